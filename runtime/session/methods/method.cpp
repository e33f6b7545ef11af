#include "session/methods/method.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"

namespace fjell::session {

namespace {

constexpr std::uint64_t least_segment = 8, base_segments = 3; // what suits the most tiles, and create_cut() wants

// In the order of Method.
constexpr MethodFacts facts[] = {
    {.name = "incremental",
     .keys = UsedBy::incremental,
     .keeps_mesh = true,
     .vertex_bytes = cut_vertex_bytes,
     .gpu_vertex_bytes = sizeof(MeshVertex) + sizeof(MorphVertex),
     .gpu_triangle_bytes = 3 * sizeof(std::uint32_t),
     .vertices = [](const Profile& p) { return p.cut_budget.vertices; },
     .holds =
         [](const Profile& p, std::uint64_t x, std::uint64_t y) {
             return (x + 1) * (y + 1) <= p.cut_budget.vertices &&
                    least_segment * (x * y + base_segments) <= p.cut_budget.triangles;
         }},
    {.name = "recursive",
     .keys = UsedBy::recursive,
     .keeps_mesh = false,
     .vertex_bytes = recursive_vertex_bytes,
     .gpu_vertex_bytes = sizeof(MeshVertex),
     .gpu_triangle_bytes = sizeof(std::uint32_t),
     .vertices = [](const Profile& p) { return p.budget.vertices; },
     .holds = [](const Profile& p, std::uint64_t x,
                 std::uint64_t y) { return 4 * x * y <= p.budget.vertices && 9 * x * y <= p.budget.indices; }},
};

} // namespace

const MethodFacts& facts_of(Method method) {
    return facts[static_cast<int>(method)];
}

std::string fewer_tiles(const PackHeader& h, const Profile& profile) {
    for (std::uint32_t log2 = h.tile_log2 + 1; log2 <= static_cast<std::uint32_t>(max_tile_log2); ++log2) {
        const std::uint64_t x = ((h.columns - 2) >> log2) + 1, y = ((h.rows - 2) >> log2) + 1;
        if (facts_of(profile).holds(profile, x, y) && x * y <= profile.page_slots) // streamed or not
            return fmt::format(", or bake the terrain with --tile {}: {} tiles instead of {}", 1u << log2, x * y,
                               tiles_of(h));
    }
    return "";
}

void require(const Status& status) {
    if (!status.ok()) throw io::Failure(1, fmt::format("{}: {}", status.field, message(status.code)));
}

void require_budget(const Status& status, const FlightOptions& options, const PackHeader& header) {
    if (status.code == StatusCode::budget_too_small || status.code == StatusCode::out_of_range)
        throw io::Failure(
            1, fmt::format("{}: {} ([budget] of a --profile){}", status.field, message(status.code),
                           status.code == StatusCode::budget_too_small ? fewer_tiles(header, options.profile) : ""));
    require(status);
}

FrameEntry RunningMethod::replay(const RecordedFrame&) {
    throw io::Failure(1, fmt::format("a recording is not of the {} method", facts_of(kind).name));
}

} // namespace fjell::session
