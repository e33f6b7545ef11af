// One picture of what a pack holds: relief, world-space errors, holes and tiles, with a legend below.
//
// North is up: row 0 on top. A sample is a rectangle of the terrain's spacing, so the terrain's aspect ratio is that of
// its extent in metres. A terrain with fewer samples than the picture has pixels is enlarged, each sample to a block.
//   relief  grey, light from the north-west, slopes exaggerated or softened until they show;
//   errors  the largest of the vertices of the step that matches the pixel, which bound everything finer under them:
//           blue over yellow to red on a logarithmic ramp, multiplied into the relief; grey where there is none at all;
//   holes   hole_rgb, flat, wherever a pixel has at least one sample without a height;
//   tiles   a line through the samples that two tiles share, darker than light ground and lighter than dark ground;
//           on holes hole_line_rgb. Every second, fourth, ... line only where they would lie too close.
// Pure: the same terrain and size make the same picture whatever the number of threads. O(pixels), not O(samples),
// except where holes have rims.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fjell/terrain.h"
#include "io/file.h"

namespace fjell::baker {

using Rgb8 = std::array<std::uint8_t, 3>; // sRGB

inline constexpr Rgb8 hole_rgb{255, 0, 255}, hole_line_rgb{150, 0, 150};
inline constexpr std::uint32_t min_picture_px = 64, max_picture_px = 8192;
inline constexpr std::uint32_t legend_from_px = 256; // a narrower picture has no room for words

struct PictureOptions {
    std::uint32_t longest_px =
        1024;        // longest side of the terrain, clamped to the limits above; the legend comes on top
    int threads = 0; // 0: all cores
};

struct Picture {
    std::uint32_t width = 0, height = 0;
    std::uint32_t terrain_height = 0;             // rows that show the terrain; the legend follows, if there is one
    float least_error_m = 0, largest_error_m = 0; // the ramp's ends; both 0 when there is no error in the picture
    std::vector<std::uint8_t> rgb;                // width * height * 3, top row first

    [[nodiscard]] Rgb8 pixel(std::uint32_t x, std::uint32_t y) const {
        const std::size_t at = (std::size_t{y} * width + x) * 3;
        return {rgb[at], rgb[at + 1], rgb[at + 2]};
    }
};

// All pages of the terrain must be loaded.
[[nodiscard]] Picture make_picture(const Terrain& terrain, const PictureOptions& options = {});

// Writes and commits. Throws Failure (3: the disk or the memory).
void write_png(const Picture& picture, io::AtomicFile& file);

} // namespace fjell::baker
