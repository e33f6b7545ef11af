#include <algorithm>

#include "recursive/emit.h"
#include "recursive/pass.h"

namespace fjell {

namespace {

void clear_unused(RecursiveState& s, PassResult& result) {
    if (result.clearings) return; // what is left is all of this pass
    ++result.clearings;
    for (std::uint32_t slot = s.budget.vertices; slot-- > 0;) {
        if (s.owners[slot] == no_index || is_selected(s, s.owners[slot])) continue;
        s.slots[s.owners[slot]] = no_index;
        s.owners[slot] = no_index;
        s.free_slots[s.free_count++] = slot;
    }
}

} // namespace

std::uint32_t insert_vertex(RecursiveState& s, std::uint32_t index, const MeshVertex& vertex, bool hole,
                            PassResult& result) {
    if (s.free_count == 0) clear_unused(s, result);
    if (s.free_count == 0) return no_index;
    const std::uint32_t slot = s.free_slots[--s.free_count];
    s.vertices[slot] = vertex;
    s.owners[slot] = index;
    s.dirty_begin = std::min(s.dirty_begin, slot);
    s.dirty_end = std::max(s.dirty_end, slot + 1);
    ++result.written;
    return s.slots[index] = slot | (hole ? hole_flag : 0);
}

} // namespace fjell
