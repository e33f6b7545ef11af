// Everything that can be done in the editor, as data.
//
// Panels, keys, the command line and scripts make commands; apply() (editor/handlers/handlers.h) is the one place that
// applies them. Each but MoveCamera has a text form, one line: a verb and its words (`set refine.max_error_px 2`), so
// that scripts can do what a user can. Thread: the frame's. Memory: those of a steady frame allocate nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "editor/digging.h"
#include "editor/names.h"
#include "fjell/profile/keys.h"
#include "fjell/view.h"
#include "session/camera.h"

namespace fjell::editor {

// --- the terrain and its profile ---
struct OpenFile { // a pack, a profile, a camera path, or heights to be baked: told from the content
    std::string path;
    bool discard = false; // without asking about what is not saved
};
struct OpenSample {};      // baked at its first use
struct ChooseMaterials {   // of near ground, for the terrain that is open: remembered for it
    std::string materials; // a file, or built-in (editor/materials.h); empty: none
    std::string rules;     // a file, or one of built_in_rules; empty: none
};
struct SetKey {
    const ProfileKey* key = nullptr;
    double value = 0;
    bool dragging = false; // more of the same follows: one undo step, and nothing is rebuilt before the last
};
struct Undo {}; // the last change of the profile, the camera path or the ground, the latest one
struct Redo {};
struct ResetProfile {};
struct SetLight { // several values of the profile, in one step
    LightPreset preset = LightPreset::relief;
};
struct OpenProfile {
    std::string path;
    bool discard = false; // without asking about what is not saved
};
struct SaveProfile {
    std::string path; // empty: where it came from
};
struct CompareProfile {
    std::string path; // empty: with what was saved last
};
struct StopComparing {};
struct BrowseFolder {   // what file dialogs look at
    std::string folder; // relative: from there on; empty: once more
};
struct BrowseAllKinds { // files of all kinds
    bool on = false;
};
struct AnswerUnsaved { // to the question about unsaved changes that a command has raised
    Answer answer = Answer::cancel;
};
struct RecoverChanges {   // what an earlier run did not save
    bool restore = false; // or it is gone
};

// --- the camera ---
struct MoveCamera { // of this frame: keys and mouse
    session::Steering steering;
    double seconds = 0;
    double right_rad = 0, up_rad = 0;   // looked, or went around the orbit's centre
    double speed_steps = 0;             // notches of the wheel: faster, or nearer to the orbit's centre
    double pan_right = 0, pan_back = 0; // of the orbit's centre, in shares of its distance
};
struct PlaceCamera {
    Vec3 position_m;
    double heading_rad = 0, pitch_rad = 0;
};
struct JumpTo { // to over this place, looking as before
    double x_m = 0, z_m = 0;
};
struct ViewAll {}; // from the south, all of the terrain in view
struct SetSpeed {
    double m_s = 1;
};
struct SetNavigation {
    Navigation navigation = Navigation::fly;
};
struct FreezeRefinement { // the camera that refines and culls stays where it is
    bool on = false;
};

// --- the camera's path ---
struct OpenPath {
    std::string path;
    bool discard = false; // without asking about what is not saved
};
struct SavePath {
    std::string path; // empty: where it came from
};
struct RecordPath {
    bool on = false;
};
struct PlayPath {
    bool on = false;
};
struct SeekPath {
    double share = 0; // 0..1 of its length
};
struct AddPoint {}; // where the camera is, after the selected one
struct ReplacePoint {
    std::size_t point = 0; // by where the camera is
};
struct RemovePoint {
    std::size_t point = 0;
};
struct MovePoint { // so that it becomes the to-th
    std::size_t point = 0, to = 0;
};
struct ClearPath {};
struct RestorePath {}; // as it was before its last edit
struct SetPathSeconds {
    double seconds = 0; // 0: at a speed that suits the terrain
};
struct LoopPath {
    bool on = true;
};

struct SelectPoint {
    std::size_t point = 0;
    bool looks = true; // from there
};
struct InsertPoint {                  // on the path, where it is at that share of its time
    std::optional<double> share = {}; // none: where it is being played
};
struct PlacePoint { // over that place: at that height, or as high above the ground as it was
    std::size_t point = 0;
    double x_m = 0, z_m = 0;
    bool dragging = false; // more of the same follows: one step of undo
    std::optional<double> y_m = {};
};

// --- the probe (editor/probe.h) ---
struct PointProbe { // at this place of the picture, in shares of its width and height
    double x = 0, y = 0;
};
struct MarkPlace { // one more
    double x_m = 0, z_m = 0;
};
struct RemoveMark {}; // the last
struct ClearMarks {};

// --- moving ground (editor/digging.h) ---
struct SetBrush {
    Brush brush;
};
struct AimBrush { // at this place of the picture, as PointProbe has it; down: and digs there; ends: it was let go
    double x = 0, y = 0;
    bool down = false, ends = false;
};
struct StrokeGround { // a whole stroke along these places, x and z in metres
    std::vector<std::array<double, 2>> places;
};
struct AddEditLayer {
    std::string name;
};
struct ChooseEditLayer {
    std::size_t place = 0; // from the bottom
};
struct SetEditLayer {
    std::size_t place = 0;
    std::optional<bool> on; // what is not given stays as it is
    std::optional<double> strength;
    std::optional<std::size_t> to; // its new place
};
struct RemoveEditLayer {
    std::size_t place = 0;
};

// --- what is shown ---
struct SetPictureMode {
    session::PictureMode mode = session::PictureMode::shaded;
};
struct SetOverlay {
    Overlay overlay = Overlay::wireframe;
    bool on = false;
};
struct SetContours {
    double every_m = 0; // between them; 0: as suits the terrain
};
struct ShowPanel {
    Panel panel = Panel::tune;
};
struct ShowGroup { // unfolded, in its panel, which is turned to; or folded
    Group group = Group::tune_refinement;
    bool on = true;
};
struct ShowDialog {
    Dialog dialog = Dialog::none;
};
struct SetSwitch {
    Switch which = Switch::show_panels;
    bool on = false;
};
struct ArrangeColumn { // its width in unscaled pixels, its upper section's share, or 1: it is folded
    Column column = Column::left;
    ColumnPart part = ColumnPart::width;
    double value = 0;
};
struct FloatPanel { // over the picture, or back in its column
    Panel panel = Panel::tune;
    bool on = false;
    std::optional<std::array<double, 2>> at_px; // where; as in PlacePanel
};
struct PlacePanel { // one that floats, in unscaled pixels from the window's corner
    Panel panel = Panel::tune;
    double x_px = 0, y_px = 0, width_px = 0, height_px = 0;
};
struct SetScale {
    double scale = 1; // of the user interface
};
struct ChooseFrame { // of those measured: its report is shown
    bool on = false;
    std::size_t ago = 0; // 0: the newest
};
struct HoldMeasures { // graphs and times stand still; when they go on, graphs show all frames again
    bool on = false;
};
struct ZoomGraphs { // to these frames, in frames ago; held, or they would move on
    std::size_t oldest = 0, newest = 0;
};
struct DismissMessage {};

// --- jobs beside the frame; one at a time ---
struct BakePack {
    std::vector<std::string> inputs;
    std::string output;     // opened when it is done
    std::uint32_t tile = 0; // cells a side; 0: auto
    std::string texture, ramp;
    double spacing_m = 0, height_scale = 0, height_offset_m = 0; // spacing, scale 0: the file's own
    std::string order, nodata, voids, crs;                       // as fjell-bake has them; empty: its defaults
    std::string rules, splat;                                    // its --layers, and how fine these maps are
    std::string horizons, encoding, bbox;                        // and these of its options
    std::string band, size, vertical_unit, texture_bands;
    std::uint32_t memory_mb = 512;
    double checkpoint_s = -1; // at least 0: work files even when all fits the memory (baker/bake/bake.h)
    bool asks = false;        // before the new pack takes the place of a terrain that is flown
    friend bool operator==(const BakePack&, const BakePack&) = default;
};
struct DraftBake { // what the dialog that bakes holds by now; output_is_chosen: typed or browsed, not derived
    BakePack pack;
    bool output_is_chosen = false;
};
struct GiveBakeFile { // to that dialog, which opens: in a field, or where its kind belongs
    std::string path;
    BakeField field = BakeField::none;
    bool another = false; // heights: beside those that are there, as a mosaic
};
struct OpenBaked { // the pack that was baked beside the terrain that is flown, or not
    bool open = true;
};
struct BrowseFor { // files of a kind, from the folder of a file that is named
    FileFilter filter = FileFilter::everything;
    std::string beside; // empty: where the last dialog looked
};
// What auto-tuning is asked for.
enum class TuneMeasure : std::uint8_t { update, frame }; // update: the CPU's; frame: with upload, drawing and the GPU
inline constexpr const char* tune_measure_names[] = {"update", "frame"};

struct TuneSettings {
    TuneMeasure measure = TuneMeasure::update;
    double budget_us = 2000; // that p99 shall keep; 10 to 1e6
    // Of each flight, 10 to 100,000; 0: as many as the path has at 60 a second. Fewer fly the same path faster, and a
    // faster camera changes more in a frame.
    std::uint32_t frames = 0;
    double least_px = 0.25, most_px = 32; // where the threshold is looked for
    bool apply = false;                   // sets what was found
    // Off-screen factor, hysteresis and morphing too: the first two where they make frames cheaper, so that a smaller
    // threshold fits, and morphing where it fits as well. Not of the recursive method, which has none of them.
    bool also = false;
};
struct TuneThreshold {
    TuneSettings settings;
    std::string csv; // of the curve; empty: none
};
struct RunBenchmark {
    std::string csv;
    std::size_t frames = 0; // 0: as many as the path usually has
};
struct ExportMesh {
    std::string path;       // .glb
    bool converged = false; // what the view would settle on; otherwise the frame's mesh as it stands
    double error_px = 0;    // not 0: the whole terrain at this threshold instead
    double texel_m = 0;     // of its textures; 0: as fine as the maps are
    bool quantised = false, meshopt = false, jpeg = false; // as gltf::SnapshotOptions has them; jpeg: its colours
};
struct PreviewExport { // size and counts of it, nothing written
    ExportMesh mesh;   // without a path
};
struct CancelJob {};
struct UseTuned {}; // sets what auto-tuning found last, in one step

// --- runs that benchmarks flew (editor/runs.h) ---
struct ChoosePlace { // of a run, and look from there
    std::size_t run = 0;
    double share = 0; // 0..1 of its frames
};
struct ForgetRun {
    std::size_t run = 0;
};
enum class Heat : std::uint8_t { none, time, error };
inline constexpr const char* heat_names[] = {"none", "time", "error"};
struct SetHeat { // what the overview's path is coloured by, from the latest run
    Heat heat = Heat::none;
};

// --- pictures of any size, rendered beside the frame ---
struct RenderPicture { // of what the camera sees
    std::string path;  // .png
    std::uint32_t width = 3840, height = 2160;
};

// --- bookmarks ---
struct AddBookmark {
    std::string name; // empty: numbered
};
struct GoToBookmark {
    std::size_t bookmark = 0;
};
struct RemoveBookmark {
    std::size_t bookmark = 0;
};

// --- two profiles in one picture (editor/comparison.h) ---
enum class CompareWith : std::uint8_t { nothing, threshold, half, profile };
inline constexpr const char* compare_with_names[] = {"off", "threshold", "half", "profile"};
struct ComparePictures {
    CompareWith with = CompareWith::nothing;
    double error_px = 0; // of a threshold; the rest is the profile's
};                       // half: the threshold that draws half the triangles
enum class CompareView : std::uint8_t { split, difference };
inline constexpr const char* compare_view_names[] = {"split", "difference"};
struct SetCompareView {
    CompareView view = CompareView::split;
};
struct SetDivider {
    double share = 0.5; // of the picture's width: on its left the profile, on its right the other one
};

// --- the program ---
struct TakeScreenshot {
    std::string path; // .png
    bool with_panels = true;
};
struct ResizeWindow { // the headless window
    std::uint32_t width = 0, height = 0;
};
struct DumpState {
    std::string path; // JSON, for tests and scripts
};
struct LoseGraphics {}; // as when the driver resets: everything on the GPU is recreated
struct Quit {
    bool discard = false; // without asking about what is not saved
};

// --- of scripts only: what comes after waits ---
struct WaitFrames {
    std::size_t frames = 0;
};
struct WaitSettled {}; // until the mesh has converged, all wanted is streamed in and no job runs

using AnyCommand =
    std::variant<OpenFile, OpenSample, ChooseMaterials, SetKey, Undo, Redo, ResetProfile, SetLight, OpenProfile,
                 SaveProfile, CompareProfile, StopComparing, BrowseFolder, BrowseAllKinds, AnswerUnsaved,
                 RecoverChanges, MoveCamera, PlaceCamera, JumpTo, ViewAll, SetSpeed, SetNavigation, FreezeRefinement,
                 OpenPath, SavePath, RecordPath, PlayPath, SeekPath, AddPoint, ReplacePoint, RemovePoint, SelectPoint,
                 MovePoint, ClearPath, RestorePath, SetPathSeconds, LoopPath, PointProbe, MarkPlace, RemoveMark,
                 ClearMarks, SetPictureMode, SetOverlay, SetContours, ShowPanel, ShowGroup, ShowDialog, SetSwitch,
                 ArrangeColumn, FloatPanel, PlacePanel, SetScale, ChooseFrame, HoldMeasures, ZoomGraphs, DismissMessage,
                 DraftBake, GiveBakeFile, OpenBaked, BrowseFor, BakePack, TuneThreshold, RunBenchmark, ExportMesh,
                 PreviewExport, CancelJob, UseTuned, TakeScreenshot, ResizeWindow, DumpState, LoseGraphics, Quit,
                 WaitFrames, WaitSettled, ChoosePlace, ForgetRun, SetHeat, RenderPicture, InsertPoint, PlacePoint,
                 SetBrush, AimBrush, StrokeGround, AddEditLayer, ChooseEditLayer, SetEditLayer, RemoveEditLayer,
                 AddBookmark, GoToBookmark, RemoveBookmark, ComparePictures, SetCompareView, SetDivider>;
template <typename T, typename V>
inline constexpr bool is_alternative = false;
template <typename T, typename... Ts>
inline constexpr bool is_alternative<T, std::variant<Ts...>> = (std::is_same_v<T, Ts> || ...);

// One of them. What the variant does for each of its kinds is compiled once, and not with every panel.
struct Command : AnyCommand {
    template <typename T>
    requires is_alternative<T, AnyCommand> Command(T command)
    noexcept : AnyCommand(std::in_place_type<T>, std::move(command)) {}
    Command(const Command& from);
    Command(Command&& from) noexcept;
    Command& operator=(const Command& from);
    Command& operator=(Command&& from) noexcept;
    ~Command();
};

// What the panels of one frame ask for, in its order. Room for a frame's worth is made once.
class Commands {
public:
    Commands() { list_.reserve(64); }
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;
    void push(Command command) { list_.push_back(std::move(command)); }
    [[nodiscard]] const std::vector<Command>& list() const { return list_; }
    void clear() { list_.clear(); }

private:
    std::vector<Command> list_;
};

// One line of a script. Empty lines and those that begin with # are none. Throws io::Failure (2) that says what the
// verb wants.
[[nodiscard]] std::optional<Command> parse_command(std::string_view line);
// Every verb, its words and what it does, one a line: for --help-commands and the README.
[[nodiscard]] std::string command_help();

} // namespace fjell::editor
