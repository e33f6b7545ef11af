#include "rivals/look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fjell::rivals {

namespace {

Vec3 place_of(const Ground& g, double column, double row, double height_m) {
    return {column * static_cast<double>(g.spacing_x_m), height_m, row * static_cast<double>(g.spacing_z_m)};
}
Vec3 place_of(const Ground& g, const Corner& c) {
    return place_of(g, static_cast<double>(c.column), static_cast<double>(c.row), static_cast<double>(c.height_m));
}

// The camera of a look.
class Eye {
public:
    Eye(const Ground& ground, const View& view)
        : ground_(ground), eye_m_(view.eye_m), frustum_(make_frustum(view)), lambda_(focal_length_px(view)) {}
    [[nodiscard]] bool sees(const Vec3& place) const {
        for (int i = 0; i < 6; ++i)
            if (dot(frustum_.normal[i], place - eye_m_) < frustum_.offset[i]) return false;
        return true;
    }
    [[nodiscard]] bool may_see(const Face& f) const {
        for (int i = 0; i < 6; ++i) {
            const bool beyond = std::all_of(f.begin(), f.end(), [&](const Corner& c) {
                return dot(frustum_.normal[i], place_of(ground_, c) - eye_m_) < frustum_.offset[i];
            });
            if (beyond) return false;
        }
        return true;
    }
    [[nodiscard]] double pixels(const Vec3& place, double error_m) const {
        return error_m * lambda_ / std::max(length(place - eye_m_), 1e-9);
    }

private:
    const Ground& ground_;
    Vec3 eye_m_;
    Frustum frustum_;
    double lambda_;
};

double doubled_area_up(const Face& f) {
    const double ax = static_cast<double>(f[1].column) - static_cast<double>(f[0].column),
                 ay = static_cast<double>(f[1].row) - static_cast<double>(f[0].row),
                 bx = static_cast<double>(f[2].column) - static_cast<double>(f[0].column),
                 by = static_cast<double>(f[2].row) - static_cast<double>(f[0].row);
    return ay * bx - ax * by;
}

// Calls visit(column, row, height) for every sample in the closed face. A sample's three weights are linear, so each
// says from where to where along a row it is not negative.
template <typename Visit>
void samples_of(const Ground& g, const Face& f, const Visit& visit) {
    const double area = doubled_area_up(f);
    if (area == 0) return;
    constexpr double on_edge = -1e-9; // a sample between two faces belongs to both, whatever rounding says
    double x[3], y[3], h[3], along[3];
    for (std::size_t k = 0; k < 3; ++k) {
        x[k] = static_cast<double>(f[k].column);
        y[k] = static_cast<double>(f[k].row);
        h[k] = static_cast<double>(f[k].height_m);
    }
    for (std::size_t k = 0; k < 3; ++k) along[k] = (y[(k + 2) % 3] - y[(k + 1) % 3]) / area;
    const auto first = [](double v) { return std::max(static_cast<std::int32_t>(std::ceil(v)), 0); };
    const auto last = [&](double v) { return std::min(static_cast<std::int32_t>(std::floor(v)), g.side); };
    const double x0 = std::min({x[0], x[1], x[2]}), x1 = std::max({x[0], x[1], x[2]});
    const double y1 = std::max({y[0], y[1], y[2]});
    for (std::int32_t row = first(std::min({y[0], y[1], y[2]})); row <= last(y1); ++row) {
        double from = x0, to = x1, start[3];
        for (std::size_t k = 0; k < 3; ++k) { // the weight at column 0
            const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
            start[k] = -along[k] * x[a] - (x[b] - x[a]) * (row - y[a]) / area;
            const double zero = (on_edge - start[k]) / along[k];
            if (along[k] > 0) from = std::max(from, zero);
            if (along[k] < 0) to = std::min(to, zero);
            if (along[k] == 0 && start[k] < on_edge) to = x0 - 1;
        }
        const double slope = along[0] * h[0] + along[1] * h[1] + along[2] * h[2],
                     height_m = start[0] * h[0] + start[1] * h[1] + start[2] * h[2];
        for (std::int32_t column = first(from); column <= last(to); ++column)
            visit(column, row, height_m + slope * column);
    }
}

} // namespace

std::vector<float> surface_of(const Ground& g, std::span<const Face> faces) {
    std::vector<float> surface(g.height_m.size(), std::numeric_limits<float>::quiet_NaN());
    for (const Face& f : faces)
        samples_of(g, f, [&](std::int32_t column, std::int32_t row, double height_m) {
            surface[g.index({column, row})] = static_cast<float>(height_m);
        });
    return surface;
}

Look look_at(const Ground& g, std::span<const Face> faces, const View& view) {
    const Eye eye(g, view);
    const double lost_m =
        0x1p-22 * std::max(std::abs(static_cast<double>(g.min_m)), std::abs(static_cast<double>(g.max_m)));
    std::vector<bool> covered(g.height_m.size());
    Look look;
    for (const Face& f : faces) {
        const double area = doubled_area_up(f);
        look.facing_down += area < 0;
        look.in_view += area > 0 && eye.may_see(f);
        samples_of(g, f, [&](std::int32_t column, std::int32_t row, double height_m) {
            const std::uint32_t i = g.index({column, row});
            covered[i] = true;
            const double wrong_m = std::abs(height_m - static_cast<double>(g.height_m[i])) - lost_m;
            if (wrong_m <= 0) return;
            const Vec3 place = place_of(g, column, row, static_cast<double>(g.height_m[i]));
            const double px = eye.pixels(place, wrong_m);
            if (px > look.error_px && eye.sees(place)) look.error_px = px, look.where = {column, row};
        });
    }
    for (std::int32_t row = 0; row <= g.side; ++row)
        for (std::int32_t column = 0; column <= g.side; ++column) {
            const std::uint32_t i = g.index({column, row});
            if (!covered[i]) look.uncovered += eye.sees(place_of(g, column, row, static_cast<double>(g.height_m[i])));
        }
    return look;
}

namespace {

struct Edge {
    Corner from, to;
    friend constexpr auto operator<=>(const Edge&, const Edge&) = default;
};

bool on_rim(const Ground& g, const Edge& e) {
    const auto side = static_cast<float>(g.side);
    return (e.from.column == e.to.column && (e.from.column == 0 || e.from.column == side)) ||
           (e.from.row == e.to.row && (e.from.row == 0 || e.from.row == side));
}

bool in_view(const Ground& g, const Eye& eye, const Edge& e) {
    const Vec3 a = place_of(g, e.from), b = place_of(g, e.to);
    for (int i = 0; i <= 4; ++i)
        if (eye.sees(a + (b - a) * (i / 4.0))) return true;
    return false;
}

// Of a corner above or below the inside of an edge; otherwise 0.
double gap_m(const Edge& e, const Corner& c) {
    const double dx = static_cast<double>(e.to.column - e.from.column), dy = static_cast<double>(e.to.row - e.from.row);
    const double cx = static_cast<double>(c.column - e.from.column), cy = static_cast<double>(c.row - e.from.row);
    const double squared = dx * dx + dy * dy, along = (cx * dx + cy * dy) / squared;
    const double beside = std::abs(cx * dy - cy * dx) / std::sqrt(squared);
    if (!(along > 1e-6 && along < 1 - 1e-6 && beside < 1e-3)) return 0;
    const double a = static_cast<double>(e.from.height_m), b = static_cast<double>(e.to.height_m);
    return std::abs(a + (b - a) * along - static_cast<double>(c.height_m));
}

} // namespace

Seams seams_of(const Ground& g, std::span<const Face> faces, const View& view) {
    std::vector<Edge> edges;
    for (const Face& f : faces)
        for (std::size_t k = 0; k < 3; ++k)
            if (f[k] != f[(k + 1) % 3]) edges.push_back({f[k], f[(k + 1) % 3]});
    std::sort(edges.begin(), edges.end());
    const Eye eye(g, view);
    std::vector<Edge> open;
    for (std::size_t i = 0; i < edges.size();) {
        // A face without an area that has become a line has each of its edges both ways: they cancel.
        const auto same = std::equal_range(edges.begin() + static_cast<std::ptrdiff_t>(i), edges.end(), edges[i]);
        const auto back = std::equal_range(edges.begin(), edges.end(), Edge{edges[i].to, edges[i].from});
        const auto there = same.second - same.first, opposite = back.second - back.first;
        if (there > opposite && !on_rim(g, edges[i]) && in_view(g, eye, edges[i])) open.push_back(edges[i]);
        i += static_cast<std::size_t>(there);
    }
    Seams seams{open.size(), 0};
    constexpr std::size_t most = 3000; // of both; a lower bound where there are more
    for (std::size_t i = 0; i < std::min(open.size(), most); ++i)
        for (std::size_t k = 0; k < std::min(open.size(), most); ++k)
            if (i != k)
                seams.gap_px =
                    std::max(seams.gap_px, eye.pixels(place_of(g, open[k].from), gap_m(open[i], open[k].from)));
    return seams;
}

double popping_px(const Ground& g, std::span<const float> before, const View& view_before, std::span<const float> after,
                  const View& view_after) {
    const Eye eye(g, view_after), former(g, view_before);
    double most = 0;
    for (std::int32_t row = 0; row <= g.side; ++row)
        for (std::int32_t column = 0; column <= g.side; ++column) {
            const std::uint32_t i = g.index({column, row});
            const double moved_m = std::abs(static_cast<double>(after[i]) - static_cast<double>(before[i]));
            if (!(moved_m > 0)) continue;
            const Vec3 place = place_of(g, column, row, static_cast<double>(g.height_m[i]));
            const double px = eye.pixels(place, moved_m);
            if (px > most && eye.sees(place) && former.sees(place)) most = px;
        }
    return most;
}

} // namespace fjell::rivals
