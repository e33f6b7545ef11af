// What all stages of a bake share: what is baked and how, threads and memory to do it with, and the work folder.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/heights/region.h"
#include "baker/locks/locks.h"
#include "baker/maps/image.h"
#include "baker/maps/splat.h"
#include "baker/store/store.h"
#include "shared/order.h"
#include "shared/tree.h"

namespace fjell::baker {

// How much a bake keeps outside of its threads: in memory when it fits there, in the work folder otherwise.

// log2 of texels a side of a tile's maps; 0: none.
struct MapSizes {
    std::uint32_t colour_log2 = 0, normal_log2 = 0, horizon_log2 = 0, splat_log2 = 0;
};

// The most bytes that all stores of a bake and the pack's compressed chunks take at once, whatever the heights are:
// the stores by their sizes, chunks as if nothing in them could be compressed. Not the pack itself, which grows when
// the other stores are gone. O(1).
[[nodiscard]] std::uint64_t work_bytes(const Tree& tree, PageOrder order, const MapSizes& maps);

// A loop over the independent units of a stage: windows, tiles or regions.
struct UnitLoop {
    const char* name; // for the progress
    std::uint64_t count;
    int workers;
    double samples; // that one unit counts for in the progress
};

class BakeContext {
public:
    // Makes the work folder and opens the images; nothing of an earlier run is touched. part: regions that are baked,
    // counted in regions, for a shard of the terrain; no area: all of them. Throws Failure.
    BakeContext(const HeightSource& the_source, const BakeOptions& the_options, const std::string& the_out_path,
                const Window& the_part = {});

    // Calls unit(i) for i in [0, loop.count) on loop.workers threads. Throws what units and the progress throw.
    void run_units(const UnitLoop& loop, const std::function<void(std::uint64_t)>& unit) const;
    // As many threads as the memory allows, of which a unit takes this much at its largest. Throws Failure 2 for none.
    [[nodiscard]] int workers_for(std::uint64_t unit_bytes) const;
    // A work file's path; empty: the store is to lie in memory.
    [[nodiscard]] std::string store_path(const std::string& name) const;
    // A new store, or what an earlier run has left of it.
    // held: the part of it that is used; no area: all.
    template <typename T>
    [[nodiscard]] Store<T> open(const std::string& name, std::int64_t columns, std::int64_t rows,
                                const Window& held = {}) const {
        const auto room = leaves_out_ ? WorkFile::Room::as_written : WorkFile::Room::reserved;
        return {store_path(name), columns, rows, held, room};
    }
    // Where the pack grows until it is complete; empty: at its own place, which is a device.
    [[nodiscard]] std::string temporary() const;
    // All that the pack's bytes depend on, as text; and that without the heights.
    [[nodiscard]] std::string identity() const;
    [[nodiscard]] std::string options_identity() const;
    [[nodiscard]] double samples() const { return static_cast<double>(sample_window().area()); }
    // What is baked here: all of the terrain, or a shard's part of it.
    [[nodiscard]] Window region_window() const;
    [[nodiscard]] Window tile_window() const { return regions.tiles_of(region_window()); }
    [[nodiscard]] Window sample_window() const { return regions.samples_of(region_window()); }
    // Regions and tiles that are baked: all of the window, or what leave_out() has left of it.
    [[nodiscard]] std::uint64_t region_count() const { return leaves_out_ ? kept_.size() : region_window().area(); }
    [[nodiscard]] std::uint64_t tile_count() const { return leaves_out_ ? kept_tiles_.size() : tile_window().area(); }
    // The u-th of them: its number among all.
    [[nodiscard]] std::int64_t region_at(std::uint64_t u) const;
    [[nodiscard]] std::uint32_t tile_at(std::uint64_t u) const;
    // From now on only regions for which keeps(number) is true are baked, of all: shards leave voids out, and a bake of
    // stamps what they do not reach.
    void leave_out(const std::function<bool(std::int64_t region)>& keeps);
    [[nodiscard]] bool leaves_out() const { return leaves_out_; }

private:
    [[nodiscard]] std::string splat_identity() const;
    bool leaves_out_ = false;
    std::vector<std::int64_t> kept_;
    std::vector<std::uint32_t> kept_tiles_;

public:
    const HeightSource& source;
    const BakeOptions& options;
    const std::string out_path;
    const Tree tree;
    const Regions regions;
    const Window part; // of the regions; no area: all
    const PageLayout pages;
    const int threads;
    // log2 of the finest step whose vertices lie in pages of several steps; 0 in linear order: all of them.
    const int mixed_log2;

    WorkFolder folder;
    const Locks locks;
    const std::unique_ptr<ImageSource> image; // or none
    const SplatPlan splat;                    // without rules: none
    const SplatImages splat_images;
    const std::uint32_t colour_log2, normal_log2, horizon_log2, splat_log2; // texels a side of mip 0; 0: no such map
    const std::uint64_t enough_bytes;                                       // of memory, for all stores to lie there
    const bool in_memory; // all stores: only the pack itself goes to the folder, and nothing can be resumed
};

} // namespace fjell::baker
