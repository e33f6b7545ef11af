// Horizons: how high the ground around a point stands, seen from it, in 15 directions; and how much of the sky it sees.
//
// N. Max, Horizon mapping: shadows for bump-mapped surfaces (1988); found over a pyramid of heights as J. Snyder and D.
// Nowrouzezahrai do, Fast Soft Self-Shadowing on Dynamic Height Fields (2008): a ray marches from each point with steps
// that grow with the distance, over near ground at full resolution, over far ground at levels whose vertices stand ever
// further apart. What is far is seen under a small angle, so what a coarse vertex leaves out hardly shows. Departure: a
// coarse vertex is a quarter the mean of the nine finer ones and three quarters the largest, as means lower ridges and
// the largest alone raises every slope; docs/notes/horizons.md has the errors against rays through every sample.
//
// A point's horizon follows from its place and the heights alone, never from the tile it is computed for: so borders
// are equal bit for bit, and memory is a window of every level around a tile, whatever the terrain's size. Units:
// metres; places in samples. Thread: pure functions. Complexity: O(points * log(terrain)). Nothing beyond the terrain's
// rim hides anything.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/maps/tent.h"
#include "baker/store/window.h"
#include "fjell/texture.h"

namespace fjell::baker {

// Vertex (x, y) of level l stands at sample (x << l, y << l), the last ones on the rim or a step beyond. Level 0: the
// heights themselves.
class HorizonLevels {
public:
    HorizonLevels() = default;
    HorizonLevels(std::int32_t columns, std::int32_t rows, const double (&spacing_m)[2]);

    [[nodiscard]] int count() const { return static_cast<int>(extents_.size()); }
    // Columns and rows of a level.
    [[nodiscard]] const Window& extents(int level) const { return extents_[static_cast<std::size_t>(level)]; }
    // Where level 1 and those above lie in one array: their extents in it, and its own.
    [[nodiscard]] Window place(int level) const;
    [[nodiscard]] Window array() const;
    [[nodiscard]] const double (&spacing_m() const)[2] { return spacing_m_; }

private:
    std::vector<Window> extents_;
    double spacing_m_[2] = {1, 1};
};

// A level's vertices from those of the level below. finer: `from` of that level, which holds all that they are made of
// (halved_from). to: at.area() floats.
[[nodiscard]] Window halved_from(const Window& finer_extents, const Window& at);
void halve_level(const float* finer, const Window& from, const Window& finer_extents, const Window& at, float* to);

// Points: every (1 << stride_log2)-th sample. The vertices of a level that rays from a window of points may meet; they
// may lie outside the level, where there is nothing.
[[nodiscard]] Window seen_of_level(int level, int stride_log2, const Window& points);

struct LevelWindow {
    Window at; // seen_of_level()
    std::vector<float> heights_m;
};
// Stands for no ground in a LevelWindow.
inline constexpr float no_ground_m = -1e30f;

// Of each point `horizon_planes` channels from 0 to 1, as fjell/texture.h says them: sines of the elevation of the
// horizon in 15 directions, and the share of the sky. seen: of every level.
[[nodiscard]] TexelPlanes horizons(const HorizonLevels& levels, int stride_log2, const Window& points,
                                   const std::vector<LevelWindow>& seen);

} // namespace fjell::baker
