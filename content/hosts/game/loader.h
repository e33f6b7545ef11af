// The thread that reads what a stream asks for.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include <fjell/fjell.h>

#include "pack_on_disk.h"

namespace game {

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
