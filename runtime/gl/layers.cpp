#include "gl/layers.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <epoxy/gl.h>

#include "fjell/texture.h"
#include "gl/fail.h"

namespace fjell::gl {
namespace {

// Where a value is within a range with soft edges: between begin and begin + 1 / rise it comes, and so it goes.
struct Band {
    double begin, rise, end, fall;

    [[nodiscard]] double share(double value) const {
        return std::clamp((value - begin) * rise, 0.0, 1.0) * std::clamp((end - value) * fall, 0.0, 1.0);
    }
};

Band band_of(const double (&range)[2], double soft, double least, double most) {
    const double half = 0.5 * std::max(soft, 1e-3), per = 0.5 / half;
    Band band{range[0] - half, per, range[1] + half, per};
    if (range[0] <= least) band.begin = -1e9;
    if (range[1] >= most) band.end = 1e9;
    return band;
}

struct Bands {
    Band height, slope, noise;
};
Bands bands_of(const LayerRule& rule) {
    return {band_of(rule.height_m, rule.height_soft_m, -open_height_m, open_height_m),
            band_of(rule.slope_deg, rule.slope_soft_deg, 0, 90), band_of(rule.noise, rule.noise_soft, 0, 1)};
}

void put_row(float (&to)[4], double a, double b, double c, double d) {
    const double from[4] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) to[i] = static_cast<float>(from[i]);
}
void put_row(float (&to)[4], const Band& band) {
    put_row(to, band.begin, band.rise, band.end, band.fall);
}

} // namespace

// Whole numbers of periods, or the texture would not be back at its beginning; each material is turned its own way.
std::array<float, 4> turns_of(const io::MaterialRecord& record, std::size_t number) {
    const double angle = 0.35 + 2.4 * static_cast<double>(number);
    std::array<float, 4> turns;
    const auto periods = [](double size_m, double turn, float& east, float& south) {
        const double n = std::max(layer_period_m / size_m, 1.0);
        east = static_cast<float>(std::round(n * std::cos(turn)));
        south = static_cast<float>(std::round(n * std::sin(turn)));
        if (east == 0 && south == 0) east = 1;
    };
    const double size_m = static_cast<double>(record.size_m);
    periods(size_m, angle, turns[0], turns[1]);
    periods(size_m * static_cast<double>(record.coarse), angle + 0.65, turns[2], turns[3]);
    return turns;
}

std::vector<std::uint8_t> decode_material(bool colour, const std::byte* blocks, std::uint32_t side) {
    const std::size_t count = blocks_of(side), all = std::size_t{side} * side;
    std::vector<std::byte> first(count * 8), second(count * 16);
    std::vector<std::uint8_t> rgb(3 * all), pair(2 * all);
    for (std::size_t b = 0; b < count; ++b) {
        const std::byte* const block = blocks + 16 * b;
        std::copy_n(block, 8, &second[16 * b]);
        std::copy_n(colour ? block : block + 8, 8, &second[16 * b + 8]);
        std::copy_n(block + 8, 8, &first[8 * b]);
    }
    (void)decode_normal(second, side, pair); // both halves of BC5 are what alpha of BC3 is
    if (!colour) return pair;
    (void)decode_colour(first, side, rgb);
    std::vector<std::uint8_t> texels(4 * all);
    for (std::size_t i = 0; i < all; ++i) {
        std::copy_n(&rgb[3 * i], 3, &texels[4 * i]);
        texels[4 * i + 3] = pair[2 * i];
    }
    return texels;
}

namespace {

LayersBlock block_of(const io::Materials& materials, std::span<const LayerRule> rules) {
    LayersBlock block{};
    for (std::size_t i = 0; i < materials.records.size(); ++i) {
        const io::MaterialRecord& r = materials.records[i];
        std::ranges::copy(turns_of(r, i), block.turn[i]);
        for (std::size_t c = 0; c < 3; ++c) block.mean[i][c] = std::max(r.mean[c], 0.004f);
        block.mean[i][3] = r.coarse_share;
    }
    for (std::size_t i = 0; i < rules.size(); ++i) {
        const LayerRule& rule = rules[i];
        const Bands bands = bands_of(rule);
        RuleBlock& to = block.rule[i];
        put_row(to.height, bands.height);
        put_row(to.slope, bands.slope);
        put_row(to.noise, bands.noise);
        put_row(to.how, rule.material, rule.opacity, rule.ragged * rule.height_soft_m,
                rule.ragged * rule.slope_soft_deg);
        put_row(to.noises, 1 - rule.fine, rule.fine, 0, 0);
    }
    block.count[0] = static_cast<std::int32_t>(rules.size());
    return block;
}

struct ArrayFormat {
    bool colour, blocks, software;

    [[nodiscard]] GLenum stored() const {
        if (blocks) return colour ? GL_COMPRESSED_RGBA_S3TC_DXT5_EXT : GL_COMPRESSED_RG_RGTC2;
        return colour ? GL_RGBA8 : GL_RG8;
    }
    [[nodiscard]] std::uint64_t bytes_a_texel() const { return blocks ? 1 : colour ? 4 : 2; }
};

void store_mip(unsigned name, const ArrayFormat& format, const io::Materials& materials, std::uint32_t mip,
               std::uint32_t as_mip) {
    const std::uint32_t side = 1u << (materials.side_log2 - mip);
    const auto n = static_cast<GLsizei>(side), count = static_cast<GLsizei>(materials.records.size());
    const std::byte* const blocks =
        (format.colour ? materials.colour : materials.normal).data() + materials.mip_offset(mip, 0);
    const std::size_t bytes = materials.mip_bytes(mip);
    const auto to = static_cast<GLint>(as_mip);
    if (format.blocks) {
        glCompressedTextureSubImage3D(name, to, 0, 0, 0, n, n, count, format.stored(),
                                      static_cast<GLsizei>(bytes * materials.records.size()), blocks);
        return;
    }
    // As texels: drivers without a GPU take ten times as long for blocks.
    for (GLsizei layer = 0; layer < count; ++layer) {
        const std::vector<std::uint8_t> texels =
            decode_material(format.colour, blocks + static_cast<std::size_t>(layer) * bytes, side);
        glTextureSubImage3D(name, to, 0, 0, layer, n, n, 1, format.colour ? GL_RGBA : GL_RG, GL_UNSIGNED_BYTE,
                            texels.data());
    }
}

unsigned make_array(const ArrayFormat& format, const io::Materials& materials, std::uint32_t first_mip,
                    float anisotropy) {
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    const std::uint32_t log2 = materials.side_log2 - first_mip, mips = materials.mips() - first_mip;
    glTextureStorage3D(name, static_cast<GLsizei>(mips), format.stored(), GLsizei{1} << log2, GLsizei{1} << log2,
                       static_cast<GLsizei>(materials.records.size()));
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(mips) - 1);
    if (anisotropy > 1) glTextureParameterf(name, GL_TEXTURE_MAX_ANISOTROPY, anisotropy);
    for (std::uint32_t mip = 0; mip < mips; ++mip) store_mip(name, format, materials, first_mip + mip, mip);
    return name;
}

bool is_range(const double (&range)[2], double least, double most) {
    return range[0] >= least && range[1] <= most && range[0] <= range[1];
}
bool is_within(double value, double least, double most) {
    return value >= least && value <= most; // false for NaN
}

const char* fault_of(const LayerRule& r, std::size_t materials) {
    if (r.material >= materials) return "material must be one of the materials";
    if (!is_range(r.height_m, -open_height_m, open_height_m))
        return "height_m must be two numbers from -1000000 to 1000000, the lower first";
    if (!is_within(r.height_soft_m, 0, open_height_m)) return "height_soft_m must be a number from 0 to 1000000";
    if (!is_range(r.slope_deg, 0, 90)) return "slope_deg must be two numbers from 0 to 90, the lower first";
    if (!is_within(r.slope_soft_deg, 0, 90)) return "slope_soft_deg must be a number from 0 to 90";
    if (!is_range(r.noise, 0, 1)) return "noise must be two numbers from 0 to 1, the lower first";
    if (!is_within(r.noise_soft, 0, 1)) return "noise_soft must be a number from 0 to 1";
    if (!is_within(r.fine, 0, 1)) return "fine must be a number from 0 to 1";
    if (!is_within(r.ragged, 0, 2)) return "ragged must be a number from 0 to 2";
    if (!is_within(r.opacity, 0, 1)) return "opacity must be a number from 0 to 1";
    return nullptr;
}

} // namespace

void validate(const LayerSettings& s) {
    if (!is_within(s.distance_m, min_layer_distance_m, max_layer_distance_m))
        fail("LayerSettings::distance_m must be a number from 1 to 100000");
    if (!is_within(s.tint, 0, 1)) fail("LayerSettings::tint must be a number from 0 to 1");
    if (!is_within(s.relief, 0, max_layer_relief)) fail("LayerSettings::relief must be a number from 0 to 4");
}

void validate(std::span<const LayerRule> rules, std::size_t materials) {
    if (rules.empty() || rules.size() > max_layer_rules)
        fail("there must be 1 to " + std::to_string(max_layer_rules) + " rules", 1);
    for (std::size_t i = 0; i < rules.size(); ++i)
        if (const char* const fault = fault_of(rules[i], materials))
            fail("rule " + std::to_string(i) + ": " + fault, 1);
}

void layer_shares(std::span<const LayerRule> rules, double height_m, double slope_deg, double patches, double spots,
                  std::span<double> shares) {
    double left = 1, all = 0;
    for (std::size_t i = rules.size(); i-- > 0;) {
        const LayerRule& r = rules[i];
        const Bands bands = bands_of(r);
        const double noise = patches * (1 - r.fine) + spots * r.fine, off = noise - 0.5;
        shares[i] = left * r.opacity * bands.height.share(height_m + off * r.ragged * r.height_soft_m) *
                    bands.slope.share(slope_deg + off * r.ragged * r.slope_soft_deg) * bands.noise.share(noise);
        left -= shares[i];
        all += shares[i];
    }
    for (double& share : shares) share = all > 0 ? share / all : 0;
}

namespace {

// Every name must be a material, or some ground would show another one. Water need not: it is drawn by the light.
void match_names(const LayersInput& in, std::int32_t (&of_name)[io::max_materials]) {
    if (in.names.size() > io::max_materials) fail("the pack's splat maps speak of more than 16 materials", 1);
    std::string known;
    for (const io::MaterialRecord& r : in.materials.records) known += (known.empty() ? "" : ", ") + std::string(r.name);
    for (std::size_t i = 0; i < in.names.size(); ++i) {
        of_name[i] = in.materials.find(in.names[i]);
        if (of_name[i] < 0 && in.names[i] != water_layer)
            fail("the pack's splat maps speak of \"" + in.names[i] + "\", and the materials are " + known +
                     ": give materials with it, or bake the pack with other --layers",
                 1);
    }
}

} // namespace

void check_layers(const LayersInput& in, std::int32_t (&of_name)[io::max_materials]) {
    if (in.names.empty() || !in.rules.empty()) validate(in.rules, in.materials.records.size());
    match_names(in, of_name);
}

void Layers::set(const LayersInput& in, std::uint64_t most_bytes, float anisotropy, bool software) {
    *this = {};
    const io::Materials& materials = in.materials;
    if (materials.records.empty() && in.rules.empty()) return;
    std::int32_t of_name[io::max_materials] = {};
    check_layers(in, of_name);
    LayersBlock block = block_of(materials, in.rules);
    std::ranges::copy(of_name, block.of_name);
    const auto* const water = std::ranges::find(of_name, -1);
    block.count[1] = static_cast<std::int32_t>(water - of_name);
    const bool blocks = !software && epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc");
    const ArrayFormat formats[] = {{true, blocks, software}, {false, blocks, software}};
    std::uint32_t first_mip = 0;
    const auto bytes_from = [&](std::uint32_t mip) {
        return (formats[0].bytes_a_texel() + formats[1].bytes_a_texel()) *
               (materials.colour.size() - materials.mip_offset(mip, 0));
    };
    while (first_mip + 1 < materials.mips() && bytes_from(first_mip) > most_bytes) ++first_mip;
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    while (glGetError() != GL_NO_ERROR) {
    } // so that what follows speaks of these
    colour = Texture(make_array(formats[0], materials, first_mip, anisotropy));
    normal = Texture(make_array(formats[1], materials, first_mip, anisotropy));
    unsigned name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferStorage(name, sizeof block, &block, 0);
    table = Buffer(name);
    bytes = bytes_from(first_mip);
    rules = in.rules.size();
    names = in.names.size();
    lakes = water != std::end(of_name);
    if (glGetError() == GL_NO_ERROR) return;
    *this = {};
    fail("the GPU has no room for the materials: lower RendererOptions::material_bytes");
}

void Layers::bind() const {
    glBindBufferBase(GL_UNIFORM_BUFFER, layers_binding, table.get());
    glBindTextureUnit(material_unit, colour.get());
    glBindTextureUnit(material_normal_unit, normal.get());
    glBindSampler(material_unit, 0);
    glBindSampler(material_normal_unit, 0);
}

} // namespace fjell::gl
