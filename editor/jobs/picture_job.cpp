// Pictures of any size beside the frame: one, or one for each frame of a path. Each shows the mesh that its view
// settles on, whatever a frame may do: budgets of items and time are for frames that must be in time.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "editor/jobs/factories.h"
#include "editor/jobs/measured_flight.h"
#include "editor/strings.h"
#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/gl/target.h"
#include "fjell/io/failure.h"
#include "flight/pictures.h"
#include "flight/session.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;
constexpr std::size_t most_pictures = 100'000; // five digits in their names

void need(bool made, const std::string& error) {
    if (!made) throw io::Failure(3, error);
}

// In the order of destruction, last first: GL objects need their context, and all the terrain.
struct Studio {
    flight::FlightOptions options;
    flight::Session session;
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    gl::Image image;

    Studio(const PicturePlan& plan, JobControl& control);
    void draw(const PicturePlan& plan, const flight::Pose& pose, double now_s, const std::string& file,
              JobControl& control);
};

Studio::Studio(const PicturePlan& plan, JobControl& control) {
    control.progress("open", 0, 1);
    options.pack = plan.pack->path();
    options.file = plan.pack;
    options.profile = plan.profile;
    options.layers = plan.layers;
    flight::open_session(options, session);
    std::string error;
    context = gl::Headless::create({}, error);
    need(context != nullptr, error);
    target = flight::make_target(plan.profile.width_px, plan.profile.height_px, plan.profile, error);
    need(target != nullptr, error);
    renderer = flight::make_renderer(options, session, error);
    need(renderer != nullptr, error);
}

void Studio::draw(const PicturePlan& plan, const flight::Pose& pose, double now_s, const std::string& file,
                  JobControl& control) {
    const View view = flight::view_of(pose, session.terrain(), plan.profile);
    (void)flight::update_until_there(session, view, plan.profile, now_s, [&](const flight::FrameEntry& poll) {
        control.check();
        const std::string error = flight::upload_mesh(*renderer, session, poll);
        need(error.empty(), error);
    });
    std::string error =
        renderer->draw_uploaded(session.mesh(), view, flight::draw_options(plan.mode, plan.profile, now_s), *target);
    need(error.empty(), error);
    target->read_colour(image);
    error = gl::write_png(image, file);
    need(error.empty(), error);
}

void draw_all(const PicturePlan& plan, JobControl& control) {
    Studio studio(plan, control);
    const std::string size = fmt::format("{} x {}", plan.profile.width_px, plan.profile.height_px);
    if (!plan.sequence) {
        studio.draw(plan, plan.poses.front(), 0, plan.path, control);
        control.publish([&](JobView& view) {
            view.output = plan.path;
            view.result = fmt::format(strings::results::picture, plan.path, size);
        });
        return;
    }
    for (std::size_t i = 0; i < plan.poses.size(); ++i) {
        control.progress("draw", i, plan.poses.size());
        studio.draw(plan, plan.poses[i], static_cast<double>(i) / plan.fps,
                    fmt::format("{}/frame_{:05}.png", plan.path, i), control);
    }
    control.publish([&](JobView& view) {
        view.output = plan.path;
        view.result = fmt::format(strings::results::pictures, plan.path, plan.poses.size(), size, plan.fps, plan.path);
    });
}

} // namespace

Jobs::Body picture_job(PicturePlan plan) {
    if (plan.path.empty()) throw io::Failure(2, strings::refusals::picture_without_name);
    io::refuse_overwriting({plan.path}, {plan.pack->path()});
    // What no frame waits for may take its time.
    plan.profile.cut.items = unlimited_items;
    plan.profile.cut.budget_us = 0;
    plan.profile.stream.fade_s = plan.profile.stream.lookahead_s = 0;
    if (plan.sequence) {
        const auto frames = static_cast<std::size_t>(
            std::lround(static_cast<double>(plan.poses.size()) * plan.fps / flight_poses_a_second));
        if (frames > most_pictures)
            throw io::Failure(2, fmt::format(strings::refusals::too_many_pictures, frames, most_pictures));
        plan.poses = in_frames(plan.poses, std::max<std::size_t>(frames, 2));
        std::error_code error;
        fs::create_directories(plan.path, error);
        if (error) throw io::Failure(3, fmt::format(strings::refusals::no_picture_folder, plan.path));
        if (fs::exists(plan.path + "/frame_00000.png", error))
            throw io::Failure(2, fmt::format(strings::refusals::picture_folder_used, plan.path));
    }
    return [plan = std::move(plan)](JobControl& control) { draw_all(plan, control); };
}

} // namespace fjell::editor
