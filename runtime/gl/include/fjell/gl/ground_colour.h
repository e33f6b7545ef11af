// The colour of ground with layers, computed on the CPU: for exports and maps, where no shader runs. The result is what
// shaders draw near the eye, seen straight from above.
//
// Units: metres, degrees. Ownership: copies of a GroundColour share the decoded texels; set() reads `materials` and
// does not keep them. Thread: paint() may run on several at once. Memory: at most 8 bytes for each texel of the
// materials. Complexity of paint(): O(texels). Failure: set() throws io::Failure, 3.
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

// A square of texels, row by row from the north-west.
struct GroundTexels {
    std::uint32_t side = 0;            // at least 2
    double x_m = 0, z_m = 0;           // the centre of the first texel, from the terrain's sample (0, 0)
    double step_x_m = 1, step_z_m = 1; // from centre to centre
    // A mip of the square's splat map as the pack stores it (fjell/texture.h), and its texels a side. Its outermost
    // texel centres are on the square's border. Empty: rules decide.
    std::span<const std::byte> splat = {};
    std::uint32_t splat_side = 0;
    std::span<const float> height_m = {}, slope_deg = {}; // of the ground at each texel; only rules read them
    // sRGB, 3 bytes each. In: the colours of the map. Out: the colours of the ground.
    std::span<std::uint8_t> rgb = {};
};

class GroundColour {
public:
    // The same arguments as for Renderer::set_layers(). texel_m: the distance between texels.
    void set(const io::Materials& materials, std::span<const LayerRule> rules, std::span<const std::string> names,
             const LayerSettings& settings, double texel_m);
    // Paints the texels. False, and nothing is painted, if the sizes do not agree or set() was not called.
    [[nodiscard]] bool paint(const GroundTexels& texels) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

} // namespace fjell::gl
FJELL_API_END
