// What a bake keeps outside of memory: a folder beside the pack, and 2-D arrays in files in it, read and written by
// windows.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "baker/store/memory.h"
#include "baker/store/window.h"
#include "shared/compiler.h"

namespace fjell::baker {

// A checksum of a file that is written in any order, in any pieces, by any threads: what a resumed bake compares the
// files of its work folder with.
//
// It is a sum over the file's 8-byte words, each times a factor of its place, so that digests of disjoint pieces add up
// to that of the whole, however unevenly it was cut. (A hash of the bytes in their order would have to read them all
// again once a stage is complete.) Zeros add nothing: what was never written is as good as zero.

struct Digest {
    // Of words as they are and with their bytes in reverse: factors of places are odd, so a word's low bits are mixed
    // well into one of the two and its high bits into the other.
    std::uint64_t forwards = 0, backwards = 0;

    Digest& operator+=(const Digest& other) {
        forwards += other.forwards;
        backwards += other.backwards;
        return *this;
    }
    friend bool operator==(const Digest&, const Digest&) = default;
};

// Of these bytes, `offset` bytes into their file. Some 10 GB/s.
[[nodiscard]] Digest digest_of(std::uint64_t offset, std::span<const std::byte> bytes);

// A file of fixed size, or as much memory where there is no path. Reads and writes of different places may run at the
// same time. Throws Failure (3: the disk).
class WorkFile {
public:
    WorkFile() = default;
    // Made, or found as an earlier run left it. bytes: its size, or `grows`.
    static constexpr std::uint64_t grows = ~std::uint64_t{0};
    // Room on the disk: taken at once, so that a disk that is too small is known before the work, or as it is written.
    enum class Room : bool { reserved, as_written };
    WorkFile(std::string path, std::uint64_t bytes, Room room = Room::reserved);
    // One that is complete and only read. Throws Failure 1 where it is missing or of another size.
    [[nodiscard]] static WorkFile complete(const std::string& path, std::uint64_t bytes);
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
    [[nodiscard]] const std::byte* in_memory() const { return memory_.data(); } // its first byte; null: in a file
    [[nodiscard]] std::uint64_t size() const;

    // What a file holds, to be compared by a later run; of memory, which no later run meets, always the same.
    // written(): of what was written so far, each place at most once. digest(): of its first bytes, read again; as of
    // zeros where it is shorter. What the file system knows for never written is not read.
    [[nodiscard]] Digest written() const;
    [[nodiscard]] Digest digest(std::uint64_t bytes) const;

private:
    struct Sum {
        std::atomic<std::uint64_t> forwards{0}, backwards{0};
    };
    void reserve(std::uint64_t bytes, Room room);
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
    ZeroedMemory memory_;
};

// columns x rows of T, row by row; or a window of them, and a frame around it that others have made.
template <typename T>
class Store {
public:
    Store() = default;
    Store(const std::string& path, std::int64_t columns, std::int64_t rows)
        : columns_(columns), rows_(rows), file_(path, static_cast<std::uint64_t>(columns * rows) * sizeof(T)) {}
    // Holds only a window; places are counted over the whole all the same.
    Store(const std::string& path, std::int64_t columns, std::int64_t rows, const Window& held,
          WorkFile::Room room = WorkFile::Room::reserved)
        : columns_(columns), rows_(rows), held_(held),
          file_(path, (held.area() ? held.area() : static_cast<std::uint64_t>(columns * rows)) * sizeof(T), room) {}
    // The same of a file that is complete (WorkFile::complete).
    [[nodiscard]] static Store complete(const std::string& path, std::int64_t columns, std::int64_t rows,
                                        const Window& held) {
        Store store;
        store.columns_ = columns, store.rows_ = rows, store.held_ = held;
        store.file_ = WorkFile::complete(path, held.area() * sizeof(T));
        return store;
    }
    [[nodiscard]] std::int64_t columns() const { return columns_; } // of the whole
    [[nodiscard]] std::int64_t rows() const { return rows_; }
    [[nodiscard]] const Window& held() const { return held_; } // no area: the whole
    [[nodiscard]] bool exists() const { return columns_ != 0; }

    // What was never written is void, NaN, and takes no room: the file holds NaN as zeros. Before anything is read or
    // written, each time that the store is opened.
    void unwritten_is_void() requires std::is_same_v<T, float> {
        flip_ = bits_as<std::uint32_t>(std::numeric_limits<float>::quiet_NaN());
    }
    [[nodiscard]] bool is_unwritten_void() const { return flip_ != 0; }

    // Values beside the window that is held, for reading. Windows do not overlap, nor the one that is held.
    void add_frame(const Window& at, Buffer<T> values) { frame_.push_back({at, std::move(values)}); }

    // The window lies inside. stride: elements from row to row of `to` and `from`.
    void read(const Window& w, T* to, std::ptrdiff_t stride) const {
        if (holds(w)) return read_held(w, to, stride);
        std::size_t found = 0;
        const auto part = [&](const Window& of, const auto& take) {
            const Window shared = common(of, w);
            if (shared.area() == 0) return;
            found += shared.area();
            take(shared, to + std::ptrdiff_t{shared.y - w.y} * stride + (shared.x - w.x));
        };
        part(held_, [&](const Window& shared, T* at) { read_held(shared, at, stride); });
        for (const Frame& f : frame_)
            part(f.at, [&](const Window& shared, T* at) {
                const T* from =
                    f.values.data() + std::ptrdiff_t{shared.y - f.at.y} * f.at.columns + (shared.x - f.at.x);
                for (std::int32_t y = 0; y < shared.rows; ++y, at += stride, from += f.at.columns)
                    std::copy_n(from, shared.columns, at);
            });
        if (found != w.area()) throw std::logic_error("a window reaches beyond what a store holds");
    }
    void write(const Window& w, const T* from, std::ptrdiff_t stride) {
        if (!holds(w)) throw std::logic_error("a window is written that a store does not hold");
        Buffer<T> flipped;
        each_run(w, stride, [&](std::uint64_t at, std::ptrdiff_t offset, std::size_t count) {
            const T* run = from + offset;
            if (flip_ != 0) {
                flipped.assign(run, run + count);
                flip(flipped.data(), count);
                run = flipped.data();
            }
            file_.write(at, std::as_bytes(std::span(run, count)));
        });
    }
    void remove() {
        file_.remove();
        frame_.clear();
        columns_ = rows_ = 0;
    }
    void clear() { file_.clear(); }
    // The first value of the first row, rows columns() apart; null where not all values lie in memory as they are.
    [[nodiscard]] const T* in_memory() const {
        const bool as_they_are = held_.area() == 0 && flip_ == 0 && frame_.empty();
        return as_they_are ? static_cast<const T*>(static_cast<const void*>(file_.in_memory())) : nullptr;
    }
    // As of a WorkFile, of all that is held.
    [[nodiscard]] Digest written() const { return file_.written(); }
    [[nodiscard]] Digest digest() const {
        return file_.digest(static_cast<std::uint64_t>(held_columns() * (held_.area() ? held_.rows : rows_)) *
                            sizeof(T));
    }

private:
    struct Frame {
        Window at;
        Buffer<T> values;
    };
    [[nodiscard]] bool holds(const Window& w) const {
        return held_.area() == 0 || (w.x >= held_.x && w.y >= held_.y && w.x + w.columns <= held_.x + held_.columns &&
                                     w.y + w.rows <= held_.y + held_.rows);
    }
    [[nodiscard]] std::int64_t held_columns() const { return held_.area() ? held_.columns : columns_; }
    void read_held(const Window& w, T* to, std::ptrdiff_t stride) const {
        each_run(w, stride, [&](std::uint64_t at, std::ptrdiff_t offset, std::size_t count) {
            file_.read(at, std::as_writable_bytes(std::span(to + offset, count)));
            if (flip_ != 0) flip(to + offset, count);
        });
    }
    void flip(T* values, std::size_t count) const {
        if constexpr (std::is_same_v<T, float>)
            for (std::size_t i = 0; i < count; ++i)
                values[i] = bits_as<float>(bits_as<std::uint32_t>(values[i]) ^ flip_);
    }
    template <typename Run>
    void each_run(const Window& w, std::ptrdiff_t stride, const Run& run) const {
        const std::int64_t columns = held_columns();
        const auto place = [&](std::int32_t y) {
            return static_cast<std::uint64_t>((y - held_.y) * columns + (w.x - held_.x)) * sizeof(T);
        };
        if (w.columns == columns && stride == w.columns) return run(place(w.y), 0, w.area()); // rows follow each other
        for (std::int32_t y = 0; y < w.rows; ++y) run(place(w.y + y), y * stride, static_cast<std::size_t>(w.columns));
    }
    std::int64_t columns_ = 0, rows_ = 0;
    Window held_;
    std::uint32_t flip_ = 0; // of the bits of floats, between the file and whoever reads
    WorkFile file_;
    std::vector<Frame> frame_;
};

// A window of a store, to be read: where it lies in memory, or else copied. The store must stay, and what lies in the
// window.
template <typename T>
class StoreView {
public:
    StoreView(const Store<T>& store, const Window& window) : first_(store.in_memory()), stride_(store.columns()) {
        if (first_) {
            first_ += window.y * stride_ + window.x;
            return;
        }
        copy_.resize(window.area());
        stride_ = window.columns;
        store.read(window, copy_.data(), stride_);
        first_ = copy_.data();
    }
    StoreView(const StoreView&) = delete;
    StoreView& operator=(const StoreView&) = delete;
    // Rows and columns are counted from the window's.
    [[nodiscard]] const T* row(std::int32_t y) const { return first_ + y * stride_; }
    [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }

private:
    const T* first_;
    std::ptrdiff_t stride_;
    Buffer<T> copy_;
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
