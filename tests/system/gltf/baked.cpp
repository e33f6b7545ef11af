#include "gltf/baked.h"
#include "shared/terrain_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>

#include <sys/wait.h>
#include <unistd.h>

namespace fjell::test {

namespace fs = std::filesystem;

namespace {

// A hash, not a generator of the library's: the same hills everywhere.
double noise(std::int32_t x, std::int32_t y) {
    auto h = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca77u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (h ^ h >> 15) / 4294967296.0 - 0.5;
}

} // namespace

BakedTerrain::BakedTerrain(const Folder& folder, const baker::Dem& dem, const baker::BakeOptions& options) {
    baker::bake(dem, options, folder / "terrain.fjell");
    loaded = io::load_pack(folder / "terrain.fjell", io::LoadTerrain::yes);
    std::vector<float> heights = dem.heights_m;
    for (std::size_t i = 0; i < dem.voids.size(); ++i)
        if (dem.voids[i] != 0) heights[i] = std::numeric_limits<float>::quiet_NaN();
    std::ofstream raw(folder / "heights.f32", std::ios::binary);
    raw.write(reinterpret_cast<const char*>(heights.data()),
              static_cast<std::streamsize>(heights.size() * sizeof(float)));
    heights_argument =
        " --heights '" + folder / "heights.f32" + "' " + std::to_string(dem.columns) + " " + std::to_string(dem.rows);
}

baker::Dem hills(std::int32_t columns, std::int32_t rows, double spacing_x_m, double spacing_z_m) {
    baker::Dem dem;
    dem.columns = columns;
    dem.rows = rows;
    dem.spacing_m[0] = spacing_x_m;
    dem.spacing_m[1] = spacing_z_m;
    dem.crs_origin[0] = 431234.56789;
    dem.crs_origin[1] = 6823456.7891;
    dem.crs_wkt = "LOCAL_CS[\"Bl\xc3\xa5 fjell \\ \xe2\x80\x9ctest\xe2\x80\x9d\",UNIT[\"metre\",1]]";
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x) {
            const double u = x / 37.0, v = y / 29.0, ridge = 1 - std::abs(std::sin(u * 0.7 + v * 0.4));
            const double height = 1200 + 300 * std::sin(u) * std::cos(v) + 400 * ridge * ridge + 30 * noise(x, y);
            dem.heights_m.push_back(static_cast<float>(std::max(height, 1100.0)));
        }
    return dem;
}

View view_of(const Terrain& terrain) {
    const double width = (data_of(terrain).tree.columns() - 1) * terrain.header().spacing_m[0];
    const double depth = (data_of(terrain).tree.rows() - 1) * terrain.header().spacing_m[1];
    const Vec3 eye{0.4 * width, terrain.header().max_m + 0.03 * width, 0.97 * depth};
    return make_view(eye, {0.3, -0.4, -1}, {0, 1, 0}, 0.8, 1280, 720, 1, 4 * (width + depth));
}

NodeResult node(const std::string& script, const std::string& arguments) {
    const std::string folder = FJELL_GLTF_SCRIPTS;
    if (!fs::exists(folder + "/node_modules/gltf-validator"))
        return {-1,
                "npm packages are missing in " + folder + ": run the tests through ctest, whose fixture installs them"};
    std::FILE* pipe = popen(("node '" + folder + "/" + script + "' " + arguments + " 2>&1").c_str(), "r");
    if (!pipe) return {-1, "cannot start node: ./dev installs the Debian packages nodejs and npm"};
    NodeResult result{0, {}};
    std::array<char, 4096> buffer;
    while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
        result.output.append(buffer.data(), n);
    const int status = pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

} // namespace fjell::test
