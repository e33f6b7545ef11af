// What the tests of the library for C share: a pack, memory for a host in C, and its views (c_host.c).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "fjell/fjell.h"
#include "support/terrain_fixture.h"
#include "unit/c_host.h"

namespace fjell::test {

struct Memory : Allocator {
    Memory() : Allocator{&give} {}
    static void* give(Allocator* self, std::size_t bytes) {
        auto& pieces = static_cast<Memory*>(self)->pieces;
        pieces.push_back(io::allocate(bytes));
        return pieces.back().get();
    }
    std::span<std::byte> span(std::size_t bytes) { return {static_cast<std::byte*>(give(this, bytes)), bytes}; }
    std::vector<io::AlignedMemory> pieces;
};

// 1,600 m x 890 m of hills.
inline io::LoadedPack a_pack() {
    Random random(1701);
    baker::Dem dem = random_dem(random, 161, 90, Shape::fractal);
    const auto [low, high] = std::ranges::minmax(dem.heights_m);
    for (float& height_m : dem.heights_m) height_m = 400 * (height_m - low) / (high - low);
    dem.spacing_m[0] = dem.spacing_m[1] = 10;
    baker::BakeOptions options = small_bake(6);
    options.max_texture_log2 = 5;
    return bake_and_load(std::move(dem), options);
}

// Those of c_host.c.
inline View view_of(int frame) {
    return make_view({100 + 5.0 * frame, 800, 100}, {1, -1, 0.5}, {0, 1, 0}, 1, 1280, 720, 1, 1e5);
}

} // namespace fjell::test
