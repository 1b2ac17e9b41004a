/* For a renderer that can ask for all hits of a ray at once (an any-hit or filter callback that
   notes each and goes on). demos/common/mesh_tracer.h does that with Embree, and says how a hit at
   an edge counts once. SPDX-License-Identifier: MIT */
#include "renderer.h"

static int lookup(const sss_medium *wax, uint32_t seed, sss_exit *exit) {
    sss_resampler s;
    sss_probe probe;

    sss_begin(&s, wax, NULL, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit[MOST_HITS];
        int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

        for (int k = 0; k < count; ++k) sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
    }
    return sss_finish(&s, exit);
}

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.25f};
    static tally channel[3];
    sss_medium wax;

    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < LOOKUPS; ++i) {
        sss_exit exit;
        int found = lookup(&wax, sss_hash(0, i), &exit);

        /* Here a renderer shades exit.position. No exit counts as zero. */
        for (int c = 0; c < 3; ++c) tally_add(&channel[c], found ? (double)exit.weight[c] : 0.0);
    }
    print_channels(channel, &wax);
    return 0;
}
