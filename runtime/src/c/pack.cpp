// fjell/fjell_c.h: packs, maps, terrains and queries.
#include "shared/c_convert.h"

using namespace fjell;
using namespace fjell::c_api;

int fjell_version(void) {
    return FJELL_VERSION;
}
const char* fjell_message(FjellStatusCode code) {
    return message(static_cast<StatusCode>(code));
}
bool fjell_set_assert_handler(FjellAssertHandler handler) {
    return set_assert_handler(handler);
}

// --- fjell/pack.h ---

FjellStatus fjell_open_pack(const void* file, size_t file_bytes, FjellPack* pack) {
    if (pack == nullptr) return refused("pack");
    Pack opened;
    return give(open_pack(span_of(file, file_bytes), opened), opened, pack);
}
FjellStatus fjell_open_index(const void* header, size_t header_bytes, const void* directory, size_t directory_bytes,
                             uint64_t file_bytes, FjellPack* pack) {
    if (pack == nullptr) return refused("pack");
    Pack opened;
    return give(open_index(span_of(header, header_bytes), span_of(directory, directory_bytes), file_bytes, opened),
                opened, pack);
}
FjellStatus fjell_read_header(const void* header, size_t header_bytes, uint64_t file_bytes, FjellPackHeader* out) {
    if (out == nullptr) return refused("out");
    PackHeader read{};
    return give(read_header(span_of(header, header_bytes), file_bytes, read), read, out);
}
FjellStatus fjell_check_ranges(const FjellPackHeader* header) {
    return to_c(check_ranges(at(header)));
}
FjellChunkEntry fjell_pack_entry(const FjellPack* pack, uint64_t chunk) {
    return to_c(at(pack).entry(chunk));
}
uint64_t fjell_chunk_index(const FjellPackHeader* header, FjellChunkId id) {
    return chunk_index(at(header), to_cpp(id));
}
FjellChunkId fjell_chunk_id(const FjellPackHeader* header, uint64_t chunk) {
    return to_c(chunk_id(at(header), chunk));
}
uint64_t fjell_chunk_count(const FjellPackHeader* header) {
    return chunk_count(at(header));
}
size_t fjell_chunk_raw_bytes(const FjellPackHeader* header, FjellChunkId id) {
    return chunk_raw_bytes(at(header), to_cpp(id));
}
FjellStatus fjell_read_chunk(const FjellPack* pack, FjellChunkId id, void* out, size_t out_bytes) {
    return to_c(read_chunk(at(pack), to_cpp(id), span_of(out, out_bytes)));
}
FjellStatus fjell_decode_chunk(const FjellChunkEntry* entry, const void* stored, size_t stored_bytes, void* out,
                               size_t out_bytes) {
    return to_c(decode_chunk(at(entry), span_of(stored, stored_bytes), span_of(out, out_bytes)));
}

uint32_t fjell_tiles_of(const FjellPackHeader* header) {
    return tiles_of(at(header));
}
uint64_t fjell_directory_bytes(const FjellPackHeader* header) {
    return directory_bytes(at(header));
}
uint32_t fjell_pack_tile_place(const FjellPack* pack, uint32_t tile) {
    return at(pack).tile_place(tile);
}

// --- fjell/pack_set.h ---

size_t fjell_set_index_bytes(FjellSetShape shape, const FjellSetPart* parts, size_t part_count) {
    return set_index_bytes(to_cpp(shape), span_of(reinterpret_cast<const SetPart*>(parts), part_count));
}
FjellStatus fjell_make_set_index(FjellSetShape shape, const FjellSetPart* parts, size_t part_count, void* memory,
                                 size_t memory_bytes, FjellSetIndex* index, uint32_t* at_fault) {
    if (index == nullptr) return refused("index");
    SetIndex made;
    std::uint32_t part = 0;
    const Status status = make_set_index(to_cpp(shape), span_of(reinterpret_cast<const SetPart*>(parts), part_count),
                                         span_of(memory, memory_bytes), made, part);
    if (at_fault != nullptr) *at_fault = part;
    return give(status, made, index);
}
uint32_t fjell_set_part_at(const FjellSetPart* parts, size_t part_count, uint64_t offset, uint64_t* in_part) {
    std::uint64_t there = 0;
    const std::uint32_t part = set_part_at(span_of(reinterpret_cast<const SetPart*>(parts), part_count), offset, there);
    if (in_part != nullptr) *in_part = there;
    return part;
}

// --- fjell/texture.h ---

FjellStatus fjell_decode_colour(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* rgb, size_t rgb_bytes) {
    return to_c(decode_colour(span_of(blocks, block_bytes), side, span_of(rgb, rgb_bytes)));
}
FjellStatus fjell_decode_normal(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* xz, size_t xz_bytes) {
    return to_c(decode_normal(span_of(blocks, block_bytes), side, span_of(xz, xz_bytes)));
}
FjellStatus fjell_decode_horizon(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* codes,
                                 size_t code_bytes) {
    return to_c(decode_horizon(span_of(blocks, block_bytes), side, span_of(codes, code_bytes)));
}

// --- fjell/terrain.h ---

void fjell_set_default_terrain_budget(FjellTerrainBudget* budget) {
    write(TerrainBudget{}, budget);
}
size_t fjell_terrain_bytes(const FjellPackHeader* header, const FjellTerrainBudget* budget) {
    const In in(budget);
    return in.ok ? terrain_bytes(at(header), in.value) : 0;
}
FjellStatus fjell_create_terrain(const FjellPack* pack, const void* corners, size_t corner_bytes,
                                 const FjellTerrainBudget* budget, void* memory, size_t memory_bytes,
                                 FjellTerrain* terrain) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (terrain == nullptr) return refused("terrain");
    const std::span<std::byte> given = span_of(memory, memory_bytes);
    Terrain made;
    return give(corners == nullptr ? create_terrain(at(pack), in.value, given, made)
                                   : create_terrain(at(pack), span_of(corners, corner_bytes), in.value, given, made),
                made, terrain);
}
FjellStatus fjell_load_terrain(const FjellPack* pack, void* memory, size_t memory_bytes, FjellTerrain* terrain) {
    if (terrain == nullptr) return refused("terrain");
    Terrain made;
    return give(load_terrain(at(pack), span_of(memory, memory_bytes), made), made, terrain);
}
FjellStatus fjell_destroy_terrain(FjellTerrain terrain) {
    return to_c(destroy_terrain(to_cpp(terrain)));
}
FjellStatus fjell_load_page(const FjellPack* pack, FjellTerrain terrain, uint32_t tile, uint32_t page) {
    return to_c(load_page(at(pack), to_cpp(terrain), tile, page));
}
FjellStatus fjell_insert_page(FjellTerrain terrain, uint32_t tile, uint32_t page, const void* raw, size_t raw_bytes) {
    return to_c(insert_page(to_cpp(terrain), tile, page, span_of(raw, raw_bytes)));
}
FjellStatus fjell_unload_page(FjellTerrain terrain, uint32_t tile, uint32_t page) {
    return to_c(unload_page(to_cpp(terrain), tile, page));
}

bool fjell_terrain_valid(FjellTerrain terrain) {
    return to_cpp(terrain).valid();
}
const FjellPackHeader* fjell_terrain_header(FjellTerrain terrain) {
    return reinterpret_cast<const FjellPackHeader*>(&to_cpp(terrain).header()); // it lies in the terrain
}
uint32_t fjell_terrain_columns(FjellTerrain terrain) {
    return to_cpp(terrain).columns();
}
uint32_t fjell_terrain_rows(FjellTerrain terrain) {
    return to_cpp(terrain).rows();
}
float fjell_terrain_spacing_x_m(FjellTerrain terrain) {
    return to_cpp(terrain).spacing_x_m();
}
float fjell_terrain_spacing_z_m(FjellTerrain terrain) {
    return to_cpp(terrain).spacing_z_m();
}
float fjell_terrain_x_m(FjellTerrain terrain, int32_t column) {
    return to_cpp(terrain).x_m(column);
}
float fjell_terrain_z_m(FjellTerrain terrain, int32_t row) {
    return to_cpp(terrain).z_m(row);
}
float fjell_terrain_extent_x_m(FjellTerrain terrain) {
    return to_cpp(terrain).extent_x_m();
}
float fjell_terrain_extent_z_m(FjellTerrain terrain) {
    return to_cpp(terrain).extent_z_m();
}
bool fjell_terrain_has_voids(FjellTerrain terrain) {
    return to_cpp(terrain).has_voids();
}
uint32_t fjell_terrain_tile_count(FjellTerrain terrain) {
    return to_cpp(terrain).tile_count();
}
uint32_t fjell_terrain_tile_at(FjellTerrain terrain, FjellSampleIndex place) {
    return to_cpp(terrain).tile_at(to_cpp(place));
}
FjellSampleIndex fjell_terrain_tile_place(FjellTerrain terrain, uint32_t tile) {
    return to_c(to_cpp(terrain).tile_place(tile));
}
uint32_t fjell_terrain_pages_per_tile(FjellTerrain terrain) {
    return to_cpp(terrain).pages_per_tile();
}
uint32_t fjell_terrain_page_count(FjellTerrain terrain) {
    return to_cpp(terrain).page_count();
}
uint32_t fjell_terrain_page_slots(FjellTerrain terrain) {
    return to_cpp(terrain).page_slots();
}
uint32_t fjell_terrain_pages_loaded(FjellTerrain terrain) {
    return to_cpp(terrain).pages_loaded();
}
uint32_t fjell_terrain_pages_missing(FjellTerrain terrain) {
    return to_cpp(terrain).pages_missing();
}
double fjell_terrain_missing_px(FjellTerrain terrain) {
    return to_cpp(terrain).missing_px();
}

// --- fjell/pages.h ---

uint32_t fjell_pages_per_tile(const FjellPackHeader* header) {
    return pages_per_tile(at(header));
}
int fjell_page_step_log2(const FjellPackHeader* header, uint32_t page) {
    return page_step_log2(at(header), page);
}
uint32_t fjell_page_at(const FjellPackHeader* header, uint32_t step_log2, uint32_t x, uint32_t y) {
    return page_at(at(header), step_log2, x, y);
}
uint32_t fjell_page_of(const FjellPackHeader* header, uint32_t x, uint32_t y) {
    return page_of(at(header), x, y);
}
bool fjell_page_loaded(FjellTerrain terrain, uint32_t tile, uint32_t page) {
    return page_loaded(to_cpp(terrain), tile, page);
}
uint64_t fjell_page_changes(FjellTerrain terrain) {
    return page_changes(to_cpp(terrain));
}
FjellStatus fjell_set_missing_px(FjellTerrain terrain, double missing_px) {
    return to_c(set_missing_px(to_cpp(terrain), missing_px));
}
FjellTerrainVertex fjell_terrain_vertex(FjellTerrain terrain, FjellSampleIndex sample) {
    return to_c(terrain_vertex(to_cpp(terrain), to_cpp(sample)));
}
double fjell_terrain_height_m(FjellTerrain terrain, double x_m, double z_m) {
    return terrain_height_m(to_cpp(terrain), x_m, z_m);
}

// --- fjell/query.h ---

FjellGroundHeight fjell_ground_height(FjellTerrain terrain, double x_m, double z_m, float accurate_m) {
    return to_c(ground_height(to_cpp(terrain), x_m, z_m, accurate_m));
}
FjellGroundHit fjell_cast_ray(FjellTerrain terrain, FjellVec3 origin_m, FjellVec3 direction, double most_m,
                              float accurate_m) {
    return to_c(cast_ray(to_cpp(terrain), to_cpp(origin_m), to_cpp(direction), most_m, accurate_m));
}
FjellGroundPatch fjell_ground_patch(FjellTerrain terrain, FjellSampleIndex first, int step_log2, uint32_t side,
                                    float* heights_m, size_t height_count, bool* holes, size_t hole_count) {
    return to_c(ground_patch(to_cpp(terrain), to_cpp(first), step_log2, side, span_of(heights_m, height_count),
                             span_of(holes, hole_count)));
}
