// Images and ramps from files.
#include "baker/colour.h"

#include <algorithm>
#include <cmath>
#include <new>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/gdal_file.h"
#include "host/file.h"

namespace fjell::baker {

namespace {

// Which bands make red, green and blue: 1, or 3.
struct Bands {
    GDALRasterBand* rgb[3];
    const GDALColorTable* palette;
    double scale; // to 0..255
};

Bands choose_bands(GDALDataset& file, const std::string& path) {
    GDALRasterBand* const first = file.GetRasterBand(1);
    const GDALDataType type = first->GetRasterDataType();
    const int count = file.GetRasterCount();
    if ((type != GDT_Byte && type != GDT_UInt16) || count > 4 || first->GetColorInterpretation() == GCI_CyanBand)
        throw Failure(1,
                      fmt::format("{}: is no grey, palette or red-green-blue image of 8 or 16 bits ({} bands of {}); "
                                  "convert it with gdal_translate -ot Byte",
                                  path, count, GDALGetDataTypeName(type)));
    const double scale = type == GDT_UInt16 ? 1.0 / 257 : 1.0;
    if (count < 3) return {{first, first, first}, first->GetColorTable(), scale};
    return {{first, file.GetRasterBand(2), file.GetRasterBand(3)}, nullptr, scale};
}

std::uint8_t to_byte(double v) {
    return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0));
}

void fill_row(const Bands& bands, const std::vector<double>& raw, std::size_t channel, std::uint8_t* to) {
    for (std::size_t x = 0; x < raw.size(); ++x) {
        std::uint8_t& out = to[3 * x + channel];
        if (!bands.palette) {
            out = to_byte(raw[x] * bands.scale);
            continue;
        }
        const GDALColorEntry* const entry = bands.palette->GetColorEntry(static_cast<int>(raw[x]));
        const short black = 0; // an index past the palette's end
        const short parts[3] = {entry ? entry->c1 : black, entry ? entry->c2 : black, entry ? entry->c3 : black};
        out = to_byte(parts[channel]);
    }
}

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
    throw Failure(1, fmt::format("{}: {}; see content/ramps/earth.json for a ramp that works", path, what));
}

Ramp::Stop parse_stop(const std::string& path, const nlohmann::json& json, std::size_t index) {
    const auto where = [&] { return fmt::format("stop {}", index); };
    if (!json.is_object() || json.size() != 2 || !json.contains("height_m") || !json.contains("rgb"))
        refuse(path, where() + " must have \"height_m\" and \"rgb\" and nothing else");
    const auto& height = json["height_m"];
    const auto& rgb = json["rgb"];
    if (!height.is_number() || std::abs(height.get<double>()) > 1e9)
        refuse(path, where() + ": \"height_m\" must be a number in -1e9..1e9");
    if (!rgb.is_array() || rgb.size() != 3) refuse(path, where() + ": \"rgb\" must hold three numbers");
    Ramp::Stop stop{height.get<double>(), {}};
    for (std::size_t c = 0; c < 3; ++c) {
        stop.rgb[c] = rgb[c].is_number() ? rgb[c].get<double>() : -1;
        if (!(stop.rgb[c] >= 0 && stop.rgb[c] <= 255)) refuse(path, where() + ": \"rgb\" must hold numbers in 0..255");
    }
    return stop;
}

} // namespace

Image read_image(const std::string& path) {
    GdalMessages messages;
    const GdalFile file = open_raster(path, "an image", messages);
    const Bands bands = choose_bands(*file, path);
    Image image;
    image.width = file->GetRasterXSize();
    image.height = file->GetRasterYSize();
    const auto width = static_cast<std::size_t>(image.width);
    try {
        image.rgb.resize(width * static_cast<std::size_t>(image.height) * 3);
        std::vector<double> raw(width);
        for (int y = 0; y < image.height; ++y)
            for (std::size_t c = 0; c < 3; ++c) {
                if (c == 0 || bands.rgb[c] != bands.rgb[0]) read_row(*bands.rgb[c], y, raw.data(), path, messages);
                fill_row(bands, raw, c, image.rgb.data() + static_cast<std::size_t>(y) * width * 3);
            }
    } catch (const std::bad_alloc&) {
        throw Failure(
            3, fmt::format("{}: not enough memory for {} x {} pixels; make it smaller with gdal_translate -outsize",
                           path, image.width, image.height));
    }
    return image;
}

Ramp read_ramp(const std::string& path) {
    const auto json = nlohmann::json::parse(host::read_text(path), nullptr, false, true);
    if (!json.is_object()) refuse(path, "is not a JSON object");
    for (const auto& [key, value] : json.items())
        if (key != "stops" && key != "relative" && key != "comment")
            refuse(path, fmt::format("unknown field \"{}\"", key));
    Ramp ramp;
    if (json.contains("relative")) {
        if (!json["relative"].is_boolean()) refuse(path, "\"relative\" must be true or false");
        ramp.relative = json["relative"].get<bool>();
    }
    if (!json.contains("stops") || !json["stops"].is_array() || json["stops"].size() < 2)
        refuse(path, "\"stops\" must be a list of at least two");
    for (const auto& entry : json["stops"]) {
        const Ramp::Stop stop = parse_stop(path, entry, ramp.stops.size());
        if (!ramp.stops.empty() && stop.height_m <= ramp.stops.back().height_m)
            refuse(path, fmt::format("stop {}: heights must rise from stop to stop", ramp.stops.size()));
        ramp.stops.push_back(stop);
    }
    return ramp;
}

} // namespace fjell::baker
