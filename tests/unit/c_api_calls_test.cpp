// Every call of the library for C that c_host.c does not make, beside its C++ one.
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "unit/c_api_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Both lie alike: padding aside, which neither sets.
template <typename C, typename Cpp>
bool same(const C& c, const Cpp& cpp) {
    static_assert(sizeof(C) == sizeof(Cpp));
    return std::memcmp(&c, &cpp, sizeof c) == 0;
}
template <typename Cpp>
auto as_c(const Cpp& handle) {
    if constexpr (std::is_same_v<Cpp, Terrain>) return std::bit_cast<FjellTerrain>(handle);
    if constexpr (std::is_same_v<Cpp, LiveCut>) return std::bit_cast<FjellLiveCut>(handle);
    if constexpr (std::is_same_v<Cpp, Stream>) return std::bit_cast<FjellStream>(handle);
}

} // namespace

TEST_CASE("what C asks of a pack, a terrain, a map and a view is answered as in C++") {
    const auto pack = a_pack();
    FjellPack c;
    REQUIRE(fjell_open_pack(pack.file.data(), pack.file.size(), &c).code == FJELL_OK);
    const PackHeader& header = pack.pack.header;
    REQUIRE(fjell_chunk_count(&c.header) == chunk_count(header));
    std::vector<std::byte> theirs, ours;
    int kinds = 0;
    for (std::uint64_t chunk = 0; chunk < chunk_count(header); ++chunk) {
        const ChunkId id = chunk_id(header, chunk);
        const FjellChunkId c_id = fjell_chunk_id(&c.header, chunk);
        kinds |= 1 << c_id.kind;
        CHECK(same(c_id, id));
        CHECK(fjell_chunk_index(&c.header, c_id) == chunk);
        CHECK(fjell_chunk_raw_bytes(&c.header, c_id) == chunk_raw_bytes(header, id));
        const ChunkEntry entry = pack.pack.entry(chunk);
        const FjellChunkEntry c_entry = fjell_pack_entry(&c, chunk);
        CHECK(same(c_entry, entry));
        ours.assign(entry.raw_bytes, std::byte{});
        REQUIRE(read_chunk(pack.pack, id, ours).ok());
        for (const bool by_hand : {false, true}) {
            theirs.assign(entry.raw_bytes, std::byte{});
            const FjellStatus s = by_hand ? fjell_decode_chunk(&c_entry, pack.file.data() + entry.offset,
                                                               entry.stored_bytes, theirs.data(), theirs.size())
                                          : fjell_read_chunk(&c, c_id, theirs.data(), theirs.size());
            CHECK(s.code == FJELL_OK);
            CHECK(theirs == ours);
        }
    }
    CHECK((kinds & 1 << FJELL_CHUNK_NORMAL) != 0); // with maps
    std::uint8_t rgb[2][48], xz[2][32];
    CHECK(fjell_decode_colour(pack.file.data(), 8, 4, rgb[0], 48).code == FJELL_OK);
    CHECK(fjell_decode_normal(pack.file.data(), 16, 4, xz[0], 32).code == FJELL_OK);
    REQUIRE(decode_colour(std::span(pack.file).first(8), 4, rgb[1]).ok());
    REQUIRE(decode_normal(std::span(pack.file).first(16), 4, xz[1]).ok());
    CHECK(std::ranges::equal(rgb[0], rgb[1]));
    CHECK(std::ranges::equal(xz[0], xz[1]));
    CHECK(fjell_check_ranges(&c.header).code == FJELL_OK);
    CHECK(fjell_check_ranges(nullptr).code == static_cast<FjellStatusCode>(check_ranges(PackHeader{}).code));

    const Terrain& t = pack.terrain;
    const FjellTerrain terrain = as_c(t);
    CHECK(fjell_terrain_valid(terrain));
    CHECK(!fjell_terrain_valid(FjellTerrain{}));
    CHECK(same(*fjell_terrain_header(terrain), t.header()));
    CHECK(fjell_terrain_columns(terrain) == t.columns());
    CHECK(fjell_terrain_rows(terrain) == t.rows());
    CHECK(fjell_terrain_spacing_x_m(terrain) == t.spacing_x_m());
    CHECK(fjell_terrain_spacing_z_m(terrain) == t.spacing_z_m());
    CHECK(fjell_terrain_x_m(terrain, 7) == t.x_m(7));
    CHECK(fjell_terrain_z_m(terrain, 9) == t.z_m(9));
    CHECK(fjell_terrain_extent_x_m(terrain) == t.extent_x_m());
    CHECK(fjell_terrain_extent_z_m(terrain) == t.extent_z_m());
    CHECK(t.extent_x_m() != t.extent_z_m());
    CHECK(fjell_terrain_has_voids(terrain) == t.has_voids());
    CHECK(fjell_terrain_tile_count(terrain) == t.tile_count());
    CHECK(fjell_terrain_pages_per_tile(terrain) == t.pages_per_tile());
    REQUIRE(fjell_unload_page(terrain, 0, t.pages_per_tile() - 1).code == FJELL_OK);
    CHECK(fjell_terrain_page_count(terrain) == t.page_count());
    CHECK(fjell_terrain_page_slots(terrain) == t.page_slots());
    CHECK(fjell_terrain_pages_loaded(terrain) == t.pages_loaded());
    CHECK(fjell_terrain_pages_missing(terrain) == 1);
    CHECK(fjell_load_page(&c, terrain, 0, t.pages_per_tile() - 1).code == FJELL_OK);
    CHECK(fjell_terrain_pages_missing(terrain) == 0);
    CHECK(fjell_terrain_missing_px(terrain) == t.missing_px());

    CHECK(fjell_pages_per_tile(&c.header) == pages_per_tile(header));
    CHECK(pages_per_tile(header) == t.pages_per_tile());
    const std::uint32_t last = t.pages_per_tile() - 1;
    CHECK(fjell_page_step_log2(&c.header, last) == page_step_log2(header, last));
    CHECK(fjell_page_at(&c.header, 0, 40, 70) == page_at(header, 0, 40, 70));
    CHECK(fjell_page_of(&c.header, 33, 47) == page_of(header, 33, 47));
    CHECK(page_of(header, 33, 47) != 0);
    CHECK(fjell_page_loaded(terrain, 0, last));
    const std::uint64_t changes = page_changes(t);
    CHECK(fjell_page_changes(terrain) == changes);
    REQUIRE(unload_page(t, 0, last).ok());
    CHECK(!fjell_page_loaded(terrain, 0, last));
    CHECK(!page_loaded(t, 0, last));
    CHECK(page_changes(t) == changes + 1);
    REQUIRE(load_page(pack.pack, t, 0, last).ok());
    for (const SampleIndex sample : {SampleIndex{0, 0}, {17, 33}, {160, 89}, {-1, 0}, {1 << 30, 1 << 30}}) {
        const FjellTerrainVertex v = fjell_terrain_vertex(terrain, {sample.column, sample.row});
        const TerrainVertex expected = terrain_vertex(t, sample);
        CHECK((v.loaded == expected.loaded && v.hole == expected.hole && v.in_tile == expected.in_tile));
        CHECK((v.height_m == expected.height_m && v.error_m == expected.error_m && v.radius_m == expected.radius_m));
        CHECK(v.loaded == (sample.column >= 0 && sample.column < 161));
    }
    CHECK(fjell_terrain_height_m(terrain, 301.5, 402.25) == terrain_height_m(t, 301.5, 402.25));
    CHECK(fjell_set_missing_px(terrain, 2.5).code == FJELL_OK);
    CHECK(t.missing_px() == 2.5);
    CHECK(std::string_view(fjell_set_missing_px(terrain, -1).field) == "missing_px");
    CHECK(set_missing_px(t, 0).ok());

    View view = view_of(1);
    view.left -= 0.1;
    FjellView seen = fjell_view_default();
    std::memcpy(&seen.eye_m, &view, sizeof view);
    CHECK(same(fjell_make_frustum(&seen), make_frustum(view)));
    CHECK(fjell_focal_length_px(&seen) == focal_length_px(view));
    CHECK(fjell_corner_factor(&seen) == corner_factor(view));
    CHECK(fjell_validate_view(&seen).code == FJELL_OK);
    seen.top = seen.bottom;
    CHECK(std::string_view(fjell_validate_view(&seen).field) == validate([&] {
                                                                    View flat = view;
                                                                    flat.top = flat.bottom;
                                                                    return flat;
                                                                }())
                                                                    .field);
}

TEST_CASE("what C reads of a stream and of vertices that morph is what C++ reads") {
    const auto pack = a_pack();
    Memory memory;
    PagedTerrain bare(pack.pack, {});
    const CutBudget budget{.vertices = 40'000, .triangles = 80'000};
    LiveCut cut;
    REQUIRE(create_cut(bare.terrain, budget, memory.span(cut_bytes(bare.terrain, budget)), cut).ok());
    const StreamBudget streaming{.map_bytes = 1 << 20, .tail_log2 = 2};
    Stream stream;
    REQUIRE(create_stream(pack.pack, bare.terrain, cut, streaming,
                          memory.span(stream_bytes(pack.pack, bare.terrain, streaming)), stream)
                .ok());
    FjellStreamBudget c_budget = fjell_stream_budget_default();
    c_budget.map_bytes = streaming.map_bytes;
    c_budget.tail_log2 = 2;
    const auto* const header = fjell_terrain_header(as_c(bare.terrain));
    std::size_t arrivals = 0, commands = 0, lod = 0, failed = 0;
    for (int frame = 0; frame < 30; ++frame) {
        const View view = view_of(frame);
        const CutSettings settings{.max_work = 300, .morph = Morph::error, .now_s = frame * 0.1};
        StreamReport streamed;
        CutReport report;
        REQUIRE(update_stream(stream, {&view, 1}, settings, {.now_s = frame * 0.1}, streamed).ok());
        REQUIRE(update_cut(cut, {&view, 1}, settings, report).ok());
        std::size_t count = 0;
        const FjellPageArrival* const arrived = fjell_stream_page_arrivals(as_c(stream), &count);
        REQUIRE(count == stream_page_arrivals(stream).size());
        for (std::size_t i = 0; i < count; ++i, ++arrivals)
            CHECK(arrived[i].page == stream_page_arrivals(stream)[i].page);
        const FjellMapCommand* const command = fjell_stream_map_commands(as_c(stream), &count);
        REQUIRE(count == stream_map_commands(stream).size());
        for (std::size_t i = 0; i < count; ++i, ++commands) {
            CHECK(command[i].layer == stream_map_commands(stream)[i].layer);
            CHECK(command[i].blocks == stream_map_commands(stream)[i].blocks.data());
            CHECK(command[i].block_bytes == stream_map_commands(stream)[i].blocks.size());
        }
        const FjellStreamFailure* const failure = fjell_stream_failures(as_c(stream), &count);
        REQUIRE(count == stream_failures(stream).size());
        for (std::size_t i = 0; i < count; ++i, ++failed) CHECK(failure[i].code == FJELL_UNREADABLE);
        if (frame == 20) CHECK(fjell_stream_retry_failed(as_c(stream)).code == FJELL_OK);
        for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
            const auto number = static_cast<std::uint8_t>(kind);
            const FjellTileMap* const maps = fjell_stream_tile_maps(as_c(stream), number, &count);
            const std::span<const TileMap> expected = stream_tile_maps(stream, kind);
            REQUIRE(count == expected.size());
            float grid[2][9] = {};
            for (std::uint32_t tile = 0; tile < count; ++tile, ++lod) {
                CHECK(maps[tile].layer == expected[tile].layer);
                CHECK(fjell_min_lod_grid(maps, count, header->tiles_x, tile, grid[0]).code == FJELL_OK);
                REQUIRE(min_lod_grid(expected, header->tiles_x, tile, grid[1]).ok());
                CHECK(same(grid[0], grid[1]));
            }
            const FjellMapLayers layers = fjell_map_layers(header, &c_budget, number);
            CHECK(same(layers, map_layers(pack.pack.header, streaming, kind)));
            CHECK(same(fjell_stream_map_layers(as_c(stream), number), stream_map_layers(stream, kind)));
            CHECK(fjell_map_layer_bytes(&layers, number) == map_layer_bytes(stream_map_layers(stream, kind), kind));
        }
        StreamRequest request;
        for (int n = 0; stream_next_request(stream, request); ++n)
            (void)(frame == 3 && n == 0 ? fjell_stream_fail(as_c(stream), request.ticket, false)
                                        : fjell_stream_provide(as_c(stream), request.ticket,
                                                               pack.file.data() + request.offset, request.bytes));
    }
    CHECK((arrivals > 3 && commands > 3 && lod > 3 && failed > 0));

    const FjellCutMesh mesh = fjell_cut_mesh(as_c(cut));
    REQUIRE(mesh.morph_count == mesh.mesh.vertex_count);
    const FjellMorphFrame& frame = mesh.frame;
    CHECK((frame.morph == FJELL_MORPH_ERROR && frame.views == 1 && frame.now_s > 0));
    CHECK(same(frame.view[0], cut_mesh(cut).frame.view[0]));
    std::vector<FjellCompactVertex> c_compact(mesh.morph_count);
    std::vector<CompactVertex> compact(mesh.morph_count);
    fjell_compact_vertices(mesh.mesh.vertices, mesh.morph, mesh.morph_count, c_compact.data());
    compact_vertices(cut_mesh(cut).mesh.vertices, cut_mesh(cut).morph, compact);
    CHECK(std::memcmp(compact.data(), c_compact.data(), 16 * mesh.morph_count) == 0);
    fjell_compact_vertices(nullptr, mesh.morph, mesh.morph_count, c_compact.data()); // nothing to read
    std::vector<std::uint16_t> small(mesh.mesh.index_count);
    fjell_compact_indices(mesh.mesh.indices, small.size(), small.data());
    CHECK(std::equal(small.begin(), small.end(), mesh.mesh.indices)); // the budget is that small
    CHECK(fjell_compact_share(&frame.view[0]) == compact_share(cut_mesh(cut).frame.view[0]));
    CHECK(fjell_compact_share(nullptr) == 0);
    CHECK(fjell_compact_rise_m(0x3c01) == compact_rise_m(0x3c01));
    CHECK(fjell_compact_length_m(77) == compact_length_m(77));
    FjellCutBudget indexed = fjell_cut_budget_default();
    CHECK(fjell_index_bytes(&indexed) == 4);
    indexed.vertices = 65'536;
    CHECK(fjell_index_bytes(&indexed) == 2);
    indexed.struct_size = sizeof indexed + 1;
    CHECK(fjell_index_bytes(&indexed) == 0);
    int between = 0;
    for (std::size_t i = 0; i < mesh.mesh.index_count; ++i) {
        const std::uint32_t slot = mesh.mesh.indices[i];
        if (slot >= mesh.morph_count) continue;
        const float height_m =
            fjell_morphed_height_m(as_c(bare.terrain), &mesh.mesh.vertices[slot], &mesh.morph[slot], &frame);
        REQUIRE(height_m == morphed_height_m(bare.terrain, cut_mesh(cut).mesh.vertices[slot], cut_mesh(cut).morph[slot],
                                             cut_mesh(cut).frame));
        between += height_m != mesh.mesh.vertices[slot].height_m;
    }
    CHECK(between > 0);
    CHECK(fjell_morph_age_s(1, 1000) == morph_age_s(1, 1000));
    bool released = true;
    REQUIRE(fjell_cut_release_page(as_c(cut), 0, 0, &released).code == FJELL_OK);
    CHECK(!released);
    CHECK(fjell_cut_cancel_release(as_c(cut), 0, 0).code == FJELL_OK);
}

TEST_CASE("a job system of C is given a cut's jobs, and the cut is that of one thread") {
    const auto pack = a_pack();
    Memory memory;
    const auto terrain = as_c(pack.terrain);
    FjellCutBudget budget = fjell_cut_budget_default();
    CHECK(budget.workers == 1);
    budget.vertices = 40'000;
    budget.triangles = 80'000;
    budget.workers = 3;
    const std::size_t bytes = fjell_cut_bytes(terrain, &budget);
    FjellLiveCut cut{};
    REQUIRE(fjell_create_cut(terrain, &budget, memory.give(&memory, bytes), bytes, &cut).code == FJELL_OK);
    FjellCutSettings settings = fjell_cut_settings_default();
    CHECK(settings.jobs.run == nullptr);
    std::uint32_t most = 0;
    settings.jobs = {[](void* user, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data) {
                         auto& seen = *static_cast<std::uint32_t*>(user);
                         seen = std::max(seen, count);
                         for (std::uint32_t n = count; n != 0; --n) job(data, n - 1);
                     },
                     &most};
    FjellView view = fjell_view_default();
    REQUIRE(fjell_make_view({100, 800, 100}, {1, -1, 0.5}, {0, 1, 0}, 1, 1280, 720, 1, 1e5, &view).code == FJELL_OK);
    FjellCutReport report = {};
    report.struct_size = sizeof report;
    REQUIRE(fjell_rebuild_cut(cut, &view, 1, &settings, &report).code == FJELL_OK);
    CHECK(most == 3);

    const CutBudget alone{.vertices = 40'000, .triangles = 80'000};
    LiveCut expected;
    REQUIRE(create_cut(pack.terrain, alone, memory.span(cut_bytes(pack.terrain, alone)), expected).ok());
    const View seen = view_of(0);
    CutReport said;
    REQUIRE(rebuild_cut(expected, {&seen, 1}, {}, said).ok());
    CHECK(report.vertices > 1000);
    CHECK(report.vertices == said.vertices);
    CHECK(report.triangles == said.triangles);
}

TEST_CASE("a host in C moves ground as one in C++ does, and is told the same of it") {
    const auto ours = a_pack(), theirs = a_pack();
    Memory memory;
    const EditBudget budget{.blocks = 64, .stamps = 4, .areas = 8};
    FjellEditBudget c_budget = fjell_edit_budget_default();
    CHECK((c_budget.blocks == EditBudget{}.blocks && c_budget.stamps == EditBudget{}.stamps &&
           c_budget.areas == EditBudget{}.areas && c_budget.moving == EditBudget{}.moving && !c_budget.holes));
    CHECK(fjell_has_room_for_holes(fjell_terrain_header(as_c(theirs.terrain))) == has_room_for_holes(ours.pack.header));
    CHECK(!fjell_has_room_for_holes(nullptr));
    CHECK(fjell_has_room_for_locks(fjell_terrain_header(as_c(theirs.terrain))) == has_room_for_locks(ours.pack.header));
    CHECK(!fjell_has_room_for_locks(nullptr));
    c_budget.blocks = budget.blocks, c_budget.stamps = budget.stamps, c_budget.areas = budget.areas,
    c_budget.moving = budget.moving;
    const FjellTerrain terrain = as_c(theirs.terrain);
    const std::size_t bytes = fjell_edits_bytes(fjell_terrain_header(terrain), &c_budget);
    CHECK(bytes == edits_bytes(ours.pack.header, budget));
    Edits edits;
    REQUIRE(create_edits(ours.terrain, budget, memory.span(bytes), edits).ok());
    FjellEdits c_edits{};
    REQUIRE(fjell_create_edits(terrain, &c_budget, Memory::give(&memory, bytes), bytes, &c_edits).code == FJELL_OK);
    CHECK(fjell_create_edits(terrain, nullptr, Memory::give(&memory, bytes), bytes, nullptr).code ==
          FJELL_OUT_OF_RANGE);

    const StampPoint points[] = {{300, 200, 90}, {500, 300, 120}};
    const FjellStampPoint c_points[] = {{300, 200, 90}, {500, 300, 120}};
    Stamp road, crater;
    road.shape = StampShape::path, road.radius_m = 25, road.falloff_m = 40, road.points = points, road.point_count = 2;
    crater.shape = StampShape::crater, crater.x_m = 800, crater.z_m = 400;
    crater.radius_m = 60, crater.falloff_m = 30, crater.amount_m = 20;
    FjellStamp c_road = fjell_stamp_default(), c_crater = c_road;
    CHECK((c_road.shape == FJELL_STAMP_SHAPE_RAISE && c_road.points == nullptr && c_road.radius_m == 0));
    c_road.shape = FJELL_STAMP_SHAPE_PATH, c_road.radius_m = 25, c_road.falloff_m = 40;
    c_road.points = c_points, c_road.point_count = 2;
    c_crater.shape = FJELL_STAMP_SHAPE_CRATER, c_crater.x_m = 800, c_crater.z_m = 400;
    c_crater.radius_m = 60, c_crater.falloff_m = 30, c_crater.amount_m = 20;
    StampId id = 0;
    std::uint64_t c_id = 0;
    REQUIRE((push_stamp(edits, road, id).ok() && push_stamp(edits, crater, id).ok()));
    REQUIRE(fjell_push_stamp(c_edits, &c_road, &c_id).code == FJELL_OK);
    REQUIRE(fjell_push_stamp(c_edits, &c_crater, &c_id).code == FJELL_OK);
    CHECK(c_id == id);
    CHECK(fjell_stamp_state(c_edits, c_id).state == FJELL_STAMP_STATE_WAITING);
    CHECK(fjell_stamp_state(c_edits, 0).state == FJELL_STAMP_STATE_UNKNOWN);
    c_crater.amount_m = std::numeric_limits<float>::quiet_NaN();
    const FjellStatus refused = fjell_push_stamp(c_edits, &c_crater, &c_id);
    CHECK(std::string_view(fjell_check_stamp(&c_crater).field) == refused.field);
    CHECK((refused.code == FJELL_OUT_OF_RANGE && std::string_view(refused.field) == "Stamp::amount_m"));
    c_crater.struct_size = sizeof c_crater + 8;
    CHECK(std::string_view(fjell_push_stamp(c_edits, &c_crater, &c_id).field) == "struct_size");
    CHECK(c_id == id);

    EditReport report;
    FjellEditReport c_report;
    c_report.struct_size = sizeof c_report;
    FjellEditSettings settings = fjell_edit_settings_default();
    CHECK((settings.max_work == FJELL_UNLIMITED_EDIT_WORK && settings.max_time_us == 0));
    settings.max_work = 3;
    int calls = 0;
    do {
        REQUIRE(update_edits(edits, {}, {.max_work = 3}, report).ok());
        REQUIRE(fjell_update_edits(c_edits, nullptr, 0, &settings, &c_report).code == FJELL_OK);
        REQUIRE((c_report.applied == report.applied && c_report.refused == report.refused &&
                 c_report.waiting == report.waiting && c_report.samples == report.samples &&
                 c_report.loose == report.loose && c_report.work == report.work && c_report.blocks == report.blocks &&
                 c_report.exhausted == report.exhausted));
        ++calls;
    } while (report.waiting + report.loose != 0);
    CHECK(calls > 2);
    CHECK(fjell_stamp_state(c_edits, c_id).state == FJELL_STAMP_STATE_APPLIED);
    // A lock along the road.
    const std::uint32_t before = count_always_drawn(edits);
    road.shape = StampShape::lock, road.amount_m = 0.5f;
    c_road.shape = FJELL_STAMP_SHAPE_LOCK, c_road.amount_m = 0.5f;
    REQUIRE((push_stamp(edits, road, id).ok() && fjell_push_stamp(c_edits, &c_road, &c_id).code == FJELL_OK));
    settings.max_work = FJELL_UNLIMITED_EDIT_WORK;
    REQUIRE(update_edits(edits, {}, {}, report).ok());
    REQUIRE(fjell_update_edits(c_edits, nullptr, 0, &settings, &c_report).code == FJELL_OK);
    CHECK((report.applied == 1 && report.locks != 0 && c_report.locks == report.locks));
    CHECK((count_always_drawn(edits) > before && fjell_count_always_drawn(c_edits) == count_always_drawn(edits)));
    for (const auto& [x_m, z_m] : {std::pair{400.0, 250.0}, {800.0, 400.0}, {100.0, 700.0}})
        CHECK(fjell_ground_height(terrain, x_m, z_m, 0).height_m == ground_height(ours.terrain, x_m, z_m).height_m);
    CHECK(ground_height(ours.terrain, 400, 250).height_m == Approx(105).margin(1));

    std::uint64_t cursor = 0, c_cursor = 0;
    bool lost = false, c_lost = true;
    GroundRect rects[64];
    FjellGroundRect c_rects[64];
    const std::uint32_t changes = take_ground_changes(edits, cursor, rects, lost);
    REQUIRE(fjell_take_ground_changes(c_edits, &c_cursor, c_rects, 64, &c_lost) == changes);
    CHECK((changes > 1 && c_cursor == cursor && !c_lost && !lost));
    CHECK(std::memcmp(rects, c_rects, changes * sizeof *rects) == 0);
    CHECK(fjell_take_ground_changes(c_edits, &c_cursor, c_rects, 64, nullptr) == 0);
    CHECK(fjell_take_ground_changes(c_edits, nullptr, c_rects, 1, nullptr) == 1);

    // Normal maps, as if each tile showed all of its own.
    const GroundMapsBudget map_budget{.changes = 8, .texels = 8192};
    FjellGroundMapsBudget c_map_budget = fjell_ground_maps_budget_default();
    CHECK((c_map_budget.changes == GroundMapsBudget{}.changes && c_map_budget.texels == GroundMapsBudget{}.texels));
    c_map_budget.changes = map_budget.changes, c_map_budget.texels = map_budget.texels;
    const std::size_t map_bytes = fjell_ground_maps_bytes(fjell_terrain_header(terrain), &c_map_budget);
    CHECK(map_bytes == ground_maps_bytes(ours.pack.header, map_budget));
    GroundMaps maps;
    FjellGroundMaps c_maps{};
    REQUIRE(create_ground_maps(ours.terrain, map_budget, memory.span(map_bytes), maps).ok());
    REQUIRE(
        fjell_create_ground_maps(terrain, &c_map_budget, Memory::give(&memory, map_bytes), map_bytes, &c_maps).code ==
        FJELL_OK);
    REQUIRE(ours.pack.header.normal_log2 != 0);
    std::vector<TileMap> shown;
    std::vector<FjellTileMap> c_shown;
    std::vector<MapCommand> commands;
    std::vector<FjellMapCommand> c_commands;
    for (std::uint32_t tile = 0; tile < ours.terrain.tile_count(); ++tile) {
        const auto log2 = static_cast<std::uint8_t>(ours.pack.header.normal_log2);
        shown.push_back({tile, log2, 0});
        c_shown.push_back({tile, log2, 0});
        commands.push_back({MapKind::normal, log2, 0, 0, tile, tile, 0, {}});
        c_commands.push_back({FJELL_MAP_NORMAL, log2, 0, 0, tile, tile, 0, nullptr, 0});
    }
    REQUIRE(note_map_commands(maps, commands).ok());
    REQUIRE(fjell_note_map_commands(c_maps, c_commands.data(), c_commands.size()).code == FJELL_OK);
    GroundMapsReport made;
    FjellGroundMapsReport c_made;
    c_made.struct_size = sizeof c_made;
    std::uint32_t patches = 0;
    do {
        REQUIRE(update_ground_maps(maps, shown, made).ok());
        REQUIRE(fjell_update_ground_maps(c_maps, c_shown.data(), c_shown.size(), &c_made).code == FJELL_OK);
        REQUIRE((made.patches == c_made.patches && made.texels == c_made.texels && made.waiting == c_made.waiting));
        const std::span<const MapPatch> of_cpp = ground_map_patches(maps);
        std::size_t count = 0;
        const FjellMapPatch* const of_c = fjell_ground_map_patches(c_maps, &count);
        REQUIRE(count == of_cpp.size());
        for (std::size_t i = 0; i < count; ++i, ++patches) {
            REQUIRE((of_c[i].tile == of_cpp[i].tile && of_c[i].x == of_cpp[i].x && of_c[i].rows == of_cpp[i].rows));
            REQUIRE(of_c[i].block_bytes == of_cpp[i].blocks.size());
            REQUIRE(std::memcmp(of_c[i].blocks, of_cpp[i].blocks.data(), of_c[i].block_bytes) == 0);
        }
    } while (made.waiting != 0);
    CHECK(patches > 2);
    CHECK(fjell_update_ground_maps(c_maps, c_shown.data(), 0, &c_made).code == FJELL_OUT_OF_RANGE);
    CHECK(fjell_destroy_ground_maps(c_maps).code == FJELL_OK);
    CHECK(fjell_destroy_ground_maps(c_maps).code == FJELL_INVALID_HANDLE);

    // Paint: the same stamp, and maps under it.
    Stamp burnt;
    burnt.shape = StampShape::paint;
    burnt.x_m = 400, burnt.z_m = 250, burnt.radius_m = 90, burnt.rgb[0] = 200, burnt.strength = 0.75f;
    FjellStamp c_burnt = fjell_stamp_default();
    CHECK((c_burnt.material == FJELL_NO_MATERIAL && c_burnt.strength == 1));
    c_burnt.shape = FJELL_STAMP_SHAPE_PAINT;
    c_burnt.x_m = 400, c_burnt.z_m = 250, c_burnt.radius_m = 90, c_burnt.rgb[0] = 200, c_burnt.strength = 0.75f;
    CHECK(fjell_paint_bytes(terrain) == 0);
    REQUIRE(push_stamp(edits, burnt, id).ok());
    REQUIRE(fjell_push_stamp(c_edits, &c_burnt, &c_id).code == FJELL_OK);
    REQUIRE(update_edits(edits, {}, {}, report).ok());
    REQUIRE(fjell_update_edits(c_edits, nullptr, 0, nullptr, &c_report).code == FJELL_OK);
    CHECK((report.paint != 0 && c_report.paint == report.paint));
    cursor = c_cursor = 0;
    const std::uint32_t painted = take_paint_changes(ours.terrain, cursor, rects, lost);
    REQUIRE(fjell_take_paint_changes(terrain, &c_cursor, c_rects, 64, &c_lost) == painted);
    CHECK((painted != 0 && c_cursor == cursor && !c_lost));
    CHECK(std::memcmp(rects, c_rects, painted * sizeof *rects) == 0);
    const std::uint32_t log2 = ours.pack.header.colour_log2;
    REQUIRE(log2 != 0);
    std::vector<std::byte> texels(chunk_raw_bytes(ours.pack.header, {ChunkKind::colour, 0, 0})), c_texels, of_copy;
    REQUIRE(read_chunk(ours.pack, {ChunkKind::colour, 0, 0}, texels).ok());
    c_texels = of_copy = texels;
    bool changed = false, c_changed = false;
    REQUIRE(paint_map(ours.terrain, MapKind::colour, 0, log2, texels, changed).ok());
    REQUIRE(fjell_paint_map(terrain, FJELL_MAP_COLOUR, 0, log2, c_texels.data(), c_texels.size(), &c_changed).code ==
            FJELL_OK);
    CHECK((changed && c_changed && c_texels == texels && texels != of_copy));
    CHECK(fjell_paint_bytes(terrain) == paint_bytes(ours.terrain));
    const std::size_t copy_bytes = fjell_paint_bytes(terrain);
    FjellPaint copy{};
    REQUIRE(fjell_copy_paint(terrain, Memory::give(&memory, copy_bytes), copy_bytes, &copy).code == FJELL_OK);
    CHECK(fjell_copy_paint(terrain, nullptr, 0, &copy).code == FJELL_MEMORY_TOO_SMALL);
    CHECK(fjell_copy_paint(terrain, nullptr, 0, nullptr).code == FJELL_OUT_OF_RANGE);
    REQUIRE(fjell_paint_map_of(copy, FJELL_MAP_COLOUR, 0, log2, of_copy.data(), of_copy.size(), nullptr).code ==
            FJELL_OK);
    CHECK(of_copy == texels);
    CHECK(fjell_paint_map(terrain, FJELL_MAP_NORMAL, 0, log2, of_copy.data(), of_copy.size(), nullptr).code ==
          FJELL_OUT_OF_RANGE);

    CHECK(fjell_destroy_edits(c_edits).code == FJELL_OK);
    CHECK(fjell_destroy_edits(c_edits).code == FJELL_INVALID_HANDLE);
}
