#include "baker/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "baker/image.h"
#include "baker/maps.h"
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
    std::unique_ptr<ImageSource> image;
    MapPlan plan;
    int threads = 1;
};

void plan_maps(Bake& b) {
    const double side = b.tree.side();
    const std::uint32_t most = std::min(b.options.max_texture_log2, max_texture_log2);
    const auto [least_m, most_m] = std::minmax_element(b.dem.heights_m.begin(), b.dem.heights_m.end());
    b.plan.tree = b.tree;
    std::copy_n(b.dem.spacing_m, 2, b.plan.spacing_m);
    b.plan.normal_log2 = fitting_log2(side, most);
    b.plan.ramp =
        absolute(b.options.ramp_path.empty() ? default_ramp() : read_ramp(b.options.ramp_path), *least_m, *most_m);
    // Colours of a ramp change slowly, and normals carry the detail: half the samples' density.
    b.plan.colour_log2 = fitting_log2(side / 2, most);
    if (b.options.texture_path.empty()) return;
    b.image = open_images({b.options.texture_path},
                          ground_of(b.dem.columns, b.dem.rows, b.dem.spacing_m, b.dem.origin_m, b.dem.crs_wkt));
    b.plan.image = b.image.get();
    b.plan.colour_log2 = fitting_log2(side * b.image->pixels_per_sample(), most);
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
    h.colour_log2 = b.plan.colour_log2;
    h.normal_log2 = b.plan.normal_log2;
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

// The window of a mip's grid that a tile needs, from what the tiles of that mip kept.
Texels gather(const MapPlan& plan, MapKind kind, std::uint32_t mip, const Window& window,
              const std::vector<Texels>& kept) {
    const std::size_t n = channels(kind);
    const std::int32_t cells = plan.texels(kind, mip, 0).columns - 1;
    Texels texels;
    for (std::int32_t y = window.y; y < window.y + window.rows; ++y)
        for (std::int32_t x = window.x; x < window.x + window.columns; ++x) {
            const std::int32_t tx = std::min(x / cells, plan.tree.tiles_x - 1),
                               ty = std::min(y / cells, plan.tree.tiles_y - 1);
            const auto tile = static_cast<std::size_t>(ty * plan.tree.tiles_x + tx);
            const auto at = static_cast<std::size_t>((y - ty * cells) * (cells + 1) + x - tx * cells) * n;
            for (std::size_t c = 0; c < n; ++c) texels.push_back(kept[tile][at + c]);
        }
    return texels;
}

std::uint64_t write_maps(PackWriter& writer, const Bake& b) {
    const MapPlan& plan = b.plan;
    const auto tiles = static_cast<std::uint32_t>(b.tree.tiles_x * b.tree.tiles_y);
    std::vector<NearMaps> near(tiles);
    parallel_for(tiles, b.threads, [&](std::int64_t i) {
        const auto tile = static_cast<std::uint32_t>(i);
        const Window w = heights_for_maps(plan, tile);
        std::vector<float> heights;
        for (std::int32_t y = w.y; y < w.y + w.rows; ++y) {
            const auto row = b.dem.heights_m.begin() + static_cast<std::ptrdiff_t>(b.dem.index(w.x, y));
            heights.insert(heights.end(), row, row + w.columns);
        }
        const auto reader = plan.image ? plan.image->reader() : nullptr;
        near[static_cast<std::size_t>(i)] = near_maps(plan, tile, heights.data(), reader.get());
    });
    std::uint64_t bytes = 0;
    for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
        const bool colour = kind == MapKind::colour;
        const ChunkKind chunk = colour ? ChunkKind::colour : ChunkKind::normal;
        const std::uint32_t mips = mip_count(plan.log2_side(kind)), first_far = std::min(near_mips, mips);
        bytes += write_chunks(
            writer, b, colour ? "colours" : "normals", std::uint64_t{tiles} * first_far, [&](std::uint64_t i) {
                const auto mip = static_cast<std::uint32_t>(i / tiles), tile = static_cast<std::uint32_t>(i % tiles);
                const NearMaps& made = near[tile];
                return compress_chunk({chunk, tile, mip}, (colour ? made.colour : made.normal)[mip].blocks,
                                      b.options.compression);
            });
        std::vector<Texels> kept(tiles);
        for (std::uint32_t tile = 0; tile < tiles && mips > 0; ++tile)
            kept[tile] = (colour ? near[tile].colour : near[tile].normal).back().texels;
        for (std::uint32_t mip = first_far; mip < mips; ++mip) {
            std::vector<Texels> next(tiles);
            bytes += write_chunks(writer, b, "maps", tiles, [&](std::uint64_t i) {
                const auto tile = static_cast<std::uint32_t>(i);
                MipTexels made = far_mip(plan, kind, mip, tile,
                                         gather(plan, kind, mip - 1, finer_texels(plan, kind, mip, tile), kept));
                next[tile] = std::move(made.texels);
                return compress_chunk({chunk, tile, mip}, made.blocks, b.options.compression);
            });
            kept = std::move(next);
        }
    }
    return bytes;
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
    Bake b{options, std::move(dem), {}, {}, {}, {}, {}, {}, resolve_threads(options.threads)};
    b.tree = tiling(b.dem, options);
    plan_maps(b);
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
    summary.texture_bytes = write_maps(writer, b);
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
