// A handle: what a host keeps of a terrain, a cut, a stream or a recursive method. The object itself is in the block of
// memory that the host gave create_...().
//
// A handle is a small value that can be copied, moved and dropped. create_...() sets it. destroy_...() ends the object
// and leaves the block to the host. Afterwards every copy of the handle is refused, even if the block holds another
// object by then. A call with a refused handle returns invalid_handle, or an empty value. A handle that was never set
// is refused too.
// Memory: a handle is checked in its block. So a block must not move while it holds an object. Destroy the object
// before you free its block, and do not use its handles afterwards; this fault cannot be detected.
// Thread: any, while no other thread creates or destroys an object in the same block.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// The base of Terrain, LiveCut, Stream and RecursiveMethod. Empty until create_...() has set it.
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
