// A binary glTF 2.0 under construction: its JSON, and the binary chunk as a list of pieces. Snapshots, meshes of height
// fields and 3D Tiles are all written here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::gltf {

// As the specification numbers them.
enum GlbType : int { glb_int8 = 5120, glb_int16 = 5122, glb_uint16 = 5123, glb_uint32 = 5125, glb_float = 5126 };
enum class GlbTarget : std::uint16_t { none = 0, vertices = 34962, indices = 34963 };

class Glb {
public:
    using Json = nlohmann::ordered_json;
    using Put = std::function<void(std::span<const std::byte>)>;
    static constexpr std::uint64_t most_bytes = 0xffff'ffff; // glTF counts in 32 bits

    // A file of more than max_bytes throws io::Failure 1, too_large, before anything more is allocated.
    Glb(const std::string& generator, std::string too_large, std::uint64_t max_bytes = most_bytes);

    Json json; // nodes and meshes are the caller's to add; scene 0 has the nodes of add_node()

    // These return the index of what they add.
    std::size_t add_node(Json node);
    std::size_t add(const char* list, Json item); // to "meshes", "accessors" and the like
    // stride: of interleaved vertices; 0: they are tight.
    std::size_t add_view(std::vector<std::byte> bytes, GlbTarget target, std::size_t stride = 0);
    // make(put) gives the bytes when they are written, for what need not be in memory twice.
    std::size_t add_view(std::uint64_t bytes, GlbTarget target, std::function<void(const Put&)> make);
    // Encoded as EXT_meshopt_compression has it; decoded it has count times stride bytes.
    std::size_t add_compressed_view(std::vector<std::byte> encoded, GlbTarget target, std::size_t count,
                                    std::size_t stride);
    // 16 bits wide where so many vertices allow it. The view is the caller's.
    std::size_t add_indices(std::size_t view, std::size_t count, std::size_t vertices);
    std::size_t add_texture(const std::string& name, std::vector<std::byte> image, const char* mime_type);
    // It may have been added already.
    void require_extension(const std::string& name);

    // Of the file. Nothing is added after it.
    std::uint64_t close();
    void write(const Put& put) const;
    [[nodiscard]] std::vector<std::byte> bytes() const;

private:
    struct Piece {
        std::uint64_t bytes;
        std::function<void(const Put&)> make;
    };
    std::uint64_t add_piece(std::uint64_t bytes, std::function<void(const Put&)> make);

    std::string too_large_, text_;
    std::vector<Piece> pieces_; // a multiple of 4 bytes each
    std::uint64_t binary_bytes_ = 0, decoded_bytes_ = 0, max_bytes_;
};

// The largest 16-bit index restarts primitives, so it may not name a vertex.
[[nodiscard]] constexpr bool fits_16_bits(std::size_t vertices) {
    return vertices <= 0xffff;
}
// As bytes of the width that add_indices() chooses.
[[nodiscard]] std::vector<std::byte> index_bytes(std::span<const std::uint32_t> indices, std::size_t vertices);

// Rows of 8-bit RGB from the top. Throw io::Failure 3: too little memory.
[[nodiscard]] std::vector<std::byte> encode_png(std::uint32_t columns, std::uint32_t rows,
                                                std::span<const std::byte> rgb);
[[nodiscard]] std::vector<std::byte> encode_jpeg(std::uint32_t columns, std::uint32_t rows,
                                                 std::span<const std::byte> rgb);

} // namespace fjell::gltf
FJELL_API_END
