// Locks: points, lines and areas along which the mesh is held to errors of their own, whatever the view asks for
// elsewhere: a road within 5 cm, a runway exactly, a shore to half a pixel.
//
// A lock holds every sample that lies within half its width of it and those of the cells there, so what is drawn over
// it keeps the lock's error between samples, too. Errors are from the heights that the pack stores.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baker/read/source.h"
#include "baker/read/vectors.h"
#include "baker/store/window.h"
#include "fjell/io/journal.h"
#include "shared/record.h"

namespace fjell::baker {

// What holds at a sample, as codes on the pack's ErrorScale. Of several locks the strictest counts.
struct LockCodes {
    static constexpr std::uint8_t any = 255;
    std::uint8_t allowed = any; // of triangles over it; any: no matter
    std::uint8_t raise = 0;     // how much larger the codes of errors under it are than they are measured
};

class Locks {
public:
    Locks() = default;
    // A feature says error_m, error_px, or both; error_m: of features that say neither. width_m: of lines and points, 0
    // where it says none. Those beside the field are left out. O(points). Throws Failure 1: read_vectors()', a feature
    // without an error, a number that is none, or nothing on the field.
    // layer: of the file; empty: all of them.
    Locks(const std::string& path, std::optional<double> error_m, const HeightSource& field,
          const std::string& layer = {});
    // Those of stamps as well, which the field keeps (HeightSource::locks()).
    void add_stamps(const HeightSource& field);

    [[nodiscard]] bool empty() const { return shapes_.empty() && stamps_.empty(); }
    // Shapes as stamps that hold the same samples: of polygons their sides, and rectangles inside. O(points, and
    // samples of polygons). Throws Failure 1: one is in pixels, which stamps are not. name: of the file, for the
    // message.
    [[nodiscard]] std::vector<io::KeptStamp> stamps(const std::string& name) const;
    [[nodiscard]] bool in_metres() const;       // some of them
    [[nodiscard]] double sharpest() const;      // 1 / the smallest error_px; 1: none
    [[nodiscard]] std::string account() const;  // "3 lines, 1 area; 2 shapes beside the terrain left out"
    [[nodiscard]] std::string identity() const; // of all that it does to a pack

    // Of samples, row by row; no lock holds places beyond the field. Empty: no lock is near. O(what lies in the window
    // + points / 64). Any thread.
    [[nodiscard]] std::vector<LockCodes> over(const Window& window, const ErrorScale& scale) const;

private:
    using Place = VectorShape::Place;
    struct Shape {
        VectorKind kind;
        double reach_m = 0; // from it to the farthest sample that it holds
        double error_m, error_px;
    };
    struct Run { // of places of a shape that lie behind each other
        std::size_t shape = 0, first = 0, count = 0;
        std::array<double, 4> box{}; // columns and rows that it may hold: from, to
    };
    void add(const VectorShape& shape, std::optional<double> error_m, const std::string& name);
    void add_part(const std::vector<Place>& part);

    struct Raster;
    void hold_along(const Run& run, Raster& raster) const;
    void hold_inside(std::span<const Run> rings, Raster& raster) const;
    void stamp_inside(std::span<const Run> rings, const Stamp& lock, std::vector<io::KeptStamp>& to) const;
    void hold_stamped(const Window& field, const ErrorScale& scale, const Window& window,
                      std::vector<LockCodes>& codes) const;

    double spacing_m_[2] = {1, 1};
    std::int32_t columns_ = 0, rows_ = 0;
    std::vector<Shape> shapes_;
    std::vector<Stamp> stamps_; // from the first that locks on
    std::vector<Run> runs_;     // those of a shape lie together
    std::vector<Place> places_;
    std::size_t outside_ = 0;
};

} // namespace fjell::baker
