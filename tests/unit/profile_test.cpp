#include <filesystem>
#include <string>

#include <catch2/catch.hpp>

#include "fly/log.h"
#include "fly/profile.h"
#include "host/failure.h"

using namespace fjell;
using namespace fjell::fly;

namespace {

std::string refusal(const std::string& text) {
    try {
        (void)parse_profile(text, "p.toml");
    } catch (const host::Failure& failure) {
        CHECK(failure.exit_code == 1);
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.what();
    }
    return "accepted";
}

void refuses(const std::string& text, const std::string& line) {
    INFO(refusal(text));
    CHECK(refusal(text).starts_with(line));
}

} // namespace

TEST_CASE("every shipped profile loads and names every key") {
    const std::filesystem::path folder = std::string(FJELL_SOURCE_DIR) + "/profiles";
    int profiles = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
        if (file.path().extension() != ".toml") continue;
        ++profiles;
        const Profile p = read_profile(file.path().string());
        CHECK(p.refine.error_px > 0);
        CHECK(p.budget.indices >= p.budget.vertices);
    }
    CHECK(profiles == 4);
    const Profile tiny = read_profile((folder / "tiny.toml").string());
    CHECK(tiny.budget.vertices == 4096);
    CHECK(tiny.width_px == 320);
}

TEST_CASE("an empty profile is the defaults, and every key changes its own field") {
    const Profile d = parse_profile("", "p.toml");
    CHECK(d.refine.error_px == RefineSettings{}.error_px);
    CHECK(d.budget.vertices == RecursiveBudget{}.vertices);
    const Profile p = parse_profile(
        "[refine]\nmethod = \"recursive\"\nerror_px = 3\nmetric = \"depth\"\ncull = true\ncorner_safe = true\n"
        "topology = \"strip\"\n[budget]\nvertices = 1_000\nindices = 9_000\n"
        "[view]\nwidth_px = 640\nheight_px = 480\nfov_deg = 60.5\n",
        "p.toml");
    CHECK(p.refine.error_px == 3);
    CHECK(p.refine.metric == Metric::depth);
    CHECK(p.refine.corner_safe);
    CHECK(p.refine.topology == Topology::strip);
    CHECK(p.budget.vertices == 1000);
    CHECK(p.budget.indices == 9000);
    CHECK(p.width_px == 640);
    CHECK(p.height_px == 480);
    CHECK(p.fov_deg == 60.5);
    CHECK_FALSE(parse_profile("[refine]\ncull = false\n", "p.toml").refine.cull);
}

TEST_CASE("a bad profile is refused in one line with file, line and key") {
    refuses("[refine]\n\nerror_pixels = 1\n",
            "p.toml:3: refine.error_pixels: unknown key; [refine] has method, error_px");
    refuses("[budgets]\nvertices = 5000\n", "p.toml:1: budgets: unknown table");
    refuses("error_px = 1\n", "p.toml:1: error_px: unknown table");
    refuses("refine = 1\n", "p.toml:1: refine: must be a table");
    refuses("[refine]\nerror_px = 0\n", "p.toml:2: refine.error_px: must be a number from 0.01 to 1000");
    refuses("[refine]\nerror_px = nan\n", "p.toml:2: refine.error_px: must be a number");
    refuses("[refine]\nerror_px = inf\n", "p.toml:2: refine.error_px: must be a number");
    refuses("[refine]\nerror_px = \"1\"\n", "p.toml:2: refine.error_px: must be a number");
    refuses("[refine]\nmetric = \"manhattan\"\n", "p.toml:2: refine.metric: must be \"isotropic\" or \"depth\"");
    refuses("[refine]\ncull = 1\n", "p.toml:2: refine.cull: must be true or false");
    refuses("[refine]\nmethod = \"incremental\"\n", "p.toml:2: refine.method: \"incremental\" is not in this version");
    refuses("[budget]\nvertices = -1\n", "p.toml:2: budget.vertices: must be a whole number from 16");
    refuses("[budget]\nvertices = 1e6\n", "p.toml:2: budget.vertices: must be a whole number");
    refuses("[budget]\nindices = 99999999999\n", "p.toml:2: budget.indices: must be a whole number");
    refuses("[view]\nwidth_px = 0\n", "p.toml:2: view.width_px: must be a whole number from 1 to 16384");
    refuses("[view]\nfov_deg = 180\n", "p.toml:2: view.fov_deg: must be a number from 1 to 150");
    refuses("[refine]\nerror_px = \n", "p.toml:2: not TOML");
    refuses("[refine]\nerror_px = 1\nerror_px = 2\n", "p.toml:3: not TOML");
    refuses("[refine]\nmetric = \"depth\"\ncull = false\n", "p.toml: refine.metric \"depth\" needs refine.cull = true");
    CHECK_THROWS_AS(read_profile("/nowhere/p.toml"), host::Failure);
    CHECK_THROWS_AS(read_profile("/"), host::Failure);
}

TEST_CASE("percentiles are values that occurred, at the nearest rank") {
    CHECK(percentiles({}).max == 0);
    CHECK(percentiles({7}).p50 == 7);
    std::vector<double> hundred;
    for (int i = 100; i >= 1; --i) hundred.push_back(i);
    const Percentiles p = percentiles(hundred);
    CHECK(p.p50 == 50);
    CHECK(p.p99 == 99);
    CHECK(p.p9999 == 100);
    CHECK(p.max == 100);
}

TEST_CASE("a flight's CSV names exhausted budgets and leaves unmeasured errors empty") {
    FlightLog log;
    FrameEntry a;
    a.update_us = 12.34;
    a.report.vertices = 5;
    a.report.exhausted = budget_vertices | budget_indices;
    a.report.error_px_asked = 1;
    a.report.error_px_effective = 1.5;
    FrameEntry b;
    b.report.converged = true;
    b.verified_px = 0.25;
    log.frames = {a, b};
    CHECK(csv(log) == "frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,"
                      "converged,verified_px\n"
                      "0,12.3,5,0,0,0,1,1.5,vertices+indices,0,\n"
                      "1,0.0,0,0,0,0,0,0,,1,0.25\n");
    const Summary s = summarise(log);
    CHECK(s.converged == 1);
    CHECK(s.verified == 1);
    CHECK(s.effective_px_max == 1.5);
    CHECK(s.ns_per_vertex == Approx(12340.0 / 5));
}
