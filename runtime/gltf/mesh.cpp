#include "gltf/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

#include "fjell/io/failure.h"

namespace fjell::gltf {

namespace {

using SharedMesh = std::shared_ptr<const GlbMesh>;

constexpr int most_signed = 32767;

// encode(i, to): element i as its bytes.
template <typename Encode>
std::size_t add_elements(Glb& glb, GlbTarget target, std::size_t count, std::size_t stride, bool meshopt,
                         const Encode& encode) {
    if (!meshopt)
        return glb.add_view(std::uint64_t{count} * stride, target, [count, stride, encode](const Glb::Put& put) {
            constexpr std::size_t some = 4096;
            std::vector<std::byte> bytes(some * stride);
            for (std::size_t first = 0; first < count; first += some) {
                const std::size_t end = std::min(count, first + some);
                for (std::size_t i = first; i < end; ++i) encode(i, &bytes[(i - first) * stride]);
                put(std::span(bytes).first((end - first) * stride));
            }
        });
    std::vector<std::byte> bytes(count * stride), encoded(meshopt_encodeVertexBufferBound(count, stride));
    for (std::size_t i = 0; i < count; ++i) encode(i, &bytes[i * stride]);
    encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()), encoded.size(),
                                              bytes.data(), count, stride));
    encoded.shrink_to_fit();
    return glb.add_compressed_view(std::move(encoded), target, count, stride);
}

std::size_t add_triangles(Glb& glb, const SharedMesh& mesh, bool meshopt) {
    const std::size_t count = mesh->indices.size();
    const bool narrow = fits_16_bits(mesh->vertices);
    const std::size_t width = narrow ? 2 : 4;
    std::size_t view = 0;
    if (meshopt) {
        std::vector<std::byte> encoded(meshopt_encodeIndexBufferBound(count, mesh->vertices));
        encoded.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(encoded.data()), encoded.size(),
                                                 mesh->indices.data(), count));
        encoded.shrink_to_fit();
        view = glb.add_compressed_view(std::move(encoded), GlbTarget::indices, count, width);
    } else {
        const auto encode = [mesh, narrow](std::size_t i, std::byte* to) {
            const std::uint32_t index = mesh->indices[i];
            const auto small = static_cast<std::uint16_t>(index);
            std::memcpy(to, narrow ? static_cast<const void*>(&small) : &index, narrow ? sizeof small : sizeof index);
        };
        view = add_elements(glb, GlbTarget::indices, count, width, false, encode);
    }
    return glb.add_indices(view, count, mesh->vertices);
}

template <typename Number, std::size_t N>
auto as(const std::array<double, N>& values, double scale) {
    std::array<Number, N> numbers{};
    for (std::size_t k = 0; k < N; ++k)
        numbers[k] = std::is_integral_v<Number> ? static_cast<Number>(std::lround(values[k] * scale))
                                                : static_cast<Number>(values[k]);
    return numbers;
}

// element(i): an array of numbers. What is narrower than Stride is padded with zeros.
template <std::size_t Stride, typename Element>
Glb::Json attribute_of(Glb& glb, std::size_t count, bool meshopt, int type, const Element& element) {
    using Numbers = decltype(element(0));
    static_assert(sizeof(Numbers) <= Stride && Stride % 4 == 0);
    const std::size_t view =
        add_elements(glb, GlbTarget::vertices, count, Stride, meshopt, [element](std::size_t i, std::byte* to) {
            const Numbers numbers = element(i);
            std::memset(to, 0, Stride);
            std::memcpy(to, &numbers, sizeof numbers);
        });
    if (sizeof(Numbers) != Stride) glb.json["bufferViews"][view]["byteStride"] = Stride;
    return {{"bufferView", view},
            {"componentType", type},
            {"count", count},
            {"type", "VEC" + std::to_string(std::tuple_size_v<Numbers>)}};
}

template <std::size_t Stride, typename Element>
std::size_t add_places(Glb& glb, std::size_t count, bool meshopt, int type, const Element& element) {
    Glb::Json accessor = attribute_of<Stride>(glb, count, meshopt, type, element);
    auto low = element(0), high = low;
    for (std::size_t i = 1; i < count; ++i) {
        const auto p = element(i);
        for (std::size_t axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    }
    accessor["min"] = low, accessor["max"] = high;
    return glb.add("accessors", std::move(accessor));
}

// Whole numbers stand for -1 to 1, or 0 to 1.
template <std::size_t Stride, typename Element>
std::size_t add_attribute(Glb& glb, std::size_t count, bool meshopt, int type, const Element& element) {
    Glb::Json accessor = attribute_of<Stride>(glb, count, meshopt, type, element);
    if (type != glb_float) accessor["normalized"] = true;
    return glb.add("accessors", std::move(accessor));
}

// A unit vector as the file has it, where axes are scaled: unit again. by(scale): what its axis multiplies.
template <std::size_t N, typename By>
std::array<double, N> rescaled(std::array<double, N> v, const std::optional<GlbLattice>& lattice, const By& by) {
    if (!lattice) return v;
    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] *= by(lattice->scale[axis]);
    const double length = std::hypot(v[0], v[1], v[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] /= length;
    return v;
}

void add_directions(Glb& glb, const SharedMesh& mesh, bool meshopt, Glb::Json& attributes) {
    constexpr std::size_t short_stride = 8;
    // A normal turns with the inverse of the node's scale, a tangent with the scale.
    bool narrow = mesh->lattice.has_value();
    if (narrow) {
        const auto [least, most] = std::ranges::minmax(mesh->lattice->scale);
        narrow = most <= GlbLattice::most_different * least;
    }
    const auto normal = [mesh](std::size_t i) {
        return rescaled(mesh->normal(i), mesh->lattice, [](double s) { return s; });
    };
    const auto tangent = [mesh](std::size_t i) {
        return rescaled(mesh->tangent(i), mesh->lattice, [](double s) { return 1 / s; });
    };
    const auto add = [&](const char* name, const auto& direction) {
        using Direction = decltype(direction(0));
        constexpr std::size_t float_stride = std::tuple_size_v<Direction> * sizeof(float);
        attributes[name] =
            narrow ? add_attribute<short_stride>(
                         glb, mesh->vertices, meshopt, glb_int16,
                         [direction](std::size_t i) { return as<std::int16_t>(direction(i), most_signed); })
                   : add_attribute<float_stride>(glb, mesh->vertices, meshopt, glb_float,
                                                 [direction](std::size_t i) { return as<float>(direction(i), 1); });
    };
    if (mesh->normal) add("NORMAL", normal);
    if (mesh->tangent) add("TANGENT", tangent);
}

Glb::Json attributes_of(Glb& glb, const SharedMesh& mesh, bool meshopt) {
    constexpr std::size_t vec3_stride = 3 * sizeof(float), vec2_stride = 2 * sizeof(float), short3_stride = 8,
                          short2_stride = 4;
    const std::size_t n = mesh->vertices;
    Glb::Json attributes;
    attributes["POSITION"] =
        mesh->lattice
            ? add_places<short3_stride>(glb, n, meshopt, glb_uint16,
                                        [mesh](std::size_t i) {
                                            std::array<double, 3> p = mesh->place(i);
                                            for (std::size_t axis = 0; axis < 3; ++axis)
                                                p[axis] = std::clamp(mesh->lattice->nearest(p[axis], axis), 0.0,
                                                                     static_cast<double>(GlbLattice::most));
                                            return as<std::uint16_t>(p, 1);
                                        })
            : add_places<vec3_stride>(glb, n, meshopt, glb_float,
                                      [mesh](std::size_t i) { return as<float>(mesh->place(i), 1); });
    add_directions(glb, mesh, meshopt, attributes);
    if (!mesh->uv) return attributes;
    attributes["TEXCOORD_0"] =
        mesh->lattice ? add_attribute<short2_stride>(
                            glb, n, meshopt, glb_uint16,
                            [mesh](std::size_t i) { return as<std::uint16_t>(mesh->uv(i), GlbLattice::most); })
                      : add_attribute<vec2_stride>(glb, n, meshopt, glb_float,
                                                   [mesh](std::size_t i) { return as<float>(mesh->uv(i), 1); });
    return attributes;
}

Glb::Json material_of(const GlbMesh& mesh) {
    Glb::Json surface{{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
    if (mesh.textures.colour >= 0)
        surface["baseColorTexture"]["index"] = mesh.textures.colour;
    else
        surface["baseColorFactor"] = {0.5, 0.5, 0.5, 1.0};
    Glb::Json material{{"name", mesh.name}, {"pbrMetallicRoughness", std::move(surface)}};
    if (mesh.textures.normal >= 0) material["normalTexture"]["index"] = mesh.textures.normal;
    if (mesh.textures.occlusion >= 0) material["occlusionTexture"]["index"] = mesh.textures.occlusion;
    return material;
}

} // namespace

double GlbLattice::nearest(double place, std::size_t axis) const {
    return std::round((place - offset[axis]) / scale[axis]);
}

void add_glb_mesh(Glb& glb, GlbMesh given, bool meshopt) {
    const SharedMesh mesh = std::make_shared<const GlbMesh>(std::move(given));
    const std::size_t indices = add_triangles(glb, mesh, meshopt);
    Glb::Json attributes = attributes_of(glb, mesh, meshopt), node{{"name", mesh->name}};
    std::array<double, 3> place = mesh->origin;
    if (mesh->lattice) {
        glb.require_extension("KHR_mesh_quantization");
        for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += mesh->lattice->offset[axis];
        node["scale"] = mesh->lattice->scale;
    }
    node["translation"] = place;
    const std::size_t material = glb.add("materials", material_of(*mesh));
    node["mesh"] = glb.add(
        "meshes",
        {{"name", mesh->name},
         {"primitives",
          {{{"attributes", std::move(attributes)}, {"indices", indices}, {"material", material}, {"mode", 4}}}}});
    glb.add_node(std::move(node));
}

} // namespace fjell::gltf
