#include "baker/bake/changed.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "baker/bake/context.h"
#include "baker/bake/plan.h"
#include "baker/bake/region_stores.h"
#include "baker/bake/stages.h"
#include "baker/pack/notes.h"
#include "baker/pack/pack_chunks.h"
#include "baker/read/pack_source.h"
#include "baker/read/tile_pages.h"
#include "baker/store/parallel.h"
#include "shared/order.h"
#include "shared/terrain_data.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;
using RegionSet = std::set<std::int64_t>;
using TileSet = std::set<std::uint32_t>;

double elapsed_s(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Why all has to be baked.
struct BakeAll {
    std::string why;
};

bool meets(const Window& a, const Window& b) {
    return common(a, b).area() != 0;
}
bool meets_any(const Window& a, const std::vector<Window>& all) {
    return std::any_of(all.begin(), all.end(), [&](const Window& w) { return meets(a, w); });
}
// The smallest window with both.
Window both(const Window& a, const Window& b) {
    if (a.area() == 0) return b;
    const std::int32_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
    return {x, y, std::max(a.x + a.columns, b.x + b.columns) - x, std::max(a.y + a.rows, b.y + b.rows) - y};
}
Window grown(const Window& w, std::int32_t by) {
    return {w.x - by, w.y - by, w.columns + 2 * by, w.rows + 2 * by};
}

// Bounds of all samples, from those of the tiles that were changed, before and after. Where only those tiles reached a
// bound that they reach no more, nobody knows the next one: what was remains a bound, but is not what a bake would
// find.
HeightStatistics moved_statistics(const HeightStatistics& all, const HeightStatistics& before,
                                  const HeightStatistics& after, bool exact, float quantum_m) {
    HeightStatistics moved = all;
    // near_m: how far below the bound heights that were rounded may lie and have reached it.
    const auto bound = [](float of_all, float was, float is, float near_m, const char* name) {
        if (is >= of_all) return is;
        if (is < was && was >= of_all - near_m)
            throw BakeAll{fmt::format("stamps move {}, which all scales follow from", name)};
        return of_all;
    };
    // The header says the lowest and the highest ground; the others are bounds alone.
    const float rounded = exact ? 0 : quantum_m, never = exact ? 0 : -HUGE_VALF;
    moved.least_m = -bound(-all.least_m, -before.least_m, -after.least_m, rounded, "the lowest ground");
    moved.most_m = bound(all.most_m, before.most_m, after.most_m, rounded, "the highest ground");
    moved.tile_range_m = bound(all.tile_range_m, before.tile_range_m, after.tile_range_m, never,
                               "the largest range of heights in a tile");
    for (const int axis : {0, 1})
        moved.step_m[axis] =
            bound(all.step_m[axis], before.step_m[axis], after.step_m[axis], never, "the steepest ground");
    if (!exact) return moved;
    moved.climbing += after.climbing - before.climbing;
    moved.off_metre += after.off_metre - before.off_metre;
    moved.off_decimetre += after.off_decimetre - before.off_decimetre;
    return moved;
}

bool same_scales(const Scales& a, const Scales& b) {
    return a.height_scale.base_m == b.height_scale.base_m && a.height_scale.quantum_m == b.height_scale.quantum_m &&
           a.floor_m == b.floor_m && a.ratio == b.ratio && a.nesting_steps == b.nesting_steps &&
           std::equal(std::begin(a.level_radius_m), std::end(a.level_radius_m), std::begin(b.level_radius_m)) &&
           a.ground_pad_m == b.ground_pad_m && a.height_pad_m == b.height_pad_m && a.half_quantum_m == b.half_quantum_m;
}

// Passes on what is wanted.
template <typename Wanted>
class SomeChunks final : public ChunkSink {
public:
    SomeChunks(ChunkSink& to, Wanted wanted) : to_(to), wanted_(std::move(wanted)) {}
    void append(ChunkBatch batch) override {
        batch.keep_if(wanted_);
        to_.append(std::move(batch));
    }

private:
    ChunkSink& to_;
    Wanted wanted_;
};

// What was made, and the pack's for all else.
class MadeAndKept final : public ChunkSource {
public:
    MadeAndKept(const ChunkSpool& made, const PackChunks& kept) : made_(made), kept_(kept), entries_(made.entries()) {
        const std::vector<ChunkEntry> had = kept.entries();
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            if (entries_[i].stored_bytes != 0) continue;
            entries_[i] = had[i];
            entries_[i].offset += kept_begin;
            kept_bytes_ += had[i].stored_bytes;
        }
    }
    [[nodiscard]] std::vector<ChunkEntry> entries() const override { return entries_; }
    [[nodiscard]] std::uint64_t kept_bytes() const { return kept_bytes_; }
    void read(std::uint64_t offset, std::span<std::byte> to) const override {
        if (offset >= kept_begin) return kept_.read(offset - kept_begin, to);
        made_.read(offset, to);
    }
    [[nodiscard]] std::string damage(std::uint64_t offset) const override {
        return offset >= kept_begin ? kept_.damage(offset - kept_begin) : made_.damage(offset);
    }

private:
    static constexpr std::uint64_t kept_begin = std::uint64_t{1} << 62;
    const ChunkSpool& made_;
    const PackChunks& kept_;
    std::vector<ChunkEntry> entries_;
    std::uint64_t kept_bytes_ = 0;
};

// A vertex' error and radius follow from descendants up to a tile beside it, and radii that blocks share from half a
// tile further: two regions. One more reads what those have.
constexpr std::int32_t most_regions = 3;

class ChangingBake {
public:
    ChangingBake(const HeightSource& source, const PackChanges& changes, const BakeOptions& options,
                 const std::string& out_path)
        : pack_(*changes.pack), changes_(changes), context_(source, options, out_path), coords_(context_.pages) {
        if (std::filesystem::exists(context_.folder.file("checkpoint"))) // which the folder keeps
            throw BakeAll{"a bake of all of it was begun, and goes on"};
        context_.folder.empty();
        context_.folder.keep(false);
    }
    BakeSummary run();

private:
    [[nodiscard]] BakedWith baked_with() const;
    [[nodiscard]] CheckpointState found_of(const HeightStatistics& heights) const;
    [[nodiscard]] HeightStatistics measure(const HeightStatistics& all);
    [[nodiscard]] BakePlan plan_of(const BakedWith& had, const CheckpointState& found) const;

    // ---- places
    [[nodiscard]] Window samples_of_tile(std::uint32_t tile) const;
    [[nodiscard]] Window places_of_all(const RegionSet& regions) const;
    [[nodiscard]] SampleIndex corner_of(std::uint32_t tile) const;
    [[nodiscard]] std::int64_t region_of(std::uint32_t tile) const;
    [[nodiscard]] RegionSet regions_of(const TileSet& tiles) const;
    [[nodiscard]] std::vector<std::uint32_t> tiles_of(const RegionSet& regions) const;
    [[nodiscard]] TileSet tiles_at(const Window& samples) const;
    [[nodiscard]] RegionSet around(const RegionSet& regions, std::int32_t by, bool corners) const;
    [[nodiscard]] Window places_read(std::int64_t region, int z) const;
    [[nodiscard]] Window samples_read(std::int64_t region) const;
    void only(const RegionSet& regions) {
        context_.leave_out([&](std::int64_t region) { return regions.contains(region); });
    }

    // ---- what the pack knows
    template <typename Make, typename Work>
    void for_tiles(const std::vector<std::uint32_t>& tiles, const Make& make, const Work& work) const;
    template <typename Take>
    void for_vertices_of(const RegionSet& regions, int finest, const Take& take) const;
    void take_step(int z, const RegionSet& regions, StepStores& to) const;
    void take_mixed(const RegionSet& regions, MixedStores& to) const;
    void load_heights(const TileSet& tiles);

    // ---- what is made
    void make_vertices(const BakePlan& plan, CheckpointState& found, ChunkSpool& spool);
    [[nodiscard]] RegionSet reached(int z, const std::vector<Window>& moved) const;
    [[nodiscard]] bool measured_at_border(std::int64_t region, int z) const;
    void measure_borders(const BakePlan& plan, const RegionSet& regions, UnsaturatedStores& unsaturated);
    [[nodiscard]] std::vector<Window> run_step(const BakePlan& plan, int z, const RegionSet& regions,
                                               UnsaturatedStores& unsaturated, ChunkSpool& spool);
    struct MapReach { // of a map that there is not: nothing
        std::vector<TileSet> made =
            std::vector<TileSet>(1); // by mip, from the last near one on: tiles whose texels are made
        std::vector<TileSet> wanted =
            std::vector<TileSet>(1); // those whose mips are others than the pack's; the first: of all near mips
    };
    [[nodiscard]] MapReach reach_of(const BakePlan& plan, MapKind kind) const;
    [[nodiscard]] Window heights_seen(const BakePlan& plan, MapKind kind, std::uint32_t tile) const;
    [[nodiscard]] MapReach reach_of_horizons(const BakePlan& plan) const;
    [[nodiscard]] Window around_tiles(const Window& samples) const;
    [[nodiscard]] RegionSet load_for(const BakePlan& plan, MapKind kind, const TileSet& tiles);
    [[nodiscard]] const MapReach& reached_by(MapKind kind) const { return reach_[static_cast<std::size_t>(kind)]; }
    void open_heights(const BakePlan& plan);
    void make_colours_and_normals(const BakePlan& plan, ChunkSpool& spool);
    void make_splat(const BakePlan& plan, ChunkSpool& spool);
    void make_far_mips(const BakePlan& plan, MapKind kind, TexelStore finer, ChunkSpool& spool);
    void make_horizons(const BakePlan& plan, ChunkSpool& spool);

    const PackSource& pack_;
    const PackChanges& changes_;
    BakeContext context_;
    const PageCoords coords_;
    bool exact_ = true;  // the pack's heights are those that it was baked from
    TileSet changed_;    // tiles with a sample that was changed
    TileSet loaded_;     // whose heights are there
    RegionSet measured_; // regions whose unsaturated errors are there
    MapReach reach_[map_kind_count];
    Store<float> heights_m_;
    const Store<std::uint8_t> no_holes_;
    const HeightStores heights_{heights_m_, no_holes_};
    std::vector<StepStores> steps_; // by z, without the last one
    MixedStores mixed_;
};

// ---- places ---------------------------------------------------------------------------------------------------------

SampleIndex ChangingBake::corner_of(std::uint32_t tile) const {
    const Tree& tree = context_.tree;
    const auto t = static_cast<std::int32_t>(tile);
    return {t % tree.tiles_x * tree.side(), t / tree.tiles_x * tree.side()};
}

Window ChangingBake::samples_of_tile(std::uint32_t tile) const {
    const Tree& tree = context_.tree;
    const SampleIndex first = corner_of(tile), last = tree.sample(first + SampleIndex{tree.side(), tree.side()});
    return {first.column, first.row, last.column - first.column + 1, last.row - first.row + 1};
}

std::int64_t ChangingBake::region_of(std::uint32_t tile) const {
    const SampleIndex corner = corner_of(tile);
    const std::int32_t cells = context_.regions.cells();
    return std::int64_t{corner.row / cells} * context_.regions.across() + corner.column / cells;
}

// The smallest window with all of them, with what lies beyond the terrain's rim.
Window ChangingBake::places_of_all(const RegionSet& regions) const {
    Window all;
    for (const std::int64_t region : regions) {
        const Region r = context_.regions.at(region);
        all =
            both(all, {r.first.column, r.first.row, r.last.column - r.first.column + 1, r.last.row - r.first.row + 1});
    }
    return all;
}

RegionSet ChangingBake::regions_of(const TileSet& tiles) const {
    RegionSet regions;
    for (const std::uint32_t tile : tiles) regions.insert(region_of(tile));
    return regions;
}

std::vector<std::uint32_t> ChangingBake::tiles_of(const RegionSet& regions) const {
    std::vector<std::uint32_t> tiles;
    for (const std::int64_t region : regions)
        context_.regions.for_each_tile(context_.regions.at(region),
                                       [&](std::uint32_t tile, SampleIndex) { tiles.push_back(tile); });
    return tiles;
}

// Tiles with one of these samples, borders included.
TileSet ChangingBake::tiles_at(const Window& samples) const {
    const Tree& tree = context_.tree;
    const Window w = common(samples, {0, 0, tree.columns(), tree.rows()});
    TileSet tiles;
    if (w.area() == 0) return tiles;
    const auto first = [&](std::int32_t at) { return std::max(at - 1, 0) / tree.side(); };
    const std::int32_t x1 = std::min((w.x + w.columns - 1) / tree.side(), tree.tiles_x - 1),
                       y1 = std::min((w.y + w.rows - 1) / tree.side(), tree.tiles_y - 1);
    for (std::int32_t y = first(w.y); y <= y1; ++y)
        for (std::int32_t x = first(w.x); x <= x1; ++x) tiles.insert(static_cast<std::uint32_t>(y * tree.tiles_x + x));
    return tiles;
}

// These and what lies beside them, so many regions away; without those that only corners touch.
RegionSet ChangingBake::around(const RegionSet& regions, std::int32_t by, bool corners) const {
    const Regions& all = context_.regions;
    RegionSet more;
    for (const std::int64_t region : regions) {
        const auto x0 = static_cast<std::int32_t>(region % all.across()),
                   y0 = static_cast<std::int32_t>(region / all.across());
        for (std::int32_t y = std::max(y0 - by, 0); y <= std::min(y0 + by, all.down() - 1); ++y)
            for (std::int32_t x = std::max(x0 - by, 0); x <= std::min(x0 + by, all.across() - 1); ++x)
                if (corners || x == x0 || y == y0) more.insert(std::int64_t{y} * all.across() + x);
    }
    return more;
}

// The places of step 2^z that a region's vertices follow from, counted in places; squares of the step before have the
// same numbers. Only steps that are cut into pages have radii in common with squares further off.
Window ChangingBake::places_read(std::int64_t region, int z) const {
    const Region r = context_.regions.at(region);
    const std::int32_t beyond = 2 * ((z < context_.mixed_log2 ? reach : 0) + 2);
    return {(r.first.column >> z) - 2, (r.first.row >> z) - 2, ((r.last.column - r.first.column) >> z) + beyond,
            ((r.last.row - r.first.row) >> z) + beyond};
}

Window ChangingBake::samples_read(std::int64_t region) const {
    const Region r = context_.regions.at(region);
    return {r.first.column - 2, r.first.row - 2, r.last.column - r.first.column + 2 * (reach + 2),
            r.last.row - r.first.row + 2 * (reach + 2)};
}

// ---- before the work ------------------------------------------------------------------------------------------------

BakedWith ChangingBake::baked_with() const {
    const io::PackFile& file = pack_.file();
    const PackHeader& h = file.pack().header;
    const auto require = [](bool ok, const char* why) {
        if (!ok) throw BakeAll{why};
    };
    require(file.packs() == 1, "it is a set of packs");
    require(h.tiles_held == 0, "it holds a part of the terrain");
    require(h.voids == 0, "it has holes, and what fills them follows from all ground around");
    const std::optional<PackNotes> notes = read_notes(file);
    require(notes && notes->baked, "an earlier version baked it, which does not say with what options");
    const BakedWith& had = *notes->baked;
    require(had.smooth.columns == context_.tree.columns() && had.smooth.rows == context_.tree.rows(),
            "it was split off a larger pack");
    require(had.options == options_hash(context_),
            "it was baked with other options; give those that it was baked with again");
    require(!had.painted, "stamps painted it when it was baked, and that paint is lost");
    require(context_.locks.empty() && notes->locks.empty(), "there are locks");
    require(context_.options.order != PageOrder::linear, "it is in linear order");
    require(!context_.splat.wants_wetness(), "wetness follows from all of the ground");
    return had;
}

CheckpointState ChangingBake::found_of(const HeightStatistics& heights) const {
    CheckpointState found;
    ReadStatistics read;
    read.least_m = heights.least_m, read.most_m = heights.most_m;
    const SourceProperties properties = context_.source.properties(read);
    if (properties.holes) throw BakeAll{"stamps cut holes"};
    found.note_source(properties, false);
    found.heights = heights;
    found.on_scale = exact_;
    return found;
}

HeightStatistics ChangingBake::measure(const HeightStatistics& all) {
    for (const Window& w : changes_.heights) changed_.merge(tiles_at(w));
    if (changed_.empty()) return all;
    const auto measured_by = [&](const HeightSource& source) {
        HeightStatistics sum;
        std::mutex adding;
        const auto make = [&] { return source.reader(); };
        for_tiles({changed_.begin(), changed_.end()}, make, [&](HeightReader& reader, std::uint32_t tile) {
            const Window w = samples_of_tile(tile);
            Buffer<float> heights(w.area());
            ReadStatistics read;
            reader.read(w, heights.data(), read);
            if (read.voids.count != 0) throw BakeAll{"stamps cut holes"};
            const HeightStatistics of_tile = measure_tile(heights.data(), w.columns, w.rows, w.columns);
            const std::lock_guard hold(adding);
            sum.add(of_tile);
        });
        return sum;
    };
    return moved_statistics(all, measured_by(pack_), measured_by(context_.source), exact_, pack_.header().quantum_m);
}

BakePlan ChangingBake::plan_of(const BakedWith& had, const CheckpointState& found) const {
    std::optional<HeightScale> given;
    if (!exact_) given = pack_.height_scale();
    BakePlan plan = make_plan(context_, found, given), before = make_plan(context_, found_of(had.heights), given);
    if (!exact_) plan.maps.smooth = before.maps.smooth = had.smooth;
    const PackHeader &h = plan.header, &was = pack_.header();
    // Heights are floats on their way; they have to find their steps again.
    const float highest = std::max({std::fabs(was.min_m), std::fabs(was.max_m), was.max_m - was.min_m});
    if (!exact_ && !(highest * 0x1p-22f < was.quantum_m / 2)) throw BakeAll{"its steps are finer than floats tell"};
    const bool off_scale =
        !exact_ && (found.heights.least_m < had.heights.least_m || found.heights.most_m > had.heights.most_m ||
                    found.heights.tile_range_m > had.heights.tile_range_m);
    if (!same_scales(plan.scales, before.scales) || h.base_m != was.base_m || h.quantum_m != was.quantum_m ||
        h.error_floor_m != was.error_floor_m || h.error_ratio != was.error_ratio ||
        !std::equal(std::begin(h.level_radius_m), std::end(h.level_radius_m), std::begin(was.level_radius_m)) ||
        off_scale)
        throw BakeAll{"stamps move the bounds that all scales follow from"};
    if (!(plan.maps.ramp == before.maps.ramp)) throw BakeAll{"stamps move the range of heights that colours span"};
    if (!(plan.maps.smooth == before.maps.smooth)) throw BakeAll{"stamps change what counts as the heights' own steps"};
    return plan;
}

// ---- what the pack knows --------------------------------------------------------------------------------------------

// Some of the tiles each, on all threads. make(): what a thread needs; work(it, tile).
template <typename Make, typename Work>
void ChangingBake::for_tiles(const std::vector<std::uint32_t>& tiles, const Make& make, const Work& work) const {
    const std::int64_t parts = std::min<std::int64_t>(context_.threads, static_cast<std::int64_t>(tiles.size()));
    parallel_for(parts, context_.threads, [&](std::int64_t part) {
        const auto own = make();
        for (std::size_t i = static_cast<std::size_t>(part); i < tiles.size(); i += static_cast<std::size_t>(parts))
            work(*own, tiles[i]);
    });
}

// take(tile, each): each(visit) calls visit(tile-local place, height steps, record) for the vertices of step 2^finest
// and of coarser ones.
template <typename Take>
void ChangingBake::for_vertices_of(const RegionSet& regions, int finest, const Take& take) const {
    const PageLayout& layout = context_.pages;
    std::vector<std::uint32_t> pages{0};
    for (std::uint32_t page = 1; page < layout.pages_per_tile(); ++page)
        if (layout.page_step_log2(page) >= finest) pages.push_back(page);
    const auto make = [&] { return std::make_unique<TilePages>(pack_.file()); };
    for_tiles(tiles_of(regions), make, [&](TilePages& held, std::uint32_t tile) {
        held.load_pages(tile, pages);
        const TerrainData& data = data_of(held.terrain());
        take(tile, [&](const auto& visit) {
            for (const std::uint32_t page : pages) {
                const PageEntry entry = data.page_table[std::size_t{tile} * layout.pages_per_tile() + page];
                const VertexRecord* const records = data.records + std::size_t{entry.slot} * data.page_capacity;
                coords_.for_each(page, [&](std::uint32_t i, SampleIndex at) {
                    visit(at, entry.base + records[i].height, records[i]);
                });
            }
        });
    });
}

void ChangingBake::take_step(int z, const RegionSet& regions, StepStores& to) const {
    const int shift = z + 1;
    const std::int32_t n = context_.tree.side() >> shift; // squares a side of a tile
    const std::int32_t mask = (1 << shift) - 1, half = 1 << z;
    for_vertices_of(regions, z, [&](std::uint32_t tile, const auto& each) {
        Buffer<CentreRecord> centres(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
        Buffer<std::uint32_t> places(static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 1));
        each([&](SampleIndex at, std::int32_t steps, const VertexRecord& record) {
            const std::int32_t x = at.column >> shift, y = at.row >> shift;
            if (((at.column | at.row) & mask) == 0)
                places[static_cast<std::size_t>(y * (n + 1) + x)] = static_cast<std::uint32_t>(steps);
            else if ((at.column & mask) == half && (at.row & mask) == half)
                centres[static_cast<std::size_t>(y * n + x)] = {
                    steps, record.error, static_cast<std::uint8_t>(record.radius & ~void_bit), 0};
        });
        const SampleIndex corner = corner_of(tile);
        const std::int32_t x = corner.column >> shift, y = corner.row >> shift;
        const bool last_x = x + n + 1 == to.places.columns(), last_y = y + n + 1 == to.places.rows();
        to.places.write({x, y, n + last_x, n + last_y}, places.data(), n + 1);
        to.centres.write({x, y, n, n}, centres.data(), n);
    });
}

void ChangingBake::take_mixed(const RegionSet& regions, MixedStores& to) const {
    const Tree& tree = context_.tree;
    const int z = context_.mixed_log2;
    // Corners of all tiles, for the chunk that holds them.
    const std::int32_t step = tree.side() >> z, across = tree.tiles_x + 1;
    std::vector<std::byte> raw;
    pack_.file().read_chunk({ChunkKind::corners, 0, 0}, raw);
    std::vector<std::uint32_t> corners(raw.size() / sizeof(std::uint32_t));
    std::memcpy(corners.data(), raw.data(), corners.size() * sizeof(std::uint32_t));
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto corner = static_cast<std::int32_t>(i);
        to.heights.write({corner % across * step, corner / across * step, 1, 1}, &corners[i], 1);
    }
    const std::int32_t side = step + 1;
    for_vertices_of(regions, tree.tile_log2, [&](std::uint32_t tile, const auto& each) {
        std::vector<std::uint16_t> codes(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
        std::vector<std::uint32_t> heights(codes.size());
        each([&](SampleIndex place, std::int32_t steps, const VertexRecord& record) {
            const auto at = static_cast<std::size_t>((place.row >> z) * side + (place.column >> z));
            heights[at] = static_cast<std::uint32_t>(steps);
            codes[at] = static_cast<std::uint16_t>(record.error | record.radius << 8);
        });
        const SampleIndex corner = corner_of(tile);
        const Window w{corner.column >> z, corner.row >> z, side, side};
        to.records.write(w, codes.data(), side);
        to.heights.write(w, heights.data(), side);
    });
}

void ChangingBake::load_heights(const TileSet& tiles) {
    std::vector<std::uint32_t> wanted;
    for (const std::uint32_t tile : tiles)
        if (loaded_.insert(tile).second) wanted.push_back(tile);
    const auto make = [&] { return context_.source.reader(); };
    for_tiles(wanted, make, [&](HeightReader& reader, std::uint32_t tile) {
        // A border's samples are the tile's to the south or east, so that each is written once.
        Window w = samples_of_tile(tile);
        const SampleIndex end = corner_of(tile) + SampleIndex{context_.tree.side(), context_.tree.side()};
        if (end.column < context_.tree.columns() - 1) --w.columns;
        if (end.row < context_.tree.rows() - 1) --w.rows;
        Buffer<float> heights(w.area());
        ReadStatistics read;
        reader.read(w, heights.data(), read);
        heights_m_.write(w, heights.data(), w.columns);
    });
}

// ---- vertices -------------------------------------------------------------------------------------------------------

// Whether half of an error on the region's border is measured in a neighbour's samples that were changed: half a
// diamond of step 2^z reaches so far.
bool ChangingBake::measured_at_border(std::int64_t region, int z) const {
    const Region r = context_.regions.at(region);
    const Window own{r.first.column, r.first.row, r.last.column - r.first.column + 1, r.last.row - r.first.row + 1};
    return meets_any(grown(own, (1 << z) + 1), changes_.heights);
}

// Regions in which a vertex of the step may have another error or radius. moved: what of the step before has.
RegionSet ChangingBake::reached(int z, const std::vector<Window>& moved) const {
    const RegionSet near = around(regions_of(changed_), most_regions, true);
    RegionSet all;
    for (const std::int64_t region : near)
        if (z == 0 ? meets_any(samples_read(region), changes_.heights)
                   : measured_at_border(region, z) || meets_any(places_read(region, z), moved))
            all.insert(region);
    return all;
}

void ChangingBake::measure_borders(const BakePlan& plan, const RegionSet& regions, UnsaturatedStores& unsaturated) {
    RegionSet wanted;
    for (const std::int64_t region : around(regions, 1, false))
        if (measured_.insert(region).second) wanted.insert(region);
    if (wanted.empty()) return;
    for (const std::int64_t region : wanted) load_heights(tiles_at(samples_read(region)));
    only(wanted);
    measure_unsaturated(context_, plan, heights_, unsaturated);
}

// The smallest window of what differs, within `at`.
template <typename T>
Window differing(const Buffer<T>& was, const Store<T>& is, const Window& at) {
    Buffer<T> now(at.area());
    is.read(at, now.data(), at.columns);
    std::int32_t x0 = at.columns, y0 = at.rows, x1 = -1, y1 = -1;
    for (std::int32_t y = 0; y < at.rows; ++y)
        for (std::int32_t x = 0; x < at.columns; ++x) {
            const auto i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(at.columns) + static_cast<std::size_t>(x);
            if (was[i] == now[i]) continue;
            x0 = std::min(x0, x), x1 = std::max(x1, x);
            y0 = std::min(y0, y), y1 = std::max(y1, y);
        }
    return x1 < 0 ? Window{} : Window{at.x + x0, at.y + y0, x1 - x0 + 1, y1 - y0 + 1};
}

// What a region leaves to the next step, as the pack has it.
struct StepBefore {
    Window places_at, centres_at;
    Buffer<std::uint32_t> places;
    Buffer<CentreRecord> centres;
    StepBefore(const Region& r, int z, const StepStores& step) {
        const std::int32_t x = r.first.column >> (z + 1), y = r.first.row >> (z + 1),
                           nx = (r.last.column - r.first.column) >> (z + 1), ny = (r.last.row - r.first.row) >> (z + 1);
        const bool last_x = x + nx + 1 == step.places.columns(), last_y = y + ny + 1 == step.places.rows();
        places_at = {x, y, nx + last_x, ny + last_y};
        centres_at = {x, y, nx, ny};
        places.resize(places_at.area());
        centres.resize(centres_at.area());
        step.places.read(places_at, places.data(), places_at.columns);
        step.centres.read(centres_at, centres.data(), centres_at.columns);
    }
    void differences(const StepStores& step, std::vector<Window>& to) const {
        for (const Window& w :
             {differing(places, step.places, places_at), differing(centres, step.centres, centres_at)})
            if (w.area() != 0) to.push_back(w);
    }
};

// Returns what of the step is other than in the pack.
std::vector<Window> ChangingBake::run_step(const BakePlan& plan, int z, const RegionSet& regions,
                                           UnsaturatedStores& unsaturated, ChunkSpool& spool) {
    StepStores none;
    StepStores& step = z + 1 < context_.tree.tile_log2 ? steps_[static_cast<std::size_t>(z)] : none;
    std::vector<StepBefore> before;
    if (step.exist()) {
        take_step(z, regions, step);
        for (const std::int64_t region : regions) before.emplace_back(context_.regions.at(region), z, step);
    }
    only(regions);
    if (z == 0)
        (void)make_finest_step(context_, plan, heights_, {unsaturated, step, mixed_, spool});
    else
        (void)make_coarser_step(context_, plan,
                                {z, false, unsaturated, steps_[static_cast<std::size_t>(z) - 1], nullptr},
                                {step, mixed_, spool});
    std::vector<Window> moved;
    for (const StepBefore& was : before) was.differences(step, moved);
    return moved;
}

void ChangingBake::make_vertices(const BakePlan& plan, CheckpointState& found, ChunkSpool& spool) {
    found.max_error_m = pack_.header().max_error_m;
    if (changed_.empty()) return;
    const int last_z = context_.tree.tile_log2 - 1;
    UnsaturatedStores unsaturated;
    if (last_z > 0) unsaturated = open_unsaturated(context_);
    mixed_ = open_mixed(context_);
    take_mixed(around(regions_of(changed_), most_regions + 1, true), mixed_);
    // Steps that are cut into pages are large, and little of them is used.
    const Window used = places_of_all(around(regions_of(changed_), most_regions + 1, true));
    for (int z = 0; z < last_z; ++z)
        steps_.push_back(open_step(context_, z, z < context_.mixed_log2 ? used : Window{}));

    RegionSet of_roots = regions_of(changed_), made = reached(0, {});
    for (const std::int64_t region : made) load_heights(tiles_at(samples_read(region)));
    measured_ = made;
    std::vector<Window> moved = run_step(plan, 0, made, unsaturated, spool);
    if (context_.mixed_log2 == 0) of_roots.insert(made.begin(), made.end());
    for (int z = 1; z <= last_z; ++z) {
        const RegionSet now = reached(z, moved);
        measure_borders(plan, now, unsaturated);
        // What the step before has not made is as in the pack.
        RegionSet beside;
        for (const std::int64_t region : around(now, 1, true))
            if (!made.contains(region)) beside.insert(region);
        take_step(z - 1, beside, steps_[static_cast<std::size_t>(z) - 1]);
        moved = run_step(plan, z, now, unsaturated, spool);
        if (z >= context_.mixed_log2) of_roots.insert(now.begin(), now.end());
        steps_[static_cast<std::size_t>(z) - 1].remove();
        made = now;
    }
    only(of_roots);
    found.max_error_m = make_mixed_pages(context_, plan, mixed_, spool);
    const Tree& tree = context_.tree;
    for (std::uint32_t tile = 0; tile < static_cast<std::uint32_t>(tree.tiles_x * tree.tiles_y); ++tile) {
        if (of_roots.contains(region_of(tile))) continue;
        const ChunkId root{ChunkKind::geometry, tile, 0};
        const std::uint8_t code = pack_.file().pack().entry(chunk_index(pack_.header(), root)).bound.error;
        found.max_error_m = std::max(found.max_error_m, plan.scales.errors.metres[code]);
    }
}

// ---- maps -----------------------------------------------------------------------------------------------------------

// The samples that a tile's near mips are made from.
Window ChangingBake::heights_seen(const BakePlan& plan, MapKind kind, std::uint32_t tile) const {
    if (kind != MapKind::splat) return heights_for_maps(plan.maps, tile);
    return heights_for_splat(splat_ground(context_, plan, nullptr), points_for_map(plan.maps, kind, tile));
}

// The last mip that is made while heights are at hand.
constexpr std::uint32_t last_near(std::uint32_t mips) {
    return std::min(near_mips, mips) - 1;
}

// From mip to mip: the texels that changed samples reach, and backwards, what the tiles that hold them are made from.
ChangingBake::MapReach ChangingBake::reach_of(const BakePlan& plan, MapKind kind) const {
    const Tree& tree = context_.tree;
    const MapPlan& maps = plan.maps;
    const std::uint32_t mips = mip_count(maps.log2_side(kind)), near = last_near(mips);
    std::vector<Window> changed = changes_.heights;
    if (kind == MapKind::colour || kind == MapKind::splat)
        changed.insert(changed.end(), changes_.paint.begin(), changes_.paint.end());
    MapReach reach;
    reach.wanted.resize(mips - near);
    reach.made.resize(mips - near);
    if (changed.empty()) return reach;

    // How far a texel of the last near mip sees, in samples.
    TileSet candidates;
    for (const Window& w : changed) candidates.merge(tiles_at(grown(w, tree.side())));
    std::int32_t sees = 0;
    for (const std::uint32_t tile : candidates) {
        const Window seen = heights_seen(plan, kind, tile), own = samples_of_tile(tile);
        sees = std::max({sees, own.x - seen.x, own.y - seen.y, seen.x + seen.columns - own.x - own.columns,
                         seen.y + seen.rows - own.y - own.rows});
        if (meets_any(seen, changed)) reach.wanted[0].insert(tile);
    }
    // Tiles that hold some texels of a mip's grid.
    const auto holding = [&](std::uint32_t mip, const Window& texels) {
        const Window grid = maps.grid(kind, mip), w = common(texels, grid);
        TileSet tiles;
        if (w.area() == 0) return tiles;
        const std::int32_t cells = (grid.columns - 1) / tree.tiles_x;
        for (std::int32_t y = std::max(w.y - 1, 0) / cells; y <= std::min((w.y + w.rows - 1) / cells, tree.tiles_y - 1);
             ++y)
            for (std::int32_t x = std::max(w.x - 1, 0) / cells;
                 x <= std::min((w.x + w.columns - 1) / cells, tree.tiles_x - 1); ++x)
                tiles.insert(static_cast<std::uint32_t>(y * tree.tiles_x + x));
        return tiles;
    };
    std::vector<Window> texels; // that are others, of the mip at hand
    const auto scaled = [](const Window& w, double by, double reach_texels) {
        const auto low = [&](std::int32_t at) { return static_cast<std::int32_t>(std::floor(at * by - reach_texels)); };
        const auto high = [&](std::int32_t at) { return static_cast<std::int32_t>(std::ceil(at * by + reach_texels)); };
        const std::int32_t x = low(w.x), y = low(w.y);
        return Window{x, y, high(w.x + w.columns - 1) - x + 1, high(w.y + w.rows - 1) - y + 1};
    };
    const auto cells_of = [&](std::uint32_t mip) { return (1 << (maps.log2_side(kind) - mip)) - 1; };
    const double a_sample = static_cast<double>(cells_of(near)) / tree.side();
    for (const Window& w : changed) texels.push_back(scaled(w, a_sample, sees * a_sample + 1));
    for (std::uint32_t mip = near + 1; mip < mips; ++mip) {
        const double coarser = static_cast<double>(cells_of(mip)) / cells_of(mip - 1);
        for (Window& w : texels) {
            w = scaled(w, coarser, 1); // a texel sees as far as the next one
            reach.wanted[mip - near].merge(holding(mip, w));
        }
    }
    std::vector<Window> needed; // of the mip at hand, by the next one
    for (std::uint32_t mip = mips; mip-- > near;) {
        TileSet& made = reach.made[mip - near];
        for (const Window& w : needed) made.merge(holding(mip, w));
        for (const std::uint32_t tile : reach.wanted[mip - near]) {
            made.insert(tile);
            needed.push_back(maps.texels(kind, mip, tile));
        }
        if (mip > near)
            for (Window& w : needed) w = finer_texels(maps, kind, mip, w);
    }
    return reach;
}

// Finds what maps reach, and makes room for the heights that are read in all that follows.
void ChangingBake::open_heights(const BakePlan& plan) {
    const Window all{0, 0, context_.tree.columns(), context_.tree.rows()};
    Window used = common(places_of_all(around(regions_of(changed_), most_regions + 2, true)), all);
    for (const MapKind kind : all_map_kinds) {
        if (plan.maps.log2_side(kind) == 0) continue;
        MapReach& reach = reach_[static_cast<std::size_t>(kind)];
        reach = kind == MapKind::horizon ? reach_of_horizons(plan) : reach_of(plan, kind);
        for (const std::uint32_t tile : tiles_of(regions_of(reach.made[0])))
            used = both(used, kind == MapKind::horizon ? all : around_tiles(heights_seen(plan, kind, tile)));
    }
    heights_m_ = context_.open<float>("heights", all.columns, all.rows, used);
}

// The samples of all tiles that have one of these.
Window ChangingBake::around_tiles(const Window& samples) const {
    Window all;
    for (const std::uint32_t tile : tiles_at(samples)) all = both(all, samples_of_tile(tile));
    return all;
}

// Horizons look over all of the terrain, and what they see are means of all of it.
ChangingBake::MapReach ChangingBake::reach_of_horizons(const BakePlan& plan) const {
    const std::uint32_t mips = mip_count(plan.maps.horizon_log2);
    const TileSet all = changed_.empty() ? TileSet{} : tiles_at({0, 0, context_.tree.columns(), context_.tree.rows()});
    const std::vector<TileSet> of_mips(mips - last_near(mips), all);
    return {of_mips, of_mips};
}

// The regions of these tiles, with the heights that they are made from.
RegionSet ChangingBake::load_for(const BakePlan& plan, MapKind kind, const TileSet& tiles) {
    const RegionSet regions = regions_of(tiles);
    TileSet all;
    for (const std::uint32_t tile : tiles_of(regions)) all.merge(tiles_at(heights_seen(plan, kind, tile)));
    load_heights(all);
    return regions;
}

void ChangingBake::make_far_mips(const BakePlan& plan, MapKind kind, TexelStore finer, ChunkSpool& spool) {
    const MapReach& reach = reached_by(kind);
    const std::uint32_t mips = mip_count(plan.maps.log2_side(kind)), near = last_near(mips);
    for (std::uint32_t mip = near + 1; mip < mips; ++mip) {
        TexelStore texels;
        if (mip + 1 < mips) texels = open_texels(context_, plan.maps, kind, mip);
        const TileSet &made = reach.made[mip - near], &wanted = reach.wanted[mip - near];
        SomeChunks some(spool, [&](const ChunkId& id) { return wanted.contains(id.tile); });
        only(regions_of(made));
        if (!made.empty()) make_far_mip(context_, plan, {kind, mip, finer}, {texels, some});
        finer.remove();
        finer = std::move(texels);
    }
}

TexelStore open_last_near(const BakeContext& context, const MapPlan& maps, MapKind kind) {
    return mip_count(maps.log2_side(kind)) > near_mips ? open_texels(context, maps, kind, near_mips - 1) : TexelStore{};
}

void ChangingBake::make_colours_and_normals(const BakePlan& plan, ChunkSpool& spool) {
    const MapReach &colour = reached_by(MapKind::colour), &normal = reached_by(MapKind::normal);
    TileSet made = colour.made[0], stored = colour.wanted[0];
    made.insert(normal.made[0].begin(), normal.made[0].end());
    stored.insert(normal.wanted[0].begin(), normal.wanted[0].end());
    if (made.empty()) return;
    only(load_for(plan, MapKind::colour, made));
    TexelStore colours = open_last_near(context_, plan.maps, MapKind::colour),
               normals = open_last_near(context_, plan.maps, MapKind::normal);
    SomeChunks some(spool, [&](const ChunkId& id) {
        return (id.kind == ChunkKind::colour ? colour : normal).wanted[0].contains(id.tile);
    });
    BakePlan of_these = plan;
    of_these.maps.stored = &stored;
    make_near_maps(context_, of_these, heights_, {colours, normals, some});
    make_far_mips(plan, MapKind::colour, std::move(colours), spool);
    make_far_mips(plan, MapKind::normal, std::move(normals), spool);
}

void ChangingBake::make_splat(const BakePlan& plan, ChunkSpool& spool) {
    const MapReach& reach = reached_by(MapKind::splat);
    if (reach.made[0].empty()) return;
    only(load_for(plan, MapKind::splat, reach.made[0]));
    TexelStore shares = open_last_near(context_, plan.maps, MapKind::splat);
    SomeChunks some(spool, [&](const ChunkId& id) { return reach.wanted[0].contains(id.tile); });
    BakePlan of_these = plan;
    of_these.maps.stored = &reach.wanted[0];
    make_near_splat(context_, of_these, heights_, nullptr, {shares, some});
    make_far_mips(plan, MapKind::splat, std::move(shares), spool);
}

void ChangingBake::make_horizons(const BakePlan& plan, ChunkSpool& spool) {
    const MapReach& reach = reached_by(MapKind::horizon);
    if (reach.made[0].empty()) return;
    load_heights(reach.made[0]);
    only(regions_of(reach.made[0]));
    Store<float> levels = open_levels(context_);
    make_levels(context_, heights_, levels);
    TexelStore planes = open_last_near(context_, plan.maps, MapKind::horizon);
    make_near_horizons(context_, plan, {heights_, levels_in(context_, levels)}, {planes, spool});
    levels.remove();
    make_far_mips(plan, MapKind::horizon, std::move(planes), spool);
}

BakeSummary ChangingBake::run() {
    const Clock::time_point start = Clock::now();
    const BakedWith had = baked_with();
    exact_ = had.on_scale;
    CheckpointState found = found_of(measure(had.heights));
    BakePlan plan = plan_of(had, found);
    only(regions_of(changed_)); // stores take room as they are written from now on
    ChunkSpool spool(context_.store_path("chunks"), context_.store_path("entries"), plan.header, SpoolState{});
    const double seconds_read = elapsed_s(start);
    const Clock::time_point maps_start = Clock::now();
    open_heights(plan);
    make_colours_and_normals(plan, spool);
    make_splat(plan, spool);
    make_horizons(plan, spool);
    const double seconds_textures = elapsed_s(maps_start);
    const Clock::time_point errors_start = Clock::now();
    make_vertices(plan, found, spool);
    plan.header.max_error_m = found.max_error_m;
    BakeSummary summary = summary_of(context_, found, plan.header);
    summary.smooth = plan.maps.smooth;
    summary.seconds_read = seconds_read;
    summary.seconds_textures = seconds_textures;
    summary.seconds_errors = elapsed_s(errors_start);
    const Clock::time_point write_start = Clock::now();
    const PackChunks had_chunks(pack_.file());
    const MadeAndKept chunks(spool, had_chunks);
    summary.kept_bytes = chunks.kept_bytes();
    write_pack(context_, plan.header, chunks, summary);
    summary.seconds_write = elapsed_s(write_start);
    summary.seconds_total = elapsed_s(start);
    return summary;
}

} // namespace

ChangedBake bake_changed(const HeightSource& source, const BakeOptions& options, const std::string& out_path) {
    const PackChanges* const changes = source.changes();
    if (changes == nullptr) return {};
    try {
        return {ChangingBake(source, *changes, options, out_path).run(), {}};
    } catch (const BakeAll& all) {
        return {std::nullopt, all.why};
    }
}

} // namespace fjell::baker
