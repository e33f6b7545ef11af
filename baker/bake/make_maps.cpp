// Stages that make materials: near mips tile by tile from the heights, then mip by mip from the texels of the one
// before.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "baker/bake/reader_pool.h"
#include "baker/bake/stages.h"
#include "baker/maps/image.h"

namespace fjell::baker {

namespace {

ChunkKind chunk_of(MapKind kind) {
    constexpr ChunkKind chunks[map_kind_count] = {ChunkKind::colour, ChunkKind::normal, ChunkKind::horizon,
                                                  ChunkKind::control};
    return chunks[static_cast<std::size_t>(kind)];
}

// The window of a store whose elements are channels of texels.
Window in_channels(const Window& w, MapKind kind) {
    const auto n = static_cast<std::int32_t>(channels(kind));
    return {w.x * n, w.y, w.columns * n, w.rows};
}

} // namespace

void store_texels(TexelStore& store, const Window& at, MapKind kind, const Texels& texels) {
    const Window w = in_channels(at, kind);
    store.write(w, texels.data(), w.columns);
}

TexelStore open_texels(const BakeContext& context, const MapPlan& maps, MapKind kind, std::uint32_t mip) {
    const Window grid = maps.grid(kind, mip);
    constexpr const char* names[map_kind_count] = {"colour", "normal", "horizon", "control"};
    return context.open<std::uint16_t>(names[static_cast<std::size_t>(kind)] + std::to_string(mip),
                                       std::int64_t{grid.columns} * static_cast<std::int64_t>(channels(kind)),
                                       grid.rows);
}

void make_near_maps(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                    const NearMapsOutput& out) {
    const double places = context.tree.side() + 32.0, texels = static_cast<double>(1u << plan.maps.colour_log2);
    // Heights, and texels of both maps on their way from floats to blocks.
    const auto tile_bytes =
        static_cast<std::uint64_t>(places * places * 20 + texels * texels * 24) + (std::uint64_t{2} << 20);
    ReaderPool<ImageSource, ImageReader> readers(context.image.get());
    context.run_units(
        {"maps", context.tile_count(), context.workers_for(tile_bytes),
         context.samples() / static_cast<double>(context.tile_count())},
        [&](std::uint64_t u) {
            const std::uint32_t tile = context.tile_at(u);
            const Window w = heights_for_maps(plan.maps, tile);
            std::optional<StoreView<float>> heights_m(std::in_place, heights.heights, w);
            std::unique_ptr<ImageReader> reader = readers.take();
            const NearMaps near = near_maps(plan.maps, tile, {heights_m->row(0), heights_m->stride(), w}, reader.get());
            readers.give(std::move(reader));
            heights_m.reset();
            ChunkBatch batch;
            for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
                const std::vector<MipTexels>& mips = kind == MapKind::colour ? near.colour : near.normal;
                for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
                    batch.add({chunk_of(kind), tile, mip}, mips[mip].blocks, context.options.compression);
                TexelStore& last = kind == MapKind::colour ? out.colour : out.normal;
                if (last.exists())
                    store_texels(last, plan.maps.texels(kind, near_mips - 1, tile), kind, mips.back().texels);
            }
            out.spool.append(std::move(batch));
        });
}

void make_far_mip(const BakeContext& context, const BakePlan& plan, const FarMipInput& in, const FarMipOutput& out) {
    // Tiles are small by now: many at once, as many as a row has.
    const auto across = static_cast<std::uint64_t>(context.tile_window().columns);
    const std::uint64_t tiles = context.tile_count(), rows = (tiles + across - 1) / across;
    context.run_units({"mips", rows, context.threads, static_cast<double>(across)}, [&](std::uint64_t row) {
        ChunkBatch batch;
        for (std::uint64_t u = row * across; u < std::min(tiles, (row + 1) * across); ++u) {
            const std::uint32_t tile = context.tile_at(u);
            const Window stored = in_channels(finer_texels(plan.maps, in.kind, in.mip, tile), in.kind);
            Texels finer(stored.area());
            in.finer.read(stored, finer.data(), stored.columns);
            const MipTexels made = far_mip(plan.maps, in.kind, in.mip, tile, finer);
            batch.add({chunk_of(in.kind), tile, in.mip}, made.blocks, context.options.compression);
            if (out.texels.exists())
                store_texels(out.texels, plan.maps.texels(in.kind, in.mip, tile), in.kind, made.texels);
        }
        out.spool.append(std::move(batch));
    });
}

} // namespace fjell::baker
