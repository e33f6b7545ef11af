// Records of vertices, as many lanes at a time as the machine has: the decision (view/decision-inl.h) of each, and
// where the bulk pass writes them. Highway compiles this for each instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/evaluate.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "cut/evaluate.h"
#include "shared/compiler.h"
#include "shared/record.h"

// What the targets share.
#ifndef FJELL_EVALUATE_ONCE
#define FJELL_EVALUATE_ONCE
namespace fjell {
namespace {

// Loaded: g++ 12 makes Iota() of stores one by one, and the load after them waits for all.
constexpr std::int32_t lane_numbers[group_lanes] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
constexpr std::int32_t lane_bits[group_lanes] = {1,      1 << 1, 1 << 2,  1 << 3,  1 << 4,  1 << 5,  1 << 6,  1 << 7,
                                                 1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15};

// Of each set of eight lanes, a bit each, its lanes, the lowest first.
[[maybe_unused]] constexpr auto lane_sets = [] {
    std::array<std::array<std::uint8_t, 8>, 256> sets{};
    for (std::uint32_t bits = 0; bits < 256; ++bits)
        for (std::uint8_t lane = 0, n = 0; lane < 8; ++lane)
            if (bits >> lane & 1) sets[bits][n++] = lane;
    return sets;
}();

} // namespace
} // namespace fjell
#endif

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using hn::Abs;
using hn::Add;
using hn::Lt;
using hn::Max;
using hn::Mul;
using hn::Or;
using hn::Set;
using hn::Sub;
#include "view/decision-inl.h"

using F = hn::CappedTag<float, group_lanes>;
using I = hn::RebindToSigned<F>;
template <typename D>
using Ints = hn::RebindToSigned<D>;

template <typename D, typename M>
HWY_INLINE std::uint32_t bits_of(D d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8;
}
// The lanes whose bits are set.
template <typename D>
HWY_INLINE hn::Mask<D> lanes_of_bits(D d, std::uint32_t bits) {
    const Ints<D> di;
    const auto set = hn::And(hn::LoadU(di, lane_bits), hn::Set(di, static_cast<std::int32_t>(bits & 0xffff)));
    return hn::RebindMask(d, hn::Ne(set, hn::Zero(di)));
}

// Through references, because vectors whose length nobody knows cannot be members.
template <typename D, typename VI, typename VF>
HWY_INLINE void read_record(D d, const Criterion& c, VI record, std::int32_t base, float unit_m, VI& error_code,
                            VF& height_m, VF& error_m, VF& radius_m) {
    const Ints<D> di;
    const auto height = hn::Add(hn::And(record, hn::Set(di, 0xffff)), hn::Set(di, base));
    height_m = hn::Add(hn::Set(d, c.base_m), hn::Mul(hn::ConvertTo(d, height), hn::Set(d, c.quantum_m)));
    error_code = hn::And(hn::ShiftRight<16>(record), hn::Set(di, 0xff));
    error_m = hn::GatherIndex(d, c.error_m, error_code);
    const auto radius_code = hn::And(hn::ShiftRight<24>(record), hn::Set(di, 0x7f));
    radius_m = hn::Mul(hn::Set(d, unit_m), hn::GatherIndex(d, c.radius_factor, radius_code));
}

// Lanes of a group, from `first` on: where they stand, and what their records say.
template <typename D, typename VI, typename VF>
HWY_INLINE void read_lanes(D d, const Criterion& c, const LaneGroup& b, std::uint32_t first, VF& x_m, VF& y_m, VF& z_m,
                           VI& error_code, VF& error_m, VF& radius_m) {
    const Ints<D> di;
    const auto number = hn::LoadU(di, lane_numbers + first);
    const auto x = hn::Min(hn::Add(hn::Set(di, b.x0), hn::Mul(number, hn::Set(di, b.dx))), hn::Set(di, c.last_x));
    const auto y = hn::Min(hn::Add(hn::Set(di, b.y0), hn::Mul(number, hn::Set(di, b.dy))), hn::Set(di, c.last_y));
    x_m = hn::Mul(hn::ConvertTo(d, x), hn::Set(d, c.spacing_x_m));
    z_m = hn::Mul(hn::ConvertTo(d, y), hn::Set(d, c.spacing_z_m));
    const auto record = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(b.records + first));
    read_record(d, c, record, b.base, b.unit_m, error_code, y_m, error_m, radius_m);
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
    read_record(F(), c, record, b.base, b.unit_m, error_code, height_m, error_m, radius_m);
}

// Margins of all views, and what they decide.
template <typename D, typename VF, typename M>
HWY_INLINE void decide(D d, const Criterion& c, VF px, VF py, VF pz, VF error, VF radius, VF& reach_margin,
                       VF& keep_margin, VF& span, M& is_wanted, M& is_kept) {
    reach_margin = keep_margin = hn::Set(d, -3.4e38f);
    span = hn::Zero(d);
    is_wanted = is_kept = hn::Lt(span, span); // none
    for (std::uint32_t v = 0; v < c.views; ++v) {
        const auto squared = squared_distance(d, c.reach[v], px, py, pz), distance = hn::Sqrt(squared);
        add_view(squared, distance, reach_m(d, c.reach[v], error, radius), reach_margin, span, is_wanted);
        if (!c.hysteresis) continue;
        add_view(squared, distance, reach_m(d, c.keep[v], error, radius), keep_margin, span, is_kept);
        is_wanted = Or(is_wanted, is_within(squared, reach_m(d, c.wish[v], error, radius)));
    }
    if (!c.hysteresis) keep_margin = reach_margin, is_kept = is_wanted;
}

template <typename D>
HWY_INLINE void evaluate_group(D d, const Criterion& c, const LaneGroup& b, LaneAnswers& out) {
    const Ints<D> di;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    const std::uint32_t looked_at = b.inactive | b.childless;
    const auto far = hn::Set(d, 3.4e38f);
    auto least = far;
    auto codes = hn::Zero(di);
    std::uint32_t wanted = 0, kept = 0;
    for (std::uint32_t lane = 0; lane < group_lanes; lane += lanes) {
        if ((looked_at >> lane & ((1u << lanes) - 1)) == 0) continue;
        auto px = hn::Undefined(d), py = px, pz = px, error = px, radius = px;
        auto error_code = hn::Undefined(di);
        read_lanes(d, c, b, lane, px, py, pz, error_code, error, radius);
        auto reach_margin = hn::Undefined(d), keep_margin = reach_margin, span = reach_margin;
        auto is_wanted = hn::Lt(px, px), is_kept = is_wanted;
        decide(d, c, px, py, pz, error, radius, reach_margin, keep_margin, span, is_wanted, is_kept);
        const std::uint32_t wanted_bits = bits_of(d, is_wanted),
                            kept_bits = c.hysteresis ? bits_of(d, is_kept) : wanted_bits;
        wanted |= wanted_bits << lane;
        kept |= kept_bits << lane;
        // A lane that is on, or will be, is judged by what keeps it.
        const std::uint32_t on = (b.inactive & wanted) | (b.childless & kept);
        const auto margin =
            c.hysteresis ? hn::IfThenElse(lanes_of_bits(d, on >> lane), keep_margin, reach_margin) : reach_margin;
        const auto slack = hn::Max(slack_m(d, margin, span), hn::Zero(d));
        const auto counts = lanes_of_bits(d, looked_at >> lane);
        least = hn::Min(least, hn::IfThenElse(counts, slack, far));
        codes = hn::Max(codes, hn::IfThenElseZero(hn::RebindMask(di, counts), error_code));
    }
    out.wanted = wanted & looked_at;
    out.kept = kept & looked_at;
    out.slack_m = hn::GetLane(hn::MinOfLanes(d, least));
    out.code = static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(di, codes)));
}

template <typename D>
HWY_INLINE float worst_of_group(D d, const Criterion& c, const LaneGroup& b, const float* unit_px) {
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    auto worst = hn::Zero(d);
    for (std::uint32_t lane = 0; lane < group_lanes; lane += lanes) {
        if ((b.inactive >> lane & ((1u << lanes) - 1)) == 0) continue;
        auto px = hn::Undefined(d), py = px, pz = px, error = px, radius = px;
        auto error_code = hn::Undefined(Ints<D>());
        read_lanes(d, c, b, lane, px, py, pz, error_code, error, radius);
        const auto counts = lanes_of_bits(d, b.inactive >> lane);
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const auto distance = hn::Sqrt(squared_distance(d, c.reach[v], px, py, pz));
            const auto apart = hn::Sub(hn::Sub(hn::Mul(distance, hn::Set(d, 1 - apart_rounding)),
                                               hn::Mul(radius, hn::Set(d, 1 + apart_rounding))),
                                       hn::Set(d, c.reach[v].pad));
            const auto pixels =
                hn::Div(hn::Mul(error, hn::Set(d, unit_px[v])), hn::Max(apart, hn::Set(d, least_apart_m)));
            worst = hn::Max(worst, hn::IfThenElseZero(counts, pixels));
        }
    }
    return hn::GetLane(hn::MaxOfLanes(d, worst));
}

void evaluate_lanes(const Criterion* const* c, const LaneGroup* b, std::uint32_t count, LaneAnswers* out) {
    for (std::uint32_t n = 0; n < count; ++n) evaluate_group(F(), *c[n], b[n], out[n]);
}
float worst_of_lanes(const Criterion& c, const LaneGroup& b, const float* unit_px) {
    return worst_of_group(F(), c, b, unit_px);
}
#if HWY_ONCE // for the baseline
void evaluate_each_lane(const Criterion* const* c, const LaneGroup* b, std::uint32_t count, LaneAnswers* out) {
    for (std::uint32_t n = 0; n < count; ++n) evaluate_group(hn::CappedTag<float, 1>(), *c[n], b[n], out[n]);
}
float worst_of_each_lane(const Criterion& c, const LaneGroup& b, const float* unit_px) {
    return worst_of_group(hn::CappedTag<float, 1>(), c, b, unit_px);
}
#endif

// The same for picked vertices. An answer is 16 bits for 16 of them; ticks are what their slacks are worth.
void evaluate_picked_lanes(const Criterion& c, const PickedLanes& b, float ticks_a_metre, PickedAnswers& out) {
    const F d;
    const I di;
    auto codes = hn::Zero(di);
    for (std::uint32_t first = 0; first < b.count; first += group_lanes) {
        std::uint32_t wanted = 0;
        for (std::uint32_t lane = 0; lane < group_lanes; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
            auto x = hn::Undefined(di), y = x, record = x, error_code = x;
            auto py = hn::Undefined(d), error = py, radius = py;
            read_picked(c, b, first + lane, x, y, record, error_code, py, error, radius);
            codes = hn::Max(codes, error_code);
            const auto px = hn::Mul(hn::ConvertTo(d, x), hn::Set(d, c.spacing_x_m));
            const auto pz = hn::Mul(hn::ConvertTo(d, y), hn::Set(d, c.spacing_z_m));
            auto reach_margin = hn::Undefined(d), keep_margin = reach_margin, span = reach_margin;
            auto is_wanted = hn::Lt(px, px), is_kept = is_wanted;
            decide(d, c, px, py, pz, error, radius, reach_margin, keep_margin, span, is_wanted, is_kept);
            wanted |= bits_of(d, is_wanted) << lane;
            const auto margin = c.hysteresis ? hn::IfThenElse(is_wanted, keep_margin, reach_margin) : reach_margin;
            const auto slack = hn::Max(slack_m(d, margin, span), hn::Zero(d));
            const auto ticks = hn::Min(hn::Mul(slack, hn::Set(d, ticks_a_metre)), hn::Set(d, float{most_ticks}));
            hn::StoreU(hn::ConvertTo(di, ticks), di, out.ticks + first + lane);
        }
        out.wanted[first / group_lanes] = static_cast<std::uint16_t>(wanted);
    }
    out.code = static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(di, codes)));
}

// Their lines come while the first of them are worked on. Rows need not begin where lines do.
HWY_INLINE void prefetch_rows(const PageRows& b) {
    for (std::uint32_t row = 0; row < b.count; ++row) {
        const std::uint32_t ready = b.ready[row];
        if (ready == 0) continue;
        const VertexRecord* const records = b.records + std::size_t{row} * b.stride;
        FJELL_PREFETCH(records + ((ready & 0xffff) != 0 ? 0 : group_lanes));
        FJELL_PREFETCH(records + group_lanes);
        FJELL_PREFETCH(records + (ready >> group_lanes != 0 ? 2 * group_lanes - 1 : group_lanes - 1));
    }
}

// Of the lanes of a row from `lane` on, where they stand.
HWY_INLINE auto columns_from(const Criterion& c, const PageRows& b, std::uint32_t lane) {
    const I di;
    const auto number = hn::Add(hn::LoadU(di, lane_numbers), hn::Set(di, static_cast<std::int32_t>(lane)));
    return hn::Min(hn::Add(hn::Set(di, b.x0), hn::ShiftLeftSame(number, b.z + 1)), hn::Set(di, c.last_x));
}
// And the row.
HWY_INLINE std::int32_t row_at(const Criterion& c, const PageRows& b, std::uint32_t row) {
    return std::min(b.y0 + (static_cast<std::int32_t>(row) << (b.z + 1)), c.last_y);
}

// The same for rows as they lie. Alone: of one view without hysteresis, whose margin is all there is.
template <bool Alone>
HWY_INLINE void evaluate_whole_rows(const Criterion& c, const PageRows& b, float ticks_a_metre, RowAnswers& out) {
    const F d;
    const I di;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    const auto far = hn::Set(d, 3.4e38f);
    const Reach& only = c.reach[0];
    alignas(64) float x_m[page_squares], x2[page_squares]; // and squares of what it is from the eye
    for (std::uint32_t lane = 0; lane < page_squares; lane += lanes) {
        const auto px = hn::Mul(hn::ConvertTo(d, columns_from(c, b, lane)), hn::Set(d, c.spacing_x_m));
        const auto dx = hn::Sub(px, hn::Set(d, only.eye_x));
        hn::Store(px, d, x_m + lane);
        hn::Store(hn::Mul(dx, dx), d, x2 + lane);
    }
    const auto eye_y = hn::Set(d, only.eye_y);
    auto codes = hn::Zero(di);
    std::uint32_t count = 0, groups = 0;
    for (std::uint32_t row = 0; row < b.count; ++row) {
        const std::uint32_t row_ready = b.ready[row];
        if (row_ready == 0) continue;
        const float z_m = static_cast<float>(row_at(c, b, row)) * c.spacing_z_m, dz = z_m - only.eye_z;
        const auto pz = hn::Set(d, z_m), z2 = hn::Set(d, dz * dz);
        const auto* const records = reinterpret_cast<const std::int32_t*>(b.records + std::size_t{row} * b.stride);
        std::uint32_t wanted = 0;
        for (std::uint32_t group = 0; group < page_squares / group_lanes; ++group) {
            const std::uint32_t first = group * group_lanes;
            if ((row_ready >> first & 0xffff) == 0) continue;
            ++groups;
            auto least = far;
            for (std::uint32_t lane = first; lane < first + group_lanes; lane += lanes) {
                const std::uint32_t ready = row_ready >> lane & ((1u << lanes) - 1);
                if (ready == 0) continue;
                auto error_code = hn::Undefined(di);
                auto py = hn::Undefined(d), error = py, radius = py, slack = py;
                read_record(d, c, hn::LoadU(di, records + lane), b.base, b.unit_m, error_code, py, error, radius);
                auto is_wanted = hn::Lt(pz, pz);
                if constexpr (Alone) { // as decide() does
                    const auto squared = squared_sum(hn::Load(d, x2 + lane), hn::Sub(py, eye_y), z2),
                               distance = hn::Sqrt(squared), reach = reach_m(d, only, error, radius);
                    is_wanted = is_within(squared, reach);
                    slack = slack_m(d, hn::Sub(reach, distance), hn::Add(reach, distance));
                } else {
                    auto reach_margin = hn::Undefined(d), keep_margin = reach_margin, span = reach_margin;
                    auto is_kept = is_wanted;
                    decide(d, c, hn::Load(d, x_m + lane), py, pz, error, radius, reach_margin, keep_margin, span,
                           is_wanted, is_kept);
                    slack = slack_m(
                        d, c.hysteresis ? hn::IfThenElse(is_wanted, keep_margin, reach_margin) : reach_margin, span);
                }
                wanted |= bits_of(d, is_wanted) << lane;
                const auto counts = lanes_of_bits(d, ready);
                least = hn::Min(least, hn::IfThenElse(counts, slack, far));
                codes = hn::Max(codes, hn::IfThenElseZero(hn::RebindMask(di, counts), error_code));
            }
            const float slack_m = std::max(hn::GetLane(hn::MinOfLanes(d, least)), 0.0f);
            const auto ticks = static_cast<std::uint32_t>(std::min(slack_m * ticks_a_metre, float{most_ticks}));
            std::uint16_t& of = out.ticks[2 * row + group];
            of = std::min(of, static_cast<std::uint16_t>(soon + ticks));
        }
        wanted &= row_ready;
        out.wanted[row] |= wanted;
        count += static_cast<std::uint32_t>(std::popcount(wanted));
    }
    out.count = count;
    out.groups = groups;
    out.code = static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(di, codes)));
}

void evaluate_rows_lanes(const Criterion& c, const PageRows& b, float ticks_a_metre, RowAnswers& out) {
    prefetch_rows(b);
    if (c.views == 1 && !c.hysteresis)
        evaluate_whole_rows<true>(c, b, ticks_a_metre, out);
    else
        evaluate_whole_rows<false>(c, b, ticks_a_metre, out);
}

void place_picked_lanes(const Criterion& c, const PickedLanes& b, MeshVertex* vertices, MorphVertex* morph) {
    const F d;
    const I di;
    auto* const words = reinterpret_cast<std::int32_t*>(vertices);
    auto* const floats = reinterpret_cast<float*>(morph);
    for (std::uint32_t first = 0; first < b.count; first += group_lanes)
        for (std::uint32_t lane = first; lane < first + group_lanes; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
            auto x = hn::Undefined(di), y = x, record = x, error_code = x;
            auto height = hn::Undefined(d), error = height, radius = height;
            read_picked(c, b, lane, x, y, record, error_code, height, error, radius);
            hn::StoreInterleaved3(x, y, hn::BitCast(di, height), di, words + std::size_t{lane} * 3);
            if (morph != nullptr)
                hn::StoreInterleaved4(hn::Zero(d), error, radius, hn::Set(d, activated_long_ago_s), d,
                                      floats + std::size_t{lane} * 4);
        }
}

#if HWY_MAX_BYTES < 64 && !HWY_HAVE_SCALABLE
// Lanes whose bits are set come first.
template <typename V>
HWY_INLINE V packed(V v, std::uint32_t bits) {
    const I d;
    const hn::Rebind<std::uint8_t, I> bytes;
    return hn::TableLookupLanes(v, hn::IndicesFromVec(d, hn::PromoteTo(d, hn::LoadU(bytes, lane_sets[bits].data()))));
}
#else // it has an instruction for that
template <typename V>
HWY_INLINE V packed(V v, std::uint32_t bits) {
    std::uint8_t bytes[8] = {};
    std::memcpy(bytes, &bits, sizeof bits); // in one store, or the load after it waits
    return hn::CompressBits(v, bytes);
}
#endif

// Vertices of rows side by side, and room for what a vector has beyond the last.
struct Gathered {
    static constexpr std::uint32_t most = 2 * page_squares * (page_squares + 1);
    std::uint32_t count = 0;
    alignas(64) std::int32_t record[most + group_lanes], x[most + group_lanes], y[most + group_lanes];
};

HWY_INLINE void gather_rows(const Criterion& c, const PageRows& b, Gathered& to) {
    const I di;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(di));
    alignas(64) std::int32_t x[page_squares];
    for (std::uint32_t lane = 0; lane < page_squares; lane += lanes) hn::Store(columns_from(c, b, lane), di, x + lane);
    std::uint32_t count = to.count;
    for (std::uint32_t row = 0; row < b.count; ++row) {
        const std::uint32_t row_bits = b.ready[row];
        if (row_bits == 0) continue;
        const auto y = hn::Set(di, row_at(c, b, row));
        const auto* const records = reinterpret_cast<const std::int32_t*>(b.records + std::size_t{row} * b.stride);
        for (std::uint32_t lane = 0; lane < page_squares; lane += lanes) {
            const std::uint32_t bits = row_bits >> lane & ((1u << lanes) - 1);
            if (bits == 0) continue;
            hn::StoreU(packed(hn::LoadU(di, records + lane), bits), di, to.record + count);
            hn::StoreU(packed(hn::Load(di, x + lane), bits), di, to.x + count);
            hn::StoreU(y, di, to.y + count);
            count += static_cast<std::uint32_t>(std::popcount(bits));
        }
    }
    to.count = count;
}

std::uint32_t place_whole_rows(const Criterion& c, const PageRows* planes, std::uint32_t count, MeshVertex* vertices,
                               MorphVertex* morph, std::uint8_t* voids) {
    const F d;
    const I di;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    Gathered all;
    for (std::uint32_t n = 0; n < count; ++n) gather_rows(c, planes[n], all);
    const auto place = [&](std::uint32_t n, std::int32_t* words, float* floats) HWY_ATTR {
        auto error_code = hn::Undefined(di);
        auto height = hn::Undefined(d), error = height, radius = height;
        read_record(d, c, hn::Load(di, all.record + n), planes[0].base, planes[0].unit_m, error_code, height, error,
                    radius);
        hn::StoreInterleaved3(hn::Load(di, all.x + n), hn::Load(di, all.y + n), hn::BitCast(di, height), di, words);
        if (floats != nullptr)
            hn::StoreInterleaved4(hn::Zero(d), error, radius, hn::Set(d, activated_long_ago_s), d, floats);
    };
    std::uint32_t n = 0;
    for (; n + lanes <= all.count; n += lanes)
        place(n, reinterpret_cast<std::int32_t*>(vertices + n),
              morph != nullptr ? reinterpret_cast<float*>(morph + n) : nullptr);
    if (n != all.count) { // what follows in their slots is others'
        // Codes of nothing are codes still, but for what was there before.
        hn::StoreU(hn::Zero(di), di, all.record + all.count);
        MeshVertex last_vertices[group_lanes];
        MorphVertex last_morph[group_lanes];
        place(n, reinterpret_cast<std::int32_t*>(last_vertices), reinterpret_cast<float*>(last_morph));
        std::copy_n(last_vertices, all.count - n, vertices + n);
        if (morph != nullptr) std::copy_n(last_morph, all.count - n, morph + n);
    }
    for (n = 0; voids != nullptr && n < all.count; ++n) {
        VertexRecord record;
        std::memcpy(&record, all.record + n, sizeof record);
        voids[n] = is_void(record) ? 1 : 0;
    }
    return all.count;
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fjell {

HWY_EXPORT(evaluate_lanes);
HWY_EXPORT(evaluate_picked_lanes);
HWY_EXPORT(evaluate_rows_lanes);
HWY_EXPORT(worst_of_lanes);
HWY_EXPORT(place_picked_lanes);
HWY_EXPORT(place_whole_rows);

void evaluate(const Criterion* const* decisions, const LaneGroup* groups, std::uint32_t count, LaneAnswers* answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_lanes)(decisions, groups, count, answers);
}
void evaluate_scalar(const Criterion* const* decisions, const LaneGroup* groups, std::uint32_t count,
                     LaneAnswers* answers) {
    HWY_STATIC_DISPATCH(evaluate_each_lane)(decisions, groups, count, answers);
}
float worst_px(const Criterion& decision, const LaneGroup& group, const float* unit_px) {
    return HWY_DYNAMIC_DISPATCH(worst_of_lanes)(decision, group, unit_px);
}
float worst_px_scalar(const Criterion& decision, const LaneGroup& group, const float* unit_px) {
    return HWY_STATIC_DISPATCH(worst_of_each_lane)(decision, group, unit_px);
}
void evaluate_picked(const Criterion& decision, const PickedLanes& lanes, float ticks_a_metre, PickedAnswers& answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_picked_lanes)(decision, lanes, ticks_a_metre, answers);
}
void evaluate_rows(const Criterion& decision, const PageRows& rows, float ticks_a_metre, RowAnswers& answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_rows_lanes)(decision, rows, ticks_a_metre, answers);
}
void place_picked(const Criterion& decision, const PickedLanes& lanes, MeshVertex* vertices, MorphVertex* morph) {
    HWY_DYNAMIC_DISPATCH(place_picked_lanes)(decision, lanes, vertices, morph);
}
std::uint32_t place_rows(const Criterion& decision, const PageRows* planes, std::uint32_t count, MeshVertex* vertices,
                         MorphVertex* morph, std::uint8_t* voids) {
    return HWY_DYNAMIC_DISPATCH(place_whole_rows)(decision, planes, count, vertices, morph, voids);
}

} // namespace fjell
#endif
