// The grids of all mips and what of them a tile needs; the mips themselves by tents (tent.h), blocks by blocks.h.
//
// A tile's near mips need texels around it: mip 2 sees mip 1 as far as its own texels are apart, mip 1 sees mip 0, mip
// 0 the samples. All of them are computed from the samples around the tile, a few percent more than its own, and equal
// what the neighbour computes bit for bit.
#include "baker/maps/maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "baker/maps/base_mip.h"
#include "fjell/pack.h"
#include "fjell/texture.h"
#include "shared/block_codes.h"
#include "shared/compiler.h"
#include "shared/paint.h"

namespace fjell::baker {

namespace {

constexpr float normal_unit = 32767, light_unit = 65535;

std::int32_t side_of(const MapPlan& plan, MapKind kind, std::uint32_t mip) {
    return std::int32_t{1} << (plan.log2_side(kind) - mip);
}

Window seen(const TentAxis (&axes)[2], const Window& texels) {
    const std::int32_t x = axes[0].first(texels.x), y = axes[1].first(texels.y);
    return {x, y, axes[0].end(texels.x + texels.columns - 1) - x, axes[1].end(texels.y + texels.rows - 1) - y};
}

// From the texels of mip - 1 to those of mip.
struct MipAxes {
    TentAxis axes[2];
};
MipAxes mip_axes(const MapPlan& plan, MapKind kind, std::uint32_t mip) {
    const std::int64_t finer = side_of(plan, kind, mip - 1) - 1, coarser = side_of(plan, kind, mip) - 1;
    const Window grid = plan.grid(kind, mip - 1);
    return {{{finer, coarser, 1e18, 1, 0, grid.columns}, {finer, coarser, 1e18, 1, 0, grid.rows}}};
}

std::uint32_t near_count(const MapPlan& plan, MapKind kind) {
    return std::min(near_mips, mip_count(plan.log2_side(kind)));
}

// The texels of mips 0.. that the near mips of a tile are made from, each with what the next one sees of it.
std::vector<Window> near_windows(const MapPlan& plan, MapKind kind, std::uint32_t tile) {
    std::vector<Window> windows(near_count(plan, kind));
    for (std::size_t m = windows.size(); m-- > 0;)
        windows[m] = m + 1 == windows.size()
                         ? plan.texels(kind, static_cast<std::uint32_t>(m), tile)
                         : seen(mip_axes(plan, kind, static_cast<std::uint32_t>(m) + 1).axes, windows[m + 1]);
    return windows;
}

class PlaneRows : public RowSource {
public:
    PlaneRows(const TexelPlanes& planes, std::int32_t first_column)
        : planes_(planes), skip_(first_column - planes.at.x) {}
    void prepare(std::int32_t, std::int32_t) override {}
    [[nodiscard]] const float* row(int c, std::int32_t y) const override { return planes_.row(c, y) + skip_; }

private:
    const TexelPlanes& planes_;
    std::int32_t skip_;
};

TexelPlanes coarser(const MipAxes& from, const TexelPlanes& finer, const Window& texels) {
    const Taps x = make_taps(from.axes[0], texels.x, texels.columns),
               y = make_taps(from.axes[1], texels.y, texels.rows);
    PlaneRows rows(finer, x.source_first);
    return tent_filter(x, y, texels, rows, static_cast<int>(finer.channel.size()));
}

// ---- texels to blocks and to 16 bits --------------------------------------------------------------------------------

std::uint16_t light16(float light) {
    return static_cast<std::uint16_t>(std::clamp(light, 0.0f, 1.0f) * light_unit + 0.5f);
}
float unit_clamped(float v) {
    v = v < -1 ? -1 : v;
    return v > 1 ? 1 : v;
}

FJELL_CLONES void to_light16(const float* light, std::size_t n, std::uint16_t* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < n; ++i) {
        float v = light[i] < 0 ? 0 : light[i];
        v = v > 1 ? 1 : v;
        to[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(v * light_unit + 0.5f));
    }
}
void to_srgb(const float* light, std::size_t n, std::uint8_t* to) {
    const std::uint8_t* const code = srgb_of_light();
    std::uint16_t light16[64];
    for (std::size_t first = 0; first < n; first += 64) {
        const std::size_t count = std::min<std::size_t>(64, n - first);
        to_light16(light + first, count, light16);
        for (std::size_t i = 0; i < count; ++i) to[first + i] = code[light16[i]];
    }
}
FJELL_CLONES void to_normal_codes(const float* from, std::size_t n, std::uint8_t* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < n; ++i) {
        float v = from[i] < -1 ? -1 : from[i];
        v = v > 1 ? 1 : v;
        to[i] = static_cast<std::uint8_t>(static_cast<std::int32_t>(v * 127.0f + 128.5f));
    }
}

FJELL_CLONES void to_unit_codes(const float* from, std::size_t n, std::uint8_t* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < n; ++i) {
        float v = from[i] < 0 ? 0 : from[i];
        v = v > 1 ? 1 : v;
        to[i] = static_cast<std::uint8_t>(static_cast<std::int32_t>(v * 255.0f + 0.5f));
    }
}

// Planes side by side: fjell/texture.h.
Buffer<std::byte> compress_horizons(const TexelPlanes& planes, const Window& tile) {
    const auto side = static_cast<std::size_t>(tile.columns), across = side / 4;
    const std::size_t row_bytes = across * horizon_planes_across * 8;
    Buffer<std::byte> blocks(across * across * horizon_block_bytes);
    std::vector<std::uint8_t> codes(side * 4);
    for (std::size_t plane = 0; plane < horizon_planes; ++plane)
        for (std::size_t j = 0; j < across; ++j) {
            const std::uint8_t* rows[4];
            for (std::size_t i = 0; i < 4; ++i) {
                to_unit_codes(planes.row(static_cast<int>(plane), tile.y + static_cast<std::int32_t>(4 * j + i)) +
                                  (tile.x - planes.at.x),
                              side, codes.data() + i * side);
                rows[i] = codes.data() + i * side;
            }
            encode_bc4(rows, across,
                       blocks.data() + (plane / horizon_planes_across * across + j) * row_bytes +
                           plane % horizon_planes_across * across * 8);
        }
    return blocks;
}

Buffer<std::byte> splat_texels(const TexelPlanes& planes, const Window& tile) {
    Buffer<std::byte> texels(tile.area() * splat_texel_bytes);
    std::byte* to = texels.data();
    float shares[max_splat_names];
    for (std::int32_t y = tile.y; y < tile.y + tile.rows; ++y)
        for (std::int32_t x = tile.x; x < tile.x + tile.columns; ++x, to += splat_texel_bytes) {
            for (std::size_t c = 0; c < max_splat_names; ++c)
                shares[c] = planes.row(static_cast<int>(c), y)[x - planes.at.x];
            edit::store_splat_texel(shares, to);
        }
    return texels;
}

// Blocks of the tile's own texels; planes may hold more around them.
Buffer<std::byte> compress(MapKind kind, const TexelPlanes& planes, const Window& tile) {
    if (kind == MapKind::horizon) return compress_horizons(planes, tile);
    if (kind == MapKind::splat) return splat_texels(planes, tile);
    const bool colour = kind == MapKind::colour;
    const auto side = static_cast<std::size_t>(tile.columns), across = side / 4;
    const std::size_t row_bytes = across * (colour ? colour_block_bytes : normal_block_bytes);
    Buffer<std::byte> blocks(across * row_bytes);
    std::vector<std::uint8_t> codes(side * 4 * 3);
    for (std::size_t j = 0; j < across; ++j) {
        ColourRows rgb{};
        NormalRows xz{};
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t c = 0; c < channels(kind); ++c) {
                const float* const from =
                    planes.row(static_cast<int>(c), tile.y + static_cast<std::int32_t>(4 * j + i)) +
                    (tile.x - planes.at.x);
                std::uint8_t* const to = codes.data() + (i * 3 + c) * side;
                colour ? to_srgb(from, side, to) : to_normal_codes(from, side, to);
                (colour ? rgb.rows[i][c] : xz.rows[i][c % 2]) = to;
            }
        std::byte* const to = blocks.data() + j * row_bytes;
        colour ? encode_bc1(rgb, across, to) : encode_bc5(xz, across, to);
    }
    return blocks;
}

Texels stored(MapKind kind, const TexelPlanes& planes, const Window& tile) {
    const std::size_t n = channels(kind);
    Texels texels(tile.area() * n);
    std::uint16_t* to = texels.data();
    for (std::int32_t y = tile.y; y < tile.y + tile.rows; ++y)
        for (std::int32_t x = tile.x; x < tile.x + tile.columns; ++x)
            for (std::size_t c = 0; c < n; ++c) {
                const float v = planes.row(static_cast<int>(c), y)[x - planes.at.x];
                *to++ = kind != MapKind::normal ? light16(v)
                                                : static_cast<std::uint16_t>(static_cast<std::int32_t>(
                                                      unit_clamped(v) * normal_unit + 32768.5f));
            }
    return texels;
}

TexelPlanes loaded(MapKind kind, const Texels& texels, const Window& window) {
    const std::size_t n = channels(kind);
    TexelPlanes planes(window, static_cast<int>(n));
    for (std::size_t i = 0; i < window.area(); ++i)
        for (std::size_t c = 0; c < n; ++c) {
            const auto v = static_cast<float>(texels[i * n + c]);
            planes.channel[c][i] = kind != MapKind::normal ? v / light_unit : (v - 32768) / normal_unit;
        }
    return planes;
}

void lay(const edit::PaintedColour& painted, TexelPlanes& planes, std::size_t at) {
    for (std::size_t c = 0; c < 3; ++c)
        planes.channel[c][at] = painted.light[c] + std::max(1 - painted.share, 0.0f) * planes.channel[c][at];
}
void lay(const edit::PaintedMaterials& painted, TexelPlanes& planes, std::size_t at) {
    for (std::size_t c = 0; c < max_splat_names; ++c)
        planes.channel[c][at] = painted.of[c] + std::max(1 - painted.share, 0.0f) * planes.channel[c][at];
}

// Paint over texels of mip 0, as the runtime puts it over the pack's.
template <typename Painted>
void lay_paint(const MapPlan& plan, MapKind kind, TexelPlanes& planes) {
    const std::uint32_t log2 = plan.log2_side(kind);
    const edit::PaintGrid grid(plan.tree.tile_log2, {plan.tree.columns() - 1, plan.tree.rows() - 1}, log2, log2,
                               {0, 0});
    const auto sums = std::make_unique<Painted[]>(edit::painted_side * edit::painted_side);
    const Window& w = planes.at;
    for (std::int32_t y = 0; y < w.rows; y += edit::painted_side)
        for (std::int32_t x = 0; x < w.columns; x += edit::painted_side) {
            const edit::PaintedTexels group{w.x + x, w.y + y, std::min(edit::painted_side, w.columns - x),
                                            std::min(edit::painted_side, w.rows - y)};
            if (!edit::sum_paint(*plan.paint, grid, group, sums.get())) continue;
            for (std::int32_t j = 0; j < group.rows; ++j)
                for (std::int32_t i = 0; i < group.columns; ++i)
                    if (const Painted& painted = sums[static_cast<std::size_t>(j * edit::painted_side + i)];
                        painted.share > 0)
                        lay(painted, planes,
                            static_cast<std::size_t>(y + j) * static_cast<std::size_t>(w.columns) +
                                static_cast<std::size_t>(x + i));
        }
}

// All near mips of a kind, from the texels of mip 0.
std::vector<MipTexels> near_mips_of(const MapPlan& plan, MapKind kind, std::uint32_t tile,
                                    const std::vector<Window>& windows, TexelPlanes planes) {
    std::vector<MipTexels> mips(windows.size());
    if (plan.paint != nullptr && kind == MapKind::colour) lay_paint<edit::PaintedColour>(plan, kind, planes);
    if (plan.paint != nullptr && kind == MapKind::splat) lay_paint<edit::PaintedMaterials>(plan, kind, planes);
    for (std::uint32_t m = 0; m < mips.size(); ++m) {
        if (m > 0) planes = coarser(mip_axes(plan, kind, m), planes, windows[m]);
        const Window own = plan.texels(kind, m, tile);
        if (plan.stored == nullptr || plan.stored->contains(tile)) mips[m].blocks = compress(kind, planes, own);
        if (m + 1 == mips.size()) mips[m].texels = stored(kind, planes, own);
    }
    return mips;
}

} // namespace

std::uint32_t MapPlan::log2_side(MapKind kind) const {
    const std::uint32_t log2[map_kind_count] = {colour_log2, normal_log2, horizon_log2, splat_log2};
    return log2[static_cast<std::size_t>(kind)];
}

int MapPlan::stride_log2(MapKind kind) const {
    return std::max(tree.tile_log2 - static_cast<int>(log2_side(kind)), 0);
}

Window MapPlan::grid(MapKind kind, std::uint32_t mip) const {
    const std::int32_t cells = side_of(*this, kind, mip) - 1;
    return {0, 0, tree.tiles_x * cells + 1, tree.tiles_y * cells + 1};
}

Window MapPlan::texels(MapKind kind, std::uint32_t mip, std::uint32_t tile) const {
    const std::int32_t side = side_of(*this, kind, mip);
    const auto tiles_x = static_cast<std::uint32_t>(tree.tiles_x);
    return {static_cast<std::int32_t>(tile % tiles_x) * (side - 1),
            static_cast<std::int32_t>(tile / tiles_x) * (side - 1), side, side};
}

SampleAxes sample_axes(const MapPlan& plan, MapKind kind) {
    const std::int64_t cells = side_of(plan, kind, 0) - 1, samples = plan.tree.side();
    return {{{samples, cells, plan.tree.columns() - 1.0, 1, 0, plan.tree.columns()},
             {samples, cells, plan.tree.rows() - 1.0, 1, 0, plan.tree.rows()}}};
}

namespace {

// What normals, and colours by steepness, are made from.
Window shapes_for_maps(const MapPlan& plan, std::uint32_t tile) {
    std::int32_t x0 = plan.tree.columns(), y0 = plan.tree.rows(), x1 = 0, y1 = 0;
    for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
        if (plan.log2_side(kind) == 0) continue;
        const Window w = seen(sample_axes(plan, kind).axes, near_windows(plan, kind, tile).front());
        x0 = std::min(x0, w.x), y0 = std::min(y0, w.y);
        x1 = std::max(x1, w.x + w.columns), y1 = std::max(y1, w.y + w.rows);
    }
    if (x1 == 0) return {};
    // Normals are differences to the samples beside.
    x0 = std::max(x0 - 1, 0), y0 = std::max(y0 - 1, 0);
    x1 = std::min(x1 + 1, plan.tree.columns()), y1 = std::min(y1 + 1, plan.tree.rows());
    return {x0, y0, x1 - x0, y1 - y0};
}

} // namespace

Window heights_for_maps(const MapPlan& plan, std::uint32_t tile) {
    return heights_for_smooth(plan.smooth, shapes_for_maps(plan, tile));
}

NearMaps near_maps(const MapPlan& plan, std::uint32_t tile, const HeightWindow& heights, ImageReader* reader) {
    NearMaps maps;
    Buffer<float> smooth;
    GroundWindows ground{heights, heights};
    if (plan.smooth.smooths()) {
        const Window at = shapes_for_maps(plan, tile);
        smooth = smooth_heights(plan.smooth, heights, at);
        ground.shape = {smooth.data(), at.columns, at};
    }
    if (plan.colour_log2 != 0) {
        const auto windows = near_windows(plan, MapKind::colour, tile);
        maps.colour =
            near_mips_of(plan, MapKind::colour, tile, windows, base_colours(plan, ground, windows.front(), reader));
    }
    if (plan.normal_log2 != 0) {
        const auto windows = near_windows(plan, MapKind::normal, tile);
        maps.normal =
            near_mips_of(plan, MapKind::normal, tile, windows, base_normals(plan, ground.shape, windows.front()));
    }
    return maps;
}

namespace {

// From points to the texels of mip 0. Texels on the rim stand where the last point would, were it not beyond it.
SampleAxes point_axes(const MapPlan& plan, MapKind kind) {
    SampleAxes axes = sample_axes(plan, kind);
    const int stride_log2 = plan.stride_log2(kind);
    for (TentAxis& axis : axes.axes) {
        axis.scale = std::ldexp(1.0, -stride_log2);
        axis.size = ((axis.size - 2) >> stride_log2) + 2; // the last one on the rim or beyond it
    }
    return axes;
}

} // namespace

Window points_for_map(const MapPlan& plan, MapKind kind, std::uint32_t tile) {
    return seen(point_axes(plan, kind).axes, near_windows(plan, kind, tile).front());
}

std::vector<MipTexels> near_mips_from(const MapPlan& plan, MapKind kind, std::uint32_t tile,
                                      const TexelPlanes& points) {
    const auto windows = near_windows(plan, kind, tile);
    const SampleAxes from = point_axes(plan, kind);
    return near_mips_of(plan, kind, tile, windows, coarser({{from.axes[0], from.axes[1]}}, points, windows.front()));
}

Window finer_texels(const MapPlan& plan, MapKind kind, std::uint32_t mip, std::uint32_t tile) {
    return finer_texels(plan, kind, mip, plan.texels(kind, mip, tile));
}

Window finer_texels(const MapPlan& plan, MapKind kind, std::uint32_t mip, const Window& texels) {
    return seen(mip_axes(plan, kind, mip).axes, texels);
}

MipTexels far_mip(const MapPlan& plan, MapKind kind, std::uint32_t mip, std::uint32_t tile, const Texels& finer) {
    const Window own = plan.texels(kind, mip, tile);
    const TexelPlanes planes =
        coarser(mip_axes(plan, kind, mip), loaded(kind, finer, finer_texels(plan, kind, mip, tile)), own);
    return {compress(kind, planes, own), stored(kind, planes, own)};
}

} // namespace fjell::baker
