// Dialogs of what runs beside the frame. What is typed into one lives here, in one form each, until its button makes
// it a command; the state knows nothing of it.
#include "editor/panels/panels.h"

#include <cstdio>
#include <cstring>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"

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
    constexpr const char* kinds[] = {"the frame's", "custom threshold"};
    fields::suggest(form.path, form.made_for, state, ".glb");
    ui::focus_first();
    fields::path("glTF", "export", "path", form.path, "a file that ends in .glb",
                 "Mesh, colours and camera in one file, for any viewer or modelling program.");
    fields::destination("export", form.path);
    fields::choice(
        "Mesh", "export", "own", form.own, kinds, 2,
        "The frame's is written as it is drawn: the triangles that the camera sees, morphed, as fine as the budgets "
        "allowed. A custom threshold refines the whole terrain for this view, whatever the budgets.");
    fields::label("Converged");
    ImGui::BeginDisabled(form.own == 1);
    bool converged = form.converged || form.own == 1;
    if (ImGui::Checkbox("##converged", &converged) && form.own == 0) form.converged = converged;
    ImGui::EndDisabled();
    ui::mark("export", "converged");
    ui::tip(
        "The mesh that this view settles on once it has had time and work items, instead of the frame's as it stands.");
    ImGui::BeginDisabled(form.own == 0);
    double shown = form.own == 1 ? form.error_px : state.measures.last().error_px_effective;
    fields::number("Pixels", "export", "error_px", shown, "%.4g",
                   "0.01 to 1,000 pixels: a smaller threshold makes a larger file.");
    if (form.own == 1) form.error_px = shown;
    ImGui::EndDisabled();
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open();
    const double error_px = form.own == 1 ? form.error_px : 0;
    if (fields::button("Preview", "export", "preview", can,
                       "Counts, and the size of the file to the byte; nothing is written."))
        commands.push(PreviewExport{form.converged, error_px});
    ImGui::SameLine();
    if (fields::button("Export", "export", "start", can && form.path[0] != '\0',
                       "Writes the file; an existing one is replaced only when it is complete.", true))
        commands.push(ExportMesh{form.path, form.converged, error_px});
    fields::close("export", commands);
    if (fields::runs(state, JobKind::snapshot) || fields::runs(state, JobKind::preview))
        fields::cancel("export", commands);
    const ExportPreview& p = state.job.preview;
    if (p.bytes != 0) {
        ui::row("Vertices", "%s", count_text(static_cast<double>(p.vertices)).text);
        ui::row("Triangles", "%s", count_text(static_cast<double>(p.triangles)).text);
        ui::row("File", "%s within %.3g px", byte_text(static_cast<double>(p.bytes)).text, p.error_px);
    }
    const bool counted = state.job.kind == JobKind::preview && !state.job.running && p.bytes != 0;
    if (!counted) fields::outcome(state, state.job.kind == JobKind::preview ? JobKind::preview : JobKind::snapshot);
}

void draw_screenshot(const State&, Commands& commands) {
    static ScreenshotForm form;
    constexpr const char* kinds[] = {"the terrain", "the window, with its panels"};
    ui::focus_first();
    fields::path("Picture", "screenshot", "path", form.path, "a file that ends in .png", "Where the PNG is written.");
    fields::destination("screenshot", form.path);
    fields::choice("Contents", "screenshot", "what", form.what, kinds, 2, "At the current size of the window.");
    ImGui::Separator();
    if (fields::button("Save", "screenshot", "start", form.path[0] != '\0',
                       "Closes this dialog and saves the next frame.", true)) {
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
    if (ImGui::SmallButton("Cancel")) commands.push(CancelJob{});
    ui::mark("status", "cancel-job");
    ui::tip("Stops the job; no partial file remains. A bake may keep a folder from which it can resume.");
    ImGui::SameLine();
}

} // namespace fjell::editor
