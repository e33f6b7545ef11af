#include "baker/materials/recipe.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/maps/colour.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

using io::Failure;

namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
    throw Failure(1, fmt::format("{}: {}; see content/materials/rock.json for a recipe that works", file, what));
}

// One JSON object of a recipe: every key is asked for once, and what nobody asked for is refused.
class Keys {
public:
    Keys(const std::string& file, const Json& json, std::string where)
        : file_(file), json_(json), where_(std::move(where)) {
        if (!json.is_object()) fail("must be a JSON object");
    }
    [[noreturn]] void fail(const std::string& what) const { refuse(file_, where_ + what); }

    const Json* find(const char* key) {
        asked_.emplace_back(key);
        const auto at = json_.find(key);
        return at == json_.end() ? nullptr : &*at;
    }
    void number(const char* key, double least, double most, float& to) {
        const Json* const value = find(key);
        if (!value) return;
        if (!value->is_number() || !(value->get<double>() >= least && value->get<double>() <= most))
            fail(fmt::format("\"{}\" must be a number in {}..{}", key, least, most));
        to = value->get<float>();
    }
    template <typename Whole>
    void whole(const char* key, std::int64_t least, std::int64_t most, Whole& to) {
        const Json* const value = find(key);
        if (!value) return;
        to = whole_of(*value, key, least, most, to);
    }
    // One number for both, or two.
    void pair(const char* key, std::int64_t least, std::int64_t most, int (&to)[2]) {
        const Json* const value = find(key);
        if (!value) return;
        const bool two = value->is_array() && value->size() == 2;
        for (std::size_t i = 0; i < 2; ++i) to[i] = whole_of(two ? (*value)[i] : *value, key, least, most, to[i]);
    }
    void pair(const char* key, double least, double most, float (&to)[2]) {
        const Json* const value = find(key);
        if (!value) return;
        const auto good = [&](const Json& one) {
            return one.is_number() && one.get<double>() >= least && one.get<double>() <= most;
        };
        if (!value->is_array() || value->size() != 2 || !good((*value)[0]) || !good((*value)[1]) ||
            (*value)[0].get<double>() > (*value)[1].get<double>())
            fail(fmt::format("\"{}\" must hold two numbers in {}..{}, the lower first", key, least, most));
        for (std::size_t i = 0; i < 2; ++i) to[i] = (*value)[i].get<float>();
    }
    void text(const char* key, std::string& to) {
        const Json* const value = find(key);
        if (!value) return;
        if (!value->is_string() || value->get_ref<const std::string&>().empty())
            fail(fmt::format("\"{}\" must be a file's name", key));
        to = value->get<std::string>();
    }
    // A colour, or a list of up to eight; sRGB to linear light.
    void colours(const char* key, std::vector<float>& to) {
        const Json* const value = find(key);
        if (!value) return;
        const bool many = value->is_array() && !value->empty() && value->front().is_array();
        to.clear();
        if (many && value->size() > 8) fail(fmt::format("\"{}\" must hold eight colours at most", key));
        for (std::size_t i = 0; i < (many ? value->size() : 1); ++i) colour(many ? (*value)[i] : *value, key, to);
    }
    void refuse_others() const {
        for (const auto& [key, value] : json_.items())
            if (std::find(asked_.begin(), asked_.end(), key) == asked_.end() && key != "comment")
                fail(fmt::format("unknown field \"{}\"", key));
    }

private:
    template <typename Whole>
    Whole whole_of(const Json& value, const char* key, std::int64_t least, std::int64_t most, Whole) const {
        if (!value.is_number_integer() || value.get<double>() < static_cast<double>(least) ||
            value.get<double>() > static_cast<double>(most))
            fail(fmt::format("\"{}\" must be a whole number in {}..{}", key, least, most));
        return value.get<Whole>();
    }
    void colour(const Json& rgb, const char* key, std::vector<float>& to) const {
        const auto good = [](const Json& one) {
            return one.is_number() && one.get<double>() >= 0 && one.get<double>() <= 255;
        };
        if (!rgb.is_array() || rgb.size() != 3 || !std::all_of(rgb.begin(), rgb.end(), good))
            fail(fmt::format("\"{}\" must hold colours of three numbers in 0..255", key));
        for (const Json& one : rgb) to.push_back(light_of_srgb(one.get<float>()));
    }

    const std::string& file_;
    const Json& json_;
    std::string where_;
    std::vector<std::string> asked_;
};

constexpr const char* draws[] = {"noise", "cells", "plates", "cracks", "ripples", "stones", "strokes"};
constexpr const char* forms[] = {"soft", "ridged", "billow"};

template <std::size_t N>
std::size_t choice(Keys& keys, const char* key, const char* const (&names)[N], const Json* value,
                   std::size_t otherwise) {
    if (!value) return otherwise;
    for (std::size_t i = 0; i < N; ++i)
        if (*value == names[i]) return i;
    keys.fail(fmt::format("\"{}\" must be one of {}", key, fmt::join(names, ", ")));
}

MaterialStep parse_step(const std::string& file, const Json& json, std::size_t number) {
    Keys keys(file, json, fmt::format("step {}: ", number));
    MaterialStep s;
    const Json* const draw = keys.find("draw");
    if (!draw) keys.fail("\"draw\" is missing");
    s.draw = static_cast<Draw>(choice(keys, "draw", draws, draw, 0));
    s.noise.form = static_cast<NoiseForm>(choice(keys, "form", forms, keys.find("form"), 0));
    keys.pair("cells", 1, 256, s.noise.cells);
    keys.whole("octaves", 1, 10, s.noise.octaves);
    keys.number("gain", 0, 1, s.noise.gain);
    keys.number("height_m", -10, 10, s.height);
    keys.number("warp", 0, 1, s.warp);
    keys.whole("warp_cells", 1, 64, s.warp_cells);
    keys.number("low", -1, 2, s.low);
    keys.number("high", -1, 2, s.high);
    if (s.high - s.low < 0.001f) keys.fail("\"high\" must be above \"low\" by 0.001 at least");
    keys.number("width", 0.0005, 1, s.width);
    keys.number("jitter", 0, 1, s.jitter);
    keys.whole("count", 0, 200000, s.count);
    keys.pair("size", 0.0005, 0.5, s.size);
    keys.number("angular", 0, 1, s.angular);
    keys.number("sink", 0, 0.95, s.sink);
    keys.number("bend", 0, 3, s.bend);
    keys.number("leaf", 0, 1, s.leaf);
    keys.number("clump", 0, 1, s.clump);
    keys.number("opacity", 0, 1, s.opacity);
    keys.colours("rgb", s.rgb);
    if (s.opacity > 0 && s.rgb.empty()) keys.fail("\"opacity\" needs \"rgb\"");
    keys.refuse_others();
    return s;
}

void parse_images(Keys& keys, const Json& json, MaterialRecipe& m) {
    keys.text("normal", m.normal);
    keys.text("height", m.height);
    keys.number("relief_m", 0, 10, m.relief_m);
    if (m.albedo.empty() && !(m.normal.empty() && m.height.empty()))
        keys.fail("\"normal\" and \"height\" need an \"albedo\"");
    if (!m.albedo.empty() && json.contains("steps")) keys.fail("give either \"albedo\" or \"steps\"");
}

} // namespace

MaterialRecipe parse_material(const std::string& text, const std::string& file) {
    const Json json = io::parse_json(text, file, io::JsonComments::yes);
    MaterialRecipe m;
    m.name = std::filesystem::path(file).stem().string();
    if (m.name.empty() || m.name.size() > io::max_material_name)
        refuse(file, fmt::format("a recipe's name must have 1 to {} letters", io::max_material_name));
    Keys keys(file, json, "");
    keys.number("size_m", 0.25, 64, m.size_m);
    keys.number("coarse", 2, 64, m.coarse);
    keys.number("coarse_share", 0, 1, m.coarse_share);
    keys.number("flatten", 0, 1, m.flatten);
    keys.number("cavity", 0, 2, m.cavity);
    keys.number("bump", 0, 4, m.bump);
    keys.whole("seed", 0, 4294967295, m.seed);
    keys.colours("base", m.base);
    keys.text("albedo", m.albedo);
    parse_images(keys, json, m);
    if (const Json* const steps = keys.find("steps")) {
        if (!steps->is_array() || steps->empty() || steps->size() > 32)
            keys.fail("\"steps\" must be a list of 1 to 32 steps");
        for (std::size_t i = 0; i < steps->size(); ++i) m.steps.push_back(parse_step(file, (*steps)[i], i));
    } else if (m.albedo.empty()) {
        keys.fail("\"steps\" is missing");
    }
    if (m.albedo.empty() && m.base.size() != 3) keys.fail("\"base\" must be one colour");
    keys.refuse_others();
    return m;
}

std::vector<MaterialRecipe> read_materials(const std::string& path) {
    namespace fs = std::filesystem;
    std::vector<std::string> files;
    std::error_code error;
    if (fs::is_directory(path, error)) {
        for (const auto& entry : fs::directory_iterator(path, error))
            if (entry.path().extension() == ".json") files.push_back(entry.path().string());
        std::sort(files.begin(), files.end());
        if (files.empty())
            throw Failure(1,
                          fmt::format("{}: holds no recipe (*.json); name a folder such as content/materials", path));
    } else {
        files.push_back(path);
    }
    if (files.size() > io::max_materials)
        throw Failure(1, fmt::format("{}: has {} recipes, but a file of materials has room for {}; move some away",
                                     path, files.size(), io::max_materials));
    std::vector<MaterialRecipe> recipes;
    for (const std::string& file : files) {
        recipes.push_back(parse_material(io::read_text(file), file));
        for (std::string* const image : {&recipes.back().albedo, &recipes.back().normal, &recipes.back().height})
            if (!image->empty()) *image = (fs::path(file).parent_path() / *image).string();
    }
    return recipes;
}

} // namespace fjell::baker
