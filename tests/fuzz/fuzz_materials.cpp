// What detail layers are read from: files of materials, their recipes, and rules. Any bytes are refused or are one.
// The first byte says which; of a file of materials it also says whether its hash is made to fit.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <xxhash.h>

#include "baker/materials/recipe.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "input.h"
#include "session/layers_file.h"

namespace {

using namespace fjell;
using fuzz::must;

void open_file(std::vector<std::byte> bytes, bool fit) {
    io::MaterialsHeader header;
    if (fit && bytes.size() >= sizeof header) {
        std::memcpy(&header, bytes.data(), sizeof header);
        header.hash = XXH3_64bits(bytes.data() + sizeof header, bytes.size() - sizeof header);
        std::memcpy(bytes.data(), &header, sizeof header);
    }
    const io::Materials materials = io::open_materials(bytes, "fuzz");
    must(!materials.records.empty() && materials.colour.size() == materials.normal.size(), "a file has materials");
    const std::uint32_t last = materials.mips() - 1;
    const auto count = static_cast<std::uint32_t>(materials.records.size());
    must(materials.mip_bytes(last) == 16, "the last mip is a block");
    must(materials.mip_offset(last, count - 1) + 16 == materials.colour.size(), "mips fill the blocks");
    for (std::uint32_t i = 0; i < count; ++i)
        must(materials.find(materials.records[i].name) == static_cast<int>(i), "materials are found by name");
    must(io::materials_file(materials) == bytes, "a file comes back as it was");
}

void parse_rules(const std::string& text) {
    io::Materials materials;
    materials.records.resize(2);
    std::memcpy(materials.records[0].name, "rock", 5);
    std::memcpy(materials.records[1].name, "grass", 6);
    const std::vector<gl::LayerRule> rules = session::parse_layer_rules(text, "fuzz", materials);
    must(!rules.empty() && rules.size() <= gl::max_layer_rules, "there are rules");
    for (const gl::LayerRule& rule : rules) {
        must(rule.material < 2, "a rule's material is one of them");
        must(rule.slope_deg[0] <= rule.slope_deg[1] && rule.slope_deg[1] <= 90, "a range is one");
        must(rule.opacity >= 0 && rule.opacity <= 1, "an opacity is a share");
    }
}

void parse_recipe(const std::string& text) {
    const baker::MaterialRecipe m = baker::parse_material(text, "fuzz.json");
    must(m.name == "fuzz" && m.steps.empty() != m.albedo.empty(), "a recipe has steps or images");
    for (const baker::MaterialStep& step : m.steps)
        must(step.noise.cells[0] >= 1 && step.high > step.low && step.rgb.size() % 3 == 0, "a step can be drawn");
}

} // namespace

extern "C" int fuzz_materials(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
    try {
        switch (data[0] % 4) {
        case 0:
        case 1: {
            const auto* const first = reinterpret_cast<const std::byte*>(data + 1);
            open_file({first, first + size - 1}, data[0] % 4 == 1);
            break;
        }
        case 2: parse_rules(text); break;
        default: parse_recipe(text); break;
        }
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
    }
    return 0;
}
