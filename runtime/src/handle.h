// What stands behind handles: the head of every block, and how a handle is checked against it.
#pragma once

#include <cassert>
#include <cstdint>

#include "fjell/handle.h"

namespace fjell {

inline constexpr std::uint64_t block_magic = 0x314b'4c42'4c4a'4621; // of a block that holds an object

// First in each object, so that it is found whatever the object is.
struct BlockHead {
    std::uint64_t magic = 0;
    std::uint64_t identity = 0; // of this object: no other one of the process has it
};

// Never 0. Any thread.
[[nodiscard]] std::uint64_t next_identity();

struct HandleAccess {
    // The object, or nullptr for a handle that is refused.
    template <typename Object>
    [[nodiscard]] static Object* find(const Handle<Object>& handle) {
        Object* const object = handle.object_;
        if (object == nullptr || object->head.magic != block_magic || object->head.identity != handle.identity_)
            return nullptr;
        return object;
    }
    // The object is complete from now on.
    template <typename Object>
    static void begin(Object& object, Handle<Object>& handle) {
        object.head = {block_magic, next_identity()};
        handle.object_ = &object;
        handle.identity_ = object.head.identity;
    }
    template <typename Object>
    static bool end(const Handle<Object>& handle) {
        Object* const object = find(handle);
        if (object != nullptr) object->head = {};
        return object != nullptr;
    }
};

template <typename Object>
[[nodiscard]] Object* find(const Handle<Object>& handle) {
    return HandleAccess::find(handle);
}
// For our own programs and tests, which know that it is there.
template <typename Object>
[[nodiscard]] Object& data_of(const Handle<Object>& handle) {
    Object* const object = find(handle);
    assert(object != nullptr);
    return *object;
}

} // namespace fjell
