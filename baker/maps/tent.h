// A separable tent filter between grids: from samples to texels, and from one mip's texels to the next one's.
//
// Texel g of an axis stands at a place of the source that follows from g alone; its value is the tent's weighted sum
// over the source there, in one order. So windows may be cut anywhere: what two of them share is equal bit for bit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "baker/read/source.h"
#include "baker/store/memory.h"

namespace fjell::baker {

// One axis: texel g of it stands at min(g * num / den, last) * scale + shift, counted in source pixels.
struct TentAxis {
    std::int64_t num = 1, den = 1;
    double last = 1e18;
    double scale = 1, shift = 0;
    std::int32_t size = 0; // of the source

    [[nodiscard]] double centre(std::int32_t texel) const;
    [[nodiscard]] double radius() const; // as wide as texels are apart, never narrower than the source's own spacing
    // The first source pixel that texel sees, and one past the last: never none.
    [[nodiscard]] std::int32_t first(std::int32_t texel) const;
    [[nodiscard]] std::int32_t end(std::int32_t texel) const;
};

// Weights of a run of texels, each the same number of taps (missing ones weigh 0). A texel's weights add up to 1, also
// where the tent reaches over the source's rim.
struct Taps {
    std::int32_t taps = 0, count = 0;
    std::int32_t source_first = 0, source_end = 0; // what all of them see
    std::vector<std::int32_t> first;               // count, from source_first
    std::vector<float> weights;                    // count * taps
    std::vector<float> across;                     // the same, taps * count
    // Runs of texels whose first pixels lie equally far apart: nearly all of them, because grids are regular.
    struct Run {
        std::int32_t begin, count, stride;
    };
    std::vector<Run> runs;
};
[[nodiscard]] Taps make_taps(const TentAxis& axis, std::int32_t first_texel, std::int32_t count);

// Rows of one or more channels, each of at least source_end - source_first floats.
class RowSource {
public:
    RowSource() = default;
    RowSource(const RowSource&) = delete;
    RowSource& operator=(const RowSource&) = delete;
    virtual ~RowSource() = default;
    // Makes rows [first, end) ready; neither decreases from call to call.
    virtual void prepare(std::int32_t first, std::int32_t end) = 0;
    // The channel's row y, from the source column x.source_first of the filter. Valid until the next prepare.
    [[nodiscard]] virtual const float* row(int channel, std::int32_t y) const = 0;
};

// Channels of a window of texels.
struct TexelPlanes {
    Window at;
    std::vector<Buffer<float>> channel; // not cleared

    TexelPlanes(const Window& window, int channels) : at(window) {
        for (int c = 0; c < channels; ++c) channel.emplace_back(window.area());
    }
    void clear() {
        for (Buffer<float>& values : channel) std::fill(values.begin(), values.end(), 0.0f);
    }
    [[nodiscard]] const float* row(int c, std::int32_t y) const {
        return channel[static_cast<std::size_t>(c)].data() +
               static_cast<std::size_t>(y - at.y) * static_cast<std::size_t>(at.columns);
    }
};

// at: the texels that x and y were made for. O(texels * taps), rows first.
[[nodiscard]] TexelPlanes tent_filter(const Taps& x, const Taps& y, const Window& at, RowSource& source, int channels);

} // namespace fjell::baker
