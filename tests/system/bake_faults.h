// Bakes to be disturbed: faults are injected by support/fault_interposer.cpp at counted calls, so nothing here depends
// on time. Most run bake_child, which keeps its work in files; some the tool itself.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

namespace fjell::test {

inline constexpr int columns = 200, rows = 170; // 4 x 3 tiles of 64 cells, the last ones beyond the rim

inline const std::string old_pack = "an old pack, to be replaced by a whole one or not at all";

struct Fault {
    std::string calls, what, when, on = "out.fjell";
};

inline std::string with(const Fault& f, const std::string& command, const std::string& count_file = "") {
    return "ASAN_OPTIONS=$ASAN_OPTIONS:verify_asan_link_order=0 LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT='" + f.calls +
           " " + f.on + " " + f.what + " " + f.when + "' FJELL_FAULT_COUNT='" + count_file + "' " + command;
}

inline std::string heights(bool holes) {
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
    void recovers(std::optional<bool> resumes = {}) const {
        REQUIRE((old() || is_whole()));
        const Run r = run();
        INFO(r.err);
        REQUIRE(r.code == 0);
        if (resumes) CHECK(r.out == (*resumes ? "resumed\n" : "new\n"));
        CHECK(is_whole());
        CHECK(folder.names() == names);
        age();
    }

    TemporaryFolder folder;
    std::string command, whole;
    std::vector<std::string> names;
};

inline bool one_line(const std::string& text) {
    return !text.empty() && std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

// The first, the last, and some between.
inline std::vector<long> spread(long count, int most) {
    std::vector<long> all;
    for (int i = 0; i < most; ++i) {
        const long n = 1 + (count - 1) * i / std::max(most - 1, 1);
        if (all.empty() || all.back() != n) all.push_back(n);
    }
    return all;
}

inline constexpr unsigned seed = 20;

} // namespace fjell::test
