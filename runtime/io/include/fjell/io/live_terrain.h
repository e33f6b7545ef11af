// A streamed terrain in one object: pack, memory, cut, stream and reading threads. An engine opens it with one line and
// updates it with another. The parts stay reachable. They are public (fjell/fjell.h), for engines with their own memory
// and their own loader.
//
// Example: once, and in every frame:
//     fjell::io::LiveTerrain ground(path, fjell::live_options(profile));
//     const fjell::io::LiveFrame& frame = ground.update({&view, 1}, now_s);
//     for (const char* field : frame.short_of) std::printf("raise %s\n", field);
//
// Ground that moves: set LiveOptions::edits, and push stamps to edits() (fjell/edit.h), from any thread. update()
// applies them before it updates pages and mesh. take_ground_changes(edits(), ...) says what has changed. With
// LiveOptions::journal the ground is the one that was left.
//
// Memory: all of it is allocated at opening: memory_bytes(), and some 16 KB for each file. update() is for the frame:
// it does not allocate, lock or enter the kernel.
// Threads: one thread updates. The object has threads of its own that read; the destructor stops them first, at any
// time. Queries (fjell/query.h) of terrain() may run on any thread until the object is destroyed.
// Failure: io::Failure, with exit code 1 for a pack, a budget, a view or a setting that cannot be used, and with 3 if
// the disk fails at opening. If something cannot be read later, the terrain stays coarser there, is counted
// (LiveFrame::stream.failed) and is named (first_failure()).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "fjell/cut.h"
#include "fjell/edit.h"
#include "fjell/export.h"
#include "fjell/io/pack_file.h"
#include "fjell/io/stream_reader.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::io {

// The settings of updates. They may change from frame to frame. update() sets the now_s of both.
struct LiveSettings {
    CutSettings cut{};
    StreamSettings stream{};
    EditSettings edits{};
};

// What the terrain may use. Fixed at opening.
struct LiveOptions {
    // Pages of geometry in memory, but no more than the pack has.
    std::uint32_t page_slots = 8192;
    CutBudget cut{}; // segment_triangles is halved until it suits the number of tiles
    StreamBudget stream{};
    StreamReaderOptions reader{};
    LiveSettings settings{}; // the first settings
    // Set: the ground can be changed, and this is what changes may use. Refused for a terrain that lacks tiles.
    std::optional<EditBudget> edits{};
    // A journal of the pack (fjell/io/journal.h), whose stamps are applied from the first update on. Needs `edits`, and
    // adds what it needs itself to their `blocks` and `paint`. What it says later is not followed: push those stamps
    // too. LiveFrame::edits counts what is refused. Empty: none.
    std::string journal{};
};

// Bits of LiveFrame::forgotten: calls that a host that draws has left out. Without them the ground is grey or dark.
enum LiveForgotten : std::uint32_t {
    // take_map_commands() was not called after an earlier update.
    live_map_commands = 1u << 0,
    // Maps are loaded, and tile_maps() was never called.
    live_tile_maps = 1u << 1
};

// What an update has done. The spans are valid until the next one.
struct LiveFrame {
    CutMesh mesh;        // what is drawn, and how it morphs
    CutReport cut;       // its error_bound_px is the mesh's
    StreamReport stream; // what was read, and what is missing
    EditReport edits;    // what was done of stamps; zeros without LiveOptions::edits
    // All pages and maps that the views want are loaded, and the mesh is drawn to the threshold.
    bool converged = false;
    // Converged, or as near to it as budgets and disk allow. Nothing is read, waits or moves, and another update with
    // the same views would change nothing. A stamp whose pages cannot be had does not count.
    bool settled = false;
    // Names of the budget fields that did not suffice, e.g. "CutBudget::vertices".
    std::span<const char* const> short_of;
    std::uint32_t forgotten = 0; // LiveForgotten, from the first frame that noticed it on
};

class PackStream;

class LiveTerrain {
public:
    // Opens a pack's file, a pack set's folder or its set.json.
    explicit LiveTerrain(const std::string& path, const LiveOptions& options = {});
    // Opens a pack's bytes in memory, which must outlive the object. name: for messages.
    LiveTerrain(std::span<const std::byte> pack, const std::string& name, const LiveOptions& options = {});
    ~LiveTerrain();
    LiveTerrain(const LiveTerrain&) = delete;
    LiveTerrain& operator=(const LiveTerrain&) = delete;

    LiveSettings settings; // of the next update

    // Takes over what was read, and refines and coarsens the mesh for the views. Call it once a frame. views: 1 to
    // CutBudget::views. now_s: the host's clock in seconds. The result belongs to the object.
    const LiveFrame& update(std::span<const View> views, double now_s);
    [[nodiscard]] const LiveFrame& frame() const { return frame_; } // the result of the last update

    // Takes the slots of the mesh that were written since the last call, for upload.
    [[nodiscard]] CutChanges take_changes() { return cut_take_changes(cut_); }
    // The map commands of the last update, for hosts that keep the maps on a GPU. Take them after each update.
    [[nodiscard]] std::span<const MapCommand> take_map_commands();
    // Which layer each tile shows of a map, for a renderer that has carried out the commands.
    [[nodiscard]] std::span<const TileMap> tile_maps(MapKind kind);

    [[nodiscard]] const Terrain& terrain() const { return terrain_; }
    [[nodiscard]] LiveCut cut() const { return cut_; }
    [[nodiscard]] Stream stream() const;
    [[nodiscard]] Edits edits() const { return edits_; } // for stamps; empty without LiveOptions::edits
    [[nodiscard]] const Pack& pack() const { return pack_; }
    [[nodiscard]] const PackFile* file() const { return file_.get(); }    // null for a pack in memory
    [[nodiscard]] const LiveOptions& options() const { return options_; } // as they were adapted to the pack
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] StreamReaderCounters reader() const;
    // The first thing that could not be read: "PACK: page 3 of tile 1: why". Empty if everything could. It allocates,
    // so do not call it in every frame.
    [[nodiscard]] std::string first_failure() const;

private:
    struct Block; // memory of one part
    struct Kept;  // a journal's stamps
    void begin(const std::string& name);
    void push_kept();
    void name_what_is_short();

    LiveOptions options_;
    std::unique_ptr<PackFile> file_;
    Pack pack_;
    std::unique_ptr<Block> terrain_block_, edits_block_, cut_block_;
    Terrain terrain_;
    Edits edits_;
    std::unique_ptr<Kept> kept_;
    LiveCut cut_;
    LiveFrame frame_;
    std::array<const char*, 14> short_of_{};
    bool commands_taken_ = true, maps_asked_for_ = false;
    std::uint32_t quiet_ = 0; // how many updates in a row found nothing to do
    // Last: its threads stop before the memory that they read into is freed.
    std::unique_ptr<PackStream> stream_;
};

// The same budget with segments of a size that suits the terrain: four segments or more for each tile. The last segment
// of a tile is half empty on average, so an eighth of the triangles at most is wasted.
[[nodiscard]] CutBudget suited(CutBudget budget, const Terrain& terrain);

} // namespace fjell::io
FJELL_API_END
