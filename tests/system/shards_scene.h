// A plan of shards for the program, and the pack that one bake makes of the same.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <string>

#include "bake_cli.h"
#include "support/program.h"

namespace fjell::test {

// A recipe of mountains, whole.fjell, and a plan of it. more: options of the bake.
inline void prepare_shards(const TemporaryFolder& folder, int shards, const std::string& more = "") {
    const std::string options = " --tile 64 " + more;
    spit(folder / "land.json", R"({"columns": 600, "rows": 420})");
    REQUIRE(run_in(folder.path, bake + "land.json -o whole.fjell --threads 1" + options).code == 0);
    REQUIRE(run_in(folder.path,
                   bake + "plan land.json -o plan --shards " + std::to_string(shards) + options + " && mkdir far")
                .code == 0);
}

[[nodiscard]] inline bool same_pack(const TemporaryFolder& folder, const std::string& pack) {
    return slurp(folder / pack) == slurp(folder / "whole.fjell");
}

// A command that fails leaves one line that says so.
inline void fails(const TemporaryFolder& folder, const std::string& command, int code, const std::string& says) {
    const Run r = run_in(folder.path, command);
    CAPTURE(command, r.err);
    CHECK(r.code == code);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.find(says) != std::string::npos);
}

} // namespace fjell::test
