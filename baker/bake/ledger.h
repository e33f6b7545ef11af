// How far a bake has come, in a file of its work folder, so that the same bake goes on from there after an interruption
// or a kill. Not after a restart of the machine: then nobody knows which of the files' bytes had reached the disk.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "baker/heights/survey.h"
#include "baker/read/source.h"

namespace fjell::baker {

// All of it is stored. done: units of the stage that are complete, from its first on.
struct LedgerState {
    std::uint32_t stage = 0;
    std::uint32_t holes = 0; // 1: samples without height stay holes
    std::uint64_t done = 0;
    std::uint64_t spool_bytes = 0;
    Census census;
    Survey survey;
    double native_quantum_m = 0, anchor_m = 0;
    float max_error_m = 0;
    std::uint32_t has_voids = 0; // 1: the source has samples without height
};

class Ledger {
public:
    // path: in the work folder. identity: of all that the pack's bytes depend on. An earlier run's state is taken over
    // when it is of the same identity, program and start of the machine.
    Ledger(std::string path, const std::string& identity);
    [[nodiscard]] bool resumed() const { return resumed_; }
    LedgerState state;
    void write(); // replaces the file; throws Failure (3)

private:
    struct Stored;
    [[nodiscard]] Stored pack() const;
    std::string path_;
    std::array<std::uint64_t, 2> identity_;
    bool resumed_ = false;
};

} // namespace fjell::baker
