// The mesh of a frame as glTF, refined again over a terrain of the job's own: a streamed one changes under its frame.
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "editor/jobs/factories.h"
#include "editor/number_text.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/io/load.h"
#include "flight/session.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

gltf::SnapshotResult snapshot(const Pack& pack, const Terrain& terrain, const ExportPlan& plan, JobControl& control) {
    gltf::SnapshotOptions options;
    options.write = !plan.path.empty();
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
        if (control.cancelled()) return false;
        control.progress(options.write ? "tiles" : "measure", done, total);
        return true;
    };
    control.progress("refine", 0, 1);
    return gltf::export_snapshot(pack, terrain, plan.view, plan.error_px, plan.path, options);
}

// As much of it as the view wants at that threshold and the profile's page slots hold.
gltf::SnapshotResult snapshot_streamed(const ExportPlan& plan, JobControl& control) {
    flight::FlightOptions options;
    options.pack = plan.pack;
    options.profile = plan.profile;
    options.profile.refine.error_px = plan.error_px;
    options.profile.refine.corner_safe = false; // it is in the threshold already
    options.exports = {{0, plan.path}};         // which keeps the pack's bytes at hand
    flight::Session session;
    flight::open_session(options, session);
    control.check();
    (void)flight::update_until_there(session, plan.view, options.profile, 0, [&](const flight::FrameEntry& entry) {
        const std::uint64_t wanted = entry.stream.pages_wanted, left = entry.stream.pages_left;
        control.progress("stream", wanted > left ? wanted - left : 0, wanted);
    });
    return snapshot(session.readable_pack(), session.terrain(), plan, control);
}

gltf::SnapshotResult snapshot_whole(const ExportPlan& plan, JobControl& control) {
    const io::LoadedPack loaded = io::load_pack(plan.pack, io::LoadTerrain::yes);
    control.check();
    return snapshot(loaded.pack, loaded.terrain, plan, control);
}

void run(const ExportPlan& plan, JobControl& control) {
    control.progress("open", 0, 1);
    const gltf::SnapshotResult r = plan.streamed ? snapshot_streamed(plan, control) : snapshot_whole(plan, control);
    if (!r.ok()) {
        control.check();
        throw io::Failure(r.exit_code, r.message);
    }
    control.publish([&](JobView& view) {
        view.output = plan.path;
        view.preview = {plan.error_px, r.vertices, r.triangles, r.file_bytes};
        view.result = fmt::format("{}{} vertices, {} triangles, {} at {:.3g} px{}",
                                  plan.path.empty() ? "the export has " : plan.path + ": ",
                                  grouped(static_cast<double>(r.vertices)), grouped(static_cast<double>(r.triangles)),
                                  byte_text(static_cast<double>(r.file_bytes)).text, plan.error_px,
                                  r.converged ? "" : ", coarser where the profile's budgets were exhausted");
    });
}

} // namespace

Jobs::Body export_job(ExportPlan plan) {
    if (!(plan.error_px >= flight::min_error_px && plan.error_px <= flight::max_error_px))
        throw io::Failure(2, fmt::format("a threshold of {} px: must be {} to {}", plan.error_px, flight::min_error_px,
                                         flight::max_error_px));
    io::refuse_overwriting({plan.path}, {plan.pack});
    return [plan = std::move(plan)](JobControl& control) { run(plan, control); };
}

} // namespace fjell::editor
