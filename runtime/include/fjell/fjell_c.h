// The library for hosts in C (C99 and later), as fjell/fjell.h is for hosts in C++.
//
// Each function calls its counterpart in C++ and adds nothing. fjell_update_cut() calls fjell::update_cut(), and
// FjellCutReport is fjell::CutReport; the other names are formed alike. The C++ headers named below say what a function
// does, its units, ranges, ownership, threads, cost and failure. All of that applies in C too. Rules of C alone:
// - A span is two arguments or two fields: a pointer, and a count of elements. For memory the count is of bytes. NULL
//   is an empty span.
// - A handle is a value, as in C++ (fjell/handle.h): FjellTerrain terrain = {0}. Its fields belong to the library.
// - A descriptor or a report may grow in later versions. So it begins with struct_size, the sizeof that the host was
//   compiled with. Start a descriptor from its _default() function, and a report from {.struct_size = sizeof report}.
//   With an older host, new fields have their defaults, and reports do not write them. A struct_size that the library
//   does not know is refused with out_of_range, "struct_size". NULL instead of a descriptor means its defaults. NULL
//   instead of a report means that none is written.
// - All other structs stay the same while FJELL_VERSION_MINOR does.
// - Enumerators are constants. The type of an enumeration, e.g. FjellMorph, is an integer as wide as in C++.
// No function prints or throws. A function allocates only if its C++ header says that zstd may.
#ifndef FJELL_FJELL_C_H
#define FJELL_FJELL_C_H

#include "fjell/fjell_c_types.h"
#include "fjell/version.h"

FJELL_API_BEGIN
#ifdef __cplusplus
extern "C" {
#endif

// FJELL_VERSION of the linked library. The macro is the version of the headers.
int fjell_version(void);

// --- fjell/status.h ---

const char* fjell_message(FjellStatusCode code);

// --- fjell/asserts.h ---

bool fjell_set_assert_handler(FjellAssertHandler handler);

// --- fjell/pack.h ---

FjellStatus fjell_open_pack(const void* file, size_t file_bytes, FjellPack* pack);
FjellStatus fjell_open_index(const void* header, size_t header_bytes, const void* directory, size_t directory_bytes,
                             uint64_t file_bytes, FjellPack* pack);
FjellStatus fjell_read_header(const void* header, size_t header_bytes, uint64_t file_bytes, FjellPackHeader* out);
FjellStatus fjell_check_ranges(const FjellPackHeader* header);
FjellChunkEntry fjell_pack_entry(const FjellPack* pack, uint64_t chunk); // Pack::entry()
uint64_t fjell_chunk_index(const FjellPackHeader* header, FjellChunkId id);
FjellChunkId fjell_chunk_id(const FjellPackHeader* header, uint64_t chunk);
uint64_t fjell_chunk_count(const FjellPackHeader* header);
size_t fjell_chunk_raw_bytes(const FjellPackHeader* header, FjellChunkId id);
FjellStatus fjell_read_chunk(const FjellPack* pack, FjellChunkId id, void* out, size_t out_bytes);
FjellStatus fjell_decode_chunk(const FjellChunkEntry* entry, const void* stored, size_t stored_bytes, void* out,
                               size_t out_bytes);

uint32_t fjell_tiles_of(const FjellPackHeader* header);
uint64_t fjell_directory_bytes(const FjellPackHeader* header);
uint32_t fjell_pack_tile_place(const FjellPack* pack, uint32_t tile); // Pack::tile_place()

// --- fjell/pack_set.h ---

size_t fjell_set_index_bytes(FjellSetShape shape, const FjellSetPart* parts, size_t part_count);
FjellStatus fjell_make_set_index(FjellSetShape shape, const FjellSetPart* parts, size_t part_count, void* memory,
                                 size_t memory_bytes, FjellSetIndex* index, uint32_t* at_fault);
uint32_t fjell_set_part_at(const FjellSetPart* parts, size_t part_count, uint64_t offset, uint64_t* in_part);

// --- fjell/texture.h ---

FjellStatus fjell_decode_colour(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* rgb, size_t rgb_bytes);
FjellStatus fjell_decode_normal(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* xz, size_t xz_bytes);
FjellStatus fjell_decode_horizon(const void* blocks, size_t block_bytes, uint32_t side, uint8_t* codes,
                                 size_t code_bytes);

// --- fjell/terrain.h ---

size_t fjell_terrain_bytes(const FjellPackHeader* header, const FjellTerrainBudget* budget);
// corners: the stored bytes of their chunk, or NULL when the pack has the whole file.
FjellStatus fjell_create_terrain(const FjellPack* pack, const void* corners, size_t corner_bytes,
                                 const FjellTerrainBudget* budget, void* memory, size_t memory_bytes,
                                 FjellTerrain* terrain);
FjellStatus fjell_load_terrain(const FjellPack* pack, void* memory, size_t memory_bytes, FjellTerrain* terrain);
FjellStatus fjell_destroy_terrain(FjellTerrain terrain);
FjellStatus fjell_load_page(const FjellPack* pack, FjellTerrain terrain, uint32_t tile, uint32_t page);
FjellStatus fjell_insert_page(FjellTerrain terrain, uint32_t tile, uint32_t page, const void* raw, size_t raw_bytes);
FjellStatus fjell_unload_page(FjellTerrain terrain, uint32_t tile, uint32_t page);

// The members of Terrain.
bool fjell_terrain_valid(FjellTerrain terrain);
const FjellPackHeader* fjell_terrain_header(FjellTerrain terrain);
uint32_t fjell_terrain_columns(FjellTerrain terrain);
uint32_t fjell_terrain_rows(FjellTerrain terrain);
float fjell_terrain_spacing_x_m(FjellTerrain terrain);
float fjell_terrain_spacing_z_m(FjellTerrain terrain);
float fjell_terrain_x_m(FjellTerrain terrain, int32_t column);
float fjell_terrain_z_m(FjellTerrain terrain, int32_t row);
float fjell_terrain_extent_x_m(FjellTerrain terrain);
float fjell_terrain_extent_z_m(FjellTerrain terrain);
bool fjell_terrain_has_voids(FjellTerrain terrain);
uint32_t fjell_terrain_tile_count(FjellTerrain terrain);
uint32_t fjell_terrain_tile_at(FjellTerrain terrain, FjellSampleIndex place);
FjellSampleIndex fjell_terrain_tile_place(FjellTerrain terrain, uint32_t tile);
uint32_t fjell_terrain_pages_per_tile(FjellTerrain terrain);
uint32_t fjell_terrain_page_count(FjellTerrain terrain);
uint32_t fjell_terrain_page_slots(FjellTerrain terrain);
uint32_t fjell_terrain_pages_loaded(FjellTerrain terrain);
uint32_t fjell_terrain_pages_missing(FjellTerrain terrain);
double fjell_terrain_missing_px(FjellTerrain terrain);

// --- fjell/pages.h ---

uint32_t fjell_pages_per_tile(const FjellPackHeader* header);
int fjell_page_step_log2(const FjellPackHeader* header, uint32_t page);
uint32_t fjell_page_at(const FjellPackHeader* header, uint32_t step_log2, uint32_t x, uint32_t y);
uint32_t fjell_page_of(const FjellPackHeader* header, uint32_t x, uint32_t y);
bool fjell_page_loaded(FjellTerrain terrain, uint32_t tile, uint32_t page);
uint64_t fjell_page_changes(FjellTerrain terrain);
FjellStatus fjell_set_missing_px(FjellTerrain terrain, double missing_px);
FjellTerrainVertex fjell_terrain_vertex(FjellTerrain terrain, FjellSampleIndex sample);
double fjell_terrain_height_m(FjellTerrain terrain, double x_m, double z_m);

// --- fjell/view.h ---

// A view that is {.struct_size = sizeof view} is enough.
FjellStatus fjell_make_view(FjellVec3 eye_m, FjellVec3 forward, FjellVec3 up, double fov_y_rad, uint32_t width_px,
                            uint32_t height_px, double near_m, double far_m, FjellView* view);
FjellStatus fjell_validate_view(const FjellView* view);
FjellFrustum fjell_make_frustum(const FjellView* view);
double fjell_focal_length_px(const FjellView* view);
double fjell_corner_factor(const FjellView* view);

// --- fjell/cut.h ---

const char* fjell_cut_budget_field(uint32_t bit); // budget_field()
FjellStatus fjell_validate_cut_settings(const FjellCutSettings* settings);
size_t fjell_cut_bytes(FjellTerrain terrain, const FjellCutBudget* budget);
FjellStatus fjell_create_cut(FjellTerrain terrain, const FjellCutBudget* budget, void* memory, size_t memory_bytes,
                             FjellLiveCut* cut);
FjellStatus fjell_destroy_cut(FjellLiveCut cut);
FjellStatus fjell_update_cut(FjellLiveCut cut, const FjellView* views, size_t view_count,
                             const FjellCutSettings* settings, FjellCutReport* report);
FjellStatus fjell_rebuild_cut(FjellLiveCut cut, const FjellView* views, size_t view_count,
                              const FjellCutSettings* settings, FjellCutReport* report);
FjellStatus fjell_cut_release_page(FjellLiveCut cut, uint32_t tile, uint32_t page, bool* released);
FjellStatus fjell_cut_cancel_release(FjellLiveCut cut, uint32_t tile, uint32_t page);
float fjell_morph_age_s(float now_s, float then_s);
float fjell_morphed_height_m(FjellTerrain terrain, const FjellMeshVertex* vertex, const FjellMorphVertex* morph,
                             const FjellMorphFrame* frame);
FjellCutMesh fjell_cut_mesh(FjellLiveCut cut);
FjellCutChanges fjell_cut_take_changes(FjellLiveCut cut);
// for_each_run() as a loop: finds the next run. False: no run is left.
bool fjell_next_run(const uint64_t* bits, const uint32_t* words, size_t word_count, FjellRun* run);

// --- fjell/compact.h ---

// The three arrays of vertices have `count` records each, the two arrays of indices `count` indices each.
void fjell_compact_vertices(const FjellMeshVertex* vertices, const FjellMorphVertex* morphs, size_t count,
                            FjellCompactVertex* to);
void fjell_compact_indices(const uint32_t* indices, size_t count, uint16_t* to);
uint32_t fjell_index_bytes(const FjellCutBudget* budget); // 0 for a budget that is refused
double fjell_compact_share(const FjellMorphView* view);
float fjell_compact_rise_m(uint16_t rise);
float fjell_compact_length_m(uint16_t error_or_radius);

// --- fjell/recursive.h ---

size_t fjell_recursive_bytes(FjellTerrain terrain, const FjellRecursiveBudget* budget);
FjellStatus fjell_create_recursive(FjellTerrain terrain, const FjellRecursiveBudget* budget, void* memory,
                                   size_t memory_bytes, FjellRecursiveMethod* method);
FjellStatus fjell_destroy_recursive(FjellRecursiveMethod method);
FjellStatus fjell_update_recursive(FjellRecursiveMethod method, const FjellView* view,
                                   const FjellRefineSettings* settings, FjellFrameReport* report);
FjellMeshView fjell_recursive_mesh(FjellRecursiveMethod method);

// --- fjell/measure.h ---

// frustum: may be NULL.
FjellMeasuredError fjell_measure_error(FjellTerrain terrain, const FjellMeshView* mesh, const FjellView* view,
                                       const FjellFrustum* frustum);
// bound_error_px() of the two methods.
double fjell_bound_cut_error_px(FjellLiveCut cut, const FjellView* view, bool corner_safe, double at_least_px);
double fjell_bound_recursive_error_px(FjellRecursiveMethod method, const FjellView* view, bool corner_safe,
                                      double at_least_px);

// --- fjell/query.h ---

FjellGroundHeight fjell_ground_height(FjellTerrain terrain, double x_m, double z_m, float accurate_m);
FjellGroundHit fjell_cast_ray(FjellTerrain terrain, FjellVec3 origin_m, FjellVec3 direction, double most_m,
                              float accurate_m);
// holes: NULL if they are not wanted.
FjellGroundPatch fjell_ground_patch(FjellTerrain terrain, FjellSampleIndex first, int step_log2, uint32_t side,
                                    float* heights_m, size_t height_count, bool* holes, size_t hole_count);

// --- fjell/stream.h ---

FjellMapLayers fjell_map_layers(const FjellPackHeader* header, const FjellStreamBudget* budget, uint8_t kind);
uint64_t fjell_map_layer_bytes(const FjellMapLayers* sizes, uint8_t kind);
const char* fjell_stream_budget_field(uint32_t bit); // budget_field()
size_t fjell_stream_bytes(const FjellPack* pack, FjellTerrain terrain, const FjellStreamBudget* budget);
FjellStatus fjell_create_stream(const FjellPack* pack, FjellTerrain terrain, FjellLiveCut cut,
                                const FjellStreamBudget* budget, void* memory, size_t memory_bytes,
                                FjellStream* stream);
FjellStatus fjell_destroy_stream(FjellStream stream);
FjellStatus fjell_update_stream(FjellStream stream, const FjellView* views, size_t view_count,
                                const FjellCutSettings* cut, const FjellStreamSettings* settings,
                                FjellStreamReport* report);
FjellStatus fjell_stream_retry_failed(FjellStream stream);
// count: receives the number of elements at the returned pointer.
const FjellStreamFailure* fjell_stream_failures(FjellStream stream, size_t* count);
const FjellPageArrival* fjell_stream_page_arrivals(FjellStream stream, size_t* count);
const FjellMapCommand* fjell_stream_map_commands(FjellStream stream, size_t* count);
const FjellTileMap* fjell_stream_tile_maps(FjellStream stream, uint8_t kind, size_t* count);
FjellMapLayers fjell_stream_map_layers(FjellStream stream, uint8_t kind);
FjellStatus fjell_min_lod_grid(const FjellTileMap* maps, size_t map_count, uint32_t tiles_x, uint32_t tile,
                               float out[9]);
// min_lod_grid() of a terrain that may lack tiles.
FjellStatus fjell_min_lod_grid_of(const FjellTileMap* maps, size_t map_count, FjellTerrain terrain, uint32_t tile,
                                  float out[9]);
bool fjell_stream_next_request(FjellStream stream, FjellStreamRequest* request);
bool fjell_stream_still_wanted(FjellStream stream, uint32_t ticket);
FjellStatus fjell_stream_provide(FjellStream stream, uint32_t ticket, const void* stored, size_t stored_bytes);
FjellStatus fjell_stream_provide_decoded(FjellStream stream, uint32_t ticket, const void* decoded,
                                         size_t decoded_bytes);
FjellStatus fjell_stream_fail(FjellStream stream, uint32_t ticket, bool unwanted);

// --- fjell/edit.h ---

bool fjell_has_room_for_holes(const FjellPackHeader* header);
bool fjell_has_room_for_locks(const FjellPackHeader* header);
size_t fjell_edits_bytes(const FjellPackHeader* header, const FjellEditBudget* budget);
FjellStatus fjell_create_edits(FjellTerrain terrain, const FjellEditBudget* budget, void* memory, size_t memory_bytes,
                               FjellEdits* edits);
FjellStatus fjell_destroy_edits(FjellEdits edits);
FjellStatus fjell_check_stamp(const FjellStamp* stamp);
FjellStatus fjell_push_stamp(FjellEdits edits, const FjellStamp* stamp, uint64_t* id);
FjellStampResult fjell_stamp_state(FjellEdits edits, uint64_t id);
FjellStatus fjell_update_edits(FjellEdits edits, const FjellView* views, size_t view_count,
                               const FjellEditSettings* settings, FjellEditReport* report);
uint32_t fjell_count_always_drawn(FjellEdits edits);
uint32_t fjell_take_ground_changes(FjellEdits edits, uint64_t* cursor, FjellGroundRect* rects, size_t rect_count,
                                   bool* lost);

// --- fjell/ground_maps.h ---

size_t fjell_ground_maps_bytes(const FjellPackHeader* header, const FjellGroundMapsBudget* budget);
FjellStatus fjell_create_ground_maps(FjellTerrain terrain, const FjellGroundMapsBudget* budget, void* memory,
                                     size_t memory_bytes, FjellGroundMaps* maps);
FjellStatus fjell_destroy_ground_maps(FjellGroundMaps maps);
FjellStatus fjell_note_map_commands(FjellGroundMaps maps, const FjellMapCommand* commands, size_t command_count);
FjellStatus fjell_update_ground_maps(FjellGroundMaps maps, const FjellTileMap* normals, size_t normal_count,
                                     FjellGroundMapsReport* report);
const FjellMapPatch* fjell_ground_map_patches(FjellGroundMaps maps, size_t* count);
FjellStatus fjell_paint_map(FjellTerrain terrain, FjellMapKind map, uint32_t tile, uint32_t side_log2, void* blocks,
                            size_t block_bytes, bool* changed);
uint32_t fjell_take_paint_changes(FjellTerrain terrain, uint64_t* cursor, FjellGroundRect* rects, size_t rect_count,
                                  bool* lost);
size_t fjell_paint_bytes(FjellTerrain terrain);
FjellStatus fjell_copy_paint(FjellTerrain terrain, void* memory, size_t memory_bytes, FjellPaint* paint);
// By a copy: paint_map() with a Paint.
FjellStatus fjell_paint_map_of(FjellPaint paint, FjellMapKind map, uint32_t tile, uint32_t side_log2, void* blocks,
                               size_t block_bytes, bool* changed);

// --- defaults of the descriptors ---

// Sets as many fields as struct_size says. A host calls the _default() functions below instead. They are compiled into
// the host, so they return the fields that its header knows.
void fjell_set_default_terrain_budget(FjellTerrainBudget* budget);
void fjell_set_default_view(FjellView* view);
void fjell_set_default_cut_budget(FjellCutBudget* budget);
void fjell_set_default_cut_settings(FjellCutSettings* settings);
void fjell_set_default_recursive_budget(FjellRecursiveBudget* budget);
void fjell_set_default_refine_settings(FjellRefineSettings* settings);
void fjell_set_default_stream_budget(FjellStreamBudget* budget);
void fjell_set_default_stream_settings(FjellStreamSettings* settings);
void fjell_set_default_edit_budget(FjellEditBudget* budget);
void fjell_set_default_stamp(FjellStamp* stamp);
void fjell_set_default_edit_settings(FjellEditSettings* settings);
void fjell_set_default_ground_maps_budget(FjellGroundMapsBudget* budget);

#define FJELL_DEFAULT(Type, name)                                                                                      \
    static inline Type fjell_##name##_default(void) {                                                                  \
        Type descriptor;                                                                                               \
        descriptor.struct_size = sizeof descriptor;                                                                    \
        fjell_set_default_##name(&descriptor);                                                                         \
        return descriptor;                                                                                             \
    }
FJELL_DEFAULT(FjellTerrainBudget, terrain_budget) // fjell_terrain_budget_default()
FJELL_DEFAULT(FjellView, view)
FJELL_DEFAULT(FjellCutBudget, cut_budget)
FJELL_DEFAULT(FjellCutSettings, cut_settings)
FJELL_DEFAULT(FjellRecursiveBudget, recursive_budget)
FJELL_DEFAULT(FjellRefineSettings, refine_settings)
FJELL_DEFAULT(FjellStreamBudget, stream_budget)
FJELL_DEFAULT(FjellStreamSettings, stream_settings)
FJELL_DEFAULT(FjellEditBudget, edit_budget)
FJELL_DEFAULT(FjellStamp, stamp)
FJELL_DEFAULT(FjellEditSettings, edit_settings)
FJELL_DEFAULT(FjellGroundMapsBudget, ground_maps_budget)
#undef FJELL_DEFAULT

#ifdef __cplusplus
}
#endif
FJELL_API_END

#endif
