// The full-resolution heights as a texture: what Mode::error compares the drawn surface with.
//
// One float a sample, in an array texture whose layers are parts of the grid when it is wider than a texture may be;
// exactly one layer otherwise. Holes are stored as a height that none has, because GLSL need not know NaN.
// Internal to runtime/gl. Thread: the context's.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/gl/renderer.h"
#include "gl/objects.h"

namespace fjell::gl {

class Heights {
public:
    // Copies. texture_side: as RendererOptions'. Empty, or one line; then what was there before is kept.
    [[nodiscard]] std::string set(const HeightGrid& grid, const Terrain& terrain, std::uint32_t texture_side);
    [[nodiscard]] bool present() const { return texture_.get() != 0; }
    [[nodiscard]] unsigned texture() const { return texture_.get(); }

    std::int32_t columns = 0, rows = 0, step_log2 = 0;
    std::int32_t wide = 0, high = 0; // texels of a layer that are used; layers go row by row

private:
    Texture texture_;
};

} // namespace fjell::gl
