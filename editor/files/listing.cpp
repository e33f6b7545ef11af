#include "editor/files/listing.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>

#include <unistd.h>

#include <cctype>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/read/gdal_file.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "fjell/pack.h"
#include "io/file.h"
#include "io/json.h"
#include "io/set_file.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

constexpr const char* everything[] = {".fjell", ".fjell-materials",
                                      ".toml",  ".json",
                                      ".txt",   ".path",
                                      ".tif",   ".tiff",
                                      ".hgt",   ".asc",
                                      ".dem",   ".vrt",
                                      ".nc",    ".png",
                                      ".img",   ".bil",
                                      ".flt",   ".adf",
                                      ".bmp",   ".dt0",
                                      ".dt1",   ".dt2",
                                      ".jp2"};
constexpr const char* profile_files[] = {".toml"};
constexpr const char* path_files[] = {".json", ".txt", ".path"};
constexpr const char* height_files[] = {".tif", ".tiff", ".hgt", ".asc", ".dem", ".vrt", ".nc",  ".png", ".img",
                                        ".bil", ".flt",  ".adf", ".bmp", ".dt0", ".dt1", ".dt2", ".jp2", ".json"};
constexpr const char* image_files[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".jp2", ".vrt", ".webp"};
constexpr const char* ramp_files[] = {".json"};
constexpr const char* pack_files[] = {".fjell"};
constexpr const char* mesh_files[] = {".glb"};

std::span<const char* const> endings_of(FileFilter filter) {
    switch (filter) {
    case FileFilter::profiles: return profile_files;
    case FileFilter::paths: return path_files;
    case FileFilter::heights: return height_files;
    case FileFilter::images: return image_files;
    case FileFilter::ramps:
    case FileFilter::rules: return ramp_files;
    case FileFilter::packs: return pack_files;
    case FileFilter::meshes: return mesh_files;
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

// --- Kinds of files.

namespace {

using io::Failure;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uintmax_t most_json_bytes = std::uintmax_t{64} << 20; // paths and recipes are far smaller

FileKind json_kind_of(const std::string& path) {
    std::error_code ignored;
    if (fs::file_size(path, ignored) > most_json_bytes)
        throw Failure(1, fmt::format("{}: too long for a camera path or a recipe", path));
    const json object = io::parse_json(io::read_text(path), path, io::JsonComments::yes);
    const auto has = [&](std::initializer_list<const char*> keys) {
        return std::ranges::any_of(keys, [&](const char* key) { return object.contains(key); });
    };
    if (has({"fjell_set"})) return FileKind::pack;
    if (has({"points", "orbit", "straight"})) return FileKind::path;
    if (has({"inputs", "relief_m", "feature_m"})) return FileKind::heights;
    if (has({"rules"})) return FileKind::rules;
    throw Failure(1, fmt::format("{}: JSON, but no camera path (points, orbit, straight), landscape (relief_m), recipe "
                                 "(inputs) or rules of materials (rules)",
                                 path));
}

} // namespace

BakeField bake_field_of(const std::string& path, bool first) {
    try {
        if (path.ends_with(".fjell")) return BakeField::output;
        if (path.ends_with(".json")) {
            const json object = io::parse_json(io::read_text(path), path, io::JsonComments::yes);
            return object.contains("stops")   ? BakeField::ramp
                   : object.contains("rules") ? BakeField::rules
                                              : BakeField::heights;
        }
        if (first) return BakeField::heights;
        baker::GdalMessages messages;
        baker::register_drivers();
        const baker::GdalFile file = baker::open_raster(path, "a height field or an image", messages);
        const bool bytes = file->GetRasterBand(1)->GetRasterDataType() == GDT_Byte;
        return bytes && file->GetRasterCount() >= 3 ? BakeField::texture : BakeField::heights;
    } catch (const std::exception&) {
        return BakeField::heights;
    }
}

FileKind file_kind_of(const std::string& path) {
    std::error_code error;
    if (baker::is_gdal_name(path)) return FileKind::heights;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) throw Failure(1, fmt::format("{}: there is no such file", path));
    if (fs::is_directory(status) && !io::set_file_of(path).empty()) return FileKind::pack;
    if (fs::is_directory(status)) throw Failure(1, fmt::format("{}: this is a folder; open a file in it", path));
    if (!fs::is_regular_file(status)) throw Failure(1, fmt::format("{}: not a file", path));
    char first[64] = {};
    const int fd = io::open_regular_file(path);
    const ssize_t read = io::uninterrupted([&] { return pread(fd, first, sizeof first - 1, 0); });
    close(fd);
    if (read < 0) io::disk_failure(path, "read");
    // By its name too, so that a damaged pack or profile is refused as such.
    if (std::memcmp(first, pack_magic, sizeof pack_magic) == 0 || path.ends_with(".fjell")) return FileKind::pack;
    if (path.ends_with(".toml")) return FileKind::profile;
    if (std::memcmp(first, io::MaterialsHeader{}.magic, sizeof io::MaterialsHeader::magic) == 0)
        return FileKind::materials;
    const char* const begins = first + std::strspn(first, " \t\r\n");
    if (*begins == '{') return json_kind_of(path);
    if (std::strncmp(begins, "F ", 2) == 0) return FileKind::path; // a line of a recorded one
    baker::GdalMessages messages;
    baker::register_drivers();
    try {
        (void)baker::open_raster(path, "a height field", messages);
        return FileKind::heights;
    } catch (const Failure&) {
        throw Failure(1, fmt::format("{}: neither a pack, a profile, a camera path nor heights that GDAL opens", path));
    }
}

} // namespace fjell::editor
