// What the host promises, held against the cut and against the full-resolution surface, all of it in memory. A game has
// no use for it.
#pragma once

#include <cstdint>
#include <string>

#include <fjell/fjell.h>

#include "drawer.h"
#include "probe.h"
#include "space.h"

namespace vulkan {

class Check {
public:
    // whole: with all pages, and no holes.
    explicit Check(const fjell::Terrain& whole) : whole_(whole) {}

    // Just what has changed is uploaded.
    void upload(const fjell::CutChanges& changes, std::uint32_t index_bytes, std::uint64_t uploaded_bytes);
    // The device has what the cut has, and its shader morphs as morphed_height_m() does, but for what CompactVertex
    // rounds.
    void vertices(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view,
                  const Origin& origin, std::uint32_t index_bytes, const Probe& probe);
    // Every 8th pixel of every 8th row is as far away as the full-resolution ground, but for what the report allows.
    void picture(const fjell::CutMesh& cut, const fjell::CutReport& report, const fjell::View& view,
                 const Probe& probe);

    // How many vertices there would be for each one if every range, or every tile, had its own: what 16-bit indices
    // into their own vertices would take.
    struct Copies {
        double by_range = 0, by_tile = 0;
    };
    [[nodiscard]] static Copies copies(const fjell::CutMesh& cut);

    [[nodiscard]] const std::string& broken() const { return broken_; } // the first promise that was; empty: none
    [[nodiscard]] std::uint64_t vertex_count() const { return vertices_; }
    [[nodiscard]] std::uint64_t between_count() const { return between_; } // of those, on the way between two heights
    // Of vertices that morph by distance: how far what CompactVertex rounds moves them.
    [[nodiscard]] double worst_rounding_px() const { return worst_rounding_px_; }
    [[nodiscard]] double worst_rounding_m() const { return worst_rounding_m_; }
    [[nodiscard]] std::uint64_t pixel_count() const { return pixels_; }
    [[nodiscard]] double worst_share() const { return worst_share_; } // of what is allowed
    [[nodiscard]] double worst_px() const { return worst_px_; }

private:
    void buffers(const fjell::CutMesh& cut, std::uint32_t index_bytes, const Probe& probe);
    void height(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view, std::uint32_t slot,
                double drawn_m);
    void pixel(const fjell::View& view, fjell::Vec3 ray, double depth, double allowed_px);
    void break_promise(const std::string& how);

    const fjell::Terrain& whole_;
    std::string broken_;
    std::uint64_t vertices_ = 0, between_ = 0, pixels_ = 0;
    double worst_rounding_px_ = 0, worst_rounding_m_ = 0, worst_share_ = 0, worst_px_ = 0;
};

// Calls of operator new on this thread while `counting` is true: a frame makes none.
inline thread_local bool counting = false;
inline thread_local std::uint64_t allocations = 0;

} // namespace vulkan
