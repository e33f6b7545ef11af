#include "editor/document.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/file.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_steps = 500;

std::string changed_label(const fly::Profile& a, const fly::Profile& b) {
    std::string label;
    for (const fly::ProfileKey& key : fly::profile_keys()) {
        if (key.get(a) == key.get(b)) continue;
        if (!label.empty()) return "several values";
        label = key.label;
    }
    return label;
}

bool same(const fly::Profile& a, const fly::Profile& b) {
    return std::ranges::all_of(fly::profile_keys(),
                               [&](const fly::ProfileKey& key) { return key.get(a) == key.get(b); });
}

} // namespace

bool Document::unsaved() const {
    return !same(profile_, saved_);
}

std::string Document::undo_label() const {
    return undo_.empty() ? "" : changed_label(undo_.back(), profile_);
}

std::string Document::redo_label() const {
    return redo_.empty() ? "" : changed_label(profile_, redo_.back());
}

void Document::step() {
    if (undo_.size() == most_steps) undo_.erase(undo_.begin());
    undo_.push_back(profile_);
    redo_.clear();
}

void Document::set(const fly::ProfileKey& key, double value, bool dragging) {
    value = std::clamp(value, key.least, key.most);
    if (key.kind != fly::KeyKind::number) value = std::round(value);
    const bool changes = key.get(profile_) != value;
    if (changes && !dragging_) step(); // a drag is one step, from its beginning
    dragging_ = dragging && (changes || dragging_);
    if (changes) key.set(profile_, value);
}

void Document::undo() {
    if (undo_.empty()) return;
    dragging_ = false;
    redo_.push_back(std::exchange(profile_, undo_.back()));
    undo_.pop_back();
}

void Document::redo() {
    if (redo_.empty()) return;
    dragging_ = false;
    undo_.push_back(std::exchange(profile_, redo_.back()));
    redo_.pop_back();
}

void Document::replace(const fly::Profile& profile) {
    dragging_ = false;
    if (same(profile, profile_)) return;
    step();
    profile_ = profile;
}

void Document::revert() {
    if (undo_.empty()) return;
    profile_ = undo_.back();
    undo_.pop_back();
}

void Document::open(const std::string& path) {
    const fly::Profile read = fly::read_profile(path);
    replace(read);
    saved_ = read;
    path_ = path;
}

void Document::save(const std::string& path) {
    const std::string& to = path.empty() ? path_ : path;
    const std::string text = fly::profile_text(profile_, "");
    host::AtomicFile file(to);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    saved_ = profile_;
    path_ = to;
}

void Document::compare(const std::string& path) {
    compared_ = path.empty() ? saved_ : fly::read_profile(path);
    compared_path_ = path;
}

} // namespace fjell::editor
