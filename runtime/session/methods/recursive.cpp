#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>

#include "fjell/gl/renderer.h"
#include "fjell/gltf/snapshot.h"
#include "session/methods/method.h"

namespace fjell::session {

namespace {

using Clock = std::chrono::steady_clock;

class Recursive final : public RunningMethod {
public:
    Recursive(const FlightOptions& options, const Terrain& terrain)
        : RunningMethod(Method::recursive, terrain, recursive_bytes(terrain, options.profile.budget)) {
        require_budget(create_recursive(terrain, options.profile.budget, memory(), method_), options, terrain.header());
    }

    FrameEntry update(std::span<const View> views, const Profile& profile, double, bool) override {
        FrameReport report;
        const auto start = Clock::now();
        const Status status = update_recursive(method_, views[0], profile.refine, report);
        const auto end = Clock::now();
        require(status);
        view_ = views[0];
        settings_ = profile.refine;
        report_ = report;
        FrameEntry entry = entry_of(report);
        entry.update_us = std::chrono::duration<double, std::micro>(end - start).count();
        const MeshView drawn = recursive_mesh(method_);
        entry.upload_bytes =
            std::uint64_t{drawn.dirty_end - drawn.dirty_begin} * sizeof(MeshVertex) + drawn.indices.size_bytes();
        entry.vertex_slots = {report.vertices, 0, static_cast<std::uint32_t>(drawn.vertices.size())};
        entry.index_slots.used = static_cast<std::uint32_t>(drawn.indices.size());
        entry.index_slots.capacity = profile.budget.indices;
        entry.error_bound_px = std::max(entry.error_bound_px, terrain_.missing_px()); // not in the report
        return entry;
    }
    [[nodiscard]] CutMesh mesh() const override { return {.mesh = recursive_mesh(method_), .morph = {}, .frame = {}}; }
    [[nodiscard]] bool within_frustum(const Profile& profile) const override { return profile.refine.cull; }

    void make_room(const Profile& profile, bool, gl::RendererOptions& slots) const override {
        slots.vertices = profile.budget.vertices;
        slots.indices = profile.budget.indices;
    }
    void upload(gl::Renderer& renderer) const override { renderer.upload(recursive_mesh(method_)); }
    [[nodiscard]] gltf::Snapshot take_frame() const override {
        return gltf::take_snapshot(terrain_, method_, *view_, settings_, report_);
    }
    [[nodiscard]] gltf::Snapshot take_converged() const override { return take_frame(); }

    [[nodiscard]] nlohmann::json described(const Profile& profile) const override {
        const RefineSettings& r = profile.refine;
        return {{"method", "recursive"},
                {"metric", r.metric == Metric::depth ? "depth" : "isotropic"},
                {"topology", r.topology == Topology::strip ? "strip" : "list"},
                {"cull", r.cull},
                {"budget", {{"vertices", profile.budget.vertices}, {"indices", profile.budget.indices}}}};
    }

private:
    RecursiveMethod method_;
    RefineSettings settings_; // of the last update, as what follows
    FrameReport report_;
};

} // namespace

std::unique_ptr<RunningMethod> make_recursive(const FlightOptions& options, const Terrain& terrain) {
    return std::make_unique<Recursive>(options, terrain);
}

} // namespace fjell::session
