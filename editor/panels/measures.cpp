#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_time(const State& state, Commands&) {
    const Quantiles q = state.measures.ring(Series::update_us).quantiles();
    ui::row("Update", "p50 %.0f  p99 %.0f  max %.0f us", static_cast<double>(q.p50), static_cast<double>(q.p99),
            static_cast<double>(q.max));
}

void draw_budgets(const State&, Commands&) {}
void draw_streaming(const State&, Commands&) {}
void draw_levels(const State&, Commands&) {}

} // namespace fjell::editor
