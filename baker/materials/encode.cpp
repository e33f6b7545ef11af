#include "baker/materials/encode.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <span>

#include <fmt/format.h>

#include "baker/check/picture.h"
#include "baker/maps/colour.h"
#include "baker/materials/canvas.h"
#include "baker/materials/images.h"
#include "baker/store/parallel.h"
#include "io/file.h"
#include "shared/block_codes.h"

namespace fjell::baker {

namespace {

constexpr int finer = 2; // drawn so many times finer, so that edges of blades are smooth

// Squares of `finer` texels become one.
std::vector<float> reduced(const std::vector<float>& from, int side, int channels, int by) {
    const int to = side / by;
    std::vector<float> out(from.size() / static_cast<std::size_t>(by * by));
    std::size_t i = 0;
    const float per = 1 / static_cast<float>(by * by);
    for (int y = 0; y < to; ++y)
        for (int x = 0; x < to; ++x)
            for (int c = 0; c < channels; ++c) {
                float sum = 0;
                for (int k = 0; k < by * by; ++k)
                    sum += from[static_cast<std::size_t>(((y * by + k / by) * side + x * by + k % by) * channels + c)];
                out[i++] = sum * per;
            }
    return out;
}

// What varies slowly would show where the texture repeats.
void flatten(const MaterialRecipe& recipe, Canvas& canvas) {
    const std::vector<float> ground = blurred(canvas.height, canvas.side, 1, canvas.side / 12);
    const std::vector<float> light = blurred(canvas.rgb, canvas.side, 3, canvas.side / 12);
    float mean[3] = {};
    for (std::size_t i = 0; i < light.size(); ++i) mean[i % 3] += light[i];
    for (float& m : mean) m = m * 3 / static_cast<float>(light.size());
    for (std::size_t i = 0; i < ground.size(); ++i) canvas.height[i] -= recipe.flatten * ground[i];
    for (std::size_t i = 0; i < light.size(); ++i)
        canvas.rgb[i] *= 1 + recipe.flatten * (mean[i % 3] / std::max(light[i], 1e-4f) - 1);
}

// Hollows see less of the sky: what lies below its surroundings of three sizes is darker, what rises above them a
// little lighter.
void darken_hollows(const MaterialRecipe& recipe, Canvas& canvas) {
    if (recipe.cavity <= 0) return;
    std::vector<float> light(canvas.height.size(), 1.0f);
    const float texel_m = canvas.size_m / static_cast<float>(canvas.side);
    for (const int radius : {2, 6, 18}) {
        const std::vector<float> around = blurred(canvas.height, canvas.side, 1, radius);
        const float per = 0.9f / (static_cast<float>(radius) * texel_m);
        for (std::size_t i = 0; i < light.size(); ++i) {
            const float deep = std::clamp((around[i] - canvas.height[i]) * per, -0.35f, 1.0f);
            light[i] *= 1 - 0.5f * recipe.cavity * deep;
        }
    }
    for (std::size_t i = 0; i < canvas.rgb.size(); ++i) canvas.rgb[i] *= std::clamp(light[i / 3], 0.1f, 1.5f);
}

// Heights become 0 to 1, but for the lowest and highest two in a thousand. Returns their metres.
float stretch_heights(std::vector<float>& height) {
    std::vector<float> sorted = height;
    const std::size_t cut = sorted.size() / 500;
    const auto nth = [&](std::size_t n) {
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n), sorted.end());
        return sorted[n];
    };
    const float low = nth(cut), relief = nth(sorted.size() - 1 - cut) - low;
    for (float& h : height) h = relief > 1e-6f ? std::clamp((h - low) / relief, 0.0f, 1.0f) : 0.5f;
    return std::max(relief, 0.0f);
}

// Of a surface that repeats, by central differences.
std::vector<float> normals_of(const Canvas& canvas, float bump) {
    std::vector<float> normal(2 * canvas.height.size());
    const float per = bump * 0.5f * static_cast<float>(canvas.side) / canvas.size_m;
    for (int y = 0; y < canvas.side; ++y)
        for (int x = 0; x < canvas.side; ++x) {
            const float dx = (canvas.height[canvas.at(x + 1, y)] - canvas.height[canvas.at(x - 1, y)]) * per;
            const float dy = (canvas.height[canvas.at(x, y + 1)] - canvas.height[canvas.at(x, y - 1)]) * per;
            const float length = 1 / std::sqrt(1 + dx * dx + dy * dy);
            const std::size_t i = canvas.at(x, y);
            normal[2 * i] = -dx * length;
            normal[2 * i + 1] = -dy * length;
        }
    return normal;
}

io::MaterialRecord record_of(const MaterialRecipe& recipe, const MaterialTexels& texels, float relief_m) {
    io::MaterialRecord r;
    std::memcpy(r.name, recipe.name.data(), recipe.name.size());
    r.size_m = recipe.size_m;
    r.relief_m = relief_m;
    r.coarse = recipe.coarse;
    r.coarse_share = recipe.coarse_share;
    double mean[3] = {};
    for (std::size_t i = 0; i < texels.rgb.size(); ++i) mean[i % 3] += static_cast<double>(texels.rgb[i]);
    for (std::size_t c = 0; c < 3; ++c)
        r.mean[c] = std::clamp(static_cast<float>(mean[c] * 3 / static_cast<double>(texels.rgb.size())), 0.0f, 1.0f);
    return r;
}

// --- compression
// ------------------------------------------------------------------------------------------------------

std::uint8_t byte_of(float value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 255.0f) + 0.5f);
}

// A mip's bytes, a plane a channel: red, green, blue, height, normal's u and v.
struct Planes {
    int side = 0;
    std::vector<std::uint8_t> of[6];
};

Planes planes_of(const MaterialTexels& t, int side) {
    Planes planes{side, {}};
    const std::uint8_t* const code = srgb_of_light();
    for (std::size_t i = 0; i < t.height.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c)
            planes.of[c].push_back(
                code[static_cast<std::size_t>(std::clamp(t.rgb[3 * i + c], 0.0f, 1.0f) * 65535 + 0.5f)]);
        planes.of[3].push_back(byte_of(255 * t.height[i]));
        for (std::size_t c = 0; c < 2; ++c) planes.of[4 + c].push_back(byte_of(128 + 127 * t.normal[2 * i + c]));
    }
    return planes;
}

// BC3 is BC1 behind one of BC5's halves.
void append_blocks(const Planes& planes, std::vector<std::byte>& colour, std::vector<std::byte>& normal) {
    const auto side = static_cast<std::size_t>(planes.side), blocks = side / 4;
    std::vector<std::byte> rgb(8 * blocks), height(16 * blocks), slopes(16 * blocks);
    for (std::size_t row = 0; row < side; row += 4) {
        ColourRows colours;
        NormalRows heights, normals;
        for (std::size_t y = 0; y < 4; ++y) {
            const std::size_t first = (row + y) * side;
            for (std::size_t c = 0; c < 3; ++c) colours.rows[y][c] = planes.of[c].data() + first;
            for (std::size_t c = 0; c < 2; ++c) {
                heights.rows[y][c] = planes.of[3].data() + first;
                normals.rows[y][c] = planes.of[4 + c].data() + first;
            }
        }
        encode_bc1(colours, blocks, rgb.data());
        encode_bc5(heights, blocks, height.data());
        encode_bc5(normals, blocks, slopes.data());
        for (std::size_t b = 0; b < blocks; ++b) {
            colour.insert(colour.end(), &height[16 * b], &height[16 * b] + 8);
            colour.insert(colour.end(), &rgb[8 * b], &rgb[8 * b] + 8);
        }
        normal.insert(normal.end(), slopes.begin(), slopes.end());
    }
}

void write_pictures(const MaterialTexels& t, const std::string& folder) {
    const Planes planes = planes_of(t, static_cast<int>(t.side));
    const auto write = [&](const char* what, const std::uint8_t(&from)[3]) {
        Picture picture;
        picture.width = picture.height = t.side;
        for (std::size_t i = 0; i < t.height.size(); ++i)
            for (const std::uint8_t plane : from)
                picture.rgb.push_back(plane < 6 ? planes.of[plane][i] : std::uint8_t{255});
        io::AtomicFile file(fmt::format("{}/{}-{}.png", folder, t.record.name, what));
        write_png(picture, file);
    };
    write("albedo", {0, 1, 2});
    write("height", {3, 3, 3});
    write("normal", {4, 5, 6});
}

} // namespace

MaterialTexels make_material(const MaterialRecipe& recipe, std::uint32_t side) {
    const int n = static_cast<int>(side);
    MaterialTexels t{side, {}, {}, {}, {}};
    Canvas canvas;
    if (recipe.albedo.empty()) {
        canvas = draw_material(recipe, finer * n);
        flatten(recipe, canvas);
        darken_hollows(recipe, canvas);
        canvas.height = reduced(canvas.height, canvas.side, 1, finer);
        canvas.rgb = reduced(canvas.rgb, canvas.side, 3, finer);
        canvas.side = n;
    } else {
        canvas = read_images(recipe, n, t.normal);
    }
    if (t.normal.empty()) t.normal = normals_of(canvas, recipe.bump);
    t.rgb = std::move(canvas.rgb);
    t.height = std::move(canvas.height);
    const float relief_m = stretch_heights(t.height);
    t.record = record_of(recipe, t, relief_m);
    return t;
}

EncodedMaterials encode_materials(const std::vector<MaterialTexels>& texels) {
    EncodedMaterials encoded;
    std::vector<MaterialTexels> mips = texels;
    for (const MaterialTexels& t : texels) encoded.materials.records.push_back(t.record);
    while ((1u << encoded.materials.side_log2) < texels.front().side) ++encoded.materials.side_log2;
    for (auto side = static_cast<int>(texels.front().side); side >= 4; side /= 2)
        for (MaterialTexels& t : mips) {
            append_blocks(planes_of(t, side), encoded.colour, encoded.normal);
            t.rgb = reduced(t.rgb, side, 3, 2);
            t.height = reduced(t.height, side, 1, 2);
            t.normal = reduced(t.normal, side, 2, 2);
        }
    encoded.materials.colour = encoded.colour;
    encoded.materials.normal = encoded.normal;
    return encoded;
}

void bake_materials(const std::string& recipes, std::uint32_t side, int threads, const std::string& output,
                    const std::string& pictures) {
    const std::vector<MaterialRecipe> all = read_materials(recipes);
    io::AtomicFile file(output); // before the work
    std::vector<MaterialTexels> texels(all.size());
    parallel_for(static_cast<std::int64_t>(all.size()), resolve_threads(threads), [&](std::int64_t i) {
        const auto at = static_cast<std::size_t>(i);
        texels[at] = make_material(all[at], side);
    });
    if (!pictures.empty())
        for (const MaterialTexels& t : texels) write_pictures(t, pictures);
    file.write(io::materials_file(encode_materials(texels).materials));
    file.commit();
}

} // namespace fjell::baker
