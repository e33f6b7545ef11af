// Writes seeds for fuzz_pack into the folder given: small packs, once as they are and once to be repaired after
// mutation.
#include <cstdio>
#include <fstream>
#include <string>

#include "support/terrain_fixture.h"

int main(int argc, char** argv) {
    using namespace fjell::test;
    if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
    Random random(31);
    int number = 0;
    for (const auto& [log2, columns, rows] : {std::tuple{1, 3, 3}, {1, 9, 5}, {2, 17, 9}, {3, 17, 17}}) {
        auto dem = random_dem(random, columns, rows, Shape::fractal);
        if (number & 1) dem.crs_wkt = "LOCAL_CS[\"seed\"]";
        const auto pack = bake_and_load(std::move(dem), small_bake(log2));
        for (const char mode : {'\0', '\1'}) {
            std::ofstream file(std::string(argv[1]) + "/pack" + std::to_string(number++), std::ios::binary);
            file.put(mode);
            file.write(reinterpret_cast<const char*>(pack.file.data()), static_cast<std::streamsize>(pack.file.size()));
            if (!file.good()) return std::fprintf(stderr, "%s: cannot write a seed\n", argv[1]), 3;
        }
    }
    return 0;
}
