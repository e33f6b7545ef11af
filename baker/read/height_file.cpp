#include "baker/read/height_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

namespace fjell::baker {

namespace {

// An identity table of greys, as 8-bit BMPs carry, is no palette.
bool is_grey_table(const GDALColorTable& table) {
    for (int i = 0; i < table.GetColorEntryCount(); ++i) {
        const GDALColorEntry& c = *table.GetColorEntry(i);
        if (c.c1 != i || c.c2 != i || c.c3 != i) return false;
    }
    return true;
}

void check_size(GDALDataset& file, const std::string& path) {
    const int columns = file.GetRasterXSize(), rows = file.GetRasterYSize();
    if (columns < 2 || rows < 2)
        throw Failure(1,
                      fmt::format("{}: has {} x {} samples; a height field needs at least 2 x 2", path, columns, rows));
}

bool says_where(GDALRasterBand& band) { // and holds no numbers of its own
    return band.GetColorInterpretation() == GCI_AlphaBand;
}

// Which band holds heights. Throws Failure where only the user can tell.
int choose_band(GDALDataset& file, const std::string& wanted, const std::string& path) {
    const int count = file.GetRasterCount();
    if (!wanted.empty()) return find_band(file, wanted, path);
    std::vector<int> heights, named;
    for (int b = 1; b <= count; ++b) {
        if (says_where(*file.GetRasterBand(b))) continue;
        heights.push_back(b);
        if (named_as_elevation(file.GetRasterBand(b)->GetDescription())) named.push_back(b);
    }
    if (heights.empty()) return 1;
    if (heights.size() == 1) return heights[0];
    if (named.size() == 1) return named[0];
    throw Failure(1, fmt::format("{}: has {} bands, {}; say which holds heights with --band N or --band NAME", path,
                                 count, named_bands(file)));
}

// Whether three bands hold the same everywhere: grey heights, saved as an image.
bool is_grey(GDALDataset& file, const std::string& path) {
    GdalMessages messages;
    const auto columns = static_cast<std::size_t>(file.GetRasterXSize());
    std::vector<std::uint8_t> first(columns), other(columns);
    for (int y = 0; y < file.GetRasterYSize(); ++y) {
        read_row(*file.GetRasterBand(1), y, first.data(), path, messages);
        for (const int b : {2, 3}) {
            read_row(*file.GetRasterBand(b), y, other.data(), path, messages);
            if (first != other) return false;
        }
    }
    return true;
}

// The band that holds heights of a file that is not coded.
int grey_band(GDALDataset& file, const std::string& wanted, const std::string& path) {
    GDALRasterBand& first = *file.GetRasterBand(1);
    const bool colours = (file.GetRasterCount() >= 3 && first.GetRasterDataType() == GDT_Byte) ||
                         first.GetColorInterpretation() == GCI_RedBand;
    int number = 1, wide = 0, count = 0; // beside colours for looking at: Vertical Mapper's grids
    for (int b = 1; b <= file.GetRasterCount(); ++b)
        if (file.GetRasterBand(b)->GetRasterDataType() != GDT_Byte) wide = b, ++count;
    if (wanted.empty() && colours && first.GetRasterDataType() == GDT_Byte && count == 1) {
        number = wide;
    } else if (wanted.empty() && colours) {
        if (file.GetRasterCount() < 3 || first.GetRasterDataType() != GDT_Byte || !is_grey(file, path))
            throw Failure(1, fmt::format("{}: has {} bands of colour; if they are Terrarium or Mapbox heights, give "
                                         "--encoding terrarium or terrain-rgb, if it is an image, make it one band of "
                                         "heights first",
                                         path, file.GetRasterCount()));
    } else {
        number = choose_band(file, wanted, path);
    }
    GDALRasterBand& band = *file.GetRasterBand(number);
    const GDALDataType type = band.GetRasterDataType();
    if (GDALDataTypeIsComplex(type))
        throw Failure(1, fmt::format("{}: holds complex numbers, not heights; extract one part first", path));
    // Of more than 8 bits a table of colours is for looking at: GRASS and Imagine write one beside heights.
    const GDALColorTable* const table = type == GDT_Byte ? band.GetColorTable() : nullptr;
    if (table && !is_grey_table(*table))
        throw Failure(
            1,
            fmt::format(
                "{}: is a palette image, whose numbers are no heights; if its colours are Terrarium or Mapbox heights, "
                "give --encoding terrarium or terrain-rgb, if they are greys, convert it first: "
                "gdal_translate -expand gray {} OUT.tif",
                path, path));
    return number;
}

// Bytes that count from -128 to 127. GDAL has had a type of its own for them since 3.7.
bool is_signed_byte(GDALRasterBand& band) {
    const char* const type = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
    return band.GetRasterDataType() == GDT_Byte && type && EQUAL(type, "SIGNEDBYTE");
}

void check_coded(GDALDataset& file, const std::string& path) {
    const int bands = file.GetRasterCount();
    if (bands == 1 && file.GetRasterBand(1)->GetColorTable()) return; // as what makes pictures small stores them
    if ((bands != 3 && bands != 4) || file.GetRasterBand(1)->GetRasterDataType() != GDT_Byte)
        throw Failure(1, fmt::format("{}: has {} bands of {}; --encoding is for pictures of 8-bit red, green and blue, "
                                     "so leave it out",
                                     path, bands, GDALGetDataTypeName(file.GetRasterBand(1)->GetRasterDataType())));
}

// Formats whose blocks can be found without decoding those before them.
bool is_sequential(GDALDataset& file, const std::string& path) {
    constexpr std::array<const char*, 12> direct{"GTiff", "COG", "VRT",  "SRTMHGT", "BMP", "EHdr",
                                                 "ENVI",  "HFA", "DTED", "AIG",     "BT",  "JP2OpenJPEG"};
    const std::string name = file.GetDriver() ? file.GetDriver()->GetDescription() : "";
    const bool packed = path.find("/vsigzip/") != std::string::npos || path.find("/vsizip/") != std::string::npos ||
                        path.find("/vsitar/") != std::string::npos || path.ends_with(".gz");
    return packed || std::find(direct.begin(), direct.end(), name) == direct.end();
}

Blocks blocks_of(GDALRasterBand& band, const Placement& at) {
    Blocks b;
    band.GetBlockSize(&b.columns, &b.rows);
    b.columns = std::clamp(b.columns, 1, at.columns);
    b.rows = std::clamp(b.rows, 1, at.rows);
    if (at.flip_x) b.x = at.columns % b.columns;
    if (at.flip_y) b.y = at.rows % b.rows;
    return b;
}

std::string identity_of(GDALDataset& file, const std::string& path) {
    std::string text = path;
    char** const names = file.GetFileList();
    for (char** name = names; name && *name; ++name) {
        VSIStatBufL status{};
        // Of a packed file GDAL learns while it reads how long it is inside.
        const char* const file_name = STARTS_WITH(*name, "/vsigzip/") ? *name + std::strlen("/vsigzip/") : *name;
        if (VSIStatL(file_name, &status) == 0) // to the nanosecond: scripts make two files in a second
            text +=
                fmt::format("|{} {} {}.{:09}", *name, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
    }
    CSLDestroy(names);
    return text;
}

// GDAL's mask for a tag reads every sample twice: numbers are compared here instead, as closely as GDAL does it.
Decoding::Void void_of(double number, GDALDataType type) {
    constexpr double ulps = 10;
    if (type == GDT_Float32) {
        const double stored = static_cast<double>(static_cast<float>(
            std::clamp<double>(number, std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max())));
        return {stored, ulps * std::numeric_limits<float>::epsilon() * std::abs(stored)};
    }
    if (type == GDT_Float64) return {number, ulps * std::numeric_limits<double>::epsilon() * std::abs(number)};
    return {number, 0};
}

// What the file says is no height, by its tag, and what the user says (--void).
void find_voids_of(GDALRasterBand& band, const ReadOptions& options, Decoding& d) {
    const GDALDataType type = options.encoding == Encoding::none ? band.GetRasterDataType() : GDT_Float64;
    int tagged = 0;
    const double tag = band.GetNoDataValue(&tagged);
    if (options.encoding == Encoding::none && tagged != 0 && !std::isnan(tag)) d.voids.push_back(void_of(tag, type));
    for (const double number : options.voids.numbers) d.voids.push_back(void_of(number, type));
    d.all_ground = options.voids.no_others;
}

bool fits_float(GDALDataType type) {
    return type == GDT_Byte || type == GDT_UInt16 || type == GDT_Int16 || type == GDT_Float32;
}

// Heights of a GeoTIFF of our own disk are read once, along its blocks: GDAL's cache would keep them for nobody, in
// memory that is touched for the first time. A band among others is cut out of what GDAL reads for all of them, and
// what lies far away GDAL fetches by many blocks at once.
bool reads_by_blocks(GDALDataset& file, const std::string& path, int columns, int rows) {
    constexpr std::int64_t largest = std::int64_t{16} << 20; // samples; beyond it a block is cut into windows
    const std::string_view driver = file.GetDriver() ? file.GetDriver()->GetDescription() : "";
    return driver == "GTiff" && file.GetRasterCount() == 1 && !path.starts_with("/vsi") &&
           std::int64_t{columns} * rows <= largest;
}

template <typename T>
void to_floats(const std::byte* from, std::size_t count, float* to) {
    const T* const raw = static_cast<const T*>(static_cast<const void*>(from));
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<float>(raw[i]);
}

} // namespace

HeightFile::HeightFile(const std::string& path, const ReadOptions& options) : encoding_(options.encoding) {
    GdalMessages messages;
    file_ = open_raster(path, "a height field", messages, options.size);
    check_size(*file_, path);
    const bool coded = encoding_ != Encoding::none;
    coded ? check_coded(*file_, path) : void(band_ = grey_band(*file_, options.band, path));
    GDALRasterBand& first = *file_->GetRasterBand(band_);
    facts_.path = path;
    facts_.at = place(*file_, path);
    facts_.blocks = blocks_of(first, facts_.at);
    facts_.sequential = is_sequential(*file_, path);
    facts_.identity = identity_of(*file_, path);
    find_voids_of(first, options, facts_.decoding);
    facts_.driver = is_raw(path)         ? options.size ? "raw" : "raw, taken as a square"
                    : file_->GetDriver() ? file_->GetDriver()->GetDescription()
                                         : "";
    facts_.type =
        fmt::format("{}{}", is_signed_byte(first) ? "signed " : "", GDALGetDataTypeName(first.GetRasterDataType()));
    if (coded) {
        facts_.decoding.scaling = {1, 0, options.zscale.value_or(1), options.zoffset_m};
        facts_.decoding.whole = true;
        facts_.step = encoding_ == Encoding::terrarium ? 1.0 / 256 : 0.1;
        if (file_->GetRasterCount() == 4) mask_ = file_->GetRasterBand(4);
        if (const GDALColorTable* const table = file_->GetRasterCount() == 1 ? first.GetColorTable() : nullptr) {
            palette_.resize(256, {0, 0, 0});
            for (int i = 0; i < std::min(table->GetColorEntryCount(), 256); ++i) {
                const GDALColorEntry& c = *table->GetColorEntry(i);
                palette_[static_cast<std::size_t>(i)] = {
                    static_cast<std::uint8_t>(c.c1), static_cast<std::uint8_t>(c.c2), static_cast<std::uint8_t>(c.c3)};
            }
        }
        return;
    }
    facts_.decoding.scaling = scaling_of(first, file_->GetSpatialRef(), options, path);
    facts_.height_unit =
        options.vertical_unit.empty() ? unit_name(first, file_->GetSpatialRef()) : options.vertical_unit;
    int tagged = 0;
    (void)first.GetNoDataValue(&tagged);
    tagged_ = tagged != 0;
    facts_.band = file_->GetRasterCount() == 1 ? "" : fmt::format("{} {}", band_, first.GetDescription());
    facts_.decoding.whole = GDALDataTypeIsInteger(first.GetRasterDataType()) != 0;
    signed_byte_ = is_signed_byte(first);
    floats_ = fits_float(first.GetRasterDataType());
    first.GetBlockSize(&block_columns_, &block_rows_);
    by_blocks_ = floats_ && reads_by_blocks(*file_, path, block_columns_, block_rows_);
    const int flags = first.GetMaskFlags();
    if (!(flags & GMF_ALL_VALID) && (!(flags & GMF_NODATA) || (flags & (GMF_ALPHA | GMF_PER_DATASET))))
        mask_ = first.GetMaskBand();
    facts_.voids = mask_ ? "mask" : tagged_ ? fmt::format("no-data {}", first.GetNoDataValue()) : "";
}

void HeightFile::refuse(const Window& in_file, const GdalMessages& messages) {
    const std::string_view driver = file_->GetDriver() ? file_->GetDriver()->GetDescription() : "";
    if (driver == "VRT" && !is_raw(facts_.path))
        throw Failure(1,
                      fmt::format("{}: one of the files that it names is missing or damaged; fetch that one again, or "
                                  "make the mosaic again with gdalbuildvrt{}",
                                  facts_.path, messages.said()));
    throw Failure(1, fmt::format("{}: damaged or cut short at rows {} to {} of {}; fetch the file again{}", facts_.path,
                                 in_file.y, in_file.y + in_file.rows - 1, facts_.at.rows, messages.said()));
}

// Warnings count, because some drivers only warn about missing data and hand out zeros.
void HeightFile::band(int number, const Window& in_file, void* to, GDALDataType type) {
    const GdalMessages messages;
    GDALRasterBand& band = number == 0 ? *mask_ : *file_->GetRasterBand(number);
    const CPLErr result = band.RasterIO(GF_Read, in_file.x, in_file.y, in_file.columns, in_file.rows, to,
                                        in_file.columns, in_file.rows, type, 0, 0, nullptr);
    if (result != CE_None || messages.failed() || messages.warned()) refuse(in_file, messages);
}

bool HeightFile::is_whole_blocks(const Window& w) const {
    const auto ends = [](std::int32_t first, std::int32_t count, int block, std::int32_t size) {
        return first % block == 0 && (first + count == size || (first + count) % block == 0);
    };
    return ends(w.x, w.columns, block_columns_, facts_.at.columns) && ends(w.y, w.rows, block_rows_, facts_.at.rows);
}

void HeightFile::read_blocks(const Window& in_file, float* to) {
    const GdalMessages messages;
    GDALRasterBand& band = *file_->GetRasterBand(band_);
    const GDALDataType type = band.GetRasterDataType();
    const auto sample_bytes = static_cast<std::size_t>(GDALGetDataTypeSizeBytes(type));
    block_.resize(static_cast<std::size_t>(block_columns_) * static_cast<std::size_t>(block_rows_) * sample_bytes);
    for (std::int32_t y = in_file.y; y < in_file.y + in_file.rows; y += block_rows_)
        for (std::int32_t x = in_file.x; x < in_file.x + in_file.columns; x += block_columns_) {
            const CPLErr result = band.ReadBlock(x / block_columns_, y / block_rows_, block_.data());
            if (result != CE_None || messages.failed() || messages.warned()) refuse(in_file, messages);
            const Window part = common(in_file, {x, y, block_columns_, block_rows_});
            for (std::int32_t row = 0; row < part.rows; ++row) {
                const std::byte* const from = block_.data() + static_cast<std::size_t>(row) *
                                                                  static_cast<std::size_t>(block_columns_) *
                                                                  sample_bytes;
                float* const at =
                    to + static_cast<std::ptrdiff_t>(y + row - in_file.y) * in_file.columns + (x - in_file.x);
                const auto count = static_cast<std::size_t>(part.columns);
                switch (type) {
                case GDT_Byte: to_floats<std::uint8_t>(from, count, at); break;
                case GDT_UInt16: to_floats<std::uint16_t>(from, count, at); break;
                case GDT_Int16: to_floats<std::int16_t>(from, count, at); break;
                default: to_floats<float>(from, count, at);
                }
            }
        }
}

// Numbers that floats hold, straight into place.
void HeightFile::floats(const Window& in_file, float* to) {
    if (by_blocks_ && is_whole_blocks(in_file)) return read_blocks(in_file, to);
    band(band_, in_file, to, GDT_Float32);
}

void HeightFile::read_coded(const Window& in_file) {
    const std::size_t area = in_file.area();
    raw_.resize(area);
    colours_.resize(3 * area);
    for (int b = 0; b < 3; ++b)
        band(palette_.empty() ? b + 1 : 1, in_file, colours_.data() + static_cast<std::size_t>(b) * area, GDT_Byte);
    if (!palette_.empty()) // three times the same places in it
        for (std::size_t i = 0; i < 3 * area; ++i) colours_[i] = palette_[colours_[i]][i / area];
    const std::uint8_t *const red = colours_.data(), *const green = red + area, *const blue = green + area;
    const bool terrarium = encoding_ == Encoding::terrarium;
    for (std::size_t i = 0; i < area; ++i) {
        const int packed = red[i] << 16 | green[i] << 8 | blue[i];
        raw_[i] = terrarium ? packed / 256.0 - 32768 : (packed - 100000) / 10.0;
    }
}

// marks_: 0 where there is no height or none is wanted; in the file's order. Empty: all are valid.
void HeightFile::read_marks(const Window& in_file, const std::uint8_t* wanted) {
    marks_.clear();
    if (!mask_ && !wanted) return;
    marks_.assign(in_file.area(), 255);
    if (mask_) band(0, in_file, marks_.data(), GDT_Byte);
    if (!wanted) return;
    const auto columns = static_cast<std::size_t>(in_file.columns), rows = static_cast<std::size_t>(in_file.rows);
    for (std::size_t y = 0; y < rows; ++y)
        for (std::size_t x = 0; x < columns; ++x) {
            const std::size_t from_x = facts_.at.flip_x ? columns - 1 - x : x;
            const std::size_t from_y = facts_.at.flip_y ? rows - 1 - y : y;
            if (wanted[from_y * columns + from_x] == 0) marks_[y * columns + x] = 0;
        }
}

template <typename T>
void HeightFile::read_as(const Window& in_file, const Window& window, T* raw, float* to, ReadStatistics& statistics) {
    const auto columns = static_cast<std::size_t>(window.columns);
    const bool flip_x = facts_.at.flip_x, flip_y = facts_.at.flip_y;
    for (int row = 0; row < in_file.rows; ++row) {
        const std::size_t start = static_cast<std::size_t>(row) * columns;
        const RowPlace place{flip_x ? window.x + window.columns - 1 : window.x,
                             flip_y ? window.y + window.rows - 1 - row : window.y + row, flip_x ? -1 : 1};
        decode_row(raw + start, marks_.empty() ? nullptr : marks_.data() + start, to + start, columns, facts_.decoding,
                   place, statistics);
        if (flip_x) std::reverse(to + start, to + start + columns);
    }
    for (int row = 0; flip_y && row < window.rows / 2; ++row) {
        float* const a = to + static_cast<std::size_t>(row) * columns;
        std::swap_ranges(a, a + columns, to + static_cast<std::size_t>(window.rows - 1 - row) * columns);
    }
}

bool HeightFile::covers(const Window& window) const {
    if (!tagged_ || mask_) return true;
    Window in_file = window;
    if (facts_.at.flip_x) in_file.x = facts_.at.columns - window.x - window.columns;
    if (facts_.at.flip_y) in_file.y = facts_.at.rows - window.y - window.rows;
    const GdalMessages messages; // what a file cannot say about itself is no failure
    return file_->GetRasterBand(band_)->GetDataCoverageStatus(in_file.x, in_file.y, in_file.columns, in_file.rows, 0,
                                                              nullptr) != GDAL_DATA_COVERAGE_STATUS_EMPTY;
}

void HeightFile::read(const Window& window, float* to, ReadStatistics& statistics, const std::uint8_t* wanted) {
    Window in_file = window;
    if (facts_.at.flip_x) in_file.x = facts_.at.columns - window.x - window.columns;
    if (facts_.at.flip_y) in_file.y = facts_.at.rows - window.y - window.rows;
    read_marks(in_file, wanted);
    if (floats_) {
        floats(in_file, to);
        if (signed_byte_)
            for (std::size_t i = 0; i < in_file.area(); ++i) to[i] -= to[i] > 127 ? 256.0f : 0.0f;
        read_as(in_file, window, to, to, statistics);
        return;
    }
    if (encoding_ == Encoding::none) {
        raw_.resize(in_file.area());
        band(band_, in_file, raw_.data(), GDT_Float64);
    } else {
        read_coded(in_file);
    }
    read_as(in_file, window, raw_.data(), to, statistics);
}

} // namespace fjell::baker
