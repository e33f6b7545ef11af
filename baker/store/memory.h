// Memory of a bake: of stores that lie in memory, and of the buffers that its units work in.
//
// The system clears a page when it is touched for the first time, and enters the kernel for it: 0.2 us for 4 KB, on a
// virtual machine up to 14. A bake that took its memory from malloc spent half of its time so. Hence memory comes in
// large pages, of 2 MB, where the system has them, and what one unit gives back the next one takes.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace fjell::baker {

// Bytes straight from the system, zero at first, resident when they are touched. Throws std::bad_alloc.
class ZeroedMemory {
public:
    ZeroedMemory() = default;
    explicit ZeroedMemory(std::size_t bytes);
    ~ZeroedMemory();
    ZeroedMemory(ZeroedMemory&& other) noexcept { swap(other); }
    ZeroedMemory& operator=(ZeroedMemory&& other) noexcept {
        ZeroedMemory(std::move(other)).swap(*this);
        return *this;
    }
    [[nodiscard]] std::byte* data() const { return data_; } // null: no bytes
    [[nodiscard]] std::size_t size() const { return bytes_; }

private:
    void swap(ZeroedMemory& other) noexcept {
        std::swap(mapped_, other.mapped_);
        std::swap(mapped_bytes_, other.mapped_bytes_);
        std::swap(data_, other.data_);
        std::swap(bytes_, other.bytes_);
    }
    void* mapped_ = nullptr;
    std::size_t mapped_bytes_ = 0;
    std::byte* data_ = nullptr; // in it, at the first border of large pages
    std::size_t bytes_ = 0;
};

// Buffers of at least this much come from memory that is kept for the next ones; smaller ones are malloc's.
inline constexpr std::size_t least_kept_bytes = std::size_t{64} << 10;

// Of at least least_kept_bytes; not cleared, aligned to 64 bytes. Any thread; what one takes another may give back.
// O(pieces), which are dozens. Throws std::bad_alloc.
[[nodiscard]] std::byte* take_kept(std::size_t bytes);
void give_kept(std::byte* at) noexcept;
// Hands what nobody holds back to the system: after a bake. Returns the bytes that stay: others are at work with them.
std::size_t release_kept() noexcept;

// A vector's memory is not cleared before it is written.
template <typename T>
struct Uninitialised {
    using value_type = T;
    Uninitialised() = default;
    template <typename U>
    Uninitialised(const Uninitialised<U>&) noexcept {}
    [[nodiscard]] T* allocate(std::size_t count) {
        const std::size_t bytes = count * sizeof(T);
        return bytes < least_kept_bytes ? std::allocator<T>().allocate(count)
                                        : static_cast<T*>(static_cast<void*>(take_kept(bytes)));
    }
    void deallocate(T* at, std::size_t count) noexcept {
        const std::size_t bytes = count * sizeof(T);
        if (bytes < least_kept_bytes) return std::allocator<T>().deallocate(at, count);
        give_kept(static_cast<std::byte*>(static_cast<void*>(at)));
    }
    template <typename U>
    void construct(U* at) noexcept {
        ::new (static_cast<void*>(at)) U; // no value: scalars stay as they are
    }
    template <typename U, typename... From>
    void construct(U* at, From&&... from) {
        ::new (static_cast<void*>(at)) U(std::forward<From>(from)...);
    }
    friend bool operator==(const Uninitialised&, const Uninitialised&) { return true; }
};
template <typename T>
using Buffer = std::vector<T, Uninitialised<T>>;

} // namespace fjell::baker
