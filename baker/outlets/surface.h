// A terrain's ground on the globe: heights anywhere, and what lies in a rectangle of degrees, coarse where the ground
// is flat.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/outlets/globe.h"
#include "baker/store/store.h"

namespace fjell::baker {

struct HeightRange {
    float low = 0, high = 0; // NaN: no ground
};

// Ground in a tile: a sample, or a block of them as a rectangle and a range of heights. Any mesh that is nowhere
// farther than e from the whole of it is nowhere farther than e from its samples.
struct GroundPiece {
    float u, v;      // its middle: 0 to 1 from west to east and from south to north
    float du, dv;    // half of its size; 0: a sample
    float low, high; // metres
    float place[3];  // of its middle at height 0, from the tile's, in metres
    float up[3];     // there
};

// Heights of a field, out of core where they do not fit the memory, with the range of each 2^k x 2^k of them.
// Immutable once it is made; any thread.
class GroundSurface {
public:
    struct How {
        std::string folder; // for what does not fit
        std::uint64_t memory_bytes = 0;
        int threads = 1;
        Progress progress;
    };
    // Throws Failure: 1 the source, 3 the disk.
    GroundSurface(const HeightSource& source, const std::string& name, const How& how);

    // The ground in a box, border included. tolerance_m: blocks, with their surroundings, have no more relief than
    // this, and are no larger than 1/64 of the box; of steeper ground come the samples themselves.
    void collect(const DegreeBox& box, double tolerance_m, std::vector<GroundPiece>& ground) const;
    // Is there a sample in it?
    [[nodiscard]] bool touches(const DegreeBox& box) const;
    // Bilinear between samples. Holes are filled as a bake's --void fill does. Beyond the rim the ground sinks or
    // rises to height 0 on a slope of 1 : 20, so that a globe is not raised by the height of a field's rim.
    [[nodiscard]] double height_m(const SampleFinder& finder, LonLat at) const;
    [[nodiscard]] double height_m(double column, double row) const;

    [[nodiscard]] const HeightSource& source() const { return source_; }
    [[nodiscard]] double spacing_m() const { return spacing_m_; } // the smaller one
    [[nodiscard]] HeightRange range() const { return range_of(static_cast<int>(ranges_.size()), 0, 0); }

private:
    struct Visit;
    void read(const How& how, const std::string& name);
    void halve(int level, const How& how);
    void fill(const How& how, const SourceProperties& properties);
    [[nodiscard]] HeightRange range_of(int level, std::int32_t x, std::int32_t y) const;
    // Of a block and the eight around it: what a small triangle that touches its rectangle may have for heights.
    [[nodiscard]] double relief_around_m(int level, std::int32_t x, std::int32_t y) const;
    // False: it was stopped.
    template <typename Take>
    bool visit(const Visit& v, int level, std::int32_t x, std::int32_t y, const Take& take) const;

    const HeightSource& source_;
    double spacing_m_;
    SamplePlaces places_;
    Store<float> heights_, filled_;          // NaN in holes; filled: nothing where there are none
    std::vector<Store<HeightRange>> ranges_; // of 2 x 2, 4 x 4, ... samples, up to one of all
};

} // namespace fjell::baker
