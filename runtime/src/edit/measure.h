// Errors and radii of vertices on ground that has been edited, such that they are what a bake gives.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// Heights from the window, and from the terrain beyond it.
struct Heights {
    const TerrainData& terrain;
    const Window* window; // or null
    const Tree& tree = terrain.tree;

    [[nodiscard]] Height at(SampleIndex v) const {
        if (window == nullptr || !window->rect.contains(v)) return height_at(terrain, v);
        const std::size_t k = window->index(v);
        return {window->steps[k], window->missing[k] == 0, window->hole[k] != 0};
    }
    [[nodiscard]] std::int32_t h(SampleIndex v) const { return at(v).steps; }
    [[nodiscard]] bool is_void(SampleIndex v) const { return terrain.has_voids() && at(v).hole; }
};

[[nodiscard]] RadiusTerms radius_terms(const TerrainData& t);

// Before its children count. least: what they ask for; a smaller error is not told from it.
struct OwnError {
    std::uint32_t code;
    bool exact; // false: some of what lies under its triangles is not loaded, or too much to be looked at; then a bound
};
[[nodiscard]] OwnError own_error(const EditsData& e, const Heights& heights, SampleIndex v, std::uint32_t least);

// What a vertex' children ask of its code; all: or those of them that are loaded.
struct Asked {
    std::uint32_t code;
    bool all;
};
[[nodiscard]] Asked asked_by_children(const TerrainData& t, SampleIndex v);

// Works out the radii of all vertices whose spheres may depend on the heights in `changed`, of all steps, and stores
// them. Those that change and are not around the places, because blocks share a code, are noted as changes; all
// that change, where told is false. by_m: what
// heights have changed by at most (from_z: and finer steps are left as they are), for spheres over pages that are not
// loaded. False: one has no code. O(places changed, and some hundreds a step).
[[nodiscard]] bool nest_radii(EditsData& e, const Heights& heights, const Rect& changed, double by_m, int from_z,
                              bool told);

// Raises the radius of one vertex to what those of its children that are loaded ask for.
void contain_children(EditsData& e, const Plane& plane, std::int32_t i, std::int32_t j);

// For those who follow (TerrainData::changed_ground).
void push_change(EditsData& e, const Rect& places, bool heights, std::int8_t step_log2);

} // namespace fjell::edit
