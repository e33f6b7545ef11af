// A frame's mesh, copied with what is true of it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <new>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/ground_maps.h"
#include "fjell/io/failure.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/load.h"
#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "gltf/content.h"

namespace fjell::gltf {

namespace {

void check(const Terrain& terrain, const SnapshotInfo& info) {
    if (!terrain.valid())
        throw io::Failure(2, "the terrain's handle is empty or destroyed; load a terrain first (load_terrain)");
    if (const Status status = validate(info.view); !status.ok())
        throw io::Failure(2, fmt::format("{}: {}", status.field, message(status.code)));
    if (!(info.error_px > 0 && info.error_bound_px > 0 && std::isfinite(info.error_bound_px)))
        throw io::Failure(2, "SnapshotInfo::error_px and error_bound_px must be above zero and finite");
}

// A tile may have several ranges, one after the other.
std::vector<TileGeometry> tiles_of(const Terrain& terrain, const MeshView& mesh, std::span<const float> drawn_m,
                                   bool lagging) {
    std::vector<TileGeometry> tiles;
    TileCollector collector(terrain);
    for (std::size_t first = 0, end = 0; first < mesh.tiles.size(); first = end) {
        while (end < mesh.tiles.size() && mesh.tiles[end].tile == mesh.tiles[first].tile) ++end;
        TileGeometry geometry = collector.collect(mesh, mesh.tiles.subspan(first, end - first), drawn_m);
        if (!geometry.indices.empty()) tiles.push_back(std::move(geometry));
    }
    if (tiles.empty())
        throw io::Failure(2, lagging ? "the mesh has no triangle yet: work or pages are missing; take a later frame"
                                     : "the mesh has no triangle: the camera sees none of the terrain; turn it");
    return tiles;
}

// The normals of ground that has moved, in all mips: the file's size of textures is chosen later.
void take_moved_normals(const Terrain& terrain, std::vector<TileGeometry>& tiles) {
    const PackHeader& h = terrain.header();
    if (h.normal_log2 == 0) return;
    const std::size_t bytes = ground_maps_bytes(h);
    const io::AlignedMemory memory = io::allocate(bytes);
    GroundMaps maps;
    if (!create_ground_maps(terrain, {}, {memory.get(), bytes}, maps).ok()) return;
    std::vector<TileMap> shown(terrain.tile_count());
    std::vector<TileGeometry*> by_tile(terrain.tile_count());
    for (TileGeometry& tile : tiles) {
        shown[tile.tile].side_log2 = static_cast<std::uint8_t>(h.normal_log2);
        by_tile[tile.tile] = &tile;
    }
    GroundMapsReport report;
    do {
        if (!update_ground_maps(maps, shown, report).ok()) return;
        for (const MapPatch& patch : ground_map_patches(maps)) {
            if (patch.map != MapKind::normal) continue; // a stream's, of its last update
            by_tile[patch.tile]->moved.push_back(
                {patch.mip, patch.x, patch.y, patch.columns, patch.rows, {patch.blocks.begin(), patch.blocks.end()}});
        }
    } while (report.waiting != 0);
}

void take_paint(const Terrain& terrain, Snapshot::Content& content) {
    const std::size_t bytes = paint_bytes(terrain);
    if (bytes == 0) return;
    content.paint_memory = io::allocate(bytes);
    (void)copy_paint(terrain, {content.paint_memory.get(), bytes}, content.paint);
}

// take() returns a Snapshot; too little memory for it is a Failure.
template <typename Take>
Snapshot with_memory(const Take& take) {
    try {
        return take();
    } catch (const std::bad_alloc&) {
        throw io::Failure(3, "not enough memory for the snapshot; ask for a larger error_px");
    }
}

Snapshot copied(const Terrain& terrain, const MeshView& mesh, std::span<const float> drawn_m,
                const SnapshotInfo& info) {
    return with_memory([&] {
        check(terrain, info);
        Snapshot::Content content{info, terrain.header(), tiles_of(terrain, mesh, drawn_m, info.lagging), {}, {}};
        take_moved_normals(terrain, content.tiles);
        take_paint(terrain, content);
        return SnapshotAccess::of(std::move(content));
    });
}

// The threshold that the method refines to, for a view: thresholds of all views rise alike. What the mesh lacks of it
// is found in the mesh.
double reached_px(double asked_px, double requested_px, double threshold_px) {
    return asked_px * std::max(threshold_px / requested_px, 1.0);
}

} // namespace

SnapshotInfo Snapshot::info() const {
    return content_ ? content_->info : SnapshotInfo{};
}

SnapshotCounts Snapshot::counts() const {
    SnapshotCounts counts;
    if (!content_) return counts;
    for (const TileGeometry& tile : content_->tiles) {
        counts.vertices += tile.vertices.size();
        counts.triangles += tile.indices.size() / 3;
    }
    counts.tiles = static_cast<std::uint32_t>(content_->tiles.size());
    counts.converged = content_->info.converged;
    counts.error_bound_px = content_->info.error_bound_px;
    return counts;
}

Snapshot take_snapshot(const Terrain& terrain, LiveCut cut, const View& view, const CutSettings& settings,
                       const CutReport& report) {
    const CutMesh live = cut_mesh(cut);
    SnapshotInfo info{
        .view = view, .error_px = view_max_error_px(view, settings.max_error_px), .corner_safe = settings.corner_safe};
    info.error_bound_px = bound_error_px(cut, view, settings.corner_safe,
                                         reached_px(info.error_px, report.error_px_requested, report.threshold_px));
    info.lagging = report.waiting != 0 || report.morphing != 0 || terrain.missing_px() > info.error_px;
    info.converged = !info.lagging && info.error_bound_px <= info.error_px;
    return with_memory([&] {
        std::vector<float> drawn_m;
        if (live.frame.morph != Morph::none) drawn_m.reserve(live.mesh.vertices.size());
        for (std::size_t i = 0; i < drawn_m.capacity(); ++i)
            drawn_m.push_back(morphed_height_m(terrain, live.mesh.vertices[i], live.morph[i], live.frame));
        for (const TileRange& range : live.mesh.tiles)
            for (std::uint32_t i = 0; i < range.index_count && !drawn_m.empty(); ++i) {
                const std::uint32_t vertex = live.mesh.indices[range.first_index + i];
                info.morphed = info.morphed || drawn_m[vertex] != live.mesh.vertices[vertex].height_m;
            }
        return copied(terrain, live.mesh, drawn_m, info);
    });
}

Snapshot take_snapshot(const io::LiveTerrain& terrain, const View& view) {
    return take_snapshot(terrain.terrain(), terrain.cut(), view, terrain.settings.cut, terrain.frame().cut);
}

Snapshot take_snapshot(const Terrain& terrain, RecursiveMethod method, const View& view, const RefineSettings& settings,
                       const FrameReport& report) {
    SnapshotInfo info{
        .view = view, .error_px = view_max_error_px(view, settings.max_error_px), .corner_safe = settings.corner_safe};
    info.culled = settings.cull;
    info.error_bound_px = bound_error_px(method, view, settings.corner_safe,
                                         reached_px(info.error_px, report.error_px_requested, report.error_bound_px));
    info.lagging = terrain.missing_px() > info.error_px;
    info.converged = !info.lagging && info.error_bound_px <= info.error_px;
    return copied(terrain, recursive_mesh(method), {}, info);
}

Snapshot take_snapshot(const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info) {
    return copied(terrain, mesh, {}, info);
}

// A budget that fits is found by trying: the mesh' size is known only once it is made, a pass costs tens of nanoseconds
// a vertex, and a capacity for every sample of a large terrain would cost more than the passes that failed.

namespace {

constexpr std::uint32_t capacity(std::uint64_t wanted) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, 0xffff'ffff));
}

// What full resolution takes, and so the most that can ever be used.
RecursiveBudget largest_budget(const Terrain& terrain) {
    const std::uint64_t side = std::uint64_t{1} << terrain.header().tile_log2, tiles = terrain.tile_count();
    return {capacity(tiles * (side + 1) * (side + 1)),
            capacity(std::max<std::uint64_t>(tiles * side * side * 6, tiles * 9))};
}

} // namespace

Snapshot take_refined(const Terrain& terrain, const View& view, double error_px) {
    if (!terrain.valid())
        throw io::Failure(2, "the terrain's handle is empty or destroyed; load a terrain first (load_terrain)");
    const RecursiveBudget largest = largest_budget(terrain);
    const RefineSettings settings{
        .max_error_px = error_px, .metric = Metric::isotropic, .cull = false, .topology = Topology::triangles};
    for (std::uint64_t vertices = 1u << 20;; vertices *= 4) {
        const RecursiveBudget budget{std::min(capacity(vertices), largest.vertices),
                                     std::min(capacity(vertices * 6), largest.indices)};
        const bool all = budget.vertices == largest.vertices && budget.indices == largest.indices;
        const std::size_t bytes = recursive_bytes(terrain, budget);
        io::AlignedMemory memory;
        try {
            memory = io::allocate(bytes);
        } catch (const std::bad_alloc&) {
            throw io::Failure(
                3, fmt::format("not enough memory to refine the whole terrain ({} bytes); ask for a larger error_px",
                               bytes));
        }
        RecursiveMethod method;
        Status status = create_recursive(terrain, budget, {memory.get(), bytes}, method);
        if (status.code == StatusCode::budget_too_small && !all) continue;
        FrameReport report;
        if (status.ok()) status = update_recursive(method, view, settings, report);
        if (!status.ok()) throw io::Failure(2, fmt::format("{}: {}", status.field, message(status.code)));
        if (!report.converged && !all) continue;
        return take_snapshot(terrain, method, view, settings, report); // the method dies with its memory
    }
}

SnapshotCounts export_snapshot(const Pack& pack, const Terrain& terrain, const View& view, double error_px,
                               const std::string& path, const SnapshotOptions& options) {
    return write_snapshot(pack, take_refined(terrain, view, error_px), path, options);
}

} // namespace fjell::gltf
