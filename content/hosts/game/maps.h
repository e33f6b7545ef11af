// Streamed maps on the GPU: an array texture for each size, and layers that come and go.
#pragma once

#include <cstdint>
#include <span>

#include <epoxy/gl.h>

#include <fjell/fjell.h>

namespace game {

// Of one kind of map. GL objects of the current context; they go with it.
class Maps {
public:
    void create(fjell::MapKind kind, const fjell::MapLayers& sizes);
    void carry_out(const fjell::MapCommand& command);
    [[nodiscard]] GLuint array(std::uint32_t side_log2) const { return array_[side_log2]; }
    [[nodiscard]] std::uint32_t top_log2() const { return sizes_.top_log2; } // 0: the pack has no such map

private:
    GLenum format_ = 0;
    std::size_t block_bytes_ = 0;
    fjell::MapLayers sizes_;
    GLuint array_[fjell::max_texture_log2 + 1] = {};
};

} // namespace game
