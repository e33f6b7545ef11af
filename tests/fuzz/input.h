// How the bytes that a fuzz target is given are read: a short script first, then what is attacked. Shared with
// make_seed, and with nothing else.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace fjell::fuzz {

// fuzz_pack: this, then a pack.
struct PackScript {
    std::uint8_t repairs;   // Repair
    std::uint8_t slots;     // how many page slots: fewer than pages
    std::uint8_t eye;       // where to look from
    std::uint8_t frame;     // settings and budget
    std::uint8_t pages[12]; // which pages come and go
};
static_assert(sizeof(PackScript) == 16, "seeds begin with it");
enum Repair : std::uint8_t {
    repair_hashes = 1,   // of header, directory and chunks: a mutation never guesses 64 bits
    repair_directory = 2 // and put the directory at the end again, where an insertion has moved it
};

// fuzz_page: this, then a page's bytes as they are after decompression.
struct PageScript {
    std::uint8_t layout;                       // order = layout % 3, tile_log2 = 1 + layout / 3 % 8
    std::uint8_t page;                         // modulo pages a tile
    std::uint8_t scale;                        // of errors
    std::uint8_t fit;                          // odd: give the bytes the length that their flags ask for
    std::uint32_t corner_first, corner_stride; // height scale steps of the 33 x 33 corners
};
static_assert(sizeof(PageScript) == 12, "seeds begin with it");

// What must hold whatever the bytes.
inline void must(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "broken: %s\n", what);
    std::abort();
}

} // namespace fjell::fuzz
