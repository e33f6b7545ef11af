#include "editor/carry_out.h"

namespace fjell::editor {

void carry_out(const Bake&, Desk) {}
void carry_out(const Tune&, Desk) {}
void carry_out(const Benchmark&, Desk) {}
void carry_out(const Export&, Desk) {}
void carry_out(const PreviewExport&, Desk) {}

void carry_out(const CancelJob&, Desk desk) {
    desk.jobs.cancel();
}

void take_result(Desk) {}

} // namespace fjell::editor
