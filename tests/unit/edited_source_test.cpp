// Heights that stamps have changed, as the baker reads them: those of a flight with the same stamps.
#include "baker/bake/bake.h"
#include "baker/bake/inputs.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "fjell/edit.h"
#include "io/stamps.h"
#include "shared/terrain_data.h"
#include "source_check.h"
#include "support/dem.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

io::KeptStamp any_stamp(Random& random, const Terrain& terrain) {
    const double wx = terrain.extent_x_m(), wz = terrain.extent_z_m(), cell = terrain.spacing_x_m();
    const PackHeader& h = terrain.header();
    const double relief = std::max<double>(h.max_m - h.min_m, h.quantum_m * 20);
    io::KeptStamp kept;
    Stamp& s = kept.plain;
    constexpr StampShape shapes[] = {StampShape::raise, StampShape::level,   StampShape::crater,
                                     StampShape::path,  StampShape::noise,   StampShape::heights,
                                     StampShape::hole,  StampShape::restore, StampShape::fill};
    s.shape = shapes[pick(random, 0, 8)];
    const auto place = [&](double wide) { return uniform(random, -0.1, 1.1) * wide; };
    const auto height = [&] { return static_cast<float>(uniform(random, h.min_m, h.max_m)); };
    if (s.shape == StampShape::heights) {
        const auto columns = static_cast<int>(terrain.columns()), rows = static_cast<int>(terrain.rows());
        s.first = {pick(random, 0, columns - 2), pick(random, 0, rows - 2)};
        s.columns = pick(random, 1, 20), s.rows = pick(random, 1, 20);
        for (int i = 0; i < s.columns * s.rows; ++i)
            kept.heights_m.push_back(pick(random, 0, 3) ? height() : std::numeric_limits<float>::quiet_NaN());
        return kept;
    }
    s.radius_m = static_cast<float>(cell * std::pow(10.0, uniform(random, 0, s.shape == StampShape::fill ? 2 : 1.3)));
    s.falloff_m = static_cast<float>(pick(random, 0, 1) * static_cast<double>(s.radius_m) * uniform(random, 0.2, 2));
    if (s.shape == StampShape::path) {
        for (int i = pick(random, 2, 4); i > 0; --i) kept.points.push_back({place(wx), place(wz), height()});
        return kept;
    }
    s.x_m = place(wx), s.z_m = place(wz);
    if (s.shape == StampShape::raise || s.shape == StampShape::crater || s.shape == StampShape::noise)
        s.amount_m = static_cast<float>(relief * uniform(random, -0.06, 0.06));
    if (s.shape == StampShape::level) s.height_m = height();
    if (s.shape == StampShape::noise) s.wavelength_m = static_cast<float>(cell * uniform(random, 1, 20));
    return kept;
}

} // namespace

TEST_CASE("a pack and a file of stamps have the heights that are flown with them, and a bake of both has them too") {
    Random random(31);
    int applied = 0, restored = 0, were_cut = 0, were_filled = 0;
    for (int round = 0; round < rounds(12, 200); ++round) {
        const int log2 = pick(random, 3, 7);
        Dem dem = random_dem(random, pick(random, 20, 200), pick(random, 20, 200),
                             static_cast<Shape>(round % static_cast<int>(Shape::count)));
        if (round % 2) add_random_holes(random, dem, log2);
        const TemporaryFolder folder;
        const std::string pack_path = folder / "pack.fjell", stamps_path = folder / "stamps.json";
        BakeOptions roomy = small_bake(log2);
        roomy.room_for_holes = true;
        (void)bake(dem, roomy, pack_path);
        const auto pack = io::load_pack(pack_path, io::LoadTerrain::yes);
        const EditBudget budget{.blocks = 4096, .stamps = 16, .areas = 256, .holes = true};
        const std::size_t bytes = edits_bytes(pack.terrain.header(), budget);
        const io::AlignedMemory memory = io::allocate(bytes);
        Edits edits;
        REQUIRE(create_edits(pack.terrain, budget, {memory.get(), bytes}, edits).ok());
        std::vector<io::TimedStamp> flown;
        for (int i = 0; i < 8; ++i) {
            // As it comes back from the file.
            const std::string text = io::write_stamps({{0, any_stamp(random, pack.terrain)}});
            const io::TimedStamp stamp = io::parse_stamps(text, "stamps").front();
            StampId id = 0;
            REQUIRE(push_stamp(edits, stamp.what.stamp(), id).ok());
            EditReport report;
            do REQUIRE(update_edits(edits, {}, {}, report).ok());
            while (report.waiting != 0);
            if (stamp_state(edits, id).state != StampState::applied) continue; // too steep or too high for the pack
            flown.push_back(stamp);
            ++applied;
            restored += stamp.what.plain.shape == StampShape::restore;
        }
        if (flown.empty()) continue;
        const std::string text = io::write_stamps(flown);
        spit(stamps_path, text);
        const auto source = edited_source(std::make_unique<PackSource>(pack_path), stamps_path);
        CAPTURE(round, log2, dem.columns, dem.rows, text);
        check_windows(*source);
        const Field whole = read_whole(*source);
        int wrong = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                const float height = whole.heights_m[dem.index(x, y)];
                const bool hole = std::isnan(height);
                const bool flown_hole = data_of(pack.terrain).vertex({x, y}).hole;
                were_cut += flown_hole && !dem.is_void(x, y), were_filled += !flown_hole && dem.is_void(x, y);
                wrong += hole != flown_hole || (!hole && height != data_of(pack.terrain).height_m({x, y}));
            }
        REQUIRE(wrong == 0);
        REQUIRE(destroy_edits(edits).ok());
        Recipe recipe;
        recipe.inputs = {pack_path};
        recipe.edits = stamps_path;
        const BakeSummary said = bake(*open_inputs(recipe), small_bake(log2), folder / "baked.fjell");
        const Field baked = read_whole(PackSource(folder / "baked.fjell"));
        double most = 0; // beyond half a step and what the two floats may round
        for (std::size_t i = 0; i < baked.heights_m.size(); ++i) {
            REQUIRE(std::isnan(baked.heights_m[i]) == std::isnan(whole.heights_m[i]));
            if (!std::isnan(whole.heights_m[i]))
                most = std::max(most, std::fabs(static_cast<double>(baked.heights_m[i]) - whole.heights_m[i]) -
                                          0x1p-23 * static_cast<double>(std::fabs(whole.heights_m[i])));
        }
        CHECK(most <= 0.5001 * static_cast<double>(said.quantum_m)); // a taller tile may take a larger step
    }
    CHECK(applied > rounds(30, 500));
    CHECK(restored > rounds(1, 50));
    CHECK(were_cut > rounds(100, 2000));
    CHECK(were_filled > rounds(10, 200));
}

TEST_CASE("stamps smooth by the ground around, keep voids, and give heights between a file's whole steps") {
    Dem dem;
    dem.columns = 70, dem.rows = 66;
    dem.heights_m.assign(70 * 66, 10.0F);
    dem.heights_m[dem.index(64, 63)] = 19; // where four blocks of the reader meet
    const TemporaryFolder folder;
    const std::string path = folder / "stamps.json",
                      text = R"({"stamps": [{"shape": "smooth", "at": [64, 63], "radius_m": 0.5},
                                            {"frame": 1, "shape": "raise", "at": [5, 5], "radius_m": 2, "amount_m": 0.3}]})";
    spit(path, text);
    (void)bake(dem, small_bake(6), folder / "pack.fjell");
    const auto source = edited_source(std::make_unique<PackSource>(folder / "pack.fjell"), path);
    const Field whole = read_whole(*source);
    CHECK(whole.heights_m[dem.index(64, 63)] == Approx(11).margin(0.01));
    CHECK(whole.heights_m[dem.index(65, 63)] == 10);
    CHECK(whole.heights_m[dem.index(5, 5)] == Approx(10.3).margin(0.01));
    CHECK(source->identity() != PackSource(folder / "pack.fjell").identity());
}

TEST_CASE("holes of stamps are baked, and what cannot be is refused: a void without ground, holes that are filled") {
    Dem dem;
    dem.columns = 70, dem.rows = 66;
    dem.heights_m.assign(70 * 66, 10.0F);
    dem.voids.assign(dem.heights_m.size(), 0);
    dem.voids[dem.index(30, 30)] = 1;
    const auto stamps = [](const std::string& shape, int column) {
        return io::parse_stamps(R"({"stamps": [{"shape": ")" + shape + R"(", "first": [)" + std::to_string(column) +
                                    R"(, 28], "columns": 5, "rows": 5}]})",
                                "s.json");
    };
    const auto cut = edited_source(std::make_unique<DemSource>(dem), stamps("hole", 50), "s.json");
    const Field field = read_whole(*cut);
    CHECK(field.statistics.voids.count == 26);
    CHECK((std::isnan(field.heights_m[dem.index(50, 28)]) && !std::isnan(field.heights_m[dem.index(55, 28)])));
    CHECK(cut->properties(field.statistics).holes);
    CHECK_THROWS_WITH((void)edited_source(std::make_unique<DemSource>(dem), stamps("fill", 28), "s.json"),
                      "s.json: fills a void at column 30, row 30, where no file has a height; bake the heights first, "
                      "and give the pack with the stamps");
    const auto no_void =
        edited_source(std::make_unique<DemSource>(dem), stamps("fill", 50), "s.json"); // ground stays ground
    CHECK(read_whole(*no_void).statistics.voids.count == 1);
}
