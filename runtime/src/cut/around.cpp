#include "cut/around.h"

namespace fjell {

Around find_around_anywhere(const Pages& pages, std::uint32_t vertex) {
    Around out{};
    out.site = site_of(pages, vertex);
    const bool root = out.site.kind == VertexKind::centre && out.site.z == pages.grid.terrain->tree.tile_log2 - 1,
               leaf = out.site.kind != VertexKind::centre && out.site.z == 0;
    for (int d = 0; d < 4; ++d) {
        out.child[d] = no_index;
        const Site child = child_site(out.site, d);
        if (leaf || !exists(pages.grid, child)) continue;
        out.child[d] = find_vertex(pages, child);
        out.lacks_child = out.lacks_child || out.child[d] == no_index;
    }
    for (int n = 0; n < 2; ++n) {
        out.parent[n] = no_index;
        const Site parent = parent_site(out.site, n);
        if (!root && exists(pages.grid, parent)) out.parent[n] = find_vertex(pages, parent);
    }
    return out;
}

namespace {

// Places in a full page, in vertices: rows of page_squares, the column of the east border last (groups.h).
constexpr std::uint32_t centre_places = 0, side_x_places = centre_places + page_squares * page_squares,
                        side_y_places = side_x_places + page_squares * (page_squares + 1),
                        column_places = side_y_places + page_squares * page_squares;
static_assert(column_places + page_squares == max_page_vertices && page_squares == 2 * group_lanes);

// The first vertex of a full page, by its place among its tile's pages of that step; no_index: it has no state.
std::uint32_t first_vertex(const Pages& pages, const StepGroups& step, std::uint32_t tile_page, std::uint32_t px,
                           std::uint32_t py) {
    const std::uint32_t page = tile_page + step.first_page + (py << (step.log2 - page_squares_log2)) + px;
    const std::uint32_t first = pages.page_groups[page];
    return first == no_index ? no_index : first * group_lanes;
}

std::uint32_t vertex_at(std::uint32_t first, std::uint32_t plane, std::uint32_t i, std::uint32_t j) {
    return first == no_index ? no_index : first + plane + j * page_squares + i;
}

} // namespace

Around find_around(const Pages& pages, std::uint32_t vertex) {
    constexpr std::uint32_t row = page_squares, last = page_squares - 1;
    const std::uint32_t slot = vertex / max_page_vertices, place = vertex - slot * max_page_vertices;
    const PageState& info = pages.state[slot];
    if (info.shape == 0 || pages.grid.hz_places != nullptr) return find_around_anywhere(pages, vertex);
    const VertexKind kind = place < side_x_places   ? VertexKind::centre
                            : place < side_y_places ? VertexKind::side_x
                                                    : VertexKind::side_y;
    const std::uint32_t plane = kind == VertexKind::centre   ? centre_places
                                : kind == VertexKind::side_x ? side_x_places
                                                             : side_y_places;
    const std::uint32_t i = (place - plane) % row, j = (place - plane) / row;
    const bool on_border = kind == VertexKind::centre   ? i == last || j == last
                           : kind == VertexKind::side_x ? j == 0 || j == row
                                                        : i == 0 || place >= column_places;
    const StepGroups* const step = &pages.grid.steps[info.z];
    if (on_border || (kind == VertexKind::centre && step[1].log2 < page_squares_log2)) // its parents are in page 0
        return find_around_anywhere(pages, vertex);

    Around out{};
    out.site = site_of(pages, vertex);
    const std::uint32_t tile_page = info.tile * pages.grid.pages_per_tile,
                        px = static_cast<std::uint32_t>(info.i0) / row, py = static_cast<std::uint32_t>(info.j0) / row;
    if (kind == VertexKind::centre) {
        const std::uint32_t west = vertex + (side_y_places - centre_places),
                            north = vertex + (side_x_places - centre_places);
        out.child[0] = west;
        out.child[1] = west + 1;
        out.child[2] = north;
        out.child[3] = north + row;
        // Of the coarser step's page this one is a quarter.
        const std::uint32_t first = first_vertex(pages, step[1], tile_page, px / 2, py / 2);
        const std::uint32_t ci = px % 2 * row + i, cj = py % 2 * row + j;
        out.parent[0] = vertex_at(first, side_x_places, ci / 2, (cj + 1) / 2);
        out.parent[1] = vertex_at(first, side_y_places, (ci + 1) / 2, cj / 2);
        return out;
    }
    const std::uint32_t centre = vertex - (plane - centre_places);
    out.parent[0] = kind == VertexKind::side_x ? centre - row : centre - 1;
    out.parent[1] = centre;
    // Its children are two by two squares of the finer step, in one page or two.
    const std::uint32_t fi = 2 * i - (kind == VertexKind::side_y), fj = 2 * j - (kind == VertexKind::side_x);
    for (std::uint32_t d = 0; d < 4; ++d) {
        out.child[d] = no_index;
        if (info.z == 0) continue;
        const std::uint32_t ci = fi + d % 2, cj = fj + d / 2;
        const std::uint32_t first = first_vertex(pages, step[-1], tile_page, 2 * px + ci / row, 2 * py + cj / row);
        out.child[d] = vertex_at(first, centre_places, ci % row, cj % row);
        out.lacks_child = out.lacks_child || first == no_index;
    }
    return out;
}

} // namespace fjell
