// The overview: the whole terrain from above, north up, shaded, painted a little every frame.
//
// Heights are asked of the live terrain (fjell/query.h), so it works streamed too: the overview is painted again and
// again until the coarsest of every tile is there, and once after that. Ownership: the picture and its texture. Thread:
// the frame's, with the graphics context current for upload() and drop_graphics(). Memory: 8 bytes a texel, made in
// begin(); advance() allocates nothing. Complexity: advance() asks for some dozen heights past its time at most.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "editor/state.h"
#include "fjell/terrain.h"
#include "gl/objects.h"

namespace fjell::editor {

class Overview {
public:
    static constexpr std::uint32_t longer_texels = 256, least_texels = 16;

    // Another terrain, from nothing.
    void begin(const Terrain& terrain);
    void end(); // no terrain
    // Paints on for that long. complete: nothing coarse is missing any more.
    void advance(const Terrain& terrain, bool complete, double budget_us);
    // Brings the texture up to date, and makes it when there is none.
    void upload(OverviewImage& image);
    void drop_graphics(OverviewImage& image);

    [[nodiscard]] std::uint32_t columns() const { return columns_; }
    [[nodiscard]] std::uint32_t rows() const { return rows_; }
    [[nodiscard]] std::span<const std::uint32_t> texels() const { return texels_; } // RGBA bytes, sRGB
    [[nodiscard]] bool done() const { return done_; }
    // Of the first pass, which is coarse; 1 afterwards.
    [[nodiscard]] double share() const;

private:
    void paint(const Terrain& terrain);
    [[nodiscard]] std::uint32_t shade(const Terrain& terrain, std::uint32_t column, std::uint32_t row) const;

    std::uint32_t columns_ = 0, rows_ = 0;
    std::vector<float> heights_; // NaN: no ground
    std::vector<std::uint32_t> texels_;
    std::uint32_t column_ = 0, row_ = 0, rest_frames_ = 0;
    std::uint32_t step_ = 1;                        // texels that are painted alike: the first pass is quick
    std::uint32_t dirty_begin_ = 0, dirty_end_ = 0; // rows that the texture does not have
    bool complete_ = false;                         // when the pass began
    bool done_ = true, first_ = true;
    gl::Texture texture_;
};

} // namespace fjell::editor
