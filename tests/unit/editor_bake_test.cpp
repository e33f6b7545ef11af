// What the dialog that bakes finds in files, proposes and asks.
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <string>

#include "baker/bake/inputs.h"
#include "baker/read/gdal_file.h"
#include "editor/command.h"
#include "editor/files/listing.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/work.h"
#include "fjell/io/failure.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell::editor;
using fjell::test::spit;
using fjell::test::TemporaryFolder;

namespace {

// A binary grey map: numbers without coordinates. 40 columns, slopes of 6 a column.
std::string grey_map(int rows) {
    std::string text = "P5\n40 " + std::to_string(rows) + "\n255\n";
    for (int i = 0; i < 40 * rows; ++i) text += static_cast<char>(10 + i % 40 * 6);
    return text;
}

std::string ascii_grid(int west, const char* number) {
    std::string text = "ncols 20\nnrows 10\nxllcorner " + std::to_string(west) + "\nyllcorner 0\ncellsize 10\n";
    for (int i = 0; i < 200; ++i) text += i == 25 ? std::string(number) + " " : std::to_string(100 + i % 20) + " ";
    return text + "\n";
}

HeightFacts facts_of(const BakePack& pack) {
    const std::atomic<bool> stop{false};
    return look_at_heights(pack, stop);
}

BakePack pack_of(std::vector<std::string> inputs) {
    BakePack pack;
    pack.inputs = std::move(inputs);
    return pack;
}

struct BakeDialog {
    State state;
    Engine engine;
    Jobs jobs;

    void run(const std::string& line) { apply(*parse_command(line), {state, engine, jobs}); }
};

} // namespace

TEST_CASE("heights without coordinates: the spacing is missing, and one is proposed from the name or from the slopes") {
    const TemporaryFolder folder;
    spit(folder / "hills_30m.png", grey_map(30));
    spit(folder / "hills.png", grey_map(30));
    const HeightFacts named = facts_of(pack_of({folder / "hills_30m.png"}));
    CHECK(named.known);
    CHECK(named.columns == 40);
    CHECK(named.rows == 30);
    CHECK(named.least_m == 10);
    CHECK(named.most_m == 10 + 39 * 6);
    CHECK(named.at == BakeField::spacing);
    CHECK(named.proposed == "30");
    CHECK(named.problem.find("--") == std::string::npos); // no option of another program
    CHECK(named.problem.starts_with("hills_30m.png: "));
    CHECK(named.texels.size() == 40 * 30);
    const HeightFacts sloped = facts_of(pack_of({folder / "hills.png"}));
    // 6 m from column to column, but 0 from row to row, which is not looked at.
    CHECK(std::stod(sloped.proposed) == Approx(6 / 0.18).margin(10));
    BakePack given = pack_of({folder / "hills.png"});
    given.spacing_m = 25;
    given.height_scale = 2;
    given.height_offset_m = 100;
    const HeightFacts right = facts_of(given);
    CHECK(right.problem.empty());
    CHECK(right.at == BakeField::none);
    CHECK(right.spacing_m[0] == 25);
    CHECK(right.least_m == 120);
}

TEST_CASE("numbers that look like voids, missing files and images that are none mark their fields") {
    const TemporaryFolder folder;
    spit(folder / "voids.asc", ascii_grid(0, "-9999"));
    spit(folder / "west.asc", ascii_grid(0, "101"));
    spit(folder / "east.asc", ascii_grid(200, "101"));
    spit(folder / "notes.txt", "no image");
    const HeightFacts voids = facts_of(pack_of({folder / "voids.asc"}));
    CHECK(voids.at == BakeField::voids);
    CHECK(voids.proposed == "-9999");
    CHECK(voids.problem.find("--") == std::string::npos);
    BakePack declared = pack_of({folder / "voids.asc"});
    declared.voids = "-9999";
    CHECK(facts_of(declared).problem.empty());
    CHECK(facts_of(declared).void_share == Approx(1.0 / 200));
    CHECK(facts_of(pack_of({folder / "none.tif"})).at == BakeField::heights);
    CHECK_FALSE(facts_of(pack_of({folder / "none.tif"})).known);
    BakePack mosaic = pack_of({folder / "west.asc", folder / "east.asc"});
    CHECK(facts_of(mosaic).columns == 40);
    mosaic.texture = folder / "notes.txt";
    CHECK(facts_of(mosaic).at == BakeField::texture);
    CHECK(facts_of(mosaic).known); // and the heights are still shown
    mosaic.texture = folder / "west.asc";
    const HeightFacts pictured = facts_of(mosaic);
    CHECK(pictured.image_px > 0);
    CHECK(pictured.texels.size() == std::size_t{pictured.width_px} * pictured.height_px);
    const std::atomic<bool> stop{true};
    CHECK_FALSE(look_at_heights(mosaic, stop).known);
}

TEST_CASE("rules are looked at before the bake: what they lay where, and a fault with its file, line and rule") {
    const TemporaryFolder folder;
    spit(folder / "west.asc", ascii_grid(0, "101")); // 100 to 119 m, rising by 1 m a column of 10 m
    spit(folder / "rules.json", R"({"rules": [
        {"layer": "grass"},
        {"layer": "snow", "height_m": [109.5, null], "ragged": 0},
        {"layer": "basalt", "slope_deg": [80, null], "ragged": 0}]})");
    BakePack pack = pack_of({folder / "west.asc"});
    const HeightFacts bare = facts_of(pack);
    CHECK(bare.rules == 0);
    pack.rules = folder / "rules.json";
    const HeightFacts laid = facts_of(pack);
    CHECK(laid.problem.empty());
    CHECK(laid.rules == 3);
    REQUIRE(laid.layers.size() == 3);
    CHECK(laid.layers[0].share + laid.layers[1].share == Approx(1));
    // 10 of 20 columns are higher than 109.5 m, give or take the cell at the edge.
    for (const RuleLayer& layer : laid.layers)
        CHECK(layer.share == Approx(layer.name == "basalt" ? 0 : 0.5).margin(0.051));
    CHECK(laid.bare_share == Approx(0).margin(1e-6));
    CHECK(laid.texels != bare.texels);
    // A hole is no ground, and spoils none of that beside it, whose slope is asked for.
    std::string holed = ascii_grid(0, "-9999");
    holed.insert(holed.find("cellsize"), "NODATA_value -9999\n");
    spit(folder / "holed.asc", holed);
    spit(folder / "gentle.json", R"({"rules": [{"layer": "grass", "slope_deg": [0, 80], "ragged": 0}]})");
    BakePack over_hole = pack_of({folder / "holed.asc"});
    over_hole.rules = folder / "gentle.json";
    const HeightFacts around = facts_of(over_hole);
    CHECK(around.void_share == Approx(1 / 200.0));
    REQUIRE(around.layers.size() == 1);
    CHECK(around.layers[0].share == Approx(1));
    spit(folder / "rules.json",
         "{\"rules\": [\n  {\"layer\": \"grass\"},\n  {\"layer\": \"snow\", \"hight_m\": [1, 2]}]}");
    const HeightFacts wrong = facts_of(pack);
    CHECK(wrong.at == BakeField::rules);
    CHECK(wrong.problem.starts_with("rules.json:3: rule 1 (snow): unknown field \"hight_m\""));
    CHECK(wrong.known); // and the heights are still shown
    pack.rules = folder / "none.json";
    CHECK(facts_of(pack).at == BakeField::rules);
    CHECK(facts_of(pack).problem.starts_with("none.json"));
}

TEST_CASE("bands and sizes that are missing mark their fields, and are right once they are given") {
    const TemporaryFolder folder;
    fjell::baker::register_drivers();
    const auto write = [&](const std::string& name, int bands) {
        GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
        GDALDataset* const file =
            driver->Create((folder / name).c_str(), 20, 10, bands, bands == 2 ? GDT_Float32 : GDT_Byte, nullptr);
        for (int b = 1; b <= bands; ++b) {
            REQUIRE(file->GetRasterBand(b)->Fill(10 * b) == CE_None);
            file->GetRasterBand(b)->SetColorInterpretation(GCI_Undefined);
        }
        GDALClose(file);
        return folder / name;
    };
    spit(folder / "oblong.r16", std::string(2 * 20 * 10, '\1'));
    BakePack two = pack_of({write("two.tif", 2)}), raw = pack_of({folder / "oblong.r16"});
    two.spacing_m = raw.spacing_m = 10;
    CHECK(facts_of(two).at == BakeField::band);
    CHECK(facts_of(two).problem.find("--") == std::string::npos);
    two.band = "2";
    CHECK(facts_of(two).problem.empty());
    CHECK(facts_of(two).least_m == 20);
    CHECK(facts_of(raw).at == BakeField::size);
    CHECK(facts_of(raw).problem.find("--") == std::string::npos);
    raw.size = "20x10";
    CHECK(facts_of(raw).problem.empty());
    CHECK(facts_of(raw).most_m == 257);
    two.texture = write("five.tif", 5);
    CHECK(facts_of(two).at == BakeField::texture_bands);
    CHECK(facts_of(two).problem.find("--") == std::string::npos);
    two.texture_bands = "4,3,2";
    const HeightFacts right = facts_of(two);
    CHECK(right.problem.empty());
    CHECK(right.texels.at(20) == (0xff000000u | 40u | 30u << 8 | 20u << 16));
}

TEST_CASE("the dialog shows an image as the bake lays it: white of 10 to 16 bits, colours of a palette") {
    const TemporaryFolder folder;
    fjell::baker::register_drivers();
    spit(folder / "west.asc", ascii_grid(0, "101"));
    BakePack pack = pack_of({folder / "west.asc"});
    pack.texture = folder / "image.tif";
    struct Case {
        const char* bits;          // the file says
        int number, largest, byte; // of most pixels, of the first one; what is shown of the former
    };
    for (const Case& c : {Case{"NBITS=12", 2048, 2048, 128},
                          {"NBITS=16", 1023, 2047, 127},
                          {"NBITS=16", 32896, 65535, 128},
                          {"NBITS=16", 4096, 8191, 16},
                          {"", 3, 3, 90}}) {
        CAPTURE(c.bits, c.number);
        const char* const words[] = {c.bits, nullptr};
        const bool palette = *c.bits == '\0';
        GDALDataset* const file = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            pack.texture.c_str(), 20, 10, 1, palette ? GDT_Byte : GDT_UInt16,
            palette ? nullptr : const_cast<char**>(words));
        GDALColorTable table;
        const GDALColorEntry entry{90, 90, 90, 255};
        table.SetColorEntry(3, &entry);
        if (palette) REQUIRE(file->GetRasterBand(1)->SetColorTable(&table) == CE_None);
        REQUIRE(file->GetRasterBand(1)->Fill(c.number) == CE_None);
        auto largest = static_cast<std::uint16_t>(c.largest);
        REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 1, 1, &largest, 1, 1, GDT_UInt16, 0, 0, nullptr) ==
                CE_None);
        GDALClose(file);
        const HeightFacts f = facts_of(pack);
        REQUIRE(f.problem.empty());
        CHECK((f.texels.at(f.width_px - 1) & 255) == static_cast<std::uint32_t>(c.byte));
    }
}

TEST_CASE("heights that are reprojected are looked at through their files, each sample where the bake has it") {
    const TemporaryFolder folder;
    fjell::baker::register_drivers();
    // A plane over degrees: 600 x 400 samples from 10 E 47 N, which rises to the east and to the north.
    const double step = 1.0 / 1200;
    {
        OGRSpatialReference crs;
        crs.SetFromUserInput("EPSG:4326");
        GDALDataset* const file = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            (folder / "a.tif").c_str(), 600, 400, 1, GDT_Float32, nullptr);
        double t[6] = {10, step, 0, 47, 0, -step};
        file->SetGeoTransform(t);
        file->SetSpatialRef(&crs);
        std::vector<float> row(600);
        for (int y = 0; y < 400; ++y) {
            for (int x = 0; x < 600; ++x) row[static_cast<std::size_t>(x)] = static_cast<float>(1000 + x - y);
            REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Write, 0, y, 600, 1, row.data(), 600, 1, GDT_Float32, 0, 0,
                                                     nullptr) == CE_None);
        }
        GDALClose(file);
    }
    const BakePack pack = pack_of({folder / "a.tif"});
    const auto source = fjell::baker::open_inputs(bake_recipe(pack));
    const auto files = fjell::baker::unwarped(*source);
    REQUIRE(files);
    CHECK(files->source->columns == 600);
    const auto reader = source->reader();
    fjell::baker::ReadStatistics statistics;
    std::vector<float> line(static_cast<std::size_t>(source->columns));
    std::size_t heights = 0;
    for (std::int32_t y = 3; y < source->rows; y += 40) {
        reader->read({0, y, source->columns, 1}, line.data(), statistics);
        for (std::int32_t x = 0; x < source->columns; x += 7) {
            double column = x, row = y;
            const float height_m = line[static_cast<std::size_t>(x)];
            if (std::isnan(height_m)) continue;
            REQUIRE(files->place(column, row));
            CHECK(static_cast<double>(height_m) ==
                  Approx(1000 + column - row).margin(0.6)); // at rims it is extrapolated
            ++heights;
        }
    }
    CHECK(heights > 500);
    const HeightFacts f = facts_of(pack);
    CHECK(f.problem.empty());
    CHECK(f.columns == static_cast<std::uint32_t>(source->columns));
    CHECK(f.reprojected_from.find("WGS 84") != std::string::npos);
    CHECK(f.crs.find("UTM zone 32N") != std::string::npos);
    CHECK(f.all_read);
    CHECK(f.least_m == 1000 - 399);
    CHECK(f.most_m == 1000 + 599);
    CHECK(f.void_share > 0);
    CHECK(f.void_share < 0.1);
    // Of a part, only that is read.
    BakePack part = pack;
    part.bbox = "10.1,46.8,10.2,46.9";
    const HeightFacts p = facts_of(part);
    CHECK(p.problem.empty());
    CHECK(p.least_m > 1000 + 110 - 250);
    CHECK(p.most_m < 1000 + 250 - 110);
}

TEST_CASE("what a file leaves open about its heights is answered by the form's fields, a scale of 1 too") {
    const TemporaryFolder folder;
    fjell::baker::register_drivers();
    const auto write = [&](const char* crs_name) {
        OGRSpatialReference crs;
        crs.SetFromUserInput(crs_name);
        GDALDataset* const file = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            (folder / "a.tif").c_str(), 20, 10, 1, GDT_Float32, nullptr);
        double t[6] = {6e6, 30, 0, 2e6, 0, -30};
        if (std::string(crs_name) != "EPSG:2225") t[0] = 5e5;
        file->SetGeoTransform(t);
        file->SetSpatialRef(&crs);
        REQUIRE(file->GetRasterBand(1)->Fill(100) == CE_None);
        GDALClose(file);
    };
    BakePack pack = pack_of({folder / "a.tif"});
    write("EPSG:32633+5715"); // depths
    CHECK(facts_of(pack).at == BakeField::height_scale);
    CHECK(facts_of(pack).problem.find("Height scale 1 if they are heights already") != std::string::npos);
    for (const double scale : {1.0, -1.0}) {
        pack.height_scale = scale;
        CHECK(facts_of(pack).problem.empty());
        CHECK(facts_of(pack).least_m == 100 * scale);
    }
    pack.height_scale = 0;
    write("EPSG:2225"); // in US feet, and the heights say nothing
    CHECK(facts_of(pack).at == BakeField::vertical_unit);
    CHECK(facts_of(pack).problem.find("--") == std::string::npos);
    for (const auto& [unit, height_m] : {std::pair{"m", 100.0}, {"us-ft", 100 * 1200.0 / 3937}}) {
        pack.vertical_unit = unit;
        CHECK(facts_of(pack).problem.empty());
        CHECK(facts_of(pack).least_m == Approx(height_m));
    }
    pack.vertical_unit.clear();
    pack.height_scale = 1;
    CHECK(facts_of(pack).problem.empty());
    CHECK(facts_of(pack).least_m == 100);
}

TEST_CASE("options of fjell-bake that a command names, the bake has, and the dialog finds the file of rules") {
    const TemporaryFolder folder;
    spit(folder / "west.asc", ascii_grid(0, "101"));
    spit(folder / "rules.json", R"({"rules": [{"layer": "grass"}]})");
    const auto command = parse_command("bake a.tif a.fjell layers=r.json splat=full horizons=quarter "
                                       "encoding=terrarium bbox=1,2,3,4 band=elevation size=5x4 vertical-unit=ft "
                                       "texture=i.tif texture-bands=4,3,2");
    const fjell::baker::Recipe recipe = bake_recipe(std::get<BakePack>(*command));
    CHECK(recipe.layers == "r.json");
    CHECK(recipe.splat == "full");
    CHECK(recipe.horizons == "quarter");
    CHECK(recipe.encoding == "terrarium");
    CHECK(recipe.band == "elevation");
    CHECK(recipe.size == "5x4");
    CHECK(recipe.vertical_unit == "ft");
    CHECK(recipe.texture_bands == "4,3,2");
    REQUIRE(recipe.bbox);
    CHECK((*recipe.bbox)[3] == 4);
    for (const char* wrong : {"splat=fine", "horizons=full", "encoding=png", "bbox=1,2,3"}) {
        INFO(wrong);
        const auto refused = parse_command("bake a.tif a.fjell layers=r.json " + std::string(wrong));
        CHECK_THROWS_AS(bake_recipe(std::get<BakePack>(*refused)), fjell::io::Failure);
    }
    BakeDialog d;
    d.run("open " + folder / "west.asc");
    d.run("bake-file " + folder / "rules.json");
    CHECK(d.state.bake.pack.rules == folder / "rules.json");
    CHECK(d.state.bake.pack.inputs.size() == 1);
    d.run("bake-file " + folder / "west.asc" + " heights");
    CHECK(d.state.bake.pack.rules == folder / "rules.json"); // of no file in particular
}

TEST_CASE("files that are given find their fields, other heights begin another bake, and the pack follows them") {
    const TemporaryFolder folder;
    spit(folder / "west.asc", ascii_grid(0, "101"));
    spit(folder / "east.asc", ascii_grid(200, "101"));
    spit(folder / "ramp.json", R"({"stops": []})");
    BakeDialog d;
    const BakePack& pack = d.state.bake.pack;
    d.run("open " + folder / "west.asc");
    CHECK(d.state.interface.dialog == Dialog::bake);
    CHECK(pack.output == folder / "west.fjell");
    d.run("open " + folder / "east.asc"); // dropped on the open dialog: beside the first
    CHECK(pack.inputs.size() == 2);
    d.run("bake-file " + folder / "ramp.json");
    CHECK(pack.ramp == folder / "ramp.json");
    CHECK(pack.inputs.size() == 2);
    d.run("bake-file " + folder / "mine" + " output");
    CHECK(pack.output == folder / "mine.fjell");
    CHECK(d.state.bake.output_problem.empty());
    d.run("bake-file /nowhere/mine.fjell output");
    CHECK(d.state.bake.output_problem.find("/nowhere") != std::string::npos);
    d.run("bake-file " + folder / "east.asc" + " heights");
    CHECK(pack.inputs == std::vector<std::string>{folder / "east.asc"});
    CHECK(pack.output == folder / "east.fjell");
    CHECK(pack.ramp == folder / "ramp.json"); // of no file in particular
    spit(folder / "east.fjell", "");
    d.run("bake-file " + folder / "east.asc" + " another"); // the same again adds nothing
    CHECK(pack.inputs.size() == 1);
    CHECK(d.state.bake.output_exists);
}

TEST_CASE("a pack that is ready is asked about only while another terrain is flown, and after other dialogs") {
    BakeDialog d;
    d.state.scene.path = "flown.fjell";
    d.state.interface.dialog = Dialog::save_profile;
    d.state.bake.asks = true;
    take_baked("new.fjell", {d.state, d.engine, d.jobs});
    CHECK(d.state.interface.dialog == Dialog::save_profile); // what is typed there is not lost
    CHECK(d.state.bake.ready == "new.fjell");
    d.run("dialog none");
    CHECK(d.state.interface.dialog == Dialog::baked);
    d.run("open-baked off");
    CHECK(d.state.interface.dialog == Dialog::none);
    CHECK(d.state.bake.ready.empty());
    CHECK(d.state.scene.path == "flown.fjell");
    d.run("open-baked on");
    CHECK(d.state.messages.all.back().severity == Severity::error); // there is none any more
}
