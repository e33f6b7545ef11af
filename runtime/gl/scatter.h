// Brings the slots of a live cut that were written to the GPU: as records in the ring, which a compute shader puts in
// their places.
//
// The slots lie anywhere, in hundreds of short runs. A call a run costs a microsecond or more each; here the calls are
// the same few whatever the runs, and the GPU's own order keeps the former picture whole: the shader runs after the
// draws before it and before those after it, so nothing waits. Internal to runtime/gl. Failure: create() throws.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/cut.h"
#include "gl/objects.h"

namespace fjell::gl {

struct VertexSlotRecord {
    std::uint32_t slot;
    MeshVertex vertex;
    MorphVertex morph;
};
static_assert(sizeof(VertexSlotRecord) == 32, "VertexSlotRecord is uploaded: change the shader in scatter.cpp with it");

struct TriangleSlotRecord {
    std::uint32_t slot, index[3];
};
static_assert(sizeof(TriangleSlotRecord) == 16,
              "TriangleSlotRecord is uploaded: change the shader in scatter.cpp with it");

struct Scatter {
    Program vertices, triangles;
    std::uint32_t lanes = 0; // records that one dispatch may have

    void create();
};

// The GPU's buffers of a mesh.
struct MeshBuffers {
    Buffer vertices, morph, indices;
};

// Has the driver compile both shaders: dispatches that write nothing.
void rehearse_scatter(const Scatter& shaders, Ring& ring, const MeshBuffers& to);

// Uploads the written slots; returns the bytes of their records. Pieces that outgrow a region of the ring go on in the
// next one. Draws given before see the old mesh, draws given after it the new one.
std::uint64_t scatter(const Scatter& shaders, Ring& ring, const CutMesh& cut, const CutChanges& changes,
                      const MeshBuffers& to);

} // namespace fjell::gl
