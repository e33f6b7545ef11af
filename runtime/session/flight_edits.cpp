#include "session/flight_edits.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::session {

namespace {

void require_edit(const Status& status) {
    if (!status.ok()) throw io::Failure(1, fmt::format("edits: {}: {}", status.field, message(status.code)));
}

} // namespace

FlightEdits::FlightEdits(const Terrain& terrain, const EditBudget& budget, std::vector<io::TimedStamp> stamps)
    : budget_(budget), stamps_(std::move(stamps)) {
    const bool holes = std::ranges::any_of(stamps_, [](const io::TimedStamp& stamp) {
        const StampShape shape = stamp.what.plain.shape;
        return shape == StampShape::hole || shape == StampShape::fill;
    });
    budget_.holes = budget_.holes || holes;
    create(terrain, live_);
}

FlightEdits::~FlightEdits() {
    (void)destroy_edits(live_.edits);
    (void)destroy_edits(mirror_.edits);
}

void FlightEdits::create(const Terrain& terrain, Place& place) const {
    place.bytes = edits_bytes(terrain.header(), budget_);
    place.memory = io::allocate(place.bytes);
    require_edit(create_edits(terrain, budget_, {place.memory.get(), place.bytes}, place.edits));
}

void FlightEdits::mirror(const Terrain& terrain) {
    create(terrain, mirror_);
}

void FlightEdits::push(io::KeptStamp stamp) {
    stamps_.push_back({frame_, std::move(stamp)});
}

void FlightEdits::settle(const Open& open, const StampResult& result) {
    if (result.state == StampState::refused) {
        refusal_ = fmt::format("{}: {}", result.status.field, message(result.status.code));
        if (totals_.first_refusal.empty()) totals_.first_refusal = fmt::format("stamp {}: {}", open.stamp, refusal_);
    }
}

// Stamps that the first terrain has taken, or has begun to move: both move by one clock.
void FlightEdits::update_mirror(double now_s) {
    if (!mirror_.memory) return;
    EditReport report;
    require_edit(update_edits(mirror_.edits, {}, {.now_s = now_s}, report)); // what has moved before goes on
    for (Open& open : open_) {
        const StampState state = stamp_state(live_.edits, open.id).state;
        if (open.mirrored || state == StampState::waiting || state == StampState::refused) continue;
        StampId id = 0;
        require_edit(push_stamp(mirror_.edits, stamps_[open.stamp].what.stamp(), id));
        require_edit(update_edits(mirror_.edits, {}, {.now_s = now_s}, report));
        require_edit(stamp_state(mirror_.edits, id).status);
        open.mirrored = true;
    }
}

// Those that the queue has room for.
void FlightEdits::push_due() {
    for (; next_ < stamps_.size() && stamps_[next_].frame <= frame_; ++next_) {
        StampId id = 0;
        const Status pushed = push_stamp(live_.edits, stamps_[next_].what.stamp(), id);
        if (pushed.code == StatusCode::out_of_slots) return;
        if (pushed.code == StatusCode::out_of_range) { // a hole, on a pack that has no room for it
            settle({0, next_}, {StampState::refused, pushed});
            ++totals_.refused;
            continue;
        }
        require_edit(pushed);
        open_.push_back({id, next_});
    }
}

std::span<const io::TimedStamp> FlightEdits::update(std::span<const View> views, double now_s) {
    const std::size_t first = next_;
    EditReport report;
    settings_.now_s = now_s;
    // Without a limit all of a frame's come in it, however many queues they fill.
    do {
        push_due();
        require_edit(update_edits(live_.edits, views, settings_, report));
        update_mirror(now_s);
        // In the order of pushing, in which those that overlap were applied.
        std::erase_if(open_, [&](const Open& open) {
            const StampResult result = stamp_state(live_.edits, open.id);
            if (result.state == StampState::waiting || result.state == StampState::moving) return false;
            settle(open, result);
            stamps_[open.stamp].what.heights_m = {}; // large, and nobody's any more
            return true;
        });
        totals_.applied += report.applied;
        totals_.refused += report.refused;
        totals_.samples += report.samples;
        totals_.exhausted |= report.exhausted;
        totals_.apply_us += report.apply_us;
        totals_.measure_us += report.measure_us;
        totals_.apply_us_max = std::max(totals_.apply_us_max, report.apply_us);
        totals_.update_us_max = std::max(totals_.update_us_max, report.apply_us + report.measure_us);
    } while (settings_.max_time_us == 0 && report.applied + report.refused != 0 && next_ < stamps_.size() &&
             stamps_[next_].frame <= frame_);
    totals_.last = report;
    return std::span(stamps_).subspan(first, next_ - first);
}

} // namespace fjell::session
