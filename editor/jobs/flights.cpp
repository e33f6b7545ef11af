#include "editor/jobs/flights.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "editor/jobs/threshold_search.h"
#include "editor/jobs/work.h"
#include "editor/measures.h"
#include "editor/number_text.h"
#include "fjell/gl/context.h"
#include "fjell/gl/target.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "session/log.h"
#include "session/pictures.h"
#include "session/session.h"

namespace fjell::editor {

namespace {

// What this thread has had of the processor: what others took of it meanwhile is not the terrain's.
double thread_us() {
    timespec t{};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

Vec3 mix(Vec3 a, Vec3 b, double share) {
    return a * (1 - share) + b * share;
}

session::Pose between(const session::Pose& a, const session::Pose& b, double share) {
    session::Pose pose{mix(a.position_m, b.position_m, share), mix(a.direction, b.direction, share), {}};
    const double long_m = length(pose.direction);
    if (!(long_m > 1e-6)) return share < 0.5 ? a : b; // turned right about: no direction lies between
    pose.direction = pose.direction * (1 / long_m);
    const Vec3 right = cross(pose.direction, mix(a.up, b.up, share));
    const double wide = length(right);
    if (!(wide > 1e-6)) return share < 0.5 ? a : b;
    pose.up = cross(right * (1 / wide), pose.direction);
    return pose;
}

} // namespace

std::vector<session::Pose> in_frames(const std::vector<session::Pose>& route, std::size_t frames) {
    if (route.empty() || frames == 0 || frames == route.size()) return route;
    std::vector<session::Pose> poses;
    poses.reserve(frames);
    const auto last = static_cast<double>(route.size() - 1);
    for (std::size_t i = 0; i < frames; ++i) {
        const double at = frames == 1 ? 0 : last * static_cast<double>(i) / static_cast<double>(frames - 1);
        const auto before = std::min(static_cast<std::size_t>(at), route.size() - 1);
        const std::size_t after = std::min(before + 1, route.size() - 1);
        poses.push_back(between(route[before], route[after], at - static_cast<double>(before)));
    }
    return poses;
}

struct MeasuredFlight::Impl { // in the order of destruction, last first: GL objects need their context, and all the
                              // terrain
    MeasuredFlightPlan plan;
    JobControl& control;
    std::vector<session::Pose> poses;
    session::Session session;
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    double now_s = 0; // never runs backwards, from flight to flight
    View flown{};     // of the last frame

    void open();
    void make_graphics(const session::FlightOptions& options);
    FlownTimes update(const View& view, session::FrameEntry& entry); // the dearest update with its upload
    double draw(const View& view);
};

void MeasuredFlight::Impl::open() {
    control.progress("open", 0, 1);
    session::FlightOptions options = options_of(plan.pack, plan.profile);
    options.verify_every = plan.measures ? 1 : 0;
    session::open_session(options, session);
    control.check();
    const std::size_t frames = plan.frames != 0 ? plan.frames : session::default_frames;
    poses = plan.route.empty() ? session::resample(session::path_of(options), session.ground(), frames)
                               : in_frames(plan.route, plan.frames);
    if (plan.draws) make_graphics(options);
}

void MeasuredFlight::Impl::make_graphics(const session::FlightOptions& options) {
    context = gl::Headless::create();
    target = gl::Target::create({plan.profile.width_px, plan.profile.height_px, 1});
    renderer = session::make_renderer(options, session);
}

FlownTimes MeasuredFlight::Impl::update(const View& view, session::FrameEntry& entry) {
    FlownTimes dearest;
    double since_us = thread_us();
    entry = session::update_until_there(session, view, plan.profile, now_s, [&](const session::FrameEntry& poll) {
        control.check();
        FlownTimes times{std::min(poll.update_us + poll.stream_us, thread_us() - since_us), 0, 0};
        if (renderer) {
            const auto start = Clock::now();
            session::upload_mesh(*renderer, session, poll);
            times.upload_us = microseconds(Clock::now() - start);
        }
        if (times.all_us() > dearest.all_us()) dearest = times;
        since_us = thread_us();
    });
    return dearest;
}

double MeasuredFlight::Impl::draw(const View& view) {
    const auto start = Clock::now();
    renderer->draw_uploaded(session.mesh(), view, session::draw_options(session::PictureMode::shaded, plan.profile, 0),
                            *target);
    glFinish();
    return microseconds(Clock::now() - start);
}

MeasuredFlight::MeasuredFlight(MeasuredFlightPlan plan, JobControl& control)
    : impl_(new Impl{std::move(plan), control, {}, {}, {}, {}, {}, 0}) {
    impl_->open();
}

MeasuredFlight::~MeasuredFlight() = default;

std::size_t MeasuredFlight::frames() const {
    return impl_->poses.size();
}

const std::vector<session::Pose>& MeasuredFlight::poses() const {
    return impl_->poses;
}

bool MeasuredFlight::incremental() const {
    return session::facts_of(impl_->session.method->kind).keeps_mesh;
}

double MeasuredFlight::error_px() const {
    return impl_->plan.profile.refine.max_error_px;
}

void MeasuredFlight::fly(double error_px, const Each& each) {
    Impl& s = *impl_;
    s.plan.profile.refine.max_error_px = error_px;
    s.session.begun = s.session.streamed != nullptr; // streamed, there is nothing to build from
    for (std::size_t i = 0; i < s.poses.size(); ++i) {
        s.control.check();
        s.flown = session::view_of(s.poses[i], s.session.terrain(), s.plan.profile);
        session::FrameEntry entry;
        FlownTimes times = s.update(s.flown, entry);
        if (s.renderer) times.draw_us = s.draw(s.flown);
        s.now_s += 1.0 / 60;
        each(entry, times, i);
    }
}

void MeasuredFlight::measure(session::FrameEntry& entry, std::size_t frame) {
    session::Verification unused;
    session::verify_frame(impl_->session, impl_->flown, impl_->plan.profile, frame, entry, unused);
}

double MeasuredFlight::samples() const {
    const PackHeader& h = impl_->session.terrain().header();
    return static_cast<double>(h.columns) * h.rows;
}

void MeasuredFlight::set(const ProfileKey& key, double value) {
    key.set(impl_->plan.profile, value);
}

double MeasuredFlight::get(const ProfileKey& key) const {
    return key.get(impl_->plan.profile);
}

// --- Jobs that fly: the one that tunes, and the one that writes a line a frame.

namespace {

void write(io::AtomicFile& file, const std::string& text) {
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

// Shares of a run whose length becomes known on the way: never backwards.
class Share {
public:
    explicit Share(JobControl& control) : control_(control) {}
    void show(double done, double expected) {
        shown_ = std::max(shown_, std::min(done / std::max(expected, 1.0), 1.0));
        control_.progress("fly", static_cast<std::uint64_t>(shown_ * parts), parts);
    }

private:
    static constexpr std::uint64_t parts = 100'000;
    JobControl& control_;
    double shown_ = 0;
};

// Shares of the update are those that the method has timed itself; the recursive one has none, and refines.
CostParts parts_of(const session::FrameEntry& entry, const FlownTimes& times) {
    const double timed_us = entry.prepare_us + entry.refine_us + entry.output_us;
    const double stream_us = std::min(entry.streamed ? entry.stream_us : 0, times.update_us);
    const double update_us = times.update_us - stream_us;
    const auto part = [&](double us) { return timed_us > 0 ? update_us * us / timed_us : 0; };
    return {part(entry.prepare_us), timed_us > 0 ? part(entry.refine_us) : update_us,
            part(entry.output_us),  stream_us,
            times.upload_us,        times.draw_us};
}

// each: with the frame's number, to show how far it is.
FlightCost fly_once(MeasuredFlight& flight, double error_px, const std::function<void(std::size_t)>& each) {
    FlightCost flown;
    flown.times_us.reserve(flight.frames());
    flown.parts_us.reserve(flight.frames());
    double vertices = 0, reached = 0;
    flight.fly(error_px, [&](const session::FrameEntry& entry, const FlownTimes& times, std::size_t frame) {
        each(frame);
        if (frame == 0) return; // built from nothing, once
        flown.times_us.push_back(times.all_us());
        flown.parts_us.push_back(parts_of(entry, times));
        vertices += entry.vertices;
        reached += entry.converged ? 1 : 0;
    });
    if (flown.times_us.empty())
        throw io::Failure(2, "the path has a single frame, whose mesh is built from scratch; choose more frames");
    const auto frames = static_cast<double>(flown.times_us.size());
    flown.vertices = vertices / frames;
    flown.reached = reached / frames;
    return flown;
}

// What was found beside the threshold, in the order in which it was tried.
class OtherKeys {
public:
    using Fly = std::function<FlightCost(double error_px)>;
    OtherKeys(MeasuredFlight& flight, const TuneSettings& settings, const Fly& fly)
        : flight_(flight), settings_(settings), fly_(fly) {}

    // Keys that make the flight at that threshold cheaper by more than what flights differ by. True: there are some.
    bool make_cheaper(double error_px) {
        double best_us = cost_us(error_px);
        for (const auto& [name, values] : cheaper) {
            const ProfileKey& key = *find_profile_key(name);
            const double before = flight_.get(key);
            double best = before;
            for (const double value : values) {
                if (value == before) continue;
                flight_.set(key, value);
                const double us = cost_us(error_px);
                if (us >= noise * best_us) continue;
                best_us = us;
                best = value;
            }
            flight_.set(key, best);
            if (best != before) changed_.push_back({{&key, best}, before});
        }
        return !changed_.empty();
    }
    // Morphing, where the profile has none and it keeps the budget.
    void morph(double error_px) {
        const ProfileKey& key = *find_profile_key("refine.morph");
        if (flight_.get(key) != 0) return;
        flight_.set(key, 1); // by the error
        if (cost_us(error_px) <= settings_.budget_us)
            changed_.push_back({{&key, 1}, 0});
        else
            flight_.set(key, 0);
    }
    void take_back() {
        for (const Change& c : changed_) flight_.set(*c.now.key, c.before);
        changed_.clear();
    }
    [[nodiscard]] std::vector<TunedKey> found() const {
        std::vector<TunedKey> keys;
        for (const Change& c : changed_) keys.push_back(c.now);
        return keys;
    }

    static constexpr std::uint32_t flights = 2 * 6; // about

private:
    struct Tried {
        const char* key;
        std::array<double, 3> values;
    };
    struct Change {
        TunedKey now;
        double before = 0;
    };
    static constexpr Tried cheaper[] = {{"refine.hysteresis", {0, 0.04, 0.1}}, {"refine.offscreen_factor", {1, 4, 8}}};
    static constexpr double noise = 0.97;

    // p99 of two flights, each frame with its least time; infinite where the threshold is not reached.
    double cost_us(double error_px) {
        FlightCost first = fly_(error_px);
        const FlightCost second = fly_(error_px);
        if (std::max(first.reached, second.reached) < least_reached) return std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < first.times_us.size(); ++i)
            first.times_us[i] = std::min(first.times_us[i], second.times_us[i]);
        return session::percentiles(first.times_us).p99;
    }

    MeasuredFlight& flight_;
    const TuneSettings& settings_;
    const Fly& fly_;
    std::vector<Change> changed_;
};

std::string keys_text(const std::vector<TunedKey>& keys) {
    std::string text;
    for (const TunedKey& t : keys) {
        Profile profile;
        t.key->set(profile, t.value);
        text += fmt::format("{}{}.{} {}", text.empty() ? "; with " : ", ", t.key->table, t.key->name,
                            value_text(*t.key, profile));
    }
    return text;
}

// Other keys at the threshold that was found; with cheaper ones a smaller threshold is looked for.
TuneResult tune_others(OtherKeys& others, TuneResult found, TuneSettings settings, const OtherKeys::Fly& fly,
                       const std::function<void(const TuneResult&)>& each) {
    if (others.make_cheaper(found.best_px) && found.best_px > rounded_up(settings.least_px)) {
        settings.most_px = found.best_px;
        // With what the first search flew above it: the curve has its span.
        const auto beside_first = [&](TuneResult result) {
            std::vector<TunePoint> curve;
            for (const TunePoint& p : found.curve)
                if (p.error_px > found.best_px) curve.push_back(p);
            result.curve.insert(result.curve.begin(), curve.begin(), curve.end());
            result.expected += found.flights;
            return result;
        };
        TuneResult smaller =
            beside_first(find_threshold(settings, fly, [&](const TuneResult& so_far) { each(beside_first(so_far)); }));
        if (smaller.best_px == 0)
            others.take_back(); // only by chance
        else
            found = std::move(smaller);
    }
    others.morph(found.best_px);
    return found;
}

void tune(MeasuredFlightPlan plan, const TuneSettings& settings, io::AtomicFile* csv, JobControl& control) {
    control.publish([&](JobView& view) { view.tuned = settings; });
    const std::string flown = plan.flight_name;
    MeasuredFlight flight(std::move(plan), control);
    const auto frames = static_cast<double>(flight.frames());
    Share share(control);
    std::uint32_t flights = 0, expected = 16;
    const bool also = settings.also && flight.incremental();
    const OtherKeys::Fly fly = [&](double error_px) {
        FlightCost cost = fly_once(flight, error_px, [&](std::size_t frame) {
            share.show(flights + static_cast<double>(frame) / frames, expected);
        });
        ++flights;
        return cost;
    };
    const auto each = [&](const TuneResult& so_far) {
        expected = std::max(so_far.expected, flights) + (also ? OtherKeys::flights : 0);
        control.publish([&](JobView& view) {
            view.curve = so_far.curve;
            view.flights = flights;
        });
    };
    TuneResult result = find_threshold(settings, fly, each);
    OtherKeys others(flight, settings, fly);
    if (also && result.best_px > 0) result = tune_others(others, std::move(result), settings, fly, each);
    result.flights = flights;
    if (csv != nullptr) write(*csv, tune_csv(result.curve));
    control.publish([&](JobView& view) {
        view.best_px = result.best_px;
        view.flights = result.flights;
        view.tuned_keys = others.found();
        view.result = tune_text(result, settings, flown) + keys_text(view.tuned_keys);
    });
}

constexpr double most_measured_samples = 64e6; // of a terrain: all of them, a frame

// In a flight of its own, or the frames that are timed would find the caches full of samples; of some frames, as it
// takes every sample of the terrain.
void measure_errors(MeasuredFlight& flight, session::FlightLog& log, JobControl& control) {
    const std::size_t count = log.frames.size();
    const auto wanted = static_cast<std::size_t>(std::clamp(4e8 / flight.samples(), 16.0, 128.0));
    const std::size_t every = std::max<std::size_t>(count / wanted, 1);
    flight.fly(flight.error_px(), [&](const session::FrameEntry& entry, const FlownTimes&, std::size_t frame) {
        control.progress("measure the error", frame, count);
        if (frame == 0 || frame % every != 0) return;
        session::FrameEntry measured = entry;
        flight.measure(measured, frame);
        log.frames[frame].verified_px = measured.verified_px;
    });
}

void benchmark(MeasuredFlightPlan plan, const std::string& path, io::AtomicFile& file, JobControl& control) {
    const double budget_us = plan.profile.cut.max_time_us;
    const std::string profile = plan.profile_name;
    const PackHeader& header = plan.pack->pack().header;
    const bool measures = static_cast<double>(header.columns) * header.rows <= most_measured_samples;
    plan.measures = measures;
    MeasuredFlight flight(std::move(plan), control);
    session::FlightLog log;
    log.frames.reserve(flight.frames());
    const double error_px = flight.error_px();
    flight.fly(error_px, [&](const session::FrameEntry& entry, const FlownTimes&, std::size_t frame) {
        log.frames.push_back(entry);
        control.progress("fly", frame + 1, flight.frames());
    });
    if (measures) measure_errors(flight, log, control);
    write(file, session::csv(log));
    const session::Summary s = session::summarise(log, flight.incremental());
    auto run = std::make_shared<FlownRun>(make_run(log.frames, flight.poses()));
    run->name = file_name(path);
    run->profile = profile;
    run->budget_us = budget_us;
    control.publish([&](JobView& view) {
        if (!run->places.empty()) view.run = std::move(run);
        view.output = path;
        view.result = fmt::format("{}: {} frames, {} of them converged; update p50 {} ms, p99 {} ms", path, s.frames,
                                  s.converged, fine_ms_text(s.update_us.p50).text, fine_ms_text(s.update_us.p99).text);
    });
}

} // namespace

Jobs::Body tune_job(MeasuredFlightPlan plan, const TuneSettings& settings, const std::string& csv) {
    check(settings);
    plan.frames = settings.frames;
    plan.draws = settings.measure == TuneMeasure::frame;
    // Opened before the work, so that a missing folder does not cost a minute.
    io::refuse_overwriting({csv}, {plan.pack->path()});
    auto file = csv.empty() ? nullptr : std::make_shared<io::AtomicFile>(csv);
    return [plan = std::move(plan), settings, file](JobControl& control) { tune(plan, settings, file.get(), control); };
}

Jobs::Body benchmark_job(MeasuredFlightPlan plan, const std::string& csv) {
    if (csv.empty()) throw io::Failure(2, "give the CSV a file name");
    if (plan.frames > 1'000'000) throw io::Failure(2, "frames must be 1 to 1,000,000, or 0 for the path's own");
    io::refuse_overwriting({csv}, {plan.pack->path()});
    auto file = std::make_shared<io::AtomicFile>(csv);
    return [plan = std::move(plan), csv, file](JobControl& control) { benchmark(plan, csv, *file, control); };
}

} // namespace fjell::editor
