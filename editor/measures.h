// What the last frames cost and gave, for graphs: rings of a fixed length, and the histogram of levels.
//
// Thread: the frame's. Memory: fixed at creation; record() allocates nothing. Complexity: record() is O(1), percentiles
// O(length) for those that are asked for.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fjell/gl/palette.h"
#include "fjell/mesh.h"
#include "session/log.h"
#include "session/path.h"

namespace fjell::editor {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double microseconds(Clock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
}

inline constexpr std::size_t measured_frames = 512;

enum class Series : std::uint8_t {
    frame_us, // all of it; the parts of it are those down to other_us
    update_us,
    stream_us,
    prepare_us, // of update_us, as the next two: incremental
    refine_us,
    output_us,
    upload_us,
    draw_us,    // the terrain: what giving it to the driver took
    present_us, // the picture copied, panels drawn, the swap: where the driver catches up
    editor_us,  // panels, commands, measures: the editor's own
    other_us,   // input, the overview, what is rebuilt
    gpu_us,     // beside all of these: what the GPU took for a frame some frames ago; none where software draws
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

// What a frame took, microseconds. All but the update, which its entry has.
struct FrameTimes {
    double frame_us = 0, upload_us = 0, draw_us = 0, present_us = 0, editor_us = 0;
    double gpu_us = -1; // of a frame some frames ago; below 0: not known
};

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
    [[nodiscard]] double mean() const;         // 0 of none
    // The largest magnitude without the largest hundredth of them, and without one at least where there are some: what
    // a scale reaches to, so that single frames do not flatten all others.
    [[nodiscard]] float usual_most() const { return usual_most(0, size_); }
    // Of those from the first-th oldest to before the end-th, as far as there are any.
    [[nodiscard]] float usual_most(std::size_t first, std::size_t end) const;

private:
    std::array<float, measured_frames> values_{};
    std::size_t first_ = 0, size_ = 0;
};

// A frame of the series whole: to be looked at again.
struct MeasuredFrame {
    session::FrameEntry entry;
    FrameTimes times;
    session::Pose pose;
    std::uint64_t number = 0; // of Measures::recorded(), this one counted
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
    [[nodiscard]] const session::FrameEntry& last() const { return last_; }
    [[nodiscard]] const LevelHistogram& levels() const { return shown_; }
    [[nodiscard]] const Peaks& peaks() const { return peaks_; }
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

    // Once a frame: what its update gave, and when it is over what it cost and the pose it was drawn from. One that was
    // built from nothing, the one after it, and one whose terrain was not drawn anew (drawn: false) are none of the
    // series'; the last are of the peaks, as their update was one.
    void observe(const session::FrameEntry& entry);
    void record(const FrameTimes& times, const session::Pose& pose, bool drawn);
    // While they are held the series stand still, to be looked at; peaks go on.
    void hold(bool on) { held_ = on; }
    [[nodiscard]] bool held() const { return held_; }
    // Frames that the series were given, in all.
    [[nodiscard]] std::uint64_t recorded() const { return recorded_; }
    // The frames of the series: 0 the newest; below ring().size().
    [[nodiscard]] const MeasuredFrame& frame(std::size_t ago) const {
        return kept_[(kept_next_ + 2 * measured_frames - 1 - ago) % measured_frames];
    }
    // Counts some thousand triangles a call, so that no frame pays for a large mesh; shown when all are counted.
    // The mesh may change between calls: the counts are then of several frames. O(indices_a_call).
    void count_levels(const MeshView& mesh, std::uint32_t tile_log2);
    static constexpr std::size_t indices_a_call = 6'000;
    void clear();

private:
    void raise_peaks(const session::FrameEntry& entry);

    std::array<Ring, series_count> rings_{};
    session::FrameEntry last_;
    LevelHistogram shown_, counting_;
    Peaks peaks_;
    std::size_t range_ = 0, index_ = 0; // where counting goes on: in MeshView::tiles, and in that range
    std::uint64_t frames_ = 0;
    std::vector<MeasuredFrame> kept_ = std::vector<MeasuredFrame>(measured_frames);
    std::size_t kept_next_ = 0;
    std::uint64_t recorded_ = 0;
    bool held_ = false;
    bool settling_ = false; // the frame after one that was built from nothing: the driver compiles
};

} // namespace fjell::editor
