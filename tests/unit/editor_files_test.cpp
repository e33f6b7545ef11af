// Settings, the kinds of files, the sample, and the listing of a folder.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "editor/files/listing.h"
#include "editor/files/settings.h"
#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"
#include "fjell/pack.h"
#include "support/environment.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::editor;
using test::slurp;
using test::spit;
using test::TemporaryFolder;
using test::Variable;

namespace {

namespace fs = std::filesystem;

std::string dem_text() {
    return "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n";
}

} // namespace

TEST_CASE("settings, state and cache are where XDG says, at home otherwise, and nowhere without a home") {
    const Variable home("HOME", "/home/me"), config("XDG_CONFIG_HOME", nullptr), state("XDG_STATE_HOME", "/elsewhere"),
        cache("XDG_CACHE_HOME", "relative");
    CHECK(standard_folders().config == "/home/me/.config/fjell");
    CHECK(standard_folders().state == "/elsewhere/fjell");
    CHECK(standard_folders().cache == "/home/me/.cache/fjell"); // XDG: only absolute ones count
    const Variable homeless("HOME", nullptr);
    CHECK(standard_folders().config.empty());
}

TEST_CASE("settings are read as they were written, and damaged ones are the defaults, with one line to say so") {
    const TemporaryFolder folder;
    std::string problem;
    const auto read = [&] { return read_settings(folder / "config", problem); };
    CHECK(read() == Settings{});
    CHECK(problem.empty()); // there are none yet
    Settings settings;
    settings.recent = {"/a/b.fjell", "/c \"d\".fjell"};
    settings.folder = "/a";
    settings.look = {1.5, 1700, 900, {}, session::PictureMode::levels, {true, false, false, true}, false};
    settings.look.arrangement.turn_to(Panel::cost);
    settings.look.arrangement.folded[1] = true;
    settings.look.arrangement.width_px[0] = 411;
    settings.look.arrangement.split[1] = 0.25F;
    settings.look.arrangement.panels = false;
    settings.look.arrangement.open[2] = !settings.look.arrangement.open[2];
    settings.materials = {{"/a/b.fjell", "built-in", "alpine"}, {"/c.fjell", "/m.fjell-materials", ""}};
    settings.look.arrangement.floating[3] = {true, -12, 40.5F, 300, 200};
    write_settings(folder / "config", settings);
    CHECK(read() == settings);
    CHECK(problem.empty());
    const std::string file = folder / "config/editor.json", kept = file + ".damaged";
    CHECK_FALSE(std::filesystem::exists(kept));
    for (const char* text :
         {"", "{", "[]", "{\"recent\": 3}", "{\"recent\": [3]}", "{\"recent\": [], \"scale\": \"x\"}",
          "{\"scale\": 1e9}", "{\"panels\": 3}", "{\"left\": {\"width_px\": 1}}", "{\"window_px\": [9]}",
          "{\"mode\": \"pretty\"}", "{\"panels_latest\": [\"sound\"]}"}) {
        INFO(text);
        spit(file, text);
        CHECK(read() == Settings{});
        CHECK(problem.find("editor.json") != std::string::npos);
        CHECK(problem.find('\n') == std::string::npos);
        write_settings(folder / "config", settings);
        CHECK(slurp(kept) == text); // nothing is lost
        CHECK(read() == settings);
    }
    spit(folder / "file", "");
    CHECK_THROWS_AS(write_settings(folder / "file/fjell", settings), io::Failure);
}

TEST_CASE("a key of the settings that means nothing costs that key alone, and an older or newer editor's cost none") {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder / "config");
    const std::string file = folder / "config/editor.json";
    std::string problem;
    spit(file, R"({"recent": ["/a.fjell"], "folder": "/b", "scale": "large", "mode": "levels"})");
    Settings settings = read_settings(folder / "config", problem);
    CHECK(problem.find("scale cannot be understood") != std::string::npos);
    CHECK(settings.recent.size() == 1);
    CHECK(settings.look.mode == session::PictureMode::levels);
    spit(file, R"({"recent": ["/a.fjell"], "folder": "/b", "scale": 2})"); // as the first editors wrote it
    settings = read_settings(folder / "config", problem);
    CHECK(problem.empty());
    CHECK(settings.look.scale == 2);
    CHECK(settings.look.arrangement == Arrangement{});
    // Panels as they were before there were groups.
    spit(
        file,
        R"({"panels_latest": ["time", "camera"], "floating": {"levels": {"on": true, "x_px": 1, "y_px": 2, "width_px": 300, "height_px": 200}}})");
    settings = read_settings(folder / "config", problem);
    CHECK(problem.empty());
    CHECK(settings.look.arrangement.latest.front() == Panel::cost);
    CHECK(settings.look.arrangement.floats(Panel::cost));
    spit(file, R"({"recent": [], "colours": {"night": true}})");
    write_settings(folder / "config", settings);
    CHECK(slurp(file).find("night") != std::string::npos);
}

TEST_CASE("recent files are absolute, the latest first, each once, ten at most") {
    std::vector<std::string> recent;
    for (int i = 0; i < 12; ++i) remember(recent, "/packs/" + std::to_string(i));
    CHECK(recent.size() == most_recent);
    CHECK(recent.front() == "/packs/11");
    remember(recent, "/packs/x/../5");
    CHECK(recent.front() == "/packs/5");
    CHECK(recent.size() == most_recent);
    CHECK(std::ranges::count(recent, "/packs/5") == 1);
    remember(recent, "here.fjell");
    CHECK(recent.front() == (fs::current_path() / "here.fjell").string());
}

TEST_CASE("what a file is, its content says") {
    const TemporaryFolder folder;
    const auto kind = [&](const char* name, const std::string& text) {
        spit(folder / name, text);
        return file_kind_of(folder / name);
    };
    CHECK(kind("a", std::string(pack_magic, sizeof pack_magic) + "rest") == FileKind::pack);
    CHECK(kind("damaged.fjell", "x") == FileKind::pack); // the one that reads it says what is wrong
    CHECK(kind("b.toml", "") == FileKind::profile);
    CHECK(kind("c", "{\"orbit\": {}}") == FileKind::path);
    CHECK(kind("d", "F 0 1 2 3") == FileKind::path);
    CHECK(kind("e.json", std::string(sample_landscape())) == FileKind::heights);
    CHECK(kind("f.json", "{\"inputs\": []}") == FileKind::heights);
    CHECK(kind("g.asc", dem_text()) == FileKind::heights);
    const auto all_are = [](const char* where, FileKind wanted) {
        std::size_t files = 0;
        for (const auto& path : fs::directory_iterator(where)) {
            CHECK(file_kind_of(path.path().string()) == wanted);
            ++files;
        }
        CHECK(files >= 2);
    };
    all_are(FJELL_SOURCE_DIR "/content/paths", FileKind::path);
    all_are(FJELL_SOURCE_DIR "/profiles", FileKind::profile);
    spit(folder / "text.txt", "no terrain");
    spit(folder / "empty", "");
    spit(folder / "other.json", "{\"name\": 1}");
    spit(folder / "broken.json", "{\"points\": [");
    for (const char* name : {"text.txt", "empty", "other.json", "broken.json", "missing", ""}) {
        INFO(name);
        try {
            (void)file_kind_of(folder / name);
            FAIL_CHECK("was taken");
        } catch (const io::Failure& failure) {
            CHECK(std::string(failure.what()).find('\n') == std::string::npos);
            CHECK(std::string(failure.what()).find(folder / name) != std::string::npos);
        }
    }
}

TEST_CASE("the sample is the landscape of content/, written where it is baked") {
    const TemporaryFolder folder;
    CHECK(sample_landscape() == slurp(FJELL_SOURCE_DIR "/content/terrain/mountains-small.json"));
    const BakePack bake = bake_sample(folder / "cache/fjell");
    REQUIRE(bake.inputs.size() == 1);
    CHECK(slurp(bake.inputs[0]) == sample_landscape());
    CHECK(bake.inputs[0].ends_with(".json")); // what tells a landscape from heights
    CHECK(bake.output == sample_pack(folder / "cache/fjell"));
    spit(folder / "file", "");
    CHECK_THROWS_AS(bake_sample(folder / "file/fjell"), io::Failure);
    CHECK_THROWS_AS(bake_sample(""), io::Failure);
}

TEST_CASE("a folder is listed with folders first, files of the dialog's kinds, and the rest on demand") {
    const TemporaryFolder folder;
    for (const char* name : {"b", "a"}) fs::create_directory(folder / name);
    spit(folder / "z.fjell", "12345");
    spit(folder / "Y.TIF", "");
    spit(folder / "p.toml", "");
    spit(folder / "program.exe", "");
    spit(folder / ".hidden.fjell", "");
    FolderListing browser;
    const auto names = [&] {
        std::vector<std::string> all;
        for (std::size_t i = 0; i < browser.size(); ++i) all.push_back(browser.entry(i).name);
        return all;
    };
    browser.filter(filter_of(Dialog::open_file), false);
    browser.look(folder.path.string());
    CHECK(names() == std::vector<std::string>{"a", "b", "Y.TIF", "p.toml", "z.fjell"});
    CHECK(browser.entry(0).folder);
    CHECK(browser.entry(4).bytes == 5);
    CHECK(browser.hidden() == 1);
    browser.filter(filter_of(Dialog::save_profile), false);
    CHECK(names() == std::vector<std::string>{"a", "b", "p.toml"});
    browser.filter(filter_of(Dialog::save_profile), true);
    CHECK(names().size() == 6);
    CHECK(browser.has_file("program.exe"));
    CHECK_FALSE(browser.has_file("a"));
    CHECK(browser.path_of("x.toml") == folder / "x.toml");
    CHECK(browser.path_of("/x.toml") == "/x.toml");
    browser.look("a"); // from here
    CHECK(browser.folder() == folder / "a");
    CHECK(browser.size() == 0);
    CHECK(browser.problem().empty());
    browser.look(browser.parent());
    CHECK(browser.folder() == folder.path.string());
    browser.look("/");
    CHECK(browser.parent().empty());
    browser.look("proc/..//");
    CHECK(browser.folder() == "/");
}

TEST_CASE("a folder that cannot be read is a problem to show, and a large one is listed whole") {
    const TemporaryFolder folder;
    spit(folder / "file", "");
    FolderListing browser;
    for (const char* name : {"file", "missing"}) {
        browser.look(folder / name);
        CHECK(browser.size() == 0);
        CHECK_FALSE(browser.problem().empty());
        CHECK(browser.parent() == folder.path.string()); // there is a way out
    }
    for (int i = 0; i < 5000; ++i) spit(folder / (std::to_string(i) + ".fjell"), "");
    browser.filter(filter_of(Dialog::open_file), false);
    browser.look(folder.path.string());
    CHECK(browser.problem().empty());
    CHECK(browser.size() == 5000);
}
