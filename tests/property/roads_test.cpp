// Roads and rivers on the ground that a bake with their stamps has, read back by other code than made it.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "baker/vectors/roads.h"
#include "fjell/io/failure.h"
#include "support/dem.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

struct HeightsRead {
    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};
    std::vector<float> heights_m;

    explicit HeightsRead(const HeightSource& source) : columns(source.columns), rows(source.rows) {
        std::copy_n(source.spacing_m, 2, spacing_m);
        heights_m.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
        ReadStatistics ignored;
        source.reader()->read({0, 0, columns, rows}, heights_m.data(), ignored);
    }
    [[nodiscard]] double at(int x, int y) const {
        return static_cast<double>(
            heights_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)]);
    }
    [[nodiscard]] double between(const Place& p) const {
        const double u = p[0] / spacing_m[0], v = p[1] / spacing_m[1];
        const int x = std::clamp(static_cast<int>(u), 0, columns - 2), y = std::clamp(static_cast<int>(v), 0, rows - 2);
        return (at(x, y) * (x + 1 - u) + at(x + 1, y) * (u - x)) * (y + 1 - v) +
               (at(x, y + 1) * (x + 1 - u) + at(x + 1, y + 1) * (u - x)) * (v - y);
    }
};

// Hills that are steeper than roads may be, a metre or more from sample to sample.
Dem hills(Random& random, int columns, int rows) {
    Dem dem = random_dem(random, columns, rows, Shape::fractal);
    dem.spacing_m[0] = uniform(random, 0.5, 20), dem.spacing_m[1] = dem.spacing_m[0] * uniform(random, 0.7, 1.4);
    const auto [least, most] = std::ranges::minmax(dem.heights_m);
    for (float& h : dem.heights_m)
        h = static_cast<float>((static_cast<double>(h - least)) / std::max<double>(most - least, 1e-3) * 0.5 * columns *
                               dem.spacing_m[0]);
    return dem;
}

// A line that never turns back: it keeps within 80 degrees of where it goes, and bends up to 160 degrees.
MapLine zigzag(Random& random, const Dem& dem, double heading, const Place& from, double bends = 1.4) {
    MapLine line;
    line.places.push_back(from);
    const double side = uniform(random, 5, 15) * dem.spacing_m[0];
    for (int k = 0; k < 10; ++k) {
        const double at = heading + uniform(random, -bends, bends);
        line.places.push_back(
            {line.places.back()[0] + side * std::cos(at), line.places.back()[1] + side * std::sin(at)});
    }
    line.width_m = uniform(random, 0.1, 6) * dem.spacing_m[0];
    line.max_grade = uniform(random, 0.05, 0.2);
    line.depth_m = uniform(random, 0, 0.5) * dem.spacing_m[0];
    return line;
}
Place somewhere(Random& random, const Dem& dem) {
    return {uniform(random, 0.1, 0.9) * (dem.columns - 1) * dem.spacing_m[0],
            uniform(random, 0.1, 0.9) * (dem.rows - 1) * dem.spacing_m[1]};
}

// A pack of the ground, and of what becomes of it.
struct Laid {
    std::unique_ptr<TemporaryFolder> folder = std::make_unique<TemporaryFolder>();
    std::unique_ptr<HeightsRead> before, after;
    LineSummary summary;
    double step_m = 0; // of the packs' heights
};
Laid laid(const Dem& dem, const std::vector<MapLine>& lines, LineKind kind, const LineOptions& options) {
    Laid l;
    (void)bake(dem, small_bake(5), *l.folder / "before.fjell");
    auto pack = std::make_unique<PackSource>(*l.folder / "before.fjell");
    l.before = std::make_unique<HeightsRead>(*pack);
    l.step_m = pack->height_scale().quantum_m;
    const MadeLines made = make_lines(*pack, lines, kind, options, "lines");
    l.summary = made.summary;
    std::vector<io::TimedStamp> stamps;
    for (const io::KeptStamp& stamp : made.stamps) stamps.push_back({0, stamp});
    l.after = std::make_unique<HeightsRead>(*edited_source(std::move(pack), stamps, "stamps"));
    return l;
}

// Heights along a line, a tenth of a sample apart: how far from its start, and how high.
struct Along {
    double way_m, height_m;
};
std::vector<std::vector<Along>> along(const MapLine& line, const HeightsRead& ground) {
    std::vector<std::vector<Along>> all;
    const double step = 0.1 * std::min(ground.spacing_m[0], ground.spacing_m[1]);
    for (const std::vector<Place>& piece :
         clipped(line.places, (ground.columns - 1) * ground.spacing_m[0], (ground.rows - 1) * ground.spacing_m[1])) {
        std::vector<Along>& one = all.emplace_back();
        double way_m = 0;
        for (std::size_t i = 1; i < piece.size(); ++i) {
            const double length_m = std::hypot(piece[i][0] - piece[i - 1][0], piece[i][1] - piece[i - 1][1]);
            const int parts = std::max(static_cast<int>(length_m / step), 1);
            for (int k = 0; k <= parts; ++k)
                one.push_back({way_m + k * length_m / parts,
                               ground.between(between(piece[i - 1], piece[i], static_cast<double>(k) / parts))});
            way_m += length_m;
        }
    }
    return all;
}

LineOptions river_options() {
    LineOptions o;
    o.shoulder_m = 0, o.smooth_m = 0;
    o.slopes = {.cut = 0.5, .fill = 0.5, .fills = false};
    return o;
}

} // namespace

TEST_CASE("over a sample or more, the ground along a road is nowhere steeper than its grade") {
    Random random(21);
    int roads = 0;
    double worst = 0, worst_straight = 0;
    for (int round = 0; round < rounds(12, 300); ++round) {
        const Dem dem = hills(random, pick(random, 60, 100), pick(random, 60, 100));
        std::vector<MapLine> lines;
        const bool straight = round % 3 == 0;
        for (int i = straight ? 1 : pick(random, 1, 3); i > 0; --i)
            lines.push_back(zigzag(random, dem, uniform(random, 0, 6.28), somewhere(random, dem), straight ? 0 : 1.4));
        if (lines.size() > 1) lines.back().places.front() = lines.front().places[3]; // a junction
        LineOptions options;
        options.shoulder_m = uniform(random, 0, 1) * dem.spacing_m[0];
        options.smooth_m = pick(random, 0, 1) * 30;
        const Laid l = laid(dem, lines, LineKind::road, options);
        CAPTURE(round, dem.spacing_m[0], dem.spacing_m[1], l.step_m, lines.size());
        const double sample_m = std::max(dem.spacing_m[0], dem.spacing_m[1]);
        for (const MapLine& line : lines)
            for (const std::vector<Along>& piece : along(line, *l.after)) {
                ++roads;
                std::size_t j = 0;
                for (std::size_t i = 0; i < piece.size(); ++i) {
                    while (j < piece.size() && piece[j].way_m - piece[i].way_m < sample_m) ++j;
                    if (j == piece.size()) break;
                    // Heights are rounded to half a step at both ends, and are single precision.
                    const double rise_m = std::abs(piece[j].height_m - piece[i].height_m) - l.step_m - 1e-3,
                                 grade = rise_m / (piece[j].way_m - piece[i].way_m);
                    double& most = straight ? worst_straight : worst;
                    most = std::max(most, grade / line.max_grade);
                }
            }
        double most = 0;
        for (const MapLine& line : lines) most = std::max(most, line.max_grade);
        CHECK(l.summary.grade <= most + 1e-9);
    }
    CAPTURE(roads);
    CHECK(worst_straight <= 1);
    // Bends that are sharper than the samples keep it by trial (Lines::beside_m), to a twentieth.
    CHECK(worst < 1.05);
    CHECK((worst > 0.8 && worst_straight > 0.8));
}

TEST_CASE("slopes beside a road are no steeper than asked, nor than the ground was, but where it is said") {
    Random random(22);
    int gentle = 0;
    for (int round = 0; round < rounds(12, 200); ++round) {
        const Dem dem = hills(random, 70, 70);
        const std::vector<MapLine> lines{zigzag(random, dem, uniform(random, 0, 6.28), somewhere(random, dem))};
        LineOptions options;
        options.shoulder_m = dem.spacing_m[0];
        options.slopes.cut = options.slopes.fill = uniform(random, 0.4, 2);
        options.slopes.reach_m = 1e5;
        const Laid l = laid(dem, lines, LineKind::road, options);
        const HeightsRead &was = *l.before, &is = *l.after;
        std::uint64_t steep = 0, changed = 0;
        double cut_m = 0, fill_m = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                const double by_m = is.at(x, y) - was.at(x, y);
                if (by_m == 0) continue;
                ++changed;
                cut_m = std::max(cut_m, -by_m), fill_m = std::max(fill_m, by_m);
                bool here = false;
                for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
                    if (x + dx < 0 || y + dy < 0 || x + dx >= dem.columns || y + dy >= dem.rows) continue;
                    const double away_m = dx != 0 ? dem.spacing_m[0] : dem.spacing_m[1],
                                 now_m = std::abs(is.at(x + dx, y + dy) - is.at(x, y)),
                                 then_m = std::abs(was.at(x + dx, y + dy) - was.at(x, y));
                    here = here || now_m > std::max(options.slopes.cut * away_m, then_m) + l.step_m + 2e-3;
                }
                steep += here;
            }
        CAPTURE(round, steep, l.summary.ground.steep, changed);
        CHECK(steep <= l.summary.ground.steep);
        CHECK(changed <= l.summary.ground.samples);
        CHECK(std::abs(cut_m - l.summary.ground.deepest_cut_m) <= l.step_m);
        CHECK(std::abs(fill_m - l.summary.ground.highest_fill_m) <= l.step_m);
        gentle += l.summary.ground.steep == 0;
    }
    CHECK(gentle > 0);
}

TEST_CASE("a straight road over a hillside is level across, and its slopes are straight lines to the ground") {
    Dem dem;
    dem.columns = dem.rows = 81;
    const auto hill = [](int x, int y) { return 0.3 * y + 0.02 * x; };
    for (int y = 0; y < 81; ++y)
        for (int x = 0; x < 81; ++x) dem.heights_m.push_back(static_cast<float>(hill(x, y)));
    MapLine line;
    line.places = {{-10, 40}, {100, 40}};
    line.width_m = 6, line.max_grade = 0.1;
    LineOptions options;
    options.slopes = {.cut = 1, .fill = 0.5};
    const Laid l = laid(dem, {line}, LineKind::road, options);
    CHECK(l.summary.lines == 1);
    CHECK(std::abs(l.summary.length_m - 80) < 1e-9);
    CHECK(l.summary.most_off_m < 0.1); // it may follow the hill, but for what smoothing takes
    for (int x = 10; x <= 70; ++x)
        for (int y = 20; y <= 60; ++y) {
            const double road_m = hill(x, 40), beyond_m = std::max(std::abs(y - 40) - 4, 0), ground_m = hill(x, y);
            const double expected = std::clamp(ground_m, road_m - 0.5 * beyond_m, road_m + 1 * beyond_m);
            // The slope comes from the nearest of all samples of the road, which need not be straight across.
            REQUIRE(std::abs(l.after->at(x, y) - expected) < 0.03 + l.step_m);
        }
    // Twice as wide by an attribute, and no shoulder.
    line.width_m = 12;
    options.shoulder_m = 0;
    const Laid wide = laid(dem, {line}, LineKind::road, options);
    CHECK(std::abs(wide.after->at(40, 46) - hill(40, 40)) < 0.01 + l.step_m);
    CHECK(wide.after->at(40, 47) > hill(40, 40) + 0.5);
}

TEST_CASE("banks of a river that runs askew are planes, without a rib for each sample") {
    Dem dem;
    dem.columns = 90, dem.rows = 80;
    dem.heights_m.assign(static_cast<std::size_t>(dem.columns) * static_cast<std::size_t>(dem.rows), 50.0f);
    dem.heights_m.back() = 51; // so that a step is a centimetre
    const Place a{12.3, 9.1}, b{71.8, 66.4};
    const MapLine river{{a, b}, 6, 0, 5};
    const Laid l = laid(dem, {river}, LineKind::river, river_options());
    const double length_m = std::hypot(b[0] - a[0], b[1] - a[1]);
    std::size_t on_banks = 0;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) {
            const double along = ((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / length_m;
            const double away = std::abs((x - a[0]) * (b[1] - a[1]) - (y - a[1]) * (b[0] - a[0])) / length_m;
            if (along < 14 || along > length_m - 14) continue; // round its ends
            const double asked = std::min(50.0, 45 + 0.5 * std::max(away - 3, 0.0));
            CAPTURE(x, y, away);
            REQUIRE(l.after->at(x, y) == Approx(asked).margin(0.02));
            on_banks += away > 3 && away < 13;
        }
    CHECK(on_banks > 800);
}

TEST_CASE("a river never climbs and only takes ground away, with the streams that run into it") {
    Random random(23);
    double deepest = 0;
    for (int round = 0; round < rounds(12, 300); ++round) {
        const Dem dem = hills(random, pick(random, 60, 100), pick(random, 60, 100));
        std::vector<MapLine> lines{zigzag(random, dem, uniform(random, 0, 6.28), somewhere(random, dem))};
        const LineOptions options = river_options();
        const Laid l = laid(dem, lines, LineKind::river, options);
        CAPTURE(round, dem.spacing_m[0], l.step_m);
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) REQUIRE(l.after->at(x, y) <= l.before->at(x, y));
        for (const MapLine& line : lines) {
            const auto before = along(line, *l.before);
            auto after = along(line, *l.after);
            if (after.empty()) continue;
            const bool against = before.back().back().height_m > before.front().front().height_m;
            double lowest = std::numeric_limits<double>::infinity(), climbed = 0;
            if (against) {
                std::ranges::reverse(after);
                for (std::vector<Along>& piece : after) std::ranges::reverse(piece);
            }
            for (const std::vector<Along>& piece : after)
                for (const Along& at : piece) {
                    climbed = std::max(climbed, at.height_m - lowest);
                    lowest = std::min(lowest, at.height_m);
                }
            // Rounding keeps the order of heights; only sums of four products of them are off by their last digits.
            // Between pieces the river is off the terrain, where nothing is known.
            if (after.size() == 1) CHECK(climbed <= 1e-3);
            // As deep as asked, everywhere.
            for (std::size_t p = 0; p < before.size() && !against; ++p)
                for (std::size_t i = 0; i < before[p].size(); ++i)
                    REQUIRE(after[p][i].height_m <= before[p][i].height_m - line.depth_m + l.step_m + 1e-3);
        }
        deepest = std::max(deepest, l.summary.ground.deepest_cut_m);
    }
    CHECK(deepest > 1);
}

TEST_CASE("a stream runs down into its river, which is drawn the wrong way round") {
    Dem dem;
    dem.columns = dem.rows = 65;
    for (int y = 0; y < 65; ++y)
        for (int x = 0; x < 65; ++x)
            dem.heights_m.push_back(static_cast<float>(100 - 0.5 * y + 0.1 * std::abs(x - 32) + (y == 40 ? 8 : 0)));
    MapLine river, stream;
    river.places = {{32, 64}, {32, 0}}; // northwards, and the ground falls to the south, over a dam
    stream.places = {{5, 10}, {32.1, 30}};
    river.width_m = stream.width_m = 2, river.depth_m = 2, stream.depth_m = 0.5;
    const Laid l = laid(dem, {river, stream}, LineKind::river, river_options());
    for (int y = 1; y < 65; ++y) CHECK(l.after->at(32, y) <= l.after->at(32, y - 1));
    CHECK(l.after->at(32, 40) <= 100 - 0.5 * 39 - 2 + l.step_m); // through the dam
    const Place mouth{32, 30};
    double last_m = 1e9;
    for (int i = 0; i <= 40; ++i) {
        const double height_m = l.after->between(between({5, 10}, mouth, i / 40.0));
        CHECK(height_m <= last_m + 1e-3);
        last_m = height_m;
    }
}

TEST_CASE("lines of a network: junctions share heights, holes end roads and stay, paint follows") {
    Random random(24);
    Dem dem = hills(random, 80, 80);
    dem.spacing_m[0] = dem.spacing_m[1] = 2;
    dem.voids.assign(dem.heights_m.size(), 0);
    for (int y = 35; y < 45; ++y)
        for (int x = 35; x < 45; ++x) dem.voids[dem.index(x, y)] = 1;
    MapLine across, up;
    across.places = {{0, 80}, {158, 80}};
    up.places = {{30, 0}, {30, 158}};
    across.width_m = up.width_m = 6, across.max_grade = up.max_grade = 0.1;
    LineOptions options;
    options.paint = {1, 2, 3};
    const Laid l = laid(dem, {across, up}, LineKind::road, options);
    CHECK(l.summary.lines == 2);
    CHECK((l.summary.length_m > 158 + 138 - 8 && l.summary.length_m < 158 + 138));
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x) REQUIRE(std::isnan(l.after->at(x, y)) == dem.is_void(x, y));
    // Where they cross they have one height, that of both.
    const double cross_m = l.after->between({30, 80});
    for (const Place& at : {Place{28, 80}, Place{32, 80}, Place{30, 78}, Place{30, 82}})
        CHECK(std::abs(l.after->between(at) - cross_m) <= 2 * 0.1 + l.step_m + 1e-3);
    const MadeLines made = make_lines(DemSource(dem), {across, up}, LineKind::road, options, "lines");
    int painted = 0;
    for (const io::KeptStamp& stamp : made.stamps) {
        REQUIRE(check_stamp(stamp.stamp()).ok());
        if (stamp.plain.shape != StampShape::paint) continue;
        ++painted;
        CHECK((stamp.points.size() == 2 && stamp.plain.rgb[2] == 3 && stamp.plain.material == no_material));
    }
    CHECK(painted == 2);
    MapLine outside = across;
    outside.places = {{-50, -1}, {500, -1}};
    REQUIRE_THROWS_AS(make_lines(DemSource(dem), {outside}, LineKind::road, options, "lines"), io::Failure);
    MapLine in_hole = across;
    in_hole.places = {{74, 80}, {84, 80}};
    REQUIRE_THROWS_AS(make_lines(DemSource(dem), {in_hole}, LineKind::road, options, "lines"), io::Failure);
}
