// The same from memory: the pack and the profile are a part of the executable (embedded.S).   embedded PICTURE.png
#include <fjell/gl.h>
#include <fjell/io.h>
#include <fjell/profile.h>

extern "C" const char pack_begin[], pack_end[], profile_begin[], profile_end[];

int main(int argc, char** argv) {
    return fjell::io::run_tool("embedded", [&] {
        if (argc != 2) throw fjell::io::Failure(2, "usage: embedded PICTURE.png");
        const fjell::Profile profile = fjell::parse_profile({profile_begin, profile_end}, "profile");
        fjell::io::LiveTerrain ground(std::as_bytes(std::span(pack_begin, pack_end)), "pack",
                                      fjell::live_options(profile));
        const auto context = fjell::gl::Headless::create();
        const auto renderer = fjell::gl::Renderer::create(ground);
        const auto target = fjell::gl::Target::create({1280, 720});
        const double wide_m = ground.terrain().extent_x_m(), high_m = ground.pack().header.max_m;
        const fjell::Vec3 eye_m{0, high_m * 1.2, ground.terrain().extent_z_m() / 2};
        const fjell::View view = fjell::make_view(eye_m, {1, -0.3, 0}, {0, 1, 0}, 0.8, 1280, 720, 1, 2 * wide_m);
        for (int frame = 0; !ground.frame().settled; ++frame) {
            ground.update({&view, 1}, frame / 60.0);
            renderer->upload(ground);
        }
        renderer->draw(ground, view, {.light = profile.light}, *target);
        fjell::gl::Image picture;
        target->read_colour(picture);
        fjell::gl::write_png(picture, argv[1]);
        return 0;
    });
}
