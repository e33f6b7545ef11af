#include "baker/locks/locks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <xxhash.h>

#include "shared/stamp.h"

namespace fjell::baker {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();
constexpr std::size_t run_places = 64;
constexpr double longest_cells = 32; // of a side: longer ones are cut, so that the box of a run is small

// How many codes make an error at least so many times as large.
std::uint8_t codes_for(const ErrorScale& scale, double times) {
    std::uint8_t codes = 0;
    while (codes < 254 && static_cast<double>(scale.metres[1 + codes]) < static_cast<double>(scale.metres[1]) * times)
        ++codes;
    return codes;
}

} // namespace

struct Locks::Raster {
    const Window& window;
    const Window field; // what of it the field has
    std::vector<LockCodes>& codes;
    LockCodes held; // by the shape that is drawn

    void hold(std::int32_t x, std::int32_t y) {
        LockCodes& at = codes[static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.columns) +
                              static_cast<std::size_t>(x - window.x)];
        at.allowed = std::min(at.allowed, held.allowed);
        at.raise = std::max(at.raise, held.raise);
    }
};

Locks::Locks(const std::string& path, std::optional<double> error_m, const HeightSource& field,
             const std::string& layer)
    : spacing_m_{field.spacing_m[0], field.spacing_m[1]}, columns_(field.columns), rows_(field.rows) {
    std::size_t number = 0;
    for (const VectorShape& shape : read_vectors(path, VectorGrid(field), "locks", layer))
        add(shape, error_m, fmt::format("{}: lock {}", path, ++number));
    if (number == 0) throw Failure(1, fmt::format("{}: has no point, line or polygon", path));
    if (empty()) throw Failure(1, fmt::format("{}: its {} locks all lie beside the terrain", path, number));
}

void Locks::add(const VectorShape& shape, std::optional<double> error_m, const std::string& name) {
    const auto number = [&](const char* key, double least, double most, std::optional<double> usual) {
        const std::optional<double> said = shape.number(key);
        if (said && !(*said >= least && *said <= most))
            throw Failure(1, fmt::format("{}: {} is {}, and must be {} to {}", name, key, *said, least, most));
        return said ? said : usual;
    };
    const std::optional<double> px = number("error_px", 1e-3, 1, {});
    const std::optional<double> metres = number("error_m", 0, 1e6, px ? std::nullopt : error_m);
    if (!px && !metres)
        throw Failure(1, fmt::format("{}: has neither error_m nor error_px; give --lock-error-m for all such", name));
    const double width_m = number("width_m", 0, 1e6, 0).value_or(0);
    const double cell_m = std::hypot(spacing_m_[0], spacing_m_[1]);
    const std::size_t before = runs_.size();
    shapes_.push_back({shape.kind, width_m / 2 + cell_m, metres.value_or(no_limit), px.value_or(1)});
    for (const std::vector<Place>& part : shape.parts) add_part(part);
    const bool near = std::any_of(runs_.begin() + static_cast<std::ptrdiff_t>(before), runs_.end(), [&](const Run& r) {
        return r.box[2] >= 0 && r.box[3] >= 0 && r.box[0] <= columns_ - 1 && r.box[1] <= rows_ - 1;
    });
    // A polygon around the whole terrain has no side near it.
    const auto covers = [&] {
        if (shape.kind != VectorKind::polygon) return false;
        const Window corner{0, 0, 1, 1};
        std::vector<LockCodes> codes(1);
        Raster raster{corner, corner, codes, {0, 1}};
        hold_inside(std::span(runs_).subspan(before), raster);
        return codes[0].allowed == 0;
    };
    if (near || covers()) return;
    if (before < runs_.size()) places_.resize(runs_[before].first);
    runs_.resize(before);
    shapes_.pop_back();
    ++outside_;
}

void Locks::add_part(const std::vector<Place>& part) {
    const Shape& shape = shapes_.back();
    const auto flush = [&](std::size_t first) {
        Run run{shapes_.size() - 1, first, places_.size() - first, {no_limit, no_limit, -no_limit, -no_limit}};
        for (std::size_t i = first; i < places_.size(); ++i)
            for (std::size_t axis = 0; axis < 2; ++axis) {
                const double reach = shape.reach_m / spacing_m_[axis];
                run.box[axis] = std::min(run.box[axis], places_[i][axis] - reach);
                run.box[axis + 2] = std::max(run.box[axis + 2], places_[i][axis] + reach);
            }
        runs_.push_back(run);
    };
    std::size_t first = places_.size();
    for (std::size_t i = 0; i < part.size(); ++i) {
        const Place& to = part[i];
        const Place from = i == 0 ? to : part[i - 1];
        const double cells = std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1]));
        const double pieces = std::clamp(std::ceil(cells / longest_cells), 1.0, 1e5);
        for (double k = 1; k <= pieces; ++k) {
            const double t = k / pieces;
            places_.push_back(k == pieces ? to
                                          : Place{from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t});
            if (places_.size() - first < run_places) continue;
            flush(first);
            first = places_.size() - 1;
            places_.push_back(places_[first]); // the next run begins where this one ends
            ++first;
        }
    }
    if (places_.size() > first) flush(first);
}

std::vector<io::KeptStamp> Locks::stamps(const std::string& name) const {
    const double cell_m = std::hypot(spacing_m_[0], spacing_m_[1]);
    std::vector<io::KeptStamp> all;
    for (std::size_t i = 0, end = 0; i < runs_.size(); i = end) {
        while (end < runs_.size() && runs_[end].shape == runs_[i].shape) ++end;
        const Shape& s = shapes_[runs_[i].shape];
        if (s.error_px != 1 || s.error_m == no_limit)
            throw Failure(1,
                          fmt::format("{}: a lock has error_px, and stamps lock in metres alone; leave it out, or bake "
                                      "the file with --locks",
                                      name));
        Stamp lock;
        lock.shape = StampShape::lock;
        lock.amount_m = static_cast<float>(s.error_m);
        const std::span<const Run> runs(runs_.data() + i, end - i);
        if (s.kind == VectorKind::polygon) stamp_inside(runs, lock, all);
        lock.radius_m = static_cast<float>(s.reach_m - cell_m);
        for (const Run& run : runs) {
            io::KeptStamp& stamp = all.emplace_back(lock);
            for (std::size_t k = run.first; k < run.first + run.count; ++k)
                stamp.points.push_back({places_[k][0] * spacing_m_[0], places_[k][1] * spacing_m_[1], 0});
            if (run.count > 1) continue;
            stamp.plain.x_m = stamp.points[0].x_m, stamp.plain.z_m = stamp.points[0].z_m;
            stamp.points.clear();
        }
    }
    return all;
}

void Locks::stamp_inside(std::span<const Run> rings, const Stamp& lock, std::vector<io::KeptStamp>& to) const {
    std::array<double, 4> box{no_limit, no_limit, 0, 0};
    for (const Run& run : rings)
        for (std::size_t axis = 0; axis < 2; ++axis) {
            box[axis] = std::max(std::min(box[axis], run.box[axis]), 0.0);
            box[axis + 2] = std::max(box[axis + 2], run.box[axis + 2]);
        }
    constexpr std::int32_t side = 128;
    const auto last = [&](double at, std::int32_t count) {
        return static_cast<std::int32_t>(std::min(at, static_cast<double>(count - 1)));
    };
    for (std::int32_t y = last(box[1], rows_); y <= last(box[3], rows_); y += side)
        for (std::int32_t x = last(box[0], columns_); x <= last(box[2], columns_); x += side) {
            const Window window{x, y, std::min(side, columns_ - x), std::min(side, rows_ - y)};
            std::vector<LockCodes> codes(window.area());
            Raster raster{window, window, codes, {0, 0}};
            hold_inside(rings, raster);
            io::KeptStamp stamp(lock);
            stamp.plain.first = {x, y};
            stamp.plain.columns = window.columns, stamp.plain.rows = window.rows;
            std::size_t held = 0;
            for (const LockCodes& at : codes) {
                stamp.mask.push_back(at.allowed == 0 ? 255 : 0);
                held += at.allowed == 0;
            }
            if (held == codes.size()) stamp.mask.clear();
            if (held != 0) to.push_back(std::move(stamp));
        }
}

bool Locks::in_metres() const {
    return !stamps_.empty() || std::ranges::any_of(shapes_, [](const Shape& s) { return s.error_m != no_limit; });
}

double Locks::sharpest() const {
    double least = 1;
    for (const Shape& s : shapes_) least = std::min(least, s.error_px);
    return 1 / least;
}

std::string Locks::account() const {
    std::string text;
    const auto say = [&](std::size_t count, const char* one, const char* more) {
        if (count) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, count == 1 ? one : more);
    };
    const auto of = [&](VectorKind kind) {
        return static_cast<std::size_t>(std::ranges::count(shapes_, kind, &Shape::kind));
    };
    say(of(VectorKind::point), "point", "points");
    say(of(VectorKind::line), "line", "lines");
    say(of(VectorKind::polygon), "area", "areas");
    say(static_cast<std::size_t>(std::ranges::count(stamps_, StampShape::lock, &Stamp::shape)), "stamp", "stamps");
    if (outside_) text += fmt::format("; {} beside the terrain left out", outside_);
    return text;
}

std::string Locks::identity() const {
    if (shapes_.empty()) return {}; // stamps are the source's
    std::string text = "\nlocks";
    for (const Shape& s : shapes_)
        text += fmt::format(" {} {} {} {}", static_cast<int>(s.kind), s.reach_m, s.error_m, s.error_px);
    for (const Run& r : runs_) text += fmt::format(" {} {}", r.shape, r.count);
    return text + fmt::format(" {:016x}", XXH3_64bits(places_.data(), places_.size() * sizeof(Place)));
}

std::vector<LockCodes> Locks::over(const Window& window, const ErrorScale& scale) const {
    std::vector<LockCodes> codes;
    const Window field = common(window, {0, 0, columns_, rows_});
    const double from_x = field.x, from_y = field.y, to_x = field.x + field.columns - 1,
                 to_y = field.y + field.rows - 1;
    const auto meets = [&](const std::array<double, 4>& b) {
        return b[0] <= to_x && b[1] <= to_y && b[2] >= from_x && b[3] >= from_y;
    };
    for (std::size_t i = 0, end = 0; i < runs_.size(); i = end) {
        std::array<double, 4> box{no_limit, no_limit, -no_limit, -no_limit}; // of the shape
        for (; end < runs_.size() && runs_[end].shape == runs_[i].shape; ++end)
            for (std::size_t axis = 0; axis < 2; ++axis) {
                box[axis] = std::min(box[axis], runs_[end].box[axis]);
                box[axis + 2] = std::max(box[axis + 2], runs_[end].box[axis + 2]);
            }
        if (!meets(box)) continue;
        if (codes.empty()) codes.resize(window.area());
        const Shape& s = shapes_[runs_[i].shape];
        const std::uint8_t allowed =
            s.error_m == no_limit ? LockCodes::any : scale.code_down(static_cast<float>(s.error_m));
        Raster raster{window, field, codes, {allowed, codes_for(scale, 1 / s.error_px)}};
        const std::span<const Run> runs(runs_.data() + i, end - i);
        if (s.kind == VectorKind::polygon) hold_inside(runs, raster);
        for (const Run& run : runs)
            if (meets(run.box)) hold_along(run, raster);
    }
    if (!stamps_.empty()) hold_stamped(field, scale, window, codes);
    return codes;
}

void Locks::add_stamps(const HeightSource& field) {
    std::copy_n(field.spacing_m, 2, spacing_m_);
    columns_ = field.columns, rows_ = field.rows;
    const auto all = field.locks();
    const edit::StampGrid grid(columns_, rows_, spacing_m_);
    for (const Stamp& stamp : all)
        if ((stamp.shape == StampShape::lock || !stamps_.empty()) && !edit::samples_of(grid, stamp).empty())
            stamps_.push_back(stamp);
}

// What stamps hold in the end, one after the other, as the runtime does (edit/locks.h). They take nothing away from
// shapes.
void Locks::hold_stamped(const Window& field, const ErrorScale& scale, const Window& window,
                         std::vector<LockCodes>& codes) const {
    using edit::Rect;
    const edit::StampGrid grid(columns_, rows_, spacing_m_);
    const Rect near{field.x, field.y, field.x + field.columns - 1, field.y + field.rows - 1};
    std::vector<std::uint8_t> allowed;
    const auto index = [&](std::int32_t x, std::int32_t y) {
        return static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.columns) +
               static_cast<std::size_t>(x - window.x);
    };
    for (const Stamp& stamp : stamps_) {
        const Rect all = edit::samples_of(grid, stamp).within(near);
        const bool locks = stamp.shape == StampShape::lock;
        if (all.empty() || (allowed.empty() && !locks)) continue;
        if (allowed.empty()) allowed.assign(window.area(), LockCodes::any);
        const std::uint8_t code = scale.code_down(stamp.amount_m);
        constexpr std::int32_t side = 32;
        for (std::int32_t by = all.y0; by <= all.y1; by += side)
            for (std::int32_t bx = all.x0; bx <= all.x1; bx += side) {
                const Rect part = Rect{bx, by, bx + side - 1, by + side - 1}.within(all);
                if (!edit::may_change(grid, stamp, part)) continue;
                for (std::int32_t y = part.y0; y <= part.y1; ++y)
                    for (std::int32_t x = part.x0; x <= part.x1; ++x) {
                        if (!edit::locks_sample(grid, stamp, {x, y})) continue;
                        std::uint8_t& at = allowed[index(x, y)];
                        at = locks ? std::min(at, code) : LockCodes::any;
                    }
            }
    }
    if (std::ranges::all_of(allowed, [](std::uint8_t code) { return code == LockCodes::any; })) return;
    if (codes.empty()) codes.resize(window.area());
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i].allowed = std::min(codes[i].allowed, allowed[i]);
}

// Samples within reach of a side, or of a point.
void Locks::hold_along(const Run& run, Raster& raster) const {
    const double reach_m = shapes_[run.shape].reach_m;
    const Window& w = raster.field;
    for (std::size_t i = run.first; i < run.first + run.count; ++i) {
        const Place& a = places_[i == run.first ? i : i - 1];
        const Place& b = places_[i];
        const auto range = [&](std::size_t axis, std::int32_t first, std::int32_t count) {
            const double reach = reach_m / spacing_m_[axis];
            const double from = std::ceil(std::min(a[axis], b[axis]) - reach),
                         to = std::floor(std::max(a[axis], b[axis]) + reach);
            return std::pair{static_cast<std::int32_t>(std::max(from, static_cast<double>(first))),
                             static_cast<std::int32_t>(std::min(to, static_cast<double>(first + count - 1)))};
        };
        const auto [x0, x1] = range(0, w.x, w.columns);
        const auto [y0, y1] = range(1, w.y, w.rows);
        const double dx = (b[0] - a[0]) * spacing_m_[0], dy = (b[1] - a[1]) * spacing_m_[1];
        const double length2 = dx * dx + dy * dy;
        for (std::int32_t y = y0; y <= y1; ++y)
            for (std::int32_t x = x0; x <= x1; ++x) {
                const double px = (x - a[0]) * spacing_m_[0], py = (y - a[1]) * spacing_m_[1];
                const double t = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0;
                const double ex = px - t * dx, ey = py - t * dy;
                if (ex * ex + ey * ey <= reach_m * reach_m) raster.hold(x, y);
            }
    }
}

void Locks::hold_inside(std::span<const Run> rings, Raster& raster) const {
    const Window& w = raster.field;
    std::vector<std::span<const Place>> pieces;
    for (const Run& run : rings)
        if (run.box[3] >= w.y && run.box[1] <= w.y + w.rows)
            pieces.push_back(std::span(places_).subspan(run.first, run.count));
    for_stretches_inside(pieces, w, [&](std::int32_t y, std::int32_t first, std::int32_t last) {
        for (std::int32_t x = first; x <= last; ++x) raster.hold(x, y);
    });
}

} // namespace fjell::baker
