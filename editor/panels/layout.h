// Where panels, splitters and picture are in a window of that size.
//
// A window that is wide enough has two columns, so that the picture keeps two thirds of it; a narrower one has one, and
// a tall one stacks two sections in a column. Thread: the frame's. Memory: none.
#pragma once

#include "editor/panels/ui.h"

namespace fjell::editor::ui {

struct Section {
    Rect rect;
    unsigned groups = 0; // group_bit() of the panels that it may show
};
struct ColumnLayout {
    bool there = false;
    bool folded = false;
    Rect strip; // beside the picture: drags the width, and a click folds
    Rect split; // between two sections
    int sections = 0;
    Section section[2];
};
struct Layout {
    float menu_height = 0, status_height = 0; // 0: they are hidden
    ColumnLayout column[columns];
    Rect view;
};
[[nodiscard]] Layout layout(float width, float height, const Interface& interface);

} // namespace fjell::editor::ui
