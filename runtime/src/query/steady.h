// Answers while the frame's thread edits the ground (fjell/edit.h).
#pragma once

#include "shared/compiler.h"
#include "shared/terrain_data.h"

namespace fjell::query {

// answer() of ground that stands still. Where it has moved at each attempt, what was read mixes heights of before and
// after; those differ by TerrainData::editing_m at most, which is added to the error. Never waits.
template <typename Answer>
[[nodiscard]] auto steady(const TerrainData& t, const Answer& answer) {
    constexpr int attempts = 3;
    for (int attempt = 1;; ++attempt) {
        const std::uint32_t before = load_acquire(t.ground_epoch);
        auto result = answer();
        fence_acquire();
        if (before % 2 == 0 && load_relaxed(t.ground_epoch) == before) return result;
        if (attempt < attempts) continue;
        result.error_m += load_relaxed(t.editing_m);
        return result;
    }
}

} // namespace fjell::query
