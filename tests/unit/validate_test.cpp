// What the walks are for (validate.h): each planted corruption is found and named, and gone when it is taken back.
#include <catch2/catch.hpp>

#include <bit>
#include <csignal>
#include <functional>
#include <utility>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "cut/mesh.h"
#include "cut/pages.h"
#include "pack/memory.h"
#include "stream/requests.h"
#include "support/cut_scene.h"
#include "support/stream_scene.h"
#include "validate.h"

using namespace fjell;
using namespace fjell::test;

namespace {

using Walk = std::function<std::string()>;

// The walk must begin with those words while the place holds the value.
template <typename T>
void plant(const Walk& walk, T& place, std::type_identity_t<T> value, const std::string& words) {
    CAPTURE(words);
    const T before = std::exchange(place, value);
    const std::string found = walk();
    place = before;
    CHECK(found.substr(0, words.size()) == words);
    REQUIRE(walk() == "");
}

// The first number below `count` of which that holds; there must be one.
std::uint32_t first(std::uint32_t count, const std::function<bool(std::uint32_t)>& holds) {
    for (std::uint32_t i = 0; i < count; ++i)
        if (holds(i)) return i;
    throw std::runtime_error("nothing to corrupt");
}

// A cut that has come and gone, so that it has free slots, with work left over and vertices that morph by time.
struct Scene {
    Scene()
        : pack(rich_terrain(random, 257, 7)), cut(pack.terrain, ample_cut(pack.terrain)),
          s(cut.state()), walk{[this] { return check_cut(cut); }} {
        settings.max_error_px = 1;
        const View near = view_from_above(pack.terrain, 0.05), far = view_from_above(pack.terrain, 20);
        update(near, unlimited_work - 1); // without a limit it would be built anew, and have no slot that is free
        update(far, unlimited_work - 1);
        update(near, 400);
        settings.morph = Morph::time;
        for (int frame = 0; frame < 3; ++frame) update(near, 200);
        REQUIRE(walk() == "");
        lane = [this](auto holds) {
            return first(s.pages.group_count * group_lanes, [&](std::uint32_t v) {
                if (s.pages.state[v / group_lanes / max_page_groups].page == no_index) return false;
                const std::uint32_t n = v / group_lanes % max_page_groups;
                const PageShape& shape = s.pages.grid.shapes[s.pages.state[v / group_lanes / max_page_groups].shape];
                if (n >= shape.count || v % group_lanes >= shape.groups[n].lanes) return false;
                return exists(s.pages.grid, site_of(s.pages, v)) && find_vertex(s.pages, site_of(s.pages, v)) == v &&
                       holds(s.pages.groups[v / group_lanes], bit_of(v));
            });
        };
    }
    void update(const View& view, std::uint32_t items) {
        settings.now_s += 0.02;
        settings.max_work = items;
        (void)cut.update({&view, 1}, settings);
    }
    Random random{77};
    io::LoadedPack pack;
    Cut cut;
    CutState& s;
    CutSettings settings;
    Walk walk;
    // A vertex whose group and bit have some property.
    std::function<std::uint32_t(std::function<bool(const GroupState&, std::uint32_t)>)> lane;
};

} // namespace

TEST_CASE("a walk over a cut names every mask, slot and page that was tampered with") {
    Scene scene;
    CutState& s = scene.s;
    const Walk& walk = scene.walk;
    const std::uint32_t leaf =
        scene.lane([](const GroupState& b, std::uint32_t bit) { return (b.active & ~b.parental() & bit) != 0; });
    const std::uint32_t parent =
        scene.lane([](const GroupState& b, std::uint32_t bit) { return (b.active & b.parental() & bit) != 0; });
    const std::uint32_t unready =
        scene.lane([](const GroupState& b, std::uint32_t bit) { return (~b.active & ~b.ready() & bit) != 0; });
    const auto bits = [](std::uint32_t mask) { return static_cast<std::uint16_t>(mask); };
    GroupState& of_leaf = s.pages.groups[leaf / group_lanes];
    GroupState& of_parent = s.pages.groups[parent / group_lanes];
    GroupState& of_unready = s.pages.groups[unready / group_lanes];
    plant(walk, of_unready.active, bits(of_unready.active | bit_of(unready)), "a child mask is wrong at");
    plant(walk, of_leaf.active, bits(of_leaf.active & ~bit_of(leaf)), "a child mask is wrong at");
    plant(walk, of_parent.active, bits(of_parent.active & ~bit_of(parent)), "nobody will look at the group of");
    plant(walk, of_leaf.child[0], bits(of_leaf.child[0] | bit_of(leaf)), "a child mask is wrong at");
    plant(walk, of_leaf.parent[0], bits(of_leaf.parent[0] & ~bit_of(leaf)), "an active vertex' parent is not active:");
    plant(walk, of_unready.parent[0], bits(of_unready.parent[0] ^ bit_of(unready)),
          "a parent mask is wrong in the group of");

    plant(walk, s.pages.vertex_slot[leaf], s.pages.vertex_slot[parent], "a vertex slot is another vertex':");
    plant(walk, s.pages.vertex_slot[leaf], s.mesh.capacity, "no vertex slot for");
    REQUIRE(s.mesh.free_vertex_count > 1);
    plant(walk, s.mesh.free_vertices[0], s.mesh.free_vertices[1], "a vertex slot is used or free twice, or lost");
    plant(walk, s.mesh.free_vertices[0], s.pages.vertex_slot[leaf], "a vertex slot is used or free twice, or lost");
    plant(walk, s.mesh.free_vertex_count, s.mesh.free_vertex_count - 1, "a vertex slot is used or free twice, or lost");
    plant(walk, s.mesh.fresh_vertex, s.mesh.fresh_vertex + 1, "a vertex slot is used or free twice, or lost");

    PageState& info = s.pages.state[leaf / group_lanes / max_page_groups];
    plant(walk, info.active, static_cast<std::uint16_t>(info.active + 1), "a page counts its active vertices wrongly");
    plant(walk, info.parents, info.parents - 1, "a page counts its vertices' parents wrongly");
    plant(walk, info.status, PageStatus::evicting, "a page is evicted, and its state does not say so");
    plant(walk, info.terrain_slot, s.pages.grid.terrain->slot_count, "a page's records are another page's");
    plant(walk, s.pages.page_groups[info.page], no_index, "a page's state is not where the page says");
    LoadedPage& loaded = s.pages.loaded[info.terrain_slot];
    plant(walk, loaded.loads, loaded.loads + 1, "a page is loaded, and the cut has not entered it");
    plant(walk, loaded.page, no_index, "a page's records are another page's");
    plant(walk, s.pages.busy, s.pages.busy + 1, "busy pages do not add up");
    plant(walk, s.pages.tiles_waiting, s.pages.tiles_waiting + 1, "tiles whose page 0 has no state do not add up");
    plant(walk, s.pages.fresh, s.pages.fresh + 1, "states are lost, or free twice");
    plant(walk, s.frame.report.vertices, s.frame.report.vertices - 1, "the report counts vertices wrongly");
    plant(walk, s.frame.report.triangles, s.frame.report.triangles + 1, "the report counts triangles wrongly");
    REQUIRE(s.morphing.late_count > 1);
    const std::uint32_t last = (s.morphing.first_late + s.morphing.late_count - 1) % s.mesh.capacity;
    REQUIRE(s.morphing.late_s[last] > s.morphing.late_s[s.morphing.first_late]);
    plant(walk, s.morphing.late_s[last], s.morphing.late_s[s.morphing.first_late] - 1,
          "vertices that morph in are not in their order");
}

TEST_CASE(
    "a walk over a cut names every group that was lost from its queue, and every page that will come up too late") {
    Scene scene;
    CutState& s = scene.s;
    Queues& q = s.work.queues;
    Schedule& l = s.work.schedule;
    const Walk& walk = scene.walk;
    const std::uint32_t rank = first(rank_count, [&](std::uint32_t i) { return q.sizes[work_queues + i] > 1; });
    const std::uint32_t queue = work_queues + rank, head = q.ends[queue].next;
    plant(walk, q.ends[queue].next, q.nodes[head].link.next, "a queue's links disagree");
    plant(walk, q.nodes[head].link.prev, head, "a queue's links disagree");
    plant(walk, q.groups[head].queue, static_cast<QueueId>(queue + 1), "a group is in a queue, and says otherwise");
    plant(walk, q.sizes[queue], q.sizes[queue] + 1, "a queue counts its groups wrongly");
    plant(walk, s.work.queues.work_ranks, s.work.queues.work_ranks & ~(1u << rank),
          "a queue holds work, and nobody will look at it");
    plant(walk, ticks_of(l, head), std::uint16_t{5}, "a group is scheduled, and in a queue");

    scene.update(view_from_above(scene.pack.terrain, 0.05), unlimited_work);
    const std::uint32_t calm = scene.lane([&](const GroupState& b, std::uint32_t bit) {
        const auto group = static_cast<std::uint32_t>(&b - s.pages.groups);
        return b.queue == unqueued && ticks_of(l, group) != unscheduled && !is_due(l, group / max_page_groups) &&
               (b.active & ~b.parental() & bit) != 0;
    });
    const std::uint32_t group = calm / group_lanes, slot = group / max_page_groups;
    PageSchedule& page = l.pages[slot];
    plant(walk, q.groups[group].queue, being_visited, "a group was taken from its queue and not put back");
    plant(walk, ticks_of(l, group), unscheduled, "nobody will look at the group of");
    plant(walk, page.charged_m, page.charged_m + 1e9, "a vertex could change before it is looked at:");
    plant(walk, l.awake[page.awake].due_m, 1e200, "a page comes up later than its groups");
    plant(walk, l.awake[page.awake].due_m, -1e9, "a page's time has come, and it is not due");
    plant(walk, page.level, static_cast<std::uint8_t>(page.level ^ 1), "a page is watched at another level");
    plant(walk, l.awake[page.awake].slot, slot ^ 1, "a page is awake elsewhere");
    plant(walk, page.awake, no_index, "a page sleeps with groups to watch");
    plant(walk, l.awake_count, l.awake_count + 1, "awake pages do not add up");
    plant(walk, l.due_count, l.due_count + 1, "due pages are counted wrongly");
    make_due(l, group);
    const std::uint32_t level = first(due_level_count, [&](std::uint32_t i) { return (l.due_levels >> i & 1) != 0; });
    PageSchedule& due = l.pages[l.due[level].first];
    plant(walk, due.level, static_cast<std::uint8_t>(level ^ 1), "a page is watched at another level");
    plant(walk, l.awake[due.awake].due, false, "a page comes up later than its groups");
    plant(walk, l.due_levels, l.due_levels & ~(1u << level), "due pages are counted wrongly");
    plant(walk, l.due[level].last, no_index, "the last due page is cut off");
}

TEST_CASE("a walk over a cut names every triangle, segment and written slot that was tampered with") {
    Scene scene;
    CutState& s = scene.s;
    const Walk& walk = scene.walk;
    TileList& tile = s.mesh.tiles[0];
    const std::uint32_t slot = tile.last_segment << s.mesh.segment_log2, key = key_of(s.mesh, slot);
    plant(walk, s.mesh.triangle_of[key], slot ^ 1, "a triangle");
    plant(walk, s.mesh.indices[std::size_t{slot} * 3], 0u, "a triangle's right angle does not know it");
    plant(walk, s.mesh.indices[std::size_t{slot} * 3 + 1], s.mesh.capacity, "a triangle's corner was never taken");
    plant(walk, s.mesh.triangle_of[key], no_index, "a triangle");
    plant(walk, tile.total, tile.total + 1, "a tile counts its triangles wrongly");
    plant(walk, tile.segments, tile.segments + 1, "a tile counts its segments wrongly");
    plant(walk, s.mesh.segment_tile[tile.last_segment], 1u, "a segment does not know its tile");
    plant(walk, s.mesh.segment_below[tile.last_segment], s.mesh.tiles[1].last_segment,
          "a segment does not know its tile");
    plant(walk, s.mesh.free_segments[0], tile.last_segment, "a segment is used or free twice, or lost");
    plant(walk, s.mesh.free_segment_count, s.mesh.free_segment_count - 1, "a segment is used or free twice, or lost");
    DirtyBits& written = s.mesh.dirty_vertices;
    REQUIRE(written.word_count > 1);
    plant(walk, written.words[0], written.words[1], "a word of written slots is listed twice, or not at all");
    plant(walk, written.word_count, written.word_count - 1, "words of written slots do not add up");
    plant(walk, written.slots, written.slots + 1, "written slots are counted wrongly");
    plant(walk, written.bits[written.words[0]], std::uint64_t{0}, "words of written slots do not add up");
}

TEST_CASE("a walk over a terrain names every page and slot that was tampered with") {
    Random random(78);
    const auto pack = rich_terrain(random, 257, 7);
    const PagedTerrain paged(pack.pack, {.page_slots = 12});
    for (std::uint32_t tile = 0; tile < 4; ++tile) REQUIRE(load_page(pack.pack, paged.terrain, tile, 0).ok());
    TerrainData& t = data_of(paged.terrain);
    TerrainMemory& m = *t.memory;
    const Walk walk = [&] { return in_words(validate_terrain(t)); };
    const std::uint32_t slot = m.page_table[0].slot, other = m.page_table[t.pages_per_tile].slot;
    plant(walk, m.page_table[0].slot, other, "a page's slot holds another page");
    plant(walk, m.page_table[0].slot, t.slot_count, "a page lies in a slot that there is not");
    plant(walk, m.page_table[0].slot, no_index, "missing pages are counted wrongly");
    plant(walk, m.page_table[0].base, max_height_steps + 1, "a page's base is off the height scale");
    plant(walk, t.pages_missing, t.pages_missing + 1, "missing pages are counted wrongly");
    plant(walk, m.slot_page[slot], no_index, "a page's slot holds another page");
    plant(walk, m.slot_page[m.free_slots[0]], 1u, "a slot's page lies elsewhere");
    plant(walk, m.slot_loads[slot], 0u, "a page lies in a slot that nothing was loaded into");
    plant(walk, m.free_slots[0], m.free_slots[1], "a slot is free twice, or used and free");
    plant(walk, m.free_slots[0], slot, "a slot is free twice, or used and free");
    plant(walk, m.free_count, m.free_count - 1, "free slots do not add up");
}

TEST_CASE("a walk over a stream names every page, request and layer that was tampered with") {
    Random random(79);
    baker::BakeOptions bake = small_bake(7);
    bake.max_texture_log2 = 6;
    const auto pack = bake_and_load(random_dem(random, 257, 257, Shape::fractal), bake);
    StreamBudget budget;
    budget.tail_log2 = 3;
    Streamed on(pack.pack, 14, budget);
    ScriptedClient client(random, on, {.most_delay = 3, .most_taken = 3});
    const View view = view_from_above(pack.terrain, 0.05);
    CutSettings cut;
    StreamSettings settings;
    StreamReport report;
    const Walk walk = [&] { return check_stream(on); };
    for (int frame = 0; frame < 60 && !(frame > 20 && report.in_flight > 2); ++frame) {
        settings.now_s += 0.02;
        client.act();
        report = on.update({&view, 1}, cut, settings);
        client.follow();
        (void)on.cut.update({&view, 1}, cut);
        REQUIRE(walk() == "");
    }
    StreamState& s = on.state();
    const std::uint32_t slot =
        first(s.slots, [&](std::uint32_t i) { return s.slot_watch[i] != no_index && s.below[i] != 0; });
    const std::uint32_t watch = s.slot_watch[slot];
    plant(walk, s.reserved_slots, s.reserved_slots + 1, "reserved slots do not add up");
    plant(walk, s.states[watch], WatchState::in_flight, "a page is in flight without a request");
    plant(walk, s.states[watch], WatchState::failed, "a page has failed without a failure");
    plant(walk, s.below[slot], static_cast<std::uint8_t>(s.below[slot] - 1), "pages below do not add up");
    plant(walk, s.slot_watch[slot], no_index, "a slot is taken in one place and free in another");
    plant(walk, s.evicting_count, s.evicting_count + 1, "a page is evicted that is not listed, or listed twice");
    std::uint64_t& bits = s.missing_bits[watch / 64];
    plant(walk, bits, bits ^ std::uint64_t{1} << watch % 64, "a page is missed, and loaded or not watched");

    const std::uint32_t kind = s.maps[0].sizes.top_log2 > 3 ? 0 : 1;
    MapState& m = s.maps[kind];
    const std::uint32_t tile =
        first(s.tiles, [&](std::uint32_t i) { return m.tiles[i].size_log2 > m.sizes.tail_log2; });
    MapArray& array = m.arrays[m.tiles[tile].size_log2];
    plant(walk, m.tiles[tile].layer, m.tiles[tile].layer + 1, "a tile shows another map than it has");
    plant(walk, m.tiles[tile].in_flight, !m.tiles[tile].in_flight,
          "a tile waits for a map without a request, or twice");
    plant(walk, array.free_count, array.free_count ^ 1, "a layer is used or free twice, or lost");
}

namespace {

// What a child that aborts has written on stderr; it must abort.
std::string last_words(const std::function<void()>& child_does) {
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    const pid_t child = fork();
    if (child == 0) {
        std::signal(SIGABRT, SIG_DFL);
        dup2(ends[1], STDERR_FILENO);
        child_does();
        _exit(0);
    }
    close(ends[1]);
    std::string said;
    char piece[256];
    for (ssize_t n = 0; (n = read(ends[0], piece, sizeof piece)) > 0;) said.append(piece, static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT));
    return said;
}

void host_log(const char* condition, const char* file, int line) {
    dprintf(STDERR_FILENO, "host's log: %s (%s, %d)", condition, file, line);
}

} // namespace

TEST_CASE("an assert that fails is the host's handler's to report, or a line on stderr, and aborts") {
    const auto fail = [] { fail_assert("cut.cpp", 7, "used <= capacity"); };
    CHECK(last_words(fail) == "cut.cpp:7: must hold: used <= capacity\n");
    CHECK(last_words([&] {
              (void)set_assert_handler(host_log);
              fail();
          }) == "host's log: used <= capacity (cut.cpp, 7)");
    CHECK(last_words([&] {
              (void)set_assert_handler(host_log);
              (void)set_assert_handler(nullptr);
              fail();
          }) == "cut.cpp:7: must hold: used <= capacity\n");
#ifdef FJELL_VALIDATE
    CHECK(set_assert_handler(nullptr)); // compiled in
    CHECK(last_words([] {
              (void)set_assert_handler(host_log);
              Scene scene;
              scene.s.mesh.tiles[0].total += 1;
              while (!std::has_single_bit(scene.s.frame.number + 1))
                  scene.update(view_from_above(scene.pack.terrain, 0.05), 0);
              scene.update(view_from_above(scene.pack.terrain, 0.05), 400);
          }).starts_with("host's log: "));
#else
    CHECK_FALSE(set_assert_handler(nullptr));
#endif
}

#ifdef FJELL_VALIDATE

TEST_CASE("the library walks by itself and asserts: it aborts a process whose cut was tampered with") {
    const auto aborts = [](const std::function<void(Scene&)>& tamper) {
        Scene scene;
        const pid_t child = fork();
        if (child == 0) {
            std::signal(SIGABRT, SIG_DFL);
            (void)std::freopen("/dev/null", "w", stderr);
            tamper(scene);
            while (!std::has_single_bit(scene.s.frame.number + 1))
                scene.update(view_from_above(scene.pack.terrain, 0.05), 0);
            scene.update(view_from_above(scene.pack.terrain, 0.05), 400);
            _exit(0);
        }
        int status = 0;
        REQUIRE(waitpid(child, &status, 0) == child);
        return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
    };
    CHECK_FALSE(aborts([](Scene&) {}));
    CHECK(aborts([](Scene& scene) { scene.s.mesh.tiles[0].total += 1; }));
    CHECK(aborts([](Scene& scene) { // the slot that is taken next
        REQUIRE(scene.s.mesh.free_vertex_count != 0);
        scene.s.mesh.free_vertices[scene.s.mesh.free_vertex_count - 1] = scene.s.mesh.indices[0];
    }));
}

#endif
