#include "baker/bake/recipe.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/maps/splat.h"
#include "baker/read/gdal_file.h"
#include "io/file.h"
#include "io/json.h"
#include "io/set_file.h"

namespace fjell::baker {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

using Of = RecipeKey::Of;
constexpr double above_0 = std::numeric_limits<double>::denorm_min();

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
    throw Failure(1, fmt::format("{}: {}; see fjell-bake --help, whose options are the keys of a recipe", name, what));
}

// What a file says, shortened and without control characters, for a message.
std::string quoted(std::string text) {
    constexpr std::size_t longest = 60;
    if (text.size() > longest) text.replace(longest, std::string::npos, "...");
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c >= 127; }, '?');
    return '"' + text + '"';
}

double number_of(const json& value, const RecipeKey& key, const std::string& name) {
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        refuse(name, fmt::format("\"{}\" must be a number", key.name));
    return value.get<double>();
}

// From a file: what the key's member takes.
void take(std::optional<std::string>& to, const json& value, const RecipeKey& key, const std::string& name) {
    const bool count = std::string_view(key.name) == "tile" && value.is_number_unsigned();
    if (!value.is_string() && !count) refuse(name, fmt::format("\"{}\" must be text", key.name));
    to = count ? std::to_string(value.get<std::uint64_t>()) : value.get<std::string>();
    if (to->find('\0') != std::string::npos) refuse(name, fmt::format("\"{}\" has a zero byte in it", key.name));
    if (!key.words.empty() && std::find(key.words.begin(), key.words.end(), *to) == key.words.end())
        refuse(name,
               fmt::format("\"{}\" is {}, but must be one of {}", key.name, quoted(*to), fmt::join(key.words, ", ")));
}
void take(std::optional<double>& to, const json& value, const RecipeKey& key, const std::string& name) {
    to = number_of(value, key, name);
}
void take(std::vector<std::string>& to, const json& value, const RecipeKey& key, const std::string& name) {
    if (!value.is_array()) refuse(name, fmt::format("\"{}\" must be a list of file names", key.name));
    for (const auto& entry : value) {
        if (!entry.is_string() || entry.get<std::string>().find('\0') != std::string::npos)
            refuse(name, fmt::format("\"{}\" must hold file names, but entry {} is none", key.name, to.size()));
        to.push_back(entry.get<std::string>());
    }
}
void take(std::optional<std::array<double, 4>>& to, const json& value, const RecipeKey& key, const std::string& name) {
    if (!value.is_array() || value.size() != 4) refuse(name, "\"bbox\" must be a list of west, south, east, north");
    to.emplace();
    for (std::size_t i = 0; i < 4; ++i) (*to)[i] = number_of(value[i], key, name);
}
void take(std::optional<DeclaredVoids>& to, const json& value, const RecipeKey& key, const std::string& name) {
    if (!value.is_array()) refuse(name, "\"void\" must be a list of numbers, or [\"none\"]");
    to.emplace();
    for (const auto& entry : value) {
        if (entry == "none")
            to->no_others = true;
        else
            to->numbers.push_back(number_of(entry, key, name));
    }
}

template <typename T>
json written(const std::optional<T>& value) {
    return value ? json(*value) : json();
}
json written(const std::vector<std::string>& files) {
    return files.empty() ? json() : json(files);
}
json written(const std::optional<DeclaredVoids>& voids) {
    if (!voids) return {};
    json list = voids->numbers;
    if (voids->no_others) list.push_back("none");
    return list;
}

bool is_given(const std::vector<std::string>& files) {
    return !files.empty();
}
template <typename T>
bool is_given(const std::optional<T>& value) {
    return value.has_value();
}

template <typename Change>
void change_paths(Recipe& recipe, Change change) {
    const auto if_file = [&](std::string& path) {
        if (!path.empty() && !is_gdal_name(path) && std::filesystem::path(path).is_relative()) path = change(path);
    };
    for (const RecipeKey& key : recipe_keys()) {
        if (!key.path) continue;
        if (const auto* const files = std::get_if<std::vector<std::string> Recipe::*>(&key.member))
            for (std::string& file : recipe.**files) if_file(file);
        else if (auto& file = recipe.*std::get<std::optional<std::string> Recipe::*>(key.member))
            if_file(*file);
    }
}

const RecipeKey* find_key(const std::string& name) {
    const std::vector<RecipeKey>& keys = recipe_keys();
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& key) {
        return name == key.name || (key.old_name && name == key.old_name);
    });
    return found == keys.end() ? nullptr : &*found;
}

} // namespace

const std::vector<RecipeKey>& recipe_keys() {
    static const std::vector<RecipeKey> keys{
        {"inputs",
         Of::files,
         &Recipe::inputs,
         "the height field: GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT, ...; several files of one CRS "
         "and spacing make a mosaic, in which later files cover earlier ones",
         {},
         true},
        {"output", Of::files, &Recipe::output, "the pack to write", {}, true},
        {"tile",
         Of::pack,
         &Recipe::tile,
         "cells a side of a tile, a power of two, or auto (default)",
         {"auto", "2", "4", "8", "16", "32", "64", "128", "256", "512", "1024", "2048", "4096"}},
        {"estimate",
         Of::pack,
         &Recipe::estimate,
         "what a vertex' error is: max (default), the largest under it, which is a bound; or midpoint, the error at "
         "the "
         "vertex alone, which is not",
         {"max", "midpoint"}},
        {"nesting",
         Of::pack,
         &Recipe::nesting,
         "mu, 0.001 to 1 (default 0.05): a parent's error is at least 1 + mu times its child's",
         {},
         false,
         0.001,
         1},
        {"room-for-holes",
         Of::pack,
         &Recipe::room_for_holes,
         "yes: stamps may cut holes while the terrain runs, whatever its height steps are (default: no; most packs "
         "have "
         "the room anyway)",
         {"no", "yes"}},
        {"room-for-locks",
         Of::pack,
         &Recipe::room_for_locks,
         "yes: stamps may lock places while the terrain runs, whatever its height steps are (default: no; most packs "
         "have "
         "the room anyway)",
         {"no", "yes"}},
        {"order",
         Of::pack,
         &Recipe::order,
         "how vertices lie in pages: planar (default), hz (hierarchical Z) or linear",
         {"planar", "hz", "linear"}},
        {"quantum",
         Of::pack,
         &Recipe::quantum,
         "the step of stored heights in metres (default: the source's own)",
         {},
         false,
         above_0},
        {"texture",
         Of::files,
         &Recipe::texture,
         "ortho-images, placed by their coordinates, or else stretched over the terrain; later images cover earlier "
         "ones",
         {},
         true},
        {"texture-bands", Of::pack, &Recipe::texture_bands,
         "the bands of red, green and blue in images with several bands, or the band of grey: numbers, from 1, or "
         "names, as in 4,3,2 (default: as the image says)"},
        {"ramp", Of::files, &Recipe::ramp, "colours by height (JSON, content/ramps)", {}, true},
        {"edits",
         Of::edits,
         &Recipe::edits,
         "stamps that change the heights before anything is made of them: craters, roads, levelled ground (JSON, "
         "content/edits)",
         {},
         true},
        {"coarse",
         Of::edits,
         &Recipe::coarse,
         "polygons in which the ground keeps less detail, as a sea's bed, and takes fewer triangles in every view: "
         "attribute detail_m, metres between heights that are kept (GeoPackage, GeoJSON, Shapefile, ...)",
         {},
         true},
        {"coarse-detail-m",
         Of::edits,
         &Recipe::coarse_detail,
         "detail_m of polygons that do not have it",
         {},
         false,
         0,
         1e6},
        {"locks",
         Of::files,
         &Recipe::locks,
         "points, lines and polygons along which errors are smaller: attributes error_m, metres that no view exceeds, "
         "or error_px, 0.001 to 1, of a threshold of one pixel; and width_m (GeoPackage, GeoJSON, Shapefile, ...)",
         {},
         true},
        {"lock-error-m",
         Of::pack,
         &Recipe::lock_error,
         "error_m of locks that have neither attribute",
         {},
         false,
         0,
         1e6},
        {"horizons",
         Of::pack,
         &Recipe::horizons,
         "horizon maps, for shadows at any time of day and for the share of the sky that ground sees: none (default), "
         "half or quarter of the samples' density",
         {"none", "half", "quarter"}},
        {"layers",
         Of::files,
         &Recipe::layers,
         "splat maps: which materials lie where, by rules over the ground, rasters of classes and painted images "
         "(JSON, content/materials/splat)",
         {},
         true},
        {"splat",
         Of::pack,
         &Recipe::splat,
         "texels of splat maps: full, half (default) or quarter of the samples' density",
         {"full", "half", "quarter"},
         false,
         -std::numeric_limits<double>::infinity(),
         std::numeric_limits<double>::infinity(),
         "control"},
        {"crs", Of::reading, &Recipe::crs,
         "auto (default): reproject a field in degrees, or in a CRS whose metres are not metres on the ground; keep or "
         "none: reproject nothing; or the projected CRS to reproject to, such as EPSG:32633"},
        {"encoding",
         Of::reading,
         &Recipe::encoding,
         "heights packed into red, green and blue",
         {"none", "terrarium", "terrain-rgb"}},
        {"nodata",
         Of::reading,
         &Recipe::nodata,
         "samples without a height: leave a hole, fill from their neighbours, or refuse. Default: samples that the "
         "file marks, and NaN, become holes; implausible heights are refused",
         {"hole", "fill", "refuse"}},
        {"spacing", Of::reading, &Recipe::spacing,
         "metres between samples; a file without a georeference needs it. With it a file in degrees is taken as a "
         "square grid, and a file in a projected CRS is resampled"},
        {"band", Of::reading, &Recipe::band,
         "the band of heights in a file with several bands: its number, from 1, or its name (default: the band that is "
         "named as elevation)"},
        {"size", Of::reading, &Recipe::size,
         "COLUMNSxROWS of a file of raw numbers (.raw, .r16, .r32: 16 bits or floats, little-endian); default: it is "
         "square"},
        {"vertical-unit", Of::reading, &Recipe::vertical_unit,
         "the unit of heights whose file names no unit: m, ft, us-ft, or another of PROJ's names (default: m; a file "
         "whose CRS counts feet is refused without it)"},
        {"zscale", Of::reading, &Recipe::zscale, "multiplies heights (after the file's own scale)"},
        {"zoffset", Of::reading, &Recipe::zoffset, "metres added to heights after --zscale"},
        {"bbox", Of::reading, &Recipe::bbox,
         "WEST,SOUTH,EAST,NORTH: only the samples inside; in units of the CRS after reprojection, in degrees if the "
         "field is in degrees, or in columns and rows from the north-west if the field has no georeference"},
        {"void", Of::reading, &Recipe::voids,
         "a number that means \"no height\" although the file does not mark it: the number in the file, before any "
         "scale and offset; may be repeated. none: every other number is a height, even one that looks like a void"}};
    return keys;
}

const RecipeKey& recipe_key(const std::string& name) {
    if (const RecipeKey* const key = find_key(name)) return *key;
    throw std::logic_error("recipes have no key " + name);
}

std::string renamed_line(const RecipeKey& key, const std::string& before) {
    return fmt::format("{} is called {}{} now, and read by its old name until 0.4", before,
                       before.starts_with("--") ? "--" : "", key.name);
}

Recipe parse_recipe(const std::string& text, const std::string& name, std::vector<std::string>* renamed) {
    const json object = io::parse_json(text, name);
    if (!object.is_object()) refuse(name, "is not a JSON object");
    Recipe recipe;
    for (const auto& item : object.items()) {
        const RecipeKey* const key = find_key(item.key());
        if (!key) refuse(name, fmt::format("{} is no key of a recipe", quoted(item.key())));
        if (item.key() != key->name) {
            if (object.contains(key->name))
                refuse(name, fmt::format("{} is now {}, which is there too", quoted(item.key()), quoted(key->name)));
            if (renamed) renamed->push_back(fmt::format("{}: {}", name, renamed_line(*key, quoted(item.key()))));
        }
        std::visit([&](const auto member) { take(recipe.*member, item.value(), *key, name); }, key->member);
    }
    return recipe;
}

std::string recipe_text(const Recipe& recipe) {
    ordered_json json = ordered_json::object();
    for (const RecipeKey& key : recipe_keys())
        std::visit(
            [&](const auto member) {
                if (is_given(recipe.*member)) json[key.name] = written(recipe.*member);
            },
            key.member);
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Recipe load_recipe(const std::string& path, std::vector<std::string>* renamed) {
    Recipe recipe = parse_recipe(io::read_text(path), path, renamed);
    const auto folder = std::filesystem::path(path).parent_path();
    change_paths(recipe, [&](const std::string& file) { return (folder / file).lexically_normal().string(); });
    return recipe;
}

Recipe for_file(Recipe recipe, const std::string& path) {
    const auto folder = std::filesystem::absolute(path).lexically_normal().parent_path();
    change_paths(recipe, [&](const std::string& file) {
        return std::filesystem::absolute(file).lexically_normal().lexically_proximate(folder).string();
    });
    return recipe;
}

Recipe merged(Recipe given, const Recipe& below) {
    for (const RecipeKey& key : recipe_keys())
        std::visit(
            [&](const auto member) {
                if (!is_given(given.*member)) given.*member = below.*member;
            },
            key.member);
    return given;
}

Recipe reading_part(Recipe recipe) {
    for (const RecipeKey& key : recipe_keys())
        if (key.of != Of::reading) std::visit([&](const auto member) { recipe.*member = {}; }, key.member);
    return recipe;
}

namespace {

// The place of a value among its key's words; usual: it is not given, or no such word.
template <typename T>
T word_at(const std::optional<std::string>& value, const char* key, T usual) {
    const std::vector<std::string>& words = recipe_key(key).words;
    const auto found = value ? std::find(words.begin(), words.end(), *value) : words.end();
    return found == words.end() ? usual : static_cast<T>(found - words.begin());
}
static_assert(static_cast<int>(ErrorEstimate::midpoint) == 1 && static_cast<int>(PageOrder::hierarchical_z) == 1 &&
                  static_cast<int>(PageOrder::linear) == 2 && static_cast<int>(Encoding::terrain_rgb) == 2,
              "words are in the order of the values they name: change recipe_keys() too");

// "512" or "auto" to log2; 0 for auto.
int tile_log2(const std::string& text) {
    if (text == "auto") return 0;
    for (int log2 = min_tile_log2; log2 <= max_tile_log2; ++log2)
        if (text == std::to_string(1 << log2)) return log2;
    throw Failure(2, fmt::format("--tile {}: must be auto or a power of two from 2 to 4096 (cells a side)", text));
}

void check_ranges(const Recipe& recipe) {
    for (const RecipeKey& key : recipe_keys()) {
        const auto* const member = std::get_if<std::optional<double> Recipe::*>(&key.member);
        if (!member || !(recipe.**member) || std::isinf(key.least)) continue;
        const double value = *(recipe.**member);
        if (std::isfinite(value) && value >= key.least && value <= key.most) continue;
        throw Failure(2, fmt::format("--{} {}: must be {}", key.name, value,
                                     std::isfinite(key.most) ? fmt::format("from {} to {}", key.least, key.most)
                                                             : "more than 0"));
    }
}

} // namespace

ReadOptions read_options(const Recipe& recipe) {
    ReadOptions o;
    o.spacing_m = recipe.spacing;
    o.zscale = recipe.zscale;
    o.zoffset_m = recipe.zoffset.value_or(0);
    o.crs = recipe.crs.value_or("auto");
    o.bbox = recipe.bbox;
    o.vertical_unit = recipe.vertical_unit.value_or("");
    o.band = recipe.band.value_or("");
    if (recipe.size) o.size = parse_size(*recipe.size);
    o.voids = recipe.voids.value_or(DeclaredVoids{});
    constexpr NoData named[] = {NoData::hole, NoData::fill, NoData::refuse};
    if (recipe.nodata) o.nodata = named[word_at(recipe.nodata, "nodata", 0)];
    o.encoding = word_at(recipe.encoding, "encoding", Encoding::none);
    return o;
}

BakeOptions bake_options(const Recipe& recipe) {
    check_ranges(recipe);
    BakeOptions o;
    o.tile_log2 = tile_log2(recipe.tile.value_or("auto"));
    o.estimate = word_at(recipe.estimate, "estimate", o.estimate);
    o.order = word_at(recipe.order, "order", o.order);
    constexpr int horizon_spacings[] = {0, 2, 4}, splat_spacings[] = {1, 2, 4};
    o.horizon_spacing = horizon_spacings[word_at(recipe.horizons, "horizons", 0)];
    o.layers_path = recipe.layers.value_or("");
    if (recipe.splat && o.layers_path.empty())
        throw Failure(2, "--splat says how fine splat maps are; give their rules with --layers");
    o.splat_spacing = splat_spacings[word_at(recipe.splat, "splat", 1)];
    o.nesting = recipe.nesting.value_or(o.nesting);
    o.room_for_holes = word_at(recipe.room_for_holes, "room-for-holes", 0) != 0;
    o.room_for_locks = word_at(recipe.room_for_locks, "room-for-locks", 0) != 0;
    o.locks_path = recipe.locks.value_or("");
    o.lock_error_m = recipe.lock_error;
    if (recipe.lock_error && !recipe.locks)
        throw Failure(2, "--lock-error-m is of locks without an error; give their file with --locks");
    o.quantum_m = recipe.quantum.value_or(0);
    o.texture_paths = recipe.texture;
    o.texture_bands = recipe.texture_bands.value_or("");
    if (recipe.texture_bands && recipe.texture.empty())
        throw Failure(2, "--texture-bands says which bands of an image are its colours; give the image with --texture");
    o.ramp_path = recipe.ramp.value_or("");
    o.reading = recipe_text(reading_part(recipe));
    return o;
}

bool is_pack(const Recipe& recipe) {
    std::error_code none;
    return recipe.inputs.size() == 1 && (recipe.inputs[0].ends_with(".fjell") ||
                                         std::filesystem::is_regular_file(recipe.inputs[0] + "/set.json", none));
}

std::vector<std::string> files_read(const Recipe& recipe) {
    std::vector<std::string> all{recipe.ramp.value_or("")};
    const auto add = [&](const std::vector<std::string>& more) { all.insert(all.end(), more.begin(), more.end()); };
    for (const std::string& input : recipe.inputs)
        if (input.ends_with(".json"))
            all.push_back(input);
        else
            add(is_pack(recipe) ? io::files_of_pack(input) : raster_files(input, "a height field"));
    if (recipe.edits) all.push_back(*recipe.edits);
    if (recipe.coarse) all.push_back(*recipe.coarse);
    if (recipe.locks) all.push_back(*recipe.locks);
    for (const std::string& image : recipe.texture) add(raster_files(image, "an image"));
    if (recipe.layers) {
        all.push_back(*recipe.layers);
        for (const SplatRaster& raster : read_splat(*recipe.layers).rasters) add(raster_files(raster.path, "a raster"));
    }
    return all;
}

std::vector<std::string> places_written(const std::string& pack_path) {
    return {pack_path, io::where_written(pack_path) + ".work/"};
}

std::array<double, 4> parse_bbox(const std::string& text) {
    std::array<double, 4> box{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t i = 0; i < box.size(); ++i) {
        const auto [next, error] = std::from_chars(at, end, box[i]);
        const bool last = i + 1 == box.size();
        if (error != std::errc() || !std::isfinite(box[i]) || (last ? next != end : next == end || *next != ','))
            throw Failure(2, fmt::format("--bbox {}: must be four numbers WEST,SOUTH,EAST,NORTH", quoted(text)));
        at = next + !last;
    }
    return box;
}

std::array<int, 2> parse_size(const std::string& text) {
    std::array<int, 2> size{};
    const char* const end = text.data() + text.size();
    const auto [x, first] = std::from_chars(text.data(), end, size[0]);
    const bool parted = first == std::errc() && x != end && *x == 'x';
    const auto [stop, second] = parted ? std::from_chars(x + 1, end, size[1]) : std::from_chars_result{x, first};
    if (!parted || second != std::errc() || stop != end || size[0] < 2 || size[1] < 2 || size[0] > 1 << 30 ||
        size[1] > 1 << 30)
        throw Failure(2, fmt::format("--size {}: must be COLUMNSxROWS, as in 1025x513", quoted(text)));
    return size;
}

void parse_voids(const std::string& text, std::optional<DeclaredVoids>& to) {
    if (!to) to.emplace();
    for (std::size_t at = 0; at <= text.size();) {
        const std::string word = text.substr(at, text.find(',', at) - at);
        at += word.size() + 1;
        if (word == "none") {
            to->no_others = true;
            continue;
        }
        double number = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number))
            throw Failure(2, fmt::format("--void {}: must be a number of the file that stands for no height, or none",
                                         quoted(word)));
        to->numbers.push_back(number);
    }
}

} // namespace fjell::baker
