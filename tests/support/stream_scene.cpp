#include "support/stream_scene.h"

#include <algorithm>
#include <cstring>

#include "shared/terrain_data.h"

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

namespace {
std::vector<std::byte> decode(const Pack& pack, const StreamRequest& r, std::span<const std::byte> stored) {
    std::vector<std::byte> all;
    for (std::uint32_t i = 0; i < r.chunks; ++i) {
        const ChunkEntry e = pack.entry(chunk_index(pack.header, r.id) + i);
        const std::size_t before = all.size();
        all.resize(before + e.raw_bytes);
        require(decode_chunk(e, stored.subspan(static_cast<std::size_t>(e.offset - r.offset), e.stored_bytes),
                             std::span(all).subspan(before)));
    }
    return all;
}
} // namespace

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
        const bool elsewhere = answered % 2 == 1 && !garbage; // every other one is decoded by the client itself
        std::vector<std::byte> decoded = elsewhere ? decode(on.pack, r, stored) : std::vector<std::byte>();
        if (cut_short) {
            stored.resize(static_cast<std::size_t>(pick(random, 0, static_cast<int>(r.bytes) - 1)));
            decoded.resize(std::min(stored.size(), decoded.size() - std::min<std::size_t>(decoded.size(), 1)));
        }
        const Status given = elsewhere ? stream_provide_decoded(on.stream, r.ticket, decoded)
                                       : stream_provide(on.stream, r.ticket, stored);
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
    if (const Violation found = validate_terrain(*s.terrain)) return in_words(found);
    return in_words(validate_stream(s));
}

} // namespace fjell::test
