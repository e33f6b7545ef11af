// sizes PACK: where a pointer has 32 bits, what does not fit is refused and not made to fit; and C has the sizes of
// C++.
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <vector>

#include "fjell/fjell.h"
#include "fjell/fjell_c.h"

using namespace fjell;

namespace {

constexpr std::size_t room = std::size_t{64} << 20; // for the terrain, and too little for the others

std::span<std::byte> allocate(std::size_t bytes) {
    return {static_cast<std::byte*>(::operator new (bytes, std::align_val_t{64})), bytes};
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

// A size of more than 2^32 bytes: itself, or as much as no memory has.
bool is_large(std::size_t bytes) {
    return static_cast<std::uint64_t>(bytes) > 0xffffffffu ||
           (sizeof bytes == 4 && bytes > std::numeric_limits<std::size_t>::max() - 64);
}

int fail(const char* what) {
    std::fprintf(stderr, "sizes: %s\n", what);
    return 1;
}

} // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    const std::vector<std::byte> file = read(arguments[1]);
    Pack pack;
    if (!open_pack(file, pack).ok()) return fail("no pack");
    const std::span<std::byte> memory = allocate(room);
    Terrain terrain;
    if (!load_terrain(pack, memory, terrain).ok()) return fail("no terrain");

    CutBudget wide;
    wide.vertices = 1u << 28;
    wide.triangles = 1u << 29;
    if (!is_large(cut_bytes(terrain, wide))) return fail("cut_bytes() wraps");
    const std::span<std::byte> little = allocate(room);
    LiveCut cut;
    if (create_cut(terrain, wide, little, cut).code != StatusCode::memory_too_small) return fail("a cut without room");

    RecursiveBudget many;
    many.vertices = 1u << 30;
    many.indices = 1u << 30;
    if (!is_large(recursive_bytes(terrain, many))) return fail("recursive_bytes() wraps");
    RecursiveMethod method;
    if (create_recursive(terrain, many, little, method).code != StatusCode::memory_too_small)
        return fail("a recursive method without room");

    PackHeader vast = pack.header;
    vast.tiles_x = vast.tiles_y = 1u << 17;
    if (!is_large(chunk_raw_bytes(vast, {ChunkKind::corners, 0, 0}))) return fail("chunk_raw_bytes() wraps");

    FjellCutBudget budget = fjell_cut_budget_default();
    budget.vertices = 20000;
    budget.triangles = 40000;
    const CutBudget same{.vertices = 20000, .triangles = 40000};
    FjellTerrain in_c;
    static_assert(sizeof in_c == sizeof terrain);
    std::memcpy(&in_c, static_cast<const void*>(&terrain), sizeof in_c);
    if (fjell_cut_bytes(in_c, &budget) != cut_bytes(terrain, same)) return fail("C has another cut_bytes()");
    FjellLiveCut cut_in_c{};
    if (fjell_create_cut(in_c, &budget, little.data(), little.size(), &cut_in_c).code != FJELL_OK)
        return fail("no cut from C");
    FjellView view = fjell_view_default();
    view.eye_m.y = 500;
    FjellCutReport report{};
    report.struct_size = sizeof report;
    if (fjell_update_cut(cut_in_c, &view, 1, nullptr, &report).code != FJELL_OK || report.triangles == 0)
        return fail("no update from C");
    std::printf("sizes of %zu bits, %" PRIu32 " triangles from C\n", sizeof(std::size_t) * 8, report.triangles);
    return 0;
}
