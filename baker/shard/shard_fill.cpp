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

ShardFill::ShardFill(const Of& of, std::int32_t frame, ScratchFolder& scratch)
    : plan_(of.plan), context_(of.context), ground_(of.ground), shard_(of.shard),
      // What is filled around a part becomes half as wide with each level, and half the halo and a little wider: 24 at
      // most, or little more than half of the first.
      mean_frame_(std::max(frame / 2 + 12, 24) + fill_halo),
      scratch_(scratch), levels_{{0, 0, of.context.tree.columns(), of.context.tree.rows()}} {
    while (levels_.size() <= most_mean_levels && (levels_.back().columns > 1 || levels_.back().rows > 1))
        levels_.push_back({0, 0, (levels_.back().columns + 1) / 2, (levels_.back().rows + 1) / 2});
    needs_.push_back(with_frame({context_.tree, context_.regions, context_.region_window()}, frame));
    for (std::size_t level = 1; level < levels_.size(); ++level)
        needs_.push_back(seen_coarser(needs_.back(), levels_[level - 1], levels_[level]));
    find_pieces(frame);
}

// Where regions are left out: pieces of each level that the ones that are baked look at, a few samples more.
void ShardFill::find_pieces(std::int32_t frame) {
    if (!ground_.leaves_out()) {
        for (const Window& all : needs_) pieces_.push_back({all});
        return;
    }
    constexpr std::int32_t side = 256;
    std::vector<Window> wanted;
    for (std::uint64_t u = 0; u < context_.region_count(); ++u) {
        const auto region = static_cast<std::int32_t>(context_.region_at(u)), across = context_.regions.across();
        wanted.push_back(
            with_frame({context_.tree, context_.regions, {region % across, region / across, 1, 1}}, frame));
    }
    for (std::size_t level = 0; level < needs_.size(); ++level) {
        const Window& all = needs_[level];
        const std::int32_t across = (all.columns - 1) / side + 1, down = (all.rows - 1) / side + 1;
        std::vector<bool> looked_at(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
        for (const Window& want : wanted) {
            const Window w = common(want, all);
            if (w.area() == 0) continue;
            for (std::int32_t y = (w.y - all.y) / side; y <= (w.y - all.y + w.rows - 1) / side; ++y)
                for (std::int32_t x = (w.x - all.x) / side; x <= (w.x - all.x + w.columns - 1) / side; ++x)
                    looked_at[static_cast<std::size_t>(y) * static_cast<std::size_t>(across) +
                              static_cast<std::size_t>(x)] = true;
        }
        std::vector<Window> pieces;
        for (std::size_t i = 0; i < looked_at.size(); ++i)
            if (looked_at[i])
                pieces.push_back(common({all.x + static_cast<std::int32_t>(i) % across * side,
                                         all.y + static_cast<std::int32_t>(i) / across * side, side, side},
                                        all));
        wanted.clear();
        for (const Window& piece : pieces)
            if (level + 1 < needs_.size()) wanted.push_back(seen_coarser(piece, levels_[level], levels_[level + 1]));
        pieces_.push_back(std::move(pieces));
    }
}

// Parts begin at multiples of 2^most_mean_levels, so that no mean lies in two of them.
Window ShardFill::held_of(int shard, std::size_t level) const {
    return halved(context_.regions.samples_of(plan_.parts[static_cast<std::size_t>(shard) - 1]), level);
}

Window ShardFill::halved(const Window& samples, std::size_t level) const {
    const std::int32_t unit = 1 << level;
    const auto end = [&](std::int32_t last) { return (last + unit - 1) / unit; };
    const std::int32_t x = samples.x / unit, y = samples.y / unit;
    return {x, y, end(samples.x + samples.columns) - x, end(samples.y + samples.rows) - y};
}

// Of this shard, their samples. Regions begin where parts may.
std::vector<Window> ShardFill::regions_with_ground() const {
    std::vector<Window> all;
    for (std::uint64_t u = 0; u < context_.region_count(); ++u) {
        const auto region = static_cast<std::int32_t>(context_.region_at(u)), across = context_.regions.across();
        const Window part{region % across, region / across, 1, 1};
        if (ground_.in_tiles(context_.regions.tiles_of(part))) all.push_back(context_.regions.samples_of(part));
    }
    return all;
}

Store<float> ShardFill::make_level(const std::string& path, std::size_t level, const Window& held) const {
    const bool sparse = ground_.leaves_out();
    return {path, levels_[level].columns, levels_[level].rows, held,
            sparse ? WorkFile::Room::as_written : WorkFile::Room::reserved};
}

void ShardFill::leave_means(const Store<float>& raw) {
    const int threads = context_.workers_for(fill_piece_bytes);
    const Window own = context_.sample_window();
    std::vector<Store<float>> means;
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        const Window held = held_of(shard_, level);
        means.push_back(make_level(scratch_.file(mean_name(level)), level, held));
        if (ground_.leaves_out()) means.back().unwritten_is_void();
        for (const Window& w : ground_.leaves_out() ? regions_with_ground() : std::vector{own})
            (void)halve_heights(level == 1 ? raw : means[level - 2], halved(w, level), threads, means.back());
        scratch_.write_parcel(mean_name(level) + "-frame",
                              frame_of_store(means.back(), mean_frame_, mean_frame_, ground_.leaves_out()));
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
    if (ground_.leaves_out()) means.unwritten_is_void();
    for (int shard = 1; shard <= plan_.shards; ++shard) {
        if (plan_.empty(shard) || ground_.is_void(shard)) continue;
        const Window held = held_of(shard, level);
        const std::vector<std::byte> bytes = read_parcel(plan_, means_step, shard, "coarsest");
        std::vector<float> values(held.area());
        ParcelReader(bytes).get_all(std::span(values));
        means.write(held, values.data(), held.columns);
    }
    return means;
}

Store<float> ShardFill::find_means(std::size_t level) const {
    const Window& all = levels_[level];
    const std::string name = mean_name(level), path = plan_.file(means_step, shard_, name);
    if (ground_.is_void(shard_)) {
        Store<float> none = make_level(scratch_.file("no-" + name), level, held_of(shard_, level));
        none.unwritten_is_void();
        return none;
    }
    const ShardRecord record = require_record(plan_, means_step, shard_);
    Store<float> means = Store<float>::complete(path, all.columns, all.rows, held_of(shard_, level));
    if (means.digest() != record.files.at(name).digest)
        throw Failure(1, fmt::format("{}: is damaged; run {} --again", path, plan_.command(means_step, shard_)));
    if (ground_.leaves_out()) means.unwritten_is_void();
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
        Store<float> means = find_means(level);
        bytes_read += add_frames<float>(
            plan_, means_step, mean_name(level) + "-frame", shard_, mean_frame_, mean_frame_,
            [&](int other) { return ground_.is_void(other) ? Window{} : held_of(other, level); }, means,
            ground_.leaves_out());
        Store<float> to = make_level(scratch_.file("filling" + std::to_string(level)), level, needs_[level]);
        for (const Window& w : pieces_[level]) fill_level(means, filled, {}, w, threads, to);
        filled.remove();
        filled = std::move(to);
    }
    for (const Window& w : pieces_.front()) fill_level(raw, filled, step, w, threads, out);
    filled.remove();
    return bytes_read;
}

} // namespace fjell::baker
