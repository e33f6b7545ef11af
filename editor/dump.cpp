#include "editor/dump.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_internal.h> // which window a list of draw commands belongs to
#include <nlohmann/json.hpp>

#include "editor/panels/ui.h"

namespace fjell::editor {

namespace {

using nlohmann::json;

json vector_json(const Vec3& v) {
    return {v.x, v.y, v.z};
}

json document_json(const Document& d) {
    return {{"path", d.path()},
            {"unsaved", d.unsaved()},
            {"undo", d.undo_steps()},
            {"redo", d.redo_steps()},
            {"undo_label", d.undo_label()},
            {"dragging", d.dragging()},
            {"compared", d.compared() != nullptr}};
}

json profile_json(const Profile& profile) {
    json values;
    for (const ProfileKey& key : profile_keys()) {
        const std::string name = std::string(key.table) + "." + key.name;
        const double value = key.get(profile);
        if (key.kind == KeyKind::choice)
            values[name] = key.choices[static_cast<std::size_t>(value)];
        else if (key.kind == KeyKind::flag)
            values[name] = value != 0;
        else
            values[name] = value;
    }
    return values;
}

json layers_of(const HeightFacts& f) {
    json layers = json::object();
    for (const RuleLayer& layer : f.layers) layers[layer.name] = layer.share;
    return layers;
}

json bake_json(const BakeDraft& d) {
    const HeightFacts& f = d.facts;
    return {{"inputs", d.pack.inputs},
            {"output", d.pack.output},
            {"texture", d.pack.texture},
            {"rules", d.pack.rules},
            {"splat", d.pack.splat},
            {"horizons", d.pack.horizons},
            {"rule_count", f.rules},
            {"layers", layers_of(f)},
            {"spacing_m", d.pack.spacing_m},
            {"looking", d.looking},
            {"looks", d.looks},
            {"known", f.known},
            {"columns", f.columns},
            {"rows", f.rows},
            {"height_m", {f.least_m, f.most_m}},
            {"problem", f.problem},
            {"field", bake_field_names[static_cast<int>(f.at)]},
            {"proposed", f.proposed},
            {"pictured", d.texture != 0},
            {"void_share", f.void_share},
            {"crs", f.crs},
            {"ready", d.ready}};
}

json files_json(const State& state) {
    const Files& f = state.files;
    json differences = json::array(), entries = json::array();
    for (const Difference& d : f.differences)
        differences.push_back(
            {{"key", std::string(d.key->table) + "." + d.key->name}, {"mine", d.mine}, {"theirs", d.theirs}});
    for (std::size_t i = 0; i < f.browser.size(); ++i) entries.push_back(f.browser.entry(i).name);
    return {{"title", f.title},
            {"differences", differences},
            {"folder", f.browser.folder()},
            {"entries", entries},
            {"browser_problem", f.browser.problem()},
            {"waiting", f.waiting.has_value()},
            {"recovery_file", f.recovery.file()},
            {"found", f.recovery.found().has_value()},
            {"bake", bake_json(state.bake)}};
}

json camera_json(const Eye& eye) {
    const session::FreeCamera& c = eye.free;
    return {{"position_m", vector_json(c.position_m)},
            {"heading_rad", c.heading},
            {"pitch_rad", c.pitch},
            {"speed_m_s", c.speed_m_s},
            {"navigation", navigation_names[static_cast<int>(eye.navigation)]},
            {"frozen", eye.frozen},
            {"ground_m", eye.ground_m},
            {"on_path", eye.on_path.has_value()},
            {"view_eye_m", vector_json(eye.view.eye_m)},
            {"refining_eye_m", eye.refining ? vector_json(eye.refining->eye_m) : json()},
            {"refining_px", eye.refining ? json({eye.refining->width_px, eye.refining->height_px}) : json()},
            {"orbit_centre_m", vector_json(eye.orbit_centre_m)},
            {"orbit_radius_m", eye.orbit_radius_m}};
}

json route_json(const Route& r) {
    json selected_m;
    if (r.selected()) {
        const session::ControlPoint& p = r.points()[*r.selected()];
        selected_m = {p[0], p[1], p[2]};
    }
    return {{"path", r.path()},
            {"unsaved", r.unsaved()},
            {"points", r.points().size()},
            {"poses", r.poses().size()},
            {"share", r.share()},
            {"playing", r.playing()},
            {"recording", r.recording()},
            {"recorded", r.recorded()},
            {"seconds", r.seconds()},
            {"loops", r.loops()},
            {"as_read", r.as_read()},
            {"can_restore", r.can_restore()},
            {"undo", r.undo_steps()},
            {"redo", r.redo_steps()},
            {"selected_m", selected_m},
            {"selected", r.selected() ? json(*r.selected()) : json()}};
}

json floating_json(const Arrangement& a) {
    json all = json::object();
    for (int p = 0; p < panels; ++p)
        if (const FloatingPanel& f = a.floating[static_cast<std::size_t>(p)]; f.on)
            all[panel_names[p]] = {f.x_px, f.y_px, f.width_px, f.height_px};
    return all;
}

json groups_json(const Arrangement& a) {
    json open = json::array();
    for (std::size_t g = 0; g < groups; ++g)
        if (a.open[g]) open.push_back(group_names[g].name);
    return open;
}

json interface_json(const State& state) {
    const Interface& i = state.interface;
    json overlay;
    for (std::size_t k = 0; k < i.overlay.size(); ++k) overlay[overlay_names[k]] = i.overlay[k];
    return {{"scale", i.scale},
            {"left", panel_names[static_cast<int>(i.arrangement.shown(left_sections))]},
            {"right", panel_names[static_cast<int>(i.arrangement.shown(right_sections))]},
            {"newest", panel_names[static_cast<int>(i.arrangement.latest.front())]},
            {"panels", i.arrangement.panels},
            {"floating", floating_json(i.arrangement)},
            {"picture_only", i.picture_only},
            {"panel_keys", i.panel_keys},
            {"focus", ui::marked_focus()},
            {"half_resolution", i.half_resolution},
            {"columns",
             {{{"width_px", i.arrangement.width_px[0]},
               {"split", i.arrangement.split[0]},
               {"folded", i.arrangement.folded[0]}},
              {{"width_px", i.arrangement.width_px[1]},
               {"split", i.arrangement.split[1]},
               {"folded", i.arrangement.folded[1]}}}},
            {"groups", groups_json(i.arrangement)},
            {"dialog", dialog_names[static_cast<int>(i.dialog)]},
            {"mode", session::picture_mode_names[static_cast<int>(i.mode)]},
            {"overlay", overlay},
            {"window_px", {i.width_px, i.height_px}},
            {"view_px", {i.view_x_px, i.view_y_px, i.view_width_px, i.view_height_px}},
            {"recent", i.recent}};
}

json labels_json(const ContourLabels& labels) {
    json all = json::array();
    for (std::size_t i = 0; i < labels.count; ++i)
        all.push_back({labels.all[i].x, labels.all[i].y, labels.all[i].height_m});
    return all;
}

json ground_json(const Ground& ground) {
    json layers = json::array();
    for (const Ground::Layer& layer : ground.layers)
        layers.push_back(
            {{"name", layer.name}, {"on", layer.on}, {"strength", layer.strength}, {"stamps", layer.stamps}});
    const Brush& b = ground.brush;
    return {{"brush",
             {{"tool", brush_tool_names[static_cast<std::size_t>(b.tool)]},
              {"radius_m", b.radius_m},
              {"falloff_m", b.falloff_m},
              {"amount_m", b.amount_m},
              {"strength", b.strength},
              {"error_m", b.error_m},
              {"colour", fmt::format("{:02x}{:02x}{:02x}", b.rgb[0], b.rgb[1], b.rgb[2])},
              {"material", b.material == no_material ? json() : json(b.material)}}},
            {"problem", ground.problem},
            {"journal", ground.journal},
            {"layers", layers},
            {"chosen", ground.chosen ? json(*ground.chosen) : json()},
            {"undo_steps", ground.undo_steps},
            {"redo_steps", ground.redo_steps},
            {"waiting", ground.waiting},
            {"blocks", ground.report.blocks},
            {"locked_blocks", ground.report.locks},
            {"always_drawn", ground.always_drawn},
            {"at", ground.at ? vector_json(*ground.at) : json()}};
}

json probe_json(const State& state) {
    const Probe& p = state.probe;
    json all = {{"on", p.on}, {"looking", p.looking}, {"marks", json::array()}};
    for (std::size_t i = 0; i < p.marks; ++i) all["marks"].push_back(vector_json(p.mark_m[i]));
    if (p.marks >= 2)
        all["profile"] = {{"length_m", p.profile.length_m}, {"ground_length_m", p.profile.ground_length_m},
                          {"area_m2", p.profile.area_m2},   {"ground_area_m2", p.profile.ground_area_m2},
                          {"lowest_m", p.profile.lowest_m}, {"highest_m", p.profile.highest_m},
                          {"height_m", p.profile.height_m}};
    if (!p.ground) return all;
    const ProbedGround& g = *p.ground;
    all["ground"] = {{"position_m", vector_json(g.position_m)},
                     {"distance_m", g.distance_m},
                     {"slope_rad", g.slope_rad},
                     {"error_m", g.error_m},
                     {"finest", g.finest},
                     {"sample", {g.sample.column, g.sample.row}},
                     {"tile", {g.tile_x, g.tile_y}},
                     {"page", g.page}};
    const baker::Coordinates& c = *state.scene.coordinates;
    if (c.projected()) all["ground"]["in_crs"] = c.in_crs(g.position_m.x, g.position_m.z);
    if (g.degrees) all["ground"]["degrees"] = *g.degrees;
    if (g.mesh)
        all["ground"]["mesh"] = {
            {"level", g.mesh->level}, {"height_m", g.mesh->height_m}, {"error_px", g.mesh->error_px}};
    return all;
}

json input_json(const InputCounts& i) {
    return {{"keys", i.keys},
            {"characters", i.characters},
            {"buttons", i.buttons},
            {"scrolls", i.scrolls},
            {"pointer_px", {i.pointer_px[0], i.pointer_px[1]}},
            {"focused", i.focused}};
}

json tuned_json(const JobView& j) {
    json keys = json::object();
    for (const TunedKey& t : j.tuned_keys) keys[std::string(t.key->table) + "." + t.key->name] = t.value;
    return keys;
}

json job_json(const JobView& j) {
    json curve = json::array();
    for (const TunePoint& p : j.curve)
        curve.push_back({{"error_px", p.error_px},
                         {"p50_us", p.p50_us},
                         {"p99_us", p.p99_us},
                         {"max_us", p.max_us},
                         {"vertices", p.vertices},
                         {"keeps", p.keeps},
                         {"reached", p.reached},
                         {"frames", p.frames},
                         {"dearest_us", p.dearest_us},
                         {"flights", p.flights}});
    return {{"kind", job_names[static_cast<int>(j.kind)]},
            {"running", j.running},
            {"cancelled", j.cancelled},
            {"stage", j.stage},
            {"share", j.share},
            {"problem", j.problem},
            {"result", j.result},
            {"output", j.output},
            {"curve", curve},
            {"best_px", j.best_px},
            {"tuned_keys", tuned_json(j)},
            {"flights", j.flights},
            {"seconds", j.seconds},
            {"preview",
             {{"error_px", j.preview.error_px},
              {"vertices", j.preview.vertices},
              {"triangles", j.preview.triangles},
              {"bytes", j.preview.bytes}}},
            {"finished", j.finished}};
}

json messages_json(const State& state) {
    json list = json::array();
    constexpr const char* severities[] = {"note", "warning", "error"};
    for (const Message& m : state.messages.all)
        list.push_back({{"severity", severities[static_cast<int>(m.severity)]}, {"text", m.text}, {"times", m.times}});
    return list;
}

// Parts that add up to the frame.
json times_json(const State& state) {
    if (!state.chosen) return {};
    const MeasuredFrame& f = *state.chosen;
    return {{"ago", state.measures.recorded() - f.number},
            {"frame_us", f.times.frame_us},
            {"update_us", f.entry.update_us},
            {"stream_us", f.entry.stream_us},
            {"upload_us", f.times.upload_us},
            {"draw_us", f.times.draw_us},
            {"present_us", f.times.present_us},
            {"editor_us", f.times.editor_us},
            {"triangles_drawn", f.entry.triangles_drawn},
            {"position_m", vector_json(f.pose.position_m)}};
}

json measures_json(const State& state) {
    const session::FrameEntry& e = state.measures.last();
    const auto ring = [&](Series series) {
        const Quantiles q = state.measures.ring(series).quantiles();
        return json{{"p50", q.p50}, {"p99", q.p99}, {"max", q.max}, {"last", q.last}};
    };
    json levels = json::array();
    for (std::uint32_t i = 0; i < state.measures.levels().levels; ++i)
        levels.push_back(state.measures.levels().triangles[i]);
    return {{"frames", state.measures.frames()},
            {"recorded", state.measures.recorded()},
            {"held", state.measures.held()},
            {"graphs", {state.graphs.oldest, state.graphs.newest}},
            {"chosen", times_json(state)},
            {"vertices", e.vertices},
            {"triangles", e.triangles},
            {"triangles_drawn", e.triangles_drawn},
            {"error_px_asked", e.error_px_requested},
            {"error_px_effective", e.error_bound_px},
            {"converged", e.converged},
            {"update_us", ring(Series::update_us)},
            {"frame_us", ring(Series::frame_us)},
            {"editor_us", ring(Series::editor_us)},
            {"stream_us", ring(Series::stream_us)},
            {"exhausted", session::budget_names(e.exhausted)},
            {"draw_us", ring(Series::draw_us)},
            {"upload_us", ring(Series::upload_us)},
            {"present_us", ring(Series::present_us)},
            {"other_us", ring(Series::other_us)},
            {"gpu_us", state.software ? json() : ring(Series::gpu_us)},
            {"levels", levels}};
}

json place_json(const FlownRun& run, std::size_t at) {
    const FlownPlace& p = run.places[at];
    return {{"share", run.share_of(at)},
            {"frame", p.frame},
            {"update_us", p.update_us},
            {"error_px", p.error_px},
            {"measured_px", p.measured_px},
            {"exhausted", session::budget_names(p.exhausted)},
            {"position_m", vector_json(p.pose.position_m)}};
}

json runs_json(const Runs& runs) {
    json all = json::array();
    for (const auto& run : runs.all) {
        json worst = json::array(), measured = json::array();
        for (const FlownPlace& p : run->places) measured.push_back(p.measured_px);
        for (const std::vector<std::uint16_t>& by : run->worst) {
            worst.push_back(json::array());
            for (const std::uint16_t at : by) worst.back().push_back(place_json(*run, at));
        }
        all.push_back({{"name", run->name},
                       {"error_px", run->error_px},
                       {"frames", run->frames},
                       {"places", run->places.size()},
                       {"measured_px", measured},
                       {"p50_us", run->p50_us},
                       {"p99_us", run->p99_us},
                       {"max_us", run->max_us},
                       {"converged", run->converged},
                       {"worst", worst}});
    }
    json chosen;
    if (runs.chosen) {
        chosen = place_json(*runs.all[runs.chosen->run], runs.chosen->place);
        chosen["run"] = runs.chosen->run;
    }
    return {{"all", all}, {"chosen", chosen}, {"heat", heat_names[static_cast<int>(runs.heat)]}};
}

json bookmarks_json(const Bookmarks& bookmarks) {
    json all = json::array();
    for (const Bookmark& b : bookmarks.all)
        if (b.pack == bookmarks.pack) all.push_back({{"name", b.name}, {"position_m", vector_json(b.pose.position_m)}});
    return all;
}

json materials_json(const MaterialsInUse& m) {
    json under = json::object();
    for (const GroundShares::Share& s : m.under.all()) under[s.name] = s.share;
    return {{"materials", m.materials}, {"rules", m.rules}, {"under", under}};
}

json compared_json(const ComparedPicture& c) {
    return {{"with", compare_with_names[static_cast<int>(c.with)]},
            {"error_px", c.error_px},
            {"view", compare_view_names[static_cast<int>(c.view)]},
            {"divider", c.divider},
            {"there", c.there},
            {"triangles", c.triangles},
            {"exhausted", session::budget_names(c.exhausted)},
            {"asked_px", c.asked_px},
            {"kept_px", c.kept_px},
            {"differing", c.differing}};
}

} // namespace

std::string dump(const State& state) {
    json marks;
    for (const ui::Mark& m : ui::marks()) marks[m.name] = {m.rect.x, m.rect.y, m.rect.width, m.rect.height};
    const Scene& s = state.scene;
    const json all = {
        {"frame", state.frame},
        {"terrain_draws", state.terrain_draws},
        {"longest_frame_us", state.longest_frame_us},
        {"programs", state.programs},
        {"half_draws", state.half_draws},
        {"band_draws", state.band_draws},
        {"drawn_px", {state.drawn_px[0], state.drawn_px[1]}},
        {"rested_s", state.rested_s},
        {"opening", state.opening},
        {"scene",
         {{"path", s.path},
          {"crs", s.coordinates ? s.coordinates->crs() : ""},
          {"columns", s.columns},
          {"rows", s.rows},
          {"spacing_m", {s.spacing_m[0], s.spacing_m[1]}},
          {"tiles", {s.tiles_x, s.tiles_y}},
          {"streamed", s.streamed},
          {"method_bytes", s.method_bytes}}},
        {"profile", profile_json(state.document.profile())},
        {"document", document_json(state.document)},
        {"files", files_json(state)},
        {"camera", camera_json(state.eye)},
        {"route", route_json(state.route)},
        {"interface", interface_json(state)},
        {"probe", probe_json(state)},
        {"ground", ground_json(state.ground)},
        {"contours", {{"every_m", contour_interval_m(state)}, {"labels", labels_json(state.contour_labels)}}},
        {"input", input_json(state.input)},
        {"job", job_json(state.job)},
        {"runs", runs_json(state.runs)},
        {"bookmarks", bookmarks_json(state.bookmarks)},
        {"compared_picture", compared_json(state.compared)},
        {"materials", materials_json(state.materials)},
        {"messages", messages_json(state)},
        {"measures", measures_json(state)},
        {"map", {{"share", state.overview.share}, {"there", state.overview.texture != 0}}},
        {"heights_share", state.heights_share},
        {"graphics", state.graphics},
        {"illegible", ui::illegible_texts()},
        {"marks", marks}};
    return all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

} // namespace fjell::editor

// --- Texts that cannot be read whole.

namespace fjell::editor::ui {

namespace {

constexpr float slack_px = 1.5F; // letters are rounded to pixels

// As much may letters lie over their neighbours: an f leans over a j.
float lean_px() {
    return slack_px + 0.12F * ImGui::GetFontSize();
}

// Letters in a row, as one call has drawn them or several one behind the other.
struct Text {
    std::string letters;
    ImVec2 low, high, last_low, last_high;
    ImVec4 clip;
    bool cut_x = false, cut_y = false; // letters of it were cut as they were written, to fit a control or the window
    bool in_field = false;
};

// Four vertices and six indices, as ImGui writes a rectangle.
bool is_rectangle(const ImDrawIdx* i, const ImDrawVert* v) {
    const ImDrawIdx a = i[0];
    if (i[1] != a + 1 || i[2] != a + 2 || i[3] != a || i[4] != a + 2 || i[5] != a + 3) return false;
    return v[a].pos.y == v[a + 1].pos.y && v[a + 1].pos.x == v[a + 2].pos.x && v[a + 2].pos.y == v[a + 3].pos.y;
}

// The letter in whose picture this part lies; null: it is none.
const ImFontGlyph* letter_of(const ImFont& font, const ImVec2& from, const ImVec2& to) {
    constexpr float e = 1e-6F;
    const auto* const found = std::find_if(font.Glyphs.begin(), font.Glyphs.end(), [&](const ImFontGlyph& g) {
        return g.U0 <= from.x + e && g.V0 <= from.y + e && g.U1 >= to.x - e && g.V1 >= to.y - e && g.U1 > g.U0;
    });
    return found == font.Glyphs.end() ? nullptr : found;
}

bool is_field(ImU32 colour) {
    const ImU32 rgb = ~static_cast<ImU32>(IM_COL32_A_MASK);
    return std::ranges::any_of(std::initializer_list<ImGuiCol>{ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered,
                                                               ImGuiCol_FrameBgActive, ImGuiCol_TextSelectedBg},
                               [&](ImGuiCol of) {
                                   return (ImGui::ColorConvertFloat4ToU32(ImGui::GetStyle().Colors[of]) & rgb) ==
                                          (colour & rgb);
                               });
}

class Reader {
public:
    Reader(const ImFont& font, const ImTextureID& letters) : font_(font), atlas_(letters) {}

    std::vector<Text> read(const ImDrawList& list) {
        texts_.clear();
        for (const ImDrawCmd& command : list.CmdBuffer) {
            going_on_ = false;
            if (command.UserCallback == nullptr) read(list, command);
        }
        return std::move(texts_);
    }

private:
    void read(const ImDrawList& list, const ImDrawCmd& command) {
        const ImDrawIdx* const indices = list.IdxBuffer.Data + command.IdxOffset;
        const ImDrawVert* const vertices = list.VtxBuffer.Data + command.VtxOffset;
        for (unsigned i = 0; i + 3 <= command.ElemCount;) {
            const bool rectangle = i + 6 <= command.ElemCount && is_rectangle(indices + i, vertices);
            const ImDrawVert* const v = vertices + indices[i];
            const bool letter = rectangle && command.TextureId == atlas_ && v[0].uv.x != v[2].uv.x;
            const ImFontGlyph* const glyph = letter ? letter_of(font_, v[0].uv, v[2].uv) : nullptr;
            if (glyph != nullptr)
                add(*glyph, v, command.ClipRect);
            else
                under_ = v->col, going_on_ = false;
            i += rectangle ? 6 : 3;
        }
    }

    void add(const ImFontGlyph& glyph, const ImDrawVert* v, const ImVec4& clip) {
        const ImVec2 low = v[0].pos, high = v[2].pos;
        const float em = font_.FontSize;
        Text* t = texts_.empty() ? nullptr : &texts_.back();
        if (!going_on_ || t == nullptr || low.x < t->last_high.x - lean_px() || low.x > t->last_high.x + 2 * em ||
            std::abs(low.y + high.y - t->last_low.y - t->last_high.y) > 1.4F * em) {
            texts_.push_back({{}, low, high, low, high, clip, false, false, is_field(under_)});
            t = &texts_.back();
        }
        going_on_ = true;
        t->letters += glyph.Codepoint < 128 ? static_cast<char>(glyph.Codepoint) : '?';
        const float hidden_wide = (glyph.X1 - glyph.X0) - (high.x - low.x),
                    hidden_high = (glyph.Y1 - glyph.Y0) - (high.y - low.y);
        t->cut_x = t->cut_x || hidden_wide > slack_px;
        t->cut_y = t->cut_y || hidden_high > slack_px;
        t->low = {std::min(t->low.x, low.x), std::min(t->low.y, low.y)};
        t->high = {std::max(t->high.x, high.x), std::max(t->high.y, high.y)};
        t->last_low = low;
        t->last_high = high;
    }

    const ImFont& font_;
    const ImTextureID atlas_;
    std::vector<Text> texts_;
    ImU32 under_ = 0; // the colour of what was drawn last that is no letter
    bool going_on_ = false;
};

bool is_seen(const Text& t) {
    return t.high.x > t.clip.x && t.low.x < t.clip.z && t.high.y > t.clip.y && t.low.y < t.clip.w;
}

bool scrolls(const ImGuiWindow* window, ImGuiAxis axis) {
    for (; window != nullptr; window = window->ParentWindow)
        if (window->ScrollMax[static_cast<std::size_t>(axis)] > 0) return true;
    return false;
}

bool is_cut(const Text& t, const ImGuiWindow* window) {
    const bool across = t.low.x < t.clip.x - slack_px || t.high.x > t.clip.z + slack_px,
               along = t.low.y < t.clip.y - slack_px || t.high.y > t.clip.w + slack_px;
    return ((across || (t.cut_x && !t.in_field)) && !scrolls(window, ImGuiAxis_X)) ||
           ((along || t.cut_y) && !scrolls(window, ImGuiAxis_Y));
}

bool lie_over_each_other(const Text& a, const Text& b) {
    const float x = std::min(std::min(a.high.x, a.clip.z), std::min(b.high.x, b.clip.z)) -
                    std::max(std::max(a.low.x, a.clip.x), std::max(b.low.x, b.clip.x));
    const float y = std::min(std::min(a.high.y, a.clip.w), std::min(b.high.y, b.clip.w)) -
                    std::max(std::max(a.low.y, a.clip.y), std::max(b.low.y, b.clip.y));
    return x > lean_px() && y > lean_px();
}

} // namespace

std::vector<std::string> illegible_texts() {
    std::vector<std::string> found;
    if (ImGui::GetCurrentContext() == nullptr) return found;
    const ImDrawData* const data = ImGui::GetDrawData();
    if (data == nullptr) return found;
    const ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    Reader reader(*fonts.Fonts.front(), fonts.TexID);
    for (int i = 0; i < data->CmdListsCount; ++i) {
        const ImDrawList& list = *data->CmdLists[i];
        const char* const name = list._OwnerName != nullptr ? list._OwnerName : "";
        const ImGuiWindow* const window = ImGui::FindWindowByName(name);
        const std::vector<Text> texts = reader.read(list);
        for (auto t = texts.begin(); t != texts.end(); ++t) {
            if (!is_seen(*t)) continue;
            if (is_cut(*t, window)) found.push_back(std::string(name) + ": " + t->letters);
            for (auto other = texts.begin(); other != t; ++other)
                if (is_seen(*other) && lie_over_each_other(*t, *other))
                    found.push_back(std::string(name) + ": " + t->letters + " | " + other->letters);
        }
    }
    return found;
}

} // namespace fjell::editor::ui
