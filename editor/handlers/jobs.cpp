#include <utility>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "editor/jobs/factories.h"
#include "editor/jobs/threshold_search.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"
#include "flight/profile_keys.h"
#include "flight/snapshots.h"

namespace fjell::editor {

namespace {

MeasuredFlightPlan plan_of(HandlerContext context, std::size_t frames) {
    const State& state = context.state;
    return {open_engine(context).session().file,
            state.document.profile(),
            state.route.poses(),
            frames,
            false,
            state.files.profile_name,
            state.route.flight_name().text};
}

// Of the frame that is shown, as it stands; converged or with a threshold of its own, for that frame's view.
ExportPlan export_plan(HandlerContext context, const std::string& path, bool converged, double error_px) {
    const State& state = context.state;
    const flight::Session& session = open_engine(context).session();
    const std::optional<View>& view = session.method->view();
    if (!view) throw io::Failure(2, strings::refusals::no_frame_yet);
    ExportPlan plan{session.file,           path, {}, state.scene.streamed, state.document.profile(), *view, error_px,
                    context.engine.layers()};
    if (!converged && error_px == 0) plan.frame = flight::take_frame(session);
    return plan;
}

void apply_tuned(HandlerContext context) {
    State& state = context.state;
    state.tuned = state.job;
    const JobView& job = state.job;
    if (!job.tuned.apply || job.best_px == 0) return;
    apply(SetKey{flight::find_profile_key("refine.error_px"), job.best_px, false}, context);
}

} // namespace

void handle(const TuneThreshold& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.csv);
    context.jobs.start(JobKind::tune, tune_job(plan_of(context, c.settings.frames), c.settings, c.csv));
}

void handle(const RunBenchmark& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.csv);
    context.jobs.start(JobKind::benchmark, benchmark_job(plan_of(context, c.frames), c.csv));
}

void handle(const ExportMesh& c, HandlerContext context) {
    if (c.path.empty()) throw io::Failure(2, strings::refusals::export_without_name);
    refuse_overwriting_open_files(context.state, c.path);
    context.jobs.start(JobKind::snapshot, export_job(export_plan(context, c.path, c.converged, c.error_px)));
}

void handle(const PreviewExport& c, HandlerContext context) {
    context.jobs.start(JobKind::preview, export_job(export_plan(context, "", c.converged, c.error_px)));
}

void handle(const CancelJob&, HandlerContext context) {
    context.jobs.cancel();
}

void handle_job_result(HandlerContext context) {
    State& state = context.state;
    const JobView& job = state.job;
    const char* const name = job_names[static_cast<int>(job.kind)];
    if (job.cancelled) {
        post_message(state, Severity::note,
                     fmt::format(strings::results::cancelled, name, job.result.empty() ? "" : "; ", job.result));
        return;
    }
    if (!job.problem.empty()) {
        post_failure(state, io::Failure(job.exit_code, job.problem), fmt::format("{}: ", name));
        return;
    }
    const bool bare = job.kind == JobKind::tune; // figures alone, among other messages
    if (!job.result.empty())
        post_message(state, Severity::note, bare ? fmt::format("{}: {}", name, job.result) : job.result);
    if (job.kind == JobKind::tune) apply_tuned(context);
    if (job.run) state.runs.add(job.run);
    if (job.kind == JobKind::bake) take_baked(job.output, context);
}

} // namespace fjell::editor
