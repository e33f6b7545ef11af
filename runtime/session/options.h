// What a flight is told: by fjell-fly's command line, or by the editor.
#pragma once

#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fjell/io/pack_file.h"
#include "fjell/profile.h"
#include "io/stamps.h"
#include "session/layers_file.h"

namespace fjell::session {

enum class Streaming : std::uint8_t { automatic, on, off }; // automatic: when the pack has more pages than page slots

enum class PictureMode : std::uint8_t { shaded, wire, levels, tiles, mips, residency, distance };
inline constexpr const char* picture_mode_names[] = {"shaded", "wire",      "levels",  "tiles",
                                                     "mips",   "residency", "distance"};
inline constexpr int picture_modes = static_cast<int>(std::size(picture_mode_names));

// A still camera: where it is, and the point that it looks at. Scene axes, metres.
struct StillCamera {
    Vec3 eye_m, look_m;
};

struct Export {
    std::size_t frame = 0;
    std::string path;
};

struct FlightOptions {
    std::string pack, path, profile_path;
    std::string materials_path, rules_path;     // of detail layers
    std::shared_ptr<const GroundLayers> layers; // and what is in them; null: none
    std::shared_ptr<const io::PackFile> file;   // the pack, when it is open already, whatever its name leads to now
    std::size_t frames = 0;                     // 0: not given
    double hz = 60;                             // path frames a second, in the window
    Profile profile;                            // with the flags applied
    bool limited = false;                       // --items or --budget-us bounds the first frame too
    bool headless = false;
    Streaming streaming = Streaming::automatic;
    bool realtime = false;                     // headless frames at hz
    bool wait = false;                         // headless frames until all is there
    double read_mb_s = 0, read_latency_ms = 0; // a slower disk than there is; 0: as it is
    bool cold = false;                         // the system forgets the file first
    std::string csv, json;
    std::string record, replay; // of the incremental method (session/record.h)
    std::string edits_path;
    std::vector<io::TimedStamp> stamps; // and what is in it
    EditBudget edit_budget;
    bool edit_room = true; // edit_budget grows to the blocks that `stamps` change
    bool editable = false; // the ground may change later, if it can
    std::vector<Export> exports;
    double export_texel_m = 0;     // width of a texel of the file's textures; 0: as fine as the maps are
    bool export_converged = false; // the mesh that the view would settle on, not the frame's
    bool export_quantised = false, export_meshopt = false, export_jpeg = false; // gltf::SnapshotOptions
    std::string render_folder;
    std::size_t render_every = 1;
    PictureMode mode = PictureMode::shaded;
    std::size_t verify_every = 0; // 0: never
    bool seeded = false;
    std::uint64_t seed = 0;
    std::optional<StillCamera> still;
};

} // namespace fjell::session
