#include "editor/files/settings.h"

#include <algorithm>
#include <cstdlib>
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

// Reads what is there and is meant; the names of what is not are collected.
class KeyReader {
public:
    KeyReader(const json& object, std::string before) : object_(object), before_(std::move(before)) {}

    // read(value) throws what nlohmann::json does, or Failure, for what means nothing.
    template <typename Read>
    void key(const char* name, const Read& read) {
        if (!object_.contains(name)) return;
        try {
            read(object_.at(name));
        } catch (const std::exception&) {
            bad += (bad.empty() ? "" : ", ") + before_ + name;
        }
    }
    template <typename T>
    void value(const char* name, T& to) {
        key(name, [&](const json& j) { to = j.get<T>(); });
    }
    template <typename T>
    void number(const char* name, T& to, T least, T most) {
        key(name, [&](const json& j) {
            const T read = j.get<T>();
            if (!(read >= least && read <= most)) throw Unusable();
            to = read;
        });
    }

    std::string bad;

private:
    const json& object_;
    std::string before_;
};

template <std::size_t N>
std::size_t index_of(const json& name, const char* const (&names)[N]) {
    for (std::size_t i = 0; i < N; ++i)
        if (name.get_ref<const std::string&>() == names[i]) return i;
    throw Unusable();
}

void read_settings(KeyReader& keys, Settings& s) {
    keys.key("recent", [&](const json& packs) {
        std::vector<std::string> recent;
        if (!packs.is_array()) throw Unusable();
        for (const json& pack : packs)
            if (recent.size() < most_recent && !pack.get<std::string>().empty())
                recent.push_back(pack.get<std::string>());
        s.recent = std::move(recent);
    });
    keys.value("folder", s.folder);
    keys.key("materials", [&](const json& all) {
        std::vector<PackMaterials> materials;
        for (const json& j : all)
            if (materials.size() < most_packs_with_materials)
                materials.push_back({j.at("pack").get<std::string>(), j.at("materials").get<std::string>(),
                                     j.at("rules").get<std::string>()});
        s.materials = std::move(materials);
    });
}

// By its name now, or before.
Panel panel_of(const json& name) {
    for (const auto& former : former_panels)
        if (name == former.name) return group_names[static_cast<std::size_t>(former.group)].panel;
    return static_cast<Panel>(index_of(name, panel_names));
}

void read_arrangement(KeyReader& keys, Arrangement& a) {
    keys.value("panels", a.panels);
    keys.key("panels_latest", [&](const json& names) {
        std::vector<Panel> turned_to; // those that this editor does not have yet, or no more, go last
        for (const json& name : names) turned_to.push_back(panel_of(name));
        for (auto panel = turned_to.rbegin(); panel != turned_to.rend(); ++panel) a.turn_to(*panel);
    });
    keys.key("floating", [&](const json& all) {
        for (const auto& item : all.items()) {
            FloatingPanel& f = a.floating[static_cast<std::size_t>(panel_of(json(item.key())))];
            const json& place = item.value();
            const auto px = [&](const char* key, float least) {
                const auto value = place.at(key).get<float>();
                if (!(value >= least && value <= most_floating_px)) throw Unusable();
                return value;
            };
            f = {place.at("on").get<bool>(), px("x_px", -most_floating_px), px("y_px", 0),
                 px("width_px", least_floating_px), px("height_px", least_floating_px)};
        }
    });
    keys.key("groups_open", [&](const json& names) {
        a.open = {};
        for (const json& name : names)
            for (std::size_t i = 0; i < groups; ++i)
                a.open[i] = a.open[i] || name.get<std::string>() == group_names[i].name;
    });
    for (std::size_t i = 0; i < columns; ++i)
        keys.key(column_names[i], [&](const json& column) {
            KeyReader part(column, "");
            part.number("width_px", a.width_px[i], least_column_px, most_column_px);
            part.number("split", a.split[i], least_split, most_split);
            part.value("folded", a.folded[i]);
            if (!part.bad.empty()) throw Unusable();
        });
}

void read_look(KeyReader& keys, Look& look) {
    keys.key("scale", [&](const json& j) {
        const auto scale = j.get<double>();
        if (scale != 0 && !(scale >= 0.5 && scale <= 4)) throw Unusable();
        look.scale = scale;
    });
    keys.key("window_px", [&](const json& j) {
        const auto width = j.at(0).get<double>(), height = j.at(1).get<double>();
        for (const double px : {width, height})
            if (px != 0 && !(px >= 320 && px <= 8192)) throw Unusable();
        look.width_px = static_cast<std::uint32_t>(width);
        look.height_px = static_cast<std::uint32_t>(height);
    });
    keys.key("mode", [&](const json& name) {
        look.mode = static_cast<session::PictureMode>(index_of(name, session::picture_mode_names));
    });
    keys.key("overlays", [&](const json& names) {
        std::array<bool, overlays> shown{};
        for (const json& name : names) shown[index_of(name, overlay_names)] = true;
        look.overlay = shown;
    });
    keys.value("half_resolution", look.half_resolution);
    keys.key("contour_m", [&](const json& j) {
        const auto every_m = j.get<double>();
        if (every_m != 0 && !(every_m >= least_contour_m && every_m <= most_contour_m)) throw Unusable();
        look.contour_m = every_m;
    });
    read_arrangement(keys, look.arrangement);
}

json look_json(const Look& look) {
    const Arrangement& a = look.arrangement;
    json shown = json::array(), latest = json::array(), open = json::array(), floating = json::object();
    for (std::size_t i = 0; i < a.floating.size(); ++i)
        if (const FloatingPanel& f = a.floating[i]; !(f == FloatingPanel{}))
            floating[panel_names[i]] = {
                {"on", f.on}, {"x_px", f.x_px}, {"y_px", f.y_px}, {"width_px", f.width_px}, {"height_px", f.height_px}};
    for (std::size_t i = 0; i < look.overlay.size(); ++i)
        if (look.overlay[i]) shown.push_back(overlay_names[i]);
    for (const Panel panel : a.latest) latest.push_back(panel_names[static_cast<std::size_t>(panel)]);
    for (std::size_t i = 0; i < groups; ++i)
        if (a.open[i]) open.push_back(group_names[i].name);
    json all = {{"scale", look.scale},
                {"window_px", {look.width_px, look.height_px}},
                {"mode", session::picture_mode_names[static_cast<std::size_t>(look.mode)]},
                {"overlays", shown},
                {"half_resolution", look.half_resolution},
                {"contour_m", look.contour_m},
                {"panels", a.panels},
                {"panels_latest", latest},
                {"groups_open", open},
                {"floating", floating}};
    for (std::size_t i = 0; i < columns; ++i)
        all[column_names[i]] = {{"width_px", a.width_px[i]}, {"split", a.split[i]}, {"folded", a.folded[i]}};
    return all;
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
    Settings s;
    if (config_folder.empty() || !fs::exists(file, ignored)) return s;
    try {
        const json all = io::parse_json(io::read_text(file), file);
        if (!all.is_object()) throw Failure(1, fmt::format("{}: no settings", file));
        KeyReader keys(all, "");
        read_settings(keys, s);
        read_look(keys, s.look);
        if (!keys.bad.empty())
            problem = fmt::format("{}: {} cannot be understood; the default is taken", file, keys.bad);
    } catch (const std::exception& failure) {
        problem = failure.what();
        return {};
    }
    if (!problem.empty()) problem = fmt::format("{}; the file will be kept as {}.damaged", problem, file);
    return s;
}

void write_settings(const std::string& config_folder, const Settings& settings) {
    if (config_folder.empty()) return;
    std::error_code ignored; // what is wrong with the folder, the file says
    fs::create_directories(config_folder, ignored);
    const std::string path = settings_file(config_folder);
    std::string problem;
    (void)read_settings(config_folder, problem);
    json all = json::object();
    if (!problem.empty())
        fs::copy_file(path, path + ".damaged", fs::copy_options::overwrite_existing, ignored);
    else if (fs::exists(path, ignored))
        all = io::parse_json(io::read_text(path), path);
    json materials = json::array();
    for (const PackMaterials& m : settings.materials)
        materials.push_back({{"pack", m.pack}, {"materials", m.materials}, {"rules", m.rules}});
    all.update({{"recent", settings.recent}, {"folder", settings.folder}, {"materials", materials}});
    all.update(look_json(settings.look));
    const std::string text = all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
    io::AtomicFile file(path);
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

// --- Bookmarks.

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
    session::ControlPoint p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = j.at("pose").at(i).get<double>();
    p = session::unit_point(p);
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
