// What the game hands to Fjell: pieces that lie where they are until the game ends.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

namespace game {

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

} // namespace game
