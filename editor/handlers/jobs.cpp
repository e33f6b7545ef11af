// Jobs, and what is looked at of them: runs that were flown, pictures, bookmarks, and two profiles in one picture.
#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "editor/files/settings.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/threshold_search.h"
#include "editor/jobs/work.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "session/snapshots.h"

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
ExportPlan export_plan(HandlerContext context, const ExportMesh& c) {
    const State& state = context.state;
    const session::Session& session = open_engine(context).session();
    const std::optional<View>& view = session.method->view();
    if (!view) throw io::Failure(2, "no frame has been drawn yet; try again");
    ExportPlan plan{session.file, c.path,     {},        state.scene.streamed,   state.document.profile(),
                    *view,        c.error_px, c.texel_m, context.engine.layers()};
    plan.quantised = c.quantised, plan.meshopt = c.meshopt, plan.jpeg = c.jpeg;
    if (!c.converged && c.error_px == 0) plan.frame = session::take_frame(session);
    return plan;
}

void apply_tuned(HandlerContext context) {
    State& state = context.state;
    state.tuned = state.job;
    const JobView& job = state.job;
    if (job.tuned.apply && job.best_px != 0) apply(UseTuned{}, context);
}

} // namespace

void handle(const TuneThreshold& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.csv);
    context.jobs.start(JobKind::tune, tune_job(plan_of(context, c.settings.frames), c.settings, c.csv));
}

void handle(const UseTuned&, HandlerContext context) {
    State& state = context.state;
    const JobView& job = state.tuned;
    if (job.best_px == 0) throw io::Failure(2, "nothing was found yet; auto-tune first");
    Profile profile = state.document.profile();
    profile.refine.max_error_px = job.best_px;
    for (const TunedKey& t : job.tuned_keys) t.key->set(profile, t.value);
    state.document.replace(profile);
}

void handle(const RunBenchmark& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.csv);
    context.jobs.start(JobKind::benchmark, benchmark_job(plan_of(context, c.frames), c.csv));
}

void handle(const ExportMesh& c, HandlerContext context) {
    if (c.path.empty()) throw io::Failure(2, "give the export a file name that ends in .glb");
    refuse_overwriting_open_files(context.state, c.path);
    if (!gltf::is_snapshot_name(c.path))
        throw io::Failure(2, c.path + ": a snapshot is binary glTF; give it a name that ends in .glb");
    context.jobs.start(JobKind::snapshot, export_job(export_plan(context, c)));
}

void handle(const PreviewExport& c, HandlerContext context) {
    context.jobs.start(JobKind::preview, export_job(export_plan(context, c.mesh)));
}

void handle_job_result(HandlerContext context) {
    State& state = context.state;
    const JobView& job = state.job;
    const char* const name = job_names[static_cast<int>(job.kind)];
    if (job.cancelled) {
        post_message(state, Severity::note,
                     fmt::format("{} cancelled{}{}", name, job.result.empty() ? "" : "; ", job.result));
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
    if (job.kind == JobKind::materials && state.materials.baking) {
        const Command chosen = *std::exchange(state.materials.baking, std::nullopt);
        apply(chosen, context);
    }
}

// --- Runs that were flown, a rendered picture, bookmarks, and two profiles in one picture.

namespace {

using io::Failure;

const FlownRun& run_of(const State& state, std::size_t run) {
    if (state.runs.all.empty()) throw Failure(2, "no benchmark has been flown yet; run one first");
    if (run >= state.runs.all.size())
        throw Failure(2, fmt::format("there is no run {}; there are 0 to {}", run, state.runs.all.size() - 1));
    return *state.runs.all[run];
}

// Of the open terrain, the index-th; an index into all.
std::size_t bookmark_of(const Bookmarks& bookmarks, std::size_t index) {
    std::size_t own = 0;
    for (std::size_t i = 0; i < bookmarks.all.size(); ++i)
        if (bookmarks.all[i].pack == bookmarks.pack && own++ == index) return i;
    throw Failure(2, own == 0 ? std::string("this terrain has no bookmarks yet; add one first")
                              : fmt::format("there is no bookmark {}; there are 0 to {}", index, own - 1));
}

void keep(State& state) {
    if (!state.files.persists) return;
    write_bookmarks(state.files.standard_folders.config, state.bookmarks.all);
}

} // namespace

void look_from(const session::Pose& pose, HandlerContext context) {
    State& state = context.state;
    (void)open_engine(context);
    take_from_path(state);
    state.eye.free = session::free_camera(pose, state.eye.free.speed_m_s);
    state.eye.on_path = pose;
    if (state.eye.navigation == Navigation::orbit) begin_orbit(context);
}

void handle(const ChoosePlace& c, HandlerContext context) {
    State& state = context.state;
    const FlownRun& run = run_of(state, c.run);
    const std::size_t place = run.place_at(c.share);
    state.route.play(false);
    look_from(run.places[place].pose, context);
    state.runs.chosen = ChosenPlace{c.run, place};
}

void handle(const ForgetRun& c, HandlerContext context) {
    (void)run_of(context.state, c.run);
    context.state.runs.forget(c.run);
}

void handle(const RenderPicture& c, HandlerContext context) {
    State& state = context.state;
    PicturePlan plan;
    plan.pack = open_engine(context).session().file;
    plan.layers = context.engine.layers();
    plan.path = c.path;
    plan.profile = state.document.profile();
    plan.profile.width_px = c.width;
    plan.profile.height_px = c.height;
    plan.mode = state.interface.mode;
    plan.pose = state.eye.pose();
    refuse_overwriting_open_files(state, c.path);
    context.jobs.start(JobKind::picture, picture_job(std::move(plan)));
}

void handle(const AddBookmark& c, HandlerContext context) {
    State& state = context.state;
    Bookmarks& b = state.bookmarks;
    (void)open_engine(context);
    if (b.all.size() >= most_bookmarks)
        throw Failure(2, fmt::format("there are {} bookmarks already; remove some", most_bookmarks));
    const auto own = std::ranges::count(b.all, b.pack, &Bookmark::pack);
    Bookmark mark;
    mark.name = c.name.empty() ? fmt::format("Place {}", own + 1) : c.name.substr(0, 60);
    mark.pack = b.pack;
    mark.pose = state.eye.pose();
    b.all.push_back(std::move(mark));
    keep(state);
}

void handle(const GoToBookmark& c, HandlerContext context) {
    const Bookmarks& b = context.state.bookmarks;
    context.state.route.play(false);
    look_from(b.all[bookmark_of(b, c.bookmark)].pose, context);
}

void handle(const RemoveBookmark& c, HandlerContext context) {
    Bookmarks& b = context.state.bookmarks;
    const std::size_t at = bookmark_of(b, c.bookmark);
    b.all.erase(b.all.begin() + static_cast<std::ptrdiff_t>(at));
    keep(context.state);
}

void handle(const ComparePictures& c, HandlerContext context) {
    State& state = context.state;
    if (c.with != CompareWith::nothing) (void)open_engine(context);
    if (c.with == CompareWith::profile && state.document.compared() == nullptr)
        throw Failure(2, "there is no profile to compare with; choose one with File > Compare profiles first");
    state.compared.with = c.with;
    state.compared.error_px =
        c.with == CompareWith::half ? 1.7 * state.document.profile().refine.max_error_px : c.error_px;
    state.compared.there = false;
    state.compared.differing = -1;
}

} // namespace fjell::editor
