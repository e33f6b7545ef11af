#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "editor/panels/file_browser.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

// One file dialog is open at a time.
FileBrowserForm browser_form;

// As wide as the longest of some, so that they stand in a column.
bool wide_button(const char* label, const char* name) {
    const bool pressed = ImGui::Button(label, {13 * ImGui::GetFontSize(), 0});
    ui::mark("start", name);
    return pressed;
}

const char* last_part(const std::string& path) {
    const char* const slash = std::strrchr(path.c_str(), '/');
    return slash != nullptr ? slash + 1 : path.c_str();
}

bool exists(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
}

// What is opened again is told by it.
void add_extension(const char* extension) {
    const std::size_t length = std::strlen(browser_form.name), added = std::strlen(extension);
    if (length >= added && std::strcmp(browser_form.name + length - added, extension) == 0) return;
    if (length + added < sizeof browser_form.name) std::memcpy(browser_form.name + length, extension, added + 1);
}

// Saving under a name; own: the file it came from, which is overwritten without a word. True: at that name, now.
bool save_as(const State& state, Commands& commands, const std::string& own, const char* otherwise,
             const char* extension) {
    begin_file_browser(browser_form, state, own.empty() ? otherwise : last_part(own));
    if (draw_file_browser(state, commands, browser_form, "Save")) {
        add_extension(extension);
        const std::string path = state.files.browser.path_of(browser_form.name);
        browser_form.asks = exists(path) && path != own;
        if (!browser_form.asks) return true;
    }
    return draw_overwrite(browser_form);
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
        ImGui::PushID(&pack);
        if (ImGui::Selectable(last_part(pack))) commands.push(OpenFile{pack});
        ImGui::PopID();
        ui::mark("recent", last_part(pack));
        ui::tip(pack.c_str());
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

void draw_start(const State& state, Commands& commands) {
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

void draw_open_file(const State& state, Commands& commands) {
    begin_file_browser(browser_form, state, "");
    if (draw_file_browser(state, commands, browser_form, "Open"))
        commands.push(OpenFile{state.files.browser.path_of(browser_form.name)});
}

void draw_save_profile(const State& state, Commands& commands) {
    if (save_as(state, commands, state.document.path(), "profile.toml", ".toml"))
        commands.push(SaveProfile{state.files.browser.path_of(browser_form.name)});
}

void draw_save_path(const State& state, Commands& commands) {
    if (save_as(state, commands, state.route.path(), "path.json", ".json"))
        commands.push(SavePath{state.files.browser.path_of(browser_form.name)});
}

void draw_compare(const State& state, Commands& commands) {
    if (state.document.compared() == nullptr) {
        begin_file_browser(browser_form, state, "");
        if (ui::button("With the saved profile")) commands.push(CompareProfile{});
        ui::mark("compare", "saved");
        ImGui::SameLine();
        ImGui::TextUnformatted("or with another profile:");
        if (draw_file_browser(state, commands, browser_form, "Compare"))
            commands.push(CompareProfile{state.files.browser.path_of(browser_form.name)});
        return;
    }
    draw_differences(state, commands);
    if (ui::button("Compare another")) commands.push(StopComparing{});
    ui::mark("compare", "another");
    ui::tip("Compares with another profile.");
    ImGui::SameLine();
    if (ui::button("Stop comparing")) {
        commands.push(StopComparing{});
        commands.push(ShowDialog{Dialog::none});
    }
    ui::mark("compare", "off");
    ImGui::SameLine();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("compare", "close");
    ui::tip("The other profile's values stay visible in the Tune panel.");
}

void draw_unsaved(const State& state, Commands& commands) {
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

void draw_recover(const State& state, Commands& commands) {
    const std::optional<Unsaved>& found = state.files.recovery.found();
    if (!found) {
        ImGui::TextWrapped("There is nothing to recover.");
        if (answer("Close", "close", true)) commands.push(ShowDialog{Dialog::none});
        return;
    }
    ImGui::TextWrapped("The editor ended before these changes were saved.");
    if (found->profile_changed)
        ImGui::BulletText("of the profile %s", found->path.empty() ? "that had no file yet" : last_part(found->path));
    if (!found->points.empty()) ImGui::BulletText("a camera path of %zu points", found->points.size());
    if (!found->pack.empty()) ImGui::BulletText("over %s", last_part(found->pack));
    ImGui::Spacing();
    if (answer("Restore", "restore", true)) commands.push(RecoverChanges{true});
    if (answer("Discard", "discard", false)) commands.push(RecoverChanges{false});
    ImGui::SameLine();
    ImGui::TextDisabled("close this dialog to be asked again next time");
}

} // namespace fjell::editor
