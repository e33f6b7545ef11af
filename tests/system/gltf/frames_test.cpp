// The mesh of a frame as it stands, whatever it lacks, seen by the checker: what the file says of itself is true.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "fjell/gltf/snapshot.h"
#include "gltf/baked.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Frames as files, and one run of the checker for all.
class Frames {
public:
    Frames(bool holes, int round) : baked_(folder_, terrain(holes, round), options()) {}

    [[nodiscard]] const BakedTerrain& baked() const { return baked_; }
    [[nodiscard]] View view(double fov_rad = 0.8) const {
        View v = view_of(baked_.terrain);
        return make_view(v.eye_m, v.forward, {0, 1, 0}, fov_rad, 640, 360, 1, v.far_m);
    }
    // Two metres over the ground, in the middle.
    [[nodiscard]] View low_view() const {
        const Vec3 middle{0.5 * baked_.terrain.extent_x_m(), 0, 0.5 * baked_.terrain.extent_z_m()};
        const double ground_m = data_of(baked_.terrain).ground_m(middle.x, middle.z);
        return make_view({middle.x, ground_m + 2, middle.z}, {1, -0.1, 0.3}, {0, 1, 0}, 1, 640, 360, 0.1, 1e5);
    }

    // Not where a coarse mesh has a hole at every triangle.
    [[nodiscard]] bool draws_something() const {
        Cut cut(baked_.terrain, ample_cut(baked_.terrain));
        const View seen = view();
        return cut.rebuild({&seen, 1}, {.max_error_px = 4}).triangles_drawn != 0;
    }

    gltf::SnapshotInfo add(const std::string& name, Cut& cut, const View& view, const CutSettings& settings,
                           const CutReport& report) {
        const gltf::Snapshot snapshot =
            gltf::take_snapshot(data_of(cut.cut).pages.grid.handle, cut.cut, view, settings, report);
        CHECK(snapshot.counts().triangles == report.triangles_drawn); // the frame's mesh, and no other
        return write(name, snapshot);
    }
    gltf::SnapshotInfo add(const std::string& name, Recursive& method, const View& view, const RefineSettings& settings,
                           const FrameReport& report) {
        const gltf::Snapshot snapshot = gltf::take_snapshot(baked_.terrain, method.method, view, settings, report);
        CHECK(snapshot.counts().triangles == report.triangles);
        return write(name, snapshot);
    }
    void check() const {
        const NodeResult result = node("check.mjs", files_ + baked_.heights_argument);
        INFO(result.output);
        REQUIRE(result.exit_code == 0);
    }

private:
    // The terrain ends inside its last tiles; ground between holes and holes in the ground.
    static baker::Dem terrain(bool holes, int round) {
        baker::Dem dem = hills(115 + 37 * round, 86 + 17 * round, 29.7, 31.3);
        Random random(static_cast<std::uint32_t>(7 + round));
        if (holes) add_random_holes(random, dem, 5);
        return dem;
    }
    static baker::BakeOptions options() {
        baker::BakeOptions o;
        o.tile_log2 = 5;
        o.max_texture_log2 = 5;
        return o;
    }
    gltf::SnapshotInfo write(const std::string& name, const gltf::Snapshot& snapshot) {
        const std::string path = folder_ / (name + ".glb");
        INFO(name);
        const gltf::SnapshotCounts plain = gltf::write_snapshot(baked_.pack, snapshot, path);
        const std::string rounded = folder_ / (name + "-rounded.glb");
        const gltf::SnapshotCounts small = gltf::write_snapshot(baked_.pack, snapshot, rounded, {.quantised = true});
        CHECK(small.vertices == plain.vertices);
        CHECK(small.file_bytes + 7 * plain.vertices < plain.file_bytes + 8000); // 8 a vertex; JSON has more
        files_ += " '" + path + "' '" + rounded + "'";
        return snapshot.info();
    }

    Folder folder_;
    BakedTerrain baked_;
    std::string files_;
};

void add_live_frames(Frames& frames) {
    const Terrain& terrain = frames.baked().terrain;
    const View view = frames.view(), low = frames.low_view();
    CutSettings settings{.max_error_px = 2};
    Cut cut(terrain, ample_cut(terrain));
    CutReport report = cut.rebuild({&view, 1}, settings);
    CHECK(frames.add("converged", cut, view, settings, report).converged);

    settings.max_work = 150;
    report = cut.update({&low, 1}, settings);
    const gltf::SnapshotInfo lagging = frames.add("lagging", cut, low, settings, report);
    CHECK(lagging.lagging);
    CHECK_FALSE(lagging.converged);
    CHECK(lagging.error_bound_px > 2);
    CHECK(lagging.error_px == 2);

    CutBudget few = ample_cut(terrain);
    few.vertices = 4 * terrain.tile_count() + 200;
    Cut capped(terrain, few);
    settings.max_work = unlimited_work;
    for (int frame = 0; frame < 40; ++frame) report = capped.update({&view, 1}, settings);
    const gltf::SnapshotInfo full = frames.add("capped", capped, view, settings, report);
    CHECK_FALSE(full.converged);
    CHECK(full.error_bound_px > 2);
}

void add_morphed_frames(Frames& frames) {
    const Terrain& terrain = frames.baked().terrain;
    for (const Morph morph : {Morph::error, Morph::time}) {
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings{.max_error_px = 3, .morph = morph};
        View view = frames.view();
        (void)cut.rebuild({&view, 1}, settings);
        CutReport report;
        for (int frame = 0; frame < 4; ++frame) {
            view.eye_m = view.eye_m + Vec3{40, -5, -60};
            settings.now_s += 1 / 60.0;
            report = cut.update({&view, 1}, settings);
        }
        const std::string name = morph == Morph::error ? "morphed" : "morphed-by-time";
        CHECK(frames.add(name, cut, view, settings, report).morphed);
    }
}

void add_recursive_frames(Frames& frames) {
    Recursive method(frames.baked().terrain, ample_budget(frames.baked().terrain));
    for (const bool cull : {false, true})
        for (const Topology topology : {Topology::triangles, Topology::strip}) {
            const RefineSettings settings{.max_error_px = 2, .cull = cull, .topology = topology};
            const View view = frames.low_view();
            const FrameReport report = method.update(view, settings);
            const gltf::SnapshotInfo info =
                frames.add(std::string(cull ? "culled" : "recursive") + (topology == Topology::strip ? "-strip" : ""),
                           method, view, settings, report);
            CHECK(info.culled == cull);
            CHECK(info.converged == !cull);
        }
}

void add_corner_safe_frames(Frames& frames) {
    const Terrain& terrain = frames.baked().terrain;
    View view = frames.view(1.9);
    for (const double pitch : {-0.05, -0.7}) {
        view = make_view(view.eye_m, {0.3, pitch, -1}, {0, 1, 0}, 1.9, 640, 360, 1, view.far_m);
        CutSettings settings{.max_error_px = 3, .corner_safe = true};
        Cut cut(terrain, ample_cut(terrain));
        CutReport report = cut.rebuild({&view, 1}, settings);
        const gltf::SnapshotInfo info =
            frames.add(pitch < -0.5 ? "corners-down" : "corners", cut, view, settings, report);
        CHECK(info.error_px == 3);
        CHECK(info.corner_safe);
        CHECK(info.converged);
        Cut late(terrain, ample_cut(terrain));
        settings.max_error_px = 30;
        (void)late.rebuild({&view, 1}, settings);
        settings.max_error_px = 3;
        settings.max_work = 30;
        report = late.update({&view, 1}, settings);
        CHECK(frames.add(pitch < -0.5 ? "corners-down-late" : "corners-late", late, view, settings, report).lagging);
    }
}

void add_streamed_frames(Frames& frames) {
    const Pack& pack = frames.baked().pack;
    for (const std::uint32_t every : {1u, 2u, 3u}) { // so many pages are missing
        const PagedTerrain paged(pack, {});
        for (std::uint32_t tile = 0; tile < paged.terrain.tile_count(); ++tile)
            for (std::uint32_t page = 0; page < paged.terrain.pages_per_tile(); ++page)
                if ((tile + page) % (every + 1) != 0 || every == 1) {
                    if (every == 1 && page != 0) continue;
                    (void)load_page(pack, paged.terrain, tile, page);
                }
        const View view = every == 3 ? frames.low_view() : frames.view();
        const CutSettings settings{.max_error_px = 2};
        Cut cut(paged.terrain, ample_cut(paged.terrain));
        const CutReport report = cut.rebuild({&view, 1}, settings);
        if (report.triangles_drawn == 0) continue; // a hole at every vertex
        (void)frames.add("streamed-" + std::to_string(every), cut, view, settings, report);
    }
}

} // namespace

TEST_CASE("every frame's file keeps what it says: converged, behind, capped, morphed, culled, in corners, streamed") {
    int checked = 0;
    for (int round = 0; round < rounds(2, 12); ++round) {
        const bool holes = round % 2 == 1;
        CAPTURE(round);
        Frames frames(holes, round / 2);
        if (!frames.draws_something()) continue;
        ++checked;
        add_live_frames(frames);
        add_morphed_frames(frames);
        add_recursive_frames(frames);
        add_corner_safe_frames(frames);
        add_streamed_frames(frames);
        frames.check();
    }
    CHECK(checked * 3 >= rounds(2, 12) * 2);
}

TEST_CASE("a snapshot outlives what it was taken of, and another pack does not take it") {
    const Folder folder, other_folder;
    gltf::Snapshot snapshot;
    CHECK_THROWS_WITH(gltf::write_snapshot(Pack{}, snapshot, folder / "out.glb"), Catch::Contains("is empty"));
    CHECK(snapshot.empty());
    baker::BakeOptions options;
    options.tile_log2 = 5;
    const BakedTerrain baked(folder, hills(65, 65, 30, 30), options),
        other(other_folder, hills(65, 64, 30, 30), options);
    {
        Cut cut(baked.terrain, ample_cut(baked.terrain));
        const View view = view_of(baked.terrain);
        const CutSettings settings;
        const CutReport report = cut.rebuild({&view, 1}, settings);
        snapshot = gltf::take_snapshot(baked.terrain, cut.cut, view, settings, report);
        const View away = make_view(view.eye_m + Vec3{0, 0, 1e5}, {0, 0, 1}, {0, 1, 0}, 0.5, 640, 360, 1, 1e5);
        const CutReport none = cut.rebuild({&away, 1}, settings);
        CHECK_THROWS_WITH(gltf::take_snapshot(baked.terrain, cut.cut, away, settings, none),
                          Catch::Contains("no triangle"));
    }
    gltf::write_snapshot(baked.pack, snapshot, folder / "out.glb");
    CHECK_THROWS_WITH(gltf::write_snapshot(other.pack, snapshot, folder / "other.glb"), Catch::Contains("not the one"));
}
