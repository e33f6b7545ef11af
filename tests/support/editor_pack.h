// The small terrain that the editor's tests open.
#pragma once

#include <string>

#include <catch2/catch.hpp>

#include "support/program.h"
#include "support/temporary_folder.h"

namespace fjell::test {

// A pack of content/terrain/mountains-small.json, baked once a process: 513 x 513 samples, tiles of 64 cells.
inline const std::string& small_pack() {
    static const TemporaryFolder folder;
    static const std::string pack = [] {
        const Run r =
            run_in(folder.path, FJELL_BIN_DIR "/fjell-bake " FJELL_SOURCE_DIR
                                              "/content/terrain/mountains-small.json -o small.fjell --tile 64");
        INFO(r.err);
        REQUIRE(r.code == 0);
        return folder / "small.fjell";
    }();
    return pack;
}

} // namespace fjell::test
