// The types of fjell/fjell_c.h. Fields are those of the C++ types of the same name, whose headers give units and
// ranges. runtime/src/c/types.py writes this file from those headers: change them, then run it. The library checks at
// compile time that both layouts are equal.
#ifndef FJELL_FJELL_C_TYPES_H
#define FJELL_FJELL_C_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fjell/export.h"

// --- fjell/status.h ---

typedef uint8_t FjellStatusCode;
enum {
    FJELL_OK,
    FJELL_TRUNCATED,
    FJELL_NOT_A_PACK,
    FJELL_WRONG_VERSION,
    FJELL_WRONG_LAYOUT,
    FJELL_CORRUPT,
    FJELL_OUT_OF_RANGE,
    FJELL_MEMORY_TOO_SMALL,
    FJELL_BUDGET_TOO_SMALL,
    FJELL_OUT_OF_SLOTS,
    FJELL_COARSER_PAGE_FIRST,
    FJELL_NOT_SUPPORTED,
    FJELL_UNREADABLE,
    FJELL_INVALID_HANDLE,
    FJELL_WRONG_PACK,
    FJELL_WRONG_TERRAIN
};

typedef struct FjellStatus {
    FjellStatusCode code;
    const char* field;
} FjellStatus;

// --- fjell/asserts.h ---

typedef void (*FjellAssertHandler)(const char* condition, const char* file, int line);

// --- fjell/sample_index.h ---

typedef struct FjellSampleIndex {
    int32_t column, row;
} FjellSampleIndex;

// --- fjell/pack.h ---

#define FJELL_PACK_VERSION 8

typedef uint64_t FjellPackFeatures;
enum { FJELL_PACK_HAS_HORIZONS = 1, FJELL_PACK_HAS_SPLAT = 2, FJELL_PACK_IS_SPARSE = 4 };
#define FJELL_MAX_LAYER_BYTES 512
#define FJELL_PACK_LAYOUT_HASH 0x46a1000400041020ull
#define FJELL_MIN_TILE_LOG2 1
#define FJELL_MAX_TILE_LOG2 12
#define FJELL_MAX_TEXTURE_LOG2 12
#define FJELL_MAX_COLUMNS (1u << 20)
#define FJELL_MIN_SPACING_M 1e-3
#define FJELL_MAX_SPACING_M 1e6
#define FJELL_MAX_SPARSE_TILES (1u << 26)
#define FJELL_MAX_EXTENT_M 1e8

typedef uint32_t FjellPageOrder;
enum { FJELL_PAGE_ORDER_PLANAR = 0, FJELL_PAGE_ORDER_HIERARCHICAL_Z = 1, FJELL_PAGE_ORDER_LINEAR = 2 };

typedef uint32_t FjellErrorEstimate;
enum { FJELL_ERROR_ESTIMATE_MAX = 0, FJELL_ERROR_ESTIMATE_MIDPOINT = 1 };

typedef uint32_t FjellChunkKind;
enum {
    FJELL_CHUNK_CORNERS = 0,
    FJELL_CHUNK_GEOMETRY = 1,
    FJELL_CHUNK_COLOUR = 2,
    FJELL_CHUNK_NORMAL = 3,
    FJELL_CHUNK_CRS = 4,
    FJELL_CHUNK_HORIZON = 5,
    FJELL_CHUNK_LAYERS = 6,
    FJELL_CHUNK_SPLAT = 7
};

typedef struct FjellPackHeader {
    char magic[8];
    uint32_t version;
    uint32_t header_bytes;
    uint64_t layout_hash;
    uint64_t file_bytes;
    uint64_t directory_offset;
    uint64_t directory_count;
    uint64_t directory_hash;
    uint32_t columns, rows;
    uint32_t tiles_x, tiles_y;
    uint32_t tile_log2;
    FjellPageOrder order;
    FjellErrorEstimate estimate;
    float nesting;
    double spacing_m[2];
    double crs_origin[2];
    float base_m, quantum_m;
    float min_m, max_m;
    float max_error_m;
    uint32_t colour_log2;
    uint32_t normal_log2;
    uint32_t crs_bytes;
    float error_floor_m;
    float error_ratio;
    uint32_t error_nesting_steps;
    uint32_t height_steps;
    uint64_t voids;
    float level_radius_m[2 * FJELL_MAX_TILE_LOG2];
    double crs_step[2];
    uint64_t notes_offset, notes_hash;
    uint64_t notes_bytes;
    uint32_t horizon_log2;
    uint32_t tiles_held;
    uint32_t splat_log2;
    uint32_t layer_bytes;
    uint64_t features;
    uint64_t reserved[21];
    uint64_t header_hash;
} FjellPackHeader;

typedef struct FjellPageBound {
    uint16_t low, high;
    uint8_t error;
    uint8_t radius;
    uint16_t reserved;
} FjellPageBound;

typedef struct FjellChunkEntry {
    uint64_t offset;
    uint64_t hash;
    uint32_t stored_bytes;
    uint32_t raw_bytes;
    FjellPageBound bound;
} FjellChunkEntry;

#define FJELL_RADIUS_SQUARES_LOG2 2
#define FJELL_PAGE_RADII (64 + 72 + 72)
#define FJELL_CORNER_VOID_BIT 0x80000000

typedef struct FjellPack {
    FjellPackHeader header;
    const void* bytes;
    size_t byte_count;
    const void* directory;
} FjellPack;

typedef struct FjellChunkId {
    FjellChunkKind kind;
    uint32_t tile, item;
} FjellChunkId;

#define FJELL_NO_CHUNK 0xffffffffffffffffull

// --- fjell/pack_set.h ---

typedef struct FjellSetPart {
    const FjellPack* pack;
    const void* corners;
    size_t corner_bytes;
    uint32_t tile_x, tile_y;
} FjellSetPart;

typedef struct FjellSetShape {
    uint32_t columns, rows;
} FjellSetShape;

typedef struct FjellSetIndex {
    const void* header;
    size_t header_bytes;
    const void* tail;
    size_t tail_bytes;
    const void* corners;
    size_t corner_bytes;
    const void* directory;
    size_t directory_bytes;
    uint64_t tail_offset;
    uint64_t file_bytes;
} FjellSetIndex;

// --- fjell/texture.h ---

#define FJELL_COLOUR_BLOCK_BYTES 8
#define FJELL_NORMAL_BLOCK_BYTES 16
#define FJELL_HORIZON_DIRECTIONS 15
#define FJELL_HORIZON_PLANES_ACROSS 4
#define FJELL_HORIZON_PLANES (FJELL_HORIZON_PLANES_ACROSS * FJELL_HORIZON_PLANES_ACROSS)
#define FJELL_HORIZON_BLOCK_BYTES (8 * FJELL_HORIZON_PLANES)
#define FJELL_SPLAT_LAYERS 4
#define FJELL_MAX_SPLAT_NAMES 16
#define FJELL_SPLAT_TEXEL_BYTES (2 * FJELL_SPLAT_LAYERS)
#define FJELL_SPLAT_BLOCK_BYTES (16 * FJELL_SPLAT_TEXEL_BYTES)

// --- fjell/terrain.h ---

#define FJELL_NO_TILE 0xffffffff

typedef struct FjellTerrain {
    void* object;
    uint64_t identity;
} FjellTerrain;

typedef struct FjellTerrainBudget {
    uint64_t struct_size;
    uint32_t page_slots;
} FjellTerrainBudget;

// --- fjell/pages.h ---

typedef struct FjellTerrainVertex {
    bool loaded;
    bool hole;
    bool in_tile;
    float height_m, error_m, radius_m;
} FjellTerrainVertex;

// --- fjell/view.h ---

typedef struct FjellVec3 {
    double x, y, z;
} FjellVec3;

typedef struct FjellView {
    uint64_t struct_size;
    FjellVec3 eye_m;
    FjellVec3 forward;
    FjellVec3 up;
    double left, right;
    double bottom, top;
    uint32_t width_px, height_px;
    double near_m, far_m;
    double max_error_px;
} FjellView;

typedef struct FjellFrustum {
    FjellVec3 normal[6];
    double offset[6];
} FjellFrustum;

// --- fjell/mesh.h ---

typedef struct FjellMeshVertex {
    int32_t column, row;
    float height_m;
} FjellMeshVertex;

typedef uint8_t FjellTopology;
enum { FJELL_TOPOLOGY_TRIANGLES, FJELL_TOPOLOGY_STRIP };

typedef struct FjellTileRange {
    uint32_t tile;
    uint32_t first_index;
    uint32_t index_count;
    uint32_t triangles;
} FjellTileRange;

typedef struct FjellMeshView {
    const FjellMeshVertex* vertices;
    size_t vertex_count;
    const uint32_t* indices;
    size_t index_count;
    const FjellTileRange* tiles;
    size_t tile_count;
    uint32_t dirty_begin, dirty_end;
    FjellTopology topology;
} FjellMeshView;

// --- fjell/jobs.h ---

#define FJELL_MAX_CUT_WORKERS 64

typedef struct FjellJobSystem {
    void (*run)(void* user, uint32_t count, void (*job)(void* data, uint32_t index), void* data);
    void* user;
} FjellJobSystem;

// --- fjell/cut.h ---

#define FJELL_MAX_CUT_VIEWS 8

typedef struct FjellCutBudget {
    uint64_t struct_size;
    uint32_t vertices;
    uint32_t triangles;
    uint32_t segment_triangles;
    uint32_t views;
    uint32_t workers;
    bool morph;
} FjellCutBudget;

#define FJELL_CUT_VERTEX_BYTES 57
#define FJELL_CUT_MORPH_BYTES 24
#define FJELL_CUT_TRIANGLE_BYTES 12
#define FJELL_CUT_PAGE_SLOT_BYTES 28
#define FJELL_CUT_PAGE_BYTES 19716

typedef uint8_t FjellMorph;
enum { FJELL_MORPH_NONE, FJELL_MORPH_ERROR, FJELL_MORPH_TIME };
#define FJELL_UNLIMITED_WORK 0xffffffff
#define FJELL_MAX_OFFSCREEN_FACTOR 100.0

typedef struct FjellCutSettings {
    uint64_t struct_size;
    double max_error_px;
    double hysteresis;
    bool corner_safe;
    uint32_t max_work;
    uint32_t visits;
    double max_time_us;
    FjellMorph morph;
    double morph_s;
    double now_s;
    double offscreen_factor;
    FjellJobSystem jobs;
} FjellCutSettings;

typedef uint32_t FjellCutBudgetBit;
enum {
    FJELL_CUT_BUDGET_VERTICES = 1u << 0,
    FJELL_CUT_BUDGET_TRIANGLES = 1u << 1,
    FJELL_CUT_BUDGET_WORK = 1u << 2,
    FJELL_CUT_BUDGET_TIME = 1u << 3
};

typedef struct FjellBudgetUse {
    uint32_t used, peak, capacity;
} FjellBudgetUse;

typedef struct FjellCutReport {
    uint64_t struct_size;
    uint64_t frame;
    uint32_t work;
    uint32_t visits;
    uint32_t evaluations, activations, deactivations;
    uint32_t vertices;
    uint32_t triangles;
    uint32_t tiles_drawn, triangles_drawn;
    uint32_t waiting;
    uint32_t blocked;
    uint32_t morphing;
    uint32_t exhausted;
    double error_px_requested, error_bound_px, threshold_px;
    bool converged;
    bool rebuilt;
    FjellBudgetUse vertex_slots, triangle_slots;
    uint32_t vertices_changed, triangles_changed;
    double prepare_us, refine_us, output_us;
} FjellCutReport;

typedef struct FjellLiveCut {
    void* object;
    uint64_t identity;
} FjellLiveCut;

#define FJELL_ACTIVATED_LONG_AGO_S (-1e30f)
#define FJELL_MORPH_CLOCK_S 1024.0f

typedef struct FjellMorphVertex {
    float morph_from_m;
    float error_m;
    float radius_m;
    float activated_s;
} FjellMorphVertex;

typedef struct FjellMorphView {
    float eye_x, eye_y, eye_z;
    float start_per_error, full_per_error;
} FjellMorphView;

typedef struct FjellMorphFrame {
    FjellMorph morph;
    uint32_t views;
    FjellMorphView view[FJELL_MAX_CUT_VIEWS];
    float now_s, morph_s;
} FjellMorphFrame;

typedef struct FjellCutMesh {
    FjellMeshView mesh;
    const FjellMorphVertex* morph;
    size_t morph_count;
    FjellMorphFrame frame;
} FjellCutMesh;

typedef struct FjellCutChanges {
    const uint64_t* vertex_bits;
    size_t vertex_bit_words;
    const uint64_t* triangle_bits;
    size_t triangle_bit_words;
    const uint32_t* vertex_words;
    size_t vertex_word_count;
    const uint32_t* triangle_words;
    size_t triangle_word_count;
} FjellCutChanges;

// Slots that were written, one after the other. Begin with {0}.
typedef struct FjellRun {
    uint32_t first, count;
    size_t words_begun; // the library's, and so is what follows
    uint64_t bits_left;
} FjellRun;

// --- fjell/compact.h ---

typedef struct FjellCompactVertex {
    uint16_t column, row;
    float height_m;
    uint16_t rise;
    uint16_t activated;
    uint16_t error, radius;
} FjellCompactVertex;

#define FJELL_COMPACT_ACTIVATED_LONG_AGO 0xffff
#define FJELL_COMPACT_STEPS_S 64.0f
#define FJELL_COMPACT_LATE_S 0x1p-5f

// --- fjell/recursive.h ---

typedef struct FjellRecursiveBudget {
    uint64_t struct_size;
    uint32_t vertices;
    uint32_t indices;
} FjellRecursiveBudget;

#define FJELL_RECURSIVE_VERTEX_BYTES 20

typedef uint8_t FjellMetric;
enum { FJELL_METRIC_ISOTROPIC, FJELL_METRIC_DEPTH };

typedef struct FjellRefineSettings {
    uint64_t struct_size;
    double max_error_px;
    FjellMetric metric;
    bool cull;
    bool corner_safe;
    FjellTopology topology;
} FjellRefineSettings;

typedef uint32_t FjellBudgetBit;
enum { FJELL_BUDGET_VERTICES = 1u << 0, FJELL_BUDGET_INDICES = 1u << 1 };

typedef struct FjellFrameReport {
    uint64_t struct_size;
    uint64_t frame;
    uint32_t vertices;
    uint32_t triangles;
    uint32_t tiles;
    uint32_t vertices_written;
    uint32_t buffer_clearings;
    uint32_t restarts;
    uint32_t exhausted;
    double error_px_requested, error_bound_px;
    bool converged;
} FjellFrameReport;

typedef struct FjellRecursiveMethod {
    void* object;
    uint64_t identity;
} FjellRecursiveMethod;

// --- fjell/measure.h ---

typedef struct FjellMeasuredError {
    double max_px;
    double max_m;
    FjellSampleIndex sample_px, sample_m;
    uint64_t samples;
} FjellMeasuredError;

#define FJELL_UNBOUNDED_PX 1e7

// --- fjell/query.h ---

typedef struct FjellGroundHeight {
    bool inside;
    bool hole;
    bool finest;
    double height_m;
    FjellVec3 normal;
    float error_m;
} FjellGroundHeight;

typedef struct FjellGroundHit {
    bool hit;
    bool finest;
    double distance_m;
    FjellVec3 position_m;
    FjellVec3 normal;
    float error_m;
} FjellGroundHit;

#define FJELL_MAX_PATCH_SIDE 4097

typedef struct FjellGroundPatch {
    float error_m;
    bool finest;
} FjellGroundPatch;

// --- fjell/stream.h ---

typedef uint8_t FjellMapKind;
enum { FJELL_MAP_COLOUR = 0, FJELL_MAP_NORMAL = 1, FJELL_MAP_HORIZON = 2, FJELL_MAP_SPLAT = 3 };
#define FJELL_MAP_KINDS 4

typedef struct FjellMapLayers {
    uint32_t tail_log2;
    uint32_t top_log2;
    uint32_t layers[FJELL_MAX_TEXTURE_LOG2 + 1];
} FjellMapLayers;

typedef struct FjellStreamBudget {
    uint64_t struct_size;
    uint32_t page_requests;
    uint32_t map_requests;
    uint64_t map_bytes;
    uint32_t tail_log2;
    uint32_t decoders;
    bool horizons;
    bool splat;
} FjellStreamBudget;

typedef struct FjellStreamSettings {
    uint64_t struct_size;
    double texel_px;
    double lookahead_s;
    double fade_s;
    double now_s;
    uint32_t pages;
    uint32_t tests;
    uint32_t map_bytes;
} FjellStreamSettings;

typedef uint32_t FjellStreamBudgetBit;
enum {
    FJELL_STREAM_PAGE_SLOTS = 1u << 0,
    FJELL_STREAM_MAP_BYTES = 1u << 1,
    FJELL_STREAM_PAGES = 1u << 2,
    FJELL_STREAM_UPLOAD = 1u << 3,
    FJELL_STREAM_TESTS = 1u << 4,
    FJELL_STREAM_REQUESTS = 1u << 5
};

typedef struct FjellStreamFailure {
    FjellChunkId id;
    FjellStatusCode code;
} FjellStreamFailure;

typedef uint8_t FjellPageEvent;
enum { FJELL_PAGE_INSERTED, FJELL_PAGE_RELEASED, FJELL_PAGE_KEPT, FJELL_PAGE_REMOVED };

typedef struct FjellPageArrival {
    uint32_t tile, page;
    FjellPageEvent event;
} FjellPageArrival;

typedef struct FjellStreamReport {
    uint64_t struct_size;
    uint64_t frame;
    bool converged;
    bool maps_converged;
    bool complete;
    double missing_px;
    double missing_mips;
    uint32_t exhausted;
    uint32_t pages_wanted;
    uint32_t pages_inserted, pages_left;
    uint32_t pages_evicting;
    uint32_t mips_uploaded, mips_left;
    uint32_t in_flight;
    uint32_t cancelled;
    uint32_t failed;
    uint64_t bytes_read;
    uint64_t pages_read, mips_read;
    uint64_t map_upload_bytes;
    FjellBudgetUse page_slots;
    uint64_t map_bytes_used, map_bytes_capacity;
    double update_us;
} FjellStreamReport;

typedef struct FjellStream {
    void* object;
    uint64_t identity;
} FjellStream;

typedef struct FjellMapCommand {
    FjellMapKind map;
    uint8_t side_log2;
    uint8_t from_log2;
    uint8_t upload_mips;
    uint32_t tile;
    uint32_t layer, from_layer;
    const void* blocks;
    size_t block_bytes;
} FjellMapCommand;

typedef struct FjellTileMap {
    uint32_t layer;
    uint8_t side_log2;
    float min_lod;
} FjellTileMap;

typedef struct FjellStreamRequest {
    uint32_t ticket;
    FjellChunkId id;
    uint32_t chunks;
    uint64_t offset;
    uint32_t bytes;
} FjellStreamRequest;

// --- fjell/edit.h ---

typedef struct FjellEdits {
    void* object;
    uint64_t identity;
} FjellEdits;

typedef uint32_t FjellStampShape;
enum {
    FJELL_STAMP_SHAPE_RAISE,
    FJELL_STAMP_SHAPE_LEVEL,
    FJELL_STAMP_SHAPE_CRATER,
    FJELL_STAMP_SHAPE_PATH,
    FJELL_STAMP_SHAPE_NOISE,
    FJELL_STAMP_SHAPE_SMOOTH,
    FJELL_STAMP_SHAPE_HEIGHTS,
    FJELL_STAMP_SHAPE_RESTORE,
    FJELL_STAMP_SHAPE_PAINT,
    FJELL_STAMP_SHAPE_UNPAINT,
    FJELL_STAMP_SHAPE_HOLE,
    FJELL_STAMP_SHAPE_FILL,
    FJELL_STAMP_SHAPE_LOCK,
    FJELL_STAMP_SHAPE_UNLOCK
};

typedef struct FjellStampPoint {
    double x_m, z_m;
    float height_m;
} FjellStampPoint;

#define FJELL_NO_MATERIAL 255

typedef struct FjellStamp {
    uint64_t struct_size;
    FjellStampShape shape;
    double x_m, z_m;
    float radius_m, falloff_m;
    float amount_m;
    float height_m, slope_x, slope_z;
    float wavelength_m;
    uint32_t seed;
    const FjellStampPoint* points;
    uint32_t point_count;
    FjellSampleIndex first;
    int32_t columns, rows;
    const float* heights_m;
    const uint8_t* mask;
    float morph_s;
    float strength;
    uint8_t rgb[3];
    uint8_t material;
} FjellStamp;

#define FJELL_MAX_PATH_POINTS 256

typedef struct FjellEditBudget {
    uint64_t struct_size;
    uint32_t blocks;
    uint32_t stamps;
    uint32_t areas;
    uint32_t moving;
    uint32_t paint;
    bool holes;
    uint32_t locks;
} FjellEditBudget;

typedef uint32_t FjellStampState;
enum {
    FJELL_STAMP_STATE_UNKNOWN,
    FJELL_STAMP_STATE_WAITING,
    FJELL_STAMP_STATE_APPLIED,
    FJELL_STAMP_STATE_REFUSED,
    FJELL_STAMP_STATE_MOVING
};

typedef struct FjellStampResult {
    FjellStampState state;
    FjellStatus status;
} FjellStampResult;

#define FJELL_UNLIMITED_EDIT_WORK 0xffffffff

typedef struct FjellEditSettings {
    uint64_t struct_size;
    uint32_t max_work;
    uint32_t max_time_us;
    double now_s;
} FjellEditSettings;

typedef uint32_t FjellEditBudgetBit;
enum {
    FJELL_EDIT_BUDGET_WORK = 1,
    FJELL_EDIT_BUDGET_TIME = 2,
    FJELL_EDIT_BUDGET_BLOCKS = 4,
    FJELL_EDIT_BUDGET_PAINT = 8,
    FJELL_EDIT_BUDGET_LOCKS = 16
};

typedef struct FjellEditReport {
    uint64_t struct_size;
    uint32_t applied, refused;
    uint32_t waiting;
    uint32_t held;
    uint32_t samples;
    uint32_t loose;
    uint32_t unmeasured;
    uint32_t work;
    uint32_t blocks;
    uint32_t exhausted;
    double apply_us, measure_us;
    uint32_t moving;
    uint32_t paint;
    uint32_t locks;
} FjellEditReport;

typedef struct FjellGroundRect {
    FjellSampleIndex first, last;
} FjellGroundRect;

// --- fjell/ground_maps.h ---

typedef struct FjellGroundMaps {
    void* object;
    uint64_t identity;
} FjellGroundMaps;

typedef struct FjellGroundMapsBudget {
    uint64_t struct_size;
    uint32_t changes;
    uint32_t texels;
} FjellGroundMapsBudget;

typedef struct FjellMapPatch {
    FjellMapKind map;
    uint8_t side_log2;
    uint8_t mip;
    uint32_t tile;
    uint32_t layer;
    uint32_t x, y, columns, rows;
    const void* blocks;
    size_t block_bytes;
} FjellMapPatch;

typedef struct FjellGroundMapsReport {
    uint64_t struct_size;
    uint32_t patches;
    uint32_t texels;
    uint32_t waiting;
    uint32_t coarse;
    double update_us;
} FjellGroundMapsReport;

typedef struct FjellPaint {
    void* object;
    uint64_t identity;
} FjellPaint;

#endif
