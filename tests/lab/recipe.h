// An experiment as a file: what is asked, over which terrain, of which cases, and what is measured of each.
//
// A recipe is a JSON object (content/experiments, docs/experiments.md); its cases are all combinations of its lists.
// Units are part of names. Immutable once read. Failure: io::Failure with exit code 1, one line with the file and the
// key at fault, 3 for a disk that fails.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fjell/pack.h"

namespace fjell::lab {

// How the mesh is found: our two methods, or the leanest recursion (bench/lean_recursion.h), which knows no tiles; and
// for the conclusions "rivals" and "instructions" whatever else rivals/rival.h has.
enum class Way : std::uint8_t {
    recursive,
    incremental,
    lean,
    incremental_morph,
    roam,
    roam_wedgies,
    cdlod,
    cdlod_doubling,
    blocks,
    spheres,
    binary_tree,
    skirted_tiles,
    multi_triangulation,
    progressive_mesh,
    incremental_offscreen // with an offscreen factor of 8
};

// Heights and a camera path over them. One of the two: a landscape for the baker's synthesis, or a file.
struct Site {
    nlohmann::json landscape;                         // null: a file
    std::string file;                                 // below the folder of real height fields
    double spacing_m = 60, zscale = 1, zoffset_m = 0; // of the file
    std::string path;                                 // camera path, from the source's root
    [[nodiscard]] nlohmann::json identity() const;    // what its cases depend on
};

// One flight with one method.
struct Case {
    int tile_cells = 0;
    PageOrder order = PageOrder::planar;
    ErrorEstimate estimate = ErrorEstimate::max;
    Way way = Way::recursive;
    double offscreen_factor = 1; // of the incremental method
    double cells_a_frame = 0;    // straight on; 0: along the site's path
    double error_px = 1;
    int texture_cells = 0; // cells from texel to texel of the colour map; 0: the smallest map, for what is not drawn
    [[nodiscard]] nlohmann::json json() const;
};

// A picture of one measured number over thresholds or speeds.
struct Plot {
    std::string x, y;
};

struct Recipe {
    std::string file, name; // name: the file's without its extension
    std::string title, question;
    std::string conclusion; // which template says what was found: "tilings", "orders", "estimates", "methods",
                            // "rivals", "drawing", "instructions"
    Site site;
    std::vector<int> tile_cells, texture_cells;
    std::vector<PageOrder> orders;
    std::vector<ErrorEstimate> estimates;
    std::vector<Way> ways;
    std::vector<double> offscreen_factors, cells_a_frame, thresholds_px;
    int frames = 840, verify_frames = 0, drawn_frames = 0; // drawn: of pictures, so many of the frames
    double about_s = 1;                                    // what it takes in all, for the estimate before a first run
    double cache_mb = 8;                                   // that page and memory misses are counted with
    // Of rivals: flights in turns with the leanest recursion, and a picture of each mesh, how fine and how large.
    int repetitions = 1, picture_cells = 128;
    double picture_px = 8;
    std::vector<std::string> measures;
    std::vector<std::string> published; // names of series (published.h) for its pictures
    std::vector<Plot> plots;

    [[nodiscard]] bool draws() const { return conclusion == "drawing"; }
    [[nodiscard]] bool counts() const { return conclusion == "instructions"; }
    [[nodiscard]] bool measures_any(std::initializer_list<const char*> names) const;
};

// Everything that can be measured, by its key, with its heading.
struct Measure {
    const char *key, *heading;
};
[[nodiscard]] const std::vector<Measure>& all_measures();
[[nodiscard]] const char* heading_of(const std::string& key); // of a measure or of a field of Case

// real_folder: of real height fields; empty: synthetic terrain instead. quick: with what the recipe says under "quick".
[[nodiscard]] Recipe read_recipe(const std::string& file, const std::string& real_folder, bool quick);
// Of a rival's mesh, in the folder of results.
[[nodiscard]] std::string picture_name(const Recipe& recipe, const Case& c);
[[nodiscard]] std::vector<Case> cases_of(const Recipe& recipe);
// What its number in the store depends on, in one line.
[[nodiscard]] std::string key_of(const Recipe& recipe, const Case& c);

} // namespace fjell::lab
