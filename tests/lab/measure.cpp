#include "lab/measure.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "fjell/cut.h"
#include "fjell/io/failure.h"
#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "lab/pages.h"
#include "lab/rivals.h"
#include "rivals/look.h"
#include "rivals/ours.h"
#include "support/times.h"

namespace fjell::lab {

namespace {

using test::rank;
using test::worked_us;

constexpr int settling_updates = 8;

struct Flight {
    std::vector<double> us;
    double vertices = 0, triangles = 0; // sums
    std::size_t converged = 0;          // frames that kept to the threshold asked for
    double true_error_px = -1, popping_px = -1;
    PageCount pages{8};
};

double five_digits(double value) {
    return value == 0 ? 0 : std::stod(fmt::format("{:.5g}", value));
}

void check(const Status& status) {
    if (!status.ok()) throw io::Failure(1, fmt::format("{}: {}", status.field, message(status.code)));
}

template <typename Update>
double timed_us(const Update& update) {
    const double start = worked_us();
    update();
    return worked_us() - start;
}

// So many of all frames, evenly.
std::set<std::size_t> spread(int wanted, std::size_t frames) {
    std::set<std::size_t> found;
    const auto count = static_cast<std::size_t>(wanted);
    for (std::size_t i = 0; i < count; ++i) found.insert((2 * i + 1) * frames / (2 * count));
    return found;
}

// Looks at the meshes of some frames or of all, when the flight's times have been taken: looking fills the caches with
// other things.
class Observer {
public:
    Observer(const Recipe& recipe, const Case& c, const Terrain& terrain, std::size_t frames)
        : terrain_(terrain), case_(c), pages_(recipe.measures_any({"pages_in_use", "pages_read", "memory_pages",
                                                                   "memory_read", "memory_misses", "page_misses"})),
          popping_(recipe.measures_any({"popping_px"})) {
        if (recipe.measures_any({"true_error_px", "popping_px"})) verified_ = spread(recipe.verify_frames, frames);
    }
    [[nodiscard]] bool idle() const { return !pages_ && verified_.empty(); }
    [[nodiscard]] bool looks_at(std::size_t frame) const {
        return pages_ || verified_.contains(frame) || (popping_ && verified_.contains(frame + 1));
    }
    void look(std::size_t frame, const View& view, const MeshView& mesh, Flight& flight) {
        if (popping_) look_for_popping(frame, view, mesh, flight);
        if (verified_.contains(frame)) {
            const Frustum frustum = make_frustum(view);
            flight.true_error_px = std::max(flight.true_error_px, measure_error(terrain_, mesh, view, &frustum).max_px);
        }
        if (pages_) flight.pages.add(mesh, static_cast<std::int32_t>(terrain_.columns()), case_);
    }

private:
    // From the frame before each that is verified, to that.
    void look_for_popping(std::size_t frame, const View& view, const MeshView& mesh, Flight& flight) {
        if (!verified_.contains(frame) && !verified_.contains(frame + 1)) return;
        if (ground_.height_m.empty()) ground_ = rivals::square_around(terrain_);
        rivals::faces_of(mesh, faces_);
        before_.swap(now_);
        now_ = rivals::surface_of(ground_, faces_);
        if (verified_.contains(frame) && before_frame_ + 1 == frame)
            flight.popping_px =
                std::max(flight.popping_px, rivals::popping_px(ground_, before_, before_view_, now_, view));
        before_frame_ = frame;
        before_view_ = view;
    }
    const Terrain& terrain_;
    const Case& case_;
    bool pages_, popping_;
    rivals::Ground ground_;
    std::vector<rivals::Face> faces_;
    std::vector<float> now_, before_;
    std::size_t before_frame_ = 0;
    View before_view_;
    std::set<std::size_t> verified_;
};

Flight fly_recursive(const Recipe& recipe, const Case& c, World& world, const std::vector<View>& views) {
    const Terrain& terrain = world.terrain(c);
    const RecursiveBudget budget{world.vertex_slots(), 8 * world.vertex_slots()};
    const std::size_t bytes = recursive_bytes(terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    RecursiveMethod method;
    check(create_recursive(terrain, budget, {memory.get(), bytes}, method));
    RefineSettings settings;
    settings.max_error_px = c.error_px;
    settings.topology = Topology::strip; // as in the thesis
    FrameReport report;
    Flight f;
    for (int i = 0; i < settling_updates; ++i) check(update_recursive(method, views[0], settings, report));
    for (const View& view : views) {
        io::check_interrupt();
        f.us.push_back(timed_us([&] { check(update_recursive(method, view, settings, report)); }));
        f.vertices += report.vertices;
        f.triangles += report.triangles;
        f.converged += report.converged;
    }
    Observer observer(recipe, c, terrain, views.size());
    f.pages = PageCount(recipe.cache_mb);
    for (std::size_t frame = 0; frame < views.size(); ++frame) {
        if (!observer.looks_at(frame)) continue; // a mesh owes nothing to the one before
        io::check_interrupt();
        check(update_recursive(method, views[frame], settings, report));
        observer.look(frame, views[frame], recursive_mesh(method), f);
    }
    return f;
}

Flight fly_incremental(const Recipe& recipe, const Case& c, World& world, const std::vector<View>& views) {
    const Terrain& terrain = world.terrain(c);
    const CutBudget budget{world.vertex_slots(), 2 * world.vertex_slots() + 1024 * terrain.tile_count(), 512, 1};
    const std::size_t bytes = cut_bytes(terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    check(create_cut(terrain, budget, {memory.get(), bytes}, cut));
    CutSettings settings;
    settings.max_error_px = c.error_px;
    settings.offscreen_factor = c.offscreen_factor;
    CutReport report;
    const auto begin = [&] {
        check(rebuild_cut(cut, {&views[0], 1}, settings, report));
        for (int i = 0; i < settling_updates; ++i) check(update_cut(cut, {&views[0], 1}, settings, report));
    };
    Flight f;
    begin();
    for (const View& view : views) {
        io::check_interrupt();
        f.us.push_back(timed_us([&] { check(update_cut(cut, {&view, 1}, settings, report)); }));
        f.vertices += report.vertices;
        f.triangles += report.triangles;
        f.converged += report.converged;
        (void)cut_take_changes(cut); // as a renderer does
    }
    Observer observer(recipe, c, terrain, views.size());
    if (observer.idle()) return f;
    f.pages = PageCount(recipe.cache_mb);
    begin();
    for (std::size_t frame = 0; frame < views.size(); ++frame) {
        io::check_interrupt();
        check(update_cut(cut, {&views[frame], 1}, settings, report));
        if (observer.looks_at(frame)) observer.look(frame, views[frame], cut_mesh(cut).mesh, f);
    }
    return f;
}

Flight fly_lean(const Case& c, World& world, const std::vector<View>& views) {
    const std::vector<LeanSquare>& squares = world.lean(c);
    Flight f;
    const auto update = [&](const View& view) {
        double triangles = 0;
        for (const LeanSquare& square : squares) {
            View local = view;
            local.eye_m.x -= square.x_m;
            local.eye_m.z -= square.z_m;
            const auto frame = square.recursion->refine(local, c.error_px, true);
            if (!frame.whole) throw io::Failure(1, "lean: its strip is too short; ask for a larger threshold");
            triangles += frame.triangles;
        }
        return triangles;
    };
    for (int i = 0; i < settling_updates; ++i) (void)update(views[0]);
    for (const View& view : views) {
        io::check_interrupt();
        double triangles = 0;
        f.us.push_back(timed_us([&] { triangles = update(view); }));
        f.triangles += triangles;
        f.vertices += triangles / 2; // but for the rim
        ++f.converged;
    }
    return f;
}

// How fast the camera was, on average.
double mean_cells_a_frame(const std::vector<View>& views, double cell_m) {
    double flown_m = 0;
    for (std::size_t i = 1; i < views.size(); ++i) flown_m += length(views[i].eye_m - views[i - 1].eye_m);
    return flown_m / cell_m / static_cast<double>(std::max<std::size_t>(views.size() - 1, 1));
}

// Those of `all` that the recipe asks for.
nlohmann::json asked_for(const Recipe& recipe, const nlohmann::json& all, nlohmann::json measured) {
    for (const std::string& key : recipe.measures)
        if (all.contains(key)) measured[key] = five_digits(all[key].get<double>());
    return measured;
}

} // namespace

nlohmann::json measure_case(const Recipe& recipe, const Case& c, std::size_t number, World& world,
                            const Counting& counting, const std::string& out) {
    if (recipe.conclusion == "rivals") {
        const nlohmann::json all = measure_rival(recipe, c, world, out + "/" + picture_name(recipe, c));
        return asked_for(recipe, all, {{"frames", all["frames"]}});
    }
    const std::vector<View> views = world.views(c, recipe.frames);
    const nlohmann::json flown{{"frames", views.size()},
                               {"flown_cells_a_frame", five_digits(mean_cells_a_frame(views, world.cell_m()))}};
    if (recipe.counts()) {
        const rivals::Refined still = [&] { // here too: it bakes the pack, and says what is refused
            rivals::Rival& rival = *world.bout(c, recipe.tile_cells[0]).rival;
            settle(rival, views[0], c.error_px);
            return rival.refine(views[0], c.error_px, rivals::unlimited_operations);
        }();
        nlohmann::json all{{"triangles", still.triangles}};
        if (const auto count = instructions_a_frame(counting, recipe, number, views.size()))
            all["instructions"] = *count;
        return asked_for(recipe, all, flown);
    }
    if (recipe.draws()) {
        Drawing* const drawing = world.drawing(c);
        return asked_for(recipe,
                         drawing ? drawing->fly(c, views, spread(recipe.drawn_frames, views.size()),
                                                spread(recipe.verify_frames, views.size()))
                                 : nlohmann::json::object(),
                         flown);
    }
    const Flight f = c.way == Way::recursive     ? fly_recursive(recipe, c, world, views)
                     : c.way == Way::incremental ? fly_incremental(recipe, c, world, views)
                                                 : fly_lean(c, world, views);
    const auto frames = static_cast<double>(views.size());
    if (f.converged != views.size())
        throw io::Failure(1, fmt::format("{}: at {} px a budget does not suffice; ask for a larger threshold",
                                         recipe.file, c.error_px));
    nlohmann::json all{{"vertices", f.vertices / frames},
                       {"triangles", f.triangles / frames},
                       {"median_us", rank(f.us, 0.5)},
                       {"p99_us", rank(f.us, 0.99)},
                       {"worst_us", rank(f.us, 1)}};
    if (f.true_error_px >= 0) all["true_error_px"] = f.true_error_px;
    if (f.popping_px >= 0) all["popping_px"] = f.popping_px;
    if (f.pages.frames > 0) {
        const auto count = static_cast<double>(f.pages.frames);
        all["memory_read"] = f.pages.memory_read.size();
        all["memory_misses"] = static_cast<double>(f.pages.memory_misses) / count;
        all["page_misses"] = static_cast<double>(f.pages.misses) / count;
        all["pages_in_use"] = f.pages.pages / count;
        all["pages_read"] = f.pages.read.size();
        all["memory_pages"] = f.pages.memory_pages / count;
    }
    if (c.way != Way::lean && recipe.measures_any({"bake_s"})) all["bake_s"] = world.bake_s(c);
    return asked_for(recipe, all, flown);
}

} // namespace fjell::lab
