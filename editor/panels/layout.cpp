#include "editor/panels/layout.h"

#include <algorithm>
#include <cmath>

namespace fjell::editor::ui {

namespace {

constexpr float strip_px = 10, folded_strip_px = 14, stacked_from_px = 860;
// Two columns, each as wide as by default, leave the picture two thirds.
constexpr float two_columns_from_px = 1880;
constexpr unsigned upper_groups = 5; // the first of the left column's, and of the right one's
constexpr float least_view_share = 0.3F;

// groups: of the panels that stand there; those that float need no room.
ColumnLayout column_at(std::size_t side, const Rect& room, unsigned groups, const Interface& i) {
    const auto s = static_cast<float>(i.scale);
    const Arrangement& a = i.arrangement;
    ColumnLayout c;
    c.there = true;
    c.folded = a.folded[side];
    const float strip = (c.folded ? folded_strip_px : strip_px) * s;
    const float width = c.folded ? 0 : room.width - strip;
    const bool left = side == 0;
    c.strip = {left ? room.x + width : room.x, room.y, strip, room.height};
    if (c.folded) return c;
    const float x = left ? room.x : room.x + strip;
    const bool both = (groups & left_groups) != 0 && (groups & right_groups) != 0;
    const unsigned upper = groups & (both ? left_groups : upper_groups);
    if (room.height < stacked_from_px * s || upper == 0 || upper == groups) {
        c.sections = 1;
        c.section[0] = {{x, room.y, width, room.height}, groups};
        return c;
    }
    c.sections = 2;
    const float gap = 0.6F * strip_px * s, above = std::floor((room.height - gap) * a.split[side]);
    c.section[0] = {{x, room.y, width, above}, upper};
    c.split = {x, room.y + above, width, gap};
    c.section[1] = {{x, room.y + above + gap, width, room.height - above - gap}, groups & ~upper};
    return c;
}

} // namespace

Layout layout(float width, float height, const Interface& i) {
    const auto s = static_cast<float>(i.scale);
    Layout l;
    if (i.picture_only) {
        l.view = {0, 0, std::max(width, 1.0F), std::max(height, 1.0F)};
        return l;
    }
    l.menu_height = ImGui::GetFrameHeight();
    l.status_height = ImGui::GetFrameHeight() + 2 * s;
    const float top = l.menu_height, rest = std::max(height - top - l.status_height, 1.0F);
    l.view = {0, top, std::max(width, 1.0F), rest};
    const Arrangement& a = i.arrangement;
    if (!a.panels) return l;
    const unsigned all = a.docked(left_groups | right_groups);
    const bool two = width >= two_columns_from_px * s && (all & left_groups) != 0 && (all & right_groups) != 0;
    const unsigned groups[columns] = {two ? all & left_groups : all, two ? all & right_groups : 0};
    const float most = (1 - least_view_share) * width / (two ? 2 : 1);
    float taken[columns] = {};
    for (std::size_t side = 0; side < columns; ++side) {
        if (groups[side] == 0) continue; // all of its panels float
        taken[side] =
            std::floor(a.folded[side] ? folded_strip_px * s : std::min(a.width_px[side] * s + strip_px * s, most));
        const Rect room{side == 0 ? 0 : width - taken[side], top, taken[side], rest};
        l.column[side] = column_at(side, room, groups[side], i);
    }
    l.view.x = taken[0];
    l.view.width = std::max(width - taken[0] - taken[1], 1.0F);
    return l;
}

} // namespace fjell::editor::ui
