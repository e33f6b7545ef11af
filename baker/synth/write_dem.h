// Height fields as GeoTIFF, of any size.
#pragma once

#include <cstdint>
#include <string>

#include "baker/bake/bake.h"
#include "baker/read/source.h"

namespace fjell::baker {

// compact: UInt16 with scale and offset when that holds every height bit for bit, else Float32; holes are the ground
// that continues over them (fill.h). plain: Float32 metres for any program, holes are no-data (NaN).
enum class DemForm : std::uint8_t { compact, plain };

// Writes a source as a tiled GeoTIFF. Through a folder PATH.work: 4 bytes a
// sample of disk, 8 with holes, and about 32 MB and 2 KB a column of memory, whatever the size. What is written is read
// back before it is renamed to its place; on any failure or interruption nothing is left. threads: 0: all cores.
// Throws Failure: 1 no such folder, 3 the disk.
void write_dem(const HeightSource& source, const std::string& path, DemForm form = DemForm::compact, int threads = 0,
               const Progress& progress = {});

} // namespace fjell::baker
