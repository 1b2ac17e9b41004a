/* For a wavefront renderer, which does one step for many paths before the next. The resampler is
   plain values, so it waits in memory between the kernels. Each function below is a kernel over all
   lookups of a wave; they meet in the arrays alone. On a GPU define SSS_LANES as 1: the state is
   then much smaller. SPDX-License-Identifier: MIT */
#include "renderer.h"

#define WAVE 4096u

static sss_medium wax;
static sss_resampler state[WAVE];
static sss_probe probe[WAVE];
static int alive[WAVE], hits[WAVE];
static ray_hit hit[WAVE][MOST_HITS];
static sss_exit exits[WAVE];

static void begin_kernel(uint32_t i, uint32_t first) {
    sss_begin(&state[i], &wax, NULL, entry_position(), entry_normal(), sss_hash(0, first + i));
}
static void probe_kernel(uint32_t i) { alive[i] = sss_next_probe(&state[i], &probe[i]); }
static void trace_kernel(uint32_t i) {
    hits[i] = 0;
    if (alive[i])
        hits[i] = all_hits(SLAB, probe[i].origin, probe[i].direction, probe[i].length, hit[i]);
}
static void add_kernel(uint32_t i) {
    for (int k = 0; k < hits[i]; ++k)
        sss_add_hit(&state[i], hit[i][k].position, hit[i][k].normal, 1.0f);
}
static void finish_kernel(uint32_t i) { alive[i] = sss_finish(&state[i], &exits[i]); }

static void wave(uint32_t first) {
    uint32_t i, busy;

    for (i = 0; i < WAVE; ++i) begin_kernel(i, first);
    do {
        for (i = 0; i < WAVE; ++i) probe_kernel(i);
        for (i = 0; i < WAVE; ++i) trace_kernel(i);
        for (i = 0; i < WAVE; ++i) add_kernel(i);
        for (i = 0, busy = 0; i < WAVE; ++i) busy += (uint32_t)alive[i];
    } while (busy > 0);
    for (i = 0; i < WAVE; ++i) finish_kernel(i);
}

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.25f};
    static tally channel[3];

    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (uint32_t first = 0; first < LOOKUPS; first += WAVE) {
        wave(first);
        for (uint32_t i = 0; i < WAVE; ++i)
            for (int c = 0; c < 3; ++c)
                tally_add(&channel[c], alive[i] ? (double)exits[i].weight[c] : 0.0);
    }
    print_channels(channel, &wax);
    return 0;
}
