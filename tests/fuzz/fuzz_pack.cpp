// Whatever the bytes, reading a pack ends in a terrain or in a Status (invariant 10). What was accepted is then
// used: every chunk is read, the terrain is loaded as a whole and page by page into fewer slots than it has pages, and
// frames are refined in between, so that a hostile record cannot do harm either.
//
// Mutations hardly ever guess a 64-bit hash, so the script says whether to repair the hashes: then the cross-checks
// behind them, zstd and the records are what is attacked.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include <xxhash.h>

#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "input.h"
#include "shared/terrain_data.h"

namespace {

using namespace fjell;
using fuzz::must;
using fuzz::PackScript;

constexpr std::size_t most_bytes = std::size_t{64} << 20; // what a host would refuse to allocate is not read
constexpr std::uint32_t steps = 48, steps_a_frame = 24;   // of the page script

// Not io::allocate: its 2 MB pages cost more than all the rest, and here the end must be exact.
constexpr std::align_val_t alignment{64};
struct MemoryDelete {
    void operator()(std::byte* memory) const { ::operator delete[](memory, alignment); }
};
using Memory = std::unique_ptr<std::byte[], MemoryDelete>;
Memory allocate(std::size_t bytes) {
    return Memory(static_cast<std::byte*>(::operator new[](bytes, alignment)));
}

void repair(std::vector<std::byte>& bytes, bool directory_too) {
    const std::size_t size = bytes.size();
    if (size < sizeof(PackHeader)) return;
    PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    std::memcpy(h.magic, pack_magic, sizeof pack_magic);
    h.version = pack_version;
    h.features = features_of(h);
    h.header_bytes = sizeof h;
    h.layout_hash = pack_layout_hash;
    h.file_bytes = size;
    if (directory_too && check_ranges(h).ok()) {
        PackHeader put = h;
        put.directory_count = chunk_count(h);
        if (put.directory_count <= (size - sizeof h) / sizeof(ChunkEntry) && directory_bytes(put) <= size - sizeof h) {
            h.directory_count = put.directory_count;
            h.directory_offset = size - directory_bytes(h);
        }
    }
    if (h.directory_offset >= sizeof h && h.directory_offset <= size) {
        const std::size_t bytes_there = size - h.directory_offset;
        const std::size_t count = std::min<std::uint64_t>(bytes_there / sizeof(ChunkEntry), h.directory_count);
        std::byte* const directory = bytes.data() + h.directory_offset;
        for (std::size_t i = 0; i < count; ++i) {
            ChunkEntry e;
            std::memcpy(&e, directory + i * sizeof e, sizeof e);
            if (e.offset <= size && e.stored_bytes <= size - e.offset)
                e.hash = XXH3_64bits(bytes.data() + e.offset, e.stored_bytes);
            std::memcpy(directory + i * sizeof e, &e, sizeof e);
        }
        h.directory_hash = XXH3_64bits(directory, std::min<std::uint64_t>(directory_bytes(h), bytes_there));
    }
    h.header_hash = XXH3_64bits(&h, offsetof(PackHeader, header_hash));
    std::memcpy(bytes.data(), &h, sizeof h);
}

// Into a span that is exactly as long, and filled before.
Status read_into(const Pack& pack, ChunkId id, std::unique_ptr<std::byte[]>& raw, std::size_t bytes, int fill) {
    raw = std::make_unique_for_overwrite<std::byte[]>(bytes);
    std::memset(raw.get(), fill, bytes);
    return read_chunk(pack, id, {raw.get(), bytes});
}

void read_chunks(const Pack& pack) {
    std::unique_ptr<std::byte[]> a, b;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        const ChunkId id = chunk_id(pack.header, i);
        must(chunk_index(pack.header, id) == i, "chunk_id and chunk_index undo each other");
        const std::size_t bytes = pack.entry(i).raw_bytes;
        if (bytes > most_bytes) continue;
        const bool ok = read_into(pack, id, a, bytes, 0x00).ok();
        must(read_into(pack, id, b, bytes, 0xa5).ok() == ok, "a chunk is refused or not by its bytes alone");
        must(!ok || std::memcmp(a.get(), b.get(), bytes) == 0, "all of a chunk is decoded");
        must(!read_into(pack, id, b, bytes + 1, 0).ok(), "a chunk does not fill a longer span");
    }
}

// The page table and the slots say the same.
void check_pages(const Terrain& t) {
    std::uint32_t missing = 0;
    for (std::uint32_t page = 0; page < t.page_count(); ++page) {
        const PageEntry entry = data_of(t).page_table[page];
        if (entry.slot == no_index) {
            ++missing;
            continue;
        }
        must(entry.slot < data_of(t).slot_count && data_of(t).slot_page[entry.slot] == page,
             "a loaded page's slot names it");
        must(entry.base >= 0 && entry.base <= max_height_steps - 65535, "a page's heights lie on the height scale");
    }
    must(missing == t.pages_missing(), "pages_missing counts the pages that are missing");
    for (std::uint32_t slot = 0; slot < data_of(t).slot_count; ++slot)
        must(data_of(t).slot_page[slot] == no_index || (data_of(t).slot_page[slot] < t.page_count() &&
                                                        data_of(t).page_table[data_of(t).slot_page[slot]].slot == slot),
             "a slot's page lies there");
}

std::span<const VertexRecord> page_records(const Terrain& t, std::uint32_t page) {
    return {data_of(t).records + std::size_t{data_of(t).page_table[page].slot} * data_of(t).page_capacity,
            data_of(t).pages.page_vertices(page % t.pages_per_tile())};
}

// What a page decodes to does not depend on when it was loaded.
void check_records(const Terrain& t, const Terrain& whole) {
    for (std::uint32_t page = 0; page < t.page_count(); ++page) {
        if (data_of(t).page_table[page].slot == no_index) continue;
        must(data_of(t).page_table[page].base == data_of(whole).page_table[page].base, "a page has one base");
        const auto a = page_records(t, page), b = page_records(whole, page);
        must(std::memcmp(a.data(), b.data(), a.size_bytes()) == 0, "a page has the same records whenever it is loaded");
    }
}

// Inside a tile, where no other one has a say, a vertex of the mesh is the terrain's.
void check_vertex(const Terrain& t, std::uint32_t tile, const MeshVertex& v) {
    const std::int32_t side = data_of(t).tree.side();
    const SampleIndex place = t.tile_place(tile);
    const std::int32_t x = v.column - place.column * side, y = v.row - place.row * side;
    must(x >= 0 && y >= 0 && x <= side && y <= side, "a vertex lies in its tile");
    must(std::isfinite(v.height_m), "a height is finite");
    const SampleIndex at{v.column, v.row};
    if (x == 0 || y == 0 || x == side || y == side) return;
    if (at.column >= data_of(t).tree.columns() - 1 || at.row >= data_of(t).tree.rows() - 1)
        return; // others stand there, too
    const TerrainData::Vertex vertex = data_of(t).vertex(at);
    must(vertex.loaded && vertex.height_m == v.height_m, "a vertex of the mesh has the terrain's height");
}

void check_mesh(const Terrain& terrain, const MeshView& mesh) {
    constexpr std::uint32_t some = 7; // a vertex has about six indices
    for (const TileRange& range : mesh.tiles) {
        must(range.tile < terrain.tile_count(), "a range is of a tile");
        must(range.first_index <= mesh.indices.size() && range.index_count <= mesh.indices.size() - range.first_index,
             "a range lies in the indices");
        must(mesh.topology == Topology::strip || range.index_count == 3 * range.triangles, "three indices a triangle");
        const auto indices = mesh.indices.subspan(range.first_index, range.index_count);
        must(std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) { return i < mesh.vertices.size(); }),
             "an index is of a vertex");
        for (std::uint32_t i = 0; i < indices.size(); i += some)
            check_vertex(terrain, range.tile, mesh.vertices[indices[i]]);
    }
}

// What queries make of vertices here and there, of missing pages too.
void query(const Terrain& t) {
    const std::int32_t columns = data_of(t).tree.grid_columns(), rows = data_of(t).tree.grid_rows();
    for (std::int32_t i = 0; i < 64; ++i) {
        const SampleIndex at{i * 37 % columns, (i * 101 + i / 8) % rows};
        const TerrainData::Vertex v = data_of(t).vertex(at);
        must(v.loaded || t.pages_missing() != 0, "a vertex is there when its page is");
        must(v.steps >= 0 && v.steps <= max_height_steps, "a height lies on the height scale");
        must(std::isfinite(v.height_m) && v.error_m >= 0 && v.radius_m >= 0, "a vertex' numbers are finite");
        must(std::isfinite(data_of(t).ground_m(i * t.header().spacing_m[0] - 0.3, i * 1.7 * t.header().spacing_m[1])),
             "the ground is somewhere");
        (void)data_of(t).is_hole(data_of(t).tree.sample(at));
    }
}

// A recursive method with its memory, and frames that the script describes.
struct Refiner {
    Refiner(const Terrain& the_terrain, const PackScript& the_script) : terrain(the_terrain), script(the_script) {
        const std::uint32_t tiles = terrain.tile_count();
        RecursiveBudget budget{4096 + 4 * tiles, 16384 + 9 * tiles};
        if (script.frame & 1) budget.vertices = 4 * tiles + script.eye; // hardly enough
        if (script.frame & 64) budget.indices = 9 * tiles + 2u * script.eye;
        const std::size_t bytes = recursive_bytes(terrain, budget);
        if (bytes > most_bytes || bytes == 0) return; // 0: tiles are missing, or there are too many vertices
        memory = allocate(bytes);
        must(create_recursive(terrain, budget, {memory.get(), bytes}, method).ok(), "a method for what was loaded");
    }

    void frames() {
        if (!memory) return;
        RefineSettings settings;
        settings.max_error_px = script.frame & 2 ? 1e-3 : script.frame & 4 ? 50 : 1;
        settings.corner_safe = (script.frame & 8) != 0;
        settings.cull = (script.frame & 48) != 0;
        settings.metric = (script.frame & 48) == 48 ? Metric::depth : Metric::isotropic;
        const View view = look(number++);
        const Frustum frustum = make_frustum(view);
        for (const Topology topology : {Topology::triangles, Topology::strip}) {
            settings.topology = topology;
            FrameReport report;
            must(update_recursive(method, view, settings, report).ok(), "a frame of what was loaded");
            const MeshView mesh = recursive_mesh(method);
            check_mesh(terrain, mesh);
            if (terrain.pages_missing() == 0)
                (void)measure_error(terrain, mesh, view, topology == Topology::strip ? &frustum : nullptr);
        }
    }

private:
    [[nodiscard]] View look(std::uint32_t frame) const {
        const double wx = terrain.x_m(data_of(terrain).tree.columns() - 1),
                     wz = terrain.z_m(data_of(terrain).tree.rows() - 1);
        const double extent = std::max(wx, wz);
        const std::uint32_t bits = script.eye + 37 * frame;
        const double ground = data_of(terrain).height_m({0, 0});
        const double above = extent * std::pow(10.0, bits / 5 % 5 - 4.0);
        const Vec3 eye{(bits % 5 - 0.5) / 3 * wx, ground + above, (bits / 25 % 5 - 0.5) / 3 * wz};
        const double far = length(eye) / 9e7; // no view is from further than 100,000 km
        const Vec3 forward{bits / 125 % 3 * 0.5 * wx - eye.x, -above, bits / 7 % 3 * 0.4 * wz - eye.z};
        return make_view(far > 1 ? eye * (1 / far) : eye, forward, {0.1, 1, 0.2}, 1, 640, 480, extent * 1e-5,
                         extent * 8);
    }

    const Terrain& terrain;
    const PackScript& script;
    Memory memory;
    RecursiveMethod method;
    std::uint32_t number = 0;
};

// One step of the page script: a page comes or goes. whole: the terrain with all of its pages, if they can be loaded.
void move_page(const Pack& pack, Terrain& terrain, std::uint32_t bits, bool unload, bool whole) {
    const std::uint32_t page = bits % terrain.page_count(), tile = page / terrain.pages_per_tile(),
                        item = page % terrain.pages_per_tile();
    if (unload) return (void)unload_page(terrain, tile, item);
    const bool there = data_of(terrain).page_table[page].slot != no_index;
    const std::uint64_t changes = data_of(terrain).changes;
    const Status s = load_page(pack, terrain, tile, item);
    switch (s.code) {
    case StatusCode::ok:
        must(data_of(terrain).page_table[page].slot != no_index, "a page that was loaded is there");
        break;
    case StatusCode::out_of_slots: {
        const std::uint32_t leaves = data_of(terrain).slot_page[bits / 7 % data_of(terrain).slot_count];
        must(!there && leaves != no_index, "no slot is free");
        return (void)unload_page(terrain, leaves / terrain.pages_per_tile(), leaves % terrain.pages_per_tile());
    }
    case StatusCode::coarser_page_first:
        must(data_of(terrain).pages.page_step_log2(item) == 0, "only errors of the finest step are derived");
        break;
    case StatusCode::corrupt: must(!whole, "a page that could be loaded can be loaded again"); break;
    default: must(false, "a page is loaded, or refused for one of three reasons");
    }
    must(data_of(terrain).changes == changes + (s.ok() && !there ? 1 : 0), "what fails changes nothing");
}

void page_by_page(const Pack& pack, const PackScript& script, const Terrain* whole) {
    const std::uint32_t pages = pack.tile_count() * pages_of(pack.header).pages_per_tile();
    const TerrainBudget budget{1 + script.slots % std::max(pages - 1, 1u)};
    const std::size_t bytes = terrain_bytes(pack.header, budget);
    if (bytes > most_bytes) return;
    const Memory memory = allocate(bytes);
    Terrain terrain;
    if (!create_terrain(pack, budget, {memory.get(), bytes}, terrain).ok()) {
        must(!whole, "a terrain that could be created can be created with fewer slots");
        return;
    }
    must(load_page(pack, terrain, terrain.tile_count(), 0).code == StatusCode::out_of_range &&
             load_page(pack, terrain, 0, terrain.pages_per_tile()).code == StatusCode::out_of_range,
         "there are no other pages");
    Refiner refiner(terrain, script);
    refiner.frames();
    std::uint32_t bits = script.slots;
    for (std::uint32_t step = 0; step < steps; ++step) {
        const std::uint8_t order = script.pages[step % std::size(script.pages)];
        bits = bits * 1664525 + 1013904223 + order;
        move_page(pack, terrain, bits >> 8, order < 64 && (bits & 32) != 0, whole != nullptr);
        if (step % steps_a_frame != steps_a_frame - 1) continue;
        check_pages(terrain);
        query(terrain);
        if (whole) check_records(terrain, *whole);
        refiner.frames();
    }
}

void use(const Pack& pack, const PackScript& script) {
    read_chunks(pack);
    const std::size_t bytes = terrain_bytes(pack.header);
    if (bytes > most_bytes) return;
    const Memory memory = allocate(bytes);
    Terrain whole;
    must(!load_terrain(pack, {memory.get(), bytes - 64}, whole).ok(), "memory that is too small is refused");
    const bool loaded = load_terrain(pack, {memory.get(), bytes}, whole).ok();
    if (loaded) {
        check_pages(whole);
        query(whole);
        Refiner(whole, script).frames();
    }
    page_by_page(pack, script, loaded ? &whole : nullptr);
}

} // namespace

extern "C" int fuzz_pack(const std::uint8_t* data, std::size_t size) {
    PackScript script;
    if (size < sizeof script) return 0;
    std::memcpy(&script, data, sizeof script);
    const auto input = std::as_bytes(std::span(data, size)).subspan(sizeof script);
    std::vector<std::byte> bytes(input.begin(), input.end());
    if (script.repairs & fuzz::repair_hashes) repair(bytes, (script.repairs & fuzz::repair_directory) != 0);
    Pack pack;
    if (open_pack(bytes, pack).ok()) use(pack, script);
    return 0;
}
