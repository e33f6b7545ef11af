// Height fields in memory: what tests and benchmarks make, read whole, bake and compare with. The baker itself never
// holds one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/check/verify.h"
#include "baker/georeference/open_source.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Heights in metres after scale and offset, row 0 = north, row by row. Every one is finite, also where there is a hole:
// there they continue the ground around it (fill.h), so that only what draws or stands on the ground has to ask.
struct Dem {
    std::int32_t columns = 0, rows = 0;
    std::vector<float> heights_m;    // columns * rows
    std::vector<std::uint8_t> voids; // columns * rows, 1: no height there, a hole; empty: none
    double spacing_m[2] = {1, 1};    // along columns, along rows; > 0
    double crs_origin[2] = {0, 0};   // of sample (0, 0) in CRS axes
    double crs_step[2] = {0, 0};     // between samples in CRS units; 0: what spacing_m is in them, if they count metres
    std::string crs_wkt;             // empty: none
    // The step that the source's numbers are multiples of (integer types: |scale|), 0 when not known.
    double native_quantum_m = 0;

    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    }
    [[nodiscard]] float at(std::int32_t x, std::int32_t y) const { return heights_m[index(x, y)]; }
    [[nodiscard]] bool is_void(std::int32_t x, std::int32_t y) const {
        return !voids.empty() && voids[index(x, y)] != 0;
    }
};

// How many samples are holes. O(samples).
[[nodiscard]] inline std::uint64_t void_count(const Dem& dem) {
    return static_cast<std::uint64_t>(std::count(dem.voids.begin(), dem.voids.end(), std::uint8_t{1}));
}

// A Dem as a source. Its voids are NaN to readers: the ground that it has under them is not handed out. Any number of
// readers at once.
class DemSource final : public HeightSource {
public:
    explicit DemSource(Dem dem);

    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override;
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override;
    // Holes where the Dem has voids; its own quantum. Throws Failure 1 when there is nothing but voids.
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override;
    [[nodiscard]] std::string identity() const override; // a hash of everything

private:
    Dem dem_;
};

// The whole of a source, voids filled as a bake fills them. Throws Failure as reading does. O(samples), one thread.
[[nodiscard]] Dem read_dem(const HeightSource& source);
[[nodiscard]] Dem read_dem(const std::vector<std::string>& paths, const ReadOptions& options);
[[nodiscard]] Dem read_dem(const std::string& path, const ReadOptions& options);

// A landscape's heights; threads: 0: all cores.
[[nodiscard]] Dem synthesise(const std::string& recipe_path, int threads = 0);
[[nodiscard]] Dem synthesise_text(const std::string& recipe_json, int threads = 0);

BakeSummary bake(Dem dem, const BakeOptions& options, const std::string& out_path);
[[nodiscard]] VerifyReport verify(const Terrain& terrain, const Dem* against, const Pack* bounds = nullptr);
[[nodiscard]] inline VerifyReport verify(const Terrain& terrain, std::nullptr_t, const Pack* bounds = nullptr) {
    return verify(terrain, static_cast<const HeightSource*>(nullptr), bounds);
}
// Compact, holes as the ground that the Dem has there.
void write_dem(const Dem& dem, const std::string& path);

} // namespace fjell::baker
