#include "baker/outlets/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <type_traits>

#include <meshoptimizer.h>

#include "fjell/io/failure.h"

namespace fjell::baker {

namespace {

using fjell::gltf::Glb;
using fjell::gltf::GlbTarget;

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

std::size_t add_triangles(Glb& glb, const GltfMesh& mesh, bool meshopt) {
    const std::size_t count = 3 * mesh.triangles.size();
    const bool narrow = fjell::gltf::fits_16_bits(mesh.vertices);
    const std::size_t width = narrow ? 2 : 4;
    std::size_t view = 0;
    if (meshopt) {
        const auto* const indices = mesh.triangles.front().data();
        std::vector<std::byte> encoded(meshopt_encodeIndexBufferBound(count, mesh.vertices));
        encoded.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(encoded.data()), encoded.size(),
                                                 indices, count));
        encoded.shrink_to_fit();
        view = glb.add_compressed_view(std::move(encoded), GlbTarget::indices, count, width);
    } else {
        const auto encode = [&mesh, narrow](std::size_t i, std::byte* to) {
            const auto& t = mesh.triangles[i];
            const std::array<std::uint16_t, 3> small{static_cast<std::uint16_t>(t[0]), static_cast<std::uint16_t>(t[1]),
                                                     static_cast<std::uint16_t>(t[2])};
            std::memcpy(to, narrow ? static_cast<const void*>(&small) : &t, narrow ? sizeof small : sizeof t);
        };
        view = add_elements(glb, GlbTarget::indices, mesh.triangles.size(), 3 * width, false, encode);
    }
    return glb.add_indices(view, count, mesh.vertices);
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
            {"type", std::tuple_size_v<Numbers> == 3 ? "VEC3" : "VEC2"}};
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
    if (type != fjell::gltf::glb_float) accessor["normalized"] = true;
    return glb.add("accessors", std::move(accessor));
}

} // namespace

double GltfLattice::nearest(double place, std::size_t axis) const {
    return std::round((place - offset[axis]) / scale[axis]);
}

void add_gltf_mesh(Glb& glb, const GltfMesh& mesh, bool meshopt) {
    using namespace fjell::gltf;
    constexpr std::size_t vec3_stride = 3 * sizeof(float), vec2_stride = 2 * sizeof(float), short3_stride = 8,
                          short2_stride = 4;
    const std::size_t n = mesh.vertices;
    const std::size_t indices = add_triangles(glb, mesh, meshopt);
    Glb::Json attributes, node{{"name", mesh.name}};
    if (mesh.lattice) {
        glb.require_extension("KHR_mesh_quantization");
        const GltfLattice& lattice = *mesh.lattice;
        attributes["POSITION"] =
            add_places<short3_stride>(glb, n, meshopt, glb_uint16, [&mesh, &lattice](std::size_t i) {
                std::array<double, 3> p = mesh.place(i);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    p[axis] = std::clamp(lattice.nearest(p[axis], axis), 0.0, static_cast<double>(GltfLattice::most));
                return as<std::uint16_t>(p, 1);
            });
        // A normal turns with the inverse of the node's scale.
        if (mesh.normal)
            attributes["NORMAL"] =
                add_attribute<short3_stride>(glb, n, meshopt, glb_int16, [&mesh, &lattice](std::size_t i) {
                    std::array<double, 3> v = mesh.normal(i);
                    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] *= lattice.scale[axis];
                    return as<std::int16_t>(v, most_signed / std::hypot(v[0], v[1], v[2]));
                });
        if (mesh.uv)
            attributes["TEXCOORD_0"] =
                add_attribute<short2_stride>(glb, n, meshopt, glb_uint16, [&mesh](std::size_t i) {
                    return as<std::uint16_t>(mesh.uv(i), GltfLattice::most);
                });
        node["translation"] = lattice.offset, node["scale"] = lattice.scale;
    } else {
        attributes["POSITION"] = add_places<vec3_stride>(
            glb, n, meshopt, glb_float, [&mesh](std::size_t i) { return as<float>(mesh.place(i), 1); });
        if (mesh.normal)
            attributes["NORMAL"] = add_attribute<vec3_stride>(
                glb, n, meshopt, glb_float, [&mesh](std::size_t i) { return as<float>(mesh.normal(i), 1); });
        if (mesh.uv)
            attributes["TEXCOORD_0"] = add_attribute<vec2_stride>(
                glb, n, meshopt, glb_float, [&mesh](std::size_t i) { return as<float>(mesh.uv(i), 1); });
    }
    Glb::Json surface{{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
    if (mesh.texture_jpeg.empty()) {
        surface["baseColorFactor"] = {0.5, 0.5, 0.5, 1.0};
    } else {
        surface["baseColorTexture"]["index"] = glb.add_texture(mesh.name, mesh.texture_jpeg, "image/jpeg");
    }
    const std::size_t material =
        glb.add("materials", {{"name", "ground"}, {"pbrMetallicRoughness", std::move(surface)}});
    node["mesh"] = glb.add(
        "meshes",
        {{"primitives",
          {{{"attributes", std::move(attributes)}, {"indices", indices}, {"material", material}, {"mode", 4}}}}});
    glb.add_node(std::move(node));
}

} // namespace fjell::baker
