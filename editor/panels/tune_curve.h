// What tuning found, drawn as in the thesis' figures 6.3 and 6.4: time over the threshold with the budget's line, and
// under it the vertices. ImPlot is no package of Debian 12's, so the axes are our own.
#pragma once

#include "editor/jobs/jobs.h"

namespace fjell::editor {

// Over the width of the window and that height in pixels. Hovering shows a threshold's values. Allocates nothing.
void draw_tune_curve(const JobView& job, float height);

} // namespace fjell::editor
