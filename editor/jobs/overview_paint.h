// The whole terrain from above, north up, in its own colours: painted from the pack's file, so that it is as fine at
// once as it will ever be, whatever is loaded of a streamed terrain.
//
// Colours are those of colour maps, under layers where these are on, as shaders lay them over near ground; a terrain
// with neither is coloured by height. Lit from the north-west, with slopes three times as steep, or a continent would
// be flat. Thread: any; it reads the file, so not the frame's. Memory: 16 bytes a texel, a terrain with the pages of
// one tile, and a tile's colours. O(texels), and reads of a tile what its texels take, of one without a texel nothing.
// Failure: what cannot be read is painted as coarse as what can; nothing is thrown but std::bad_alloc and io::Failure
// for a terrain that cannot be made.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "fjell/gl/layers.h"
#include "fjell/io/pack_file.h"
#include "flight/layers_file.h"

namespace fjell::editor {

// What is painted.
struct OverviewSource {
    std::shared_ptr<const io::PackFile> pack;
    std::shared_ptr<const flight::GroundLayers> layers; // null: none
    gl::LayerSettings settings;
};

struct OverviewSize {
    static constexpr std::uint32_t longer_texels = 256, least_texels = 16;
    std::uint32_t columns = 0, rows = 0;

    [[nodiscard]] std::size_t texels() const { return std::size_t{columns} * rows; }
};
[[nodiscard]] OverviewSize overview_size_of(const PackHeader& header);
inline constexpr std::uint32_t overview_ground = 0xff2a2520u; // no texel yet, and holes: the panels' grey

// Called now and then with the share that is painted and all texels, RGBA bytes, sRGB: grey where none is painted yet,
// and in holes; the last time with share 1. False: stop.
using OverviewShow = std::function<bool(double share, std::span<const std::uint32_t> texels)>;
// stopped: asked after every page and every row of texels. False: it was stopped.
bool paint_overview(const OverviewSource& source, const std::function<bool()>& stopped, const OverviewShow& show);

} // namespace fjell::editor
