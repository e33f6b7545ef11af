#include "editor/jobs/overview_job.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

namespace fjell::editor {

namespace {

// The picture comes first: where processors are few, the overview a little later.
void step_back() {
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 5);
}

} // namespace

struct OverviewJob::Sheet {
    std::mutex lock; // of what follows
    std::vector<std::uint32_t> texels;
    double share = 0;
    // Without the lock: what it guards has changed since it was taken; and the thread will not come back to it.
    std::atomic<bool> changed{false}, ended{false};
    OverviewSize size; // never changes
};

OverviewJob::~OverviewJob() {
    leave();
}

// A thread that is left has been told to stop by then, so joining all of them takes no longer than the slowest.
void OverviewJob::leave() {
    std::erase_if(leaving_, [](const Painting& p) { return p.sheet->ended.load(std::memory_order_acquire); });
    if (now_.thread.joinable()) {
        now_.thread.request_stop();
        leaving_.push_back(std::move(now_));
    }
    now_ = {};
}

void OverviewJob::begin(OverviewSource source) {
    leave();
    auto sheet = std::make_shared<Sheet>();
    sheet->size = overview_size_of(source.pack->pack().header);
    sheet->texels.assign(sheet->size.texels(), overview_ground);
    now_.sheet = sheet;
    try {
        now_.thread = std::jthread([sheet, source = std::move(source)](const std::stop_token& stop) {
            paint(*sheet, source, stop);
            sheet->ended.store(true, std::memory_order_release);
        });
    } catch (const std::system_error&) { // the machine gives no thread: there is no overview
        sheet->ended.store(true, std::memory_order_release);
    }
}

void OverviewJob::end() {
    leave();
}

void OverviewJob::paint(Sheet& sheet, const OverviewSource& source, const std::stop_token& stop) {
    step_back();
    try {
        (void)paint_overview(
            source, [&] { return stop.stop_requested(); },
            [&](double share, std::span<const std::uint32_t> texels) {
                {
                    const std::scoped_lock hold(sheet.lock);
                    std::ranges::copy(texels, sheet.texels.begin());
                    sheet.share = share;
                }
                sheet.changed.store(true, std::memory_order_release);
                return !stop.stop_requested();
            });
    } catch (const std::exception&) { // the flight needs the same memory and the same file, and says what is wrong
    }
}

bool OverviewJob::news() const {
    return now_.sheet && now_.sheet->changed.load(std::memory_order_acquire);
}

bool OverviewJob::done() const {
    return !now_.sheet || (now_.sheet->ended.load(std::memory_order_acquire) && !news());
}

bool OverviewJob::take(Take give, void* to) {
    if (!now_.sheet) return false;
    Sheet& sheet = *now_.sheet;
    const std::unique_lock hold(sheet.lock, std::try_to_lock);
    if (!hold) return false;
    sheet.changed.store(false, std::memory_order_relaxed); // before what is read, as the thread sets it after writing
    give(to, sheet.size, sheet.share, sheet.texels);
    return true;
}

} // namespace fjell::editor
