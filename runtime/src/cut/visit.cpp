#include "cut/visit.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cut/change.h"
#include "cut/judge.h"
#include "cut/sink.h"

namespace fjell {

namespace {

std::uint32_t bits(int mask) {
    return static_cast<std::uint32_t>(mask);
}

// A group as it was evaluated.
struct Look {
    explicit Look(GroupState& group) : state(group) {} // the rest evaluate_group() sets
    GroupState& state;
    bool draining;
    std::uint32_t sinking; // lanes that will go by themselves
    const VertexRecord* records;
    VertexRecord gathered[group_lanes];
    LaneMargins margins;

    // The lanes that could change: by the tree, they may.
    [[nodiscard]] std::uint32_t inactive() const { return draining ? 0 : bits(state.ready() & ~state.active); }
    [[nodiscard]] std::uint32_t childless() const { return bits(state.active & ~state.parental()) & ~sinking; }
    // And by the decision, they should.
    [[nodiscard]] std::uint32_t rising() const { return inactive() & margins.wanted; }
    [[nodiscard]] std::uint32_t falling() const { return childless() & ~margins.kept; }
};

void evaluate_group(CutState& s, std::uint32_t number, Look& look) {
    const std::uint32_t slot = number / max_page_groups;
    const PageSlot& info = s.page_slot[slot];
    const GroupShape& shape = s.shapes[info.shape].groups[number - slot * max_page_groups];
    look.draining = info.status == PageSlotStatus::draining;
    look.sinking = 0;
    for (std::uint32_t lanes = s.sinking_count != 0 ? look.state.active : 0u; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        if (sinks(s, s.slots[number * group_lanes + lane])) look.sinking |= 1u << lane;
    }
    look.records = s.terrain->records + std::size_t{slot} * s.terrain->page_capacity + shape.first;
    if (shape.lanes != group_lanes || shape.stride != 1 || s.hz_places) {
        for (std::uint32_t lane = 0; lane < group_lanes; ++lane)
            look.gathered[lane] = record_of(s, number * group_lanes + std::min<std::uint32_t>(lane, shape.lanes - 1u));
        look.records = look.gathered;
    }
    const Site first = site_of(s, number * group_lanes);
    const Coord at = site_coord(first);
    const std::int32_t apart = 2 << first.z;
    const float unit_m = s.level_unit_m[2 * first.z + (shape.kind == VertexKind::centre ? 0 : 1)];
    s.evaluate(s.decision,
               {look.records, at.x, at.y, shape.along_y ? 0 : apart, shape.along_y ? apart : 0, info.base, unit_m},
               look.margins);
    ++s.report.evaluations;
    ++s.report.items;
    ++s.report.visits;
}

// Of the lanes in a mask, the smallest slack; and the largest error code.
struct Rest {
    float slack_m = 3e38f;
    std::uint32_t code = 0;

    void lessen(const Look& look, std::uint32_t mask, const float* margins_m) {
        for (; mask != 0; mask &= mask - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(mask));
            const float rounding_m = look.margins.span_m[lane] * slack_rounding;
            slack_m = std::min(slack_m, std::max(std::abs(margins_m[lane]) - rounding_m, 0.0f));
            code = std::max<std::uint32_t>(code, look.records[lane].error);
        }
    }
};

// Everything in the group agrees with the decision: when might that end?
void settle(CutState& s, std::uint32_t number, const Look& look) {
    s.groups[number].list = unlisted;
    if ((look.inactive() | look.childless()) == 0) return;
    Rest rest;
    rest.lessen(look, look.inactive(), look.margins.reach_m);
    rest.lessen(look, look.childless(), look.margins.keep_m);
    schedule(s.lists, number, rest.slack_m, grade_of(rest.code));
}

void queue(CutState& s, std::uint32_t number, const Look& look, std::uint32_t list) {
    push_back(s.lists, list, number);
    s.groups[number].due = look.rising() | look.falling() << 16;
}

void queue_rising(CutState& s, std::uint32_t number, const Look& look) {
    std::uint32_t rank = 0;
    for (std::uint32_t lanes = look.rising(); lanes != 0; lanes &= lanes - 1) {
        const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
        rank = std::max(rank, rank_of(s, judge(s, vertex, site_of(s, vertex), false)));
    }
    s.work_ranks |= 1u << rank;
    queue(s, number, look, work_lists + rank);
}

} // namespace

void examine(CutState& s, std::uint32_t number) {
    Look look(s.groups[number]);
    evaluate_group(s, number, look);
    if (look.rising() != 0) return queue_rising(s, number, look);
    if (look.falling() != 0) return queue(s, number, look, retire_list);
    settle(s, number, look);
}

void carry_out(CutState& s, std::uint32_t number, bool may_retire) {
    Look look(s.groups[number]);
    evaluate_group(s, number, look);
    CutReport& r = s.report;
    bool blocked = false, gated = false;
    // To look again is part of the first change: with one item a frame a mesh must get somewhere, too.
    bool looked = true;
    const auto spend = [&](std::uint32_t& changes) {
        ++changes;
        if (looked)
            --r.evaluations;
        else
            ++r.items;
        looked = false;
    };
    const auto may_go_on = [&] { return looked || r.items < s.item_limit; };
    for (std::uint32_t lanes = look.rising(); lanes != 0 && may_go_on(); lanes &= lanes - 1) {
        switch (activate(s, number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes)))) {
        case Outcome::done: spend(r.activations); break;
        case Outcome::gated: gated = true; break;
        case Outcome::no_vertices:
            s.short_of |= cut_budget_vertices;
            blocked = true;
            break;
        case Outcome::no_triangles:
            s.short_of |= cut_budget_triangles;
            blocked = true;
            break;
        }
    }
    if (may_retire)
        for (std::uint32_t lanes = look.falling(); lanes != 0 && may_go_on(); lanes &= lanes - 1) {
            const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
            if (deactivate(s, vertex) == Outcome::done) {
                spend(r.deactivations);
            } else {
                s.short_of |= cut_budget_triangles;
                blocked = true;
            }
        }
    if (blocked) return queue(s, number, look, blocked_lists + s.turn);
    if (gated && may_go_on()) return queue(s, number, look, gated_lists + s.gated_turn);
    if (look.rising() != 0) return queue_rising(s, number, look);
    if (look.falling() != 0) return queue(s, number, look, retire_list);
    settle(s, number, look);
}

std::uint32_t build_block(CutState& s, std::uint32_t number) {
    Look look(s.groups[number]);
    evaluate_group(s, number, look);
    const std::uint32_t lanes = look.rising();
    if (free_vertices(s) < group_lanes) {
        s.short_of |= cut_budget_vertices;
        return 0;
    }
    PageSlot& info = s.page_slot[number / max_page_groups];
    const GroupShape& shape = shape_of(s, number);
    const Coord at = site_coord(site_of(s, number * group_lanes));
    const std::int32_t apart = 2 << (info.z + shape.z);
    const float unit_m = s.level_unit_m[2 * (info.z + shape.z) + (shape.kind == VertexKind::centre ? 0 : 1)];
    Rest rest;
    for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::int32_t>(std::countr_zero(left));
        const VertexRecord record = look.records[lane];
        const std::uint32_t slot = take_vertex(s);
        s.slots[number * group_lanes + static_cast<std::uint32_t>(lane)] = slot;
        s.vertices[slot] = {std::min(at.x + (shape.along_y ? 0 : lane * apart), s.decision.last_x),
                            std::min(at.y + (shape.along_y ? lane * apart : 0), s.decision.last_y),
                            s.decision.base_m + static_cast<float>(record.height + info.base) * s.decision.quantum_m};
        s.morph[slot] = {0, s.decision.error_m[record.error],
                         unit_m * s.decision.radius_factor[record.radius & (radius_codes - 1)], never_born_s};
        s.hole[slot] = is_void(record);
        ++info.active;
        for (std::size_t d = 0; d < 4; ++d) s.made[std::size_t{slot} * 4 + d] = no_index;
    }
    look.state.active = static_cast<std::uint16_t>(lanes);
    // Of those that will have active children nobody knows yet; to look at them too is early, never late.
    rest.lessen(look, look.inactive(), look.margins.reach_m);
    rest.lessen(look, lanes, look.margins.keep_m);
    schedule(s.lists, number, rest.slack_m, grade_of(rest.code));
    return lanes;
}

} // namespace fjell
