#include "baker/pack/notes.h"

#include <cerrno>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "io/json.h"

namespace fjell::baker {

namespace {

using nlohmann::json;

[[noreturn]] void damaged(const io::PackFile& file) {
    if (file.changed()) file.fail(EIO);
    throw Failure(1, file.path() + ": its notes of how it was baked are damaged; copy or bake it again");
}

SourceFacts source_of(const json& j) {
    SourceFacts f;
    for (const auto& [key, to] : {std::pair{"driver", &f.driver}, {"type", &f.type}, {"voids", &f.voids}})
        if (j.contains(key)) *to = j.at(key).get<std::string>();
    if (j.contains("band")) f.band = j.at("band").get<std::string>();
    if (j.contains("coarse")) f.coarse = j.at("coarse").get<std::string>();
    f.height_unit = j.at("height_unit").get<std::string>();
    f.height_unit_m = j.at("height_unit_m").get<double>();
    if (j.contains("ground_scale"))
        for (std::size_t end = 0; end < 2; ++end) f.ground_scale[end] = j["ground_scale"].at(end).get<double>();
    if (!j.contains("reprojected_from")) return f;
    f.reprojected_from = j.at("reprojected_from").get<std::string>();
    for (std::size_t axis = 0; axis < 2; ++axis) f.from_step[axis] = j.at("from_step").at(axis).get<double>();
    f.from_unit = j.at("from_unit").get<std::string>();
    for (const auto& [key, to] : {std::pair{"resampled", &f.resampled}, {"axes", &f.axes}})
        if (j.contains(key)) *to = j.at(key).get<std::string>();
    return f;
}

json baked_json(const BakedWith& b) {
    const HeightStatistics& h = b.heights;
    return {{"options", fmt::format("{:016x}", b.options)},
            {"on_scale", b.on_scale},
            {"painted", b.painted},
            {"columns", b.smooth.columns},
            {"rows", b.smooth.rows},
            {"smooth", {b.smooth.step_m, b.smooth.levels}},
            {"heights",
             {{"least_m", h.least_m},
              {"most_m", h.most_m},
              {"tile_range_m", h.tile_range_m},
              {"step_m", {h.step_m[0], h.step_m[1]}},
              {"climbing", h.climbing},
              {"off_metre", h.off_metre},
              {"off_decimetre", h.off_decimetre}}}};
}

BakedWith baked_of(const json& j, std::uint64_t voids) {
    BakedWith b;
    b.options = std::stoull(j.at("options").get<std::string>(), nullptr, 16);
    b.on_scale = j.at("on_scale").get<bool>();
    b.painted = j.at("painted").get<bool>();
    b.smooth = {j.at("columns").get<std::int32_t>(), j.at("rows").get<std::int32_t>(),
                j.at("smooth").at(0).get<float>(), j.at("smooth").at(1).get<int>()};
    const json& h = j.at("heights");
    HeightStatistics& to = b.heights;
    to.least_m = h.at("least_m").get<float>();
    to.most_m = h.at("most_m").get<float>();
    to.tile_range_m = h.at("tile_range_m").get<float>();
    for (std::size_t axis = 0; axis < 2; ++axis) to.step_m[axis] = h.at("step_m").at(axis).get<float>();
    to.voids = voids;
    to.climbing = h.at("climbing").get<std::uint64_t>();
    to.off_metre = h.at("off_metre").get<std::uint64_t>();
    to.off_decimetre = h.at("off_decimetre").get<std::uint64_t>();
    const bool sound = to.least_m <= to.most_m && to.tile_range_m >= 0 && to.step_m[0] >= 0 && to.step_m[1] >= 0 &&
                       std::isfinite(to.most_m - to.least_m) && std::isfinite(to.tile_range_m) &&
                       std::isfinite(to.step_m[0]) && std::isfinite(to.step_m[1]) && std::isfinite(b.smooth.step_m) &&
                       b.smooth.levels >= 0 && b.smooth.levels <= most_smooth_levels;
    if (!sound) throw std::out_of_range("baked"); // damaged, as a number that is none
    return b;
}

} // namespace

std::string notes_text(const PackNotes& notes) {
    const SourceFacts& f = notes.source;
    json source = {{"height_unit", f.height_unit}, {"height_unit_m", f.height_unit_m}};
    for (const auto& [key, text] : {std::pair{"driver", &f.driver}, {"type", &f.type}, {"voids", &f.voids}})
        if (!text->empty()) source[key] = *text;
    if (!f.band.empty()) source["band"] = f.band;
    if (!f.coarse.empty()) source["coarse"] = f.coarse;
    if (f.ground_scale[0] > 0) source["ground_scale"] = {f.ground_scale[0], f.ground_scale[1]};
    if (!f.reprojected_from.empty()) {
        source["reprojected_from"] = f.reprojected_from;
        source["from_step"] = {f.from_step[0], f.from_step[1]};
        source["from_unit"] = f.from_unit;
        source["resampled"] = f.resampled;
        if (!f.axes.empty()) source["axes"] = f.axes;
    }
    json all = {{"source", std::move(source)}};
    if (!notes.images.empty()) all["images"] = notes.images;
    if (!notes.locks.empty()) all["locks"] = notes.locks;
    if (!notes.read.empty()) all["read"] = io::parse_json(notes.read, "notes");
    if (notes.ground_error_m) all["ground_error_m"] = *notes.ground_error_m;
    if (notes.baked) all["baked"] = baked_json(*notes.baked);
    return all.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::optional<PackNotes> read_notes(const io::PackFile& file) {
    const PackHeader& h = file.pack().header;
    if (h.notes_bytes == 0) return {};
    std::string text(h.notes_bytes, '\0');
    if (const int error = file.read(h.notes_offset, std::as_writable_bytes(std::span(text))); error != 0)
        file.fail(error);
    if (XXH3_64bits(text.data(), text.size()) != h.notes_hash) damaged(file);
    const json all = io::parse_json(text, file.path());
    if (!all.is_object()) damaged(file);
    try {
        PackNotes notes;
        notes.source = source_of(all.at("source"));
        if (all.contains("images")) notes.images = all["images"].get<std::vector<std::string>>();
        if (all.contains("locks")) notes.locks = all["locks"].get<std::string>();
        if (all.contains("read")) notes.read = all["read"].dump();
        if (all.contains("ground_error_m")) notes.ground_error_m = all["ground_error_m"].get<double>();
        if (all.contains("baked")) notes.baked = baked_of(all["baked"], h.voids);
        return notes;
    } catch (const json::exception&) {
        damaged(file);
    } catch (const std::logic_error&) { // a number that is none
        damaged(file);
    }
}

} // namespace fjell::baker
