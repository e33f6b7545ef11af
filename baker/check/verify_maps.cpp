// Every decoded texel stands for an interval: its value and what its block may be off by. Borders: both neighbours'
// intervals must meet. Mips: a tent over the finer mip's lower and upper ends is an interval again, and must meet the
// coarser texel's. Tents that reach over the tile's border are left out; the neighbour comparison covers those texels.
#include "baker/check/verify_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "baker/maps/colour.h"
#include "fjell/io/failure.h"
#include "fjell/texture.h"

namespace fjell::baker {

namespace {

struct Mip {
    std::uint32_t side = 0, channels = 0;
    std::vector<std::uint8_t> codes;     // interleaved
    std::vector<std::uint8_t> tolerance; // a texel
    std::vector<std::byte> stored;       // of a splat map: its texels

    [[nodiscard]] std::size_t at(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * side + x; }
    [[nodiscard]] int code(std::size_t texel, std::uint32_t c) const { return codes[texel * channels + c]; }
};

// Brings a chunk, decompressed; throws Failure.
using ReadChunk = std::function<void(ChunkId id, std::vector<std::byte>& raw)>;

std::uint32_t log2_of(const PackHeader& h, ChunkKind kind) {
    switch (kind) {
    case ChunkKind::colour: return h.colour_log2;
    case ChunkKind::normal: return h.normal_log2;
    case ChunkKind::horizon: return h.horizon_log2;
    default: return h.splat_log2;
    }
}

const char* name_of(ChunkKind kind) {
    switch (kind) {
    case ChunkKind::colour: return "colour";
    case ChunkKind::normal: return "normal";
    case ChunkKind::horizon: return "horizon";
    default: return "splat";
    }
}

// Of splat texels: a channel a material. Weights are rounded, and what a fifth material had went to the other four,
// none of which had less: where the fourth has nothing, nothing was left out.
void decode_splat(const std::vector<std::byte>& texels, std::size_t names, Mip& mip) {
    for (std::size_t i = 0; i < mip.tolerance.size(); ++i) {
        const std::byte* const from = texels.data() + i * splat_texel_bytes;
        std::uint8_t* const to = mip.codes.data() + i * mip.channels;
        int last = 0;
        for (std::size_t k = 0; k < splat_layers; ++k) {
            last = std::to_integer<int>(from[2 * k]);
            const std::size_t layer = std::to_integer<std::size_t>(from[2 * k + 1]) % max_splat_names;
            to[layer] = static_cast<std::uint8_t>(to[layer] + last);
        }
        const int hidden = last > 0 && names > splat_layers ? static_cast<int>(names - splat_layers) * (last + 1) : 0;
        mip.tolerance[i] = static_cast<std::uint8_t>(std::min(3 + hidden, 255));
    }
}

// names: of materials.
Mip decode(const PackHeader& header, const ReadChunk& read, ChunkId id, std::size_t names) {
    const bool colour = id.kind == ChunkKind::colour;
    Mip mip{(1u << log2_of(header, id.kind)) >> id.item,
            colour                         ? 3u
            : id.kind == ChunkKind::normal ? 2u
                                           : 16u,
            {},
            {},
            {}};
    std::vector<std::byte> blocks;
    read(id, blocks);
    mip.codes.resize(std::size_t{mip.side} * mip.side * mip.channels);
    mip.tolerance.resize(std::size_t{mip.side} * mip.side);
    if (id.kind == ChunkKind::splat) {
        decode_splat(blocks, names, mip);
        mip.stored = std::move(blocks);
        return mip;
    }
    (void)(colour                         ? decode_colour(blocks, mip.side, mip.codes)
           : id.kind == ChunkKind::normal ? decode_normal(blocks, mip.side, mip.codes)
                                          : decode_horizon(blocks, mip.side, mip.codes));
    for (std::uint32_t y = 0; y < mip.side; y += 4)
        for (std::uint32_t x = 0; x < mip.side; x += 4) {
            int range = 0;
            for (std::uint32_t c = 0; c < mip.channels; ++c) {
                int low = 255, high = 0;
                for (std::uint32_t i = 0; i < 16; ++i) {
                    const int v = mip.code(mip.at(x + i % 4, y + i / 4), c);
                    low = std::min(low, v), high = std::max(high, v);
                }
                range = std::max(range, high - low);
            }
            const auto wide = static_cast<std::uint32_t>(range);
            const std::uint32_t off = std::min(colour ? colour_tolerance(wide) : normal_tolerance(wide), 255u);
            for (std::uint32_t i = 0; i < 16; ++i)
                mip.tolerance[mip.at(x + i % 4, y + i / 4)] = static_cast<std::uint8_t>(off);
        }
    return mip;
}

class Checker {
public:
    Checker(const Pack& the_pack, ReadChunk the_read) : pack(the_pack), read(std::move(the_read)) {}

    MapsReport run() {
        if (pack.header.layer_bytes != 0) {
            std::vector<std::byte> text;
            read({ChunkKind::layers, 0, 0}, text);
            names = io::layer_names({reinterpret_cast<const char*>(text.data()), text.size()}).size();
        }
        for (const ChunkKind kind : {ChunkKind::colour, ChunkKind::normal, ChunkKind::horizon, ChunkKind::splat})
            check_kind(kind);
        if (colour_borders) report.colour_border_mean = colour_sum / static_cast<double>(colour_borders);
        if (normal_borders) report.normal_border_mean = normal_sum / static_cast<double>(normal_borders);
        if (horizon_borders) report.horizon_border_mean = horizon_sum / static_cast<double>(horizon_borders);
        report.border_texels = colour_borders + normal_borders + horizon_borders + splat_borders;
        return report;
    }

private:
    struct Border {
        std::vector<std::uint8_t> codes, tolerance;
        std::vector<std::byte> stored;
    };

    void check_kind(ChunkKind kind) {
        const std::uint32_t mips = mip_count(log2_of(pack.header, kind));
        const std::uint32_t tiles_x = pack.header.tiles_x;
        std::vector<Border> east(mips), south(std::size_t{mips} * tiles_x);
        std::vector<std::uint64_t> below(tiles_x, 0); // the place after which south's border was the last one's, + 1
        std::uint64_t after = 0;                      // the same of east
        for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) {
            Mip finer;
            const std::uint64_t at = pack.tile_place(tile);
            const std::size_t column = at % tiles_x;
            const bool has_west = column > 0 && after == at, has_north = below[column] == at + 1;
            after = at + 1;
            below[column] = at + tiles_x + 1;
            for (std::uint32_t level = 0; level < mips; ++level) {
                place = {kind, tile, level};
                Mip mip = decode(pack.header, read, place, names);
                report.texels += mip.tolerance.size();
                if (kind == ChunkKind::normal) check_lengths(mip);
                if (kind == ChunkKind::splat) check_texels(mip);
                if (level > 0) check_tent(finer, mip);
                if (has_west) compare(east[level], border(mip, 0, 0, 0, 1), "west");
                Border& above = south[std::size_t{level} * tiles_x + column];
                if (has_north) compare(above, border(mip, 0, 0, 1, 0), "north");
                east[level] = border(mip, mip.side - 1, 0, 0, 1);
                above = border(mip, 0, mip.side - 1, 1, 0);
                finer = std::move(mip);
            }
        }
    }

    static Border border(const Mip& mip, std::uint32_t x, std::uint32_t y, std::uint32_t dx, std::uint32_t dy) {
        Border b;
        for (std::uint32_t i = 0; i < mip.side; ++i, x += dx, y += dy) {
            for (std::uint32_t c = 0; c < mip.channels; ++c)
                b.codes.push_back(mip.codes[mip.at(x, y) * mip.channels + c]);
            b.tolerance.push_back(mip.tolerance[mip.at(x, y)]);
            if (mip.stored.empty()) continue;
            const auto texel = mip.stored.begin() + static_cast<std::ptrdiff_t>(mip.at(x, y) * splat_texel_bytes);
            b.stored.insert(b.stored.end(), texel, texel + splat_texel_bytes);
        }
        return b;
    }

    // Nothing was compressed: equal bit for bit.
    void compare_stored(const Border& theirs, const Border& ours, const char* side) {
        splat_borders += ours.tolerance.size();
        for (std::size_t i = 0; i < ours.tolerance.size(); ++i)
            if (!std::equal(&ours.stored[i * splat_texel_bytes],
                            &ours.stored[i * splat_texel_bytes] + splat_texel_bytes,
                            &theirs.stored[i * splat_texel_bytes]))
                note(report.border_violations,
                     fmt::format("texel {} of the {} border is not the neighbour's", i, side));
    }

    void compare(const Border& theirs, const Border& ours, const char* side) {
        if (place.kind == ChunkKind::splat) return compare_stored(theirs, ours, side);
        const bool colour = place.kind == ChunkKind::colour, horizon = place.kind == ChunkKind::horizon;
        const std::size_t channels = ours.codes.size() / ours.tolerance.size();
        double& sum = colour ? colour_sum : horizon ? horizon_sum : normal_sum;
        std::uint32_t& most = colour    ? report.colour_border_most
                              : horizon ? report.horizon_border_most
                                        : report.normal_border_most;
        for (std::size_t i = 0; i < ours.codes.size(); ++i) {
            const auto off = static_cast<std::uint32_t>(std::abs(theirs.codes[i] - ours.codes[i]));
            const std::uint32_t allowed = theirs.tolerance[i / channels] + ours.tolerance[i / channels];
            sum += off;
            most = std::max(most, off);
            if (off > allowed)
                note(report.border_violations,
                     fmt::format("texel {} of the {} border differs from the neighbour's by {} "
                                 "codes, more than the {} of compression",
                                 i / channels, side, off, allowed));
        }
        (colour ? colour_borders : horizon ? horizon_borders : normal_borders) += ours.codes.size();
    }

    // The largest weight first, no more than all of the ground, and materials that there are.
    void check_texels(const Mip& mip) {
        for (std::size_t i = 0; i < mip.tolerance.size(); ++i) {
            int sum = 0, before = 255;
            bool good = true;
            for (std::size_t k = 0; k < splat_layers; ++k) {
                const int weight = std::to_integer<int>(mip.stored[i * splat_texel_bytes + 2 * k]);
                const auto layer = std::to_integer<std::size_t>(mip.stored[i * splat_texel_bytes + 2 * k + 1]);
                good &= weight <= before && (weight == 0 ? layer == 0 : layer < names);
                sum += before = weight;
            }
            if (!good || sum > 255)
                note(report.weight_violations,
                     fmt::format("the texel at ({}, {}) has weights or materials that cannot be", i % mip.side,
                                 i / mip.side));
        }
    }

    void check_lengths(const Mip& mip) {
        for (std::size_t i = 0; i < mip.tolerance.size(); ++i) {
            const double length =
                std::hypot(normal_component(mip.codes[2 * i]), normal_component(mip.codes[2 * i + 1]));
            if (length > 1 + std::sqrt(2.0) * mip.tolerance[i] / 127)
                note(report.length_violations,
                     fmt::format("the normal at ({}, {}) is {:.3f} long", i % mip.side, i / mip.side, length));
        }
    }

    // The ends of a texel's interval, in what tents are made in: light, or the codes themselves.
    [[nodiscard]] double end(int code, int off) const {
        const auto v = static_cast<float>(std::clamp(code + off, 0, 255));
        return place.kind == ChunkKind::colour ? light_of_srgb(v) : v;
    }

    void check_tent(const Mip& finer, const Mip& mip) {
        const double step = (finer.side - 1.0) / (mip.side - 1.0);
        const double rounding = place.kind == ChunkKind::colour ? 2e-4 : 1.0; // of codes, on the way
        for (std::uint32_t y = 1; y + 1 < mip.side; ++y)
            for (std::uint32_t x = 1; x + 1 < mip.side; ++x)
                for (std::uint32_t c = 0; c < mip.channels; ++c) {
                    double sum = 0, low = 0, high = 0;
                    for (auto v = static_cast<std::uint32_t>(std::ceil((y - 1) * step)); v <= (y + 1) * step; ++v)
                        for (auto u = static_cast<std::uint32_t>(std::ceil((x - 1) * step)); u <= (x + 1) * step; ++u) {
                            const double w = (step - std::abs(u - x * step)) * (step - std::abs(v - y * step));
                            const std::size_t i = finer.at(u, v);
                            sum += w;
                            low += w * end(finer.code(i, c), -finer.tolerance[i]);
                            high += w * end(finer.code(i, c), finer.tolerance[i]);
                        }
                    const std::size_t i = mip.at(x, y);
                    if (end(mip.code(i, c), mip.tolerance[i]) + rounding < low / sum ||
                        end(mip.code(i, c), -mip.tolerance[i]) - rounding > high / sum)
                        note(report.mip_violations,
                             fmt::format("texel ({}, {}) is no average of the mip before", x, y));
                }
    }

    void note(std::uint64_t& counter, const std::string& what) {
        ++counter;
        if (!report.first.empty()) return;
        report.first = fmt::format("{} map of tile {}, mip {}: {}", name_of(place.kind), place.tile, place.item, what);
    }

    const Pack& pack;
    const ReadChunk read;
    MapsReport report;
    ChunkId place;
    double colour_sum = 0, normal_sum = 0, horizon_sum = 0;
    std::uint64_t colour_borders = 0, normal_borders = 0, horizon_borders = 0, splat_borders = 0;
    std::size_t names = 0; // of materials
};

} // namespace

MapsReport check_maps(const Pack& pack) {
    const auto read = [&](ChunkId id, std::vector<std::byte>& raw) {
        raw.resize(chunk_raw_bytes(pack.header, id));
        if (const Status s = read_chunk(pack, id, raw); !s.ok())
            throw io::Failure(1, fmt::format("{}: {}", io::chunk_name(id), message(s.code)));
    };
    return Checker(pack, read).run();
}

MapsReport check_maps(const io::PackFile& file) {
    return Checker(file.pack(), [&](ChunkId id, std::vector<std::byte>& raw) { file.read_chunk(id, raw); }).run();
}

} // namespace fjell::baker
