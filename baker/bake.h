// From heights to a pack: quantise -> errors and radii -> tiles -> textures -> write (thesis 5.3, DESIGN section 5).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "baker/colour.h"
#include "baker/dem.h"
#include "fjell/pack.h"
#include "fjell/record.h"
#include "fjell/tree.h"
#include "pack/page.h"

namespace fjell::baker {

// stage: what is being done; done, total: in units of the stage (samples or tiles).
using Progress = std::function<void(const char* stage, std::uint64_t done, std::uint64_t total)>;

struct BakeOptions {
    int tile_log2 = 0; // 0: auto
    Estimate estimate = Estimate::max;
    double nesting = 0.05; // mu, 0.001..1
    Order order = Order::planar;
    double quantum_m = 0;     // the vertical lattice's step; 0: the source's own, or the smallest that is of use
    int threads = 0;          // 0: all cores; the pack does not depend on it
    std::string texture_path; // an image over the whole DEM; empty: none
    std::string ramp_path;    // colours by height; empty: meadows to snow when there is no texture
    std::uint32_t max_texture_log2 = 10;
    int compression = 6; // zstd level
    Progress progress;
};

struct BakeSummary {
    std::int32_t columns = 0, rows = 0;
    Tree tree;
    float quantum_m = 0;
    float max_error_m = 0;
    std::uint64_t voids = 0; // samples that are holes
    std::uint64_t file_bytes = 0, geometry_bytes = 0, directory_bytes = 0, texture_bytes = 0;
    double seconds_errors = 0, seconds_textures = 0, seconds_total = 0;
};

// The vertical lattice for a DEM: the source's own step when 65,536 of it span every tile (lossless); otherwise the
// smallest that does, but not less than a centimetre or a hundredth of the spacing. asked_m: 0, or the step to use; a
// Failure says the least possible one.
[[nodiscard]] Lattice choose_lattice(const Dem& dem, const Tree& tree, double asked_m = 0);
// Lattice steps of every sample.
[[nodiscard]] std::vector<std::int32_t> quantise(const Dem& dem, const Lattice& lattice);

// Error and radius codes of every vertex, also beyond the rim: row-major over tree.lattice_columns() x lattice_rows(),
// on the scales beside them (fjell/record.h). Corners of tiles: zero.
struct VertexErrors {
    std::vector<std::uint8_t> error, radius;
    float floor_m = 1, ratio = 1.05f; // of the scale
    std::uint32_t nesting_steps = 1;
    ErrorScale scale;
    RadiusScale radii = RadiusScale::make();
    float level_radius_m[2 * max_tile_log2] = {};
    float max_error_m = 0;
};
struct ErrorInput {
    const Dem& dem; // for spacing and voids; dem.columns == tree.columns(), dem.rows == tree.rows()
    const std::vector<std::int32_t>& steps;
    Lattice lattice;
    Tree tree;
    Estimate estimate = Estimate::max;
    double nesting = 0.05;
    int threads = 1;
};
[[nodiscard]] VertexErrors compute_errors(const ErrorInput& input, const Progress& progress = {});

// One page before compression. Errors are left out when a reader can tell them from the heights.
struct PageInput {
    const Dem& dem; // for voids
    const std::vector<std::int32_t>& steps;
    const VertexErrors& errors;
    Tree tree;
    PageLayout pages;
    const LeafErrors& leaf;
};
[[nodiscard]] std::vector<std::byte> pack_page(const PageInput& input, std::uint32_t tile, std::uint32_t page);

// Bakes to OUT beside its place and renames; nothing is left behind on failure. Throws Failure.
BakeSummary bake(Dem dem, const BakeOptions& options, const std::string& out_path);

// Tile size for `auto`: 512 cells, more when the terrain would have over 1,024 tiles, fewer when one tile covers it.
[[nodiscard]] int auto_tile_log2(std::int32_t columns, std::int32_t rows);

} // namespace fjell::baker
