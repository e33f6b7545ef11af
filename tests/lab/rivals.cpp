#include "lab/rivals.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "lab/mesh_picture.h"
#include "rivals/look.h"
#include "support/times.h"

namespace fjell::lab {

namespace {

using rivals::Face;
using rivals::Ground;
using rivals::Rival;
using rivals::unlimited_operations;
using test::worked_us;

// Methods that follow their view by a level a frame need as many as there are levels.
constexpr int settling_frames = 128, resting_frames = 40; // a morph goes on for some when nothing else changes
constexpr std::size_t few_cameras = 8;

} // namespace

void settle(Rival& rival, const View& view, double error_px) {
    std::uint32_t before = 0;
    const int rest = rival.traits().coherent ? resting_frames : 2;
    for (int i = 0, same = 0; i < settling_frames && same < rest; ++i) {
        io::check_interrupt();
        const rivals::Refined now = rival.refine(view, error_px, unlimited_operations);
        same = now.triangles == before && !now.interrupted ? same + 1 : 0;
        before = now.triangles;
    }
}

namespace {

struct Times {
    std::vector<double> us;
    double triangles = 0; // mean
};

Times fly(Rival& rival, const std::vector<View>& views, double error_px) {
    settle(rival, views[0], error_px);
    Times t;
    for (const View& view : views) {
        io::check_interrupt();
        const double start = worked_us();
        const rivals::Refined now = rival.refine(view, error_px, unlimited_operations);
        t.us.push_back(worked_us() - start);
        t.triangles += now.triangles / static_cast<double>(views.size());
    }
    return t;
}

// What many cameras see at rest.
struct Quality {
    double error_px = 0, in_view = 0, gap_px = 0; // in_view: mean
    std::size_t open_edges = 0, uncovered = 0, folds = 0;
};
Quality quality_at(Rival& rival, const Ground& ground, const std::vector<View>& views, double error_px, bool seams) {
    Quality q;
    std::vector<Face> faces;
    for (const View& view : views) {
        settle(rival, view, error_px);
        rival.faces(faces);
        const rivals::Look look = rivals::look_at(ground, faces, view);
        q.error_px = std::max(q.error_px, look.error_px);
        q.in_view += static_cast<double>(look.in_view) / static_cast<double>(views.size());
        q.uncovered += look.uncovered;
        q.folds += look.facing_down;
        if (!seams) continue;
        const rivals::Seams s = rivals::seams_of(ground, faces, view);
        q.open_edges += s.open_edges;
        q.gap_px = std::max(q.gap_px, s.gap_px);
    }
    return q;
}

// The largest threshold at which the true error keeps to `error_px`, to some percent, and the triangles it takes.
struct Equal {
    double threshold_px = 0, in_view = 0; // 0: there is none
};
Equal equal_error(Rival& rival, const Ground& ground, const std::vector<View>& views, double error_px) {
    Equal found;
    double low = -4, high = 3; // powers of two of error_px
    for (int i = 0; i < 8; ++i) {
        const double middle = (low + high) / 2, threshold_px = error_px * std::exp2(middle);
        const Quality q = quality_at(rival, ground, views, threshold_px, false);
        const bool within = q.error_px <= error_px;
        if (within) found = {threshold_px, q.in_view};
        (within ? low : high) = middle;
    }
    return found;
}

// Between each frame and the next: the largest change.
double popping_px(Rival& rival, const Ground& ground, const std::vector<View>& views, double error_px) {
    double most = 0;
    std::vector<Face> faces;
    std::vector<float> now, before;
    settle(rival, views[0], error_px);
    for (std::size_t i = 0; i < views.size(); ++i) {
        io::check_interrupt();
        (void)rival.refine(views[i], error_px, unlimited_operations);
        rival.faces(faces);
        before.swap(now);
        now = rivals::surface_of(ground, faces);
        if (i > 0) most = std::max(most, rivals::popping_px(ground, before, views[i - 1], now, views[i]));
    }
    return most;
}

double middle_of(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[(v.size() - 1) / 2];
}

nlohmann::json times_of(const Recipe& recipe, const Case& c, Rival& rival, Rival& lean,
                        const std::vector<View>& views) {
    std::vector<double> medians, ratios, worst;
    double triangles = 0;
    for (int i = 0; i < recipe.repetitions; ++i) {
        const Times reference = fly(lean, views, c.error_px), own = fly(rival, views, c.error_px);
        medians.push_back(middle_of(own.us));
        ratios.push_back(medians.back() / middle_of(reference.us));
        worst.push_back(*std::max_element(own.us.begin(), own.us.end()));
        triangles = own.triangles;
    }
    const auto [low, high] = std::minmax_element(medians.begin(), medians.end());
    return {{"triangles", triangles},
            {"median_us", middle_of(medians)},
            {"low_us", *low},
            {"high_us", *high},
            {"lean_ratio", middle_of(ratios)},
            {"worst_us", *std::min_element(worst.begin(), worst.end())}};
}

// cameras: along the site's path. Seams and equal errors are looked for from a few of them: they take longer.
void add_quality(const Case& c, const Ground& ground, Rival& rival, const std::vector<View>& views,
                 const std::vector<View>& cameras, nlohmann::json& all) {
    std::vector<View> some;
    const std::size_t count = std::min(cameras.size(), few_cameras);
    for (std::size_t i = 0; i < count; ++i) some.push_back(cameras[(2 * i + 1) * cameras.size() / (2 * count)]);
    const Quality seen = quality_at(rival, ground, cameras, c.error_px, false),
                  seams = quality_at(rival, ground, some, c.error_px, true);
    if (seen.uncovered > 0) throw io::Failure(1, "a rival leaves ground uncovered: its mesh is not one");
    all["triangles_in_view"] = seen.in_view;
    all["true_error_px"] = seen.error_px;
    all["folds"] = static_cast<double>(seen.folds) / static_cast<double>(cameras.size());
    all["open_edges"] = static_cast<double>(seams.open_edges) / static_cast<double>(count);
    all["gap_px"] = seams.gap_px;
    all["popping_px"] = popping_px(rival, ground, views, c.error_px);
    all["interruptible"] = rival.traits().interruptible ? 1 : 0;
    all["memory_mb"] = static_cast<double>(rival.bytes()) * 1e-6; // at this threshold
    if (const Equal e = equal_error(rival, ground, some, c.error_px); e.in_view > 0) {
        all["equal_threshold_px"] = e.threshold_px;
        all["equal_triangles"] = e.in_view;
    }
}

} // namespace

nlohmann::json measure_rival(const Recipe& recipe, const Case& c, World& world, const std::string& picture) {
    const std::string name = c.json().at("method");
    try {
        const Bout& bout = world.bout(c, recipe.tile_cells[0]);
        const Ground& ground = bout.ground;
        Rival* const rival = bout.rival.get();
        const std::vector<View> views = world.views(c, recipe.frames);
        nlohmann::json all = times_of(recipe, c, *rival, *bout.lean, views);
        const bool looks = recipe.measures_any({"triangles_in_view", "true_error_px", "folds", "open_edges", "gap_px",
                                                "popping_px", "memory_mb", "equal_threshold_px", "equal_triangles"});
        if (looks && c.cells_a_frame == recipe.cells_a_frame[0]) {
            Case on_path = c;
            on_path.cells_a_frame = 0;
            add_quality(c, ground, *rival, views, world.views(on_path, recipe.verify_frames), all);
        }
        if (c.cells_a_frame == recipe.cells_a_frame[0] && !picture.empty()) {
            std::vector<Face> faces;
            const View& view = views[views.size() / 2];
            settle(*rival, view, recipe.picture_px);
            rival->faces(faces);
            const std::string svg = mesh_svg(ground, faces, view, std::min(recipe.picture_cells, ground.side),
                                             fmt::format("{}, {:g} px", name, recipe.picture_px));
            io::AtomicFile file(picture);
            file.write(std::as_bytes(std::span(svg)));
            file.commit();
        }
        all["frames"] = views.size();
        return all;
    } catch (const std::invalid_argument& e) {
        throw io::Failure(1, fmt::format("{}: {}", recipe.file, e.what()));
    } catch (const std::runtime_error& e) {
        if (dynamic_cast<const io::Failure*>(&e)) throw;
        throw io::Failure(1, fmt::format("{}: {}", recipe.file, e.what()));
    }
}

std::vector<std::vector<std::string>> rivals_table(const Results& results) {
    const std::vector<std::string> quality{"true_error_px", "equal_triangles", "memory_mb",  "interruptible",
                                           "open_edges",    "folds",           "popping_px", "worst_us"};
    std::vector<std::vector<std::string>> rows(1);
    rows[0] = {heading_of("method")};
    for (const std::string& key : quality) rows[0].emplace_back(heading_of(key));
    rows[0].emplace_back("ns a vertex in the first flight");
    for (const double speed : results.recipe.cells_a_frame)
        rows[0].push_back(fmt::format("median [us] at {:g} cells a frame, and times lean", speed));
    for (const Way way : results.recipe.ways) {
        std::vector<std::string> row, times;
        for (const Result& r : results.all) {
            if (r.c.way != way || r.measured.empty()) continue;
            if (row.empty()) {
                row.push_back(r.c.json().at("method"));
                for (const std::string& key : quality) {
                    const auto v = r.value(key);
                    row.push_back(v ? fmt::format("{:.4g}", *v) : "-");
                }
                // But for the rim there are half as many vertices as triangles.
                row.push_back(
                    fmt::format("{:.3g}", 2000 * r.value("median_us").value_or(0) / r.value("triangles").value_or(1)));
            } else if (const auto most = r.value("worst_us"); most && *most > std::stod(row[quality.size()])) {
                row[quality.size()] = fmt::format("{:.4g}", *most); // of all speeds
            }
            times.push_back(
                fmt::format("{:.4g} ({:.2f})", r.value("median_us").value_or(0), r.value("lean_ratio").value_or(0)));
        }
        if (row.empty()) continue;
        times.resize(results.recipe.cells_a_frame.size(), "-");
        row.insert(row.end(), times.begin(), times.end());
        rows.push_back(row);
    }
    return rows;
}

} // namespace fjell::lab
