// Kept memory: ranges of the system's, each with its free pieces by place. A buffer takes the smallest piece that holds
// it, from its beginning; what comes back joins the free pieces beside it. A unit gives back all that it has taken, so
// between units a range is one piece again and nothing splinters over a bake.
#include "baker/store/memory.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>

#include <sys/mman.h>

namespace fjell::baker {

namespace {

constexpr std::size_t large_page = std::size_t{2} << 20;
constexpr std::size_t range_bytes = std::size_t{16} << 20; // or what a larger buffer needs
constexpr std::size_t alignment = 64;

constexpr std::size_t rounded_up(std::size_t bytes, std::size_t to) {
    return (bytes + to - 1) / to * to;
}

} // namespace

ZeroedMemory::ZeroedMemory(std::size_t bytes) {
    if (bytes == 0) return;
    const std::size_t slack = bytes < large_page ? 0 : large_page;
    void* const mapped =
        mmap(nullptr, bytes + slack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    mapped_ = mapped;
    mapped_bytes_ = bytes + slack;
    const auto begin = reinterpret_cast<std::uintptr_t>(mapped);
    data_ = static_cast<std::byte*>(mapped) + (slack ? rounded_up(begin, large_page) - begin : 0);
    bytes_ = bytes;
    // Whole ones only: what the last of them would take beyond the end nobody has counted. A system without them says
    // no, which changes nothing.
    if (slack) (void)madvise(data_, bytes / large_page * large_page, MADV_HUGEPAGE);
}

ZeroedMemory::~ZeroedMemory() {
    if (mapped_) munmap(mapped_, mapped_bytes_);
}

namespace {

struct Range {
    struct Piece {
        std::size_t bytes;
        bool free;
    };
    ZeroedMemory memory;
    std::map<std::size_t, Piece> pieces; // by their places; of two neighbours one is taken at least
    [[nodiscard]] bool unused() const { return pieces.size() == 1 && pieces.begin()->second.free; }
    [[nodiscard]] bool holds(const std::byte* at) const {
        return at >= memory.data() && at < memory.data() + memory.size();
    }
};

class Kept {
public:
    std::byte* take(std::size_t bytes) {
        bytes = rounded_up(bytes, alignment);
        const std::lock_guard hold(lock_);
        Range* best = nullptr;
        std::map<std::size_t, Range::Piece>::iterator piece;
        for (Range& range : ranges_)
            for (auto at = range.pieces.begin(); at != range.pieces.end(); ++at)
                if (at->second.free && at->second.bytes >= bytes && (!best || at->second.bytes < piece->second.bytes))
                    best = &range, piece = at;
        if (!best) {
            ZeroedMemory memory(std::max(range_bytes, rounded_up(bytes, large_page)));
            const Range::Piece all{memory.size(), true};
            best = &ranges_.emplace_back(Range{std::move(memory), {{0, all}}});
            piece = best->pieces.begin();
        }
        if (const std::size_t rest = piece->second.bytes - bytes; rest > 0)
            best->pieces.emplace(piece->first + bytes, Range::Piece{rest, true});
        piece->second = {bytes, false};
        return best->memory.data() + piece->first;
    }

    void give(const std::byte* at) noexcept {
        const std::lock_guard hold(lock_);
        const auto range = std::find_if(ranges_.begin(), ranges_.end(), [&](const Range& r) { return r.holds(at); });
        auto& pieces = range->pieces;
        auto piece = pieces.find(static_cast<std::size_t>(at - range->memory.data()));
        piece->second.free = true;
        if (const auto next = std::next(piece); next != pieces.end() && next->second.free) {
            piece->second.bytes += next->second.bytes;
            pieces.erase(next);
        }
        if (piece == pieces.begin() || !std::prev(piece)->second.free) return;
        std::prev(piece)->second.bytes += piece->second.bytes;
        pieces.erase(piece);
    }

    std::size_t release() noexcept {
        const std::lock_guard hold(lock_);
        std::erase_if(ranges_, [](const Range& r) { return r.unused(); });
        std::size_t held = 0;
        for (const Range& r : ranges_) held += r.memory.size();
        return held;
    }

private:
    std::mutex lock_;
    std::vector<Range> ranges_;
};

// Never destroyed: buffers of other static objects may outlive it.
Kept& kept() {
    static Kept* const one = new Kept;
    return *one;
}

} // namespace

#ifdef FJELL_WATCHED // by a sanitizer, which guards what malloc hands out
std::byte* take_kept(std::size_t bytes) {
    return static_cast<std::byte*>(::operator new (bytes, std::align_val_t{alignment}));
}
void give_kept(std::byte* at) noexcept {
    ::operator delete (at, std::align_val_t{alignment});
}
#else
std::byte* take_kept(std::size_t bytes) {
    return kept().take(bytes);
}
void give_kept(std::byte* at) noexcept {
    kept().give(at);
}
#endif
std::size_t release_kept() noexcept {
    return kept().release();
}

} // namespace fjell::baker
