#include "gl/lighting.h"

#include <epoxy/gl.h>

#include "gl/noise.h"

namespace fjell::gl {
namespace {

Texture make_sky_map() {
    unsigned name = 0;
    // An array and not 3-D: Mesa 22's software driver crashes where 3-D textures stand beside indexed arrays of
    // samplers.
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    glTextureStorage3D(name, 1, GL_RGB16F, sky_columns, sky_rows, sky_slices);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (const GLenum axis : {GLenum{GL_TEXTURE_WRAP_S}, GLenum{GL_TEXTURE_WRAP_T}})
        glTextureParameteri(name, axis, GL_CLAMP_TO_EDGE);
    return Texture(name);
}

Texture make_noise_map() {
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    glTextureStorage2D(name, noise_mips, GL_RGBA8, noise_side, noise_side);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    const std::vector<std::uint8_t> texels = make_noise();
    const std::uint8_t* from = texels.data();
    for (GLint mip = 0; mip < noise_mips; ++mip) {
        const GLsizei side = noise_side >> mip;
        glTextureSubImage2D(name, mip, 0, 0, side, side, GL_RGBA, GL_UNSIGNED_BYTE, from);
        from += 4 * side * side;
    }
    return Texture(name);
}

} // namespace

unsigned Lighting::variant(const LightSettings& light) {
    if (units == 0) glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
    if (units <= static_cast<int>(noise_unit)) return 0;
    return (light.air == Air::physical ? light_air : 0) | (light.detail ? light_detail : 0) |
           (light.water ? light_water : 0);
}

std::string Lighting::follow(const LightSettings& light, unsigned bits) {
    if (std::string error = validate(light); !error.empty()) return error;
    const Vec3 now = sun_direction(light);
    if (visibility_km != light.visibility_km || now.x != sun.x || now.y != sun.y || now.z != sun.z) {
        make_sky(now, light.visibility_km, sky);
        sun = now;
        visibility_km = light.visibility_km;
        in_map = false;
    }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    if ((bits & light_air) != 0 && !in_map) {
        if (sky_map.get() == 0) sky_map = make_sky_map();
        glTextureSubImage3D(sky_map.get(), 0, 0, 0, 0, sky_columns, sky_rows, sky_slices, GL_RGB, GL_FLOAT,
                            sky.radiance.data());
        in_map = true;
    }
    if ((bits & (light_detail | light_water | light_layers)) != 0 && noise_map.get() == 0) noise_map = make_noise_map();
    return {};
}

void Lighting::bind() const {
    if (units <= static_cast<int>(noise_unit)) return;
    glBindTextureUnit(sky_unit, sky_map.get());
    glBindTextureUnit(noise_unit, noise_map.get());
    glBindSampler(sky_unit, 0);
    glBindSampler(noise_unit, 0);
}

} // namespace fjell::gl
