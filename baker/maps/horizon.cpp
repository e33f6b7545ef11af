// Each step of a ray moves all points of a tile by the same way, so a step is a sum of shifted rows: of two rows of a
// level, mixed by where the shifted row lies between them, and along the row by weights that are the same for all
// points (fine levels) or repeat (coarse ones).
#include "baker/maps/horizon.h"

#include <algorithm>
#include <cmath>

#include "shared/compiler.h"
#include "shared/horizon.h"

namespace fjell::baker {

namespace {

// A level serves from 12 of its cells away to 24, and a ray doubles its distance in six steps, each of 1.5 to 3 cells.
constexpr double cells_away = 12;
constexpr std::int32_t halo = static_cast<std::int32_t>(2 * cells_away) + 2;
constexpr std::int32_t block_rows = 16; // of points at a time: what they use stays in the nearest cache

struct Step {
    int level = 0;
    double distance = 1; // in units of the lesser spacing
};

std::vector<Step> steps_of(const HorizonLevels& levels) {
    const auto& spacing = levels.spacing_m();
    const double unit = std::min(spacing[0], spacing[1]);
    const Window& all = levels.extents(0);
    const double most = std::hypot((all.columns - 1) * spacing[0], (all.rows - 1) * spacing[1]) / unit;
    std::vector<Step> steps;
    int level = 0;
    for (double d = 1; d <= most; d = std::max(d + 1, d * horizon_growth)) {
        while (level + 1 < levels.count() && d >= std::ldexp(cells_away, level + 1)) ++level;
        steps.push_back({level, d});
    }
    return steps;
}

// ---- kernels: one row of points, one step ------------------------------------------------------------------------

struct Rows {
    const float *north, *south; // of the level
    float towards_south;
};

// Points that lie as far apart as the level's vertices.
FJELL_CLONES void raise_1(const Rows& rows, float towards_east, const float* own, float per_m,
                          float* FJELL_RESTRICT tangent, std::size_t n) {
    const float *a = rows.north, *b = rows.south, v = rows.towards_south;
    for (std::size_t i = 0; i < n; ++i) {
        const float west = a[i] + (b[i] - a[i]) * v, east = a[i + 1] + (b[i + 1] - a[i + 1]) * v;
        const float t = (west + (east - west) * towards_east - own[i]) * per_m;
        tangent[i] = t > tangent[i] ? t : tangent[i];
    }
}
// Twice as far.
FJELL_CLONES void raise_2(const Rows& rows, float towards_east, const float* own, float per_m,
                          float* FJELL_RESTRICT tangent, std::size_t n) {
    const float *a = rows.north, *b = rows.south, v = rows.towards_south;
    for (std::size_t i = 0; i < n; ++i) {
        const float west = a[2 * i] + (b[2 * i] - a[2 * i]) * v,
                    east = a[2 * i + 1] + (b[2 * i + 1] - a[2 * i + 1]) * v;
        const float t = (west + (east - west) * towards_east - own[i]) * per_m;
        tangent[i] = t > tangent[i] ? t : tangent[i];
    }
}
FJELL_CLONES void mix_rows(const Rows& rows, std::size_t n, float* FJELL_RESTRICT to) {
    const float *a = rows.north, *b = rows.south, v = rows.towards_south;
    for (std::size_t i = 0; i < n; ++i) to[i] = a[i] + (b[i] - a[i]) * v;
}
FJELL_CLONES void raise_any(const float* mixed, const std::int32_t* vertex, const float* towards_east, const float* own,
                            float per_m, float* FJELL_RESTRICT tangent, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const float west = mixed[vertex[i]], east = mixed[vertex[i] + 1];
        const float t = (west + (east - west) * towards_east[i] - own[i]) * per_m;
        tangent[i] = t > tangent[i] ? t : tangent[i];
    }
}

// A direction's share of a row of points: the sky that is there, and what there would be over an endless slope.
struct SkyRow {
    const float *rise_east, *rise_south; // of the ground, metres a metre
    float* there;
    float* whole;
};
FJELL_CLONES void finish_direction(const float* tangent, float east, float south, const SkyRow& sky,
                                   float* FJELL_RESTRICT sine, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const float t = tangent[i] > 0 ? tangent[i] : 0, s = t / std::sqrt(1 + t * t);
        sine[i] = s;
        const float x = sky.rise_east[i], z = sky.rise_south[i];
        const float up = 1 / std::sqrt(1 + x * x + z * z), rise = x * east + z * south;
        const float own = rise > 0 ? rise : 0, slope = own / std::sqrt(1 + own * own);
        sky.there[i] += sky_above(s > slope ? s : slope, -rise * up, up);
        sky.whole[i] += sky_above(slope, -rise * up, up);
    }
}

// ---- one window of points ----------------------------------------------------------------------------------------

class Marcher {
public:
    Marcher(const HorizonLevels& levels, int stride_log2, const Window& points, const std::vector<LevelWindow>& seen,
            TexelPlanes& out)
        : levels_(levels), stride_log2_(stride_log2), points_(points), seen_(seen), out_(out), steps_(steps_of(levels)),
          n_(static_cast<std::size_t>(points.columns)), own_(n_ * block_rows), tangent_(n_ * block_rows), mixed_(n_),
          vertex_(n_), towards_east_(n_), east_(n_ * block_rows), south_(n_ * block_rows), there_(n_ * block_rows),
          whole_(n_ * block_rows) {
        std::size_t widest = 0;
        for (const LevelWindow& w : seen) widest = std::max(widest, static_cast<std::size_t>(w.at.columns));
        mixed_.resize(widest);
    }

    void run() {
        for (std::int32_t y = points_.y; y < points_.y + points_.rows; y += block_rows) {
            first_row_ = y;
            rows_ = std::min(block_rows, points_.y + points_.rows - y);
            load_own();
            std::fill(there_.begin(), there_.end(), 0.0f);
            std::fill(whole_.begin(), whole_.end(), 0.0f);
            for (std::size_t direction = 0; direction < horizon_directions; ++direction) march(direction);
            store_sky();
        }
    }

private:
    [[nodiscard]] const float* row_of(int level, std::int32_t y) const {
        const LevelWindow& w = seen_[static_cast<std::size_t>(level)];
        return w.heights_m.data() + static_cast<std::size_t>(y - w.at.y) * static_cast<std::size_t>(w.at.columns);
    }
    // A point beyond the rim (the last of a row or column) takes the rim's height.
    [[nodiscard]] std::int32_t sample_x(std::int32_t point) const {
        return std::min(point << stride_log2_, levels_.extents(0).columns - 1);
    }
    [[nodiscard]] std::int32_t sample_y(std::int32_t point) const {
        return std::min(point << stride_log2_, levels_.extents(0).rows - 1);
    }
    [[nodiscard]] float* out_row(std::size_t plane, std::int32_t row) const {
        return out_.channel[plane].data() + static_cast<std::size_t>(first_row_ + row - points_.y) * n_;
    }

    void load_own() {
        const Window& all = levels_.extents(0);
        const auto& spacing = levels_.spacing_m();
        for (std::int32_t j = 0; j < rows_; ++j) {
            const std::int32_t y = sample_y(first_row_ + j);
            const std::int32_t north = std::max(y - 1, 0), south = std::min(y + 1, all.rows - 1);
            const float *at = row_of(0, y), *above = row_of(0, north), *below = row_of(0, south);
            const auto per_south = static_cast<float>(1 / ((south - north) * spacing[1]));
            for (std::size_t i = 0; i < n_; ++i) {
                const std::int32_t x = sample_x(points_.x + static_cast<std::int32_t>(i)), first = seen_[0].at.x;
                const std::int32_t west = std::max(x - 1, 0), east = std::min(x + 1, all.columns - 1);
                const auto per_east = static_cast<float>(1 / ((east - west) * spacing[0]));
                const std::size_t k = static_cast<std::size_t>(j) * n_ + i;
                own_[k] = at[x - first];
                east_[k] = (at[east - first] - at[west - first]) * per_east;
                south_[k] = (below[x - first] - above[x - first]) * per_south;
            }
        }
    }

    void march(std::size_t direction) {
        std::fill(tangent_.begin(), tangent_.end(), 0.0f);
        const auto& spacing = levels_.spacing_m();
        const double unit = std::min(spacing[0], spacing[1]);
        for (const Step& step : steps_) {
            const double metres = step.distance * unit;
            advance(step, metres * horizon_east[direction] / spacing[0], metres * horizon_south[direction] / spacing[1],
                    static_cast<float>(1 / metres));
        }
        for (std::int32_t j = 0; j < rows_; ++j) {
            const std::size_t k = static_cast<std::size_t>(j) * n_;
            finish_direction(tangent_.data() + k, static_cast<float>(horizon_east[direction]),
                             static_cast<float>(horizon_south[direction]),
                             {east_.data() + k, south_.data() + k, there_.data() + k, whole_.data() + k},
                             out_row(direction, j), n_);
        }
    }

    // dx, dy: in samples.
    void advance(const Step& step, double dx, double dy, float per_m) {
        const LevelWindow& w = seen_[static_cast<std::size_t>(step.level)];
        const bool regular = step.level <= stride_log2_ && stride_log2_ - step.level <= 1;
        const double shift_x = std::ldexp(dx, -step.level), whole_x = std::floor(shift_x);
        const auto first_x = static_cast<std::int32_t>(whole_x) - w.at.x +
                             static_cast<std::int32_t>((std::int64_t{points_.x} << stride_log2_) >> step.level);
        if (!regular)
            for (std::size_t i = 0; i < n_; ++i) {
                const auto sample = std::int64_t{points_.x + static_cast<std::int32_t>(i)} << stride_log2_;
                const double at = std::ldexp(static_cast<double>(sample) + dx, -step.level), whole = std::floor(at);
                vertex_[i] = static_cast<std::int32_t>(whole) - w.at.x;
                towards_east_[i] = static_cast<float>(at - whole);
            }
        for (std::int32_t j = 0; j < rows_; ++j) {
            const auto sample = std::int64_t{first_row_ + j} << stride_log2_;
            const double at = std::ldexp(static_cast<double>(sample) + dy, -step.level), whole = std::floor(at);
            const auto y = static_cast<std::int32_t>(whole);
            const Rows rows{row_of(step.level, y), row_of(step.level, y + 1), static_cast<float>(at - whole)};
            const std::size_t k = static_cast<std::size_t>(j) * n_;
            if (!regular) {
                mix_rows(rows, static_cast<std::size_t>(w.at.columns), mixed_.data());
                raise_any(mixed_.data(), vertex_.data(), towards_east_.data(), own_.data() + k, per_m,
                          tangent_.data() + k, n_);
                continue;
            }
            const Rows from{rows.north + first_x, rows.south + first_x, rows.towards_south};
            const auto towards_east = static_cast<float>(shift_x - whole_x);
            (step.level == stride_log2_ ? raise_1 : raise_2)(from, towards_east, own_.data() + k, per_m,
                                                             tangent_.data() + k, n_);
        }
    }

    void store_sky() {
        for (std::int32_t j = 0; j < rows_; ++j) {
            float* const to = out_row(horizon_directions, j);
            const std::size_t k = static_cast<std::size_t>(j) * n_;
            for (std::size_t i = 0; i < n_; ++i)
                to[i] = whole_[k + i] > 0 ? std::min(there_[k + i] / whole_[k + i], 1.0f) : 1.0f;
        }
    }

    const HorizonLevels& levels_;
    const int stride_log2_;
    const Window points_;
    const std::vector<LevelWindow>& seen_;
    TexelPlanes& out_;
    const std::vector<Step> steps_;
    const std::size_t n_;
    std::int32_t first_row_ = 0, rows_ = 0; // of the block
    std::vector<float> own_, tangent_, mixed_;
    std::vector<std::int32_t> vertex_; // in a level's row, west of a point's shifted place
    std::vector<float> towards_east_;
    std::vector<float> east_, south_; // the ground's rise
    std::vector<float> there_, whole_;
};

} // namespace

HorizonLevels::HorizonLevels(std::int32_t columns, std::int32_t rows, const double (&spacing_m)[2]) {
    std::copy_n(spacing_m, 2, spacing_m_);
    extents_.push_back({0, 0, columns, rows});
    const double unit = std::min(spacing_m[0], spacing_m[1]);
    const double most = std::hypot((columns - 1) * spacing_m[0], (rows - 1) * spacing_m[1]) / unit;
    while (std::ldexp(cells_away, count()) <= most)
        extents_.push_back({0, 0, extents_.back().columns / 2 + 1, extents_.back().rows / 2 + 1});
}

// Level 1 above, level 2 below it, the others to the right of that one, from the top.
Window HorizonLevels::place(int level) const {
    Window w = extents(level);
    if (level >= 2) w.y = extents(1).rows;
    if (level >= 3) w.x = extents(2).columns;
    for (int i = 3; i < level; ++i) w.y += extents(i).rows;
    return w;
}

Window HorizonLevels::array() const {
    Window all;
    for (int level = 1; level < count(); ++level) {
        const Window w = place(level);
        all.columns = std::max(all.columns, w.x + w.columns);
        all.rows = std::max(all.rows, w.y + w.rows);
    }
    return all;
}

Window halved_from(const Window& finer_extents, const Window& at) {
    const std::int32_t x = std::clamp(2 * at.x - 1, 0, finer_extents.columns - 1),
                       y = std::clamp(2 * at.y - 1, 0, finer_extents.rows - 1);
    const std::int32_t end_x = std::min(2 * (at.x + at.columns), finer_extents.columns),
                       end_y = std::min(2 * (at.y + at.rows), finer_extents.rows);
    return {x, y, end_x - x, end_y - y};
}

void halve_level(const float* finer, const Window& from, const Window& finer_extents, const Window& at, float* to) {
    constexpr float weight[3] = {0.25f, 0.5f, 0.25f}, of_largest = 0.75f;
    const auto row = [&](std::int32_t y) {
        return finer + static_cast<std::size_t>(std::clamp(y, 0, finer_extents.rows - 1) - from.y) *
                           static_cast<std::size_t>(from.columns);
    };
    for (std::int32_t y = at.y; y < at.y + at.rows; ++y) {
        const float* const rows[3] = {row(2 * y - 1), row(2 * y), row(2 * y + 1)};
        for (std::int32_t x = at.x; x < at.x + at.columns; ++x) {
            float mean = 0, largest = no_ground_m;
            for (std::int32_t i = 0; i < 3; ++i) {
                const std::int32_t column = std::clamp(2 * x - 1 + i, 0, finer_extents.columns - 1) - from.x;
                for (std::size_t j = 0; j < 3; ++j) {
                    const float h = rows[j][column];
                    mean += weight[i] * weight[j] * h;
                    largest = h > largest ? h : largest;
                }
            }
            *to++ = mean + of_largest * (largest - mean);
        }
    }
}

Window seen_of_level(int level, int stride_log2, const Window& points) {
    const auto first = [&](std::int32_t point) {
        return static_cast<std::int32_t>((std::int64_t{point} << stride_log2) >> level) - halo;
    };
    const auto end = [&](std::int32_t point) {
        return static_cast<std::int32_t>((std::int64_t{point} << stride_log2) >> level) + halo + 1;
    };
    const std::int32_t x = first(points.x), y = first(points.y);
    return {x, y, end(points.x + points.columns - 1) - x, end(points.y + points.rows - 1) - y};
}

TexelPlanes horizons(const HorizonLevels& levels, int stride_log2, const Window& points,
                     const std::vector<LevelWindow>& seen) {
    TexelPlanes out(points, static_cast<int>(horizon_planes));
    Marcher(levels, stride_log2, points, seen, out).run();
    return out;
}

} // namespace fjell::baker
