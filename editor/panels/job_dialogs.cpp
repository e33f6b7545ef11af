// Dialogs of what runs beside the frame. What is typed into one lives here, in one form each, until its button makes
// it a command; the state knows nothing of it.
#include "editor/panels/panels.h"

#include <cstdio>
#include <cstring>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

// ---- export

struct ExportForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText path = "";
    bool converged = false;
    int own = 0; // a threshold of its own
    double error_px = 1;
};

struct ScreenshotForm {
    fields::PathText path = "fjell.png";
    int what = 0;
};

} // namespace

void draw_snapshot(const State& state, Commands& commands) {
    static ExportForm form;
    constexpr const char* kinds[] = {strings::job_dialogs::frames_own, strings::job_dialogs::custom_threshold};
    fields::suggest(form.path, form.made_for, state, ".glb");
    ui::focus_first();
    fields::path(strings::job_dialogs::gltf, "export", "path", form.path, strings::job_dialogs::gltf_hint,
                 strings::job_dialogs::about_gltf);
    fields::destination("export", form.path);
    fields::choice(strings::common::mesh, "export", "own", form.own, kinds, 2, strings::job_dialogs::about_mesh);
    fields::label(strings::job_dialogs::converged);
    ImGui::BeginDisabled(form.own == 1);
    bool converged = form.converged || form.own == 1;
    if (ImGui::Checkbox("##converged", &converged) && form.own == 0) form.converged = converged;
    ImGui::EndDisabled();
    ui::mark("export", "converged");
    ui::tip(strings::job_dialogs::about_converged);
    ImGui::BeginDisabled(form.own == 0);
    double shown = form.own == 1 ? form.error_px : state.measures.last().error_px_effective;
    fields::number(strings::job_dialogs::pixels, "export", "error_px", shown, "%.4g",
                   strings::job_dialogs::about_pixels);
    if (form.own == 1) form.error_px = shown;
    ImGui::EndDisabled();
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open();
    const double error_px = form.own == 1 ? form.error_px : 0;
    if (fields::button(strings::job_dialogs::preview, "export", "preview", can, strings::job_dialogs::about_preview))
        commands.push(PreviewExport{form.converged, error_px});
    ImGui::SameLine();
    if (fields::button(strings::job_dialogs::export_, "export", "start", can && form.path[0] != '\0',
                       strings::job_dialogs::about_export, true))
        commands.push(ExportMesh{form.path, form.converged, error_px});
    fields::close("export", commands);
    if (fields::runs(state, JobKind::snapshot) || fields::runs(state, JobKind::preview))
        fields::cancel("export", commands);
    const ExportPreview& p = state.job.preview;
    if (p.bytes != 0) {
        ui::row(strings::common::vertices, "%s", count_text(static_cast<double>(p.vertices)).text);
        ui::row(strings::common::triangles, "%s", count_text(static_cast<double>(p.triangles)).text);
        ui::row(strings::common::file, strings::job_dialogs::size_within, byte_text(static_cast<double>(p.bytes)).text,
                p.error_px);
    }
    const bool counted = state.job.kind == JobKind::preview && !state.job.running && p.bytes != 0;
    if (!counted) fields::outcome(state, state.job.kind == JobKind::preview ? JobKind::preview : JobKind::snapshot);
}

void draw_screenshot(const State&, Commands& commands) {
    static ScreenshotForm form;
    constexpr const char* kinds[] = {strings::job_dialogs::terrain_alone, strings::job_dialogs::window_with_panels};
    ui::focus_first();
    fields::path(strings::common::picture, "screenshot", "path", form.path, strings::common::png_hint,
                 strings::common::about_png);
    fields::destination("screenshot", form.path);
    fields::choice(strings::job_dialogs::contents, "screenshot", "what", form.what, kinds, 2,
                   strings::job_dialogs::about_contents);
    ImGui::Separator();
    if (fields::button(strings::common::save, "screenshot", "start", form.path[0] != '\0',
                       strings::job_dialogs::about_save, true)) {
        commands.push(ShowDialog{Dialog::none});
        commands.push(TakeScreenshot{form.path, form.what == 1});
    }
    fields::close("screenshot", commands);
}

void draw_job_status(const State& state, Commands& commands) {
    const JobView& job = state.job;
    if (!job.running) return;
    ImGui::Text("%s: %s %.0f%%", job_names[static_cast<int>(job.kind)], job.stage.c_str(), 100 * job.share);
    ui::mark("status", "job");
    ImGui::SameLine();
    if (ImGui::SmallButton(strings::common::cancel)) commands.push(CancelJob{});
    ui::mark("status", "cancel-job");
    ui::tip(strings::job_dialogs::about_cancel);
    ImGui::SameLine();
}

} // namespace fjell::editor
