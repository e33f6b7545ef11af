// Stages that make errors, radii and pages: the finest step with the heights at hand, then step by step to the roots.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "baker/bake/pipeline.h"
#include "baker/pack/page_pack.h"

namespace fjell::baker {

namespace {

// Rows and columns of a patch that lie beyond what was read take the nearest that was.
template <typename T>
void replicate(Patch<T>& patch, const Window& known) {
    const std::int32_t left = known.x - patch.x, right = left + known.columns, top = known.y - patch.y,
                       bottom = top + known.rows;
    for (std::int32_t y = top; y < bottom; ++y) {
        T* const row = patch.values.data() + std::ptrdiff_t{y} * patch.columns;
        std::fill(row, row + left, row[left]);
        std::fill(row + right, row + patch.columns, row[right - 1]);
    }
    const auto copy = [&](std::int32_t from, std::int32_t to) {
        std::memcpy(patch.values.data() + std::ptrdiff_t{to} * patch.columns,
                    patch.values.data() + std::ptrdiff_t{from} * patch.columns,
                    static_cast<std::size_t>(patch.columns) * sizeof(T));
    };
    for (std::int32_t y = 0; y < top; ++y) copy(top, y);
    for (std::int32_t y = bottom; y < patch.rows; ++y) copy(bottom - 1, y);
}

// The part of a patch that lies within columns x rows.
template <typename T>
Window within(const Patch<T>& patch, std::int64_t columns, std::int64_t rows) {
    const std::int32_t x = std::max(patch.x, 0), y = std::max(patch.y, 0);
    const auto end_x = static_cast<std::int32_t>(std::min<std::int64_t>(patch.x + patch.columns, columns));
    const auto end_y = static_cast<std::int32_t>(std::min<std::int64_t>(patch.y + patch.rows, rows));
    return {x, y, end_x - x, end_y - y};
}

template <typename T>
void load(const Store<T>& store, Patch<T>& patch) {
    const Window known = within(patch, store.columns(), store.rows());
    store.read(known, patch.at(known.x, known.y), patch.columns);
    replicate(patch, known);
}

// The places that level.h wants of a region at step 2^z, in units of that step.
template <typename T>
Patch<T> patch_for(const Region& region, int z) {
    const std::int32_t nx = (region.last.x - region.first.x) >> (z + 1),
                       ny = (region.last.y - region.first.y) >> (z + 1);
    return {(region.first.x >> z) - 2, (region.first.y >> z) - 2, 2 * (nx + reach + 2), 2 * (ny + reach + 2)};
}

} // namespace

Ground Pipeline::ground_of(const Region& region) const {
    Ground ground{tree_, patch_for<std::int32_t>(region, 0), {}};
    Patch<std::int32_t>& steps = ground.steps;
    const Window known = within(steps, tree_.columns(), tree_.rows());
    Buffer<float> heights_m(known.area());
    heights().read(known, heights_m.data(), known.columns);
    for (std::int32_t y = 0; y < known.rows; ++y)
        quantise(heights_m.data() + std::ptrdiff_t{y} * known.columns, static_cast<std::size_t>(known.columns),
                 height_scale_, steps.at(known.x, known.y + y));
    replicate(steps, known);
    if (!voids_.exists()) return ground;
    Patch<std::uint8_t> voids = patch_for<std::uint8_t>(region, 0);
    load(voids_, voids);
    if (std::count(voids.values.begin(), voids.values.end(), std::uint8_t{1}) != 0) ground.voids = std::move(voids);
    return ground;
}

void Pipeline::load_level(const Region& region, int z, Planes<std::int32_t>& steps, Planes<std::uint8_t>& voids) const {
    Patch<std::uint32_t> stored = patch_for<std::uint32_t>(region, z);
    load(level_[z & 1], stored);
    Patch<std::int32_t> values = patch_for<std::int32_t>(region, z);
    std::transform(stored.values.begin(), stored.values.end(), values.values.begin(),
                   [](std::uint32_t v) { return static_cast<std::int32_t>(v & ~void_flag); });
    take_apart(values, steps);
    if (ledger_.state.holes == 0) return;
    Patch<std::uint8_t> flags = patch_for<std::uint8_t>(region, z);
    std::transform(stored.values.begin(), stored.values.end(), flags.values.begin(),
                   [](std::uint32_t v) { return static_cast<std::uint8_t>(v >> 31); });
    take_apart(flags, voids);
}

void Pipeline::load_finer(const Region& region, int z, FinerCentres& finer) const {
    const Store<CentreRecord>& store = centres_[(z - 1) & 1];
    Patch<CentreRecord> patch = patch_for<CentreRecord>(region, z);
    const Window known = within(patch, store.columns(), store.rows());
    load(store, patch);
    const float unit_m = scales_.level_radius_m[2 * (tree_.tile_log2 - z)];
    float radius_m[radius_codes];
    for (std::size_t code = 0; code < radius_codes; ++code) radius_m[code] = unit_m * scales_.radii.factor[code];
    for (std::size_t i = 0; i < patch.area(); ++i) {
        finer.steps[i] = patch.values[i].steps;
        finer.error[i] = patch.values[i].error;
        finer.radius_m[i] = radius_m[patch.values[i].radius];
    }
    // Where there are no centres they ask for nothing.
    for (std::int32_t y = 0; y < patch.rows; ++y)
        for (std::int32_t x = 0; x < patch.columns; ++x) {
            const bool inside = x + patch.x >= known.x && x + patch.x < known.x + known.columns &&
                                y + patch.y >= known.y && y + patch.y < known.y + known.rows;
            if (inside) {
                x = known.x + known.columns - patch.x - 1; // the rest of the row that is
                continue;
            }
            const std::size_t i = patch.index(x + patch.x, y + patch.y);
            finer.error[i] = 0;
            finer.radius_m[i] = 0;
        }
}

void Pipeline::store_own(std::int64_t region_index, const Region& region, const Patch<std::uint8_t>& own) {
    // The southern and eastern borders are the neighbours' rows; what was measured on this side lies apart.
    const bool last_x = region.last.x + 1 == tree_.grid_columns(), last_y = region.last.y + 1 == tree_.grid_rows();
    own_.write({own.x, own.y, own.columns - !last_x, own.rows - !last_y}, own.values.data(), own.columns);
    const auto across = static_cast<std::int32_t>(region_index % regions_.across()),
               down = static_cast<std::int32_t>(region_index / regions_.across());
    own_south_.write({own.x, down, own.columns, 1}, own.at(own.x, own.y + own.rows - 1), own.columns);
    std::vector<std::uint8_t> east;
    for (std::int32_t y = 0; y < own.rows; ++y) east.push_back(*own.at(own.x + own.columns - 1, own.y + y));
    own_east_.write({own.y, across, own.rows, 1}, east.data(), own.rows);
}

void Pipeline::load_own(const Region& region, std::int64_t region_index, int z, Planes<std::uint8_t>& error) const {
    const auto across = static_cast<std::int32_t>(region_index % regions_.across()),
               down = static_cast<std::int32_t>(region_index / regions_.across());
    const std::int32_t x0 = region.first.x / 2, y0 = region.first.y / 2,
                       columns = (region.last.x - region.first.x) / 2 + 1,
                       rows = (region.last.y - region.first.y) / 2 + 1;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(columns)), other(row.size());
    std::vector<std::uint8_t> west(static_cast<std::size_t>(rows), 0), east(west);
    if (across > 0) own_east_.read({y0, across - 1, rows, 1}, west.data(), rows);
    if (across + 1 < regions_.across()) own_east_.read({y0, across, rows, 1}, east.data(), rows);
    const std::int32_t step = 1 << (z - 1), n = (columns - 1) / (2 * step);
    for (std::int32_t y = 0; y < rows; y += step) {
        own_.read({x0, y0 + y, columns, 1}, row.data(), columns);
        const auto merge = [&](std::int32_t border) {
            own_south_.read({x0, border, columns, 1}, other.data(), columns);
            std::transform(row.begin(), row.end(), other.begin(), row.begin(),
                           [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
        };
        if (y == 0 && down > 0) merge(down - 1);
        if (y == rows - 1 && down + 1 < regions_.down()) merge(down);
        row.front() = std::max(row.front(), west[static_cast<std::size_t>(y)]);
        row.back() = std::max(row.back(), east[static_cast<std::size_t>(y)]);
        const std::int32_t j = y / (2 * step);
        const bool even = y / step % 2 == 0;
        std::uint8_t* const at_corner = (even ? error.corner : error.side_y).row(j);
        std::uint8_t* const between = (even ? error.side_x : error.centre).row(j);
        for (std::int32_t i = 0; i <= n; ++i) at_corner[i] = row[static_cast<std::size_t>(2 * i * step)];
        for (std::int32_t i = 0; i < n; ++i) between[i] = row[static_cast<std::size_t>((2 * i + 1) * step)];
    }
}

// Vertices of the finest step at the rim and beside holes, one by one.
void Pipeline::fix_leaves(const Ground& ground, const LevelInput& level) const {
    const Region& all = {{0, 0}, {tree_.grid_columns() - 1, tree_.grid_rows() - 1}};
    const OwnInput input{ground, all, scales_, *leaf_, options_.estimate, {source_.spacing_m[0], source_.spacing_m[1]}};
    const bool rim = straddles_rim(tree_, {2 * (level.square.x + level.nx) + 1, 1}) ||
                     straddles_rim(tree_, {1, 2 * (level.square.y + level.ny) + 1});
    if (!rim && !ground.has_voids()) return;
    const auto fix = [&](Plane<std::uint8_t>& plane, std::int32_t columns, std::int32_t rows, Coord offset) {
        for (std::int32_t j = 0; j < rows; ++j)
            for (std::int32_t i = 0; i < columns; ++i) {
                const Coord v{2 * (level.square.x + i) + offset.x, 2 * (level.square.y + j) + offset.y};
                bool odd = straddles_rim(tree_, v);
                for (std::int32_t y = v.y - 1; !odd && ground.has_voids() && y <= v.y + 1; ++y)
                    for (std::int32_t x = v.x - 1; x <= v.x + 1; ++x) odd = odd || ground.is_void({x, y});
                if (odd) plane.row(j)[i] = own_error(input, v);
            }
    };
    fix(level.error.side_x, level.nx, level.ny + 1, {1, 0});
    fix(level.error.side_y, level.nx + 1, level.ny, {0, 1});
    fix(level.error.centre, level.nx, level.ny, {1, 1});
}

void Pipeline::open_level_stores(int z) {
    const auto places = [&](int step) {
        return std::pair{((tree_.grid_columns() - 1) >> step) + 1, ((tree_.grid_rows() - 1) >> step) + 1};
    };
    const auto level_name = [](int step) { return "level" + std::to_string(step); };
    const auto [columns, rows] = places(1);
    if (!own_.exists()) {
        own_ = {file("own"), columns, rows};
        own_south_ = {file("own-south"), columns, regions_.down()};
        own_east_ = {file("own-east"), rows, regions_.across()};
    }
    const auto open = [&](int step) {
        const auto [w, h] = places(step);
        level_[step & 1] = {file(level_name(step)), w, h};
    };
    const auto open_centres = [&](int step) {
        centres_[step & 1] = {file("centres" + std::to_string(step)), (tree_.grid_columns() - 1) >> (step + 1),
                              (tree_.grid_rows() - 1) >> (step + 1)};
    };
    if (z > 0 && !level_[z & 1].exists()) open(z), open_centres(z - 1);
    open(z + 1), open_centres(z);
    if (plain_.exists()) return;
    const auto [w, h] = places(plain_z_);
    plain_ = {file("plain"), w, h};
    records_ = {file("records"), w, h};
}

void Pipeline::keep_level(const LevelResult& result) {
    const LevelInput& in = result.level;
    const int z = in.z;
    const auto flagged = [&](const Plane<std::int32_t>& steps, const Plane<std::uint8_t>* voids, std::int32_t i,
                             std::int32_t j) {
        const auto v = static_cast<std::uint32_t>(steps.row(j)[i]);
        return voids && voids->row(j)[i] ? v | void_flag : v;
    };
    const Planes<std::uint8_t>* const voids = result.voids;
    Buffer<std::uint32_t> corners(static_cast<std::size_t>(in.nx + 1) * static_cast<std::size_t>(in.ny + 1));
    Buffer<CentreRecord> centres(static_cast<std::size_t>(in.nx) * static_cast<std::size_t>(in.ny));
    for (std::int32_t j = 0; j <= in.ny; ++j)
        for (std::int32_t i = 0; i <= in.nx; ++i)
            corners[static_cast<std::size_t>(j) * static_cast<std::size_t>(in.nx + 1) + static_cast<std::size_t>(i)] =
                flagged(in.steps.corner, voids ? &voids->corner : nullptr, i, j);
    level_[(z + 1) & 1].write({in.square.x, in.square.y, in.nx + 1, in.ny + 1}, corners.data(), in.nx + 1);
    for (std::int32_t j = 0; j < in.ny; ++j)
        for (std::int32_t i = 0; i < in.nx; ++i)
            centres[static_cast<std::size_t>(j) * static_cast<std::size_t>(in.nx) + static_cast<std::size_t>(i)] = {
                in.steps.centre.row(j)[i], in.error.centre.row(j)[i], result.radii.at(VertexKind::centre, i, j), 0};
    centres_[z & 1].write({in.square.x, in.square.y, in.nx, in.ny}, centres.data(), in.nx);
    if (z >= plain_z_) keep_records(result);
}

void Pipeline::keep_records(const LevelResult& result) {
    const LevelInput& in = result.level;
    const int shift = in.z - plain_z_;
    const std::int32_t x0 = result.region.first.x >> plain_z_, y0 = result.region.first.y >> plain_z_;
    const std::int32_t columns = (2 * in.nx << shift) + 1;
    const auto record = [&](VertexKind kind, const Plane<std::uint8_t>& error, const Plane<std::uint8_t>* voids,
                            std::int32_t i, std::int32_t j) {
        const std::uint32_t radius = result.radii.at(kind, i, j) | (voids && voids->row(j)[i] ? void_bit : 0u);
        return static_cast<std::uint16_t>(error.row(j)[i] | radius << 8);
    };
    const Planes<std::uint8_t>* const v = result.voids;
    std::vector<std::uint16_t> row(static_cast<std::size_t>(columns));
    std::vector<std::uint32_t> steps(row.size());
    for (std::int32_t y = 0; y <= 2 * in.ny; ++y) {
        const Window w{x0, y0 + (y << shift), columns, 1};
        // Places between belong to finer steps. A neighbour that writes the same row at the same time writes the same.
        records_.read(w, row.data(), columns);
        const std::int32_t j = y / 2;
        for (std::int32_t x = 0; x <= 2 * in.nx; ++x) {
            const std::int32_t i = x / 2;
            std::uint16_t& to = row[static_cast<std::size_t>(x << shift)];
            if (x % 2 && y % 2)
                to = record(VertexKind::centre, in.error.centre, v ? &v->centre : nullptr, i, j);
            else if (x % 2)
                to = record(VertexKind::side_x, in.error.side_x, v ? &v->side_x : nullptr, i, j);
            else if (y % 2)
                to = record(VertexKind::side_y, in.error.side_y, v ? &v->side_y : nullptr, i, j);
            if (shift != 0) continue;
            const Plane<std::int32_t>& h =
                y % 2 ? (x % 2 ? in.steps.centre : in.steps.side_y) : (x % 2 ? in.steps.side_x : in.steps.corner);
            steps[static_cast<std::size_t>(x)] = static_cast<std::uint32_t>(h.row(j)[i]);
            if (v && (y % 2 ? (x % 2 ? v->centre : v->side_y) : (x % 2 ? v->side_x : v->corner)).row(j)[i])
                steps[static_cast<std::size_t>(x)] |= void_flag;
        }
        records_.write(w, row.data(), columns);
        if (shift == 0) plain_.write(w, steps.data(), columns);
    }
}

void Pipeline::pack_pages(const LevelResult& result) {
    const LevelInput& in = result.level;
    const std::int32_t n = tree_.side() >> (in.z + 1); // squares of a tile
    if (options_.order == Order::linear || n < static_cast<std::int32_t>(page_squares)) return;
    ChunkBatch batch;
    regions_.for_each_tile(result.region, [&](std::uint32_t tile, Coord corner) {
        const std::int32_t i0 = (corner.x >> (in.z + 1)) - in.square.x, j0 = (corner.y >> (in.z + 1)) - in.square.y;
        const auto blocks = static_cast<std::uint32_t>(n) / page_squares;
        for (std::uint32_t by = 0; by < blocks; ++by)
            for (std::uint32_t bx = 0; bx < blocks; ++bx) {
                const StepPageInput block{in.steps,
                                          in.error,
                                          result.voids,
                                          result.radii,
                                          i0 + static_cast<std::int32_t>(bx * page_squares),
                                          j0 + static_cast<std::int32_t>(by * page_squares),
                                          in.z == 0 ? &*leaf_ : nullptr,
                                          scales_.errors,
                                          header_,
                                          in.z};
                const PackedPage page = pack_step_page(block);
                batch.add({ChunkKind::geometry, tile, pages_.page_at(in.z, bx, by)}, page.bytes, options_.compression,
                          page.bound);
            }
    });
    spool_->append(std::move(batch));
}

namespace {

// What a unit of a step takes: the patch, taken apart, with codes, and the finer centres.
std::uint64_t bytes_of_unit(std::int32_t cells, int z) {
    const double places = (cells >> z) + 16.0;
    return static_cast<std::uint64_t>(places * places * (z == 0 ? 16 : 40)) + (std::uint64_t{1} << 20);
}

} // namespace

void Pipeline::vertices() {
    const std::uint32_t stage = index(Stage::vertices);
    if (done(stage)) return;
    open_level_stores(0);
    const auto count = static_cast<std::uint64_t>(regions_.count());
    run_units(
        {stage, "errors", count, workers_for(bytes_of_unit(regions_.cells(), 0)),
         static_cast<double>(tree_.columns()) * tree_.rows() / static_cast<double>(count)},
        [&](std::uint64_t u) {
            const auto region_index = static_cast<std::int64_t>(u);
            const Region region = regions_.at(region_index);
            Ground ground = ground_of(region);
            const std::int32_t nx = squares(region.last.x - region.first.x, 0),
                               ny = squares(region.last.y - region.first.y, 0);
            Planes<std::int32_t> steps(nx, ny);
            take_apart(ground.steps, steps);
            Planes<std::uint8_t> error(nx, ny), voids;
            const LevelInput level{scales_,
                                   tree_,
                                   {source_.spacing_m[0], source_.spacing_m[1]},
                                   0,
                                   {region.first.x / 2, region.first.y / 2},
                                   nx,
                                   ny,
                                   steps,
                                   error};
            leaf_errors(level, *leaf_);
            fix_leaves(ground, level);
            if (tree_.tile_log2 > 1) {
                Patch<std::uint8_t> own;
                own_errors(
                    {ground, region, scales_, *leaf_, options_.estimate, {source_.spacing_m[0], source_.spacing_m[1]}},
                    own);
                store_own(region_index, region, own);
            }
            if (ground.has_voids()) {
                voids = Planes<std::uint8_t>(nx, ny);
                take_apart(ground.voids, voids);
            }
            ground = {};
            climb_errors(level);
            Radii radii;
            climb_radii(level, radii);
            const LevelResult result{region, level, radii, voids.corner.values.empty() ? nullptr : &voids};
            pack_pages(result);
            keep_level(result);
        });
    finish(stage);
    raw_.remove();
    filled_.remove();
    voids_.remove();
}

void Pipeline::level(int z) {
    const std::uint32_t stage = index(Stage::levels, z);
    if (done(stage)) return;
    open_level_stores(z);
    const auto count = static_cast<std::uint64_t>(regions_.count());
    run_units({stage, "levels", count, workers_for(bytes_of_unit(regions_.cells(), z)),
               static_cast<double>(tree_.columns()) * tree_.rows() / static_cast<double>(count) / (1 << (2 * z))},
              [&](std::uint64_t u) {
                  const auto region_index = static_cast<std::int64_t>(u);
                  const Region region = regions_.at(region_index);
                  const std::int32_t nx = squares(region.last.x - region.first.x, z),
                                     ny = squares(region.last.y - region.first.y, z);
                  Planes<std::int32_t> steps(nx, ny);
                  Planes<std::uint8_t> error(nx, ny), voids;
                  if (ledger_.state.holes) voids = Planes<std::uint8_t>(nx, ny);
                  load_level(region, z, steps, voids);
                  load_own(region, region_index, z, error);
                  FinerCentres finer(nx, ny);
                  load_finer(region, z, finer);
                  const LevelInput level{scales_,
                                         tree_,
                                         {source_.spacing_m[0], source_.spacing_m[1]},
                                         z,
                                         {region.first.x >> (z + 1), region.first.y >> (z + 1)},
                                         nx,
                                         ny,
                                         steps,
                                         error,
                                         &finer};
                  climb_errors(level);
                  Radii radii;
                  climb_radii(level, radii);
                  const LevelResult result{region, level, radii, ledger_.state.holes ? &voids : nullptr};
                  pack_pages(result);
                  keep_level(result);
              });
    finish(stage);
    level_[z & 1].remove();
    centres_[(z - 1) & 1].remove();
}

void Pipeline::write_corners() {
    std::vector<std::uint32_t> corners, row(static_cast<std::size_t>(plain_.columns()));
    const std::int32_t step = tree_.side() >> plain_z_;
    for (std::int32_t y = 0; y < plain_.rows(); y += step) {
        plain_.read({0, y, static_cast<std::int32_t>(plain_.columns()), 1}, row.data(), plain_.columns());
        for (std::size_t x = 0; x < row.size(); x += static_cast<std::size_t>(step))
            corners.push_back((row[x] & ~void_flag) | (row[x] & void_flag ? corner_void_bit : 0));
    }
    ChunkBatch batch;
    batch.add({ChunkKind::corners, 0, 0}, std::as_bytes(std::span(corners)), options_.compression);
    if (header_.crs_bytes)
        batch.add({ChunkKind::crs, 0, 0}, std::as_bytes(std::span(source_.crs_wkt)), options_.compression);
    spool_->append(std::move(batch));
}

void Pipeline::plain_pages() {
    const std::uint32_t stage = index(Stage::plain_pages);
    if (done(stage)) return;
    if (!plain_.exists()) open_level_stores(std::max(tree_.tile_log2 - 1, 0));
    ledger_.state.done = 0; // the largest error is gathered in memory: from its beginning
    const std::uint32_t pages = options_.order == Order::linear ? pages_.pages_per_tile() : 1;
    const std::int32_t places = (tree_.side() >> plain_z_) + 1;
    const auto tiles = static_cast<std::uint64_t>(tree_.tiles_x) * static_cast<std::uint64_t>(tree_.tiles_y);
    std::vector<std::uint8_t> worst(tiles, 0);
    run_units({stage, "coarsest", tiles,
               workers_for(static_cast<std::uint64_t>(places) * static_cast<std::uint64_t>(places) * 8),
               static_cast<double>(places) * places},
              [&](std::uint64_t tile) {
                  const auto t = static_cast<std::int32_t>(tile);
                  const Window w{t % tree_.tiles_x * (places - 1), t / tree_.tiles_x * (places - 1), places, places};
                  std::vector<std::uint16_t> records(w.area());
                  std::vector<std::uint32_t> steps(w.area());
                  records_.read(w, records.data(), places);
                  plain_.read(w, steps.data(), places);
                  const auto vertex = [&](Coord c) {
                      const std::size_t at =
                          static_cast<std::size_t>(c.y >> plain_z_) * static_cast<std::size_t>(places) +
                          static_cast<std::size_t>(c.x >> plain_z_);
                      const bool corner = ((c.x | c.y) & (tree_.side() - 1)) == 0;
                      const auto error = static_cast<std::uint8_t>(corner ? 0 : records[at] & 0xff);
                      const auto hole = static_cast<std::uint8_t>(steps[at] & void_flag ? void_bit : 0);
                      const auto radius = static_cast<std::uint8_t>(corner ? 0 : records[at] >> 8 & ~void_bit);
                      return MixedPageVertex{static_cast<std::int32_t>(steps[at] & ~void_flag), error,
                                             static_cast<std::uint8_t>(radius | hole)};
                  };
                  worst[tile] = 0;
                  for (const std::uint16_t r : records)
                      worst[tile] = std::max(worst[tile], static_cast<std::uint8_t>(r & 0xff));
                  ChunkBatch batch;
                  for (std::uint32_t page = 0; page < pages; ++page) {
                      const PackedPage packed = pack_mixed_page(header_, page, vertex);
                      batch.add({ChunkKind::geometry, static_cast<std::uint32_t>(tile), page}, packed.bytes,
                                options_.compression, packed.bound);
                  }
                  spool_->append(std::move(batch));
              });
    ledger_.state.max_error_m = scales_.errors.metres[*std::max_element(worst.begin(), worst.end())];
    write_corners();
    finish(stage);
}

} // namespace fjell::baker
