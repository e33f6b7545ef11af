#include "cut/change.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cut/mesh.h"

namespace fjell {

namespace {

// Of one vertex: the same numbers as evaluate() gives for its lane, of one answer.
struct Verdict {
    bool wanted;
    float slack_m;
    float error_m, radius_m;
    std::uint8_t code;
    float x, y, z;
};

Verdict judge(const CutState& s, std::uint32_t vertex, const Site& site, bool active) {
    const Decision& c = s.decision;
    const VertexRecord record = record_of(s, vertex);
    const Coord at = site_coord(site);
    const std::int32_t base = s.slot_info[vertex / block_lanes / max_page_blocks].base;
    Verdict v{};
    v.x = static_cast<float>(std::min(at.x, c.last_x)) * c.spacing_x_m;
    v.z = static_cast<float>(std::min(at.y, c.last_y)) * c.spacing_z_m;
    v.y = c.base_m + static_cast<float>(record.height + base) * c.quantum_m;
    v.error_m = c.error_m[record.error];
    v.code = record.error;
    v.radius_m = s.level_unit_m[2 * site.z + (site.kind == PlaneKind::centre ? 0 : 1)] *
                 c.radius_factor[record.radius & (radius_codes - 1)];
    float margin = -3.4e38f, span = 0;
    for (std::uint32_t i = 0; i < c.views; ++i) {
        const Reach& r = active && c.hysteresis ? c.keep[i] : c.reach[i];
        const float dx = v.x - r.eye_x, dy = v.y - r.eye_y, dz = v.z - r.eye_z;
        const float squared = dx * dx + dy * dy + dz * dz, distance = std::sqrt(squared);
        const float reach = (v.radius_m + v.error_m * r.q) * reach_grow + r.pad;
        v.wanted = v.wanted || squared < reach * reach;
        margin = std::max(margin, reach - distance);
        span = std::max(span, reach + distance);
    }
    v.slack_m = std::max(std::abs(margin) - span * slack_rounding, 0.0f);
    return v;
}

bool seen(const CutState& s, const Verdict& v) {
    for (std::uint32_t i = 0; i < s.view_count; ++i) {
        const Vec3 p = Vec3{v.x, v.y, v.z} - s.views[i].eye_m;
        bool inside = true;
        for (int plane = 0; plane < 6 && inside; ++plane)
            inside = dot(s.frustums[i].normal[plane], p) >= s.frustums[i].offset[plane] - static_cast<double>(v.radius_m);
        if (inside) return true;
    }
    return false;
}

// Worst first: 16 ranks of a factor 2 of screen error over the threshold, and 16 above them for what is seen.
std::uint32_t rank_of(const CutState& s, const Verdict& v) {
    float worst = 0;
    for (std::uint32_t i = 0; i < s.decision.views; ++i) {
        const Reach& r = s.decision.reach[i];
        const float dx = v.x - r.eye_x, dy = v.y - r.eye_y, dz = v.z - r.eye_z;
        const float depth = std::sqrt(dx * dx + dy * dy + dz * dz) - v.radius_m;
        worst = std::max(worst, v.error_m * r.q / std::max(depth, 1e-3f));
    }
    const int log2 = std::clamp(worst < 0x1p15f ? std::ilogb(std::max(worst, 1.0f)) : 15, 0, 15);
    return static_cast<std::uint32_t>(log2) + (seen(s, v) ? 16u : 0u);
}

std::uint32_t grade_of(std::uint32_t code) {
    return code >> grade_codes_log2;
}

// A block has work of this rank: it goes to its list, unless it is in one that comes first.
void offer(CutState& s, std::uint32_t block, std::uint32_t rank) {
    const ListId list = list_of(s.lists, block), wanted_list = static_cast<ListId>(work_lists + rank);
    if (list != no_list && list >= due_lists && list < work_lists) return; // will be evaluated
    if (list != no_list && list >= work_lists && list < retire_list && list >= wanted_list) return;
    unlink(s.lists, block);
    push_back(s.lists, wanted_list, block);
    s.work_ranks |= 1u << rank;
}

bool drains(const CutState& s, std::uint32_t vertex) {
    return s.slot_info[vertex / block_lanes / max_page_blocks].status == SlotStatus::draining;
}

// A vertex has just become ready, or an active one childless: when must it be looked at?
void consider(CutState& s, std::uint32_t vertex, const Site& site, bool active) {
    if (drains(s, vertex)) return;
    const Verdict v = judge(s, vertex, site, active);
    const std::uint32_t block = vertex / block_lanes;
    if (v.wanted == active) {
        tighten(s.lists, block, v.slack_m, grade_of(v.code));
    } else if (!active) {
        offer(s, block, rank_of(s, v));
    } else if (list_of(s.lists, block) == no_list || list_of(s.lists, block) < due_lists) {
        unlink(s.lists, block);
        push_back(s.lists, retire_list, block);
    }
}

std::uint16_t bit_of(std::uint32_t vertex) {
    return static_cast<std::uint16_t>(1u << vertex % block_lanes);
}

// The triangle of a parent that a vertex splits.
struct Split {
    std::uint32_t parent; // no_vertex: a tile's corner
    std::uint32_t name;   // of the triangle: the parent's vertex slot * 4 + direction
    std::uint32_t tile;
    Halves halves;
};

// One or two of them: at the terrain's rim a side has one parent.
int splits_of(const CutState& s, const Site& site, std::uint32_t vertex, Split (&out)[2]) {
    const bool root = site.z == s.terrain->tree.tile_log2 - 1 && site.kind == PlaneKind::centre;
    int count = 0;
    for (int n = 0; n < 2; ++n) {
        Split split{};
        if (root) {
            // A tile's root splits its two base triangles, whose right angles are its north-east and south-west corner.
            const Bearing bearing = n == 0 ? Bearing::north_east : Bearing::south_west;
            const auto corner = static_cast<std::uint32_t>((site.j + n) * (s.tiles_x + 1) + site.i + 1 - n);
            split = {no_vertex, corner * 4 + static_cast<std::uint32_t>(child_number(bearing)), 0, halves(bearing)};
        } else {
            const Site parent = parent_site(site, n);
            if (!exists(s, parent)) continue;
            const Bearing bearing = parent_bearing(site, n);
            split.parent = find_vertex(s, parent);
            split.name = s.slots[split.parent] * 4 + static_cast<std::uint32_t>(child_number(bearing));
            split.halves = halves(bearing);
        }
        // The centre of the two lies inside its tile.
        const std::uint32_t inside = site.kind == PlaneKind::centre ? vertex : split.parent;
        split.tile = s.slot_info[inside / block_lanes / max_page_blocks].tile;
        out[count++] = split;
    }
    return count;
}

bool room_for(const CutState& s, const Split* splits, int count) {
    // Two tiles at most, and what is not drawn; one chunk each will do. Two more stay back for deactivations.
    std::uint32_t chunks = s.some_hidden && room_in(s, hidden_tile(s)) < 4 ? 1 : 0;
    for (int i = 0; i < count; ++i) chunks += room_in(s, splits[i].tile) < 4 ? 1 : 0;
    return chunks == 0 || s.free_chunk_count >= chunks + 2;
}

} // namespace

Outcome activate(CutState& s, std::uint32_t vertex) {
    const Site site = site_of(s, vertex);
    Split splits[2];
    const int count = splits_of(s, site, vertex, splits);
    if (s.free_vertex_count == 0) return Outcome::no_vertices;
    if (!room_for(s, splits, count)) return Outcome::no_triangles;
    const std::uint32_t first = s.made[splits[0].name];
    const std::uint32_t ends[2] = {s.indices[std::size_t{first} * 3 + 1], s.indices[std::size_t{first} * 3 + 2]};
    const Verdict v = judge(s, vertex, site, true);

    const std::uint32_t slot = s.free_vertices[--s.free_vertex_count];
    const Coord at = s.terrain->tree.sample(site_coord(site));
    s.vertices[slot] = {at.x, at.y, v.y};
    s.hole[slot] = is_void(record_of(s, vertex));
    s.morph[slot] = {(s.vertices[ends[0]].height_m + s.vertices[ends[1]].height_m) * 0.5f, v.error_m, v.radius_m,
                     never_born_s};
    s.dirty_vertices.mark(slot);
    s.slots[vertex] = slot;
    BlockState& block = s.blocks[vertex / block_lanes];
    block.active |= bit_of(vertex);
    ++s.slot_info[vertex / block_lanes / max_page_blocks].active;

    for (int n = 0; n < count; ++n) {
        const Split& split = splits[n];
        const std::uint32_t old = s.made[split.name];
        const std::uint32_t* const t = s.indices + std::size_t{old} * 3;
        const std::uint32_t p = t[0], a = t[1], b = t[2];
        replace_triangle(s, old, split.tile, {slot, p, a}, slot * 4 + split.halves.first);
        const MeshTriangle second{slot, b, p};
        append_triangle(s, list_for(s, split.tile, second), second, slot * 4 + split.halves.second);
        if (split.parent == no_vertex) continue;
        s.blocks[split.parent / block_lanes].child[split.name % 4] |= bit_of(split.parent);
    }
    if (site.kind != PlaneKind::centre && site.z == 0) return Outcome::done;
    for (int d = 0; d < 4; ++d) {
        const Site child = child_site(site, d);
        if (!exists(s, child)) continue;
        const std::uint32_t found = find_vertex(s, child);
        if (found == no_vertex) continue;
        BlockState& of_child = s.blocks[found / block_lanes];
        of_child.parent[parent_number(site.kind, d)] |= bit_of(found);
        if (of_child.ready() & bit_of(found)) consider(s, found, child, false);
    }
    return Outcome::done;
}

Outcome deactivate(CutState& s, std::uint32_t vertex) {
    const Site site = site_of(s, vertex);
    Split splits[2];
    const int count = splits_of(s, site, vertex, splits);
    const std::uint32_t slot = s.slots[vertex];
    if (s.some_hidden && s.free_chunk_count < 2) {
        for (int n = 0; n < count; ++n)
            if (room_in(s, splits[n].tile) < 2 || room_in(s, hidden_tile(s)) < 2) return Outcome::no_triangles;
    }
    for (int n = 0; n < count; ++n) {
        const Split& split = splits[n];
        const std::uint32_t first = s.made[slot * 4 + split.halves.first];
        // (v, parent, a) and (v, b, parent) become (parent, a, b) again.
        const std::uint32_t p = s.indices[std::size_t{first} * 3 + 1], a = s.indices[std::size_t{first} * 3 + 2];
        const std::uint32_t b = s.indices[std::size_t{s.made[slot * 4 + split.halves.second]} * 3 + 1];
        replace_triangle(s, first, split.tile, {p, a, b}, split.name);
        remove_triangle(s, s.made[slot * 4 + split.halves.second]);
    }
    s.free_vertices[s.free_vertex_count++] = slot;
    BlockState& block = s.blocks[vertex / block_lanes];
    block.active &= static_cast<std::uint16_t>(~bit_of(vertex));
    --s.slot_info[vertex / block_lanes / max_page_blocks].active;
    if (site.kind == PlaneKind::centre || site.z != 0) {
        for (int d = 0; d < 4; ++d) {
            const Site child = child_site(site, d);
            if (!exists(s, child)) continue;
            const std::uint32_t found = find_vertex(s, child);
            if (found == no_vertex) continue;
            s.blocks[found / block_lanes].parent[parent_number(site.kind, d)] &=
                static_cast<std::uint16_t>(~bit_of(found));
        }
    }
    for (int n = 0; n < count; ++n) {
        const Split& split = splits[n];
        if (split.parent == no_vertex) continue;
        BlockState& of_parent = s.blocks[split.parent / block_lanes];
        of_parent.child[split.name % 4] &= static_cast<std::uint16_t>(~bit_of(split.parent));
        if (!(of_parent.parental() & bit_of(split.parent)))
            consider(s, split.parent, site_of(s, split.parent), true);
    }
    return Outcome::done;
}

namespace {

// Of the lanes in a mask, the smallest slack; and the largest error code.
struct Rest {
    float slack_m = 3e38f;
    std::uint32_t code = 0;
};
void lessen(Rest& rest, std::uint32_t mask, const float* margins, const LaneMargins& m, const VertexRecord* records) {
    for (; mask != 0; mask &= mask - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(mask));
        rest.slack_m = std::min(rest.slack_m, std::max(std::abs(margins[lane]) - m.span_m[lane] * slack_rounding, 0.0f));
        rest.code = std::max<std::uint32_t>(rest.code, records[lane].error);
    }
}

} // namespace

void visit_block(CutState& s, std::uint32_t number, std::uint32_t least_rank, bool may_retire) {
    BlockState& b = s.blocks[number];
    const std::uint32_t slot = number / max_page_blocks;
    const SlotInfo& info = s.slot_info[slot];
    const BlockShape& shape = s.shapes[info.shape].blocks[number - slot * max_page_blocks];
    const Site first = site_of(s, number * block_lanes);
    VertexRecord gathered[block_lanes];
    const VertexRecord* records =
        s.terrain->records + std::size_t{slot} * s.terrain->page_capacity + shape.first;
    if (shape.lanes != block_lanes || shape.stride != 1 || s.hz_places) {
        for (std::uint32_t lane = 0; lane < block_lanes; ++lane)
            gathered[lane] = record_of(s, number * block_lanes + std::min<std::uint32_t>(lane, shape.lanes - 1u));
        records = gathered;
    }
    const Coord at = site_coord(first);
    const std::int32_t apart = 2 << first.z;
    const LaneBlock lanes{records,
                          at.x,
                          at.y,
                          shape.along_y ? 0 : apart,
                          shape.along_y ? apart : 0,
                          info.base,
                          s.level_unit_m[2 * first.z + (shape.kind == PlaneKind::centre ? 0 : 1)]};
    LaneMargins margins;
    s.evaluate(s.decision, lanes, margins);
    ++s.report.evaluations;
    ++s.report.items;

    const bool draining = info.status == SlotStatus::draining;
    const auto inactive = [&] { return draining ? 0u : static_cast<std::uint32_t>(b.ready() & ~b.active); };
    const auto childless = [&] { return static_cast<std::uint32_t>(b.active & ~b.parental()); };
    ListId left_over = no_list;
    std::uint32_t later = 0; // ranks of what must wait, as bits
    for (std::uint32_t todo = inactive() & margins.wanted; todo != 0; todo &= todo - 1) {
        const std::uint32_t vertex = number * block_lanes + static_cast<std::uint32_t>(std::countr_zero(todo));
        const std::uint32_t rank = rank_of(s, judge(s, vertex, site_of(s, vertex), false));
        if (rank < least_rank || s.report.items >= s.item_limit) {
            later |= 1u << rank;
            continue;
        }
        const Outcome outcome = activate(s, vertex);
        if (outcome == Outcome::done) {
            ++s.report.activations;
            ++s.report.items;
        } else {
            s.report.exhausted |= outcome == Outcome::no_vertices ? cut_budget_vertices : cut_budget_triangles;
            left_over = static_cast<ListId>(blocked_lists + s.turn);
        }
    }
    for (std::uint32_t todo = childless() & ~margins.kept; todo != 0; todo &= todo - 1) {
        const std::uint32_t vertex = number * block_lanes + static_cast<std::uint32_t>(std::countr_zero(todo));
        if (!may_retire || s.report.items >= s.item_limit) {
            if (left_over == no_list) left_over = retire_list;
        } else if (deactivate(s, vertex) == Outcome::done) {
            ++s.report.deactivations;
            ++s.report.items;
        } else {
            s.report.exhausted |= cut_budget_triangles;
            left_over = static_cast<ListId>(blocked_lists + s.turn);
        }
    }
    if (later != 0) left_over = static_cast<ListId>(work_lists + std::bit_width(later) - 1);
    s.work_ranks |= later;
    if (left_over != no_list) return push_back(s.lists, left_over, number);

    // All that is left here agrees with the decision: when might that end?
    Rest rest;
    lessen(rest, inactive(), margins.reach_m, margins, records);
    lessen(rest, childless(), margins.keep_m, margins, records);
    if ((inactive() | childless()) != 0) schedule(s.lists, number, rest.slack_m, grade_of(rest.code));
}

} // namespace fjell
