#include "fjell/io/materials.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#define XXH_INLINE_ALL // as runtime/src/shared/hash.cpp does
#include <xxhash.h>

#include "fjell/io/failure.h"

namespace fjell::io {

namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
    throw Failure(1, name + ": " + what + "; make it again with fjell-bake materials");
}

std::size_t blocks_of_all(std::uint32_t side_log2, std::size_t materials) {
    std::size_t blocks = 0;
    for (std::uint32_t log2 = 2; log2 <= side_log2; ++log2) blocks += std::size_t{1} << (2 * (log2 - 2));
    return blocks * materials * 16;
}

bool is_within(float value, float least, float most) {
    return value >= least && value <= most; // false for NaN
}

void check_record(const MaterialRecord& r, std::size_t i, const std::string& file) {
    const auto which = "material " + std::to_string(i);
    const char* const end = std::find(std::begin(r.name), std::end(r.name), '\0');
    const bool readable = std::all_of(std::begin(r.name), end, [](char c) { return c > ' ' && c < 127; });
    if (end == std::end(r.name) || end == std::begin(r.name) || !readable)
        refuse(file, which + " has no name of 1 to 31 letters");
    bool good = is_within(r.size_m, 0.25f, 64) && is_within(r.relief_m, 0, 64) && is_within(r.coarse, 1, 64) &&
                is_within(r.coarse_share, 0, 1);
    for (const float mean : r.mean) good = good && is_within(mean, 0, 1);
    if (!good) refuse(file, which + " (" + r.name + ") has a size, relief or mean out of range");
}

} // namespace

std::size_t Materials::mip_bytes(std::uint32_t mip) const {
    return (std::size_t{16} << (2 * (side_log2 - mip))) / 16;
}

std::size_t Materials::mip_offset(std::uint32_t mip, std::uint32_t material) const {
    std::size_t offset = 0;
    for (std::uint32_t finer = 0; finer < mip; ++finer) offset += mip_bytes(finer) * records.size();
    return offset + mip_bytes(mip) * material;
}

int Materials::find(std::string_view name) const {
    for (std::size_t i = 0; i < records.size(); ++i)
        if (name == records[i].name) return static_cast<int>(i);
    return -1;
}

Materials open_materials(std::span<const std::byte> file, const std::string& name) {
    MaterialsHeader header;
    const MaterialsHeader ours;
    if (file.size() >= sizeof header) std::memcpy(&header, file.data(), sizeof header);
    if (file.size() < sizeof header || std::memcmp(header.magic, ours.magic, sizeof ours.magic) != 0)
        refuse(name, "is not a file of materials");
    if (header.version != materials_version)
        refuse(name, "has materials of version " + std::to_string(header.version) +
                         ", and this program reads version " + std::to_string(materials_version));
    if (header.materials < 1 || header.materials > max_materials || header.side_log2 < min_material_log2 ||
        header.side_log2 > max_material_log2 || header.reserved != 0)
        refuse(name, "has a damaged header");
    const std::size_t records = header.materials * sizeof(MaterialRecord);
    const std::size_t blocks = blocks_of_all(header.side_log2, header.materials);
    if (file.size() != sizeof header + records + 2 * blocks)
        refuse(name, "has " + std::to_string(file.size()) + " bytes where its header says " +
                         std::to_string(sizeof header + records + 2 * blocks));
    const std::span<const std::byte> rest = file.subspan(sizeof header);
    if (XXH3_64bits(rest.data(), rest.size()) != header.hash) refuse(name, "is damaged");
    Materials materials;
    materials.side_log2 = header.side_log2;
    materials.records.resize(header.materials);
    std::memcpy(materials.records.data(), rest.data(), records);
    for (std::size_t i = 0; i < materials.records.size(); ++i) {
        check_record(materials.records[i], i, name);
        if (materials.find(materials.records[i].name) != static_cast<int>(i))
            refuse(name, std::string("has two materials called ") + materials.records[i].name);
    }
    materials.colour = rest.subspan(records, blocks);
    materials.normal = rest.subspan(records + blocks, blocks);
    return materials;
}

std::vector<std::byte> materials_file(const Materials& materials) {
    MaterialsHeader header;
    header.materials = static_cast<std::uint32_t>(materials.records.size());
    header.side_log2 = materials.side_log2;
    const auto records = std::as_bytes(std::span(materials.records));
    std::vector<std::byte> file(sizeof header);
    for (const std::span<const std::byte> part : {records, materials.colour, materials.normal})
        file.insert(file.end(), part.begin(), part.end());
    header.hash = XXH3_64bits(file.data() + sizeof header, file.size() - sizeof header);
    std::memcpy(file.data(), &header, sizeof header);
    return file;
}

} // namespace fjell::io
