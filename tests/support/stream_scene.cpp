#include "support/stream_scene.h"

#include <algorithm>
#include <cstring>

#include "pack/memory.h"
#include "pack/terrain_data.h"
#include "stream/requests.h"

namespace fjell::test {

namespace {
void require(const Status& status) {
    if (!status.ok()) throw std::runtime_error(std::string(status.field) + ": " + message(status.code));
}
} // namespace

Streamed::Streamed(const Pack& source, const CutBudget& cut_budget, std::uint32_t page_slots,
                   const StreamBudget& budget)
    : pack(source), paged(source, {.page_slots = page_slots}), cut(paged.terrain, cut_budget) {
    const std::size_t bytes = stream_bytes(pack, paged.terrain, budget);
    memory = io::allocate(bytes);
    require(create_stream(pack, paged.terrain, cut.cut, budget, {memory.get(), bytes}, stream));
}

namespace {
CutBudget ample_for(const Pack& pack, std::uint32_t views) {
    PagedTerrain all(pack, {.page_slots = 1});
    return ample_cut(all.terrain, views);
}
} // namespace

Streamed::Streamed(const Pack& source, std::uint32_t page_slots, const StreamBudget& budget, std::uint32_t views)
    : Streamed(source, ample_for(source, views), page_slots, budget) {}

StreamReport Streamed::update(std::span<const View> views, const CutSettings& cut_settings,
                              const StreamSettings& settings) {
    StreamReport report;
    require(update_stream(stream, views, cut_settings, settings, report));
    return report;
}

ScriptedClient::ScriptedClient(Random& numbers, Streamed& streamed, const ClientScript& what)
    : random(numbers), on(streamed), script(what) {}

void ScriptedClient::act() {
    ++frame;
    std::erase_if(held, [&](const Held& h) {
        if (h.due > frame) return false;
        const StreamRequest& r = h.request;
        std::vector<std::byte> stored(on.pack.bytes.begin() + static_cast<std::ptrdiff_t>(r.offset),
                                      on.pack.bytes.begin() + static_cast<std::ptrdiff_t>(r.offset + r.bytes));
        if (!stream_still_wanted(on.stream, r.ticket)) {
            (void)stream_fail(on.stream, r.ticket, true);
            ++declined;
            return true;
        }
        double dice = uniform(random, 0, 1);
        const auto falls = [&](double share) { return (dice -= share) < 0; };
        if (falls(script.fails)) {
            (void)stream_fail(on.stream, r.ticket);
            broken.push_back(r.id);
            return true;
        }
        const bool garbage = falls(script.garbage);
        if (garbage)
            stored[static_cast<std::size_t>(pick(random, 0, static_cast<int>(r.bytes) - 1))] ^= std::byte{0x41};
        const bool cut_short = !garbage && falls(script.short_reads);
        if (cut_short) stored.resize(static_cast<std::size_t>(pick(random, 0, static_cast<int>(r.bytes) - 1)));
        const Status given = stream_provide(on.stream, r.ticket, stored);
        if (given.ok() != !(garbage || cut_short)) throw std::runtime_error("garbage was taken, or good bytes refused");
        if (!given.ok()) broken.push_back(r.id);
        ++answered;
        return true;
    });
    StreamRequest r;
    for (int n = pick(random, 0, script.most_taken); n > 0 && stream_next_request(on.stream, r); --n) {
        ++taken;
        if (r.id.kind == ChunkKind::geometry) {
            const auto page = std::pair(r.id.tile, r.id.item);
            read_twice += there.count(page);
        }
        if (uniform(random, 0, 1) < script.never) {
            ++lost;
            continue;
        }
        held.push_back({r, frame + pick(random, 0, script.most_delay)});
    }
}

void ScriptedClient::follow() {
    for (const PageArrival& a : stream_page_arrivals(on.stream)) {
        if (a.event == PageEvent::inserted) there.insert({a.tile, a.page});
        if (a.event == PageEvent::removed) there.erase({a.tile, a.page});
    }
}

std::string check_stream(Streamed& streamed) {
    const StreamState& s = streamed.state();
    const Terrain& t = streamed.paged.terrain;
    std::uint32_t reserved = 0;
    std::vector<std::uint32_t> below(s.slots, 0);
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        const Request& r = s.requests[i];
        if (phase_of(r) == Phase::vacant) continue;
        ++reserved;
        if (s.states[r.watch] != WatchState::in_flight) return "a request whose page is not in flight";
        if (r.watch < s.slots * watches_per_slot) ++below[r.watch / watches_per_slot];
    }
    if (reserved != s.reserved_slots) return "reserved slots do not add up";
    if (data_of(t).memory->free_count < reserved) return "a request without a slot";
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) {
        const std::uint32_t page = data_of(t).slot_page[slot], watch = s.slot_watch[slot];
        if ((page == no_index) != (watch == no_index)) return "a slot is taken in one place and free in another";
        if (page == no_index) continue;
        if (s.watch_page[watch] != page) return "a slot's watch speaks of another page";
        if (s.states[watch] != WatchState::loaded && s.states[watch] != WatchState::evicting)
            return "loaded, but not so";
        if (watch < s.slots * watches_per_slot) {
            ++below[watch / watches_per_slot];
            if (data_of(t).slot_page[watch / watches_per_slot] == no_index) return "a page without the one above it";
        }
    }
    for (std::uint32_t slot = 0; slot < s.slots; ++slot)
        if (data_of(t).slot_page[slot] != no_index && below[slot] != s.below[slot]) return "pages below do not add up";
    for (std::uint32_t tile = 0; tile < s.tiles; ++tile)
        if (const std::uint32_t slot = data_of(t).page_table[tile * t.pages_per_tile()].slot;
            slot != no_index && s.states[s.slots * watches_per_slot + tile] != WatchState::loaded)
            return "a coarsest page is not pinned";
    return {};
}

} // namespace fjell::test
