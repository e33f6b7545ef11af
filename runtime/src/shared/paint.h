// What stamps paint on the ground (StampShape::paint), and what maps are under it: for the terrain that is flown, and
// for the baker.
//
// Paint lies on samples: a colour and how much of the colour map it hides, and of up to two materials how much they
// hide of the splat map. It is kept by blocks of 32 x 32 samples, with the means of 2 x 2, 4 x 4 .. 32 x 32 of them. A
// texel takes a tent over samples, or over means where texels are wide: as wide as the baker's filters from samples to
// its mip are together. So every mip follows from the paint and from the pack's texels alone, and costs the same a
// texel. Colours are mixed as light. Of a block of texels that no paint reaches no bit changes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fjell/pack.h"
#include "fjell/texture.h"
#include "shared/stamp.h"

namespace fjell::edit {

inline constexpr int paint_log2 = 5;
inline constexpr std::int32_t paint_side = 1 << paint_log2;
inline constexpr std::uint32_t paint_level_at[paint_log2 + 2] = {0, 1024, 1280, 1344, 1360, 1364, 1365}; // in words
inline constexpr std::uint32_t paint_words = paint_level_at[paint_log2 + 1];

// Words are written while other threads read them: each of its own, relaxed.
struct PaintBlock {
    std::int32_t x, y; // in blocks
    // Red, green, blue (sRGB) and share, from the lowest byte on; materials: twice a share and a number. The shares of
    // materials are no more than the colour's together: what is left of it shows the colour map.
    std::uint32_t colours[paint_words], materials[paint_words];
};

// Paints the samples of a block, and takes the means anew. False: nothing has changed.
bool paint_block(const StampGrid& grid, const Stamp& stamp, PaintBlock& block);
[[nodiscard]] bool is_blank(const PaintBlock& block);

// Where paint is looked for. find(): the block at a place, in blocks; null: there is none.
struct PaintSource {
    const void* object;
    const PaintBlock* (*find)(const void* object, std::int32_t x, std::int32_t y);
};

// Of a mip, in texels.
struct MapRect {
    std::uint32_t x = 0, y = 0, columns = 0, rows = 0;
};

// Texels of a mip among samples. Texel x of it stands at first + x * spacing.
struct PaintGrid {
    SampleIndex first, last; // sample of texel 0; the terrain's last sample
    double spacing, wide;    // of texels; half a tent. In samples
    int level;               // of means that are taken

    // top_log2, mip_log2: texels a side, of the map and of its mip. first: of a tile.
    PaintGrid(const PackHeader& header, std::uint32_t top_log2, std::uint32_t mip_log2, SampleIndex first);
    PaintGrid(int tile_log2, SampleIndex last, std::uint32_t top_log2, std::uint32_t mip_log2, SampleIndex first);
    // Whole blocks of texels of the tile that paint on these samples may reach; columns 0: none. side: of the mip.
    [[nodiscard]] MapRect texels_over(const Rect& samples, std::uint32_t side) const;
};

inline constexpr std::int32_t painted_side = 16; // of texels that are summed at once
struct PaintedColour {
    float share, light[3]; // light times share, 0 to 1
};
struct PaintedMaterials {
    float share, of[max_splat_names];
};
// Texels [x, x + columns) by [y, y + rows), by rows of painted_side; `to` has painted_side squared. False: no paint
// reaches them, and nothing is written.
struct PaintedTexels {
    std::int32_t x, y, columns, rows; // at most painted_side
};
[[nodiscard]] bool sum_paint(const PaintSource& from, const PaintGrid& grid, const PaintedTexels& at,
                             PaintedColour* to);
[[nodiscard]] bool sum_paint(const PaintSource& from, const PaintGrid& grid, const PaintedTexels& at,
                             PaintedMaterials* to);

// Puts paint over the texels [x, x + columns) by [y, y + rows) of a mip as the pack stores it, whole blocks of 4 x 4.
// False: no paint reaches them, and no bit has changed.
bool paint_colours(const PaintSource& from, const PaintGrid& grid, std::uint32_t side, const MapRect& at,
                   std::byte* blocks);
bool paint_splat(const PaintSource& from, const PaintGrid& grid, std::uint32_t side, const MapRect& at,
                 std::byte* texels);

// The four largest of shares that add up to 1 at most, as fjell/texture.h has them: 8 bytes. What the others would have
// shown goes to these in proportion.
void store_splat_texel(const float (&shares)[max_splat_names], std::byte* to);

} // namespace fjell::edit
