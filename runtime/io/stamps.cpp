#include "io/stamps.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "fjell/pack.h"
#include "fjell/texture.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::io {

namespace {

using nlohmann::json;

constexpr const char* shape_names[] = {"raise",   "level", "crater",  "path", "noise", "smooth", "heights",
                                       "restore", "paint", "unpaint", "hole", "fill",  "lock",   "unlock"};
static_assert(std::size(shape_names) == static_cast<std::size_t>(StampShape::unlock) + 1,
              "a shape has a name: add it, and what it reads to the tables below");

constexpr std::uint32_t bit(StampShape shape) {
    return 1u << static_cast<std::uint32_t>(shape);
}
template <typename... Shapes>
constexpr std::uint32_t bits(Shapes... shapes) {
    return (bit(shapes) | ...);
}
constexpr std::uint32_t by_rectangle = bit(StampShape::heights);
constexpr std::uint32_t by_line = bit(StampShape::path);
constexpr std::uint32_t locking = bits(StampShape::lock, StampShape::unlock);
constexpr std::uint32_t by_either = bits(StampShape::paint, StampShape::unpaint) | locking; // by a centre or by a line
constexpr std::uint32_t all_shapes = (1u << std::size(shape_names)) - 1;
constexpr std::uint32_t by_centre = all_shapes & ~(by_rectangle | by_line);
constexpr std::uint32_t moving = all_shapes & ~(by_either | bits(StampShape::hole, StampShape::fill));

constexpr double largest = 1e8, smallest = 1e-6;

struct NumberOf {
    const char* name;
    float Stamp::*field;
    double least, most;
    std::uint32_t read_by, needed_by;
};
constexpr NumberOf numbers[] = {
    {"radius_m", &Stamp::radius_m, 0, largest, by_centre | by_line, by_line},
    {"falloff_m", &Stamp::falloff_m, 0, largest, (by_centre | by_line) & ~locking, 0},
    {"amount_m", &Stamp::amount_m, -largest, largest, bits(StampShape::raise, StampShape::crater, StampShape::noise),
     bits(StampShape::raise, StampShape::crater, StampShape::noise)},
    {"amount_m", &Stamp::amount_m, 0, largest, bits(StampShape::lock), bits(StampShape::lock)},
    {"height_m", &Stamp::height_m, -largest, largest, bits(StampShape::level), bits(StampShape::level)},
    {"slope_x", &Stamp::slope_x, -largest, largest, bits(StampShape::level), 0},
    {"slope_z", &Stamp::slope_z, -largest, largest, bits(StampShape::level), 0},
    {"strength", &Stamp::strength, 0, 1, all_shapes, 0},
    {"morph_s", &Stamp::morph_s, 0, largest, moving, 0},
    {"wavelength_m", &Stamp::wavelength_m, smallest, largest, bits(StampShape::noise), bits(StampShape::noise)},
};

// The file, the line and the stamp are added where stamps are listed.
[[noreturn]] void unfit(const std::string& what) {
    throw Failure(1, what);
}

double within(const json& value, const char* key, double least, double most) {
    if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
        unfit(fmt::format("\"{}\" must hold numbers in {}..{}", key, least, most));
    return value.get<double>();
}
std::int64_t whole_within(const json& value, const char* key, std::int64_t least, std::int64_t most) {
    const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <= static_cast<std::uint64_t>(most)
                                                 : value.is_number_integer() && value.get<std::int64_t>() <= most;
    if (!fits || value.get<std::int64_t>() < least)
        unfit(fmt::format("\"{}\" must hold whole numbers in {}..{}", key, least, most));
    return value.get<std::int64_t>();
}
const json& list_of(const json& value, const char* key, std::size_t least, std::size_t most) {
    if (!value.is_array() || value.size() < least || value.size() > most)
        unfit(least == most ? fmt::format("\"{}\" must be a list of {}", key, least)
                            : fmt::format("\"{}\" must be a list of {} to {}", key, least, most));
    return value;
}

StampShape shape_of(const json& object) {
    const auto found = object.find("shape");
    if (found != object.end() && found->is_string())
        for (std::size_t i = 0; i < std::size(shape_names); ++i)
            if (*found == shape_names[i]) return static_cast<StampShape>(i);
    unfit(fmt::format("\"shape\" must be one of {}", fmt::join(shape_names, ", ")));
}

// Paint and locks lie at any height.
void read_points(const json& value, KeptStamp& kept) {
    const bool flat = kept.plain.shape != StampShape::path;
    for (const json& point : list_of(value, "points", 2, max_path_points)) {
        list_of(point, flat ? "points: [x, z]" : "points: [x, z, height]", flat ? 2 : 3, flat ? 2 : 3);
        kept.points.push_back({within(point[0], "points", -largest, largest),
                               within(point[1], "points", -largest, largest),
                               flat ? 0 : static_cast<float>(within(point[2], "points", -largest, largest))});
    }
}

// "first": [column, row], "columns" and "rows"; then "heights_m" and "mask" have one number a sample.
void read_rectangle(const json& object, KeptStamp& kept) {
    constexpr std::int64_t most = max_columns;
    const auto at = [&](const char* key) -> const json& {
        const auto found = object.find(key);
        if (found == object.end()) unfit(fmt::format("\"{}\" is missing: a rectangle has first, columns, rows", key));
        return *found;
    };
    const json& first = list_of(at("first"), "first", 2, 2);
    kept.plain.first = {static_cast<std::int32_t>(whole_within(first[0], "first", -most, most)),
                        static_cast<std::int32_t>(whole_within(first[1], "first", -most, most))};
    kept.plain.columns = static_cast<std::int32_t>(whole_within(at("columns"), "columns", 1, most));
    kept.plain.rows = static_cast<std::int32_t>(whole_within(at("rows"), "rows", 1, most));
    const std::size_t samples =
        static_cast<std::size_t>(kept.plain.columns) * static_cast<std::size_t>(kept.plain.rows);
    if (object.contains("heights_m"))
        for (const json& height : list_of(object["heights_m"], "heights_m", samples, samples))
            kept.heights_m.push_back(height.is_null()
                                         ? std::numeric_limits<float>::quiet_NaN()
                                         : static_cast<float>(within(height, "heights_m", -largest, largest)));
    if (object.contains("mask"))
        for (const json& share : list_of(object["mask"], "mask", samples, samples))
            kept.mask.push_back(static_cast<std::uint8_t>(whole_within(share, "mask", 0, 255)));
}

// Whether a stamp of that shape has a field of that name.
bool is_read(std::string_view key, StampShape shape) {
    if (key == "shape" || key == "comment") return true;
    if (key == "first" || key == "columns" || key == "rows" || key == "mask") return true;
    if (key == "at") return (bit(shape) & by_centre) != 0;
    if (key == "points") return (bit(shape) & (by_line | by_either)) != 0;
    if (key == "rgb" || key == "material") return shape == StampShape::paint;
    if (key == "seed") return shape == StampShape::noise;
    if (key == "heights_m") return shape == StampShape::heights;
    return std::ranges::any_of(numbers,
                               [&](const NumberOf& n) { return key == n.name && (n.read_by & bit(shape)) != 0; });
}

json timed_json(const TimedStamp& timed) {
    json object = stamp_json(timed.what);
    object["frame"] = timed.frame;
    return object;
}

constexpr std::size_t most_stamps = 1'000'000, most_frame = 10'000'000;

} // namespace

KeptStamp stamp_of(const json& object) {
    if (!object.is_object()) unfit("must be an object { ... }");
    KeptStamp kept;
    Stamp& s = kept.plain;
    s.shape = shape_of(object);
    for (const auto& [key, value] : object.items())
        if (!is_read(key, s.shape))
            unfit(fmt::format("\"{}\" is no field of a stamp of shape {}; remove it", key,
                              shape_names[static_cast<std::size_t>(s.shape)]));
    const bool rectangle = object.contains("columns") || object.contains("rows") || object.contains("first") ||
                           object.contains("mask") || s.shape == StampShape::heights;
    const auto needs = [&](const char* key) {
        if (!object.contains(key)) unfit(fmt::format("\"{}\" is missing", key));
    };
    for (const NumberOf& n : numbers) {
        if ((n.needed_by & bit(s.shape)) != 0) needs(n.name);
        if (object.contains(n.name) && (n.read_by & bit(s.shape)) != 0)
            s.*n.field = static_cast<float>(within(object[n.name], n.name, n.least, n.most));
    }
    if (object.contains("at")) {
        const json& at = list_of(object["at"], "at", 2, 2);
        s.x_m = within(at[0], "at", -largest, largest), s.z_m = within(at[1], "at", -largest, largest);
    }
    const bool by_points = object.contains("points");
    if (by_points) needs("radius_m");
    if ((bit(s.shape) & by_centre) != 0 && !rectangle && !by_points) needs("at"), needs("radius_m");
    if (s.shape == StampShape::crater && !(s.radius_m > 0)) unfit("\"radius_m\" of a crater must be above 0");
    if (object.contains("seed"))
        s.seed = static_cast<std::uint32_t>(whole_within(object["seed"], "seed", 0, 0xffff'ffff));
    if (s.shape == StampShape::path) needs("points");
    if (by_points) read_points(object["points"], kept);
    if (s.shape == StampShape::paint) {
        needs("rgb");
        const json& rgb = list_of(object["rgb"], "rgb", 3, 3);
        for (std::size_t c = 0; c < 3; ++c) s.rgb[c] = static_cast<std::uint8_t>(whole_within(rgb[c], "rgb", 0, 255));
    }
    if (object.contains("material"))
        s.material = static_cast<std::uint8_t>(
            whole_within(object["material"], "material", 0, std::int64_t{max_splat_names} - 1));
    if (s.shape == StampShape::heights) needs("heights_m");
    if (rectangle) read_rectangle(object, kept);
    return kept;
}

json stamp_json(const KeptStamp& kept) {
    const Stamp& s = kept.plain;
    json object = {{"shape", shape_names[static_cast<std::size_t>(s.shape)]}};
    for (const NumberOf& n : numbers)
        if ((n.read_by & bit(s.shape)) != 0) object[n.name] = s.*n.field;
    if ((bit(s.shape) & by_centre) != 0 && kept.points.empty()) object["at"] = {s.x_m, s.z_m};
    if (s.shape == StampShape::paint) {
        object["rgb"] = {s.rgb[0], s.rgb[1], s.rgb[2]};
        if (s.material != no_material) object["material"] = s.material;
    }
    if (s.shape == StampShape::noise) object["seed"] = s.seed;
    for (const StampPoint& p : kept.points)
        object["points"].push_back(s.shape == StampShape::path ? json({p.x_m, p.z_m, p.height_m})
                                                               : json({p.x_m, p.z_m}));
    if (s.columns == 0) return object;
    object["first"] = {s.first.column, s.first.row};
    object["columns"] = s.columns;
    object["rows"] = s.rows;
    for (const float height_m : kept.heights_m)
        object["heights_m"].push_back(std::isnan(height_m) ? json() : json(height_m));
    for (const std::uint8_t share : kept.mask) object["mask"].push_back(share);
    return object;
}

std::vector<TimedStamp> parse_stamps(std::string_view text, const std::string& name) {
    const json file = parse_json(text, name, JsonComments::yes);
    const auto refuse = [](const std::string& where, const std::string& what) {
        throw Failure(1, fmt::format("{}: {}; see content/edits/craters.json for stamps that work", where, what));
    };
    if (!file.is_object()) refuse(name, "is not a JSON object");
    for (const auto& [key, value] : file.items())
        if (key != "stamps" && key != "comment") refuse(name, fmt::format("unknown field \"{}\"", key));
    if (!file.contains("stamps") || !file["stamps"].is_array() || file["stamps"].empty() ||
        file["stamps"].size() > most_stamps)
        refuse(name, fmt::format("\"stamps\" must be a list of 1 to {} stamps", most_stamps));
    std::vector<TimedStamp> stamps;
    stamps.reserve(file["stamps"].size());
    for (json object : file["stamps"]) {
        TimedStamp timed;
        try {
            if (object.is_object() && object.contains("frame")) {
                timed.frame =
                    static_cast<std::size_t>(whole_within(object["frame"], "frame", 0, std::int64_t{most_frame}));
                object.erase("frame");
            }
            timed.what = stamp_of(object);
        } catch (const Failure& failure) {
            refuse(fmt::format("{}:{}: stamp {}", name, line_of_item(text, "stamps", stamps.size()), stamps.size()),
                   failure.what());
        }
        stamps.push_back(std::move(timed));
    }
    std::ranges::stable_sort(stamps, {}, &TimedStamp::frame);
    return stamps;
}

std::vector<TimedStamp> read_stamps(const std::string& path, const PackHeader* pack) {
    if (!is_journal(path)) return parse_stamps(read_text(path), path);
    const Journal journal = pack != nullptr ? Journal(path, *pack, JournalAccess::read) : Journal(path);
    if (journal.dropped_bytes() != 0)
        std::fprintf(stderr, "%s: left out %llu bytes of an incomplete record at its end\n", path.c_str(),
                     static_cast<unsigned long long>(journal.dropped_bytes()));
    std::vector<TimedStamp> stamps;
    for (KeptStamp& stamp : journal.stamps()) stamps.push_back({0, std::move(stamp)});
    return stamps;
}

std::string write_stamps(const std::vector<TimedStamp>& stamps) {
    std::string text = "{\n  \"stamps\": [";
    for (std::size_t i = 0; i < stamps.size(); ++i)
        text += (i == 0 ? "\n    " : ",\n    ") + timed_json(stamps[i]).dump();
    return text + "\n  ]\n}\n";
}

std::array<std::uint8_t, 3> rgb_of(const std::string& text, const char* option) {
    std::uint32_t rgb = 0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, rgb, 16);
    if (text.size() != 6 || read.ec != std::errc() || read.ptr != end)
        throw Failure(2, fmt::format("{} {}: give six hexadecimal digits, as in 5c4e3c", option, text));
    return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8 & 255),
            static_cast<std::uint8_t>(rgb & 255)};
}

} // namespace fjell::io
