// Recordings as files: what is written is read back, and what is not a recording is refused with the line.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <sstream>

#include "fjell/io/failure.h"
#include "flight/record.h"

using namespace fjell;
using namespace fjell::flight;

namespace {

Recording random_recording(std::mt19937_64& random) {
    const auto real = [&] { return std::uniform_real_distribution<double>(-1e6, 1e6)(random) / 3; };
    Recording r;
    r.pack_hash = random();
    r.budget.vertices = static_cast<std::uint32_t>(random() % 1000000);
    r.page_slots = static_cast<std::uint32_t>(random());
    for (int frame = 0; frame < 5; ++frame) {
        RecordedFrame f;
        f.views.resize(static_cast<std::size_t>(1 + frame % 3));
        for (View& v : f.views) {
            v.eye_m = {real(), real(), real()};
            v.forward = {real(), real(), real()};
            v.left = real(), v.right = real(), v.bottom = real(), v.top = real();
        }
        f.settings.error_px = real();
        f.settings.items = static_cast<std::uint32_t>(random());
        f.settings.visits = static_cast<std::uint32_t>(random());
        f.settings.morph = static_cast<Morph>(frame % 3);
        f.settings.now_s = real();
        f.rebuild = frame == 0;
        f.mesh_hash = random();
        for (std::size_t n = random() % 4; n > 0; --n)
            f.pages.push_back({static_cast<std::uint32_t>(random()), static_cast<std::uint32_t>(random() % 100),
                               static_cast<PageEvent>(random() % 4)});
        f.missing_px = real();
        r.frames.push_back(f);
    }
    return r;
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
        REQUIRE(back.frames.size() == r.frames.size());
        for (std::size_t i = 0; i < r.frames.size(); ++i) {
            CHECK(back.frames[i].mesh_hash == r.frames[i].mesh_hash);
            CHECK(back.frames[i].settings.items == r.frames[i].settings.items);
            CHECK(back.frames[i].settings.visits == r.frames[i].settings.visits);
            CHECK(back.frames[i].settings.morph == r.frames[i].settings.morph);
            CHECK(back.frames[i].settings.error_px == r.frames[i].settings.error_px);
            CHECK(back.frames[i].missing_px == r.frames[i].missing_px);
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
        text.replace(text.find("\"version\":3"), 11, "\"version\":2");
        const std::size_t views = text.rfind("\"views\":[[");
        text.replace(views, text.find("]]", views) + 2 - views, view.str());
        const View back = parse_recording(text, "r.json").frames[0].views[0];
        REQUIRE(lambda_px(back) == lambda);
        REQUIRE((back.width_px == width && back.far_m == 1e6));
        const double half_height = height / (2 * lambda); // as version 2 had it
        REQUIRE((back.bottom == -back.top && back.left == -back.right));
        REQUIRE(back.right == back.top * width / height);
        other_frustum += back.top != half_height;
        REQUIRE(std::abs(back.top - half_height) <= half_height * 0x1p-52);
    }
    CHECK(other_frustum < 600); // by one bit, where no number gives both
}

TEST_CASE("what is not a recording is refused with the line and what to do") {
    std::mt19937_64 random(2);
    const std::string text = write_recording(random_recording(random));
    CHECK(recording_refusal("").find("no frames") != std::string::npos);
    CHECK(recording_refusal("{}\n").find("r.json:1: not a recording") == 0);
    CHECK(recording_refusal(text.substr(0, text.size() - 1)).find("r.json:6: the recording ends in the middle") == 0);
    CHECK(recording_refusal(text + "[]\n").find("r.json:7: not a recording") == 0);
    std::string later = text;
    later.replace(later.find("\"version\":3"), 11, "\"version\":4");
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
