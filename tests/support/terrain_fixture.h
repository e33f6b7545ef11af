// Terrains for tests: made, baked, loaded, thrown away.
#pragma once

#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include "fjell/io/load.h"
#include "fjell/recursive.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/temporary_folder.h"

namespace fjell::test {

using Random = std::mt19937;
[[nodiscard]] double uniform(Random& random, double least, double most);
[[nodiscard]] int pick(Random& random, int least, int most);

enum class Shape { fractal, noise, spikes, steps, ramp, flat, count };
[[nodiscard]] baker::Dem random_dem(Random& random, std::int32_t columns, std::int32_t rows, Shape shape);

// Takes heights away: single samples, a ring, blobs, whole tiles, or all but a few. Changes nothing else.
void add_random_holes(Random& random, baker::Dem& dem, int tile_log2);

// Baked to a file and loaded back.
[[nodiscard]] io::LoadedPack bake_and_load(baker::Dem dem, baker::BakeOptions options = {});
// A random tiling of at most about `most_samples` samples.
[[nodiscard]] baker::BakeOptions small_bake(int tile_log2, double nesting = 0.05);

// A view that looks at the terrain from somewhere, often low and near.
[[nodiscard]] View random_view(Random& random, const Terrain& terrain);

// The same terrain as if nothing were missing: what is drawn of holes is what their vertices stand on.
class WithoutHoles {
public:
    explicit WithoutHoles(const Terrain& terrain) : data_(std::make_unique<TerrainData>(data_of(terrain))) {
        data_->header.voids = 0;
        data_->holes_made = false;
        HandleAccess::begin(*data_, terrain_);
    }
    [[nodiscard]] const Terrain& terrain() const { return terrain_; }

private:
    std::unique_ptr<TerrainData> data_; // its tables are the other one's
    Terrain terrain_;
};

// A terrain that loads its pages one by one.
struct PagedTerrain {
    PagedTerrain(const Pack& pack, const TerrainBudget& budget);
    io::AlignedMemory memory;
    Terrain terrain;
};

// A recursive method with its memory.
struct Recursive {
    Recursive(const Terrain& terrain, const RecursiveBudget& budget);
    FrameReport update(const View& view, const RefineSettings& settings);
    [[nodiscard]] MeshView mesh() const { return recursive_mesh(method); }
    io::AlignedMemory memory;
    RecursiveMethod method;
};
[[nodiscard]] RecursiveBudget ample_budget(const Terrain& terrain);

} // namespace fjell::test
