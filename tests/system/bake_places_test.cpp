// Bakes in unfriendly surroundings: several at once, folders and inputs that come, go and change, and the tool itself.
#include "bake_faults.h"

using namespace fjell::test;

TEST_CASE("of several bakes of one pack at once one works, and the others say so") {
    const Scene scene;
    std::string all;
    for (int i = 0; i < 6; ++i)
        all += "(sleep 0.0" + std::to_string(2 * i) + "; " + scene.command + "; echo code $?) & ";
    for (int round = 0; round < rounds(1, 2); ++round) {
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
    SECTION("a damaged checkpoint is none") {
        const std::string work = scene.folder / "out.fjell.work", checkpoint = work + "/checkpoint";
        const TemporaryFolder aside;
        std::filesystem::copy(work, aside / "left", std::filesystem::copy_options::recursive);
        const std::string bytes = slurp(checkpoint);
        std::string changed = bytes;
        changed[bytes.size() / 2] ^= 1;
        for (const std::string& damaged : {bytes.substr(0, bytes.size() - 1), changed, bytes + "x", std::string()}) {
            CAPTURE(bytes.size(), damaged.size());
            std::filesystem::remove_all(work);
            std::filesystem::copy(aside / "left", work, std::filesystem::copy_options::recursive);
            spit(checkpoint, damaged);
            CHECK(scene.run().out == "new\n");
            CHECK(scene.is_whole());
            CHECK(scene.folder.names() == scene.names);
            scene.age();
        }
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
    scene.recovers();
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
    const Run r = run_in(scene.folder.path, "(for i in $(seq 3000); do [ -e '" + out +
                                                ".work' ] && break; sleep 0.002; done; mv '" + (far / "f") + "' '" +
                                                (far / "g") + "') & " + scene.command);
    CAPTURE(r.err);
    if (r.code == 0) {
        WARN("skipped: the bake ended before its folder went away");
        return;
    }
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
    CHECK(std::filesystem::exists(folder / "out.fjell.work/checkpoint"));
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
    // Plain land, made fast: it is made two dozen times.
    spit(folder / "recipe.json",
         R"({"columns": 600, "rows": 300, "spacing_m": 60, "gullies": 0, "octaves": 1, "warp": 0})");
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
    for (const char* when : first_of(2, {"1", "5+", "1+", "2", "3", "7"}))
        fails(with({"fwrite", "ENOSPC", when, "out.tif"}, synth));
    fails(with({"fsync", "EIO", "1", "out.tif"}, synth));
    fails(with({"rename", "EACCES", "1", "out.tif"}, synth));
    for (const char* blocks : first_of(1, {"200", "20"})) fails("ulimit -f " + std::string(blocks) + "; " + synth);
    const long calls = std::strtol(slurp(aside / "count").c_str(), nullptr, 10);
    for (const long n : spread(calls, rounds(2, 6))) {
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
    for (const int n : first_of(1, {900, 1, 40, 2500})) {
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
        for (const char* when : first_of(1, {"2+", "1", "3"})) {
            const Run r = run_in(folder.path, with({"pwrite", "ENOSPC", when}, fast));
            CAPTURE(when, r.err);
            CHECK(r.code == 3);
            CHECK(one_line(r.err));
            CHECK((slurp(folder / "out.fjell") == old_pack));
            CHECK(folder.names() == names);
        }
        for (const int n : first_of(1, {4, 1, 2, 6, 8})) {
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
