// What the dialog that bakes holds, and what becomes of the pack.
#include <algorithm>
#include <filesystem>
#include <utility>

#include <unistd.h>

#include <fmt/format.h>

#include "editor/files/file_kind.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/factories.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

bool may_write(const std::filesystem::path& folder) {
    return access(folder.empty() ? "." : folder.c_str(), W_OK) == 0;
}

// Beside the heights or, where nothing may be written, in the home folder.
std::string proposed_output(const BakeDraft& draft, const State& state) {
    if (draft.pack.inputs.empty() || draft.pack.inputs.front().empty()) return {};
    const std::filesystem::path beside = pack_beside(draft.pack.inputs.front());
    const std::string& home = state.files.standard_folders.home;
    if (may_write(beside.parent_path()) || home.empty()) return beside.string();
    return (std::filesystem::path(home) / beside.filename()).string();
}

void judge_output(State& state) {
    BakeDraft& d = state.bake;
    if (!d.output_is_chosen) d.pack.output = proposed_output(d, state);
    d.output_problem.clear();
    std::error_code ignored;
    const std::filesystem::path output = d.pack.output;
    d.output_exists = !output.empty() && std::filesystem::exists(output, ignored);
    if (output.empty()) return;
    const std::filesystem::path folder = std::filesystem::absolute(output, ignored).parent_path();
    if (std::filesystem::is_directory(output, ignored))
        d.output_problem = "the pack's name is that of a folder; give a name in it";
    else if (!std::filesystem::is_directory(folder, ignored))
        d.output_problem = fmt::format("{} does not exist; choose another folder for the pack", folder.string());
    else if (!may_write(folder))
        d.output_problem =
            fmt::format("nothing may be written to {}; choose another folder for the pack", folder.string());
}

void give(BakeDraft& d, const GiveBakeFile& c) {
    std::vector<std::string>& inputs = d.pack.inputs;
    switch (c.field) {
    case BakeField::texture: d.pack.texture = c.path; return;
    case BakeField::ramp: d.pack.ramp = c.path; return;
    case BakeField::rules: d.pack.rules = c.path; return;
    case BakeField::output:
        d.pack.output = c.path.ends_with(".fjell") ? c.path : c.path + ".fjell";
        d.output_is_chosen = true;
        return;
    default: break;
    }
    if (c.another && !inputs.empty() && !inputs.front().empty()) {
        if (std::ranges::find(inputs, c.path) == inputs.end()) inputs.push_back(c.path);
        return;
    }
    // Other heights are another bake: what was given for the ones before need not suit them.
    BakePack fresh;
    fresh.inputs = {c.path};
    fresh.ramp = d.pack.ramp;
    fresh.rules = d.pack.rules;
    fresh.control = d.pack.control;
    fresh.horizons = d.pack.horizons;
    d.pack = std::move(fresh);
    d.output_is_chosen = false;
}

} // namespace

void handle(const DraftBake& c, HandlerContext context) {
    BakeDraft& d = context.state.bake;
    d.pack = c.pack;
    d.output_is_chosen = c.output_is_chosen;
    ++d.version;
    judge_output(context.state);
}

void handle(const GiveBakeFile& c, HandlerContext context) {
    State& state = context.state;
    GiveBakeFile given = c;
    if (given.field == BakeField::none) given.field = bake_field_of(c.path, state.bake.pack.inputs.empty());
    give(state.bake, given);
    ++state.bake.given;
    ++state.bake.version;
    judge_output(state);
    if (state.interface.dialog != Dialog::bake) handle(ShowDialog{Dialog::bake}, context);
}

void handle(const BakePack& c, HandlerContext context) {
    // Over the pack that is open it may go: that is replaced whole, and opened again.
    State& state = context.state;
    refuse_overwriting_open_files(state, c.output.empty() && !c.inputs.empty() ? pack_beside(c.inputs[0]) : c.output,
                                  state.scene.path);
    context.jobs.start(JobKind::bake, bake_job(c));
    state.bake.asks = c.asks;
}

void take_baked(const std::string& pack, HandlerContext context) {
    State& state = context.state;
    Dialog& dialog = state.interface.dialog;
    if (dialog == Dialog::bake) dialog = Dialog::none;
    const bool asks = std::exchange(state.bake.asks, false);
    // What is being opened is as good as flown.
    if (state.opening.empty() && (!asks || !state.scene.open())) return apply(OpenFile{pack}, context);
    state.bake.ready = pack;
    if (dialog == Dialog::none) dialog = Dialog::baked;
}

void handle(const OpenBaked& c, HandlerContext context) {
    State& state = context.state;
    const std::string pack = std::exchange(state.bake.ready, {});
    if (state.interface.dialog == Dialog::baked) state.interface.dialog = Dialog::none;
    if (pack.empty()) throw io::Failure(2, "no pack is waiting to be opened");
    if (c.open) handle(OpenFile{pack}, context);
}

} // namespace fjell::editor
