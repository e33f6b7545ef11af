// What is shown: picture mode, overlays, panels, dialogs and messages.
#include <algorithm>
#include <array>
#include <exception>
#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

void prepare_dialog(Dialog dialog, State& state) {
    Files& files = state.files;
    if (dialog != Dialog::unsaved && dialog != Dialog::save_profile && dialog != Dialog::save_path) {
        files.waiting.reset();
        files.saving = false;
    }
    if (!shows_files(dialog)) return;
    std::string folder = files.browser.folder();
    if (folder.empty()) folder = files.settings.folder.empty() ? "." : files.settings.folder;
    const std::string& own = dialog == Dialog::save_path ? state.route.path() : state.document.path();
    if (dialog != Dialog::open_file && !own.empty()) folder = std::filesystem::absolute(own).parent_path().string();
    // The heights' folder, where the last file was, hardly has profiles; where the editor was started there may be
    // some.
    std::error_code none;
    if (filter_of(dialog) == FileFilter::profiles && own.empty() && std::filesystem::is_directory("profiles", none))
        folder = std::filesystem::absolute("profiles").string();
    files.browser.filter(filter_of(dialog), false);
    files.browser.look(folder);
}

// Where no hand has put it yet: over the picture, each a title's height below and beside the one before.
void place_first(FloatingPanel& f, const Interface& i) {
    const auto others = std::ranges::count_if(i.arrangement.floating, [](const FloatingPanel& p) { return p.on; });
    const auto scale = static_cast<float>(i.scale), step = 14 + 28 * static_cast<float>(others);
    f.x_px = static_cast<float>(i.view_x_px) / scale + step;
    f.y_px = static_cast<float>(i.view_y_px) / scale + step;
}

} // namespace

void handle(const ShowPanel& c, HandlerContext context) {
    Arrangement& a = context.state.interface.arrangement;
    a.turn_to(c.panel);
    a.panels = true; // it was asked for: it is seen
    context.state.interface.picture_only = false;
    for (bool& folded : a.folded) folded = false;
}

void handle(const ShowGroup& c, HandlerContext context) {
    const auto group = static_cast<std::size_t>(c.group);
    context.state.interface.arrangement.open[group] = c.on;
    if (c.on) handle(ShowPanel{group_names[group].panel}, context);
}

void handle(const SetSwitch& c, HandlerContext context) {
    Interface& i = context.state.interface;
    switch (c.which) {
    case Switch::show_panels: i.arrangement.panels = c.on; break;
    case Switch::picture_only: i.picture_only = c.on; break;
    case Switch::panel_keys: i.panel_keys = c.on; break;
    case Switch::half_resolution: i.half_resolution = c.on; break;
    case Switch::probe: context.state.probe.on = c.on; break;
    }
    if (!c.on && c.which == Switch::show_panels) i.panel_keys = false; // nobody would see where they go
    if (c.on && c.which == Switch::picture_only) i.panel_keys = false;
    if (c.on && c.which == Switch::show_panels) i.picture_only = false;
    if (c.on && c.which == Switch::panel_keys) {
        i.arrangement.panels = true;
        i.picture_only = false;
    }
}

void handle(const ArrangeColumn& c, HandlerContext context) {
    Arrangement& a = context.state.interface.arrangement;
    const auto column = static_cast<std::size_t>(c.column);
    const auto value = static_cast<float>(c.value);
    switch (c.part) {
    case ColumnPart::width: a.width_px[column] = std::clamp(value, least_column_px, most_column_px); break;
    case ColumnPart::split: a.split[column] = std::clamp(value, least_split, most_split); break;
    case ColumnPart::folded: a.folded[column] = c.value != 0; break;
    }
}

void handle(const FloatPanel& c, HandlerContext context) {
    Arrangement& a = context.state.interface.arrangement;
    FloatingPanel& f = a.floating[static_cast<std::size_t>(c.panel)];
    if (c.at_px) {
        f.x_px = static_cast<float>((*c.at_px)[0]);
        f.y_px = static_cast<float>((*c.at_px)[1]);
    } else if (c.on && !f.on && f.x_px == 0 && f.y_px == 0) {
        place_first(f, context.state.interface);
    }
    f.on = c.on;
    handle(ShowPanel{c.panel}, context);
}

void handle(const PlacePanel& c, HandlerContext context) {
    FloatingPanel& f = context.state.interface.arrangement.floating[static_cast<std::size_t>(c.panel)];
    f.x_px = std::clamp(static_cast<float>(c.x_px), -most_floating_px, most_floating_px);
    f.y_px = std::clamp(static_cast<float>(c.y_px), 0.0F, most_floating_px);
    f.width_px = std::clamp(static_cast<float>(c.width_px), least_floating_px, most_floating_px);
    f.height_px = std::clamp(static_cast<float>(c.height_px), least_floating_px, most_floating_px);
}

void handle(const ShowDialog& c, HandlerContext context) {
    State& state = context.state;
    prepare_dialog(c.dialog, state);
    // A pack that is ready asks once nothing else does.
    if (c.dialog == Dialog::none && !state.bake.ready.empty() && state.interface.dialog != Dialog::baked) {
        state.interface.dialog = Dialog::baked;
        return;
    }
    if (state.interface.dialog == Dialog::baked) state.bake.ready.clear();
    const bool leaves_nothing = c.dialog == Dialog::none && !state.scene.open();
    state.interface.dialog = leaves_nothing && state.interface.dialog != Dialog::start ? Dialog::start : c.dialog;
}

void handle(const ChooseFrame& c, HandlerContext context) {
    State& state = context.state;
    if (!c.on) return state.chosen.reset();
    if (c.ago >= state.measures.ring(Series::frame_us).size())
        throw io::Failure(2, "not so many frames have been measured yet; fly on");
    state.chosen = state.measures.frame(c.ago);
}

void handle(const ZoomGraphs& c, HandlerContext context) {
    State& state = context.state;
    std::size_t oldest = std::min(std::max(c.oldest, c.newest), measured_frames - 1);
    std::size_t newest = std::min(c.oldest, c.newest);
    // So narrow that lines would be all there is: wider, to both sides.
    if (oldest - newest + 1 < least_graph_span) {
        oldest = std::clamp(oldest + least_graph_span / 2, least_graph_span - 1, measured_frames - 1);
        newest = oldest - (least_graph_span - 1);
    }
    state.graphs = {oldest, newest};
    if (!state.graphs.whole()) state.measures.hold(true);
}

// --- The profile.

void handle(const SetKey& c, HandlerContext context) {
    Document& document = context.state.document;
    document.set(*c.key, c.value, c.dragging);
    if (c.dragging || (c.value >= c.key->least && c.value <= c.key->most)) return;
    post_message(
        context.state, Severity::warning,
        fmt::format("{}: {}; set to {}", c.key->label, key_refusal(*c.key), value_text(*c.key, document.profile())));
}

void handle(const Undo&, HandlerContext context) {
    State& state = context.state;
    if (state.ground.undo_stamp > std::max(state.route.undo_stamp(), state.document.undo_stamp()))
        return context.engine.digging().undo();
    state.route.undo_stamp() > state.document.undo_stamp() ? undo_path(context) : state.document.undo();
}

void handle(const Redo&, HandlerContext context) {
    State& state = context.state;
    const std::uint64_t of_path = state.route.redo_stamp(), of_profile = state.document.redo_stamp();
    const std::uint64_t of_ground = state.ground.redo_stamp;
    if (of_ground != 0 && (of_path == 0 || of_ground < of_path) && (of_profile == 0 || of_ground < of_profile))
        return context.engine.digging().redo();
    const bool path = of_path != 0 && (of_profile == 0 || of_path < of_profile);
    path ? redo_path(context) : state.document.redo();
}

void handle(const OpenProfile& c, HandlerContext context) {
    if (!c.discard && ask_about_unsaved(OpenProfile{c.path, true}, context)) return;
    State& state = context.state;
    std::vector<std::string> renamed = state.document.open(c.path);
    if (state.interface.dialog == Dialog::open_file) state.interface.dialog = Dialog::none;
    post_message(state, Severity::note, fmt::format("opened {}", c.path));
    for (std::string& line : renamed) post_message(state, Severity::warning, std::move(line));
}

void handle(const SaveProfile& c, HandlerContext context) {
    State& state = context.state;
    refuse_overwriting_open_files(state, c.path, state.document.path());
    state.document.save(c.path);
    if (state.interface.dialog == Dialog::save_profile) state.interface.dialog = Dialog::none;
    post_message(state, Severity::note, fmt::format("saved {}", state.document.path()));
    continue_saving(context);
}

// --- Every command.

namespace {

template <typename... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <typename... F>
Overloaded(F...) -> Overloaded<F...>; // clang 14 does not find it out

// What takes a line is done here; all else has a handler.
void dispatch(const Command& command, HandlerContext context) {
    State& state = context.state;
    Interface& i = state.interface;
    Route& route = state.route;
    const auto ground = [&] { return path_ground(context); };
    std::visit(
        Overloaded{
            [&](const ResetProfile&) { state.document.replace({}); },
            [&](const SetLight& c) { state.document.replace(with_light(state.document.profile(), c.preset)); },
            [&](const CompareProfile& c) {
                for (std::string& line : state.document.compare(c.path))
                    post_message(state, Severity::warning, std::move(line));
            },
            [&](const StopComparing&) { state.document.stop_comparing(); },
            [&](const BrowseFolder& c) { state.files.browser.look(c.folder); },
            [&](const BrowseAllKinds& c) { state.files.browser.filter(state.files.browser.kinds(), c.on); },
            [&](const AddPoint&) { route.add(state.eye.pose(), ground()); },
            [&](const ReplacePoint& c) { route.replace(c.point, state.eye.pose(), ground()); },
            [&](const MovePoint& c) { route.move(c.point, c.to, ground()); },
            [&](const SetPathSeconds& c) { route.set_seconds(c.seconds, ground()); },
            [&](const LoopPath& c) { route.loop(c.on); },
            [&](const RemovePoint& c) { route.remove(c.point, ground()), follow_path(state); },
            [&](const InsertPoint& c) { route.insert(c.share.value_or(route.share()), ground()), follow_path(state); },
            [&](const PlacePoint& c) {
                route.place(c.point, c.x_m, c.z_m, c.dragging, ground(), c.y_m);
                follow_path(state);
            },
            [&](const RestorePath&) { route.restore(), follow_path(state); },
            [&](const PointProbe& c) {
                state.probe.pointer = std::array{c.x, c.y};
            },
            [&](const MarkPlace& c) { set_mark(state.probe, open_engine(context).session(), c.x_m, c.z_m); },
            [&](const SetBrush& c) { state.ground.brush = c.brush; },
            [&](const AddEditLayer& c) { digging(context).add_layer(c.name); },
            [&](const ChooseEditLayer& c) { digging(context).choose(c.place); },
            [&](const SetEditLayer& c) { digging(context).set_layer(c.place, c.on, c.strength, c.to); },
            [&](const RemoveEditLayer& c) { digging(context).remove_layer(c.place); },
            [&](const RemoveMark&) { remove_mark(state.probe, open_engine(context).session()); },
            [&](const ClearMarks&) { state.probe.marks = 0; }, [&](const SetPictureMode& c) { i.mode = c.mode; },
            [&](const SetOverlay& c) { i.overlay[static_cast<std::size_t>(c.overlay)] = c.on; },
            [&](const SetContours& c) { i.contour_m = c.every_m; },
            [&](const SetScale& c) { i.scale = std::clamp(c.scale, 0.5, 4.0); },
            [&](const HoldMeasures& c) {
                state.measures.hold(c.on);
                if (!c.on) state.graphs = {};
            },
            [&](const DismissMessage&) { state.messages.shown_until_s = 0; },
            [&](const CancelJob&) { context.jobs.cancel(); }, [&](const ForgetRun& c) { state.runs.forget(c.run); },
            [&](const SetHeat& c) { state.runs.heat = c.heat; },
            [&](const SetCompareView& c) { state.compared.view = c.view; },
            [&](const SetDivider& c) { state.compared.divider = std::clamp(c.share, 0.0, 1.0); },
            // The app's, of the surface and of scripts (editor/app.h).
            [](const TakeScreenshot&) {}, [](const ResizeWindow&) {}, [](const DumpState&) {},
            [](const LoseGraphics&) {}, [](const WaitFrames&) {}, [](const WaitSettled&) {},
            [&](const auto& c) { handle(c, context); }},
        command);
}

} // namespace

void apply(const Command& command, HandlerContext context) {
    try {
        dispatch(command, context);
    } catch (const std::exception& failure) {
        post_failure(context.state, failure);
    }
}

void follow_document(HandlerContext context) {
    State& state = context.state;
    if (!context.engine.is_open() || state.document.dragging()) return;
    try {
        const bool rebuilt = context.engine.follow(state.document.profile());
        state.document.accept();
        if (!rebuilt) return;
        state.scene = context.engine.scene();
        state.measures.clear();
        state.chosen.reset();
    } catch (const std::exception& failure) {
        state.document.revert();
        state.scene = context.engine.scene(); // closed when what was before cannot be had any more either
        post_failure(state, failure, "the change was reverted: ");
    }
}

} // namespace fjell::editor
