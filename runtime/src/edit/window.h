// What lies around a piece of a stamp: read from the pages at once, worked on, and written back at once. Finding one
// vertex in its page takes as long as reading twenty in a row.
#pragma once

#include "edit/ground.h"

namespace fjell::edit {

// Stamps are applied in pieces of so many places a side, or whole where they are hardly larger: a crater of 64 samples
// and its rim.
inline constexpr std::int32_t piece_side = 64, largest_piece = 72;
// Errors of steps up to 2^measured_at_once are measured at once, in the window.
inline constexpr int measured_at_once = 3;
// Diamonds of the vertices that these depend on lie in it.
inline constexpr std::int32_t window_margin = (error_reach(VertexKind::centre) + 1) << measured_at_once,
                              window_side = largest_piece + 2 * window_margin;

struct Window {
    Rect rect;                                       // places
    bool loaded = false;                             // all are
    bool complete = false;                           // and none is a hole
    Rect written[max_tile_log2];                     // by step: where vertices have changed since it was read
    std::uint8_t allowed[window_side * window_side]; // by locks (edit/locks.h), where there are some
    Cell cells[window_side * window_side];
    void note(int z, const Rect& places) { written[z] = written[z].with(places); }
    [[nodiscard]] Cell& at(SampleIndex v) {
        return cells[static_cast<std::size_t>(v.row - rect.y0) * window_side +
                     static_cast<std::size_t>(v.column - rect.x0)];
    }
};

// Vertices that were looked for and are not loaded: one of each page, nearly, and the last ones of many.
struct Missing {
    static constexpr std::uint32_t most = 32;
    SampleIndex at[most];
    std::uint32_t count = 0, next = 0;
    void note(SampleIndex v) {
        const int z = Tree::step_log2(v), page_log2 = z + 1 + page_squares_log2;
        for (std::uint32_t i = 0; i < count; ++i)
            if (Tree::step_log2(at[i]) == z && (at[i].column ^ v.column) >> page_log2 == 0 &&
                (at[i].row ^ v.row) >> page_log2 == 0)
                return;
        at[next] = v;
        next = (next + 1) % most;
        count = std::min(count + 1, most);
    }
    template <typename Is>
    void forget(const Is& is) {
        const std::uint32_t left = static_cast<std::uint32_t>(std::remove_if(at, at + count, is) - at);
        if (left == count) return;
        count = next = left;
    }
};

// The terrain, and a window that lies over a part of it: what is read there is the window's, and what is written goes
// there until write_back().
class Ground {
public:
    // window: or null.
    Ground(const TerrainData& t, Window* window) : terrain(t), tree(t.tree), window_(window) {}
    const TerrainData& terrain;
    const Tree& tree;
    Missing* missing = nullptr; // notes what is looked for in vain, if it is set
    [[nodiscard]] Window* window() const { return window_; }

    [[nodiscard]] Cell at(SampleIndex v) const {
        if (window_ != nullptr && window_->rect.contains(v)) [[likely]]
            return window_->at(v);
        return beyond(v);
    }
    // As diamond_error() asks (shared/diamond_error.h).
    [[nodiscard]] std::int32_t h(SampleIndex v) const { return at(v).steps; }
    [[nodiscard]] bool is_void(SampleIndex v) const { return terrain.has_voids() && at(v).hole; }

    void set_error(const Plane& plane, std::int32_t i, std::int32_t j, std::uint8_t code) const {
        const SampleIndex v = plane.at(i, j);
        if (window_ != nullptr && window_->rect.contains(v))
            window_->at(v).error = code, window_->note(plane.z, {v.column, v.row, v.column, v.row});
        else
            change_record(terrain, plane, i, j, [&](VertexRecord& record) { record.error = code; });
    }
    // Of all these squares. True: one was another one.
    bool set_radii(const Plane& plane, const Rect& squares, std::uint8_t code) const {
        const Rect places = plane.places(squares);
        bool changed = false;
        if (window_ != nullptr && window_->rect.contains(places)) {
            const std::int32_t step = 2 << plane.z;
            for (std::int32_t y = places.y0; y <= places.y1; y += step) {
                Cell* const row = &window_->at({places.x0, y});
                for (std::int32_t x = 0; x < places.columns(); x += step) {
                    if (!row[x].loaded || row[x].radius == code) continue;
                    row[x].radius = code;
                    changed = true;
                }
            }
            if (changed) window_->note(plane.z, places);
            return changed;
        }
        for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
            for (std::int32_t i = squares.x0; i <= squares.x1; ++i) changed = set_radius(plane, i, j, code) || changed;
        return changed;
    }

private:
    bool set_radius(const Plane& plane, std::int32_t i, std::int32_t j, std::uint8_t code) const {
        const SampleIndex v = plane.at(i, j);
        if (window_ != nullptr && window_->rect.contains(v)) {
            Cell& cell = window_->at(v);
            if (!cell.loaded || cell.radius == code) return false;
            cell.radius = code;
            window_->note(plane.z, {v.column, v.row, v.column, v.row});
            return true;
        }
        bool changed = false;
        change_record(terrain, plane, i, j, [&](VertexRecord& record) {
            changed = changed || (record.radius & (radius_codes - 1)) != code;
            record.radius = static_cast<std::uint8_t>((record.radius & void_bit) | code);
        });
        return changed;
    }
    [[nodiscard]] Cell beyond(SampleIndex v) const; // not inline, so that at() is
    Window* window_;
};

// Reads all within `rect`.
void read(const TerrainData& t, const Rect& rect, Window& window);
// Is one of its places a hole? When some have become one, or ground.
void look_for_holes(const TerrainData& t, Window& window);
// Writes what differs where it was noted, and corners. heights: of those that do; pages whose base they do not count
// from get another one.
void write_back(const TerrainData& t, Window& window, const StepRange& heights);

} // namespace fjell::edit
