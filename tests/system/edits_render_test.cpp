// Moving ground in pictures: where heights have changed, the light is that of the new ground, on the whole maps of a
// pack as on maps that come later.
#include <cmath>

#include <epoxy/gl.h>

#include "fjell/edit.h"
#include "fjell/ground_maps.h"
#include "fjell/texture.h"
#include "hosts/game/draw.h"
#include "picture_scene.h"

using namespace pictures;

namespace {

// The mean difference of two pictures, in codes.
double difference(const Picture& a, const Picture& b) {
    double sum = 0;
    REQUIRE(a.colour.rgb.size() == b.colour.rgb.size());
    for (std::size_t i = 0; i < a.colour.rgb.size(); ++i)
        sum += std::abs(static_cast<double>(a.colour.rgb[i]) - static_cast<double>(b.colour.rgb[i]));
    return sum / static_cast<double>(a.colour.rgb.size());
}

// Four tiles, with a crater over their common corner.
struct Moved {
    Scene scene{mountains(257), 7};
    const Terrain& terrain = scene.loaded.terrain;
    io::AlignedMemory memory = io::allocate(edits_bytes(terrain.header()));
    Edits edits;
    Moved() {
        REQUIRE(create_edits(terrain, {}, {memory.get(), edits_bytes(terrain.header())}, edits).ok());
        Stamp crater;
        crater.shape = StampShape::crater;
        crater.x_m = terrain.x_m(133), crater.z_m = terrain.z_m(125);
        crater.radius_m = 900, crater.falloff_m = 400, crater.amount_m = 300;
        StampId id = 0;
        EditReport report;
        REQUIRE(push_stamp(edits, crater, id).ok());
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        REQUIRE((report.applied == 1 && report.samples > 1000));
    }
    [[nodiscard]] baker::Dem heights() const {
        baker::Dem dem = mountains(257);
        for (std::int32_t row = 0; row < 257; ++row)
            for (std::int32_t column = 0; column < 257; ++column)
                dem.heights_m[static_cast<std::size_t>(row * 257 + column)] = data_of(terrain).height_m({column, row});
        return dem;
    }
    // The crater fills most of the picture.
    [[nodiscard]] View view() const { return scene.camera(0.52, 0.62, 900, 0, -35); }
};

// The guide's game draws a live cut with the pack's normal maps alone, and with patches over them.
struct Game {
    game::Drawer drawer;
    std::vector<TileMap> shown;

    explicit Game(Scene& scene) {
        scene.make_cut();
        const std::uint32_t log2 = scene.loaded.pack.header.normal_log2, tiles = scene.loaded.terrain.tile_count();
        MapLayers layers;
        layers.tail_log2 = layers.top_log2 = log2;
        layers.layers[log2] = tiles;
        const CutMesh cut = cut_mesh(scene.cut);
        REQUIRE(drawer.create(FJELL_SOURCE_DIR "/content/hosts/game",
                              {.vertices = static_cast<std::uint32_t>(cut.mesh.vertices.size()),
                               .triangles = static_cast<std::uint32_t>(cut.mesh.indices.size() / 3)},
                              {}, layers) == "");
        for (std::uint32_t tile = 0; tile < tiles; ++tile) {
            std::vector<std::byte> blocks;
            for (std::uint32_t mip = 0; mip < mip_count(log2); ++mip) {
                const ChunkId id{ChunkKind::normal, tile, mip};
                std::vector<std::byte> of_mip(chunk_raw_bytes(scene.loaded.pack.header, id));
                REQUIRE(read_chunk(scene.loaded.pack, id, of_mip).ok());
                blocks.insert(blocks.end(), of_mip.begin(), of_mip.end());
            }
            const MapCommand all{MapKind::normal,
                                 static_cast<std::uint8_t>(log2),
                                 0,
                                 static_cast<std::uint8_t>(mip_count(log2)),
                                 tile,
                                 tile,
                                 0,
                                 blocks};
            drawer.upload(std::span(&all, 1));
            shown.push_back({tile, static_cast<std::uint8_t>(log2), 0});
        }
    }
    [[nodiscard]] Picture draw(Scene& scene, const View& view) {
        CutReport report;
        REQUIRE(rebuild_cut(scene.cut, {&view, 1}, {.max_error_px = 0.5}, report).ok());
        const CutMesh cut = cut_mesh(scene.cut);
        drawer.upload(cut, cut_take_changes(scene.cut));
        glBindFramebuffer(GL_FRAMEBUFFER, scene.target->framebuffer());
        glEnable(GL_FRAMEBUFFER_SRGB);
        glClearColor(0, 0, 0, 1);
        glClearDepth(0);
        glDepthMask(GL_TRUE);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glViewport(0, 0, static_cast<GLsizei>(view.width_px), static_cast<GLsizei>(view.height_px));
        drawer.draw(scene.loaded.terrain, cut, view, {}, shown);
        Picture picture;
        scene.target->read_colour(picture.colour);
        return picture;
    }
};

} // namespace

TEST_CASE("the light on ground that has moved is that on a pack that was baked from the new heights") {
    Moved moved;
    Scene& scene = moved.scene;
    Scene baked(moved.heights(), 7);

    // Tiles in their colours, so that light alone differs.
    const gl::DrawOptions options{.mode = gl::Mode::tiles};
    const View view = moved.view();
    const OwnMesh mesh = full_resolution(moved.terrain);
    const Picture expected = baked.draw(full_resolution(baked.loaded.terrain).view(), view, options);
    const auto follow = [&] {
        do scene.renderer->show_ground();
        while (scene.renderer->stats().ground_waiting != 0);
        return difference(scene.draw(mesh.view(), view, options), expected);
    };
    const double before = difference(scene.draw(mesh.view(), view, options), expected);
    const double after = follow();
    CAPTURE(before, after);
    CHECK(before > 2);
    CHECK(after < before / 50);

    // A renderer that is made later learns of it too.
    scene.renderer = gl::Renderer::create(moved.terrain, scene.loaded.pack,
                                          {.vertices = static_cast<std::uint32_t>(mesh.vertices.size()),
                                           .indices = static_cast<std::uint32_t>(mesh.indices.size()),
                                           .ground = {.texels = 4096}});
    CHECK(follow() < before / 50);
}

TEST_CASE("so is the light in the guide's game, which uploads patches itself") {
    Moved moved;
    Scene baked(moved.heights(), 7);
    Game game(moved.scene), of_baked(baked);
    const View view = moved.view();
    const Picture expected = of_baked.draw(baked, view);
    const double before = difference(game.draw(moved.scene, view), expected);

    const std::size_t bytes = ground_maps_bytes(moved.terrain.header());
    const io::AlignedMemory memory = io::allocate(bytes);
    GroundMaps maps;
    REQUIRE(create_ground_maps(moved.terrain, {}, {memory.get(), bytes}, maps).ok());
    GroundMapsReport report;
    do {
        REQUIRE(update_ground_maps(maps, game.shown, report).ok());
        game.drawer.upload(ground_map_patches(maps));
    } while (report.waiting != 0);
    const double after = difference(game.draw(moved.scene, view), expected);
    CAPTURE(before, after);
    CHECK(before > 2);
    CHECK(after < before / 10); // the two cuts differ where a sphere's radius rounds otherwise
    CHECK(context().log().errors == 0);
}

TEST_CASE("paint shows on the whole maps of a pack, and leaves no trace when it is taken away") {
    Scene scene(mountains(257), 7);
    const Terrain& terrain = scene.loaded.terrain;
    const io::AlignedMemory memory = io::allocate(edits_bytes(terrain.header()));
    Edits edits;
    REQUIRE(create_edits(terrain, {}, {memory.get(), edits_bytes(terrain.header())}, edits).ok());
    const View view = scene.camera(0.52, 0.62, 900, 0, -35);
    const OwnMesh mesh = full_resolution(terrain);
    const gl::DrawOptions options{.lit = false};
    const auto stamped = [&](StampShape shape) {
        Stamp stamp;
        stamp.shape = shape;
        stamp.x_m = terrain.x_m(133), stamp.z_m = terrain.z_m(125), stamp.falloff_m = 200;
        stamp.radius_m = shape == StampShape::paint ? 900 : 1200; // what has faded out, too
        stamp.rgb[0] = 250, stamp.rgb[1] = 10, stamp.rgb[2] = 10;
        StampId id = 0;
        EditReport report;
        REQUIRE(push_stamp(edits, stamp, id).ok());
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        scene.renderer->show_ground();
        return scene.draw(mesh.view(), view, options);
    };
    const Picture before = scene.draw(mesh.view(), view, options), painted = stamped(StampShape::paint);
    std::size_t red = 0;
    for (std::size_t i = 0; i + 2 < painted.colour.rgb.size(); i += 3)
        red += painted.colour.rgb[i] > 220 && painted.colour.rgb[i + 1] < 40;
    CHECK(red > painted.colour.rgb.size() / 3 / 20);
    CHECK(difference(painted, before) > 5);
    CHECK(difference(stamped(StampShape::unpaint), before) == 0);
    CHECK(context().log().errors == 0);
}
