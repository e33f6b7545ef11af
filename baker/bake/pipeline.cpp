#include "baker/bake/pipeline.h"

#include <algorithm>
#include <cmath>

#include <malloc.h>

#include <fmt/format.h>

#include "baker/bake/parallel.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

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
    return open_images(options.texture_paths, frame_of(source));
}

} // namespace

Pipeline::Pipeline(const HeightSource& source, const BakeOptions& options, const std::string& out_path)
    : source_(source), options_(options), out_path_(out_path), tree_(tiling(source, options)),
      regions_(tree_, options.region_cells), pages_{tree_.tile_log2, options.order},
      threads_(resolve_threads(options.threads)),
      plain_z_(options.order == Order::linear ? 0 : std::max(tree_.tile_log2 - page_squares_log2, 0)),
      folder_(out_path), in_memory_(fits_memory()), image_(images_of(source, options)),
      ledger_(folder_.file("ledger"), identity()), last_checkpoint_(Clock::now()) {
    if (!ledger_.resumed()) folder_.empty();
    folder_.keep(false);
    (void)io::AtomicFile(out_path_, temporary()); // a pack that cannot be written should not cost an hour
}

std::string Pipeline::temporary() const {
    return std::filesystem::is_character_file(out_path_) ? "" : folder_.file("pack");
}

// What all stores take together at their most: heights, the finest step's places and centres, texels between mips, the
// pack's chunks. (Where there are voids: heights twice, before the others come.)
bool Pipeline::fits_memory() const {
    if (options_.checkpoint_s || std::filesystem::exists(folder_.file("ledger"))) return false;
    constexpr double bytes_per_sample = 13;
    const double stores = bytes_per_sample * tree_.grid_columns() * tree_.grid_rows();
    return stores + static_cast<double>(base_bytes) <= 0.75 * static_cast<double>(options_.memory_bytes);
}

std::string Pipeline::identity() const {
    const BakeOptions& o = options_;
    return fmt::format("{}\ntile {} regions {} estimate {} nesting {} order {} quantum {} ramp {} texels {} level {} "
                       "place {} {} {} {} {} {} {}\n{}",
                       source_.identity(), tree_.tile_log2, regions_.cells(), static_cast<int>(o.estimate), o.nesting,
                       static_cast<int>(o.order), o.quantum_m, o.ramp_path.empty() ? "" : io::read_text(o.ramp_path),
                       o.max_texture_log2, o.compression, source_.spacing_m[0], source_.spacing_m[1],
                       source_.origin_m[0], source_.origin_m[1], source_.crs_step[0], source_.crs_step[1],
                       source_.crs_wkt, image_ ? image_->identity() : "");
}

int Pipeline::workers_for(std::uint64_t bytes) const {
    const std::uint64_t taken = in_memory_ ? options_.memory_bytes / 4 * 3 : base_bytes;
    const std::uint64_t rest = options_.memory_bytes > taken ? options_.memory_bytes - taken : 0;
    const std::uint64_t fit = rest / std::max<std::uint64_t>(bytes, 1);
    if (fit == 0 && in_memory_) return 1;
    if (fit == 0)
        throw Failure(2, fmt::format("tiles of {} cells need {} MB; give a larger --memory, or a smaller --tile",
                                     tree_.side(), (bytes + taken) / 1'000'000 + 1));
    return static_cast<int>(std::min<std::uint64_t>(fit, static_cast<std::uint64_t>(threads_)));
}

void Pipeline::run_units(const StageRun& stage, const std::function<void(std::uint64_t)>& unit) {
    LedgerState& state = ledger_.state;
    const std::uint64_t start = state.stage == stage.index ? state.done : 0;
    state.stage = stage.index;
    state.done = start;
    std::vector<char> complete(stage.count, 0);
    std::fill_n(complete.begin(), start, char{1});
    parallel_for(static_cast<std::int64_t>(stage.count - start), stage.workers, [&](std::int64_t i) {
        const std::uint64_t u = start + static_cast<std::uint64_t>(i);
        unit(u);
        const std::lock_guard hold(lock_);
        complete[u] = 1;
        // Only what is complete from the first unit on is remembered; units after a gap are made again.
        const std::uint64_t before = state.done;
        while (state.done < stage.count && complete[state.done]) ++state.done;
        if (stage.in_order)
            for (std::uint64_t k = before; k < state.done; ++k) stage.in_order(k);
        if (seconds_since(last_checkpoint_) >= checkpoint_s()) checkpoint();
        if (options_.progress)
            options_.progress(stage.name, static_cast<std::uint64_t>(static_cast<double>(state.done) * stage.each),
                              static_cast<std::uint64_t>(static_cast<double>(stage.count) * stage.each));
    });
}

void Pipeline::checkpoint() {
    last_checkpoint_ = Clock::now();
    if (in_memory_) return;
    if (spool_) ledger_.state.spool_bytes = spool_->bytes();
    ledger_.write();
}

void Pipeline::finish(std::uint32_t stage) {
    ledger_.state.stage = stage + 1;
    ledger_.state.done = 0;
    checkpoint();
#ifdef __GLIBC__
    malloc_trim(0); // what this stage's threads kept for themselves the next one's need
#endif
}

PackHeader Pipeline::make_header() const {
    PackHeader h{};
    const Survey& survey = ledger_.state.survey;
    h.columns = static_cast<std::uint32_t>(tree_.columns());
    h.rows = static_cast<std::uint32_t>(tree_.rows());
    h.tiles_x = static_cast<std::uint32_t>(tree_.tiles_x);
    h.tiles_y = static_cast<std::uint32_t>(tree_.tiles_y);
    h.tile_log2 = static_cast<std::uint32_t>(tree_.tile_log2);
    h.order = options_.order;
    h.estimate = options_.estimate;
    h.nesting = static_cast<float>(options_.nesting);
    std::copy_n(source_.spacing_m, 2, h.spacing_m);
    std::copy_n(source_.origin_m, 2, h.origin_m);
    for (const int axis : {0, 1}) h.crs_step[axis] = std::clamp(source_.crs_step[axis], 0.0, 1e9);
    h.base_m = height_scale_.base_m;
    h.quantum_m = height_scale_.quantum_m;
    std::int32_t least = 0, most = 0;
    quantise(&survey.least_m, 1, height_scale_, &least);
    quantise(&survey.most_m, 1, height_scale_, &most);
    h.min_m = height_scale_.height_m(least);
    h.max_m = height_scale_.height_m(most);
    h.height_steps = static_cast<std::uint32_t>(most);
    h.error_floor_m = scales_.floor_m;
    h.error_ratio = scales_.ratio;
    h.error_nesting_steps = scales_.nesting_steps;
    std::copy_n(scales_.level_radius_m, 2 * tree_.tile_log2, h.level_radius_m);
    h.voids = survey.voids;
    h.colour_log2 = maps_.colour_log2;
    h.normal_log2 = maps_.normal_log2;
    h.crs_bytes = static_cast<std::uint32_t>(source_.crs_wkt.size());
    return h;
}

// What a reader would refuse is refused before the work.
void Pipeline::check_header() const {
    const Status s = check_ranges(header_);
    if (s.ok()) return;
    throw Failure(
        1, fmt::format("no pack can hold this terrain: its {} is out of range ({} x {} samples, {} m apart, heights "
                       "{:.6g}..{:.6g} m in steps of {:.3g} m); change --spacing, --zscale or --zoffset, or cut the "
                       "height field",
                       s.field, tree_.columns(), tree_.rows(), source_.spacing_m[0], height_scale_.base_m,
                       header_.max_m, height_scale_.quantum_m));
}

void Pipeline::plan() {
    const Survey& survey = ledger_.state.survey;
    height_scale_ = choose_height_scale(
        survey, {{source_.spacing_m[0], source_.spacing_m[1]}, ledger_.state.native_quantum_m, options_.quantum_m});
    // The stored float is what readers test against.
    const double nesting = static_cast<double>(static_cast<float>(options_.nesting));
    scales_ = choose_scales({tree_, {source_.spacing_m[0], source_.spacing_m[1]}, height_scale_, survey, nesting});
    leaf_.emplace(scales_.errors, height_scale_.quantum_m);
    plan_maps();
    header_ = make_header();
    check_header();
    spool_.emplace(file("chunks"), file("entries"), header_, ledger_.state.spool_bytes);
}

BakeSummary Pipeline::run() {
    const auto start = Clock::now();
    BakeSummary summary;
    summary.resumed = ledger_.resumed();
    try {
        read();
        fill();
        survey();
        summary.seconds_read = seconds_since(start);
        plan();
        const auto maps_start = Clock::now();
        make_maps();
        summary.seconds_textures = seconds_since(maps_start);
        const auto errors_start = Clock::now();
        vertices();
        for (int z = 1; z < tree_.tile_log2; ++z) level(z);
        summary.seconds_errors = seconds_since(errors_start);
        plain_pages();
        const auto write_start = Clock::now();
        summary.file_bytes = assemble(summary);
        summary.seconds_write = seconds_since(write_start);
    } catch (const Failure& failure) {
        const bool interrupted = failure.exit_code == 130;
        const bool input_lost =
            failure.exit_code == 1 && input_at_work_ && (summary.resumed || seconds_since(start) > checkpoint_s());
        const bool goes_on = !in_memory_ && !temporary().empty(); // a device's folder nobody finds again
        if (interrupted && !goes_on) throw Failure(130, "interrupted; nothing is left behind");
        if (!goes_on || (!interrupted && !input_lost)) throw;
        checkpoint();
        folder_.keep();
        throw Failure(failure.exit_code, fmt::format("{}; the same command goes on from there, or delete {}",
                                                     interrupted ? "interrupted" : failure.what(), folder_.path()));
    }
    summary.columns = tree_.columns();
    summary.rows = tree_.rows();
    summary.tree = tree_;
    summary.quantum_m = height_scale_.quantum_m;
    summary.max_error_m = ledger_.state.max_error_m;
    summary.voids = header_.voids;
    summary.seconds_total = seconds_since(start);
    return summary;
}

// Pages in the order they are wanted in: page 0 of all tiles, then step by step, so that a prefix of the file is the
// whole terrain, coarser. Linear order knows no steps: tile by tile.
std::vector<ChunkId> Pipeline::chunk_sequence() const {
    std::vector<ChunkId> sequence{{ChunkKind::corners, 0, 0}};
    const std::uint32_t tiles = header_.tiles_x * header_.tiles_y, pages = pages_.pages_per_tile();
    const auto add_pages = [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t page = from; page < to; ++page) sequence.push_back({ChunkKind::geometry, tile, page});
    };
    if (options_.order == Order::linear) {
        add_pages(0, pages);
    } else {
        add_pages(0, 1);
        for (std::uint32_t page = 1; page < pages;) {
            std::uint32_t end = page;
            while (end < pages && pages_.page_step_log2(end) == pages_.page_step_log2(page)) ++end;
            add_pages(page, end);
            page = end;
        }
    }
    const auto add_maps = [&](ChunkKind kind, std::uint32_t log2_side) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t mip = 0; mip < mip_count(log2_side); ++mip) sequence.push_back({kind, tile, mip});
    };
    add_maps(ChunkKind::colour, header_.colour_log2);
    add_maps(ChunkKind::normal, header_.normal_log2);
    if (header_.crs_bytes) sequence.push_back({ChunkKind::crs, 0, 0});
    return sequence;
}

std::uint64_t Pipeline::assemble(BakeSummary& summary) {
    header_.max_error_m = ledger_.state.max_error_m;
    const std::vector<ChunkId> sequence = chunk_sequence();
    io::AtomicFile out(out_path_, temporary());
    const std::uint64_t bytes = assemble_pack(header_, *spool_, sequence, out, [&](std::uint64_t n) {
        if (options_.progress) options_.progress("write", n, sequence.size());
    });
    const std::vector<ChunkEntry> entries = spool_->entries();
    const std::uint64_t maps = chunk_index(header_, {ChunkKind::colour, 0, 0}),
                        end = entries.size() - (header_.crs_bytes ? 1 : 0);
    for (std::uint64_t i = 0; i < end; ++i)
        (i < maps ? summary.geometry_bytes : summary.texture_bytes) += entries[i].stored_bytes;
    summary.directory_bytes = maps * sizeof(ChunkEntry) + sizeof(PackHeader);
    out.commit();
    return bytes;
}

} // namespace fjell::baker
