// All maps of a small terrain, as a bake makes them: every tile by itself, far mips from the grid before.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "baker/maps/image.h"
#include "baker/maps/maps.h"
#include "fjell/pack.h"
#include "fjell/texture.h"

namespace fjell::test {

// An image in memory: red, green, blue, alpha.
class MemoryImage final : public baker::ImageSource {
public:
    using Pixel = std::function<std::array<std::uint8_t, 4>(int x, int y)>;
    MemoryImage(baker::ImageLayer layer, Pixel pixel) : pixel_(std::move(pixel)) { layers = {layer}; }
    // Stretched over a terrain.
    MemoryImage(int width, int height, const Tree& tree, Pixel pixel) : pixel_(std::move(pixel)) {
        layers = {{width, height, {0, 0}, {width / (tree.columns() - 1.0), height / (tree.rows() - 1.0)}}};
    }
    [[nodiscard]] std::unique_ptr<baker::ImageReader> reader() const override {
        return std::make_unique<Reader>(*this);
    }
    [[nodiscard]] std::string identity() const override { return {}; }

private:
    struct Reader final : baker::ImageReader {
        const MemoryImage& from;
        explicit Reader(const MemoryImage& image) : from(image) {}
        void read(std::size_t, const baker::Window& w, std::uint8_t* rgba) override {
            for (int y = w.y; y < w.y + w.rows; ++y)
                for (int x = w.x; x < w.x + w.columns; ++x)
                    for (const std::uint8_t v : from.pixel_(x, y)) *rgba++ = v;
        }
    };
    Pixel pixel_;
};

struct Maps {
    // [mip][tile]
    std::vector<std::vector<baker::MipTexels>> colour, normal;
    [[nodiscard]] const auto& of(baker::MapKind kind) const { return kind == baker::MapKind::colour ? colour : normal; }
};

inline baker::NearMaps near_of(const baker::MapPlan& plan, const std::function<double(int, int)>& height,
                               std::uint32_t tile) {
    const baker::Window w = baker::heights_for_maps(plan, tile);
    std::vector<float> heights;
    for (int y = w.y; y < w.y + w.rows; ++y)
        for (int x = w.x; x < w.x + w.columns; ++x) heights.push_back(static_cast<float>(height(x, y)));
    const auto reader = plan.image ? plan.image->reader() : nullptr;
    return baker::near_maps(plan, tile, {heights.data(), w.columns, w}, reader.get());
}

// The window of a mip's grid that a tile needs, from the tiles' texels.
inline baker::Texels gather(const baker::MapPlan& plan, baker::MapKind kind, std::uint32_t mip,
                            const baker::Window& window, const std::vector<baker::MipTexels>& tiles) {
    const std::size_t n = baker::channels(kind);
    const int cells = plan.texels(kind, mip, 0).columns - 1;
    baker::Texels texels;
    for (int y = window.y; y < window.y + window.rows; ++y)
        for (int x = window.x; x < window.x + window.columns; ++x) {
            const int tx = std::min(x / cells, plan.tree.tiles_x - 1), ty = std::min(y / cells, plan.tree.tiles_y - 1);
            const auto& from = tiles[static_cast<std::size_t>(ty * plan.tree.tiles_x + tx)].texels;
            const auto at = static_cast<std::size_t>((y - ty * cells) * (cells + 1) + x - tx * cells) * n;
            texels.insert(texels.end(), from.begin() + static_cast<std::ptrdiff_t>(at),
                          from.begin() + static_cast<std::ptrdiff_t>(at + n));
        }
    return texels;
}

inline Maps all_maps(const baker::MapPlan& plan, const std::function<double(int, int)>& height) {
    const auto tiles = static_cast<std::uint32_t>(plan.tree.tiles_x * plan.tree.tiles_y);
    Maps maps;
    maps.colour.resize(mip_count(plan.colour_log2));
    maps.normal.resize(mip_count(plan.normal_log2));
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
        baker::NearMaps near = near_of(plan, height, tile);
        for (std::size_t m = 0; m < near.colour.size(); ++m) maps.colour[m].push_back(std::move(near.colour[m]));
        for (std::size_t m = 0; m < near.normal.size(); ++m) maps.normal[m].push_back(std::move(near.normal[m]));
    }
    for (const auto kind : {baker::MapKind::colour, baker::MapKind::normal}) {
        auto& mips = kind == baker::MapKind::colour ? maps.colour : maps.normal;
        for (std::uint32_t m = baker::near_mips; m < mips.size(); ++m)
            for (std::uint32_t tile = 0; tile < tiles; ++tile)
                mips[m].push_back(far_mip(plan, kind, m, tile,
                                          gather(plan, kind, m - 1, finer_texels(plan, kind, m, tile), mips[m - 1])));
    }
    return maps;
}

inline std::vector<std::uint8_t> decoded(baker::MapKind kind, const baker::MipTexels& mip, std::uint32_t side) {
    std::vector<std::uint8_t> codes(std::size_t{side} * side * baker::channels(kind));
    (void)(kind == baker::MapKind::colour ? decode_colour(mip.blocks, side, codes)
                                          : decode_normal(mip.blocks, side, codes));
    return codes;
}

} // namespace fjell::test
