// Materials: what recipes draw, and the file that they go into.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <xxhash.h>

#include "baker/maps/colour.h"
#include "baker/materials/canvas.h"
#include "baker/materials/encode.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "fjell/texture.h"
#include "raster.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::baker;

namespace {

const std::string recipes_folder = FJELL_SOURCE_DIR "/content/materials";

// The mean difference between neighbours, pair by pair of columns (or rows): the last is that of the last and the
// first.
std::vector<double> steps_between(const std::vector<float>& values, std::uint32_t side, std::size_t channels,
                                  bool rows) {
    std::vector<double> steps(side);
    const std::size_t along = channels * (rows ? side : 1), across = channels * (rows ? 1 : side);
    for (std::size_t i = 0; i < side; ++i)
        for (std::size_t k = 0; k < side; ++k)
            for (std::size_t c = 0; c < channels; ++c)
                steps[i] += std::abs(static_cast<double>(values[i * along + k * across + c]) -
                                     static_cast<double>(values[(i + 1) % side * along + k * across + c]));
    return steps;
}

void refuses_material(const std::string& text, const std::string& message) {
    CHECK_THROWS_WITH((void)parse_material(text, "moss.json"), Catch::Contains(message));
}

std::string failure_of(const std::vector<std::byte>& file) {
    try {
        (void)io::open_materials(file, "m");
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        return failure.what();
    }
    return {};
}

// One of everything, with colours that no table had a part in.
MaterialRecipe everything() {
    MaterialRecipe m;
    m.name = "everything";
    m.base = {0.2f, 0.15f, 0.1f};
    for (const Draw draw :
         {Draw::noise, Draw::cells, Draw::plates, Draw::cracks, Draw::ripples, Draw::stones, Draw::strokes}) {
        MaterialStep step;
        step.draw = draw;
        step.noise.form = draw == Draw::cells    ? NoiseForm::ridged
                          : draw == Draw::plates ? NoiseForm::billow
                                                 : NoiseForm::soft;
        step.height = 0.1f;
        step.warp = 0.1f;
        step.count = 60;
        step.size[0] = 0.03f, step.size[1] = 0.2f;
        step.width = 0.05f;
        step.angular = 0.6f;
        step.leaf = 0.5f;
        step.clump = 0.5f;
        step.opacity = 0.8f;
        step.rgb = {0.1f, 0.2f, 0.3f, 0.6f, 0.5f, 0.4f};
        m.steps.push_back(step);
    }
    return m;
}

std::vector<std::byte> small_file() {
    MaterialRecipe m = everything();
    std::vector<MaterialTexels> texels{make_material(m, 32)};
    m.name = "other";
    m.steps.resize(2);
    texels.push_back(make_material(m, 32));
    return io::materials_file(encode_materials(texels).materials);
}

} // namespace

TEST_CASE("every material of content repeats without a seam, in colour, height and normal") {
    for (const MaterialRecipe& recipe : read_materials(recipes_folder)) {
        INFO(recipe.name);
        const MaterialTexels t = make_material(recipe, test::rounds<std::uint32_t>(64, 256));
        for (const bool rows : {false, true})
            for (const auto& [values, channels] : {std::pair{&t.rgb, 3u}, {&t.height, 1u}, {&t.normal, 2u}}) {
                std::vector<double> steps = steps_between(*values, t.side, channels, rows);
                const double seam = steps.back();
                steps.pop_back();
                CHECK(seam > 0);
                CHECK(seam <= 1.1 * *std::max_element(steps.begin(), steps.end()));
            }
    }
}

TEST_CASE("the materials of content are ten, and no two are of one colour or without relief") {
    std::vector<MaterialTexels> texels;
    for (const MaterialRecipe& recipe : read_materials(recipes_folder)) texels.push_back(make_material(recipe, 32));
    REQUIRE(texels.size() == 10);
    for (const MaterialTexels& a : texels) {
        INFO(a.record.name);
        CHECK(a.record.relief_m > 0.005f);
        for (const MaterialTexels& b : texels) {
            if (&a == &b) continue;
            double apart = 0;
            for (std::size_t c = 0; c < 3; ++c)
                apart += std::abs(static_cast<double>(a.record.mean[c]) - static_cast<double>(b.record.mean[c]));
            CHECK(apart > 0.01);
        }
    }
}

TEST_CASE("one recipe draws one picture, whoever compiled the program") {
    const Canvas canvas = draw_material(everything(), 64);
    const std::uint64_t hash = XXH3_64bits(canvas.height.data(), canvas.height.size() * sizeof(float)) ^
                               XXH3_64bits(canvas.rgb.data(), canvas.rgb.size() * sizeof(float));
    CHECK(hash == 0x5d826ea8da1d4ac6); // g++ and clang, -O0 to -O3
}

TEST_CASE("a file of materials comes back as it was, and a damaged one is refused") {
    std::vector<std::byte> file = small_file();
    const io::Materials materials = io::open_materials(file, "m");
    REQUIRE(materials.records.size() == 2);
    CHECK(materials.find("other") == 1);
    CHECK(materials.find("none") == -1);
    CHECK(materials.mips() == 4);
    CHECK(io::materials_file(materials) == file);

    CHECK(failure_of({}) == "m: is not a file of materials; make it again with fjell-bake materials");
    for (std::size_t bytes = 0; bytes < file.size(); bytes += test::rounds<std::size_t>(97, 1))
        CHECK_FALSE(failure_of({file.begin(), file.begin() + static_cast<std::ptrdiff_t>(bytes)}).empty());
    for (std::size_t at = 0; at < file.size(); at += test::rounds<std::size_t>(23, 1)) {
        file[at] ^= std::byte{0x10};
        CHECK_FALSE(failure_of(file).empty());
        file[at] ^= std::byte{0x10};
    }
    file[8] = std::byte{9};
    CHECK_THAT(failure_of(file), Catch::Contains("has materials of version 9, and this program reads version 1"));
}

TEST_CASE("blocks of a file are the material's colours, heights and normals") {
    MaterialRecipe flat;
    flat.name = "flat";
    flat.base = {light_of_srgb(200), light_of_srgb(100), light_of_srgb(50)};
    const std::vector<std::byte> file = io::materials_file(encode_materials({make_material(flat, 16)}).materials);
    const io::Materials m = io::open_materials(file, "m");
    std::vector<std::byte> colour, both;
    for (std::size_t block = 0; block < 16; ++block) {
        const std::byte* const at = m.colour.data() + 16 * block;
        both.insert(both.end(), at, at + 8);
        both.insert(both.end(), at, at + 8);
        colour.insert(colour.end(), at + 8, at + 16);
    }
    std::vector<std::uint8_t> rgb(3 * 256), height(2 * 256), normal(2 * 256);
    REQUIRE(decode_colour(colour, 16, rgb).ok());
    REQUIRE(decode_normal(both, 16, height).ok());
    REQUIRE(decode_normal(m.normal.first(256), 16, normal).ok());
    for (std::size_t i = 0; i < 256; ++i) {
        CHECK(std::abs(rgb[3 * i] - 200) <= 2); // a block of one colour: blocks.h
        CHECK(std::abs(rgb[3 * i + 1] - 100) <= 2);
        CHECK(std::abs(rgb[3 * i + 2] - 50) <= 2);
        CHECK(height[2 * i] == 128);
        CHECK(normal[2 * i] == 128);
        CHECK(normal[2 * i + 1] == 128);
    }
}

TEST_CASE("what is wrong with a recipe is said with its file, step and key") {
    const std::string base = R"("base": [1, 2, 3], )";
    refuses_material("[]", "moss.json: must be a JSON object");
    refuses_material("{}", "moss.json: \"steps\" is missing; see content/materials/rock.json");
    refuses_material(R"({"steps": [{"draw": "noise"}]})", "\"base\" must be one colour");
    refuses_material("{" + base + R"("steps": []})", "\"steps\" must be a list of 1 to 32 steps");
    refuses_material("{" + base + R"("size_m": 0, "steps": [{"draw": "noise"}]})",
                     "\"size_m\" must be a number in 0.25..64");
    refuses_material("{" + base + R"("hue": 1, "steps": [{"draw": "noise"}]})", "unknown field \"hue\"");
    refuses_material(
        "{" + base + R"("steps": [{"draw": "noise"}, {"draw": "moss"}]})",
        "moss.json: step 1: \"draw\" must be one of noise, cells, plates, cracks, ripples, stones, strokes");
    refuses_material("{" + base + R"("steps": [{"draw": "noise", "cells": 0}]})",
                     "step 0: \"cells\" must be a whole number in 1..256");
    refuses_material("{" + base + R"("steps": [{"draw": "noise", "opacity": 1}]})",
                     "step 0: \"opacity\" needs \"rgb\"");
    refuses_material("{" + base + R"("steps": [{"draw": "stones", "size": [0.2, 0.1]}]})",
                     "step 0: \"size\" must hold two numbers in 0.0005..0.5, the lower first");
    refuses_material("{" + base + R"("steps": [{"draw": "noise", "low": 1, "high": 1}]})",
                     "\"high\" must be above \"low\"");
    refuses_material(R"({"albedo": "a.png", "steps": []})", "give either \"albedo\" or \"steps\"");
    refuses_material(R"({"normal": "n.png"})", "\"normal\" and \"height\" need an \"albedo\"");
    CHECK_THROWS_WITH((void)read_materials(FJELL_SOURCE_DIR "/content/hosts"),
                      Catch::Contains("holds no recipe (*.json)"));
}

TEST_CASE("a material of one's own images has their colours and normals") {
    const test::TempDir temporary;
    const auto write = [&](const std::string& name, int side, std::vector<double> bands) {
        test::Raster raster;
        raster.columns = raster.rows = side;
        raster.bands = static_cast<int>(bands.size());
        raster.type = GDT_Byte;
        raster.values.resize(static_cast<std::size_t>(side * side));
        raster.more = [&](GDALDataset& file) {
            for (std::size_t b = 0; b < bands.size(); ++b)
                REQUIRE(file.GetRasterBand(static_cast<int>(b) + 1)->Fill(bands[b]) == CE_None);
        };
        (void)test::write(raster, temporary / name);
    };
    write("a.tif", 32, {200, 100, 50});
    write("n.tif", 32, {192, 191, 230});
    MaterialRecipe m = parse_material(R"({"albedo": "a.tif", "normal": "n.tif"})", "own.json");
    m.albedo = temporary / m.albedo;
    m.normal = temporary / m.normal;
    const MaterialTexels t = make_material(m, 16); // half as many
    CHECK(t.record.mean[0] == Approx(light_of_srgb(200)).margin(1e-4));
    CHECK(t.record.mean[2] == Approx(light_of_srgb(50)).margin(1e-4));
    CHECK(t.normal[0] == Approx(64.0 / 127).margin(0.005));
    CHECK(t.normal[1] == Approx(-63.0 / 127).margin(0.005)); // green is up in the image: north
    CHECK_THROWS_WITH((void)make_material(m, 64),
                      Catch::Contains("has 32 texels a side where 64 are asked for; give --size 32"));
    write("a.tif", 24, {100, 100, 100});
    CHECK_THROWS_WITH((void)make_material(m, 16), Catch::Contains("is 24 x 24 where a texture is square"));
}
