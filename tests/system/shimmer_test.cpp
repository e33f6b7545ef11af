// Shimmering: what a picture does from frame to frame of a slow flight that many more samples a pixel would not do.
//
// Of each pixel the second difference over three frames, in linear light: a place that moves on evenly has next to
// none, one that flickers has much. Its energy in pictures of one sample a pixel, over that in pictures of 16, is 1
// where nothing aliases beyond what the frame's grid does by itself. Prints the figures that docs/notes/renderer.md
// has.
#include <cstdio>
#include <span>
#include <vector>

#include "baker/materials/encode.h"
#include "picture_scene.h"

using namespace pictures;

namespace {

constexpr std::uint32_t still_wide = 96, still_high = 72, across = 4; // samples a pixel: across x across

struct Flight {
    Scene scene{pictures::mountains(129), 6, PageOrder::planar, 2};
    OwnMesh mesh = full_resolution(scene.loaded.terrain);

    // Linear light of a frame's pixels; 3 a pixel. finer: averaged over so many pixels each way.
    std::vector<float> frame(const View& view, const gl::DrawOptions& options, std::uint32_t finer) {
        View now = view;
        now.width_px = still_wide * finer, now.height_px = still_high * finer;
        const gl::Image image = scene.draw(mesh.view(), now, options).colour;
        std::vector<float> light(std::size_t{still_wide} * still_high * 3);
        for (std::uint32_t y = 0; y < image.height; ++y)
            for (std::uint32_t x = 0; x < image.width; ++x)
                for (std::size_t c = 0; c < 3; ++c)
                    light[(std::size_t{y / finer} * still_wide + x / finer) * 3 + c] +=
                        table[image.pixel(x, y)[c]] / static_cast<float>(finer * finer);
        return light;
    }

    // Of all pixels the share, in percent, that differ by more than 24 of 255 from the same place in a picture whose
    // camera is turned by one pixel.
    double pan_percent(View view, const gl::DrawOptions& options) {
        constexpr std::uint32_t pan_wide = 320, pan_high = 180;
        scene.target = gl::Target::create({pan_wide, pan_high, 1});
        view.width_px = pan_wide, view.height_px = pan_high;
        view.right = view.top * pan_wide / pan_high, view.left = -view.right;
        const gl::Image first = scene.draw(mesh.view(), view, options).colour;
        const double turn = (view.right - view.left) / pan_wide;
        const Vec3 right = cross(view.forward, view.up);
        view.forward = view.forward * std::cos(turn) + right * std::sin(turn);
        const gl::Image second = scene.draw(mesh.view(), view, options).colour;
        std::size_t changed = 0;
        for (std::uint32_t y = 0; y < pan_high; ++y)
            for (std::uint32_t x = 1; x < pan_wide; ++x) {
                int most = 0;
                for (std::size_t c = 0; c < 3; ++c)
                    most = std::max(most, std::abs(first.pixel(x, y)[c] - second.pixel(x - 1, y)[c]));
                changed += most > 24;
            }
        return 100.0 * static_cast<double>(changed) / (pan_high * (pan_wide - 1));
    }

    // Mean square of the second difference over time, less what rounding to 8 bits adds: of each code the variance is a
    // twelfth of its step squared, and the second difference has weights 1, -2, 1.
    double flicker(const gl::DrawOptions& options, std::uint32_t finer, int frames) {
        scene.target = gl::Target::create({still_wide * finer, still_high * finer, 1});
        std::vector<float> last, before;
        double sum = 0, rounding = 0;
        std::size_t count = 0;
        for (int i = 0; i < frames; ++i) {
            // 40 m over the ground: half a pixel a frame in the middle of the picture.
            View view = scene.camera(0.4, 0.6, 40, 30, -14);
            view.eye_m = view.eye_m + view.forward * (0.9 * i);
            std::vector<float> now = frame(view, options, finer);
            // Below the outlines of hills, which alias whatever covers them.
            for (std::size_t k = now.size() / 2; i >= 2 && k < now.size(); ++k, ++count) {
                const double second =
                    static_cast<double>(now[k]) - 2 * static_cast<double>(last[k]) + static_cast<double>(before[k]);
                sum += second * second;
                const double code = 255 * (1.055 * std::pow(static_cast<double>(now[k]), 1 / 2.4) - 0.055);
                const double step = linear(code + 0.5) - linear(code - 0.5);
                rounding += 6 * step * step / 12 / (finer * finer);
            }
            before = std::move(last);
            last = std::move(now);
        }
        return (sum - rounding) / static_cast<double>(count);
    }

    std::vector<float> table = [] {
        std::vector<float> light;
        for (int code = 0; code < 256; ++code) light.push_back(static_cast<float>(linear(code)));
        return light;
    }();
};

} // namespace

TEST_CASE("a slow flight shimmers hardly more than pictures of 16 samples a pixel do", "[picture]") {
    Flight flight;
    flight.scene.light = {.azimuth_deg = 250, .elevation_deg = 30, .tone_curve = gl::ToneCurve::none, .dither = false};
    constexpr int frames = 30; // of fewer, what is 1.93 times may be 2.03
    const double drawn = flight.flicker({}, 1, frames), wanted = flight.flicker({}, across, frames);
    std::printf("shimmer with detail and shadows: %.3g, of 16 samples a pixel %.3g: %.2f times\n", drawn, wanted,
                drawn / wanted);
    CHECK(drawn < 2 * wanted);

    // Stones all over, whose fine texture is there up to 160 m.
    baker::MaterialRecipe stones;
    stones.name = "stones";
    stones.base = {0.2f, 0.2f, 0.2f};
    baker::MaterialStep step;
    step.draw = baker::Draw::stones;
    step.count = 300;
    step.opacity = 1;
    step.rgb = {0.1f, 0.1f, 0.1f, 0.5f, 0.5f, 0.4f};
    stones.steps.push_back(step);
    const std::vector<baker::MaterialTexels> texels{baker::make_material(stones, 64)};
    const std::vector<std::byte> file = io::materials_file(baker::encode_materials(texels).materials);
    const std::vector<gl::LayerRule> rules{{}};
    flight.scene.renderer->set_layers(io::open_materials(file, "stones"), rules);
    const gl::DrawOptions layered{.layers = {.on = true}};
    const double stones_drawn = flight.flicker(layered, 1, frames),
                 stones_wanted = flight.flicker(layered, across, frames);
    std::printf("shimmer with a layer of stones too: %.3g, of 16 samples a pixel %.3g: %.2f times\n", stones_drawn,
                stones_wanted, stones_drawn / stones_wanted);
    CHECK(stones_drawn < 2 * stones_wanted);

    // The same ground, from near above it and grazing, turned by a pixel; as films have it.
    flight.scene.light.tone_curve = gl::ToneCurve::filmic;
    for (const gl::DrawOptions& options : {gl::DrawOptions{}, layered})
        for (const auto& [above_m, pitch_deg] :
             {std::pair{2.0, -4.0}, std::pair{25.0, -12.0}, std::pair{400.0, -30.0}}) {
            const double changed = flight.pan_percent(flight.scene.camera(0.4, 0.6, above_m, 30, pitch_deg), options);
            std::printf("pan by a pixel, %g m over %s: %.2f%% of pixels change by more than 24\n", above_m,
                        options.layers.on ? "stones" : "bare ground", changed);
            CHECK(changed <= 0.5);
        }
}
