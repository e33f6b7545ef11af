// Unsaved changes: kept from crashes, asked about before they would be lost, and what an editor keeps between runs.
#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "editor/files/persistence.h"
#include "editor/files/recovery.h"
#include "editor/handlers/handlers.h"
#include "fjell/io/failure.h"
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

// Home for an editor of its own.
struct Home {
    TemporaryFolder folder;
    Variable config{"XDG_CONFIG_HOME", (folder / "config").c_str()};
    Variable state{"XDG_STATE_HOME", (folder / "state").c_str()};
    Variable cache{"XDG_CACHE_HOME", (folder / "cache").c_str()};
};

// All of an editor but its window and its frames.
struct Editor {
    State state;
    Engine engine;
    Jobs jobs;

    void run(const std::string& line) { apply(*parse_command(line), {state, engine, jobs}); }
    void set(double error_px) { run("set refine.max_error_px " + std::to_string(error_px)); }
    [[nodiscard]] double error_px() const { return state.document.profile().refine.max_error_px; }
    [[nodiscard]] std::string last_message() const {
        return state.messages.all.empty() ? "" : state.messages.all.back().text;
    }
};

void change(Document& document, double error_px) {
    document.set(*fjell::find_profile_key("refine.max_error_px"), error_px, false);
}

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder, missing)) names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

std::string tiny_dem() {
    return "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n";
}

} // namespace

TEST_CASE("changes are kept every two seconds, found when their editor is no more, and not before") {
    const TemporaryFolder folder;
    const std::string where = folder / "state/fjell";
    Document document;
    const Route route;
    auto living = std::make_unique<Recovery>();
    living->start(where);
    living->keep(document, route, "a.fjell", 0);
    CHECK(names_in(where).empty()); // nothing has changed
    change(document, 3);
    living->keep(document, route, "a.fjell", 10);
    const std::string first = slurp(living->file());
    REQUIRE(!first.empty());
    change(document, 4);
    living->keep(document, route, "a.fjell", 11.9);
    CHECK(slurp(living->file()) == first);
    living->keep(document, route, "a.fjell", 12);
    CHECK(slurp(living->file()) != first);

    // Of editors that were killed in the middle of writing; the living one's stay.
    const auto names = names_in(where);
    for (const char* name : {"unsaved-1-0.json.tmp", "unsaved-1-0.json.lock", "unsaved-2-0.json.tmp"})
        spit(fs::path(where) / name, "");
    Recovery next;
    next.find(where);
    CHECK_FALSE(next.found()); // that editor lives
    CHECK(names_in(where) == names);
    living.reset();
    next.find(where);
    REQUIRE(next.found());
    CHECK(next.found()->profile.refine.max_error_px == 4);
    CHECK(next.found()->profile_changed);
    CHECK(next.found()->pack == "a.fjell");
    Recovery third;
    third.find(where);
    CHECK_FALSE(third.found()); // it is offered once
    next.drop_found();
    CHECK_FALSE(next.found());
    CHECK(names_in(where).empty());
}

TEST_CASE("a path that was not saved is found with the time that it takes, also when that alone has changed") {
    const TemporaryFolder folder;
    const std::string where = folder / "state/fjell";
    const Document document;
    Route route;
    session::Ground ground;
    ground.extent_x_m = ground.extent_z_m = 9000;
    ground.cell_m = 30;
    for (int i = 0; i < 4; ++i) route.add({{1000.0 * i, 500, 3000}, {0, 0, -1}, {0, 1, 0}}, ground);
    auto living = std::make_unique<Recovery>();
    living->start(where);
    living->keep(document, route, "a.fjell", 0);
    route.set_seconds(9.5, ground);
    living->keep(document, route, "a.fjell", 10);
    living.reset();
    Recovery next;
    next.find(where);
    REQUIRE(next.found());
    CHECK(next.found()->points == route.points());
    CHECK(next.found()->path_seconds == 9.5);
}

TEST_CASE("an unsaved path survives a crash as a file to be opened") {
    const Home home;
    std::vector<session::ControlPoint> points;
    {
        Editor editor;
        start_persistence(editor.state, true);
        session::Ground ground;
        ground.extent_x_m = ground.extent_z_m = 9000;
        ground.cell_m = 30;
        Route& route = editor.state.route;
        for (int i = 0; i < 4; ++i) route.add({{1000.0 * i, 500, 300.0 * i * i}, {0, 0, -1}, {0, 1, 0}}, ground);
        route.set_seconds(8, ground);
        editor.state.files.recovery.keep(editor.state.document, route, "", 10);
        points = route.points();
    } // it crashed
    Editor next;
    start_persistence(next.state, true);
    REQUIRE(next.state.files.recovery.found());
    next.run("recover restore");
    const session::CameraPath path = session::read_path(home.folder / "state/fjell/recovered-path.json");
    const session::CubicSpline<9>& spline = std::get<session::SplinePath>(path.kind).spline;
    REQUIRE(spline.knots().size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(spline.at(spline.knots()[i]) == points[i]);
    CHECK(path.seconds == 8);
    finish_persistence(next.state, true);
}

TEST_CASE("changes that are saved or undone are kept no longer") {
    const TemporaryFolder folder;
    Document document;
    Recovery recovery;
    recovery.start(folder / "state");
    for (const bool save : {true, false}) {
        change(document, save ? 3 : 4);
        recovery.keep_now(document, Route(), "");
        CHECK(names_in(folder / "state").size() == 2); // it and its lock
        save ? document.save(folder / "p.toml") : document.undo();
        recovery.keep(document, Route(), "", save ? 100 : 200);
        CHECK(names_in(folder / "state").empty());
    }
}

TEST_CASE("two editors keep their changes apart, and both are found, the latest first") {
    const TemporaryFolder folder;
    Document one, two;
    change(one, 3);
    change(two, 4);
    {
        Recovery first, second;
        first.start(folder / "state");
        second.start(folder / "state");
        first.keep_now(one, Route(), "");
        second.keep_now(two, Route(), "");
        CHECK(first.file() != second.file());
        fs::last_write_time(first.file(), fs::file_time_type::clock::now() - std::chrono::hours(1));
    }
    Recovery next;
    next.find(folder / "state");
    REQUIRE(next.found());
    CHECK(next.found()->profile.refine.max_error_px == 4);
    next.drop_found();
    REQUIRE(next.found());
    CHECK(next.found()->profile.refine.max_error_px == 3);
    next.drop_found();
    CHECK_FALSE(next.found());
}

TEST_CASE("changes of an editor that was killed are found") {
    const TemporaryFolder folder;
    int ready[2];
    REQUIRE(pipe(ready) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        Document document;
        change(document, 7);
        Recovery recovery;
        recovery.start(folder / "state");
        recovery.keep(document, Route(), "", 1);
        (void)!write(ready[1], "x", 1);
        for (;;) pause();
    }
    char done = 0;
    REQUIRE(read(ready[0], &done, 1) == 1);
    Recovery next;
    next.find(folder / "state");
    CHECK_FALSE(next.found());
    kill(child, SIGKILL);
    REQUIRE(waitpid(child, nullptr, 0) == child);
    next.find(folder / "state");
    REQUIRE(next.found());
    CHECK(next.found()->profile.refine.max_error_px == 7);
    close(ready[0]);
    close(ready[1]);
}

TEST_CASE("damaged changes are set aside with a message, and those that cannot be kept are told of once") {
    const TemporaryFolder folder;
    fs::create_directory(folder / "state");
    for (const char* text : {"", "{}", "{\"path\": 1}"}) {
        spit(folder / "state/unsaved-1-0.json", text);
        Recovery recovery;
        recovery.find(folder / "state");
        CHECK_FALSE(recovery.found());
        CHECK(recovery.take_problem().find("damaged") != std::string::npos);
        CHECK(names_in(folder / "state") == std::vector<std::string>{"unsaved-1-0.json.damaged"});
    }
    spit(folder / "file", "");
    Document document;
    Recovery recovery;
    recovery.start(folder / "file/fjell");
    int told = 0;
    for (int i = 0; i < 5; ++i) {
        change(document, 2 + i);
        recovery.keep(document, Route(), "", 10.0 * i);
        told += recovery.take_problem().empty() ? 0 : 1;
    }
    CHECK(told == 1);
}

TEST_CASE("quitting with changes asks first: cancelled, saved or discarded") {
    const TemporaryFolder folder;
    Editor editor;
    editor.set(3);
    editor.run("quit");
    CHECK_FALSE(editor.state.quit);
    CHECK(editor.state.interface.dialog == Dialog::unsaved);
    editor.run("go-on cancel");
    CHECK_FALSE(editor.state.quit);
    CHECK(editor.state.interface.dialog != Dialog::unsaved);
    editor.run("go-on discard"); // nothing waits any more
    CHECK_FALSE(editor.state.quit);

    editor.run("quit");
    editor.run("go-on save"); // it has no file yet
    CHECK(editor.state.interface.dialog == Dialog::save_profile);
    CHECK_FALSE(editor.state.quit);
    editor.run("save-profile /dev/full");
    CHECK_FALSE(editor.state.quit);
    CHECK(editor.state.document.unsaved());
    editor.run("save-profile " + folder / "p.toml");
    CHECK(editor.state.quit);
    CHECK(fjell::read_profile(folder / "p.toml").refine.max_error_px == 3);

    Editor other;
    other.set(3);
    other.run("quit");
    other.run("dialog none"); // closed
    other.run("save-profile " + folder / "q.toml");
    CHECK_FALSE(other.state.quit); // saved for its own sake
    other.set(4);
    other.run("quit");
    other.run("go-on discard");
    CHECK(other.state.quit);
    CHECK(fjell::read_profile(folder / "q.toml").refine.max_error_px == 3);

    Editor hasty;
    hasty.set(3);
    hasty.run("quit discard");
    CHECK(hasty.state.quit);
}

TEST_CASE("opening another profile with changes asks first, and remembers which one it was") {
    const TemporaryFolder folder;
    for (const char* verb : {"open", "open-profile"}) {
        spit(folder / "mine.toml", "[refine]\nmax_error_px = 2.0\n");
        spit(folder / "theirs.toml", "[refine]\nmax_error_px = 5.0\n");
        Editor editor;
        editor.run("open " + folder / "mine.toml");
        editor.set(3);
        editor.run(verb + (" " + folder / "theirs.toml"));
        CHECK(editor.error_px() == 3);
        CHECK(editor.state.interface.dialog == Dialog::unsaved);
        editor.run("go-on save");
        CHECK(fjell::read_profile(folder / "mine.toml").refine.max_error_px == 3);
        CHECK(editor.error_px() == 5);
        CHECK(editor.state.document.path() == folder / "theirs.toml");
        editor.set(4);
        editor.run(verb + (" " + folder / "mine.toml") + " discard");
        CHECK(editor.error_px() == 3);
        CHECK_FALSE(editor.state.document.unsaved());
    }
}

TEST_CASE("what cannot be opened is a message, heights are offered to be baked") {
    const TemporaryFolder folder;
    Editor editor;
    spit(folder / "damaged.fjell", "FJELLPK\nno more");
    spit(folder / "bad.toml", "[refine]\nmax_error_px = 0\n");
    spit(folder / "text", "text");
    for (const char* name : {"damaged.fjell", "bad.toml", "text", "missing"}) {
        INFO(name);
        editor.run("open " + folder / name);
        CHECK(editor.state.messages.all.back().severity == Severity::error);
        CHECK(editor.last_message().find(name) != std::string::npos);
        CHECK_FALSE(editor.state.scene.open());
        CHECK_FALSE(editor.state.document.unsaved());
        CHECK(editor.state.interface.recent.empty());
    }
    spit(folder / "dem.asc", tiny_dem());
    editor.run("open " + folder / "dem.asc");
    CHECK(editor.state.interface.dialog == Dialog::bake);
    CHECK(editor.state.bake.pack.inputs.front() == folder / "dem.asc");
    Editor script;
    script.state.headless = true;
    script.run("open " + folder / "dem.asc");
    CHECK(script.state.interface.dialog == Dialog::none);
    CHECK(script.jobs.running()); // baked beside, as from the command line
    script.jobs.cancel();
}

TEST_CASE("the keys in which a compared profile differs are listed, until theirs are taken") {
    const TemporaryFolder folder;
    spit(folder / "theirs.toml", "[refine]\nmax_error_px = 5.0\nmorph = \"time\"\n");
    Editor editor;
    editor.run("compare " + folder / "theirs.toml");
    update_file_state(editor.state);
    const std::vector<Difference>& differences = editor.state.files.differences;
    REQUIRE(differences.size() == 2);
    CHECK(std::string(differences[0].key->name) == "max_error_px");
    CHECK(differences[0].mine == "1.0");
    CHECK(differences[0].theirs == "5.0");
    CHECK(differences[1].theirs == "\"time\"");
    apply(SetKey{differences[0].key, differences[0].theirs_value, false}, {editor.state, editor.engine, editor.jobs});
    update_file_state(editor.state);
    CHECK(editor.error_px() == 5);
    CHECK(differences.size() == 1);
    editor.run("compare-off");
    update_file_state(editor.state);
    CHECK(differences.empty());
}

TEST_CASE("the title names the profile, with a star while it is not saved") {
    const TemporaryFolder folder;
    Editor editor;
    update_file_state(editor.state);
    CHECK(editor.state.files.title == "default profile - Fjell editor");
    editor.set(3);
    update_file_state(editor.state);
    CHECK(editor.state.files.title == "* default profile - Fjell editor");
    editor.run("save-profile " + folder / "p.toml");
    update_file_state(editor.state);
    CHECK(editor.state.files.title == "p.toml - Fjell editor");
    CHECK(editor.state.files.profile_name == "p.toml");
    editor.run("undo");
    update_file_state(editor.state);
    CHECK(editor.state.files.profile_name == "* p.toml");
}

TEST_CASE("an editor that ended against its will leaves its changes to the next one, which restores or discards them") {
    const Home home;
    spit(home.folder / "mine.toml", "# Mine.\n\n[refine]\nmax_error_px = 2.0\n");
    for (const bool restore : {true, false}) {
        {
            Editor editor;
            start_persistence(editor.state, true);
            editor.run("open " + home.folder / "mine.toml");
            editor.set(3);
            finish_persistence(editor.state, false); // a signal
        }
        Editor next;
        start_persistence(next.state, true);
        REQUIRE(next.state.files.recovery.found());
        next.run(restore ? "recover restore" : "recover discard");
        CHECK_FALSE(next.state.files.recovery.found());
        CHECK(next.error_px() == (restore ? 3 : 1));
        CHECK(next.state.document.unsaved() == restore);
        CHECK(next.state.document.path() == (restore ? home.folder / "mine.toml" : std::string()));
        if (restore) CHECK(names_in(home.folder / "state/fjell").size() == 2); // kept by this one now
        finish_persistence(next.state, true);
        CHECK(names_in(home.folder / "state/fjell").empty());
    }
}

TEST_CASE("packs that were opened are recent in the next run, and headless ones are not, nor are their changes kept") {
    const Home home;
    {
        Editor editor;
        start_persistence(editor.state, true);
        remember_pack("/packs/a.fjell", editor.state);
        remember_pack("/packs/b.fjell", editor.state);
    }
    {
        Editor script;
        start_persistence(script.state, false);
        CHECK(script.state.interface.recent.size() == 2);
        remember_pack("/packs/c.fjell", script.state);
        script.set(3);
        update_file_state(script.state);
        finish_persistence(script.state, false);
    }
    Editor next;
    start_persistence(next.state, true);
    CHECK(next.state.interface.recent == std::vector<std::string>{"/packs/b.fjell", "/packs/a.fjell"});
    CHECK(names_in(home.folder / "state/fjell").empty());
    CHECK(next.state.messages.all.empty());
}

TEST_CASE("how the window looks is kept once it has come to rest, but not what the command line alone has asked for") {
    const Home home;
    const auto frame = [](Editor& editor, double now_s) {
        editor.state.now_s = now_s;
        update_file_state(editor.state);
    };
    const auto kept = [&] {
        std::string problem;
        return read_settings(home.folder / "config/fjell", problem).look;
    };
    {
        Editor editor;
        start_persistence(editor.state, true);
        editor.state.interface.scale = 0.5; // --scale 0.5 --size 600x320
        editor.state.interface.width_px = 600;
        editor.state.interface.height_px = 320;
        frame(editor, 0);
        frame(editor, 5);
        CHECK(kept() == Look{}); // nothing has changed
        editor.run("column left width 400");
        editor.run("panel light");
        frame(editor, 6);
        frame(editor, 6.5);
        CHECK(kept() == Look{}); // it may still be dragged
        frame(editor, 7.5);
        CHECK(kept().arrangement == editor.state.interface.arrangement);
        CHECK(kept().scale == 0);
        CHECK(kept().width_px == 0);
        editor.run("mode wire");
        editor.run("contours 25");
        editor.state.interface.width_px = 700;
        frame(editor, 8);
        finish_persistence(editor.state, true); // at once
    }
    CHECK(kept().mode == session::PictureMode::wire);
    CHECK(kept().width_px == 700);
    Editor next;
    start_persistence(next.state, true);
    CHECK(next.state.interface.arrangement.shown(left_sections | right_sections) == Panel::light);
    CHECK(next.state.interface.mode == session::PictureMode::wire);
    CHECK(next.state.interface.contour_m == 25);
    Editor script;
    start_persistence(script.state, false); // a script's pictures are those of everybody
    CHECK(script.state.interface.arrangement == Arrangement{});
}

TEST_CASE("settings in which a key is given twice are refused with their line") {
    const Home home;
    fs::create_directories(home.folder / "config/fjell");
    spit(home.folder / "config/fjell/editor.json", "{\"recent\": [],\n\"scale\": 1,\n\"scale\": 2}");
    Editor editor;
    start_persistence(editor.state, true);
    CHECK_THAT(editor.last_message(), Catch::Contains("editor.json:3: \"scale\" is there twice"));
}

TEST_CASE("settings that cannot be read or written are a message, and the editor goes on") {
    const Home home;
    fs::create_directories(home.folder / "config/fjell/editor.json"); // a folder in its place
    Editor editor;
    start_persistence(editor.state, true);
    CHECK(editor.state.messages.all.size() == 1);
    remember_pack("/packs/a.fjell", editor.state);
    CHECK(editor.last_message().find("editor.json") != std::string::npos);
    CHECK(editor.state.interface.recent.size() == 1);
}

TEST_CASE("no command of the editor writes over the pack, the profile, the path or the script that is open") {
    const TemporaryFolder folder;
    Editor editor;
    editor.state.scene.path = folder / "terrain.fjell";
    editor.state.files.script = folder / "script";
    for (const char* name : {"terrain.fjell", "script", "dem.asc"}) spit(folder / name, tiny_dem());
    editor.run("save-profile " + (folder / "p.toml"));
    const std::string profile = slurp(folder / "p.toml");
    fs::create_hard_link(folder / "p.toml", folder / "same.csv");
    const auto refused = [&](const std::string& verb, const std::string& file) {
        editor.state.messages.all.clear();
        editor.run(verb + " " + (folder / file));
        CAPTURE(verb, file, editor.last_message());
        CHECK(editor.last_message().find("would overwrite") != std::string::npos);
        CHECK(slurp(folder / "p.toml") == profile);
        CHECK(slurp(folder / "script") == tiny_dem());
        CHECK(slurp(folder / "terrain.fjell") == tiny_dem());
    };
    for (const char* verb : {"save-path", "benchmark", "export"})
        for (const char* file : {"terrain.fjell", "p.toml", "same.csv", "script"}) refused(verb, file);
    refused("save-profile", "terrain.fjell");
    refused("save-profile", "script");
    refused("bake " + (folder / "dem.asc"), "p.toml");
    editor.state.messages.all.clear();
    editor.run("save-profile"); // over itself it may
    CHECK(editor.last_message().starts_with("saved "));
}
