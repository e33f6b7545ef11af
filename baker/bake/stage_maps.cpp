// Stages that make materials: near mips tile by tile from the heights, then mip by mip from the texels of the one
// before.
#include <algorithm>

#include "baker/bake/pipeline.h"
#include "baker/maps/image.h"

namespace fjell::baker {

namespace {

constexpr MapKind kinds[2] = {MapKind::colour, MapKind::normal};

ChunkKind chunk_of(MapKind kind) {
    return kind == MapKind::colour ? ChunkKind::colour : ChunkKind::normal;
}

} // namespace

void Pipeline::plan_maps() {
    const double side = tree_.side();
    const std::uint32_t most = std::min(options_.max_texture_log2, max_texture_log2);
    const Survey& survey = ledger_.state.survey;
    maps_.tree = tree_;
    std::copy_n(source_.spacing_m, 2, maps_.spacing_m);
    maps_.normal_log2 = fitting_log2(side, most);
    maps_.ramp = absolute(options_.ramp_path.empty() ? default_ramp() : read_ramp(options_.ramp_path),
                          static_cast<double>(survey.least_m), static_cast<double>(survey.most_m));
    // Colours of a ramp change slowly, and normals carry the detail: half the samples' density.
    maps_.colour_log2 = fitting_log2(image_ ? side * image_->pixels_per_sample() : side / 2, most);
    maps_.image = image_.get();
}

void Pipeline::open_texels(MapKind kind, std::uint32_t mip) {
    const Window grid = maps_.grid(kind, mip);
    const auto k = static_cast<std::size_t>(kind);
    texels_[k][mip & 1] = {file((kind == MapKind::colour ? "colour" : "normal") + std::to_string(mip)),
                           std::int64_t{grid.columns} * static_cast<std::int64_t>(channels(kind)), grid.rows};
}

// The window of a store whose elements are channels of texels.
static Window in_channels(const Window& w, MapKind kind) {
    const auto n = static_cast<std::int32_t>(channels(kind));
    return {w.x * n, w.y, w.columns * n, w.rows};
}

void Pipeline::store_texels(MapKind kind, std::uint32_t mip, std::uint32_t tile, const Texels& texels) {
    const Window w = in_channels(maps_.texels(kind, mip, tile), kind);
    texels_[static_cast<std::size_t>(kind)][mip & 1].write(w, texels.data(), w.columns);
}

void Pipeline::make_maps() {
    make_near_maps();
    for (const MapKind kind : kinds)
        for (std::uint32_t mip = near_mips; mip < mip_count(maps_.log2_side(kind)); ++mip) make_far_mip(kind, mip);
}

void Pipeline::make_near_maps() {
    const std::uint32_t stage = index(Stage::maps);
    if (done(stage)) return;
    for (const MapKind kind : kinds)
        if (mip_count(maps_.log2_side(kind)) > near_mips) open_texels(kind, near_mips - 1);
    const auto tiles = static_cast<std::uint64_t>(tree_.tiles_x) * static_cast<std::uint64_t>(tree_.tiles_y);
    const double places = tree_.side() + 32.0, texels = static_cast<double>(1u << maps_.colour_log2);
    // Heights, and texels of both maps on their way from floats to blocks.
    const auto bytes =
        static_cast<std::uint64_t>(places * places * 20 + texels * texels * 24) + (std::uint64_t{2} << 20);
    input_at_work_ = true;
    run_units({stage, "maps", tiles, workers_for(bytes),
               static_cast<double>(tree_.columns()) * tree_.rows() / static_cast<double>(tiles)},
              [&](std::uint64_t u) {
                  const auto tile = static_cast<std::uint32_t>(u);
                  const Window w = heights_for_maps(maps_, tile);
                  Buffer<float> heights_m(w.area());
                  heights().read(w, heights_m.data(), w.columns);
                  std::unique_ptr<ImageReader> reader = take_reader();
                  const NearMaps near = near_maps(maps_, tile, heights_m.data(), reader.get());
                  give_reader(std::move(reader));
                  heights_m = {};
                  ChunkBatch batch;
                  for (const MapKind kind : kinds) {
                      const std::vector<MipTexels>& mips = kind == MapKind::colour ? near.colour : near.normal;
                      for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
                          batch.add({chunk_of(kind), tile, mip}, mips[mip].blocks, options_.compression);
                      if (mip_count(maps_.log2_side(kind)) > near_mips)
                          store_texels(kind, near_mips - 1, tile, mips.back().texels);
                  }
                  spool_->append(std::move(batch));
              });
    input_at_work_ = false;
    image_readers_.clear();
    finish(stage);
}

void Pipeline::make_far_mip(MapKind kind, std::uint32_t mip) {
    const std::uint32_t stage = index(Stage::maps, 1 + static_cast<int>(kind) * 32 + static_cast<int>(mip));
    if (done(stage)) return;
    const auto k = static_cast<std::size_t>(kind);
    if (!texels_[k][(mip - 1) & 1].exists()) open_texels(kind, mip - 1);
    open_texels(kind, mip);
    // Tiles are small by now: many at once, in rows.
    const auto down = static_cast<std::uint64_t>(tree_.tiles_y);
    run_units({stage, "mips", down, threads_, static_cast<double>(tree_.tiles_x)}, [&](std::uint64_t row) {
        ChunkBatch batch;
        for (std::int32_t x = 0; x < tree_.tiles_x; ++x) {
            const auto tile = static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(tree_.tiles_x) +
                              static_cast<std::uint32_t>(x);
            const Window from = finer_texels(maps_, kind, mip, tile), stored = in_channels(from, kind);
            Texels finer(stored.area());
            texels_[k][(mip - 1) & 1].read(stored, finer.data(), stored.columns);
            const MipTexels made = far_mip(maps_, kind, mip, tile, finer);
            batch.add({chunk_of(kind), tile, mip}, made.blocks, options_.compression);
            store_texels(kind, mip, tile, made.texels);
        }
        spool_->append(std::move(batch));
    });
    finish(stage);
    texels_[k][(mip - 1) & 1].remove();
}

std::unique_ptr<ImageReader> Pipeline::take_reader() {
    if (!image_) return nullptr;
    const std::lock_guard hold(lock_);
    if (image_readers_.empty()) return image_->reader();
    std::unique_ptr<ImageReader> reader = std::move(image_readers_.back());
    image_readers_.pop_back();
    return reader;
}

void Pipeline::give_reader(std::unique_ptr<ImageReader> reader) {
    const std::lock_guard hold(lock_);
    if (reader) image_readers_.push_back(std::move(reader));
}

} // namespace fjell::baker
