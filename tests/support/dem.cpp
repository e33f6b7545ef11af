#include "support/dem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <xxhash.h>

#include "baker/heights/fill.h"
#include "baker/read/gdal_file.h"
#include "baker/read/windows.h"
#include "baker/store/parallel.h"
#include "baker/synth/synth.h"
#include "baker/synth/write_dem.h"

namespace fjell::baker {

namespace {

class DemReader final : public HeightReader {
public:
    explicit DemReader(const Dem& dem) : dem_(dem) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        statistics.per_unit = 1; // the quantum is the Dem's own
        for (std::int32_t y = window.y; y < window.y + window.rows; ++y)
            for (std::int32_t x = window.x; x < window.x + window.columns; ++x, ++to) {
                *to = dem_.at(x, y);
                if (dem_.is_void(x, y) || std::isnan(*to)) {
                    *to = std::numeric_limits<float>::quiet_NaN();
                    statistics.voids.add(x, y);
                    continue;
                }
                statistics.least_m = std::min(statistics.least_m, *to);
                statistics.most_m = std::max(statistics.most_m, *to);
            }
    }

private:
    const Dem& dem_;
};

std::uint64_t hash(const void* bytes, std::size_t size) {
    return XXH3_64bits(bytes, size);
}

} // namespace

DemSource::DemSource(Dem dem) : dem_(std::move(dem)) {
    facts.height_unit += 'm';
    columns = dem_.columns;
    rows = dem_.rows;
    std::copy_n(dem_.spacing_m, 2, spacing_m);
    std::copy_n(dem_.crs_origin, 2, crs_origin);
    crs_wkt = dem_.crs_wkt;
    std::copy_n(dem_.crs_step, 2, crs_step);
    if (!(crs_step[0] > 0 && crs_step[1] > 0)) crs_step_of(spacing_m, crs_wkt, crs_step);
}

std::unique_ptr<HeightReader> DemSource::reader() const {
    return std::make_unique<DemReader>(dem_);
}

std::vector<Window> DemSource::windows(std::size_t most) const {
    return cut_along({0, 0, columns, rows}, {columns, 1, 0, 0}, most);
}

SourceProperties DemSource::properties(const ReadStatistics& statistics) const {
    if (!(statistics.least_m <= statistics.most_m))
        throw Failure(1, fmt::format("all {} x {} samples are holes; give a height field with heights", columns, rows));
    // Every multiple of the step is on a height scale that starts anywhere on it.
    return {dem_.native_quantum_m, dem_.native_quantum_m > 0 ? static_cast<double>(statistics.least_m) : 0,
            statistics.voids.count > 0};
}

std::string DemSource::identity() const {
    return fmt::format("{} x {} in memory, {} {} ({} {}) at {} {} step {} heights {:016x} voids {:016x} crs {:016x}",
                       columns, rows, spacing_m[0], spacing_m[1], crs_step[0], crs_step[1], crs_origin[0],
                       crs_origin[1], dem_.native_quantum_m,
                       hash(dem_.heights_m.data(), dem_.heights_m.size() * sizeof(float)),
                       hash(dem_.voids.data(), dem_.voids.size()), hash(crs_wkt.data(), crs_wkt.size()));
}

namespace {

ReadStatistics read_all(const HeightSource& source, Dem& dem) {
    constexpr std::size_t at_once = std::size_t{1} << 21; // samples
    dem.heights_m.resize(static_cast<std::size_t>(dem.columns) * static_cast<std::size_t>(dem.rows));
    const auto reader = source.reader();
    std::vector<float> part;
    ReadStatistics statistics;
    for (const Window& w : source.windows(at_once)) {
        io::check_interrupt();
        if (w.columns == dem.columns) {
            reader->read(w, dem.heights_m.data() + dem.index(0, w.y), statistics);
            continue;
        }
        part.resize(w.area());
        reader->read(w, part.data(), statistics);
        for (std::int32_t row = 0; row < w.rows; ++row)
            std::copy_n(part.begin() + std::ptrdiff_t{row} * w.columns, w.columns,
                        dem.heights_m.begin() + static_cast<std::ptrdiff_t>(dem.index(w.x, w.y + row)));
    }
    return statistics;
}

void fill(Dem& dem, const SourceProperties& properties) {
    if (properties.holes) {
        dem.voids.resize(dem.heights_m.size());
        std::transform(dem.heights_m.begin(), dem.heights_m.end(), dem.voids.begin(),
                       [](float height) { return static_cast<std::uint8_t>(std::isnan(height)); });
    }
    const Window all{0, 0, dem.columns, dem.rows};
    Store<float> raw({}, dem.columns, dem.rows), out({}, dem.columns, dem.rows);
    raw.write(all, dem.heights_m.data(), dem.columns);
    const auto make = [](const std::string&, std::int64_t w, std::int64_t h) { return Store<float>({}, w, h); };
    fill_voids({raw, {properties.native_quantum_m, properties.anchor_m}, 1, make}, out);
    out.read(all, dem.heights_m.data(), dem.columns);
}

} // namespace

Dem read_dem(const HeightSource& source) {
    Dem dem;
    dem.columns = source.columns;
    dem.rows = source.rows;
    std::copy_n(source.spacing_m, 2, dem.spacing_m);
    std::copy_n(source.crs_origin, 2, dem.crs_origin);
    std::copy_n(source.crs_step, 2, dem.crs_step);
    dem.crs_wkt = source.crs_wkt;
    const ReadStatistics statistics = read_all(source, dem);
    const SourceProperties properties = source.properties(statistics);
    dem.native_quantum_m = properties.native_quantum_m;
    if (statistics.voids.count + statistics.implausible.count > 0) fill(dem, properties);
    return dem;
}

Dem read_dem(const std::vector<std::string>& paths, const ReadOptions& options) {
    return read_dem(*open_source(paths, options));
}

Dem read_dem(const std::string& path, const ReadOptions& options) {
    return read_dem(std::vector<std::string>{path}, options);
}

namespace {

Dem dem_of_land(const HeightSource& source, int threads) {
    Dem dem;
    dem.columns = source.columns;
    dem.rows = source.rows;
    std::copy_n(source.spacing_m, 2, dem.spacing_m);
    dem.native_quantum_m = source.properties({}).native_quantum_m;
    dem.heights_m.resize(static_cast<std::size_t>(dem.columns) * static_cast<std::size_t>(dem.rows));
    parallel_for(dem.rows, resolve_threads(threads), [&](std::int64_t row) {
        const auto y = static_cast<std::int32_t>(row);
        ReadStatistics unused;
        source.reader()->read({0, y, dem.columns, 1}, dem.heights_m.data() + dem.index(0, y), unused);
    });
    return dem;
}

} // namespace

Dem synthesise_text(const std::string& recipe_json, int threads) {
    return dem_of_land(*synth_source(recipe_json), threads);
}

Dem synthesise(const std::string& recipe_path, int threads) {
    return dem_of_land(*open_synth(recipe_path), threads);
}

BakeSummary bake(Dem dem, const BakeOptions& options, const std::string& out_path) {
    return bake(DemSource(std::move(dem)), options, out_path);
}

VerifyReport verify(const Terrain& terrain, const Dem* against, const Pack* bounds) {
    if (!against) return verify(terrain, nullptr, bounds);
    const DemSource source(*against);
    return verify(terrain, &source, bounds);
}

void write_dem(const Dem& dem, const std::string& path) {
    Dem ground = dem;
    ground.voids.clear();
    write_dem(DemSource(std::move(ground)), path, DemForm::compact);
}

} // namespace fjell::baker
