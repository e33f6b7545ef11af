// Sizes of maps that tiles have, want, fade to, and give back.
#pragma once

#include "stream/state.h"

namespace fjell {

void begin_maps(StreamState& s);

// What has come since the last update becomes commands for the renderer, up to StreamSettings::map_bytes.
void upload_maps(StreamState& s);

// Looks at some tiles, asks for the mips that lack most, and fades.
void request_maps(StreamState& s, double seconds);

void forget_failed_maps(StreamState& s);

} // namespace fjell
