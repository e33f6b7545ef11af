// What the host sees of the mesh.
#include <algorithm>
#include <cmath>

#include "cut/state.h"
#include "fjell/compact.h"
#include "fjell/pack.h"
#include "shared/compiler.h"

namespace fjell {

CutMesh cut_mesh(LiveCut cut) {
    const CutState* const found = find_cut(cut);
    if (found == nullptr) return {};
    const CutState& s = *found;
    CutMesh out;
    const std::size_t triangles = std::size_t{s.mesh.segment_count} << s.mesh.segment_log2;
    out.mesh = {Topology::triangles,
                {s.mesh.vertices, s.mesh.capacity},
                {s.mesh.indices, triangles * 3},
                {s.mesh.ranges, s.mesh.range_count},
                0,
                s.mesh.capacity};
    if (s.mesh.morph != nullptr) out.morph = {s.mesh.morph, s.mesh.capacity};
    out.frame = s.morphing.now;
    return out;
}

CutChanges cut_take_changes(LiveCut cut) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return {};
    CutState& s = *found;
    if (s.mesh.dirty_taken) return {};
    const bool earlier =
        !s.mesh.untaken_taken && s.mesh.untaken_vertices.word_count + s.mesh.untaken_triangles.word_count != 0;
    if (earlier) {
        s.mesh.dirty_vertices.move_to(s.mesh.untaken_vertices);
        s.mesh.dirty_triangles.move_to(s.mesh.untaken_triangles);
        s.mesh.untaken_taken = true;
    }
    s.mesh.dirty_taken = true;
    const DirtyBits& v = earlier ? s.mesh.untaken_vertices : s.mesh.dirty_vertices;
    const DirtyBits& t = earlier ? s.mesh.untaken_triangles : s.mesh.dirty_triangles;
    const std::size_t triangles = std::size_t{s.mesh.segment_count} << s.mesh.segment_log2;
    return {{v.bits, s.mesh.capacity / 64 + 1},
            {t.bits, triangles / 64 + 1},
            {v.words, v.word_count},
            {t.words, t.word_count}};
}

// --- compact vertices

namespace {

constexpr float least_length_m = 0x1p-10f, least_rise_m = 0x1p-15f; // below the smallest that is told from 0

static_assert(max_tile_log2 < 16, "16 bits tell the columns of a tile apart");

// 11 bits of mantissa, rounded up: by a 2048th at most, up to 2^22; less than 2^-10 becomes that.
std::uint16_t length_up(float positive_m) {
    const std::uint32_t above =
        bits_as<std::uint32_t>(std::max(positive_m, least_length_m)) - bits_as<std::uint32_t>(least_length_m);
    return static_cast<std::uint16_t>(std::min((above + 0xfff) >> 12, 0xffffu));
}

// An IEEE half, rounded towards 0: by a 1024th at most; what is smaller than 2^-14 becomes 0. Of a double, which holds
// the difference of two heights: a float might have rounded it up.
std::uint16_t half_towards_zero(double value) {
    constexpr std::uint64_t most = 0x7bff, least_bits = bits_as<std::uint64_t>(double{least_rise_m});
    const std::uint64_t sign = value < 0 ? 0x8000 : 0;
    if (!(std::abs(value) >= 0x1p-14)) return static_cast<std::uint16_t>(sign);
    return static_cast<std::uint16_t>(sign |
                                      std::min((bits_as<std::uint64_t>(std::abs(value)) - least_bits) >> 42, most));
}

std::uint16_t steps_up(float activated_s) {
    // Between 0 and a turn, or activated_long_ago_s; what is neither has been active for long.
    if (!(activated_s >= 0 && activated_s <= morph_clock_s)) return compact_activated_long_ago;
    const auto steps = static_cast<std::uint16_t>(static_cast<std::uint32_t>(std::ceil(activated_s * compact_steps_s)));
    return steps == compact_activated_long_ago ? std::uint16_t{0} : steps; // a step later
}

} // namespace

void compact_vertices(std::span<const MeshVertex> vertices, std::span<const MorphVertex> morphs,
                      std::span<CompactVertex> to) {
    const std::size_t count = std::min({vertices.size(), morphs.empty() ? vertices.size() : morphs.size(), to.size()});
    for (std::size_t i = 0; i < count; ++i) {
        const MeshVertex& vertex = vertices[i];
        const MorphVertex morph = morphs.empty() ? MorphVertex{vertex.height_m, 0, 0, activated_long_ago_s} : morphs[i];
        to[i] = {static_cast<std::uint16_t>(vertex.column),
                 static_cast<std::uint16_t>(vertex.row),
                 vertex.height_m,
                 half_towards_zero(double{morph.morph_from_m} - double{vertex.height_m}),
                 steps_up(morph.activated_s),
                 length_up(morph.error_m),
                 length_up(morph.radius_m)};
    }
}

void compact_indices(std::span<const std::uint32_t> indices, std::span<std::uint16_t> to) {
    const std::size_t count = std::min(indices.size(), to.size());
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<std::uint16_t>(indices[i]);
}

// Rounding moves start = radius + error * start_per_error out by start / 2048 at most, which is start / 2048 / (error *
// (start_per_error - full_per_error)) of the way. The height moves by error over the whole way. A metre at distance d
// is full_per_error / d thresholds, and d is at least radius + error * full_per_error, which is at least start *
// full_per_error / start_per_error. The product: start_per_error / (start_per_error - full_per_error) / 2048. Beside
// it, a 1024th for the flat height.
double compact_share(const MorphView& view) {
    const double band = double{view.start_per_error} - double{view.full_per_error};
    return band > 0 ? 0x1p-11 * double{view.start_per_error} / band + 0x1p-10
                    : 0; // without a band nothing morphs by distance
}

float compact_rise_m(std::uint16_t rise) {
    const std::uint32_t size = rise & 0x7fffu;
    const float value = size == 0 ? 0 : bits_as<float>((size << 13) + bits_as<std::uint32_t>(least_rise_m));
    return (rise & 0x8000) != 0 ? -value : value;
}
float compact_length_m(std::uint16_t error_or_radius) {
    return bits_as<float>((std::uint32_t{error_or_radius} << 12) + bits_as<std::uint32_t>(least_length_m));
}

} // namespace fjell
