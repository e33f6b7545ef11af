// Places that the user keeps; beside the settings, in bookmarks.json.
//
// Thread: the frame's, on user actions. Failure: writing throws io::Failure; of a file that cannot be read there are no
// bookmarks, and a problem to report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "flight/path.h"

namespace fjell::editor {

inline constexpr std::size_t most_bookmarks = 64;

struct Bookmark {
    std::string name, pack; // the pack's absolute path: a bookmark is of one terrain
    flight::Pose pose;
};

struct Bookmarks {
    std::vector<Bookmark> all;
    std::string pack; // whose bookmarks are shown: the open one's
};

// folder: of the settings. Without one nothing is read or written.
[[nodiscard]] std::vector<Bookmark> read_bookmarks(const std::string& folder, std::string& problem);
void write_bookmarks(const std::string& folder, const std::vector<Bookmark>& bookmarks);

} // namespace fjell::editor
