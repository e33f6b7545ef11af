// A source read whole, and in windows of any kind.
#pragma once

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "baker/georeference/open_source.h"
#include "read_support.h"

namespace fjell::test {

struct Field {
    std::vector<float> heights_m;
    ReadStatistics statistics;
};

inline Field read_whole(const HeightSource& source) {
    Field f;
    f.heights_m.resize(Window{0, 0, source.columns, source.rows}.area());
    source.reader()->read({0, 0, source.columns, source.rows}, f.heights_m.data(), f.statistics);
    return f;
}

// Reads one window of the field; true when it holds the same bits.
inline bool same_bits(HeightReader& reader, const HeightSource& source, const Field& whole, const Window& w,
                      ReadStatistics& statistics) {
    std::vector<float> part(w.area());
    reader.read(w, part.data(), statistics);
    for (int row = 0; row < w.rows; ++row) {
        const float* const expected = whole.heights_m.data() +
                                      static_cast<std::size_t>(w.y + row) * static_cast<std::size_t>(source.columns) +
                                      static_cast<std::size_t>(w.x);
        if (std::memcmp(part.data() + row * w.columns, expected, static_cast<std::size_t>(w.columns) * 4) != 0)
            return false;
    }
    return true;
}

inline bool same(const ReadStatistics& a, const ReadStatistics& b) {
    const auto alike = [](const Tally& x, const Tally& y) {
        return x.count == y.count && (x.count == 0 || (x.column == y.column && x.row == y.row));
    };
    return alike(a.voids, b.voids) && alike(a.implausible, b.implausible) &&
           (a.implausible.count == 0 || a.implausible_m == b.implausible_m) && a.per_unit == b.per_unit &&
           a.least_m == b.least_m && a.most_m == b.most_m;
}

// Windows of several sizes, shuffled, and random ones, all give what one read gives.
inline void check_windows(const HeightSource& source) {
    const Field whole = read_whole(source);
    std::mt19937 random(7);
    for (const std::size_t most : {std::size_t{1}, std::size_t{1000}, std::size_t{70000}, std::size_t{1} << 30}) {
        std::vector<Window> windows = source.windows(most);
        std::size_t area = 0;
        for (const Window& w : windows) area += w.area();
        REQUIRE(area == whole.heights_m.size()); // and all of them inside and right: each sample once
        if (windows.size() > 3000) continue;
        std::shuffle(windows.begin(), windows.end(), random);
        ReadStatistics statistics;
        const auto reader = source.reader();
        int wrong = 0;
        for (const Window& w : windows) {
            ReadStatistics part;
            wrong += !same_bits(*reader, source, whole, w, part);
            statistics.add(part);
        }
        INFO("most " << most << ", per_unit " << statistics.per_unit << " " << whole.statistics.per_unit);
        CHECK(wrong == 0);
        CHECK(same(statistics, whole.statistics));
    }
    const auto reader = source.reader();
    int wrong = 0;
    for (int i = 0; i < 60; ++i) {
        const auto below = [&](std::int32_t n) {
            return static_cast<std::int32_t>(random() % static_cast<unsigned>(n));
        };
        Window w{below(source.columns), below(source.rows), 0, 0};
        w.columns = 1 + below(source.columns - w.x);
        w.rows = 1 + below(source.rows - w.y);
        ReadStatistics unused;
        wrong += !same_bits(*reader, source, whole, w, unused);
    }
    CHECK(wrong == 0);
}

} // namespace fjell::test
