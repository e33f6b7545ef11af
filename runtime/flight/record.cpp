#include "flight/record.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "fjell/io/failure.h"
#include "pack/terrain_data.h"

namespace fjell::flight {

namespace {

using io::Failure;
using nlohmann::json;

constexpr std::uint32_t version = 3, oldest_version = 2;
constexpr const char* morph_names[] = {"none", "error", "time"};
constexpr std::uint32_t page_events = 4; // PageEvent's values, as they are written
static_assert(static_cast<std::uint32_t>(PageEvent::removed) == page_events - 1,
              "PageEvent is written by number: change the recording's version with it");

std::string hex(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

// get<std::uint32_t>() would convert any number, also one that does not fit.
std::uint32_t whole_number(const json& j) {
    if (!j.is_number_unsigned() || j.get<std::uint64_t>() > 0xffffffff)
        throw json::other_error::create(600, "must be a whole number below 2^32: " + j.dump(), &j);
    return static_cast<std::uint32_t>(j.get<std::uint64_t>());
}

json view_json(const View& v) {
    json j = {v.eye_m.x, v.eye_m.y, v.eye_m.z, v.forward.x, v.forward.y, v.forward.z, v.up.x,   v.up.y, v.up.z,
              v.left,    v.right,   v.bottom,  v.top,       v.width_px,  v.height_px, v.near_m, v.far_m};
    if (v.error_px != 0) j.push_back(v.error_px); // a threshold of its own
    return j;
}

// The sides of version 2, which had lambda_px instead: those that give the same frustum and, to the last bit, the same
// lambda. (There are such sides for every view of make_view(), which had computed lambda from one of them.)
void set_sides(View& v, double lambda) {
    const double middle = v.height_px / (2 * lambda);
    double top = middle;
    for (const double other : {std::nextafter(middle, 0.0), std::nextafter(middle, 1e300)})
        if (v.height_px / (2 * top) != lambda) top = other;
    if (v.height_px / (2 * top) != lambda) top = middle;
    v.top = top;
    v.bottom = -top;
    v.right = top * v.width_px / v.height_px;
    v.left = -v.right;
}

View view_of(const json& j) {
    const std::size_t numbers = j.is_array() ? j.size() : 0;
    if (numbers < 15 || numbers > 18 || numbers == 16)
        throw json::other_error::create(600, "a view has 17 or 18 numbers, or 15 in version 2", &j);
    View v;
    const auto vec = [&](std::size_t i) {
        return Vec3{j.at(i).get<double>(), j.at(i + 1).get<double>(), j.at(i + 2).get<double>()};
    };
    v.eye_m = vec(0);
    v.forward = vec(3);
    v.up = vec(6);
    if (numbers != 15) {
        v.left = j.at(9).get<double>();
        v.right = j.at(10).get<double>();
        v.bottom = j.at(11).get<double>();
        v.top = j.at(12).get<double>();
    }
    const std::size_t next = numbers != 15 ? 13 : 10;
    v.width_px = whole_number(j.at(next));
    v.height_px = whole_number(j.at(next + 1));
    v.near_m = j.at(next + 2).get<double>();
    v.far_m = j.at(next + 3).get<double>();
    if (numbers == 18) v.error_px = j.at(17).get<double>();
    if (numbers == 15) set_sides(v, j.at(14).get<double>());
    return v;
}

json frame_json(const RecordedFrame& f) {
    json views = json::array();
    for (const View& v : f.views) views.push_back(view_json(v));
    const CutSettings& s = f.settings;
    json pages = json::array();
    for (const PageArrival& p : f.pages) pages.push_back({p.tile, p.page, static_cast<std::uint32_t>(p.event)});
    return {{"views", std::move(views)},
            {"pages", std::move(pages)},
            {"missing_px", f.missing_px},
            {"rebuild", f.rebuild},
            {"items", s.items},
            {"visits", s.visits},
            {"error_px", s.error_px},
            {"hysteresis", s.hysteresis},
            {"corner_safe", s.corner_safe},
            {"morph", morph_names[static_cast<int>(s.morph)]},
            {"morph_s", s.morph_s},
            {"now_s", s.now_s},
            {"mesh", hex(f.mesh_hash)}};
}

std::uint64_t from_hex(const json& j) {
    return std::stoull(j.get<std::string>(), nullptr, 16);
}

RecordedFrame frame_of(const json& j) {
    RecordedFrame f;
    for (const json& v : j.at("views")) f.views.push_back(view_of(v));
    if (f.views.empty()) throw json::other_error::create(600, "a frame needs a view", &j);
    CutSettings& s = f.settings;
    f.rebuild = j.at("rebuild").get<bool>();
    s.items = whole_number(j.at("items"));
    s.visits = whole_number(j.at("visits"));
    s.error_px = j.at("error_px").get<double>();
    s.hysteresis = j.at("hysteresis").get<double>();
    s.corner_safe = j.at("corner_safe").get<bool>();
    s.morph_s = j.at("morph_s").get<double>();
    s.now_s = j.at("now_s").get<double>();
    const auto morph = j.at("morph").get<std::string>();
    for (int m = 0; m < 3; ++m)
        if (morph == morph_names[m]) s.morph = static_cast<Morph>(m);
    f.mesh_hash = from_hex(j.at("mesh"));
    for (const json& p : j.at("pages")) {
        if (!p.is_array() || p.size() != 3 || whole_number(p.at(2)) >= page_events)
            throw json::other_error::create(600, "what became of a page is its tile, its number and 0 to 3", &p);
        f.pages.push_back(
            {whole_number(p.at(0)), whole_number(p.at(1)), static_cast<PageEvent>(whole_number(p.at(2)))});
    }
    f.missing_px = j.at("missing_px").get<double>();
    return f;
}

void read_head(const json& j, Recording& r) {
    const std::uint32_t is = j.at("fjell").get<std::string>() == "recording" ? whole_number(j.at("version")) : 0;
    if (is < oldest_version || is > version)
        throw json::other_error::create(600, "not a recording of this version", &j);
    r.pack_hash = from_hex(j.at("pack"));
    r.budget.vertices = whole_number(j.at("vertices"));
    r.budget.triangles = whole_number(j.at("triangles"));
    r.budget.segment_triangles = whole_number(j.at("chunk_triangles"));
    r.budget.views = whole_number(j.at("views"));
    r.page_slots = whole_number(j.at("page_slots"));
}

} // namespace

std::uint64_t mesh_hash(const MeshView& mesh) {
    std::uint64_t hash = XXH3_64bits_withSeed(mesh.vertices.data(), mesh.vertices.size_bytes(), 0);
    for (const TileRange& range : mesh.tiles) {
        hash = XXH3_64bits_withSeed(&range, sizeof range, hash);
        hash = XXH3_64bits_withSeed(mesh.indices.data() + range.first_index, range.index_count * sizeof(std::uint32_t),
                                    hash);
    }
    return hash;
}

RecordedFrame recorded(std::span<const View> views, const CutSettings& settings, const CutReport& report,
                       const MeshView& mesh) {
    RecordedFrame f{{views.begin(), views.end()}, settings, report.rebuilt, mesh_hash(mesh), {}, 0};
    if (settings.budget_us > 0 && !report.rebuilt) f.settings.visits = report.visits;
    f.settings.budget_us = 0;
    return f;
}

Status replay_pages(const Pack& pack, Terrain& terrain, LiveCut cut, const RecordedFrame& frame) {
    for (const PageArrival& p : frame.pages) {
        if (p.tile >= terrain.tile_count() || p.page >= terrain.pages_per_tile()) return {Code::out_of_range, "page"};
        bool released = false;
        switch (p.event) {
        case PageEvent::inserted:
            if (Status s = load_page(pack, terrain, p.tile, p.page); !s.ok()) return s;
            break;
        case PageEvent::released:
            if (Status s = cut_release_page(cut, p.tile, p.page, released); !s.ok()) return s;
            break;
        case PageEvent::kept: (void)cut_cancel_release(cut, p.tile, p.page); break;
        case PageEvent::removed: (void)unload_page(terrain, p.tile, p.page); break;
        }
    }
    data_of(terrain).missing_px = frame.missing_px;
    return {};
}

std::string write_recording(const Recording& r) {
    std::string text = json{
        {"fjell", "recording"},
        {"version", version},
        {"pack", hex(r.pack_hash)},
        {"vertices", r.budget.vertices},
        {"triangles", r.budget.triangles},
        {"chunk_triangles", r.budget.segment_triangles},
        {"page_slots", r.page_slots},
        {"views",
         r.budget.views}}.dump();
    text += '\n';
    for (const RecordedFrame& f : r.frames) {
        text += frame_json(f).dump();
        text += '\n';
    }
    return text;
}

Recording parse_recording(std::string_view text, const std::string& name) {
    Recording r;
    for (std::size_t line = 1; !text.empty(); ++line) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos)
            throw Failure(1,
                          fmt::format("{}:{}: the recording ends in the middle of a line; copy it again", name, line));
        try {
            const json j = json::parse(text.substr(0, end));
            if (line == 1)
                read_head(j, r);
            else
                r.frames.push_back(frame_of(j));
        } catch (const std::exception& error) { // nlohmann's, and std::stoull's
            throw Failure(1, fmt::format("{}:{}: not a recording: {}", name, line, error.what()));
        }
        text.remove_prefix(end + 1);
    }
    if (r.frames.empty()) throw Failure(1, fmt::format("{}: the recording has no frames", name));
    return r;
}

} // namespace fjell::flight
