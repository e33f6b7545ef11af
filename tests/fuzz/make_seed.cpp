// Writes seeds into FOLDER/pack for fuzz_pack and into FOLDER/page for fuzz_page: small packs in every order, with
// tiles of 2 to 64 cells, with and without holes, lossless and not, and their pages decompressed.
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
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "input.h"
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
        directory.push_back(
            {offset, 0, static_cast<std::uint32_t>(out.size() - offset), static_cast<std::uint32_t>(raw.size())});
    }
    h.directory_offset = out.size();
    append(out, std::as_bytes(std::span(directory)));
    h.file_bytes = out.size();
    std::memcpy(out.data(), &h, sizeof h);
    return out;
}

class SeedWriter {
public:
    explicit SeedWriter(const std::filesystem::path& folder) : packs_(folder / "pack"), pages_(folder / "page") {
        for (const auto& f : {packs_, pages_}) {
            std::filesystem::remove_all(f); // no seed of an earlier format
            std::filesystem::create_directories(f);
        }
    }

    void packs(const std::string& name, const host::LoadedPack& pack) {
        PackScript script{};
        for (std::uint8_t& b : script.pages) b = static_cast<std::uint8_t>(pick(random_, 0, 255));
        script.slots = static_cast<std::uint8_t>(pick(random_, 0, 255));
        script.eye = static_cast<std::uint8_t>(pick(random_, 0, 255));
        const auto one = [&](const char* suffix, unsigned repairs, const Bytes& bytes) {
            script.repairs = static_cast<std::uint8_t>(repairs);
            script.frame = static_cast<std::uint8_t>(pick(random_, 0, 63));
            Bytes seed;
            append_value(seed, script);
            append(seed, bytes);
            write(packs_ / (name + suffix), seed);
        };
        one("_as_it_is", 0, pack.file);
        one("_repaired", fuzz::repair_hashes, pack.file);
        one("_uncompressed", fuzz::repair_hashes | fuzz::repair_directory, uncompressed(pack.pack));
    }

    // The first page, and the first and the last one of the finest step.
    void pages(const std::string& name, const host::LoadedPack& pack) {
        const PageLayout layout = pack.pack.pages();
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

// 1,023 of a hundredth of the spacing: residuals of one byte where the ground is smooth.
void make_lossless(baker::Dem& dem) {
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const float quantum = std::max(1e-3f, (*most - *least) / 1023), base = *least;
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

host::LoadedPack make_pack(Random& random, Order order, int log2, Coord samples, bool holes, bool lossless) {
    const Shape shape = lossless ? Shape::fractal : static_cast<Shape>(pick(random, 0, 4));
    baker::Dem dem = random_dem(random, samples.x, samples.y, shape);
    if (lossless) make_lossless(dem);
    if (holes) make_holes(dem);
    if (log2 % 2 == 1) dem.crs_wkt = "LOCAL_CS[\"seed\"]";
    baker::BakeOptions options = small_bake(log2);
    options.order = order;
    if (log2 == 4) options.estimate = Estimate::midpoint;
    return bake_and_load(std::move(dem), options);
}

void make_seeds(const std::filesystem::path& folder) {
    // Tiles by their size; some end within the terrain's rim. 90 x 60 in tiles of 64: two tiles, both rims, two pages
    // each.
    struct Size {
        int log2;
        Coord samples;
    };
    constexpr std::array sizes{Size{1, {4, 3}},   Size{2, {9, 5}},   Size{3, {17, 12}}, Size{4, {17, 17}},
                               Size{5, {40, 33}}, Size{6, {65, 65}}, Size{6, {90, 60}}};
    constexpr std::array large{Size{7, {129, 129}}, Size{8, {200, 257}}}; // for single pages
    SeedWriter seeds(folder);
    Random random(31);
    unsigned number = 0;
    for (const Order order : {Order::planar, Order::hierarchical_z, Order::linear}) {
        const auto make = [&](const Size& size, bool holes, bool lossless) {
            return make_pack(random, order, size.log2, size.samples, holes, lossless);
        };
        const auto name = [&](const Size& size) {
            constexpr const char* orders[] = {"planar", "hz", "linear"};
            return std::string(orders[static_cast<int>(order)]) + "_" + std::to_string(size.samples.x) + "x" +
                   std::to_string(size.samples.y);
        };
        for (const Size& size : sizes) {
            const unsigned kind = number++;
            const auto pack = make(size, (kind & 1) != 0, (kind & 2) != 0);
            seeds.packs(name(size), pack);
            seeds.pages(name(size), pack);
        }
        for (const Size& size : large) seeds.pages(name(size), make(size, size.log2 == 8, true));
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
