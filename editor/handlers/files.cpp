#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "editor/handlers/handlers.h"
#include "editor/sample.h"
#include "io/failure.h"
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

void write_anew(State& state, Settings settings) {
    if (settings == state.files.settings) return;
    state.files.settings = std::move(settings);
    if (!state.files.keeps) return;
    try {
        write_settings(state.files.places.config, state.files.settings);
    } catch (const std::exception& failure) {
        tell(state, Severity::warning, std::string("recent files will be forgotten: ") + failure.what());
    }
}

// As a file to be opened like any other: where, or empty for none.
std::string written_path(const Unsaved& unsaved, const std::string& folder) {
    if (unsaved.points.empty()) return {};
    nlohmann::json points = nlohmann::json::array();
    for (const flight::ControlPoint& p : unsaved.points)
        points.push_back(
            {{"position", {p[0], p[1], p[2]}}, {"direction", {p[3], p[4], p[5]}}, {"up", {p[6], p[7], p[8]}}});
    const nlohmann::json path = {
        {"comment", "Recovered."}, {"units", "metres"}, {"seconds", unsaved.path_seconds}, {"points", points}};
    const std::string text = path.dump(1) + "\n";
    std::string name = folder + "/recovered-path.json";
    std::error_code ignored;
    for (int n = 2; fs::exists(name, ignored); ++n) name = fmt::format("{}/recovered-path-{}.json", folder, n);
    io::AtomicFile file(name);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    return name;
}

std::vector<Difference> differences_of(const Document& document) {
    std::vector<Difference> all;
    if (document.compared() == nullptr) return all;
    const flight::Profile &mine = document.profile(), &theirs = *document.compared();
    for (const flight::ProfileKey* key : flight::differing_keys(mine, theirs))
        all.push_back({key, key->get(theirs), flight::value_text(*key, mine), flight::value_text(*key, theirs)});
    return all;
}

std::string name_of(const std::string& path, const char* otherwise) {
    return path.empty() ? otherwise : fs::path(path).filename().string();
}

} // namespace

bool asks_first(Command again, Desk desk) {
    State& state = desk.state;
    if (!would_lose(again, state)) return false;
    state.files.waiting = std::move(again);
    state.files.saving = false;
    state.interface.dialog = Dialog::unsaved;
    return true;
}

void go_on_saving(Desk desk) {
    State& state = desk.state;
    Files& files = state.files;
    if (!files.waiting || !files.saving) return;
    if (loses_profile(*files.waiting) && state.document.unsaved()) {
        if (state.document.path().empty()) return carry_out(ShowDialog{Dialog::save_profile}, desk);
        state.document.save("");
    }
    if (loses_path(*files.waiting) && state.route.unsaved()) {
        if (state.route.path().empty()) return carry_out(ShowDialog{Dialog::save_path}, desk);
        state.route.save("");
    }
    const Command again = *std::exchange(files.waiting, std::nullopt);
    files.saving = false;
    close_dialog(state);
    apply(again, desk);
}

void carry_out(const GoOn& c, Desk desk) {
    Files& files = desk.state.files;
    if (!files.waiting) throw io::Failure(2, "nothing waits for an answer");
    if (c.answer == Answer::save) {
        files.saving = true;
        return go_on_saving(desk);
    }
    const Command again = *std::exchange(files.waiting, std::nullopt);
    close_dialog(desk.state);
    if (c.answer == Answer::discard) apply(again, desk);
}

void dialog_opens(Dialog dialog, State& state) {
    Files& files = state.files;
    if (dialog != Dialog::unsaved && dialog != Dialog::save_profile && dialog != Dialog::save_path) {
        files.waiting.reset();
        files.saving = false;
    }
    if (!browses(dialog)) return;
    std::string folder = files.browser.folder();
    if (folder.empty()) folder = files.settings.folder.empty() ? "." : files.settings.folder;
    const std::string& own = dialog == Dialog::save_path ? state.route.path() : state.document.path();
    if (dialog != Dialog::open_file && !own.empty()) folder = fs::absolute(own).parent_path().string();
    files.browser.filter(dialog, false);
    files.browser.look(folder);
}

void carry_out(const Browse& c, Desk desk) {
    Files& files = desk.state.files;
    files.browser.look(c.folder);
}

void carry_out(const BrowseAll& c, Desk desk) {
    desk.state.files.browser.filter(desk.state.interface.dialog, c.on);
}

void carry_out(const Open& c, Desk desk) {
    State& state = desk.state;
    switch (kind_of(c.path)) {
    case FileKind::pack:
        desk.engine.open(c.path, state.document.profile());
        state.document.accept();
        look_at_scene(desk);
        return opened_pack(c.path, state);
    case FileKind::profile: return carry_out(OpenProfile{c.path, c.discard}, desk);
    case FileKind::path:
        if (!desk.engine.is_open())
            throw io::Failure(2, fmt::format("{}: a camera path; open a terrain for it first", c.path));
        return carry_out(OpenPath{c.path, c.discard}, desk);
    case FileKind::heights: state.bake_input = c.path; return carry_out(ShowDialog{Dialog::bake}, desk);
    }
}

void carry_out(const OpenSample&, Desk desk) {
    const std::string& folder = desk.state.files.places.cache;
    const std::string pack = sample_pack(folder);
    std::error_code ignored;
    if (fs::exists(pack, ignored)) {
        try {
            return carry_out(Open{pack, true}, desk);
        } catch (const io::Failure& failure) { // of another version, or damaged: it is made anew
            tell(desk.state, Severity::note, std::string("the sample is made anew: ") + failure.what());
        }
    }
    carry_out(bake_sample(folder), desk);
}

void opened_pack(const std::string& path, State& state) {
    if (state.interface.dialog == Dialog::start || state.interface.dialog == Dialog::open_file)
        state.interface.dialog = Dialog::none;
    // Another editor may have written them meanwhile.
    std::string problem;
    Settings settings = state.files.keeps ? read_settings(state.files.places.config, problem) : state.files.settings;
    if (!problem.empty()) settings = state.files.settings;
    settings.scale = state.files.settings.scale;
    settings.folder = state.files.browser.folder().empty() ? settings.folder : state.files.browser.folder();
    remember(settings.recent, path);
    state.interface.recent = settings.recent;
    write_anew(state, std::move(settings));
}

void carry_out(const Recover& c, Desk desk) {
    State& state = desk.state;
    Recovery& recovery = state.files.recovery;
    if (!recovery.found()) throw io::Failure(2, "there is nothing to recover");
    if (c.restore && state.headless)
        throw io::Failure(2, "a run without a window keeps nothing: recover in the editor's window");
    const Unsaved found = *recovery.found();
    if (c.restore) {
        const std::string path = written_path(found, state.files.places.state);
        if (!found.pack.empty() && !state.scene.open()) apply(Open{found.pack, true}, desk);
        if (found.profile_changed) state.document.restore(found.profile, found.path);
        if (!path.empty()) {
            tell(state, Severity::note, "the camera path that was not saved is now " + path);
            if (desk.engine.is_open()) apply(OpenPath{path, true}, desk);
        }
        recovery.keep_now(state.document, state.route, state.scene.path); // before the other one goes
    }
    recovery.forget();
    close_dialog(state);
    if (recovery.found()) state.interface.dialog = Dialog::recover;
}

std::string title(const State& state) {
    std::string text = name_of(state.document.path(), "default profile");
    if (state.document.unsaved() || state.route.unsaved()) text = "* " + text;
    if (state.scene.open()) text += " - " + name_of(state.scene.path, "");
    return text + " - Fjell editor";
}

void begin_keeping(State& state, bool window) {
    Files& files = state.files;
    std::string problem;
    files.places = places();
    files.settings = read_settings(files.places.config, problem);
    if (!problem.empty()) tell(state, Severity::warning, std::move(problem));
    state.interface.recent = files.settings.recent;
    files.recovery.look(files.places.state);
    files.keeps = window;
    if (!window) return; // a script's changes are its own affair
    files.recovery.begin(files.places.state);
}

void keep_up(State& state) {
    Files& files = state.files;
    const Document& document = state.document;
    if (files.version != document.version() || files.path_unsaved != state.route.unsaved() ||
        files.pack != state.scene.path) {
        files.version = document.version();
        files.path_unsaved = state.route.unsaved();
        files.pack = state.scene.path;
        files.profile_name = (document.unsaved() ? "* " : "") + name_of(document.path(), "default profile");
        files.title = title(state);
        files.differences = differences_of(document);
    }
    files.recovery.keep(document, state.route, state.scene.path, state.now_s);
    if (std::string problem = files.recovery.take_problem(); !problem.empty())
        tell(state, Severity::warning, std::move(problem));
    const double scale = state.interface.scale, seen = std::exchange(files.scale_seen, scale);
    if (seen != 0 && seen != scale) {
        Settings settings = files.settings;
        settings.scale = scale;
        write_anew(state, std::move(settings));
    }
}

void end_keeping(State& state, bool wanted) {
    Files& files = state.files;
    if (!files.keeps) return;
    if (!wanted) return files.recovery.keep_now(state.document, state.route, state.scene.path);
    files.recovery.remove();
    Settings settings = files.settings;
    if (!files.browser.folder().empty()) settings.folder = files.browser.folder();
    write_anew(state, std::move(settings));
}

} // namespace fjell::editor
