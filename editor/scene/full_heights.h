// The heights that the picture of the true error is compared with: read once from the pack's file, on a thread of its
// own, when that picture is first asked for.
//
// Ownership: the thread and, until they are on the GPU, the heights. Thread: the frame's, with the graphics context
// current in upload(). Memory: 4 bytes a sample, most_samples of them; a larger terrain is compared at every second,
// fourth, ... sample. Failure: problem() is one line; it is not tried again
// before allow_retry() or forget().
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "fjell/gl/renderer.h"
#include "fjell/io/heights.h"

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
