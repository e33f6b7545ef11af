// A frame's mesh, copied with what is true of it.
#include "fjell/gltf/snapshot.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/measure.h"
#include "gltf/content.h"
#include "gltf/refused.h"

namespace fjell::gltf {

namespace {

void check(const Terrain& terrain, const SnapshotInfo& info) {
    if (!terrain.valid()) throw io::Failure(2, "there is no terrain behind the handle; load it with load_terrain");
    if (const Status status = validate(info.view); !status.ok())
        throw io::Failure(2, fmt::format("{}: {}", status.field, message(status.code)));
    if (!(info.error_px > 0 && info.error_px_effective > 0 && std::isfinite(info.error_px_effective)))
        throw io::Failure(2, "SnapshotInfo::error_px and error_px_effective must be above zero and finite");
}

// A tile may have several ranges, one after the other.
std::vector<TileGeometry> tiles_of(const Terrain& terrain, const MeshView& mesh, std::span<const float> drawn_m) {
    std::vector<TileGeometry> tiles;
    TileCollector collector(terrain);
    for (std::size_t first = 0, end = 0; first < mesh.tiles.size(); first = end) {
        while (end < mesh.tiles.size() && mesh.tiles[end].tile == mesh.tiles[first].tile) ++end;
        TileGeometry geometry = collector.collect(mesh, mesh.tiles.subspan(first, end - first), drawn_m);
        if (!geometry.indices.empty()) tiles.push_back(std::move(geometry));
    }
    if (tiles.empty()) throw io::Failure(2, "the mesh has no triangle: the camera sees none of the terrain; turn it");
    return tiles;
}

SnapshotResult take(const Terrain& terrain, const MeshView& mesh, std::span<const float> drawn_m,
                    const SnapshotInfo& info, Snapshot& snapshot) {
    try {
        check(terrain, info);
        Snapshot::Content content{info, terrain.header(), tiles_of(terrain, mesh, drawn_m)};
        SnapshotResult result;
        for (const TileGeometry& tile : content.tiles) {
            result.vertices += tile.vertices.size();
            result.triangles += tile.indices.size() / 3;
        }
        result.tiles = static_cast<std::uint32_t>(content.tiles.size());
        result.converged = info.converged;
        result.error_px_effective = info.error_px_effective;
        SnapshotAccess::set(snapshot, std::move(content));
        return result;
    } catch (const io::Failure& failure) {
        return refused(failure.exit_code, failure.what());
    } catch (const std::bad_alloc&) {
        return refused(3, "not enough memory for the snapshot; ask for a larger error_px");
    }
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

SnapshotResult take_snapshot(const Terrain& terrain, LiveCut cut, const View& view, const CutSettings& settings,
                             const CutReport& report, Snapshot& snapshot) {
    const CutMesh live = cut_mesh(cut);
    SnapshotInfo info{
        .view = view, .error_px = view_error_px(view, settings.error_px), .corner_safe = settings.corner_safe};
    std::vector<float> drawn_m;
    try {
        drawn_m.reserve(live.mesh.vertices.size());
    } catch (const std::bad_alloc&) {
        return refused(3, "not enough memory for the snapshot; ask for a larger error_px");
    }
    if (live.frame.morph != Morph::none)
        for (std::size_t i = 0; i < live.mesh.vertices.size(); ++i)
            drawn_m.push_back(morphed_height_m(terrain, live.mesh.vertices[i], live.morph[i], live.frame));
    for (const TileRange& range : live.mesh.tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count && !drawn_m.empty(); ++i) {
            const std::uint32_t vertex = live.mesh.indices[i];
            info.morphed = info.morphed || drawn_m[vertex] != live.mesh.vertices[vertex].height_m;
        }
    info.error_px_effective = bound_error_px(cut, view, settings.corner_safe,
                                             reached_px(info.error_px, report.error_px_requested, report.threshold_px));
    info.lagging = report.waiting != 0 || report.morphing != 0 || terrain.missing_px() > info.error_px;
    info.converged = !info.lagging && info.error_px_effective <= info.error_px;
    return take(terrain, live.mesh, drawn_m, info, snapshot);
}

SnapshotResult take_snapshot(const Terrain& terrain, RecursiveMethod method, const View& view,
                             const RefineSettings& settings, const FrameReport& report, Snapshot& snapshot) {
    SnapshotInfo info{
        .view = view, .error_px = view_error_px(view, settings.error_px), .corner_safe = settings.corner_safe};
    info.culled = settings.cull;
    info.error_px_effective =
        bound_error_px(method, view, settings.corner_safe,
                       reached_px(info.error_px, report.error_px_requested, report.error_px_effective));
    info.lagging = terrain.missing_px() > info.error_px;
    info.converged = !info.lagging && info.error_px_effective <= info.error_px;
    return take(terrain, recursive_mesh(method), {}, info, snapshot);
}

SnapshotResult take_snapshot(const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                             Snapshot& snapshot) {
    return take(terrain, mesh, {}, info, snapshot);
}

} // namespace fjell::gltf
