// Dialogs of what runs beside the frame. What is typed into one lives here, in one form each, until its button makes
// it a command; the state knows nothing of it.
#include "editor/panels/panels.h"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"

namespace fjell::editor {

namespace {

// ---- bake

constexpr const char* tile_names[] = {"auto", "64", "128", "256", "512", "1024", "2048"};
constexpr const char* order_names[] = {"planar", "hz", "linear"};
constexpr const char* nodata_names[] = {"auto: holes, suspicious values refused", "hole", "fill", "refuse"};

struct BakeForm {
    std::string made_for; // State::bake_input, which resets the form when it changes
    fields::PathText input = "", output = "", texture = "", ramp = "", voids = "";
    int tile = 0, order = 0, nodata = 0;
    double spacing_m = 0, height_scale = 1;
};

BakePack bake_of(const BakeForm& form) {
    BakePack b;
    b.inputs = {form.input};
    b.output = form.output;
    b.texture = form.texture;
    b.ramp = form.ramp;
    b.tile = form.tile == 0 ? 0 : 32u << form.tile;
    b.order = order_names[form.order];
    b.nodata = form.nodata == 0 ? "" : nodata_names[form.nodata];
    b.voids = form.voids;
    b.spacing_m = form.spacing_m;
    b.height_scale = form.height_scale;
    return b;
}

void draw_bake_form(BakeForm& form) {
    ui::focus_first();
    fields::path("Heights", "bake", "input", form.input, "a file",
                 "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json). Several files make a "
                 "mosaic with the command `bake`.");
    fields::path("Pack", "bake", "output", form.output, "beside the heights, with .fjell",
                 "Where the pack is written; an existing file is replaced only when the bake is complete. Temporary "
                 "files go to a folder PACK.work beside it.");
    fields::choice("Tile", "bake", "tile", form.tile, tile_names, static_cast<int>(std::size(tile_names)),
                   "Cells along a side of a tile, the unit of drawing. Smaller tiles are culled more tightly and cost "
                   "more draw calls; auto chooses 512, or what suits the extents.");
    fields::number("Spacing, m", "bake", "spacing", form.spacing_m, "%.6g",
                   "Metres between samples; 0: the file's own. Needed where it has no coordinates.");
    fields::number("Height scale", "bake", "zscale", form.height_scale, "%.6g",
                   "Multiplies heights: 0.3048 converts feet to metres.");
    fields::path("Texture", "bake", "texture", form.texture, "none",
                 "An ortho-image, placed by its coordinates or stretched over the terrain.");
    fields::path("Ramp", "bake", "ramp", form.ramp, "meadows to snow",
                 "Colours by height and slope where there is no image (JSON, as in content/ramps).");
    fields::choice("Order", "bake", "order", form.order, order_names, static_cast<int>(std::size(order_names)),
                   "Order of vertices in a page: planar and hz (hierarchical Z) for both methods; linear, as in the "
                   "thesis, for the recursive method.");
    fields::choice("No data", "bake", "nodata", form.nodata, nodata_names, static_cast<int>(std::size(nodata_names)),
                   "Samples without a height: a hole, filled from their neighbours, or refused.");
    fields::path(
        "Voids", "bake", "void", form.voids, "what the file marks",
        "Numbers that stand for no height without the file saying so, such as -9999; several with commas. none: "
        "every other number is a height.");
}

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

void draw_bake(const State& state, Commands& commands) {
    static BakeForm form;
    if (form.made_for != state.bake_input) {
        form = {};
        form.made_for = state.bake_input;
        fields::copy(form.input, state.bake_input);
        if (!state.bake_input.empty())
            fields::copy(form.output, std::filesystem::path(state.bake_input).replace_extension(".fjell").string());
    }
    draw_bake_form(form);
    ImGui::Separator();
    const bool can = !state.job.running && form.input[0] != '\0';
    if (fields::button("Bake", "bake", "start", can,
                       "Bakes in the background with 512 MB of memory, and opens the pack when it is done.", true))
        commands.push(bake_of(form));
    fields::close("bake", commands);
    if (fields::runs(state, JobKind::bake)) fields::cancel("bake", commands);
    fields::outcome(state, JobKind::bake, true);
}

void draw_snapshot(const State& state, Commands& commands) {
    static ExportForm form;
    constexpr const char* kinds[] = {"the frame's", "custom threshold"};
    fields::suggest(form.path, form.made_for, state, ".glb");
    ui::focus_first();
    fields::path("glTF", "export", "path", form.path, "a file that ends in .glb",
                 "Mesh, colours and camera in one file, for any viewer or modelling program.");
    fields::choice("Mesh", "export", "own", form.own, kinds, 2,
                   "The frame's is written as it is drawn: what the camera sees of it, morphed, as far as its budgets "
                   "went. With a custom threshold the whole terrain is refined for this view, whatever the budgets.");
    fields::label("Converged");
    ImGui::BeginDisabled(form.own == 1);
    bool converged = form.converged || form.own == 1;
    if (ImGui::Checkbox("##converged", &converged) && form.own == 0) form.converged = converged;
    ImGui::EndDisabled();
    ui::mark("export", "converged");
    ui::tip("Not the frame's mesh as it stands, but the one that its view settles on once it has had time and items.");
    ImGui::BeginDisabled(form.own == 0);
    double shown = form.own == 1 ? form.error_px : state.measures.last().error_px_effective;
    fields::number("Pixels", "export", "error_px", shown, "%.4g",
                   "0.01 to 1000 pixels: a smaller threshold makes a larger file.");
    if (form.own == 1) form.error_px = shown;
    ImGui::EndDisabled();
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open();
    const double error_px = form.own == 1 ? form.error_px : 0;
    if (fields::button("Preview", "export", "preview", can,
                       "Counts and size of the file, to the byte; nothing is written."))
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
    fields::path("Picture", "screenshot", "path", form.path, "a file that ends in .png", "Where the PNG goes.");
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
