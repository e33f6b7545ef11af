#include "baker/maps/smooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

// How many squares beside the wanted ones a level is smoothed over: one for the smoothing itself, one for the level
// below, which lies between two of this one.
constexpr std::int32_t smooth_reach[most_smooth_levels + 1] = {1, 3, 4, 4, 4};

// Squares of a level. Rows are columns floats apart.
struct Squares {
    Window at;
    Buffer<float> values; // not cleared

    explicit Squares(const Window& window) : at(window), values(window.area()) {}
    [[nodiscard]] float* row(std::int32_t y) {
        return values.data() + static_cast<std::size_t>(y - at.y) * static_cast<std::size_t>(at.columns);
    }
    [[nodiscard]] const float* row(std::int32_t y) const {
        return values.data() + static_cast<std::size_t>(y - at.y) * static_cast<std::size_t>(at.columns);
    }
};

Window squares_of(const Window& samples, int level, std::int32_t beside) {
    const std::int32_t x = (samples.x >> level) - beside, y = (samples.y >> level) - beside;
    return {x, y, ((samples.x + samples.columns - 1) >> level) + beside + 1 - x,
            ((samples.y + samples.rows - 1) >> level) + beside + 1 - y};
}

// All samples that the surface over `wanted` sees, some of them beyond the rim: whole squares of the coarsest level.
Window seen_by_smooth(const SmoothGround& ground, const Window& wanted) {
    const int l = ground.levels;
    const Window w = squares_of(wanted, l, smooth_reach[l] + 1); // the bound looks at the means beside
    return {w.x << l, w.y << l, w.columns << l, w.rows << l};
}

// Where a sample beyond the rim is reflected to, and back from which.
struct Reflected {
    std::int32_t from, about;
    bool beyond;
};
Reflected reflected(std::int32_t at, std::int32_t count) {
    const std::int32_t last = count - 1;
    if (at < 0) return {std::min(-at, last), 0, true};
    if (at > last) return {std::max(2 * last - at, 0), last, true};
    return {at, at, false};
}

// Along one axis, what of the terrain [first, end) sees.
std::pair<std::int32_t, std::int32_t> read_along(std::int32_t first, std::int32_t end, std::int32_t count) {
    std::int32_t least = std::max(first, 0), most = std::min(end, count) - 1;
    for (const std::int32_t edge : {first, end - 1}) {
        const Reflected r = reflected(edge, count);
        least = std::min({least, r.from, r.about}), most = std::max({most, r.from, r.about});
    }
    return {least, most + 1};
}

Squares samples_and_beyond(const SmoothGround& ground, const HeightWindow& heights, const Window& seen) {
    Squares all(seen);
    const std::int32_t inner = std::max(seen.x, 0), outer = std::min(seen.x + seen.columns, ground.columns);
    const auto row_of = [&](std::int32_t y) { return heights.heights_m + (y - heights.at.y) * heights.stride; };
    for (std::int32_t y = seen.y; y < seen.y + seen.rows; ++y) {
        const Reflected down = reflected(y, ground.rows);
        const float *const from = row_of(down.from) - heights.at.x, *const about = row_of(down.about) - heights.at.x;
        float* const to = all.row(y) - seen.x;
        if (down.beyond)
            for (std::int32_t x = inner; x < outer; ++x) to[x] = 2 * about[x] - from[x];
        else
            std::copy(from + inner, from + outer, to + inner);
        const auto at = [&](std::int32_t x) { return down.beyond ? 2 * about[x] - from[x] : from[x]; };
        const auto go_on = [&](std::int32_t first, std::int32_t end) {
            for (std::int32_t x = first; x < end; ++x) {
                const Reflected across = reflected(x, ground.columns);
                to[x] = 2 * at(across.about) - at(across.from);
            }
        };
        go_on(seen.x, inner);
        go_on(outer, seen.x + seen.columns);
    }
    return all;
}

FJELL_CLONES void mean_row(const float* north, const float* south, float* FJELL_RESTRICT to, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i)
        to[i] = 0.25f * ((north[2 * i] + north[2 * i + 1]) + (south[2 * i] + south[2 * i + 1]));
}

Squares means_of(const Squares& finer) {
    Squares means({finer.at.x >> 1, finer.at.y >> 1, finer.at.columns >> 1, finer.at.rows >> 1});
    for (std::int32_t y = means.at.y; y < means.at.y + means.at.rows; ++y)
        mean_row(finer.row(2 * y), finer.row(2 * y + 1), means.row(y), means.at.columns);
    return means;
}

// How far from its mean a square may lie. Half a step; where the ground climbs more than half a step from square to
// square, its mean is over several of them, and known the better for it.
FJELL_CLONES void bounds_of_row(const float* mean, const float* north, const float* south, float step_m,
                                float* FJELL_RESTRICT to, std::int32_t n) {
    constexpr float per_climb = 4;
    const float half = 0.5f * step_m;
    for (std::int32_t i = 0; i < n; ++i) {
        const float across = mean[i + 1] - mean[i - 1], down = south[i] - north[i];
        const float climb = 0.5f * ((across < 0 ? -across : across) + (down < 0 ? -down : down)) - half;
        to[i] = half * step_m / (step_m + per_climb * (climb < 0 ? 0 : climb));
    }
}

FJELL_CLONES void hold_within(const float* mean, const float* bound, float* FJELL_RESTRICT values, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) {
        const float least = mean[i] - bound[i], most = mean[i] + bound[i];
        const float v = values[i] < least ? least : values[i];
        values[i] = v > most ? most : v;
    }
}

// A row of squares between those of the coarser level: three parts of the one that it lies in, one of the next.
FJELL_CLONES void between_rows(const float* in, const float* next, float* FJELL_RESTRICT line, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) line[i] = 0.75f * in[i] + 0.25f * next[i];
}
// line: the coarser squares from the one before that of the first pair on.
FJELL_CLONES void between_columns(const float* line, float* FJELL_RESTRICT to, std::int32_t pairs) {
    for (std::int32_t i = 0; i < pairs; ++i) {
        const float here = 0.75f * line[i + 1];
        to[2 * i] = here + 0.25f * line[i];
        to[2 * i + 1] = here + 0.25f * line[i + 2];
    }
}

FJELL_CLONES void smooth_across(const float* row, float* FJELL_RESTRICT to, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) to[i] = 0.25f * (row[i - 1] + row[i + 1]) + 0.5f * row[i];
}
FJELL_CLONES void smooth_down(const float* north, const float* row, const float* south, float* FJELL_RESTRICT to,
                              std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) to[i] = 0.25f * (north[i] + south[i]) + 0.5f * row[i];
}

// One level: from the coarser one, or from its own means at the coarsest, to `wanted` of it. Row by row: three rows
// that are smoothed across are kept.
class SmoothLevel {
public:
    SmoothLevel(const Squares& means, const Squares* coarser, float step_m, bool samples)
        : means_(means), coarser_(coarser), step_m_(step_m), samples_(samples) {}

    void make(Squares& to) {
        width_ = to.at.columns;
        const auto wide = static_cast<std::size_t>(width_);
        // A pair more on each side: pairs begin at even places, and the row is one longer on each side.
        begun_.resize(wide + 6);
        line_.resize(wide / 2 + 8);
        bound_.assign(wide + 2, 0.5f * step_m_);
        for (auto& row : across_) row.resize(wide);
        for (std::int32_t y = to.at.y - 1; y < to.at.y + to.at.rows + 1; ++y) {
            begin_row(to.at.x - 1, y);
            smooth_across(begun_.data() + begun_first_ + 1, across_[slot(y)].data(), width_);
            if (y < to.at.y + 1) continue;
            const std::int32_t done = y - 1;
            float* const out = to.row(done);
            smooth_down(across_[slot(done - 1)].data(), across_[slot(done)].data(), across_[slot(y)].data(), out,
                        width_);
            hold(to.at.x, done, out, width_);
        }
    }

private:
    [[nodiscard]] static std::size_t slot(std::int32_t y) { return static_cast<std::size_t>(y + 0x30000000) % 3; }
    [[nodiscard]] const float* mean(std::int32_t x, std::int32_t y) const { return means_.row(y) + (x - means_.at.x); }
    void hold(std::int32_t x, std::int32_t y, float* values, std::int32_t n) {
        if (!samples_) bounds_of_row(mean(x, y), mean(x, y - 1), mean(x, y + 1), step_m_, bound_.data(), n);
        hold_within(mean(x, y), bound_.data(), values, n);
    }
    // From x on, width_ + 2 squares, within their bound.
    void begin_row(std::int32_t x, std::int32_t y) {
        begun_first_ = 0;
        if (!coarser_) {
            std::copy_n(mean(x, y), width_ + 2, begun_.data());
            return;
        }
        const std::int32_t in = y >> 1, next = y & 1 ? in + 1 : in - 1, first = x >> 1;
        const std::int32_t pairs = ((x + width_ + 1) >> 1) - first + 1, skip = first - 1 - coarser_->at.x;
        between_rows(coarser_->row(in) + skip, coarser_->row(next) + skip, line_.data(), pairs + 2);
        between_columns(line_.data(), begun_.data(), pairs);
        begun_first_ = static_cast<std::size_t>(x & 1);
        hold(x, y, begun_.data() + begun_first_, width_ + 2);
    }

    const Squares& means_;
    const Squares* coarser_;
    const float step_m_;
    const bool samples_;
    std::int32_t width_ = 0;
    std::size_t begun_first_ = 0;
    Buffer<float> begun_, line_, bound_;
    std::array<Buffer<float>, 3> across_;
};

} // namespace

SmoothGround smooth_ground(std::int32_t columns, std::int32_t rows, const double (&spacing_m)[2], double native_step_m,
                           const HeightStatistics& heights) {
    constexpr double least_of_spacing = 1.0 / 40, coarse_of_spacing = 0.5;
    const double spacing = std::min(spacing_m[0], spacing_m[1]);
    const double step_m = std::max(native_step_m, heights.whole_m());
    if (step_m < least_of_spacing * spacing) return {columns, rows};
    return {columns, rows, static_cast<float>(step_m),
            step_m < coarse_of_spacing * spacing ? most_smooth_levels - 1 : most_smooth_levels};
}

Window heights_for_smooth(const SmoothGround& ground, const Window& wanted) {
    if (!ground.smooths() || wanted.area() == 0) return wanted;
    const Window seen = seen_by_smooth(ground, wanted);
    const auto [x, end_x] = read_along(seen.x, seen.x + seen.columns, ground.columns);
    const auto [y, end_y] = read_along(seen.y, seen.y + seen.rows, ground.rows);
    return {x, y, end_x - x, end_y - y};
}

Buffer<float> smooth_heights(const SmoothGround& ground, const HeightWindow& heights, const Window& wanted) {
    std::vector<Squares> means;
    means.reserve(static_cast<std::size_t>(ground.levels) + 1);
    means.push_back(samples_and_beyond(ground, heights, seen_by_smooth(ground, wanted)));
    for (int level = 1; level <= ground.levels; ++level) means.push_back(means_of(means.back()));
    std::optional<Squares> coarser;
    for (int level = ground.levels; level >= 0; --level) {
        Squares made(level == 0 ? wanted : squares_of(wanted, level, smooth_reach[level] - 1));
        const Squares& own = means[static_cast<std::size_t>(level)];
        SmoothLevel(own, coarser ? &*coarser : nullptr, ground.step_m, level == 0).make(made);
        coarser.emplace(std::move(made));
        means.pop_back();
    }
    return std::move(coarser->values);
}

} // namespace fjell::baker
