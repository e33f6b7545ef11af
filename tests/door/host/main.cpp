// The game: opens a pack, loads it, draws one frame's mesh into nothing. Prints what a script can check.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#include "fjell/cut.h"
#include "fjell/terrain.h"

namespace {

struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
};
using Memory = std::unique_ptr<std::byte, Free>;

std::span<std::byte> allocate(std::vector<Memory>& owner, std::size_t bytes) {
    const std::size_t rounded = (bytes + 63) / 64 * 64;
    owner.emplace_back(static_cast<std::byte*>(std::aligned_alloc(64, rounded)));
    return {owner.back().get(), rounded};
}

int fail(const char* what, fjell::Status status) {
    std::fprintf(stderr, "game: %s: %s: %s\n", what, status.field, fjell::message(status.code));
    return 1;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    std::ifstream file(argv[1], std::ios::binary);
    const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
    std::vector<Memory> owner; // outlives what lies in it

    fjell::Pack pack;
    if (fjell::Status s = fjell::open_pack(std::as_bytes(std::span(chars)), pack); !s.ok()) return fail("pack", s);
    fjell::Terrain terrain;
    if (fjell::Status s = fjell::load_terrain(pack, allocate(owner, fjell::terrain_bytes(pack.header)), terrain);
        !s.ok())
        return fail("terrain", s);
    const fjell::CutBudget budget{};
    fjell::LiveCut cut;
    if (fjell::Status s = fjell::create_cut(terrain, budget, allocate(owner, fjell::cut_bytes(terrain, budget)), cut);
        !s.ok())
        return fail("cut", s);
    const fjell::View view = fjell::make_view({100, 2000, 100}, {1, -1, 1}, {0, 1, 0}, 1, 1280, 720, 1, 1e5);
    fjell::CutReport report;
    if (fjell::Status s = fjell::update_cut(cut, {&view, 1}, {}, report); !s.ok()) return fail("view", s);
    std::printf("%u triangles, converged %d\n", report.triangles, report.converged);
    return report.converged && report.triangles > 0 ? 0 : 1;
}
