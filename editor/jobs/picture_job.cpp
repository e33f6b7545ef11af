// A picture of any size beside the frame. It shows the mesh that its view settles on, whatever a frame may do: budgets
// of items and time are for frames that must be in time.
#include <utility>

#include <fmt/format.h>

#include "editor/jobs/factories.h"
#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/gl/target.h"
#include "fjell/io/failure.h"
#include "flight/pictures.h"
#include "flight/session.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

void need(bool made, const std::string& error) {
    if (!made) throw io::Failure(3, error);
}

void draw_picture_of(const PicturePlan& plan, JobControl& control) {
    control.progress("open", 0, 1);
    // In the order of destruction, last first: GL objects need their context, and all the terrain.
    flight::FlightOptions options;
    flight::Session session;
    options.pack = plan.pack->path();
    options.file = plan.pack;
    options.profile = plan.profile;
    options.layers = plan.layers;
    flight::open_session(options, session);
    std::string error;
    const auto context = gl::Headless::create({}, error);
    need(context != nullptr, error);
    const auto target = flight::make_target(plan.profile.width_px, plan.profile.height_px, plan.profile, error);
    need(target != nullptr, error);
    const auto renderer = flight::make_renderer(options, session, error);
    need(renderer != nullptr, error);
    const View view = flight::view_of(plan.pose, session.terrain(), plan.profile);
    (void)flight::update_until_there(session, view, plan.profile, 0, [&](const flight::FrameEntry& poll) {
        control.check();
        error = flight::upload_mesh(*renderer, session, poll);
        need(error.empty(), error);
    });
    error = renderer->draw_uploaded(session.mesh(), view, flight::draw_options(plan.mode, plan.profile, 0), *target);
    need(error.empty(), error);
    gl::Image image;
    target->read_colour(image);
    error = gl::write_png(image, plan.path);
    need(error.empty(), error);
    control.publish([&](JobView& shown) {
        shown.output = plan.path;
        shown.result = fmt::format("{}: {} x {} pixels", plan.path, plan.profile.width_px, plan.profile.height_px);
    });
}

} // namespace

Jobs::Body picture_job(PicturePlan plan) {
    if (plan.path.empty()) throw io::Failure(2, "give the picture a file name");
    io::refuse_overwriting({plan.path}, {plan.pack->path()});
    // What no frame waits for may take its time.
    plan.profile.cut.items = unlimited_items;
    plan.profile.cut.budget_us = 0;
    plan.profile.stream.fade_s = plan.profile.stream.lookahead_s = 0;
    return [plan = std::move(plan)](JobControl& control) { draw_picture_of(plan, control); };
}

} // namespace fjell::editor
