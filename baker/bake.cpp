#include "baker/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "baker/parallel.h"
#include "baker/write.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

Tree tiling(const Dem& dem, const BakeOptions& options) {
    const double extent = std::max((dem.columns - 1) * dem.spacing_m[0], (dem.rows - 1) * dem.spacing_m[1]);
    if (extent > max_extent_m)
        throw Failure(1, fmt::format("the terrain would be {:.3g} m wide, more than {:.0e} m; give a smaller --spacing",
                                     extent, max_extent_m));
    return Tree::covering(dem.columns, dem.rows,
                          options.tile_log2 ? options.tile_log2 : auto_tile_log2(dem.columns, dem.rows));
}

// Everything a bake holds on its way to the file.
struct Bake {
    const BakeOptions& options;
    Dem dem;
    Tree tree;
    Lattice lattice;
    std::vector<std::int32_t> steps;
    VertexErrors errors;
    std::optional<Image> image;
    std::optional<Ramp> ramp;
    std::uint32_t colour_log2 = 0, normal_log2 = 0;
    int threads = 1;

    [[nodiscard]] MapBuilder maps() const { return {dem, tree, colour_log2, normal_log2}; }
};

// Meadows, forest edge, rock, snow: for height fields that come without colours.
Ramp default_ramp() {
    return {{{0.0, {92, 112, 66}},
             {0.35, {128, 126, 84}},
             {0.6, {140, 124, 104}},
             {0.8, {150, 144, 138}},
             {1.0, {240, 242, 246}}},
            true};
}

void prepare_colour(Bake& b) {
    const double side = b.tree.side();
    const std::uint32_t most = std::min(b.options.max_texture_log2, max_texture_log2);
    b.normal_log2 = fitting_log2(side, most);
    if (!b.options.texture_path.empty()) {
        b.image = read_image(b.options.texture_path);
        const double per_tile =
            side * std::max(b.image->width / (b.dem.columns - 1.0), b.image->height / (b.dem.rows - 1.0));
        b.colour_log2 = fitting_log2(per_tile, most);
        return;
    }
    b.ramp = absolute(b.options.ramp_path.empty() ? default_ramp() : read_ramp(b.options.ramp_path), b.dem);
    b.colour_log2 = fitting_log2(side, most);
}

PackHeader header_of(const Bake& b) {
    PackHeader h{};
    h.columns = static_cast<std::uint32_t>(b.tree.columns());
    h.rows = static_cast<std::uint32_t>(b.tree.rows());
    h.tiles_x = static_cast<std::uint32_t>(b.tree.tiles_x);
    h.tiles_y = static_cast<std::uint32_t>(b.tree.tiles_y);
    h.tile_log2 = static_cast<std::uint32_t>(b.tree.tile_log2);
    h.order = b.options.order;
    h.estimate = b.options.estimate;
    h.nesting = static_cast<float>(b.options.nesting);
    std::copy_n(b.dem.spacing_m, 2, h.spacing_m);
    std::copy_n(b.dem.origin_m, 2, h.origin_m);
    h.base_m = b.lattice.base_m;
    h.quantum_m = b.lattice.quantum_m;
    const auto [least, most] = std::minmax_element(b.steps.begin(), b.steps.end());
    h.min_m = b.lattice.height_m(*least);
    h.max_m = b.lattice.height_m(*most);
    h.lattice_steps = static_cast<std::uint32_t>(*most);
    h.max_error_m = b.errors.max_error_m;
    h.error_floor_m = b.errors.floor_m;
    h.error_ratio = b.errors.ratio;
    h.error_nesting_steps = b.errors.nesting_steps;
    std::copy_n(b.errors.level_radius_m, std::size(h.level_radius_m), h.level_radius_m);
    h.voids = void_count(b.dem);
    h.colour_log2 = b.colour_log2;
    h.normal_log2 = b.normal_log2;
    h.crs_bytes = static_cast<std::uint32_t>(b.dem.crs_wkt.size());
    return h;
}

// What a reader would refuse is refused before the work.
void check_header(const Bake& b) {
    PackHeader header = header_of(b);
    std::fill_n(header.level_radius_m, 2 * b.tree.tile_log2, 1.0f); // not known yet
    const Status s = check_ranges(header);
    if (s.ok()) return;
    throw Failure(
        1, fmt::format("no pack can hold this terrain: its {} is out of range ({} x {} samples, {} m apart, heights "
                       "{:.6g}..{:.6g} m in steps of {:.3g} m); change --spacing, --zscale or --zoffset, or cut the "
                       "height field",
                       s.field, b.dem.columns, b.dem.rows, b.dem.spacing_m[0], b.lattice.base_m,
                       b.lattice.height_m(*std::max_element(b.steps.begin(), b.steps.end())), b.lattice.quantum_m));
}

// Makes chunks [0, count) on all threads, a batch at a time so that few wait in memory, and writes them in order.
template <typename Make>
std::uint64_t write_chunks(PackWriter& writer, const Bake& b, const char* stage, std::uint64_t count,
                           const Make& make) {
    std::uint64_t bytes = 0;
    const std::uint64_t batch = static_cast<std::uint64_t>(b.threads) * 32;
    for (std::uint64_t first = 0; first < count; first += batch) {
        const std::uint64_t n = std::min(batch, count - first);
        std::vector<Chunk> chunks(n);
        parallel_for(static_cast<std::int64_t>(n), b.threads, [&](std::int64_t i) {
            chunks[static_cast<std::size_t>(i)] = make(first + static_cast<std::uint64_t>(i));
        });
        for (const Chunk& chunk : chunks) {
            writer.add(chunk);
            bytes += chunk.stored.size();
        }
        if (b.options.progress) b.options.progress(stage, first + n, count);
    }
    return bytes;
}

void write_corners(PackWriter& writer, const Bake& b) {
    std::vector<std::uint32_t> corners;
    for (std::int32_t y = 0; y <= b.tree.tiles_y; ++y)
        for (std::int32_t x = 0; x <= b.tree.tiles_x; ++x) {
            const Coord sample = b.tree.sample({x * b.tree.side(), y * b.tree.side()});
            const std::size_t at = static_cast<std::size_t>(sample.y) * static_cast<std::size_t>(b.tree.columns()) +
                                   static_cast<std::size_t>(sample.x);
            corners.push_back(static_cast<std::uint32_t>(b.steps[at]) |
                              (b.dem.is_void(sample.x, sample.y) ? corner_void_bit : 0));
        }
    writer.add(compress_chunk({ChunkKind::corners, 0, 0}, std::as_bytes(std::span(corners)), b.options.compression));
}

// Pages in the order they are wanted in: page 0 of all tiles, then step by step, so that a prefix of the file is the
// whole terrain, coarser. Linear order knows no steps: tile by tile.
std::vector<ChunkId> page_sequence(const Bake& b) {
    const PageLayout pages{b.tree.tile_log2, b.options.order};
    const auto tiles = static_cast<std::uint32_t>(b.tree.tiles_x * b.tree.tiles_y);
    std::vector<ChunkId> sequence;
    for (std::uint32_t tile = 0; tile < tiles; ++tile)
        for (std::uint32_t page = 0; page < pages.pages_per_tile(); ++page)
            sequence.push_back({ChunkKind::geometry, tile, page});
    if (b.options.order == Order::linear) return sequence;
    std::stable_sort(sequence.begin(), sequence.end(), [&](const ChunkId& p, const ChunkId& q) {
        const auto rank = [&](const ChunkId& id) {
            return id.item == 0 ? 0 : b.tree.tile_log2 - pages.page_step_log2(id.item);
        };
        return rank(p) < rank(q);
    });
    return sequence;
}

std::uint64_t write_geometry(PackWriter& writer, const Bake& b) {
    write_corners(writer, b);
    const std::vector<ChunkId> sequence = page_sequence(b);
    const LeafErrors leaf(b.errors.scale, b.lattice.quantum_m);
    const PageInput input{b.dem, b.steps, b.errors, b.tree, {b.tree.tile_log2, b.options.order}, leaf};
    return write_chunks(writer, b, "pages", sequence.size(), [&](std::uint64_t i) {
        const ChunkId id = sequence[i];
        return compress_chunk(id, pack_page(input, id.tile, id.item), b.options.compression);
    });
}

std::uint64_t write_maps(PackWriter& writer, const Bake& b, ChunkKind kind) {
    const bool colour = kind == ChunkKind::colour;
    const std::uint64_t mips = mip_count(colour ? b.colour_log2 : b.normal_log2);
    const auto tiles = static_cast<std::uint64_t>(b.tree.tiles_x) * static_cast<std::uint64_t>(b.tree.tiles_y);
    return write_chunks(writer, b, colour ? "colours" : "normals", tiles * mips, [&](std::uint64_t i) {
        const auto tile = static_cast<std::uint32_t>(i / mips), mip = static_cast<std::uint32_t>(i % mips);
        const auto texels =
            colour ? colour_mip(b.maps(), b.image ? &*b.image : nullptr, b.ramp ? &*b.ramp : nullptr, tile, mip)
                   : normal_mip(b.maps(), tile, mip);
        return compress_chunk({kind, tile, mip}, std::as_bytes(std::span(texels)), b.options.compression);
    });
}

void check(const BakeOptions& options) {
    if (!(options.nesting >= 0.001 && options.nesting <= 1))
        throw Failure(2,
                      "--nesting must lie in 0.001..1: with less, spheres that touch do not nest in float arithmetic "
                      "and the mesh cracks");
    if (options.tile_log2 && (options.tile_log2 < min_tile_log2 || options.tile_log2 > max_tile_log2))
        throw Failure(2, "--tile must be a power of two from 2 to 4096, or auto");
    if (!options.texture_path.empty() && !options.ramp_path.empty())
        throw Failure(2, "give --texture or --ramp, not both");
}

} // namespace

int auto_tile_log2(std::int32_t columns, std::int32_t rows) {
    int log2 = 9;
    while (log2 > min_tile_log2 && (1 << (log2 - 1)) >= std::max(columns, rows) - 1) --log2;
    const auto tiles = [&] {
        const Tree tree = Tree::covering(columns, rows, log2);
        return static_cast<std::int64_t>(tree.tiles_x) * tree.tiles_y;
    };
    while (log2 < max_tile_log2 && tiles() > 1024) ++log2;
    return log2;
}

BakeSummary bake(Dem dem, const BakeOptions& options, const std::string& out_path) {
    check(options);
    const auto start = Clock::now();
    PackWriter writer(out_path); // first: a missing folder should not cost an hour
    BakeSummary summary;
    Bake b{options, std::move(dem), {}, {}, {}, {}, {}, {}, 0, 0, resolve_threads(options.threads)};
    b.tree = tiling(b.dem, options);
    prepare_colour(b);
    b.lattice = choose_lattice(b.dem, b.tree, options.quantum_m);
    b.steps = quantise(b.dem, b.lattice);
    check_header(b);
    const auto errors_start = Clock::now();
    // The stored float is what readers test against.
    const double nesting = static_cast<float>(options.nesting);
    b.errors =
        compute_errors({b.dem, b.steps, b.lattice, b.tree, options.estimate, nesting, b.threads}, options.progress);
    summary.seconds_errors = seconds_since(errors_start);

    const PackHeader header = header_of(b);
    writer.begin(header);
    summary.geometry_bytes = write_geometry(writer, b);
    const auto textures_start = Clock::now();
    summary.directory_bytes = chunk_index(header, {ChunkKind::colour, 0, 0}) * sizeof(ChunkEntry) + sizeof(PackHeader);
    summary.texture_bytes = write_maps(writer, b, ChunkKind::colour) + write_maps(writer, b, ChunkKind::normal);
    summary.seconds_textures = seconds_since(textures_start);
    if (header.crs_bytes)
        writer.add(
            compress_chunk({ChunkKind::crs, 0, 0}, std::as_bytes(std::span(b.dem.crs_wkt)), options.compression));
    summary.file_bytes = writer.finish();

    summary.columns = b.dem.columns;
    summary.rows = b.dem.rows;
    summary.tree = b.tree;
    summary.quantum_m = b.lattice.quantum_m;
    summary.max_error_m = b.errors.max_error_m;
    summary.voids = header.voids;
    summary.seconds_total = seconds_since(start);
    return summary;
}

} // namespace fjell::baker
