#include "baker/shard/shard_ground.h"

#include <algorithm>
#include <cmath>

#include "baker/bake/stages.h"
#include "baker/pack/write_set.h"

namespace fjell::baker {

bool needs_all_heights(const BakeOptions& options) {
    return options.horizon_spacing != 0 ||
           (!options.layers_path.empty() && read_splat(options.layers_path).wants_wetness());
}

bool GroundSeen::note(const Window& w, const float* heights, std::ptrdiff_t stride) {
    const std::int32_t side = tree_.side();
    bool any = false;
    // A border is both tiles'; the last column and row are nobody's first.
    const auto first = [&](std::int32_t at) { return at == 0 ? 0 : (at - 1) / side; };
    const auto last = [&](std::int32_t at, std::int32_t tiles) { return std::min(at / side, tiles - 1); };
    for (std::int32_t ty = first(w.y); ty <= last(w.y + w.rows - 1, tree_.tiles_y); ++ty)
        for (std::int32_t tx = first(w.x); tx <= last(w.x + w.columns - 1, tree_.tiles_x); ++tx) {
            const Window shared = common(w, {tx * side, ty * side, side + 1, side + 1});
            bool ground = false;
            for (std::int32_t y = shared.y; y < shared.y + shared.rows && !ground; ++y) {
                const float* const row = heights + (y - w.y) * stride + (shared.x - w.x);
                ground = std::any_of(row, row + shared.columns, [](float h) { return !std::isnan(h); });
            }
            if (!ground) continue;
            any = true;
            tiles_[static_cast<std::size_t>(ty) * static_cast<std::size_t>(tree_.tiles_x) +
                   static_cast<std::size_t>(tx)] = 1;
        }
    return any;
}

std::vector<std::uint32_t> GroundSeen::tiles() const {
    std::vector<std::uint32_t> all;
    for (std::size_t tile = 0; tile < tiles_.size(); ++tile)
        if (tiles_[tile] != 0) all.push_back(static_cast<std::uint32_t>(tile));
    return all;
}

void ShardGround::find(bool holes) {
    if (!plan_.packs || !holes) return;
    tiles_.assign(static_cast<std::size_t>(tree_.tiles_x) * static_cast<std::size_t>(tree_.tiles_y), 0);
    has_ground_.assign(plan_.parts.size(), false);
    for (int shard = 1; shard <= plan_.shards; ++shard) {
        if (plan_.empty(shard)) continue;
        const std::vector<std::byte> bytes = read_parcel(plan_, {ShardStep::Kind::read}, shard, "facts");
        ParcelReader from(bytes);
        from.skip<ReadStatistics>(1);
        while (!from.ended()) {
            tiles_.at(from.get<std::uint32_t>()) = 1;
            has_ground_[static_cast<std::size_t>(shard) - 1] = true;
        }
    }
    find_baked();
}

// All tiles of packs that have ground, and a ring around them.
void ShardGround::find_baked() {
    // A tile's root looks at descendants up to one tile beside it, 3 (1/2 + 1/4 + ...) halves of a side from its
    // centre; blocks of 4 x 4 squares that share a radius (errors/step.h) add up to half a side to that, because they
    // are the steps' from the seventh on. What its mips are made from lies nearer.
    constexpr std::int32_t ring = 2;
    baked_.assign(static_cast<std::size_t>(regions_.count()), 0);
    works_.assign(plan_.parts.size(), false);
    const std::int32_t group = regions_.cells() / tree_.side();
    for (std::uint32_t py = 0; py < plan_.packs->packs_y; ++py)
        for (std::uint32_t px = 0; px < plan_.packs->packs_x; ++px) {
            const Window tiles = tiles_of_pack(*plan_.packs, tree_, px, py);
            if (!in_tiles(tiles)) continue;
            const Window needed =
                common({tiles.x - ring, tiles.y - ring, tiles.columns + 2 * ring, tiles.rows + 2 * ring},
                       {0, 0, tree_.tiles_x, tree_.tiles_y});
            for (std::int32_t y = needed.y / group; y <= (needed.y + needed.rows - 1) / group; ++y)
                for (std::int32_t x = needed.x / group; x <= (needed.x + needed.columns - 1) / group; ++x)
                    baked_[static_cast<std::size_t>(y) * static_cast<std::size_t>(regions_.across()) +
                           static_cast<std::size_t>(x)] = 1;
        }
    for (std::size_t shard = 0; shard < plan_.parts.size(); ++shard) {
        const Window& part = plan_.parts[shard];
        for (std::int32_t y = part.y; y < part.y + part.rows; ++y)
            for (std::int32_t x = part.x; x < part.x + part.columns; ++x)
                works_[shard] = works_[shard] || bakes(std::int64_t{y} * regions_.across() + x);
    }
}

bool ShardGround::in_tiles(const Window& tiles) const {
    for (std::int32_t y = tiles.y; y < tiles.y + tiles.rows; ++y) {
        const auto row = tiles_.begin() + std::ptrdiff_t{y} * tree_.tiles_x;
        if (std::find(row + tiles.x, row + tiles.x + tiles.columns, std::uint8_t{1}) != row + tiles.x + tiles.columns)
            return true;
    }
    return false;
}

bool ShardGround::in_samples(const Window& samples) const {
    const std::int32_t side = tree_.side();
    return in_tiles(
        {samples.x / side, samples.y / side, (samples.columns - 2) / side + 1, (samples.rows - 2) / side + 1});
}

std::uint64_t ShardGround::samples_left_out() const {
    std::uint64_t samples = 0;
    for (std::int32_t y = 0; leaves_out() && y < regions_.down(); ++y)
        for (std::int32_t x = 0; x < regions_.across(); ++x)
            if (!bakes(std::int64_t{y} * regions_.across() + x)) samples += regions_.samples_of({x, y, 1, 1}).area();
    return samples;
}

} // namespace fjell::baker
