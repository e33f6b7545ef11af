// Opening files and packs, and what file dialogs list.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "editor/files/listing.h"
#include "editor/files/persistence.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/work.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

constexpr char landscape[] = {
#include "mountains-small.inc"
};

} // namespace

std::string_view sample_landscape() {
    return {landscape, std::size(landscape)};
}

std::string sample_pack(const std::string& cache_folder) {
    return cache_folder + "/sample.fjell";
}

BakePack bake_sample(const std::string& cache_folder) {
    if (cache_folder.empty()) throw io::Failure(3, "there is no folder for the sample; set XDG_CACHE_HOME or HOME");
    std::error_code ignored; // what is wrong with the folder, the file says
    std::filesystem::create_directories(cache_folder, ignored);
    BakePack bake;
    bake.inputs = {cache_folder + "/sample.json"};
    bake.output = sample_pack(cache_folder);
    io::AtomicFile file(bake.inputs[0]);
    file.write(std::as_bytes(std::span(sample_landscape())));
    file.commit();
    return bake;
}

void handle(const BrowseFor& c, HandlerContext context) {
    Files& files = context.state.files;
    std::string folder = files.browser.folder();
    if (folder.empty()) folder = files.settings.folder.empty() ? "." : files.settings.folder;
    std::error_code ignored;
    if (!c.beside.empty())
        if (const fs::path above = fs::absolute(c.beside, ignored).parent_path(); fs::is_directory(above, ignored))
            folder = above.string();
    files.browser.filter(c.filter, false);
    files.browser.look(folder);
}

// --- Materials.

namespace {

Engine::Layers read_materials(const ChooseMaterials& c, const State& state) {
    if (c.materials.empty()) return {};
    const std::string& cache = state.files.standard_folders.cache;
    const std::string file = c.materials == built_in_materials ? built_in_file(cache) : c.materials;
    return std::make_shared<const session::GroundLayers>(session::read_ground_layers(file, rules_file(cache, c.rules)));
}

// Those that were chosen for a pack that is about to be opened.
void recall_materials(const std::string& pack, HandlerContext context) {
    State& state = context.state;
    if (state.materials.of_this_run) return;
    context.engine.set_layers({});
    const PackMaterials* const chosen = remembered_materials(pack, state);
    if (chosen == nullptr) return;
    try {
        context.engine.set_layers(read_materials({chosen->materials, chosen->rules}, state));
    } catch (const std::exception& failure) {
        post_message(state, Severity::warning, fmt::format("without its materials: {}", failure.what()));
    }
}

void warn_of_missing_materials(State& state) {
    if (state.scene.splat && !state.scene.materials)
        post_message(state, Severity::warning,
                     "this pack says which materials lie where, but none are loaded: choose them in Light > Materials");
}

} // namespace

void handle(const ChooseMaterials& c, HandlerContext context) {
    State& state = context.state;
    (void)open_engine(context);
    const std::string& cache = state.files.standard_folders.cache;
    std::error_code ignored;
    if (c.materials == built_in_materials && !fs::exists(built_in_file(cache), ignored)) {
        write_built_in(cache);
        context.jobs.start(JobKind::materials, materials_job(built_in_recipes(cache), built_in_file(cache)));
        state.materials.baking = c;
        return;
    }
    const Engine::Layers before = context.engine.layers();
    context.engine.set_layers(read_materials(c, state));
    try {
        context.engine.reopen(state.document.profile());
    } catch (...) {
        context.engine.set_layers(before);
        throw;
    }
    state.scene = context.engine.scene();
    state.materials = {c.materials, c.rules, false, {}, {}};
    remember_materials({state.scene.path, c.materials, c.rules}, state);
    if (!c.materials.empty()) handle(SetKey{find_profile_key("layers.on"), 1, false}, context);
}

void handle(const OpenFile& c, HandlerContext context) {
    State& state = context.state;
    const FileKind kind = file_kind_of(c.path);
    switch (kind) {
    case FileKind::pack:
        // A frame that waits is seen in a window that shows something already.
        if (!state.headless && state.frame != 0) {
            recall_materials(c.path, context);
            context.engine.begin_opening(c.path, state);
            state.opening = c.path;
            return;
        }
        return open_now(c.path, context);
    case FileKind::profile: return handle(OpenProfile{c.path, c.discard}, context);
    case FileKind::path:
        if (!context.engine.is_open())
            throw io::Failure(2, fmt::format("{}: this is a camera path; open a terrain for it first", c.path));
        return handle(OpenPath{c.path, c.discard}, context);
    case FileKind::materials:
    case FileKind::rules:
        if (state.interface.dialog == Dialog::open_file) state.interface.dialog = Dialog::none;
        if (kind == FileKind::materials) return handle(ChooseMaterials{c.path, state.materials.rules}, context);
        return handle(
            ChooseMaterials{state.materials.materials.empty() ? built_in_materials : state.materials.materials, c.path},
            context);
    case FileKind::heights:
        if (state.headless) return bake_beside(c.path, context); // nobody is there to fill in a dialog
        return handle(GiveBakeFile{c.path, BakeField::none, state.interface.dialog == Dialog::bake}, context);
    }
}

void open_now(const std::string& pack, HandlerContext context) {
    recall_materials(pack, context);
    context.engine.open(pack, context.state.document.profile());
    show_opened(pack, context);
}

void show_opened(const std::string& pack, HandlerContext context) {
    context.state.document.accept();
    start_at_scene(context);
    remember_pack(pack, context.state);
    State& state = context.state;
    if (!state.materials.of_this_run) {
        state.materials = {};
        const PackMaterials* const chosen = remembered_materials(pack, state);
        if (chosen != nullptr && context.engine.layers()) {
            state.materials.materials = chosen->materials;
            state.materials.rules = chosen->rules;
        }
    }
    warn_of_missing_materials(state);
    std::error_code unknown;
    std::string absolute = fs::absolute(pack, unknown).lexically_normal().string();
    if (absolute == state.bookmarks.pack) return;
    state.bookmarks.pack = std::move(absolute);
    state.runs = {}; // of another terrain
    state.compared = {};
}

void bake_beside(const std::string& heights, HandlerContext context) {
    BakePack bake;
    bake.inputs = {heights};
    bake.output = pack_beside(heights);
    std::error_code ignored;
    if (fs::exists(bake.output, ignored))
        throw io::Failure(
            2, fmt::format("{}: exists already; open that pack, or bake elsewhere: --do \"bake {} OTHER.fjell\"",
                           bake.output, heights));
    handle(bake, context);
}

void handle(const OpenSample&, HandlerContext context) {
    const std::string& folder = context.state.files.standard_folders.cache;
    const std::string pack = sample_pack(folder);
    std::error_code ignored;
    if (fs::exists(pack, ignored)) {
        try {
            return handle(OpenFile{pack, true}, context);
        } catch (const io::Failure& failure) { // of another version, or damaged: it is recreated
            post_message(context.state, Severity::note, fmt::format("the sample is baked again: {}", failure.what()));
        }
    }
    handle(bake_sample(folder), context);
}

// --- What the dialog that bakes holds, and what becomes of the pack.

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
    fresh.splat = d.pack.splat;
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

// --- Unsaved changes: the question before they would be lost, and what an earlier run left.

namespace {

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
    for (const session::ControlPoint& p : unsaved.points)
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
