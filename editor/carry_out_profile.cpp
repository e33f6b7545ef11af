#include "editor/carry_out.h"

namespace fjell::editor {

void carry_out(const Open& c, Desk desk) {
    desk.engine.open(c.path, desk.state.document.profile());
    look_at_scene(desk);
}

void carry_out(const OpenSample&, Desk) {}

void carry_out(const SetKey& c, Desk desk) {
    desk.state.document.set(*c.key, c.value, c.dragging);
}

void carry_out(const Undo&, Desk desk) {
    desk.state.document.undo();
}

void carry_out(const Redo&, Desk desk) {
    desk.state.document.redo();
}

void carry_out(const DefaultProfile&, Desk desk) {
    desk.state.document.replace({});
}

void carry_out(const OpenProfile& c, Desk desk) {
    desk.state.document.open(c.path);
}

void carry_out(const SaveProfile& c, Desk desk) {
    desk.state.document.save(c.path);
}

void carry_out(const CompareProfile& c, Desk desk) {
    desk.state.document.compare(c.path);
}

} // namespace fjell::editor
