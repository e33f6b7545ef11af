// Unsaved changes: the question before they would be lost, and what an earlier run left.
#include <filesystem>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

void close_dialog(State& state) {
    state.interface.dialog = state.scene.open() ? Dialog::none : Dialog::start;
}

bool loses_profile(const Command& command) {
    return std::holds_alternative<OpenProfile>(command) || std::holds_alternative<Quit>(command);
}

bool loses_path(const Command& command) {
    return std::holds_alternative<OpenPath>(command) || std::holds_alternative<Quit>(command);
}

bool would_lose(const Command& command, const State& state) {
    return (loses_profile(command) && state.document.unsaved()) || (loses_path(command) && state.route.unsaved());
}

// At once, because the path that is restored lies over it.
void try_opening(const std::string& pack, HandlerContext context) {
    try {
        open_now(pack, context);
    } catch (const std::exception& failure) {
        post_failure(context.state, failure);
    }
}

// As a file to be opened like any other: where, or empty for none.
std::string written_path(const Unsaved& unsaved, const std::string& folder) {
    if (unsaved.points.empty()) return {};
    nlohmann::json points = nlohmann::json::array();
    for (const flight::ControlPoint& p : unsaved.points)
        points.push_back(
            {{"position", {p[0], p[1], p[2]}}, {"direction", {p[3], p[4], p[5]}}, {"up", {p[6], p[7], p[8]}}});
    nlohmann::json path = {{"comment", "Recovered."}, {"units", "metres"}, {"points", points}};
    path["seconds"] = unsaved.path_seconds;
    const std::string text = path.dump(1) + "\n";
    std::string name = folder + "/recovered-path.json";
    std::error_code ignored;
    for (int n = 2; fs::exists(name, ignored); ++n) name = fmt::format("{}/recovered-path-{}.json", folder, n);
    io::AtomicFile file(name);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    return name;
}

} // namespace

bool ask_about_unsaved(Command again, HandlerContext context) {
    State& state = context.state;
    if (!would_lose(again, state)) return false;
    state.files.waiting = std::move(again);
    state.files.saving = false;
    state.interface.dialog = Dialog::unsaved;
    return true;
}

void continue_saving(HandlerContext context) {
    State& state = context.state;
    Files& files = state.files;
    if (!files.waiting || !files.saving) return;
    if (loses_profile(*files.waiting) && state.document.unsaved()) {
        if (state.document.path().empty()) return handle(ShowDialog{Dialog::save_profile}, context);
        state.document.save("");
    }
    if (loses_path(*files.waiting) && state.route.unsaved()) {
        if (state.route.path().empty()) return handle(ShowDialog{Dialog::save_path}, context);
        state.route.save("");
    }
    const Command again = *std::exchange(files.waiting, std::nullopt);
    files.saving = false;
    close_dialog(state);
    apply(again, context);
}

void handle(const AnswerUnsaved& c, HandlerContext context) {
    Files& files = context.state.files;
    if (!files.waiting) throw io::Failure(2, "there is no question to answer");
    if (c.answer == Answer::save) {
        files.saving = true;
        return continue_saving(context);
    }
    const Command again = *std::exchange(files.waiting, std::nullopt);
    close_dialog(context.state);
    if (c.answer == Answer::discard) apply(again, context);
}

void handle(const RecoverChanges& c, HandlerContext context) {
    State& state = context.state;
    Recovery& recovery = state.files.recovery;
    if (!recovery.found()) throw io::Failure(2, "there is nothing to recover");
    if (c.restore && state.headless)
        throw io::Failure(2, "a headless run keeps nothing; recover in the editor's window");
    const Unsaved found = *recovery.found();
    if (c.restore) {
        const std::string path = written_path(found, state.files.standard_folders.state);
        if (!found.pack.empty() && !state.scene.open()) try_opening(found.pack, context);
        if (found.profile_changed) state.document.restore(found.profile, found.path);
        if (!path.empty()) {
            post_message(state, Severity::note, fmt::format("the unsaved camera path was written to {}", path));
            if (context.engine.is_open()) apply(OpenPath{path, true}, context);
        }
        recovery.keep_now(state.document, state.route, state.scene.path); // before the other one goes
    }
    recovery.drop_found();
    close_dialog(state);
    if (recovery.found()) state.interface.dialog = Dialog::recover;
}

void handle(const Quit& c, HandlerContext context) {
    if (!c.discard) end_recording(context);
    if (!c.discard && ask_about_unsaved(Quit{true}, context)) return;
    context.state.quit = true;
}

} // namespace fjell::editor
