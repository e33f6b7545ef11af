#include <algorithm>

#include "editor/handlers/handlers.h"

namespace fjell::editor {

void carry_out(const SetMode& c, Desk desk) {
    desk.state.interface.mode = c.mode;
}

void carry_out(const SetOverlay& c, Desk desk) {
    desk.state.interface.overlay[static_cast<std::size_t>(c.overlay)] = c.on;
}

void carry_out(const ShowPanel& c, Desk desk) {
    Interface& i = desk.state.interface;
    (static_cast<int>(c.panel) >= left_panels ? i.right : i.left) = c.panel;
    i.newest = c.panel;
}

void carry_out(const ShowDialog& c, Desk desk) {
    State& state = desk.state;
    dialog_opens(c.dialog, state);
    const bool leaves_nothing = c.dialog == Dialog::none && !state.scene.open();
    state.interface.dialog = leaves_nothing && state.interface.dialog != Dialog::start ? Dialog::start : c.dialog;
}

void carry_out(const SetScale& c, Desk desk) {
    desk.state.interface.scale = std::clamp(c.scale, 0.5, 4.0);
}

void carry_out(const DismissMessage&, Desk desk) {
    desk.state.messages.shown_until_s = 0;
}

void carry_out(const Quit& c, Desk desk) {
    if (!c.discard) end_recording(desk);
    if (!c.discard && asks_first(Quit{true}, desk)) return;
    desk.state.quit = true;
}

} // namespace fjell::editor
