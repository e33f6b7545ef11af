#include "edit/normals.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "fjell/query.h"
#include "fjell/texture.h"

namespace fjell::edit {

namespace {

// Samples between the texels of a mip, as the baker lays them: the first and the last texel of every mip lie on the
// tile's border.
double spacing_of(const TerrainData& t, std::uint32_t mip_log2) {
    return static_cast<double>(1u << t.header.tile_log2) / ((1u << mip_log2) - 1);
}

// The baker makes mip 0 of samples and each mip of the finer one, with a tent whose sides are a texel wide, and no less
// than a sample. Variances of tents, a sixth of a side's square, add up: this is a side of the tent that has their sum.
double tent_of(const TerrainData& t, std::uint32_t mip_log2) {
    const double finest = std::max(spacing_of(t, t.header.normal_log2), 1.0);
    double squares = finest * finest;
    for (std::uint32_t log2 = mip_log2; log2 < t.header.normal_log2; ++log2)
        squares += spacing_of(t, log2) * spacing_of(t, log2);
    return std::sqrt(squares);
}
int step_log2_of(double spacing) {
    return std::max(static_cast<int>(std::bit_width(static_cast<std::uint32_t>(spacing))) - 3, 0);
}

SampleIndex first_sample(const TerrainData& t, std::uint32_t tile) {
    const SampleIndex place = t.tile_xy(tile);
    return {place.column << t.header.tile_log2, place.row << t.header.tile_log2};
}

// A BC4 block of codes: two of them and six between, 3 bits a texel.
void encode(const std::uint8_t (&codes)[16], std::byte* block) {
    const auto [low, high] = std::minmax_element(std::begin(codes), std::end(codes));
    const int first = *high, range = *high - *low;
    std::uint64_t bits = 0;
    for (int i = 0; i < 16 && range != 0; ++i) {
        const int step = ((first - codes[i]) * 14 + range) / (2 * range); // 0 to 7, from the higher to the lower
        bits |= static_cast<std::uint64_t>(step == 0 ? 0 : step == 7 ? 1 : step + 1) << (3 * i);
    }
    block[0] = static_cast<std::byte>(*high);
    block[1] = static_cast<std::byte>(*low);
    for (int i = 0; i < 6; ++i) block[2 + i] = static_cast<std::byte>(bits >> (8 * i));
}

std::uint8_t code_of(float component) {
    return static_cast<std::uint8_t>(std::clamp(128.5f + 127 * component, 1.0f, 255.0f));
}

// The places of a piece along one axis, every 2^step_log2 samples, and what texels take of them: a tent as wide as the
// baker's filters are together. Steps are a quarter to an eighth of a texel, or a sample.
struct Axis {
    int step_log2;
    std::int32_t first, count; // of places
    std::int32_t begin[piece_texels], end[piece_texels];
    float weight[piece_texels][normal_taps];

    // samples: of the terrain, along the axis. What would be beyond its rim stands on the rim, and takes what is
    // inside.
    Axis(double first_sample, double spacing, double wide, std::int32_t texels, int step_log2_, std::uint32_t samples)
        : step_log2(step_log2_) {
        const double step = 1 << step_log2, rim = samples - 1.0;
        const auto place_of = [&](std::int32_t texel) { return std::min(first_sample + texel * spacing, rim); };
        const auto inside = [&](double place) {
            return static_cast<std::int32_t>(std::clamp(place, 0.0, std::floor(rim / step)));
        };
        first = inside(std::floor((place_of(0) - wide) / step) + 1);
        count = inside(std::ceil((place_of(texels - 1) + wide) / step) - 1) + 1 - first;
        for (std::int32_t i = 0; i < texels; ++i) {
            const double at = place_of(i);
            begin[i] = inside(std::floor((at - wide) / step) + 1) - first;
            end[i] = inside(std::ceil((at + wide) / step) - 1) + 1 - first;
            double sum = 0;
            const auto share = [&](std::int32_t place) { return wide - std::abs((first + place) * step - at); };
            for (std::int32_t place = begin[i]; place < end[i]; ++place) sum += share(place);
            for (std::int32_t place = begin[i]; place < end[i]; ++place)
                weight[i][place - begin[i]] = static_cast<float>(share(place) / sum);
        }
    }
};
// Where a place's neighbours lie, and 1 over their distance in metres: the place itself is one at the terrain's rim.
// Heights begin a place before the first one.
struct Neighbours {
    std::int32_t before, after;
    float per_m;

    Neighbours(std::int32_t i, const Axis& axis, std::uint32_t samples, double spacing_m) : before(i), after(i + 2) {
        const auto inside = [&](std::int64_t place) {
            return std::clamp<std::int64_t>(place * (std::int64_t{1} << axis.step_log2), 0, std::int64_t{samples} - 1);
        };
        const std::int64_t apart = inside(axis.first + i + 1) - inside(axis.first + i - 1);
        per_m = apart == 0 ? 0 : static_cast<float>(1 / (static_cast<double>(apart) * spacing_m));
    }
};

} // namespace

TexelRect texels_over(const TerrainData& t, std::uint32_t tile, std::uint32_t mip_log2, const GroundRect& rect) {
    const double spacing = spacing_of(t, mip_log2);
    if (spacing > widest_texel) return {};
    const SampleIndex origin = first_sample(t, tile);
    struct Run {
        std::int32_t first = 0, count = 0;
    };
    const auto run = [&](std::int32_t from, std::int32_t to) {
        const std::int32_t side = 1 << mip_log2;
        const double reach = tent_of(t, mip_log2) + 2 * (1 << step_log2_of(spacing));
        const double first = std::floor((from - reach) / spacing), last = std::ceil((to + reach) / spacing);
        if (last < 0 || first >= side) return Run{};
        const std::int32_t begin = static_cast<std::int32_t>(std::max(first, 0.0)) / 4 * 4;
        const std::int32_t end = static_cast<std::int32_t>(std::min(last, side - 1.0)) / 4 * 4 + 4;
        return Run{begin, end - begin};
    };
    const Run x = run(rect.first.column - origin.column, rect.last.column - origin.column),
              y = run(rect.first.row - origin.row, rect.last.row - origin.row);
    return {x.first, y.first, x.count, y.count};
}

std::int32_t most_texels(const TerrainData& t, std::uint32_t mip_log2) {
    const double spacing = spacing_of(t, mip_log2), step = 1 << step_log2_of(spacing);
    const double room = (NormalScratch::side - 5) * step - 2 * tent_of(t, mip_log2);
    return std::clamp(static_cast<std::int32_t>(room / spacing) / 4 * 4, 4, piece_texels);
}

bool make_normals(const Terrain& terrain, const TerrainData& t, std::uint32_t tile, std::uint32_t mip_log2,
                  const TexelRect& piece, NormalScratch& s, std::byte* block) {
    const PackHeader& h = t.header;
    const double spacing = spacing_of(t, mip_log2);
    const SampleIndex origin = first_sample(t, tile);
    const int step_log2 = step_log2_of(spacing);
    const double wide = tent_of(t, mip_log2);
    const Axis x(origin.column + piece.x * spacing, spacing, wide, piece.columns, step_log2, h.columns),
        y(origin.row + piece.y * spacing, spacing, wide, piece.rows, step_log2, h.rows);
    const std::int32_t side = std::max(x.count, y.count) + 2;
    const GroundPatch ground =
        ground_patch(terrain, {(x.first - 1) * (1 << step_log2), (y.first - 1) * (1 << step_log2)}, step_log2,
                     static_cast<std::uint32_t>(side), s.heights_m);
    for (std::int32_t j = 0; j < y.count; ++j) {
        const Neighbours rows(j, y, h.rows, h.spacing_m[1]);
        const float *const north = s.heights_m + rows.before * side, *const south = s.heights_m + rows.after * side,
                           *const row = s.heights_m + (j + 1) * side;
        float east[NormalScratch::side], down[NormalScratch::side];
        for (std::int32_t i = 0; i < x.count; ++i) {
            const Neighbours columns(i, x, h.columns, h.spacing_m[0]);
            const float a = (row[columns.before] - row[columns.after]) * columns.per_m,
                        b = (north[i + 1] - south[i + 1]) * rows.per_m;
            const float shorter = 1 / std::sqrt(1 + a * a + b * b);
            east[i] = a * shorter, down[i] = b * shorter;
        }
        for (std::int32_t i = 0; i < piece.columns; ++i) {
            float sum[2] = {};
            for (std::int32_t k = x.begin[i]; k < x.end[i]; ++k) {
                sum[0] += x.weight[i][k - x.begin[i]] * east[k];
                sum[1] += x.weight[i][k - x.begin[i]] * down[k];
            }
            s.across[0][j][i] = sum[0], s.across[1][j][i] = sum[1];
        }
    }
    for (std::int32_t row = 0; row < piece.rows; row += 4) {
        std::uint8_t codes[2][4][piece_texels];
        for (std::int32_t j = 0; j < 4; ++j)
            for (std::int32_t c = 0; c < 2; ++c) {
                float sum[piece_texels] = {};
                for (std::int32_t k = y.begin[row + j]; k < y.end[row + j]; ++k)
                    for (std::int32_t i = 0; i < piece.columns; ++i)
                        sum[i] += y.weight[row + j][k - y.begin[row + j]] * s.across[c][k][i];
                for (std::int32_t i = 0; i < piece.columns; ++i) codes[c][j][i] = code_of(sum[i]);
            }
        for (std::int32_t column = 0; column < piece.columns; column += 4)
            for (std::int32_t c = 0; c < 2; ++c, block += normal_block_bytes / 2) {
                std::uint8_t of_block[16];
                for (std::int32_t i = 0; i < 16; ++i) of_block[i] = codes[c][i / 4][column + i % 4];
                encode(of_block, block);
            }
    }
    return ground.finest;
}

} // namespace fjell::edit
