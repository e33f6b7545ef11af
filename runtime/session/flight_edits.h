// The moving ground of a flight: stamps that are pushed frame by frame, before the frame's pages and mesh are updated.
//
// Ownership: owns the edits, their memory and the stamps. The terrains must outlive it. Thread: the flight's.
// Failure: io::Failure, 1 for a terrain or a budget that takes no edits, 3 when memory is short.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fjell/edit.h"
#include "fjell/io/load.h"
#include "io/stamps.h"

namespace fjell::session {

// What was done so far, over all updates.
struct EditTotals {
    std::uint32_t applied = 0, refused = 0;
    std::uint64_t samples = 0;
    std::uint32_t exhausted = 0;                // EditBudgetBits
    double apply_us = 0, measure_us = 0;        // sums
    double apply_us_max = 0, update_us_max = 0; // of one update
    EditReport last;                            // waiting, held, loose, unmeasured and blocks at the end
    std::string first_refusal;                  // "stamp 3: EditBudget::blocks: why"; empty: none
};

class FlightEdits {
public:
    // stamps: by frame, as io::parse_stamps() returns them.
    FlightEdits(const Terrain& terrain, const EditBudget& budget, std::vector<io::TimedStamp> stamps);
    ~FlightEdits();
    FlightEdits(const FlightEdits&) = delete;
    FlightEdits& operator=(const FlightEdits&) = delete;

    // A second terrain that takes each stamp once the first one has: for measuring against, whole and at rest.
    void mirror(const Terrain& terrain);

    // One more, due at once; after those that wait.
    void push(io::KeptStamp stamp);
    // What an update may take; 0: as long as it does.
    void limit_us(std::uint32_t most) { settings_.max_time_us = most; }
    // What has been refused since the last call: "EditBudget::blocks: why", by whatever stamp. Empty: nothing.
    [[nodiscard]] std::string take_refusal() { return std::exchange(refusal_, {}); }
    // Stamps that are not applied yet, pushed or not.
    [[nodiscard]] std::size_t waiting() const { return stamps_.size() - next_ + open_.size(); }

    // The stamps of this frame, and of all before it, are due.
    void begin_frame(std::size_t frame) { frame_ = frame; }
    // Pushes what is due, as far as the queue has room, and applies what can be. An update of the stream and of the
    // mesh follows. Returns the stamps that it has pushed.
    std::span<const io::TimedStamp> update(std::span<const View> views, double now_s);

    [[nodiscard]] const EditTotals& totals() const { return totals_; }
    [[nodiscard]] const EditBudget& budget() const { return budget_; }
    [[nodiscard]] Edits edits() const { return live_.edits; }
    [[nodiscard]] std::size_t stamps() const { return stamps_.size(); }
    [[nodiscard]] std::size_t bytes() const { return live_.bytes; }

private:
    struct Place { // a terrain's edits
        std::size_t bytes = 0;
        io::AlignedMemory memory;
        Edits edits;
    };
    struct Open { // pushed, and neither applied nor refused yet
        StampId id;
        std::size_t stamp;
        bool mirrored = false; // the second terrain has it
    };
    void create(const Terrain& terrain, Place& place) const;
    void push_due();
    void settle(const Open& open, const StampResult& result);
    void update_mirror(double now_s);

    EditBudget budget_;
    std::vector<io::TimedStamp> stamps_;
    std::size_t frame_ = 0, next_ = 0; // of stamps_
    Place live_, mirror_;
    std::vector<Open> open_;
    EditTotals totals_;
    std::string refusal_;
    EditSettings settings_;
};

} // namespace fjell::session
