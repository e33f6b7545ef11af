// When there is something to draw: an editor at rest waits for input, and a frame whose terrain looks as before shows
// the picture that is there.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "editor/app.h"
#include "editor/files/persistence.h"
#include "editor/panels/ui.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

constexpr double stirred_for_s = 0.3;               // dialogs dim, lists open: what ImGui does over several frames
constexpr std::uint64_t stirred_frames = 3;         // a command, what it changes, and where things then lie
constexpr double look_s = 0.1, look_soon_s = 0.002; // for signals and jobs, which wake nobody; and while a test asks

// What shows in panels alone. Everything else may show in the terrain's picture.
bool only_panels(const Command& command) {
    return std::holds_alternative<MoveCamera>(command) || std::holds_alternative<ShowPanel>(command) ||
           std::holds_alternative<ShowDialog>(command) || std::holds_alternative<ArrangeColumn>(command) ||
           std::holds_alternative<FloatPanel>(command) || std::holds_alternative<PlacePanel>(command) ||
           std::holds_alternative<PointProbe>(command) || std::holds_alternative<MarkPlace>(command) ||
           std::holds_alternative<ClearMarks>(command) || std::holds_alternative<SetSwitch>(command) ||
           std::holds_alternative<ChooseFrame>(command) || std::holds_alternative<HoldMeasures>(command) ||
           std::holds_alternative<ZoomGraphs>(command) || std::holds_alternative<DismissMessage>(command) ||
           std::holds_alternative<BakePack>(command) || std::holds_alternative<BrowseFolder>(command) ||
           std::holds_alternative<BrowseFor>(command) || std::holds_alternative<DraftBake>(command) ||
           std::holds_alternative<GiveBakeFile>(command) || std::holds_alternative<BrowseAllKinds>(command) ||
           std::holds_alternative<SetHeat>(command) || std::holds_alternative<ForgetRun>(command);
}

} // namespace

void App::stir() {
    stirred_s_ = state_.now_s;
    stirred_frame_ = state_.frame;
}

void App::note(const Command& command) {
    if (std::holds_alternative<MoveCamera>(command)) return; // of every frame; the view tells whether it moved
    stir();
    const auto* const file = std::get_if<OpenFile>(&command);
    const bool read_by_thread = file != nullptr && engine_.opening() && file->path == state_.opening;
    if (!read_by_thread && !only_panels(command)) redraw();
}

void App::redraw() {
    picture_old_ = true;
    band_row_ = 0;
}

void App::judge_picture() {
    moving_ = engine_.is_open() && shown_ != nullptr && std::memcmp(&drawn_view_, &state_.eye.view, sizeof(View)) != 0;
    const flight::FrameEntry& e = entry_;
    const StreamReport& r = e.stream;
    mesh_changed_ = e.rebuilt || e.activations != 0 || e.deactivations != 0 || e.morphing != 0 || e.upload_bytes != 0 ||
                    (e.streamed && (!r.maps_converged || r.mips_uploaded != 0));
    const bool reading = state_.shows(Overlay::error) && state_.heights_share >= 0 && state_.heights_share < 1;
    const Interface& i = state_.interface;
    const bool sized = shown_ == target_.get() && target_ &&
                       (target_->width() != i.view_width_px || target_->height() != i.view_height_px);
    if (moving_ || mesh_changed_ || reading || sized || shown_ == nullptr || state_.route.recording()) redraw();
    if (!after_frame_.empty() && shown_ != target_.get()) redraw();
    if (compared_changed_ || drawn_terrain_ != engine_.terrains()) redraw();
    if (picture_old_ && engine_.is_open()) stir();
}

bool App::at_rest() const {
    const bool stirred = state_.now_s - stirred_s_ < stirred_for_s || state_.frame < stirred_frame_ + stirred_frames;
    const bool script = script_at_ < script_.size() || waiting_settled_ || state_.frame < wait_until_frame_;
    if (stirred || script || options_.frames != 0 || state_.quit) return false;
    if (!after_frame_.empty() || !next_frame_.empty() || !surface_->dropped.empty()) return false;
    if (!engine_.is_open()) return true;
    if (!comparison_.settled()) return false;
    const bool plays = state_.route.playing() || state_.route.recording();
    return !plays && !picture_old_ && !state_.probe.looking && (settled() || jobs_.running());
}

double App::next_change_s() const {
    double next_s = 3600;
    const double tip_s = ui::tip_due_s();
    if (tip_s > 0) next_s = tip_s;
    for (const double until_s : {state_.messages.shown_until_s, state_.eye.speed_shown_until_s})
        if (until_s > frame_s_) next_s = std::min(next_s, until_s - frame_s_);
    if (ImGui::GetIO().WantTextInput) next_s = std::min(next_s, 0.5); // the caret blinks
    if (jobs_.running()) next_s = std::min(next_s, 1.0);              // how long it has run
    return next_s;
}

void App::rest() {
    frame_s_ = state_.now_s; // of the frame that was drawn last
    if (!at_rest()) return;
    const double begun_s = state_.now_s, until_s = begun_s + next_change_s();
    const auto begun = Clock::now();
    const double look = dump_is_wanted() ? look_soon_s : look_s;
    while (state_.now_s < until_s) {
        io::check_interrupt();
        const bool event = surface_->wait(std::clamp(until_s - state_.now_s, 0.001, look));
        state_.now_s = begun_s + microseconds(Clock::now() - begun) * 1e-6;
        if (event || surface_->should_close()) {
            stir();
            break;
        }
        if (dump_asked_for() || jobs_.news() || look_.news() || overview_.news() || engine_.opening_done()) break;
        update_file_state(state_); // what is not saved is kept at its time, frames or not
    }
    if (state_.now_s >= until_s) stirred_frame_ = state_.frame; // a tip takes a frame to find its size
    rested_ = state_.now_s - begun_s;
    state_.rested_s += rested_;
}

} // namespace fjell::editor
