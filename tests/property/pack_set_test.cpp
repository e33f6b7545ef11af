// A pack set is one terrain: whole, it is the pack that it was split from, bit for bit; with packs left out, it is that
// terrain with another rim.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "fjell/measure.h"
#include "fjell/query.h"
#include "gltf/geometry.h"
#include "session/file_ground.h"
#include "support/mesh_check.h"
#include "support/rounds.h"
#include "support/set_scene.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Several tiles of several pages, maps or not, any order that streams.
baker::Dem random_field(Random& random, int& log2) {
    log2 = pick(random, 4, 7);
    const int most = std::min((1 << log2) * pick(random, 2, 6), 400);
    baker::Dem dem = random_dem(random, pick(random, most / 2 + 2, most + 30), pick(random, most / 2 + 2, most + 30),
                                pick(random, 0, 3) ? Shape::fractal : Shape::noise);
    if (pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
    return dem;
}

PackAndSet random_set(Random& random) {
    int log2 = 0;
    baker::Dem dem = random_field(random, log2);
    baker::BakeOptions options = small_bake(log2);
    options.order = pick(random, 0, 2) == 0 ? PageOrder::hierarchical_z : PageOrder::planar;
    return {random, std::move(dem), options};
}

template <typename T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

// Everything of a pack but where in a file it lies.
void require_same_contents(const Pack& a, const Pack& b) {
    REQUIRE(a.header.columns == b.header.columns);
    REQUIRE(a.header.rows == b.header.rows);
    REQUIRE(a.header.directory_count == b.header.directory_count);
    // From the vertical scale on, but for holes, which neighbours share, and the places and hashes of notes.
    PackHeader of_a = a.header, of_b = b.header;
    for (PackHeader* const h : {&of_a, &of_b}) {
        h->file_bytes = h->directory_offset = h->directory_hash = h->notes_offset = h->header_hash = h->voids = 0;
        for (double& origin : h->crs_origin) origin = std::round(origin * 1e3);
    }
    REQUIRE(std::memcmp(&of_a, &of_b, sizeof of_a) == 0);
    REQUIRE((a.header.voids == 0) == (b.header.voids == 0));
    std::vector<std::byte> from_a, from_b;
    for (std::uint64_t chunk = 0; chunk < a.header.directory_count; ++chunk) {
        const ChunkEntry ea = a.entry(chunk), eb = b.entry(chunk);
        from_a.resize(ea.raw_bytes);
        from_b.resize(eb.raw_bytes);
        REQUIRE(read_chunk(a, chunk_id(a.header, chunk), from_a).ok());
        REQUIRE(read_chunk(b, chunk_id(b.header, chunk), from_b).ok());
        REQUIRE(from_a == from_b);
        REQUIRE(std::memcmp(&ea.bound, &eb.bound, sizeof ea.bound) == 0);
    }
}

// One of two that fly side by side: with random numbers of its own, the same as the other's.
struct Flyer {
    Flyer(const Pack& pack, std::uint32_t slots, const StreamBudget& budget, std::uint32_t seed)
        : on(pack, slots, budget), random(seed),
          client(random, on, {.fails = 0.02, .garbage = 0.02, .never = 0.01, .most_delay = 3}) {}
    void update(const View& view, CutSettings cut, StreamSettings settings) {
        client.act();
        stream = on.update({&view, 1}, cut, settings);
        client.follow();
        report = on.cut.update({&view, 1}, cut);
    }
    Streamed on;
    Random random;
    ScriptedClient client;
    StreamReport stream;
    CutReport report;
};

void require_same_frame(Flyer& a, Flyer& b) {
    REQUIRE(a.stream.pages_inserted == b.stream.pages_inserted);
    REQUIRE(a.stream.bytes_read == b.stream.bytes_read);
    REQUIRE(same_bytes(stream_page_arrivals(a.on.stream), stream_page_arrivals(b.on.stream)));
    REQUIRE(std::memcmp(&a.stream.missing_px, &b.stream.missing_px, sizeof(double)) == 0);
    REQUIRE(a.report.work == b.report.work);
    const CutMesh of_a = cut_mesh(a.on.cut.cut), of_b = cut_mesh(b.on.cut.cut);
    REQUIRE(same_bytes(of_a.mesh.vertices, of_b.mesh.vertices));
    REQUIRE(same_bytes(of_a.mesh.indices, of_b.mesh.indices));
    REQUIRE(same_bytes(of_a.mesh.tiles, of_b.mesh.tiles));
    REQUIRE(same_bytes(of_a.morph, of_b.morph));
    const auto maps_a = stream_map_commands(a.on.stream), maps_b = stream_map_commands(b.on.stream);
    REQUIRE(maps_a.size() == maps_b.size());
    for (std::size_t i = 0; i < maps_a.size(); ++i) {
        REQUIRE(maps_a[i].tile == maps_b[i].tile);
        REQUIRE(maps_a[i].layer == maps_b[i].layer);
        REQUIRE(same_bytes(maps_a[i].blocks, maps_b[i].blocks));
    }
}

void require_same_answers(Random& random, const Terrain& a, const Terrain& b) {
    for (int n = 0; n < 20; ++n) {
        const double x = uniform(random, -0.1, 1.1) * a.extent_x_m(), z = uniform(random, -0.1, 1.1) * a.extent_z_m();
        const GroundHeight of_a = ground_height(a, x, z), of_b = ground_height(b, x, z);
        REQUIRE(std::memcmp(&of_a.height_m, &of_b.height_m, sizeof(double)) == 0);
        REQUIRE(of_a.hole == of_b.hole);
        REQUIRE(of_a.finest == of_b.finest);
        const Vec3 eye{x, a.header().max_m + 10.0, z}, way{uniform(random, -1, 1), -0.5, uniform(random, -1, 1)};
        const GroundHit hit_a = cast_ray(a, eye, way, 1e9), hit_b = cast_ray(b, eye, way, 1e9);
        REQUIRE(hit_a.hit == hit_b.hit);
        REQUIRE(std::memcmp(&hit_a.distance_m, &hit_b.distance_m, sizeof(double)) == 0);
    }
}

// A set with a pack for every tile, less some of them in the middle and few at its rim: its folder.
std::string perforated(Random& random, const PackAndSet& both) {
    const std::string folder = both.folder / "perforated", path = folder + "/set.json";
    const PackHeader h = io::PackFile(both.pack).pack().header;
    (void)baker::split_pack(both.pack, folder, {h.tiles_x, h.tiles_y});
    io::SetFile set = io::parse_set_file(io::read_text(path), path);
    const io::SetFilePack first = set.packs.front();
    std::erase_if(set.packs, [&](const io::SetFilePack& pack) {
        const bool at_rim =
            pack.tile_x == 0 || pack.tile_y == 0 || pack.tile_x + 1 == h.tiles_x || pack.tile_y + 1 == h.tiles_y;
        return pick(random, 0, at_rim ? 9 : 1) == 0;
    });
    if (set.packs.empty()) set.packs.push_back(first);
    spit(path, io::set_file_text(set));
    return folder;
}

// A tile is missing that lies between four that are there.
bool has_enclosed_gap(const Terrain& terrain) {
    const PackHeader& h = terrain.header();
    for (std::int32_t y = 1; y + 1 < static_cast<std::int32_t>(h.tiles_y); ++y)
        for (std::int32_t x = 1; x + 1 < static_cast<std::int32_t>(h.tiles_x); ++x) {
            const auto there = [&](std::int32_t dx, std::int32_t dy) {
                return terrain.tile_at({x + dx, y + dy}) != no_tile;
            };
            if (!there(0, 0) && there(-1, 0) && there(1, 0) && there(0, -1) && there(0, 1)) return true;
        }
    return false;
}

// What covers all of its tiles has no holes: those of terrains with holes are compared, not looked at.
std::string wrong_with(const Terrain& terrain, const MeshView& mesh) {
    return terrain.has_voids() ? std::string() : check_mesh(terrain, mesh);
}

// Of a mesh of the whole: what lies in the tiles that the sparse one has.
std::vector<Triangle> triangles_in(const Terrain& sparse, const Terrain& whole, MeshView mesh) {
    std::vector<TileRange> there;
    for (const TileRange& range : mesh.tiles)
        if (sparse.tile_at(whole.tile_place(range.tile)) != no_tile) there.push_back(range);
    mesh.tiles = there;
    return triangles_of(mesh);
}

void load_all(const Pack& pack, const Terrain& terrain) {
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            REQUIRE(load_page(pack, terrain, tile, page).ok());
}
void load_or_unload(Random& random, const Pack& pack, const Terrain& terrain) {
    const auto tile = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.tile_count()) - 1)),
               page = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.pages_per_tile()) - 1));
    if (pick(random, 0, 3) == 0) {
        (void)unload_page(terrain, tile, page);
        return;
    }
    const Status s = load_page(pack, terrain, tile, page);
    REQUIRE((s.ok() || s.code == StatusCode::coarser_page_first));
}

} // namespace

TEST_CASE("a pack set is the pack that it was split from, chunk for chunk, and flies like it bit for bit") {
    Random random(2101);
    std::uint64_t pages = 0;
    for (int round = 0; round < rounds(3, 60); ++round) {
        const PackAndSet both = random_set(random);
        const io::LoadedPack pack = io::load_pack(both.pack, io::LoadTerrain::yes),
                             set = io::load_pack(both.set, io::LoadTerrain::yes);
        CAPTURE(round, both.split.packs_x, both.split.packs_y);
        if (set.pack.header.tiles_held != 0) continue; // it has rectangles without any ground
        require_same_contents(pack.pack, set.pack);
        const auto least = static_cast<int>(pack.terrain.tile_count()),
                   all = static_cast<int>(pack.terrain.page_count());
        const auto slots = static_cast<std::uint32_t>(pick(random, std::min(least + 2, all), all)),
                   seed = static_cast<std::uint32_t>(random());
        Flyer a(pack.pack, slots, {}, seed), b(set.pack, slots, {}, seed);
        View view = random_view(random, pack.terrain);
        CutSettings cut;
        cut.max_error_px = random_threshold(random);
        cut.morph = pick(random, 0, 1) ? Morph::error : Morph::none;
        StreamSettings settings;
        for (int frame = 0; frame < 25; ++frame) {
            if (pick(random, 0, 9) == 0) view = random_view(random, pack.terrain);
            view = moved(random, view, random_step_m(random, pack.terrain));
            cut.now_s = settings.now_s += 1.0 / 60;
            a.update(view, cut, settings);
            b.update(view, cut, settings);
            CAPTURE(frame, slots, cut.max_error_px);
            require_same_frame(a, b);
            pages += a.stream.pages_inserted;
        }
        require_same_answers(random, a.on.paged.terrain, b.on.paged.terrain);
    }
    CHECK(pages > 20);
}

TEST_CASE("a sparse set streams and is drawn without a crack, to the threshold wherever it has tiles") {
    Random random(2102);
    int converged = 0, sparse = 0;
    for (int round = 0; round < rounds(4, 80); ++round) {
        const PackAndSet both = random_set(random);
        if (both.split.packs_x * both.split.packs_y > 1) thin_out(random, both.set);
        const io::LoadedPack set = io::load_pack(both.set, io::LoadTerrain::yes);
        sparse += set.pack.header.tiles_held != 0;
        const auto least = static_cast<int>(set.terrain.tile_count()), all = static_cast<int>(set.terrain.page_count());
        const auto slots = static_cast<std::uint32_t>(pick(random, std::min(least + 2, all), all));
        Flyer flyer(set.pack, slots, {}, static_cast<std::uint32_t>(random()));
        View view = random_view(random, set.terrain);
        CutSettings cut;
        cut.max_error_px = random_threshold(random);
        StreamSettings settings;
        for (int frame = 0; frame < 20; ++frame) {
            if (pick(random, 0, 9) == 0) view = random_view(random, set.terrain);
            view = moved(random, view, random_step_m(random, set.terrain));
            cut.now_s = settings.now_s += 1.0 / 60;
            flyer.update(view, cut, settings);
            CAPTURE(round, frame, slots, cut.max_error_px);
            REQUIRE(check_stream(flyer.on) == "");
            REQUIRE(check_frame(flyer.on.cut, set.terrain, flyer.report, cut) == "");
            if (flyer.stream.converged && flyer.report.converged) {
                ++converged;
                REQUIRE(difference(active_set(flyer.on.cut),
                                   target_set(set.terrain, set.terrain, {&view, 1}, cut.max_error_px)) == "");
            }
        }
        // From scratch it is the same.
        Cut fresh(set.terrain, ample_cut(set.terrain));
        CutReport rebuilt = fresh.rebuild({&view, 1}, cut);
        REQUIRE(check_frame(fresh, set.terrain, rebuilt, cut) == "");
        REQUIRE(difference(active_set(fresh), target_set(set.terrain, set.terrain, {&view, 1}, cut.max_error_px)) ==
                "");
    }
    CHECK(sparse > 1);
    CHECK(converged > 0);
}

TEST_CASE("over a sparse set the recursive method draws the live cut's triangles, whatever pages are missing") {
    Random random(2104);
    int enclosed = 0, incomplete = 0, complete = 0;
    for (int round = 0; round < rounds(12, 150); ++round) {
        const PackAndSet both = random_set(random);
        std::string folder = both.set;
        if (pick(random, 0, 1))
            folder = perforated(random, both);
        else
            thin_out(random, folder);
        const io::LoadedPack set = io::load_pack(folder, io::LoadTerrain::yes),
                             pack = io::load_pack(both.pack, io::LoadTerrain::yes);
        Recursive whole(pack.terrain, ample_budget(pack.terrain));
        enclosed += has_enclosed_gap(set.terrain);
        PagedTerrain paged(set.pack, {});
        Recursive method(paged.terrain, ample_budget(set.terrain)), strips(paged.terrain, ample_budget(set.terrain));
        for (int frame = 0; frame < 4; ++frame) {
            if (frame == 3) load_all(set.pack, paged.terrain);
            for (int n = pick(random, 0, 400); n > 0 && frame < 3; --n) load_or_unload(random, set.pack, paged.terrain);
            (paged.terrain.pages_missing() != 0 ? incomplete : complete) += 1;
            const View view = random_view(random, set.terrain);
            const Frustum frustum = make_frustum(view);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.cull = false;
            const FrameReport report = method.update(view, settings);
            CAPTURE(round, frame, settings.max_error_px, paged.terrain.pages_missing(), set.terrain.tile_count());
            REQUIRE(report.converged);
            REQUIRE(report.tiles == set.terrain.tile_count());
            REQUIRE(wrong_with(set.terrain, method.mesh()) == "");
            if (paged.terrain.pages_missing() == 0) {
                REQUIRE(measure_error(set.terrain, method.mesh(), view).max_px <= settings.max_error_px * (1 + 1e-9));
                (void)whole.update(view, settings);
                REQUIRE((triangles_in(set.terrain, pack.terrain, whole.mesh()) == triangles_of(method.mesh())));
            }
            Cut cut(paged.terrain, ample_cut(set.terrain));
            CutSettings cut_settings;
            cut_settings.max_error_px = settings.max_error_px;
            (void)settle(cut, {&view, 1}, cut_settings, 1000);
            REQUIRE((triangles_of(cut.mesh()) == triangles_of(method.mesh())));
            settings.topology = Topology::strip;
            (void)strips.update(view, settings);
            REQUIRE(wrong_with(set.terrain, strips.mesh()) == "");
            REQUIRE((triangles_of(strips.mesh()) == triangles_of(method.mesh())));
            settings.cull = true;
            settings.topology = Topology::triangles;
            settings.metric = pick(random, 0, 1) ? Metric::depth : Metric::isotropic;
            (void)method.update(view, settings);
            REQUIRE(wrong_with(set.terrain, method.mesh()) == "");
            if (paged.terrain.pages_missing() == 0)
                REQUIRE(measure_error(set.terrain, method.mesh(), view, &frustum).max_px <=
                        settings.max_error_px * (1 + 1e-9));
        }
    }
    CHECK(enclosed > 1);
    CHECK(incomplete > 10);
    CHECK(complete > 10);
}

// The ground rises by a metre a cell, so that one-sided slopes are those of both sides, and lies high, so that what is
// not there would be a cliff.
TEST_CASE("what flies over missing tiles has ground under it, and what is exported has its slope beside them") {
    baker::Dem dem;
    dem.columns = dem.rows = 3 * 16 + 1;
    dem.spacing_m[0] = dem.spacing_m[1] = 1;
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x) dem.heights_m.push_back(static_cast<float>(1000 + x));
    const TemporaryFolder folder;
    (void)baker::bake(std::move(dem), small_bake(4), folder / "pack.fjell");
    (void)baker::split_pack(folder / "pack.fjell", folder / "set", {3, 3});
    io::SetFile set = io::parse_set_file(slurp(folder / "set/set.json"), "set");
    std::erase_if(set.packs, [](const io::SetFilePack& pack) { return pack.tile_x == 1 && pack.tile_y == 1; });
    spit(folder / "set/set.json", io::set_file_text(set));
    const io::LoadedPack loaded = io::load_pack(folder / "set", io::LoadTerrain::yes);
    const Terrain& terrain = loaded.terrain;

    for (const double x : {17.5, 24.0, 31.9}) CHECK(data_of(terrain).ground_m(x, 24) >= 1000);
    const io::PackFile file(folder / "set");
    session::FileGround read(file);
    for (const double x : {17.5, 24.0, 31.9}) CHECK(read.ground_m(x, 24) == Approx(data_of(terrain).ground_m(x, 24)));

    // Triangles along the border of the tile to the west of the missing one.
    std::vector<MeshVertex> vertices;
    std::vector<std::uint32_t> indices;
    for (std::int32_t row = 16; row <= 32; ++row)
        for (const std::int32_t column : {15, 16})
            vertices.push_back({column, row, data_of(terrain).height_m({column, row})});
    for (std::uint32_t i = 0; i + 3 < vertices.size(); i += 2)
        for (const std::uint32_t corner : {i, i + 3, i + 1}) indices.push_back(corner);
    const auto count = static_cast<std::uint32_t>(indices.size());
    const TileRange range{terrain.tile_at({0, 1}), 0, count, count / 3};
    const MeshView mesh{Topology::triangles, vertices, indices, {&range, 1}, 0, 0};
    const gltf::TileGeometry geometry = gltf::TileCollector(terrain).collect(mesh, mesh.tiles, {});
    CHECK(geometry.vertices.size() == 33);
    for (const gltf::SnapshotVertex& v : geometry.vertices) {
        CHECK(v.normal[0] == Approx(-std::sqrt(0.5)));
        CHECK(v.normal[1] == Approx(std::sqrt(0.5)));
        CHECK(v.normal[2] == 0);
    }
}

TEST_CASE("queries of a sparse set are those of the whole where it has tiles, and find no ground elsewhere") {
    Random random(2103);
    int there = 0, missing = 0;
    for (int round = 0; round < rounds(4, 60); ++round) {
        const PackAndSet both = random_set(random);
        if (both.split.packs_x * both.split.packs_y > 1) thin_out(random, both.set);
        const io::LoadedPack pack = io::load_pack(both.pack, io::LoadTerrain::yes),
                             set = io::load_pack(both.set, io::LoadTerrain::yes);
        const Terrain &whole = pack.terrain, &part = set.terrain;
        const std::int32_t side = data_of(whole).tree.side();
        for (int n = 0; n < 60; ++n) {
            const std::int32_t column = pick(random, 0, static_cast<int>(whole.columns()) - 1),
                               row = pick(random, 0, static_cast<int>(whole.rows()) - 1);
            const double u = pick(random, 0, 1) ? uniform(random, 0, 1) : 0,
                         x = (column + u) * whole.header().spacing_m[0], z = row * whole.header().spacing_m[1];
            const SampleIndex tile{std::min(column / side, data_of(whole).tree.tiles_x - 1),
                                   std::min(row / side, data_of(whole).tree.tiles_y - 1)};
            const GroundHeight of_whole = ground_height(whole, x, z), of_part = ground_height(part, x, z);
            CAPTURE(round, column, row, u);
            if (part.tile_at(tile) != no_tile) {
                ++there;
                REQUIRE(of_part.hole == of_whole.hole);
                REQUIRE(std::memcmp(&of_part.height_m, &of_whole.height_m, sizeof(double)) == 0);
            } else if (column % side != 0 && row % side != 0) { // in no neighbour's border either
                ++missing;
                REQUIRE(of_part.inside == of_whole.inside);
                REQUIRE(of_part.hole);
                REQUIRE(!cast_ray(part, {x, whole.header().max_m + 1.0, z}, {0, -1, 0}, 1e9).hit);
            }
        }
        // A patch over all of it: samples of the tiles that are there, their borders included, and holes.
        const auto patch_side = std::min(std::max(whole.columns(), whole.rows()), max_patch_side);
        std::vector<float> of_whole(std::size_t{patch_side} * patch_side), of_part(of_whole.size());
        const std::unique_ptr<bool[]> whole_holes(new bool[of_whole.size()]), part_holes(new bool[of_whole.size()]);
        (void)ground_patch(whole, {0, 0}, 0, patch_side, of_whole, {whole_holes.get(), of_whole.size()});
        (void)ground_patch(part, {0, 0}, 0, patch_side, of_part, {part_holes.get(), of_part.size()});
        for (std::int32_t row = 0; row < static_cast<std::int32_t>(whole.rows()); ++row)
            for (std::int32_t column = 0; column < static_cast<std::int32_t>(whole.columns()); ++column) {
                const std::size_t at = static_cast<std::size_t>(row) * patch_side + static_cast<std::size_t>(column);
                const TerrainData::Vertex v = data_of(part).vertex({column, row});
                bool held = false;
                for (const SampleIndex by : {SampleIndex{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
                    const SampleIndex of{(column - by.column) / side, (row - by.row) / side};
                    held = held || (column >= by.column && row >= by.row && part.tile_at(of) != no_tile);
                }
                CAPTURE(round, column, row);
                REQUIRE(part_holes[at] == (held ? whole_holes[at] : true));
                REQUIRE(v.hole == part_holes[at]);
                if (held) REQUIRE(of_part[at] == of_whole[at]);
            }
    }
    CHECK(there > 20);
    CHECK(missing > 20);
}
