// A stream over a terrain, with a client that answers late, wrongly, or never, as a script of random numbers says.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "fjell/stream.h"
#include "stream/state.h"
#include "support/cut_scene.h"

namespace fjell::test {

// Terrains of several pages a tile and several tiles.
[[nodiscard]] inline io::LoadedPack streamed_terrain(Random& random, bool with_holes = true) {
    const int log2 = pick(random, 6, 8), most = (512 >> pick(random, 0, 2)) + pick(random, 0, 70);
    baker::Dem dem = random_dem(random, pick(random, 70, most), pick(random, 70, most),
                                pick(random, 0, 3) ? Shape::fractal : Shape::noise);
    if (with_holes && pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2);
    options.order = pick(random, 0, 2) == 0 ? PageOrder::hierarchical_z : PageOrder::planar;
    return bake_and_load(std::move(dem), options);
}

// What a client does with requests, in shares of 1; the rest is answered well.
struct ClientScript {
    double fails = 0, garbage = 0, short_reads = 0, never = 0;
    int most_delay = 0; // frames
    int most_taken = 8; // requests a frame
};

// A stream with its terrain, cut and memory over a pack in memory.
struct Streamed {
    Streamed(const Pack& source, std::uint32_t page_slots, const StreamBudget& budget = {}, std::uint32_t views = 1);
    Streamed(const Pack& source, const CutBudget& cut_budget, std::uint32_t page_slots, const StreamBudget& budget);
    StreamReport update(std::span<const View> views, const CutSettings& cut_settings, const StreamSettings& settings);
    [[nodiscard]] StreamState& state() { return data_of(stream); }
    const Pack& pack;
    PagedTerrain paged;
    Cut cut;
    io::AlignedMemory memory;
    Stream stream;
};

// The client's side in the frame's thread. Keeps account of what was read, so that nothing may be read twice without
// having been given up in between.
struct ScriptedClient {
    ScriptedClient(Random& numbers, Streamed& streamed, const ClientScript& what);
    // Once a frame, before the update: answers what is due, then takes more.
    void act();
    // After the update: which pages went.
    void follow();
    [[nodiscard]] bool idle() const { return held.empty(); }

    struct Held {
        StreamRequest request;
        int due;
    };
    Random& random;
    Streamed& on;
    ClientScript script;
    std::vector<Held> held;
    std::set<std::pair<std::uint32_t, std::uint32_t>> there; // pages
    std::vector<ChunkId> broken;                             // answered with what is no page
    std::uint64_t taken = 0, answered = 0, declined = 0, lost = 0, read_twice = 0;
    int frame = 0;
};

// Empty when validate_terrain() and validate_stream() find nothing (validate.h), otherwise what they do.
[[nodiscard]] std::string check_stream(Streamed& streamed);

} // namespace fjell::test
