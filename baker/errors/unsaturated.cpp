#include "baker/errors/unsaturated.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "baker/errors/triangle_scan.h"

namespace fjell::baker {

UnsaturatedError unsaturated_error(const UnsaturatedInput& in, SampleIndex v) {
    const Scales& scales = in.scales;
    return diamond_error(in.ground,
                         {scales.errors,
                          scales.height_scale.quantum_m,
                          {in.spacing_m[0], in.spacing_m[1]},
                          scales.ground_pad_m,
                          scales.height_pad_m,
                          in.estimate == ErrorEstimate::midpoint},
                         v, [&](SampleIndex apex) {
                             return apex.column >= in.region.first.column && apex.row >= in.region.first.row &&
                                    apex.column <= in.region.last.column && apex.row <= in.region.last.row;
                         });
}

namespace {

// Codes of small errors that are multiples of a unit, looked up instead of searched for.
class CodeTable {
public:
    void make(const ErrorScale& scale, double unit_m) {
        std::uint32_t code = 0;
        for (std::size_t k = 0; k < codes_.size(); ++k) {
            while (code < 255 && static_cast<double>(scale.metres[code]) < static_cast<double>(k) * unit_m) ++code;
            codes_[k] = static_cast<std::uint8_t>(code);
        }
        made_ = true;
    }
    void clear() { made_ = false; }
    [[nodiscard]] bool holds(std::int32_t k) const { return made_ && k < static_cast<std::int32_t>(codes_.size()); }
    [[nodiscard]] std::uint8_t at(std::int32_t k) const { return codes_[static_cast<std::size_t>(k)]; }
    static constexpr std::size_t size = 1024;

private:
    bool made_ = false;
    std::array<std::uint8_t, size> codes_;
};

class UnsaturatedErrors {
public:
    UnsaturatedErrors(const UnsaturatedInput& input, Patch<std::uint8_t>& out)
        : in(input), tree(input.ground.tree),
          half_quantum(0.5 * static_cast<double>(input.scales.height_scale.quantum_m)), to(out),
          worst(static_cast<std::size_t>(out.columns) + scan_slack) {}

    std::uint8_t worst_on_ground = 0; // where there are voids: then every vertex goes the slow way

    // Even rows of a step hold sides along x; odd ones sides along y, and centres between them.
    void run(int z) {
        const Region& r = in.region;
        const std::int32_t s = 1 << z, n = (r.last.column - r.first.column) / (2 * s);
        small = z <= 3 && in.estimate == ErrorEstimate::max && !in.ground.has_voids();
        if (small)
            phases = DeinterleavedSamples::of(in.ground.steps.at(r.first.column, r.first.row), in.ground.steps.columns,
                                              n, r.last.row - r.first.row + 1, 2 * s);
        table.clear();
        if (std::int64_t{n} * n >= static_cast<std::int64_t>(CodeTable::size))
            table.make(in.scales.errors, half_quantum / s);
        for (std::int32_t y = r.first.row; y <= r.last.row; y += s)
            if (((y >> z) & 1) == 0) {
                row(VertexKind::side_x, {r.first.column + s, y}, z, n);
            } else {
                row(VertexKind::side_y, {r.first.column, y}, z, n + 1);
                row(VertexKind::centre, {r.first.column + s, y}, z, n);
            }
    }

private:
    void row(VertexKind kind, SampleIndex first, int z, std::int32_t count) {
        const std::int32_t s = 1 << z;
        std::uint8_t* const codes = to.at(first.column / 2, first.row / 2);
        std::int32_t plain = in.ground.has_voids() ? 0 : count; // vertices before the first one that stands at the rim
        while (plain > 0 && straddles_rim(tree, {first.column + 2 * s * (plain - 1), first.row})) --plain;
        for (std::int32_t i = plain; i < count; ++i) {
            const UnsaturatedError e = unsaturated_error(in, {first.column + 2 * s * i, first.row});
            codes[i * s] = e.code;
            worst_on_ground = std::max(worst_on_ground, e.on_ground);
        }
        if (plain == 0) return;
        const std::int32_t* const v = in.ground.steps.at(first.column, first.row);
        const std::ptrdiff_t stride = in.ground.steps.columns;
        const bool root = z == tree.tile_log2 - 1;
        const bool falling = root || ((((first.column - s) >> (z + 1)) + ((first.row - s) >> (z + 1))) & 1) == 0;
        if (in.estimate == ErrorEstimate::midpoint) {
            for (std::int32_t i = 0; i < plain; ++i) {
                const std::int32_t* const h = v + std::ptrdiff_t{2} * s * i;
                const std::ptrdiff_t down = s * stride;
                const std::ptrdiff_t end = kind == VertexKind::side_x      ? s
                                           : kind == VertexKind::side_y    ? down
                                           : falling != (!root && (i & 1)) ? down + s
                                                                           : down - s;
                codes[i * s] = in.leaf.code(static_cast<std::uint32_t>(std::abs(2 * h[0] - h[-end] - h[end])));
            }
            return;
        }
        const bool rows = kind == VertexKind::side_x;
        VertexRow line{v, stride, s, plain, kind};
        line.before = !rows || first.row > in.region.first.row;
        line.after = !rows || first.row < in.region.last.row;
        line.falling = falling, line.alternate = !root;
        if (small && plain == count) {
            SmallRow side{phases, first.row - in.region.first.row, count, kind};
            side.before = line.before, side.after = line.after;
            side.falling = line.falling, side.alternate = line.alternate;
            scan_small_row(side, worst.data());
        } else if (kind == VertexKind::side_y) { // those on the region's borders are measured inside only
            if (plain > 1) scan(line, 1, plain - (plain == count ? 2 : 1));
            line.before = false;
            scan(line, 0, 1);
            if (plain == count) line.before = true, line.after = false, scan(line, count - 1, 1);
        } else {
            scan(line, 0, plain);
        }
        const double unit_m = half_quantum / s;
        for (std::int32_t i = 0; i < plain; ++i) {
            const std::int32_t k = worst[static_cast<std::size_t>(i)];
            codes[i * s] = table.holds(k) ? table.at(k) : in.scales.errors.code_up(k * unit_m);
        }
    }

    void scan(VertexRow line, std::int32_t from, std::int32_t count) {
        line.first += std::ptrdiff_t{2} * line.s * from;
        line.count = count;
        if (count > 0) scan_row(line, worst.data() + from);
    }

    const UnsaturatedInput& in;
    const Tree& tree;
    const double half_quantum;
    Patch<std::uint8_t>& to;
    std::vector<std::int32_t> worst;
    CodeTable table;
    bool small = false; // this step's vertices go side by side
    DeinterleavedSamples phases;
};

} // namespace

std::uint8_t unsaturated_errors(const UnsaturatedInput& input, Patch<std::uint8_t>& out) {
    const Region& r = input.region;
    out = {r.first.column / 2, r.first.row / 2, (r.last.column - r.first.column) / 2 + 1,
           (r.last.row - r.first.row) / 2 + 1};
    std::fill(out.values.begin(), out.values.end(), std::uint8_t{0}); // corners of tiles
    UnsaturatedErrors stage(input, out);
    for (int z = 1; z < input.ground.tree.tile_log2; ++z) stage.run(z);
    if (input.ground.has_voids()) return stage.worst_on_ground;
    std::uint8_t worst = 0;
    for (const std::uint8_t code : out.values) worst = std::max(worst, code);
    return worst;
}

} // namespace fjell::baker
