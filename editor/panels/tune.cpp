#include <cmath>

#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void draw_key(const fly::ProfileKey& key, const State& state, Commands& commands) {
    ImGui::PushID(&key);
    const fly::Profile& profile = state.document.profile();
    auto value = key.get(profile);
    ImGui::TextUnformatted(key.label);
    ui::tip(key.about);
    ImGui::SetNextItemWidth(-1);
    const ImGuiSliderFlags flags = key.logarithmic ? ImGuiSliderFlags_Logarithmic : 0;
    if (ImGui::SliderScalar("##slider", ImGuiDataType_Double, &value, &key.least, &key.most,
                            key.kind == fly::KeyKind::number ? "%.3f" : "%.0f", flags))
        commands.push(SetKey{&key, value, ImGui::IsItemActive()});
    if (ImGui::IsItemDeactivated()) commands.push(SetKey{&key, key.get(profile), false});
    ui::mark(key.table, key.name);
    ImGui::PopID();
}

} // namespace

void draw_tune(const State& state, Commands& commands) {
    for (const fly::ProfileKey& key : fly::profile_keys()) draw_key(key, state, commands);
}

} // namespace fjell::editor
