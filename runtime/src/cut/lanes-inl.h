// What vertices' records say, for as many lanes as a target has: for files that Highway compiles once a target.
#if defined(FJELL_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FJELL_LANES_INL_H
#undef FJELL_LANES_INL_H
#else
#define FJELL_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "cut/evaluate.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, group_lanes>;
using I = hn::RebindToSigned<F>;

template <typename M>
HWY_INLINE std::uint32_t bits_of(F d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8;
}

// Loaded: g++ 12 makes Iota() of stores one by one, and the load after them waits for all.
constexpr std::int32_t lane_numbers[group_lanes] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
constexpr std::int32_t lane_bits[group_lanes] = {1,      1 << 1, 1 << 2,  1 << 3,  1 << 4,  1 << 5,  1 << 6,  1 << 7,
                                                 1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15};

template <typename VI, typename VF>
HWY_INLINE void read_record(const Criterion& c, VI record, std::int32_t base, float unit_m, VI& error_code,
                            VF& height_m, VF& error_m, VF& radius_m) {
    const F d;
    const I di;
    const auto height = hn::Add(hn::And(record, hn::Set(di, 0xffff)), hn::Set(di, base));
    height_m = hn::Add(hn::Set(d, c.base_m), hn::Mul(hn::ConvertTo(d, height), hn::Set(d, c.quantum_m)));
    error_code = hn::And(hn::ShiftRight<16>(record), hn::Set(di, 0xff));
    error_m = hn::GatherIndex(d, c.error_m, error_code);
    const auto radius_code = hn::And(hn::ShiftRight<24>(record), hn::Set(di, 0x7f));
    radius_m = hn::Mul(hn::Set(d, unit_m), hn::GatherIndex(d, c.radius_factor, radius_code));
}

// Lanes of picked vertices, from `first` on.
template <typename VI, typename VF>
HWY_INLINE void read_picked(const Criterion& c, const PickedLanes& b, std::uint32_t first, VI& x, VI& y, VI& record,
                            VI& error_code, VF& height_m, VF& error_m, VF& radius_m) {
    const I di;
    auto picked = hn::Zero(di), unused = picked;
    hn::LoadInterleaved2(di, reinterpret_cast<const std::int32_t*>(b.picked + first), picked, unused);
    const auto byte = hn::Set(di, 0xff);
    x = hn::Min(hn::Add(hn::Set(di, b.x0), hn::ShiftLeftSame(hn::And(hn::ShiftRight<16>(picked), byte), b.z)),
                hn::Set(di, c.last_x));
    y = hn::Min(hn::Add(hn::Set(di, b.y0), hn::ShiftLeftSame(hn::And(hn::ShiftRight<24>(picked), byte), b.z)),
                hn::Set(di, c.last_y));
    record =
        hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(b.records), hn::And(picked, hn::Set(di, 0xffff)));
    read_record(c, record, b.base, b.unit_m, error_code, height_m, error_m, radius_m);
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
