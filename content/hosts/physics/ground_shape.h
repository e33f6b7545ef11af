// A ground patch as a collision shape of Bullet.
#pragma once

#include <vector>

#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <fjell/fjell.h>

namespace physics {

inline constexpr int patch_cells = 32;
inline constexpr int patch_side = patch_cells + 1; // samples
inline constexpr btScalar ground_margin_m = 0.01f; // how far a contact may be from the triangle it is with

// 33 x 33 samples and the triangles between them, in metres from the first sample and from `base_m`. They are those of
// the full-resolution surface: diagonals alternate from cell to cell, and where a corner is a hole there is none.
// btHeightfieldTerrainShape has these diagonals too, with setUseDiamondSubdivision() and from a sample whose column and
// row have an even sum, but no holes.
class GroundShape : public btConcaveShape {
public:
    // Reads the patch: on the thread that calls, from what is loaded now. Returns the microseconds that ground_patch()
    // took.
    float make(const fjell::Terrain& terrain, fjell::SampleIndex first);

    [[nodiscard]] float error_m() const { return error_m_; } // of every sample, and so of every triangle
    [[nodiscard]] bool finest() const { return finest_; }
    [[nodiscard]] double base_m() const { return base_m_; }
    [[nodiscard]] double steepest() const { return steepest_; } // metres up a metre

    void processAllTriangles(btTriangleCallback* callback, const btVector3& low, const btVector3& high) const override;
    void getAabb(const btTransform& at, btVector3& low, btVector3& high) const override;
    void setLocalScaling(const btVector3&) override {} // metres are metres
    const btVector3& getLocalScaling() const override { return one_; }
    void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); } // it never moves
    const char* getName() const override { return "ground"; }

private:
    [[nodiscard]] btVector3 sample(int x, int y) const;
    void process(btTriangleCallback* callback, int id, const int (&corners)[3][2]) const;

    fjell::SampleIndex first_;
    float spacing_x_m_ = 1, spacing_z_m_ = 1, error_m_ = 0, high_m_ = 0;
    double base_m_ = 0, steepest_ = 0;
    bool finest_ = false;
    btVector3 one_{1, 1, 1};
    std::vector<float> heights_m_; // from base_m_
    std::vector<std::uint8_t> holes_;
};

} // namespace physics
