#include "session/log.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::session {

using nlohmann::json;

namespace {

constexpr std::pair<std::uint32_t, const char*> names_of_bits[] = {{exhausted_vertices, "vertices"},
                                                                   {exhausted_indices, "indices"},
                                                                   {exhausted_triangles, "triangles"},
                                                                   {exhausted_items, "items"},
                                                                   {exhausted_time, "time"},
                                                                   {exhausted_page_slots, "page_slots"},
                                                                   {exhausted_map_bytes, "map_bytes"},
                                                                   {exhausted_stream_pages, "stream_pages"},
                                                                   {exhausted_stream_upload, "stream_upload"},
                                                                   {exhausted_stream_tests, "stream_tests"},
                                                                   {exhausted_stream_requests, "stream_requests"}};

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
    s.effective_px_max = std::max(s.effective_px_max, f.error_bound_px);
    s.threshold_px_max = std::max(s.threshold_px_max, f.threshold_px);
    s.exhausted |= f.exhausted;
    s.restarts += f.restarts;
    s.clearings += f.buffer_clearings;
    raise(s.vertices_max, f.vertices);
    raise(s.triangles_max, f.triangles);
    raise(s.waiting_max, f.waiting);
    raise(s.blocked_max, f.blocked);
    raise(s.morphing_max, f.morphing);
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

void add_streaming(StreamSummary& s, const FrameEntry& f, std::size_t frame, std::vector<double>& times) {
    const StreamReport& r = f.stream;
    s.streamed = true;
    s.last = r;
    s.pages_inserted += r.pages_inserted;
    s.mips_uploaded += r.mips_uploaded;
    s.upload_bytes += r.map_upload_bytes;
    s.cancelled += r.cancelled;
    raise(s.pages_wanted_max, r.pages_wanted);
    raise(s.pages_left_max, r.pages_left);
    raise(s.mips_left_max, r.mips_left);
    raise(s.pages_evicting_max, r.pages_evicting);
    raise(s.in_flight_max, r.in_flight);
    s.map_bytes_max = std::max(s.map_bytes_max, r.map_bytes_used);
    s.missing_px_max = std::max(s.missing_px_max, f.missing_px);
    s.missing_mips_max = std::max(s.missing_mips_max, r.missing_mips);
    s.converged += r.converged;
    s.maps_converged += r.maps_converged;
    if (r.complete && !s.coarse_s) s.coarse_s = f.at_s;
    if (f.converged && r.converged && r.maps_converged && !s.picture_s) s.picture_s = f.at_s, s.picture_frame = frame;
    s.update_us_mean += f.stream_us;
    times.push_back(f.stream_us);
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

void add_stream(FrameEntry& f, const StreamReport& r) {
    f.streamed = true;
    f.stream = r;
    f.stream_us = r.update_us;
    f.missing_px = r.missing_px;
    f.converged = f.converged && r.converged;
    f.exhausted |= bit_if(r.exhausted, stream_page_slots, exhausted_page_slots) |
                   bit_if(r.exhausted, stream_map_bytes, exhausted_map_bytes) |
                   bit_if(r.exhausted, stream_pages, exhausted_stream_pages) |
                   bit_if(r.exhausted, stream_upload, exhausted_stream_upload) |
                   bit_if(r.exhausted, stream_tests, exhausted_stream_tests) |
                   bit_if(r.exhausted, stream_requests, exhausted_stream_requests);
}

void add_poll(FrameEntry& frame, const FrameEntry& poll) {
    const FrameEntry before = frame;
    frame = poll;
    frame.polls = before.polls + 1;
    frame.rebuilt = poll.rebuilt || before.rebuilt;
    frame.exhausted |= before.exhausted;
    const auto sum = [&](auto field) { frame.*field += before.*field; };
    for (const auto field : {&FrameEntry::update_us, &FrameEntry::prepare_us, &FrameEntry::refine_us,
                             &FrameEntry::output_us, &FrameEntry::stream_us})
        sum(field);
    for (const auto field : {&FrameEntry::vertices_written, &FrameEntry::triangles_written, &FrameEntry::items,
                             &FrameEntry::evaluations, &FrameEntry::activations, &FrameEntry::deactivations})
        sum(field);
    // As much as all of them were allowed: each keeps to its own.
    frame.item_limit =
        before.item_limit > unlimited_work - poll.item_limit ? unlimited_work : before.item_limit + poll.item_limit;
    sum(&FrameEntry::upload_bytes);
    const auto sum_stream = [&](auto field) { frame.stream.*field += before.stream.*field; };
    for (const auto field : {&StreamReport::pages_inserted, &StreamReport::mips_uploaded, &StreamReport::cancelled})
        sum_stream(field);
    sum_stream(&StreamReport::map_upload_bytes);
}

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
    f.error_px_requested = r.error_px_requested;
    f.threshold_px = f.error_bound_px = r.error_bound_px;
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
    f.items = r.work;
    f.evaluations = r.evaluations;
    f.activations = r.activations;
    f.deactivations = r.deactivations;
    f.item_limit = r.rebuilt ? unlimited_work : settings.max_work;
    f.waiting = r.waiting;
    f.blocked = r.blocked;
    f.morphing = r.morphing;
    f.exhausted = bit_if(r.exhausted, cut_budget_vertices, exhausted_vertices) |
                  bit_if(r.exhausted, cut_budget_triangles, exhausted_triangles) |
                  bit_if(r.exhausted, cut_budget_work, exhausted_items) |
                  bit_if(r.exhausted, cut_budget_time, exhausted_time);
    f.vertex_slots = r.vertex_slots;
    f.triangle_slots = r.triangle_slots;
    f.vertices_peak = r.vertex_slots.peak;
    f.triangles_peak = r.triangle_slots.peak;
    f.error_px_requested = r.error_px_requested;
    f.threshold_px = r.threshold_px;
    f.error_bound_px = r.error_bound_px;
    f.converged = r.converged;
    f.rebuilt = r.rebuilt;
    f.settled = r.waiting == 0 && r.morphing == 0;
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
    std::vector<double> stream_times;
    for (std::size_t i = 0; i < log.frames.size(); ++i) {
        add_state(s, log.frames[i]);
        if (log.frames[i].streamed) add_streaming(s.stream, log.frames[i], i, stream_times);
    }
    if (!stream_times.empty()) s.stream.update_us_mean /= static_cast<double>(stream_times.size());
    s.stream.update_us = percentiles(std::move(stream_times));
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
                       "triangles_drawn,rebuilt,bytes_uploaded,prepare_us,refine_us,output_us,stream_us,pages_taken,"
                       "pages_left,pages_wanted,pages_draining,pages_failed,page_slots,mips_taken,mips_left,requested,"
                       "bytes_read,map_upload_bytes,missing_px,missing_mips,stream_converged,polls,at_s\n";
    auto out = std::back_inserter(text);
    for (std::size_t i = 0; i < log.frames.size(); ++i) {
        const FrameEntry& f = log.frames[i];
        fmt::format_to(out, "{},{:.1f},{},{},{},{},{:.6g},{:.6g},{},{},", i, f.update_us, f.vertices, f.triangles,
                       f.tiles_drawn, f.vertices_written, f.error_px_requested, f.error_bound_px,
                       fmt::join(budget_names(f.exhausted), "+"), f.converged ? 1 : 0);
        if (f.verified_px) fmt::format_to(out, "{:.6g}", *f.verified_px);
        fmt::format_to(out, ",{},{},{},{},{},{},{},{},{},{},{:.1f},{:.1f},{:.1f},", f.items, f.evaluations,
                       f.activations, f.deactivations, f.waiting, f.blocked, f.morphing, f.triangles_drawn,
                       f.rebuilt ? 1 : 0, f.upload_bytes, f.prepare_us, f.refine_us, f.output_us);
        const StreamReport& r = f.stream;
        fmt::format_to(out, "{:.1f},{},{},{},{},{},{},{},{},{},{},{},{:.6g},{:.3g},{},{},{:.4f}\n", f.stream_us,
                       r.pages_inserted, r.pages_left, r.pages_wanted, r.pages_evicting, r.failed, r.page_slots.used,
                       r.mips_uploaded, r.mips_left, r.in_flight, r.bytes_read, r.map_upload_bytes, f.missing_px,
                       r.missing_mips, r.converged ? 1 : 0, f.polls, f.at_s);
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
              {"rising_max", s.morphing_max},
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

namespace {

json times_json(const Percentiles& p, double mean) {
    return {{"p50", p.p50}, {"p99", p.p99}, {"p9999", p.p9999}, {"max", p.max}, {"mean", mean}};
}

template <typename T>
json maybe(const std::optional<T>& value) {
    return value ? json(*value) : json();
}

// What only a streamed flight knows; null for one that is loaded whole.
json stream_json(const StreamSummary& s) {
    if (!s.streamed) return nullptr;
    const StreamReport& r = s.last;
    return {
        {"coarse_s", maybe(s.coarse_s)},
        {"first_picture_s", maybe(s.picture_s)},
        {"first_picture_frame", maybe(s.picture_frame)},
        {"converged_frames", s.converged},
        {"maps_converged_frames", s.maps_converged},
        {"missing_px_max", s.missing_px_max},
        {"missing_mips_max", s.missing_mips_max},
        {"pages_read", r.pages_read},
        {"pages_taken", s.pages_inserted},
        {"pages_wanted_max", s.pages_wanted_max},
        {"pages_left_max", s.pages_left_max},
        {"pages_draining_max", s.pages_evicting_max},
        {"mips_read", r.mips_read},
        {"mips_taken", s.mips_uploaded},
        {"mips_left_max", s.mips_left_max},
        {"requested_max", s.in_flight_max},
        {"withdrawn", s.cancelled},
        {"failed", r.failed},
        {"bytes_read", r.bytes_read},
        {"map_upload_bytes", s.upload_bytes},
        {"page_slots", {{"used", r.page_slots.used}, {"peak", r.page_slots.peak}, {"capacity", r.page_slots.capacity}}},
        {"map_bytes", {{"used", r.map_bytes_used}, {"peak", s.map_bytes_max}, {"capacity", r.map_bytes_capacity}}},
        {"update_us", times_json(s.update_us, s.update_us_mean)}};
}

} // namespace

json summary_json(const Summary& s) {
    json j = incremental_json(s);
    j.update({{"frames", s.frames},
              {"vertices_mean", s.vertices_mean},
              {"vertices_max", s.vertices_max},
              {"triangles_mean", s.triangles_mean},
              {"triangles_max", s.triangles_max},
              {"triangles_drawn_mean", s.triangles_drawn_mean},
              {"tiles_mean", s.tiles_mean},
              {"vertices_written_mean", s.written_mean},
              {"update_us", times_json(s.update_us, s.update_us_mean)},
              {"selected_ns_per_vertex", s.ns_per_vertex},
              {"overruns", s.overruns},
              {"allocations", nullptr},
              {"converged_frames", s.converged},
              {"error_px_effective_max", s.effective_px_max},
              {"exhausted", budget_names(s.exhausted)},
              {"restarts", s.restarts},
              {"buffer_clearings", s.clearings},
              {"verified_frames", s.verified},
              {"verified_error_px_max", maybe(s.verified_px_max)},
              {"verified_lagging_error_px_max", maybe(s.verified_lagging_px_max)},
              {"bytes_uploaded_mean", s.upload_mean},
              {"pages_loaded", s.stream.last.pages_read}, // 0: the pack was loaded whole
              {"textures_loaded", s.stream.last.mips_read},
              {"stream", stream_json(s.stream)}});
    return j;
}

} // namespace fjell::session
