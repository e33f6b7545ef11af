// Tiles with transition skirts (T. Sevaldrud, Cand.Scient. thesis; J. Mugaas' thesis 3.1): each tile has triangulations
// for a ladder of tolerances, made beforehand; the coarsest that is good enough at the tile's distance is drawn, and
// where a neighbour is finer, the triangles along that border are replaced by a transition skirt that takes the
// neighbour's vertices.
//
// Otherwise than there: triangulations are those of the vertex tree at a tolerance, not irregular ones; skirts are made
// when a tile or its neighbour changes its level, for any difference of levels, and not stored. The extension to
// terrain coarser than a tile (3.1.1) is not in it: a tile has two triangles at least. A triangulation keeps its
// tolerance; a skirt, being another one, need not: nothing in the method measures it.
// Memory: 12 bytes a triangle of each level. Complexity: O(tiles + triangles of tiles that change).
#pragma once

#include <vector>

#include "rivals/rival.h"

namespace fjell::rivals {

class SkirtedTiles final : public Rival {
public:
    explicit SkirtedTiles(const Ground& ground, std::int32_t tile_cells = 64); // keeps a reference
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, true, true, true}; }
    [[nodiscard]] std::size_t skirt_triangles() const; // of the last mesh

private:
    struct Indices { // three a triangle
        std::vector<std::uint32_t> inner, border;
    };
    struct Tile {
        Vec3 low, high;
        std::vector<Indices> levels;       // the finest first; the same tolerances for all tiles
        std::vector<std::uint32_t> skirts; // of the last mesh
        int level = -1;
        int around[4] = {-1, -1, -1, -1}; // to which levels the skirts lead: west, east, north, south
        bool drawn = false;
    };
    struct Triangle {
        SampleIndex a, b, c;
    };
    void bisect(std::size_t level, SampleIndex apex, SampleIndex left, SampleIndex right);
    void skirt(Tile& tile, SampleIndex corner, const Triangle& t);
    [[nodiscard]] int side_of(SampleIndex corner, SampleIndex a, SampleIndex b) const;
    void join(Tile& tile, std::int32_t tx, std::int32_t ty);
    [[nodiscard]] SampleIndex coord(std::uint32_t sample) const;

    const Ground& ground_;
    std::int32_t cells_, per_side_;
    std::vector<float> tolerances_m_;
    std::vector<Tile> tiles_;
    std::uint32_t triangles_ = 0;
};

} // namespace fjell::rivals
