// What is shown: picture mode, overlays, panels, dialogs and messages.
#include <algorithm>
#include <filesystem>
#include <string>

#include "editor/handlers/handlers.h"

namespace fjell::editor {

namespace {

void prepare_dialog(Dialog dialog, State& state) {
    Files& files = state.files;
    if (dialog != Dialog::unsaved && dialog != Dialog::save_profile && dialog != Dialog::save_path) {
        files.waiting.reset();
        files.saving = false;
    }
    if (!shows_files(dialog)) return;
    std::string folder = files.browser.folder();
    if (folder.empty()) folder = files.settings.folder.empty() ? "." : files.settings.folder;
    const std::string& own = dialog == Dialog::save_path ? state.route.path() : state.document.path();
    if (dialog != Dialog::open_file && !own.empty()) folder = std::filesystem::absolute(own).parent_path().string();
    files.browser.filter(dialog, false);
    files.browser.look(folder);
}

} // namespace

void handle(const SetPictureMode& c, HandlerContext context) {
    context.state.interface.mode = c.mode;
}

void handle(const SetOverlay& c, HandlerContext context) {
    context.state.interface.overlay[static_cast<std::size_t>(c.overlay)] = c.on;
}

void handle(const ShowPanel& c, HandlerContext context) {
    Interface& i = context.state.interface;
    (static_cast<int>(c.panel) >= left_panels ? i.right : i.left) = c.panel;
    i.newest = c.panel;
}

void handle(const ShowDialog& c, HandlerContext context) {
    State& state = context.state;
    prepare_dialog(c.dialog, state);
    const bool leaves_nothing = c.dialog == Dialog::none && !state.scene.open();
    state.interface.dialog = leaves_nothing && state.interface.dialog != Dialog::start ? Dialog::start : c.dialog;
}

void handle(const SetScale& c, HandlerContext context) {
    context.state.interface.scale = std::clamp(c.scale, 0.5, 4.0);
}

void handle(const DismissMessage&, HandlerContext context) {
    context.state.messages.shown_until_s = 0;
}

} // namespace fjell::editor
