#include "baker/outlets/simulate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/outlets/height_files.h"
#include "baker/outlets/read_ground.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

class Folder {
public:
    Folder(const std::string& path, SimulateSummary& summary) : path_(path), summary_(summary) {
        std::filesystem::create_directories(path);
    }
    void write(const std::string& name, std::span<const std::byte> bytes) {
        io::AtomicFile file(path_ + "/" + name);
        file.write(bytes);
        file.commit();
        summary_.files.push_back(name);
    }
    void write(const std::string& name, const std::string& text) { write(name, std::as_bytes(std::span(text))); }

private:
    std::string path_;
    SimulateSummary& summary_;
};

// ---- terrain.obj

void write_mesh(const Ground& ground, const SimulateOptions& options, Folder& to, SimulateSummary& summary) {
    HeightMeshOptions wanted{{ground.spacing_m[0], ground.spacing_m[1]}, options.max_error_m};
    wanted.area = options.area, wanted.z_up = true, wanted.threads = options.threads;
    const HeightMesh mesh = mesh_heights(ground.array(), wanted);
    std::string text = "# Fjell: x east, y north, z up, metres\no terrain\n";
    for (const auto& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles)
        text += fmt::format("f {} {} {}\n", std::uint64_t{t[0]} + 1, std::uint64_t{t[1]} + 1, std::uint64_t{t[2]} + 1);
    to.write("terrain.obj", text);
    summary.vertices = mesh.vertices.size(), summary.triangles = mesh.triangles.size();
    summary.true_error_m = mesh.true_error_m, summary.area_error_m = mesh.area_error_m;
}

// ---- MuJoCo

// Where its diagonal is not ours, the surfaces differ most in the middle of the cell: by half of what its corners are
// off a plane. Both cut the cells whose north-western sample has an odd sum from south-west to north-east.
double diagonal_error_m(const Ground& g) {
    double worst = 0;
    for (std::int32_t y = 0; y + 1 < g.rows; ++y)
        for (std::int32_t x = y & 1; x + 1 < g.columns; x += 2) {
            const float *const north = g.row(y) + x, *const south = g.row(y + 1) + x;
            const double off = static_cast<double>(north[0]) + static_cast<double>(south[1]) -
                               static_cast<double>(north[1]) - static_cast<double>(south[0]);
            worst = std::max(worst, std::abs(off) / 2);
        }
    return worst;
}

void write_mujoco(const Ground& g, Folder& to, SimulateSummary& summary) {
    // It maps the numbers of a file to 0..1 in float, and back by the elevation in the XML.
    const double range = static_cast<double>(g.max_m) - static_cast<double>(g.min_m);
    const double elevation_m = range > 0 ? range : 1;
    std::vector<std::byte> bytes(8 + static_cast<std::size_t>(g.columns) * static_cast<std::size_t>(g.rows) *
                                         sizeof(float));
    const std::int32_t size[2] = {g.rows, g.columns};
    std::memcpy(bytes.data(), size, sizeof size);
    std::byte* at = bytes.data() + sizeof size;
    for (std::int32_t y = g.rows - 1; y >= 0; --y) { // from the south
        for (std::int32_t x = 0; x < g.columns; ++x, at += sizeof(float)) {
            const float over = g.row(y)[x] - g.min_m;
            std::memcpy(at, &over, sizeof over);
            const double kept = static_cast<double>(over / static_cast<float>(range > 0 ? range : 1)) * elevation_m;
            summary.rounding_error_m = std::max(summary.rounding_error_m, std::abs(kept + static_cast<double>(g.min_m) -
                                                                                   static_cast<double>(g.row(y)[x])));
        }
    }
    to.write("terrain.hfield", bytes);
    summary.diagonal_error_m = diagonal_error_m(g);
    const double half_x = (g.columns - 1) * g.spacing_m[0] / 2, half_y = (g.rows - 1) * g.spacing_m[1] / 2;
    to.write("terrain.xml",
             fmt::format("<mujoco model=\"terrain\">\n"
                         "  <asset>\n"
                         "    <hfield name=\"terrain\" file=\"terrain.hfield\" size=\"{} {} {} {}\"/>\n"
                         "  </asset>\n"
                         "  <worldbody>\n"
                         "    <geom name=\"terrain\" type=\"hfield\" hfield=\"terrain\" pos=\"{} {} {}\"/>\n"
                         "  </worldbody>\n"
                         "</mujoco>\n",
                         half_x, half_y, elevation_m, std::max(1.0, range / 10), half_x, -half_y, g.min_m));
}

// ---- SDFormat and URDF

// A square of 2^n + 1 samples whose north-west is the terrain's; beyond its rim the rim's heights go on.
void write_heightmap(const Ground& g, const std::string& folder, Folder& to, SimulateSummary& summary) {
    const auto longest = static_cast<std::uint32_t>(std::max(g.columns, g.rows));
    const auto side = static_cast<std::int32_t>(std::bit_ceil(longest - 1)) + 1;
    const double range = std::max(static_cast<double>(g.max_m) - static_cast<double>(g.min_m), 1e-6);
    std::vector<std::uint16_t> numbers;
    numbers.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    for (std::int32_t y = 0; y < side; ++y) {
        const float* const from = g.row(std::min(y, g.rows - 1));
        for (std::int32_t x = 0; x < side; ++x) {
            const double over = static_cast<double>(from[std::min(x, g.columns - 1)]) - static_cast<double>(g.min_m);
            numbers.push_back(static_cast<std::uint16_t>(std::lround(over / range * 65535)));
        }
    }
    write_image(folder + "/heightmap.png", "PNG", side, side, numbers);
    summary.files.emplace_back("heightmap.png");
    summary.heightmap_quantum_m = range / 65535;
    const double size_x = (side - 1) * g.spacing_m[0], size_y = (side - 1) * g.spacing_m[1];
    to.write("heightmap.sdf", fmt::format("<?xml version=\"1.0\"?>\n"
                                          "<sdf version=\"1.6\">\n"
                                          "  <model name=\"terrain\">\n"
                                          "    <static>true</static>\n"
                                          "    <link name=\"ground\">\n"
                                          "      <visual name=\"ground\">\n"
                                          "        <geometry>\n"
                                          "          <heightmap>\n"
                                          "            <uri>heightmap.png</uri>\n"
                                          "            <size>{} {} {}</size>\n"
                                          "            <pos>{} {} {}</pos>\n"
                                          "          </heightmap>\n"
                                          "        </geometry>\n"
                                          "      </visual>\n"
                                          "    </link>\n"
                                          "  </model>\n"
                                          "</sdf>\n",
                                          size_x, size_y, range, size_x / 2, -size_y / 2, g.min_m));
}

constexpr const char* model_sdf = R"(<?xml version="1.0"?>
<sdf version="1.6">
  <model name="terrain">
    <static>true</static>
    <link name="ground">
      <collision name="ground">
        <geometry><mesh><uri>terrain.obj</uri></mesh></geometry>
      </collision>
      <visual name="ground">
        <geometry><mesh><uri>terrain.obj</uri></mesh></geometry>
      </visual>
    </link>
  </model>
</sdf>
)";
constexpr const char* model_config = R"(<?xml version="1.0"?>
<model>
  <name>terrain</name>
  <version>1.0</version>
  <sdf version="1.6">model.sdf</sdf>
  <description>Ground made by fjell-bake simulate; ground.json says how far it is from the samples.</description>
</model>
)";
// concave: Bullet makes a hull of a mesh that does not say so.
constexpr const char* terrain_urdf = R"(<?xml version="1.0"?>
<robot name="terrain">
  <link name="ground" concave="yes">
    <visual>
      <geometry><mesh filename="terrain.obj"/></geometry>
    </visual>
    <collision concave="yes">
      <geometry><mesh filename="terrain.obj"/></geometry>
    </collision>
  </link>
</robot>
)";

std::string json_of(const SimulateSummary& s, const SimulateOptions& options) {
    nlohmann::ordered_json j{{"columns", s.columns},
                             {"rows", s.rows},
                             {"spacing_m", {s.spacing_m[0], s.spacing_m[1]}},
                             {"crs_origin", {s.crs_origin[0], s.crs_origin[1]}},
                             {"height_m", {s.min_m, s.max_m}},
                             {"files", s.files}};
    if (options.simulator == Simulator::mujoco) {
        j["diagonal_error_m"] = s.diagonal_error_m;
        j["rounding_error_m"] = s.rounding_error_m;
    } else {
        j["max_error_m"] = options.max_error_m;
        j["vertices"] = s.vertices;
        j["triangles"] = s.triangles;
        j["true_error_m"] = s.true_error_m;
        j["area_error_m"] = s.area_error_m;
    }
    if (options.simulator == Simulator::sdf) j["heightmap_quantum_m"] = s.heightmap_quantum_m;
    return j.dump(2) + "\n";
}

} // namespace

SimulateSummary simulate(const HeightSource& source, const SimulateOptions& options, const std::string& folder) {
    SimulateSummary summary;
    const Ground ground = read_ground(source, GroundHoles::refuse, options.threads, options.progress);
    summary.columns = ground.columns, summary.rows = ground.rows;
    std::copy_n(ground.spacing_m, 2, summary.spacing_m);
    std::copy_n(source.crs_origin, 2, summary.crs_origin);
    summary.min_m = ground.min_m, summary.max_m = ground.max_m;
    Folder to(folder, summary);
    switch (options.simulator) {
    case Simulator::mujoco: write_mujoco(ground, to, summary); break;
    case Simulator::sdf:
        write_mesh(ground, options, to, summary);
        write_heightmap(ground, folder, to, summary);
        to.write("model.sdf", std::string(model_sdf));
        to.write("model.config", std::string(model_config));
        break;
    case Simulator::urdf:
        write_mesh(ground, options, to, summary);
        to.write("terrain.urdf", std::string(terrain_urdf));
        break;
    }
    to.write("ground.json", json_of(summary, options));
    return summary;
}

} // namespace fjell::baker
