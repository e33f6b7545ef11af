#include <algorithm>
#include <cmath>

#include "editor/carry_out.h"

namespace fjell::editor {

namespace {

double least_above_m(const fly::Ground& ground) {
    return 0.5 * ground.cell_m; // ten times the near plane's distance
}

} // namespace

void look_at_scene(Desk desk) {
    State& state = desk.state;
    state.scene = desk.engine.scene();
    state.measures.clear();
    const fly::Ground ground = desk.engine.session().live_ground();
    // From the south, over the terrain's near third, looking at its middle.
    const double w = state.scene.width_m(), d = state.scene.depth_m(), longer = std::max(w, d);
    fly::FreeCamera camera;
    camera.position_m = {w / 2, ground.height_m(w / 2, 0.85 * d) + 0.12 * longer, 0.85 * d};
    camera.heading = 0;
    camera.pitch = -0.35;
    camera.speed_m_s = longer / 60;
    state.eye.free = camera;
    state.eye.frozen = false;
    state.eye.refining.reset();
}

void carry_out(const Move& c, Desk desk) {
    Eye& eye = desk.state.eye;
    eye.free.speed_m_s = std::clamp(eye.free.speed_m_s * std::pow(1.25, c.speed_steps), 0.01, 1e6);
    fly::look(eye.free, c.right_rad, c.up_rad);
    if (!desk.engine.is_open()) return;
    const fly::Ground ground = desk.engine.session().live_ground();
    fly::steer(eye.free, c.steering, c.seconds, ground, least_above_m(ground));
}

void carry_out(const PlaceCamera& c, Desk desk) {
    fly::FreeCamera& free = desk.state.eye.free;
    free.position_m = c.position_m;
    free.heading = c.heading_rad;
    free.pitch = c.pitch_rad;
}

void carry_out(const JumpTo&, Desk) {}

void carry_out(const SetSpeed& c, Desk desk) {
    desk.state.eye.free.speed_m_s = std::clamp(c.m_s, 0.01, 1e6);
}

void carry_out(const Navigate& c, Desk desk) {
    desk.state.eye.navigation = c.navigation;
}

void carry_out(const Freeze& c, Desk desk) {
    Eye& eye = desk.state.eye;
    eye.frozen = c.on;
    if (c.on)
        eye.refining = eye.view;
    else
        eye.refining.reset();
}

void carry_out(const OpenPath& c, Desk desk) {
    if (!c.discard && asks_first(OpenPath{c.path, true}, desk)) return;
    desk.state.route.open(c.path, desk.engine.session().ground());
}

void carry_out(const SavePath& c, Desk desk) {
    desk.state.route.save(c.path);
    if (desk.state.interface.dialog == Dialog::save_path) desk.state.interface.dialog = Dialog::none;
    go_on_saving(desk);
}
void carry_out(const RecordPath&, Desk) {}
void carry_out(const PlayPath& c, Desk desk) {
    desk.state.route.play(c.on);
    if (c.on) desk.state.eye.navigation = Navigation::path;
}
void carry_out(const SeekPath& c, Desk desk) {
    desk.state.route.seek(c.share);
}
void carry_out(const AddPoint&, Desk) {}
void carry_out(const ReplacePoint&, Desk) {}
void carry_out(const RemovePoint&, Desk) {}
void carry_out(const SelectPoint&, Desk) {}
void carry_out(const ClearPath&, Desk desk) {
    desk.state.route.clear();
}

} // namespace fjell::editor
