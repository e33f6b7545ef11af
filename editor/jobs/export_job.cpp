// A mesh as glTF: the frame's, taken when the job was made, as a streamed terrain changes under its frame; or one that
// is refined over a terrain of the job's own.
#include <utility>

#include <fmt/format.h>

#include "editor/jobs/factories.h"
#include "editor/number_text.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "flight/session.h"
#include "flight/snapshots.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

gltf::SnapshotOptions options_of(const ExportPlan& plan, JobControl& control) {
    gltf::SnapshotOptions options;
    options.write = !plan.path.empty();
    options.progress = [&control, write = options.write](std::uint64_t done, std::uint64_t total) {
        if (control.cancelled()) return false;
        control.progress(write ? "tiles" : "measure", done, total);
        return true;
    };
    return options;
}

gltf::SnapshotResult write(const ExportPlan& plan, const gltf::Snapshot& snapshot, JobControl& control) {
    return flight::write_snapshot(*plan.pack, snapshot, plan.path, options_of(plan, control),
                                  {plan.layers, plan.profile.layers});
}

gltf::SnapshotResult write_frame(const ExportPlan& plan, JobControl& control) {
    return write(plan, plan.frame, control);
}

// A session that is as the frame's; of a streamed one with as much as the view wants and the page slots hold.
gltf::SnapshotResult write_refined(const ExportPlan& plan, JobControl& control) {
    flight::FlightOptions options;
    options.pack = plan.pack->path();
    options.file = plan.pack;
    options.streaming = plan.streamed ? flight::Streaming::on : flight::Streaming::off;
    options.profile = plan.profile;
    options.profile.stream.fade_s = options.profile.stream.lookahead_s = 0; // time stands still
    const bool own = plan.error_px > 0;
    if (own) {
        options.profile.refine.error_px = plan.error_px;
        options.profile.refine.corner_safe = false;
    }
    flight::Session session;
    flight::open_session(options, session);
    control.check();
    if (!own || session.streamed)
        (void)flight::update_until_there(session, plan.view, options.profile, 0, [&](const flight::FrameEntry& entry) {
            const std::uint64_t wanted = entry.stream.pages_wanted, left = entry.stream.pages_left;
            control.progress("stream", wanted > left ? wanted - left : 0, wanted);
        });
    control.progress("refine", 0, 1);
    gltf::Snapshot snapshot;
    if (!own)
        snapshot = flight::take_converged(session);
    else if (gltf::SnapshotResult taken = gltf::take_refined(session.terrain(), plan.view, plan.error_px, snapshot);
             !taken.ok())
        return taken;
    return write(plan, snapshot, control);
}

void run(const ExportPlan& plan, JobControl& control) {
    control.progress("open", 0, 1);
    const gltf::SnapshotResult r = plan.frame.empty() ? write_refined(plan, control) : write_frame(plan, control);
    if (!r.ok()) {
        control.check();
        throw io::Failure(r.exit_code, r.message);
    }
    control.publish([&](JobView& view) {
        view.output = plan.path;
        view.preview = {r.error_px_effective, r.vertices, r.triangles, r.file_bytes};
        view.result = fmt::format("{}{} vertices, {} triangles, {} within {:.3g} px{}",
                                  plan.path.empty() ? "the export has " : plan.path + ": ",
                                  grouped(static_cast<double>(r.vertices)), grouped(static_cast<double>(r.triangles)),
                                  byte_text(static_cast<double>(r.file_bytes)).text, r.error_px_effective,
                                  r.converged ? "" : ", which is not what was asked for");
    });
}

} // namespace

Jobs::Body export_job(ExportPlan plan) {
    if (plan.error_px != 0 && !(plan.error_px >= flight::min_error_px && plan.error_px <= flight::max_error_px))
        throw io::Failure(2, fmt::format("a threshold of {} px: must be {} to {}", plan.error_px, flight::min_error_px,
                                         flight::max_error_px));
    io::refuse_overwriting({plan.path}, {plan.pack->path()});
    return [plan = std::move(plan)](JobControl& control) { run(plan, control); };
}

} // namespace fjell::editor
