#include "baker/cli/arguments.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "baker/shard/shard_plan.h"
#include "fjell/io/materials.h"
#include "fjell/pack.h"
#include "io/command_line.h"

namespace fjell::baker {

namespace {

// From a command line: what a key's member takes.
template <typename T>
CLI::Option* add_key(CLI::App& app, const std::string& name, T& to, const RecipeKey& key) {
    CLI::Option* const option = app.add_option(name, to, key.about);
    if (&key != &recipe_key("tile") && !key.words.empty()) option->check(io::one_of(key.words));
    return option;
}
CLI::Option* add_key(CLI::App& app, const std::string& name, std::optional<std::array<double, 4>>& to,
                     const RecipeKey& key) {
    return app.add_option_function<std::string>(
        name, [&to](const std::string& text) { to = parse_bbox(text); }, key.about);
}
CLI::Option* add_key(CLI::App& app, const std::string& name, std::optional<DeclaredVoids>& to, const RecipeKey& key) {
    const auto parse = [&to](const std::vector<std::string>& texts) {
        to.reset();
        for (const std::string& text : texts) parse_voids(text, to);
    };
    return app.add_option_function<std::vector<std::string>>(name, parse, key.about)
        ->type_name("VALUE")
        ->type_size(1)
        ->allow_extra_args(false);
}

// The same by the name that it had: help does not show it, and whoever uses it is told.
void add_old_name(CLI::App& app, CLI::Option& now, Recipe& r, const RecipeKey& key) {
    const std::string before = std::string("--") + key.old_name;
    std::visit([&](const auto member) { return add_key(app, before, r.*member, key); }, key.member)
        ->group("")
        ->each([before, &key, &now](const std::string&) {
            if (now.count() != 0) throw CLI::ExcludesError(before, now.get_name());
            fmt::print(stderr, "fjell-bake: {}\n", renamed_line(key, before));
        });
}

// All that a pack's bytes depend on; or only how files become heights in metres (for verify --against), or that and
// what stamps make of them; or what does not tell of heights.
enum class Options { all, reading, heights, pack };
void add_recipe_options(CLI::App& app, Recipe& r, Options wanted = Options::all) {
    using Of = RecipeKey::Of;
    for (const RecipeKey& key : recipe_keys()) {
        const std::string name = &key == &recipe_key("inputs") ? "IN" : std::string("--") + key.name;
        if (&key == &recipe_key("output") || (wanted == Options::pack && &key == &recipe_key("inputs"))) continue;
        const bool of_heights = key.of == Of::reading || (key.of == Of::edits && wanted != Options::reading);
        if (wanted != Options::all && of_heights == (wanted == Options::pack)) continue;
        CLI::Option* const option =
            std::visit([&](const auto member) { return add_key(app, name, r.*member, key); }, key.member);
        if (key.old_name) add_old_name(app, *option, r, key);
    }
}

void add_how_options(CLI::App& app, Arguments& a) {
    app.add_option("--threads", a.threads, "cores to use; 0 (default): all")->check(io::whole_within(0, 1024));
    app.add_option("--memory", a.memory_mb, "MB the bake may use, whatever the height field's size (default 512)")
        ->check(io::whole_within(128, 1 << 24));
    app.add_flag("--quiet", a.quiet, "no progress, no summary");
}

void declare_bake(CLI::App& app, Arguments& a) {
    add_recipe_options(app, a.given);
    app.add_option("-o,--output", a.given.output, "the pack to write");
    app.add_option("--recipe", a.recipe_path,
                   "take options that are not given here from this file (--save-recipe writes one)");
    app.add_option("--save-recipe", a.save_recipe_path, "record inputs and options in a file, for --recipe");
    add_how_options(app, a);
    app.add_option(
           "--checkpoint", a.checkpoint_s,
           "work in files even if all fits --memory, so that an interrupted bake can be resumed; the files are removed "
           "if an input fails within this many seconds (default 5)")
        ->check(io::within(0, 3600));
    app.add_option("--json", a.json_path, "a summary for scripts; - for standard output");
}

void declare_apply(CLI::App& app, Arguments& a, Commands& c) {
    c.apply = app.add_subcommand("apply", "bake a pack with its journal: what no stamp reaches is the pack's own");
    c.apply->add_option("PACK", a.pack, "the pack")->required();
    c.apply->add_option("JOURNAL", a.given.edits, "its journal, or stamps as JSON (default: PACK.journal)");
    c.apply->add_option("-o,--output", a.given.output, "the pack to write")->required();
    add_recipe_options(*c.apply, a.given, Options::pack);
    add_how_options(*c.apply, a);
    c.apply->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
}

void add_packs_option(CLI::App& command, Arguments& a, const std::string& about) {
    const auto parse = [&a](const std::string& text) {
        const auto number = [](std::string_view digits, std::uint32_t& to) {
            const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), to);
            return error == std::errc{} && end == digits.data() + digits.size() && to >= 1;
        };
        const std::string_view all = text;
        const std::size_t x = std::min(all.find('x'), all.size());
        SetGrid grid;
        if (x == all.size() || !number(all.substr(0, x), grid.packs_x) || !number(all.substr(x + 1), grid.packs_y))
            throw CLI::ValidationError("--packs", "must be two numbers such as 2x3");
        a.packs = grid;
    };
    command.add_option_function<std::string>("--packs", parse, about)->type_name("AxB");
}

constexpr const char* about_pack = "a pack, or the folder of a pack set";
constexpr const char* about_ground = "a pack, or the height field: one file, or several that make a mosaic";
constexpr const char* about_set =
    "write a pack set instead, with so many packs across and down: OUT is its folder; packs without any ground are "
    "left out";

void declare_shards(CLI::App& app, Arguments& a, Commands& c) {
    c.plan = app.add_subcommand("plan", "cut a bake into shards that machines with a shared folder bake apart");
    add_recipe_options(*c.plan, a.given);
    c.plan->add_option("-o,--output", a.plan_folder, "the shared folder to write the plan to");
    c.plan->add_option("--shards", a.shards, "the number of shards")->check(io::whole_within(1, max_shards));
    add_packs_option(*c.plan, a,
                     "plan for a pack set with so many packs across and down; packs without any ground are not baked");
    c.plan->add_option("--recipe", a.recipe_path, "take options that are not given here from this file");
    c.plan->add_flag("--status", a.status, "show which shards have completed which step of the plan in the folder IN");
    c.shard = app.add_subcommand(
        "shard", "run a step of one shard of a plan, or of several: the next step that it has not completed");
    c.shard->add_option("DIR", a.plan_folder, "the plan's folder")->required();
    c.shard->add_option("K/N", a.shard, "the shard, from 1/N to N/N, or several: K-L/N")->required();
    c.shard->add_option("--step", a.shard_step, "run this step: read, means, measure, step1, step2, ...");
    c.shard->add_flag("--again", a.again, "run the step even if it is complete");
    add_how_options(*c.shard, a);
    c.launch = app.add_subcommand("launch", "run all shards of a plan, step by step, and merge them");
    c.launch->add_option("DIR", a.plan_folder, "the plan's folder")->required();
    c.launch->add_option("-o,--output", a.given.output, "the pack to write")->required();
    c.launch
        ->add_option(
            "--with", a.launcher,
            "local: processes on this machine (default); slurm: one job array for each step; mpi: one mpirun for each "
            "step, with the options in FJELL_MPI_OPTIONS")
        ->check(io::one_of({"local", "slurm", "mpi"}));
    c.launch->add_option("--at-once", a.at_once, "local, mpi: processes side by side (default 1)")
        ->check(io::whole_within(1, max_shards));
    c.launch->add_flag("--dry-run", a.dry_run,
                       "only print the commands, and the time, disk and memory that a shard takes");
    add_packs_option(*c.launch, a, about_set);
    add_how_options(*c.launch, a);
    c.merge = app.add_subcommand("merge", "make the pack, or a pack set, from the results of all shards of a plan");
    c.merge->add_option("DIR", a.plan_folder, "the plan's folder")->required();
    c.merge->add_option("-o,--output", a.given.output, "the pack to write")->required();
    add_packs_option(*c.merge, a, about_set);
    c.merge->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    add_how_options(*c.merge, a);
}

void declare_materials(CLI::App& app, Arguments& a, Commands& c) {
    c.materials = app.add_subcommand("materials", "make the textures of near ground from recipes");
    c.materials->add_option("RECIPES", a.recipes_path, "a folder of recipes (content/materials), or one")->required();
    c.materials->add_option("-o,--output", a.materials_path, "the file to write, for fjell-fly --materials")
        ->required();
    c.materials->add_option("--size", a.texels, "texels a side of each, a power of two from 16 to 2048 (default 512)")
        ->check([](const std::string& text) {
            for (std::uint32_t log2 = io::min_material_log2; log2 <= io::max_material_log2; ++log2)
                if (text == std::to_string(1u << log2)) return std::string();
            return std::string("must be a power of two from 16 to 2048");
        });
    c.materials->add_option("--pictures", a.textures_folder,
                            "write each material's colour, height and normal as PNGs into this folder too");
    c.materials->add_option("--threads", a.threads, "cores to use; 0 (default): all")->check(io::whole_within(0, 1024));
}

// What all commands take alike; the summary for scripts where one has any, and a refusal where it has none.
void add_common_options(CLI::App& app, Arguments& a) {
    for (CLI::App* const command : app.get_subcommands([](CLI::App*) { return true; })) {
        if (!command->get_option_no_throw("--quiet"))
            command->add_flag("--quiet", a.quiet, "no progress, no summary: only what is wrong");
        if (command->get_option_no_throw("--json")) continue;
        const std::string why = command->get_name() + " has no summary for scripts; leave --json out";
        command
            ->add_option_function<std::string>(
                "--json", [why](const std::string&) { throw io::Failure(2, why); }, "")
            ->expected(0, 1)
            ->group("");
    }
}

void add_packing_options(CLI::App& command, gltf::GlbPacking& packing) {
    command.add_flag("--quantised", packing.quantised,
                     "glTF: 16 bits a number (KHR_mesh_quantization); the error that is claimed includes the rounding");
    command.add_flag("--meshopt", packing.meshopt,
                     "glTF: compressed (EXT_meshopt_compression), which not all viewers read");
}

void declare_tiles(CLI::App& app, Arguments& a, Commands& c) {
    c.tiles = app.add_subcommand(
        "tiles",
        "write a pack as a pyramid of tiles for globes: quantized-mesh 1.0, as CesiumJS reads it, or 3D Tiles 1.1");
    c.tiles->add_option("PACK", a.pack, about_pack)->required();
    c.tiles
        ->add_option("-o,--output", a.tiles_folder,
                     "the new folder to write: layer.json and z/x/y.terrain, tileset.json and z/x/y.glb, or tiles.json "
                     "and z/x/y.png or .webp; or one file, .mbtiles or .pmtiles")
        ->required();
    c.tiles
        ->add_option_function<std::string>(
            "--format",
            [&a](const std::string& word) {
                a.tiles.format = word == "3dtiles"       ? TilesFormat::tiles_3d
                                 : word == "terrain-rgb" ? TilesFormat::terrain_rgb
                                 : word == "terrarium"   ? TilesFormat::terrarium
                                                         : TilesFormat::quantized_mesh;
            },
            "quantized-mesh (default): terrain of CesiumJS; 3dtiles: glTF tiles; terrain-rgb, terrarium: heights as "
            "pictures, for MapLibre")
        ->check(io::one_of({"quantized-mesh", "3dtiles", "terrain-rgb", "terrarium"}));
    c.tiles
        ->add_option("--tile-px", a.tiles.side_px, "pixels a side of terrain-rgb and terrarium: 256 or 512 (default)")
        ->check(io::one_of({"256", "512"}));
    c.tiles
        ->add_option_function<std::string>(
            "--image", [&a](const std::string& word) { a.tiles.webp = word == "webp"; },
            "how terrain-rgb and terrarium are written: png (default), or webp, smaller; both without loss")
        ->check(io::one_of({"png", "webp"}));
    c.tiles
        ->add_option_function<std::string>(
            "--tiling",
            [&a](const std::string& word) {
                a.tiles.tiling = word == "mercator" ? Tiling::mercator : Tiling::geographic;
            },
            "geographic: EPSG:4326 with two tiles at level 0 (default); mercator: EPSG:3857 with one, as pictures have "
            "it")
        ->check(io::one_of({"geographic", "mercator"}));
    c.tiles
        ->add_option("--max-level", a.tiles.max_level,
                     "the finest level; default: the first whose error is at most a fifth of the samples' spacing")
        ->check(io::whole_within(0, most_tile_level));
    c.tiles->add_flag("!--no-normals", a.tiles.normals, "leave out normals, which viewers need for light");
    c.tiles->add_flag("!--no-gzip", a.tiles.gzip,
                      "leave tiles uncompressed, for servers that do not send Content-Encoding: gzip");
    c.tiles->add_flag("!--no-water-mask", a.water,
                      "quantized-mesh: leave out where water is, which a pack with water in its splat maps knows");
    add_packing_options(*c.tiles, a.tiles.packing);
    c.tiles->add_flag("--implicit", a.tiles.implicit_tree,
                      "3dtiles: an implicit tree, with .subtree files, instead of one that tileset.json spells out");
    c.tiles->add_flag("--colours", a.colours, "3dtiles: the pack's colours as textures");
    add_how_options(*c.tiles, a);
    c.tiles->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
}

void declare_split(CLI::App& app, Arguments& a, Commands& c) {
    c.split = app.add_subcommand("split", "take a pack apart into a pack set, a folder that is opened like one pack");
    c.split->add_option("PACK", a.pack, "the pack")->required();
    c.split->add_option("-o,--output", a.set_folder, "the folder to write")->required();
    add_packs_option(*c.split, a, "packs across and down (default 2x2); packs without any ground are left out");
    c.join = app.add_subcommand("join", "make a pack set of the packs in a folder, if they agree where they meet");
    c.join->add_option("FOLDER", a.set_folder, "the packs' folder; its set.json is written")->required();
}

void declare_heights(CLI::App& app, Arguments& a, Commands& c) {
    c.heights = app.add_subcommand("heights", "write heights as a GeoTIFF, or as files of numbers for engines");
    c.heights->add_option("IN", a.ground.inputs, about_ground)->required();
    c.heights
        ->add_option("-o,--output", a.dem_path,
                     "the file to write: .tif (holes as no-data); .raw or .r16 (16 bits, little-endian) and .png (16 "
                     "bits), with scale and offset in a .json beside it; .exr (floats)")
        ->required();
    c.heights
        ->add_option("--at", a.heights.level,
                     "write every 2^LEVEL-th sample only (default 0: all); the summary says the error")
        ->type_name("LEVEL")
        ->check(io::whole_within(0, 20));
    c.heights
        ->add_option("--tiles", a.heights.tile_side,
                     "write tiles of SIDE x SIDE numbers, which share a row or column with their neighbours, as "
                     "OUT_x<i>_y<j>")
        ->type_name("SIDE")
        ->check(io::whole_within(2, 32769));
    c.heights->add_option("--threads", a.threads, "cores to use; 0 (default): all")->check(io::whole_within(0, 1024));
    add_recipe_options(*c.heights, a.ground, Options::heights);
}

void declare_mesh(CLI::App& app, Arguments& a, Commands& c) {
    c.mesh = app.add_subcommand("mesh", "write a height field or a pack as one mesh, within a vertical error");
    c.mesh->add_option("IN", a.ground.inputs, about_ground)->required();
    c.mesh
        ->add_option("-o,--output", a.mesh_path,
                     "the file to write: .glb and .obj (y up), .ply (z up), or .stl (z up, closed, for printing)")
        ->required();
    c.mesh->add_option("--max-error-m", a.mesh_error_m, "metres that a sample may lie above or below the mesh, at most")
        ->check(io::within(0, 1e6));
    c.mesh
        ->add_option("--max-triangles", a.mesh.max_triangles,
                     "instead: as small an error as so many triangles reach, walls and base of .stl not counted")
        ->check(io::whole_within(2, 2'000'000'000));
    c.mesh
        ->add_option("--base-m", a.mesh.base_m,
                     ".stl: metres from the lowest ground down to the base (default: 1/20 of the longer side)")
        ->check(io::within(0, 1e6));
    add_packing_options(*c.mesh, a.mesh.packing);
    c.mesh->add_flag("--colours", a.colours, ".glb of a pack: its colours as a texture");
    c.mesh->add_flag("--normal-map", a.mesh.normal_map,
                     ".glb: the normals of all samples as a texture, of a height field too");
    c.mesh->add_flag("--occlusion", a.mesh.occlusion,
                     ".glb of a pack with horizon maps: the share of the sky that ground sees, as a texture");
    c.mesh->add_option(
        "--polygon", a.mesh.polygon,
        "only the samples inside of the polygons of this file, which GDAL reads as vectors, e.g. GeoJSON");
    c.mesh->add_flag("--dry-run", a.dry_run, "only say how many triangles and bytes it would be, and the error");
    c.mesh->add_option("--threads", a.threads, "cores to use; 0 (default): all")->check(io::whole_within(0, 1024));
    c.mesh->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    add_recipe_options(*c.mesh, a.ground, Options::heights);
}

void declare_simulate(CLI::App& app, Arguments& a, Commands& c) {
    c.simulate = app.add_subcommand("simulate", "write a height field as ground for a physics engine");
    c.simulate->add_option("IN", a.given.inputs, recipe_key("inputs").about)->required();
    c.simulate->add_option("-o,--output", a.simulate_folder, "the folder to write")->required();
    c.simulate
        ->add_option("--for", a.simulator,
                     "mujoco: a height field and its MJCF; sdf: a model for Gazebo; urdf: a mesh, for Bullet and DART")
        ->required()
        ->check(io::one_of({std::begin(simulator_names), std::end(simulator_names)}));
    c.simulate
        ->add_option("--max-error-m", a.simulate.max_error_m,
                     "metres that the mesh of sdf and urdf may be off a sample (default 0.05)")
        ->check(io::within(0, 1e6));
    const auto area = [&a](const std::vector<double>& numbers) {
        a.simulate.area = {numbers[0], -numbers[1], numbers[2], numbers[3]};
    };
    c.simulate
        ->add_option_function<std::vector<double>>(
            "--area", area,
            "X,Y,RADIUS,GROWTH: --max-error-m holds within RADIUS metres of (X, Y), in the engine's axes; beyond it "
            "the mesh may be off GROWTH metres more for each metre of distance")
        ->delimiter(',')
        ->expected(4)
        ->type_name("X,Y,RADIUS,GROWTH");
    c.simulate->add_option("--threads", a.threads, "cores to use; 0 (default): all")->check(io::whole_within(0, 1024));
    c.simulate->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    add_recipe_options(*c.simulate, a.given, Options::heights);
}

} // namespace

Commands declare_arguments(CLI::App& app, Arguments& a) {
    app.set_version_flag("--version", fmt::format("fjell-bake, pack version {}", pack_version));
    declare_bake(app, a);
    Commands c{};
    c.info = app.add_subcommand("info", "describe a pack");
    c.info->add_option("PACK", a.pack, about_pack); // looked for in what is parsed: it may stand behind --json
    c.info
        ->add_option_function<std::string>(
            "--json", [&a](const std::string& path) { a.info_json = path.empty() ? "-" : path; },
            "write JSON to a file; - (default): to standard output")
        ->expected(0, 1);
    auto* const picture =
        c.info->add_option("--picture", a.picture_path, "a PNG of its relief, errors, holes and tiles")
            ->check([](const std::string& name) { return std::string(name.empty() ? "give a file name" : ""); });
    c.info->add_option("--picture-size", a.picture.longest_px, "pixels of the terrain's longest side (default 1024)")
        ->check(io::whole_within(min_picture_px, max_picture_px))
        ->needs(picture);
    declare_apply(app, a, c);
    c.verify = app.add_subcommand("verify", "check a pack's promises over every vertex and sample");
    c.verify->add_option("PACK", a.pack, about_pack)->required();
    c.verify->add_option(
        "--against", a.against.inputs,
        "the height field it was baked from, one file or several, read with the options in the pack, or "
        "with those given here");
    c.verify->add_option("--recipe", a.against_recipe_path, "the recipe it was baked from, instead of --against");
    c.verify->add_option("--json", a.verify_json_path, "the report for scripts; - for standard output");
    add_recipe_options(*c.verify, a.against, Options::reading);
    declare_heights(app, a, c);
    declare_mesh(app, a, c);
    declare_tiles(app, a, c);
    declare_simulate(app, a, c);
    declare_split(app, a, c);
    c.synth = app.add_subcommand("synth", "make a height field from a recipe");
    c.synth->add_option("RECIPE", a.terrain_path, "a terrain recipe (JSON, content/terrain)")->required();
    c.synth->add_option("-o,--output", a.dem_path, "the GeoTIFF to write")->required();
    declare_materials(app, a, c);
    declare_shards(app, a, c);
    c.journals = declare_journals(app, a.journals);
    c.vectors = declare_vectors(app, a.vectors);
    add_common_options(app, a);
    app.require_subcommand(0, 1);
    return c;
}

} // namespace fjell::baker
