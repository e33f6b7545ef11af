// The game's own renderer: a cut's buffers on the GPU, edited in place, a draw call a range, and streamed maps.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <epoxy/gl.h>
#include <fjell/fjell.h>

namespace game {

// Streamed maps of one kind on the GPU: an array texture for each size, and layers that come and go. GL objects of the
// current context; they go with it.
class Maps {
public:
    void create(fjell::MapKind kind, const fjell::MapLayers& sizes);
    void carry_out(const fjell::MapCommand& command);
    void put(const fjell::MapPatch& patch);
    [[nodiscard]] GLuint array(std::uint32_t side_log2) const { return array_[side_log2]; }
    [[nodiscard]] std::uint32_t top_log2() const { return sizes_.top_log2; } // 0: the pack has no such map

private:
    GLenum format_ = 0;
    std::size_t block_bytes_ = 0;
    fjell::MapLayers sizes_;
    GLuint array_[fjell::max_texture_log2 + 1] = {};
};

// GL objects of the context that is current; they go with it. Its thread only.
class Drawer {
public:
    // Empty, or why it cannot be. shaders: the folder of terrain.vert and terrain.frag.
    [[nodiscard]] std::string create(const std::string& shaders, const fjell::CutBudget& budget,
                                     const fjell::MapLayers& colour, const fjell::MapLayers& normal);
    void upload(const fjell::CutMesh& cut, const fjell::CutChanges& changes);
    void upload(std::span<const fjell::MapCommand> commands);
    void upload(std::span<const fjell::MapPatch> patches);
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
