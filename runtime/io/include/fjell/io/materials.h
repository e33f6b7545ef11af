// A file of materials: what the ground is made of, near the eye. Textures that repeat, block-compressed, one after the
// other, as `fjell-bake materials` writes them and fjell::gl draws them.
//
// The file: MaterialsHeader, a MaterialRecord each, then for every mip from the finest to 4 x 4 texels, material by
// material: BC3 blocks, sRGB colours and in alpha the height, 0 the lowest; then in the same order BC5 blocks of the
// unit normal's components along u and v, each 128 + 127 v (fjell/texture.h). u runs east and v south where the ground
// is level. All little-endian. Units: metres, where the name says so. Ownership: Materials points into the bytes it was
// opened from. Thread: any. Complexity: opening reads every byte once. Failure: Failure (1) that names the file.
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
    std::uint32_t reserved = 0; // 0
    std::uint64_t hash = 0;     // XXH3 of everything behind the header
};
static_assert(sizeof(MaterialsHeader) == 32, "MaterialsHeader is stored: raise materials_version with any change");

struct MaterialRecord {
    char name[max_material_name + 1] = {}; // ends with a zero
    float size_m = 1;                      // of a texture's side
    float relief_m = 0;                    // from height 0 to height 1
    float mean[3] = {};                    // of the colour, linear light
    float coarse = 1;                      // drawn a second time, so many times larger
    float coarse_share = 0;                // and how much of it shows, 0 to 1
    float reserved = 0;
};
static_assert(sizeof(MaterialRecord) == 64, "MaterialRecord is stored: raise materials_version with any change");

struct Materials {
    std::uint32_t side_log2 = 0;
    std::vector<MaterialRecord> records;
    std::span<const std::byte> colour, normal; // 16 bytes a block each

    [[nodiscard]] std::uint32_t mips() const { return side_log2 - 1; }
    // Bytes of one material's mip, of either kind; where they begin in `colour` and `normal`.
    [[nodiscard]] std::size_t mip_bytes(std::uint32_t mip) const;
    [[nodiscard]] std::size_t mip_offset(std::uint32_t mip, std::uint32_t material) const;
    // -1: there is none of that name.
    [[nodiscard]] int find(std::string_view name) const;
};

// name: of the file, for messages.
[[nodiscard]] Materials open_materials(std::span<const std::byte> file, const std::string& name);
// The other way: header and records, in front of the blocks. Fills in the hash.
[[nodiscard]] std::vector<std::byte> materials_file(const Materials& materials);

} // namespace fjell::io
FJELL_API_END
