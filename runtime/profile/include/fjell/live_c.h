// A terrain that a host in C (C99 and later) opens with one call and updates with another: pack, memory, mesh, stream
// and reading threads in one object. It is fjell::io::LiveTerrain (fjell/io/live_terrain.h) with a profile
// (fjell/profile.h); what a host in C must know of both stands here. Types and queries are those of fjell/fjell_c.h.
//
//   char why[256];
//   FjellLiveOptions options = {.struct_size = sizeof options, .path = "alps.fjell", .profile = "laptop.toml"};
//   FjellLive* const ground = fjell_live_open(&options, why, sizeof why);
//   if (ground == NULL) return fail(why);
//   ... every frame: FjellLiveFrame frame = {.struct_size = sizeof frame};
//                    FjellStatus status = fjell_live_update(ground, &view, 1, now_s, &frame);
//   fjell_live_close(ground);
//
// Memory: all of it at opening. fjell_live_update() is the frame's: it neither allocates nor locks nor calls into the
// kernel. Threads: one that updates, takes and sets; its own, which read; queries of fjell_live_terrain() (heights,
// rays, patches: fjell_c.h) on any thread until it is closed. Two objects know nothing of each other.
// Failure: what is written to `why` is one line, cut short where it does not fit; a status has a code and the field at
// fault (fjell_message()). NULL in place of an object is refused, FJELL_INVALID_HANDLE. What cannot be read while it
// flies is coarser terrain and a count: FjellLiveFrame::failed, fjell_live_first_failure(). Nothing prints or aborts.
// Linking: the library is C++ inside; link fjell::profile with the C++ compiler, or all of Fjell as shared libraries.
#ifndef FJELL_LIVE_C_H
#define FJELL_LIVE_C_H

#include "fjell/fjell_c.h"

FJELL_API_BEGIN
#ifdef __cplusplus
extern "C" {
#endif

typedef struct FjellLive FjellLive;

// A key of a profile and its value as TOML writes it: {"refine.max_error_px", "2"}. profiles/laptop.toml has them all.
typedef struct FjellProfileKey {
    const char *key, *value;
} FjellProfileKey;

// What is opened, and with what. Texts end with 0 and are copied; NULL: there is none.
typedef struct FjellLiveOptions {
    uint64_t struct_size;
    const char* path; // a pack's file, a pack set's folder or its set.json; or
    const void* pack; // the bytes of a pack in memory, which must outlive the object
    size_t pack_bytes;
    const char* profile;         // a profile's file, as the editor saves it; or
    const char* profile_text;    // what stands in one. Neither: the defaults
    const FjellProfileKey* keys; // over those, in order
    size_t key_count;
} FjellLiveOptions;

// NULL, and why: a pack, a set or a profile that cannot be used (its line names file, line and key), a budget that
// cannot hold the coarsest mesh, a disk that fails, memory that there is not.
FjellLive* fjell_live_open(const FjellLiveOptions* options, char* why, size_t why_bytes);
// At any moment; its reading threads stop first. NULL: nothing.
void fjell_live_close(FjellLive* live);
// Changes a key from the next update on. False, and why: no such key, a value out of its range, or a key that is fixed
// at opening (budgets). Allocates: not for every frame.
bool fjell_live_set(FjellLive* live, FjellProfileKey key, char* why, size_t why_bytes);

// What an update has done. Pointers hold until the next one.
typedef struct FjellLiveFrame {
    uint64_t struct_size;
    FjellCutMesh mesh;           // what is drawn, and how it morphs
    double error_bound_px;       // what it keeps: no sample is farther off on the screen
    bool converged;              // all that the views want is there, drawn to the threshold, and every map
    bool settled;                // converged, or as near to it as budgets and disk allow
    uint32_t failed;             // pages and mips that could not be read, so far
    const char* const* short_of; // names of budget fields that did not suffice: "CutBudget::vertices"
    size_t short_of_count;
    uint32_t forgotten; // FJELL_LIVE_MAP_COMMANDS, FJELL_LIVE_TILE_MAPS
} FjellLiveFrame;
enum {
    FJELL_LIVE_MAP_COMMANDS = 1u << 0, // commands of an earlier update were not taken: fjell_live_take_map_commands()
    FJELL_LIVE_TILE_MAPS = 1u << 1     // maps are loaded, and fjell_live_tile_maps() was never asked
};

// Takes over what was read, and refines the mesh for the views: 1 to the profile's budget.views. now_s: the host's
// clock in seconds. Once a frame. frame may be NULL. FJELL_OUT_OF_RANGE: a view or its struct_size.
FjellStatus fjell_live_update(FjellLive* live, const FjellView* views, size_t view_count, double now_s,
                              FjellLiveFrame* frame);
// All that the parts report of the last update; either may be NULL, and begins with struct_size.
FjellStatus fjell_live_reports(const FjellLive* live, FjellCutReport* cut, FjellStreamReport* stream);

// Slots of the mesh that were written since the last call; whoever uploads takes them.
FjellCutChanges fjell_live_take_changes(FjellLive* live);
// For whoever keeps the maps on a GPU: after each update the commands, then which layer each tile shows. `map` is a
// FjellMapKind. The layers that are to be made: fjell_stream_map_layers(fjell_live_stream(live), map).
const FjellMapCommand* fjell_live_take_map_commands(FjellLive* live, size_t* count);
const FjellTileMap* fjell_live_tile_maps(FjellLive* live, uint8_t map, size_t* count);

// What it is made of, for the calls of fjell_c.h. {0} for NULL.
FjellTerrain fjell_live_terrain(const FjellLive* live);
FjellLiveCut fjell_live_cut(const FjellLive* live);
FjellStream fjell_live_stream(const FjellLive* live);
size_t fjell_live_memory_bytes(const FjellLive* live);
// "PACK: page 3 of tile 1: why" of what could not be read; empty: nothing. Allocates: not for every frame.
void fjell_live_first_failure(const FjellLive* live, char* why, size_t why_bytes);

#ifdef __cplusplus
} // extern "C"
#endif
FJELL_API_END
#endif
