// Dialogs and panels of what runs beside the frame, and bookmarks.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/forms.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "fjell/profile/keys.h"

namespace fjell::editor {

void draw_snapshot(const State& state, PanelState& own, Commands& commands) {
    ExportForm& form = own.mesh_export;
    constexpr const char* kinds[] = {"as drawn now", "custom threshold"};
    fields::suggest(form.path, form.made_for, state, ".glb");
    ui::focus_first();
    fields::label("glTF");
    ImGui::SetNextItemWidth(-ImGui::CalcTextSize("Browse").x - 2 * ImGui::GetStyle().FramePadding.x -
                            ImGui::GetStyle().ItemSpacing.x - 0.3F * ImGui::GetFontSize());
    ImGui::InputTextWithHint("##path", "a file that ends in .glb", form.path, fields::path_bytes);
    ui::control("export", "path", "Mesh, colours and camera in one file, for any viewer or modelling program.");
    ImGui::SameLine();
    if (ImGui::Button("Browse")) {
        form.browsing = true;
        commands.push(BrowseFor{FileFilter::meshes, form.path});
    }
    ui::mark("export", "browse");
    fields::destination("export", form.path);
    fields::choice(
        "Mesh", "export", "own", form.own, kinds,
        "As drawn now: the triangles that the camera sees, morphed, as fine as the budgets allowed. A custom "
        "threshold refines the whole terrain for this view, whatever the budgets.");
    fields::label("Converged");
    ImGui::BeginDisabled(form.own == 1);
    bool converged = form.converged || form.own == 1;
    if (ImGui::Checkbox("##converged", &converged) && form.own == 0) form.converged = converged;
    ImGui::EndDisabled();
    ui::control("export", "converged",
                "Waits until the mesh of this view needs no more work, instead of taking the mesh of this frame.");
    ImGui::BeginDisabled(form.own == 0);
    double shown = form.own == 1 ? form.error_px : state.measures.last().error_bound_px;
    fields::number("Pixels", "export", "error_px", shown, "%.4g",
                   "0.01 to 1,000 pixels: a smaller threshold makes a larger file.");
    if (form.own == 1) form.error_px = shown;
    ImGui::EndDisabled();
    fields::number("Texel, m", "export", "texel_m", form.texel_m, form.texel_m > 0 ? "%.6g" : "as the maps",
                   "The size of a texel of its textures, in metres: larger ones make a smaller file. 0: as fine as the "
                   "maps are.");
    form.texel_m = std::max(form.texel_m, 0.0);
    constexpr const char* textures[] = {"PNG", "JPEG"};
    fields::choice("Colours", "export", "texture", form.texture, textures,
                   "PNG loses nothing, JPEG is smaller. Normals and occlusion are always PNG.");
    fields::label("16 bits");
    ImGui::Checkbox("##quantised", &form.quantised);
    ui::control("export", "quantised",
                "16 bits a number instead of 32 (KHR_mesh_quantization). The file says what this rounds.");
    fields::label("Compressed");
    ImGui::Checkbox("##meshopt", &form.meshopt);
    ui::control("export", "meshopt", "EXT_meshopt_compression: smaller still, but not all viewers read it.");
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open();
    const auto mesh = [&form](const char* path) {
        return ExportMesh{
            path,         form.converged,   form.own == 1 ? form.error_px : 0, form.texel_m, form.quantised,
            form.meshopt, form.texture == 1};
    };
    if (fields::button("Preview", "export", "preview", can,
                       "Shows the counts and the size of the file to the byte. Writes nothing."))
        commands.push(PreviewExport{mesh("")});
    ImGui::SameLine();
    if (fields::button("Export", "export", "start", can && form.path[0] != '\0',
                       "Writes the file; an existing one is replaced only when it is complete.", true))
        commands.push(mesh(form.path));
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
    if (!form.browsing) return;
    const NestedBrowser done = draw_nested_browser(state, commands, form.browser, file_name(form.path));
    if (done == NestedBrowser::chose) {
        std::string path = state.files.browser.path_of(form.browser.name);
        if (!path.ends_with(".glb")) path += ".glb";
        fields::copy(form.path, path);
    }
    form.browsing = done == NestedBrowser::open;
    if (!form.browsing) form.browser = {};
}

void draw_screenshot(const State&, PanelState& own, Commands& commands) {
    ScreenshotForm& form = own.screenshot;
    constexpr const char* kinds[] = {"the terrain", "the window, with its panels"};
    ui::focus_first();
    fields::path("Picture", "screenshot", "path", form.path, "a file that ends in .png", "Where the PNG is written.");
    fields::destination("screenshot", form.path);
    fields::choice("Contents", "screenshot", "what", form.what, kinds, "At the current size of the window.");
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
    ui::control("status", "cancel-job",
                "Stops the job; no partial file remains. A bake may keep a folder from which it can resume.");
    ImGui::SameLine();
}

// --- Auto-tune and benchmark: forms and outcomes that stay beside the picture while they run.

namespace {

// What will be flown.
void draw_flight(const State& state) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(ImColor(ui::quiet).Value,
                       "Flies %s with this profile, in a view of %u x %u. The terrain is loaded a second time.",
                       state.route.flight_name().text, state.document.profile().width_px,
                       state.document.profile().height_px);
    ImGui::PopTextWrapPos();
}

constexpr const char* measures[] = {"update (CPU)", "whole frame"};

void draw_tune_form(TuneForm& form) {
    fields::number("Budget, ms", "auto-tune", "budget_ms", form.budget_ms, "%.6g",
                   "The time that 99% of the frames (p99) must not exceed: 0.01 to 1,000 milliseconds. A frame at 60 "
                   "Hz has 16.7.");
    fields::choice("Measure", "auto-tune", "measure", form.measure, measures,
                   "Update: CPU time of refinement and streaming. Whole frame: upload and drawing too, in a picture "
                   "of the profile's size. It takes longer and depends on the graphics driver.");
    fields::whole("Frames, 0: auto", "auto-tune", "frames", form.frames,
                  "Frames of a flight, 10 to 100,000. With 0 a path is flown at 60 Hz, and an orbit takes 840 frames. "
                  "Fewer frames fly the same path faster, with more changes in each.");
    fields::label("Thresholds, px");
    ImGui::PushID("range");
    float width = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    ImGui::SetNextItemWidth(width);
    ImGui::InputDouble("##least", &form.least_px, 0, 0, "%.4g");
    ui::control("auto-tune", "least_px", "The smallest threshold to try, in pixels.");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 0.3F);
    ImGui::InputDouble("##most", &form.most_px, 0, 0, "%.4g");
    ui::control("auto-tune", "most_px", "The largest threshold to try, in pixels. The search begins with it.");
    ImGui::PopID();
    ImGui::Checkbox("Off-screen, hysteresis, morphing too", &form.also);
    ui::control("auto-tune", "also",
                "Tries other off-screen factors and hystereses, and keeps those that make frames cheaper, so that a "
                "smaller threshold fits. Switches morphing on where it fits as well. (Incremental.)");
}

void draw_tune_result(const State& state, const JobView& shown, Commands& commands) {
    if (shown.running || shown.best_px <= 0) return;
    char text[48];
    const Profile& profile = state.document.profile();
    bool used = profile.refine.max_error_px == shown.best_px;
    for (const TunedKey& t : shown.tuned_keys) used = used && t.key->get(profile) == t.value;
    if (shown.tuned_keys.empty())
        std::snprintf(text, sizeof text, "Use %.3g px", shown.best_px);
    else
        std::snprintf(text, sizeof text, "Use %.3g px and these", shown.best_px);
    ImGui::SameLine();
    if (fields::button(text, "auto-tune", "use", !used, "Sets the profile to what was found; one undo step."))
        commands.push(UseTuned{});
    for (const TunedKey& t : shown.tuned_keys) {
        Profile tuned = profile;
        t.key->set(tuned, t.value);
        ui::row(t.key->label, "%s", value_text(*t.key, tuned).c_str());
    }
}

} // namespace

void draw_auto_tune(const State& state, PanelState& own, Commands& commands) {
    TuneForm& form = own.tune;
    draw_tune_form(form);
    draw_flight(state);
    const bool can = !state.job.running && state.scene.open();
    if (fields::button("Start", "auto-tune", "start", can,
                       "Flies the path repeatedly, to find the smallest threshold whose p99 is within the budget.")) {
        TuneThreshold t;
        t.settings = {form.measure == 1 ? TuneMeasure::frame : TuneMeasure::update,
                      form.budget_ms * 1000,
                      static_cast<std::uint32_t>(form.frames),
                      form.least_px,
                      form.most_px,
                      false,
                      form.also};
        commands.push(t);
    }
    const bool running = fields::runs(state, JobKind::tune);
    if (running) fields::cancel("auto-tune", commands);
    const JobView& shown = state.job.kind == JobKind::tune ? state.job : state.tuned;
    draw_tune_result(state, shown, commands);
    fields::outcome(state, JobKind::tune);
    draw_tune_curve(shown, 16 * ImGui::GetFontSize());
}

void draw_benchmark(const State& state, PanelState& own, Commands& commands) {
    CsvForm& form = own.benchmark;
    fields::suggest(form.path, form.made_for, state, ".csv");
    fields::path("CSV", "benchmark", "path", form.path, "a file",
                 "One line for each frame, with the columns of fjell-fly --csv.");
    fields::whole("Frames, 0: auto", "benchmark", "frames", form.frames,
                  "With 0 a path is flown at 60 Hz, and an orbit takes 840 frames. Fewer frames fly the same path "
                  "faster.");
    draw_flight(state);
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open() && form.path[0] != '\0';
    if (fields::button("Run", "benchmark", "start", can, "Starts at once and flies as fast as possible."))
        commands.push(RunBenchmark{form.path, static_cast<std::size_t>(form.frames)});
    if (fields::runs(state, JobKind::benchmark)) fields::cancel("benchmark", commands);
    fields::outcome(state, JobKind::benchmark);
    draw_runs(state, commands);
}

// --- Bookmarks, and pictures rendered beside the frame: larger than the window, or one for each frame of the path.

void draw_bookmarks(const State& state, PanelState& own, Commands& commands) {
    auto& name = own.bookmark_name;
    const float add = ImGui::CalcTextSize("Add").x + 2 * ImGui::GetStyle().FramePadding.x;
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - add - ImGui::GetStyle().ItemSpacing.x);
    const bool entered =
        ImGui::InputTextWithHint("##name", "a name, or none", name, sizeof name, ImGuiInputTextFlags_EnterReturnsTrue);
    ui::control("bookmark", "name", "The name of the bookmark. Without a name it gets a number.");
    ImGui::SameLine();
    if (ImGui::Button("Add") || entered) {
        commands.push(AddBookmark{name});
        name[0] = '\0';
    }
    ui::control("bookmark", "add", "Remembers the camera's place.");
    std::size_t index = 0;
    char mark[24];
    for (const Bookmark& b : state.bookmarks.all) {
        if (b.pack != state.bookmarks.pack) continue;
        ui::need_glyphs(b.name);
        ImGui::PushID(static_cast<int>(index));
        if (ImGui::SmallButton("x")) commands.push(RemoveBookmark{index});
        std::snprintf(mark, sizeof mark, "remove.%zu", index);
        ui::control("bookmark", mark, "Removes this bookmark.");
        ImGui::SameLine();
        if (ImGui::Selectable(b.name.c_str())) commands.push(GoToBookmark{index});
        std::snprintf(mark, sizeof mark, "go.%zu", index);
        ui::control("bookmark", mark, "Looks from there.");
        ImGui::PopID();
        ++index;
    }
    if (index == 0) {
        ui::note("This terrain has none yet.");
    }
}

void draw_render(const State& state, PanelState& own, Commands& commands) {
    RenderForm& form = own.render;
    fields::suggest(form.file, form.made_for, state, ".png");
    fields::path("Picture", "render", "path", form.file, "a file that ends in .png", "Where the PNG is written.");
    fields::whole("Width, px", "render", "width", form.width, "The picture's size; the window's size does not matter.");
    fields::whole("Height, px", "render", "height", form.height,
                  "The picture's size; the window's size does not matter.");
    const bool can =
        !state.job.running && state.scene.open() && form.file[0] != '\0' && form.width >= 16 && form.height >= 16;
    if (fields::button(
            "Render", "render", "start", can,
            "Draws in the background. Every picture keeps the threshold, whatever the budgets. A picture wider "
            "than the profile's view is refined further, as for a larger screen."))
        commands.push(
            RenderPicture{form.file, static_cast<std::uint32_t>(form.width), static_cast<std::uint32_t>(form.height)});
    if (fields::runs(state, JobKind::picture)) fields::cancel("render", commands);
    fields::outcome(state, JobKind::picture);
}

} // namespace fjell::editor
