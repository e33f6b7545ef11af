// What jobs do, ready for Jobs::start(). Each copies what it needs of the state: the frame goes on as it likes.
//
// Thread: made on the frame's, run on the job's. Failure: io::Failure at once for settings out of range and outputs
// that would overwrite inputs; later ones end the job. What is cancelled leaves no file, but for a bake's own folder,
// from which it can go on.
#pragma once

#include <string>

#include "editor/command.h"
#include "editor/jobs/jobs.h"
#include "editor/jobs/measured_flight.h"

namespace fjell::editor {

// job_bake.cpp
[[nodiscard]] Jobs::Body bake_job(BakePack bake);
// The pack's name beside its heights: mountains.tif becomes mountains.fjell.
[[nodiscard]] std::string pack_beside(const std::string& input);

// job_benchmark.cpp
[[nodiscard]] Jobs::Body tune_job(MeasuredFlightPlan plan, const TuneSettings& settings, const std::string& csv);
[[nodiscard]] Jobs::Body benchmark_job(MeasuredFlightPlan plan, const std::string& csv);

// job_export.cpp
struct ExportPlan {
    std::string pack, path; // path empty: counts and size alone
    bool streamed = false;  // the frame's terrain is: then so is this one's
    flight::Profile profile;
    View view;
    double error_px = 1; // without the corner's share
};
[[nodiscard]] Jobs::Body export_job(ExportPlan plan);

} // namespace fjell::editor
