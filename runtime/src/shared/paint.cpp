#include "shared/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "shared/block_codes.h"
#include "shared/compiler.h"

namespace fjell::edit {

namespace {

// ---- light ---------------------------------------------------------------------------------------------------------

constexpr double fifth_root(double v) {
    double root = 1;
    for (int i = 0; i < 40; ++i) root = (4 * root + v / (root * root * root * root)) / 5;
    return root;
}
// Of sRGB codes, 0 to 1: x^2.4 is x^2 times the fifth root of x^2.
constexpr std::array<float, 256> light_of_codes() {
    std::array<float, 256> light{};
    for (std::size_t code = 0; code < 256; ++code) {
        const double v = static_cast<double>(code) / 255, x = (v + 0.055) / 1.055;
        light[code] = static_cast<float>(v <= 0.04045 ? v / 12.92 : x * x * fifth_root(x * x));
    }
    return light;
}
constexpr std::array<float, 256> light_of = light_of_codes();

std::uint8_t code_of(float light) { // the nearest
    const auto above = std::lower_bound(light_of.begin(), light_of.end(), light);
    if (above == light_of.begin()) return 0;
    if (above == light_of.end()) return 255;
    const auto code = static_cast<std::uint8_t>(above - light_of.begin());
    return light - *(above - 1) < *above - light ? static_cast<std::uint8_t>(code - 1) : code;
}

std::uint32_t byte_of(std::uint32_t word, int n) {
    return word >> (8 * n) & 255;
}
std::uint32_t share_of(std::uint32_t colour) {
    return colour >> 24;
}

// ---- samples -------------------------------------------------------------------------------------------------------

// Of both halves of 255: what is left of a share that another one hides.
std::uint32_t left_of(std::uint32_t share, std::uint32_t hidden) {
    return (share * (255 - hidden) + 127) / 255;
}

// A colour that hides `hides` of 255 over one that is there.
std::uint32_t paint_over(std::uint32_t colour, const std::uint8_t (&rgb)[3], std::uint32_t hides) {
    if (hides == 255) return 0xff00'0000u | rgb[0] | std::uint32_t{rgb[1]} << 8 | std::uint32_t{rgb[2]} << 16;
    const std::uint32_t under = left_of(share_of(colour), hides), share = std::min(under + hides, 255u);
    std::uint32_t mixed = share << 24;
    for (int c = 0; c < 3; ++c) {
        const float light =
            (static_cast<float>(hides) * light_of[rgb[c]] + static_cast<float>(under) * light_of[byte_of(colour, c)]) /
            static_cast<float>(hides + under);
        mixed |= std::uint32_t{code_of(light)} << (8 * c);
    }
    return mixed;
}

struct MaterialShare {
    std::uint32_t share = 0, number = 0;
};
std::uint32_t word_of(const MaterialShare& a, const MaterialShare& b) { // the larger one first
    if (a.share < b.share) return word_of(b, a);
    const auto half = [](const MaterialShare& m) { return m.share == 0 ? 0 : m.share | m.number << 8; };
    return half(a) | half(b) << 16;
}
// The two that hide most. most: what they may hide together.
std::uint32_t two_of(MaterialShare (&all)[8], std::uint32_t count, std::uint32_t most) {
    const auto larger = [](const MaterialShare& a, const MaterialShare& b) {
        return a.share != b.share ? a.share > b.share : a.number < b.number;
    };
    std::sort(all, all + count, larger);
    MaterialShare a = count > 0 ? all[0] : MaterialShare{}, b = count > 1 ? all[1] : MaterialShare{};
    a.share = std::min(a.share, most);
    b.share = std::min(b.share, most - a.share);
    return word_of(a, b);
}
void add_to(MaterialShare (&all)[8], std::uint32_t& count, std::uint32_t share, std::uint32_t number) {
    if (share == 0) return;
    for (std::uint32_t i = 0; i < count; ++i)
        if (all[i].number == number) {
            all[i].share += share;
            return;
        }
    all[count++] = {share, number};
}
std::uint32_t paint_over_materials(std::uint32_t word, std::uint8_t material, std::uint32_t hides,
                                   std::uint32_t share) {
    MaterialShare all[8];
    std::uint32_t count = 0;
    add_to(all, count, left_of(byte_of(word, 0), hides), byte_of(word, 1));
    add_to(all, count, left_of(byte_of(word, 2), hides), byte_of(word, 3));
    if (material != no_material) add_to(all, count, hides, material);
    return two_of(all, count, share);
}

std::uint32_t mean_of_colours(const std::uint32_t (&of)[4]) {
    if (of[0] == of[1] && of[0] == of[2] && of[0] == of[3]) return of[0];
    std::uint32_t shares = 0;
    for (const std::uint32_t colour : of) shares += share_of(colour);
    std::uint32_t mean = (shares + 2) / 4 << 24;
    if (mean == 0) return 0;
    for (int c = 0; c < 3; ++c) {
        float light = 0;
        for (const std::uint32_t colour : of)
            light += static_cast<float>(share_of(colour)) * light_of[byte_of(colour, c)];
        mean |= std::uint32_t{code_of(light / static_cast<float>(shares))} << (8 * c);
    }
    return mean;
}
std::uint32_t mean_of_materials(const std::uint32_t (&of)[4], std::uint32_t share) {
    if (of[0] == of[1] && of[0] == of[2] && of[0] == of[3]) return of[0];
    MaterialShare all[8];
    std::uint32_t count = 0;
    for (const std::uint32_t word : of)
        for (int half = 0; half < 4; half += 2) add_to(all, count, byte_of(word, half), byte_of(word, half + 1));
    for (std::uint32_t i = 0; i < count; ++i) all[i].share = (all[i].share + 2) / 4;
    return two_of(all, count, share);
}

void take_means(PaintBlock& block) {
    for (int level = 1; level <= paint_log2; ++level) {
        const std::uint32_t side = 1u << (paint_log2 - level), finer = paint_level_at[level - 1];
        for (std::uint32_t k = 0; k < side * side; ++k) {
            const std::uint32_t from = finer + 4 * side * (k / side) + 2 * (k % side);
            const std::uint32_t at[4] = {from, from + 1, from + 2 * side, from + 2 * side + 1};
            std::uint32_t colours[4], materials[4];
            for (int i = 0; i < 4; ++i) colours[i] = block.colours[at[i]], materials[i] = block.materials[at[i]];
            const std::uint32_t mean = mean_of_colours(colours);
            store_word_relaxed(&block.colours[paint_level_at[level] + k], mean);
            store_word_relaxed(&block.materials[paint_level_at[level] + k],
                               mean_of_materials(materials, share_of(mean)));
        }
    }
}

} // namespace

bool paint_block(const StampGrid& grid, const Stamp& stamp, PaintBlock& block) {
    const std::int32_t x0 = block.x * paint_side, y0 = block.y * paint_side;
    const Rect samples = samples_of(grid, stamp).within({x0, y0, x0 + paint_side - 1, y0 + paint_side - 1});
    bool changed = false;
    for (std::int32_t y = samples.y0; y <= samples.y1; ++y)
        for (std::int32_t x = samples.x0; x <= samples.x1; ++x) {
            const auto hides = nearest<std::uint32_t>(stamp_weight(grid, stamp, {x, y}) * 255);
            if (hides == 0) continue;
            const auto k = static_cast<std::size_t>(y - y0) * paint_side + static_cast<std::size_t>(x - x0);
            const std::uint32_t colour = block.colours[k], material = block.materials[k];
            std::uint32_t painted = 0;
            if (stamp.shape == StampShape::paint)
                painted = paint_over(colour, stamp.rgb, hides);
            else if (const std::uint32_t share = left_of(share_of(colour), hides); share != 0)
                painted = (colour & 0xff'ffffu) | share << 24;
            const std::uint32_t materials = paint_over_materials(
                material, stamp.shape == StampShape::paint ? stamp.material : no_material, hides, share_of(painted));
            if (painted == colour && materials == material) continue;
            store_word_relaxed(&block.colours[k], painted);
            store_word_relaxed(&block.materials[k], materials);
            changed = true;
        }
    if (changed) take_means(block);
    return changed;
}

bool is_blank(const PaintBlock& block) {
    return std::all_of(block.colours, block.colours + paint_level_at[1], [](std::uint32_t c) { return c == 0; });
}

// ---- texels --------------------------------------------------------------------------------------------------------

PaintGrid::PaintGrid(int tile_log2, SampleIndex last_, std::uint32_t top_log2, std::uint32_t mip_log2,
                     SampleIndex first_)
    : first(first_), last(last_) {
    const auto apart = [&](std::uint32_t log2) {
        return static_cast<double>(1u << tile_log2) / static_cast<double>((1u << log2) - 1);
    };
    spacing = apart(mip_log2);
    level = 0;
    while (level < paint_log2 && spacing >= 4 << level) ++level;
    // Variances of tents add up, a sixth of a side's square each. The means' own, a twelfth, is among them.
    double squares = std::max(apart(top_log2), 1.0) * std::max(apart(top_log2), 1.0);
    for (std::uint32_t log2 = mip_log2; log2 < top_log2; ++log2) squares += apart(log2) * apart(log2);
    const double cell = 1 << level;
    if (level > 0) squares -= 0.5 * cell * cell;
    wide = std::max(std::sqrt(squares), cell);
}
PaintGrid::PaintGrid(const PackHeader& h, std::uint32_t top_log2, std::uint32_t mip_log2, SampleIndex first_)
    : PaintGrid(static_cast<int>(h.tile_log2),
                {static_cast<std::int32_t>(h.columns) - 1, static_cast<std::int32_t>(h.rows) - 1}, top_log2, mip_log2,
                first_) {}

MapRect PaintGrid::texels_over(const Rect& samples, std::uint32_t side) const {
    const double reach = wide + (1 << level);
    struct Run {
        std::uint32_t first = 0, count = 0;
    };
    const auto run = [&](std::int32_t from, std::int32_t to, std::int32_t origin, std::int32_t rim) {
        const double begin = std::floor((std::min(from, rim) - origin - reach) / spacing);
        double end = std::ceil((to - origin + reach) / spacing);
        if (to + reach + spacing >= rim) end = side; // texels beyond the rim show what it does
        if (end < 0 || begin >= side) return Run{};
        const auto a = static_cast<std::uint32_t>(std::max(begin, 0.0)) / 4 * 4,
                   b = static_cast<std::uint32_t>(std::min(end, side - 1.0)) / 4 * 4 + 4;
        return Run{a, b - a};
    };
    const Run x = run(samples.x0, samples.x1, first.column, last.column),
              y = run(samples.y0, samples.y1, first.row, last.row);
    if (x.count == 0 || y.count == 0) return {};
    return {x.first, y.first, x.count, y.count};
}

namespace {

// What texels take of cells, along one axis: cells [begin, end), by a tent around `at`.
struct PaintAxis {
    std::int32_t begin[painted_side], end[painted_side];
    double at[painted_side], wide, per[painted_side];

    PaintAxis(const PaintGrid& grid, std::int32_t first_sample, std::int32_t first_texel, std::int32_t count,
              std::int32_t last_sample) {
        const double cell = 1 << grid.level;
        wide = grid.wide / cell;
        const std::int32_t last_cell = last_sample >> grid.level;
        for (std::int32_t i = 0; i < count; ++i) {
            const double sample = std::min(first_sample + (first_texel + i) * grid.spacing, double(last_sample));
            at[i] = sample / cell - 0.5 * (1 - 1 / cell);
            begin[i] = std::clamp(static_cast<std::int32_t>(std::floor(at[i] - wide)) + 1, 0, last_cell);
            end[i] = std::clamp(static_cast<std::int32_t>(std::ceil(at[i] + wide)), begin[i] + 1, last_cell + 1);
            double sum = 0;
            for (std::int32_t k = begin[i]; k < end[i]; ++k) sum += weight(i, k);
            per[i] = sum > 0 ? 1 / sum : 0;
        }
    }
    [[nodiscard]] double weight(std::int32_t i, std::int32_t cell) const {
        return std::max(wide - std::abs(cell - at[i]), 0.0);
    }
    [[nodiscard]] float share(std::int32_t i, std::int32_t cell) const {
        return static_cast<float>(weight(i, cell) * per[i]);
    }
};

void add(PaintedColour& to, const PaintBlock& block, std::size_t k, float weight) {
    const std::uint32_t colour = load_word_relaxed(&block.colours[k]);
    const float share = weight * static_cast<float>(share_of(colour)) * (1.0f / 255);
    if (share == 0) return;
    to.share += share;
    for (int c = 0; c < 3; ++c) to.light[c] += share * light_of[byte_of(colour, c)];
}
void add(PaintedMaterials& to, const PaintBlock& block, std::size_t k, float weight) {
    const std::uint32_t colour = load_word_relaxed(&block.colours[k]), word = load_word_relaxed(&block.materials[k]);
    to.share += weight * static_cast<float>(share_of(colour)) * (1.0f / 255);
    for (int half = 0; half < 4; half += 2)
        to.of[byte_of(word, half + 1) % max_splat_names] +=
            weight * static_cast<float>(byte_of(word, half)) * (1.0f / 255);
}
void add(PaintedColour& to, const PaintedColour& from, float weight) {
    to.share += weight * from.share;
    for (int c = 0; c < 3; ++c) to.light[c] += weight * from.light[c];
}
void add(PaintedMaterials& to, const PaintedMaterials& from, float weight) {
    to.share += weight * from.share;
    for (std::uint32_t i = 0; i < max_splat_names; ++i) to.of[i] += weight * from.of[i];
}

// Block by block, across first.
template <typename Painted>
bool sum_blocks(const PaintSource& from, const PaintGrid& grid, const PaintedTexels& t, Painted* to) {
    const PaintAxis x(grid, grid.first.column, t.x, t.columns, grid.last.column),
        y(grid, grid.first.row, t.y, t.rows, grid.last.row);
    const int cells_log2 = paint_log2 - grid.level; // a side of a block
    const std::int32_t cells = 1 << cells_log2;
    bool found = false;
    for (std::int32_t by = y.begin[0] >> cells_log2; by <= (y.end[t.rows - 1] - 1) >> cells_log2; ++by)
        for (std::int32_t bx = x.begin[0] >> cells_log2; bx <= (x.end[t.columns - 1] - 1) >> cells_log2; ++bx) {
            const PaintBlock* const block = from.find(from.object, bx, by);
            if (block == nullptr) continue;
            if (!found) std::fill_n(to, painted_side * painted_side, Painted{});
            found = true;
            for (std::int32_t j = 0; j < cells; ++j) {
                const std::int32_t row = (by << cells_log2) + j;
                if (row < y.begin[0] || row >= y.end[t.rows - 1]) continue;
                Painted across[painted_side] = {};
                for (std::int32_t i = 0; i < t.columns; ++i) {
                    const std::int32_t first = std::max(x.begin[i], bx << cells_log2),
                                       end = std::min(x.end[i], (bx + 1) << cells_log2);
                    for (std::int32_t k = first; k < end; ++k)
                        add(across[i], *block,
                            paint_level_at[grid.level] + static_cast<std::size_t>(j * cells + k - (bx << cells_log2)),
                            x.share(i, k));
                }
                for (std::int32_t r = 0; r < t.rows; ++r) {
                    if (row < y.begin[r] || row >= y.end[r]) continue;
                    const float weight = y.share(r, row);
                    for (std::int32_t i = 0; i < t.columns; ++i) add(to[r * painted_side + i], across[i], weight);
                }
            }
        }
    return found;
}

// draw(group, sums) for each group of texels that paint reaches.
template <typename Painted, typename Draw>
void for_each_painted(const PaintSource& from, const PaintGrid& grid, const MapRect& at, const Draw& draw) {
    Painted sums[painted_side * painted_side];
    for (std::uint32_t y = at.y; y < at.y + at.rows; y += painted_side)
        for (std::uint32_t x = at.x; x < at.x + at.columns; x += painted_side) {
            const PaintedTexels group{
                static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                static_cast<std::int32_t>(std::min<std::uint32_t>(painted_side, at.x + at.columns - x)),
                static_cast<std::int32_t>(std::min<std::uint32_t>(painted_side, at.y + at.rows - y))};
            if (sum_blocks(from, grid, group, sums)) draw(group, sums);
        }
}

// Blocks of a group, side by side for the encoder.
class ColourStrip {
public:
    // Of a texel of the block that is added next; i: 0 to 15.
    void set(std::size_t i, int c, std::uint8_t code) { codes_[i / 4][c][4 * count_ + i % 4] = code; }
    void add(std::byte* to) { to_[count_++] = to; }
    void store() {
        if (count_ == 0) return;
        ColourRows rows{};
        for (int y = 0; y < 4; ++y)
            for (int c = 0; c < 3; ++c) rows.rows[y][c] = codes_[y][c];
        std::byte blocks[most * colour_block_bytes];
        encode_bc1(rows, count_, blocks);
        for (std::size_t i = 0; i < count_; ++i)
            std::memcpy(to_[i], blocks + i * colour_block_bytes, colour_block_bytes);
    }

private:
    static constexpr std::size_t most = painted_side * painted_side / 16;
    std::uint8_t codes_[4][3][4 * most];
    std::byte* to_[most];
    std::size_t count_ = 0;
};

constexpr float shows = 1.0f / 512; // of a share: less changes no code

} // namespace

bool sum_paint(const PaintSource& from, const PaintGrid& grid, const PaintedTexels& at, PaintedColour* to) {
    return sum_blocks(from, grid, at, to);
}
bool sum_paint(const PaintSource& from, const PaintGrid& grid, const PaintedTexels& at, PaintedMaterials* to) {
    return sum_blocks(from, grid, at, to);
}

bool paint_colours(const PaintSource& from, const PaintGrid& grid, std::uint32_t side, const MapRect& at,
                   std::byte* blocks) {
    bool changed = false;
    for_each_painted<PaintedColour>(from, grid, at, [&](const PaintedTexels& group, const PaintedColour* sums) {
        ColourStrip strip;
        for (std::int32_t y = 0; y < group.rows; y += 4)
            for (std::int32_t x = 0; x < group.columns; x += 4) {
                const auto sum = [&](std::size_t i) -> const PaintedColour& {
                    return sums[(y + static_cast<std::int32_t>(i / 4)) * painted_side + x +
                                static_cast<std::int32_t>(i % 4)];
                };
                bool shown = false;
                for (std::size_t i = 0; i < 16; ++i) shown = shown || sum(i).share >= shows;
                if (!shown) continue;
                std::byte* const block = blocks + (static_cast<std::size_t>((group.y + y) / 4) * (side / 4) +
                                                   static_cast<std::size_t>((group.x + x) / 4)) *
                                                      colour_block_bytes;
                std::uint8_t rgb[48];
                (void)decode_colour({block, colour_block_bytes}, 4, rgb);
                for (std::size_t i = 0; i < 16; ++i)
                    for (int c = 0; c < 3; ++c) {
                        const std::uint8_t code = rgb[3 * i + static_cast<std::size_t>(c)];
                        const PaintedColour& p = sum(i);
                        strip.set(i, c, p.share < shows ? code : code_of(p.light[c] + (1 - p.share) * light_of[code]));
                    }
                strip.add(block);
                changed = true;
            }
        strip.store();
    });
    return changed;
}

bool paint_splat(const PaintSource& from, const PaintGrid& grid, std::uint32_t side, const MapRect& at,
                 std::byte* texels) {
    bool changed = false;
    for_each_painted<PaintedMaterials>(from, grid, at, [&](const PaintedTexels& group, const PaintedMaterials* sums) {
        for (std::int32_t y = 0; y < group.rows; ++y)
            for (std::int32_t x = 0; x < group.columns; ++x) {
                const PaintedMaterials& p = sums[y * painted_side + x];
                if (p.share < shows) continue;
                std::byte* const to =
                    texels + (static_cast<std::size_t>(group.y + y) * side + static_cast<std::size_t>(group.x + x)) *
                                 splat_texel_bytes;
                float shares[max_splat_names];
                std::copy_n(p.of, max_splat_names, shares);
                for (std::size_t k = 0; k < splat_layers; ++k)
                    shares[std::to_integer<std::size_t>(to[2 * k + 1]) % max_splat_names] +=
                        static_cast<float>(std::to_integer<int>(to[2 * k])) * (1.0f / 255) *
                        std::max(1 - p.share, 0.0f);
                store_splat_texel(shares, to);
                changed = true;
            }
    });
    return changed;
}

void store_splat_texel(const float (&shares)[max_splat_names], std::byte* to) {
    std::size_t best[splat_layers];
    float all = 0, kept = 0;
    for (const float share : shares) all += std::max(share, 0.0f);
    bool taken[max_splat_names] = {};
    for (std::size_t k = 0; k < splat_layers; ++k) {
        std::size_t most = 0;
        while (taken[most]) ++most;
        for (std::size_t i = most + 1; i < max_splat_names; ++i)
            if (!taken[i] && shares[i] > shares[most]) most = i;
        taken[most] = true;
        best[k] = most;
        kept += std::max(shares[most], 0.0f);
    }
    // Rounded so that the sum is what it should be, and the order stays: what is missing goes to the largest, what is
    // too much is the smallest's.
    const float scale = kept > 0 ? 255 * std::min(all, 1.0f) / kept : 0;
    int weight[splat_layers], sum = 0;
    for (std::size_t k = 0; k < splat_layers; ++k) {
        weight[k] = nearest<int>(std::max(shares[best[k]], 0.0f) * scale);
        sum += weight[k];
    }
    const int wanted = nearest<int>(std::min(all, 1.0f) * 255);
    weight[0] += std::max(wanted - sum, 0);
    for (std::size_t k = splat_layers; sum > wanted; --sum) {
        while (weight[k - 1] == 0) --k;
        --weight[k - 1];
    }
    for (std::size_t k = 0; k < splat_layers; ++k) {
        to[2 * k] = static_cast<std::byte>(weight[k]);
        to[2 * k + 1] = static_cast<std::byte>(weight[k] == 0 ? 0 : best[k]);
    }
}

} // namespace fjell::edit
