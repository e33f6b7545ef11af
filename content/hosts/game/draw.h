// The game's own renderer: a cut's buffers on the GPU, edited in place, and a draw call a range.
#pragma once

#include <span>
#include <string>

#include <epoxy/gl.h>

#include <fjell/fjell.h>

#include "maps.h"

namespace game {

// GL objects of the context that is current; they go with it. Its thread only.
class Drawer {
public:
    // Empty, or why it cannot be. shaders: the folder of terrain.vert and terrain.frag.
    [[nodiscard]] std::string create(const std::string& shaders, const fjell::CutBudget& budget,
                                     const fjell::MapLayers& colour, const fjell::MapLayers& normal);
    void upload(const fjell::CutMesh& cut, const fjell::CutChanges& changes);
    void upload(std::span<const fjell::MapCommand> commands);
    // Into the current framebuffer and viewport; the depth buffer is float, and cleared to 0.
    void draw(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view,
              std::span<const fjell::TileMap> colour, std::span<const fjell::TileMap> normal) const;

private:
    void set_view(const fjell::Terrain& terrain, const fjell::View& view) const;
    void set_morph(const fjell::MorphFrame& frame, const fjell::View& view) const;
    void set_tile(const fjell::Terrain& terrain, std::uint32_t tile, std::span<const fjell::TileMap> colour,
                  std::span<const fjell::TileMap> normal) const;
    [[nodiscard]] GLint at(const char* uniform) const { return glGetUniformLocation(program_, uniform); }

    GLuint program_ = 0, vertices_ = 0, morphs_ = 0, indices_ = 0, format_ = 0;
    Maps maps_[fjell::map_kinds];
};

} // namespace game
