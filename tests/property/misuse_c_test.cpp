// misuse_test.cpp through the functions of C, and what only C can get wrong: pointers that are NULL, sizes that no
// header has, enumerators that do not exist. Under sanitizers this is the test of what fjell/fjell_c.h promises.
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include <catch2/catch.hpp>

#include "fjell/fjell_c.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell::test;

namespace {

struct Objects {
    FjellTerrain terrain;
    FjellLiveCut cut;
    FjellStream stream;
    FjellRecursiveMethod method;
    FjellEdits edits;
    FjellGroundMaps maps;
};

class MisuseOfC {
public:
    explicit MisuseOfC(unsigned seed)
        : random_(seed), baked_(bake_and_load(random_dem(random_, 70, 90, Shape::fractal), small_bake(5))) {
        REQUIRE(fjell_open_pack(baked_.file.data(), baked_.file.size(), &pack_).code == FJELL_OK);
        cut_budget_ = fjell_cut_budget_default();
        cut_budget_.vertices = 16'000;
        cut_budget_.triangles = 32'768;
        recursive_budget_ = fjell_recursive_budget_default();
        recursive_budget_.vertices = 4000;
        stream_budget_ = fjell_stream_budget_default();
        stream_budget_.map_bytes = 1u << 22;
        objects_.resize(1); // empty handles
        game_ = begin(of_game_, false);
        objects_.push_back(begin(of_others_, true));
    }

    void call() {
        switch (pick(random_, 0, 9)) {
        case 0: return replace();
        case 1: return query();
        case 2: return pages();
        case 3: return update();
        case 4: return stream();
        case 5: return requests();
        case 6: return read_pack();
        case 7: return create_wrongly();
        case 8: return edit();
        default: return refine();
        }
    }
    // The game that makes no mistakes, beside all that.
    void play() {
        FjellView view = fjell_view_default();
        const double x_m = ++frames_; // metres
        count(fjell_make_view({x_m, 9000, 50}, {0.1, -1, 0.1}, {0, 1, 0}, 1, 640, 480, 1, 1e6, &view));
        FjellCutReport report;
        report.struct_size = sizeof report;
        REQUIRE(fjell_update_cut(game_.cut, &view, 1, nullptr, &report).code == FJELL_OK);
        REQUIRE(report.converged);
        REQUIRE(fjell_cut_mesh(game_.cut).mesh.vertex_count == cut_budget_.vertices);
    }
    std::uint64_t refused = 0, accepted = 0;

private:
    struct Blocks {
        fjell::io::AlignedMemory terrain, cut, method, stream, edits, maps;
    };
    // Memory that is taken once, and used again by whoever comes next.
    static void* in(fjell::io::AlignedMemory& block, std::size_t bytes) {
        if (!block) block = fjell::io::allocate(bytes);
        return block.get();
    }
    Objects begin(Blocks& blocks, bool streamed) {
        const auto ok = [](FjellStatus s) { REQUIRE(s.code == FJELL_OK); };
        Objects o{};
        std::size_t bytes = fjell_terrain_bytes(&pack_.header, nullptr);
        if (streamed)
            ok(fjell_create_terrain(&pack_, nullptr, 0, nullptr, in(blocks.terrain, bytes), bytes, &o.terrain));
        else
            ok(fjell_load_terrain(&pack_, in(blocks.terrain, bytes), bytes, &o.terrain));
        bytes = fjell_cut_bytes(o.terrain, &cut_budget_);
        ok(fjell_create_cut(o.terrain, &cut_budget_, in(blocks.cut, bytes), bytes, &o.cut));
        bytes = fjell_recursive_bytes(o.terrain, &recursive_budget_);
        ok(fjell_create_recursive(o.terrain, &recursive_budget_, in(blocks.method, bytes), bytes, &o.method));
        if (!streamed) return o;
        bytes = fjell_edits_bytes(&pack_.header, nullptr);
        ok(fjell_create_edits(o.terrain, nullptr, in(blocks.edits, bytes), bytes, &o.edits));
        bytes = fjell_ground_maps_bytes(&pack_.header, nullptr);
        ok(fjell_create_ground_maps(o.terrain, nullptr, in(blocks.maps, bytes), bytes, &o.maps));
        bytes = fjell_stream_bytes(&pack_, o.terrain, &stream_budget_);
        ok(fjell_create_stream(&pack_, o.terrain, o.cut, &stream_budget_, in(blocks.stream, bytes), bytes, &o.stream));
        return o;
    }
    const Objects& any() { return objects_[static_cast<std::size_t>(pick(random_, 0, int(objects_.size()) - 1))]; }
    bool one_in(int n) { return pick(random_, 1, n) == 1; }
    template <typename T>
    T* maybe(T* pointer) { // or NULL
        return one_in(6) ? nullptr : pointer;
    }
    template <typename Sized>
    Sized* odd(Sized* sized) { // a size that no header has, or NULL
        if (one_in(8)) sized->struct_size = one_in(2) ? odd_index() : sizeof *sized + 1;
        return maybe(sized);
    }
    double odd_number() {
        constexpr double odd[] = {0,    -1,  1,   1e300,    -1e300,    1e-300, 1e9, 2147483648.0,
                                  1e19, 0.5, NAN, INFINITY, -INFINITY, 1e6,    3.5};
        return one_in(2) ? uniform(random_, -2000, 2000) : odd[pick(random_, 0, std::size(odd) - 1)];
    }
    std::uint32_t odd_index() {
        constexpr std::uint32_t odd[] = {0, 1, 2, 7, 8, 9, 31, 64, 0x7fffffff, 0x80000000, 0xffffffff, 1u << 20};
        return one_in(2) ? static_cast<std::uint32_t>(pick(random_, 0, 40)) : odd[pick(random_, 0, std::size(odd) - 1)];
    }
    std::uint8_t odd_byte() { return static_cast<std::uint8_t>(pick(random_, 0, 255)); }
    FjellVec3 odd_vector() { return {odd_number(), odd_number(), odd_number()}; }
    void count(FjellStatus status) {
        ++(status.code == FJELL_OK ? accepted : refused);
        REQUIRE(std::string_view(fjell_message(status.code)) != "unknown status");
        REQUIRE((status.code == FJELL_OK || std::string_view(status.field) != ""));
    }
    FjellView a_view() {
        FjellView view = fjell_view_default();
        (void)fjell_make_view({uniform(random_, 0, 3000), uniform(random_, 0, 5000), uniform(random_, 0, 3000)},
                              {0.2, -1, 0.1}, {0, 1, 0}, 1, 640, 480, 1, 1e6, &view);
        switch (pick(random_, 0, 6)) {
        case 0: view.eye_m = odd_vector(); break;
        case 1: view.top = odd_number(); break;
        case 2: view.max_error_px = odd_number(); break;
        case 3: view.width_px = odd_index(); break;
        default: break;
        }
        return view;
    }
    FjellCutSettings settings() {
        FjellCutSettings s = fjell_cut_settings_default();
        s.max_work = 500;
        if (one_in(3)) s.max_error_px = odd_number();
        if (one_in(5)) s.morph = odd_byte();
        if (one_in(5)) s.morph_s = odd_number();
        return s;
    }

    // All begin anew in the same memory, or one ends; handles to the old ones are kept.
    void replace() {
        if (objects_.size() > 40) objects_.resize(1);
        if (one_in(3)) return objects_.push_back(begin(of_others_, true));
        const Objects o = any();
        switch (pick(random_, 0, 5)) {
        case 0: return count(fjell_destroy_terrain(o.terrain));
        case 4: return count(fjell_destroy_edits(o.edits));
        case 5: return count(fjell_destroy_ground_maps(o.maps));
        case 1: return count(fjell_destroy_cut(o.cut));
        case 2: return count(fjell_destroy_stream(o.stream));
        default: return count(fjell_destroy_recursive(o.method));
        }
    }
    void query() {
        const FjellTerrain t = any().terrain;
        REQUIRE(fjell_terrain_header(t) != nullptr);
        REQUIRE(fjell_terrain_valid(t) == (fjell_terrain_columns(t) != 0));
        sum_ += fjell_terrain_x_m(t, int(odd_index())) + fjell_terrain_z_m(t, int(odd_index()));
        const FjellGroundHeight ground =
            fjell_ground_height(t, odd_number(), odd_number(), float(uniform(random_, 0, 9)));
        REQUIRE((fjell_terrain_valid(t) || !ground.inside));
        const FjellGroundHit hit = fjell_cast_ray(t, odd_vector(), odd_vector(), odd_number(), 0);
        REQUIRE((fjell_terrain_valid(t) || !hit.hit));
        std::array<float, 100> heights{};
        std::array<bool, 100> holes{};
        const auto given = static_cast<std::size_t>(pick(random_, 0, 100));
        sum_ += fjell_ground_patch(t, {int(odd_index()), int(odd_index())}, int(odd_index()), odd_index(),
                                   maybe(heights.data()), given, maybe(holes.data()), given)
                    .finest;
    }
    void pages() {
        const FjellTerrain t = any().terrain;
        std::array<std::byte, 64> raw{};
        count(fjell_insert_page(t, odd_index(), odd_index(), maybe(raw.data()), odd_index() % 65));
        count(fjell_load_page(maybe(&pack_), {}, odd_index(), odd_index()));
        count(fjell_unload_page({}, odd_index(), odd_index()));
        bool released = false;
        const FjellLiveCut cut = any().cut;
        count(fjell_cut_release_page(cut, odd_index(), odd_index(), maybe(&released)));
        count(fjell_cut_cancel_release(cut, odd_index(), odd_index()));
    }
    void update() {
        const FjellLiveCut cut = any().cut;
        FjellView views[2] = {a_view(), a_view()};
        FjellCutSettings s = settings();
        FjellCutReport report;
        report.struct_size = sizeof report;
        const FjellView* const first = odd(&views[0]);
        // More are refused before they are read; so are views of another size.
        const std::size_t counts[] = {0, 1, 2, 9, 1u << 30};
        const std::size_t given =
            counts[pick(random_, 0, first == nullptr || views[0].struct_size == sizeof(FjellView) ? 2 : 1)];
        const auto change = one_in(5) ? fjell_rebuild_cut : fjell_update_cut;
        count(change(cut, first, given, odd(&s), odd(&report)));
        count(fjell_validate_view(odd(&views[1])));
        sum_ += fjell_corner_factor(&views[1]) > 0 ? 1 : 0;
        sum_ += fjell_make_frustum(odd(&views[1])).offset[0] > 0 ? 1 : 0;
        const FjellCutMesh mesh = fjell_cut_mesh(cut);
        for (std::size_t i = 0; i < mesh.mesh.tile_count; ++i)
            REQUIRE(std::size_t{mesh.mesh.tiles[i].first_index} + mesh.mesh.tiles[i].index_count <=
                    mesh.mesh.index_count);
        const FjellMeshVertex vertex{int(odd_index()), 3, 4};
        const FjellMorphFrame& frame = mesh.frame;
        sum_ += fjell_morphed_height_m(any().terrain, maybe(&vertex), nullptr, maybe(&frame)) > 0 ? 1 : 0;
        sum_ += fjell_bound_cut_error_px(any().cut, odd(&views[1]), true, 1) > 0 ? 1 : 0;
    }
    void stream() {
        const FjellStream stream = any().stream;
        FjellView view = a_view();
        FjellCutSettings cut = settings();
        FjellStreamSettings s = fjell_stream_settings_default();
        if (one_in(3)) s.now_s = odd_number();
        if (one_in(3)) s.texel_px = odd_number();
        FjellStreamReport report;
        report.struct_size = sizeof report;
        const FjellView* const first = odd(&view);
        count(fjell_update_stream(stream, first, 1, odd(&cut), odd(&s), odd(&report)));
        count(fjell_stream_retry_failed(stream));
        std::size_t n = 0;
        (void)fjell_stream_failures(stream, maybe(&n));
        (void)fjell_stream_page_arrivals(stream, maybe(&n));
        (void)fjell_stream_map_commands(stream, maybe(&n));
        const std::uint8_t kind = odd_byte();
        const FjellTileMap* const maps = fjell_stream_tile_maps(stream, kind, &n);
        float out[9];
        count(fjell_min_lod_grid(maps, n, odd_index(), odd_index(), maybe(&out[0])));
        const FjellMapLayers layers = fjell_stream_map_layers(stream, kind);
        sum_ += double(fjell_map_layer_bytes(maybe(&layers), kind) % 7);
    }
    void requests() {
        const FjellStream stream = any().stream;
        FjellStreamRequest request;
        const bool got = fjell_stream_next_request(stream, maybe(&request));
        const std::uint32_t ticket = got && !one_in(4) ? request.ticket : odd_index();
        sum_ += fjell_stream_still_wanted(stream, ticket);
        if (got && !one_in(3))
            count(fjell_stream_provide(stream, ticket, maybe(baked_.file.data() + request.offset),
                                       one_in(4) ? request.bytes / 2 : request.bytes));
        else
            count(fjell_stream_fail(stream, ticket, one_in(2)));
    }
    void read_pack() {
        const FjellChunkId id{static_cast<std::uint32_t>(pick(random_, 0, 9)), odd_index(), odd_index()};
        const std::uint64_t chunk = fjell_chunk_index(maybe(&pack_.header), id);
        REQUIRE((chunk == FJELL_NO_CHUNK || chunk < fjell_chunk_count(&pack_.header)));
        std::vector<std::byte> out(one_in(2) ? odd_index() % 5000 : fjell_chunk_raw_bytes(&pack_.header, id));
        count(fjell_read_chunk(maybe(&pack_), id, maybe(out.data()), out.size()));
        const FjellChunkEntry entry = fjell_pack_entry(maybe(&pack_), odd_index());
        count(fjell_decode_chunk(maybe(&entry), maybe(baked_.file.data()), odd_index() % 3000, out.data(), out.size()));
        sum_ += fjell_chunk_id(maybe(&pack_.header), odd_index()).tile;
        FjellPack pack;
        const std::size_t bytes = odd_index() % baked_.file.size();
        count(fjell_open_pack(maybe(baked_.file.data()), bytes, maybe(&pack)));
        count(fjell_open_index(maybe(baked_.file.data()), bytes, nullptr, odd_index(), odd_index(), maybe(&pack)));
        FjellPackHeader header;
        count(fjell_read_header(maybe(baked_.file.data()), bytes, baked_.file.size(), maybe(&header)));
        count(fjell_check_ranges(maybe(&pack_.header)));
        std::array<std::uint8_t, 48> texels{};
        count(fjell_decode_colour(maybe(baked_.file.data()), 8, one_in(2) ? 4 : odd_index(), maybe(texels.data()), 48));
        count(
            fjell_decode_normal(maybe(baked_.file.data()), 16, one_in(2) ? 4 : odd_index(), maybe(texels.data()), 32));
    }
    void create_wrongly() {
        const FjellTerrain t = any().terrain;
        alignas(64) std::array<std::byte, 256> little;
        FjellCutBudget budget = cut_budget_;
        if (one_in(2)) budget.vertices = odd_index();
        if (one_in(4)) budget.views = odd_index();
        FjellLiveCut cut{};
        const FjellCutBudget* const given = odd(&budget);
        sum_ += double(fjell_cut_bytes(t, given) % 7);
        count(fjell_create_cut(t, given, maybe(little.data()), sizeof little, maybe(&cut)));
        REQUIRE((cut.object == nullptr && cut.identity == 0));
        FjellStreamBudget streaming = stream_budget_;
        if (one_in(2)) streaming.tail_log2 = odd_index();
        FjellStream stream{};
        sum_ += double(fjell_stream_bytes(maybe(&pack_), t, odd(&streaming)) % 7);
        count(fjell_create_stream(maybe(&pack_), t, any().cut, odd(&streaming), nullptr, odd_index(), maybe(&stream)));
        sum_ += fjell_map_layers(maybe(&pack_.header), odd(&streaming), odd_byte()).tail_log2;
        FjellRecursiveBudget refining = recursive_budget_;
        refining.indices = odd_index();
        FjellRecursiveMethod method{};
        count(fjell_create_recursive(t, odd(&refining), little.data(), sizeof little, maybe(&method)));
        FjellTerrainBudget slots = fjell_terrain_budget_default();
        slots.page_slots = odd_index();
        FjellTerrain none{};
        count(fjell_create_terrain(maybe(&pack_), maybe(baked_.file.data()), odd_index() % 100, odd(&slots),
                                   maybe(little.data()), sizeof little, maybe(&none)));
        count(fjell_load_terrain(maybe(&pack_), maybe(little.data()), sizeof little, maybe(&none)));
        REQUIRE(!fjell_terrain_valid(none));
    }
    void edit() {
        const FjellEdits edits = any().edits;
        FjellStamp stamp = fjell_stamp_default();
        stamp.shape = one_in(4) ? odd_byte() : std::uint32_t{FJELL_STAMP_SHAPE_CRATER};
        stamp.x_m = one_in(3) ? odd_number() : uniform(random_, 0, 2000);
        stamp.z_m = one_in(3) ? odd_number() : uniform(random_, 0, 2000);
        stamp.radius_m = one_in(4) ? static_cast<float>(odd_number()) : 100;
        stamp.amount_m = one_in(4) ? static_cast<float>(odd_number()) : 10;
        if (one_in(3)) stamp.morph_s = one_in(4) ? static_cast<float>(odd_number()) : 0.1f;
        if (one_in(3)) stamp.shape = FJELL_STAMP_SHAPE_PAINT, stamp.material = odd_byte();
        if (one_in(4)) stamp.strength = static_cast<float>(odd_number());
        if (one_in(6)) stamp.point_count = odd_index();                            // of NULL
        if (one_in(6)) stamp.columns = stamp.rows = static_cast<int>(odd_index()); // without heights or mask
        std::uint64_t id = odd_index();
        count(fjell_push_stamp(edits, odd(&stamp), maybe(&id)));
        sum_ += fjell_stamp_state(any().edits, id).state;
        FjellView view = a_view();
        FjellEditSettings s = fjell_edit_settings_default();
        s.max_work = 50;
        s.now_s = one_in(4) ? odd_number() : frames_;
        FjellEditReport report;
        report.struct_size = sizeof report;
        count(fjell_update_edits(any().edits, odd(&view), 1, odd(&s), odd(&report)));
        std::uint64_t cursor = odd_index();
        bool lost = false;
        FjellGroundRect rects[3];
        REQUIRE(fjell_take_ground_changes(any().edits, maybe(&cursor), maybe(rects), 3, maybe(&lost)) <= 3);
        FjellEditBudget budget = fjell_edit_budget_default();
        budget.blocks = odd_index();
        sum_ += double(fjell_edits_bytes(maybe(&pack_.header), odd(&budget)) % 7);
        alignas(64) std::array<std::byte, 64> little;
        count(fjell_create_edits(any().terrain, odd(&budget), maybe(little.data()), sizeof little, nullptr));
        FjellGroundMapsBudget map_budget = fjell_ground_maps_budget_default();
        map_budget.texels = odd_index();
        sum_ += double(fjell_ground_maps_bytes(maybe(&pack_.header), odd(&map_budget)) % 7);
        FjellGroundMaps none{};
        count(fjell_create_ground_maps(any().terrain, odd(&map_budget), maybe(little.data()), sizeof little,
                                       maybe(&none)));
        FjellMapCommand command{};
        command.tile = odd_index(), command.map = static_cast<FjellMapKind>(odd_byte());
        const FjellGroundMaps maps = any().maps;
        count(fjell_note_map_commands(maps, maybe(&command), 1));
        std::size_t shown = 0;
        const FjellTileMap* const normals = fjell_stream_tile_maps(any().stream, FJELL_MAP_NORMAL, &shown);
        FjellGroundMapsReport made;
        made.struct_size = sizeof made;
        count(fjell_update_ground_maps(maps, maybe(normals), shown, odd(&made)));
        REQUIRE((fjell_ground_map_patches(maps, maybe(&shown)) == nullptr || shown < 10'000));
        std::byte mip[64 * 64];
        bool changed = false;
        cursor = odd_index();
        FjellPaint copy{};
        count(fjell_paint_map(any().terrain, odd_byte(), odd_index(), odd_index(), maybe(mip),
                              one_in(2) ? sizeof mip : odd_index() % sizeof mip, maybe(&changed)));
        sum_ +=
            fjell_take_paint_changes(any().terrain, maybe(&cursor), maybe(rects), one_in(2) ? 2 : 0, maybe(&changed));
        sum_ += double(fjell_paint_bytes(any().terrain) % 7);
        count(fjell_copy_paint(any().terrain, maybe(little.data()), sizeof little, maybe(&copy)));
        count(fjell_paint_map_of(copy, odd_byte(), odd_index(), odd_index(), maybe(mip), sizeof mip, nullptr));
    }
    void refine() {
        const FjellRecursiveMethod method = any().method;
        FjellRefineSettings s = fjell_refine_settings_default();
        if (one_in(3)) s.max_error_px = odd_number();
        if (one_in(3)) s.metric = odd_byte();
        if (one_in(3)) s.topology = odd_byte();
        FjellView view = a_view();
        FjellFrameReport report;
        report.struct_size = sizeof report;
        count(fjell_update_recursive(method, odd(&view), odd(&s), odd(&report)));
        view.struct_size = sizeof view;
        const FjellMeshView mesh = fjell_recursive_mesh(method);
        sum_ += double(fjell_measure_error(any().terrain, maybe(&mesh), odd(&view), nullptr).samples % 7);
        sum_ += fjell_bound_recursive_error_px(any().method, odd(&view), false, 1) > 0 ? 1 : 0;
    }

    Random random_;
    fjell::io::LoadedPack baked_;
    FjellPack pack_;
    FjellCutBudget cut_budget_;
    FjellRecursiveBudget recursive_budget_;
    FjellStreamBudget stream_budget_;
    Blocks of_game_, of_others_;
    Objects game_{};
    std::vector<Objects> objects_;
    double frames_ = 0;
    double sum_ = 0;
};

} // namespace

TEST_CASE("no misuse of the library from C crashes, and what is used rightly goes on") {
    MisuseOfC misuse(1705);
    for (int i = 0; i < rounds(1500, 60'000); ++i) {
        misuse.call();
        if (i % 50 == 0) misuse.play();
    }
    CHECK(misuse.refused > misuse.accepted / 4); // a test of misuse that is all accepted would test nothing
    CHECK(misuse.accepted > 0);
}
