// Detail layers in pictures.
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "baker/materials/encode.h"
#include "fjell/gl/ground_colour.h"
#include "picture_scene.h"

using namespace pictures;

namespace {

constexpr std::uint32_t layered_wide = 160, layered_high = 120;

// One colour, no relief.
baker::MaterialRecipe plain(const std::string& name, float r, float g, float b) {
    baker::MaterialRecipe m;
    m.name = name;
    m.base = {r, g, b};
    return m;
}

baker::MaterialRecipe pebbles() {
    baker::MaterialRecipe m = plain("pebbles", 0.2f, 0.2f, 0.2f);
    baker::MaterialStep stones;
    stones.draw = baker::Draw::stones;
    stones.count = 300;
    stones.opacity = 1;
    stones.rgb = {0.1f, 0.1f, 0.1f, 0.5f, 0.5f, 0.4f};
    m.steps.push_back(stones);
    return m;
}

struct MaterialFile {
    std::vector<std::byte> bytes;
    io::Materials materials;
    explicit MaterialFile(const std::vector<baker::MaterialRecipe>& recipes, std::uint32_t side = 16) {
        std::vector<baker::MaterialTexels> texels;
        for (const baker::MaterialRecipe& recipe : recipes) texels.push_back(baker::make_material(recipe, side));
        bytes = io::materials_file(baker::encode_materials(texels).materials);
        materials = io::open_materials(bytes, "test");
    }
};

// Ground that rises evenly to the east.
baker::Dem slope(int samples, double spacing_m, double rise) {
    baker::Dem dem;
    dem.columns = dem.rows = samples;
    dem.spacing_m[0] = dem.spacing_m[1] = spacing_m;
    for (int y = 0; y < samples; ++y)
        for (int x = 0; x < samples; ++x) dem.heights_m.push_back(static_cast<float>(x * spacing_m * rise));
    return dem;
}

struct Layered {
    Scene scene;
    OwnMesh mesh;
    explicit Layered(baker::Dem dem) : scene(std::move(dem), 6), mesh(full_resolution(scene.loaded.terrain)) {
        scene.target = gl::Target::create({layered_wide, layered_high, 1});
        scene.light.exposure = gl::Exposure::fixed;
        scene.light.tone_curve = gl::ToneCurve::none;
        scene.light.ev100 = 14;
    }
    void set(const MaterialFile& file, std::span<const gl::LayerRule> rules) {
        scene.renderer->set_layers(file.materials, rules);
    }
    [[nodiscard]] View camera(double east, double south, double above_m, double heading_deg, double pitch_deg) const {
        View view = scene.camera(east, south, above_m, heading_deg, pitch_deg);
        view.width_px = layered_wide;
        view.height_px = layered_high;
        return view;
    }
    Picture draw(const View& view, const gl::LayerSettings& layers) {
        return scene.draw(mesh.view(), view, {.haze = false, .layers = layers});
    }
};

// In metres from the eye, as shaders measure it.
double metres_to(const Picture& picture, const View& view, std::uint32_t x, std::uint32_t y, Vec3& to) {
    const double u = view.left + (view.right - view.left) * (x + 0.5) / layered_wide;
    const double v = view.top + (view.bottom - view.top) * (y + 0.5) / layered_high;
    to = view.forward + cross(view.forward, view.up) * u + view.up * v;
    const double length = std::sqrt(dot(to, to));
    const double along = static_cast<double>(picture.distance_m[std::size_t{y} * layered_wide + x]);
    to = to * along;
    return along * length;
}

} // namespace

TEST_CASE("layers change near ground, and from their distance on no bit of the picture", "[picture]") {
    Layered l(pictures::mountains(129));
    const MaterialFile file({pebbles(), plain("red", 0.5f, 0.1f, 0.1f)});
    const std::array rules{gl::LayerRule{}, gl::LayerRule{.material = 1, .slope_deg = {30, 90}, .slope_soft_deg = 10}};
    const View view = l.camera(0.5, 0.5, 20, 30, -12);
    for (const bool detail : {false, true}) {
        l.scene.light.detail = detail;
        const Picture without = l.draw(view, {});
        // On, but with nothing to draw: the same shaders, the same picture.
        l.scene.renderer->set_layers({}, {});
        CHECK(l.draw(view, {.on = true}).colour.rgb == without.colour.rgb);
        l.set(file, rules);
        CHECK(l.draw(view, {}).colour.rgb == without.colour.rgb);
        const gl::LayerSettings settings{.on = true, .distance_m = 500};
        const Picture with = l.draw(view, settings);
        std::size_t near = 0, changed = 0, far = 0, far_changed = 0;
        for (std::uint32_t y = 0; y < layered_high; ++y)
            for (std::uint32_t x = 0; x < layered_wide; ++x) {
                Vec3 to;
                const double metres = metres_to(with, view, x, y, to);
                const bool differs = std::memcmp(with.colour.pixel(x, y), without.colour.pixel(x, y), 3) != 0;
                if (metres < 0.4 * settings.distance_m) ++near, changed += differs;
                if (metres > 1.0001 * settings.distance_m) ++far, far_changed += differs; // the sky too
            }
        CHECK(near > 500);
        CHECK(changed > near * 9 / 10);
        CHECK(far > 1000);
        CHECK(far_changed == 0);
    }
}

TEST_CASE("shaders lay rules as layer_shares() does", "[picture]") {
    constexpr double degrees = 25;
    Layered l(slope(65, 16, std::tan(degrees * pi / 180)));
    const std::vector<std::array<float, 3>> colours{{0.5f, 0.1f, 0.1f}, {0.1f, 0.5f, 0.1f}, {0.1f, 0.1f, 0.5f}};
    std::vector<baker::MaterialRecipe> recipes{plain("white", 0.5f, 0.5f, 0.5f)};
    for (std::size_t i = 0; i < 3; ++i)
        recipes.push_back(
            plain(std::string("colour") + static_cast<char>('0' + i), colours[i][0], colours[i][1], colours[i][2]));
    const MaterialFile file(recipes);
    // Two thirds of the way into the second by slope, and along the view all of the third by height.
    const std::array rules{gl::LayerRule{.material = 1},
                           gl::LayerRule{.material = 2, .slope_deg = {26.5, 90}, .slope_soft_deg = 9, .ragged = 0},
                           gl::LayerRule{.material = 3, .height_m = {240, 300}, .height_soft_m = 60, .ragged = 0}};
    const View view = l.camera(0.3, 0.5, 60, 90, -10);
    const gl::LayerSettings settings{.on = true, .distance_m = 100'000, .tint = 0};
    const std::array white{gl::LayerRule{}};
    l.set(file, white);
    const Picture reference = l.draw(view, settings);
    l.set(file, rules);
    const Picture picture = l.draw(view, settings);
    std::size_t compared = 0;
    double worst = 0;
    for (std::uint32_t y = 0; y < layered_high; y += 3)
        for (std::uint32_t x = 0; x < layered_wide; x += 3) {
            Vec3 to;
            const double metres = metres_to(reference, view, x, y, to);
            if (!(metres < 1000)) continue;
            std::array<double, 3> shares{};
            gl::layer_shares(rules, view.eye_m.y + to.y, degrees, 0.5, 0.5, shares);
            // Without relief what shows most covers what shows 0.15 less, from 160 m on 0.6.
            const double far = std::clamp((metres / 160 - 0.3) / 0.7, 0.0, 1.0),
                         covers = 0.15 + 0.45 * far * far * (3 - 2 * far);
            const double top = *std::max_element(shares.begin(), shares.end());
            double all = 0, rgb[3] = {};
            for (std::size_t i = 0; i < 3; ++i) {
                const double weight = shares[i] < 0.12 ? 0 : std::max(shares[i] - (top - covers), 0.0);
                all += weight;
                for (std::size_t c = 0; c < 3; ++c) rgb[c] += weight * static_cast<double>(colours[i][c]);
            }
            // At these a thousandth of a share more or less is another picture.
            bool on_edge = false;
            for (const double share : shares) on_edge = on_edge || std::abs(share - 0.12) < 0.03;
            if (on_edge) continue;
            ++compared;
            for (std::size_t c = 0; c < 3; ++c) {
                const double white_light = linear(reference.colour.pixel(x, y)[c]);
                const double drawn = 0.5 * linear(picture.colour.pixel(x, y)[c]) / white_light;
                worst = std::max(worst, std::abs(drawn - rgb[c] / all));
            }
        }
    CHECK(compared > 300);
    // A share is off by 0.03: the normal map's codes are 1/127 apart, 0.25 degrees of the 9. Over the 0.15 in which one
    // goes over into the other that is a fifth of the way between two colours 0.4 apart; BC1 and 8 bits add 0.02.
    CHECK(worst < 0.1);
}

TEST_CASE("ground is painted for exports as shaders draw it", "[picture]") {
    Layered l(slope(65, 16, 0));
    const MaterialFile file({plain("white", 0.5f, 0.5f, 0.5f), pebbles(), plain("red", 0.5f, 0.1f, 0.1f)}, 64);
    // Pebbles, with red over half of them: where noise says, in patches and spots.
    const std::array rules{gl::LayerRule{.material = 1},
                           gl::LayerRule{.material = 2, .noise = {0.5, 1}, .noise_soft = 0.3, .fine = 0.5}};
    const View view = l.camera(0.4, 0.6, 60, 30, -80);
    const gl::LayerSettings settings{.on = true, .distance_m = 100'000, .tint = 0, .relief = 0};
    const std::array white{gl::LayerRule{}};
    l.set(file, white);
    const Picture reference = l.draw(view, settings);
    l.set(file, rules);
    const Picture picture = l.draw(view, settings);
    const double pixel_m = 60 * (view.top - view.bottom) / layered_high;
    gl::GroundColour painter;
    painter.set(file.materials, rules, {}, settings, pixel_m);

    // Mips are chosen a little differently, so squares of pixels are compared.
    constexpr std::uint32_t square = 8;
    double apart = 0, spread = 0;
    int squares = 0;
    for (std::uint32_t top = 0; top < layered_high; top += square)
        for (std::uint32_t left = 0; left < layered_wide; left += square) {
            double drawn[3] = {}, painted[3] = {};
            for (std::uint32_t y = top; y < top + square; ++y)
                for (std::uint32_t x = left; x < left + square; ++x) {
                    Vec3 to;
                    (void)metres_to(picture, view, x, y, to);
                    std::array<std::uint8_t, 12> rgb{};
                    const std::array<float, 4> level{};
                    REQUIRE(painter.paint(
                        {2, view.eye_m.x + to.x, view.eye_m.z + to.z, pixel_m, pixel_m, {}, 0, level, level, rgb}));
                    for (std::size_t c = 0; c < 3; ++c) {
                        drawn[c] += 0.5 * linear(picture.colour.pixel(x, y)[c]) /
                                    linear(reference.colour.pixel(x, y)[c]) / (square * square);
                        painted[c] += linear(rgb[c]) / (square * square);
                    }
                }
            for (std::size_t c = 0; c < 3; ++c) apart += std::abs(drawn[c] - painted[c]) / 3;
            spread += std::abs(drawn[0] - 0.35); // between pebbles and red
            ++squares;
        }
    CHECK(apart / squares < 0.008);
    CHECK(spread / squares > 0.06); // there was something to get wrong
}

TEST_CASE("materials lie as still 30 km from the origin as beside it", "[picture]") {
    Layered l(slope(257, 128, 0));
    const MaterialFile file({pebbles()}, 64);
    const std::array rules{gl::LayerRule{}};
    l.set(file, rules);
    const double extent_m = 128 * 256;
    // Textures and noise are back at their beginning after 1024 m.
    const View here = l.camera((1024 + 300.3) / extent_m, 0.5, 2, 20, -20);
    const View there = l.camera((28 * 1024 + 300.3) / extent_m, 0.5, 2, 20, -20);
    const gl::LayerSettings settings{.on = true, .tint = 0};
    const Picture a = l.draw(here, settings), b = l.draw(there, settings);
    std::size_t apart = 0, ground = 0;
    for (std::size_t i = 0; i < a.colour.rgb.size(); ++i) {
        ground += a.depth[i / 3] > 0;
        apart += std::abs(a.colour.rgb[i] - b.colour.rgb[i]) > 3;
    }
    CHECK(ground > a.colour.rgb.size() / 2);
    CHECK(apart < ground / 200);
}

TEST_CASE("textures of materials count as memory, and stay in their budget", "[picture]") {
    Layered l(slope(17, 16, 0.2));
    const MaterialFile file({pebbles(), plain("red", 0.5f, 0.1f, 0.1f)}, 64);
    const std::array rules{gl::LayerRule{}};
    const std::uint64_t before = l.scene.renderer->stats().texture_bytes;
    l.set(file, rules);
    const std::uint64_t with = l.scene.renderer->stats().texture_bytes - before;
    // Two materials, 64 texels a side down to 4: 2 bytes a texel as blocks, 6 where a driver without a GPU gets texels.
    const std::uint64_t texels = 2 * (64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4);
    CHECK((with == 2 * texels || with == 6 * texels));
    l.scene.renderer->set_layers({}, {});
    CHECK(l.scene.renderer->stats().texture_bytes == before);

    const auto few = gl::Renderer::create(l.scene.loaded.terrain, l.scene.loaded.pack,
                                          {.vertices = 16, .indices = 16, .material_bytes = with / 3});
    few->set_layers(file.materials, rules);
    CHECK(few->stats().texture_bytes > before);
    CHECK(few->stats().texture_bytes <= before + with / 3);
    const std::array bad{gl::LayerRule{.material = 2}};
    CHECK_THROWS_WITH(few->set_layers(file.materials, bad), "rule 0: material must be one of the materials");
}
