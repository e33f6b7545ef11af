#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/heights/fill.h"
#include "baker/outlets/height_mesh.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

HeightMesh mesh_heights(const HeightArray& heights, const HeightMeshOptions& options) {
    if (options.nodata != NoData::fill || !has_voids(heights, options)) return mesh_unfilled(heights, options);
    const int threads = resolve_threads(options.threads);
    const auto columns = static_cast<std::int32_t>(heights.columns);
    Store<float> raw({}, columns, heights.rows), filled({}, columns, heights.rows);
    std::vector<float> row(static_cast<std::size_t>(columns));
    for (std::int32_t y = 0; y < heights.rows; ++y) {
        heights.read(y, 0, columns, row.data());
        raw.write({0, y, columns, 1}, row.data(), columns);
    }
    fill_voids(
        {raw,
         {},
         threads,
         [](const std::string&, std::int64_t across, std::int64_t down) { return Store<float>({}, across, down); }},
        filled);
    const HeightArray ground{reinterpret_cast<const std::byte*>(filled.in_memory()),
                             NumberType::float32,
                             heights.columns,
                             heights.rows,
                             sizeof(float),
                             static_cast<std::ptrdiff_t>(sizeof(float)) * heights.columns};
    return mesh_unfilled(ground, options);
}

} // namespace fjell::baker
