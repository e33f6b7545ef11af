// Profiles: budgets and thresholds for one kind of machine, as TOML (profiles/*.toml). The editor tunes them, and a
// host opens a terrain with one.
//
// Every key has a default, a unit and a range. The profiles in profiles/ say what each key costs, and
// fjell/profile/keys.h has the keys as data. Ownership: plain values. Thread: any. Failure: io::Failure with exit code
// 1 that names file, line and key. An unknown key is a failure too.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/gl/layers.h"
#include "fjell/gl/light.h"
#include "fjell/io/live_terrain.h"
#include "fjell/recursive.h"
#include "fjell/stream.h"

FJELL_API_BEGIN
namespace fjell {

enum class Method : std::uint8_t { incremental, recursive };

// A profile. Keys of the method that is not chosen are kept too.
struct Profile {
    Method method = Method::incremental; // [refine] method
    RefineSettings refine;               // [refine] max_error_px, corner_safe; recursive: metric, cull, topology
    CutSettings cut;                     // [refine] hysteresis, offscreen_factor, morph...; [budget] max_work...
    RecursiveBudget budget;              // [budget] vertices, indices
    CutBudget cut_budget;                // [budget] vertices, triangles, views, workers
    std::uint32_t page_slots = 8192;     // [stream] page_slots
    StreamBudget stream_budget;          // [stream] page_requests, map_requests, map_mb, tail_log2, decoders
    StreamSettings stream;               // [stream] texel_px, lookahead_s, fade_s, pages, tests, map_kb
    std::uint32_t width_px = 1280, height_px = 720; // [view] width_px, height_px
    double fov_deg = 45;                            // [view] fov_deg: vertical field of view
    std::uint32_t samples = 4;                      // [view] samples a pixel; fewer if the GPU has no more
    gl::LightSettings light;                        // [light]
    gl::LayerSettings layers{.on = true};           // [layers], if the pack or a file has layers
    std::uint64_t material_bytes = 64u << 20;       // [layers] material_mb
};

// Reads a profile from a file, or from text in memory. name: for messages. renamed: receives a line for each key that
// has a name from before 0.3.
[[nodiscard]] Profile read_profile(const std::string& file, std::vector<std::string>* renamed = nullptr);
[[nodiscard]] Profile parse_profile(std::string_view text, const std::string& name,
                                    std::vector<std::string>* renamed = nullptr);
// Sets one key by its name, e.g. "refine.max_error_px", to a value as TOML writes it. Failure (1) for an unknown key or
// a value out of its range.
// Example:
//     fjell::set_profile_key(profile, "refine.max_error_px", "2");
//     fjell::io::LiveTerrain ground(path, fjell::live_options(profile));
void set_profile_key(Profile& profile, std::string_view key, std::string_view value);

// The settings for an update of the stream.
[[nodiscard]] StreamSettings stream_settings(const Profile& profile, double now_s);
// The settings for an update of the incremental method.
[[nodiscard]] CutSettings cut_settings(const Profile& profile, double now_s);
// The options to open a LiveTerrain with: budgets, and the first settings. Horizon maps are loaded if light.shadows is
// on. Failure (1) for a profile of the recursive method, which a LiveTerrain does not use.
[[nodiscard]] io::LiveOptions live_options(const Profile& profile);

} // namespace fjell
FJELL_API_END
