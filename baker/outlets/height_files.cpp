#include "baker/outlets/height_files.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <mutex>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/outlets/encode_image.h"
#include "baker/outlets/read_ground.h"
#include "baker/store/parallel.h"
#include "baker/synth/write_dem.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

namespace fs = std::filesystem;

enum class HeightFormat : std::uint8_t { raw, png, exr, tif };

HeightFormat height_format_of(const std::string& path) {
    std::string ending = fs::path(path).extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (ending == ".raw" || ending == ".r16") return HeightFormat::raw;
    if (ending == ".png") return HeightFormat::png;
    if (ending == ".exr") return HeightFormat::exr;
    if (ending == ".tif" || ending == ".tiff") return HeightFormat::tif;
    throw Failure(
        2, fmt::format("{}: heights are written as .tif, .raw, .r16, .png or .exr; give a name that ends so", path));
}

// Every step-th sample; beyond the rim its last ones.
struct StepGrid {
    const Ground& ground;
    std::int32_t step, columns, rows;
    StepGrid(const Ground& of, int level)
        : ground(of), step(1 << level), columns((of.columns - 2) / step + 2), rows((of.rows - 2) / step + 2) {}
    [[nodiscard]] float at(std::int64_t x, std::int64_t y) const {
        return ground.row(
            std::min<std::int64_t>(y * step, ground.rows - 1))[std::min<std::int64_t>(x * step, ground.columns - 1)];
    }
};

struct Numbers16 {
    double scale_m, offset_m;
    [[nodiscard]] std::uint16_t number(float height) const {
        return static_cast<std::uint16_t>(
            std::clamp<long>(std::lround((static_cast<double>(height) - offset_m) / scale_m), 0, 65535));
    }
    [[nodiscard]] double height_m(float height) const { return offset_m + scale_m * number(height); }
};

// The source's own step where 16 bits count it; else the finest that they count.
Numbers16 numbers_of(const Ground& ground) {
    constexpr double most = 65535;
    const double least = static_cast<double>(ground.min_m), range = static_cast<double>(ground.max_m) - least;
    const double q = ground.quantum_m;
    if (q > 0) {
        const double base = ground.anchor_m + std::floor((least - ground.anchor_m) / q) * q;
        if (static_cast<double>(ground.max_m) - base <= q * most) return {q, base};
    }
    return {range > 0 ? range / most : 1, least};
}

// height(x, y): of the grid, as its file says it.
template <typename Height>
double step_error_m(const StepGrid& grid, int threads, const Height& height) {
    const Ground& g = grid.ground;
    const std::int32_t s = grid.step;
    std::mutex lock;
    double worst = 0;
    parallel_for(grid.rows - 1, threads, [&](std::int64_t row) {
        double off = 0;
        for (std::int64_t column = 0; column + 1 < grid.columns; ++column) {
            const double nw = height(column, row), ne = height(column + 1, row), sw = height(column, row + 1),
                         se = height(column + 1, row + 1);
            const double east = ne - nw, south = sw - nw, bend = se + nw - ne - sw;
            const std::int64_t x0 = column * s, y0 = row * s, x1 = std::min<std::int64_t>(x0 + s, g.columns - 1),
                               y1 = std::min<std::int64_t>(y0 + s, g.rows - 1);
            for (std::int64_t y = y0; y <= y1; ++y)
                for (std::int64_t x = x0; x <= x1; ++x) {
                    const double u = static_cast<double>(x - x0) / s, v = static_cast<double>(y - y0) / s;
                    const double plane = nw + u * east + v * south - static_cast<double>(g.row(y)[x]);
                    // What the cell's bend adds: the most from north-west to south-east, the least the other way.
                    off = std::max({off, std::abs(plane + bend * std::min(u, v)),
                                    std::abs(plane + bend * std::max(0.0, u + v - 1))});
                }
        }
        const std::lock_guard hold(lock);
        worst = std::max(worst, off);
    });
    return worst;
}

template <typename T>
std::vector<T> window_of(const StepGrid& grid, std::int64_t x0, std::int64_t y0, std::int32_t columns,
                         std::int32_t rows, const auto& number) {
    std::vector<T> numbers;
    numbers.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (std::int64_t y = y0; y < y0 + rows; ++y)
        for (std::int64_t x = x0; x < x0 + columns; ++x)
            numbers.push_back(
                number(grid.at(std::min<std::int64_t>(x, grid.columns - 1), std::min<std::int64_t>(y, grid.rows - 1))));
    return numbers;
}

void write_tif(const HeightSource& source, const HeightFilesSummary& s, std::int64_t x0, std::int64_t y0,
               const std::vector<float>& heights, const std::string& path, int threads) {
    const HeightArray array{
        reinterpret_cast<const std::byte*>(heights.data()),    NumberType::float32, s.columns, s.rows, sizeof(float),
        static_cast<std::ptrdiff_t>(sizeof(float)) * s.columns};
    ReadOptions as_it_is;
    as_it_is.nodata = NoData::hole;
    as_it_is.voids.no_others = true;
    const auto part = array_source(array, {}, as_it_is);
    std::copy_n(s.spacing_m, 2, part->spacing_m);
    part->crs_wkt = source.crs_wkt;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        part->crs_step[axis] = source.crs_step[axis] * s.spacing_m[axis] / source.spacing_m[axis];
        const double step = part->crs_step[axis] > 0 ? part->crs_step[axis] : s.spacing_m[axis];
        part->crs_origin[axis] =
            source.crs_origin[axis] + (axis == 0 ? step * static_cast<double>(x0) : -step * static_cast<double>(y0));
    }
    write_dem(*part, path, DemForm::plain, threads);
}

std::string sidecar_of(const HeightSource& source, const HeightFilesOptions& options, const HeightFilesSummary& s) {
    nlohmann::ordered_json j{{"files", s.files},
                             {"columns", s.columns},
                             {"rows", s.rows},
                             {"tiles", {s.tiles_x, s.tiles_y}},
                             {"spacing_m", {s.spacing_m[0], s.spacing_m[1]}},
                             {"level", options.level},
                             {"error_m", s.error_m},
                             {"holes_filled", s.holes_filled},
                             {"crs_origin", {source.crs_origin[0], source.crs_origin[1]}}};
    if (s.sixteen_bits) {
        constexpr double middle = 32768, most = 65535, cm = 100, unreal_steps = 128; // of a metre at a scale of 100
        j["scale_m"] = s.scale_m;
        j["offset_m"] = s.offset_m;
        j["unreal"] = {{"scale", {s.spacing_m[0] * cm, s.spacing_m[1] * cm, s.scale_m * unreal_steps * cm}},
                       {"location_z_cm", (s.offset_m + middle * s.scale_m) * cm}};
        j["unity"] = {{"terrain_height_m", s.scale_m * most}, {"position_y_m", s.offset_m}};
    }
    return j.dump(2) + "\n";
}

void write_with_gdal(const std::string& path, const char* driver, const ImageNumbers& image) {
    io::AtomicFile out(path);
    out.write(encode_image(driver, image, {}, path));
    out.commit();
}

} // namespace

void write_image(const std::string& path, const char* driver, std::int32_t columns, std::int32_t rows,
                 std::span<const std::uint16_t> numbers) {
    write_with_gdal(path, driver, {columns, rows, GDT_UInt16, numbers.data()});
}
void write_image(const std::string& path, const char* driver, std::int32_t columns, std::int32_t rows,
                 std::span<const float> numbers) {
    write_with_gdal(path, driver, {columns, rows, GDT_Float32, numbers.data()});
}

HeightFilesSummary write_height_files(const HeightSource& source, const HeightFilesOptions& options,
                                      const std::string& path) {
    const HeightFormat format = height_format_of(path);
    const int threads = resolve_threads(options.threads);
    HeightFilesSummary s;
    s.sixteen_bits = format == HeightFormat::raw || format == HeightFormat::png;
    const fs::path whole(path);
    const std::string stem = (whole.parent_path() / whole.stem()).string(), ending = whole.extension().string();
    (void)io::AtomicFile(stem + ".json"); // a folder that cannot be written should not cost the work
    const Ground ground = read_ground(source, format == HeightFormat::tif ? GroundHoles::as_source : GroundHoles::fill,
                                      threads, options.progress);
    if (options.level > 0 && (std::min(ground.columns, ground.rows) - 1) >> options.level == 0)
        throw Failure(2, fmt::format("--at {}: {} x {} samples have no step of {}; give less", options.level,
                                     ground.columns, ground.rows, std::int64_t{1} << options.level));
    const StepGrid grid(ground, options.level);
    const bool tiled = options.tile_side > 0;
    s.columns = tiled ? options.tile_side : grid.columns, s.rows = tiled ? options.tile_side : grid.rows;
    s.tiles_x = tiled ? (grid.columns - 2) / (options.tile_side - 1) + 1 : 1;
    s.tiles_y = tiled ? (grid.rows - 2) / (options.tile_side - 1) + 1 : 1;
    for (std::size_t axis = 0; axis < 2; ++axis) s.spacing_m[axis] = ground.spacing_m[axis] * grid.step;
    s.holes_filled = format == HeightFormat::tif ? 0 : ground.holes;
    const Numbers16 as16 = numbers_of(ground);
    if (s.sixteen_bits) s.scale_m = as16.scale_m, s.offset_m = as16.offset_m;
    s.error_m = step_error_m(grid, threads, [&](std::int64_t x, std::int64_t y) {
        return s.sixteen_bits ? as16.height_m(grid.at(x, y)) : static_cast<double>(grid.at(x, y));
    });
    for (std::int32_t j = 0; j < s.tiles_y; ++j)
        for (std::int32_t i = 0; i < s.tiles_x; ++i) {
            io::check_interrupt();
            const std::string file = tiled ? fmt::format("{}_x{}_y{}{}", stem, i, j, ending) : path;
            const std::int64_t x0 = std::int64_t{i} * (s.columns - 1), y0 = std::int64_t{j} * (s.rows - 1);
            if (s.sixteen_bits) {
                const auto numbers = window_of<std::uint16_t>(grid, x0, y0, s.columns, s.rows,
                                                              [&](float height) { return as16.number(height); });
                if (format == HeightFormat::raw) {
                    io::AtomicFile out(file);
                    out.write(std::as_bytes(std::span(numbers)));
                    out.commit();
                } else {
                    write_image(file, "PNG", s.columns, s.rows, numbers);
                }
            } else {
                const auto heights =
                    window_of<float>(grid, x0, y0, s.columns, s.rows, [](float height) { return height; });
                if (format == HeightFormat::exr)
                    write_image(file, "EXR", s.columns, s.rows, heights);
                else
                    write_tif(source, s, x0, y0, heights, file, threads);
            }
            s.files.push_back(fs::path(file).filename().string());
            if (options.progress)
                options.progress("write", s.files.size(),
                                 static_cast<std::uint64_t>(s.tiles_x) * static_cast<std::uint64_t>(s.tiles_y));
        }
    const std::string text = sidecar_of(source, options, s);
    io::AtomicFile sidecar(stem + ".json");
    sidecar.write(std::as_bytes(std::span(text)));
    sidecar.commit();
    s.files.push_back(fs::path(stem + ".json").filename().string());
    return s;
}

} // namespace fjell::baker
