// What ./dev gpu does, small: on the software renderer where there is no other.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/gl/image.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;

namespace {

using nlohmann::json;
using test::slurp;

struct Measured {
    Measured() {
        run = test::run_in(home.path, "'" FJELL_SOURCE_DIR "/tests/bench/gpu.sh' '" FJELL_BIN_DIR "' out --quick");
        INFO(run.err);
        REQUIRE(run.code == 0);
        found = json::parse(slurp(home.path / "out/gpu.json"));
    }
    [[nodiscard]] gl::Image picture(const std::string& name) const {
        return gl::read_png((home.path / "out" / name).string());
    }
    const test::TemporaryFolder home;
    test::Run run;
    json found;
};
const Measured& measured() {
    static const Measured one;
    return one;
}

// Levels of 255 that two pictures of one size differ by, the mean of all numbers.
double difference(const gl::Image& a, const gl::Image& b) {
    REQUIRE(a.rgb.size() == b.rgb.size());
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::abs(int{a.rgb[i]} - int{b.rgb[i]});
    return sum / static_cast<double>(a.rgb.size());
}

} // namespace

TEST_CASE("./dev gpu flies each scene at each size with each setting, and says what a frame took") {
    const Measured& m = measured();
    const json& flights = m.found.at("flights");
    REQUIRE(flights.size() == 2 * 7);
    const bool timers = m.found.at("timers");
    CHECK_FALSE((timers && m.found.at("software")));
    double uploaded = 0;
    for (std::size_t i = 0; i < flights.size(); ++i) {
        const json& row = flights[i];
        INFO(row.dump());
        CHECK(row.at("triangles") > 100);
        CHECK(row.at("update_us").at("p50") > 0);
        CHECK(row.at("frame_ms").at("p99") >= row.at("frame_ms").at("p50"));
        CHECK(row.at("frame_ms").at("p50").get<double>() > row.at("update_us").at("p50").get<double>() * 1e-3);
        CHECK(row.at("draw_gpu_us").is_null() == !timers);
        CHECK(row.at("draw").at("calls") == 2); // the ground and the sky
        CHECK(row.at("draw").at("draws") > 2);
        uploaded += row.at("uploaded_bytes").at("p99").get<double>();
        const gl::Image picture = m.picture(row.at("picture"));
        CHECK(picture.width == row.at("width"));
        CHECK(picture.height == row.at("height"));
        const std::set<std::uint8_t> levels(picture.rgb.begin(), picture.rgb.end());
        CHECK(levels.size() > 50);
        // Every setting shows; nothing else differs, not a single dither.
        if (i % 7 != 0) CHECK(difference(picture, m.picture(flights[i - 1].at("picture"))) > 0.02);
    }
    CHECK(uploaded > 0);
}

TEST_CASE("./dev gpu draws the same ground as a mesh and as patches, at the same true error or as many triangles") {
    const Measured& m = measured();
    const json& rows = m.found.at("patches");
    REQUIRE(rows.size() == 2 * 3);
    for (std::size_t i = 0; i < rows.size(); i += 2) {
        const json &mesh = rows[i], &patches = rows[i + 1];
        INFO(mesh.dump() << "\n" << patches.dump());
        REQUIRE(mesh.at("method") == "cut");
        REQUIRE(patches.at("method") == "cdlod");
        CHECK(mesh.at("asked") == patches.at("asked"));
        for (const json& row : {mesh, patches}) {
            CHECK(row.at("true_error_px") <= row.at("error_px"));
            CHECK(row.at("true_error_px") > 0);
            CHECK(row.at("draws") > 0);
            CHECK(row.at("frame_ms") > 0);
        }
        const double ratio = patches.at("triangles").get<double>() / mesh.at("triangles").get<double>();
        if (i == 0) {
            CHECK(mesh.at("error_px") == 2);
            CHECK(patches.at("true_error_px") <= mesh.at("true_error_px"));
            CHECK(ratio > 1);
        } else {
            CHECK(std::abs(ratio - 1) < 0.25); // patches come whole
        }
        // Both show the same mountains: the sky is the same in all pixels but a few of the ridges'.
        const gl::Image a = m.picture(mesh.at("picture")), b = m.picture(patches.at("picture"));
        std::size_t sky = 0, other = 0, pixels = std::size_t{a.width} * a.height;
        for (std::uint32_t y = 0; y < a.height; ++y)
            for (std::uint32_t x = 0; x < a.width; ++x) {
                const auto is_sky = [&](const gl::Image& image) {
                    return std::equal(image.pixel(x, y), image.pixel(x, y) + 3, a.pixel(0, 0));
                };
                sky += is_sky(a);
                other += is_sky(a) != is_sky(b);
            }
        CHECK(sky > pixels / 10);
        CHECK(sky < pixels * 9 / 10);
        CHECK(other < pixels / 100);
        CHECK(difference(a, b) < 12); // slopes are lit alike
    }
}

TEST_CASE("./dev gpu makes tables with as many cells as heads and the command in each row") {
    std::istringstream text(slurp(measured().home.path / "out/gpu.md"));
    std::ptrdiff_t cells = 0;
    int rows = 0;
    for (std::string line; std::getline(text, line);) {
        if (!line.starts_with("| ")) {
            if (line.empty()) cells = 0;
            continue;
        }
        const auto bars = std::count(line.begin(), line.end(), '|');
        if (cells != 0) {
            INFO(line);
            CHECK(bars == cells);
            CHECK(line.find("`./dev gpu`") != std::string::npos);
            ++rows;
        }
        cells = bars;
    }
    CHECK(rows == 2 + 2 * 7 + 6);
}
