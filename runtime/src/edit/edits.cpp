// Stamps become ground here (fjell/edit.h).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

#include "block_layout.h"
#include "edit/apply.h"
#include "edit/areas.h"
#include "edit/paint.h"
#include "edit/radii.h"
#include "edit/refuse.h"
#include "shared/stamp.h"

namespace fjell {

using namespace edit;

namespace {

std::uint64_t queue_cells(const EditBudget& budget) {
    return std::bit_ceil(std::max<std::uint64_t>(budget.stamps, 2));
}
std::uint32_t table_size(std::uint32_t blocks) {
    return std::bit_ceil(2 * std::max(blocks, 1u));
}

struct Layout {
    std::size_t queue, results, waiting, moving, blocks, holes, table, areas, paint, locks, lock_table, end;
};
bool has_maps(const PackHeader& header) {
    return header.colour_log2 != 0 || header.splat_log2 != 0;
}
Layout layout_of(const PackHeader& header, const EditBudget& budget) {
    BlockLayout block(sizeof(EditsData));
    Layout l{};
    l.queue = block.place(queue_cells(budget), sizeof(QueueCell));
    l.results = block.place(2 * queue_cells(budget), sizeof(std::atomic<std::uint64_t>));
    l.waiting = block.place(budget.stamps, sizeof(Waiting));
    l.moving = block.place(budget.moving, sizeof(Moving));
    l.blocks = block.place(budget.blocks, sizeof(Block));
    l.holes = block.place(budget.holes ? budget.blocks : 0, sizeof(BlockHoles));
    l.table = block.place(table_size(budget.blocks), sizeof(std::uint32_t));
    l.areas = block.place(budget.areas, sizeof(Area));
    l.paint = block.place(has_maps(header) ? paint_bytes_of(budget.paint) : 0, 1);
    l.locks = block.place(budget.locks, sizeof(LockBlock));
    l.lock_table = block.place(table_size(budget.locks), sizeof(std::uint32_t));
    l.end = block.end();
    return l;
}

Status check_budget(const EditBudget& budget) {
    constexpr std::uint32_t most = 1u << 24;
    if (budget.blocks == 0 || budget.blocks > most) return {StatusCode::out_of_range, "EditBudget::blocks"};
    if (budget.stamps == 0 || budget.stamps > most) return {StatusCode::out_of_range, "EditBudget::stamps"};
    if (budget.areas < 2 || budget.areas > most) return {StatusCode::out_of_range, "EditBudget::areas"};
    if (budget.paint > most) return {StatusCode::out_of_range, "EditBudget::paint"};
    if (budget.locks > most) return {StatusCode::out_of_range, "EditBudget::locks"};
    if (budget.moving > 1024) return {StatusCode::out_of_range, "EditBudget::moving"};
    return {};
}

constexpr Status no_edits{StatusCode::invalid_handle, "edits, or their terrain"};

EditsData* find_edits(const Edits& edits) {
    EditsData* const e = find(edits);
    return e != nullptr && find(e->handle) != nullptr ? e : nullptr;
}

// Fields that are to blame for a refusal, by number: results hold no pointer.
constexpr const char* refusals[] = {"",
                                    "EditBudget::blocks",
                                    "Stamp (heights span more than 65,535 steps of the height scale within a page)",
                                    "Stamp (steeper, or higher, than the pack's codes can bound)",
                                    "Stamp (a height that is no number)",
                                    "EditBudget::paint",
                                    "Stamp::shape (the pack has no colour or splat maps)",
                                    "EditBudget::locks"};

// Unless a later stamp has the place: one may wait for its pages while thousands come and go.
void set_result(EditsData& e, StampId id, StampState state, StatusCode code = StatusCode::ok, std::uint32_t field = 0) {
    std::atomic<std::uint64_t>& result = e.results[id % (2 * e.queue_size)];
    const std::uint64_t now = id << 16 | static_cast<std::uint64_t>(state) << 12 | std::uint64_t{field} << 8 |
                              static_cast<std::uint64_t>(code);
    std::uint64_t before = result.load(std::memory_order_relaxed);
    while (before >> 16 <= id &&
           !result.compare_exchange_weak(before, now, std::memory_order_release, std::memory_order_relaxed)) {
    }
}

} // namespace

bool has_room_for_holes(const PackHeader& h) {
    return check_ranges(h).ok() && rims_have_codes(h);
}

bool has_room_for_locks(const PackHeader& h) {
    if (!check_ranges(h).ok() || h.estimate == ErrorEstimate::midpoint) return false;
    const ErrorScale errors = ErrorScale::make(h.error_floor_m, h.error_ratio, h.error_nesting_steps);
    const double across_m = std::hypot((h.columns - 1.0) * h.spacing_m[0], (h.rows - 1.0) * h.spacing_m[1]);
    return static_cast<double>(errors.metres[errors.always(2 * static_cast<int>(h.tile_log2) - 1)]) >=
           across_m * always_drawn_share;
}

std::size_t edits_bytes(const PackHeader& header, const EditBudget& budget) {
    if (!check_ranges(header).ok() || !check_budget(budget).ok()) return 0;
    return layout_of(header, budget).end;
}

Status create_edits(const Terrain& terrain, const EditBudget& budget, std::span<std::byte> memory, Edits& edits) {
    TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    if (t->is_sparse()) return {StatusCode::not_supported, "terrain (sparse)"};
    if (t->edits != nullptr) return {StatusCode::not_supported, "terrain (it has edits)"};
    if (Status s = check_budget(budget); !s.ok()) return s;
    const Layout l = layout_of(t->header, budget);
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(at, 0, l.end); // every page of memory is touched now
    EditsData& e = *new (at) EditsData{};
    e.handle = terrain;
    e.terrain = t;
    e.budget = budget;
    e.radius = radius_terms(*t);
    e.queue_size = queue_cells(budget);
    e.queue = reinterpret_cast<QueueCell*>(at + l.queue);
    for (std::uint64_t i = 0; i < e.queue_size; ++i) new (&e.queue[i]) QueueCell{{i}, {}, 0};
    e.results = reinterpret_cast<std::atomic<std::uint64_t>*>(at + l.results);
    for (std::uint64_t i = 0; i < 2 * e.queue_size; ++i) new (&e.results[i]) std::atomic<std::uint64_t>(0);
    e.waiting = reinterpret_cast<Waiting*>(at + l.waiting);
    e.moving = reinterpret_cast<Moving*>(at + l.moving);
    e.blocks = reinterpret_cast<Block*>(at + l.blocks);
    e.block_holes = budget.holes ? reinterpret_cast<BlockHoles*>(at + l.holes) : nullptr;
    e.block_table = {reinterpret_cast<std::uint32_t*>(at + l.table), table_size(budget.blocks)};
    e.locks = reinterpret_cast<LockBlock*>(at + l.locks);
    e.lock_table = {reinterpret_cast<std::uint32_t*>(at + l.lock_table), table_size(budget.locks)};
    for (const BlockTable& table : {e.block_table, e.lock_table}) std::fill_n(table.cells, table.size, no_index);
    e.areas = reinterpret_cast<Area*>(at + l.areas);
    if (has_maps(t->header)) e.paint = make_paint(t->header, budget.paint, at + l.paint);
    if (budget.holes) t->holes_made = true;
    e.room_for_holes = t->has_voids() && rims_have_codes(t->header);
    e.room_for_locks = has_room_for_locks(t->header);
    e.steepest_m = steepest_of_codes(e);
    HandleAccess::begin(e, edits);
    t->edits = &e;
    t->changed_ground = e.changes;
    store_release(t->paint, e.paint);
    // What edits before these have changed is not in this log: whoever has not followed it looks at everything.
    if (t->ground_changes != 0) t->ground_changes += ground_change_log + 1;
    return {};
}

Status destroy_edits(const Edits& edits) {
    EditsData* const e = find(edits);
    if (e == nullptr) return no_edits;
    if (TerrainData* const t = find(e->handle)) {
        t->edits = nullptr;
        t->changed_ground = nullptr;
        store_release(t->paint, static_cast<PaintData*>(nullptr));
    }
    (void)HandleAccess::end(edits);
    return {};
}

Status push_stamp(const Edits& edits, const Stamp& stamp, StampId& id) {
    EditsData* const e = find_edits(edits);
    if (e == nullptr) return no_edits;
    if (Status s = check_stamp(stamp); !s.ok()) return s;
    if (makes_or_fills_holes(stamp.shape)) {
        if (!e->budget.holes) return {StatusCode::out_of_range, "EditBudget::holes"};
        if (!e->room_for_holes)
            return {StatusCode::out_of_range,
                    "Stamp::shape (holes need a pack that is baked with --room-for-holes yes)"};
    }
    if (stamp.shape == StampShape::lock && !e->room_for_locks)
        return {StatusCode::out_of_range,
                "Stamp::shape (locks need a pack that is baked with --room-for-locks yes and --estimate max)"};
    for (std::uint64_t at = e->tail.load(std::memory_order_relaxed);;) {
        QueueCell& cell = e->queue[at & (e->queue_size - 1)];
        const auto ahead = static_cast<std::int64_t>(cell.turn.load(std::memory_order_acquire) - at);
        if (ahead < 0) return {StatusCode::out_of_slots, "EditBudget::stamps"};
        if (ahead > 0) {
            at = e->tail.load(std::memory_order_relaxed);
            continue;
        }
        if (!e->tail.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) continue;
        cell.stamp = stamp;
        cell.id = id = at + 1;
        set_result(*e, id, StampState::waiting);
        cell.turn.store(at + 1, std::memory_order_release);
        return {};
    }
}

StampResult stamp_state(const Edits& edits, StampId id) {
    const EditsData* const e = find_edits(edits);
    if (e == nullptr || id == 0) return {};
    const std::uint64_t stored = e->results[id % (2 * e->queue_size)].load(std::memory_order_acquire);
    if (stored >> 16 != id) return {};
    return {static_cast<StampState>(stored >> 12 & 15),
            {static_cast<StatusCode>(stored & 0xff),
             refusals[std::min<std::uint64_t>(stored >> 8 & 15, std::size(refusals) - 1)]}};
}

namespace {

using Clock = std::chrono::steady_clock;
double microseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::micro>(to - from).count();
}

class Budgeted {
public:
    Budgeted(const EditSettings& settings, EditReport& report) : settings_(settings), report_(report) {}
    // Before an item.
    [[nodiscard]] bool may_go_on() {
        if (report_.work >= settings_.max_work) {
            report_.exhausted |= edit_budget_work;
            return false;
        }
        if (settings_.max_time_us != 0 &&
            microseconds(started_, Clock::now()) >= static_cast<double>(settings_.max_time_us)) {
            report_.exhausted |= edit_budget_time;
            return false;
        }
        ++report_.work;
        return true;
    }

private:
    const EditSettings& settings_;
    EditReport& report_;
    Clock::time_point started_ = Clock::now();
};

void take_stamps(EditsData& e) {
    while (e.waiting_count < e.budget.stamps) {
        QueueCell& cell = e.queue[e.queue_head & (e.queue_size - 1)];
        if (cell.turn.load(std::memory_order_acquire) != e.queue_head + 1) return;
        Waiting& w = e.waiting[e.waiting_count++];
        w = {.stamp = cell.stamp,
             .id = cell.id,
             .places = places_of(e.terrain->tree, samples_of(*e.terrain, cell.stamp))};
        cell.turn.store(e.queue_head + e.queue_size, std::memory_order_release);
        ++e.queue_head;
    }
}

double distance_m(const TerrainData& t, const Rect& places, const View& view) {
    const double x0 = places.x0 * t.header.spacing_m[0], x1 = places.x1 * t.header.spacing_m[0],
                 z0 = places.y0 * t.header.spacing_m[1], z1 = places.y1 * t.header.spacing_m[1];
    const double dx = std::max({x0 - view.eye_m.x, view.eye_m.x - x1, 0.0}),
                 dz = std::max({z0 - view.eye_m.z, view.eye_m.z - z1, 0.0});
    return dx * dx + dz * dz;
}

// Which stamp comes next: the nearest to a view whose pages are there and that no earlier one overlaps. no_index: none.
constexpr std::uint32_t looked_ahead = 64;
std::uint32_t next_stamp(EditsData& e, std::span<const View> views) {
    std::uint32_t best = no_index;
    double nearest = 1e300;
    const std::uint32_t count = std::min(e.waiting_count, looked_ahead);
    for (std::uint32_t i = 0; i < count; ++i)
        if (e.waiting[i].fits) { // with the room that there is now: it comes to its end first
            e.waiting[i].held = is_held(e, e.waiting[i]);
            return e.waiting[i].held ? no_index : i;
        }
    for (std::uint32_t i = 0; i < count; ++i) {
        Waiting& w = e.waiting[i];
        bool behind = false;
        for (std::uint32_t k = 0; k < i && !behind; ++k) behind = e.waiting[k].places.grown(1).meets(w.places);
        for (std::uint32_t k = 0; k < e.moving_count && !behind; ++k)
            behind = e.moving[k].stamp.places.grown(1).meets(w.places);
        if (behind) continue;
        w.held = is_held(e, w);
        if ((w.lacks_pages || w.wants_rest) && !std::exchange(w.awaits, true)) ++e.awaiting_count, ++e.awaits_changes;
        if (w.held) continue;
        double away = 1e200;
        for (const View& view : views) away = std::min(away, distance_m(*e.terrain, w.places, view));
        if (away < nearest) nearest = away, best = i;
    }
    return best;
}

// It is applied, or refused.
void finish(EditsData& e, StampId id, Refusal refusal, EditReport& report) {
    const bool refused = refusal != Refusal::none;
    const std::uint32_t spent = refusal == Refusal::blocks  ? +edit_budget_blocks
                                : refusal == Refusal::paint ? +edit_budget_paint
                                : refusal == Refusal::locks ? +edit_budget_locks
                                                            : 0;
    set_result(e, id, refused ? StampState::refused : StampState::applied,
               !refused                      ? StatusCode::ok
               : spent != 0                  ? StatusCode::out_of_slots
               : refusal == Refusal::no_maps ? StatusCode::not_supported
                                             : StatusCode::out_of_range,
               static_cast<std::uint32_t>(refusal));
    ++(refused ? report.refused : report.applied);
    report.exhausted |= spent;
}

// Each that is on its way takes a step.
void move_stamps(EditsData& e, double now_s, Budgeted& budget, EditReport& report) {
    for (std::uint32_t i = 0; i < e.moving_count && budget.may_go_on();) {
        Refusal refusal = Refusal::none;
        if (!move_on(e, e.moving[i], now_s, refusal, report.samples)) {
            ++i;
            continue;
        }
        finish(e, e.moving[i].stamp.id, refusal, report);
        --e.awaiting_count, ++e.awaits_changes;
        std::copy(e.moving + i + 1, e.moving + e.moving_count, e.moving + i);
        --e.moving_count;
    }
}

void apply_stamps(EditsData& e, std::span<const View> views, double now_s, Budgeted& budget, EditReport& report) {
    take_stamps(e);
    while (e.waiting_count != 0) {
        const std::uint32_t i = next_stamp(e, views);
        if (i == no_index || !budget.may_go_on()) return;
        const StampId id = e.waiting[i].id;
        Refusal refusal = Refusal::none;
        Waiting& w = e.waiting[i];
        const bool done = paints(w.stamp.shape)  ? paint_piece(e, w, refusal)
                          : locks(w.stamp.shape) ? lock_piece(e, w, refusal)
                                                 : apply_piece(e, w, now_s, refusal, report.samples);
        if (!done) continue;
        const bool moves = e.waiting[i].moves;
        if (moves)
            set_result(e, id, StampState::moving);
        else
            finish(e, id, refusal, report);
        if (e.waiting[i].awaits && !moves) --e.awaiting_count, ++e.awaits_changes;
        std::copy(e.waiting + i + 1, e.waiting + e.waiting_count, e.waiting + i);
        --e.waiting_count;
        take_stamps(e);
    }
}

} // namespace

Status update_edits(const Edits& edits, std::span<const View> views, const EditSettings& settings, EditReport& report) {
    EditsData* const found = find_edits(edits);
    if (found == nullptr) return no_edits;
    EditsData& e = *found;
    for (const View& view : views)
        if (Status s = validate(view); !s.ok()) return s;
    report = {};
    Budgeted budget(settings, report);
    bool moved = false;
    do {
        const auto started = Clock::now();
        if (!std::exchange(moved, true)) move_stamps(e, settings.now_s, budget, report);
        apply_stamps(e, views, settings.now_s, budget, report);
        const auto applied = Clock::now();
        retry_unmeasured(e);
        while (has_area_to_measure(e) && budget.may_go_on()) measure_next(e);
        flush_measured(e);
        report.apply_us += microseconds(started, applied);
        report.measure_us += microseconds(applied, Clock::now());
        // What has been measured may be what a stamp has waited for.
    } while ((report.exhausted & (edit_budget_work | edit_budget_time)) == 0 && next_stamp(e, views) != no_index);
    report.waiting = e.waiting_count;
    report.moving = e.moving_count;
    for (std::uint32_t i = 0; i < e.waiting_count; ++i) report.held += e.waiting[i].held;
    for (std::uint32_t i = 0; i < e.area_count; ++i) ++(e.areas[i].unmeasured ? report.unmeasured : report.loose);
    report.blocks = e.block_count;
    report.paint = e.paint != nullptr ? e.paint->count : 0;
    report.locks = e.lock_count;
    return {};
}

namespace {

// Of those under a triangle: a vertex with such an error has ancestors with such errors. It is counted in the first
// triangle of its diamond.
std::uint32_t count_below(const TerrainData& t, SampleIndex right, SampleIndex one, SampleIndex other) {
    const SampleIndex sum = one + other;
    if (((sum.column | sum.row) & 1) != 0) return 0;
    const SampleIndex m{sum.column / 2, sum.row / 2};
    const Cell cell = cell_at(t, m);
    if (!cell.loaded || cell.error < t.errors.always(t.tree.level(m))) return 0;
    const SampleIndex first = diamond(t.tree, m).apexes[0];
    return (first == right || !t.tree.contains(first) ? 1 : 0) + count_below(t, m, right, one) +
           count_below(t, m, other, right);
}

} // namespace

std::uint32_t count_always_drawn(const Edits& edits) {
    const EditsData* const e = find_edits(edits);
    if (e == nullptr) return 0;
    const TerrainData& t = *e->terrain;
    std::uint32_t count = 0;
    for (std::uint32_t tile = 0; tile < t.tile_count(); ++tile) {
        const SampleIndex place = t.tile_xy(tile);
        const std::int32_t side = t.tree.side();
        const Diamond root = diamond(t.tree, {place.column * side + side / 2, place.row * side + side / 2});
        for (const SampleIndex apex : root.apexes) count += count_below(t, apex, root.ends[0], root.ends[1]);
    }
    return count;
}

std::uint32_t take_ground_changes(const Edits& edits, std::uint64_t& cursor, std::span<GroundRect> rects, bool& lost) {
    lost = false;
    const EditsData* const e = find_edits(edits);
    if (e == nullptr || rects.empty()) return 0;
    const TerrainData& t = *e->terrain;
    if (cursor > t.ground_changes || t.ground_changes - cursor > ground_change_log) {
        lost = true;
        cursor = t.ground_changes;
        rects[0] = {{0, 0}, {t.tree.columns() - 1, t.tree.rows() - 1}};
        return 1;
    }
    std::uint32_t count = 0;
    for (; cursor < t.ground_changes && count < rects.size(); ++cursor) {
        const GroundChange& change = e->changes[cursor % ground_change_log];
        if (change.step_log2 == heights_changed)
            rects[count++] = {t.tree.sample(change.first), t.tree.sample(change.last)};
    }
    return count;
}

} // namespace fjell
