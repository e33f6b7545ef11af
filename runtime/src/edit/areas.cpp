#include "edit/areas.h"

#include "edit/errors.h"
#include "edit/radii.h"

namespace fjell::edit {

namespace {

std::int64_t size(const Rect& r) {
    return std::int64_t{r.columns()} * r.rows();
}

void join(Area& area, const Rect& places, int z, int radii_z) {
    area = {.places = area.places.with(places),
            .first_z = std::min(area.first_z, z),
            .radii_z = std::min(area.radii_z, radii_z)};
}

std::uint32_t first_to_measure(const EditsData& e) {
    std::uint32_t i = 0;
    while (i < e.area_count && e.areas[i].unmeasured) ++i;
    return i;
}

// The next vertex of an area, from fine to coarse. False: there is none.
bool next_vertex(const TerrainData& t, Area& a, Plane& plane, SampleIndex& square) {
    while (a.z < t.tree.tile_log2) {
        plane = {a.z, sides_then_centres[a.plane]};
        const Rect squares = around(t.tree, plane, a.places);
        if (!a.plane_begun) a.i = squares.x0, a.j = squares.y0, a.plane_begun = true;
        if (!squares.empty() && a.j <= squares.y1) {
            square = {a.i, a.j};
            if (++a.i > squares.x1) a.i = squares.x0, ++a.j;
            return true;
        }
        a.plane_begun = false;
        if (++a.plane == 3) a.plane = 0, ++a.z;
    }
    return false;
}

} // namespace

void push_area(EditsData& e, const Rect& places, int z, int radii_z) {
    constexpr std::int32_t near = 8;
    for (std::uint32_t i = 0; i < e.area_count; ++i) { // one that has not begun takes it in
        Area& a = e.areas[i];
        if (a.begun || !a.places.grown(near).meets(places)) continue;
        if (size(a.places.with(places)) <= 2 * (size(a.places) + size(places))) return join(a, places, z, radii_z);
    }
    if (e.area_count == e.budget.areas) return join(e.areas[e.area_count - 1], places, z, radii_z);
    e.areas[e.area_count++] = {.places = places, .first_z = z, .radii_z = radii_z};
}

bool has_area_to_measure(const EditsData& e) {
    return first_to_measure(e) != e.area_count;
}

void measure_next(EditsData& e) {
    const TerrainData& t = *e.terrain;
    const std::uint32_t number = first_to_measure(e);
    Area& a = e.areas[number];
    Ground ground(t, nullptr);
    ground.missing = &a.missing;
    if (!a.begun) a.begun = true, a.z = a.first_z, a.page_changes = t.changes;
    if (a.radii_z != no_radii) { // of a page that has come back
        if (!nest_radii_of_pages(e, a.places, a.radii_z, a.missing)) a.missed_radii_z = a.radii_z;
        a.radii_z = no_radii;
        return;
    }
    Plane plane{};
    SampleIndex square;
    if (!next_vertex(t, a, plane, square)) {
        const Area done = a;
        std::copy(e.areas + number + 1, e.areas + e.area_count, e.areas + number);
        --e.area_count;
        if (done.missed || done.missed_radii_z != no_radii)
            e.areas[e.area_count++] = {.places = done.places,
                                       .unmeasured = true,
                                       .first_z = done.first_z,
                                       .radii_z = done.missed_radii_z,
                                       .page_changes = done.page_changes,
                                       .missing = done.missing};
        if (done.missing.count != 0) ++e.awaits_changes; // by a stamp that waits for it
        return;
    }
    const SampleIndex v = plane.at(square.column, square.row);
    const Cell own = ground.at(v);
    if (!own.loaded) {
        a.missed = true;
        return;
    }
    const Asked asked = asked_by_children(ground, v);
    Measured now = measure(e, ground, v, asked);
    if (!now.exact) { // as it is, which is a bound
        a.missed = true;
        now.code = std::min(now.code, std::max<std::uint32_t>(own.error, asked.code));
    }
    if (now.code == own.error) return;
    ground.set_error(plane, square.column, square.row, static_cast<std::uint8_t>(now.code));
    note_error(*e.terrain, now.code);
    if (plane.z != e.measured_z) flush_measured(e);
    e.measured_z = plane.z;
    e.measured = e.measured.with({v.column, v.row, v.column, v.row});
}

void retry_unmeasured(EditsData& e) {
    for (std::uint32_t i = 0; i < e.area_count; ++i) {
        Area& a = e.areas[i];
        if (!a.unmeasured || a.page_changes == e.terrain->changes) continue;
        a.page_changes = e.terrain->changes;
        // Not before something that it has lacked is there: pages come for other reasons in most frames.
        const std::uint32_t lacked = a.missing.count;
        a.missing.forget([&](SampleIndex v) { return cell_at(*e.terrain, v).loaded; });
        if (lacked == 0 || a.missing.count != lacked)
            a = {.places = a.places, .first_z = a.first_z, .radii_z = a.radii_z, .missing = a.missing};
    }
}

void flush_measured(EditsData& e) {
    if (e.measured.empty()) return;
    push_change(e, e.measured, e.measured_z);
    e.measured = {};
}

} // namespace fjell::edit
