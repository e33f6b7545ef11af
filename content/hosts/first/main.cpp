// The shortest host: a pack in memory, a view, a picture. docs/guides/embedding.md begins with it.
//   first PACK PICTURE.png
#include <cstdio>
#include <string>

#include <fjell/fjell.h>
#include <fjell/gl/context.h>
#include <fjell/gl/image.h>
#include <fjell/gl/renderer.h>
#include <fjell/gl/target.h>
#include <fjell/io/failure.h>
#include <fjell/io/load.h>

namespace {

using fjell::io::Failure;

// From the middle of the southern border, over all peaks, towards the middle of the terrain.
fjell::View look(const fjell::Terrain& terrain) {
    const double wide_m = terrain.extent_x_m(), deep_m = terrain.extent_z_m(), high_m = terrain.header().max_m;
    const fjell::Vec3 eye_m{wide_m / 2, high_m + deep_m / 10, deep_m}, middle_m{wide_m / 2, high_m / 2, deep_m / 2};
    return fjell::make_view(eye_m, middle_m - eye_m, {0, 1, 0}, 1.0, 1280, 720, 0.5, 1e6);
}

void draw(const fjell::io::LoadedPack& loaded, const std::string& path) {
    const fjell::Terrain& terrain = loaded.terrain;
    const fjell::CutBudget budget{.vertices = 200'000, .triangles = 400'000};
    const std::size_t bytes = fjell::cut_bytes(terrain, budget);
    const fjell::io::AlignedMemory memory = fjell::io::allocate(bytes);
    fjell::LiveCut cut;
    fjell::Status s = fjell::create_cut(terrain, budget, {memory.get(), bytes}, cut);

    const fjell::View view = look(terrain);
    fjell::CutReport report;
    if (s.ok()) s = fjell::update_cut(cut, {&view, 1}, {.max_error_px = 1}, report); // a game: every frame
    if (!s.ok()) throw Failure(1, std::string(s.field) + ": " + fjell::message(s.code));

    std::string error;
    const auto context = fjell::gl::Headless::create({}, error); // a game has its window
    const auto target = context ? fjell::gl::Target::create({view.width_px, view.height_px}, error) : nullptr;
    const fjell::gl::RendererOptions slots{.vertices = budget.vertices,
                                           .indices = 3 * budget.triangles,
                                           .ranges = budget.triangles / budget.segment_triangles,
                                           .morph = true};
    const auto renderer = target ? fjell::gl::Renderer::create(terrain, loaded.pack, slots, error) : nullptr;
    if (!renderer) throw Failure(3, error);
    error = renderer->draw(fjell::cut_mesh(cut), fjell::cut_take_changes(cut), view, {}, *target);
    fjell::gl::Image picture;
    if (error.empty()) target->read_colour(picture);
    if (error.empty()) error = fjell::gl::write_png(picture, path);
    if (!error.empty()) throw Failure(3, error);
    std::printf("%u triangles, no sample off by more than %.2f px\n", report.triangles_drawn, report.error_bound_px);
}

} // namespace

int main(int argc, char** argv) {
    return fjell::io::run_tool("first", [&] { // one line for what fails
        if (argc != 3) throw Failure(2, "usage: first PACK PICTURE.png");
        draw(fjell::io::load_pack(argv[1], fjell::io::LoadTerrain::yes), argv[2]);
        return 0;
    });
}
