#include "rivals/roam.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "view/wanted.h"

namespace fjell::rivals {

namespace {

constexpr double ticks_a_cell = 4096, most_ticks = 2.0e9;
constexpr std::uint32_t not_deferred = 0, queued = 0xffffffff; // of due_; distances lie between

constexpr std::uint32_t packed(SampleIndex c) {
    return static_cast<std::uint32_t>(c.row) << 16 | static_cast<std::uint32_t>(c.column);
}
constexpr SampleIndex unpacked(std::uint32_t place) {
    return {static_cast<std::int32_t>(place & 0xffff), static_cast<std::int32_t>(place >> 16)};
}

} // namespace

std::size_t DueQueue::bucket(std::uint32_t due) const {
    return static_cast<std::size_t>(std::bit_width(due ^ last_));
}

void DueQueue::clear(std::uint32_t now) {
    for (auto& b : buckets_) b.clear();
    last_ = now;
}

// What differs from `last_` in a higher bit than `now` does, stays where it is.
void DueQueue::take(std::uint32_t now, std::vector<Entry>& out) {
    const auto changed = bucket(now);
    last_ = now;
    for (std::size_t i = 0; i <= changed; ++i) {
        moved_.clear();
        moved_.swap(buckets_[i]);
        for (const Entry& e : moved_) {
            if (e.due <= now)
                out.push_back(e);
            else
                buckets_[bucket(e.due)].push_back(e);
        }
    }
}

std::size_t DueQueue::bytes() const {
    std::size_t entries = moved_.capacity();
    for (const auto& b : buckets_) entries += b.capacity();
    return entries * sizeof(Entry);
}

// What decides in this frame.
struct Roam::Eye {
    Reach reach;
    double ticks_a_metre;
};

Roam::Roam(const Ground& ground) : ground_(ground), mesh_(ground.side) {
    keep_vertices();
}
Roam::Roam(Ground&& ground) : own_(std::move(ground)), ground_(own_), mesh_(own_.side) {
    keep_vertices();
    own_.error_m = own_.radius_m = {};
}

void Roam::keep_vertices() {
    for (std::size_t i = 0; i < ground_.height_m.size(); ++i)
        vertices_.push_back({ground_.height_m[i], ground_.error_m[i], ground_.radius_m[i], not_deferred});
}

// Everything is looked at again.
void Roam::restart() {
    now_ = 1;
    deferred_.clear(now_);
    for (Vertex& v : vertices_) v.due = not_deferred;
    now_due_.clear();
    const std::int32_t half = ground_.side / 2;
    now_due_.push_back({now_, packed({half, half})});
    for (std::size_t i = 0; i < now_due_.size(); ++i) { // top down, each once
        const SampleIndex v = unpacked(now_due_[i].place);
        vertices_[ground_.index(v)].due = now_;
        if (!mesh_.active(v)) continue;
        const Children c = children(v);
        for (int k = 0; k < c.count; ++k)
            if (mesh_.tree().contains(c.at[k]) && vertices_[ground_.index(c.at[k])].due != now_) {
                vertices_[ground_.index(c.at[k])].due = now_;
                now_due_.push_back({now_, packed(c.at[k])});
            }
    }
}

// A leaf triangle's vertex, or a diamond that can be merged.
bool Roam::candidate(SampleIndex v) const {
    if (mesh_.active(v)) return !mesh_.has_active_child(v);
    for (const SampleIndex apex : diamond(mesh_.tree(), v).apexes)
        if (mesh_.tree().contains(apex) && mesh_.active(apex)) return true;
    return false;
}

void Roam::put_off(SampleIndex v, std::uint32_t due) {
    vertices_[ground_.index(v)].due = due;
    deferred_.push({due, packed(v)});
}

// Queues a split or a merge, or puts the vertex off until it could need one.
void Roam::consider(const Eye& eye, SampleIndex v) {
    Vertex& vertex = vertices_[ground_.index(v)];
    if (vertex.due == queued) return;
    vertex.due = not_deferred;
    if (!candidate(v)) return; // it is considered when it becomes one
    const float y = vertex.height_m, error_m = vertex.error_m, radius_m = vertex.radius_m;
    const float x = ground_.x_m(v.column), z = ground_.z_m(v.row);
    const bool is = mesh_.active(v), should = wanted(eye.reach, x, y, z, error_m, radius_m);
    const float dx = x - eye.reach.eye_x, dy = y - eye.reach.eye_y, dz = z - eye.reach.eye_z;
    const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
    if (is != should) {
        const float error_px = error_m / std::max(distance - radius_m, 1e-6f);
        auto& queue = should ? splits_ : merges_;
        queue.push_back({should ? error_px : -error_px, packed(v)});
        std::push_heap(queue.begin(), queue.end());
        vertex.due = queued;
        return;
    }
    // Nothing changes before the eye has moved by the slack; less what the roundings of both may hide.
    const float reach = radius_m + error_m * eye.reach.q;
    const float slack_m = std::abs(distance - reach) - (distance + reach) * 0x1p-18f - 2 * eye.reach.pad;
    const double ticks = static_cast<double>(slack_m) * eye.ticks_a_metre;
    put_off(v, now_ + 1 + static_cast<std::uint32_t>(std::clamp(ticks, 0.0, most_ticks)));
}

// With those that it forces. Returns how many.
std::uint32_t Roam::split(const Eye& eye, SampleIndex v) {
    std::uint32_t done = 1;
    const Diamond d = diamond(mesh_.tree(), v);
    for (const SampleIndex apex : d.apexes)
        if (mesh_.tree().contains(apex) && !mesh_.active(apex)) {
            if (vertices_[ground_.index(apex)].due == queued)
                vertices_[ground_.index(apex)].due = not_deferred; // its entry is stale
            done += split(eye, apex);
        }
    mesh_.activate(v);
    vertices_[ground_.index(v)].due = not_deferred; // a parent that was forced has queued it again
    const Children c = children(v);
    for (int i = 0; i < c.count; ++i)
        if (mesh_.tree().contains(c.at[i])) consider(eye, c.at[i]);
    consider(eye, v);
    return done;
}

void Roam::merge(const Eye& eye, SampleIndex v) {
    mesh_.deactivate(v);
    for (const SampleIndex apex : diamond(mesh_.tree(), v).apexes)
        if (mesh_.tree().contains(apex) && !mesh_.tree().is_corner(apex)) consider(eye, apex);
    consider(eye, v);
}

Refined Roam::refine(const View& view, double error_px, std::uint32_t operations) {
    const double cell_m = static_cast<double>(std::min(ground_.spacing_x_m, ground_.spacing_z_m));
    const Eye eye{make_reach(view, error_px), ticks_a_cell / cell_m};
    const double moved = length(view.eye_m - eye_m_) * eye.ticks_a_metre;
    now_due_.clear();
    if (eye.reach.q != q_ || now_ + moved > most_ticks) { // or the distances run out
        restart();
    } else {
        if (moved > 0) now_ += static_cast<std::uint32_t>(moved) + 2; // rounded up, and the 1 that put_off() adds
        deferred_.take(now_, now_due_);
    }
    eye_m_ = view.eye_m;
    q_ = eye.reach.q;
    const std::size_t due_now = now_due_.size();
    for (std::size_t i = 0; i < due_now; ++i) {
        constexpr std::size_t ahead = 8;
        if (i + ahead < due_now) {
            const SampleIndex next = unpacked(now_due_[i + ahead].place);
            __builtin_prefetch(&vertices_[ground_.index(next)]);
            mesh_.prefetch(next);
        }
        const DueQueue::Entry e = now_due_[i];
        if (vertices_[ground_.index(unpacked(e.place))].due == e.due) consider(eye, unpacked(e.place));
    }
    std::uint32_t left = operations;
    for (auto* queue : {&splits_, &merges_}) {
        while (!queue->empty() && left > 0) {
            const SampleIndex v = unpacked(queue->front().place);
            std::pop_heap(queue->begin(), queue->end());
            queue->pop_back();
            std::uint32_t& due = vertices_[ground_.index(v)].due;
            if (due != queued) continue; // forced in the meantime
            due = not_deferred;
            const bool splits = queue == &splits_;
            if (mesh_.active(v) == splits || (!splits && mesh_.has_active_child(v))) continue;
            if (splits)
                left -= std::min(left, split(eye, v));
            else
                merge(eye, v), --left;
        }
    }
    const bool interrupted = !splits_.empty() || !merges_.empty();
    for (auto* queue : {&splits_, &merges_}) { // their priorities are those of this frame
        for (const Operation& o : *queue)
            if (vertices_[ground_.index(unpacked(o.place))].due == queued) put_off(unpacked(o.place), now_);
        queue->clear();
    }
    return {mesh_.triangles(), interrupted};
}

std::size_t Roam::bytes() const {
    return mesh_.bytes() + sizeof(Vertex) * vertices_.size() + deferred_.bytes() +
           (splits_.capacity() + merges_.capacity()) * sizeof(Operation) +
           now_due_.capacity() * sizeof(DueQueue::Entry);
}

} // namespace fjell::rivals
