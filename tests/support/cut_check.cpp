#include "support/cut_check.h"

#include <stdexcept>

#include "cut/mesh.h"
#include "cut/morph.h"
#include "cut/pages.h"
#include "shared/terrain_data.h"
#include "view/wanted.h"

namespace fjell::test {

Cut::Cut(const Terrain& terrain, const CutBudget& budget) {
    const std::size_t bytes = cut_bytes(terrain, budget);
    memory = io::allocate(bytes);
    const Status made = create_cut(terrain, budget, {memory.get(), bytes}, cut);
    if (!made.ok()) throw std::runtime_error(std::string(made.field) + ": " + message(made.code));
}

CutReport Cut::update(std::span<const View> views, const CutSettings& settings) {
    CutReport report;
    const Status done = update_cut(cut, views, settings, report);
    if (!done.ok()) throw std::runtime_error(std::string(done.field) + ": " + message(done.code));
    return report;
}

CutReport Cut::rebuild(std::span<const View> views, const CutSettings& settings) {
    CutReport report;
    const Status done = rebuild_cut(cut, views, settings, report);
    if (!done.ok()) throw std::runtime_error(std::string(done.field) + ": " + message(done.code));
    return report;
}

MeshView Cut::mesh() {
    const CutState& s = state();
    ranges.clear();
    for (std::uint32_t tile = 0; tile < s.pages.grid.terrain->tile_count(); ++tile) {
        std::uint32_t count = s.mesh.tiles[tile].in_last;
        for (std::uint32_t segment = s.mesh.tiles[tile].last_segment; segment != no_index;
             segment = s.mesh.segment_below[segment]) {
            ranges.push_back({tile, (segment << s.mesh.segment_log2) * 3, count * 3, count});
            count = 1u << s.mesh.segment_log2;
        }
    }
    MeshView view = cut_mesh(cut).mesh;
    view.tiles = ranges;
    return view;
}

CutBudget ample_cut(const Terrain& terrain, std::uint32_t views) {
    const std::uint32_t samples = static_cast<std::uint32_t>(data_of(terrain).tree.grid_columns()) *
                                  static_cast<std::uint32_t>(data_of(terrain).tree.grid_rows());
    CutBudget budget;
    budget.vertices = samples + 16;
    budget.segment_triangles = 16;
    budget.triangles = 2 * samples + 16 * (2 * terrain.tile_count() + 8);
    budget.views = views;
    return budget;
}

std::string in_words(const Violation& found) {
    if (!found) return {};
    if (found.at.column < 0) return found.what;
    return std::string(found.what) + " (" + std::to_string(found.at.column) + ", " + std::to_string(found.at.row) + ")";
}

std::string check_cut(Cut& cut) {
    const CutState& s = cut.state();
    if (const Violation found = validate_terrain(*s.pages.grid.terrain)) return in_words(found);
    return in_words(validate_cut(s));
}

std::string check_surface(Cut& cut, const Terrain& full) {
    MeshView drawn = cut.mesh();
    // Vertices that morph out are on their way to the edge: for the rest of this they stand where their samples do.
    std::vector<MeshVertex> standing(drawn.vertices.begin(), drawn.vertices.end());
    for (std::uint32_t slot = 0; slot < standing.size(); ++slot)
        if (morphs_out(cut.state().mesh, slot))
            standing[slot].height_m = data_of(full).height_m({standing[slot].column, standing[slot].row});
    drawn.vertices = standing;
    const auto holes = [&](const Triangle& t) {
        return data_of(full).is_hole(t[0]) || data_of(full).is_hole(t[1]) || data_of(full).is_hole(t[2]);
    };
    if (full.has_voids())
        for (const Triangle& t : triangles_of(drawn))
            if (holes(t)) return "a triangle with a corner in a hole is drawn";
    // What is hidden, one range a triangle, in the tile that its middle lies in; less what is shrunk to nothing.
    const CutState& s = cut.state();
    std::vector<TileRange> ranges = cut.ranges;
    const TileList& hidden = s.mesh.tiles[hidden_tile(s.mesh)];
    std::uint32_t count = hidden.in_last;
    for (std::uint32_t segment = hidden.last_segment; segment != no_index; segment = s.mesh.segment_below[segment]) {
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t first = ((segment << s.mesh.segment_log2) + i) * 3;
            MeshView one = drawn;
            const TileRange range{0, first, 3, 1};
            one.tiles = {&range, 1};
            const std::vector<Triangle> found = triangles_of(one);
            if (found.empty()) continue;
            const Triangle& t = found[0];
            if (!holes(t)) return "a triangle without a corner in a hole is hidden";
            const std::int32_t side = 3 * data_of(full).tree.side();
            const std::int32_t x = (t[0].column + t[1].column + t[2].column) / side,
                               y = (t[0].row + t[1].row + t[2].row) / side;
            ranges.push_back({full.tile_at({x, y}), first, 3, 1});
        }
        count = 1u << s.mesh.segment_log2;
    }
    MeshView whole = drawn;
    whole.tiles = ranges;
    return check_mesh(full, whole);
}

namespace {

std::size_t place(const Terrain& t, SampleIndex c) {
    return static_cast<std::size_t>(c.row) * static_cast<std::size_t>(data_of(t).tree.grid_columns()) +
           static_cast<std::size_t>(c.column);
}
// In a tile of the terrain, or on its border; a sparse one lacks some.
bool is_there(const Terrain& t, SampleIndex c) {
    if (!data_of(t).tree.contains(c)) return false;
    const std::int32_t side = data_of(t).tree.side();
    for (const SampleIndex by : {SampleIndex{0, 0}, {-1, 0}, {0, -1}, {-1, -1}}) {
        const SampleIndex inside{c.column + by.column, c.row + by.row}; // where a tile that has c on its border begins
        const bool holds = (by.column == 0 || c.column % side == 0) && (by.row == 0 || c.row % side == 0);
        if (holds && inside.column >= 0 && inside.row >= 0 &&
            t.tile_at({inside.column / side, inside.row / side}) != no_tile)
            return true;
    }
    return false;
}
VertexSet only_corners(const Terrain& t, bool others) {
    VertexSet set(place(t, {0, data_of(t).tree.grid_rows()}), others);
    for (std::int32_t y = 0; y < data_of(t).tree.grid_rows(); y += data_of(t).tree.side())
        for (std::int32_t x = 0; x < data_of(t).tree.grid_columns(); x += data_of(t).tree.side())
            set[place(t, {x, y})] = true;
    return set;
}

} // namespace

VertexSet active_set(Cut& cut) {
    const CutState& s = cut.state();
    VertexSet set = only_corners(s.pages.grid.handle, false);
    for (std::uint32_t slot = 0; slot < s.pages.count; ++slot) {
        if (s.pages.state[slot].page == no_index) continue;
        for (std::uint32_t n = 0; n < s.pages.grid.shapes[s.pages.state[slot].shape].count * group_lanes; ++n) {
            const std::uint32_t vertex = slot * max_page_groups * group_lanes + n;
            if (s.pages.groups[vertex / group_lanes].active & bit_of(vertex))
                set[place(s.pages.grid.handle, site_coord(site_of(s.pages, vertex)))] = true;
        }
    }
    return set;
}

VertexSet target_set(const Terrain& full, const Terrain& paged, std::span<const View> views, double error_px,
                     bool corner_safe) {
    VertexSet set = only_corners(full, true);
    for (std::uint32_t tile = 0; tile < paged.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < paged.pages_per_tile(); ++page) {
            if (data_of(paged).page_table[tile * paged.pages_per_tile() + page].slot != no_index) continue;
            const SampleIndex corner{full.tile_place(tile).column * data_of(full).tree.side(),
                                     full.tile_place(tile).row * data_of(full).tree.side()};
            for (std::uint32_t i = 0; i < data_of(full).pages.page_vertices(page); ++i) {
                const SampleIndex c = corner + data_of(full).pages.coord({page, i});
                if (!data_of(full).tree.is_corner(c)) set[place(full, c)] = false;
            }
        }
    std::vector<Reach> reaches;
    for (const View& view : views) {
        const double px = view.max_error_px > 0 ? view.max_error_px : error_px;
        reaches.push_back(make_reach(view, corner_safe ? px / corner_factor(view) : px));
    }
    // Of every level its own coordinates: centres at odd multiples of the step, sides where one is odd and one even.
    // Parents first: most vertices have none in the set, and need not be looked up.
    for (int level = 0; level < 2 * data_of(full).tree.tile_log2; ++level) {
        const std::int32_t step = 1 << (data_of(full).tree.tile_log2 - 1 - level / 2);
        const bool sides = level % 2 != 0;
        for (std::int32_t y = sides ? 0 : step; y < data_of(full).tree.grid_rows(); y += sides ? step : 2 * step)
            for (std::int32_t x = sides && (y & step) ? 0 : step; x < data_of(full).tree.grid_columns();
                 x += 2 * step) {
                const SampleIndex c{x, y};
                if (!set[place(full, c)]) continue;
                if (!is_there(full, c)) {
                    set[place(full, c)] = false;
                    continue;
                }
                bool parents = true, in = false;
                for (const SampleIndex parent : diamond(data_of(full).tree, c).apexes)
                    parents = parents && (!is_there(full, parent) || set[place(full, parent)]);
                if (parents) {
                    const TerrainData::Vertex v = data_of(full).vertex(c);
                    const SampleIndex at = data_of(full).tree.sample(c);
                    for (const Reach& r : reaches)
                        in = in || wanted(r, full.x_m(at.column), v.height_m, full.z_m(at.row), v.error_m, v.radius_m);
                }
                set[place(full, c)] = in;
            }
    }
    return set;
}

std::vector<View> thresholds_over(double divisor, std::span<const View> views) {
    std::vector<View> result(views.begin(), views.end());
    for (View& view : result) view.max_error_px /= divisor;
    return result;
}

std::string difference(const VertexSet& is, const VertexSet& should_be) {
    if (is == should_be) return {};
    std::size_t extra = 0, missing = 0;
    for (std::size_t i = 0; i < is.size(); ++i) {
        extra += is[i] && !should_be[i];
        missing += !is[i] && should_be[i];
    }
    return std::to_string(extra) + " vertices too many, " + std::to_string(missing) + " too few";
}

bool contains(const VertexSet& larger, const VertexSet& smaller) {
    for (std::size_t i = 0; i < smaller.size(); ++i)
        if (smaller[i] && !larger[i]) return false;
    return smaller.size() == larger.size();
}

} // namespace fjell::test
