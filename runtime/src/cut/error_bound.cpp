#include "cut/error_bound.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cut/evaluate.h"
#include "fjell/measure.h"

namespace fjell {

namespace {

// Of the floats that positions, errors and radii are.
constexpr double grow = 1 + 0x1p-18;

// Pixels of one metre at one metre's distance, over what the view's threshold is to that of the settings: views are
// bounded in the same units, whatever their own thresholds are.
double unit_px(const Views& views, const Frame& frame, std::uint32_t view) {
    const View& v = views.view[view];
    const double own = view_max_error_px(v, frame.settings.max_error_px) / frame.settings.max_error_px;
    return focal_length_px(v) / own * (frame.settings.corner_safe ? corner_factor(v) : 1);
}

double pixels(double unit_px, double error_m, double apart_m) {
    const double most = error_m * grow * unit_px;
    return apart_m * unbounded_px > most ? most / apart_m : error_m > 0 ? unbounded_px : 0;
}

struct PagePixels {
    double px;
    std::uint32_t slot;
};

// How near what its vertices hide may come to a view's eye.
double apart_m(const Pages& pages, const Views& views, const PageState& page, std::uint32_t view) {
    const std::int32_t cells =
        page.shape == 0 ? pages.grid.terrain->tree.side() : static_cast<std::int32_t>(2 * page_squares) << page.z;
    const Criterion& c = views.criterion;
    const PageExtent& extent = pages.loaded[page.terrain_slot].extent;
    const auto place = [](std::int32_t at, std::int32_t last, float spacing_m) {
        return static_cast<double>(static_cast<float>(std::min(at, last)) * spacing_m);
    };
    const double low[3] = {place(page.x0, c.last_x, c.spacing_x_m), static_cast<double>(extent.low_m),
                           place(page.y0, c.last_y, c.spacing_z_m)};
    const double high[3] = {place(page.x0 + cells, c.last_x, c.spacing_x_m), static_cast<double>(extent.high_m),
                            place(page.y0 + cells, c.last_y, c.spacing_z_m)};
    const double eye[3] = {views.view[view].eye_m.x, views.view[view].eye_m.y, views.view[view].eye_m.z};
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double out = std::max({low[axis] - eye[axis], eye[axis] - high[axis], 0.0});
        squared += out * out;
    }
    return std::sqrt(squared) / grow - static_cast<double>(extent.radius_m) * grow;
}

// What a page's vertices hide at most, as its bound has it: the eye may have moved since.
double bound_px(const Work& work, const Views& views, const HiddenBound& bound) {
    const double way_m = (work.schedule.odometer_m[0] - bound.from_m) * grow;
    return pixels(views.largest_unit_px, static_cast<double>(bound.error_m),
                  static_cast<double>(bound.apart_m) - way_m);
}

// Measures it anew.
double renew_bound(const Pages& pages, Work& work, const Views& views, std::uint32_t slot) {
    const PageState& page = pages.state[slot];
    double apart = 1e30;
    for (std::uint32_t i = 0; i < views.count; ++i) apart = std::min(apart, apart_m(pages, views, page, i));
    HiddenBound& bound = work.schedule.bounds[slot];
    bound = {work.schedule.odometer_m[0], static_cast<float>(apart / (apart > 0 ? grow : 1)),
             pages.loaded[page.terrain_slot].extent.error_m};
    return bound_px(work, views, bound);
}

// Looks at vertices, as long as it may.
class Looker {
public:
    Looker(const Pages& pages, const Schedule& schedule, const Views& views, const Frame& frame)
        : pages_(pages), schedule_(schedule), views_(views) {
        for (std::uint32_t i = 0; i < views.count; ++i)
            units_px_[i] = static_cast<float>(unit_px(views, frame, i) * grow);
    }

    // The largest of a page's vertices that wait. Unbounded when there are too many to be looked at.
    [[nodiscard]] double px(std::uint32_t slot) {
        const PageState& page = pages_.state[slot];
        const bool all = page.status == PageStatus::evicting;
        double most = 0;
        for (std::uint32_t n = 0; n < pages_.grid.shapes[page.shape].count; ++n) {
            const std::uint32_t number = slot * max_page_groups + n;
            const GroupState& group = pages_.groups[number];
            if (!all && group.queue == unqueued && !is_spent(schedule_, number)) continue;
            VertexRecord gathered[group_lanes];
            const auto lanes = static_cast<std::uint32_t>(group.ready() & ~group.active);
            if (lanes == 0) continue;
            if (left_-- == 0) return unbounded_px;
            LaneGroup at = lanes_of(pages_, number, gathered);
            at.inactive = lanes;
            most = std::max(most, static_cast<double>(views_.worst_px(views_.criterion, at, units_px_)) * grow);
        }
        return most;
    }

private:
    const Pages& pages_;
    const Schedule& schedule_;
    const Views& views_;
    float units_px_[max_cut_views];
    std::uint32_t left_ = 192; // groups
};

// The pages with the highest bounds, and the highest of all others'.
class Worst {
public:
    void add(PagePixels page) {
        if (count_ < most_looked_at) {
            pages_[count_++] = page;
            return;
        }
        PagePixels& least = *std::min_element(pages_, pages_ + count_, by_px);
        if (page.px > least.px) std::swap(page, least);
        add_others(page.px);
    }
    void add_others(double px) { others_px_ = std::max(others_px_, px); }
    [[nodiscard]] double px(Looker looker) {
        std::sort(pages_, pages_ + count_, by_px);
        double most = others_px_;
        for (; count_ != 0 && pages_[count_ - 1].px > most; --count_)
            most = std::max(most, std::min(pages_[count_ - 1].px, looker.px(pages_[count_ - 1].slot)));
        return most;
    }

private:
    static constexpr std::uint32_t most_looked_at = 16;
    static bool by_px(const PagePixels& a, const PagePixels& b) {
        return a.px < b.px || (a.px == b.px && a.slot < b.slot);
    }
    PagePixels pages_[most_looked_at];
    std::uint32_t count_ = 0;
    double others_px_ = 0;
};

} // namespace

double screen_unit_px(const Views& views, const Frame& frame) {
    double most = 0;
    for (std::uint32_t i = 0; i < views.count; ++i) most = std::max(most, unit_px(views, frame, i));
    return most;
}

PageExtent extent_of(const Grid& grid, std::uint32_t page, std::uint32_t terrain_slot) {
    const TerrainData& t = *grid.terrain;
    const VertexRecord* const records = t.records + std::size_t{terrain_slot} * t.page_capacity;
    const std::uint32_t in_tile = page % grid.pages_per_tile, count = t.pages.page_vertices(in_tile);
    const std::int32_t base = t.page_table[page].base;
    std::uint16_t low = 0xffff, high = 0;
    std::uint8_t error = 0, radius = 0;
    for (std::uint32_t i = 0; i < count; ++i) { // in whatever order: compilers make vectors of it
        const VertexRecord r = records[i];
        low = std::min(low, r.height);
        high = std::max(high, r.height);
        error = std::max(error, r.error);
        radius = std::max(radius, static_cast<std::uint8_t>(r.radius & (radius_codes - 1)));
    }
    float unit_m = 0; // coarser levels have larger ones
    const int finest = in_tile == 0 ? 0 : t.pages.page_step_log2(in_tile),
              coarsest = in_tile == 0 ? t.tree.tile_log2 - 1 : finest;
    for (int z = finest; z <= coarsest; ++z)
        unit_m = std::max({unit_m, grid.level_unit_m[2 * z], grid.level_unit_m[2 * z + 1]});
    return {t.height_scale.height_m(low + base), t.height_scale.height_m(high + base), t.errors.metres[error],
            unit_m * t.radii.factor[radius]};
}

void note_bound(const Pages& pages, Work& work, const Views& views, std::uint32_t slot) {
    // Where the eye has hardly moved for it, what it was known to hide will do, less the way.
    const HiddenBound& bound = work.schedule.bounds[slot];
    if ((work.schedule.odometer_m[0] - bound.from_m) * 8 < static_cast<double>(bound.apart_m)) return;
    // A level for each factor of 2 over the threshold. By q, which is the same bit for bit whether a view or the
    // settings have the threshold: so is the order of work, then.
    (void)renew_bound(pages, work, views, slot);
    float q = 0;
    const Criterion& c = pages.state[slot].offscreen == all_parts ? views.offscreen_criterion : views.criterion;
    for (std::uint32_t i = 0; i < c.views; ++i) q = std::max(q, c.reach[i].q);
    const double ratio =
        pixels(static_cast<double>(q), static_cast<double>(bound.error_m), static_cast<double>(bound.apart_m));
    const int level = ratio < 0x1p20 ? std::clamp(std::ilogb(ratio + 0x1p-20) + 8, 0, 31) : 31;
    set_level(work.schedule, slot, static_cast<std::uint32_t>(level));
}

void renew_bound_of_edited(const Pages& pages, Work& work, const Views& views, std::uint32_t slot) {
    if (is_due(work.schedule, slot)) { // it has its place by what it was
        (void)renew_bound(pages, work, views, slot);
        return;
    }
    work.schedule.bounds[slot].apart_m = 0; // nothing that was known of it will do
    note_bound(pages, work, views, slot);
}

namespace {

// Samples to each side of the eye that are looked at one by one; of all others it is enough that they are not nearer.
constexpr std::int32_t columns_around = 8;

// No sample that is shown is nearer to the eye: it lies beyond the near plane, and the ground around the eye is known.
double nearest_shown_m(const Grid& grid, const View& v) {
    const TerrainData& t = *grid.terrain;
    const double spacing_x_m = t.header.spacing_m[0], spacing_z_m = t.header.spacing_m[1];
    const auto sample_near = [](double at_m, double a_sample_m, std::int32_t count) {
        return static_cast<std::int32_t>(std::clamp(std::floor(at_m / a_sample_m), 0.0, count - 1.0));
    };
    const std::int32_t column = sample_near(v.eye_m.x, spacing_x_m, t.tree.columns()),
                       row = sample_near(v.eye_m.z, spacing_z_m, t.tree.rows());
    // The eye stands between a sample and the next, so that the first that is not looked at is this far away; all stand
    // below the highest.
    double nearest_m =
        std::max(columns_around * std::min(spacing_x_m, spacing_z_m), v.eye_m.y - static_cast<double>(t.range.high_m));
    for (std::int32_t y = std::max(row - columns_around, 0);
         y <= std::min(row + columns_around, t.tree.rows() - 1) && nearest_m > v.near_m; ++y)
        for (std::int32_t x = std::max(column - columns_around, 0);
             x <= std::min(column + columns_around, t.tree.columns() - 1); ++x) {
            const TerrainData::Vertex sample = t.vertex({x, y});
            if (!sample.loaded) return v.near_m;
            const Vec3 way = Vec3{x * spacing_x_m, static_cast<double>(sample.height_m), y * spacing_z_m} - v.eye_m;
            nearest_m = std::min(nearest_m, std::sqrt(dot(way, way)));
        }
    return std::max(nearest_m / grow, v.near_m);
}

} // namespace

double any_mesh_px(const CutState& s) {
    const GroundRange& h = s.pages.grid.terrain->range;
    // Errors bound what a mesh without morphing hides. Heights do too, where all that is drawn stands between them.
    const auto error_m = static_cast<double>(h.error_m),
               heights_m = static_cast<double>(h.high_m) - static_cast<double>(h.low_m);
    const bool morphs = s.morphing.now.morph != Morph::none || s.frame.report.morphing != 0;
    const double most_m = s.mesh.some_hidden ? error_m + (morphs ? heights_m : 0)
                          : morphs           ? heights_m
                                             : std::min(error_m, heights_m);
    double most_px = 0;
    for (std::uint32_t i = 0; i < s.views.count; ++i)
        most_px = std::max(
            most_px, pixels(unit_px(s.views, s.frame, i), most_m, nearest_shown_m(s.pages.grid, s.views.view[i])));
    return most_px;
}

namespace {

// How near to an eye any sample is that a view shows: looked for when it is needed.
class NearestShown {
public:
    explicit NearestShown(const CutState& s) : s_(s) {}
    // What no error of that size exceeds.
    [[nodiscard]] double px(double error_m) {
        for (std::uint32_t i = 0; !known_ && i < s_.views.count; ++i)
            metres_ = std::min(metres_, nearest_shown_m(s_.pages.grid, s_.views.view[i]));
        known_ = true;
        return pixels(s_.views.largest_unit_px, error_m, metres_);
    }

private:
    const CutState& s_;
    double metres_ = 1e300;
    bool known_ = false;
};

// What vertices that morph by time hide: their errors, as near as their spheres have come to an eye since they began.
double late_px(const CutState& s, NearestShown& nearest, double coarse_px) {
    const LateBounds& late = s.work.schedule.late;
    const std::int64_t lasts = late_ticks(s.pages, s.mesh, s.morphing, s.frame);
    double most_px = 0;
    for (std::uint32_t age = 0; age < late_ages; ++age)
        for (std::uint32_t grade = late_grades; grade-- > 0;) {
            if (s.morphing.clock.ticks - late.last[age] > lasts) break; // all have arrived
            if (late.reach_m[age][grade] >= never_m / 2) continue;
            const std::size_t code = ((grade + 1u) << late_grade_codes_log2) - 1;
            const auto error_m = static_cast<double>(s.pages.grid.terrain->errors.metres[code]);
            const double apart_m = (late.reach_m[age][grade] - s.work.schedule.odometer_m[0]) / grow,
                         px = pixels(s.views.largest_unit_px, error_m, apart_m);
            most_px = std::max(most_px, px > coarse_px ? std::min(px, nearest.px(error_m)) : px);
        }
    return most_px;
}

} // namespace

double error_bound_px(CutState& s, bool offscreen_too) {
    if (s.views.jumped) return any_mesh_px(s); // nothing that was known holds: it is for the next frames to find out
    Worst worst;
    // Where the eye stands inside a sphere, or nearly so, that bound says little.
    const double coarse_px = 32 * s.frame.report.threshold_px;
    NearestShown nearest(s);
    std::uint32_t renewals = 256; // a frame: after a jump of the camera the claim takes some frames to tell anything
    const auto add = [&](std::uint32_t slot) {
        if (!offscreen_too && s.pages.state[slot].offscreen == all_parts) return;
        const HiddenBound& bound = s.work.schedule.bounds[slot];
        double px = bound_px(s.work, s.views, bound);
        const double way_m = s.work.schedule.odometer_m[0] - bound.from_m;
        if (way_m * 8 > static_cast<double>(bound.apart_m) && way_m > 0) {
            if (renewals == 0) return worst.add_others(px);
            --renewals;
            px = renew_bound(s.pages, s.work, s.views, slot);
        }
        if (px > coarse_px) px = std::min(px, nearest.px(static_cast<double>(bound.error_m)));
        worst.add({px, slot});
    };
    // Most pages are far away, and hide little: that what they were last known to hide tells without a look at them.
    const double little_px = 2 * s.frame.report.threshold_px;
    for (std::uint32_t i = 0; i < s.work.schedule.awake_count; ++i) {
        const AwakePage& page = s.work.schedule.awake[i];
        if (!page.due && page.queued == 0) continue;
        if (!offscreen_too && s.pages.state[page.slot].offscreen == all_parts)
            continue; // whatever it hides, nobody sees it
        const double px = bound_px(s.work, s.views, s.work.schedule.bounds[page.slot]);
        if (px <= little_px)
            worst.add_others(px);
        else
            add(page.slot);
    }
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i)
        if (s.pages.state[s.pages.evicting[i]].active != 0) add(s.pages.evicting[i]);
    if (s.frame.report.morphing != 0) worst.add_others(late_px(s, nearest, coarse_px));
    const double px = worst.px(Looker(s.pages, s.work.schedule, s.views, s.frame));
    return px < 256 * s.frame.report.threshold_px ? px : std::min(px, any_mesh_px(s));
}

} // namespace fjell
