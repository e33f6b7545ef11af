// Bringing nearer the memory that changes will touch. What a change costs is a chain of cache misses: the parents'
// vertex slots, the triangles they make, those triangles' corners. For a batch of changes every link of the chain is
// fetched for all of them before the next one is followed for any.
#pragma once

#include "cut/find.h"
#include "cut/judge.h"

namespace fjell {

// Where one change will look. Only a hint: by the time it is carried out things may have changed.
struct Plan {
    std::uint32_t vertex;
    std::uint32_t triangles[4]; // names, then slots
    std::uint32_t parents[2];   // or no_index
    std::uint8_t directions[2]; // of the parents' triangles that an activation replaces
    bool activation;
};

// g++ takes a function that only prefetches for one without effects, and drops calls of it; hence the asm.
#define FJELL_FETCH(at)                                                                                                \
    do {                                                                                                               \
        const void* const fetched_at = (at);                                                                           \
        asm volatile("" : : "r"(fetched_at));                                                                          \
        __builtin_prefetch(fetched_at, 1);                                                                             \
    } while (false)

// What looking at a group reads.
inline void fetch_group(const CutState& s, std::uint32_t group) {
    FJELL_FETCH(&s.groups[group]);
    const VertexRecord* const records =
        s.terrain->records + std::size_t{group / max_page_groups} * s.terrain->page_capacity + shape_of(s, group).first;
    FJELL_FETCH(records);
    FJELL_FETCH(records + group_lanes - 1);
}

inline void fetch_record(const CutState& s, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes, slot = group / max_page_groups;
    const GroupShape& shape = shape_of(s, group);
    FJELL_FETCH(s.terrain->records + std::size_t{slot} * s.terrain->page_capacity + shape.first +
                shape.stride * (vertex % group_lanes));
}

// The first link: vertices around it.
inline Plan make_plan(const CutState& s, std::uint32_t vertex, bool activation) {
    Plan plan{vertex, {no_index, no_index, no_index, no_index}, {no_index, no_index}, {}, activation};
    const Site site = site_of(s, vertex);
    FJELL_FETCH(&s.slots[vertex]);
    if (site.kind == VertexKind::centre || site.z != 0)
        for (int d = 0; d < 4; ++d) {
            const Site child = child_site(site, d);
            if (!exists(s, child)) continue;
            const std::uint32_t found = find_vertex(s, child);
            if (found == no_index) continue;
            FJELL_FETCH(&s.groups[found / group_lanes]);
            if (activation) fetch_record(s, found);
        }
    if (site.kind == VertexKind::centre && site.z == s.terrain->tree.tile_log2 - 1) return plan;
    for (int n = 0; n < 2; ++n) {
        const Site parent = parent_site(site, n);
        if (!exists(s, parent)) continue;
        const std::uint32_t found = plan.parents[n] = find_vertex(s, parent);
        if (found == no_index) continue;
        plan.directions[n] = static_cast<std::uint8_t>(child_number(parent_bearing(site, n)));
        FJELL_FETCH(&s.groups[found / group_lanes]);
        FJELL_FETCH(&s.slots[found]);
        if (!activation) fetch_record(s, found);
    }
    return plan;
}

// The second link: what they make.
inline void fetch_made(const CutState& s, Plan& plan) {
    if (plan.activation) {
        for (int n = 0; n < 2; ++n) {
            const std::uint32_t parent = plan.parents[n];
            if (parent == no_index || !(s.groups[parent / group_lanes].active & bit_of(parent))) continue;
            plan.triangles[n] = s.slots[parent] * 4 + plan.directions[n];
            FJELL_FETCH(&s.made[plan.triangles[n]]);
        }
    } else if (s.groups[plan.vertex / group_lanes].active & bit_of(plan.vertex)) {
        for (std::uint32_t d = 0; d < 4; ++d) plan.triangles[d] = s.slots[plan.vertex] * 4 + d;
        FJELL_FETCH(&s.made[plan.triangles[0]]);
    }
}

// The third: those triangles.
inline void fetch_triangles(const CutState& s, Plan& plan) {
    for (std::uint32_t& triangle : plan.triangles) {
        if (triangle == no_index) continue;
        triangle = s.made[triangle];
        if (triangle == no_index) continue;
        FJELL_FETCH(&s.indices[std::size_t{triangle} * 3]);
        FJELL_FETCH(&s.names[triangle]);
    }
}

// The fourth: the ends of the edge that an activation splits.
inline void fetch_corners(const CutState& s, const Plan& plan) {
    if (!plan.activation || plan.triangles[0] == no_index || s.morph_now.morph == Morph::none) return;
    const std::uint32_t* const t = s.indices + std::size_t{plan.triangles[0]} * 3;
    FJELL_FETCH(&s.vertices[t[1]]);
    FJELL_FETCH(&s.vertices[t[2]]);
}

} // namespace fjell
