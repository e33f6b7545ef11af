// The library for C (fjell/fjell_c.h) beside the one for C++: the same calls, answers and refusals. c_host.c is the
// host, compiled as C99; c_abi.c holds what a host that was compiled earlier relies on.
#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>
#include <vector>

#include <catch2/catch.hpp>

#include "unit/c_api_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Times differ from run to run.
void check_same(const FjellCutReport& c, const CutReport& cpp) {
    CHECK(c.frame == cpp.frame);
    CHECK(c.work == cpp.work);
    CHECK(c.visits == cpp.visits);
    CHECK(c.activations == cpp.activations);
    CHECK(c.deactivations == cpp.deactivations);
    CHECK(c.vertices == cpp.vertices);
    CHECK(c.triangles == cpp.triangles);
    CHECK(c.tiles_drawn == cpp.tiles_drawn);
    CHECK(c.triangles_drawn == cpp.triangles_drawn);
    CHECK(c.waiting == cpp.waiting);
    CHECK(c.exhausted == cpp.exhausted);
    CHECK(c.error_px_requested == cpp.error_px_requested);
    CHECK(c.error_bound_px == cpp.error_bound_px);
    CHECK(c.threshold_px == cpp.threshold_px);
    CHECK(c.converged == cpp.converged);
    CHECK(c.vertex_slots.used == cpp.vertex_slots.used);
    CHECK(c.triangle_slots.capacity == cpp.triangle_slots.capacity);
    CHECK(c.vertices_changed == cpp.vertices_changed);
    CHECK(c.triangles_changed == cpp.triangles_changed);
}

template <typename C, typename Cpp>
void check_defaults(const C& c, const Cpp& cpp) { // without what pads the end
    CHECK(c.struct_size == sizeof(C));
    Cpp other = cpp;
    std::memcpy(static_cast<void*>(&other), reinterpret_cast<const std::byte*>(&c) + sizeof(std::size_t),
                std::min(sizeof(Cpp), sizeof(C) - sizeof(std::size_t)));
    CHECK(std::memcmp(&other, &cpp, sizeof cpp) == 0);
}

} // namespace

TEST_CASE("a host in C gets what one in C++ gets: meshes, changes, reports, bounds, heights, rays and patches") {
    const auto pack = a_pack();
    Memory memory;
    Flown flown;
    REQUIRE(c_host_fly(pack.file.data(), pack.file.size(), &memory, &flown) == 0);

    const CutBudget budget{.vertices = 40'000, .triangles = 80'000};
    Terrain terrain;
    REQUIRE(load_terrain(pack.pack, memory.span(terrain_bytes(pack.pack.header)), terrain).ok());
    LiveCut cut;
    REQUIRE(create_cut(terrain, budget, memory.span(cut_bytes(terrain, budget)), cut).ok());
    CutReport report;
    std::uint32_t vertices = 0, triangles = 0, drawn = 0;
    for (int frame = 0; frame < 4; ++frame) {
        const View view = view_of(frame);
        REQUIRE(update_cut(cut, {&view, 1}, {.max_error_px = 1, .max_work = 5000}, report).ok());
        const CutChanges changes = cut_take_changes(cut);
        for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t, std::uint32_t n) { vertices += n; });
        for_each_run(changes.triangle_bits, changes.triangle_words,
                     [&](std::uint32_t, std::uint32_t n) { triangles += n; });
        for (const TileRange& range : cut_mesh(cut).mesh.tiles) drawn += range.triangles;
    }
    check_same(flown.report, report);
    CHECK(flown.uploaded_vertices == vertices);
    CHECK(flown.uploaded_triangles == triangles);
    CHECK(flown.drawn == drawn);
    CHECK(drawn > 1000);
    const View view = view_of(3);
    CHECK(flown.bound_px == bound_error_px(cut, view, false, 1));

    RecursiveMethod method;
    const RecursiveBudget refining{.vertices = 20'000};
    REQUIRE(create_recursive(terrain, refining, memory.span(recursive_bytes(terrain, refining)), method).ok());
    FrameReport refined;
    REQUIRE(update_recursive(method, view, {}, refined).ok());
    CHECK(flown.recursive_triangles == refined.triangles);
    CHECK(refined.triangles > 100);

    const GroundHeight ground = ground_height(terrain, 300.5, 400.25);
    CHECK(flown.ground.inside);
    CHECK(flown.ground.height_m == ground.height_m);
    CHECK(flown.ground.normal.y == ground.normal.y);
    const GroundHit hit = cast_ray(terrain, view.eye_m, view.forward, 1e5);
    CHECK(flown.hit.hit);
    CHECK(flown.hit.distance_m == hit.distance_m);
    CHECK(flown.hit.position_m.z == hit.position_m.z);
    float heights[33 * 33];
    CHECK(flown.patch_error_m == ground_patch(terrain, {-3, 5}, 0, 33, heights).error_m);
    CHECK(std::ranges::equal(flown.heights_m, heights));

    std::vector<std::byte> damaged = pack.file;
    damaged[100] ^= std::byte{1};
    REQUIRE(c_host_fly(damaged.data(), damaged.size(), &memory, &flown) == 1);
    CHECK(std::string_view(flown.failure.field) == "header");
    CHECK(std::string_view(fjell_message(flown.failure.code)) == message(StatusCode::corrupt));
}

TEST_CASE("a host in C streams a pack as a client of its own, and ends where one that has loaded it is") {
    const auto pack = a_pack();
    Memory memory;
    Flown flown;
    REQUIRE(c_host_stream(pack.file.data(), pack.file.size(), &memory, &flown) == 0);
    CHECK(flown.streamed.converged);
    CHECK(flown.streamed.pages_read > 2);
    CHECK(flown.streamed.failed == 0);
    const CutBudget budget{.vertices = 40'000, .triangles = 80'000};
    LiveCut cut;
    REQUIRE(create_cut(pack.terrain, budget, memory.span(cut_bytes(pack.terrain, budget)), cut).ok());
    const View view = view_of(3);
    CutReport report;
    REQUIRE(update_cut(cut, {&view, 1}, {}, report).ok());
    CHECK(report.converged);
    CHECK(flown.report.converged);
    CHECK(flown.report.triangles == report.triangles);
    CHECK(flown.ground.height_m == ground_height(pack.terrain, 300.5, 400.25).height_m);
}

TEST_CASE("the defaults of C are those of C++, and so are all messages and names of fields") {
    check_defaults(fjell_terrain_budget_default(), TerrainBudget{});
    check_defaults(fjell_view_default(), View{});
    const FjellCutBudget cut_budget = fjell_cut_budget_default();
    CHECK(cut_budget.struct_size == sizeof cut_budget);
    CHECK(cut_budget.vertices == CutBudget{}.vertices);
    CHECK(cut_budget.triangles == CutBudget{}.triangles);
    CHECK(cut_budget.segment_triangles == CutBudget{}.segment_triangles);
    CHECK(cut_budget.views == CutBudget{}.views);
    CHECK(cut_budget.workers == CutBudget{}.workers);
    CHECK(cut_budget.morph == CutBudget{}.morph);
    check_defaults(fjell_recursive_budget_default(), RecursiveBudget{});
    const FjellCutSettings cut = fjell_cut_settings_default();
    CHECK(cut.struct_size == sizeof cut);
    CHECK(cut.max_error_px == CutSettings{}.max_error_px);
    CHECK(!cut.corner_safe);
    CHECK(cut.max_work == unlimited_work);
    CHECK(cut.visits == unlimited_work);
    CHECK(cut.morph == FJELL_MORPH_NONE);
    CHECK(cut.morph_s == CutSettings{}.morph_s);
    const FjellRefineSettings refine = fjell_refine_settings_default();
    CHECK((refine.max_error_px == 1 && refine.metric == FJELL_METRIC_ISOTROPIC && refine.cull && !refine.corner_safe));
    const FjellStreamBudget budget = fjell_stream_budget_default();
    CHECK((budget.map_bytes == StreamBudget{}.map_bytes && budget.tail_log2 == StreamBudget{}.tail_log2));
    const FjellStreamSettings stream = fjell_stream_settings_default();
    CHECK((stream.fade_s == StreamSettings{}.fade_s && stream.map_bytes == StreamSettings{}.map_bytes));

    CHECK(fjell_version() == FJELL_VERSION);
    for (int code = 0; code < 256; ++code) {
        const auto text = static_cast<FjellStatusCode>(code);
        CHECK(std::string_view(fjell_message(text)) == message(static_cast<StatusCode>(code)));
        CHECK((std::string_view(fjell_message(text)) == "unknown status") == (code > FJELL_WRONG_TERRAIN));
    }
    for (std::uint32_t bit = 1; bit < 64; bit <<= 1) {
        CHECK(fjell_cut_budget_field(bit) == budget_field(static_cast<CutBudgetBit>(bit)));
        CHECK(fjell_stream_budget_field(bit) == budget_field(static_cast<StreamBudgetBit>(bit)));
    }
}

TEST_CASE("fields that an older host does not know have their defaults, and its reports end where it ends") {
    const auto pack = a_pack();
    Memory memory;
    FjellPack opened;
    REQUIRE(fjell_open_pack(pack.file.data(), pack.file.size(), &opened).code == FJELL_OK);
    FjellTerrain terrain{};
    const std::size_t bytes = fjell_terrain_bytes(&opened.header, nullptr);
    REQUIRE(fjell_load_terrain(&opened, memory.give(&memory, bytes), bytes, &terrain).code == FJELL_OK);

    FjellCutBudget budget = fjell_cut_budget_default();
    budget.vertices = 40'000;
    budget.triangles = 80'000;
    budget.views = 1000; // which that host does not have
    budget.struct_size = offsetof(FjellCutBudget, views);
    const std::size_t needed = fjell_cut_bytes(terrain, &budget);
    REQUIRE(needed == cut_bytes(pack.terrain, {.vertices = 40'000, .triangles = 80'000}));
    FjellLiveCut cut{};
    REQUIRE(fjell_create_cut(terrain, &budget, memory.give(&memory, needed), needed, &cut).code == FJELL_OK);

    // Two views as a host has them whose headers end before error_px.
    constexpr std::size_t known = offsetof(FjellView, max_error_px);
    std::vector<std::byte> views(2 * known);
    FjellView view = fjell_view_default();
    REQUIRE(fjell_make_view({100, 2000, 100}, {1, -1, 1}, {0, 1, 0}, 1, 1280, 720, 1, 1e5, &view).code == FJELL_OK);
    view.struct_size = known;
    view.max_error_px = -1;
    for (const std::size_t at : {std::size_t{0}, known}) std::memcpy(views.data() + at, &view, known);
    const auto* const first = reinterpret_cast<const FjellView*>(views.data());
    FjellCutSettings settings = fjell_cut_settings_default();
    settings.max_work = 0; // likewise
    settings.struct_size = offsetof(FjellCutSettings, max_work);
    FjellCutReport report;
    std::memset(static_cast<void*>(&report), 0x55, sizeof report);
    report.struct_size = offsetof(FjellCutReport, triangles);
    REQUIRE(fjell_update_cut(cut, first, 1, &settings, &report).code == FJELL_OK);
    CHECK(report.work > 0);
    CHECK(report.vertices > 100);
    CHECK(report.triangles == 0x55555555);
    CHECK(report.struct_size == offsetof(FjellCutReport, triangles));
    CHECK(fjell_update_cut(cut, first, 1, &settings, nullptr).code == FJELL_OK);
    const FjellStatus many = fjell_update_cut(cut, first, 2, &settings, &report);
    CHECK(many.code == FJELL_OUT_OF_RANGE);
    CHECK(std::string_view(many.field) == "views (1 to CutBudget::views)");
    for (const std::size_t count : {std::size_t{9}, std::size_t{1} << 60}) // not read
        CHECK(std::string_view(fjell_update_cut(cut, first, count, &settings, &report).field) == many.field);

    // Each view lies where that host has it.
    const View seen[2] = {view_of(0), make_view({1200, 500, 700}, {-1, -1, 0}, {0, 1, 0}, 1, 1280, 720, 1, 1e5)};
    for (std::size_t i = 0; i < 2; ++i) {
        std::memcpy(views.data() + i * known, &known, sizeof known);
        std::memcpy(views.data() + i * known + sizeof known, &seen[i], known - sizeof known);
    }
    CutBudget for_two{.vertices = 40'000, .triangles = 80'000, .views = 2};
    LiveCut expected;
    REQUIRE(create_cut(pack.terrain, for_two, memory.span(cut_bytes(pack.terrain, for_two)), expected).ok());
    CutReport of_two;
    REQUIRE(update_cut(expected, seen, {}, of_two).ok());
    budget = fjell_cut_budget_default();
    budget.vertices = for_two.vertices;
    budget.triangles = for_two.triangles;
    budget.views = 2;
    FjellLiveCut two{};
    const std::size_t more = fjell_cut_bytes(terrain, &budget);
    REQUIRE(fjell_create_cut(terrain, &budget, memory.give(&memory, more), more, &two).code == FJELL_OK);
    report.struct_size = sizeof report;
    REQUIRE(fjell_update_cut(two, first, 2, nullptr, &report).code == FJELL_OK);
    check_same(report, of_two);

    // Of a newer header than the library, or of none.
    for (const std::size_t wrong : {std::size_t{0}, std::size_t{7}, sizeof(FjellCutReport) + 8, ~std::size_t{0}}) {
        const auto refuses = [&](FjellStatus s) {
            CHECK(s.code == FJELL_OUT_OF_RANGE);
            CHECK(std::string_view(s.field) == "struct_size");
        };
        FjellView wrong_view = view;
        FjellCutSettings wrong_settings = settings;
        wrong_view.struct_size = wrong_settings.struct_size = budget.struct_size = report.struct_size = wrong;
        view.struct_size = sizeof view;
        refuses(fjell_update_cut(cut, &wrong_view, 1, nullptr, nullptr));
        refuses(fjell_update_cut(cut, &view, 1, &wrong_settings, nullptr));
        refuses(fjell_update_cut(cut, &view, 1, nullptr, &report));
        refuses(fjell_create_cut(terrain, &budget, nullptr, 0, &cut));
        refuses(fjell_validate_view(&wrong_view));
        refuses(fjell_make_view({}, {1, 0, 0}, {0, 1, 0}, 1, 1, 1, 1, 2, &wrong_view));
        CHECK(fjell_cut_bytes(terrain, &budget) == 0);
    }
}

TEST_CASE("C finds the runs of written slots that for_each_run() visits") {
    Random random(1702);
    using Run = std::pair<std::uint32_t, std::uint32_t>;
    for (int round = 0; round < 2000; ++round) {
        std::uint64_t bits[4];
        std::vector<std::uint32_t> words;
        for (std::uint32_t i = 0; i < 4; ++i) { // few long runs, which touch the ends of words
            const auto random_64 = [&] { return std::uint64_t{random()} << 32 | random(); };
            bits[i] = ~std::uint64_t{0} << (random_64() % 64) ^ ~std::uint64_t{0} << (random_64() % 64);
            if (pick(random, 0, 3) == 0) bits[i] = ~bits[i];
            if (pick(random, 0, 7) == 0) bits[i] = random_64();
            if (pick(random, 0, 4) != 0) words.push_back(i);
        }
        std::vector<Run> expected, found;
        for_each_run(bits, words, [&](std::uint32_t first, std::uint32_t count) {
            expected.push_back({first, count});
        });
        FjellRun run{};
        while (fjell_next_run(bits, words.data(), words.size(), &run)) found.push_back({run.first, run.count});
        REQUIRE(found == expected);
    }
    FjellRun none{};
    CHECK(!fjell_next_run(nullptr, nullptr, 0, &none));
}

TEST_CASE("spans are a pointer and a count in C, also inside what lies in arrays") {
    const auto pack = a_pack();
    FjellPack c;
    REQUIRE(fjell_open_pack(pack.file.data(), pack.file.size(), &c).code == FJELL_OK);
    Pack cpp;
    REQUIRE(open_pack(pack.file, cpp).ok());
    CHECK(c.bytes == cpp.bytes.data());
    CHECK(c.byte_count == cpp.bytes.size());
    CHECK(c.directory == cpp.directory);
    CHECK(std::memcmp(&c.header, &cpp.header, sizeof cpp.header) == 0);
    const MapCommand of_cpp{.map = MapKind::normal,
                            .side_log2 = 3,
                            .from_log2 = 2,
                            .upload_mips = 1,
                            .tile = 4,
                            .layer = 5,
                            .from_layer = 6,
                            .blocks = pack.file};
    FjellMapCommand of_c;
    std::memcpy(&of_c, &of_cpp, sizeof of_c);
    CHECK(of_c.map == FJELL_MAP_NORMAL);
    CHECK(of_c.from_layer == 6);
    CHECK(of_c.blocks == pack.file.data());
    CHECK(of_c.block_bytes == pack.file.size());
}
