// One or several files on one grid.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "baker/read/height_file.h"

namespace fjell::baker {

struct MosaicFile {
    FileFacts facts;
    std::int32_t x = 0, y = 0; // its north-western sample in the mosaic
};

// Where the files lie: the smallest rectangle around all of them.
struct MosaicLayout {
    Placement at;
    std::vector<MosaicFile> files;
};

// Opens every file once. Throws Failure 1 when they do not share CRS, spacing and grid, or one has no georeference,
// naming two of them and the command that helps. O(files).
[[nodiscard]] MosaicLayout lay_out(const std::vector<std::string>& paths, const ReadOptions& options);

// Windows that read the files' blocks once (windows.h). The area is in samples of the mosaic.
[[nodiscard]] std::vector<Window> cut_along(const MosaicLayout& layout, const Window& area, std::size_t most);

// Reads a layout; one thread at a time. Files are opened when they are needed, and few are kept open.
class Mosaic {
public:
    Mosaic(const MosaicLayout& layout, const ReadOptions& options); // both must outlive it
    // As HeightFile::read. Samples that no file covers are voids. The last file is on top, where it has heights.
    void read(const Window& window, float* to, ReadStatistics& statistics);
    // False where no file has samples, by their places, and what they know themselves (HeightFile::covers).
    [[nodiscard]] bool covers(const Window& window);

private:
    struct Open {
        std::unique_ptr<HeightFile> file;
        std::uint64_t used = 0;
    };
    HeightFile& open(std::size_t index);
    void paint(std::size_t index, const Window& window, float* to, ReadStatistics& statistics);

    const MosaicLayout& layout_;
    const ReadOptions& options_;
    std::vector<Open> open_;
    std::size_t open_count_ = 0;
    std::uint64_t uses_ = 0;
    std::vector<float> part_;
    std::vector<std::uint8_t> wanted_;
};

} // namespace fjell::baker
