// A page's bytes as one zstd frame: smaller, and sooner decompressed, than zstd itself would make it.
//
// Low bytes of heights are often noise, in which zstd's codes save a few percent and take two thirds of a reader's
// time; and one set of codes for them and for the high ones suits neither. Where they save less than a tenth by
// themselves they become a block of their own that is not compressed, and what follows is coded byte by byte, without
// matches. It is a frame like any other: every reader of zstd reads it.
#pragma once

#include <cstddef>
#include <span>

#include "baker/store/memory.h"

namespace fjell::baker {

// Appends the frame to `to`. low_end: page[0, low_end) is the head and the low bytes of heights (EncodedPage::low_end).
// Any thread. The same bytes for the same page, whatever was compressed before. Throws io::Failure without memory.
void compress_page(std::span<const std::byte> page, std::size_t low_end, Buffer<std::byte>& to);

} // namespace fjell::baker
