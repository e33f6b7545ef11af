#include "lab/store.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/file.h"

namespace fjell::lab {

using nlohmann::json;

namespace {

std::string line_of(const std::string& key, const Case& c, const json& measured) {
    return json{{"key", key}, {"case", c.json()}, {"measured", measured}}.dump() + "\n";
}

void write_whole(const std::string& path, const std::string& text) {
    io::AtomicFile file(path);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

} // namespace

Store::Store(const Recipe& recipe, const std::string& folder, bool fresh)
    : recipe_(recipe), file_(folder + "/" + recipe.name + ".jsonl") {
    std::filesystem::create_directories(folder);
    std::istringstream lines(fresh || !std::filesystem::exists(file_) ? std::string() : io::read_text(file_));
    std::string kept;
    for (std::string line; std::getline(lines, line);) {
        const json read = json::parse(line, nullptr, false);
        if (!read.is_object() || !read.contains("key") || !read["key"].is_string() || !read.contains("measured"))
            continue;
        const std::string key = read["key"].get<std::string>();
        if (measured_.emplace(key, read["measured"]).second) kept += line + "\n";
    }
    write_whole(file_, kept);
}

std::optional<json> Store::find(const Case& c) const {
    const auto at = measured_.find(key_of(recipe_, c));
    return at == measured_.end() ? std::nullopt : std::optional(at->second);
}

void Store::add(const Case& c, const json& measured) {
    const std::string key = key_of(recipe_, c);
    std::ofstream out(file_, std::ios::app | std::ios::binary);
    out << line_of(key, c, measured) << std::flush;
    if (!out) io::disk_failure(file_, "write");
    measured_[key] = measured;
}

} // namespace fjell::lab
