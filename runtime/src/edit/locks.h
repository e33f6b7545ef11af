// Locks of stamps (StampShape::lock): the error that is allowed at each sample, and what that asks of vertices. Baked
// ones (baker/errors/lock_errors.h) are in the pack's codes, and ask for the same.
//
// A vertex whose error is above what is allowed anywhere under the square around its diamond gets the code of its
// level's locks (ErrorScale::always()). Nesting hands it up. The square holds more than the diamond, so triangles whose
// corners have changed need not be told from others.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// What is allowed in these samples at least, as a code; no_lock: all of it.
[[nodiscard]] std::uint8_t least_allowed(const EditsData& e, const Rect& samples);

struct LockAt {
    std::uint32_t allowed, always; // codes
    // What a vertex' code becomes whose triangles are off by this one.
    [[nodiscard]] std::uint32_t raised(std::uint32_t code) const {
        return code > allowed ? std::max(code, always) : code;
    }
};
// O(1) up to steps of 32 samples; above, O(blocks with locks).
[[nodiscard]] LockAt lock_at(const EditsData& e, SampleIndex v);

// The same for all vertices of a window, from fine to coarse.
class WindowLocks {
public:
    WindowLocks(const EditsData& e, Window& window);
    [[nodiscard]] bool any() const { return any_; }
    // Of steps of 2^z from here on; larger than the last one.
    void begin_step(int z);
    // Of a vertex of that step, whose square lies in the window.
    [[nodiscard]] LockAt at(SampleIndex v, std::uint32_t always) const {
        return {window_.allowed[static_cast<std::size_t>(v.row - step_ - window_.rect.y0) * window_side +
                                static_cast<std::size_t>(v.column - step_ - window_.rect.x0)],
                always};
    }

private:
    void widen(std::int32_t by);
    Window& window_;
    std::int32_t step_ = 0;
    bool any_ = false;
};

// Is there room for what a stamp may lock?
[[nodiscard]] bool has_room_for(const EditsData& e, const Stamp& stamp);
// Of these samples. Returns those for which another error is allowed than before.
[[nodiscard]] Rect lock_samples(EditsData& e, const Stamp& stamp, const Rect& samples);

} // namespace fjell::edit
