#include "baker/outlets/read_ground.h"

#include <mutex>

#include <fmt/format.h>

#include "baker/heights/fill.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

HeightArray Ground::array() const {
    return {
        reinterpret_cast<const std::byte*>(heights_m.in_memory()), NumberType::float32, columns, rows, sizeof(float),
        static_cast<std::ptrdiff_t>(sizeof(float)) * columns};
}

Ground read_ground(const HeightSource& source, GroundHoles holes, int threads, const Progress& progress) {
    Ground ground{source.columns, source.rows, {source.spacing_m[0], source.spacing_m[1]}, 0, 0, 0, 0, 0, {}};
    ground.heights_m = Store<float>({}, source.columns, source.rows);
    const std::vector<Window> windows = source.windows(std::size_t{1} << 20);
    ReadStatistics all;
    std::mutex lock;
    std::uint64_t done = 0;
    parallel_for(static_cast<std::int64_t>(windows.size()), source.readers(resolve_threads(threads)),
                 [&](std::int64_t i) {
                     const Window& w = windows[static_cast<std::size_t>(i)];
                     std::vector<float> read(w.area());
                     ReadStatistics part;
                     source.reader()->read(w, read.data(), part);
                     ground.heights_m.write(w, read.data(), w.columns);
                     const std::lock_guard hold(lock);
                     all.add(part);
                     if (progress) progress("read", ++done, windows.size());
                 });
    const SourceProperties properties = source.properties(all);
    ground.quantum_m = properties.native_quantum_m, ground.anchor_m = properties.anchor_m;
    ground.min_m = all.least_m, ground.max_m = all.most_m;
    ground.holes = all.voids.count + all.implausible.count;
    if (ground.holes == 0) return ground;
    if (holes == GroundHoles::refuse && properties.holes)
        throw Failure(1, fmt::format("{} of {} samples are holes, which no engine's height field has; give --nodata "
                                     "fill to make ground of them",
                                     ground.holes, std::int64_t{ground.columns} * ground.rows));
    if (holes == GroundHoles::as_source && properties.holes) return ground;
    Store<float> filled({}, source.columns, source.rows);
    const auto level = [](const std::string&, std::int64_t columns, std::int64_t rows) {
        return Store<float>({}, columns, rows);
    };
    fill_voids({ground.heights_m, {properties.native_quantum_m, properties.anchor_m}, resolve_threads(threads), level},
               filled);
    ground.heights_m = std::move(filled);
    for (std::int32_t y = 0; y < ground.rows; ++y)
        for (std::int32_t x = 0; x < ground.columns; ++x) {
            ground.min_m = std::min(ground.min_m, ground.row(y)[x]);
            ground.max_m = std::max(ground.max_m, ground.row(y)[x]);
        }
    return ground;
}

} // namespace fjell::baker
