#include "editor/files/settings.h"

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::editor {

namespace {

using io::Failure;
using nlohmann::json;
namespace fs = std::filesystem;

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

} // namespace

Folders standard_folders() {
    Folders p;
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
        const json j = io::parse_json(io::read_text(file), file);
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
        problem = fmt::format("{}: damaged; recent files are lost, and it will be rewritten", file);
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

} // namespace fjell::editor
