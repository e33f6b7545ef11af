// What neighbouring shards show each other: frames of a store, `width` wide, along the inside of what each one holds.
// A shard lays its neighbours' frames around its own store, and from then on reads as if it held them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "baker/shard/plan_folder.h"
#include "baker/store/store.h"

namespace fjell::baker {

// Four windows that cover `outer` less `inner`, which lies inside; some may be without area.
[[nodiscard]] inline std::vector<Window> ring(const Window& outer, const Window& inner) {
    const std::int32_t below = inner.y + inner.rows, right = inner.x + inner.columns;
    return {{outer.x, outer.y, outer.columns, inner.y - outer.y},
            {outer.x, below, outer.columns, outer.y + outer.rows - below},
            {outer.x, inner.y, inner.x - outer.x, inner.rows},
            {right, inner.y, outer.x + outer.columns - right, inner.rows}};
}

// What a store holds where nobody has written.
template <typename T>
[[nodiscard]] T unwritten(const Store<T>& store) {
    if constexpr (std::is_same_v<T, float>)
        if (store.is_unwritten_void()) return std::numeric_limits<float>::quiet_NaN();
    return T{};
}

// The frame inside what a store holds, as a parcel. width_x may differ from width_y: channels of texels lie along x.
// sparse: without pieces in which nobody has written.
template <typename T>
[[nodiscard]] std::vector<std::byte> frame_of_store(const Store<T>& store, std::int32_t width_x, std::int32_t width_y,
                                                    bool sparse = false) {
    const Window& all = store.held();
    const std::int32_t wx = std::min(width_x, (all.columns + 1) / 2), wy = std::min(width_y, (all.rows + 1) / 2);
    std::vector<Window> strips =
        ring(all, {all.x + wx, all.y + wy, std::max(all.columns - 2 * wx, 0), std::max(all.rows - 2 * wy, 0)});
    // Of an odd middle that is no more than one column or row wide the last strip begins where the first one ends.
    ParcelWriter to;
    const std::vector<T> none(sparse ? std::size_t{1} << 10 : 0, unwritten(store));
    const auto has_any = [&](const std::vector<T>& values) {
        for (std::size_t at = 0; at < values.size(); at += none.size())
            if (std::memcmp(values.data() + at, none.data(), std::min(none.size(), values.size() - at) * sizeof(T)) !=
                0)
                return true;
        return false;
    };
    const auto put = [&](const Window& w) {
        std::vector<T> values(w.area());
        if (w.area() != 0) store.read(w, values.data(), w.columns);
        if (sparse && !has_any(values)) return;
        to.put(w);
        to.put_all(std::span<const T>(values));
    };
    const std::int32_t most = sparse ? 512 : std::max(all.columns, all.rows);
    for (Window w : strips) {
        w = common(w, all);
        if (w.area() == 0 && !sparse) put(w);
        for (std::int32_t y = w.y; y < w.y + w.rows; y += most)
            for (std::int32_t x = w.x; x < w.x + w.columns; x += most) put(common(w, {x, y, most, most}));
    }
    return std::move(to.bytes);
}

// Lays around `store` what the neighbours' frames of the same name hold, as far as the whole reaches. window_of(shard):
// what that shard holds of this store; without area: it has left none. sparse: what no frame has is unwritten. Returns
// the bytes that were read.
template <typename T>
std::uint64_t add_frames(const ShardPlan& plan, const ShardStep& step, const std::string& name, int shard,
                         std::int32_t width_x, std::int32_t width_y, const std::function<Window(int)>& window_of,
                         Store<T>& store, bool sparse = false) {
    const Window& own = store.held();
    const Window whole{0, 0, static_cast<std::int32_t>(store.columns()), static_cast<std::int32_t>(store.rows())};
    const Window outer =
        common({own.x - width_x, own.y - width_y, own.columns + 2 * width_x, own.rows + 2 * width_y}, whole);
    struct Strip {
        Window at;
        Buffer<T> values;
        std::vector<bool> known;
    };
    // Row by row what both hold.
    const auto lay = [](const Window& at, const std::vector<T>& values, Strip& strip) {
        const auto place = [](const Window& w, std::int32_t x, std::int32_t y) {
            return std::ptrdiff_t{y - w.y} * w.columns + (x - w.x);
        };
        const Window shared = common(at, strip.at);
        if (shared.area() == 0) return;
        for (std::int32_t y = shared.y; y < shared.y + shared.rows; ++y) {
            const std::ptrdiff_t to = place(strip.at, shared.x, y);
            std::copy_n(values.begin() + place(at, shared.x, y), shared.columns, strip.values.data() + to);
            std::fill_n(strip.known.begin() + to, shared.columns, true);
        }
    };
    std::vector<Strip> strips;
    std::vector<T> values;
    for (const Window& w : ring(outer, own))
        if (w.area() != 0)
            strips.push_back({w, Buffer<T>(w.area(), unwritten(store)), std::vector<bool>(w.area(), sparse)});
    std::uint64_t bytes_read = 0;
    for (int other = 1; other <= plan.shards; ++other) {
        if (other == shard || plan.empty(other) || common(window_of(other), outer).area() == 0) continue;
        const std::vector<std::byte> bytes = read_parcel(plan, step, other, name);
        bytes_read += bytes.size();
        for (ParcelReader from(bytes); !from.ended();) {
            const Window at = from.get<Window>();
            if (common(at, outer).area() == 0) { // of a neighbour's four sides at most three face this shard
                from.skip<T>(at.area());
                continue;
            }
            values.resize(at.area());
            from.get_all(std::span<T>(values));
            for (Strip& strip : strips) lay(at, values, strip);
        }
    }
    for (Strip& strip : strips) {
        if (std::find(strip.known.begin(), strip.known.end(), false) != strip.known.end())
            throw std::logic_error("frames of shards do not cover what lies between them");
        store.add_frame(strip.at, std::move(strip.values));
    }
    return bytes_read;
}

} // namespace fjell::baker
