// Sizes of maps that tiles have, want, fade to, and release.
#pragma once

#include "stream/state.h"

namespace fjell {

// Chunks of a kind of map, by its number; and the way back.
[[nodiscard]] constexpr ChunkKind chunks_of_map(std::uint32_t kind) {
    return kind == 0   ? ChunkKind::colour
           : kind == 1 ? ChunkKind::normal
           : kind == 2 ? ChunkKind::horizon
                       : ChunkKind::splat;
}
[[nodiscard]] constexpr std::uint32_t map_of_chunks(ChunkKind kind) {
    return kind == ChunkKind::colour ? 0 : kind == ChunkKind::normal ? 1 : kind == ChunkKind::horizon ? 2 : 3;
}

void begin_maps(StreamState& s);

// What has arrived since the last update becomes commands for the renderer, up to StreamSettings::map_bytes.
void upload_maps(StreamState& s);

// On a client's thread: puts paint over what it has decompressed. Of a request that repaints it leaves the parts that
// may be others.
void paint_request(const StreamState& s, Request& r);
// Where paint has changed, mips that are there are read again, and become patches of the layers that tiles have now.
void publish_patches(StreamState& s);

// Tests some tiles, requests the mips that are missed most, and fades.
void request_maps(StreamState& s, double seconds);

void forget_failed_maps(StreamState& s);

} // namespace fjell
