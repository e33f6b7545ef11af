// Auto-tune and benchmark: forms and outcomes that stay beside the picture while they run.
#include <algorithm>
#include <cstdio>
#include <string>

#include "editor/panels/fields.h"
#include "editor/panels/panels.h"
#include "editor/panels/runs.h"
#include "editor/panels/tune_curve.h"
#include "editor/strings.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

namespace {

// What will be flown.
void draw_flight(const State& state) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(ImColor(ui::quiet).Value, strings::job_panels::about_flight, state.route.flight_name().text,
                       state.document.profile().width_px, state.document.profile().height_px);
    ImGui::PopTextWrapPos();
}

// ---- tune

struct TuneForm {
    double budget_ms = TuneSettings{}.budget_us / 1000, least_px = TuneSettings{}.least_px,
           most_px = TuneSettings{}.most_px;
    int measure = 0, frames = 0;
};

constexpr const char* measures[] = {strings::job_panels::update_cpu, strings::job_panels::whole_frame};

void draw_tune_form(TuneForm& form) {
    fields::number(strings::job_panels::budget_ms, "auto-tune", "budget_ms", form.budget_ms, "%.6g",
                   strings::job_panels::about_budget);
    fields::choice(strings::job_panels::measure, "auto-tune", "measure", form.measure, measures, 2,
                   strings::job_panels::about_measure);
    fields::whole(strings::job_panels::frames, "auto-tune", "frames", form.frames, strings::job_panels::about_frames);
    fields::label(strings::job_panels::threshold_range);
    ImGui::PushID("range");
    float width = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    ImGui::SetNextItemWidth(width);
    ImGui::InputDouble("##least", &form.least_px, 0, 0, "%.4g");
    ui::mark("auto-tune", "least_px");
    ui::tip(strings::job_panels::about_smallest);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 0.3F);
    ImGui::InputDouble("##most", &form.most_px, 0, 0, "%.4g");
    ui::mark("auto-tune", "most_px");
    ui::tip(strings::job_panels::about_largest);
    ImGui::PopID();
}

void draw_tune_result(const State& state, const JobView& shown, Commands& commands) {
    if (shown.running || shown.best_px <= 0) return;
    char text[48];
    std::snprintf(text, sizeof text, strings::job_panels::use_threshold, shown.best_px);
    const flight::ProfileKey* const key = flight::find_profile_key("refine.error_px");
    const bool used = key->get(state.document.profile()) == shown.best_px;
    ImGui::SameLine();
    if (fields::button(text, "auto-tune", "use", !used, strings::job_panels::about_use_threshold))
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
    if (fields::button(strings::job_panels::start, "auto-tune", "start", can, strings::job_panels::about_start)) {
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
    fields::path(strings::job_panels::csv, "benchmark", "path", form.path, strings::job_panels::csv_hint,
                 strings::job_panels::about_csv);
    fields::whole(strings::job_panels::frames, "benchmark", "frames", form.frames,
                  strings::job_panels::about_benchmark_frames);
    draw_flight(state);
    ImGui::Separator();
    const bool can = !state.job.running && state.scene.open() && form.path[0] != '\0';
    if (fields::button(strings::job_panels::run, "benchmark", "start", can, strings::job_panels::about_run))
        commands.push(RunBenchmark{form.path, static_cast<std::size_t>(form.frames)});
    if (fields::runs(state, JobKind::benchmark)) fields::cancel("benchmark", commands);
    fields::outcome(state, JobKind::benchmark);
    draw_runs(state, commands);
}

} // namespace fjell::editor
