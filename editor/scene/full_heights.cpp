#include "editor/scene/full_heights.h"

#include <exception>
#include <utility>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"

namespace fjell::editor {

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
    if (heights_) {
        problem_ = renderer.set_heights({heights_->columns, heights_->rows, heights_->step_log2, heights_->heights_m});
        uploaded_ = problem_.empty();
    }
    heights_.reset();
    return uploaded_;
}

} // namespace fjell::editor
