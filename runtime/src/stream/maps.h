// Sizes of maps that tiles have, want, fade to, and release.
#pragma once

#include "stream/state.h"

namespace fjell {

void begin_maps(StreamState& s);

// What has arrived since the last update becomes commands for the renderer, up to StreamSettings::map_bytes.
void upload_maps(StreamState& s);

// Tests some tiles, requests the mips that are missed most, and fades.
void request_maps(StreamState& s, double seconds);

void forget_failed_maps(StreamState& s);

} // namespace fjell
