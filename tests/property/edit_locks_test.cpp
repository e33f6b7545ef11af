// Locks that stamps make (StampShape::lock): along them no view draws ground farther off than they allow, however it
// moves, and at rest all errors are those of a bake with the same locks.
#include <catch2/catch.hpp>

#include <cmath>
#include <deque>
#include <limits>

#include <nlohmann/json.hpp>

#include "baker/locks/locks.h"
#include "baker/read/edited_source.h"
#include "fjell/query.h"
#include "support/cut_scene.h"
#include "support/edited_ground.h"
#include "support/ground_truth.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

// A disc, a line that may cross itself, or a rectangle with a mask; on the terrain, or beside it.
io::KeptStamp random_lock(Random& random, const Terrain& terrain) {
    io::KeptStamp kept;
    Stamp& s = kept.plain;
    const double cell = terrain.spacing_x_m(), quantum = terrain.header().quantum_m;
    const auto place = [&](double extent) { return uniform(random, -0.1, 1.1) * extent; };
    s.shape = pick(random, 0, 4) != 0 ? StampShape::lock : StampShape::unlock;
    s.amount_m = pick(random, 0, 2) == 0 ? 0 : static_cast<float>(quantum * std::exp2(uniform(random, 0, 11)));
    s.radius_m = pick(random, 0, 1) == 0 ? 0 : static_cast<float>(cell * std::exp2(uniform(random, -2, 4)));
    switch (pick(random, 0, 2)) {
    case 0: s.x_m = place(terrain.extent_x_m()), s.z_m = place(terrain.extent_z_m()); break;
    case 1:
        for (int n = pick(random, 2, 6); n > 0; --n)
            kept.points.push_back({place(terrain.extent_x_m()), place(terrain.extent_z_m()), 0});
        break;
    default:
        s.radius_m = 0;
        s.first = {pick(random, -9, data_of(terrain).tree.columns()), pick(random, -9, data_of(terrain).tree.rows())};
        s.columns = pick(random, 1, 60), s.rows = pick(random, 1, 60);
        if (pick(random, 0, 1) != 0)
            for (int n = s.columns * s.rows; n > 0; --n)
                kept.mask.push_back(static_cast<std::uint8_t>(pick(random, 0, 255)));
        break;
    }
    return kept;
}

// Slow and simple: metres from a sample to what a lock lies on.
double away_m(const io::KeptStamp& lock, double x, double z) {
    if (lock.points.empty()) return std::hypot(x - lock.plain.x_m, z - lock.plain.z_m);
    double least = no_limit;
    for (std::size_t i = 1; i < lock.points.size(); ++i) {
        const StampPoint &a = lock.points[i - 1], &b = lock.points[i];
        const double dx = b.x_m - a.x_m, dz = b.z_m - a.z_m, length2 = dx * dx + dz * dz;
        const double t = length2 > 0 ? std::clamp(((x - a.x_m) * dx + (z - a.z_m) * dz) / length2, 0.0, 1.0) : 0;
        least = std::min(least, std::hypot(x - a.x_m - t * dx, z - a.z_m - t * dz));
    }
    return least;
}

// What is allowed at each sample, in metres, as one stamp after the other has left it. A sample whose distance is that
// of a radius may be either: rounding decides.
struct Allowed {
    explicit Allowed(const Terrain& terrain) : t(data_of(terrain)) {
        metres.assign(static_cast<std::size_t>(t.tree.columns()) * static_cast<std::size_t>(t.tree.rows()), no_limit);
    }
    [[nodiscard]] double& at(std::int32_t x, std::int32_t y) {
        return metres[static_cast<std::size_t>(y) * static_cast<std::size_t>(t.tree.columns()) +
                      static_cast<std::size_t>(x)];
    }
    void add(const io::KeptStamp& lock) {
        const Stamp& s = lock.plain;
        const double sx = t.header.spacing_m[0], sz = t.header.spacing_m[1],
                     reach = static_cast<double>(s.radius_m) + std::hypot(sx, sz);
        for (std::int32_t y = 0; y < t.tree.rows(); ++y)
            for (std::int32_t x = 0; x < t.tree.columns(); ++x) {
                const std::int32_t i = x - s.first.column, j = y - s.first.row;
                bool holds = false;
                if (s.columns == 0)
                    holds = away_m(lock, x * sx, z_of(y, sz)) <= reach;
                else if (i >= 0 && j >= 0 && i < s.columns && j < s.rows)
                    holds = lock.mask.empty() || lock.mask[static_cast<std::size_t>(j * s.columns + i)] >= 128;
                if (!holds) continue;
                double& to = at(x, y);
                to = s.shape == StampShape::lock ? std::min(to, static_cast<double>(s.amount_m)) : no_limit;
            }
    }
    static double z_of(std::int32_t y, double sz) { return y * sz; }
    const TerrainData& t;
    std::vector<double> metres;
};

// After any step: a vertex whose triangles are farther off than a locked sample under them allows has at least the code
// that every mesh draws, and so have its ancestors (check_bounds()).
std::string check_locks(const TerrainData& t, Allowed& allowed) {
    const LoadedGround ground{t};
    const DiamondTerms terms{t.errors, t.header.quantum_m, {t.header.spacing_m[0], t.header.spacing_m[1]}, 0, 0, false};
    for (const SampleIndex v : all_vertices(t)) {
        const TerrainData::Vertex own = t.vertex(v);
        if (!own.loaded || own.error_code >= t.errors.always(t.tree.level(v))) continue;
        const std::int32_t s = 1 << Tree::step_log2(v);
        double least = no_limit; // under the diamond
        for (std::int32_t y = std::max(v.row - s, 0); y <= std::min(v.row + s, t.tree.rows() - 1); ++y)
            for (std::int32_t x = std::max(v.column - s, 0); x <= std::min(v.column + s, t.tree.columns() - 1); ++x)
                if (Tree::kind(v) == VertexKind::centre || std::abs(x - v.column) + std::abs(y - v.row) <= s)
                    least = std::min(least, allowed.at(x, y));
        if (least == no_limit) continue;
        const std::uint32_t code =
            diamond_error(ground, terms, v, [&](SampleIndex a) { return t.tree.contains(a); }).code;
        if (code > t.errors.code_down(static_cast<float>(least)))
            return "a lock is not kept at " + std::to_string(v.column) + ", " + std::to_string(v.row);
    }
    return {};
}

io::LoadedPack bake_locked(baker::Dem dem, const std::deque<io::KeptStamp>& locks, const baker::BakeOptions& options) {
    std::vector<io::TimedStamp> stamps;
    for (const io::KeptStamp& lock : locks) stamps.push_back({0, lock});
    const TemporaryFolder folder;
    const auto source = baker::edited_source(std::make_unique<baker::DemSource>(std::move(dem)), stamps, "locks");
    (void)baker::bake(*source, options, folder / "pack.fjell");
    return io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
}

std::uint32_t always_drawn(const TerrainData& t) {
    std::uint32_t count = 0;
    for (const SampleIndex v : all_vertices(t)) count += t.vertex(v).error_code >= t.errors.always(t.tree.level(v));
    return count;
}

// Somewhere on the lock.
std::array<double, 2> place_on(Random& random, const io::KeptStamp& lock, const Terrain& terrain) {
    const Stamp& s = lock.plain;
    const double sx = terrain.spacing_x_m(), sz = terrain.spacing_z_m();
    if (s.columns > 0)
        return {s.first.column + uniform(random, 0, s.columns - 1), s.first.row + uniform(random, 0, s.rows - 1)};
    double x = s.x_m, z = s.z_m;
    if (!lock.points.empty()) {
        const auto i = static_cast<std::size_t>(pick(random, 1, static_cast<int>(lock.points.size()) - 1));
        const double t = uniform(random, 0, 1);
        x = lock.points[i - 1].x_m + t * (lock.points[i].x_m - lock.points[i - 1].x_m);
        z = lock.points[i - 1].z_m + t * (lock.points[i].z_m - lock.points[i - 1].z_m);
    }
    const double around = uniform(random, 0, 6.3), off_m = uniform(random, 0, static_cast<double>(s.radius_m));
    return {(x + std::cos(around) * off_m) / sx, (z + std::sin(around) * off_m) / sz};
}

// Of the drawn mesh, at places on locks: how often it is looked at where the view alone would not ask for as much.
int check_drawn(Random& random, const Terrain& terrain, const MeshView& mesh, const View& view, double error_px,
                const std::deque<io::KeptStamp>& locks, Allowed& allowed) {
    const TerrainData& t = data_of(terrain);
    const double float_m =
        0x1p-22 * (std::abs(static_cast<double>(t.range.high_m)) + std::abs(static_cast<double>(t.range.low_m)));
    const double across_m = std::hypot(terrain.extent_x_m(), terrain.extent_z_m());
    int needed = 0;
    for (int n = 0; n < 80; ++n) {
        const auto [column, row] = place_on(
            random, locks[static_cast<std::size_t>(pick(random, 0, static_cast<int>(locks.size()) - 1))], terrain);
        if (column < 0 || row < 0 || column > t.tree.columns() - 1 || row > t.tree.rows() - 1) continue;
        const auto i = std::min(static_cast<std::int32_t>(column), t.tree.columns() - 2),
                   j = std::min(static_cast<std::int32_t>(row), t.tree.rows() - 2);
        double most = 0; // of the cell's corners, all of which may have been unlocked since
        for (const std::int32_t k : {0, 1, 2, 3}) most = std::max(most, allowed.at(i + k % 2, j + k / 2));
        if (most == no_limit) continue;
        const TruePlane ground = true_plane(terrain, column, row);
        const double shown_m = drawn_m(mesh, column, row);
        if (ground.hole || std::isnan(shown_m)) continue; // beside a hole nothing is drawn
        const double off_m = std::abs(shown_m - at(ground, column, row)), rounding = 2 * rounding_m(terrain) + float_m;
        const double dx = column * terrain.spacing_x_m() - view.eye_m.x, dy = shown_m - view.eye_m.y,
                     dz = row * terrain.spacing_z_m() - view.eye_m.z;
        const double px_m = std::sqrt(dx * dx + dy * dy + dz * dz) / focal_length_px(view);
        CAPTURE(column, row, off_m, most, px_m, error_px);
        if (error_px * px_m > across_m / 50) continue; // the whole terrain is tiny
        REQUIRE(off_m <= most + rounding);
        needed += error_px * px_m > 10 * most;
    }
    return needed;
}

} // namespace

TEST_CASE("moving ground keeps its locks after every step, and at rest its errors are those of a bake with them",
          "[edit][locks]") {
    Random random(20261210);
    int applied = 0, locked = 0, counted = 0;
    for (int round = 0; round < rounds(12, 120); ++round) {
        const int log2 = pick(random, 2, 7);
        const std::int32_t side = 1 << log2;
        const auto extent = [&] { // whole tiles, or less
            const std::int32_t whole = pick(random, 1, std::max(1, 150 / side)) * side + 1;
            return pick(random, 0, 2) != 0 ? whole : std::max(whole - pick(random, 0, side / 2), 4);
        };
        const std::int32_t columns = extent(), rows = extent();
        const auto order = static_cast<PageOrder>(pick(random, 0, 2));
        CAPTURE(round, log2, columns, rows, static_cast<int>(order));
        const auto pack = framed_terrain(random, log2, columns, rows, order, false, true);
        const TerrainData& t = data_of(pack.terrain);
        REQUIRE(has_room_for_locks(t.header));
        Editor editor(pack.terrain);
        Allowed allowed(pack.terrain);
        std::deque<io::KeptStamp> locks; // stay where they are pointed to
        for (int n = 0; n < 8; ++n) {
            const bool is_lock = pick(random, 0, 1) != 0;
            Stamp stamp;
            if (is_lock)
                stamp = locks.emplace_back(random_lock(random, pack.terrain)).stamp();
            else if (stamp = random_stamp(random, pack.terrain); touches_frame(pack.terrain, stamp))
                continue;
            const StampId id = editor.push(stamp);
            EditReport report = editor.update(1);
            for (int step = 0; stamp_state(editor.edits, id).state == StampState::waiting; ++step) {
                REQUIRE(step < 1000);
                REQUIRE(check_bounds(t) == "");
                report = editor.update(1);
            }
            const StampResult result = stamp_state(editor.edits, id);
            CAPTURE(n, static_cast<int>(stamp.shape), result.status.field);
            if (is_lock) {
                REQUIRE(result.state == StampState::applied);
                REQUIRE(report.samples == 0);
                allowed.add(locks.back());
            } else {
                applied += result.state == StampState::applied;
            }
            REQUIRE(check_bounds(t) == "");
            REQUIRE(check_locks(t, allowed) == "");
            if (pick(random, 0, 2) == 0) report = editor.update();
        }
        const EditReport report = editor.update();
        CHECK(report.loose + report.unmeasured + report.waiting == 0);
        REQUIRE(check_locks(t, allowed) == "");
        locked += report.locks != 0;
        const std::uint32_t count = count_always_drawn(editor.edits);
        CHECK(count == always_drawn(t));
        counted += count > 10;
        baker::Dem dem = heights_of(t);
        dem.native_quantum_m = 1;
        baker::BakeOptions options = small_bake(log2);
        options.order = order, options.room_for_locks = true;
        const auto baked = bake_locked(std::move(dem), locks, options);
        REQUIRE(data_of(baked.terrain).header.error_floor_m == t.header.error_floor_m);
        CHECK(difference_of(t, data_of(baked.terrain)) == "");
        // All taken away: as if there had never been any.
        Stamp all;
        all.shape = StampShape::unlock, all.radius_m = 1e7f;
        editor.push(all);
        CHECK(editor.update().locks == 0);
        baker::Dem bare = heights_of(t);
        bare.native_quantum_m = 1;
        CHECK(difference_of(t, data_of(bake_and_load(std::move(bare), options).terrain)) == "");
    }
    CHECK(applied > rounds(8, 80));
    CHECK(locked > rounds(6, 60));
    CHECK(counted > rounds(5, 50));
}

TEST_CASE("a lock on even ground holds beside a crater before its errors are measured", "[edit][locks]") {
    Random random(20261217);
    int needed = 0;
    for (int round = 0; round < rounds(20, 300); ++round) {
        baker::Dem dem;
        dem.columns = dem.rows = 257;
        dem.heights_m.assign(257 * 257, 1000);
        // So that errors have codes: a wall in the corner.
        for (const std::int32_t x : {0, 1}) dem.heights_m[dem.index(x, 0)] = dem.heights_m[dem.index(x, 1)] = 0;
        dem.heights_m[dem.index(1, 0)] = 2000;
        dem.native_quantum_m = 1;
        baker::BakeOptions options = small_bake(pick(random, 6, 8));
        options.room_for_locks = true;
        const auto pack = bake_and_load(std::move(dem), options);
        const TerrainData& t = data_of(pack.terrain);
        Editor editor(pack.terrain);
        Allowed allowed(pack.terrain);
        std::deque<io::KeptStamp> locks(1);
        Stamp& lock = locks[0].plain;
        lock.shape = StampShape::lock, lock.amount_m = static_cast<float>(pick(random, 5, 50));
        const double cell = pack.terrain.spacing_x_m();
        lock.x_m = uniform(random, 60, 200) * cell, lock.z_m = uniform(random, 60, 200) * pack.terrain.spacing_z_m();
        editor.push(lock);
        (void)editor.update();
        allowed.add(locks[0]);
        const std::uint32_t before = count_always_drawn(editor.edits);
        Stamp crater;
        crater.shape = StampShape::crater, crater.amount_m = static_cast<float>(pick(random, 60, 300));
        crater.radius_m = static_cast<float>(uniform(random, 3, 9) * cell);
        crater.x_m = lock.x_m + uniform(random, -40, 40) * cell,
        crater.z_m = lock.z_m + uniform(random, -40, 40) * cell;
        const StampId id = editor.push(crater);
        (void)editor.update(1);
        CAPTURE(round, lock.x_m, lock.z_m, crater.x_m, crater.z_m);
        REQUIRE(stamp_state(editor.edits, id).state == StampState::applied);
        REQUIRE(check_bounds(t) == "");
        REQUIRE(check_locks(t, allowed) == "");
        needed += count_always_drawn(editor.edits) > before;
        (void)editor.update();
        REQUIRE(check_locks(t, allowed) == "");
    }
    CHECK(needed > rounds(10, 150));
}

TEST_CASE("along locks of stamps no view draws ground farther off than they allow, and elsewhere nothing changes",
          "[edit][locks]") {
    Random random(20261211);
    int needed = 0, alike = 0;
    for (int round = 0; round < rounds(12, 200); ++round) {
        const bool holes = pick(random, 0, 3) == 0;
        const int log2 = pick(random, 1, 6);
        baker::Dem dem = random_dem(random, pick(random, 3, 130), pick(random, 3, 130), Shape::fractal);
        for (double& spacing : dem.spacing_m) spacing = uniform(random, 0.5, 30);
        if (holes) add_random_holes(random, dem, log2);
        if (baker::void_count(dem) == dem.heights_m.size()) continue;
        baker::BakeOptions options = small_bake(log2, pick(random, 0, 2) == 0 ? 0.2 : 0.05);
        options.room_for_locks = true, options.order = static_cast<PageOrder>(pick(random, 0, 1)); // for a cut
        const auto pack = bake_and_load(dem, options), bare = bake_and_load(dem, options);
        CAPTURE(round, dem.columns, dem.rows, log2, pack.terrain.has_voids());
        Editor editor(pack.terrain), other(bare.terrain);
        Allowed allowed(pack.terrain);
        std::deque<io::KeptStamp> locks;
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        for (int n = 0; n < 6; ++n) {
            const bool is_lock = n == 0 || pick(random, 0, 1) != 0;
            const Stamp stamp = is_lock ? locks.emplace_back(random_lock(random, pack.terrain)).stamp()
                                        : random_stamp(random, pack.terrain);
            const StampId id = editor.push(stamp);
            (void)editor.update();
            if (is_lock) {
                allowed.add(locks.back());
            } else {
                const StampId same = other.push(stamp);
                (void)other.update();
                REQUIRE(stamp_state(other.edits, same).state == stamp_state(editor.edits, id).state);
            }
            const View view = random_view(random, pack.terrain);
            CutSettings settings;
            settings.max_error_px = std::exp2(uniform(random, -2, 5));
            settings.morph = Morph::none;
            (void)settle(cut, {&view, 1}, settings, 200);
            REQUIRE(check_cut(cut) == "");
            CHECK(recursive_triangles(pack.terrain, view, settings.max_error_px) == triangles_of(cut.mesh()));
            needed += check_drawn(random, pack.terrain, cut.mesh(), view, settings.max_error_px, locks, allowed);
        }
        // Far from locks errors are those of the same stamps without them.
        const TerrainData &a = data_of(pack.terrain), &b = data_of(bare.terrain);
        for (const SampleIndex v : all_vertices(a)) {
            const std::int32_t s = 5 << Tree::step_log2(v); // what children of children reach
            bool near = false;
            for (std::int32_t y = std::max(v.row - s, 0); y <= std::min(v.row + s, a.tree.rows() - 1) && !near; ++y)
                for (std::int32_t x = std::max(v.column - s, 0); x <= std::min(v.column + s, a.tree.columns() - 1); ++x)
                    near = near || allowed.at(x, y) != no_limit;
            if (near) continue;
            CAPTURE(v.column, v.row);
            REQUIRE(a.vertex(v).error_code == b.vertex(v).error_code);
            ++alike;
        }
    }
    CHECK(needed > rounds(300, 6000));
    CHECK(alike > rounds(1000, 30000));
}

TEST_CASE("pages that leave come back with their locks", "[edit][locks]") {
    Random random(20261212);
    Happened sum;
    for (int round = 0; round < rounds(12, 120); ++round) {
        CAPTURE(round);
        const auto pack = paged_terrain(random, pick(random, 0, 1) != 0);
        if (has_room_for_locks(pack.terrain.header())) dig_while_pages_leave(random, pack, 30, 3, sum, false, true);
    }
    CHECK(sum.locks > rounds(8, 80));
    CHECK(sum.left > rounds(10, 100));
}

TEST_CASE("a road that is locked is streamed from afar, where no view would ask for its pages", "[edit][locks]") {
    Random random(20261213);
    int needed = 0;
    std::uint32_t came = 0, stayed = 0;
    for (int round = 0; round < rounds(2, 20); ++round) {
        baker::BakeOptions options = small_bake(7);
        options.room_for_locks = true;
        const auto pack = bake_and_load(random_dem(random, 513, 400, Shape::fractal), options);
        const double wx = pack.terrain.extent_x_m(), wz = pack.terrain.extent_z_m();
        Streamed on(pack.pack, 0);
        ScriptedClient client(random, on, {.most_delay = 2});
        Editor editor(on.paged.terrain), whole(pack.terrain);
        std::deque<io::KeptStamp> locks(1);
        locks[0].plain.shape = StampShape::lock;
        locks[0].plain.amount_m = pack.terrain.header().quantum_m * 4;
        for (const double at : {0.1, 0.4, 0.8}) locks[0].points.push_back({at * wx, uniform(random, 0.2, 0.8) * wz, 0});
        Allowed allowed(pack.terrain);
        allowed.add(locks[0]);
        const View view = make_view({wx / 2, 2 * wx, wz / 2}, {0.01, -1, 0.01}, {0, 0, 1}, 1, 640, 480, 1, 100 * wx);
        CutSettings cut;
        cut.max_error_px = 2, cut.morph = Morph::none;
        StreamSettings settings;
        CutReport drawn;
        StreamReport streamed;
        EditReport report;
        const auto step = [&] {
            settings.now_s += 1.0 / 60;
            client.act();
            report = editor.update();
            streamed = on.update({&view, 1}, cut, settings);
            client.follow();
            drawn = on.cut.update({&view, 1}, cut);
        };
        for (int frame = 0; frame < 200; ++frame) step();
        const std::uint32_t missing = data_of(on.paged.terrain).pages_missing;
        editor.push(locks[0].stamp());
        whole.push(locks[0].stamp());
        (void)whole.update();
        int frames = 0;
        do step(); // what no view wants, and no lock, is not loaded to be measured
        while ((frames < 60 || !streamed.converged || !drawn.converged) && ++frames < 3000);
        CAPTURE(round, frames, missing, data_of(on.paged.terrain).pages_missing, report.unmeasured);
        REQUIRE((streamed.converged && drawn.converged));
        came += missing - data_of(on.paged.terrain).pages_missing; // under the road
        stayed += data_of(on.paged.terrain).pages_missing;
        // All that the whole terrain would draw; more where errors cannot be measured before other pages come.
        const VertexSet target = target_set(pack.terrain, pack.terrain, {&view, 1}, cut.max_error_px);
        CHECK(contains(active_set(on.cut), target));
        needed += check_drawn(random, pack.terrain, on.cut.mesh(), view, cut.max_error_px, locks, allowed);
    }
    CHECK(needed > rounds(50, 500));
    CHECK((came > 0 && stayed > 0));
}

TEST_CASE("a cut with too little room gives up all else before a lock", "[edit][locks]") {
    Random random(20261214);
    baker::BakeOptions options = small_bake(6);
    options.room_for_locks = true;
    const auto pack = bake_and_load(random_dem(random, 257, 257, Shape::fractal), options);
    Editor editor(pack.terrain);
    std::deque<io::KeptStamp> locks(1);
    locks[0].plain.shape = StampShape::lock;
    locks[0].points = {{0.1 * static_cast<double>(pack.terrain.extent_x_m()), 0.2, 0},
                       {0.7 * static_cast<double>(pack.terrain.extent_x_m()),
                        0.9 * static_cast<double>(pack.terrain.extent_z_m()), 0}};
    editor.push(locks[0].stamp());
    (void)editor.update();
    Allowed allowed(pack.terrain);
    allowed.add(locks[0]);
    const std::uint32_t count = count_always_drawn(editor.edits);
    CHECK(count > 1000);
    CutBudget budget = ample_cut(pack.terrain);
    budget.vertices = count + count / 8;
    Cut cut(pack.terrain, budget);
    const View view = view_from_above(pack.terrain, 0.2);
    CutSettings settings;
    settings.max_error_px = 0.01, settings.morph = Morph::none; // far more than there is room for
    CutReport report;
    for (int frame = 0; frame < 400; ++frame) report = cut.update({&view, 1}, settings);
    CHECK((report.exhausted & cut_budget_vertices) != 0);
    REQUIRE(check_cut(cut) == "");
    std::uint32_t drawn = 0;
    const VertexSet active = active_set(cut);
    const TerrainData& t = data_of(pack.terrain);
    for (const SampleIndex v : all_vertices(t))
        drawn += t.vertex(v).error_code >= t.errors.always(t.tree.level(v)) &&
                 active[static_cast<std::size_t>(v.row) * static_cast<std::size_t>(t.tree.grid_columns()) +
                        static_cast<std::size_t>(v.column)];
    CHECK(drawn == count);
    CHECK(check_drawn(random, pack.terrain, cut.mesh(), view, 0.01, locks, allowed) >= 0);
}

TEST_CASE("stamps that lock give the codes of the same locks in a file", "[edit][locks]") {
    using nlohmann::json;
    Random random(20261215);
    int raised = 0, areas = 0;
    for (int round = 0; round < rounds(4, 60); ++round) {
        const TemporaryFolder folder;
        baker::Dem dem = random_dem(random, pick(random, 40, 130), pick(random, 40, 130), Shape::fractal);
        for (double& spacing : dem.spacing_m) spacing = uniform(random, 0.5, 30);
        std::deque<io::KeptStamp> locks;
        json features = json::array();
        for (int n = pick(random, 1, 4); n > 0; --n) {
            io::KeptStamp& lock = locks.emplace_back();
            lock.plain.shape = StampShape::lock;
            lock.plain.amount_m = static_cast<float>(std::exp2(uniform(random, -6, 3)));
            lock.plain.radius_m = static_cast<float>(pick(random, 0, 3) * dem.spacing_m[0]);
            const bool line = pick(random, 0, 1) != 0;
            json places = json::array();
            for (int k = line ? pick(random, 2, 5) : 1; k > 0; --k) {
                const double x = uniform(random, 0, dem.columns - 1) * dem.spacing_m[0],
                             z = uniform(random, 0, dem.rows - 1) * dem.spacing_m[1];
                if (line)
                    lock.points.push_back({x, z, 0});
                else
                    lock.plain.x_m = x, lock.plain.z_m = z;
                places.push_back({x, -z});
            }
            features.push_back(
                {{"type", "Feature"},
                 {"properties",
                  {{"error_m", static_cast<double>(lock.plain.amount_m)},
                   {"width_m", 2 * static_cast<double>(lock.plain.radius_m)}}},
                 {"geometry", {{"type", line ? "LineString" : "Point"}, {"coordinates", line ? places : places[0]}}}});
        }
        spit(folder / "locks.json", json{{"type", "FeatureCollection"}, {"features", features}}.dump());
        baker::BakeOptions options = small_bake(pick(random, 3, 6));
        options.room_for_locks = true;
        const auto plain = bake_and_load(dem, options), by_edits = bake_locked(dem, locks, options);
        options.locks_path = folder / "locks.json";
        const auto by_file = bake_and_load(dem, options);
        CAPTURE(round);
        CHECK(difference_of(data_of(by_file.terrain), data_of(by_edits.terrain)) == "");
        raised += difference_of(data_of(plain.terrain), data_of(by_file.terrain)) != "";
        Editor editor(plain.terrain);
        for (const io::KeptStamp& lock : locks) editor.push(lock.stamp());
        (void)editor.update();
        CHECK(difference_of(data_of(plain.terrain), data_of(by_file.terrain)) == "");
        // As fjell-bake locks lays them, areas too.
        json ring = json::array();
        for (int k = pick(random, 3, 7); k > 0; --k)
            ring.push_back({uniform(random, -0.2, 1.2) * dem.columns * dem.spacing_m[0],
                            -uniform(random, -0.2, 1.2) * dem.rows * dem.spacing_m[1]});
        ring.push_back(ring[0]);
        features.push_back({{"type", "Feature"},
                            {"properties", {{"error_m", 0.5}, {"width_m", pick(random, 0, 1) * 3 * dem.spacing_m[0]}}},
                            {"geometry", {{"type", "Polygon"}, {"coordinates", json::array({ring})}}}});
        spit(folder / "locks.json", json{{"type", "FeatureCollection"}, {"features", features}}.dump());
        const std::vector<io::KeptStamp> stamps =
            baker::Locks(folder / "locks.json", {}, baker::DemSource(dem)).stamps("locks.json");
        const auto with_areas = bake_and_load(dem, options);
        options.locks_path.clear();
        const auto laid = bake_locked(dem, {stamps.begin(), stamps.end()}, options);
        CHECK(difference_of(data_of(with_areas.terrain), data_of(laid.terrain)) == "");
        areas += difference_of(data_of(with_areas.terrain), data_of(by_file.terrain)) != "";
    }
    CHECK(raised >= rounds(3, 50));
    CHECK(areas >= rounds(2, 40));
}

TEST_CASE("a lock that cannot be is refused by its field's name, and one that lies elsewhere changes nothing",
          "[edit][locks]") {
    Random random(20261216);
    const auto pack = rich_terrain(random, 129, 5);
    Editor editor(pack.terrain, {.locks = 4});
    const TerrainData& t = data_of(pack.terrain);
    const auto codes = [&] {
        std::vector<std::uint8_t> all;
        for (const SampleIndex v : all_vertices(t)) all.push_back(t.vertex(v).error_code);
        return all;
    };
    const auto before = codes();
    Stamp good;
    good.shape = StampShape::lock;
    good.x_m = static_cast<double>(pack.terrain.extent_x_m()) / 2,
    good.z_m = static_cast<double>(pack.terrain.extent_z_m()) / 2;
    StampId id = 0;
    const auto refused = [&](const auto& change) {
        Stamp stamp = good;
        change(stamp);
        const Status s = push_stamp(editor.edits, stamp, id);
        CHECK(s.code == StatusCode::out_of_range);
        return std::string(s.field);
    };
    CHECK(refused([](Stamp& s) { s.amount_m = NAN; }) == "Stamp::amount_m");
    CHECK(refused([](Stamp& s) { s.amount_m = -1; }) == "Stamp::amount_m");
    CHECK(refused([](Stamp& s) { s.radius_m = INFINITY; }) == "Stamp::radius_m");
    CHECK(refused([](Stamp& s) { s.point_count = 1; }) == "Stamp::points");
    CHECK(refused([](Stamp& s) { s.shape = static_cast<StampShape>(14); }) == "Stamp::shape");
    const auto applied = [&](const auto& change) {
        Stamp stamp = good;
        change(stamp);
        REQUIRE(push_stamp(editor.edits, stamp, id).ok());
        const EditReport report = editor.update();
        CHECK(report.locks <= 4);
        return stamp_state(editor.edits, id);
    };
    CHECK(applied([](Stamp& s) { s.x_m = -1e6; }).state == StampState::applied); // beside the terrain
    CHECK(applied([](Stamp& s) { s.strength = 0.4f; }).state == StampState::applied);
    CHECK(applied([](Stamp& s) { s.shape = StampShape::unlock; }).state == StampState::applied);
    CHECK((codes() == before));
    const StampResult whole = applied([](Stamp& s) { s.radius_m = 1e6f; });
    CHECK((whole.state == StampState::refused && whole.status.code == StatusCode::out_of_slots));
    CHECK(std::string(whole.status.field) == "EditBudget::locks");
    CHECK((codes() == before));
    CHECK(applied([](Stamp& s) { s.falloff_m = 1e6f; }).state == StampState::applied); // which a lock has none of
    CHECK((codes() != before));
    CHECK(count_always_drawn(editor.edits) > 0);
    CHECK(count_always_drawn({}) == 0);
    CHECK(edits_bytes(t.header, {.locks = 1u << 25}) == 0);
    std::uint64_t cursor = 0;
    bool lost = false;
    GroundRect rects[8];
    CHECK(take_ground_changes(editor.edits, cursor, rects, lost) == 0); // no ground has moved
    CHECK_FALSE(lost);
    // Errors that are estimates bound nothing, and fine steps have no codes for what is seen from afar.
    CHECK_FALSE(has_room_for_locks({}));
    baker::BakeOptions options = small_bake(5);
    options.estimate = ErrorEstimate::midpoint;
    const baker::Dem dem = random_dem(random, 65, 65, Shape::fractal);
    const auto guess = bake_and_load(dem, options);
    options = small_bake(5, 1);
    options.quantum_m = 1e-4;
    baker::Dem wide = random_dem(random, 65, 65, Shape::fractal);
    for (float& h : wide.heights_m) h = std::fmod(std::abs(h), 5.0f);
    wide.spacing_m[0] = wide.spacing_m[1] = 1000;
    const auto fine = bake_and_load(wide, options);
    options.room_for_locks = true;
    CHECK(has_room_for_locks(bake_and_load(wide, options).terrain.header()));
    for (const Terrain& terrain : {guess.terrain, fine.terrain}) {
        CHECK_FALSE(has_room_for_locks(terrain.header()));
        Editor without(terrain);
        const Status s = push_stamp(without.edits, good, id);
        CHECK(s.code == StatusCode::out_of_range);
        CHECK(std::string(s.field) ==
              "Stamp::shape (locks need a pack that is baked with --room-for-locks yes and --estimate max)");
    }
}
