// A terrain that an engine opens with one line and updates with another: pack, memory, cut, stream and reading threads
// in one object. What it is made of stays reachable, and is public as the tier below (fjell/fjell.h): an engine with
// its own memory and its own loader uses that.
//
// Example: once, and in every frame:
//     fjell::io::LiveTerrain ground(path, fjell::live_options(profile));
//     const fjell::io::LiveFrame& frame = ground.update({&view, 1}, now_s);
//     for (const char* field : frame.short_of) std::printf("raise %s\n", field);
//
// Memory: all of it at opening, memory_bytes() and 16 KB or so for each file. update() is the frame's: no allocation,
// lock or call into the kernel. Threads: one that updates; its own, which read; queries (fjell/query.h) of terrain() on
// any thread, at any time until it is destroyed. Destroying it at any moment stops the reading threads first. Failure:
// io::Failure, 1 for a pack, a budget, a view or a setting that cannot be used, 3 when the disk fails at opening. What
// cannot be read later is coarser terrain, a count (LiveFrame::stream.failed) and a line (first_failure()).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/io/pack_file.h"
#include "fjell/io/stream_reader.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::io {

// What updates go by; may change from frame to frame. now_s of both is update()'s.
struct LiveSettings {
    CutSettings cut{};
    StreamSettings stream{};
};

// What it may use: fixed at opening.
struct LiveOptions {
    std::uint32_t page_slots = 8192; // pages of geometry in memory; no more than the pack has are made
    CutBudget cut{};                 // segment_triangles are halved until they suit the number of tiles
    StreamBudget stream{};
    StreamReaderOptions reader{};
    LiveSettings settings{}; // to begin with
};

// Bits of LiveFrame::forgotten: what a host that draws has left out, so that the ground is grey or dark.
enum LiveForgotten : std::uint32_t {
    live_map_commands = 1u << 0, // map commands of an earlier update were not taken: take_map_commands()
    live_tile_maps = 1u << 1     // maps are loaded, and tile_maps() was never asked which tile shows which
};

// What an update has done. Spans hold until the next one.
struct LiveFrame {
    CutMesh mesh;           // what is drawn, and how it morphs
    CutReport cut;          // error_bound_px: what the mesh keeps
    StreamReport stream;    // what was read, and what is missing
    bool converged = false; // all that the views want is there, drawn to the threshold, and every map
    // Converged, or as near to it as budgets and disk allow: nothing is read, waits or moves, and the same views would
    // change nothing more.
    bool settled = false;
    std::span<const char* const> short_of; // the budget fields that did not suffice: "CutBudget::vertices"
    std::uint32_t forgotten = 0;           // LiveForgotten, from the first frame on in which it was seen
};

class PackStream;

class LiveTerrain {
public:
    // From a pack's file, a pack set's folder or its set.json.
    explicit LiveTerrain(const std::string& path, const LiveOptions& options = {});
    // From a pack's bytes in memory, which must outlive it. name: for messages.
    LiveTerrain(std::span<const std::byte> pack, const std::string& name, const LiveOptions& options = {});
    ~LiveTerrain();
    LiveTerrain(const LiveTerrain&) = delete;
    LiveTerrain& operator=(const LiveTerrain&) = delete;

    LiveSettings settings; // of the next update

    // Takes over what was read, and refines and coarsens the mesh for the views: 1 to CutBudget::views of them. now_s:
    // the host's clock. Call it once a frame; what it returns is the object's own.
    const LiveFrame& update(std::span<const View> views, double now_s);
    [[nodiscard]] const LiveFrame& frame() const { return frame_; } // of the last update

    // Slots of the mesh that were written since the last call; whoever uploads takes them.
    [[nodiscard]] CutChanges take_changes() { return cut_take_changes(cut_); }
    // Of the last update, for whoever keeps the maps on a GPU: take them after each one.
    [[nodiscard]] std::span<const MapCommand> take_map_commands();
    // Which layer each tile shows of a map: what a renderer goes by after the commands.
    [[nodiscard]] std::span<const TileMap> tile_maps(MapKind kind);

    [[nodiscard]] const Terrain& terrain() const { return terrain_; }
    [[nodiscard]] LiveCut cut() const { return cut_; }
    [[nodiscard]] Stream stream() const;
    [[nodiscard]] const Pack& pack() const { return pack_; }
    [[nodiscard]] const PackFile* file() const { return file_.get(); }    // null: in memory
    [[nodiscard]] const LiveOptions& options() const { return options_; } // as they were made to suit the pack
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] StreamReaderCounters reader() const;
    // Of what could not be read: "PACK: page 3 of tile 1: why"; empty: nothing. Allocates: not for every frame.
    [[nodiscard]] std::string first_failure() const;

private:
    struct Block; // memory of one part
    void begin(const std::string& name);

    LiveOptions options_;
    std::unique_ptr<PackFile> file_;
    Pack pack_;
    std::unique_ptr<Block> terrain_block_, cut_block_;
    Terrain terrain_;
    LiveCut cut_;
    LiveFrame frame_;
    std::array<const char*, 10> short_of_{};
    bool commands_taken_ = true, maps_asked_for_ = false;
    std::uint32_t quiet_ = 0;            // updates in a row that found nothing to do
    std::unique_ptr<PackStream> stream_; // last: its threads stop before what they read into goes
};

// A tile's last segment is half empty on average: four segments a tile at least keep that to an eighth of the
// triangles.
[[nodiscard]] CutBudget suited(CutBudget budget, const Terrain& terrain);

} // namespace fjell::io
FJELL_API_END
