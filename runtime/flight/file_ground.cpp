#include "flight/file_ground.h"

#include <algorithm>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "pack/terrain_data.h"

namespace fjell::flight {

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

Coord FileGround::north_west_of(double x_m, double z_m) const {
    const PackHeader& h = terrain_.header();
    const auto first = [](double at, std::int32_t count) {
        return static_cast<std::int32_t>(std::clamp(at, 0.0, static_cast<double>(count - 2)));
    };
    return {first(x_m / h.spacing_m[0], data_of(terrain_).tree.columns()),
            first(z_m / h.spacing_m[1], data_of(terrain_).tree.rows())};
}

void FileGround::make_room() {
    if (terrain_.page_count() - terrain_.pages_missing() + most_pages > data_of(terrain_).slot_count)
        for (std::uint32_t slot = 0; slot < data_of(terrain_).slot_count; ++slot)
            if (const std::uint32_t page = data_of(terrain_).slot_page[slot]; page != no_index)
                (void)unload_page(terrain_, page / terrain_.pages_per_tile(), page % terrain_.pages_per_tile());
}

bool FileGround::has_ground(double x_m, double z_m) {
    const Coord at = north_west_of(x_m, z_m);
    make_room();
    fetch(at);
    const TerrainData::Vertex v = data_of(terrain_).vertex(at);
    return v.loaded && v.in_tile && !v.hole;
}

double FileGround::ground_m(double x_m, double z_m) {
    const Coord nw = north_west_of(x_m, z_m);
    make_room();
    bool all = true;
    for (const Coord by : {Coord{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        fetch(nw + by);
        all = all && data_of(terrain_).vertex(nw + by).loaded;
    }
    if (all) return data_of(terrain_).ground_m(x_m, z_m);
    for (int shift = 1;; ++shift) { // ends at a tile's corner at the latest
        const TerrainData::Vertex v = data_of(terrain_).vertex({nw.x >> shift << shift, nw.y >> shift << shift});
        if (v.loaded) return v.height_m;
    }
}

void FileGround::fetch(Coord sample) {
    const Tree& tree = data_of(terrain_).tree;
    const PageLayout& pages = data_of(terrain_).pages;
    if (tree.is_corner(sample)) return;
    const std::int32_t side = tree.side();
    const Coord place = data_of(terrain_).tile_with(
        sample, {std::min(sample.x / side, tree.tiles_x - 1), std::min(sample.y / side, tree.tiles_y - 1)});
    const std::uint32_t tile = terrain_.tile_at(place);
    if (tile == no_tile) return; // nothing is there to be read
    const std::uint32_t page = pages
                                   .place(static_cast<std::uint32_t>(sample.x - place.x * side),
                                          static_cast<std::uint32_t>(sample.y - place.y * side))
                                   .page;
    const int z = pages.page_step_log2(page);
    if (z == 0) { // its errors follow from the heights of all pages over it
        const Coord at = pages.page_position(page);
        if (!load(tile, 0)) return;
        for (int over = pages.tile_log2 - 1 - page_squares_log2; over > 0; --over)
            if (!load(tile, pages.page_at(over, static_cast<std::uint32_t>(at.x) >> over,
                                          static_cast<std::uint32_t>(at.y) >> over)))
                return;
    }
    (void)load(tile, page);
}

bool FileGround::load(std::uint32_t tile, std::uint32_t page) {
    if (data_of(terrain_).page_table[std::size_t{tile} * terrain_.pages_per_tile() + page].slot != no_index)
        return true;
    const ChunkEntry entry = file_.pack().entry(chunk_index(terrain_.header(), {ChunkKind::geometry, tile, page}));
    stored_.resize(entry.stored_bytes);
    raw_.resize(entry.raw_bytes);
    return file_.read(entry.offset, stored_) == 0 && decode_chunk(entry, stored_, raw_).ok() &&
           insert_page(terrain_, tile, page, raw_).ok();
}

Ground ground_of(FileGround& file, const Terrain& terrain) {
    Ground ground = ground_of(terrain);
    ground.height_m = [&file](double x_m, double z_m) { return file.ground_m(x_m, z_m); };
    return ground;
}

} // namespace fjell::flight
