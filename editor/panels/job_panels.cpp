// Auto-tune and benchmark: forms and outcomes that stay beside the picture while they run.
#include <algorithm>
#include <cstdio>
#include <string>

#include "editor/panels/fields.h"
#include "editor/panels/panels.h"
#include "editor/panels/runs.h"
#include "editor/panels/tune_curve.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

namespace {

// What will be flown.
void draw_flight(const State& state) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(
        ImColor(ui::quiet).Value,
        "Flies %s as the profile says, over a terrain that is loaded once more for this, in a view of %u x %u.",
        state.route.flight_name().text, state.document.profile().width_px, state.document.profile().height_px);
    ImGui::PopTextWrapPos();
}

// ---- tune

struct TuneForm {
    double budget_ms = TuneSettings{}.budget_us / 1000, least_px = TuneSettings{}.least_px,
           most_px = TuneSettings{}.most_px;
    int measure = 0, frames = 0;
};

constexpr const char* measures[] = {"update (CPU)", "whole frame"};

void draw_tune_form(TuneForm& form) {
    fields::number("Budget, ms", "auto-tune", "budget_ms", form.budget_ms, "%.6g",
                   "The time that 99% of the frames (p99) must not exceed: 0.01 to 1,000 milliseconds. A frame at 60 "
                   "Hz has 16.7.");
    fields::choice("Measure", "auto-tune", "measure", form.measure, measures, 2,
                   "Update: CPU time of refinement and streaming. Whole frame: with upload and drawing, in a picture "
                   "as large as the profile says; slower, and dependent on the graphics driver.");
    fields::whole("Frames, 0: auto", "auto-tune", "frames", form.frames,
                  "Frames of a flight, 10 to 100,000; 0: as many as the path has at 60 Hz, or 840 for an orbit if "
                  "there is no path. Fewer frames fly the same path faster, with more changes in each.");
    fields::label("From, to, px");
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
    ui::tip("The largest threshold, in pixels: the search begins there.");
    ImGui::PopID();
}

void draw_tune_result(const State& state, const JobView& shown, Commands& commands) {
    if (shown.running || shown.best_px <= 0) return;
    char text[48];
    std::snprintf(text, sizeof text, "Use %.3g px", shown.best_px);
    const flight::ProfileKey* const key = flight::find_profile_key("refine.error_px");
    const bool used = key->get(state.document.profile()) == shown.best_px;
    ImGui::SameLine();
    if (fields::button(text, "auto-tune", "use", !used, "Sets the threshold of the profile; one undo step."))
        commands.push(SetKey{key, shown.best_px, false});
}

struct CsvForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText path = "";
    int frames = 0;
};

} // namespace

void draw_auto_tune(const State& state, Commands& commands) {
    static TuneForm form;
    draw_tune_form(form);
    draw_flight(state);
    const bool can = !state.job.running && state.scene.open();
    if (fields::button("Start", "auto-tune", "start", can,
                       "Flies again and again until the smallest threshold is found whose p99 keeps the budget.")) {
        TuneThreshold t;
        t.settings = {form.measure == 1 ? TuneMeasure::frame : TuneMeasure::update,
                      form.budget_ms * 1000,
                      static_cast<std::uint32_t>(form.frames),
                      form.least_px,
                      form.most_px,
                      false};
        commands.push(t);
    }
    const bool running = fields::runs(state, JobKind::tune);
    if (running) fields::cancel("auto-tune", commands);
    const JobView& shown = state.job.kind == JobKind::tune ? state.job : state.tuned;
    draw_tune_result(state, shown, commands);
    fields::outcome(state, JobKind::tune);
    draw_tune_curve(shown, std::max(ImGui::GetContentRegionAvail().y, 16 * ImGui::GetFontSize()));
}

void draw_benchmark(const State& state, Commands& commands) {
    static CsvForm form;
    fields::suggest(form.path, form.made_for, state, ".csv");
    fields::path("CSV", "benchmark", "path", form.path, "a file",
                 "One line for each frame, with the columns of fjell-fly --csv.");
    fields::whole("Frames, 0: auto", "benchmark", "frames", form.frames,
                  "0: as many as the path has at 60 Hz, or 840 for an orbit if there is no path. Fewer frames fly the "
                  "same path faster.");
    draw_flight(state);
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open() && form.path[0] != '\0';
    if (fields::button("Run", "benchmark", "start", can, "Starts at once and flies as fast as possible."))
        commands.push(RunBenchmark{form.path, static_cast<std::size_t>(form.frames)});
    if (fields::runs(state, JobKind::benchmark)) fields::cancel("benchmark", commands);
    fields::outcome(state, JobKind::benchmark);
    draw_runs(state, commands);
}

} // namespace fjell::editor
