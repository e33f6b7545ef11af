// set.json, the index of a pack set's folder: which packs there are, and where in the terrain they lie.
//
// A reader of its own, for the few kinds of value that such a file has: hosts that read packs link no JSON library.
// Keys that it does not know are skipped. Failure: throws Failure with exit code 1, "NAME:LINE: what; what to do".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::io {

inline constexpr std::uint32_t set_file_version = 1;
inline constexpr std::uint32_t max_set_packs = 1u << 20;

struct SetFilePack {
    std::string file; // in the folder of the set
    std::uint32_t tile_x = 0, tile_y = 0, tiles_x = 0, tiles_y = 0;
    std::uint64_t pack_hash = 0; // PackHeader::directory_hash
    bool has_hash = false;
};
struct SetFile {
    std::uint32_t columns = 0, rows = 0, tile_cells = 0;
    double spacing_m[2] = {0, 0};
    std::vector<SetFilePack> packs;
};

// name: of the file, for messages.
[[nodiscard]] SetFile parse_set_file(std::string_view text, const std::string& name);
// The same, as text. One line a pack.
[[nodiscard]] std::string set_file_text(const SetFile& set);

// A folder with a set.json in it, or such a file itself: the file's name. Empty: the path is no set's.
[[nodiscard]] std::string set_file_of(const std::string& path);

} // namespace fjell::io
FJELL_API_END
