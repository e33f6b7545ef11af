// The camera: flying, orbiting, jumping, freezing, and along its path.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "editor/probe.h"
#include "fjell/io/failure.h"
#include "fjell/query.h"

namespace fjell::editor {

namespace {

using io::Failure;

double least_above_m(const session::Ground& ground) {
    return 0.5 * ground.cell_m; // ten times the near plane's distance
}

// The surface of triangles that the mesh approaches, as fine as it is there: the camera must not sink into that one.
session::Ground live_ground(HandlerContext context) {
    const session::Session& session = open_engine(context).session();
    const Terrain& terrain = session.terrain();
    session::Ground ground = session::ground_of(terrain);
    ground.start = session.start;
    ground.height_m = [&terrain](double x_m, double z_m) { return ground_height(terrain, x_m, z_m).height_m; };
    return ground;
}
// Views end at 1e8 m (fjell/view.h), and ten extents of a large terrain do not.
void stay_in_reach(session::FreeCamera& camera) {
    constexpr double reach_m = 9e7;
    for (double* const c : {&camera.position_m.x, &camera.position_m.y, &camera.position_m.z})
        *c = std::clamp(*c, -reach_m, reach_m);
}

View drawn_view(HandlerContext context) {
    State& state = context.state;
    stay_in_reach(state.eye.free);
    Profile profile = state.document.profile();
    profile.width_px = std::max(state.interface.view_width_px, 1u);
    profile.height_px = std::max(state.interface.view_height_px, 1u);
    return session::view_of(state.eye.pose(), context.engine.session().terrain(), profile);
}

void keep_above(session::FreeCamera& camera, const session::Ground& ground) {
    const Vec3& at = camera.position_m;
    camera.position_m.y = std::max(at.y, ground.height_m(at.x, at.z) + least_above_m(ground));
}

void look_at(session::FreeCamera& camera, const Vec3& place) {
    const Vec3 way = normalised(place - camera.position_m);
    if (length(way) > 0.5) camera = session::free_camera({camera.position_m, way, {}}, camera.speed_m_s);
}

bool moves(const MoveCamera& c) {
    const session::Steering& s = c.steering;
    return s.forward != 0 || s.right != 0 || s.up != 0 || s.turn_right != 0 || s.turn_up != 0 || c.right_rad != 0 ||
           c.up_rad != 0 || c.pan_right != 0 || c.pan_back != 0;
}

void orbit(const MoveCamera& c, HandlerContext context) {
    Eye& eye = context.state.eye;
    if (!moves(c) && c.speed_steps == 0) return;
    const session::Ground ground = live_ground(context);
    const double least_m = 2 * least_above_m(ground), most_m = 10 * ground.longer_m();
    eye.orbit_radius_m = std::clamp(eye.orbit_radius_m * std::pow(0.85, c.speed_steps), least_m, most_m);
    session::FreeCamera& camera = eye.free;
    session::look(camera, c.right_rad + c.steering.turn_right * 0.9 * c.seconds,
                  c.up_rad + (c.steering.turn_up - c.steering.up) * 0.9 * c.seconds);
    // Keys pan half the distance a second.
    const double right = (c.pan_right + 0.5 * c.steering.right * c.seconds) * eye.orbit_radius_m;
    const double back = (c.pan_back - 0.5 * c.steering.forward * c.seconds) * eye.orbit_radius_m;
    const double s = std::sin(camera.heading), o = std::cos(camera.heading);
    Vec3& centre = eye.orbit_centre_m;
    centre.x = std::clamp(centre.x + right * o - back * s, 0.0, ground.extent_x_m);
    centre.z = std::clamp(centre.z + right * s + back * o, 0.0, ground.extent_z_m);
    if (right != 0 || back != 0) centre.y = ground.height_m(centre.x, centre.z);
    camera.position_m = centre - camera.pose().direction * eye.orbit_radius_m;
    const double wanted_m = camera.position_m.y;
    keep_above(camera, ground);
    if (camera.position_m.y != wanted_m) look_at(camera, centre); // over the hill that is in the way
}

// How far behind the middle of the terrain's tiles their corners, at the lowest and the highest height, fill most of
// the picture.
double away_to_see_all_m(HandlerContext context, const session::Area& area, const session::Pose& pose, double aspect) {
    const Scene& s = context.state.scene;
    const double up = 0.94 * std::tan(context.state.document.profile().fov_deg * std::numbers::pi / 360),
                 right = up * aspect;
    double away_m = 0;
    for (const double x_m : {-area.width_m / 2, area.width_m / 2})
        for (const double z_m : {-area.depth_m / 2, area.depth_m / 2})
            for (const double y_m : {0.0, s.max_m - s.min_m}) {
                const Vec3 corner{x_m, y_m, z_m};
                const double aside_m = std::abs(dot(corner, cross(pose.direction, pose.up))),
                             above_m = std::abs(dot(corner, pose.up)), ahead_m = dot(corner, pose.direction);
                away_m = std::max({away_m, aside_m / right - ahead_m, above_m / up - ahead_m});
            }
    return away_m;
}

// After the camera was put somewhere else.
void settle(HandlerContext context) {
    State& state = context.state;
    take_from_path(state);
    keep_above(state.eye.free, live_ground(context));
    if (state.eye.navigation == Navigation::orbit) begin_orbit(context);
}

} // namespace

const Engine& open_engine(HandlerContext context) {
    if (!context.engine.is_open()) throw Failure(2, "no terrain is open; open a pack first");
    return context.engine;
}

// A hand has taken the camera from the path.
void take_from_path(State& state) {
    state.eye.on_path.reset();
    if (state.eye.navigation != Navigation::path) return;
    state.route.play(false);
    state.eye.navigation = Navigation::fly;
}

// Around the ground in the picture's middle; where that shows the sky, around what lies ahead.
void begin_orbit(HandlerContext context) {
    Eye& eye = context.state.eye;
    const Terrain& terrain = context.engine.session().terrain();
    const session::Ground ground = live_ground(context);
    const session::Pose pose = eye.free.pose();
    const GroundHit hit = cast_ray(terrain, pose.position_m, pose.direction, 20 * ground.longer_m());
    if (hit.hit) {
        eye.orbit_centre_m = hit.position_m;
    } else {
        const double ahead_m = ground.longer_m() / 4;
        Vec3& c = eye.orbit_centre_m;
        c.x = std::clamp(pose.position_m.x + ahead_m * std::sin(eye.free.heading), 0.0, ground.extent_x_m);
        c.z = std::clamp(pose.position_m.z - ahead_m * std::cos(eye.free.heading), 0.0, ground.extent_z_m);
        c.y = ground.height_m(c.x, c.z);
        look_at(eye.free, c);
    }
    eye.orbit_radius_m = std::max(length(pose.position_m - eye.orbit_centre_m), least_above_m(ground));
}

namespace {

// The highest ground, about: the best of a grid, then of finer ones around it.
Vec3 summit_in(const session::Area& area, const session::Ground& ground) {
    constexpr int side = 48;
    double x_m = area.x_m, z_m = area.z_m, width_m = area.width_m, depth_m = area.depth_m;
    Vec3 best{0, -std::numeric_limits<double>::infinity(), 0};
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i <= side; ++i)
            for (int j = 0; j <= side; ++j) {
                const double x = std::clamp(x_m + width_m * i / side, area.x_m, area.x_m + area.width_m),
                             z = std::clamp(z_m + depth_m * j / side, area.z_m, area.z_m + area.depth_m);
                if (const double y = ground.height_m(x, z); y > best.y) best = {x, y, z};
            }
        width_m *= 4.0 / side;
        depth_m *= 4.0 / side;
        x_m = best.x - width_m / 2;
        z_m = best.z - depth_m / 2;
    }
    return best;
}

// Of a terrain that has just been opened: its highest ground in the upper part of the picture, from the side from which
// there is the most of it to see, and the sun on it: from the north it would be dark.
session::FreeCamera first_camera(const Scene& scene, const session::Ground& ground) {
    const session::Area area = ground.start_area();
    const double longer_m = area.longer_m(), relief_m = std::max(scene.max_m - scene.min_m, 1e-3 * longer_m);
    const Vec3 summit = summit_in(area, ground);
    const double away_m = std::clamp(4 * relief_m, std::min(40 * ground.cell_m, 0.45 * longer_m), 0.45 * longer_m);
    session::FreeCamera camera;
    double most_m = -std::numeric_limits<double>::infinity();
    for (const double bearing : {0.0, -0.6, 0.6, -1.2, 1.2}) { // the way it looks, from north
        const Vec3 at{summit.x - away_m * std::sin(bearing), 0, summit.z + away_m * std::cos(bearing)};
        if (at.x < area.x_m || at.x > area.x_m + area.width_m || at.z < area.z_m || at.z > area.z_m + area.depth_m)
            continue;
        const double below_m = summit.y - ground.height_m(at.x, at.z);
        if (below_m <= most_m) continue;
        most_m = below_m;
        camera.position_m = at;
        camera.heading = bearing;
    }
    if (!(most_m > -std::numeric_limits<double>::infinity())) // it is at the southern rim
        camera.position_m = {area.x_m + area.width_m / 2, 0, area.z_m + 0.85 * area.depth_m};
    const double ground_m = ground.height_m(camera.position_m.x, camera.position_m.z);
    camera.position_m.y = std::max(ground_m + 0.08 * away_m, summit.y - 0.02 * away_m);
    camera.pitch = -0.16; // the summit lies in the picture's upper half, with some sky
    camera.speed_m_s = longer_m / 60;
    return camera;
}

} // namespace

void start_at_scene(HandlerContext context) {
    State& state = context.state;
    state.scene = context.engine.scene();
    state.measures.clear();
    state.chosen.reset();
    state.graphs = {};
    state.probe.marks = 0; // of another terrain
    Eye eye;
    eye.free = first_camera(state.scene, live_ground(context));
    state.eye = eye;
    state.route.play(false);
}

void move_camera(HandlerContext context, double seconds) {
    State& state = context.state;
    Eye& eye = state.eye;
    if (const auto pose = state.route.advance(seconds)) {
        eye.on_path = *pose;
        eye.free = session::free_camera(*pose, eye.free.speed_m_s);
    }
    if (!state.route.follow(eye.pose(), seconds)) {
        post_message(state, Severity::warning,
                     "the recording is full and has stopped; record the rest as another path");
        apply(RecordPath{false}, context);
    }
    const Terrain& terrain = context.engine.session().terrain();
    eye.ground_m = ground_height(terrain, eye.free.position_m.x, eye.free.position_m.z).height_m;
    eye.view = drawn_view(context);
}

void handle(const MoveCamera& c, HandlerContext context) {
    State& state = context.state;
    Eye& eye = state.eye;
    if (!context.engine.is_open()) return;
    eye.moved = eye.moved || moves(c) || c.speed_steps != 0;
    if (moves(c)) take_from_path(state);
    if (eye.navigation == Navigation::orbit) {
        orbit(c, context);
        return;
    }
    if (c.speed_steps != 0) handle(SetSpeed{eye.free.speed_m_s * std::pow(1.25, c.speed_steps)}, context);
    if (!moves(c)) return;
    session::look(eye.free, c.right_rad, c.up_rad);
    const session::Ground ground = live_ground(context);
    session::steer(eye.free, c.steering, c.seconds, ground, least_above_m(ground));
}

void handle(const PlaceCamera& c, HandlerContext context) {
    session::FreeCamera& free = context.state.eye.free;
    const double reach_m = 1e7;
    if (!(std::abs(c.position_m.x) <= reach_m && std::abs(c.position_m.y) <= reach_m &&
          std::abs(c.position_m.z) <= reach_m))
        throw Failure(2, "the camera's position must be within 10,000 km of the terrain's first sample");
    const session::Ground ground = live_ground(context);
    free.position_m = c.position_m;
    free.heading = 0;
    free.pitch = 0;
    session::look(free, c.heading_rad, c.pitch_rad);
    settle(context);
}

void handle(const JumpTo& c, HandlerContext context) {
    const session::Ground ground = live_ground(context);
    Vec3& at = context.state.eye.free.position_m;
    const double above_m = at.y - ground.height_m(at.x, at.z);
    at.x = std::clamp(c.x_m, 0.0, ground.extent_x_m);
    at.z = std::clamp(c.z_m, 0.0, ground.extent_z_m);
    at.y = ground.height_m(at.x, at.z) + above_m;
    settle(context);
}

void handle(const ViewAll&, HandlerContext context) {
    const Interface& i = context.state.interface;
    const double aspect = i.view_height_px > 0 ? static_cast<double>(i.view_width_px) / i.view_height_px : 1.6;
    const session::Area area = session::area_of_tiles(open_engine(context).session().terrain());
    session::FreeCamera& free = context.state.eye.free;
    const Vec3 centre{area.x_m + area.width_m / 2, context.state.scene.min_m, area.z_m + area.depth_m / 2};
    free.heading = 0;
    free.pitch = -0.65;
    free.position_m = centre - free.pose().direction * away_to_see_all_m(context, area, free.pose(), aspect);
    settle(context);
}

void handle(const SetSpeed& c, HandlerContext context) {
    context.state.eye.free.speed_m_s = std::clamp(c.m_s, 0.01, 1e6);
    context.state.eye.speed_shown_until_s = context.state.now_s + 1.5;
}

void handle(const SetNavigation& c, HandlerContext context) {
    State& state = context.state;
    if (c.navigation == Navigation::path && state.route.empty())
        throw Failure(2, "there is no camera path yet; open one, record one or add points");
    if (c.navigation != Navigation::path) take_from_path(state);
    state.eye.navigation = c.navigation;
    if (c.navigation == Navigation::orbit && context.engine.is_open()) begin_orbit(context);
    if (c.navigation == Navigation::path) handle(SeekPath{state.route.share()}, context);
}

void handle(const FreezeRefinement& c, HandlerContext context) {
    Eye& eye = context.state.eye;
    if (c.on) {
        (void)open_engine(context);
        eye.refining = drawn_view(context);
    } else {
        eye.refining.reset();
    }
    eye.frozen = c.on;
}

// --- The camera path: opened, saved, recorded, played and edited.

// For paths, whose flight must not depend on what has been streamed in.
session::Ground path_ground(HandlerContext context) {
    return open_engine(context).session().ground();
}

// The path has changed under a camera that follows it: it sees what is there now.
void follow_path(State& state) {
    if (state.eye.navigation != Navigation::path) return;
    if (state.route.empty()) return take_from_path(state);
    state.eye.on_path = state.route.pose();
    state.eye.free = session::free_camera(*state.eye.on_path, state.eye.free.speed_m_s);
}

// What is being recorded becomes the path: then it can be saved, asked about and restored.
void end_recording(HandlerContext context) {
    if (!context.state.route.recording()) return;
    try {
        handle(RecordPath{false}, context);
    } catch (const Failure&) { // the camera did not move: there is nothing to lose
    }
}

void handle(const OpenPath& c, HandlerContext context) {
    end_recording(context);
    if (!c.discard && ask_about_unsaved(OpenPath{c.path, true}, context)) return;
    State& state = context.state;
    const bool lost = state.route.unsaved();
    state.route.open(c.path, path_ground(context));
    if (state.eye.navigation == Navigation::path) take_from_path(state);
    if (lost) post_message(state, Severity::warning, "the previous path was not saved; Restore brings it back");
}

void handle(const SavePath& c, HandlerContext context) {
    refuse_overwriting_open_files(context.state, c.path, context.state.route.path());
    context.state.route.save(c.path);
    if (context.state.interface.dialog == Dialog::save_path) context.state.interface.dialog = Dialog::none;
    continue_saving(context);
    post_message(context.state, Severity::note, fmt::format("saved the camera path to {}", context.state.route.path()));
}

void handle(const RecordPath& c, HandlerContext context) {
    State& state = context.state;
    if (c.on) take_from_path(state);
    const bool lost = !c.on && state.route.recording() && state.route.unsaved_before_recording();
    state.route.record(c.on, state.eye.pose(), path_ground(context));
    if (lost) post_message(state, Severity::warning, "the previous path was not saved; Restore brings it back");
}

void handle(const PlayPath& c, HandlerContext context) {
    State& state = context.state;
    if (c.on && state.route.recording()) handle(RecordPath{false}, context);
    state.route.play(c.on);
    if (c.on) handle(SeekPath{state.route.share()}, context);
}

void handle(const SeekPath& c, HandlerContext context) {
    State& state = context.state;
    if (state.route.empty()) throw Failure(2, "there is no camera path yet; open one, record one or add points");
    state.route.seek(c.share);
    state.eye.on_path = state.route.pose();
    state.eye.free = session::free_camera(*state.eye.on_path, state.eye.free.speed_m_s);
    state.eye.navigation = Navigation::path;
}

void handle(const SelectPoint& c, HandlerContext context) {
    State& state = context.state;
    const session::Pose pose = state.route.select(c.point);
    if (!c.looks) return;
    take_from_path(state);
    state.eye.free = session::free_camera(pose, state.eye.free.speed_m_s);
    state.eye.on_path = pose; // with its roll, until a hand moves the camera
    if (state.eye.navigation == Navigation::orbit && context.engine.is_open()) begin_orbit(context);
}

void handle(const ClearPath&, HandlerContext context) {
    end_recording(context);
    const bool unsaved = context.state.route.unsaved();
    take_from_path(context.state);
    context.state.route.clear();
    if (unsaved) post_message(context.state, Severity::note, "the cleared path was not saved; Restore brings it back");
}

void undo_path(HandlerContext context) {
    context.state.route.undo();
    follow_path(context.state);
}

void redo_path(HandlerContext context) {
    context.state.route.redo();
    follow_path(context.state);
}

} // namespace fjell::editor
