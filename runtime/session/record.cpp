#include "session/record.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "io/json.h"

namespace fjell::session {

namespace {

using io::Failure;
using nlohmann::json;

constexpr std::uint32_t version = 4, oldest_version = 2;
constexpr const char* morph_names[] = {"none", "error", "time"};
constexpr std::uint32_t page_events = 4; // PageEvent's values, as they are written
static_assert(static_cast<std::uint32_t>(PageEvent::removed) == page_events - 1,
              "PageEvent is written by number: change the recording's version with it");

std::string hex(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

// The line they are of is added where lines are read.
[[noreturn]] void refuse(const std::string& what) {
    throw Failure(1, what);
}

const json& value(const json& object, const char* key) {
    if (!object.is_object()) refuse("a line must be an object { ... }");
    const auto found = object.find(key);
    if (found == object.end()) refuse(fmt::format("\"{}\" is missing", key));
    return *found;
}
const json& list(const json& object, const char* key) {
    const json& j = value(object, key);
    if (!j.is_array()) refuse(fmt::format("\"{}\" must be a list", key));
    return j;
}
std::string text_of(const json& object, const char* key) {
    const json& j = value(object, key);
    if (!j.is_string()) refuse(fmt::format("\"{}\" must be text", key));
    return j.get<std::string>();
}
bool flag_of(const json& object, const char* key) {
    const json& j = value(object, key);
    if (!j.is_boolean()) refuse(fmt::format("\"{}\" must be true or false", key));
    return j.get<bool>();
}
double number(const json& j, const char* key) {
    if (!j.is_number()) refuse(fmt::format("\"{}\" must hold numbers", key));
    return j.get<double>();
}
double number_of(const json& object, const char* key) {
    return number(value(object, key), key);
}
// get<std::uint32_t>() would convert any number, also one that does not fit.
std::uint32_t whole_number(const json& j, const char* key) {
    if (!j.is_number_unsigned() || j.get<std::uint64_t>() > 0xffffffff)
        refuse(fmt::format("\"{}\" must hold whole numbers below 2^32", key));
    return static_cast<std::uint32_t>(j.get<std::uint64_t>());
}
std::uint32_t whole_number_of(const json& object, const char* key) {
    return whole_number(value(object, key), key);
}

json view_json(const View& v) {
    json j = {v.eye_m.x, v.eye_m.y, v.eye_m.z, v.forward.x, v.forward.y, v.forward.z, v.up.x,   v.up.y, v.up.z,
              v.left,    v.right,   v.bottom,  v.top,       v.width_px,  v.height_px, v.near_m, v.far_m};
    if (v.max_error_px != 0) j.push_back(v.max_error_px); // a threshold of its own
    return j;
}

// The sides of version 2, which had focal_length_px instead: those that give the same frustum and, to the last bit, the
// same lambda. (There are such sides for every view of make_view(), which had computed lambda from one of them.)
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
        refuse("a view has 17 numbers, 18 with a threshold of its own, or 15 in version 2");
    View v;
    const auto at = [&](std::size_t i) { return number(j[i], "views"); };
    const auto vec = [&](std::size_t i) { return Vec3{at(i), at(i + 1), at(i + 2)}; };
    v.eye_m = vec(0);
    v.forward = vec(3);
    v.up = vec(6);
    if (numbers != 15) {
        v.left = at(9);
        v.right = at(10);
        v.bottom = at(11);
        v.top = at(12);
    }
    const std::size_t next = numbers != 15 ? 13 : 10;
    v.width_px = whole_number(j[next], "views");
    v.height_px = whole_number(j[next + 1], "views");
    v.near_m = at(next + 2);
    v.far_m = at(next + 3);
    if (numbers == 18) v.max_error_px = at(17);
    if (numbers == 15) set_sides(v, at(14));
    return v;
}

json frame_json(const RecordedFrame& f) {
    json views = json::array();
    for (const View& v : f.views) views.push_back(view_json(v));
    const CutSettings& s = f.settings;
    json pages = json::array();
    for (const PageArrival& p : f.pages) pages.push_back({p.tile, p.page, static_cast<std::uint32_t>(p.event)});
    json stamps = json::array();
    for (const io::KeptStamp& stamp : f.stamps) stamps.push_back(io::stamp_json(stamp));
    return {{"views", std::move(views)},    {"stamps", std::move(stamps)},
            {"pages", std::move(pages)},    {"missing_px", f.missing_px},
            {"rebuild", f.rebuild},         {"items", s.max_work},
            {"visits", s.visits},           {"error_px", s.max_error_px},
            {"hysteresis", s.hysteresis},   {"offscreen_factor", s.offscreen_factor},
            {"corner_safe", s.corner_safe}, {"morph", morph_names[static_cast<int>(s.morph)]},
            {"morph_s", s.morph_s},         {"now_s", s.now_s},
            {"mesh", hex(f.mesh_hash)}};
}

std::uint64_t hash_of(const json& object, const char* key) {
    const std::string text = text_of(object, key);
    std::uint64_t hash = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
    if (error != std::errc() || end != text.data() + text.size())
        refuse(fmt::format("\"{}\" must be a hash of hexadecimal digits", key));
    return hash;
}

Morph morph_of(const json& object) {
    const std::string name = text_of(object, "morph");
    for (std::size_t m = 0; m < std::size(morph_names); ++m)
        if (name == morph_names[m]) return static_cast<Morph>(m);
    refuse(fmt::format("\"morph\" must be one of {}", fmt::join(morph_names, ", ")));
}

RecordedFrame frame_of(const json& j) {
    RecordedFrame f;
    for (const json& v : list(j, "views")) f.views.push_back(view_of(v));
    if (f.views.empty()) refuse("a frame needs a view");
    CutSettings& s = f.settings;
    f.rebuild = flag_of(j, "rebuild");
    s.max_work = whole_number_of(j, "items");
    s.visits = whole_number_of(j, "visits");
    s.max_error_px = number_of(j, "error_px");
    s.hysteresis = number_of(j, "hysteresis");
    if (j.contains("offscreen_factor")) s.offscreen_factor = number_of(j, "offscreen_factor"); // since 2026-11-23
    s.corner_safe = flag_of(j, "corner_safe");
    s.morph_s = number_of(j, "morph_s");
    s.now_s = number_of(j, "now_s");
    s.morph = morph_of(j);
    f.mesh_hash = hash_of(j, "mesh");
    if (j.contains("stamps")) // since version 4
        for (const json& stamp : list(j, "stamps")) f.stamps.push_back(io::stamp_of(stamp));
    for (const json& p : list(j, "pages")) {
        if (!p.is_array() || p.size() != 3 || whole_number(p[2], "pages") >= page_events)
            refuse("what became of a page is its tile, its number and 0 to 3");
        f.pages.push_back({whole_number(p[0], "pages"), whole_number(p[1], "pages"),
                           static_cast<PageEvent>(whole_number(p[2], "pages"))});
    }
    f.missing_px = number_of(j, "missing_px");
    return f;
}

void read_head(const json& j, Recording& r) {
    const std::uint32_t is = text_of(j, "fjell") == "recording" ? whole_number_of(j, "version") : 0;
    if (is < oldest_version || is > version)
        refuse(fmt::format("it must be of version {} to {}; record it again", oldest_version, version));
    r.pack_hash = hash_of(j, "pack");
    r.budget.vertices = whole_number_of(j, "vertices");
    r.budget.triangles = whole_number_of(j, "triangles");
    r.budget.segment_triangles = whole_number_of(j, "chunk_triangles");
    r.budget.views = whole_number_of(j, "views");
    r.page_slots = whole_number_of(j, "page_slots");
    if (j.contains("edits")) { // since version 4
        const json& e = value(j, "edits");
        r.edits = {whole_number_of(e, "blocks"), whole_number_of(e, "stamps"), whole_number_of(e, "areas")};
        if (e.contains("paint")) r.edits->paint = whole_number_of(e, "paint");
        if (e.contains("locks")) r.edits->locks = whole_number_of(e, "locks");
    }
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
    RecordedFrame f{{views.begin(), views.end()}, settings, report.rebuilt, mesh_hash(mesh), {}, {}, 0};
    if (settings.max_time_us > 0 && !report.rebuilt) f.settings.visits = report.visits;
    f.settings.max_time_us = 0;
    f.settings.jobs = {};
    return f;
}

Status replay_pages(const Pack& pack, Terrain& terrain, LiveCut cut, const RecordedFrame& frame) {
    for (const PageArrival& p : frame.pages) {
        if (p.tile >= terrain.tile_count() || p.page >= terrain.pages_per_tile())
            return {StatusCode::out_of_range, "page"};
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
    return set_missing_px(terrain, frame.missing_px);
}

std::string write_recording(const Recording& r) {
    json head = {{"fjell", "recording"},
                 {"version", version},
                 {"pack", hex(r.pack_hash)},
                 {"vertices", r.budget.vertices},
                 {"triangles", r.budget.triangles},
                 {"chunk_triangles", r.budget.segment_triangles},
                 {"page_slots", r.page_slots},
                 {"views", r.budget.views}};
    if (r.edits)
        head["edits"] = {{"blocks", r.edits->blocks},
                         {"stamps", r.edits->stamps},
                         {"areas", r.edits->areas},
                         {"paint", r.edits->paint},
                         {"locks", r.edits->locks}};
    std::string text = head.dump() + '\n';
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
        const json j = io::parse_json(text.substr(0, end), name, io::JsonComments::no, line);
        try {
            if (line == 1)
                read_head(j, r);
            else
                r.frames.push_back(frame_of(j));
        } catch (const Failure& failure) {
            throw Failure(1, fmt::format("{}:{}: not a recording: {}", name, line, failure.what()));
        }
        text.remove_prefix(end + 1);
    }
    if (!r.edits && std::ranges::any_of(r.frames, [](const RecordedFrame& f) { return !f.stamps.empty(); }))
        throw Failure(1, fmt::format("{}: not a recording: stamps without \"edits\" in the first line", name));
    if (r.frames.empty()) throw Failure(1, fmt::format("{}: the recording has no frames", name));
    return r;
}

} // namespace fjell::session
