#include "support/terrain_fixture.h"
#include "shared/terrain_data.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <unistd.h>

namespace fjell::test {

double uniform(Random& random, double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
}
int pick(Random& random, int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random);
}

namespace {

// Sum of random value-noise octaves, coarse to fine.
float fractal(Random& random, std::vector<float>& height_scale, double x, double y) {
    constexpr int side = 32;
    if (height_scale.empty())
        for (int i = 0; i < side * side; ++i) height_scale.push_back(static_cast<float>(uniform(random, -1, 1)));
    double sum = 0, size = 1, frequency = 1.0 / 64;
    for (int octave = 0; octave < 6; ++octave, size *= 0.5, frequency *= 2) {
        const double u = x * frequency + octave * 7.3, v = y * frequency + octave * 3.1;
        const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
        const auto at = [&](int a, int b) {
            return height_scale[static_cast<std::size_t>((b & 31) * side + (a & 31))];
        };
        const double s = u - i, t = v - j;
        sum += size * ((at(i, j) * (1 - s) + at(i + 1, j) * s) * (1 - t) +
                       (at(i, j + 1) * (1 - s) + at(i + 1, j + 1) * s) * t);
    }
    return static_cast<float>(sum);
}

} // namespace

baker::Dem random_dem(Random& random, std::int32_t columns, std::int32_t rows, Shape shape) {
    baker::Dem dem;
    dem.columns = columns;
    dem.rows = rows;
    const double spacing = std::pow(10.0, uniform(random, -1, 3));
    dem.spacing_m[0] = spacing;
    dem.spacing_m[1] = pick(random, 0, 1) ? spacing : spacing * uniform(random, 0.5, 2);
    const double relief = spacing * std::pow(10.0, uniform(random, -1, 1.5)), base = uniform(random, -4000, 4000);
    std::vector<float> height_scale;
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x) {
            double h = 0;
            switch (shape) {
            case Shape::fractal: h = fractal(random, height_scale, x, y) * 4; break;
            case Shape::noise: h = uniform(random, -1, 1); break;
            case Shape::spikes: h = pick(random, 0, 60) == 0 ? uniform(random, -3, 3) : 0; break;
            case Shape::steps: h = ((x / 5) + (y / 7)) % 3; break;
            case Shape::ramp: h = 0.3 * x - 0.2 * y; break;
            case Shape::flat:
            case Shape::count: break;
            }
            dem.heights_m.push_back(static_cast<float>(base + relief * h));
        }
    return dem;
}

void add_random_holes(Random& random, baker::Dem& dem, int tile_log2) {
    dem.voids.assign(dem.heights_m.size(), 0);
    const auto disc = [&](double x, double y, double inner, double outer, std::uint8_t what) {
        for (std::int32_t j = 0; j < dem.rows; ++j)
            for (std::int32_t i = 0; i < dem.columns; ++i) {
                const double d = std::hypot(i - x, j - y);
                if (d >= inner && d <= outer) dem.voids[dem.index(i, j)] = what;
            }
    };
    const double x = uniform(random, 0, dem.columns), y = uniform(random, 0, dem.rows),
                 size = uniform(random, 0.5, std::max(dem.columns, dem.rows));
    switch (pick(random, 0, 5)) {
    case 0: // single samples
        for (int n = pick(random, 1, 8); n > 0; --n)
            dem.voids[dem.index(pick(random, 0, dem.columns - 1), pick(random, 0, dem.rows - 1))] = 1;
        break;
    case 1: disc(x, y, size / 2, size / 2 + uniform(random, 0.8, 4), 1); break; // a ring
    case 2:                                                                     // blobs
        for (int n = pick(random, 1, 5); n > 0; --n)
            disc(uniform(random, 0, dem.columns), uniform(random, 0, dem.rows), 0, size / 4, 1);
        break;
    case 3: { // a whole tile, and the samples around it or not
        const std::int32_t side = 1 << tile_log2, around = pick(random, 0, 1);
        const std::int32_t x0 = pick(random, 0, (dem.columns - 2) / side) * side,
                           y0 = pick(random, 0, (dem.rows - 2) / side) * side;
        for (std::int32_t j = std::max(y0 - around, 0); j <= std::min(y0 + side + around, dem.rows - 1); ++j)
            for (std::int32_t i = std::max(x0 - around, 0); i <= std::min(x0 + side + around, dem.columns - 1); ++i)
                dem.voids[dem.index(i, j)] = 1;
        break;
    }
    case 4: // everything but one sample, or a small disc
        dem.voids.assign(dem.voids.size(), 1);
        disc(std::floor(x), std::floor(y), 0, pick(random, 0, 1) ? 0.5 : size / 6, 0);
        break;
    case 5: // each by chance
        for (std::uint8_t& v : dem.voids) v = pick(random, 0, 2) == 0;
        break;
    }
    if (std::count(dem.voids.begin(), dem.voids.end(), std::uint8_t{0}) == 0)
        dem.voids[static_cast<std::size_t>(pick(random, 0, static_cast<int>(dem.voids.size()) - 1))] =
            0; // the last one
}

io::LoadedPack bake_and_load(baker::Dem dem, baker::BakeOptions options) {
    const TemporaryFolder folder;
    (void)baker::bake(std::move(dem), options, folder / "pack.fjell");
    return io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
}

baker::BakeOptions small_bake(int tile_log2, double nesting) {
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.nesting = nesting;
    options.threads = 1;
    options.max_texture_log2 = 2; // textures are not what these tests are about
    options.compression = 1;
    return options;
}

View random_view(Random& random, const Terrain& terrain) {
    const double wx = terrain.x_m(data_of(terrain).tree.columns() - 1),
                 wz = terrain.z_m(data_of(terrain).tree.rows() - 1);
    const double extent = std::max(wx, wz);
    Vec3 eye{uniform(random, -0.3, 1.3) * wx, 0, uniform(random, -0.3, 1.3) * wz};
    const double above = extent * std::pow(10.0, uniform(random, -4, 0.5));
    eye.y = data_of(terrain).ground_m(eye.x, eye.z) + (pick(random, 0, 9) == 0 ? -above : above);
    const Vec3 at{uniform(random, 0, 1) * wx, terrain.header().min_m, uniform(random, 0, 1) * wz};
    const double fov = uniform(random, 0.2, 2.0);
    return make_view(eye, at - eye, {uniform(random, -0.3, 0.3), 1, uniform(random, -0.3, 0.3)}, fov,
                     static_cast<std::uint32_t>(pick(random, 64, 3840)),
                     static_cast<std::uint32_t>(pick(random, 64, 2160)), extent * 1e-5, extent * 8);
}

RecursiveBudget ample_budget(const Terrain& terrain) {
    const std::uint32_t vertices = terrain.tile_count() * data_of(terrain).pages.tile_vertices();
    return {vertices, vertices * 8 + terrain.tile_count() * 16};
}

PagedTerrain::PagedTerrain(const Pack& pack, const TerrainBudget& budget)
    : memory(io::allocate(terrain_bytes(pack.header, budget))) {
    const Status s = create_terrain(pack, budget, {memory.get(), terrain_bytes(pack.header, budget)}, terrain);
    if (!s.ok()) throw std::runtime_error(std::string(s.field) + ": " + message(s.code));
}

Recursive::Recursive(const Terrain& terrain, const RecursiveBudget& budget)
    : memory(io::allocate(recursive_bytes(terrain, budget))) {
    const Status s = create_recursive(terrain, budget, {memory.get(), recursive_bytes(terrain, budget)}, method);
    if (!s.ok()) throw std::runtime_error(std::string(s.field) + ": " + message(s.code));
}

FrameReport Recursive::update(const View& view, const RefineSettings& settings) {
    FrameReport report;
    const Status s = update_recursive(method, view, settings, report);
    if (!s.ok()) throw std::runtime_error(std::string(s.field) + ": " + message(s.code));
    return report;
}

} // namespace fjell::test
