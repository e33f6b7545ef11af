#include <algorithm>
#include <chrono>
#include <new>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/gl/renderer.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/io/live_terrain.h"
#include "session/methods/method.h"
#include "session/worker_pool.h"

namespace fjell::session {

namespace {

using io::Failure;
using Clock = std::chrono::steady_clock;

const char* name_of(Morph morph) {
    return morph == Morph::error ? "error" : morph == Morph::time ? "time" : "none";
}

class Incremental final : public RunningMethod {
public:
    Incremental(const FlightOptions& options, const Terrain& terrain, const CutBudget& budget)
        : RunningMethod(Method::incremental, terrain, cut_bytes(terrain, budget)), budget_(budget),
          workers_(budget.workers > 1 ? std::make_unique<WorkerPool>(budget.workers) : nullptr) {
        require_budget(create_cut(terrain, budget, memory(), cut_), options, terrain.header());
    }

    FrameEntry update(std::span<const View> views, const Profile& profile, double now_s, bool anew) override {
        return update(views, cut_settings(profile, now_s), anew);
    }
    FrameEntry replay(const RecordedFrame& frame) override {
        return update(frame.views, frame.settings, frame.rebuild);
    }
    [[nodiscard]] RecordedFrame recorded() const override {
        return session::recorded({&*view_, 1}, settings_, report_, mesh().mesh);
    }
    [[nodiscard]] CutBudget cut_budget() const override { return budget_; }
    [[nodiscard]] LiveCut cut() const override { return cut_; }
    [[nodiscard]] CutMesh mesh() const override { return cut_mesh(cut_); }
    [[nodiscard]] bool within_frustum(const Profile&) const override { return true; } // what may be seen is listed

    void make_room(const Profile& profile, bool streamed, gl::RendererOptions& slots) const override {
        slots = gl::room_for(budget_, streamed ? profile.stream.map_bytes : 0);
    }
    void upload(gl::Renderer& renderer) const override { renderer.upload(mesh(), cut_take_changes(cut_)); }

    [[nodiscard]] gltf::Snapshot take_frame() const override {
        return gltf::take_snapshot(terrain_, cut_, *view_, settings_, report_);
    }
    // Of a second cut, built from scratch.
    [[nodiscard]] gltf::Snapshot take_converged() const override {
        io::AlignedMemory block;
        try {
            block = io::allocate(bytes());
        } catch (const std::bad_alloc&) {
            throw Failure(3, fmt::format("not enough memory for a second cut ({} bytes); export the frame as it "
                                         "stands, or lower the budgets",
                                         bytes()));
        }
        LiveCut cut;
        CutReport report;
        require(create_cut(terrain_, budget_, {block.get(), bytes()}, cut));
        require(rebuild_cut(cut, {&*view_, 1}, settings_, report));
        return gltf::take_snapshot(terrain_, cut, *view_, settings_, report); // the cut dies with its memory
    }

    [[nodiscard]] nlohmann::json described(const Profile& profile) const override {
        const CutSettings& c = profile.cut;
        return {{"method", "incremental"},
                {"hysteresis", c.hysteresis},
                {"offscreen_factor", c.offscreen_factor},
                {"morph", name_of(c.morph)},
                {"metric", "isotropic"},
                {"topology", "list"},
                {"cull", false},
                {"budget",
                 {{"vertices", budget_.vertices},
                  {"triangles", budget_.triangles},
                  {"chunk_triangles", budget_.segment_triangles},
                  {"views", budget_.views},
                  {"workers", budget_.workers},
                  {"items", c.max_work == unlimited_work ? 0 : c.max_work},
                  {"budget_us", c.max_time_us}}}};
    }

private:
    FrameEntry update(std::span<const View> views, CutSettings settings, bool rebuild) {
        if (workers_) settings.jobs = workers_->jobs();
        CutReport report;
        const auto start = Clock::now();
        const Status status = (rebuild ? rebuild_cut : update_cut)(cut_, views, settings, report);
        const auto end = Clock::now();
        require(status);
        view_ = views[0];
        settings_ = settings;
        report_ = report;
        FrameEntry entry = entry_of(report, settings);
        entry.update_us = std::chrono::duration<double, std::micro>(end - start).count();
        const MeshView drawn = mesh().mesh;
        const MethodFacts& slot = facts_of(kind);
        entry.upload_bytes = report.rebuilt ? drawn.vertices.size() * slot.gpu_vertex_bytes + drawn.indices.size_bytes()
                                            : report.vertices_changed * slot.gpu_vertex_bytes +
                                                  report.triangles_changed * slot.gpu_triangle_bytes;
        return entry;
    }

    CutBudget budget_; // the profile's, with segments to suit the terrain
    LiveCut cut_;
    std::unique_ptr<WorkerPool> workers_; // where the budget has more than one
    CutSettings settings_;                // of the last update, as what follows
    CutReport report_;
};

} // namespace

std::unique_ptr<RunningMethod> make_incremental(const FlightOptions& options, const Terrain& terrain,
                                                const CutBudget* recorded) {
    if (terrain.header().order == PageOrder::linear)
        throw Failure(1,
                      fmt::format("{}: the pack is in linear order, which the incremental method does not read; bake "
                                  "it with --order planar, or fly it with --method recursive",
                                  options.pack));
    return std::make_unique<Incremental>(options, terrain,
                                         recorded ? *recorded : io::suited(options.profile.cut_budget, terrain));
}

} // namespace fjell::session
