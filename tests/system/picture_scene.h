// What the picture tests share: a baked terrain, its meshes, and a renderer that shows them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "fjell/cut.h"
#include "fjell/gl/context.h"
#include "fjell/gl/renderer.h"
#include "fjell/io/load.h"
#include "fjell/recursive.h"
#include "shared/terrain_data.h"
#include "support/dem.h"

namespace pictures {

using namespace fjell;

constexpr double pi = 3.14159265358979323846;
// What software draws takes its time a pixel; what is asserted holds at any size.
inline constexpr std::uint32_t width_px = 640, height_px = 480;

// Ridges and valleys, samples x samples, 30 m apart.
inline baker::Dem mountains(int samples) {
    const std::string n = std::to_string(samples);
    return baker::synthesise_text(
        R"({"columns": )" + n + R"(, "rows": )" + n +
        R"(, "spacing_m": 30, "seed": 7, "base_m": 0, "relief_m": 2500, "feature_m": 12000})");
}

// The light of an sRGB code, 0 to 1; codes may lie between two.
[[nodiscard]] inline double linear(double code) {
    const double c = std::clamp(code, 0.0, 255.0) / 255;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

// A mesh whose spans it owns itself.
struct OwnMesh {
    std::vector<MeshVertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<TileRange> tiles;
    Topology topology = Topology::triangles;

    [[nodiscard]] MeshView view() const {
        return {topology, vertices, indices, tiles, 0, static_cast<std::uint32_t>(vertices.size())};
    }
};

inline OwnMesh copy_of(const MeshView& mesh) {
    return {{mesh.vertices.begin(), mesh.vertices.end()},
            {mesh.indices.begin(), mesh.indices.end()},
            {mesh.tiles.begin(), mesh.tiles.end()},
            mesh.topology};
}

// Every sample active: each cell is cut along the diagonal that longest-edge bisection ends with. Cell (x, y) of a tile
// with x + y even: from its north-west to its south-east sample; odd: the other one (one step below the finest
// centres).
inline OwnMesh full_resolution(const Terrain& terrain) {
    OwnMesh mesh;
    const auto side = static_cast<std::uint32_t>(data_of(terrain).tree.side()), n = side + 1;
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        const auto first_index = static_cast<std::uint32_t>(mesh.indices.size());
        const SampleIndex corner{static_cast<std::int32_t>(tile % terrain.header().tiles_x * side),
                                 static_cast<std::int32_t>(tile / terrain.header().tiles_x * side)};
        for (std::uint32_t y = 0; y < n; ++y)
            for (std::uint32_t x = 0; x < n; ++x) {
                const SampleIndex at = corner + SampleIndex{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
                mesh.vertices.push_back({at.column, at.row, data_of(terrain).height_m(at)});
            }
        for (std::uint32_t y = 0; y < side; ++y)
            for (std::uint32_t x = 0; x < side; ++x) {
                const std::uint32_t nw = first + y * n + x, ne = nw + 1, sw = nw + n, se = sw + 1;
                // Counter-clockwise from above: east is right, south is down.
                if ((x + y) % 2 == 0)
                    mesh.indices.insert(mesh.indices.end(), {nw, sw, se, nw, se, ne});
                else
                    mesh.indices.insert(mesh.indices.end(), {nw, sw, ne, ne, sw, se});
            }
        mesh.tiles.push_back({tile, first_index, 6 * side * side, 2 * side * side});
    }
    return mesh;
}

struct Picture {
    gl::Image colour;
    std::vector<float> depth;      // as stored
    std::vector<float> distance_m; // along forward; infinity: sky
};

// One headless context for the whole program: creating it is the dear part. Never destroyed: leak checkers cannot
// follow into a driver that was unloaded.
inline gl::Headless& context() {
    static gl::Headless* const headless = gl::Headless::create({.debug = true, .device = -1}).release();
    return *headless;
}

// A terrain baked in this process, with a renderer large enough for its full resolution.
struct Scene {
    io::LoadedPack loaded;
    io::AlignedMemory memory;
    RecursiveMethod method;
    io::AlignedMemory cut_memory;
    LiveCut cut; // after make_cut()
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    // The cheapest: most pictures are about geometry and maps. Tests of light set it.
    gl::LightSettings light{.air = gl::Air::simple, .dither = false, .detail = false};

    Scene(baker::Dem dem, int tile_log2, PageOrder order = PageOrder::planar, int horizon_spacing = 0,
          const std::string& layers = {}) {
        context();
        char path[] = "/tmp/fjell-picture-XXXXXX";
        const int fd = mkstemp(path);
        REQUIRE(fd >= 0);
        close(fd);
        baker::BakeOptions options;
        options.tile_log2 = tile_log2;
        options.compression = 1;
        options.order = order;
        options.horizon_spacing = horizon_spacing;
        options.layers_path = layers;
        baker::bake(std::move(dem), options, path);
        loaded = io::load_pack(path, io::LoadTerrain::yes);
        unlink(path);

        const Terrain& terrain = loaded.terrain;
        const RecursiveBudget budget{terrain.tile_count() * data_of(terrain).pages.tile_vertices() + 1024,
                                     terrain.tile_count() * data_of(terrain).pages.tile_vertices() * 6 + 1024};
        const std::size_t bytes = recursive_bytes(terrain, budget);
        memory = io::allocate(bytes);
        REQUIRE(create_recursive(terrain, budget, {memory.get(), bytes}, method).ok());
        target = gl::Target::create({width_px, height_px, 1});
        renderer = gl::Renderer::create(terrain, loaded.pack,
                                        {.vertices = budget.vertices,
                                         .indices = std::max(budget.indices, 3 * chunks(terrain) * segment_triangles),
                                         .ranges = chunks(terrain),
                                         .morph = true,
                                         .light = light});
    }

    // Of a live cut that may be refined to the last sample: two triangles a cell, and a half-full chunk a tile.
    static constexpr std::uint32_t segment_triangles = 64;
    static std::uint32_t chunks(const Terrain& terrain) {
        return terrain.tile_count() * (data_of(terrain).pages.tile_vertices() * 2 / segment_triangles + 2) + 8;
    }

    // The cut on its way from one view to another, with vertices that morph by distance and by time. After make_cut().
    CutMesh half_way(const View& from, const View& to, double error_px) {
        CutSettings settings;
        settings.max_error_px = error_px;
        settings.morph = Morph::error;
        settings.morph_s = 1;
        CutReport report;
        REQUIRE(rebuild_cut(cut, {&from, 1}, settings, report).ok());
        settings.max_work = 1500; // so that some come late
        for (int frame = 1; frame <= 8; ++frame) {
            settings.now_s = frame * 0.1;
            REQUIRE(update_cut(cut, {&to, 1}, settings, report).ok());
        }
        REQUIRE(report.morphing > 0);
        return cut_mesh(cut);
    }

    void make_cut(bool morph = true) {
        const Terrain& terrain = loaded.terrain;
        CutBudget budget;
        budget.vertices = terrain.tile_count() * data_of(terrain).pages.tile_vertices() + 1024;
        budget.triangles = chunks(terrain) * segment_triangles;
        budget.segment_triangles = segment_triangles;
        budget.morph = morph;
        const std::size_t bytes = cut_bytes(terrain, budget);
        cut_memory = io::allocate(bytes);
        REQUIRE(create_cut(terrain, budget, {cut_memory.get(), bytes}, cut).ok());
    }

    // The live cut brought to a view, from nothing or from where it was.
    CutReport follow(const View& view, double error_px, bool from_nothing = false) {
        CutSettings settings;
        settings.max_error_px = error_px;
        CutReport report;
        REQUIRE((from_nothing ? rebuild_cut : update_cut)(cut, {&view, 1}, settings, report).ok());
        REQUIRE(report.converged);
        return report;
    }

    // The recursive method's mesh of a view; valid until the next call.
    MeshView refined(const View& view, double error_px, Topology topology = Topology::triangles, bool cull = true) {
        RefineSettings settings;
        settings.max_error_px = error_px;
        settings.topology = topology;
        settings.cull = cull;
        FrameReport report;
        REQUIRE(update_recursive(method, view, settings, report).ok());
        REQUIRE(report.converged);
        return recursive_mesh(method);
    }

    template <typename Mesh> // MeshView or CutMesh
    Picture draw(const Mesh& mesh, const View& view, gl::DrawOptions options = {}) {
        options.light = light;
        if constexpr (std::is_same_v<Mesh, CutMesh>)
            renderer->draw(mesh, cut_take_changes(cut), view, options, *target);
        else
            renderer->draw(mesh, view, options, *target);
        Picture picture;
        target->read_colour(picture.colour);
        target->read_depth(picture.depth);
        picture.distance_m = picture.depth;
        gl::depth_to_metres(picture.distance_m, view);
        const std::vector<std::string>& messages = context().log().messages;
        INFO((messages.empty() ? std::string() : messages.front()));
        REQUIRE(context().log().errors == 0);
        return picture;
    }

    // A camera at a share of the terrain's extents, some metres above ground, heading clockwise from north.
    [[nodiscard]] View camera(double east, double south, double above_m, double heading_deg, double pitch_deg) const {
        const Terrain& terrain = loaded.terrain;
        const double x = east * terrain.x_m(static_cast<std::int32_t>(terrain.header().columns) - 1);
        const double z = south * terrain.z_m(static_cast<std::int32_t>(terrain.header().rows) - 1);
        const double h = heading_deg * pi / 180, p = pitch_deg * pi / 180;
        const Vec3 forward{std::sin(h) * std::cos(p), std::sin(p), -std::cos(h) * std::cos(p)};
        const Vec3 up{-std::sin(h) * std::sin(p), std::cos(p), std::cos(h) * std::sin(p)};
        return make_view({x, data_of(terrain).ground_m(x, z) + above_m, z}, forward, up, pi / 4, width_px, height_px, 5,
                         1e6);
    }
};

} // namespace pictures
