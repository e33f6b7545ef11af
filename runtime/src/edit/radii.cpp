#include "edit/radii.h"

#include <cmath>

namespace fjell::edit {

RadiusTerms radius_terms(const TerrainData& t) {
    const PackHeader& h = t.header;
    RadiusTerms r{};
    const double extent = std::max({t.tree.grid_columns() * h.spacing_m[0], t.tree.grid_rows() * h.spacing_m[1], 1e4});
    const double least = h.min_m, most = h.max_m;
    r.ground_pad_m = extent * 0x1p-22;
    r.height_pad_m = (std::max(std::abs(least), std::abs(most)) + most - least) * 0x1p-22;
    r.half_quantum_m = 0.5 * static_cast<double>(h.quantum_m);
    r.quantum = h.quantum_m;
    r.height_pad = static_cast<float>(r.height_pad_m);
    r.leaf_pad = static_cast<float>(r.half_quantum_m);
    for (int z = 0; z < t.tree.tile_log2; ++z) {
        const double s = 1 << z;
        const auto ground = [&](double x, double y) {
            const double dx = x * h.spacing_m[0] + 2 * r.ground_pad_m, dy = y * h.spacing_m[1] + 2 * r.ground_pad_m;
            return static_cast<float>(dx * dx * (x != 0) + dy * dy * (y != 0));
        };
        r.along_x[z] = ground(s, 0);
        r.along_y[z] = ground(0, s);
        r.across[z] = ground(s / 2, s / 2);
        const int level = 2 * (t.tree.tile_log2 - 1 - z);
        r.unit_m[2 * z] = h.level_radius_m[level + 1];
        r.unit_m[2 * z + 1] = h.level_radius_m[level];
    }
    return r;
}

namespace {

// Radii of one step.
class RadiusStep {
public:
    // by_m: what heights have moved by at most, where radii can only be bounded.
    RadiusStep(const EditsData& e, const Ground& ground, int z, double by_m)
        : terms_(e.radius), ground_(ground), t_(ground.terrain), z_(z), by_m_(by_m) {}

    // Codes of a plane over squares, and stores them; whole blocks, which share one where the step has pages of its
    // own. Returns those that changed.
    [[nodiscard]] Rect plane(const Plane& plane, Rect squares, bool& all_loaded) {
        const std::int32_t size = t_.tree.tile_log2 - 1 - z_ >= page_squares_log2 ? 1 << radius_squares_log2 : 1;
        const Rect all = plane.all(t_.tree);
        squares = squares.within(all);
        Rect changed;
        if (squares.empty()) return changed;
        for (std::int32_t j = squares.y0 & -size; j <= squares.y1; j += size)
            for (std::int32_t i = squares.x0 & -size; i <= squares.x1; i += size) {
                const Rect block = Rect{i, j, i + size - 1, j + size - 1}.within(all);
                float most = 0;
                bool known = true;
                for (std::int32_t y = block.y0; y <= block.y1 && known; ++y)
                    for (std::int32_t x = block.x0; x <= block.x1 && known; ++x)
                        known = add(plane.at(x, y), plane.kind, most);
                all_loaded = all_loaded && known;
                const auto code = static_cast<std::uint8_t>(code_up(unit_m(plane), most));
                bool differs = false;
                for (std::int32_t y = block.y0; y <= block.y1; ++y)
                    for (std::int32_t x = block.x0; x <= block.x1; ++x)
                        differs = (known ? ground_.set_radius(plane, x, y, code) : contain(plane, x, y)) || differs;
                if (differs) changed = changed.with(block);
            }
        return changed;
    }

    // One vertex, which has to contain its children: those that are loaded, and the others wherever they may be by now.
    // Never less than it does. True: it was another radius.
    bool contain(const Plane& plane, std::int32_t i, std::int32_t j) {
        const SampleIndex v = plane.at(i, j);
        const Cell own = ground_.at(v);
        if (!own.loaded) return false;
        float most = 0;
        if (!add(v, plane.kind, most) && by_m_ > 0)
            most = std::max(most, unit_m(plane) * t_.radii.factor[own.radius] +
                                      static_cast<float>((levels_below(v) + 1) * by_m_ * (1 + 0x1p-10)));
        const std::uint32_t code = code_up(unit_m(plane), most);
        return code > own.radius && ground_.set_radius(plane, i, j, static_cast<std::uint8_t>(code));
    }

private:
    [[nodiscard]] float unit_m(const Plane& plane) const {
        return terms_.unit_m[2 * z_ + (plane.kind == VertexKind::centre ? 1 : 0)];
    }
    [[nodiscard]] std::uint32_t code_up(float unit_m, float radius_m) const {
        const double asked_m = static_cast<double>(radius_m) * sphere_margin;
        std::uint32_t below = 0; // how many codes are
        for (std::uint32_t step = radius_codes / 2; step != 0; step /= 2)
            below += step * static_cast<std::uint32_t>(static_cast<double>(unit_m * t_.radii.factor[below + step - 1]) <
                                                       asked_m);
        return below;
    }
    // steps: that one end is higher by.
    [[nodiscard]] float distance_m(float along_ground, std::int32_t steps) const {
        const float climb = static_cast<float>(steps) * terms_.quantum + terms_.height_pad;
        return std::sqrt(along_ground + climb * climb);
    }
    // most: of the radii so far. False: something is not loaded, and most is of the rest.
    [[nodiscard]] bool add(SampleIndex v, VertexKind kind, float& most) const {
        const Cell own = ground_.at(v);
        if (!own.loaded) return false;
        return kind != VertexKind::centre && z_ == 0 ? add_leaf(v, own, kind, most) : add_parent(v, own, kind, most);
    }
    // Contains the corners of its triangles.
    [[nodiscard]] bool add_leaf(SampleIndex v, const Cell& own, VertexKind kind, float& most) const {
        const bool along_x = kind == VertexKind::side_x;
        const float to_end = along_x ? terms_.along_x[0] : terms_.along_y[0],
                    to_apex = along_x ? terms_.along_y[0] : terms_.along_x[0];
        const Diamond d = diamond(t_.tree, v);
        std::int32_t end = 0, apex = 0; // largest differences: the larger one is farther away
        for (int k = 0; k < 2; ++k) {
            // An apex beyond the terrain stands where the vertex does.
            const Cell at_end = ground_.at(d.ends[k]),
                       at_apex = t_.tree.contains(d.apexes[k]) ? ground_.at(d.apexes[k]) : own;
            if (!at_end.loaded || !at_apex.loaded) return false;
            end = std::max(end, std::abs(at_end.steps - own.steps));
            apex = std::max(apex, std::abs(at_apex.steps - own.steps));
        }
        const float largest_m = std::max(distance_m(to_end, end), distance_m(to_apex, apex));
        most = std::max(most, (largest_m + terms_.leaf_pad) * radius_rounding);
        return true;
    }
    // Contains its children's spheres.
    [[nodiscard]] bool add_parent(SampleIndex v, const Cell& own, VertexKind kind, float& most) const {
        const bool centre = kind == VertexKind::centre;
        const float unit_m = terms_.unit_m[centre ? 2 * z_ : 2 * z_ - 1];
        struct Farthest { // of children that lie as far along the ground, and have one radius
            float along = 0;
            std::uint32_t radius = 0;
            std::int32_t climb = -1;
        } farthest;
        const auto add_farthest = [&] {
            if (farthest.climb < 0) return;
            const float radius_m = unit_m * t_.radii.factor[farthest.radius];
            most = std::max(most, (distance_m(farthest.along, farthest.climb) + radius_m) * radius_rounding);
        };
        bool known = true;
        for (const SampleIndex at : children(v).at) {
            if (!t_.tree.contains(at)) continue;
            const Cell child = ground_.at(at);
            if (!child.loaded) {
                known = false;
                continue;
            }
            const float along = !centre ? terms_.across[z_] : at.row == v.row ? terms_.along_x[z_] : terms_.along_y[z_];
            const std::int32_t climb = std::abs(child.steps - own.steps);
            if (farthest.climb >= 0 && farthest.along == along && farthest.radius == child.radius) {
                farthest.climb = std::max(farthest.climb, climb);
                continue;
            }
            add_farthest();
            farthest = {along, child.radius, climb};
        }
        add_farthest();
        return known;
    }

    const RadiusTerms& terms_;
    const Ground& ground_;
    const TerrainData& t_;
    int z_;
    double by_m_;
};

// told: followers look at all vertices around `places` anyway; otherwise what changes is noted, wherever it is.
bool nest(EditsData& e, const Ground& ground, const Rect& places, double by_m, int from_z, bool told) {
    const TerrainData& t = *e.terrain;
    bool all_loaded = true;
    Rect finer; // centres of the step before that stand or reach elsewhere
    for (int z = from_z; z < t.tree.tile_log2; ++z) {
        const Rect changed = told ? places : places.grown(radius_reach << z).within(grid_of(t.tree));
        RadiusStep step(e, ground, z, by_m);
        const auto nest_plane = [&](const Plane& plane, const Rect& squares) {
            const Rect differ = step.plane(plane, squares, all_loaded), moved = plane.places(differ);
            if (!differ.empty() && !(told && changed.grown(error_reach(plane.kind) << z).contains(moved)))
                push_change(e, moved, z);
            return differ;
        };
        Rect sides[2]; // along x, along y
        for (const int k : {0, 1}) {
            const bool along_x = k == 0;
            const Plane plane{z, along_x ? VertexKind::side_x : VertexKind::side_y};
            const Rect own = plane.squares(changed);
            Rect todo = z == 0 ? plane.squares(changed.grown(1)) : own;
            if (!finer.empty())
                todo = todo.with({finer.x0 >> 1, finer.y0 >> 1, (finer.x1 + (along_x ? 0 : 1)) >> 1,
                                  (finer.y1 + (along_x ? 1 : 0)) >> 1});
            sides[k] = nest_plane(plane, todo).with(own);
        }
        const Plane centres{z, VertexKind::centre};
        const Rect own = centres.squares(changed);
        Rect todo = own;
        if (!sides[0].empty()) todo = todo.with({sides[0].x0, sides[0].y0 - 1, sides[0].x1, sides[0].y1});
        if (!sides[1].empty()) todo = todo.with({sides[1].x0 - 1, sides[1].y0, sides[1].x1, sides[1].y1});
        finer = nest_plane(centres, todo).with(own);
    }
    return all_loaded;
}

} // namespace

bool nest_radii(EditsData& e, const Ground& ground, const Rect& changed, double by_m) {
    return nest(e, ground, changed, by_m, 0, true);
}

bool nest_radii_of_pages(EditsData& e, const Rect& places, int from_z) {
    return nest(e, Ground(*e.terrain, nullptr), places, 0, from_z, false);
}

void contain_children(const EditsData& e, const Ground& ground, const Plane& plane, std::int32_t i, std::int32_t j) {
    (void)RadiusStep(e, ground, plane.z, 0).contain(plane, i, j);
}

void push_change(EditsData& e, const Rect& places, int step_log2) {
    TerrainData& t = *e.terrain;
    e.changes[t.ground_changes++ % ground_change_log] = {{places.x0, places.y0}, {places.x1, places.y1}, step_log2};
}

} // namespace fjell::edit
