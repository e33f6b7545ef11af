// A checksum of a file that is written in any order, in any pieces, by any threads: what a resumed bake compares the
// files of its work folder with.
//
// It is a sum over the file's 8-byte words, each times a factor of its place, so that digests of disjoint pieces add up
// to that of the whole, however unevenly it was cut. (A hash of the bytes in their order would have to read them all
// again once a stage is complete.) Zeros add nothing: what was never written is as good as zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fjell::baker {

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

} // namespace fjell::baker
