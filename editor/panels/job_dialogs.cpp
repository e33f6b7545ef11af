// Dialogs of what runs beside the frame. What is typed into one lives here, in one form each, until its button makes
// it a command; the state knows nothing of it.
#include "editor/panels/panels.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/tune_curve.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

namespace {

constexpr std::size_t path_bytes = 1024;
using PathText = char[path_bytes];

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

void path_field(const char* text, const char* group, const char* name, PathText& path, const char* hint,
                const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputTextWithHint("##path", hint, path, path_bytes);
    ImGui::PopID();
    ui::mark(group, name);
    ui::tip(about);
}

void number_field(const char* text, const char* group, const char* name, double& value, const char* format,
                  const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputDouble("##number", &value, 0, 0, format);
    ImGui::PopID();
    ui::mark(group, name);
    ui::tip(about);
}

void whole_field(const char* text, const char* group, const char* name, int& value, const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::InputInt("##whole", &value, 0);
    ImGui::PopID();
    value = std::max(value, 0);
    ui::mark(group, name);
    ui::tip(about);
}

void choice_field(const char* text, const char* group, const char* name, int& value, const char* const* names,
                  int count, const char* about) {
    label(text);
    ImGui::PushID(name);
    ImGui::Combo("##choice", &value, names, count);
    ImGui::PopID();
    ui::mark(group, name);
    ui::tip(about);
}

// True when it is pressed; grey while it cannot be.
bool button(const char* text, const char* group, const char* name, bool enabled, const char* about) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(text);
    ImGui::EndDisabled();
    ui::mark(group, name);
    ui::tip(about);
    return pressed;
}

bool runs(const State& state, JobKind kind) {
    return state.job.running && state.job.kind == kind;
}

void cancel_button(const char* group, Commands& commands) {
    ImGui::SameLine();
    if (button("Cancel", group, "cancel", true, "Stops the job; no partial file remains.")) commands.push(CancelJob{});
}

void draw_bar(const JobView& job, bool with_rate) {
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
void draw_outcome(const State& state, JobKind kind, bool with_rate = false) {
    const JobView& job = state.job;
    if (job.running && job.kind != kind) {
        ImGui::TextColored(ImColor(ui::warning_colour).Value, "Another job is running; wait for it, or cancel it.");
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
constexpr const char* nothing_yet = "\n";
void suggest(PathText& path, std::string& made_for, const State& state, const char* ending) {
    if (made_for == state.scene.path) return;
    made_for = state.scene.path;
    const std::filesystem::path pack(state.scene.path);
    copy(path, (state.scene.open() ? pack.stem().string() : std::string("fjell")) + ending);
}

// ---- bake

constexpr const char* tile_names[] = {"auto", "64", "128", "256", "512", "1024", "2048"};
constexpr const char* order_names[] = {"planar", "hz", "linear"};
constexpr const char* nodata_names[] = {"auto: holes, suspicious values refused", "hole", "fill", "refuse"};

struct BakeForm {
    std::string made_for; // State::bake_input, which resets the form when it changes
    PathText input = "", output = "", texture = "", ramp = "", voids = "";
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
    path_field("Heights", "bake", "input", form.input, "a file",
               "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json). Several files make a "
               "mosaic with the command `bake`.");
    path_field("Pack", "bake", "output", form.output, "beside the heights, with .fjell",
               "Where the pack is written; an existing file is replaced only when the bake is complete. Temporary "
               "files go to a folder PACK.work beside it.");
    choice_field("Tile", "bake", "tile", form.tile, tile_names, static_cast<int>(std::size(tile_names)),
                 "Cells along a side of a tile, the unit of drawing. Smaller tiles are culled more tightly and cost "
                 "more draw calls; auto chooses 512, or what suits the extents.");
    number_field("Spacing, m", "bake", "spacing", form.spacing_m, "%.6g",
                 "Metres between samples; 0: the file's own. Needed where it has no coordinates.");
    number_field("Height scale", "bake", "zscale", form.height_scale, "%.6g",
                 "Multiplies heights: 0.3048 converts feet to metres.");
    path_field("Texture", "bake", "texture", form.texture, "none",
               "An ortho-image, placed by its coordinates or stretched over the terrain.");
    path_field("Ramp", "bake", "ramp", form.ramp, "meadows to snow",
               "Colours by height and slope where there is no image (JSON, as in content/ramps).");
    choice_field("Order", "bake", "order", form.order, order_names, static_cast<int>(std::size(order_names)),
                 "Order of vertices in a page: planar and hz (hierarchical Z) for both methods; linear, as in the "
                 "thesis, for the recursive method.");
    choice_field("No data", "bake", "nodata", form.nodata, nodata_names, static_cast<int>(std::size(nodata_names)),
                 "Samples without a height: a hole, filled from their neighbours, or refused.");
    path_field("Voids", "bake", "void", form.voids, "what the file marks",
               "Numbers that stand for no height without the file saying so, such as -9999; several with commas. none: "
               "every other number is a height.");
}

// ---- tune

struct TuneForm {
    double budget_us = TuneSettings{}.budget_us, least_px = TuneSettings{}.least_px, most_px = TuneSettings{}.most_px;
    int measure = 0, frames = 0;
};

constexpr const char* measures[] = {"update: the CPU's part", "frame: with upload, drawing and the GPU"};

void draw_tune_form(TuneForm& form) {
    number_field("Budget, us", "auto-tune", "budget_us", form.budget_us, "%.6g",
                 "Limit for the p99 time of a frame: 10 to 1,000,000 microseconds. A frame at 60 Hz has 16,667.");
    choice_field("Measure", "auto-tune", "measure", form.measure, measures, 2,
                 "update: CPU time of refinement and streaming. frame: with upload and drawing at the picture size of "
                 "the profile; slower, and dependent on the graphics driver.");
    whole_field("Frames", "auto-tune", "frames", form.frames,
                "Frames per flight, 10 to 100,000; 0: as many as the path has at 60 Hz, or 840 for an orbit without a "
                "path. Fewer frames fly the same path faster, so more changes per frame.");
    label("From, to, px");
    ImGui::PushID("range");
    float width = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    ImGui::SetNextItemWidth(width);
    ImGui::InputDouble("##least", &form.least_px, 0, 0, "%.4g");
    ui::mark("auto-tune", "least_px");
    ui::tip("The smallest threshold to try, in pixels.");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 0.3F);
    ImGui::InputDouble("##most", &form.most_px, 0, 0, "%.4g");
    ui::mark("auto-tune", "most_px");
    ui::tip("The largest threshold, with which the search begins, in pixels.");
    ImGui::PopID();
}

void draw_tune_result(const State& state, const JobView& shown, Commands& commands) {
    if (shown.running || shown.best_px <= 0) return;
    char text[48];
    std::snprintf(text, sizeof text, "Use %.3g px", shown.best_px);
    const flight::ProfileKey* const key = flight::find_profile_key("refine.error_px");
    const bool used = key->get(state.document.profile()) == shown.best_px;
    ImGui::SameLine();
    if (button(text, "auto-tune", "use", !used, "Sets the threshold of the profile; one undo step."))
        commands.push(SetKey{key, shown.best_px, false});
}

// ---- export

struct ExportForm {
    std::string made_for = nothing_yet;
    PathText path = "";
    bool converged = false;
    int own = 0; // a threshold of its own
    double error_px = 1;
};

struct CsvForm {
    std::string made_for = nothing_yet;
    PathText path = "";
    int frames = 0;
};

struct ScreenshotForm {
    PathText path = "fjell.png";
    int what = 0;
};

} // namespace

void draw_bake(const State& state, Commands& commands) {
    static BakeForm form;
    if (form.made_for != state.bake_input) {
        form = {};
        form.made_for = state.bake_input;
        copy(form.input, state.bake_input);
        if (!state.bake_input.empty())
            copy(form.output, std::filesystem::path(state.bake_input).replace_extension(".fjell").string());
    }
    draw_bake_form(form);
    ImGui::Separator();
    const bool can = !state.job.running && form.input[0] != '\0';
    if (button("Bake", "bake", "start", can,
               "Bakes in the background with 512 MB of memory, and opens the pack when it is done."))
        commands.push(bake_of(form));
    if (runs(state, JobKind::bake)) cancel_button("bake", commands);
    draw_outcome(state, JobKind::bake, true);
}

void draw_auto_tune(const State& state, Commands& commands) {
    static TuneForm form;
    draw_tune_form(form);
    const bool can = !state.job.running && state.scene.open();
    if (button("Start", "auto-tune", "start", can,
               "Flies the path, or an orbit, over a terrain of its own until the smallest threshold is found whose p99 "
               "keeps the budget. The view is as large as the profile says.")) {
        TuneThreshold t;
        t.settings = {form.measure == 1 ? TuneMeasure::frame : TuneMeasure::update,
                      form.budget_us,
                      static_cast<std::uint32_t>(form.frames),
                      form.least_px,
                      form.most_px,
                      false};
        commands.push(t);
    }
    const bool running = runs(state, JobKind::tune);
    if (running) cancel_button("auto-tune", commands);
    const JobView& shown = state.job.kind == JobKind::tune ? state.job : state.tuned;
    draw_tune_result(state, shown, commands);
    draw_outcome(state, JobKind::tune);
    draw_tune_curve(shown, ImGui::GetContentRegionAvail().y);
}

void draw_benchmark(const State& state, Commands& commands) {
    static CsvForm form;
    suggest(form.path, form.made_for, state, ".csv");
    path_field("CSV", "benchmark", "path", form.path, "a file",
               "One line per frame, with the columns of fjell-fly --csv.");
    whole_field("Frames", "benchmark", "frames", form.frames,
                "0: as many as the path has at 60 Hz, or 840 for an orbit without a path. Fewer frames fly the same "
                "path faster.");
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(ImColor(ui::quiet).Value,
                       "Flies %s as the profile says, over a terrain of its own, in a view of %u x %u.",
                       state.route.empty() ? "an orbit" : "the path", state.document.profile().width_px,
                       state.document.profile().height_px);
    ImGui::PopTextWrapPos();
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open() && form.path[0] != '\0';
    if (button("Run", "benchmark", "start", can, "Starts at once and flies as fast as possible."))
        commands.push(RunBenchmark{form.path, static_cast<std::size_t>(form.frames)});
    if (runs(state, JobKind::benchmark)) cancel_button("benchmark", commands);
    draw_outcome(state, JobKind::benchmark);
}

void draw_snapshot(const State& state, Commands& commands) {
    static ExportForm form;
    constexpr const char* kinds[] = {"the frame's", "custom threshold"};
    suggest(form.path, form.made_for, state, ".glb");
    path_field("glTF", "export", "path", form.path, "a file that ends in .glb",
               "Mesh, colours and camera in one file, for any viewer or modelling program.");
    choice_field("Mesh", "export", "own", form.own, kinds, 2,
                 "The frame's is written as it is drawn: what the camera sees of it, morphed, as far as its budgets "
                 "went. With a custom threshold the whole terrain is refined for this view, whatever the budgets.");
    label("Converged");
    ImGui::BeginDisabled(form.own == 1);
    bool converged = form.converged || form.own == 1;
    if (ImGui::Checkbox("##converged", &converged) && form.own == 0) form.converged = converged;
    ImGui::EndDisabled();
    ui::mark("export", "converged");
    ui::tip("Not the frame's mesh as it stands, but the one that its view settles on once it has had time and items.");
    ImGui::BeginDisabled(form.own == 0);
    double shown = form.own == 1 ? form.error_px : state.measures.last().error_px_effective;
    number_field("Pixels", "export", "error_px", shown, "%.4g",
                 "0.01 to 1000 pixels: a smaller threshold makes a larger file.");
    if (form.own == 1) form.error_px = shown;
    ImGui::EndDisabled();
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open();
    const double error_px = form.own == 1 ? form.error_px : 0;
    if (button("Preview", "export", "preview", can, "Counts and size of the file, to the byte; nothing is written."))
        commands.push(PreviewExport{form.converged, error_px});
    ImGui::SameLine();
    if (button("Export", "export", "start", can && form.path[0] != '\0',
               "Writes the file; an existing one is replaced only when it is complete."))
        commands.push(ExportMesh{form.path, form.converged, error_px});
    if (runs(state, JobKind::snapshot) || runs(state, JobKind::preview)) cancel_button("export", commands);
    const ExportPreview& p = state.job.preview;
    if (p.bytes != 0) {
        ui::row("Vertices", "%llu", static_cast<unsigned long long>(p.vertices));
        ui::row("Triangles", "%llu", static_cast<unsigned long long>(p.triangles));
        ui::row("File", "%s within %.3g px", byte_text(static_cast<double>(p.bytes)).text, p.error_px);
    }
    const bool counted = state.job.kind == JobKind::preview && !state.job.running && p.bytes != 0;
    if (!counted) draw_outcome(state, state.job.kind == JobKind::preview ? JobKind::preview : JobKind::snapshot);
}

void draw_screenshot(const State&, Commands& commands) {
    static ScreenshotForm form;
    constexpr const char* kinds[] = {"the terrain", "the window, with its panels"};
    path_field("Picture", "screenshot", "path", form.path, "a file that ends in .png", "Where the PNG goes.");
    choice_field("Contents", "screenshot", "what", form.what, kinds, 2, "At the current size of the window.");
    ImGui::Separator();
    if (button("Save", "screenshot", "start", form.path[0] != '\0', "Closes this dialog and saves the next frame.")) {
        commands.push(ShowDialog{Dialog::none});
        commands.push(TakeScreenshot{form.path, form.what == 1});
    }
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
