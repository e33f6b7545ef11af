// A map of a pack as a picture of its ground, at any place and as coarse as it is wanted: its colours, the share of the
// sky that a place sees, or the share of water in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fjell/io/pack_file.h"

namespace fjell::baker {

// One thread. Memory: what it has decoded, at most 64 MB and one map more.
class PackMap {
public:
    // sky: of the horizon maps. water: what the splat maps call so.
    enum class Kind : std::uint8_t { colour, sky, water };

    PackMap(const std::string& path, Kind kind); // throws Failure 1: no pack, or a pack without such maps
    [[nodiscard]] static bool has(const std::string& path, Kind kind);

    // Bilinear, of the coarsest mip whose texels are no wider than texel_m. Colours are sRGB; shares are three times
    // the same, 255 for all. Beyond the ground: grey, all of the sky, no water.
    using Texel = std::array<std::uint8_t, 3>;
    [[nodiscard]] Texel at(double column, double row, double texel_m);

    // Of columns x rows texels; place(u, v) gives a sample's column and row, or nothing, for 0 to 1 from the west and
    // from the north. It is asked at middles of some texels, between them, and a few texels beyond (TexelPlaces).
    using Place = std::function<std::optional<std::array<double, 2>>(double u, double v)>;
    [[nodiscard]] std::vector<std::uint8_t> picture(std::uint32_t columns, std::uint32_t rows, double texel_m,
                                                    const Place& place);

private:
    using Map = std::vector<std::uint8_t>;
    [[nodiscard]] std::size_t channels() const { return kind_ == Kind::colour ? 3 : 1; }
    [[nodiscard]] const Map& map_of(std::uint32_t tile, std::uint32_t mip);
    void decode(std::uint32_t side, Map& to) const; // blocks_

    Kind kind_;
    io::PackFile file_;
    std::uint32_t log2_ = 0;                                      // texels a side of the finest maps
    int water_ = -1;                                              // its number in splat maps
    std::map<std::uint32_t, std::uint32_t> tiles_;                // by place
    std::map<std::pair<std::uint32_t, std::uint32_t>, Map> maps_; // by tile and mip
    std::size_t bytes_ = 0;
    std::vector<std::byte> blocks_;
};

} // namespace fjell::baker
