#include "editor/handlers/apply.h"

#include <exception>

#include "editor/handlers/handlers.h"

namespace fjell::editor {

void apply(const Command& command, HandlerContext context) {
    try {
        std::visit([&](const auto& c) { handle(c, context); }, command);
    } catch (const std::exception& failure) {
        post_failure(context.state, failure);
    }
}

void follow_document(HandlerContext context) {
    State& state = context.state;
    if (!context.engine.is_open() || state.document.dragging()) return;
    try {
        const bool rebuilt = context.engine.follow(state.document.profile());
        state.document.accept();
        if (!rebuilt) return;
        state.scene = context.engine.scene();
        state.measures.clear();
        state.chosen.reset();
    } catch (const std::exception& failure) {
        state.document.revert();
        state.scene = context.engine.scene(); // closed when what was before cannot be had any more either
        post_failure(state, failure, "the change was reverted: ");
    }
}

} // namespace fjell::editor
