// What the measuring panels draw: graphs over the last frames, and bars.
//
// Thread: the frame's, inside a window. Memory: none; complexity O(values), at most measured_frames a line.
#pragma once

#include <initializer_list>
#include <span>

#include "editor/measures.h"
#include "editor/panels/ui.h"

namespace fjell::editor::ui {

inline constexpr std::size_t no_frame = ~std::size_t{0};

struct GraphLine {
    const Ring* values = nullptr;
    ImU32 colour = 0;
    const char* label = "";
    float factor = 1; // from the ring's unit to the graph's; below 0: downwards from the middle
    bool filled = false;
};
struct Graph {
    const char* name = ""; // of its mark, and its id
    const char* unit = "";
    double height_em = 6; // in text heights
    double budget = 0;    // a line across, in the graph's unit; 0: none
    const char* budget_label = "";
    bool logarithmic = false;      // values below 1e-3 count as that
    std::size_t chosen = no_frame; // frames ago: marked
    GraphSpan shown{};
};
// What the mouse does with a graph, in frames ago.
struct GraphInput {
    std::size_t clicked = no_frame;
    bool drags = false, released = false;             // over some frames: held, and let go
    std::size_t oldest = no_frame, newest = no_frame; // of those
};
// Over the column's width: lines from the oldest frame on the left to the newest, gridlines with numbers, the budget's
// line, a legend, and what the frame under the mouse had. The scale reaches to what is usual, or if not all frames are
// shown to the most of those; what is above has a mark at the top.
GraphInput graph(const Graph& graph, std::initializer_list<GraphLine> lines);

// The next round number of 1, 2 and 5 times a power of ten that is not below value; 1 for 0 and less.
[[nodiscard]] double round_up(double value);
// "12.3 M", "4,096", "0.25": up to 7 characters.
void short_number(char (&text)[16], double value);

// A bar over the column's width under a line "label   value": share 0..1 of it full, mark 0..1 a notch (the peak;
// below 0: none).
void bar(const char* label, const char* value, double share, double mark, ImU32 colour);
// Parts of a whole beside each other over the column's width, which stands for the sum; the legend below says how much
// each is, in milliseconds.
struct Share {
    const char* label = "";
    double us = 0;
    ImU32 colour = 0;
    const char* about = "";
};
void stacked_bar(const char* name, std::span<const Share> shares);
// A square of that colour, for legends, in the line of the text that follows.
void swatch(ImU32 colour);

} // namespace fjell::editor::ui
