#include "draw.h"

#include <math.h>
#include <string.h>

/* A vertex is a whole sample and a height. Samples from the scene's origin are small whole numbers, so that nothing is
   rounded before it is near the eye. From there on axes are the engine's: x north, y east, z up, which is left-handed,
   and its eyes look along +z. */
static const char vertex_shader[] =
    "#version 330\n"
    "layout(location = 0) in ivec2 at_sample;\n"
    "layout(location = 1) in float height_m;\n"
    "uniform ivec2 origin;\n"
    "uniform vec2 spacing_m;\n"
    "uniform vec3 eye_m;\n" /* from the origin */
    "uniform mat3 eye_from_engine;\n"
    "uniform vec4 projection;\n" /* of x and y; what of z becomes depth, and what is added */
    "uniform vec2 centre;\n"
    "uniform float depth_scale;\n" /* 2 where clip space reaches from -1 to 1 */
    "out vec3 from_eye_m;\n"
    "out float high_m;\n"
    "void main() {\n"
    "    vec2 ground = vec2(at_sample - origin) * spacing_m;\n" /* east and south */
    "    from_eye_m = vec3(-ground.y, ground.x, height_m) - eye_m;\n"
    "    high_m = height_m;\n"
    "    vec3 p = eye_from_engine * from_eye_m;\n"
    "    float depth = projection.w - projection.z * p.z;\n" /* reversed: the near plane is 1, the far plane 0 */
    "    gl_Position = vec4(p.xy * projection.xy - centre * p.z, depth_scale * depth - (depth_scale - 1.0) * p.z, "
    "p.z);\n"
    "}\n";

static const char fragment_shader[] =
    "#version 330\n"
    "in vec3 from_eye_m;\n"
    "in float high_m;\n"
    "out vec4 colour;\n"
    "void main() {\n"
    "    vec3 normal = normalize(cross(dFdx(from_eye_m), dFdy(from_eye_m)));\n"
    "    if (normal.z < 0.0) normal = -normal;\n"
    "    vec3 meadow = vec3(0.24, 0.33, 0.14), rock = vec3(0.38, 0.34, 0.30), snow = vec3(0.92);\n"
    "    vec3 ground = mix(meadow, snow, smoothstep(1100.0, 1900.0, high_m));\n"
    "    ground = mix(rock, ground, smoothstep(0.70, 0.88, normal.z));\n"
    "    float sun = max(dot(normal, normalize(vec3(0.5, -0.5, 0.6))), 0.0);\n"
    "    float haze = 1.0 - exp(-length(from_eye_m) / 30000.0);\n"
    "    colour = vec4(mix(ground * (0.25 + sun), vec3(0.62, 0.72, 0.84), haze), 1.0);\n"
    "}\n";

static GLuint compile(GLenum stage, const char* source) {
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &source, NULL);
    glCompileShader(shader);
    return shader;
}

const char* renderer_create(Renderer* renderer, const FjellCutBudget* budget) {
    memset(renderer, 0, sizeof *renderer);
    const GLuint shaders[2] = {compile(GL_VERTEX_SHADER, vertex_shader), compile(GL_FRAGMENT_SHADER, fragment_shader)};
    renderer->program = glCreateProgram();
    for (int i = 0; i < 2; ++i) {
        glAttachShader(renderer->program, shaders[i]);
        glDeleteShader(shaders[i]); /* with the program */
    }
    glLinkProgram(renderer->program);
    GLint linked = 0;
    glGetProgramiv(renderer->program, GL_LINK_STATUS, &linked);
    if (!linked) return "the shaders do not link: update the graphics driver";

    /* As many slots as the budget has: they stay where they are, so the buffers never grow. */
    glGenVertexArrays(1, &renderer->format);
    glBindVertexArray(renderer->format);
    glGenBuffers(1, &renderer->vertices);
    glBindBuffer(GL_ARRAY_BUFFER, renderer->vertices);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(budget->vertices * sizeof(FjellMeshVertex)), NULL, GL_DYNAMIC_DRAW);
    glVertexAttribIPointer(0, 2, GL_INT, sizeof(FjellMeshVertex), (void*)offsetof(FjellMeshVertex, column));
    glVertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, sizeof(FjellMeshVertex),
                          (void*)offsetof(FjellMeshVertex, height_m));
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    glGenBuffers(1, &renderer->indices);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, renderer->indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(budget->triangles * 3 * sizeof(uint32_t)), NULL,
                 GL_DYNAMIC_DRAW);
    glBindVertexArray(0);
    return glGetError() == GL_NO_ERROR ? NULL : "the buffers do not fit the graphics memory: lower the cut's budget";
}

void renderer_destroy(Renderer* renderer) {
    glDeleteBuffers(1, &renderer->vertices);
    glDeleteBuffers(1, &renderer->indices);
    glDeleteVertexArrays(1, &renderer->format);
    glDeleteProgram(renderer->program);
}

void renderer_upload(Renderer* renderer, const FjellCutMesh* cut, const FjellCutChanges* changes) {
    glBindVertexArray(renderer->format);
    glBindBuffer(GL_ARRAY_BUFFER, renderer->vertices);
    FjellRun run = {0};
    while (fjell_next_run(changes->vertex_bits, changes->vertex_words, changes->vertex_word_count, &run)) {
        const size_t bytes = run.count * sizeof(FjellMeshVertex);
        glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)(run.first * sizeof(FjellMeshVertex)), (GLsizeiptr)bytes,
                        cut->mesh.vertices + run.first);
        renderer->uploaded_bytes += bytes;
    }
    const size_t triangle_bytes = 3 * sizeof(uint32_t);
    memset(&run, 0, sizeof run);
    while (fjell_next_run(changes->triangle_bits, changes->triangle_words, changes->triangle_word_count, &run)) {
        const size_t bytes = run.count * triangle_bytes;
        glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, (GLintptr)(run.first * triangle_bytes), (GLsizeiptr)bytes,
                        cut->mesh.indices + (size_t)3 * run.first);
        renderer->uploaded_bytes += bytes;
    }
    glBindVertexArray(0);
}

/* Reversed depth: 1 at the near plane, 0 far away, where floats are finest. OpenGL 3.3 has it with an extension that
   drivers of the last ten years bring; without it depth is still right, but coarser far away. */
static float set_depth(void) {
    static int has_clip_control = -1;
    if (has_clip_control < 0) has_clip_control = epoxy_has_gl_extension("GL_ARB_clip_control");
    if (has_clip_control) glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    return has_clip_control ? 1.0f : 2.0f;
}

/* Fjell's x east, y up, z south. */
static void set_row(float* row, FjellVec3 scene) {
    row[0] = (float)-scene.z;
    row[1] = (float)scene.x;
    row[2] = (float)scene.y;
}

static void set_view(const Renderer* renderer, FjellTerrain terrain, const FjellView* view, FjellSampleIndex origin) {
    const FjellPackHeader* const header = fjell_terrain_header(terrain);
    const double dx = header->spacing_m[0], dz = header->spacing_m[1];
    const double eye_x = view->eye_m.x - origin.column * dx,
                 eye_z = view->eye_m.z - origin.row * dz; /* doubles until here */
    const FjellVec3 f = view->forward, u = view->up;
    const FjellVec3 r = {f.y * u.z - f.z * u.y, f.z * u.x - f.x * u.z, f.x * u.y - f.y * u.x}; /* to the right */
    float rows[9];
    set_row(rows, r);
    set_row(rows + 3, u);
    set_row(rows + 6, f); /* ahead is +z */
    const double wide = view->right - view->left, high = view->top - view->bottom, range = view->far_m - view->near_m;
    const GLuint p = renderer->program;
    glUniform2i(glGetUniformLocation(p, "origin"), origin.column, origin.row);
    glUniform2f(glGetUniformLocation(p, "spacing_m"), (float)dx, (float)dz);
    glUniform3f(glGetUniformLocation(p, "eye_m"), (float)-eye_z, (float)eye_x, (float)view->eye_m.y);
    glUniformMatrix3fv(glGetUniformLocation(p, "eye_from_engine"), 1, GL_TRUE, rows);
    glUniform4f(glGetUniformLocation(p, "projection"), (float)(2 / wide), (float)(2 / high),
                (float)(view->near_m / range), (float)(view->near_m * view->far_m / range));
    glUniform2f(glGetUniformLocation(p, "centre"), (float)((view->right + view->left) / wide),
                (float)((view->top + view->bottom) / high));
    glUniform1f(glGetUniformLocation(p, "depth_scale"), set_depth());
}

void renderer_draw(const Renderer* renderer, FjellTerrain terrain, const FjellCutMesh* cut, const FjellView* view,
                   FjellSampleIndex origin) {
    glUseProgram(renderer->program);
    set_view(renderer, terrain, view, origin);
    glBindVertexArray(renderer->format);
    glEnable(GL_CULL_FACE); /* ground is counter-clockwise from above on the screen, whatever axes lead there */
    glFrontFace(GL_CCW);
    for (size_t i = 0; i < cut->mesh.tile_count; ++i) { /* of tiles that the view may see */
        const FjellTileRange* range = cut->mesh.tiles + i;
        glDrawElements(GL_TRIANGLES, (GLsizei)range->index_count, GL_UNSIGNED_INT,
                       (void*)(range->first_index * sizeof(uint32_t)));
    }
    glDisable(GL_CULL_FACE);
    glBindVertexArray(0);
}
