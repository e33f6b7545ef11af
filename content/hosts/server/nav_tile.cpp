#include "nav_tile.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <DetourNavMesh.h>
#include <DetourNavMeshBuilder.h>
#include <Recast.h>

namespace server {

namespace {

constexpr int voxels_a_cell = 2, radius = 1, height = 10, climb = 3; // the last three in voxels: an agent
constexpr int border = radius + 3;                                   // of voxels: Recast looks beyond the tile
constexpr int border_cells = border / voxels_a_cell;
constexpr int side = tile_cells + 2 * border_cells + 1; // samples

float voxel_m(const fjell::Terrain& terrain) { // across
    return terrain.spacing_x_m() / voxels_a_cell;
}
float voxel_up_m(const fjell::Terrain& terrain) {
    return 0.4f * voxel_m(terrain);
}

// The same triangles as the full-resolution surface has (hosts/physics/ground_shape.cpp says which).
struct Triangles {
    std::vector<float> vertices;
    std::vector<int> indices;
    fjell::GroundPatch patch;
};
fjell::SampleIndex first_sample(int x, int z) {
    return {x * tile_cells - border_cells, z * tile_cells - border_cells};
}
Triangles triangles_of(const fjell::Terrain& terrain, fjell::SampleIndex first) {
    float heights_m[side * side];
    bool holes[side * side];
    Triangles out;
    out.patch = fjell::ground_patch(terrain, first, 0, side, heights_m, holes);
#ifdef PLANT_CLOSED_HOLES
    std::fill(std::begin(holes), std::end(holes), false);
#endif
    for (int i = 0; i < side * side; ++i)
        out.vertices.insert(out.vertices.end(), {float(first.column + i % side) * terrain.spacing_x_m(), heights_m[i],
                                                 float(first.row + i / side) * terrain.spacing_z_m()});
    const auto add = [&](int a, int b, int c) {
        if (!holes[a] && !holes[b] && !holes[c]) out.indices.insert(out.indices.end(), {a, b, c});
    };
    for (int y = 0; y < side - 1; ++y)
        for (int x = 0; x < side - 1; ++x) {
            const int nw = y * side + x, ne = nw + 1, sw = nw + side, se = sw + 1;
            if (((first.column + x + first.row + y) & 1) == 0)
                add(nw, sw, se), add(nw, se, ne);
            else
                add(nw, sw, ne), add(ne, sw, se);
        }
    return out;
}

template <auto free>
struct Freed {
    void operator()(auto* object) const { free(object); }
};

struct Meshes {
    std::unique_ptr<rcPolyMesh, Freed<rcFreePolyMesh>> polygons{rcAllocPolyMesh()};
    std::unique_ptr<rcPolyMeshDetail, Freed<rcFreePolyMeshDetail>> detail{rcAllocPolyMeshDetail()};
};

rcConfig config_of(const fjell::Terrain& terrain, int x, int z, const Triangles& ground) {
    rcConfig c{};
    c.cs = voxel_m(terrain), c.ch = voxel_up_m(terrain);
    c.borderSize = border;
    c.width = c.height = tile_cells * voxels_a_cell + 2 * border;
    c.walkableSlopeAngle = 40;
    c.walkableHeight = height, c.walkableClimb = climb, c.walkableRadius = radius;
    c.maxEdgeLen = 24, c.maxSimplificationError = 1.3f;
    c.minRegionArea = 16, c.mergeRegionArea = 400, c.maxVertsPerPoly = DT_VERTS_PER_POLYGON;
    c.detailSampleDist = 4 * c.cs, c.detailSampleMaxError = c.ch;
    rcCalcBounds(ground.vertices.data(), side * side, c.bmin, c.bmax);
    for (const auto& [axis, tile] : {std::pair{0, x}, {2, z}}) {
        c.bmin[axis] = float(tile * tile_cells) * terrain.spacing_x_m() - float(border) * c.cs;
        c.bmax[axis] = c.bmin[axis] + float(c.width) * c.cs;
    }
    return c;
}

// As Recast's own sample does it. False: no memory.
bool build(const rcConfig& c, const Triangles& ground, Meshes& out) {
    rcContext quiet(false);
    std::unique_ptr<rcHeightfield, Freed<rcFreeHeightField>> solid(rcAllocHeightfield());
    std::unique_ptr<rcCompactHeightfield, Freed<rcFreeCompactHeightfield>> open(rcAllocCompactHeightfield());
    std::unique_ptr<rcContourSet, Freed<rcFreeContourSet>> contours(rcAllocContourSet());
    if (!solid || !open || !contours || !out.polygons || !out.detail) return false;
    const int count = int(ground.indices.size() / 3), vertices = side * side;
    std::vector<unsigned char> areas(std::size_t(count), RC_NULL_AREA);
    rcMarkWalkableTriangles(&quiet, c.walkableSlopeAngle, ground.vertices.data(), vertices, ground.indices.data(),
                            count, areas.data());
    if (!rcCreateHeightfield(&quiet, *solid, c.width, c.height, c.bmin, c.bmax, c.cs, c.ch)) return false;
    if (!rcRasterizeTriangles(&quiet, ground.vertices.data(), vertices, ground.indices.data(), areas.data(), count,
                              *solid, c.walkableClimb))
        return false;
    rcFilterLedgeSpans(&quiet, c.walkableHeight, c.walkableClimb, *solid);
    return rcBuildCompactHeightfield(&quiet, c.walkableHeight, c.walkableClimb, *solid, *open) &&
           rcErodeWalkableArea(&quiet, c.walkableRadius, *open) &&
           rcBuildRegionsMonotone(&quiet, *open, c.borderSize, c.minRegionArea, c.mergeRegionArea) &&
           rcBuildContours(&quiet, *open, c.maxSimplificationError, c.maxEdgeLen, *contours) &&
           rcBuildPolyMesh(&quiet, *contours, c.maxVertsPerPoly, *out.polygons) &&
           rcBuildPolyMeshDetail(&quiet, *out.polygons, *open, c.detailSampleDist, c.detailSampleMaxError, *out.detail);
}

bool to_detour(const rcConfig& c, int x, int z, const Meshes& meshes, NavTile& tile) {
    rcPolyMesh& polygons = *meshes.polygons;
    if (polygons.npolys == 0) return true;
    std::fill_n(polygons.flags, polygons.npolys, static_cast<unsigned short>(1)); // who may walk: all
    dtNavMeshCreateParams p{};
    p.verts = polygons.verts, p.vertCount = polygons.nverts;
    p.polys = polygons.polys, p.polyAreas = polygons.areas, p.polyFlags = polygons.flags;
    p.polyCount = polygons.npolys, p.nvp = polygons.nvp;
    p.detailMeshes = meshes.detail->meshes, p.detailVerts = meshes.detail->verts;
    p.detailVertsCount = meshes.detail->nverts;
    p.detailTris = meshes.detail->tris, p.detailTriCount = meshes.detail->ntris;
    p.walkableHeight = float(c.walkableHeight) * c.ch, p.walkableClimb = float(c.walkableClimb) * c.ch;
    p.walkableRadius = float(c.walkableRadius) * c.cs;
    p.tileX = x, p.tileY = z;
    std::copy_n(polygons.bmin, 3, p.bmin);
    std::copy_n(polygons.bmax, 3, p.bmax);
    p.cs = c.cs, p.ch = c.ch, p.buildBvTree = true;
    return dtCreateNavMeshData(&p, &tile.data, &tile.bytes);
}

// A triangle of the mesh lies over a place.
bool covers(const rcPolyMeshDetail& mesh, double x_m, double z_m) {
    for (int i = 0; i < mesh.nmeshes; ++i) {
        const unsigned* const part = &mesh.meshes[4 * i]; // first vertex, vertices, first triangle, triangles
        for (unsigned t = part[2]; t < part[2] + part[3]; ++t) {
            bool left = true, right = true;
            for (int k = 0; k < 3; ++k) {
                const float* const a = &mesh.verts[3 * (part[0] + mesh.tris[4 * t + unsigned(k)])];
                const float* const b = &mesh.verts[3 * (part[0] + mesh.tris[4 * t + unsigned(k + 1) % 3])];
                const double turn =
                    double(b[0] - a[0]) * (z_m - double(a[2])) - double(b[2] - a[2]) * (x_m - double(a[0]));
                left = left && turn > 0;
                right = right && turn < 0;
            }
            if (left || right) return true;
        }
    }
    return false;
}

void look(const Meshes& meshes, int x, int z, const fjell::Terrain& whole, NavTile& tile) {
    for (int i = 0; i < meshes.detail->nverts; ++i) {
        const float* const v = &meshes.detail->verts[3 * i];
        const fjell::GroundHeight full = fjell::ground_height(whole, double(v[0]), double(v[2]));
        if (full.inside && !full.hole) tile.off_m = std::max(tile.off_m, std::abs(double(v[1]) - full.height_m));
    }
    float heights_m[tile_cells * tile_cells];
    bool holes[tile_cells * tile_cells];
    const fjell::SampleIndex first{x * tile_cells, z * tile_cells};
    (void)fjell::ground_patch(whole, first, 0, tile_cells, heights_m, holes);
    for (int i = 0; i < tile_cells * tile_cells; ++i)
        if (holes[i])
            tile.in_hole =
                tile.in_hole || covers(*meshes.detail, (first.column + i % tile_cells) * double(whole.spacing_x_m()),
                                       (first.row + i / tile_cells) * double(whole.spacing_z_m()));
}

} // namespace

// A voxel's top is the highest ground in it, rounded up; a polygon's corner takes the highest of the voxels that meet
// there, between which an agent can climb; and Recast puts the mesh one voxel above.
double nav_allowed_m(const fjell::Terrain& terrain) {
    return double(voxel_up_m(terrain)) * (2 * climb + 2);
}

fjell::GroundRect nav_samples(int x, int z) {
    const fjell::SampleIndex first = first_sample(x, z);
    return {first, {first.column + side - 1, first.row + side - 1}};
}

fjell::GroundPatch nav_ground(const fjell::Terrain& terrain, int x, int z) {
    float heights_m[side * side];
    return fjell::ground_patch(terrain, first_sample(x, z), 0, side, heights_m);
}

NavTile make_nav_tile(const fjell::Terrain& terrain, int x, int z, const fjell::Terrain& whole) {
    const Triangles ground = triangles_of(terrain, first_sample(x, z));
    NavTile tile;
    tile.error_m = ground.patch.error_m;
    tile.finest = ground.patch.finest;
    Meshes meshes;
    const rcConfig config = config_of(terrain, x, z, ground);
    tile.made = build(config, ground, meshes) && to_detour(config, x, z, meshes, tile);
    if (tile.made) look(meshes, x, z, whole, tile);
    return tile;
}

} // namespace server
