#include "editor/scene/overview.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "editor/clock.h"
#include "editor/scene/panel_texture.h"
#include "fjell/query.h"

namespace fjell::editor {

namespace {

constexpr std::uint32_t texels_a_look = 16;   // at the clock
constexpr std::uint32_t first_step = 4;       // texels a side, of the first pass
constexpr std::uint32_t frames_between = 30;  // passes over a terrain that is still coming
constexpr std::uint32_t ground = 0xff2a2520u; // no texel yet, and holes: the panels' grey

using Colour = std::array<float, 3>;
// By height, from the lowest ground to the highest; sRGB.
constexpr Colour ramp[] = {{84, 118, 84},  {124, 146, 92},  {176, 168, 112},
                           {168, 134, 98}, {178, 166, 156}, {240, 242, 246}};

Colour ramp_at(float share) {
    constexpr auto last = static_cast<float>(std::size(ramp) - 1);
    const float at = std::clamp(share, 0.0F, 1.0F) * last;
    const auto i = std::min(static_cast<std::size_t>(at), std::size(ramp) - 2);
    const float f = at - static_cast<float>(i);
    Colour c{};
    for (std::size_t k = 0; k < 3; ++k) c[k] = ramp[i][k] * (1 - f) + ramp[i + 1][k] * f;
    return c;
}

std::uint32_t packed(const Colour& c) {
    std::uint32_t value = 0xff000000u;
    for (std::size_t k = 0; k < 3; ++k) value |= static_cast<std::uint32_t>(std::clamp(c[k], 0.0F, 255.0F)) << (8 * k);
    return value;
}

double extent_m(std::uint32_t samples, double spacing_m) {
    return (samples - 1) * spacing_m;
}

} // namespace

void Overview::begin(const Terrain& terrain) {
    const PackHeader& h = terrain.header();
    const double w = extent_m(h.columns, h.spacing_m[0]), d = extent_m(h.rows, h.spacing_m[1]), longer = std::max(w, d);
    const auto texels = [&](double m) {
        const auto n = static_cast<std::uint32_t>(std::lround(longer_texels * m / longer));
        return std::clamp(n, least_texels, longer_texels);
    };
    columns_ = texels(w);
    rows_ = texels(d);
    heights_.assign(std::size_t{columns_} * rows_, 0.0F);
    texels_.assign(heights_.size(), ground);
    column_ = row_ = rest_frames_ = 0;
    dirty_begin_ = 0;
    dirty_end_ = rows_;
    step_ = first_step;
    done_ = false;
    first_ = true;
    texture_ = {}; // it may have another size now
}

void Overview::end() {
    columns_ = rows_ = dirty_end_ = dirty_begin_ = 0;
    done_ = true;
    texture_ = {};
}

double Overview::share() const {
    return done_ || !first_ ? 1 : static_cast<double>(row_) / rows_;
}

void Overview::advance(const Terrain& terrain, bool complete, double budget_us) {
    if (done_) return;
    if (rest_frames_ > 0) {
        --rest_frames_;
        return;
    }
    const auto until = Clock::now() + std::chrono::duration<double, std::micro>(budget_us);
    if (column_ == 0 && row_ == 0) complete_ = complete;
    for (std::uint32_t n = 1;; ++n) {
        paint(terrain);
        column_ += step_;
        if (column_ >= columns_) {
            column_ = 0;
            dirty_begin_ = dirty_begin_ == dirty_end_ ? row_ : std::min(dirty_begin_, row_);
            row_ += step_;
            dirty_end_ = std::max(dirty_end_, std::min(row_, rows_));
        }
        if (row_ >= rows_) {
            row_ = 0;
            first_ = false;
            const bool fine = std::exchange(step_, 1) == 1;
            done_ = fine && complete_;
            rest_frames_ = fine ? frames_between : 0;
            return;
        }
        if (n % texels_a_look == 0 && Clock::now() >= until) return;
    }
}

void Overview::paint(const Terrain& terrain) {
    const PackHeader& h = terrain.header();
    const double half = 0.5 * step_;
    const double x = (column_ + half) * extent_m(h.columns, h.spacing_m[0]) / columns_;
    const double z = (row_ + half) * extent_m(h.rows, h.spacing_m[1]) / rows_;
    const auto accurate_m = static_cast<float>((h.max_m - h.min_m) / 512); // finer than a texel's shade
    const GroundHeight at = ground_height(terrain, x, z, accurate_m);
    const std::size_t first = std::size_t{row_} * columns_ + column_;
    heights_[first] = at.hole ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(at.height_m);
    const std::uint32_t texel = shade(terrain, column_, row_);
    for (std::uint32_t r = row_; r < std::min(row_ + step_, rows_); ++r)
        for (std::uint32_t c = column_; c < std::min(column_ + step_, columns_); ++c) {
            heights_[std::size_t{r} * columns_ + c] = heights_[first];
            texels_[std::size_t{r} * columns_ + c] = texel;
        }
}

// Lit from the north-west, by the heights to the west and to the north, which are there already.
std::uint32_t Overview::shade(const Terrain& terrain, std::uint32_t column, std::uint32_t row) const {
    const PackHeader& h = terrain.header();
    const std::size_t i = std::size_t{row} * columns_ + column;
    const float height = heights_[i];
    if (std::isnan(height)) return ground;
    const auto slope = [&](bool there, std::size_t before, double step_m) {
        const float rise = there && !std::isnan(heights_[before]) ? height - heights_[before] : 0.0F;
        return rise / static_cast<float>(step_m);
    };
    const float dx = slope(column > 0, i - 1, step_ * extent_m(h.columns, h.spacing_m[0]) / columns_);
    const float dz = slope(row > 0, i - columns_, step_ * extent_m(h.rows, h.spacing_m[1]) / rows_);
    // Slopes are drawn three times as steep, or an overview of a continent would be flat.
    const float sx = 3 * dx, sz = 3 * dz;
    const float light = (0.5F * (sx + sz) + 0.71F) / std::sqrt(sx * sx + sz * sz + 1);
    const float range = std::max(static_cast<float>(h.max_m - h.min_m), 1e-6F);
    Colour c = ramp_at((height - static_cast<float>(h.min_m)) / range);
    for (float& v : c) v *= 0.35F + 0.9F * std::clamp(light, 0.0F, 1.0F);
    return packed(c);
}

void Overview::upload(OverviewImage& image) {
    image.share = share();
    if (columns_ == 0) {
        image.texture = 0;
        return;
    }
    if (texture_.get() == 0) {
        texture_ = make_panel_texture(GL_RGBA8, columns_, rows_);
        dirty_begin_ = 0;
        dirty_end_ = rows_;
    }
    image.texture = texture_.get();
    if (dirty_begin_ == dirty_end_) return;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture_.get(), 0, 0, static_cast<GLint>(dirty_begin_), static_cast<GLsizei>(columns_),
                        static_cast<GLsizei>(dirty_end_ - dirty_begin_), GL_RGBA, GL_UNSIGNED_BYTE,
                        texels_.data() + std::size_t{dirty_begin_} * columns_);
    dirty_begin_ = dirty_end_ = 0;
}

void Overview::drop_graphics(OverviewImage& image) {
    texture_ = {};
    image.texture = 0;
}

} // namespace fjell::editor
