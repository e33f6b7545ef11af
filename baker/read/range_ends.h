// The lowest and the highest numbers of a source, each with how often and where it occurs, and counts of the numbers
// that programs write where there is no height. Undeclared voids show in them: numbers that repeat and stand apart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

namespace fjell::baker {

// How many samples are of one kind, and where the first of them is.

// Samples of one kind, and the first of them in reading order.
struct Tally {
    std::uint64_t count = 0;
    std::int32_t column = 0, row = 0;

    void add(std::int32_t x, std::int32_t y) { add(Tally{1, x, y}); }
    void add(const Tally& other) {
        if (other.count == 0) return;
        if (count == 0 || std::tie(other.row, other.column) < std::tie(row, column))
            column = other.column, row = other.row;
        count += other.count;
    }
};

// Where sample i of a row stands: (x + i * step, y).
struct RowPlace {
    std::int32_t x = 0, y = 0, step = 1;
};

// A number as the file has it, and the samples that have it.
struct NumberTally {
    double number = 0;
    Tally samples;
};

// Fixed memory, whatever is counted. Counting in any order and adding up gives the same: a number that is among the
// lowest of all is among the lowest of every part that has it.
class RangeEnds {
public:
    static constexpr std::size_t kept = 16; // distinct numbers at each end

    // The numbers of a row from place on; no NaN. O(count), vectorised where no number is among those kept.
    void see(const float* numbers, std::size_t count, const RowPlace& place);
    void see(const double* numbers, std::size_t count, const RowPlace& place);
    void see(double number, std::int32_t x, std::int32_t y);
    void add(const RangeEnds& other);
    void move(std::int32_t columns, std::int32_t rows); // all places

private:
    friend class VoidSearch;
    struct End { // the first is the outermost; sign 1: the lowest, -1: the highest
        std::array<NumberTally, kept> numbers;
        std::size_t count = 0;
        void add(const NumberTally& more, double sign);
        [[nodiscard]] bool takes(double number, double sign) const {
            return count < kept || sign * number <= sign * numbers[kept - 1].number;
        }
    };
    struct Marker {
        Tally exact;
        std::uint64_t near = 0; // within a hundredth, itself not counted
    };
    template <typename T>
    void see_row(const T* numbers, std::size_t count, const RowPlace& place);
    template <typename T>
    void see_markers(const T* numbers, std::size_t count, const RowPlace& place, double least, double most);

    End low_, high_;
    std::array<Marker, 2> markers_; // of undeclared_markers
    std::uint64_t samples_ = 0;
};

// A number that may be ground, but that many samples share at an end of the heights.
struct Repeated {
    NumberTally at;
    bool lowest = false; // or the highest
};

struct VoidFindings {
    std::vector<NumberTally> voids; // look like voids: the user has to decide
    std::vector<Repeated> repeated; // may be ground: worth a line
    bool others = false;            // there are other numbers
    double least = 0, most = 0;     // of those
    std::uint64_t samples = 0;      // that were counted
};

// What stands out. A number looks like a void when
// - it is one that programs write for "no height" (-9999, -32768, ...) and lies apart from the rest by a tenth of their
//   range and of itself, or lies among the rest, but occurs sixteen times as often as the others
//   within a hundredth of it do, unit by unit;
// - it is any number, repeats, and lies apart from the rest by twice their range, which has eight numbers at least.
// same_scale: all numbers are on one scale; otherwise distances between them mean nothing, and only the first holds.
[[nodiscard]] VoidFindings find_voids(const RangeEnds& ends, bool same_scale);

// The shortest text that is read as this number again, by a float if it is one.
[[nodiscard]] std::string number_text(double number);

} // namespace fjell::baker
