// The snapshot, seen by two strangers: Khronos' validator and a checker that knows only the fields of extras.fjell
// (gltf/*.mjs).
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/texture.h"
#include "gltf/baked.h"
#include "support/dem.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/set_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::string quoted(const std::string& path) {
    return "'" + path + "'";
}

std::string vector_argument(const char* option, Vec3 v) {
    return std::string(" ") + option + " " + std::to_string(v.x) + " " + std::to_string(v.y) + " " +
           std::to_string(v.z);
}

// infos: of textures whose sides are no powers of two, and of what the validator does not know.
void require_valid(const std::string& glb, int infos = 0) {
    const NodeResult result = node("validate.mjs", quoted(glb));
    INFO(result.output);
    REQUIRE(result.exit_code == 0);
    CHECK(result.output.find(" 0 errors, 0 warnings, " + std::to_string(infos) + " infos, 0 hints") !=
          std::string::npos);
}

void require_sound(const std::string& glb, const std::string& arguments) {
    const NodeResult result = node("check.mjs", quoted(glb) + arguments);
    INFO(result.output);
    REQUIRE(result.exit_code == 0);
}

gltf::SnapshotCounts require_export(const BakedTerrain& baked, const View& view, double error_px,
                                    const std::string& glb, const gltf::SnapshotOptions& options = {}) {
    const gltf::SnapshotCounts result = gltf::export_snapshot(baked.pack, baked.terrain, view, error_px, glb, options);
    CHECK(result.converged);
    CHECK(result.file_bytes == std::filesystem::file_size(glb));
    return result;
}

baker::BakeOptions options_with(int tile_log2, std::uint32_t max_texture_log2) {
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.max_texture_log2 = max_texture_log2;
    return options;
}

} // namespace

TEST_CASE("the glTF that fjell-bake writes of a mesh and of tiles is valid", "[gltf]") {
    const Folder folder;
    const auto done = [&](const std::string& command) {
        const Run r = run_in(folder.path, FJELL_BIN_DIR "/fjell-bake " + command);
        CAPTURE(command, r.err);
        REQUIRE(r.code == 0);
    };
    std::string grid = "ncols 60\nnrows 50\nxllcorner 430000\nyllcorner 6790000\ncellsize 30\n";
    for (int i = 0; i < 60 * 50; ++i) grid += std::to_string(500 + 90 * std::sin(i * 0.1) * std::cos(i * 0.003)) + " ";
    spit(folder / "dem.asc", grid);
    done("mesh dem.asc -o mesh.glb --max-error-m 3 --quiet");
    require_valid(folder / "mesh.glb");
    done("mesh dem.asc -o mesh.glb --max-error-m 3 --quiet --normal-map");
    require_valid(folder / "mesh.glb", 1);
    done("mesh dem.asc -o small.glb --max-error-m 3 --quiet --normal-map --quantised --meshopt");
    require_valid(folder / "small.glb", 2);
    CHECK(10 * std::filesystem::file_size(folder / "small.glb") < 7 * std::filesystem::file_size(folder / "mesh.glb"));
    REQUIRE(run_in(folder.path, "gdal_translate -q -a_srs EPSG:32632 dem.asc dem.tif").code == 0);
    done("dem.tif -o pack.fjell --crs none --quiet");
    done("tiles pack.fjell -o tiles --format 3dtiles --quiet");
    int tiles = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "tiles"))
        if (entry.path().extension() == ".glb" && ++tiles < 4) require_valid(entry.path().string());
    CHECK(tiles > 2);
}

TEST_CASE("a snapshot of several textured tiles is valid, sound and within the requested error", "[gltf]") {
    const Folder folder;
    // Neither spacing is a float, and the terrain ends inside its last tiles.
    const BakedTerrain baked(folder, hills(3 * 64 + 8, 2 * 64 + 5, 29.7, 31.3), options_with(6, 6));
    const View view = view_of(baked.terrain);
    for (const double error_px : first_of(2, {0.25, 200.0, 1.0, 8.0})) {
        const auto result = require_export(baked, view, error_px, folder / "out.glb");
        CHECK(result.tiles == 4 * 3);
        require_valid(folder / "out.glb");
        require_sound(folder / "out.glb", baked.heights_argument + vector_argument("--forward", view.forward) +
                                              vector_argument("--up", view.up));
    }
}

TEST_CASE("a camera that rolls, looks straight down or backwards keeps its axes", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(129, 129, 10, 10), options_with(6, 4));
    const Vec3 eye{640, 3000, 640};
    const Vec3 axes[][2] = {{{0, -1, 0}, {0, 0, -1}},     {{0, 0, 1}, {0, 1, 0}},    {{0, 0, 1}, {0, -1, 0}},
                            {{1, 0, 0}, {0, 1, 0}},       {{-1, 0, 0}, {0, 0, 1}},   {{0, 1, 0}, {1, 0, 0}},
                            {{0, 0, -1}, {0, -1, 0}},     {{1, -2, 3}, {1, 1, 0.5}}, {{0, 0, -1}, {1, 0, 0}},
                            {{0.1, -0.9, 0.2}, {1, 0, 1}}};
    for (std::size_t i = 0; i < std::size(axes); i += rounds<std::size_t>(3, 1)) {
        const auto& [forward, up] = axes[i]; // in brief rounds down, east, roll and askew
        const View view = make_view(eye, forward, up, 1.2, 640, 480, 0.5, 5000);
        CHECK(require_export(baked, view, 4, folder / "out.glb").tiles == 4);
        require_sound(folder / "out.glb",
                      vector_argument("--forward", view.forward) + vector_argument("--up", view.up));
    }
}

TEST_CASE("a tile of more than 65,535 vertices gets wide indices", "[gltf]") {
    const Folder folder;
    const std::int32_t samples = rounds(385, 513);
    const BakedTerrain baked(folder, hills(samples, samples, 30, 30), options_with(9, 4));
    const auto result = require_export(baked, view_of(baked.terrain), 0.01, folder / "out.glb");
    CHECK(result.vertices > 0xffff);
    require_valid(folder / "out.glb");
    require_sound(folder / "out.glb", baked.heights_argument);
}

TEST_CASE("a mesh larger than the first budget converges too", "[gltf]") {
    if (!full_rounds()) { // a million vertices, read by three programs
        WARN("skipped: FJELL_TEST_ROUNDS=full exports a million vertices");
        return;
    }
    const Folder folder;
    const BakedTerrain baked(folder, hills(1537, 1537, 30, 30), options_with(9, 2));
    CHECK(require_export(baked, view_of(baked.terrain), 0.002, folder / "out.glb").vertices > 1u << 20);
}

TEST_CASE("the colour in the file is the pack's, texel for texel", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(97, 65, 30, 30), options_with(5, 5));
    CHECK(require_export(baked, view_of(baked.terrain), 4, folder / "out.glb").tiles == 6);
    tinygltf::Model model;
    std::string errors, warnings;
    REQUIRE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &errors, &warnings, folder / "out.glb"));
    CHECK(errors + warnings == "");
    REQUIRE(model.materials.size() == baked.pack.tile_count());
    constexpr std::size_t channels = 3;
    const std::uint32_t side = 1u << baked.pack.header.colour_log2;
    std::vector<std::byte> blocks(chunk_raw_bytes(baked.pack.header, {ChunkKind::colour, 0, 0}));
    std::vector<std::uint8_t> texels(std::size_t{side} * side * channels);
    for (std::uint32_t tile = 0; tile < baked.pack.tile_count(); ++tile) {
        REQUIRE(read_chunk(baked.pack, {ChunkKind::colour, tile, 0}, blocks).ok());
        (void)decode_colour(blocks, side, texels);
        const int texture = model.materials[tile].pbrMetallicRoughness.baseColorTexture.index;
        const tinygltf::Image& image =
            model.images[static_cast<std::size_t>(model.textures[static_cast<std::size_t>(texture)].source)];
        const auto components = static_cast<std::size_t>(image.component);
        REQUIRE(image.image.size() / components == texels.size() / channels);
        std::size_t different = 0;
        for (std::size_t i = 0; i < texels.size(); ++i)
            different += texels[i] != image.image[i / channels * components + i % channels];
        CHECK(different == 0);
    }
}

TEST_CASE("of a sparse set all is exported that is there, and it is sound", "[gltf]") {
    const Folder folder;
    const baker::Dem dem = hills(3 * 32 + 8, 2 * 32 + 9, 30, 30);
    const BakedTerrain baked(folder, dem, options_with(5, 5));
    (void)baker::split_pack(folder / "terrain.fjell", folder / "set", {4, 3});
    io::SetFile set = io::parse_set_file(slurp(folder / "set/set.json"), "set");
    const auto missing = [](std::uint32_t tile_x, std::uint32_t tile_y) {
        return (tile_x == 1 && tile_y == 1) || (tile_x == 3 && tile_y == 0);
    };
    std::erase_if(set.packs, [&](const io::SetFilePack& pack) { return missing(pack.tile_x, pack.tile_y); });
    spit(folder / "set/set.json", io::set_file_text(set));
    const io::LoadedPack sparse = io::load_pack(folder / "set", io::LoadTerrain::yes);
    REQUIRE(sparse.pack.header.tiles_held == 10);
    // What the checker may expect: no ground inside the missing tiles; on their borders the neighbours have it.
    std::string heights;
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x) {
            const bool inner = (x % 32 != 0 && y % 32 != 0) || (x > 96 && y < 32);
            float height = dem.heights_m[static_cast<std::size_t>(y * dem.columns + x)];
            if (inner && missing(static_cast<std::uint32_t>(x) / 32, static_cast<std::uint32_t>(y) / 32))
                height = std::numeric_limits<float>::quiet_NaN();
            heights.append(reinterpret_cast<const char*>(&height), sizeof height);
        }
    spit(folder / "heights.f32", heights);
    for (const double error_px : first_of(1, {0.5, 20.0})) {
        const gltf::SnapshotCounts result =
            gltf::export_snapshot(sparse.pack, sparse.terrain, view_of(baked.terrain), error_px, folder / "out.glb");
        CHECK(result.converged);
        CHECK(result.tiles == 10);
        require_valid(folder / "out.glb");
        require_sound(folder / "out.glb", baked.heights_argument);
    }
}

TEST_CASE("a pack without maps gives tiles without texture coordinates", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(65, 65, 30, 30), options_with(5, 4));
    Pack plain = baked.pack;
    plain.header.colour_log2 = plain.header.normal_log2 = plain.header.crs_bytes = 0;
    const auto result = gltf::export_snapshot(plain, baked.terrain, view_of(baked.terrain), 1, folder / "out.glb");
    CHECK(result.texture_px == 0);
    CHECK(result.normal_px == 0);
    require_valid(folder / "out.glb");
    require_sound(folder / "out.glb", baked.heights_argument);
}

TEST_CASE("the largest mip that fits is embedded", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(129, 65, 30, 30), options_with(6, 6));
    const std::uint32_t full = 1u << baked.pack.header.colour_log2;
    const View view = view_of(baked.terrain);
    CHECK(require_export(baked, view, 4, folder / "out.glb").texture_px == full);
    CHECK(require_export(baked, view, 4, folder / "out.glb", {.max_texture_px = full - 1}).texture_px == full / 2);
    CHECK(require_export(baked, view, 4, folder / "out.glb", {.max_texture_px = 0}).texture_px == 4);
    require_sound(folder / "out.glb", "");
}

TEST_CASE("textures have the coarsest mip whose texels are no wider than asked", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(129, 65, 30, 30), options_with(6, 6));
    const std::uint32_t full = 1u << baked.pack.header.colour_log2;
    const View view = view_of(baked.terrain);
    const double tile_m = 64 * 30.0;
    for (std::uint32_t side = full; side >= 8; side /= 2) {
        const double texel_m = tile_m / (side - 1); // outer texel centres lie on the border
        CHECK(require_export(baked, view, 4, folder / "out.glb", {.texel_m = texel_m * 1.001}).texture_px == side);
        if (side < full)
            CHECK(require_export(baked, view, 4, folder / "out.glb", {.texel_m = texel_m * 0.999}).texture_px ==
                  2 * side);
    }
    const gltf::SnapshotOptions wrong{.texel_m = -1};
    CHECK_THROWS_WITH(gltf::export_snapshot(baked.pack, baked.terrain, view, 4, folder / "out.glb", wrong),
                      Catch::Contains("texel_m"));
}

TEST_CASE("the occlusion in the file is the sky that ground hides: dark in a pit, none on a plain", "[gltf]") {
    const Folder folder;
    baker::Dem dem = hills(65, 65, 30, 30);
    for (int y = 0, i = 0; y < 65; ++y)
        for (int x = 0; x < 65; ++x, ++i) // a cone 480 m wide and deep
            dem.heights_m[static_cast<std::size_t>(i)] =
                static_cast<float>(1000 - std::max(480 - 60 * std::hypot(x - 24, y - 40), 0.0));
    baker::BakeOptions options = options_with(6, 6);
    options.horizon_spacing = 2;
    const BakedTerrain baked(folder, dem, options);
    const auto result = require_export(baked, view_of(baked.terrain), 4, folder / "out.glb");
    CHECK(result.occlusion_px == 1u << baked.pack.header.colour_log2);
    require_valid(folder / "out.glb");
    require_sound(folder / "out.glb", baked.heights_argument);
    tinygltf::Model model;
    std::string errors, warnings;
    REQUIRE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &errors, &warnings, folder / "out.glb"));
    const int texture = model.materials.at(0).occlusionTexture.index;
    REQUIRE(texture >= 0);
    const tinygltf::Image& image =
        model.images[static_cast<std::size_t>(model.textures[static_cast<std::size_t>(texture)].source)];
    const auto at = [&](double column, double row) { // sample of the height field -> red
        const auto texel = [&](double sample) { return std::lround(sample / 64 * (image.width - 1)); };
        return static_cast<int>(
            image.image[static_cast<std::size_t>((texel(row) * image.width + texel(column)) * image.component)]);
    };
    // Walls of 63 degrees leave a cone of 27 degrees around the zenith: sin(27 degrees)^2, a fifth of the sky's light,
    // and more where a texel is wider than the bottom.
    CHECK(at(24, 40) < 130);
    CHECK(at(24, 38) < 200); // half-way up nothing stands before the open side
    CHECK(at(60, 4) > 250);
    CHECK(at(4, 4) > 250);
    CHECK(at(40, 24) > 250); // and not mirrored
}

TEST_CASE("the checker notices every way to spoil a snapshot", "[gltf]") {
    const Folder folder;
    const BakedTerrain baked(folder, hills(3 * 32 + 1, 2 * 32 + 1, 30, 30), options_with(5, 5));
    CHECK(require_export(baked, view_of(baked.terrain), 20, folder / "out.glb").tiles == 6);
    const NodeResult result = node("selftest.mjs", quoted(folder / "out.glb") + baked.heights_argument);
    INFO(result.output);
    CHECK(result.exit_code == 0);
}

TEST_CASE("a frame of the Grand Canyon is valid, sound and within the requested error", "[gltf][canyon]") {
    const std::string given = FJELL_DATA_DIR;
    const std::string data = given.empty() ? std::string(FJELL_SOURCE_DIR) + "/../shared/data" : given;
    const std::string dem_path = data + "/dem/grand_canyon_60m_4097x2049_u8.png";
    if (!std::filesystem::exists(dem_path)) {
        std::cout << "skipped: no Grand Canyon DEM in " << data << "; set FJELL_DATA to the folder of real DEMs\n";
        return;
    }
    if (!full_rounds()) {
        std::cout << "skipped: " << dem_path << " is large (FJELL_TEST_ROUNDS=full reads it)\n";
        return;
    }
    const Folder folder;
    baker::ReadOptions reading;
    reading.spacing_m = 60;
    reading.zscale = 14.4;
    reading.zoffset_m = 127;
    const BakedTerrain baked(folder, baker::read_dem(dem_path, reading), options_with(9, 8));
    const auto result = require_export(baked, view_of(baked.terrain), 2, folder / "out.glb");
    CHECK(result.tiles == 32);
    require_valid(folder / "out.glb");
    require_sound(folder / "out.glb", baked.heights_argument);
}
