// What the live cut keeps in the host's memory, between frames.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "asserts.h"
#include "cut/bulk_pages.h"
#include "cut/groups.h"
#include "cut/queues.h"
#include "cut/schedule.h"
#include "fjell/cut.h"
#include "pack/terrain_data.h"
#include "view/wanted.h"

namespace fjell {

// What all groups of a frame share.
struct Criterion {
    const float* error_m;       // 256
    const float* radius_factor; // 128
    float base_m, quantum_m;    // HeightScale
    float spacing_x_m, spacing_z_m;
    std::int32_t last_x, last_y; // of the terrain's samples
    std::uint32_t views;
    bool hysteresis;            // keep differs from reach
    Reach reach[max_cut_views]; // for vertices that are not active
    Reach keep[max_cut_views];  // for those that are
};

struct LaneGroup; // evaluate.h
struct LaneAnswers;

// One group: a bit a lane in every mask. 16 bytes, so that a visit costs a quarter of a cache line beside the records.
// When it is due, the schedule says.
struct GroupState {
    std::uint16_t active;
    std::uint16_t parent[2]; // that parent is active, or does not exist because it would lie outside the terrain
    std::uint16_t child[4];  // that child is active; where it is not, an active vertex draws a triangle towards it
    QueueId queue;           // that the group waits in, or unqueued

    [[nodiscard]] std::uint16_t ready() const { return static_cast<std::uint16_t>(parent[0] & parent[1]); }
    [[nodiscard]] std::uint16_t parental() const {
        return static_cast<std::uint16_t>(child[0] | child[1] | child[2] | child[3]);
    }
};
static_assert(sizeof(GroupState) == 16, "four groups a cache line");

// What a page's vertices stand within, and the largest of their errors and spheres: what it could hide.
struct PageExtent {
    float low_m, high_m, error_m, radius_m;
};

// What a page slot of the terrain holds, as far as the cut knows.
struct LoadedPage {
    std::uint32_t page;  // tile * pages_per_tile + page, or no_index
    std::uint32_t loads; // TerrainData::slot_loads when the cut entered it
    bool evicting;
    PageExtent extent;
};

enum class PageStatus : std::uint8_t { empty, live, evicting };

// The state of a page: of every tile's page 0, and of those where a vertex has an active parent. No other can have
// anything to do, so the pool follows what is active, not what is loaded. A page's state is named by its place in the
// pool, and keeps it until it is idle and another page needs it.
struct alignas(64) PageState {  // a cache line
    std::uint32_t page;         // tile * pages_per_tile + page, or no_index
    std::uint32_t terrain_slot; // where its records are
    std::uint32_t tile;
    std::int32_t i0, j0; // the page's first square in its tile; page 0: 0
    std::int32_t tile_x, tile_y;
    std::int32_t x0, y0;     // its first square's corner, in samples of the terrain
    std::int32_t base;       // height scale steps
    std::int64_t late_ticks; // when one of its vertices last began to morph by time
    std::uint32_t parents;   // active ones, counted once for each vertex that has them; 0: the page is idle
    std::uint16_t active;    // vertices
    std::uint8_t z;          // log2 of the step; page 0: 0, its groups say
    std::uint8_t shape;      // 0: page 0; 1: any other
    PageStatus status;
    bool idle;              // listed among idle_pages: stays when the page leaves
    bool late;              // listed among late_pages
    std::uint8_t offscreen; // parts that no view sees, nor soon will (sight.h)
    bool used;              // something was active since its groups were last written: any of them may be queued
};
static_assert(sizeof(PageState) == 64);

// A tile's triangles: all segments but the last are full.
struct TileList : TileStack {
    bool bounded; // by the root's sphere; not while page 0 is missing
    double centre_m[3];
    double radius_m;
};

struct DirtyBits {
    std::uint64_t* bits;
    std::uint32_t* words; // which hold any
    std::uint32_t word_count;
    std::uint32_t slots; // marked

    void mark(std::uint32_t slot) {
        std::uint64_t& word = bits[slot / 64];
        const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
        if (word == 0) words[word_count++] = slot / 64;
        slots += (word & bit) == 0;
        word |= bit;
    }
    void mark_range(std::uint32_t first, std::uint32_t end) {
        for (; first < end && (first % 64 != 0 || end - first < 64); ++first) mark(first);
        for (; end - first >= 64; first += 64) {
            if (bits[first / 64] != 0) {
                for (std::uint32_t slot = first; slot < first + 64; ++slot) mark(slot);
                continue;
            }
            bits[first / 64] = ~std::uint64_t{0};
            words[word_count++] = first / 64;
            slots += 64;
        }
        for (; first < end; ++first) mark(first);
    }
    void clear() {
        for (std::uint32_t i = 0; i < word_count; ++i) bits[words[i]] = 0;
        word_count = slots = 0;
    }
    void move_to(DirtyBits& other) { // other.slots is not kept up to date
        for (std::uint32_t i = 0; i < word_count; ++i) {
            const std::uint32_t word = words[i];
            FJELL_ASSERT(bits[word] != 0); // or it was listed before, and would be listed there for good
            if (other.bits[word] == 0) other.words[other.word_count++] = word;
            other.bits[word] |= std::exchange(bits[word], 0);
        }
        word_count = slots = 0;
    }
};

// Of Mesh::hole.
inline constexpr std::uint8_t hole_bit = 1, morphs_out_bit = 2;

// What the governor remembers (governor.h).
struct Governor {
    double effective_px; // 0: not started
    double aim_px;       // where it goes: at once, or frame by frame where vertices morph
    std::uint32_t haste; // how often in a row it has arrived in vain
    double failed_px;    // a threshold at which a capacity did not suffice; 0: none known
    double failed_use;   // share of the scarcest capacity in use once that was resolved
    bool moved;          // the camera has since then
    std::uint32_t cause; // CutBudgetBits that keep the effective threshold above the requested one
};

// With what pages are looked at: planes 2 to 5 of frustums wider than a view, through the eye that it had then
// (sight.h).
struct Sight {
    Vec3 eye_m, forward;
    Frustum half, most, outer; // by half the margin, three quarters and all of it
    Frustum last;              // and beyond it: what parts leave
};
struct Sights {
    Sight of[max_cut_views];
    std::uint32_t count; // 0: nothing is off-screen
};

// The clock of morphing: the host's, in whole ticks that floats hold, however large its numbers are. Only what passes
// from one update to the next counts; of a gap no more than any morph takes.
inline constexpr std::int32_t ticks_a_second = 1 << 14;
inline constexpr std::int64_t clock_ticks = std::int64_t{ticks_a_second} * static_cast<std::int64_t>(morph_clock_s);
inline constexpr std::int64_t longest_gap_ticks = 16 * ticks_a_second; // CutSettings::morph_s is 10 at most
static_assert(clock_ticks <= 1 << 24, "floats hold 24 bits");

struct MorphClock {
    std::int64_t host_ticks;  // of the last update
    std::int64_t ticks;       // since the first update; an int64 lasts 17 million years
    std::int64_t timed_ticks; // when a vertex last began to morph by time
    [[nodiscard]] float now_s() const {
        return static_cast<float>(ticks % clock_ticks) / static_cast<float>(ticks_a_second);
    }
};

// The geometry of groups, the same for as long as the cut lives.
struct Grid {
    Terrain handle;
    const TerrainData* terrain; // its data
    std::uint32_t pages_per_tile;
    std::int32_t tiles_x, tiles_y;
    StepGroups steps[max_tile_log2];
    PageShape shapes[2];      // [0] of page 0, [1] of all others
    std::uint16_t* hz_places; // hierarchical Z-order: place of each group's lanes, for both shapes; else nullptr
    float level_unit_m[2 * max_tile_log2]; // of radii: centres at 2 z, sides at 2 z + 1
};

// The pool of page states, and the masks of their groups.
struct Pages {
    Grid grid;
    GroupState* groups;
    std::uint32_t* vertex_slot; // vertex slot of each active vertex
    std::uint32_t* page_groups; // first group of each page, or no_index: no state
    LoadedPage* loaded;         // one a page slot of the terrain
    std::uint64_t seen_changes;
    PageState* state;
    std::uint32_t count, group_count; // the pool's size
    std::uint32_t* free;              // a stack of given-back states; those from fresh on were never taken
    std::uint32_t free_count, fresh;
    std::uint32_t* idle; // a ring: those that became idle first; some of them are no longer
    std::uint32_t first_idle, idle_count;
    std::uint32_t tiles_waiting; // for their pages 0, which shall have one
    bool some_wait;              // a page was loaded, and had none to be had
    std::uint32_t busy;          // that are not idle
    std::uint32_t* evicting;     // states of pages that are being evicted
    std::uint32_t evicting_count;
};

// What is to be done, and when.
struct Work {
    Schedule schedule;
    Queues queues;
};

struct Mesh {
    // Vertex slots. The corners of all tiles have the first.
    std::uint32_t capacity, corner_count;
    MeshVertex* vertices;
    MorphVertex* morph;
    std::uint32_t* triangle_of;   // by key: its slot, or no_index
    std::uint8_t* hole;           // 1 a vertex slot: hole_bit, morphs_out_bit
    std::uint32_t* free_vertices; // a stack of given-back slots; those from fresh_vertex on were never taken
    std::uint32_t free_vertex_count, fresh_vertex, vertex_peak;
    std::uint32_t mapped; // entries of that stack that say what the bulk pass took, while the state follows
    // Triangle slots, in segments.
    std::uint32_t* indices; // 3 a triangle slot: right angle first
    TileList* tiles;        // tile_count, and one more: triangles that are not drawn
    std::uint32_t tile_count;
    std::uint32_t* segment_tile;
    std::uint32_t* segment_below; // the tile's segment before it
    std::uint32_t* free_segments;
    std::uint32_t free_segment_count, segment_count, segment_peak;
    std::uint32_t segment_log2;
    bool some_hidden; // the terrain has holes or ends inside tiles
    TileRange* ranges;
    std::uint32_t range_count;
    // What has changed.
    DirtyBits dirty_vertices, dirty_triangles;     // slots written by this update
    DirtyBits untaken_vertices, untaken_triangles; // and by those before, when the host had not taken them
    bool dirty_taken, untaken_taken;               // by cut_take_changes()
};

// The views of the last update, and what follows from them.
struct Views {
    View view[max_cut_views];
    Frustum frustum[max_cut_views];
    std::uint32_t count;                      // 0: no update yet
    Criterion criterion, offscreen_criterion; // of groups that are not off-screen, and of those that are
    double largest_unit_px;                   // screen_unit_px() (lag.h)
    double largest_ratio;                     // of a view's threshold to that of the settings
    bool jumped;                              // an eye has, so far that much is due
    bool leapt;                               // and it is not only a threshold that has
    bool still;                               // no eye has moved, come or gone since the frame before
    void (*evaluate)(const Criterion&, const LaneGroup&, LaneAnswers&);
    float (*worst_px)(const Criterion&, const LaneGroup&, const float*);
};

// With what pages are looked at.
struct Visibility {
    Sights now, before; // of the look that pages are given, and of the one that the others had
    std::uint32_t next; // state of a page that comes next; from Pages::fresh on all have had it
    bool mixed;         // the others had several: looks that did not come to their end
};

struct Morphing {
    MorphClock clock;
    MorphFrame now, before;
    std::uint32_t ring_size; // Mesh::capacity
    float* late_s;           // activated_s of vertices activated late, a ring: oldest first
    std::uint32_t first_late, late_count;
    std::uint32_t* late_pages; // states of pages with such vertices
    std::uint32_t late_page_count;
    std::uint32_t* out; // vertices that morph out, a ring: those that began first
    std::uint32_t first_out, out_count;
};

// The frame in work.
struct Frame {
    CutSettings settings;
    CutReport report;
    std::uint64_t number;
    std::uint32_t item_limit;
    bool lagging;                          // the frame before left work undone
    std::uint32_t full_capacities;         // CutBudgetBits of capacities at which a change has just failed
    std::uint32_t deactivations_when_full; // deactivations before it did
    std::uint32_t batches;                 // of groups, changed in this frame
    std::uint32_t examined;                // groups since the last batch, also of the frame before
    std::chrono::steady_clock::time_point started;
    double output_us;   // what the report of the last frame that lagged took
    double reserved_us; // of this frame's time, for its own
};

struct CutState {
    BlockHead head;
    CutBudget budget;
    Pages pages;
    Work work;
    BulkPass bulk;
    Mesh mesh;
    Views views;
    Visibility visibility;
    Governor governor;
    Morphing morphing;
    Frame frame;
};

[[nodiscard]] inline bool is_offscreen(const Pages& pages, std::uint32_t group) {
    const PageState& page = pages.state[group / max_page_groups];
    if (page.offscreen == 0) return false;
    const std::uint8_t parts = pages.grid.shapes[page.shape].groups[group % max_page_groups].parts;
    return (page.offscreen & parts) == parts;
}
[[nodiscard]] inline const Criterion& criterion_of(const Pages& pages, const Views& views, std::uint32_t group) {
    return is_offscreen(pages, group) ? views.offscreen_criterion : views.criterion;
}
inline void count_parents(Pages& pages, std::uint32_t slot, std::uint32_t more) {
    PageState& page = pages.state[slot];
    pages.busy += page.parents == 0 && more != 0;
    page.parents += more;
}
[[nodiscard]] inline std::uint32_t free_vertices(const Mesh& mesh) {
    return mesh.free_vertex_count - mesh.mapped + mesh.capacity - mesh.fresh_vertex;
}
[[nodiscard]] inline std::uint32_t take_vertex(Mesh& mesh) {
    FJELL_ASSERT(free_vertices(mesh) != 0);
    const std::uint32_t slot =
        mesh.free_vertex_count != 0 ? mesh.free_vertices[--mesh.free_vertex_count] : mesh.fresh_vertex++;
    FJELL_ASSERT(slot >= mesh.corner_count && slot < mesh.fresh_vertex);
    for (std::uint32_t d = 0; d < 4; ++d)
        mesh.triangle_of[slot * 4 + d] = no_index; // whoever had the slot is forgotten
    return slot;
}
inline void give_vertex(Mesh& mesh, std::uint32_t slot) {
    FJELL_ASSERT(slot >= mesh.corner_count && slot < mesh.fresh_vertex);
    FJELL_ASSERT(mesh.free_vertex_count < mesh.fresh_vertex - mesh.corner_count); // or one was given back twice
    mesh.free_vertices[mesh.free_vertex_count++] = slot;
}

// The cut behind a handle, or nullptr: also when its terrain is gone.
[[nodiscard]] inline CutState* find_cut(const LiveCut& cut) {
    CutState* const s = find(cut);
    return s != nullptr && find(s->pages.grid.handle) != nullptr ? s : nullptr;
}
inline constexpr Status no_cut{Code::invalid_handle, "cut, or its terrain"};

// Of an update, of the cut or of a stream beside it.
[[nodiscard]] Status validate(std::span<const View> views, const CutSettings& settings, std::uint32_t most_views);

// No vertex active, every page that is loaded entered, all slots free; and no triangle yet.
void reset(CutState& s);
// After reset(): two triangles a tile, and every tile's root due.
void begin_at_roots(const Pages& pages, Work& work, Mesh& mesh);

} // namespace fjell
