#include "baker/materials/images.h"

#include <algorithm>

#include <fmt/format.h>

#include "baker/maps/colour.h"
#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

// Values 0 to 1, as stored, `bands` a texel.
struct ImageBands {
    int side = 0;
    std::vector<float> values;
};

double full_scale(GDALDataType type, const std::string& path) {
    if (type == GDT_Byte) return 255;
    if (type == GDT_UInt16) return 65535;
    throw Failure(1, fmt::format("{}: has values of type {} where a texture has 8 or 16 bits; convert it with "
                                 "gdal_translate -ot Byte -scale",
                                 path, GDALGetDataTypeName(type)));
}

ImageBands read_bands(const std::string& path, int bands) {
    GdalMessages messages;
    const GdalFile file = open_raster(path, "an image", messages);
    const int side = file->GetRasterXSize();
    if (side != file->GetRasterYSize() || side < 4 || side > 8192 || (side & (side - 1)) != 0)
        throw Failure(1, fmt::format("{}: is {} x {} where a texture is square, its side a power of two up to 8192; "
                                     "scale it with gdal_translate -outsize",
                                     path, side, file->GetRasterYSize()));
    const int present = file->GetRasterCount();
    ImageBands texels{side, {}};
    const auto count = static_cast<std::size_t>(bands), n = static_cast<std::size_t>(side);
    texels.values.resize(count * n * n);
    std::vector<double> row(n);
    for (int b = 0; b < bands; ++b) {
        GDALRasterBand* const band = file->GetRasterBand(present >= bands ? b + 1 : 1); // grey is all three
        const double scale = full_scale(band->GetRasterDataType(), path);
        for (std::size_t y = 0; y < n; ++y) {
            read_row(*band, static_cast<int>(y), row.data(), path, messages);
            for (std::size_t x = 0; x < n; ++x)
                texels.values[(y * n + x) * count + static_cast<std::size_t>(b)] = static_cast<float>(row[x] / scale);
        }
    }
    return texels;
}

// Means of squares, to `side` texels a side.
std::vector<float> scaled(const ImageBands& from, int bands, int side, const std::string& path) {
    if (from.side < side)
        throw Failure(1, fmt::format("{}: has {} texels a side where {} are asked for; give --size {}", path, from.side,
                                     side, from.side));
    const int by = from.side / side;
    std::vector<float> to(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) *
                          static_cast<std::size_t>(bands));
    const float share = 1 / static_cast<float>(by * by);
    for (int y = 0; y < from.side; ++y)
        for (int x = 0; x < from.side; ++x)
            for (int b = 0; b < bands; ++b)
                to[static_cast<std::size_t>(((y / by) * side + x / by) * bands + b)] +=
                    share * from.values[static_cast<std::size_t>((y * from.side + x) * bands + b)];
    return to;
}

} // namespace

Canvas read_images(const MaterialRecipe& recipe, int side, std::vector<float>& normal) {
    Canvas canvas{side, recipe.size_m, {}, {}};
    ImageBands albedo = read_bands(recipe.albedo, 3);
    for (float& v : albedo.values) v = light_of_srgb(255 * v);
    canvas.rgb = scaled(albedo, 3, side, recipe.albedo);
    canvas.height.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0.0f);
    if (!recipe.height.empty()) {
        canvas.height = scaled(read_bands(recipe.height, 1), 1, side, recipe.height);
        for (float& h : canvas.height) h *= recipe.relief_m;
    }
    if (recipe.normal.empty()) return canvas;
    normal.clear();
    const std::vector<float> codes = scaled(read_bands(recipe.normal, 3), 3, side, recipe.normal);
    for (std::size_t i = 0; i < codes.size(); i += 3) {
        normal.push_back(std::clamp((255 * codes[i] - 128) / 127, -1.0f, 1.0f));
        normal.push_back(-std::clamp((255 * codes[i + 1] - 128) / 127, -1.0f, 1.0f));
    }
    return canvas;
}

} // namespace fjell::baker
