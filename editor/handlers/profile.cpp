#include <algorithm>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "io/file.h"

namespace fjell::editor {

void carry_out(const SetKey& c, Desk desk) {
    Document& document = desk.state.document;
    document.set(*c.key, c.value, c.dragging);
    if (c.dragging || (c.value >= c.key->least && c.value <= c.key->most)) return;
    tell(desk.state, Severity::warning,
         fmt::format("{}: {}; {} was taken", c.key->label, flight::key_refusal(*c.key),
                     flight::value_text(*c.key, document.profile())));
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
    if (!c.discard && asks_first(OpenProfile{c.path, true}, desk)) return;
    State& state = desk.state;
    state.document.open(c.path);
    if (state.interface.dialog == Dialog::open_file) state.interface.dialog = Dialog::none;
    tell(state, Severity::note, "opened " + c.path);
}

void carry_out(const SaveProfile& c, Desk desk) {
    State& state = desk.state;
    io::refuse_overwriting({c.path}, {state.scene.path});
    state.document.save(c.path);
    if (state.interface.dialog == Dialog::save_profile) state.interface.dialog = Dialog::none;
    tell(state, Severity::note, "saved " + state.document.path());
    go_on_saving(desk);
}

void carry_out(const CompareProfile& c, Desk desk) {
    desk.state.document.compare(c.path);
}

void carry_out(const StopComparing&, Desk desk) {
    desk.state.document.stop_comparing();
}

} // namespace fjell::editor
