#include "baker/shard/shard_fill.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "baker/shard/seam.h"

namespace fjell::baker {

namespace {

constexpr ShardStep means_step{ShardStep::Kind::means};

std::string mean_name(std::size_t level) {
    return fmt::format("means{}", level);
}

} // namespace

ShardFill::ShardFill(const ShardPlan& plan, const BakeContext& context, int shard, std::int32_t frame,
                     ScratchFolder& scratch)
    : plan_(plan), context_(context), shard_(shard),
      // What is filled around a part becomes half as wide with each level, and half the halo and a little wider: 24 at
      // most, or little more than half of the first.
      mean_frame_(std::max(frame / 2 + 12, 24) + fill_halo),
      scratch_(scratch), levels_{{0, 0, context.tree.columns(), context.tree.rows()}} {
    while (levels_.size() <= most_mean_levels && (levels_.back().columns > 1 || levels_.back().rows > 1))
        levels_.push_back({0, 0, (levels_.back().columns + 1) / 2, (levels_.back().rows + 1) / 2});
    needs_.push_back(with_frame({context.tree, context.regions, context.region_window()}, frame));
    for (std::size_t level = 1; level < levels_.size(); ++level)
        needs_.push_back(seen_coarser(needs_.back(), levels_[level - 1], levels_[level]));
}

// Parts begin at multiples of 2^most_mean_levels, so that no mean lies in two of them.
Window ShardFill::held_of(int shard, std::size_t level) const {
    const Window own = context_.regions.samples_of(plan_.parts[static_cast<std::size_t>(shard) - 1]);
    const std::int32_t unit = 1 << level;
    const auto end = [&](std::int32_t last) { return (last + unit - 1) / unit; };
    const std::int32_t x = own.x / unit, y = own.y / unit;
    return {x, y, end(own.x + own.columns) - x, end(own.y + own.rows) - y};
}

void ShardFill::leave_means(const Store<float>& raw) {
    const int threads = context_.workers_for(fill_piece_bytes);
    std::vector<Store<float>> means;
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        const Window held = held_of(shard_, level);
        means.emplace_back(scratch_.file(mean_name(level)), levels_[level].columns, levels_[level].rows, held);
        (void)halve_heights(level == 1 ? raw : means[level - 2], held, threads, means.back());
        scratch_.write_parcel(mean_name(level) + "-frame", frame_of_store(means.back(), mean_frame_, mean_frame_));
        scratch_.add(mean_name(level), means.back().digest());
    }
    const Window held = held_of(shard_, levels_.size() - 1);
    std::vector<float> coarsest(held.area());
    (means.empty() ? raw : means.back()).read(held, coarsest.data(), held.columns);
    ParcelWriter parcel;
    parcel.put_all(std::span<const float>(coarsest));
    scratch_.write_parcel("coarsest", parcel.bytes);
}

Store<float> ShardFill::gather_coarsest() const {
    const std::size_t level = levels_.size() - 1;
    const Window& all = levels_[level];
    Store<float> means("", all.columns, all.rows);
    for (int shard = 1; shard <= plan_.shards; ++shard) {
        if (plan_.empty(shard)) continue;
        const Window held = held_of(shard, level);
        const std::vector<std::byte> bytes = read_parcel(plan_, means_step, shard, "coarsest");
        std::vector<float> values(held.area());
        ParcelReader(bytes).get_all(std::span(values));
        means.write(held, values.data(), held.columns);
    }
    return means;
}

std::uint64_t ShardFill::fill(const Store<float>& raw, const FillStep& step, Store<float>& out) const {
    const int threads = context_.workers_for(fill_piece_bytes);
    const std::size_t top = levels_.size() - 1;
    const Store<float> coarsest = gather_coarsest();
    std::uint64_t bytes_read = levels_[top].area() * sizeof(float);
    Store<float> filled("", levels_[top].columns, levels_[top].rows);
    fill_voids(
        {coarsest,
         {},
         threads,
         [](const std::string&, std::int64_t columns, std::int64_t rows) { return Store<float>("", columns, rows); }},
        filled);
    for (std::size_t level = top - 1; level > 0; --level) {
        const Window& all = levels_[level];
        const std::string name = mean_name(level);
        const ShardRecord record = require_record(plan_, means_step, shard_);
        Store<float> means =
            Store<float>::complete(plan_.file(means_step, shard_, name), all.columns, all.rows, held_of(shard_, level));
        if (means.digest() != record.files.at(name).digest)
            throw Failure(1, fmt::format("{}: is damaged; run {} --again", plan_.file(means_step, shard_, name),
                                         plan_.command(means_step, shard_)));
        bytes_read += add_frames<float>(
            plan_, means_step, name + "-frame", shard_, mean_frame_, mean_frame_,
            [&](int other) { return held_of(other, level); }, means);
        Store<float> to(scratch_.file("filling" + std::to_string(level)), all.columns, all.rows, needs_[level]);
        fill_level(means, filled, {}, needs_[level], threads, to);
        filled.remove();
        filled = std::move(to);
    }
    fill_level(raw, filled, step, needs_.front(), threads, out);
    filled.remove();
    return bytes_read;
}

} // namespace fjell::baker
