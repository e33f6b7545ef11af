// web_flight PACK: the flight of flight.mjs, natively. Prints the hash over the triangles of every frame, and the work.
#include <array>
#include <bit>
#include <cinttypes>
#include <cstdio>

#include "fjell/fjell.h"
#include "fjell/io/load.h"

using namespace fjell;

namespace {

std::uint32_t hashed(std::uint32_t hash, std::uint32_t value) {
    return (hash ^ value) * 16777619u;
}

class Random { // flight.mjs has the same
public:
    double part() {
        state_ = state_ * 1664525u + 1013904223u;
        return (static_cast<double>(state_ >> 11) - (1 << 20)) / (1 << 20);
    }

private:
    std::uint32_t state_ = 2024;
};

std::uint32_t sum_of(const MeshView& mesh) { // in whatever order the ranges are
    std::uint32_t sum = 0;
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; i += 3) {
            std::uint32_t hash = 2166136261u;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const MeshVertex& v = mesh.vertices[mesh.indices[i + k]];
                hash = hashed(hashed(hash, static_cast<std::uint32_t>(v.column)), static_cast<std::uint32_t>(v.row));
                hash = hashed(hash, std::bit_cast<std::uint32_t>(v.height_m));
            }
            sum += hash;
        }
    return sum;
}

} // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    const io::LoadedPack loaded = io::load_pack(arguments[1], io::LoadTerrain::yes);
    const Terrain& terrain = loaded.terrain;
    const CutBudget budget = {.vertices = 6000, .triangles = 12000, .segment_triangles = 512, .views = 2};
    CutBudget suited = budget; // as the package does
    while (suited.segment_triangles > 8 && suited.triangles / suited.segment_triangles < 4 * terrain.tile_count())
        suited.segment_triangles /= 2;
    const io::AlignedMemory memory = io::allocate(cut_bytes(terrain, suited));
    LiveCut cut;
    if (!create_cut(terrain, suited, {memory.get(), cut_bytes(terrain, suited)}, cut).ok()) return 1;
    const double wide = static_cast<double>(terrain.extent_x_m()), deep = static_cast<double>(terrain.extent_z_m());
    Random random;
    std::uint32_t triangles = 2166136261u, work = 2166136261u;
    std::array<View, 2> views;
    Vec3 eye{wide / 2, 4000, deep / 2};
    for (int frame = 0; frame < 240; ++frame) {
        const double stride = frame % 60 < 40 ? 20 : 400;
        eye = eye + Vec3{random.part(), random.part() * 0.5, random.part()} * stride;
        if (frame % 80 == 79)
            eye = {wide / 2 + random.part() * wide / 2, 3000 + random.part() * 1000,
                   deep / 2 + random.part() * deep / 2};
        views[0].eye_m = eye;
        views[1].eye_m = Vec3{wide, 6000, deep} - eye * 0.25;
        CutSettings settings;
        settings.max_error_px = 0.75 + 3.25 * (frame / 30 % 4);
        settings.hysteresis = frame % 120 < 60 ? 0 : 0.25;
        settings.max_work = frame % 7 < 3 ? 150 : unlimited_work;
        CutReport report;
        if (!update_cut(cut, std::span(views).first(frame % 50 < 30 ? 1u : 2u), settings, report).ok()) return 1;
        triangles = hashed(triangles, sum_of(cut_mesh(cut).mesh));
        for (const std::uint32_t n :
             {report.work, report.activations, report.deactivations, report.waiting, report.triangles})
            work = hashed(work, n);
    }
    std::printf("%08" PRIx32 " %08" PRIx32 "\n", triangles, work);
    return 0;
}
