#include <algorithm>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"

namespace fjell::editor {

void handle(const SetKey& c, HandlerContext context) {
    Document& document = context.state.document;
    document.set(*c.key, c.value, c.dragging);
    if (c.dragging || (c.value >= c.key->least && c.value <= c.key->most)) return;
    post_message(context.state, Severity::warning,
                 fmt::format("{}: {}; set to {}", c.key->label, flight::key_refusal(*c.key),
                             flight::value_text(*c.key, document.profile())));
}

void handle(const Undo&, HandlerContext context) {
    State& state = context.state;
    state.route.undo_stamp() > state.document.undo_stamp() ? undo_path(context) : state.document.undo();
}

void handle(const Redo&, HandlerContext context) {
    State& state = context.state;
    const std::uint64_t of_path = state.route.redo_stamp(), of_profile = state.document.redo_stamp();
    const bool path = of_path != 0 && (of_profile == 0 || of_path < of_profile);
    path ? redo_path(context) : state.document.redo();
}

void handle(const ResetProfile&, HandlerContext context) {
    context.state.document.replace({});
}

void handle(const OpenProfile& c, HandlerContext context) {
    if (!c.discard && ask_about_unsaved(OpenProfile{c.path, true}, context)) return;
    State& state = context.state;
    state.document.open(c.path);
    if (state.interface.dialog == Dialog::open_file) state.interface.dialog = Dialog::none;
    post_message(state, Severity::note, fmt::format("opened {}", c.path));
}

void handle(const SaveProfile& c, HandlerContext context) {
    State& state = context.state;
    refuse_overwriting_open_files(state, c.path, state.document.path());
    state.document.save(c.path);
    if (state.interface.dialog == Dialog::save_profile) state.interface.dialog = Dialog::none;
    post_message(state, Severity::note, fmt::format("saved {}", state.document.path()));
    continue_saving(context);
}

void handle(const CompareProfile& c, HandlerContext context) {
    context.state.document.compare(c.path);
}

void handle(const StopComparing&, HandlerContext context) {
    context.state.document.stop_comparing();
}

} // namespace fjell::editor
