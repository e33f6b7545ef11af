// The editor's camera on a real terrain, by its commands. Needs a headless OpenGL context.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "editor/handlers/handlers.h"
#include "editor/probe.h"
#include "fjell/gl/context.h"
#include "fjell/query.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

struct CameraPlace {
    explicit CameraPlace(unsigned seed) : random(seed) {
        context = gl::Headless::create();
        (void)baker::bake(random_dem(random, 180, 140, Shape::fractal), small_bake(5), folder / "t.fjell");
        state.interface.view_width_px = 640;
        state.interface.view_height_px = 360;
        engine.open(folder / "t.fjell", state.document.profile());
        start_at_scene(handlers());
        frame();
    }
    ~CameraPlace() { engine.close(); } // before its context goes
    HandlerContext handlers() { return {state, engine, jobs}; }
    void act(const Command& command) { apply(command, handlers()); }
    void frame() { move_camera(handlers(), 1.0 / 60); }
    [[nodiscard]] const Terrain& terrain() const { return engine.session().terrain(); }
    [[nodiscard]] double ground(double x, double z) const { return ground_height(terrain(), x, z).height_m; }
    [[nodiscard]] double above() const {
        const Vec3& at = state.eye.free.position_m;
        return at.y - ground(at.x, at.z);
    }
    void fly_somewhere() {
        const double w = state.scene.width_m(), d = state.scene.depth_m();
        act(PlaceCamera{{uniform(random, 0, w), uniform(random, 0, w / 4), uniform(random, 0, d)},
                        uniform(random, -3, 3),
                        uniform(random, -1.3, 0.3)});
    }

    Random random;
    TemporaryFolder folder;
    std::unique_ptr<gl::Headless> context;
    State state;
    Engine engine;
    Jobs jobs;
};

MoveCamera drag(Random& random) {
    MoveCamera move;
    move.seconds = 1.0 / 60;
    move.right_rad = uniform(random, -0.5, 0.5);
    move.up_rad = uniform(random, -0.5, 0.5);
    if (pick(random, 0, 3) == 0) move.speed_steps = pick(random, -8, 8);
    if (pick(random, 0, 3) == 0) move.pan_right = uniform(random, -0.4, 0.4);
    if (pick(random, 0, 3) == 0) move.pan_back = uniform(random, -0.4, 0.4);
    if (pick(random, 0, 3) == 0) move.steering.up = uniform(random, -5, 5);
    return move;
}

} // namespace

TEST_CASE("however it is dragged, the camera never sinks into the ground") {
    double nearest = 1e9; // in cells
    for (unsigned seed = 0; seed < 4; ++seed) {
        CameraPlace place(seed);
        INFO("seed " << seed);
        for (const Navigation navigation : {Navigation::orbit, Navigation::fly}) {
            place.fly_somewhere();
            place.act(SetNavigation{navigation});
            double least = 1e9;
            for (int i = 0; i < 400; ++i) {
                place.act(drag(place.random));
                place.frame();
                least = std::min(least, place.above());
            }
            CHECK(least > 0);
            nearest = std::min(nearest, least / place.state.scene.spacing_m[0]);
        }
    }
    CHECK(nearest < 0.6); // it was pressed against the ground, where half a cell is left
}

TEST_CASE("an orbit begins without moving the camera, around the ground in the picture's middle, and looks at it") {
    int on_ground = 0, looked = 0;
    for (unsigned seed = 0; seed < 6; ++seed) {
        CameraPlace place(seed);
        place.fly_somewhere();
        Eye& eye = place.state.eye;
        const session::Pose pose = eye.free.pose();
        const GroundHit hit = cast_ray(place.terrain(), pose.position_m, pose.direction, 1e9);
        place.act(SetNavigation{Navigation::orbit});
        INFO("seed " << seed << (hit.hit ? "" : ", sky"));
        CHECK(length(eye.free.position_m - pose.position_m) == 0);
        if (hit.hit) {
            ++on_ground;
            CHECK(length(eye.orbit_centre_m - hit.position_m) == 0);
            CHECK(length(eye.free.pose().direction - pose.direction) < 1e-12);
        }
        for (int i = 0; i < 100; ++i) {
            MoveCamera move = drag(place.random);
            place.act(move);
            const Vec3 way = normalised(eye.orbit_centre_m - eye.free.position_m);
            // Straight over the centre pitch stops short, and there alone the two differ.
            if (std::abs(way.y) >= std::sin(1.49)) continue;
            ++looked;
            CHECK(length(way - eye.free.pose().direction) < 1e-6);
        }
    }
    CHECK(on_ground > 0);
    CHECK(looked > 300);
}

TEST_CASE("seen whole, the terrain has all of its corners in the picture and fills it one way, wide or narrow") {
    CameraPlace place(3);
    for (const auto& [width, height] : {std::pair{640u, 360u}, {300u, 700u}, {1600u, 300u}}) {
        INFO(width << " x " << height);
        place.state.interface.view_width_px = width;
        place.state.interface.view_height_px = height;
        place.act(ViewAll{});
        place.frame();
        double least = 1; // from a corner to the nearest edge, in shares of the picture
        const Scene& s = place.state.scene;
        for (const double x : {0.0, s.width_m()})
            for (const double z : {0.0, s.depth_m()})
                for (const double y : {s.min_m, s.max_m}) {
                    const auto at = place_in(place.state.eye.view, {x, y, z});
                    REQUIRE(at);
                    for (const double share : *at) least = std::min({least, share, 1 - share});
                }
        CHECK(least == Approx(0.03).epsilon(1e-6)); // half of what the fit leaves of the picture
    }
}

TEST_CASE("the wheel nears the orbit's centre and sets the speed of flying") {
    CameraPlace place(2);
    place.act(ViewAll{});
    const double speed = place.state.eye.free.speed_m_s;
    MoveCamera wheel;
    wheel.speed_steps = 1;
    place.act(wheel);
    CHECK(place.state.eye.free.speed_m_s == Approx(1.25 * speed));
    CHECK(place.state.eye.speed_shown_until_s > place.state.now_s);
    place.act(SetNavigation{Navigation::orbit});
    const double away = place.state.eye.orbit_radius_m;
    place.act(wheel);
    CHECK(place.state.eye.orbit_radius_m == Approx(0.85 * away));
    CHECK(place.state.eye.free.speed_m_s == Approx(1.25 * speed));
}

TEST_CASE("a jump keeps the view and the height above the ground") {
    for (unsigned seed = 0; seed < 3; ++seed) {
        CameraPlace place(seed);
        place.fly_somewhere();
        for (int i = 0; i < 50; ++i) {
            const session::FreeCamera before = place.state.eye.free;
            const double above = place.above();
            const JumpTo to{uniform(place.random, 0, place.state.scene.width_m()),
                            uniform(place.random, 0, place.state.scene.depth_m())};
            place.act(to);
            const session::FreeCamera& now = place.state.eye.free;
            CHECK(now.position_m.x == to.x_m);
            CHECK(now.position_m.z == to.z_m);
            CHECK(place.above() == Approx(above).margin(1e-6));
            CHECK(now.heading == before.heading);
            CHECK(now.pitch == before.pitch);
        }
        place.act(JumpTo{-1e9, 1e9}); // beside the terrain
        CHECK(place.state.eye.free.position_m.x == 0);
        CHECK(place.state.eye.free.position_m.z == Approx(place.state.scene.depth_m()));
    }
}

TEST_CASE("frozen, refinement stays where it was and the picture moves on") {
    CameraPlace place(4);
    const Vec3 here = place.state.eye.view.eye_m;
    place.act(FreezeRefinement{true});
    place.fly_somewhere();
    place.frame();
    REQUIRE(place.state.eye.refining);
    CHECK(length(place.state.eye.refining->eye_m - here) == 0);
    CHECK(length(place.state.eye.view.eye_m - here) > 0);
    CHECK(place.state.eye.frozen);
    place.act(FreezeRefinement{false});
    CHECK_FALSE(place.state.eye.refining);
    CHECK_FALSE(place.state.eye.frozen);
}

TEST_CASE("a path is followed as it is held, until a hand moves the camera") {
    CameraPlace place(6);
    place.act(AddPoint{});
    for (int i = 0; i < 3; ++i) {
        place.act(JumpTo{30.0 * (i + 1) * place.state.scene.spacing_m[0], 40 * place.state.scene.spacing_m[1]});
        place.act(AddPoint{});
    }
    REQUIRE(place.state.route.points().size() == 4);
    place.act(SetPathSeconds{4});
    place.act(PlayPath{true});
    CHECK(place.state.eye.navigation == Navigation::path);
    for (int i = 0; i < 60; ++i) place.frame();
    CHECK(place.state.route.share() == Approx(0.25).margin(1e-9));
    CHECK(length(place.state.eye.view.eye_m - place.state.route.pose().position_m) == 0);
    place.act(MoveCamera{}); // of a frame in which nothing was touched
    CHECK(place.state.route.playing());
    MoveCamera look;
    look.right_rad = 0.1;
    place.act(look);
    CHECK_FALSE(place.state.route.playing());
    CHECK(place.state.eye.navigation == Navigation::fly);
    place.act(SeekPath{1});
    place.frame();
    CHECK(length(place.state.eye.view.eye_m - place.state.route.poses().back().position_m) == 0);
    place.act(ClearPath{});
    CHECK(place.state.route.empty());
    place.act(RestorePath{});
    CHECK(place.state.route.points().size() == 4);
}

TEST_CASE("what cannot be done says so and changes nothing") {
    CameraPlace place(8);
    const auto told = [&place] { // the same again is counted
        std::size_t times = 0;
        for (const Message& message : place.state.messages.all) times += message.times;
        return times;
    };
    const std::size_t said = told();
    const session::FreeCamera before = place.state.eye.free;
    for (const Command& command :
         std::initializer_list<Command>{PlayPath{true}, SeekPath{0.5}, SetNavigation{Navigation::path}, RemovePoint{0},
                                        RestorePath{}, SavePath{}, PlaceCamera{{1e9, 0, 0}, 0, 0}})
        place.act(command);
    CHECK(told() == said + 7);
    for (const Message& message : place.state.messages.all) CHECK(message.severity == Severity::error);
    CHECK(place.state.eye.navigation == Navigation::fly);
    CHECK(length(place.state.eye.free.position_m - before.position_m) == 0);
    CHECK(place.state.route.empty());
}
