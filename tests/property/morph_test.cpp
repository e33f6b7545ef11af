// invariant 9: as the camera's step goes to zero, so does the largest change on screen.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// The drawn surface at every sample.
std::vector<double> surface(const Terrain& terrain, Cut& cut) {
    const MeshView mesh = cut.mesh();
    const CutMesh live = cut_mesh(cut.cut);
    const MorphFrame frame = cut_mesh(cut.cut).frame;
    const auto columns = static_cast<std::size_t>(data_of(terrain).tree.columns());
    std::vector<double> heights(columns * static_cast<std::size_t>(data_of(terrain).tree.rows()),
                                std::numeric_limits<double>::quiet_NaN());
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; i += 3) {
            double x[3], y[3], h[3];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t slot = mesh.indices[i + k];
                x[k] = mesh.vertices[slot].column, y[k] = mesh.vertices[slot].row;
                h[k] = morphed_height_m(terrain, mesh.vertices[slot], live.morph[slot], frame);
            }
            const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
            const auto [x0, x1] = std::minmax({x[0], x[1], x[2]});
            const auto [y0, y1] = std::minmax({y[0], y[1], y[2]});
            for (double py = y0; py <= y1; ++py)
                for (double px = x0; px <= x1; ++px) {
                    const double a = ((x[1] - px) * (y[2] - py) - (x[2] - px) * (y[1] - py)) / area;
                    const double b = ((x[2] - px) * (y[0] - py) - (x[0] - px) * (y[2] - py)) / area;
                    if (a < 0 || b < 0 || a + b > 1) continue;
                    heights[static_cast<std::size_t>(py) * columns + static_cast<std::size_t>(px)] =
                        a * h[0] + b * h[1] + (1 - a - b) * h[2];
                }
        }
    return heights;
}

double largest_step_px(const Terrain& terrain, const View& view, const std::vector<double>& before,
                       const std::vector<double>& after) {
    double most = 0;
    const std::int32_t columns = data_of(terrain).tree.columns();
    for (std::size_t i = 0; i < after.size(); ++i) {
        const auto at = static_cast<std::int32_t>(i);
        const Vec3 p{terrain.x_m(at % columns), after[i], terrain.z_m(at / columns)};
        most = std::max(most, std::abs(after[i] - before[i]) * focal_length_px(view) / length(p - view.eye_m));
    }
    return most;
}

struct Flight {
    double largest_px = 0, largest_of_threshold = 0;
    int threshold_steps = 0;
    std::uint32_t changes = 0, most_morphing = 0, morphing_frames = 0;
};

// Hundredths of a cell, low over the ground, 60 frames a second.
Flight fly(const Terrain& terrain, const CutBudget& budget, CutSettings settings, std::uint32_t items, int frames,
           double step_cells = 0.01) {
    Cut cut(terrain, budget);
    const double cell = terrain.spacing_x_m(), x = terrain.x_m(data_of(terrain).tree.columns() - 1);
    Vec3 eye{0.3 * x, 0, 0.4 * x};
    eye.y = terrain.header().max_m + 3 * cell;
    const auto look = [&] { return make_view(eye, {0.8, -0.1, 0.6}, {0, 1, 0}, 0.8, 1280, 720, 1, 1e6); };
    View view = look();
    double threshold_px = cut.rebuild({&view, 1}, settings).threshold_px;
    Flight flight;
    std::vector<double> before;
    settings.max_work = items;
    for (int frame = 0; frame < frames; ++frame) {
        eye = eye + Vec3{0.8, 0.05, 0.6} * (step_cells * cell);
        view = look();
        settings.now_s = frame / 60.0;
        const CutReport report = cut.update({&view, 1}, settings);
        REQUIRE(check_cut(cut) == "");
        flight.changes += report.activations + report.deactivations;
        flight.most_morphing = std::max(flight.most_morphing, report.morphing);
        flight.morphing_frames += report.morphing != 0;
        flight.threshold_steps += std::exchange(threshold_px, report.threshold_px) != report.threshold_px;
        const std::vector<double> after = surface(terrain, cut);
        const double step_px = before.empty() ? 0 : largest_step_px(terrain, view, before, after);
        flight.largest_px = std::max(flight.largest_px, step_px);
        flight.largest_of_threshold = std::max(flight.largest_of_threshold, step_px / threshold_px);
        before = after;
    }
    return flight;
}

} // namespace

TEST_CASE("morphing by error, no sample jumps by more than a twentieth of a pixel in a hundredth of a cell") {
    Random random(301);
    for (int round = 0; round < rounds(1, 6); ++round) {
        const auto pack = rich_terrain(random, 65, 6);
        const CutBudget ample = ample_cut(pack.terrain);
        CutSettings settings;
        settings.max_error_px = 1;
        settings.morph = Morph::error;
        const Flight morphed = fly(pack.terrain, ample, settings, unlimited_work, 700);
        CAPTURE(round, morphed.changes);
        CHECK(morphed.changes > 20); // or nothing was tested
        CHECK(morphed.largest_px < 0.05);
        CHECK(morphed.most_morphing == 0);
        settings.morph = Morph::none;
        CHECK(fly(pack.terrain, ample, settings, unlimited_work, 700).largest_px > 0.25); // the measure sees pops
    }
}

TEST_CASE("what is activated late morphs by time, and nothing jumps either") {
    Random random(302);
    for (const auto& [morph, step_cells] : first_of(
             2,
             {std::pair{Morph::time, 0.01}, {Morph::error, -0.01}, {Morph::error, 0.01}})) { // back: deactivations lag
        const auto pack = rich_terrain(random, 65, 6);
        CutSettings settings;
        settings.max_error_px = 1;
        settings.morph = morph;
        settings.morph_s = 10; // 1/600 of a displacement a frame
        const Flight late = fly(pack.terrain, ample_cut(pack.terrain), settings, 2, 900, step_cells);
        CAPTURE(static_cast<int>(morph), step_cells, late.changes, late.morphing_frames);
        CHECK(late.changes > 20);
        CHECK(late.most_morphing > 0);
        CHECK(late.largest_px < 0.05);
    }
}

TEST_CASE("what waits for a vertex that morphs is looked at when that has arrived, and not whenever another one has") {
    Random random(611);
    int waited = 0;
    for (int round = 0; round < rounds(12, 60); ++round) {
        const auto pack = rich_terrain(random, 257, 8);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = 8;
        settings.morph = Morph::time;
        View view = random_view(random, terrain);
        int frame = 0;
        const auto update = [&] {
            view.eye_m.x += 0.3 * terrain.header().spacing_m[0]; // so that vertices arrive in most frames
            settings.now_s = frame++ / 60.0;
            return cut.update({&view, 1}, settings);
        };
        for (int i = 0; i < 20; ++i) (void)update();
        settings.max_error_px = 0.25;
        const CutReport first = update();
        if (first.waiting < 100) continue; // a view from far away
        ++waited;
        double evaluations = 0, changes = 0;
        CutReport report;
        for (int i = 0; i < 14; ++i) { // the first have not arrived yet
            report = update();
            evaluations += report.evaluations;
            changes += report.activations + report.deactivations;
        }
        CAPTURE(round, first.waiting, evaluations, changes);
        CHECK(evaluations < first.waiting / 4 + 2 * changes); // 14 times as many, were all tried in every frame
        CHECK(report.waiting > first.waiting / 2);
        for (int i = 0; i < 400 && report.waiting != 0; ++i) {
            view.eye_m.x -= 0.3 * terrain.header().spacing_m[0]; // it rests
            report = update();
        }
        CHECK(report.waiting == 0); // nobody was forgotten
    }
    CHECK(waited > 2);
}

TEST_CASE("where vertices morph a capacity that is spent moves the mesh in many small steps, and in pops where not") {
    Random random(306);
    int governed = 0;
    for (int round = 0; round < rounds(2, 8); ++round) {
        const auto pack = rich_terrain(random, 65, 6);
        CutSettings settings;
        settings.max_error_px = 1;
        CutBudget scarce = ample_cut(pack.terrain);
        const View above = view_from_above(pack.terrain, 0.1);
        Cut cut(pack.terrain, scarce);
        scarce.vertices = cut.rebuild({&above, 1}, settings).vertices * pick(random, 20u, 60u) / 100 + 60;
        const Flight popping = fly(pack.terrain, scarce, settings, unlimited_work, 600, 0.02);
        settings.morph = Morph::error;
        const Flight morphed = fly(pack.terrain, scarce, settings, unlimited_work, 600, 0.02);
        CAPTURE(round, scarce.vertices, popping.threshold_steps, morphed.threshold_steps, popping.largest_of_threshold);
        if (morphed.threshold_steps == 0) continue;
        ++governed;
        CHECK(popping.largest_of_threshold > 0.5);
        CHECK(morphed.largest_of_threshold < 0.2); // a sixteenth of the way in a frame, of two levels
    }
    REQUIRE(governed > 0);
}

TEST_CASE("the narrowest nesting does not hold the governor up") {
    Random random(307);
    const auto pack = bake_and_load(random_dem(random, 65, 65, Shape::fractal), small_bake(6, 0.001));
    const View view = view_from_above(pack.terrain, 0.1);
    CutSettings settings;
    settings.morph = Morph::error;
    settings.max_error_px = 0.1;
    CutBudget budget = ample_cut(pack.terrain);
    Cut ample(pack.terrain, budget);
    budget.vertices = ample.rebuild({&view, 1}, settings).vertices / 4;
    settings.max_work = 1000;
    Cut cut(pack.terrain, budget);
    CutReport report;
    int frames = 0;
    do {
        settings.now_s = ++frames / 60.0;
        report = cut.update({&view, 1}, settings);
    } while (frames < 300 && (report.waiting != 0 || report.vertices < budget.vertices / 2));
    CAPTURE(frames, report.threshold_px, report.blocked);
    CHECK(report.waiting == 0);
    CHECK(report.threshold_px > 1.5 * settings.max_error_px); // it had some way to go
}

TEST_CASE("a vertex morphs over all of the way that nesting leaves it, and not before the edge it splits has arrived") {
    Random random(305);
    for (int round = 0; round < 40; ++round) {
        const auto pack = rich_terrain(random, 33, pick(random, 2, 5));
        const Terrain& terrain = pack.terrain;
        const View view = view_from_above(terrain, uniform(random, 1, 30));
        const auto distance_m = [&](SampleIndex c) {
            const double height_m = static_cast<double>(data_of(terrain).vertex(c).height_m);
            return length(Vec3{terrain.x_m(c.column), height_m, terrain.z_m(c.row)} - view.eye_m);
        };
        const auto reach_m = [&](SampleIndex c, double q) {
            const TerrainData::Vertex v = data_of(terrain).vertex(c);
            return static_cast<double>(v.radius_m) + static_cast<double>(v.error_m) * q;
        };
        // A threshold at which some vertex has just begun: there the edges' ends have the least to spare.
        const SampleIndex some{pick(random, 0, 32), pick(random, 0, 32)};
        const double error_m = static_cast<double>(data_of(terrain).vertex(some).error_m);
        if (data_of(terrain).tree.is_corner(some) || error_m == 0) continue;
        const double nested = 1 + static_cast<double>(terrain.header().nesting);
        const double start_q = 1.0001 * (distance_m(some) - reach_m(some, 0)) / error_m;
        CutSettings settings;
        settings.max_error_px = std::clamp(nested * nested * focal_length_px(view) / start_q, 1e-3, 1e6);
        settings.morph = Morph::error;
        Cut cut(terrain, ample_cut(terrain));
        (void)cut.update({&view, 1}, settings);
        const MorphView morph = cut_mesh(cut.cut).frame.view[0];
        const double start_per_error = static_cast<double>(morph.start_per_error),
                     full_per_error = static_cast<double>(morph.full_per_error);
        CAPTURE(round, settings.max_error_px);
        CHECK(std::abs(start_per_error / full_per_error / (nested * nested) - 1) <
              0x1p-22); // both are rounded to floats
        int early = 0;
        constexpr double rounding = 1 + 0x1p-20; // of errors, radii and the eye, which are floats
        for (std::int32_t y = 0; y < data_of(terrain).tree.rows(); ++y)
            for (std::int32_t x = 0; x < data_of(terrain).tree.columns(); ++x) {
                const SampleIndex c{x, y};
                if (data_of(terrain).tree.is_corner(c) || distance_m(c) * rounding > reach_m(c, start_per_error))
                    continue;
                for (const SampleIndex end : diamond(data_of(terrain).tree, c).ends)
                    early += !data_of(terrain).tree.is_corner(end) &&
                             distance_m(end) > reach_m(end, full_per_error) * rounding;
            }
        CHECK(early == 0);
    }
}

TEST_CASE("morphing switched on later starts where it would have, had it been on") {
    Random random(304);
    for (int round = 0; round < rounds(12, 40); ++round) {
        const auto pack = random_terrain(random, 100, 6);
        Cut later(pack.terrain, ample_cut(pack.terrain)), always(pack.terrain, ample_cut(pack.terrain));
        const View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        (void)later.rebuild({&view, 1}, settings);
        settings.morph = Morph::error;
        (void)later.update({&view, 1}, settings);
        (void)(round % 2 ? always.rebuild({&view, 1}, settings) : always.update({&view, 1}, settings));
        REQUIRE(check_cut(later) == "");
        const std::vector<double> a = surface(pack.terrain, later), b = surface(pack.terrain, always);
        double apart = 0; // triangles come in another order: an edge's heights may be summed the other way round
        for (std::size_t i = 0; i < a.size(); ++i)
            if (std::isnan(a[i]) != std::isnan(b[i]) || std::abs(a[i] - b[i]) > apart)
                apart = std::isnan(a[i]) != std::isnan(b[i]) ? 1e9 : std::abs(a[i] - b[i]);
        REQUIRE(apart <=
                1e-12 * std::max(std::abs(pack.terrain.header().max_m), std::abs(pack.terrain.header().min_m)));
    }
}

TEST_CASE("morphed or not, a converged frame holds the screen bound") {
    Random random(303);
    for (int round = 0; round < rounds(12, 40); ++round) {
        const auto pack = rich_terrain(random, pick(random, 20, 90), pick(random, 3, 6));
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain, 2));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.morph = Morph::error;
        View views[2] = {random_view(random, terrain), random_view(random, terrain)};
        views[1].max_error_px = random_threshold(random);
        for (int frame = 0; frame < 10; ++frame) {
            for (View& view : views) view = moved(random, view, random_step_m(random, terrain));
            settings.now_s = frame;
            const auto count = static_cast<std::size_t>(pick(random, 1, 2)); // the second one comes and goes
            const CutReport report = cut.update({views, count}, settings);
            CAPTURE(round, frame, count, settings.max_error_px, views[1].max_error_px);
            if (!report.converged) continue;
            const std::vector<double> drawn = surface(terrain, cut);
            const std::int32_t columns = data_of(terrain).tree.columns();
            for (std::size_t n = 0; n < count * drawn.size(); ++n) {
                const View& view = views[n / drawn.size()];
                const std::size_t i = n % drawn.size();
                const SampleIndex c{static_cast<std::int32_t>(i) % columns, static_cast<std::int32_t>(i) / columns};
                const double height = data_of(terrain).height_m(c);
                const Vec3 p{terrain.x_m(c.column), height, terrain.z_m(c.row)};
                const double error_px = std::abs(height - drawn[i]) * focal_length_px(view) / length(p - view.eye_m);
                // Heights are floats, and morphing rounds once more: some 2^-22 of the largest height.
                const double rounding_px =
                    0x1p-21 * std::max(std::abs(terrain.header().max_m), std::abs(terrain.header().min_m)) *
                    focal_length_px(view) / length(p - view.eye_m);
                REQUIRE(error_px <= (view.max_error_px > 0 ? view.max_error_px : settings.max_error_px) + rounding_px);
            }
        }
    }
}

// Pages that are evicted: their vertices morph out before they are deactivated. The eye rests, so nothing else moves.
TEST_CASE("pages are evicted without a jump when vertices morph, and with one when they do not") {
    Random random(212);
    for (int round = 0; round < rounds(1, 2); ++round) {
        const auto pack = bake_and_load(random_dem(random, 129, 129, Shape::fractal), small_bake(7));
        const View view = view_from_above(pack.terrain, 0.05);
        double largest_px[2] = {};
        for (const bool morphs : {false, true}) {
            PagedTerrain paged(pack.pack, {});
            for (std::uint32_t page = 0; page < paged.terrain.page_count(); ++page)
                REQUIRE(load_page(pack.pack, paged.terrain, 0, page).ok());
            Cut cut(paged.terrain, ample_cut(pack.terrain));
            CutSettings settings;
            settings.max_error_px = 0.3;
            settings.morph = morphs ? Morph::error : Morph::none;
            settings.morph_s = 0.25;
            (void)cut.rebuild({&view, 1}, settings);
            constexpr int frames_a_morph = 100; // a step is a hundredth of the way
            std::vector<double> before = surface(paged.terrain, cut);
            // The finest pages first, as a stream does.
            std::uint32_t gone = 0, removed = 0, morphing = 0;
            for (std::uint32_t page = paged.terrain.page_count() - 1; page >= 2; --page) {
                bool released = false;
                for (int frame = 0; frame < 5 * frames_a_morph && !released; ++frame) {
                    REQUIRE(cut_release_page(cut.cut, 0, page, released).ok());
                    if (released) break;
                    settings.now_s += settings.morph_s / frames_a_morph;
                    settings.max_work = frame % 3 ? unlimited_work : 200;
                    const CutReport report = cut.update({&view, 1}, settings);
                    CAPTURE(round, morphs, page, frame);
                    REQUIRE(check_cut(cut) == "");
                    REQUIRE(report.work == report.evaluations + report.activations + report.deactivations);
                    REQUIRE(report.work <= settings.max_work);
                    removed += report.deactivations;
                    morphing += report.morphing != 0;
                    const std::vector<double> after = surface(paged.terrain, cut);
                    largest_px[morphs] =
                        std::max(largest_px[morphs], largest_step_px(paged.terrain, view, before, after));
                    before = after;
                }
                REQUIRE(released);
                (void)unload_page(paged.terrain, 0, page);
                ++gone;
            }
            REQUIRE(gone > 3);
            REQUIRE(removed > 100);
            REQUIRE((morphing > 100) == morphs);
        }
        CAPTURE(round, largest_px[0], largest_px[1]);
        REQUIRE(largest_px[0] > 1);
        // Of two levels that morph out one after the other, and of rounding, no more than a few hundredths.
        REQUIRE(largest_px[1] < 0.05 * largest_px[0]);
    }
}
