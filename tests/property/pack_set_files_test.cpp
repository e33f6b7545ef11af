// The files of a pack set: what is missing, mixed, damaged or replaced is refused in one line that says which, and few
// are open at a time.
#include <catch2/catch.hpp>

#include <cerrno>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include "baker/read/pack_source.h"
#include "fjell/cut.h"
#include "fjell/io/failure.h"
#include "fjell/pack_set.h"
#include "fjell/stream.h"
#include "io/set_parts.h"
#include "support/rounds.h"
#include "support/set_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

baker::Dem field(double step_m = 1) {
    Random random(7);
    baker::Dem dem = random_dem(random, 4 * 64 + 1, 2 * 64 + 20, Shape::fractal);
    for (float& height : dem.heights_m) height *= static_cast<float>(step_m);
    dem.spacing_m[0] = dem.spacing_m[1] = 1;
    return dem;
}

// Empty when it opens.
std::string refusal(const std::string& path) {
    try {
        const io::PackFile file(path);
    } catch (const io::Failure& f) {
        CHECK(f.exit_code == 1);
        CHECK(std::string(f.what()).find('\n') == std::string::npos);
        return f.what();
    }
    return {};
}
bool says(const std::string& said, const std::string& what) {
    CAPTURE(said, what);
    return said.find(what) != std::string::npos;
}

std::size_t open_files() {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) count += entry.exists();
    return count;
}

struct MemoryUse {
    std::size_t terrain = 0, cut = 0, stream = 0;
};
MemoryUse memory_use(const io::PackFile& file, std::uint32_t slots) {
    MemoryUse use;
    use.terrain = terrain_bytes(file.pack().header, {slots});
    const io::AlignedMemory memory = io::allocate(use.terrain);
    Terrain terrain;
    REQUIRE(create_terrain(file.pack(), file.corners(), {slots}, {memory.get(), use.terrain}, terrain).ok());
    use.cut = cut_bytes(terrain, {});
    use.stream = stream_bytes(file.pack(), terrain, {});
    return use;
}

struct Place {
    Place() {
        (void)baker::bake(field(), small_bake(6), pack);
        (void)baker::split_pack(pack, set, {2, 2});
    }
    // set.json with one thing replaced by another.
    std::string with(const std::string& what, const std::string& by) const {
        std::string text = slurp(index);
        const std::size_t at = text.find(what);
        REQUIRE(at != std::string::npos);
        spit(index, text.replace(at, what.size(), by));
        const std::string said = refusal(set);
        spit(index, text.replace(at, by.size(), what));
        return said;
    }
    TemporaryFolder folder;
    const std::string pack = folder / "pack.fjell", set = folder / "set", index = set + "/set.json";
};

} // namespace

TEST_CASE("a set is opened by its folder or its set.json, and is one pack to whoever opens it") {
    const Place place;
    const io::PackFile whole(place.pack), by_folder(place.set), by_file(place.index);
    CHECK(by_folder.packs() == 4);
    CHECK(by_file.pack().header.directory_hash == by_folder.pack().header.directory_hash);
    std::vector<std::byte> a, b;
    for (std::uint64_t chunk = 0; chunk < whole.pack().header.directory_count; ++chunk) {
        whole.read_chunk(chunk_id(whole.pack().header, chunk), a);
        by_folder.read_chunk(chunk_id(whole.pack().header, chunk), b);
        REQUIRE(a == b);
    }
    // One read may go over several files, from the header to the end of what is no file.
    std::vector<std::byte> all(by_folder.pack().header.file_bytes);
    REQUIRE(by_folder.read(0, all) == 0);
    Pack pack;
    CHECK(open_pack(all, pack).ok());
    CHECK(by_folder.read(1, all) == EIO);
    CHECK(!by_folder.changed());
    // As a file it is no pack that anyone else opens: only a set in memory may lack tiles.
    std::filesystem::remove(place.set + "/0-0.fjell");
    CHECK(says(refusal(place.set), "0-0.fjell: a pack of"));
}

TEST_CASE("a sparse terrain in a file is refused: it is a set's") {
    const Place place;
    std::string text = slurp(place.index);
    const std::size_t first = text.find("    {\"file\""), second = text.find("    {\"file\"", first + 1);
    spit(place.index, text.erase(first, second - first));
    const io::PackFile sparse(place.set);
    REQUIRE(sparse.pack().header.tiles_held != 0);
    std::vector<std::byte> all(sparse.pack().header.file_bytes);
    REQUIRE(sparse.read(0, all) == 0);
    spit(place.folder / "sparse.fjell", {reinterpret_cast<const char*>(all.data()), all.size()});
    CHECK(says(refusal(place.folder / "sparse.fjell"), "version"));
}

TEST_CASE("what is wrong with a set is said in one line that names the file") {
    const Place place;
    REQUIRE(refusal(place.set).empty());
    CHECK(says(place.with("\"fjell_set\": 1", "\"fjell_set\": 2"), "set.json:2: a pack set of version 2"));
    CHECK(says(place.with("\"fjell_set\": 1,", ""), "\"fjell_set\" is missing"));
    CHECK(says(place.with("\"columns\": 257", "\"columns\": 256"), "does not fit"));
    CHECK(says(place.with("\"columns\": 257", "\"columns\": 1e30"), "whole number"));
    CHECK(says(place.with("\"tile_cells\": 64", "\"tile_cells\": 32"), "another tile size"));
    CHECK(says(place.with("1-0.fjell", "0-0.fjell"), "0-0.fjell"));
    CHECK(says(place.with("1-0.fjell", "../pack.fjell"), "in the folder of the set"));
    CHECK(says(place.with("1-0.fjell", place.pack), "in the folder of the set"));
    CHECK(says(place.with("1-0.fjell", "a/../../pack.fjell"), "in the folder of the set"));
    CHECK(says(place.with("1-0.fjell", ""), "in the folder of the set"));
    for (const char* const number : {"-1", "0", "1", "1048577", "4294967296", "4294967553", "1e308", "2.5"}) {
        CHECK(says(place.with("\"columns\": 257", std::string("\"columns\": ") + number), "set.json:3: "));
        CHECK(says(place.with("\"rows\": 148", std::string("\"rows\": ") + number), "set.json:4: "));
    }
    for (const char* const number : {"-1", "1048576", "1048577", "4294967295", "4294967297", "1e999", "-1e-320", "nan"})
        for (const char* const key : {"\"tile_x\": 2", "\"tiles_x\": 2", "\"tile_y\": 1"}) {
            const std::string name(key, std::string(key).find(' '));
            CHECK(!place.with(key, name + " " + number).empty());
        }
    for (const char* const spacing : {"[0, 1]", "[1, 0]", "[-1, 1]", "[1e-320, 1]", "[1, 1e308]", "[1]", "[1, 1, 1]"})
        CHECK(!place.with("[1, 1]", spacing).empty());
    for (const char* const cells : {"0", "1", "3", "4097", "63"})
        CHECK(!place.with("\"tile_cells\": 64", std::string("\"tile_cells\": ") + cells).empty());
    CHECK(says(place.with("1-0.fjell", "set.json"), "a set in the set"));
    CHECK(says(place.with("1-0.fjell", "nothing.fjell"), "nothing.fjell: a pack of"));
    CHECK(says(place.with("\"tile_x\": 2", "\"tile_x\": 0"), "place"));
    CHECK(says(place.with("\"tiles_x\": 2", "\"tiles_x\": 3"), "other numbers of tiles"));
    CHECK(says(place.with("\"pack_hash\": \"", "\"pack_hash\": \"f"), "hexadecimal"));
    const std::string hash = slurp(place.index).substr(slurp(place.index).find("\"pack_hash\": \"") + 14, 16);
    CHECK(says(place.with(hash, "0123456789abcdef"), "another pack (pack_hash)"));
    const std::string text = slurp(place.index);
    for (auto size = std::size_t{0}; size + 2 < text.size();
         size += rounds<std::size_t>(9, 1)) { // the last bracket and its newline
        spit(place.index, text.substr(0, size));
        CAPTURE(size);
        REQUIRE(says(refusal(place.set), "set.json:"));
    }
}

TEST_CASE("packs of two bakes are not mixed, nor damaged ones taken") {
    const Place place;
    const std::string part = place.set + "/1-0.fjell", good = slurp(part), other = place.folder / "other";
    const auto with_other = [&](double step_m, baker::BakeOptions options) {
        (void)baker::bake(field(step_m), options, place.folder / "other.fjell");
        (void)baker::split_pack(place.folder / "other.fjell", other, {2, 2});
        spit(part, slurp(other + "/1-0.fjell"));
        std::string text = slurp(place.index); // as if it had been written for it
        std::string index = text;
        for (std::size_t at = 0; (at = index.find("\"pack_hash\": \"", at)) != std::string::npos; at += 14)
            index.erase(at + 14, 16);
        spit(place.index, index);
        const std::string said = refusal(place.set);
        spit(place.index, text);
        spit(part, good);
        return said;
    };
    CHECK(says(with_other(3, small_bake(6)), "1-0.fjell: height scale: not that of"));
    CHECK(says(with_other(1, small_bake(6, 0.1)), "1-0.fjell: nesting: not that of"));
    baker::BakeOptions ordered = small_bake(6);
    ordered.order = PageOrder::hierarchical_z;
    CHECK(says(with_other(1, ordered), "1-0.fjell: order: not that of"));
    const auto with_link = [&](const std::string& target) {
        std::filesystem::remove(part);
        std::filesystem::create_symlink(target, part);
        const std::string said = refusal(place.set);
        std::filesystem::remove(part);
        return said;
    };
    CHECK(says(with_link("1-0.fjell"), "1-0.fjell: a pack of")); // a link in a circle
    CHECK(says(with_link(".."), "1-0.fjell: is a folder"));
    CHECK(says(with_link("../set"), "1-0.fjell: a set in the set"));
    CHECK(says(with_link("/dev/null"), "1-0.fjell: not a file"));
    CHECK(says(with_link("../other/1-0.fjell"), "1-0.fjell: order: not that of"));
    for (const std::size_t size : {std::size_t{0}, std::size_t{100}, good.size() - 1}) {
        spit(part, good.substr(0, size));
        CHECK(says(refusal(place.set), "1-0.fjell: "));
    }
    spit(part, good);
    CHECK(refusal(place.set).empty());
}

TEST_CASE("a pack that is replaced while its set is open is noticed when it is read") {
    const Place place;
    const io::PackFile file(place.set);
    std::vector<std::byte> raw;
    const ChunkId page{ChunkKind::geometry, 0, 0};
    const std::string part = place.set + "/0-0.fjell";
    std::string bytes = slurp(part);
    std::filesystem::remove(part);
    spit(part, bytes.substr(0, bytes.size() - 8));
    const ChunkEntry entry = file.pack().entry(chunk_index(file.pack().header, page));
    raw.resize(entry.stored_bytes);
    CHECK(file.read(entry.offset, raw) == ESTALE);
    CHECK(file.changed());
    try {
        file.read_chunk(page, raw);
        FAIL("it was read");
    } catch (const io::Failure& f) {
        CHECK(says(f.what(), "0-0.fjell: was changed after it was opened"));
    }
}

TEST_CASE("a pack that is gone while its set is open is named, and read again once it is back") {
    const Place place;
    const io::PackFile file(place.set);
    const ChunkId page{ChunkKind::geometry, 0, 0};
    const std::string part = place.set + "/0-0.fjell", bytes = slurp(part);
    std::vector<std::byte> raw;
    std::filesystem::remove(part);
    CHECK(file.changed());
    try {
        file.read_chunk(page, raw);
        FAIL("it was read");
    } catch (const io::Failure& f) {
        CHECK(f.exit_code == 1);
        CHECK(says(f.what(), "0-0.fjell: is gone since its set was opened; copy it there"));
    }
    spit(part, bytes);
    CHECK(!file.changed());
    file.read_chunk(page, raw);
    std::filesystem::remove(part); // now it is open
    file.read_chunk(page, raw);
}

TEST_CASE("a set that is open may be moved, and is read by a program that changes its working folder") {
    const Place place;
    struct Home {
        ~Home() { std::filesystem::current_path(path); }
        std::filesystem::path path = std::filesystem::current_path();
    } home;
    std::filesystem::current_path(place.folder.path);
    const io::PackFile file("set");
    const io::PackFile whole("pack.fjell");
    std::filesystem::current_path("/");
    std::filesystem::rename(place.set, place.folder / "elsewhere");
    std::vector<std::byte> a, b;
    for (std::uint64_t chunk = 0; chunk < whole.pack().header.directory_count; ++chunk) {
        whole.read_chunk(chunk_id(whole.pack().header, chunk), a);
        file.read_chunk(chunk_id(file.pack().header, chunk), b);
        REQUIRE(a == b);
    }
    CHECK(!file.changed());
    CHECK(refusal(place.folder / "elsewhere").empty());
}

TEST_CASE("where the machine has few descriptors left a set is read with fewer, and is not said to have changed") {
    const Place place;
    const io::PackFile file(place.set);
    const auto first_page = [&](std::uint32_t tile) {
        const ChunkEntry entry = file.pack().entry(chunk_index(file.pack().header, {ChunkKind::geometry, tile, 0}));
        std::vector<std::byte> raw(entry.stored_bytes);
        return file.read(entry.offset, raw);
    };
    struct Limit {
        explicit Limit(rlim_t files) {
            getrlimit(RLIMIT_NOFILE, &before);
            const rlimit now{files, before.rlim_max};
            setrlimit(RLIMIT_NOFILE, &now);
        }
        ~Limit() { setrlimit(RLIMIT_NOFILE, &before); }
        rlimit before{};
    };
    const int next = open("/dev/null", O_RDONLY); // the lowest number that is free
    close(next);
    {
        const Limit none(static_cast<rlim_t>(next));
        CHECK(first_page(0) == EMFILE);
        CHECK(!file.changed());
    }
    const Limit one(static_cast<rlim_t>(next) + 1);
    for (std::uint32_t tile = 0; tile < file.pack().tile_count(); ++tile) CHECK(first_page(tile) == 0);
    CHECK(!file.changed());
}

TEST_CASE("however many packs a set has, few of their files are open at a time, and a stream needs no more memory") {
    Random random(11);
    const TemporaryFolder folder;
    (void)baker::bake(random_dem(random, 32 * 4 + 1, 32 * 4 + 1, Shape::fractal), small_bake(2), folder / "pack.fjell");
    (void)baker::split_pack(folder / "pack.fjell", folder / "set", {32, 32});
    const std::size_t before = open_files();
    const io::PackFile file(folder / "set");
    CHECK(file.packs() == 1024);
    CHECK(open_files() == before + 1); // the folder
    for (const std::uint32_t slots : {2048u, 4096u}) {
        const io::PackFile one(folder / "pack.fjell");
        const MemoryUse of_set = memory_use(file, slots), of_one = memory_use(one, slots);
        CHECK(of_set.terrain == of_one.terrain);
        CHECK(of_set.cut == of_one.cut);
        CHECK(of_set.stream == of_one.stream);
        CHECK(of_set.stream > 0);
    }
    std::vector<std::byte> raw;
    std::size_t most = 0;
    for (int times = 0; times < 2; ++times)
        for (std::uint64_t chunk = 0; chunk < file.pack().header.directory_count; ++chunk) {
            file.read_chunk(chunk_id(file.pack().header, chunk), raw);
            most = std::max(most, open_files());
        }
    CHECK(most <= before + 1 + io::most_set_descriptors);
    CHECK(most > before + 8);
}

TEST_CASE("parts that lie over each other or outside the set are refused, and which one is said") {
    const Place place;
    const io::PackFile a(place.set + "/0-0.fjell"), b(place.set + "/1-0.fjell");
    const SetShape shape{257, 148};
    std::uint32_t at_fault = 0;
    SetIndex index;
    const auto made = [&](const std::vector<SetPart>& parts) {
        std::vector<std::byte> room(set_index_bytes(shape, parts) + 64);
        const auto from = reinterpret_cast<std::uintptr_t>(room.data());
        const std::size_t skip = (64 - from % 64) % 64;
        return make_set_index(shape, parts, std::span(room).subspan(skip), index, at_fault);
    };
    const SetPart first{&a.pack(), a.corners(), 0, 0}, second{&b.pack(), b.corners(), 2, 0};
    CHECK(made({first, second}).ok());
    CHECK(made({second, first}).ok());
    const Status twice = made({first, second, second});
    CHECK(twice.code == StatusCode::out_of_range);
    CHECK(at_fault == 2);
    CHECK(made({}).code == StatusCode::out_of_range);
    CHECK(made({first, {nullptr, {}, 0, 0}}).code == StatusCode::not_a_pack);
    CHECK(made({first, {&b.pack(), {}, 2, 0}}).code == StatusCode::corrupt);
    CHECK(at_fault == 1);
    CHECK(make_set_index(shape, std::vector<SetPart>{first}, {}, index, at_fault).code == StatusCode::memory_too_small);
    std::uint64_t in_part = 7;
    const std::vector<SetPart> parts{first, second};
    CHECK(set_part_at(parts, 511, in_part) == 2);
    CHECK(set_part_at(parts, 512, in_part) == 0);
    CHECK(in_part == 0);
    CHECK(set_part_at(parts, 512 + a.pack().header.file_bytes, in_part) == 1);
    CHECK(in_part == 0);
    CHECK(set_part_at(parts, 512 + a.pack().header.file_bytes + b.pack().header.file_bytes, in_part) == 2);
}

namespace {

// Packs of files that say their own places in text, each baked on its own, as members of one set. Steps are in the
// files' units; spacing_m: as asked for; 0: what the files say.
struct BakedApart {
    double step, spacing_m;
    double west, north; // of the set's first sample

    static constexpr std::int32_t cells = 64, columns = 2 * cells + 1, rows = cells + 1;
    static constexpr std::uint32_t tiles_x = 2000, tiles_y = 3;

    // Whole metres; mirrored, so that it goes on where the same ground ends in the west.
    static int height(std::int32_t x, std::int32_t y, bool mirrored) {
        x = mirrored ? columns - 1 - x : x;
        return x * y % 89 + (x / 7 * 31 + y / 5 * 17) % 53;
    }
    // off: of its place, in cells.
    void bake(const std::string& out, std::uint32_t tile_x, std::uint32_t tile_y, bool mirrored, double off = 0) const {
        const double x = west + (tile_x * cells + off) * step, y = north - (tile_y * cells + rows - 1) * step;
        std::string text = fmt::format("ncols {}\nnrows {}\nxllcenter {:.15f}\nyllcenter {:.15f}\ncellsize {:.15f}\n",
                                       columns, rows, x, y, step);
        for (std::int32_t j = 0; j < rows; ++j)
            for (std::int32_t i = 0; i < columns; ++i)
                text += fmt::format("{}{}", height(i, j, mirrored), i + 1 == columns ? "\n" : " ");
        spit(out + ".asc", text);
        baker::ReadOptions reading;
        if (spacing_m > 0) reading.spacing_m = spacing_m;
        (void)baker::bake(baker::read_dem(out + ".asc", reading), small_bake(6), out);
    }
};

} // namespace

TEST_CASE("packs baked apart are one set where floats do not hold their spacing, in metres or in degrees") {
    for (const BakedApart& apart : {BakedApart{0.1, 0, 500000.3, 6000000.7},     // a tenth of a metre
                                    BakedApart{1.0 / 10800, 10.3, 7.1, 46.3}}) { // a third of an arc-second
        CAPTURE(apart.step);
        const TemporaryFolder folder;
        const std::uint32_t far_x = BakedApart::tiles_x - 2, far_y = BakedApart::tiles_y - 1;
        apart.bake(folder / "west.fjell", 0, 0, false);
        apart.bake(folder / "east.fjell", 2, 0, true);
        apart.bake(folder / "far.fjell", far_x, far_y, false);
        const auto cells = static_cast<std::uint32_t>(BakedApart::cells);
        const io::PackFile west(folder / "west.fjell");
        const double(&spacing)[2] = west.pack().header.spacing_m;
        const io::SetFile set{BakedApart::tiles_x * cells + 1,
                              BakedApart::tiles_y * cells + 1,
                              cells,
                              {spacing[0], spacing[1]},
                              {{"west.fjell", 0, 0, 2, 1, 0, false},
                               {"east.fjell", 2, 0, 2, 1, 0, false},
                               {"far.fjell", far_x, far_y, 2, 1, 0, false}}};
        const std::string path = folder / "set.json";
        spit(path, io::set_file_text(set));
        REQUIRE(refusal(path) == "");
        {
            const io::PackFile opened(path);
            CHECK(opened.packs() == 3);
            CHECK(opened.pack().header.crs_origin[0] == Approx(apart.west).epsilon(1e-12));
            CHECK(opened.pack().header.crs_origin[1] == Approx(apart.north).epsilon(1e-12));
        }
        const auto reader = baker::PackSource(path).reader();
        const auto holds = [&](std::uint32_t tile_x, std::uint32_t tile_y, bool mirrored) {
            std::vector<float> read(std::size_t{BakedApart::columns} * BakedApart::rows);
            baker::ReadStatistics seen;
            reader->read({static_cast<std::int32_t>(tile_x * cells), static_cast<std::int32_t>(tile_y * cells),
                          BakedApart::columns, BakedApart::rows},
                         read.data(), seen);
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < read.size(); ++i) {
                const auto x = static_cast<std::int32_t>(i % BakedApart::columns),
                           y = static_cast<std::int32_t>(i / BakedApart::columns);
                wrong += std::abs(read[i] - static_cast<float>(BakedApart::height(x, y, mirrored))) > 0;
            }
            return wrong == 0;
        };
        CHECK(holds(0, 0, false));
        CHECK(holds(2, 0, true));
        CHECK(holds(far_x, far_y, false));
        // A hundredth of a cell is ten times what no rounding of doubles comes to.
        apart.bake(folder / "far.fjell", far_x, far_y, false, 0.01);
        CHECK(says(refusal(path), "far.fjell: place (origin and tile_x, tile_y): not that of"));
    }
}
