// Writes seeds for each fuzz_X into FOLDER/X. Of packs and pages: small packs in every order, with tiles of 2 to 64
// cells, with and without holes, lossless and not, and their pages decompressed. Of texts: what content/ and profiles/
// have.
//
// Each pack is written three times: as it is, so that hashes are what is attacked; with its hashes repaired after a
// mutation, so that zstd is; and with chunks that are not compressed, so that records are.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "baker/bake/checkpoint.h"
#include "baker/materials/encode.h"
#include "baker/pack/write_set.h"
#include "fjell/io/journal.h"
#include "input.h"
#include "io/file.h"
#include "io/set_file.h"
#include "io/stamps.h"
#include "session/record.h"
#include "support/terrain_fixture.h"

namespace {

using namespace fjell;
using namespace fjell::test;
using fuzz::PackScript;
using fuzz::PageScript;
using Bytes = std::vector<std::byte>;

void append(Bytes& to, std::span<const std::byte> what) {
    to.insert(to.end(), what.begin(), what.end());
}
template <typename T>
void append_value(Bytes& to, const T& value) {
    append(to, std::as_bytes(std::span(&value, 1)));
}

void write(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw std::runtime_error("cannot write " + path.string());
}

Bytes read(const Pack& pack, ChunkId id) {
    Bytes raw(pack.entry(chunk_index(pack.header, id)).raw_bytes);
    if (!read_chunk(pack, id, raw).ok()) throw std::runtime_error("a chunk that was just written cannot be read");
    return raw;
}

// A zstd frame of one block that is not compressed (RFC 8878, 3.1.1): what a mutation changes in it is the content.
void append_raw_frame(Bytes& to, const Bytes& content) {
    if (content.size() > 128 * 1024) throw std::runtime_error("one zstd block holds at most 128 KB");
    const auto size = static_cast<std::uint32_t>(content.size());
    append_value(to, std::uint32_t{0xfd2fb528});
    append_value(to, std::uint8_t{0xa0}); // single segment, the size in four bytes
    append_value(to, size);
    const std::uint32_t block = size << 3 | 1; // the last one, raw
    append(to, std::as_bytes(std::span(&block, 1)).first(3));
    append(to, content);
}

// The same pack without compression; its hashes are left to fuzz_pack's repair.
Bytes uncompressed(const Pack& pack) {
    PackHeader h = pack.header;
    Bytes out(sizeof h);
    std::vector<ChunkEntry> directory;
    for (std::uint64_t i = 0; i < h.directory_count; ++i) {
        const std::size_t offset = out.size();
        const Bytes raw = read(pack, chunk_id(h, i));
        append_raw_frame(out, raw);
        directory.push_back({offset, 0, static_cast<std::uint32_t>(out.size() - offset),
                             static_cast<std::uint32_t>(raw.size()), pack.entry(i).bound});
    }
    h.directory_offset = out.size();
    append(out, std::as_bytes(std::span(directory)));
    h.file_bytes = out.size();
    std::memcpy(out.data(), &h, sizeof h);
    return out;
}

void write_text(const std::filesystem::path& path, const std::string& text);

constexpr std::size_t most_seed_bytes = 32'000; // a fuzzer changes one byte at a time

class SeedWriter {
public:
    explicit SeedWriter(const std::filesystem::path& folder) : packs_(folder / "pack"), pages_(folder / "page") {
        for (const auto& f : {packs_, pages_}) {
            std::filesystem::remove_all(f); // no seed of an earlier format
            std::filesystem::create_directories(f);
        }
    }

    void packs(const std::string& name, const io::LoadedPack& pack) {
        PackScript script{};
        for (std::uint8_t& b : script.pages) b = static_cast<std::uint8_t>(pick(random_, 0, 255));
        script.slots = static_cast<std::uint8_t>(pick(random_, 0, 255));
        script.eye = static_cast<std::uint8_t>(pick(random_, 0, 255));
        const auto one = [&](const char* suffix, unsigned repairs, const Bytes& bytes) {
            script.repairs = static_cast<std::uint8_t>(repairs);
            script.frame = static_cast<std::uint8_t>(pick(random_, 0, 127));
            Bytes seed;
            append_value(seed, script);
            append(seed, bytes);
            write(packs_ / (name + suffix), seed);
        };
        if (pack.file.size() <= most_seed_bytes) {
            one("_as_it_is", 0, pack.file);
            one("_repaired", fuzz::repair_hashes, pack.file);
        }
        const Bytes raw = uncompressed(pack.pack);
        if (raw.size() <= most_seed_bytes) one("_uncompressed", fuzz::repair_hashes | fuzz::repair_directory, raw);
    }

    // The first page, and the first and the last one of the finest step.
    void pages(const std::string& name, const io::LoadedPack& pack) {
        const PageLayout layout = pages_of(pack.pack.header);
        const std::uint32_t last = layout.pages_per_tile() - 1;
        for (const std::uint32_t page : {0u, layout.tile_log2 > page_squares_log2 ? last / 4 * 3 : 0, last}) {
            PageScript script{};
            script.layout = static_cast<std::uint8_t>(static_cast<int>(layout.order) + 3 * (layout.tile_log2 - 1));
            script.page = static_cast<std::uint8_t>(page);
            script.scale = static_cast<std::uint8_t>(pick(random_, 0, 3));
            script.fit = static_cast<std::uint8_t>(pick(random_, 0, 1));
            script.corner_first = static_cast<std::uint32_t>(random_());
            script.corner_stride = static_cast<std::uint32_t>(random_()) >> pick(random_, 0, 31);
            Bytes seed;
            append_value(seed, script);
            append(seed, read(pack.pack, {ChunkKind::geometry, 0, page}));
            write(pages_ / (name + "_" + std::to_string(page)), seed);
        }
    }

private:
    std::filesystem::path packs_, pages_;
    Random random_{7};
};

// 256 heights: residuals of one byte where the ground is smooth.
void make_lossless(baker::Dem& dem) {
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const float quantum = std::max(1e-3f, (*most - *least) / 255), base = *least;
    for (float& h : dem.heights_m) h = base + std::round((h - base) / quantum) * quantum;
    dem.native_quantum_m = static_cast<double>(quantum);
}

// A hole in the middle and one at the far corner, which is a tile's if the terrain ends with one.
void make_holes(baker::Dem& dem) {
    dem.voids.assign(dem.heights_m.size(), 0);
    for (std::int32_t y = dem.rows / 3; y < dem.rows / 2; ++y)
        for (std::int32_t x = dem.columns / 3; x < dem.columns / 2; ++x) dem.voids[dem.index(x, y)] = 1;
    dem.voids.back() = 1;
}

struct SeedPack {
    int log2;
    SampleIndex samples;
    bool holes, lossless;
};

// Some tiles end beyond the terrain's rim. Errors are derived in blocks without rim and hole, so from 65 x 65 on; 90 x
// 60 in tiles of 64 is two tiles with both rims, 129 x 129 one of six pages: five blocks, one of them over the others.
constexpr std::array seed_packs{
    SeedPack{1, {4, 3}, false, false},    SeedPack{2, {9, 5}, true, true},     SeedPack{3, {17, 12}, false, true},
    SeedPack{4, {17, 17}, true, false},   SeedPack{5, {40, 33}, true, true},   SeedPack{6, {65, 65}, false, true},
    SeedPack{6, {65, 64}, true, false},   SeedPack{6, {90, 60}, true, true},   SeedPack{6, {129, 65}, false, false},
    SeedPack{7, {129, 129}, false, true}, SeedPack{8, {200, 257}, true, true},
};

io::LoadedPack make_pack(Random& random, PageOrder order, const SeedPack& seed) {
    const Shape shape = seed.lossless ? Shape::fractal : static_cast<Shape>(pick(random, 0, 4));
    baker::Dem dem = random_dem(random, seed.samples.column, seed.samples.row, shape);
    if (seed.lossless) make_lossless(dem);
    if (seed.holes) make_holes(dem);
    if (seed.log2 % 2 == 1) dem.crs_wkt = "LOCAL_CS[\"seed\"]";
    baker::BakeOptions options = small_bake(seed.log2);
    options.order = order;
    if (seed.log2 == 6 && seed.holes) options.horizon_spacing = 4;
    if (seed.log2 == 5 || seed.log2 == 6) options.layers_path = FJELL_SOURCE_DIR "/content/materials/splat/alpine.json";
    if (seed.log2 == 4) options.estimate = ErrorEstimate::midpoint;
    return bake_and_load(std::move(dem), options);
}

// As a pack set is to readers of packs: tiles are missing in the middle and at the rim.
io::LoadedPack make_sparse(Random& random) {
    const TemporaryFolder folder;
    (void)baker::bake(random_dem(random, 49, 33, Shape::fractal), small_bake(4), folder / "pack.fjell");
    (void)baker::split_pack(folder / "pack.fjell", folder / "set", {3, 2});
    const std::string path = folder / "set/set.json";
    io::SetFile set = io::parse_set_file(io::read_text(path), path);
    set.packs.erase(set.packs.begin() + 1);
    set.packs.pop_back();
    write_text(path, io::set_file_text(set));
    return io::load_pack(folder / "set", io::LoadTerrain::no);
}

// Coarse pages mostly, so that finer ones find theirs: fuzz_record's terrain has 2 tiles of 6 pages.
void script_pages(Random& random, session::RecordedFrame& frame) {
    for (int n = 0; n < 12; ++n)
        frame.pages.push_back({static_cast<std::uint32_t>(pick(random, 0, 1)),
                               static_cast<std::uint32_t>(std::min(pick(random, 0, 5), pick(random, 0, 5))),
                               pick(random, 0, 1) ? PageEvent::inserted : static_cast<PageEvent>(pick(random, 0, 3))});
    frame.missing_px = uniform(random, 0, 9);
}

// Short recordings of every kind of frame.
void make_recordings(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    Random random(32);
    for (int seed = 0; seed < 6; ++seed) {
        session::Recording recording;
        recording.budget.vertices = 4000;
        recording.page_slots = seed < 3 ? 0 : seed == 3 ? 5 : 12;
        for (int frame = 0; frame < 6; ++frame) {
            session::RecordedFrame f;
            f.rebuild = frame == 0 && seed % 2 == 0;
            for (int n = 0; n <= seed % 3; ++n) {
                const Vec3 eye{uniform(random, -100, 2000), uniform(random, 0, 900), uniform(random, -100, 2000)};
                f.views.push_back(make_view(eye, {1, -0.5, uniform(random, -1, 1)}, {0, 1, 0}, 0.8, 640, 480, 1, 1e5));
            }
            f.settings.max_error_px = std::pow(10.0, uniform(random, -1, 1.5));
            f.settings.max_work = frame % 2 ? unlimited_work : 50;
            f.settings.hysteresis = seed == 4 ? 0.5 : 0;
            f.settings.corner_safe = seed == 5;
            f.settings.morph = static_cast<Morph>(seed % 3);
            f.settings.now_s = frame / 60.0;
            if (seed >= 3) script_pages(random, f);
            recording.frames.push_back(f);
        }
        const std::string text = write_recording(recording);
        Bytes bytes;
        append(bytes, std::as_bytes(std::span(text)));
        write(folder / ("flight_" + std::to_string(seed)), bytes);
    }
}

void make_recipes(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "full.json") << R"({"inputs": ["a.tif", "/b/c.vrt"], "output": "o.fjell", "texture": "t.png",
"ramp": "r.json", "crs": "EPSG:32633", "encoding": "terrain-rgb", "nodata": "fill", "tile": 512, "estimate": "max",
"order": "hz", "horizons": "half", "layers": "l.json", "splat": "full", "spacing": 30.5, "zscale": -1e-3, "zoffset": 0, "nesting": 0.05, "quantum": 0.01,
"bbox": [-3.5, 1e2, 0, 4000000], "void": [-9999, "none"]})";
    std::ofstream(folder / "least.json") << R"({"inputs": []})";
}

void write_text(const std::filesystem::path& path, const std::string& text) {
    Bytes bytes;
    append(bytes, std::as_bytes(std::span(text)));
    write(path, bytes);
}

void copy_texts(const std::filesystem::path& to, const std::filesystem::path& from) {
    std::filesystem::create_directories(to);
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(FJELL_SOURCE_DIR) / from))
        if (entry.file_size() < most_seed_bytes)
            std::filesystem::copy_file(entry.path(), to / entry.path().filename(),
                                       std::filesystem::copy_options::overwrite_existing);
}

// Headers with two dimensions, an attribute and two variables, one of which has records.
void make_sets(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    write_text(folder / "full",
               R"({"fjell_set": 1, "columns": 129, "rows": 65, "tile_cells": 32, "spacing_m": [1.5, 2e0],
"made_by": {"a": [true, null, -1.5e-3, "x\u00e9\n"]}, "packs": [
{"file": "a/0-0.fjell", "tile_x": 0, "tile_y": 0, "tiles_x": 2, "tiles_y": 2, "pack_hash": "00ff00ff00ff00ff"},
{"tiles_y": 2, "file": "b\"\\.fjell", "tile_x": 2, "tile_y": 0, "tiles_x": 2, "pack_hash": ""}]})");
    write_text(folder / "least", R"({"fjell_set":1,"columns":2,"rows":2,"tile_cells":2,"spacing_m":[1,1],"packs":[
{"file":"p","tile_x":0,"tile_y":0,"tiles_x":1,"tiles_y":1}]})");
}

void make_netcdf(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    for (const int version : {1, 2, 5}) {
        std::string text = "CDF";
        text += static_cast<char>(version);
        const auto number = [&](std::uint64_t value, int bytes) {
            while (bytes-- > 0) text += static_cast<char>(value >> (8 * bytes) & 0xff);
        };
        const int wide = version == 5 ? 8 : 4, offset = version == 1 ? 4 : 8;
        const auto name = [&](const char* what) { number(4, wide), text += what; }; // of four letters
        number(3, wide);
        number(10, 4), number(2, wide);
        name("time"), number(0, wide), name("cols"), number(7, wide);
        number(12, 4), number(1, wide), name("unit"), number(2, 4), number(1, wide), text.append("m\0\0\0", 4);
        number(11, 4), number(2, wide);
        for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{1}}) {
            name("elev"), number(2 - first, wide); // dimensions
            for (std::uint64_t d = first; d < 2; ++d) number(d, wide);
            number(0, 4), number(0, wide);                       // no attributes
            number(3, 4), number(16, wide), number(300, offset); // shorts
        }
        write_text(folder / ("cdf" + std::to_string(version)), text);
    }
}

void make_checkpoint(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const std::string path = (folder / "taken").string();
    baker::Checkpoint checkpoint(path, "fuzz");
    checkpoint.state.complete = 401;
    checkpoint.state.spool.bytes = 12345;
    checkpoint.write();
    std::ifstream file(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    write_text(folder / "as_it_is", std::string(1, '\0') + bytes);
    write_text(path, std::string(1, '\1') + bytes);
}

// Rules, recipes, and a file of one small material, each behind the byte that says what it is.
void make_materials(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const auto copy = [&](const char* from, char kind) {
        for (const auto& entry : std::filesystem::directory_iterator(std::string(FJELL_SOURCE_DIR "/") + from)) {
            if (entry.path().extension() != ".json") continue;
            std::ifstream file(entry.path(), std::ios::binary);
            const std::string bytes(std::istreambuf_iterator<char>(file), {});
            write_text(folder / (kind + entry.path().filename().string()), kind + bytes);
        }
    };
    copy("content/materials/rules", 'b'); // 2 of 4
    copy("content/materials", 'c');       // 3 of 4
    write_text(folder / "rules", R"(b{"rules": [{"layer": "grass"}, {"layer": "rock", "slope_deg": [30, null]}]})");
    baker::MaterialRecipe recipe;
    recipe.name = "grey";
    recipe.base = {0.2f, 0.2f, 0.2f};
    const baker::EncodedMaterials encoded = baker::encode_materials({baker::make_material(recipe, 16)});
    const std::vector<std::byte> file = io::materials_file(encoded.materials);
    const std::string bytes(reinterpret_cast<const char*>(file.data()), file.size());
    write_text(folder / "as_it_is", 'd' + bytes);  // 0 of 4
    write_text(folder / "hash_fits", 'a' + bytes); // 1 of 4
}

// A journal's records without what fuzz_journal puts in: a byte for the kind, two for the length, the payload.
void make_journal(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const std::string path = (folder / "all").string();
    std::filesystem::remove(path);
    {
        PackHeader pack{};
        io::Journal journal(path, pack);
        const std::uint32_t low = journal.add_layer("low"), high = journal.add_layer("high");
        const std::string stamps = (std::filesystem::path(FJELL_SOURCE_DIR) / "content/edits/craters.json").string();
        std::vector<std::uint64_t> ids;
        for (const io::TimedStamp& stamp : io::read_stamps(stamps)) ids.push_back(journal.add_stamp(low, stamp.what));
        io::KeptStamp lock;
        lock.plain.shape = StampShape::lock, lock.plain.amount_m = 0.05f, lock.points = {{1, 2, 0}, {30, 40, 0}};
        ids.push_back(journal.add_stamp(low, lock));
        journal.set_layer({high, "higher", false, 0.5f, {}}, 0);
        journal.remove_stamps(std::span(ids).first(2));
        journal.remove_layer(high);
    }
    const std::vector<std::byte> file = io::read_file(path);
    std::string records;
    std::uint32_t head_bytes = 0;
    std::memcpy(&head_bytes, file.data() + 12, sizeof head_bytes);
    for (std::size_t at = head_bytes; at < file.size();) {
        std::uint32_t kind = 0;
        std::uint64_t bytes = 0;
        std::memcpy(&kind, file.data() + at + 4, sizeof kind);
        std::memcpy(&bytes, file.data() + at + 16, sizeof bytes);
        records += {static_cast<char>(kind), static_cast<char>(bytes & 0xff), static_cast<char>(bytes >> 8)};
        records.append(reinterpret_cast<const char*>(file.data() + at + 32), bytes);
        at += 32 + (bytes + 7) / 8 * 8;
    }
    write_text(folder / "all", records);
}

void make_seeds(const std::filesystem::path& folder) {
    make_recordings(folder / "record");
    make_recipes(folder / "recipe");
    copy_texts(folder / "terrain", {"content/terrain"});
    copy_texts(folder / "ramp", {"content/ramps"});
    copy_texts(folder / "path", {"content/paths"});
    write_text(folder / "path/recorded",
               "F 0  1 0 0  0 1 0  0 0 1  0.1 0.2 0.3  1\nF 0  1 0 0  0 1 0  0 0 1  0.2 0.2 0.3  1\n");
    copy_texts(folder / "profile", {"profiles"});
    copy_texts(folder / "stamps", {"content/edits"});
    write_text(folder / "stamps/all",
               R"({"stamps": [{"shape": "raise", "at": [300, 200], "radius_m": 90, "amount_m": 9},
{"shape": "noise", "at": [500, 300], "radius_m": 90, "falloff_m": 20, "amount_m": 5, "wavelength_m": 60, "seed": 3},
{"shape": "heights", "first": [3, 4], "columns": 2, "rows": 2, "heights_m": [1, null, 3, 4], "mask": [9, 9, 255, 0]},
{"frame": 2, "shape": "path", "radius_m": 30, "falloff_m": 20, "points": [[0, 0, 40], [400, 300, 90], [900, 100, 80]]},
{"frame": 1, "shape": "smooth", "at": [400, 400], "radius_m": 100}, {"frame": 3, "shape": "restore", "at": [400, 400],
"radius_m": 50, "falloff_m": 50}, {"shape": "level", "at": [100, 600], "radius_m": 70, "height_m": 50},
{"shape": "paint", "at": [300, 200], "radius_m": 60, "falloff_m": 20, "rgb": [200, 10, 10], "material": 3, "strength": 0.7},
{"shape": "unpaint", "points": [[0, 0], [400, 300]], "radius_m": 9},
{"frame": 2, "shape": "hole", "at": [420, 380], "radius_m": 40}, {"frame": 4, "shape": "fill", "at": [430, 380],
"radius_m": 30}, {"shape": "lock", "points": [[0, 0], [400, 300]], "radius_m": 9, "amount_m": 0.05}, {"frame": 1,
"shape": "unlock", "at": [300, 200], "radius_m": 60}]})");
    make_journal(folder / "journal");
    make_netcdf(folder / "netcdf");
    make_checkpoint(folder / "checkpoint");
    make_materials(folder / "materials");
    make_sets(folder / "set");
    SeedWriter seeds(folder);
    Random random(31);
    seeds.packs("sparse", make_sparse(random));
    for (const auto& [order, order_name] :
         {std::pair{PageOrder::planar, "planar"}, {PageOrder::hierarchical_z, "hz"}, {PageOrder::linear, "linear"}})
        for (const SeedPack& seed : seed_packs) {
            const auto pack = make_pack(random, order, seed);
            std::ostringstream name;
            name << order_name << '_' << seed.samples.column << 'x' << seed.samples.row;
            seeds.packs(name.str(), pack);
            seeds.pages(name.str(), pack);
        }
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
    try {
        make_seeds(argv[1]);
    } catch (const std::exception& e) {
        return std::fprintf(stderr, "%s: %s\n", argv[0], e.what()), 3;
    }
    return 0;
}
