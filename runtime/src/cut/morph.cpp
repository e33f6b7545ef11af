#include "cut/morph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "cut/evaluate.h"
#include "cut/state.h"

namespace fjell {

namespace {

// How far a vertex has morphed in by its distance alone, 0 to 1.
float morph_fraction(const MorphFrame& frame, float x, float y, float z, float error_m, float radius_m) {
    float most = 0;
    for (std::uint32_t i = 0; i < frame.views; ++i) {
        const MorphView& v = frame.view[i];
        const float dx = x - v.eye_x, dy = y - v.eye_y, dz = z - v.eye_z;
        const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float start = radius_m + error_m * v.start_per_error, full = radius_m + error_m * v.full_per_error;
        const float t = start > full ? (start - distance) / (start - full) : distance < start ? 1.0f : 0.0f;
        most = std::max(most, std::min(t, 1.0f));
    }
    return most;
}

// Displacement on screen below which nobody can see a vertex jump.
constexpr float unseen_px = 0.01f;

} // namespace

float activation_time_s(const Views& views, Morphing& morphing, const Frame& frame, float x, float y, float z,
                        float error_m, float radius_m) {
    const MorphFrame& now = morphing.now;
    if (now.morph == Morph::none) return activated_long_ago_s;
    if (now.morph == Morph::error) {
        // Late: the frame before would have shown it above its edge already.
        const float before = morph_fraction(morphing.before, x, y, z, error_m, radius_m);
        if (before * static_cast<float>(frame.report.threshold_px * views.largest_ratio) <= unseen_px)
            return activated_long_ago_s;
    }
    if (morphing.late_count == morphing.ring_size)
        return activated_long_ago_s; // cannot be: a slot each; but no reason to fail
    morphing.late_s[(morphing.first_late + morphing.late_count++) % morphing.ring_size] = now.now_s;
    morphing.clock.timed_ticks = morphing.clock.ticks;
    return now.now_s;
}

void end_morphing_in(Work& work, Morphing& morphing) {
    while (morphing.late_count != 0 &&
           (morphing.now.morph == Morph::none ||
            morph_age_s(morphing.now.now_s, morphing.late_s[morphing.first_late]) >= morphing.now.morph_s)) {
        morphing.first_late = (morphing.first_late + 1) % morphing.ring_size;
        --morphing.late_count;
    }
    Queues& q = work.queues;
    constexpr std::uint32_t all = (1u << rising_slots) - 1;
    constexpr std::int64_t slots_a_morph = 8;
    const auto ticks = static_cast<std::int64_t>(std::ceil(morphing.now.morph_s * ticks_a_second));
    const std::int64_t slot_ticks = std::max<std::int64_t>((ticks + slots_a_morph - 1) / slots_a_morph, 1);
    const auto waiting = std::span(q.sizes).subspan(rising_queues, rising_slots);
    const bool none_waits = std::all_of(waiting.begin(), waiting.end(), [](std::uint32_t size) { return size == 0; });
    if (none_waits && morphing.late_count == 0 && morphing.out_count == 0) {
        q.slots_from_ticks = morphing.clock.ticks;
        q.opened = 0;
    }
    const std::int64_t now = (morphing.clock.ticks - q.slots_from_ticks) / slot_ticks;
    if (morphing.now.morph == Morph::none || slot_ticks != q.slot_ticks) q.open_slots = all; // times count no more
    for (std::int64_t n = std::max(q.opened, now - rising_slots) + 1; n <= now; ++n)
        q.open_slots |= 1u << n % rising_slots;
    q.slot_ticks = slot_ticks;
    q.opened = now;
}

std::uint32_t rising_queue(Queues& q, std::int64_t arrives_ticks) {
    // A rebuild that cannot be completed refines before the first update has set how long a slot is.
    const std::int64_t slot_ticks = std::max<std::int64_t>(q.slot_ticks, 1),
                       wanted = (arrives_ticks - q.slots_from_ticks + slot_ticks - 1) / slot_ticks,
                       n = std::clamp(wanted, q.opened + 1, q.opened + std::int64_t{rising_slots} - 1);
    // What is left in it from the last time round waits for this one, or groups would be tried in the frame that has
    // filed them, again and again.
    q.open_slots &= ~(1u << n % rising_slots);
    return rising_queues + static_cast<std::uint32_t>(n % rising_slots);
}

void advance_clock(Morphing& morphing, const Frame& frame, bool first) {
    MorphClock& c = morphing.clock;
    constexpr double most = 0x1p61; // so that a difference of two fits an int64
    const double exact = std::clamp(frame.settings.now_s * static_cast<double>(ticks_a_second), -most, most);
    const auto host = static_cast<std::int64_t>(std::floor(exact + 0.5));
    if (!first) c.ticks += std::clamp<std::int64_t>(host - c.host_ticks, 0, longest_gap_ticks);
    c.host_ticks = host;
    if (frame.settings.morph == Morph::none) {
        c.arrived_ticks = c.timed_ticks; // all have
        morphing.now.morph_s = static_cast<float>(frame.settings.morph_s);
        return;
    }
    c.ticks += c.ticks == c.arrived_ticks ? 1 : 0; // a step at least, or what was activated just now would be moved
    const auto wanted = static_cast<std::int64_t>(std::ceil(frame.settings.morph_s * ticks_a_second)),
               taken = std::min(wanted, c.ticks - c.arrived_ticks);
    morphing.now.morph_s = taken == wanted ? static_cast<float>(frame.settings.morph_s)
                                           : static_cast<float>(taken) / static_cast<float>(ticks_a_second);
    c.arrived_ticks = c.ticks - taken;
}

void retire_times(Mesh& mesh, const Morphing& morphing, std::int64_t ticks_before) {
    constexpr std::int64_t round = clock_ticks / 2;
    const std::int64_t now = morphing.clock.ticks;
    if (mesh.morph == nullptr || now == ticks_before ||
        ticks_before - morphing.clock.timed_ticks > round + longest_gap_ticks)
        return;
    const auto cursor = [&](std::int64_t ticks) {
        return static_cast<std::uint32_t>(ticks % round * static_cast<std::int64_t>(mesh.capacity) / round);
    };
    const auto pass = [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t slot = first; slot < std::min(end, mesh.fresh_vertex); ++slot) {
            MorphVertex& m = mesh.morph[slot];
            if (m.activated_s == activated_long_ago_s ||
                morph_age_s(morphing.clock.now_s(), m.activated_s) * static_cast<float>(ticks_a_second) <
                    static_cast<float>(longest_gap_ticks))
                continue;
            m.activated_s = activated_long_ago_s;
            mesh.dirty_vertices.mark(slot);
        }
    };
    const std::uint32_t first = cursor(ticks_before), end = cursor(now);
    if (first <= end) return pass(first, end);
    pass(first, mesh.capacity);
    pass(0, end);
}

void begin_morphing_out(const Pages& pages, Mesh& mesh, Morphing& morphing, std::uint32_t vertex) {
    const std::uint32_t slot = pages.vertex_slot[vertex];
    MeshVertex& v = mesh.vertices[slot];
    MorphVertex& m = mesh.morph[slot];
    const float edge_m = m.morph_from_m;
    m.morph_from_m = morphed_height_m(pages.grid.handle, v, m, morphing.now);
    v.height_m = edge_m;
    m.error_m = 1e30f; // by distance it has arrived
    m.radius_m = 0;
    m.activated_s = morphing.now.now_s;
    morphing.clock.timed_ticks = morphing.clock.ticks;
    mesh.hole[slot] |= morphs_out_bit;
    mesh.dirty_vertices.mark(slot);
    FJELL_ASSERT(morphing.out_count < morphing.ring_size); // a full ring would forget the first
    morphing.out[(morphing.first_out + morphing.out_count++) % morphing.ring_size] = vertex;
}

std::int64_t late_ticks(const Pages& pages, const Mesh& mesh, const Morphing& morphing, const Frame& frame) {
    const auto lasts = static_cast<std::int64_t>(std::ceil(frame.settings.morph_s * ticks_a_second)) + 1;
    if (morphing.out_count == 0) return lasts;
    // What has morphed out hides its error until it is deactivated, for which there may be no items: those that began
    // first are the first to go.
    const std::uint32_t first = morphing.out[morphing.first_out];
    if (!is_active(pages, first)) return clock_ticks;
    const float age_s = morph_age_s(morphing.clock.now_s(), mesh.morph[pages.vertex_slot[first]].activated_s);
    return std::max(lasts, static_cast<std::int64_t>(std::ceil(age_s * ticks_a_second)) + 1);
}

void note_late(CutState& s, const Evaluation& v) {
    const Vec3 at{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
    double apart_m = never_m;
    for (std::uint32_t i = 0; i < s.views.count; ++i) {
        const Vec3 way = at - s.views.view[i].eye_m;
        apart_m = std::min(apart_m, std::sqrt(dot(way, way)) - static_cast<double>(v.radius_m));
    }
    note_late(s.work.schedule.late, s.work.schedule.odometer_m[0], s.morphing.clock.ticks,
              late_ticks(s.pages, s.mesh, s.morphing, s.frame), v.code, apart_m);
}

namespace {

std::uint32_t slot_at(const Pages& pages, SampleIndex c) {
    if (!pages.grid.terrain->tree.is_corner(c)) return pages.vertex_slot[find_vertex(pages, site_at(c))];
    return pages.grid.terrain->corner_at(c.column >> pages.grid.terrain->tree.tile_log2,
                                         c.row >> pages.grid.terrain->tree.tile_log2);
}

} // namespace

void flatten_all(const Pages& pages, Mesh& mesh) {
    for (std::uint32_t number = 0; number < pages.fresh * max_page_groups; ++number)
        for (std::uint32_t lanes = pages.groups[number].active; lanes != 0; lanes &= lanes - 1) {
            const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
            const Site site = site_of(pages, vertex);
            const SampleIndex at = site_coord(site);
            const Diamond split = diamond(pages.grid.terrain->tree, at);
            const std::uint32_t slot = pages.vertex_slot[vertex];
            mesh.morph[slot].morph_from_m =
                flat_height(pages.grid, mesh, slot, at, site.z, site.kind == VertexKind::centre,
                            slot_at(pages, split.ends[0]), slot_at(pages, split.ends[1]));
            mesh.dirty_vertices.mark(slot);
        }
}

float morphed_height_m(const Terrain& terrain, const MeshVertex& v, const MorphVertex& m, const MorphFrame& frame) {
    if (frame.morph == Morph::none) return v.height_m;
    const TerrainData* const found = find(terrain);
    if (found == nullptr) return v.height_m;
    float t = morph_fraction(frame, found->x_m(v.column), v.height_m, found->z_m(v.row), m.error_m, m.radius_m);
    t = std::min(t, morph_age_s(frame.now_s, m.activated_s) / frame.morph_s);
    return m.morph_from_m + (v.height_m - m.morph_from_m) * std::clamp(t, 0.0f, 1.0f);
}

} // namespace fjell
