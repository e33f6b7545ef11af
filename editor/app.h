// The editor's program: surface, frame, and the order of things in it.
//
// A frame: input; panels read the state and push commands; commands are applied; the camera moves, the terrain is
// updated and drawn (editor/picture.h); the panels are drawn over it; what it cost is recorded. Where nothing changes
// the program waits for input instead. Thread: main. Failure: io::Failure gets out only when nothing can be shown at
// all; everything else is a message in the window.
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
#include "editor/panels/panels.h"
#include "editor/picture.h"
#include "editor/scene/textures.h"
#include "editor/script.h"
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
    void draw(const PictureFrame& frame);
    void attempt(const std::function<void()>& what);
    void follow_overview();
    void finish_opening();  // of a pack that a thread has read
    void finish_requests(); // screenshots and dumps of the frame that was just drawn
    bool run_script();      // false: it is over
    void run_line(const ScriptLine& line);
    bool settled() const; // all that was requested is done and drawn
    void open_input();    // the command line's: a pack, or heights that are baked before the script begins
    void show_baking();   // on stderr, once a second
    void make_surface_and_graphics();
    void replace_surface();
    void drop_graphics();
    void place_view();
    [[nodiscard]] HandlerContext context() { return {state_, engine_, jobs_}; }

    void rest(); // returns when there is something to draw
    [[nodiscard]] bool at_rest() const;
    [[nodiscard]] double next_change_s() const; // until something shows or goes of itself
    void stir();                                // the next frames are drawn
    void note(const Command& command);          // that was applied

    Options options_;
    State state_;
    PanelState panels_;
    Jobs jobs_;
    Commands commands_;
    Script script_;
    bool baking_input_ = false; // headless: frames and the script begin when it is done
    double baking_shown_s_ = 0;
    std::string shown_title_;
    bool dumping_ = false;      // at the end of this frame
    bool dumped_ = false;       // in this frame
    bool ended_ = false;        // as it should: not by a signal or a failure
    double styled_ = 0;         // the scale that fonts were made for
    session::FrameEntry entry_; // of this frame
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
    OverviewSource overview_of_; // that it shows
    TerrainPicture picture_;
    int rehearsals_ = 0;            // frames that the driver compiles in, before the first picture
    std::uint64_t rehearsed_ = 0;   // the last such frame
    bool compared_changed_ = false; // the other profile's mesh, in this frame
    double frame_s_ = 0;            // the clock of the last frame
    double stirred_s_ = 0;          // when, by State::now_s
    std::uint64_t stirred_frame_ = 0;
    Clock::time_point frame_began_{};
    double rested_ = 0; // before this frame, seconds
};

} // namespace fjell::editor
