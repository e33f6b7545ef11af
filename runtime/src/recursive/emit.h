// Where the recursion puts its indices: lists, and one strip a tile (tStripAppend, thesis figure 5.7).
#pragma once

#include <cstdint>

#include "fjell/mesh.h"
#include "recursive/state.h"
#include "shared/compiler.h"

namespace fjell {

// A slot of the vertex buffer whose vertex is in a hole: no triangle of it is drawn.
inline constexpr std::uint32_t hole_flag = 0x80000000;

class Emitter {
public:
    explicit Emitter(const RecursiveState& state)
        : next_(state.indices), last_triangle_(state.indices + state.budget.indices - 3), begin_(state.indices),
          end_(state.indices + state.budget.indices), holes_(state.terrain->has_voids()) {}

    [[nodiscard]] std::uint32_t cursor() const { return static_cast<std::uint32_t>(next_ - begin_); }
    [[nodiscard]] bool full() const { return full_; }

    // False when there is no room for it.
    FJELL_ALWAYS_INLINE bool triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        std::uint32_t* const out = next_;
        if (out > last_triangle_) return false;
        out[0] = a;
        out[1] = b;
        out[2] = c;
        next_ = out + 3;
        return true;
    }

    void begin_strip(std::uint32_t first) {
        strip_begin_ = next_;
        taken_ = 0;
        in_step_ = false;
        push(first);
        push(first);
        last_parity_ = 0;
    }

    // tStripAppend. parity: of the vertex' level; parities alternate along the strip, or the older vertex is repeated.
    FJELL_ALWAYS_INLINE void append(std::uint32_t slot, int parity) {
        if (slot == newest_ || slot == older_) return;
        if (holes_) return append_around_holes(slot, parity);
        // One of two, without a branch that could not be predicted: the older one is overwritten, or stays.
        const bool repeat = parity == last_parity_;
        if (end_ - next_ < 1 + repeat) {
            full_ = true;
            return;
        }
        *next_ = older_;
        next_ += repeat;
        *next_++ = slot;
        older_ = repeat ? older_ : newest_;
        newest_ = slot;
        last_parity_ = parity;
    }

    // One more vertex of the thesis' strip.
    void push(std::uint32_t slot) {
        if (holes_)
            push_around_holes(slot);
        else
            put(slot);
        older_ = newest_;
        newest_ = slot;
        ++taken_;
    }

private:
    void append_around_holes(std::uint32_t slot, int parity) {
        if (parity == last_parity_) push(older_);
        push(slot);
        last_parity_ = parity;
    }

    void put(std::uint32_t slot) {
        if (next_ == end_) {
            full_ = true;
            return;
        }
        *next_++ = slot & ~hole_flag;
    }

    // The strip with holes is the thesis' strip less some of its triangles. While nothing is left out the two run in
    // step; after a gap the next drawn triangle is led up to by degenerate ones, at a place of the same parity, so that
    // it keeps its winding.
    void push_around_holes(std::uint32_t slot) {
        if (taken_ < 2) return;
        const bool degenerate = slot == newest_ || slot == older_ || newest_ == older_;
        const bool hole = ((slot | newest_ | older_) & hole_flag) != 0;
        if (degenerate) {
            if (in_step_) put(slot);
            return;
        }
        if (hole) {
            in_step_ = false;
            return;
        }
        if (!in_step_) {
            if (next_ != strip_begin_) put(next_[-1]);
            put(older_);
            put(older_);
            // older_ now lies at next_ - 1 and must lie at a place of the parity of taken_ - 2.
            if (((next_ - 1 - strip_begin_) & 1) != (taken_ & 1)) put(older_);
            put(newest_);
            in_step_ = true;
        }
        put(slot);
    }

    std::uint32_t* next_;
    const std::uint32_t* const last_triangle_; // where the last one that fits begins
    const std::uint32_t *const begin_, *const end_;
    const bool holes_;
    bool full_ = false;
    int last_parity_ = 0;
    // The last two vertices of the thesis' strip, and how many there were.
    std::uint32_t older_ = 0, newest_ = 0, taken_ = 0;
    std::uint32_t* strip_begin_ = nullptr;
    bool in_step_ = false;
};

} // namespace fjell
