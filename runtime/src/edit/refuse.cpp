// Would a stamp's ground still be bounded? A pack's codes span what its own ground may ask for, and no more.
#include "edit/refuse.h"

#include <cmath>

#include "edit/errors.h"

namespace fjell::edit {

namespace {

double metres(const EditsData& e, std::int32_t steps) {
    return steps * static_cast<double>(e.terrain->header.quantum_m);
}

// Which levels have codes for any ground whose neighbours differ by no more than `steepest_m`, and all of whose heights
// lie within `range_m`. Worked out as the baker does (choose_radius_units, choose_error_scale), with all heights in one
// tile.
struct LevelFit {
    bool radii[2 * max_tile_log2], errors[2 * max_tile_log2]; // by levels_below() of their vertices
    bool all = true;
};
LevelFit fit_levels(const EditsData& e, double steepest_m, double range_m) {
    const TerrainData& t = *e.terrain;
    const double sx = t.header.spacing_m[0], sz = t.header.spacing_m[1];
    const Pads pads{e.radius.ground_pad_m, e.radius.height_pad_m};
    LevelFit fit;
    double radius_m = 0; // at most, of the level below
    for (int below = 0; below < 2 * t.tree.tile_log2; ++below) {
        const bool centre = below % 2 != 0, along_axis = centre || below == 0;
        const double step = 1 << below / 2;
        const double along_m =
            (along_axis ? step * std::max(sx, sz) : step / 2 * std::hypot(sx, sz)) + 2 * e.radius.ground_pad_m;
        const double climb_m = std::min(range_m, steepest_m * step) + e.radius.height_pad_m;
        const double leaf_m = below == 0 ? e.radius.half_quantum_m : 0, unit_m = e.radius.unit_m[below];
        const double largest_m = unit_m * static_cast<double>(t.radii.factor[radius_codes - 1]);
        radius_m = (std::hypot(along_m, climb_m) + radius_m + leaf_m) * sphere_margin * (1 + 0x1p-20);
        fit.radii[below] = radius_m <= largest_m;
        radius_m = std::clamp(radius_m * static_cast<double>(RadiusScale::ratio), unit_m, largest_m); // as it is stored
        const auto level = static_cast<std::uint32_t>(2 * t.tree.tile_log2 - 1 - below);
        const double climb_most_m = std::min(range_m, 4 * step * steepest_m);
        const double error_m =
            e.room_for_holes ? rim_m(t.header, pads, below / 2, climb_most_m) : climb_most_m; // which is no more
        fit.errors[below] = static_cast<double>(t.errors.metres[255]) >= error_m &&
                            t.errors.code_up(error_m) + t.errors.nesting_steps * level <= 255;
        fit.all = fit.all && fit.radii[below] && fit.errors[below];
    }
    return fit;
}

// Has every vertex around a change a code, whatever ground its level has codes for, and however its own ground moves?
// From the codes that it has now: an error grows by what heights under its triangles move apart by, a radius by the
// same a level, and a code for rounding. bend_m: what neighbours move apart by.
Fit keep_codes(EditsData& e, const Change& change, const LevelFit& levels, double bend_m) {
    const TerrainData& t = *e.terrain;
    const Ground ground(t, &e.window); // of what was looked at last
    const double all_m = metres(e, change.off.span());
    const auto apart_m = [&](double samples) { return std::min(all_m, samples * bend_m); };
    const auto by_m = [&](int z) { return apart_m(4.0 * (1 << z)); };
    double radius_by_m = 0;
    // Of what has its own level's codes all above it have room, too.
    const auto has_rim_code = [&](SampleIndex v) {
        if (!change.holes) return true;
        const double rim = rim_around_m(e, ground, v, change.filled) + by_m(Tree::step_log2(v));
        return static_cast<double>(t.errors.metres[255]) >= rim &&
               t.errors.code_up(rim) + t.errors.nesting_steps * static_cast<std::uint32_t>(t.tree.level(v)) <= 255;
    };
    const auto keeps_code = [&](SampleIndex v, const Cell& own) {
        const std::uint32_t below = levels_below(v), code = own.radius + below + 1;
        const float unit_m = e.radius.unit_m[below];
        return (levels.radii[below] ||
                (code < radius_codes && static_cast<double>(unit_m * t.radii.factor[code]) + radius_by_m <=
                                            static_cast<double>(unit_m * t.radii.factor[radius_codes - 1]))) &&
               (levels.errors[below] || (grown_with_descendants(t, v, own.error, by_m) <= 255 && has_rim_code(v)));
    };
    Fit fit = Fit::yes;
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        if (plane.kind != VertexKind::side_y) // both kinds of sides are one level
            radius_by_m = static_cast<double>(RadiusScale::ratio) * (radius_by_m + apart_m(2.0 * (1 << plane.z)));
        const int below = 2 * plane.z + (plane.kind == VertexKind::centre ? 1 : 0);
        if (levels.radii[below] && levels.errors[below]) return;
        const Rect squares = around(t.tree, plane, change.places);
        for (std::int32_t j = squares.y0; j <= squares.y1 && fit == Fit::yes; ++j)
            for (std::int32_t i = squares.x0; i <= squares.x1 && fit == Fit::yes; ++i) {
                const SampleIndex v = plane.at(i, j);
                const Cell own = ground.at(v);
                fit = !own.loaded ? Fit::unknown : keeps_code(v, own) ? Fit::yes : Fit::no;
            }
    });
    return fit;
}

double pack_range_m(const EditsData& e) {
    return static_cast<double>(e.terrain->header.max_m) - static_cast<double>(e.terrain->header.min_m);
}

} // namespace

bool rims_have_codes(const PackHeader& h) {
    const ErrorScale errors = ErrorScale::make(h.error_floor_m, h.error_ratio, h.error_nesting_steps);
    const Pads pads = pads_of(h, tree_of(h));
    const int levels = 2 * static_cast<int>(h.tile_log2);
    for (int level = 0; level < levels; ++level) {
        const double rim = rim_m(h, pads, (levels - 1 - level) / 2, 0);
        if (static_cast<double>(errors.metres[255]) < rim ||
            errors.code_up(rim) + errors.nesting_steps * static_cast<std::uint32_t>(level) > 255)
            return false;
    }
    return true;
}

double steepest_of_codes(const EditsData& e) {
    double low = 0, high = 1e6;
    for (int round = 0; round < 60; ++round) {
        const double middle = 0.5 * (low + high);
        (fit_levels(e, middle, pack_range_m(e)).all ? low : high) = middle;
    }
    return low;
}

bool is_at_rest(const EditsData& e, const Rect& places) {
    const TerrainData& t = *e.terrain;
    bool rests = true;
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        for_each_page(t, plane, around(t.tree, plane, places),
                      [&](std::uint32_t page) { rests = rests && t.page_table[page].slot != no_index; });
    });
    for (std::uint32_t i = 0; i < e.area_count; ++i)
        rests = rests && !e.areas[i].places.grown(2 * t.tree.side()).meets(places); // no vertex has more under it
    return rests;
}

Fit fits_codes(EditsData& e, const Change& change, bool& at_once) {
    const TerrainData& t = *e.terrain;
    const double range_m = std::max(t.range.high_m, t.height_scale.height_m(change.heights.high)) -
                           static_cast<double>(std::min(t.range.low_m, t.height_scale.height_m(change.heights.low)));
    // bend_m, steepest_m: of the stamp alone.
    const auto fit = [&](double bend_m, double steepest_m) {
        const LevelFit levels = fit_levels(e, std::max(steepest_m, e.steepest_m), std::max(range_m, pack_range_m(e)));
        return levels.all ? Fit::yes : keep_codes(e, change, levels, bend_m);
    };
    const double steepest_m = metres(e, change.steepest), bend_m = metres(e, change.bend);
    at_once = false;
    // Between its pieces there are cliffs for a while.
    const double cliff_m = change.pieces > 1 ? metres(e, change.off.span()) : 0;
    Fit found = fit(std::max(bend_m, cliff_m), steepest_m + cliff_m);
    if (found == Fit::no && change.pieces > 1) {
        found = fit(bend_m, steepest_m);
        at_once = found == Fit::yes;
    }
    return found == Fit::no && !is_at_rest(e, change.places) ? Fit::unknown : found;
}

} // namespace fjell::edit
