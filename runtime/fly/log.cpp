#include "fly/log.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::fly {

using nlohmann::json;

namespace {

constexpr std::pair<std::uint32_t, const char*> names_of_bits[] = {{exhausted_vertices, "vertices"},
                                                                   {exhausted_indices, "indices"},
                                                                   {exhausted_triangles, "triangles"},
                                                                   {exhausted_items, "items"},
                                                                   {exhausted_time, "time"}};

constexpr std::uint32_t bit_if(std::uint32_t bits, std::uint32_t bit, std::uint32_t then) {
    return (bits & bit) != 0 ? then : 0;
}

void raise(std::uint32_t& most, std::uint32_t value) {
    most = std::max(most, value);
}
void raise(std::optional<double>& most, double value) {
    most = std::max(most.value_or(0), value);
}

// What every frame has, rebuilt or not. Sums, where the field says mean.
void add_state(Summary& s, const FrameEntry& f) {
    s.vertices_mean += f.vertices;
    s.triangles_mean += f.triangles;
    s.triangles_drawn_mean += f.triangles_drawn;
    s.tiles_mean += f.tiles_drawn;
    s.converged += f.converged;
    s.rebuilt += f.rebuilt;
    s.overruns += f.items > f.item_limit;
    s.effective_px_max = std::max(s.effective_px_max, f.error_px_effective);
    s.exhausted |= f.exhausted;
    s.restarts += f.restarts;
    s.clearings += f.buffer_clearings;
    raise(s.vertices_max, f.vertices);
    raise(s.triangles_max, f.triangles);
    raise(s.waiting_max, f.waiting);
    raise(s.blocked_max, f.blocked);
    raise(s.rising_max, f.rising);
    raise(s.vertices_peak, f.vertices_peak);
    raise(s.triangles_peak, f.triangles_peak);
    if (f.rebuilt) {
        s.rebuild_us = std::max(s.rebuild_us, f.update_us);
        s.rebuild_bytes = std::max(s.rebuild_bytes, f.upload_bytes);
    }
    if (!f.verified_px) return;
    s.verified += f.settled;
    raise(f.settled ? s.verified_px_max : s.verified_lagging_px_max, *f.verified_px);
}

// What one frame's update did.
void add_work(Summary& s, const FrameEntry& f) {
    s.update_us_mean += f.update_us;
    s.prepare_us_mean += f.prepare_us;
    s.refine_us_mean += f.refine_us;
    s.output_us_mean += f.output_us;
    s.items_mean += f.items;
    s.evaluations_mean += f.evaluations;
    s.activations_mean += f.activations;
    s.deactivations_mean += f.deactivations;
    s.written_mean += f.vertices_written;
    s.triangles_written_mean += f.triangles_written;
    s.upload_mean += static_cast<double>(f.upload_bytes);
    raise(s.items_max, f.items);
}

} // namespace

FrameEntry entry_of(const FrameReport& r) {
    FrameEntry f;
    f.vertices = r.vertices;
    f.triangles = f.triangles_drawn = r.triangles;
    f.tiles_drawn = r.tiles;
    f.vertices_written = r.vertices_written;
    f.restarts = r.restarts;
    f.buffer_clearings = r.buffer_clearings;
    f.exhausted = bit_if(r.exhausted, budget_vertices, exhausted_vertices) |
                  bit_if(r.exhausted, budget_indices, exhausted_indices);
    f.error_px_asked = r.error_px_asked;
    f.error_px_effective = r.error_px_effective;
    f.converged = r.converged;
    f.settled = true;
    return f;
}

FrameEntry entry_of(const CutReport& r, const CutSettings& settings) {
    FrameEntry f;
    f.prepare_us = r.prepare_us;
    f.refine_us = r.refine_us;
    f.output_us = r.output_us;
    f.vertices = r.vertices;
    f.triangles = r.triangles;
    f.tiles_drawn = r.tiles_drawn;
    f.triangles_drawn = r.triangles_drawn;
    f.vertices_written = r.vertices_changed;
    f.triangles_written = r.triangles_changed;
    f.items = r.items;
    f.evaluations = r.evaluations;
    f.activations = r.activations;
    f.deactivations = r.deactivations;
    f.item_limit = r.rebuilt ? unlimited_items : settings.items;
    f.waiting = r.waiting;
    f.blocked = r.blocked;
    f.rising = r.rising;
    f.exhausted = bit_if(r.exhausted, cut_budget_vertices, exhausted_vertices) |
                  bit_if(r.exhausted, cut_budget_triangles, exhausted_triangles) |
                  bit_if(r.exhausted, cut_budget_items, exhausted_items) |
                  bit_if(r.exhausted, cut_budget_time, exhausted_time);
    f.vertices_peak = r.vertex_slots.peak;
    f.triangles_peak = r.triangle_slots.peak;
    f.error_px_asked = r.error_px_asked;
    f.error_px_effective = r.error_px_effective;
    f.converged = r.converged;
    f.rebuilt = r.rebuilt;
    f.settled = r.waiting == 0 && r.rising == 0;
    return f;
}

Percentiles percentiles(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const auto rank = [&](double share) {
        const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
        return values[std::clamp<std::size_t>(n, 1, values.size()) - 1];
    };
    return {rank(0.5), rank(0.99), rank(0.9999), values.back()};
}

Summary summarise(const FlightLog& log, bool incremental) {
    Summary s;
    s.incremental = incremental;
    s.frames = log.frames.size();
    if (s.frames == 0) return s;
    for (const FrameEntry& f : log.frames) add_state(s, f);
    const bool all = s.rebuilt == s.frames;
    std::vector<double> times;
    double vertices = 0;
    for (const FrameEntry& f : log.frames) {
        if (f.rebuilt && !all) continue;
        add_work(s, f);
        times.push_back(f.update_us);
        vertices += f.vertices;
    }
    s.ns_per_vertex = vertices > 0 ? s.update_us_mean * 1000 / vertices : 0;
    for (double* sum : {&s.vertices_mean, &s.triangles_mean, &s.triangles_drawn_mean, &s.tiles_mean})
        *sum /= static_cast<double>(s.frames);
    for (double* sum : {&s.update_us_mean, &s.prepare_us_mean, &s.refine_us_mean, &s.output_us_mean, &s.items_mean,
                        &s.evaluations_mean, &s.activations_mean, &s.deactivations_mean, &s.written_mean,
                        &s.triangles_written_mean, &s.upload_mean})
        *sum /= static_cast<double>(times.size());
    s.update_us = percentiles(std::move(times));
    return s;
}

std::vector<std::string> budget_names(std::uint32_t exhausted) {
    std::vector<std::string> names;
    for (const auto& [bit, name] : names_of_bits)
        if (exhausted & bit) names.emplace_back(name);
    return names;
}

std::string csv(const FlightLog& log) {
    std::string text = "frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,"
                       "converged,verified_px,items,evaluations,activations,deactivations,waiting,blocked,rising,"
                       "triangles_drawn,rebuilt,bytes_uploaded,prepare_us,refine_us,output_us\n";
    auto out = std::back_inserter(text);
    for (std::size_t i = 0; i < log.frames.size(); ++i) {
        const FrameEntry& f = log.frames[i];
        fmt::format_to(out, "{},{:.1f},{},{},{},{},{:.6g},{:.6g},{},{},", i, f.update_us, f.vertices, f.triangles,
                       f.tiles_drawn, f.vertices_written, f.error_px_asked, f.error_px_effective,
                       fmt::join(budget_names(f.exhausted), "+"), f.converged ? 1 : 0);
        if (f.verified_px) fmt::format_to(out, "{:.6g}", *f.verified_px);
        fmt::format_to(out, ",{},{},{},{},{},{},{},{},{},{},{:.1f},{:.1f},{:.1f}\n", f.items, f.evaluations,
                       f.activations, f.deactivations, f.waiting, f.blocked, f.rising, f.triangles_drawn,
                       f.rebuilt ? 1 : 0, f.upload_bytes, f.prepare_us, f.refine_us, f.output_us);
    }
    return text;
}

namespace {

// What only the incremental method knows; null for the other.
json incremental_json(const Summary& s) {
    json j = {{"changes_mean", s.activations_mean + s.deactivations_mean},
              {"items_mean", s.items_mean},
              {"items_max", s.items_max},
              {"evaluations_mean", s.evaluations_mean},
              {"activations_mean", s.activations_mean},
              {"deactivations_mean", s.deactivations_mean},
              {"triangles_written_mean", s.triangles_written_mean},
              {"waiting_max", s.waiting_max},
              {"blocked_max", s.blocked_max},
              {"rising_max", s.rising_max},
              {"vertices_peak", s.vertices_peak},
              {"triangles_peak", s.triangles_peak},
              {"prepare_us_mean", s.prepare_us_mean},
              {"refine_us_mean", s.refine_us_mean},
              {"output_us_mean", s.output_us_mean},
              {"rebuilt_frames", s.rebuilt},
              {"rebuild_us", s.rebuild_us},
              {"rebuild_bytes", s.rebuild_bytes}};
    if (!s.incremental)
        for (auto& value : j) value = nullptr;
    return j;
}

} // namespace

json summary_json(const Summary& s) {
    const auto number = [](const std::optional<double>& value) { return value ? json(*value) : json(); };
    json j = incremental_json(s);
    j.update({{"frames", s.frames},
              {"vertices_mean", s.vertices_mean},
              {"vertices_max", s.vertices_max},
              {"triangles_mean", s.triangles_mean},
              {"triangles_max", s.triangles_max},
              {"triangles_drawn_mean", s.triangles_drawn_mean},
              {"tiles_mean", s.tiles_mean},
              {"vertices_written_mean", s.written_mean},
              {"update_us",
               {{"p50", s.update_us.p50},
                {"p99", s.update_us.p99},
                {"p9999", s.update_us.p9999},
                {"max", s.update_us.max},
                {"mean", s.update_us_mean}}},
              {"selected_ns_per_vertex", s.ns_per_vertex},
              {"overruns", s.overruns},
              {"allocations", nullptr},
              {"converged_frames", s.converged},
              {"error_px_effective_max", s.effective_px_max},
              {"exhausted", budget_names(s.exhausted)},
              {"restarts", s.restarts},
              {"buffer_clearings", s.clearings},
              {"verified_frames", s.verified},
              {"verified_error_px_max", number(s.verified_px_max)},
              {"verified_lagging_error_px_max", number(s.verified_lagging_px_max)},
              {"bytes_uploaded_mean", s.upload_mean},
              {"pages_requested", 0}, // packs are loaded whole
              {"pages_loaded", 0},
              {"textures_requested", 0},
              {"textures_loaded", 0}});
    return j;
}

} // namespace fjell::fly
