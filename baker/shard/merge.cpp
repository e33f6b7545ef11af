#include "baker/shard/merge.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "baker/bake/plan.h"
#include "baker/bake/stages.h"
#include "baker/shard/shard_chunks.h"
#include "baker/shard/shard_ground.h"
#include "baker/shard/shard_step.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t piece_values = std::size_t{1} << 20;

template <typename T>
bool has_any(const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    return std::any_of(bytes.begin(), bytes.end(), [](std::byte b) { return b != std::byte{0}; });
}

class Merge {
public:
    Merge(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options, const std::string& out_path)
        : plan_(plan), context_(source, options, out_path),
          ground_(plan, context_), last_{ShardStep::Kind::errors, plan.rounds - 1} {
        context_.folder.empty();
        context_.folder.keep(false);
        for (const ShardStep& step : shard_steps(plan.rounds))
            for (int shard = 1; shard <= plan.shards; ++shard) (void)require_record(plan, step, shard);
        if (!needs_all_heights(context_)) ground_.find(found_by_shards(plan, context_, false).holes != 0);
        if (ground_.leaves_out()) context_.leave_out([&](std::int64_t region) { return ground_.bakes(region); });
    }
    BakeSummary to_pack();
    MergedSet to_set(const SetGrid& grid, const std::string& folder);

private:
    [[nodiscard]] PartWindows windows_of(int shard) const {
        return {context_.tree, context_.regions, plan_.parts[static_cast<std::size_t>(shard) - 1]};
    }
    template <typename Visit>
    void for_each_shard(const Visit& visit) const {
        for (int shard = 1; shard <= plan_.shards; ++shard)
            if (!ground_.idles(shard)) visit(shard, windows_of(shard));
    }
    // Copies what all shards have left of a store into the whole of it; take: every take-th column and row, of each
    // axis.
    template <typename T, typename HeldOf>
    void gather(const ShardStep& step, const std::string& name, const Window& whole, std::int32_t take_x,
                std::int32_t take_y, const HeldOf& held_of, Store<T>& to) const;
    [[nodiscard]] UnsaturatedStores gather_unsaturated() const;
    void make_steps(const BakePlan& plan, CheckpointState& found, MixedStores& mixed, ChunkSpool& spool) const;
    void make_mips(const BakePlan& plan, ChunkSpool& spool) const;
    // Everything but the pack: all chunks, in files of shards and in one of the merge's own.
    struct Made {
        CheckpointState found;
        BakePlan plan;
        std::unique_ptr<ChunkSpool> spool;
        BakeSummary summary;
    };
    [[nodiscard]] Made make_rest() const;
    [[nodiscard]] Store<std::uint8_t> holes_of(int shard, const MapPlan& maps) const;
    [[nodiscard]] std::uint64_t voids_in(const Window& samples, const MapPlan& maps) const;

    const ShardPlan& plan_;
    BakeContext context_;
    ShardGround ground_;
    const ShardStep last_;
    const Clock::time_point start_ = Clock::now();
};

template <typename T, typename HeldOf>
void Merge::gather(const ShardStep& step, const std::string& name, const Window& whole, std::int32_t take_x,
                   std::int32_t take_y, const HeldOf& held_of, Store<T>& to) const {
    for_each_shard([&](int shard, const PartWindows& windows) {
        const ShardRecord record = require_record(plan_, step, shard);
        const std::string path = plan_.file(step, shard, name);
        const Window held = held_of(windows);
        const Store<T> from = Store<T>::complete(path, whole.columns, whole.rows, held);
        if (from.digest() != record.files.at(name).digest) throw Failure(1, plan_.damage(step, shard, path));
        const auto most = static_cast<std::int32_t>(
            std::clamp<std::size_t>(piece_values / static_cast<std::size_t>(held.columns), 1, 1024));
        std::vector<T> values, taken;
        // Parts begin at multiples of what is taken.
        for (std::int32_t y = 0; y < held.rows; y += take_y == 1 ? most : take_y) {
            const std::int32_t rows = take_y == 1 ? std::min(most, held.rows - y) : 1;
            const Window w{held.x, held.y + y, held.columns, rows};
            values.resize(w.area());
            from.read(w, values.data(), w.columns);
            const std::int32_t columns = (held.columns - 1) / take_x + 1;
            taken.clear();
            for (std::int32_t row = 0; row < rows; ++row)
                for (std::int32_t x = 0; x < held.columns; x += take_x)
                    taken.push_back(values[static_cast<std::size_t>(row) * static_cast<std::size_t>(held.columns) +
                                           static_cast<std::size_t>(x)]);
            if (!ground_.leaves_out() || has_any(taken)) // where nothing is baked nothing is stored
                to.write({held.x / take_x, (held.y + y) / take_y, columns, rows}, taken.data(), columns);
        }
    });
}

UnsaturatedStores Merge::gather_unsaturated() const {
    const ShardStep first{ShardStep::Kind::errors, 0};
    const std::int32_t take = 1 << (plan_.rounds - 1);
    const Window all = places_of(context_.tree, 1);
    UnsaturatedStores stores = open_unsaturated(context_, plan_.rounds);
    gather(
        first, "unsaturated", all, take, take, [](const PartWindows& w) { return w.places(1); }, stores.inside);
    gather(
        first, "south", {0, 0, all.columns, context_.regions.down()}, take, 1,
        [](const PartWindows& w) { return w.south(1); }, stores.south);
    gather(
        first, "east", {0, 0, all.rows, context_.regions.across()}, take, 1,
        [](const PartWindows& w) { return w.east(1); }, stores.east);
    return stores;
}

void Merge::make_steps(const BakePlan& plan, CheckpointState& found, MixedStores& mixed, ChunkSpool& spool) const {
    const int first = plan_.rounds, last_z = context_.tree.tile_log2 - 1;
    UnsaturatedStores unsaturated = gather_unsaturated();
    StepStores finer = open_step(context_, first - 1);
    const Window all = places_of(context_.tree, first);
    gather(
        last_, "places", all, 1, 1, [&](const PartWindows& w) { return w.places(first); }, finer.places);
    gather(
        last_, "centres", {0, 0, all.columns - 1, all.rows - 1}, 1, 1,
        [&](const PartWindows& w) { return w.centres(first - 1); }, finer.centres);
    for (int z = first; z <= last_z; ++z) {
        StepStores step;
        if (z < last_z) step = open_step(context_, z);
        found.always_drawn +=
            make_coarser_step(context_, plan, {z, found.holes != 0, unsaturated, finer}, {step, mixed, spool});
        finer.remove();
        finer = std::move(step);
    }
    unsaturated.remove();
}

void Merge::make_mips(const BakePlan& plan, ChunkSpool& spool) const {
    const std::uint32_t left = mip_of_round(plan_.rounds - 1); // the last that shards have made
    for (const MapKind kind : all_map_kinds) {
        if (!leaves_texels(plan.maps, kind, left)) continue;
        TexelStore finer = open_texels(context_, plan.maps, kind, left);
        const Window grid{0, 0, static_cast<std::int32_t>(finer.columns()), static_cast<std::int32_t>(finer.rows())};
        gather(
            last_, texel_name(kind, left), grid, 1, 1,
            [&](const PartWindows& w) { return w.texels(plan.maps, kind, left); }, finer);
        const std::uint32_t mips = mip_count(plan.maps.log2_side(kind));
        for (std::uint32_t mip = left + 1; mip < mips; ++mip) {
            TexelStore texels;
            if (mip + 1 < mips) texels = open_texels(context_, plan.maps, kind, mip);
            make_far_mip(context_, plan, {kind, mip, finer}, {texels, spool});
            finer.remove();
            finer = std::move(texels);
        }
    }
}

Merge::Made Merge::make_rest() const {
    Made made{found_by_shards(plan_, context_, true), {}, nullptr, {}};
    made.plan = make_plan(context_, made.found);
    PackHeader& header = made.plan.header;
    made.spool = std::make_unique<ChunkSpool>(context_.store_path("chunks"), context_.store_path("entries"), header,
                                              SpoolState{});
    make_mips(made.plan, *made.spool);
    MixedStores mixed = open_mixed(context_);
    make_steps(made.plan, made.found, mixed, *made.spool);
    made.found.max_error_m = make_mixed_pages(context_, made.plan, mixed, *made.spool);
    mixed.remove();
    made.found.on_scale = 1;
    for_each_shard([&](int shard, const PartWindows&) {
        for (int z = 0; z < plan_.rounds; ++z) {
            const std::vector<std::byte> bytes = read_parcel(plan_, {ShardStep::Kind::errors, z}, shard, "facts");
            ParcelReader facts(bytes);
            made.found.always_drawn += facts.get<std::uint64_t>();
            if (z != 0) continue;
            made.found.ground_error_m = std::max(made.found.ground_error_m, facts.get<float>());
            made.found.on_scale = facts.get<std::uint32_t>() & made.found.on_scale;
        }
    });
    header.max_error_m = made.found.max_error_m;
    made.summary = summary_of(context_, made.found, header);
    return made;
}

Store<std::uint8_t> Merge::holes_of(int shard, const MapPlan& maps) const {
    const ShardStep step{ShardStep::Kind::measure};
    const std::string path = plan_.file(step, shard, "holes");
    const std::int32_t frame = height_frame(maps, context_.options.whole_level_vertices);
    Store<std::uint8_t> holes = Store<std::uint8_t>::complete(path, context_.tree.columns(), context_.tree.rows(),
                                                              with_frame(windows_of(shard), frame));
    if (holes.digest() != require_record(plan_, step, shard).files.at("holes").digest)
        throw Failure(1, plan_.damage(step, shard, path));
    return holes;
}

// As shards have marked them, each of its own samples.
std::uint64_t Merge::voids_in(const Window& samples, const MapPlan& maps) const {
    constexpr std::int32_t band = 64;
    if (ground_.leaves_out() && !ground_.in_samples(samples)) return samples.area();
    std::uint64_t voids = 0;
    for_each_shard([&](int shard, const PartWindows& windows) {
        const Window mine = common(windows.samples(), samples);
        if (mine.area() == 0) return;
        const Store<std::uint8_t> holes = holes_of(shard, maps);
        std::vector<std::uint8_t> marks;
        for (std::int32_t y = 0; y < mine.rows; y += band) {
            io::check_interrupt();
            const Window w{mine.x, mine.y + y, mine.columns, std::min(band, mine.rows - y)};
            marks.resize(w.area());
            holes.read(w, marks.data(), w.columns);
            voids += static_cast<std::uint64_t>(std::count(marks.begin(), marks.end(), std::uint8_t{1}));
        }
    });
    return voids;
}

BakeSummary Merge::to_pack() {
    Made made = make_rest();
    const PackHeader& header = made.plan.header;
    write_pack(context_, header, ShardChunks(plan_, header, *made.spool, ground_), made.summary);
    made.summary.seconds_total = std::chrono::duration<double>(Clock::now() - start_).count();
    return made.summary;
}

MergedSet Merge::to_set(const SetGrid& grid, const std::string& folder) {
    Made made = make_rest();
    const PackHeader& header = made.plan.header;
    const ShardChunks chunks(plan_, header, *made.spool, ground_);
    const std::string notes = notes_of(context_, made.summary);
    const Progress& progress = context_.options.progress;
    MergedSet merged;
    merged.set =
        write_set({header, chunks, notes, [&](const Window& samples) { return voids_in(samples, made.plan.maps); }},
                  grid, folder, context_.folder.path(), [&](std::uint64_t done, std::uint64_t total) {
                      if (progress) progress("write", done, total);
                  });
    count_bytes(header, chunks.entries(), made.summary);
    made.summary.file_bytes = merged.set.file_bytes;
    made.summary.seconds_total = std::chrono::duration<double>(Clock::now() - start_).count();
    merged.bake = made.summary;
    return merged;
}

} // namespace

void check_packs(const ShardPlan& plan, const std::optional<SetGrid>& grid) {
    if (plan.packs && plan.packs != grid)
        throw Failure(2, fmt::format("{}: was planned for a set of {}x{} packs, and ground outside them was not baked; "
                                     "give --packs {}x{}, or plan anew into another folder",
                                     plan.folder, plan.packs->packs_x, plan.packs->packs_y, plan.packs->packs_x,
                                     plan.packs->packs_y));
    if (!grid) return;
    const Tree tree = Tree::covering(plan.columns, plan.rows, plan.tile_log2);
    check_grid(*grid, static_cast<std::uint32_t>(tree.tiles_x), static_cast<std::uint32_t>(tree.tiles_y), plan.folder);
}

BakeSummary merge_shards(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                         const std::string& out_path) {
    check_source(plan, source);
    if (plan.packs) check_packs(plan, {});
    remove_dead_attempts(plan);
    return Merge(plan, source, options, out_path).to_pack();
}

MergedSet merge_shards_to_set(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                              const SetGrid& grid, const std::string& folder) {
    check_source(plan, source);
    check_packs(plan, grid);
    remove_dead_attempts(plan);
    make_set_folder(folder);
    return Merge(plan, source, options, set_work_name(folder)).to_set(grid, folder);
}

} // namespace fjell::baker
