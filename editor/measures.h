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

#include "fjell/mesh.h"
#include "fly/log.h"
#include "gl/palette.h"

namespace fjell::editor {

inline constexpr std::size_t measured_frames = 512;

enum class Series : std::uint8_t {
    frame_us, // from swap to swap
    update_us,
    stream_us,
    draw_us,   // upload and drawing, the CPU's part
    editor_us, // panels, commands, measures: the editor's own
    asked_px,
    effective_px,
    vertices,
    triangles_drawn,
    activations,
    deactivations,
    uploaded_bytes,
    requested, // pages and mips under way
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

struct LevelHistogram {
    std::array<std::uint32_t, gl::max_triangle_levels> triangles{}; // drawn, by level
    std::uint32_t levels = 0, most = 0;
};

class Measures {
public:
    [[nodiscard]] const Ring& ring(Series series) const { return rings_[static_cast<std::size_t>(series)]; }
    [[nodiscard]] const fly::FrameEntry& last() const { return last_; }
    [[nodiscard]] const LevelHistogram& levels() const { return shown_; }
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

    void record(const fly::FrameEntry& entry, float frame_us, float draw_us, float editor_us);
    // Counts some thousand triangles a call, so that no frame pays for a large mesh; shown when all are counted.
    void count_levels(const MeshView& mesh, std::uint32_t tile_log2);
    void clear();

private:
    std::array<Ring, series_count> rings_{};
    fly::FrameEntry last_;
    LevelHistogram shown_, counting_;
    std::size_t range_ = 0, triangle_ = 0;
    std::uint64_t frames_ = 0;
};

} // namespace fjell::editor
