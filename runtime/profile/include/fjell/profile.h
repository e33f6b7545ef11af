// Profiles: what one kind of machine can afford, as TOML (profiles/*.toml), tuned in the editor, and what a host makes
// of one.
//
// Every key has a default, a unit and a range; the shipped profiles say what each costs. fjell/profile/keys.h has them
// as data. Ownership: plain values. Thread: any. Failure: io::Failure with exit code 1 naming file, line and key; a key
// that is not known is one.
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

// Keys of the method that is not chosen are kept for when it is.
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
    double fov_deg = 45;                            // [view] fov_deg: vertical
    std::uint32_t samples = 4;                      // [view] samples: a pixel, fewer where the GPU has no more
    gl::LightSettings light;                        // [light]
    gl::LayerSettings layers{.on = true};           // [layers]: where there are files of them
    std::uint64_t material_bytes = 64u << 20;       // [layers] material_mb
};

// From a file, or from text in memory; name: for messages. renamed: gets a line for each key that has the name it had
// before 0.3.
[[nodiscard]] Profile read_profile(const std::string& file, std::vector<std::string>* renamed = nullptr);
[[nodiscard]] Profile parse_profile(std::string_view text, const std::string& name,
                                    std::vector<std::string>* renamed = nullptr);
// A key by its name, "refine.max_error_px", and a value as TOML writes it: what a host overrides. Failure (1) for
// another key, or a value out of its range.
// Example:
//     fjell::set_profile_key(profile, "refine.max_error_px", "2");
//     fjell::io::LiveTerrain ground(path, fjell::live_options(profile));
void set_profile_key(Profile& profile, std::string_view key, std::string_view value);

// What an update of the stream is given.
[[nodiscard]] StreamSettings stream_settings(const Profile& profile, double now_s);
// What an update of the incremental method is given.
[[nodiscard]] CutSettings cut_settings(const Profile& profile, double now_s);
// What a LiveTerrain is opened with: budgets, and the settings to begin with. Horizon maps where light.shadows are on.
// Failure (1) for a profile of the recursive method: a LiveTerrain is the incremental one.
[[nodiscard]] io::LiveOptions live_options(const Profile& profile);

} // namespace fjell
FJELL_API_END
