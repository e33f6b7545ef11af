#include "lab/recipe.h"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "baker/synth/synth.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::lab {

namespace {

using nlohmann::json;

// An object that is asked for its keys, and refuses those that nobody asked for.
class Keys {
public:
    Keys(const json& object, std::string file, std::string where = {})
        : object_(object), file_(std::move(file)), where_(std::move(where)) {
        if (!object_.is_object()) throw io::Failure(1, fmt::format("{}: {}must be an object {{ ... }}", file_, where_));
    }
    [[noreturn]] void bad(const std::string& key, const std::string& what) const {
        throw io::Failure(1, fmt::format("{}: {}{}: {}", file_, where_, key, what));
    }
    const json* find(const char* key) {
        known_.insert(key);
        const auto at = object_.find(key);
        return at == object_.end() ? nullptr : &*at;
    }
    const json& need(const char* key) {
        const json* value = find(key);
        if (!value) bad(key, "is missing; give it");
        return *value;
    }
    std::string text(const char* key) {
        const json& value = need(key);
        if (!value.is_string() || value.get<std::string>().empty()) bad(key, "must be text");
        return value.get<std::string>();
    }
    double number(const char* key, double otherwise, double least, double most) {
        const json* value = find(key);
        return value ? checked(key, *value, least, most) : otherwise;
    }
    std::vector<double> numbers(const char* key, std::vector<double> otherwise, double least, double most) {
        const json* value = find(key);
        if (!value) return otherwise;
        std::vector<double> found;
        for (const json& v : list(key, *value)) found.push_back(checked(key, v, least, most));
        return found;
    }
    // Words out of a list; their places in it.
    std::vector<std::size_t> words(const char* key, const std::vector<std::string>& known, bool required) {
        const json* value = find(key);
        if (!value && required) bad(key, fmt::format("is missing; give some of {}", fmt::join(known, ", ")));
        std::vector<std::size_t> found;
        if (!value) return found;
        for (const json& v : list(key, *value)) {
            const auto at = std::find(known.begin(), known.end(), v.is_string() ? v.get<std::string>() : "");
            if (at == known.end()) bad(key, fmt::format("{} is none of {}", v.dump(), fmt::join(known, ", ")));
            found.push_back(static_cast<std::size_t>(at - known.begin()));
        }
        return found;
    }
    const json& list(const char* key, const json& value) const {
        if (!value.is_array() || value.empty()) bad(key, "must be a list with something in it");
        return value;
    }
    void refuse_others() {
        known_.insert("comment");
        for (const auto& [key, value] : object_.items())
            if (!known_.contains(key)) bad(key, "unknown key; remove it");
    }

private:
    double checked(const char* key, const json& value, double least, double most) const {
        const double v = value.is_number() ? value.get<double>() : least - 1;
        if (!(v >= least && v <= most)) bad(key, fmt::format("must be numbers from {} to {}", least, most));
        return v;
    }
    const json& object_;
    std::string file_, where_;
    std::set<std::string> known_;
};

const std::vector<std::string> order_words{"planar", "hz", "linear"}, estimate_words{"true", "midpoint"},
    way_words{"recursive",
              "incremental",
              "lean",
              "incremental-morph",
              "roam",
              "roam-wedgies",
              "cdlod",
              "cdlod-doubling",
              "blocks",
              "spheres",
              "binary-tree",
              "skirted-tiles",
              "multi-triangulation",
              "progressive-mesh",
              "incremental-offscreen"},
    conclusion_words{"tilings", "orders", "estimates", "methods", "rivals", "drawing", "instructions"};

Site site_of(const json& terrain, const std::string& file, const std::string& real_folder) {
    Keys kinds(terrain, file, "terrain.");
    const json& synthetic = kinds.need("synthetic");
    const json* real = kinds.find("real");
    kinds.refuse_others();
    Site site;
    if (real) {
        Keys keys(*real, file, "terrain.real.");
        site.file = keys.text("file");
        site.path = keys.text("path");
        site.spacing_m = keys.number("spacing_m", 60, 1e-3, 1e6);
        site.zscale = keys.number("zscale", 1, -1e6, 1e6);
        site.zoffset_m = keys.number("zoffset_m", 0, -1e6, 1e6);
        keys.refuse_others();
        if (!real_folder.empty() && std::filesystem::exists(real_folder + "/" + site.file)) return site;
    }
    Keys keys(synthetic, file, "terrain.synthetic.");
    site = {};
    site.landscape = keys.need("landscape");
    if (!site.landscape.is_object()) keys.bad("landscape", "must be an object, as in content/terrain");
    try {
        (void)baker::synth_source(site.landscape.dump()); // refuses what is no landscape
    } catch (const io::Failure& e) {
        keys.bad("landscape", e.what());
    }
    site.path = keys.text("path");
    keys.refuse_others();
    return site;
}

std::vector<int> whole(Keys& keys, const char* key, double least, double most, std::vector<double> otherwise = {}) {
    std::vector<int> found;
    for (const double v : keys.numbers(key, std::move(otherwise), least, most)) {
        if (v != static_cast<int>(v)) keys.bad(key, "must be whole numbers");
        found.push_back(static_cast<int>(v));
    }
    if (found.empty()) keys.bad(key, "is missing; give a list");
    return found;
}

std::vector<Plot> plots_of(Keys& keys, const std::string& file, const std::vector<std::string>& measures) {
    std::vector<Plot> plots;
    for (const json& each : keys.list("plots", keys.need("plots"))) {
        Keys plot(each, file, "plots.");
        const Plot p{plot.text("x"), plot.text("y")};
        plot.refuse_others();
        if (p.x != "error_px" && p.x != "cells_a_frame") plot.bad("x", "must be error_px or cells_a_frame");
        if (std::find(measures.begin(), measures.end(), p.y) == measures.end())
            plot.bad("y", p.y + " is not among the recipe's measures; add it there");
        plots.push_back(p);
    }
    return plots;
}

void read_lists(Keys& keys, Recipe& r) {
    r.tile_cells = whole(keys, "tile_cells", 2, 4096);
    for (const int cells : r.tile_cells)
        if (!std::has_single_bit(static_cast<unsigned>(cells))) keys.bad("tile_cells", "must be powers of two");
    r.texture_cells = whole(keys, "texture_cells", 0, 4096, {0});
    for (const int cells : r.texture_cells)
        if (cells != 0 && !std::has_single_bit(static_cast<unsigned>(cells)))
            keys.bad("texture_cells", "must be 0 or powers of two");
    for (const std::size_t i : keys.words("orders", order_words, true)) r.orders.push_back(static_cast<PageOrder>(i));
    for (const std::size_t i : keys.words("estimates", estimate_words, true))
        r.estimates.push_back(static_cast<ErrorEstimate>(i));
    for (const std::size_t i : keys.words("methods", way_words, true)) r.ways.push_back(static_cast<Way>(i));
    const bool linear = std::find(r.orders.begin(), r.orders.end(), PageOrder::linear) != r.orders.end();
    if (linear && std::find(r.ways.begin(), r.ways.end(), Way::incremental) != r.ways.end())
        keys.bad("orders", "the incremental method does not take linear; leave one of them out");
    r.cache_mb = keys.number("cache_mb", r.cache_mb, 0.1, 1e6);
    r.offscreen_factors = keys.numbers("offscreen_factors", {1}, 1, 100);
    r.cells_a_frame = keys.numbers("cells_a_frame", {0}, 0, 1000);
    r.thresholds_px = keys.numbers("thresholds_px", {}, 0.01, 1000);
    if (r.thresholds_px.empty()) keys.bad("thresholds_px", "is missing; give a list");
}

// What only the comparison of rivals has, and what it cannot do without.
void read_rivals(Keys& keys, Recipe& r) {
    if (r.conclusion != "rivals") {
        for (const Way way : r.ways)
            if (way > Way::lean && !r.counts())
                keys.bad("methods", way_words[static_cast<std::size_t>(way)] +
                                        " is for the conclusions rivals and instructions alone");
        if (!r.counts()) return;
    }
    if (r.tile_cells.size() != 1 || r.offscreen_factors != std::vector<double>{1})
        keys.bad("tile_cells", "rivals take one tile as large as the terrain, and no offscreen_factors");
    if (r.counts()) return;
    r.repetitions = static_cast<int>(keys.number("repetitions", r.repetitions, 1, 100));
    r.picture_px = keys.number("picture_px", r.picture_px, 0.01, 1000);
    r.picture_cells = static_cast<int>(keys.number("picture_cells", r.picture_cells, 8, 4096));
    if (r.verify_frames == 0) keys.bad("verify_frames", "rivals are looked at; give at least 1");
}

} // namespace

nlohmann::json Site::identity() const {
    if (!landscape.is_null()) return {{"landscape", landscape}, {"path", path}};
    return {{"file", file}, {"spacing_m", spacing_m}, {"zscale", zscale}, {"zoffset_m", zoffset_m}, {"path", path}};
}

nlohmann::json Case::json() const {
    return {{"tile_cells", tile_cells},
            {"order", order_words[static_cast<std::size_t>(order)]},
            {"estimate", estimate_words[static_cast<std::size_t>(estimate)]},
            {"method", way_words[static_cast<std::size_t>(way)]},
            {"offscreen_factor", offscreen_factor},
            {"cells_a_frame", cells_a_frame},
            {"error_px", error_px},
            {"texture_cells", texture_cells}};
}

bool Recipe::measures_any(std::initializer_list<const char*> names) const {
    return std::any_of(names.begin(), names.end(), [&](const char* wanted) {
        return std::find(measures.begin(), measures.end(), wanted) != measures.end();
    });
}

const std::vector<Measure>& all_measures() {
    static const std::vector<Measure> all{{"vertices", "vertices, mean"},
                                          {"triangles", "triangles, mean"},
                                          {"median_us", "update, median [us]"},
                                          {"p99_us", "update, p99 [us]"},
                                          {"worst_us", "update, worst [us]"},
                                          {"true_error_px", "true error, largest [px]"},
                                          {"pages_in_use", "pages in use, mean"},
                                          {"pages_read", "pages read in the flight"},
                                          {"memory_pages", "memory pages (4 KB) in use, mean"},
                                          {"memory_read", "memory pages read in the flight"},
                                          {"memory_misses", "memory pages that miss the cache, mean"},
                                          {"page_misses", "pages that miss the cache, mean"},
                                          {"bake_s", "baking errors, radii, pages [s]"},
                                          {"low_us", "lowest median [us]"},
                                          {"high_us", "highest median [us]"},
                                          {"lean_ratio", "median, times the leanest recursion's"},
                                          {"triangles_in_view", "triangles in view, mean"},
                                          {"equal_triangles", "triangles in view at equal true error"},
                                          {"equal_threshold_px", "threshold that this takes [px]"},
                                          {"memory_mb", "memory [MB]"},
                                          {"interruptible", "interruptible (1: yes)"},
                                          {"open_edges", "open edges in view, mean"},
                                          {"folds", "triangles that face down, mean"},
                                          {"gap_px", "largest gap [px]"},
                                          {"popping_px", "popping, largest [px]"},
                                          {"frames_a_second", "frames a second, median"},
                                          {"frame_ms", "whole frame, median [ms]"},
                                          {"frame_work_ms", "whole frame, work of all threads, median [ms]"},
                                          {"image_difference", "image difference, mean [levels of 255]"},
                                          {"psnr_db", "PSNR, lowest [dB]"},
                                          {"instructions", "instructions a frame, mean"},
                                          {"finest_px", "threshold of the finest mesh [px]"}};
    return all;
}

const char* heading_of(const std::string& key) {
    static const std::vector<Measure> fields{{"tile_cells", "tile [cells]"},
                                             {"order", "order"},
                                             {"estimate", "estimate"},
                                             {"method", "method"},
                                             {"offscreen_factor", "offscreen factor"},
                                             {"texture_cells", "cells a texel"},
                                             {"cells_a_frame", "cells a frame"},
                                             {"error_px", "threshold [px]"}};
    for (const auto* list : {&all_measures(), &fields})
        for (const Measure& m : *list)
            if (key == m.key) return m.heading;
    return "";
}

Recipe read_recipe(const std::string& file, const std::string& real_folder, bool quick) {
    json root = io::parse_json(io::read_text(file), file, io::JsonComments::yes);
    if (!root.is_object()) throw io::Failure(1, file + ": must be an object { ... }");
    const auto at = root.find("quick");
    if (at == root.end() || !at->is_object())
        throw io::Failure(1, file + ": quick: is missing; give an object with what the quick form changes");
    const json changes = *at;
    root.erase("quick");
    if (quick) root.update(changes);
    Keys keys(root, file);
    Recipe r;
    r.file = file;
    r.name = std::filesystem::path(file).stem().string();
    r.title = keys.text("title");
    r.question = keys.text("question");
    r.conclusion = keys.text("conclusion");
    if (std::find(conclusion_words.begin(), conclusion_words.end(), r.conclusion) == conclusion_words.end())
        keys.bad("conclusion", fmt::format("must be one of {}", fmt::join(conclusion_words, ", ")));
    r.site = site_of(keys.need("terrain"), file, quick ? std::string() : real_folder);
    read_lists(keys, r);
    (void)keys.need("about_s");
    r.about_s = keys.number("about_s", 1, 0, 1e6);
    r.frames = static_cast<int>(keys.number("frames", 840, 1, 100'000));
    r.verify_frames = static_cast<int>(keys.number("verify_frames", 0, 0, 1000));
    std::vector<std::string> known;
    for (const Measure& m : all_measures()) known.emplace_back(m.key);
    for (const std::size_t i : keys.words("measures", known, true)) r.measures.push_back(known[i]);
    if (r.measures_any({"true_error_px"}) && r.verify_frames == 0)
        keys.bad("verify_frames", "true_error_px is measured on none; give at least 1");
    if (const json* published = keys.find("published"))
        for (const json& name : keys.list("published", *published)) {
            if (!name.is_string()) keys.bad("published", "must be names of series");
            r.published.push_back(name.get<std::string>());
        }
    r.plots = plots_of(keys, file, r.measures);
    read_rivals(keys, r);
    if (r.draws() && std::find(r.ways.begin(), r.ways.end(), Way::lean) != r.ways.end())
        keys.bad("methods", "lean has no mesh that is drawn; leave it out");
    if (r.draws()) r.drawn_frames = static_cast<int>(keys.number("drawn_frames", 12, 1, 10'000));
    const bool drawn =
        r.measures_any({"frames_a_second", "frame_ms", "frame_work_ms", "image_difference", "psnr_db", "finest_px"});
    if (r.measures_any({"instructions"}) != r.counts())
        keys.bad("measures", "instructions and the conclusion instructions belong together");
    if (drawn != r.draws())
        keys.bad("measures", "what is measured of pictures and the conclusion drawing belong together");
    keys.refuse_others();
    return r;
}

std::vector<Case> cases_of(const Recipe& r) {
    std::vector<Case> cases;
    // The lean recursion has neither tiles nor orders nor offscreen factors: one case where others have several.
    const auto add = [&](const Case& c) {
        const bool first = c.tile_cells == r.tile_cells[0] && c.order == r.orders[0];
        if (c.way == Way::lean && !first) return;
        if (c.way != Way::incremental && c.offscreen_factor != r.offscreen_factors[0]) return;
        cases.push_back(c);
        if (c.way == Way::lean) cases.back().tile_cells = 0;
        if (c.way != Way::incremental) cases.back().offscreen_factor = 1;
    };
    for (const int tile : r.tile_cells)
        for (const PageOrder order : r.orders)
            for (const ErrorEstimate estimate : r.estimates)
                for (const double cells : r.cells_a_frame)
                    for (const Way way : r.ways)
                        for (const double offscreen : r.offscreen_factors)
                            for (const int texture : r.texture_cells)
                                for (const double error_px : r.thresholds_px)
                                    add({tile, order, estimate, way, offscreen, cells, error_px, texture});
    if (r.conclusion == "rivals" || r.counts()) // a method after the other: each is built once
        std::stable_sort(cases.begin(), cases.end(), [](const Case& a, const Case& b) { return a.way < b.way; });
    return cases;
}

std::string key_of(const Recipe& r, const Case& c) {
    json key{{"site", r.site.identity()},        {"case", c.json()},       {"frames", r.frames},
             {"verify_frames", r.verify_frames}, {"measures", r.measures}, {"cache_mb", r.cache_mb}};
    if (r.draws()) key["drawn_frames"] = r.drawn_frames;
    if (r.conclusion == "rivals") key["repetitions"] = r.repetitions;
    return key.dump();
}

std::string picture_name(const Recipe& r, const Case& c) {
    return fmt::format("{}-mesh-{}.svg", r.name, way_words[static_cast<std::size_t>(c.way)]);
}

} // namespace fjell::lab
