// The types of C against those of C++: every field at the same place, of descriptors and reports behind struct_size,
// and every number the same. Compiles to nothing.
#include <type_traits>

#include "c/convert.h"

namespace fjell::c_api {

#define FJELL_SIZE(type)                                                                                               \
    static_assert(sizeof(type) == (before<type> + sizeof(CppOf<type>::Type) + alignof(type) - 1) / alignof(type) *     \
                                      alignof(type) &&                                                                 \
                      std::is_trivially_copyable_v<CppOf<type>::Type>,                                                 \
                  "the C++ type has changed: change fjell/fjell_c_types.h with it")
#define FJELL_FIELD(type, field)                                                                                       \
    static_assert(offsetof(type, field) == before<type> + offsetof(CppOf<type>::Type, field) &&                        \
                      sizeof(type::field) == sizeof(CppOf<type>::Type::field),                                         \
                  "the C++ type has changed: change fjell/fjell_c_types.h with it")

FJELL_SIZE(FjellStatus);
FJELL_FIELD(FjellStatus, code);
FJELL_FIELD(FjellStatus, field);

FJELL_SIZE(FjellCoord);
FJELL_FIELD(FjellCoord, x);
FJELL_FIELD(FjellCoord, y);

FJELL_SIZE(FjellPackHeader);
FJELL_FIELD(FjellPackHeader, magic);
FJELL_FIELD(FjellPackHeader, version);
FJELL_FIELD(FjellPackHeader, header_bytes);
FJELL_FIELD(FjellPackHeader, layout_hash);
FJELL_FIELD(FjellPackHeader, file_bytes);
FJELL_FIELD(FjellPackHeader, directory_offset);
FJELL_FIELD(FjellPackHeader, directory_count);
FJELL_FIELD(FjellPackHeader, directory_hash);
FJELL_FIELD(FjellPackHeader, columns);
FJELL_FIELD(FjellPackHeader, rows);
FJELL_FIELD(FjellPackHeader, tiles_x);
FJELL_FIELD(FjellPackHeader, tiles_y);
FJELL_FIELD(FjellPackHeader, tile_log2);
FJELL_FIELD(FjellPackHeader, order);
FJELL_FIELD(FjellPackHeader, estimate);
FJELL_FIELD(FjellPackHeader, nesting);
FJELL_FIELD(FjellPackHeader, spacing_m);
FJELL_FIELD(FjellPackHeader, origin_m);
FJELL_FIELD(FjellPackHeader, base_m);
FJELL_FIELD(FjellPackHeader, quantum_m);
FJELL_FIELD(FjellPackHeader, min_m);
FJELL_FIELD(FjellPackHeader, max_m);
FJELL_FIELD(FjellPackHeader, max_error_m);
FJELL_FIELD(FjellPackHeader, colour_log2);
FJELL_FIELD(FjellPackHeader, normal_log2);
FJELL_FIELD(FjellPackHeader, crs_bytes);
FJELL_FIELD(FjellPackHeader, error_floor_m);
FJELL_FIELD(FjellPackHeader, error_ratio);
FJELL_FIELD(FjellPackHeader, error_nesting_steps);
FJELL_FIELD(FjellPackHeader, height_steps);
FJELL_FIELD(FjellPackHeader, voids);
FJELL_FIELD(FjellPackHeader, level_radius_m);
FJELL_FIELD(FjellPackHeader, crs_step);
FJELL_FIELD(FjellPackHeader, notes_offset);
FJELL_FIELD(FjellPackHeader, notes_hash);
FJELL_FIELD(FjellPackHeader, notes_bytes);
FJELL_FIELD(FjellPackHeader, horizon_log2);
FJELL_FIELD(FjellPackHeader, tiles_held);
FJELL_FIELD(FjellPackHeader, control_log2);
FJELL_FIELD(FjellPackHeader, layer_bytes);
FJELL_FIELD(FjellPackHeader, features);
FJELL_FIELD(FjellPackHeader, reserved);
FJELL_FIELD(FjellPackHeader, header_hash);

FJELL_SIZE(FjellPageBound);
FJELL_FIELD(FjellPageBound, low);
FJELL_FIELD(FjellPageBound, high);
FJELL_FIELD(FjellPageBound, error);
FJELL_FIELD(FjellPageBound, radius);
FJELL_FIELD(FjellPageBound, reserved);

FJELL_SIZE(FjellChunkEntry);
FJELL_FIELD(FjellChunkEntry, offset);
FJELL_FIELD(FjellChunkEntry, hash);
FJELL_FIELD(FjellChunkEntry, stored_bytes);
FJELL_FIELD(FjellChunkEntry, raw_bytes);
FJELL_FIELD(FjellChunkEntry, bound);

FJELL_SIZE(FjellChunkId);
FJELL_FIELD(FjellChunkId, kind);
FJELL_FIELD(FjellChunkId, tile);
FJELL_FIELD(FjellChunkId, item);

FJELL_SIZE(FjellPack);
FJELL_FIELD(FjellPack, header);
FJELL_FIELD(FjellPack, directory);

FJELL_SIZE(FjellSetPart);
FJELL_FIELD(FjellSetPart, tile_x);
FJELL_FIELD(FjellSetPart, tile_y);

FJELL_SIZE(FjellSetShape);
FJELL_FIELD(FjellSetShape, columns);
FJELL_FIELD(FjellSetShape, rows);

FJELL_SIZE(FjellSetIndex);
FJELL_FIELD(FjellSetIndex, tail_offset);
FJELL_FIELD(FjellSetIndex, file_bytes);

FJELL_SIZE(FjellTerrainBudget);
FJELL_FIELD(FjellTerrainBudget, page_slots);

FJELL_SIZE(FjellVec3);
FJELL_FIELD(FjellVec3, x);
FJELL_FIELD(FjellVec3, y);
FJELL_FIELD(FjellVec3, z);

FJELL_SIZE(FjellView);
FJELL_FIELD(FjellView, eye_m);
FJELL_FIELD(FjellView, forward);
FJELL_FIELD(FjellView, up);
FJELL_FIELD(FjellView, left);
FJELL_FIELD(FjellView, right);
FJELL_FIELD(FjellView, bottom);
FJELL_FIELD(FjellView, top);
FJELL_FIELD(FjellView, width_px);
FJELL_FIELD(FjellView, height_px);
FJELL_FIELD(FjellView, near_m);
FJELL_FIELD(FjellView, far_m);
FJELL_FIELD(FjellView, error_px);

FJELL_SIZE(FjellFrustum);
FJELL_FIELD(FjellFrustum, normal);
FJELL_FIELD(FjellFrustum, offset);

FJELL_SIZE(FjellMeshVertex);
FJELL_FIELD(FjellMeshVertex, column);
FJELL_FIELD(FjellMeshVertex, row);
FJELL_FIELD(FjellMeshVertex, height_m);

FJELL_SIZE(FjellTileRange);
FJELL_FIELD(FjellTileRange, tile);
FJELL_FIELD(FjellTileRange, first_index);
FJELL_FIELD(FjellTileRange, index_count);
FJELL_FIELD(FjellTileRange, triangles);

FJELL_SIZE(FjellCutBudget);
FJELL_FIELD(FjellCutBudget, vertices);
FJELL_FIELD(FjellCutBudget, triangles);
FJELL_FIELD(FjellCutBudget, segment_triangles);
FJELL_FIELD(FjellCutBudget, views);
FJELL_FIELD(FjellCutBudget, workers);

FJELL_SIZE(FjellJobSystem);
FJELL_FIELD(FjellJobSystem, run);
FJELL_FIELD(FjellJobSystem, user);

FJELL_SIZE(FjellCutSettings);
FJELL_FIELD(FjellCutSettings, error_px);
FJELL_FIELD(FjellCutSettings, hysteresis);
FJELL_FIELD(FjellCutSettings, corner_safe);
FJELL_FIELD(FjellCutSettings, items);
FJELL_FIELD(FjellCutSettings, visits);
FJELL_FIELD(FjellCutSettings, budget_us);
FJELL_FIELD(FjellCutSettings, morph);
FJELL_FIELD(FjellCutSettings, morph_s);
FJELL_FIELD(FjellCutSettings, now_s);
FJELL_FIELD(FjellCutSettings, offscreen_factor);
FJELL_FIELD(FjellCutSettings, jobs);

FJELL_SIZE(FjellBudgetUse);
FJELL_FIELD(FjellBudgetUse, used);
FJELL_FIELD(FjellBudgetUse, peak);
FJELL_FIELD(FjellBudgetUse, capacity);

FJELL_SIZE(FjellCutReport);
FJELL_FIELD(FjellCutReport, frame);
FJELL_FIELD(FjellCutReport, items);
FJELL_FIELD(FjellCutReport, visits);
FJELL_FIELD(FjellCutReport, evaluations);
FJELL_FIELD(FjellCutReport, activations);
FJELL_FIELD(FjellCutReport, deactivations);
FJELL_FIELD(FjellCutReport, vertices);
FJELL_FIELD(FjellCutReport, triangles);
FJELL_FIELD(FjellCutReport, tiles_drawn);
FJELL_FIELD(FjellCutReport, triangles_drawn);
FJELL_FIELD(FjellCutReport, waiting);
FJELL_FIELD(FjellCutReport, blocked);
FJELL_FIELD(FjellCutReport, morphing);
FJELL_FIELD(FjellCutReport, exhausted);
FJELL_FIELD(FjellCutReport, error_px_requested);
FJELL_FIELD(FjellCutReport, error_px_effective);
FJELL_FIELD(FjellCutReport, threshold_px);
FJELL_FIELD(FjellCutReport, converged);
FJELL_FIELD(FjellCutReport, rebuilt);
FJELL_FIELD(FjellCutReport, vertex_slots);
FJELL_FIELD(FjellCutReport, triangle_slots);
FJELL_FIELD(FjellCutReport, vertices_changed);
FJELL_FIELD(FjellCutReport, triangles_changed);
FJELL_FIELD(FjellCutReport, prepare_us);
FJELL_FIELD(FjellCutReport, refine_us);
FJELL_FIELD(FjellCutReport, output_us);

FJELL_SIZE(FjellMorphVertex);
FJELL_FIELD(FjellMorphVertex, flat_m);
FJELL_FIELD(FjellMorphVertex, error_m);
FJELL_FIELD(FjellMorphVertex, radius_m);
FJELL_FIELD(FjellMorphVertex, activated_s);

FJELL_SIZE(FjellMorphView);
FJELL_FIELD(FjellMorphView, eye_x);
FJELL_FIELD(FjellMorphView, eye_y);
FJELL_FIELD(FjellMorphView, eye_z);
FJELL_FIELD(FjellMorphView, q_start);
FJELL_FIELD(FjellMorphView, q_full);

FJELL_SIZE(FjellCompactVertex);
FJELL_FIELD(FjellCompactVertex, column);
FJELL_FIELD(FjellCompactVertex, row);
FJELL_FIELD(FjellCompactVertex, height_m);
FJELL_FIELD(FjellCompactVertex, rise);
FJELL_FIELD(FjellCompactVertex, activated);
FJELL_FIELD(FjellCompactVertex, error);
FJELL_FIELD(FjellCompactVertex, radius);

FJELL_SIZE(FjellMorphFrame);
FJELL_FIELD(FjellMorphFrame, morph);
FJELL_FIELD(FjellMorphFrame, views);
FJELL_FIELD(FjellMorphFrame, view);
FJELL_FIELD(FjellMorphFrame, now_s);
FJELL_FIELD(FjellMorphFrame, morph_s);

FJELL_SIZE(FjellRecursiveBudget);
FJELL_FIELD(FjellRecursiveBudget, vertices);
FJELL_FIELD(FjellRecursiveBudget, indices);

FJELL_SIZE(FjellRefineSettings);
FJELL_FIELD(FjellRefineSettings, error_px);
FJELL_FIELD(FjellRefineSettings, metric);
FJELL_FIELD(FjellRefineSettings, cull);
FJELL_FIELD(FjellRefineSettings, corner_safe);
FJELL_FIELD(FjellRefineSettings, topology);

FJELL_SIZE(FjellFrameReport);
FJELL_FIELD(FjellFrameReport, frame);
FJELL_FIELD(FjellFrameReport, vertices);
FJELL_FIELD(FjellFrameReport, triangles);
FJELL_FIELD(FjellFrameReport, tiles);
FJELL_FIELD(FjellFrameReport, vertices_written);
FJELL_FIELD(FjellFrameReport, buffer_clearings);
FJELL_FIELD(FjellFrameReport, restarts);
FJELL_FIELD(FjellFrameReport, exhausted);
FJELL_FIELD(FjellFrameReport, error_px_requested);
FJELL_FIELD(FjellFrameReport, error_px_effective);
FJELL_FIELD(FjellFrameReport, converged);

FJELL_SIZE(FjellMeasuredError);
FJELL_FIELD(FjellMeasuredError, max_px);
FJELL_FIELD(FjellMeasuredError, max_m);
FJELL_FIELD(FjellMeasuredError, sample_px);
FJELL_FIELD(FjellMeasuredError, sample_m);
FJELL_FIELD(FjellMeasuredError, samples);

FJELL_SIZE(FjellGroundHeight);
FJELL_FIELD(FjellGroundHeight, inside);
FJELL_FIELD(FjellGroundHeight, hole);
FJELL_FIELD(FjellGroundHeight, finest);
FJELL_FIELD(FjellGroundHeight, height_m);
FJELL_FIELD(FjellGroundHeight, normal);
FJELL_FIELD(FjellGroundHeight, error_m);

FJELL_SIZE(FjellGroundHit);
FJELL_FIELD(FjellGroundHit, hit);
FJELL_FIELD(FjellGroundHit, finest);
FJELL_FIELD(FjellGroundHit, distance_m);
FJELL_FIELD(FjellGroundHit, position_m);
FJELL_FIELD(FjellGroundHit, normal);
FJELL_FIELD(FjellGroundHit, error_m);

FJELL_SIZE(FjellGroundPatch);
FJELL_FIELD(FjellGroundPatch, error_m);
FJELL_FIELD(FjellGroundPatch, finest);

FJELL_SIZE(FjellMapLayers);
FJELL_FIELD(FjellMapLayers, tail_log2);
FJELL_FIELD(FjellMapLayers, top_log2);
FJELL_FIELD(FjellMapLayers, layers);

FJELL_SIZE(FjellStreamBudget);
FJELL_FIELD(FjellStreamBudget, page_requests);
FJELL_FIELD(FjellStreamBudget, map_requests);
FJELL_FIELD(FjellStreamBudget, map_bytes);
FJELL_FIELD(FjellStreamBudget, tail_log2);
FJELL_FIELD(FjellStreamBudget, decoders);
FJELL_FIELD(FjellStreamBudget, horizons);
FJELL_FIELD(FjellStreamBudget, control);

FJELL_SIZE(FjellStreamSettings);
FJELL_FIELD(FjellStreamSettings, texel_px);
FJELL_FIELD(FjellStreamSettings, lookahead_s);
FJELL_FIELD(FjellStreamSettings, fade_s);
FJELL_FIELD(FjellStreamSettings, now_s);
FJELL_FIELD(FjellStreamSettings, pages);
FJELL_FIELD(FjellStreamSettings, tests);
FJELL_FIELD(FjellStreamSettings, map_bytes);

FJELL_SIZE(FjellStreamFailure);
FJELL_FIELD(FjellStreamFailure, id);
FJELL_FIELD(FjellStreamFailure, code);

FJELL_SIZE(FjellPageArrival);
FJELL_FIELD(FjellPageArrival, tile);
FJELL_FIELD(FjellPageArrival, page);
FJELL_FIELD(FjellPageArrival, event);

FJELL_SIZE(FjellStreamReport);
FJELL_FIELD(FjellStreamReport, frame);
FJELL_FIELD(FjellStreamReport, converged);
FJELL_FIELD(FjellStreamReport, maps_converged);
FJELL_FIELD(FjellStreamReport, complete);
FJELL_FIELD(FjellStreamReport, missing_px);
FJELL_FIELD(FjellStreamReport, missing_mips);
FJELL_FIELD(FjellStreamReport, exhausted);
FJELL_FIELD(FjellStreamReport, pages_wanted);
FJELL_FIELD(FjellStreamReport, pages_inserted);
FJELL_FIELD(FjellStreamReport, pages_left);
FJELL_FIELD(FjellStreamReport, pages_evicting);
FJELL_FIELD(FjellStreamReport, mips_uploaded);
FJELL_FIELD(FjellStreamReport, mips_left);
FJELL_FIELD(FjellStreamReport, in_flight);
FJELL_FIELD(FjellStreamReport, cancelled);
FJELL_FIELD(FjellStreamReport, failed);
FJELL_FIELD(FjellStreamReport, bytes_read);
FJELL_FIELD(FjellStreamReport, pages_read);
FJELL_FIELD(FjellStreamReport, mips_read);
FJELL_FIELD(FjellStreamReport, map_upload_bytes);
FJELL_FIELD(FjellStreamReport, page_slots);
FJELL_FIELD(FjellStreamReport, map_bytes_used);
FJELL_FIELD(FjellStreamReport, map_bytes_capacity);
FJELL_FIELD(FjellStreamReport, update_us);

FJELL_SIZE(FjellMapCommand);
FJELL_FIELD(FjellMapCommand, map);
FJELL_FIELD(FjellMapCommand, side_log2);
FJELL_FIELD(FjellMapCommand, from_log2);
FJELL_FIELD(FjellMapCommand, upload_mips);
FJELL_FIELD(FjellMapCommand, tile);
FJELL_FIELD(FjellMapCommand, layer);
FJELL_FIELD(FjellMapCommand, from_layer);

FJELL_SIZE(FjellTileMap);
FJELL_FIELD(FjellTileMap, layer);
FJELL_FIELD(FjellTileMap, side_log2);
FJELL_FIELD(FjellTileMap, min_lod);

FJELL_SIZE(FjellStreamRequest);
FJELL_FIELD(FjellStreamRequest, ticket);
FJELL_FIELD(FjellStreamRequest, id);
FJELL_FIELD(FjellStreamRequest, chunks);
FJELL_FIELD(FjellStreamRequest, offset);
FJELL_FIELD(FjellStreamRequest, bytes);

// A span is a pointer and a count, as the implementations of the standard library have it; a test looks that the
// pointer comes first.
static_assert(sizeof(std::span<const std::byte>) == 2 * sizeof(void*));
static_assert(offsetof(Pack, bytes) == offsetof(FjellPack, bytes) &&
              offsetof(FjellPack, byte_count) == offsetof(FjellPack, bytes) + sizeof(void*));
static_assert(offsetof(SetPart, pack) == offsetof(FjellSetPart, pack) &&
              offsetof(SetPart, corners) == offsetof(FjellSetPart, corners) &&
              offsetof(FjellSetPart, corner_bytes) == offsetof(FjellSetPart, corners) + sizeof(void*));
static_assert(offsetof(SetIndex, header) == offsetof(FjellSetIndex, header) &&
              offsetof(SetIndex, tail) == offsetof(FjellSetIndex, tail) &&
              offsetof(SetIndex, corners) == offsetof(FjellSetIndex, corners) &&
              offsetof(SetIndex, directory) == offsetof(FjellSetIndex, directory) &&
              offsetof(FjellSetIndex, directory_bytes) == offsetof(FjellSetIndex, directory) + sizeof(void*));
static_assert(offsetof(MapCommand, blocks) == offsetof(FjellMapCommand, blocks) &&
              offsetof(FjellMapCommand, block_bytes) == offsetof(FjellMapCommand, blocks) + sizeof(void*));

template <typename C>
constexpr bool is_handle = sizeof(C) == sizeof(typename CppOf<C>::Type) &&
                           alignof(C) == alignof(typename CppOf<C>::Type);
static_assert(is_handle<FjellTerrain> && is_handle<FjellLiveCut> && is_handle<FjellRecursiveMethod> &&
              is_handle<FjellStream>);

static_assert(FJELL_OK == static_cast<int>(Code::ok));
static_assert(FJELL_TRUNCATED == static_cast<int>(Code::truncated));
static_assert(FJELL_NOT_A_PACK == static_cast<int>(Code::not_a_pack));
static_assert(FJELL_WRONG_VERSION == static_cast<int>(Code::wrong_version));
static_assert(FJELL_WRONG_LAYOUT == static_cast<int>(Code::wrong_layout));
static_assert(FJELL_CORRUPT == static_cast<int>(Code::corrupt));
static_assert(FJELL_OUT_OF_RANGE == static_cast<int>(Code::out_of_range));
static_assert(FJELL_MEMORY_TOO_SMALL == static_cast<int>(Code::memory_too_small));
static_assert(FJELL_BUDGET_TOO_SMALL == static_cast<int>(Code::budget_too_small));
static_assert(FJELL_OUT_OF_SLOTS == static_cast<int>(Code::out_of_slots));
static_assert(FJELL_COARSER_PAGE_FIRST == static_cast<int>(Code::coarser_page_first));
static_assert(FJELL_NOT_SUPPORTED == static_cast<int>(Code::not_supported));
static_assert(FJELL_UNREADABLE == static_cast<int>(Code::unreadable));
static_assert(FJELL_INVALID_HANDLE == static_cast<int>(Code::invalid_handle));
static_assert(FJELL_WRONG_PACK == static_cast<int>(Code::wrong_pack));
static_assert(FJELL_WRONG_TERRAIN == static_cast<int>(Code::wrong_terrain));
static_assert(FJELL_ORDER_PLANAR == static_cast<int>(Order::planar));
static_assert(FJELL_ORDER_HIERARCHICAL_Z == static_cast<int>(Order::hierarchical_z));
static_assert(FJELL_ORDER_LINEAR == static_cast<int>(Order::linear));
static_assert(FJELL_ESTIMATE_MAX == static_cast<int>(Estimate::max));
static_assert(FJELL_ESTIMATE_MIDPOINT == static_cast<int>(Estimate::midpoint));
static_assert(FJELL_CHUNK_CORNERS == static_cast<int>(ChunkKind::corners));
static_assert(FJELL_CHUNK_GEOMETRY == static_cast<int>(ChunkKind::geometry));
static_assert(FJELL_CHUNK_COLOUR == static_cast<int>(ChunkKind::colour));
static_assert(FJELL_CHUNK_NORMAL == static_cast<int>(ChunkKind::normal));
static_assert(FJELL_CHUNK_CRS == static_cast<int>(ChunkKind::crs));
static_assert(FJELL_CHUNK_HORIZON == static_cast<int>(ChunkKind::horizon));
static_assert(FJELL_CHUNK_LAYERS == static_cast<int>(ChunkKind::layers));
static_assert(FJELL_CHUNK_CONTROL == static_cast<int>(ChunkKind::control));
static_assert(FJELL_TOPOLOGY_TRIANGLES == static_cast<int>(Topology::triangles));
static_assert(FJELL_TOPOLOGY_STRIP == static_cast<int>(Topology::strip));
static_assert(FJELL_MORPH_NONE == static_cast<int>(Morph::none));
static_assert(FJELL_MORPH_ERROR == static_cast<int>(Morph::error));
static_assert(FJELL_MORPH_TIME == static_cast<int>(Morph::time));
static_assert(FJELL_METRIC_ISOTROPIC == static_cast<int>(Metric::isotropic));
static_assert(FJELL_METRIC_DEPTH == static_cast<int>(Metric::depth));
static_assert(FJELL_MAP_COLOUR == static_cast<int>(MapKind::colour));
static_assert(FJELL_MAP_NORMAL == static_cast<int>(MapKind::normal));
static_assert(FJELL_MAP_HORIZON == static_cast<int>(MapKind::horizon));
static_assert(FJELL_MAP_CONTROL == static_cast<int>(MapKind::control));
static_assert(FJELL_PAGE_INSERTED == static_cast<int>(PageEvent::inserted));
static_assert(FJELL_PAGE_RELEASED == static_cast<int>(PageEvent::released));
static_assert(FJELL_PAGE_KEPT == static_cast<int>(PageEvent::kept));
static_assert(FJELL_PAGE_REMOVED == static_cast<int>(PageEvent::removed));
static_assert(FJELL_CUT_BUDGET_VERTICES == static_cast<int>(cut_budget_vertices));
static_assert(FJELL_CUT_BUDGET_TRIANGLES == static_cast<int>(cut_budget_triangles));
static_assert(FJELL_CUT_BUDGET_ITEMS == static_cast<int>(cut_budget_items));
static_assert(FJELL_CUT_BUDGET_TIME == static_cast<int>(cut_budget_time));
static_assert(FJELL_BUDGET_VERTICES == static_cast<int>(budget_vertices));
static_assert(FJELL_BUDGET_INDICES == static_cast<int>(budget_indices));
static_assert(FJELL_STREAM_PAGE_SLOTS == static_cast<int>(stream_page_slots));
static_assert(FJELL_STREAM_MAP_BYTES == static_cast<int>(stream_map_bytes));
static_assert(FJELL_STREAM_PAGES == static_cast<int>(stream_pages));
static_assert(FJELL_STREAM_UPLOAD == static_cast<int>(stream_upload));
static_assert(FJELL_STREAM_TESTS == static_cast<int>(stream_tests));
static_assert(FJELL_STREAM_REQUESTS == static_cast<int>(stream_requests));
static_assert(FJELL_MAX_TILE_LOG2 == max_tile_log2);
static_assert(FJELL_MAX_TEXTURE_LOG2 == max_texture_log2);
static_assert(FJELL_NO_CHUNK == no_chunk);
static_assert(FJELL_MAX_CUT_VIEWS == max_cut_views);
static_assert(FJELL_UNLIMITED_ITEMS == unlimited_items);
static_assert(FJELL_LONG_ACTIVE_S == long_active_s);
static_assert(FJELL_MORPH_CLOCK_S == morph_clock_s);
static_assert(FJELL_COMPACT_LONG_ACTIVE == compact_long_active);
static_assert(FJELL_COMPACT_STEPS_S == compact_steps_s);
static_assert(FJELL_COMPACT_LATE_S == compact_late_s);
static_assert(FJELL_UNBOUNDED_PX == unbounded_px);
static_assert(FJELL_MAP_KINDS == map_kinds);
static_assert(FJELL_COLOUR_BLOCK_BYTES == colour_block_bytes);
static_assert(FJELL_NORMAL_BLOCK_BYTES == normal_block_bytes);
static_assert(FJELL_HORIZON_BLOCK_BYTES == horizon_block_bytes);
static_assert(FJELL_CONTROL_BLOCK_BYTES == control_block_bytes);

} // namespace fjell::c_api
