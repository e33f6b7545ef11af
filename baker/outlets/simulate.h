// A height field as ground for robots: the files that a physics engine loads, and how far what it collides with lies
// from the samples.
//
// Axes are the engines': x east, y north, z up, metres; sample (0, 0), the north-west corner, lies at (0, 0), so that
// y is negative to the south. All files speak of the same ground:
//   mujoco  terrain.hfield, every sample as a float, and terrain.xml, which an MJCF includes;
//   sdf     a model for Gazebo: model.config, model.sdf with terrain.obj for both looks and collisions, and
//           heightmap.sdf with heightmap.png, a square of 2^n + 1 samples of 16 bits, for looks;
//   urdf    terrain.urdf and terrain.obj, for Bullet, DART and whatever reads URDF.
// terrain.obj is the mesh of mesh_heights(): triangles as Fjell draws them, within max_error_m. MuJoCo cuts every cell
// of its height fields the same way, from south-west to north-east, where Fjell's diagonals alternate:
// SimulateSummary::diagonal_error_m says how far apart that leaves them. ground.json beside them holds the summary.
// O(samples); memory: 9 bytes a sample, and the mesh's. Throws Failure: 1 for holes that are not filled, 3 the disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/outlets/height_mesh.h"
#include "baker/read/source.h"

namespace fjell::baker {

inline constexpr const char* simulator_names[] = {"mujoco", "sdf", "urdf"};
enum class Simulator : std::uint8_t { mujoco, sdf, urdf };

struct SimulateOptions {
    Simulator simulator = Simulator::mujoco;
    double max_error_m = 0.05;      // of terrain.obj
    std::optional<MeshArea> area{}; // where that holds; beyond it more is allowed
    int threads = 0;                // 0: all cores
    Progress progress{};
};

struct SimulateSummary {
    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};
    double crs_origin[2] = {0, 0}; // of sample (0, 0)
    float min_m = 0, max_m = 0;
    std::vector<std::string> files; // in the folder
    // Of terrain.obj: the largest distance of a sample from it, and within the area alone.
    std::uint64_t vertices = 0, triangles = 0;
    double true_error_m = 0, area_error_m = 0;
    // Of terrain.hfield: how far its surface lies from Fjell's full resolution, at most, for its diagonals; and how far
    // a height was rounded.
    double diagonal_error_m = 0, rounding_error_m = 0;
    double heightmap_quantum_m = 0; // of heightmap.png
};

// Writes into the folder, which is made if need be; each file is replaced whole.
SimulateSummary simulate(const HeightSource& source, const SimulateOptions& options, const std::string& folder);

} // namespace fjell::baker
