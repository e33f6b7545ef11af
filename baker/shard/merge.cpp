#include "baker/shard/merge.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "baker/bake/plan.h"
#include "baker/bake/stages.h"
#include "baker/shard/shard_chunks.h"
#include "baker/shard/shard_step.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t piece_values = std::size_t{1} << 20;

class Merge {
public:
    Merge(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options, const std::string& out_path)
        : plan_(plan), context_(source, options, out_path), last_{ShardStep::Kind::errors, plan.rounds - 1} {
        context_.folder.empty();
        context_.folder.keep(false);
        for (const ShardStep& step : shard_steps(plan.rounds))
            for (int shard = 1; shard <= plan.shards; ++shard) (void)require_record(plan, step, shard);
    }
    BakeSummary run();

private:
    [[nodiscard]] PartWindows windows_of(int shard) const {
        return {context_.tree, context_.regions, plan_.parts[static_cast<std::size_t>(shard) - 1]};
    }
    template <typename Visit>
    void for_each_shard(const Visit& visit) const {
        for (int shard = 1; shard <= plan_.shards; ++shard)
            if (!plan_.empty(shard)) visit(shard, windows_of(shard));
    }
    // Copies what all shards have left of a store into the whole of it; take: every take-th column and row, of each
    // axis.
    template <typename T, typename HeldOf>
    void gather(const ShardStep& step, const std::string& name, const Window& whole, std::int32_t take_x,
                std::int32_t take_y, const HeldOf& held_of, Store<T>& to) const;
    [[nodiscard]] UnsaturatedStores gather_unsaturated() const;
    void make_steps(const BakePlan& plan, const CheckpointState& found, MixedStores& mixed, ChunkSpool& spool) const;
    void make_mips(const BakePlan& plan, ChunkSpool& spool) const;

    const ShardPlan& plan_;
    BakeContext context_;
    const ShardStep last_;
};

template <typename T, typename HeldOf>
void Merge::gather(const ShardStep& step, const std::string& name, const Window& whole, std::int32_t take_x,
                   std::int32_t take_y, const HeldOf& held_of, Store<T>& to) const {
    for_each_shard([&](int shard, const PartWindows& windows) {
        const ShardRecord record = require_record(plan_, step, shard);
        const std::string path = plan_.file(step, shard, name);
        const Window held = held_of(windows);
        const Store<T> from = Store<T>::complete(path, whole.columns, whole.rows, held);
        if (from.digest() != record.files.at(name).digest)
            throw Failure(1, fmt::format("{}: is damaged; run {} --again", path, plan_.command(step, shard)));
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

void Merge::make_steps(const BakePlan& plan, const CheckpointState& found, MixedStores& mixed,
                       ChunkSpool& spool) const {
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
        make_coarser_step(context_, plan, {z, found.holes != 0, unsaturated, finer}, {step, mixed, spool});
        finer.remove();
        finer = std::move(step);
    }
    unsaturated.remove();
}

void Merge::make_mips(const BakePlan& plan, ChunkSpool& spool) const {
    const std::uint32_t left = mip_of_round(plan_.rounds - 1); // the last that shards have made
    for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
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

BakeSummary Merge::run() {
    const Clock::time_point start = Clock::now();
    CheckpointState found = found_by_shards(plan_, context_, true);
    BakePlan plan = make_plan(context_, found);
    ChunkSpool spool(context_.store_path("chunks"), context_.store_path("entries"), plan.header, {});
    make_mips(plan, spool);
    MixedStores mixed = open_mixed(context_);
    make_steps(plan, found, mixed, spool);
    found.max_error_m = make_mixed_pages(context_, plan, mixed, spool);
    mixed.remove();
    for_each_shard([&](int shard, const PartWindows&) {
        const std::vector<std::byte> bytes = read_parcel(plan_, {ShardStep::Kind::errors, 0}, shard, "facts");
        found.ground_error_m = std::max(found.ground_error_m, ParcelReader(bytes).get<float>());
    });
    plan.header.max_error_m = found.max_error_m;
    BakeSummary summary = summary_of(context_, found, plan.header);
    write_pack(context_, plan.header, ShardChunks(plan_, plan.header, spool), summary);
    summary.seconds_total = std::chrono::duration<double>(Clock::now() - start).count();
    return summary;
}

} // namespace

BakeSummary merge_shards(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                         const std::string& out_path) {
    check_source(plan, source);
    return Merge(plan, source, options, out_path).run();
}

} // namespace fjell::baker
