// Bakes that are killed, starved, interrupted and misled: nothing is lost, what is said is clear, and the same command
// comes to the same bytes. Faults are injected by support/fault_interposer.cpp at counted calls, so nothing here
// depends on time. Most run bake_child, which secures its work after every step; some the tool itself.
#include <catch2/catch.hpp>

#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell::test;

namespace {

constexpr int columns = 200, rows = 170; // 4 x 3 tiles of 64 cells, the last ones beyond the rim

const std::string old_pack = "an old pack, to be replaced by a whole one or not at all";

struct Fault {
    std::string calls, what, when, on = "out.fjell";
};

std::string with(const Fault& f, const std::string& command, const std::string& count_file = "") {
    return "ASAN_OPTIONS=$ASAN_OPTIONS:verify_asan_link_order=0 LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT='" + f.calls +
           " " + f.on + " " + f.what + " " + f.when + "' FJELL_FAULT_COUNT='" + count_file + "' " + command;
}

std::string heights(bool holes) {
    Random random(5);
    fjell::baker::Dem dem = random_dem(random, columns, rows, Shape::fractal);
    for (float& h : dem.heights_m) h = static_cast<float>(std::round(h * 10.0) * 0.1);
    if (holes) {
        add_random_holes(random, dem, 6);
        for (std::size_t i = 0; i < dem.voids.size(); ++i)
            if (dem.voids[i]) dem.heights_m[i] = std::numeric_limits<float>::quiet_NaN();
    }
    std::string bytes(dem.heights_m.size() * sizeof(float), 0);
    std::memcpy(bytes.data(), dem.heights_m.data(), bytes.size());
    return bytes;
}

// A folder with heights, the command that bakes them to out.fjell, and what an undisturbed bake makes of them.
class Scene {
public:
    explicit Scene(bool holes = true, int threads = 2) {
        spit(folder / "input", heights(holes));
        command = child(threads);
        const Run r = run_in(folder.path, command);
        INFO(r.err);
        REQUIRE(r.code == 0);
        whole = slurp(folder / "out.fjell");
        names = folder.names();
        REQUIRE(names == std::vector<std::string>{"input", "out.fjell"});
        age();
    }
    [[nodiscard]] static std::string child(int threads) {
        return FJELL_BIN_DIR "/bake_child out.fjell input " + std::to_string(columns) + " " + std::to_string(rows) +
               " " + std::to_string(threads);
    }
    void age() const { spit(folder / "out.fjell", old_pack); }
    [[nodiscard]] bool old() const { return slurp(folder / "out.fjell") == old_pack; }
    [[nodiscard]] bool is_whole() const { return slurp(folder / "out.fjell") == whole; }
    [[nodiscard]] Run run(const Fault& fault) const { return run_in(folder.path, with(fault, command)); }
    [[nodiscard]] Run run() const { return run_in(folder.path, command); }
    // How many such calls an undisturbed bake makes.
    [[nodiscard]] long count(const std::string& calls, const std::string& on = "out.fjell") const {
        const TemporaryFolder aside;
        const Run r = run_in(folder.path, with({calls, "none", "1", on}, command, aside / "count"));
        REQUIRE(r.code == 0);
        age();
        const long n = std::strtol(slurp(aside / "count").c_str(), nullptr, 10);
        REQUIRE(n > 0);
        return n;
    }
    // The old pack is as it was, or the new one is whole; the same command then makes it, and leaves nothing beside it.
    void recovers(bool resumes) const {
        REQUIRE((old() || is_whole()));
        const Run r = run();
        INFO(r.err);
        REQUIRE(r.code == 0);
        if (resumes) CHECK(r.out == "resumed\n");
        CHECK(is_whole());
        CHECK(folder.names() == names);
        age();
    }

    TemporaryFolder folder;
    std::string command, whole;
    std::vector<std::string> names;
};

bool one_line(const std::string& text) {
    return !text.empty() && std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

// The first, the last, and some between.
std::vector<long> spread(long count, int most) {
    std::vector<long> all;
    for (int i = 0; i < most; ++i) {
        const long n = 1 + (count - 1) * i / std::max(most - 1, 1);
        if (all.empty() || all.back() != n) all.push_back(n);
    }
    return all;
}

constexpr unsigned seed = 20;

} // namespace

TEST_CASE("a disk that fails at any call is one line and exit code 3, and leaves the old pack and nothing else") {
    const Scene scene(true, 1); // one thread makes the same calls every time
    const struct {
        const char *call, *error, *remedy;
        int samples;
    } kinds[] = {{"pwrite", "EIO", "check the disk", 4},        {"pwrite", "ENOSPC", "free some space", 4},
                 {"pread", "EIO", "check the disk", 4},         {"ftruncate", "ENOSPC", "free some space", 2},
                 {"fallocate", "ENOSPC", "free some space", 3}, {"open", "EACCES", "you may write to", 3},
                 {"open", "EIO", "check the disk", 2},          {"rename", "EIO", "check the disk", 4},
                 {"fsync", "EIO", "check the disk", 2},         {"close", "EIO", "check the disk", 0}};
    for (const auto& kind : kinds) {
        const long calls = scene.count(kind.call);
        for (const long n : spread(calls, kind.samples))
            for (const char* after : {"", "+"}) {
                if (*after && n != 1 && n != calls) continue; // a disk that stays full
                const Fault fault{kind.call, kind.error, std::to_string(n) + after};
                const Run r = scene.run(fault);
                CAPTURE(kind.call, kind.error, n, calls, after, r.err);
                // Some calls are only tried: what is taken away is not missed, and a folder need not be listed.
                if (r.code == 0 && std::string(kind.call) == "open") {
                    CHECK(scene.is_whole());
                    scene.age();
                    continue;
                }
                CHECK(r.code == 3);
                CHECK(one_line(r.err));
                CHECK(r.err.find("out.fjell") != std::string::npos);
                CHECK(r.err.find(kind.remedy) != std::string::npos);
                CHECK(scene.old());
                CHECK(scene.folder.names() == scene.names);
            }
    }
    scene.recovers(false);
}

TEST_CASE("short and interrupted calls change no byte") {
    const Scene scene;
    for (const char* what : {"short", "EINTR"})
        for (const char* when : {"%2", "%3", "%7"}) {
            const std::string calls = "pwrite,pread,write,read,";
            const Run r = scene.run({calls + (std::string(what) == "EINTR" ? "ftruncate,fallocate,fsync,open" : ""),
                                     what, when, "/out.fjell"});
            CAPTURE(what, when, r.err);
            CHECK(r.code == 0);
            CHECK(scene.is_whole());
            CHECK(scene.folder.names() == scene.names);
            scene.age();
        }
    SECTION("nor does a file system that cannot reserve space") {
        const Run r = scene.run({"fallocate", "EOPNOTSUPP", "1+"});
        CHECK(r.code == 0);
        CHECK(scene.is_whole());
    }
}

TEST_CASE("a bake that is killed at any of 50 moments goes on to the same bytes") {
    for (const bool holes : {true, false}) {
        const Scene scene(holes);
        const long calls = scene.count("all");
        std::mt19937 random(seed + holes);
        for (int i = 0; i < 25; ++i) {
            const long n = std::uniform_int_distribution<long>(1, calls)(random);
            const Run r = scene.run({"all", "kill", std::to_string(n)});
            CAPTURE(holes, seed, i, n, calls, r.err);
            // Two threads do not always make the same number of calls.
            if (r.code == 0 && n > calls * 9 / 10) {
                scene.age();
                continue;
            }
            REQUIRE(r.code == 128 + SIGKILL);
            scene.recovers(false);
        }
    }
}

TEST_CASE("a bake that is killed again and again gets there") {
    const Scene scene;
    const long calls = scene.count("all");
    std::mt19937 random(seed);
    for (int round = 0; round < 2; ++round) {
        int kills = 0, resumed = 0;
        for (Run r; kills < 200;) {
            // Far enough to read the ledger and do a unit or two, or there would be no end to it.
            const long n = std::uniform_int_distribution<long>(200, calls / 4)(random);
            r = scene.run({"all", "kill", std::to_string(n)});
            CAPTURE(seed, round, kills, n, r.err);
            if (r.code == 0) {
                resumed += r.out == "resumed\n";
                break;
            }
            REQUIRE(r.code == 128 + SIGKILL);
            REQUIRE((scene.old() || scene.is_whole()));
            ++kills;
        }
        CHECK(kills > 3);
        CHECK(kills < 200);
        CHECK(resumed == 1);
        CHECK(scene.is_whole());
        CHECK(scene.folder.names() == scene.names);
        scene.age();
    }
}

TEST_CASE("what is killed with two threads goes on with one, and the other way round") {
    Scene scene;
    const long calls = scene.count("all");
    for (const long n : spread(calls, 8)) {
        scene.command = Scene::child(n % 2 ? 2 : 1);
        const Run r = scene.run({"all", "kill", std::to_string(n)});
        scene.command = Scene::child(n % 2 ? 1 : 3);
        CAPTURE(n, calls, r.err);
        scene.recovers(false);
    }
}

TEST_CASE("Ctrl-C at any call is exit code 130 and says how to go on") {
    const Scene scene;
    const long calls = scene.count("pwrite");
    for (const long n : spread(calls, 8)) {
        const Run r = scene.run({"pwrite", "interrupt", std::to_string(n)});
        CAPTURE(n, calls, r.err);
        if (r.code == 0) { // in the last moment
            CHECK(n > calls * 9 / 10);
            CHECK(scene.is_whole());
            CHECK(scene.folder.names() == scene.names);
            scene.age();
            continue;
        }
        CHECK(r.code == 130);
        CHECK(one_line(r.err));
        CHECK(r.err.find("the same command goes on from there") != std::string::npos);
        CHECK(r.err.find("out.fjell.work") != std::string::npos);
        CHECK(scene.old());
        scene.recovers(true);
    }
}

TEST_CASE("signals from outside, at any time, are an interruption or come too late") {
    const Scene scene;
    for (const char* delay : {"0", "0.03", "0.08"})
        for (const char* signal : {"INT", "TERM", "HUP"}) {
            // Shells ignore SIGINT for what they start in the background; env takes it back.
            const Run r = run_in(scene.folder.path, "env --default-signal=INT " + scene.command + " & p=$!; sleep " +
                                                        delay + "; kill -" + signal + " $p; wait $p");
            CAPTURE(delay, signal, r.code, r.err);
            // Before main() nobody catches it.
            CHECK((r.code == 130 || r.code == 0 || r.code == 128 + SIGINT || r.code == 128 + SIGTERM ||
                   r.code == 128 + SIGHUP));
            if (r.code == 130 && !r.err.empty()) CHECK(one_line(r.err));
            scene.recovers(false);
        }
}

TEST_CASE("an input that vanishes in the middle is named, and when it is back the bake goes on") {
    const Scene scene;
    const std::string input = scene.folder / "input";
    REQUIRE(scene.count("pread", "/input") >= 17);
    for (const int n : {3, 9, 17}) {
        const Run r = scene.run({"pread", "EIO", std::to_string(n) + "+", "/input"});
        CAPTURE(n, r.err);
        CHECK(r.code == 1);
        CHECK(one_line(r.err));
        CHECK(r.err.find("input: ") != std::string::npos);
        CHECK(r.err.find("the same command goes on from there") != std::string::npos);
        CHECK(scene.old());
        // Gone for a while: the work stays, however often it is tried.
        std::filesystem::rename(input, scene.folder / "elsewhere");
        for (int again = 0; again < 2; ++again) {
            const Run gone = scene.run();
            CHECK(gone.code == 1);
            CHECK(one_line(gone.err));
            CHECK(gone.err.find("input: ") != std::string::npos);
            CHECK(scene.old());
        }
        std::filesystem::rename(scene.folder / "elsewhere", input);
        const Run back = scene.run();
        CHECK(back.code == 0);
        CHECK(back.out == "resumed\n");
        CHECK(scene.is_whole());
        CHECK(scene.folder.names() == std::vector<std::string>{"input", "out.fjell"});
        scene.age();
    }
}

TEST_CASE("a file-size limit, as of a disk that is full, is a write error") {
    const Scene scene;
    for (const int blocks : {0, 8, 60, 200}) { // of 512 bytes
        const Run r = run_in(scene.folder.path, "ulimit -f " + std::to_string(blocks) + "; " + scene.command);
        CAPTURE(blocks, r.err);
        CHECK(r.code == 3);
        CHECK((r.err.empty() || one_line(r.err))); // the limit is of the file that takes the message, too
        CHECK(scene.old());
        CHECK(scene.folder.names() == scene.names);
    }
}

TEST_CASE("of several bakes of one pack at once one works, and the others say so") {
    const Scene scene;
    std::string all;
    for (int i = 0; i < 6; ++i)
        all += "(sleep 0.0" + std::to_string(2 * i) + "; " + scene.command + "; echo code $?) & ";
    for (int round = 0; round < 2; ++round) {
        const Run r = run_in(scene.folder.path, all + "wait");
        CAPTURE(round, r.out, r.err);
        const auto times = [](const std::string& text, const std::string& what) {
            int n = 0;
            for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++n;
            return n;
        };
        CHECK(times(r.out, "code 0\n") >= 1);
        CHECK(times(r.out, "code 0\n") + times(r.out, "code 1\n") == 6);
        CHECK(times(r.err, "another bake is writing this pack") == times(r.out, "code 1\n"));
        CHECK(scene.is_whole());
        CHECK(scene.folder.names() == scene.names);
        scene.age();
    }
}

TEST_CASE("what a killed bake has left is kept while others are at work in it, and not taken for another bake's") {
    Scene scene;
    REQUIRE(scene.run({"all", "kill", std::to_string(scene.count("all") * 3 / 4)}).code == 128 + SIGKILL);
    const int lock = open((scene.folder / "out.fjell.work/lock").c_str(), O_RDWR);
    REQUIRE(flock(lock, LOCK_EX | LOCK_NB) == 0);
    const Run busy = scene.run();
    CHECK(busy.code == 1);
    CHECK(busy.err.find("another bake is writing this pack; wait for it") != std::string::npos);
    close(lock);
    SECTION("the same heights under the same name go on") {
        scene.recovers(true);
    }
    SECTION("other heights begin anew") {
        std::filesystem::rename(scene.folder / "input", scene.folder / "other");
        scene.names = {"other", "out.fjell"};
        scene.command.replace(scene.command.find(" input "), 7, " other ");
        const Run r = scene.run();
        CHECK(r.out == "new\n");
        CHECK(scene.is_whole());
        CHECK(scene.folder.names() == scene.names);
    }
    SECTION("a damaged ledger is none") {
        const std::string ledger = scene.folder / "out.fjell.work/ledger";
        std::string bytes = slurp(ledger);
        SECTION("cut") {
            bytes.pop_back();
        }
        SECTION("changed") {
            bytes[bytes.size() / 2] ^= 1;
        }
        SECTION("longer") {
            bytes += "x";
        }
        SECTION("empty") {
            bytes.clear();
        }
        spit(ledger, bytes);
        CHECK(scene.run().out == "new\n");
        CHECK(scene.is_whole());
        CHECK(scene.folder.names() == scene.names);
    }
}

TEST_CASE("a folder of that name that no bake has made is left alone") {
    const Scene scene;
    std::filesystem::create_directory(scene.folder / "out.fjell.work");
    spit(scene.folder / "out.fjell.work/thesis.txt", "years of work");
    const Run r = scene.run();
    CHECK(r.code == 1);
    CHECK(one_line(r.err));
    CHECK(r.err.find("move it away") != std::string::npos);
    CHECK(slurp(scene.folder / "out.fjell.work/thesis.txt") == "years of work");
    CHECK(scene.old());
    std::filesystem::remove(scene.folder / "out.fjell.work/thesis.txt"); // an empty one is nobody's
    scene.recovers(false);
}

TEST_CASE("a link to a pack on another disk is followed, by what is beside the pack too") {
    Scene scene;
    const TemporaryFolder far;
    spit(far / "pack", old_pack);
    std::filesystem::remove(scene.folder / "out.fjell");
    std::filesystem::create_symlink(far / "pack", scene.folder / "out.fjell");
    const Run r = scene.run({"all", "kill", "600", far.path.filename().string()});
    CHECK(r.code == 128 + SIGKILL);
    CHECK(far.names() == std::vector<std::string>{"pack", "pack.work"});
    scene.recovers(true);
    CHECK(far.names() == std::vector<std::string>{"pack"});
    CHECK(std::filesystem::is_symlink(scene.folder / "out.fjell"));
}

TEST_CASE("a folder that goes away during the bake is said") {
    const TemporaryFolder far;
    Scene scene;
    const std::string out = far / "f/out.fjell";
    std::filesystem::create_directory(far / "f");
    scene.command.replace(scene.command.find(" out.fjell "), 11, " " + out + " ");
    const Run r =
        run_in(scene.folder.path, "(sleep 0.05; mv '" + (far / "f") + "' '" + (far / "g") + "') & " + scene.command);
    CAPTURE(r.err);
    if (r.code == 0) return; // it was faster
    CHECK((r.code == 1 || r.code == 3));
    CHECK(one_line(r.err));
}

TEST_CASE("a ramp that is away for a while costs nothing") {
    const TemporaryFolder folder;
    const std::string bake =
        FJELL_BIN_DIR "/fjell-bake dem.tif -o out.fjell --tile 64 --threads 1 --quiet --checkpoint 0 --ramp ramp.json";
    spit(folder / "recipe.json", R"({"columns": 150, "rows": 100, "spacing_m": 60})");
    spit(folder / "ramp.json",
         R"({"stops": [{"height_m": 0, "rgb": [0, 90, 0]}, {"height_m": 900, "rgb": [250, 240, 250]}]})");
    REQUIRE(run_in(folder.path, FJELL_BIN_DIR "/fjell-bake synth recipe.json -o dem.tif").code == 0);
    REQUIRE(run_in(folder.path, bake).code == 0);
    const std::string whole = slurp(folder / "out.fjell");
    REQUIRE(run_in(folder.path, with({"fsync", "kill", "1"}, bake)).code == 128 + SIGKILL);
    std::filesystem::rename(folder / "ramp.json", folder / "elsewhere");
    CHECK(run_in(folder.path, bake).code == 1);
    CHECK(std::filesystem::exists(folder / "out.fjell.work/ledger"));
    std::filesystem::rename(folder / "elsewhere", folder / "ramp.json");
    CHECK(run_in(folder.path, bake).code == 0);
    CHECK((slurp(folder / "out.fjell") == whole));
    CHECK(!std::filesystem::exists(folder / "out.fjell.work"));
}

TEST_CASE("a height field that was exchanged for another of its size in the same second is read anew") {
    const TemporaryFolder folder;
    const std::string bake =
        FJELL_BIN_DIR "/fjell-bake dem.asc -o out.fjell --tile 32 --threads 1 --quiet --checkpoint 0";
    const auto field = [&](int factor, const char* second) {
        std::string text = "ncols 70\nnrows 70\nxllcorner 1000\nyllcorner 1000\ncellsize 30\n";
        for (int i = 0; i < 70 * 70; ++i) text += std::to_string(100 + i * factor % 97) + (i % 70 == 69 ? "\n" : " ");
        spit(folder / "dem.asc", text);
        REQUIRE(run_in(folder.path, "touch -d '2026-01-02 03:04:" + std::string(second) + "' dem.asc").code == 0);
    };
    field(7, "05.5");
    REQUIRE(run_in(folder.path, bake).code == 0);
    const std::string whole = slurp(folder / "out.fjell");
    field(5, "05.1");
    REQUIRE(run_in(folder.path, with({"fsync", "kill", "1"}, bake)).code == 128 + SIGKILL);
    field(7, "05.5");
    CHECK(run_in(folder.path, bake).code == 0);
    CHECK((slurp(folder / "out.fjell") == whole));
}

TEST_CASE("a height field that is made is there as a whole or not at all") {
    const TemporaryFolder folder, aside;
    const std::string synth = FJELL_BIN_DIR "/fjell-bake synth recipe.json -o out.tif";
    spit(folder / "recipe.json", R"({"columns": 600, "rows": 300, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, with({"all", "none", "1", "out.tif"}, synth, aside / "count")).code == 0);
    const std::string whole = slurp(folder / "out.tif");
    const auto names = folder.names();
    REQUIRE(names == std::vector<std::string>{"out.tif", "recipe.json"});
    spit(folder / "out.tif", old_pack);
    const auto fails = [&](const std::string& command) {
        const Run r = run_in(folder.path, command);
        CAPTURE(command, r.err);
        CHECK(r.code == 3);
        CHECK(one_line(r.err));
        CHECK((slurp(folder / "out.tif") == old_pack));
        CHECK(folder.names() == names);
    };
    for (const char* when : {"1", "1+", "2", "3", "5+", "7"}) fails(with({"fwrite", "ENOSPC", when, "out.tif"}, synth));
    fails(with({"fsync", "EIO", "1", "out.tif"}, synth));
    fails(with({"rename", "EACCES", "1", "out.tif"}, synth));
    for (const char* blocks : {"20", "200"})
        fails("ulimit -f " + std::string(blocks) + "; " + synth + " 2>&1 | cat >&2; exit 3");
    const long calls = std::strtol(slurp(aside / "count").c_str(), nullptr, 10);
    for (const long n : spread(calls, 6)) {
        const Run r = run_in(folder.path, with({"all", "kill", std::to_string(n), "out.tif"}, synth));
        CAPTURE(n, calls);
        CHECK((r.code == 0 || r.code == 128 + SIGKILL));
        if (r.code != 0) CHECK((slurp(folder / "out.tif") == old_pack || slurp(folder / "out.tif") == whole));
        CHECK(run_in(folder.path, synth).code == 0);
        CHECK((slurp(folder / "out.tif") == whole));
        CHECK(folder.names() == names);
        spit(folder / "out.tif", old_pack);
    }
}

TEST_CASE("the tool holds the same under faults") {
    const TemporaryFolder folder;
    const std::string bake =
        FJELL_BIN_DIR "/fjell-bake dem.tif -o out.fjell --tile 64 --threads 2 --quiet --checkpoint 0";
    spit(folder / "recipe.json", R"({"columns": 300, "rows": 300, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, FJELL_BIN_DIR "/fjell-bake synth recipe.json -o dem.tif").code == 0);
    REQUIRE(run_in(folder.path, bake).code == 0);
    const std::string whole = slurp(folder / "out.fjell");
    const auto names = folder.names();
    spit(folder / "out.fjell", old_pack);
    const auto fails = [&](const Fault& fault, int code, const std::string& says) {
        const Run r = run_in(folder.path, with(fault, bake));
        CAPTURE(fault.calls, fault.what, fault.when, r.err);
        CHECK(r.code == code);
        CHECK(one_line(r.err));
        CHECK(r.err.find(says) != std::string::npos);
        CHECK((slurp(folder / "out.fjell") == old_pack));
        CHECK(folder.names() == names);
    };
    fails({"pwrite", "ENOSPC", "1+"}, 3, "free some space");
    fails({"pwrite", "EIO", "500"}, 3, "check the disk");
    fails({"fsync", "EIO", "1"}, 3, "check the disk");
    fails({"rename", "EACCES", "1+"}, 3, "you may write to");
    fails({"fread,read,pread", "EIO", "3+", "/dem.tif"}, 1, "dem.tif");
    for (const char* what : {"short", "EINTR"}) {
        const Run r = run_in(folder.path, with({"pwrite,pread,write", what, "%2", "/out.fjell"}, bake));
        CAPTURE(what, r.err);
        CHECK(r.code == 0);
        CHECK((slurp(folder / "out.fjell") == whole));
        spit(folder / "out.fjell", old_pack);
    }
    for (const int n : {1, 40, 900, 2500}) {
        const Run r = run_in(folder.path, with({"all", "kill", std::to_string(n)}, bake));
        CAPTURE(n, r.err);
        CHECK(r.code == 128 + SIGKILL);
        CHECK((slurp(folder / "out.fjell") == old_pack));
        CHECK(run_in(folder.path, bake).code == 0);
        CHECK((slurp(folder / "out.fjell") == whole));
        CHECK(folder.names() == names);
        spit(folder / "out.fjell", old_pack);
    }
    SECTION("in memory, too, where only the pack is written") {
        const std::string fast = FJELL_BIN_DIR "/fjell-bake dem.tif -o out.fjell --tile 64 --threads 2 --quiet";
        for (const char* when : {"1", "2+", "3"}) {
            const Run r = run_in(folder.path, with({"pwrite", "ENOSPC", when}, fast));
            CAPTURE(when, r.err);
            CHECK(r.code == 3);
            CHECK(one_line(r.err));
            CHECK((slurp(folder / "out.fjell") == old_pack));
            CHECK(folder.names() == names);
        }
        for (const int n : {1, 2, 4, 6, 8}) {
            const Run r = run_in(folder.path, with({"all", "kill", std::to_string(n)}, fast));
            CAPTURE(n, r.err);
            CHECK(r.code == 128 + SIGKILL);
            CHECK((slurp(folder / "out.fjell") == old_pack));
            CHECK(run_in(folder.path, fast).code == 0);
            CHECK((slurp(folder / "out.fjell") == whole));
            CHECK(folder.names() == names);
            spit(folder / "out.fjell", old_pack);
        }
    }
}
