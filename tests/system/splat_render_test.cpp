// Splat maps in pictures: the materials that a pack says, whole and streamed.
#include <cmath>
#include <string>
#include <vector>

#include "baker/materials/encode.h"
#include "picture_scene.h"
#include "support/splat_rules.h"

using namespace pictures;

namespace {

constexpr std::uint8_t splat_tail = 3;
constexpr std::uint32_t splat_wide = 128, splat_high = 96;

// Two materials of one colour each, no relief, one recipe each.
struct TwoMaterials {
    std::vector<std::byte> bytes;
    io::Materials materials;
    TwoMaterials() {
        std::vector<baker::MaterialTexels> texels;
        for (const bool red : {true, false}) {
            baker::MaterialRecipe m;
            m.name = red ? "red" : "green";
            m.base = {red ? 0.5f : 0.1f, red ? 0.1f : 0.5f, 0.1f};
            texels.push_back(baker::make_material(m, 16));
        }
        bytes = io::materials_file(baker::encode_materials(texels).materials);
        materials = io::open_materials(bytes, "test");
    }
};

// Ground that rises evenly to the east, 4 tiles.
baker::Dem rising() {
    baker::Dem dem;
    dem.columns = dem.rows = 129;
    dem.spacing_m[0] = dem.spacing_m[1] = 16;
    for (int y = 0; y < 129; ++y)
        for (int x = 0; x < 129; ++x) dem.heights_m.push_back(static_cast<float>(x));
    return dem;
}

struct SplatScene {
    Scene scene;
    OwnMesh mesh;
    TwoMaterials file;
    const std::vector<std::string> names{"green", "red"}; // as the rules name them first
    const gl::LayerSettings on{.on = true, .distance_m = 100'000, .tint = 0, .relief = 0};

    explicit SplatScene(const std::string& rules)
        : scene(rising(), 6, PageOrder::planar, 0, fjell::test::RulesFile(rules).path()),
          mesh(full_resolution(scene.loaded.terrain)) {
        scene.target = gl::Target::create({splat_wide, splat_high, 1});
        scene.light.exposure = gl::Exposure::fixed;
        scene.light.tone_curve = gl::ToneCurve::none;
        scene.light.ev100 = 14;
    }
    // The same with splat maps that come by and by.
    MapLayers stream_splat() {
        MapLayers slots;
        slots.tail_log2 = splat_tail;
        slots.top_log2 = scene.loaded.pack.header.splat_log2;
        for (std::uint32_t log2 = splat_tail; log2 <= slots.top_log2; ++log2) slots.layers[log2] = 4;
        scene.renderer =
            gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack,
                                 {.vertices = 1u << 16, .indices = 1u << 18, .splat = slots, .light = scene.light});
        return slots;
    }
    void set() { scene.renderer->set_layers(file.materials, {}, names); }
    [[nodiscard]] View above() const {
        View view = scene.camera(0.5, 0.5, 1800, 0, -86);
        view.width_px = splat_wide;
        view.height_px = splat_high;
        return view;
    }
    Picture draw(const gl::LayerSettings& layers) {
        return scene.draw(mesh.view(), above(), {.haze = false, .layers = layers});
    }
    // From the file, as a stream brings them: the tail, or one mip.
    void send(std::uint32_t tile, std::uint8_t log2, std::uint8_t from) {
        std::vector<std::byte> blocks;
        const std::uint32_t top = scene.loaded.pack.header.splat_log2;
        std::uint8_t mips = 0;
        for (std::uint32_t size = log2; size >= (from == 0 ? 2u : log2); --size, ++mips) {
            const ChunkId id{ChunkKind::splat, tile, top - size};
            std::vector<std::byte> mip(chunk_raw_bytes(scene.loaded.pack.header, id));
            REQUIRE(read_chunk(scene.loaded.pack, id, mip).ok());
            blocks.insert(blocks.end(), mip.begin(), mip.end());
        }
        const MapCommand command{MapKind::splat, log2, from, mips, tile, tile, tile, blocks};
        scene.renderer->upload(std::span(&command, 1));
    }
    void show(std::uint8_t log2, float min_lod) {
        const std::vector<TileMap> maps{{0, log2, min_lod}, {1, log2, min_lod}, {2, log2, min_lod}, {3, log2, min_lod}};
        scene.renderer->show_maps({}, {}, {}, maps);
    }
};

double mean_difference(const gl::Image& a, const gl::Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::abs(a.rgb[i] - b.rgb[i]);
    return sum / static_cast<double>(a.rgb.size());
}

constexpr const char* halves = R"({"rules": [{"layer": "green"}, {"layer": "red", "height_m": [64, null]}]})";
constexpr const char* patches =
    R"({"rules": [{"layer": "green"}, {"layer": "red", "noise": [0.5, 1], "noise_m": 250, "fine": 0}]})";

} // namespace

TEST_CASE("ground shows the materials that its splat map says, and colours alone where it says none", "[picture]") {
    SplatScene c(halves);
    const Picture without = c.draw({});
    c.set();
    CHECK(c.draw({}).colour.rgb == without.colour.rgb);
    const Picture with = c.draw(c.on);
    // North is up: green in the west, red in the east, and between them no more than a few texels of 32 m.
    std::size_t red = 0, green = 0;
    for (std::uint32_t y = splat_high / 4; y < splat_high * 3 / 4; ++y)
        for (std::uint32_t x = 0; x < splat_wide; ++x) {
            if (std::isinf(with.distance_m[std::size_t{y} * splat_wide + x])) continue;
            const double along = with.distance_m[std::size_t{y} * splat_wide + x];
            const View view = c.above();
            const double east = (view.left + (view.right - view.left) * (x + 0.5) / splat_wide) * along;
            if (std::abs(east) < 90) continue;
            const auto* const rgb = with.colour.pixel(x, y);
            CAPTURE(x, y, east, int{rgb[0]}, int{rgb[1]});
            REQUIRE((east < 0) == (rgb[1] > rgb[0]));
            REQUIRE(std::max(rgb[0], rgb[1]) > 3 * std::min(rgb[0], rgb[1]) / 2);
            (east < 0 ? green : red)++;
        }
    CHECK(green > 500);
    CHECK(red > 500);
    gl::LayerSettings off = c.on;
    off.splat = false; // and there are no rules
    CHECK(c.draw(off).colour.rgb == without.colour.rgb);
    const std::vector<std::string> unknown{"green", "moss"};
    CHECK_THROWS_WITH(
        c.scene.renderer->set_layers(c.file.materials, {}, unknown),
        "the pack's splat maps speak of \"moss\", and the materials are red, green: give materials with it, or bake "
        "the pack with other --layers");

    SplatScene bare(
        R"({"rules": [{"layer": "green", "height_m": [null, 32]}, {"layer": "red", "height_m": [96, null]}]})");
    const Picture plain = bare.draw({});
    bare.set();
    const Picture some = bare.draw(bare.on);
    for (const std::uint32_t y : {splat_high / 3, splat_high / 2})
        CHECK(std::equal(plain.colour.pixel(splat_wide / 2, y), plain.colour.pixel(splat_wide / 2, y) + 3,
                         some.colour.pixel(splat_wide / 2, y)));
    CHECK(mean_difference(plain.colour, some.colour) > 1);
}

TEST_CASE("water in a splat map is a lake near and far, and needs no material", "[picture]") {
    SplatScene c(R"({"rules": [{"layer": "green"}, {"layer": "water", "height_m": [64, null]}]})");
    const Picture without = c.draw({});
    const std::vector<std::string> names{"green", "water"};
    c.scene.renderer->set_layers(c.file.materials, {}, names);
    const Picture near = c.draw(c.on);
    gl::LayerSettings away = c.on;
    away.distance_m = 1; // materials end there, and lakes do not
    const Picture far = c.draw(away);
    const View view = c.above();
    std::size_t lake = 0, land = 0;
    for (std::uint32_t y = splat_high / 4; y < splat_high * 3 / 4; ++y)
        for (std::uint32_t x = 0; x < splat_wide; ++x) {
            const double along = near.distance_m[std::size_t{y} * splat_wide + x];
            const double east = (view.left + (view.right - view.left) * (x + 0.5) / splat_wide) * along;
            if (std::isinf(along) || std::abs(east) < 90) continue;
            const auto *const rgb = near.colour.pixel(x, y), *const rgb_far = far.colour.pixel(x, y),
                              *const bare = without.colour.pixel(x, y);
            CAPTURE(x, y, east, int{rgb[0]}, int{rgb[1]}, int{rgb[2]}, int{rgb_far[0]}, int{bare[0]});
            if (east > 0) {
                REQUIRE(rgb[2] > rgb[0]); // of the sky, where ground is brown or green
                REQUIRE(std::equal(rgb, rgb + 3, rgb_far, [](int a, int b) { return std::abs(a - b) <= 2; }));
                ++lake;
            } else {
                REQUIRE(rgb[1] > rgb[2]);
                REQUIRE(std::equal(bare, bare + 3, rgb_far));
                ++land;
            }
        }
    CHECK(lake > 500);
    CHECK(land > 500);
}

TEST_CASE("a splat map that streams in shows nothing before, changes nothing when a finer mip comes, and fades to it",
          "[picture]") {
    SplatScene c(patches);
    c.set();
    const Picture whole = c.draw(c.on);
    const auto top = static_cast<std::uint8_t>(c.stream_splat().top_log2);
    REQUIRE(top > splat_tail);
    c.set();
    const Picture without = c.draw({});
    CHECK(c.draw(c.on).colour.rgb == without.colour.rgb);
    for (std::uint32_t tile = 0; tile < 4; ++tile) c.send(tile, splat_tail, 0);
    const float coarsest = static_cast<float>(top - splat_tail);
    c.show(splat_tail, coarsest);
    const Picture coarse = c.draw(c.on);
    CHECK(mean_difference(coarse.colour, without.colour) > 1);
    for (std::uint8_t log2 = splat_tail + 1; log2 <= top; ++log2)
        for (std::uint32_t tile = 0; tile < 4; ++tile) c.send(tile, log2, static_cast<std::uint8_t>(log2 - 1));
    c.show(top, coarsest);
    Picture before = c.draw(c.on);
    CHECK(before.colour.rgb == coarse.colour.rgb);
    const double all = mean_difference(coarse.colour, whole.colour);
    CHECK(all > 1);
    for (int step = 1; step <= 16; ++step) {
        c.show(top, coarsest * static_cast<float>(16 - step) / 16);
        Picture now = c.draw(c.on);
        CAPTURE(step, all);
        CHECK(mean_difference(now.colour, before.colour) < all / 4);
        before = std::move(now);
    }
    CHECK(mean_difference(before.colour, whole.colour) < 0.02); // mips of pixels, not bits of the map
}
