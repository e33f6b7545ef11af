// fjell-bake: IN -o OUT.fjell, info, verify, synth. Exit codes: 0 done, 1 the input is at fault, 2 usage, 3 the machine
// is.
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/bake.h"
#include "baker/picture.h"
#include "baker/progress.h"
#include "baker/read.h"
#include "baker/verify.h"
#include "host/file.h"
#include "host/load.h"

namespace {

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::host;
using nlohmann::json;

// Shared by bake and verify --against: how a file becomes heights in metres.
struct ReadFlags {
    double spacing_m = 0, zscale = 1, zoffset_m = 0;
    std::string nodata; // empty: automatic

    void add_to(CLI::App& app) {
        app.add_option("--spacing", spacing_m, "metres between samples; needed where the file has degrees or nothing");
        app.add_option("--zscale", zscale, "multiplies heights (after the file's own scale)");
        app.add_option("--zoffset", zoffset_m, "metres added to heights after --zscale");
        app.add_option("--nodata", nodata,
                       "samples without a height: leave a hole, fill from their neighbours, or refuse (default: what "
                       "the file marks and NaN become holes, implausible heights are refused)")
            ->check(CLI::IsMember({"hole", "fill", "refuse"}));
    }
    [[nodiscard]] ReadOptions options(const CLI::App& app, std::size_t memory_mb) const {
        ReadOptions o;
        if (app.count("--spacing")) o.spacing_m = spacing_m;
        o.zscale = zscale;
        o.zoffset_m = zoffset_m;
        if (nodata == "hole") o.nodata = NoData::hole;
        if (nodata == "fill") o.nodata = NoData::fill;
        if (nodata == "refuse") o.nodata = NoData::refuse;
        o.memory_bytes = memory_mb << 20;
        return o;
    }
};

struct Arguments {
    std::vector<std::string> inputs;
    std::string output, tile = "auto", estimate = "max", order = "planar", json_path;
    BakeOptions bake;
    ReadFlags read;
    std::size_t memory_mb = 8192;
    bool quiet = false;

    std::string pack, against, recipe, dem_out;
    ReadFlags verify_read;
    bool info_json = false;
    std::string picture_path;
    PictureOptions picture;
};

// A summary for scripts, opened before the work so that a missing folder does not cost a bake.
class JsonOutput {
public:
    explicit JsonOutput(const std::string& path) : to_stdout_(path == "-") {
        if (!path.empty() && !to_stdout_) file_.emplace(path);
    }
    void write(const json& value) {
        const std::string text = value.dump(2) + "\n";
        if (to_stdout_) fmt::print("{}", text);
        if (!file_) return;
        file_->write(std::as_bytes(std::span(text)));
        file_->commit();
    }

private:
    bool to_stdout_;
    std::optional<AtomicFile> file_;
};

const char* order_name(Order order) {
    switch (order) {
    case Order::planar: return "planar";
    case Order::hierarchical_z: return "hz";
    case Order::linear: break;
    }
    return "linear";
}

Order order_named(const std::string& name) {
    return name == "planar" ? Order::planar : name == "hz" ? Order::hierarchical_z : Order::linear;
}

// "512" or "auto" to log2; 0 for auto.
int tile_log2(const std::string& text) {
    if (text == "auto") return 0;
    for (int log2 = min_tile_log2; log2 <= max_tile_log2; ++log2)
        if (text == std::to_string(1 << log2)) return log2;
    throw Failure(2, fmt::format("--tile {}: must be auto or a power of two from 2 to 4096 (cells a side)", text));
}

json summary_json(const BakeSummary& s) {
    return {{"columns", s.columns},
            {"rows", s.rows},
            {"tiles", {s.tree.tiles_x, s.tree.tiles_y}},
            {"tile_cells", s.tree.side()},
            {"quantum_m", s.quantum_m},
            {"max_error_m", s.max_error_m},
            {"file_bytes", s.file_bytes},
            {"geometry_bytes", s.geometry_bytes},
            {"directory_bytes", s.directory_bytes},
            {"holes", s.voids},
            {"texture_bytes", s.texture_bytes},
            {"seconds_errors", s.seconds_errors},
            {"seconds_textures", s.seconds_textures},
            {"seconds_total", s.seconds_total}};
}

int run_bake(Arguments& a, const CLI::App& app) {
    if (a.inputs.empty()) throw Failure(2, "no height field given; see fjell-bake --help");
    if (a.inputs.size() > 1)
        throw Failure(2, "more than one height field given; make one of them first (gdalbuildvrt mosaic.vrt A B ...)");
    if (a.output.empty()) throw Failure(2, "no output given; add -o OUT.fjell");
    refuse_overwriting({a.output, a.json_path}, {a.inputs[0], a.bake.ramp_path});
    a.bake.tile_log2 = tile_log2(a.tile);
    a.bake.memory_bytes = a.memory_mb << 20;
    a.bake.order = order_named(a.order);
    a.bake.estimate = a.estimate == "max" ? Estimate::max : Estimate::midpoint;
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    bar("read", 0, 1);
    Dem dem = read_dem(a.inputs[0], a.read.options(app, a.memory_mb));
    bar("read", 1, 1);
    a.bake.progress = std::ref(bar);
    const BakeSummary s = bake(std::move(dem), a.bake, a.output);
    summary.write(summary_json(s));
    if (a.quiet) return 0;
    fmt::print("{}: {} x {} samples in {} x {} tiles of {} cells, quantum {:.4g} m, largest error {:.1f} m\n", a.output,
               s.columns, s.rows, s.tree.tiles_x, s.tree.tiles_y, s.tree.side(), s.quantum_m, s.max_error_m);
    const double samples = static_cast<double>(s.columns) * s.rows;
    fmt::print("{:.1f} MB ({:.2f} bytes a sample of geometry) in {:.1f} s ({:.1f} M samples/s; errors {:.1f} s)\n",
               static_cast<double>(s.file_bytes) / 1e6, static_cast<double>(s.geometry_bytes) / samples,
               s.seconds_total, samples / s.seconds_total / 1e6, s.seconds_errors);
    return 0;
}

json info_json(const LoadedPack& loaded) {
    const PackHeader& h = loaded.pack.header;
    return {{"version", h.version},
            {"columns", h.columns},
            {"rows", h.rows},
            {"tiles", {h.tiles_x, h.tiles_y}},
            {"tile_cells", 1u << h.tile_log2},
            {"order", order_name(h.order)},
            {"estimate", h.estimate == Estimate::max ? "max" : "midpoint"},
            {"nesting", h.nesting},
            {"spacing_m", {h.spacing_m[0], h.spacing_m[1]}},
            {"origin_m", {h.origin_m[0], h.origin_m[1]}},
            {"crs", loaded.crs.empty() ? json() : json(loaded.crs)},
            {"height_m", {h.min_m, h.max_m}},
            {"quantum_m", h.quantum_m},
            {"holes", h.voids},
            {"pages_per_tile", loaded.pack.pages().pages_per_tile()},
            {"max_error_m", h.max_error_m},
            {"colour_texels", h.colour_log2 ? 1u << h.colour_log2 : 0},
            {"normal_texels", h.normal_log2 ? 1u << h.normal_log2 : 0},
            {"chunks", h.directory_count},
            {"file_bytes", h.file_bytes},
            {"pack_hash", fmt::format("{:016x}", h.directory_hash)},
            {"required_bytes", terrain_bytes(h)}};
}

int run_info(const Arguments& a) {
    refuse_overwriting({a.picture_path}, {a.pack});
    std::optional<AtomicFile> picture; // opened before the work
    if (!a.picture_path.empty()) picture.emplace(a.picture_path);
    const LoadedPack loaded = load_pack(a.pack, picture ? LoadTerrain::yes : LoadTerrain::no);
    if (picture) write_png(make_picture(loaded.terrain, a.picture), *picture);
    const json info = info_json(loaded);
    if (a.info_json) {
        fmt::print("{}\n", info.dump(2));
        return 0;
    }
    for (const auto& [key, value] : info.items()) {
        if (key == "crs" && value.is_string())
            fmt::print("{:<16} {:.60}\n", key, value.get<std::string>());
        else
            fmt::print("{:<16} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
    }
    return 0;
}

int run_verify(const Arguments& a, const CLI::App& app) {
    const LoadedPack loaded = load_pack(a.pack, LoadTerrain::yes);
    std::optional<Dem> against;
    if (!a.against.empty()) against = read_dem(a.against, a.verify_read.options(app, a.memory_mb));
    VerifyReport r = verify(loaded.terrain, against ? &*against : nullptr);
    r.chunks = check_all_chunks(loaded);
    fmt::print("{} vertices: {} nesting, {} sphere, {} border, {} rim violations\n", r.vertices, r.nesting_violations,
               r.sphere_violations, r.border_mismatches, r.rim_violations);
    fmt::print("{} chunks: checksums hold\n", r.chunks);
    for (const int axis : {0, 1})
        if (against && std::abs(against->spacing_m[axis] / loaded.pack.header.spacing_m[axis] - 1) > 1e-9)
            throw Failure(
                1, fmt::format("{}: its samples are {} m apart, the pack's {} m; give the --spacing it was baked with",
                               a.against, against->spacing_m[axis], loaded.pack.header.spacing_m[axis]));
    if (against) fmt::print("heights against {}: {} off by more than half a quantum\n", a.against, r.height_mismatches);
    if (r.true_error_checked)
        fmt::print("{} comparisons of samples with triangles: {} above the vertex' error\n", r.samples_compared,
                   r.true_error_violations);
    else
        fmt::print("true error: not promised by the mid-point estimate, not checked\n");
    if (!r.ok()) throw Failure(1, fmt::format("{}: {}; bake it again", a.pack, r.first));
    fmt::print("ok\n");
    return 0;
}

int run_synth(const Arguments& a) {
    refuse_overwriting({a.dem_out}, {a.recipe});
    if (!a.dem_out.ends_with(".tif") && !a.dem_out.ends_with(".tiff"))
        throw Failure(
            2, fmt::format("{}: height fields are written as GeoTIFF; give a name that ends in .tif", a.dem_out));
    write_dem(synthesise(a.recipe), a.dem_out);
    return 0;
}

struct Commands {
    CLI::App* info;
    CLI::App* verify;
    CLI::App* synth;
};

Commands declare(CLI::App& app, Arguments& a) {
    app.set_version_flag("--version", fmt::format("fjell-bake, pack version {}", pack_version));
    app.add_option("IN", a.inputs, "the height field: GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, ...");
    app.add_option("-o,--output", a.output, "the pack to write");
    app.add_option("--tile", a.tile, "cells a side of a tile, a power of two, or auto");
    app.add_option("--estimate", a.estimate, "world-space error: max (true, default) or midpoint")
        ->check(CLI::IsMember({"max", "midpoint"}));
    app.add_option("--nesting", a.bake.nesting, "mu: how much larger a parent's error is, 0.001 to 1 (default 0.05)");
    app.add_option("--order", a.order, "how vertices lie in pages: planar (default), hz (hierarchical Z) or linear")
        ->check(CLI::IsMember({"planar", "hz", "linear"}));
    app.add_option("--quantum", a.bake.quantum_m, "the step of stored heights in metres (default: the source's own)")
        ->check(CLI::PositiveNumber);
    app.add_option("--texture", a.bake.texture_paths, "an image over the whole height field");
    app.add_option("--ramp", a.bake.ramp_path, "colours by height (JSON, content/ramps)");
    app.add_option("--threads", a.bake.threads, "0: all cores")->check(CLI::Range(0, 1024));
    app.add_option("--memory", a.memory_mb, "MB the bake may use; larger height fields are refused")
        ->check(CLI::Range(16, 1 << 24));
    app.add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    app.add_flag("--quiet", a.quiet, "no progress, no summary");
    a.read.add_to(app);

    Commands c{};
    c.info = app.add_subcommand("info", "what a pack holds");
    c.info->add_option("PACK", a.pack)->required();
    c.info->add_flag("--json", a.info_json);
    auto* const picture =
        c.info->add_option("--picture", a.picture_path, "a PNG of its relief, errors, holes and tiles")
            ->check([](const std::string& name) { return std::string(name.empty() ? "give a file name" : ""); });
    c.info->add_option("--picture-size", a.picture.longest_px, "pixels of the terrain's longest side (default 1024)")
        ->check(CLI::Range(min_picture_px, max_picture_px))
        ->needs(picture);
    c.verify = app.add_subcommand("verify", "check a pack's promises over every vertex and sample");
    c.verify->add_option("PACK", a.pack)->required();
    c.verify->add_option("--against", a.against, "the height field it was baked from (give the same read options)");
    a.verify_read.add_to(*c.verify);
    c.synth = app.add_subcommand("synth", "make a height field from a recipe");
    c.synth->add_option("RECIPE", a.recipe)->required();
    c.synth->add_option("-o,--output", a.dem_out, "the GeoTIFF to write")->required();
    app.require_subcommand(0, 1);
    return c;
}

int run(int argc, char** argv) {
    Arguments a;
    CLI::App app{"Bakes a height field into a Fjell pack."};
    const Commands commands = declare(app, a);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& e) {
        return app.exit(e); // --help, --version
    } catch (const CLI::ParseError& e) {
        throw Failure(2, fmt::format("{}; see fjell-bake --help", e.what()));
    }
    const bool other = commands.info->parsed() || commands.verify->parsed() || commands.synth->parsed();
    if (other && (!a.inputs.empty() || !a.output.empty()))
        throw Failure(2, "info, verify and synth bake nothing; leave out the height field and -o, or the command");
    catch_interrupts();
    if (commands.info->parsed()) return run_info(a);
    if (commands.verify->parsed()) return run_verify(a, *commands.verify);
    if (commands.synth->parsed()) return run_synth(a);
    return run_bake(a, app);
}

} // namespace

int main(int argc, char** argv) {
    return run_tool("fjell-bake", [&] { return run(argc, argv); });
}
