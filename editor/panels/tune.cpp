#include <cstdio>
#include <cstring>

#include <strings.h>

#include "editor/panels/panels.h"
#include "editor/panels/slider.h"
#include "editor/panels/tune_cost.h"

namespace fjell::editor {

namespace {

constexpr float field_px = 106; // unscaled; ten digits

// The field that is being typed into, and whether what is there so far is no value: it turns red.
struct TypingField {
    const flight::ProfileKey* key = nullptr;
    bool wrong = false;
};
TypingField typing;

struct Row {
    const flight::ProfileKey& key;
    const State& state;
    Commands& commands;
    char name[64] = {}; // refine.error_px
    double value = 0;
    const char* idle = nullptr; // why it does not count now

    Row(const flight::ProfileKey& k, const State& s, Commands& c) : key(k), state(s), commands(c) {
        (void)std::snprintf(name, sizeof name, "%s.%s", key.table, key.name);
        value = key.get(state.document.profile());
        idle = why_idle(key, state);
    }
};

const char* rebuilds(flight::Rebuild rebuild) {
    switch (rebuild) {
    case flight::Rebuild::nothing: return "A change takes effect in the next frame.";
    case flight::Rebuild::method: return "A change reallocates the method's memory.";
    case flight::Rebuild::session: return "A change reopens the pack; the view stays.";
    }
    return "";
}

void tip(const Row& row) {
    if (!ui::begin_tip()) return;
    const flight::ProfileKey& key = row.key;
    const ShownUnit unit = shown_unit(key);
    char text[1400], range[96] = "";
    if (key.kind == flight::KeyKind::number || key.kind == flight::KeyKind::whole)
        (void)std::snprintf(range, sizeof range, "Range: %.10g to %.10g%s%s\n", key.least * unit.share,
                            key.most * unit.share, *unit.name != '\0' ? " " : "", unit.name);
    (void)std::snprintf(text, sizeof text, "%s\n\n%s%s%s%s%s", key.about, range,
                        unit.share != 1 ? "Shown in milliseconds; a profile's file has microseconds.\n" : "",
                        rebuilds(key.rebuild), row.idle != nullptr ? "\n\nNot used now: " : "",
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
    const bool choice = row.key.kind == flight::KeyKind::choice;
    (void)std::snprintf(text, sizeof text, "Reset to the saved value: %s",
                        choice ? row.key.choices[static_cast<std::size_t>(saved)] : was);
    ImGui::TextUnformatted(text);
    ui::end_tip();
}

void draw_field(Row& row) {
    char text[48];
    write_value(row.key, row.value, text, sizeof text);
    const bool wrong = typing.key == &row.key && typing.wrong;
    if (wrong) ImGui::PushStyleColor(ImGuiCol_FrameBg, ImVec4(0.45F, 0.12F, 0.11F, 1));
    ImGui::SetNextItemWidth(-1);
    const bool entered = ImGui::InputText("##field", text, sizeof text,
                                          ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    if (wrong) ImGui::PopStyleColor();
    ui::mark("field", row.name);
    double typed = row.value;
    const bool read = typed_value(row.key, text, typed);
    if (ImGui::IsItemActive())
        typing = {&row.key, !read || typed < row.key.least || typed > row.key.most};
    else if (typing.key == &row.key)
        typing = {};
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
void draw_notes(const Row& row) {
    char text[160];
    ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
    ImGui::PushTextWrapPos(0);
    if (row.idle == nullptr && row.state.scene.open() && cost_text(row.key, row.state, text, sizeof text))
        ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
    const flight::Profile* const compared = row.state.document.compared();
    if (compared != nullptr && row.key.get(*compared) != row.value) {
        const double theirs = row.key.get(*compared);
        write_value(row.key, theirs, text, sizeof text);
        const bool choice = row.key.kind == flight::KeyKind::choice, flag = row.key.kind == flight::KeyKind::flag;
        ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.55F, 0.74F, 0.95F, 1));
        ImGui::Text("compared: %s", choice ? row.key.choices[static_cast<std::size_t>(theirs)]
                                    : flag ? (theirs != 0 ? "on" : "off")
                                           : text);
        ImGui::PopStyleColor();
    }
    ImGui::PopTextWrapPos();
}

void draw_key(const flight::ProfileKey& key, const State& state, Commands& commands) {
    Row row(key, state, commands);
    ImGui::PushID(&key);
    ImGui::BeginDisabled(row.idle != nullptr);
    draw_label(row);
    switch (key.kind) {
    case flight::KeyKind::number:
    case flight::KeyKind::whole: draw_slider(row); break;
    case flight::KeyKind::flag: draw_flag(row); break;
    case flight::KeyKind::choice: draw_choices(row); break;
    }
    draw_notes(row);
    ImGui::EndDisabled();
    ImGui::PopID();
    ImGui::Spacing();
}

} // namespace

void draw_tune(const State& state, Commands& commands) {
    for (const flight::ProfileTable& table : flight::profile_tables()) {
        ui::heading(table.label);
        for (const flight::ProfileKey& key : flight::profile_keys())
            if (std::strcmp(key.table, table.name) == 0) draw_key(key, state, commands);
    }
}

} // namespace fjell::editor
