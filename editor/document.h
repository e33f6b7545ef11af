// The profile being tuned: what it was when it was saved, and every step since.
//
// A drag is one step, from the control's first change until it is let go; one that ends where it began is none. Thread:
// the frame's. Memory: a step is a Profile, some hundred bytes; the last 500 are kept. Failure: reading and writing
// throw io::Failure and leave the document as it was, and so do values that do not go together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "editor/names.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"

namespace fjell::editor {

// Of an undo step, greater than of all before; 0 is none.
[[nodiscard]] inline std::uint64_t next_edit_stamp() {
    static std::uint64_t last = 0;
    return ++last;
}

[[nodiscard]] bool same(const Profile& a, const Profile& b);
// With the preset's sun, air and exposure.
[[nodiscard]] Profile with_light(Profile profile, LightPreset preset);

class Document {
public:
    [[nodiscard]] const Profile& profile() const { return profile_; }
    [[nodiscard]] const Profile& saved() const { return file_.saved; }
    [[nodiscard]] const std::string& path() const { return file_.path; }       // empty: the defaults, never saved
    [[nodiscard]] const std::string& heading() const { return file_.heading; } // what its file begins with
    [[nodiscard]] bool unsaved() const;                                        // differs from what was saved
    // A control is held: more of the same follows.
    [[nodiscard]] bool dragging() const { return held_ != nullptr && !ignoring_drag_; }
    [[nodiscard]] const ProfileKey* held() const { return held_; } // the control; null: none
    [[nodiscard]] std::size_t undo_steps() const { return undo_.size(); }
    [[nodiscard]] std::size_t redo_steps() const { return redo_.size(); }
    // Of the next step back, or forward (next_edit_stamp()); 0: there is none.
    [[nodiscard]] std::uint64_t undo_stamp() const { return undo_.empty() ? 0 : undo_.back().stamp; }
    [[nodiscard]] std::uint64_t redo_stamp() const { return redo_.empty() ? 0 : redo_.back().stamp; }
    // What one step back, or forward, would change: the key's label, "several values", or empty.
    [[nodiscard]] const char* undo_label() const;
    [[nodiscard]] const char* redo_label() const;
    // Beside which the panels show this one's values; null: none.
    [[nodiscard]] const Profile* compared() const { return compared_ ? &*compared_ : nullptr; }
    [[nodiscard]] const std::string& compared_path() const { return compared_path_; }
    // Grows with every change of any of this: for what is made from it and kept.
    [[nodiscard]] std::uint64_t version() const { return version_; }

    // value is clamped to the key's range. dragging: the control is held; an undo meanwhile ignores it until it
    // is released, which a call without dragging says.
    void set(const ProfileKey& key, double value, bool dragging);
    void undo();
    void redo();
    void replace(const Profile& profile); // one step

    // The engine goes by the profile as it is now.
    void accept();
    // The engine cannot: everything since the last accept() is reverted, whether it was set, undone, redone or
    // opened; what was saved meanwhile stays saved. False: there was nothing.
    bool revert();

    // Both: a line for each key under its old name.
    std::vector<std::string> open(const std::string& path);
    std::vector<std::string> compare(const std::string& path); // empty: with what was saved
    void save(const std::string& path);                        // empty: where it came from
    // Changes that an earlier run did not save, of the file at path, which may be gone.
    void restore(const Profile& profile, const std::string& path);
    void stop_comparing();

private:
    struct Step {
        Profile profile;
        std::uint64_t stamp = 0;
    };
    struct File {
        Profile saved;
        std::string path, heading;
    };
    struct Past {
        Profile profile;
        std::vector<Step> undo, redo;
        File file;
    };
    void changing(); // before any change: what accept() and revert() go by
    void step();
    void end_drag();
    void ignore_rest_of_drag();
    void begin_at(const Profile& profile, File file);
    [[nodiscard]] std::vector<std::string> read(const std::string& path, Profile& profile, File& file) const;

    Profile profile_;
    File file_;
    std::string compared_path_;
    std::optional<Profile> compared_;
    std::vector<Step> undo_, redo_;
    std::vector<Step> redo_before_drag_;
    const ProfileKey* held_ = nullptr;
    bool ignoring_drag_ = false; // what the held control says is not wanted any more
    std::optional<Past> accepted_;
    std::uint64_t version_ = 0;
};

} // namespace fjell::editor
