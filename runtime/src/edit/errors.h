// Errors of vertices on ground that has been edited: measured as a bake measures them, or bounded.
#pragma once

#include "edit/radii.h"
#include "edit/state.h"

namespace fjell::edit {

// What a vertex' children ask of its code; all: or those of them that are loaded.
struct Asked {
    std::uint32_t code;
    bool all;
};
[[nodiscard]] Asked asked_by_children(const Ground& ground, SampleIndex v);

// What a vertex' code has to be: for the ground under its triangles, and for its children.
struct Measured {
    std::uint32_t code;
    bool exact; // false: something there is not loaded, or too much to be looked at; then a bound
};
[[nodiscard]] Measured measure(const EditsData& e, const Ground& ground, SampleIndex v, const Asked& asked);

// A code whose error is larger by so much, or more. 255 may be too small: fits_codes() refuses what needs more.
[[nodiscard]] std::uint32_t grown(const TerrainData& t, std::uint32_t code, double by_m);
// What a vertex' code is at most, if its own error and those of all its descendants have grown by by_m(log2 of their
// step); may be more than 255.
template <typename By>
[[nodiscard]] std::uint32_t grown_with_descendants(const TerrainData& t, SampleIndex v, std::uint32_t code,
                                                   const By& by_m) {
    const std::uint32_t levels = levels_below(v);
    std::uint32_t most = code;
    for (std::uint32_t d = 0; d <= levels; ++d) { // one d levels below is smaller by what nesting asks for
        const std::uint32_t nested = d * t.errors.nesting_steps, of = code > nested ? code - nested : 0;
        const double grown_m = static_cast<double>(t.errors.metres[of]) + by_m(static_cast<int>(levels - d) / 2);
        if (grown_m > static_cast<double>(t.errors.metres[255])) return 256;
        most = std::max(most, t.errors.code_up(grown_m) + nested);
    }
    return most;
}

// The longest edge of a triangle under a diamond of this step whose corners' heights are within climb_m, and what
// heights there may be off by: what the rim of a hole may ask for.
[[nodiscard]] double rim_m(const PackHeader& header, const Pads& pads, int z, double climb_m);
// A code with room for a rim anywhere under a vertex, and under what is below it.
[[nodiscard]] std::uint8_t rim_code(const EditsData& e, SampleIndex v);
// What a vertex' error is at most where samples under its diamond have become holes, or ground at heights within
// `filled`.
[[nodiscard]] double rim_around_m(const EditsData& e, const Ground& ground, SampleIndex v, const StepRange& filled);

// Errors of all vertices around what has changed: they bound the new ground, and nest. Returns the step (its log2) from
// which on they may be larger than a bake's.
[[nodiscard]] int raise_errors(EditsData& e, const Ground& ground, const Change& change);

// The largest error of all (TerrainData::range).
void note_error(TerrainData& t, std::uint32_t code);

} // namespace fjell::edit
