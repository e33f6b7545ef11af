// cut_golden PACK: flies the golden flight with the vector and the scalar evaluation and prints their hashes in one
// line. Built with the runtime's own sources under several compilers and optimisations: cut_golden.cmake compares.
#include "cut_golden.h"

#include <cinttypes>
#include <cstdio>
#include <new>

#include "fjell/pack.h"

using namespace fjell;

namespace {

std::span<std::byte> block_of(std::size_t bytes) {
    const std::size_t whole = (bytes + 63) / 64 * 64;
    return {static_cast<std::byte*>(::operator new (whole, std::align_val_t{64})), whole};
}

std::vector<std::byte> read(const char* path) {
    std::vector<std::byte> bytes;
    if (std::FILE* file = std::fopen(path, "rb")) {
        std::byte part[4096];
        for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, file)) != 0;)
            bytes.insert(bytes.end(), part, part + n);
        std::fclose(file);
    }
    return bytes;
}

} // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    const std::vector<std::byte> file = read(arguments[1]);
    Pack pack;
    if (!open_pack(file, pack).ok()) return std::fputs("no pack\n", stderr), 1;
    Terrain terrain;
    if (!load_terrain(pack, block_of(terrain_bytes(pack.header)), terrain).ok()) return 1;
    const std::size_t bytes = cut_bytes(terrain, test::golden_budget(terrain));
    const test::Golden vector = test::fly_golden(terrain, block_of(bytes), false),
                       scalar = test::fly_golden(terrain, block_of(bytes), true);
    if (!vector.ok || !scalar.ok) return std::fputs("a frame was refused\n", stderr), 1;
    std::printf("vector %016" PRIx64 " %016" PRIx64 " scalar %016" PRIx64 " %016" PRIx64 "\n", vector.triangles,
                vector.work, scalar.triangles, scalar.work);
    return 0;
}
