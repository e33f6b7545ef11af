// A run of the live cut in a file, to be replayed bit for bit: bug reports, tests, fuzzing and the editor share it.
//
// JSON, one object a line. The first names the pack and the budget, each further one a frame: the views (eye, forward,
// up, the tangents of its left, right, bottom and top, width and height in pixels, near and far in metres, and its own
// threshold if it has one), the settings, the groups that the frame visited, and a hash of the mesh after it. Of a
// streamed run the first line has the page slots, and a frame what happened to pages before its update and the error
// that missing ones may hide: it is replayed from the whole pack, and the disk of the replaying machine does not matter
// either. Of moving ground the first line has the budget of edits, and a frame the stamps that were pushed before its
// update. Numbers are written so that they are read back exactly. A frame that ran out of time is replayed by its
// visits, so the clock of the replaying machine does not matter.
//
// Throws io::Failure: 1 for a file that is damaged, of another version, or of another pack; 3 when it cannot be
// written.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/cut.h"
#include "fjell/pack.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"
#include "fjell/view.h"
#include "io/stamps.h"

namespace fjell::session {

struct RecordedFrame {
    std::vector<View> views;
    CutSettings settings; // without budget_us; visits: what the frame did, if there was one
    bool rebuild = false;
    std::uint64_t mesh_hash = 0;
    std::vector<io::KeptStamp> stamps; // in their order; before the pages
    std::vector<PageArrival> pages;    // in their order, before the update
    double missing_px = 0;             // Terrain::missing_px at the update
};

struct Recording {
    std::uint64_t pack_hash = 0; // PackHeader::directory_hash
    CutBudget budget;
    std::uint32_t page_slots = 0; // TerrainBudget::page_slots; 0: the pack was loaded whole
    std::vector<RecordedFrame> frames;
    std::optional<EditBudget> edits = {}; // of moving ground
};

// Of the ranges that are drawn, in their order, and of every vertex slot. O(mesh).
[[nodiscard]] std::uint64_t mesh_hash(const MeshView& mesh);

// What is needed to replay the frame that was just updated.
[[nodiscard]] RecordedFrame recorded(std::span<const View> views, const CutSettings& settings, const CutReport& report,
                                     const MeshView& mesh);

// Applies the frame's page events to the terrain and its cut, before its update. Fails as load_page does, with
// out_of_range for a page that the pack does not have; then what came before it is done.
Status replay_pages(const Pack& pack, Terrain& terrain, LiveCut cut, const RecordedFrame& frame);

[[nodiscard]] std::string write_recording(const Recording& recording);
// name: of the file, for messages.
[[nodiscard]] Recording parse_recording(std::string_view text, const std::string& name);

} // namespace fjell::session
