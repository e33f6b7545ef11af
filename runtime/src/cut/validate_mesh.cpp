#include <algorithm>
#include <bit>

#include "cut/mesh.h"
#include "cut/validate_parts.h"

namespace fjell {

namespace {

Violation check_triangle(const CutState& s, std::uint32_t tile, std::uint32_t slot) {
    const std::uint32_t* const t = s.mesh.indices + std::size_t{slot} * 3;
    if (t[0] >= s.mesh.fresh_vertex || t[1] >= s.mesh.fresh_vertex || t[2] >= s.mesh.fresh_vertex)
        return {"a triangle's corner was never taken"};
    const std::uint32_t* const of = s.mesh.triangle_of + std::size_t{t[0]} * 4;
    if (std::count(of, of + 4, slot) != 1) return {"a triangle's right angle does not know it"};
    if (s.mesh.some_hidden && is_hidden(s.mesh, {t[0], t[1], t[2]}) != (tile == hidden_tile(s.mesh)))
        return {"a triangle is hidden wrongly"};
    return {};
}

Violation check_tile(const CutState& s, std::uint32_t tile, Tally& segments) {
    const TileList& list = s.mesh.tiles[tile];
    std::uint32_t count = list.in_last, total = 0, found = 0;
    for (std::uint32_t segment = list.last_segment; segment != no_index; segment = s.mesh.segment_below[segment]) {
        if (segment >= s.mesh.segment_count || ++found > s.mesh.segment_count)
            return {"a tile's segments go elsewhere"};
        if (s.mesh.segment_tile[segment] != tile) return {"a segment does not know its tile"};
        if (count == 0 || count > 1u << s.mesh.segment_log2) return {"an empty segment is kept"};
        segments.add(segment);
        for (std::uint32_t i = 0; i < count; ++i)
            if (const Violation wrong = check_triangle(s, tile, (segment << s.mesh.segment_log2) + i)) return wrong;
        total += count;
        count = 1u << s.mesh.segment_log2;
    }
    if (found != list.segments) return {"a tile counts its segments wrongly"};
    return total == list.total ? Violation{} : Violation{"a tile counts its triangles wrongly"};
}

Violation check_triangles(const CutState& s) {
    Tally segments, all;
    std::uint32_t listed = 0, made = 0;
    for (std::uint32_t tile = 0; tile <= s.mesh.tile_count; ++tile) {
        if (const Violation wrong = check_tile(s, tile, segments)) return wrong;
        listed += s.mesh.tiles[tile].total;
    }
    // What the bulk pass builds beside.
    if (s.bulk.phase == BulkPhase::triangles || s.bulk.phase == BulkPhase::built) {
        for (std::uint32_t tile = 0; tile <= s.mesh.tile_count; ++tile) {
            const BulkTile& list = s.bulk.tiles[tile];
            const std::uint32_t planned = (list.planned + (1u << s.mesh.segment_log2) - 1) >> s.mesh.segment_log2;
            for (std::uint32_t n = list.segments; list.reserved != no_index && n < planned; ++n)
                segments.add(s.mesh.free_segments[list.reserved - 1 - (n - list.segments)]);
            for (std::uint32_t segment = list.last_segment; segment != no_index;
                 segment = s.mesh.segment_below[segment])
                segments.add(segment);
        }
    }
    if (s.mesh.free_segment_count > s.mesh.segment_count) return {"more segments are free than there are"};
    for (std::uint32_t i = 0; i < s.mesh.free_segment_count; ++i) segments.add(s.mesh.free_segments[i]);
    all.add_range(0, s.mesh.segment_count);
    if (!(segments == all)) return {"a segment is used or free twice, or lost"};
    if (s.bulk.phase >= BulkPhase::releasing) return {}; // some of what was drawn before is still named
    const auto count = [&](std::uint32_t vertex_slot) {
        for (std::uint32_t d = 0; d < 4; ++d) made += s.mesh.triangle_of[std::size_t{vertex_slot} * 4 + d] != no_index;
    };
    for (std::uint32_t corner = 0; corner < s.mesh.corner_count; ++corner) count(corner);
    for (std::uint32_t number = 0; number < s.pages.group_count; ++number)
        for (std::uint32_t lanes = s.pages.groups[number].active; lanes != 0; lanes &= lanes - 1)
            count(s.pages.vertex_slot[number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes))]);
    return made == listed ? Violation{} : Violation{"a triangle is made that no tile has"};
}

// The words listed are those that hold any, each once. total: of the bits' words.
Violation check_words(const DirtyBits& written, std::size_t total) {
    Tally listed, held;
    std::uint32_t count = 0;
    for (std::size_t word = 0; word < total; ++word)
        if (written.bits[word] != 0) held.add(word), ++count;
    if (count != written.word_count) return {"words of written slots do not add up"};
    for (std::uint32_t i = 0; i < written.word_count; ++i) listed.add(written.words[i]);
    return listed == held ? Violation{} : Violation{"a word of written slots is listed twice, or not at all"};
}

Violation check_written(const CutState& s) {
    const std::size_t vertex_words = s.mesh.capacity / 64 + 1;
    const std::size_t triangle_words = (std::size_t{s.mesh.segment_count} << s.mesh.segment_log2) / 64 + 1;
    for (const DirtyBits* written : {&s.mesh.dirty_vertices, &s.mesh.untaken_vertices})
        if (const Violation wrong = check_words(*written, vertex_words)) return wrong;
    for (const DirtyBits* written : {&s.mesh.dirty_triangles, &s.mesh.untaken_triangles})
        if (const Violation wrong = check_words(*written, triangle_words)) return wrong;
    for (const DirtyBits* written : {&s.mesh.dirty_vertices, &s.mesh.dirty_triangles}) {
        std::uint32_t slots = 0;
        for (std::uint32_t i = 0; i < written->word_count; ++i)
            slots += static_cast<std::uint32_t>(std::popcount(written->bits[written->words[i]]));
        if (slots != written->slots) return {"written slots are counted wrongly"};
    }
    return {};
}

} // namespace

Violation validate_mesh(const CutState& s) {
    if (const Violation wrong = check_triangles(s)) return wrong;
    return check_written(s);
}

} // namespace fjell
