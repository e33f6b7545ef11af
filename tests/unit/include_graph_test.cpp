// Who includes whom, read from the sources: from programs to companions to the library, and never back
// (docs/architecture.md).
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

namespace {

namespace fs = std::filesystem;
using Sources = std::map<std::string, std::string>; // text by path from the root
using Names = std::vector<std::string>;

// Folders and the folders whose headers they may include beside their own. Of runtime/src others see `shared` alone.
const std::map<std::string, std::set<std::string>> rooms{
    {"runtime/include", {}},
    {"runtime/src/shared", {"runtime/include", "runtime/src"}},
    {"runtime/src", {"runtime/include", "runtime/src/shared"}},
    {"runtime/io", {"runtime/include"}},
    {"runtime/profile", {"runtime/include", "runtime/src/shared", "runtime/io", "runtime/gl"}},
    {"runtime/gl", {"runtime/include", "runtime/io"}},
    {"runtime/gltf", {"runtime/include", "runtime/io"}},
    {"runtime/session", {"runtime/include", "runtime/io", "runtime/profile", "runtime/gl", "runtime/gltf"}},
    {"runtime/fly",
     {"runtime/include", "runtime/io", "runtime/profile", "runtime/gl", "runtime/gltf", "runtime/session"}},
    {"baker", {"runtime/include", "runtime/src/shared", "runtime/io", "runtime/gltf"}},
    {"baker/python",
     {"runtime/include", "runtime/io", "runtime/profile", "runtime/gl", "runtime/gltf", "runtime/session", "baker"}},
    {"runtime/web", {"runtime/include", "runtime/io", "baker"}}, // for browsers: of the baker its meshes alone
    {"editor",
     {"runtime/include", "runtime/src/shared", "runtime/io", "runtime/profile", "runtime/gl", "runtime/gltf",
      "runtime/session", "baker"}},
};

std::string room_of(const std::string& path) {
    std::string innermost; // the longest: they are in order
    for (const auto& [room, may] : rooms)
        if (path.starts_with(room + "/")) innermost = room;
    return innermost;
}

// For hosts: the library's headers and those of its companions.
bool is_public(const std::string& path) {
    return path.find("/include/fjell") != std::string::npos;
}

// The file that `#include "name"` in `from` means, or nothing: made by the build.
std::string resolve(const Sources& sources, const std::string& from, const std::string& name) {
    for (const char* root : {".", "runtime/include", "runtime/io/include", "runtime/gl/include", "runtime/gltf/include",
                             "runtime/profile/include", "runtime/src", "runtime", ""}) {
        const fs::path folder = root == std::string_view(".") ? fs::path(from).parent_path() : fs::path(root);
        const std::string path = (folder / name).lexically_normal().string();
        if (sources.contains(path)) return path;
    }
    return {};
}

Names includes_of(const std::string& text) {
    Names names;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (const std::string start = "#include \""; line.starts_with(start))
            names.push_back(line.substr(start.size(), line.find('"', start.size()) - start.size()));
    return names;
}

struct Found {
    Names wrong;         // must not be
    Names included_once; // a header, not public, that a single source of another name includes
};

Found check(const Sources& sources) {
    Found found;
    std::map<std::string, std::set<std::string>> includers;
    std::map<std::string, int> files; // in a folder
    std::set<std::string> parents;
    for (const auto& [path, text] : sources) {
        const fs::path folder = fs::path(path).parent_path();
        ++files[folder.string()];
        for (fs::path p = folder.parent_path(); !p.empty(); p = p.parent_path()) parents.insert(p.string());
        for (const std::string& name : includes_of(text)) {
            if (name.ends_with(".cpp")) found.wrong.push_back(path + " includes the source " + name);
            const std::string header = resolve(sources, path, name);
            if (header.empty()) {
                if (!name.ends_with(".inc") && name != "fjell/version.h")
                    found.wrong.push_back(path + " includes " + name + ", which is nowhere");
                continue;
            }
            includers[header].insert(path);
            const std::string from = room_of(path), to = room_of(header);
            if (from != to && !rooms.at(from).contains(to)) found.wrong.push_back(path + " includes " + header);
        }
    }
    for (const auto& [folder, count] : files)
        if (count == 1 && !parents.contains(folder) && !is_public(folder))
            found.wrong.push_back(folder + " is a folder with one file");
    for (const auto& [header, by] : includers)
        if (by.size() == 1 && by.begin()->ends_with(".cpp") && !is_public(header) &&
            fs::path(header).stem() != fs::path(*by.begin()).stem())
            found.included_once.push_back(header + " is included by " + *by.begin() + " alone");
    return found;
}

// Constants of the library's sources that have the name of one in its headers. Where sources are compiled as one, each
// of them would hide the header's from those that follow, without a word from the compiler.
Names hiding_constants(const Sources& sources) {
    const auto constants_of = [](const std::string& text, const std::string& start) {
        Names names;
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);)
            for (std::size_t at = line.starts_with(start) ? line.find(" = ") : std::string::npos;
                 at != std::string::npos; at = line.find(" = ", at + 1)) {
                const std::size_t before = line.find_last_of(" *&", at - 1);
                names.push_back(line.substr(
                    before + 1, line.find('[', before) < at ? line.find('[', before) - before - 1 : at - before - 1));
            }
        return names;
    };
    std::map<std::string, std::string> declared; // in which header
    for (const auto& [path, text] : sources)
        if (path.ends_with(".h") && (path.starts_with("runtime/src/") || path.starts_with("runtime/include/")))
            for (const std::string& name : constants_of(text, "inline constexpr ")) declared[name] = path;
    Names hiding;
    for (const auto& [path, text] : sources)
        if (path.ends_with(".cpp") && path.starts_with("runtime/src/"))
            for (const std::string& name : constants_of(text, "constexpr "))
                if (declared.contains(name)) hiding.push_back(path + " hides " + name + " of " + declared[name]);
    return hiding;
}

Sources read_sources() {
    Sources sources;
    const fs::path root = FJELL_SOURCE_DIR;
    for (const char* top : {"runtime", "baker", "editor"})
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension();
            std::string path = fs::relative(entry.path(), root).string();
            if (path.ends_with(".h.in"))
                path.resize(path.size() - 3); // completed by CMake
            else if (extension != ".h" && extension != ".cpp")
                continue;
            std::ostringstream text;
            text << std::ifstream(entry.path()).rdbuf();
            sources[path] = text.str();
        }
    return sources;
}

} // namespace

TEST_CASE("programs include companions, companions the library, and nothing the other way round") {
    const Sources sources = read_sources();
    REQUIRE(sources.size() > 100);
    const Found found = check(sources);
    CHECK(found.wrong == Names{});
    CHECK(found.included_once == Names{}); // each would be a .cpp in disguise
}

TEST_CASE("fjell.h includes every header of the library but the optional one and those for C") {
    const Sources sources = read_sources();
    const Names included = includes_of(sources.at("runtime/include/fjell/fjell.h"));
    for (const auto& [path, text] : sources) {
        const std::string prefix = "runtime/include/";
        if (!path.starts_with(prefix) || path.ends_with("/fjell.h") || path.ends_with("/glm.h") ||
            path.find("/fjell_c") != std::string::npos)
            continue;
        CAPTURE(path);
        CHECK(std::find(included.begin(), included.end(), path.substr(prefix.size())) != included.end());
        for (const std::string& name : includes_of(text)) CHECK(name.starts_with("fjell/")); // nothing internal
    }
}

TEST_CASE("an arrow the wrong way, an included source and a folder with one file are found") {
    const Sources sound{{"runtime/include/fjell/a.h", ""},
                        {"runtime/include/fjell/b.h", "#include \"fjell/a.h\"\n"},
                        {"runtime/src/a.cpp", "#include \"fjell/a.h\"\n#include \"inner.h\"\n"},
                        {"runtime/src/inner.h", ""},
                        {"runtime/src/b.cpp", "#include \"fjell/b.h\"\n#include \"inner.h\"\n"},
                        {"runtime/io/file.h", "#include \"fjell/a.h\"\n"},
                        {"runtime/io/file.cpp", "#include \"file.h\"\n"},
                        {"runtime/src/shared/tree.h", ""},
                        {"runtime/src/shared/page.h", "#include \"shared/tree.h\"\n"},
                        {"baker/bake.h", "#include \"shared/page.h\"\n"},
                        {"baker/bake.cpp", "#include \"bake.h\"\n#include \"io/file.h\"\n#include \"ramp.inc\"\n"}};
    CHECK(check(sound).wrong == Names{});
    const auto with = [&](const std::string& path, const std::string& text) {
        Sources sources = sound;
        sources[path] = text;
        return check(sources).wrong;
    };
    CHECK(with("runtime/src/a.cpp", "#include \"io/file.h\"\n") ==
          Names{"runtime/src/a.cpp includes runtime/io/file.h"});
    CHECK(with("runtime/io/file.cpp", "#include \"inner.h\"\n") == // what only the library's own sources may
          Names{"runtime/io/file.cpp includes runtime/src/inner.h"});
    CHECK(with("baker/bake.cpp", "#include \"inner.h\"\n") == Names{"baker/bake.cpp includes runtime/src/inner.h"});
    CHECK(with("runtime/io/file.cpp", "#include \"baker/bake.h\"\n") ==
          Names{"runtime/io/file.cpp includes baker/bake.h"});
    CHECK(with("baker/bake.cpp", "#include \"bake.cpp\"\n") == Names{"baker/bake.cpp includes the source bake.cpp"});
    CHECK(with("baker/bake.cpp", "#include \"gone.h\"\n") == Names{"baker/bake.cpp includes gone.h, which is nowhere"});
    CHECK(with("editor/app.cpp", "") == Names{"editor is a folder with one file"});
    Sources once = sound;
    once["baker/other.cpp"] = "#include \"bake.h\"\n", once["baker/bake.cpp"] = "";
    CHECK(check(once).included_once == Names{"baker/bake.h is included by baker/other.cpp alone"});
}

TEST_CASE("no constant of a source of the library hides one of a header, so that sources may be compiled as one") {
    Sources sources = read_sources();
    CHECK(hiding_constants(sources) == Names{});
    sources["runtime/src/cut/planted.cpp"] = "constexpr std::uint64_t item_cost = 6, page_parts = 210, all[2] = {};\n";
    CHECK(hiding_constants(sources) ==
          Names{"runtime/src/cut/planted.cpp hides page_parts of runtime/src/cut/groups.h"});
}

TEST_CASE("every public header shows its symbols in a shared library, and is installed") {
    int headers = 0;
    for (const auto& [path, text] : read_sources()) {
        if (!is_public(path) || text.find("\nnamespace ") == std::string::npos) continue; // macros alone
        INFO(path);
        ++headers;
        const std::size_t begin = text.find("\nFJELL_API_BEGIN\n"), end = text.find("\nFJELL_API_END\n");
        REQUIRE(begin != std::string::npos);
        CHECK(text.find("\n#include") < begin);
        CHECK(text.rfind("\n#include") < begin); // what is included decides for itself
        CHECK(begin < text.find("\nnamespace fjell"));
        CHECK(end == text.size() - std::string("\nFJELL_API_END\n").size());
        CHECK(text.find("#include \"fjell/") != std::string::npos);
    }
    CHECK(headers > 25);
}
