// A flight drawn off screen: what whole frames take, and how far their pictures are from the finest mesh's.
//
// Pictures have 640 x 480 pixels: of a view of 1280 x 960, with its mesh, a quarter of the pixels, because a software
// renderer's cost is theirs. Frames are textured, without light, haze and sky, as the thesis draws; pictures that are
// compared are lit. The finest mesh is that of a hundredth of a pixel, or as fine as two million vertices allow.
// Ownership: refers to the terrain; holds an OpenGL context and the finest mesh's pictures. Thread: the one that
// created it. Failure: create() gives null and a reason; the rest io::Failure, 1 when a budget does not suffice, 3 when
// OpenGL fails, 130 when interrupted.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fjell/gl/context.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "fjell/io/load.h"
#include "lab/recipe.h"

namespace fjell::lab {

class Drawing {
public:
    // vertices: slots for the finest mesh.
    [[nodiscard]] static std::unique_ptr<Drawing> create(const io::LoadedPack& pack, std::uint32_t vertices,
                                                         std::string& reason);
    // What is measured of a case, by key. timed: frames, each after the one before it, so that the mesh goes as far as
    // the flight does; compared: frames whose pictures are.
    [[nodiscard]] nlohmann::json fly(const Case& c, const std::vector<View>& views, const std::set<std::size_t>& timed,
                                     const std::set<std::size_t>& compared);

private:
    struct Finest {
        gl::Image image;
        std::vector<bool> covered; // where it draws ground
        double error_px = 0;
    };
    Drawing(const io::LoadedPack& pack, std::uint32_t vertices) : pack_(pack), vertices_(vertices) {}
    const Finest& finest(std::size_t frame, const View& view);
    // What draws a method's meshes.
    struct Method;
    std::unique_ptr<Method> recursive(double error_px);
    std::unique_ptr<Method> incremental(double error_px, double offscreen_factor);
    [[nodiscard]] const gl::Image& picture(Method& method, const View& view);

    const io::LoadedPack& pack_;
    std::uint32_t vertices_;
    std::unique_ptr<gl::Headless> context_; // before what lives in it
    std::unique_ptr<gl::Target> target_;
    std::unique_ptr<gl::Renderer> renderer_;
    gl::Image image_;
    std::map<std::size_t, Finest> finest_; // by frame
};

// Of two pictures of one size, where covered: the mean absolute difference in levels of 255, and 10 log10 of 255
// squared over the mean squared one, in dB; no such number (infinite) when they are equal.
struct Difference {
    double mean = 0, psnr_db = 0;
};
[[nodiscard]] Difference difference_of(const gl::Image& a, const gl::Image& b, const std::vector<bool>& covered);

} // namespace fjell::lab
