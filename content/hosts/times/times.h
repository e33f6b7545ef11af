/* What a frame costs, measured alike in all hosts: each takes `PACK --times VIEWS` and prints one line.
   tests/bench/hosts.sh runs them side by side. In C99, which is C++ too.

   VIEWS is a text file: the picture's width and height in pixels and its vertical field of view in radians; then a line
   a frame, the eye in metres of the scene, the direction of sight and up. It is flown twice, so that every page has
   been there before: the second flight counts. Between measured parts a host may wait. */
#ifndef HOSTS_TIMES_H
#define HOSTS_TIMES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    times_update, /* deciding: of the stream and of the cut, of a simulation's ground the stream alone */
    times_upload, /* converting what has changed, and handing it over */
    times_draw,   /* submitting what is drawn, until the calls return; the driver's share of the work is in it */
    times_finish, /* until the picture is there: what a game does not wait for, and what a CPU that draws does here */
    times_parts
};
/* The same for all hosts, so that they have the same mesh, and room for all pages. */
#define TIMES_ERROR_PX 1.0
#define TIMES_PAGES 1024
#define TIMES_NEAR_M 0.5
#define TIMES_FAR_M 1e6

typedef struct Times {
    unsigned width_px, height_px, frames;
    double fov_y_rad;
    double* view;            /* 9 numbers a frame */
    double* us[times_parts]; /* a number a frame */
    unsigned count[times_parts];
} Times;

static inline void times_end(Times* times) {
    free(times->view);
    for (int part = 0; part < times_parts; ++part) free(times->us[part]);
    memset(times, 0, sizeof *times);
}

/* NULL, or one line that says what is wrong. Whatever it says, times_end() frees. */
static inline const char* times_read(Times* times, const char* path) {
    memset(times, 0, sizeof *times);
    FILE* const file = fopen(path, "r");
    if (file == NULL) return "--times: cannot open VIEWS; tests/bench/hosts.sh writes one";
    unsigned room = 0;
    int good = fscanf(file, "%u %u %lf", &times->width_px, &times->height_px, &times->fov_y_rad) == 3;
    while (good) {
        if (times->frames == room) {
            room = room == 0 ? 256 : 2 * room;
            double* const more = (double*)realloc(times->view, 9 * sizeof(double) * room);
            if (more == NULL) break;
            times->view = more;
        }
        double* const to = times->view + (size_t)9 * times->frames;
        int numbers = 0;
        while (numbers < 9 && fscanf(file, "%lf", to + numbers) == 1) ++numbers;
        if (numbers != 9) {
            good = numbers == 0 && feof(file);
            break;
        }
        ++times->frames;
    }
    fclose(file);
    for (int part = 0; part < times_parts; ++part) {
        times->us[part] = (double*)calloc((size_t)times->frames + 1, sizeof(double));
        good = good && times->us[part] != NULL;
    }
    return good && times->frames > 0 ? NULL : "--times: VIEWS does not hold 3 numbers and then 9 for each frame";
}

static inline void times_add(Times* times, int part, double us) {
    if (times->count[part] < times->frames) times->us[part][times->count[part]++] = us;
}

static inline int times_compare(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

/* parts: what the host calls them; NULL for one that it has not. vertices: of the mesh at the end, or 0. */
static inline void times_print(Times* times, unsigned vertices, const char* const parts[times_parts]) {
    printf("times of %u frames, %u vertices, mean/median/p99 us:", times->frames, vertices);
    for (int part = 0; part < times_parts; ++part) {
        const unsigned n = times->count[part];
        double sum = 0;
        if (parts[part] == NULL || n == 0) continue;
        for (unsigned i = 0; i < n; ++i) sum += times->us[part][i];
        qsort(times->us[part], n, sizeof(double), times_compare);
        printf(" %s %.1f/%.1f/%.1f", parts[part], sum / n, times->us[part][n / 2], times->us[part][(n - 1) * 99 / 100]);
    }
    printf("\n");
}

#ifdef __cplusplus
#include <chrono>

#include <fjell/view.h>

/* The same for C++: start() a frame, and done() after each of its parts. */
struct Measured : Times {
    Measured() : Times{} {}
    ~Measured() { times_end(this); }
    Measured(const Measured&) = delete;
    Measured& operator=(const Measured&) = delete;

    [[nodiscard]] unsigned flown() const { return 2 * frames; }
    [[nodiscard]] fjell::View look(unsigned frame) const {
        const double* const v = view + std::size_t{9} * (frame % frames);
        return fjell::make_view({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, fov_y_rad, width_px,
                                height_px, TIMES_NEAR_M, TIMES_FAR_M);
    }
    void start(unsigned frame) {
        counts_ = frame >= frames;
        pause();
    }
    void done(int part) {
        const auto now = std::chrono::steady_clock::now();
        if (counts_) times_add(this, part, std::chrono::duration<double, std::micro>(now - since_).count());
        pause();
    }

    void pause() { since_ = std::chrono::steady_clock::now(); } // what was done since counts for no part

private:
    std::chrono::steady_clock::time_point since_;
    bool counts_ = false;
};
#endif

#endif
