// What an experiment's cases fly over: heights, packs of them baked as the cases want, and views.
//
// Packs are kept in a folder and baked once for each name, which says all that they depend on but the code. Holds one
// pack and one lean recursion loaded at a time. Thread: one. Failure: io::Failure as reading, synthesis and baking do.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/lean_recursion.h"
#include "fjell/io/load.h"
#include "fjell/view.h"
#include "lab/draw.h"
#include "lab/recipe.h"
#include "rivals/rival.h"
#include "support/dem.h"

namespace fjell::lab {

// The lean recursion takes a square: an oblong terrain is several, side by side, each refined by itself. So vertices on
// the borders between them may differ from one terrain's, by what their errors know of one side only.
struct LeanSquare {
    std::unique_ptr<bench::LeanRecursion> recursion;
    double x_m = 0, z_m = 0; // of its first sample
};

// A rival over a pack of one tile, and what it is flown in turns with.
struct Bout {
    rivals::Ground ground;
    std::unique_ptr<rivals::Rival> lean, rival;
};

class World {
public:
    // source_root: where recipes' paths start. packs: a folder.
    World(Site site, std::string source_root, std::string real_folder, std::string packs);

    [[nodiscard]] const Terrain& terrain(const Case& c);
    [[nodiscard]] double bake_s(const Case& c); // of its pack: errors, radii, encoded pages; one thread
    [[nodiscard]] const std::vector<LeanSquare>& lean(const Case& c);
    // Null where there is no OpenGL: that is said once, on the error output.
    [[nodiscard]] Drawing* drawing(const Case& c);
    // The last one stays: some take a minute to build, and fly several speeds.
    [[nodiscard]] Bout& bout(const Case& c, int tile_cells);
    [[nodiscard]] std::vector<View> views(const Case& c, int frames);
    [[nodiscard]] std::size_t samples();
    // For both methods: a slot for each vertex of the finest mesh, or two million.
    [[nodiscard]] std::uint32_t vertex_slots();
    [[nodiscard]] double cell_m() { return std::min(dem().spacing_m[0], dem().spacing_m[1]); }

private:
    const baker::Dem& dem();
    const io::LoadedPack& loaded(const Case& c);
    std::string pack(const baker::Dem& heights, int tile_log2, const Case& c, const std::string& part);

    Site site_;
    std::string source_root_, real_folder_, packs_;
    std::optional<baker::Dem> dem_;
    std::string loaded_name_, lean_name_, bout_name_;
    io::LoadedPack loaded_;
    std::vector<LeanSquare> lean_;
    std::unique_ptr<Drawing> drawing_; // of loaded_
    bool cannot_draw_ = false;
    std::unique_ptr<Bout> bout_; // rivals refer to its ground
};

} // namespace fjell::lab
