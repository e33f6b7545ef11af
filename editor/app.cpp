#include "editor/app.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>

#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include "editor/dump.h"
#include "editor/files/listing.h"
#include "editor/files/persistence.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/work.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/panels/ui.h"
#include "fjell/gl/image.h"
#include "fjell/io/failure.h"
#include "gl/objects.h"
#include "io/file.h"
#include "session/session.h"

namespace fjell::editor {

namespace {

using io::Failure;

// SIGUSR1 asks for FJELL_EDITOR_DUMP: how tests look inside.
volatile std::sig_atomic_t dump_requested = 0;
const char* dump_file() {
    static const char* const file = std::getenv("FJELL_EDITOR_DUMP");
    return file;
}

constexpr double stirred_for_s = 0.3;               // dialogs dim, lists open: what ImGui does over several frames
constexpr std::uint64_t stirred_frames = 3;         // a command, what it changes, and where things then lie
constexpr double look_s = 0.1, look_soon_s = 0.002; // for signals and jobs, which wake nobody; and while a test asks

// A terrain that is only rebuilt, for other budgets, looks the same from above.
bool looks_the_same(const OverviewSource& now, const OverviewSource& source) {
    if (!now.pack || !source.pack) return now.pack == source.pack;
    const gl::LayerSettings &a = now.settings, &b = source.settings;
    return now.pack->pack().header.directory_hash == source.pack->pack().header.directory_hash &&
           now.layers == source.layers && (!now.layers || (a.on == b.on && a.tint == b.tint && a.splat == b.splat));
}

// What shows in panels alone. Everything else may show in the terrain's picture.
template <typename... C>
bool is_one_of(const Command& command) {
    return (std::holds_alternative<C>(command) || ...);
}
bool only_panels(const Command& command) {
    return is_one_of<MoveCamera, ShowPanel, ShowGroup, ShowDialog, ArrangeColumn, FloatPanel, PlacePanel, PointProbe,
                     MarkPlace, ClearMarks, SetBrush, SetSwitch, ChooseFrame, HoldMeasures, ZoomGraphs, DismissMessage,
                     BakePack, BrowseFolder, BrowseFor, DraftBake, GiveBakeFile, BrowseAllKinds, SetHeat, ForgetRun>(
        command);
}

void write_text(const std::string& path, const std::string& text) {
    io::AtomicFile file(path);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

} // namespace

App::App(Options options) : options_(std::move(options)) {
    script_.read(options_.commands, options_.script);
    if (!options_.materials.empty()) {
        engine_.set_layers(std::make_shared<const session::GroundLayers>(
            session::read_ground_layers(options_.materials, options_.layers)));
        state_.materials.materials = options_.materials;
        state_.materials.rules = options_.layers;
        state_.materials.of_this_run = true;
    }
    // Before there is a window: whoever sees that may ask already.
    if (dump_file() != nullptr) std::signal(SIGUSR1, [](int) { dump_requested = 1; });
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.UserData = &panels_.ui;
    io.IniFilename = nullptr; // the state is ours to keep
    io.LogFilename = nullptr;
    state_.headless = options_.headless;
    if (options_.script != "-") state_.files.script = options_.script;
    start_persistence(state_, !options_.headless);
    if (options_.width == 0) { // the size it had, or ours
        const Look last = options_.headless ? Look{} : state_.files.settings.look;
        options_.width = last.width_px != 0 ? last.width_px : 1280;
        options_.height = last.height_px != 0 ? last.height_px : 720;
    }
    make_surface_and_graphics();
    double& scale = state_.interface.scale;
    scale = options_.scale;
    if (scale <= 0 && !options_.headless) scale = state_.files.settings.look.scale;
    if (scale <= 0) scale = std::clamp(surface_->content_scale(), 0.5, 4.0);
    ui::apply_style(scale);
    styled_ = scale;
}

App::~App() {
    finish_persistence(state_, ended_);
    jobs_.cancel();
    engine_.abandon_opening();
    drop_graphics();
    engine_.close();
    surface_.reset();
    ImGui::DestroyContext();
}

// Before the context goes.
void App::drop_graphics() {
    picture_.drop_graphics();
    overview_.drop_graphics(state_.overview);
    gpu_timer_.drop_graphics();
    comparison_.drop_graphics();
    preview_.drop_graphics(state_.bake);
    engine_.drop_graphics();
}

void App::make_surface_and_graphics() {
    surface_ = make_surface({options_.headless, options_.width, options_.height, options_.vsync});
    shown_title_.clear();
    engine_.set_second_context(surface_->second_context());
    state_.graphics = surface_->description();
    for (const char* name : {"llvmpipe", "softpipe", "SwiftShader"})
        state_.software = state_.software || state_.graphics.find(name) != std::string::npos;
    if (!options_.headless) rehearse_blit(*surface_);
    picture_.redraw();
}

// Everything on the GPU is gone, or shall be: what is open and edited stays.
void App::replace_surface() {
    std::uint32_t width = 0, height = 0;
    surface_->size(width, height);
    options_.width = std::max(width, 320u);
    options_.height = std::max(height, 320u);
    drop_graphics();
    const InputCounts counted = surface_->input;
    surface_.reset();
    for (int left = 20;; --left) { // a driver that resets takes a while
        try {
            make_surface_and_graphics();
            break;
        } catch (const Failure&) {
            if (left == 0) throw; // what is not saved is kept for the next start
            std::this_thread::sleep_for(std::chrono::milliseconds(250));
        }
    }
    surface_->input = counted;
    engine_.make_graphics();
    preview_.set(state_.bake);
    post_message(state_, Severity::warning, "the graphics driver was reset; all GPU resources were recreated");
}

int App::run() {
    if (!options_.profile.empty()) // a bad one is an error of the command line
        for (std::string& line : state_.document.open(options_.profile))
            post_message(state_, Severity::warning, std::move(line));
    if (!options_.pack.empty())
        open_input();
    else
        state_.interface.dialog = Dialog::start;
    if (!options_.path.empty()) {
        const OpenPath path{options_.path, true};
        if (baking_input_)
            script_.put_first(path);
        else
            apply(path, context());
    }
    if (!baking_input_ && !engine_.is_open() && state_.interface.dialog == Dialog::none)
        state_.interface.dialog = Dialog::start;
    if (state_.files.persists && state_.files.recovery.found()) state_.interface.dialog = Dialog::recover;
    while (!state_.quit) {
        io::check_interrupt();
        if (surface_->lost()) replace_surface();
        if (!run_script()) break;
        if (!options_.headless) rest();
        frame();
        // Nothing else holds a headless run back; what a job measures is not to be disturbed by it.
        if (options_.headless && jobs_.running()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
        if (baking_input_) {
            show_baking();
            continue;
        }
        const std::uint64_t least = script_.empty() ? 1 : 2; // a script begins after the first frame
        const bool last = options_.frames != 0 && state_.frame >= std::max(options_.frames, least);
        if (last && !options_.screenshot.empty()) {
            after_frame_.emplace_back(TakeScreenshot{options_.screenshot, true});
            frame();
        }
        if (last) break;
    }
    ended_ = true;
    return options_.headless ? state_.exit_code : 0;
}

void App::frame() {
    const auto start = Clock::now();
    const double since_us = frame_began_ == Clock::time_point{} ? 0 : microseconds(start - frame_began_);
    frame_began_ = start;
    // What the editor rested has passed, and nothing moved in it.
    state_.frame_s = std::clamp(since_us * 1e-6 - std::exchange(rested_, 0), 0.0, 0.25);
    state_.now_s += state_.frame_s;
    if (options_.headless) state_.frame_s = 1.0 / 60;
    ++state_.frame;
    times_ = {};
    dumping_ = dump_requested != 0; // asked for later, it waits for a frame that records its marks
    for (Command& command : next_frame_) after_frame_.push_back(std::move(command));
    next_frame_.clear();
    const bool recording = dumping_ || !after_frame_.empty();
    if (recording) ui::record_marks(true);
    {
        const OwnCode own(watch_);
        follow_overview(); // before the panels, which show its texture
    }
    times_.editor_us = interface();
    times_.editor_us += handle_commands();
    attempt([&] { times_.editor_us += move_and_update(); });
    const PictureFrame shown{entry_, !after_frame_.empty(), rehearsed_ != 0, compared_changed_, watch_};
    picture_.judge(state_, engine_, shown);
    const bool drawn = picture_.old();
    if (drawn && engine_.is_open()) stir();
    draw(shown);
    if (recording) ui::record_marks(false);
    state_.measures.observe(entry_); // before a dump tells of it
    finish_requests();
    const auto present = Clock::now();
    if (!state_.software) {
        gpu_timer_.end();
        times_.gpu_us = gpu_timer_.take_us();
    }
    surface_->present();
    const auto end = Clock::now();
    times_.present_us += microseconds(end - present);
    times_.frame_us = microseconds(end - start);
    const OwnCode own(watch_);
    state_.programs = gl::programs_made();
    state_.longest_frame_us = std::max(std::exchange(dumped_, false) ? 0 : state_.longest_frame_us, times_.frame_us);
    picture_.end_frame(times_);
    state_.measures.record(times_, state_.eye.pose(), drawn);
}

double App::interface() {
    surface_->begin_frame();
    state_.input = surface_->input;
    surface_->size(state_.interface.width_px, state_.interface.height_px);
    const OwnCode own(watch_);
    const auto start = Clock::now();
    keyboard::begin_frame(state_);
    ImGui::NewFrame();
    place_view();
    draw_panels(state_, panels_, commands_);
    ImGui::Render();
    ui::leave_room();
    return microseconds(Clock::now() - start);
}

double App::handle_commands() {
    std::optional<OwnCode> own(watch_);
    const auto start = Clock::now();
    for (const std::string& file : std::exchange(surface_->dropped, {}))
        apply(OpenFile{file, false}, context()), stir();
    for (const Command& command : commands_.list()) {
        // The panels of this frame are drawn already, with the dialog that asked: the next one's are shown.
        if (is_one_of<TakeScreenshot, DumpState>(command))
            next_frame_.push_back(command);
        else
            apply(command, context());
        note(command);
    }
    commands_.clear();
    if (look_.follow(state_.bake)) {
        preview_.set(state_.bake);
        stir();
    }
    if (jobs_.poll(state_.job)) {
        handle_job_result(context());
        if (state_.job.kind != JobKind::bake) picture_.redraw(); // whose terrain is not shown yet
        stir();
    }
    own.reset();
    const auto follow = Clock::now();
    if (engine_.opening_done()) finish_opening();
    follow_document(context()); // rebuilding a terrain is not what the editor costs
    const auto followed = Clock::now();
    own.emplace(watch_);
    update_file_state(state_);
    if (shown_title_ != state_.files.title) {
        shown_title_ = state_.files.title;
        surface_->set_title(shown_title_.c_str());
    }
    for (std::string& line : engine_.take_messages()) post_message(state_, Severity::warning, std::move(line));
    if (surface_->should_close()) {
        surface_->stay_open();
        apply(Quit{}, context());
    }
    return microseconds(Clock::now() - start) - microseconds(followed - follow);
}

double App::move_and_update() {
    entry_ = {};
    compared_changed_ = false;
    if (!engine_.is_open()) return 0;
    const auto start = Clock::now();
    {
        const OwnCode own(watch_);
        move_camera(context(), state_.frame_s);
    }
    const auto moved = Clock::now();
    if (rehearsals_ != 0) { // nothing else is done in these frames
        rehearsed_ = state_.frame;
        engine_.rehearse(state_, --rehearsals_ == 0);
        return microseconds(moved - start);
    }
    {
        const OwnCode own(watch_);
        comparison_.follow(state_, engine_);
    }
    if (!state_.software) gpu_timer_.begin(); // ends when all of the frame was given to the driver
    const View& refining = state_.eye.refining ? *state_.eye.refining : state_.eye.view;
    entry_ = engine_.update(refining, state_.document.profile(), state_.now_s, times_.upload_us);
    compared_changed_ = comparison_.update(state_, refining);
    const OwnCode own(watch_);
    const auto updated = Clock::now();
    const session::Session& session = engine_.session();
    const Vec3& at = state_.eye.view.eye_m;
    state_.materials.under.follow(session, engine_.layers().get(), state_.document.profile().layers, at.x, at.z);
    if (session.streamed) state_.reader = session.streamed->reader();
    state_.measures.count_levels(session.mesh(), session.loaded.pack.header.tile_log2);
    const bool pages = entry_.streamed && (entry_.stream.pages_inserted != 0 || entry_.stream.pages_evicting != 0);
    const bool mesh = entry_.rebuilt || entry_.activations != 0 || entry_.deactivations != 0 || entry_.morphing != 0;
    if (pages) measure_profile(state_.probe, session);
    update_probe(state_.probe, session, state_.eye.view, refining, mesh || pages, state_.scene.coordinates.get());
    follow_ground(state_.ground, engine_.digging(), session, state_.eye.view);
    update_contour_labels(state_.contour_labels, session.terrain(), state_.eye.view,
                          state_.shows(Overlay::contours) ? contour_interval_m(state_) : 0, mesh || pages,
                          60 * state_.interface.scale);
    return microseconds(moved - start) + microseconds(Clock::now() - updated);
}

void App::finish_opening() {
    stir();
    attempt([&] {
        const std::string pack = engine_.finish_opening();
        if (pack.empty()) return;
        show_opened(pack, context());
        rehearsals_ = 2;
    });
    if (!engine_.opening()) state_.opening.clear(); // otherwise another one was asked for meanwhile
}

void App::follow_overview() {
    OverviewSource source;
    if (engine_.is_open()) source = {engine_.session().file, engine_.layers(), state_.document.profile().layers};
    // A slider that is held would begin it anew in every frame.
    if (looks_the_same(overview_of_, source)) {
        overview_of_ = std::move(source); // the file may be another one of the same contents
    } else if (!state_.document.dragging()) {
        overview_of_ = source;
        if (source.pack)
            overview_.begin(std::move(source));
        else
            overview_.end();
    }
    overview_.upload(state_.overview);
}

// Commands look through it, whether a terrain is drawn already or not.
void App::place_view() {
    Interface& i = state_.interface;
    const ui::Layout l = ui::layout(static_cast<float>(i.width_px), static_cast<float>(i.height_px), i);
    i.view_x_px = static_cast<std::uint32_t>(l.view.x);
    i.view_y_px = static_cast<std::uint32_t>(l.view.y);
    i.view_width_px = std::max(static_cast<std::uint32_t>(l.view.width), 1u);
    i.view_height_px = std::max(static_cast<std::uint32_t>(l.view.height), 1u);
}

// What the terrain or the driver refuses in a frame is told; the panels go on.
void App::attempt(const std::function<void()>& what) {
    try {
        what();
    } catch (const std::exception& failure) {
        post_failure(state_, failure);
    }
}

void App::finish_requests() {
    for (const ImWchar c : ImGui::GetIO().InputQueueCharacters) ui::need_glyph(c);
    if (state_.interface.scale != styled_ || ui::glyphs_are_missing()) {
        // The panels of this frame were drawn with the old font; from the next one on with the new.
        styled_ = state_.interface.scale;
        ui::apply_style(styled_);
        surface_->fonts_changed();
        stir();
    }
    if (dumping_ && dump_file() != nullptr) {
        dump_requested = 0;
        attempt([&] { write_text(dump_file(), dump(state_)); });
        dumped_ = true;
    }
    for (const Command& command : std::exchange(after_frame_, {})) {
        attempt([&] {
            if (const auto* shot = std::get_if<TakeScreenshot>(&command)) {
                refuse_overwriting_open_files(state_, shot->path);
                gl::Image image;
                if (shot->with_panels)
                    surface_->read(image);
                else if (picture_.shown() != nullptr)
                    picture_.shown()->read_colour(image);
                gl::write_png(image, shot->path);
            } else if (const auto* file = std::get_if<DumpState>(&command)) {
                refuse_overwriting_open_files(state_, file->path);
                write_text(file->path, dump(state_));
                dumped_ = true;
            }
        });
    }
}

void App::draw(const PictureFrame& frame) {
    const unsigned framebuffer = surface_->framebuffer();
    if (engine_.is_open() && picture_.old() && state_.frame != rehearsed_)
        attempt([&] { picture_.draw(state_, engine_, comparison_, frame, times_); });
    const auto start = Clock::now();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glClearColor(0.06F, 0.065F, 0.075F, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    const Interface& i = state_.interface;
    if (engine_.is_open() && picture_.shown() != nullptr)
        blit(*picture_.shown(), framebuffer, i.height_px,
             {i.view_x_px, i.view_y_px, i.view_width_px, i.view_height_px});
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    surface_->draw_interface();
    times_.present_us = microseconds(Clock::now() - start);
}

// --- What an editor does before and beside its hands: heights given on the command line, and scripts.

// A window asks how heights are to be baked; without one they are baked as that dialog would begin.
void App::open_input() {
    const std::string& input = options_.pack;
    attempt([&] {
        if (!options_.headless || file_kind_of(input) != FileKind::heights)
            return apply(OpenFile{input, true}, context());
        bake_beside(input, context());
        baking_input_ = true;
    });
}

void App::show_baking() {
    if (!jobs_.running()) {
        baking_input_ = false;
        state_.frame = 0; // --frames counts from here
        return;
    }
    if (state_.now_s - baking_shown_s_ < 1) return;
    baking_shown_s_ = state_.now_s;
    fmt::print(stderr, "fjell-editor: baking {}: {} {:.0f}%\n", options_.pack, state_.job.stage,
               100 * state_.job.share);
}

bool App::settled() const {
    if (jobs_.running()) return false;
    if (!engine_.is_open()) return true;
    if (!comparison_.settled()) return false;
    if (state_.shows(Overlay::error) && state_.heights_share >= 0 && state_.heights_share < 1) return false;
    if (state_.probe.looking || state_.ground.waiting != 0 || state_.ground.report.loose != 0) return false;
    if (engine_.stats().ground_waiting != 0) return false; // normals of ground that has moved
    const session::FrameEntry& e = state_.measures.last();
    const StreamReport& r = e.stream;
    // Slots may not suffice for what is wanted, and damaged pages never come: then all is there that will be.
    const bool resting = r.in_flight == 0 && r.pages_left == 0 && r.mips_left == 0 && r.pages_inserted == 0 &&
                         r.mips_uploaded == 0 && r.pages_evicting == 0 && e.activations == 0 && e.deactivations == 0;
    const bool streamed = !e.streamed || (r.converged && r.maps_converged) || resting;
    return state_.measures.frames() > 1 && e.waiting == e.blocked && e.morphing == 0 && streamed;
}

// Carries on with the script where nothing waits. False: a headless run is over.
bool App::run_script() {
    if (baking_input_ || engine_.opening() || rehearsals_ != 0) return true;
    if (state_.frame == 0) return true; // how large the picture is, is known after a frame
    const auto done = [this] { return settled() && overview_.done(); };
    while (const ScriptLine* const line = script_.next(state_.frame, done)) {
        run_line(*line);
        if (engine_.opening() || rehearsals_ != 0) return true;
    }
    return !script_.over(state_.frame, settled()) || !options_.headless || options_.frames != 0;
}

void App::run_line(const ScriptLine& line) {
    if (!line.command) return post_failure(state_, Failure(2, line.problem));
    const Command& command = *line.command;
    if (const auto* wait = std::get_if<WaitFrames>(&command)) {
        script_.wait_until(state_.frame + wait->frames);
    } else if (std::holds_alternative<WaitSettled>(command)) {
        script_.wait_until(state_.frame + 2, true); // what was just asked for shows in the frames that follow
    } else if (is_one_of<TakeScreenshot, DumpState>(command)) {
        after_frame_.push_back(command);
        script_.wait_until(state_.frame + 2); // drawn with what came before it
    } else if (const auto* size = std::get_if<ResizeWindow>(&command)) {
        surface_->resize(size->width, size->height);
        script_.wait_until(state_.frame + 3);
    } else if (std::holds_alternative<LoseGraphics>(command)) {
        replace_surface();
    } else {
        const bool ran = jobs_.running();
        apply(command, context());
        note(command);
        // Heights that a script opens are baked first; what follows is about the terrain.
        if (std::holds_alternative<OpenFile>(command) && options_.headless && !ran && jobs_.running())
            script_.wait_until(state_.frame + 2, true);
    }
}

// --- When there is something to draw: an editor at rest waits for input, and a frame whose terrain looks as before
// shows the picture that is there.

void App::stir() {
    stirred_s_ = state_.now_s;
    stirred_frame_ = state_.frame;
}

void App::note(const Command& command) {
    if (std::holds_alternative<MoveCamera>(command)) return; // of every frame; the view tells whether it moved
    stir();
    const auto* const file = std::get_if<OpenFile>(&command);
    const bool read_by_thread = file != nullptr && engine_.opening() && file->path == state_.opening;
    if (!read_by_thread && !only_panels(command)) picture_.redraw();
}

bool App::at_rest() const {
    const bool stirred = state_.now_s - stirred_s_ < stirred_for_s || state_.frame < stirred_frame_ + stirred_frames;
    if (stirred || script_.goes_on(state_.frame) || options_.frames != 0 || state_.quit) return false;
    if (!after_frame_.empty() || !next_frame_.empty() || !surface_->dropped.empty()) return false;
    if (!engine_.is_open()) return true;
    if (!comparison_.settled()) return false;
    const bool plays = state_.route.playing() || state_.route.recording();
    return !plays && !picture_.old() && !state_.probe.looking && (settled() || jobs_.running());
}

double App::next_change_s() const {
    double next_s = 3600;
    const double tip_s = ui::tip_due_s();
    if (tip_s > 0) next_s = tip_s;
    for (const double until_s : {state_.messages.shown_until_s, state_.eye.speed_shown_until_s})
        if (until_s > frame_s_) next_s = std::min(next_s, until_s - frame_s_);
    if (ImGui::GetIO().WantTextInput) next_s = std::min(next_s, 0.5); // the caret blinks
    if (state_.bake.looking) next_s = std::min(next_s, 0.25);         // how far it is
    if (jobs_.running()) next_s = std::min(next_s, 1.0);              // how long it has run
    return next_s;
}

void App::rest() {
    frame_s_ = state_.now_s; // of the frame that was drawn last
    if (!at_rest()) return;
    const double begun_s = state_.now_s, until_s = begun_s + next_change_s();
    const auto begun = Clock::now();
    const double look = dump_file() != nullptr ? look_soon_s : look_s;
    while (state_.now_s < until_s) {
        io::check_interrupt();
        const bool event = surface_->wait(std::clamp(until_s - state_.now_s, 0.001, look));
        state_.now_s = begun_s + microseconds(Clock::now() - begun) * 1e-6;
        if (event || surface_->should_close()) {
            stir();
            break;
        }
        if (dump_requested != 0 || jobs_.news() || look_.news() || overview_.news() || engine_.opening_done()) break;
        update_file_state(state_); // what is not saved is kept at its time, frames or not
    }
    if (state_.now_s >= until_s) stirred_frame_ = state_.frame; // a tip takes a frame to find its size
    rested_ = state_.now_s - begun_s;
    state_.rested_s += rested_;
}

} // namespace fjell::editor
