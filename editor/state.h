// All that the editor knows and panels read: one plain value, changed by apply() and by the frame (editor/app.h) alone.
//
// docs/notes/editor.md draws who reads and who writes. Thread: the frame's. Units are in the names; times of the clock
// are seconds since the editor started.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baker/georeference/coordinates.h"
#include "editor/command.h"
#include "editor/contours.h"
#include "editor/document.h"
#include "editor/files/listing.h"
#include "editor/files/recovery.h"
#include "editor/files/settings.h"
#include "editor/jobs/heights.h"
#include "editor/jobs/jobs.h"
#include "editor/materials.h"
#include "editor/measures.h"
#include "editor/names.h"
#include "editor/probe.h"
#include "editor/route.h"
#include "editor/runs.h"
#include "editor/surface.h"
#include "fjell/gl/renderer.h"
#include "fjell/io/stream_reader.h"
#include "fjell/view.h"
#include "session/camera.h"
#include "session/log.h"
#include "session/options.h"

namespace fjell::editor {

// What is open.
struct Scene {
    std::shared_ptr<const baker::Coordinates> coordinates; // null: nothing is open
    std::string path;                                      // of the pack; empty: nothing is open
    std::uint32_t columns = 0, rows = 0, tiles_x = 0, tiles_y = 0, tile_cells = 0, pages = 0;
    std::uint32_t tiles = 0; // that there are: fewer than fit, of a sparse pack set
    double spacing_m[2] = {}, min_m = 0, max_m = 0, quantum_m = 0;
    bool horizons = false, splat = false; // the pack has these maps
    bool materials = false;               // are loaded
    std::uint32_t mips = 0;               // of the maps that are shown by their mips; 0: it has none
    std::uint64_t file_bytes = 0, terrain_bytes = 0, method_bytes = 0, stream_bytes = 0;
    bool streamed = false;

    [[nodiscard]] bool open() const { return !path.empty(); }
    [[nodiscard]] double width_m() const { return columns > 1 ? (columns - 1) * spacing_m[0] : 0; }
    [[nodiscard]] double depth_m() const { return rows > 1 ? (rows - 1) * spacing_m[1] : 0; }
};

struct Eye {
    session::FreeCamera free;
    Navigation navigation = Navigation::fly;
    Vec3 orbit_centre_m; // on the ground
    double orbit_radius_m = 1;
    double ground_m = 0;                  // under the camera
    double speed_shown_until_s = 0;       // in the picture's corner
    bool moved = false;                   // by a hand, since the terrain was opened
    std::optional<session::Pose> on_path; // of the path that is played, until the user moves the camera
    View view;                            // of the last frame, as drawn
    bool frozen = false;                  // refined for another view than is drawn:
    std::optional<View> refining;         // that one

    [[nodiscard]] session::Pose pose() const { return on_path ? *on_path : free.pose(); }
};

enum class Severity : std::uint8_t { note, warning, error };
struct Message {
    Severity severity = Severity::note;
    std::string text; // one line, the remedy in it
    double at_s = 0;
    std::uint32_t times = 1; // the same again
};

struct Messages {
    std::deque<Message> all;  // the last 200
    double shown_until_s = 0; // the newest, over the picture
};

// Keys of which the profile and the one it is compared with have different values.
struct Difference {
    const ProfileKey* key = nullptr;
    double theirs_value = 0;
    std::string mine, theirs;
};

// Files that the editor keeps or lists, and the open question about unsaved changes.
struct Files {
    Folders standard_folders;
    Settings settings;     // as they were written last
    bool persists = false; // settings and changes are written: it is in a window
    FolderListing browser;
    Recovery recovery;
    std::optional<Command> waiting; // for changes to be saved or discarded
    bool saving = false;            // and the user wants them saved
    std::optional<Look> look_begun; // of the first frame, which the command line may have asked for
    Look look_seen;                 // of the frame before
    double look_changed_s = 0;
    // Recreated when one of the three below has changed.
    std::string title;        // of the window
    std::string profile_name; // with a star when it is not saved
    std::vector<Difference> differences;
    std::uint64_t version = ~std::uint64_t{0}; // of the document
    bool path_unsaved = false;
    std::string pack;
    std::string script; // the file that commands are read from; empty: none
};

struct Interface {
    double scale = 1;
    Arrangement arrangement;
    bool picture_only = false;    // neither panels nor menu nor status line
    bool panel_keys = false;      // the keyboard is the panels', not the camera's
    bool half_resolution = false; // of the picture while the camera moves
    Dialog dialog = Dialog::none;
    session::PictureMode mode = session::PictureMode::shaded;
    std::array<bool, overlays> overlay = first_overlays;
    double contour_m = 0;                      // between contours; 0: as suits the terrain
    std::vector<std::string> recent;           // packs, the latest first
    std::uint32_t width_px = 0, height_px = 0; // of the window
    std::uint32_t view_x_px = 0, view_y_px = 0, view_width_px = 0, view_height_px = 0; // of the picture in it
};

// The frames that graphs show, in frames ago.
struct GraphSpan {
    std::size_t oldest = measured_frames - 1, newest = 0;

    [[nodiscard]] bool whole() const { return oldest == measured_frames - 1 && newest == 0; }
};
inline constexpr std::size_t least_graph_span = 8;

// The terrain from above (editor/scene/textures.h), north up.
struct OverviewImage {
    unsigned texture = 0; // GL name; 0: there is none yet
    double share = 0;     // of it that is painted, 0..1
};

// Another profile in the same picture (editor/comparison.h).
struct ComparedPicture {
    CompareWith with = CompareWith::nothing;
    double error_px = 0; // of CompareWith::threshold, and of half as far as it is found
    CompareView view = CompareView::split;
    double divider = 0.5; // in shares of the picture's width
    bool there = false;   // drawn; otherwise still being opened
    // Of the last frame:
    std::uint32_t triangles = 0, exhausted = 0; // exhausted: ExhaustedBit
    double update_us = 0, asked_px = 0, kept_px = 0;
    double differing = -1; // share of the picture's pixels that differ visibly; below 0: not counted yet
};

// What brushes and edit layers are at (editor/digging.h).
struct Ground {
    struct Layer {
        std::string name;
        bool on = true;
        double strength = 1;
        std::size_t stamps = 0;
    };
    static constexpr std::size_t ring_points = 48;

    Brush brush;
    std::string problem; // why the ground cannot be changed; empty: it can
    std::string journal; // its file
    std::vector<Layer> layers;
    std::optional<std::size_t> chosen; // of them
    std::size_t undo_steps = 0, redo_steps = 0;
    std::uint64_t undo_stamp = 0, redo_stamp = 0;
    std::uint64_t version = 0;                      // of Digging, that this is of
    EditReport report;                              // of the last frame
    double update_us = 0;                           // the same
    std::uint32_t blocks = 0;                       // that there is room for
    std::uint32_t always_drawn = 0;                 // vertices, where there are locks
    std::size_t waiting = 0;                        // stamps
    std::optional<std::array<double, 2>> pointer;   // in the picture
    std::optional<Vec3> at;                         // under it
    std::array<Vec3, ring_points> inner{}, outer{}; // on the ground, round that place
    std::optional<std::array<double, 2>> last_dab;  // of the stroke that is under way
    double level_m = 0;                             // its height, of BrushTool::level
    std::vector<StampPoint> road;                   // so far, of BrushTool::road: it is built when the stroke ends
};

// Of near ground, as they are drawn.
struct MaterialsInUse {
    std::string materials, rules;  // as ChooseMaterials has them
    bool of_this_run = false;      // the command line's, whatever is remembered
    std::optional<Command> baking; // what is chosen once the built-in ones have been baked
    GroundShares under;            // the camera
};

struct State {
    Scene scene;
    MaterialsInUse materials;
    std::string opening; // a pack that is being read; empty: none
    Document document;
    Route route;
    Eye eye;
    Measures measures;
    GraphSpan graphs;
    std::optional<MeasuredFrame> chosen; // that the time panel reports on
    OverviewImage overview;
    Probe probe;
    Ground ground;
    ContourLabels contour_labels;
    io::StreamReaderCounters reader; // of a streamed pack
    JobView job;
    Runs runs; // benchmarks that were flown
    Bookmarks bookmarks;
    ComparedPicture compared;
    JobView tuned; // the last tuning that was not cancelled
    Messages messages;
    Files files;
    BakeDraft bake; // of the dialog that bakes
    Interface interface;
    InputCounts input;
    double now_s = 0;
    double frame_s = 0;  // since the frame before, at most 0.25, without what the editor rested
    double rested_s = 0; // in all: nothing changed, and nothing was drawn
    std::uint64_t frame = 0;
    std::uint64_t terrain_draws = 0; // frames whose terrain was drawn anew
    double longest_frame_us = 0;     // since the frame of the last dump, that one counted
    std::uint64_t programs = 0;      // shaders that the frame's thread has had compiled and linked
    std::uint64_t half_draws = 0;    // of those, at half resolution
    std::uint64_t band_draws = 0;    // of those, a band of the whole picture after one of half resolution
    std::uint32_t drawn_px[2] = {};  // of the last of these
    bool quit = false;
    bool headless = false;              // messages go to the terminal too
    int exit_code = 0;                  // of a headless run: the first failure's
    std::optional<gl::DrawStats> drawn; // of the last frame
    double heights_share = 0; // of what the picture of the true error needs, read; below 1 it is not drawn yet,
                              // below 0 it cannot be
    std::string graphics;     // the driver
    bool software = false;    // it draws on the CPU: no GPU to be timed

    [[nodiscard]] bool shows(Overlay overlay) const { return interface.overlay[static_cast<std::size_t>(overlay)]; }
};

// Between contours: what was chosen, or a round number of metres, some 20 of them over the terrain's heights.
[[nodiscard]] double contour_interval_m(const State& state);

// Throws Failure (2) when the output would replace a file that is open: the pack, the profile, the camera path or the
// script. own: the one of these that it may replace, as what is saved replaces what it came from.
void refuse_overwriting_open_files(const State& state, const std::string& output, const std::string& own = "");

// What one step back, or forward, would change: a key's label, several values or the camera path; empty: there is none.
[[nodiscard]] const char* undo_label(const State& state);
[[nodiscard]] const char* redo_label(const State& state);

// Appends a message and shows it in the status line; a headless run prints it too.
void post_message(State& state, Severity severity, std::string text);
// What was thrown, as an error. before: the line's beginning.
void post_failure(State& state, const std::exception& failure, const std::string& before = "");

} // namespace fjell::editor
