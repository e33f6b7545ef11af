#include "baker/maps/tent.h"

#include <algorithm>
#include <cmath>

#include "shared/compiler.h"

namespace fjell::baker {

double TentAxis::centre(std::int32_t texel) const {
    // One rounding of a quotient of whole numbers: exact where the grids meet, at tiles' borders.
    const double at = static_cast<double>(texel * num) / static_cast<double>(den);
    return std::min(at, last) * scale + shift;
}
double TentAxis::radius() const {
    return std::max(static_cast<double>(num) / static_cast<double>(den) * scale, 1.0);
}
std::int32_t TentAxis::first(std::int32_t texel) const {
    const double low = std::clamp(std::ceil(centre(texel) - radius()), 0.0, size - 1.0);
    return static_cast<std::int32_t>(low);
}
std::int32_t TentAxis::end(std::int32_t texel) const {
    const double high = std::clamp(std::floor(centre(texel) + radius()), 0.0, size - 1.0);
    return std::max(static_cast<std::int32_t>(high), first(texel)) + 1;
}

namespace {

// Weights in doubles, then rounded. A texel past the last pixel by rounding alone has no weight: it takes the nearest.
void weigh(const TentAxis& axis, std::int32_t texel, float* to, std::int32_t skip) {
    const std::int32_t first = axis.first(texel), count = axis.end(texel) - first;
    const double centre = axis.centre(texel), radius = axis.radius();
    const auto weight = [&](std::int32_t k) { return std::max(1 - std::abs(first + k - centre) / radius, 0.0); };
    double sum = 0;
    for (std::int32_t k = 0; k < count; ++k) sum += weight(k);
    for (std::int32_t k = 0; k < count; ++k) to[skip + k] = static_cast<float>(sum > 0 ? weight(k) / sum : 1.0 / count);
}

void find_runs(Taps& t) {
    for (std::int32_t begin = 0; begin < t.count;) {
        const std::int32_t* const first = t.first.data() + begin;
        const std::int32_t left = t.count - begin, stride = left > 1 ? first[1] - first[0] : 1;
        std::int32_t count = 1;
        while (count < left && first[count] - first[count - 1] == stride) ++count;
        t.runs.push_back({begin, count, stride});
        begin += count;
    }
}

} // namespace

Taps make_taps(const TentAxis& axis, std::int32_t first_texel, std::int32_t count) {
    Taps t;
    t.count = count;
    t.source_first = axis.first(first_texel);
    t.source_end = axis.end(first_texel + count - 1);
    for (std::int32_t i = 0; i < count; ++i)
        t.taps = std::max(t.taps, axis.end(first_texel + i) - axis.first(first_texel + i));
    const auto n = static_cast<std::size_t>(count), taps = static_cast<std::size_t>(t.taps);
    t.weights.resize(n * taps);
    t.across.resize(n * taps);
    for (std::size_t i = 0; i < n; ++i) {
        const std::int32_t texel = first_texel + static_cast<std::int32_t>(i);
        // Taps that weigh nothing stay inside the source, too.
        const std::int32_t first = std::min(axis.first(texel), t.source_end - t.taps);
        t.first.push_back(first - t.source_first);
        weigh(axis, texel, t.weights.data() + i * taps, axis.first(texel) - first);
        for (std::size_t k = 0; k < taps; ++k) t.across[k * n + i] = t.weights[i * taps + k];
    }
    find_runs(t);
    return t;
}

namespace {

// Sums of rows: by far the most of the work, and side by side.
FJELL_CLONES void set_row(float* to, const float* from, float weight, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) to[i] = weight * from[i];
}
FJELL_CLONES void add_row(float* to, const float* from, float weight, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) to[i] += weight * from[i];
}
FJELL_CLONES void add_three(float* to, const float* const (&from)[3], const float* weights, std::size_t n) {
    const float *a = from[0], *b = from[1], *c = from[2], u = weights[0], v = weights[1], w = weights[2];
    for (std::size_t i = 0; i < n; ++i) to[i] = u * a[i] + v * b[i] + w * c[i];
}
FJELL_CLONES void add_five(float* to, const float* const (&from)[5], const float* weights, std::size_t n) {
    const float *a = from[0], *b = from[1], *c = from[2], *d = from[3], *e = from[4];
    const float u = weights[0], v = weights[1], w = weights[2], x = weights[3], y = weights[4];
    for (std::size_t i = 0; i < n; ++i) to[i] = u * a[i] + v * b[i] + w * c[i] + x * d[i] + y * e[i];
}

// One tap of a run. A known stride lets the compiler load side by side.
FJELL_CLONES void add_tap_1(float* FJELL_RESTRICT to, const float* FJELL_RESTRICT from, const float* FJELL_RESTRICT w,
                            std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) to[i] += w[i] * from[i];
}
FJELL_CLONES void add_tap_2(float* FJELL_RESTRICT to, const float* FJELL_RESTRICT from, const float* FJELL_RESTRICT w,
                            std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) to[i] += w[i] * from[2 * i];
}
FJELL_CLONES void set_three_1(float* FJELL_RESTRICT to, const float* FJELL_RESTRICT from, const float* FJELL_RESTRICT u,
                              const float* FJELL_RESTRICT v, const float* FJELL_RESTRICT w, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) to[i] = u[i] * from[i] + v[i] * from[i + 1] + w[i] * from[i + 2];
}
// all: weights from tap to tap.
FJELL_CLONES void set_five_2(float* FJELL_RESTRICT to, const float* FJELL_RESTRICT from, const float* FJELL_RESTRICT w,
                             std::size_t all, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const float *const f = from + 2 * i, *const weight = w + i;
        to[i] = weight[0] * f[0] + weight[all] * f[1] + weight[2 * all] * f[2] + weight[3 * all] * f[3] +
                weight[4 * all] * f[4];
    }
}
void add_tap(float* to, const float* from, const float* w, std::size_t n, std::size_t stride) {
    if (stride == 1) return add_tap_1(to, from, w, n);
    if (stride == 2) return add_tap_2(to, from, w, n);
    for (std::size_t i = 0; i < n; ++i) to[i] += w[i] * from[stride * i];
}

void sum_across(const Taps& x, const float* from, float* to) {
    const auto all = static_cast<std::size_t>(x.count);
    for (const Taps::Run& run : x.runs) {
        const auto begin = static_cast<std::size_t>(run.begin), n = static_cast<std::size_t>(run.count);
        const float *at = from + x.first[begin], *w = x.across.data() + begin;
        if (x.taps == 3 && run.stride == 1) {
            set_three_1(to + begin, at, w, w + all, w + 2 * all, n);
            continue;
        }
        if (x.taps == 5 && run.stride == 2) {
            set_five_2(to + begin, at, w, all, n);
            continue;
        }
        std::fill_n(to + begin, n, 0.0f);
        for (std::int32_t k = 0; k < x.taps; ++k, w += all)
            add_tap(to + begin, at + k, w, n, static_cast<std::size_t>(run.stride));
    }
}

} // namespace

TexelPlanes tent_filter(const Taps& x, const Taps& y, const Window& at, RowSource& source, int channels) {
    TexelPlanes out(at, channels);
    const auto width = static_cast<std::size_t>(x.source_end - x.source_first);
    const auto taps = static_cast<std::size_t>(y.taps);
    Buffer<float> sum(width);
    for (std::size_t j = 0; j < static_cast<std::size_t>(y.count); ++j) {
        const float* const weights = y.weights.data() + j * taps;
        const std::int32_t first = y.source_first + y.first[j];
        source.prepare(first, first + y.taps);
        for (int c = 0; c < channels; ++c) {
            if (taps == 3) {
                const float* const rows[3] = {source.row(c, first), source.row(c, first + 1), source.row(c, first + 2)};
                add_three(sum.data(), rows, weights, width);
            } else if (taps == 5) {
                const float* rows[5];
                for (int k = 0; k < 5; ++k) rows[k] = source.row(c, first + k);
                add_five(sum.data(), rows, weights, width);
            } else {
                set_row(sum.data(), source.row(c, first), weights[0], width);
                for (std::size_t k = 1; k < taps; ++k)
                    if (weights[k] != 0)
                        add_row(sum.data(), source.row(c, first + static_cast<std::int32_t>(k)), weights[k], width);
            }
            sum_across(x, sum.data(),
                       out.channel[static_cast<std::size_t>(c)].data() + j * static_cast<std::size_t>(x.count));
        }
    }
    return out;
}

} // namespace fjell::baker
