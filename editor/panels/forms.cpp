#include "editor/panels/forms.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/ui.h"

namespace fjell::editor::fields {

void copy(PathText& to, const std::string& from) {
    std::snprintf(to, path_bytes, "%s", from.c_str());
}

// The label's column, so that fields begin under each other.
void label(const char* text) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(text);
    ImGui::SameLine(ImGui::GetFontSize() * 9.5F);
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 0.3F);
}

void path(const char* text, const char* group, const char* name, PathText& text_of, const char* hint,
          const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputTextWithHint("##path", hint, text_of, path_bytes);
    ImGui::PopID();
    ui::control(group, name, about);
}

void number(const char* text, const char* group, const char* name, double& value, const char* format,
            const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputDouble("##number", &value, 0, 0, format);
    ImGui::PopID();
    ui::control(group, name, about);
}

void whole(const char* text, const char* group, const char* name, int& value, const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputInt("##whole", &value, 0);
    ImGui::PopID();
    value = std::max(value, 0);
    ui::control(group, name, about);
}

void choice(const char* text, const char* group, const char* name, int& value, std::span<const char* const> names,
            const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::Combo("##choice", &value, names.data(), static_cast<int>(names.size()));
    ImGui::PopID();
    ui::control(group, name, about);
}

// True when it is pressed; grey while it cannot be.
bool button(const char* text, const char* group, const char* name, bool enabled, const char* about, bool primary) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ui::button(text, primary);
    ImGui::EndDisabled();
    ui::control(group, name, about);
    return pressed;
}

bool runs(const State& state, JobKind kind) {
    return state.job.running && state.job.kind == kind;
}

void cancel(const char* group, Commands& commands) {
    ImGui::SameLine();
    if (button("Cancel", group, "cancel", true, "Stops the job; no partial file remains.")) commands.push(CancelJob{});
}

void close(const char* group, Commands& commands) {
    ImGui::SameLine();
    if (button("Close", group, "close", true, "Closes this dialog (Esc); a running job goes on."))
        commands.push(ShowDialog{Dialog::none});
}

static void draw_bar(const JobView& job, bool with_rate) {
    char text[96];
    const int n = std::snprintf(text, sizeof text, "%s  %.0f%%", job.stage.c_str(), 100 * job.share);
    const auto used = static_cast<std::size_t>(std::clamp(n, 0, 95));
    if (job.left_s >= 0.5 && with_rate && job.rate >= 1e4)
        std::snprintf(text + used, sizeof text - used, "  %.1f M/s  %.0f s left", job.rate * 1e-6, job.left_s);
    else if (job.left_s >= 0.5)
        std::snprintf(text + used, sizeof text - used, "  %.0f s left", job.left_s);
    ImGui::ProgressBar(static_cast<float>(job.share), {-1, 0}, text);
    ui::mark("job", "progress");
}

// How the last job of that kind ended, or how far this one is. other: what runs instead keeps the button grey.
void outcome(const State& state, JobKind kind, bool with_rate) {
    const JobView& job = state.job;
    if (job.running && job.kind != kind) {
        ImGui::TextColored(ImColor(ui::warning_colour).Value, "Another job is running: wait for it, or cancel it.");
        return;
    }
    if (job.kind != kind) return;
    if (job.running) {
        draw_bar(job, with_rate);
        return;
    }
    ImGui::PushTextWrapPos(0);
    if (job.cancelled)
        ImGui::Text("Cancelled%s%s", job.result.empty() ? "." : "; ", job.result.c_str());
    else if (!job.problem.empty())
        ImGui::TextColored(ImColor(ui::bad).Value, "%s", job.problem.c_str());
    else
        ImGui::TextColored(ImColor(ui::good).Value, "%s", job.result.c_str());
    ImGui::PopTextWrapPos();
}

// A name after the pack's, where the program was started: terrain.fjell and ".csv" make terrain.csv. made_for: the pack
// that it was suggested for; another one's name is none of a path.
void suggest(PathText& path, std::string& made_for, const State& state, const char* ending) {
    if (made_for == state.scene.path) return;
    made_for = state.scene.path;
    const std::filesystem::path pack(state.scene.path);
    copy(path, (state.scene.open() ? pack.stem().string() : std::string("fjell")) + ending);
}

void destination(const char* group, const PathText& path) {
    if (path[0] == '\0' || path[0] == '/') return;
    static const std::string started_in = [] {
        std::error_code failed;
        const std::string folder = std::filesystem::current_path(failed).string();
        return folder == "/" ? "" : folder;
    }();
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::ColorConvertU32ToFloat4(ui::quiet));
    ImGui::TextWrapped("Writes %s/%s", started_in.c_str(), path);
    ui::mark(group, "destination");
    ImGui::PopStyleColor();
}

} // namespace fjell::editor::fields

// --- The file browser.

namespace fjell::editor {

namespace {

void set_name(FileBrowserForm& form, const char* name) {
    (void)std::snprintf(form.name, sizeof form.name, "%s", name);
}

void go(const std::string& folder, Commands& commands, FileBrowserForm& form) {
    commands.push(BrowseFolder{folder});
    form.name[0] = '\0';
}

void draw_places(const State& state, Commands& commands, FileBrowserForm& form) {
    const FolderListing& browser = state.files.browser;
    ImGui::BeginDisabled(browser.parent().empty());
    if (ImGui::Button("Up")) go(browser.parent(), commands, form);
    ui::mark("browse", "up");
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("Home")) go(state.files.standard_folders.home, commands, form);
    ui::mark("browse", "home");
    ImGui::SameLine();
    if (ImGui::Button("Reload")) commands.push(BrowseFolder{});
    ui::mark("browse", "reload");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    if (ImGui::BeginCombo("##recent", "Folders of recent files")) {
        for (const std::string& pack : state.interface.recent) {
            const std::size_t slash = pack.rfind('/');
            if (slash == std::string::npos) continue;
            char folder[600];
            (void)std::snprintf(folder, sizeof folder, "%.*s", static_cast<int>(std::max<std::size_t>(slash, 1)),
                                pack.c_str());
            ImGui::PushID(&pack);
            if (ImGui::Selectable(folder)) go(folder, commands, form);
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
    ui::mark("browse", "recent");
    ui::path_text(browser.folder());
}

// True: that file was chosen by a double click.
bool draw_entry(const FolderListing::Entry& entry, bool first, const State& state, Commands& commands,
                FileBrowserForm& form) {
    ui::need_glyphs(entry.name);
    const NumberText bytes = byte_text(static_cast<double>(entry.bytes));
    const char* const size = entry.folder ? "folder" : bytes.text;
    char label[300];
    (void)std::snprintf(label, sizeof label, "%.255s%s", entry.name.c_str(), entry.folder ? "/" : "");
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::PushID(&entry);
    const bool selected = entry.name == form.name;
    const keyboard::TabStops stop(selected || first); // the list is one stop; arrows move in it
    const bool clicked =
        ImGui::Selectable(label, selected, ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick);
    ImGui::PopID();
    const bool moved = keyboard::arrived();
    ui::mark("file", entry.name.c_str());
    ImGui::TableNextColumn();
    const float width = ImGui::CalcTextSize(size).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x - width);
    ImGui::TextUnformatted(size);
    if (moved) set_name(form, entry.name.c_str());
    if (!clicked) return false;
    const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    if (entry.folder && twice) {
        go(state.files.browser.path_of(entry.name), commands, form);
        return false;
    }
    set_name(form, entry.name.c_str());
    return twice;
}

bool draw_list(const State& state, Commands& commands, FileBrowserForm& form, float height) {
    const FolderListing& browser = state.files.browser;
    bool chosen = false;
    ImGui::BeginChild("files", {0, height}, true, ImGuiWindowFlags_NavFlattened);
    if (!ImGui::BeginTable("files", 2)) {
        ImGui::EndChild();
        return false;
    }
    ImGui::TableSetupColumn("Name", ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableSetupColumn("Size", ImGuiTableColumnFlags_WidthFixed, ImGui::CalcTextSize("8.88 MB ").x);
    const bool focuses = form.focuses == FileBrowserForm::Focus::list && form.of_folder != browser.folder();
    if (!browser.parent().empty()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        if (focuses) ImGui::SetKeyboardFocusHere();
        const bool clicked =
            ImGui::Selectable("..", std::strcmp(form.name, "..") == 0,
                              ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick);
        if (keyboard::arrived()) set_name(form, "..");
        if (clicked && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) go(browser.parent(), commands, form);
        ui::mark("file", "..");
    }
    if (!browser.problem().empty() || browser.size() == 0) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(!browser.problem().empty() ? browser.problem().c_str()
                               : browser.hidden() != 0    ? "no files of this kind here"
                                                          : "this folder is empty");
    }
    if (focuses) form.focuses = FileBrowserForm::Focus::stays;
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(browser.size()));
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
            chosen = draw_entry(browser.entry(static_cast<std::size_t>(i)), i == 0 && browser.parent().empty(), state,
                                commands, form) ||
                     chosen;
    ImGui::EndTable();
    ImGui::EndChild();
    return chosen;
}

// What is named: a folder is gone to, all else is chosen.
bool choose(const State& state, Commands& commands, FileBrowserForm& form) {
    if (form.name[0] == '\0') return false;
    const std::string path = state.files.browser.path_of(form.name);
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) return true;
    form.of_folder = state.files.browser.folder();
    go(path, commands, form);
    return false;
}

} // namespace

void begin_file_browser(FileBrowserForm& form, const State& state, const char* name) {
    const bool begins = form.frame + 1 != state.frame || form.of != state.interface.dialog;
    form.frame = state.frame;
    form.of = state.interface.dialog;
    if (!begins) return;
    form.asks = false;
    set_name(form, name);
}

bool draw_file_browser(const State& state, Commands& commands, FileBrowserForm& form, const char* button) {
    draw_places(state, commands, form);
    const float below = 2 * ImGui::GetFrameHeightWithSpacing();
    const float least = 4 * ImGui::GetTextLineHeightWithSpacing();
    bool chosen = draw_list(state, commands, form, std::max(ImGui::GetContentRegionAvail().y - below, least));
    ImGui::SetNextItemWidth(-1);
    ui::focus_first();
    if (form.focuses == FileBrowserForm::Focus::name && form.of_folder != state.files.browser.folder()) {
        ImGui::SetKeyboardFocusHere();
        form.focuses = FileBrowserForm::Focus::stays;
    }
    const bool entered = ImGui::InputTextWithHint("##name", "a name or a full path", form.name, sizeof form.name,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    chosen = entered || chosen;
    ui::mark("browse", "name");
    ImGui::BeginDisabled(form.name[0] == '\0');
    chosen = ui::button(button, true) || chosen;
    ui::mark("browse", "choose");
    ImGui::EndDisabled();
    ImGui::SameLine();
    const bool cancelled = ui::button("Cancel");
    ui::mark("browse", "cancel");
    if (cancelled && !form.nested) commands.push(ShowDialog{Dialog::none});
    form.cancelled = cancelled;
    ImGui::SameLine();
    bool all = state.files.browser.all();
    if (ImGui::Checkbox("All files", &all)) commands.push(BrowseAllKinds{all});
    ui::control("browse", "all", "Lists files of other kinds as well.");
    if (chosen) form.focuses = entered ? FileBrowserForm::Focus::name : FileBrowserForm::Focus::list;
    return chosen && choose(state, commands, form);
}

NestedBrowser draw_nested_browser(const State& state, Commands& commands, FileBrowserForm& form, const char* name) {
    constexpr const char* title = "Choose a file";
    if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    const float em = ImGui::GetFontSize();
    const keyboard::TabStops no_title(false); // its list brings its own
    const ImVec2 display = ImGui::GetIO().DisplaySize, from = ImGui::GetWindowPos();
    ImGui::SetNextWindowPos({std::min(from.x + 2 * em, 0.1F * display.x), from.y + 2 * em}, ImGuiCond_Appearing);
    ImGui::SetNextWindowSize({std::min(44 * em, 0.9F * display.x), std::min(30 * em, display.y - from.y - 3 * em)});
    bool open = true;
    if (!ImGui::BeginPopupModal(title, &open, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings))
        return NestedBrowser::open;
    form.nested = true;
    begin_file_browser(form, state, name);
    const bool chosen = [&] { // ImGui wants what is pushed within a window popped within it
        const keyboard::TabStops stops;
        return draw_file_browser(state, commands, form, "Choose");
    }();
    const bool over =
        chosen || !open || form.cancelled || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
    if (over) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    return chosen ? NestedBrowser::chose : over ? NestedBrowser::closed : NestedBrowser::open;
}

bool draw_overwrite(FileBrowserForm& form) {
    constexpr const char* title = "Overwrite?";
    if (!form.asks) return false;
    if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    const float em = ImGui::GetFontSize();
    const ImVec2 from = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    ImGui::SetNextWindowPos({from.x + size.x / 2, from.y + 0.35F * size.y}, ImGuiCond_Appearing, {0.5F, 0});
    ImGui::SetNextWindowSize({std::min(24 * em, size.x), 0});
    if (!ImGui::BeginPopupModal(title, &form.asks, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings))
        return false;
    ImGui::TextWrapped("%s already exists.", form.name);
    ImGui::Spacing();
    const bool yes = ui::button("Overwrite");
    ui::mark("overwrite", "yes");
    ImGui::SameLine();
    const bool escaped = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
    if (ui::button("Choose another name", true) || yes || escaped) {
        form.asks = false;
        ImGui::CloseCurrentPopup();
    }
    ui::mark("overwrite", "no");
    ImGui::EndPopup();
    return yes;
}

} // namespace fjell::editor
