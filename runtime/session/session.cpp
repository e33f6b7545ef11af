#include "session/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "io/file.h"
#include "io/stamp_blocks.h"

namespace fjell::session {

namespace {

using io::Failure;
using Clock = std::chrono::steady_clock;

double microseconds(Clock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
}

// The one place where it is asked which method it is. Throws before it touches the session. recorded: the budget of
// what is replayed, instead of the profile's.
void make_method(const FlightOptions& options, const CutBudget* recorded, Session& session) {
    session.method = options.profile.method == Method::recursive
                         ? make_recursive(options, session.terrain())
                         : make_incremental(options, session.terrain(), recorded);
}

bool shall_stream(const FlightOptions& options, const PackHeader& h) {
    if (!options.replay.empty() || options.streaming == Streaming::off) return false;
    if (options.streaming == Streaming::on) return true;
    return h.order != PageOrder::linear && std::uint64_t{tiles_of(h)} * pages_per_tile(h) > options.profile.page_slots;
}

// A terrain without pages, of slots for so many.
void make_paged(Session& session, std::span<const std::byte> corners, std::uint32_t page_slots) {
    const Pack& pack = session.loaded.pack;
    const TerrainBudget budget{page_slots};
    session.terrain_bytes = terrain_bytes(pack.header, budget);
    session.loaded.memory = io::allocate(session.terrain_bytes);
    const std::span memory{session.loaded.memory.get(), session.terrain_bytes};
    const Status s = corners.empty() ? create_terrain(pack, budget, memory, session.loaded.terrain)
                                     : create_terrain(pack, corners, budget, memory, session.loaded.terrain);
    if (!s.ok()) throw Failure(1, fmt::format("{}: {}: {}", session.loaded.path, s.field, message(s.code)));
}

// The terrain, as it is wanted: streamed, replayed page by page, or whole.
void open_terrain(const FlightOptions& options, Session& session) {
    // Opened once: whatever the name comes to lead to, everything here is of one file.
    session.file = options.file ? options.file : std::make_shared<const io::PackFile>(options.pack);
    const io::PackFile& file = *session.file;
    const std::uint32_t replayed_slots = options.replay.empty() ? 0 : session.recording->page_slots;
    if (shall_stream(options, file.pack().header)) {
        session.loaded.path = file.path();
        session.loaded.pack = file.pack();
        session.loaded.crs = file.crs();
        make_paged(session, file.corners(), options.profile.page_slots);
        session.file_ground = std::make_unique<FileGround>(file);
        if (options.cold) file.drop_cache();
        session.streamed = std::make_unique<io::PackStream>(file);
    } else if (replayed_slots != 0) {
        session.loaded = io::load_pack(file, io::LoadTerrain::no);
        make_paged(session, {}, replayed_slots);
    } else {
        session.loaded = io::load_pack(file, io::LoadTerrain::yes);
        session.terrain_bytes = terrain_bytes(session.loaded.pack.header);
    }
    if (options.verify_every != 0 && (session.streamed || replayed_slots != 0))
        session.reference = std::make_unique<io::LoadedPack>(io::load_pack(file, io::LoadTerrain::yes));
    if (session.terrain().header().tiles_held != 0)
        session.start = start_area(session.terrain(), [&](double x_m, double z_m) {
            if (session.file_ground) return session.file_ground->has_ground(x_m, z_m);
            return !ground_height(session.terrain(), x_m, z_m).hole;
        });
}

// Before the method, whose mesh follows them from its first update on.
void make_edits(const FlightOptions& options, Session& session) {
    std::vector<io::TimedStamp> stamps = options.stamps;
    EditBudget budget = options.edit_budget;
    if (!options.replay.empty()) {
        stamps.clear();
        if (session.recording->edits) budget = *session.recording->edits;
        for (std::size_t frame = 0; frame < session.recording->frames.size(); ++frame)
            for (const io::KeptStamp& stamp : session.recording->frames[frame].stamps) stamps.push_back({frame, stamp});
    }
    const bool sparse = session.terrain().header().tiles_held != 0; // takes none
    if (stamps.empty() && (!options.editable || sparse)) return;
    if (options.edit_room && options.replay.empty()) {
        io::StampBlocks blocks(session.terrain().header());
        for (const io::TimedStamp& stamp : stamps) blocks.add(stamp.what);
        // Where the ground may change later, what the budget says is for that.
        const bool more = options.editable;
        budget.blocks = more ? budget.blocks + blocks.heights() : std::max(budget.blocks, blocks.heights());
        budget.paint = more ? budget.paint + blocks.paint() : std::max(budget.paint, blocks.paint());
        budget.locks = more ? budget.locks + blocks.locks() : std::max(budget.locks, blocks.locks());
    }
    if (options.editable) budget.holes = has_room_for_holes(session.terrain().header());
    session.edits = std::make_unique<FlightEdits>(session.terrain(), budget, std::move(stamps));
    if (session.reference) session.edits->mirror(session.reference->terrain);
}

void begin_stream(const FlightOptions& options, Session& session) {
    StreamBudget budget = options.profile.stream_budget;
    budget.horizons = options.profile.light.shadows;
    budget.splat = options.layers && options.profile.layers.splat;
    try {
        session.streamed->begin(session.terrain(), session.method->cut(), budget,
                                {options.read_mb_s * 1e6, options.read_latency_ms * 1e-3, budget.decoders});
    } catch (const Failure& failure) {
        throw Failure(failure.exit_code,
                      fmt::format("{} ([stream] of a --profile, where map_bytes is map_mb){}", failure.what(),
                                  fewer_tiles(session.loaded.pack.header, options.profile)));
    }
}

} // namespace

void open_session(const FlightOptions& options, Session& session) {
    const auto start = Clock::now();
    if (!options.replay.empty()) session.recording = parse_recording(io::read_text(options.replay), options.replay);
    open_terrain(options, session);
    // Streamed, there is nothing yet to build from.
    session.begun = options.limited || session.streamed;
    const std::uint64_t pack_hash = session.loaded.pack.header.directory_hash;
    if (!options.replay.empty() && session.recording->pack_hash != pack_hash)
        throw Failure(1, fmt::format("{}: recorded over another pack than {}", options.replay, options.pack));
    make_edits(options, session);
    make_method(options, options.replay.empty() ? nullptr : &session.recording->budget, session);
    if (!options.record.empty())
        session.recording = Recording{pack_hash,
                                      session.method->cut_budget(),
                                      session.streamed ? session.loaded.terrain.page_slots() : 0,
                                      {},
                                      session.edits ? std::optional(session.edits->budget()) : std::nullopt};
    session.load_seconds = microseconds(Clock::now() - start) / 1e6;
    session.started = Clock::now();
    if (session.streamed) begin_stream(options, session);
}

void remake_method(const FlightOptions& options, Session& session) {
    if (session.streamed || session.recording)
        throw Failure(1, fmt::format("{}: it is {}, with the method and the budgets it was opened with; open it anew",
                                     session.loaded.path, session.streamed ? "streamed" : "recorded or replayed"));
    make_method(options, nullptr, session);
    session.begun = false;
}

CameraPath path_of(const FlightOptions& options) {
    if (options.still) {
        const Vec3 way = options.still->look_m - options.still->eye_m, eye = options.still->eye_m;
        if (!(length(way) > 0)) throw Failure(2, "--eye and --look are one point; give --look another one");
        // Straight up or down north is up, as on a map.
        const bool upright = length(cross(normalised(way), {0, 1, 0})) > 1e-3;
        return still_path({eye.x, eye.y, eye.z, way.x, way.y, way.z, 0, upright ? 1.0 : 0.0, upright ? 0.0 : -1.0},
                          "still camera");
    }
    if (options.seeded) return random_path(options.seed);
    if (!options.path.empty()) return read_path(options.path);
    return {"orbit", Units::terrain, Orbit{.over_start = true}};
}

View view_of(const Pose& pose, const Terrain& terrain, const Profile& profile) {
    const PackHeader& h = terrain.header();
    const double width_m = (h.columns - 1) * h.spacing_m[0], depth_m = (h.rows - 1) * h.spacing_m[1];
    const Vec3 eye = pose.position_m;
    const Vec3 farthest{std::max(std::abs(eye.x), std::abs(eye.x - width_m)),
                        std::max(std::abs(eye.y - h.min_m), std::abs(eye.y - h.max_m)),
                        std::max(std::abs(eye.z), std::abs(eye.z - depth_m))};
    const double near_m = std::min(0.05 * std::min(h.spacing_m[0], h.spacing_m[1]), 0.5);
    const double far_m = std::max(1.01 * length(farthest), 2 * near_m);
    return make_view(eye, pose.direction, pose.up, profile.fov_deg * std::numbers::pi / 180, profile.width_px,
                     profile.height_px, near_m, far_m);
}

void begin_frame(Session& session, std::size_t frame) {
    if (session.edits) session.edits->begin_frame(frame);
}

FrameEntry update_frame(Session& session, const View& view, const Profile& profile, double now_s) {
    const std::span views(&view, 1);
    std::span<const io::TimedStamp> pushed;
    if (session.edits) pushed = session.edits->update(views, now_s);
    if (session.streamed) {
        const bool failed = session.streamed->report().failed != 0;
        const StreamReport& r =
            session.streamed->update(views, cut_settings(profile, now_s), stream_settings(profile, now_s));
        if (!failed && r.failed != 0 && session.on_failure) session.on_failure(session.streamed->first_failure());
    }
    FrameEntry entry = session.method->update(views, profile, now_s, !session.begun);
    session.begun = true;
    if (session.recording) {
        RecordedFrame frame = session.method->recorded();
        frame.missing_px = session.terrain().missing_px();
        for (const io::TimedStamp& stamp : pushed) frame.stamps.push_back(stamp.what);
        if (session.streamed) {
            const auto pages = stream_page_arrivals(session.streamed->stream());
            frame.pages.assign(pages.begin(), pages.end());
        }
        session.recording->frames.push_back(std::move(frame));
    }
    if (session.streamed) add_stream(entry, session.streamed->report());
    entry.at_s = microseconds(Clock::now() - session.started) / 1e6;
    return entry;
}

namespace {

bool nothing_under_way(const StreamReport& r) {
    return r.in_flight == 0 && r.pages_left == 0 && r.mips_left == 0 && r.pages_inserted == 0 && r.mips_uploaded == 0 &&
           r.pages_evicting == 0 && (r.exhausted & stream_tests) == 0;
}

} // namespace

FrameEntry update_until_there(Session& session, const View& view, const Profile& profile, double now_s,
                              const std::function<void(const FrameEntry&)>& each) {
    constexpr std::chrono::seconds patience{10}, most{300};
    constexpr std::chrono::microseconds pause{300};
    FrameEntry frame = update_frame(session, view, profile, now_s);
    each(frame);
    if (!session.streamed) return frame;
    const auto start = Clock::now();
    auto progress = start;
    for (int quiet = 0; quiet < 2;) { // twice: what an update has requested it may find out in the next one
        io::check_interrupt();
        const FrameEntry poll = update_frame(session, view, profile, now_s);
        each(poll);
        add_poll(frame, poll);
        const StreamReport& r = poll.stream;
        const bool moved =
            r.pages_inserted != 0 || r.mips_uploaded != 0 || poll.activations != 0 || poll.deactivations != 0;
        const bool there = (r.converged && r.maps_converged) || nothing_under_way(r);
        // What waits for a vertex that morphs by time would wait for ever: time stands still.
        const bool idle = poll.waiting == poll.blocked || poll.morphing != 0;
        quiet = there && idle && !moved ? quiet + 1 : 0;
        const auto now = Clock::now();
        if (moved) progress = now;
        if (now - progress > patience || now - start > most) break; // the frame says what it lacks
        if (!moved) std::this_thread::sleep_for(pause);
    }
    return frame;
}

void adopt_recorded(const Session& session, Profile& profile) {
    const RecordedFrame& first = session.recording->frames.front();
    const View& view = first.views.front();
    profile.method = Method::incremental;
    profile.cut = first.settings;
    profile.cut.visits = unlimited_work; // that frame's
    profile.refine.max_error_px = first.settings.max_error_px;
    profile.refine.corner_safe = first.settings.corner_safe;
    profile.width_px = view.width_px;
    profile.height_px = view.height_px;
    profile.fov_deg = (std::atan(view.top) - std::atan(view.bottom)) * 180 / std::numbers::pi;
}

FrameEntry replay_frame(Session& session, std::size_t frame) {
    const RecordedFrame& f = session.recording->frames[frame];
    begin_frame(session, frame);
    if (session.edits) (void)session.edits->update(f.views, f.settings.now_s);
    if (session.recording->page_slots != 0)
        if (const Status s = replay_pages(session.loaded.pack, session.loaded.terrain, session.method->cut(), f);
            !s.ok())
            throw Failure(1, fmt::format("frame {}: a page cannot come or go as recorded ({}); the recording is of "
                                         "another pack, or damaged",
                                         frame, s.field));
    FrameEntry entry = session.method->replay(f);
    entry.missing_px = f.missing_px;
    if (mesh_hash(session.mesh()) != f.mesh_hash)
        throw Failure(
            1, fmt::format("frame {}: the mesh is not the recorded one; was it recorded by another version?", frame));
    return entry;
}

void verify_frame(const Session& session, const View& view, const Profile& profile, std::size_t frame,
                  FrameEntry& entry, Verification& verification) {
    const Frustum frustum = make_frustum(view);
    const bool inside = session.method->within_frustum(profile);
    const CutMesh live = session.method->mesh();
    MeshView mesh = live.mesh;
    std::vector<MeshVertex> morphed; // as the vertex shader will place them
    if (live.frame.morph != Morph::none) {
        morphed.assign(mesh.vertices.begin(), mesh.vertices.end());
        for (std::size_t i = 0; i < morphed.size(); ++i)
            morphed[i].height_m = morphed_height_m(session.terrain(), mesh.vertices[i], live.morph[i], live.frame);
        mesh.vertices = morphed;
    }
    const MeasuredError e = measure_error(session.whole_terrain(), mesh, view, inside ? &frustum : nullptr);
    entry.verified_px = e.max_px;
    const double limit_px = entry.error_bound_px;
    verification.exceeded = verification.exceeded || e.max_px > limit_px;
    if (!entry.settled) return; // where the mesh lags the limit is far from tight
    if (verification.limit_px > 0 && e.max_px / limit_px <= verification.max_px / verification.limit_px) return;
    verification.frame = frame;
    verification.max_px = e.max_px;
    verification.limit_px = limit_px;
}

} // namespace fjell::session
