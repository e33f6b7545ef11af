// Everything that decides what a pack holds, as a command line or a file says it.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/georeference/open_source.h"

namespace fjell::baker {

// Options of fjell-bake by their names (--zscale is zscale); what is not given has its default. How a bake goes about
// it (threads, memory, progress) is no part of it.
struct Recipe {
    std::vector<std::string> inputs, texture;
    std::optional<std::string> output, ramp, edits, coarse, locks;
    std::optional<std::string> nodata, crs, encoding, tile, estimate, order, horizons, layers, splat, size, band,
        vertical_unit, texture_bands, room_for_holes, room_for_locks;
    std::optional<double> spacing, zscale, zoffset, nesting, quantum, lock_error, coarse_detail;
    std::optional<std::array<double, 4>> bbox; // west, south, east, north
    std::optional<DeclaredVoids> voids;        // key "void"
    friend bool operator==(const Recipe&, const Recipe&) = default;
};

// An option: its name on a command line (--name) and in a file, and all that either, or a form, has to know of it.
struct RecipeKey {
    // What it says: names of files; what the pack is; how files become heights; what then becomes of these.
    enum class Of { files, pack, reading, edits };
    using Member = std::variant<std::vector<std::string> Recipe::*, std::optional<std::string> Recipe::*,
                                std::optional<double> Recipe::*, std::optional<std::array<double, 4>> Recipe::*,
                                std::optional<DeclaredVoids> Recipe::*>;
    const char* name = nullptr;
    Of of = Of::pack;
    Member member;
    const char* about = nullptr;                             // what it is, its unit and default: one paragraph
    std::vector<std::string> words = {};                     // that it takes; empty: any
    bool path = false;                                       // a file's name
    double least = -std::numeric_limits<double>::infinity(); // of a number
    double most = std::numeric_limits<double>::infinity();
    const char* old_name = nullptr; // before 0.3; read until 0.4
};
// In the order in which help and files have them.
[[nodiscard]] const std::vector<RecipeKey>& recipe_keys();
// Throws std::logic_error: there is none.
[[nodiscard]] const RecipeKey& recipe_key(const std::string& name);

// A JSON object whose keys are the options above; unknown keys, wrong types and words that no option knows are refused.
// name: for messages. renamed: gets a line for each key under its old name. Throws Failure 1, one line with the key.
// O(text).
[[nodiscard]] Recipe parse_recipe(const std::string& text, const std::string& name,
                                  std::vector<std::string>* renamed = nullptr);
// "--control is called --splat now, and read by its old name until 0.4". before: an option with its dashes, or a key.
[[nodiscard]] std::string renamed_line(const RecipeKey& key, const std::string& before);
[[nodiscard]] std::string recipe_text(const Recipe& recipe);

// A file's; relative paths in it start at its folder. Throws Failure.
[[nodiscard]] Recipe load_recipe(const std::string& path, std::vector<std::string>* renamed = nullptr);
// As it is to be written to a file of this name: relative paths, which start at the working folder, become relative to
// the file's folder. Absolute ones and names that GDAL gives a meaning (/vsizip/..., NETCDF:...) stay as they are.
[[nodiscard]] Recipe for_file(Recipe recipe, const std::string& path);
// What is given wins; the rest is taken from below.
[[nodiscard]] Recipe merged(Recipe given, const Recipe& below);

// Only what says how files become heights: neither names of files nor options of the pack. For a pack's notes.
[[nodiscard]] Recipe reading_part(Recipe recipe);

// Throw Failure 2 for words and numbers out of range.
[[nodiscard]] ReadOptions read_options(const Recipe& recipe);
[[nodiscard]] BakeOptions bake_options(const Recipe& recipe);

// Its one input is a pack, or a pack set's folder.
[[nodiscard]] bool is_pack(const Recipe& recipe);

// Every file that its bake reads, as far as files are there: heights and images with what lies beside and behind them,
// the ramp and the stamps. Throws Failure 1 for one that cannot be opened.
[[nodiscard]] std::vector<std::string> files_read(const Recipe& recipe);
// Where its bake writes: the pack, and the work folder with all that is in it, as refuse_overwriting() wants them.
[[nodiscard]] std::vector<std::string> places_written(const std::string& pack_path);

// "WEST,SOUTH,EAST,NORTH" to four numbers. Throws Failure 2.
[[nodiscard]] std::array<double, 4> parse_bbox(const std::string& text);
// "COLUMNSxROWS", each from 2 to 2^30. Throws Failure 2.
[[nodiscard]] std::array<int, 2> parse_size(const std::string& text);
// "-9999", "none" or several with commas, added to what there is. Throws Failure 2.
void parse_voids(const std::string& text, std::optional<DeclaredVoids>& to);

} // namespace fjell::baker
