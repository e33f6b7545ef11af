/* The same in C99, for an engine that draws by itself: what a frame gives it.   fly PACK PROFILE.toml */
#include <stdio.h>

#include <fjell/live_c.h>

static int fail(const char* why) {
    fprintf(stderr, "fly: %s\n", why);
    return 1;
}

int main(int argc, char** argv) {
    char why[512];
    if (argc != 3) return fail("usage: fly PACK PROFILE.toml"), 2;
    const FjellProfileKey coarser = {"refine.max_error_px", "2"}; /* over what the profile says */
    const FjellLiveOptions options = {
        .struct_size = sizeof options, .path = argv[1], .profile = argv[2], .keys = &coarser, .key_count = 1};
    FjellLive* const ground = fjell_live_open(&options, why, sizeof why);
    if (ground == NULL) return fail(why);
    const FjellTerrain terrain = fjell_live_terrain(ground);
    const double wide_m = fjell_terrain_extent_x_m(terrain), deep_m = fjell_terrain_extent_z_m(terrain);
    FjellLiveFrame frame = {.struct_size = sizeof frame};
    FjellView view = {.struct_size = sizeof view};
    FjellStatus status = {0};
    size_t uploaded = 0;
    for (int n = 0; status.code == FJELL_OK && (n < 600 || !frame.settled);
         ++n) { /* ten seconds, then until all is there */
        const FjellVec3 east = {1, -0.2, 0}, up = {0, 1, 0};
        FjellVec3 eye_m = {wide_m * (n < 600 ? n : 600) / 1200, 0, deep_m / 2};
        eye_m.y = fjell_ground_height(terrain, eye_m.x, eye_m.z, 0).height_m + 200;
        (void)fjell_make_view(eye_m, east, up, 0.8, 1280, 720, 1, 2 * wide_m, &view);
        status = fjell_live_update(ground, &view, 1, n / 60.0, &frame);  /* no allocation, no lock, no system call */
        const FjellCutChanges changes = fjell_live_take_changes(ground); /* these slots go to the GPU */
        for (FjellRun run = {0};
             fjell_next_run(changes.vertex_bits, changes.vertex_words, changes.vertex_word_count, &run);)
            uploaded += run.count * sizeof *frame.mesh.mesh.vertices;
        size_t commands = 0; /* and these maps */
        (void)fjell_live_take_map_commands(ground, &commands);
        (void)fjell_live_tile_maps(ground, FJELL_MAP_COLOUR, NULL);
    }
    FjellCutReport report = {.struct_size = sizeof report};
    (void)fjell_live_reports(ground, &report, NULL);
    for (size_t i = 0; i < frame.short_of_count; ++i) fprintf(stderr, "fly: raise %s\n", frame.short_of[i]);
    printf("converged %d within %.3g px: %u triangles; %zu bytes to upload, eye %.17g,%.17g,%.17g\n", frame.converged,
           frame.error_bound_px, report.triangles, uploaded, view.eye_m.x, view.eye_m.y, view.eye_m.z);
    fjell_live_close(ground);
    return status.code == FJELL_OK ? 0 : fail(fjell_message(status.code));
}
