// Which stages of a bake are complete and what they found out, in a file of its work folder, so that the same bake goes
// on from there after an interruption or a kill. Not after a restart of the machine: then nobody knows which of the
// files' bytes had reached the disk.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "baker/heights/statistics.h"
#include "baker/maps/maps.h"
#include "baker/pack/chunk_spool.h"
#include "baker/read/source.h"
#include "baker/store/store.h"

namespace fjell::baker {

// In the order in which they run; far_mips and coarser_steps in parts, one for each mip and step.
enum class Stage : std::uint32_t {
    read,
    fill,
    measure,
    near_maps,
    levels,
    near_horizons,
    near_splat,
    far_mips,
    finest_step,
    coarser_steps,
    mixed_pages
};

struct StageId {
    Stage stage;
    int part = 0; // 0..99
    [[nodiscard]] constexpr std::uint32_t number() const {
        return static_cast<std::uint32_t>(stage) * 100 + static_cast<std::uint32_t>(part);
    }
};

// What complete stages have left in stores that others read.
struct StoreDigests {
    Digest heights, filled, holes; // read, fill
    Digest texels[map_kind_count]; // of the last mip of a kind: near_*, far_mips
    Digest levels;
    Digest unsaturated, unsaturated_south, unsaturated_east; // finest_step
    Digest places, centres;                                  // of the last step
    Digest mixed_records, mixed_heights;                     // of all steps so far
};

// All of it is stored. What is measured by a stage holds once that one is complete.
struct CheckpointState {
    // What a source that has been read is like; voids: it has samples without height.
    void note_source(const SourceProperties& source, bool voids);

    std::uint32_t complete = 0;                // all stages of a smaller number are
    std::uint32_t has_voids = 0;               // read: 1: the source has samples without height
    std::uint32_t holes = 0;                   // read: 1: those stay holes
    float max_error_m = 0;                     // mixed_pages
    float ground_error_m = 0;                  // finest_step
    std::uint64_t always_drawn = 0;            // finest_step, coarser_steps
    std::uint32_t on_scale = 0;                // finest_step: 1: BakeSummary::on_scale
    double native_quantum_m = 0, anchor_m = 0; // read: see SourceProperties
    RepeatedHeight lowest, highest;            // read: see SourceProperties
    HeightStatistics heights;                  // measure
    SpoolState spool;                          // chunks of complete stages
    StoreDigests stores;
};

class Checkpoint {
public:
    // path: in the work folder; empty: nothing is stored. identity: of all that the pack's bytes depend on. An earlier
    // run's state is taken over when it is of the same identity, program and start of the machine.
    Checkpoint(std::string path, const std::string& identity);
    [[nodiscard]] bool resumed() const { return resumed_; }
    [[nodiscard]] bool complete(StageId id) const { return state.complete > id.number(); }
    void set_complete(StageId id); // and writes
    void write();                  // replaces the file; throws Failure (3)
    CheckpointState state;

private:
    struct Stored;
    [[nodiscard]] Stored stored() const;
    std::string path_;
    std::array<std::uint64_t, 2> identity_;
    bool resumed_ = false;
};

} // namespace fjell::baker
