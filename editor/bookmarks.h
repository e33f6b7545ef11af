// Places that the user keeps, with a thumbnail of what is seen from there; beside the settings, in bookmarks.json and
// the folder bookmarks/.
//
// Thread: the frame's, on user actions. Memory: a thumbnail is 160 pixels wide, three bytes each. Failure: writing
// throws io::Failure; of a file that cannot be read there are no bookmarks, and a problem to report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fjell/gl/image.h"
#include "flight/path.h"

namespace fjell::editor {

inline constexpr std::size_t most_bookmarks = 64;
inline constexpr std::uint32_t thumbnail_px = 160; // its width

struct Bookmark {
    std::string name, pack; // the pack's absolute path: a bookmark is of one terrain
    flight::Pose pose;
    gl::Image thumbnail; // none yet, or none any more: 0 x 0
    unsigned texture = 0;
};

struct Bookmarks {
    std::vector<Bookmark> all;
    std::optional<std::size_t> wanted; // whose thumbnail the next picture is for
    std::string pack;                  // whose bookmarks are shown: the open one's
    bool changed = false;              // textures are out of date
};

// As wide as a thumbnail, each pixel the mean of those that it covers; smaller ones stay.
[[nodiscard]] gl::Image shrunk(const gl::Image& image);

// folder: of the settings. Without one nothing is read or written.
[[nodiscard]] std::vector<Bookmark> read_bookmarks(const std::string& folder, std::string& problem);
void write_bookmarks(const std::string& folder, const std::vector<Bookmark>& bookmarks);

} // namespace fjell::editor
