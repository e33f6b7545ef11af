// Bookmarks, and pictures rendered beside the frame: larger than the window, or one for each frame of the path.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void draw_bookmarks(const State& state, Commands& commands) {
    static char name[61] = "";
    ui::heading("Bookmarks");
    const float add = ImGui::CalcTextSize("Add").x + 2 * ImGui::GetStyle().FramePadding.x;
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - add - ImGui::GetStyle().ItemSpacing.x);
    const bool entered =
        ImGui::InputTextWithHint("##name", "a name, or none", name, sizeof name, ImGuiInputTextFlags_EnterReturnsTrue);
    ui::mark("bookmark", "name");
    ui::tip("What the bookmark is called; without a name it is numbered.");
    ImGui::SameLine();
    if (ImGui::Button("Add") || entered) {
        commands.push(AddBookmark{name});
        name[0] = '\0';
    }
    ui::mark("bookmark", "add");
    ui::tip("Keeps the camera's place.");
    std::size_t index = 0;
    char mark[24];
    for (const Bookmark& b : state.bookmarks.all) {
        if (b.pack != state.bookmarks.pack) continue;
        ImGui::PushID(static_cast<int>(index));
        if (ImGui::SmallButton("x")) commands.push(RemoveBookmark{index});
        std::snprintf(mark, sizeof mark, "remove.%zu", index);
        ui::mark("bookmark", mark);
        ui::tip("Removes this bookmark.");
        ImGui::SameLine();
        if (ImGui::Selectable(b.name.c_str())) commands.push(GoToBookmark{index});
        std::snprintf(mark, sizeof mark, "go.%zu", index);
        ui::mark("bookmark", mark);
        ui::tip("Looks from there.");
        ImGui::PopID();
        ++index;
    }
    if (index == 0) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
        ImGui::TextWrapped("This terrain has none yet.");
        ImGui::PopStyleColor();
    }
}

struct RenderForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText file = "";
    int width = 3840, height = 2160;
};

void draw_render(const State& state, Commands& commands) {
    static RenderForm form;
    ui::heading("Render");
    fields::suggest(form.file, form.made_for, state, ".png");
    fields::path("Picture", "render", "path", form.file, "a file that ends in .png", "Where the PNG is written.");
    fields::whole("Width, px", "render", "width", form.width, "Of the picture; the window's size does not matter.");
    fields::whole("Height, px", "render", "height", form.height, "Of the picture; the window's size does not matter.");
    const bool can =
        !state.job.running && state.scene.open() && form.file[0] != '\0' && form.width >= 16 && form.height >= 16;
    if (fields::button("Render", "render", "start", can,
                       "Draws beside the frames, and holds the threshold in every picture whatever the budgets are. A "
                       "picture wider than the profile's view is refined further, as for a larger screen."))
        commands.push(
            RenderPicture{form.file, static_cast<std::uint32_t>(form.width), static_cast<std::uint32_t>(form.height)});
    if (fields::runs(state, JobKind::picture)) fields::cancel("render", commands);
    fields::outcome(state, JobKind::picture);
}

} // namespace

void draw_pictures(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    draw_bookmarks(state, commands);
    draw_render(state, commands);
}

} // namespace fjell::editor
