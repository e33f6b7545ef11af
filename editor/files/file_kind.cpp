#include "editor/files/file_kind.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/read/gdal_file.h"
#include "fjell/io/failure.h"
#include "fjell/pack.h"
#include "io/file.h"
#include "io/json.h"
#include "io/set_file.h"

namespace fjell::editor {

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
    throw Failure(
        1,
        fmt::format("{}: JSON, but no camera path (points, orbit, straight), landscape (relief_m) or recipe (inputs)",
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
