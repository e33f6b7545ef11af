#include "fly/outputs.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"

namespace fjell::session {

namespace {

using io::AtomicFile;
using io::Failure;
using nlohmann::json;

std::unique_ptr<AtomicFile> open_output(const std::string& path) {
    if (path.empty() || path == "-") return {};
    return std::make_unique<AtomicFile>(path);
}

void check_folder(const std::string& folder, const std::string& output) {
    struct stat info {};
    if (stat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode))
        throw Failure(1, fmt::format("{}: the output folder does not exist; create it or choose another", output));
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        throw Failure(3, fmt::format("{}: cannot write there: {}; choose a folder you may write to", output,
                                     std::strerror(errno)));
}

std::string folder_of(const std::string& path) {
    const auto slash = path.find_last_of('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

void check_export(const std::string& path) {
    check_folder(folder_of(path), path);
    struct stat info {};
    if (path.ends_with('/') || (stat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode)))
        throw Failure(1, fmt::format("{}: is a folder; give the output a file name", path));
}

void write_all(std::unique_ptr<AtomicFile>& file, const std::string& path, const std::string& text) {
    if (path == "-") std::fwrite(text.data(), 1, text.size(), stdout);
    if (!file) return;
    file->write(std::as_bytes(std::span(text)));
    file->commit();
}

json pack_json(const Session& session) {
    const PackHeader& h = session.loaded.pack.header;
    return {{"columns", h.columns},
            {"rows", h.rows},
            {"tiles", {h.tiles_x, h.tiles_y}},
            {"tile_cells", 1u << h.tile_log2},
            {"spacing_m", {h.spacing_m[0], h.spacing_m[1]}},
            {"height_m", {h.min_m, h.max_m}},
            {"quantum_m", h.quantum_m},
            {"max_error_m", h.max_error_m},
            {"file_bytes", h.file_bytes},
            {"pack_hash", fmt::format("{:016x}", h.directory_hash)},
            {"load_seconds", session.load_seconds},
            {"terrain_bytes", session.terrain_bytes},
            {"method_bytes", session.method->bytes()}};
}

// What the frames do not know of streaming: where the memory is, and what the reader did.
void add_stream(json& j, const FlightOptions& o, const Session& session) {
    j["pages_requested"] = 0; // the pack was loaded whole
    j["textures_requested"] = 0;
    j["streamed"] = session.streamed != nullptr;
    if (!session.streamed) return;
    const io::StreamReaderCounters r = session.streamed->reader();
    std::uint64_t map_bytes = 0;
    for (const MapKind kind : {MapKind::colour, MapKind::normal, MapKind::horizon, MapKind::splat})
        map_bytes += map_layer_bytes(stream_map_layers(session.streamed->stream(), kind), kind);
    j["pages_requested"] = r.pages;
    j["textures_requested"] = r.mips;
    j["stream"]["reader"] = {{"reads", r.reads},         {"bytes", r.bytes},     {"unwanted", r.unwanted},
                             {"errors", r.errors},       {"damaged", r.damaged}, {"read_s", r.read_s},
                             {"provide_s", r.provide_s}, {"mb_s", o.read_mb_s},  {"latency_ms", o.read_latency_ms}};
    j["stream"]["memory_bytes"] = {{"terrain", session.terrain_bytes},
                                   {"method", session.method->bytes()},
                                   {"stream", session.streamed->memory_bytes()},
                                   {"maps_on_gpu", map_bytes}};
    const StreamBudget& b = o.profile.stream_budget;
    const StreamSettings& s = o.profile.stream;
    j["stream"]["budget"] = {{"page_slots", o.profile.page_slots},
                             {"page_requests", b.page_requests},
                             {"map_requests", b.map_requests},
                             {"map_bytes", b.map_bytes},
                             {"tail_log2", b.tail_log2},
                             {"decoders", b.decoders},
                             {"texel_px", s.texel_px},
                             {"lookahead_s", s.lookahead_s},
                             {"fade_s", s.fade_s},
                             {"pages", s.pages},
                             {"tests", s.tests},
                             {"map_upload_bytes", s.map_bytes}};
}

void add_edits(json& j, const Session& session) {
    j["edits"] = json(); // the ground stayed as it was
    if (!session.edits) return;
    const EditTotals& t = session.edits->totals();
    j["edits"] = {{"stamps", session.edits->stamps()},
                  {"applied", t.applied},
                  {"refused", t.refused},
                  {"waiting", t.last.waiting},
                  {"held", t.last.held},
                  {"samples", t.samples},
                  {"blocks", t.last.blocks},
                  {"blocks_capacity", session.edits->budget().blocks},
                  {"locked_blocks", t.last.locks},
                  {"always_drawn", count_always_drawn(session.edits->edits())},
                  {"bytes", session.edits->bytes()},
                  {"loose", t.last.loose},
                  {"unmeasured", t.last.unmeasured},
                  {"apply_us", t.apply_us},
                  {"measure_us", t.measure_us},
                  {"apply_us_max", t.apply_us_max},
                  {"update_us_max", t.update_us_max}};
}

json flight_json(const FlightOptions& o, const Session& session, const CameraPath& path, const Summary& summary,
                 const Verification& v) {
    json j = summary_json(summary);
    const RefineSettings& r = o.profile.refine;
    j.update(session.method->described(o.profile));
    j["corner_safe"] = r.corner_safe;
    j["error_px"] = r.max_error_px;
    j["viewport"] = {o.profile.width_px, o.profile.height_px};
    j["fov_y_deg"] = o.profile.fov_deg;
    j["path"] = path.name;
    j["profile"] = o.profile_path.empty() ? json() : json(o.profile_path);
    j["seed"] = o.seeded ? json(o.seed) : json();
    j["verified_ok"] = summary.verified ? json(!v.exceeded) : json();
    j["pack"] = pack_json(session);
    add_stream(j, o, session);
    add_edits(j, session);
    return j;
}

std::string row(const char* name, const std::string& value) {
    return fmt::format("{:<22} {}\n", name, value);
}

std::string stream_rows(const Summary& summary) {
    const StreamSummary& s = summary.stream;
    const StreamReport& r = s.last;
    std::string text =
        row("streamed", fmt::format("{} pages and {} mips, {:.1f} MB; {} frames had all they wanted", r.pages_read,
                                    r.mips_read, static_cast<double>(r.bytes_read) / 1e6, s.converged));
    text += row("stream update [us]", fmt::format("{:.0f} mean, {:.0f} p50, {:.0f} p99, {:.0f} max", s.update_us_mean,
                                                  s.update_us.p50, s.update_us.p99, s.update_us.max));
    text += row("page slots", fmt::format("{} used, {} peak, {} in all", r.page_slots.used, r.page_slots.peak,
                                          r.page_slots.capacity));
    if (s.picture_s)
        text +=
            row("first whole picture", fmt::format("{:.2f} s after opening, frame {}", *s.picture_s, *s.picture_frame));
    if (const std::uint32_t wanting = summary.exhausted & (exhausted_page_slots | exhausted_map_bytes))
        text += row("coarser for want of", fmt::format("{}; raise them in [stream] of the profile",
                                                       fmt::join(budget_names(wanting), " and ")));
    return text;
}

std::string table(const FlightOptions& o, const Summary& s, const Verification& v) {
    std::string text;
    const auto row = [&](const char* name, const std::string& value) { text += session::row(name, value); };
    row("frames", fmt::format("{}, {} of them converged; threshold {:g} px", s.frames, s.converged,
                              o.profile.refine.max_error_px));
    row("update [us]", fmt::format("{:.0f} mean, {:.0f} p50, {:.0f} p99, {:.0f} max", s.update_us_mean, s.update_us.p50,
                                   s.update_us.p99, s.update_us.max));
    if (s.rebuilt)
        row("built from nothing",
            fmt::format("{:.0f} us, once{}", s.rebuild_us, s.rebuilt < s.frames ? "; not in the figures above" : ""));
    row(s.incremental ? "active vertices" : "selected vertices",
        fmt::format("{:.0f} mean, {} max, {:.1f} ns each", s.vertices_mean, s.vertices_max, s.ns_per_vertex));
    row("triangles", fmt::format("{:.0f} mean, {} max", s.triangles_mean, s.triangles_max));
    if (s.incremental) {
        row("triangles drawn", fmt::format("{:.0f} mean", s.triangles_drawn_mean));
        row("changes a frame", fmt::format("{:.0f} vertices mean, for {:.0f} work items, {} at most",
                                           s.activations_mean + s.deactivations_mean, s.items_mean, s.items_max));
    }
    row("tiles drawn", fmt::format("{:.0f} mean", s.tiles_mean));
    row("uploaded [kB/frame]", fmt::format("{:.1f} mean", s.upload_mean / 1000));
    constexpr std::uint32_t work = exhausted_items | exhausted_time, capacities = exhausted_page_slots - 1;
    if (s.exhausted & capacities & ~work)
        row("budgets exhausted",
            fmt::format("{}; the threshold rose to {:.3g} px; raise them in the profile",
                        fmt::join(budget_names(s.exhausted & capacities & ~work), " and "), s.threshold_px_max));
    if (s.exhausted & work)
        row("lagged for want of", fmt::format("{}; up to {} groups and pages waited",
                                              fmt::join(budget_names(s.exhausted & work), " and "), s.waiting_max));
    if (s.stream.streamed) text += stream_rows(s);
    if (s.verified)
        row("verified error [px]",
            fmt::format("{:.4f} largest of {} frames, threshold {:g}; nearest to its limit: {:.4f} of {:g}, frame {}",
                        *s.verified_px_max, s.verified, o.profile.refine.max_error_px, v.max_px, v.limit_px, v.frame));
    if (s.verified_lagging_px_max)
        row("error while it lagged", fmt::format("{:.4f} px largest measured", *s.verified_lagging_px_max));
    return text;
}

} // namespace

Outputs::Outputs(const FlightOptions& options)
    : csv_(open_output(options.csv)), json_(open_output(options.json)), record_(open_output(options.record)) {
    for (const Export& e : options.exports) check_export(e.path);
    if (options.render_folder.empty()) return;
    std::string folder = options.render_folder;
    while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
    if (mkdir(folder.c_str(), 0777) == 0) made_folder_ = folder;
    check_folder(folder, options.render_folder); // also says why it was not made
}

Outputs::~Outputs() {
    if (!made_folder_.empty()) (void)rmdir(made_folder_.c_str()); // refused for one that holds pictures
}

std::string Outputs::keep_measured(const FlightOptions& options, const FlightLog& log) {
    if (log.frames.empty() || options.csv.empty()) return "";
    try {
        write_all(csv_, options.csv, csv(log));
    } catch (const Failure& failure) {
        return fmt::format("; {}", failure.what());
    }
    return fmt::format("; {} has the {} frames before", options.csv == "-" ? "the CSV" : options.csv,
                       log.frames.size());
}

void Outputs::finish(const FlightOptions& options, const Session& session, const CameraPath& path, const FlightLog& log,
                     const Verification& verification) {
    const Summary summary = summarise(log, facts_of(session.method->kind).keeps_mesh);
    if (csv_ || options.csv == "-") write_all(csv_, options.csv, csv(log));
    if (json_ || options.json == "-")
        write_all(json_, options.json, flight_json(options, session, path, summary, verification).dump(2) + "\n");
    if (record_) write_all(record_, options.record, write_recording(*session.recording));
    if (options.csv != "-" && options.json != "-") fmt::print("{}", table(options, summary, verification));
}

} // namespace fjell::session
