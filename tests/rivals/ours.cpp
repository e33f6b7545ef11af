#include "rivals/ours.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/terrain_data.h"

namespace fjell::rivals {

namespace {

void ensure(const Status& status) {
    if (!status.ok()) throw std::runtime_error(std::string(status.field) + ": " + message(status.code));
}

CutBudget ample_cut_budget(const Terrain& terrain) {
    const std::uint32_t samples = terrain.columns() * terrain.rows();
    const std::uint32_t vertices = std::min(samples + 4096, std::max(CutBudget{}.vertices, samples / 16));
    return {vertices, 2 * vertices + 4096, 512, 1};
}
RecursiveBudget ample_recursive_budget(const Terrain& terrain) {
    const std::uint32_t vertices = std::min(terrain.columns() * terrain.rows() + 256, RecursiveBudget{}.vertices);
    return {vertices, 6 * vertices};
}

// height_m(index) of a vertex of the mesh.
template <typename Height>
void faces_of_mesh(const MeshView& mesh, const Height& height_m, std::vector<Face>& out) {
    out.clear();
    for (const TileRange& range : mesh.tiles) {
        const bool strip = mesh.topology == Topology::strip;
        for (std::uint32_t i = 0; i + 3 <= range.index_count; i += strip ? 1 : 3) {
            Face f;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t index = mesh.indices[range.first_index + i + k];
                const MeshVertex& v = mesh.vertices[index];
                f[k] = {static_cast<float>(v.column), static_cast<float>(v.row), height_m(index)};
            }
            if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) continue;
            if (strip && i % 2 == 1) std::swap(f[1], f[2]);
            out.push_back(f);
        }
    }
}

} // namespace

void faces_of(const MeshView& mesh, std::vector<Face>& out) {
    faces_of_mesh(
        mesh, [&](std::uint32_t i) { return mesh.vertices[i].height_m; }, out);
}

Ground square_around(const Terrain& terrain) {
    const TerrainData& data = data_of(terrain);
    const auto columns = static_cast<std::int32_t>(terrain.columns()), rows = static_cast<std::int32_t>(terrain.rows());
    Ground g;
    g.side = std::max(columns, rows) - 1;
    g.spacing_x_m = terrain.spacing_x_m();
    g.spacing_z_m = terrain.spacing_z_m();
    g.min_m = terrain.header().min_m;
    g.max_m = terrain.header().max_m;
    g.height_m.resize(static_cast<std::size_t>(g.side + 1) * static_cast<std::size_t>(g.side + 1));
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x) g.height_m[g.index({x, y})] = data.vertex({x, y}).height_m;
    return g;
}

std::span<std::byte> Memory::span() {
    void* start = raw_.data();
    std::size_t left = raw_.size();
    return {static_cast<std::byte*>(std::align(64, bytes_, start, left)), bytes_};
}

Incremental::Incremental(const Terrain& terrain, bool morphing, double offscreen_factor)
    : terrain_(terrain), memory_(cut_bytes(terrain, ample_cut_budget(terrain))), morphing_(morphing),
      offscreen_factor_(offscreen_factor) {
    ensure(create_cut(terrain, ample_cut_budget(terrain), memory_.span(), cut_));
}

Refined Incremental::refine(const View& view, double error_px, std::uint32_t operations) {
    CutSettings settings;
    settings.max_error_px = error_px;
    settings.max_work = operations;
    settings.offscreen_factor = offscreen_factor_;
    settings.morph = morphing_ ? Morph::error : Morph::none;
    settings.now_s = now_s_ += 1.0 / 60; // or what comes late would never arrive
    CutReport report;
    ensure(update_cut(cut_, {&view, 1}, settings, report));
    if (report.exhausted & (cut_budget_vertices | cut_budget_triangles))
        throw std::runtime_error("incremental: its slots do not suffice; ask for a larger threshold");
    (void)cut_take_changes(cut_); // as a renderer does
    return {report.triangles, report.waiting > 0};
}

void Incremental::faces(std::vector<Face>& out) const {
    const CutMesh live = cut_mesh(cut_);
    faces_of_mesh(
        live.mesh,
        [&](std::uint32_t i) {
            const MeshVertex& v = live.mesh.vertices[i];
            return morphing_ ? morphed_height_m(terrain_, v, live.morph[i], live.frame) : v.height_m;
        },
        out);
}

std::size_t Incremental::bytes() const {
    return memory_.size() + terrain_bytes(terrain_.header());
}

Recursive::Recursive(const Terrain& terrain)
    : terrain_(terrain), memory_(recursive_bytes(terrain, ample_recursive_budget(terrain))) {
    ensure(create_recursive(terrain, ample_recursive_budget(terrain), memory_.span(), method_));
}

Refined Recursive::refine(const View& view, double error_px, std::uint32_t) {
    RefineSettings settings;
    settings.max_error_px = error_px;
    settings.topology = Topology::strip;
    FrameReport report;
    ensure(update_recursive(method_, view, settings, report));
    if (!report.converged) throw std::runtime_error("recursive: its slots do not suffice; ask for a larger threshold");
    return {report.triangles, false};
}

void Recursive::faces(std::vector<Face>& out) const {
    const MeshView mesh = recursive_mesh(method_);
    faces_of_mesh(
        mesh, [&](std::uint32_t i) { return mesh.vertices[i].height_m; }, out);
}

std::size_t Recursive::bytes() const {
    return memory_.size() + terrain_bytes(terrain_.header());
}

Lean::Lean(const Terrain& terrain)
    : spacing_x_m_(terrain.spacing_x_m()), spacing_z_m_(terrain.spacing_z_m()),
      recursion_(terrain,
                 std::min<std::size_t>(std::size_t{1} << 23, 16 * std::size_t{terrain.columns()} * terrain.rows())) {}

Refined Lean::refine(const View& view, double error_px, std::uint32_t) {
    const bench::LeanRecursion::Frame frame = recursion_.refine(view, error_px, true);
    if (!frame.whole) throw std::runtime_error("lean: its strip is too short; ask for a larger threshold");
    return {frame.triangles, false};
}

void Lean::faces(std::vector<Face>& out) const {
    out.clear();
    const auto strip = recursion_.strip();
    const auto corner = [&](std::size_t i) -> Corner {
        const bench::LeanVertex& v = recursion_.vertex(strip[i]);
        return {std::round(v.x_m / spacing_x_m_), std::round(v.z_m / spacing_z_m_), v.y_m};
    };
    for (std::size_t i = 2; i < strip.size(); ++i) {
        if (strip[i] == strip[i - 1] || strip[i] == strip[i - 2] || strip[i - 1] == strip[i - 2]) continue;
        Face f{corner(i - 2), corner(i - 1), corner(i)};
        if (i % 2) std::swap(f[0], f[1]);
        out.push_back(f);
    }
}

std::size_t Lean::bytes() const {
    return recursion_.bytes() + 4 * recursion_.strip().size();
}

} // namespace fjell::rivals
