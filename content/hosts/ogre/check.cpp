#include "check.h"

#include <cmath>
#include <cstdlib>
#include <fstream>

namespace host {

namespace {

fjell::GroundHit ray(const fjell::Terrain& terrain, const fjell::View& view, int x, int y) {
    const fjell::Vec3 right = fjell::cross(view.forward, view.up);
    const double tx = view.left + (view.right - view.left) * (x + 0.5) / view.width_px,
                 ty = view.top + (view.bottom - view.top) * (y + 0.5) / view.height_px;
    return fjell::cast_ray(terrain, view.eye_m, view.forward + right * tx + view.up * ty, view.far_m);
}

} // namespace

Checked check_picture(const fjell::Terrain& terrain, const fjell::View& view, std::span<const unsigned char> picture,
                      const float (&sky)[3], int margin_px) {
    Checked checked;
    const int width = static_cast<int>(view.width_px), height = static_cast<int>(view.height_px);
    for (int y = 8; y < height - 8; y += 9)
        for (int x = 8; x < width - 8; x += 9) {
            const bool hit = ray(terrain, view, x, y).hit;
            bool beside = false; // a silhouette
            for (const int d : {-margin_px, margin_px})
                beside = beside || ray(terrain, view, x, y + d).hit != hit || ray(terrain, view, x + d, y).hit != hit;
            if (beside) continue;
            const unsigned char* const pixel = &picture[3 * (std::size_t(y) * view.width_px + std::size_t(x))];
            bool is_sky = true;
            for (int c = 0; c < 3; ++c) is_sky = is_sky && std::abs(pixel[c] - std::lround(sky[c] * 255)) <= 1;
            ++(hit ? checked.ground : checked.sky);
            checked.wrong += is_sky == hit;
        }
    return checked;
}

std::string write_ppm(const char* path, std::span<const unsigned char> picture, const fjell::View& view) {
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << view.width_px << ' ' << view.height_px << "\n255\n";
    file.write(reinterpret_cast<const char*>(picture.data()), static_cast<std::streamsize>(picture.size()));
    return file ? "" : std::string(path) + ": cannot be written";
}

} // namespace host
