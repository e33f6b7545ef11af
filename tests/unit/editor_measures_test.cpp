// Rings, quantiles, peaks and the histogram of levels, against the obvious ways to get them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <utility>

#include "editor/measures.h"
#include "editor/number_text.h"
#include "fjell/cut.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

// From the bounding rectangle, as the shader finds it: a square holds even levels, two squares side by side odd ones.
void count_plainly(const MeshView& mesh, int tile_log2, LevelHistogram& levels, std::uint64_t& triangles) {
    for (const TileRange& range : mesh.tiles) {
        triangles += range.triangles;
        const std::size_t step = mesh.topology == Topology::strip ? 1 : 3;
        for (std::size_t i = 0; i + 3 <= range.index_count; i += step) {
            const auto vertex = [&](std::size_t k) { return mesh.vertices[mesh.indices[range.first_index + i + k]]; };
            const MeshVertex a = vertex(0), b = vertex(1), c = vertex(2);
            const auto x = [&](const MeshVertex& v) { return v.column - a.column; };
            const auto z = [&](const MeshVertex& v) { return v.row - a.row; };
            if (x(b) * z(c) - z(b) * x(c) == 0) continue;
            const auto [left, right] = std::minmax({a.column, b.column, c.column});
            const auto [top, bottom] = std::minmax({a.row, b.row, c.row});
            const int w = right - left, h = bottom - top;
            const int halvings = tile_log2 - static_cast<int>(std::floor(std::log2(std::max(w, h))));
            ++levels.triangles[static_cast<std::size_t>(2 * halvings + (w == h ? 0 : 1))];
        }
    }
}

std::size_t calls_until_shown(Measures& measures, const MeshView& mesh, std::uint32_t tile_log2) {
    std::size_t calls = 0;
    do measures.count_levels(mesh, tile_log2);
    while (++calls < 10'000 && measures.levels().levels == 0);
    return calls;
}

void check_histogram(const MeshView& mesh, std::uint32_t tile_log2) {
    Measures measures;
    const std::size_t calls = calls_until_shown(measures, mesh, tile_log2);
    LevelHistogram plain;
    std::uint64_t triangles = 0, counted = 0;
    count_plainly(mesh, static_cast<int>(tile_log2), plain, triangles);
    for (const std::uint32_t n : measures.levels().triangles) counted += n;
    CHECK(measures.levels().triangles == plain.triangles);
    CHECK(counted == triangles); // which the method has counted itself
    CHECK(measures.levels().most == *std::max_element(plain.triangles.begin(), plain.triangles.end()));
    CHECK(calls <= mesh.indices.size() / (Measures::indices_a_call / 2) + mesh.tiles.size() / 1000 + 2);
}

} // namespace

TEST_CASE("a ring holds the last values, the oldest first") {
    for (unsigned seed = 0; seed < 5; ++seed) {
        Random random(seed);
        Ring ring;
        std::deque<float> model;
        for (int i = pick(random, 0, 1500); i > 0; --i) {
            model.push_back(static_cast<float>(uniform(random, -5, 5)));
            if (model.size() > measured_frames) model.pop_front();
            ring.push(model.back());
        }
        REQUIRE(ring.size() == model.size());
        for (std::size_t i = 0; i < model.size(); ++i) REQUIRE(ring.value(i) == model[i]);
    }
}

TEST_CASE("quantiles are the nearest ranks of what was sorted") {
    CHECK(Ring().quantiles().max == 0);
    for (unsigned seed = 0; seed < 60; ++seed) {
        Random random(seed);
        Ring ring;
        std::vector<float> all;
        for (int i = pick(random, 1, 700); i > 0; --i) {
            // Often the same value.
            all.push_back(static_cast<float>(pick(random, 0, 1) == 1 ? pick(random, 0, 3) : uniform(random, 0, 1e4)));
            ring.push(all.back());
        }
        const float last = all.back();
        if (all.size() > measured_frames) all.erase(all.begin(), all.end() - measured_frames);
        std::sort(all.begin(), all.end());
        const auto rank = [&](std::size_t percent) { return all[(percent * all.size() + 99) / 100 - 1]; };
        const Quantiles q = ring.quantiles();
        INFO("seed " << seed << ", " << all.size() << " values");
        CHECK(q.p50 == rank(50));
        CHECK(q.p99 == rank(99));
        CHECK(q.max == all.back());
        CHECK(q.last == last);
    }
}

TEST_CASE("a scale reaches to what is usual: one value in a hundred, and one of few, does not stretch it") {
    Ring ring;
    CHECK(ring.usual_most() == 0);
    ring.push(500);
    CHECK(ring.usual_most() == 500); // there is nothing else
    for (int i = 1; i <= 20; ++i) ring.push(static_cast<float>(-i));
    CHECK(ring.usual_most() == 20); // magnitudes
    for (std::size_t i = 0; i < measured_frames; ++i) ring.push(i % 100 == 7 ? 9000.0F : 3.0F);
    CHECK(ring.usual_most() == 9000); // six of 512 are more than a hundredth
    for (std::size_t i = 0; i < measured_frames; ++i) ring.push(i % 128 == 7 ? 9000.0F : 3.0F);
    CHECK(ring.usual_most() == 3);
    CHECK(ring.mean() == Approx(3 + 4 * 8997.0 / measured_frames));
    CHECK(ring.usual_most(8, 100) == 3);
    CHECK(ring.usual_most(7, 8) == 9000);
    CHECK(ring.usual_most(400, 9000) == ring.usual_most(400, measured_frames));
    CHECK(ring.usual_most(9000, 9001) == 0);
}

TEST_CASE("a frame is recorded once, and one that was built from nothing counts as none of the others") {
    Measures measures;
    session::FrameEntry entry;
    const FrameTimes times{16000, 500, 3000, 11000, 400};
    const auto record = [&](double camera_m, bool drawn) {
        measures.observe(entry);
        measures.record(times, {{0, camera_m, 0}, {}, {}}, drawn);
    };
    entry.update_us = 9000;
    entry.items = 70;
    entry.rebuilt = true;
    record(0, true);
    CHECK(measures.frames() == 1);
    CHECK(measures.last().items == 70);
    CHECK(measures.ring(Series::frame_us).size() == 0);
    CHECK(measures.peaks().update_us == 0);
    entry.rebuilt = false;
    record(0, true); // in which the driver compiles for it
    CHECK(measures.ring(Series::frame_us).size() == 0);
    entry.update_us = 800;
    record(0, true);
    CHECK(measures.ring(Series::frame_us).size() == 1);
    CHECK(measures.ring(Series::editor_us).quantiles().last == 400);
    CHECK(measures.ring(Series::draw_us).quantiles().last == 3000);
    CHECK(measures.ring(Series::other_us).quantiles().last == 16000 - 800 - 500 - 3000 - 11000 - 400);
    entry.items = 10;
    record(2, true);
    CHECK(measures.frame(0).entry.items == 10);
    CHECK(measures.frame(0).pose.position_m.y == 2);
    CHECK(measures.frame(1).entry.items == 70);
    CHECK(measures.frame(0).number == measures.recorded());
    entry.update_us = 900;
    record(0, false); // the picture of before was shown again
    CHECK(measures.ring(Series::frame_us).size() == 2);
    CHECK(measures.peaks().update_us == 900); // a panel that says used and peak shows both
    entry.update_us = 800;
    CHECK(measures.peaks().items == 70);
    CHECK(measures.last().items == 10);
    measures.hold(true); // the series stand still, whatever happens
    entry.items = 90;
    record(3, true);
    CHECK(measures.ring(Series::frame_us).size() == 2);
    CHECK(measures.frame(0).entry.items == 10);
    CHECK(measures.recorded() == 2);
    CHECK(measures.peaks().items == 90);
    measures.hold(false);
    record(4, true);
    CHECK(measures.ring(Series::frame_us).size() == 3);
    measures.hold(true);
    measures.clear();
    CHECK_FALSE(measures.held());
    CHECK(measures.frames() == 0);
    CHECK(measures.peaks().items == 0);
}

TEST_CASE("halving a triangle raises its level by one") {
    for (unsigned seed = 0; seed < 200; ++seed) {
        Random random(seed);
        const int tile_log2 = pick(random, 1, 12), side = 1 << tile_log2;
        const int left = side * pick(random, -3, 3), top = side * pick(random, -3, 3);
        MeshVertex ends[2] = {{left, top, 0}, {left + side, top + side, 0}}; // of the hypotenuse
        MeshVertex apex{left + side, top, 0};
        if (pick(random, 0, 1) == 1) apex = {left, top + side, 0};
        for (int level = 0; level <= 2 * tile_log2; ++level) {
            INFO("seed " << seed << ", tiles of " << side);
            CHECK(triangle_level(ends[0], apex, ends[1], static_cast<std::uint32_t>(tile_log2)) == level);
            const MeshVertex middle{(ends[0].column + ends[1].column) / 2, (ends[0].row + ends[1].row) / 2, 0};
            ends[pick(random, 0, 1)] = apex;
            apex = middle;
        }
    }
    const MeshVertex a{0, 0, 0}, b{4, 4, 0}, c{2, 2, 0};
    CHECK(triangle_level(a, b, c, 3) < 0);
    CHECK(triangle_level(a, a, b, 3) < 0);
}

TEST_CASE("the histogram of levels is the plain count, of lists and of strips") {
    for (unsigned seed = 0; seed < 12; ++seed) {
        Random random(seed);
        const int tile_log2 = pick(random, 3, 6);
        const io::LoadedPack loaded = bake_and_load(
            random_dem(random, pick(random, 40, 260), pick(random, 40, 260), Shape::fractal), small_bake(tile_log2));
        Recursive method(loaded.terrain, ample_budget(loaded.terrain));
        RefineSettings settings;
        settings.max_error_px = uniform(random, 0.2, 20);
        settings.cull = pick(random, 0, 1) == 1;
        for (const Topology topology : {Topology::triangles, Topology::strip}) {
            settings.topology = topology;
            (void)method.update(random_view(random, loaded.terrain), settings);
            INFO("seed " << seed << ", " << (topology == Topology::strip ? "strips" : "list"));
            check_histogram(method.mesh(), static_cast<std::uint32_t>(tile_log2));
        }
    }
}

TEST_CASE("the histogram of the live cut is the plain count, whatever lies idle in its chunks") {
    for (unsigned seed = 0; seed < 6; ++seed) {
        Random random(seed);
        const int tile_log2 = pick(random, 4, 6);
        const io::LoadedPack loaded =
            bake_and_load(random_dem(random, 200, 170, Shape::fractal), small_bake(tile_log2));
        CutBudget budget;
        budget.vertices = 1u << 16;
        budget.triangles = 1u << 18;
        const std::size_t bytes = cut_bytes(loaded.terrain, budget);
        const io::AlignedMemory memory = io::allocate(bytes);
        LiveCut cut;
        REQUIRE(create_cut(loaded.terrain, budget, {memory.get(), bytes}, cut).ok());
        for (int frame = 0; frame < 4; ++frame) {
            const View view = random_view(random, loaded.terrain);
            CutSettings settings;
            settings.max_error_px = uniform(random, 0.5, 8);
            CutReport report;
            REQUIRE(update_cut(cut, std::span(&view, 1), settings, report).ok());
            INFO("seed " << seed << ", frame " << frame);
            check_histogram(cut_mesh(cut).mesh, static_cast<std::uint32_t>(tile_log2));
        }
    }
}

TEST_CASE("a size in bytes has three digits, and the unit that leaves one to three before the point") {
    const std::pair<double, const char*> byte_texts[] = {
        {0, "0 B"},          {999, "999 B"},     {1000, "1.00 kB"},   {9994, "9.99 kB"},    {9996, "10.0 kB"},
        {99'949, "99.9 kB"}, {99'960, "100 kB"}, {999'400, "999 kB"}, {999'500, "1.00 MB"}, {12.34e6, "12.3 MB"},
        {525e6, "525 MB"},   {1.5e9, "1.50 GB"}, {2e12, "2.00 TB"},   {1e15, "1000 TB"}};
    for (const auto& [bytes, text] : byte_texts) CHECK(std::string(byte_text(bytes).text) == text);
    const std::pair<double, const char*> counts[] = {
        {0, "0"}, {999, "999"}, {1000, "1,000"}, {12345.4, "12,345"}, {1234567, "1,234,567"}};
    for (const auto& [count, text] : counts) CHECK(std::string(count_text(count).text) == text);
    CHECK(std::string(metre_text(-235929.6).text) == "-235,930");
    CHECK(std::string(metre_text(-0.3).text) == "0");
    CHECK(std::string(place_text(1234.5, -12, 235930).text) == "1,234 E  235,930 S  -12 m");
    const std::pair<double, const char*> speeds[] = {{0, "0 m/s"},         {0.51, "0.51 m/s"},   {999.4, "999 m/s"},
                                                     {4096, "4,096 m/s"},  {12345, "12.3 km/s"}, {999400, "999 km/s"},
                                                     {1.5e6, "1,500 km/s"}};
    for (const auto& [m_s, text] : speeds) CHECK(std::string(speed_text(m_s).text) == text);
    const std::pair<double, const char*> times[] = {{0, "0.00"},    {274, "0.27"},  {9994, "9.99"},
                                                    {9996, "10.0"}, {99960, "100"}, {1250000, "1,250"}};
    for (const auto& [us, text] : times) CHECK(std::string(ms_text(us).text) == text);
}
