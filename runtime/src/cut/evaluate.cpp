// One expression, in the order of tree/wanted.h, for as many lanes as the machine has: Highway compiles it for each
// instruction set and picks one at run time. No fused multiply-add, or decisions would differ from machine to machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/evaluate.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

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

void evaluate_lanes(const Criterion& c, const LaneGroup& b, LaneMargins& out) {
    const F d;
    const I di;
    out.wanted = out.kept = 0;
    for (std::uint32_t lane = 0; lane < group_lanes; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto number = hn::Iota(di, static_cast<std::int32_t>(lane));
        const auto x = hn::Min(hn::Add(hn::Set(di, b.x0), hn::Mul(number, hn::Set(di, b.dx))), hn::Set(di, c.last_x));
        const auto y = hn::Min(hn::Add(hn::Set(di, b.y0), hn::Mul(number, hn::Set(di, b.dy))), hn::Set(di, c.last_y));
        const auto px = hn::Mul(hn::ConvertTo(d, x), hn::Set(d, c.spacing_x_m));
        const auto pz = hn::Mul(hn::ConvertTo(d, y), hn::Set(d, c.spacing_z_m));
        const auto record = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(b.records + lane));
        const auto height = hn::Add(hn::And(record, hn::Set(di, 0xffff)), hn::Set(di, b.base));
        const auto py = hn::Add(hn::Set(d, c.base_m), hn::Mul(hn::ConvertTo(d, height), hn::Set(d, c.quantum_m)));
        const auto error_code = hn::And(hn::ShiftRight<16>(record), hn::Set(di, 0xff));
        const auto radius_code = hn::And(hn::ShiftRight<24>(record), hn::Set(di, 0x7f));
        const auto error = hn::GatherIndex(d, c.error_m, error_code);
        const auto radius = hn::Mul(hn::Set(d, b.unit_m), hn::GatherIndex(d, c.radius_factor, radius_code));
        auto reach_margin = hn::Set(d, -3.4e38f), keep_margin = reach_margin, span = hn::Zero(d);
        std::uint32_t wanted_bits = 0, kept_bits = 0;
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const Reach& r = c.reach[v];
            const auto dx = hn::Sub(px, hn::Set(d, r.eye_x));
            const auto dy = hn::Sub(py, hn::Set(d, r.eye_y));
            const auto dz = hn::Sub(pz, hn::Set(d, r.eye_z));
            const auto squared = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
            const auto distance = hn::Sqrt(squared);
            const auto decide = [&](const Reach& with, auto& margin) HWY_ATTR {
                const auto reach =
                    hn::Add(hn::Mul(hn::Add(radius, hn::Mul(error, hn::Set(d, with.q))), hn::Set(d, reach_grow)),
                            hn::Set(d, with.pad));
                margin = hn::Max(margin, hn::Sub(reach, distance));
                span = hn::Max(span, hn::Add(reach, distance));
                return bits_of(d, hn::Lt(squared, hn::Mul(reach, reach)));
            };
            wanted_bits |= decide(r, reach_margin);
            if (c.hysteresis) kept_bits |= decide(c.keep[v], keep_margin);
        }
        if (!c.hysteresis) keep_margin = reach_margin, kept_bits = wanted_bits;
        hn::Store(reach_margin, d, out.reach_m + lane);
        hn::Store(keep_margin, d, out.keep_m + lane);
        hn::Store(span, d, out.span_m + lane);
        out.wanted |= wanted_bits << lane;
        out.kept |= kept_bits << lane;
    }
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace fjell {

HWY_EXPORT(evaluate_lanes);

void evaluate(const Criterion& decision, const LaneGroup& group, LaneMargins& margins) {
    HWY_DYNAMIC_DISPATCH(evaluate_lanes)(decision, group, margins);
}

void evaluate_scalar(const Criterion& c, const LaneGroup& b, LaneMargins& out) {
    out.wanted = out.kept = 0;
    for (std::int32_t lane = 0; lane < static_cast<std::int32_t>(group_lanes); ++lane) {
        const VertexRecord record = b.records[lane];
        const float px = static_cast<float>(std::min(b.x0 + lane * b.dx, c.last_x)) * c.spacing_x_m;
        const float pz = static_cast<float>(std::min(b.y0 + lane * b.dy, c.last_y)) * c.spacing_z_m;
        const float py = c.base_m + static_cast<float>(record.height + b.base) * c.quantum_m;
        const float error = c.error_m[record.error];
        const float radius = b.unit_m * c.radius_factor[record.radius & (radius_codes - 1)];
        float margins[2] = {-3.4e38f, -3.4e38f}, span = 0;
        std::uint32_t bits[2] = {0, 0};
        for (std::uint32_t v = 0; v < c.views; ++v) {
            const float dx = px - c.reach[v].eye_x, dy = py - c.reach[v].eye_y, dz = pz - c.reach[v].eye_z;
            const float squared = dx * dx + dy * dy + dz * dz;
            const float distance = std::sqrt(squared);
            for (int keep = 0; keep <= (c.hysteresis ? 1 : 0); ++keep) {
                const Reach& r = keep ? c.keep[v] : c.reach[v];
                const float reach = (radius + error * r.q) * reach_grow + r.pad;
                margins[keep] = std::max(margins[keep], reach - distance);
                span = std::max(span, reach + distance);
                bits[keep] |= squared < reach * reach ? 1u : 0u;
            }
        }
        if (!c.hysteresis) margins[1] = margins[0], bits[1] = bits[0];
        out.reach_m[lane] = margins[0];
        out.keep_m[lane] = margins[1];
        out.span_m[lane] = span;
        out.wanted |= bits[0] << lane;
        out.kept |= bits[1] << lane;
    }
}

} // namespace fjell
#endif
