#include "support/cut_check.h"

#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "cut/change.h"
#include "cut/mesh.h"
#include "cut/morph.h"
#include "cut/pages.h"
#include "pack/terrain_data.h"
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
    for (std::uint32_t tile = 0; tile < s.terrain->tile_count(); ++tile) {
        std::uint32_t count = s.tiles[tile].in_last;
        for (std::uint32_t segment = s.tiles[tile].last_segment; segment != no_index;
             segment = s.segment_below[segment]) {
            ranges.push_back({tile, (segment << s.segment_log2) * 3, count * 3, count});
            count = 1u << s.segment_log2;
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

namespace {

std::string say(const char* what, const CutState& s, std::uint32_t vertex) {
    std::ostringstream text;
    const Coord c = site_coord(site_of(s, vertex));
    text << what << " (" << c.x << ", " << c.y << ")";
    return text.str();
}

bool active(const CutState& s, std::uint32_t vertex) {
    return s.groups[vertex / group_lanes].active >> vertex % group_lanes & 1;
}

std::string check_vertex(const CutState& s, std::uint32_t vertex, std::vector<bool>& slot_used) {
    const Site site = site_of(s, vertex);
    const GroupState& b = s.groups[vertex / group_lanes];
    const std::uint32_t lane = vertex % group_lanes;
    const auto bit = [&](std::uint16_t mask) { return (mask >> lane & 1) != 0; };
    if (!exists(s, site) || find_vertex(s, site) != vertex) {
        if (b.active >> lane & 1) return say("a vertex is active where it is not owned:", s, vertex);
        if (b.ready() >> lane & 1) return say("a vertex is ready where it is not owned:", s, vertex);
        return {};
    }
    if (bit(b.active) && !bit(b.ready())) return say("an active vertex' parent is not active:", s, vertex);
    const bool leaf = site.kind != VertexKind::centre && site.z == 0;
    for (int d = 0; d < 4; ++d) {
        bool child = false;
        if (!leaf && exists(s, child_site(site, d))) {
            const std::uint32_t found = find_vertex(s, child_site(site, d));
            child = found != no_index && active(s, found);
        }
        if (bit(b.child[d]) != child) return say("a child mask is wrong at", s, vertex);
        if (!bit(b.active)) continue;
        const std::uint32_t slot = s.vertex_slot[vertex];
        if (slot >= s.budget.vertices) return say("no vertex slot for", s, vertex);
        const bool drawn = s.triangle_of[slot * 4 + static_cast<std::uint32_t>(d)] != no_index;
        // At the rim no triangle lies beyond; a leaf has no children to say so.
        bool expected = !child;
        if (!leaf) expected = expected && exists(s, child_site(site, d));
        if (!leaf && drawn != expected) return say("a triangle is missing, or is one too many, at", s, vertex);
    }
    if (bit(b.active)) {
        const std::uint32_t slot = s.vertex_slot[vertex];
        if (slot_used[slot]) return say("two vertices have one slot:", s, vertex);
        slot_used[slot] = true;
        const Coord at = s.terrain->tree.sample(site_coord(site));
        if (s.vertices[slot].column != at.x || s.vertices[slot].row != at.y)
            return say("a vertex slot is another vertex':", s, vertex);
    }
    return {};
}

std::string check_group(const CutState& s, std::uint32_t number) {
    const GroupState& b = s.groups[number];
    const PageSlot& info = s.page_slot[number / max_page_groups];
    const ParentMasks parents = parents_of(s, number, (1u << shape_of(s, number).lanes) - 1);
    if (b.parent[0] != parents.parent[0] || b.parent[1] != parents.parent[1])
        return say("a parent mask is wrong in the group of", s, number * group_lanes);
    const bool evicting = info.status == PageSlotStatus::evicting;
    const std::uint32_t inactive = evicting ? 0u : static_cast<std::uint32_t>(b.ready() & ~b.active);
    auto childless = static_cast<std::uint32_t>(b.active & ~b.parental());
    for (std::uint32_t lane = 0; lane < group_lanes; ++lane) // those that morph out go by themselves
        if ((b.active >> lane & 1) && morphs_out(s, s.vertex_slot[number * group_lanes + lane]))
            childless &= ~(1u << lane);
    const ListId list = list_of(s.lists, number);
    if ((inactive | childless) != 0 && list == unlisted && !evicting)
        return say("nobody will look at the group of", s, number * group_lanes);
    if (list >= due_lists || evicting) return {}; // what is evicted goes without being evaluated
    // Until a page is evicted, what stood on it goes step by step, whatever the decision says.
    bool some_evicting = false;
    for (std::uint32_t i = 0; i < s.evicting_count; ++i)
        some_evicting = some_evicting || s.page_slot[s.evicting[i]].active != 0;
    // In the calendar: how far may it go, and how far will it?
    const std::uint32_t grade = b.grade;
    const double left_m = list >= soon_lists
                              ? 0
                              : (static_cast<double>(std::uint64_t{b.due_high} << 32 | b.due) + 1) * s.lists.tick_m -
                                    s.lists.odometer_m[grade];
    for (std::uint32_t lane = 0; lane < group_lanes; ++lane) {
        if (!((inactive | childless) >> lane & 1)) continue;
        const std::uint32_t vertex = number * group_lanes + lane;
        const Coord c = site_coord(site_of(s, vertex)), at = s.terrain->tree.sample(c);
        const TerrainData::Vertex v = s.terrain->vertex(c);
        const bool on = childless >> lane & 1;
        if (!on && some_evicting) continue;
        double margin = -1e300;
        bool in = false;
        for (std::uint32_t i = 0; i < s.view_count; ++i) {
            const Reach& r = on ? s.criterion.keep[i] : s.criterion.reach[i];
            in = in || wanted(r, s.terrain->x_m(at.x), v.height_m, s.terrain->z_m(at.y), v.error_m, v.radius_m);
            const Vec3 way{s.terrain->x_m(at.x) - r.eye_x, v.height_m - r.eye_y, s.terrain->z_m(at.y) - r.eye_z};
            margin = std::max(margin, (static_cast<double>(v.radius_m) + static_cast<double>(v.error_m) * r.q) *
                                              static_cast<double>(reach_grow) +
                                          static_cast<double>(r.pad) - length(way));
        }
        if (in != on) return say("a vertex disagrees with the decision, and nobody knows:", s, vertex);
        if (left_m > std::abs(margin) * (1 + 1e-4) + s.lists.tick_m * 1.01)
            return say("a vertex could change before it is looked at:", s, vertex);
        if (v.error_code >> grade_codes_log2 > grade) return say("a group's grade is too low:", s, vertex);
    }
    return {};
}

std::string check_triangles(const CutState& s) {
    std::vector<bool> segment_used(s.segment_count);
    for (std::uint32_t i = 0; i < s.free_segment_count; ++i) {
        if (segment_used[s.free_segments[i]]) return "a segment is free twice";
        segment_used[s.free_segments[i]] = true;
    }
    std::uint32_t named = 0;
    for (std::uint32_t tile = 0; tile <= s.terrain->tile_count(); ++tile) {
        const TileList& list = s.tiles[tile];
        std::uint32_t count = list.in_last, total = 0;
        for (std::uint32_t segment = list.last_segment; segment != no_index; segment = s.segment_below[segment]) {
            if (segment_used[segment]) return "a segment is used twice";
            segment_used[segment] = true;
            if (s.segment_tile[segment] != tile) return "a segment does not know its tile";
            if (count == 0) return "an empty segment is kept";
            total += count;
            for (std::uint32_t i = 0; i < count; ++i) {
                const std::uint32_t slot = (segment << s.segment_log2) + i;
                if (s.triangle_of[s.key_of[slot]] != slot) return "a triangle's name leads elsewhere";
                if (s.key_of[slot] / 4 != s.indices[std::size_t{slot} * 3])
                    return "a triangle's right angle is not its maker's";
                const MeshTriangle t{s.indices[std::size_t{slot} * 3], s.indices[std::size_t{slot} * 3 + 1],
                                     s.indices[std::size_t{slot} * 3 + 2]};
                if (s.some_hidden && is_hidden(s, t) != (tile == hidden_tile(s))) return "a triangle is hidden wrongly";
                ++named;
            }
            count = 1u << s.segment_log2;
        }
        if (total != list.total) return "a tile counts its triangles wrongly";
    }
    for (const bool used : segment_used)
        if (!used) return "a segment is lost";
    std::uint32_t made = 0;
    for (std::size_t i = 0; i < std::size_t{s.budget.vertices} * 4; ++i) made += s.triangle_of[i] != no_index;
    return made == named ? "" : "a triangle is made that no tile has";
}

} // namespace

std::string check_cut(Cut& cut) {
    const CutState& s = cut.state();
    std::vector<bool> slot_used(s.budget.vertices);
    const auto corners = static_cast<std::uint32_t>((s.tiles_x + 1) * (s.tiles_y + 1));
    for (std::uint32_t i = 0; i < corners; ++i) slot_used[i] = true;
    for (std::uint32_t slot = 0; slot < s.terrain->slot_count; ++slot) {
        const PageSlot& info = s.page_slot[slot];
        if (info.page == no_index) continue;
        std::uint32_t count = 0;
        for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) {
            const std::uint32_t number = slot * max_page_groups + n;
            for (std::uint32_t lane = 0; lane < s.shapes[info.shape].groups[n].lanes; ++lane) {
                if (std::string wrong = check_vertex(s, number * group_lanes + lane, slot_used); !wrong.empty())
                    return wrong;
                count += active(s, number * group_lanes + lane);
            }
            if (std::string wrong = check_group(s, number); !wrong.empty()) return wrong;
        }
        if (count != info.active) return "a page counts its active vertices wrongly";
    }
    for (std::uint32_t i = 0; i < s.free_vertex_count; ++i) {
        if (slot_used[s.free_vertices[i]]) return "a vertex slot is free and used";
        slot_used[s.free_vertices[i]] = true;
    }
    for (std::uint32_t slot = s.fresh_vertex; slot < s.budget.vertices; ++slot) {
        if (slot_used[slot]) return "a vertex slot that was never taken is used";
        slot_used[slot] = true;
    }
    for (const bool used : slot_used)
        if (!used) return "a vertex slot is lost";
    return check_triangles(s);
}

std::string check_surface(Cut& cut, const Terrain& full) {
    MeshView drawn = cut.mesh();
    // Vertices that morph out are on their way to the edge: for the rest of this they stand where their samples do.
    std::vector<MeshVertex> standing(drawn.vertices.begin(), drawn.vertices.end());
    for (std::uint32_t slot = 0; slot < standing.size(); ++slot)
        if (morphs_out(cut.state(), slot))
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
    const TileList& hidden = s.tiles[hidden_tile(s)];
    std::uint32_t count = hidden.in_last;
    for (std::uint32_t segment = hidden.last_segment; segment != no_index; segment = s.segment_below[segment]) {
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t first = ((segment << s.segment_log2) + i) * 3;
            MeshView one = drawn;
            const TileRange range{0, first, 3, 1};
            one.tiles = {&range, 1};
            const std::vector<Triangle> found = triangles_of(one);
            if (found.empty()) continue;
            const Triangle& t = found[0];
            if (!holes(t)) return "a triangle without a corner in a hole is hidden";
            const std::int32_t side = 3 * data_of(full).tree.side();
            const std::int32_t x = (t[0].x + t[1].x + t[2].x) / side, y = (t[0].y + t[1].y + t[2].y) / side;
            ranges.push_back({static_cast<std::uint32_t>(y * data_of(full).tree.tiles_x + x), first, 3, 1});
        }
        count = 1u << s.segment_log2;
    }
    MeshView whole = drawn;
    whole.tiles = ranges;
    return check_mesh(full, whole);
}

namespace {

std::size_t place(const Terrain& t, Coord c) {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(data_of(t).tree.grid_columns()) +
           static_cast<std::size_t>(c.x);
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
    VertexSet set = only_corners(s.terrain_handle, false);
    for (std::uint32_t slot = 0; slot < s.terrain->slot_count; ++slot) {
        if (s.page_slot[slot].page == no_index) continue;
        for (std::uint32_t n = 0; n < s.shapes[s.page_slot[slot].shape].count * group_lanes; ++n) {
            const std::uint32_t vertex = slot * max_page_groups * group_lanes + n;
            if (active(s, vertex)) set[place(s.terrain_handle, site_coord(site_of(s, vertex)))] = true;
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
            const Coord corner{static_cast<std::int32_t>(tile % full.header().tiles_x) * data_of(full).tree.side(),
                               static_cast<std::int32_t>(tile / full.header().tiles_x) * data_of(full).tree.side()};
            for (std::uint32_t i = 0; i < data_of(full).pages.page_vertices(page); ++i) {
                const Coord c = corner + data_of(full).pages.coord({page, i});
                if (!data_of(full).tree.is_corner(c)) set[place(full, c)] = false;
            }
        }
    std::vector<Reach> reaches;
    for (const View& view : views) {
        const double px = view.error_px > 0 ? view.error_px : error_px;
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
                const Coord c{x, y};
                if (!set[place(full, c)]) continue;
                bool parents = true, in = false;
                for (const Coord parent : diamond(data_of(full).tree, c).apexes)
                    parents = parents && (!data_of(full).tree.contains(parent) || set[place(full, parent)]);
                if (parents) {
                    const TerrainData::Vertex v = data_of(full).vertex(c);
                    const Coord at = data_of(full).tree.sample(c);
                    for (const Reach& r : reaches)
                        in = in || wanted(r, full.x_m(at.x), v.height_m, full.z_m(at.y), v.error_m, v.radius_m);
                }
                set[place(full, c)] = in;
            }
    }
    return set;
}

std::vector<View> thresholds_over(double divisor, std::span<const View> views) {
    std::vector<View> result(views.begin(), views.end());
    for (View& view : result) view.error_px /= divisor;
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
