#include "baker/check/second_reading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "baker/read/gdal_file.h"
#include "baker/read/pack_source.h"

namespace fjell::baker {

namespace {

bool is_plain(const Recipe& source, const SourceFacts& facts) {
    return source.inputs.size() == 1 && !source.inputs[0].ends_with(".json") && !is_raw(source.inputs[0]) &&
           source.encoding.value_or("none") == "none" && !source.bbox && facts.reprojected_from.empty();
}

} // namespace

std::string second_reading(const Recipe& source, const SourceFacts& facts, const io::PackFile& pack) {
    if (!is_plain(source, facts)) return {};
    const std::string& path = source.inputs[0];
    const PackHeader& h = pack.pack().header;
    GdalMessages messages;
    const GdalFile file = open_raster(path, "a height field", messages);
    if (file->GetRasterXSize() != static_cast<int>(h.columns) || file->GetRasterYSize() != static_cast<int>(h.rows))
        return {}; // said elsewhere
    const int number = facts.band.empty() ? 1 : std::atoi(facts.band.c_str());
    GDALRasterBand& band = *file->GetRasterBand(number);
    int tagged = 0;
    const double tag = band.GetNoDataValue(&tagged);
    const double zscale = source.zscale.value_or(1), unit = facts.height_unit_m; // with zscale and scale in it
    const double scale = band.GetScale(nullptr), offset = band.GetOffset(nullptr);
    const auto metres = [&](double raw) {
        const double file_unit = scale != 0 && zscale != 0 ? unit / (scale * zscale) : 1;
        return (raw * scale + offset) * file_unit * zscale + source.zoffset.value_or(0);
    };
    const double slack_m =
        0.75 * static_cast<double>(h.quantum_m) + 1e-6 * std::max(std::abs(h.min_m), std::abs(h.max_m));
    const char* const kind = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
    const bool signed_byte = band.GetRasterDataType() == GDT_Byte && kind && EQUAL(kind, "SIGNEDBYTE");
    std::array<double, 6> t{0, 1, 0, 0, 0, -1};
    if (file->GetGeoTransform(t.data()) != CE_None) t = {0, 1, 0, 0, 0, -1};
    const PackSource heights(pack.path());
    const auto reader = heights.reader();
    constexpr std::array<std::array<double, 2>, 5> places{{{0.5, 0.5}, {0.1, 0.2}, {0.9, 0.3}, {0.2, 0.9}, {0.8, 0.8}}};
    for (const auto& [across, down] : places) {
        const auto column = static_cast<std::int32_t>(across * (h.columns - 1));
        const auto row = static_cast<std::int32_t>(down * (h.rows - 1));
        const int x = t[1] < 0 ? static_cast<int>(h.columns) - 1 - column : column;
        const int y = t[5] > 0 ? static_cast<int>(h.rows) - 1 - row : row;
        double raw = 0;
        if (band.RasterIO(GF_Read, x, y, 1, 1, &raw, 1, 1, GDT_Float64, 0, 0, nullptr) != CE_None) continue;
        if (signed_byte && raw > 127) raw -= 256;
        float in_pack = 0;
        ReadStatistics statistics;
        reader->read({column, row, 1, 1}, &in_pack, statistics);
        if (std::isnan(in_pack) || std::isnan(raw) || (tagged != 0 && raw == tag)) continue;
        if (std::abs(metres(raw) - static_cast<double>(in_pack)) > slack_m)
            return fmt::format(
                "{}: read by GDAL alone the height at column {}, row {} is {:.7g} m ({} of type {}); the "
                "pack has {:.7g} m",
                path, column, row, metres(raw), raw, GDALGetDataTypeName(band.GetRasterDataType()), in_pack);
    }
    return {};
}

} // namespace fjell::baker
