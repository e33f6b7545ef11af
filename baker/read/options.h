// How files become heights in metres.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fjell::baker {

// Voids are samples that the file marks as no-data (tag or mask), that --void names, or that are NaN. Implausible ones
// are infinite, or outside -12000..30000 m both as the file has them and after zscale: undeclared voids (-32767 and the
// like), or another unit. automatic: voids become holes; implausible ones, which only the user can tell apart, are
// refused. hole: both become holes. fill: both become ground, a smooth continuation of what surrounds them, on the
// source's own step (fill.h). refuse: a Failure that counts them. Plausible heights that look like voids (range_ends.h)
// are refused whatever this says: holes in ground that is right would be as wrong as pits of voids.
enum class NoData : std::uint8_t { automatic, hole, fill, refuse };

// --void. numbers: of the file, before its scale, offset and unit and before zscale (with an encoding, the metres that
// it stands for); compared as closely as a tag is. no_others ("none"): every other finite number is a height.
struct DeclaredVoids {
    std::vector<double> numbers;
    bool no_others = false;
    friend bool operator==(const DeclaredVoids&, const DeclaredVoids&) = default;
};

// Heights packed into the red, green and blue of a picture; no height where alpha is 0.
// terrarium: R * 256 + G + B / 256 - 32768. terrain_rgb (Mapbox): -10000 + (R * 65536 + G * 256 + B) * 0.1.
enum class Encoding : std::uint8_t { none, terrarium, terrain_rgb };

struct ReadOptions {
    // Of a file without a CRS, and of one in degrees to take them as a square grid. What has a projected CRS, or gets
    // one by a crs that is named, is resampled to it.
    std::optional<double> spacing_m;
    // automatic ("auto"): reprojected to metres (projection.h) is what is in degrees, or in a projected CRS whose
    // metres are off the ground's by more than 0.5% or whose axes do not point east and north. "keep" and "none":
    // nothing is reprojected. Else a projected CRS as GDAL understands it ("EPSG:25832", WKT, PROJ) to reproject to.
    std::string crs = "auto";
    Encoding encoding = Encoding::none;
    // West, south, east, north: only samples inside. In the units of the CRS after reprojection; of the file's own,
    // when that is projected and crs is automatic; degrees,
    // of a field in degrees when crs is automatic and the box meets the field so, or there is no automatic CRS for all
    // of it, or nothing is reprojected (EAST may be less than WEST there: across the antimeridian);
    // columns and rows, counted from the north-west, when there is no georeference.
    std::optional<std::array<double, 4>> bbox;
    // Multiplies heights after the band's own scale and offset; not given: 1, and depths and unknown units are refused.
    std::optional<double> zscale;
    double zoffset_m = 0; // added after zscale
    // What heights count whose unit neither band nor CRS names: m, ft, us-ft, or another name that PROJ or GDAL has.
    std::string vertical_unit;
    // Of a file with several bands the one that holds heights, by its number (from 1) or its name. Empty: the only one,
    // or the only one whose name says so.
    std::string band;
    // Columns and rows of raw numbers (open_raster()), whose file does not say. Not given: square.
    std::optional<std::array<int, 2>> size;
    NoData nodata = NoData::automatic;
    DeclaredVoids voids;
};

// GDAL keeps decoded blocks of all open files in at most this many bytes (default: 5% of the machine's memory), from
// the next file on that is opened.
void limit_gdal_cache(std::size_t bytes);

} // namespace fjell::baker
