#include "flight/snapshots.h"

#include <new>
#include <span>

#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::flight {

namespace {

using io::Failure;

void require(const gltf::SnapshotResult& result) {
    if (!result.ok()) throw Failure(result.exit_code, result.message);
}

} // namespace

gltf::Snapshot take_frame(const Session& session) {
    const LastUpdate& last = session.last;
    gltf::Snapshot snapshot;
    if (session.incremental())
        require(gltf::take_snapshot(session.terrain(), session.cut, last.view, last.cut_settings, last.cut_report,
                                    snapshot));
    else
        require(gltf::take_snapshot(session.terrain(), session.recursive, last.view, last.refine_settings,
                                    last.frame_report, snapshot));
    return snapshot;
}

gltf::SnapshotResult write_snapshot(const Session& session, const gltf::Snapshot& snapshot, const std::string& path,
                                    const gltf::SnapshotOptions& options) {
    if (session.streamed) return gltf::write_snapshot(*session.file, snapshot, path, options);
    return gltf::write_snapshot(session.loaded.pack, snapshot, path, options);
}

gltf::Snapshot take_converged(const Session& session) {
    if (!session.incremental()) return take_frame(session);
    const View& view = session.last.view;
    const CutSettings& settings = session.last.cut_settings;
    const std::size_t bytes = cut_bytes(session.terrain(), session.cut_budget);
    io::AlignedMemory memory;
    try {
        memory = io::allocate(bytes);
    } catch (const std::bad_alloc&) {
        throw Failure(3, fmt::format("not enough memory for a second cut ({} bytes); export the frame as it stands, or "
                                     "lower the budgets",
                                     bytes));
    }
    LiveCut cut;
    CutReport report;
    Status status = create_cut(session.terrain(), session.cut_budget, {memory.get(), bytes}, cut);
    if (status.ok()) status = rebuild_cut(cut, {&view, 1}, settings, report);
    if (!status.ok()) throw Failure(1, fmt::format("{}: {}", status.field, message(status.code)));
    gltf::Snapshot snapshot;
    const gltf::SnapshotResult taken = gltf::take_snapshot(session.terrain(), cut, view, settings, report, snapshot);
    (void)destroy_cut(cut);
    require(taken);
    return snapshot;
}

} // namespace fjell::flight
