#include "lab/store.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/file.h"

namespace fjell::lab {

using nlohmann::json;

namespace {

std::string line_of(const std::string& key, const Case& c, const json& measured, double seconds) {
    return json{{"key", key}, {"case", c.json()}, {"measured", measured}, {"seconds", seconds}}.dump() + "\n";
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
    std::istringstream lines(std::filesystem::exists(file_) ? io::read_text(file_) : std::string());
    std::string kept;
    for (std::string line; std::getline(lines, line);) {
        const json read = json::parse(line, nullptr, false);
        if (!read.is_object() || !read.contains("key") || !read["key"].is_string() || !read.contains("measured"))
            continue;
        const std::string key = read["key"].get<std::string>();
        if (const auto at = read.find("seconds"); at != read.end() && at->is_number())
            seconds_[key] = at->get<double>();
        if (fresh) continue;
        if (measured_.emplace(key, read["measured"]).second) kept += line + "\n";
    }
    write_whole(file_, kept);
}

std::optional<json> Store::find(const Case& c) const {
    const auto at = measured_.find(key_of(recipe_, c));
    return at == measured_.end() ? std::nullopt : std::optional(at->second);
}

double Store::expected_s() const {
    const std::vector<Case> cases = cases_of(recipe_);
    double sum = 0;
    for (const Case& c : cases) {
        const std::string key = key_of(recipe_, c);
        if (measured_.contains(key)) continue;
        const auto at = seconds_.find(key);
        sum += at != seconds_.end() ? at->second : recipe_.about_s / static_cast<double>(cases.size());
    }
    return sum;
}

void Store::add(const Case& c, const json& measured, double seconds) {
    const std::string key = key_of(recipe_, c);
    std::ofstream out(file_, std::ios::app | std::ios::binary);
    out << line_of(key, c, measured, seconds) << std::flush;
    if (!out) io::disk_failure(file_, "write");
    measured_[key] = measured;
}

} // namespace fjell::lab
