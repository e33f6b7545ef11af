#include "editor/handlers/apply.h"

#include <cstdio>
#include <exception>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "editor/handlers/handlers.h"
#include "io/failure.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_messages = 200;
constexpr double shown_s = 8;

} // namespace

void tell(State& state, Severity severity, std::string text) {
    if (state.headless && severity == Severity::note) fmt::print("{}\n", text);
    if (state.headless && severity != Severity::note) fmt::print(stderr, "fjell-editor: {}\n", text);
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

void tell_failure(State& state, const std::exception& failure, const std::string& before) {
    const auto* const own = dynamic_cast<const io::Failure*>(&failure);
    const bool memory = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr;
    if (state.exit_code == 0) state.exit_code = own != nullptr ? own->exit_code : 3;
    tell(state, Severity::error,
         before + (memory ? "memory is short; choose smaller budgets, or a smaller terrain" : failure.what()));
}

void apply(const Command& command, Desk desk) {
    try {
        std::visit([&](const auto& c) { carry_out(c, desk); }, command);
    } catch (const std::exception& failure) {
        tell_failure(desk.state, failure);
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
        state.document.revert();
        state.scene = desk.engine.scene(); // closed when what was before cannot be had any more either
        tell_failure(state, failure, "not possible, and taken back: ");
    }
}

} // namespace fjell::editor
