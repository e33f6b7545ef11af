#include "stream/requests.h"
#include "shared/hash.h"
#include "stream/maps.h"

#define ZSTD_STATIC_LINKING_ONLY // a decoder in the caller's memory
#include <zstd.h>

#include <cstring>
#include <thread>

namespace fjell {

bool queue_request(StreamState& s, Request& r, const ChunkId& id, std::uint32_t chunks, float score) {
    FJELL_ASSERT(may_follow(phase_of(r), Phase::queued));
    r.id = id;
    r.chunks = chunks;
    r.first_chunk = chunk_index(s.pack->header, id);
    std::uint64_t end = 0, raw = 0;
    for (std::uint32_t i = 0; i < chunks; ++i) {
        const ChunkEntry e = s.pack->entry(r.first_chunk + i);
        if (i == 0) r.offset = end = e.offset;
        if (e.offset != end) return false;
        end += e.stored_bytes;
        raw += chunk_raw_bytes(s.pack->header, {id.kind, id.tile, id.item + i});
    }
    if (end - r.offset > 0xffffffff) return false;
    r.stored_bytes = static_cast<std::uint32_t>(end - r.offset);
    r.raw_bytes = static_cast<std::uint32_t>(raw);
    r.score.store(score, std::memory_order_relaxed);
    r.cancelled.store(false, std::memory_order_relaxed);
    const std::uint32_t generation = (r.state.load(std::memory_order_relaxed) >> 3) + 1;
    r.state.store(generation << 3 | static_cast<std::uint32_t>(Phase::queued), std::memory_order_release);
    return true;
}

Request* vacant_request(StreamState& s, bool map) {
    const std::uint32_t begin = map ? s.budget.page_requests : 0, end = map ? s.request_count : s.budget.page_requests;
    for (std::uint32_t i = begin; i < end; ++i)
        if (phase_of(s.requests[i]) == Phase::vacant) return &s.requests[i];
    return nullptr;
}

Request* best_ready(StreamState& s, std::uint32_t begin, std::uint32_t end) {
    Request* best = nullptr;
    float most = -1;
    for (std::uint32_t i = begin; i < end; ++i) {
        Request& r = s.requests[i];
        if (phase_of(r) != Phase::ready) continue;
        const float score = r.score.load(std::memory_order_relaxed);
        if (score > most) most = score, best = &r;
    }
    return best;
}

namespace {

// Tickets: the entry's number + 1 in the low bits, its generation above.
constexpr std::uint32_t ticket_bits = 9;
static_assert(max_requests < (1u << ticket_bits));

std::uint32_t ticket_of(std::uint32_t index, std::uint32_t state) {
    return (state >> 3) << ticket_bits | (index + 1);
}

// The entry that a client thread holds, or nullptr.
Request* taken(StreamState& s, std::uint32_t ticket) {
    const std::uint32_t index = (ticket & ((1u << ticket_bits) - 1)) - 1;
    if (index >= s.request_count) return nullptr;
    Request& r = s.requests[index];
    const std::uint32_t state = r.state.load(std::memory_order_acquire);
    if ((state & 7) != static_cast<std::uint32_t>(Phase::in_flight) || ticket_of(index, state) != ticket)
        return nullptr;
    return &r;
}

Status damaged(Request& r) {
    const bool page = r.id.kind == ChunkKind::geometry; // before the entry is given away
    set_phase(r, Phase::damaged);
    return {StatusCode::corrupt, page ? "geometry page" : "map"};
}

// Maps come with their paint, and over ground that has moved, whoever has decoded them.
Status decoded_to(const StreamState& s, Request& r, std::uint32_t raw_bytes) {
    r.raw_bytes = raw_bytes;
    if (r.id.kind == ChunkKind::colour || r.id.kind == ChunkKind::splat || r.id.kind == ChunkKind::horizon)
        paint_request(s, r);
    set_phase(r, Phase::ready);
    return {};
}

// A decoder for as long as this lives. There is one for each of the client's threads that may be here at a time; were
// there more threads, they would wait.
class DecoderLease {
public:
    explicit DecoderLease(StreamState& s) {
        for (std::uint32_t i = 0;; i = (i + 1) % s.budget.decoders) {
            if (!s.decoders[i].taken.exchange(true, std::memory_order_acquire)) {
                decoder_ = &s.decoders[i];
                return;
            }
            if (i + 1 == s.budget.decoders) std::this_thread::yield();
        }
    }
    ~DecoderLease() { decoder_->taken.store(false, std::memory_order_release); }
    DecoderLease(const DecoderLease&) = delete;
    DecoderLease& operator=(const DecoderLease&) = delete;
    [[nodiscard]] ZSTD_DCtx* zstd() const { return decoder_->zstd; }

private:
    Decoder* decoder_;
};

} // namespace

bool stream_next_request(Stream stream, StreamRequest& request) {
    StreamState* const found = find_stream(stream);
    if (found == nullptr) return false;
    StreamState& s = *found;
    for (;;) {
        std::uint32_t best = no_index;
        float most = -1;
        for (std::uint32_t i = 0; i < s.request_count; ++i) {
            if (phase_of(s.requests[i]) != Phase::queued) continue;
            const float score = s.requests[i].score.load(std::memory_order_relaxed);
            if (score > most) most = score, best = i;
        }
        if (best == no_index) return false;
        Request& r = s.requests[best];
        if (!claim(r, Phase::in_flight)) continue; // cancelled in between, or taken by another thread
        request = {ticket_of(best, r.state.load(std::memory_order_relaxed)), r.id, r.chunks, r.offset, r.stored_bytes};
        return true;
    }
}

bool stream_still_wanted(Stream stream, std::uint32_t ticket) {
    StreamState* const s = find_stream(stream);
    const Request* const r = s != nullptr ? taken(*s, ticket) : nullptr;
    return r != nullptr && !r->cancelled.load(std::memory_order_relaxed);
}

Status stream_provide(Stream stream, std::uint32_t ticket, std::span<const std::byte> stored) {
    StreamState* const found = find_stream(stream);
    if (found == nullptr) return no_stream;
    StreamState& s = *found;
    Request* const r = taken(s, ticket);
    if (r == nullptr) return {StatusCode::out_of_range, "ticket"};
    if (stored.size() != r->stored_bytes) return damaged(*r);
    const DecoderLease decoder(s);
    std::size_t raw = 0;
    for (std::uint32_t i = 0; i < r->chunks; ++i) {
        const ChunkEntry e = s.pack->entry(r->first_chunk + i);
        const auto bytes = stored.subspan(static_cast<std::size_t>(e.offset - r->offset), e.stored_bytes);
        if (e.raw_bytes > r->raw_bytes - raw || hash_of(bytes.data(), bytes.size()) != e.hash) return damaged(*r);
        const std::size_t written =
            ZSTD_decompressDCtx(decoder.zstd(), r->raw + raw, r->raw_bytes - raw, bytes.data(), bytes.size());
        if (ZSTD_isError(written) || written != e.raw_bytes) return damaged(*r);
        raw += written;
    }
    return decoded_to(s, *r, static_cast<std::uint32_t>(raw));
}

Status stream_provide_decoded(Stream stream, std::uint32_t ticket, std::span<const std::byte> decoded) {
    StreamState* const s = find_stream(stream);
    if (s == nullptr) return no_stream;
    Request* const r = taken(*s, ticket);
    if (r == nullptr) return {StatusCode::out_of_range, "ticket"};
    std::uint64_t raw = 0;
    for (std::uint32_t i = 0; i < r->chunks; ++i) raw += s->pack->entry(r->first_chunk + i).raw_bytes;
    if (decoded.size() != raw || raw > r->raw_bytes) return damaged(*r);
    if (!decoded.empty()) std::memcpy(r->raw, decoded.data(), decoded.size());
    return decoded_to(*s, *r, static_cast<std::uint32_t>(raw));
}

Status stream_fail(Stream stream, std::uint32_t ticket, bool unwanted) {
    StreamState* const s = find_stream(stream);
    if (s == nullptr) return no_stream;
    Request* const r = taken(*s, ticket);
    if (r == nullptr) return {StatusCode::out_of_range, "ticket"};
    set_phase(*r, unwanted ? Phase::unwanted : Phase::unreadable);
    return {};
}

} // namespace fjell
