// What the tests of fjell-bake's command line have in common.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <string>

#include "support/program.h"
#include "support/temporary_folder.h"

namespace fjell::test {

inline const std::string bake = FJELL_BIN_DIR "/fjell-bake ";

// The command fails with this code and one line that says this, and leaves the folder as it was.
inline void refused(const TemporaryFolder& folder, const std::string& command, int code, const std::string& says) {
    const auto before = folder.names();
    const Run r = run_in(folder.path, command);
    CAPTURE(command, r.err);
    CHECK(r.code == code);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.rfind("fjell-bake: ", 0) == 0);
    CHECK(r.err.find(says) != std::string::npos);
    CHECK(folder.names() == before);
}

inline std::string output_of(const TemporaryFolder& folder, const std::string& command) {
    const Run r = run_in(folder.path, command);
    CAPTURE(command, r.out, r.err);
    REQUIRE(r.code == 0);
    return r.out;
}

// Writes the samples of pack.fjell as GDAL places them to points.txt: "longitude latitude height".
inline void write_points(const TemporaryFolder& folder, const std::string& crs) {
    output_of(folder, bake +
                          "heights pack.fjell -o back.tif && gdal_translate -q -of XYZ back.tif back.xyz && "
                          "grep -vi nan back.xyz >ground.xyz && cut -d' ' -f1,2 ground.xyz | gdaltransform -output_xy "
                          "-s_srs " +
                          crs +
                          " -t_srs EPSG:4326 >places && cut -d' ' -f3 ground.xyz >heights && "
                          "paste -d' ' places heights >points.txt");
}

[[nodiscard]] inline std::string ascii_grid(int columns, int rows, const std::string& value,
                                            const std::string& header = "") {
    std::string text = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) +
                       "\nxllcorner 1000\nyllcorner 1000\ncellsize 30\n" + header;
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) text += value + " ";
        text += "\n";
    }
    return text;
}

} // namespace fjell::test
