// Recordings: what is written is read back, what is not a recording is refused with the line, and what was recorded
// is repeated, whatever happened.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>

#include "fjell/io/failure.h"
#include "session/record.h"
#include "shared/terrain_data.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::session;
using namespace fjell::test;

namespace {

Recording random_recording(std::mt19937_64& random) {
    const auto real = [&] { return std::uniform_real_distribution<double>(-1e6, 1e6)(random) / 3; };
    Recording r;
    r.pack_hash = random();
    r.budget.vertices = static_cast<std::uint32_t>(random() % 1000000);
    r.page_slots = static_cast<std::uint32_t>(random());
    r.edits = EditBudget{7, 8, 9};
    for (int frame = 0; frame < 5; ++frame) {
        RecordedFrame f;
        f.views.resize(static_cast<std::size_t>(1 + frame % 3));
        for (View& v : f.views) {
            v.eye_m = {real(), real(), real()};
            v.forward = {real(), real(), real()};
            v.left = real(), v.right = real(), v.bottom = real(), v.top = real();
        }
        f.settings.max_error_px = real();
        f.settings.max_work = static_cast<std::uint32_t>(random());
        f.settings.visits = static_cast<std::uint32_t>(random());
        f.settings.morph = static_cast<Morph>(frame % 3);
        f.settings.now_s = real();
        f.rebuild = frame == 0;
        f.mesh_hash = random();
        for (std::size_t n = random() % 4; n > 0; --n)
            f.pages.push_back({static_cast<std::uint32_t>(random()), static_cast<std::uint32_t>(random() % 100),
                               static_cast<PageEvent>(random() % 4)});
        f.missing_px = real();
        if (frame % 2 == 1) { // of every kind of field
            io::KeptStamp noise, road, heights;
            noise.plain.shape = StampShape::noise, noise.plain.x_m = real(), noise.plain.z_m = real();
            noise.plain.radius_m = noise.plain.wavelength_m = static_cast<float>(std::abs(real()) + 1);
            noise.plain.amount_m = static_cast<float>(real()), noise.plain.seed = static_cast<std::uint32_t>(random());
            road.plain.shape = StampShape::path, road.plain.radius_m = 3;
            for (int n = 0; n < 3; ++n) road.points.push_back({real(), real(), static_cast<float>(real())});
            heights.plain.shape = StampShape::heights, heights.plain.first = {-3, 8};
            heights.plain.columns = 2, heights.plain.rows = 1;
            heights.heights_m = {static_cast<float>(real()), std::numeric_limits<float>::quiet_NaN()};
            heights.mask = {0, 200};
            f.stamps = {noise, road, heights};
        }
        r.frames.push_back(f);
    }
    return r;
}

// What a host sees of a frame, beyond the mesh that a recording names: what it uploads and what it is told.
struct Seen {
    std::vector<MorphVertex> morph;
    MorphFrame frame;
    CutReport report;
};

Seen seen(Cut& cut, const CutReport& report) {
    const CutMesh mesh = cut_mesh(cut.cut);
    return {{mesh.morph.begin(), mesh.morph.end()}, mesh.frame, report};
}

bool alike(const Seen& a, const Seen& b) {
    const CutReport &r = a.report, &q = b.report;
    bool same = a.morph.size() == b.morph.size() && a.frame.views == b.frame.views && a.frame.now_s == b.frame.now_s &&
                std::memcmp(a.morph.data(), b.morph.data(), a.morph.size() * sizeof(MorphVertex)) == 0;
    for (std::uint32_t i = 0; i < a.frame.views; ++i)
        same = same && std::memcmp(&a.frame.view[i], &b.frame.view[i], sizeof(MorphView)) == 0;
    return same && r.work == q.work && r.visits == q.visits && r.activations == q.activations &&
           r.deactivations == q.deactivations && r.waiting == q.waiting && r.blocked == q.blocked &&
           r.morphing == q.morphing && r.error_bound_px == q.error_bound_px && r.converged == q.converged &&
           r.vertices_changed == q.vertices_changed && r.triangles_changed == q.triangles_changed;
}

// Anything that a host may change from frame to frame, often changed.
void change_settings(Random& random, CutSettings& s) {
    if (pick(random, 0, 9) == 0) s.max_error_px = std::pow(10.0, uniform(random, -0.3, 1.5));
    if (pick(random, 0, 19) == 0) s.morph = static_cast<Morph>(pick(random, 0, 2));
    if (pick(random, 0, 19) == 0) s.morph_s = uniform(random, 0.02, 0.5);
    if (pick(random, 0, 19) == 0) s.hysteresis = pick(random, 0, 1) * 0.3;
    if (pick(random, 0, 19) == 0) s.corner_safe = !s.corner_safe;
    if (pick(random, 0, 19) == 0) s.offscreen_factor = pick(random, 0, 1) ? 1 : uniform(random, 1, 20);
    if (pick(random, 0, 9) == 0) s.max_work = pick(random, 0, 1) ? unlimited_work : std::uint32_t(pick(random, 0, 600));
    if (pick(random, 0, 9) == 0) s.max_time_us = pick(random, 0, 1) ? 0 : uniform(random, 0.1, 60);
    s.now_s += pick(random, 0, 29) ? 1.0 / 60 : uniform(random, -5, 900);
}

// Cameras come, go and jump; some have a threshold of their own.
void change_views(Random& random, const Terrain& terrain, std::size_t most, std::vector<View>& views) {
    for (View& v : views) v = moved(random, v, terrain.spacing_x_m());
    const int what = pick(random, 0, 19);
    if (views.empty() || (what == 0 && views.size() < most)) views.push_back(random_view(random, terrain));
    if (what == 1 && views.size() > 1) views.erase(views.begin());
    if (what == 2) views.front() = random_view(random, terrain);
    if (what == 3) views.back().max_error_px = pick(random, 0, 1) * uniform(random, 0.5, 20);
}

struct RecordedRun {
    Recording recording;
    std::vector<Seen> frames;
    std::uint64_t pages = 0;
};

// A host with a client that is late, wrong or silent, a clock that jumps, and budgets that do not suffice.
RecordedRun run_recorded(Random& random, const Pack& pack, const CutBudget& budget, std::uint32_t slots, int frames) {
    Streamed on(pack, budget, slots, {.page_requests = 8, .map_requests = 1});
    ClientScript script{.fails = 0.02, .garbage = 0.02, .short_reads = 0.02, .never = 0.002, .most_delay = 4};
    ScriptedClient client(random, on, script);
    RecordedRun run;
    run.recording = {pack.header.directory_hash, budget, slots, {}};
    CutSettings settings;
    std::vector<View> views;
    for (int frame = 0; frame < frames; ++frame) {
        change_settings(random, settings);
        change_views(random, on.paged.terrain, budget.views, views);
        client.act();
        (void)on.update(views, settings, {.now_s = settings.now_s});
        client.follow();
        const bool rebuild = pick(random, 0, 29) == 0;
        CutReport report;
        REQUIRE((rebuild ? rebuild_cut : update_cut)(on.cut.cut, views, settings, report).ok());
        RecordedFrame recorded_frame = recorded(views, settings, report, cut_mesh(on.cut.cut).mesh);
        recorded_frame.missing_px = on.paged.terrain.missing_px();
        const auto pages = stream_page_arrivals(on.stream);
        recorded_frame.pages.assign(pages.begin(), pages.end());
        run.pages += pages.size();
        run.recording.frames.push_back(std::move(recorded_frame));
        run.frames.push_back(seen(on.cut, report));
    }
    return run;
}

std::string recording_refusal(const std::string& text) {
    try {
        (void)parse_recording(text, "r.json");
    } catch (const io::Failure& f) {
        return f.what();
    }
    return {};
}

} // namespace

TEST_CASE("a recording is read back bit for bit") {
    std::mt19937_64 random(1);
    for (int round = 0; round < 50; ++round) {
        const Recording r = random_recording(random);
        const std::string text = write_recording(r);
        const Recording back = parse_recording(text, "r.json");
        CHECK(write_recording(back) == text);
        CHECK(back.page_slots == r.page_slots);
        REQUIRE(back.edits);
        CHECK((back.edits->blocks == 7 && back.edits->stamps == 8 && back.edits->areas == 9));
        REQUIRE(back.frames.size() == r.frames.size());
        for (std::size_t i = 0; i < r.frames.size(); ++i) {
            CHECK(back.frames[i].mesh_hash == r.frames[i].mesh_hash);
            CHECK(back.frames[i].settings.max_work == r.frames[i].settings.max_work);
            CHECK(back.frames[i].settings.visits == r.frames[i].settings.visits);
            CHECK(back.frames[i].settings.morph == r.frames[i].settings.morph);
            CHECK(back.frames[i].settings.max_error_px == r.frames[i].settings.max_error_px);
            CHECK(back.frames[i].missing_px == r.frames[i].missing_px);
            REQUIRE(back.frames[i].stamps.size() == r.frames[i].stamps.size());
            if (!r.frames[i].stamps.empty()) {
                const Stamp noise = back.frames[i].stamps[0].stamp(), heights = back.frames[i].stamps[2].stamp();
                CHECK(noise.x_m == r.frames[i].stamps[0].plain.x_m);
                CHECK(noise.amount_m == r.frames[i].stamps[0].plain.amount_m);
                CHECK(back.frames[i].stamps[1].points[2].height_m == r.frames[i].stamps[1].points[2].height_m);
                CHECK((heights.heights_m[0] == r.frames[i].stamps[2].heights_m[0] && std::isnan(heights.heights_m[1])));
            }
            REQUIRE(back.frames[i].pages.size() == r.frames[i].pages.size());
            for (std::size_t p = 0; p < r.frames[i].pages.size(); ++p) {
                CHECK(back.frames[i].pages[p].tile == r.frames[i].pages[p].tile);
                CHECK(back.frames[i].pages[p].page == r.frames[i].pages[p].page);
                CHECK(back.frames[i].pages[p].event == r.frames[i].pages[p].event);
            }
            REQUIRE(back.frames[i].views.size() == r.frames[i].views.size());
            CHECK(back.frames[i].views.back().eye_m.y == r.frames[i].views.back().eye_m.y);
            for (const auto side : {&View::left, &View::right, &View::bottom, &View::top})
                CHECK(back.frames[i].views.back().*side == r.frames[i].views.back().*side);
        }
    }
}

TEST_CASE(
    "a recording of version 2, which had lambda instead of sides, gives the same lambda and frustum, bit for bit") {
    std::mt19937_64 random(3);
    const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    Recording r;
    r.frames.resize(1);
    r.frames[0].views.resize(1);
    const std::string now = write_recording(r);
    int other_frustum = 0;
    for (int round = 0; round < 3000; ++round) {
        const auto width = static_cast<std::uint32_t>(random() % 4000 + 1),
                   height = static_cast<std::uint32_t>(random() % 4000 + 1);
        const double fov = between(0.01, 3), lambda = height / (2 * std::tan(fov / 2));
        std::ostringstream view;
        view.precision(17);
        view << "\"views\":[[1.0,2.0,3.0,0.0,0.0,-1.0,0.0,1.0,0.0," << fov << ',' << width << ',' << height
             << ",1.0,1000000.0," << lambda << "]]";
        std::string text = now;
        text.replace(text.find("\"version\":4"), 11, "\"version\":2");
        const std::size_t views = text.rfind("\"views\":[[");
        text.replace(views, text.find("]]", views) + 2 - views, view.str());
        const View back = parse_recording(text, "r.json").frames[0].views[0];
        REQUIRE(focal_length_px(back) == lambda);
        REQUIRE((back.width_px == width && back.far_m == 1e6));
        const double half_height = height / (2 * lambda); // as version 2 had it
        REQUIRE((back.bottom == -back.top && back.left == -back.right));
        REQUIRE(back.right == back.top * width / height);
        other_frustum += back.top != half_height;
        REQUIRE(std::abs(back.top - half_height) <= half_height * 0x1p-52);
    }
    CHECK(other_frustum < 600); // by one bit, where no number gives both
}

TEST_CASE("a streamed run is repeated bit for bit, whatever its views, clock, budgets, morphing, failing pages and "
          "evictions") {
    Random random(2611);
    std::uint64_t pages = 0, capped = 0, timed = 0, several = 0;
    for (int round = 0; round < rounds(7, 200); ++round) {
        const auto pack = bake_and_load(random_dem(random, 400, 300, Shape::fractal), small_bake(7));
        const std::uint32_t tiles = pack.terrain.tile_count();
        const CutBudget budget{.vertices = static_cast<std::uint32_t>(pick(random, 600, 20'000)),
                               .triangles = static_cast<std::uint32_t>(pick(random, 1500, 40'000)),
                               .segment_triangles = 32,
                               .views = static_cast<std::uint32_t>(pick(random, 1, 3))};
        const auto slots =
            static_cast<std::uint32_t>(pick(random, static_cast<int>(tiles) + 2, static_cast<int>(tiles) * 6));
        const RecordedRun run = run_recorded(random, pack.pack, budget, slots, 90);
        const Recording back = parse_recording(write_recording(run.recording), "r.json");
        PagedTerrain paged(pack.pack, {.page_slots = back.page_slots});
        Cut cut(paged.terrain, back.budget);
        for (std::size_t i = 0; i < back.frames.size(); ++i) {
            const RecordedFrame& f = back.frames[i];
            CAPTURE(round, i);
            REQUIRE(replay_pages(pack.pack, paged.terrain, cut.cut, f).ok());
            CutReport report;
            REQUIRE((f.rebuild ? rebuild_cut : update_cut)(cut.cut, f.views, f.settings, report).ok());
            REQUIRE(mesh_hash(cut_mesh(cut.cut).mesh) == f.mesh_hash);
            REQUIRE(alike(seen(cut, report), run.frames[i]));
            capped += (report.exhausted & (cut_budget_vertices | cut_budget_triangles)) != 0;
            timed += (run.frames[i].report.exhausted & cut_budget_time) != 0;
            several += f.views.size() > 1;
        }
        pages += run.pages;
    }
    CHECK((pages > 100 && capped > 10 && timed > 10 && several > 10)); // all of it has happened
}

TEST_CASE("what is not a recording is refused with the line and what to do") {
    std::mt19937_64 random(2);
    const std::string text = write_recording(random_recording(random));
    CHECK(recording_refusal("").find("no frames") != std::string::npos);
    CHECK(recording_refusal("{}\n").find("r.json:1: not a recording") == 0);
    CHECK(recording_refusal(text.substr(0, text.size() - 1)).find("r.json:6: the recording ends in the middle") == 0);
    CHECK(recording_refusal(text + "[]\n").find("r.json:7: not a recording") == 0);
    std::string later = text;
    later.replace(later.find("\"version\":4"), 11, "\"version\":5");
    CHECK(recording_refusal(later).find("r.json:1: not a recording") == 0);
    CHECK(recording_refusal("{}\n") == "r.json:1: not a recording: \"fjell\" is missing");
    const auto with = [&](const std::string& key, const std::string& value) {
        std::string changed = text;
        const std::size_t from = changed.find("\"" + key + "\":") + key.size() + 3;
        changed.replace(from, changed.find_first_of(",}", from) - from, value);
        return recording_refusal(changed);
    };
    CHECK(with("morph", "\"slow\"") == "r.json:2: not a recording: \"morph\" must be one of none, error, time");
    CHECK(with("morph", "\"none\",\"morph\":\"time\"") == "r.json:2: \"morph\" is there twice; leave one of them");
    CHECK(with("mesh", "\"12x\"").find("\"mesh\" must be a hash") != std::string::npos);
    CHECK(with("items", "-1").find("\"items\" must hold whole numbers") != std::string::npos);
    CHECK(with("rebuild", "1").find("\"rebuild\" must be true or false") != std::string::npos);
    std::string event = text;
    const std::size_t pages = event.find("\"pages\":[") + 9;
    event.insert(pages, event[pages] == ']' ? "[1,2,4]" : "[1,2,4],");
    CHECK(recording_refusal(event).find("r.json:2: not a recording") == 0);
}

TEST_CASE("a recording of version 3, which knew no stamps, is read as one of ground that stays as it is") {
    std::mt19937_64 random(5);
    Recording r = random_recording(random);
    r.edits.reset();
    for (RecordedFrame& f : r.frames) f.stamps.clear();
    std::string text = write_recording(r);
    text.replace(text.find("\"version\":4"), 11, "\"version\":3");
    for (std::size_t at = 0; (at = text.find("\"stamps\":[],")) != std::string::npos;) text.erase(at, 12);
    const Recording back = parse_recording(text, "r.json");
    CHECK(!back.edits);
    REQUIRE(back.frames.size() == r.frames.size());
    CHECK(back.frames[3].mesh_hash == r.frames[3].mesh_hash);
    CHECK(back.frames[1].stamps.empty());
}

TEST_CASE("a recording cut or changed at any byte is refused or read") {
    std::mt19937_64 random(3);
    const std::string text = write_recording(random_recording(random));
    for (std::size_t at = 0; at < text.size(); at += 7) (void)recording_refusal(text.substr(0, at));
    std::size_t refused = 0;
    for (int round = 0; round < 20'000; ++round) {
        std::string other = text;
        for (int n = static_cast<int>(random() % 3); n >= 0; --n)
            other[random() % other.size()] = static_cast<char>(random());
        refused += !recording_refusal(other).empty();
    }
    CHECK(refused > 10'000);
}
