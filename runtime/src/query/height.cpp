#include "query/ground.h"

#include <cmath>
#include <cstdint>

#include "fjell/query.h"
#include "query/steady.h"

namespace fjell {

using namespace query;

namespace {

// Into [0, last]; NaN too.
double onto(double value, double last) {
    return value > 0 ? std::min(value, last) : 0;
}

GroundHeight height_now(const TerrainData& terrain, double x_m, double z_m, float accurate_m) {
    const double column = x_m / terrain.header.spacing_m[0], row = z_m / terrain.header.spacing_m[1];
    const Point p{onto(column, terrain.tree.columns() - 1), onto(row, terrain.tree.rows() - 1)};
    const SampleIndex tile = tile_of(terrain, p);
    Reader reader(terrain, tile.column, tile.row);
    const Found found = find_ground(terrain, reader, p, accurate_code(terrain, accurate_m));
    GroundHeight out;
    out.inside = p.x == column && p.y == row;
    out.hole = found.hole;
    out.finest = found.finest;
    out.height_m = query::height_m(terrain, found.plane.height(p));
    out.normal = normal_of(terrain, found.plane);
    out.error_m = reported_m(terrain, found.error_m);
    return out;
}

} // namespace

GroundHeight ground_height(const Terrain& handle, double x_m, double z_m, float accurate_m) {
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {};
    return steady(*data, [&] { return height_now(*data, x_m, z_m, accurate_m); });
}

} // namespace fjell
