// One update: passes until one fits the budget. A capacity that does not suffice raises the threshold, because stopping
// half-way would crack.
#include <algorithm>

#include "recursive/pass.h"

namespace fjell {

namespace {

constexpr double step_up = 1.25, step_down = 1 / 1.05;

// Where to start: where the last frame ended, a step finer when it had room to spare.
double first_threshold(const RecursiveState& s, double requested_px) {
    if (!s.exhausted || s.effective_px <= requested_px) return requested_px;
    const bool room = s.last_selected < s.budget.vertices / 5 * 4 && s.last_indices < s.budget.indices / 5 * 4;
    return std::max(requested_px, room ? s.effective_px * step_down : s.effective_px);
}

} // namespace

Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report) {
    RecursiveState* const found = find_recursive(method);
    if (found == nullptr) return no_recursive;
    RecursiveState& s = *found;
    if (Status v = validate(view); !v.ok()) return v;
    if (!(settings.error_px >= 1e-3 && settings.error_px <= 1e6))
        return {Code::out_of_range, "RefineSettings::error_px"};
    if (settings.metric == Metric::depth && !settings.cull)
        return {Code::out_of_range,
                "RefineSettings::cull (the depth metric needs it: behind the eye depth means nothing)"};
    sync_pages(s);
    s.topology = settings.topology;
    s.dirty_begin = s.budget.vertices;
    s.dirty_end = 0;
    report = {};
    report.frame = ++s.frame;
    const double requested_px = view_error_px(view, settings.error_px);
    report.error_px_requested = requested_px;

    const double corner = settings.corner_safe ? corner_factor(view) : 1;
    double threshold_px = first_threshold(s, requested_px);
    std::uint32_t exhausted = threshold_px > requested_px ? s.exhausted : 0;
    PassResult result;
    for (;; threshold_px *= step_up, ++report.restarts) {
        result = run_pass(s, view, settings, threshold_px / corner);
        report.vertices_written += result.written;
        report.buffer_clearings += result.clearings;
        exhausted |= result.exhausted;
        if (!result.exhausted) break;
    }
    s.effective_px = threshold_px;
    s.exhausted = report.exhausted = exhausted;
    s.last_selected = result.selected;
    s.last_indices = s.index_count;
    report.vertices = result.selected;
    report.triangles = result.triangles;
    report.tiles = result.tiles;
    report.error_px_effective = threshold_px;
    report.converged = threshold_px <= requested_px;
    return {};
}

} // namespace fjell
