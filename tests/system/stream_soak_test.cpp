// A pack ten times larger than what may be in memory, flown from its file by the real reader: for long, and while the
// file is spoilt under it.
#include <catch2/catch.hpp>

#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include <fcntl.h>
#include <malloc.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "fjell/io/stream_reader.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/patience.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Of the whole program, in pages of the machine.
std::uint64_t resident_pages() {
    (void)malloc_trim(0); // what the checks between frames have given back
    std::uint64_t total = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident;
}

struct Scene {
    TemporaryFolder folder;
    std::string path = folder / "pack.fjell";
    io::LoadedPack full; // what the checks measure against

    explicit Scene(std::uint32_t seed, int samples, std::uint32_t texture_log2) {
        Random random(seed);
        baker::BakeOptions options = small_bake(8);
        options.threads = 2;
        options.max_texture_log2 = texture_log2;
        baker::Dem dem = random_dem(random, samples, samples, Shape::fractal);
        dem.spacing_m[0] = dem.spacing_m[1] = 30;
        (void)baker::bake(std::move(dem), options, path);
        full = io::load_pack(path, io::LoadTerrain::yes);
    }
    [[nodiscard]] View near_ground(double column, double row, double above_m) const {
        const Terrain& t = full.terrain;
        const double x = column * t.header().spacing_m[0], z = row * t.header().spacing_m[1];
        return make_view({x, data_of(t).ground_m(x, z) + above_m, z}, {0.8, -0.3, -0.6}, {0, 1, 0}, 0.8, 1280, 720, 10,
                         1e6);
    }
};

Terrain terrain_of(const io::PackFile& file, std::uint32_t slots, io::AlignedMemory& memory) {
    const std::size_t bytes = terrain_bytes(file.pack().header, {slots});
    memory = io::allocate(bytes);
    Terrain terrain;
    REQUIRE(create_terrain(file.pack(), file.corners(), {slots}, {memory.get(), bytes}, terrain).ok());
    return terrain;
}

// All that an engine holds, over a pack that stays in its file.
struct Flown {
    Flown(const Scene& of, const std::string& path, std::uint32_t slots, const StreamBudget& budget)
        : scene(of), file(path), terrain(terrain_of(file, slots, terrain_memory)),
          cut(terrain, {700'000, 1'500'000, 512, 1}) {
        const std::size_t bytes = stream_bytes(file.pack(), terrain, budget);
        stream_memory = io::allocate(bytes);
        REQUIRE(create_stream(file.pack(), terrain, cut.cut, budget, {stream_memory.get(), bytes}, stream).ok());
    }
    void frame() {
        settings.now_s += 1.0 / 60;
        const Status s = update_stream(stream, {&view, 1}, refine, settings, streamed);
        if (!s.ok()) REQUIRE(s.ok());
        for (const StreamFailure& f : stream_failures(stream)) ++failures[{f.id.kind, f.id.tile, f.id.item}];
        for (const PageArrival& a : stream_page_arrivals(stream)) removed += a.event == PageEvent::removed;
        updated = cut.update({&view, 1}, refine);
    }
    [[nodiscard]] std::string check() {
        if (std::string wrong = check_cut(cut); !wrong.empty()) return wrong;
        return check_surface(cut, scene.full.terrain);
    }
    // Until nothing is requested and nothing comes or goes any more.
    void rest() {
        for (int quiet = 0; quiet < 5;) {
            frame();
            const bool still =
                stream_page_arrivals(stream).empty() &&
                streamed.in_flight + streamed.pages_left + streamed.mips_left + streamed.mips_uploaded == 0;
            quiet = still ? quiet + 1 : 0;
            if (!still) std::this_thread::sleep_for(std::chrono::microseconds(300));
        }
    }
    // What is drawn is all that the views want of what is loaded.
    [[nodiscard]] std::string at_target() {
        return difference(active_set(cut), target_set(scene.full.terrain, terrain, {&view, 1}, refine.max_error_px));
    }
    [[nodiscard]] bool loaded(std::uint32_t tile, std::uint32_t page) const {
        return data_of(terrain).page_table[std::size_t{tile} * terrain.pages_per_tile() + page].slot != no_index;
    }

    const Scene& scene;
    io::PackFile file;
    io::AlignedMemory terrain_memory, stream_memory;
    Terrain terrain;
    Cut cut;
    Stream stream;
    View view;
    CutSettings refine;
    StreamSettings settings;
    StreamReport streamed;
    CutReport updated;
    std::map<std::tuple<ChunkKind, std::uint32_t, std::uint32_t>, int> failures; // how often each was told
    std::uint64_t removed = 0;
};

// Bytes of a file from a place on, in the same file: whoever holds it open sees them.
void overwrite(const std::string& path, std::uint64_t offset, std::span<const std::byte> bytes) {
    const int fd = open(path.c_str(), O_WRONLY | O_CLOEXEC);
    REQUIRE(fd >= 0);
    const ssize_t written = pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    close(fd);
    REQUIRE(written == static_cast<ssize_t>(bytes.size()));
}

std::uint64_t map_bytes_of(const PackHeader& h) {
    std::uint64_t bytes = 0;
    for (const auto& [kind, log2] :
         {std::pair(ChunkKind::colour, h.colour_log2), std::pair(ChunkKind::normal, h.normal_log2)})
        for (std::uint32_t mip = 0; mip < mip_count(log2); ++mip)
            bytes += chunk_raw_bytes(h, {kind, 0, mip}) * h.tiles_x * h.tiles_y;
    return bytes;
}

} // namespace

TEST_CASE("thousands of frames over a pack ten times larger than its pools: memory stays, the mesh is whole, rest "
          "converges") {
    (void)prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0); // the kernel joins pages into huge ones when it likes, and counts them
    const Scene scene(901, 1537, 8);
    const PackHeader& h = scene.full.pack.header;
    const std::uint32_t slots = scene.full.terrain.page_count() / 10;
    StreamBudget budget;
    budget.map_bytes = map_bytes_of(h) / 10;
    budget.tail_log2 = 3;
    Flown on(scene, scene.path, slots, budget);
    const io::StreamReader reader(on.stream, on.file);
    on.refine.max_error_px = 8;
    Random random(902);
    double column = 300, row = 1200;
    std::uint64_t before = 0, largest = 0;
    for (std::uint64_t chunk = 0; chunk < h.directory_count; ++chunk)
        largest = std::max<std::uint64_t>(largest, scene.full.pack.entry(chunk).stored_bytes);
    std::uint64_t drawn = 0;
    // How far the reader comes in so many frames is the machine's affair: on until it was all in and out several times.
    const auto far_enough = [&] {
        return on.removed > rounds<std::uint64_t>(5, 10) * slots &&
               on.streamed.mips_read > rounds<std::uint64_t>(500, 1000);
    };
    const Patience patience;
    for (int frame = 0; frame < rounds(5000, 10'000) || (!far_enough() && patience.left()); ++frame) {
        column += 0.8, row -= 0.6;
        if (column > 1500 || row < 40 || pick(random, 0, 400) == 0)
            column = uniform(random, 40, 1500), row = uniform(random, 40, 1500);
        on.view = scene.near_ground(column, row, frame / 1000 % 2 ? 2000 : 300);
        on.frame();
        drawn += on.updated.triangles_drawn;
        if (frame % 1500 == 750) {
            CAPTURE(frame);
            REQUIRE(on.check() == "");
        }
        if (frame == 1000) before = resident_pages();
    }
    const std::uint64_t after = resident_pages(), machine_page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    // The reader's room for the largest chunk may come late, with deeper stacks and a heap cut differently; 16 bytes
    // lost a frame would be 35 pages, one page of geometry in each hundred that was read more than that.
    const std::uint64_t may_grow = largest / machine_page + 1 + 32;
    CAPTURE(before, after, slots, on.streamed.pages_read, on.streamed.mips_read, on.removed, drawn);
    CHECK(after <= before + may_grow);
    CHECK(on.failures.empty());
    CHECK(far_enough());
    CHECK(on.streamed.page_slots.peak <= slots);
    CHECK(on.streamed.map_bytes_capacity <= budget.map_bytes);

    // From near the slots do not suffice, and the threshold says so; from far they do.
    on.refine.max_error_px = 0.5;
    on.view = scene.near_ground(700, 700, 100);
    on.rest();
    CHECK_FALSE(on.streamed.converged);
    CHECK((on.streamed.exhausted & stream_page_slots) != 0);
    CHECK(on.updated.error_bound_px == on.streamed.missing_px);
    CHECK(on.at_target() == "");
    on.refine.max_error_px = 16;
    on.view = scene.near_ground(700, 700, 20'000);
    on.rest();
    CHECK(on.streamed.converged);
    CHECK(on.updated.converged);
    CHECK(on.updated.error_bound_px == on.refine.max_error_px);
    CHECK(on.at_target() == "");
    CHECK(on.check() == "");
}

TEST_CASE("a file cut short, overwritten or deleted in flight: what is loaded stays, failures are told once, retrying "
          "heals") {
    const Scene scene(903, 700, 6);
    const std::span<const std::byte> whole = scene.full.file;
    for (const int damage : {0, 1, 2}) {
        CAPTURE(damage);
        const std::string path = scene.folder / "flown.fjell";
        std::filesystem::remove(path);
        std::filesystem::copy_file(scene.path, path);
        Flown on(scene, path, 0, {});
        const io::StreamReader reader(on.stream, on.file);
        on.refine.max_error_px = 2;
        on.view = scene.near_ground(100, 100, 300);
        on.rest();
        REQUIRE(on.streamed.converged);
        const std::uint64_t read = on.streamed.pages_read;
        switch (damage) {
        case 0: std::filesystem::resize_file(path, 1000); break;
        case 1: overwrite(path, 0, std::vector<std::byte>(whole.size(), std::byte{0xa5})); break;
        case 2: std::filesystem::remove(path); break; // who holds it open still reads it
        }
        for (int frame = 0; frame < 400; ++frame) {
            on.view = scene.near_ground(100 + frame, 100 + frame, 300);
            on.frame();
            if (frame % 80 == 0) REQUIRE(on.check() == "");
        }
        on.rest();
        CAPTURE(read, on.streamed.pages_read, on.streamed.failed, on.failures.size());
        CHECK(on.check() == "");
        CHECK(on.at_target() == "");
        CHECK(on.removed == 0);
        for (const auto& [id, times] : on.failures) CHECK(times == 1);
        if (damage == 2) {
            CHECK(on.failures.empty());
            CHECK(on.streamed.converged);
            continue;
        }
        CHECK(on.streamed.pages_read == read);
        CHECK(on.failures.size() > 5);
        CHECK_FALSE(on.streamed.converged);
        CHECK_FALSE(on.updated.converged);
        CHECK(on.updated.error_bound_px > on.refine.max_error_px);
        overwrite(path, 0, whole);
        on.rest();
        CHECK(on.streamed.pages_read == read); // not before it is told to
        (void)stream_retry_failed(on.stream);
        on.rest();
        CHECK(on.streamed.converged);
        CHECK(on.updated.converged);
        CHECK(on.at_target() == "");
        CHECK(on.check() == "");
    }
}

TEST_CASE("a bit flipped in one page: that page fails, once, and the rest is what the views want of what is loaded") {
    const Scene scene(904, 769, 6); // whole tiles: no page lies beyond the rim
    const Pack& pack = scene.full.pack;
    Random random(905);
    for (int round = 0; round < 2; ++round) {
        const std::string path = scene.folder / "flipped.fjell";
        std::filesystem::remove(path);
        std::filesystem::copy_file(scene.path, path);
        // One of the coarser pages, which has others below it; the first may be the tile's coarsest.
        const auto tile = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(pack.tile_count()) - 1));
        const auto page = static_cast<std::uint32_t>(pick(random, 0, 5));
        const ChunkEntry entry = pack.entry(chunk_index(pack.header, {ChunkKind::geometry, tile, page}));
        const std::uint64_t at =
            entry.offset + static_cast<std::uint64_t>(pick(random, 0, static_cast<int>(entry.stored_bytes) - 1));
        const std::byte flipped = scene.full.file[at] ^ (std::byte{1} << pick(random, 0, 7));
        overwrite(path, at, {&flipped, 1});
        Flown on(scene, path, 0, {});
        const io::StreamReader reader(on.stream, on.file);
        on.refine.max_error_px = 0.01; // everything
        on.view = scene.near_ground(350, 350, 3000);
        on.rest();
        std::uint32_t elsewhere = 0;
        CAPTURE(round, tile, page, on.streamed.missing_px, on.updated.error_bound_px, on.updated.waiting);
        REQUIRE(on.failures.size() == 1);
        CHECK(on.failures.begin()->first == std::tuple(ChunkKind::geometry, tile, page));
        CHECK(on.failures.begin()->second == 1);
        CHECK_FALSE(on.loaded(tile, page));
        CHECK_FALSE(on.streamed.converged);
        CHECK(on.at_target() == "");
        CHECK(on.check() == "");
        // Nothing else is missing but pages below it: outside its tile all are there.
        for (std::uint32_t other = 0; other < on.terrain.page_count(); ++other)
            if (other / on.terrain.pages_per_tile() != tile &&
                !on.loaded(other / on.terrain.pages_per_tile(), other % on.terrain.pages_per_tile()))
                ++elsewhere;
        CHECK(elsewhere == 0);
        overwrite(path, at, std::span(scene.full.file).subspan(at, 1));
        (void)stream_retry_failed(on.stream);
        on.rest();
        CHECK(on.streamed.converged);
        CHECK(on.at_target() == "");
    }
}
