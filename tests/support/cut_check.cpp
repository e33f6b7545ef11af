#include "support/cut_check.h"

#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "cut/change.h"
#include "cut/mesh.h"
#include "cut/pages.h"

namespace fjell::test {

Cut::Cut(const Terrain& terrain, const CutBudget& budget) {
    const std::size_t bytes = cut_bytes(terrain, budget);
    block = host::make_block(bytes);
    const Status made = create_cut(terrain, budget, {block.get(), bytes}, cut);
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
        for (std::uint32_t chunk = s.tiles[tile].last_chunk; chunk != nil; chunk = s.chunk_below[chunk]) {
            ranges.push_back({tile, (chunk << s.chunk_log2) * 3, count * 3, count});
            count = 1u << s.chunk_log2;
        }
    }
    MeshView view = cut_mesh(cut).mesh;
    view.tiles = ranges;
    return view;
}

CutBudget ample_cut(const Terrain& terrain, std::uint32_t views) {
    const std::uint32_t samples = static_cast<std::uint32_t>(terrain.tree.lattice_columns()) *
                                  static_cast<std::uint32_t>(terrain.tree.lattice_rows());
    CutBudget budget;
    budget.vertices = samples + 16;
    budget.chunk_triangles = 16;
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
    return s.blocks[vertex / block_lanes].active >> vertex % block_lanes & 1;
}

std::string check_vertex(const CutState& s, std::uint32_t vertex, std::vector<bool>& slot_used) {
    const Site site = site_of(s, vertex);
    const BlockState& b = s.blocks[vertex / block_lanes];
    const std::uint32_t lane = vertex % block_lanes;
    const auto bit = [&](std::uint16_t mask) { return (mask >> lane & 1) != 0; };
    if (!exists(s, site) || find_vertex(s, site) != vertex) {
        if (b.active >> lane & 1) return say("a vertex is active where it is not owned:", s, vertex);
        if (b.ready() >> lane & 1) return say("a vertex is ready where it is not owned:", s, vertex);
        return {};
    }
    if (bit(b.active) && !bit(b.ready())) return say("an active vertex' parent is not active:", s, vertex);
    const bool leaf = site.kind != PlaneKind::centre && site.z == 0;
    for (int d = 0; d < 4; ++d) {
        bool child = false;
        if (!leaf && exists(s, child_site(site, d))) {
            const std::uint32_t found = find_vertex(s, child_site(site, d));
            child = found != no_vertex && active(s, found);
        }
        if (bit(b.child[d]) != child) return say("a child mask is wrong at", s, vertex);
        if (!bit(b.active)) continue;
        const std::uint32_t slot = s.slots[vertex];
        if (slot >= s.budget.vertices) return say("no vertex slot for", s, vertex);
        const bool drawn = s.made[slot * 4 + static_cast<std::uint32_t>(d)] != nil;
        // At the rim no triangle lies beyond; a leaf has no children to say so.
        bool expected = !child;
        if (!leaf) expected = expected && exists(s, child_site(site, d));
        if (!leaf && drawn != expected) return say("a triangle is missing, or is one too many, at", s, vertex);
    }
    if (bit(b.active)) {
        const std::uint32_t slot = s.slots[vertex];
        if (slot_used[slot]) return say("two vertices have one slot:", s, vertex);
        slot_used[slot] = true;
        const Coord at = s.terrain->tree.sample(site_coord(site));
        if (s.vertices[slot].column != at.x || s.vertices[slot].row != at.y)
            return say("a vertex slot is another vertex':", s, vertex);
    }
    return {};
}

std::string check_block(const CutState& s, std::uint32_t number) {
    const BlockState& b = s.blocks[number];
    const SlotInfo& info = s.slot_info[number / max_page_blocks];
    const ParentMasks parents = parents_of(s, number);
    if (b.parent[0] != parents.parent[0] || b.parent[1] != parents.parent[1])
        return say("a parent mask is wrong in the block of", s, number * block_lanes);
    const bool draining = info.status == SlotStatus::draining;
    const std::uint32_t inactive = draining ? 0u : static_cast<std::uint32_t>(b.ready() & ~b.active);
    const auto childless = static_cast<std::uint32_t>(b.active & ~b.parental());
    const ListId list = list_of(s.lists, number);
    if ((inactive | childless) != 0 && list == no_list && !draining)
        return say("nobody will look at the block of", s, number * block_lanes);
    if (list >= due_lists) return {};
    // In the calendar: how far may it go, and how far will it?
    const std::uint32_t grade = b.grade;
    const double left_m =
        list >= soon_lists
            ? 0
            : (static_cast<double>(std::uint64_t{b.due_high} << 32 | b.due) + 1) * s.lists.tick_m -
                  s.lists.odometer_m[grade];
    for (std::uint32_t lane = 0; lane < block_lanes; ++lane) {
        if (!((inactive | childless) >> lane & 1)) continue;
        const std::uint32_t vertex = number * block_lanes + lane;
        const Coord c = site_coord(site_of(s, vertex)), at = s.terrain->tree.sample(c);
        const Terrain::Vertex v = s.terrain->vertex(c);
        const bool on = childless >> lane & 1;
        double margin = -1e300;
        bool in = false;
        for (std::uint32_t i = 0; i < s.view_count; ++i) {
            const Reach& r = on ? s.decision.keep[i] : s.decision.reach[i];
            in = in || wanted(r, s.terrain->x_m(at.x), v.height_m, s.terrain->z_m(at.y), v.error_m, v.radius_m);
            const Vec3 way{s.terrain->x_m(at.x) - r.eye_x, v.height_m - r.eye_y, s.terrain->z_m(at.y) - r.eye_z};
            margin = std::max(margin, (static_cast<double>(v.radius_m) + static_cast<double>(v.error_m) * r.q) -
                                          length(way));
        }
        if (in != on) return say("a vertex disagrees with the decision, and nobody knows:", s, vertex);
        if (left_m > std::abs(margin) * (1 + 1e-4) + s.lists.tick_m * 1.01)
            return say("a vertex could change before it is looked at:", s, vertex);
        if (v.error_code >> grade_codes_log2 > grade) return say("a block's grade is too low:", s, vertex);
    }
    return {};
}

std::string check_triangles(const CutState& s) {
    std::vector<bool> chunk_used(s.chunk_count);
    for (std::uint32_t i = 0; i < s.free_chunk_count; ++i) {
        if (chunk_used[s.free_chunks[i]]) return "a chunk is free twice";
        chunk_used[s.free_chunks[i]] = true;
    }
    std::uint32_t named = 0;
    for (std::uint32_t tile = 0; tile <= s.terrain->tile_count(); ++tile) {
        const TileList& list = s.tiles[tile];
        std::uint32_t count = list.in_last, total = 0;
        for (std::uint32_t chunk = list.last_chunk; chunk != nil; chunk = s.chunk_below[chunk]) {
            if (chunk_used[chunk]) return "a chunk is used twice";
            chunk_used[chunk] = true;
            if (s.chunk_tile[chunk] != tile) return "a chunk does not know its tile";
            if (count == 0) return "an empty chunk is kept";
            total += count;
            for (std::uint32_t i = 0; i < count; ++i) {
                const std::uint32_t slot = (chunk << s.chunk_log2) + i;
                if (s.made[s.names[slot]] != slot) return "a triangle's name leads elsewhere";
                if (s.names[slot] / 4 != s.indices[std::size_t{slot} * 3]) return "a triangle's right angle is not its maker's";
                const MeshTriangle t{s.indices[std::size_t{slot} * 3], s.indices[std::size_t{slot} * 3 + 1],
                                     s.indices[std::size_t{slot} * 3 + 2]};
                if (s.some_hidden && is_hidden(s, t) != (tile == hidden_tile(s))) return "a triangle is hidden wrongly";
                ++named;
            }
            count = 1u << s.chunk_log2;
        }
        if (total != list.total) return "a tile counts its triangles wrongly";
    }
    for (const bool used : chunk_used)
        if (!used) return "a chunk is lost";
    std::uint32_t made = 0;
    for (std::size_t i = 0; i < std::size_t{s.budget.vertices} * 4; ++i) made += s.made[i] != nil;
    return made == named ? "" : "a triangle is made that no tile has";
}

} // namespace

std::string check_cut(Cut& cut) {
    const CutState& s = cut.state();
    std::vector<bool> slot_used(s.budget.vertices);
    const auto corners = static_cast<std::uint32_t>((s.tiles_x + 1) * (s.tiles_y + 1));
    for (std::uint32_t i = 0; i < corners; ++i) slot_used[i] = true;
    for (std::uint32_t slot = 0; slot < s.terrain->slot_count; ++slot) {
        const SlotInfo& info = s.slot_info[slot];
        if (info.page == no_page) continue;
        std::uint32_t count = 0;
        for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) {
            const std::uint32_t number = slot * max_page_blocks + n;
            for (std::uint32_t lane = 0; lane < s.shapes[info.shape].blocks[n].lanes; ++lane) {
                if (std::string wrong = check_vertex(s, number * block_lanes + lane, slot_used); !wrong.empty())
                    return wrong;
                count += active(s, number * block_lanes + lane);
            }
            if (std::string wrong = check_block(s, number); !wrong.empty()) return wrong;
        }
        if (count != info.active) return "a page counts its active vertices wrongly";
    }
    for (std::uint32_t i = 0; i < s.free_vertex_count; ++i) {
        if (slot_used[s.free_vertices[i]]) return "a vertex slot is free and used";
        slot_used[s.free_vertices[i]] = true;
    }
    for (const bool used : slot_used)
        if (!used) return "a vertex slot is lost";
    return check_triangles(s);
}

} // namespace fjell::test
