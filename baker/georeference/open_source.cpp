// Heights from any raster GDAL opens (thesis 5.3.1, its DataReader for bmp and ascii). Everything that could change the
// ground silently - units, degrees, voids, orientation - is converted, or refused with the option that decides it.
#include "baker/georeference/open_source.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "baker/georeference/crs_label.h"
#include "baker/georeference/ground_scale.h"
#include "baker/georeference/projection.h"
#include "baker/georeference/warp.h"
#include "baker/read/gdal_file.h"
#include "baker/read/mosaic.h"
#include "baker/read/void_check.h"
#include "fjell/pack.h"

namespace fjell::baker {

namespace {

void check_options(const std::vector<std::string>& paths, const ReadOptions& o) {
    if (paths.empty()) throw Failure(2, "no height field given; name at least one file");
    if (o.spacing_m && !(*o.spacing_m >= min_spacing_m && *o.spacing_m <= max_spacing_m))
        throw Failure(2, fmt::format("--spacing {} is out of range; give metres between samples in {}..{:.0f}",
                                     *o.spacing_m, min_spacing_m, max_spacing_m));
    if (o.zscale && !(std::abs(*o.zscale) >= 1e-6 && std::abs(*o.zscale) <= 1e6))
        throw Failure(2, fmt::format("--zscale {} is out of range; give a factor of size 1e-6..1e6", *o.zscale));
    if (!(std::abs(o.zoffset_m) <= 1e7))
        throw Failure(2, fmt::format("--zoffset {} is out of range; give metres in -1e7..1e7", o.zoffset_m));
    if (!o.vertical_unit.empty() && !(unit_in_metres(o.vertical_unit.c_str()) > 0))
        throw Failure(2, fmt::format("--vertical-unit {}: is not known; give m, ft, us-ft, another name of PROJ's, or "
                                     "--zscale S (metres a unit) instead",
                                     o.vertical_unit.substr(0, 100)));
    if (!o.bbox) return;
    for (const double edge : *o.bbox)
        if (!(std::abs(edge) <= 1e9))
            throw Failure(2, fmt::format("--bbox: {} is out of range; give WEST,SOUTH,EAST,NORTH", edge));
}

// What a source and all its readers know; never changes.
struct ReadPlan {
    ReadOptions options;
    MosaicLayout layout;
    bool warped = false;
    double ratio = 1; // resampling_ratio()
    Placement target; // what windows are cut from: the layout's own grid, or the one it is reprojected to
    Window crop;      // of the target: the source's extents
    [[nodiscard]] const std::string& name() const { return layout.files.front().facts.path; }
    [[nodiscard]] std::string names() const {
        const std::size_t more = layout.files.size() - 1;
        return more ? fmt::format("{} and {} more", name(), more) : name();
    }
};

void check_spacing(const Placement& p, const std::string& path) {
    for (const double step : p.step)
        if (!(step * p.unit_m >= min_spacing_m && step * p.unit_m <= max_spacing_m))
            throw Failure(1, fmt::format("{}: its samples are {} m apart; give --spacing M in {}..{:.0f}", path,
                                         step * p.unit_m, min_spacing_m, max_spacing_m));
}

// Samples inside the box, both ends included, along one axis on which sample i stands at from + i * step. What is off
// by rounding alone is inside.
std::pair<std::int32_t, std::int32_t> inside(double low, double high, double from, double step, std::int32_t count) {
    constexpr double slack = 1e-6;
    double first = (low - from) / step, last = (high - from) / step;
    if (step < 0) std::swap(first, last);
    first = std::max(0.0, std::ceil(first - slack));
    last = std::min(count - 1.0, std::floor(last + slack));
    return first <= last ? std::pair{static_cast<std::int32_t>(first), static_cast<std::int32_t>(last)}
                         : std::pair{0, -1};
}

Window crop_to(const ReadPlan& plan) {
    const Placement& p = plan.target;
    const Window all{0, 0, p.columns, p.rows};
    if (!plan.options.bbox) return all;
    auto [west, south, east, north] = *plan.options.bbox;
    if (p.axes == Axes::degrees) { // longitudes count from anywhere
        const double turn = turn_of(source_crs(p)).length;
        const double off = turn * std::round((p.east((p.columns - 1) / 2.0) - (west + east) / 2) / turn);
        west += off, east += off;
        const bool whole = (p.columns + 0.5) * p.step[0] > turn;
        if (whole && east - west < turn && (west < p.east(-1) || east > p.east(p.columns)))
            throw Failure(1, fmt::format("{}: --bbox goes across {}, where the field begins and ends, which a square "
                                         "grid in degrees cannot; leave out --spacing{} to reproject it, or bake its "
                                         "two sides one by one",
                                         plan.names(), p.east(-0.5),
                                         plan.options.crs == "auto" ? "" : " and --crs " + plan.options.crs));
    }
    const bool counted = p.axes == Axes::none; // columns and rows from the north-west
    if (!(west < east) || !(counted ? north < south : south < north))
        throw Failure(2, fmt::format("--bbox {},{},{},{}: give WEST,SOUTH,EAST,NORTH with WEST less than EAST and {}",
                                     west, south, east, north,
                                     counted ? "NORTH less than SOUTH (rows from the north; there is no georeference)"
                                             : "SOUTH less than NORTH"));
    const auto [left, right] = inside(west, east, counted ? 0 : p.origin[0], p.step[0], p.columns);
    const auto [top, bottom] =
        counted ? inside(north, south, 0, 1, p.rows) : inside(south, north, p.origin[1], -p.step[1], p.rows);
    if (right < left || bottom < top) {
        const std::string spans =
            counted ? fmt::format("0,{},{},0", p.rows - 1, p.columns - 1)
                    : fmt::format("{},{},{},{}", p.origin[0], p.north(p.rows - 1), p.east(p.columns - 1), p.origin[1]);
        throw Failure(1, fmt::format("{}: --bbox {},{},{},{} lies outside of it; it spans {}", plan.names(), west,
                                     south, east, north, spans));
    }
    if (right == left || bottom == top)
        throw Failure(1, fmt::format("{}: fewer than 2 x 2 samples lie in --bbox {},{},{},{}; give a larger one",
                                     plan.names(), west, south, east, north));
    return {left, top, right - left + 1, bottom - top + 1};
}

// In degrees a box may go across the antimeridian, from 179 to -179.
void set_order(ReadOptions& o, Axes axes) {
    if (o.bbox && axes == Axes::degrees && (*o.bbox)[0] <= 360 && (*o.bbox)[2] >= -360)
        while ((*o.bbox)[0] >= (*o.bbox)[2]) (*o.bbox)[2] += 360;
    if (o.bbox && !((*o.bbox)[0] < (*o.bbox)[2]))
        throw Failure(2, fmt::format("--bbox: WEST {} is not less than EAST {}; give WEST,SOUTH,EAST,NORTH",
                                     (*o.bbox)[0], (*o.bbox)[2]));
}

std::shared_ptr<const ReadPlan> make_plan(const std::vector<std::string>& paths, const ReadOptions& options) {
    check_options(paths, options);
    auto plan = std::make_shared<ReadPlan>();
    plan->options = options;
    plan->layout = lay_out(paths, options);
    plan->target = plan->layout.at;
    set_order(plan->options, plan->layout.at.axes);
    const GdalMessages quiet;
    const ReprojectionTarget target = choose_target(plan->layout.at, plan->options, plan->names());
    if (target.crs) {
        PlacedDataset from(plan->layout.at, source_crs(plan->layout.at), [](const Window&, float*) {});
        plan->warped = true;
        plan->target = target_grid(from, target, plan->options, plan->names());
        plan->crop = {0, 0, plan->target.columns, plan->target.rows};
        Transformer transformer(from, plan->target.crs_wkt, plan->names());
        transformer.set_target(plan->target);
        plan->ratio = resampling_ratio(transformer, plan->layout.at, plan->target);
        double samples = 0;
        for (const MosaicFile& f : plan->layout.files)
            samples += static_cast<double>(f.facts.at.columns) * f.facts.at.rows;
        constexpr double most = 100; // of what the files hold: hours of work and disks of room for next to nothing
        const double made = static_cast<double>(plan->target.columns) * plan->target.rows;
        if (made > most * std::max(samples, 1e6 / most) && !options.spacing_m)
            throw Failure(1,
                          fmt::format("{}: its {:.3g} samples would become {} x {}, a hundred times as many, because "
                                      "they lie far apart; give --bbox for a part, or --spacing {:.6g} if that is "
                                      "what you want",
                                      plan->names(), samples, plan->target.columns, plan->target.rows,
                                      plan->target.step[0] * plan->target.unit_m));
    } else {
        if (!options.spacing_m) check_spacing(plan->target, plan->name());
        plan->crop = crop_to(*plan);
    }
    return plan;
}

class PlainReader final : public HeightReader {
public:
    explicit PlainReader(std::shared_ptr<const ReadPlan> plan)
        : plan_(std::move(plan)), mosaic_(plan_->layout, plan_->options) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        ReadStatistics own;
        own.per_unit = statistics.per_unit;
        const Window& crop = plan_->crop;
        mosaic_.read({window.x + crop.x, window.y + crop.y, window.columns, window.rows}, to, own);
        for (Tally* t : {&own.voids, &own.implausible}) t->column -= crop.x, t->row -= crop.y;
        own.ends.move(-crop.x, -crop.y);
        statistics.add(own);
    }
    bool covers(const Window& window) override {
        const Window& crop = plan_->crop;
        return mosaic_.covers({window.x + crop.x, window.y + crop.y, window.columns, window.rows});
    }

private:
    std::shared_ptr<const ReadPlan> plan_;
    Mosaic mosaic_;
};

class WarpedReader final : public HeightReader {
public:
    explicit WarpedReader(std::shared_ptr<const ReadPlan> plan)
        : plan_(std::move(plan)), warp_(plan_->layout, plan_->target, plan_->options) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        warp_.read(window, to);
        statistics.ends.add(warp_.take_ends());
        statistics.per_unit = 1000; // interpolated heights have no step
        const auto columns = static_cast<std::size_t>(window.columns);
        for (std::size_t i = 0; i < window.area(); ++i) {
            if (std::isnan(to[i])) {
                statistics.voids.add(window.x + static_cast<std::int32_t>(i % columns),
                                     window.y + static_cast<std::int32_t>(i / columns));
                continue;
            }
            statistics.least_m = std::min(statistics.least_m, to[i]);
            statistics.most_m = std::max(statistics.most_m, to[i]);
        }
    }

private:
    std::shared_ptr<const ReadPlan> plan_;
    Warp warp_;
};

SourceFacts facts_of(const ReadPlan& plan) {
    SourceFacts f;
    const FileFacts& first = plan.layout.files.front().facts;
    f.band = first.band;
    f.driver = first.driver;
    f.type = first.type;
    f.voids = first.voids;
    f.height_unit = first.height_unit;
    f.height_unit_m = first.decoding.scaling.file_scale * first.decoding.scaling.zscale;
    const Placement& at = plan.target;
    const Window& crop = plan.crop;
    if (const OGRSpatialReference crs = source_crs(at); at.axes == Axes::metres && crs.IsProjected()) {
        const GdalMessages quiet;
        const CrsBox box{at.east(crop.x), at.north(crop.y + crop.rows - 1), at.east(crop.x + crop.columns - 1),
                         at.north(crop.y)};
        if (const auto scale = ground_scale(crs, box.nine_places())) {
            f.ground_scale[0] = scale->least;
            f.ground_scale[1] = scale->most;
        }
    }
    if (!plan.warped) return f;
    const Placement& from = plan.layout.at;
    const bool metres = from.axes == Axes::metres;
    const OGRSpatialReference own = source_crs(from);
    f.reprojected_from = crs_text(crs_label(wkt_of(own)));
    f.from_unit = metres ? "m" : angle_name(own);
    f.resampled = plan.ratio < 1 ? fmt::format("cubic over {:.2g} samples", 1 / plan.ratio) : "cubic";
    if (metres && !points_east_and_north(own)) f.axes = axes_text(own);
    for (const int axis : {0, 1}) f.from_step[axis] = from.step[axis] * (metres ? from.unit_m : 1);
    return f;
}

class FileSource final : public HeightSource {
public:
    explicit FileSource(std::shared_ptr<const ReadPlan> plan) : plan_(std::move(plan)) {
        const Placement& p = plan_->target;
        const ReadOptions& o = plan_->options;
        columns = plan_->crop.columns;
        rows = plan_->crop.rows;
        for (const int axis : {0, 1}) spacing_m[axis] = o.spacing_m ? *o.spacing_m : p.step[axis] * p.unit_m;
        facts = facts_of(*plan_);
        if (p.axes == Axes::none) return;
        std::copy_n(p.step, 2, crs_step);
        crs_origin[0] = p.east(plan_->crop.x);
        crs_origin[1] = p.north(plan_->crop.y);
        crs_wkt = p.crs_wkt;
    }
    std::unique_ptr<HeightReader> reader() const override {
        if (plan_->warped) return std::make_unique<WarpedReader>(plan_);
        return std::make_unique<PlainReader>(plan_);
    }
    int readers(int threads) const override {
        const auto sequential = [](const MosaicFile& f) { return f.facts.sequential; };
        const auto& files = plan_->layout.files;
        // Readers of a mosaic work in different files most of the time.
        return files.size() == 1 && std::any_of(files.begin(), files.end(), sequential) ? 1 : threads;
    }
    std::vector<Window> windows(std::size_t most) const override;
    SourceProperties properties(const ReadStatistics& statistics) const override;
    std::string identity() const override;
    [[nodiscard]] const ReadPlan& plan() const { return *plan_; }

private:
    [[nodiscard]] VoidCheck void_check() const;
    [[nodiscard]] VoidFindings count_again() const;
    [[nodiscard]] bool same_scale() const;
    std::shared_ptr<const ReadPlan> plan_;
};

std::vector<Window> FileSource::windows(std::size_t most) const {
    const Window& crop = plan_->crop;
    if (plan_->warped) return cut_along(crop, Blocks{warp_block, warp_block, 0, 0}, most);
    std::vector<Window> windows = cut_along(plan_->layout, crop, most);
    for (Window& w : windows) w.x -= crop.x, w.y -= crop.y;
    // A format that is decoded from its start begins where the file does.
    const FileFacts& first = plan_->layout.files.front().facts;
    if (plan_->layout.files.size() == 1 && first.at.flip_y) std::reverse(windows.begin(), windows.end());
    return windows;
}

VoidCheck FileSource::void_check() const {
    const ReadOptions& o = plan_->options;
    return {plan_->names(),     o.nodata,      o.voids.no_others,
            plan_->crop.area(), plan_->warped, plan_->layout.files.front().facts.decoding.scaling};
}

bool FileSource::same_scale() const {
    const Scaling& first = plan_->layout.files.front().facts.decoding.scaling;
    return std::all_of(plan_->layout.files.begin(), plan_->layout.files.end(),
                       [&](const MosaicFile& f) { return f.facts.decoding.scaling == first; });
}

// Where blocks were fetched to be reprojected, samples were counted twice; a refusal should name the number that a user
// finds.
VoidFindings FileSource::count_again() const {
    Mosaic mosaic(plan_->layout, plan_->options);
    ReadStatistics all;
    std::vector<float> unused;
    constexpr std::size_t at_once = std::size_t{1} << 20;
    const Placement& at = plan_->layout.at;
    for (const Window& w : cut_along(plan_->layout, {0, 0, at.columns, at.rows}, at_once)) {
        unused.resize(w.area());
        mosaic.read(w, unused.data(), all);
    }
    return find_voids(all.ends, same_scale());
}

SourceProperties FileSource::properties(const ReadStatistics& statistics) const {
    const VoidCheck check = void_check();
    refuse_voids(statistics, check);
    SourceProperties s;
    s.holes = statistics.voids.count + statistics.implausible.count > 0 && plan_->options.nodata != NoData::fill;
    if (!check.no_others) {
        VoidFindings found = find_voids(statistics.ends, same_scale());
        if (plan_->warped && !found.voids.empty()) found = count_again();
        tell_voids(found, check, s);
    }
    const FileFacts& first = plan_->layout.files.front().facts;
    const Scaling& scaling = first.decoding.scaling;
    s.anchor_m = scaling.asked_m(scaling.file_offset_m);
    const bool alike = same_scale() && std::all_of(plan_->layout.files.begin(), plan_->layout.files.end(),
                                                   [&](const MosaicFile& f) { return f.facts.step == first.step; });
    if (alike && statistics.per_unit <= 100 && !plan_->warped)
        s.native_quantum_m = first.step / statistics.per_unit * std::abs(scaling.file_scale * scaling.zscale);
    return s;
}

std::string FileSource::identity() const {
    const ReadOptions& o = plan_->options;
    std::string text =
        fmt::format("crs {} spacing {} encoding {} zscale {} zoffset {} nodata {} bbox", o.crs, o.spacing_m.value_or(0),
                    static_cast<int>(o.encoding), o.zscale.value_or(1), o.zoffset_m, static_cast<int>(o.nodata));
    if (o.bbox)
        for (const double edge : *o.bbox) text += fmt::format(" {}", edge);
    text += fmt::format(" void {}{}", fmt::join(o.voids.numbers, " "), o.voids.no_others ? " none" : "");
    if (!o.vertical_unit.empty()) text += " vertical-unit " + o.vertical_unit;
    for (const MosaicFile& f : plan_->layout.files) text += "\n" + f.facts.identity;
    return text;
}

} // namespace

std::unique_ptr<HeightSource> open_source(const std::vector<std::string>& paths, const ReadOptions& options) {
    return std::make_unique<FileSource>(make_plan(paths, options));
}

std::optional<Unwarped> unwarped(const HeightSource& source) {
    const auto* const files = dynamic_cast<const FileSource*>(&source);
    if (files == nullptr || !files->plan().warped) return {};
    auto own = std::make_shared<ReadPlan>(files->plan());
    own->warped = false;
    own->target = own->layout.at;
    own->crop = {0, 0, own->target.columns, own->target.rows};
    struct Way {
        PlacedDataset from;
        Transformer transformer;
        Way(const Placement& at, const Placement& to, const std::string& path)
            : from(at, source_crs(at), [](const Window&, float*) {}), transformer(from, to.crs_wkt, path) {
            transformer.set_target(to);
        }
    };
    const auto way = std::make_shared<Way>(own->layout.at, files->plan().target, own->names());
    return Unwarped{std::make_unique<FileSource>(own), [way](double& column, double& row) {
                        column += 0.5, row += 0.5; // GDAL counts from a pixel's corner
                        const bool there = way->transformer.to_source(column, row);
                        column -= 0.5, row -= 0.5;
                        return there;
                    }};
}

} // namespace fjell::baker
