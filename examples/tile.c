/* For a renderer that works tile by tile: every pixel makes its own lookup and shades its own
   exits, then each exit also counts for the other pixels of the tile. Nothing is traced for that.
   The tile must be chosen without a look at the random numbers, and hold one object.
   SPDX-License-Identifier: MIT */
#include "renderer.h"

#define SIDE   4
#define PIXELS (SIDE * SIDE)
#define PIXEL  0.02f /* width of a pixel on the surface */

/* All of one pixel that sharing needs. */
typedef struct pixel {
    int found;
    sss_exit exit;
} pixel;

static sss_vec3 pixel_position(int i) {
    return vec(0.3f + PIXEL * (float)(i % SIDE), 0.1f + PIXEL * (float)(i / SIDE), 0.0f);
}

static void lookup(const sss_medium *wax, int i, uint32_t seed, pixel *p) {
    sss_resampler s;
    sss_probe probe;

    sss_begin(&s, wax, NULL, pixel_position(i), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit[MOST_HITS];
        int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

        for (int k = 0; k < count; ++k) sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
    }
    p->found = sss_finish(&s, &p->exit);
}

/* Light from above on one half of the plane, x > 0.3, seen through the irradiance E of the exit. */
static float irradiance(const sss_exit *exit) {
    return exit->normal.z > 0.0f && exit->position.x > 0.3f ? 1.0f : 0.0f;
}

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.25f};
    static tally own, shared;
    sss_entry entry[PIXELS];
    sss_medium wax;

    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (int i = 0; i < PIXELS; ++i) {
        entry[i].position = pixel_position(i);
        entry[i].medium = &wax;
    }
    for (uint32_t tile = 0; tile < LOOKUPS / PIXELS; ++tile) {
        pixel pixels[PIXELS];
        float sum[PIXELS] = {0.0f};

        for (int i = 0; i < PIXELS; ++i) lookup(&wax, i, sss_hash((uint32_t)i, tile), &pixels[i]);
        for (int i = 0; i < PIXELS; ++i) {
            float weight[PIXELS][3];

            if (!pixels[i].found) continue;
            float light = irradiance(&pixels[i].exit); /* shaded once, for all */
            sss_share(&pixels[i].exit, entry, PIXELS, i, PIXEL, weight);
            for (int k = 0; k < PIXELS; ++k) sum[k] += weight[k][0] * light;
        }

        /* The light ends right at the first pixel: it gets half of the upper face's. */
        tally_add(&shared, (double)sum[0]);
        tally_add(&own, pixels[0].found
                            ? (double)(pixels[0].exit.weight[0] * irradiance(&pixels[0].exit))
                            : 0.0);
    }
    tally_print(&own, "own exits", 0.5 * (double)sss_within(&wax, 0, 1e9f));
    tally_print(&shared, "shared exits", 0.5 * (double)sss_within(&wax, 0, 1e9f));
    return 0;
}
