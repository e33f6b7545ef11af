// Camera paths, ours and recorded ones: any text is refused or is flown, with upright cameras in finite places.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "fjell/io/failure.h"
#include "input.h"
#include "session/path.h"

using namespace fjell;
using fuzz::must;

namespace {
bool near(double a, double b) {
    return std::abs(a - b) < 1e-6;
}
} // namespace

extern "C" int fuzz_path(const std::uint8_t* data, std::size_t size) {
    try {
        const std::string_view text{reinterpret_cast<const char*>(data), size};
        const session::CameraPath path = session::parse_path(text, "fuzz");
        session::Ground ground;
        ground.extent_x_m = 3000;
        ground.extent_z_m = 2000;
        ground.cell_m = 10;
        for (const std::size_t frames : {std::size_t{1}, std::size_t{17}}) {
            const auto poses = resample(path, ground, frames);
            must(poses.size() == frames, "as many frames as asked for");
            for (const session::Pose& p : poses) {
                must(std::abs(p.position_m.x) <= 1e8 && std::abs(p.position_m.y) <= 1e8 &&
                         std::abs(p.position_m.z) <= 1e8,
                     "a camera is somewhere");
                must(near(length(p.direction), 1) && near(length(p.up), 1) && near(dot(p.direction, p.up), 0),
                     "a camera is upright");
            }
        }
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
    }
    return 0;
}
