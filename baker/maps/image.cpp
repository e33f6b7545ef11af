#include "baker/maps/image.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <mutex>
#include <regex>
#include <utility>

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

// ---- one file, ready to be read as red, green, blue and alpha ------------------------------------------------------

// A file and what was made of it; later ones read from earlier ones and are closed first.
struct Opened {
    std::vector<GdalFile> chain;
    bool warped = false;

    [[nodiscard]] GDALDataset& top() const { return *chain.back(); }
    Opened() = default;
    Opened(Opened&&) = default;
    Opened& operator=(Opened&&) = delete;
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;
    ~Opened() {
        while (!chain.empty()) chain.pop_back();
    }
};

// How an image is laid: decided once, repeated by every reader.
struct Recipe {
    std::string path;
    std::string warp_to; // WKT; empty: as it is
    RasterUse use = RasterUse::picture;
    std::vector<int> bands = {};                 // red, green, blue, or grey; empty: as they are
    std::uint32_t white = 65535, opaque = 65535; // of 16 bits
    std::vector<std::string> cut{};              // for gdalwarp: extents and pixels; empty: it chooses
    bool by_points = false, thin_plate = false;  // warped by control points: by a polynomial or through each point
    bool centred = false;                        // goes on beyond the edge of its map: centred() before it is warped
};

bool is_alpha(GDALDataset& file, int band) {
    return file.GetRasterBand(band)->GetColorInterpretation() == GCI_AlphaBand;
}

void check_kind(GDALDataset& file, const Recipe& recipe) {
    GDALRasterBand* const first = file.GetRasterBand(1);
    const GDALDataType type = first->GetRasterDataType();
    const std::string& path = recipe.path;
    int numbers = 0;
    for (int b = 1; b <= file.GetRasterCount(); ++b) numbers += is_alpha(file, b) ? 0 : 1;
    if (recipe.use == RasterUse::classes ? numbers > 1 : recipe.use == RasterUse::paint && numbers == 2)
        throw Failure(1, fmt::format("{}: has {} bands, {}; give a raster with the one that holds {}: gdal_translate "
                                     "-b N {} OUT.tif",
                                     path, file.GetRasterCount(), named_bands(file),
                                     recipe.use == RasterUse::classes ? "classes" : "what is painted", path));
    if (recipe.use == RasterUse::classes) {
        if (type == GDT_Byte || type == GDT_UInt16 || type == GDT_Int16) return;
        throw Failure(1, fmt::format("{}: is no raster of classes of 8 or 16 bits ({}); convert it with "
                                     "gdal_translate -ot UInt16",
                                     path, GDALGetDataTypeName(type)));
    }
    const int count = file.GetRasterCount();
    if ((type != GDT_Byte && type != GDT_UInt16) || count > 4 || first->GetColorInterpretation() == GCI_CyanBand)
        throw Failure(1,
                      fmt::format("{}: is no grey, palette or red-green-blue image of 8 or 16 bits ({} bands of {}); "
                                  "convert it with gdal_translate -ot Byte{}",
                                  path, count, GDALGetDataTypeName(type),
                                  GDALDataTypeIsFloating(type) ? " -scale 0 WHITE 0 255" : ""));
}

GdalFile checked(GDALDatasetH made, const Recipe& recipe, const char* what, const GdalMessages& messages) {
    if (!made) throw Failure(1, fmt::format("{}: {}{}", recipe.path, what, messages.said()));
    return GdalFile(GDALDataset::FromHandle(made));
}

GDALDatasetH translated(GDALDataset& file, CPLStringList& words) {
    words.AddString("-of"), words.AddString("VRT");
    GDALTranslateOptions* const options = GDALTranslateOptionsNew(words.List(), nullptr);
    GDALDatasetH made = GDALTranslate("", GDALDataset::ToHandle(&file), options, nullptr);
    GDALTranslateOptionsFree(options);
    return made;
}

GdalFile expand_palette(GDALDataset& file, const Recipe& recipe, const GdalMessages& messages) {
    CPLStringList words;
    words.AddString("-expand"), words.AddString("rgba");
    return checked(translated(file, words), recipe,
                   "its palette cannot be expanded; convert it with gdal_translate -expand rgb", messages);
}

// The bands of the recipe, and behind them what says where there is a picture.
GdalFile select_bands(GDALDataset& file, const Recipe& recipe, const GdalMessages& messages) {
    std::vector<int> all = recipe.bands;
    for (int b = 1; b <= file.GetRasterCount(); ++b)
        if (is_alpha(file, b)) all.push_back(b);
    CPLStringList words;
    for (const int b : all) words.AddString("-b"), words.AddString(std::to_string(b).c_str());
    return checked(translated(file, words), recipe, "its bands cannot be chosen; do it with gdal_translate -b",
                   messages);
}

// Everything that GDAL would choose by itself is fixed: memory for chunks, threads, the error of approximated
// coordinates, overviews.
GdalFile warp(GDALDataset& file, const Recipe& recipe, const GdalMessages& messages) {
    const char* const how = recipe.use == RasterUse::picture ? "bilinear" : "near";
    const char* const words[] = {
        "-of",  "VRT",  "-t_srs", recipe.warp_to.c_str(), "-r", how, "-dstalpha", "-et", "0.125", "-wm", "64",
        "-ovr", "NONE", "-wo",    "NUM_THREADS=1"};
    CPLStringList all;
    for (const char* const word : words) all.AddString(word);
    for (const std::string& word : recipe.cut) all.AddString(word.c_str());
    if (recipe.thin_plate) all.AddString("-tps");
    if (recipe.by_points && !file.GetGCPSpatialRef()) { // as coordinates without a CRS: the terrain's
        all.AddString("-s_srs");
        all.AddString(recipe.warp_to.c_str());
    }
    GDALWarpAppOptions* const options = GDALWarpAppOptionsNew(all.List(), nullptr);
    GDALDatasetH from = GDALDataset::ToHandle(&file);
    GDALDatasetH made = GDALWarp("", nullptr, 1, &from, options, nullptr);
    GDALWarpAppOptionsFree(options);
    return checked(made, recipe, "cannot be warped to the terrain's CRS; do it with gdalwarp -t_srs", messages);
}

// Whether a map of all longitudes goes on beyond its edge, where its CRS knows no places.
bool goes_beyond(GDALDataset& file, const Turn& turn) {
    double t[6];
    if (!(turn.length > 0) || file.GetGeoTransform(t) != CE_None || t[2] != 0 || t[4] != 0 || t[1] <= 0) return false;
    const double width = file.GetRasterXSize() * t[1], half = turn.length / 2, slack = 0.01 * t[1];
    return width <= turn.length && (t[0] < turn.middle - half - slack || t[0] + width > turn.middle + half + slack);
}

// The same pixels on the same map around their own meridian, so that all of them are on it.
GdalFile centred(GDALDataset& file, const Recipe& recipe, const GdalMessages& messages) {
    OGRSpatialReference crs(*file.GetSpatialRef());
    const Turn turn = turn_of(crs);
    double t[6];
    (void)file.GetGeoTransform(t);
    const double east = t[0] + 0.5 * file.GetRasterXSize() * t[1] - turn.middle, degrees = 360 * east / turn.length;
    char* text = nullptr;
    (void)crs.exportToProj4(&text); // of WKT PROJ takes Web Mercator's meridian to be Greenwich
    const std::string own = text ? text : "";
    CPLFree(text);
    static const std::regex meridian(R"re(\+lon_0=([-+.0-9eE]+))re");
    std::smatch found;
    OGRSpatialReference around;
    const bool possible =
        std::regex_search(own, found, meridian) &&
        around.importFromProj4(fmt::format("{}+lon_0={}{}", found.prefix().str(),
                                           std::strtod(found[1].str().c_str(), nullptr) + degrees, found.suffix().str())
                                   .c_str()) == OGRERR_NONE;
    CPLStringList words;
    words.AddString("-a_ullr");
    for (const double edge :
         {t[0] - east, t[3], t[0] - east + file.GetRasterXSize() * t[1], t[3] + file.GetRasterYSize() * t[5]})
        words.AddString(fmt::format("{}", edge).c_str());
    GdalFile made =
        checked(possible ? translated(file, words) : nullptr, recipe,
                "goes on beyond the edge of its map; bring it to the terrain's CRS with gdalwarp -t_srs", messages);
    around.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    made->SetSpatialRef(&around);
    return made;
}

Opened open_image(const Recipe& recipe, GdalMessages& messages) {
    Opened opened;
    opened.chain.push_back(open_raster(recipe.path, "an image", messages));
    if (!recipe.bands.empty()) opened.chain.push_back(select_bands(opened.top(), recipe, messages));
    check_kind(opened.top(), recipe);
    if (recipe.use != RasterUse::classes && opened.top().GetRasterBand(1)->GetColorTable() &&
        opened.top().GetRasterCount() < 3)
        opened.chain.push_back(expand_palette(opened.top(), recipe, messages));
    if (recipe.centred) opened.chain.push_back(centred(opened.top(), recipe, messages));
    if (!recipe.warp_to.empty()) {
        opened.chain.push_back(warp(opened.top(), recipe, messages));
        opened.warped = true;
    }
    messages.forget();
    return opened;
}

// ---- reading -------------------------------------------------------------------------------------------------------

class Reader final : public ImageReader {
public:
    explicit Reader(const std::vector<Recipe>& recipes) : recipes_(recipes), open_(recipes.size()) {}

    void read(std::size_t layer, const Window& pixels, std::uint8_t* rgba) override {
        GdalMessages messages;
        if (!open_[layer]) open_[layer] = std::make_unique<Opened>(open_image(recipes_[layer], messages));
        const Opened& file = *open_[layer];
        const Recipe& recipe = recipes_[layer];
        classes_ = recipe.use == RasterUse::classes;
        if (!file.warped) return read_window(file.top(), pixels, pixels, rgba, recipe, messages);
        // Whole blocks, so that what is warped at once is always the same.
        int across = 0, down = 0;
        file.top().GetRasterBand(1)->GetBlockSize(&across, &down);
        const Window all{0, 0, file.top().GetRasterXSize(), file.top().GetRasterYSize()};
        for (std::int32_t y = pixels.y / down * down; y < pixels.y + pixels.rows; y += down)
            for (std::int32_t x = pixels.x / across * across; x < pixels.x + pixels.columns; x += across) {
                const Window block{x, y, std::min(across, all.columns - x), std::min(down, all.rows - y)};
                block_.resize(block.area() * 4);
                read_window(file.top(), block, block, block_.data(), recipe, messages);
                copy_common(block, pixels, rgba);
            }
    }

private:
    void read_window(GDALDataset& file, const Window& w, const Window& to, std::uint8_t* rgba, const Recipe& recipe,
                     const GdalMessages& messages) {
        GDALRasterBand* const first = file.GetRasterBand(1);
        const bool grey = file.GetRasterCount() < 3, wide = first->GetRasterDataType() == GDT_UInt16;
        CPLErr result = CE_None;
        if (classes_) result = read_classes(*first, w, rgba);
        for (int c = 0; c < 3 && result == CE_None && !classes_; ++c) {
            GDALRasterBand* const band = grey ? first : file.GetRasterBand(c + 1);
            result = wide ? read_wide(*band, w, recipe.white, rgba + c)
                          : band->RasterIO(GF_Read, w.x, w.y, w.columns, w.rows, rgba + c, w.columns, w.rows, GDT_Byte,
                                           4, 4 * static_cast<GSpacing>(w.columns), nullptr);
        }
        const bool thin = wide && recipe.opaque != 65535 && (first->GetMaskFlags() & GMF_ALPHA);
        if (result == CE_None && thin) {
            result = read_wide(*file.GetRasterBand(file.GetRasterCount()), w, recipe.opaque, rgba + 3);
        } else if (result == CE_None)
            result = first->GetMaskBand()->RasterIO(GF_Read, w.x, w.y, w.columns, w.rows, rgba + 3, w.columns, w.rows,
                                                    GDT_Byte, 4, 4 * static_cast<GSpacing>(w.columns), nullptr);
        if (result != CE_None || messages.failed() || messages.warned())
            throw Failure(1,
                          fmt::format("{}: damaged or cut short at rows {}..{} of {}; fetch the file again{}",
                                      recipe.path, to.y, to.y + to.rows - 1, file.GetRasterYSize(), messages.said()));
    }

    // 16 bits to the nearest of 8; white becomes 255.
    CPLErr read_wide(GDALRasterBand& band, const Window& w, std::uint32_t white, std::uint8_t* to) {
        wide_.resize(w.area());
        const CPLErr result = band.RasterIO(GF_Read, w.x, w.y, w.columns, w.rows, wide_.data(), w.columns, w.rows,
                                            GDT_UInt16, 0, 0, nullptr);
        for (std::size_t i = 0; i < wide_.size(); ++i)
            to[4 * i] =
                static_cast<std::uint8_t>((std::min<std::uint32_t>(wide_[i], white) * 255u + white / 2) / white);
        return result;
    }

    // Numbers below 0 count as 0.
    CPLErr read_classes(GDALRasterBand& band, const Window& w, std::uint8_t* to) {
        wide_.resize(w.area());
        const CPLErr result = band.RasterIO(GF_Read, w.x, w.y, w.columns, w.rows, wide_.data(), w.columns, w.rows,
                                            GDT_UInt16, 0, 0, nullptr);
        for (std::size_t i = 0; i < wide_.size(); ++i) {
            to[4 * i] = static_cast<std::uint8_t>(wide_[i] & 255u);
            to[4 * i + 1] = static_cast<std::uint8_t>(wide_[i] >> 8);
            to[4 * i + 2] = 0;
        }
        return result;
    }

    void copy_common(const Window& from, const Window& to, std::uint8_t* rgba) const {
        const std::int32_t x0 = std::max(from.x, to.x), x1 = std::min(from.x + from.columns, to.x + to.columns);
        const std::int32_t y0 = std::max(from.y, to.y), y1 = std::min(from.y + from.rows, to.y + to.rows);
        const auto at = [](const Window& w, std::int32_t x, std::int32_t y) {
            return 4 * (static_cast<std::ptrdiff_t>(y - w.y) * w.columns + (x - w.x));
        };
        for (std::int32_t y = y0; y < y1; ++y)
            std::copy_n(block_.data() + at(from, x0, y), 4 * (x1 - x0), rgba + at(to, x0, y));
    }

    const std::vector<Recipe>& recipes_;
    std::vector<std::unique_ptr<Opened>> open_;
    std::vector<std::uint8_t> block_;
    std::vector<std::uint16_t> wide_;
    bool classes_ = false;
};

// ---- which numbers are white ---------------------------------------------------------------------------------------

// The largest number of a band's pixels that are not masked; looks no further than the first that needs 13 bits.
std::uint32_t largest_number(GDALRasterBand& band, const std::string& path, const GdalMessages& messages) {
    const int columns = band.GetXSize();
    std::vector<double> row(static_cast<std::size_t>(columns));
    std::vector<std::uint8_t> marks(row.size(), 255);
    const bool masked = (band.GetMaskFlags() & (GMF_ALL_VALID | GMF_ALPHA)) == 0;
    double largest = 0;
    for (int y = 0; y < band.GetYSize() && largest < 4096; ++y) {
        read_row(band, y, row.data(), path, messages);
        if (masked) read_row(*band.GetMaskBand(), y, marks.data(), path, messages);
        for (std::size_t i = 0; i < row.size(); ++i)
            if (marks[i] != 0) largest = std::max(largest, row[i]);
    }
    return static_cast<std::uint32_t>(largest);
}

// NBITS of the file; 0: it does not say, or not less than 16.
int bits_of(GDALRasterBand& band) {
    const char* const text = band.GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
    const int bits = text ? std::atoi(text) : 0;
    return bits > 0 && bits < 16 ? bits : 0;
}

// Of the fewest bits that hold the number.
std::uint32_t white_for(std::uint32_t largest) {
    std::uint32_t white = 255;
    while (white < largest) white = 2 * white + 1;
    return white > 4095 ? 65535 : white;
}

// Sets what is white, and says it.
std::string find_white(GDALDataset& file, Recipe& recipe, const GdalMessages& messages) {
    const int count = file.GetRasterCount(), colours = count < 3 ? 1 : 3;
    if (recipe.use == RasterUse::classes || file.GetRasterBand(1)->GetRasterDataType() != GDT_UInt16) return "8 bits";
    const bool alpha = is_alpha(file, count);
    if (const int bits = bits_of(*file.GetRasterBand(1))) {
        recipe.white = (1u << bits) - 1;
        if (alpha) recipe.opaque = recipe.white;
        return fmt::format("{} bits, so that {} is white", bits, recipe.white);
    }
    if (recipe.use == RasterUse::paint) return "16 bits"; // weights, of which the largest need not be all
    std::uint32_t largest = 0;
    for (int b = 1; b <= colours && largest < 4096; ++b)
        largest = std::max(largest, largest_number(*file.GetRasterBand(b), recipe.path, messages));
    recipe.white = white_for(largest);
    if (recipe.white == 65535) return "16 bits, so that 65535 is white";
    if (alpha) recipe.opaque = white_for(largest_number(*file.GetRasterBand(count), recipe.path, messages));
    return fmt::format("numbers up to {} of 16 bits, so that {} is taken as white", largest, recipe.white);
}

// ---- where an image lies -------------------------------------------------------------------------------------------

bool same_crs(const OGRSpatialReference& a, const OGRSpatialReference& b) {
    const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", "CRITERION=EQUIVALENT", nullptr};
    return a.IsSame(&b, options) != 0;
}

OGRSpatialReference crs_of(const std::string& wkt) {
    OGRSpatialReference crs;
    crs.importFromWkt(wkt.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return crs;
}

struct Georeference {
    bool there = false, upright = false;
    bool by_points = false; // by control points or arrays of coordinates: only a warp can place it
    double t[6] = {0, 1, 0, 0, 0, 1};
};
Georeference georeference(GDALDataset& file) {
    Georeference g;
    g.there = file.GetGeoTransform(g.t) == CE_None && g.t[1] * g.t[5] != g.t[2] * g.t[4];
    g.upright = g.t[2] == 0 && g.t[4] == 0 && g.t[1] > 0 && g.t[5] < 0;
    if (g.there) return g;
    g.by_points = file.GetGCPCount() >= 3 || file.GetMetadata("GEOLOCATION");
    g.there = g.by_points;
    g.upright = false;
    return g;
}

// How control points place an image, and what to say of it.
std::string place_by_points(GDALDataset& file, Recipe& recipe) {
    recipe.by_points = true;
    const int count = file.GetGCPCount();
    if (count < 3) return "placed by its arrays of coordinates";
    constexpr int most_bent = 1000; // points that a thin-plate spline can be solved for at once
    double off_px = 0;
    recipe.thin_plate = points_are_bent(file, off_px) && count <= most_bent;
    return recipe.thin_plate
               ? fmt::format("placed by its {} control points, through each of them", count)
               : fmt::format("placed by its {} control points, off the worst by {:.2g} pixels", count, off_px);
}

// Coordinates of an image without a CRS are taken to be the terrain's.
bool needs_warp(GDALDataset& file, const Georeference& g, const Frame& ground) {
    const OGRSpatialReference* const crs = file.GetSpatialRef();
    return !g.upright || (crs && !same_crs(*crs, crs_of(ground.crs_wkt)));
}

// Pixels of an image under a terrain.
struct Under {
    double between[2] = {0, 0}; // from sample to sample, along columns and along rows; 0: the image has no such place
    bool torn = false;          // some lie at one end of the image, some at the other: on both sides of a map's edge
};
Under pixels_under(GDALDataset& file, const Frame& ground) {
    CPLStringList options;
    options.SetNameValue("DST_SRS", ground.crs_wkt.c_str());
    const std::unique_ptr<void, decltype(&GDALDestroyGenImgProjTransformer)> to_pixels(
        GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&file), nullptr, options.List()),
        GDALDestroyGenImgProjTransformer);
    Under under;
    if (!to_pixels) return under;
    const double samples[6] = {ground.origin[0], ground.step[0], 0, ground.origin[1], 0, -ground.step[1]};
    GDALSetGenImgProjTransformerDstGeoTransform(to_pixels.get(), samples);
    double west = HUGE_VAL, east = -HUGE_VAL;
    for (const double v : {0.5, 0.0, 1.0})
        for (const double u : {0.5, 0.0, 1.0}) {
            const double column = u * (ground.columns - 2), row = v * (ground.rows - 2);
            double x[3] = {column, column + 1, column}, y[3] = {row, row, row + 1}, z[3] = {};
            int good[3] = {};
            (void)GDALGenImgProjTransform(to_pixels.get(), TRUE, 3, x, y, z, good);
            if (!good[0] || !good[1] || !good[2] || x[0] < 0 || y[0] < 0 || x[0] > file.GetRasterXSize() ||
                y[0] > file.GetRasterYSize())
                continue;
            west = std::min(west, x[0]), east = std::max(east, x[0]);
            // Between neighbours on both sides of a map's edge lies all of it.
            if (2 * std::max(std::abs(x[1] - x[0]), std::abs(x[2] - x[0])) > file.GetRasterXSize()) continue;
            const double across = std::hypot(x[1] - x[0], y[1] - y[0]), down = std::hypot(x[2] - x[0], y[2] - y[0]);
            if (under.between[0] == 0 && across > 0 && down > 0) under.between[0] = across, under.between[1] = down;
        }
    under.torn = east - west > 4 * std::hypot(under.between[0] * ground.columns, under.between[1] * ground.rows);
    // A map of all longitudes that begins elsewhere than at -180: GDAL lays parts of it on one side of the others.
    double t[6];
    const OGRSpatialReference* const own = file.GetSpatialRef();
    if (own && own->IsGeographic() && file.GetGeoTransform(t) == CE_None)
        under.torn |= file.GetRasterXSize() * t[1] > 359 && t[0] > -179;
    return under;
}

// GDAL chooses the pixels of what it warps by all of an image, and degrees from -180 to 180: too coarse for a terrain
// that is a small part of it, and cut at the antimeridian.
bool suits(GDALDataset& warped, const Frame& ground, const Under& pixels) {
    double t[6];
    if (pixels.between[0] == 0 || warped.GetGeoTransform(t) != CE_None) return true;
    if (pixels.torn) return false;
    if (crs_of(ground.crs_wkt).IsGeographic() && warped.GetRasterXSize() * t[1] > 180) return false;
    constexpr double coarser = 1.5;
    return ground.step[0] / std::abs(t[1]) * ground.step[1] / std::abs(t[5]) * coarser * coarser >
           pixels.between[0] * pixels.between[1];
}

// What gdalwarp is told instead: the terrain and two samples and pixels around it, pixels as fine as there.
std::vector<std::string> cut_to(const Frame& ground, const Under& pixels) {
    double size[2], rim[2];
    for (const std::size_t axis : {0u, 1u}) {
        size[axis] = ground.step[axis] / pixels.between[axis];
        rim[axis] = 2 * std::max(size[axis], ground.step[axis]);
    }
    std::vector<std::string> words{"-te"};
    for (const double edge :
         {ground.origin[0] - rim[0], ground.origin[1] - (ground.rows - 1) * ground.step[1] - rim[1],
          ground.origin[0] + (ground.columns - 1) * ground.step[0] + rim[0], ground.origin[1] + rim[1]})
        words.push_back(fmt::format("{}", edge));
    // Where a map is torn GDAL would take means over as many pixels as lie between its ends.
    words.insert(words.end(),
                 {"-tr", fmt::format("{}", size[0]), fmt::format("{}", size[1]), "-wo", "XSCALE=1", "-wo", "YSCALE=1"});
    return words;
}

ImageLayer stretched(GDALDataset& file, const Frame& ground) {
    ImageLayer layer{file.GetRasterXSize(), file.GetRasterYSize(), {0, 0}, {1, 1}};
    layer.per_sample[0] = static_cast<double>(layer.columns) / (ground.columns - 1);
    layer.per_sample[1] = static_cast<double>(layer.rows) / (ground.rows - 1);
    return layer;
}

// What is stretched must be of the whole terrain, or classes would lie anywhere.
void check_proportions(GDALDataset& file, const Frame& ground, const std::string& path) {
    const double columns = file.GetRasterXSize(), rows = file.GetRasterYSize();
    const double off = columns / rows * (ground.rows / static_cast<double>(ground.columns));
    if (std::abs(off - 1) <= 1.5 / std::min(columns, rows) + 1.5 / std::min(ground.columns, ground.rows)) return;
    throw Failure(1,
                  fmt::format("{}: has {} x {} pixels and no georeference in a CRS that the terrain shares, whose {} "
                              "x {} samples have other proportions; cut it to the terrain, or place it with "
                              "gdal_translate -a_srs -a_ullr",
                              path, columns, rows, ground.columns, ground.rows));
}

ImageLayer placed(GDALDataset& file, const Frame& ground, const std::string& path) {
    const Georeference g = georeference(file);
    ImageLayer layer{file.GetRasterXSize(), file.GetRasterYSize(), {0, 0}, {1, 1}};
    double west = ground.origin[0] - g.t[0];
    // 0..360 and -180..180 name the same places, as do places beyond the edge of a map of all: the nearest turn.
    if (const double turn = turn_of(crs_of(ground.crs_wkt)).length; turn > 0) {
        const double off = west + 0.5 * ((ground.columns - 1) * ground.step[0] - layer.columns * g.t[1]);
        west -= turn * std::round(off / turn);
    }
    layer.first_px[0] = west / g.t[1];
    layer.first_px[1] = (ground.origin[1] - g.t[3]) / g.t[5];
    layer.per_sample[0] = ground.step[0] / g.t[1];
    layer.per_sample[1] = -ground.step[1] / g.t[5];
    const double end[2] = {layer.first_px[0] + (ground.columns - 1) * layer.per_sample[0],
                           layer.first_px[1] + (ground.rows - 1) * layer.per_sample[1]};
    if (end[0] <= 0 || end[1] <= 0 || layer.first_px[0] >= layer.columns || layer.first_px[1] >= layer.rows)
        throw Failure(
            1, fmt::format("{}: lies beside the terrain: it covers x {:.10g}..{:.10g}, y {:.10g}..{:.10g} in the "
                           "terrain's CRS, the terrain x {:.10g}..{:.10g}, y {:.10g}..{:.10g}; give an image of "
                           "the same place, or remove its georeference to stretch it over the terrain",
                           path, g.t[0], g.t[0] + layer.columns * g.t[1], g.t[3] + layer.rows * g.t[5], g.t[3],
                           ground.origin[0], ground.origin[0] + (ground.columns - 1) * ground.step[0],
                           ground.origin[1] - (ground.rows - 1) * ground.step[1], ground.origin[1]));
    return layer;
}

// A sensor's model places an image only over the ground that it saw.
void refuse_rpc(GDALDataset& file, const Georeference& g, const Frame& ground, const std::string& path) {
    if (g.there || ground.crs_wkt.empty() || !file.GetMetadata("RPC")) return;
    throw Failure(1,
                  fmt::format("{}: has no coordinates but a sensor's model (RPC); place it over the heights: gdalwarp "
                              "-rpc -to RPC_DEM=DEM -t_srs CRS {} OUT.tif",
                              path, path));
}

std::string crs_text(GDALDataset& file, const Frame& ground) {
    const OGRSpatialReference* const crs = file.GetSpatialRef();
    const bool other = crs && !same_crs(*crs, crs_of(ground.crs_wkt));
    return !other ? "a grid that is not upright" : crs->GetName() ? crs->GetName() : "its CRS";
}

std::string file_identity(const std::string& path) {
    std::error_code unknown;
    const auto bytes = std::filesystem::file_size(path, unknown);
    const auto time = std::filesystem::last_write_time(path, unknown).time_since_epoch().count();
    return fmt::format("{} {} {}", path, unknown ? 0 : bytes, unknown ? 0 : time);
}

std::string extent_text(const double (&t)[6], int columns, int rows) {
    return fmt::format("x {:.10g}..{:.10g}, y {:.10g}..{:.10g}", t[0], t[0] + columns * t[1], t[3] + rows * t[5], t[3]);
}

// Both extents, of what nobody has compared.
std::string stretched_text(GDALDataset& file, const Georeference& g, const Frame& ground) {
    const bool east_north = g.there && !g.by_points;
    std::string text = fmt::format(
        "stretched over the terrain, because {}: {} x {} pixels{} over {} x {} samples",
        g.there ? "the terrain has no CRS" : "it has no coordinates", file.GetRasterXSize(), file.GetRasterYSize(),
        east_north ? " at " + extent_text(g.t, file.GetRasterXSize(), file.GetRasterYSize()) : "", ground.columns,
        ground.rows);
    if (ground.step[0] > 0)
        text += fmt::format(" at x {:.10g}..{:.10g}, y {:.10g}..{:.10g}", ground.origin[0],
                            ground.origin[0] + (ground.columns - 1) * ground.step[0],
                            ground.origin[1] - (ground.rows - 1) * ground.step[1], ground.origin[1]);
    return text;
}

class Images final : public ImageSource {
public:
    Images(const std::vector<std::string>& paths, const Frame& ground, RasterUse use, const std::string& bands = "") {
        for (const std::string& path : paths) add({path, {}, use}, bands, ground, paths.size());
    }
    [[nodiscard]] std::unique_ptr<ImageReader> reader() const override { return std::make_unique<Reader>(recipes_); }
    [[nodiscard]] std::string identity() const override {
        std::string text;
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const ImageLayer& l = layers[i];
            text += fmt::format("image {}; {} x {} at {} {} by {} {}{}{}{}\n", file_identity(recipes_[i].path),
                                l.columns, l.rows, l.first_px[0], l.first_px[1], l.per_sample[0], l.per_sample[1],
                                recipes_[i].warp_to.empty() ? ""
                                : recipes_[i].centred       ? " centred, warped"
                                                            : " warped",
                                recipes_[i].white == 65535 ? "" : fmt::format(" white {}", recipes_[i].white),
                                recipes_[i].bands.empty() ? "" : fmt::format(" {}", bands_text(recipes_[i])));
        }
        return text;
    }

private:
    static std::string bands_text(const Recipe& recipe) {
        return fmt::format("band{} {}", recipe.bands.size() == 1 ? "" : "s", fmt::join(recipe.bands, ", "));
    }

    void add(Recipe recipe, const std::string& bands, const Frame& ground, std::size_t count) {
        GdalMessages messages;
        const std::string path = recipe.path;
        if (recipe.use == RasterUse::picture)
            recipe.bands = picture_bands(*open_raster(path, "an image", messages), bands, path);
        std::unique_ptr<Opened> opened = std::make_unique<Opened>(open_image(recipe, messages));
        const Georeference g = georeference(opened->top());
        const std::string numbers =
            (recipe.bands.empty() ? "" : bands_text(recipe) + ", ") + find_white(opened->top(), recipe, messages);
        std::string where = "placed by its coordinates";
        if (!g.there || ground.crs_wkt.empty() || ground.step[0] <= 0) {
            if (count > 1)
                throw Failure(1, fmt::format("{}: several images need georeferences, and a terrain with a CRS; give "
                                             "one image, or place all with gdalwarp",
                                             path));
            refuse_rpc(opened->top(), g, ground, path);
            if (recipe.use != RasterUse::picture) check_proportions(opened->top(), ground, path);
            where = stretched_text(opened->top(), g, ground);
            layers.push_back(stretched(opened->top(), ground));
        } else {
            if (needs_warp(opened->top(), g, ground)) {
                where = g.by_points ? place_by_points(opened->top(), recipe)
                                    : where + ", warped from " + crs_text(opened->top(), ground);
                const OGRSpatialReference* const own = opened->top().GetSpatialRef();
                if (own && own->IsProjected() && goes_beyond(opened->top(), turn_of(*own))) {
                    recipe.centred = true;
                    opened.reset();
                    opened = std::make_unique<Opened>(open_image(recipe, messages));
                }
                const Under pixels = recipe.by_points ? Under{} : pixels_under(opened->top(), ground);
                recipe.warp_to = ground.crs_wkt;
                opened.reset();
                opened = std::make_unique<Opened>(open_image(recipe, messages));
                if (!suits(opened->top(), ground, pixels)) {
                    recipe.cut = cut_to(ground, pixels);
                    opened.reset();
                    opened = std::make_unique<Opened>(open_image(recipe, messages));
                }
            }
            layers.push_back(placed(opened->top(), ground, path));
            add_turns(opened->top(), recipe, ground);
        }
        accounts.push_back(fmt::format("{}: {}; {}", path, numbers, where));
        recipes_.push_back(recipe);
    }

    // Of a terrain in degrees, or on a map of all longitudes, that goes across an edge of an image of all of them: the
    // same image on its other side.
    void add_turns(GDALDataset& file, const Recipe& recipe, const Frame& ground) {
        const double turn = turn_of(crs_of(ground.crs_wkt)).length / georeference(file).t[1];
        const ImageLayer nearest = layers.back();
        for (const double turns : {-turn, turn}) {
            ImageLayer beside = nearest;
            beside.first_px[0] += turns;
            const double last = beside.first_px[0] + (ground.columns - 1) * beside.per_sample[0];
            if (turns == 0 || last <= 0 || beside.first_px[0] >= beside.columns) continue;
            if (recipe.use != RasterUse::picture)
                throw Failure(1, fmt::format("{}: ends within the terrain and goes on from its other end; let the "
                                             "terrain be reprojected, without --spacing and --crs",
                                             recipe.path));
            layers.push_back(beside);
            recipes_.push_back(recipe);
        }
    }

    std::vector<Recipe> recipes_;
};

} // namespace

Frame frame_of(const HeightSource& ground) {
    return {ground.columns,
            ground.rows,
            {ground.crs_origin[0], ground.crs_origin[1]},
            {ground.crs_step[0], ground.crs_step[1]},
            ground.crs_wkt};
}

std::vector<int> picture_bands(GDALDataset& file, const std::string& text, const std::string& path) {
    std::vector<int> bands;
    if (!text.empty()) {
        for (std::size_t at = 0; at <= text.size(); at = text.find(',', at) + 1) {
            bands.push_back(find_band(file, text.substr(at, text.find(',', at) - at), path));
            if (text.find(',', at) == std::string::npos) break;
        }
        if (bands.size() != 1 && bands.size() != 3)
            throw Failure(2,
                          fmt::format("--texture-bands {}: must be one band, or three for red, green and blue", text));
        return bands;
    }
    if (file.GetRasterCount() == 2 && !is_alpha(file, 1) && !is_alpha(file, 2))
        throw Failure(
            1, fmt::format("{}: has 2 bands, {}; say which is grey with --texture-bands N", path, named_bands(file)));
    if (file.GetRasterCount() < 3) return {};
    const std::array<std::pair<GDALColorInterp, const char*>, 3> colours{
        {{GCI_RedBand, "red"}, {GCI_GreenBand, "green"}, {GCI_BlueBand, "blue"}}};
    for (const bool by_name : {false, true}) {
        bands.clear();
        for (const auto& [colour, name] : colours) {
            int found = 0, count = 0;
            for (int b = 1; b <= file.GetRasterCount(); ++b) {
                GDALRasterBand& band = *file.GetRasterBand(b);
                if (by_name ? EQUAL(band.GetDescription(), name) : band.GetColorInterpretation() == colour)
                    found = b, ++count;
            }
            if (count == 1) bands.push_back(found);
        }
        if (bands.size() == colours.size()) break;
    }
    if (bands.size() != colours.size() && file.GetRasterCount() > 4)
        throw Failure(1, fmt::format("{}: has {} bands, {}; say which are red, green and blue with --texture-bands "
                                     "R,G,B",
                                     path, file.GetRasterCount(), named_bands(file)));
    const bool all = file.GetRasterCount() == 3 || (file.GetRasterCount() == 4 && is_alpha(file, 4));
    if (bands.size() != colours.size()) bands = {1, 2, 3};
    return all && bands == std::vector{1, 2, 3} ? std::vector<int>{} : bands;
}

std::uint32_t picture_white(GDALRasterBand& band, std::uint32_t largest) {
    const int bits = bits_of(band);
    return bits ? (1u << bits) - 1 : white_for(largest);
}

std::unique_ptr<ImageSource> open_images(const std::vector<std::string>& paths, const Frame& ground,
                                         const std::string& bands) {
    return std::make_unique<Images>(paths, ground, RasterUse::picture, bands);
}

std::unique_ptr<ImageSource> open_raster_map(const std::string& path, const Frame& ground, RasterUse use) {
    return std::make_unique<Images>(std::vector<std::string>{path}, ground, use);
}

} // namespace fjell::baker
