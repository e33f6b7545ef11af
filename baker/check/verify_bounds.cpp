// In metres and doubles where the baker counts codes: what a reader makes of the bound is what must hold.
#include "baker/check/verify_bounds.h"
#include "pack/terrain_data.h"

#include <algorithm>

#include <fmt/format.h>

namespace fjell::baker {

namespace {

// A page's own extremes, the closed borders included.
struct PageExtremes {
    std::int64_t least = max_height_steps, most = 0;
    double error_m = 0, radius_m = 0;
};

PageExtremes extremes_of(const Terrain& terrain, std::uint32_t tile, std::uint32_t page) {
    const PageEntry entry = data_of(terrain).page_table[std::size_t{tile} * terrain.pages_per_tile() + page];
    const VertexRecord* const records =
        data_of(terrain).records + std::size_t{entry.slot} * data_of(terrain).page_capacity;
    PageExtremes e;
    for (std::uint32_t i = 0; i < data_of(terrain).pages.page_vertices(page); ++i) {
        const std::int64_t steps = std::int64_t{entry.base} + records[i].height;
        e.least = std::min(e.least, steps);
        e.most = std::max(e.most, steps);
        e.error_m = std::max(e.error_m, static_cast<double>(data_of(terrain).errors.metres[records[i].error]));
        const Coord c = data_of(terrain).pages.coord({page, i});
        if (data_of(terrain).tree.is_corner(c)) continue; // neither wanted nor unwanted: it is always there
        const float unit_m = terrain.header().level_radius_m[data_of(terrain).tree.level(c)];
        const double radius_m = unit_m * data_of(terrain).radii.factor[records[i].radius & (radius_codes - 1)];
        e.radius_m = std::max(e.radius_m, radius_m);
    }
    return e;
}

} // namespace

std::string wrong_bound(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page) {
    const PackHeader& h = pack.header;
    const PageBound b = pack.entry(chunk_index(h, {ChunkKind::geometry, tile, page})).bound;
    const PageExtremes e = extremes_of(terrain, tile, page);
    const std::int64_t unit = std::int64_t{1} << bound_shift(h);
    const std::int64_t low = b.low * unit, high = (b.high + std::int64_t{1}) * unit - 1;
    const auto wrong = [&](const char* what, double said, double is) {
        return fmt::format("page {} of tile {}: the directory bounds its {} by {}, and it is {}", page, tile, what,
                           said, is);
    };
    if (low > e.least || low + unit <= e.least)
        return wrong("lowest height step", static_cast<double>(low), static_cast<double>(e.least));
    if (high < e.most || high - unit >= e.most)
        return wrong("highest height step", static_cast<double>(high), static_cast<double>(e.most));
    const double error_m = data_of(terrain).errors.metres[b.error];
    if (error_m != e.error_m) return wrong("largest error in metres", error_m, e.error_m);
    const float unit_m = h.level_radius_m[bound_level(data_of(terrain).pages, page)];
    const double radius_m = unit_m * data_of(terrain).radii.factor[b.radius];
    if (radius_m < e.radius_m ||
        (b.radius > 0 && static_cast<double>(unit_m * data_of(terrain).radii.factor[b.radius - 1]) >= e.radius_m))
        return wrong("largest radius in metres", radius_m, e.radius_m);
    return "";
}

} // namespace fjell::baker
