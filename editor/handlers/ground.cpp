// What brushes do to the ground: a stroke's dabs, a quarter of the brush apart, and what panels show of it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "editor/handlers/handlers.h"
#include "editor/probe.h"
#include "fjell/io/failure.h"
#include "fjell/query.h"

namespace fjell::editor {

namespace {

constexpr double apart = 0.25; // dabs, in shares of the brush's whole width

// The ground's under the pointer; none: the sky.
std::optional<Vec3> ground_under(const session::Session& session, const View& view, double x, double y) {
    const Vec3 way = normalised(direction_at(view, x, y));
    const GroundHit hit = cast_ray(session.terrain(), view.eye_m, way, 1e9);
    return hit.hit ? std::optional(hit.position_m) : std::nullopt;
}

Engine& diggable(HandlerContext context) {
    (void)digging(context);
    if (context.state.ground.brush.tool == BrushTool::off)
        throw io::Failure(2, "there is no brush; choose one first, as in: brush raise");
    return context.engine;
}

void dab_at(Ground& ground, Engine& engine, double x_m, double z_m) {
    if (ground.brush.tool == BrushTool::road) {
        const GroundHeight there = ground_height(engine.session().terrain(), x_m, z_m);
        if (there.inside && !there.hole) ground.road.push_back({x_m, z_m, static_cast<float>(there.height_m)});
        ground.last_dab = {x_m, z_m};
        return;
    }
    if (!ground.last_dab) ground.level_m = ground_height(engine.session().terrain(), x_m, z_m).height_m;
    const auto seed = static_cast<std::uint32_t>(engine.digging().version());
    engine.digging().dab(dab_of(ground.brush, x_m, z_m, ground.level_m, seed));
    ground.last_dab = {x_m, z_m};
}

// To that place from the last dab, and dabs on the way.
void draw_to(Ground& ground, Engine& engine, double x_m, double z_m) {
    if (!ground.last_dab) return dab_at(ground, engine, x_m, z_m);
    const Brush& b = ground.brush;
    const double step_m = std::max(apart * (b.radius_m + 0.5 * falloff_of(b)), least_brush_m);
    constexpr int most_dabs = 1000; // a stroke across a large terrain by a small brush
    for (int i = 0; i < most_dabs; ++i) {
        const auto [from_x, from_z] = *ground.last_dab;
        const double away_m = std::hypot(x_m - from_x, z_m - from_z);
        if (away_m < step_m) return;
        const double share = step_m / away_m;
        dab_at(ground, engine, from_x + share * (x_m - from_x), from_z + share * (z_m - from_z));
    }
}

void end_stroke(Ground& ground, Engine& engine) {
    const bool is_road = ground.last_dab && ground.brush.tool == BrushTool::road;
    ground.last_dab.reset();
    const std::vector<StampPoint> road = std::exchange(ground.road, {});
    if (is_road && road.size() < 2)
        throw io::Failure(2, "a road needs two places on the ground: drag farther, or name another");
    if (is_road) {
        const io::KeptStamp built = road_of(ground.brush, road);
        engine.digging().dab(built.stamp());
    }
    engine.digging().end_stroke();
}

void lay_ring(const Terrain& terrain, const Vec3& at, double radius_m, std::array<Vec3, Ground::ring_points>& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(ring.size());
        const double x = at.x + radius_m * std::cos(angle), z = at.z + radius_m * std::sin(angle);
        const GroundHeight there = ground_height(terrain, x, z);
        ring[i] = {x, there.inside && !there.hole ? there.height_m : at.y, z};
    }
}

} // namespace

Digging& digging(HandlerContext context) {
    (void)open_engine(context);
    return context.engine.digging();
}

void handle(const AimBrush& c, HandlerContext context) {
    Ground& ground = context.state.ground;
    ground.pointer = std::array{c.x, c.y};
    if (!c.down && !c.ends) return;
    Engine& engine = diggable(context);
    const auto at = ground_under(engine.session(), context.state.eye.view, c.x, c.y);
    try {
        if (c.down && at) draw_to(ground, engine, at->x, at->z);
        if (c.ends) end_stroke(ground, engine);
    } catch (...) {
        ground.last_dab.reset();
        ground.road.clear();
        throw;
    }
}

void handle(const StrokeGround& c, HandlerContext context) {
    Ground& ground = context.state.ground;
    Engine& engine = diggable(context);
    end_stroke(ground, engine);
    const bool corners = ground.brush.tool == BrushTool::road;
    for (const auto& [x_m, z_m] : c.places) (corners ? dab_at : draw_to)(ground, engine, x_m, z_m);
    end_stroke(ground, engine);
}

void follow_ground(Ground& ground, const Digging& digging, const session::Session& session, const View& view) {
    if (ground.version != digging.version() || ground.journal != digging.path()) {
        ground.version = digging.version();
        ground.journal = digging.path();
        ground.problem = digging.problem();
        ground.layers.clear();
        for (const io::JournalLayer& layer : digging.layers())
            ground.layers.push_back({layer.name, layer.on, static_cast<double>(layer.strength), layer.stamps.size()});
        ground.chosen = digging.chosen();
        ground.undo_steps = digging.undo_steps(), ground.redo_steps = digging.redo_steps();
        ground.undo_stamp = digging.undo_stamp(), ground.redo_stamp = digging.redo_stamp();
    }
    ground.report = {};
    ground.waiting = 0;
    if (session.edits) {
        ground.report = session.edits->totals().last;
        ground.waiting = session.edits->waiting();
        ground.blocks = session.edits->budget().blocks;
        // As many as vertices that it counts, so not while a stroke goes on.
        if (ground.report.locks == 0)
            ground.always_drawn = 0;
        else if (ground.report.loose == 0 && (ground.report.work != 0 || ground.always_drawn == 0))
            ground.always_drawn = count_always_drawn(session.edits->edits());
        ground.update_us = ground.report.apply_us + ground.report.measure_us;
    } else if (ground.problem.empty()) {
        ground.problem = "This terrain lacks tiles: its ground cannot be changed.";
    }
    ground.at.reset();
    if (ground.brush.tool == BrushTool::off || !ground.pointer) return;
    ground.at = ground_under(session, view, (*ground.pointer)[0], (*ground.pointer)[1]);
    if (!ground.at) return;
    lay_ring(session.terrain(), *ground.at, ground.brush.radius_m, ground.inner);
    lay_ring(session.terrain(), *ground.at, ground.brush.radius_m + falloff_of(ground.brush), ground.outer);
}

} // namespace fjell::editor
