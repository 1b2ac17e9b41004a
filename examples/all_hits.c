/* For a renderer that can ask for all hits of a ray at once (an any-hit or filter callback that notes each and goes
   on): demos/common/mesh_tracer.h does that with Embree, and says how a hit at an edge counts once. SPDX-License-Identifier:
   MIT */
#include "renderer.h"

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.25f};
    double sum[3] = {0.0, 0.0, 0.0}, squares[3] = {0.0, 0.0, 0.0};
    sss_medium wax;
    uint32_t i;
    int c;
    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (i = 0; i < LOOKUPS; ++i) {
        sss_resampler s;
        sss_probe probe;
        sss_exit exit;
        sss_begin(&s, &wax, NULL, vec(0.3f, 0.1f, 0.0f), vec(0.0f, 0.0f, 1.0f), sss_hash(0, i));
        while (sss_next_probe(&s, &probe)) {
            ray_hit hit[MOST_HITS];
            int k, count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);
            for (k = 0; k < count; ++k) sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
        }
        if (!sss_finish(&s, &exit)) continue;
        for (c = 0; c < 3; ++c) { /* here a renderer shades exit.position */
            sum[c] += (double)exit.weight[c];
            squares[c] += (double)exit.weight[c] * (double)exit.weight[c];
        }
    }
    report(&wax, sum, squares);
    return 0;
}
