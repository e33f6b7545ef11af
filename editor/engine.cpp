#include "editor/engine.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "editor/measures.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "gl/window.h"
#include "session/pictures.h"

namespace fjell::editor {

namespace {

// The most that any changed key takes.
Rebuild rebuild_of(const Profile& from, const Profile& to) {
    Rebuild most = Rebuild::nothing;
    for (const ProfileKey& key : profile_keys())
        if (key.get(from) != key.get(to)) most = std::max(most, key.rebuild);
    return most;
}

// What the driver compiles beforehand. If it fails the first picture will say it.
void rehearse_picture(gl::Renderer& renderer, const gl::DrawOptions& options) {
    try {
        renderer.rehearse(options, *gl::Target::create({16, 16, 1}));
    } catch (const io::Failure&) {
        return;
    }
}

// All but Mode::error, which has to wait for its heights.
gl::DrawOptions picture_options(const State& state) {
    gl::DrawOptions options = session::draw_options(state.interface.mode, state.document.profile(), 0);
    options.wireframe = options.wireframe || state.shows(Overlay::wireframe);
    options.tile_borders = state.shows(Overlay::tile_borders);
    options.page_borders = state.shows(Overlay::page_borders);
    options.contour_m = state.shows(Overlay::contours) ? contour_interval_m(state) : 0;
    options.slope = state.shows(Overlay::slope);
    options.hatch = true;
    return options;
}

class ContextInUse {
public:
    explicit ContextInUse(gl::SecondContext& context) : context_(context) {}
    ~ContextInUse() { context_.release(); }
    ContextInUse(const ContextInUse&) = delete;
    ContextInUse& operator=(const ContextInUse&) = delete;

private:
    gl::SecondContext& context_;
};

} // namespace

Engine::Engine() = default;
Engine::~Engine() = default;

namespace {
constexpr std::uint32_t most_edit_us = 4000; // of a frame, for what was done to the ground
}

session::FlightOptions Engine::options(const Profile& profile) const {
    session::FlightOptions o;
    o.pack = pack_;
    o.profile = profile;
    o.layers = layers_;
    return o;
}

void Engine::open(const std::string& pack, const Profile& profile) {
    session::FlightOptions o = options(profile);
    o.pack = pack;
    o.layers = next_layers_;
    adopt(prepare(o, {}, nullptr, nullptr), o);
}

void Engine::begin_opening(const std::string& pack, const State& state) {
    Request request{pack, state.document.profile(), picture_options(state), next_layers_};
    if (!opening()) return start(std::move(request));
    waiting_ = std::move(request);
    abandoned_->store(true, std::memory_order_relaxed);
}

void Engine::start(Request request) {
    request_ = std::move(request);
    session::FlightOptions o = options(request_.profile);
    o.pack = request_.pack;
    o.layers = request_.layers;
    abandoned_ = std::make_shared<std::atomic<bool>>(false);
    opening_ =
        std::async(std::launch::async, [o = std::move(o), shown = request_.shown, context = second_context_,
                                        abandoned = abandoned_] { return prepare(o, shown, context, abandoned); });
}

void Engine::abandon_opening() {
    waiting_.reset();
    if (abandoned_) abandoned_->store(true, std::memory_order_relaxed);
}

Engine::Opened Engine::prepare(const session::FlightOptions& options, const gl::DrawOptions& shown,
                               gl::SecondContext* context, const Abandoned& abandoned) {
    const auto go_on = [&] { return !abandoned || !abandoned->load(std::memory_order_relaxed); };
    Opened opened;
    if (!go_on()) return opened;
    opened.session = std::make_unique<session::Session>();
    {
        session::FlightOptions with_journal = options;
        open_with_journal(with_journal);
        session::open_session(with_journal, *opened.session);
    }
    opened.coordinates =
        std::make_shared<baker::Coordinates>(opened.session->loaded.pack.header, opened.session->file->crs());
    if (!go_on() || context == nullptr || !context->make_current()) return opened;
    const ContextInUse until_done(*context);
    std::unique_ptr<gl::Renderer> renderer;
    try {
        renderer = session::make_renderer(options, *opened.session);
    } catch (
        const io::Failure&) { // this context's, which may be lost: the frame's thread tries in its own, and says it
        return opened;
    }
    if (go_on()) rehearse_picture(*renderer, shown);
    renderer->leave_context();
    opened.renderer = std::move(renderer);
    return opened;
}

bool Engine::opening_done() const {
    return opening() && opening_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::string Engine::finish_opening() {
    if (waiting_) {
        try {
            (void)opening_.get();         // its renderer, in this context, before its session
        } catch (const std::exception&) { // nobody wants to know any more
        }
        start(*std::exchange(waiting_, {}));
        return {};
    }
    Opened opened = opening_.get();
    if (abandoned_->load(std::memory_order_relaxed))
        throw io::Failure(2, fmt::format("{}: is no longer being opened", request_.pack));
    session::FlightOptions o = options(request_.profile);
    o.pack = request_.pack;
    o.layers = request_.layers;
    adopt(std::move(opened), o);
    return request_.pack;
}

void Engine::adopt(Opened opened, const session::FlightOptions& o) {
    auto& [session, renderer, coordinates] = opened;
    unread_told_ = 0;
    if (session->streamed) session->on_failure = [this](const std::string& line) { messages_.push_back(line); };
    if (!renderer) renderer = session::make_renderer(o, *session);
    set_renderer(std::move(renderer)); // which points into the terrain: the old one goes before the old session
    session_ = std::move(session);
    if (!digging_ || pack_ != o.pack) {
        digging_ = std::make_unique<Digging>(o.pack, session_->loaded.pack.header);
        for (const std::string* const text : {&digging_->problem(), &digging_->notice()})
            if (!text->empty()) messages_.push_back(*text);
    }
    digging_->use(session_->edits.get());
    if (session_->edits) session_->edits->limit_us(most_edit_us);
    coordinates_ = std::move(coordinates);
    pack_ = o.pack;
    built_ = o.profile;
    layers_ = o.layers;
    ++terrains_;
}

void Engine::set_renderer(std::unique_ptr<gl::Renderer> renderer) {
    heights_.forget(); // which the old one had
    renderer_ = std::move(renderer);
}

void Engine::close() {
    set_renderer(nullptr);
    digging_.reset();
    session_.reset();
    pack_.clear();
    ++terrains_;
}

void Engine::remake(const Profile& profile) {
    session::remake_method(options(profile), *session_);
    set_renderer(nullptr); // the old one's memory first
    try {
        set_renderer(session::make_renderer(options(profile), *session_));
        built_ = profile;
    } catch (...) { // as it was; and when that cannot be had any more either, nothing is open
        try {
            session::remake_method(options(built_), *session_);
            set_renderer(session::make_renderer(options(built_), *session_));
        } catch (...) {
            close();
        }
        throw;
    }
}

bool Engine::follow(const Profile& profile) {
    switch (rebuild_of(built_, profile)) {
    case Rebuild::nothing: return false;
    case Rebuild::method:
        if (!session_->streamed) {
            remake(profile);
            return true;
        }
        [[fallthrough]]; // the stream holds on to the cut
    case Rebuild::session: {
        const std::uint64_t hash = session_->loaded.pack.header.directory_hash;
        const Layers next = std::exchange(next_layers_, layers_);
        try {
            reopen(profile);
        } catch (...) {
            next_layers_ = next;
            throw;
        }
        next_layers_ = next;
        if (session_->loaded.pack.header.directory_hash != hash)
            messages_.push_back(fmt::format("{}: the file has changed; its new contents are shown", pack_));
        return true;
    }
    }
    return false;
}

session::FrameEntry Engine::update(const View& view, const Profile& profile, double now_s, double& upload_us) {
    session::FrameEntry entry = session::update_frame(*session_, view, profile, now_s);
    if (entry.streamed && entry.stream.in_flight == 0) tell_unread();
    const auto start = Clock::now();
    session::upload_mesh(*renderer_, *session_, entry);
    if (session_->edits) {
        if (const std::string refusal = session_->edits->take_refusal(); !refusal.empty()) refuse_edit(refusal);
    }
    upload_us = microseconds(Clock::now() - start);
    return entry;
}

void Engine::refuse_edit(const std::string& why) {
    try {
        digging_->take_back_refused();
        messages_.push_back(fmt::format("the ground there cannot take that, so it was taken back: {}", why));
    } catch (const io::Failure& failure) { // in the middle of a frame
        messages_.push_back(
            fmt::format("the ground there cannot take that ({}), and the journal keeps it: {}", why, failure.what()));
    }
}

void Engine::rehearse(const State& state, bool all) {
    gl::DrawOptions options = picture_options(state);
    options.sky = options.sky && all;
    rehearse_picture(*renderer_, options);
    glFinish();
}

// The first is told at once, by itself; how many there are when reading has come to rest, and again when they have
// doubled.
void Engine::tell_unread() {
    const std::uint64_t unread = session_->streamed->corrupt() + session_->streamed->unreadable();
    if (unread < 2 * std::max<std::uint64_t>(unread_told_, 1)) return;
    unread_told_ = unread;
    messages_.push_back(fmt::format(
        "{}: {} pages or mips cannot be read; the terrain is coarser there; check the pack with fjell-bake verify",
        pack_, unread));
}

// Until the heights are there the picture is the usual one. Measured from the refining eye, against what it was
// promised: pixels of that view, as a cut that has converged keeps them.
void Engine::set_error_options(const State& state, gl::DrawOptions& options) {
    if (!state.shows(Overlay::error)) return heights_.allow_retry();
    if (!heights_.problem().empty()) return; // said already
    heights_.read(session_->file);
    if (!heights_.upload(*renderer_)) {
        if (!heights_.problem().empty()) messages_.push_back(heights_.problem());
        return;
    }
    const View& refining = state.eye.refining ? *state.eye.refining : state.eye.view;
    options.mode = gl::Mode::error;
    options.error_full_px = static_cast<float>(state.document.profile().refine.max_error_px);
    options.error_eye_m = refining.eye_m;
    options.error_lambda_px = focal_length_px(refining);
}

void Engine::build_lines(const State& state) {
    scene_lines_.build(state, *session_);
}

void Engine::draw(const State& state, const gl::Target& target, PictureRows rows) {
    gl::DrawOptions options = picture_options(state);
    set_error_options(state, options);
    options.first_row = rows.first;
    options.end_row = rows.end;
    renderer_->draw_uploaded(session_->mesh(), state.eye.view, options, target);
}

void Engine::draw_lines(const State& state, const gl::Target& target) {
    if (scene_lines_.empty()) return;
    if (!lines_) lines_ = gl::Lines::create({SceneLines::most_lines, SceneLines::most_balls});
    lines_->draw(scene_lines_.lines(), scene_lines_.balls(), state.eye.view, target);
}

std::vector<std::string> Engine::take_messages() {
    return std::exchange(messages_, {});
}

void Engine::drop_graphics() {
    lines_.reset();
    set_renderer(nullptr);
    drop_opened_graphics();
    second_context_ = nullptr;
}

// What a thread has read stays, to be shown in another context.
void Engine::drop_opened_graphics() {
    if (!opening()) return;
    std::promise<Opened> again;
    try {
        Opened opened = opening_.get();
        opened.renderer.reset();
        again.set_value(std::move(opened));
    } catch (...) {
        again.set_exception(std::current_exception());
    }
    opening_ = again.get_future();
}

void Engine::make_graphics() {
    if (session_) set_renderer(session::make_renderer(options(built_), *session_));
}

Scene Engine::scene() const {
    Scene s;
    if (!session_) return s;
    const session::Session& session = *session_;
    const PackHeader& h = session.loaded.pack.header;
    s.coordinates = coordinates_;
    s.path = pack_;
    s.columns = h.columns;
    s.rows = h.rows;
    s.tiles_x = h.tiles_x;
    s.tiles_y = h.tiles_y;
    s.tiles = tiles_of(h);
    s.tile_cells = 1u << h.tile_log2;
    s.pages = session.terrain().page_count();
    s.spacing_m[0] = h.spacing_m[0];
    s.spacing_m[1] = h.spacing_m[1];
    s.min_m = h.min_m;
    s.max_m = h.max_m;
    s.quantum_m = static_cast<double>(h.quantum_m);
    s.horizons = h.horizon_log2 != 0;
    s.splat = h.splat_log2 != 0;
    s.materials = layers_ != nullptr;
    s.mips = mip_count(h.colour_log2 != 0 ? h.colour_log2 : h.normal_log2);
    s.file_bytes = h.file_bytes;
    s.terrain_bytes = session.terrain_bytes;
    s.method_bytes = session.method->bytes();
    s.stream_bytes = session.streamed ? session.streamed->memory_bytes() : 0;
    s.streamed = session.streamed != nullptr;
    return s;
}

void FullHeights::read(std::shared_ptr<const io::PackFile> pack) {
    if (thread_.joinable() || uploaded_ || !problem_.empty()) return;
    share_ = 0;
    done_ = false;
    failure_.clear();
    thread_ = std::jthread([this, pack = std::move(pack)](const std::stop_token& stop) { run(*pack, stop); });
}

void FullHeights::run(const io::PackFile& pack, const std::stop_token& stop) {
    try {
        heights_ = io::read_heights(pack, most_samples, [&](double share) {
            share_.store(share, std::memory_order_relaxed);
            return !stop.stop_requested();
        });
    } catch (const std::exception& failure) {
        failure_ = io::as_failure(failure).what();
    }
    done_.store(true, std::memory_order_release);
}

void FullHeights::forget() {
    if (thread_.joinable()) {
        thread_.request_stop();
        thread_.join();
    }
    heights_.reset();
    uploaded_ = false;
    problem_.clear();
    share_ = 0;
}

bool FullHeights::upload(gl::Renderer& renderer) {
    if (uploaded_ || !done_.load(std::memory_order_acquire) || !thread_.joinable()) return uploaded_;
    thread_.join();
    problem_ = failure_;
    try {
        if (heights_)
            renderer.set_heights({heights_->columns, heights_->rows, heights_->step_log2, heights_->heights_m});
        uploaded_ = heights_.has_value();
    } catch (const io::Failure& failure) {
        problem_ = failure.what();
    }
    heights_.reset();
    return uploaded_;
}

} // namespace fjell::editor
