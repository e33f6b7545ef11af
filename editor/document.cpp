#include "editor/document.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_steps = 500;

const char* changed_label(const Profile& a, const Profile& b) {
    const char* label = "";
    for (const ProfileKey& key : profile_keys()) {
        if (key.get(a) == key.get(b)) continue;
        if (*label != '\0') return "several values";
        label = key.label;
    }
    return label;
}

} // namespace

bool same(const Profile& a, const Profile& b) {
    return std::ranges::all_of(profile_keys(), [&](const ProfileKey& key) { return key.get(a) == key.get(b); });
}

Profile with_light(Profile profile, LightPreset preset) {
    struct Values {
        double azimuth_deg, elevation_deg, visibility_km, bias_ev;
    };
    constexpr Values all[] = {{315, 40, 160, 0}, {100, 14, 120, 0}, {180, 58, 160, 0},
                              {275, 9, 90, 0.3}, {290, -4, 120, 0}, {200, 45, 18, 0}};
    static_assert(std::size(all) == std::size(light_preset_names), "a preset was added: give it values");
    const Values& v = all[static_cast<std::size_t>(preset)];
    gl::LightSettings& light = profile.light;
    light.sun = gl::SunBy::direction;
    light.azimuth_deg = v.azimuth_deg;
    light.elevation_deg = v.elevation_deg;
    light.air = gl::Air::physical;
    light.visibility_km = v.visibility_km;
    light.exposure = gl::Exposure::automatic;
    light.exposure_bias_ev = v.bias_ev;
    light.tone_curve = gl::ToneCurve::filmic;
    return profile;
}

bool Document::unsaved() const {
    return !same(profile_, file_.saved);
}

const char* Document::undo_label() const {
    return undo_.empty() ? "" : changed_label(undo_.back().profile, profile_);
}

const char* Document::redo_label() const {
    return redo_.empty() ? "" : changed_label(profile_, redo_.back().profile);
}

void Document::changing() {
    ++version_;
    if (!accepted_) accepted_ = Past{profile_, undo_, redo_, file_};
}

void Document::step() {
    if (undo_.size() == most_steps) undo_.erase(undo_.begin());
    undo_.push_back({profile_, next_edit_stamp()});
    redo_before_drag_ = std::exchange(redo_, {});
}

// Of a drag that came back to where it began, nothing is left.
void Document::end_drag() {
    if (!dragging()) return;
    held_ = nullptr;
    if (undo_.empty() || !same(profile_, undo_.back().profile)) return;
    undo_.pop_back();
    redo_ = std::exchange(redo_before_drag_, {});
}

void Document::ignore_rest_of_drag() {
    const ProfileKey* const held = held_;
    end_drag();
    held_ = held;
    ignoring_drag_ = held != nullptr;
}

void Document::set(const ProfileKey& key, double value, bool dragging) {
    if (held_ == &key && ignoring_drag_) {
        if (!dragging) held_ = nullptr, ignoring_drag_ = false;
        return;
    }
    if (held_ != nullptr && held_ != &key) { // another control, or a script, while one is held
        end_drag();
        held_ = nullptr, ignoring_drag_ = false;
    }
    value = std::clamp(value, key.least, key.most);
    if (key.kind != KeyKind::number) value = std::round(value);
    if (key.get(profile_) != value) {
        Profile changed = profile_;
        key.set(changed, value);
        if (const std::string conflict = profile_conflict(changed); !conflict.empty()) {
            end_drag();
            throw io::Failure(2, conflict);
        }
        changing();
        if (held_ == nullptr) step(); // a drag is one step, from its beginning
        profile_ = changed;
        if (dragging) held_ = &key;
    }
    if (!dragging) {
        if (held_ != nullptr) ++version_; // unheld is a change too
        end_drag();
    }
}

void Document::undo() {
    ignore_rest_of_drag();
    if (undo_.empty()) return;
    changing();
    redo_.push_back({std::exchange(profile_, undo_.back().profile), undo_.back().stamp});
    undo_.pop_back();
}

void Document::redo() {
    ignore_rest_of_drag();
    if (redo_.empty()) return;
    changing();
    undo_.push_back({std::exchange(profile_, redo_.back().profile), redo_.back().stamp});
    redo_.pop_back();
}

void Document::replace(const Profile& profile) {
    ignore_rest_of_drag();
    if (same(profile, profile_)) return;
    changing();
    step();
    profile_ = profile;
}

void Document::accept() {
    if (!dragging()) accepted_.reset();
}

bool Document::revert() {
    if (!accepted_) return false;
    ignore_rest_of_drag();
    Past past = std::move(*accepted_);
    accepted_.reset();
    ++version_;
    profile_ = past.profile;
    undo_ = std::move(past.undo);
    redo_ = std::move(past.redo);
    file_ = std::move(past.file);
    return true;
}

std::vector<std::string> Document::read(const std::string& path, Profile& profile, File& file) const {
    std::vector<std::string> renamed;
    const std::string text = io::read_text(path);
    profile = parse_profile(text, path, &renamed);
    file = {profile, path, profile_heading(text)};
    return renamed;
}

// Undo ends here: what was before is of another file, under whose name it would be saved.
void Document::begin_at(const Profile& profile, File file) {
    ignore_rest_of_drag();
    profile_ = profile;
    file_ = std::move(file);
    undo_.clear();
    redo_.clear();
}

std::vector<std::string> Document::open(const std::string& path) {
    Profile profile;
    File file;
    std::vector<std::string> renamed = read(path, profile, file);
    changing();
    begin_at(profile, std::move(file));
    return renamed;
}

void Document::save(const std::string& path) {
    const std::string to = path.empty() ? file_.path : path;
    if (to.empty()) throw io::Failure(2, "the profile has no file yet; say where to save it");
    const std::string text = profile_text(profile_, file_.heading);
    io::AtomicFile file(to);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    ++version_;
    file_.saved = profile_;
    file_.path = to;
    if (accepted_) accepted_->file = file_;
}

void Document::restore(const Profile& profile, const std::string& path) {
    Profile read_profile;
    File file;
    try {
        if (!path.empty()) (void)read(path, read_profile, file);
    } catch (const io::Failure&) { // gone or changed: all of it is unsaved then, and still to be saved there
        file = {{}, path, ""};
    }
    changing();
    const Profile saved = file.saved;
    begin_at(saved, std::move(file));
    replace(profile);
}

std::vector<std::string> Document::compare(const std::string& path) {
    std::vector<std::string> renamed;
    compared_ = path.empty() ? file_.saved : read_profile(path, &renamed);
    compared_path_ = path;
    ++version_;
    return renamed;
}

void Document::stop_comparing() {
    compared_.reset();
    compared_path_.clear();
    ++version_;
}

} // namespace fjell::editor
