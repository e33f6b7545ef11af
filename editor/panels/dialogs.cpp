// Dialogs of files and unsaved changes, the list of keys, all messages, and the window that each dialog has.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <imgui_internal.h> // ClosePopupToLevel: the state closes a dialog, not only its own buttons

#include "editor/number_text.h"
#include "editor/panels/forms.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

// As wide as the longest of some, so that they stand in a column.
bool wide_button(const char* label, const char* name) {
    const bool pressed = ImGui::Button(label, {13 * ImGui::GetFontSize(), 0});
    ui::mark("start", name);
    return pressed;
}

bool exists(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
}

// What is opened again is told by it.
void add_extension(FileBrowserForm& form, const char* extension) {
    const std::size_t length = std::strlen(form.name), added = std::strlen(extension);
    if (length >= added && std::strcmp(form.name + length - added, extension) == 0) return;
    if (length + added < sizeof form.name) std::memcpy(form.name + length, extension, added + 1);
}

// Saving under a name; file: the one it came from, which is overwritten without a word. True: at that name, now.
bool save_as(FileBrowserForm& form, const State& state, Commands& commands, const std::string& file,
             const char* otherwise, const char* extension) {
    begin_file_browser(form, state, file.empty() ? otherwise : file_name(file));
    if (draw_file_browser(state, commands, form, "Save")) {
        add_extension(form, extension);
        const std::string path = state.files.browser.path_of(form.name);
        form.asks = exists(path) && path != file;
        if (!form.asks) return true;
    }
    return draw_overwrite(form);
}

void draw_sample_progress(const State& state, Commands& commands) {
    const JobView& job = state.job;
    if (job.kind != JobKind::bake || !job.running) return;
    ImGui::Spacing();
    ImGui::ProgressBar(static_cast<float>(job.share), {-1, 0}, job.stage.c_str());
    if (ImGui::Button("Cancel")) commands.push(CancelJob{});
    ui::mark("start", "cancel");
}

void draw_recent_packs(const State& state, Commands& commands) {
    ui::heading("Recent packs");
    if (state.interface.recent.empty()) ImGui::TextDisabled("None yet.");
    for (const std::string& pack : state.interface.recent) {
        ui::need_glyphs(pack);
        ImGui::PushID(&pack);
        if (ImGui::Selectable(file_name(pack))) commands.push(OpenFile{pack});
        ImGui::PopID();
        ui::control("recent", file_name(pack), pack.c_str());
    }
}

void draw_differences(const State& state, Commands& commands) {
    ImGui::TextWrapped("Compared with %s: %zu keys differ.",
                       state.document.compared_path().empty() ? "the saved profile"
                                                              : state.document.compared_path().c_str(),
                       state.files.differences.size());
    const float below = ImGui::GetFrameHeightWithSpacing();
    const float height = std::max(ImGui::GetContentRegionAvail().y - below, 3 * below);
    constexpr ImGuiTableFlags flags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersOuter | ImGuiTableFlags_RowBg;
    if (!ImGui::BeginTable("differences", 4, flags, {0, height})) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("Key", ImGuiTableColumnFlags_WidthStretch, 2);
    ImGui::TableSetupColumn("Mine", ImGuiTableColumnFlags_WidthStretch, 1.2F);
    ImGui::TableSetupColumn("Theirs", ImGuiTableColumnFlags_WidthStretch, 1.2F);
    ImGui::TableSetupColumn("##take", ImGuiTableColumnFlags_WidthFixed, ImGui::CalcTextSize("Take theirs   ").x);
    ImGui::TableHeadersRow();
    for (const Difference& d : state.files.differences) {
        char name[64];
        (void)std::snprintf(name, sizeof name, "%s.%s", d.key->table, d.key->name);
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(name);
        ui::tip(d.key->about);
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(d.mine.c_str());
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(d.theirs.c_str());
        ImGui::TableNextColumn();
        ImGui::PushID(d.key);
        if (ImGui::SmallButton("Take theirs")) commands.push(SetKey{d.key, d.theirs_value, false});
        ui::mark("take", name);
        ImGui::PopID();
    }
    ImGui::EndTable();
}

// The answers stand in one line at the bottom of what they answer.
bool answer(const char* label, const char* name, bool first) {
    if (!first) ImGui::SameLine();
    const bool pressed = ui::button(label, first); // the first one loses nothing
    ui::mark("answer", name);
    return pressed;
}

} // namespace

void draw_start(const State& state, PanelState&, Commands& commands) {
    ImGui::TextWrapped("Fjell draws large terrains with a bounded screen-space error. This editor tunes its thresholds "
                       "and budgets, by eye and by number.");
    ImGui::Spacing();
    if (wide_button("Open the sample", "sample")) commands.push(OpenSample{});
    ui::tip("A small synthetic landscape. It is baked when first used, which takes a few seconds.");
    if (wide_button("Open a file...", "open")) commands.push(ShowDialog{Dialog::open_file});
    ui::tip("A pack (.fjell), a profile, or heights to be baked, in any format that GDAL reads.");
    if (wide_button("Bake heights...", "bake")) commands.push(ShowDialog{Dialog::bake});
    ui::tip("Makes a pack from a DEM: GeoTIFF, PNG, ASCII grid or any other format that GDAL reads.");
    ImGui::TextDisabled("Or drop a file onto the window.");
    draw_sample_progress(state, commands);
    draw_recent_packs(state, commands);
}

void draw_open_file(const State& state, PanelState& own, Commands& commands) {
    begin_file_browser(own.browser, state, "");
    if (draw_file_browser(state, commands, own.browser, "Open"))
        commands.push(OpenFile{state.files.browser.path_of(own.browser.name)});
}

void draw_save_profile(const State& state, PanelState& own, Commands& commands) {
    if (save_as(own.browser, state, commands, state.document.path(), "profile.toml", ".toml"))
        commands.push(SaveProfile{state.files.browser.path_of(own.browser.name)});
}

void draw_save_path(const State& state, PanelState& own, Commands& commands) {
    if (save_as(own.browser, state, commands, state.route.path(), "path.json", ".json"))
        commands.push(SavePath{state.files.browser.path_of(own.browser.name)});
}

void draw_compare(const State& state, PanelState& own, Commands& commands) {
    if (state.document.compared() == nullptr) {
        begin_file_browser(own.browser, state, "");
        if (ui::button("With the saved profile")) commands.push(CompareProfile{});
        ui::mark("compare", "saved");
        ImGui::SameLine();
        ImGui::TextUnformatted("or with another profile:");
        if (draw_file_browser(state, commands, own.browser, "Compare"))
            commands.push(CompareProfile{state.files.browser.path_of(own.browser.name)});
        return;
    }
    draw_differences(state, commands);
    if (ui::button("Compare another")) commands.push(StopComparing{});
    ui::control("compare", "another", "Compares with another profile.");
    ImGui::SameLine();
    if (ui::button("Stop comparing")) {
        commands.push(StopComparing{});
        commands.push(ShowDialog{Dialog::none});
    }
    ui::mark("compare", "off");
    ImGui::SameLine();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::control("compare", "close", "The other profile's values stay visible in the Tune panel.");
}

void draw_unsaved(const State& state, PanelState&, Commands& commands) {
    if (state.document.unsaved())
        ImGui::TextWrapped("The profile has unsaved changes: %s.",
                           state.document.path().empty() ? "it has no file yet" : state.document.path().c_str());
    if (state.route.unsaved())
        ImGui::TextWrapped("The camera path has unsaved changes: %s.",
                           state.route.path().empty() ? "it has no file yet" : state.route.path().c_str());
    ImGui::Spacing();
    ImGui::BeginDisabled(!state.files.waiting);
    if (answer("Save", "save", true)) commands.push(AnswerUnsaved{Answer::save});
    if (answer("Discard", "discard", false)) commands.push(AnswerUnsaved{Answer::discard});
    ImGui::EndDisabled();
    if (answer("Cancel", "cancel", false)) commands.push(ShowDialog{Dialog::none});
}

void draw_recover(const State& state, PanelState&, Commands& commands) {
    const std::optional<Unsaved>& found = state.files.recovery.found();
    if (!found) {
        ImGui::TextWrapped("There is nothing to recover.");
        if (answer("Close", "close", true)) commands.push(ShowDialog{Dialog::none});
        return;
    }
    ImGui::TextWrapped("The editor ended before these changes were saved.");
    if (found->profile_changed)
        ImGui::BulletText("of the profile %s", found->path.empty() ? "that had no file yet" : file_name(found->path));
    if (!found->points.empty()) ImGui::BulletText("a camera path of %zu points", found->points.size());
    if (!found->pack.empty()) ImGui::BulletText("over %s", file_name(found->pack));
    ImGui::Spacing();
    if (answer("Restore", "restore", true)) commands.push(RecoverChanges{true});
    if (answer("Discard", "discard", false)) commands.push(RecoverChanges{false});
    ImGui::SameLine();
    ImGui::TextDisabled("close this dialog to be asked again next time");
}

// --- Keys, and all messages.

namespace {

struct Key {
    const char *keys, *what; // what null: a heading
};
constexpr Key all_keys[] = {
    {"Camera", nullptr},
    {"W S, A D", "fly forwards and back, left and right; in orbit: pan"},
    {"E Q", "up and down"},
    {"Shift", "five times as fast"},
    {"Arrows, left drag", "look around; in orbit: turn around the centre"},
    {"Wheel", "speed; in orbit: zoom"},
    {"Right drag, Shift+drag", "in orbit: pan"},
    {"1  2  3", "fly, orbit, follow the path"},
    {"Home", "look at the whole terrain"},
    {"Click on the overview", "fly there, at the same height above the ground"},
    {"F", "freeze refinement, to look at the mesh from elsewhere"},
    {"Camera path", nullptr},
    {"R", "record the flight; again: stop recording"},
    {"N", "add a point where the camera is"},
    {"Insert  Delete", "add a point where the path is being played; remove the selected point"},
    {"Left drag on a point", "move it, in the picture (Shift: up and down) or on the overview; a click selects it"},
    {"Arrows on the timeline", "select a point; Enter: look from there; Insert, Delete"},
    {"P", "play; again: pause"},
    {"Picture", nullptr},
    {"M, Shift+M", "next and previous picture mode"},
    {"G", "wireframe"},
    {"L and left drag", "the sun: across its azimuth, up and down its elevation"},
    {"I", "probe the ground under the pointer, or where the camera looks; a click or Enter marks a place, others "
          "measure from there: distance and area; Backspace: remove the last, with Shift all"},
    {"B", "take a brush to the ground, or put it away; left drag: brush, right drag: look around, wheel: its size"},
    {"T", "pause graphs and times; again: go on"},
    {"Window", nullptr},
    {"Tab", "hide the panels, or show them"},
    {"F11", "the picture alone; again or Esc: all of it"},
    {"F6", "move in the panels by keys: Tab and arrows move, Enter presses, Space changes a value; again: the next "
           "panel, after the last one the camera; Shift+F6: the one before; Esc: the camera"},
    {"Ctrl+Page Up, Page Down", "turn to the panel before or after"},
    {"Ctrl+Tab and arrows", "with F6: move a floating panel; with Shift: resize it"},
    {"F10, Alt+F, Alt+E, ...",
     "the first menu; again: the next one; Alt and its first letter: any; arrows move, Enter chooses"},
    {"Enter, Esc", "in a dialog: its main button, or close it"},
    {"Profile and program", nullptr},
    {"[  ]", "lower, raise the threshold"},
    {"Ctrl+Z, Ctrl+Shift+Z", "undo, redo"},
    {"Ctrl+F", "search the settings"},
    {"Ctrl+O", "open a pack, a DEM, a profile or a camera path"},
    {"Ctrl+S", "save the profile"},
    {"Ctrl+click on a slider", "type a value"},
    {"Page Up, Page Down", "scroll this list"},
    {"F1", "this list of keys"},
    {"Ctrl+Q", "quit"},
};

// Arrows stay the camera's beside these lists.
void scroll_by_keys() {
    constexpr ImGuiKey keys[] = {ImGuiKey_PageUp, ImGuiKey_PageDown};
    for (int i = 0; i < 2; ++i)
        if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(keys[i])))
            ImGui::SetScrollY(ImGui::GetScrollY() + (i == 0 ? -0.9F : 0.9F) * ImGui::GetWindowHeight());
}

} // namespace

void draw_keys(const State&, PanelState&, Commands& commands) {
    ImGui::BeginChild("list", {0, -ImGui::GetFrameHeightWithSpacing()});
    scroll_by_keys();
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed,
                                ImGui::CalcTextSize("Arrows on the timeline").x + ImGui::GetFontSize());
        ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthStretch);
        for (const Key& key : all_keys) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            if (key.what == nullptr) {
                ImGui::Spacing();
                ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "%s", key.keys);
                continue;
            }
            ImGui::TextUnformatted(key.keys);
            ImGui::TableNextColumn();
            ImGui::TextWrapped("%s", key.what);
        }
        ImGui::EndTable();
    }
    ImGui::EndChild();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("keys", "close");
}

void draw_messages(const State& state, PanelState& own, Commands& commands) {
    // As high as they are, as far as the button stays in the window.
    float& list_height = own.messages_height;
    const float line = ImGui::GetTextLineHeight();
    const float below = ImGui::GetFrameHeightWithSpacing() + 2 * ImGui::GetStyle().WindowPadding.y;
    const float room = 0.98F * ImGui::GetIO().DisplaySize.y - ImGui::GetCursorScreenPos().y - below;
    ImGui::BeginChild("list", {0, std::max(std::min({list_height, 24 * line, room}), 3 * line)});
    scroll_by_keys();
    if (state.messages.all.empty()) ImGui::TextUnformatted("No messages yet.");
    for (auto message = state.messages.all.rbegin(); message != state.messages.all.rend(); ++message) {
        ui::need_glyphs(message->text);
        const int seconds = static_cast<int>(message->at_s);
        char time[24];
        std::snprintf(time, sizeof time, "%d:%02d", seconds / 60, seconds % 60);
        ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "%s", time);
        ImGui::SameLine(4 * ImGui::GetFontSize());
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::ColorConvertU32ToFloat4(ui::severity_colour(message->severity)));
        ImGui::PushTextWrapPos(0);
        ImGui::TextUnformatted(message->text.c_str());
        if (message->times > 1) ImGui::Text("(%u times)", message->times);
        ImGui::PopTextWrapPos();
        ImGui::PopStyleColor();
    }
    list_height = ImGui::GetCursorPosY();
    ImGui::EndChild();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("messages", "close");
}

// --- The one that is open.

namespace {

struct Window {
    const char* title;
    double width, height; // unscaled pixels; height 0: as its content
    void (*draw)(const State&, PanelState&, Commands&);
};
constexpr Window windows[] = {
    {"", 0, 0, nullptr},
    {"Welcome to Fjell", 560, 0, draw_start},
    {"Open", 640, 460, draw_open_file},
    {"Save profile", 640, 460, draw_save_profile},
    {"Save camera path", 640, 460, draw_save_path},
    {"Compare profiles", 640, 460, draw_compare},
    {"Bake", 820, 0, draw_bake},
    {"Export glTF", 520, 0, draw_snapshot},
    {"Screenshot", 520, 0, draw_screenshot},
    {"Keys", 560, 600, draw_keys},
    {"Messages", 640, 0, draw_messages},
    {"Unsaved changes", 480, 0, draw_unsaved},
    {"Recovered changes", 480, 0, draw_recover},
    {"The pack is ready", 480, 0, draw_baked},
};
static_assert(std::size(windows) == dialogs, "a dialog was added: add its window");

constexpr ImGuiWindowFlags dialog_flags =
    ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;
constexpr float top_share = 0.12F; // of the window, above a dialog

// Escape belongs to a list that is dropped down first, then to what has been typed.
bool escapes(const DialogBefore& before, const State& state) {
    const bool typed = before.typing && state.input.characters != before.characters;
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false) && !before.list && !typed;
}

// Where it is stays the user's affair once it is open: its top is fixed, and what it says grows downwards.
void place(const Window& window, const DialogBefore& before, const State& state) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const bool opens = before.dialog != state.interface.dialog || before.scale != state.interface.scale ||
                       before.display.x != display.x || before.display.y != display.y;
    const auto fit = [&](double unscaled, float most) {
        return std::min(static_cast<float>(unscaled * state.interface.scale), 0.96F * most);
    };
    const float width = fit(window.width, display.x), height = fit(window.height, display.y);
    const float top = std::max(std::min(top_share * display.y, (display.y - height) / 2), 0.0F);
    ImGui::SetNextWindowPos({(display.x - width) / 2, top}, opens ? ImGuiCond_Always : ImGuiCond_Appearing);
    ImGui::SetNextWindowSize({width, height}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({0, 0}, {display.x, 0.98F * display.y - top});
}

} // namespace

void draw_dialog(const State& state, PanelState& own, Commands& commands) {
    DialogBefore& before = own.dialog;
    const Dialog dialog = state.interface.dialog;
    const Window& window = windows[static_cast<std::size_t>(dialog)];
    const bool modal = is_modal(dialog);
    const auto is_open = [](Dialog d) { return ImGui::IsPopupOpen(windows[static_cast<std::size_t>(d)].title); };
    if (before.dialog != dialog && is_modal(before.dialog) && is_open(before.dialog)) ImGui::ClosePopupToLevel(0, true);
    if (dialog == Dialog::none) {
        before.dialog = dialog;
        return;
    }
    place(window, before, state);
    bool open = true;
    if (modal && !is_open(dialog)) ImGui::OpenPopup(window.title);
    if (modal ? !ImGui::BeginPopupModal(window.title, &open, dialog_flags)
              : !ImGui::Begin(window.title, &open, dialog_flags)) {
        if (!modal) ImGui::End();
        return;
    }
    const bool escaped = escapes(before, state);
    if (ImGui::IsWindowAppearing()) keyboard::show_focus();
    {
        const keyboard::TabStops stops;
        window.draw(state, own, commands);
    }
    const bool list = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId), active = ImGui::IsAnyItemActive();
    before = {dialog,
              ImGui::GetIO().DisplaySize,
              state.interface.scale,
              list,
              active,
              active && before.typing ? before.characters : state.input.characters};
    if (modal)
        ImGui::EndPopup();
    else
        ImGui::End();
    if (!open || escaped) commands.push(ShowDialog{Dialog::none});
}

} // namespace fjell::editor
