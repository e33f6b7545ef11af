// What the picture must show: ground where a ray from the camera meets it, and sky elsewhere.
#pragma once

#include <span>
#include <string>

#include <fjell/fjell.h>

namespace host {

struct Checked {
    int ground = 0, sky = 0, wrong = 0; // rays
};
// picture: red, green, blue of the view, row by row from above. sky: its colour. Pixels beside a silhouette are left
// out: there a threshold of some pixels decides.
[[nodiscard]] Checked check_picture(const fjell::Terrain& terrain, const fjell::View& view,
                                    std::span<const unsigned char> picture, const float (&sky)[3], int margin_px);
// Empty, or why it cannot be written. Binary PPM: any viewer opens it.
[[nodiscard]] std::string write_ppm(const char* path, std::span<const unsigned char> picture, const fjell::View& view);

} // namespace host
