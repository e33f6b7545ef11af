// ROAM (Duchaineau and others, "ROAMing Terrain: Real-time Optimally Adapting Meshes", 1997): the mesh of the frame
// before is split where it is too wrong, the worst first, and merged where it is better than needed, the best first.
//
// As in the paper: a queue of splits and one of merges (4.1 there), forced splits (4.2), priorities that are computed
// again only when the eye has come far enough for them to matter (5.2, "deferred priorities"; here by the distance
// travelled, exactly, and not by guessing velocities), and a mesh that is whole after every operation, so that a frame
// may end anywhere (5.3). Otherwise: a triangle's error on screen is that of the vertex which splits it, with a sphere
// of ours around it, from the pack's errors or from wedgies (with_wedgies); triangles are named and not linked
// (diamond_mesh.h); and the queues work towards a threshold, not towards a number of triangles. No frustum: all around.
//
// A change of the threshold or the lens looks at every active vertex again. Complexity: O(log n) an operation.
#pragma once

#include <vector>

#include "rivals/diamond_mesh.h"
#include "rivals/rival.h"

namespace fjell::rivals {

// Places that are due at a distance, by a radix heap: taken in order of distance, which only grows.
class DueQueue {
public:
    struct Entry {
        std::uint32_t due, place;
    };
    void clear(std::uint32_t now);
    void push(Entry e) { buckets_[bucket(e.due)].push_back(e); } // e.due: the last `now`, or later
    // Moves what is due at `now` or before into `out`.
    void take(std::uint32_t now, std::vector<Entry>& out);
    [[nodiscard]] std::size_t bytes() const;

private:
    [[nodiscard]] std::size_t bucket(std::uint32_t due) const;
    std::vector<Entry> buckets_[33], moved_;
    std::uint32_t last_ = 0;
};

class Roam final : public Rival {
public:
    explicit Roam(const Ground& ground); // keeps a reference
    explicit Roam(Ground&& ground);      // keeps it
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override { faces_of(ground_, mesh_.indices(), out); }
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {true, true, false, true}; }

private:
    struct Operation {
        float priority; // the largest is done first
        std::uint32_t place;
        friend bool operator<(const Operation& a, const Operation& b) { return a.priority < b.priority; }
    };
    struct Eye; // of a frame
    void keep_vertices();
    void restart();
    [[nodiscard]] bool candidate(SampleIndex v) const;
    void consider(const Eye& eye, SampleIndex v);
    void put_off(SampleIndex v, std::uint32_t due);
    std::uint32_t split(const Eye& eye, SampleIndex v);
    void merge(const Eye& eye, SampleIndex v);

    Ground own_; // perhaps
    const Ground& ground_;
    DiamondMesh mesh_;
    DueQueue deferred_;
    struct Vertex { // what is looked at together lies together
        float height_m, error_m, radius_m;
        std::uint32_t due; // when its entry counts; not_deferred: none does
    };
    std::vector<Vertex> vertices_;
    std::vector<Operation> splits_, merges_;
    std::vector<DueQueue::Entry> now_due_;
    Vec3 eye_m_;
    float q_ = -1;          // of the last frame
    std::uint32_t now_ = 0; // how far the eye has come, in ticks
};

} // namespace fjell::rivals
