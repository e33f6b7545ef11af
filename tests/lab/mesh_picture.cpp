#include "lab/mesh_picture.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "lab/plot.h"

namespace fjell::lab {

namespace {

constexpr int side_px = 600, top_px = 24;

} // namespace

std::string mesh_svg(const rivals::Ground& ground, std::span<const rivals::Face> faces, const View& view, int cells,
                     const std::string& title) {
    const double sx = static_cast<double>(ground.spacing_x_m), sz = static_cast<double>(ground.spacing_z_m);
    const double ahead = std::hypot(view.forward.x, view.forward.z), half = cells / 2.0;
    const double eye_x = view.eye_m.x / sx, eye_y = view.eye_m.z / sz, to_x = view.forward.x / std::max(ahead, 1e-9),
                 to_y = view.forward.z / std::max(ahead, 1e-9);
    const double x0 = std::round(eye_x + 0.7 * half * to_x - half), y0 = std::round(eye_y + 0.7 * half * to_y - half);
    // Tenths of a pixel, whole: short to write.
    const auto place = [&](double x, double y) {
        return std::pair(static_cast<int>(std::lround((x - x0) * 10 * side_px / cells)),
                         static_cast<int>(std::lround((y - y0) * 10 * side_px / cells)));
    };
    std::set<std::pair<std::pair<int, int>, std::pair<int, int>>> edges;
    for (const rivals::Face& f : faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const rivals::Corner &a = f[k], &b = f[(k + 1) % 3];
            const auto [left, right] = std::minmax({static_cast<double>(a.column), static_cast<double>(b.column)});
            const auto [up, down] = std::minmax({static_cast<double>(a.row), static_cast<double>(b.row)});
            if (right < x0 || left > x0 + cells || down < y0 || up > y0 + cells) continue;
            const auto from = place(static_cast<double>(a.column), static_cast<double>(a.row)),
                       to = place(static_cast<double>(b.column), static_cast<double>(b.row));
            if (from != to) edges.insert(std::minmax({from, to}));
        }
    std::string path;
    for (const auto& [from, to] : edges)
        path += fmt::format("M{} {}l{} {}", from.first, from.second, to.first - from.first, to.second - from.second);
    std::string svg =
        fmt::format("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}' "
                    "font-family='sans-serif' font-size='14'>\n<rect width='100%' height='100%' fill='white'/>"
                    "<text x='4' y='17'>{2}</text>\n<svg y='{3}' width='{0}' height='{0}' viewBox='0 0 {4} {4}'>"
                    "<path d='{5}' fill='none' stroke='#345' stroke-width='6'/>\n",
                    side_px, side_px + top_px, escaped(title), top_px, 10 * side_px, path);
    for (const double tangent : {view.left, view.right}) {
        // The side of the picture on the ground, as if the camera looked level: right of forward is (-z, x) seen so.
        const auto from = place(eye_x, eye_y),
                   to = place(eye_x + 4 * cells * (to_x - tangent * to_y), eye_y + 4 * cells * (to_y + tangent * to_x));
        svg += fmt::format("<line x1='{}' y1='{}' x2='{}' y2='{}' stroke='#d55e00' stroke-width='20'/>\n", from.first,
                           from.second, to.first, to.second);
    }
    return svg + "</svg>\n</svg>\n";
}

} // namespace fjell::lab
