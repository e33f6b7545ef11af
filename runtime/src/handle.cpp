#include "handle.h"

#include <atomic>

namespace fjell {

std::uint64_t next_identity() {
    static std::atomic<std::uint64_t> last{0};
    return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

} // namespace fjell
