// Bakes that are killed, starved, interrupted and misled: nothing is lost, what is said is clear, and the same command
// comes to the same bytes.
#include "bake_faults.h"

#include "baker/store/store.h"
#include "support/rounds.h"

using namespace fjell::test;

TEST_CASE("a disk that fails at any call is one line and exit code 3, and leaves the old pack and nothing else") {
    const Scene scene(true, 1); // one thread makes the same calls every time
    const struct {
        const char *call, *error, *remedy;
        int samples;
    } kinds[] = {{"pwrite", "EIO", "check the disk", 4},        {"pwrite", "ENOSPC", "free some space", 4},
                 {"pread", "EIO", "check the disk", 4},         {"ftruncate", "ENOSPC", "free some space", 2},
                 {"fallocate", "ENOSPC", "free some space", 3}, {"open", "EACCES", "you may write to", 3},
                 {"open", "EIO", "check the disk", 2},          {"rename", "EIO", "check the disk", 4},
                 {"fsync", "EIO", "check the disk", 2},         {"close", "EIO", "check the disk", 8}};
    for (const auto& kind : kinds) {
        const long calls = scene.count(kind.call);
        int noticed = 0;
        // In brief rounds the last one; of opening and closing, which are not always missed, more.
        const bool missed = std::string(kind.call) != "open" && std::string(kind.call) != "close";
        const int samples = rounds(missed ? 1 : std::min(kind.samples, 3), kind.samples);
        for (const long n : samples == 1 ? std::vector<long>{calls} : spread(calls, samples))
            for (const char* after : {"", "+"}) {
                // A disk that stays full.
                if (*after && n != 1 && n != calls) continue;
                if (*after && missed && !full_rounds() && std::string(kind.error) != "ENOSPC") continue;
                const Fault fault{kind.call, kind.error, std::to_string(n) + after};
                const Run r = scene.run(fault);
                CAPTURE(kind.call, kind.error, n, calls, after, r.err);
                // Some calls are only tried: what is taken away is not missed, and a folder need not be listed. And of
                // work that is read back or thrown away nobody asks how its file was closed.
                if (r.code == 0 && (std::string(kind.call) == "open" || std::string(kind.call) == "close")) {
                    CHECK(scene.is_whole());
                    scene.age();
                    continue;
                }
                ++noticed;
                CHECK(r.code == 3);
                CHECK(one_line(r.err));
                CHECK(r.err.find("out.fjell") != std::string::npos);
                CHECK(r.err.find(kind.remedy) != std::string::npos);
                CHECK(scene.old());
                CHECK(scene.folder.names() == scene.names);
            }
        CAPTURE(kind.call, kind.error, calls);
        CHECK(noticed > 0);
    }
    scene.recovers();
}

TEST_CASE("without GDAL a file of heights is refused in one line, and what reads none goes on") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n7 8 9\n");
    const std::string bake = FJELL_BIN_DIR "/fjell-bake ";
    REQUIRE(run_in(folder.path, bake + "dem.asc --spacing 1 -o out.fjell --quiet").code == 0);
    const Fault gone{"dlopen", "ENOENT", "1+", "libgdal"};
    const Run r = run_in(folder.path, with(gone, bake + "dem.asc --spacing 1 -o other.fjell"));
    CHECK(r.code == 3);
    CHECK(one_line(r.err));
    CHECK(r.err.find("GDAL cannot be loaded") != std::string::npos);
    for (const char* command : {"info out.fjell", "verify out.fjell", "--help"}) {
        INFO(command);
        CHECK(run_in(folder.path, with(gone, bake + command)).code == 0);
    }
}

TEST_CASE("short and interrupted calls change no byte") {
    const Scene scene;
    for (const char* what : {"short", "EINTR"})
        for (const char* when : first_of(2, {"%2", "%7", "%3"})) {
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

TEST_CASE("a bake that is killed at any moment goes on to the same bytes") {
    for (const bool holes : {true, false}) {
        const Scene scene(holes);
        const long calls = scene.count("all");
        std::mt19937 random(seed + holes);
        for (int i = 0; i < rounds(2, 15); ++i) {
            const long n = std::uniform_int_distribution<long>(1, calls)(random);
            const Run r = scene.run({"all", "kill", std::to_string(n)});
            CAPTURE(holes, seed, i, n, calls, r.err);
            // Two threads do not always make the same number of calls.
            if (r.code == 0 && n > calls * 9 / 10) {
                scene.age();
                continue;
            }
            REQUIRE(r.code == 128 + SIGKILL);
            scene.recovers();
        }
    }
}

TEST_CASE("a bake that is killed again and again gets there") {
    const Scene scene;
    const long calls = scene.count("all");
    std::mt19937 random(seed);
    for (int round = 0; round < rounds(1, 2); ++round) {
        int kills = 0, resumed = 0;
        for (Run r; kills < 200;) {
            // After a while far enough for the longest stage, or there would be no end to it.
            const long n = std::uniform_int_distribution<long>(200, kills < 4 ? calls / 4 : calls * 3 / 4)(random);
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
    for (const long n : spread(calls, rounds(3, 8))) {
        scene.command = Scene::child(n % 2 ? 2 : 1);
        const Run r = scene.run({"all", "kill", std::to_string(n)});
        scene.command = Scene::child(n % 2 ? 1 : 3);
        CAPTURE(n, calls, r.err);
        scene.recovers();
    }
}

namespace {

// What can become of a file, or of two, while nobody looks.
constexpr int damages = 6;
void damage(const std::string& file, const std::string& other, int how, std::mt19937& random) {
    std::string bytes = slurp(file);
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    switch (how) {
    case 0: std::filesystem::remove(file); return;
    case 1: bytes.resize(bytes.size() / 2); break;
    case 2: std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), '\0'); break;
    case 3: bytes += std::string(64, 'x'); break;
    case 4:
        if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
        break;
    default:
        spit(file, slurp(other));
        spit(other, bytes);
        return;
    }
    spit(file, bytes);
}

} // namespace

TEST_CASE("whatever becomes of its work folder, an interrupted bake comes to the same pack") {
    std::mt19937 random(seed);
    const Scene scene(true, 1);
    const std::string work = scene.folder / "out.fjell.work";
    const long stages = scene.count("rename", "work/checkpoint");
    const TemporaryFolder aside;
    const auto copy = [](const std::string& from, const std::string& to) {
        std::filesystem::remove_all(to);
        std::filesystem::copy(from, to, std::filesystem::copy_options::recursive);
    };
    int anew = 0, resumed = 0;
    std::map<std::string, int> met; // damages of each file
    for (const long stage : spread(stages, rounds<int>(4, static_cast<int>(stages)))) {
        if (stage == 1) continue; // nothing to go on from
        // When a stage is done, but not yet noted; or in the middle of the next one.
        REQUIRE(scene.run({"rename", "kill", std::to_string(stage), "work/checkpoint"}).code == 128 + SIGKILL);
        if (stage % 2 != 0 && scene.run({"pwrite", "kill", "60", "out.fjell.work"}).code == 0) {
            scene.age();
            continue;
        }
        copy(work, aside / "left");
        std::vector<std::string> files;
        for (const auto& entry : std::filesystem::directory_iterator(aside / "left"))
            if (entry.path().filename() != "lock") files.push_back(entry.path().filename().string());
        std::sort(files.begin(), files.end());
        scene.recovers(true);
        // Every damage of each file once it is there, then every file once a stage: all of both is twelve minutes.
        for (std::size_t i = 0; i < files.size();) {
            const std::string& file = files[i];
            const int how = met[file]++ % damages;
            if (met[file] >= damages) ++i;
            if (!full_rounds() && random() % 8 != 0) continue;
            copy(aside / "left", work);
            damage(work + "/" + file, work + "/" + files[random() % files.size()], how, random);
            const Run r = scene.run();
            CAPTURE(stage, stages, file, how, r.out, r.err);
            CHECK(r.code == 0);
            CHECK(scene.is_whole());
            CHECK(scene.folder.names() == scene.names);
            ++(r.out == "resumed\n" ? resumed : anew);
            scene.age();
        }
    }
    CHECK(anew > 0);
    CHECK(resumed > 0); // what no further stage reads does not matter
}

TEST_CASE("digests of a file's pieces add up, however it was cut, and change with every bit and place") {
    std::mt19937 random(seed);
    std::vector<std::byte> bytes(5000);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random() % 256);
    const std::span<const std::byte> all(bytes);
    constexpr std::uint64_t far = std::uint64_t{1} << 40;
    for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{3}, far}) {
        fjell::baker::Digest sum;
        for (std::size_t at = 0; at < bytes.size();) {
            const std::size_t count = std::min<std::size_t>(random() % 700, bytes.size() - at);
            sum += fjell::baker::digest_of(offset + at, all.subspan(at, count));
            at += count;
        }
        const fjell::baker::Digest whole = fjell::baker::digest_of(offset, all);
        CHECK(sum == whole);
        CHECK(!(whole == fjell::baker::digest_of(offset + 1, all)));
        CHECK(!(whole == fjell::baker::digest_of(offset + 8, all)));
        int unseen = 0;
        for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 7) {
            bytes[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
            unseen += whole == fjell::baker::digest_of(offset, all);
            bytes[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
        }
        CHECK(unseen == 0);
    }
}

TEST_CASE("Ctrl-C at any call is exit code 130 and says how to go on") {
    const Scene scene;
    int anew = 0, resumed = 0;
    const long calls = scene.count("pwrite");
    for (const long n : spread(calls, rounds(4, 8))) {
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
        CHECK(scene.old());
        const bool kept = scene.folder.names() != scene.names;
        // Before the first stage is complete there is nothing to go on from.
        if (!kept) CHECK(r.err.find("nothing is left behind") != std::string::npos);
        if (kept) CHECK(r.err.find("the same command goes on from there") != std::string::npos);
        if (kept) CHECK(r.err.find("out.fjell.work") != std::string::npos);
        ++(kept ? resumed : anew);
        scene.recovers(kept);
    }
    CHECK(anew > 0);
    CHECK(resumed > rounds(1, 3));
}

TEST_CASE("signals from outside, at any time, are an interruption or come too late") {
    const Scene scene;
    for (const char* delay : first_of(1, {"0.03", "0", "0.08"}))
        for (const char* signal : {"INT", "TERM", "HUP"}) {
            // Shells ignore SIGINT for what they start in the background; env takes it back.
            const Run r = run_in(scene.folder.path, "env --default-signal=INT " + scene.command + " & p=$!; sleep " +
                                                        delay + "; kill -" + signal + " $p; wait $p");
            CAPTURE(delay, signal, r.code, r.err);
            // Before main() nobody catches it.
            CHECK((r.code == 130 || r.code == 0 || r.code == 128 + SIGINT || r.code == 128 + SIGTERM ||
                   r.code == 128 + SIGHUP));
            if (r.code == 130 && !r.err.empty()) CHECK(one_line(r.err));
            scene.recovers();
        }
}

TEST_CASE("heights that vanish while they are read are named, and nothing is left") {
    const Scene scene;
    REQUIRE(scene.count("pread", "/input") >= 17);
    for (const int n : {3, 9, 17}) {
        const Run r = scene.run({"pread", "EIO", std::to_string(n) + "+", "/input"});
        CAPTURE(n, r.err);
        CHECK(r.code == 1);
        CHECK(one_line(r.err));
        CHECK(r.err.find("input: ") != std::string::npos);
        CHECK(scene.old());
        CHECK(scene.folder.names() == scene.names);
        scene.recovers(false);
    }
}

TEST_CASE("an input that vanishes in the middle is named, and when it is back the bake goes on") {
    Scene scene(true, 1); // one thread makes the same calls every time
    const std::string image = scene.folder / "image.ppm";
    std::string pixels = "P6\n64 64\n255\n";
    for (int i = 0; i < 64 * 64 * 3; ++i) pixels += static_cast<char>(i % 251);
    spit(image, pixels);
    scene.command += " image.ppm";
    scene.names = {"image.ppm", "input", "out.fjell"};
    REQUIRE(scene.run().code == 0);
    scene.whole = slurp(scene.folder / "out.fjell");
    const char* const calls = "pread,read,fread";
    // It is open by then, and its pixels are wanted.
    const long n = scene.count(calls, "/image.ppm") * 3 / 4;
    const Run r = scene.run({calls, "EIO", std::to_string(n) + "+", "/image.ppm"});
    CAPTURE(n, r.err);
    CHECK(r.code == 1);
    CHECK(one_line(r.err));
    CHECK(r.err.find("image.ppm") != std::string::npos);
    CHECK(r.err.find("the same command goes on from there") != std::string::npos);
    CHECK(scene.old());
    // Gone for a while: the work stays, however often it is tried.
    std::filesystem::rename(image, scene.folder / "elsewhere");
    for (int again = 0; again < 2; ++again) {
        const Run gone = scene.run();
        CHECK(gone.code == 1);
        CHECK(one_line(gone.err));
        CHECK(gone.err.find("image.ppm") != std::string::npos);
        CHECK(scene.old());
    }
    std::filesystem::rename(scene.folder / "elsewhere", image);
    scene.recovers(true);
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
