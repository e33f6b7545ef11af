// Makes the functions that Jobs::start() runs. Each copies what it needs of the state, which the frame may then change.
//
// Thread: made on the frame's, run on the job's. Failure: io::Failure at once for settings out of range and outputs
// that would overwrite inputs; later ones end the job. What is cancelled leaves no file, but for a bake's own folder,
// from which it can go on.
#pragma once

#include <memory>
#include <string>

#include "baker/bake/recipe.h"
#include "editor/command.h"
#include "editor/jobs/flights.h"
#include "editor/jobs/jobs.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/pack_file.h"

namespace fjell::editor {

// --- bakes
[[nodiscard]] Jobs::Body bake_job(BakePack bake);
// Its options, as fjell-bake has them. Failure: io::Failure.
[[nodiscard]] baker::Recipe bake_recipe(const BakePack& bake);
// The pack's name beside its heights: mountains.tif becomes mountains.fjell.
[[nodiscard]] std::string pack_beside(const std::string& input);

// Textures of near ground, from a folder of recipes.
[[nodiscard]] Jobs::Body materials_job(const std::string& recipes, const std::string& output);

// --- flights that measure
[[nodiscard]] Jobs::Body tune_job(MeasuredFlightPlan plan, const TuneSettings& settings, const std::string& csv);
[[nodiscard]] Jobs::Body benchmark_job(MeasuredFlightPlan plan, const std::string& csv);

// --- exports
struct ExportPlan {
    std::shared_ptr<const io::PackFile> pack; // of the frame's terrain
    std::string path;                         // empty: counts and size alone
    gltf::Snapshot frame;  // what is written as it stands; empty: what follows is refined for the view
    bool streamed = false; // the frame's terrain is: then so is this one's
    Profile profile;
    View view;
    double error_px = 0; // the whole terrain at this threshold, whatever the budgets; 0: as the profile settles on
    double texel_m = 0;  // of its textures; 0: as fine as the maps are
    std::shared_ptr<const session::GroundLayers> layers = {}; // drawn over its colours, as the profile says
    bool quantised = false, meshopt = false, jpeg = false;    // what makes it smaller (gltf::SnapshotOptions)
};
[[nodiscard]] Jobs::Body export_job(ExportPlan plan);

// --- pictures
struct PicturePlan {
    std::shared_ptr<const io::PackFile> pack; // of the frame's terrain
    std::shared_ptr<const session::GroundLayers> layers;
    std::string path;
    Profile profile; // with the picture's size
    session::PictureMode mode = session::PictureMode::shaded;
    session::Pose pose;
};
[[nodiscard]] Jobs::Body picture_job(PicturePlan plan);

} // namespace fjell::editor
