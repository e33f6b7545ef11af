#include "cut/refine.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "cut/change.h"
#include "cut/error_bound.h"
#include "cut/evaluate.h"
#include "cut/state.h"
#include "shared/compiler.h"

namespace fjell {

namespace {

std::uint32_t bits(int mask) {
    return static_cast<std::uint32_t>(mask);
}

// A group as it was evaluated.
struct Evaluated {
    const GroupState* state;
    bool evicting;
    std::uint32_t morphing_out; // lanes that will go by themselves
    std::uint32_t looked_at;    // lanes of which there are answers
    LaneAnswers answers;

    // The lanes that could change: by the tree, they may.
    [[nodiscard]] std::uint32_t inactive() const { return evicting ? 0 : bits(state->ready() & ~state->active); }
    [[nodiscard]] std::uint32_t childless() const { return bits(state->active & ~state->parental()) & ~morphing_out; }
    // And by the decision, they should.
    [[nodiscard]] std::uint32_t to_activate() const { return inactive() & answers.wanted; }
    [[nodiscard]] std::uint32_t to_deactivate() const { return childless() & ~answers.kept; }
    [[nodiscard]] std::uint32_t calls() const { return to_activate() | to_deactivate() << 16; }
    // Are there answers of all that could change by now?
    [[nodiscard]] bool is_answered() const { return ((inactive() | childless()) & ~looked_at) == 0; }
};

// A group about to be evaluated: which of its lanes could change, and what its evaluation reads.
LaneGroup begin_evaluation(const CutState& s, const PageAtHand& page, std::uint32_t number,
                           VertexRecord (&gathered)[group_lanes], Evaluated& group) {
    const GroupState& state = s.pages.groups[number];
    std::uint32_t morphing_out = 0;
    for (std::uint32_t lanes = s.morphing.out_count != 0 ? state.active : 0u; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        if (morphs_out(s.mesh, s.pages.vertex_slot[number * group_lanes + lane])) morphing_out |= 1u << lane;
    }
    group.state = &state;
    group.evicting = page.info->status == PageStatus::evicting;
    group.morphing_out = morphing_out;
    LaneGroup lanes = lanes_of(s.pages, page, number, gathered);
    lanes.inactive = group.inactive();
    lanes.childless = group.childless();
    group.looked_at = lanes.inactive | lanes.childless;
    return lanes;
}

void count_evaluations(CutReport& r, std::uint32_t count) {
    r.evaluations += count;
    r.work += count;
    r.visits += count;
}

Evaluated evaluate_group(CutState& s, std::uint32_t number) {
    VertexRecord gathered[group_lanes];
    Evaluated group{};
    const LaneGroup lanes =
        begin_evaluation(s, page_at_hand(s.pages, number / max_page_groups), number, gathered, group);
    const Criterion* const criterion = &criterion_of(s.pages, s.views, number);
    if (group.looked_at != 0) s.views.evaluate(&criterion, &lanes, 1, &group.answers);
    count_evaluations(s.frame.report, 1);
    return group;
}

// Everything in the group agrees with the decision: when might that end?
void schedule_group(Pages& pages, Work& work, std::uint32_t number, const Evaluated& group) {
    pages.groups[number].queue = unqueued;
    if ((group.inactive() | group.childless()) == 0) return;
    tighten(work.schedule, number, group.answers.slack_m, grade_of(group.answers.code));
}

void queue(Work& work, std::uint32_t number, const Evaluated& group, std::uint32_t queue) {
    push_back(work.queues, queue, number);
    work.queues.nodes[number].calls = group.calls();
}

// The highest of the vertices that a group is to activate.
std::uint32_t rank_of(const Pages& pages, const Views& views, std::uint32_t number, const Evaluated& group) {
    std::uint32_t rank = 0;
    for (std::uint32_t lanes = group.to_activate(); lanes != 0; lanes &= lanes - 1) {
        const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
        rank = std::max(rank, rank_of(views, evaluate_vertex(pages, views, vertex, site_of(pages, vertex), false)));
    }
    return rank;
}

void queue_activations(const Pages& pages, Work& work, const Views& views, std::uint32_t number,
                       const Evaluated& group) {
    const std::uint32_t rank = rank_of(pages, views, number, group);
    work.queues.work_ranks |= 1u << rank;
    queue(work, number, group, work_queues + rank);
}

// Puts the group in the queue that its lanes call for, or schedules it.
void examine(CutState& s, std::uint32_t number) {
    FJELL_ASSERT(s.pages.groups[number].queue == unqueued); // what waits in a queue is not scheduled
    forget(s.work.schedule, number);
    const Evaluated group = evaluate_group(s, number);
    if (group.to_activate() != 0) return queue_activations(s.pages, s.work, s.views, number, group);
    if (group.to_deactivate() != 0) return queue(s.work, number, group, deactivation_queue);
    schedule_group(s.pages, s.work, number, group);
}

// Prefetching what changes will touch. What a change costs is a chain of cache misses: the parents'
// vertex slots, the triangles at their right angles, those triangles' corners. For a batch of changes every link of the
// chain is prefetched for all of them before the next one is followed for any.

// What one change will touch. Only a hint, but for what is around the vertex: by the time it is made things may have
// changed.
struct PlannedChange {
    std::uint32_t vertex;
    bool activation;
    Around around;
    std::uint32_t triangles[4]; // keys, then slots
};

// What evaluating a group reads.
inline void prefetch_group(const Pages& pages, std::uint32_t group) {
    FJELL_PREFETCH_TO_WRITE(&pages.groups[group]);
    const VertexRecord* const records = records_of(pages, group / max_page_groups) + shape_of(pages, group).first;
    FJELL_PREFETCH_TO_WRITE(records);
    FJELL_PREFETCH_TO_WRITE(records + group_lanes - 1);
}

inline void prefetch_record(const Pages& pages, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes, slot = group / max_page_groups;
    const GroupShape& shape = shape_of(pages, group);
    FJELL_PREFETCH_TO_WRITE(records_of(pages, slot) + shape.first + shape.stride * (vertex % group_lanes));
}

// The first link: vertices around it.
inline void plan_change(const Pages& pages, std::uint32_t vertex, bool activation, PlannedChange& plan) {
    plan.vertex = vertex;
    plan.activation = activation;
    plan.around = find_around(pages, vertex);
    std::fill_n(plan.triangles, 4, no_index);
    FJELL_PREFETCH_TO_WRITE(&pages.vertex_slot[vertex]);
    for (const std::uint32_t child : plan.around.child) {
        if (child == no_index) continue;
        FJELL_PREFETCH_TO_WRITE(&pages.groups[child / group_lanes]);
        if (activation) prefetch_record(pages, child);
    }
    for (const std::uint32_t parent : plan.around.parent) {
        if (parent == no_index) continue;
        FJELL_PREFETCH_TO_WRITE(&pages.groups[parent / group_lanes]);
        FJELL_PREFETCH_TO_WRITE(&pages.vertex_slot[parent]);
        if (!activation) prefetch_record(pages, parent);
    }
}

// The second link: the slots of their triangles.
inline void prefetch_triangle_slots(const Pages& pages, const Mesh& mesh, PlannedChange& plan) {
    if (plan.activation) {
        for (int n = 0; n < 2; ++n) {
            const std::uint32_t parent = plan.around.parent[n];
            if (parent == no_index || !is_active(pages, parent)) continue;
            plan.triangles[n] = pages.vertex_slot[parent] * 4 +
                                static_cast<std::uint32_t>(child_number(parent_bearing(plan.around.site, n)));
            FJELL_PREFETCH_TO_WRITE(&mesh.triangle_of[plan.triangles[n]]);
        }
    } else if (is_active(pages, plan.vertex)) {
        for (std::uint32_t d = 0; d < 4; ++d) plan.triangles[d] = pages.vertex_slot[plan.vertex] * 4 + d;
        FJELL_PREFETCH_TO_WRITE(&mesh.triangle_of[plan.triangles[0]]);
    }
}

// The third: those triangles.
inline void prefetch_triangles(const Mesh& mesh, PlannedChange& plan) {
    for (std::uint32_t& triangle : plan.triangles) {
        if (triangle == no_index) continue;
        triangle = mesh.triangle_of[triangle];
        if (triangle == no_index) continue;
        FJELL_PREFETCH_TO_WRITE(&mesh.indices[std::size_t{triangle} * 3]);
    }
}

// The fourth: the ends of the edge that an activation splits.
inline void prefetch_corners(const Mesh& mesh, const Morphing& morphing, const PlannedChange& plan) {
    if (!plan.activation || plan.triangles[0] == no_index || morphing.now.morph == Morph::none) return;
    const std::uint32_t* const t = mesh.indices + std::size_t{plan.triangles[0]} * 3;
    FJELL_PREFETCH_TO_WRITE(&mesh.vertices[t[1]]);
    FJELL_PREFETCH_TO_WRITE(&mesh.vertices[t[2]]);
}

// Groups that are changed together, so that what they touch can be prefetched for all of them first.
constexpr std::uint32_t batch_groups = 16;

// Their changes. More would push each other out of the cache.
class Plans {
public:
    // Of a group: the lanes that call for changes, activations in the lower half.
    void add(const Pages& pages, std::uint32_t group, std::uint32_t calls) {
        for (; calls != 0 && count_ < most; calls &= calls - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(calls));
            plan_change(pages, group * group_lanes + lane % group_lanes, lane < group_lanes, plans_[count_++]);
        }
    }
    void prefetch(const Pages& pages, const Mesh& mesh, const Morphing& morphing) {
        for (std::uint32_t i = 0; i < count_; ++i) prefetch_triangle_slots(pages, mesh, plans_[i]);
        prefetch_last_triangles(pages, mesh);
        for (std::uint32_t i = 0; i < count_; ++i) prefetch_triangles(mesh, plans_[i]);
        for (std::uint32_t i = 0; i < count_; ++i) prefetch_corners(mesh, morphing, plans_[i]);
    }
    // What is around a vertex: of those that were added, in their order, or another one.
    [[nodiscard]] const Around& around(const Pages& pages, std::uint32_t vertex) {
        for (std::uint32_t i = next_; i < count_ && i < next_ + 2 * group_lanes; ++i)
            if (plans_[i].vertex == vertex) {
                next_ = i + 1;
                return plans_[i].around;
            }
        return other_ = find_around(pages, vertex);
    }

private:
    // Each deactivation moves its tile's last two triangles into the places of those that go; what activations before
    // it have appended is at hand.
    void prefetch_last_triangles(const Pages& pages, const Mesh& mesh) const {
        std::uint32_t tile = no_index, appended = 0, last = 0, left = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            if (const std::uint32_t of = pages.state[plans_[i].vertex / max_page_vertices].tile; of != tile) {
                tile = of;
                const TileList& list = mesh.tiles[tile];
                appended = 0;
                left = list.in_last;
                last = (list.last_segment << mesh.segment_log2) + left;
            }
            if (plans_[i].activation) {
                appended += 2;
                continue;
            }
            for (int n = 0; n < 2; ++n) {
                if (appended != 0) {
                    --appended;
                } else if (left != 0) {
                    --left;
                    FJELL_PREFETCH_TO_WRITE(&mesh.triangle_of[std::size_t{mesh.indices[std::size_t{--last} * 3]} * 4]);
                }
            }
        }
    }

    static constexpr std::uint32_t most = 6 * batch_groups;
    std::uint32_t count_ = 0, next_ = 0;
    PlannedChange plans_[most];
    Around other_;
};

// Activates and deactivates what its lanes call for, as far as this frame's items go; deactivations only if they may.
// What is left over keeps the group in a queue; otherwise it is scheduled.
// looked: the group has been evaluated for this, which is part of the first change: with one item a frame a mesh must
// get somewhere, too.
void make_changes(CutState& s, Plans& plans, std::uint32_t number, const Evaluated& group, bool may_deactivate,
                  bool looked) {
    CutReport& r = s.frame.report;
    bool blocked = false, gated = false, rising = false;
    std::int64_t arrives_ticks = 0; // the first of those that something waits for
    const auto spend = [&](std::uint32_t& changes) {
        ++changes;
        if (looked)
            --r.evaluations;
        else
            ++r.work;
        looked = false;
    };
    const auto may_go_on = [&] { return looked || r.work < s.frame.item_limit; };
    for (std::uint32_t lanes = group.to_activate(); lanes != 0 && may_go_on(); lanes &= lanes - 1) {
        const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
        switch (activate(s, vertex, plans.around(s.pages, vertex))) {
        case Outcome::done: spend(r.activations); break;
        case Outcome::gated: gated = true; break;
        case Outcome::rising:
            arrives_ticks = rising ? std::min(arrives_ticks, s.morphing.arrives_ticks) : s.morphing.arrives_ticks;
            rising = true;
            break;
        case Outcome::no_vertices:
        case Outcome::no_pages: // states come with vertices
            s.frame.full_capacities |= cut_budget_vertices;
            blocked = true;
            break;
        case Outcome::no_triangles:
            s.frame.full_capacities |= cut_budget_triangles;
            blocked = true;
            break;
        }
    }
    if (may_deactivate)
        for (std::uint32_t lanes = group.to_deactivate(); lanes != 0 && may_go_on(); lanes &= lanes - 1) {
            const std::uint32_t vertex = number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes));
            if (deactivate(s.pages, s.work, s.mesh, s.views, vertex, plans.around(s.pages, vertex)) == Outcome::done) {
                spend(r.deactivations);
            } else {
                s.frame.full_capacities |= cut_budget_triangles;
                blocked = true;
            }
        }
    if (blocked) return queue(s.work, number, group, blocked_queues + s.work.queues.turn);
    if (rising && may_go_on()) return queue(s.work, number, group, rising_queue(s.work.queues, arrives_ticks));
    if (gated && may_go_on()) return queue(s.work, number, group, gated_queues + s.work.queues.gated_turn);
    if (group.to_activate() != 0) return queue_activations(s.pages, s.work, s.views, number, group);
    if (group.to_deactivate() != 0) return queue(s.work, number, group, deactivation_queue);
    schedule_group(s.pages, s.work, number, group);
}

} // namespace

bool out_of_time(Frame& frame, bool done_something) {
    if (frame.report.visits >= frame.settings.visits) return true;
    if (frame.settings.max_time_us <= 0 || !done_something ||
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - frame.started).count() <
            frame.settings.max_time_us - frame.reserved_us)
        return false;
    frame.report.exhausted |= cut_budget_time;
    return true;
}

bool has_done_something(const Frame& frame) {
    return frame.report.work != 0 || frame.report.visits != 0;
}

namespace {

void change_group(CutState& s, Plans& plans, std::uint32_t number, bool may_deactivate) {
    make_changes(s, plans, number, evaluate_group(s, number), may_deactivate, true);
}

// Groups that have just been evaluated and call for changes.
constexpr std::uint32_t called_together = 8; // that are evaluated side by side
struct Called {
    std::uint32_t count = 0;
    struct Group {
        std::uint32_t number;
        std::uint32_t order; // the highest is to be changed first: its rank + 1; 0: deactivations only
        Evaluated evaluated;
    } of[batch_groups + called_together];
};

void end_batch(CutState& s, std::uint32_t full_before) {
    ++s.frame.batches;
    keep_pages_at_hand(s.pages, s.work, s.mesh);
    if (s.frame.full_capacities != full_before) s.frame.deactivations_when_full = s.frame.report.deactivations;
}

// They are due again.
void put_back_called(CutState& s, Called& called, std::uint32_t from) {
    for (; from < called.count; ++from) {
        s.pages.groups[called.of[from].number].queue = unqueued;
        make_due(s.work.schedule, called.of[from].number);
    }
    called.count = 0;
}

// The worst first, otherwise in the order in which they were evaluated.
void sort(Called& called) {
    for (std::uint32_t i = 1; i < called.count; ++i) {
        if (called.of[i - 1].order >= called.of[i].order) continue;
        const Called::Group group = called.of[i];
        std::uint32_t to = i;
        for (; to != 0 && called.of[to - 1].order < group.order; --to) called.of[to] = called.of[to - 1];
        called.of[to] = group;
    }
}

// Changes them, the worst first, by the answers that there are. Each is a visit, so that a frame which its time has
// ended is replayed by their number. False when there was not time or items for all of them; the rest is due again.
bool change_called(CutState& s, Called& called) {
    Plans plans;
    sort(called);
    for (std::uint32_t i = 0; i < called.count; ++i)
        plans.add(s.pages, called.of[i].number, called.of[i].evaluated.calls());
    plans.prefetch(s.pages, s.mesh, s.morphing);
    const std::uint32_t full_before = s.frame.full_capacities;
    std::uint32_t i = 0;
    for (; i < called.count && !out_of_items(s.frame) && !out_of_time(s.frame, true); ++i) {
        const std::uint32_t number = called.of[i].number;
        if (called.of[i].evaluated.is_answered()) {
            ++s.frame.report.visits;
            make_changes(s, plans, number, called.of[i].evaluated, true, false);
        } else { // others of its lanes may change by what was changed before it
            change_group(s, plans, number, true);
        }
    }
    const bool all = i == called.count;
    put_back_called(s, called, i);
    end_batch(s, full_before);
    return all;
}

// False when there was not time or items for all of them; the rest goes back to its queue.
bool change_batch(CutState& s, std::uint32_t queue, bool may_deactivate) {
    std::uint32_t groups[batch_groups], count = 0;
    Plans plans;
    for (; count < batch_groups && s.work.queues.sizes[queue] != 0; ++count) {
        groups[count] = pop_front(s.work.queues, queue);
        s.pages.groups[groups[count]].queue = being_visited;
    }
    for (std::uint32_t i = 0; i < count; ++i) plans.add(s.pages, groups[i], s.work.queues.nodes[groups[i]].calls);
    plans.prefetch(s.pages, s.mesh, s.morphing);
    const std::uint32_t full_before = s.frame.full_capacities;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (s.frame.report.work < s.frame.item_limit && !out_of_time(s.frame, has_done_something(s.frame))) {
            change_group(s, plans, groups[i], may_deactivate);
            continue;
        }
        // As they were: a frame that ends by its time must leave the same order as one that ends by its items.
        while (count > i) push_front(s.work.queues, queue, groups[--count]);
        return false;
    }
    end_batch(s, full_before);
    return true;
}

// While the mesh lags, some batches give slots back, or it would outgrow what the view wants: one in sixteen while
// there is room, one in three when there is not.
std::uint32_t deactivation_interval(const Mesh& mesh) {
    const bool room = free_vertices(mesh) > mesh.capacity / 4 && mesh.free_segment_count > mesh.segment_count / 4;
    return room ? 16 : 3;
}

// Of activations; unqueued where none waits.
std::uint32_t worst_queue(Queues& queues) {
    while (queues.work_ranks != 0) {
        const auto rank = static_cast<std::uint32_t>(std::bit_width(queues.work_ranks)) - 1;
        if (queues.sizes[work_queues + rank] != 0) return work_queues + rank;
        queues.work_ranks &= ~(1u << rank);
    }
    return unqueued;
}

// The queue that comes next; unqueued when all are done. Deactivations come last, but first when a capacity is spent,
// and then what was blocked is tried again.
std::uint32_t next_queue(Work& work, const Mesh& mesh, const Morphing& morphing, Frame& frame) {
    const bool can_deactivate = work.queues.sizes[deactivation_queue] != 0;
    if (can_deactivate &&
        (frame.full_capacities != 0 || (frame.lagging && frame.batches % deactivation_interval(mesh) == 0)))
        return deactivation_queue;
    if (frame.full_capacities != 0 && frame.deactivations_when_full != frame.report.deactivations) {
        frame.full_capacities = 0;
        work.queues.turn ^= 1;
    }
    if (const std::uint32_t worst = worst_queue(work.queues); worst != unqueued) return worst;
    if (can_deactivate) return deactivation_queue;
    Queues& q = work.queues;
    for (std::uint32_t n = 1; n <= rising_slots && q.open_slots != 0; ++n) { // those that opened first, first
        const auto slot = static_cast<std::uint32_t>((q.opened + n) % rising_slots);
        if ((q.open_slots >> slot & 1) != 0 && q.sizes[rising_queues + slot] != 0) return rising_queues + slot;
        q.open_slots &= ~(1u << slot);
    }
    const std::uint32_t gated_before = gated_queues + (work.queues.gated_turn ^ 1);
    const bool open = work.queues.gate_passes != 0 || morphing.now.morph == Morph::none;
    if (open && work.queues.sizes[gated_before] != 0) return gated_before;
    const std::uint32_t blocked_before = blocked_queues + (work.queues.turn ^ 1);
    return work.queues.sizes[blocked_before] != 0 && frame.full_capacities == 0 ? blocked_before : unqueued;
}

// Due pages, a batch at a time: what a visit costs is a chain of cache misses, a page's ticks, then its spent groups.
// Each link is prefetched for the whole batch before the next one is followed.
class PageVisits {
public:
    explicit PageVisits(CutState& state) : s(state) { open(); }
    PageVisits(const PageVisits&) = delete;
    PageVisits& operator=(const PageVisits&) = delete;
    // What was not finished stays due.
    ~PageVisits() {
        put_back_called(s, called_, 0);
        while (page_count_ != 0) put_back_due(s.work.schedule, pages_[--page_count_]);
    }

    // Is there a group to be evaluated? Closes pages that have none left. Whoever looks at the clock asks first: where
    // a frame ends must not depend on groups that were queued meanwhile, or it could not be replayed by its visits.
    [[nodiscard]] bool any() {
        while (page_count_ != 0) {
            while (next_ != count_ && ticks_of(s.work.schedule, groups_[next_]) != spent) ++next_;
            if (next_ != count_) return true;
            if (called_.count != 0) return false; // of these pages
            while (page_count_ != 0) {
                close_page(s.work.schedule, pages_[--page_count_]);
                note_bound(s.pages, s.work, s.views, pages_[page_count_]);
            }
            open();
        }
        return false;
    }
    // Evaluates it.
    void examine_next() {
        if (next_ + ahead < count_) prefetch_group(s.pages, groups_[next_ + ahead]);
        examine(s, groups_[next_++]);
        ++s.frame.examined;
    }
    // Evaluates all, and changes what they call for, page by page. False: the frame may do no more.
    [[nodiscard]] bool change_all() {
        for (;;) {
            const bool more = any();
            if (called_.count >= batch_groups || (!more && called_.count != 0)) {
                if (!change_called(s, called_) || !change_queued()) return false;
                continue;
            }
            if (!more) return true;
            if (out_of_items(s.frame) || out_of_time(s.frame, has_done_something(s.frame))) return false;
            look_at_next();
        }
    }

private:
    // What has become ready by that, and all that comes of it.
    [[nodiscard]] bool change_queued() {
        for (;;) {
            const std::uint32_t queue = worst_queue(s.work.queues);
            if (queue == unqueued) return true;
            if (out_of_items(s.frame) || !change_batch(s, queue, true)) return false;
        }
    }

    static constexpr std::uint32_t most_pages = 16, enough_groups = 48, ahead = 8, together = called_together;

    // Several, as far as the frame may: so many, some others between them or not, or a replay whose visits end with
    // them would change what they call for at another place.
    void look_at_next() {
        const CutReport& r = s.frame.report;
        const std::uint32_t most =
            std::min({together, s.frame.item_limit - r.work, s.frame.settings.visits - r.visits});
        for (std::uint32_t i = next_ + together; i < std::min(count_, next_ + 2 * together); ++i)
            prefetch_group(s.pages, groups_[i]);
        std::uint32_t numbers[together], count = 0;
        VertexRecord gathered[together][group_lanes];
        Evaluated evaluated[together];
        LaneGroup lanes[together];
        LaneAnswers answers[together];
        const Criterion* criteria[together];
        const InWork* pages[together];
        for (; next_ < count_ && count < most; ++next_) {
            const std::uint32_t number = groups_[next_];
            while (number - in_work_[page_].at_hand.first >= max_page_groups) ++page_;
            const InWork& page = in_work_[page_];
            std::uint16_t& ticks = page.due.ticks[number - page.at_hand.first];
            if (ticks != spent) continue; // it has come to wait in a queue
            ticks = unscheduled;
            numbers[count] = number;
            pages[count] = &page;
            criteria[count] = &criterion_of(s.pages, s.views, number);
            lanes[count] = begin_evaluation(s, page.at_hand, number, gathered[count], evaluated[count]);
            ++count;
        }
        s.views.evaluate(criteria, lanes, count, answers);
        count_evaluations(s.frame.report, count);
        for (std::uint32_t i = 0; i < count; ++i) {
            evaluated[i].answers = answers[i];
            if (evaluated[i].calls() != 0) {
                s.pages.groups[numbers[i]].queue = being_visited;
                const std::uint32_t rank = rank_of(s.pages, s.views, numbers[i], evaluated[i]);
                const std::uint32_t order = evaluated[i].to_activate() != 0 ? 1 + rank : 0;
                called_.of[called_.count++] = {numbers[i], order, evaluated[i]};
            } else if (grade_of(answers[i].code) > pages[i]->due.grade) {
                schedule_group(s.pages, s.work, numbers[i], evaluated[i]);
            } else if (evaluated[i].looked_at != 0) {
                tighten(pages[i]->due, numbers[i] - pages[i]->at_hand.first, answers[i].slack_m);
            }
        }
    }

    void open() {
        next_ = count_ = page_ = 0;
        std::uint32_t popped[most_pages], n = 0;
        for (; n < most_pages; ++n) {
            popped[n] = pop_due(s.work.schedule);
            if (popped[n] == no_index) break;
            FJELL_PREFETCH_TO_WRITE(&s.work.schedule.pages[popped[n]]);
            FJELL_PREFETCH_TO_WRITE(&s.pages.state[popped[n]]);
            const std::uint16_t* const ticks = s.work.schedule.ticks + std::size_t{popped[n]} * page_ticks;
            for (std::uint32_t i = 0; i < page_ticks; i += 32) FJELL_PREFETCH_TO_WRITE(ticks + i);
        }
        std::uint32_t used = 0;
        for (; used < n && count_ < enough_groups; ++used) add(popped[used]);
        while (n > used) put_back_due(s.work.schedule, popped[--n]);
        for (std::uint32_t i = 0; i < std::min(count_, ahead); ++i) prefetch_group(s.pages, groups_[i]);
    }
    void add(std::uint32_t slot) {
        std::uint64_t spent_groups[page_words];
        find_spent(s.work.schedule, slot, spent_groups);
        const InWork& page = in_work_[page_count_] = {page_at_hand(s.pages, slot), due_page(s.work.schedule, slot)};
        pages_[page_count_++] = slot;
        for (std::uint32_t word = 0; word < page_words; ++word)
            for (std::uint64_t left = spent_groups[word]; left != 0; left &= left - 1) {
                const std::uint32_t n = word * 64 + static_cast<std::uint32_t>(std::countr_zero(left));
                page.due.ticks[n] = spent; // what comes to wait in a queue until its turn is not
                groups_[count_++] = page.at_hand.first + n;
            }
    }

    CutState& s;
    Called called_;
    struct InWork {
        PageAtHand at_hand;
        DuePage due;
    };
    std::uint32_t page_count_ = 0, next_ = 0, count_ = 0, page_ = 0;
    InWork in_work_[most_pages];
    std::uint32_t pages_[most_pages];
    std::uint32_t groups_[enough_groups + max_page_groups];
};

} // namespace

std::uint32_t waiting_groups(const Work& work) {
    std::uint32_t n = work.schedule.due_count;
    for (const std::uint32_t size : work.queues.sizes) n += size;
    return n;
}

std::uint32_t blocked_groups(const Work& work) {
    return work.queues.sizes[blocked_queues] + work.queues.sizes[blocked_queues + 1];
}

namespace {

// True when the items were spent before the work.
bool work_off(CutState& s) {
    PageVisits visits(s);
    // A frame that begins at rest will probably do all that is due, so it need not know all before it changes any.
    const bool at_rest = !s.frame.lagging && !s.views.jumped && s.governor.cause == 0;
    if (at_rest && !visits.change_all()) return out_of_items(s.frame);
    // While the mesh lags, what is known to be bad does not wait for all that might be.
    s.frame.lagging = s.frame.lagging || s.views.jumped;
    const std::uint32_t most_examined = s.frame.lagging ? 2 * batch_groups : unlimited_work;
    while (s.frame.report.work < s.frame.item_limit) {
        const bool any_due = visits.any();
        if (any_due && s.frame.examined < most_examined) {
            if (out_of_time(s.frame, has_done_something(s.frame))) return false;
            visits.examine_next();
            continue;
        }
        s.frame.examined = 0;
        const std::uint32_t queue = next_queue(s.work, s.mesh, s.morphing, s.frame);
        if (queue == unqueued && !any_due) return false;
        if (queue == unqueued) continue;
        if (!change_batch(s, queue, queue == deactivation_queue || !s.frame.lagging)) break;
    }
    return s.frame.report.work >= s.frame.item_limit;
}

} // namespace

void refine(CutState& s) {
    if (work_off(s) && waiting_groups(s.work) != blocked_groups(s.work) &&
        (s.frame.report.exhausted & cut_budget_time) == 0)
        s.frame.report.exhausted |= cut_budget_work;
}

} // namespace fjell
