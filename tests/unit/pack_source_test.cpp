// A pack's heights, read back as a source.
#include "baker/bake/bake.h"
#include "baker/read/pack_source.h"
#include "baker/synth/write_dem.h"
#include "io/file.h"
#include "shared/terrain_data.h"
#include "source_check.h"
#include "support/dem.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

TEST_CASE("a pack read back in any windows has the heights and holes that the runtime stands on") {
    Random random(21);
    for (int round = 0; round < 12; ++round) {
        const int log2 = pick(random, 2, 7);
        Dem dem = random_dem(random, pick(random, 2, 200), pick(random, 2, 200),
                             static_cast<Shape>(round % static_cast<int>(Shape::count)));
        if (round % 2) add_random_holes(random, dem, log2);
        BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        const TemporaryFolder folder;
        (void)bake(dem, options, folder / "pack.fjell");
        const auto pack = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
        const PackSource source(folder / "pack.fjell");
        CAPTURE(round, log2, dem.columns, dem.rows);
        check_windows(source);
        const Field whole = read_whole(source);
        int wrong = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                const float height = whole.heights_m[dem.index(x, y)];
                const bool hole = std::isnan(height);
                wrong += hole != dem.is_void(x, y) || (!hole && height != data_of(pack.terrain).height_m({x, y}));
            }
        REQUIRE(wrong == 0);
        REQUIRE(whole.statistics.voids.count == void_count(dem));
        REQUIRE(source.properties(whole.statistics).holes == (void_count(dem) > 0));
    }
}

TEST_CASE("a pack is where its height field was, and its heights as a GeoTIFF are the same field") {
    const TempDir dir;
    Raster r = slope_with(-9999);
    tag(r, -9999);
    r.geotransform = {499990, 20, 0, 5000010, 0, -20};
    r.crs = "EPSG:32632";
    const std::string path = write(r, dir / "a.tif");
    const auto from = open_source({path}, {});
    const std::string pack = dir / "a.fjell", back = dir / "back.tif";
    (void)bake(*from, small_bake(4), pack);
    const PackSource source(pack);
    CHECK(source.crs_wkt == from->crs_wkt);
    for (const int axis : {0, 1}) {
        CHECK(source.crs_origin[axis] == from->crs_origin[axis]);
        CHECK(source.spacing_m[axis] == from->spacing_m[axis]);
        CHECK(source.crs_step[axis] == from->crs_step[axis]);
    }
    write_dem(source, back, DemForm::plain);
    const Dem dem = read_dem(path, {}), again = read_dem(back, {});
    CHECK(again.voids == dem.voids);
    CHECK(again.heights_m == dem.heights_m);
    CHECK(again.crs_origin[0] == dem.crs_origin[0]);
    CHECK(again.crs_origin[1] == dem.crs_origin[1]);
    CHECK(again.crs_step[0] == 20);
    CHECK(again.crs_wkt.find("32632") != std::string::npos);
    // Baked again it is the same pack but for what stands under its holes.
    CHECK(again.native_quantum_m == dem.native_quantum_m);
}

TEST_CASE("a pack that is damaged is refused when it is read back, one that is missing at once") {
    const TempDir dir;
    Random random(22);
    const std::string pack = dir / "a.fjell";
    (void)bake(random_dem(random, 200, 100, Shape::fractal), small_bake(6), pack);
    std::vector<std::byte> bytes = io::read_file(pack);
    for (std::size_t at = 1000; at < 1400; ++at) bytes[at] ^= std::byte{0xff};
    {
        io::AtomicFile damaged(pack);
        damaged.write(bytes);
        damaged.commit();
    }
    const PackSource source(pack);
    check_refusal(refusal([&] { (void)read_whole(source); }), 1, pack, {"tile", "bake it again"});
    const std::string missing = dir / "b.fjell";
    check_refusal(refusal([&] { PackSource s(missing); }), 1, missing, {"give an existing file"});
    check_refusal(refusal([&] { PackSource s(dir / "."); }), 1, dir / ".", {"is a folder", "fjell-bake split"});
}
