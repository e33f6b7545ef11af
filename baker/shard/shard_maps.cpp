#include "baker/shard/shard_maps.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "baker/shard/seam.h"

namespace fjell::baker {

namespace {

constexpr ShardStep measuring{ShardStep::Kind::measure};

std::string level_name(int level) {
    return fmt::format("level{}", level);
}

// A window of one store into another, some rows at a time.
void copy_window(const Store<float>& from, const Window& at, Store<float>& to) {
    const std::int32_t most = std::max((1 << 20) / at.columns, 1);
    Buffer<float> values;
    for (std::int32_t y = 0; y < at.rows; y += most) {
        const Window w{at.x, at.y + y, at.columns, std::min(most, at.rows - y)};
        values.resize(w.area());
        from.read(w, values.data(), w.columns);
        to.write(w, values.data(), w.columns);
    }
}

} // namespace

ShardLevels::ShardLevels(const ShardPlan& plan, const BakeContext& context, int shard, std::int32_t frame)
    : plan_(plan), context_(context), shard_(shard), frame_(frame), levels_(levels_of(context)),
      coarse_(levels_of_shards(levels_, context.options.whole_level_vertices)) {}

Window ShardLevels::own(int shard, int level) const {
    const PartWindows windows{context_.tree, context_.regions, plan_.parts[static_cast<std::size_t>(shard) - 1]};
    return windows.level(levels_, level);
}

void ShardLevels::leave(const Store<float>& heights, ScratchFolder& scratch) const {
    if (coarse_ == 0) return;
    // From a level's own vertices down: what of the one below they are made from, which is a little more than its own.
    std::vector<Window> needs(static_cast<std::size_t>(coarse_) + 1);
    needs.back() = own(shard_, coarse_);
    for (int level = coarse_ - 1; level > 0; --level)
        needs[static_cast<std::size_t>(level)] =
            halved_from(levels_.extents(level), needs[static_cast<std::size_t>(level) + 1]);
    Store<float> finer;
    for (int level = 1; level <= coarse_; ++level) {
        const Window &all = levels_.extents(level), need = needs[static_cast<std::size_t>(level)];
        Store<float> made(scratch.file("making" + std::to_string(level)), all.columns, all.rows, need);
        make_level(
            context_, level, need,
            [&](int below, const Window& w, float* to, std::ptrdiff_t stride) {
                (below == 0 ? heights : finer).read(w, to, stride);
            },
            [&](const Window& at, const float* values) { made.write(at, values, at.columns); });
        finer.remove();
        finer = std::move(made);
        if (level == coarse_) break;
        const std::string name = level_name(level);
        Store<float> left(scratch.file(name), all.columns, all.rows, own(shard_, level));
        copy_window(finer, left.held(), left);
        scratch.write_parcel(name + "-frame", frame_of_store(left, frame_, frame_));
        scratch.add(name, left.digest());
    }
    std::vector<float> coarse(needs.back().area());
    finer.read(needs.back(), coarse.data(), needs.back().columns);
    finer.remove();
    ParcelWriter parcel;
    parcel.put_all(std::span<const float>(coarse));
    scratch.write_parcel("coarse", parcel.bytes);
}

std::uint64_t ShardLevels::find() {
    std::uint64_t bytes_read = 0;
    const ShardRecord record = require_record(plan_, measuring, shard_);
    for (int level = 1; level < coarse_; ++level) {
        const Window& all = levels_.extents(level);
        const std::string name = level_name(level), path = plan_.file(measuring, shard_, name);
        stores_.push_back(Store<float>::complete(path, all.columns, all.rows, own(shard_, level)));
        if (stores_.back().digest() != record.files.at(name).digest)
            throw Failure(1, plan_.damage(measuring, shard_, path));
        bytes_read += add_frames<float>(
            plan_, measuring, name + "-frame", shard_, frame_, frame_, [&](int other) { return own(other, level); },
            stores_.back());
    }
    for (int level = coarse_; level > 0 && level < levels_.count(); ++level) {
        const Window& all = levels_.extents(level);
        Store<float> whole("", all.columns, all.rows);
        if (level > coarse_)
            make_level(context_, level, all, reader(),
                       [&](const Window& at, const float* values) { whole.write(at, values, at.columns); });
        for (int other = 1; level == coarse_ && other <= plan_.shards; ++other) {
            if (plan_.empty(other)) continue;
            const std::vector<std::byte> bytes = read_parcel(plan_, measuring, other, "coarse");
            bytes_read += bytes.size();
            const Window at = own(other, level);
            std::vector<float> values(at.area());
            ParcelReader(bytes).get_all(std::span(values));
            whole.write(at, values.data(), at.columns);
        }
        stores_.push_back(std::move(whole));
    }
    return bytes_read;
}

LevelReader ShardLevels::reader() const {
    return [this](int level, const Window& w, float* to, std::ptrdiff_t stride) {
        stores_.at(static_cast<std::size_t>(level) - 1).read(w, to, stride);
    };
}

// ---- wetness

void leave_squares(const BakeContext& context, const Store<float>& heights, ScratchFolder& scratch) {
    const SquareSums squares = sum_squares(context, heights);
    ParcelWriter parcel;
    parcel.put(squares.at);
    parcel.put_all(std::span<const double>(squares.sums));
    scratch.write_parcel("squares", parcel.bytes);
}

namespace {

// Of all shards, in one grid.
SquareSums gather_squares(const ShardPlan& plan, std::uint64_t& bytes_read) {
    std::vector<SquareSums> parts;
    SquareSums all;
    for (int shard = 1; shard <= plan.shards; ++shard) {
        if (plan.empty(shard)) continue;
        const std::vector<std::byte> bytes = read_parcel(plan, measuring, shard, "squares");
        bytes_read += bytes.size();
        ParcelReader from(bytes);
        SquareSums& part = parts.emplace_back();
        part.at = from.get<Window>();
        part.sums.resize(part.at.area());
        from.get_all(std::span(part.sums));
        all.at.columns = std::max(all.at.columns, part.at.x + part.at.columns);
        all.at.rows = std::max(all.at.rows, part.at.y + part.at.rows);
    }
    all.sums.resize(all.at.area());
    for (const SquareSums& part : parts)
        for (std::int32_t y = 0; y < part.at.rows; ++y)
            std::copy_n(part.sums.begin() + std::ptrdiff_t{y} * part.at.columns, part.at.columns,
                        all.sums.begin() + std::ptrdiff_t{part.at.y + y} * all.at.columns + part.at.x);
    return all;
}

} // namespace

Wetness find_wetness(const ShardPlan& plan, const BakeContext& context, std::uint64_t& bytes_read) {
    const std::string path = fmt::format("{}/{}/wetness", plan.folder, measuring.name());
    if (const auto bytes = find_parcel(plan, path)) {
        bytes_read += bytes->size();
        std::vector<float> index(bytes->size() / sizeof(float));
        ParcelReader(*bytes).get_all(std::span(index));
        return found_wetness(context, std::move(index));
    }
    Wetness wetness = make_wetness(context, gather_squares(plan, bytes_read));
    ParcelWriter parcel;
    parcel.put_all(std::span<const float>(wetness.index()));
    write_parcel(plan, path, parcel.bytes);
    return wetness;
}

} // namespace fjell::baker
