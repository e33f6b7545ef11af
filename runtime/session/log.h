// What every frame of a flight cost and gave, and what scripts read of it: one CSV line a frame, one JSON object a
// flight. The same columns and keys for both methods; what a method does not know is 0, or null in the JSON.
//
// Thread: one. Memory: about 500 bytes a frame, reserved at the start, so that nothing is allocated between frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "fjell/cut.h"
#include "fjell/recursive.h"
#include "fjell/stream.h"

namespace fjell::session {

enum ExhaustedBit : std::uint32_t {
    exhausted_vertices = 1u << 0,
    exhausted_indices = 1u << 1,   // recursive
    exhausted_triangles = 1u << 2, // incremental, as the next two
    exhausted_items = 1u << 3,
    exhausted_time = 1u << 4,
    exhausted_page_slots = 1u << 5, // streaming, as all that follow
    exhausted_map_bytes = 1u << 6,
    exhausted_stream_pages = 1u << 7,
    exhausted_stream_upload = 1u << 8,
    exhausted_stream_tests = 1u << 9,
    exhausted_stream_requests = 1u << 10
};

struct FrameEntry {
    double update_us = 0;
    double prepare_us = 0, refine_us = 0, output_us = 0; // incremental: of update_us
    // Recursive: selected, where culling left them. Incremental: active all around, and what of it is drawn.
    std::uint32_t vertices = 0, triangles = 0, tiles_drawn = 0, triangles_drawn = 0;
    std::uint32_t vertices_written = 0, triangles_written = 0; // slots
    std::uint32_t items = 0, evaluations = 0, activations = 0, deactivations = 0;
    std::uint32_t item_limit = unlimited_work;
    std::uint32_t waiting = 0, blocked = 0, morphing = 0;
    std::uint32_t exhausted = 0; // ExhaustedBits
    std::uint32_t restarts = 0, buffer_clearings = 0;
    std::uint32_t vertices_peak = 0, triangles_peak = 0; // slots in use, so far; triangles in whole segments
    BudgetUse vertex_slots;                              // of the method's memory; the recursive one knows no peaks
    BudgetUse triangle_slots;                            // incremental, in whole segments
    BudgetUse index_slots;                               // recursive
    double error_px_requested = 0, threshold_px = 0, error_bound_px = 0;
    bool converged = false, rebuilt = false;
    // Nothing waits and nothing morphs: the threshold holds. Every frame of the recursive method.
    bool settled = false;
    std::uint64_t upload_bytes = 0; // what a renderer must be given: written slots, or all of them when rebuilt
    std::optional<double> verified_px;
    // Of a streamed flight; update_us is the method's alone.
    bool streamed = false;
    StreamReport stream;
    double stream_us = 0;    // of update_stream
    double missing_px = 0;   // Terrain::missing_px: what missing pages may hide, in pixels
    double at_s = 0;         // when the frame was done, from the flight's start
    std::uint32_t polls = 1; // updates that it took; more with --wait
};
// What the stream's update of this frame reported.
void add_stream(FrameEntry& entry, const StreamReport& report);
// A frame of several updates: the last one's state, and the work of all of them.
void add_poll(FrameEntry& frame, const FrameEntry& poll);

// Without times, bytes and measured errors.
[[nodiscard]] FrameEntry entry_of(const FrameReport& report);
[[nodiscard]] FrameEntry entry_of(const CutReport& report, const CutSettings& settings);

struct FlightLog {
    std::vector<FrameEntry> frames;
};

struct Percentiles {
    double p50 = 0, p99 = 0, p9999 = 0, max = 0;
};
// Nearest rank: the smallest value that at least that share of all values does not exceed. Empty: zeros.
[[nodiscard]] Percentiles percentiles(std::vector<double> values);

struct StreamSummary {
    bool streamed = false;
    StreamReport last; // counts so far are those of the flight
    std::uint64_t pages_inserted = 0, mips_uploaded = 0, upload_bytes = 0, cancelled = 0;
    std::uint32_t pages_wanted_max = 0, pages_left_max = 0, mips_left_max = 0, pages_evicting_max = 0,
                  in_flight_max = 0;
    std::uint64_t map_bytes_max = 0;
    double missing_px_max = 0, missing_mips_max = 0;
    std::size_t converged = 0, maps_converged = 0; // frames
    std::optional<double> coarse_s;                // when the coarsest of every tile was there
    std::optional<double> picture_s;               // when a frame first had all that its view wanted, maps too
    std::optional<std::size_t> picture_frame;
    Percentiles update_us;
    double update_us_mean = 0;
};

// Times, items, changes and bytes are of the frames that were not rebuilt. Building the cut from scratch is counted
// apart, as rebuild_us and rebuild_bytes, or one first frame would outweigh hundreds that follow. (A flight that
// consists of rebuilt frames alone counts those.)
struct Summary {
    std::size_t frames = 0, converged = 0, verified = 0, rebuilt = 0;
    bool incremental = false;
    double vertices_mean = 0, triangles_mean = 0, triangles_drawn_mean = 0, tiles_mean = 0, written_mean = 0;
    double triangles_written_mean = 0, upload_mean = 0;
    std::uint32_t vertices_max = 0, triangles_max = 0;
    double items_mean = 0, evaluations_mean = 0, activations_mean = 0, deactivations_mean = 0;
    std::uint32_t items_max = 0, waiting_max = 0, blocked_max = 0, morphing_max = 0;
    std::uint32_t vertices_peak = 0, triangles_peak = 0;
    std::size_t overruns = 0; // frames with more items than their limit
    Percentiles update_us;
    double update_us_mean = 0, prepare_us_mean = 0, refine_us_mean = 0, output_us_mean = 0;
    double rebuild_us = 0; // the longest
    std::uint64_t rebuild_bytes = 0;
    double ns_per_vertex = 0; // time of all updates over all selected vertices
    double effective_px_max = 0, threshold_px_max = 0;
    std::uint32_t exhausted = 0, restarts = 0, clearings = 0;
    std::optional<double> verified_px_max;         // of settled frames
    std::optional<double> verified_lagging_px_max; // of the others: no more than each one claims
    StreamSummary stream;
};
[[nodiscard]] Summary summarise(const FlightLog& log, bool incremental);

// "vertices", "indices", "triangles", "items", "time", "page_slots", "map_bytes", "stream_pages", ...: the budgets
// named by ExhaustedBits.
[[nodiscard]] std::vector<std::string> budget_names(std::uint32_t exhausted);

// frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_bound_px,exhausted,converged,verified_px,
// then items,evaluations,activations,deactivations,waiting,blocked,rising,triangles_drawn,rebuilt,bytes_uploaded,
// prepare_us,refine_us,output_us, then stream_us,pages_taken,pages_left,pages_wanted,pages_draining,pages_failed,
// page_slots,mips_taken,mips_left,requested,bytes_read,map_upload_bytes,missing_px,missing_mips,stream_converged,polls,
// at_s: zeros of a flight that is not streamed, but for the last two. bytes_read: so far.
// exhausted: names joined by +, empty when none; verified_px: empty when the frame was not measured.
[[nodiscard]] std::string csv(const FlightLog& log);

// The keys of a flight that the frames alone give; the caller adds what it flew.
[[nodiscard]] nlohmann::json summary_json(const Summary& summary);

} // namespace fjell::session
