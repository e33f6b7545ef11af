// One raster file as heights.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/read/decode.h"
#include "baker/read/gdal_file.h"
#include "baker/read/windows.h"
#include "baker/store/memory.h"

namespace fjell::baker {

// What is known of a file before its samples are read.
struct FileFacts {
    std::string path;
    Placement at;
    Decoding decoding;
    Blocks blocks;           // seen from the north-west
    bool sequential = false; // its format is decoded from the start
    std::string height_unit; // as the file calls it; empty: it does not
    std::string band;        // of several: "2 elevation"
    std::string driver, type;
    std::string voids;    // how the file tells them; empty: it does not
    double step = 1;      // raw numbers are multiples of this, unless they have a fraction
    std::string identity; // names, sizes and times of everything it is read from
};

// An open file. One thread at a time. Throws Failure (georeference/open_source.h).
class HeightFile {
public:
    HeightFile(const std::string& path, const ReadOptions& options);

    [[nodiscard]] const FileFacts& facts() const { return facts_; }
    // window.area() heights, row by row, row 0 north and column 0 west whichever way the file runs. wanted: samples
    // with 0 are not looked at and become NaN; null: all. Places in the statistics are the window's.
    void read(const Window& window, float* to, ReadStatistics& statistics, const std::uint8_t* wanted = nullptr);
    // False where the file says of itself that it has nothing but no-data: what a VRT's files leave free, blocks that a
    // GeoTIFF does not store.
    [[nodiscard]] bool covers(const Window& window) const;

private:
    template <typename T>
    void read_as(const Window& in_file, const Window& window, T* raw, float* to, ReadStatistics& statistics);
    void read_coded(const Window& in_file);
    void read_marks(const Window& in_file, const std::uint8_t* wanted);
    void band(int number, const Window& in_file, void* to, GDALDataType type);
    void floats(const Window& in_file, float* to);
    [[nodiscard]] bool is_whole_blocks(const Window& in_file) const;
    void read_blocks(const Window& in_file, float* to);
    [[noreturn]] void refuse(const Window& in_file, const GdalMessages& messages);

    GdalFile file_;
    FileFacts facts_;
    Encoding encoding_ = Encoding::none;
    int band_ = 1;                   // that holds heights
    bool signed_byte_ = false;       // its numbers above 127 are below 0
    bool tagged_ = false;            // what it has no data for is no height
    bool floats_ = false;            // float holds every raw number
    GDALRasterBand* mask_ = nullptr; // none: all are valid
    bool by_blocks_ = false;         // GDAL need not keep blocks: its driver finds each by itself
    int block_columns_ = 0, block_rows_ = 0;
    Buffer<std::byte> block_;
    std::vector<double> raw_;
    std::vector<std::uint8_t> marks_, colours_;
    std::vector<std::array<std::uint8_t, 3>> palette_; // of a coded picture that has one; empty: three bands
};

} // namespace fjell::baker
