#include "editor/files/persistence.h"

#include <filesystem>
#include <utility>

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

void save_settings(State& state, Settings settings) {
    if (settings == state.files.settings) return;
    state.files.settings = std::move(settings);
    if (!state.files.persists) return;
    try {
        write_settings(state.files.standard_folders.config, state.files.settings);
    } catch (const std::exception& failure) {
        post_message(state, Severity::warning, std::string("recent files cannot be saved: ") + failure.what());
    }
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

void remember_pack(const std::string& path, State& state) {
    if (state.interface.dialog == Dialog::start || state.interface.dialog == Dialog::open_file)
        state.interface.dialog = Dialog::none;
    // Another editor may have written them meanwhile.
    std::string problem;
    Settings settings =
        state.files.persists ? read_settings(state.files.standard_folders.config, problem) : state.files.settings;
    if (!problem.empty()) settings = state.files.settings;
    settings.scale = state.files.settings.scale;
    settings.folder = state.files.browser.folder().empty() ? settings.folder : state.files.browser.folder();
    remember(settings.recent, path);
    state.interface.recent = settings.recent;
    save_settings(state, std::move(settings));
}

std::string title(const State& state) {
    std::string text = name_of(state.document.path(), "default profile");
    if (state.document.unsaved() || state.route.unsaved()) text = "* " + text;
    if (state.scene.open()) text += " - " + name_of(state.scene.path, "");
    return text + " - Fjell editor";
}

void start_persistence(State& state, bool window) {
    Files& files = state.files;
    std::string problem;
    files.standard_folders = standard_folders();
    files.settings = read_settings(files.standard_folders.config, problem);
    if (!problem.empty()) post_message(state, Severity::warning, std::move(problem));
    state.interface.recent = files.settings.recent;
    files.recovery.find(files.standard_folders.state);
    files.persists = window;
    if (!window) return; // a script's changes are its own affair
    files.recovery.start(files.standard_folders.state);
}

void update_file_state(State& state) {
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
        post_message(state, Severity::warning, std::move(problem));
    const double scale = state.interface.scale, seen = std::exchange(files.scale_seen, scale);
    if (seen != 0 && seen != scale) {
        Settings settings = files.settings;
        settings.scale = scale;
        save_settings(state, std::move(settings));
    }
}

void finish_persistence(State& state, bool wanted) {
    Files& files = state.files;
    if (!files.persists) return;
    if (!wanted) return files.recovery.keep_now(state.document, state.route, state.scene.path);
    files.recovery.remove();
    Settings settings = files.settings;
    if (!files.browser.folder().empty()) settings.folder = files.browser.folder();
    save_settings(state, std::move(settings));
}

} // namespace fjell::editor
