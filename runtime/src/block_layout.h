// Where the parts of an object lie in the block of memory that its host gives it.
//
// Units: bytes. Counts are multiplied in 64 bits: a block larger than a pointer reaches (WebAssembly's have 32 bits)
// has an end() that no memory has, so that whoever compares finds the memory too small.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace fjell {

inline constexpr std::size_t block_alignment = 64;

template <typename Bytes>
[[nodiscard]] constexpr Bytes block_aligned(Bytes bytes) {
    return (bytes + (block_alignment - 1)) / block_alignment * block_alignment;
}

class BlockLayout {
public:
    explicit constexpr BlockLayout(std::size_t head_bytes) : at_(block_aligned<std::uint64_t>(head_bytes)) {}
    // Where the next part begins. Nothing is there if end() says that there is no such block.
    constexpr std::size_t place(std::uint64_t count, std::size_t bytes) {
        return static_cast<std::size_t>(std::exchange(at_, at_ + block_aligned(count * bytes)));
    }
    [[nodiscard]] constexpr std::size_t end() const {
        constexpr std::size_t most = std::numeric_limits<std::size_t>::max() / block_alignment * block_alignment;
        return at_ < most ? static_cast<std::size_t>(at_) : most;
    }

private:
    std::uint64_t at_;
};

} // namespace fjell
