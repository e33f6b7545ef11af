#include "baker/errors/step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "compiler.h"
#include "tree/order.h"

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
        diagonals(north, south, in.nx, (in.square.x + in.square.y + j) & 1, in.z == in.tree.tile_log2 - 1, a.data(),
                  b.data());
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

// Distances are found in float from whole differences of heights, and rounded up by more than that loses.
constexpr float float_rounding = 1 + 0x1p-19f;

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
        line.resize(static_cast<std::size_t>(in.nx + reach + 1));
    }

    FJELL_ALWAYS_INLINE void run() {
        const int side_level = 2 * (in.tree.tile_log2 - 1 - in.z) + 1;
        const float unit = in.scales.level_radius_m[side_level];
        // Squares beyond the last row or column that the region's own blocks reach into.
        const std::int32_t more = (1 << out.shift) - 1;
        plane(in.nx, in.ny + 1 + more, out.blocks_x, unit, out.side_x,
              [&](std::int32_t j) FJELL_ALWAYS_INLINE_LAMBDA { in.finer ? side_x_row(j) : leaf_x_row(j); });
        plane(in.nx + 1 + more, in.ny, out.blocks_x + 1, unit, out.side_y,
              [&](std::int32_t j) FJELL_ALWAYS_INLINE_LAMBDA { in.finer ? side_y_row(j) : leaf_y_row(j); });
        for (std::size_t code = 0; code < radius_codes; ++code) side_m[code] = unit * in.scales.radii.factor[code];
        plane(in.nx, in.ny, out.blocks_x, in.scales.level_radius_m[side_level - 1], out.centre,
              [&](std::int32_t j) FJELL_ALWAYS_INLINE_LAMBDA { centre_row(j); });
    }

private:
    // Codes of the blocks of a plane of columns x rows, whose radii row(j) puts on the line.
    template <typename Row>
    FJELL_ALWAYS_INLINE void plane(std::int32_t columns, std::int32_t rows, std::int32_t blocks_x, float unit,
                                   std::vector<std::uint8_t>& to, const Row& row) {
        const std::int32_t size = 1 << out.shift, mask = size - 1;
        std::vector<float> most(static_cast<std::size_t>(columns));
        to.clear();
        for (std::int32_t j = 0; j < rows; ++j) {
            row(j);
            if ((j & mask) == 0) std::fill(most.begin(), most.end(), 0.0f);
            for (std::size_t i = 0; i < most.size(); ++i) most[i] = line[i] > most[i] ? line[i] : most[i];
            if ((j & mask) != mask) continue;
            for (std::int32_t b = 0; b < blocks_x; ++b) {
                float block = 0;
                for (std::int32_t i = b << out.shift; i < (b + 1) << out.shift; ++i)
                    block = std::max(block, most[static_cast<std::size_t>(i)]);
                to.push_back(in.scales.radii.code_up(unit, static_cast<double>(block) * sphere_margin));
            }
        }
    }

    [[nodiscard]] FJELL_ALWAYS_INLINE float climb_m(std::int32_t a, std::int32_t b) const {
        return static_cast<float>(std::abs(a - b)) * quantum + height_pad;
    }

    // A leaf's sphere holds the corners of its triangles: the ends of its side and the centres beside it.
    FJELL_ALWAYS_INLINE void leaf_row(const std::int32_t* h, const std::int32_t* a, const std::int32_t* b,
                                      const std::int32_t* c, const std::int32_t* d, float ends, float apexes,
                                      std::int32_t count) {
        for (std::int32_t i = 0; i < count; ++i) {
            const std::int32_t e0 = std::abs(a[i] - h[i]), e1 = std::abs(b[i] - h[i]);
            const std::int32_t p0 = std::abs(c[i] - h[i]), p1 = std::abs(d[i] - h[i]);
            const float end = static_cast<float>(e0 > e1 ? e0 : e1) * quantum + height_pad;
            const float apex = static_cast<float>(p0 > p1 ? p0 : p1) * quantum + height_pad;
            const float x = ends + end * end, y = apexes + apex * apex;
            line[static_cast<std::size_t>(i)] = (std::sqrt(x > y ? x : y) + leaf_pad) * float_rounding;
        }
    }
    FJELL_ALWAYS_INLINE void leaf_x_row(std::int32_t j) {
        const auto& h = in.steps;
        const std::int32_t* const ends = h.corner.row(j);
        leaf_row(h.side_x.row(j), ends, ends + 1, h.centre.row(j - 1), h.centre.row(j), along_x, along_y, in.nx);
    }
    FJELL_ALWAYS_INLINE void leaf_y_row(std::int32_t j) {
        const auto& h = in.steps;
        const std::int32_t* const apexes = h.centre.row(j);
        leaf_row(h.side_y.row(j), h.corner.row(j), h.corner.row(j + 1), apexes - 1, apexes, along_y, along_x,
                 in.nx + 1 + (1 << out.shift) - 1);
    }

    // Over two rows of finer centres, two of them each: (2 i + first) and the next.
    FJELL_ALWAYS_INLINE void side_row(const std::int32_t* h, std::size_t north, std::size_t south, std::int32_t count) {
        const FinerCentres& f = *in.finer;
        const float ground = across;
        float* const to = line.data();
        std::fill_n(to, count, 0.0f);
        for (const std::size_t row : {north, south}) {
            const std::int32_t* const steps = f.steps.data() + row;
            const float* const radius = f.radius_m.data() + row;
            for (std::int32_t i = 0; i < count; ++i) {
                const float da = climb_m(steps[2 * i], h[i]), db = climb_m(steps[2 * i + 1], h[i]);
                const float a = std::sqrt(ground + da * da) + radius[2 * i];
                const float b = std::sqrt(ground + db * db) + radius[2 * i + 1];
                const float most = (a > b ? a : b) * float_rounding;
                to[i] = most > to[i] ? most : to[i];
            }
        }
    }
    FJELL_ALWAYS_INLINE void side_x_row(std::int32_t j) {
        side_row(in.steps.side_x.row(j), in.finer->row(2 * j - 1), in.finer->row(2 * j), in.nx);
    }
    FJELL_ALWAYS_INLINE void side_y_row(std::int32_t j) {
        side_row(in.steps.side_y.row(j), in.finer->row(2 * j) - 1, in.finer->row(2 * j + 1) - 1,
                 in.nx + 1 + (1 << out.shift) - 1);
    }

    FJELL_ALWAYS_INLINE void centre_row(std::int32_t j) {
        const auto& steps = in.steps;
        const std::int32_t* const h = steps.centre.row(j);
        const std::int32_t* const north = steps.side_x.row(j);
        const std::int32_t* const south = steps.side_x.row(j + 1);
        const std::int32_t* const side_y = steps.side_y.row(j);
        expand(out.side_x, out.blocks_x, j, north_m);
        expand(out.side_x, out.blocks_x, j + 1, south_m);
        expand(out.side_y, out.blocks_x + 1, j, side_y_m);
        float* const to = line.data();
        for (std::int32_t i = 0; i < in.nx; ++i) {
            const float dn = climb_m(north[i], h[i]), ds = climb_m(south[i], h[i]);
            const float dw = climb_m(side_y[i], h[i]), de = climb_m(side_y[i + 1], h[i]);
            const float n = std::sqrt(along_y + dn * dn) + north_m[static_cast<std::size_t>(i)];
            const float s = std::sqrt(along_y + ds * ds) + south_m[static_cast<std::size_t>(i)];
            const float w = std::sqrt(along_x + dw * dw) + side_y_m[static_cast<std::size_t>(i)];
            const float e = std::sqrt(along_x + de * de) + side_y_m[static_cast<std::size_t>(i) + 1];
            const float ns = n > s ? n : s, we = w > e ? w : e;
            to[i] = (ns > we ? ns : we) * float_rounding;
        }
    }
    // The radii in metres of a row of squares, from those of their blocks.
    FJELL_ALWAYS_INLINE void expand(const std::vector<std::uint8_t>& codes, std::int32_t blocks, std::int32_t j,
                                    std::vector<float>& to) {
        const std::uint8_t* const row = codes.data() + (j >> out.shift) * blocks;
        const std::int32_t size = 1 << out.shift;
        to.resize(static_cast<std::size_t>(blocks * size));
        for (std::int32_t b = 0; b < blocks; ++b)
            for (std::int32_t i = 0; i < size; ++i) to[static_cast<std::size_t>(b * size + i)] = side_m[row[b]];
    }

    const StepInput& in;
    Radii& out;
    float quantum = 1, height_pad = 0, leaf_pad = 0;
    float along_x = 0, along_y = 0, across = 0; // squares of distances along the ground
    std::vector<float> line, north_m, south_m, side_y_m;
    std::array<float, radius_codes> side_m{};
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
