#include "gl/scatter.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include <epoxy/gl.h>

namespace fjell::gl {
namespace {

constexpr unsigned record_binding = 0, first_binding = 1, second_binding = 2;
constexpr std::uint32_t group = 128;

// Words, because a MeshVertex has three and std430 would pad a vec3 to four.
const char* const vertex_shader = R"(
layout(local_size_x = 128) in;
layout(std430, binding = 0) readonly buffer Records { uvec4 record[]; };
layout(std430, binding = 1) writeonly buffer Vertices { uint vertex_word[]; };
layout(std430, binding = 2) writeonly buffer Morph { uvec4 morph_vertex[]; };
layout(location = 0) uniform uint count;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    uvec4 vertex = record[2u * i];
    uint first = 3u * vertex.x;
    vertex_word[first] = vertex.y;
    vertex_word[first + 1u] = vertex.z;
    vertex_word[first + 2u] = vertex.w;
    morph_vertex[vertex.x] = record[2u * i + 1u];
}
)";

const char* const triangle_shader = R"(
layout(local_size_x = 128) in;
layout(std430, binding = 0) readonly buffer Records { uvec4 record[]; };
layout(std430, binding = 1) writeonly buffer Indices { uint index_word[]; };
layout(location = 0) uniform uint count;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    uvec4 triangle = record[i];
    uint first = 3u * triangle.x;
    index_word[first] = triangle.y;
    index_word[first + 1u] = triangle.z;
    index_word[first + 2u] = triangle.w;
}
)";

std::uint32_t written(std::span<const std::uint64_t> bits, std::span<const std::uint32_t> words) {
    int count = 0;
    for (const std::uint32_t word : words) count += std::popcount(bits[word]);
    return static_cast<std::uint32_t>(count);
}

// Fills slices of the ring with records, and has the shader spread each before the next is opened.
template <typename Record>
class Sender {
public:
    Sender(const Program& program, std::uint32_t lanes, Ring& ring, std::uint32_t count)
        : program_(program.get()), lanes_(lanes), ring_(ring), left_(count) {
        glUseProgram(program_);
    }
    void put(const Record& record) {
        if (filled_ == opened_) {
            send();
            open();
        }
        std::memcpy(slice_.data + std::size_t{filled_++} * sizeof(Record), &record, sizeof(Record));
    }
    void send() {
        if (filled_ == 0) return;
        glBindBufferRange(GL_SHADER_STORAGE_BUFFER, record_binding, ring_.buffer(),
                          static_cast<GLintptr>(slice_.offset),
                          static_cast<GLsizeiptr>(std::size_t{filled_} * sizeof(Record)));
        glProgramUniform1ui(program_, 0, filled_);
        glDispatchCompute((filled_ + group - 1) / group, 1, 1);
        filled_ = opened_ = 0;
    }

private:
    void open() {
        ring_.reserve(ring_.aligned(sizeof(Record)));
        opened_ =
            static_cast<std::uint32_t>(std::min<std::size_t>(std::min(left_, lanes_), ring_.room() / sizeof(Record)));
        left_ -= opened_;
        slice_ = ring_.take(std::size_t{opened_} * sizeof(Record));
    }

    unsigned program_;
    std::uint32_t lanes_;
    Ring& ring_;
    std::uint32_t left_, opened_ = 0, filled_ = 0;
    RingSlice slice_;
};

} // namespace

void Scatter::create() {
    vertices = make_compute_program("vertex slots", vertex_shader);
    triangles = make_compute_program("triangle slots", triangle_shader);
    int groups = 0;
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &groups);
    lanes = group * static_cast<std::uint32_t>(std::clamp(groups, 1, 1 << 16));
}

void rehearse_scatter(const Scatter& shaders, Ring& ring, const MeshBuffers& to) {
    constexpr std::size_t bytes = sizeof(VertexSlotRecord);
    ring.reserve(ring.aligned(bytes));
    const RingSlice slice = ring.take(bytes);
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, record_binding, ring.buffer(), static_cast<GLintptr>(slice.offset),
                      static_cast<GLsizeiptr>(bytes));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, first_binding, to.vertices.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, second_binding, to.morph.get());
    for (const Program* program : {&shaders.vertices, &shaders.triangles}) {
        glUseProgram(program->get());
        glProgramUniform1ui(program->get(), 0, 0); // of no records
        glDispatchCompute(1, 1, 1);
    }
}

std::uint64_t scatter(const Scatter& shaders, Ring& ring, const CutMesh& cut, const CutChanges& changes,
                      const MeshBuffers& to) {
    const std::uint32_t vertex_count = written(changes.vertex_bits, changes.vertex_words);
    const std::uint32_t triangle_count = written(changes.triangle_bits, changes.triangle_words);
    if (vertex_count + triangle_count == 0) return 0;
    // Stores wait for the draws that still fetch, and for stores of an upload before this one to the same slots.
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    Sender<VertexSlotRecord> vertices(shaders.vertices, shaders.lanes, ring, vertex_count);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, first_binding, to.vertices.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, second_binding, to.morph.get());
    for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t slot = first; slot < first + count; ++slot)
            vertices.put({slot, cut.mesh.vertices[slot], cut.morph.empty() ? MorphVertex{} : cut.morph[slot]});
    });
    vertices.send();
    Sender<TriangleSlotRecord> triangles(shaders.triangles, shaders.lanes, ring, triangle_count);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, first_binding, to.indices.get());
    for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t slot = first; slot < first + count; ++slot) {
            const std::uint32_t* index = &cut.mesh.indices[std::size_t{3} * slot];
            triangles.put({slot, {index[0], index[1], index[2]}});
        }
    });
    triangles.send();
    // Fetches by draws, and whole uploads, see what was stored.
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return vertex_count * sizeof(VertexSlotRecord) + triangle_count * sizeof(TriangleSlotRecord);
}

} // namespace fjell::gl
