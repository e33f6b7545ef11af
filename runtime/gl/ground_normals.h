// Moving ground (fjell/edit.h) on normal maps: the texels over edited heights are made anew from them, in the mips that
// are on the GPU, and again whenever a map with the pack's normals comes. Mips whose texels are farther apart than 32
// samples stay the pack's. Internal to runtime/gl. Memory: 16 bytes an edited rectangle and tile, up to 64 of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fjell/edit.h"
#include "fjell/terrain.h"
#include "gl/maps.h"

namespace fjell::gl {

class GroundNormals {
public:
    // Takes what has changed since the last call. Paints it on the maps that tiles show.
    void follow(const Edits& edits, const Terrain& terrain, const MapArrays& normals);
    // A map of that tile was written: what it shows is the pack's until the next repaint().
    void written(std::uint32_t tile);
    // Paints tiles that were written, or that show another layer than the one that was painted.
    void repaint(const Terrain& terrain, const MapArrays& normals);

private:
    struct TileEdits {
        std::vector<GroundRect> rects;
        std::uint32_t layer = 0, side_log2 = 0; // that were painted; 0: none
    };
    void add(const GroundRect& rect, const Terrain& terrain, const MapArrays& normals);
    void paint(std::uint32_t tile, const GroundRect& rect, const Terrain& terrain, const MapArrays& normals);
    void paint_mip(std::uint32_t tile, std::uint32_t mip, const GroundRect& rect, const Terrain& terrain,
                   const MapArrays& normals);

    std::uint64_t cursor_ = 0;
    std::vector<TileEdits> tiles_; // one a tile; empty before the first change
    std::vector<float> heights_m_;
    std::vector<std::byte> blocks_;
};

} // namespace fjell::gl
