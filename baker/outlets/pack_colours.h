// The colour map of a pack as a picture of its ground, at any place and as coarse as it is wanted.
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
class PackColours {
public:
    explicit PackColours(const std::string& path); // throws Failure 1: no pack, or a pack without colours

    // Bilinear, of the coarsest mip whose texels are no wider than texel_m. Grey beyond the ground. sRGB.
    [[nodiscard]] std::array<std::uint8_t, 3> at(double column, double row, double texel_m);

    // A JPEG of columns x rows texels; place(u, v) gives a sample's column and row, or nothing, for 0 to 1 from the
    // west and from the north. Throws Failure 3: too little memory.
    using Place = std::function<std::optional<std::array<double, 2>>(double u, double v)>;
    [[nodiscard]] std::vector<std::byte> picture(std::uint32_t columns, std::uint32_t rows, double texel_m,
                                                 const Place& place);

private:
    using Map = std::vector<std::uint8_t>;
    [[nodiscard]] const Map& map_of(std::uint32_t tile, std::uint32_t mip);

    io::PackFile file_;
    std::map<std::uint32_t, std::uint32_t> tiles_;                // by place
    std::map<std::pair<std::uint32_t, std::uint32_t>, Map> maps_; // by tile and mip
    std::size_t bytes_ = 0;
    std::vector<std::byte> blocks_;
};

} // namespace fjell::baker
