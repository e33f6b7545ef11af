#include "editor/files/folder_listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <span>
#include <system_error>

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

constexpr const char* everything[] = {".fjell", ".toml", ".json", ".txt", ".path", ".tif", ".tiff", ".hgt",
                                      ".asc",   ".dem",  ".vrt",  ".nc",  ".png",  ".img", ".bil",  ".flt",
                                      ".adf",   ".bmp",  ".dt0",  ".dt1", ".dt2",  ".jp2"};
constexpr const char* profile_files[] = {".toml"};
constexpr const char* path_files[] = {".json", ".txt", ".path"};
constexpr const char* height_files[] = {".tif", ".tiff", ".hgt", ".asc", ".dem", ".vrt", ".nc",  ".png", ".img",
                                        ".bil", ".flt",  ".adf", ".bmp", ".dt0", ".dt1", ".dt2", ".jp2", ".json"};
constexpr const char* image_files[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".jp2", ".vrt", ".webp"};
constexpr const char* ramp_files[] = {".json"};
constexpr const char* pack_files[] = {".fjell"};

std::span<const char* const> endings_of(FileFilter filter) {
    switch (filter) {
    case FileFilter::profiles: return profile_files;
    case FileFilter::paths: return path_files;
    case FileFilter::heights: return height_files;
    case FileFilter::images: return image_files;
    case FileFilter::ramps:
    case FileFilter::rules: return ramp_files;
    case FileFilter::packs: return pack_files;
    case FileFilter::everything: break;
    }
    return everything;
}

bool ends_with(std::string_view name, std::string_view end) {
    if (name.size() < end.size()) return false;
    return std::equal(end.begin(), end.end(), name.end() - static_cast<std::ptrdiff_t>(end.size()), [](char a, char b) {
        return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
    });
}

bool comes_first(const FolderListing::Entry& a, const FolderListing::Entry& b) {
    return a.folder != b.folder ? a.folder : a.name < b.name;
}

} // namespace

bool shows_files(Dialog dialog) {
    return dialog == Dialog::open_file || dialog == Dialog::save_profile || dialog == Dialog::save_path ||
           dialog == Dialog::compare;
}

FileFilter filter_of(Dialog dialog) {
    switch (dialog) {
    case Dialog::save_profile:
    case Dialog::compare: return FileFilter::profiles;
    case Dialog::save_path: return FileFilter::paths;
    default: return FileFilter::everything;
    }
}

bool FolderListing::has_file(std::string_view name) const {
    return std::ranges::any_of(entries_, [&](const Entry& e) { return !e.folder && e.name == name; });
}

std::string FolderListing::path_of(std::string_view name) const {
    return (fs::path(folder_) / name).lexically_normal().string();
}

void FolderListing::look(const std::string& folder) {
    std::error_code error;
    fs::path place = fs::absolute(fs::path(folder_) / folder, error).lexically_normal();
    if (error) place = folder;
    if (!place.has_filename() && place.has_relative_path()) place = place.parent_path(); // a slash at its end
    folder_ = place.string();
    parent_ = place.has_relative_path() ? place.parent_path().string() : "";
    problem_.clear();
    entries_.clear();
    fs::directory_iterator at(place, fs::directory_options::none, error);
    for (const fs::directory_iterator end; !error && at != end; at.increment(error)) {
        std::error_code ignored; // a link to nowhere is a file of no bytes
        Entry entry{at->path().filename().string(), at->is_directory(ignored), 0};
        if (entry.name.starts_with('.')) continue;
        if (!entry.folder && at->is_regular_file(ignored)) entry.bytes = at->file_size(ignored);
        entries_.push_back(std::move(entry));
    }
    if (error) problem_ = fmt::format("cannot be read: {}", error.message());
    std::ranges::sort(entries_, comes_first);
    choose_shown();
}

void FolderListing::filter(FileFilter kinds, bool all) {
    kinds_ = kinds;
    all_ = all;
    choose_shown();
}

void FolderListing::choose_shown() {
    shown_.clear();
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const Entry& e = entries_[i];
        const auto fits = [&](const char* end) { return ends_with(e.name, end); };
        if (e.folder || all_ || std::ranges::any_of(endings_of(kinds_), fits)) shown_.push_back(i);
    }
}

} // namespace fjell::editor
