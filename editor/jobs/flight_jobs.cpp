// Jobs that fly: the one that tunes, and the one that writes a line a frame.
#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "editor/jobs/factories.h"
#include "editor/jobs/threshold_search.h"
#include "editor/number_text.h"
#include "fjell/io/failure.h"
#include "flight/log.h"
#include "io/file.h"

namespace fjell::editor {

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
CostParts parts_of(const flight::FrameEntry& entry, const FlownTimes& times) {
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
    flight.fly(error_px, [&](const flight::FrameEntry& entry, const FlownTimes& times, std::size_t frame) {
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

void tune(MeasuredFlightPlan plan, const TuneSettings& settings, io::AtomicFile* csv, JobControl& control) {
    control.publish([&](JobView& view) { view.tuned = settings; });
    const std::string flown = plan.flight_name;
    MeasuredFlight flight(std::move(plan), control);
    const auto frames = static_cast<double>(flight.frames());
    Share share(control);
    std::uint32_t flights = 0, expected = 16;
    const TuneResult result = find_threshold(
        settings,
        [&](double error_px) {
            return fly_once(flight, error_px, [&](std::size_t frame) {
                share.show(flights + static_cast<double>(frame) / frames, expected);
            });
        },
        [&](const TuneResult& so_far) {
            flights = so_far.flights;
            expected = so_far.expected;
            control.publish([&](JobView& view) {
                view.curve = so_far.curve;
                view.flights = so_far.flights;
            });
        });
    if (csv != nullptr) write(*csv, tune_csv(result.curve));
    control.publish([&](JobView& view) {
        view.best_px = result.best_px;
        view.result = tune_text(result, settings, flown);
    });
}

std::string name_of(const std::string& path) {
    return path.substr(path.find_last_of('/') + 1);
}

void benchmark(MeasuredFlightPlan plan, const std::string& path, io::AtomicFile& file, JobControl& control) {
    const double budget_us = plan.profile.cut.budget_us;
    const std::string profile = plan.profile_name;
    MeasuredFlight flight(std::move(plan), control);
    flight::FlightLog log;
    log.frames.reserve(flight.frames());
    const double error_px = flight.error_px();
    flight.fly(error_px, [&](const flight::FrameEntry& entry, const FlownTimes&, std::size_t frame) {
        log.frames.push_back(entry);
        control.progress("fly", frame + 1, flight.frames());
    });
    write(file, flight::csv(log));
    const flight::Summary s = flight::summarise(log, flight.incremental());
    auto run = std::make_shared<FlownRun>(make_run(log.frames, flight.poses()));
    run->name = name_of(path);
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
