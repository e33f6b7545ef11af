// Places with less detail: a sea's bed, ground that nobody visits. There heights are kept at some distance from each
// other, and between them the ground is as flat as the mesh's triangles of that size. So finer vertices have no error,
// and no view takes them; what Fjell says of its errors is true there as everywhere, of the heights that the pack has.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "baker/read/source.h"

namespace fjell::baker {

// Samples between two heights that are kept: 2^most_coarse_log2 at most.
inline constexpr int most_coarse_log2 = 6;

// path: polygons of a vector file. Each says detail_m, metres between heights that are kept, rounded down to 2, 4, 8
// ... samples; detail_m: of those that do not. Where some overlap, the finest counts. Only squares of so many samples
// that lie within a polygon get less detail, and smaller ones along its border; none with a void. Holds 16 bytes a
// point; a reader 5 bytes for each sample of a window and of some squares around it. Throws Failure 1: read_vectors()';
// a polygon without a number, or with one that leaves nothing out; no polygon on the field.
[[nodiscard]] std::unique_ptr<HeightSource> coarse_source(std::unique_ptr<HeightSource> source, const std::string& path,
                                                          std::optional<double> detail_m);

} // namespace fjell::baker
