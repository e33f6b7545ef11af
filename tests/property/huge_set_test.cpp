// A terrain of a million samples a side, planned as a pack set of which a few packs are there: what it costs, and that
// it is as good far from its corner as near it.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <optional>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/stream_reader.h"
#include "fjell/query.h"
#include "session/file_ground.h"
#include "session/path.h"
#include "support/patience.h"
#include "support/set_scene.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr std::uint32_t side_samples = 1u << 20, tile_log2 = 10, tile_cells = 1u << tile_log2;
constexpr std::uint32_t tiles_a_side = (side_samples - 2) / tile_cells + 1; // 1,024
constexpr double spacing_m = 1;

struct At {
    std::uint32_t x, y;
};

// The same ground in each pack, two tiles wide: far apart, and the last one at the far end but for the cut tiles.
struct HugeSet {
    HugeSet() {
        Random random(31);
        baker::Dem dem = random_dem(random, 2 * tile_cells + 1, tile_cells + 1, Shape::fractal);
        const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
        const float base = *low, scale = 120 / (*high - *low);
        for (float& height : dem.heights_m) height = (height - base) * scale;
        io::SetFile set{side_samples, side_samples, tile_cells, {spacing_m, spacing_m}, {}};
        for (const At at : places) {
            baker::Dem here = dem;
            for (const int axis : {0, 1}) here.spacing_m[axis] = spacing_m;
            here.crs_origin[0] = 5e5 + at.x * tile_cells * spacing_m;
            here.crs_origin[1] = 6e6 - at.y * tile_cells * spacing_m;
            const std::string name = std::to_string(at.x) + "-" + std::to_string(at.y) + ".fjell";
            (void)baker::bake(std::move(here), small_bake(tile_log2), folder / name);
            set.packs.push_back({name, at.x, at.y, 2, 1, 0, false});
        }
        spit(path, io::set_file_text(set));
    }
    static constexpr At places[3] = {{0, 0}, {600, 480}, {tiles_a_side - 3, tiles_a_side - 2}};
    TemporaryFolder folder;
    const std::string path = folder / "set.json";
};

// As fjell-fly's shader and the guides' place a vertex: in floats, from the sample nearest to the eye.
double error_of_place_m(std::int32_t sample, double eye_m) {
    const auto cell = std::llround(eye_m / spacing_m);
    const auto eye_in_cell = static_cast<float>(eye_m - static_cast<double>(cell) * spacing_m);
    const float placed = static_cast<float>(sample - cell) * static_cast<float>(spacing_m) - eye_in_cell;
    return std::abs(static_cast<double>(placed) - (sample * spacing_m - eye_m));
}

// A stream over the set's files, with a reader of its own, until it rests.
struct Flown {
    explicit Flown(const io::PackFile& set)
        : file(set), memory(io::allocate(terrain_bytes(set.pack().header, {slots}))) {
        REQUIRE(create_terrain(file.pack(), file.corners(), {slots},
                               {memory.get(), terrain_bytes(file.pack().header, {slots})}, terrain)
                    .ok());
        CutBudget budget;
        budget.vertices = 1u << 17;
        budget.triangles = 1u << 18;
        cut.emplace(terrain, budget);
        const std::size_t bytes = stream_bytes(file.pack(), terrain, {});
        stream_memory = io::allocate(bytes);
        REQUIRE(create_stream(file.pack(), terrain, cut->cut, {}, {stream_memory.get(), bytes}, stream).ok());
    }
    void rest(const View& view) {
        io::StreamReader reader(stream, file);
        for (const Patience patience; patience.left();) {
            settings.now_s = stream_settings.now_s += 1.0 / 60;
            REQUIRE(update_stream(stream, {&view, 1}, settings, stream_settings, report).ok());
            cut_report = cut->update({&view, 1}, settings);
            if (report.converged && report.complete && cut_report.converged) return;
        }
        FAIL("the stream does not come to rest");
    }
    static constexpr std::uint32_t slots = 600;
    const io::PackFile& file;
    io::AlignedMemory memory, stream_memory;
    Terrain terrain;
    std::optional<Cut> cut;
    Stream stream;
    CutSettings settings{.max_error_px = 3};
    StreamSettings stream_settings;
    StreamReport report;
    CutReport cut_report;
};

// Heights, patches and rays over the same ground with all of its pages: what floats near a million metres would lose
// shows as another height.
void require_same_queries(const Terrain& terrain) {
    Random random(2302);
    std::vector<float> patches[2] = {std::vector<float>(33 * 33), std::vector<float>(33 * 33)};
    for (int n = 0; n < 500; ++n) {
        // Of 1/1,024 of a cell: exact in doubles, wherever the pack is.
        const double x = pick(random, 1, (2 * tile_cells << 10) - 1) / 1024.0,
                     z = pick(random, 1, (tile_cells << 10) - 1) / 1024.0;
        Vec3 places[3];
        for (std::size_t k = 0; k < 3; ++k)
            places[k] = {HugeSet::places[k].x * tile_cells * spacing_m + x, 400,
                         HugeSet::places[k].y * tile_cells * spacing_m + z};
        for (const Vec3& far : {places[1], places[2]}) {
            const GroundHeight a = ground_height(terrain, places[0].x, places[0].z),
                               b = ground_height(terrain, far.x, far.z);
            REQUIRE(b.finest);
            REQUIRE(std::memcmp(&a.height_m, &b.height_m, sizeof(double)) == 0);
            const GroundHit hit_a = cast_ray(terrain, places[0], {0.3, -0.8, 0.1}, 5e3),
                            hit_b = cast_ray(terrain, far, {0.3, -0.8, 0.1}, 5e3);
            REQUIRE(hit_a.hit == hit_b.hit);
            // Doubles a million metres away are 2^-33 m apart, and the ray goes through hundreds of triangles.
            REQUIRE(std::abs(hit_a.distance_m - hit_b.distance_m) < 1e-6);
            if (x > 2 * tile_cells - 33 || z > tile_cells - 33) continue;
            const Vec3* const corners[2] = {&places[0], &far};
            for (const int k : {0, 1})
                (void)ground_patch(terrain,
                                   {static_cast<std::int32_t>(corners[k]->x), static_cast<std::int32_t>(corners[k]->z)},
                                   0, 33, patches[k]);
            REQUIRE((patches[0] == patches[1]));
        }
    }
}

} // namespace

TEST_CASE(
    "a flight over a sparse set starts over ground nearest to its empty middle, and all of it is where tiles are") {
    const HugeSet set;
    const io::PackFile file(set.folder.path.string());
    session::FileGround ground(file);
    const io::LoadedPack loaded = io::load_pack(set.path, io::LoadTerrain::yes);
    const auto whole = [&](double x, double z) { return !ground_height(loaded.terrain, x, z).hole; };
    const session::Area area = session::start_area(loaded.terrain, whole),
                        streamed = session::start_area(loaded.terrain,
                                                       [&](double x, double z) { return ground.has_ground(x, z); });
    const At near = HugeSet::places[1]; // to (512, 512)
    const double a_tile = tile_cells * spacing_m;
    CHECK(area.x_m == near.x * a_tile);
    CHECK(area.z_m == near.y * a_tile);
    CHECK(area.width_m == 2 * a_tile);
    CHECK(area.depth_m == a_tile);
    // From the file a place is its north-western sample's: the last column and row, which the next tile does not have.
    CHECK(streamed.x_m == area.x_m);
    CHECK(streamed.z_m == area.z_m);
    CHECK(streamed.width_m >= area.width_m * (1 - 1.0 / 32));

    session::Ground here = session::ground_of(loaded.terrain);
    here.start = area;
    const session::CameraPath path{"orbit", session::Units::terrain, session::Orbit{.over_start = true}};
    for (const session::Pose& pose : session::resample(path, here, 8)) {
        CHECK(std::abs(pose.position_m.x - (near.x + 1) * a_tile) < a_tile);
        CHECK(std::abs(pose.position_m.z - (near.y + 0.5) * a_tile) < a_tile);
        CHECK(pose.position_m.y < loaded.terrain.header().max_m + a_tile);
    }
    const session::Area all = session::area_of_tiles(loaded.terrain);
    CHECK(all.x_m == 0);
    CHECK(all.width_m == (HugeSet::places[2].x + 2) * a_tile);
    CHECK(all.depth_m == (HugeSet::places[2].y + 1) * a_tile);
    const session::Ground full = session::ground_of(loaded.terrain);
    CHECK(full.start_area().longer_m() == full.longer_m());
}

TEST_CASE("a terrain of a million samples a side is opened, flown across its voids, asked and exported") {
    const HugeSet set;
    const io::PackFile file(set.folder.path.string());
    const PackHeader& h = file.pack().header;
    CHECK(h.tiles_x == tiles_a_side);
    CHECK(h.tiles_held == 6);
    // Void tiles cost 8 bytes each in the terrain and nothing else: the rest is what six tiles would cost alone.
    PackHeader six = h;
    six.columns = 6 * tile_cells + 1, six.rows = tile_cells + 1;
    six.tiles_x = 6, six.tiles_y = 1, six.tiles_held = 0;
    const double places = std::pow(tiles_a_side + 1.0, 2);
    CHECK(static_cast<double>(terrain_bytes(h, {600})) <
          static_cast<double>(terrain_bytes(six, {600})) + 8 * places + 4096);

    Flown flown(file);
    const Terrain& terrain = flown.terrain;
    CHECK(terrain.tile_count() == 6);
    CHECK(static_cast<double>(cut_bytes(terrain, flown.cut->state().budget)) < 24e6 + 20'000.0 * 600);
    const double a_tile = tile_cells * spacing_m;
    std::vector<std::uint32_t> vertices;
    for (const At at : HugeSet::places) { // from pack to pack, over nothing
        const Vec3 eye{(at.x + 0.93) * a_tile + 0.2, 0, (at.y + 0.4) * a_tile + 0.7};
        const View view = make_view({eye.x, terrain.header().max_m + 30.0, eye.z}, {0.7, -0.3, 0.5}, {0, 1, 0}, 1, 640,
                                    480, 0.5, 2e6);
        const View between =
            make_view({eye.x + 30 * a_tile, 500, eye.z}, {0, -1, 0.01}, {0, 1, 0}, 1, 640, 480, 1, 1e6);
        flown.rest(between);
        CHECK(!ground_height(terrain, between.eye_m.x, eye.z).finest);
        CHECK(ground_height(terrain, between.eye_m.x, eye.z).hole);
        flown.rest(view);
        CHECK(check_cut(*flown.cut) == "");
        vertices.push_back(flown.cut_report.vertices);
        const GroundHeight ground = ground_height(terrain, eye.x, eye.z);
        CHECK(ground.inside);
        CHECK(!ground.hole);
        const GroundHit hit = cast_ray(terrain, view.eye_m, {0.7, -0.3, 0.5}, 5e3);
        CHECK(hit.hit);
        double worst_m = 0;
        int near_by = 0;
        const CutMesh mesh = cut_mesh(flown.cut->cut);
        for (const TileRange& range : mesh.mesh.tiles)
            for (std::uint32_t i = 0; i < range.index_count; ++i) {
                const MeshVertex& v = mesh.mesh.vertices[mesh.mesh.indices[range.first_index + i]];
                if (std::hypot(v.column * spacing_m - eye.x, v.row * spacing_m - eye.z) > 4000) continue;
                ++near_by;
                worst_m = std::max({worst_m, error_of_place_m(v.column, eye.x), error_of_place_m(v.row, eye.z)});
            }
        CHECK(near_by > 1000);
        CHECK(worst_m < 1e-3);
    }
    // The same ground seen from the same place in it: as fine a thousand kilometres from the corner as beside it, and
    // what the eye's rounding adds to its reach (make_reach) is hardly more.
    for (const std::size_t far : {1u, 2u}) {
        CHECK(vertices[far] > 0.99 * vertices[0]);
        CHECK(vertices[far] < 1.02 * vertices[0]);
    }

    require_same_queries(io::load_pack(set.path, io::LoadTerrain::yes).terrain);
    const At last = HugeSet::places[2];
    const View view = make_view({(last.x + 0.5) * a_tile, 900, (last.y + 0.5) * a_tile}, {0, -1, 0.01}, {0, 1, 0}, 1,
                                640, 480, 1, 1e6);
    flown.settings.max_error_px = 8;
    flown.rest(view);
    const gltf::Snapshot snapshot =
        gltf::take_snapshot(terrain, flown.cut->cut, view, flown.settings, flown.cut_report);
    CHECK(gltf::write_snapshot(file, snapshot, set.folder / "far.glb").triangles > 100);
}
