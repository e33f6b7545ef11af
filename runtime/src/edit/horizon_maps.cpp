// Rays as the baker's (baker/maps/horizon.h), from the sample that is nearest to a texel, over samples alone: steps
// grow with the distance, and end at horizon_reach.
#include "edit/horizon_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "edit/state.h"
#include "query/reader.h"
#include "shared/block_codes.h"
#include "shared/horizon.h"
#include "shared/paint.h"

namespace fjell::edit {

namespace {

constexpr std::size_t most_steps = 40;
constexpr double smooth_until = 8; // nearer than this rays pass between samples

// Of a tile and those around it.
class Heights {
public:
    Heights(const TerrainData& terrain, SampleIndex tile)
        : t_(terrain), tile_(tile), columns_(static_cast<std::int32_t>(terrain.header.columns)),
          rows_(static_cast<std::int32_t>(terrain.header.rows)) {}

    // In metres above the pack's base. False: it is not loaded, is a hole, or lies beyond the rim.
    [[nodiscard]] bool read(SampleIndex at, double& height_m) {
        if (at.column < 0 || at.row < 0 || at.column >= columns_ || at.row >= rows_) return false;
        const int log2 = t_.tree.tile_log2;
        const SampleIndex of{std::min(at.column >> log2, t_.tree.tiles_x - 1),
                             std::min(at.row >> log2, t_.tree.tiles_y - 1)};
        const std::int32_t x = of.column - tile_.column + 1, y = of.row - tile_.row + 1;
        if (x < 0 || x > 2 || y < 0 || y > 2) return false;
        std::optional<query::Reader>& reader = readers_[3 * static_cast<std::size_t>(y) + static_cast<std::size_t>(x)];
        if (!reader) reader.emplace(t_, of.column, of.row);
        const query::Sample sample = reader->read(at);
        height_m = sample.steps * static_cast<double>(t_.header.quantum_m);
        return sample.loaded && !sample.hole;
    }
    // Between four samples.
    [[nodiscard]] bool read(double x, double y, double& height_m) {
        const SampleIndex at{static_cast<std::int32_t>(std::floor(x)), static_cast<std::int32_t>(std::floor(y))};
        double h[4];
        if (!read(at, h[0]) || !read(at + SampleIndex{1, 0}, h[1]) || !read(at + SampleIndex{0, 1}, h[2]) ||
            !read(at + SampleIndex{1, 1}, h[3]))
            return false;
        const double u = x - at.column, v = y - at.row;
        const double north = h[0] + (h[1] - h[0]) * u, south = h[2] + (h[3] - h[2]) * u;
        height_m = north + (south - north) * v;
        return true;
    }

private:
    const TerrainData& t_;
    const SampleIndex tile_;
    const std::int32_t columns_, rows_;
    std::array<std::optional<query::Reader>, 9> readers_;
};

using Codes = std::uint8_t[horizon_planes];

bool is_in(const Rect& rect, SampleIndex at) {
    return rect.contains({at.column, at.row, at.column, at.row});
}

class Raiser {
public:
    Raiser(const TerrainData& terrain, const Rect& edited, SampleIndex tile)
        : edited_(edited), heights_(terrain, tile), spacing_m_{static_cast<double>(terrain.spacing_x_m),
                                                               static_cast<double>(terrain.spacing_z_m)},
          unit_m_(std::min(spacing_m_[0], spacing_m_[1])) {
        for (double d = 1; d <= horizon_reach && step_count_ < most_steps; d = std::max(d + 1, d * horizon_growth))
            steps_[step_count_++] = d;
    }

    // One texel's codes; at: the sample where it stands. False: none has changed.
    bool raise(SampleIndex at, Codes& codes) {
        double own_m = 0;
        if (!is_in(edited_.grown(horizon_reach), at) || !heights_.read(at, own_m)) return false;
        const bool inside = is_in(edited_, at);
        Codes raised;
        bool changed = false;
        for (std::size_t i = 0; i < horizon_directions; ++i) {
            const double tangent = march(at, own_m, i, inside);
            const auto code = nearest<std::uint8_t>(255 * tangent / std::sqrt(1 + tangent * tangent));
            raised[i] = std::max(codes[i], code);
            changed = changed || raised[i] != codes[i];
        }
        if (!changed) return false;
        // The share of the sky falls as the light above these horizons does.
        const double before = sky(at, codes), after = sky(at, raised);
        raised[horizon_directions] =
            before > 0 ? nearest<std::uint8_t>(codes[horizon_directions] * std::min(after / before, 1.0))
                       : codes[horizon_directions];
        std::copy_n(raised, horizon_planes, codes);
        return true;
    }

private:
    // The largest tangent of moved ground's elevation; of a texel that has moved itself, of all ground's.
    [[nodiscard]] double march(SampleIndex at, double own_m, std::size_t direction, bool inside) {
        const double east = horizon_east[direction] * unit_m_ / spacing_m_[0],
                     south = horizon_south[direction] * unit_m_ / spacing_m_[1];
        double tangent = 0;
        for (std::size_t k = 0; k < step_count_; ++k) {
            const double d = steps_[k], x = at.column + d * east, y = at.row + d * south;
            const SampleIndex near{static_cast<std::int32_t>(std::floor(x + 0.5)),
                                   static_cast<std::int32_t>(std::floor(y + 0.5))};
            if (!inside && !is_in(edited_, near)) continue;
            double height_m = 0;
            if (d < smooth_until ? heights_.read(x, y, height_m) : heights_.read(near, height_m))
                tangent = std::max(tangent, (height_m - own_m) / (d * unit_m_));
        }
        return tangent;
    }

    [[nodiscard]] double sky(SampleIndex at, const Codes& codes) {
        double west = 0, east = 0, north = 0, south = 0;
        if (!heights_.read(at + SampleIndex{-1, 0}, west) || !heights_.read(at + SampleIndex{1, 0}, east) ||
            !heights_.read(at + SampleIndex{0, -1}, north) || !heights_.read(at + SampleIndex{0, 1}, south))
            west = east = north = south = 0;
        const double x = (east - west) / (2 * spacing_m_[0]), z = (south - north) / (2 * spacing_m_[1]);
        const double up = 1 / std::sqrt(1 + x * x + z * z);
        double light = 0;
        for (std::size_t i = 0; i < horizon_directions; ++i) {
            const double rise = x * horizon_east[i] + z * horizon_south[i], own = std::max(rise, 0.0);
            const double sine = std::max(codes[i] / 255.0, own / std::sqrt(1 + own * own));
            light += static_cast<double>(
                sky_above(static_cast<float>(sine), static_cast<float>(-rise * up), static_cast<float>(up)));
        }
        return light;
    }

    const Rect edited_;
    Heights heights_;
    const double spacing_m_[2], unit_m_;
    std::array<double, most_steps> steps_{};
    std::size_t step_count_ = 0;
};

// The 16 planes' blocks of the same 4 x 4 texels.
class Planes {
public:
    Planes(std::byte* blocks, std::uint32_t side, std::uint32_t x, std::uint32_t y)
        : first_(blocks + 8 * (std::size_t{y / 4} * side + x / 4)), side_(side) {
        std::byte together[horizon_block_bytes];
        for (std::uint32_t plane = 0; plane < horizon_planes; ++plane) std::memcpy(together + 8 * plane, at(plane), 8);
        (void)decode_horizon(together, 4, {&codes[0][0], sizeof(codes)});
        std::memcpy(before_, codes, sizeof(codes));
    }
    void store() const {
        for (std::uint32_t plane = 0; plane < horizon_planes; ++plane) {
            std::uint8_t values[16];
            bool changed = false;
            for (std::uint32_t i = 0; i < 16; ++i) {
                values[i] = codes[i][plane];
                changed = changed || values[i] != before_[i][plane];
            }
            if (changed) encode_bc4({values, values + 4, values + 8, values + 12}, 1, at(plane));
        }
    }
    Codes codes[16];

private:
    // A picture of four planes by four; a row of blocks of it has as many blocks as a plane has texels a side.
    [[nodiscard]] std::byte* at(std::uint32_t plane) const {
        const std::size_t across = side_ / 4, down = std::size_t{plane / horizon_planes_across} * across;
        return first_ + 8 * (down * side_ + plane % horizon_planes_across * across);
    }
    std::byte* first_;
    std::uint32_t side_;
    Codes before_[16];
};

} // namespace

Rect edited_near(const TerrainData& t, std::uint32_t tile) {
    Rect edited;
    if (t.edits == nullptr) return edited;
    const SampleIndex place = t.tile_xy(tile);
    const std::int32_t side = t.tree.side();
    const Rect seen =
        Rect{place.column * side, place.row * side, (place.column + 1) * side, (place.row + 1) * side}.grown(
            horizon_reach);
    for (std::uint32_t n = 0; n < t.edits->block_count; ++n) {
        const Block& b = t.edits->blocks[n];
        const std::int32_t x = b.x << block_log2, y = b.y << block_log2;
        const Rect samples{x, y, x + block_side - 1, y + block_side - 1};
        if (samples.meets(seen)) edited = edited.with(samples);
    }
    return edited;
}

void raise_horizons(const TerrainData& t, const Rect& edited, std::uint32_t tile, std::uint32_t side_log2,
                    std::byte* blocks) {
    if (edited.empty()) return;
    const SampleIndex place = t.tile_xy(tile);
    const SampleIndex first{place.column << t.tree.tile_log2, place.row << t.tree.tile_log2};
    const PaintGrid grid(t.header, t.header.horizon_log2, side_log2, first);
    Raiser raiser(t, edited, place);
    const std::uint32_t side = 1u << side_log2;
    const auto sample_of = [&](std::int32_t from, std::uint32_t texel, std::int32_t last) {
        return std::clamp(static_cast<std::int32_t>(std::floor(from + texel * grid.spacing + 0.5)), 0, last);
    };
    for (std::uint32_t y = 0; y < side; y += 4)
        for (std::uint32_t x = 0; x < side; x += 4) {
            const Rect near{sample_of(first.column, x, grid.last.column), sample_of(first.row, y, grid.last.row),
                            sample_of(first.column, x + 3, grid.last.column),
                            sample_of(first.row, y + 3, grid.last.row)};
            if (!near.grown(horizon_reach).meets(edited)) continue;
            Planes planes(blocks, side, x, y);
            bool changed = false;
            for (std::uint32_t i = 0; i < 16; ++i)
                changed = raiser.raise({sample_of(first.column, x + i % 4, grid.last.column),
                                        sample_of(first.row, y + i / 4, grid.last.row)},
                                       planes.codes[i]) ||
                          changed;
            if (changed) planes.store();
        }
}

} // namespace fjell::edit
