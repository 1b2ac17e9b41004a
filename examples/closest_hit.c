/* For a renderer whose rays find the closest hit alone. It steps along the probe: always from the probe's origin,
   beyond the float that the last hit was at. Every triangle then has the same t each time, so none is met twice, and no
   epsilon is needed that a thin part would be lost in. (To start anew at the last hit is what goes wrong: its position
   is rounded.) SPDX-License-Identifier: MIT */
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
            ray_hit hit;
            float least = 0.0f;
            while (closest_hit(SLAB, probe.origin, probe.direction, least, probe.length, &hit)) {
                sss_add_hit(&s, hit.position, hit.normal, 1.0f);
                least = nextafterf(hit.t, HUGE_VALF);
            }
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
