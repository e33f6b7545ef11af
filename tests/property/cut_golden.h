// One fixed flight over one fixed terrain, and what it must come to on every compiler (invariant 8).
//
// Without libm where decisions are made: eyes, thresholds and lambda are made of sums and products; heights of
// integers. A hash over the triangles of every frame, sorted, and over the work done: both are part of the promise.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "cut/evaluate.h"
#include "cut/state.h"
#include "fjell/cut.h"
#include "shared/terrain_data.h"

namespace fjell::test {

inline constexpr std::int32_t golden_columns = 150, golden_rows = 133;
inline constexpr int golden_tile_log2 = 5;

class Fnv {
public:
    void add(std::uint64_t value) {
        for (int byte = 0; byte < 8; ++byte, value >>= 8) hash_ = (hash_ ^ (value & 0xff)) * 0x100000001b3u;
    }
    [[nodiscard]] std::uint64_t value() const { return hash_; }

private:
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

class Lcg { // the same numbers everywhere
public:
    [[nodiscard]] std::uint32_t next() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<std::uint32_t>(state_ >> 33);
    }
    // -1 to 1 in steps of 2^-20
    [[nodiscard]] double part() { return (static_cast<double>(next() % (1u << 21)) - (1 << 20)) / (1 << 20); }

private:
    std::uint64_t state_ = 2024;
};

// Metres, whole: hills of folded ramps, and noise.
[[nodiscard]] inline std::vector<float> golden_heights() {
    std::vector<float> heights;
    Lcg random;
    const auto fold = [](std::int32_t value, std::int32_t length) { // a zigzag
        const std::int32_t at = value % (2 * length);
        return at < length ? at : 2 * length - at;
    };
    for (std::int32_t y = 0; y < golden_rows; ++y)
        for (std::int32_t x = 0; x < golden_columns; ++x)
            heights.push_back(static_cast<float>(8 * fold(x + 2 * y, 64) + 3 * fold(3 * x - y + 500, 37) +
                                                 static_cast<std::int32_t>(random.next() % 16)));
    return heights;
}

// Every record of the terrain, page by page: when this differs, the baker or the format did it and not the cut.
[[nodiscard]] inline std::uint64_t golden_terrain_hash(const Terrain& terrain) {
    Fnv hash;
    for (std::uint32_t page = 0; page < terrain.page_count(); ++page)
        for (std::uint32_t i = 0; i < data_of(terrain).pages.page_vertices(page % terrain.pages_per_tile()); ++i) {
            const VertexRecord r =
                data_of(terrain)
                    .records[std::size_t{data_of(terrain).page_table[page].slot} * data_of(terrain).page_capacity + i];
            hash.add(static_cast<std::uint64_t>(r.height) << 16 | static_cast<std::uint64_t>(r.error) << 8 | r.radius);
        }
    return hash.value();
}

inline void add_triangles(Fnv& hash, const CutState& s) {
    using Key = std::array<std::uint64_t, 3>;
    std::vector<Key> keys;
    for (std::uint32_t tile = 0; tile < s.pages.grid.terrain->tile_count(); ++tile) {
        std::uint32_t count = s.mesh.tiles[tile].in_last;
        for (std::uint32_t segment = s.mesh.tiles[tile].last_segment; segment != no_index;
             segment = s.mesh.segment_below[segment]) {
            for (std::uint32_t i = 0; i < count; ++i) {
                Key key{};
                for (std::uint32_t n = 0; n < 3; ++n) {
                    const MeshVertex& v =
                        s.mesh.vertices[s.mesh.indices[std::size_t{(segment << s.mesh.segment_log2) + i} * 3 + n]];
                    key[n] = static_cast<std::uint64_t>(v.row) << 32 | static_cast<std::uint64_t>(v.column);
                }
                keys.push_back(key);
            }
            count = 1u << s.mesh.segment_log2;
        }
    }
    std::sort(keys.begin(), keys.end());
    for (const Key& key : keys)
        for (const std::uint64_t corner : key) hash.add(corner);
}

struct Golden {
    std::uint64_t triangles = 0, work = 0;
    std::uint32_t exhausted = 0; // any bit, in any frame
    bool ok = false;
};

// The flight. block: cut_bytes(terrain, golden_budget()), aligned to 64.
[[nodiscard]] inline CutBudget golden_budget(const Terrain& terrain) {
    CutBudget budget;
    budget.vertices = 6000;
    budget.segment_triangles = 16;
    budget.triangles = 16 * (terrain.tile_count() + 900);
    budget.views = 2;
    return budget;
}
[[nodiscard]] inline Golden fly_golden(const Terrain& terrain, std::span<std::byte> block, bool scalar) {
    Golden result;
    LiveCut cut;
    if (!create_cut(terrain, golden_budget(terrain), block, cut).ok()) return result;
    if (scalar) {
        data_of(cut).views.evaluate = evaluate_scalar;
        data_of(cut).views.worst_px = worst_px_scalar;
        data_of(cut).work.schedule.vectors = scalar_ticks;
    }
    Fnv triangles, work;
    Lcg random;
    View views[2];
    Vec3 eye{700, 900, 800};
    for (int frame = 0; frame < 240; ++frame) {
        // Walking, running, then a jump; the threshold in steps, items now and then short.
        const double stride = frame % 60 < 40 ? 1.37 : 23.1;
        eye = eye + Vec3{random.part(), random.part() * 0.5, random.part()} * stride;
        if (frame % 80 == 79) eye = {random.part() * 800 + 700, random.part() * 200 + 500, random.part() * 700 + 600};
        views[0].eye_m = eye;
        views[1].eye_m = Vec3{1400, 300, 1300} - eye * 0.25;
        CutSettings settings;
        settings.max_error_px = 0.75 + 3.25 * ((frame / 30) % 4);
        if (frame >= 180) settings.max_error_px = 0.125;
        settings.hysteresis = frame % 120 < 60 ? 0 : 0.25;
        settings.max_work = frame % 7 < 3 ? 150 : unlimited_work;
        CutReport report;
        if (!update_cut(cut, {views, frame % 50 < 30 ? 1u : 2u}, settings, report).ok()) return result;
        result.exhausted |= report.exhausted;
        for (const std::uint64_t count : {report.evaluations, report.activations, report.deactivations, report.waiting,
                                          report.blocked, report.triangles, report.exhausted})
            work.add(count);
        add_triangles(triangles, data_of(cut));
    }
    result.triangles = triangles.value();
    result.work = work.value();
    result.ok = true;
    return result;
}

} // namespace fjell::test
