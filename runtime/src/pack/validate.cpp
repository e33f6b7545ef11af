#include "validate.h"

#include "pack/memory.h"
#include "shared/terrain_data.h"

namespace fjell {

namespace {

Violation check_table(const TerrainData& t) {
    std::uint32_t missing = 0;
    for (std::uint32_t page = 0; page < t.page_count(); ++page) {
        const PageEntry& entry = t.page_table[page];
        if (entry.slot == no_index) {
            ++missing;
            continue;
        }
        if (entry.slot >= t.slot_count) return {"a page lies in a slot that there is not"};
        if (t.slot_page[entry.slot] != page) return {"a page's slot holds another page"};
        if (t.slot_loads[entry.slot] == 0) return {"a page lies in a slot that nothing was loaded into"};
        if (entry.base < -2 * max_height_steps || entry.base > max_height_steps)
            return {"a page's base is off the height scale"};
    }
    return missing == t.pages_missing ? Violation{} : Violation{"missing pages are counted wrongly"};
}

// A slot is free, once, or holds a page.
Violation check_slots(const TerrainData& t) {
    Tally free, empty;
    std::uint32_t count = 0;
    for (std::uint32_t slot = 0; slot < t.slot_count; ++slot) {
        const std::uint32_t page = t.slot_page[slot];
        if (page == no_index)
            empty.add(slot), ++count;
        else if (page >= t.page_count() || t.page_table[page].slot != slot)
            return {"a slot's page lies elsewhere"};
    }
    if (t.memory->free_count != count) return {"free slots do not add up"};
    for (std::uint32_t i = 0; i < count; ++i) free.add(t.memory->free_slots[i]);
    return free == empty ? Violation{} : Violation{"a slot is free twice, or used and free"};
}

} // namespace

Violation validate_terrain(const TerrainData& t) {
    if (const Violation wrong = check_table(t)) return wrong;
    if (const Violation wrong = check_slots(t)) return wrong;
    for (std::uint32_t i = 0; i < change_log && i < t.changes; ++i)
        if (t.changed_slots[i] >= t.slot_count) return {"a slot has changed that there is not"};
    return {};
}

} // namespace fjell
