// The overview: what it shows, and its thread beside a frame that takes and leaves it. Means most under the tsan
// preset.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <vector>

#include "editor/jobs/overview.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

using Texels = std::vector<std::uint32_t>;

std::array<int, 3> rgb(std::uint32_t texel) {
    return {static_cast<int>(texel & 255), static_cast<int>(texel >> 8 & 255), static_cast<int>(texel >> 16 & 255)};
}

struct OverviewPlace {
    OverviewSource bake(const std::string& name, baker::Dem dem, baker::BakeOptions options) {
        (void)baker::bake(std::move(dem), options, folder / name);
        return {std::make_shared<io::PackFile>(folder / name), nullptr, {}};
    }
    [[nodiscard]] std::string ramp(const std::string& stops) const {
        const std::string path = folder / "ramp.json";
        std::ofstream(path) << R"({"stops": [)" << stops << "]}";
        return path;
    }
    TemporaryFolder folder;
};

// All of it at once. The last picture is the finished one.
Texels painted(const OverviewSource& source) {
    Texels last;
    const bool whole = paint_overview(
        source, [] { return false; },
        [&](double, std::span<const std::uint32_t> texels) {
            last.assign(texels.begin(), texels.end());
            return true;
        });
    REQUIRE(whole);
    return last;
}

struct Taken {
    OverviewSize size;
    double share = 0;
    Texels texels;
};
void take(void* to, OverviewSize size, double share, std::span<const std::uint32_t> texels) {
    auto& taken = *static_cast<Taken*>(to);
    taken.size = size;
    taken.share = share;
    taken.texels.assign(texels.begin(), texels.end());
}

// As frames do.
Taken taken_until_done(OverviewJob& job) {
    Taken last;
    while (!job.done())
        if (job.news()) (void)job.take(take, &last);
    return last;
}

} // namespace

TEST_CASE("an overview has the colours of the terrain's maps where they lie, and grey in holes") {
    Random random(11);
    OverviewPlace place;
    baker::Dem dem = random_dem(random, 200, 130, Shape::flat);
    const std::int32_t step_at = 120;
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x) dem.heights_m[dem.index(x, y)] = x < step_at ? 0.0F : 10.0F;
    dem.voids.assign(dem.heights_m.size(), 0);
    for (std::int32_t y = 40; y < 80; ++y)
        for (std::int32_t x = 20; x < 60; ++x) dem.voids[dem.index(x, y)] = 1;
    baker::BakeOptions options = small_bake(5);
    options.max_texture_log2 = 6;
    options.ramp_path = place.ramp(R"({"height_m": 4, "rgb": [255, 0, 0]}, {"height_m": 6, "rgb": [0, 0, 255]})");
    const OverviewSource source = place.bake("two.fjell", dem, options);
    const OverviewSize size = overview_size_of(source.pack->pack().header);
    CHECK(size.columns == OverviewSize::longer_texels);
    const Texels texels = painted(source);
    // Level ground in a light of 0.35 + 0.9 * 0.71. A texel's centre is less than a sample from where it is looked up;
    // a block of a colour map is 4 texels of the map, fewer than 4 samples, and the step is a sample wide.
    const int full = static_cast<int>(255 * (0.35 + 0.9 * 0.71));
    std::size_t wrong = 0, looked_at = 0;
    for (std::uint32_t row = 0; row < size.rows; ++row)
        for (std::uint32_t column = 0; column < size.columns; ++column) {
            const double x = (column + 0.5) * (dem.columns - 1) / size.columns,
                         y = (row + 0.5) * (dem.rows - 1) / size.rows;
            const auto near = [&](double from, double to, double at) { return at > from - 6 && at < to + 6; };
            const auto inside = [&](double from, double to, double at) { return at > from + 1 && at < to - 1; };
            const std::uint32_t texel = texels[std::size_t{row} * size.columns + column];
            if (inside(20, 59, x) && inside(40, 79, y)) {
                wrong += texel != overview_ground;
            } else if (near(20, 59, x) && near(40, 79, y)) {
                continue;
            } else if (near(step_at - 1, step_at, x)) {
                continue;
            } else {
                const auto [r, g, b] = rgb(texel);
                wrong += std::abs((x < step_at ? r : b) - full) > 2 || g > 8 || (x < step_at ? b : r) > 8;
            }
            ++looked_at;
        }
    CHECK(wrong == 0);
    CHECK(looked_at > size.texels() / 2);
}

TEST_CASE("an overview that is told to stop paints no further, whenever it is told") {
    Random random(12);
    OverviewPlace place;
    const OverviewSource source = place.bake("t.fjell", random_dem(random, 150, 150, Shape::fractal), small_bake(4));
    const Texels whole = painted(source);
    int asked = 0;
    (void)paint_overview(
        source, [&] { return ++asked, false; }, [](double, std::span<const std::uint32_t>) { return true; });
    REQUIRE(asked > 100);
    for (int i = 0; i < 20; ++i) {
        const int most = pick(random, 0, asked - 1);
        int left = most;
        bool finished = false;
        CHECK_FALSE(paint_overview(
            source, [&] { return left-- <= 0; },
            [&](double share, std::span<const std::uint32_t>) { return finished = share == 1, true; }));
        CHECK_FALSE(finished);
        CHECK(left > -asked / 4); // it did not go on regardless
    }
}

TEST_CASE("overviews of terrains that are left in the middle leave the next one whole") {
    Random random(13);
    OverviewPlace place;
    std::vector<OverviewSource> sources;
    std::vector<Texels> wanted;
    for (int i = 0; i < 2; ++i) {
        sources.push_back(place.bake("t" + std::to_string(i) + ".fjell",
                                     random_dem(random, 180, 90 + 60 * i, Shape::fractal), small_bake(4)));
        wanted.push_back(painted(sources.back()));
    }
    REQUIRE(wanted[0] != wanted[1]);
    OverviewJob job;
    CHECK(job.done());
    for (int round = 0; round < rounds(8, 40); ++round) {
        for (int i = pick(random, 0, 5); i > 0; --i) {
            job.begin(sources[static_cast<std::size_t>(i % 2)]);
            Taken ignored;
            for (int frames = pick(random, 0, 3000); frames > 0; --frames)
                if (job.news()) (void)job.take(take, &ignored);
        }
        const std::size_t last = static_cast<std::size_t>(round % 2);
        job.begin(sources[last]);
        const Taken taken = taken_until_done(job);
        CHECK(taken.share == 1);
        CHECK(taken.texels == wanted[last]);
        CHECK(taken.size.texels() == wanted[last].size());
        if (round % 3 == 0) job.end();
    }
    job.begin(sources[0]); // and is destroyed while it paints
}
