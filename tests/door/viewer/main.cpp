// Draws a pack once, without a window, and writes the mesh as glTF. Prints what a script can check.
#include <cstdio>
#include <string>

#include <fjell/gl/context.h>
#include <fjell/gl/renderer.h>
#include <fjell/gl/target.h>
#include <fjell/gltf/snapshot.h>
#include <fjell/io/load.h>

namespace {

int fail(const std::string& what) {
    std::fprintf(stderr, "viewer: %s\n", what.c_str());
    return 1;
}

int draw(const fjell::io::LoadedPack& loaded, const fjell::View& view) {
    const auto context = fjell::gl::Headless::create();
    const auto target = fjell::gl::Target::create({view.width_px, view.height_px});
    const fjell::CutBudget budget{.vertices = 1u << 17, .triangles = 1u << 18};
    const auto renderer = fjell::gl::Renderer::create(
        loaded.terrain, loaded.pack, {.ranges = budget.triangles / budget.segment_triangles, .morph = true});
    const std::size_t bytes = fjell::cut_bytes(loaded.terrain, budget);
    const fjell::io::AlignedMemory memory = fjell::io::allocate(bytes);
    fjell::LiveCut cut;
    if (!fjell::create_cut(loaded.terrain, budget, {memory.get(), bytes}, cut).ok()) return fail("no cut");
    fjell::CutReport report;
    if (!fjell::update_cut(cut, {&view, 1}, {}, report).ok()) return fail("no mesh");
    renderer->draw(fjell::cut_mesh(cut), fjell::cut_take_changes(cut), view, {}, *target);
    std::printf("drawn %u triangles\n", report.triangles_drawn);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const fjell::io::LoadedPack loaded = fjell::io::load_pack(argv[1], fjell::io::LoadTerrain::yes);
    const fjell::View view = fjell::make_view({100, 4000, 100}, {1, -0.5, 1}, {0, 1, 0}, 1, 320, 240, 1, 1e5);
    if (draw(loaded, view) != 0) return 1;
    const auto written = fjell::gltf::export_snapshot(loaded.pack, loaded.terrain, view, 4, argv[2]);
    std::printf("exported %llu triangles\n", static_cast<unsigned long long>(written.triangles));
    return 0;
}
