#include "fly/log.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::fly {

using nlohmann::json;

Percentiles percentiles(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const auto rank = [&](double share) {
        const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
        return values[std::clamp<std::size_t>(n, 1, values.size()) - 1];
    };
    return {rank(0.5), rank(0.99), rank(0.9999), values.back()};
}

Summary summarise(const FlightLog& log) {
    Summary s;
    s.frames = log.frames.size();
    if (s.frames == 0) return s;
    std::vector<double> times;
    double time_us = 0, vertices = 0, triangles = 0, tiles = 0, written = 0, uploaded = 0;
    for (const FrameEntry& f : log.frames) {
        times.push_back(f.update_us);
        time_us += f.update_us;
        vertices += f.report.vertices;
        triangles += f.report.triangles;
        tiles += f.report.tiles;
        written += f.report.vertices_written;
        uploaded += static_cast<double>(f.upload_bytes);
        s.vertices_max = std::max(s.vertices_max, f.report.vertices);
        s.triangles_max = std::max(s.triangles_max, f.report.triangles);
        s.converged += f.report.converged;
        s.effective_px_max = std::max(s.effective_px_max, f.report.error_px_effective);
        s.exhausted |= f.report.exhausted;
        s.restarts += f.report.restarts;
        s.clearings += f.report.buffer_clearings;
        if (!f.verified_px) continue;
        ++s.verified;
        s.verified_px_max = std::max(s.verified_px_max.value_or(0), *f.verified_px);
    }
    const auto n = static_cast<double>(s.frames);
    s.vertices_mean = vertices / n;
    s.triangles_mean = triangles / n;
    s.tiles_mean = tiles / n;
    s.written_mean = written / n;
    s.upload_mean = uploaded / n;
    s.update_us = percentiles(std::move(times));
    s.update_us_mean = time_us / n;
    s.ns_per_vertex = vertices > 0 ? time_us * 1000 / vertices : 0;
    return s;
}

std::vector<std::string> budget_names(std::uint32_t exhausted) {
    std::vector<std::string> names;
    if (exhausted & budget_vertices) names.emplace_back("vertices");
    if (exhausted & budget_indices) names.emplace_back("indices");
    return names;
}

std::string csv(const FlightLog& log) {
    std::string text = "frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,"
                       "converged,verified_px\n";
    auto out = std::back_inserter(text);
    for (std::size_t i = 0; i < log.frames.size(); ++i) {
        const FrameEntry& f = log.frames[i];
        const FrameReport& r = f.report;
        fmt::format_to(out, "{},{:.1f},{},{},{},{},{:.6g},{:.6g},{},{},", i, f.update_us, r.vertices, r.triangles,
                       r.tiles, r.vertices_written, r.error_px_asked, r.error_px_effective,
                       fmt::join(budget_names(r.exhausted), "+"), r.converged ? 1 : 0);
        if (f.verified_px) fmt::format_to(out, "{:.6g}", *f.verified_px);
        text += '\n';
    }
    return text;
}

json summary_json(const Summary& s) {
    return {{"frames", s.frames},
            {"vertices_mean", s.vertices_mean},
            {"vertices_max", s.vertices_max},
            {"triangles_mean", s.triangles_mean},
            {"triangles_max", s.triangles_max},
            {"triangles_drawn_mean", s.triangles_mean}, // this method emits what it culled to, and all of it is drawn
            {"tiles_mean", s.tiles_mean},
            {"changes_mean", nullptr}, // this method knows no changes, only what it wrote
            {"vertices_written_mean", s.written_mean},
            {"update_us",
             {{"p50", s.update_us.p50},
              {"p99", s.update_us.p99},
              {"p9999", s.update_us.p9999},
              {"max", s.update_us.max},
              {"mean", s.update_us_mean}}},
            {"selected_ns_per_vertex", s.ns_per_vertex},
            {"overruns", 0}, // this method has no time budget to overrun
            {"allocations", nullptr},
            {"converged_frames", s.converged},
            {"error_px_effective_max", s.effective_px_max},
            {"exhausted", budget_names(s.exhausted)},
            {"restarts", s.restarts},
            {"buffer_clearings", s.clearings},
            {"verified_frames", s.verified},
            {"verified_error_px_max", s.verified_px_max ? json(*s.verified_px_max) : json()},
            {"bytes_uploaded_mean", s.upload_mean},
            {"pages_requested", 0}, // packs are loaded whole
            {"pages_loaded", 0},
            {"textures_requested", 0},
            {"textures_loaded", 0}};
}

} // namespace fjell::fly
