/* A game loop in C99: a window, a pack in memory, a cut, and a renderer of its own (draw.c). It shows the tier for
   engines with memory of their own; a host that wants all in one object is content/hosts/first/fly.c.
     c_loop PACK                                 flies over it until the window is closed
     c_loop PACK PICTURE.ppm FRAMES [VERTICES]   flies so many frames without showing them, and writes the last one
     c_loop PACK --times VIEWS                   prints what a frame costs (content/hosts/times) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "../times/times.h"
#include "draw.h"

enum { width_px = 640, height_px = 360 };

static int fail(const char* what, const char* why) {
    fprintf(stderr, "c_loop: %s: %s\n", what, why);
    return 1;
}
static int refused(FjellStatus status) {
    return fail(status.field, fjell_message(status.code)); /* what is at fault, and what to do about it */
}

/* --- what the host owns --- */

typedef struct World {
    void* file; /* the pack lies in it */
    size_t file_bytes;
    void *terrain_memory, *cut_memory;
    FjellPack pack;
    FjellTerrain terrain;
    FjellCutBudget budget;
    FjellLiveCut cut;
} World;

/* The library takes memory in pieces that are aligned to 64 bytes, and allocates none itself. */
static void* aligned(void* piece) {
    return (char*)piece + (64 - (uintptr_t)piece % 64) % 64;
}

static int read_file(World* world, const char* path) {
    FILE* const file = fopen(path, "rb");
    if (file == NULL) return fail(path, "cannot be opened; give a pack that fjell-bake has written");
    long bytes = -1;
    if (fseek(file, 0, SEEK_END) == 0) bytes = ftell(file);
    rewind(file);
    world->file_bytes = bytes < 0 ? 0 : (size_t)bytes;
    world->file = malloc(world->file_bytes + 1);
    const int good =
        bytes >= 0 && world->file != NULL && fread(world->file, 1, world->file_bytes, file) == world->file_bytes;
    fclose(file);
    return good ? 0 : fail(path, "cannot be read; check the disk");
}

static int create(World* world, const char* path, uint32_t vertices) {
    if (read_file(world, path) != 0) return 1;
    FjellStatus status = fjell_open_pack(world->file, world->file_bytes, &world->pack);
    if (status.code != FJELL_OK) return refused(status);

    const size_t terrain_bytes = fjell_terrain_bytes(&world->pack.header, NULL); /* NULL: the defaults */
    world->terrain_memory = malloc(terrain_bytes + 63);
    if (world->terrain_memory == NULL) return fail("memory", "the terrain does not fit; stream it");
    status = fjell_load_terrain(&world->pack, aligned(world->terrain_memory), terrain_bytes, &world->terrain);
    if (status.code != FJELL_OK) return refused(status);

    world->budget = fjell_cut_budget_default();
    world->budget.vertices = vertices;
    world->budget.triangles = 2 * vertices;
    const size_t cut_bytes = fjell_cut_bytes(world->terrain, &world->budget);
    world->cut_memory = malloc(cut_bytes + 63);
    if (world->cut_memory == NULL) return fail("memory", "the cut does not fit; lower its budget");
    status = fjell_create_cut(world->terrain, &world->budget, aligned(world->cut_memory), cut_bytes, &world->cut);
    return status.code == FJELL_OK ? 0 : refused(status);
}

static void destroy(World* world) { /* what uses the other goes first; a handle that is still {0} is refused */
    (void)fjell_destroy_cut(world->cut);
    (void)fjell_destroy_terrain(world->terrain);
    free(world->cut_memory);
    free(world->terrain_memory);
    free(world->file);
}

/* --- the camera --- */

/* This engine's axes: x north, y east, z up, which is left-handed. Fjell's: x east, y up, z south, right-handed. As
   both draw the same picture and not its mirror image, triangles keep their winding on the screen. */
static FjellVec3 from_engine(double north, double east, double up) {
    const FjellVec3 v = {east, up, -north};
    return v;
}

/* 20 cells a second to the south-east, 250 m above the ground. */
static FjellStatus look(const World* world, double now_s, FjellView* view) {
    const double speed_m = 20 * fjell_terrain_spacing_x_m(world->terrain);
    const double x = -fjell_terrain_extent_z_m(world->terrain) / 3 - speed_m * now_s / 2;
    const double y = fjell_terrain_extent_x_m(world->terrain) / 3 + speed_m * now_s;
    const FjellVec3 below = from_engine(x, y, 0);
    const double z = fjell_ground_height(world->terrain, below.x, below.z, 0).height_m + 250;
    view->struct_size = sizeof *view;
    return fjell_make_view(from_engine(x, y, z), from_engine(-0.5, 1, -0.15), from_engine(0, 0, 1), 1.0, width_px,
                           height_px, 1, 1e6, view);
}

/* The scene's origin is a sample near the eye. An engine counts its objects, physics and sound from there in floats,
   and moves them when it moves. Returns whether it has. */
static int rebase(const World* world, const FjellView* view, FjellSampleIndex* origin) {
    const FjellPackHeader* const header = fjell_terrain_header(world->terrain);
    const double dx = header->spacing_m[0], dz = header->spacing_m[1];
    const double far_m = 1000;
    if (fabs(view->eye_m.x - origin->column * dx) < far_m && fabs(view->eye_m.z - origin->row * dz) < far_m) return 0;
    origin->column = (int32_t)floor(view->eye_m.x / dx);
    origin->row = (int32_t)floor(view->eye_m.z / dz);
    return 1;
}

/* --- the picture --- */

/* Drawn into a framebuffer of our own, because a window's has no depth in floats. */
static GLuint create_target(void) {
    GLuint target = 0, parts[2];
    glGenFramebuffers(1, &target);
    glGenRenderbuffers(2, parts);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glBindRenderbuffer(GL_RENDERBUFFER, parts[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width_px, height_px);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, parts[0]);
    glBindRenderbuffer(GL_RENDERBUFFER, parts[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, width_px, height_px);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, parts[1]);
    return target;
}

static void draw(const World* world, const Renderer* renderer, const FjellCutMesh* mesh, const FjellView* view,
                 FjellSampleIndex origin) {
    glViewport(0, 0, width_px, height_px);
    glClearColor(0.62f, 0.72f, 0.84f, 1);
    glClearDepth(0); /* far away */
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    renderer_draw(renderer, world->terrain, mesh, view, origin);
}

static void show(GLFWwindow* window, GLuint target) {
    int width, height;
    glfwGetFramebufferSize(window, &width, &height);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, width_px, height_px, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glfwSwapBuffers(window);
    glfwPollEvents();
}

static int write_picture(const char* path) {
    static unsigned char rgb[height_px][width_px][3];
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width_px, height_px, GL_RGB, GL_UNSIGNED_BYTE, rgb);
    FILE* const file = fopen(path, "wb");
    if (file == NULL) return fail(path, "cannot be written");
    fprintf(file, "P6\n%d %d\n255\n", width_px, height_px);
    for (int row = height_px - 1; row >= 0; --row)
        fwrite(rgb[row], sizeof rgb[row], 1, file); /* OpenGL's first is the lowest */
    return fclose(file) == 0 ? 0 : fail(path, "cannot be written");
}

/* --- the loop --- */

static int play(World* world, GLFWwindow* window, const char* picture, int frames) {
    Renderer renderer;
    const char* const error = renderer_create(&renderer, &world->budget);
    if (error != NULL) return fail("graphics", error);
    const GLuint target = create_target();
    FjellCutSettings settings = fjell_cut_settings_default();
    settings.max_error_px = 2;
    settings.max_work = 20000;
    FjellCutReport report = {.struct_size = sizeof report};
    FjellView view;
    FjellSampleIndex origin = {0, 0};
    int rebased = 0;
    for (int frame = 0; picture == NULL ? !glfwWindowShouldClose(window) : frame < frames; ++frame) {
        FjellStatus status = look(world, picture == NULL ? glfwGetTime() : frame / 60.0, &view);
        if (status.code ==
            FJELL_OK) /* every frame: no allocation, no lock, no system call; the first one from nothing */
            status = (frame == 0 ? fjell_rebuild_cut : fjell_update_cut)(world->cut, &view, 1, &settings, &report);
        if (status.code != FJELL_OK) return refused(status);
        rebased += rebase(world, &view, &origin);
        const FjellCutMesh mesh = fjell_cut_mesh(world->cut);
        const FjellCutChanges changes = fjell_cut_take_changes(world->cut);
        renderer_upload(&renderer, &mesh, &changes);
        if (picture == NULL || frame == frames - 1) draw(world, &renderer, &mesh, &view, origin);
        if (picture == NULL) show(window, target);
    }
    for (uint32_t bit = 1; bit <= report.exhausted; bit <<= 1)
        if (report.exhausted & bit) fprintf(stderr, "c_loop: raise %s\n", fjell_cut_budget_field(bit));
    printf("eye %.17g,%.17g,%.17g\n", view.eye_m.x, view.eye_m.y, view.eye_m.z);
    printf("converged %d: %u triangles, %u drawn; %zu bytes uploaded, rebased %d times\n", report.converged,
           report.triangles, report.triangles_drawn, renderer.uploaded_bytes, rebased);
    const int code = picture == NULL ? 0 : write_picture(picture);
    renderer_destroy(&renderer);
    return code;
}

static double us_since(double* then_s) {
    const double before_s = *then_s;
    *then_s = glfwGetTime();
    return (*then_s - before_s) * 1e6;
}

static int measure(World* world, Times* times) {
    Renderer renderer;
    const char* const error = renderer_create(&renderer, &world->budget);
    if (error != NULL) return fail("graphics", error);
    (void)create_target();
    FjellCutSettings settings = fjell_cut_settings_default();
    settings.max_error_px = TIMES_ERROR_PX;
    FjellCutReport report = {.struct_size = sizeof report};
    FjellView view = {.struct_size = sizeof view};
    FjellSampleIndex origin = {0, 0};
    for (unsigned frame = 0; frame < 2 * times->frames; ++frame) {
        const double* const v = times->view + (size_t)9 * (frame % times->frames);
        const FjellVec3 eye_m = {v[0], v[1], v[2]}, ahead = {v[3], v[4], v[5]}, up = {v[6], v[7], v[8]};
        FjellStatus status = fjell_make_view(eye_m, ahead, up, times->fov_y_rad, times->width_px, times->height_px,
                                             TIMES_NEAR_M, TIMES_FAR_M, &view);
        double us[times_parts], then_s = glfwGetTime();
        if (status.code == FJELL_OK)
            status = (frame == 0 ? fjell_rebuild_cut : fjell_update_cut)(world->cut, &view, 1, &settings, &report);
        if (status.code != FJELL_OK) return refused(status);
        us[times_update] = us_since(&then_s);
        (void)rebase(world, &view, &origin);
        const FjellCutMesh mesh = fjell_cut_mesh(world->cut);
        const FjellCutChanges changes = fjell_cut_take_changes(world->cut);
        renderer_upload(&renderer, &mesh, &changes);
        us[times_upload] = us_since(&then_s);
        draw(world, &renderer, &mesh, &view, origin);
        us[times_draw] = us_since(&then_s);
        glFinish();
        us[times_finish] = us_since(&then_s);
        for (int part = 0; frame >= times->frames && part < times_parts; ++part) times_add(times, part, us[part]);
        glfwWaitEventsTimeout(0.001); /* where a game waits for the display */
    }
    const char* const parts[] = {"update", "upload", "draw", "finish"};
    times_print(times, report.vertices, parts);
    renderer_destroy(&renderer);
    return 0;
}

int main(int argc, char** argv) {
    if (argc != 2 && argc != 4 && argc != 5) return fail("usage", "c_loop PACK [PICTURE.ppm FRAMES [VERTICES]]"), 2;
    const char* const picture = argc > 2 ? argv[2] : NULL;
    const int measured = argc == 4 && strcmp(picture, "--times") == 0;
    World world = {0};
    Times times = {0};
    const char* const error = measured ? times_read(&times, argv[3]) : NULL;
    int code =
        error != NULL ? fail(argv[3], error) : create(&world, argv[1], argc > 4 ? (uint32_t)atoi(argv[4]) : 200000);
    if (code == 0 && !glfwInit()) code = fail("graphics", "there is no display");
    if (code == 0) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_VISIBLE, picture == NULL);
        GLFWwindow* const window = glfwCreateWindow(width_px, height_px, "c_loop", NULL, NULL);
        if (window == NULL) {
            code = fail("graphics", "there is no OpenGL 3.3");
        } else {
            glfwMakeContextCurrent(window);
            code =
                measured ? measure(&world, &times) : play(&world, window, picture, picture == NULL ? 0 : atoi(argv[3]));
        }
        glfwTerminate();
    }
    destroy(&world);
    times_end(&times);
    return code;
}
