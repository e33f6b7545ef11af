#include "edit/radii.h"

#include <cmath>

namespace fjell::edit {

Pads pads_of(const PackHeader& h, const Tree& tree) {
    const double extent = std::max({tree.grid_columns() * h.spacing_m[0], tree.grid_rows() * h.spacing_m[1], 1e4});
    const double least = h.min_m, most = h.max_m;
    return {extent * 0x1p-22, (std::max(std::abs(least), std::abs(most)) + most - least) * 0x1p-22};
}

RadiusTerms radius_terms(const TerrainData& t) {
    const PackHeader& h = t.header;
    RadiusTerms r{};
    const Pads pads = pads_of(h, t.tree);
    r.ground_pad_m = pads.ground_m;
    r.height_pad_m = pads.height_m;
    r.half_quantum_m = 0.5 * static_cast<double>(h.quantum_m);
    r.quantum = h.quantum_m;
    r.side_edge_m = static_cast<float>(2 * std::min(h.spacing_m[0], h.spacing_m[1])) * (1 - 0x1p-10f);
    r.centre_edge_m = static_cast<float>(2 * std::hypot(h.spacing_m[0], h.spacing_m[1])) * (1 - 0x1p-10f);
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

// What a vertex' sphere contains, of one vertex or of several that share a code. Of what lies as far along the ground
// and has one radius only the greatest climb counts: floats round alike, so larger climbs never come out with smaller
// radii, and one root for all of them will do.
class Contents {
public:
    Contents() { std::fill(std::begin(climb_), std::end(climb_), nothing); }
    // way: of two distances along the ground.
    void see(std::uint32_t way, std::uint32_t radius, std::int32_t climb) {
        const std::uint32_t key = way * radius_codes + radius;
        if (climb <= climb_[key]) return;
        if (climb_[key] == nothing) seen_[seen_count_++] = static_cast<std::uint8_t>(key);
        climb_[key] = climb;
    }
    // f(way, radius, climb) of all that was seen, which is forgotten.
    template <typename F>
    void take(const F& f) {
        for (int k = 0; k < seen_count_; ++k) {
            std::int32_t& climb = climb_[seen_[k]];
            f(seen_[k] / radius_codes, seen_[k] % radius_codes, climb);
            climb = nothing;
        }
        seen_count_ = 0;
    }

private:
    static_assert(radius_codes == 128, "a way and a radius are a byte of seen_");
    static constexpr std::int32_t nothing = -1;
    std::int32_t climb_[2 * radius_codes];
    std::uint8_t seen_[2 * radius_codes];
    int seen_count_ = 0;
};

// Where cells are read: in a window that has all around them, or wherever they are.
struct InWindow {
    using Place = const Cell*;
    using Way = std::ptrdiff_t;
    Window& window;
    [[nodiscard]] Place place(SampleIndex v) const { return &window.at(v); }
    [[nodiscard]] static Way way(SampleIndex off) { return off.row * window_side + off.column; }
    [[nodiscard]] static bool has(Place, Way) { return true; }
    [[nodiscard]] static bool is_loaded(const Cell&) { return true; }
    [[nodiscard]] static const Cell& at(Place place, Way way) { return place[way]; }
};
struct Anywhere {
    using Place = SampleIndex;
    using Way = SampleIndex;
    const Ground& ground;
    [[nodiscard]] static Place place(SampleIndex v) { return v; }
    [[nodiscard]] static Way way(SampleIndex off) { return off; }
    [[nodiscard]] bool has(Place place, Way way) const { return ground.tree.contains(place + way); }
    [[nodiscard]] static bool is_loaded(const Cell& cell) { return cell.loaded; }
    [[nodiscard]] Cell at(Place place, Way way) const { return ground.at(place + way); }
};

// Radii of planes.
class Nesting {
public:
    // by_m: what heights have moved by at most, where radii can only be bounded.
    Nesting(const EditsData& e, const Ground& ground, double by_m)
        : terms_(e.radius), ground_(ground), t_(ground.terrain), by_m_(by_m) {}

    // Codes of a plane over squares, and stores them; whole blocks, which share one where the step has pages of its
    // own. Returns those that changed.
    [[nodiscard]] Rect plane(const Plane& plane, Rect squares, bool& all_loaded) {
        const std::int32_t size = t_.tree.tile_log2 - 1 - plane.z >= page_squares_log2 ? 1 << radius_squares_log2 : 1;
        const Rect all = plane.all(t_.tree);
        squares = squares.within(all);
        Rect changed;
        if (squares.empty()) return changed;
        for (std::int32_t j = squares.y0 & -size; j <= squares.y1; j += size)
            for (std::int32_t i = squares.x0 & -size; i <= squares.x1; i += size) {
                const Rect block = Rect{i, j, i + size - 1, j + size - 1}.within(all);
                const bool known = see(plane, block);
                const auto code = static_cast<std::uint8_t>(code_up(unit_m(plane), radius_m(plane)));
                all_loaded = all_loaded && known;
                bool differs = false;
                if (known) {
                    differs = ground_.set_radii(plane, block, code);
                } else {
                    for (std::int32_t y = block.y0; y <= block.y1; ++y)
                        for (std::int32_t x = block.x0; x <= block.x1; ++x) differs = contain(plane, x, y) || differs;
                }
                if (differs) changed = changed.with(block);
            }
        return changed;
    }

    // One vertex, which has to contain its children: those that are loaded, and the others wherever they may be by now.
    // Never less than it does. True: it was another radius.
    bool contain(const Plane& plane, std::int32_t i, std::int32_t j) {
        const Cell own = ground_.at(plane.at(i, j));
        if (!own.loaded) return false;
        const bool known = see(plane, {i, j, i, j});
        float most = radius_m(plane);
        if (!known && by_m_ > 0)
            most = std::max(most, unit_m(plane) * t_.radii.factor[own.radius] +
                                      static_cast<float>((2 * plane.z + 1 + (plane.kind == VertexKind::centre)) *
                                                         by_m_ * (1 + 0x1p-10)));
        const std::uint32_t code = code_up(unit_m(plane), most);
        return code > own.radius && ground_.set_radii(plane, {i, j, i, j}, static_cast<std::uint8_t>(code));
    }

private:
    [[nodiscard]] float unit_m(const Plane& plane) const {
        return terms_.unit_m[2 * plane.z + (plane.kind == VertexKind::centre ? 1 : 0)];
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
    // The radius that what was seen asks for.
    [[nodiscard]] float radius_m(const Plane& plane) {
        const auto [z, kind] = plane;
        float most = 0;
        if (kind != VertexKind::centre && z == 0) { // the corners of its triangles: ends, and apexes
            const bool along_x = kind == VertexKind::side_x;
            const float along[2] = {along_x ? terms_.along_x[0] : terms_.along_y[0],
                                    along_x ? terms_.along_y[0] : terms_.along_x[0]};
            contents_.take([&](std::uint32_t way, std::uint32_t, std::int32_t climb) {
                most = std::max(most, (distance_m(along[way], climb) + terms_.leaf_pad) * radius_rounding);
            });
            return most;
        }
        const bool centre = kind == VertexKind::centre;
        const float unit_m = terms_.unit_m[centre ? 2 * z : 2 * z - 1];
        const float along[2] = {centre ? terms_.along_x[z] : terms_.across[z], terms_.along_y[z]};
        contents_.take([&](std::uint32_t way, std::uint32_t radius, std::int32_t climb) {
            most = std::max(most, (distance_m(along[way], climb) + unit_m * t_.radii.factor[radius]) * radius_rounding);
        });
        return most;
    }

    // What the spheres of these vertices contain. False: something is not loaded, and is not among it.
    [[nodiscard]] bool see(const Plane& plane, const Rect& block) {
        Window* const w = ground_.window();
        if (w != nullptr && w->loaded && w->rect.contains(plane.places(block).grown(1 << plane.z)))
            return see_in(plane, block, InWindow{*w});
        return see_in(plane, block, Anywhere{ground_});
    }
    template <typename Cells>
    [[nodiscard]] bool see_in(const Plane& plane, const Rect& block, const Cells& cells) {
        const std::int32_t s = 1 << plane.z, h = s / 2;
        const auto ways = [&](SampleIndex a, SampleIndex b, const auto& f) {
            return f(Cells::way({-a.column, -a.row}), Cells::way(a), Cells::way({-b.column, -b.row}), Cells::way(b));
        };
        const SampleIndex along_x{s, 0}, along_y{0, s};
        if (plane.kind == VertexKind::centre)
            return ways(along_x, along_y, [&](auto... way) { return see_all<1, 1>(plane, block, cells, way...); });
        if (plane.z != 0)
            return ways({h, h}, {h, -h}, [&](auto... way) { return see_all<0, 1>(plane, block, cells, way...); });
        // A leaf's are the corners of its triangles: the ends first.
        const bool x_first = plane.kind == VertexKind::side_x;
        return ways(x_first ? along_x : along_y, x_first ? along_y : along_x,
                    [&](auto... way) { return see_all<1, 0>(plane, block, cells, way...); });
    }
    // two_ways: are a and b nearer or farther along the ground than c and d? radii: have they any?
    template <std::uint32_t two_ways, std::uint32_t radii, typename Cells, typename Way = typename Cells::Way>
    [[nodiscard]] bool see_all(const Plane& plane, const Rect& block, const Cells& cells, Way a, Way b, Way c, Way d) {
        bool known = true;
        struct Run { // of children that have one radius, as most that lie beside each other do
            std::uint32_t radius = 0;
            std::int32_t climb = -1;
        } ab, cd;
        const auto end = [&](std::uint32_t number, const Run& run) { contents_.see(number, run.radius, run.climb); };
        for (std::int32_t j = block.y0; j <= block.y1; ++j)
            for (std::int32_t i = block.x0; i <= block.x1; ++i) {
                const auto v = cells.place(plane.at(i, j));
                const Cell own = cells.at(v, {});
                if (!Cells::is_loaded(own)) {
                    known = false;
                    continue;
                }
                const auto see_child = [&](std::uint32_t number, Run& run, Way way) {
                    if (!cells.has(v, way)) return;
                    const Cell child = cells.at(v, way);
                    if (!Cells::is_loaded(child)) {
                        known = false;
                        return;
                    }
                    const std::uint32_t radius = child.radius * radii;
                    const std::int32_t climb = std::abs(child.steps - own.steps);
                    if (radius != run.radius) {
                        end(number, run);
                        run = {radius, climb};
                    } else {
                        run.climb = std::max(run.climb, climb);
                    }
                };
                see_child(0, ab, a), see_child(0, ab, b);
                see_child(two_ways, cd, c), see_child(two_ways, cd, d);
            }
        end(0, ab), end(two_ways, cd);
        return known;
    }

    const RadiusTerms& terms_;
    const Ground& ground_;
    const TerrainData& t_;
    double by_m_;
    Contents contents_;
};

// told: followers look at all vertices around `places` anyway; otherwise what changes is noted, wherever it is.
bool nest(EditsData& e, const Ground& ground, const Rect& places, double by_m, int from_z, bool told) {
    const TerrainData& t = *e.terrain;
    bool all_loaded = true;
    const auto changed = [&](int z) { // where vertices stand or reach elsewhere, whatever their children do
        return told ? places : places.grown(radius_reach << z).within(grid_of(t.tree));
    };
    Nesting nesting(e, ground, by_m);
    go_up(
        from_z, t.tree.tile_log2 - 1,
        [&](const Plane& plane) {
            const bool leaf = plane.z == 0 && plane.kind != VertexKind::centre;
            return plane.squares(changed(plane.z).grown(leaf ? 1 : 0));
        },
        [&](const Plane& plane, const Rect& squares) {
            const Rect differ = nesting.plane(plane, squares, all_loaded), moved = plane.places(differ);
            if (!differ.empty() && !(told && places.grown(error_reach(plane.kind) << plane.z).contains(moved)))
                push_change(e, moved, plane.z);
            return differ.with(plane.squares(changed(plane.z)));
        });
    return all_loaded;
}

} // namespace

bool nest_radii(EditsData& e, const Ground& ground, const Rect& changed, double by_m) {
    return nest(e, ground, changed, by_m, 0, true);
}

bool nest_radii_of_pages(EditsData& e, const Rect& places, int from_z, Missing& missing) {
    Ground ground(*e.terrain, nullptr);
    ground.missing = &missing;
    return nest(e, ground, places, 0, from_z, false);
}

void contain_children(const EditsData& e, const Ground& ground, const Plane& plane, std::int32_t i, std::int32_t j) {
    (void)Nesting(e, ground, 0).contain(plane, i, j);
}

void push_change(EditsData& e, const Rect& places, int step_log2, bool holes) {
    TerrainData& t = *e.terrain;
    e.changes[t.ground_changes++ % ground_change_log] = {
        {places.x0, places.y0}, {places.x1, places.y1}, step_log2, holes};
}

} // namespace fjell::edit
