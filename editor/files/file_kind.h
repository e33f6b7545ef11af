// What a file is that is to be opened: told from its content.
//
// Thread: the frame's, on user actions. Complexity: reads the first bytes; JSON is read whole, 64 MiB at most.
#pragma once

#include <cstdint>
#include <string>

#include "editor/names.h"

namespace fjell::editor {

// heights: what GDAL opens as a raster, a landscape of content/terrain, or a recipe of fjell-bake.
// A pack set is a pack, by its folder or its set.json.
enum class FileKind : std::uint8_t { pack, profile, path, heights };
// Throws io::Failure (1), one line, for anything else.
[[nodiscard]] FileKind file_kind_of(const std::string& path);

// Where a file belongs in the dialog that bakes: a ramp, an image for the texture, or heights. first: there are no
// heights yet, so that a picture is taken for them. Failure: none; what cannot be told is heights, and refused there.
[[nodiscard]] BakeField bake_field_of(const std::string& path, bool first);

} // namespace fjell::editor
