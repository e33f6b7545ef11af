#include <filesystem>
#include <set>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"
#include "io/file.h"
#include "session/log.h"

using namespace fjell;
using namespace fjell::session;

namespace {

std::string profile_refusal(const std::string& text) {
    try {
        (void)parse_profile(text, "p.toml");
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.what();
    }
    return "accepted";
}

void refuses(const std::string& text, const std::string& line) {
    INFO(profile_refusal(text));
    CHECK(profile_refusal(text).starts_with(line));
}

} // namespace

TEST_CASE("every shipped profile loads and names every key") {
    const std::filesystem::path folder = std::string(FJELL_SOURCE_DIR) + "/profiles";
    int profiles = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
        if (file.path().extension() != ".toml") continue;
        ++profiles;
        const Profile p = read_profile(file.path().string());
        CHECK(p.refine.max_error_px > 0);
        CHECK(p.method == Method::incremental);
        CHECK(p.cut_budget.triangles >= 2 * p.cut_budget.vertices);
        CHECK(p.cut_budget.vertices == p.budget.vertices);
        const std::vector<std::byte> bytes = io::read_file(file.path().string());
        const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        for (const char* key : {"method",
                                "max_error_px",
                                "corner_safe",
                                "hysteresis",
                                "offscreen_factor",
                                "morph",
                                "morph_s",
                                "metric",
                                "cull",
                                "topology",
                                "vertices",
                                "triangles",
                                "views",
                                "workers",
                                "max_work",
                                "max_time_us",
                                "indices",
                                "width_px",
                                "height_px",
                                "fov_deg",
                                "page_slots",
                                "page_requests",
                                "map_requests",
                                "decoders",
                                "map_mb",
                                "tail_log2",
                                "texel_px",
                                "lookahead_s",
                                "fade_s",
                                "pages",
                                "tests",
                                "map_kb",
                                "samples",
                                "sun",
                                "azimuth_deg",
                                "elevation_deg",
                                "latitude_deg",
                                "longitude_deg",
                                "year",
                                "month",
                                "day",
                                "hour_utc",
                                "air",
                                "visibility_km",
                                "exposure",
                                "ev100",
                                "exposure_bias_ev",
                                "tone_curve",
                                "dither",
                                "detail",
                                "shadows",
                                "water",
                                "water_level_m"}) {
            INFO(file.path() << ' ' << key);
            std::string line = "\n"; // by +=: g++ 12 warns of an impossible overlap in +
            line += key;
            line += " = ";
            CHECK(text.find(line) != std::string_view::npos);
        }
    }
    CHECK(profiles == 4);
    const Profile tiny = read_profile((folder / "tiny.toml").string());
    CHECK(tiny.budget.vertices == 4096);
    CHECK(tiny.cut.max_work == 500);
    CHECK(tiny.width_px == 320);
}

TEST_CASE("an empty profile is the defaults, and every key changes its own field") {
    const Profile d = parse_profile("", "p.toml");
    CHECK(d.refine.max_error_px == RefineSettings{}.max_error_px);
    CHECK(d.budget.vertices == RecursiveBudget{}.vertices);
    CHECK(d.method == Method::incremental);
    CHECK(d.cut_budget.vertices == CutBudget{}.vertices);
    CHECK(d.cut_budget.triangles == CutBudget{}.triangles);
    CHECK(d.cut.max_work == unlimited_work);
    CHECK(d.cut.max_time_us == 0);
    CHECK(d.cut.morph == Morph::none);
    const Profile p = parse_profile(
        "[refine]\nmethod = \"recursive\"\nmax_error_px = 3\nmetric = \"depth\"\ncull = true\ncorner_safe = true\n"
        "topology = \"strip\"\n[budget]\nvertices = 1_000\nindices = 9_000\n"
        "[view]\nwidth_px = 640\nheight_px = 480\nfov_deg = 60.5\n",
        "p.toml");
    CHECK(p.method == Method::recursive);
    CHECK(p.refine.max_error_px == 3);
    CHECK(p.refine.metric == Metric::depth);
    CHECK(p.refine.corner_safe);
    CHECK(p.refine.topology == Topology::strip);
    CHECK(p.budget.vertices == 1000);
    CHECK(p.budget.indices == 9000);
    CHECK(p.width_px == 640);
    CHECK(p.height_px == 480);
    CHECK(p.fov_deg == 60.5);
    CHECK_FALSE(parse_profile("[refine]\ncull = false\n", "p.toml").refine.cull);
    const Profile q = parse_profile(
        "[refine]\nmethod = \"incremental\"\nmax_error_px = 3\ncorner_safe = true\nhysteresis = 0.5\nmorph = \"time\"\n"
        "offscreen_factor = 6\nmorph_s = 2\n[budget]\nvertices = 1_000\ntriangles = 2_000\nviews = 3\nworkers = "
        "6\nmax_work = "
        "400\nmax_time_us = 99.5\n",
        "p.toml");
    CHECK(q.method == Method::incremental);
    CHECK(q.cut_budget.vertices == 1000);
    CHECK(q.cut_budget.triangles == 2000);
    CHECK(q.cut_budget.views == 3);
    CHECK(q.cut_budget.workers == 6);
    const CutSettings settings = cut_settings(q, 1.5);
    CHECK(settings.max_error_px == 3);
    CHECK(settings.corner_safe);
    CHECK(settings.hysteresis == 0.5);
    CHECK(settings.offscreen_factor == 6);
    CHECK(settings.morph == Morph::time);
    CHECK(settings.morph_s == 2);
    CHECK(settings.max_work == 400);
    CHECK(settings.max_time_us == 99.5);
    CHECK(settings.now_s == 1.5);
    CHECK(parse_profile("[refine]\nmorph = \"error\"\n", "p.toml").cut.morph == Morph::error);
    CHECK(parse_profile("[budget]\nmax_work = 0\n", "p.toml").cut.max_work == unlimited_work);
    CHECK(d.stream_budget.map_bytes == StreamBudget{}.map_bytes);
    CHECK(d.stream.map_bytes == StreamSettings{}.map_bytes);
    const Profile s = parse_profile(
        "[stream]\npage_slots = 77\npage_requests = 3\nmap_requests = 4\nmap_mb = 65536\ntail_log2 = 5\ndecoders = 3\n"
        "texel_px = 2.5\nlookahead_s = 0\nfade_s = 1.5\npages = 6\ntests = 70000\nmap_kb = 9\n",
        "p.toml");
    CHECK(s.page_slots == 77);
    CHECK(s.stream_budget.page_requests == 3);
    CHECK(s.stream_budget.map_requests == 4);
    CHECK(s.stream_budget.map_bytes == std::uint64_t{1} << 36);
    CHECK(s.stream_budget.tail_log2 == 5);
    CHECK(s.stream_budget.decoders == 3);
    const StreamSettings stream = stream_settings(s, 2.5);
    CHECK(stream.texel_px == 2.5);
    CHECK(stream.lookahead_s == 0);
    CHECK(stream.fade_s == 1.5);
    CHECK(stream.pages == 6);
    CHECK(stream.tests == 70000);
    CHECK(stream.map_bytes == 9 * 1024);
    CHECK(stream.now_s == 2.5);
    const Profile l = parse_profile(
        "[view]\nsamples = 2\n[light]\nsun = \"time\"\nlatitude_deg = -41.5\nlongitude_deg = 174\nyear = 2030\nmonth = "
        "2\n"
        "day = 3\nhour_utc = 4.5\nair = \"simple\"\nvisibility_km = 30\nexposure = \"fixed\"\nev100 = 12\n"
        "exposure_bias_ev = -1\ntone_curve = \"none\"\ndither = false\ndetail = false\nshadows = false\nwater = "
        "true\nwater_level_m = "
        "7.5\n"
        "azimuth_deg = 1\nelevation_deg = 2\n"
        "[layers]\non = false\nsplat = false\ndistance_m = 900\ntint = 0.25\nrelief = 2\nmaterial_mb = 5\n",
        "p.toml");
    CHECK_FALSE(l.layers.on);
    CHECK_FALSE(l.layers.splat);
    CHECK(l.layers.distance_m == 900);
    CHECK(l.layers.tint == 0.25);
    CHECK(l.layers.relief == 2);
    CHECK(l.material_bytes == 5u << 20);
    CHECK(l.samples == 2);
    CHECK(l.light.sun == gl::SunBy::time);
    CHECK(l.light.latitude_deg == -41.5);
    CHECK(l.light.longitude_deg == 174);
    CHECK(l.light.year == 2030);
    CHECK(l.light.month == 2);
    CHECK(l.light.day == 3);
    CHECK(l.light.hour_utc == 4.5);
    CHECK(l.light.air == gl::Air::simple);
    CHECK(l.light.visibility_km == 30);
    CHECK(l.light.exposure == gl::Exposure::fixed);
    CHECK(l.light.ev100 == 12);
    CHECK(l.light.exposure_bias_ev == -1);
    CHECK(l.light.tone_curve == gl::ToneCurve::none);
    CHECK_FALSE(l.light.dither);
    CHECK_FALSE(l.light.detail);
    CHECK_FALSE(l.light.shadows);
    CHECK(l.light.water);
    CHECK(l.light.water_level_m == 7.5);
    CHECK(l.light.azimuth_deg == 1);
    CHECK(l.light.elevation_deg == 2);
}

TEST_CASE("keys are read by the names that they had before 0.3, and a line each names the new one") {
    std::vector<std::string> renamed;
    const Profile p = parse_profile("[refine]\nerror_px = 3\n[budget]\nitems = 40\nbudget_us = 99.5\n[layers]\n"
                                    "control = false\n",
                                    "p.toml", &renamed);
    CHECK(p.refine.max_error_px == 3);
    CHECK(p.cut.max_work == 40);
    CHECK(p.cut.max_time_us == 99.5);
    CHECK_FALSE(p.layers.splat);
    CHECK(std::set<std::string>(renamed.begin(), renamed.end()) ==
          std::set<std::string>{
              "p.toml:2: refine.error_px is called refine.max_error_px now, and read by its old name until 0.4",
              "p.toml:4: budget.items is called budget.max_work now, and read by its old name until 0.4",
              "p.toml:5: budget.budget_us is called budget.max_time_us now, and read by its old name until 0.4",
              "p.toml:7: layers.control is called layers.splat now, and read by its old name until 0.4"});
    renamed.clear();
    (void)parse_profile(profile_text(p, ""), "p.toml", &renamed); // written by its new ones
    CHECK(renamed.empty());
    refuses("[refine]\nmax_error_px = 1\nerror_px = 2\n",
            "p.toml:3: refine.error_px: is now max_error_px, which is there too");
}

TEST_CASE("a bad profile is refused in one line with file, line and key") {
    refuses("[refine]\n\nerror_pixels = 1\n",
            "p.toml:3: refine.error_pixels: unknown key; [refine] has method, max_error_px");
    refuses("[budgets]\nvertices = 5000\n", "p.toml:1: budgets: unknown table");
    refuses("max_error_px = 1\n", "p.toml:1: max_error_px: unknown table");
    refuses("refine = 1\n", "p.toml:1: refine: must be a table");
    refuses("[refine]\nmax_error_px = 0\n", "p.toml:2: refine.max_error_px: must be a number from 0.01 to 1000");
    refuses("[refine]\nmax_error_px = nan\n", "p.toml:2: refine.max_error_px: must be a number");
    refuses("[refine]\nmax_error_px = inf\n", "p.toml:2: refine.max_error_px: must be a number");
    refuses("[refine]\nmax_error_px = \"1\"\n", "p.toml:2: refine.max_error_px: must be a number");
    refuses("[refine]\nmetric = \"manhattan\"\n", "p.toml:2: refine.metric: must be \"isotropic\" or \"depth\"");
    refuses("[refine]\ncull = 1\n", "p.toml:2: refine.cull: must be true or false");
    refuses("[refine]\nmethod = \"magic\"\n", "p.toml:2: refine.method: must be \"incremental\" or \"recursive\"");
    refuses("[refine]\nmorph = true\n", "p.toml:2: refine.morph: must be \"none\" or \"error\" or \"time\"");
    refuses("[refine]\nmorph_s = 0\n", "p.toml:2: refine.morph_s: must be a number from 0.01 to 10 (seconds)");
    refuses("[refine]\nhysteresis = -0.1\n", "p.toml:2: refine.hysteresis: must be a number from 0 to 10");
    refuses("[refine]\noffscreen_factor = 0.5\n", "p.toml:2: refine.offscreen_factor: must be a number from 1 to 100");
    refuses("[budget]\nviews = 9\n", "p.toml:2: budget.views: must be a whole number from 1 to 8");
    refuses("[budget]\nmax_work = 4294967295\n",
            "p.toml:2: budget.max_work: must be a whole number from 0 to 4294967294");
    refuses("[budget]\nmax_time_us = -1\n", "p.toml:2: budget.max_time_us: must be a number from 0 to");
    refuses("[budget]\ntriangles = 0\n", "p.toml:2: budget.triangles: must be a whole number from 16");
    refuses("[budget]\nvertices = -1\n", "p.toml:2: budget.vertices: must be a whole number from 16");
    refuses("[budget]\nvertices = 1e6\n", "p.toml:2: budget.vertices: must be a whole number");
    refuses("[budget]\nindices = 99999999999\n", "p.toml:2: budget.indices: must be a whole number");
    refuses("[stream]\nslots = 1\n", "p.toml:2: stream.slots: unknown key; [stream] has page_slots, page_requests");
    refuses("[stream]\npage_slots = 0\n", "p.toml:2: stream.page_slots: must be a whole number from 1 to");
    refuses("[stream]\npage_requests = 257\n", "p.toml:2: stream.page_requests: must be a whole number from 1 to 256");
    refuses("[stream]\nmap_mb = 0\n", "p.toml:2: stream.map_mb: must be a whole number from 1 to 65536");
    refuses("[stream]\nmap_kb = 1.5\n", "p.toml:2: stream.map_kb: must be a whole number");
    refuses("[stream]\ntail_log2 = 13\n", "p.toml:2: stream.tail_log2: must be a whole number from 2 to 12");
    refuses("[stream]\ntexel_px = 0\n", "p.toml:2: stream.texel_px: must be a number from 0.1 to 100 (pixels)");
    refuses("[stream]\ntests = 3\n", "p.toml:2: stream.tests: must be a whole number from 1024");
    refuses("[view]\nwidth_px = 0\n", "p.toml:2: view.width_px: must be a whole number from 1 to 16384");
    refuses("[view]\nfov_deg = 180\n", "p.toml:2: view.fov_deg: must be a number from 1 to 150");
    refuses("[view]\nsamples = 0\n", "p.toml:2: view.samples: must be a whole number from 1 to 16");
    refuses("[light]\nair = \"thick\"\n", "p.toml:2: light.air: must be \"simple\" or \"physical\"");
    refuses("[layers]\ntint = 2\n", "p.toml:2: layers.tint: must be a number from 0 to 1");
    refuses("[light]\nvisibility_km = 0\n", "p.toml:2: light.visibility_km: must be a number from 1 to 280");
    refuses("[refine]\nmax_error_px = \n", "p.toml:2: is not TOML");
    refuses("[refine]\nmax_error_px = 1\nmax_error_px = 2\n", "p.toml:3: a key or a table is there twice");
    refuses("[refine]\nmetric = \"depth\"\ncull = false\n", "p.toml: refine.metric \"depth\" needs refine.cull = true");
    CHECK_THROWS_AS(read_profile("/nowhere/p.toml"), io::Failure);
    CHECK_THROWS_AS(read_profile("/"), io::Failure);
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
    a.vertices = 5;
    a.exhausted = exhausted_vertices | exhausted_indices;
    a.error_px_requested = 1;
    a.error_bound_px = 1.5;
    FrameEntry b;
    b.converged = b.settled = true;
    b.verified_px = 0.25;
    b.items = 7;
    b.exhausted = exhausted_triangles | exhausted_items | exhausted_time;
    b.upload_bytes = 40;
    b.stream_us = 4.5;
    b.stream.pages_inserted = 3;
    b.stream.failed = 1;
    b.stream.page_slots.used = 9;
    b.stream.in_flight = 2;
    b.stream.bytes_read = 1000;
    b.stream.missing_mips = 0.5;
    b.stream.converged = true;
    b.missing_px = 2.5;
    b.at_s = 0.25;
    log.frames = {a, b};
    CHECK(csv(log) == "frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,"
                      "converged,verified_px,items,evaluations,activations,deactivations,waiting,blocked,rising,"
                      "triangles_drawn,rebuilt,bytes_uploaded,prepare_us,refine_us,output_us,stream_us,pages_taken,"
                      "pages_left,pages_wanted,pages_draining,pages_failed,page_slots,mips_taken,mips_left,requested,"
                      "bytes_read,map_upload_bytes,missing_px,missing_mips,stream_converged,polls,at_s\n"
                      "0,12.3,5,0,0,0,1,1.5,vertices+indices,0,,0,0,0,0,0,0,0,0,0,0,0.0,0.0,0.0,"
                      "0.0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1,0.0000\n"
                      "1,0.0,0,0,0,0,0,0,triangles+items+time,1,0.25,7,0,0,0,0,0,0,0,0,40,0.0,0.0,0.0,"
                      "4.5,3,0,0,0,1,9,0,0,2,1000,0,2.5,0.5,1,1,0.2500\n");
    const Summary s = summarise(log, true);
    CHECK(s.converged == 1);
    CHECK(s.verified == 1);
    CHECK(s.effective_px_max == 1.5);
    CHECK(s.ns_per_vertex == Approx(12340.0 / 5));
}

TEST_CASE("a frame built from nothing is told apart from those that follow it") {
    FlightLog log;
    FrameEntry first, second, third;
    first.rebuilt = true;
    first.update_us = 9000;
    first.items = 1000000;
    first.activations = 1000;
    first.upload_bytes = 1 << 20;
    log.frames = {first};
    CHECK(summarise(log, true).update_us.max == 9000);
    second.update_us = 10;
    second.items = second.item_limit = 40;
    second.activations = 3;
    second.deactivations = 1;
    second.upload_bytes = 100;
    third.update_us = 20;
    third.items = 41;
    third.item_limit = 40;
    third.verified_px = 7; // lags: promises nothing
    log.frames = {first, second, third};
    const Summary s = summarise(log, true);
    CHECK(s.rebuilt == 1);
    CHECK(s.rebuild_us == 9000);
    CHECK(s.rebuild_bytes == 1 << 20);
    CHECK(s.update_us.max == 20);
    CHECK(s.update_us_mean == 15);
    CHECK(s.activations_mean == 1.5);
    CHECK(s.upload_mean == 50);
    CHECK(s.items_max == 41);
    CHECK(s.overruns == 1);
    CHECK(s.verified == 0);
    CHECK_FALSE(s.verified_px_max);
    CHECK(s.verified_lagging_px_max == 7);
}

TEST_CASE("a streamed flight is summed up apart, and knows when its first whole picture was there") {
    const auto frame = [](double at_s, bool coarse, bool pages, bool maps) {
        CutReport cut;
        cut.converged = true;
        FrameEntry f = entry_of(cut, {});
        StreamReport r;
        r.complete = coarse;
        r.converged = pages;
        r.maps_converged = maps;
        r.pages_inserted = 2;
        r.pages_read = static_cast<std::uint64_t>(at_s * 10);
        r.missing_px = pages ? 0 : 8;
        r.update_us = 30;
        r.exhausted = stream_page_slots | stream_requests;
        add_stream(f, r);
        f.at_s = at_s;
        return f;
    };
    FlightLog log;
    log.frames = {frame(1, false, false, false), frame(2, true, false, true), frame(3, true, true, false),
                  frame(4, true, true, true)};
    const Summary s = summarise(log, true);
    CHECK(s.converged == 2); // a mesh that lacks pages has not converged
    CHECK(s.stream.streamed);
    CHECK(s.stream.coarse_s == 2.0);
    CHECK(s.stream.picture_s == 4.0);
    CHECK(s.stream.picture_frame == std::size_t{3});
    CHECK(s.stream.converged == 2);
    CHECK(s.stream.maps_converged == 2);
    CHECK(s.stream.pages_inserted == 8);
    CHECK(s.stream.last.pages_read == 40);
    CHECK(s.stream.missing_px_max == 8);
    CHECK(s.stream.update_us.max == 30);
    CHECK(budget_names(s.exhausted) == std::vector<std::string>{"page_slots", "stream_requests"});
    CHECK(summary_json(s)["pages_loaded"] == 40);
    CHECK(summary_json(s)["stream"]["first_picture_s"] == 4.0);
    log.frames.resize(1);
    CHECK(summary_json(summarise(log, true))["stream"]["first_picture_s"].is_null());
    CHECK(summary_json(summarise({{FrameEntry{}}}, true))["stream"].is_null());
}

TEST_CASE("a frame that waited has the work of all its updates and the state of the last") {
    FrameEntry frame, poll;
    frame.items = 5;
    frame.item_limit = poll.item_limit = 6;
    frame.update_us = 10;
    frame.upload_bytes = 100;
    frame.stream.pages_inserted = 2;
    frame.stream.map_upload_bytes = 1000;
    frame.missing_px = 7;
    frame.exhausted = exhausted_items;
    poll.items = 6;
    poll.update_us = 20;
    poll.upload_bytes = 10;
    poll.converged = true;
    poll.stream.pages_inserted = 3;
    poll.stream.pages_read = 5;
    poll.vertices = 77;
    add_poll(frame, poll);
    add_poll(frame, FrameEntry{});
    CHECK(frame.polls == 3);
    CHECK(frame.items == 11);
    CHECK(frame.item_limit == unlimited_work); // the third had no limit
    CHECK(frame.update_us == 30);
    CHECK(frame.upload_bytes == 110);
    CHECK(frame.stream.pages_inserted == 5);
    CHECK(frame.stream.map_upload_bytes == 1000);
    CHECK(frame.stream.pages_read == 0);
    CHECK(frame.vertices == 0);
    CHECK_FALSE(frame.converged);
    CHECK(frame.missing_px == 0);
    CHECK(frame.exhausted == exhausted_items);
}

TEST_CASE("each method's exhausted capacities keep their names") {
    FrameReport recursive;
    recursive.exhausted = budget_vertices | budget_indices;
    CHECK(budget_names(entry_of(recursive).exhausted) == std::vector<std::string>{"vertices", "indices"});
    CutReport cut;
    cut.exhausted = cut_budget_vertices | cut_budget_triangles | cut_budget_work | cut_budget_time;
    CHECK(budget_names(entry_of(cut, {}).exhausted) ==
          std::vector<std::string>{"vertices", "triangles", "items", "time"});
    cut.exhausted = cut_budget_triangles;
    CHECK(budget_names(entry_of(cut, {}).exhausted) == std::vector<std::string>{"triangles"});
}
