#include "editor/measures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

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
    first_ = size_ = 0;
}

Quantiles Ring::quantiles() const {
    if (size_ == 0) return {};
    std::array<float, measured_frames> sorted;
    for (std::size_t i = 0; i < size_; ++i) sorted[i] = value(i);
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto rank = [&](double share) {
        const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(size_)));
        const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(n, 1) - 1);
        std::nth_element(sorted.begin(), at, end);
        return *at;
    };
    return {rank(0.5), rank(0.99), *std::max_element(sorted.begin(), end), value(size_ - 1)};
}

void Measures::record(const fly::FrameEntry& entry, float frame_us, float draw_us, float editor_us) {
    last_ = entry;
    ++frames_;
    const auto push = [&](Series series, auto value) {
        rings_[static_cast<std::size_t>(series)].push(static_cast<float>(value));
    };
    push(Series::frame_us, frame_us);
    push(Series::update_us, entry.update_us);
    push(Series::stream_us, entry.stream_us);
    push(Series::draw_us, draw_us);
    push(Series::editor_us, editor_us);
    push(Series::asked_px, entry.error_px_asked);
    push(Series::effective_px, entry.error_px_effective);
    push(Series::vertices, entry.vertices);
    push(Series::triangles_drawn, entry.triangles_drawn);
    push(Series::activations, entry.activations);
    push(Series::deactivations, entry.deactivations);
    push(Series::uploaded_bytes, entry.upload_bytes);
    push(Series::requested, entry.streamed ? entry.stream.requested : 0);
}

void Measures::clear() {
    *this = {};
}

void Measures::count_levels(const MeshView&, std::uint32_t) {}

} // namespace fjell::editor
