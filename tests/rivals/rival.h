// One interface for every way to find a mesh, so that they can be compared: ours, and those of other people.
//
// A rival is built from a Ground, which is read from a pack once: all of them see the same heights, and those that take
// errors and radii take ours. refine() is what is timed; it leaves the mesh as the method would hand it to a renderer,
// and faces() spells that out afterwards. Places are in cells, heights in metres; samples lie row by row, `side + 1` a
// row. Ownership: a rival keeps a reference to its Ground, ours to the terrain too. Thread: one at a time.
// Failure: ground_of() throws std::invalid_argument, refine() of ours std::runtime_error.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fjell/sample_index.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

namespace fjell::rivals {

// A square of 2^n cells a side. Corners of the square have neither error nor radius: infinite.
struct Ground {
    std::int32_t side = 0; // cells
    float spacing_x_m = 1, spacing_z_m = 1;
    float min_m = 0, max_m = 0; // of all heights
    std::vector<float> height_m, error_m, radius_m;

    [[nodiscard]] std::uint32_t index(SampleIndex c) const {
        return static_cast<std::uint32_t>(c.row * (side + 1) + c.column);
    }
    [[nodiscard]] float x_m(std::int32_t column) const { return static_cast<float>(column) * spacing_x_m; }
    [[nodiscard]] float z_m(std::int32_t row) const { return static_cast<float>(row) * spacing_z_m; }
};
// terrain: all its pages loaded, without holes, one tile.
[[nodiscard]] Ground ground_of(const Terrain& terrain);
// What is looked at together, together: a miss of the caches a vertex, not three.
struct GroundVertex {
    float height_m, error_m, radius_m;
};
[[nodiscard]] std::vector<GroundVertex> vertices_of(const Ground& ground);
// The same ground with wedgies for errors (Duchaineau 1997, 4): what each split moves, added up from the leaves.
[[nodiscard]] Ground with_wedgies(const Ground& ground);

struct Corner {
    float column = 0, row = 0, height_m = 0;
    friend constexpr auto operator<=>(const Corner&, const Corner&) = default;
};
using Face = std::array<Corner, 3>; // counter-clockwise seen from above; some have no area

inline constexpr std::uint32_t unlimited_operations = 0xffffffff;

struct Refined {
    std::uint32_t triangles = 0;
    bool interrupted = false; // the operations did not suffice: the mesh is behind, and whole if the method promises it
};

// What a method is, as its paper has it.
struct Traits {
    bool interruptible = false; // can stop after any operation with a whole mesh
    bool coherent = false;      // goes on from the frame before
    bool culls = false;         // refines for the frustum only; the others all around
    bool bounded = false;       // claims that no error on screen is larger than the threshold
};

class Rival {
public:
    virtual ~Rival() = default;
    // operations: changes of the mesh that this frame may make; only interruptible methods count them.
    [[nodiscard]] virtual Refined refine(const View& view, double error_px, std::uint32_t operations) = 0;
    virtual void faces(std::vector<Face>& out) const = 0; // of the last refine(); replaces what is in `out`
    [[nodiscard]] virtual std::size_t bytes() const = 0;  // all that it holds, its part of the ground and the output
    [[nodiscard]] virtual Traits traits() const = 0;
};

// "incremental", "incremental-morph", "incremental-offscreen", "recursive", "lean", and what rival_names() has besides.
[[nodiscard]] const std::vector<std::string>& rival_names();
[[nodiscard]] std::unique_ptr<Rival> make_rival(const std::string& name, const Ground& ground, const Terrain& terrain);

} // namespace fjell::rivals
