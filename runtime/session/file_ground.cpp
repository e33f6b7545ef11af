#include "session/file_ground.h"

#include <algorithm>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/pages.h"

namespace fjell::session {

namespace {

// Four samples may lie in four tiles; each needs its page and, if that is of the finest step, all those over it.
constexpr std::uint32_t most_pages = 4 * max_tile_log2;
constexpr TerrainBudget slots{2 * most_pages};

} // namespace

FileGround::FileGround(const io::PackFile& file) : file_(file) {
    const std::size_t bytes = terrain_bytes(file.pack().header, slots);
    memory_ = io::allocate(bytes);
    const Status s = create_terrain(file.pack(), file.corners(), slots, {memory_.get(), bytes}, terrain_);
    if (!s.ok()) throw io::Failure(1, fmt::format("{}: {}: {}", file.path(), s.field, message(s.code)));
}

SampleIndex FileGround::north_west_of(double x_m, double z_m) const {
    const PackHeader& h = terrain_.header();
    const auto first = [](double at, std::uint32_t count) {
        return static_cast<std::int32_t>(std::clamp(at, 0.0, static_cast<double>(count - 2)));
    };
    return {first(x_m / h.spacing_m[0], h.columns), first(z_m / h.spacing_m[1], h.rows)};
}

void FileGround::make_room() {
    if (terrain_.pages_loaded() + most_pages <= terrain_.page_slots()) return;
    for (const auto& [tile, page] : loaded_) (void)unload_page(terrain_, tile, page);
    loaded_.clear();
}

bool FileGround::has_ground(double x_m, double z_m) {
    const SampleIndex at = north_west_of(x_m, z_m);
    make_room();
    fetch(at);
    const TerrainVertex v = terrain_vertex(terrain_, at);
    return v.loaded && v.in_tile && !v.hole;
}

double FileGround::ground_m(double x_m, double z_m) {
    const SampleIndex nw = north_west_of(x_m, z_m);
    make_room();
    bool all = true;
    for (const SampleIndex by : {SampleIndex{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        fetch(nw + by);
        all = all && terrain_vertex(terrain_, nw + by).loaded;
    }
    if (all) return terrain_height_m(terrain_, x_m, z_m);
    for (int shift = 1;; ++shift) { // ends at a tile's corner at the latest
        const TerrainVertex v = terrain_vertex(terrain_, {nw.column >> shift << shift, nw.row >> shift << shift});
        if (v.loaded) return v.height_m;
    }
}

void FileGround::fetch(SampleIndex sample) {
    const PackHeader& h = terrain_.header();
    const std::int32_t side = std::int32_t{1} << h.tile_log2;
    const bool on_column = sample.column % side == 0, on_row = sample.row % side == 0;
    if (on_column && on_row) return; // a tile's corner
    // The tile that begins there, or on its border a neighbour to the west or north that has the sample too.
    SampleIndex place{std::min(sample.column / side, static_cast<std::int32_t>(h.tiles_x) - 1),
                      std::min(sample.row / side, static_cast<std::int32_t>(h.tiles_y) - 1)};
    if (terrain_.tile_at(place) == no_tile) {
        if (on_column && sample.column == place.column * side) --place.column;
        if (on_row && sample.row == place.row * side) --place.row;
    }
    const std::uint32_t tile = terrain_.tile_at(place);
    if (tile == no_tile) return; // nothing is there to be read
    const auto x = static_cast<std::uint32_t>(sample.column - place.column * side),
               y = static_cast<std::uint32_t>(sample.row - place.row * side);
    const std::uint32_t page = page_of(h, x, y);
    if (page_step_log2(h, page) == 0) // its errors follow from the heights of all pages over it
        for (std::uint32_t over = h.tile_log2 - 1; over > 0; --over)
            if (!load(tile, page_at(h, over, x, y))) return;
    (void)load(tile, page);
}

bool FileGround::load(std::uint32_t tile, std::uint32_t page) {
    if (page_loaded(terrain_, tile, page)) return true;
    const ChunkEntry entry = file_.pack().entry(chunk_index(terrain_.header(), {ChunkKind::geometry, tile, page}));
    stored_.resize(entry.stored_bytes);
    raw_.resize(entry.raw_bytes);
    if (file_.read(entry.offset, stored_) != 0 || !decode_chunk(entry, stored_, raw_).ok() ||
        !insert_page(terrain_, tile, page, raw_).ok())
        return false;
    loaded_.emplace_back(tile, page);
    return true;
}

Ground ground_of(FileGround& file, const Terrain& terrain) {
    Ground ground = ground_of(terrain);
    ground.height_m = [&file](double x_m, double z_m) { return file.ground_m(x_m, z_m); };
    return ground;
}

} // namespace fjell::session
