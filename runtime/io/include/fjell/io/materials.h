// A file of materials: what the ground near the eye is made of. A material is a set of textures that repeat.
// `fjell-bake materials` writes such a file, and fjell::gl draws it.
//
// The file begins with a MaterialsHeader and a MaterialRecord for each material. Then follow BC3 blocks, for every mip
// from the finest to 4 x 4 texels, material by material: sRGB colour, and the height in alpha (0 is the lowest). In the
// same order follow BC5 blocks: the components of the unit normal along u and v, each as 128 + 127 v (fjell/texture.h).
// On level ground u runs east and v south. Everything is little-endian.
// Units: metres where the name says so. Ownership: Materials points into the bytes that it was opened from. Thread:
// any. Complexity: opening reads every byte once. Failure: Failure (1) that names the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::io {

inline constexpr std::uint32_t materials_version = 1, max_materials = 16, max_material_name = 31;
inline constexpr std::uint32_t min_material_log2 = 4, max_material_log2 = 11; // texels a side

struct MaterialsHeader {
    char magic[8] = {'F', 'J', 'E', 'L', 'L', 'M', 'A', 'T'};
    std::uint32_t version = materials_version;
    std::uint32_t materials = 0;
    std::uint32_t side_log2 = 0;
    std::uint32_t reserved = 0; // zero
    std::uint64_t hash = 0;     // XXH3 of everything behind the header
};
static_assert(sizeof(MaterialsHeader) == 32, "MaterialsHeader is stored: raise materials_version with any change");

struct MaterialRecord {
    char name[max_material_name + 1] = {}; // ends with a zero
    float size_m = 1;                      // the side of a texture
    float relief_m = 0;                    // between heights 0 and 1
    float mean[3] = {};                    // mean colour, linear light
    // The texture is drawn a second time, this many times larger.
    float coarse = 1;
    // How much of that second drawing shows, 0 to 1.
    float coarse_share = 0;
    float reserved = 0;
};
static_assert(sizeof(MaterialRecord) == 64, "MaterialRecord is stored: raise materials_version with any change");

struct Materials {
    std::uint32_t side_log2 = 0;
    std::vector<MaterialRecord> records;
    std::span<const std::byte> colour, normal; // 16 bytes a block each

    [[nodiscard]] std::uint32_t mips() const { return side_log2 - 1; }
    // The bytes of one material's mip, of either kind, and where they begin in `colour` and `normal`.
    [[nodiscard]] std::size_t mip_bytes(std::uint32_t mip) const;
    [[nodiscard]] std::size_t mip_offset(std::uint32_t mip, std::uint32_t material) const;
    // The number of a material, or -1 if no material has the name.
    [[nodiscard]] int find(std::string_view name) const;
};

// name: the file's, for messages.
[[nodiscard]] Materials open_materials(std::span<const std::byte> file, const std::string& name);
// The header and the records of a file; the blocks follow them. Fills in the hash.
[[nodiscard]] std::vector<std::byte> materials_file(const Materials& materials);

} // namespace fjell::io
FJELL_API_END
