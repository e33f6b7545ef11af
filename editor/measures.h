// What the last frames cost and gave, for graphs: rings of a fixed length, and the histogram of levels.
//
// Thread: the frame's. Memory: fixed at creation; record() allocates nothing. Complexity: record() is O(1), percentiles
// O(length) for those that are asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fjell/gl/palette.h"
#include "fjell/mesh.h"
#include "flight/log.h"

namespace fjell::editor {

inline constexpr std::size_t measured_frames = 512;

enum class Series : std::uint8_t {
    frame_us, // from swap to swap
    update_us,
    stream_us,
    prepare_us, // of update_us, as the next two: incremental
    refine_us,
    output_us,
    draw_us,   // upload and drawing, the CPU's part
    editor_us, // panels, commands, measures: the editor's own
    requested_px,
    effective_px,
    vertices,
    triangles_drawn,
    activations,
    deactivations,
    uploaded_bytes,
    requested, // pages and mips in flight
    pages_wanted,
    count
};
inline constexpr std::size_t series_count = static_cast<std::size_t>(Series::count);

struct Quantiles {
    float p50 = 0, p99 = 0, max = 0, last = 0;
};

// The last measured_frames values, the oldest first, in one piece: what a plot takes.
class Ring {
public:
    void push(float value);
    void clear();
    [[nodiscard]] std::size_t size() const { return size_; }
    // value(i): the i-th oldest.
    [[nodiscard]] float value(std::size_t i) const { return values_[(first_ + i) % measured_frames]; }
    [[nodiscard]] Quantiles quantiles() const; // nearest rank; zeros of none

private:
    std::array<float, measured_frames> values_{};
    std::size_t first_ = 0, size_ = 0;
};

// The most of each since the measures were cleared.
struct Peaks {
    std::uint32_t vertices = 0, indices = 0, items = 0, requested = 0, pages_inserted = 0, page_slots = 0;
    std::uint64_t map_bytes = 0, map_upload_bytes = 0;
    double update_us = 0;
};

// The level of a triangle of the mesh, 0 to 2 * tile_log2, as the picture's mode colours it: by its bounding rectangle,
// a square of 2^tile_log2 cells of a base triangle, half of it at the next level. Cut off by the terrain's rim it may
// count as a finer one. Negative: it is degenerate.
[[nodiscard]] int triangle_level(const MeshVertex& a, const MeshVertex& b, const MeshVertex& c,
                                 std::uint32_t tile_log2);

struct LevelHistogram {
    std::array<std::uint32_t, gl::max_triangle_levels> triangles{}; // drawn, by level
    std::uint32_t levels = 0, most = 0;
};

class Measures {
public:
    [[nodiscard]] const Ring& ring(Series series) const { return rings_[static_cast<std::size_t>(series)]; }
    [[nodiscard]] const flight::FrameEntry& last() const { return last_; }
    [[nodiscard]] const LevelHistogram& levels() const { return shown_; }
    [[nodiscard]] const Peaks& peaks() const { return peaks_; }
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

    // Once a frame. One that was built from nothing is the last one, and none of the series'.
    void record(const flight::FrameEntry& entry, double frame_us, double draw_us, double editor_us);
    // Counts some thousand triangles a call, so that no frame pays for a large mesh; shown when all are counted.
    // The mesh may change between calls: the counts are then of several frames. O(indices_a_call).
    void count_levels(const MeshView& mesh, std::uint32_t tile_log2);
    static constexpr std::size_t indices_a_call = 12'000;
    void clear();

private:
    std::array<Ring, series_count> rings_{};
    flight::FrameEntry last_;
    LevelHistogram shown_, counting_;
    Peaks peaks_;
    std::size_t range_ = 0, index_ = 0; // where counting goes on: in MeshView::tiles, and in that range
    std::uint64_t frames_ = 0;
};

} // namespace fjell::editor
