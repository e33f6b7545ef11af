// The terrain's colour, normal, horizon and splat maps on the GPU: an array texture for each size that tiles may
// have.
//
// A tile has one layer of one of them, with all mips down to 4 x 4. Of a whole pack there is one size and a layer a
// tile, loaded at creation; of a streamed one there are the sizes and layers of MapLayers, empty at first, and
// MapCommands fill them. Whatever its size, a tile's map covers the same square of uv: that of the pack's own size, so
// an upgrade does not shift the picture. Internal to runtime/gl. Memory: half a byte a colour texel, 1 a
// normal texel and 8 a horizon texel, times 4/3 for the mips. Failure: io::Failure names the chunk, the limit or
// the option.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "fjell/ground_maps.h"
#include "fjell/pack.h"
#include "fjell/stream.h"
#include "gl/objects.h"

namespace fjell::gl {

// Colours and normals must fit into the 16 units that every fragment shader has.
inline constexpr std::uint32_t max_map_sizes = 8;

struct MapArrays {
    MapLayers slots;         // zeroes: there is no such map
    std::uint32_t sizes = 0; // arrays, smallest first
    Texture array[max_map_sizes];
    std::int32_t array_of[max_texture_log2 + 1]; // by log2 of the side; -1: none
    std::vector<TileMap> tiles;                  // how each is drawn
    // Of a map that was loaded whole, what the pack has of tiles with paint: mips, largest first. Read from the GPU
    // when paint comes.
    bool whole = false;
    std::unordered_map<std::uint32_t, std::vector<std::byte>> unpainted;

    [[nodiscard]] bool present() const { return sizes != 0; }
    [[nodiscard]] unsigned texture(std::uint32_t side_log2) const {
        return array[static_cast<std::uint32_t>(array_of[side_log2])].get();
    }
};

// A coarse mip of the colours of a tile on the terrain's rim, for the ground around it.
struct RimColours {
    std::uint8_t side_log2 = 0; // 0: not loaded
    std::vector<std::uint8_t> rgb;
};

struct Maps {
    MapArrays kind[map_kinds];   // by MapKind
    std::vector<RimColours> rim; // one a tile; empty without colours
    std::uint64_t rim_changes = 0;
    bool all_there = true;   // whole packs, drawn as they are: shaders need not look at tiles
    float anisotropy = 1;    // samples along the steep direction, as the driver grants them
    std::uint64_t bytes = 0; // on the GPU
};

struct MapOptions {
    float anisotropy = 1;
    bool horizons = true, splat = true; // load a whole pack's
};
// slots: of each kind; with top_log2 != 0 it is streamed, otherwise all that the pack has of it is loaded.
void make_maps(const Pack& pack, const MapLayers (&slots)[map_kinds], const MapOptions& options, Maps& maps);

// Carries out commands, in order; adds the bytes of their blocks to `bytes`. Nothing is done when one is not of these
// maps.
void run_commands(std::span<const MapCommand> commands, Maps& maps, Ring& ring, std::uint64_t& bytes);

// The same for patches of moving ground (fjell/ground_maps.h).
void run_patches(std::span<const MapPatch> patches, const Maps& maps, std::uint64_t& bytes);

// Puts paint (StampShape::paint) over the tiles of maps that were loaded whole, where these samples may matter to them.
void paint_tiles(const Terrain& terrain, std::span<const GroundRect> changed, Maps& maps, std::uint64_t& bytes);

// Refuses what has no layer. `from`: one a tile.
void show_maps(std::span<const TileMap> from, MapKind kind, Maps& maps);

// uv of sample i of a tile = i * scale + offset: the first and last texel centre of mip 0 lie on the tile's border.
struct SampleToTexel {
    float scale = 0, offset = 0;
};
[[nodiscard]] SampleToTexel sample_to_texel(std::uint32_t texture_log2, std::uint32_t tile_log2);

} // namespace fjell::gl
