/* For a wavefront renderer, which does one step for many paths before the next: the resampler is plain values, so it
   waits in memory between the kernels. Each function below is a kernel over all lookups of a wave; they meet in the
   arrays alone. On a GPU define SSS_LANES as 1: the state is then half as large. SPDX-License-Identifier: MIT */
#include "renderer.h"

#define WAVE 4096

static sss_medium wax;
static sss_resampler state[WAVE];
static sss_probe probe[WAVE];
static int alive[WAVE], hits[WAVE];
static ray_hit hit[WAVE][MOST_HITS];
static sss_exit exits[WAVE];

static void begin_kernel(int i, uint32_t first) {
    sss_begin(&state[i], &wax, NULL, vec(0.3f, 0.1f, 0.0f), vec(0.0f, 0.0f, 1.0f), sss_hash(0, first + (uint32_t)i));
}
static void probe_kernel(int i) { alive[i] = sss_next_probe(&state[i], &probe[i]); }
static void trace_kernel(int i) {
    hits[i] = alive[i] ? all_hits(SLAB, probe[i].origin, probe[i].direction, probe[i].length, hit[i]) : 0;
}
static void add_kernel(int i) {
    int k;
    for (k = 0; k < hits[i]; ++k) sss_add_hit(&state[i], hit[i][k].position, hit[i][k].normal, 1.0f);
}
static void finish_kernel(int i) { alive[i] = sss_finish(&state[i], &exits[i]); }

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.25f};
    double sum[3] = {0.0, 0.0, 0.0}, squares[3] = {0.0, 0.0, 0.0};
    uint32_t first;
    int i, c, busy;
    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (first = 0; first < LOOKUPS; first += WAVE) {
        for (i = 0; i < WAVE; ++i) begin_kernel(i, first);
        do {
            for (i = 0; i < WAVE; ++i) probe_kernel(i);
            for (i = 0; i < WAVE; ++i) trace_kernel(i);
            for (i = 0; i < WAVE; ++i) add_kernel(i);
            for (i = 0, busy = 0; i < WAVE; ++i) busy += alive[i];
        } while (busy > 0);
        for (i = 0; i < WAVE; ++i) finish_kernel(i);
        for (i = 0; i < WAVE; ++i) {
            for (c = 0; c < 3 && alive[i]; ++c) { /* here a renderer shades exits[i].position */
                sum[c] += (double)exits[i].weight[c];
                squares[c] += (double)exits[i].weight[c] * (double)exits[i].weight[c];
            }
        }
    }
    report(&wax, sum, squares);
    return 0;
}
