// Profiles: what one kind of machine can afford, as TOML (profiles/*.toml).
//
// Every key has a default, a unit and a range; the shipped profiles say what each costs. Command-line flags win over
// the profile, the profile over the defaults. Failure: io::Failure with exit code 1 naming file, line and key.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/cut.h"
#include "fjell/gl/layers.h"
#include "fjell/gl/light.h"
#include "fjell/recursive.h"
#include "fjell/stream.h"

namespace fjell::session {

enum class Method : std::uint8_t { incremental, recursive };

// Keys of the method that is not chosen are kept for when --method chooses it.
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

// Ranges, for the command line too.
inline constexpr double least_threshold_px = 0.01, most_threshold_px = 1000;
inline constexpr double min_fov_deg = 1, max_fov_deg = 150;
inline constexpr std::uint32_t max_size_px = 16384, max_samples = 16;
inline constexpr std::uint32_t min_budget = 16, max_vertices = 1u << 27, max_indices = 1u << 30;
inline constexpr std::uint32_t max_triangles = 1u << 29, most_work = unlimited_work - 1;
inline constexpr std::uint32_t max_page_slots = 1u << 24, max_page_requests = 256, max_map_requests = 64;
inline constexpr std::uint32_t max_map_mb = 1u << 16, max_material_mb = 1u << 16, max_map_kb = 1u << 20,
                               min_tail_log2 = 2, most_decoders = 16;
inline constexpr std::uint32_t max_stream_pages = 4096, min_stream_tests = 1024;
inline constexpr double min_texel_px = 0.1, max_texel_px = 100, max_lookahead_s = 10, max_fade_s = 10;
inline constexpr double max_hysteresis = 10, min_morph_s = 0.01, max_morph_s = 10, most_time_us = 1e6;

// renamed: gets a line for each key that has the name it had before 0.3.
[[nodiscard]] Profile read_profile(const std::string& file, std::vector<std::string>* renamed = nullptr);
[[nodiscard]] Profile parse_profile(std::string_view text, const std::string& name,
                                    std::vector<std::string>* renamed = nullptr);

// What an update of the stream is given.
[[nodiscard]] StreamSettings stream_settings(const Profile& profile, double now_s);
// What an update of the incremental method is given.
[[nodiscard]] CutSettings cut_settings(const Profile& profile, double now_s);

} // namespace fjell::session
