// The editor's program: surface, frame, and the order of things in it.
//
// A frame: input; panels read the state and push commands; commands are applied; the camera moves, the terrain is
// updated and drawn; the panels are drawn over it; what it cost is recorded. Thread: main. Failure: io::Failure gets
// out only when nothing can be shown at all; everything else is a message in the window.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/command.h"
#include "editor/comparison.h"
#include "editor/engine.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/heights.h"
#include "editor/jobs/jobs.h"
#include "editor/measures.h"
#include "editor/scene/textures.h"
#include "editor/state.h"
#include "editor/surface.h"

namespace fjell::editor {

// The command line's.
struct Options {
    std::string pack, profile, path;   // may be empty
    std::string materials, layers;     // of detail layers: both or neither
    std::string screenshot;            // of the last of so many frames
    std::size_t frames = 0;            // then it quits; 0: until it is closed
    std::string script;                // a file of commands, "-": standard input
    std::vector<std::string> commands; // --do: before the script's
    bool headless = false;
    std::uint32_t width = 0, height = 0; // 0: as last time, or 1280x720
    double scale = 0;                    // 0: the desktop's
    bool vsync = true;
};

// A command of --do or --script, or what is wrong with it.
struct ScriptLine {
    std::optional<Command> command;
    std::string problem;
};

// A stretch of the editor's own code in a frame, told to whoever watches.
class OwnCode {
public:
    explicit OwnCode(void (*watch)(bool begins)) : watch_(watch) { watch_(true); }
    ~OwnCode() { watch_(false); }
    OwnCode(const OwnCode&) = delete;
    OwnCode& operator=(const OwnCode&) = delete;

private:
    void (*watch_)(bool begins);
};

class App {
public:
    explicit App(Options options);
    ~App();
    App(const App&) = delete;
    App& operator=(const App&) = delete;

    int run();
    [[nodiscard]] const State& state() const { return state_; }
    // Called where the editor's own code of a frame begins and ends: for tests that count what it does.
    void watch_own_code(void (*watch)(bool begins)) { watch_ = watch; }

private:
    void frame();
    double interface(); // what it took, us
    double handle_commands();
    double move_and_update(); // what the editor itself took of it, us
    void draw();
    void draw_terrain();
    [[nodiscard]] PictureRows next_band(std::uint32_t height) const;
    PictureRows next_first_band(std::uint32_t height);
    void attempt(const std::function<void()>& what);
    [[nodiscard]] bool overview_is_of(const OverviewSource& source) const;
    void follow_overview();
    void finish_opening();  // of a pack that a thread has read
    void finish_requests(); // screenshots and dumps of the frame that was just drawn
    void read_script();
    bool run_script();    // false: it is over
    bool settled() const; // all that was requested is done and drawn
    void open_input();    // the command line's: a pack, or heights that are baked before the script begins
    void show_baking();   // on stderr, once a second
    void make_surface_and_graphics();
    void replace_surface();
    void drop_graphics();
    void place_view();
    gl::Target& fit_target(bool half);

    // When there is something to draw (app_rest.cpp).
    void rest(); // returns when there is
    [[nodiscard]] bool at_rest() const;
    [[nodiscard]] double next_change_s() const; // until something shows or goes of itself
    [[nodiscard]] static bool dump_is_wanted(); // by a test, now and then: FJELL_EDITOR_DUMP
    [[nodiscard]] static bool dump_asked_for(); // now
    void stir();                                // the next frames are drawn
    void note(const Command& command);          // that was applied
    void judge_picture();                       // sets picture_old_, of this frame's view and mesh
    void redraw();                              // all of the terrain's picture, bands that are drawn already too

    Options options_;
    State state_;
    Jobs jobs_;
    Commands commands_;
    std::vector<ScriptLine> script_;
    std::size_t script_at_ = 0;
    std::uint64_t wait_until_frame_ = 0;
    bool waiting_settled_ = false;
    bool baking_input_ = false; // headless: frames and the script begin when it is done
    double baking_shown_s_ = 0;
    std::string shown_title_;
    bool dumping_ = false;     // at the end of this frame
    bool dumped_ = false;      // in this frame
    bool ended_ = false;       // as it should: not by a signal or a failure
    double styled_ = 0;        // the scale that fonts were made for
    flight::FrameEntry entry_; // of this frame
    FrameTimes times_;
    void (*watch_)(bool begins) = [](bool) {};
    std::vector<Command> after_frame_; // Screenshot and DumpState, once the frame is drawn
    std::vector<Command> next_frame_;  // those that panels ask for: of the frame after theirs
    // Destroyed from last to first: GL objects need their context.
    std::unique_ptr<Surface> surface_;
    Engine engine_;
    HeightLook look_; // at what is to be baked
    PreviewTexture preview_;
    Comparison comparison_;
    GpuTimer gpu_timer_; // off where software draws
    Overview overview_;
    OverviewSource overview_of_;                       // that it shows
    std::unique_ptr<gl::Target> target_, half_target_; // the terrain's picture, and that of a moving camera
    const gl::Target* shown_ = nullptr;                // the one that was drawn last
    bool software_ = false;                            // draws
    bool picture_old_ = true;                          // the terrain's, of this frame
    bool mesh_changed_ = false;                        // in this frame
    std::uint32_t first_row_ = 0;                      // of a terrain's first picture, rows below it are drawn already
    std::uint32_t first_bands_ = 1;                    // that it is drawn in
    View first_view_;                                  // of it
    int rehearsals_ = 0;                               // frames that the driver compiles in, before the first picture
    std::uint64_t rehearsed_ = 0;                      // the last such frame
    bool drew_half_ = false;                           // in this frame
    double half_us_ = 0;                               // what the last picture of half resolution took, with its copy
    std::uint32_t band_row_ = 0;                       // of the whole picture, rows below this one are drawn already
    bool compared_changed_ = false;                    // the other profile's mesh, in this frame
    bool moving_ = false;                              // the camera, since the last picture
    View drawn_view_;                                  // of the last picture
    std::uint64_t drawn_terrain_ = 0;                  // the same, by Engine::terrains()
    double frame_s_ = 0;                               // the clock of the last frame
    double stirred_s_ = 0;                             // when, by State::now_s
    std::uint64_t stirred_frame_ = 0;
    Clock::time_point frame_began_{};
    double rested_ = 0; // before this frame, seconds
};

} // namespace fjell::editor
