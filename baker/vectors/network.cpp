#include "baker/vectors/network.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::baker {

namespace {

constexpr std::uint32_t no_station = 0xffff'ffff;

double apart(const Place& a, const Place& b) {
    return std::hypot(b[0] - a[0], b[1] - a[1]);
}

// The part of a side that lies on the terrain, as shares of it (Liang and Barsky); from > to: none.
struct Part {
    double from = 0, to = 1;
};
Part part_within(const Place& a, const Place& b, double width_m, double height_m) {
    Part part;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double most = axis == 0 ? width_m : height_m, by = b[axis] - a[axis];
        if (by == 0) {
            if (a[axis] < 0 || a[axis] > most) return {1, 0};
            continue;
        }
        const double in = -a[axis] / by, out = (most - a[axis]) / by;
        part.from = std::max(part.from, std::min(in, out));
        part.to = std::min(part.to, std::max(in, out));
    }
    return part;
}

// Things by the squares of a grid that they lie in.
class Squares {
public:
    explicit Squares(double side) : side_(side) {}
    [[nodiscard]] std::int32_t at(double v) const { return static_cast<std::int32_t>(std::floor(v / side_)); }
    [[nodiscard]] static std::uint64_t key(std::int32_t x, std::int32_t y) {
        return static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32 | static_cast<std::uint32_t>(x);
    }
    void add(std::int32_t x, std::int32_t y, std::uint32_t thing) { entries_.push_back({key(x, y), thing}); }
    struct Entry {
        std::uint64_t square;
        std::uint32_t thing;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };
    void sort() {
        std::ranges::sort(entries_);
        entries_.erase(std::unique(entries_.begin(), entries_.end()), entries_.end());
    }
    // After sort().
    [[nodiscard]] std::span<const Entry> in(std::int32_t x, std::int32_t y) const {
        const std::uint64_t square = key(x, y);
        return {std::ranges::lower_bound(entries_, square, {}, &Entry::square),
                std::ranges::upper_bound(entries_, square, {}, &Entry::square)};
    }
    // After sort(): work(things of a square, its key), square by square.
    template <typename Work>
    void each(const Work& work) const {
        for (std::size_t i = 0; i < entries_.size();) {
            std::size_t end = i;
            while (end < entries_.size() && entries_[end].square == entries_[i].square) ++end;
            work(std::span(entries_).subspan(i, end - i), entries_[i].square);
            i = end;
        }
    }

private:
    double side_;
    std::vector<Entry> entries_;
};

void drop_unlinked(Network& network) {
    std::vector<std::uint32_t> now(network.stations.size(), no_station);
    std::vector<Place> kept;
    for (Link& link : network.links)
        for (std::uint32_t* const end : {&link.from, &link.to}) {
            if (now[*end] == no_station) {
                now[*end] = static_cast<std::uint32_t>(kept.size());
                kept.push_back(network.stations[*end]);
            }
            *end = now[*end];
        }
    network.stations = std::move(kept);
}

class Making {
public:
    explicit Making(const NetworkOptions& options) : o_(options) {}

    void add(std::uint32_t line, std::span<const Place> places) {
        for (const std::vector<Place>& piece : clipped(places, o_.width_m, o_.height_m)) {
            std::uint32_t last = station(piece[0]);
            for (std::size_t i = 1; i < piece.size(); ++i) {
                const Place from = n_.stations[last], to = piece[i];
                const double length_m = apart(from, to);
                if (length_m < o_.snap_m) continue;
                const double parts = std::ceil(length_m / o_.step_m);
                if (parts > double{most_stations}) refuse();
                for (double k = 1; k <= parts; ++k) {
                    const std::uint32_t next = station(between(from, to, k / parts));
                    n_.links.push_back({last, next, line, length_m / parts});
                    last = next;
                }
            }
        }
    }

    Network finish() {
        merge();
        join();
        std::erase_if(n_.links, [](const Link& l) { return l.from == l.to; });
        const auto ends = [](const Link& l) { return std::pair(l.from, l.to); };
        std::ranges::stable_sort(n_.links, {}, ends);
        const auto same = [&](const Link& a, const Link& b) { return ends(a) == ends(b); };
        n_.links.erase(std::unique(n_.links.begin(), n_.links.end(), same), n_.links.end());
        drop_unlinked(n_);
        return std::move(n_);
    }

private:
    [[noreturn]] static void refuse() {
        throw io::Failure(
            1, fmt::format("the lines are longer than {} samples of the terrain; take some of them", most_stations));
    }
    std::uint32_t station(const Place& at) {
        if (n_.stations.size() == most_stations) refuse();
        n_.stations.push_back(at);
        return static_cast<std::uint32_t>(n_.stations.size() - 1);
    }

    // Stations that are nearer than snap_m become the first of them.
    void merge() {
        Squares squares(o_.snap_m);
        for (std::uint32_t i = 0; i < n_.stations.size(); ++i)
            squares.add(squares.at(n_.stations[i][0]), squares.at(n_.stations[i][1]), i);
        squares.sort();
        std::vector<std::uint32_t> of(n_.stations.size(), no_station);
        for (std::uint32_t i = 0; i < n_.stations.size(); ++i) {
            const Place& at = n_.stations[i];
            const std::int32_t x = squares.at(at[0]), y = squares.at(at[1]);
            double nearest = o_.snap_m;
            of[i] = i;
            for (std::int32_t dy = -1; dy <= 1; ++dy)
                for (std::int32_t dx = -1; dx <= 1; ++dx)
                    for (const auto& [square, j] : squares.in(x + dx, y + dy)) {
                        if (j >= i || of[j] != j || apart(at, n_.stations[j]) >= nearest) continue;
                        nearest = apart(at, n_.stations[j]), of[i] = j;
                    }
        }
        for (Link& link : n_.links) {
            link.from = of[link.from], link.to = of[link.to];
            link.length_m = apart(n_.stations[link.from], n_.stations[link.to]);
        }
        std::erase_if(n_.links, [](const Link& l) { return l.from == l.to; });
    }

    struct Cut {
        std::uint32_t link;
        double share;
        std::uint32_t station;
    };
    // Where two links meet in the inside of one: by a station that is there already, or a new one.
    void cut(std::uint32_t i, std::uint32_t j) {
        const Link a = n_.links[i], b = n_.links[j];
        if (a.from == b.from || a.from == b.to || a.to == b.from || a.to == b.to) return;
        bool touches = false; // each of them is asked, because it joins
        for (const auto& [link, end] : {std::pair{i, b.from}, {i, b.to}, {j, a.from}, {j, a.to}})
            touches = rest_on(link, end) || touches;
        const Place &p = n_.stations[a.from], &q = n_.stations[b.from], &pe = n_.stations[a.to],
                    &qe = n_.stations[b.to];
        const double px = pe[0] - p[0], py = pe[1] - p[1], qx = qe[0] - q[0], qy = qe[1] - q[1],
                     across = px * qy - py * qx;
        if (across == 0) return;
        const double share_a = ((q[0] - p[0]) * qy - (q[1] - p[1]) * qx) / across,
                     share_b = ((q[0] - p[0]) * py - (q[1] - p[1]) * px) / across;
        if (!(share_a > 0 && share_a < 1 && share_b > 0 && share_b < 1)) return;
        const Place crossing = between(p, pe, share_a);
        for (const Place& end : {p, pe, q, qe})
            if (touches && apart(crossing, end) < 2 * o_.snap_m) return; // joined there
        const std::uint32_t both = station(crossing);
        cuts_.push_back({i, share_a, both});
        cuts_.push_back({j, share_b, both});
    }
    bool rest_on(std::uint32_t link, std::uint32_t station) {
        const Place &a = n_.stations[n_.links[link].from], &b = n_.stations[n_.links[link].to],
                    &at = n_.stations[station];
        const double dx = b[0] - a[0], dy = b[1] - a[1],
                     share = ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / (dx * dx + dy * dy);
        if (!(share > 0 && share < 1) || apart(at, between(a, b, share)) >= o_.snap_m) return false;
        cuts_.push_back({link, share, station});
        return true;
    }

    void join() {
        Squares squares(2 * o_.step_m);
        const auto box = [&](const Link& l, std::size_t axis) {
            const auto [least, most] = std::minmax(n_.stations[l.from][axis], n_.stations[l.to][axis]);
            return std::pair(squares.at(least - o_.snap_m), squares.at(most + o_.snap_m));
        };
        for (std::uint32_t i = 0; i < n_.links.size(); ++i) {
            const auto [x0, x1] = box(n_.links[i], 0);
            const auto [y0, y1] = box(n_.links[i], 1);
            for (std::int32_t y = y0; y <= y1; ++y)
                for (std::int32_t x = x0; x <= x1; ++x) squares.add(x, y, i);
        }
        squares.sort();
        squares.each([&](auto links, std::uint64_t square) {
            for (std::size_t i = 0; i < links.size(); ++i)
                for (std::size_t j = i + 1; j < links.size(); ++j) {
                    // In the first square that both lie in, and not again in the others.
                    const Link &a = n_.links[links[i].thing], &b = n_.links[links[j].thing];
                    const std::int32_t x = std::max(box(a, 0).first, box(b, 0).first),
                                       y = std::max(box(a, 1).first, box(b, 1).first);
                    if (Squares::key(x, y) == square) cut(links[i].thing, links[j].thing);
                }
        });
        std::ranges::stable_sort(cuts_, {}, [](const Cut& c) { return std::tuple(c.link, c.share, c.station); });
        for (std::size_t i = 0; i < cuts_.size();) {
            const Link whole = n_.links[cuts_[i].link];
            std::size_t end = i;
            for (; end < cuts_.size() && cuts_[end].link == cuts_[i].link; ++end) {
            }
            std::uint32_t last = whole.from;
            for (std::size_t k = i; k <= end; ++k) {
                const std::uint32_t next = k < end ? cuts_[k].station : whole.to;
                const Link piece{last, next, whole.line, apart(n_.stations[last], n_.stations[next])};
                if (k == i)
                    n_.links[cuts_[i].link] = piece;
                else
                    n_.links.push_back(piece);
                last = next;
            }
            i = end;
        }
    }

    const NetworkOptions& o_;
    Network n_;
    std::vector<Cut> cuts_;
};

} // namespace

void leave_out(Network& network, const std::vector<bool>& gone) {
    std::erase_if(network.links, [&](const Link& l) { return gone[l.from] || gone[l.to]; });
    drop_unlinked(network);
}

std::vector<std::vector<Place>> clipped(std::span<const Place> line, double width_m, double height_m) {
    std::vector<std::vector<Place>> pieces;
    bool goes_on = false; // the last piece ends where the next side begins
    const auto finite = [](const Place& p) { return std::isfinite(p[0]) && std::isfinite(p[1]); };
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Place &a = line[i - 1], &b = line[i];
        const Part part = finite(a) && finite(b) ? part_within(a, b, width_m, height_m) : Part{1, 0};
        if (!(part.from <= part.to)) {
            goes_on = false;
            continue;
        }
        if (!goes_on || part.from > 0) pieces.push_back({between(a, b, part.from)});
        pieces.back().push_back(part.to < 1 ? between(a, b, part.to) : b);
        goes_on = part.to >= 1;
    }
    return pieces;
}

Network make_network(std::span<const std::vector<Place>> lines, const NetworkOptions& options) {
    Making making(options);
    for (std::uint32_t i = 0; i < lines.size(); ++i) making.add(i, lines[i]);
    return making.finish();
}

void near_pairs(const Network& network, double near_m, const std::function<void(const NearPair&)>& found) {
    constexpr std::size_t most_near = 96, most_reached = 512;
    std::vector<std::uint32_t> first(network.stations.size() + 2), beside(2 * network.links.size());
    for (const Link& link : network.links) ++first[link.from + 2], ++first[link.to + 2];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (std::uint32_t i = 0; i < network.links.size(); ++i)
        beside[first[network.links[i].from + 1]++] = i, beside[first[network.links[i].to + 1]++] = i;
    Squares squares(near_m);
    for (std::uint32_t i = 0; i < network.stations.size(); ++i)
        squares.add(squares.at(network.stations[i][0]), squares.at(network.stations[i][1]), i);
    squares.sort();
    // By the network from the station that is looked at, and which stations that is known of.
    std::vector<double> along_m(network.stations.size(), std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < network.stations.size(); ++i) {
        open.assign(1, i);
        along_m[i] = 0;
        for (std::size_t next = 0; next < open.size() && open.size() < most_reached; ++next) {
            const std::uint32_t from = open[next];
            for (std::uint32_t l = first[from]; l < first[from + 1]; ++l) {
                const Link& link = network.links[beside[l]];
                const std::uint32_t to = link.from == from ? link.to : link.from;
                const double to_m = along_m[from] + link.length_m;
                if (to_m > 2 * near_m || along_m[to] <= to_m) continue;
                along_m[to] = to_m;
                open.push_back(to);
            }
        }
        const Place& at = network.stations[i];
        const std::int32_t x = squares.at(at[0]), y = squares.at(at[1]);
        std::size_t count = 0;
        for (std::int32_t dy = -1; dy <= 1; ++dy)
            for (std::int32_t dx = -1; dx <= 1; ++dx)
                for (const auto& [square, j] : squares.in(x + dx, y + dy)) {
                    if (j >= i || count == most_near) break; // they are in order
                    const double distance_m = apart(at, network.stations[j]);
                    if (!(distance_m < near_m && along_m[j] > distance_m * 1.001)) continue;
                    found({i, j, distance_m, along_m[j]});
                    ++count;
                }
        for (const std::uint32_t station : open) along_m[station] = std::numeric_limits<double>::infinity();
    }
}

std::vector<Place> simplified(std::span<const Place> line, double off_m) {
    if (line.size() < 3) return {line.begin(), line.end()};
    std::vector<bool> kept(line.size());
    kept.front() = kept.back() = true;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() - 1}};
    while (!open.empty()) {
        const auto [first, last] = open.back();
        open.pop_back();
        double farthest_m = off_m;
        std::size_t at = 0;
        for (std::size_t i = first + 1; i < last; ++i) {
            const double dx = line[last][0] - line[first][0], dy = line[last][1] - line[first][1],
                         squared = dx * dx + dy * dy;
            const double share =
                squared > 0
                    ? std::clamp(((line[i][0] - line[first][0]) * dx + (line[i][1] - line[first][1]) * dy) / squared,
                                 0.0, 1.0)
                    : 0;
            if (const double off = apart(line[i], between(line[first], line[last], share)); off > farthest_m)
                farthest_m = off, at = i;
        }
        if (at == 0) continue;
        kept[at] = true;
        open.emplace_back(first, at), open.emplace_back(at, last);
    }
    std::vector<Place> few;
    for (std::size_t i = 0; i < line.size(); ++i)
        if (kept[i]) few.push_back(line[i]);
    return few;
}

} // namespace fjell::baker
