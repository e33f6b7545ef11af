// The terrain's picture in a frame: whole, at half resolution while the camera moves and software draws, or in bands
// after that; and what lies under the panels.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include <epoxy/gl.h>

#include "editor/app.h"
#include "editor/handlers/handlers.h"
#include "fjell/gl/image.h"
#include "fjell/io/failure.h"
#include "gl/objects.h"

namespace fjell::editor {

namespace {

constexpr double band_us = 50'000, most_bands = 8; // of a whole picture that software draws after a half one
constexpr std::uint32_t band_triangles = 25'000;   // for each band of the first half one

} // namespace

gl::Target& App::fit_target(bool half) {
    const Interface& i = state_.interface;
    const std::uint32_t divisor = half ? 2 : 1;
    const std::uint32_t width = std::max(i.view_width_px / divisor, 1u),
                        height = std::max(i.view_height_px / divisor, 1u);
    std::unique_ptr<gl::Target>& target = half ? half_target_ : target_;
    if (target && target->width() == width && target->height() == height) return *target;
    if (shown_ == target.get()) shown_ = nullptr;
    if (!half) band_row_ = 0; // nothing of it is drawn
    std::string error;
    target.reset(); // the old one's memory first
    target = gl::Target::create({width, height, 1}, error);
    if (!target) throw io::Failure(3, error);
    return *target;
}

void App::draw_terrain() {
    const auto start = Clock::now();
    // Who asks for a picture gets it whole.
    const bool in_steps = state_.interface.half_resolution && software_ && after_frame_.empty();
    {
        const OwnCode own(watch_);
        engine_.build_lines(state_);
    }
    const bool was_half = shown_ != nullptr && shown_ == half_target_.get();
    // A mesh from nothing costs its frame enough: what was shown before it is shown once more.
    const bool opened = rehearsed_ != 0; // by a thread; the first pack, of the command line, is shown at once
    if (in_steps && entry_.rebuilt && (opened || shown_ != nullptr)) return;
    // After that, and after a motion, the mesh still changes for a while.
    const bool another = drawn_terrain_ != engine_.terrains();
    const bool half = in_steps && (moving_ || another || (was_half && mesh_changed_));
    const bool in_bands = in_steps && was_half && !half && !state_.compared.there;
    const gl::Target& target = fit_target(half);
    PictureRows rows;
    // The first picture of a terrain comes in bands as well, while what was shown before it stays, unless the camera
    // moves.
    if (half && another && opened && !state_.compared.there && shown_ != half_target_.get())
        rows = next_first_band(target.height());
    if (in_bands) rows = next_band(target.height());
    if (rows.end == 0 || in_bands) shown_ = in_bands ? half_target_.get() : nullptr;
    engine_.draw(state_, target, rows);
    first_row_ = half && rows.end < target.height() ? rows.end : 0;
    if (first_row_ != 0) {
        times_.draw_us = microseconds(Clock::now() - start);
        return;
    }
    const bool whole = !half && (!in_bands || rows.end == target.height());
    if (!in_bands) comparison_.draw(state_, target);
    if (whole || half) engine_.draw_lines(state_, target); // beyond the divider too, and no difference
    if (whole || half) shown_ = &target;
    band_row_ = whole || half ? 0 : rows.end;
    drew_half_ = half;
    drawn_view_ = state_.eye.view;
    drawn_terrain_ = engine_.terrains();
    picture_old_ = !whole; // until it is
    ++state_.terrain_draws;
    if (half) ++state_.half_draws;
    if (in_bands) ++state_.band_draws;
    state_.drawn_px[0] = target.width();
    state_.drawn_px[1] = target.height();
    state_.heights_share = engine_.heights_share();
    state_.drawn = engine_.stats();
    times_.draw_us = microseconds(Clock::now() - start);
}

// The whole picture has four times the pixels of the half one and the same triangles, so it costs at most four times as
// much: so many bands that none costs more than band_us beside what its triangles cost.
PictureRows App::next_band(std::uint32_t height) const {
    const auto bands = static_cast<std::uint32_t>(std::clamp(std::ceil(4 * half_us_ / band_us), 1.0, most_bands));
    const std::uint32_t high = (height + bands - 1) / bands;
    return {band_row_, std::min(band_row_ + high, height)};
}

// A half picture costs by its triangles, most of which are smaller than its pixels.
PictureRows App::next_first_band(std::uint32_t height) {
    const View& view = state_.eye.view;
    if (first_row_ == 0)
        first_bands_ = std::min(entry_.triangles_drawn / band_triangles + 1, static_cast<std::uint32_t>(most_bands));
    else if (std::memcmp(&first_view_, &view, sizeof view) != 0)
        first_bands_ = 1;
    first_view_ = view;
    if (first_bands_ == 1) return {};
    return {first_row_, std::min(first_row_ + (height + first_bands_ - 1) / first_bands_, height)};
}

void App::draw() {
    const unsigned framebuffer = surface_->framebuffer();
    if (engine_.is_open() && picture_old_ && state_.frame != rehearsed_) attempt([&] { draw_terrain(); });
    const auto start = Clock::now();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glClearColor(0.06F, 0.065F, 0.075F, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    const Interface& i = state_.interface;
    if (engine_.is_open() && shown_ != nullptr)
        blit(*shown_, framebuffer, i.height_px, {i.view_x_px, i.view_y_px, i.view_width_px, i.view_height_px});
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    surface_->draw_interface();
    times_.present_us = microseconds(Clock::now() - start);
}

} // namespace fjell::editor
