#include "baker/read/coarse_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "baker/read/vectors.h"

namespace fjell::baker {

namespace {

using Place = VectorShape::Place;

// Polygons, and how much detail there is in each.
class CoarseAreas {
public:
    CoarseAreas(const HeightSource& field, const std::string& path, std::optional<double> detail_m)
        : field_{0, 0, field.columns, field.rows} {
        const double sample_m = std::max(field.spacing_m[0], field.spacing_m[1]);
        std::size_t number = 0;
        for (VectorShape& shape : read_vectors(path, VectorGrid(field), "polygons")) {
            if (shape.kind != VectorKind::polygon) continue;
            ++number;
            const std::optional<double> own = shape.number("detail_m"), metres = own ? own : detail_m;
            if (!metres)
                throw Failure(1, fmt::format("{}: polygon {}: has no detail_m; give --coarse-detail-m for all such",
                                             path, number));
            if (!(*metres >= 2 * sample_m && *metres <= 1e6))
                throw Failure(1, fmt::format("{}: polygon {}: detail_m is {}, and must be {} to 1000000: samples are "
                                             "{} m apart, and at least every second one is left out",
                                             path, number, *metres, 2 * sample_m, sample_m));
            add(shape, std::min(std::ilogb(*metres / sample_m), most_coarse_log2));
        }
        if (number == 0) throw Failure(1, fmt::format("{}: has no polygon", path));
        if (areas_.empty())
            throw Failure(1, fmt::format("{}: its {} polygons all lie beside the terrain", path, number));
    }

    [[nodiscard]] int most_log2() const { return most_log2_; }
    [[nodiscard]] std::string account() const {
        return fmt::format("{} {} with {} samples between heights", areas_.size(),
                           areas_.size() == 1 ? "area" : "areas",
                           least_log2_ == most_log2_ ? std::to_string(1 << most_log2_)
                                                     : fmt::format("{} to {}", 1 << least_log2_, 1 << most_log2_));
    }
    [[nodiscard]] std::uint64_t hash() const {
        std::uint64_t hash = 0;
        for (const Area& area : areas_) {
            hash = XXH3_64bits_withSeed(&area.log2, sizeof area.log2, hash);
            for (const std::vector<Place>& ring : area.rings)
                hash = XXH3_64bits_withSeed(ring.data(), ring.size() * sizeof(Place), hash);
        }
        return hash;
    }
    // Of a window's samples, row by row: the binary logarithm of the samples between heights that are kept; 0: all are.
    // Empty: all are in all of them.
    [[nodiscard]] std::vector<std::uint8_t> over(const Window& window) const {
        std::vector<std::uint8_t> logs;
        std::vector<std::span<const Place>> near;
        for (const Area& area : areas_) {
            near.clear();
            for (const Piece& piece : area.pieces)
                if (piece.to >= window.y && piece.from <= window.y + window.rows)
                    near.push_back(std::span(area.rings[piece.ring]).subspan(piece.first, piece.count));
            for_stretches_inside(near, window, [&](std::int32_t y, std::int32_t first, std::int32_t last) {
                if (logs.empty()) logs.resize(window.area());
                std::uint8_t* const row =
                    logs.data() + static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.columns);
                for (std::int32_t x = first; x <= last; ++x) {
                    std::uint8_t& at = row[x - window.x];
                    at = at == 0 ? area.log2 : std::min(at, area.log2);
                }
            });
        }
        return logs;
    }

private:
    struct Piece { // of a ring's sides, and the rows that they cross
        std::size_t ring, first, count;
        double from, to;
    };
    struct Area {
        std::uint8_t log2;
        std::vector<std::vector<Place>> rings;
        std::vector<Piece> pieces;
    };

    void add(VectorShape& shape, int log2) {
        constexpr std::size_t a_piece = 64;
        Area area{static_cast<std::uint8_t>(log2), std::move(shape.parts), {}};
        double box[4] = {HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
        for (std::size_t r = 0; r < area.rings.size(); ++r) {
            const std::vector<Place>& ring = area.rings[r];
            for (std::size_t first = 0; first + 1 < ring.size(); first += a_piece - 1) {
                Piece piece{r, first, std::min(a_piece, ring.size() - first), HUGE_VAL, -HUGE_VAL};
                for (std::size_t i = first; i < first + piece.count; ++i) {
                    piece.from = std::min(piece.from, ring[i][1]), piece.to = std::max(piece.to, ring[i][1]);
                    for (std::size_t axis = 0; axis < 2; ++axis)
                        box[axis] = std::min(box[axis], ring[i][axis]),
                        box[axis + 2] = std::max(box[axis + 2], ring[i][axis]);
                }
                area.pieces.push_back(piece);
            }
        }
        if (!(box[0] < field_.columns && box[1] < field_.rows && box[2] >= 0 && box[3] >= 0)) return;
        least_log2_ = std::min(least_log2_, log2), most_log2_ = std::max(most_log2_, log2);
        areas_.push_back(std::move(area));
    }

    Window field_;
    std::vector<Area> areas_;
    int least_log2_ = most_coarse_log2, most_log2_ = 0;
};

// Heights of a window, of which squares lose their detail: from the largest ones down, each from the corners that it
// has by then. Squares lie on the field's grid, so it does not matter how windows are cut.
class Flattener {
public:
    Flattener(const Window& window, std::vector<std::uint8_t> logs, float* heights_m)
        : window_(window), logs_(std::move(logs)), heights_m_(heights_m) {}

    void flatten(int log2) {
        const std::int32_t side = 1 << log2;
        const auto first = [&](std::int32_t at) { return (at + side - 1) & -side; };
        for (std::int32_t y = first(window_.y); y + side < window_.y + window_.rows; y += side)
            for (std::int32_t x = first(window_.x); x + side < window_.x + window_.columns; x += side)
                if (may_lose({x, y}, side, log2)) square({x, y}, side);
    }

private:
    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y - window_.y) * static_cast<std::size_t>(window_.columns) +
               static_cast<std::size_t>(x - window_.x);
    }
    [[nodiscard]] bool may_lose(SampleIndex at, std::int32_t side, int log2) const {
        for (std::int32_t y = at.row; y <= at.row + side; ++y)
            for (std::int32_t x = at.column; x <= at.column + side; ++x)
                if (logs_[index(x, y)] < log2 || std::isnan(heights_m_[index(x, y)])) return false;
        return true;
    }
    void square(SampleIndex at, std::int32_t side) {
        const std::int32_t x1 = at.column + side, y1 = at.row + side;
        const double nw = height(at.column, at.row), ne = height(x1, at.row), sw = height(at.column, y1),
                     se = height(x1, y1);
        // Squares alternate which diagonal a centre splits, as triangles of the mesh do.
        const bool falling = ((at.column + at.row) / side) % 2 == 0;
        for (std::int32_t dy = 0; dy <= side; ++dy)
            for (std::int32_t dx = 0; dx <= side; ++dx) {
                const double x = static_cast<double>(dx) / side, y = static_cast<double>(dy) / side;
                double h = 0;
                if (dy == 0) // sides alone, as both of their squares have them
                    h = nw + (ne - nw) * x;
                else if (dy == side)
                    h = sw + (se - sw) * x;
                else if (dx == 0)
                    h = nw + (sw - nw) * y;
                else if (dx == side)
                    h = ne + (se - ne) * y;
                else if (falling)
                    h = x > y ? nw + (ne - nw) * x + (se - ne) * y : nw + (se - sw) * x + (sw - nw) * y;
                else
                    h = x + y < 1 ? nw + (ne - nw) * x + (sw - nw) * y : se + (sw - se) * (1 - x) + (ne - se) * (1 - y);
                heights_m_[index(at.column + dx, at.row + dy)] = static_cast<float>(h);
                // What lies inside has lost its detail, and no smaller square takes it up.
                if (dx != 0 && dy != 0 && dx != side && dy != side) logs_[index(at.column + dx, at.row + dy)] = 0;
            }
    }
    [[nodiscard]] double height(std::int32_t x, std::int32_t y) const { return heights_m_[index(x, y)]; }

    Window window_;
    std::vector<std::uint8_t> logs_;
    float* heights_m_;
};

class CoarseReader final : public HeightReader {
public:
    CoarseReader(std::unique_ptr<HeightReader> reader, std::shared_ptr<const CoarseAreas> areas, const Window& field)
        : reader_(std::move(reader)), areas_(std::move(areas)), field_(field) {}

    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        reader_->read(window, to, statistics);
        const Window wide = widened(window, 1 << areas_->most_log2());
        std::vector<std::uint8_t> logs = areas_->over(wide);
        if (logs.empty()) return;
        std::vector<float> heights_m(wide.area());
        ReadStatistics ignored; // what is wanted has been counted
        reader_->read(wide, heights_m.data(), ignored);
        Flattener flattener(wide, std::move(logs), heights_m.data());
        for (int log2 = areas_->most_log2(); log2 > 0; --log2) flattener.flatten(log2);
        const float* row =
            heights_m.data() + static_cast<std::ptrdiff_t>(window.y - wide.y) * wide.columns + (window.x - wide.x);
        for (std::int32_t y = 0; y < window.rows; ++y, row += wide.columns, to += window.columns)
            std::copy_n(row, window.columns, to);
    }
    [[nodiscard]] bool covers(const Window& window) override { return reader_->covers(window); }

private:
    // With the largest squares around it, and those around these: a square's corners may lie on a larger one.
    [[nodiscard]] Window widened(const Window& w, std::int32_t side) const {
        const auto low = [&](std::int32_t at) { return (at & -side) - 2 * side; };
        const auto high = [&](std::int32_t at) { return ((at + side - 1) & -side) + 2 * side; };
        const std::int32_t x = low(w.x), y = low(w.y);
        return common({x, y, high(w.x + w.columns - 1) - x + 1, high(w.y + w.rows - 1) - y + 1}, field_);
    }

    std::unique_ptr<HeightReader> reader_;
    std::shared_ptr<const CoarseAreas> areas_;
    Window field_;
};

class CoarseSource final : public HeightSource {
public:
    CoarseSource(std::unique_ptr<HeightSource> source, const std::string& path, std::optional<double> detail_m)
        : source_(std::move(source)), areas_(std::make_shared<CoarseAreas>(*source_, path, detail_m)) {
        take_place_of(*source_);
        facts.coarse = areas_->account();
    }

    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<CoarseReader>(source_->reader(), areas_, Window{0, 0, columns, rows});
    }
    [[nodiscard]] int readers(int threads) const override { return source_->readers(threads); }
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override { return source_->windows(most); }
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override {
        SourceProperties all = source_->properties(statistics);
        all.native_quantum_m = 0; // what lies between two heights is on no step of theirs
        return all;
    }
    [[nodiscard]] std::string identity() const override {
        return fmt::format("{}\ncoarse {:016x}", source_->identity(), areas_->hash());
    }
    [[nodiscard]] const edit::PaintSource* paint() const override { return source_->paint(); }
    [[nodiscard]] std::span<const Stamp> locks() const override { return source_->locks(); }

private:
    std::unique_ptr<HeightSource> source_;
    std::shared_ptr<const CoarseAreas> areas_;
};

} // namespace

std::unique_ptr<HeightSource> coarse_source(std::unique_ptr<HeightSource> source, const std::string& path,
                                            std::optional<double> detail_m) {
    return std::make_unique<CoarseSource>(std::move(source), path, detail_m);
}

} // namespace fjell::baker
