// What layers make of the ground's colours, on the CPU: for exports and maps, where no shader runs. As shaders draw
// near ground, seen straight from above.
//
// Units: metres, degrees. Ownership: a GroundColour shares decoded texels with its copies; `materials` is read by set()
// and not kept. Thread: paint() from several at once. Memory: at most 8 bytes a texel of the materials. Complexity of
// paint(): O(texels). Failure: set() throws io::Failure, 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fjell/export.h"
#include "fjell/gl/layers.h"
#include "fjell/io/materials.h"

FJELL_API_BEGIN
namespace fjell::gl {

// A square of texels, row by row from its north-west.
struct GroundTexels {
    std::uint32_t side = 0;            // at least 2
    double x_m = 0, z_m = 0;           // where the first texel's centre lies, from the terrain's sample (0, 0)
    double step_x_m = 1, step_z_m = 1; // from centre to centre
    // A mip of the square's splat map as the pack stores it (fjell/texture.h), and its texels a side; its outermost
    // centres lie where the square's do. Empty: what rules say.
    std::span<const std::byte> splat = {};
    std::uint32_t splat_side = 0;
    std::span<const float> height_m = {}, slope_deg = {}; // of the ground at each texel: for rules only
    std::span<std::uint8_t> rgb = {};                     // sRGB, 3 bytes each: the map's colours; then the ground's
};

class GroundColour {
public:
    // What Renderer::set_layers() takes; texel_m: how far apart the texels will be.
    void set(const io::Materials& materials, std::span<const LayerRule> rules, std::span<const std::string> names,
             const LayerSettings& settings, double texel_m);
    // False, and nothing is painted: sizes do not agree, or nothing was set.
    [[nodiscard]] bool paint(const GroundTexels& texels) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

} // namespace fjell::gl
FJELL_API_END
