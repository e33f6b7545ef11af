// Digging in the editor: after whatever is done and undone the ground that is shown is the one that a bake of the
// journal has, and the journal says it after a restart.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "baker/locks/locks.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "edit/locks.h"
#include "editor/digging.h"
#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "io/stamps.h"
#include "session/session.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;
using editor::Brush;
using editor::BrushTool;
using editor::Digging;

namespace {

// As the editor opens it.
struct DugTerrain {
    explicit DugTerrain(const std::string& pack) {
        session::FlightOptions options;
        options.pack = pack;
        editor::open_with_journal(options);
        session::open_session(options, session);
        digging = std::make_unique<Digging>(pack, session.loaded.pack.header);
        digging->use(session.edits.get());
        settle();
    }
    void settle() {
        session.edits->begin_frame(0);
        for (int i = 0; i < 1000 && (i < 2 || session.edits->waiting() != 0); ++i) (void)session.edits->update({}, 0);
        CHECK(session.edits->waiting() == 0);
    }
    // Whether the ground has taken it. If not, it is as before.
    bool settled_or_back() {
        settle();
        const std::string why = session.edits->take_refusal();
        if (why.empty()) return true;
        INFO(why);
        CHECK(why.find("Stamp") != std::string::npos); // its codes or its range: no budget
        digging->take_back_refused();
        settle();
        CHECK(session.edits->take_refusal().empty());
        return false;
    }
    // How many samples are not what the journal makes of the pack.
    [[nodiscard]] int wrong(const std::string& pack) const {
        std::vector<io::TimedStamp> stamps;
        std::unique_ptr<baker::HeightSource> source = std::make_unique<baker::PackSource>(pack);
        if (std::filesystem::exists(io::journal_path(pack)))
            for (io::KeptStamp& stamp : io::Journal(io::journal_path(pack)).stamps())
                stamps.push_back({0, std::move(stamp)});
        if (!stamps.empty()) source = baker::edited_source(std::move(source), stamps, "journal");
        std::vector<float> heights(static_cast<std::size_t>(source->columns) * static_cast<std::size_t>(source->rows));
        baker::ReadStatistics ignored;
        source->reader()->read({0, 0, source->columns, source->rows}, heights.data(), ignored);
        int count = 0;
        for (std::int32_t y = 0; y < source->rows; ++y)
            for (std::int32_t x = 0; x < source->columns; ++x) {
                const TerrainVertex v = terrain_vertex(session.terrain(), {x, y});
                const float height_m = heights[static_cast<std::size_t>(y) * static_cast<std::size_t>(source->columns) +
                                               static_cast<std::size_t>(x)];
                count += v.hole != std::isnan(height_m) || (!v.hole && v.height_m != height_m);
            }
        return count + wrong_locks(*source);
    }
    // What is allowed at a sample is another error than a bake has.
    [[nodiscard]] int wrong_locks(const baker::HeightSource& source) const {
        const EditsData& edits = *find(session.edits->edits());
        const baker::Window all{0, 0, source.columns, source.rows};
        baker::Locks locks;
        locks.add_stamps(source);
        std::vector<baker::LockCodes> codes = locks.over(all, edits.terrain->errors);
        codes.resize(all.area());
        int count = 0;
        for (std::int32_t y = 0; y < source.rows; ++y)
            for (std::int32_t x = 0; x < source.columns; ++x)
                count += edit::least_allowed(edits, {x, y, x, y}) !=
                         codes[static_cast<std::size_t>(y) * static_cast<std::size_t>(source.columns) +
                               static_cast<std::size_t>(x)]
                             .allowed;
        return count;
    }
    session::Session session;
    std::unique_ptr<Digging> digging;
};

std::string layers_told(const Digging& digging) {
    std::string text;
    for (const io::JournalLayer& layer : digging.layers()) {
        text += layer.name + (layer.on ? " on " : " off ") + std::to_string(layer.strength) + ":";
        for (const io::JournalStamp& stamp : layer.stamps) text += io::write_stamps({{0, stamp.what}});
    }
    return text;
}

// Metres up and down in shares of the relief: what no page's heights span is refused, which is other tests' matter.
Brush any_brush(Random& random, const Terrain& terrain, bool locks = false) {
    const double spacing_m = terrain.spacing_x_m(), relief_m = terrain.header().max_m - terrain.header().min_m;
    Brush b;
    b.tool = static_cast<BrushTool>(pick(random, 1, has_room_for_holes(terrain.header()) ? 9 : 7));
    b.radius_m = spacing_m * uniform(random, 1, 9), b.falloff_m = spacing_m * uniform(random, 0, 9);
    b.amount_m = relief_m * uniform(random, 0.005, 0.03), b.strength = uniform(random, 0.1, 1);
    if (locks && has_room_for_locks(terrain.header()) && pick(random, 0, 3) == 0) {
        b.tool = pick(random, 0, 2) != 0 ? BrushTool::lock : BrushTool::unlock;
        b.error_m = relief_m * uniform(random, 0, 0.01), b.strength = 1;
    }
    return b;
}

} // namespace

TEST_CASE("whatever is dug, switched, moved, removed and undone, the ground is what a bake of the journal has") {
    Random random(450);
    int steps = 0, undone = 0, removed = 0, refused = 0;
    for (int round = 0; round < rounds(4, 40); ++round) {
        const TemporaryFolder folder;
        const std::string pack = folder / "hills.fjell";
        baker::Dem dem = random_dem(random, pick(random, 60, 140), pick(random, 60, 140), Shape::fractal);
        // A page's heights span at most 65,535 steps: by default a bake leaves room for more ground than there is.
        const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
        // And floats tell all steps, or what is flown and what is baked round apart.
        const double lowest = *low, highest = *high;
        dem.native_quantum_m =
            std::max((highest - lowest) / 8192, std::max(std::abs(lowest), std::abs(highest)) * 0x1p-20);
        (void)baker::bake(std::move(dem), small_bake(5), pack);
        auto terrain = std::make_unique<DugTerrain>(pack);
        const Terrain& t = terrain->session.terrain();
        const double wide_m = t.extent_x_m(), deep_m = t.extent_z_m();
        std::vector<std::string> said{""}; // after each step that can be undone
        for (int i = 0; i < 25; ++i) {
            Digging& d = *terrain->digging;
            const auto layer = [&] {
                return static_cast<std::size_t>(pick(random, 0, static_cast<int>(d.layers().size()) - 1));
            };
            const std::size_t before = d.undo_steps();
            const int what = pick(random, 0, 9);
            if (d.layers().empty()) { // a stroke would make one, and be undone with it
                d.add_layer("first");
            } else if (what <= 3) {
                const std::size_t to = layer();
                if (!d.layers()[to].on) continue;
                d.choose(to);
                const Brush brush = any_brush(random, terrain->session.terrain(), true);
                const double level_m = 0.5 * (t.header().min_m + t.header().max_m);
                for (int n = pick(random, 1, 4); n > 0; --n)
                    d.dab(dab_of(brush, uniform(random, 0, wide_m), uniform(random, 0, deep_m), level_m, 7));
                d.end_stroke();
            } else if (what == 4 && d.layers().size() < 5) {
                d.add_layer("layer " + std::to_string(i));
            } else if (what == 5) {
                const std::size_t n = layer();
                d.set_layer(n, pick(random, 0, 3) != 0, uniform(random, 0, 1), layer());
            } else if (what == 6 && d.layers().size() > 1) {
                d.remove_layer(layer()), ++removed;
            } else if (what >= 7 && d.undo_steps() > 0) {
                d.undo(), ++undone;
                said.pop_back();
                CHECK(layers_told(d) == said.back());
                if (pick(random, 0, 1) == 0) {
                    d.redo();
                    said.push_back(layers_told(d));
                }
            }
            if (d.undo_steps() > before && (what < 7 || before == 0)) said.push_back(layers_told(d)), ++steps;
            if (!terrain->settled_or_back()) {
                ++refused;
                said.resize(std::min(said.size(), d.undo_steps() + 1));
                if (said.size() <= d.undo_steps()) said.push_back(layers_told(d)); // an undo was refused
                CHECK(layers_told(d) == said.back());
            }
            INFO("round " << round << " step " << i << " kind " << what << " refused " << refused);
            CHECK(terrain->wrong(pack) == 0);
        }
        const std::string last = layers_told(*terrain->digging);
        terrain.reset();
        terrain = std::make_unique<DugTerrain>(pack); // the next day
        CHECK((layers_told(*terrain->digging) == last && terrain->wrong(pack) == 0));
    }
    CHECK((steps > 30 && undone > 5 && removed > 0 && refused < steps / 2));
}

TEST_CASE("undoing everything gives the pack's ground, and what cannot be dug is said and changes nothing") {
    Random random(451);
    const TemporaryFolder folder;
    const std::string pack = folder / "hills.fjell";
    (void)baker::bake(random_dem(random, 90, 90, Shape::fractal), small_bake(5), pack);
    DugTerrain terrain(pack);
    CHECK(!std::filesystem::exists(io::journal_path(pack))); // looking makes none
    const double spacing_m = terrain.session.terrain().spacing_x_m();
    std::vector<float> before;
    const auto heights = [&] {
        std::vector<float> all;
        for (std::int32_t y = 0; y < 90; ++y)
            for (std::int32_t x = 0; x < 90; ++x)
                all.push_back(terrain_vertex(terrain.session.terrain(), {x, y}).height_m);
        return all;
    };
    before = heights();
    Digging& d = *terrain.digging;
    for (int i = 0; i < 6; ++i) {
        const Brush brush = any_brush(random, terrain.session.terrain());
        for (int n = 0; n < 3; ++n)
            d.dab(dab_of(brush, uniform(random, 0, 89 * spacing_m), uniform(random, 0, 89 * spacing_m), 0, 1));
        d.end_stroke();
        (void)terrain.settled_or_back();
    }
    CHECK(heights() != before);
    while (d.undo_steps() != 0) d.undo();
    terrain.settle();
    CHECK((heights() == before && d.layers().empty()));
    CHECK(terrain.session.edits->totals().last.blocks == 0); // and nothing is kept of it
    while (d.redo_steps() != 0) d.redo();
    terrain.settle();
    CHECK((heights() != before && terrain.wrong(pack) == 0));
    // A second program.
    Digging other(pack, terrain.session.loaded.pack.header);
    CHECK(other.problem().find("another program") != std::string::npos);
    CHECK_THROWS_AS(other.add_layer("mine"), io::Failure);
    Stamp bad = dab_of({BrushTool::raise, 1, 1, 1, 1}, std::nan(""), 0, 0, 0);
    CHECK_THROWS_AS(d.dab(bad), io::Failure);
    d.set_layer(0, false, {}, {});
    CHECK_THROWS_AS(d.dab(dab_of({BrushTool::raise, 1, 1, 1, 1}, 1, 1, 0, 0)), io::Failure);
    CHECK_THROWS_AS(d.set_layer(0, {}, {}, 7), io::Failure);
    CHECK(!d.in_stroke());
    // Of another pack.
    (void)baker::bake(random_dem(random, 80, 80, Shape::fractal), small_bake(5), folder / "other.fjell");
    std::filesystem::copy(io::journal_path(pack), io::journal_path(folder / "other.fjell"));
    DugTerrain stranger(folder / "other.fjell");
    CHECK(stranger.digging->problem().find("fjell-bake rebase") != std::string::npos);
    CHECK(stranger.session.edits->totals().applied == 0);
}

TEST_CASE("a road begins and ends on the ground, leaves out what is short beside its width, and follows the rest") {
    Brush brush;
    brush.tool = BrushTool::road;
    brush.radius_m = 4;
    std::vector<StampPoint> places;
    const auto hill_m = [](double x_m) { return 100 + 40 * std::sin(x_m / 400); };
    for (int i = 0; i <= 700; ++i)
        places.push_back({2.0 * i, 0.5 * i, static_cast<float>(hill_m(2.0 * i) + (i % 2 ? 1 : -1))});
    const io::KeptStamp road = road_of(brush, places);
    REQUIRE(road.points.size() == max_path_points);
    CHECK(check_stamp(road.stamp()).ok());
    CHECK((road.plain.shape == StampShape::path && road.plain.radius_m == 4));
    CHECK(road.points.front().height_m == places.front().height_m);
    CHECK(road.points.back().height_m == places.back().height_m);
    CHECK((road.points.back().x_m == 1400 && road.points.back().z_m == 350));
    for (std::size_t i = 8; i + 8 < road.points.size(); ++i)
        CHECK(std::fabs(static_cast<double>(road.points[i].height_m) - hill_m(road.points[i].x_m)) < 0.9);
    brush.radius_m = 0.5; // narrow: bumps as far apart as its points are its own
    const std::vector<StampPoint> few(places.begin(), places.begin() + 3);
    CHECK(road_of(brush, few).points[1].height_m == few[1].height_m);
    CHECK(road_of(brush, std::span(few).first(2)).points.size() == 2); // a ramp
}

TEST_CASE("the first stroke makes a layer, and both are one step") {
    const TemporaryFolder folder;
    const std::string pack = folder / "hills.fjell";
    Random random(451);
    (void)baker::bake(random_dem(random, 90, 90, Shape::fractal), small_bake(5), pack);
    DugTerrain terrain(pack);
    Digging& d = *terrain.digging;
    const double middle_m = terrain.session.terrain().extent_x_m() / 2;
    d.dab(dab_of({BrushTool::raise, 3, 3, 0.01, 1}, middle_m, middle_m, 0, 0));
    d.end_stroke();
    REQUIRE(d.layers().size() == 1);
    const std::string dug = layers_told(d);
    d.undo();
    CHECK((d.layers().empty() && d.undo_steps() == 0));
    d.redo();
    CHECK(layers_told(d) == dug);
    CHECK(d.redo_steps() == 0);
    d.dab(dab_of({BrushTool::raise, 3, 3, 0.01, 1}, middle_m, middle_m, 0, 0));
    d.undo(); // the second alone
    CHECK(layers_told(d) == dug);
}
