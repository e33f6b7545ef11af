#include <utility>

#include <epoxy/gl.h>

#include "gl/state.h"

namespace fjell::gl {
namespace {

void write_buffer(const Buffer& buffer, std::size_t first, std::size_t bytes, const void* data) {
    if (bytes != 0)
        glNamedBufferSubData(buffer.get(), static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes), data);
}

} // namespace

// What is uploaded after a draw belongs to the next one: counters start anew and the ring moves on.
void Renderer::State::begin_frame() {
    if (!std::exchange(drawn, false)) return;
    stats.bytes_uploaded = stats.map_bytes_uploaded = 0;
    stats.upload_us = 0;
    ring.next();
}

// Whether this mesh must be uploaded whole.
bool Renderer::State::begin_upload(const MeshView& view) {
    const bool whole = uploaded != view.vertices.data() || uploaded_count != view.vertices.size();
    uploaded = view.vertices.data();
    uploaded_count = view.vertices.size();
    return whole;
}

void Renderer::State::upload_indices(const MeshView& view) {
    if (kept_indices != nullptr && kept_indices == view.indices.data()) return;
    const Stopwatch watch(stats.upload_us);
    kept_indices = nullptr;
    glInvalidateBufferData(mesh.indices.get()); // the last picture may still be reading the old ones
    write_buffer(mesh.indices, 0, view.indices.size_bytes(), view.indices.data());
    stats.bytes_uploaded += view.indices.size_bytes();
}

void Renderer::invalidate() {
    state_->uploaded = nullptr;
    state_->kept_indices = nullptr;
}

std::string Renderer::upload(const MeshView& mesh) {
    State& s = *state_;
    s.morph_frame = {};
    if (mesh.vertices.size() > s.options.vertices || mesh.dirty_end > mesh.vertices.size() ||
        mesh.dirty_begin > mesh.dirty_end)
        return "the mesh has more vertex slots than RendererOptions::vertices, or its dirty range lies outside them";
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    const bool whole = s.begin_upload(mesh);
    s.kept_indices = nullptr;
    const std::size_t begin = whole ? 0 : mesh.dirty_begin, end = whole ? mesh.vertices.size() : mesh.dirty_end;
    write_buffer(s.mesh.vertices, begin * sizeof(MeshVertex), (end - begin) * sizeof(MeshVertex),
                 mesh.vertices.data() + begin);
    s.stats.bytes_uploaded += (end - begin) * sizeof(MeshVertex);
    return {};
}

std::string Renderer::upload(const CutMesh& cut, const CutChanges& changes) {
    State& s = *state_;
    const MeshView& mesh = cut.mesh;
    if (!s.options.morph) return "a live cut needs RendererOptions::morph";
    if (mesh.vertices.size() > s.options.vertices || mesh.indices.size() > s.options.indices)
        return "the cut has more slots than RendererOptions::vertices or ::indices: give them the cut's budget";
    if (cut.morph.size() != mesh.vertices.size())
        return "the cut's morph vertices are not one for one with its vertices";
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    s.morph_frame = cut.frame;
    const bool other_indices = std::exchange(s.kept_indices, mesh.indices.data()) != mesh.indices.data();
    if (s.begin_upload(mesh) || other_indices) { // three calls; the driver keeps its own copy
        write_buffer(s.mesh.vertices, 0, mesh.vertices.size_bytes(), mesh.vertices.data());
        write_buffer(s.mesh.morph, 0, cut.morph.size_bytes(), cut.morph.data());
        write_buffer(s.mesh.indices, 0, mesh.indices.size_bytes(), mesh.indices.data());
        s.stats.bytes_uploaded += mesh.vertices.size_bytes() + cut.morph.size_bytes() + mesh.indices.size_bytes();
    } else {
        s.stats.bytes_uploaded += scatter(s.scatter, s.ring, cut, changes, s.mesh);
    }
    s.stats.ring_waits = s.ring.waits();
    return {};
}

std::string Renderer::upload(std::span<const MapCommand> commands) {
    State& s = *state_;
    if (commands.empty()) return {};
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    std::string error = run_commands(commands, s.maps, s.ring, s.stats.map_bytes_uploaded);
    s.stats.ring_waits = s.ring.waits();
    return error;
}

std::string Renderer::show_maps(std::span<const TileMap> colour, std::span<const TileMap> normal,
                                std::span<const TileMap> horizon, std::span<const TileMap> control) {
    Maps& maps = state_->maps;
    for (const auto& [tiles, kind] : {std::pair(colour, MapKind::colour), std::pair(normal, MapKind::normal),
                                      std::pair(horizon, MapKind::horizon), std::pair(control, MapKind::control)})
        if (std::string error = gl::show_maps(tiles, kind, maps); !error.empty()) return error;
    return {};
}

} // namespace fjell::gl
