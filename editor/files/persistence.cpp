#include "editor/files/persistence.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;
constexpr double look_rest_s = 1;

void save_settings(State& state, Settings settings) {
    if (settings == state.files.settings) return;
    state.files.settings = std::move(settings);
    if (!state.files.persists) return;
    try {
        write_settings(state.files.standard_folders.config, state.files.settings);
    } catch (const std::exception& failure) {
        post_message(state, Severity::warning, fmt::format("settings cannot be saved: {}", failure.what()));
    }
}

Look look_of(const Interface& i) {
    return {i.scale, i.width_px, i.height_px, i.arrangement, i.mode, i.overlay, i.half_resolution, i.contour_m};
}

void show(const Look& look, Interface& i) {
    i.arrangement = look.arrangement;
    i.mode = look.mode;
    i.overlay = look.overlay;
    i.half_resolution = look.half_resolution;
    i.contour_m = look.contour_m;
}

// What the command line has asked for, and nobody has changed since, is of this run alone.
void save_look(State& state) {
    Files& files = state.files;
    if (!files.persists || !files.look_begun || files.look_seen == *files.look_begun) return;
    Look look = files.look_seen;
    const Look &begun = *files.look_begun, &kept = files.settings.look;
    if (look.scale == begun.scale) look.scale = kept.scale;
    if (look.width_px == begun.width_px && look.height_px == begun.height_px) {
        look.width_px = kept.width_px;
        look.height_px = kept.height_px;
    }
    if (look == kept) return;
    Settings settings = files.settings;
    settings.look = look;
    save_settings(state, std::move(settings));
}

std::vector<Difference> differences_of(const Document& document) {
    std::vector<Difference> all;
    if (document.compared() == nullptr) return all;
    const Profile &mine = document.profile(), &theirs = *document.compared();
    for (const ProfileKey* key : differing_keys(mine, theirs))
        all.push_back({key, key->get(theirs), value_text(*key, mine), value_text(*key, theirs)});
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
    settings.look = state.files.settings.look;
    settings.folder = state.files.browser.folder().empty() ? settings.folder : state.files.browser.folder();
    remember(settings.recent, path);
    state.interface.recent = settings.recent;
    save_settings(state, std::move(settings));
}

const PackMaterials* remembered_materials(const std::string& pack, const State& state) {
    std::error_code error;
    const std::string absolute = fs::absolute(pack, error).lexically_normal().string();
    for (const PackMaterials& m : state.files.settings.materials)
        if (m.pack == absolute) return &m;
    return nullptr;
}

void remember_materials(PackMaterials chosen, State& state) {
    std::error_code error;
    chosen.pack = fs::absolute(chosen.pack, error).lexically_normal().string();
    Settings settings = state.files.settings;
    std::erase_if(settings.materials, [&](const PackMaterials& m) { return m.pack == chosen.pack; });
    settings.materials.insert(settings.materials.begin(), std::move(chosen));
    if (settings.materials.size() > most_packs_with_materials) settings.materials.resize(most_packs_with_materials);
    save_settings(state, std::move(settings));
}

std::string title(const State& state) {
    std::string text = name_of(state.document.path(), "default profile");
    if (state.document.unsaved() || state.route.unsaved()) text = "* " + text;
    if (state.scene.open()) text += " - " + name_of(state.scene.path, "");
    return text + " - " + "Fjell editor";
}

void start_persistence(State& state, bool window) {
    Files& files = state.files;
    std::string problem;
    files.standard_folders = standard_folders();
    files.settings = read_settings(files.standard_folders.config, problem);
    if (!problem.empty()) post_message(state, Severity::warning, std::move(problem));
    state.interface.recent = files.settings.recent;
    if (window) show(files.settings.look, state.interface);
    files.recovery.find(files.standard_folders.state);
    files.persists = window;
    if (window) state.bookmarks.all = read_bookmarks(files.standard_folders.config, problem);
    if (window && !problem.empty()) post_message(state, Severity::warning, std::move(problem));
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
    const Look look = look_of(state.interface);
    if (!files.look_begun && look.width_px != 0) files.look_begun = files.look_seen = look;
    if (!(look == files.look_seen)) {
        files.look_seen = look;
        files.look_changed_s = state.now_s;
    } else if (state.now_s - files.look_changed_s > look_rest_s) { // not in the middle of a drag
        save_look(state);
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
    save_look(state);
}

} // namespace fjell::editor
