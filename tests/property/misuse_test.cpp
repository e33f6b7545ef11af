// What a host may get wrong: handles that are empty, moved, destroyed, of other objects or of memory used anew, numbers
// that are none or far out. Every call answers with a status or with nothing, none crashes, and what is used rightly
// beside it goes on as if nothing had happened. Under sanitizers this is the test of what the headers promise.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include <catch2/catch.hpp>

#include "fjell/compact.h"
#include "fjell/fjell.h"
#include "fjell/io/failure.h"
#include "fjell/io/live_terrain.h"
#include "fjell/pack_set.h"
#include "support/cut_check.h"
#include "support/patience.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

using Block = std::pair<io::AlignedMemory, std::size_t>;
std::span<std::byte> span_of(const Block& block) {
    return {block.first.get(), block.second};
}
Block make_block(std::size_t bytes) {
    return {io::allocate(bytes), bytes};
}

// A number that a caller might pass by mistake.
double odd_number(Random& random) {
    constexpr double odd[] = {0,    -1,       1,         1e300, -1e300, 1e-300,
                              NAN,  INFINITY, -INFINITY, 1e9,   -1e9,   2147483648.0,
                              1e19, -1e19,    0.5,       1e6,   3.5,    std::numeric_limits<float>::max()};
    return pick(random, 0, 2) == 0 ? uniform(random, -2000, 2000) : odd[pick(random, 0, std::size(odd) - 1)];
}
std::uint32_t odd_index(Random& random) {
    constexpr std::uint32_t odd[] = {0, 1, 2, 3, 5, 31, 64, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff, 1u << 20};
    return pick(random, 0, 1) == 0 ? static_cast<std::uint32_t>(pick(random, 0, 40))
                                   : odd[pick(random, 0, std::size(odd) - 1)];
}
Vec3 odd_vector(Random& random) {
    return {odd_number(random), odd_number(random), odd_number(random)};
}
float odd_float(Random& random) {
    const double d = odd_number(random);
    return std::abs(d) > 3e38 && std::isfinite(d) ? std::numeric_limits<float>::infinity() : static_cast<float>(d);
}

void last_first(void*, std::uint32_t count, void (*job)(void* data, std::uint32_t index), void* data) {
    while (count-- > 0) job(data, count);
}

// One engine's worth of objects, each in a block of its own that stays when the object goes.
struct Engine {
    const Pack* pack = nullptr;
    Block terrain_block, cut_block, stream_block, recursive_block;
    Terrain terrain;
    LiveCut cut;
    Stream stream;
    RecursiveMethod recursive;
};

constexpr CutBudget cut_budget{.vertices = 16'000, .triangles = 32'768, .segment_triangles = 8, .workers = 3};
constexpr RecursiveBudget recursive_budget{4000, 16000};
constexpr StreamBudget stream_budget{.page_requests = 4, .map_requests = 2, .map_bytes = 1u << 22};

class Misuse {
public:
    explicit Misuse(unsigned seed) : random_(seed) {
        for (int i = 0; i < 2; ++i) {
            packs_[i] = bake_and_load(random_dem(random_, 70 + 30 * i, 90, Shape::fractal), small_bake(5 + i));
            right_[i] = make_engine(packs_[i].pack, true);
        }
        keep(Terrain{}, LiveCut{}, Stream{}, RecursiveMethod{});
        for (Engine& e : right_) keep(e.terrain, e.cut, e.stream, e.recursive);
        game_ = make_engine(packs_[0].pack, false);
        REQUIRE(load_terrain(packs_[0].pack, span_of(game_.terrain_block), game_.terrain).ok());
        REQUIRE(create_cut(game_.terrain, cut_budget, span_of(game_.cut_block), game_.cut).ok());
        view_ = random_view(random_, game_.terrain);
        expected_ = ground_height(game_.terrain, 30, 40).height_m;
    }

    void call() {
        switch (pick(random_, 0, 13)) {
        case 0: return replace();
        case 1: return ask_terrain();
        case 2: return query();
        case 3: return move_pages();
        case 4: return update();
        case 5: return mesh();
        case 6: return stream();
        case 7: return requests();
        case 8: return read_pack();
        case 9: return decode();
        case 10: return create_wrongly();
        case 11: return lods();
        case 12: return make_set();
        default: return refine();
        }
    }

    // The game that makes no mistakes, beside all that.
    void play() {
        view_.eye_m = view_.eye_m + Vec3{1, 0, 1};
        CutReport report;
        REQUIRE(update_cut(game_.cut, {&view_, 1}, {}, report).ok());
        REQUIRE(report.converged);
        REQUIRE(ground_height(game_.terrain, 30, 40).height_m == expected_);
        REQUIRE(cut_mesh(game_.cut).mesh.vertices.size() == cut_budget.vertices);
    }

    std::uint64_t refused = 0, accepted = 0;

private:
    Engine make_engine(const Pack& pack, bool whole) {
        Engine e;
        e.pack = &pack;
        e.terrain_block = make_block(terrain_bytes(pack.header));
        Terrain sized;
        REQUIRE(create_terrain(pack, {}, span_of(e.terrain_block), sized).ok());
        e.cut_block = make_block(cut_bytes(sized, cut_budget));
        e.stream_block = make_block(stream_bytes(pack, sized, stream_budget));
        e.recursive_block = make_block(recursive_bytes(sized, recursive_budget));
        if (whole) begin(e);
        return e;
    }
    void begin(Engine& e) {
        REQUIRE(create_terrain(*e.pack, {}, span_of(e.terrain_block), e.terrain).ok());
        REQUIRE(create_cut(e.terrain, cut_budget, span_of(e.cut_block), e.cut).ok());
        REQUIRE(create_stream(*e.pack, e.terrain, e.cut, stream_budget, span_of(e.stream_block), e.stream).ok());
        REQUIRE(create_recursive(e.terrain, recursive_budget, span_of(e.recursive_block), e.recursive).ok());
    }
    void keep(Terrain t, LiveCut c, Stream s, RecursiveMethod r) {
        terrains_.push_back(t);
        cuts_.push_back(c);
        streams_.push_back(s);
        recursives_.push_back(r);
    }
    template <typename T>
    const T& any(const std::vector<T>& of) {
        return of[static_cast<std::size_t>(pick(random_, 0, static_cast<int>(of.size()) - 1))];
    }
    const Pack& any_pack() {
        const int which = pick(random_, 0, 3);
        return which == 0 ? empty_ : packs_[which % 2].pack;
    }
    void count(const Status& status) {
        ++(status.ok() ? accepted : refused);
        REQUIRE(std::string_view(message(status.code)) != "unknown status");
        if (!status.ok()) REQUIRE(std::string_view(status.field) != "");
    }
    View any_view() {
        View view = random_view(random_, game_.terrain);
        switch (pick(random_, 0, 5)) {
        case 0: view.eye_m = odd_vector(random_); break;
        case 1: view.forward = odd_vector(random_); break;
        case 2: view.top = odd_number(random_); break;
        case 3: view.left = odd_number(random_); break;
        case 4: view.max_error_px = odd_number(random_); break;
        default: break;
        }
        return view;
    }
    CutSettings any_settings() {
        CutSettings s{.max_work = 500};
        if (pick(random_, 0, 2) == 0) s.max_error_px = odd_number(random_);
        if (pick(random_, 0, 5) == 0) s.hysteresis = odd_number(random_);
        if (pick(random_, 0, 5) == 0) s.offscreen_factor = odd_number(random_);
        if (pick(random_, 0, 5) == 0) s.morph = Morph::time, s.morph_s = odd_number(random_);
        if (pick(random_, 0, 5) == 0) s.now_s = odd_number(random_);
        if (pick(random_, 0, 1) == 0) s.jobs = {last_first, nullptr};
        return s;
    }

    // Some object ends, or all begin anew in the same memory; handles to the old ones are kept.
    void replace() {
        Engine& e = right_[pick(random_, 0, 1)];
        switch (pick(random_, 0, 5)) {
        case 0: count(destroy_terrain(e.terrain)); break;
        case 1: count(destroy_cut(e.cut)); break;
        case 2: count(destroy_stream(e.stream)); break;
        case 3: count(destroy_recursive(e.recursive)); break;
        default: break;
        }
        if (pick(random_, 0, 3) != 0) return;
        begin(e);
        if (terrains_.size() > 60) terrains_.resize(1), cuts_.resize(1), streams_.resize(1), recursives_.resize(1);
        keep(e.terrain, e.cut, e.stream, e.recursive);
    }
    void ask_terrain() {
        const Terrain t = any(terrains_);
        const std::int32_t at = static_cast<std::int32_t>(odd_index(random_));
        sum_ += t.x_m(at) + t.z_m(at) + t.extent_x_m() + t.extent_z_m() + t.spacing_x_m() + t.spacing_z_m() +
                static_cast<double>(t.header().columns + t.columns() + t.rows() + t.tile_count() + t.page_count()) +
                t.missing_px() + (t.has_voids() ? 1 : 0);
        REQUIRE(t.pages_loaded() + t.pages_missing() == t.page_count());
        REQUIRE(t.pages_loaded() <= t.page_slots());
        REQUIRE(t.valid() == (t.columns() != 0));
    }
    void query() {
        const Terrain t = any(terrains_);
        const GroundHeight ground = ground_height(t, odd_number(random_), odd_number(random_), odd_float(random_));
        REQUIRE((t.valid() || !ground.inside));
        REQUIRE(std::isfinite(ground.height_m));
        const GroundHit hit =
            cast_ray(t, odd_vector(random_), odd_vector(random_), odd_number(random_), odd_float(random_));
        REQUIRE((t.valid() || !hit.hit));
        std::array<float, 100> heights{};
        std::array<bool, 100> holes{};
        const SampleIndex first{static_cast<std::int32_t>(odd_index(random_)),
                                static_cast<std::int32_t>(odd_index(random_))};
        const auto given = static_cast<std::size_t>(pick(random_, 0, 100));
        const GroundPatch patch = ground_patch(t, first, static_cast<int>(odd_index(random_)), odd_index(random_),
                                               std::span(heights).first(given), std::span(holes).first(given));
        REQUIRE((t.valid() || std::isinf(patch.error_m)));
    }
    // As a host may that streams nothing: of a stream's terrain only the stream moves pages.
    void move_pages() {
        const Terrain t = any(terrains_);
        const std::uint32_t tile = odd_index(random_), page = odd_index(random_);
        std::array<std::byte, 64> raw{};
        for (std::byte& b : raw) b = static_cast<std::byte>(pick(random_, 0, 255));
        if (pick(random_, 0, 1))
            count(insert_page(t, tile, page, std::span(raw).first(static_cast<std::size_t>(pick(random_, 0, 64)))));
        if (pick(random_, 0, 3) == 0) count(load_page(any_pack(), t, tile, page));
        const bool of_a_stream = t == right_[0].terrain || t == right_[1].terrain;
        if (!of_a_stream || tile >= t.tile_count() || page >= t.pages_per_tile()) count(unload_page(t, tile, page));
    }
    void update() {
        const LiveCut cut = any(cuts_);
        const View views[3] = {any_view(), any_view(), any_view()};
        CutReport report;
        const auto some = std::span(views).first(static_cast<std::size_t>(pick(random_, 0, 3)));
        count(pick(random_, 0, 5) == 0 ? rebuild_cut(cut, some, any_settings(), report)
                                       : update_cut(cut, some, any_settings(), report));
        bool released = false;
        count(cut_release_page(cut, odd_index(random_), odd_index(random_), released));
        count(cut_cancel_release(cut, odd_index(random_), odd_index(random_)));
    }
    void mesh() {
        const LiveCut cut = any(cuts_);
        const CutMesh mesh = cut_mesh(cut);
        for (const TileRange& range : mesh.mesh.tiles)
            REQUIRE(std::size_t{range.first_index} + range.index_count <= mesh.mesh.indices.size());
        const MorphFrame frame = mesh.frame;
        const MeshVertex vertex{static_cast<std::int32_t>(odd_index(random_)), 3, odd_float(random_)};
        sum_ += morphed_height_m(any(terrains_), vertex, {}, frame) > 0 ? 1 : 0;
        compact(mesh);
    }
    // Numbers that no cut has, in arrays of different lengths.
    void compact(const CutMesh& mesh) {
        std::array<MeshVertex, 40> vertices;
        std::array<MorphVertex, 40> morphs;
        for (MeshVertex& v : vertices) v = {static_cast<std::int32_t>(odd_index(random_)), -1, odd_float(random_)};
        for (MorphVertex& m : morphs)
            m = {odd_float(random_), odd_float(random_), odd_float(random_), odd_float(random_)};
        constexpr CompactVertex untouched{1, 2, 3, 4, 5, 6, 7};
        std::array<CompactVertex, 40> to;
        to.fill(untouched);
        const auto some = [&](auto& of) { return std::span(of).first(static_cast<std::size_t>(pick(random_, 0, 40))); };
        const auto from = some(vertices);
        const auto with = some(morphs);
        const auto into = some(to);
        compact_vertices(from, with, into);
        const std::size_t written = std::min({from.size(), with.empty() ? from.size() : with.size(), into.size()});
        for (std::size_t i = 0; i < to.size(); ++i) {
            const float height_m = i < written ? vertices[i].height_m : untouched.height_m;
            REQUIRE(std::memcmp(&to[i].height_m, &height_m, sizeof height_m) == 0); // exact, also where it is NaN
        }
        std::array<std::uint16_t, 40> small{};
        compact_indices(mesh.mesh.indices, some(small));
        sum_ += compact_share({odd_float(random_), 0, 0, odd_float(random_), odd_float(random_)}) > 0 ? 1 : 0;
        const auto code = static_cast<std::uint16_t>(odd_index(random_));
        sum_ += compact_rise_m(code) > 0 ? 1 : 0;
        REQUIRE(compact_length_m(code) >= 0);
    }
    void make_set() {
        std::array<SetPart, 3> parts;
        for (SetPart& part : parts) {
            part.pack = pick(random_, 0, 9) == 0 ? nullptr : &any_pack();
            part.corners = std::span(packs_[0].file).first(odd_index(random_) % 3000);
            part.tile_x = odd_index(random_), part.tile_y = pick(random_, 0, 1) ? 0 : odd_index(random_);
        }
        const auto some = std::span(parts).first(static_cast<std::size_t>(pick(random_, 0, 3)));
        const PackHeader& h = packs_[0].pack.header;
        const bool right = some.size() == 1 && pick(random_, 0, 1) == 0;
        if (right) {
            const ChunkEntry corners = packs_[0].pack.entry(chunk_index(h, {ChunkKind::corners, 0, 0}));
            parts[0] = {&packs_[0].pack, std::span(packs_[0].file).subspan(corners.offset, corners.stored_bytes), 0, 0};
        }
        const SetShape shape = right || pick(random_, 0, 1) ? SetShape{h.columns, h.rows}
                                                            : SetShape{odd_index(random_), odd_index(random_)};
        const std::size_t needed = set_index_bytes(shape, some);
        const Block memory = make_block(needed < (1u << 20) ? needed : 64);
        SetIndex index;
        std::uint32_t at_fault = 77;
        const Status s = make_set_index(shape, some, span_of(memory), index, at_fault);
        count(s);
        REQUIRE((s.ok() || (!right && at_fault <= some.size() && index.header.empty())));
        std::uint64_t in_part = 0;
        REQUIRE(set_part_at(some, odd_index(random_), in_part) <= some.size());
    }
    void stream() {
        const Stream stream = any(streams_);
        const View view = any_view();
        StreamSettings settings;
        if (pick(random_, 0, 3) == 0) settings.lookahead_s = odd_number(random_);
        if (pick(random_, 0, 3) == 0) settings.now_s = odd_number(random_);
        if (pick(random_, 0, 3) == 0) settings.texel_px = odd_number(random_);
        StreamReport report;
        count(update_stream(stream, {&view, static_cast<std::size_t>(pick(random_, 0, 1))}, any_settings(), settings,
                            report));
        count(stream_retry_failed(stream));
        sum_ += static_cast<double>(stream_failures(stream).size() + stream_page_arrivals(stream).size() +
                                    stream_map_commands(stream).size());
    }
    void requests() {
        const Stream stream = any(streams_);
        StreamRequest request;
        const bool got = stream_next_request(stream, request);
        REQUIRE((!got || request.bytes != 0));
        const std::uint32_t ticket = got && pick(random_, 0, 3) ? request.ticket : odd_index(random_);
        sum_ += stream_still_wanted(stream, ticket) ? 1 : 0;
        const std::span<const std::byte> file = packs_[pick(random_, 0, 1)].file;
        const std::size_t from = std::min<std::size_t>(got ? request.offset : odd_index(random_), file.size());
        const std::size_t bytes = std::min<std::size_t>(got ? request.bytes : odd_index(random_), file.size() - from);
        if (pick(random_, 0, 3))
            count(stream_provide(stream, ticket, file.subspan(from, pick(random_, 0, 3) ? bytes : bytes / 2)));
        else
            count(stream_fail(stream, ticket, pick(random_, 0, 1) != 0));
    }
    void read_pack() {
        const Pack& pack = any_pack();
        const ChunkId id{static_cast<ChunkKind>(pick(random_, 0, 9)), odd_index(random_), odd_index(random_)};
        const std::uint64_t chunk = chunk_index(pack.header, id);
        const std::size_t bytes = chunk_raw_bytes(pack.header, id);
        REQUIRE((chunk == no_chunk) == (bytes == 0));
        if (chunk != no_chunk) {
            REQUIRE(chunk < chunk_count(pack.header));
            const ChunkId back = chunk_id(pack.header, chunk);
            REQUIRE((back.kind == id.kind && back.tile == id.tile && back.item == id.item));
        }
        const std::uint64_t number = odd_index(random_) * (std::uint64_t{1} << pick(random_, 0, 32));
        REQUIRE((chunk_id(pack.header, number).tile == 0xffffffff) == (number >= chunk_count(pack.header)));
        const ChunkEntry entry = pack.entry(number);
        REQUIRE((number < pack.header.directory_count || entry.stored_bytes == 0));
        std::vector<std::byte> out(chunk == no_chunk || pick(random_, 0, 2) == 0 ? odd_index(random_) % 5000
                                                                                 : pack.entry(chunk).raw_bytes);
        count(read_chunk(pack, id, out));
        count(decode_chunk(entry, std::span(packs_[0].file).first(odd_index(random_) % 3000), out));
    }
    void decode() {
        std::vector<std::byte> blocks(pick(random_, 0, 1) ? odd_index(random_) % 5000 : std::size_t{4} * 16);
        std::vector<std::uint8_t> texels(pick(random_, 0, 1) ? odd_index(random_) % 5000 : std::size_t{16} * 3);
        const std::uint32_t side = pick(random_, 0, 1) ? odd_index(random_) : 4;
        count(decode_colour(blocks, side, texels));
        count(decode_normal(blocks, side, texels));
    }
    void create_wrongly() {
        const Engine& e = right_[pick(random_, 0, 1)];
        const Terrain t = any(terrains_);
        CutBudget budget = cut_budget;
        if (pick(random_, 0, 1)) budget.vertices = odd_index(random_);
        if (pick(random_, 0, 3) == 0) budget.triangles = odd_index(random_);
        if (pick(random_, 0, 3) == 0) budget.segment_triangles = odd_index(random_);
        if (pick(random_, 0, 3) == 0) budget.views = odd_index(random_);
        if (pick(random_, 0, 3) == 0) budget.workers = odd_index(random_);
        const std::size_t needed = cut_bytes(t, budget);
        std::array<std::byte, 256> little;
        LiveCut cut;
        count(create_cut(t, budget, std::span(little).subspan(1), cut));
        REQUIRE(cut == LiveCut{});
        REQUIRE((needed == 0) == (create_cut(t, budget, {}, cut).code != StatusCode::memory_too_small));
        StreamBudget streaming = stream_budget;
        if (pick(random_, 0, 1)) streaming.page_requests = odd_index(random_);
        if (pick(random_, 0, 1)) streaming.tail_log2 = odd_index(random_);
        sum_ += static_cast<double>(stream_bytes(any_pack(), t, streaming) % 7);
        Stream stream;
        count(create_stream(any_pack(), t, any(cuts_), streaming, {}, stream));
        RecursiveBudget refining{odd_index(random_), odd_index(random_)};
        sum_ += static_cast<double>(recursive_bytes(t, refining) % 7);
        RecursiveMethod method;
        count(create_recursive(t, refining, std::span(little).subspan(1), method));
        PackHeader header = e.pack->header;
        header.tile_log2 = odd_index(random_);
        header.tiles_x = odd_index(random_);
        sum_ += static_cast<double>(terrain_bytes(header, {odd_index(random_)}) % 7);
        Pack forged = *e.pack;
        forged.header = header;
        Terrain none;
        count(create_terrain(forged, {odd_index(random_)}, std::span(little).subspan(1), none));
        count(create_terrain(empty_, {}, span_of(game_.recursive_block), none));
        REQUIRE(!none.valid());
        const std::span<const std::byte> file = packs_[0].file;
        Pack pack;
        count(open_pack(file.first(odd_index(random_) % file.size()), pack));
    }
    void lods() {
        const Stream stream = any(streams_);
        const auto kind = static_cast<MapKind>(pick(random_, 0, 255));
        const std::span<const TileMap> maps = stream_tile_maps(stream, kind);
        sum_ += stream_map_layers(stream, kind).tail_log2;
        float out[9];
        count(min_lod_grid(maps, odd_index(random_), odd_index(random_), out));
        const std::array<TileMap, 12> some{};
        count(min_lod_grid(some, odd_index(random_), odd_index(random_), out));
    }
    void refine() {
        const RecursiveMethod method = any(recursives_);
        RefineSettings settings;
        if (pick(random_, 0, 2) == 0) settings.max_error_px = odd_number(random_);
        if (pick(random_, 0, 2) == 0) settings.metric = Metric::depth, settings.cull = pick(random_, 0, 1) != 0;
        FrameReport report;
        count(update_recursive(method, any_view(), settings, report));
        const MeshView mesh = recursive_mesh(method);
        const Terrain t = any(terrains_);
        const MeasuredError error = measure_error(t, mesh, any_view());
        REQUIRE((t.valid() || error.samples == 0));
    }

    Random random_;
    const Pack empty_{};
    io::LoadedPack packs_[2];
    Engine right_[2], game_;
    std::vector<Terrain> terrains_;
    std::vector<LiveCut> cuts_;
    std::vector<Stream> streams_;
    std::vector<RecursiveMethod> recursives_;
    View view_;
    double expected_ = 0, sum_ = 0;
};

} // namespace

TEST_CASE("no misuse of the library crashes, and what is used rightly goes on") {
    Misuse misuse(1402);
    for (int i = 0; i < rounds(3000, 100'000); ++i) {
        misuse.call();
        if (i % 50 == 0) misuse.play();
    }
    CHECK(misuse.refused > misuse.accepted / 4); // a test of misuse that is all accepted would test nothing
    CHECK(misuse.accepted > 0);
}

TEST_CASE("no misuse of the terrain in one object crashes, and it goes on once it is used rightly") {
    Random random(1404);
    const auto pack = bake_and_load(random_dem(random, 90, 70, Shape::fractal), small_bake(5));
    io::LiveOptions good;
    good.cut = cut_budget, good.stream = stream_budget;
    const auto odd_capacity = [&] {
        constexpr std::uint32_t odd[] = {0, 1, 2, 31, 64, 4096, 0x80000000, 0xffffffff};
        return odd[pick(random, 0, std::size(odd) - 1)];
    };
    int refused = 0, accepted = 0;
    // Whatever is wrong is one line that blames the input.
    const auto attempt = [&](const auto& what) {
        try {
            what();
            ++accepted;
        } catch (const io::Failure& failure) {
            ++refused;
            const std::string_view line = failure.what();
            REQUIRE((failure.exit_code == 1 && !line.empty() && line.find('\n') == std::string_view::npos));
        }
    };
    io::LiveTerrain live(pack.file, "in memory", good);
    double now_s = 0;
    for (int i = 0; i < rounds(200, 5000); ++i) {
        attempt([&] { // opened wrongly, and closed in any frame
            io::LiveOptions options = good;
            if (pick(random, 0, 3) == 0) options.page_slots = odd_capacity();
            if (pick(random, 0, 3) == 0) options.cut.vertices = odd_capacity();
            if (pick(random, 0, 3) == 0) options.cut.views = odd_index(random);
            if (pick(random, 0, 3) == 0) options.cut.workers = odd_index(random);
            if (pick(random, 0, 3) == 0) options.stream.page_requests = odd_index(random);
            if (pick(random, 0, 3) == 0) options.stream.map_bytes = odd_capacity();
            const std::size_t bytes = pick(random, 0, 3) == 0 ? odd_index(random) % pack.file.size() : pack.file.size();
            io::LiveTerrain other(std::span(pack.file).first(bytes), "other", options);
            const View view = random_view(random, other.terrain());
            for (int frames = pick(random, 0, 2); frames > 0; --frames) (void)other.update({&view, 1}, frames);
        });
        attempt([&] {
            View views[9];
            for (View& view : views) view = random_view(random, live.terrain());
            if (pick(random, 0, 2) == 0) views[0].eye_m = odd_vector(random);
            if (pick(random, 0, 2) == 0) views[1].max_error_px = odd_number(random);
            live.settings = good.settings;
            if (pick(random, 0, 3) == 0) live.settings.cut.max_error_px = odd_number(random);
            if (pick(random, 0, 3) == 0) live.settings.cut.hysteresis = odd_number(random);
            if (pick(random, 0, 3) == 0) live.settings.stream.texel_px = odd_number(random);
            if (pick(random, 0, 1) == 0) live.settings.cut.jobs = {last_first, nullptr};
            const auto given = static_cast<std::size_t>(pick(random, 0, 1) ? 1 : pick(random, 0, 9));
            (void)live.update(std::span(views).first(given), pick(random, 0, 3) ? now_s += 0.02 : odd_number(random));
        });
        (void)live.tile_maps(static_cast<MapKind>(pick(random, 0, 255)));
        if (pick(random, 0, 1)) (void)live.take_map_commands();
        if (pick(random, 0, 1)) (void)live.take_changes();
        REQUIRE(live.frame().short_of.size() <= 10);
    }
    CHECK(refused > accepted / 4);
    CHECK(accepted > 0);
    live.settings = good.settings;
    const View view = random_view(random, live.terrain());
    const Patience patience;
    do (void)live.update({&view, 1}, now_s += 1.0 / 60);
    while (!live.frame().settled && patience.left());
    CHECK(live.frame().converged);
    CHECK(live.first_failure().empty());
}

TEST_CASE("a handle is refused once its object is destroyed, also when another one lies in its memory") {
    Random random(1403);
    const auto pack = bake_and_load(random_dem(random, 65, 65, Shape::fractal), small_bake(5));
    const Block memory = make_block(terrain_bytes(pack.pack.header));
    Terrain first;
    CHECK(!first.valid());
    REQUIRE(load_terrain(pack.pack, span_of(memory), first).ok());
    Terrain moved = std::move(first);
    CHECK(moved.columns() == 65);
    const Block cut_memory = make_block(cut_bytes(moved, {}));
    LiveCut cut;
    REQUIRE(create_cut(moved, {}, span_of(cut_memory), cut).ok());
    const View view = random_view(random, moved);
    CutReport report;
    REQUIRE(update_cut(cut, {&view, 1}, {}, report).ok());

    REQUIRE(destroy_terrain(moved).ok());
    CHECK(destroy_terrain(moved).code == StatusCode::invalid_handle);
    CHECK(update_cut(cut, {&view, 1}, {}, report).code == StatusCode::invalid_handle);
    CHECK(cut_mesh(cut).mesh.vertices.empty());
    CHECK(cut_take_changes(cut).vertex_words.empty());
    Terrain second;
    REQUIRE(load_terrain(pack.pack, span_of(memory), second).ok());
    CHECK(!moved.valid());
    CHECK(load_page(pack.pack, moved, 0, 0).code == StatusCode::invalid_handle);
    CHECK(update_cut(cut, {&view, 1}, {}, report).code == StatusCode::invalid_handle);
    CHECK(second.valid());
    CHECK(load_page(pack.pack, second, 0, 0).ok());
}

TEST_CASE("a pack or a cut of another terrain is refused") {
    Random random(1404);
    const auto one = bake_and_load(random_dem(random, 65, 65, Shape::fractal), small_bake(5));
    const auto other = bake_and_load(random_dem(random, 65, 65, Shape::fractal), small_bake(5));
    PagedTerrain a(one.pack, {}), b(other.pack, {});
    CHECK(load_page(other.pack, a.terrain, 0, 0).code == StatusCode::wrong_pack);
    const Block memory = make_block(cut_bytes(b.terrain, {})),
                streaming = make_block(stream_bytes(one.pack, a.terrain, {}));
    LiveCut cut;
    REQUIRE(create_cut(b.terrain, {}, span_of(memory), cut).ok());
    Stream stream;
    CHECK(create_stream(one.pack, a.terrain, cut, {}, span_of(streaming), stream).code == StatusCode::wrong_terrain);
    CHECK(create_stream(other.pack, a.terrain, {}, {}, span_of(streaming), stream).code == StatusCode::wrong_pack);
    CHECK(create_stream(one.pack, a.terrain, {}, {}, span_of(streaming), stream).ok());
}
