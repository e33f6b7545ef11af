#include "baker/bake/context.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>

#include <fmt/format.h>

#include "baker/bake/region_stores.h"
#include "baker/maps/colour.h"
#include "baker/maps/maps.h"
#include "baker/store/parallel.h"
#include "fjell/pack.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

constexpr double sum_of_mips = 4.0 / 3; // 1 + 1/4 + 1/16 + ...
constexpr double not_compressed = 1.01; // what zstd adds at most, and headers of pages

double texels_of(const Tree& tree, std::uint32_t log2_side) {
    return log2_side ? std::ldexp(static_cast<double>(tree.tiles_x) * tree.tiles_y, static_cast<int>(2 * log2_side))
                     : 0;
}

} // namespace

std::uint64_t work_bytes(const Tree& tree, PageOrder order, const MapSizes& maps) {
    const double samples = static_cast<double>(tree.columns()) * tree.rows();
    const double places = static_cast<double>(tree.grid_columns()) * tree.grid_rows();
    const double tiles = static_cast<double>(tree.tiles_x) * tree.tiles_y;
    const double heights = samples * (sizeof(float) + sizeof(std::uint8_t)); // with holes marked
    const double colour = texels_of(tree, maps.colour_log2), normal = texels_of(tree, maps.normal_log2),
                 horizon = texels_of(tree, maps.horizon_log2), splat = texels_of(tree, maps.splat_log2);

    // Filling voids: heights as they were read, filled ones, and the pyramid of means.
    const double filling = heights + samples * sizeof(float) * sum_of_mips;
    // Maps: the last near mip and the one made from it. BC1 takes half a byte a texel, BC5 one.
    const double texel_bytes = sizeof(std::uint16_t) * (static_cast<double>(channels(MapKind::colour)) * colour +
                                                        static_cast<double>(channels(MapKind::normal)) * normal);
    const double texels = texel_bytes / std::pow(4.0, near_mips - 1) * 1.25;
    const double map_chunks = (0.5 * colour + normal) * sum_of_mips * not_compressed;
    // Horizons: levels of the heights, which lie in a rectangle that they fill to two thirds, and BC4 for each plane.
    const double levels = maps.horizon_log2 ? (samples / 4 * 1.6 + 4096) * sizeof(float) : 0;
    const double horizon_texels =
        horizon * sizeof(std::uint16_t) * horizon_planes / std::pow(4.0, near_mips - 1) * 1.25;
    const double horizon_chunks = 0.5 * horizon_planes * horizon * sum_of_mips * not_compressed;
    // Splat maps: the same 16 channels on the way, 8 bytes a texel. They come last.
    const double splat_texels = splat * sizeof(std::uint16_t) * static_cast<double>(channels(MapKind::splat)) /
                                std::pow(4.0, near_mips - 1) * 1.25;
    const double splat_chunks = splat_texel_bytes * splat * sum_of_mips * not_compressed;
    const double all_chunks = map_chunks + horizon_chunks + splat_chunks;
    // Vertices: places and centres of the step above the finest one, its unsaturated errors, records of mixed pages.
    const bool linear = order == PageOrder::linear;
    const int mixed_log2 = linear ? 0 : std::max(tree.tile_log2 - page_squares_log2, 0);
    const double steps = places / 4 * (sizeof(std::uint32_t) + sizeof(CentreRecord)) * 1.25 + places / 4;
    const double mixed = std::ldexp(places, -2 * mixed_log2) * (sizeof(std::uint32_t) + sizeof(std::uint16_t));
    // A vertex: height 2 bytes, error 1; a radius of its own in linear order, else one for 16.
    const double page_chunks = places * (linear ? 4 : 3 + 1.0 / 16) * not_compressed;
    const PageLayout pages{tree.tile_log2, order};
    const double entries = tiles *
                           (pages.pages_per_tile() + mip_count(maps.colour_log2) + mip_count(maps.normal_log2) +
                            mip_count(maps.horizon_log2) + mip_count(maps.splat_log2)) *
                           sizeof(ChunkEntry);
    return static_cast<std::uint64_t>(
        std::max({filling, heights + texels + map_chunks + entries,
                  heights + texels + levels + horizon_texels + splat_texels + all_chunks + entries,
                  heights + steps + mixed + all_chunks + page_chunks + entries}));
}

namespace {

// What the program and GDAL take before any work, and what stays beside it.
constexpr std::uint64_t base_bytes = std::uint64_t{64} << 20;

Tree tiling(const HeightSource& source, const BakeOptions& options) {
    const double extent = std::max((source.columns - 1) * source.spacing_m[0], (source.rows - 1) * source.spacing_m[1]);
    if (extent > max_extent_m)
        throw Failure(1, fmt::format("the terrain would be {:.3g} m wide, more than {:.0e} m; give a smaller --spacing",
                                     extent, max_extent_m));
    return Tree::covering(source.columns, source.rows,
                          options.tile_log2 ? options.tile_log2 : auto_tile_log2(source.columns, source.rows));
}

std::unique_ptr<ImageSource> images_of(const HeightSource& source, const BakeOptions& options) {
    if (options.texture_paths.empty()) return nullptr;
    return open_images(options.texture_paths, frame_of(source), options.texture_bands);
}

Locks locks_of(const HeightSource& source, const BakeOptions& options) {
    Locks locks = options.locks_path.empty() ? Locks{} : Locks(options.locks_path, options.lock_error_m, source);
    locks.add_stamps(source);
    if (!locks.empty() && options.estimate == ErrorEstimate::midpoint)
        throw Failure(2, "locks need errors that are bounds; leave out --estimate midpoint");
    return locks;
}

SplatPlan splat_of(const BakeOptions& options) {
    return options.layers_path.empty() ? SplatPlan{} : read_splat(options.layers_path);
}

std::uint32_t map_log2(double texels_a_side, const BakeOptions& options) {
    return fitting_log2(texels_a_side, std::min(options.max_texture_log2, max_texture_log2));
}

} // namespace

BakeContext::BakeContext(const HeightSource& the_source, const BakeOptions& the_options,
                         const std::string& the_out_path, const Window& the_part)
    : source(the_source), options(the_options), out_path(the_out_path), tree(tiling(source, options)),
      regions(tree, options.region_cells), part(the_part), pages{tree.tile_log2, options.order},
      threads(resolve_threads(options.threads)),
      mixed_log2(options.order == PageOrder::linear ? 0 : std::max(tree.tile_log2 - page_squares_log2, 0)),
      folder(out_path), locks(locks_of(source, options)), image(images_of(source, options)), splat(splat_of(options)),
      splat_images(open_splat_images(splat, frame_of(source))),
      // Colours of a ramp change slowly, and normals carry the detail: half the samples' density.
      colour_log2(map_log2(image ? tree.side() * image->pixels_per_sample() : tree.side() / 2.0, options)),
      normal_log2(map_log2(tree.side(), options)),
      horizon_log2(
          options.horizon_spacing ? map_log2(tree.side() / static_cast<double>(options.horizon_spacing), options) : 0),
      splat_log2(splat.rules.empty() ? 0 : map_log2(tree.side() / static_cast<double>(options.splat_spacing), options)),
      enough_bytes(
          (work_bytes(tree, options.order, {colour_log2, normal_log2, horizon_log2, splat_log2}) + base_bytes) / 3 * 4),
      // Work files that an earlier run has left are gone on with.
      in_memory(part.area() == 0 && !options.checkpoint_s && !std::filesystem::exists(folder.file("checkpoint")) &&
                enough_bytes <= options.memory_bytes) {}

Window BakeContext::region_window() const {
    return part.area() ? part : Window{0, 0, regions.across(), regions.down()};
}

std::int64_t BakeContext::region_at(std::uint64_t u) const {
    if (leaves_out_) return kept_[u];
    const Window r = region_window();
    const auto i = static_cast<std::int64_t>(u);
    return (r.y + i / r.columns) * regions.across() + r.x + i % r.columns;
}

std::uint32_t BakeContext::tile_at(std::uint64_t u) const {
    if (leaves_out_) return kept_tiles_[u];
    const Window t = tile_window();
    const auto i = static_cast<std::int64_t>(u);
    return static_cast<std::uint32_t>((t.y + i / t.columns) * tree.tiles_x + t.x + i % t.columns);
}

void BakeContext::leave_out(const std::function<bool(std::int64_t region)>& keeps) {
    std::vector<std::int64_t> kept;
    std::vector<std::uint32_t> tiles;
    leaves_out_ = false; // of all, whatever was left out before
    for (std::uint64_t u = 0; u < region_window().area(); ++u)
        if (const std::int64_t region = region_at(u); keeps(region)) {
            kept.push_back(region);
            regions.for_each_tile(regions.at(region), [&](std::uint32_t tile, SampleIndex) { tiles.push_back(tile); });
        }
    std::sort(tiles.begin(), tiles.end()); // row by row, as they are without
    kept_ = std::move(kept);
    kept_tiles_ = std::move(tiles);
    leaves_out_ = true;
}

std::string BakeContext::store_path(const std::string& name) const {
    return in_memory ? "" : folder.file(name);
}

std::string BakeContext::temporary() const {
    return std::filesystem::is_character_file(out_path) ? "" : folder.file("pack");
}

std::string BakeContext::identity() const {
    return fmt::format("{}\nregions {}\n{}", source.identity(), regions.cells(), options_identity());
}

std::string BakeContext::options_identity() const {
    const BakeOptions& o = options;
    return fmt::format("tile {} estimate {} nesting {} order {} quantum {} ramp {} texels {} level {} "
                       "place {} {} {} {} {} {} {} horizons {}\n{}",
                       tree.tile_log2, static_cast<int>(o.estimate), o.nesting, static_cast<int>(o.order), o.quantum_m,
                       o.ramp_path.empty() ? "" : io::read_text(o.ramp_path), o.max_texture_log2, o.compression,
                       source.spacing_m[0], source.spacing_m[1], source.crs_origin[0], source.crs_origin[1],
                       source.crs_step[0], source.crs_step[1], source.crs_wkt, o.horizon_spacing,
                       image ? image->identity() : "") +
           splat_identity() + (o.room_for_holes ? "\nroom for holes" : "") +
           (o.room_for_locks ? "\nroom for locks" : "") + locks.identity();
}

std::string BakeContext::splat_identity() const {
    if (splat.rules.empty()) return {};
    std::string text = fmt::format("layers {} {}\n", options.splat_spacing, splat.text);
    for (const auto& raster : splat_images) text += raster->identity();
    return text;
}

int BakeContext::workers_for(std::uint64_t unit_bytes) const {
    const std::uint64_t taken = in_memory ? options.memory_bytes / 4 * 3 : base_bytes;
    const std::uint64_t rest = options.memory_bytes > taken ? options.memory_bytes - taken : 0;
    const std::uint64_t fit = rest / std::max<std::uint64_t>(unit_bytes, 1);
    if (fit == 0 && in_memory) return 1;
    if (fit == 0)
        throw Failure(2, fmt::format("tiles of {} cells need {} MB; give a larger --memory, or a smaller --tile",
                                     tree.side(), (unit_bytes + taken) / 1'000'000 + 1));
    return static_cast<int>(std::min<std::uint64_t>(fit, static_cast<std::uint64_t>(threads)));
}

void BakeContext::run_units(const UnitLoop& loop, const std::function<void(std::uint64_t)>& unit) const {
    std::mutex lock;
    std::uint64_t done = 0;
    parallel_for(static_cast<std::int64_t>(loop.count), loop.workers, [&](std::int64_t i) {
        unit(static_cast<std::uint64_t>(i));
        if (!options.progress) return;
        const std::lock_guard hold(lock);
        ++done;
        options.progress(loop.name, static_cast<std::uint64_t>(static_cast<double>(done) * loop.samples),
                         static_cast<std::uint64_t>(static_cast<double>(loop.count) * loop.samples));
    });
}

} // namespace fjell::baker
