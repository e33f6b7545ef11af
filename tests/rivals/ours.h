// Our own methods, and the leanest recursion, as entries among their rivals.
//
// Ownership: they keep the terrain. Budgets are ample for a square of samples; a frame that does not converge for want
// of them throws std::runtime_error.
#pragma once

#include "bench/lean_recursion.h"
#include "fjell/cut.h"
#include "fjell/recursive.h"
#include "rivals/rival.h"

namespace fjell::rivals {

// A mesh's triangles, as the vertices stand; and the heights of any terrain in the north-west corner of the smallest
// square of whole cells around it: for look.h, which takes squares. Beyond the terrain it is level, where no mesh is.
void faces_of(const MeshView& mesh, std::vector<Face>& out);
[[nodiscard]] Ground square_around(const Terrain& terrain);

// What the library's objects lie in: aligned to 64.
class Memory {
public:
    explicit Memory(std::size_t bytes) : bytes_(bytes), raw_(bytes + 64) {}
    [[nodiscard]] std::span<std::byte> span();
    [[nodiscard]] std::size_t size() const { return bytes_; }

private:
    std::size_t bytes_;
    std::vector<std::byte> raw_;
};

class Incremental final : public Rival {
public:
    // offscreen_factor: CutSettings has it. Its bound then speaks of what the view shows.
    Incremental(const Terrain& terrain, bool morphing, double offscreen_factor = 1);
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {true, true, offscreen_factor_ > 1, true}; }

private:
    Terrain terrain_;
    Memory memory_;
    LiveCut cut_;
    bool morphing_;
    double offscreen_factor_;
    double now_s_ = 0; // 60 frames a second
};

class Recursive final : public Rival {
public:
    explicit Recursive(const Terrain& terrain);
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, false, true, true}; }

private:
    Terrain terrain_;
    Memory memory_;
    RecursiveMethod method_;
};

class Lean final : public Rival {
public:
    explicit Lean(const Terrain& terrain);
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, false, true, true}; }

private:
    float spacing_x_m_, spacing_z_m_;
    bench::LeanRecursion recursion_;
};

} // namespace fjell::rivals
