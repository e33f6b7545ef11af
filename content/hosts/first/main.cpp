// Terrain in a window, streamed, textured and morphing.   first PACK PROFILE.toml
#include <GLFW/glfw3.h>
#include <fjell/gl.h>
#include <fjell/io.h>
#include <fjell/profile.h>

int main(int argc, char** argv) {
    return fjell::io::run_tool("first", [&] { // whatever fails is one line
        if (argc != 3) throw fjell::io::Failure(2, "usage: first PACK PROFILE.toml");
        const fjell::Profile profile = fjell::read_profile(argv[2]); // as the editor has saved it
        fjell::io::LiveTerrain ground(argv[1], fjell::live_options(profile));
        GLFWwindow* const window = glfwInit() ? glfwCreateWindow(1280, 720, "first", nullptr, nullptr) : nullptr;
        if (!window) throw fjell::io::Failure(3, "no window opens; is there a display?");
        glfwMakeContextCurrent(window);
        const auto renderer = fjell::gl::Renderer::create(ground);
        const auto target = fjell::gl::Target::create({1280, 720, profile.samples});
        const double wide_m = ground.terrain().extent_x_m(), high_m = ground.pack().header.max_m;
        while (!glfwWindowShouldClose(window) && !glfwGetKey(window, GLFW_KEY_ESCAPE)) {
            const double now_s = glfwGetTime(); // from west to east and on, looking east and a little down
            const fjell::Vec3 eye_m{wide_m * now_s / 60, high_m * 1.2, ground.terrain().extent_z_m() / 2};
            const fjell::View view = fjell::make_view(eye_m, {1, -0.3, 0}, {0, 1, 0}, 0.8, 1280, 720, 1, 2 * wide_m);
            ground.update({&view, 1}, now_s); // every frame: no allocation, no lock, no system call
            renderer->draw(ground, view, {.light = profile.light, .time_s = now_s}, *target);
            target->present(1280, 720);
            glfwSwapBuffers(window);
            glfwPollEvents();
        }
        return 0;
    });
}
