#include "baker/bake/region_stores.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <vector>

namespace fjell::baker {

void StepStores::remove() {
    places.remove();
    centres.remove();
    codes.remove();
}

void UnsaturatedStores::remove() {
    inside.remove();
    south.remove();
    east.remove();
}

void MixedStores::remove() {
    records.remove();
    heights.remove();
}

Window places_of(const Tree& tree, int z) {
    return {0, 0, ((tree.grid_columns() - 1) >> z) + 1, ((tree.grid_rows() - 1) >> z) + 1};
}

StepStores open_step(const BakeContext& context, int z, const Window& samples) {
    const Window all = places_of(context.tree, z + 1);
    const std::int32_t x = samples.x >> (z + 1), y = samples.y >> (z + 1);
    const Window places = samples.area() == 0 ? Window{}
                                              : common({x, y, ((samples.x + samples.columns) >> (z + 1)) - x + 2,
                                                        ((samples.y + samples.rows) >> (z + 1)) - y + 2},
                                                       all);
    return {context.open<std::uint32_t>("places" + std::to_string(z + 1), all.columns, all.rows, places),
            context.open<CentreRecord>("centres" + std::to_string(z), all.columns - 1, all.rows - 1,
                                       common(places, {0, 0, all.columns - 1, all.rows - 1})),
            {}};
}

StepStores open_step_codes(const BakeContext& context) {
    const Window all = places_of(context.tree, 1);
    return {{}, {}, context.open<CentreCodes>("codes", all.columns - 1, all.rows - 1)};
}

UnsaturatedStores open_unsaturated(const BakeContext& context, int z) {
    const Window all = places_of(context.tree, z);
    return {context.open<std::uint8_t>("unsaturated", all.columns, all.rows),
            context.open<std::uint8_t>("unsaturated-south", all.columns, context.regions.down()),
            context.open<std::uint8_t>("unsaturated-east", all.rows, context.regions.across()), z};
}

MixedStores open_mixed(const BakeContext& context) {
    const Window all = places_of(context.tree, context.mixed_log2);
    return {context.open<std::uint16_t>("mixed-records", all.columns, all.rows),
            context.open<std::uint32_t>("mixed-heights", all.columns, all.rows)};
}

Digest records_digest(const BakeContext& context, const MixedStores& stores, int first, int last, bool with_rest) {
    const auto columns = static_cast<std::int32_t>(stores.records.columns()),
               rows = static_cast<std::int32_t>(stores.records.rows());
    const int none = context.tree.tile_log2 - context.mixed_log2; // corners of tiles, which are no vertices
    first -= context.mixed_log2;
    last -= context.mixed_log2;
    const std::int32_t step = with_rest ? 1 : 1 << first;
    std::vector<std::uint16_t> row(static_cast<std::size_t>(columns));
    Digest sum;
    for (std::int32_t y = 0; y < rows; y += step) {
        stores.records.read({0, y, columns, 1}, row.data(), columns);
        for (std::int32_t x = 0; x < columns; ++x) {
            // A vertex belongs to the largest step that divides both of its coordinates.
            const int of = std::countr_zero(static_cast<std::uint32_t>(x | y));
            if (!(of >= first && of <= last) && !(with_rest && of >= none)) row[static_cast<std::size_t>(x)] = 0;
        }
        sum += digest_of(static_cast<std::uint64_t>(y) * row.size() * sizeof row[0], std::as_bytes(std::span(row)));
    }
    return sum;
}

// ---- what a region reads

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

// The places that errors/step.h wants of a region at step 2^z, in units of that step.
template <typename T>
Patch<T> patch_for(const Region& region, int z) {
    const std::int32_t nx = (region.last.column - region.first.column) >> (z + 1),
                       ny = (region.last.row - region.first.row) >> (z + 1);
    return {(region.first.column >> z) - 2, (region.first.row >> z) - 2, 2 * (nx + reach + 2), 2 * (ny + reach + 2)};
}

} // namespace

QuantisedHeights load_heights(const BakeContext& context, const HeightScale& scale, const HeightStores& stores,
                              const Region& region) {
    QuantisedHeights heights{context.tree, patch_for<std::int32_t>(region, 0), {}, true};
    Patch<std::int32_t>& steps = heights.steps;
    const Window known = within(steps, context.tree.columns(), context.tree.rows());
    const StoreView<float> heights_m(stores.heights, known);
    for (std::int32_t y = 0; y < known.rows; ++y) {
        const auto count = static_cast<std::size_t>(known.columns);
        std::int32_t* const to = steps.at(known.x, known.y + y);
        quantise(heights_m.row(y), count, scale, to);
        heights.on_scale = heights.on_scale && lie_on(scale, heights_m.row(y), to, count);
    }
    replicate(steps, known);
    if (!stores.holes.exists()) return heights;
    Patch<std::uint8_t> voids = patch_for<std::uint8_t>(region, 0);
    load(stores.holes, voids);
    if (std::count(voids.values.begin(), voids.values.end(), std::uint8_t{1}) != 0) heights.voids = std::move(voids);
    return heights;
}

namespace {

// The places of step 2^z, which step z - 1 has left.
void load_places(const StepStores& finer, const Region& region, int z, const FinerInput& out) {
    Patch<std::uint32_t> stored = patch_for<std::uint32_t>(region, z);
    load(finer.places, stored);
    Patch<std::int32_t> values = patch_for<std::int32_t>(region, z);
    std::transform(stored.values.begin(), stored.values.end(), values.values.begin(),
                   [](std::uint32_t v) { return static_cast<std::int32_t>(v & ~hole_flag); });
    split_planes(values, out.steps);
    if (!out.holes) return;
    Patch<std::uint8_t> flags = patch_for<std::uint8_t>(region, z);
    std::transform(stored.values.begin(), stored.values.end(), flags.values.begin(),
                   [](std::uint32_t v) { return static_cast<std::uint8_t>(v >> 31); });
    split_planes(flags, *out.holes);
}

// Radii in metres of step z - 1's centres.
struct CentreRadii {
    float m[radius_codes];
    CentreRadii(const Scales& scales, int z, int tile_log2) {
        const float unit_m = scales.level_radius_m[2 * (tile_log2 - z)];
        for (std::size_t code = 0; code < radius_codes; ++code) m[code] = unit_m * scales.radii.factor[code];
    }
};

// Where there are no centres they ask for nothing.
template <typename T>
void clear_unknown(const Patch<T>& patch, const Window& known, FinerCentres& out) {
    const std::int32_t left = known.x - patch.x, right = left + known.columns;
    for (std::int32_t y = 0; y < patch.rows; ++y) {
        const bool outside = y + patch.y < known.y || y + patch.y >= known.y + known.rows;
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(patch.columns);
        const auto clear = [&](std::int32_t from, std::int32_t to) {
            std::fill(out.error.data() + row + from, out.error.data() + row + to, std::uint8_t{0});
            std::fill(out.radius_m.data() + row + from, out.radius_m.data() + row + to, 0.0f);
        };
        clear(0, outside ? patch.columns : left);
        if (!outside) clear(right, patch.columns);
    }
}

void load_centres(const StepStores& finer, const Region& region, int z, const CentreRadii& radii, FinerCentres& out) {
    Patch<CentreRecord> patch = patch_for<CentreRecord>(region, z);
    load(finer.centres, patch);
    for (std::size_t i = 0; i < patch.area(); ++i) {
        out.steps[i] = patch.values[i].steps;
        out.error[i] = patch.values[i].error;
        out.radius_m[i] = radii.m[patch.values[i].radius];
    }
    clear_unknown(patch, within(patch, finer.centres.columns(), finer.centres.rows()), out);
}

} // namespace

void load_finer(const StepStores& finer, const Region& region, int z, int tile_log2, const Scales& scales,
                const FinerInput& out) {
    load_places(finer, region, z, out);
    load_centres(finer, region, z, CentreRadii(scales, z, tile_log2), out.centres);
}

namespace {

// Samples of a row, in height steps, at every second column from `first` on; those beyond the ends take the nearest of
// these columns, or the last sample where that stands beyond it.
class EverySecondSample {
public:
    EverySecondSample(const BakeContext& context, const HeightScale& scale, const Store<float>& heights,
                      const Patch<std::int32_t>& patch)
        : scale_(scale), heights_(heights), last_{context.tree.columns() - 1, context.tree.rows() - 1},
          grid_{(context.tree.grid_columns() - 1) / 2, (context.tree.grid_rows() - 1) / 2}, patch_(patch),
          row_(static_cast<std::size_t>(2 * patch.columns)) {}

    // odd: centres, which are one fewer; else places. y: of the patch. Where its sample lies.
    [[nodiscard]] std::int32_t sample_row(std::int32_t y, bool odd) const {
        return std::min(2 * std::clamp(patch_.y + y, 0, grid_.row - odd) + odd, last_.row);
    }
    void take(std::int32_t y, bool odd, std::int32_t* to) {
        const std::int32_t x0 = std::max(2 * patch_.x, 0),
                           x1 = std::min(2 * (patch_.x + patch_.columns) - 1, last_.column);
        const StoreView<float> samples(heights_, {x0, sample_row(y, odd), x1 - x0 + 1, 1});
        quantise(samples.row(0), static_cast<std::size_t>(x1 - x0 + 1), scale_, row_.data());
        pick(odd, row_.data(), x0, to);
    }
    // from: of columns from x0 on.
    template <typename T>
    void pick(bool odd, const T* from, std::int32_t x0, T* to) const {
        const std::int32_t first = std::max(patch_.x, 0); // columns of a patch whose samples are there
        const std::int32_t end =
            std::min(patch_.x + patch_.columns, std::min((last_.column - odd) >> 1, grid_.column - odd) + 1);
        for (std::int32_t x = first; x < end; ++x) to[x - patch_.x] = from[2 * x + odd - x0];
        for (std::int32_t x = std::max(first, end); x < patch_.x + patch_.columns; ++x)
            to[x - patch_.x] = from[std::min(2 * std::min(x, grid_.column - odd) + odd, last_.column) - x0];
        std::fill(to, to + (first - patch_.x), to[first - patch_.x]);
    }

private:
    const HeightScale& scale_;
    const Store<float>& heights_;
    const SampleIndex last_, grid_; // the last sample; the last place of step 2
    const Patch<std::int32_t>& patch_;
    Buffer<std::int32_t> row_;
};

} // namespace

void load_finest(const BakeContext& context, const StepStores& finest, const HeightStores& stores, const Region& region,
                 const Scales& scales, const FinerInput& out) {
    Patch<std::int32_t> values = patch_for<std::int32_t>(region, 1);
    EverySecondSample samples(context, scales.height_scale, stores.heights, values);
    const auto columns = static_cast<std::size_t>(values.columns);
    for (std::int32_t y = 0; y < values.rows; ++y) {
        const std::size_t at = static_cast<std::size_t>(y) * columns;
        samples.take(y, false, values.values.data() + at);
        samples.take(y, true, out.centres.steps.data() + at);
    }
    split_planes(values, out.steps);
    if (out.holes) {
        Patch<std::uint8_t> flags = patch_for<std::uint8_t>(region, 1);
        const std::int32_t x0 = std::max(2 * flags.x, 0);
        const std::int32_t x1 = std::min(2 * (flags.x + flags.columns), context.tree.columns());
        for (std::int32_t y = 0; y < flags.rows; ++y) {
            const StoreView<std::uint8_t> marks(stores.holes, {x0, samples.sample_row(y, false), x1 - x0, 1});
            samples.pick(false, marks.row(0), x0, flags.values.data() + static_cast<std::size_t>(y) * columns);
        }
        split_planes(flags, *out.holes);
    }
    Patch<CentreCodes> codes = patch_for<CentreCodes>(region, 1);
    load(finest.codes, codes);
    const CentreRadii radii(scales, 1, context.tree.tile_log2);
    for (std::size_t i = 0; i < codes.area(); ++i) {
        out.centres.error[i] = codes.values[i].error;
        out.centres.radius_m[i] = radii.m[codes.values[i].radius];
    }
    clear_unknown(codes, within(codes, finest.codes.columns(), finest.codes.rows()), out.centres);
}

void load_unsaturated(const BakeContext& context, const UnsaturatedStores& stores, std::int64_t region_index, int z,
                      VertexPlanes<std::uint8_t>& error) {
    const Regions& regions = context.regions;
    const Region region = regions.at(region_index);
    const auto across = static_cast<std::int32_t>(region_index % regions.across()),
               down = static_cast<std::int32_t>(region_index / regions.across());
    const std::int32_t x0 = region.first.column >> stores.z, y0 = region.first.row >> stores.z,
                       columns = ((region.last.column - region.first.column) >> stores.z) + 1,
                       rows = ((region.last.row - region.first.row) >> stores.z) + 1;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(columns)), other(row.size());
    std::vector<std::uint8_t> west(static_cast<std::size_t>(rows), 0), east(west);
    if (across > 0) stores.east.read({y0, across - 1, rows, 1}, west.data(), rows);
    if (across + 1 < regions.across()) stores.east.read({y0, across, rows, 1}, east.data(), rows);
    const std::int32_t step = 1 << (z - stores.z), n = (columns - 1) / (2 * step);
    for (std::int32_t y = 0; y < rows; y += step) {
        stores.inside.read({x0, y0 + y, columns, 1}, row.data(), columns);
        const auto merge = [&](std::int32_t border) {
            stores.south.read({x0, border, columns, 1}, other.data(), columns);
            std::transform(row.begin(), row.end(), other.begin(), row.begin(),
                           [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
        };
        if (y == 0 && down > 0) merge(down - 1);
        if (y == rows - 1 && down + 1 < regions.down()) merge(down);
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

// ---- what a region writes

void store_unsaturated(const BakeContext& context, std::int64_t region_index, const Patch<std::uint8_t>& errors,
                       UnsaturatedStores& stores) {
    const Tree& tree = context.tree;
    const Regions& regions = context.regions;
    const Region region = regions.at(region_index);
    // The southern and eastern borders are the neighbours' rows; what was measured on this side lies apart.
    const bool last_x = region.last.column + 1 == tree.grid_columns(), last_y = region.last.row + 1 == tree.grid_rows();
    stores.inside.write({errors.x, errors.y, errors.columns - !last_x, errors.rows - !last_y}, errors.values.data(),
                        errors.columns);
    const auto across = static_cast<std::int32_t>(region_index % regions.across()),
               down = static_cast<std::int32_t>(region_index / regions.across());
    stores.south.write({errors.x, down, errors.columns, 1}, errors.at(errors.x, errors.y + errors.rows - 1),
                       errors.columns);
    std::vector<std::uint8_t> east;
    for (std::int32_t y = 0; y < errors.rows; ++y)
        east.push_back(*errors.at(errors.x + errors.columns - 1, errors.y + y));
    stores.east.write({errors.y, across, errors.rows, 1}, east.data(), errors.rows);
}

namespace {

void store_places(const StepResult& result, StepStores& stores) {
    const StepInput& in = result.step;
    const VertexPlanes<std::uint8_t>* const holes = result.holes;
    Buffer<std::uint32_t> corners(static_cast<std::size_t>(in.nx + 1) * static_cast<std::size_t>(in.ny + 1));
    std::uint32_t* corner = corners.data();
    for (std::int32_t j = 0; j <= in.ny; ++j)
        for (std::int32_t i = 0; i <= in.nx; ++i) {
            const auto steps = static_cast<std::uint32_t>(in.steps.corner.row(j)[i]);
            *corner++ = holes && holes->corner.row(j)[i] ? steps | hole_flag : steps;
        }
    // The southern and eastern borders are the neighbours', which know the same of them: each place is written once.
    const bool last_x = in.square.column + in.nx + 1 == stores.places.columns(),
               last_y = in.square.row + in.ny + 1 == stores.places.rows();
    stores.places.write({in.square.column, in.square.row, in.nx + last_x, in.ny + last_y}, corners.data(), in.nx + 1);
}

// record(i, j): of the centre of square (i, j).
template <typename T, typename Record>
void store_centres(const StepInput& in, Store<T>& store, const Record& record) {
    Buffer<T> centres(static_cast<std::size_t>(in.nx) * static_cast<std::size_t>(in.ny));
    T* to = centres.data();
    for (std::int32_t j = 0; j < in.ny; ++j)
        for (std::int32_t i = 0; i < in.nx; ++i) *to++ = record(i, j);
    store.write({in.square.column, in.square.row, in.nx, in.ny}, centres.data(), in.nx);
}

} // namespace

void store_step(const StepResult& result, StepStores& stores) {
    const StepInput& in = result.step;
    const auto codes = [&](std::int32_t i, std::int32_t j) {
        return CentreCodes{in.error.centre.row(j)[i], result.radii.at(VertexKind::centre, i, j)};
    };
    if (stores.codes.exists()) return store_centres(in, stores.codes, codes);
    store_places(result, stores);
    store_centres(in, stores.centres, [&](std::int32_t i, std::int32_t j) {
        const CentreCodes c = codes(i, j);
        return CentreRecord{in.steps.centre.row(j)[i], c.error, c.radius, 0};
    });
}

void store_mixed(const StepResult& result, int mixed_log2, MixedStores& stores) {
    const StepInput& in = result.step;
    const int shift = in.z - mixed_log2;
    const std::int32_t x0 = result.region.first.column >> mixed_log2, y0 = result.region.first.row >> mixed_log2;
    const std::int32_t columns = (2 * in.nx << shift) + 1;
    const VertexPlanes<std::uint8_t>* const v = result.holes;
    const auto record = [&](VertexKind kind, const VertexPlane<std::uint8_t>& error,
                            const VertexPlane<std::uint8_t>* holes, std::int32_t i, std::int32_t j) {
        const std::uint32_t radius = result.radii.at(kind, i, j) | (holes && holes->row(j)[i] ? void_bit : 0u);
        return static_cast<std::uint16_t>(error.row(j)[i] | radius << 8);
    };
    std::vector<std::uint16_t> row(static_cast<std::size_t>(columns));
    std::vector<std::uint32_t> steps(row.size());
    for (std::int32_t y = 0; y <= 2 * in.ny; ++y) {
        const Window w{x0, y0 + (y << shift), columns, 1};
        // Places between belong to finer steps. A neighbour that writes the same row at the same time writes the same.
        stores.records.read(w, row.data(), columns);
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
            const VertexPlane<std::int32_t>& h =
                y % 2 ? (x % 2 ? in.steps.centre : in.steps.side_y) : (x % 2 ? in.steps.side_x : in.steps.corner);
            steps[static_cast<std::size_t>(x)] = static_cast<std::uint32_t>(h.row(j)[i]);
            if (v && (y % 2 ? (x % 2 ? v->centre : v->side_y) : (x % 2 ? v->side_x : v->corner)).row(j)[i])
                steps[static_cast<std::size_t>(x)] |= hole_flag;
        }
        stores.records.write(w, row.data(), columns);
        if (shift == 0) stores.heights.write(w, steps.data(), columns);
    }
}

} // namespace fjell::baker
