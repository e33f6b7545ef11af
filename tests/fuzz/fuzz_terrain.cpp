// Recipes of landscapes: any text is refused or makes heights, finite ones, the same in any window.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/synth/synth.h"
#include "input.h"

using namespace fjell;
using namespace fjell::baker;
using fuzz::must;

extern "C" int fuzz_terrain(const std::uint8_t* data, std::size_t size) {
    try {
        const auto source = synth_source({reinterpret_cast<const char*>(data), size});
        must(source->columns >= 2 && source->columns <= 65537 && source->rows >= 2 && source->rows <= 65537, "a size");
        // The far corner: the largest numbers.
        const std::int32_t columns = std::min(source->columns, 6), rows = std::min(source->rows, 4);
        const Window window{source->columns - columns, source->rows - rows, columns, rows};
        std::vector<float> heights(window.area());
        ReadStatistics statistics;
        source->reader()->read(window, heights.data(), statistics);
        for (std::size_t i = 0; i < heights.size(); ++i) {
            const auto x = static_cast<std::int32_t>(i) % columns, y = static_cast<std::int32_t>(i) / columns;
            float alone = 0;
            source->reader()->read({window.x + x, window.y + y, 1, 1}, &alone, statistics);
            must(std::isfinite(alone) && std::abs(alone) < 1e5f, "a height is one");
            must(alone == heights[i], "a height depends on its place alone");
        }
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
    }
    return 0;
}
