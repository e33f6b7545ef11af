#include "fjell/pages.h"

#include <algorithm>

#include "shared/terrain_data.h"

namespace fjell {

std::uint32_t pages_per_tile(const PackHeader& header) {
    return pages_of(header).pages_per_tile();
}
int page_step_log2(const PackHeader& header, std::uint32_t page) {
    return pages_of(header).page_step_log2(page);
}
std::uint32_t page_at(const PackHeader& header, std::uint32_t step_log2, std::uint32_t x, std::uint32_t y) {
    constexpr std::uint32_t first = page_squares_log2 + 1;
    if (header.order == PageOrder::linear || header.tile_log2 < first || step_log2 > header.tile_log2 - first) return 0;
    const PageLayout pages = pages_of(header);
    const std::uint32_t shift = step_log2 + first, last = (1u << (header.tile_log2 - shift)) - 1;
    return pages.page_at(static_cast<int>(step_log2), std::min(x >> shift, last), std::min(y >> shift, last));
}
std::uint32_t page_of(const PackHeader& header, std::uint32_t x, std::uint32_t y) {
    const PageLayout pages = pages_of(header);
    return pages.place(std::min(x, pages.side()), std::min(y, pages.side())).page;
}

bool page_loaded(const Terrain& terrain, std::uint32_t tile, std::uint32_t page) {
    const TerrainData* const t = find(terrain);
    return t != nullptr && tile < t->tile_count() && page < t->pages_per_tile &&
           t->page_table[std::size_t{tile} * t->pages_per_tile + page].slot != no_index;
}
std::uint64_t page_changes(const Terrain& terrain) {
    const TerrainData* const t = find(terrain);
    return t != nullptr ? t->changes : 0;
}
Status set_missing_px(const Terrain& terrain, double missing_px) {
    TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    if (!(missing_px >= 0)) return {StatusCode::out_of_range, "missing_px"};
    t->missing_px = missing_px;
    t->sought_px = 0;
    return {};
}

TerrainVertex terrain_vertex(const Terrain& terrain, SampleIndex sample) {
    const TerrainData* const t = find(terrain);
    if (t == nullptr || !t->tree.contains(sample)) return {};
    const TerrainData::Vertex v = t->vertex(sample);
    return {v.loaded, v.hole, v.in_tile, v.height_m, v.error_m, v.radius_m};
}
double terrain_height_m(const Terrain& terrain, double x_m, double z_m) {
    const TerrainData* const t = find(terrain);
    return t != nullptr ? t->ground_m(x_m, z_m) : 0;
}

} // namespace fjell
