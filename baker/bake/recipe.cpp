#include "baker/bake/recipe.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/maps/control.h"
#include "baker/read/gdal_file.h"
#include "baker/read/raster_files.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

struct TextField {
    const char* key;
    std::optional<std::string> Recipe::*member;
    bool path;
    std::vector<std::string> words; // empty: any text
};
struct NumberField {
    const char* key;
    std::optional<double> Recipe::*member;
};

const std::vector<TextField>& text_fields() {
    static const std::vector<TextField> fields{
        {"output", &Recipe::output, true, {}},
        {"ramp", &Recipe::ramp, true, {}},
        {"crs", &Recipe::crs, false, {}},
        {"encoding", &Recipe::encoding, false, {"none", "terrarium", "terrain-rgb"}},
        {"nodata", &Recipe::nodata, false, {"hole", "fill", "refuse"}},
        {"tile",
         &Recipe::tile,
         false,
         {"auto", "2", "4", "8", "16", "32", "64", "128", "256", "512", "1024", "2048", "4096"}},
        {"estimate", &Recipe::estimate, false, {"max", "midpoint"}},
        {"order", &Recipe::order, false, {"planar", "hz", "linear"}},
        {"horizons", &Recipe::horizons, false, {"none", "half", "quarter"}},
        {"layers", &Recipe::layers, true, {}},
        {"control", &Recipe::control, false, {"full", "half", "quarter"}}};
    return fields;
}
const std::vector<NumberField>& number_fields() {
    static const std::vector<NumberField> fields{{"spacing", &Recipe::spacing},
                                                 {"zscale", &Recipe::zscale},
                                                 {"zoffset", &Recipe::zoffset},
                                                 {"nesting", &Recipe::nesting},
                                                 {"quantum", &Recipe::quantum}};
    return fields;
}

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

std::string joined(const std::vector<std::string>& words) {
    return fmt::format("{}", fmt::join(words, ", "));
}

std::string text_of(const json& value, const TextField& field, const std::string& name) {
    const bool count = std::string_view(field.key) == "tile" && value.is_number_unsigned();
    if (!value.is_string() && !count) refuse(name, fmt::format("\"{}\" must be text", field.key));
    std::string text = count ? std::to_string(value.get<std::uint64_t>()) : value.get<std::string>();
    if (text.find('\0') != std::string::npos) refuse(name, fmt::format("\"{}\" has a zero byte in it", field.key));
    if (!field.words.empty() && std::find(field.words.begin(), field.words.end(), text) == field.words.end())
        refuse(name, fmt::format("\"{}\" is {}, but must be one of {}", field.key, quoted(text), joined(field.words)));
    return text;
}

double number_of(const json& value, const std::string& key, const std::string& name) {
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        refuse(name, fmt::format("\"{}\" must be a number", key));
    return value.get<double>();
}

std::vector<std::string> files_of(const json& value, const std::string& key, const std::string& name) {
    std::vector<std::string> files;
    if (!value.is_array()) refuse(name, fmt::format("\"{}\" must be a list of file names", key));
    for (const auto& entry : value) {
        if (!entry.is_string() || entry.get<std::string>().find('\0') != std::string::npos)
            refuse(name, fmt::format("\"{}\" must hold file names, but entry {} is none", key, files.size()));
        files.push_back(entry.get<std::string>());
    }
    return files;
}

std::array<double, 4> bbox_of(const json& value, const std::string& name) {
    if (!value.is_array() || value.size() != 4) refuse(name, "\"bbox\" must be a list of west, south, east, north");
    std::array<double, 4> box{};
    for (std::size_t i = 0; i < 4; ++i) box[i] = number_of(value[i], "bbox", name);
    return box;
}

DeclaredVoids voids_of(const json& value, const std::string& name) {
    DeclaredVoids voids;
    if (!value.is_array()) refuse(name, "\"void\" must be a list of numbers, or [\"none\"]");
    for (const auto& entry : value) {
        if (entry == "none")
            voids.no_others = true;
        else
            voids.numbers.push_back(number_of(entry, "void", name));
    }
    return voids;
}

void take(Recipe& recipe, const std::string& key, const json& value, const std::string& name) {
    if (key == "inputs" || key == "texture") {
        (key == "inputs" ? recipe.inputs : recipe.texture) = files_of(value, key, name);
        return;
    }
    if (key == "bbox") {
        recipe.bbox = bbox_of(value, name);
        return;
    }
    if (key == "void") {
        recipe.voids = voids_of(value, name);
        return;
    }
    for (const TextField& field : text_fields())
        if (key == field.key) {
            recipe.*field.member = text_of(value, field, name);
            return;
        }
    for (const NumberField& field : number_fields())
        if (key == field.key) {
            recipe.*field.member = number_of(value, key, name);
            return;
        }
    refuse(name, fmt::format("{} is no key of a recipe", quoted(key)));
}

template <typename Change>
void change_paths(Recipe& recipe, Change change) {
    const auto if_file = [&](std::string& path) {
        if (!path.empty() && !is_gdal_name(path) && std::filesystem::path(path).is_relative()) path = change(path);
    };
    for (std::string& input : recipe.inputs) if_file(input);
    for (std::string& image : recipe.texture) if_file(image);
    for (const TextField& field : text_fields())
        if (field.path && recipe.*field.member) if_file(*(recipe.*field.member));
}

} // namespace

Recipe parse_recipe(const std::string& text, const std::string& name) {
    const json object = io::parse_json(text, name);
    if (!object.is_object()) refuse(name, "is not a JSON object");
    Recipe recipe;
    for (const auto& [key, value] : object.items()) take(recipe, key, value, name);
    return recipe;
}

std::string recipe_text(const Recipe& recipe) {
    ordered_json json = ordered_json::object();
    if (!recipe.inputs.empty()) json["inputs"] = recipe.inputs;
    if (!recipe.texture.empty()) json["texture"] = recipe.texture;
    for (const TextField& field : text_fields())
        if (recipe.*field.member) json[field.key] = *(recipe.*field.member);
    for (const NumberField& field : number_fields())
        if (recipe.*field.member) json[field.key] = *(recipe.*field.member);
    if (recipe.bbox) json["bbox"] = *recipe.bbox;
    if (recipe.voids) {
        json["void"] = recipe.voids->numbers;
        if (recipe.voids->no_others) json["void"].push_back("none");
    }
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Recipe load_recipe(const std::string& path) {
    Recipe recipe = parse_recipe(io::read_text(path), path);
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
    if (given.inputs.empty()) given.inputs = below.inputs;
    if (given.texture.empty()) given.texture = below.texture;
    for (const TextField& field : text_fields())
        if (!(given.*field.member)) given.*field.member = below.*field.member;
    for (const NumberField& field : number_fields())
        if (!(given.*field.member)) given.*field.member = below.*field.member;
    if (!given.bbox) given.bbox = below.bbox;
    if (!given.voids) given.voids = below.voids;
    return given;
}

Recipe reading_part(Recipe recipe) {
    recipe.inputs.clear();
    recipe.texture.clear();
    for (auto* const text : {&recipe.output, &recipe.ramp, &recipe.tile, &recipe.estimate, &recipe.order,
                             &recipe.horizons, &recipe.layers, &recipe.control})
        text->reset();
    recipe.nesting.reset();
    recipe.quantum.reset();
    return recipe;
}

ReadOptions read_options(const Recipe& recipe) {
    ReadOptions o;
    o.spacing_m = recipe.spacing;
    o.zscale = recipe.zscale;
    o.zoffset_m = recipe.zoffset.value_or(0);
    o.crs = recipe.crs.value_or("auto");
    o.bbox = recipe.bbox;
    o.voids = recipe.voids.value_or(DeclaredVoids{});
    const std::string nodata = recipe.nodata.value_or(""), encoding = recipe.encoding.value_or("");
    if (nodata == "hole") o.nodata = NoData::hole;
    if (nodata == "fill") o.nodata = NoData::fill;
    if (nodata == "refuse") o.nodata = NoData::refuse;
    if (encoding == "terrarium") o.encoding = Encoding::terrarium;
    if (encoding == "terrain-rgb") o.encoding = Encoding::terrain_rgb;
    return o;
}

namespace {

// "512" or "auto" to log2; 0 for auto.
int tile_log2(const std::string& text) {
    if (text == "auto") return 0;
    for (int log2 = min_tile_log2; log2 <= max_tile_log2; ++log2)
        if (text == std::to_string(1 << log2)) return log2;
    throw Failure(2, fmt::format("--tile {}: must be auto or a power of two from 2 to 4096 (cells a side)", text));
}

Order order_named(const std::string& name) {
    return name == "planar" ? Order::planar : name == "hz" ? Order::hierarchical_z : Order::linear;
}

} // namespace

BakeOptions bake_options(const Recipe& recipe) {
    BakeOptions o;
    o.tile_log2 = tile_log2(recipe.tile.value_or("auto"));
    o.estimate = recipe.estimate.value_or("max") == "max" ? Estimate::max : Estimate::midpoint;
    o.order = order_named(recipe.order.value_or("planar"));
    const std::string horizons = recipe.horizons.value_or("none");
    o.horizon_spacing = horizons == "half" ? 2 : horizons == "quarter" ? 4 : 0;
    o.layers_path = recipe.layers.value_or("");
    if (recipe.control && o.layers_path.empty())
        throw Failure(2, "--control says how fine control maps are; give their rules with --layers");
    const std::string control = recipe.control.value_or("half");
    o.control_spacing = control == "full" ? 1 : control == "half" ? 2 : 4;
    o.nesting = recipe.nesting.value_or(o.nesting);
    o.quantum_m = recipe.quantum.value_or(0);
    if (recipe.quantum && !(o.quantum_m > 0 && std::isfinite(o.quantum_m)))
        throw Failure(2, fmt::format("--quantum {}: must be more than 0 (metres)", o.quantum_m));
    o.texture_paths = recipe.texture;
    o.ramp_path = recipe.ramp.value_or("");
    o.reading = recipe_text(reading_part(recipe));
    return o;
}

std::vector<std::string> files_read(const Recipe& recipe) {
    std::vector<std::string> all{recipe.ramp.value_or("")};
    const auto add = [&](const std::vector<std::string>& more) { all.insert(all.end(), more.begin(), more.end()); };
    for (const std::string& input : recipe.inputs)
        add(input.ends_with(".json") ? std::vector{input} : raster_files(input, "a height field"));
    for (const std::string& image : recipe.texture) add(raster_files(image, "an image"));
    if (recipe.layers) {
        all.push_back(*recipe.layers);
        for (const ControlRaster& raster : read_control(*recipe.layers).rasters)
            add(raster_files(raster.path, "a raster"));
    }
    return all;
}

std::vector<std::string> places_written(const std::string& pack_path) {
    return {pack_path, io::where_written(pack_path) + ".work/"};
}

std::vector<std::string> words_of(const std::string& key) {
    for (const TextField& field : text_fields())
        if (key == field.key) return field.words;
    return {};
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
