// Nested error spheres (Blow, "Terrain Rendering at High Levels of Detail", GDC 2000; thesis 3.4): for a fixed
// threshold a vertex is in the mesh while the eye is in its sphere, and spheres are nested, so that what is outside one
// is outside all within it.
//
// As there: a sphere a vertex with the threshold already in it, artificial spheres around clusters of them, and only
// vertices whose state has changed touch the mesh, parents first. A cluster here is what one step has in 8 x 8 squares;
// its sphere holds those of its vertices and of the clusters below. Spheres grow from the pack's errors and radii. The
// threshold is built in: another one, or another lens, computes all spheres again. No frustum: all around.
// Interruptible, because every change leaves the mesh whole; but not the worst first. Complexity: O(vertices of
// clusters whose sphere the eye is in and not in all of).
#pragma once

#include <vector>

#include "rivals/diamond_mesh.h"
#include "rivals/rival.h"
#include "rivals/step_blocks.h"

namespace fjell::rivals {

class ErrorSpheres final : public Rival {
public:
    explicit ErrorSpheres(const Ground& ground); // keeps a reference
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override { faces_of(ground_, mesh_.indices(), out); }
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {true, true, false, true}; }
    [[nodiscard]] std::size_t spheres_tested() const { return tested_; } // in the last frame

private:
    struct Cluster {
        float x_m, y_m, z_m; // of its middle
        float outer_m = 0;   // beyond, nothing in it or below is active
        float inner_m = 0;   // within, all of its own are
        bool below = false;  // something in it or below may be active
        bool all = false;    // all of its own are active
    };
    void grow_spheres(float q);
    void grow_cluster(std::size_t level, std::int32_t cx, std::int32_t cy);
    void visit(const Vec3& eye_m, float pad, std::size_t level, std::int32_t cx, std::int32_t cy, bool beyond);
    void test(std::size_t cluster, const Vec3& eye_m, float pad, bool none, bool all, std::size_t level);
    bool apply(std::uint32_t& left);

    const Ground& ground_;
    DiamondMesh mesh_;
    StepBlocks layout_;
    std::vector<Cluster> clusters_; // as its blocks
    // By its places: where the vertex is, its sphere, and whether it is active: 1, as wide as a float, so that the
    // compiler tests several at once.
    std::vector<float> x_m_, y_m_, z_m_, spheres_m_;
    std::vector<std::uint32_t> active_;
    std::vector<std::vector<std::uint32_t>> on_, off_; // by level of the vertex tree
    float q_ = -1;
    std::size_t tested_ = 0;
};

} // namespace fjell::rivals
