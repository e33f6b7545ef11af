// Paint of a terrain (StampShape::paint): blocks of samples that have some, and what has changed.
//
// The frame's thread paints; streams' clients and hosts read on any thread (shared/paint.h). A block never moves while
// it has paint, and its words are written one by one. Only the table of blocks must be seen whole: a counter is odd
// while it changes, and who has seen it move looks again. What is read while it is painted may be half painted: it is
// in a change that is noted afterwards, so whoever follows the changes reads it again.
#pragma once

#include <cstdint>

#include "edit/apply.h"
#include "edit/state.h"
#include "fjell/stream.h"
#include "shared/paint.h"

namespace fjell {

inline constexpr std::uint32_t paint_change_log = 256; // changes that are remembered

struct PaintData {
    BlockHead head;    // of a copy (copy_paint())
    PackHeader header; // of the terrain, which is not sparse
    edit::PaintBlock* blocks;
    std::uint32_t capacity, count;
    std::uint32_t* free_numbers; // of blocks: capacity - count of them
    std::uint32_t* table;        // by hash of their places: number, or no_index
    std::uint32_t table_size;
    std::uint32_t epoch;   // odd while the table changes
    std::uint64_t changes; // so far; the n-th is changed[n % paint_change_log], in samples
    edit::Rect changed[paint_change_log];
};

namespace edit {

// Bytes that it takes, in one piece, and the piece made one. memory: cleared.
[[nodiscard]] std::size_t paint_bytes_of(std::uint32_t blocks);
[[nodiscard]] PaintData* make_paint(const PackHeader& header, std::uint32_t blocks, std::byte* memory);

// Into one that has room.
void copy_block(const PaintBlock& from, PaintData& to);

// Any thread.
[[nodiscard]] PaintSource source_of(const PaintData& paint);
// Of one mip as the pack stores it. tile: by number. False: no paint reaches it, and no bit has changed.
bool paint_mip(const PaintData& paint, MapKind map, std::uint32_t tile, std::uint32_t side_log2, const MapRect& at,
               std::byte* blocks);
[[nodiscard]] PaintGrid grid_of_mip(const PackHeader& header, MapKind map, std::uint32_t tile, std::uint32_t side_log2);

// The next piece of a stamp that paints. True: it is done, or refused.
[[nodiscard]] bool paint_piece(EditsData& e, Waiting& w, Refusal& refusal);

} // namespace edit
} // namespace fjell
