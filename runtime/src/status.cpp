#include "fjell/status.h"

namespace fjell {

const char* message(StatusCode code) {
    switch (code) {
    case StatusCode::ok: return "ok";
    case StatusCode::truncated: return "the pack ends too early; copy or bake it again";
    case StatusCode::not_a_pack: return "this is not a Fjell pack; bake the height field with fjell-bake first";
    case StatusCode::wrong_version:
        return "the pack was written by another version of fjell-bake; bake it again with this one: "
               "fjell-bake HEIGHTS -o PACK";
    case StatusCode::wrong_layout:
        return "the pack's record layout is not this build's; bake it again on this kind of machine";
    case StatusCode::corrupt: return "the pack is damaged here; copy or bake it again";
    case StatusCode::out_of_range: return "the value is outside its allowed range; choose another";
    case StatusCode::memory_too_small:
        return "the memory is smaller than the matching *_bytes() function says; pass a larger one";
    case StatusCode::budget_too_small: return "the budget cannot hold the coarsest mesh; raise the field";
    case StatusCode::out_of_slots: return "every page slot is taken; unload a page, or raise TerrainBudget::page_slots";
    case StatusCode::coarser_page_first:
        return "a page of a coarser step over this one is not loaded; load that one first";
    case StatusCode::not_supported: return "this method cannot read such a pack";
    case StatusCode::unreadable:
        return "the file could not be read there; check the disk, then ask again (stream_retry_failed)";
    case StatusCode::invalid_handle: return "the handle is empty or its object is destroyed; create it first";
    case StatusCode::wrong_pack: return "the terrain was made from another pack; pass that one";
    case StatusCode::wrong_terrain: return "the cut is of another terrain; pass a cut of this one";
    }
    return "unknown status";
}

} // namespace fjell
