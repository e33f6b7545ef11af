// Which of two edits is the later one, of the profile or of the camera path: so that one Undo takes back either.
//
// Thread: the frame's.
#pragma once

#include <cstdint>

namespace fjell::editor {

// Of an undo step, greater than of all before; 0 is none.
[[nodiscard]] inline std::uint64_t next_edit_stamp() {
    static std::uint64_t last = 0;
    return ++last;
}

} // namespace fjell::editor
