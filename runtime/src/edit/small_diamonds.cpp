// Lanes are diamonds: each takes the same way through its samples, whatever the ground. Highway compiles this for each
// instruction set and picks one at run time. Whole numbers, so that all give the same.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "edit/small_diamonds.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <cstddef>
#include <cstdlib>

#include "edit/small_diamonds.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::edit::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

static_assert(sizeof(Cell) == 2 * sizeof(std::int32_t) && offsetof(Cell, steps) == 0, "lanes gather every other word");

// Diamonds of one row, as many as D has lanes.
template <typename D>
class Diamonds {
public:
    using V = hn::Vec<D>;
    HWY_INLINE Diamonds(const DiamondRow& row, std::int32_t lane)
        : words_(reinterpret_cast<const std::int32_t*>(row.first)), s_(1 << row.z), shift_(row.z + 1) {
        std::int32_t at[diamond_lanes], sign[diamond_lanes];
        for (std::int32_t k = 0; k < static_cast<std::int32_t>(hn::Lanes(D())); ++k) {
            const std::int32_t n = lane + k < row.count ? lane + k : row.count - 1;
            at[k] = 2 * (n << shift_);
            sign[k] = row.first_from_sw != (row.alternates && (n & 1) != 0) ? -1 : 1;
        }
        hn::StoreU(hn::LoadU(D(), at), D(), at_);
        hn::StoreU(hn::LoadU(D(), sign), D(), sign_);
    }

    HWY_INLINE V side_x() const {
        const D d;
        const V own = h(0, 0), west = hn::Sub(h(-s_, 0), own), east = hn::Sub(h(s_, 0), own), gx = hn::Sub(east, west),
                middle = hn::Add(west, east), base = hn::Add(times_2s(own), times_s(middle));
        V worst = hn::Zero(d);
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            const std::int32_t far = std::abs(dy);
            const V apex = hn::Sub(h(0, dy < 0 ? -s_ : s_), own), rise = hn::Sub(hn::Add(apex, apex), middle);
            V plane = hn::Add(base, hn::Add(times(rise, far), times(gx, far - s_)));
            for (std::int32_t dx = far - s_; dx <= s_ - far; ++dx, plane = hn::Add(plane, gx))
                worst = see(worst, dx, dy, plane);
        }
        return worst;
    }
    HWY_INLINE V side_y() const {
        const D d;
        const V own = h(0, 0), north = hn::Sub(h(0, -s_), own), south = hn::Sub(h(0, s_), own),
                gy = hn::Sub(south, north), middle = hn::Add(north, south),
                base = hn::Add(times_2s(own), times_s(middle));
        const V to_west = hn::Sub(times_2(hn::Sub(h(-s_, 0), own)), middle),
                to_east = hn::Sub(times_2(hn::Sub(h(s_, 0), own)), middle);
        V worst = hn::Zero(d);
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            const std::int32_t half = s_ - std::abs(dy);
            V plane = hn::Add(base, hn::Add(times(gy, dy), times(to_west, half)));
            for (std::int32_t dx = -half; dx < 0; ++dx, plane = hn::Sub(plane, to_west))
                worst = see(worst, dx, dy, plane);
            for (std::int32_t dx = 0; dx <= half; ++dx, plane = hn::Add(plane, to_east))
                worst = see(worst, dx, dy, plane);
        }
        return worst;
    }
    // Where the hypotenuse runs from south-west to north-east all is as in the other ones turned upside down: sign.
    HWY_INLINE V centre() const {
        const D d;
        const V own = h(0, 0), sign = hn::LoadU(d, sign_);
        const auto from_sw = hn::Lt(sign, hn::Zero(d));
        const V nw = hn::Sub(h(-s_, -s_), own), ne = hn::Sub(h(s_, -s_), own), sw = hn::Sub(h(-s_, s_), own),
                se = hn::Sub(h(s_, s_), own);
        const V north = hn::IfThenElse(from_sw, ne, nw), south = hn::IfThenElse(from_sw, sw, se);
        const V west = hn::IfThenElse(from_sw, nw, sw), east = hn::IfThenElse(from_sw, se, ne);
        const V base = hn::Add(times_2s(own), times_s(hn::Add(north, south))), gy = hn::Sub(south, north);
        // Across the west triangle's row heights change as along its leg, and so across the east one's.
        const V in_west = hn::IfThenElse(from_sw, hn::Sub(north, west), hn::Sub(south, west)),
                in_east = hn::IfThenElse(from_sw, hn::Sub(east, south), hn::Sub(east, north));
        V worst = hn::Zero(d);
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            const V split = hn::Mul(sign, hn::Set(d, dy)); // where the triangles meet
            const V at_split = hn::Add(base, times(gy, dy));
            V plane = hn::Sub(at_split, hn::Mul(in_west, hn::Add(split, hn::Set(d, s_))));
            for (std::int32_t dx = -s_; dx <= s_; ++dx) {
                worst = see(worst, dx, dy, plane);
                plane = hn::Add(plane, hn::IfThenElse(hn::Lt(hn::Set(d, dx), split), in_west, in_east));
            }
        }
        return worst;
    }

private:
    HWY_INLINE V h(std::int32_t dx, std::int32_t dy) const {
        return hn::GatherIndex(D(), words_ + 2 * (dy * window_side + dx), hn::LoadU(D(), at_));
    }
    HWY_INLINE V times(V v, std::int32_t by) const { return hn::Mul(v, hn::Set(D(), by)); }
    HWY_INLINE V times_2(V v) const { return hn::Add(v, v); }
    HWY_INLINE V times_s(V v) const { return hn::ShiftLeftSame(v, shift_ - 1); }
    HWY_INLINE V times_2s(V v) const { return hn::ShiftLeftSame(v, shift_); }
    HWY_INLINE V see(V worst, std::int32_t dx, std::int32_t dy, V plane) const {
        return hn::Max(worst, hn::Abs(hn::Sub(times_2s(h(dx, dy)), plane)));
    }
    const std::int32_t* words_;
    std::int32_t s_;
    int shift_;
    std::int32_t at_[diamond_lanes], sign_[diamond_lanes]; // vectors whose length nobody knows cannot be members
};

HWY_ATTR void worst_of_row(const DiamondRow& row, std::int32_t (&worst)[diamond_lanes]) {
    const hn::CappedTag<std::int32_t, diamond_lanes> d;
    for (std::int32_t lane = 0; lane < row.count; lane += static_cast<std::int32_t>(hn::Lanes(d))) {
        const Diamonds<decltype(d)> diamonds(row, lane);
        const auto found = row.kind == VertexKind::side_x   ? diamonds.side_x()
                           : row.kind == VertexKind::side_y ? diamonds.side_y()
                                                            : diamonds.centre();
        hn::StoreU(found, d, worst + lane);
    }
}

} // namespace fjell::edit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fjell::edit {

HWY_EXPORT(worst_of_row);

void worst_under(const DiamondRow& row, std::int32_t (&worst)[diamond_lanes]) {
    HWY_DYNAMIC_DISPATCH(worst_of_row)(row, worst);
}
void worst_under_scalar(const DiamondRow& row, std::int32_t (&worst)[diamond_lanes]) {
    HWY_STATIC_DISPATCH(worst_of_row)(row, worst);
}

} // namespace fjell::edit
#endif
