// The camera path: opened, saved, recorded, played and edited.
#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

using io::Failure;

// For paths, whose flight must not depend on what has been streamed in.
flight::Ground whole_ground(HandlerContext context) {
    return open_engine(context).session().ground();
}

// The path has changed under a camera that follows it: it sees what is there now.
void follow_edit(State& state) {
    if (state.eye.navigation != Navigation::path) return;
    if (state.route.empty()) return take_from_path(state);
    state.eye.on_path = state.route.pose();
    state.eye.free = flight::free_camera(*state.eye.on_path, state.eye.free.speed_m_s);
}

} // namespace

// What is being recorded becomes the path: then it can be saved, asked about and restored.
void end_recording(HandlerContext context) {
    if (!context.state.route.recording()) return;
    try {
        handle(RecordPath{false}, context);
    } catch (const Failure&) { // the camera did not move: there is nothing to lose
    }
}

void handle(const OpenPath& c, HandlerContext context) {
    end_recording(context);
    if (!c.discard && ask_about_unsaved(OpenPath{c.path, true}, context)) return;
    State& state = context.state;
    const bool lost = state.route.unsaved();
    state.route.open(c.path, whole_ground(context));
    if (state.eye.navigation == Navigation::path) take_from_path(state);
    if (lost) post_message(state, Severity::warning, "the previous path was not saved; Restore brings it back");
}

void handle(const SavePath& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.path, context.state.route.path());
    context.state.route.save(c.path);
    if (context.state.interface.dialog == Dialog::save_path) context.state.interface.dialog = Dialog::none;
    continue_saving(context);
    post_message(context.state, Severity::note, fmt::format("saved the camera path to {}", context.state.route.path()));
}

void handle(const RecordPath& c, HandlerContext context) {
    State& state = context.state;
    if (c.on) take_from_path(state);
    const bool lost = !c.on && state.route.recording() && state.route.unsaved();
    state.route.record(c.on, state.eye.pose(), whole_ground(context));
    if (lost) post_message(state, Severity::warning, "the previous path was not saved; Restore brings it back");
}

void handle(const PlayPath& c, HandlerContext context) {
    State& state = context.state;
    if (c.on && state.route.recording()) handle(RecordPath{false}, context);
    state.route.play(c.on);
    if (c.on) handle(SeekPath{state.route.share()}, context);
}

void handle(const SeekPath& c, HandlerContext context) {
    State& state = context.state;
    if (state.route.empty()) throw Failure(2, "there is no camera path yet; open one, record one or add points");
    state.route.seek(c.share);
    state.eye.on_path = state.route.pose();
    state.eye.free = flight::free_camera(*state.eye.on_path, state.eye.free.speed_m_s);
    state.eye.navigation = Navigation::path;
}

void handle(const AddPoint&, HandlerContext context) {
    context.state.route.add(context.state.eye.pose(), whole_ground(context));
}

void handle(const ReplacePoint& c, HandlerContext context) {
    context.state.route.replace(c.point, context.state.eye.pose(), whole_ground(context));
}

void handle(const RemovePoint& c, HandlerContext context) {
    context.state.route.remove(c.point, whole_ground(context));
    follow_edit(context.state);
}

void handle(const SelectPoint& c, HandlerContext context) {
    State& state = context.state;
    const flight::Pose pose = state.route.select(c.point);
    if (!c.looks) return;
    take_from_path(state);
    state.eye.free = flight::free_camera(pose, state.eye.free.speed_m_s);
    state.eye.on_path = pose; // with its roll, until a hand moves the camera
    if (state.eye.navigation == Navigation::orbit && context.engine.is_open()) begin_orbit(context);
}

void handle(const MovePoint& c, HandlerContext context) {
    context.state.route.move(c.point, c.to, whole_ground(context));
}

void handle(const ClearPath&, HandlerContext context) {
    end_recording(context);
    const bool unsaved = context.state.route.unsaved();
    take_from_path(context.state);
    context.state.route.clear();
    if (unsaved) post_message(context.state, Severity::note, "the cleared path was not saved; Restore brings it back");
}

void handle(const RestorePath&, HandlerContext context) {
    context.state.route.restore();
    follow_edit(context.state);
}

void undo_path(HandlerContext context) {
    context.state.route.undo();
    follow_edit(context.state);
}

void redo_path(HandlerContext context) {
    context.state.route.redo();
    follow_edit(context.state);
}

void handle(const PlacePoint& c, HandlerContext context) {
    context.state.route.place(c.point, c.x_m, c.z_m, c.dragging, whole_ground(context), c.y_m);
    follow_edit(context.state);
}

void handle(const InsertPoint& c, HandlerContext context) {
    Route& route = context.state.route;
    route.insert(c.share.value_or(route.share()), whole_ground(context));
    follow_edit(context.state);
}

void handle(const SetPathSeconds& c, HandlerContext context) {
    context.state.route.set_seconds(c.seconds, whole_ground(context));
}

void handle(const LoopPath& c, HandlerContext context) {
    context.state.route.loop(c.on);
}

} // namespace fjell::editor
