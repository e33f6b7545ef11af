#include "rivals/progressive_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fjell::rivals {

struct ProgressiveMesh::Eye {
    Vec3 at;
    Frustum frustum;
    double q; // lambda / threshold
};

ProgressiveMesh::ProgressiveMesh(const Ground& ground) : ground_(ground) {
    number(simplify(ground, 64, 1024));
    cover_below();
    next_ = first_;
    where_.assign(splits_.size(), no_index);
    leaning_.assign(splits_.size(), 0);
}

// Splits are numbered in the order of refinement, the last collapse first, and what a split makes is numbered after it.
void ProgressiveMesh::number(const Simplified& all) {
    const std::size_t samples = ground_.height_m.size(), count = all.collapses.size();
    std::vector<std::uint32_t> vertex_of(samples, no_index), face_of(all.faces.size(), no_index);
    base_ = static_cast<std::uint32_t>(samples - count);
    places_.resize(samples);
    const auto name = [&](std::size_t sample, std::size_t vertex) {
        const auto stride = static_cast<std::size_t>(ground_.side + 1);
        vertex_of[sample] = static_cast<std::uint32_t>(vertex);
        places_[vertex] = {static_cast<std::uint16_t>(sample % stride), static_cast<std::uint16_t>(sample / stride),
                           ground_.height_m[sample]};
    };
    for (std::size_t i = 0; i < count; ++i) name(all.collapses[count - 1 - i].from, base_ + i);
    std::vector<bool> goes(samples);
    for (const Collapse& c : all.collapses) goes[c.from] = true;
    for (std::size_t i = 0, vertex = 0; i < samples; ++i)
        if (!goes[i]) name(i, vertex++);
    for (std::size_t i = 0; i < all.faces.size(); ++i)
        if (all.faces[i].corner[0] != no_index) face_of[i] = base_faces_++;
    for (std::size_t i = 0; i < count; ++i) {
        const Collapse& c = all.collapses[count - 1 - i];
        const auto number = base_faces_ + 2 * static_cast<std::uint32_t>(i);
        if (c.first != no_index) face_of[c.first] = number;
        if (c.second != no_index) face_of[c.second] = number + 1;
    }
    slots_.assign(base_faces_ + 2 * count, no_index);
    std::vector<std::uint32_t> last(samples, no_index); // split of a vertex so far
    first_.assign(samples, no_index);
    splits_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Collapse& c = all.collapses[count - 1 - i];
        Split& s = splits_[i];
        s = {vertex_of[c.to], {}, c.error_m, c.reach_m, last[vertex_of[c.to]], no_index};
        for (std::size_t k = 0; k < 4; ++k) s.around[k] = c.around[k] == no_index ? no_index : face_of[c.around[k]];
        (s.before == no_index ? first_[s.of] : splits_[s.before].after) = i;
        last[s.of] = i;
    }
    for (std::size_t i = 0; i < all.faces.size(); ++i) {
        if (face_of[i] >= base_faces_) continue;
        LinkedFace f = all.faces[i];
        for (std::uint32_t& corner : f.corner) corner = vertex_of[corner];
        for (std::uint32_t& n : f.neighbour) n = n == no_index ? no_index : face_of[n]; // slots: added in this order
        (void)add_face(face_of[i], f);
    }
}

void ProgressiveMesh::cover_below() {
    for (std::size_t i = splits_.size(); i-- > 0;) {
        const Split& below = splits_[i];
        const std::uint32_t up = below.before != no_index ? below.before
                                 : below.of >= base_      ? below.of - base_
                                                          : no_index;
        if (up == no_index) continue;
        const Place &a = places_[base_ + i], &b = places_[base_ + up];
        const double x = (a.column - b.column) * static_cast<double>(ground_.spacing_x_m),
                     y = static_cast<double>(a.height_m) - static_cast<double>(b.height_m),
                     z = (a.row - b.row) * static_cast<double>(ground_.spacing_z_m);
        const double reach = (std::sqrt(x * x + y * y + z * z) + static_cast<double>(below.radius_m)) * (1 + 1e-6);
        splits_[up].error_m = std::max(splits_[up].error_m, below.error_m);
        splits_[up].radius_m = std::max(splits_[up].radius_m, static_cast<float>(reach));
    }
}

bool ProgressiveMesh::wanted(const Eye& eye, std::uint32_t s) const {
    const Place& p = places_[base_ + s];
    const Vec3 to = Vec3{static_cast<double>(ground_.x_m(p.column)), static_cast<double>(p.height_m),
                         static_cast<double>(ground_.z_m(p.row))} -
                    eye.at;
    const double radius = static_cast<double>(splits_[s].radius_m),
                 reach = radius + static_cast<double>(splits_[s].error_m) * eye.q;
    if (!(dot(to, to) < reach * reach)) return false;
    for (int i = 0; i < 6; ++i)
        if (dot(eye.frustum.normal[i], to) + radius < eye.frustum.offset[i]) return false;
    return true;
}

std::uint32_t ProgressiveMesh::add_face(std::uint32_t face, const LinkedFace& f) {
    std::uint32_t slot = static_cast<std::uint32_t>(drawn_.size());
    if (free_.empty())
        drawn_.push_back(f);
    else {
        slot = free_.back();
        free_.pop_back();
        drawn_[slot] = f;
    }
    return slots_[face] = slot;
}

void ProgressiveMesh::remove_face(std::uint32_t face) {
    drawn_[slots_[face]].corner.fill(0); // without an area
    free_.push_back(slots_[face]);
    slots_[face] = no_index;
}

// Renames a corner of `slot` and of those after it around that corner, to `last` or to the rim.
void ProgressiveMesh::turn_around(std::uint32_t slot, bool onward, std::uint32_t last, std::uint32_t was,
                                  std::uint32_t is) {
    while (slot != no_index) {
        LinkedFace& f = drawn_[slot];
        const std::size_t k = f.corner[0] == was ? 0 : f.corner[1] == was ? 1 : 2;
        f.corner[k] = is;
        if (slot == last) return;
        slot = f.neighbour[(k + (onward ? 1 : 2)) % 3];
    }
}

void ProgressiveMesh::split(std::uint32_t s) {
    const Split& record = splits_[s];
    const std::uint32_t u = base_ + s, v = record.of, number = base_faces_ + 2 * s;
    const auto& [to_1, from_1, to_2, from_2] = record.around;
    const std::uint32_t first_fan = slot_of(from_1), last_fan = slot_of(from_2);
    const auto relink = [&](std::uint32_t slot, std::uint32_t was, std::uint32_t is) {
        if (slot == no_index) return;
        auto& n = drawn_[slot].neighbour;
        n[n[0] == was ? 0 : n[1] == was ? 1 : 2] = is;
    };
    const auto place_in = [&](std::uint32_t slot) {
        const auto& c = drawn_[slot].corner;
        return c[0] == v ? 0u : c[1] == v ? 1u : 2u;
    };
    std::uint32_t first = no_index, second = no_index;
    const std::uint32_t at_1 = first_fan == no_index ? 0 : place_in(first_fan),
                        at_2 = last_fan == no_index ? 0 : place_in(last_fan);
    if (first_fan != no_index)
        turn_around(first_fan, true, last_fan, v, u);
    else
        turn_around(last_fan, false, no_index, v, u);
    if (first_fan != no_index) {
        const std::uint32_t ring = drawn_[first_fan].corner[(at_1 + 1) % 3];
        first = add_face(number, {{u, v, ring}, {slot_of(to_1), first_fan, no_index}});
        drawn_[first_fan].neighbour[(at_1 + 2) % 3] = first;
        relink(slot_of(to_1), first_fan, first);
    }
    if (last_fan != no_index) {
        const std::uint32_t ring = drawn_[last_fan].corner[(at_2 + 2) % 3];
        second = add_face(number + 1, {{u, ring, v}, {slot_of(to_2), first, last_fan}});
        drawn_[last_fan].neighbour[(at_2 + 1) % 3] = second;
        relink(slot_of(to_2), last_fan, second);
        if (first != no_index) drawn_[first].neighbour[2] = second;
    }
    next_[v] = record.after;
    for (const std::uint32_t face : record.around)
        if (const std::uint32_t m = maker_of(face); m != no_index) ++leaning_[m];
    where_[s] = static_cast<std::uint32_t>(made_.size());
    made_.push_back(s);
}

bool ProgressiveMesh::may_unsplit(std::uint32_t s) const {
    const std::uint32_t u = base_ + s;
    return leaning_[s] == 0 && next_[u] == first_[u] && next_[splits_[s].of] == splits_[s].after;
}

void ProgressiveMesh::unsplit(std::uint32_t s) {
    const Split& record = splits_[s];
    const std::uint32_t u = base_ + s, v = record.of, number = base_faces_ + 2 * s;
    const std::uint32_t first_fan = slot_of(record.around[1]), last_fan = slot_of(record.around[3]);
    for (std::uint32_t i = 0; i < 2; ++i) {
        const std::uint32_t fan = i == 0 ? first_fan : last_fan;
        if (fan == no_index) continue;
        const std::uint32_t gone = slots_[number + i], beyond = slot_of(record.around[2 * i]);
        for (const auto& [at, is] : {std::pair(fan, beyond), std::pair(beyond, fan)}) {
            if (at == no_index) continue;
            auto& n = drawn_[at].neighbour;
            n[n[0] == gone ? 0 : n[1] == gone ? 1 : 2] = is;
        }
        remove_face(number + i);
    }
    if (first_fan != no_index)
        turn_around(first_fan, true, last_fan, u, v);
    else
        turn_around(last_fan, false, no_index, u, v);
    next_[v] = s;
    for (const std::uint32_t face : record.around)
        if (const std::uint32_t m = maker_of(face); m != no_index) --leaning_[m];
    where_[made_.back()] = where_[s];
    made_[where_[s]] = made_.back();
    made_.pop_back();
    where_[s] = no_index;
}

std::uint32_t ProgressiveMesh::force(std::uint32_t wanted_split, std::uint32_t most) {
    std::uint32_t operations = 0;
    stack_.assign(1, wanted_split);
    while (!stack_.empty()) {
        const std::uint32_t s = stack_.back();
        const std::uint32_t v = splits_[s].of;
        std::uint32_t missing = no_index;
        if (where_[s] != no_index) {
            stack_.pop_back();
            continue;
        }
        if (v >= base_ && !made(v - base_))
            missing = v - base_;
        else if (next_[v] != s)
            missing = next_[v];
        else
            for (const std::uint32_t face : splits_[s].around)
                if (!made(maker_of(face))) missing = maker_of(face);
        if (missing != no_index) {
            stack_.push_back(missing);
            continue;
        }
        if (operations == most) return operations;
        split(s);
        ++operations;
        stack_.pop_back();
    }
    return operations;
}

// Undoes it, and those that it was made for alone.
std::uint32_t ProgressiveMesh::unsplit_from(const Eye& eye, std::uint32_t start, std::uint32_t most) {
    std::uint32_t operations = 0;
    stack_.assign(1, start);
    while (!stack_.empty() && operations < most) {
        const std::uint32_t s = stack_.back();
        stack_.pop_back();
        if (s == no_index || where_[s] == no_index || !may_unsplit(s) || wanted(eye, s)) continue;
        unsplit(s);
        ++operations;
        stack_.push_back(splits_[s].before);
        if (splits_[s].of >= base_) stack_.push_back(splits_[s].of - base_);
        for (const std::uint32_t face : splits_[s].around) stack_.push_back(maker_of(face));
    }
    return operations;
}

Refined ProgressiveMesh::refine(const View& view, double error_px, std::uint32_t operations) {
    const Eye eye{view.eye_m, make_frustum(view), focal_length_px(view) / error_px};
    std::uint32_t left = operations;
    bool behind = false;
    const auto refine_at = [&](std::uint32_t vertex) {
        while (next_[vertex] != no_index && wanted(eye, next_[vertex])) {
            if (left == 0) {
                behind = true;
                return;
            }
            left -= force(next_[vertex], left);
        }
    };
    for (std::uint32_t vertex = 0; vertex < base_; ++vertex) refine_at(vertex);
    for (std::size_t i = 0; i < made_.size(); ++i) refine_at(base_ + made_[i]); // grows
    for (std::size_t i = made_.size(); i-- > 0;) {
        if (i >= made_.size()) continue;
        const std::uint32_t s = made_[i];
        if (!may_unsplit(s) || wanted(eye, s)) continue;
        if (left == 0) {
            behind = true;
            break;
        }
        left -= unsplit_from(eye, s, left);
        behind = behind || !stack_.empty(); // what waits there may lie among those that were passed
    }
    return {static_cast<std::uint32_t>(drawn_.size() - free_.size()), behind};
}

void ProgressiveMesh::faces(std::vector<Face>& out) const {
    out.clear();
    for (const LinkedFace& f : drawn_) {
        if (f.corner[0] == f.corner[1]) continue;
        Face face;
        for (std::size_t k = 0; k < 3; ++k) {
            const Place& p = places_[f.corner[k]];
            face[k] = {static_cast<float>(p.column), static_cast<float>(p.row), p.height_m};
        }
        out.push_back(face);
    }
}

std::size_t ProgressiveMesh::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return of(places_) + of(splits_) + of(first_) + of(next_) + of(where_) + of(leaning_) + of(made_) + of(slots_) +
           of(drawn_) + of(free_);
}

} // namespace fjell::rivals
