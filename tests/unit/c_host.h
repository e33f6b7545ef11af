/* What a host in C does, for c_api_test.cpp to compare with what one in C++ gets. The guide quotes c_host.c. */
#ifndef FJELL_TESTS_C_HOST_H
#define FJELL_TESTS_C_HOST_H

#include <fjell/fjell_c.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Allocates for a test: aligned to 64 bytes, freed by it. */
typedef struct Allocator {
    void* (*allocate)(struct Allocator* self, size_t bytes);
} Allocator;

typedef struct Flown {
    FjellStatus failure; /* of the call that was refused */
    FjellView view;      /* of the last frame */
    FjellCutReport report;
    uint32_t uploaded_vertices, uploaded_triangles, drawn; /* in all frames */
    FjellStreamReport streamed;
    double bound_px;
    uint32_t recursive_triangles;
    FjellGroundHeight ground;
    FjellGroundHit hit;
    float heights_m[33 * 33], patch_error_m;
} Flown;

/* The README's loop, then the other queries. 0, or 1 and flown->failure. */
int c_host_fly(const void* file, size_t file_bytes, Allocator* allocator, Flown* flown);
/* Streams the same pack until it has all that the view wants. */
int c_host_stream(const void* file, size_t file_bytes, Allocator* allocator, Flown* flown);

#ifdef __cplusplus
}
#endif
#endif
