// How long the GPU takes for a frame, by timestamps that it notes itself; known some frames later.
//
// Software renderers return nonsense: whoever draws by one leaves it off. Ownership: its queries. Thread: the
// context's. Memory: none after the first frame. Nothing here waits for the GPU.
#pragma once

#include <array>
#include <cstddef>

namespace fjell::editor {

class GpuTimer {
public:
    void begin(); // of a frame; nothing where all queries are still under way
    void end();
    // Of the newest frame whose result has come since the last call, microseconds; below 0: none has.
    [[nodiscard]] double take_us();
    void drop_graphics(); // before the context goes

private:
    static constexpr std::size_t frames = 4; // the GPU is up to three behind
    struct Pair {
        unsigned names[2] = {};
        bool waits = false;
    };
    std::array<Pair, frames> pairs_{};
    std::size_t next_ = 0, oldest_ = 0;
    bool begun_ = false;
};

} // namespace fjell::editor
