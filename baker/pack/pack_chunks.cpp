#include "baker/pack/pack_chunks.h"

#include "fjell/status.h"
#include "shared/order.h"

namespace fjell::baker {

std::vector<ChunkEntry> PackChunks::entries() const {
    std::vector<ChunkEntry> all(file_.pack().header.directory_count);
    for (std::uint64_t chunk = 0; chunk < all.size(); ++chunk) all[chunk] = file_.pack().entry(chunk);
    return all;
}

void PackChunks::read(std::uint64_t offset, std::span<std::byte> to) const {
    if (to.empty()) return;
    if (const int error = file_.read(offset, to); error != 0) file_.fail(error);
}

std::string PackChunks::damage(std::uint64_t offset) const {
    const PackHeader& h = file_.pack().header;
    std::uint64_t chunk = 0;
    while (chunk + 1 < h.directory_count && file_.pack().entry(chunk).offset != offset) ++chunk;
    return file_.path() + ": " + io::chunk_name(chunk_id(h, chunk)) + ": " + message(StatusCode::corrupt);
}

} // namespace fjell::baker
