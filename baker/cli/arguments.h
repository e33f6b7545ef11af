// What fjell-bake is told.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "baker/bake/recipe.h"
#include "baker/check/picture.h"
#include "baker/cli/journals.h"
#include "baker/cli/vectors.h"
#include "baker/outlets/height_files.h"
#include "baker/outlets/mesh_file.h"
#include "baker/outlets/simulate.h"
#include "baker/outlets/tile_archive.h"
#include "baker/outlets/tiles.h"
#include "baker/pack/write_set.h"

namespace fjell::baker {

struct Arguments {
    Recipe given; // bake
    std::string recipe_path, save_recipe_path, json_path;
    int threads = 0;
    std::size_t memory_mb = 512;
    std::optional<double> checkpoint_s;
    bool quiet = false;

    std::string plan_folder, shard, shard_step; // plan, shard, merge
    int shards = 0;
    bool status = false, again = false;
    std::string launcher = "local";
    int at_once = 1;
    bool dry_run = false;

    std::string pack;      // info, verify, heights, tiles
    std::string info_json; // where to; empty: as a table
    std::string picture_path;
    PictureOptions picture;

    Recipe against; // verify: its inputs and read options
    std::string against_recipe_path, verify_json_path;

    std::string set_folder;       // split, join
    std::optional<SetGrid> packs; // split, merge, launch

    std::string terrain_path, dem_path; // synth, heights

    std::string tiles_folder; // tiles
    bool colours = false;     // tiles, mesh
    bool water = true;        // tiles
    TilesOptions tiles;

    Recipe ground;              // mesh, heights: its inputs and read options
    HeightFilesOptions heights; // heights

    std::string mesh_path; // mesh
    std::optional<double> mesh_error_m;
    MeshFileOptions mesh;

    std::string simulate_folder, simulator; // simulate
    SimulateOptions simulate;

    JournalArguments journals; // journal, rebase
    VectorArguments vectors;   // roads, rivers

    std::string recipes_path, materials_path, textures_folder; // materials
    std::uint32_t texels = 512;
};

struct Commands {
    CLI::App* info;
    CLI::App* apply;
    CLI::App* verify;
    CLI::App* heights;
    CLI::App* mesh;
    CLI::App* tiles;
    CLI::App* simulate;
    CLI::App* split;
    CLI::App* join;
    CLI::App* synth;
    CLI::App* materials;
    CLI::App* plan;
    CLI::App* shard;
    CLI::App* launch;
    CLI::App* merge;
    JournalCommands journals;
    VectorCommands vectors;
};

[[nodiscard]] Commands declare_arguments(CLI::App& app, Arguments& arguments);

} // namespace fjell::baker
