#include "editor/contours.h"

#include <cmath>
#include <cstring>

#include "editor/probe.h"
#include "fjell/query.h"

namespace fjell::editor {

namespace {

constexpr int label_columns = 10, label_lines = 40;

struct LabelSearch {
    ContourLabels& labels;
    const Terrain& terrain;
    const View& view;
    double apart_px;

    [[nodiscard]] GroundHit hit(double x, double y) const {
        return cast_ray(terrain, view.eye_m, direction_at(view, x, y), view.far_m);
    }
    [[nodiscard]] bool has_room(double x, double y) const {
        for (std::size_t i = 0; i < labels.count; ++i)
            if (std::abs(x - labels.all[i].x) * view.width_px < 1.5 * apart_px &&
                std::abs(y - labels.all[i].y) * view.height_px < 0.7 * apart_px)
                return false;
        return labels.count < labels.all.size();
    }
    // The contour between two places of a column, one above the other, of which one lies below it.
    void pin(double x, double low_y, double high_y, double height_m, bool rises) {
        for (int i = 0; i < 8; ++i) {
            const double middle = (low_y + high_y) / 2;
            const GroundHit there = hit(x, middle);
            if (!there.hit) return;
            ((there.position_m.y < height_m) == rises ? low_y : high_y) = middle;
        }
        // Where the ground is hidden between the two, the edge of what hides it was found.
        const GroundHit there = hit(x, low_y);
        if (!there.hit || std::abs(there.position_m.y - height_m) > 0.1 * labels.every_m) return;
        if (has_room(x, low_y)) labels.all[labels.count++] = {x, low_y, height_m};
    }
    void along(double x, double step_m) {
        double before_y = 0, before_m = 0, before_away_m = 0;
        bool there = false;
        for (int row = label_lines; row >= 1; --row) { // from the picture's foot up
            const double y = (row - 0.5) / label_lines;
            const GroundHit now = hit(x, y);
            if (!now.hit) return; // the sky
            const double now_m = now.position_m.y, away_m = length(now.position_m - view.eye_m);
            const bool beyond_a_ridge = there && away_m > 2 * before_away_m;
            const double least = std::floor(std::min(now_m, before_m) / step_m),
                         most = std::floor(std::max(now_m, before_m) / step_m);
            // Where several lie between two rays lines are too close for numbers.
            if (there && !beyond_a_ridge && most == least + 1) pin(x, before_y, y, most * step_m, now_m > before_m);
            before_y = y;
            before_m = now_m;
            before_away_m = away_m;
            there = true;
        }
    }
};

} // namespace

void update_contour_labels(ContourLabels& labels, const Terrain& terrain, const View& view, double every_m,
                           bool changed, double apart_px) {
    const bool same = std::memcmp(&labels.of, &view, sizeof view) == 0 && labels.every_m == every_m;
    labels.of = view;
    labels.every_m = every_m;
    if (same && labels.found && !changed) return;
    labels.count = 0;
    labels.found = same && !changed && every_m > 0;
    if (!labels.found) return;
    LabelSearch search{labels, terrain, view, apart_px};
    for (const double step_m : {5 * every_m, every_m}) { // the wide ones; the others where there are few
        if (labels.count >= 6) return;
        for (int column = 0; column < label_columns; ++column) search.along((column + 0.5) / label_columns, step_m);
    }
}

} // namespace fjell::editor
