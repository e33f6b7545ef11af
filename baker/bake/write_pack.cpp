// The last stage: the pack's chunks, in the order in which a reader wants them.
#include <cstdint>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/pack/assemble.h"
#include "baker/pack/notes.h"
#include "io/file.h"
#include "tree/order.h"

namespace fjell::baker {

std::string notes_of(const BakeContext& context, const BakeSummary& summary) {
    return notes_text({context.options.reading, context.source.facts, summary.ground_error_m});
}

void count_bytes(const PackHeader& header, const std::vector<ChunkEntry>& entries, BakeSummary& summary) {
    const std::uint64_t tiles = std::uint64_t{header.tiles_x} * header.tiles_y;
    const std::uint64_t maps = 1 + tiles * pages_of(header).pages_per_tile(); // the corners before them
    for (std::uint64_t i = 0; i < entries.size(); ++i) {
        const ChunkKind kind = chunk_id(header, i).kind;
        if (kind == ChunkKind::crs || kind == ChunkKind::layers) continue;
        (i < maps ? summary.geometry_bytes : summary.texture_bytes) += entries[i].stored_bytes;
        if (kind == ChunkKind::horizon) summary.horizon_bytes += entries[i].stored_bytes;
        if (kind == ChunkKind::control) summary.control_bytes += entries[i].stored_bytes;
    }
    summary.directory_bytes = maps * sizeof(ChunkEntry) + sizeof(PackHeader);
}

void write_pack(const BakeContext& context, const PackHeader& header, const ChunkSource& chunks, BakeSummary& summary) {
    const std::vector<ChunkId> sequence = chunk_sequence(header);
    io::AtomicFile out(context.out_path, context.temporary());
    const Progress& progress = context.options.progress;
    (void)assemble_pack(header, chunks, sequence, notes_of(context, summary), out, [&](std::uint64_t n) {
        if (progress) progress("write", n, sequence.size());
    });
    summary.file_bytes = out.size();
    count_bytes(header, chunks.entries(), summary);
    out.commit();
}

} // namespace fjell::baker
