// Full-resolution heights of a pack that stays in its file: what a camera path needs before anything is streamed.
//
// The same heights as of a terrain that is loaded whole, bit for bit, so that a path is the same either way. Memory: a
// few pages, and 8 bytes for each page of the pack. Thread: one; it reads the file, so not the frame's. Where a page is
// damaged or cannot be read, the ground is a coarser sample's beside it: the flight will say what is wrong.
#pragma once

#include <utility>
#include <vector>

#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"
#include "fjell/terrain.h"
#include "session/path.h"

namespace fjell::session {

class FileGround {
public:
    explicit FileGround(const io::PackFile& file); // must outlive it; throws Failure as create_terrain fails
    FileGround(const FileGround&) = delete;
    FileGround& operator=(const FileGround&) = delete;

    // terrain_height_m() (fjell/pages.h), whatever is loaded.
    [[nodiscard]] double ground_m(double x_m, double z_m);
    // Of the sample nearest to the north-west: that it is no hole.
    [[nodiscard]] bool has_ground(double x_m, double z_m);

private:
    [[nodiscard]] SampleIndex north_west_of(double x_m, double z_m) const; // not the last column or row
    void make_room();
    void fetch(SampleIndex sample);
    bool load(std::uint32_t tile, std::uint32_t page);

    const io::PackFile& file_;
    io::AlignedMemory memory_;
    Terrain terrain_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> loaded_; // tiles and their pages, in order
    std::vector<std::byte> stored_, raw_;
};

// ground must outlive the result.
[[nodiscard]] Ground ground_of(FileGround& ground, const Terrain& terrain);

} // namespace fjell::session
