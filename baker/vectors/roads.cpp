#include "baker/vectors/roads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "baker/read/vectors.h"
#include "baker/vectors/profile.h"

namespace fjell::baker {

namespace {

double attribute(const VectorShape& shape, const std::string& name, double otherwise, double least, double most,
                 const std::string& path) {
    const std::optional<double> said = shape.number(name);
    if (!said) return otherwise;
    if (!(*said >= least && *said <= most))
        throw Failure(1,
                      fmt::format("{}: a line says {} {}, which may be {:g} to {:g}", path, name, *said, least, most));
    return *said;
}

class Lines {
public:
    Lines(const HeightSource& terrain, const std::vector<MapLine>& lines, const LineOptions& options, std::string name)
        : lines_(lines), o_(options), name_(std::move(name)), works_(terrain, name_),
          width_m_((terrain.columns - 1) * terrain.spacing_m[0]), height_m_((terrain.rows - 1) * terrain.spacing_m[1]),
          sample_m_(std::min(terrain.spacing_m[0], terrain.spacing_m[1])),
          widest_m_(std::max(terrain.spacing_m[0], terrain.spacing_m[1])) {}

    MadeLines roads() {
        make({}, sample_m_);
        std::vector<double> most(network_.stations.size(), most_grade); // of all lines that meet there
        std::vector<HeightLimit> limits;
        std::vector<Neighbours> neighbours;
        for (const Link& l : network_.links) {
            const double grade = lines_[l.line].max_grade;
            for (const std::uint32_t end : {l.from, l.to}) most[end] = std::min(most[end], grade);
            limits.push_back({l.from, l.to, grade * l.length_m});
            neighbours.push_back({l.from, l.to, l.length_m});
        }
        near_pairs(network_, near_samples * widest_m_, [&](const NearPair& p) {
            limits.push_back({p.a, p.b, std::min(most[p.a], most[p.b]) * beside_m(p)});
        });
        heights_m_ = limited_heights(without_bumps(ground_m_, neighbours, o_.smooth_m), limits);
        lay();
        return finish();
    }

    MadeLines rivers() {
        std::vector<bool> against(lines_.size());
        for (std::size_t i = 0; i < lines_.size(); ++i) against[i] = climbs(lines_[i]);
        make(against, 0.5 * sample_m_);
        lay();
        std::vector<double> most_m(network_.stations.size(), std::numeric_limits<double>::infinity());
        std::vector<Flow> flows;
        const std::vector<double> lowest_m = works_.lowest_ground_m();
        for (std::size_t i = 0; i < network_.links.size(); ++i) {
            const Link& l = network_.links[i];
            flows.push_back({l.from, l.to});
            // Nowhere above the ground at either end: what is between them is no higher than the higher one.
            for (const std::uint32_t end : {l.from, l.to})
                most_m[end] = std::min(most_m[end], std::min(ground_m_[end], lowest_m[i]) - lines_[l.line].depth_m);
        }
        // In a bend too narrow for the samples, and beside another river, they have one bed.
        constexpr double straight = 1.05;
        std::vector<std::uint32_t> one(network_.stations.size()); // a station of the same bed, which may be itself
        std::iota(one.begin(), one.end(), 0u);
        const auto first_of = [&](std::uint32_t station) {
            while (one[station] != station) station = one[station] = one[one[station]];
            return station;
        };
        near_pairs(network_, near_samples * widest_m_, [&](const NearPair& p) {
            const std::uint32_t a = first_of(p.a), b = first_of(p.b);
            if (a == b || p.along_m <= straight * p.distance_m) return;
            one[a] = b;
            flows.push_back({p.a, p.b}), flows.push_back({p.b, p.a});
        });
        heights_m_ = river_beds(most_m, flows);
        return finish();
    }

private:
    // A sample beside a bend or a crossing has one height for two places of the network, up to so many samples apart.
    static constexpr double near_samples = 4;
    // How far apart two such places count for a grade. They count less than their distance, because the samples between
    // them get the heights of one or the other. What a bend needs was found by trial: roads_test.cpp measures the
    // ground.
    static double beside_m(const NearPair& p) {
        if (std::isinf(p.along_m)) return 0.5 * p.distance_m;
        const double straight = p.distance_m / p.along_m;
        return straight * straight * straight * p.distance_m;
    }

    // Is the ground at its end higher than at its start?
    bool climbs(const MapLine& line) {
        double first_m = std::numeric_limits<double>::quiet_NaN(), last_m = first_m;
        for (const std::vector<Place>& piece : clipped(line.places, width_m_, height_m_))
            for (const Place& at : {piece.front(), piece.back()})
                if (const double h = works_.ground_m(at); !std::isnan(h)) {
                    if (std::isnan(first_m)) first_m = h;
                    last_m = h;
                }
        return last_m > first_m;
    }

    void make(const std::vector<bool>& against, double step_m) {
        std::vector<std::vector<Place>> all;
        for (const MapLine& line : lines_) {
            all.push_back(line.places);
            if (!against.empty() && against[all.size() - 1]) std::ranges::reverse(all.back());
        }
        constexpr double most_snap_m = 1;
        network_ = make_network(all, {width_m_, height_m_, step_m, std::min(0.25 * step_m, most_snap_m)});
        for (const bool again : {true, false}) {
            std::vector<GroundCells::Sample> samples;
            for (const Place& at : network_.stations) samples.push_back(works_.sample_of(at));
            works_.ground().load(samples);
            ground_m_.clear();
            std::vector<bool> gone;
            for (const Place& at : network_.stations) {
                ground_m_.push_back(works_.ground_m(at));
                gone.push_back(std::isnan(ground_m_.back()));
            }
            if (again) leave_out(network_, gone); // beside holes
        }
        if (network_.links.empty())
            throw Failure(1, fmt::format("{}: none of its {} lines lies on the terrain", name_, lines_.size()));
    }

    void lay() {
        std::vector<double> half_m;
        for (const Link& l : network_.links) half_m.push_back(0.5 * lines_[l.line].width_m + o_.shoulder_m);
        works_.lay(network_, half_m);
    }

    MadeLines finish() {
        MadeLines made;
        LineSummary& s = made.summary;
        std::vector<bool> there(lines_.size());
        s.asked_m = most_width_m;
        for (const Link& l : network_.links) {
            there[l.line] = true;
            s.length_m += l.length_m;
            s.ground_grade = std::max(s.ground_grade, std::abs(ground_m_[l.to] - ground_m_[l.from]) / l.length_m);
            s.grade = std::max(s.grade, std::abs(heights_m_[l.to] - heights_m_[l.from]) / l.length_m);
            s.asked_m = std::min(s.asked_m, lines_[l.line].width_m + 2 * o_.shoulder_m);
        }
        s.lines = static_cast<std::size_t>(std::ranges::count(there, true));
        s.bed_width_m = std::max(s.asked_m, widest_m_);
        for (std::size_t i = 0; i < heights_m_.size(); ++i)
            s.most_off_m = std::max(s.most_off_m, std::abs(heights_m_[i] - ground_m_[i]));
        made.stamps = works_.shape(heights_m_, o_.slopes, s.ground);
        if (o_.paint || o_.material != no_material) paint(made.stamps);
        return made;
    }

    void paint(std::vector<io::KeptStamp>& stamps) {
        for (const MapLine& line : lines_)
            for (const std::vector<Place>& piece : clipped(line.places, width_m_, height_m_)) {
                constexpr double soft = 0.1; // of the width, on either side
                const std::vector<Place> few = simplified(piece, soft * line.width_m);
                for (std::size_t first = 0; first + 1 < few.size(); first += max_path_points - 1) {
                    io::KeptStamp& stamp = stamps.emplace_back();
                    stamp.plain.shape = StampShape::paint;
                    stamp.plain.radius_m = static_cast<float>((0.5 - 0.5 * soft) * line.width_m);
                    stamp.plain.falloff_m = static_cast<float>(soft * line.width_m);
                    stamp.plain.material = o_.material;
                    if (o_.paint) std::copy_n(o_.paint->data(), 3, stamp.plain.rgb);
                    for (std::size_t i = first; i < std::min<std::size_t>(few.size(), first + max_path_points); ++i)
                        stamp.points.push_back({few[i][0], few[i][1], 0});
                }
            }
    }

    const std::vector<MapLine>& lines_;
    const LineOptions& o_;
    std::string name_;
    Earthworks works_;
    double width_m_, height_m_, sample_m_, widest_m_;
    Network network_;
    std::vector<double> ground_m_, heights_m_; // of stations
};

} // namespace

std::vector<MapLine> read_map_lines(const std::string& path, const std::string& layer, const HeightSource& terrain,
                                    LineKind kind, const LineOptions& options) {
    std::vector<MapLine> lines;
    for (VectorShape& shape : read_vectors(path, VectorGrid(terrain), "lines", layer)) {
        if (shape.kind != VectorKind::line) continue;
        MapLine& line = lines.emplace_back();
        line.places = std::move(shape.parts[0]);
        for (Place& at : line.places) at[0] *= terrain.spacing_m[0], at[1] *= terrain.spacing_m[1];
        line.width_m = attribute(shape, shape.number("width_m") ? "width_m" : "width", options.width_m, least_width_m,
                                 most_width_m, path);
        line.max_grade = options.max_grade, line.depth_m = options.depth_m;
        if (kind == LineKind::road)
            line.max_grade = attribute(shape, "max_grade", options.max_grade, least_grade, most_grade, path);
        else
            line.depth_m = attribute(shape, "depth_m", options.depth_m, 0, most_depth_m, path);
    }
    if (lines.empty()) throw Failure(1, fmt::format("{}: has no lines", path));
    return lines;
}

MadeLines make_lines(const HeightSource& terrain, const std::vector<MapLine>& lines, LineKind kind,
                     const LineOptions& options, const std::string& name) {
    Lines work(terrain, lines, options, name);
    return kind == LineKind::road ? work.roads() : work.rivers();
}

} // namespace fjell::baker
