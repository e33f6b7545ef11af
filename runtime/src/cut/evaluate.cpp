// One expression, in the order of tree/wanted.h, for as many lanes as the machine has: Highway compiles it for each
// instruction set and picks one at run time. No fused multiply-add, or decisions would differ from machine to machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/evaluate.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <bit>

#include "compiler.h"
#include "cut/evaluate.h"
#include "cut/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Of the lanes from `first` on: where they stand, and what their records say. Through references, because vectors whose
// length nobody knows cannot be members.
template <typename VI, typename VF>
HWY_INLINE void read_lanes(const Criterion& c, const LaneGroup& b, std::uint32_t first, VF& x_m, VF& y_m, VF& z_m,
                           VI& error_code, VF& error_m, VF& radius_m) {
    const F d;
    const I di;
    const auto number = hn::LoadU(di, lane_numbers + first);
    const auto x = hn::Min(hn::Add(hn::Set(di, b.x0), hn::Mul(number, hn::Set(di, b.dx))), hn::Set(di, c.last_x));
    const auto y = hn::Min(hn::Add(hn::Set(di, b.y0), hn::Mul(number, hn::Set(di, b.dy))), hn::Set(di, c.last_y));
    x_m = hn::Mul(hn::ConvertTo(d, x), hn::Set(d, c.spacing_x_m));
    z_m = hn::Mul(hn::ConvertTo(d, y), hn::Set(d, c.spacing_z_m));
    const auto record = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(b.records + first));
    read_record(c, record, b.base, b.unit_m, error_code, y_m, error_m, radius_m);
}

// Margins of all views, and what they decide.
template <typename VF, typename M>
HWY_INLINE void decide(const Criterion& c, VF px, VF py, VF pz, VF error, VF radius, VF& reach_margin, VF& keep_margin,
                       VF& span, M& is_wanted, M& is_kept) {
    const F d;
    reach_margin = keep_margin = hn::Set(d, -3.4e38f);
    span = hn::Zero(d);
    is_wanted = is_kept = hn::Lt(span, span); // none
    for (std::uint32_t v = 0; v < c.views; ++v) {
        const Reach& r = c.reach[v];
        const auto dx = hn::Sub(px, hn::Set(d, r.eye_x));
        const auto dy = hn::Sub(py, hn::Set(d, r.eye_y));
        const auto dz = hn::Sub(pz, hn::Set(d, r.eye_z));
        const auto squared = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
        const auto distance = hn::Sqrt(squared);
        const auto with = [&](const Reach& reach_of, VF& margin, M& answer) HWY_ATTR {
            const auto reach =
                hn::Add(hn::Mul(hn::Add(radius, hn::Mul(error, hn::Set(d, reach_of.q))), hn::Set(d, reach_grow)),
                        hn::Set(d, reach_of.pad));
            margin = hn::Max(margin, hn::Sub(reach, distance));
            span = hn::Max(span, hn::Add(reach, distance));
            answer = hn::Or(answer, hn::Lt(squared, hn::Mul(reach, reach)));
        };
        with(r, reach_margin, is_wanted);
        if (c.hysteresis) with(c.keep[v], keep_margin, is_kept);
    }
    if (!c.hysteresis) keep_margin = reach_margin, is_kept = is_wanted;
}

void evaluate_lanes(const Criterion& c, const LaneGroup& b, LaneAnswers& out) {
    const F d;
    const I di;
    const std::uint32_t looked_at = b.inactive | b.childless;
    const auto far = hn::Set(d, 3.4e38f);
    auto least = far;
    auto codes = hn::Zero(di);
    std::uint32_t wanted = 0, kept = 0;
    for (std::uint32_t lane = 0; lane < group_lanes; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
        if ((looked_at >> lane & ((1u << hn::Lanes(d)) - 1)) == 0) continue;
        auto px = hn::Undefined(d), py = px, pz = px, error = px, radius = px;
        auto error_code = hn::Undefined(di);
        read_lanes(c, b, lane, px, py, pz, error_code, error, radius);
        auto reach_margin = hn::Undefined(d), keep_margin = reach_margin, span = reach_margin;
        auto is_wanted = hn::Lt(px, px), is_kept = is_wanted;
        decide(c, px, py, pz, error, radius, reach_margin, keep_margin, span, is_wanted, is_kept);
        const std::uint32_t wanted_bits = bits_of(d, is_wanted),
                            kept_bits = c.hysteresis ? bits_of(d, is_kept) : wanted_bits;
        wanted |= wanted_bits << lane;
        kept |= kept_bits << lane;
        const auto bit = hn::LoadU(di, lane_bits);
        const auto is_set = [&](std::uint32_t bits) HWY_ATTR {
            return hn::RebindMask(
                d, hn::Ne(hn::And(bit, hn::Set(di, static_cast<std::int32_t>(bits >> lane & 0xffff))), hn::Zero(di)));
        };
        // A lane that is on, or will be, is judged by what keeps it.
        const std::uint32_t on = (b.inactive & wanted) | (b.childless & kept);
        const auto margin = c.hysteresis ? hn::IfThenElse(is_set(on), keep_margin, reach_margin) : reach_margin;
        const auto slack = hn::Max(hn::Sub(hn::Abs(margin), hn::Mul(span, hn::Set(d, slack_rounding))), hn::Zero(d));
        const auto counts = is_set(looked_at);
        least = hn::Min(least, hn::IfThenElse(counts, slack, far));
        codes = hn::Max(codes, hn::IfThenElseZero(hn::RebindMask(di, counts), error_code));
    }
    out.wanted = wanted & looked_at;
    out.kept = kept & looked_at;
    out.slack_m = hn::GetLane(hn::MinOfLanes(d, least));
    out.code = static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(di, codes)));
}

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
            decide(c, px, py, pz, error, radius, reach_margin, keep_margin, span, is_wanted, is_kept);
            wanted |= bits_of(d, is_wanted) << lane;
            const auto margin = c.hysteresis ? hn::IfThenElse(is_wanted, keep_margin, reach_margin) : reach_margin;
            const auto slack =
                hn::Max(hn::Sub(hn::Abs(margin), hn::Mul(span, hn::Set(d, slack_rounding))), hn::Zero(d));
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
        const auto number = hn::Add(hn::LoadU(di, lane_numbers), hn::Set(di, static_cast<std::int32_t>(lane)));
        const auto x = hn::Min(hn::Add(hn::Set(di, b.x0), hn::ShiftLeftSame(number, b.z + 1)), hn::Set(di, c.last_x));
        const auto px = hn::Mul(hn::ConvertTo(d, x), hn::Set(d, c.spacing_x_m));
        const auto dx = hn::Sub(px, hn::Set(d, only.eye_x));
        hn::Store(px, d, x_m + lane);
        hn::Store(hn::Mul(dx, dx), d, x2 + lane);
    }
    const auto q = hn::Set(d, only.q), pad = hn::Set(d, only.pad), eye_y = hn::Set(d, only.eye_y);
    auto codes = hn::Zero(di);
    std::uint32_t count = 0, groups = 0;
    for (std::uint32_t row = 0; row < b.count; ++row) {
        const std::uint32_t row_ready = b.ready[row];
        if (row_ready == 0) continue;
        const std::int32_t y = std::min(b.y0 + (static_cast<std::int32_t>(row) << (b.z + 1)), c.last_y);
        const float z_m = static_cast<float>(y) * c.spacing_z_m, dz = z_m - only.eye_z;
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
                read_record(c, hn::LoadU(di, records + lane), b.base, b.unit_m, error_code, py, error, radius);
                auto is_wanted = hn::Lt(pz, pz);
                if constexpr (Alone) { // as decide() does
                    const auto dy = hn::Sub(py, eye_y);
                    const auto squared = hn::Add(hn::Add(hn::Load(d, x2 + lane), hn::Mul(dy, dy)), z2);
                    const auto distance = hn::Sqrt(squared);
                    const auto reach =
                        hn::Add(hn::Mul(hn::Add(radius, hn::Mul(error, q)), hn::Set(d, reach_grow)), pad);
                    is_wanted = hn::Lt(squared, hn::Mul(reach, reach));
                    slack = hn::Sub(hn::Abs(hn::Sub(reach, distance)),
                                    hn::Mul(hn::Add(reach, distance), hn::Set(d, slack_rounding)));
                } else {
                    auto reach_margin = hn::Undefined(d), keep_margin = reach_margin, span = reach_margin;
                    auto is_kept = is_wanted;
                    decide(c, hn::Load(d, x_m + lane), py, pz, error, radius, reach_margin, keep_margin, span,
                           is_wanted, is_kept);
                    const auto margin =
                        c.hysteresis ? hn::IfThenElse(is_wanted, keep_margin, reach_margin) : reach_margin;
                    slack = hn::Sub(hn::Abs(margin), hn::Mul(span, hn::Set(d, slack_rounding)));
                }
                wanted |= bits_of(d, is_wanted) << lane;
                const auto counts = hn::Ne(
                    hn::And(hn::LoadU(di, lane_bits), hn::Set(di, static_cast<std::int32_t>(ready))), hn::Zero(di));
                least = hn::Min(least, hn::IfThenElse(hn::RebindMask(d, counts), slack, far));
                codes = hn::Max(codes, hn::IfThenElseZero(counts, error_code));
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

float worst_of_lanes(const Criterion& c, const LaneGroup& b, const float* unit_px) {
    const F d;
    const I di;
    auto worst = hn::Zero(d);
    for (std::uint32_t lane = 0; lane < group_lanes; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const std::uint32_t bits = b.inactive >> lane & 0xffff;
        if ((bits & ((1u << hn::Lanes(d)) - 1)) == 0) continue;
        auto px = hn::Undefined(d), py = px, pz = px, error = px, radius = px;
        auto error_code = hn::Undefined(di);
        read_lanes(c, b, lane, px, py, pz, error_code, error, radius);
        const auto counts = hn::RebindMask(
            d, hn::Ne(hn::And(hn::LoadU(di, lane_bits), hn::Set(di, static_cast<std::int32_t>(bits))), hn::Zero(di)));
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const Reach& r = c.reach[v];
            const auto dx = hn::Sub(px, hn::Set(d, r.eye_x));
            const auto dy = hn::Sub(py, hn::Set(d, r.eye_y));
            const auto dz = hn::Sub(pz, hn::Set(d, r.eye_z));
            const auto distance = hn::Sqrt(hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz)));
            const auto apart = hn::Sub(hn::Sub(hn::Mul(distance, hn::Set(d, 1 - apart_rounding)),
                                               hn::Mul(radius, hn::Set(d, 1 + apart_rounding))),
                                       hn::Set(d, r.pad));
            const auto pixels =
                hn::Div(hn::Mul(error, hn::Set(d, unit_px[v])), hn::Max(apart, hn::Set(d, least_apart_m)));
            worst = hn::Max(worst, hn::IfThenElseZero(counts, pixels));
        }
    }
    return hn::GetLane(hn::MaxOfLanes(d, worst));
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace fjell {

HWY_EXPORT(evaluate_lanes);
HWY_EXPORT(evaluate_picked_lanes);
HWY_EXPORT(evaluate_rows_lanes);
HWY_EXPORT(worst_of_lanes);

float worst_px(const Criterion& decision, const LaneGroup& group, const float* unit_px) {
    return HWY_DYNAMIC_DISPATCH(worst_of_lanes)(decision, group, unit_px);
}

namespace {

struct LaneVertex {
    float x_m, y_m, z_m, error_m, radius_m;
    std::uint8_t error_code;
};
LaneVertex read_lane(const Criterion& c, const LaneGroup& b, std::int32_t lane) {
    const VertexRecord record = b.records[lane];
    return {static_cast<float>(std::min(b.x0 + lane * b.dx, c.last_x)) * c.spacing_x_m,
            c.base_m + static_cast<float>(record.height + b.base) * c.quantum_m,
            static_cast<float>(std::min(b.y0 + lane * b.dy, c.last_y)) * c.spacing_z_m,
            c.error_m[record.error],
            b.unit_m * c.radius_factor[record.radius & (radius_codes - 1)],
            record.error};
}

} // namespace

float worst_px_scalar(const Criterion& c, const LaneGroup& b, const float* unit_px) {
    float worst = 0;
    for (std::int32_t lane = 0; lane < static_cast<std::int32_t>(group_lanes); ++lane) {
        if ((b.inactive >> lane & 1) == 0) continue;
        const LaneVertex p = read_lane(c, b, lane);
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const Reach& r = c.reach[v];
            const float dx = p.x_m - r.eye_x, dy = p.y_m - r.eye_y, dz = p.z_m - r.eye_z;
            const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
            const float apart = distance * (1 - apart_rounding) - p.radius_m * (1 + apart_rounding) - r.pad;
            worst = std::max(worst, p.error_m * unit_px[v] / std::max(apart, least_apart_m));
        }
    }
    return worst;
}

void evaluate(const Criterion& decision, const LaneGroup& group, LaneAnswers& answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_lanes)(decision, group, answers);
}

void evaluate_picked(const Criterion& decision, const PickedLanes& lanes, float ticks_a_metre, PickedAnswers& answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_picked_lanes)(decision, lanes, ticks_a_metre, answers);
}

void evaluate_rows(const Criterion& decision, const PageRows& rows, float ticks_a_metre, RowAnswers& answers) {
    HWY_DYNAMIC_DISPATCH(evaluate_rows_lanes)(decision, rows, ticks_a_metre, answers);
}

void evaluate_scalar(const Criterion& c, const LaneGroup& b, LaneAnswers& out) {
    out = {0, 0, 3.4e38f, 0};
    for (std::int32_t lane = 0; lane < static_cast<std::int32_t>(group_lanes); ++lane) {
        const std::uint32_t bit = 1u << lane;
        if (((b.inactive | b.childless) & bit) == 0) continue;
        const LaneVertex p = read_lane(c, b, lane);
        float margins[2] = {-3.4e38f, -3.4e38f}, span = 0;
        bool answers[2] = {false, false};
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const float dx = p.x_m - c.reach[v].eye_x, dy = p.y_m - c.reach[v].eye_y, dz = p.z_m - c.reach[v].eye_z;
            const float squared = dx * dx + dy * dy + dz * dz;
            const float distance = std::sqrt(squared);
            for (std::size_t keep = 0; keep <= (c.hysteresis ? 1 : 0); ++keep) {
                const Reach& r = keep ? c.keep[v] : c.reach[v];
                const float reach = (p.radius_m + p.error_m * r.q) * reach_grow + r.pad;
                margins[keep] = std::max(margins[keep], reach - distance);
                span = std::max(span, reach + distance);
                answers[keep] = answers[keep] || squared < reach * reach;
            }
        }
        if (!c.hysteresis) margins[1] = margins[0], answers[1] = answers[0];
        out.wanted |= answers[0] ? bit : 0;
        out.kept |= answers[1] ? bit : 0;
        const bool on = (b.inactive & bit) != 0 ? answers[0] : answers[1];
        const float slack = std::max(std::abs(margins[on ? 1 : 0]) - span * slack_rounding, 0.0f);
        out.slack_m = std::min(out.slack_m, slack);
        out.code = std::max<std::uint32_t>(out.code, p.error_code);
    }
}

} // namespace fjell
#endif
