/* The host's own renderer, OpenGL 3.3: a cut's two buffers on the GPU, edited where they have changed, and a draw call
   a range. Of the context that is current. */
#ifndef C_LOOP_DRAW_H
#define C_LOOP_DRAW_H

#include <epoxy/gl.h>
#include <fjell/fjell_c.h>

typedef struct Renderer {
    GLuint program, format, vertices, indices;
    size_t uploaded_bytes; /* by all uploads so far */
} Renderer;

/* NULL, or one line that says what is wrong. */
const char* renderer_create(Renderer* renderer, const FjellCutBudget* budget);
void renderer_destroy(Renderer* renderer);
/* changes: what was written since the last upload. */
void renderer_upload(Renderer* renderer, const FjellCutMesh* cut, const FjellCutChanges* changes);
/* Into the current framebuffer and viewport. Depth is reversed: cleared to 0, and best in floats. The origin is that of
   the host's scene: everything on the GPU is counted from there. */
void renderer_draw(const Renderer* renderer, FjellTerrain terrain, const FjellCutMesh* cut, const FjellView* view,
                   FjellSampleIndex origin);

#endif
