#include "baker/cli/reports.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "baker/bake/inputs.h"
#include "baker/cli/summary.h"
#include "baker/georeference/crs_label.h"
#include "baker/pack/join.h"
#include "baker/pack/notes.h"
#include "fjell/edit.h"
#include "fjell/io/load.h"
#include "fjell/terrain.h"
#include "io/file.h"
#include "io/json.h"
#include "io/set_file.h"
#include "io/system.h"
#include "shared/order.h"

namespace fjell::baker {

using io::PackFile;
using io::parse_json;
using io::place_json;
using nlohmann::json;

namespace {

const char* order_name(PageOrder order) {
    switch (order) {
    case PageOrder::planar: return "planar";
    case PageOrder::hierarchical_z: return "hz";
    case PageOrder::linear: break;
    }
    return "linear";
}

// Throws when what the pack is compared with has its samples elsewhere.
void check_spacing(const HeightSource& against, const std::string& name, const PackHeader& header) {
    for (const int axis : {0, 1})
        if (std::abs(against.spacing_m[axis] / header.spacing_m[axis] - 1) > 1e-9)
            throw Failure(1, fmt::format("{}: its samples are {} m apart, the pack's {} m: it is not what the pack was "
                                         "baked from, or it was read with another --spacing; give that",
                                         name, against.spacing_m[axis], header.spacing_m[axis]));
}

// How the height field is read: as the pack says that it was, unless the command line says otherwise.
Recipe as_baked(const Recipe& given, const std::optional<PackNotes>& notes, const std::string& pack) {
    if (!notes || notes->read.empty()) return given;
    return merged(given, parse_recipe(notes->read, pack));
}

// What is wrong with a pack's heights or maps, and what to do about it. Baking it again helps only where the pack
// contradicts itself.
std::string verdict_of(const PackCheck& check, const std::string& pack) {
    const VerifyReport& r = check.heights;
    const MapsReport& maps = check.maps;
    const Recipe& source = check.source;
    const std::string& first = r.ok() ? maps.first : r.first;
    const bool contradicts =
        !maps.ok() ||
        r.nesting_violations + r.sphere_violations + r.border_mismatches + r.rim_violations + r.bound_violations != 0;
    if (contradicts || r.height_mismatches == 0) return fmt::format("{}: {}; bake it again", pack, first);
    return fmt::format("{}: {}: these are not the heights of {}, read with {}; name what it was baked from, and its "
                       "options",
                       pack, first,
                       source.inputs.empty() ? "the array" : fmt::format("{}", fmt::join(source.inputs, " ")),
                       parse_json(recipe_text(reading_part(source)), pack).dump());
}

// Which packs of a set differ where they meet, and how. Empty: none, or it is no set.
std::string seam_of(const std::string& path) {
    const std::string index = io::set_file_of(path);
    if (index.empty()) return {};
    const std::filesystem::path folder = std::filesystem::path(index).parent_path();
    const BorderReport borders = compare_borders(io::parse_set_file(io::read_text(index), index), folder.string());
    return borders.ok() ? "" : path + ": " + borders.first;
}

} // namespace

std::vector<std::string> layer_names(const PackFile& file) {
    if (file.pack().header.layer_bytes == 0) return {};
    std::vector<std::byte> text;
    file.read_chunk({ChunkKind::layers, 0, 0}, text);
    return io::layer_names({reinterpret_cast<const char*>(text.data()), text.size()});
}

json journal_json(const io::Journal& journal) {
    json layers = json::array();
    for (const io::JournalLayer& layer : journal.layers())
        layers.push_back(
            {{"name", layer.name}, {"on", layer.on}, {"strength", layer.strength}, {"stamps", layer.stamps.size()}});
    return {{"pack_hash", fmt::format("{:016x}", journal.pack_hash())},
            {"bytes", journal.file_bytes()},
            {"dead_bytes", journal.dead_bytes()},
            {"dropped_bytes", journal.dropped_bytes()},
            {"layers", layers}};
}

namespace {

json journal_beside(const PackFile& file) {
    const std::string path = io::journal_path(file.path());
    io::os::FileInfo there;
    if (!io::os::look(path, there)) return {};
    json j{{"path", path}};
    try {
        const io::Journal journal(path);
        j["of_this_pack"] = journal.pack_hash() == file.pack().header.directory_hash;
        j.update(journal_json(journal));
    } catch (const Failure& failure) {
        j["problem"] = failure.what();
    }
    return j;
}

} // namespace

json info_json(const PackFile& file) {
    const PackHeader& h = file.pack().header;
    const CrsLabel crs = crs_label(file.crs());
    json j{{"version", h.version},
           {"columns", h.columns},
           {"rows", h.rows},
           {"tiles", {h.tiles_x, h.tiles_y}},
           {"tile_cells", 1u << h.tile_log2},
           {"order", order_name(h.order)},
           {"estimate", h.estimate == ErrorEstimate::max ? "max" : "midpoint"},
           {"nesting", h.nesting},
           {"crs", file.crs().empty() ? json() : json(file.crs())},
           {"crs_name", crs.name.empty() ? json() : json(crs.name)},
           {"epsg", crs.epsg ? json(crs.epsg) : json()},
           {"height_m", {h.min_m, h.max_m}},
           {"quantum_m", h.quantum_m},
           {"holes", h.voids},
           {"room_for_holes", has_room_for_holes(h)},
           {"room_for_locks", has_room_for_locks(h)},
           {"pages_per_tile", pages_of(h).pages_per_tile()},
           {"max_error_m", h.max_error_m},
           {"colour_texels", h.colour_log2 ? 1u << h.colour_log2 : 0},
           {"normal_texels", h.normal_log2 ? 1u << h.normal_log2 : 0},
           {"horizon_texels", h.horizon_log2 ? 1u << h.horizon_log2 : 0},
           {"splat_texels", h.splat_log2 ? 1u << h.splat_log2 : 0},
           {"layers", layer_names(file)},
           {"packs", file.packs()},
           {"tiles_held", tiles_of(h)},
           {"chunks", h.directory_count},
           {"file_bytes", h.file_bytes},
           {"pack_hash", fmt::format("{:016x}", h.directory_hash)},
           {"required_bytes", terrain_bytes(h)},
           {"journal", journal_beside(file)}};
    j.update(place_json(h));
    add_notes(j, read_notes(file));
    return j;
}

PackCheck check_pack(const std::string& path, const Recipe& source, const HeightSource* heights) {
    const PackFile pack(path);
    limit_gdal_cache(std::size_t{64} << 20);
    PackCheck check;
    check.source = source;
    const std::optional<PackNotes> notes = read_notes(pack); // damaged ones are refused, needed or not
    std::unique_ptr<HeightSource> opened;
    if (!source.inputs.empty()) {
        check.source = as_baked(source, notes, path);
        opened = open_inputs(check.source);
        heights = opened.get();
    }
    if (heights) check_spacing(*heights, opened ? source.inputs.front() : "heights", pack.pack().header);
    check.heights = verify(pack, heights);
    if (opened && !source.inputs.front().ends_with(".json"))
        check.again = read_again(check.source.inputs, read_options(check.source), opened->facts, pack);
    if (check.heights.border_mismatches != 0) check.seam = seam_of(path);
    if (!check.seam.empty()) check.heights.first = check.seam;
    check.heights.chunks = io::check_all_chunks(pack);
    check.maps = check_maps(pack);
    return check;
}

json check_json(const PackCheck& check) {
    const VerifyReport& r = check.heights;
    const MapsReport& maps = check.maps;
    json j{{"ok", r.ok() && maps.ok() && check.again.wrong.empty()},
           {"vertices", r.vertices},
           {"chunks", r.chunks},
           {"nesting_violations", r.nesting_violations},
           {"sphere_violations", r.sphere_violations},
           {"border_mismatches", r.border_mismatches},
           {"rim_violations", r.rim_violations},
           {"bound_violations", r.bound_violations},
           {"height_mismatches", r.height_mismatches},
           {"samples_compared", r.samples_compared},
           {"true_error_violations", r.true_error_checked ? json(r.true_error_violations) : json()},
           {"texels", maps.texels},
           {"mip_violations", maps.mip_violations},
           {"map_border_violations", maps.border_violations},
           {"length_violations", maps.length_violations},
           {"weight_violations", maps.weight_violations}};
    j["read_again"] = check.again.account.empty() ? json() : json(check.again.account);
    const std::string& first = !r.ok() ? r.first : !maps.ok() ? maps.first : check.again.wrong;
    j["first"] = first.empty() ? json() : json(first);
    return j;
}

std::string verdict(const PackCheck& check, const std::string& pack) {
    if (!check.seam.empty()) return check.seam;
    if (!check.heights.ok() || !check.maps.ok()) return verdict_of(check, pack);
    if (check.again.wrong.empty()) return {};
    return fmt::format("{}: {}, as GDAL alone reads it: {}; bake it again", pack, fmt::join(check.source.inputs, " "),
                       check.again.wrong);
}

} // namespace fjell::baker
