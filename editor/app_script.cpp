// What an editor does before and beside its hands: heights given on the command line, and scripts.
#include <iostream>
#include <iterator>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "editor/app.h"
#include "editor/files/listing.h"
#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

using io::Failure;

void App::read_script() {
    const auto add = [&](const std::string& line, const std::string& where) {
        try {
            if (auto command = parse_command(line)) script_.push_back({std::move(command), {}});
        } catch (const Failure& failure) {
            script_.push_back({{}, where + ": " + failure.what()});
        }
    };
    for (const std::string& line : options_.commands) add(line, "--do");
    if (options_.script.empty()) return;
    std::string text;
    if (options_.script == "-")
        text.assign(std::istreambuf_iterator<char>(std::cin), {});
    else
        text = io::read_text(options_.script);
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) add(line, options_.script + ":" + std::to_string(++number));
}

// A window asks how heights are to be baked; without one they are baked as that dialog would begin.
void App::open_input() {
    const HandlerContext context{state_, engine_, jobs_};
    const std::string& input = options_.pack;
    attempt([&] {
        if (!options_.headless || file_kind_of(input) != FileKind::heights)
            return apply(OpenFile{input, true}, context);
        bake_beside(input, context);
        baking_input_ = true;
    });
}

void App::show_baking() {
    if (!jobs_.running()) {
        baking_input_ = false;
        state_.frame = 0; // --frames counts from here
        return;
    }
    if (state_.now_s - baking_shown_s_ < 1) return;
    baking_shown_s_ = state_.now_s;
    fmt::print(stderr, "fjell-editor: baking {}: {} {:.0f}%\n", options_.pack, state_.job.stage,
               100 * state_.job.share);
}

bool App::settled() const {
    if (jobs_.running()) return false;
    if (!engine_.is_open()) return true;
    if (!comparison_.settled()) return false;
    if (state_.shows(Overlay::error) && state_.heights_share >= 0 && state_.heights_share < 1) return false;
    if (state_.probe.looking) return false;
    const flight::FrameEntry& e = state_.measures.last();
    const StreamReport& r = e.stream;
    // Slots may not suffice for what is wanted, and damaged pages never come: then all is there that will be.
    const bool resting = r.in_flight == 0 && r.pages_left == 0 && r.mips_left == 0 && r.pages_inserted == 0 &&
                         r.mips_uploaded == 0 && r.pages_evicting == 0 && e.activations == 0 && e.deactivations == 0;
    const bool streamed = !e.streamed || (r.converged && r.maps_converged) || resting;
    return state_.measures.frames() > 1 && e.waiting == e.blocked && e.morphing == 0 && streamed;
}

// Carries on with the script where nothing waits. False: a headless run is over.
bool App::run_script() {
    if (baking_input_ || engine_.opening() || rehearsals_ != 0) return true;
    if (state_.frame == 0) return true; // how large the picture is, is known after a frame
    const HandlerContext context{state_, engine_, jobs_};
    while (script_at_ < script_.size()) {
        if (state_.frame < wait_until_frame_) return true;
        if (waiting_settled_) {
            if (!settled() || !overview_.done()) return true;
            waiting_settled_ = false;
        }
        const ScriptLine& line = script_[script_at_++];
        if (!line.command) {
            post_failure(state_, Failure(2, line.problem));
            continue;
        }
        const Command& command = *line.command;
        if (const auto* wait = std::get_if<WaitFrames>(&command)) {
            wait_until_frame_ = state_.frame + wait->frames;
        } else if (std::holds_alternative<WaitSettled>(command)) {
            waiting_settled_ = true;
            wait_until_frame_ = state_.frame + 2; // what was just asked for shows in the frames that follow
        } else if (std::holds_alternative<TakeScreenshot>(command) || std::holds_alternative<DumpState>(command)) {
            after_frame_.push_back(command);
            wait_until_frame_ = state_.frame + 2; // drawn with what came before it
        } else if (const auto* size = std::get_if<ResizeWindow>(&command)) {
            surface_->resize(size->width, size->height);
            wait_until_frame_ = state_.frame + 3;
        } else if (std::holds_alternative<LoseGraphics>(command)) {
            replace_surface();
        } else {
            const bool ran = jobs_.running();
            apply(command, context);
            note(command);
            if (engine_.opening() || rehearsals_ != 0) return true;
            // Heights that a script opens are baked first; what follows is about the terrain.
            if (std::holds_alternative<OpenFile>(command) && options_.headless && !ran && jobs_.running()) {
                waiting_settled_ = true;
                wait_until_frame_ = state_.frame + 2;
            }
        }
    }
    const bool waiting = state_.frame < wait_until_frame_ || (waiting_settled_ && !settled());
    return waiting || !options_.headless || options_.frames != 0;
}

} // namespace fjell::editor
