// Stamps: any text is refused or is stamps, which come back the same when they are written and read. push_stamp() takes
// each of them and applies or refuses it, and the ground that they leave is finite.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "fjell/ground_maps.h"
#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "input.h"
#include "io/stamps.h"
#include "support/terrain_fixture.h"
#include "validate.h"

namespace {

using namespace fjell;
using namespace fjell::test;
using fuzz::must;

void stamp(const std::vector<io::TimedStamp>& stamps) {
    static const std::vector<std::byte> file = [] {
        Random random(77);
        baker::BakeOptions options = small_bake(5);
        options.room_for_holes = true, options.room_for_locks = true;
        return bake_and_load(random_dem(random, 90, 70, Shape::fractal), options).file;
    }();
    Pack pack;
    must(open_pack(file, pack).ok(), "the pack is one");
    const io::AlignedMemory memory = io::allocate(terrain_bytes(pack.header));
    Terrain terrain;
    must(load_terrain(pack, {memory.get(), terrain_bytes(pack.header)}, terrain).ok(), "it is loaded");
    const EditBudget budget{.blocks = 24, .stamps = 16, .areas = 8, .paint = 6, .holes = true, .locks = 8};
    const std::size_t bytes = edits_bytes(pack.header, budget);
    const io::AlignedMemory block = io::allocate(bytes);
    Edits edits;
    must(create_edits(terrain, budget, {block.get(), bytes}, edits).ok(), "it takes edits");
    const std::size_t few = std::min<std::size_t>(stamps.size(), 16);
    std::uint32_t done = 0;
    for (std::size_t i = 0; i < few; ++i) {
        StampId id = 0;
        must(push_stamp(edits, stamps[i].what.stamp(), id).ok(), "a stamp that was read is taken");
    }
    for (int call = 0; call < 10'000 && done < few; ++call) {
        EditReport report;
        must(update_edits(edits, {}, {.max_work = 64, .now_s = call * 1e6}, report).ok(), "edits go on");
        must(report.held == 0, "no stamp waits for pages that are there");
        done += report.applied + report.refused;
    }
    must(done == few, "each stamp is applied or refused");
    must(!validate_terrain(data_of(terrain)), "pages are where they were");
    for (int row = 0; row < 70; row += 3)
        for (int column = 0; column < 90; column += 3)
            must(std::isfinite(terrain_vertex(terrain, {column, row}).height_m), "ground has a height");
    // Paint, whatever it is, leaves maps that decode to something, and the pack's once it is gone.
    const auto mip = [&](std::uint32_t tile) {
        std::vector<std::byte> blocks(chunk_raw_bytes(pack.header, {ChunkKind::colour, tile, 0}));
        must(read_chunk(pack, {ChunkKind::colour, tile, 0}, blocks).ok(), "a mip is read");
        return blocks;
    };
    for (int clear = 0; clear < 2; ++clear) {
        for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) {
            std::vector<std::byte> blocks = mip(tile);
            bool changed = false;
            must(paint_map(terrain, MapKind::colour, tile, pack.header.colour_log2, blocks, changed).ok(),
                 "a map is painted");
            must(clear == 0 || (!changed && blocks == mip(tile)), "without paint it is the pack's");
        }
        Stamp all;
        all.shape = StampShape::unpaint, all.radius_m = 1e8f;
        StampId id = 0;
        EditReport report;
        must(push_stamp(edits, all, id).ok() && update_edits(edits, {}, {.now_s = 1e9}, report).ok(), "paint ends");
        must(report.paint == 0, "and gives its blocks back");
    }
    Stamp all;
    all.shape = StampShape::unlock, all.radius_m = 1e8f;
    StampId id = 0;
    EditReport report;
    must(push_stamp(edits, all, id).ok() && update_edits(edits, {}, {.now_s = 1e9}, report).ok(), "locks end");
    must(report.locks == 0 && report.loose == 0, "and give their blocks back");
}

} // namespace

extern "C" int fuzz_stamps(const std::uint8_t* data, std::size_t size) {
    try {
        const std::vector<io::TimedStamp> stamps =
            io::parse_stamps({reinterpret_cast<const char*>(data), size}, "fuzz");
        const std::string text = io::write_stamps(stamps);
        must(io::write_stamps(io::parse_stamps(text, "written")) == text, "stamps come back as they were");
        stamp(stamps);
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
        must(std::string_view(refused.what()).rfind("written", 0) != 0, "what is written is not refused");
    }
    return 0;
}
