#include "check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <utility>
#include <vector>

void* operator new(std::size_t bytes) {
    if (vulkan::counting) ++vulkan::allocations;
    if (void* const piece = std::malloc(bytes)) return piece;
    throw std::bad_alloc();
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    if (vulkan::counting) ++vulkan::allocations;
    return std::malloc(bytes);
}
void operator delete(void* piece) noexcept {
    std::free(piece);
}
void operator delete(void* piece, std::size_t) noexcept {
    std::free(piece);
}

namespace vulkan {

namespace {

constexpr double eps = 0x1p-24; // half a step of a float at 1

std::string text(const char* format, double a, double b, double c, double d) {
    char line[200];
    std::snprintf(line, sizeof line, format, a, b, c, d);
    return line;
}

} // namespace

void Check::break_promise(const std::string& how) {
    if (broken_.empty()) broken_ = how;
}

void Check::upload(const fjell::CutChanges& changes, std::uint32_t index_bytes, std::uint64_t uploaded_bytes) {
    std::uint64_t bytes = 0;
    for (const std::uint64_t bits : changes.vertex_bits) // all words, not only those that are listed
        bytes += std::uint64_t(std::popcount(bits)) * sizeof(fjell::CompactVertex);
    for (const std::uint64_t bits : changes.triangle_bits)
        bytes += std::uint64_t(std::popcount(bits)) * 3 * index_bytes;
    if (bytes != uploaded_bytes)
        break_promise(
            text("%.0f bytes were uploaded where %.0f have changed", double(uploaded_bytes), double(bytes), 0, 0));
}

void Check::buffers(const fjell::CutMesh& cut, std::uint32_t index_bytes, const Probe& probe) {
    for (const Probe::Asked& asked : probe.asked()) {
        fjell::CompactVertex wanted;
        compact(cut, asked.slot, {&wanted, 1});
        if (std::memcmp(&wanted, &probe.vertices()[asked.slot], sizeof wanted) != 0)
            return break_promise(
                text("vertex slot %.0f is not on the device as it is in the cut", asked.slot, 0, 0, 0));
    }
    for (const fjell::TileRange& range : cut.mesh.tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i) {
            std::uint32_t there = 0; // little-endian, as all that Vulkan runs on
            std::memcpy(&there, &probe.indices()[std::size_t{i} * index_bytes], index_bytes);
            if (there != cut.mesh.indices[i])
                return break_promise(text("index %.0f is not on the device as it is in the cut", i, 0, 0, 0));
        }
}

// The device's height lies between that of morphed_height_m() and the full one, and near the first: as fjell/compact.h
// derives it, and as far as floats go.
void Check::height(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view,
                   std::uint32_t slot, double drawn_m) {
    const fjell::MeshVertex& vertex = cut.mesh.vertices[slot];
    const fjell::MorphVertex& morph = cut.morph[slot];
    const double exact_m = double(fjell::morphed_height_m(terrain, vertex, morph, cut.frame));
    const double full_m = double(vertex.height_m), rise_m = double(morph.morph_from_m) - full_m;
    // Some twelve roundings of numbers up to the diagonal on the way to a share of the band, whose width is error_m
    // times start_per_error - full_per_error; the height moves by at most error_m over it. Then a few of the height
    // itself.
    const fjell::MorphView& eye = cut.frame.view[0];
    const double band = double(eye.start_per_error) - double(eye.full_per_error);
    const double diagonal_m = std::hypot(double(terrain.extent_x_m()), double(terrain.extent_z_m()));
    const double floats_m = eps * (24 * diagonal_m / band + 8 * (std::abs(full_m) + rebase_m));
    const double away_m = fjell::length(
        fjell::Vec3{double(terrain.x_m(vertex.column)), exact_m, double(terrain.z_m(vertex.row))} - view.eye_m);
    const double off_m = drawn_m - exact_m, px = fjell::focal_length_px(view) / away_m;
    const double error_m = double(morph.error_m), radius_m = double(morph.radius_m);
    const double out_m =
        std::max(radius_m * 0x1p-11, 0x1p-10) + std::max(error_m * 0x1p-11, 0x1p-10) * double(eye.start_per_error);
    const double steps = error_m > 0 ? std::min(1.0, out_m / (error_m * band)) : 1;
    double ahead_m = floats_m + std::abs(rise_m) * (steps + 0x1p-10), behind_m = floats_m;
    if (morph.activated_s != fjell::activated_long_ago_s) { // by time, up to so much ahead or behind
        const double late =
            double(fjell::compact_late_s) / std::max(double(cut.frame.morph_s - fjell::compact_late_s), 1e-3);
        ahead_m += std::abs(rise_m) * std::min(1.0, late);
        behind_m += std::abs(rise_m) * std::min(1.0, late);
    } else {
        worst_rounding_m_ = std::max(worst_rounding_m_, std::abs(off_m));
        worst_rounding_px_ = std::max(worst_rounding_px_, std::abs(off_m) * px);
    }
    const double towards_full_m = rise_m > 0 ? -off_m : off_m;
    if (!(towards_full_m <= ahead_m && towards_full_m >= -behind_m))
        break_promise(text("a vertex is drawn %.5f m nearer to its full height than morphed_height_m() says, between "
                           "%.5f and %.5f m are allowed (%.5f px)",
                           towards_full_m, -behind_m, ahead_m, std::abs(off_m) * px));
    between_ += std::abs(exact_m - full_m) > 0.1 && std::abs(exact_m - double(morph.morph_from_m)) > 0.1;
    ++vertices_;
}

void Check::vertices(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view,
                     const Origin& origin, std::uint32_t index_bytes, const Probe& probe) {
    buffers(cut, index_bytes, probe);
    for (std::size_t i = 0; i < probe.asked().size(); ++i) {
        const std::uint32_t slot = probe.asked()[i].slot;
        const Probe::Answer& drawn = probe.answers()[i];
        height(terrain, cut, view, slot, double(drawn.z_m) + origin.position_m().z);
        const fjell::MeshVertex& vertex = cut.mesh.vertices[slot];
        const double east_m = vertex.column * terrain.header().spacing_m[0] - origin.position_m().x;
        const double north_m = -vertex.row * terrain.header().spacing_m[1] - origin.position_m().y;
        // The shader's spacing is a float, and so is its product: (1 + eps)^2 is below 1 + 3 eps.
        if (!(std::abs(double(drawn.x_m) - east_m) <= 3 * eps * std::abs(east_m) &&
              std::abs(double(drawn.y_m) - north_m) <= 3 * eps * std::abs(north_m)))
            break_promise(text("a vertex is drawn at %.3f, %.3f where %.3f, %.3f is its place", double(drawn.x_m),
                               double(drawn.y_m), east_m, north_m));
    }
}

// ray: through the pixel's centre, 1 along the direction of sight. depth: near / how far along it; 0: sky.
void Check::pixel(const fjell::View& view, fjell::Vec3 ray, double depth, double allowed_px) {
    ++pixels_;
    const double lambda = fjell::focal_length_px(view), long_ray = fjell::length(ray);
    const double cell_m = std::hypot(double(whole_.spacing_x_m()), double(whole_.spacing_z_m()));
    const double half_quantum_m = double(whole_.header().quantum_m) / 2;
    const double along_m = depth > 0 ? view.near_m / depth : 1e6;
    // The drawn surface is below a ray until it meets it. So a ray that is higher by all that is allowed meets no
    // ground before: what is allowed at a sample counts from its distance, up to a steep cell's length farther away.
    const fjell::Vec3 up{0, 1, 0};
    const double more_m = allowed_px / lambda * 3 * cell_m + half_quantum_m;
    const fjell::Vec3 raised = ray + up * (allowed_px / lambda * long_ray);
    const double sight_m = fjell::length(raised) * along_m * 0.9999;
    if (const fjell::GroundHit hit = fjell::cast_ray(whole_, view.eye_m + up * more_m, raised, sight_m); hit.hit)
        break_promise(text("a pixel shows what is %.1f m away, where there is ground at %.1f m (%.2f px allowed)",
                           long_ray * along_m, hit.distance_m, allowed_px, 0));
    if (!(depth > 0)) return;
    // And where it meets it, there is ground.
    const fjell::Vec3 place = view.eye_m + ray * along_m;
    const fjell::GroundHeight ground = fjell::ground_height(whole_, place.x, place.z);
    const double away_m = long_ray * along_m, steep = 1 / std::max(ground.normal.y, 1e-3);
    const double allowed_m = allowed_px * (away_m + cell_m * steep) / lambda + half_quantum_m +
                             // half a 256th of a pixel of the rasteriser's, and floats of depths
                             (0x1p-8 + 8 * eps * lambda) * (1 + steep) * away_m / lambda;
    const double off_m = std::abs(ground.height_m - place.y);
    worst_share_ = std::max(worst_share_, off_m / allowed_m);
    worst_px_ = std::max(worst_px_, off_m * lambda / away_m);
    if (!(off_m <= allowed_m))
        break_promise(text("a pixel shows ground %.3f m off the full-resolution one, %.3f m are allowed (%.0f m away, "
                           "%.2f px)",
                           off_m, allowed_m, away_m, allowed_px));
}

Check::Copies Check::copies(const fjell::CutMesh& cut) {
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Pair> by_range, by_tile;
    for (const fjell::TileRange& range : cut.mesh.tiles)
        for (const std::uint32_t slot : cut.mesh.indices.subspan(range.first_index, range.index_count)) {
            by_range.emplace_back(slot, range.first_index);
            by_tile.emplace_back(slot, range.tile);
        }
    const auto count = [](std::vector<Pair>& all, auto same) {
        std::sort(all.begin(), all.end());
        return double(std::unique(all.begin(), all.end(), same) - all.begin());
    };
    const auto same_slot = [](Pair a, Pair b) { return a.first == b.first; };
    std::vector<Pair> slots = by_tile;
    const double alone = std::max(count(slots, same_slot), 1.0);
    return {.by_range = count(by_range, std::equal_to<>()) / alone,
            .by_tile = count(by_tile, std::equal_to<>()) / alone};
}

void Check::picture(const fjell::CutMesh& cut, const fjell::CutReport& report, const fjell::View& view,
                    const Probe& probe) {
    const double allowed_px = report.error_bound_px + report.threshold_px * fjell::compact_share(cut.frame.view[0]);
    const fjell::Vec3 right = fjell::cross(view.forward, view.up);
    for (std::uint32_t y = 4; y < view.height_px; y += 8)
        for (std::uint32_t x = 4; x < view.width_px; x += 8) {
            const double across = view.left + (x + 0.5) / view.width_px * (view.right - view.left);
            const double high = view.top - (y + 0.5) / view.height_px * (view.top - view.bottom);
            pixel(view, view.forward + right * across + view.up * high,
                  double(probe.depths()[std::size_t{y} * view.width_px + x]), allowed_px);
        }
}

} // namespace vulkan
