// Pack sets for tests: a pack that is split, with some of its packs left out or not.
#pragma once

#include <string>

#include "baker/pack/write_set.h"
#include "io/file.h"
#include "io/set_file.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

namespace fjell::test {

// Leaves packs out of a set, by chance; at least one stays, and one goes if there are two.
inline void thin_out(Random& random, const std::string& folder) {
    const std::string path = folder + "/set.json";
    io::SetFile set = io::parse_set_file(io::read_text(path), path);
    if (set.packs.size() == 1) return;
    const auto keeps = static_cast<std::size_t>(pick(random, 1, static_cast<int>(set.packs.size()) - 1));
    std::shuffle(set.packs.begin(), set.packs.end(), random); // their order in the set says nothing
    set.packs.resize(keeps);
    spit(path, io::set_file_text(set));
}

// A pack, and the set that it was split into.
struct PackAndSet {
    PackAndSet(Random& random, baker::Dem dem, const baker::BakeOptions& options) {
        (void)baker::bake(std::move(dem), options, pack);
        const io::PackFile file(pack);
        const PackHeader& h = file.pack().header;
        const auto parts = [&](std::uint32_t tiles) {
            return static_cast<std::uint32_t>(pick(random, 1, static_cast<int>(std::min(tiles, 5u))));
        };
        split = {parts(h.tiles_x), parts(h.tiles_y)};
        (void)baker::split_pack(pack, set, split);
    }
    TemporaryFolder folder;
    const std::string pack = folder / "pack.fjell", set = folder / "set";
    baker::SetGrid split;
};

} // namespace fjell::test
