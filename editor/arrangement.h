// How the window is divided between panels and picture: remembered between runs (editor/files/settings.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "editor/names.h"

namespace fjell::editor {

// Pixels are those of a scale of 1.
struct Arrangement {
    bool panels = true; // shown at all
    std::array<bool, columns> folded{};
    std::array<float, columns> width_px{325, 325};
    std::array<float, columns> split{0.6F, 0.55F}; // the upper section's share of a column that stacks two
    std::array<Panel, editor::panels> latest;      // the one that was turned to last comes first

    Arrangement() {
        for (std::size_t i = 0; i < latest.size(); ++i) latest[i] = static_cast<Panel>(i);
    }
    friend bool operator==(const Arrangement&, const Arrangement&) = default;

    void turn_to(Panel panel) {
        const auto at = std::find(latest.begin(), latest.end(), panel);
        std::rotate(latest.begin(), at, at + 1);
    }
    // Of these groups (a bit each) the panel that was turned to last.
    [[nodiscard]] Panel shown(unsigned groups) const {
        for (const Panel panel : latest)
            if ((groups & group_bit(panel)) != 0) return panel;
        return latest.front();
    }
};
inline constexpr float least_column_px = 220, most_column_px = 800;
inline constexpr float least_split = 0.15F, most_split = 0.85F;

} // namespace fjell::editor
