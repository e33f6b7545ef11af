// The profile being tuned: what it was when it was saved, and every step since.
//
// Thread: the frame's. Memory: a step is a Profile, some hundred bytes; the last 500 are kept. Failure: reading and
// writing throw host::Failure and leave the document as it was.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fly/profile.h"
#include "fly/profile_keys.h"

namespace fjell::editor {

class Document {
public:
    [[nodiscard]] const fly::Profile& profile() const { return profile_; }
    [[nodiscard]] const fly::Profile& saved() const { return saved_; }
    [[nodiscard]] const std::string& path() const { return path_; } // empty: the defaults, never saved
    [[nodiscard]] bool unsaved() const;                             // differs from what was saved
    [[nodiscard]] bool dragging() const { return dragging_; }       // a control is held: more of the same follows
    [[nodiscard]] std::size_t undo_steps() const { return undo_.size(); }
    [[nodiscard]] std::size_t redo_steps() const { return redo_.size(); }
    // What one step back, or forward, would change: the key's label, or empty.
    [[nodiscard]] std::string undo_label() const;
    [[nodiscard]] std::string redo_label() const;
    // Beside which the panels show this one's values; null: none.
    [[nodiscard]] const fly::Profile* compared() const { return compared_ ? &*compared_ : nullptr; }
    [[nodiscard]] const std::string& compared_path() const { return compared_path_; }

    // value is clamped to the key's range.
    void set(const fly::ProfileKey& key, double value, bool dragging);
    void undo();
    void redo();
    void replace(const fly::Profile& profile); // one step
    // What was set cannot be had: takes the last step back without a trace.
    void revert();

    void open(const std::string& path);
    void save(const std::string& path);
    void compare(const std::string& path); // empty: what was saved

private:
    void step();

    fly::Profile profile_, saved_;
    std::string path_, compared_path_;
    std::optional<fly::Profile> compared_;
    std::vector<fly::Profile> undo_, redo_;
    bool dragging_ = false;
};

} // namespace fjell::editor
