// What a streamed pack needs of a game: memory, the pack on the disk, and the thread that reads what a stream asks for.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fjell/fjell.h>

namespace game {

// What the game hands to Fjell: pieces that lie where they are until the game ends.
class Memory {
public:
    // Aligned to 64 bytes. Empty: there is none, and create_...() answers memory_too_small.
    std::span<std::byte> allocate(std::size_t bytes) {
        const std::size_t rounded = (bytes + 63) / 64 * 64;
        pieces_.emplace_back(static_cast<std::byte*>(std::aligned_alloc(64, rounded)));
        return {pieces_.back().get(), pieces_.back() ? rounded : 0};
    }

private:
    struct Free {
        void operator()(std::byte* piece) const { std::free(piece); }
    };
    std::vector<std::unique_ptr<std::byte, Free>> pieces_;
};

// A pack that stays on the disk: its header, directory and corners in memory, the rest read when it is wanted.
class PackOnDisk {
public:
    PackOnDisk() = default;
    ~PackOnDisk();
    PackOnDisk(const PackOnDisk&) = delete;
    PackOnDisk& operator=(const PackOnDisk&) = delete;

    // Empty, or one line that says what is wrong.
    [[nodiscard]] std::string open(const char* path);
    // All of the bytes from there on. False: the disk failed, or the file ends before. Any thread.
    [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const;

    [[nodiscard]] const fjell::Pack& pack() const { return pack_; }
    [[nodiscard]] std::span<const std::byte> corners() const { return corners_; }

private:
    int file_ = -1;
    std::vector<std::byte> directory_, corners_;
    fjell::Pack pack_; // points into directory_
};

// The thread that reads what a stream asks for.
class Loader {
public:
    Loader(fjell::Stream stream, const PackOnDisk& file) : stream_(stream), file_(file), thread_([this] { run(); }) {}
    // Waits for at most one read. Every request that the loader took has been answered by then.
    ~Loader();
    Loader(const Loader&) = delete;
    Loader& operator=(const Loader&) = delete;

    // After update_stream(), on the frame's thread: there may be requests.
    void wake();

private:
    void run();
    void serve(const fjell::StreamRequest& request);

    const fjell::Stream stream_;
    const PackOnDisk& file_;
    std::vector<std::byte> bytes_;
    std::atomic<std::uint32_t> wakes_{0};
    std::atomic<bool> stop_{false};
    std::thread thread_; // last: it uses the others
};

} // namespace game
