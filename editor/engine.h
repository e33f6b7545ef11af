// The terrain as the editor shows it: a session of the flight client, the renderer of its mesh, and how both follow a
// profile that changes under them.
//
// Ownership: both. Thread: the frame's, with the graphics context current. Failure: io::Failure with one line; what
// was open before stays open, as it was.
#pragma once

#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "editor/digging.h"
#include "editor/scene/lines.h"
#include "editor/state.h"
#include "fjell/gl/lines.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "fjell/io/heights.h"
#include "session/session.h"

namespace fjell::editor {

class FullHeights {
public:
    static constexpr std::uint64_t most_samples = std::uint64_t{1} << 26;

    FullHeights() = default;
    ~FullHeights() = default; // the thread goes first
    FullHeights(const FullHeights&) = delete;
    FullHeights& operator=(const FullHeights&) = delete;

    // Nothing when it is under way, done or failed.
    void read(std::shared_ptr<const io::PackFile> pack);
    void forget();                           // another pack, or another renderer
    void allow_retry() { problem_.clear(); } // what failed may be tried again
    // Hands them to the renderer once they are there. True: the renderer has them.
    [[nodiscard]] bool upload(gl::Renderer& renderer);
    [[nodiscard]] double share() const { return share_.load(std::memory_order_relaxed); } // read, 0..1
    [[nodiscard]] const std::string& problem() const { return problem_; }

private:
    void run(const io::PackFile& pack, const std::stop_token& stop);

    std::atomic<double> share_{0};
    std::atomic<bool> done_{false};
    std::optional<io::FullHeights> heights_; // the thread's until done_
    std::string failure_;                    // the same
    std::string problem_;
    bool uploaded_ = false;
    std::jthread thread_; // last: it ends before what it writes goes
};

} // namespace fjell::editor

namespace fjell::gl {
class SecondContext; // gl/window.h
}

namespace fjell::editor {

// Of a picture, from below; end 0: all.
struct PictureRows {
    std::uint32_t first = 0, end = 0;
};

class Engine {
public:
    Engine();
    ~Engine();
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    using Layers = std::shared_ptr<const session::GroundLayers>;
    // Of every terrain that is opened from now on; null: none.
    void set_layers(Layers layers) { next_layers_ = std::move(layers); }
    // Of the one that is shown.
    [[nodiscard]] const Layers& layers() const { return layers_; }
    void open(const std::string& pack, const Profile& profile);
    // The same with the state's profile, by a thread that reads it and, where there is a second context, uploads its
    // maps and has the driver compile what the picture's mode takes: what is shown goes on until finish_opening()
    // replaces it. The latest is meant: one that is being read still is dropped when it has been, and this one follows.
    void begin_opening(const std::string& pack, const State& state);
    // Shares the objects of the frame's; null: there is none. Used until drop_graphics().
    void set_second_context(gl::SecondContext* context) { second_context_ = context; }
    [[nodiscard]] bool opening() const { return opening_.valid(); }
    [[nodiscard]] bool opening_done() const; // finish_opening() will not wait
    // The pack that was opened; empty: another one was asked for meanwhile, and is being read now.
    std::string finish_opening();
    // What is being read is not wanted any more: its thread does no more than it must. finish_opening() throws then.
    void abandon_opening();
    // Once more, with the layers that were set last.
    void reopen(const Profile& profile) { open(std::string(pack_), profile); }
    void close();
    [[nodiscard]] bool is_open() const { return session_ != nullptr; }
    [[nodiscard]] const session::Session& session() const { return *session_; }
    [[nodiscard]] Scene scene() const;

    // Recreates what the profile's budgets ask for: the method's memory, or terrain and stream too. True when it did.
    bool follow(const Profile& profile);
    // One update for that view, uploaded. draw_us: what the upload took.
    [[nodiscard]] session::FrameEntry update(const View& view, const Profile& profile, double now_s, double& upload_us);
    // What is done to its ground. Only while it is open.
    [[nodiscard]] Digging& digging() { return *digging_; }
    // Before the first update of what was opened: has the driver compile what this context needs for its picture, first
    // that of the ground, then all of it. Another context's is of no use to it.
    void rehearse(const State& state, bool all);
    // The terrain. rows: of the target, from below, these alone.
    void draw(const State& state, const gl::Target& target, PictureRows rows = {});
    // Before draw_lines(): the lines over the terrain.
    void build_lines(const State& state);
    // Over what is drawn there, hidden by what its depth says is nearer.
    void draw_lines(const State& state, const gl::Target& target);
    // Of what the picture of the true error needs, 0..1; below 0: it cannot be had.
    [[nodiscard]] double heights_share() const { return heights_.problem().empty() ? heights_.share() : -1; }
    [[nodiscard]] const gl::DrawStats& stats() const { return renderer_->stats(); }
    // How many were opened so far, a rebuilt one counted again: what was made of another terrain is out of date.
    [[nodiscard]] std::uint64_t terrains() const { return terrains_; }
    // What reading has had to say since the last call; empty: nothing.
    [[nodiscard]] std::vector<std::string> take_messages();

    // The context is gone, or about to go; and there is another one.
    void drop_graphics();
    void make_graphics();

private:
    // What a thread has made of a pack. The renderer points into the session; null: the frame's thread makes it.
    struct Opened {
        std::unique_ptr<session::Session> session;
        std::unique_ptr<gl::Renderer> renderer;
        std::shared_ptr<const baker::Coordinates> coordinates;
    };
    using Abandoned = std::shared_ptr<std::atomic<bool>>; // the frame's thread says so, the one that reads looks
    struct Request {
        std::string pack;
        Profile profile;
        gl::DrawOptions shown;
        Layers layers;
    };
    static Opened prepare(const session::FlightOptions& options, const gl::DrawOptions& shown,
                          gl::SecondContext* context, const Abandoned& abandoned);
    void start(Request request);
    void drop_opened_graphics();
    [[nodiscard]] session::FlightOptions options(const Profile& profile) const; // of the terrain that is shown
    void set_error_options(const State& state, gl::DrawOptions& options);
    // Shows it; what it was opened with.
    void adopt(Opened opened, const session::FlightOptions& options);
    void set_renderer(std::unique_ptr<gl::Renderer> renderer);
    void tell_unread();
    void refuse_edit(const std::string& why);
    void remake(const Profile& profile); // the method's memory, and a renderer for it

    std::uint64_t unread_told_ = 0;     // pages and mips of this session that could not be read
    std::vector<std::string> messages_; // of reading, until they are taken
    std::uint64_t terrains_ = 0;
    std::string pack_;
    Layers layers_, next_layers_;
    Profile built_; // what the session's memory was allocated for
    std::unique_ptr<session::Session> session_;
    std::unique_ptr<Digging> digging_;
    std::unique_ptr<gl::Renderer> renderer_;
    std::shared_ptr<const baker::Coordinates> coordinates_;
    FullHeights heights_;
    SceneLines scene_lines_;
    std::unique_ptr<gl::Lines> lines_; // made when there are some
    Request request_;                  // of what is being read
    std::optional<Request> waiting_;   // follows it, in its place
    Abandoned abandoned_;
    std::future<Opened> opening_;
    gl::SecondContext* second_context_ = nullptr;
};

} // namespace fjell::editor
