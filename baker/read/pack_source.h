// A pack's heights, read back: a source like any file.
#pragma once

#include <memory>
#include <string>

#include "baker/read/source.h"
#include "fjell/io/pack_file.h"
#include "shared/record.h"

namespace fjell::baker {

// Full resolution, decoded tile by tile from its pages: what the runtime stands on, bit for bit. Holes are NaN; CRS,
// its steps, origin and spacing are the header's. Memory: a tile's pages a reader (4.2 bytes a sample of the tile), and
// what of the file is being decoded.
class PackSource final : public HeightSource {
public:
    explicit PackSource(const std::string& path); // throws Failure as PackFile does

    // Throws Failure 1 for a page that is damaged.
    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override;
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override; // along tiles
    // The same, and a hole's samples have the height that their vertices stand on.
    [[nodiscard]] std::unique_ptr<HeightReader> ground_reader() const;
    // The pack's own height steps.
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override;
    [[nodiscard]] std::string identity() const override; // the pack's hash
    [[nodiscard]] HeightScale height_scale() const;
    [[nodiscard]] const PackHeader& header() const { return file_->pack().header; }
    [[nodiscard]] const io::PackFile& file() const { return *file_; }

private:
    std::shared_ptr<const io::PackFile> file_;
};

} // namespace fjell::baker
