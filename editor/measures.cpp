#include "editor/measures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>
#include <utility>

namespace fjell::editor {

void Ring::push(float value) {
    if (size_ < measured_frames) {
        values_[(first_ + size_++) % measured_frames] = value;
    } else {
        values_[first_] = value;
        first_ = (first_ + 1) % measured_frames;
    }
}

void Ring::clear() {
    first_ = size_ = 0; // the next ones begin at 0, so mean() may read in any order
}

Quantiles Ring::quantiles() const {
    if (size_ == 0) return {};
    std::array<float, measured_frames> sorted;
    for (std::size_t i = 0; i < size_; ++i) sorted[i] = value(i);
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto place = [&](double share) {
        const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(size_)));
        return sorted.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(n, 1) - 1);
    };
    // What lies behind a place is no less, so the larger ones are looked for there alone.
    const auto p50 = place(0.5), p99 = place(0.99);
    std::nth_element(sorted.begin(), p50, end);
    const float half = *p50; // which the next one puts elsewhere
    std::nth_element(p50, p99, end);
    return {half, *p99, *std::max_element(p99, end), value(size_ - 1)};
}

double Ring::mean() const {
    double sum = 0;
    for (std::size_t i = 0; i < size_; ++i) sum += static_cast<double>(values_[i]); // in any order
    return size_ == 0 ? 0 : sum / static_cast<double>(size_);
}

float Ring::usual_most(std::size_t first, std::size_t end_at) const {
    end_at = std::min(end_at, size_);
    if (first >= end_at) return 0;
    const std::size_t count = end_at - first;
    std::array<float, measured_frames> sorted;
    for (std::size_t i = 0; i < count; ++i) sorted[i] = std::abs(value(first + i));
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count);
    const std::size_t left_out = count < 8 ? 0 : std::max<std::size_t>(count / 100, 1);
    const auto at = end - static_cast<std::ptrdiff_t>(left_out + 1);
    std::nth_element(sorted.begin(), at, end);
    return *at;
}

int triangle_level(const MeshVertex& a, const MeshVertex& b, const MeshVertex& c, std::uint32_t tile_log2) {
    const std::int64_t bx = std::int64_t{b.column} - a.column, bz = std::int64_t{b.row} - a.row;
    const std::int64_t cx = std::int64_t{c.column} - a.column, cz = std::int64_t{c.row} - a.row;
    if (bx * cz == bz * cx) return -1;
    const auto [left, right] = std::minmax({std::int64_t{0}, bx, cx});
    const auto [top, bottom] = std::minmax({std::int64_t{0}, bz, cz});
    const std::int64_t wide = right - left, deep = bottom - top;
    const int longest_log2 = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::max(wide, deep)))) - 1;
    return 2 * (static_cast<int>(tile_log2) - longest_log2) + (wide == deep ? 0 : 1);
}

void Measures::observe(const session::FrameEntry& entry) {
    last_ = entry;
    ++frames_;
}

void Measures::raise_peaks(const session::FrameEntry& entry) {
    const auto raise = [](auto& peak, auto value) { peak = std::max<std::decay_t<decltype(peak)>>(peak, value); };
    raise(peaks_.vertices, entry.vertex_slots.used);
    raise(peaks_.indices, entry.index_slots.used);
    raise(peaks_.items, entry.items);
    raise(peaks_.update_us, entry.update_us);
    if (!entry.streamed) return;
    raise(peaks_.requested, entry.stream.in_flight);
    raise(peaks_.pages_inserted, entry.stream.pages_inserted);
    raise(peaks_.page_slots, entry.stream.page_slots.used);
    raise(peaks_.map_bytes, entry.stream.map_bytes_used);
    raise(peaks_.map_upload_bytes, entry.stream.map_upload_bytes);
}

void Measures::record(const FrameTimes& times, const session::Pose& pose, bool drawn) {
    const session::FrameEntry& entry = last_;
    if (!drawn) { // at rest, a frame costs what a window without a terrain costs
        if (!entry.rebuilt) raise_peaks(entry);
        return;
    }
    const bool settles = std::exchange(settling_, entry.rebuilt);
    if (entry.rebuilt || settles)
        return; // once, and hundreds of times as much as a frame: it would be all that graphs show
    raise_peaks(entry);
    if (held_) return;
    const auto push = [&](Series series, auto value) {
        rings_[static_cast<std::size_t>(series)].push(static_cast<float>(value));
    };
    push(Series::frame_us, times.frame_us);
    push(Series::update_us, entry.update_us);
    push(Series::stream_us, entry.stream_us);
    push(Series::prepare_us, entry.prepare_us);
    push(Series::refine_us, entry.refine_us);
    push(Series::output_us, entry.output_us);
    push(Series::upload_us, times.upload_us);
    push(Series::draw_us, times.draw_us);
    push(Series::present_us, times.present_us);
    push(Series::editor_us, times.editor_us);
    push(Series::other_us, std::max(times.frame_us - entry.update_us - entry.stream_us - times.upload_us -
                                        times.draw_us - times.present_us - times.editor_us,
                                    0.0));
    if (times.gpu_us >= 0) push(Series::gpu_us, times.gpu_us);
    kept_[kept_next_] = {entry, times, pose, ++recorded_};
    kept_next_ = (kept_next_ + 1) % measured_frames;
    push(Series::requested_px, entry.error_px_requested);
    push(Series::effective_px, entry.error_bound_px);
    push(Series::vertices, entry.vertices);
    push(Series::triangles_drawn, entry.triangles_drawn);
    push(Series::activations, entry.activations);
    push(Series::deactivations, entry.deactivations);
    push(Series::uploaded_bytes, entry.upload_bytes);
    push(Series::requested, entry.streamed ? entry.stream.in_flight : 0);
    push(Series::pages_wanted, entry.streamed ? entry.stream.pages_wanted : 0);
}

void Measures::clear() {
    for (Ring& ring : rings_) ring.clear();
    last_ = {};
    shown_ = counting_ = {};
    peaks_ = {};
    range_ = index_ = 0;
    frames_ = 0;
    kept_next_ = 0;
    recorded_ = 0;
    held_ = settling_ = false;
}

void Measures::count_levels(const MeshView& mesh, std::uint32_t tile_log2) {
    const bool strip = mesh.topology == Topology::strip;
    const std::size_t step = strip ? 1 : 3;
    counting_.levels = std::min<std::uint32_t>(2 * tile_log2 + 1, gl::max_triangle_levels);
    const auto vertex = [&](std::size_t i) -> const MeshVertex& { return mesh.vertices[mesh.indices[i]]; };
    std::size_t left = indices_a_call;
    for (; range_ < mesh.tiles.size(); ++range_, index_ = 0) {
        const TileRange& range = mesh.tiles[range_];
        for (; index_ + 3 <= range.index_count; index_ += step) {
            if (left < step) return; // goes on in the next call
            left -= step;
            const std::size_t at = range.first_index + index_;
            const int level = triangle_level(vertex(at), vertex(at + 1), vertex(at + 2), tile_log2);
            if (level >= 0 && level < static_cast<int>(counting_.levels))
                ++counting_.triangles[static_cast<std::size_t>(level)];
        }
        left -= std::min<std::size_t>(left, 1); // empty ranges are not free either
        if (left == 0) {
            ++range_, index_ = 0;
            return;
        }
    }
    counting_.most = *std::max_element(counting_.triangles.begin(), counting_.triangles.end());
    shown_ = std::exchange(counting_, {});
    range_ = index_ = 0;
}

} // namespace fjell::editor
