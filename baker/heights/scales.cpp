// Quantise first, then measure errors on the quantised surface: what it differs from the original by is half a quantum,
// which every bound allows for (invariant 3, section 5).
#include "baker/heights/scales.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "shared/compiler.h"

namespace fjell::baker {

namespace {

using io::Failure;

constexpr double page_steps = 65535;
constexpr double height_steps = max_height_steps - 65536;
constexpr double finest_quantum_m = 1e-6; // less is noise of the source's own floats
constexpr double above = 1 + 0x1p-20;     // more than the float roundings of a bound

// To three digits, so that what a message names is enough.
double rounded_up(double quantum_m) {
    const double unit = std::pow(10.0, std::floor(std::log10(quantum_m)) - 2);
    return std::ceil(quantum_m / unit) * unit;
}

} // namespace

double least_quantum_m(const HeightStatistics& heights) {
    const double range = static_cast<double>(heights.most_m) - static_cast<double>(heights.least_m);
    // Rounded up, so that the highest sample still has a step.
    return std::max(static_cast<double>(heights.tile_range_m) / page_steps, range / height_steps) * (1 + 0x1p-22);
}

HeightScale choose_height_scale(const HeightStatistics& heights, const HeightScaleRequest& request) {
    const double base = heights.least_m, range = static_cast<double>(heights.most_m) - base;
    const double needed = least_quantum_m(heights);
    const auto height_scale = [&](double quantum) {
        return HeightScale{static_cast<float>(base), std::nextafter(static_cast<float>(quantum), HUGE_VALF)};
    };
    if (request.asked_m > 0) {
        if (request.asked_m < std::max(needed, finest_quantum_m))
            throw Failure(2,
                          fmt::format("--quantum {} m is too small for these heights: {} steps of 16 bits span the "
                                      "{:.6g} m within one tile{}; give at least {:.3g}, or smaller tiles with --tile",
                                      request.asked_m, page_steps + 1, heights.tile_range_m,
                                      request.tile_cells ? fmt::format(" of {} cells", request.tile_cells) : "",
                                      rounded_up(std::max(needed, finest_quantum_m))));
        return {static_cast<float>(base), static_cast<float>(request.asked_m)};
    }
    if (request.native_quantum_m > 0 && needed <= request.native_quantum_m)
        return {static_cast<float>(base), static_cast<float>(request.native_quantum_m)};
    if (range == 0) return {static_cast<float>(base), 1.0f};
    const double of_use = std::min({0.01, request.spacing_m[0] / 100, request.spacing_m[1] / 100});
    return height_scale(std::max({needed, of_use, finest_quantum_m}));
}

// Heights are not below the base and not above the last step: what is added rounds, what is cut off is positive.
FJELL_CLONES void quantise(const float* heights_m, std::size_t count, const HeightScale& height_scale,
                           std::int32_t* steps) {
    const double base = height_scale.base_m, per_metre = 1 / static_cast<double>(height_scale.quantum_m);
    constexpr double most = max_height_steps;
    for (std::size_t i = 0; i < count; ++i) {
        double v = (static_cast<double>(heights_m[i]) - base) * per_metre + 0.5;
        v = v > 0.0 ? v : 0.0;
        v = v < most ? v : most;
        steps[i] = static_cast<std::int32_t>(v);
    }
}

FJELL_CLONES bool lie_on(const HeightScale& height_scale, const float* heights_m, const std::int32_t* steps,
                         std::size_t count) {
    std::int32_t off = 0;
    for (std::size_t i = 0; i < count; ++i) off |= height_scale.height_m(steps[i]) == heights_m[i] ? 0 : 1;
    return off == 0;
}

namespace {

// Bounds that hold for every vertex of a step.
class Bounds {
public:
    explicit Bounds(const ScaleInput& input) : in_(input) {
        const double q = input.height_scale.quantum_m;
        range_m_ = static_cast<double>(input.heights.tile_range_m) + q; // of quantised heights
        for (const int axis : {0, 1}) step_m_[axis] = static_cast<double>(input.heights.step_m[axis]) + q;
    }
    // Between places dx columns and dy rows apart in one tile: no way along the grid climbs more.
    [[nodiscard]] double climb_m(double dx, double dy) const {
        return std::min(range_m_, dx * step_m_[0] + dy * step_m_[1]);
    }
    [[nodiscard]] double distance_m(double dx, double dy, double dh) const {
        return std::sqrt(dx * in_.spacing_m[0] * dx * in_.spacing_m[0] + dy * in_.spacing_m[1] * dy * in_.spacing_m[1] +
                         dh * dh);
    }
    // Of any sample under a diamond from its triangles; over a hole's rim its own size.
    [[nodiscard]] double error_m(int z, double pad_m) const {
        const double side = 2.0 * (1 << z), climb = climb_m(side, side);
        const bool flat = in_.heights.voids == 0 && !in_.room_for_holes;
        return flat ? climb : std::max(climb, distance_m(side, side, climb) + pad_m) * above;
    }
    [[nodiscard]] double diagonal_m() const {
        return distance_m(in_.tree.columns() - 1.0, in_.tree.rows() - 1.0, range_m_);
    }

private:
    const ScaleInput& in_;
    double range_m_ = 0, step_m_[2] = {0, 0};
};

// Codes of 5% or a little more; not so many a level that a whole tile of them uses them up. The finest floor with which
// the root still has a code, were every level's worst handed up from there.
void choose_error_scale(const ScaleInput& in, const Bounds& bounds, Scales& s) {
    const double least = 1 + in.nesting;
    const int levels = 2 * in.tree.tile_log2;
    const double wish = std::ceil(std::log(least) / std::log(1.05) - 1e-6);
    s.nesting_steps = static_cast<std::uint32_t>(std::clamp(wish, 1.0, 64.0 / in.tree.tile_log2));
    s.ratio = static_cast<float>(std::max(std::pow(least, 1.0 / s.nesting_steps), 1.05) * (1 + 0x1p-20));
    s.floor_m = std::max(0.5f * in.height_scale.quantum_m, 1e-8f);
    const double always_m = in.room_for_locks ? bounds.diagonal_m() * always_drawn_share : 0;
    for (bool fits = false; !fits; s.floor_m *= fits ? 1 : 1.5f) {
        s.errors = ErrorScale::make(s.floor_m, s.ratio, s.nesting_steps);
        fits = static_cast<double>(s.errors.metres[s.errors.always(levels - 1)]) >= always_m;
        for (int level = 0; level < levels; ++level) {
            const double worst =
                bounds.error_m(in.tree.tile_log2 - 1 - level / 2, 2 * s.ground_pad_m + s.height_pad_m) *
                in.sharpest_lock * (in.sharpest_lock > 1 ? static_cast<double>(s.ratio) : 1);
            fits = fits && static_cast<double>(s.errors.metres[255]) >= worst &&
                   s.errors.code_up(worst) + s.nesting_steps * static_cast<std::uint32_t>(level) <= 255;
        }
    }
}

// Each level's unit: what its radii would be on flat ground, or more where its steepest ground asks for more than the
// codes span.
void choose_radius_units(const ScaleInput& in, const Bounds& bounds, Scales& s) {
    const double span = static_cast<double>(s.radii.factor[radius_codes - 1]);
    double flat = 0, worst = 0; // of the level below
    for (int z = 0; z < in.tree.tile_log2; ++z)
        for (const bool centre : {false, true}) {
            const double step = 1 << z;
            // To a child, or to a corner of a leaf's triangles: along an axis, or by half a step along both.
            const bool along_axis = centre || z == 0;
            const double dx = along_axis ? step : step / 2, dy = along_axis ? 0 : step / 2;
            const auto reach = [&](double x, double y, bool steep) {
                return bounds.distance_m(x, y, steep ? bounds.climb_m(x, y) + s.height_pad_m : 0) +
                       (steep ? 2 * s.ground_pad_m + s.half_quantum_m : 0);
            };
            const auto longest = [&](bool steep) { return std::max(reach(dx, dy, steep), reach(dy, dx, steep)); };
            flat = (longest(false) + flat) * sphere_margin;
            // What is below was rounded up by a code.
            worst = (longest(true) + worst) * sphere_margin * above;
            const float unit = std::nextafter(static_cast<float>(std::max(flat, worst / span * above)), HUGE_VALF);
            s.level_radius_m[2 * (in.tree.tile_log2 - 1 - z) + (centre ? 0 : 1)] = unit;
            worst = std::max<double>(worst * static_cast<double>(RadiusScale::ratio), unit);
        }
}

} // namespace

Scales choose_scales(const ScaleInput& input) {
    Scales s;
    s.height_scale = input.height_scale;
    // Positions are rounded to float, 2^-24 relative on each end, products too; heights as well.
    const double extent =
        std::max({input.tree.grid_columns() * input.spacing_m[0], input.tree.grid_rows() * input.spacing_m[1], 1e4});
    const double highest = std::max(std::abs(static_cast<double>(input.heights.least_m)),
                                    std::abs(static_cast<double>(input.heights.most_m)));
    s.ground_pad_m = extent * 0x1p-22;
    s.height_pad_m = (highest + static_cast<double>(input.heights.most_m) - input.heights.least_m) * 0x1p-22;
    s.half_quantum_m = 0.5 * static_cast<double>(input.height_scale.quantum_m);
    const Bounds bounds(input);
    choose_error_scale(input, bounds, s);
    choose_radius_units(input, bounds, s);
    return s;
}

} // namespace fjell::baker
