// Every file is decoded on its own (no-data, mask, scale, unit, direction), so files may differ in all of these.
#include "baker/read/mosaic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <fmt/format.h>
#include <ogr_spatialref.h>

namespace fjell::baker {

namespace {

constexpr std::size_t most_open = 32; // files a reader keeps open
constexpr double off_grid = 0.05;     // samples that a file may be off its place
constexpr std::int32_t sliver = 64;   // file borders nearer to each other than this are one for cutting windows

bool same_crs(const std::string& a, const std::string& b) {
    if (a == b) return true;
    OGRSpatialReference first, second;
    return first.importFromWkt(a.c_str()) == OGRERR_NONE && second.importFromWkt(b.c_str()) == OGRERR_NONE &&
           first.IsSame(&second) != 0;
}

std::string warp_command(const Placement& like, const std::string& path) {
    return fmt::format("gdalwarp -t_srs CRS -tr {} {} -tap -r cubic {} OUT.tif", like.step[0], like.step[1], path);
}

void check_alike(const FileFacts& a, const FileFacts& b) {
    for (const FileFacts* f : {&a, &b})
        if (!f->at.command.empty())
            throw Failure(1, fmt::format("{}: is placed by control points or arrays of coordinates alone; make a grid "
                                         "of it first: {}",
                                         f->path, f->at.command));
        else if (f->at.axes == Axes::none)
            throw Failure(1,
                          fmt::format("{}: has no georeference, so that its place beside {} is not known; give it one "
                                      "with gdal_edit.py -a_ullr",
                                      f->path, f == &a ? b.path : a.path));
    if (!same_crs(a.at.crs_wkt, b.at.crs_wkt) || a.at.axes != b.at.axes)
        throw Failure(1, fmt::format("{}: is in another CRS than {}; bring them together first: {}", b.path, a.path,
                                     warp_command(a.at, b.path)));
    for (const int axis : {0, 1}) {
        const double samples = axis == 0 ? std::max(a.at.columns, b.at.columns) : std::max(a.at.rows, b.at.rows);
        if (std::abs(b.at.step[axis] / a.at.step[axis] - 1) * samples > off_grid)
            throw Failure(1, fmt::format("{}: its samples are {} apart, those of {} {}; bring them together first: {}",
                                         b.path, b.at.step[axis], a.path, a.at.step[axis], warp_command(a.at, b.path)));
        const double apart = (b.at.origin[axis] - a.at.origin[axis]) / a.at.step[axis];
        if (!(std::abs(apart - std::round(apart)) <= off_grid))
            throw Failure(1, fmt::format("{}: its samples lie between those of {}; bring them together first: {}",
                                         b.path, a.path, warp_command(a.at, b.path)));
        if (!(std::abs(apart) + samples < std::numeric_limits<std::int32_t>::max() / 2))
            throw Failure(1,
                          fmt::format("{}: is too far from {} for one terrain; bake them one by one", b.path, a.path));
    }
}

// Longitudes, and places on a map of all of them, name a place by any number of turns. Files on both sides of the
// antimeridian are brought together, by whole turns, when all of them then take less room: what lies beside the widest
// gap between them begins the field.
void unwrap(std::vector<MosaicFile>& files) {
    const Placement first = files.front().facts.at;
    if (first.axes != Axes::degrees && (first.axes != Axes::metres || first.crs_wkt.empty())) return;
    OGRSpatialReference crs;
    crs.importFromWkt(first.crs_wkt.c_str());
    const double turn = first.crs_wkt.empty() ? 360 : turn_of(crs).length, turn_samples = turn / first.step[0];
    if (!(turn > 0)) return;
    if (std::abs(turn_samples - std::round(turn_samples)) > 0.01) return; // a turn would not keep the grid
    struct Span {
        double west, east; // west in 0..turn
    };
    std::vector<Span> spans;
    double west = HUGE_VAL, east = -HUGE_VAL;
    for (const MosaicFile& f : files) {
        const Placement& at = f.facts.at;
        if (at.axes != first.axes || at.step[0] != first.step[0]) return;
        west = std::min(west, at.east(-0.5)), east = std::max(east, at.east(at.columns - 0.5));
        const double from = at.east(-0.5) - turn * std::floor(at.east(-0.5) / turn);
        spans.push_back({from, from + at.columns * at.step[0]});
    }
    std::ranges::sort(spans, {}, &Span::west);
    double begin = spans[0].west, reached = spans[0].east, widest = 0;
    for (std::size_t i = 1; i <= spans.size(); ++i) { // the last time round to the first
        const double next = i < spans.size() ? spans[i].west : spans[0].west + turn;
        if (next - reached > widest) widest = next - reached, begin = next - (i < spans.size() ? 0 : turn);
        if (i < spans.size()) reached = std::max(reached, spans[i].east);
    }
    if (turn - widest > east - west - 0.5 * first.step[0]) return;
    for (MosaicFile& f : files) {
        const double from = f.facts.at.east(-0.5) - turn * std::floor((f.facts.at.east(-0.5) - begin) / turn + 1e-9);
        f.facts.at.origin[0] += turn * std::round((from - f.facts.at.east(-0.5)) / turn);
    }
    if (files.front().facts.at.origin[0] >= turn) // as near to 0 as turns allow
        for (MosaicFile& f : files) f.facts.at.origin[0] -= turn;
}

// Places relative to the first file's, then to the north-west of all.
void set_places(MosaicLayout& layout) {
    const Placement first = layout.files.front().facts.at;
    std::int32_t west = 0, north = 0, east = first.columns, south = first.rows;
    for (MosaicFile& f : layout.files) {
        f.x = static_cast<std::int32_t>(std::lround((f.facts.at.origin[0] - first.origin[0]) / first.step[0]));
        f.y = static_cast<std::int32_t>(std::lround((first.origin[1] - f.facts.at.origin[1]) / first.step[1]));
        west = std::min(west, f.x);
        north = std::min(north, f.y);
        east = std::max(east, f.x + f.facts.at.columns);
        south = std::max(south, f.y + f.facts.at.rows);
    }
    for (MosaicFile& f : layout.files) f.x -= west, f.y -= north;
    layout.at = first;
    layout.at.flip_x = layout.at.flip_y = false;
    layout.at.columns = east - west;
    layout.at.rows = south - north;
    layout.at.origin[0] = first.east(west);
    layout.at.origin[1] = first.north(north);
}

// Where windows are cut: where files begin, but for slivers.
std::vector<std::int32_t> cuts(std::vector<std::int32_t> starts, std::int32_t from, std::int32_t to) {
    std::sort(starts.begin(), starts.end());
    std::vector<std::int32_t> kept{from};
    for (const std::int32_t at : starts)
        if (at - kept.back() >= sliver && to - at >= sliver) kept.push_back(at);
    kept.push_back(to);
    return kept;
}

// Blocks of the file that is on top in the middle of a cell.
Blocks blocks_at(const MosaicLayout& layout, const Window& cell) {
    const std::int32_t x = cell.x + cell.columns / 2, y = cell.y + cell.rows / 2;
    for (auto f = layout.files.rbegin(); f != layout.files.rend(); ++f) {
        Blocks b = f->facts.blocks;
        b.x += f->x, b.y += f->y;
        if (x >= f->x && y >= f->y && x < f->x + f->facts.at.columns && y < f->y + f->facts.at.rows) return b;
    }
    return {cell.columns, 1, cell.x, cell.y};
}

} // namespace

MosaicLayout lay_out(const std::vector<std::string>& paths, const ReadOptions& options) {
    MosaicLayout layout;
    for (const std::string& path : paths) {
        const HeightFile file(path, options);
        layout.files.push_back({file.facts(), 0, 0});
    }
    if (layout.files.size() > 1) unwrap(layout.files);
    for (const MosaicFile& f : layout.files)
        if (&f != &layout.files.front()) check_alike(layout.files.front().facts, f.facts);
    set_places(layout);
    return layout;
}

std::vector<Window> cut_along(const MosaicLayout& layout, const Window& area, std::size_t most) {
    if (layout.files.size() == 1) return cut_along(area, layout.files.front().facts.blocks, most);
    std::vector<std::int32_t> xs, ys;
    for (const MosaicFile& f : layout.files) xs.push_back(f.x), ys.push_back(f.y);
    xs = cuts(std::move(xs), area.x, area.x + area.columns);
    ys = cuts(std::move(ys), area.y, area.y + area.rows);
    std::vector<Window> windows;
    for (std::size_t j = 0; j + 1 < ys.size(); ++j)
        for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
            const Window cell{xs[i], ys[j], xs[i + 1] - xs[i], ys[j + 1] - ys[j]};
            const auto more = cut_along(cell, blocks_at(layout, cell), most);
            windows.insert(windows.end(), more.begin(), more.end());
        }
    return windows;
}

Mosaic::Mosaic(const MosaicLayout& layout, const ReadOptions& options)
    : layout_(layout), options_(options), open_(layout.files.size()) {}

HeightFile& Mosaic::open(std::size_t index) {
    Open& wanted = open_[index];
    wanted.used = ++uses_;
    if (wanted.file) return *wanted.file;
    if (open_count_ == most_open) {
        const auto oldest = std::min_element(open_.begin(), open_.end(), [](const Open& a, const Open& b) {
            return std::make_tuple(!a.file, a.used) < std::make_tuple(!b.file, b.used);
        });
        oldest->file.reset();
        --open_count_;
    }
    const FileFacts& before = layout_.files[index].facts;
    wanted.file = std::make_unique<HeightFile>(before.path, options_);
    ++open_count_;
    if (wanted.file->facts().identity != before.identity)
        throw Failure(1, fmt::format("{}: changed while it was read; start again", before.path));
    return *wanted.file;
}

// Fills what is still NaN from one file.
void Mosaic::paint(std::size_t index, const Window& window, float* to, ReadStatistics& statistics) {
    const MosaicFile& f = layout_.files[index];
    const std::int32_t left = std::max(window.x, f.x), top = std::max(window.y, f.y);
    const std::int32_t right = std::min(window.x + window.columns, f.x + f.facts.at.columns);
    const std::int32_t bottom = std::min(window.y + window.rows, f.y + f.facts.at.rows);
    if (left >= right || top >= bottom) return;
    const Window part{left, top, right - left, bottom - top};
    const auto columns = static_cast<std::size_t>(part.columns);
    const auto row_of = [&](std::int32_t row) {
        return to + static_cast<std::size_t>(part.y - window.y + row) * static_cast<std::size_t>(window.columns) +
               static_cast<std::size_t>(part.x - window.x);
    };
    wanted_.resize(part.area());
    for (std::int32_t row = 0; row < part.rows; ++row)
        std::transform(row_of(row), row_of(row) + columns,
                       wanted_.begin() + static_cast<std::ptrdiff_t>(row) * part.columns,
                       [](float height) { return static_cast<std::uint8_t>(std::isnan(height)); });
    const bool all = std::find(wanted_.begin(), wanted_.end(), 0) == wanted_.end();
    if (!all && std::find(wanted_.begin(), wanted_.end(), 1) == wanted_.end()) return;
    part_.resize(part.area());
    ReadStatistics own;
    own.per_unit = statistics.per_unit;
    open(index).read({part.x - f.x, part.y - f.y, part.columns, part.rows}, part_.data(), own,
                     all ? nullptr : wanted_.data());
    own.voids = {}; // counted when every file is painted
    own.implausible.column += f.x, own.implausible.row += f.y;
    own.ends.move(f.x, f.y);
    statistics.add(own);
    for (std::size_t i = 0; i < part_.size(); ++i) {
        float& height = row_of(static_cast<std::int32_t>(i / columns))[i % columns];
        if (wanted_[i]) height = part_[i];
    }
}

bool Mosaic::covers(const Window& window) {
    for (std::size_t index = 0; index < layout_.files.size(); ++index) {
        const MosaicFile& f = layout_.files[index];
        const Window part = common(window, {f.x, f.y, f.facts.at.columns, f.facts.at.rows});
        if (part.area() == 0) continue;
        if (layout_.files.size() > 1 || open(index).covers({part.x - f.x, part.y - f.y, part.columns, part.rows}))
            return true;
    }
    return false;
}

void Mosaic::read(const Window& window, float* to, ReadStatistics& statistics) {
    if (layout_.files.size() == 1) return open(0).read(window, to, statistics);
    std::fill_n(to, window.area(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t index = layout_.files.size(); index-- > 0;) paint(index, window, to, statistics);
    const auto columns = static_cast<std::size_t>(window.columns);
    for (std::size_t i = 0; i < window.area(); ++i)
        if (std::isnan(to[i]))
            statistics.voids.add(window.x + static_cast<std::int32_t>(i % columns),
                                 window.y + static_cast<std::int32_t>(i / columns));
}

} // namespace fjell::baker
