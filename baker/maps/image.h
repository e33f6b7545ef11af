// Ortho-images of any size, kind and CRS, read by windows: never a whole one in memory.
//
// Where an image lies: georeferenced, over a terrain with a CRS: by its coordinates, warped to the terrain's CRS where
// its own is another; whole turns of longitude do not count. Control points and arrays of coordinates count as such.
// Without any, or over a terrain without: stretched, its outer edge on the outermost samples. Several are laid on top
// of each other, the last one uppermost; each must be georeferenced. Kinds: grey, palette, red-green-blue, each with or
// without alpha, mask or no-data value; 8 bits, or 16 scaled down. Of 16 bits white is what NBITS says, or without it
// the largest number of 8 to 12 bits when all numbers have so few. Of several bands those are red, green and blue that
// say so, by their colour or by their name.
//
// An image is read by rows from its full resolution, never through overviews: what a pixel is does not depend on who
// asks. A warped one is computed in blocks of one fixed grid for the same reason. A format that is not tiled (PNG,
// JPEG) is decoded from its first row on wherever GDAL's cache (GDAL_CACHEMAX) does not hold a row of tiles of it: make
// it a tiled GeoTIFF when it is large.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "baker/read/source.h"

class GDALDataset;
class GDALRasterBand;

namespace fjell::baker {

// One image over the terrain. Sample (x, y) lies at pixel coordinates first_px + per_sample * (x, y); pixel 0 covers
// 0..1.
struct ImageLayer {
    std::int32_t columns = 0, rows = 0;
    double first_px[2] = {0, 0}, per_sample[2] = {1, 1};
};

// Reads windows. One a thread: it owns its open files.
class ImageReader {
public:
    ImageReader() = default;
    ImageReader(const ImageReader&) = delete;
    ImageReader& operator=(const ImageReader&) = delete;
    virtual ~ImageReader() = default;
    // pixels.area() * 4 bytes: red, green, blue (sRGB), alpha. Does not depend on how windows are cut. Throws Failure.
    virtual void read(std::size_t layer, const Window& pixels, std::uint8_t* rgba) = 0;
};

class ImageSource {
public:
    ImageSource() = default;
    ImageSource(const ImageSource&) = delete;
    ImageSource& operator=(const ImageSource&) = delete;
    virtual ~ImageSource() = default;

    std::vector<ImageLayer> layers;    // the last one uppermost
    std::vector<std::string> accounts; // a line for each: kind, numbers, and how it was placed

    [[nodiscard]] virtual std::unique_ptr<ImageReader> reader() const = 0;
    // Names, sizes and times of the files and how they are laid: equal identities, equal pixels.
    [[nodiscard]] virtual std::string identity() const = 0;
    // Of the finest layer, along the finer axis: what a map should hold.
    [[nodiscard]] double pixels_per_sample() const {
        double most = 0;
        for (const ImageLayer& layer : layers) most = std::max({most, layer.per_sample[0], layer.per_sample[1]});
        return most;
    }
};

// What an image needs to know of the terrain.
struct Frame {
    std::int32_t columns = 0, rows = 0;
    double origin[2] = {0, 0}; // of sample (0, 0) in CRS axes
    double step[2] = {1, 1};   // from sample to sample in CRS units, the second southwards; 0: not known
    std::string crs_wkt;       // empty: none
};
[[nodiscard]] Frame frame_of(const HeightSource& ground);

// bands: of every image, "RED,GREEN,BLUE" or "GREY", each a number from 1 or a name; empty: as the image says. Throws
// Failure: no such file, no image, no such band, images that do not go together, or that do not meet the terrain.
[[nodiscard]] std::unique_ptr<ImageSource> open_images(const std::vector<std::string>& paths, const Frame& ground,
                                                       const std::string& bands = "");

// Which of an image's bands are red, green and blue, or grey, when bands is as above; empty: all of them as they are.
// Throws Failure: no such band, more than four of which none say it, or two of which none is alpha.
[[nodiscard]] std::vector<int> picture_bands(GDALDataset& file, const std::string& bands, const std::string& path);
// The number that is white of a band of 16 bits whose largest number this is.
[[nodiscard]] std::uint32_t picture_white(GDALRasterBand& band, std::uint32_t largest);

// A raster that says what lies where, for splat maps: nothing is mixed when it is warped. Classes: whole numbers of 8
// or 16 bits in the only band, which a reader gives as low byte, high byte, 0, alpha. Without georeference it must
// have the terrain's proportions. Throws Failure as open_images().
enum class RasterUse : std::uint8_t { picture, paint, classes };
[[nodiscard]] std::unique_ptr<ImageSource> open_raster_map(const std::string& path, const Frame& ground, RasterUse use);

} // namespace fjell::baker
