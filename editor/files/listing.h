// What a file dialog looks at: the files of one folder, read when the folder changes and not in between.
//
// Thread: the frame's. Memory: some hundred bytes a file. Complexity: look() O(n log n) of the folder's files, filter()
// O(n). Failure: none; what cannot be read is a problem to show, and the list is empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "editor/names.h"

namespace fjell::editor {

class FolderListing {
public:
    struct Entry {
        std::string name;
        bool folder = false;
        std::uint64_t bytes = 0;
    };

    [[nodiscard]] const std::string& folder() const { return folder_; }   // absolute; empty: not looked anywhere yet
    [[nodiscard]] const std::string& parent() const { return parent_; }   // empty: there is none above
    [[nodiscard]] const std::string& problem() const { return problem_; } // why the folder cannot be read
    // Those that are shown: folders first, then files of the dialog's kinds, each by name.
    [[nodiscard]] std::size_t size() const { return shown_.size(); }
    [[nodiscard]] const Entry& entry(std::size_t i) const { return entries_[shown_[i]]; }
    [[nodiscard]] std::size_t hidden() const { return entries_.size() - shown_.size(); } // files of other kinds
    [[nodiscard]] bool all() const { return all_; }
    [[nodiscard]] bool has_file(std::string_view name) const;
    // The name in the folder, or the path that it is already.
    [[nodiscard]] std::string path_of(std::string_view name) const;

    void look(const std::string& folder);    // relative ones start at the one that is looked at
    void filter(FileFilter kinds, bool all); // which files are shown; all: whatever their kind
    [[nodiscard]] FileFilter kinds() const { return kinds_; }

private:
    void choose_shown();

    std::string folder_, parent_, problem_;
    std::vector<Entry> entries_;
    std::vector<std::size_t> shown_;
    FileFilter kinds_ = FileFilter::everything;
    bool all_ = false;
};

// Whether the dialog looks at files.
[[nodiscard]] bool shows_files(Dialog dialog);
[[nodiscard]] FileFilter filter_of(Dialog dialog);

// --- What a file is that is to be opened: told from its content.
//
// Thread: the frame's, on user actions. Complexity: reads the first bytes; JSON is read whole, 64 MiB at most.

// heights: what GDAL opens as a raster, a landscape of content/terrain, or a recipe of fjell-bake.
// A pack set is a pack, by its folder or its set.json.
// rules: that place materials.
enum class FileKind : std::uint8_t { pack, profile, path, heights, materials, rules };
// Throws io::Failure (1), one line, for anything else.
[[nodiscard]] FileKind file_kind_of(const std::string& path);

// Where a file belongs in the dialog that bakes: a ramp, an image for the texture, or heights. first: there are no
// heights yet, so that a picture is taken for them. Failure: none; what cannot be told is heights, and refused there.
[[nodiscard]] BakeField bake_field_of(const std::string& path, bool first);

} // namespace fjell::editor
