// Bookmarks, and pictures rendered beside the frame: larger than the window, or one for each frame of the path.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

// A picture that goes there when it is clicked, with its name below.
void draw_bookmark(const Bookmark& b, std::size_t index, float width, Commands& commands) {
    const float height = width * 9 / 16;
    char name[24];
    ImGui::PushID(static_cast<int>(index));
    ImGui::BeginGroup();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    if (ImGui::InvisibleButton("go", {width, height})) commands.push(GoToBookmark{index});
    std::snprintf(name, sizeof name, "go.%zu", index);
    ui::mark("bookmark", name);
    const bool hovered = ImGui::IsItemHovered();
    (void)keyboard::outline();
    ui::tip(strings::pictures::about_bookmark);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 high{at.x + width, at.y + height};
    if (b.texture != 0) { // cut to the frame's shape, not stretched
        const float aspect =
            static_cast<float>(b.thumbnail.width) / static_cast<float>(std::max(b.thumbnail.height, 1u));
        const float wide = aspect > 16.0F / 9 ? 16.0F / 9 / aspect : 1, tall = aspect < 16.0F / 9 ? aspect * 9 / 16 : 1;
        list.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(b.texture)), at, high,
                      {(1 - wide) / 2, (1 - tall) / 2}, {(1 + wide) / 2, (1 + tall) / 2});
    } else {
        list.AddRectFilled(at, high, IM_COL32(40, 44, 52, 255));
    }
    if (hovered) list.AddRect(at, high, IM_COL32_WHITE);
    if (ImGui::SmallButton("x")) commands.push(RemoveBookmark{index});
    std::snprintf(name, sizeof name, "remove.%zu", index);
    ui::mark("bookmark", name);
    ui::tip(strings::pictures::about_remove);
    ImGui::SameLine();
    const ImVec2 text = ImGui::GetCursorScreenPos();
    ImGui::PushClipRect(text, {high.x, text.y + 2 * ImGui::GetFontSize()}, true);
    ImGui::TextUnformatted(b.name.c_str());
    ImGui::PopClipRect();
    ImGui::EndGroup();
    ImGui::PopID();
}

void draw_bookmarks(const State& state, Commands& commands) {
    static char name[61] = "";
    ui::heading(strings::pictures::bookmarks);
    const float add = ImGui::CalcTextSize(strings::common::add).x + 2 * ImGui::GetStyle().FramePadding.x;
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - add - ImGui::GetStyle().ItemSpacing.x);
    const bool entered = ImGui::InputTextWithHint("##name", strings::pictures::name_hint, name, sizeof name,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ui::mark("bookmark", "name");
    ui::tip(strings::pictures::about_name);
    ImGui::SameLine();
    if (ImGui::Button(strings::common::add) || entered) {
        commands.push(AddBookmark{name});
        name[0] = '\0';
    }
    ui::mark("bookmark", "add");
    ui::tip(strings::pictures::about_add);
    const float gap = ImGui::GetStyle().ItemSpacing.x, room = ImGui::GetContentRegionAvail().x;
    const float width = std::max((room - gap) / 2 - 1, 4 * ImGui::GetFontSize());
    std::size_t index = 0;
    for (const Bookmark& b : state.bookmarks.all) {
        if (b.pack != state.bookmarks.pack) continue;
        if (index % 2 == 1) ImGui::SameLine(0, gap);
        draw_bookmark(b, index++, width, commands);
    }
    if (index == 0) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
        ImGui::TextWrapped(strings::pictures::none_yet);
        ImGui::PopStyleColor();
    }
}

struct RenderForm {
    std::string file_made_for = fields::nothing_yet, folder_made_for = fields::nothing_yet;
    fields::PathText file = "", folder = "";
    int way = 0, width = 3840, height = 2160;
    double fps = 30;
};

void draw_render(const State& state, Commands& commands) {
    static RenderForm form;
    constexpr const char* ways[] = {strings::pictures::this_view, strings::pictures::the_path_frame_by_frame};
    ui::heading(strings::pictures::render);
    fields::suggest(form.file, form.file_made_for, state, ".png");
    fields::suggest(form.folder, form.folder_made_for, state, strings::pictures::frames_suffix);
    fields::choice(strings::pictures::what, "render", "what", form.way, ways, 2, strings::pictures::about_what);
    const bool path = form.way == 1;
    fields::path(path ? strings::pictures::folder : strings::common::picture, "render", "path",
                 path ? form.folder : form.file, path ? strings::pictures::folder_hint : strings::common::png_hint,
                 path ? strings::pictures::about_folder : strings::common::about_png);
    fields::whole(strings::pictures::width_px, "render", "width", form.width, strings::pictures::about_size);
    fields::whole(strings::pictures::height_px, "render", "height", form.height, strings::pictures::about_size);
    if (path) fields::number(strings::pictures::rate, "render", "fps", form.fps, "%.4g", strings::pictures::about_rate);
    if (path && !state.route.empty()) {
        const double count = std::max(std::round(state.route.seconds() * form.fps), 2.0);
        ImGui::TextColored(ImColor(ui::quiet).Value, strings::pictures::length, count_text(count).text,
                           state.route.seconds());
    }
    const bool can = !state.job.running && state.scene.open() && (!path || !state.route.empty()) &&
                     (path ? form.folder : form.file)[0] != '\0' && form.width >= 16 && form.height >= 16;
    if (fields::button(strings::pictures::render, "render", "start", can, strings::pictures::about_render)) {
        RenderPictures r;
        r.path = path ? form.folder : form.file;
        r.way = path ? PictureWay::path : PictureWay::still;
        r.width = static_cast<std::uint32_t>(form.width);
        r.height = static_cast<std::uint32_t>(form.height);
        r.fps = std::clamp(form.fps, 1.0, 240.0);
        commands.push(r);
    }
    if (fields::runs(state, JobKind::pictures)) fields::cancel("render", commands);
    fields::outcome(state, JobKind::pictures);
}

} // namespace

void draw_pictures(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped(strings::common::no_terrain_is_open);
        return;
    }
    draw_bookmarks(state, commands);
    draw_render(state, commands);
}

} // namespace fjell::editor
