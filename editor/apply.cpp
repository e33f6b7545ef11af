#include "editor/apply.h"

#include <exception>
#include <new>
#include <utility>

#include "editor/carry_out.h"
#include "host/failure.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_messages = 200;
constexpr double shown_s = 8;

} // namespace

void tell(State& state, Severity severity, std::string text) {
    auto& all = state.messages.all;
    if (!all.empty() && all.back().text == text) {
        ++all.back().times;
        all.back().at_s = state.now_s;
    } else {
        all.push_back({severity, std::move(text), state.now_s});
        if (all.size() > most_messages) all.pop_front();
    }
    state.messages.shown_until_s = state.now_s + shown_s;
}

void apply(const Command& command, Desk desk) {
    try {
        std::visit([&](const auto& c) { carry_out(c, desk); }, command);
    } catch (const std::bad_alloc&) {
        tell(desk.state, Severity::error, "memory is short; choose smaller budgets, or a smaller terrain");
    } catch (const std::exception& failure) {
        tell(desk.state, Severity::error, failure.what());
    }
}

void follow_document(Desk desk) {
    State& state = desk.state;
    if (!desk.engine.is_open() || state.document.dragging()) return;
    try {
        const bool anew = desk.engine.follow(state.document.profile());
        state.document.accept();
        if (!anew) return;
        state.scene = desk.engine.scene();
        state.measures.clear();
    } catch (const std::exception& failure) {
        const bool memory = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr;
        state.document.revert();
        state.scene = desk.engine.scene(); // closed when what was before cannot be had any more either
        tell(state, Severity::error,
             std::string("not possible, and taken back: ") + (memory ? "memory is short" : failure.what()));
    }
}

} // namespace fjell::editor
