#include "cut/visibility.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cut/state.h"

namespace fjell {

namespace {

// Parts come into sight this far beside a view, turned and moved, and leave it when they are farther. Half of the first
// margin is left for a view to turn or move until pages are looked at again, and a quarter while that is done. Measured
// (docs/notes/live-cut.md): wider margins keep vertices that nobody will see, narrower ones have pages looked at too
// often. Tangents and not angles, as in a view: another machine must decide alike.
constexpr double margin_tangent = 0.1051 /* 6 degrees */, half_tangent = 0.0524, most_tangent = 0.0787,
                 leave_tangent = 0.1477 /* 8.4 */;
constexpr double margin_cells = 8, leave_cells = 11;
constexpr double half_share = 0.5, most_share = 0.75; // of them
constexpr std::uint32_t look_frames = 5;              // that a look at all pages takes, unless a view is faster
constexpr double quarter_tangent = 0.0262; // what an error off-screen may span, so that it never reaches a view
constexpr double widest = 1000;            // the tangents of a view

struct Box {
    double low[3], high[3];
};

// Of a page from one of its squares' corners to another's, in squares; all that stands there, and its spheres.
Box box_of(const Pages& pages, const PageState& page, std::uint32_t i0, std::uint32_t j0, std::uint32_t i1,
           std::uint32_t j1) {
    const TerrainData& t = *pages.grid.terrain;
    const auto place = [&](std::int32_t from, std::uint32_t square) {
        return from + (static_cast<std::int32_t>(2 * square) << page.z);
    };
    // What lies beyond the terrain's rim stands on it.
    const SampleIndex first = t.tree.sample({place(page.x0, i0), place(page.y0, j0)}),
                      last = t.tree.sample({place(page.x0, i1), place(page.y0, j1)});
    const PageExtent& extent = pages.loaded[page.terrain_slot].extent;
    const double out = static_cast<double>(extent.radius_m) * (1 + 0x1p-18);
    return {{static_cast<double>(t.x_m(first.column)) - out, static_cast<double>(extent.low_m) - out,
             static_cast<double>(t.z_m(first.row)) - out},
            {static_cast<double>(t.x_m(last.column)) + out, static_cast<double>(extent.high_m) + out,
             static_cast<double>(t.z_m(last.row)) + out}};
}
Box box_of(const Pages& pages, const PageState& page) {
    const auto tile_squares = static_cast<std::uint32_t>(pages.grid.terrain->tree.side()) / 2;
    const std::uint32_t squares = page.shape == 0 ? tile_squares : page_squares;
    return box_of(pages, page, 0, 0, squares, squares);
}
Box box_of(const Pages& pages, const PageState& page, std::uint32_t part) {
    const std::uint32_t i = part % parts_x * part_columns, j = part / parts_x * part_rows;
    return box_of(pages, page, i, j, i + part_columns, j + part_rows);
}

// How much of the box is within beyond_m of the planes from `first` on?
enum class Met : std::uint8_t { nothing, some, all };
Met meets(const Frustum& frustum, const Vec3& eye, const Box& box, int first, double beyond_m) {
    Met met = Met::all;
    for (int plane = first; plane < 6; ++plane) {
        const Vec3& n = frustum.normal[plane];
        const double low[3] = {n.x * (box.low[0] - eye.x), n.y * (box.low[1] - eye.y), n.z * (box.low[2] - eye.z)},
                     high[3] = {n.x * (box.high[0] - eye.x), n.y * (box.high[1] - eye.y), n.z * (box.high[2] - eye.z)};
        const double from = frustum.offset[plane] - beyond_m;
        const double most = std::max(low[0], high[0]) + std::max(low[1], high[1]) + std::max(low[2], high[2]);
        if (most < from) return Met::nothing;
        const double least = std::min(low[0], high[0]) + std::min(low[1], high[1]) + std::min(low[2], high[2]);
        if (least < from) met = Met::some;
    }
    return met;
}

constexpr int sides = 2; // the first plane of a frustum that leads through its eye

// A view whose sides are farther out by an angle with this tangent, and no side beyond `widest`.
Frustum wider(View view, double by) {
    const auto turned = [&](double tangent) { // outwards, away from 0 for what lies on its own side of the view
        const double below = 1 - tangent * by;
        return below * widest > tangent + by ? (tangent + by) / below : widest;
    };
    view.left = -turned(-view.left);
    view.right = turned(view.right);
    view.bottom = -turned(-view.bottom);
    view.top = turned(view.top);
    return make_frustum(view);
}

double cells_m(const Grid& grid, double cells) {
    return cells * static_cast<double>(std::min(grid.terrain->spacing_x_m, grid.terrain->spacing_z_m));
}

// Does all that the view sees lie within a share of the margin of what another one saw?
bool within(const View& view, const LookView& wide, const Frustum& frustum, double move_m) {
    if (length(view.eye_m - wide.eye_m) > move_m) return false;
    const Vec3 right = cross(view.forward, view.up);
    for (const double x : {view.left, view.right})
        for (const double y : {view.bottom, view.top}) {
            const Vec3 corner = view.forward + right * x + view.up * y;
            for (int plane = sides; plane < 6; ++plane)
                if (dot(frustum.normal[plane], corner) < 0) return false;
        }
    return true;
}

bool all_within(const Grid& grid, const Views& views, const Look& look, Frustum LookView::*frustum, double share) {
    const double move_m = cells_m(grid, margin_cells * share);
    return std::all_of(views.view, views.view + views.count, [&](const View& view) {
        return std::any_of(look.of, look.of + look.count,
                           [&](const LookView& wide) { return within(view, wide, wide.*frustum, move_m); });
    });
}

// How much of the way from half of the margin to most of it the views have gone, of what they turned apart.
double gone(const Grid& grid, const Views& views, const Look& from) {
    double worst_m = 0;
    for (std::uint32_t i = 0; i < views.count; ++i) {
        double least_m = length(views.view[i].eye_m - from.of[0].eye_m);
        for (std::uint32_t n = 1; n < from.count; ++n)
            least_m = std::min(least_m, length(views.view[i].eye_m - from.of[n].eye_m));
        worst_m = std::max(worst_m, least_m);
    }
    return std::clamp((worst_m / cells_m(grid, margin_cells) - half_share) / (most_share - half_share), 0.0, 1.0);
}

// Has no view moved or turned since the look began?
bool rests(const Views& views, const Visibility& visibility) {
    for (std::uint32_t i = 0; i < views.count; ++i) {
        const LookView& wide = visibility.now.of[std::min(i, visibility.now.count - 1)];
        if (length(views.view[i].eye_m - wide.eye_m) > 0 || length(views.view[i].forward - wide.forward) > 0)
            return false;
    }
    return true;
}

// The parts of which nothing is met. met(box, part): what a box meets; part page_parts: the page as a whole.
template <typename Meet>
std::uint8_t parts_not_met(const Pages& pages, const PageState& page, const Meet& met) {
    const Met whole = met(box_of(pages, page), page_parts);
    if (whole == Met::nothing) return all_parts;
    if (whole == Met::all || page.shape == 0) return 0;
    std::uint8_t not_met = 0;
    for (std::uint32_t part = 0; part < page_parts; ++part)
        if (met(box_of(pages, page, part), part) == Met::nothing) not_met |= static_cast<std::uint8_t>(1u << part);
    return not_met;
}

void set_offscreen(Pages& pages, Work& work, std::uint32_t slot, std::uint8_t offscreen) {
    PageState& page = pages.state[slot];
    if (page.offscreen == offscreen) return;
    const std::uint8_t before = std::exchange(page.offscreen, offscreen);
    for (std::uint32_t n = 0; n < pages.grid.shapes[page.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        const std::uint8_t parts = pages.grid.shapes[page.shape].groups[n].parts;
        if (((before & parts) == parts) == ((offscreen & parts) == parts)) continue;
        // What waits in a queue is evaluated anyway.
        if (pages.groups[number].queue == unqueued && pages.groups[number].ready() != 0)
            make_due(work.schedule, number);
    }
}

} // namespace

double offscreen_factor(const Frame& frame, const View& view, double threshold_px) {
    const double highest = quarter_tangent * focal_length_px(view) / threshold_px;
    return std::clamp(highest, 1.0, frame.settings.offscreen_factor);
}

namespace {

bool is_looking(const Pages& pages, const Visibility& visibility) {
    return visibility.next < pages.fresh;
}

void begin_look(const Pages& pages, const Views& views, Visibility& visibility) {
    visibility.mixed = visibility.now.count != 0 && is_looking(pages, visibility);
    visibility.before = visibility.now;
    visibility.now.count = views.count;
    for (std::uint32_t i = 0; i < views.count; ++i) {
        const View& view = views.view[i];
        visibility.now.of[i] = {view.eye_m,
                                view.forward,
                                wider(view, half_tangent),
                                wider(view, most_tangent),
                                wider(view, margin_tangent),
                                wider(view, leave_tangent)};
    }
    visibility.next = 0;
}

void look_at(Pages& pages, Work& work, const Visibility& visibility, std::uint32_t slot) {
    const PageState& page = pages.state[slot];
    if (page.page == no_index) return;
    const double margin_m = cells_m(pages.grid, margin_cells), leave_m = cells_m(pages.grid, leave_cells);
    const auto met = [&](const Box& box, std::uint32_t part) {
        const bool out = part == page_parts ? page.offscreen == all_parts : page.offscreen >> part & 1;
        Met meeting = Met::nothing;
        for (std::uint32_t i = 0; i < visibility.now.count && meeting != Met::all; ++i) {
            const LookView& wide = visibility.now.of[i];
            meeting = std::max(meeting, out ? meets(wide.outer, wide.eye_m, box, sides, margin_m)
                                            : meets(wide.last, wide.eye_m, box, sides, leave_m));
        }
        return meeting;
    };
    set_offscreen(pages, work, slot, parts_not_met(pages, page, met));
}

constexpr std::uint32_t pages_a_visit = 16;

// More of the pages: all of them before a view can see what the others were not looked at for, or as many as there is
// time for. all: at once.
void go_on_looking(CutState& s, bool all) {
    const Look& before = s.visibility.before;
    std::uint32_t end = s.pages.fresh;
    if (!all && !s.visibility.mixed && before.count != 0 &&
        all_within(s.pages.grid, s.views, before, &LookView::most, most_share)) {
        const auto gone_to =
            static_cast<std::uint32_t>(gone(s.pages.grid, s.views, before) * static_cast<double>(s.pages.fresh));
        end = std::min(end, std::max(s.visibility.next + s.pages.fresh / look_frames + 1, gone_to));
    }
    while (s.visibility.next < end && !out_of_time(s.frame, has_done_something(s.frame))) {
        const std::uint32_t visit_end = std::min(s.visibility.next + pages_a_visit, end);
        while (s.visibility.next < visit_end) look_at(s.pages, s.work, s.visibility, s.visibility.next++);
        ++s.frame.report.visits;
    }
}

} // namespace

void watch_pages(CutState& s) {
    FJELL_ASSERT(s.bulk.phase == BulkPhase::idle);
    if (s.frame.settings.offscreen_factor <= 1) {
        if (s.visibility.now.count == 0) return;
        s.visibility.now.count = 0;
        s.visibility.next = no_index;
        for (std::uint32_t slot = 0; slot < s.pages.fresh; ++slot)
            if (s.pages.state[slot].page != no_index) set_offscreen(s.pages, s.work, slot, 0);
        return;
    }
    if (s.visibility.now.count != 0 && is_looking(s.pages, s.visibility)) {
        go_on_looking(s, rests(s.views, s.visibility));
        if (is_looking(s.pages, s.visibility)) return;
    }
    if (s.visibility.now.count != 0 && all_within(s.pages.grid, s.views, s.visibility.now, &LookView::half, half_share))
        return;
    begin_look(s.pages, s.views, s.visibility);
    go_on_looking(s, false);
}

void watch_visited_pages(CutState& s) {
    if (s.frame.settings.offscreen_factor <= 1) return watch_pages(s);
    begin_look(s.pages, s.views, s.visibility);
    s.visibility.mixed = true; // of the pages that the pass has not visited nobody keeps a list
}

void watch_visited_page(Pages& pages, Work& work, const Visibility& visibility, std::uint32_t slot) {
    if (visibility.now.count != 0) look_at(pages, work, visibility, slot);
}

bool is_overlooking(const Pages& pages, const Views& views, const Visibility& visibility) {
    if (visibility.now.count == 0 || !is_looking(pages, visibility)) return false;
    return visibility.mixed ||
           (visibility.before.count != 0 &&
            !all_within(pages.grid, views, visibility.before, &LookView::most, most_share)) ||
           !all_within(pages.grid, views, visibility.now, &LookView::outer, 1);
}

void watch_page(Pages& pages, Visibility& visibility, std::uint32_t slot) {
    PageState& page = pages.state[slot];
    if (visibility.now.count == 0) return;
    if (visibility.next == slot) ++visibility.next; // the last one of a look that was over, and is
    const double margin_m = cells_m(pages.grid, margin_cells);
    page.offscreen = parts_not_met(pages, page, [&](const Box& box, std::uint32_t) {
        Met meeting = Met::nothing;
        for (std::uint32_t i = 0; i < visibility.now.count && meeting != Met::all; ++i)
            meeting =
                std::max(meeting, meets(visibility.now.of[i].outer, visibility.now.of[i].eye_m, box, sides, margin_m));
        return meeting;
    });
}

bool may_be_seen(const Pages& pages, const Views& views, const PageState& page) {
    const Box box = box_of(pages, page);
    for (std::uint32_t i = 0; i < views.count; ++i)
        if (meets(views.frustum[i], views.view[i].eye_m, box, 0, 0) != Met::nothing) return true;
    return false;
}

} // namespace fjell
