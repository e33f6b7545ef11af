// A pack as an object: heights, rays and patches from any thread, frames, snapshots and pictures.
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "baker/check/picture.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "baking.h"
#include "fjell/edit.h"
#include "fjell/gl/context.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/io/heights.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/load.h"
#include "fjell/profile.h"
#include "fjell/query.h"
#include "fjell/texture.h"
#include "io/stamps.h"
#include "watched.h"

namespace fjell::python {

namespace py = pybind11;
using io::Failure;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

Vec3 vector_of(const std::array<double, 3>& v) {
    return {v[0], v[1], v[2]};
}

// What has changed the ground, in order. The terrain that is asked for heights is changed at once; those that are
// updated and drawn, which may be made later, when they are updated.
struct Edited {
    EditBudget budget;
    io::AlignedMemory memory;
    Edits edits;                      // of the terrain that is asked; a streamed one's are its LiveTerrain's
    std::deque<io::KeptStamp> stamps; // all that were applied, or may be yet; they stay where they are
    std::deque<StampId> ids;          // theirs
    std::uint64_t cursor = 0;         // of ground_changes()
};

// A terrain that is updated, and how many stamps it has been given.
struct Followed {
    io::LiveTerrain ground;
    std::size_t stamps = 0;

    Followed(const std::string& path, const io::LiveOptions& options) : ground(path, options) {}
    void follow(const Edited* edited) {
        StampId id = 0;
        while (edited != nullptr && stamps < edited->stamps.size() &&
               push_stamp(ground.edits(), edited->stamps[stamps].stamp(), id).ok())
            ++stamps;
    }
};

// What draws, of a terrain of its own: whoever updates the other one without drawing would lose its maps.
struct Painter {
    Followed followed;
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Renderer> renderer;
    std::unique_ptr<gl::Target> target;

    Painter(const std::string& path, const io::LiveOptions& options) : followed(path, options) {}
};

// All of a terrain. Arrays that show its memory keep it alive.
struct Ground {
    std::string path;
    Profile profile;
    std::unique_ptr<io::LoadedPack> whole; // null: streamed
    std::mutex lock;                       // of what follows, which one thread uses at a time
    std::unique_ptr<Edited> edited;        // null: the ground cannot be changed
    std::unique_ptr<Followed> live;        // null: there was no update yet
    std::unique_ptr<Painter> painter;
    double clock_s = 0; // of updates that are given no time
    View view = [] {    // of the last update; before it one that wants next to nothing
        View least;
        least.max_error_px = 1e6;
        return least;
    }();

    [[nodiscard]] const Terrain& terrain() const { return whole ? whole->terrain : live->ground.terrain(); }
    [[nodiscard]] io::LiveOptions options() const {
        io::LiveOptions made = live_options(profile);
        if (edited) made.edits = edited->budget;
        return made;
    }
    void begin_updates() {
        if (!live) live = std::make_unique<Followed>(path, options());
    }
    void allow_edits(std::uint32_t blocks) {
        auto made = std::make_unique<Edited>();
        const PackHeader header = whole ? whole->terrain.header() : io::PackFile(path).pack().header; // not open yet
        made->budget = {.blocks = blocks, .stamps = 4096, .holes = has_room_for_holes(header), .locks = blocks};
        if (!whole) {
            edited = std::move(made);
            begin_updates();
            edited->edits = live->ground.edits();
            return;
        }
        const std::size_t bytes = edits_bytes(whole->terrain.header(), made->budget);
        made->memory = io::allocate(bytes);
        const Status s = create_edits(whole->terrain, made->budget, {made->memory.get(), bytes}, made->edits);
        if (!s.ok()) throw Failure(1, std::string("edit_blocks: ") + s.field + ": " + message(s.code));
        edited = std::move(made);
    }
};

// Updates until all that the view wants is there, or nothing comes any more.
const io::LiveFrame& settle(Followed& followed, const Edited* edited, const View& view, double& clock_s,
                            const std::function<void()>& after_each = {}) {
    constexpr int patience = 40'000; // updates, of 0.5 ms
    for (int i = 0;; ++i) {
        io::check_interrupt();
        followed.follow(edited);
        const io::LiveFrame& frame = followed.ground.update({&view, 1}, clock_s);
        clock_s += 1.0 / 60;
        if (after_each) after_each();
        if (frame.settled || i == patience) return frame;
        std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
}

// Has a stamp applied: at once where all pages are loaded; a streamed terrain is updated, as it was updated last, until
// it has those under the stamp. Returns how many samples have changed.
std::uint32_t apply(Ground& g, StampId id) {
    constexpr int patience = 20'000; // updates, of 0.5 ms
    if (g.whole) {
        EditReport report;
        (void)update_edits(g.edited->edits, {}, {}, report); // nothing limits it
        return report.samples;
    }
    std::uint32_t samples = 0;
    int settled = 0; // updates that had nothing left to do
    for (int i = 0; i < patience && settled < 4 && stamp_state(g.edited->edits, id).state == StampState::waiting; ++i) {
        io::check_interrupt();
        const io::LiveFrame& frame = g.live->ground.update({&g.view, 1}, g.clock_s);
        samples += frame.edits.samples;
        settled = frame.settled ? settled + 1 : 0;
        g.clock_s += 1.0 / 60;
        std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    return samples;
}

// All heights of a pack with the stamps that a terrain was given.
io::FullHeights edited_heights(const Ground& g, int step_log2) {
    std::vector<io::TimedStamp> stamps;
    for (std::size_t i = 0; i < g.edited->stamps.size(); ++i)
        if (stamp_state(g.edited->edits, g.edited->ids[i]).state != StampState::waiting)
            stamps.push_back({0, g.edited->stamps[i]});
    const auto source = baker::edited_source(std::make_unique<baker::PackSource>(g.path), stamps, g.path);
    const auto shrunk = [&](std::int32_t count) { return ((count - 2) >> step_log2) + 2; };
    io::FullHeights all{shrunk(source->columns), shrunk(source->rows), static_cast<std::uint32_t>(step_log2), {}};
    all.heights_m.resize(static_cast<std::size_t>(all.columns) * static_cast<std::size_t>(all.rows));
    // The sample that each of the result's rows, or columns, shows; a last one beyond the rim shows the rim's.
    const auto shown = [&](std::int32_t at, std::int32_t count) { return std::min(at << step_log2, count - 1); };
    const auto reader = source->reader();
    baker::ReadStatistics statistics;
    std::vector<float> part;
    for (const baker::Window& w : source->windows(std::size_t{1} << 20)) {
        io::check_interrupt();
        part.resize(w.area());
        reader->read(w, part.data(), statistics);
        for (std::int32_t y = w.y >> step_log2; y < all.rows; ++y) {
            const std::int32_t row = shown(y, source->rows) - w.y;
            if (row < 0 || row >= w.rows) continue;
            for (std::int32_t x = w.x >> step_log2; x < all.columns; ++x) {
                const std::int32_t column = shown(x, source->columns) - w.x;
                if (column < 0 || column >= w.columns) continue;
                all.heights_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(all.columns) +
                              static_cast<std::size_t>(x)] =
                    part[static_cast<std::size_t>(row) * static_cast<std::size_t>(w.columns) +
                         static_cast<std::size_t>(column)];
            }
        }
    }
    return all;
}

// A frame's mesh as it lies in the terrain's memory, and its report.
struct Frame {
    std::shared_ptr<Ground> ground;
    MeshView mesh;
    CutReport cut;
    StreamReport stream;
    bool converged = false, settled = false;
    std::vector<std::string> short_of;
};

template <typename T>
py::array seen(const std::shared_ptr<Ground>& ground, std::span<const T> values, const py::dtype& type) {
    auto owned = std::make_unique<std::shared_ptr<Ground>>(ground);
    const py::capsule owner(owned.get(), [](void* held) { delete static_cast<std::shared_ptr<Ground>*>(held); });
    (void)owned.release();
    py::array array(type, {static_cast<py::ssize_t>(values.size())}, {static_cast<py::ssize_t>(sizeof(T))},
                    values.data(), owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

struct MapCodes {
    std::int64_t columns = 0, rows = 0;
    std::uint32_t channels = 0;
    double samples_per_texel = 1;
    std::vector<std::uint8_t> codes;
};

MapCodes read_map(const std::string& path, bool normal) {
    const io::PackFile file(path);
    const Pack& pack = file.pack();
    const PackHeader& h = pack.header;
    const std::uint32_t log2 = normal ? h.normal_log2 : h.horizon_log2;
    if (log2 == 0)
        throw Failure(1, path + (normal ? ": has no normal map; bake it again"
                                        : ": has no horizon maps; bake it with horizons=\"half\""));
    const std::uint32_t side = 1u << log2, cells = 1u << h.tile_log2;
    MapCodes map;
    map.channels = normal ? 2 : horizon_planes;
    map.samples_per_texel = static_cast<double>(cells) / (side - 1);
    const auto texels = [&](std::uint32_t samples) {
        return static_cast<std::int64_t>(std::ceil((samples - 1) / map.samples_per_texel - 1e-9)) + 1;
    };
    map.columns = texels(h.columns), map.rows = texels(h.rows);
    map.codes.resize(static_cast<std::size_t>(map.columns * map.rows) * map.channels);
    std::vector<std::byte> blocks;
    std::vector<std::uint8_t> tile_codes(std::size_t{side} * side * map.channels);
    for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) {
        io::check_interrupt();
        file.read_chunk({normal ? ChunkKind::normal : ChunkKind::horizon, tile, 0}, blocks);
        const Status s = normal ? decode_normal(blocks, side, tile_codes) : decode_horizon(blocks, side, tile_codes);
        if (!s.ok()) throw Failure(1, path + ": " + message(s.code));
        const std::uint32_t place = pack.tile_place(tile);
        const std::int64_t x0 = std::int64_t{place % h.tiles_x} * (side - 1),
                           y0 = std::int64_t{place / h.tiles_x} * (side - 1);
        const std::int64_t across = std::min<std::int64_t>(side, map.columns - x0);
        for (std::int64_t y = 0; y < std::min<std::int64_t>(side, map.rows - y0); ++y)
            std::copy_n(tile_codes.data() + static_cast<std::size_t>(y) * side * map.channels,
                        static_cast<std::size_t>(across) * map.channels,
                        map.codes.data() + static_cast<std::size_t>((y0 + y) * map.columns + x0) * map.channels);
    }
    return map;
}

class PyTerrain {
public:
    PyTerrain(const std::string& path, const std::string& profile_path,
              const std::vector<std::pair<std::string, std::string>>& overrides, bool streaming,
              std::uint32_t edit_blocks)
        : ground_(std::make_shared<Ground>()) {
        Ground& g = *ground_;
        run_watched([&](const baker::Progress&) {
            g.path = path;
            if (!profile_path.empty()) g.profile = read_profile(profile_path);
            for (const auto& [key, value] : overrides) set_profile_key(g.profile, key, value);
            if (!streaming)
                g.whole = std::make_unique<io::LoadedPack>(io::load_pack(io::PackFile(path), io::LoadTerrain::yes));
            if (edit_blocks != 0) g.allow_edits(edit_blocks);
            if (streaming) g.begin_updates();
        });
    }

    void close() { ground_.reset(); }
    [[nodiscard]] bool closed() const { return ground_ == nullptr; }
    // What a call works on until it returns, closed meanwhile or not.
    [[nodiscard]] std::shared_ptr<Ground> ground() const {
        if (!ground_) throw py::value_error("the terrain is closed");
        return ground_;
    }

    [[nodiscard]] py::tuple height(double x_m, double z_m) const {
        const auto g = ground();
        const GroundHeight h = ground_height(g->terrain(), x_m, z_m);
        return py::make_tuple(h.inside && !h.hole ? h.height_m : not_a_number, h.error_m);
    }

    // Heights, errors and normals of places in pairs.
    [[nodiscard]] py::tuple heights(const Numbers& xs, const Numbers& zs) const {
        const auto g = ground();
        const py::ssize_t count = xs.size();
        py::array_t<double> heights_m(count), errors_m(count);
        py::array_t<double> normals({count, py::ssize_t{3}});
        const double *const x = xs.data(), *const z = zs.data();
        double *const h = heights_m.mutable_data(), *const e = errors_m.mutable_data(), *n = normals.mutable_data();
        {
            const py::gil_scoped_release without_gil;
            for (py::ssize_t i = 0; i < count; ++i, n += 3) {
                const GroundHeight at = ground_height(g->terrain(), x[i], z[i]);
                const bool ground = at.inside && !at.hole;
                h[i] = ground ? at.height_m : not_a_number;
                e[i] = ground ? static_cast<double>(at.error_m) : not_a_number;
                n[0] = ground ? at.normal.x : not_a_number;
                n[1] = ground ? at.normal.y : not_a_number;
                n[2] = ground ? at.normal.z : not_a_number;
            }
        }
        return py::make_tuple(heights_m, errors_m, normals);
    }

    // Distance (NaN: no hit), position, normal and error of each ray.
    [[nodiscard]] py::tuple rays(const Numbers& origins, const Numbers& directions, double most_m) const {
        const auto g = ground();
        const py::ssize_t count = origins.size() / 3;
        py::array_t<double> distances_m(count), errors_m(count);
        py::array_t<double> positions({count, py::ssize_t{3}}), normals({count, py::ssize_t{3}});
        const double *o = origins.data(), *d = directions.data();
        double *const far = distances_m.mutable_data(), *const e = errors_m.mutable_data();
        double *p = positions.mutable_data(), *n = normals.mutable_data();
        {
            const py::gil_scoped_release without_gil;
            for (py::ssize_t i = 0; i < count; ++i, o += 3, d += 3, p += 3, n += 3) {
                const GroundHit hit = cast_ray(g->terrain(), {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, most_m);
                far[i] = hit.hit ? hit.distance_m : not_a_number;
                e[i] = hit.hit ? static_cast<double>(hit.error_m) : not_a_number;
                const Vec3 at = hit.hit ? hit.position_m : Vec3{not_a_number, not_a_number, not_a_number};
                const Vec3 up = hit.hit ? hit.normal : Vec3{not_a_number, not_a_number, not_a_number};
                p[0] = at.x, p[1] = at.y, p[2] = at.z;
                n[0] = up.x, n[1] = up.y, n[2] = up.z;
            }
        }
        return py::make_tuple(distances_m, positions, normals, errors_m);
    }

    [[nodiscard]] py::tuple patch(std::int32_t column, std::int32_t row, std::uint32_t side, int step_log2) const {
        const auto g = ground();
        if (side < 2 || side > max_patch_side)
            throw py::value_error("side: is " + std::to_string(side) + "; give 2 to " + std::to_string(max_patch_side));
        const auto across = static_cast<py::ssize_t>(side);
        py::array_t<float> heights_m({across, across});
        py::array_t<bool> holes({across, across});
        const std::span h(heights_m.mutable_data(), std::size_t{side} * side);
        const std::span v(holes.mutable_data(), h.size());
        GroundPatch made;
        {
            const py::gil_scoped_release without_gil;
            made = ground_patch(g->terrain(), {column, row}, step_log2, side, h, v);
            for (std::size_t i = 0; i < h.size(); ++i)
                if (v[i]) h[i] = std::numeric_limits<float>::quiet_NaN();
        }
        if (std::isinf(made.error_m)) throw py::value_error("patch: no such samples; see Terrain.columns and rows");
        return py::make_tuple(heights_m, made.error_m);
    }

    [[nodiscard]] py::array samples(int step_log2) const {
        const auto g = ground();
        io::FullHeights all = watched([&] {
            const io::PackFile file(g->path);
            const PackHeader& h = file.pack().header;
            if (const std::lock_guard hold(g->lock); g->edited && !g->whole) return edited_heights(*g, step_log2);
            const auto shrunk = [&](std::uint32_t count) { return ((std::uint64_t{count} - 2) >> step_log2) + 2; };
            const auto go_on = [](double) { return io::check_interrupt(), true; };
            return *io::read_heights(file, shrunk(h.columns) * shrunk(h.rows), go_on);
        });
        const auto columns = static_cast<py::ssize_t>(all.columns), rows = static_cast<py::ssize_t>(all.rows);
        return array_of<float>(std::move(all.heights_m), {rows, columns});
    }

    // The finest mip of a map of all tiles as one array of bytes, rows x columns x channels, and the samples from texel
    // to texel. Tiles share the texels on their borders.
    [[nodiscard]] py::tuple map_codes(const std::string& kind) const {
        const auto g = ground();
        const bool normal = kind == "normal";
        if (!normal && kind != "horizon") throw py::value_error("kind: is '" + kind + "'; give 'normal' or 'horizon'");
        MapCodes map = watched([&] { return read_map(g->path, normal); });
        const std::vector<py::ssize_t> shape{map.rows, map.columns, map.channels};
        return py::make_tuple(array_of<std::uint8_t>(std::move(map.codes), shape), map.samples_per_texel);
    }

    [[nodiscard]] bool editable() const { return ground()->edited != nullptr; }

    // Of the fields of a stamp in JSON (io/stamps.h). Returns the number of samples whose height has changed.
    std::uint32_t edit(const std::string& stamp) {
        const auto g = ground();
        if (!g->edited) throw py::value_error("edit: open the terrain with edit_blocks");
        return watched([&] {
            io::KeptStamp kept = io::stamp_of(nlohmann::json::parse(stamp));
            const std::lock_guard hold(g->lock);
            Edited& e = *g->edited;
            e.stamps.push_back(std::move(kept));
            std::uint32_t samples = 0;
            StampId id = 0;
            StampResult result{StampState::refused, push_stamp(e.edits, e.stamps.back().stamp(), id)};
            if (result.status.ok()) {
                samples = apply(*g, id);
                result = stamp_state(e.edits, id);
            }
            // One that waits points to what is kept here, and may be applied yet.
            const bool waits = result.state == StampState::waiting, applied = result.state == StampState::applied;
            if (waits || applied)
                e.ids.push_back(id);
            else
                e.stamps.pop_back();
            if (!g->whole) g->live->stamps = e.stamps.size();
            if (waits)
                throw Failure(
                    1, "edit: too little of the ground around is loaded to tell whether the stamp fits; update the "
                       "terrain with a view from near it first, or make the stamp less steep");
            if (!applied)
                throw Failure(1, std::string("edit: ") + result.status.field + ": " + message(result.status.code));
            return samples;
        });
    }

    // Rectangles of samples (column, row, columns, rows) that have changed since the last call.
    [[nodiscard]] py::list ground_changes() {
        const auto g = ground();
        py::list changed;
        if (!g->edited) return changed;
        const std::vector<GroundRect> rects = watched([&] {
            const std::lock_guard hold(g->lock);
            std::vector<GroundRect> found;
            GroundRect some[64];
            bool lost = false;
            do {
                const std::uint32_t count = take_ground_changes(g->edited->edits, g->edited->cursor, some, lost);
                found.insert(found.end(), some, some + count);
                if (count < std::size(some)) return found;
            } while (true);
        });
        for (const GroundRect& r : rects)
            changed.append(py::make_tuple(r.first.column, r.first.row, r.last.column - r.first.column + 1,
                                          r.last.row - r.first.row + 1));
        return changed;
    }

    [[nodiscard]] Frame update(const View& view, const py::object& now_s, bool wait) {
        const auto g = ground();
        const double given_s = now_s.is_none() ? not_a_number : now_s.cast<double>();
        Frame made{g, {}, {}, {}, false, false, {}};
        run_watched([&](const baker::Progress&) {
            const std::lock_guard hold(g->lock);
            g->begin_updates();
            if (!std::isnan(given_s)) g->clock_s = given_s;
            Followed& live = *g->live;
            g->view = view;
            if (!wait) live.follow(g->edited.get());
            const io::LiveFrame& frame =
                wait ? settle(live, g->edited.get(), view, g->clock_s) : live.ground.update({&view, 1}, g->clock_s);
            if (std::isnan(given_s) && !wait) g->clock_s += 1.0 / 60;
            made.mesh = frame.mesh.mesh;
            made.cut = frame.cut, made.stream = frame.stream;
            made.converged = frame.converged, made.settled = frame.settled;
            made.short_of.assign(frame.short_of.begin(), frame.short_of.end());
        });
        return made;
    }

    [[nodiscard]] py::dict snapshot(const std::string& path, const View& view, double texel_m, bool quantised,
                                    bool meshopt, const std::string& texture) {
        if (texture != "png" && texture != "jpeg")
            throw py::value_error(texture + ": texture must be \"png\" or \"jpeg\"");
        const auto g = ground();
        const gltf::SnapshotCounts counts = watched([&] {
            const std::lock_guard hold(g->lock);
            g->begin_updates();
            g->view = view;
            (void)settle(*g->live, g->edited.get(), view, g->clock_s);
            const io::LiveTerrain& live = g->live->ground;
            return gltf::write_snapshot(
                live, gltf::take_snapshot(live, view), path,
                {.texel_m = texel_m,
                 .colours = texture == "jpeg" ? gltf::SnapshotImage::jpeg : gltf::SnapshotImage::png,
                 .quantised = quantised,
                 .meshopt = meshopt});
        });
        py::dict said;
        said["tiles"] = counts.tiles, said["vertices"] = counts.vertices, said["triangles"] = counts.triangles;
        said["converged"] = counts.converged, said["error_bound_px"] = counts.error_bound_px;
        said["file_bytes"] = counts.file_bytes;
        return said;
    }

    // On the calling thread: OpenGL's contexts are a thread's.
    [[nodiscard]] py::array render(const View& view, const std::string& mode, bool haze) {
        const auto g = ground();
        gl::Image image;
        {
            const py::gil_scoped_release without_gil;
            const std::lock_guard hold(g->lock);
            draw(*g, view, mode, haze, image);
        }
        return array_of<std::uint8_t>(std::move(image.rgb), {image.height, image.width, 3});
    }

    // From above, without OpenGL. Of a terrain that is loaded whole.
    [[nodiscard]] py::object map(std::uint32_t longest_px) const {
        const auto g = ground();
        if (!g->whole) return py::none();
        baker::Picture picture = watched([&] {
            const std::lock_guard hold(g->lock); // from edits
            return baker::make_picture(g->whole->terrain, {longest_px, 0});
        });
        return array_of<std::uint8_t>(std::move(picture.rgb), {picture.height, picture.width, 3});
    }

private:
    static void draw(Ground& g, const View& view, const std::string& mode, bool haze, gl::Image& image) {
        constexpr std::pair<const char*, gl::Mode> modes[] = {
            {"shaded", gl::Mode::shaded}, {"levels", gl::Mode::levels}, {"distance", gl::Mode::distance},
            {"tiles", gl::Mode::tiles},   {"mips", gl::Mode::mips},     {"wire", gl::Mode::shaded}};
        const auto* const found =
            std::find_if(std::begin(modes), std::end(modes), [&](const auto& entry) { return entry.first == mode; });
        if (found == std::end(modes))
            throw Failure(2, "mode: is " + mode + "; give shaded, wire, levels, distance, tiles or mips");
        if (!g.painter) {
            auto painter = std::make_unique<Painter>(g.path, g.options());
            painter->context = gl::Headless::create();
            painter->renderer = gl::Renderer::create(painter->followed.ground);
            g.painter = std::move(painter);
        }
        Painter& p = *g.painter;
        if (!p.context->make_current()) throw Failure(3, "render: another thread has the picture's OpenGL context");
        if (!p.target || p.target->width() != view.width_px || p.target->height() != view.height_px)
            p.target = gl::Target::create(
                {view.width_px, view.height_px, std::min(g.profile.samples, gl::max_target_samples())});
        double clock_s = 0;
        (void)settle(p.followed, g.edited.get(), view, clock_s, [&] { p.renderer->upload(p.followed.ground); });
        gl::DrawOptions options;
        options.mode = found->second;
        options.wireframe = mode == "wire";
        options.light = g.profile.light;
        options.haze = haze;
        p.renderer->draw(p.followed.ground, view, options, *p.target);
        p.target->read_colour(image);
    }

    std::shared_ptr<Ground> ground_; // null: closed
};

View view_of(const std::array<double, 3>& eye, const std::array<double, 3>& forward, const std::array<double, 3>& up,
             double fov_deg, const std::array<std::uint32_t, 2>& size, double near_m, double far_m,
             double max_error_px) {
    View view = make_view(vector_of(eye), vector_of(forward), vector_of(up), fov_deg * std::numbers::pi / 180, size[0],
                          size[1], near_m, far_m);
    view.max_error_px = max_error_px;
    if (const Status s = validate(view); !s.ok())
        throw py::value_error(std::string("view: ") + s.field + ": " + message(s.code));
    return view;
}

void add_frame(py::module_& module) {
    PYBIND11_NUMPY_DTYPE(MeshVertex, column, row, height_m);
    PYBIND11_NUMPY_DTYPE(TileRange, tile, first_index, index_count, triangles);
    py::class_<Frame>(module, "Frame")
        .def_property_readonly(
            "vertices", [](const Frame& f) { return seen(f.ground, f.mesh.vertices, py::dtype::of<MeshVertex>()); })
        .def_property_readonly(
            "indices", [](const Frame& f) { return seen(f.ground, f.mesh.indices, py::dtype::of<std::uint32_t>()); })
        .def_property_readonly("ranges",
                               [](const Frame& f) { return seen(f.ground, f.mesh.tiles, py::dtype::of<TileRange>()); })
        .def_readonly("converged", &Frame::converged)
        .def_readonly("settled", &Frame::settled)
        .def_readonly("short_of", &Frame::short_of)
        .def_property_readonly("error_bound_px", [](const Frame& f) { return f.cut.error_bound_px; })
        .def_property_readonly("threshold_px", [](const Frame& f) { return f.cut.threshold_px; })
        .def_property_readonly("active_vertices", [](const Frame& f) { return f.cut.vertices; })
        .def_property_readonly("triangles", [](const Frame& f) { return f.cut.triangles; })
        .def_property_readonly("triangles_drawn", [](const Frame& f) { return f.cut.triangles_drawn; })
        .def_property_readonly("pages_missing", [](const Frame& f) { return f.stream.pages_left; });
}

template <typename Value>
auto of_header(Value value) {
    return [value](const PyTerrain& t) { return value(t.ground()->terrain().header()); };
}

} // namespace

void add_terrain(py::module_& module) {
    add_frame(module);
    py::class_<View>(module, "View").def(py::init(&view_of));
    py::class_<PyTerrain>(module, "Terrain")
        .def(py::init<const std::string&, const std::string&, const std::vector<std::pair<std::string, std::string>>&,
                      bool, std::uint32_t>())
        .def("close", &PyTerrain::close)
        .def_property_readonly("closed", &PyTerrain::closed)
        .def_property_readonly("columns", of_header([](const PackHeader& h) { return h.columns; }))
        .def_property_readonly("rows", of_header([](const PackHeader& h) { return h.rows; }))
        .def_property_readonly(
            "spacing_m", of_header([](const PackHeader& h) { return py::make_tuple(h.spacing_m[0], h.spacing_m[1]); }))
        .def_property_readonly("height_range_m",
                               of_header([](const PackHeader& h) { return py::make_tuple(h.min_m, h.max_m); }))
        .def_property_readonly("quantum_m", of_header([](const PackHeader& h) { return h.quantum_m; }))
        .def_property_readonly("has_holes", of_header([](const PackHeader& h) { return h.voids != 0; }))
        .def("height", &PyTerrain::height)
        .def("heights", &PyTerrain::heights)
        .def("rays", &PyTerrain::rays)
        .def("patch", &PyTerrain::patch)
        .def("samples", &PyTerrain::samples)
        .def("map_codes", &PyTerrain::map_codes)
        .def_property_readonly("editable", &PyTerrain::editable)
        .def("edit", &PyTerrain::edit)
        .def("ground_changes", &PyTerrain::ground_changes)
        .def("update", &PyTerrain::update)
        .def("snapshot", &PyTerrain::snapshot)
        .def("render", &PyTerrain::render)
        .def("map", &PyTerrain::map);
}

} // namespace fjell::python
