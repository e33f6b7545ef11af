#include "baker/bake/bake.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <malloc.h>
#include <unistd.h>

#include <fmt/format.h>

#include "baker/bake/changed.h"
#include "baker/bake/checkpoint.h"
#include "baker/bake/context.h"
#include "baker/bake/plan.h"
#include "baker/bake/stages.h"
#include "baker/heights/scales.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

std::uint64_t physical_memory_bytes() {
    return static_cast<std::uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 0L)) *
           static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void check(const BakeOptions& options) {
    if (!(options.nesting >= 0.001 && options.nesting <= 1))
        throw Failure(2,
                      "--nesting must lie in 0.001..1: with less, spheres that touch do not nest in float arithmetic "
                      "and the mesh cracks");
    if (options.tile_log2 && (options.tile_log2 < min_tile_log2 || options.tile_log2 > max_tile_log2))
        throw Failure(2, "--tile must be a power of two from 2 to 4096, or auto");
}

// What an earlier run has left is not what its checkpoint speaks of.
struct DamagedWork {};

// One bake, stage by stage. A store is opened (made, or found as an earlier run left it) unless the last stage that
// reads it is complete, and removed when that stage is.
class Bake {
public:
    Bake(const HeightSource& source, const BakeOptions& options, const std::string& out_path)
        : context_(source, options, out_path),
          checkpoint_(context_.in_memory ? "" : context_.folder.file("checkpoint"), context_.identity()) {
        if (!checkpoint_.resumed()) context_.folder.empty();
        context_.folder.keep(false);
        (void)io::AtomicFile(out_path, context_.temporary()); // a pack that cannot be written should not cost an hour
        summary_.resumed = checkpoint_.resumed();
    }
    BakeSummary run();

private:
    void run_stages();
    void make_maps(const BakePlan& plan, const HeightStores& heights);
    void make_horizons(const BakePlan& plan, const HeightStores& heights, TexelStore& texels);
    void make_splat(const BakePlan& plan, const HeightStores& heights, TexelStore& texels);
    void make_far_mips(const BakePlan& plan, MapKind kind, TexelStore finer);
    struct Below { // what a step is made from
        const HeightStores& heights;
        const UnsaturatedStores& unsaturated;
        StepStores& finer;
    };
    void coarser_step(const BakePlan& plan, int z, const Below& below, MixedStores& mixed);

    // Runs a stage unless an earlier run has completed it.
    template <typename Work>
    void stage(StageId id, const Work& work) {
        if (checkpoint_.complete(id)) return;
        work();
        if (spool_ && !context_.in_memory) checkpoint_.state.spool = spool_->state();
        checkpoint_.set_complete(id);
#ifdef __GLIBC__
        if (!context_.in_memory) malloc_trim(0); // what this stage's threads kept for themselves the next one's need
#endif
    }
    [[nodiscard]] bool complete(StageId id) const {
        return checkpoint_.complete(id);
    }
    // For a store that was just opened: what its stage has left, if that was an earlier run's; else nothing.
    template <typename T>
    void check(Store<T>& store, bool made, const Digest& left) const {
        if (!made) return store.clear();
        if (context_.options.progress) context_.options.progress("check", 0, 1);
        if (store.digest() != left) throw DamagedWork{};
    }
    void check_unsaturated(UnsaturatedStores& stores) const;
    void check_step(StepStores& stores, StageId writer) const;
    void check_mixed(MixedStores& stores) const;
    void note_unsaturated(const UnsaturatedStores& stores);
    void note_step(int z, const StepStores& step, const MixedStores& mixed);

    BakeContext context_;
    Checkpoint checkpoint_;
    std::optional<ChunkSpool> spool_;
    bool reads_input_ = false; // what fails now is the input, which may come back
    BakeSummary summary_;
};

void Bake::run_stages() {
    const Tree& tree = context_.tree;
    const Clock::time_point start = Clock::now();
    CheckpointState& found = checkpoint_.state;

    // ---- heights: as they are read, then with voids filled
    Store<float> raw, filled;
    Store<std::uint8_t> holes;
    if (!complete({found.has_voids ? Stage::fill : Stage::finest_step}))
        raw = context_.open<float>("heights", tree.columns(), tree.rows());
    if (raw.exists()) check(raw, complete({Stage::read}), found.stores.heights);
    stage({Stage::read}, [&] {
        reads_input_ = true;
        const ReadResult read = read_result(context_, read_windows(context_, raw));
        reads_input_ = false;
        found.note_source(read.properties, read.has_voids);
        found.stores.heights = raw.written();
    });
    if (found.has_voids && !complete({Stage::finest_step})) {
        filled = context_.open<float>("filled", tree.columns(), tree.rows());
        check(filled, complete({Stage::fill}), found.stores.filled);
        if (found.holes) holes = context_.open<std::uint8_t>("holes", tree.columns(), tree.rows());
        if (found.holes) check(holes, complete({Stage::fill}), found.stores.holes);
    }
    stage({Stage::fill}, [&] {
        const SourceProperties properties{found.native_quantum_m, found.anchor_m, found.holes != 0};
        if (found.has_voids) fill_heights(context_, raw, properties, {filled, holes});
        found.stores.filled = filled.written();
        found.stores.holes = holes.written();
    });
    if (found.has_voids) raw.remove();
    const HeightStores heights{found.has_voids ? filled : raw, holes};
    stage({Stage::measure}, [&] { found.heights = measure_heights(context_, heights); });
    summary_.seconds_read = seconds_since(start);

    // ---- scales and header; from here on chunks of the pack go to the spool
    BakePlan plan = make_plan(context_, found);
    spool_.emplace(context_.store_path("chunks"), context_.store_path("entries"), plan.header, found.spool);
    if (found.spool.bytes != 0 && !spool_->has_found()) throw DamagedWork{};

    const Clock::time_point maps_start = Clock::now();
    make_maps(plan, heights);
    summary_.seconds_textures = seconds_since(maps_start) - summary_.seconds_horizons - summary_.seconds_splat;

    // ---- vertices: the finest step from the heights, each further one from what the step before has left
    const Clock::time_point errors_start = Clock::now();
    const int last_z = tree.tile_log2 - 1;
    UnsaturatedStores unsaturated;
    MixedStores mixed;
    StepStores finer;
    if (last_z > 0 && !complete({Stage::coarser_steps, last_z})) unsaturated = open_unsaturated(context_);
    if (!complete({Stage::mixed_pages})) mixed = open_mixed(context_);
    if (last_z > 0 && !complete({Stage::coarser_steps, 1}))
        finer = context_.in_memory ? open_step_codes(context_) : open_step(context_, 0);
    check_unsaturated(unsaturated);
    check_mixed(mixed);
    check_step(finer, {Stage::finest_step});
    stage({Stage::finest_step}, [&] {
        const FinestStepResult made = make_finest_step(context_, plan, heights, {unsaturated, finer, mixed, *spool_});
        found.ground_error_m = made.ground_error_m;
        found.always_drawn = made.always_drawn;
        found.on_scale = made.on_scale;
        note_unsaturated(unsaturated);
        note_step(0, finer, mixed);
    });
    const auto remove_heights = [&] {
        raw.remove();
        filled.remove();
        holes.remove();
    };
    if (!finer.codes.exists()) remove_heights();
    if (last_z > 0) coarser_step(plan, 1, {heights, unsaturated, finer}, mixed);
    remove_heights();
    for (int z = 2; z <= last_z; ++z) coarser_step(plan, z, {heights, unsaturated, finer}, mixed);
    unsaturated.remove();
    summary_.seconds_errors = seconds_since(errors_start);
    stage({Stage::mixed_pages}, [&] { found.max_error_m = make_mixed_pages(context_, plan, mixed, *spool_); });
    mixed.remove();

    const Clock::time_point write_start = Clock::now();
    plan.header.max_error_m = found.max_error_m;
    const BakeSummary times = std::exchange(summary_, summary_of(context_, found, plan.header));
    summary_.resumed = times.resumed;
    if (!context_.in_memory && !context_.options.checkpoint_s && !times.resumed &&
        context_.enough_bytes <= physical_memory_bytes() / 2)
        summary_.enough_bytes = context_.enough_bytes;
    summary_.seconds_read = times.seconds_read;
    summary_.seconds_textures = times.seconds_textures;
    summary_.seconds_horizons = times.seconds_horizons;
    summary_.seconds_splat = times.seconds_splat;
    summary_.seconds_errors = times.seconds_errors;
    write_pack(context_, plan.header, *spool_, summary_);
    summary_.seconds_write = seconds_since(write_start);
    summary_.seconds_total = seconds_since(start);
}

void Bake::check_unsaturated(UnsaturatedStores& stores) const {
    if (!stores.inside.exists()) return;
    const bool made = complete({Stage::finest_step});
    const StoreDigests& left = checkpoint_.state.stores;
    check(stores.inside, made, left.unsaturated);
    check(stores.south, made, left.unsaturated_south);
    check(stores.east, made, left.unsaturated_east);
}

void Bake::check_step(StepStores& stores, StageId writer) const {
    if (!stores.places.exists()) return; // or in memory, where nothing is found
    check(stores.places, complete(writer), checkpoint_.state.stores.places);
    check(stores.centres, complete(writer), checkpoint_.state.stores.centres);
}

// Steps write their records into one store, one after the other.
void Bake::check_mixed(MixedStores& stores) const {
    if (!stores.records.exists()) return;
    int z = -1; // the last step that was complete
    while (z + 1 < context_.tree.tile_log2 &&
           complete(z < 0 ? StageId{Stage::finest_step} : StageId{Stage::coarser_steps, z + 1}))
        ++z;
    const StoreDigests& left = checkpoint_.state.stores;
    const bool begun = z >= context_.mixed_log2;
    check(stores.heights, begun, left.mixed_heights);
    if (!begun) return stores.records.clear();
    if (records_digest(context_, stores, context_.mixed_log2, z, true) != left.mixed_records) throw DamagedWork{};
}

void Bake::note_unsaturated(const UnsaturatedStores& stores) {
    if (!stores.inside.exists() || context_.in_memory) return;
    StoreDigests& left = checkpoint_.state.stores;
    left.unsaturated = stores.inside.written();
    left.unsaturated_south = stores.south.digest(); // neighbours both write where two borders meet
    left.unsaturated_east = stores.east.digest();
}

void Bake::note_step(int z, const StepStores& step, const MixedStores& mixed) {
    if (context_.in_memory) return;
    StoreDigests& left = checkpoint_.state.stores;
    left.places = step.places.written();
    left.centres = step.centres.written();
    if (z < context_.mixed_log2) return;
    if (z == context_.mixed_log2) left.mixed_heights = mixed.heights.digest();
    left.mixed_records += records_digest(context_, mixed, z, z, false);
}

// below.finer: what the step before has left; afterwards what this one has.
void Bake::coarser_step(const BakePlan& plan, int z, const Below& below, MixedStores& mixed) {
    const bool holes = checkpoint_.state.holes != 0;
    StepStores step;
    if (z < context_.tree.tile_log2 - 1 && !complete({Stage::coarser_steps, z + 1})) step = open_step(context_, z);
    check_step(step, {Stage::coarser_steps, z});
    stage({Stage::coarser_steps, z}, [&] {
        checkpoint_.state.always_drawn += make_coarser_step(
            context_, plan, {z, holes, below.unsaturated, below.finer, &below.heights}, {step, mixed, *spool_});
        note_step(z, step, mixed);
    });
    below.finer.remove();
    below.finer = std::move(step);
}

constexpr StageId far_mip_stage(MapKind kind, std::uint32_t mip) {
    return {Stage::far_mips, static_cast<int>(kind) * 16 + static_cast<int>(mip)};
}

void Bake::make_maps(const BakePlan& plan, const HeightStores& heights) {
    constexpr MapKind kinds[map_kind_count] = {MapKind::colour, MapKind::normal, MapKind::horizon, MapKind::splat};
    constexpr Stage near_stages[map_kind_count] = {Stage::near_maps, Stage::near_maps, Stage::near_horizons,
                                                   Stage::near_splat};
    TexelStore texels[map_kind_count];
    Digest* const left = checkpoint_.state.stores.texels;
    for (const MapKind kind : kinds)
        if (mip_count(plan.maps.log2_side(kind)) > near_mips && !complete(far_mip_stage(kind, near_mips))) {
            TexelStore& last = texels[static_cast<int>(kind)];
            last = open_texels(context_, plan.maps, kind, near_mips - 1);
            check(last, complete({near_stages[static_cast<int>(kind)]}), left[static_cast<int>(kind)]);
        }
    stage({Stage::near_maps}, [&] {
        reads_input_ = true; // images
        make_near_maps(context_, plan, heights, {texels[0], texels[1], *spool_});
        reads_input_ = false;
        for (const int kind : {0, 1}) left[kind] = texels[kind].digest(); // neighbours both write what they share
    });
    if (plan.maps.horizon_log2 != 0) make_horizons(plan, heights, texels[static_cast<int>(MapKind::horizon)]);
    if (plan.maps.splat_log2 != 0) make_splat(plan, heights, texels[static_cast<int>(MapKind::splat)]);
    for (const MapKind kind : kinds) make_far_mips(plan, kind, std::move(texels[static_cast<int>(kind)]));
}

void Bake::make_horizons(const BakePlan& plan, const HeightStores& heights, TexelStore& texels) {
    const Clock::time_point start = Clock::now();
    StoreDigests& left = checkpoint_.state.stores;
    Store<float> levels;
    if (!complete({Stage::near_horizons})) {
        levels = open_levels(context_);
        check(levels, complete({Stage::levels}), left.levels);
    }
    stage({Stage::levels}, [&] {
        make_levels(context_, heights, levels);
        left.levels = levels.written();
    });
    stage({Stage::near_horizons}, [&] {
        make_near_horizons(context_, plan, {heights, levels_in(context_, levels)}, {texels, *spool_});
        left.texels[static_cast<int>(MapKind::horizon)] = texels.digest();
    });
    levels.remove();
    summary_.seconds_horizons = seconds_since(start);
}

void Bake::make_splat(const BakePlan& plan, const HeightStores& heights, TexelStore& texels) {
    const Clock::time_point start = Clock::now();
    stage({Stage::near_splat}, [&] {
        reads_input_ = true; // rasters
        std::optional<Wetness> wetness;
        if (context_.splat.wants_wetness()) wetness = make_wetness(context_, sum_squares(context_, heights.heights));
        make_near_splat(context_, plan, heights, wetness ? &*wetness : nullptr, {texels, *spool_});
        reads_input_ = false;
        checkpoint_.state.stores.texels[static_cast<int>(MapKind::splat)] = texels.digest();
    });
    summary_.seconds_splat = seconds_since(start);
}

// finer: texels of the last near mip.
void Bake::make_far_mips(const BakePlan& plan, MapKind kind, TexelStore finer) {
    const std::uint32_t mips = mip_count(plan.maps.log2_side(kind));
    Digest& left = checkpoint_.state.stores.texels[static_cast<int>(kind)];
    for (std::uint32_t mip = near_mips; mip < mips; ++mip) {
        TexelStore texels;
        if (mip + 1 < mips && !complete(far_mip_stage(kind, mip + 1)))
            texels = open_texels(context_, plan.maps, kind, mip);
        if (texels.exists()) check(texels, complete(far_mip_stage(kind, mip)), left);
        stage(far_mip_stage(kind, mip), [&] {
            make_far_mip(context_, plan, {kind, mip, finer}, {texels, *spool_});
            left = texels.digest();
        });
        finer.remove();
        finer = std::move(texels);
    }
}

BakeSummary Bake::run() {
    const Clock::time_point start = Clock::now();
    try {
        run_stages();
        return summary_;
    } catch (const Failure& failure) {
        constexpr double usual_s = 5;
        const bool interrupted = failure.exit_code == 130;
        const bool input_lost =
            failure.exit_code == 1 && reads_input_ &&
            (summary_.resumed || seconds_since(start) > context_.options.checkpoint_s.value_or(usual_s));
        // Nothing to go on from: no stage is complete, or it lies in memory, or beside a device, where nobody finds it.
        const bool goes_on = checkpoint_.state.complete > 0 && !context_.in_memory && !context_.temporary().empty();
        if (interrupted && !goes_on) throw Failure(130, "interrupted; nothing is left behind");
        if (!goes_on || (!interrupted && !input_lost)) throw;
        context_.folder.keep();
        throw Failure(failure.exit_code,
                      fmt::format("{}; the same command goes on from there, or delete {}",
                                  interrupted ? "interrupted" : failure.what(), context_.folder.path()));
    }
}

} // namespace

std::vector<std::string> remarks(const BakeSummary& s) {
    std::vector<std::string> lines;
    for (const RepeatedHeight* r : {&s.lowest, &s.highest})
        if (r->share > 0)
            lines.push_back(fmt::format("{:.2g}% of the heights are {:.6g} m, the {}, the first at column {}, row {}: "
                                        "taken as ground; if they are voids, give --void {}",
                                        100 * r->share, r->height_m, r == &s.lowest ? "lowest" : "highest", r->column,
                                        r->row, number_text(r->number)));
    if (s.quantum_range_m > 0)
        lines.push_back(
            fmt::format("the quantum is {:.4g} m because 65536 steps of 16 bits span the {:.6g} m within one "
                        "tile; smaller tiles (--tile) keep finer steps",
                        s.quantum_m, s.quantum_range_m));
    if (s.enough_bytes > 0)
        lines.push_back(fmt::format("it worked in files beside the pack; with --memory {} it stays in memory, which "
                                    "takes less time",
                                    (s.enough_bytes >> 20) + 1));
    return lines;
}

namespace {

// Programs that go on after a bake want the memory for other things.
struct MemoryReleased {
    MemoryReleased() = default;
    MemoryReleased(const MemoryReleased&) = delete;
    MemoryReleased& operator=(const MemoryReleased&) = delete;
    ~MemoryReleased() { release_kept(); }
};

} // namespace

BakeSummary bake(const HeightSource& source, const BakeOptions& options, const std::string& out_path) {
    check(options);
    const MemoryReleased at_the_end;
    ChangedBake changed;
    if (options.keep_unchanged) changed = bake_changed(source, options, out_path);
    if (changed.done) return *changed.done;
    const auto whole = [&] {
        BakeSummary summary = Bake(source, options, out_path).run();
        summary.kept_nothing = changed.why_not;
        return summary;
    };
    try {
        return whole();
    } catch (const DamagedWork&) { // its folder is gone by now
        BakeSummary summary = whole();
        summary.work_damaged = true;
        return summary;
    }
}

} // namespace fjell::baker
