// A budget that fits is found by trying: the mesh' size is known only once it is made, a pass costs tens of nanoseconds
// a vertex, and a capacity for every sample of a large terrain would cost more than the passes that failed.
#include "fjell/gltf/snapshot.h"

#include <algorithm>
#include <cstddef>
#include <new>
#include <string>

#include <fmt/format.h>

#include "fjell/io/load.h"
#include "fjell/recursive.h"
#include "gltf/refused.h"

namespace fjell::gltf {

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

SnapshotResult take_refined(const Terrain& terrain, const View& view, double error_px, Snapshot& snapshot) {
    if (!terrain.valid()) return refused(2, "there is no terrain behind the handle; load it with load_terrain");
    const RecursiveBudget largest = largest_budget(terrain);
    const RefineSettings settings{
        .error_px = error_px, .metric = Metric::isotropic, .cull = false, .topology = Topology::triangles};
    for (std::uint64_t vertices = 1u << 20;; vertices *= 4) {
        const RecursiveBudget budget{std::min(capacity(vertices), largest.vertices),
                                     std::min(capacity(vertices * 6), largest.indices)};
        const bool all = budget.vertices == largest.vertices && budget.indices == largest.indices;
        const std::size_t bytes = recursive_bytes(terrain, budget);
        io::AlignedMemory memory;
        try {
            memory = io::allocate(bytes);
        } catch (const std::bad_alloc&) {
            return refused(
                3, fmt::format("not enough memory to refine the whole terrain ({} bytes); ask for a larger error_px",
                               bytes));
        }
        RecursiveMethod method;
        Status status = create_recursive(terrain, budget, {memory.get(), bytes}, method);
        if (status.code == Code::budget_too_small && !all) continue;
        FrameReport report;
        if (status.ok()) status = update_recursive(method, view, settings, report);
        if (!status.ok()) return refused(2, fmt::format("{}: {}", status.field, message(status.code)));
        if (!report.converged && !all) continue;
        SnapshotResult taken = take_snapshot(terrain, method, view, settings, report, snapshot);
        (void)destroy_recursive(method);
        return taken;
    }
}

SnapshotResult export_snapshot(const Pack& pack, const Terrain& terrain, const View& view, double error_px,
                               const std::string& path, const SnapshotOptions& options) {
    Snapshot snapshot;
    SnapshotResult taken = take_refined(terrain, view, error_px, snapshot);
    return taken.ok() ? write_snapshot(pack, snapshot, path, options) : taken;
}

} // namespace fjell::gltf
