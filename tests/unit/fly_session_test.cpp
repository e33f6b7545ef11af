// A session changes its method under way, and tells of what it could not read.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "session/session.h"
#include "shared/terrain_data.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::session;
using namespace fjell::test;

namespace {

// A pack in its file, of 9 tiles at most, and the options to open it.
struct Place {
    explicit Place(unsigned seed, PageOrder order = PageOrder::planar) {
        Random random(seed);
        baker::BakeOptions bake = small_bake(6);
        bake.order = order;
        (void)baker::bake(random_dem(random, 150, 130, Shape::fractal), bake, folder / "t.fjell");
        options.pack = folder / "t.fjell";
        options.streaming = Streaming::off;
        options.profile.refine.max_error_px = 2;
    }
    [[nodiscard]] View view(const Session& session) const {
        return view_of(resample(path_of(options), session.ground(), 5)[2], session.terrain(), options.profile);
    }
    TemporaryFolder folder;
    FlightOptions options;
};

std::uint64_t updated_hash(Session& session, const Place& place, const Profile& profile) {
    (void)update_frame(session, place.view(session), profile, 0);
    return mesh_hash(session.mesh());
}

std::uint64_t opened_hash(const Place& place, const FlightOptions& options) {
    Session session;
    open_session(options, session);
    return updated_hash(session, place, options.profile);
}

void refuses_to_remake(const FlightOptions& options, Session& session, const std::string& part) {
    try {
        remake_method(options, session);
        FAIL("remade, and it should speak of " << part);
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        INFO(failure.what());
        CHECK(std::string(failure.what()).find(part) != std::string::npos);
    }
}

} // namespace

TEST_CASE("a session with another method or budget draws what one opened with it does, over the same terrain") {
    const Place place(301);
    FlightOptions recursive = place.options, small = place.options;
    recursive.profile.method = Method::recursive;
    small.profile.cut_budget = {600, 1200, 64, 1};
    Session session;
    open_session(place.options, session);
    const void* const records = data_of(session.terrain()).records;
    (void)updated_hash(session, place, place.options.profile);
    for (const FlightOptions& options : {recursive, small, place.options, small, recursive, place.options}) {
        remake_method(options, session);
        CHECK_FALSE(session.begun);
        CHECK(session.method->kind == options.profile.method);
        CHECK(data_of(session.terrain()).records == records);
        CHECK(updated_hash(session, place, options.profile) == opened_hash(place, options));
    }
}

TEST_CASE("what a changed key takes is what its table says: nothing, or the method's memory") {
    Place place(306);
    for (const Method method : {Method::incremental, Method::recursive}) {
        place.options.profile.method = method;
        Session session;
        open_session(place.options, session);
        (void)update_frame(session, place.view(session), place.options.profile, 0);
        const Profile before = place.options.profile;
        for (const ProfileKey& key : profile_keys()) {
            if (key.used_by == UsedBy::streaming || key.rebuild == Rebuild::session) continue;
            if (key.kind == KeyKind::choice && key.rebuild == Rebuild::method) continue; // tested above
            INFO(key.name);
            FlightOptions options = place.options;
            const double other = key.kind == KeyKind::whole    ? key.get(before) / 2
                                 : key.kind == KeyKind::number ? key.get(before) * 1.5
                                                               : key.most - key.get(before);
            key.set(options.profile, std::clamp(std::floor(other), key.least, key.most));
            if (key.rebuild == Rebuild::method) remake_method(options, session);
            session.begun = false; // built from nothing, so that it is comparable
            Session fresh;
            open_session(options, fresh);
            const View view = place.view(session);
            const FrameEntry here = update_frame(session, view, options.profile, 0);
            const FrameEntry there = update_frame(fresh, view, options.profile, 0);
            CHECK(here.vertices == there.vertices);
            CHECK(here.triangles == there.triangles);
            CHECK(session.mesh().topology == fresh.mesh().topology);
            CHECK(session.method->bytes() == fresh.method->bytes());
            if (key.rebuild == Rebuild::method) remake_method(place.options, session);
        }
    }
}

TEST_CASE("a session that cannot have what is asked goes on as it was") {
    const Place place(302), linear(303, PageOrder::linear);
    Session session;
    open_session(place.options, session);
    const std::uint64_t before = updated_hash(session, place, place.options.profile);
    FlightOptions options = place.options;
    options.profile.cut_budget.vertices = 15; // one for each corner of 3 x 3 tiles, but for the last
    refuses_to_remake(options, session, "CutBudget::vertices");
    options.profile.method = Method::recursive;
    options.profile.budget.indices = 16;
    refuses_to_remake(options, session, "RecursiveBudget::indices");
    CHECK(session.begun);
    CHECK(session.method->kind == Method::incremental);
    CHECK(mesh_hash(session.mesh()) == before);
    CHECK_FALSE(update_frame(session, place.view(session), place.options.profile, 0).rebuilt);
    CHECK(mesh_hash(session.mesh()) == before);

    Session hz;
    FlightOptions flown = linear.options;
    flown.profile.method = Method::recursive;
    open_session(flown, hz);
    refuses_to_remake(linear.options, hz, "linear order");
    CHECK(hz.method->kind == Method::recursive);
}

TEST_CASE("a session that streams or records is not remade") {
    Place place(304);
    place.options.streaming = Streaming::on;
    Session streamed;
    open_session(place.options, streamed);
    refuses_to_remake(place.options, streamed, "streamed");
    place.options.streaming = Streaming::off;
    place.options.record = place.folder / "flight.json";
    Session recorded;
    open_session(place.options, recorded);
    refuses_to_remake(place.options, recorded, "recorded");
}

TEST_CASE("the first page that is damaged is one line to who listens, and all of them are counted") {
    Place place(305);
    place.options.streaming = Streaming::on;
    place.options.profile.refine.max_error_px = 0.05;
    const auto whole = io::load_pack(place.options.pack, io::LoadTerrain::yes);
    std::string bytes = slurp(place.options.pack);
    for (std::uint32_t tile = 0; tile < whole.terrain.tile_count(); tile += 2) {
        const ChunkEntry e = whole.pack.entry(chunk_index(whole.terrain.header(), {ChunkKind::geometry, tile, 0}));
        bytes[e.offset + e.stored_bytes / 2] ^= 1;
    }
    spit(place.options.pack, bytes);
    for (const bool listens : {true, false}) {
        Session session;
        std::vector<std::string> lines;
        open_session(place.options, session);
        if (listens) session.on_failure = [&](const std::string& line) { lines.push_back(line); };
        (void)update_until_there(session, place.view(session), place.options.profile, 0, [](const FrameEntry&) {});
        CHECK(session.streamed->corrupt() > 1);
        CHECK(session.streamed->unreadable() == 0);
        CHECK(lines.size() == (listens ? 1 : 0));
        for (const std::string& line : lines) CHECK(line.starts_with(place.options.pack + ": page 0 of tile "));
        for (const std::string& line : lines) CHECK(line.find('\n') == std::string::npos);
    }
}
