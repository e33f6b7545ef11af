#include "editor/files.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/read/gdal_file.h"
#include "fjell/pack.h"
#include "io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

using io::Failure;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uintmax_t most_json_bytes = std::uintmax_t{64} << 20; // paths and recipes are far smaller

std::string variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? "" : value;
}

// XDG: what is not absolute does not count.
std::string folder_of(const char* name, const std::string& home, const char* otherwise) {
    const std::string given = variable(name);
    if (given.starts_with('/')) return given + "/fjell";
    return home.empty() ? "" : home + otherwise + "/fjell";
}

std::string settings_file(const std::string& folder) {
    return folder + "/editor.json";
}

FileKind kind_of_json(const std::string& path) {
    std::error_code ignored;
    if (fs::file_size(path, ignored) > most_json_bytes)
        throw Failure(1, fmt::format("{}: too long for a camera path or a recipe", path));
    const json object = json::parse(io::read_text(path), nullptr, false);
    const auto has = [&](std::initializer_list<const char*> keys) {
        return std::ranges::any_of(keys, [&](const char* key) { return object.contains(key); });
    };
    if (!object.is_object()) throw Failure(1, fmt::format("{}: begins like JSON, but is none", path));
    if (has({"points", "orbit", "straight"})) return FileKind::path;
    if (has({"inputs", "relief_m", "feature_m"})) return FileKind::heights;
    throw Failure(1,
                  fmt::format("{}: JSON, but no camera path (points, orbit, straight), landscape (relief_m) or recipe "
                              "(inputs)",
                              path));
}

} // namespace

Places places() {
    Places p;
    p.home = variable("HOME");
    p.config = folder_of("XDG_CONFIG_HOME", p.home, "/.config");
    p.state = folder_of("XDG_STATE_HOME", p.home, "/.local/state");
    p.cache = folder_of("XDG_CACHE_HOME", p.home, "/.cache");
    return p;
}

Settings read_settings(const std::string& config_folder, std::string& problem) {
    problem.clear();
    std::error_code ignored;
    const std::string file = settings_file(config_folder);
    if (config_folder.empty() || !fs::exists(file, ignored)) return {};
    try {
        const json j = json::parse(io::read_text(file));
        Settings s;
        for (const json& pack : j.at("recent"))
            if (s.recent.size() < most_recent && !pack.get<std::string>().empty())
                s.recent.push_back(pack.get<std::string>());
        s.folder = j.value("folder", "");
        s.scale = j.value("scale", 0.0);
        if (s.scale != 0 && !(s.scale >= 0.5 && s.scale <= 4)) s.scale = 0;
        return s;
    } catch (const Failure& failure) {
        problem = failure.what();
    } catch (const json::exception&) {
        problem = fmt::format("{}: damaged; recent files are forgotten, and it will be written anew", file);
    }
    return {};
}

void write_settings(const std::string& config_folder, const Settings& settings) {
    if (config_folder.empty()) return;
    std::error_code ignored; // what is wrong with the folder, the file says
    fs::create_directories(config_folder, ignored);
    const json j = {{"recent", settings.recent}, {"folder", settings.folder}, {"scale", settings.scale}};
    const std::string text = j.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
    io::AtomicFile file(settings_file(config_folder));
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

void remember(std::vector<std::string>& recent, const std::string& path) {
    std::error_code error;
    const fs::path absolute = fs::absolute(path, error).lexically_normal();
    std::string entry = error ? path : absolute.string();
    std::erase(recent, entry);
    recent.insert(recent.begin(), std::move(entry));
    if (recent.size() > most_recent) recent.resize(most_recent);
}

FileKind kind_of(const std::string& path) {
    std::error_code error;
    if (baker::is_gdal_name(path)) return FileKind::heights;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) throw Failure(1, fmt::format("{}: there is no such file", path));
    if (fs::is_directory(status)) throw Failure(1, fmt::format("{}: a folder; open a file in it", path));
    if (!fs::is_regular_file(status)) throw Failure(1, fmt::format("{}: not a file", path));
    char first[64] = {};
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Failure(3, fmt::format("{}: cannot be read; you may lack the permission", path));
    file.read(first, sizeof first - 1);
    // By its name too, so that a damaged pack or profile is refused as such.
    if (std::memcmp(first, pack_magic, sizeof pack_magic) == 0 || path.ends_with(".fjell")) return FileKind::pack;
    if (path.ends_with(".toml")) return FileKind::profile;
    const char* const begins = first + std::strspn(first, " \t\r\n");
    if (*begins == '{') return kind_of_json(path);
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
