// What every frame of a flight cost and gave, and what scripts read of it: one CSV line a frame, one JSON object a
// flight.
//
// Thread: one. Memory: about 100 bytes a frame, reserved at the start, so that nothing is allocated between frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "fjell/recursive.h"

namespace fjell::fly {

struct FrameEntry {
    FrameReport report;
    double update_us = 0;
    std::uint64_t upload_bytes = 0; // what a renderer must be given: the written vertices and all indices
    std::optional<double> verified_px;
};

struct FlightLog {
    std::vector<FrameEntry> frames;
};

struct Percentiles {
    double p50 = 0, p99 = 0, p9999 = 0, max = 0;
};
// Nearest rank: the smallest value that at least that share of all values does not exceed. Empty: zeros.
[[nodiscard]] Percentiles percentiles(std::vector<double> values);

struct Summary {
    std::size_t frames = 0, converged = 0, verified = 0;
    double vertices_mean = 0, triangles_mean = 0, tiles_mean = 0, written_mean = 0, upload_mean = 0;
    std::uint32_t vertices_max = 0, triangles_max = 0;
    Percentiles update_us;
    double update_us_mean = 0;
    double ns_per_vertex = 0; // time of all updates over all selected vertices
    double effective_px_max = 0;
    std::uint32_t exhausted = 0, restarts = 0, clearings = 0;
    std::optional<double> verified_px_max;
};
[[nodiscard]] Summary summarise(const FlightLog& log);

// "vertices", "indices": the budgets named by BudgetBits.
[[nodiscard]] std::vector<std::string> budget_names(std::uint32_t exhausted);

// frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,converged,verified_px
// exhausted: names joined by +, empty when none; verified_px: empty when the frame was not measured.
[[nodiscard]] std::string csv(const FlightLog& log);

// The keys of a flight that the frames alone give; the caller adds what it flew.
[[nodiscard]] nlohmann::json summary_json(const Summary& summary);

} // namespace fjell::fly
