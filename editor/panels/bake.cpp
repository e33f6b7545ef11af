// The dialog that bakes: its form on the left, on the right what was found in the files, and below what will happen;
// the file browser over it; and the question that a pack asks when it is ready.
#include <algorithm>
#include <cstdio>
#include <string>

#include "editor/panels/bake_form.h"
#include "editor/panels/fields.h"
#include "editor/panels/file_browser.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void draw_browser(bake_dialog::Form& form, const State& state, Commands& commands) {
    if (form.browsing == BakeField::none) return;
    constexpr const char* title = "Choose a file";
    if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    const float em = ImGui::GetFontSize();
    const keyboard::TabStops no_title(false); // its list brings its own
    const ImVec2 display = ImGui::GetIO().DisplaySize, from = ImGui::GetWindowPos();
    ImGui::SetNextWindowPos({std::min(from.x + 2 * em, 0.1F * display.x), from.y + 2 * em}, ImGuiCond_Appearing);
    ImGui::SetNextWindowSize({std::min(44 * em, 0.9F * display.x), std::min(30 * em, display.y - from.y - 3 * em)});
    bool open = true;
    if (!ImGui::BeginPopupModal(title, &open, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) return;
    form.browser.nested = true;
    const bool output = form.browsing == BakeField::output;
    begin_file_browser(form.browser, state, output ? bake_dialog::name_in(state.bake.pack.output) : "");
    const bool chosen = [&] { // ImGui wants what is pushed within a window popped within it
        const keyboard::TabStops stops;
        return draw_file_browser(state, commands, form.browser, "Choose");
    }();
    if (chosen) {
        commands.push(
            GiveBakeFile{state.files.browser.path_of(form.browser.name), form.browsing, form.browsing_another});
        open = false;
    }
    if (!open || form.browser.cancelled || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) {
        form.browsing = BakeField::none;
        form.browser = {};
        ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
}

void start(bake_dialog::Form& form, const State& state, Commands& commands) {
    BakePack pack = bake_dialog::pack_of(form);
    pack.asks = state.scene.open();
    commands.push(std::move(pack));
}

} // namespace

void draw_bake(const State& state, Commands& commands) {
    static bake_dialog::Form form;
    const BakeDraft& draft = state.bake;
    if (form.given != draft.given) bake_dialog::load(form, draft);
    if (!form.output_is_chosen && draft.pack.output != form.output) {
        fields::copy(form.output, draft.pack.output);
        form.sent.output = draft.pack.output;
    }
    if (ImGui::BeginTable("bake", 2, ImGuiTableFlags_None)) {
        ImGui::TableSetupColumn("form", ImGuiTableColumnFlags_WidthStretch, 1.7F);
        ImGui::TableSetupColumn("facts", ImGuiTableColumnFlags_WidthStretch, 1);
        ImGui::TableNextColumn();
        bake_dialog::draw_form(form, state, commands);
        ImGui::TableNextColumn();
        bake_dialog::draw_facts(draft);
        ImGui::EndTable();
    }
    if (BakePack now = bake_dialog::pack_of(form); !(now == form.sent)) {
        form.sent = now;
        commands.push(DraftBake{std::move(now), form.output_is_chosen});
    }
    ImGui::Separator();
    // The buttons stay where they are, whatever is said.
    const float top = ImGui::GetCursorPosY();
    bake_dialog::draw_plan(state);
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), top + 3.4F * ImGui::GetTextLineHeightWithSpacing()));
    const bool can = !state.job.running && form.input[0] != '\0' && draft.output_problem.empty() &&
                     (draft.looking || draft.facts.problem.empty());
    if (fields::button("Bake", "bake", "start", can, "Bakes in the background with 512 MB of memory (Enter).", true)) {
        if (draft.output_exists) {
            (void)std::snprintf(form.overwrite.name, sizeof form.overwrite.name, "%.500s",
                                bake_dialog::name_in(form.output));
            form.overwrite.asks = true;
        } else {
            start(form, state, commands);
        }
    }
    fields::close("bake", commands);
    if (fields::runs(state, JobKind::bake)) fields::cancel("bake", commands);
    fields::outcome(state, JobKind::bake, true);
    if (draw_overwrite(form.overwrite)) start(form, state, commands);
    draw_browser(form, state, commands);
}

void draw_baked(const State& state, Commands& commands) {
    ImGui::TextWrapped("%s is ready. Fly it, and leave %s?", bake_dialog::name_in(state.bake.ready),
                       bake_dialog::name_in(state.scene.path));
    ImGui::Spacing();
    if (ui::button("Fly it", true)) commands.push(OpenBaked{true});
    ui::mark("baked", "open");
    ImGui::SameLine();
    if (ui::button("Not now")) commands.push(OpenBaked{false});
    ui::mark("baked", "stay");
    ui::tip("The pack stays on the disk: open it with File > Open.");
}

} // namespace fjell::editor
