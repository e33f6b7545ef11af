// How the window is divided between panels and picture: remembered between runs (editor/files/settings.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "editor/names.h"

namespace fjell::editor {

// A panel that floats over the picture instead of standing in a column. Pixels as below, from the window's corner.
struct FloatingPanel {
    bool on = false;
    float x_px = 0, y_px = 0, width_px = 360, height_px = 440; // the place is kept while it is docked
    friend bool operator==(const FloatingPanel&, const FloatingPanel&) = default;
};

// Pixels are those of a scale of 1.
struct Arrangement {
    bool panels = true; // shown at all
    std::array<bool, columns> folded{};
    std::array<float, columns> width_px{325, 325};
    std::array<float, columns> split{0.6F, 0.55F}; // the upper section's share of a column that stacks two
    std::array<Panel, editor::panels> latest;      // the one that was turned to last comes first
    std::array<FloatingPanel, editor::panels> floating{};

    Arrangement() {
        for (std::size_t i = 0; i < latest.size(); ++i) latest[i] = static_cast<Panel>(i);
    }
    friend bool operator==(const Arrangement&, const Arrangement&) = default;

    void turn_to(Panel panel) {
        const auto at = std::find(latest.begin(), latest.end(), panel);
        std::rotate(latest.begin(), at, at + 1);
    }
    [[nodiscard]] bool floats(Panel panel) const { return floating[static_cast<std::size_t>(panel)].on; }
    // Of these groups (a bit each) the panel that was turned to last, of those that stand in a column.
    [[nodiscard]] Panel shown(unsigned groups) const {
        for (const Panel panel : latest)
            if ((groups & group_bit(panel)) != 0 && !floats(panel)) return panel;
        return latest.front();
    }
    // Those of these groups that have a panel in a column.
    [[nodiscard]] unsigned docked(unsigned groups) const {
        unsigned some = 0;
        for (const Panel panel : latest)
            if (!floats(panel)) some |= groups & group_bit(panel);
        return some;
    }
};
inline constexpr float least_column_px = 220, most_column_px = 800;
inline constexpr float least_floating_px = 180, most_floating_px = 4000;
inline constexpr float least_split = 0.15F, most_split = 0.85F;

} // namespace fjell::editor
