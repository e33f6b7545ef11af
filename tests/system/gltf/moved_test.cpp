// A snapshot of moving ground (fjell/edit.h): its normal textures and its slopes are those of a pack that was baked
// from the new heights.
#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "fjell/edit.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/ground_maps.h"
#include "gltf/baked.h"
#include "shared/terrain_data.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct Exported {
    std::vector<std::vector<std::uint8_t>> normals; // of each tile: RGB texels
    std::vector<std::vector<float>> slopes_deg;
};

Exported exported(const BakedTerrain& baked, const std::string& path, std::uint32_t texture_px) {
    Exported out;
    gltf::SnapshotOptions options;
    options.max_texture_px = texture_px;
    options.paint = [&](const gltf::TileTexels& texels) {
        out.slopes_deg.emplace_back(texels.slope_deg.begin(), texels.slope_deg.end());
    };
    gltf::export_snapshot(baked.pack, baked.terrain, view_of(baked.terrain), 30, path, options);
    tinygltf::Model model;
    std::string errors, warnings;
    REQUIRE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &errors, &warnings, path));
    for (const tinygltf::Material& material : model.materials) {
        const auto texture = static_cast<std::size_t>(material.normalTexture.index);
        const tinygltf::Image& image = model.images[static_cast<std::size_t>(model.textures[texture].source)];
        std::vector<std::uint8_t> rgb;
        for (std::size_t i = 0; i < image.image.size(); ++i)
            if (i % static_cast<std::size_t>(image.component) < 3) rgb.push_back(image.image[i]);
        out.normals.push_back(std::move(rgb));
    }
    return out;
}

// The mean difference of two lists of tiles.
template <typename Number>
double difference(const std::vector<std::vector<Number>>& a, const std::vector<std::vector<Number>>& b) {
    double sum = 0;
    std::size_t count = 0;
    REQUIRE(a.size() == b.size());
    for (std::size_t tile = 0; tile < a.size(); ++tile) {
        REQUIRE(a[tile].size() == b[tile].size());
        for (std::size_t i = 0; i < a[tile].size(); ++i, ++count)
            sum += std::abs(static_cast<double>(a[tile][i]) - static_cast<double>(b[tile][i]));
    }
    return sum / static_cast<double>(count);
}

} // namespace

TEST_CASE("a snapshot's normals and slopes are those of the ground as it has moved", "[gltf]") {
    const Folder folder, new_folder;
    baker::Dem dem = hills(97, 65, 30, 30);
    baker::BakeOptions options;
    options.tile_log2 = 5;
    options.max_texture_log2 = 5;
    const BakedTerrain moved(folder, dem, options);
    const Exported still[] = {exported(moved, folder / "still.glb", 32), exported(moved, folder / "still.glb", 16)};

    const std::size_t bytes = edits_bytes(moved.pack.header);
    const io::AlignedMemory memory = io::allocate(bytes);
    Edits edits;
    REQUIRE(create_edits(moved.terrain, {}, {memory.get(), bytes}, edits).ok());
    Stamp crater;
    crater.shape = StampShape::crater;
    crater.x_m = 34 * 30, crater.z_m = 31 * 30; // over the corner of four tiles
    crater.radius_m = 700, crater.falloff_m = 300, crater.amount_m = 250;
    StampId id = 0;
    EditReport report;
    REQUIRE(push_stamp(edits, crater, id).ok());
    REQUIRE(update_edits(edits, {}, {}, report).ok());
    REQUIRE(report.applied == 1);
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x)
            dem.heights_m[dem.index(x, y)] = data_of(moved.terrain).height_m({x, y});
    const BakedTerrain baked(new_folder, dem, options);

    for (const int mip : {0, 1}) {
        const std::uint32_t texture_px = 32u >> mip;
        const Exported now = exported(moved, folder / "now.glb", texture_px),
                       expected = exported(baked, folder / "expected.glb", texture_px);
        const double slope_deg = difference(now.slopes_deg, expected.slopes_deg),
                     normal = difference(now.normals, expected.normals),
                     old_deg = difference(still[mip].slopes_deg, expected.slopes_deg),
                     old = difference(still[mip].normals, expected.normals);
        CAPTURE(texture_px, slope_deg, old_deg, normal, old);
        CHECK((old_deg > 1 && old > 0.8));
        CHECK(slope_deg < old_deg / 4);
        CHECK(normal < old / 3);
    }
}

TEST_CASE("a snapshot's normals are not those of other maps, which a stream has read again in that frame", "[gltf]") {
    const Folder folder;
    baker::BakeOptions options;
    options.tile_log2 = 5;
    options.max_texture_log2 = 5;
    const BakedTerrain place(folder, hills(97, 65, 30, 30), options);
    const Exported before = exported(place, folder / "before.glb", 32);
    const std::vector<std::byte> black(blocks_of(32) * colour_block_bytes);
    MapPatch patches[12] = {}; // of all tiles
    for (std::uint32_t tile = 0; tile < tiles_of(place.pack.header); ++tile)
        patches[tile] = {MapKind::colour, 5, 0, tile, 0, 0, 0, 32, 32, black};
    TerrainData& t = data_of(place.terrain);
    t.map_patches = patches, t.map_patch_count = tiles_of(place.pack.header);
    const Exported after = exported(place, folder / "after.glb", 32);
    t.map_patch_count = 0;
    CHECK(difference(before.normals, after.normals) == 0);
}

TEST_CASE("a snapshot's colours are under the paint that was there when it was taken", "[gltf]") {
    const Folder folder;
    baker::BakeOptions options;
    options.tile_log2 = 5;
    options.max_texture_log2 = 5;
    const BakedTerrain place(folder, hills(97, 65, 30, 30), options);
    const auto colours = [&](const gltf::Snapshot& snapshot) {
        std::vector<std::vector<std::uint8_t>> rgb;
        gltf::SnapshotOptions as;
        as.paint = [&](const gltf::TileTexels& texels) { rgb.emplace_back(texels.rgb.begin(), texels.rgb.end()); };
        (void)gltf::write_snapshot(place.pack, snapshot, folder / "s.glb", as);
        return rgb;
    };
    const std::size_t bytes = edits_bytes(place.pack.header);
    const io::AlignedMemory memory = io::allocate(bytes);
    Edits edits;
    REQUIRE(create_edits(place.terrain, {}, {memory.get(), bytes}, edits).ok());
    const View view = view_of(place.terrain);
    const auto before = colours(gltf::take_refined(place.terrain, view, 30));
    const auto stamped = [&](StampShape shape) {
        Stamp stamp;
        stamp.shape = shape;
        stamp.x_m = 34 * 30, stamp.z_m = 31 * 30, stamp.radius_m = 600;
        stamp.rgb[0] = 250, stamp.rgb[1] = 3, stamp.rgb[2] = 4;
        StampId id = 0;
        EditReport report;
        REQUIRE(push_stamp(edits, stamp, id).ok());
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        REQUIRE(report.applied == 1);
        return gltf::take_refined(place.terrain, view, 30);
    };
    const gltf::Snapshot painted = stamped(StampShape::paint), bare = stamped(StampShape::unpaint);
    CHECK(difference(colours(bare), before) == 0);
    const auto now = colours(painted); // written after the paint was taken away
    CHECK(difference(now, before) > 1);
    std::size_t red = 0;
    for (const auto& tile : now)
        for (std::size_t i = 0; i < tile.size(); i += 3) red += tile[i] > 240 && tile[i + 1] < 14 && tile[i + 2] < 14;
    CHECK(red > 200);
}
