#include "editor/jobs.h"

#include <exception>
#include <new>
#include <utility>

#include "host/failure.h"

namespace fjell::editor {

namespace {

using Clock = std::chrono::steady_clock;

// What the body throws is all that is known of why it ended.
void run(const Jobs::Body& body, JobControl& control) {
    std::string problem;
    bool cancelled = false;
    try {
        body(control);
    } catch (const Cancelled&) {
        cancelled = true;
    } catch (const std::bad_alloc&) {
        problem = "memory is short; close something, or ask for less";
    } catch (const std::exception& failure) {
        problem = failure.what();
    }
    cancelled = cancelled || (!problem.empty() && control.cancelled());
    control.publish([&](JobView& view) {
        view.cancelled = cancelled;
        if (!cancelled) view.problem = std::move(problem);
    });
}

} // namespace

void JobControl::progress(const char* stage, std::uint64_t done, std::uint64_t total) {
    if (cancelled()) throw Cancelled{};
    publish([&](JobView& view) {
        if (view.stage != stage) view.stage = stage;
        view.share = total == 0 ? 0 : static_cast<double>(done) / static_cast<double>(total);
    });
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
    if (running()) throw host::Failure(2, "another job is running; wait for it, or cancel it first");
    control_ = std::make_shared<JobControl>();
    control_->view_.kind = kind;
    control_->view_.running = true;
    control_->changed_ = true;
    started_ = Clock::now();
    thread_ = std::jthread([control = control_, body = std::move(body)](const std::stop_token& stop) {
        control->stop_ = stop;
        run(body, *control);
        control->done_.store(true, std::memory_order_release);
    });
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
    view.seconds = std::chrono::duration<double>(Clock::now() - started_).count();
    if (!done) return false;
    thread_.join();
    control_.reset();
    view.running = false;
    view.finished = ++finished_;
    return true;
}

} // namespace fjell::editor
