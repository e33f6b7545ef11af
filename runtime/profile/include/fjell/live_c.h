// A streamed terrain in one object for hosts in C (C99 and later): pack, memory, mesh, stream and reading threads. It
// is opened with one call and updated with another. It is fjell::io::LiveTerrain (fjell/io/live_terrain.h) with a
// profile (fjell/profile.h); a host in C needs to read neither of these headers. Types and queries are those of
// fjell/fjell_c.h.
//
//     char why[256];
//     FjellLiveOptions options = {.struct_size = sizeof options, .path = "alps.fjell", .profile = "laptop.toml"};
//     FjellLive* const ground = fjell_live_open(&options, why, sizeof why);
//     if (ground == NULL) return fail(why);
//     ... every frame: FjellLiveFrame frame = {.struct_size = sizeof frame};
//                      FjellStatus status = fjell_live_update(ground, &view, 1, now_s, &frame);
//     fjell_live_close(ground);
//
// Memory: all of it is allocated when the object is opened. fjell_live_update() is for the frame: it does not allocate,
// lock or enter the kernel.
// Threads: one thread updates, takes and sets. The object has threads of its own that read. Queries of
// fjell_live_terrain() (heights, rays, patches: fjell_c.h) may run on any thread until the object is closed. Two
// objects are independent of each other. Stamps (fjell_push_stamp()) may be pushed on any thread; fjell_live_update()
// applies them.
// Failure: `why` receives one line, cut short if it does not fit. A status has a code and the field at fault
// (fjell_message()). NULL in place of an object is refused with FJELL_INVALID_HANDLE. If something cannot be read while
// the camera flies, the terrain stays coarser there and is counted: FjellLiveFrame::failed, fjell_live_first_failure().
// Nothing prints or aborts.
// Linking: the library is C++ inside. Link fjell::profile with the C++ compiler, or all of Fjell as shared libraries.
#ifndef FJELL_LIVE_C_H
#define FJELL_LIVE_C_H

#include "fjell/fjell_c.h"

FJELL_API_BEGIN
#ifdef __cplusplus
extern "C" {
#endif

typedef struct FjellLive FjellLive;

// A key of a profile and its value as TOML writes it: {"refine.max_error_px", "2"}. profiles/laptop.toml has all keys.
typedef struct FjellProfileKey {
    const char *key, *value;
} FjellProfileKey;

// What is opened, and with which profile. Texts end with 0 and are copied. Give either path or pack, and either profile
// or profile_text; with neither profile the defaults apply.
typedef struct FjellLiveOptions {
    uint64_t struct_size;
    const char* path; // a pack's file, a pack set's folder or its set.json
    // The bytes of a pack in memory, which must outlive the object.
    const void* pack;
    size_t pack_bytes;
    const char* profile;         // a profile's file, as the editor saves it
    const char* profile_text;    // the text of a profile
    const FjellProfileKey* keys; // keys that override the profile, in order
    size_t key_count;
    const FjellEditBudget* edits; // not NULL: the ground can be changed, and this is what changes may use
    // Not NULL: the pack's journal (fjell/io/journal.h), whose stamps are applied from the first update on. A file that
    // is not there has none. Needs `edits`.
    const char* journal;
} FjellLiveOptions;

// Opens a terrain. NULL if it fails; `why` then has the reason: a pack, a set or a profile that cannot be used (with
// file, line and key), a budget that cannot hold the coarsest mesh, a disk error, or too little memory.
FjellLive* fjell_live_open(const FjellLiveOptions* options, char* why, size_t why_bytes);
// Closes a terrain, at any time. Its reading threads stop first. NULL is allowed.
void fjell_live_close(FjellLive* live);
// Changes a key from the next update on. False if it fails; `why` then has the reason: an unknown key, a value out of
// its range, or a key that is fixed at opening (budgets). It allocates, so do not call it in every frame.
bool fjell_live_set(FjellLive* live, FjellProfileKey key, char* why, size_t why_bytes);

// Keeps stamps in FjellLiveOptions::journal, on top of the layer of that name, which is made if there is none. All of
// them are on the disk when it returns true; otherwise none are, and `why` has the reason. It does not apply them:
// push them too. What they point to is copied. From the first call on, the journal cannot be changed by another
// program. It allocates and writes, so do not call it in every frame. Any thread, one at a time.
bool fjell_live_keep_stamps(FjellLive* live, const char* layer, const FjellStamp* stamps, size_t stamp_count, char* why,
                            size_t why_bytes);

// What an update has done. The pointers are valid until the next one.
typedef struct FjellLiveFrame {
    uint64_t struct_size;
    FjellCutMesh mesh;     // what is drawn, and how it morphs
    double error_bound_px; // the mesh's bound: no sample is farther from it on screen
    // All pages and maps that the views want are loaded, and the mesh is drawn to the threshold.
    bool converged;
    bool settled;    // converged, or as near to it as budgets and disk allow
    uint32_t failed; // pages and mips that could not be read, so far
    // Names of the budget fields that did not suffice, e.g. "CutBudget::vertices".
    const char* const* short_of;
    size_t short_of_count;
    uint32_t forgotten; // calls that the host has left out: FJELL_LIVE_MAP_COMMANDS, FJELL_LIVE_TILE_MAPS
} FjellLiveFrame;
enum {
    // fjell_live_take_map_commands() was not called after an earlier update.
    FJELL_LIVE_MAP_COMMANDS = 1u << 0,
    // Maps are loaded, and fjell_live_tile_maps() was never called.
    FJELL_LIVE_TILE_MAPS = 1u << 1
};

// Takes over what was read, and refines the mesh for the views. Call it once a frame. views: 1 to the profile's
// budget.views. now_s: the host's clock in seconds. frame may be NULL. Returns FJELL_OUT_OF_RANGE for a view that is
// invalid or has a wrong struct_size.
FjellStatus fjell_live_update(FjellLive* live, const FjellView* views, size_t view_count, double now_s,
                              FjellLiveFrame* frame);
// The full reports of the last update. Either may be NULL, and begins with struct_size.
FjellStatus fjell_live_reports(const FjellLive* live, FjellCutReport* cut, FjellStreamReport* stream);

// Takes the slots of the mesh that were written since the last call, for upload.
FjellCutChanges fjell_live_take_changes(FjellLive* live);
// For hosts that keep the maps on a GPU: take the commands after each update, then ask which layer each tile shows.
// `map` is an FjellMapKind. fjell_stream_map_layers(fjell_live_stream(live), map) says which layers to create.
const FjellMapCommand* fjell_live_take_map_commands(FjellLive* live, size_t* count);
const FjellTileMap* fjell_live_tile_maps(FjellLive* live, uint8_t map, size_t* count);

// The parts of the object, for the calls of fjell_c.h. {0} for NULL.
FjellTerrain fjell_live_terrain(const FjellLive* live);
FjellLiveCut fjell_live_cut(const FjellLive* live);
FjellStream fjell_live_stream(const FjellLive* live);
FjellEdits fjell_live_edits(const FjellLive* live); // for fjell_push_stamp(); {0} without FjellLiveOptions::edits
size_t fjell_live_memory_bytes(const FjellLive* live);
// The first thing that could not be read: "PACK: page 3 of tile 1: why". Empty if everything could. It allocates, so do
// not call it in every frame.
void fjell_live_first_failure(const FjellLive* live, char* why, size_t why_bytes);

#ifdef __cplusplus
} // extern "C"
#endif
FJELL_API_END
#endif
