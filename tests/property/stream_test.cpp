// Pages that are streamed by a client that may be late, wrong, or silent.
#include <catch2/catch.hpp>

#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::uint32_t random_slots(Random& random, const Terrain& full) {
    const auto least = static_cast<int>(full.tile_count()), all = static_cast<int>(full.page_count());
    switch (pick(random, 0, 5)) {
    case 0: return static_cast<std::uint32_t>(least);
    case 1: return static_cast<std::uint32_t>(all);
    default: return static_cast<std::uint32_t>(pick(random, std::min(least + 2, all), least + (all - least) / 2));
    }
}

// What the stream says of missing pages is true of the cut at rest: whatever is wanted at a threshold above theirs is
// active, and when it says that nothing is missing, exactly what is wanted.
std::string check_promise(Streamed& on, const Terrain& full, std::span<const View> views, const CutReport& cut,
                          const StreamReport& stream, const CutSettings& settings) {
    if (cut.converged && !stream.converged) return "the cut has converged on a terrain that has not";
    if (cut.waiting != 0 || cut.error_bound_px > std::max(settings.max_error_px, stream.missing_px)) return {};
    const VertexSet active = active_set(on.cut);
    // Vertices that morph come early: two levels of nesting (fjell/cut.h).
    const double nested = settings.morph == Morph::none ? 1 : 1 + static_cast<double>(full.header().nesting);
    const double early = nested * nested;
    if (stream.converged)
        return difference(active, target_set(full, full, thresholds_over(early, views), settings.max_error_px / early,
                                             settings.corner_safe));
    if (stream.missing_px >= 1e7) return {}; // of an eye inside the sphere of what is missing nothing can be said
    const double px = stream.missing_px * (1 + 1e-6) / early;
    const std::vector<View> at_px = thresholds_over(settings.max_error_px / px, views);
    if (!contains(active, target_set(full, full, at_px, px, settings.corner_safe)))
        return "something wanted at the threshold of the missing pages is not active";
    return {};
}

struct Flight {
    int rounds, frames;
    ClientScript script;
    bool rests; // converges in the end, or says what it lacks
};

struct Seen {
    std::uint64_t removed = 0, converged = 0, limited = 0, failed = 0, lost = 0, declined = 0, cancelled = 0;
};

Seen fly(std::uint32_t seed, const Flight& flight) {
    Random random(seed);
    Seen seen;
    for (int round = 0; round < flight.rounds; ++round) {
        const auto pack = streamed_terrain(random);
        StreamBudget budget;
        budget.page_requests = static_cast<std::uint32_t>(pick(random, 1, 40));
        const std::uint32_t slots = random_slots(random, pack.terrain);
        const auto count = static_cast<std::uint32_t>(pick(random, 1, 3));
        Streamed on(pack.pack, slots, budget, count);
        ScriptedClient client(random, on, flight.script);
        std::vector<View> views;
        for (std::uint32_t i = 0; i < count; ++i) views.push_back(random_view(random, pack.terrain));
        CutSettings settings;
        settings.max_error_px = std::pow(10.0, uniform(random, 0, 2.5));
        for (View& view : views)
            if (pick(random, 0, 2) == 0)
                view.max_error_px = settings.max_error_px * std::pow(10.0, uniform(random, -1, 1));
        settings.corner_safe = pick(random, 0, 4) == 0;
        settings.morph = pick(random, 0, 2) == 0 ? Morph::error : Morph::none;
        settings.morph_s = 0.05;
        StreamSettings stream_settings;
        stream_settings.pages = static_cast<std::uint32_t>(pick(random, 1, 12));
        stream_settings.lookahead_s = pick(random, 0, 1) ? 0.5 : 0;
        for (int frame = 0; frame < flight.frames; ++frame) {
            if (pick(random, 0, 7) == 0) views[0] = random_view(random, pack.terrain);
            for (View& view : views) view = moved(random, view, random_step_m(random, pack.terrain));
            settings.max_work = pick(random, 0, 2) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, 99));
            stream_settings.tests = pick(random, 0, 5) ? 1u << 16 : static_cast<std::uint32_t>(pick(random, 1, 99));
            settings.now_s = stream_settings.now_s += 1.0 / 60;
            client.act();
            const StreamReport stream = on.update(views, settings, stream_settings);
            client.follow();
            const CutReport report = on.cut.update(views, settings);
            CAPTURE(round, frame, slots, count, settings.max_error_px, settings.max_work, stream.missing_px);
            REQUIRE(check_stream(on) == "");
            REQUIRE(check_frame(on.cut, pack.terrain, report, settings) == "");
            REQUIRE(check_promise(on, pack.terrain, views, report, stream, settings) == "");
            REQUIRE(client.read_twice == 0);
            for (const PageArrival& a : stream_page_arrivals(on.stream)) seen.removed += a.event == PageEvent::removed;
            seen.cancelled += stream.cancelled;
            seen.failed += stream_failures(on.stream).size();
        }
        settings.max_work = unlimited_work;
        stream_settings.tests = 1u << 16;
        StreamReport stream;
        CutReport report;
        std::uint64_t read = 0;
        int quiet = 0; // frames in which nothing came, went or was requested
        for (int frame = 0; quiet < 20 && frame < 3000; ++frame) {
            settings.now_s = stream_settings.now_s += 1.0 / 60;
            client.act();
            stream = on.update(views, settings, stream_settings);
            client.follow();
            report = on.cut.update(views, settings);
            const bool rests =
                stream_page_arrivals(on.stream).empty() && stream.pages_read == read && stream.in_flight == 0;
            quiet = rests ? quiet + 1 : 0;
            read = stream.pages_read;
        }
        CAPTURE(round, slots, pack.terrain.page_count(), settings.max_error_px, stream.missing_px, stream.in_flight);
        REQUIRE(check_frame(on.cut, pack.terrain, report, settings) == "");
        REQUIRE(check_promise(on, pack.terrain, views, report, stream, settings) == "");
        seen.converged += stream.converged;
        seen.limited += (stream.exhausted & stream_page_slots) != 0;
        seen.lost += client.lost;
        seen.declined += client.declined;
        if (!flight.rests) continue;
        REQUIRE(quiet == 20); // it does not push pages around for ever
        REQUIRE((stream.converged || (stream.exhausted & stream_page_slots) != 0));
        REQUIRE(report.converged == stream.converged);
        if (!stream.converged) REQUIRE(report.error_bound_px == stream.missing_px);
    }
    return seen;
}

} // namespace

TEST_CASE("pages that come late and go leave a whole mesh that keeps its promise, and it converges at rest") {
    const Seen seen = fly(301, {rounds(14, 24), 60, {.most_delay = 10, .most_taken = 4}, true});
    CAPTURE(seen.removed, seen.converged, seen.limited, seen.declined, seen.cancelled);
    REQUIRE(seen.removed > 5);
    REQUIRE(seen.converged > rounds<std::uint64_t>(1, 3));
    REQUIRE(seen.limited > rounds<std::uint64_t>(1, 3));
    REQUIRE(seen.declined > rounds<std::uint64_t>(8, 15));
    REQUIRE(seen.cancelled > rounds<std::uint64_t>(0, 3));
}

TEST_CASE("reads that fail, bring garbage or are cut short are reported once each and leave a whole mesh") {
    const Seen seen =
        fly(302, {rounds(14, 18), 60, {.fails = 0.05, .garbage = 0.05, .short_reads = 0.05, .most_delay = 10}, false});
    CAPTURE(seen.failed, seen.removed);
    REQUIRE(seen.failed > rounds<std::uint64_t>(10, 20));
    REQUIRE(seen.removed > 1);
}

TEST_CASE("reads that never return leave a whole mesh, and what does return is used") {
    const Seen seen = fly(303, {rounds(11, 16), 60, {.never = 0.05, .most_delay = 10}, false});
    CAPTURE(seen.lost, seen.removed);
    REQUIRE(seen.lost > rounds<std::uint64_t>(2, 5));
    REQUIRE(seen.removed > rounds<std::uint64_t>(4, 10));
}

// A stream's own cut keeps pages by asking for them to be released; others lose their vertices with the page.
TEST_CASE("several cuts of one streamed terrain each claim what is true of their own views") {
    Random random(304);
    std::size_t beyond = 0, served = 0;
    for (int round = 0; round < rounds(6, 120); ++round) {
        const auto pack = streamed_terrain(random, false);
        const std::uint32_t slots = pack.terrain.tile_count() + static_cast<std::uint32_t>(pick(random, 2, 30));
        Streamed on(pack.pack, std::min(slots, pack.terrain.page_count()));
        Cut other(on.paged.terrain, ample_cut(pack.terrain));
        ScriptedClient client(random, on, {.most_delay = 4});
        const bool both = round % 2 == 0; // of the cuts' views are given to the stream
        View views[] = {random_view(random, pack.terrain), random_view(random, pack.terrain)};
        CutSettings settings;
        settings.max_error_px = std::pow(10.0, uniform(random, 0, 1.5));
        StreamSettings stream_settings;
        CutReport report;
        for (int frame = 0; frame < 40; ++frame) {
            for (View& view : views)
                if (frame < 20) view = moved(random, view, random_step_m(random, pack.terrain) / 4);
            stream_settings.now_s += 1.0 / 60;
            client.act();
            const StreamReport streamed = on.update({views, both ? 2u : 1u}, settings, stream_settings);
            client.follow();
            (void)on.cut.update({views, 1}, settings);
            report = other.update({views + 1, 1}, settings);
            const double shown_px = measure_error(pack.terrain, other.mesh(), views[1]).max_px;
            CAPTURE(round, both, frame, settings.max_error_px, streamed.missing_px);
            REQUIRE(shown_px <= report.error_bound_px * (1 + 1e-6));
            beyond += shown_px > std::max(settings.max_error_px, streamed.missing_px) * 1.01;
        }
        served += both && report.converged;
    }
    CHECK(beyond > 3); // what the stream says of its own views would be wrong
    CHECK(served > 1);
}
