// Readers of a source that wait for a thread: opening one costs as much as reading a window.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace fjell::baker {

// Source: HeightSource or ImageSource; null: all readers are null. Any thread may take and give.
template <typename Source, typename Reader>
class ReaderPool {
public:
    explicit ReaderPool(const Source* source) : source_(source) {}
    [[nodiscard]] std::unique_ptr<Reader> take() {
        if (!source_) return nullptr;
        const std::lock_guard hold(lock_);
        if (free_.empty()) return source_->reader();
        std::unique_ptr<Reader> reader = std::move(free_.back());
        free_.pop_back();
        return reader;
    }
    void give(std::unique_ptr<Reader> reader) {
        const std::lock_guard hold(lock_);
        if (reader) free_.push_back(std::move(reader));
    }

private:
    const Source* source_;
    std::mutex lock_;
    std::vector<std::unique_ptr<Reader>> free_;
};

} // namespace fjell::baker
