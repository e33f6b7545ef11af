#include "editor/bookmarks.h"

#include <algorithm>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::editor {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string file_of(const std::string& folder) {
    return folder + "/bookmarks.json";
}

Bookmark bookmark_of(const json& j) {
    Bookmark b;
    b.name = j.at("name").get<std::string>();
    b.pack = j.at("pack").get<std::string>();
    flight::ControlPoint p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = j.at("pose").at(i).get<double>();
    p = flight::unit_point(p);
    b.pose = {{p[0], p[1], p[2]}, {p[3], p[4], p[5]}, {p[6], p[7], p[8]}};
    return b;
}

} // namespace

std::vector<Bookmark> read_bookmarks(const std::string& folder, std::string& problem) {
    problem.clear();
    std::error_code ignored;
    if (folder.empty() || !fs::exists(file_of(folder), ignored)) return {};
    try {
        const json all = io::parse_json(io::read_text(file_of(folder)), file_of(folder));
        std::vector<Bookmark> bookmarks;
        for (const json& j : all.at("bookmarks")) {
            if (bookmarks.size() == most_bookmarks) break;
            bookmarks.push_back(bookmark_of(j));
        }
        return bookmarks;
    } catch (const std::exception& failure) {
        problem = fmt::format("{}: the bookmarks cannot be read ({}); move the file away to keep new ones",
                              file_of(folder), failure.what());
        return {};
    }
}

void write_bookmarks(const std::string& folder, const std::vector<Bookmark>& bookmarks) {
    if (folder.empty()) return;
    json list = json::array();
    for (const Bookmark& b : bookmarks) {
        const auto& [at, to, up] = b.pose;
        list.push_back(
            {{"name", b.name}, {"pack", b.pack}, {"pose", {at.x, at.y, at.z, to.x, to.y, to.z, up.x, up.y, up.z}}});
    }
    std::error_code ignored; // what is wrong with the folder, the file says
    fs::create_directories(folder, ignored);
    const std::string text = json{{"bookmarks", list}}.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
    io::AtomicFile file(file_of(folder));
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

} // namespace fjell::editor
