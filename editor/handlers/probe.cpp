// The probe: what is under the pointer, and the two places that are marked.
#include "editor/probe.h"

#include "editor/handlers/handlers.h"

namespace fjell::editor {

void handle(const PointProbe& c, HandlerContext context) {
    context.state.probe.pointer = std::array{c.x, c.y};
}

void handle(const MarkPlace& c, HandlerContext context) {
    set_mark(context.state.probe, open_engine(context).session(), c.x_m, c.z_m);
}

void handle(const ClearMarks&, HandlerContext context) {
    context.state.probe.marks = 0;
}

} // namespace fjell::editor
