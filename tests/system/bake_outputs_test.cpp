// What fjell-bake writes over and what it does not, and files that are none: pipes, links, full disks, interruptions.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "bake_cli.h"
#include "support/program.h"
#include "support/real_data.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell::test;

TEST_CASE("an output that cannot be written is refused with the right exit code, and an old pack survives") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(65, 65, "5"));
    refused(folder, bake + "dem.asc -o missing/out.fjell", 1, "folder does not exist");
    refused(folder, bake + "dem.asc -o .", 1, "folder");
    refused(folder, bake + "dem.asc -o /dev/full", 3, "space");
    refused(folder, bake + "dem.asc -o out.fjell --json missing/x.json", 1, "folder does not exist");
    REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell").code == 0);
    const std::string before = slurp(folder / "out.fjell");
    refused(folder, "ulimit -f 1; " + bake + "dem.asc -o out.fjell --texture dem.asc", 1, "");
    refused(folder, "ulimit -f 1; " + bake + "dem.asc -o out.fjell", 3, "");
    CHECK(slurp(folder / "out.fjell") == before);
}

TEST_CASE("an output never overwrites an input or another output, and a link is followed") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    spit(folder / "recipe.json", R"({"columns": 9, "rows": 9})");
    refused(folder, bake + "dem.asc -o ./dem.asc", 2, "overwrite");
    refused(folder, bake + "dem.asc -o out.fjell --json ../" + folder.path.filename().string() + "/out.fjell", 2,
            "overwrite");
    refused(folder, bake + "synth recipe.json -o recipe.json", 2, "overwrite");
    spit(folder / "taken.json", R"({"columns": 9, "rows": 9})");
    std::filesystem::create_hard_link(folder / "dem.asc", folder / "same.fjell");
    refused(folder, bake + "dem.asc -o same.fjell", 2, "overwrite the input dem.asc");
    refused(folder, bake + "recipe.json -o out.fjell --json out.fjell.work/x.json", 2, "overwrite the output");
    spit(folder / "ramp.json", R"({"stops": [{"height_m": 0, "rgb": [0, 0, 0]}, {"height_m": 9, "rgb": [9, 9, 9]}]})");
    refused(folder, bake + "dem.asc -o out.fjell --ramp ramp.json --save-recipe ./ramp.json", 2, "overwrite");
    refused(folder, bake + "synth recipe.json -o mountains.png", 2, ".tif");
    refused(folder, bake + "dem.asc -o out.fjell info out.fjell", 2, "bake nothing");
    std::filesystem::create_symlink("real.fjell", folder.path / "link.fjell");
    REQUIRE(run_in(folder.path, bake + "dem.asc -o link.fjell").code == 0);
    CHECK(std::filesystem::is_symlink(folder.path / "link.fjell"));
    CHECK(run_in(folder.path, bake + "info real.fjell").code == 0);
}

namespace {

std::string vrt_of(const std::string& source) {
    return "<VRTDataset rasterXSize=\"17\" rasterYSize=\"17\"><GeoTransform>1000,30,0,1510,0,-30</GeoTransform>"
           "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename relativeToVRT=\"1\">" +
           source + "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>";
}

} // namespace

TEST_CASE("an output overwrites none of the files that a source consists of: behind mosaics, beside rasters") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    spit(folder / "dem.prj", "PROJCS[\"p\",GEOGCS[\"g\",DATUM[\"d\",SPHEROID[\"s\",6378137,298]],PRIMEM[\"G\",0],"
                             "UNIT[\"d\",0.0174532925199433]],PROJECTION[\"Mercator_1SP\"],UNIT[\"m\",1]]");
    std::filesystem::create_directory(folder / "in");
    spit(folder / "in/inner.vrt", vrt_of("../dem.asc"));
    spit(folder / "outer.vrt", vrt_of("in/inner.vrt"));
    spit(folder / "image.vrt", vrt_of("in/pixels.ppm"));
    spit(folder / "in/pixels.ppm", "P6\n17 17\n255\n" + std::string(3 * 17 * 17, 'x'));
    std::filesystem::create_symlink("dem.asc", folder / "link.fjell");
    std::filesystem::create_hard_link(folder / "in/pixels.ppm", folder / "hard.fjell");
    for (const std::string out : {"dem.asc", "in/inner.vrt", "outer.vrt", "link.fjell", "dem.prj"})
        refused(folder, bake + "outer.vrt -o " + out, 2, "overwrite the input");
    refused(folder, bake + "outer.vrt -o out.fjell --json dem.asc", 2, "overwrite the input");
    refused(folder, bake + "dem.asc -o dem.prj", 2, "overwrite the input");
    refused(folder, bake + "dem.asc --texture image.vrt -o hard.fjell", 2, "overwrite the input");
    const std::string dem = slurp(folder / "dem.asc");
    CHECK(dem == ascii_grid(17, 17, "5"));
    CHECK(run_in(folder.path, bake + "outer.vrt -o out.fjell").code == 0);
}

TEST_CASE("pipes behind other files, which would never end, are refused like those in front") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    spit(folder / "outer.vrt", vrt_of("inner.vrt"));
    spit(folder / "inner.vrt", vrt_of("pipe"));
    REQUIRE(run_in(folder.path, "mkfifo pipe").code == 0);
    const std::string soon = "timeout -s KILL 60 " + bake;
    refused(folder, soon + "inner.vrt -o out.fjell", 1, "pipe: not a regular file, which inner.vrt needs");
    refused(folder, soon + "outer.vrt -o out.fjell", 1, "pipe: not a regular file");
    refused(folder, soon + "dem.asc --texture inner.vrt -o out.fjell", 1, "pipe: not a regular file");
    refused(folder, soon + "/vsigzip/pipe -o out.fjell", 1, "pipe: not a regular file");
    for (const std::string option : {"--texture pipe", "--ramp pipe", "--recipe pipe"})
        refused(folder, soon + "dem.asc -o out.fjell " + option, 1, "regular file");
    refused(folder, soon + "verify pipe", 1, "regular file");
    refused(folder, soon + "heights pipe -o x.tif", 1, "regular file");
}

TEST_CASE("a pack far larger than memory is read where it is looked at") {
    const TemporaryFolder folder;
    spit(folder / "recipe.json", R"({"columns": 200, "rows": 130, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, bake + "recipe.json -o big.fjell --tile 64").code == 0);
    // The same, its directory behind a hundred gigabytes of nothing.
    std::string bytes = slurp(folder / "big.fjell");
    fjell::PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    const std::string directory = bytes.substr(h.directory_offset, h.directory_count * sizeof(fjell::ChunkEntry));
    h.directory_offset = std::uint64_t{100} << 30;
    h.file_bytes = h.directory_offset + directory.size();
    h.header_hash = XXH3_64bits(&h, offsetof(fjell::PackHeader, header_hash));
    {
        std::fstream file(folder / "big.fjell", std::ios::in | std::ios::out | std::ios::binary);
        file.write(reinterpret_cast<const char*>(&h), sizeof h);
        file.seekp(static_cast<std::streamoff>(h.directory_offset));
        file.write(directory.data(), static_cast<std::streamsize>(directory.size()));
    }
    const Run info = run_in(folder.path, "ulimit -v 4000000; " + bake + "info big.fjell --json");
    CAPTURE(info.err);
    REQUIRE(info.code == 0);
    CHECK(nlohmann::json::parse(info.out)["file_bytes"] == h.file_bytes);
    CHECK(run_in(folder.path, bake + "verify big.fjell").code == 0);
    CHECK(run_in(folder.path, bake + "heights big.fjell -o back.tif").code == 0);
    const Run flown = run_in(folder.path, FJELL_BIN_DIR "/fjell-fly big.fjell --headless --frames 2 --stream on "
                                                        "--export 1:out.glb");
    CAPTURE(flown.err);
    CHECK(flown.code == 0);
}

TEST_CASE("pipes, a full standard output and too many threads do no harm") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    REQUIRE(run_in(folder.path, "mkfifo pipe; " + bake + "dem.asc -o out.fjell --threads 64").code == 0);
    refused(folder, bake + "info pipe", 1, "regular file");
    refused(folder, bake + "dem.asc -o pipe", 1, "pipe");
    refused(folder, bake + "synth pipe -o x.tif", 1, "regular file");
    const Run r = run_in(folder.path, "exec " + bake + "info out.fjell >/dev/full");
    CHECK(r.code == 3);
}

TEST_CASE("an interrupted bake or synth ends soon and leaves nothing") {
    const TemporaryFolder folder;
    spit(folder / "recipe.json", R"({"columns": 8193, "rows": 8193})");
    for (const char* number : first_of(1, {"TERM", "INT", "HUP"})) {
        const std::string in_the_middle =
            " & p=$!; " + until_caught(0x4003) + "sleep 0.2; kill -" + number + " $p; wait $p";
        const Run r = run_in(folder.path, bake + "synth recipe.json -o dem.tif" + in_the_middle);
        CAPTURE(number, r.err);
        CHECK(r.code == 130);
        CHECK(r.err.find("interrupted") != std::string::npos);
        CHECK(folder.names() == std::vector<std::string>{"recipe.json"});
    }
}
