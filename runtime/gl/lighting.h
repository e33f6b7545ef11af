// What a draw's light takes: the sky's tables, and the two textures that shaders read.
//
// Internal to runtime/gl. Made at the first draw that needs them; the tables anew when the sun or the air changes.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/gl/light.h"
#include "gl/objects.h"
#include "gl/sky.h"

namespace fjell::gl {

inline constexpr unsigned sky_unit = 16, noise_unit = 17; // behind those of colours and normals
inline constexpr unsigned horizon_unit = 20;              // of the first horizon map, behind materials

// Which lines of the ground's shader are compiled: bits.
inline constexpr unsigned light_air = 1, light_detail = 2, light_water = 4, light_layers = 8, light_shadows = 16;
inline constexpr unsigned light_control = 32; // with light_layers only
inline constexpr unsigned light_lakes = 64;   // with light_control and light_water only
inline constexpr unsigned light_none = 128, light_variants = 129;

struct Lighting {
    Sky sky;
    Vec3 sun;                 // that the tables are for
    double visibility_km = 0; // 0: there are no tables yet
    Texture sky_map, noise_map;
    bool in_map = false; // whether sky_map holds the tables
    int units = 0;       // that this GPU gives a fragment shader

    // Bits of the variant for these settings. A GPU of only 16 texture units has the simple air and no detail.
    [[nodiscard]] unsigned variant(const LightSettings& light);
    // Tables and textures for these settings and this variant. Refuses settings out of range.
    [[nodiscard]] std::string follow(const LightSettings& light, unsigned bits);
    void bind() const;
};

} // namespace fjell::gl
