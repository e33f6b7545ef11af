// The overview, painted by a thread of its own while frames go on.
//
// The thread shares a sheet of texels with the frame, behind a lock that the frame takes only when there is something
// new, and leaves alone while the thread has it. One that is no longer wanted is told to stop, and joined when it has:
// no frame waits for the page that it reads. Ownership: the threads. Thread: the frame's. Memory: 4 bytes a texel, and
// what painting takes while it goes on; take() allocates nothing. Failure: what cannot be painted stays grey.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "editor/jobs/overview_paint.h"

namespace fjell::editor {

class OverviewJob {
public:
    OverviewJob() = default;
    ~OverviewJob(); // waits for its threads, which stop after the page that they read
    OverviewJob(const OverviewJob&) = delete;
    OverviewJob& operator=(const OverviewJob&) = delete;

    // Another terrain, from nothing, or the same in other colours.
    void begin(OverviewSource source);
    void end(); // no terrain
    [[nodiscard]] bool there() const { return now_.sheet != nullptr; }
    // Something was painted since take().
    [[nodiscard]] bool news() const;
    // All that there will be is painted and taken.
    [[nodiscard]] bool done() const;
    // Gives what is painted so far: all texels, and the share of them that are no longer grey. False: the thread is
    // writing them, or there is none.
    using Take = void (*)(void* to, OverviewSize size, double share, std::span<const std::uint32_t> texels);
    bool take(Take give, void* to);
    // Threads that were told to stop and are not known to have stopped yet.
    [[nodiscard]] std::size_t leaving() const { return leaving_.size(); }

private:
    struct Sheet;
    struct Painting {
        std::shared_ptr<Sheet> sheet;
        std::jthread thread;
    };
    static void paint(Sheet& sheet, const OverviewSource& source, const std::stop_token& stop);
    void leave();

    Painting now_; // sheet null: none
    std::vector<Painting> leaving_;
};

} // namespace fjell::editor
