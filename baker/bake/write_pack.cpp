// The last stage: the pack's chunks, in the order in which a reader wants them.
#include <cstdint>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/pack/assemble.h"
#include "baker/pack/notes.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

// Page 0 of all tiles, then step by step, so that a prefix of the file is the whole terrain, coarser. Linear order
// knows no steps: tile by tile.
std::vector<ChunkId> chunk_sequence(const PackHeader& header, const PageLayout& layout) {
    std::vector<ChunkId> sequence{{ChunkKind::corners, 0, 0}};
    const std::uint32_t tiles = header.tiles_x * header.tiles_y, pages = layout.pages_per_tile();
    const auto add_pages = [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t page = from; page < to; ++page) sequence.push_back({ChunkKind::geometry, tile, page});
    };
    if (layout.order == Order::linear) {
        add_pages(0, pages);
    } else {
        add_pages(0, 1);
        for (std::uint32_t page = 1; page < pages;) {
            std::uint32_t end = page;
            while (end < pages && layout.page_step_log2(end) == layout.page_step_log2(page)) ++end;
            add_pages(page, end);
            page = end;
        }
    }
    const auto add_maps = [&](ChunkKind kind, std::uint32_t log2_side) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t mip = 0; mip < mip_count(log2_side); ++mip) sequence.push_back({kind, tile, mip});
    };
    add_maps(ChunkKind::colour, header.colour_log2);
    add_maps(ChunkKind::normal, header.normal_log2);
    add_maps(ChunkKind::horizon, header.horizon_log2);
    add_maps(ChunkKind::control, header.control_log2);
    if (header.crs_bytes) sequence.push_back({ChunkKind::crs, 0, 0});
    if (header.layer_bytes) sequence.push_back({ChunkKind::layers, 0, 0});
    return sequence;
}

} // namespace

void write_pack(const BakeContext& context, const PackHeader& header, const ChunkSource& chunks, BakeSummary& summary) {
    const std::vector<ChunkId> sequence = chunk_sequence(header, context.pages);
    io::AtomicFile out(context.out_path, context.temporary());
    const Progress& progress = context.options.progress;
    const PackNotes notes{context.options.reading, context.source.facts, summary.ground_error_m};
    summary.file_bytes = assemble_pack(header, chunks, sequence, notes_text(notes), out, [&](std::uint64_t n) {
        if (progress) progress("write", n, sequence.size());
    });
    const std::vector<ChunkEntry> entries = chunks.entries();
    const std::uint64_t tiles = std::uint64_t{header.tiles_x} * header.tiles_y;
    const std::uint64_t maps = 1 + tiles * context.pages.pages_per_tile(); // the corners before them
    for (std::uint64_t i = 0; i < entries.size(); ++i) {
        const ChunkKind kind = chunk_id(header, i).kind;
        if (kind == ChunkKind::crs || kind == ChunkKind::layers) continue;
        (i < maps ? summary.geometry_bytes : summary.texture_bytes) += entries[i].stored_bytes;
        if (kind == ChunkKind::horizon) summary.horizon_bytes += entries[i].stored_bytes;
        if (kind == ChunkKind::control) summary.control_bytes += entries[i].stored_bytes;
    }
    summary.directory_bytes = maps * sizeof(ChunkEntry) + sizeof(PackHeader);
    out.commit();
}

} // namespace fjell::baker
