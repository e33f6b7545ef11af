#include "fly/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/failure.h"

namespace fjell::fly {

namespace {

using host::Failure;
using Clock = std::chrono::steady_clock;

void require(const Status& status) {
    if (!status.ok()) throw Failure(1, fmt::format("{}: {}", status.field, message(status.code)));
}

double microseconds(Clock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
}

} // namespace

void open_session(const Options& options, Session& session) {
    const auto start = Clock::now();
    session.loaded = host::load_pack(options.pack, host::LoadTerrain::yes);
    session.block_bytes = recursive_bytes(session.terrain(), options.profile.budget);
    session.block = host::make_block(session.block_bytes);
    const Status made = create_recursive(session.terrain(), options.profile.budget,
                                         {session.block.get(), session.block_bytes}, session.method);
    if (made.code == Code::budget_too_small)
        throw Failure(1, fmt::format("{}: {} ([budget] of a --profile)", made.field, message(made.code)));
    require(made);
    session.load_seconds = microseconds(Clock::now() - start) / 1e6;
}

CameraPath path_of(const Options& options) {
    if (options.seeded) return random_path(options.seed);
    if (!options.path.empty()) return read_path(options.path);
    return {"orbit", Units::terrain, Orbit{}};
}

View view_of(const Pose& pose, const Terrain& terrain, const Profile& profile) {
    const PackHeader& h = terrain.header;
    const double width_m = (h.columns - 1) * h.spacing_m[0], depth_m = (h.rows - 1) * h.spacing_m[1];
    const Vec3 eye = pose.position_m;
    const Vec3 farthest{std::max(std::abs(eye.x), std::abs(eye.x - width_m)),
                        std::max(std::abs(eye.y - h.min_m), std::abs(eye.y - h.max_m)),
                        std::max(std::abs(eye.z), std::abs(eye.z - depth_m))};
    const double near_m = 0.05 * std::min(h.spacing_m[0], h.spacing_m[1]);
    const double far_m = std::max(1.01 * length(farthest), 2 * near_m);
    return make_view(eye, pose.direction, pose.up, profile.fov_deg * std::numbers::pi / 180, profile.width_px,
                     profile.height_px, near_m, far_m);
}

FrameEntry update_frame(Session& session, const View& view, const RefineSettings& settings) {
    FrameEntry entry;
    const auto start = Clock::now();
    const Status status = update_recursive(session.method, view, settings, entry.report);
    entry.update_us = microseconds(Clock::now() - start);
    require(status);
    const MeshView mesh = recursive_mesh(session.method);
    entry.upload_bytes =
        std::uint64_t{mesh.dirty_end - mesh.dirty_begin} * sizeof(MeshVertex) + mesh.indices.size_bytes();
    return entry;
}

void verify_frame(const Session& session, const View& view, const RefineSettings& settings, std::size_t frame,
                  FrameEntry& entry, Verification& verification) {
    const Frustum frustum = make_frustum(view);
    const MeasuredError e =
        measure_error(session.terrain(), recursive_mesh(session.method), view, settings.cull ? &frustum : nullptr);
    const double limit_px = entry.report.error_px_effective;
    entry.verified_px = e.max_px;
    verification.exceeded = verification.exceeded || e.max_px > limit_px;
    if (verification.limit_px > 0 && e.max_px / limit_px <= verification.max_px / verification.limit_px) return;
    verification.frame = frame;
    verification.max_px = e.max_px;
    verification.limit_px = limit_px;
}

} // namespace fjell::fly
