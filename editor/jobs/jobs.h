// Work that takes seconds or minutes beside the frame: baking, tuning, benchmarks, exports. One at a time, on a thread
// of its own, with progress, and cancelled at any moment.
//
// A job has its own terrain and, where it draws, its own headless context: it touches nothing of the frame's.
// Ownership: Jobs owns the thread; destroying it cancels and joins. Thread: start(), poll() and cancel() on the
// frame's. Failure: what a job throws becomes JobView::problem; files appear only when they are complete.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "editor/command.h"
#include "editor/runs.h"
#include "fjell/io/pack_file.h"
#include "fjell/profile.h"
#include "session/layers_file.h"
#include "session/options.h"
#include "session/path.h"

namespace fjell::editor {

enum class JobKind : std::uint8_t { none, bake, tune, benchmark, snapshot, preview, picture, materials };
inline constexpr const char* job_names[] = {"none",   "bake",    "tune",    "benchmark",
                                            "export", "preview", "picture", "materials"};

// What a flight's frame spends its time on; the first three are the method's update, of the recursive one all refining.
// Their names: limiting_part().
using CostParts = std::array<double, 6>; // microseconds

// What flights at one threshold cost: each frame with its least time (editor/jobs/threshold_search.h).
struct TunePoint {
    double error_px = 0;
    double p50_us = 0, p99_us = 0, max_us = 0;
    double vertices = 0;       // mean, selected or active
    double reached = 1;        // share of frames that had what the threshold asks for: no budget in its way, no lag
    std::uint32_t frames = 0;  // that counted: without the first
    std::uint32_t flights = 0; // at this threshold
    CostParts dearest_us{};    // the mean of frames at p99 and above
    bool keeps = false;        // p99 is within the budget, and the threshold was reached
};

// A key that auto-tuning would change, beside the threshold.
struct TunedKey {
    const ProfileKey* key = nullptr;
    double value = 0;
};

// Of a session of a job's own over the file that is shown.
[[nodiscard]] session::FlightOptions options_of(std::shared_ptr<const io::PackFile> file, const Profile& profile,
                                                std::shared_ptr<const session::GroundLayers> layers = {});

struct ExportPreview {
    double error_px = 0;
    std::uint64_t vertices = 0, triangles = 0, bytes = 0; // bytes: about
};

// What panels see of the job that runs, or of the last one.
struct JobView {
    JobKind kind = JobKind::none;
    bool running = false, cancelled = false;
    std::string stage;
    double share = 0;             // done, 0..1; of this stage, or of the whole (JobControl::goes_from)
    double rate = 0, left_s = 0;  // units of the stage a second, and until its end; 0: not known
    double seconds = 0;           // so far
    std::string problem;          // why it failed; empty: it did not
    int exit_code = 0;            // and whose fault it was, as for a program
    std::string result;           // one line when it is done
    std::string output;           // the file that it wrote
    std::vector<TunePoint> curve; // of tuning, by falling threshold
    TuneSettings tuned;
    std::uint32_t flights = 0;        // of tuning, so far
    double best_px = 0;               // of tuning: the smallest threshold that keeps the budget; 0: none does
    std::vector<TunedKey> tuned_keys; // of tuning, with best_px
    ExportPreview preview;
    std::shared_ptr<const FlownRun> run; // of a benchmark that is done
    std::uint64_t finished = 0;          // jobs that ended so far
};

// What a job's body is given. Thread: the job's, and those that it starts.
class JobControl {
public:
    // Throws Cancelled when the job is to stop. stage: what is being done. Cheap: at most 20 a second are shown.
    void progress(const char* stage, std::uint64_t done, std::uint64_t total);
    // For one bar over several stages: what follows goes from the one share of the whole to the other.
    void goes_from(double share, double to);
    void check() const; // throws Cancelled too, and shows nothing
    // Changes the view that panels will see.
    void publish(const std::function<void(JobView&)>& change);
    [[nodiscard]] bool cancelled() const { return stop_.stop_requested(); }

private:
    friend class Jobs;
    std::stop_token stop_;
    std::mutex lock_; // of what follows
    JobView view_;
    double from_ = 0, to_ = 1;
    std::chrono::steady_clock::time_point stage_began_, shown_;
    std::atomic<bool> changed_{false}, done_{false};
};
struct Cancelled {};

class Jobs {
public:
    using Body = std::function<void(JobControl&)>;
    Jobs() = default;
    ~Jobs();
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    // Throws io::Failure: 2 while another one runs, 3 when the machine gives no thread.
    void start(JobKind kind, Body body);
    void cancel();
    [[nodiscard]] bool running() const { return thread_.joinable(); }
    // poll() would bring something new.
    [[nodiscard]] bool news() const {
        return control_ &&
               (control_->changed_.load(std::memory_order_acquire) || control_->done_.load(std::memory_order_acquire));
    }
    // Brings the view up to date; allocates nothing when nothing has changed. True once, when a job has ended.
    bool poll(JobView& view);

private:
    std::shared_ptr<JobControl> control_;
    std::uint64_t finished_ = 0;
    std::chrono::steady_clock::time_point started_;
    std::jthread thread_; // last: it ends before what it uses goes
};

} // namespace fjell::editor
