// Pictures of streamed maps: what is resident shows, without a seam and without a jump.
#include <cmath>
#include <cstdlib>

#include "fjell/gl/palette.h"
#include "gl/terrain_textures.h"
#include "picture_scene.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/rounds.h"
#include "support/splat_rules.h"
#include "support/terrain_fixture.h"

using namespace pictures;

namespace {

baker::Dem relief_ground(int samples, const char* relief) {
    const std::string n = std::to_string(samples);
    return baker::synthesise_text(R"({"columns": )" + n + R"(, "rows": )" + n +
                                  R"(, "spacing_m": 30, "seed": 7, "base_m": 0, )" + relief + "}");
}
constexpr const char* mountain_relief = R"("relief_m": 2500, "feature_m": 12000)";

constexpr std::uint32_t tail_log2 = 3;

// A scene whose renderer draws streamed maps, with layers for every size; the scene's own draws the whole pack.
struct Streamed {
    Scene scene;
    std::unique_ptr<gl::Renderer> whole;
    MapLayers slots[map_kinds];
    std::vector<TileMap> shown[map_kinds];

    Streamed(baker::Dem dem, int tile_log2, std::uint32_t ring_bytes = 0)
        : scene(std::move(dem), tile_log2, PageOrder::planar, 2, fjell::test::RulesFile().path()) {
        const PackHeader& header = scene.loaded.pack.header;
        const std::uint32_t tiles = scene.loaded.pack.tile_count();
        for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
            slots[kind].tail_log2 = tail_log2;
            slots[kind].top_log2 = kind == 0   ? header.colour_log2
                                   : kind == 1 ? header.normal_log2
                                   : kind == 2 ? header.horizon_log2
                                               : header.splat_log2;
            REQUIRE(slots[kind].top_log2 > tail_log2);
            for (std::uint32_t log2 = tail_log2; log2 <= slots[kind].top_log2; ++log2) slots[kind].layers[log2] = tiles;
            shown[kind].resize(tiles);
        }
        gl::RendererOptions options{.vertices = 1u << 20, .indices = 1u << 22, .ring_bytes = ring_bytes};
        options.colour = slots[0];
        options.normal = slots[1];
        options.horizon = slots[2];
        options.splat = slots[3];
        whole = std::exchange(scene.renderer, gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack, options));
    }
    [[nodiscard]] std::uint32_t top(std::uint32_t kind) const { return slots[kind].top_log2; }

    [[nodiscard]] std::vector<std::byte> mip(std::uint32_t kind, std::uint32_t tile, std::uint32_t log2) const {
        constexpr ChunkKind chunks[map_kinds] = {ChunkKind::colour, ChunkKind::normal, ChunkKind::horizon,
                                                 ChunkKind::splat};
        const ChunkId id{chunks[kind], tile, top(kind) - log2};
        std::vector<std::byte> blocks(chunk_raw_bytes(scene.loaded.pack.header, id));
        REQUIRE(read_chunk(scene.loaded.pack, id, blocks).ok());
        return blocks;
    }
    // Any layer will do but a tail's; this one shows that it is heeded.
    [[nodiscard]] std::uint32_t layer(std::uint32_t tile, std::uint32_t log2) const {
        return log2 == tail_log2 ? tile : (tile + log2) % scene.loaded.pack.tile_count();
    }
    void send(const MapCommand& command) { scene.renderer->upload(std::span(&command, 1)); }
    void load_tail(std::uint32_t kind, std::uint32_t tile) {
        std::vector<std::byte> blocks;
        for (std::uint32_t log2 = tail_log2; log2 >= 2; --log2) {
            const std::vector<std::byte> part = mip(kind, tile, log2);
            blocks.insert(blocks.end(), part.begin(), part.end());
        }
        send({static_cast<MapKind>(kind), tail_log2, 0, static_cast<std::uint8_t>(mip_count(tail_log2)), tile, tile, 0,
              blocks});
        shown[kind][tile] = {tile, tail_log2, static_cast<float>(top(kind) - tail_log2)};
    }
    // Mip by mip, as a stream brings them.
    void refine(std::uint32_t kind, std::uint32_t tile, std::uint32_t to_log2) {
        for (std::uint32_t log2 = shown[kind][tile].side_log2 + 1u; log2 <= to_log2; ++log2) {
            const std::vector<std::byte> blocks = mip(kind, tile, log2);
            send({static_cast<MapKind>(kind), static_cast<std::uint8_t>(log2), static_cast<std::uint8_t>(log2 - 1), 1,
                  tile, layer(tile, log2), layer(tile, log2 - 1), blocks});
            shown[kind][tile] = {layer(tile, log2), static_cast<std::uint8_t>(log2),
                                 static_cast<float>(top(kind) - log2)};
        }
    }
    void load_all() {
        for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
            for (std::uint32_t tile = 0; tile < shown[kind].size(); ++tile) {
                load_tail(kind, tile);
                refine(kind, tile, top(kind));
            }
    }
    void show() { scene.renderer->show_maps(shown[0], shown[1], shown[2], shown[3]); }
    // The whole pack drawn with the same least mips.
    Picture reference(const OwnMesh& mesh, const View& view, const gl::DrawOptions& options = {}) {
        std::vector<TileMap> same[map_kinds];
        for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
            for (std::uint32_t tile = 0; tile < shown[kind].size(); ++tile)
                same[kind].push_back({tile, static_cast<std::uint8_t>(top(kind)), shown[kind][tile].min_lod});
        whole->show_maps(same[0], same[1], same[2], same[3]);
        std::swap(whole, scene.renderer);
        Picture picture = scene.draw(mesh.view(), view, options);
        std::swap(whole, scene.renderer);
        return picture;
    }
};

int largest_step(const gl::Image& a, const gl::Image& b) {
    int most = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) most = std::max(most, std::abs(a.rgb[i] - b.rgb[i]));
    return most;
}

// Looks straight down on the middle of the terrain, so that `across_m` fill the picture's height.
View map_from_above(const Scene& scene, double across_m) {
    View view = scene.camera(0.5, 0.5, across_m / (2 * std::tan(pi / 8)), 0, -90);
    return view;
}

} // namespace

TEST_CASE("streamed maps that are all resident give the picture of the whole pack", "[picture]") {
    // 1: the least, so that blocks come in several regions.
    for (const std::uint32_t ring_bytes : test::first_of(1, {1u, 0u})) {
        Streamed streamed(relief_ground(257, mountain_relief), 6, ring_bytes);
        const OwnMesh mesh = full_resolution(streamed.scene.loaded.terrain);
        streamed.load_all();
        streamed.show();
        for (const View& view : {streamed.scene.camera(0.5, 0.9, 150, 0, -5), map_from_above(streamed.scene, 6000)}) {
            const Picture drawn = streamed.scene.draw(mesh.view(), view), whole = streamed.reference(mesh, view);
            CHECK((drawn.depth == whole.depth));
            // The same arrays, levels and layers' contents: the same arithmetic.
            CHECK(largest_step(drawn.colour, whole.colour) == 0);
        }
    }
}

TEST_CASE("a tile in a smaller array looks as its mips do in the pack's own size", "[picture]") {
    Streamed streamed(relief_ground(257, mountain_relief), 6);
    const OwnMesh mesh = full_resolution(streamed.scene.loaded.terrain);
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        for (std::uint32_t tile = 0; tile < streamed.shown[kind].size(); ++tile) {
            streamed.load_tail(kind, tile);
            streamed.refine(kind, tile, tail_log2 + (tile * 7 + kind) % (streamed.top(kind) - tail_log2 + 1));
        }
    streamed.show();
    const gl::DrawOptions ground{.sky = false}; // around it colours come from whatever mip there is
    for (const View& view : {streamed.scene.camera(0.5, 0.9, 150, 0, -5), map_from_above(streamed.scene, 6000)}) {
        const Picture drawn = streamed.scene.draw(mesh.view(), view, ground),
                      whole = streamed.reference(mesh, view, ground);
        // uv times another power of two rounds alike, but a level counted from another mip 0 does not: a step of the
        // weight between two mips, 1/256 of their contrast, and another for rounding the result.
        CHECK(largest_step(drawn.colour, whole.colour) <= 2);
        CHECK(largest_step(drawn.colour, streamed.scene.draw(mesh.view(), view, {.mode = gl::Mode::mips}).colour) > 20);
    }
    // And a map with too coarse a `finest` is another picture, or the comparison was blind.
    const View view = map_from_above(streamed.scene, 6000);
    const Picture before = streamed.scene.draw(mesh.view(), view);
    for (std::vector<TileMap>& kind : streamed.shown)
        for (TileMap& map : kind) map.min_lod += 1;
    streamed.show();
    CHECK(largest_step(before.colour, streamed.scene.draw(mesh.view(), view).colour) > 20);
}

namespace {

// The largest steps from pixel to pixel: across the borders between four tiles, which run between the middle pixels,
// and elsewhere.
struct Steps {
    int across = 0, inside = 0;
    explicit Steps(const gl::Image& image) {
        const auto step = [&](std::uint32_t x, std::uint32_t y, std::uint32_t dx, std::uint32_t dy) {
            int most = 0;
            for (std::size_t k = 0; k < 3; ++k)
                most = std::max(most, std::abs(image.pixel(x, y)[k] - image.pixel(x - dx, y - dy)[k]));
            return most;
        };
        for (std::uint32_t y = 1; y < image.height; ++y)
            for (std::uint32_t x = 1; x < image.width; ++x) {
                const bool border_x = x + 1 >= image.width / 2 && x <= image.width / 2 + 1;
                const bool border_y = y + 1 >= image.height / 2 && y <= image.height / 2 + 1;
                int& most = border_x || border_y ? across : inside;
                most = std::max({most, step(x, y, 1, 0), step(x, y, 0, 1)});
            }
    }
};

} // namespace

TEST_CASE("neighbours of different mips meet without a seam", "[picture]") {
    Streamed streamed(relief_ground(129, R"("relief_m": 300, "feature_m": 60000)"), 6); // smooth, two by two tiles
    const OwnMesh mesh = full_resolution(streamed.scene.loaded.terrain);
    const View view = map_from_above(streamed.scene, 2600);
    const auto draw = [&](const gl::DrawOptions& drawing) {
        const Picture picture = streamed.scene.draw(mesh.view(), view, drawing);
        REQUIRE(std::count(picture.depth.begin(), picture.depth.end(), 0.0f) == 0);
        return Steps(picture.colour);
    };
    const gl::DrawOptions lit{.haze = false}, bare{.lit = false, .haze = false},
        mips{.mode = gl::Mode::mips, .lit = false, .haze = false};
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        for (const std::uint32_t tile : {0u, 1u, 2u, 3u}) streamed.load_tail(kind, tile);
    streamed.show();
    // What steps there are between equal mips is compression: neighbours' blocks decode to different border texels.
    const Steps lit_alone = draw(lit), bare_alone = draw(bare);
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        for (const std::uint32_t tile : {0u, 3u}) // a chess board: every border has both
            streamed.refine(kind, tile, streamed.top(kind));
    streamed.show();
    // Pixels beside a border lie half a pixel off it, where the fine tile has left the coarsest mip by 1/500 of the
    // way: less than a code, which may round to one.
    const Steps lit_mixed = draw(lit), bare_mixed = draw(bare), mips_mixed = draw(mips);
    CHECK(lit_mixed.across <= std::max(lit_alone.across, lit_mixed.inside) + 1);
    CHECK(bare_mixed.across <= std::max(bare_alone.across, bare_mixed.inside) + 1);
    // The mip itself: it moves by the same share of its way from pixel to pixel everywhere.
    CHECK(mips_mixed.across <= mips_mixed.inside);
    CHECK(mips_mixed.inside > 0);
    CHECK(mips_mixed.inside < 10); // or a seam could hide
}

TEST_CASE("a mip fades in without a jump", "[picture]") {
    Streamed streamed(relief_ground(257, mountain_relief), 6);
    const OwnMesh mesh = full_resolution(streamed.scene.loaded.terrain);
    streamed.load_all();
    const View view = map_from_above(streamed.scene, 3500); // a texel of mip 1 covers 8 pixels: `finest` alone decides
    constexpr int steps = 32;
    streamed.scene.target = gl::Target::create({320, 240, 1}); // 66 pictures
    // All tiles, or every second one beside others that stay as they are.
    for (const bool all : test::first_of(1, {false, true})) {
        const auto at = [&](int i) {
            for (std::vector<TileMap>& kind : streamed.shown)
                for (std::uint32_t tile = 0; tile < kind.size(); ++tile)
                    kind[tile].min_lod = all || (tile + tile / 4) % 2 ? 2 - static_cast<float>(i) / steps : 2;
            streamed.show();
            return streamed.scene.draw(mesh.view(), view, {.lit = false, .haze = false}).colour;
        };
        const gl::Image coarse = at(0), fine = at(steps);
        REQUIRE(largest_step(coarse, fine) > 10);
        // In linear light a pixel is a + (b - a) w, and in a step w moves by 1 / steps of its way. Mesa's software
        // driver narrows the blend to the middle half of the way ("brilinear") and takes the fraction of a logarithm
        // from the mantissa, whose slope is up to 1 / ln 2: 2 / ln 2 times as much at most. Weights have 8 bits. Of
        // every picture a pixel is rounded to half a code.
        const double share = 2 / std::log(2.0) / steps + 2.0 / 256;
        std::vector<double> light(256), half(256); // of a code, and of half a code there
        for (int code = 0; code < 256; ++code) {
            light[static_cast<std::size_t>(code)] = linear(code);
            half[static_cast<std::size_t>(code)] = (linear(code + 0.5) - linear(code - 0.5)) / 2;
        }
        gl::Image before = coarse;
        double worst = 0;
        for (int i = 1; i <= steps; ++i) {
            const gl::Image now = at(i);
            for (std::size_t p = 0; p < now.rgb.size(); ++p) {
                const std::uint8_t a = coarse.rgb[p], b = fine.rgb[p], x = before.rgb[p], y = now.rgb[p];
                const double way = std::abs(light[a] - light[b]) + half[a] + half[b];
                worst = std::max(worst, std::abs(light[x] - light[y]) - (way * share + half[x] + half[y]));
            }
            before = now;
        }
        INFO("all tiles " << all);
        CHECK(worst <= 0);
        CHECK((before.rgb == fine.rgb));
    }
}

TEST_CASE("a tile whose maps have not come is drawn as rock, and its neighbours as they are", "[picture]") {
    Streamed streamed(relief_ground(129, mountain_relief), 6);
    const OwnMesh mesh = full_resolution(streamed.scene.loaded.terrain);
    const View view = map_from_above(streamed.scene, 3000);
    const gl::DrawOptions ground{.sky = false}; // what goes on around has colours of all tiles
    const Picture nothing = streamed.scene.draw(mesh.view(), view, ground); // before any call
    streamed.load_all();
    streamed.show();
    const Picture all = streamed.scene.draw(mesh.view(), view, ground);
    streamed.shown[0][3] = streamed.shown[1][3] = streamed.shown[2][3] = {};
    streamed.show();
    const Picture three = streamed.scene.draw(mesh.view(), view, ground);
    std::size_t mixed = 0, bare = 0;
    for (std::uint32_t y = 0; y < height_px; ++y)
        for (std::uint32_t x = 0; x < width_px; ++x) {
            const bool fourth = x >= width_px / 2 && y >= height_px / 2;
            const std::uint8_t* const is = three.colour.pixel(x, y);
            const std::uint8_t* const expected = (fourth ? nothing : all).colour.pixel(x, y);
            mixed += !std::equal(is, is + 3, expected);
            bare += fourth && !std::equal(is, is + 3, all.colour.pixel(x, y));
        }
    CHECK(mixed <= width_px + height_px); // pixels whose middle is on the border
    CHECK(bare > width_px * height_px / 5);
}

TEST_CASE("the modes of tiles, mips and residency show what their legends say", "[picture]") {
    Streamed streamed(relief_ground(257, mountain_relief), 7);
    Scene& scene = streamed.scene;
    Terrain& terrain = scene.loaded.terrain;
    const OwnMesh mesh = full_resolution(terrain);
    const View view = map_from_above(scene, 7000);
    const auto colour_at = [&](const Picture& picture, double column, double row) {
        const Vec3 p{column * 30 - view.eye_m.x, 0, row * 30 - view.eye_m.z};
        // The ground's height under the pixel moves it: take the pixel of this place at its own height.
        const double h = data_of(terrain).ground_m(column * 30, row * 30) - view.eye_m.y;
        const double x = width_px / 2.0 + focal_length_px(view) * p.x / -h,
                     y = height_px / 2.0 + focal_length_px(view) * p.z / -h;
        const std::uint8_t* pixel = picture.colour.pixel(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
        return gl::Rgb8{pixel[0], pixel[1], pixel[2]};
    };
    const auto close = [](const gl::Rgb8& a, const gl::Rgb8& b) { // sRGB -> linear -> sRGB may round once
        return std::abs(a[0] - b[0]) <= 1 && std::abs(a[1] - b[1]) <= 1 && std::abs(a[2] - b[2]) <= 1;
    };
    const gl::DrawOptions bare{.sky = false, .lit = false, .haze = false};
    gl::DrawOptions drawing = bare;

    drawing.mode = gl::Mode::tiles;
    const Picture tiles = scene.draw(mesh.view(), view, drawing);
    for (std::uint32_t row = 0; row < 2; ++row)
        for (std::uint32_t column = 0; column < 2; ++column)
            CHECK(close(colour_at(tiles, 64 + 128 * column, 64 + 128 * row), gl::tile_rgb(column, row)));

    for (std::uint32_t tile = 0; tile < 36; ++tile) // no tile looks like one that it touches
        for (const auto& [dx, dy] : {std::pair{1u, 0u}, {0u, 1u}, {1u, 1u}, {1u, ~0u}}) {
            const gl::Rgb8 a = gl::tile_rgb(6 + tile % 6, 6 + tile / 6),
                           b = gl::tile_rgb(6 + tile % 6 + dx, 6 + tile / 6 + dy);
            CHECK(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 60);
        }

    drawing.mode = gl::Mode::mips;
    streamed.load_all();
    const auto mips = static_cast<int>(mip_count(streamed.top(0)));
    for (int mip = mips - 1; mip >= 2; --mip) {
        for (TileMap& map : streamed.shown[0]) map.min_lod = static_cast<float>(mip);
        streamed.show();
        const Picture picture = scene.draw(mesh.view(), map_from_above(scene, 7000), drawing);
        CHECK(close(colour_at(picture, 40, 200), gl::mip_rgb(mip, mips)));
    }

    drawing.mode = gl::Mode::residency;
    CHECK(close(colour_at(scene.draw(mesh.view(), view, drawing), 100, 100), gl::step_rgb(0, 7)));
    // Of tile 0 the page of step 1 over its north-west goes, and all of tile 3.
    (void)unload_page(terrain, 0, data_of(terrain).pages.page_at(0, 0, 0));
    for (std::uint32_t page = terrain.pages_per_tile(); page-- > 0;) (void)unload_page(terrain, 3, page);
    const Picture some = scene.draw(mesh.view(), view, drawing);
    CHECK(close(colour_at(some, 60, 60), gl::step_rgb(1, 7)));
    CHECK(close(colour_at(some, 68, 60), gl::step_rgb(0, 7)));
    CHECK(close(colour_at(some, 60, 68), gl::step_rgb(0, 7)));
    CHECK(close(colour_at(some, 200, 200), gl::step_rgb(7, 7)));
    CHECK(close(colour_at(some, 200, 60), gl::step_rgb(0, 7)));
}

TEST_CASE("the resident step over a place is the finest down to which all pages that cover it are loaded") {
    test::Random random(163);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z}) {
        baker::BakeOptions options = test::small_bake(8);
        options.order = order;
        const auto pack = test::bake_and_load(test::random_dem(random, 257, 257, test::Shape::fractal), options);
        test::PagedTerrain paged(pack.pack, {});
        Terrain& terrain = paged.terrain;
        const std::uint32_t square = 1u << gl::residency_square_log2(terrain.header()),
                            side = data_of(terrain).pages.side();
        for (int round = 0; round < 30; ++round) {
            for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
                if (data_of(terrain).page_table[page].slot == no_index)
                    REQUIRE(load_page(pack.pack, terrain, 0, page).ok());
            for (std::uint32_t page = round == 0 ? 0 : 1; page < terrain.pages_per_tile(); ++page)
                if (test::pick(random, 0, 5) == 0) (void)unload_page(terrain, 0, page);
            for (std::uint32_t y = 0; y < side / square; ++y)
                for (std::uint32_t x = 0; x < side / square; ++x) {
                    // A centre of every step, from the same page as those in the square; coarse first.
                    std::uint32_t finest = terrain.header().tile_log2;
                    for (std::uint32_t z = finest; z-- > 0; finest = z) {
                        const std::uint32_t page_side = std::min(64u << z, side);
                        const std::uint32_t west = x * square / page_side * page_side,
                                            north = y * square / page_side * page_side;
                        const std::uint32_t page =
                            data_of(terrain).pages.place(west + (1u << z), north + (1u << z)).page;
                        if (data_of(terrain).page_table[page].slot == no_index) break;
                    }
                    CAPTURE(round, x, y);
                    REQUIRE(gl::resident_step_log2(terrain, 0, x, y) == finest);
                }
        }
    }
}

TEST_CASE("streamed maps that do not fit are refused with the number to change", "[picture]") {
    Streamed streamed(relief_ground(129, mountain_relief), 6);
    Scene& scene = streamed.scene;
    const auto create = [&](const MapLayers& colour) {
        gl::RendererOptions options;
        options.colour = colour;
        return gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack, options);
    };
    MapLayers slots = streamed.slots[0];
    ++slots.top_log2;
    CHECK_THROWS_WITH(create(slots), Catch::Contains("RendererOptions::colour") && !Catch::Contains("\n"));
    slots = streamed.slots[0];
    slots.layers[slots.top_log2] = 1u << 30;
    CHECK_THROWS_WITH(create(slots), Catch::Contains("StreamBudget::map_bytes") && !Catch::Contains("\n"));
    slots = streamed.slots[0];
    slots.layers[slots.tail_log2] = 1;
    CHECK_THROWS_WITH(create(slots), Catch::Contains("stream_map_layers()") && !Catch::Contains("\n"));
    // More sizes than samplers: a pack that says its map is 2^12 a side. It is refused before anything is made.
    io::LoadedPack& loaded = scene.loaded;
    loaded.pack.header.colour_log2 = 12;
    slots = {2, 12, {}};
    for (std::uint32_t log2 = 2; log2 <= 12; ++log2) slots.layers[log2] = 4;
    CHECK_THROWS_WITH(create(slots), Catch::Contains("StreamBudget::tail_log2") && !Catch::Contains("\n"));
    loaded.pack.header.colour_log2 = streamed.top(0);

    const std::vector<std::byte> blocks = streamed.mip(0, 0, streamed.top(0));
    const auto top = static_cast<std::uint8_t>(streamed.top(0));
    const MapCommand good{MapKind::colour, top, 0, 1, 0, 1, 0, blocks};
    const auto send = [&](MapCommand command) { scene.renderer->upload(std::span(&command, 1)); };
    send(good);
    MapCommand bad = good;
    bad.layer = 4;
    CHECK_THROWS_AS(send(bad), io::Failure);
    bad = good;
    bad.side_log2 = 31;
    CHECK_THROWS_AS(send(bad), io::Failure);
    bad = good;
    bad.upload_mips = 2;
    CHECK_THROWS_AS(send(bad), io::Failure);
    bad = good;
    bad.from_log2 = 2;
    CHECK_THROWS_AS(send(bad), io::Failure);
    streamed.shown[0][2] = {4, top, 0};
    CHECK_THROWS_AS(scene.renderer->show_maps(streamed.shown[0], streamed.shown[1]), io::Failure);
    streamed.shown[0].pop_back();
    CHECK_THROWS_AS(scene.renderer->show_maps(streamed.shown[0], {}), io::Failure);
    CHECK(context().log().errors == 0);
}
