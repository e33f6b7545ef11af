#include "editor/jobs/jobs.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include "editor/measures.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

constexpr std::chrono::milliseconds between_shown{50};

double seconds(Clock::duration d) {
    return std::chrono::duration<double>(d).count();
}

// What the body throws is all that is known of why it ended.
void run(const Jobs::Body& body, JobControl& control) {
    std::string problem;
    int exit_code = 3;
    bool cancelled = false;
    try {
        body(control);
    } catch (const Cancelled&) {
        cancelled = true;
    } catch (const std::exception& thrown) {
        const io::Failure failure = io::as_failure(thrown);
        problem = failure.what();
        exit_code = failure.exit_code;
    } catch (...) {
        problem = "the job failed with an unknown error; please report it with its settings";
    }
    // What a library makes of being stopped is still a cancelled job.
    cancelled = cancelled || (!problem.empty() && control.cancelled());
    control.publish([&](JobView& view) {
        view.cancelled = cancelled;
        if (cancelled || problem.empty()) return;
        view.problem = std::move(problem);
        view.exit_code = exit_code;
    });
}

} // namespace

session::FlightOptions options_of(std::shared_ptr<const io::PackFile> file, const Profile& profile,
                                  std::shared_ptr<const session::GroundLayers> layers) {
    session::FlightOptions options;
    options.pack = file->path();
    options.file = std::move(file);
    options.profile = profile;
    options.layers = std::move(layers);
    open_with_journal(options); // jobs see the ground that is shown
    return options;
}

void JobControl::check() const {
    if (cancelled()) throw Cancelled{};
}

void JobControl::goes_from(double share, double to) {
    const std::scoped_lock hold(lock_);
    from_ = share;
    to_ = to;
}

void JobControl::progress(const char* stage, std::uint64_t done, std::uint64_t total) {
    check();
    const auto now = Clock::now();
    const std::scoped_lock hold(lock_);
    const bool another = view_.stage != stage;
    if (!another && done < total && now - shown_ < between_shown) return;
    if (another) {
        view_.stage = stage;
        stage_began_ = now;
    }
    shown_ = now;
    const double elapsed = seconds(now - stage_began_);
    const double part = total == 0 ? 0 : static_cast<double>(done) / static_cast<double>(total);
    const bool whole = from_ > 0 || to_ < 1; // such a bar never goes back, though what a stage counts may grow
    view_.share = std::max(from_ + (to_ - from_) * part, whole ? view_.share : 0);
    view_.rate = elapsed > 0.2 ? static_cast<double>(done) / elapsed : 0;
    view_.left_s = view_.rate > 0 ? static_cast<double>(total - std::min(done, total)) / view_.rate : 0;
    changed_.store(true, std::memory_order_release);
}

void JobControl::publish(const std::function<void(JobView&)>& change) {
    const std::scoped_lock hold(lock_);
    change(view_);
    changed_.store(true, std::memory_order_release);
}

Jobs::~Jobs() {
    cancel();
}

void Jobs::start(JobKind kind, Body body) {
    if (running()) throw io::Failure(2, "another job is running; wait for it, or cancel it first");
    auto control = std::make_shared<JobControl>();
    control->view_.kind = kind;
    control->view_.running = true;
    control->changed_ = true;
    try {
        thread_ = std::jthread([control, body = std::move(body)](const std::stop_token& stop) {
            control->stop_ = stop;
            run(body, *control);
            control->done_.store(true, std::memory_order_release);
        });
    } catch (const std::system_error&) {
        throw io::Failure(3, "cannot create a thread for the job; close other programs");
    }
    control_ = std::move(control);
    started_ = Clock::now();
}

void Jobs::cancel() {
    if (thread_.joinable()) thread_.request_stop();
}

bool Jobs::poll(JobView& view) {
    if (!control_) return false;
    const bool done = control_->done_.load(std::memory_order_acquire);
    if (control_->changed_.exchange(false, std::memory_order_acq_rel)) {
        const std::scoped_lock hold(control_->lock_);
        view = control_->view_;
        view.finished = finished_;
    }
    view.seconds = seconds(Clock::now() - started_);
    if (!done) return false;
    thread_.join();
    control_.reset();
    view.running = false;
    view.finished = ++finished_;
    return true;
}

} // namespace fjell::editor
