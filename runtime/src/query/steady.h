// Answers while the frame's thread edits the ground (fjell/edit.h).
#pragma once

#include "shared/compiler.h"
#include "shared/terrain_data.h"

namespace fjell::query {

// answer() of ground that stands still. Where it has moved at each attempt, what was read mixes heights of before and
// after. Those of one change differ by TerrainData::editing_m at most, so the error grows by that for each change that
// ran meanwhile. Never waits.
template <typename Answer>
[[nodiscard]] auto steady(const TerrainData& t, const Answer& answer) {
    constexpr int attempts = 3;
    for (int attempt = 1;; ++attempt) {
        const std::uint32_t before = load_acquire(t.ground_epoch);
        auto result = answer();
        fence_acquire();
        const std::uint32_t after = load_relaxed(t.ground_epoch);
        if (before % 2 == 0 && after == before) return result;
        if (attempt < attempts) continue;
        const std::uint32_t changes = (after + 1) / 2 - before / 2; // an odd number is in the middle of one
        result.error_m += load_relaxed(t.editing_m) * static_cast<float>(changes);
        return result;
    }
}

} // namespace fjell::query
