// A run of the live cut in a file, to be replayed bit for bit: bug reports, tests, fuzzing and the editor share it.
//
// JSON, one object a line. The first names the pack and the budget, each further one a frame: the views (eye, forward,
// up, vertical field of view in radians, width and height in pixels, near and far in metres, lambda_px), the settings,
// the blocks that the frame visited, and a hash of the mesh after it. Numbers are written so that they are read back
// exactly. A frame that its time ended is replayed by its visits, so the clock of the replaying machine does not
// matter.
//
// Throws host::Failure: 1 for a file that is damaged, of another version, or of another pack; 3 when it cannot be
// written.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/cut.h"
#include "fjell/pack.h"
#include "fjell/view.h"

namespace fjell::fly {

struct RecordedFrame {
    std::vector<View> views;
    CutSettings settings; // without budget_us; visits: what the frame did, if there was one
    bool rebuild = false;
    std::uint64_t mesh_hash = 0;
};

struct Recording {
    std::uint64_t pack_hash = 0; // PackHeader::directory_hash
    CutBudget budget;
    std::vector<RecordedFrame> frames;
};

// Of the ranges that are drawn, in their order, and of every vertex slot. O(mesh).
[[nodiscard]] std::uint64_t mesh_hash(const MeshView& mesh);

// What a frame just done has to be replayed with.
[[nodiscard]] RecordedFrame recorded(std::span<const View> views, const CutSettings& settings, const CutReport& report,
                                     const MeshView& mesh);

[[nodiscard]] std::string write_recording(const Recording& recording);
// name: of the file, for messages.
[[nodiscard]] Recording parse_recording(std::string_view text, const std::string& name);

} // namespace fjell::fly
