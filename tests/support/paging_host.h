// A host that loads and unloads pages under a live cut, at random.
#pragma once

#include <catch2/catch.hpp>

#include "support/cut_scene.h"

namespace fjell::test {

struct Page {
    std::uint32_t tile, page;
    friend bool operator==(const Page&, const Page&) = default;
};

// A host that loads and unloads at random.
struct Host {
    Random& random;
    const Pack& pack;
    Terrain& terrain;
    Cut& cut;
    bool abrupt = false;                       // pages may be unloaded without being evicted first
    std::vector<Page> evicting, just_unloaded; // just_unloaded: in eviction until then, since the last frame
    std::uint32_t loaded = 0, released = 0, unloaded = 0;

    [[nodiscard]] Page any() {
        return {static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.tile_count()) - 1)),
                static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.pages_per_tile()) - 1))};
    }
    [[nodiscard]] bool is_loaded(Page p) const {
        return data_of(terrain).page_table[p.tile * terrain.pages_per_tile() + p.page].slot != no_index;
    }
    void load(Page p) {
        for (const auto& pages : {evicting, just_unloaded})
            if (std::find(pages.begin(), pages.end(), p) != pages.end()) return;
        const std::uint32_t missing = terrain.pages_missing();
        const Status s = load_page(pack, terrain, p.tile, p.page);
        REQUIRE((s.ok() || s.code == StatusCode::coarser_page_first || s.code == StatusCode::out_of_slots));
        loaded += missing - terrain.pages_missing();
    }
    void load_all() { // as far as the slots go, coarse ones first
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) load({tile, page});
    }
    void act() {
        just_unloaded.clear();
        for (int n = pick(random, 0, 6); n > 0; --n) {
            if (pick(random, 0, 2)) load(any());
            const Page p = any();
            if (!is_loaded(p)) continue;
            if (abrupt && pick(random, 0, 2) == 0) {
                (void)unload_page(terrain, p.tile, p.page);
                if (std::erase(evicting, p) != 0) just_unloaded.push_back(p); // comes back in another frame: see below
                ++unloaded;
            } else if (pick(random, 0, 1) && std::find(evicting.begin(), evicting.end(), p) == evicting.end()) {
                evicting.push_back(p);
            }
        }
        if (pick(random, 0, 9) == 0) load_all();
        collect();
    }
    // One of those that leave stays after all. False: none leaves.
    bool keep() {
        if (evicting.empty()) return false;
        const auto page = evicting.begin() + pick(random, 0, static_cast<int>(evicting.size()) - 1);
        REQUIRE(cut_cancel_release(cut.cut, page->tile, page->page).ok());
        evicting.erase(page);
        return true;
    }
    // Calls cut_release_page() for every page in eviction, and unloads those that are released.
    void collect() {
        std::erase_if(evicting, [&](Page p) {
            bool free = false;
            REQUIRE(cut_release_page(cut.cut, p.tile, p.page, free).ok());
            if (!free) return false;
            (void)unload_page(terrain, p.tile, p.page);
            ++released;
            return true;
        });
    }
};

[[nodiscard]] inline io::LoadedPack paged_terrain(Random& random, bool large) {
    const int log2 = large ? pick(random, 7, 9) : pick(random, 1, 5);
    const int most = large ? 400 : std::min(90, 20 << log2);
    baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most),
                                pick(random, 0, 1) ? Shape::fractal : Shape::noise);
    if (pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2);
    options.order = pick(random, 0, 2) == 0 ? PageOrder::hierarchical_z : PageOrder::planar;
    return bake_and_load(std::move(dem), options);
}

} // namespace fjell::test
