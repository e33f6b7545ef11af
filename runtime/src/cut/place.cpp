// Vertices of pages, written to their slots one after the other.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/place.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "cut/evaluate.h"
#include "cut/lane_sets.h"
#include "cut/lanes-inl.h"
#include "pack/record.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

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
            hn::StoreInterleaved4(hn::Zero(d), error, radius, hn::Set(d, long_active_s), d,
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
    for (std::uint32_t lane = 0; lane < page_squares; lane += lanes) {
        const auto number = hn::Add(hn::LoadU(di, lane_numbers), hn::Set(di, static_cast<std::int32_t>(lane)));
        const auto at = hn::Add(hn::Set(di, b.x0), hn::ShiftLeftSame(number, b.z + 1));
        hn::Store(hn::Min(at, hn::Set(di, c.last_x)), di, x + lane);
    }
    std::uint32_t count = to.count;
    for (std::uint32_t row = 0; row < b.count; ++row) {
        const std::uint32_t row_bits = b.ready[row];
        if (row_bits == 0) continue;
        const auto y = hn::Set(di, std::min(b.y0 + (static_cast<std::int32_t>(row) << (b.z + 1)), c.last_y));
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
        read_record(c, hn::Load(di, all.record + n), planes[0].base, planes[0].unit_m, error_code, height, error,
                    radius);
        hn::StoreInterleaved3(hn::Load(di, all.x + n), hn::Load(di, all.y + n), hn::BitCast(di, height), di, words);
        hn::StoreInterleaved4(hn::Zero(d), error, radius, hn::Set(d, long_active_s), d, floats);
    };
    std::uint32_t n = 0;
    for (; n + lanes <= all.count; n += lanes)
        place(n, reinterpret_cast<std::int32_t*>(vertices + n), reinterpret_cast<float*>(morph + n));
    if (n != all.count) { // what follows in their slots is others'
        // Codes of nothing are codes still, but for what was there before.
        hn::StoreU(hn::Zero(di), di, all.record + all.count);
        MeshVertex last_vertices[group_lanes];
        MorphVertex last_morph[group_lanes];
        place(n, reinterpret_cast<std::int32_t*>(last_vertices), reinterpret_cast<float*>(last_morph));
        std::copy_n(last_vertices, all.count - n, vertices + n);
        std::copy_n(last_morph, all.count - n, morph + n);
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

HWY_EXPORT(place_picked_lanes);
HWY_EXPORT(place_whole_rows);

void place_picked(const Criterion& decision, const PickedLanes& lanes, MeshVertex* vertices, MorphVertex* morph) {
    HWY_DYNAMIC_DISPATCH(place_picked_lanes)(decision, lanes, vertices, morph);
}

std::uint32_t place_rows(const Criterion& decision, const PageRows* planes, std::uint32_t count, MeshVertex* vertices,
                         MorphVertex* morph, std::uint8_t* voids) {
    return HWY_DYNAMIC_DISPATCH(place_whole_rows)(decision, planes, count, vertices, morph, voids);
}

} // namespace fjell
#endif
