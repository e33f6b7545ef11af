#include "baker/errors/step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "shared/compiler.h"
#include "shared/order.h"

namespace fjell::baker {

FinerCentres::FinerCentres(std::int32_t nx, std::int32_t ny) : stride(2 * (nx + reach + 2)) {
    const std::size_t count = static_cast<std::size_t>(stride) * static_cast<std::size_t>(2 * (ny + reach + 2));
    steps.resize(count);
    error.resize(count);
    radius_m.resize(count);
}

// ---- errors --------------------------------------------------------------------------------------------------------

namespace {

// |2 h - a - b| to codes, a row at a time: jumps in vector code, look-ups one by one.
FJELL_ALWAYS_INLINE inline void look_up(const LeafErrors& leaf, const std::int32_t* h, const std::int32_t* a,
                                        const std::int32_t* b, std::int32_t count, std::uint8_t* to) {
    constexpr std::int32_t piece = 256;
    std::uint32_t jump[piece];
    const std::uint8_t* const table = leaf.table();
    for (std::int32_t from = 0; from < count; from += piece) {
        const std::int32_t n = std::min(piece, count - from);
        std::uint32_t all = 0;
        for (std::int32_t k = 0; k < n; ++k) {
            const std::int32_t i = from + k;
            jump[k] = static_cast<std::uint32_t>(std::abs(2 * h[i] - a[i] - b[i]));
            all |= jump[k];
        }
        if (all < LeafErrors::table_size)
            for (std::int32_t k = 0; k < n; ++k) to[from + k] = table[jump[k]];
        else
            for (std::int32_t k = 0; k < n; ++k) to[from + k] = leaf.code(jump[k]);
    }
}

// Every second square of a row of centres is cut the other way: first falling, where `odd` is 0.
FJELL_ALWAYS_INLINE inline void diagonals(const std::int32_t* north, const std::int32_t* south, std::int32_t count,
                                          std::int32_t odd, bool root, std::int32_t* a, std::int32_t* b) {
    for (std::int32_t i = 0; i < count; ++i) {
        const std::int32_t rising = root ? 0 : -((i + odd) & 1);
        a[i] = (north[i] & ~rising) | (north[i + 1] & rising);
        b[i] = (south[i + 1] & ~rising) | (south[i] & rising);
    }
}

FJELL_CLONES void leaf_rows(const StepInput& in, const LeafErrors& leaf) {
    const VertexPlanes<std::int32_t>& h = in.steps;
    std::vector<std::int32_t> a(static_cast<std::size_t>(in.nx)), b(a.size());
    for (std::int32_t j = 0; j <= in.ny; ++j) {
        const std::int32_t* const north = h.corner.row(j);
        const std::int32_t* const south = h.corner.row(j + 1);
        look_up(leaf, h.side_x.row(j), north, north + 1, in.nx, in.error.side_x.row(j));
        if (j == in.ny) break;
        look_up(leaf, h.side_y.row(j), north, south, in.nx + 1, in.error.side_y.row(j));
        diagonals(north, south, in.nx, (in.square.column + in.square.row + j) & 1, in.z == in.tree.tile_log2 - 1,
                  a.data(), b.data());
        look_up(leaf, h.centre.row(j), a.data(), b.data(), in.nx, in.error.centre.row(j));
    }
}

// own: raised to what children ask for. Codes never reach 256: the scale was chosen so.
FJELL_ALWAYS_INLINE inline std::uint8_t raised(std::uint8_t own, std::uint8_t child, std::uint8_t nesting) {
    const auto asked = static_cast<std::uint8_t>(child == 0 ? 0 : child + nesting);
    return asked > own ? asked : own;
}
FJELL_ALWAYS_INLINE inline std::uint8_t larger(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}

FJELL_ALWAYS_INLINE inline void climb_sides(const StepInput& in, std::uint8_t nesting) {
    const FinerCentres& f = *in.finer;
    for (std::int32_t j = 0; j <= in.ny; ++j) {
        const std::uint8_t* const north = f.error.data() + f.row(2 * j - 1);
        const std::uint8_t* const south = f.error.data() + f.row(2 * j);
        std::uint8_t* const to = in.error.side_x.row(j);
        for (std::int32_t i = 0; i < in.nx; ++i)
            to[i] = raised(
                to[i], larger(larger(north[2 * i], north[2 * i + 1]), larger(south[2 * i], south[2 * i + 1])), nesting);
    }
    for (std::int32_t j = 0; j < in.ny; ++j) {
        const std::uint8_t* const north = f.error.data() + f.row(2 * j);
        const std::uint8_t* const south = f.error.data() + f.row(2 * j + 1);
        std::uint8_t* const to = in.error.side_y.row(j);
        for (std::int32_t i = 0; i <= in.nx; ++i)
            to[i] = raised(
                to[i], larger(larger(north[2 * i - 1], north[2 * i]), larger(south[2 * i - 1], south[2 * i])), nesting);
    }
}

FJELL_CLONES void climb(const StepInput& in) {
    const auto nesting = static_cast<std::uint8_t>(in.scales.nesting_steps);
    if (in.finer) climb_sides(in, nesting);
    for (std::int32_t j = 0; j < in.ny; ++j) {
        const std::uint8_t* const north = in.error.side_x.row(j);
        const std::uint8_t* const south = in.error.side_x.row(j + 1);
        const std::uint8_t* const side_y = in.error.side_y.row(j);
        std::uint8_t* const to = in.error.centre.row(j);
        for (std::int32_t i = 0; i < in.nx; ++i)
            to[i] = raised(to[i], larger(larger(north[i], south[i]), larger(side_y[i], side_y[i + 1])), nesting);
    }
}

} // namespace

void leaf_errors(const StepInput& input, const LeafErrors& leaf) {
    leaf_rows(input, leaf);
}

void saturate_errors(const StepInput& input) {
    climb(input);
}

// ---- radii ---------------------------------------------------------------------------------------------------------

namespace {

// Distances are found in float from whole differences of heights, and rounded up by more than that loses
// (radius_rounding). A block's radius is the largest of its vertices'; where the other terms are one block's, that of
// the largest difference: floats round alike, so larger differences never come out with smaller radii, and one root a
// block will do.

// Largest differences of a row of squares, over the rows of its blocks.
struct Differences {
    Buffer<std::int32_t> most;
    void clear(std::int32_t count) { most.assign(static_cast<std::size_t>(count), 0); }
    // To a or b, the larger.
    FJELL_ALWAYS_INLINE void see(const std::int32_t* h, const std::int32_t* a, const std::int32_t* b) {
        std::int32_t* const to = most.data();
        for (std::size_t i = 0; i < most.size(); ++i) {
            const std::int32_t p = std::abs(a[i] - h[i]), q = std::abs(b[i] - h[i]), r = p > q ? p : q;
            to[i] = r > to[i] ? r : to[i];
        }
    }
    FJELL_ALWAYS_INLINE void see(const std::int32_t* h, const std::int32_t* a) { see(h, a, a); }
    [[nodiscard]] FJELL_ALWAYS_INLINE std::int32_t of(std::int32_t first, std::int32_t count) const {
        std::int32_t largest = 0;
        for (std::int32_t i = first; i < first + count; ++i)
            largest = std::max(largest, most[static_cast<std::size_t>(i)]);
        return largest;
    }
};

class RadiusStage {
public:
    RadiusStage(const StepInput& input, Radii& radii) : in(input), out(radii) {
        const double s = 1 << in.z;
        const Scales& scales = in.scales;
        quantum = scales.height_scale.quantum_m;
        height_pad = static_cast<float>(scales.height_pad_m);
        const auto ground = [&](double x, double y) {
            const double dx = x * in.spacing_m[0] + 2 * scales.ground_pad_m,
                         dy = y * in.spacing_m[1] + 2 * scales.ground_pad_m;
            return static_cast<float>(dx * dx * (x != 0) + dy * dy * (y != 0));
        };
        along_x = ground(s, 0);
        along_y = ground(0, s);
        across = ground(s / 2, s / 2);
        leaf_pad = static_cast<float>(scales.half_quantum_m);
        out.shift = in.tree.tile_log2 - 1 - in.z >= page_squares_log2 ? radius_squares_log2 : 0;
        out.blocks_x = in.nx >> out.shift;
        out.blocks_y = in.ny >> out.shift;
        size = 1 << out.shift;
    }

    FJELL_ALWAYS_INLINE void run() {
        const int side_level = 2 * (in.tree.tile_log2 - 1 - in.z) + 1;
        for (std::size_t code = 0; code < radius_codes; ++code) {
            side_m[code] = in.scales.level_radius_m[side_level] * in.scales.radii.factor[code];
            centre_m[code] = in.scales.level_radius_m[side_level - 1] * in.scales.radii.factor[code];
        }
        sides(out.side_x, out.blocks_x, out.blocks_y + 1, [&](std::int32_t j) FJELL_ALWAYS_INLINE_LAMBDA {
            in.finer ? side_row(in.steps.side_x.row(j), in.finer->row(2 * j - 1), in.finer->row(2 * j)) : leaf_x_row(j);
        });
        sides(out.side_y, out.blocks_x + 1, out.blocks_y, [&](std::int32_t j) FJELL_ALWAYS_INLINE_LAMBDA {
            in.finer ? side_row(in.steps.side_y.row(j), in.finer->row(2 * j) - 1, in.finer->row(2 * j + 1) - 1)
                     : leaf_y_row(j);
        });
        out.centre.clear();
        for (std::int32_t block = 0; block < out.blocks_y; ++block) centre_blocks(block);
    }

private:
    // Codes of the blocks of a plane of sides, whose rows row(j) adds to the line or to the differences. Rows and
    // columns beyond the region's last square belong to blocks that it shares with the next region.
    template <typename Row>
    FJELL_ALWAYS_INLINE void sides(std::vector<std::uint8_t>& to, std::int32_t blocks, std::int32_t block_rows,
                                   const Row& row) {
        to.clear();
        for (std::int32_t block_row = 0; block_row < block_rows; ++block_row) {
            if (in.finer) {
                line.assign(static_cast<std::size_t>(blocks * size), 0.0f);
            } else {
                ends.clear(blocks * size);
                apexes.clear(blocks * size);
            }
            for (std::int32_t j = block_row * size; j < (block_row + 1) * size; ++j) row(j);
            for (std::int32_t b = 0; b < blocks; ++b) to.push_back(code_up(side_m, in.finer ? along(b) : leaf(b)));
        }
    }
    using CodedRadii = std::array<float, radius_codes>; // in metres, of a level
    // RadiusScale::code_up with room for a sphere's rounding; without a branch, because none could be predicted.
    [[nodiscard]] FJELL_ALWAYS_INLINE static std::uint8_t code_up(const CodedRadii& radii_m, float radius_m) {
        const double asked_m = static_cast<double>(radius_m) * sphere_margin;
        std::uint32_t below = 0; // how many codes are
        for (std::uint32_t step = radius_codes / 2; step != 0; step /= 2)
            below += step * static_cast<std::uint32_t>(static_cast<double>(radii_m[below + step - 1]) < asked_m);
        return static_cast<std::uint8_t>(below);
    }

    [[nodiscard]] FJELL_ALWAYS_INLINE float climb_m(std::int32_t steps) const {
        return static_cast<float>(steps) * quantum + height_pad;
    }
    [[nodiscard]] FJELL_ALWAYS_INLINE float distance_m(float ground, std::int32_t steps) const {
        const float climb = climb_m(steps);
        return std::sqrt(ground + climb * climb);
    }

    // A leaf's sphere holds the corners of its triangles: the ends of its side and the centres beside it.
    FJELL_ALWAYS_INLINE void leaf_x_row(std::int32_t j) {
        const auto& h = in.steps;
        const std::int32_t* const corners = h.corner.row(j);
        ends.see(h.side_x.row(j), corners, corners + 1);
        apexes.see(h.side_x.row(j), h.centre.row(j - 1), h.centre.row(j));
        ends_ground = along_x, apexes_ground = along_y;
    }
    FJELL_ALWAYS_INLINE void leaf_y_row(std::int32_t j) {
        const auto& h = in.steps;
        const std::int32_t* const centres = h.centre.row(j);
        ends.see(h.side_y.row(j), h.corner.row(j), h.corner.row(j + 1));
        apexes.see(h.side_y.row(j), centres - 1, centres);
        ends_ground = along_y, apexes_ground = along_x;
    }
    [[nodiscard]] FJELL_ALWAYS_INLINE float leaf(std::int32_t block) const {
        const float end = distance_m(ends_ground, ends.of(block * size, size)),
                    apex = distance_m(apexes_ground, apexes.of(block * size, size));
        return (std::max(end, apex) + leaf_pad) * radius_rounding;
    }

    // Over two rows of finer centres, two of them each: (2 i + first) and the next. Each has a radius of its own.
    FJELL_ALWAYS_INLINE void side_row(const std::int32_t* h, std::size_t north, std::size_t south) {
        const FinerCentres& f = *in.finer;
        const auto count = static_cast<std::int32_t>(line.size());
        float* const to = line.data();
        for (const std::size_t row : {north, south}) {
            const std::int32_t* const steps = f.steps.data() + row;
            const float* const radius = f.radius_m.data() + row;
            for (std::int32_t i = 0; i < count; ++i) {
                const float a = distance_m(across, std::abs(steps[2 * i] - h[i])) + radius[2 * i];
                const float b = distance_m(across, std::abs(steps[2 * i + 1] - h[i])) + radius[2 * i + 1];
                const float most = (a > b ? a : b) * radius_rounding;
                to[i] = most > to[i] ? most : to[i];
            }
        }
    }
    [[nodiscard]] FJELL_ALWAYS_INLINE float along(std::int32_t block) const {
        float most = 0;
        for (std::int32_t i = block * size; i < (block + 1) * size; ++i)
            most = std::max(most, line[static_cast<std::size_t>(i)]);
        return most;
    }

    // A centre's children are the four sides of its square. All northern ones of a block have one radius, and all
    // southern ones but those of its last row the same; its western and eastern ones likewise.
    FJELL_ALWAYS_INLINE void centre_blocks(std::int32_t block_row) {
        const auto& steps = in.steps;
        for (Differences* const d : {&to_north, &to_south, &to_west, &to_east}) d->clear(in.nx);
        const std::int32_t last = (block_row + 1) * size - 1;
        for (std::int32_t j = block_row * size; j <= last; ++j) {
            const std::int32_t* const h = steps.centre.row(j);
            to_north.see(h, steps.side_x.row(j), steps.side_x.row(j == last ? j : j + 1));
            if (j == last) to_south.see(h, steps.side_x.row(j + 1));
            to_west.see(h, steps.side_y.row(j));
            to_east.see(h, steps.side_y.row(j) + 1);
        }
        const std::uint8_t* const side_x = out.side_x.data() + block_row * out.blocks_x;
        const std::uint8_t* const side_y = out.side_y.data() + block_row * (out.blocks_x + 1);
        for (std::int32_t b = 0; b < out.blocks_x; ++b) {
            const std::int32_t first = b * size;
            const float n = distance_m(along_y, to_north.of(first, size)) + side_m[side_x[b]];
            const float s = distance_m(along_y, to_south.of(first, size)) + side_m[side_x[b + out.blocks_x]];
            const float w =
                distance_m(along_x, std::max(to_west.of(first, size), to_east.of(first, size - 1))) + side_m[side_y[b]];
            const float e = distance_m(along_x, to_east.of(first + size - 1, 1)) + side_m[side_y[b + 1]];
            out.centre.push_back(code_up(centre_m, std::max({n, s, w, e}) * radius_rounding));
        }
    }

    const StepInput& in;
    Radii& out;
    std::int32_t size = 1; // squares of a block, a side
    float quantum = 1, height_pad = 0, leaf_pad = 0;
    float along_x = 0, along_y = 0, across = 0; // squares of distances along the ground
    float ends_ground = 0, apexes_ground = 0;   // the same, of leaves
    Buffer<float> line;
    Differences ends, apexes, to_north, to_south, to_west, to_east;
    CodedRadii side_m{}, centre_m{};
};

FJELL_CLONES void run(RadiusStage& stage) {
    stage.run();
}

} // namespace

void nest_radii(const StepInput& input, Radii& out) {
    RadiusStage stage(input, out);
    run(stage);
}

} // namespace fjell::baker
