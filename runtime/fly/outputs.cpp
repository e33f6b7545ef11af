#include "fly/outputs.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/failure.h"

namespace fjell::fly {

namespace {

using host::AtomicFile;
using host::Failure;
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

const char* name_of(Metric metric) {
    return metric == Metric::depth ? "depth" : "isotropic";
}
const char* name_of(Topology topology) {
    return topology == Topology::strip ? "strip" : "list";
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
            {"terrain_bytes", terrain_bytes(h)},
            {"method_bytes", session.block_bytes}};
}

json flight_json(const Options& o, const Session& session, const CameraPath& path, const Summary& summary,
                 const Verification& v) {
    json j = summary_json(summary);
    const RefineSettings& r = o.profile.refine;
    j["method"] = "recursive";
    j["metric"] = name_of(r.metric);
    j["topology"] = name_of(r.topology);
    j["cull"] = r.cull;
    j["corner_safe"] = r.corner_safe;
    j["error_px"] = r.error_px;
    j["viewport"] = {o.profile.width_px, o.profile.height_px};
    j["fov_y_deg"] = o.profile.fov_deg;
    j["budget"] = {{"vertices", o.profile.budget.vertices}, {"indices", o.profile.budget.indices}};
    j["path"] = path.name;
    j["profile"] = o.profile_path.empty() ? json() : json(o.profile_path);
    j["seed"] = o.seeded ? json(o.seed) : json();
    j["verified_ok"] = summary.verified ? json(!v.exceeded) : json();
    j["pack"] = pack_json(session);
    return j;
}

std::string table(const Options& o, const Summary& s, const Verification& v) {
    std::string text;
    const auto row = [&](const char* name, const std::string& value) {
        text += fmt::format("{:<22} {}\n", name, value);
    };
    row("frames",
        fmt::format("{}, {} of them converged; threshold {:g} px", s.frames, s.converged, o.profile.refine.error_px));
    row("update [us]", fmt::format("{:.0f} mean, {:.0f} p50, {:.0f} p99, {:.0f} max", s.update_us_mean, s.update_us.p50,
                                   s.update_us.p99, s.update_us.max));
    row("selected vertices",
        fmt::format("{:.0f} mean, {} max, {:.1f} ns each", s.vertices_mean, s.vertices_max, s.ns_per_vertex));
    row("triangles", fmt::format("{:.0f} mean, {} max", s.triangles_mean, s.triangles_max));
    row("tiles drawn", fmt::format("{:.0f} mean", s.tiles_mean));
    row("uploaded [kB/frame]", fmt::format("{:.0f} mean", s.upload_mean / 1000));
    if (s.exhausted)
        row("budgets exhausted", fmt::format("{}; the threshold rose to {:.3g} px; raise them in the profile",
                                             fmt::join(budget_names(s.exhausted), " and "), s.effective_px_max));
    if (s.verified)
        row("verified error [px]",
            fmt::format("{:.4f} largest of {} frames, threshold {:g}; nearest to its limit: {:.4f} of {:g}, frame {}",
                        *s.verified_px_max, s.verified, o.profile.refine.error_px, v.max_px, v.limit_px, v.frame));
    return text;
}

} // namespace

Outputs::Outputs(const Options& options) : csv_(open_output(options.csv)), json_(open_output(options.json)) {
    for (const Export& e : options.exports) check_export(e.path);
    if (!options.render_folder.empty()) check_folder(options.render_folder, options.render_folder);
}

void Outputs::finish(const Options& options, const Session& session, const CameraPath& path, const FlightLog& log,
                     const Verification& verification) {
    const Summary summary = summarise(log);
    if (csv_ || options.csv == "-") write_all(csv_, options.csv, csv(log));
    if (json_ || options.json == "-")
        write_all(json_, options.json, flight_json(options, session, path, summary, verification).dump(2) + "\n");
    if (options.csv != "-" && options.json != "-") fmt::print("{}", table(options, summary, verification));
}

} // namespace fjell::fly
