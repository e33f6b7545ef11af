#include "editor/panels/fields.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

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
    ui::mark(group, name);
    ui::tip(about);
}

void number(const char* text, const char* group, const char* name, double& value, const char* format,
            const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputDouble("##number", &value, 0, 0, format);
    ImGui::PopID();
    ui::mark(group, name);
    ui::tip(about);
}

void whole(const char* text, const char* group, const char* name, int& value, const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputInt("##whole", &value, 0);
    ImGui::PopID();
    value = std::max(value, 0);
    ui::mark(group, name);
    ui::tip(about);
}

void choice(const char* text, const char* group, const char* name, int& value, const char* const* names, int count,
            const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::Combo("##choice", &value, names, count);
    ImGui::PopID();
    ui::mark(group, name);
    ui::tip(about);
}

// True when it is pressed; grey while it cannot be.
bool button(const char* text, const char* group, const char* name, bool enabled, const char* about, bool primary) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ui::button(text, primary);
    ImGui::EndDisabled();
    ui::mark(group, name);
    ui::tip(about);
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
