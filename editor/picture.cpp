#include "editor/picture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

constexpr double band_us = 50'000, most_bands = 8; // of a whole picture that software draws after a half one
constexpr std::uint32_t band_triangles = 25'000;   // for each band of the first half one

bool waits_for_normals(const Engine& engine) { // of ground that has moved
    return engine.is_open() && engine.stats().ground_waiting != 0;
}

} // namespace

void TerrainPicture::redraw() {
    old_ = true;
    band_row_ = 0;
}

void TerrainPicture::judge(const State& state, const Engine& engine, const PictureFrame& frame) {
    moving_ = engine.is_open() && shown_ != nullptr && std::memcmp(&drawn_view_, &state.eye.view, sizeof(View)) != 0;
    const session::FrameEntry& e = frame.entry;
    const StreamReport& r = e.stream;
    mesh_changed_ = e.rebuilt || e.activations != 0 || e.deactivations != 0 || e.morphing != 0 || e.upload_bytes != 0 ||
                    (e.streamed && (!r.maps_converged || r.mips_uploaded != 0));
    const bool shaded_anew = ground_waiting_ || waits_for_normals(engine);
    ground_waiting_ = waits_for_normals(engine);
    const bool reading = state.shows(Overlay::error) && state.heights_share >= 0 && state.heights_share < 1;
    const Interface& i = state.interface;
    const bool sized = shown_ == whole_.get() && whole_ &&
                       (whole_->width() != i.view_width_px || whole_->height() != i.view_height_px);
    if (moving_ || mesh_changed_ || shaded_anew || reading || sized || shown_ == nullptr || state.route.recording())
        redraw();
    if (frame.asked && shown_ != whole_.get()) redraw();
    if (frame.compared_changed || drawn_terrain_ != engine.terrains()) redraw();
}

gl::Target& TerrainPicture::fit(const Interface& i, bool half) {
    const std::uint32_t divisor = half ? 2 : 1;
    const std::uint32_t width = std::max(i.view_width_px / divisor, 1u),
                        height = std::max(i.view_height_px / divisor, 1u);
    std::unique_ptr<gl::Target>& target = half ? half_ : whole_;
    if (target && target->width() == width && target->height() == height) return *target;
    if (shown_ == target.get()) shown_ = nullptr;
    if (!half) band_row_ = 0; // nothing of it is drawn
    target.reset();           // the old one's memory first
    target = gl::Target::create({width, height, 1});
    return *target;
}

void TerrainPicture::draw(State& state, Engine& engine, Comparison& comparison, const PictureFrame& frame,
                          FrameTimes& times) {
    const auto start = Clock::now();
    const bool in_steps = state.interface.half_resolution && state.software && !frame.asked;
    {
        const OwnCode own(frame.watch);
        engine.build_lines(state);
    }
    const bool was_half = shown_ != nullptr && shown_ == half_.get();
    // A mesh from nothing costs its frame enough: what was shown before it is shown once more.
    if (in_steps && frame.entry.rebuilt && (frame.opened || shown_ != nullptr)) return;
    // After that, and after a motion, the mesh still changes for a while.
    const bool another = drawn_terrain_ != engine.terrains();
    const bool half = in_steps && (moving_ || another || (was_half && mesh_changed_));
    const bool in_bands = in_steps && was_half && !half && !state.compared.there;
    const gl::Target& target = fit(state.interface, half);
    PictureRows rows;
    // The first picture of a terrain comes in bands as well, while what was shown before it stays, unless the camera
    // moves.
    if (half && another && frame.opened && !state.compared.there && shown_ != half_.get())
        rows = next_first_band(state.eye.view, frame.entry, target.height());
    if (in_bands) rows = next_band(target.height());
    if (rows.end == 0 || in_bands) shown_ = in_bands ? half_.get() : nullptr;
    engine.draw(state, target, rows);
    first_row_ = half && rows.end < target.height() ? rows.end : 0;
    if (first_row_ != 0) {
        times.draw_us = microseconds(Clock::now() - start);
        return;
    }
    const bool whole = !half && (!in_bands || rows.end == target.height());
    if (!in_bands) comparison.draw(state, target);
    if (whole || half) engine.draw_lines(state, target); // beyond the divider too, and no difference
    if (whole || half) shown_ = &target;
    band_row_ = whole || half ? 0 : rows.end;
    drew_half_ = half;
    drawn_view_ = state.eye.view;
    drawn_terrain_ = engine.terrains();
    old_ = !whole; // until it is
    ++state.terrain_draws;
    if (half) ++state.half_draws;
    if (in_bands) ++state.band_draws;
    state.drawn_px[0] = target.width();
    state.drawn_px[1] = target.height();
    state.heights_share = engine.heights_share();
    state.drawn = engine.stats();
    times.draw_us = microseconds(Clock::now() - start);
}

// The whole picture has four times the pixels of the half one and the same triangles, so it costs at most four times as
// much: so many bands that none costs more than band_us beside what its triangles cost.
PictureRows TerrainPicture::next_band(std::uint32_t height) const {
    const auto bands = static_cast<std::uint32_t>(std::clamp(std::ceil(4 * half_us_ / band_us), 1.0, most_bands));
    const std::uint32_t high = (height + bands - 1) / bands;
    return {band_row_, std::min(band_row_ + high, height)};
}

// A half picture costs by its triangles, most of which are smaller than its pixels.
PictureRows TerrainPicture::next_first_band(const View& view, const session::FrameEntry& entry, std::uint32_t height) {
    if (first_row_ == 0)
        first_bands_ = std::min(entry.triangles_drawn / band_triangles + 1, static_cast<std::uint32_t>(most_bands));
    else if (std::memcmp(&first_view_, &view, sizeof view) != 0)
        first_bands_ = 1;
    first_view_ = view;
    if (first_bands_ == 1) return {};
    return {first_row_, std::min(first_row_ + (height + first_bands_ - 1) / first_bands_, height)};
}

void TerrainPicture::end_frame(const FrameTimes& times) {
    if (std::exchange(drew_half_, false))
        half_us_ = (times.draw_us + times.present_us) * std::exchange(first_bands_, 1);
}

void TerrainPicture::drop_graphics() {
    shown_ = nullptr;
    whole_.reset();
    half_.reset();
}

} // namespace fjell::editor
