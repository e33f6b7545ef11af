#include "gltf/glb.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

#include <stb_image_write.h>

#include "fjell/io/failure.h"

namespace fjell::gltf {

namespace {

constexpr const char* meshopt_extension = "EXT_meshopt_compression";
constexpr std::uint64_t container_bytes = 12 + 8 + 8; // header and the heads of two chunks

constexpr std::uint64_t padded(std::uint64_t bytes) {
    return (bytes + 3) / 4 * 4;
}

// stb hands over a file in one call or many; nothing may be thrown through its C frames.
struct ImageSink {
    std::vector<std::byte> bytes;
    std::exception_ptr failure;
};

void receive(void* context, void* data, int size) {
    auto& sink = *static_cast<ImageSink*>(context);
    try {
        const auto* begin = static_cast<const std::byte*>(data);
        if (!sink.failure) sink.bytes.insert(sink.bytes.end(), begin, begin + size);
    } catch (...) {
        sink.failure = std::current_exception();
    }
}

// encode(sink): what stb returns, 0 when it fails.
template <typename Encode>
std::vector<std::byte> encoded_image(const Encode& encode) {
    ImageSink sink;
    const int written = encode(&sink);
    if (sink.failure) std::rethrow_exception(sink.failure);
    if (!written) throw io::Failure(3, "not enough memory to encode a picture; ask for smaller textures");
    return std::move(sink.bytes);
}

} // namespace

Glb::Glb(const std::string& generator, std::string too_large, std::uint64_t max_bytes)
    : json{{"asset", {{"version", "2.0"}, {"generator", generator}}},
           {"scene", 0},
           {"scenes", {{{"nodes", Json::array()}}}}},
      too_large_(std::move(too_large)), max_bytes_(std::min(max_bytes, most_bytes)) {}

std::size_t Glb::add(const char* list, Json item) {
    json[list].push_back(std::move(item));
    return json[list].size() - 1;
}

std::size_t Glb::add_node(Json node) {
    const std::size_t index = add("nodes", std::move(node));
    json["scenes"][0]["nodes"].push_back(index);
    return index;
}

std::uint64_t Glb::add_piece(std::uint64_t bytes, std::function<void(const Put&)> make) {
    const std::uint64_t at = binary_bytes_;
    if (padded(bytes) > max_bytes_ - binary_bytes_) throw io::Failure(1, too_large_);
    pieces_.push_back({bytes, std::move(make)});
    binary_bytes_ += padded(bytes);
    return at;
}

std::size_t Glb::add_view(std::vector<std::byte> bytes, GlbTarget target, std::size_t stride) {
    const std::size_t length = bytes.size();
    const std::size_t index = add_view(length, target, [kept = std::move(bytes)](const Put& put) { put(kept); });
    if (stride != 0) json["bufferViews"][index]["byteStride"] = stride;
    return index;
}

std::size_t Glb::add_view(std::uint64_t bytes, GlbTarget target, std::function<void(const Put&)> make) {
    Json view{{"buffer", 0}, {"byteOffset", add_piece(bytes, std::move(make))}, {"byteLength", bytes}};
    if (target != GlbTarget::none) view["target"] = static_cast<int>(target);
    return add("bufferViews", std::move(view));
}

std::size_t Glb::add_compressed_view(std::vector<std::byte> encoded, GlbTarget target, std::size_t count,
                                     std::size_t stride) {
    require_extension(meshopt_extension);
    const std::size_t length = encoded.size();
    const std::uint64_t at = add_piece(length, [kept = std::move(encoded)](const Put& put) { put(kept); });
    const bool vertices = target == GlbTarget::vertices;
    Json view{{"buffer", 1}, {"byteOffset", decoded_bytes_}, {"byteLength", count * stride}};
    if (vertices) view["byteStride"] = stride;
    view["target"] = static_cast<int>(target);
    view["extensions"][meshopt_extension] = {{"buffer", 0},          {"byteOffset", at},
                                             {"byteLength", length}, {"byteStride", stride},
                                             {"count", count},       {"mode", vertices ? "ATTRIBUTES" : "TRIANGLES"}};
    decoded_bytes_ += padded(count * stride);
    return add("bufferViews", std::move(view));
}

std::size_t Glb::add_indices(std::size_t view, std::size_t count, std::size_t vertices) {
    return add("accessors", {{"bufferView", view},
                             {"componentType", static_cast<int>(fits_16_bits(vertices) ? glb_uint16 : glb_uint32)},
                             {"count", count},
                             {"type", "SCALAR"}});
}

std::size_t Glb::add_texture(const std::string& name, std::vector<std::byte> image, const char* mime_type) {
    constexpr int linear = 9729, linear_mipmap_linear = 9987, clamp_to_edge = 33071;
    if (!json.contains("samplers"))
        add("samplers", {{"magFilter", linear},
                         {"minFilter", linear_mipmap_linear},
                         {"wrapS", clamp_to_edge},
                         {"wrapT", clamp_to_edge}});
    const std::size_t view = add_view(std::move(image), GlbTarget::none);
    const std::size_t source = add("images", {{"name", name}, {"mimeType", mime_type}, {"bufferView", view}});
    return add("textures", {{"sampler", 0}, {"source", source}});
}

void Glb::require_extension(const std::string& name) {
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
        Json& names = json[list];
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
}

std::uint64_t Glb::close() {
    json["buffers"] = Json::array({{{"byteLength", binary_bytes_}}});
    if (decoded_bytes_ > 0) // where decoders put what they decode; it has no bytes
        json["buffers"].push_back(
            {{"byteLength", decoded_bytes_}, {"extensions", {{meshopt_extension, {{"fallback", true}}}}}});
    // A CRS comes from a file and may hold anything; JSON must be UTF-8.
    text_ = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    text_.resize(padded(text_.size()), ' ');
    const std::uint64_t total = container_bytes + text_.size() + binary_bytes_;
    if (total > max_bytes_) throw io::Failure(1, too_large_);
    return total;
}

// The container (glTF 2.0, section 4.4): a header of 12 bytes, then chunks of length, type and data, all in words of 4.
void Glb::write(const Put& put) const {
    const auto words = [&](std::initializer_list<std::uint64_t> list) {
        for (const std::uint64_t value : list) {
            const auto word = static_cast<std::uint32_t>(value);
            put(std::as_bytes(std::span(&word, 1)));
        }
    };
    words({0x46546c67, 2, container_bytes + text_.size() + binary_bytes_, text_.size(), 0x4e4f534a});
    put(std::as_bytes(std::span(text_)));
    words({binary_bytes_, 0x004e4942});
    constexpr std::array<std::byte, 3> zeros{};
    for (const Piece& piece : pieces_) {
        piece.make(put);
        if (const std::uint64_t rest = padded(piece.bytes) - piece.bytes; rest != 0)
            put(std::span(zeros).first(static_cast<std::size_t>(rest)));
    }
}

std::vector<std::byte> Glb::bytes() const {
    std::vector<std::byte> all;
    write([&](std::span<const std::byte> some) { all.insert(all.end(), some.begin(), some.end()); });
    return all;
}

std::vector<std::byte> index_bytes(std::span<const std::uint32_t> indices, std::size_t vertices) {
    std::vector<std::byte> bytes(indices.size() * (fits_16_bits(vertices) ? 2 : 4));
    if (!fits_16_bits(vertices)) {
        std::memcpy(bytes.data(), indices.data(), bytes.size());
        return bytes;
    }
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const auto narrow = static_cast<std::uint16_t>(indices[i]);
        std::memcpy(&bytes[2 * i], &narrow, 2);
    }
    return bytes;
}

std::vector<std::byte> encode_png(std::uint32_t columns, std::uint32_t rows, std::span<const std::byte> rgb) {
    const int width = static_cast<int>(columns), height = static_cast<int>(rows);
    return encoded_image([&](ImageSink* sink) {
        return stbi_write_png_to_func(receive, sink, width, height, 3, rgb.data(), width * 3);
    });
}

std::vector<std::byte> encode_jpeg(std::uint32_t columns, std::uint32_t rows, std::span<const std::byte> rgb) {
    constexpr int quality = 90;
    const int width = static_cast<int>(columns), height = static_cast<int>(rows);
    return encoded_image(
        [&](ImageSink* sink) { return stbi_write_jpg_to_func(receive, sink, width, height, 3, rgb.data(), quality); });
}

} // namespace fjell::gltf
