// Does a pack keep its promises? Invariants 2 and 3 over every vertex and sample.
#pragma once

#include <cstdint>
#include <string>

#include "baker/read/source.h"
#include "fjell/io/pack_file.h"
#include "fjell/terrain.h"

namespace fjell::baker {

// What the directory says of a page (PageBound) against the page itself.

// Empty: the bound holds for every vertex of the page, and no narrower one would. Otherwise what is wrong, in words.
// The page must be loaded. O(vertices of a page).
[[nodiscard]] std::string wrong_bound(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page);

struct VerifyReport {
    std::uint64_t vertices = 0, samples_compared = 0, chunks = 0;
    std::uint64_t nesting_violations = 0;    // error_m(parent) < (1 + mu) error_m(child)
    std::uint64_t sphere_violations = 0;     // the parent's sphere does not contain the child's with its margin
    std::uint64_t border_mismatches = 0;     // a vertex with different bits in two pages, or a corner in two places
    std::uint64_t true_error_violations = 0; // a sample off by more than error_m + half a quantum
    std::uint64_t height_mismatches = 0;     // against a DEM: stored height off by more than half a quantum, or a hole
                                             // where there is none
    std::uint64_t rim_violations = 0;        // a triangle over a hole's rim with an error below its own size
    std::uint64_t bound_violations = 0;      // a PageBound that does not hold, or is wider than it need be
    double worst_excess_m = 0;               // of true_error_violations
    bool true_error_checked = true;          // false with the mid-point estimate, which does not promise it
    std::string first;                       // the first violation, in words
    [[nodiscard]] bool ok() const {
        return nesting_violations + sphere_violations + border_mismatches + true_error_violations + height_mismatches +
                   rim_violations + bound_violations ==
               0;
    }
};

// A pack tile by tile, in memory that does not grow with its size: a tile's pages and samples a thread, and the borders
// and original heights of a row of tiles. against: the original heights; null: the pack's own full resolution.
// Independent of the baker's error stage: it walks explicit triangles by bisection. O(samples * levels). Throws
// Failure: for pages that are damaged, a source that is not of the pack's size, and what reading it throws.
// Samples that the source would fill are compared with nothing, but must not be holes. row_bytes: original heights of a
// row of tiles are held when they take no more, or the source can only be decoded from its start; otherwise they are
// read tile by tile.
[[nodiscard]] VerifyReport verify(const io::PackFile& file, const HeightSource* against,
                                  std::size_t row_bytes = std::size_t{64} << 20);
// The same of a terrain that is loaded whole; of the pack it came from bounds are looked at, or not if it is null.
[[nodiscard]] VerifyReport verify(const Terrain& terrain, const HeightSource* against, const Pack* bounds = nullptr);

} // namespace fjell::baker
