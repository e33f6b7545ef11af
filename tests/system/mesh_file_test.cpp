// fjell-bake mesh and heights: files read by programs that share nothing with ours (mesh/check.py,
// mesh/heights.py), which measure every sample.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

std::string done(const TemporaryFolder& folder, const std::string& command) {
    const Run r = run_in(folder.path, command);
    CAPTURE(command, r.out, r.err);
    REQUIRE(r.code == 0);
    return r.out;
}

// Mountains with a cliff and, if asked for, holes: one inside, one at the rim.
void write_mountains(const TemporaryFolder& folder, int columns, int rows, const std::string& spacing, bool holes,
                     bool mirrored = false) {
    std::string text = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) +
                       "\nxllcorner 430000\nyllcorner 6790000\ncellsize " + spacing + "\nNODATA_value -9999\n";
    for (int y = 0; y < rows; ++y) {
        for (int column = 0; column < columns; ++column) {
            const int x = mirrored ? columns - 1 - column : column;
            const double waves = 900 + 300 * std::sin(x * 0.13) * std::cos(y * 0.11) + 40 * std::sin(x * 0.7 + y);
            const bool hole = holes && ((std::abs(x - 33) < 4 && std::abs(y - 21) < 3) || (x < 5 && y > 10 && y < 14));
            text += hole ? "-9999 " : std::to_string(waves + (x > 40 && y > 25 ? 200 : 0)) + " ";
        }
        text += "\n";
    }
    spit(folder / "dem.asc", text);
}

json checked(const TemporaryFolder& folder, const std::string& file) {
    return json::parse(done(folder, "python3 " FJELL_SOURCE_DIR "/tests/system/mesh/check.py " + file + " dem.asc"));
}

} // namespace

TEST_CASE("no sample is farther from a mesh file than the file says, and there is no crack") {
    struct Field {
        int columns, rows;
        std::string spacing; // 0.3 m: coordinates are no floats
        bool holes;
    };
    for (const Field& f : first_of<Field>(2, {{97, 60, "30", true},
                                              {65, 65, "30", false},
                                              {130, 41, "0.3", true},
                                              {2, 2, "10", false},
                                              {2, 40, "5", false}})) {
        const TemporaryFolder folder;
        CAPTURE(f.columns, f.rows, f.spacing);
        write_mountains(folder, f.columns, f.rows, f.spacing, f.holes);
        for (const std::string error : first_of(2, {"0.01", "5", "80"}))
            for (const std::string way : {"glb", "ply", "obj", "stl", "glb --quantised"}) {
                CAPTURE(error, way);
                const std::string ending = way.substr(0, 3);
                const bool quantised = way.size() > 3;
                if (quantised && error == "0.01") continue; // finer than 16 bits of this relief
                const json said = json::parse(
                    done(folder, bake + "mesh dem.asc -o mesh." + way + " --max-error-m " + error + " --json -"));
                const json found = checked(folder, "mesh." + ending);
                const double slack_m = 1e-5 * 400 + // check.py's EDGE, on cliffs of 400 m a cell
                                       (quantised ? 0.5 * std::stod(error) : 0); // rounding, which is not measured
                CHECK(said["true_error_m"].get<double>() <= std::stod(error));
                CHECK(found["worst"].get<double>() <= said["true_error_m"].get<double>() + 1e-5 * 400);
                CHECK(found["worst"].get<double>() >= said["true_error_m"].get<double>() - slack_m);
                CHECK(found["claimed"].get<double>() == Approx(said["true_error_m"].get<double>()).epsilon(1e-5));
                CHECK(found["triangles"] == said["ground_triangles"]);
                CHECK(found["facets"] == said["triangles"]);
                CHECK(found["downward"] == 0);
                CHECK(found["bare"] == 0);
                CHECK(found["over_holes"] == 0);
                CHECK(found["inner"] == 0);
                CHECK(said["bytes"] == std::filesystem::file_size(folder / ("mesh." + ending)));
                if (ending != "stl") continue;
                CHECK(found["unpaired"] == 0);
                CHECK(found["volume"].get<double>() > 0);
                const double fewest = f.holes ? 1.0 : 0.5; // a base that is flat needs few
                if (error == "0.01" && f.rows > 50)
                    CHECK(found["facets"].get<double>() < (1 + fewest) * found["triangles"].get<double>());
            }
    }
}

TEST_CASE("a mesh takes as many triangles as it may, or the options that a bake takes") {
    const TemporaryFolder folder;
    write_mountains(folder, 129, 129, "30", true);
    const auto mesh = [&](const std::string& options) {
        return json::parse(done(folder, bake + "mesh " + options + " --json -"));
    };
    const json few = mesh("dem.asc -o few.ply --max-triangles 2000");
    CHECK(few["triangles"] <= 2000);
    CHECK(few["triangles"] >= 1800);
    CHECK(checked(folder, "few.ply")["worst"] <= few["max_error_m"]);
    CHECK(mesh("dem.asc -o part.ply --max-error-m 0 --bbox 430000,6790000,430600,6790900")["columns"] == 20);
    CHECK(mesh("dem.asc -o full.ply --max-error-m 0 --nodata fill")["triangles"] == 2 * 128 * 128);
    // A pack, and the field that it was baked from.
    done(folder, bake + "dem.asc -o pack.fjell --quiet");
    done(folder, bake + "heights pack.fjell -o back.tif --quiet");
    (void)mesh("pack.fjell -o pack.glb --max-error-m 3");
    (void)mesh("back.tif -o back.glb --max-error-m 3");
    const auto binary = [&](const std::string& name) {
        const std::string glb = slurp(folder / name);
        return glb.substr(glb.find("BIN"));
    };
    CHECK(binary("pack.glb") == binary("back.glb"));
    // Told before, to the byte, and nothing is written.
    for (const std::string way :
         {"told.glb --quantised --meshopt", "told.glb --normal-map", "told.ply", "told.obj", "told.stl"}) {
        CAPTURE(way);
        const std::string options = "dem.asc --max-error-m 8 -o " + way;
        json told = mesh(options + " --dry-run");
        CHECK_FALSE(std::filesystem::exists(folder / way.substr(0, 8)));
        json written = mesh(options);
        CHECK(told["bytes"] == std::filesystem::file_size(folder / way.substr(0, 8)));
        told.erase("mesh_s"), written.erase("mesh_s");
        CHECK(told == written);
        std::filesystem::remove(folder / way.substr(0, 8));
    }
    // Whatever the number of threads.
    done(folder, bake + "mesh dem.asc -o one.stl --max-error-m 3 --threads 1 --quiet");
    done(folder, bake + "mesh dem.asc -o three.stl --max-error-m 3 --threads 3 --quiet");
    CHECK(slurp(folder / "one.stl") == slurp(folder / "three.stl"));
}

TEST_CASE("with its normal texture a coarse mesh is lit as all samples would be") {
    const TemporaryFolder folder;
    std::string text = "ncols 130\nnrows 75\nxllcorner 430000\nyllcorner 6790000\ncellsize 30\nNODATA_value -9999\n";
    for (int y = 0; y < 75; ++y) {
        for (int x = 0; x < 130; ++x)
            text +=
                std::to_string(900 + 120 * std::sin(x * 0.13) * std::cos(y * 0.11) + 9 * std::sin(x * 0.7 + y)) + " ";
        text += "\n";
    }
    spit(folder / "dem.asc", text);
    done(folder, bake + "dem.asc -o pack.fjell --quiet --horizons half");
    for (const std::string way : {"dem.asc", "dem.asc --quantised", "pack.fjell --occlusion"}) {
        CAPTURE(way);
        const json said =
            json::parse(done(folder, bake + "mesh " + way + " -o mesh.glb --max-error-m 60 --normal-map --json -"));
        CHECK(said["triangles"] < 2000);
        const json found =
            json::parse(done(folder, "python3 " FJELL_SOURCE_DIR "/tests/system/mesh/check_maps.py mesh.glb dem.asc"));
        CAPTURE(found.dump());
        CHECK(found["samples"] >= 130 * 75);
        CHECK(found["flat_deg"] > 10);
        // Half a step of 1 / 127.5 in three components, 0.39 degrees, and the rounding of a pack's heights.
        CHECK(found["angle_deg"].get<double>() < 0.5);
        CHECK(found["occlusion"].is_null() != way.ends_with("--occlusion"));
        if (!way.ends_with("--occlusion")) continue;
        CHECK(found["occlusion"][0] < 250);
        CHECK(found["occlusion"][1] == 255);
    }
}

TEST_CASE("assimp reads meshes with their textures, and not what it has no reader for") {
    const TemporaryFolder folder;
    if (run_in(folder.path, "command -v assimp").code != 0) {
        WARN("there is no assimp, which ./dev test --long installs: it reads no mesh");
        return;
    }
    write_mountains(folder, 97, 60, "30", false);
    done(folder, bake + "dem.asc -o pack.fjell --quiet --horizons half");
    const auto numbers_after = [&](const std::string& text, const std::string& label) {
        const std::size_t at = text.find(label);
        REQUIRE(at != std::string::npos);
        std::istringstream words(text.substr(at + label.size()));
        std::vector<double> found;
        for (std::string word; words >> word;) {
            if (word.starts_with("(")) word.erase(0, 1);
            found.push_back(std::stod(word));
            if (found.size() == 3 || label.find("point") == std::string::npos) break;
        }
        return found;
    };
    for (const std::string way : {"mesh.glb --colours --normal-map --occlusion", "mesh.ply", "mesh.obj", "mesh.stl"}) {
        CAPTURE(way);
        const json said =
            json::parse(done(folder, bake + "mesh pack.fjell -o " + way + " --max-error-m 20 --quiet --json -"));
        const std::string read = done(folder, "assimp info " + way.substr(0, 8));
        CAPTURE(read);
        CHECK(numbers_after(read, "\nFaces:")[0] == said["triangles"]);
        CHECK(numbers_after(read, "\nTextures (embed.):")[0] == (way.ends_with("occlusion") ? 3 : 0));
        const bool z_up = way.ends_with(".ply") || way.ends_with(".stl");
        const auto low = numbers_after(read, "\nMinimum point"), high = numbers_after(read, "\nMaximum point");
        CHECK(high[0] - low[0] == Approx(96 * 30));
        CHECK(high[z_up ? 1 : 2] - low[z_up ? 1 : 2] == Approx(59 * 30));
        CHECK(high[z_up ? 2 : 1] > low[z_up ? 2 : 1] + 600);
    }
    // It ignores that KHR_mesh_quantization is required, so only the other extension stops it.
    done(folder, bake + "mesh pack.fjell -o packed.glb --max-error-m 20 --meshopt --quiet");
    const Run packed = run_in(folder.path, "assimp info packed.glb");
    CHECK(packed.code != 0);
    CHECK((packed.out + packed.err).find("missing the \"uri\" attribute") != std::string::npos);
}

TEST_CASE("a mesh of a polygon has its samples and no others") {
    const TemporaryFolder folder;
    write_mountains(folder, 97, 60, "30", true);
    done(folder, "gdal_translate -q -a_srs EPSG:32632 dem.asc placed.tif");
    // Columns and rows of two areas that overlap, one of them with a hole; corners lie between samples.
    const auto place = [](double column, double row) {
        return "[" + std::to_string(430000 + 30 * (column + 0.5)) + "," + std::to_string(6790000 + 30 * (59.5 - row)) +
               "]";
    };
    const auto box = [&](double west, double north, double east, double south) {
        return "[" + place(west, north) + "," + place(east, north) + "," + place(east, south) + "," +
               place(west, south) + "," + place(west, north) + "]";
    };
    const std::string areas =
        R"({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:32632"}}, "features": [)"
        R"({"type": "Feature", "properties": {}, "geometry": {"type": "MultiPolygon", "coordinates": [[)" +
        box(9.5, 4.5, 60.5, 50.5) + "," + box(29.5, 14.5, 45.5, 30.5) + "]," + "[" + box(50.5, 30.5, 80.5, 55.5) +
        R"(]]}}]})";
    spit(folder / "areas.geojson", areas);
    const auto inside = [](int x, int y) {
        const auto in = [&](int west, int north, int east, int south) {
            return x > west && x <= east && y > north && y <= south;
        };
        return (in(9, 4, 60, 50) && !in(29, 14, 45, 30)) || in(50, 30, 80, 55);
    };
    const json said = json::parse(
        done(folder, bake + "mesh placed.tif -o part.ply --max-error-m 2 --polygon areas.geojson --json -"));
    // The same field with holes outside: check.py finds that ground, that all of it is covered, and nothing else.
    std::string grid = slurp(folder / "dem.asc"), masked;
    std::size_t at = 0;
    for (int line = 0; line < 6; ++line) at = grid.find('\n', at) + 1;
    masked = grid.substr(0, at);
    int kept = 0, with_height = 0;
    for (int y = 0; y < 60; ++y, masked += "\n", ++at)
        for (int x = 0; x < 97; ++x) {
            const std::size_t end = grid.find(' ', at);
            const std::string value = grid.substr(at, end - at);
            with_height += value != "-9999";
            kept += value != "-9999" && inside(x, y);
            masked += inside(x, y) ? value + " " : "-9999 ";
            at = end + 1;
        }
    spit(folder / "dem.asc", masked);
    const json found = checked(folder, "part.ply");
    CHECK(found["ground"] == kept);
    CHECK(said["left_out"] == with_height - kept);
    CHECK(found["bare"] == 0);
    CHECK(found["over_holes"] == 0);
    CHECK(found["inner"] == 0);
    CHECK(found["worst"] <= said["true_error_m"].get<double>() + 1e-5 * 400);
    // In degrees, as GeoJSON has it, the same samples but for those beside the sides; to STL, which is closed.
    done(folder, "ogr2ogr -f GeoJSON degrees.json areas.geojson -t_srs EPSG:4326 -lco RFC7946=YES");
    const json turned =
        json::parse(done(folder, bake + "mesh placed.tif -o part.stl --max-error-m 2 --polygon degrees.json --json -"));
    CHECK(std::abs(turned["left_out"].get<int>() - said["left_out"].get<int>()) < 12);
    CHECK(checked(folder, "part.stl")["unpaired"] == 0);
    const auto refuses = [&](const std::string& polygon, const std::string& says) {
        refused(folder, bake + "mesh placed.tif -o new.ply --max-error-m 2 --polygon " + polygon, 1, says);
    };
    refuses("missing.json", "missing.json");
    refuses("placed.tif", "is no file of polygons");
    spit(folder / "point.json", R"({"type": "Point", "coordinates": [9, 61]})");
    refuses("point.json", "has no polygon");
    spit(folder / "far.json", R"({"type": "Polygon", "coordinates": [[[1, 1], [2, 1], [2, 2], [1, 1]]]})");
    refuses("far.json", "no sample lies in its polygons");
    refused(folder,
            bake + "mesh placed.tif -o areas.geojson.ply --max-error-m 2 --polygon areas.geojson --json "
                   "areas.geojson",
            2, "areas.geojson");
}

TEST_CASE("what is no mesh is refused in one line, and leaves no file") {
    const TemporaryFolder folder;
    write_mountains(folder, 40, 40, "30", false);
    std::string grid = ascii_grid(9, 9, "5", "NODATA_value -9999\n");
    grid.replace(grid.find("5 5 5 5", 200), 1, "-9999");
    spit(folder / "hole.asc", grid);
    const auto refuses = [&](const std::string& options, int code, const std::string& says) {
        refused(folder, bake + "mesh " + options, code, says);
    };
    refuses("dem.asc -o mesh.glb", 2, "--max-error-m or --max-triangles");
    refuses("dem.asc -o mesh.glb --max-error-m 1 --max-triangles 9", 2, "one of them");
    refuses("dem.asc -o mesh.glb --max-error-m -1", 2, "--max-error-m");
    refuses("dem.asc -o mesh.glb --max-error-m nan", 2, "--max-error-m");
    refuses("dem.asc -o mesh.glb --max-error-m much", 2, "--max-error-m");
    refuses("dem.asc -o mesh.fbx --max-error-m 1", 2, ".glb, .ply, .obj, .stl");
    for (const std::string option : {"--meshopt", "--quantised", "--normal-map"})
        refuses("dem.asc -o mesh.ply --max-error-m 1 " + option, 2, option + " is for .glb");
    refuses("dem.asc -o mesh.glb --max-error-m 0 --quantised", 1, "leave out --quantised");
    refuses("dem.asc -o mesh --max-error-m 1", 2, ".glb, .ply, .obj, .stl");
    refuses("dem.asc -o mesh.stl --max-error-m 1 --base-m 0", 2, "the base touches");
    refuses("hole.asc -o mesh.ply --max-triangles 2", 2, "the coarsest mesh has");
    refuses("dem.asc -o mesh.ply --max-error-m 1 --bbox 0,0,9,9", 1, "bbox");
    refuses("dem.asc -o no/mesh.ply --max-error-m 1", 1, "no");
    refuses("dem.asc -o dem.asc --max-error-m 1", 2, "dem.asc");
    refuses("missing.tif -o mesh.ply --max-error-m 1", 1, "missing.tif");
    spit(folder / "void.asc", ascii_grid(9, 9, "-9999", "NODATA_value -9999\n"));
    refuses("void.asc -o mesh.ply --max-error-m 1", 1, "");
    done(folder, bake + "dem.asc -o pack.fjell --quiet");
    refuses("pack.fjell -o mesh.ply --max-error-m 1 --bbox 0,0,9,9", 2, "is a pack");
    // A full disk, and a file that was there before.
    for (const std::string ending : {"glb", "ply", "obj", "stl"}) {
        const std::string file = "mesh." + ending;
        spit(folder / file, "before");
        refused(folder, "trap '' XFSZ; ulimit -f 8; " + bake + "mesh dem.asc --max-error-m 0 -o " + file, 3, file);
        CHECK(slurp(folder / file) == "before");
    }
}

TEST_CASE("heights for engines are the field's, as the summary beside them says") {
    const TemporaryFolder folder;
    struct Way {
        std::string options;
        int columns, rows, files, level;
    };
    for (const Way& w : std::vector<Way>{{"", 97, 60, 1, 0},
                                         {"--at 1", 49, 31, 1, 1},
                                         {"--at 3", 13, 9, 1, 3},
                                         {"--tiles 33", 33, 33, 6, 0},
                                         {"--tiles 17 --at 2", 17, 17, 2, 2}})
        for (const std::string ending : {"r16", "raw", "png"}) {
            const bool mirrored = ending == "raw"; // the other diagonal is the worse one
            if (!full_rounds() && ending != "raw" && w.level != 1) continue;
            CAPTURE(w.options, ending);
            write_mountains(folder, 97, 60, "30", false, mirrored);
            done(folder, "rm -f h*; " + bake + "heights dem.asc -o h." + ending + " --quiet " + w.options);
            const json said = json::parse(slurp(folder / "h.json"));
            const json found =
                json::parse(done(folder, "python3 " FJELL_SOURCE_DIR "/tests/system/mesh/heights.py h.json dem.asc"));
            CHECK(said["columns"] == w.columns);
            CHECK(said["rows"] == w.rows);
            CHECK(said["files"].size() == static_cast<std::size_t>(w.files));
            CHECK(said["spacing_m"][0] == 30 << w.level);
            CHECK(found["surface"].get<double>() == Approx(said["error_m"].get<double>()).margin(1e-4)); // floats
            CHECK(found["rounded"].get<double>() <= said["scale_m"].get<double>() / 2 + 1e-4);
            CHECK(found["shared"].get<int>() >= (w.files - 1) * (w.columns / 2));
            CHECK(folder.names().size() == static_cast<std::size_t>(w.files) + 2);
        }
}

TEST_CASE("GDAL and PIL find the numbers of a raw file in a picture of heights") {
    const TemporaryFolder folder;
    write_mountains(folder, 97, 60, "30", false);
    done(folder, bake + "heights dem.asc -o h.png --quiet && " + bake + "heights dem.asc -o raw.r16 --quiet");
    const std::string numbers = slurp(folder / "raw.r16");
    REQUIRE(numbers.size() == 2 * 97 * 60);
    done(folder, "gdal_translate -q -of ENVI h.png gdal.bin");
    CHECK(slurp(folder / "gdal.bin") == numbers);
    const std::string script = "'from PIL import Image; import array, sys; i = Image.open(\"h.png\"); "
                               "assert i.size == (97, 60), i.size; a = array.array(\"H\", i.getdata()); "
                               "sys.byteorder == \"big\" and a.byteswap(); open(\"pil.bin\", \"wb\").write(a)'";
    for (const std::string python : {"python3", "/usr/bin/python3"}) // the first may be one without Debian's packages
        if (run_in(folder.path, python + " -c 'import PIL'").code == 0) {
            done(folder, python + " -c " + script);
            CHECK(slurp(folder / "pil.bin") == numbers);
            return;
        }
    WARN("there is no PIL, which ./dev test --long installs: it reads no picture of heights");
}

TEST_CASE("raw heights come back as they were, and a step of a GeoTIFF lies where it was") {
    const TemporaryFolder folder;
    write_mountains(folder, 97, 60, "30", false);
    done(folder, bake + "heights dem.asc -o raw.r16 --quiet");
    const json said = json::parse(slurp(folder / "raw.json"));
    const std::string back = "--size 97x60 --spacing 30 --zscale " + std::to_string(said["scale_m"].get<double>()) +
                             " --zoffset " + std::to_string(said["offset_m"].get<double>());
    done(folder, bake + "heights raw.r16 -o again.r16 --quiet " + back);
    const std::string first = slurp(folder / "raw.r16"), second = slurp(folder / "again.r16");
    REQUIRE(first.size() == second.size());
    int most = 0; // the options have six digits
    for (std::size_t i = 0; i < first.size(); i += 2) {
        const auto number = [i](const std::string& from) {
            return static_cast<unsigned char>(from[i]) + 256 * static_cast<unsigned char>(from[i + 1]);
        };
        most = std::max(most, std::abs(number(first) - number(second)));
    }
    CHECK(most <= 3);
    done(folder, "gdal_translate -q -a_srs EPSG:32632 dem.asc placed.tif");
    done(folder, bake + "heights placed.tif -o part.tif --tiles 33 --at 1 --quiet");
    const std::string info = done(folder, "gdalinfo part_x1_y0.tif");
    const double west = 430000 + 15 + 32 * 60 - 30, north = 6790000 + 60 * 30 - 15 + 30;
    CHECK(info.find("Origin = (" + std::to_string(static_cast<long>(west))) != std::string::npos);
    CHECK(info.find("," + std::to_string(static_cast<long>(north))) != std::string::npos);
    CHECK(info.find("Pixel Size = (60.0") != std::string::npos);
    CHECK(info.find("UTM zone 32N") != std::string::npos);
}

TEST_CASE("heights that no file can hold are refused in one line") {
    const TemporaryFolder folder;
    write_mountains(folder, 40, 40, "30", false);
    refused(folder, bake + "heights dem.asc -o h.bmp", 2, ".tif, .raw, .r16, .png or .exr");
    refused(folder, bake + "heights dem.asc -o h.r16 --at 9", 2, "--at 9");
    refused(folder, bake + "heights dem.asc -o h.r16 --at -1", 2, "--at");
    refused(folder, bake + "heights dem.asc -o h.r16 --tiles 1", 2, "--tiles");
    refused(folder, bake + "heights dem.asc -o dem.asc", 2, "dem.asc");
    refused(folder, bake + "heights dem.asc -o no/h.r16", 1, "no");
    for (const std::string ending : {"r16", "png"}) {
        spit(folder / ("h." + ending), "before");
        refused(folder, "trap '' XFSZ; ulimit -f 1; " + bake + "heights dem.asc -o h." + ending, 3, "h." + ending);
        CHECK(slurp(folder / ("h." + ending)) == "before");
    }
    if (run_in(folder.path, "gdalinfo --formats | grep -q ' EXR '").code != 0) {
        refused(folder, bake + "heights dem.asc -o h.exr", 3, "no driver for EXR");
        WARN("this GDAL has no EXR driver: files of that kind are not tested");
    } else {
        done(folder, bake + "heights dem.asc -o h.exr --quiet");
        CHECK(done(folder, "gdalinfo -stats h.exr").find("Type=Float32") != std::string::npos);
    }
}
