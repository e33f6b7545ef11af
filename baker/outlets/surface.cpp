#include "baker/outlets/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "baker/heights/fill.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

constexpr float no_ground = std::numeric_limits<float>::quiet_NaN();
constexpr double largest_block = 1.0 / 64; // of a block, in boxes
constexpr double widest_m = 250e3;         // blocks beyond this bend too much to be judged by their corners
constexpr double polar_cap = 89;           // longitudes mean little from here on

} // namespace

GroundSurface::GroundSurface(const HeightSource& source, const std::string& name, const How& how)
    : source_(source), spacing_m_(std::min(source.spacing_m[0], source.spacing_m[1])), places_(source, name) {
    read(how, name);
    for (int level = 1; (std::max(source.columns, source.rows) - 1) >> (level - 1) > 0; ++level) halve(level, how);
}

void GroundSurface::read(const How& how, const std::string& name) {
    const std::uint64_t samples =
        static_cast<std::uint64_t>(source_.columns) * static_cast<std::uint64_t>(source_.rows);
    constexpr std::uint64_t bytes = 12; // heights, filled ones, and ranges
    const std::string prefix = samples * bytes <= how.memory_bytes ? "" : how.folder + "/";
    const auto file = [&](const std::string& of) { return prefix.empty() ? "" : prefix + of; };
    heights_ = Store<float>(file("heights"), source_.columns, source_.rows);
    const std::vector<Window> windows = source_.windows(std::size_t{1} << 20);
    ReadStatistics statistics;
    std::mutex lock;
    std::uint64_t done = 0;
    parallel_for(static_cast<std::int64_t>(windows.size()), source_.readers(how.threads), [&](std::int64_t i) {
        const Window& w = windows[static_cast<std::size_t>(i)];
        std::vector<float> read(w.area());
        ReadStatistics part;
        source_.reader()->read(w, read.data(), part);
        heights_.write(w, read.data(), w.columns);
        const std::lock_guard hold(lock);
        statistics.add(part);
        if (how.progress) how.progress("read", ++done, windows.size());
    });
    const SourceProperties properties = source_.properties(statistics);
    if (statistics.voids.count + statistics.implausible.count > 0) {
        filled_ = Store<float>(file("filled"), source_.columns, source_.rows);
        const auto make = [&](const std::string& level, std::int64_t columns, std::int64_t rows) {
            return Store<float>(file("fill-" + level), columns, rows);
        };
        fill_voids({heights_, {properties.native_quantum_m, properties.anchor_m}, how.threads, make}, filled_);
    }
    for (int level = 1; (std::max(source_.columns, source_.rows) - 1) >> (level - 1) > 0; ++level) {
        const auto size = [&](std::int32_t n) { return ((n - 1) >> level) + 1; };
        ranges_.emplace_back(file("ranges-" + std::to_string(level)), size(source_.columns), size(source_.rows));
    }
    (void)name;
}

void GroundSurface::halve(int level, const How& how) {
    Store<HeightRange>& coarse = ranges_[static_cast<std::size_t>(level) - 1];
    const auto columns = static_cast<std::int32_t>(coarse.columns()), rows = static_cast<std::int32_t>(coarse.rows());
    constexpr std::int32_t band = 64;
    parallel_for((rows + band - 1) / band, how.threads, [&](std::int64_t i) {
        const auto first = static_cast<std::int32_t>(i) * band, count = std::min(band, rows - first);
        std::vector<HeightRange> out(static_cast<std::size_t>(columns) * static_cast<std::size_t>(count),
                                     {no_ground, no_ground});
        const auto put = [&](std::int32_t x, std::int32_t y, float low, float high) {
            HeightRange& r = out[static_cast<std::size_t>(y / 2 - first) * static_cast<std::size_t>(columns) +
                                 static_cast<std::size_t>(x / 2)];
            r = {std::fmin(r.low, low), std::fmax(r.high, high)}; // of a NaN and a number the number
        };
        const auto each = [&](const auto& fine, const auto& low_high) {
            const auto fine_columns = static_cast<std::int32_t>(fine.columns()),
                       fine_rows = std::min(2 * count, static_cast<std::int32_t>(fine.rows()) - 2 * first);
            const StoreView view(fine, Window{0, 2 * first, fine_columns, fine_rows});
            for (std::int32_t y = 0; y < fine_rows; ++y)
                for (std::int32_t x = 0; x < fine_columns; ++x) {
                    const HeightRange r = low_high(view.row(y)[x]);
                    put(x, 2 * first + y, r.low, r.high);
                }
        };
        if (level == 1)
            each(heights_, [](float h) { return HeightRange{h, h}; });
        else
            each(ranges_[static_cast<std::size_t>(level) - 2], [](const HeightRange& r) { return r; });
        coarse.write({0, first, columns, count}, out.data(), columns);
    });
}

HeightRange GroundSurface::range_of(int level, std::int32_t x, std::int32_t y) const {
    if (level == 0) {
        float h = 0;
        heights_.read({x, y, 1, 1}, &h, 1);
        return {h, h};
    }
    HeightRange r;
    ranges_[static_cast<std::size_t>(level) - 1].read({x, y, 1, 1}, &r, 1);
    return r;
}

double GroundSurface::relief_around_m(int level, std::int32_t x, std::int32_t y) const {
    const Store<HeightRange>& ranges = ranges_[static_cast<std::size_t>(level) - 1];
    const auto columns = static_cast<std::int32_t>(ranges.columns()), rows = static_cast<std::int32_t>(ranges.rows());
    HeightRange all{no_ground, no_ground};
    for (std::int32_t j = std::max(0, y - 1); j <= std::min(rows - 1, y + 1); ++j)
        for (std::int32_t i = std::max(0, x - 1); i <= std::min(columns - 1, x + 1); ++i) {
            const HeightRange r = range_of(level, i, j);
            all = {std::fmin(all.low, r.low), std::fmax(all.high, r.high)};
        }
    return static_cast<double>(all.high) - static_cast<double>(all.low);
}

struct GroundSurface::Visit {
    DegreeBox box;
    LonLat middle;
    double tolerance_m;
};

template <typename Take>
bool GroundSurface::visit(const Visit& v, int level, std::int32_t x, std::int32_t y, const Take& take) const {
    const HeightRange range = range_of(level, x, y);
    if (!(range.low <= range.high)) return true;
    const std::int32_t x0 = x << level, y0 = y << level, x1 = std::min(x0 + (1 << level), source_.columns) - 1,
                       y1 = std::min(y0 + (1 << level), source_.rows) - 1;
    const GlobePlace place = places_.at((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    const LonLat at = lon_lat_of(place);
    const double width = v.box.east - v.box.west, height = v.box.north - v.box.south;
    const double longitude = near_longitude(at.longitude, v.middle.longitude);
    const double a = (longitude - v.box.west) / width, b = (at.latitude - v.box.south) / height;
    double da = 0, db = 0;
    bool judged = true;
    if (x0 < x1 || y0 < y1) {
        double reach_m = 0, farthest = std::abs(at.latitude);
        for (const auto& [cx, cy] : {std::pair{x0, y0}, {x1, y0}, {x0, y1}, {x1, y1}}) {
            const GlobePlace corner = places_.at(cx, cy);
            const LonLat c = lon_lat_of(corner);
            reach_m = std::max(reach_m, std::hypot(corner[0] - place[0], corner[1] - place[1], corner[2] - place[2]));
            farthest = std::max(farthest, std::abs(c.latitude));
            da = std::max(da, std::abs(near_longitude(c.longitude, at.longitude) - at.longitude) / width);
            db = std::max(db, std::abs(c.latitude - at.latitude) / height);
        }
        constexpr double bent = 1.1; // edges bulge beyond their corners
        da *= bent, db *= bent;
        judged = reach_m < widest_m && farthest + reach_m / 100e3 < polar_cap;
    }
    constexpr double rounding = 1e-9;
    if (judged && (a + da < -rounding || a - da > 1 + rounding || b + db < -rounding || b - db > 1 + rounding))
        return true;
    const bool one = x0 == x1 && y0 == y1;
    if (one || (judged && da <= largest_block && db <= largest_block && range.high - range.low <= v.tolerance_m &&
                relief_around_m(level, x, y) <= v.tolerance_m))
        return take(a, b, da, db, range, place, at);
    for (int child = 0; child < 4; ++child) {
        const std::int32_t cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1);
        if (cx << (level - 1) >= source_.columns || cy << (level - 1) >= source_.rows) continue;
        if (!visit(v, level - 1, cx, cy, take)) return false;
    }
    return true;
}

void GroundSurface::collect(const DegreeBox& box, double tolerance_m, std::vector<GroundPiece>& ground) const {
    const Visit v{box, box.middle(), tolerance_m};
    const GlobePlace middle = on_globe(v.middle, 0);
    const auto take = [&](double a, double b, double da, double db, const HeightRange& range, const GlobePlace& place,
                          LonLat at) {
        const GlobePlace up = up_at(at);
        ground.push_back({static_cast<float>(a),
                          static_cast<float>(b),
                          static_cast<float>(da),
                          static_cast<float>(db),
                          range.low,
                          range.high,
                          {static_cast<float>(place[0] - middle[0]), static_cast<float>(place[1] - middle[1]),
                           static_cast<float>(place[2] - middle[2])},
                          {static_cast<float>(up[0]), static_cast<float>(up[1]), static_cast<float>(up[2])}});
        return true;
    };
    visit(v, static_cast<int>(ranges_.size()), 0, 0, take);
}

bool GroundSurface::touches(const DegreeBox& box) const {
    // A sample of its own, not a block that may have all of its ground beside the box.
    const Visit v{box, box.middle(), -1};
    return !visit(v, static_cast<int>(ranges_.size()), 0, 0,
                  [](double, double, double, double, const HeightRange&, const GlobePlace&, LonLat) { return false; });
}

double GroundSurface::height_m(const SampleFinder& finder, LonLat at) const {
    double column = 0, row = 0;
    return finder.find(at, column, row) ? height_m(column, row) : 0;
}

double GroundSurface::height_m(double column, double row) const {
    const double x = std::clamp(column, 0.0, source_.columns - 1.0), y = std::clamp(row, 0.0, source_.rows - 1.0);
    const auto left = std::min(static_cast<std::int32_t>(x), source_.columns - 2),
               top = std::min(static_cast<std::int32_t>(y), source_.rows - 2);
    std::array<float, 4> h{};
    (filled_.exists() ? filled_ : heights_).read({left, top, 2, 2}, h.data(), 2);
    const double s = x - left, t = y - top;
    const double height = (1 - t) * ((1 - s) * h[0] + s * h[1]) + t * ((1 - s) * h[2] + s * h[3]);
    // Where a map goes once around the globe its ends are a sample apart.
    const double away = std::hypot((column - x) * source_.spacing_m[0], (row - y) * source_.spacing_m[1]) -
                        1.5 * std::max(source_.spacing_m[0], source_.spacing_m[1]);
    constexpr double slope = 1.0 / 20;
    if (away <= 0 || height == 0) return height;
    return height * std::max(0.0, 1 - away * slope / std::abs(height));
}

} // namespace fjell::baker
