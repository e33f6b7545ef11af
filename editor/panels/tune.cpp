// The profile: where values lie on their sliders, what they cost now, and the panel that changes them.
#include "editor/panels/tune.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <utility>

#include <strings.h>

#include "editor/number_text.h"
#include "editor/panels/forms.h"
#include "editor/panels/panels.h"
#include "session/methods/method.h"

namespace fjell::editor {

namespace {

constexpr double zero_stretch = 0.04; // of the slider, where 0 is allowed on a logarithmic one

// The smallest value above 0 that such a slider gives.
double floor_of(const ProfileKey& key) {
    return key.kind == KeyKind::number ? key.most * 1e-6 : 1;
}

double three_digits(double value) {
    if (value == 0) return 0;
    const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
    return step < 1 ? std::round(value / step) / std::round(1 / step) : std::round(value / step) * step;
}

} // namespace

double slider_share(const ProfileKey& key, double value) {
    const double v = std::clamp(value, key.least, key.most);
    if (!key.logarithmic) return (v - key.least) / (key.most - key.least);
    if (key.least > 0) return std::log(v / key.least) / std::log(key.most / key.least);
    if (v == 0) return 0;
    const double floor = floor_of(key);
    return zero_stretch + (1 - zero_stretch) * std::max(std::log(v / floor), 0.0) / std::log(key.most / floor);
}

double slider_value(const ProfileKey& key, double share) {
    if (!(share > 0)) return key.least;
    if (share >= 1) return key.most;
    double value = 0;
    if (!key.logarithmic) {
        value = key.least + share * (key.most - key.least);
    } else if (key.least > 0) {
        value = key.least * std::pow(key.most / key.least, share);
    } else {
        if (share < zero_stretch) return 0;
        const double floor = floor_of(key);
        value = floor * std::pow(key.most / floor, (share - zero_stretch) / (1 - zero_stretch));
    }
    value = three_digits(value);
    if (key.kind != KeyKind::number) value = std::round(value);
    return std::clamp(value, key.least, key.most);
}

ShownUnit shown_unit(const ProfileKey& key) {
    return std::strcmp(key.unit, "us") == 0 ? ShownUnit{"ms", 1e-3} : ShownUnit{key.unit, 1};
}

void write_value(const ProfileKey& key, double value, char* to, int size) {
    if (key.zero != nullptr && value == 0)
        (void)std::snprintf(to, static_cast<std::size_t>(size), "%s", key.zero);
    else
        (void)std::snprintf(to, static_cast<std::size_t>(size), key.kind == KeyKind::number ? "%.7g" : "%.0f",
                            value * shown_unit(key).share);
}

bool typed_value(const ProfileKey& key, std::string_view text, double& value) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    while (text.ends_with(' ')) text.remove_suffix(1);
    if (key.zero != nullptr && text == key.zero) {
        value = 0;
        return true;
    }
    double read = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(read)) return false;
    const double share = shown_unit(key).share;
    value = share == 1 ? read : std::round(read / share * 1e3) / 1e3; // or 16.667 ms would be 16667.000000000002 us
    return true;
}

namespace {

using session::FrameEntry;

struct Text {
    char* to;
    std::size_t size, used = 0;

    void add(const char* format, ...) IM_FMTARGS(2) {
        if (used + 1 >= size) return;
        va_list values;
        va_start(values, format);
        const int n = std::vsnprintf(to + used, size - used, format, values);
        va_end(values);
        if (n > 0) used += static_cast<std::size_t>(n);
    }
    void count(const char* before, double number) { add("%s%s", before, count_text(number).text); }
    void bytes(double bytes) { add("%s", byte_text(bytes).text); }
};

// Of the states of pages that a cut with so many vertices has for the terrain that is shown.
double page_state_bytes(const State& state, double vertices) {
    const Scene& scene = state.scene;
    const std::uint32_t slots =
        scene.streamed ? std::min(scene.pages, state.document.profile().page_slots) : scene.pages;
    return static_cast<double>(cut_pages({.vertices = static_cast<std::uint32_t>(vertices)}, slots, scene.tiles)) *
           static_cast<double>(cut_page_bytes);
}

// What the table above the profile's keys says of bytes, for the chosen method.
void vertices(const State& state, Text& text, double value) {
    const FrameEntry& e = state.measures.last();
    const session::MethodFacts& slot = session::facts_of(state.document.profile());
    text.bytes(value * static_cast<double>(slot.vertex_bytes) + (slot.keeps_mesh ? page_state_bytes(state, value) : 0));
    text.add(" + ");
    text.bytes(value * static_cast<double>(slot.gpu_vertex_bytes));
    text.add(" GPU");
    text.count(", used ", e.vertices);
    if (slot.keeps_mesh) text.count(", peak ", e.vertices_peak);
}

void triangles(const State& state, Text& text, double value) {
    const FrameEntry& e = state.measures.last();
    text.bytes(value * static_cast<double>(cut_triangle_bytes));
    text.add(" + ");
    text.bytes(value * 12);
    text.count(" GPU, used ", e.triangles);
    text.count(", peak ", e.triangles_peak);
}

void indices(const State&, Text& text, double value) {
    text.bytes(value * 4);
    text.add(" + ");
    text.bytes(value * 4);
    text.add(" GPU");
}

void items(const State& state, Text& text, double) {
    text.count("last frame ", state.measures.last().items);
}

void time(const State& state, Text& text, double) {
    text.add("last update %s ms", ms_text(state.measures.last().update_us).text);
}

void threshold(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (e.error_bound_px >= 1e6)
        text.add("lags");
    else
        text.add("keeps %.*f px", e.error_bound_px < 100 ? 2 : 0, e.error_bound_px);
    text.count(", ", e.triangles_drawn);
    text.add(" triangles drawn");
}

void page_slots(const State& state, Text& text, double value) {
    text.bytes(value * 12.5e3);
    if (state.scene.pages != 0) text.count(", the pack has ", state.scene.pages);
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.count(", used ", e.stream.page_slots.used);
    text.count(", peak ", e.stream.page_slots.peak);
}

void page_requests(const State& state, Text& text, double value) {
    text.bytes(value * 16e3);
    if (state.measures.last().streamed) text.add(", in flight %u with mips", state.measures.last().stream.in_flight);
}

void map_requests(const State&, Text& text, double value) {
    text.add("up to ");
    text.bytes(value * 525e3);
}

void map_mb(const State& state, Text& text, double value) {
    text.bytes(value * 1048576);
    text.add(" GPU");
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.add(", used ");
    text.bytes(static_cast<double>(e.stream.map_bytes_used));
}

void pages(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (e.streamed) text.add("last frame %u, left %u", e.stream.pages_inserted, e.stream.pages_left);
}

void map_kb(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.add("last frame ");
    text.bytes(static_cast<double>(e.stream.map_upload_bytes));
}

struct Cost {
    const char *table, *name;
    void (*write)(const State&, Text&, double value);
};
constexpr Cost costs[] = {
    {"refine", "max_error_px", threshold},
    {"budget", "vertices", vertices},
    {"budget", "triangles", triangles},
    {"budget", "max_work", items},
    {"budget", "max_time_us", time},
    {"budget", "indices", indices},
    {"stream", "page_slots", page_slots},
    {"stream", "page_requests", page_requests},
    {"stream", "map_requests", map_requests},
    {"stream", "map_mb", map_mb},
    {"stream", "pages", pages},
    {"stream", "map_kb", map_kb},
};

bool is(const ProfileKey& key, const char* table, const char* name) {
    return std::strcmp(key.table, table) == 0 && std::strcmp(key.name, name) == 0;
}

} // namespace

bool cost_text(const ProfileKey& key, const State& state, char* to, std::size_t size) {
    for (const Cost& cost : costs) {
        if (!is(key, cost.table, cost.name)) continue;
        Text text{to, size};
        cost.write(state, text, key.get(state.document.profile()));
        return text.used != 0;
    }
    return false;
}

namespace {

// Of light, by what else is chosen.
struct LightCondition {
    const char* names; // each between spaces
    bool (*idle)(const State&, const gl::LightSettings&);
    const char* why;
};
constexpr LightCondition light_conditions[] = {
    {" azimuth_deg elevation_deg ",
     [](const State&, const gl::LightSettings& light) { return light.sun == gl::SunBy::time; },
     "only with the sun by direction"},
    {" latitude_deg longitude_deg year month day hour_utc ",
     [](const State&, const gl::LightSettings& light) { return light.sun == gl::SunBy::direction; },
     "only with the sun by time"},
    {" ev100 ", [](const State&, const gl::LightSettings& light) { return light.exposure == gl::Exposure::automatic; },
     "only with a fixed exposure"},
    {" shadows ",
     [](const State& state, const gl::LightSettings&) { return state.scene.open() && !state.scene.horizons; },
     "this pack was baked without horizons"},
    {" water_level_m ", [](const State&, const gl::LightSettings& light) { return !light.water; }, "only with water"},
};

const char* why_light_idle(const ProfileKey& key, const State& state) {
    const std::string_view name = key.name;
    for (const LightCondition& c : light_conditions) {
        const std::string_view names = c.names;
        const std::size_t at = names.find(name);
        if (at != std::string_view::npos && names[at - 1] == ' ' && names[at + name.size()] == ' ' &&
            c.idle(state, state.document.profile().light))
            return c.why;
    }
    return nullptr;
}

} // namespace

const char* why_idle(const ProfileKey& key, const State& state) {
    const Profile& profile = state.document.profile();
    switch (key.used_by) {
    case UsedBy::any: break;
    case UsedBy::incremental:
        if (session::facts_of(profile).keys != key.used_by) return "only with the incremental method";
        break;
    case UsedBy::recursive:
        if (session::facts_of(profile).keys != key.used_by) return "only with the recursive method";
        break;
    case UsedBy::streaming: // page_slots decides whether anything is streamed: it counts always
        if (!state.scene.streamed && !is(key, "stream", "page_slots"))
            return "only when streaming: a pack with more pages than page slots";
        break;
    }
    if (is(key, "refine", "morph_s") && profile.cut.morph != Morph::time) return "only with morph \"time\"";
    if (std::strcmp(key.table, "light") == 0) return why_light_idle(key, state);
    if (std::strcmp(key.table, "layers") != 0) return nullptr;
    if (!state.scene.materials) return "only with materials";
    if (is(key, "layers", "splat") && !state.scene.splat) return "this pack was baked without splat maps";
    return !profile.layers.on && !is(key, "layers", "on") ? "only with materials on" : nullptr;
}

Group group_of(const ProfileKey& key) {
    if (key.used_by == UsedBy::recursive) return Group::tune_advanced;
    constexpr struct {
        const char* table;
        Group group;
    } tables[] = {{"refine", Group::tune_refinement},
                  {"budget", Group::tune_budgets},
                  {"stream", Group::tune_streaming},
                  {"view", Group::tune_screen},
                  {"layers", Group::light_materials}};
    for (const auto& t : tables)
        if (std::strcmp(key.table, t.table) == 0) return t.group;
    // Light, in the order in which a profile has it.
    static const ProfileKey *const air = find_profile_key("light.air"), *const ground =
                                                                            find_profile_key("light.detail");
    return &key < air ? Group::light_sun : &key < ground ? Group::light_air : Group::light_ground;
}

namespace {

constexpr float field_px = 106; // unscaled; ten digits

struct Row {
    const ProfileKey& key;
    const State& state;
    TypingField& typing;
    Commands& commands;
    char name[64] = {}; // refine.max_error_px
    double value = 0;
    const char* idle = nullptr; // why it does not count now

    Row(const ProfileKey& k, const State& s, TypingField& t, Commands& c) : key(k), state(s), typing(t), commands(c) {
        (void)std::snprintf(name, sizeof name, "%s.%s", key.table, key.name);
        value = key.get(state.document.profile());
        idle = why_idle(key, state);
    }
};

const char* rebuilds(Rebuild rebuild) {
    switch (rebuild) {
    case Rebuild::nothing: return "A change takes effect in the next frame.";
    case Rebuild::method: return "A change reallocates the method's memory.";
    case Rebuild::session: return "A change reopens the pack; the view stays.";
    }
    return "";
}

void tip(const Row& row) {
    if (!ui::begin_tip()) return;
    const ProfileKey& key = row.key;
    const ShownUnit unit = shown_unit(key);
    char text[1400], range[96] = "";
    if (key.kind == KeyKind::number || key.kind == KeyKind::whole)
        (void)std::snprintf(range, sizeof range, "Range: %.10g to %.10g%s%s\n", key.least * unit.share,
                            key.most * unit.share, *unit.name != '\0' ? " " : "", unit.name);
    (void)std::snprintf(text, sizeof text, "%s\n\n%s%s%s%s%s", key.about, range,
                        unit.share != 1 ? "Shown in milliseconds; a profile's file has microseconds.\n" : "",
                        rebuilds(key.rebuild), row.idle != nullptr ? "\n\nNo effect now: " : "",
                        row.idle != nullptr ? row.idle : "");
    ImGui::TextUnformatted(text);
    ui::end_tip();
}

// The label, its unit, and what takes a change back.
void draw_label(const Row& row) {
    const double saved = row.key.get(row.state.document.saved());
    const bool changed = row.value != saved;
    ImGui::AlignTextToFramePadding();
    if (changed) ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
    ImGui::TextUnformatted(row.key.label);
    if (changed) ImGui::PopStyleColor();
    tip(row);
    const char* const unit = shown_unit(row.key).name;
    if (*unit != '\0' && strcasecmp(unit, row.key.label) != 0) {
        ImGui::SameLine();
        ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
        ImGui::TextUnformatted(unit);
        ImGui::PopStyleColor();
    }
    if (!changed) return;
    const ImGuiStyle& style = ImGui::GetStyle();
    const float width = ImGui::CalcTextSize("reset").x + 2 * style.FramePadding.x;
    ImGui::SameLine(ImGui::GetContentRegionMax().x - width);
    if (ImGui::Button("reset")) row.commands.push(SetKey{&row.key, saved, false});
    ui::mark("reset", row.name);
    if (!ui::begin_tip()) return;
    char was[64], text[96];
    write_value(row.key, saved, was, sizeof was);
    const bool choice = row.key.kind == KeyKind::choice;
    (void)std::snprintf(text, sizeof text, "Reset to the saved value: %s",
                        choice ? row.key.choices[static_cast<std::size_t>(saved)] : was);
    ImGui::TextUnformatted(text);
    ui::end_tip();
}

void draw_field(Row& row) {
    char text[48];
    write_value(row.key, row.value, text, sizeof text);
    const bool wrong = row.typing.key == &row.key && row.typing.wrong;
    if (wrong) ImGui::PushStyleColor(ImGuiCol_FrameBg, ImVec4(0.45F, 0.12F, 0.11F, 1));
    ImGui::SetNextItemWidth(-1);
    const bool entered = ImGui::InputText("##field", text, sizeof text,
                                          ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    if (wrong) ImGui::PopStyleColor();
    ui::mark("field", row.name);
    double typed = row.value;
    const bool read = typed_value(row.key, text, typed);
    if (ImGui::IsItemActive())
        row.typing = {&row.key, !read || typed < row.key.least || typed > row.key.most};
    else if (row.typing.key == &row.key)
        row.typing = {};
    if (entered && read) row.commands.push(SetKey{&row.key, typed, false});
    tip(row);
}

void draw_slider(Row& row) {
    const float field = field_px * static_cast<float>(row.state.interface.scale);
    auto share = static_cast<float>(slider_share(row.key, row.value));
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - field - ImGui::GetStyle().ItemSpacing.x);
    const bool moved =
        ImGui::SliderFloat("##slider", &share, 0, 1, "", ImGuiSliderFlags_NoInput | ImGuiSliderFlags_NoRoundToFormat);
    const bool ctrl = ImGui::GetIO().KeyCtrl; // which asks for the field instead
    if (moved && !ctrl) {
        const double value = slider_value(row.key, static_cast<double>(share));
        if (value != row.value) row.commands.push(SetKey{&row.key, value, true});
    }
    if (ImGui::IsItemDeactivated()) row.commands.push(SetKey{&row.key, row.value, false});
    const bool type = ctrl && ImGui::IsItemClicked();
    ui::mark(row.key.table, row.key.name);
    tip(row);
    ImGui::SameLine();
    if (type) ImGui::SetKeyboardFocusHere();
    draw_field(row);
}

void draw_choices(const Row& row) {
    const auto count = static_cast<int>(row.key.choices.size());
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    const float width =
        (ImGui::GetContentRegionAvail().x - gap * static_cast<float>(count - 1)) / static_cast<float>(count);
    for (int i = 0; i < count; ++i) {
        if (i != 0) ImGui::SameLine(0, gap);
        const bool on = static_cast<int>(row.value) == i;
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ImGui::Button(row.key.choices[static_cast<std::size_t>(i)], {width, 0}) && !on)
            row.commands.push(SetKey{&row.key, static_cast<double>(i), false});
        if (!on) ImGui::PopStyleColor();
        ui::mark(row.name, row.key.choices[static_cast<std::size_t>(i)]);
        tip(row);
    }
}

void draw_flag(const Row& row) {
    bool on = row.value != 0;
    if (ImGui::Checkbox(on ? "on" : "off", &on)) row.commands.push(SetKey{&row.key, on ? 1.0 : 0.0, false});
    ui::mark(row.key.table, row.key.name);
    tip(row);
}

// What it costs now, and what the compared profile has instead.
void draw_notes(const Row& row, const char* said) {
    char text[160];
    ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
    ImGui::PushTextWrapPos(0);
    const bool says = row.idle != nullptr && row.idle != said;
    if (says) (void)std::snprintf(text, sizeof text, "No effect: %s.", row.idle);
    if (says || (row.idle == nullptr && row.state.scene.open() && cost_text(row.key, row.state, text, sizeof text)))
        ui::wrapped(text);
    ImGui::PopStyleColor();
    const Profile* const compared = row.state.document.compared();
    if (compared != nullptr && row.key.get(*compared) != row.value) {
        const double theirs = row.key.get(*compared);
        write_value(row.key, theirs, text, sizeof text);
        const bool choice = row.key.kind == KeyKind::choice, flag = row.key.kind == KeyKind::flag;
        ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.55F, 0.74F, 0.95F, 1));
        ImGui::Text("compared: %s", choice ? row.key.choices[static_cast<std::size_t>(theirs)]
                                    : flag ? (theirs != 0 ? "on" : "off")
                                           : text);
        ImGui::PopStyleColor();
    }
    ImGui::PopTextWrapPos();
}

// Returns why it has no effect; said: that of the key above, which need not be said again.
const char* draw_key(const ProfileKey& key, const State& state, TypingField& typing, Commands& commands,
                     const char* said = nullptr) {
    Row row(key, state, typing, commands);
    ImGui::PushID(&key);
    ImGui::BeginDisabled(row.idle != nullptr);
    draw_label(row);
    switch (key.kind) {
    case KeyKind::number:
    case KeyKind::whole: draw_slider(row); break;
    case KeyKind::flag: draw_flag(row); break;
    case KeyKind::choice: draw_choices(row); break;
    }
    draw_notes(row, said);
    ImGui::EndDisabled();
    ImGui::PopID();
    ImGui::Spacing();
    return row.idle;
}

// Whether each word of what is looked for begins, or is in, one of the texts; in small letters or large.
bool matches(const char* wanted, std::initializer_list<const char*> texts) {
    for (const char* at = wanted; *at != '\0';) {
        char word[sizeof PanelState::search];
        std::size_t n = 0;
        while (*at == ' ') ++at;
        while (*at != ' ' && *at != '\0') word[n++] = *at++;
        word[n] = '\0';
        if (!std::ranges::any_of(texts, [&](const char* text) { return strcasestr(text, word) != nullptr; }))
            return false;
    }
    return true;
}

} // namespace

void draw_profile_keys(Group group, const State& state, PanelState& own, Commands& commands) {
    const char* idle = nullptr;
    for (const ProfileKey& key : profile_keys())
        if (group_of(key) == group) idle = draw_key(key, state, own.typing, commands, idle);
}

// --- Search, over the profile's keys and over all groups.

bool draw_search(const State& state, PanelState& own, Commands& commands) {
    if (std::exchange(own.search_begins, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-FLT_MIN);
    ImGui::InputTextWithHint("##search", "Search all settings (Ctrl+F)", own.search, sizeof own.search,
                             ImGuiInputTextFlags_AutoSelectAll);
    ui::control("tune", "search", "Part of a name, of a key, or of what it does. Empty: all groups.");
    ImGui::Spacing();
    const char* const wanted = own.search + std::strspn(own.search, " ");
    if (*wanted == '\0') return false;
    bool found = false;
    for (std::size_t i = 0; i < groups; ++i) {
        const GroupName& group = group_names[i];
        bool any = false;
        for (const ProfileKey& key : profile_keys()) {
            if (group_of(key) != static_cast<Group>(i) ||
                !matches(wanted, {key.label, key.table, key.name, key.about, group.label}))
                continue;
            if (!std::exchange(any, true)) ui::heading(group.label);
            (void)draw_key(key, state, own.typing, commands);
        }
        found = found || any;
        if (any || group.panel == Panel::tune || !matches(wanted, {group.label, title_of(group.panel)})) continue;
        found = true;
        char text[64];
        (void)std::snprintf(text, sizeof text, "%s > %s", title_of(group.panel), group.label);
        if (ImGui::Selectable(text)) commands.push(ShowGroup{static_cast<Group>(i), true});
        ui::control("found", group.name, "Unfolds this group in its panel.");
    }
    if (!found) ui::note("Nothing of that name.");
    return true;
}

// --- Light at once.

void draw_light_presets(const State& state, PanelState&, Commands& commands) {
    constexpr const char *labels[] = {"Relief", "Morning", "Noon", "Evening", "Dusk", "Haze"},
                         *abouts[] = {"The sun from the upper left, in clear air: relief is read as on a map.",
                                      "A low sun in the east, a clear day.",
                                      "A high sun in the south, a clear day.",
                                      "A low sun in the west, and warm light.",
                                      "The sun below the horizon: the sky alone gives light.",
                                      "A high sun in thick air."};
    static_assert(std::size(labels) == std::size(light_preset_names), "a preset was added: say what it is");
    const Profile& profile = state.document.profile();
    for (std::size_t i = 0; i < std::size(labels); ++i) {
        if (i > 0) ui::beside(labels[i]);
        const auto preset = static_cast<LightPreset>(i);
        const bool on = same(profile, with_light(profile, preset));
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ImGui::Button(labels[i])) commands.push(SetLight{preset});
        ui::control("light", light_preset_names[i], abouts[i]);
        if (!on) ImGui::PopStyleColor();
    }
}

namespace {

void draw_shares(const State& state) {
    const auto shares = state.materials.under.all();
    if (shares.empty()) return;
    ui::heading("Under the camera");
    for (const GroundShares::Share& s : shares) ui::row(s.name.c_str(), "%.0f%%", 100 * s.share);
}

} // namespace

void draw_materials(const State& state, PanelState& own, Commands& commands) {
    const MaterialsInUse& in_use = state.materials;
    const bool can = state.scene.open() && !state.job.running;
    const auto button = [&](const char* label, const char* name, bool on, const ChooseMaterials& choice,
                            const char* about) {
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ui::panel_button(label, "materials", name, can, about)) commands.push(choice);
        if (!on) ImGui::PopStyleColor();
    };
    if (state.scene.splat && in_use.materials.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
        ImGui::TextWrapped("This pack says which materials lie where. Choose what they are drawn with.");
        ImGui::PopStyleColor();
        ui::mark("materials", "missing");
    }
    button("None", "none", in_use.materials.empty(), {}, "The ground as it was baked.");
    ui::beside("Built-in");
    button(
        "Built-in", built_in_materials, in_use.materials == built_in_materials, {built_in_materials, in_use.rules},
        "Rock, scree, gravel, soil, sand, grass, forest floor, snow and ice. Baked at their first use, in a minute.");
    ui::beside("File...");
    if (ui::panel_button("File...", "materials", "file", can,
                         "A file that fjell-bake materials has made, or one of rules. Or drop it onto the window."))
        commands.push(ShowDialog{Dialog::open_file});
    if (!in_use.materials.empty() && in_use.materials != built_in_materials) ui::path_text(in_use.materials);
    if (!in_use.materials.empty() && !(state.scene.splat && state.document.profile().layers.splat)) {
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted("Rules");
        for (const char* rules : built_in_rules) {
            ui::beside(rules);
            button(rules, rules, in_use.rules == rules, {in_use.materials, rules}, "Where each material lies.");
        }
        const bool own_file = std::ranges::find(built_in_rules, in_use.rules) == std::end(built_in_rules);
        if (own_file && !in_use.rules.empty()) ui::path_text(in_use.rules);
        if (in_use.rules.empty()) ui::note("This pack has no splat maps: without rules no material lies anywhere.");
    }
    if (fields::runs(state, JobKind::materials)) ui::note("The built-in materials are being baked.");
    draw_shares(state);
    draw_profile_keys(Group::light_materials, state, own, commands);
}

} // namespace fjell::editor
