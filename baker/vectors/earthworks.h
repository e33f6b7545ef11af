// Ground along a network: its bed where the lines run, and slopes from there to the ground as it was.
//
// The *bed* is made of the samples within a line's half width, and of the corners of all cells that the line crosses,
// so that it has no gap where samples lie wider apart than the line is wide. Each has the height of the nearest place
// on a line. From the bed on, ground that is higher than a cone of the cut slope comes down to it, until the cone
// leaves the ground; ground that is lower than a cone of the fill slope is raised in the same way. So no slope is
// steeper than asked, nor than the ground was there, but where lines of two heights lie side by side, or where a slope
// reaches its limit: EarthworkSummary::steep counts these.
//
// O(samples changed * log); memory: 28 bytes a sample of the cells that are changed. Deterministic. Failure: Failure 1
// as ground_cells.h has it.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "baker/vectors/ground_cells.h"
#include "baker/vectors/network.h"
#include "fjell/io/journal.h"

namespace fjell::baker {

struct EarthworkSlopes {
    double cut = 1, fill = 0.67; // metres up a metre
    bool fills = true;           // false: ground is only taken away, in the bed too
    double reach_m = 100;        // a slope goes on no farther
};

struct EarthworkSummary {
    double cut_m3 = 0, fill_m3 = 0;
    double deepest_cut_m = 0, highest_fill_m = 0;
    std::uint64_t samples = 0; // changed
    std::uint64_t steep = 0;   // of them, those beside which ground is steeper than asked
};

class Earthworks {
public:
    Earthworks(const HeightSource& source, const std::string& name)
        : ground_(source, name), spacing_m_{source.spacing_m[0], source.spacing_m[1]} {}

    [[nodiscard]] GroundCells& ground() { return ground_; }
    // Of a place on the terrain. NaN: beside a hole.
    [[nodiscard]] double ground_m(const Place& at) {
        return ground_.between(at[0] / spacing_m_[0], at[1] / spacing_m_[1]);
    }
    [[nodiscard]] GroundCells::Sample sample_of(const Place& at) const {
        return {static_cast<std::int32_t>(at[0] / spacing_m_[0]), static_cast<std::int32_t>(at[1] / spacing_m_[1])};
    }
    // Once. half_m: of each link.
    void lay(const Network& network, std::span<const double> half_m);
    // Of each link: the lowest ground of those samples of the bed that are nearest to it; infinite: of none.
    [[nodiscard]] std::vector<double> lowest_ground_m();
    // Stamps of shape `heights`, a cell each, in order. heights_m: of each station.
    [[nodiscard]] std::vector<io::KeptStamp> shape(std::span<const double> heights_m, const EarthworkSlopes& slopes,
                                                   EarthworkSummary& summary);

private:
    static constexpr std::uint32_t none = 0xffff'ffff, any_link = none - 1; // any_link: not known yet which
    static constexpr std::size_t area = std::size_t{ground_cell} * ground_cell;
    struct Cell {
        std::vector<double> away_m = std::vector<double>(area, std::numeric_limits<double>::infinity()); // of the bed
        std::vector<float> height_m; // in the end; NaN: as it is
        std::vector<std::uint32_t> link = std::vector<std::uint32_t>(area, none);
        // Whose cone lies lowest there, and highest: of `beds_`.
        std::vector<std::uint32_t> cut = std::vector<std::uint32_t>(area, none),
                                   fill = std::vector<std::uint32_t>(area, none);
    };
    struct Bed {
        std::int32_t x, y;
        double height_m;
        // Its nearest place on a line, and how far the bed reaches from there: what slopes begin at. Slopes from
        // samples would have a rib for each of them.
        Place nearest;
        double half_m;
    };
    [[nodiscard]] Cell& cell_at(std::int32_t x, std::int32_t y);
    [[nodiscard]] static std::size_t index(std::int32_t x, std::int32_t y);
    [[nodiscard]] double from_m(const Bed& bed, std::int32_t x, std::int32_t y) const;
    template <typename Work>
    void each_near(const Link& link, double within_m, const Work& work) const;
    void mark_bed(const Link& link, double half_m);
    void make_bed(std::span<const double> heights_m, bool fills);
    void spread(bool cuts, double slope, double reach_m);
    [[nodiscard]] double shaped(const Cell& cell, std::int32_t x, std::int32_t y, const EarthworkSlopes& slopes);
    void account(std::int32_t x, std::int32_t y, const EarthworkSlopes& slopes, EarthworkSummary& summary);
    [[nodiscard]] std::vector<std::uint64_t> keys() const;
    [[nodiscard]] double now_m(std::int32_t x, std::int32_t y);

    GroundCells ground_;
    double spacing_m_[2];
    const Network* network_ = nullptr;
    std::vector<double> half_m_; // of each link, and no less than the corners of cells that it crosses are away
    std::unordered_map<std::uint64_t, Cell> cells_;
    std::vector<Bed> beds_;
};

} // namespace fjell::baker
