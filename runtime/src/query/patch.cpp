// Patches of ground. Along a row the vertices of one step and kind lie side by side in their page (planar order), so a
// patch is read run by run: a page is looked up, and found to have stayed, once for up to 33 samples.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "fjell/query.h"
#include "query/ground.h"
#include "query/steady.h"

namespace fjell {

using namespace query;

namespace {

// Where a row of samples goes; holes: nullptr if nobody asks.
struct Row {
    float* heights_m;
    bool* holes;
};

// Samples of one tile in a row, 2^step_log2 apart.
struct Span {
    SampleIndex tile, first;
    std::uint32_t count;
    int step_log2;
};

class PatchReader {
public:
    explicit PatchReader(const TerrainData& terrain) : t_(terrain) {}

    void read(const Span& span, const Row& to) {
        const auto x = static_cast<std::uint32_t>(span.first.column - span.tile.column * t_.tree.side()),
                   y = static_cast<std::uint32_t>(span.first.row - span.tile.row * t_.tree.side());
        const int top = t_.tree.tile_log2, of_y = std::countr_zero(y | 1u << top);
        const bool on_step = std::countr_zero(x | y | 1u << span.step_log2) == span.step_log2;
        if (t_.pages.order != PageOrder::planar || !on_step || span.step_log2 >= top) return one_by_one(span, 0, 1, to);
        // By the largest power of 2 that divides its x, which says the vertex' step and, with y's, its kind.
        for (int z = span.step_log2; z < of_y; ++z) read_kind(span, {x, y}, {VertexKind::side_x, z, 1u << z}, to);
        if (of_y < top) {
            read_kind(span, {x, y}, {VertexKind::centre, of_y, 1u << of_y}, to);
            read_kind(span, {x, y}, {VertexKind::side_y, of_y, 0}, to);
        } else { // the tile's corners, which lie in no page
            const std::uint32_t apart = 1u << top;
            one_by_one(span, (-x & (apart - 1)) >> span.step_log2, apart >> span.step_log2, to);
        }
    }
    // One sample, for a place of the row.
    void read(SampleIndex tile, SampleIndex v, std::uint32_t place, const Row& to) {
        Reader reader(t_, tile.column, tile.row);
        read(reader, v, place, to);
    }
    [[nodiscard]] GroundPatch result() const { return {reported_m(t_, worst_m_), finest_}; }

private:
    struct InTile {
        std::uint32_t x, y;
    };
    // Vertices whose x, in the tile, is `odd` modulo 2^(z + 1).
    struct Kind {
        VertexKind kind;
        int z;
        std::uint32_t odd;
    };

    void read_kind(const Span& span, InTile from, const Kind& of, const Row& to) {
        const std::uint32_t apart = 2u << of.z, stride = apart >> span.step_log2;
        const StepLayout step = t_.pages.step_layout(of.z);
        const std::uint32_t last = (1u << step.pages_log2) - 1, j = from.y >> (of.z + 1);
        const int page_log2 = std::countr_zero(step.page_side);
        const std::uint32_t page_y = std::min(j >> page_log2, last), in_y = j - (page_y << page_log2);
        std::uint32_t place = ((of.odd - from.x) & (apart - 1)) >> span.step_log2;
        while (place < span.count) {
            const std::uint32_t i = (from.x + (place << span.step_log2)) >> (of.z + 1),
                                page_x = std::min(i >> page_log2, last), in_x = i - (page_x << page_log2);
            const PagePlace at{step.first_page + (page_y << step.pages_log2) + page_x,
                               step.offset + page_index<PageOrder::planar>(step.page_side, of.kind, in_x, in_y)};
            const std::uint32_t in_page = step.page_side + (page_x == last ? 1 : 0) - in_x,
                                count = std::min((span.count - place - 1) / stride + 1, in_page);
            if (!read_run(span.tile, at, count, place, stride, to)) one_by_one(span, place, stride, to, count);
            place += count * stride;
        }
    }

    bool read_run(SampleIndex tile, PagePlace at, std::uint32_t count, std::uint32_t place, std::uint32_t stride,
                  const Row& to) const {
        VertexRecord records[page_squares + 1];
        const std::uint32_t number = t_.tile_at(tile.column, tile.row);
        if (number == no_index) return false;
        const std::size_t page = std::size_t{number} * t_.pages_per_tile + at.page;
        PublishedPage found;
        if (!find_page(t_, page, found) || !read_records(t_, found, at.index, {records, count})) return false;
        for (std::uint32_t n = 0; n < count; ++n, place += stride) {
            to.heights_m[place] = t_.height_scale.height_m(found.base + records[n].height);
            if (to.holes != nullptr) to.holes[place] = is_void(records[n]);
        }
        return true;
    }

    void one_by_one(const Span& span, std::uint32_t place, std::uint32_t stride, const Row& to,
                    std::uint32_t count = max_patch_side) {
        Reader reader(t_, span.tile.column, span.tile.row);
        for (; place < span.count && count != 0; place += stride, --count)
            read(reader, {span.first.column + static_cast<std::int32_t>(place << span.step_log2), span.first.row},
                 place, to);
    }
    void read(Reader& reader, SampleIndex v, std::uint32_t place, const Row& to) {
        bool hole = false;
        if (const Sample s = reader.read(v); s.loaded) {
            to.heights_m[place] = t_.height_scale.height_m(s.steps);
            hole = s.hole;
        } else {
            const Found found =
                find_ground(t_, reader, {static_cast<double>(v.column), static_cast<double>(v.row)}, any_error);
            to.heights_m[place] = static_cast<float>(
                query::height_m(t_, found.plane.height({static_cast<double>(v.column), static_cast<double>(v.row)})));
            hole = found.hole;
            worst_m_ = std::max(worst_m_, found.error_m);
            finest_ = finest_ && found.error_m == 0;
        }
        if (to.holes != nullptr) to.holes[place] = hole;
    }

    const TerrainData& t_;
    double worst_m_ = 0;
    bool finest_ = true;
};

GroundPatch patch_now(const TerrainData& terrain, SampleIndex first, int step_log2, std::uint32_t side,
                      std::span<float> heights_m, std::span<bool> holes) {
    const Tree& tree = terrain.tree;
    const auto place = [&](std::int32_t from, std::uint32_t i) { return from + (std::int64_t{i} << step_log2); };
    const auto onto = [](std::int64_t at, std::int32_t last) {
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(at, 0, last));
    };
    const std::int32_t last_x = tree.columns() - 1;
    PatchReader reader(terrain);
    for (std::uint32_t j = 0; j < side; ++j) {
        const Row row{heights_m.data() + std::size_t{j} * side,
                      holes.empty() ? nullptr : holes.data() + std::size_t{j} * side};
        const std::int32_t y = onto(place(first.row, j), tree.rows() - 1);
        for (std::uint32_t i = 0; i < side;) {
            const std::int64_t at = place(first.column, i);
            const SampleIndex v{onto(at, last_x), y};
            const SampleIndex tile = tile_of(terrain, {static_cast<double>(v.column), static_cast<double>(v.row)});
            if (v.column != at) { // beyond the rim: those that stand on the same sample
                reader.read(tile, v, i, row);
                for (const std::uint32_t from = i++; i < side && onto(place(first.column, i), last_x) == v.column;
                     ++i) {
                    row.heights_m[i] = row.heights_m[from];
                    if (row.holes != nullptr) row.holes[i] = row.holes[from];
                }
                continue;
            }
            // As far as the tile goes.
            // It does not go beyond v where it is the neighbour of one that is not there.
            const std::int32_t end =
                tile.column == tree.tiles_x - 1 ? last_x : std::max((tile.column + 1) * tree.side() - 1, v.column);
            const std::uint32_t in_tile = (static_cast<std::uint32_t>(end - v.column) >> step_log2) + 1;
            const Span span{tile, v, std::min(in_tile, side - i), step_log2};
            reader.read(span, {row.heights_m + i, row.holes != nullptr ? row.holes + i : nullptr});
            i += span.count;
        }
    }
    return reader.result();
}

} // namespace

GroundPatch ground_patch(const Terrain& handle, SampleIndex first, int step_log2, std::uint32_t side,
                         std::span<float> heights_m, std::span<bool> holes) {
    const std::size_t count = std::size_t{side} * side;
    if (side < 2 || side > max_patch_side || step_log2 < 0 || step_log2 > max_tile_log2 || heights_m.size() < count ||
        (!holes.empty() && holes.size() < count))
        return {INFINITY, false};
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {INFINITY, false};
    return steady(*data, [&] { return patch_now(*data, first, step_log2, side, heights_m, holes); });
}

} // namespace fjell
