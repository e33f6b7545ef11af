#include "baker/bake/bake.h"

#include <algorithm>

#include "baker/bake/pipeline.h"
#include "baker/read/dem_source.h"

namespace fjell::baker {

namespace {

void check(const BakeOptions& options) {
    if (!(options.nesting >= 0.001 && options.nesting <= 1))
        throw Failure(2,
                      "--nesting must lie in 0.001..1: with less, spheres that touch do not nest in float arithmetic "
                      "and the mesh cracks");
    if (options.tile_log2 && (options.tile_log2 < min_tile_log2 || options.tile_log2 > max_tile_log2))
        throw Failure(2, "--tile must be a power of two from 2 to 4096, or auto");
}

} // namespace

int auto_tile_log2(std::int32_t columns, std::int32_t rows) {
    int log2 = 9;
    while (log2 > min_tile_log2 && (1 << (log2 - 1)) >= std::max(columns, rows) - 1) --log2;
    const auto tiles = [&] {
        const Tree tree = Tree::covering(columns, rows, log2);
        return static_cast<std::int64_t>(tree.tiles_x) * tree.tiles_y;
    };
    while (log2 < max_tile_log2 && tiles() > 1024) ++log2;
    return log2;
}

BakeSummary bake(const HeightSource& source, const BakeOptions& options, const std::string& out_path) {
    check(options);
    return Pipeline(source, options, out_path).run();
}

BakeSummary bake(Dem dem, const BakeOptions& options, const std::string& out_path) {
    return bake(DemSource(std::move(dem)), options, out_path);
}

} // namespace fjell::baker
