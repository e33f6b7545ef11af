#include "editor/bookmarks.h"

#include <algorithm>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "editor/strings.h"
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

std::string picture_of(const std::string& folder, std::size_t i) {
    return fmt::format("{}/bookmarks/{}.png", folder, i);
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

gl::Image shrunk(const gl::Image& image) {
    if (image.width <= thumbnail_px) return image;
    gl::Image small;
    small.width = thumbnail_px;
    small.height = std::max(image.height * thumbnail_px / image.width, 1u);
    small.rgb.reserve(std::size_t{small.width} * small.height * 3);
    for (std::uint32_t y = 0; y < small.height; ++y)
        for (std::uint32_t x = 0; x < small.width; ++x) {
            const std::uint32_t x0 = x * image.width / small.width, x1 = (x + 1) * image.width / small.width;
            const std::uint32_t y0 = y * image.height / small.height, y1 = (y + 1) * image.height / small.height;
            for (std::size_t c = 0; c < 3; ++c) {
                std::uint64_t sum = 0;
                for (std::uint32_t v = y0; v < y1; ++v)
                    for (std::uint32_t u = x0; u < x1; ++u) sum += image.pixel(u, v)[c];
                small.rgb.push_back(static_cast<std::uint8_t>(sum / (std::uint64_t{x1 - x0} * (y1 - y0))));
            }
        }
    return small;
}

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
            Bookmark& b = bookmarks.back();
            if (!gl::read_png(picture_of(folder, bookmarks.size() - 1), b.thumbnail).empty()) b.thumbnail = {};
            b.thumbnail = shrunk(b.thumbnail);
        }
        return bookmarks;
    } catch (const std::exception& failure) {
        problem = fmt::format(strings::notices::bookmarks_unreadable, file_of(folder), failure.what());
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
    fs::create_directories(folder + "/bookmarks", ignored);
    for (std::size_t i = 0; i < bookmarks.size(); ++i) {
        if (bookmarks[i].thumbnail.width == 0) {
            fs::remove(picture_of(folder, i), ignored);
            continue;
        }
        const std::string error = gl::write_png(bookmarks[i].thumbnail, picture_of(folder, i));
        if (!error.empty()) throw io::Failure(3, error);
    }
    fs::remove(picture_of(folder, bookmarks.size()), ignored); // of the one that was removed
    const std::string text = json{{"bookmarks", list}}.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
    io::AtomicFile file(file_of(folder));
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

} // namespace fjell::editor
