// mesh(): heights to triangles, by the mesher of the baker.
#include <memory>

#include "baker/outlets/height_mesh.h"
#include "calls.h"

namespace fjell::web {

using namespace fjell::baker;

// type: NumberType. numbers: spacing x, spacing z, max_error; then true error, vertices, their address, triangles,
// their address. The mesh stays until mesh_free().
FJELL_CALL HeightMesh* mesh_make(const std::byte* heights, std::uint32_t type, std::uint32_t columns,
                                 std::uint32_t rows) {
    static constexpr std::ptrdiff_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    const std::ptrdiff_t step = bytes[type];
    const HeightArray array{
        heights, static_cast<NumberType>(type), columns, rows, step, step * static_cast<std::ptrdiff_t>(columns)};
    HeightMeshOptions options{{numbers[0], numbers[1]}, numbers[2], NoData::hole};
    options.threads = 1;
    auto made = std::make_unique<HeightMesh>(mesh_unfilled(array, options));
    numbers[0] = made->true_error_m;
    numbers[1] = static_cast<double>(made->vertices.size());
    numbers[2] = static_cast<double>(reinterpret_cast<std::uintptr_t>(made->vertices.data()));
    numbers[3] = static_cast<double>(made->triangles.size());
    numbers[4] = static_cast<double>(reinterpret_cast<std::uintptr_t>(made->triangles.data()));
    return made.release();
}
FJELL_CALL void mesh_free(HeightMesh* mesh) {
    delete mesh;
}

} // namespace fjell::web
