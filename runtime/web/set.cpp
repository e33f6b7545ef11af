// A pack set: the packs of set.json as one pack (fjell/pack_set.h), whose files JavaScript reads (package/set.js).
#include <algorithm>
#include <memory>
#include <vector>

#include "calls.h"
#include "fjell/pack_set.h"

namespace fjell::web {

namespace {

struct AlignedFree {
    void operator()(std::byte* memory) const { web_free(memory); }
};
struct Part {
    std::vector<std::byte> index, corners;
    Pack pack;
    std::uint32_t tile_x = 0, tile_y = 0;
};
struct Set {
    std::vector<std::unique_ptr<Part>> parts; // where they are: parts of the joined index point to them
    std::unique_ptr<std::byte, AlignedFree> memory;
    std::string message;
};

} // namespace

FJELL_CALL Set* set_make() {
    return new Set;
}
FJELL_CALL void set_free(Set* set) {
    delete set;
}

// index: header, then directory; copied. numbers: where the corners are, and their bytes; tiles, cells of a tile,
// spacing, and the two halves of the pack's hash.
FJELL_CALL void set_part(Set* set, const std::byte* index, std::size_t bytes, double file_bytes, std::uint32_t tile_x,
                         std::uint32_t tile_y) {
    Part& part = *set->parts.emplace_back(std::make_unique<Part>());
    part.index.assign(index, index + bytes);
    part.tile_x = tile_x, part.tile_y = tile_y;
    const std::span all(part.index);
    require(open_index(all.first(sizeof(PackHeader)), all.subspan(sizeof(PackHeader)),
                       static_cast<std::uint64_t>(file_bytes), part.pack),
            "pack");
    const PackHeader& h = part.pack.header;
    const ChunkEntry corners = part.pack.entry(chunk_index(h, {ChunkKind::corners, 0, 0}));
    numbers[0] = static_cast<double>(corners.offset), numbers[1] = corners.stored_bytes;
    numbers[2] = h.tiles_x, numbers[3] = h.tiles_y, numbers[4] = static_cast<double>(1u << h.tile_log2);
    numbers[5] = h.spacing_m[0], numbers[6] = h.spacing_m[1];
    numbers[7] = static_cast<double>(h.directory_hash >> 32);
    numbers[8] = static_cast<double>(h.directory_hash & 0xffff'ffff);
}
FJELL_CALL void set_corners(Set* set, std::uint32_t part, const std::byte* stored, std::size_t bytes) {
    set->parts[part]->corners.assign(stored, stored + bytes);
}

// Null: joined. numbers: where the header is, where the tail is and its bytes, its offset, the whole's bytes. Otherwise
// what is wrong, and in numbers which part is at fault.
FJELL_CALL const char* set_join(Set* set, std::uint32_t columns, std::uint32_t rows) {
    std::vector<SetPart> parts;
    for (const auto& part : set->parts) parts.push_back({&part->pack, part->corners, part->tile_x, part->tile_y});
    const SetShape shape{columns, rows};
    const std::size_t bytes = std::max<std::size_t>(set_index_bytes(shape, parts), 64);
    set->memory.reset(static_cast<std::byte*>(web_allocate(bytes)));
    SetIndex index;
    std::uint32_t at_fault = 0;
    const Status status = make_set_index(shape, parts, {set->memory.get(), bytes}, index, at_fault);
    if (!status.ok()) {
        set->message = std::string(*status.field ? status.field : "set") + ": " + message(status.code);
        numbers[0] = at_fault;
        return set->message.c_str();
    }
    const auto address = [](std::span<const std::byte> bytes) {
        return static_cast<double>(reinterpret_cast<std::uintptr_t>(bytes.data()));
    };
    numbers[0] = address(index.header), numbers[1] = address(index.tail);
    numbers[2] = static_cast<double>(index.tail.size()), numbers[3] = static_cast<double>(index.tail_offset);
    numbers[4] = static_cast<double>(index.file_bytes);
    return nullptr;
}

} // namespace fjell::web
