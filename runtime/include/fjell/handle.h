// What a host holds of a terrain, a cut, a stream or a recursive method. The object itself lies in the block of memory
// that the host gave create_...().
//
// A handle is a small value: copy, move and drop it as you like. create_...() sets it, destroy_...() ends the object
// and leaves the block to the host. Afterwards every handle to that object is refused, also when the block holds
// another object by then: a call returns invalid_handle, or an empty answer where it returns a value. So is a handle
// that was never set.
// Memory: a handle is checked in its block. A block must not move while it holds an object. Destroy the object before
// you free its block, and use none of its handles once the block is freed: that cannot be noticed.
// Thread: any, while no other thread creates or destroys in the same block.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// What Terrain, LiveCut, Stream and RecursiveMethod are. Empty until create_...() has set it.
template <typename Object>
class Handle {
public:
    friend constexpr bool operator==(const Handle&, const Handle&) = default;

private:
    friend struct HandleAccess; // the library's
    Object* object_ = nullptr;
    std::uint64_t identity_ = 0;
};

} // namespace fjell
FJELL_API_END
