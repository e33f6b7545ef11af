// fjell-bake: IN -o OUT.fjell, apply, info, verify, heights, mesh, tiles, simulate, split, join, synth, materials,
// journal, rebase, roads, rivers, locks. Exit codes: 0 done, 1 the input is at fault, 2 usage, 3 the machine is.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <malloc.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/bake/bake.h"
#include "baker/bake/inputs.h"
#include "baker/bake/recipe.h"
#include "baker/check/picture.h"
#include "baker/check/second_reading.h"
#include "baker/check/verify.h"
#include "baker/check/verify_maps.h"
#include "baker/cli/arguments.h"
#include "baker/cli/reports.h"
#include "baker/cli/shards.h"
#include "baker/cli/summary.h"
#include "baker/georeference/crs_label.h"
#include "baker/georeference/open_source.h"
#include "baker/materials/encode.h"
#include "baker/outlets/pack_map.h"
#include "baker/pack/join.h"
#include "baker/pack/write_set.h"
#include "baker/read/pack_source.h"
#include "baker/synth/synth.h"
#include "baker/synth/write_dem.h"
#include "fjell/io/journal.h"
#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"
#include "io/command_line.h"
#include "io/file.h"
#include "io/json.h"
#include "io/set_file.h"
#include "shared/order.h"

namespace {

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::io;
using nlohmann::json;

void save_recipe(const Recipe& recipe, const std::string& path, AtomicFile& file) {
    const std::string text = recipe_text(for_file(recipe, path));
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

int run_bake(const Arguments& a) {
    const Recipe recipe = complete(a.given, a.recipe_path);
    if (recipe.inputs.empty()) throw Failure(2, "no height field given; see fjell-bake --help");
    if (!recipe.output) throw Failure(2, "no output given; add -o OUT.fjell");
    const std::string& output = *recipe.output;
    BakeOptions options = bake_options(recipe);
    std::vector<std::string> outputs = places_written(output);
    outputs.push_back(a.json_path);
    refuse_overwriting(outputs, {a.recipe_path});
    outputs.push_back(a.save_recipe_path); // which may be the one that the recipe came from
    refuse_overwriting(outputs, files_read(recipe));
    std::optional<AtomicFile> saved; // opened before the work, like the summary
    if (!a.save_recipe_path.empty()) saved.emplace(a.save_recipe_path);
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    options.threads = a.threads;
    options.memory_bytes = std::uint64_t{a.memory_mb} << 20;
    options.checkpoint_s = a.checkpoint_s;
    options.progress = std::ref(bar);
    limit_gdal_cache(options.memory_bytes / 16);
    const BakeSummary s = bake(*open_inputs(recipe), options, output);
    if (saved) save_recipe(recipe, a.save_recipe_path, *saved);
    summary.write(summary_json(s));
    if (a.quiet || a.json_path == "-") return 0;
    print_summary(s, output);
    if (is_pack(recipe) && !recipe.locks)
        if (const auto notes = read_notes(PackFile(recipe.inputs[0])); notes && !notes->locks.empty())
            fmt::print("{} has locks, and the new pack none; give --locks again to keep them\n", recipe.inputs[0]);
    return 0;
}

// What a pack's header says of the options that it was baked with, where none are given.
void take_options(const PackHeader& h, Recipe& r) {
    const auto take = [](std::optional<std::string>& to, const std::string& word) {
        if (!to) to = word;
    };
    take(r.tile, std::to_string(1u << h.tile_log2));
    constexpr const char* orders[] = {"planar", "hz", "linear"};
    take(r.order, orders[static_cast<std::size_t>(h.order)]);
    take(r.estimate, h.estimate == ErrorEstimate::max ? "max" : "midpoint");
    if (!r.nesting) r.nesting = std::stod(fmt::format("{}", h.nesting));
    const std::uint32_t half = h.tile_log2 > 0 ? h.tile_log2 - 1 : 0;
    take(r.horizons, h.horizon_log2 == 0 ? "none" : h.horizon_log2 >= half ? "half" : "quarter");
}

int run_apply(Arguments a) {
    a.given.inputs = {a.pack};
    if (!is_pack(a.given))
        throw Failure(1, fmt::format("{}: is no pack; give the pack that the journal belongs to", a.pack));
    if (!a.given.edits) a.given.edits = journal_path(a.pack);
    take_options(PackFile(a.pack).pack().header, a.given);
    return run_bake(a);
}

// As its bake said it.
std::string description_of(const PackFile& file) {
    const PackHeader& h = file.pack().header;
    BakeSummary s;
    s.columns = static_cast<std::int32_t>(h.columns);
    s.rows = static_cast<std::int32_t>(h.rows);
    std::copy_n(h.spacing_m, 2, s.spacing_m);
    s.min_m = h.min_m, s.max_m = h.max_m;
    s.voids = h.voids;
    s.crs_wkt = file.crs();
    const std::optional<PackNotes> notes = read_notes(file);
    if (notes) s.source = notes->source, s.images = notes->images, s.locks = notes->locks;
    return describe(s, notes.has_value());
}

void print_journal(const json& j) { // of info
    if (j.is_null()) return;
    std::string says = j.value("problem", "");
    if (says.empty()) {
        std::size_t stamps = 0;
        for (const json& layer : j["layers"]) stamps += layer["stamps"].get<std::size_t>();
        says = fmt::format("{}: {} edit layers, {} stamps, {} bytes; {}", j["path"].get<std::string>(),
                           j["layers"].size(), stamps, j["bytes"].get<std::uint64_t>(),
                           j["of_this_pack"].get<bool>() ? "of this pack"
                                                         : "of another pack, or of this one before it was baked anew: "
                                                           "fjell-bake rebase carries it over");
    }
    fmt::print("{:<16} {}\n", "journal", says);
}

int run_info(Arguments a) {
    if (a.pack.empty() && a.info_json != "-") a.pack = std::exchange(a.info_json, "-"); // info --json PACK
    if (a.pack.empty()) throw Failure(2, "no pack given; see fjell-bake info --help");
    refuse_overwriting({a.picture_path, a.info_json}, files_of_pack(a.pack));
    std::optional<AtomicFile> picture; // opened before the work
    if (!a.picture_path.empty()) picture.emplace(a.picture_path);
    const PackFile file(a.pack); // header, directory, corners and CRS, however large it is
    if (picture) write_png(make_picture(load_pack(a.pack, LoadTerrain::yes).terrain, a.picture), *picture);
    const json info = info_json(file);
    if (!a.info_json.empty()) {
        JsonOutput(a.info_json).write(info);
        return 0;
    }
    fmt::print("{}", description_of(file));
    for (const auto& [key, value] : info.items()) {
        if (key == "journal")
            print_journal(value);
        else if (key == "crs" && value.is_string())
            fmt::print("{:<16} {:.60}...\n", key, value.get<std::string>()); // all of it: --json
        else
            fmt::print("{:<16} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
    }
    return 0;
}

void print_verify(const VerifyReport& r, const MapsReport& maps, const std::vector<std::string>& against) {
    fmt::print("{} vertices: {} nesting, {} sphere, {} border, {} rim, {} page bound violations\n", r.vertices,
               r.nesting_violations, r.sphere_violations, r.border_mismatches, r.rim_violations, r.bound_violations);
    fmt::print("{} chunks: all checksums agree\n", r.chunks);
    fmt::print("{} texels, {} on borders of tiles: {} mip, {} border, {} length, {} weight violations\n", maps.texels,
               maps.border_texels, maps.mip_violations, maps.border_violations, maps.length_violations,
               maps.weight_violations);
    if (!against.empty())
        fmt::print("heights against {}: {} off by more than half a quantum\n", fmt::join(against, " "),
                   r.height_mismatches);
    if (r.true_error_checked)
        fmt::print("{} comparisons of samples with triangles: {} above the vertex' error\n", r.samples_compared,
                   r.true_error_violations);
    else
        fmt::print("true error: not checked, because the mid-point estimate promises none\n");
}

int run_verify(const Arguments& a) {
    const Recipe source = complete(a.against, a.against_recipe_path);
    std::vector<std::string> inputs = source.inputs;
    for (const std::string& file : files_of_pack(a.pack)) inputs.push_back(file);
    inputs.push_back(a.against_recipe_path);
    refuse_overwriting({a.verify_json_path}, inputs);
    JsonOutput report(a.verify_json_path);
    const PackCheck check = check_pack(a.pack, source);
    const bool prints = !a.quiet && a.verify_json_path != "-";
    report.write(check_json(check));
    if (prints) print_verify(check.heights, check.maps, check.source.inputs);
    if (prints && !check.again.account.empty()) fmt::print("as GDAL alone reads it: {}\n", check.again.account);
    if (const std::string wrong = verdict(check, a.pack); !wrong.empty()) throw Failure(1, wrong);
    if (prints) fmt::print("ok\n");
    return 0;
}

void require_tif(const std::string& path) {
    if (!path.ends_with(".tif") && !path.ends_with(".tiff"))
        throw Failure(2, fmt::format("{}: height fields are written as GeoTIFF; give a name that ends in .tif", path));
}

json tiles_json(const TilesSummary& s) {
    json levels = json::array();
    for (const LevelSummary& l : s.levels)
        levels.push_back({{"level", l.level},
                          {"tiles", l.tiles},
                          {"vertices", l.vertices},
                          {"triangles", l.triangles},
                          {"bytes", l.bytes},
                          {"error_m", l.error_m},
                          {"assumed_error_m", l.assumed_error_m},
                          {"tiles_above", l.above}});
    return {{"levels", levels}, {"resumed", s.resumed}};
}

void print_tiles(const TilesSummary& s, const std::string& folder) {
    if (s.resumed) fmt::print("went on from an earlier run\n");
    const bool pictures = s.levels.front().assumed_error_m == 0;
    fmt::print("level    tiles {}     MB  error m {}\n", pictures ? "" : " triangles ", pictures ? "" : " assumed m");
    for (const LevelSummary& l : s.levels)
        if (pictures)
            fmt::print("{:5} {:8} {:7.2f} {:8.2f}\n", l.level, l.tiles, static_cast<double>(l.bytes) / 1e6, l.error_m);
        else
            fmt::print("{:5} {:8} {:10} {:7.2f} {:8.2f} {:10.2f}\n", l.level, l.tiles, l.triangles,
                       static_cast<double>(l.bytes) / 1e6, l.error_m, l.assumed_error_m);
    for (const LevelSummary& l : s.levels)
        if (l.above > 0)
            fmt::print(
                "level {}: {} tiles have cliffs that no mesh of their grid follows: their errors are larger than "
                "viewers assume\n",
                l.level, l.above);
    fmt::print("wrote {}\n", folder);
}

int run_tiles(Arguments a) {
    refuse_overwriting(
        {archive_of(a.tiles_folder) == Archive::folder ? a.tiles_folder + "/" : a.tiles_folder, a.json_path},
        files_of_pack(a.pack));
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    a.tiles.threads = a.threads;
    a.tiles.memory_bytes = std::uint64_t{a.memory_mb} << 20;
    a.tiles.progress = std::ref(bar);
    a.tiles.maps_of = a.pack;
    a.tiles.colours = a.colours;
    a.tiles.water =
        a.water && a.tiles.format == TilesFormat::quantized_mesh && PackMap::has(a.pack, PackMap::Kind::water);
    const TilesSummary s = write_tiles(PackSource(a.pack), a.pack, a.tiles, a.tiles_folder);
    summary.write(tiles_json(s));
    if (!a.quiet && a.json_path != "-") print_tiles(s, a.tiles_folder);
    return 0;
}

int run_heights(Arguments a) {
    refuse_overwriting(places_written(a.dem_path), files_read(a.ground));
    const bool tif = a.dem_path.ends_with(".tif") || a.dem_path.ends_with(".tiff");
    if (tif && a.heights.level == 0 && a.heights.tile_side == 0) { // of any size
        write_dem(*open_inputs(a.ground), a.dem_path, DemForm::plain, a.threads);
        return 0;
    }
    ProgressBar bar(a.quiet);
    a.heights.threads = a.threads;
    a.heights.progress = std::ref(bar);
    const HeightFilesSummary s = write_height_files(*open_inputs(a.ground), a.heights, a.dem_path);
    if (a.quiet) return 0;
    fmt::print("{}: {} x {} heights{}, {} x {} m apart\n", a.dem_path, s.columns, s.rows,
               a.heights.tile_side > 0 ? fmt::format(" in each of {} x {} tiles", s.tiles_x, s.tiles_y) : "",
               s.spacing_m[0], s.spacing_m[1]);
    if (s.sixteen_bits)
        fmt::print("a height is {} m + {} m * number; {} says so too\n", s.offset_m, s.scale_m, s.files.back());
    if (s.holes_filled > 0) fmt::print("{} samples without a height were filled\n", s.holes_filled);
    fmt::print("no sample is farther than {:.6g} m from the surface through them\n", s.error_m);
    return 0;
}

int run_mesh(Arguments a) {
    if (a.mesh.max_triangles.has_value() == a.mesh_error_m.has_value())
        throw Failure(2, "mesh needs --max-error-m or --max-triangles, one of them");
    a.mesh.max_error_m = a.mesh_error_m.value_or(0);
    std::vector<std::string> read = files_read(a.ground);
    if (!a.mesh.polygon.empty()) read.push_back(a.mesh.polygon);
    refuse_overwriting({a.mesh_path, a.json_path}, read);
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    a.mesh.write = !a.dry_run;
    a.mesh.threads = a.threads;
    a.mesh.progress = std::ref(bar);
    if ((a.colours || a.mesh.occlusion) && !is_pack(a.ground))
        throw Failure(2, fmt::format("--{} takes a pack's; bake the height field first, or leave it out",
                                     a.colours ? "colours" : "occlusion"));
    a.mesh.colours = a.colours;
    if (is_pack(a.ground)) a.mesh.maps_of = a.ground.inputs[0];
    const MeshFileSummary s = write_mesh_file(*open_inputs(a.ground), a.mesh, a.mesh_path);
    summary.write({{"columns", s.columns},
                   {"rows", s.rows},
                   {"vertices", s.vertices},
                   {"triangles", s.triangles},
                   {"ground_triangles", s.ground_triangles},
                   {"bytes", s.bytes},
                   {"holes", s.holes},
                   {"left_out", s.left_out},
                   {"max_error_m", s.max_error_m},
                   {"true_error_m", s.true_error_m},
                   {"mesh_s", s.mesh_s}});
    if (a.quiet || a.json_path == "-") return 0;
    fmt::print("{}: {}{} triangles, no sample farther than {:.6g} m from them ({:.6g} m allowed), {:.2f} MB\n",
               a.mesh_path, a.dry_run ? "not written; " : "", s.triangles, s.true_error_m, s.max_error_m,
               static_cast<double>(s.bytes) / 1e6);
    if (s.holes > 0) fmt::print("{} of {} samples had no height\n", s.holes, std::int64_t{s.columns} * s.rows);
    if (s.left_out > 0) fmt::print("{} samples lie outside of {}\n", s.left_out, a.mesh.polygon);
    return 0;
}

int run_simulate(const Arguments& a) {
    refuse_overwriting({a.simulate_folder + "/", a.json_path}, files_read(a.given));
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    SimulateOptions options = a.simulate;
    for (std::size_t i = 0; i < std::size(simulator_names); ++i)
        if (a.simulator == simulator_names[i]) options.simulator = static_cast<Simulator>(i);
    options.threads = a.threads;
    options.progress = std::ref(bar);
    const SimulateSummary s = simulate(*open_inputs(a.given), options, a.simulate_folder);
    summary.write(parse_json(read_text(a.simulate_folder + "/ground.json"), "ground.json"));
    if (a.quiet || a.json_path == "-") return 0;
    fmt::print("{}: {} x {} samples, heights {:.6g} to {:.6g} m\n", a.simulate_folder, s.columns, s.rows, s.min_m,
               s.max_m);
    if (options.simulator == Simulator::mujoco)
        fmt::print("terrain.hfield is {:.3g} m off Fjell's surface at most, where MuJoCo's diagonals are others\n",
                   s.diagonal_error_m);
    else
        fmt::print("terrain.obj: {} triangles, {:.3g} m off a sample at most{}\n", s.triangles, s.true_error_m,
                   options.area ? fmt::format(", {:.3g} m within the area", s.area_error_m) : "");
    return 0;
}

int run_split(const Arguments& a) {
    refuse_overwriting({a.set_folder + "/"}, {a.pack});
    ProgressBar bar(a.quiet);
    const SetSummary s = split_pack(a.pack, a.set_folder, a.packs.value_or(SetGrid{}),
                                    [&](std::uint64_t done, std::uint64_t total) { bar("split", done, total); });
    if (!a.quiet) print_set(s, a.set_folder);
    return 0;
}

int run_join(const Arguments& a) {
    const JoinSummary s = join_packs(a.set_folder);
    if (a.quiet) return 0;
    print_set(s.set, a.set_folder);
    fmt::print("{} vertices where packs meet: heights, holes, errors and radii agree; {:.1f} MB of pages were read\n",
               s.borders.vertices, static_cast<double>(s.borders.bytes_read) / 1e6);
    return 0;
}

int run_synth(const Arguments& a) {
    refuse_overwriting(places_written(a.dem_path), {a.terrain_path});
    require_tif(a.dem_path);
    ProgressBar bar(a.quiet);
    write_dem(*open_synth(a.terrain_path), a.dem_path, DemForm::compact, 0, std::ref(bar));
    return 0;
}

int run_materials(const Arguments& a) {
    refuse_overwriting({a.materials_path}, {a.recipes_path});
    bake_materials(a.recipes_path, a.texels, a.threads, a.materials_path, a.textures_folder);
    return 0;
}

int run(int argc, char** argv) {
    Arguments a;
    CLI::App app{"Bakes a height field into a Fjell pack.", "fjell-bake"};
    const Commands commands = declare_arguments(app, a);
    if (!io::parse_command_line(app, argc, argv, "fjell-bake")) return 0;
    const bool other =
        commands.info->parsed() || commands.verify->parsed() || commands.heights->parsed() || commands.mesh->parsed() ||
        commands.tiles->parsed() || commands.split->parsed() || commands.join->parsed() || commands.synth->parsed() ||
        commands.materials->parsed() || commands.journals.journal->parsed() || commands.journals.rebase->parsed() ||
        commands.vectors.roads->parsed() || commands.vectors.rivers->parsed() || commands.vectors.locks->parsed();
    if (other && (!a.given.inputs.empty() || a.given.output))
        throw Failure(2, "info, verify, heights, mesh, tiles, split, join, synth, materials, journal, rebase, roads, "
                         "rivers and locks bake nothing; leave out the height field and -o, or the command");
    catch_interrupts();
    if (commands.info->parsed()) return run_info(a);
    if (commands.apply->parsed()) return run_apply(a);
    if (commands.verify->parsed()) return run_verify(a);
    if (commands.heights->parsed()) return run_heights(a);
    if (commands.tiles->parsed()) return run_tiles(a);
    if (commands.mesh->parsed()) return run_mesh(a);
    if (commands.simulate->parsed()) return run_simulate(a);
    if (commands.split->parsed()) return run_split(a);
    if (commands.join->parsed()) return run_join(a);
    if (commands.synth->parsed()) return run_synth(a);
    if (commands.materials->parsed()) return run_materials(a);
    if (commands.journals.journal->parsed()) return run_journal(a.journals);
    if (commands.journals.rebase->parsed()) return run_rebase(a.journals);
    if (commands.vectors.roads->parsed()) return run_vectors(a.vectors, LineKind::road);
    if (commands.vectors.rivers->parsed()) return run_vectors(a.vectors, LineKind::river);
    if (commands.vectors.locks->parsed()) return run_locks(a.vectors);
    if (commands.plan->parsed()) return run_plan(a);
    if (commands.shard->parsed()) return run_shard(a);
    if (commands.launch->parsed()) return run_launch(a);
    if (commands.merge->parsed()) return run_merge(a);
    return run_bake(a);
}

} // namespace

int main(int argc, char** argv) {
    // The same buffers again and again: handing each back to the system would clear its pages every time. Large ones
    // are handed back, or threads would hold on to each other's share of the memory.
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
    mallopt(M_TRIM_THRESHOLD, 8 << 20);
    return run_tool("fjell-bake", [&] { return run(argc, argv); });
}
