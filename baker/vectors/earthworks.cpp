#include "baker/vectors/earthworks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

namespace fjell::baker {

namespace {

std::uint64_t earth_key(std::int32_t x, std::int32_t y) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(y / ground_cell)) << 32 |
           static_cast<std::uint32_t>(x / ground_cell);
}
constexpr float not_changed = std::numeric_limits<float>::quiet_NaN();

// How far a place is from a link, and where on it the nearest one is: a share of its length.
struct OnLink {
    double away_m, share;
};
OnLink on_link(const Place& a, const Place& b, double x, double z) {
    const double dx = b[0] - a[0], dz = b[1] - a[1], squared = dx * dx + dz * dz;
    const double share = squared > 0 ? std::clamp(((x - a[0]) * dx + (z - a[1]) * dz) / squared, 0.0, 1.0) : 0;
    return {std::hypot(x - (a[0] + share * dx), z - (a[1] + share * dz)), share};
}

} // namespace

std::size_t Earthworks::index(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y % ground_cell) * ground_cell + static_cast<std::size_t>(x % ground_cell);
}

Earthworks::Cell& Earthworks::cell_at(std::int32_t x, std::int32_t y) {
    return cells_[earth_key(x, y)];
}

double Earthworks::from_m(const Bed& bed, std::int32_t x, std::int32_t y) const {
    return std::max(std::hypot(x * spacing_m_[0] - bed.nearest[0], y * spacing_m_[1] - bed.nearest[1]) - bed.half_m,
                    0.0);
}

std::vector<std::uint64_t> Earthworks::keys() const {
    std::vector<std::uint64_t> all;
    for (const auto& [key, cell] : cells_) all.push_back(key);
    std::ranges::sort(all);
    return all;
}

// work(x, y) for the samples of the terrain within so many metres of a link.
template <typename Work>
void Earthworks::each_near(const Link& link, double within_m, const Work& work) const {
    const Place &a = network_->stations[link.from], &b = network_->stations[link.to];
    std::array<std::int32_t, 2> first{}, last{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const auto [least, most] = std::minmax(a[axis], b[axis]);
        const std::int32_t end = (axis == 0 ? ground_.columns() : ground_.rows()) - 1;
        first[axis] = std::max(static_cast<std::int32_t>(std::ceil((least - within_m) / spacing_m_[axis])), 0);
        last[axis] = std::min(static_cast<std::int32_t>(std::floor((most + within_m) / spacing_m_[axis])), end);
    }
    for (std::int32_t y = first[1]; y <= last[1]; ++y)
        for (std::int32_t x = first[0]; x <= last[0]; ++x)
            if (const double away_m = on_link(a, b, x * spacing_m_[0], y * spacing_m_[1]).away_m; away_m <= within_m)
                work(x, y, away_m);
}

// Within the half width, and around the cells between where the link crosses columns and rows.
void Earthworks::mark_bed(const Link& link, double half_m) {
    each_near(link, half_m,
              [&](std::int32_t x, std::int32_t y, double) { cell_at(x, y).link[index(x, y)] = any_link; });
    const Place &a = network_->stations[link.from], &b = network_->stations[link.to];
    std::vector<double> shares{0, 1};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double from = a[axis] / spacing_m_[axis], by = b[axis] / spacing_m_[axis] - from;
        const double least = std::min(from, from + by), most = std::max(from, from + by);
        for (double at = std::floor(least) + 1; at < most; ++at) shares.push_back((at - from) / by);
    }
    std::ranges::sort(shares);
    for (std::size_t i = 1; i < shares.size(); ++i) {
        const Place middle = between(a, b, 0.5 * (shares[i - 1] + shares[i]));
        const GroundCells::Sample corner = sample_of(middle);
        for (std::int32_t y = corner.y; y <= std::min(corner.y + 1, ground_.rows() - 1); ++y)
            for (std::int32_t x = corner.x; x <= std::min(corner.x + 1, ground_.columns() - 1); ++x)
                cell_at(x, y).link[index(x, y)] = any_link;
    }
}

void Earthworks::lay(const Network& network, std::span<const double> half_m) {
    network_ = &network;
    for (std::uint32_t link = 0; link < network.links.size(); ++link) mark_bed(network.links[link], half_m[link]);
    // The nearest link of a sample need not be one that has made it bed.
    const double corner_m = std::hypot(spacing_m_[0], spacing_m_[1]);
    for (const double half : half_m) half_m_.push_back(std::max(half, corner_m));
    for (std::uint32_t link = 0; link < network.links.size(); ++link)
        each_near(network.links[link], half_m_[link], [&](std::int32_t x, std::int32_t y, double away_m) {
            Cell& cell = cell_at(x, y);
            const std::size_t i = index(x, y);
            if (cell.link[i] == none || !(away_m < cell.away_m[i])) return;
            cell.away_m[i] = away_m, cell.link[i] = link;
        });
    std::vector<GroundCells::Sample> samples; // with a cell around, for slopes
    for (const std::uint64_t key : keys())
        for (const std::int32_t dy : {-1, 0, 1})
            for (const std::int32_t dx : {-1, 0, 1})
                samples.push_back({(static_cast<std::int32_t>(key & 0xffff'ffff) + dx) * ground_cell,
                                   (static_cast<std::int32_t>(key >> 32) + dy) * ground_cell});
    ground_.load(samples);
}

std::vector<double> Earthworks::lowest_ground_m() {
    std::vector<double> lowest(network_->links.size(), std::numeric_limits<double>::infinity());
    for (const auto& [key, cell] : cells_)
        for (std::int32_t i = 0; i < static_cast<std::int32_t>(area); ++i) {
            const std::uint32_t link = cell.link[static_cast<std::size_t>(i)];
            if (link == none) continue;
            const auto x = static_cast<std::int32_t>(key & 0xffff'ffff) * ground_cell + i % ground_cell,
                       y = static_cast<std::int32_t>(key >> 32) * ground_cell + i / ground_cell;
            if (const double h = ground_.at(x, y); h < lowest[link]) lowest[link] = h;
        }
    return lowest;
}

void Earthworks::make_bed(std::span<const double> heights_m, bool fills) {
    for (const std::uint64_t key : keys()) {
        Cell& cell = cells_.at(key);
        for (std::size_t i = 0; i < area; ++i) {
            if (cell.link[i] == none) continue;
            const auto x = static_cast<std::int32_t>(key & 0xffff'ffff) * ground_cell +
                           static_cast<std::int32_t>(i) % ground_cell,
                       y = static_cast<std::int32_t>(key >> 32) * ground_cell +
                           static_cast<std::int32_t>(i) / ground_cell;
            const double ground_m = ground_.at(x, y);
            if (std::isnan(ground_m)) { // a hole stays one
                cell.link[i] = none;
                continue;
            }
            const Link& l = network_->links[cell.link[i]];
            const Place &from = network_->stations[l.from], &to = network_->stations[l.to];
            const double share = on_link(from, to, x * spacing_m_[0], y * spacing_m_[1]).share;
            const double height_m = heights_m[l.from] + share * (heights_m[l.to] - heights_m[l.from]);
            cell.cut[i] = cell.fill[i] = static_cast<std::uint32_t>(beds_.size());
            beds_.push_back({x, y, fills ? height_m : std::min(height_m, ground_m), between(from, to, share),
                             half_m_[cell.link[i]]});
        }
    }
}

// From the bed on, along ground beyond the cones: each sample learns whose cone is the lowest there (the highest, where
// it fills). As Dijkstra's method goes, but by straight distances.
void Earthworks::spread(bool cuts, double slope, double reach_m) {
    const double sign = cuts ? 1 : -1;
    struct Front {
        double cone_m; // where it fills, upside down
        std::int32_t y, x;
        std::uint32_t bed;
        bool operator>(const Front& o) const { return std::tie(cone_m, y, x) > std::tie(o.cone_m, o.y, o.x); }
    };
    const auto cone_m = [&](std::uint32_t bed, std::int32_t x, std::int32_t y) {
        return sign * beds_[bed].height_m + slope * from_m(beds_[bed], x, y);
    };
    std::priority_queue<Front, std::vector<Front>, std::greater<>> open;
    for (std::uint32_t i = 0; i < beds_.size(); ++i) open.push({sign * beds_[i].height_m, beds_[i].y, beds_[i].x, i});
    while (!open.empty()) {
        const Front at = open.top();
        open.pop();
        const Cell& here = cell_at(at.x, at.y);
        if ((cuts ? here.cut : here.fill)[index(at.x, at.y)] != at.bed) continue; // another cone has come since
        for (std::int32_t y = at.y - 1; y <= at.y + 1; ++y)
            for (std::int32_t x = at.x - 1; x <= at.x + 1; ++x) {
                const float ground_m = ground_.at(x, y);
                if (std::isnan(ground_m) || from_m(beds_[at.bed], x, y) > reach_m) continue;
                Cell& there = cell_at(x, y);
                if (there.link[index(x, y)] != none) continue; // bed
                std::uint32_t& best = (cuts ? there.cut : there.fill)[index(x, y)];
                const double own_m = cone_m(at.bed, x, y);
                if (best != none && cone_m(best, x, y) <= own_m) continue;
                best = at.bed;
                if (sign * static_cast<double>(ground_m) > own_m) open.push({own_m, y, x, at.bed});
            }
    }
}

// NaN: the ground as it is.
double Earthworks::shaped(const Cell& cell, std::int32_t x, std::int32_t y, const EarthworkSlopes& slopes) {
    const std::size_t i = index(x, y);
    const std::uint32_t cut = cell.cut[i], fill = cell.fill[i];
    if (cell.link[i] != none) return beds_[cut].height_m;
    const double ground_m = ground_.at(x, y);
    const double away_cut = cut != none ? from_m(beds_[cut], x, y) : 0,
                 away_fill = fill != none ? from_m(beds_[fill], x, y) : 0;
    const double high = cut != none ? beds_[cut].height_m + slopes.cut * away_cut : ground_m,
                 low = fill != none ? beds_[fill].height_m - slopes.fill * away_fill : ground_m;
    if (!(ground_m > high) && !(ground_m < low)) return not_changed;
    if (cut == none || fill == none || low <= high) return ground_m > high ? high : low;
    // Between a line above and one below, as much steeper as it takes from one bed to the other.
    const double between_m = slopes.fill * away_fill + slopes.cut * away_cut;
    if (!(between_m > 0)) return 0.5 * (beds_[fill].height_m + beds_[cut].height_m);
    const double steeper = (beds_[fill].height_m - beds_[cut].height_m) / between_m;
    return beds_[fill].height_m - steeper * slopes.fill * away_fill;
}

double Earthworks::now_m(std::int32_t x, std::int32_t y) {
    const auto found = cells_.find(earth_key(x, y));
    const float changed_m = found != cells_.end() ? found->second.height_m[index(x, y)] : not_changed;
    return static_cast<double>(std::isnan(changed_m) ? ground_.at(x, y) : changed_m);
}

void Earthworks::account(std::int32_t x, std::int32_t y, const EarthworkSlopes& slopes, EarthworkSummary& summary) {
    const double ground_m = ground_.at(x, y), height_m = now_m(x, y), by_m = height_m - ground_m;
    const double column_m2 = spacing_m_[0] * spacing_m_[1];
    (by_m < 0 ? summary.cut_m3 : summary.fill_m3) += std::abs(by_m) * column_m2;
    summary.deepest_cut_m = std::max(summary.deepest_cut_m, -by_m);
    summary.highest_fill_m = std::max(summary.highest_fill_m, by_m);
    ++summary.samples;
    const double asked = slopes.fills ? std::max(slopes.cut, slopes.fill) : slopes.cut;
    const auto is_steep = [&](std::int32_t x1, std::int32_t y1) {
        if (x1 < 0 || y1 < 0 || x1 >= ground_.columns() || y1 >= ground_.rows()) return false;
        const double there_m = ground_.at(x1, y1), away_m = x1 != x ? spacing_m_[0] : spacing_m_[1];
        constexpr double rounding_m = 1e-3; // of single precision, and of cones that come by eight ways
        return std::abs(now_m(x1, y1) - height_m) > std::max(asked * away_m, std::abs(there_m - ground_m)) + rounding_m;
    };
    summary.steep += is_steep(x - 1, y) || is_steep(x + 1, y) || is_steep(x, y - 1) || is_steep(x, y + 1);
}

std::vector<io::KeptStamp> Earthworks::shape(std::span<const double> heights_m, const EarthworkSlopes& slopes,
                                             EarthworkSummary& summary) {
    make_bed(heights_m, slopes.fills);
    spread(true, slopes.cut, slopes.reach_m);
    if (slopes.fills) spread(false, slopes.fill, slopes.reach_m);
    const std::vector<std::uint64_t> all = keys();
    const auto each = [&](std::uint64_t key, const auto& work) {
        const std::int32_t x0 = static_cast<std::int32_t>(key & 0xffff'ffff) * ground_cell,
                           y0 = static_cast<std::int32_t>(key >> 32) * ground_cell;
        for (std::int32_t y = y0; y < std::min(y0 + ground_cell, ground_.rows()); ++y)
            for (std::int32_t x = x0; x < std::min(x0 + ground_cell, ground_.columns()); ++x) work(x, y);
    };
    for (const std::uint64_t key : all) {
        Cell& cell = cells_.at(key);
        std::vector<float> made(area, not_changed);
        each(key, [&](std::int32_t x, std::int32_t y) {
            made[index(x, y)] = static_cast<float>(shaped(cell, x, y, slopes));
        });
        cell.height_m = std::move(made);
    }
    std::vector<io::KeptStamp> stamps;
    for (const std::uint64_t key : all) {
        const std::vector<float>& made = cells_.at(key).height_m;
        std::int32_t x0 = ground_.columns(), x1 = -1, y0 = ground_.rows(), y1 = -1;
        each(key, [&](std::int32_t x, std::int32_t y) {
            if (std::isnan(made[index(x, y)])) return;
            x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
            account(x, y, slopes, summary);
        });
        if (x1 < x0) continue;
        io::KeptStamp& stamp = stamps.emplace_back();
        stamp.plain.shape = StampShape::heights;
        stamp.plain.first = {x0, y0};
        stamp.plain.columns = x1 - x0 + 1, stamp.plain.rows = y1 - y0 + 1;
        for (std::int32_t y = y0; y <= y1; ++y)
            for (std::int32_t x = x0; x <= x1; ++x) stamp.heights_m.push_back(made[index(x, y)]);
    }
    return stamps;
}

} // namespace fjell::baker
