#include "baker/cli/vectors.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "baker/cli/reports.h"
#include "baker/cli/summary.h"
#include "baker/locks/locks.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/pack_file.h"
#include "io/command_line.h"
#include "io/file.h"
#include "io/stamps.h"
#include "io/system.h"

namespace fjell::baker {

using io::Failure;
using io::Journal;
using io::JournalLayer;
using nlohmann::json;

namespace {

LineOptions river_defaults() {
    LineOptions o;
    o.shoulder_m = 0, o.smooth_m = 0;
    o.slopes = {.cut = 0.5, .fill = 0.5, .fills = false};
    return o;
}

void declare_layer(CLI::App& c, VectorArguments& a, const std::string& what) {
    c.add_option("PACK", a.pack, "a pack, or the folder of a pack set that covers its terrain")->required();
    c.add_option("FILE", a.file, what + ": GeoPackage, GeoJSON, Shapefile, or what else GDAL reads, in any CRS")
        ->required();
    c.add_option("--from", a.from, "the layer of FILE to take (default: all of them)");
    c.add_option("--layer", a.layer, "the edit layer to make (default " + c.get_name() + ")");
    c.add_flag("--replace", a.replace, "the layer is there: put these " + what + " in the place of what is in it");
    c.add_option("--journal", a.journal, "another file than PACK.journal");
    c.add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    c.add_flag("--quiet", a.quiet, "no summary: only what is wrong");
}

void declare_common(CLI::App& c, VectorArguments& a, LineOptions& o) {
    declare_layer(c, a, "lines");
    c.add_option(
         "--width-m", o.width_m,
         fmt::format("width in metres (default {:g}); an attribute width_m or width of a line counts more", o.width_m))
        ->check(io::within(least_width_m, most_width_m));
    c.add_option("--reach-m", o.slopes.reach_m,
                 fmt::format("a slope ends after so many metres (default {:g})", o.slopes.reach_m))
        ->check(io::within(0, 1e5));
    c.add_option("--paint", a.paint, "RRGGBB: the colour that maps show along lines");
    c.add_option("--material", a.material, "the material that they show, by its name in the pack's splat maps");
}

CLI::Option* slope(CLI::App& c, const char* name, double& slope, const char* what) {
    constexpr double flattest = 0.01, steepest = 100;
    return c.add_option(name, slope, fmt::format("{}: metres up a metre (default {:g})", what, slope))
        ->check(io::within(flattest, steepest));
}

std::uint8_t material_of(const std::string& name, const io::PackFile& pack) {
    const std::vector<std::string> names = layer_names(pack);
    const auto found = std::ranges::find(names, name);
    if (found != names.end()) return static_cast<std::uint8_t>(found - names.begin());
    throw Failure(1, names.empty() ? fmt::format("--material: {} has no splat maps; bake it with --layers", pack.path())
                                   : fmt::format("--material: {} is none of the pack's; they are {}", name,
                                                 fmt::join(names, ", ")));
}

// What is flown and baked below a layer.
std::vector<io::TimedStamp> stamps_below(const Journal& journal, std::size_t place) {
    std::vector<io::TimedStamp> all;
    for (io::KeptStamp& stamp : journal.stamps(place)) all.push_back({0, std::move(stamp)});
    return all;
}

void write(Journal& journal, std::size_t place, const std::string& name, const std::vector<io::KeptStamp>& stamps) {
    std::vector<std::uint64_t> old;
    std::uint32_t id = 0;
    if (place < journal.layers().size()) {
        const JournalLayer& layer = journal.layers()[place];
        id = layer.id;
        for (const io::JournalStamp& stamp : layer.stamps) old.push_back(stamp.id);
    } else {
        id = journal.add_layer(name);
    }
    // The new ones first: a program that is killed in between leaves both, and the upper ones are right.
    (void)journal.add_stamps(id, stamps);
    if (!old.empty()) journal.remove_stamps(old);
    journal.commit();
}

json summary_json(const MadeLines& made, const std::string& journal, const std::string& layer) {
    const LineSummary& s = made.summary;
    return {{"journal", journal},
            {"layer", layer},
            {"lines", s.lines},
            {"length_m", s.length_m},
            {"stamps", made.stamps.size()},
            {"samples", s.ground.samples},
            {"deepest_cut_m", s.ground.deepest_cut_m},
            {"highest_fill_m", s.ground.highest_fill_m},
            {"cut_m3", s.ground.cut_m3},
            {"fill_m3", s.ground.fill_m3},
            {"steepest_grade_before", s.ground_grade},
            {"steepest_grade", s.grade},
            {"most_off_ground_m", s.most_off_m},
            {"steep_samples", s.ground.steep}};
}

void print(const MadeLines& made, const std::string& journal, const std::string& layer, LineKind kind) {
    const LineSummary& s = made.summary;
    fmt::print("{}: layer \"{}\": {} lines, {:.0f} m, {} stamps, {} samples\n", journal, layer, s.lines, s.length_m,
               made.stamps.size(), s.ground.samples);
    fmt::print("cut {:.1f} m deep at most, {:.0f} m3; filled {:.1f} m high at most, {:.0f} m3\n",
               s.ground.deepest_cut_m, s.ground.cut_m3, s.ground.highest_fill_m, s.ground.fill_m3);
    fmt::print("steepest {} {:.3f}, and {:.3f} on the ground before\n", kind == LineKind::road ? "grade" : "fall",
               s.grade, s.ground_grade);
    if (s.bed_width_m > s.asked_m)
        fmt::print("samples are {:g} m apart: lines {:g} m wide become at least as wide as that\n", s.bed_width_m,
                   s.asked_m);
    if (s.ground.steep > 0)
        fmt::print("{} samples lie at slopes steeper than asked: lines of two heights are too near each other, or a "
                   "slope goes on beyond --reach-m\n",
                   s.ground.steep);
}

} // namespace

VectorCommands declare_vectors(CLI::App& app, VectorArguments& a) {
    VectorCommands c{};
    a.rivers = river_defaults();
    c.roads = app.add_subcommand("roads", "lay the roads of a map on a pack's ground, as a layer of its journal");
    LineOptions& road = a.roads;
    declare_common(*c.roads, a, road);
    c.roads
        ->add_option("--shoulder-m", road.shoulder_m,
                     fmt::format("level ground on either side, in metres (default {:g})", road.shoulder_m))
        ->check(io::within(0, most_width_m));
    slope(*c.roads, "--cut-slope", road.slopes.cut, "ground above the road comes down to it at this slope");
    slope(*c.roads, "--fill-slope", road.slopes.fill, "and ground below it comes up at this one");
    c.roads
        ->add_option("--max-grade", road.max_grade,
                     fmt::format("the steepest that a road may be, metres up a metre (default {:g}); an attribute "
                                 "max_grade of a line counts more",
                                 road.max_grade))
        ->check(io::within(least_grade, most_grade));
    c.roads
        ->add_option("--smooth-m", road.smooth_m,
                     fmt::format("a road does not follow bumps shorter than this (default {:g})", road.smooth_m))
        ->check(io::within(0, 1e4));
    c.rivers =
        app.add_subcommand("rivers", "carve the rivers of a map into a pack's ground, as a layer of its journal");
    LineOptions& river = a.rivers;
    declare_common(*c.rivers, a, river);
    c.rivers
        ->add_option("--depth-m", river.depth_m,
                     fmt::format("of the bed below the lowest ground upstream, in metres (default {:g}); an "
                                 "attribute depth_m of a line counts more",
                                 river.depth_m))
        ->check(io::within(0, most_depth_m));
    slope(*c.rivers, "--bank-slope", river.slopes.cut, "of the banks");
    c.locks =
        app.add_subcommand("locks", "hold places of a map to errors of their own, as a layer of a pack's journal");
    declare_layer(*c.locks, a, "points, lines and polygons");
    c.locks
        ->add_option("--lock-error-m", a.lock_error_m,
                     "metres that no view exceeds there; an attribute error_m of a feature counts more")
        ->check(io::within(0, 1e6));
    return c;
}

namespace {

// The layer that is to be made, or made anew.
struct TargetLayer {
    std::string path, name;
    PackHeader header;
    std::optional<Journal> journal; // an existing one is held, so that no other program changes what lies below
    std::size_t place = 0;

    TargetLayer(const VectorArguments& a, const PackHeader& pack, const char* usual)
        : path(a.journal.empty() ? io::journal_path(a.pack) : a.journal), name(a.layer.empty() ? usual : a.layer),
          header(pack) {
        if (name.size() > io::max_layer_name)
            throw Failure(2, fmt::format("--layer: a name has at most {} bytes", io::max_layer_name));
        io::refuse_overwriting({path, a.json_path}, {a.pack, a.file});
        io::refuse_overwriting({a.json_path}, {path});
        if (header.tiles_held != 0)
            throw Failure(1, fmt::format("{}: lacks tiles, and such ground cannot be changed", a.pack));
        io::os::FileInfo there;
        if (!io::os::look(path, there)) return;
        journal.emplace(path, header);
        const auto found = std::ranges::find(journal->layers(), name, &JournalLayer::name);
        place = static_cast<std::size_t>(found - journal->layers().begin());
        if (place < journal->layers().size() && !a.replace)
            throw Failure(1, fmt::format("{}: has a layer \"{}\"; give --replace, or another --layer", path, name));
    }
    void put(const std::vector<io::KeptStamp>& stamps) {
        if (!journal) journal.emplace(path, header);
        write(*journal, place, name, stamps);
    }
    void say_how_to_use(const VectorArguments& a) const {
        fmt::print("to fly over it: fjell-fly {0} --edits {1}; for a pack of it: fjell-bake apply {0} {1} -o OUT\n",
                   a.pack, path);
    }
};

} // namespace

int run_vectors(const VectorArguments& a, LineKind kind) {
    LineOptions options = kind == LineKind::road ? a.roads : a.rivers;
    auto pack = std::make_unique<PackSource>(a.pack);
    TargetLayer layer(a, pack->header(), kind == LineKind::road ? "roads" : "rivers");
    if (!a.paint.empty()) options.paint = io::rgb_of(a.paint, "--paint");
    if (!a.material.empty()) options.material = material_of(a.material, io::PackFile(a.pack));
    JsonOutput summary(a.json_path);
    const std::vector<MapLine> lines = read_map_lines(a.file, a.from, *pack, kind, options);
    std::unique_ptr<HeightSource> ground = std::move(pack);
    if (layer.journal)
        if (const std::vector<io::TimedStamp> below = stamps_below(*layer.journal, layer.place); !below.empty())
            ground = edited_source(std::move(ground), below, layer.path);
    const MadeLines made = make_lines(*ground, lines, kind, options, a.file);
    if (made.stamps.empty())
        throw Failure(1, fmt::format("{}: changes nothing: the ground is as it should be", a.file));
    layer.put(made.stamps);
    summary.write(summary_json(made, layer.path, layer.name));
    if (!a.quiet && a.json_path != "-") {
        print(made, layer.path, layer.name, kind);
        layer.say_how_to_use(a);
    }
    return 0;
}

int run_locks(const VectorArguments& a) {
    const PackSource pack(a.pack);
    if (!has_room_for_locks(pack.header()))
        throw Failure(1, fmt::format("{}: has no room for locks; bake it with --room-for-locks yes", a.pack));
    TargetLayer layer(a, pack.header(), "locks");
    JsonOutput summary(a.json_path);
    const Locks locks(a.file, a.lock_error_m, pack, a.from);
    const std::vector<io::KeptStamp> stamps = locks.stamps(a.file);
    layer.put(stamps);
    summary.write(
        {{"journal", layer.path}, {"layer", layer.name}, {"locks", locks.account()}, {"stamps", stamps.size()}});
    if (!a.quiet && a.json_path != "-") {
        fmt::print("{}: layer \"{}\": {} as {} stamps\n", layer.path, layer.name, locks.account(), stamps.size());
        layer.say_how_to_use(a);
    }
    return 0;
}

} // namespace fjell::baker
