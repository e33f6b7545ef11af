#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "editor/panels/file_browser.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

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
    if (draw_file_browser(state, commands, browser_form, strings::common::save)) {
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
    if (ImGui::Button(strings::common::cancel)) commands.push(CancelJob{});
    ui::mark("start", "cancel");
}

void draw_recent_packs(const State& state, Commands& commands) {
    ui::heading(strings::file_dialogs::recent_packs);
    if (state.interface.recent.empty()) ImGui::TextDisabled(strings::file_dialogs::none_yet);
    for (const std::string& pack : state.interface.recent) {
        ImGui::PushID(&pack);
        if (ImGui::Selectable(last_part(pack))) commands.push(OpenFile{pack});
        ImGui::PopID();
        ui::mark("recent", last_part(pack));
        ui::tip(pack.c_str());
    }
}

void draw_differences(const State& state, Commands& commands) {
    ImGui::TextWrapped(strings::file_dialogs::differences,
                       state.document.compared_path().empty() ? strings::file_dialogs::the_saved_profile
                                                              : state.document.compared_path().c_str(),
                       state.files.differences.size());
    const float below = ImGui::GetFrameHeightWithSpacing();
    const float height = std::max(ImGui::GetContentRegionAvail().y - below, 3 * below);
    constexpr ImGuiTableFlags flags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersOuter | ImGuiTableFlags_RowBg;
    if (!ImGui::BeginTable("differences", 4, flags, {0, height})) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn(strings::file_dialogs::key, ImGuiTableColumnFlags_WidthStretch, 2);
    ImGui::TableSetupColumn(strings::file_dialogs::mine, ImGuiTableColumnFlags_WidthStretch, 1.2F);
    ImGui::TableSetupColumn(strings::file_dialogs::theirs, ImGuiTableColumnFlags_WidthStretch, 1.2F);
    ImGui::TableSetupColumn("##take", ImGuiTableColumnFlags_WidthFixed,
                            ImGui::CalcTextSize(strings::file_dialogs::take_theirs_column).x);
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
        if (ImGui::SmallButton(strings::file_dialogs::take_theirs)) commands.push(SetKey{d.key, d.theirs_value, false});
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
    ImGui::TextWrapped(strings::file_dialogs::welcome);
    ImGui::Spacing();
    if (wide_button(strings::common::open_the_sample, "sample")) commands.push(OpenSample{});
    ui::tip(strings::file_dialogs::about_sample);
    if (wide_button(strings::file_dialogs::open_a_file, "open")) commands.push(ShowDialog{Dialog::open_file});
    ui::tip(strings::file_dialogs::about_open_a_file);
    if (wide_button(strings::menu::bake_heights, "bake")) commands.push(ShowDialog{Dialog::bake});
    ui::tip(strings::file_dialogs::about_bake);
    ImGui::TextDisabled(strings::file_dialogs::or_drop_a_file);
    draw_sample_progress(state, commands);
    draw_recent_packs(state, commands);
}

void draw_open_file(const State& state, Commands& commands) {
    begin_file_browser(browser_form, state, "");
    if (draw_file_browser(state, commands, browser_form, strings::common::open))
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
        if (ui::button(strings::file_dialogs::with_the_saved_profile)) commands.push(CompareProfile{});
        ui::mark("compare", "saved");
        ImGui::SameLine();
        ImGui::TextUnformatted(strings::file_dialogs::or_another_profile);
        if (draw_file_browser(state, commands, browser_form, strings::file_dialogs::compare))
            commands.push(CompareProfile{state.files.browser.path_of(browser_form.name)});
        return;
    }
    draw_differences(state, commands);
    if (ui::button(strings::file_dialogs::compare_another)) commands.push(StopComparing{});
    ui::mark("compare", "another");
    ui::tip(strings::file_dialogs::about_compare_another);
    ImGui::SameLine();
    if (ui::button(strings::file_dialogs::stop_comparing)) {
        commands.push(StopComparing{});
        commands.push(ShowDialog{Dialog::none});
    }
    ui::mark("compare", "off");
    ImGui::SameLine();
    if (ui::button(strings::common::close, true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("compare", "close");
    ui::tip(strings::file_dialogs::about_close_comparison);
}

void draw_unsaved(const State& state, Commands& commands) {
    if (state.document.unsaved())
        ImGui::TextWrapped(strings::file_dialogs::unsaved_profile, state.document.path().empty()
                                                                       ? strings::file_dialogs::no_file_yet
                                                                       : state.document.path().c_str());
    if (state.route.unsaved())
        ImGui::TextWrapped(strings::file_dialogs::unsaved_path, state.route.path().empty()
                                                                    ? strings::file_dialogs::no_file_yet
                                                                    : state.route.path().c_str());
    ImGui::Spacing();
    ImGui::BeginDisabled(!state.files.waiting);
    if (answer(strings::common::save, "save", true)) commands.push(AnswerUnsaved{Answer::save});
    if (answer(strings::file_dialogs::discard, "discard", false)) commands.push(AnswerUnsaved{Answer::discard});
    ImGui::EndDisabled();
    if (answer(strings::common::cancel, "cancel", false)) commands.push(ShowDialog{Dialog::none});
}

void draw_recover(const State& state, Commands& commands) {
    const std::optional<Unsaved>& found = state.files.recovery.found();
    if (!found) {
        ImGui::TextWrapped(strings::file_dialogs::nothing_to_recover);
        if (answer(strings::common::close, "close", true)) commands.push(ShowDialog{Dialog::none});
        return;
    }
    ImGui::TextWrapped(strings::file_dialogs::earlier_run);
    if (found->profile_changed)
        ImGui::BulletText(strings::file_dialogs::of_the_profile,
                          found->path.empty() ? strings::file_dialogs::profile_without_file : last_part(found->path));
    if (!found->points.empty()) ImGui::BulletText(strings::file_dialogs::recovered_path, found->points.size());
    if (!found->pack.empty()) ImGui::BulletText(strings::file_dialogs::over_terrain, last_part(found->pack));
    ImGui::Spacing();
    if (answer(strings::common::restore, "restore", true)) commands.push(RecoverChanges{true});
    if (answer(strings::file_dialogs::discard, "discard", false)) commands.push(RecoverChanges{false});
    ImGui::SameLine();
    ImGui::TextDisabled(strings::file_dialogs::about_later);
}

} // namespace fjell::editor
