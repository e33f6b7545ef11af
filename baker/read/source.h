// Where heights come from, without holding them: extents known at once, any window of samples as often as asked.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "baker/read/range_ends.h"
#include "baker/store/window.h"
#include "fjell/edit.h"
#include "fjell/io/failure.h"

namespace fjell::edit {
struct PaintSource;
}

namespace fjell::baker {

using io::Failure;

// Statistics of what was read. Counting windows in any order, on any number of threads, and adding up gives the same.
struct ReadStatistics {
    Tally voids, implausible; // options.h says what these are
    double implausible_m = 0; // the first implausible one
    double per_unit = 1;      // 1, 10 or 100: raw numbers are multiples of 1 / per_unit; 1000: of none of them
    float least_m = std::numeric_limits<float>::infinity(), most_m = -std::numeric_limits<float>::infinity();
    RangeEnds ends; // of the numbers that became heights; places of what is reprojected are the source's

    void add(const ReadStatistics& other);
};

// Reads windows of one source. One a thread: it owns its open files.
class HeightReader {
public:
    HeightReader() = default;
    HeightReader(const HeightReader&) = delete;
    HeightReader& operator=(const HeightReader&) = delete;
    virtual ~HeightReader() = default;
    // window.area() heights in metres, row by row; NaN where there is none. What is read is added to the statistics.
    // The numbers do not depend on how windows are cut or ordered. Throws Failure.
    virtual void read(const Window& window, float* to, ReadStatistics& statistics) = 0;
    // False where a window is known to be void without reading it: no file reaches there.
    [[nodiscard]] virtual bool covers(const Window& /*window*/) { return true; }
};

// A height that so many samples share, at an end of all heights, that it may stand for none.
struct RepeatedHeight {
    double number = 0; // in the file; what --void takes
    double height_m = 0;
    double share = 0; // of the samples, 0..1; 0: there is no such height
    std::int32_t column = 0, row = 0;
};

// What a statistics means for the whole terrain.
struct SourceProperties {
    double native_quantum_m = 0; // the step that the source's numbers are multiples of; 0: not known
    double anchor_m = 0;         // a height that is on that step
    bool holes = false;          // samples without height stay holes; otherwise they are filled, or there are none
    RepeatedHeight lowest{}, highest{}; // baked as ground, but to be said
};

// What the samples were before they were metres on this grid: told in summaries and kept in the pack.
struct SourceFacts {
    std::string reprojected_from;    // the name of the CRS that they were reprojected from; empty: they were not
    double from_step[2] = {0, 0};    // between samples there, in from_unit
    std::string from_unit;           // "degrees" or "m"
    std::string resampled;           // how: "cubic", or "cubic over 3.2 samples"; empty: they are those of the file
    std::string axes;                // of the file's CRS, as x and y run: "west, south"; empty: east, north, or no CRS
    double ground_scale[2] = {0, 0}; // least and most metres of the grid that a metre of ground is; 0: not known
    std::string driver, type;        // of the first file, as GDAL calls them, or raw; empty: not from a file
    std::string voids;               // how it tells them: "mask", "no-data -9999"; empty: it does not
    std::string band;                // of several that the file has: "2 elevation"
    std::string coarse;              // where less detail was kept (read/coarse_source.h); empty: nowhere
    std::string height_unit;         // as the file says; empty: it does not, so that they count as metres
    double height_unit_m = 1;        // metres that 1 in the file counts for, with its own scale and --zscale
};

class PackSource;

// Where stamps have changed a pack's ground: windows of samples.
struct PackChanges {
    const PackSource* pack = nullptr;
    std::vector<Window> heights; // outside of them heights are the pack's
    std::vector<Window> paint;   // and outside of these nothing is painted
};

class HeightSource {
public:
    HeightSource() = default;
    HeightSource(const HeightSource&) = delete;
    HeightSource& operator=(const HeightSource&) = delete;
    virtual ~HeightSource() = default;

    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};  // along columns, along rows; > 0
    double crs_origin[2] = {0, 0}; // of sample (0, 0) in CRS axes
    double crs_step[2] = {0, 0};   // between samples in the CRS' own units (degrees, feet, ...), eastwards and
                                   // southwards, whatever spacing_m says; 0: not known
    std::string crs_wkt;           // empty: none
    SourceFacts facts;
    // For heights that are made from another's: the same samples at the same places.
    void take_place_of(const HeightSource& other) {
        columns = other.columns, rows = other.rows;
        std::copy_n(other.spacing_m, 2, spacing_m);
        std::copy_n(other.crs_origin, 2, crs_origin);
        std::copy_n(other.crs_step, 2, crs_step);
        crs_wkt = other.crs_wkt;
        facts = other.facts;
    }

    [[nodiscard]] virtual std::unique_ptr<HeightReader> reader() const = 0;
    // How many readers at once pay, of at most `threads`: 1 for files that can only be decoded from their start.
    [[nodiscard]] virtual int readers(int threads) const { return threads; }
    // Windows that cover every sample once, each of at most about `most` samples and no larger than that unless one
    // row or block of the file is, cut along the file's own blocks, in the order that reads it fastest.
    [[nodiscard]] virtual std::vector<Window> windows(std::size_t most) const = 0;
    // Throws Failure for what the user has to decide about (implausible heights, voids with NoData::refuse) and for a
    // source without any height.
    [[nodiscard]] virtual SourceProperties properties(const ReadStatistics& statistics) const = 0;
    // Everything that the heights depend on, as text: names, sizes and times of files, options. Two sources with equal
    // identities give equal heights; a bake is only resumed with the same one.
    [[nodiscard]] virtual std::string identity() const = 0;
    // Of a pack with stamps; null: it is none.
    [[nodiscard]] virtual const PackChanges* changes() const { return nullptr; }
    // What lies over its colour and splat maps (shared/paint.h); null: nothing.
    [[nodiscard]] virtual const edit::PaintSource* paint() const { return nullptr; }
    // Stamps that lock places, or unlock them, in order (StampShape::lock). They stay as long as the source.
    [[nodiscard]] virtual std::span<const Stamp> locks() const { return {}; }
};

} // namespace fjell::baker
