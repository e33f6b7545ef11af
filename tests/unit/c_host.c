/* C99, with warnings as errors: tests/CMakeLists.txt. */
#include "unit/c_host.h"

#include <string.h>

static int fail(Flown* flown, FjellStatus status) {
    flown->failure = status;
    return 1;
}

static void upload_vertices(Flown* flown, const FjellMeshVertex* first, uint32_t count) {
    flown->uploaded_vertices += first == NULL ? 0 : count;
}
static void upload_triangles(Flown* flown, const uint32_t* first, uint32_t count) {
    flown->uploaded_triangles += first == NULL ? 0 : count;
}
static void draw(Flown* flown, const FjellTileRange* range, const uint32_t* indices) {
    flown->drawn += indices == NULL ? 0 : range->triangles;
}

static FjellStatus next_view(int frame, FjellView* view) {
    const FjellVec3 eye_m = {100 + 5 * frame, 800, 100}, forward = {1, -1, 0.5}, up = {0, 1, 0};
    view->struct_size = sizeof *view;
    return fjell_make_view(eye_m, forward, up, 1, 1280, 720, 1, 1e5, view);
}

static FjellStatus look_around(FjellTerrain terrain, FjellLiveCut cut, Allocator* allocator, Flown* flown) {
    flown->bound_px = fjell_bound_cut_error_px(cut, &flown->view, false, 1);
    flown->ground = fjell_ground_height(terrain, 300.5, 400.25, 0);
    flown->hit = fjell_cast_ray(terrain, flown->view.eye_m, flown->view.forward, 1e5, 0);
    const FjellSampleIndex first = {-3, 5};
    flown->patch_error_m = fjell_ground_patch(terrain, first, 0, 33, flown->heights_m, 33 * 33, NULL, 0).error_m;

    FjellRecursiveBudget budget = fjell_recursive_budget_default();
    budget.vertices = 20000;
    const size_t bytes = fjell_recursive_bytes(terrain, &budget);
    FjellRecursiveMethod method = {0};
    FjellStatus s = fjell_create_recursive(terrain, &budget, allocator->allocate(allocator, bytes), bytes, &method);
    if (s.code != FJELL_OK) return s;
    FjellFrameReport report = {.struct_size = sizeof report};
    s = fjell_update_recursive(method, &flown->view, NULL, &report);
    if (s.code != FJELL_OK) return s;
    const FjellMeshView mesh = fjell_recursive_mesh(method);
    for (size_t i = 0; i < mesh.tile_count; ++i) flown->recursive_triangles += mesh.tiles[i].triangles;
    return fjell_destroy_recursive(method);
}

int c_host_fly(const void* file, size_t file_bytes, Allocator* allocator, Flown* flown) {
    memset(flown, 0, sizeof *flown);
    FjellPack pack; /* `file`: the pack's bytes, read or mapped by you */
    FjellStatus s = fjell_open_pack(file, file_bytes, &pack);
    if (s.code != FJELL_OK) return fail(flown, s); /* s.field, fjell_message(s.code) */
    const size_t ground = fjell_terrain_bytes(&pack.header, NULL);
    FjellTerrain terrain = {0}; /* your memory, aligned to 64 bytes; the library allocates nothing itself */
    s = fjell_load_terrain(&pack, allocator->allocate(allocator, ground), ground, &terrain);
    if (s.code != FJELL_OK) return fail(flown, s);
    FjellCutBudget budget = fjell_cut_budget_default();
    budget.vertices = 40000;
    budget.triangles = 80000;
    const size_t mesh_bytes = fjell_cut_bytes(terrain, &budget);
    FjellLiveCut cut = {0};
    s = fjell_create_cut(terrain, &budget, allocator->allocate(allocator, mesh_bytes), mesh_bytes, &cut);
    if (s.code != FJELL_OK) return fail(flown, s);
    FjellCutSettings settings = fjell_cut_settings_default();
    settings.max_error_px = 1;
    settings.max_work = 5000;
    FjellCutReport report = {.struct_size = sizeof report};
    for (int frame = 0; frame < 4; ++frame) {
        s = next_view(frame, &flown->view);
        if (s.code == FJELL_OK) s = fjell_update_cut(cut, &flown->view, 1, &settings, &report);
        if (s.code != FJELL_OK) return fail(flown, s);
        const FjellMeshView mesh = fjell_cut_mesh(cut).mesh;
        const FjellCutChanges changes = fjell_cut_take_changes(cut); /* written since the last call */
        FjellRun run = {0};
        while (fjell_next_run(changes.vertex_bits, changes.vertex_words, changes.vertex_word_count, &run))
            upload_vertices(flown, mesh.vertices + run.first, run.count);
        FjellRun triangles = {0};
        while (fjell_next_run(changes.triangle_bits, changes.triangle_words, changes.triangle_word_count, &triangles))
            upload_triangles(flown, mesh.indices + 3 * (size_t)triangles.first, triangles.count);
        for (size_t i = 0; i < mesh.tile_count; ++i) draw(flown, &mesh.tiles[i], mesh.indices);
    }
    flown->report = report;
    s = look_around(terrain, cut, allocator, flown);
    if (s.code == FJELL_OK) s = fjell_destroy_cut(cut);
    if (s.code == FJELL_OK) s = fjell_destroy_terrain(terrain);
    return s.code == FJELL_OK ? 0 : fail(flown, s);
}

/* The client of a stream: on a thread of its own in an engine, from a file. */
static void serve(FjellStream stream, const unsigned char* file) {
    FjellStreamRequest request;
    while (fjell_stream_next_request(stream, &request)) {
        if (fjell_stream_still_wanted(stream, request.ticket))
            (void)fjell_stream_provide(stream, request.ticket, file + request.offset, request.bytes);
        else /* the camera has moved on */
            (void)fjell_stream_fail(stream, request.ticket, true);
    }
}

/* From the header, the directory and the corners alone: the rest is read when it is wanted. */
static FjellStatus open_streamed(const unsigned char* file, size_t file_bytes, Allocator* allocator, FjellPack* pack,
                                 FjellTerrain* terrain) {
    FjellPackHeader header;
    FjellStatus s = fjell_read_header(file, sizeof header, file_bytes, &header);
    if (s.code != FJELL_OK) return s;
    s = fjell_open_index(file, sizeof header, file + header.directory_offset,
                         header.directory_count * sizeof(FjellChunkEntry), file_bytes, pack);
    if (s.code != FJELL_OK) return s;
    const FjellChunkId id = {FJELL_CHUNK_CORNERS, 0, 0};
    const FjellChunkEntry corners = fjell_pack_entry(pack, fjell_chunk_index(&header, id));
    const size_t bytes = fjell_terrain_bytes(&header, NULL);
    return fjell_create_terrain(pack, file + corners.offset, corners.stored_bytes, NULL,
                                allocator->allocate(allocator, bytes), bytes, terrain);
}

int c_host_stream(const void* file, size_t file_bytes, Allocator* allocator, Flown* flown) {
    memset(flown, 0, sizeof *flown);
    FjellPack pack;
    FjellTerrain terrain = {0};
    FjellStatus s = open_streamed(file, file_bytes, allocator, &pack, &terrain);
    if (s.code != FJELL_OK) return fail(flown, s);
    FjellCutBudget budget = fjell_cut_budget_default();
    budget.vertices = 40000;
    budget.triangles = 80000;
    const size_t mesh_bytes = fjell_cut_bytes(terrain, &budget);
    FjellLiveCut cut = {0};
    s = fjell_create_cut(terrain, &budget, allocator->allocate(allocator, mesh_bytes), mesh_bytes, &cut);
    if (s.code != FJELL_OK) return fail(flown, s);
    FjellStreamBudget streaming = fjell_stream_budget_default();
    streaming.map_bytes = 1 << 20;
    const size_t stream_bytes = fjell_stream_bytes(&pack, terrain, &streaming);
    FjellStream stream = {0};
    s = fjell_create_stream(&pack, terrain, cut, &streaming, allocator->allocate(allocator, stream_bytes), stream_bytes,
                            &stream);
    if (s.code != FJELL_OK) return fail(flown, s);

    FjellStreamSettings settings = fjell_stream_settings_default();
    FjellStreamReport streamed = {.struct_size = sizeof streamed};
    FjellCutReport report = {.struct_size = sizeof report};
    for (int frame = 0; frame < 1000 && !(streamed.converged && report.converged); ++frame) {
        s = next_view(3, &flown->view);
        settings.now_s = frame / 60.0;
        if (s.code == FJELL_OK) s = fjell_update_stream(stream, &flown->view, 1, NULL, &settings, &streamed);
        size_t count = 0;
        const FjellStreamFailure* const failures = fjell_stream_failures(stream, &count);
        if (count != 0) return fail(flown, (FjellStatus){failures[0].code, "tile"}); /* coarser there from now on */
        if (s.code == FJELL_OK) s = fjell_update_cut(cut, &flown->view, 1, NULL, &report);
        if (s.code != FJELL_OK) return fail(flown, s);
        serve(stream, file);
    }
    flown->report = report;
    flown->streamed = streamed;
    flown->ground = fjell_ground_height(terrain, 300.5, 400.25, 0);
    s = fjell_destroy_stream(stream); /* the client has stopped */
    if (s.code == FJELL_OK) s = fjell_destroy_cut(cut);
    if (s.code == FJELL_OK) s = fjell_destroy_terrain(terrain);
    return s.code == FJELL_OK ? 0 : fail(flown, s);
}
