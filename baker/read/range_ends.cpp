#include "baker/read/range_ends.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

constexpr std::size_t end_lanes = 8;

// Those that may lie among real heights, and are counted wherever they do.
constexpr std::array<double, 2> undeclared_markers{-9999, -999};

// What programs write where there is no height.
bool is_marker(double number) {
    constexpr std::array<double, 9> known{-99999, -32768, -32767, -10000, -9999, -999, 9999, 32767, 65535};
    return std::abs(number) >= 1e10 || std::find(known.begin(), known.end(), number) != known.end();
}

template <typename T>
FJELL_ALWAYS_INLINE inline std::pair<T, T> range_in_lanes(const T* numbers, std::size_t count) {
    T least[end_lanes], most[end_lanes]; // lanes: see Extremes in decode.cpp
    std::fill_n(least, end_lanes, numbers[0]);
    std::fill_n(most, end_lanes, numbers[0]);
    std::size_t i = 0;
    for (; i + end_lanes <= count; i += end_lanes)
        for (std::size_t k = 0; k < end_lanes; ++k) {
            least[k] = numbers[i + k] < least[k] ? numbers[i + k] : least[k];
            most[k] = numbers[i + k] > most[k] ? numbers[i + k] : most[k];
        }
    for (; i < count; ++i) least[0] = std::min(least[0], numbers[i]), most[0] = std::max(most[0], numbers[i]);
    return {*std::min_element(least, least + end_lanes), *std::max_element(most, most + end_lanes)};
}
FJELL_CLONES std::pair<float, float> range_of(const float* numbers, std::size_t count) {
    return range_in_lanes(numbers, count);
}
FJELL_CLONES std::pair<double, double> range_of(const double* numbers, std::size_t count) {
    return range_in_lanes(numbers, count);
}

} // namespace

void RangeEnds::End::add(const NumberTally& more, double sign) {
    std::size_t at = 0;
    while (at < count && sign * numbers[at].number < sign * more.number) ++at;
    if (at < count && numbers[at].number == more.number) {
        numbers[at].samples.add(more.samples);
        return;
    }
    if (at == kept) return;
    count = std::min(count + 1, kept);
    for (std::size_t i = count - 1; i > at; --i) numbers[i] = numbers[i - 1];
    numbers[at] = more;
}

template <typename T>
void RangeEnds::see_markers(const T* numbers, std::size_t count, const RowPlace& place, double least, double most) {
    for (std::size_t m = 0; m < undeclared_markers.size(); ++m) {
        const double marker = undeclared_markers[m], slack = std::abs(marker) / 100;
        if (marker + slack < least || marker - slack > most) continue;
        const T low = static_cast<T>(marker - slack), high = static_cast<T>(marker + slack),
                exact = static_cast<T>(marker);
        std::uint64_t around = 0;
        for (std::size_t i = 0; i < count; ++i) around += (numbers[i] >= low) & (numbers[i] <= high);
        if (around == 0) continue;
        for (std::size_t i = 0; i < count; ++i) {
            if (numbers[i] != exact) continue;
            markers_[m].exact.add(place.x + static_cast<std::int32_t>(i) * place.step, place.y);
            --around;
        }
        markers_[m].near += around;
    }
}

template <typename T>
void RangeEnds::see_row(const T* numbers, std::size_t count, const RowPlace& place) {
    if (count == 0) return;
    samples_ += count;
    const auto [least, most] = range_of(numbers, count);
    see_markers(numbers, count, place, static_cast<double>(least), static_cast<double>(most));
    const bool low = low_.takes(static_cast<double>(least), 1), high = high_.takes(static_cast<double>(most), -1);
    if (!low && !high) return;
    for (std::size_t i = 0, next = 0; i < count; i = next) {
        const auto number = static_cast<double>(numbers[i]);
        for (next = i + 1; next < count && numbers[next] == numbers[i];) ++next; // seas are long runs
        const std::size_t first = place.step > 0 ? i : next - 1;
        const Tally here{next - i, place.x + static_cast<std::int32_t>(first) * place.step, place.y};
        if (low && low_.takes(number, 1)) low_.add({number, here}, 1);
        if (high && high_.takes(number, -1)) high_.add({number, here}, -1);
    }
}

void RangeEnds::see(const float* numbers, std::size_t count, const RowPlace& place) {
    see_row(numbers, count, place);
}
void RangeEnds::see(const double* numbers, std::size_t count, const RowPlace& place) {
    see_row(numbers, count, place);
}
void RangeEnds::see(double number, std::int32_t x, std::int32_t y) {
    see_row(&number, 1, {x, y, 1});
}

void RangeEnds::add(const RangeEnds& other) {
    for (std::size_t i = 0; i < other.low_.count; ++i) low_.add(other.low_.numbers[i], 1);
    for (std::size_t i = 0; i < other.high_.count; ++i) high_.add(other.high_.numbers[i], -1);
    for (std::size_t m = 0; m < markers_.size(); ++m) {
        markers_[m].exact.add(other.markers_[m].exact);
        markers_[m].near += other.markers_[m].near;
    }
    samples_ += other.samples_;
}

void RangeEnds::move(std::int32_t columns, std::int32_t rows) {
    const auto move_one = [&](Tally& t) { t.column += columns, t.row += rows; };
    for (End* const end : {&low_, &high_})
        for (NumberTally& n : end->numbers) move_one(n.samples);
    for (Marker& m : markers_) move_one(m.exact);
}

// Takes numbers that stand apart off both ends, until none does.
class VoidSearch {
public:
    VoidSearch(const RangeEnds& ends, bool same_scale) : ends_(ends), same_scale_(same_scale) {}

    VoidFindings run() {
        VoidFindings found;
        found.samples = ends_.samples_;
        if (ends_.samples_ == 0) return found;
        while (take_off(low_, ends_.low_, high_, ends_.high_, 1) ||
               take_off(high_, ends_.high_, low_, ends_.low_, -1)) {
        }
        if (everything()) {
            // Nothing else is left: voids and no ground, or one flat field.
            for (std::size_t i = 0; i < ends_.low_.count; ++i)
                if (is_marker(ends_.low_.numbers[i].number)) found.voids.push_back(ends_.low_.numbers[i]);
            return found;
        }
        for (std::size_t i = 0; i < low_; ++i) collect(ends_.low_.numbers[i], found);
        for (std::size_t i = 0; i < high_; ++i) collect(ends_.high_.numbers[i], found);
        found.others = true;
        found.least = ends_.low_.numbers[low_].number;
        found.most = ends_.high_.numbers[high_].number;
        collect_markers(found);
        note(ends_.low_, low_, true, found);
        note(ends_.high_, high_, false, found);
        return found;
    }

private:
    static constexpr std::size_t most_taken = 4; // off one end
    static constexpr std::size_t enough = 8;     // distinct numbers that have a range of their own
    static constexpr std::uint64_t crowd = 16;   // samples with a marker among the rest
    static constexpr double apart = 2, marker_apart = 0.1;

    [[nodiscard]] bool complete() const { return ends_.low_.count < RangeEnds::kept; } // every number is kept
    // Distinct numbers left, or as many as are known.
    [[nodiscard]] std::size_t left() const {
        return ends_.low_.count - std::min(ends_.low_.count, low_ + (complete() ? high_ : 0));
    }
    [[nodiscard]] bool everything() const {
        const auto& n = ends_.low_.numbers;
        return complete() && std::all_of(n.begin(), n.begin() + static_cast<std::ptrdiff_t>(ends_.low_.count),
                                         [](const NumberTally& one) { return is_marker(one.number); });
    }

    // Whether the number before end[i + 1] stands apart from all from there to the other end.
    [[nodiscard]] bool stands_apart(const NumberTally& one, double gap, double range, std::size_t rest) const {
        if (is_marker(one.number)) return gap > marker_apart * std::max(range, std::abs(one.number));
        return same_scale_ && one.samples.count >= 2 && rest >= enough && gap > apart * range;
    }

    // The innermost gap counts: what lies beyond it lies apart too.
    bool take_off(std::size_t& taken, const RangeEnds::End& end, std::size_t other_taken, const RangeEnds::End& other,
                  double sign) const {
        const double far = other.numbers[other_taken].number;
        const std::size_t rest = left();
        for (std::size_t i = std::min(taken + most_taken, end.count - 1); i-- > taken;) {
            const double inner = end.numbers[i + 1].number, gap = sign * (inner - end.numbers[i].number);
            const double range = sign * (far - inner);
            if (range < 0) continue; // beyond what was taken off the other end
            if (!stands_apart(end.numbers[i], gap, range, rest - std::min(rest, i + 1 - taken))) continue;
            taken = i + 1;
            return true;
        }
        return false;
    }

    // One that occurs once and is no marker may be a spire or a shaft.
    static void collect(const NumberTally& one, VoidFindings& found) {
        if (is_marker(one.number) || one.samples.count >= 2) found.voids.push_back(one);
    }

    void collect_markers(VoidFindings& found) const {
        for (std::size_t m = 0; m < undeclared_markers.size(); ++m) {
            const RangeEnds::Marker& marker = ends_.markers_[m];
            const double number = undeclared_markers[m];
            if (number <= found.least || number >= found.most) continue;
            // Others there, one unit with another: whole metres have so many samples each, finer heights fewer.
            const double units = 2 * std::abs(number) / 100, others = static_cast<double>(marker.near) / units;
            if (marker.exact.count >= crowd && static_cast<double>(marker.exact.count) > 16 * others)
                found.voids.push_back({number, marker.exact});
        }
    }

    // The outermost number that is left, when it is shared by many or lies off by a tenth of the range.
    void note(const RangeEnds::End& end, std::size_t taken, bool lowest, VoidFindings& found) const {
        if (left() < enough || taken + 1 >= end.count) return;
        const NumberTally &one = end.numbers[taken], &next = end.numbers[taken + 1];
        const double gap = std::abs(next.number - one.number);
        const bool many = one.samples.count * 100 >= ends_.samples_ && one.samples.count >= 4 * next.samples.count;
        const bool off = same_scale_ && gap > 0.1 * std::abs(found.most - found.least - gap);
        if (one.samples.count >= 2 && (many || off)) found.repeated.push_back({one, lowest});
    }

    const RangeEnds& ends_;
    const bool same_scale_;
    std::size_t low_ = 0, high_ = 0; // taken off
};

std::string number_text(double number) {
    const auto single = static_cast<float>(std::clamp<double>(number, -3e38, 3e38));
    return static_cast<double>(single) == number ? fmt::format("{}", single) : fmt::format("{}", number);
}

VoidFindings find_voids(const RangeEnds& ends, bool same_scale) {
    return VoidSearch(ends, same_scale).run();
}

} // namespace fjell::baker
