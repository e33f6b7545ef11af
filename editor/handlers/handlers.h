// Applies commands: the one place, beside the frame itself, that changes the state.
//
// Failure: none gets out. What a command cannot do becomes a message and the state stays as it was.
#pragma once

#include <string>
#include <string_view>

#include "editor/command.h"
#include "editor/engine.h"
#include "editor/jobs/jobs.h"
#include "editor/state.h"

namespace fjell::editor {

// What commands act on.
struct HandlerContext {
    State& state;
    Engine& engine;
    Jobs& jobs;
};

void apply(const Command& command, HandlerContext context);

// Brings the engine in line with the document, unless a control is still held; what cannot be had is reverted.
void follow_document(HandlerContext context);
// After a pack was opened: scene, camera, measures.
void start_at_scene(HandlerContext context);
// What a frame does to the camera of itself: the path that is played or recorded goes on, and Eye::view and ground_m
// follow. A pack must be open, and Interface know the picture's size.
void move_camera(HandlerContext context, double seconds);

// --- One handler per command; apply() finds it. Handlers may throw io::Failure, which becomes a message.

// --- profile
void handle(const SetKey& c, HandlerContext context);
void handle(const Undo& c, HandlerContext context);
void handle(const Redo& c, HandlerContext context);
void handle(const OpenProfile& c, HandlerContext context);
void handle(const SaveProfile& c, HandlerContext context);

// --- files
// The sample terrain: a small synthetic landscape (content/terrain/mountains-small.json), baked at its first use.
[[nodiscard]] std::string_view sample_landscape(); // JSON, as fjell-bake takes it
[[nodiscard]] std::string sample_pack(const std::string& cache_folder);
// What bakes it: the landscape is written to the folder, which is made. Throws io::Failure.
[[nodiscard]] BakePack bake_sample(const std::string& cache_folder);
// Reads the pack while the caller waits. What the engine has opened, as the scene: camera, measures, recent files.
void open_now(const std::string& pack, HandlerContext context);
void show_opened(const std::string& pack, HandlerContext context);
// Heights to a pack beside them, never over a file. Failure: io::Failure 2 where there is one.
void bake_beside(const std::string& heights, HandlerContext context);
void handle(const OpenFile& c, HandlerContext context);
void handle(const OpenSample& c, HandlerContext context);
void handle(const ChooseMaterials& c, HandlerContext context);

void handle(const BrowseFor& c, HandlerContext context);

// --- bake
void handle(const DraftBake& c, HandlerContext context);
void handle(const GiveBakeFile& c, HandlerContext context);
void handle(const OpenBaked& c, HandlerContext context);
void handle(const BakePack& c, HandlerContext context);
// A pack is ready: it is opened, or the user is asked.
void take_baked(const std::string& pack, HandlerContext context);

// --- what is not saved
void handle(const AnswerUnsaved& c, HandlerContext context);
void handle(const RecoverChanges& c, HandlerContext context);
void handle(const Quit& c, HandlerContext context);
// Before a command that would lose changes: asks, and keeps the command as `again`, to be applied once the user has
// answered. True: the question is open, and the command must not run now.
[[nodiscard]] bool ask_about_unsaved(Command again, HandlerContext context);
// After something was saved: runs the command that waited for it.
void continue_saving(HandlerContext context);

// --- ground
[[nodiscard]] Digging& digging(HandlerContext context); // of what is open; Failure 2 when nothing is
// What panels show of it, once a frame.
void follow_ground(Ground& ground, const Digging& digging, const session::Session& session, const View& view);
void handle(const AimBrush& c, HandlerContext context);
void handle(const StrokeGround& c, HandlerContext context);

// --- camera
void handle(const MoveCamera& c, HandlerContext context);
void handle(const PlaceCamera& c, HandlerContext context);
void handle(const JumpTo& c, HandlerContext context);
void handle(const ViewAll& c, HandlerContext context);
void handle(const SetSpeed& c, HandlerContext context);
void handle(const SetNavigation& c, HandlerContext context);
void handle(const FreezeRefinement& c, HandlerContext context);
// Throws Failure (2) when no terrain is open.
const Engine& open_engine(HandlerContext context);
// The user has moved the camera: it leaves the path.
void take_from_path(State& state);
// Around the ground at the picture's centre or, where that shows the sky, around a point ahead.
void begin_orbit(HandlerContext context);

// --- path
void handle(const OpenPath& c, HandlerContext context);
void handle(const SavePath& c, HandlerContext context);
void handle(const RecordPath& c, HandlerContext context);
void handle(const PlayPath& c, HandlerContext context);
void handle(const SeekPath& c, HandlerContext context);
void handle(const SelectPoint& c, HandlerContext context);
void handle(const ClearPath& c, HandlerContext context);
// For paths, whose flight must not depend on what has been streamed in.
[[nodiscard]] session::Ground path_ground(HandlerContext context);
// The path has changed under a camera that follows it: it sees what is there now.
void follow_path(State& state);
// One step of undo, or of redo, of the path.
void undo_path(HandlerContext context);
void redo_path(HandlerContext context);
// Makes what is being recorded the path, so that it can be saved, asked about and restored.
void end_recording(HandlerContext context);

// --- interface
void handle(const ShowPanel& c, HandlerContext context);
void handle(const ShowGroup& c, HandlerContext context);
void handle(const ShowDialog& c, HandlerContext context);
void handle(const SetSwitch& c, HandlerContext context);
void handle(const ArrangeColumn& c, HandlerContext context);
void handle(const FloatPanel& c, HandlerContext context);
void handle(const PlacePanel& c, HandlerContext context);
void handle(const ChooseFrame& c, HandlerContext context);
void handle(const ZoomGraphs& c, HandlerContext context);

// --- jobs
void handle(const TuneThreshold& c, HandlerContext context);
void handle(const RunBenchmark& c, HandlerContext context);
void handle(const UseTuned& c, HandlerContext context);
void handle(const ExportMesh& c, HandlerContext context);
void handle(const PreviewExport& c, HandlerContext context);
// What a job that has just ended means for the state: a baked pack is opened, a tuned threshold offered.
void handle_job_result(HandlerContext context);

// --- runs, bookmarks, pictures
void handle(const ChoosePlace& c, HandlerContext context);
void handle(const ForgetRun& c, HandlerContext context);
void handle(const RenderPicture& c, HandlerContext context);
void handle(const AddBookmark& c, HandlerContext context);
void handle(const GoToBookmark& c, HandlerContext context);
void handle(const RemoveBookmark& c, HandlerContext context);
void handle(const ComparePictures& c, HandlerContext context);
// Looks from there, with its roll, until a hand moves the camera.
void look_from(const session::Pose& pose, HandlerContext context);

} // namespace fjell::editor
