// What a bake keeps outside of memory: a folder beside the pack, and 2-D arrays in files in it, read and written by
// windows.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "baker/store/digest.h"
#include "baker/store/window.h"

namespace fjell::baker {

// A vector's memory is not cleared before it is written.
template <typename T>
struct Uninitialised : std::allocator<T> {
    template <typename U>
    struct rebind {
        using other = Uninitialised<U>;
    };
    template <typename U>
    void construct(U* at) noexcept {
        ::new (static_cast<void*>(at)) U; // no value: scalars stay as they are
    }
    template <typename U, typename... From>
    void construct(U* at, From&&... from) {
        ::new (static_cast<void*>(at)) U(std::forward<From>(from)...);
    }
};
template <typename T>
using Buffer = std::vector<T, Uninitialised<T>>;

// A file of fixed size, or as much memory where there is no path. Reads and writes of different places may run at the
// same time. Throws Failure (3: the disk).
class WorkFile {
public:
    WorkFile() = default;
    // Made, or found as an earlier run left it. bytes: its size, or `grows`.
    static constexpr std::uint64_t grows = ~std::uint64_t{0};
    WorkFile(std::string path, std::uint64_t bytes);
    ~WorkFile();
    WorkFile(WorkFile&& other) noexcept { swap(other); }
    WorkFile& operator=(WorkFile&& other) noexcept {
        swap(other);
        return *this;
    }

    void read(std::uint64_t offset, std::span<std::byte> to) const;
    void write(std::uint64_t offset, std::span<const std::byte> from);
    void remove(); // closes it and gives its space back; harmless when there is none
    void clear();  // what an earlier run has left is zero again
    [[nodiscard]] std::uint64_t size() const;

    // What a file holds, to be compared by a later run; of memory, which no later run meets, always the same.
    // written(): of what was written so far, each place at most once. digest(): of its first bytes, read again; as of
    // zeros where it is shorter.
    [[nodiscard]] Digest written() const;
    [[nodiscard]] Digest digest(std::uint64_t bytes) const;

private:
    struct Sum {
        std::atomic<std::uint64_t> forwards{0}, backwards{0};
    };
    void reserve(std::uint64_t bytes);
    void swap(WorkFile& other) noexcept {
        std::swap(path_, other.path_);
        std::swap(fd_, other.fd_);
        std::swap(found_, other.found_);
        std::swap(sum_, other.sum_);
        std::swap(memory_, other.memory_);
    }
    std::string path_;
    int fd_ = -1;
    bool found_ = false; // an earlier run has left it
    std::unique_ptr<Sum> sum_;
    Buffer<std::byte> memory_;
};

// columns x rows of T, row by row.
template <typename T>
class Store {
public:
    Store() = default;
    Store(const std::string& path, std::int64_t columns, std::int64_t rows)
        : columns_(columns), rows_(rows), file_(path, static_cast<std::uint64_t>(columns * rows) * sizeof(T)) {}
    [[nodiscard]] std::int64_t columns() const { return columns_; }
    [[nodiscard]] std::int64_t rows() const { return rows_; }
    [[nodiscard]] bool exists() const { return columns_ != 0; }

    // The window lies inside. stride: elements from row to row of `to` and `from`.
    void read(const Window& w, T* to, std::ptrdiff_t stride) const {
        each_run(w, stride, [&](std::uint64_t at, std::ptrdiff_t offset, std::size_t count) {
            file_.read(at, std::as_writable_bytes(std::span(to + offset, count)));
        });
    }
    void write(const Window& w, const T* from, std::ptrdiff_t stride) {
        each_run(w, stride, [&](std::uint64_t at, std::ptrdiff_t offset, std::size_t count) {
            file_.write(at, std::as_bytes(std::span(from + offset, count)));
        });
    }
    void remove() {
        file_.remove();
        columns_ = rows_ = 0;
    }
    void clear() { file_.clear(); }
    // As of a WorkFile, of all of it.
    [[nodiscard]] Digest written() const { return file_.written(); }
    [[nodiscard]] Digest digest() const {
        return file_.digest(static_cast<std::uint64_t>(columns_ * rows_) * sizeof(T));
    }

private:
    template <typename Run>
    void each_run(const Window& w, std::ptrdiff_t stride, const Run& run) const {
        const auto place = [&](std::int32_t y) { return static_cast<std::uint64_t>(y * columns_ + w.x) * sizeof(T); };
        if (w.columns == columns_ && stride == w.columns) return run(place(w.y), 0, w.area()); // rows follow each other
        for (std::int32_t y = 0; y < w.rows; ++y) run(place(w.y + y), y * stride, static_cast<std::size_t>(w.columns));
    }
    std::int64_t columns_ = 0, rows_ = 0;
    WorkFile file_;
};

// The folder PACK.work. One process at a time. Unless it is kept, the destructor removes it with all that is in it.
// What an earlier run has left is kept until keep(false): a failure before its worth is known must not cost hours.
class WorkFolder {
public:
    // Throws Failure: 3 when it cannot be made, 1 when another bake is at work in it, or it is somebody else's.
    explicit WorkFolder(const std::string& pack_path);
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    bool empty(); // removes what is in it, but for the lock; false when something stays
    void keep(bool kept = true) { keep_ = kept; }
    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

private:
    [[nodiscard]] bool take_lock(const std::string& pack_path); // false: the folder went away meanwhile
    std::string path_;
    int lock_ = -1;
    bool keep_ = false;
};

} // namespace fjell::baker
