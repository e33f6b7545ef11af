#include "editor/state.h"

#include <algorithm>
#include <cmath>

#include <cstdio>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

double contour_interval_m(const State& state) {
    if (state.interface.contour_m > 0) return state.interface.contour_m;
    const Scene& scene = state.scene;
    const double rough_m = std::max((scene.max_m - scene.min_m) / 20, 1e-3);
    const double power = std::pow(10.0, std::floor(std::log10(rough_m)));
    for (const double step : {1.0, 2.0, 5.0})
        if (step * power >= rough_m * (1 - 1e-9)) return step * power;
    return 10 * power;
}

namespace {

constexpr std::size_t most_messages = 200;
constexpr double shown_s = 8;

} // namespace

void refuse_overwriting_open_files(const State& state, const std::string& output, const std::string& own) {
    std::vector<std::string> inputs{state.scene.path, state.document.path(), state.route.path(), state.files.script};
    if (!own.empty()) std::erase(inputs, own);
    io::refuse_overwriting({output}, inputs);
}

const char* undo_label(const State& state) {
    if (state.ground.undo_stamp > std::max(state.route.undo_stamp(), state.document.undo_stamp())) return "ground";
    return state.route.undo_stamp() > state.document.undo_stamp() ? "camera path" : state.document.undo_label();
}

const char* redo_label(const State& state) {
    const std::uint64_t path = state.route.redo_stamp(), profile = state.document.redo_stamp();
    const auto later = [&](std::uint64_t other) { return other == 0 || state.ground.redo_stamp < other; };
    if (state.ground.redo_stamp != 0 && later(path) && later(profile)) return "ground";
    return path != 0 && (profile == 0 || path < profile) ? "camera path" : state.document.redo_label();
}

void post_message(State& state, Severity severity, std::string text) {
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

void post_failure(State& state, const std::exception& failure, const std::string& before) {
    const io::Failure own = io::as_failure(failure);
    if (state.exit_code == 0) state.exit_code = own.exit_code;
    post_message(state, Severity::error, before + own.what());
}

} // namespace fjell::editor
