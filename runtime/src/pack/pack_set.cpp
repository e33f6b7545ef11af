// The set's index is what assemble_pack() of the baker would have written for the whole, with the offsets of chunks
// that lie in other files. Nothing of a part is trusted: open_index() has checked it, and looks at the result again.
#include "fjell/pack_set.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "block_layout.h"
#include "shared/hash.h"
#include "shared/order.h"

namespace fjell {

namespace {

// Whether parts may stand in one terrain: nullptr, or what differs.
const char* difference(const PackHeader& a, const PackHeader& b) {
    if (a.tile_log2 != b.tile_log2) return "tile size";
    if (a.order != b.order) return "order";
    if (a.estimate != b.estimate) return "estimate";
    if (!std::equal(&a.nesting, &a.nesting + 1, &b.nesting) || a.error_nesting_steps != b.error_nesting_steps)
        return "nesting";
    if (!std::equal(a.spacing_m, a.spacing_m + 2, b.spacing_m)) return "spacing";
    if (a.base_m < b.base_m || a.base_m > b.base_m || a.quantum_m < b.quantum_m || a.quantum_m > b.quantum_m)
        return "height scale";
    if (!std::equal(&a.error_floor_m, &a.error_floor_m + 1, &b.error_floor_m) ||
        !std::equal(&a.error_ratio, &a.error_ratio + 1, &b.error_ratio))
        return "error scale";
    if (!std::equal(std::begin(a.level_radius_m), std::end(a.level_radius_m), b.level_radius_m)) return "radius scale";
    if (a.colour_log2 != b.colour_log2) return "size of colour maps";
    if (a.normal_log2 != b.normal_log2) return "size of normal maps";
    if (a.horizon_log2 != b.horizon_log2) return "size of horizon maps";
    if (a.splat_log2 != b.splat_log2 || a.layer_bytes != b.layer_bytes) return "size of splat maps";
    if (a.crs_bytes != b.crs_bytes || !std::equal(a.crs_step, a.crs_step + 2, b.crs_step)) return "CRS";
    return nullptr;
}

// A CRS unit a sample; metres where the pack does not say.
double step_of(const PackHeader& h, int axis) {
    return h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis];
}
// Where sample (0, 0) of the whole lies, as a part's place says.
double origin_of(const SetPart& part, int axis) {
    const PackHeader& h = part.pack->header;
    const double cells = std::ldexp(axis == 0 ? part.tile_x : part.tile_y, static_cast<int>(h.tile_log2));
    return axis == 0 ? h.crs_origin[0] - cells * step_of(h, 0) : h.crs_origin[1] + cells * step_of(h, 1);
}
// Packs say their places in doubles, which are far finer than this part of a cell.
constexpr double most_apart = 1e-3;

Status check_part(const SetShape& shape, const SetPart& first, const SetPart& part) {
    if (part.pack == nullptr || part.pack->directory == nullptr) return {StatusCode::not_a_pack, "pack"};
    const PackHeader &h = part.pack->header, &a = first.pack->header;
    if (h.tiles_held != 0) return {StatusCode::not_supported, "a set in a set"};
    if (const char* const differs = difference(h, a)) return {StatusCode::wrong_pack, differs};
    if (h.crs_bytes != 0) {
        const ChunkId crs{ChunkKind::crs, 0, 0};
        if (part.pack->entry(chunk_index(h, crs)).hash != first.pack->entry(chunk_index(a, crs)).hash)
            return {StatusCode::wrong_pack, "CRS"};
    }
    // What splat maps mean by a number.
    if (const ChunkId names{ChunkKind::layers, 0, 0};
        h.layer_bytes != 0 &&
        part.pack->entry(chunk_index(h, names)).hash != first.pack->entry(chunk_index(a, names)).hash)
        return {StatusCode::wrong_pack, "names of layers"};
    for (const int axis : {0, 1})
        if (!(std::abs(origin_of(part, axis) - origin_of(first, axis)) < most_apart * step_of(h, axis)))
            return {StatusCode::wrong_pack, "place (origin and tile_x, tile_y)"};
    const Tree whole = Tree::covering(static_cast<std::int32_t>(shape.columns), static_cast<std::int32_t>(shape.rows),
                                      static_cast<int>(h.tile_log2));
    const auto fits = [&](std::uint32_t tile, std::uint32_t tiles, std::int32_t all, std::uint32_t samples,
                          std::uint32_t of_whole) {
        if (tile > static_cast<std::uint32_t>(all) || tiles > static_cast<std::uint32_t>(all) - tile) return false;
        const std::uint32_t side = 1u << h.tile_log2; // the last tiles end with the terrain, all others are whole
        return samples == std::min(of_whole - tile * side, tiles * side + 1);
    };
    if (!fits(part.tile_x, h.tiles_x, whole.tiles_x, h.columns, shape.columns))
        return {StatusCode::out_of_range, "tile_x, or columns of the pack or the set"};
    if (!fits(part.tile_y, h.tiles_y, whole.tiles_y, h.rows, shape.rows))
        return {StatusCode::out_of_range, "tile_y, or rows of the pack or the set"};
    return {};
}

// Everything that can be known without memory: the header, but for its hashes and what the corners say.
Status plan(const SetShape& shape, std::span<const SetPart> parts, PackHeader& h, std::uint32_t& at_fault) {
    at_fault = static_cast<std::uint32_t>(parts.size());
    if (shape.columns < 2 || shape.columns > max_columns || shape.rows < 2 || shape.rows > max_columns)
        return {StatusCode::out_of_range, "columns or rows of the set"};
    if (parts.empty()) return {StatusCode::out_of_range, "packs (at least one)"};
    std::uint64_t tiles = 0, end = sizeof(PackHeader);
    bool same_notes = true;
    for (at_fault = 0; at_fault < parts.size(); ++at_fault) {
        const SetPart& part = parts[at_fault];
        if (Status s = check_part(shape, parts[0], part); !s.ok()) return s;
        const PackHeader& p = part.pack->header;
        if (at_fault == 0) {
            h = p;
            h.voids = 0;
        }
        h.min_m = std::min(h.min_m, p.min_m);
        h.max_m = std::max(h.max_m, p.max_m);
        h.max_error_m = std::max(h.max_error_m, p.max_error_m);
        h.height_steps = std::max(h.height_steps, p.height_steps);
        h.voids += p.voids;
        same_notes = same_notes && p.notes_bytes == h.notes_bytes && p.notes_hash == h.notes_hash;
        tiles += std::uint64_t{p.tiles_x} * p.tiles_y;
        end += p.file_bytes;
    }
    const Tree whole = Tree::covering(static_cast<std::int32_t>(shape.columns), static_cast<std::int32_t>(shape.rows),
                                      static_cast<int>(h.tile_log2));
    h.columns = shape.columns;
    h.rows = shape.rows;
    h.tiles_x = static_cast<std::uint32_t>(whole.tiles_x);
    h.tiles_y = static_cast<std::uint32_t>(whole.tiles_y);
    const std::uint64_t all = std::uint64_t{h.tiles_x} * h.tiles_y;
    if (tiles > all) return {StatusCode::out_of_range, "packs (some lie over others)"};
    h.tiles_held = tiles == all ? 0 : static_cast<std::uint32_t>(tiles);
    h.features = features_of(h);
    for (const int axis : {0, 1}) h.crs_origin[axis] = origin_of(parts[0], axis);
    if (same_notes)
        h.notes_offset += sizeof(PackHeader); // the first part's
    else
        h.notes_offset = h.notes_hash = h.notes_bytes = 0;
    std::fill(std::begin(h.reserved), std::end(h.reserved), 0);
    if (Status s = check_ranges(h); !s.ok()) return s;
    h.directory_count = chunk_count(h);
    h.directory_offset = end; // and the corners, which come first
    return {};
}

// --- the corners, as a zstd frame of blocks that are not compressed

constexpr std::size_t frame_head = 9, block_head = 3, block_most = 1u << 17;

std::size_t frame_bytes(std::size_t raw) {
    return frame_head + raw + std::max<std::size_t>((raw + block_most - 1) / block_most, 1) * block_head;
}

// raw: where the frame's contents lie, behind it in the same memory.
void write_frame(const std::byte* raw, std::size_t size, std::byte* to) {
    const auto number = [&](std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) *to++ = static_cast<std::byte>(value >> 8 * i);
    };
    number(0xfd2fb528, 4);
    number(0xa0, 1); // one segment, four bytes of size
    number(size, 4);
    do {
        const std::size_t block = std::min(size, block_most);
        number(block << 3 | (block == size ? 1 : 0), static_cast<int>(block_head));
        std::memmove(to, raw, block);
        to += block;
        raw += block;
        size -= block;
    } while (size != 0);
}

// Where everything lies in the host's memory.
struct Layout {
    std::size_t header, corners, directory, places, raw, numbers, part_corners, end;
    std::size_t raw_bytes; // of the corners
};
Layout layout_of(std::span<const SetPart> parts, const PackHeader& h) {
    Layout l{};
    l.raw_bytes = chunk_raw_bytes(h, {ChunkKind::corners, 0, 0});
    BlockLayout block(0);
    l.header = block.place(1, sizeof(PackHeader));
    // One after the other, as in the file.
    l.corners = block.place(frame_bytes(l.raw_bytes) + directory_bytes(h), 1);
    l.directory = l.corners + frame_bytes(l.raw_bytes);
    l.places = l.directory + static_cast<std::size_t>(h.directory_count) * sizeof(ChunkEntry);
    l.raw = block.place(l.raw_bytes / sizeof(std::uint32_t), sizeof(std::uint32_t));
    l.numbers = block.place(std::uint64_t{h.tiles_x} * h.tiles_y, sizeof(std::uint32_t));
    std::size_t most = 0;
    for (const SetPart& part : parts)
        most = std::max(most, chunk_raw_bytes(part.pack->header, {ChunkKind::corners, 0, 0}));
    l.part_corners = block.place(most, 1);
    l.end = block.end();
    return l;
}

// Which number each place's tile has, no_index where there is none. False: two parts have the same tile.
bool number_tiles(std::span<const SetPart> parts, const PackHeader& h, std::uint32_t* numbers,
                  std::uint32_t& at_fault) {
    const std::size_t all = std::size_t{h.tiles_x} * h.tiles_y;
    std::fill_n(numbers, all, no_index);
    for (at_fault = 0; at_fault < parts.size(); ++at_fault) {
        const SetPart& part = parts[at_fault];
        for (std::uint32_t y = 0; y < part.pack->header.tiles_y; ++y) {
            std::uint32_t* const row = numbers + std::size_t{part.tile_y + y} * h.tiles_x + part.tile_x;
            for (std::uint32_t x = 0; x < part.pack->header.tiles_x; ++x) {
                if (row[x] != no_index) return false;
                row[x] = 0;
            }
        }
    }
    std::uint32_t next = 0;
    for (std::size_t place = 0; place < all; ++place)
        if (numbers[place] != no_index) numbers[place] = next++;
    return true;
}

// A part's bound counts heights on its own shift; on a coarser one it grows outwards.
PageBound rescaled(PageBound bound, std::uint32_t shift) {
    bound.low = static_cast<std::uint16_t>(bound.low >> shift);
    bound.high = static_cast<std::uint16_t>(bound.high >> shift);
    return bound;
}

void enter_chunks(const SetPart& part, std::uint64_t begins, const PackHeader& h, const std::uint32_t* numbers,
                  std::byte* directory) {
    const PackHeader& p = part.pack->header;
    const std::uint32_t shift = bound_shift(h) - bound_shift(p);
    for (std::uint64_t chunk = 0; chunk < p.directory_count; ++chunk) {
        ChunkId id = chunk_id(p, chunk);
        if (id.kind == ChunkKind::corners) continue;
        if (id.kind != ChunkKind::crs && id.kind != ChunkKind::layers)
            id.tile =
                numbers[std::size_t{part.tile_y + id.tile / p.tiles_x} * h.tiles_x + part.tile_x + id.tile % p.tiles_x];
        ChunkEntry entry = part.pack->entry(chunk);
        entry.offset += begins;
        if (id.kind == ChunkKind::geometry) entry.bound = rescaled(entry.bound, shift);
        std::memcpy(directory + chunk_index(h, id) * sizeof entry, &entry, sizeof entry);
    }
}

// Where a tile's corner k lies among the whole's, in a full terrain row by row, in a sparse one four a tile.
std::size_t corner_index(const PackHeader& h, const std::uint32_t* numbers, std::size_t x, std::size_t y,
                         std::size_t k) {
    if (h.tiles_held == 0) return (y + k / 2) * (std::size_t{h.tiles_x} + 1) + x + k % 2;
    return std::size_t{numbers[y * h.tiles_x + x]} * 4 + k;
}

// One part's corners to the whole's, which hold no_index where none is yet. False: tiles of an earlier part have other
// heights there, so that packs of different ground lie side by side.
bool place_corners(const SetPart& part, const PackHeader& h, const std::uint32_t* numbers, const std::byte* from,
                   std::uint32_t* to) {
    const PackHeader& p = part.pack->header;
    const auto agrees = [&](std::size_t cx, std::size_t cy, std::uint32_t corner) {
        for (std::size_t k = 0; k < 4; ++k) {                 // the tiles that have it as their corner k
            const std::size_t x = cx - k % 2, y = cy - k / 2; // beyond the first: huge
            if (x >= h.tiles_x || y >= h.tiles_y || numbers[y * h.tiles_x + x] == no_index) continue;
            const std::uint32_t placed = to[corner_index(h, numbers, x, y, k)];
            if (placed != no_index && placed != corner) return false;
        }
        return true;
    };
    for (std::size_t y = 0; y < p.tiles_y; ++y)
        for (std::size_t x = 0; x < p.tiles_x; ++x)
            for (std::size_t k = 0; k < 4; ++k) {
                std::uint32_t corner = 0;
                std::memcpy(&corner, from + ((y + k / 2) * (std::size_t{p.tiles_x} + 1) + x + k % 2) * sizeof corner,
                            sizeof corner);
                if (!agrees(part.tile_x + x + k % 2, part.tile_y + y + k / 2, corner)) return false;
                to[corner_index(h, numbers, part.tile_x + x, part.tile_y + y, k)] = corner;
            }
    return true;
}

} // namespace

std::size_t set_index_bytes(const SetShape& shape, std::span<const SetPart> parts) {
    PackHeader h{};
    std::uint32_t at_fault = 0;
    return plan(shape, parts, h, at_fault).ok() ? layout_of(parts, h).end : 0;
}

Status make_set_index(const SetShape& shape, std::span<const SetPart> parts, std::span<std::byte> memory,
                      SetIndex& index, std::uint32_t& at_fault) {
    PackHeader h{};
    if (Status s = plan(shape, parts, h, at_fault); !s.ok()) return s;
    const Layout l = layout_of(parts, h);
    at_fault = static_cast<std::uint32_t>(parts.size());
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    auto* const numbers = reinterpret_cast<std::uint32_t*>(at + l.numbers);
    if (!number_tiles(parts, h, numbers, at_fault))
        return {StatusCode::out_of_range, "tiles (an earlier pack of the set has some of them)"};
    std::uint64_t end = sizeof(PackHeader);
    auto* const corners_of_whole = reinterpret_cast<std::uint32_t*>(at + l.raw);
    std::fill_n(corners_of_whole, l.raw_bytes / sizeof(std::uint32_t), no_index);
    for (at_fault = 0; at_fault < parts.size(); ++at_fault) {
        const SetPart& part = parts[at_fault];
        const ChunkId id{ChunkKind::corners, 0, 0};
        const std::span raw{at + l.part_corners, chunk_raw_bytes(part.pack->header, id)};
        if (!decode_chunk(part.pack->entry(chunk_index(part.pack->header, id)), part.corners, raw).ok())
            return {StatusCode::corrupt, "corners"};
        if (!place_corners(part, h, numbers, raw.data(), corners_of_whole))
            return {StatusCode::wrong_pack, "corners where tiles meet"};
        enter_chunks(part, end, h, numbers, at + l.directory);
        end += part.pack->header.file_bytes;
    }
    at_fault = static_cast<std::uint32_t>(parts.size());
    write_frame(at + l.raw, l.raw_bytes, at + l.corners);
    const std::size_t stored = l.directory - l.corners;
    const ChunkEntry corners{end,
                             hash_of(at + l.corners, stored),
                             static_cast<std::uint32_t>(stored),
                             static_cast<std::uint32_t>(l.raw_bytes),
                             {}};
    std::memcpy(at + l.directory, &corners, sizeof corners);
    const std::size_t places = std::size_t{h.tiles_x} * h.tiles_y;
    for (std::size_t place = 0; h.tiles_held != 0 && place < places; ++place) {
        const auto value = static_cast<std::uint32_t>(place);
        if (numbers[place] != no_index) std::memcpy(at + l.places + std::size_t{numbers[place]} * 4, &value, 4);
    }
    h.directory_offset = end + stored;
    h.file_bytes = h.directory_offset + directory_bytes(h);
    h.directory_hash = hash_of(at + l.directory, static_cast<std::size_t>(directory_bytes(h)));
    h.header_hash = hash_of(&h, offsetof(PackHeader, header_hash));
    std::memcpy(at + l.header, &h, sizeof h);
    const std::size_t tail = stored + static_cast<std::size_t>(directory_bytes(h));
    index = {{at + l.header, sizeof h},
             {at + l.corners, tail},
             {at + l.corners, stored},
             {at + l.directory, tail - stored},
             end,
             h.file_bytes};
    return {};
}

std::uint32_t set_part_at(std::span<const SetPart> parts, std::uint64_t offset, std::uint64_t& in_part) {
    std::uint64_t begins = sizeof(PackHeader);
    for (std::uint32_t part = 0; offset >= begins && part < parts.size(); ++part) {
        const std::uint64_t bytes = parts[part].pack == nullptr ? 0 : parts[part].pack->header.file_bytes;
        if (offset - begins < bytes) {
            in_part = offset - begins;
            return part;
        }
        begins += bytes;
    }
    return static_cast<std::uint32_t>(parts.size());
}

} // namespace fjell
