/* For a renderer whose rays find the closest hit alone. It steps along the probe: always from the
   probe's origin, from the float after the last hit's t on. Every triangle has the same t each
   time, so none is met twice, and there is no epsilon for a thin part to be lost in. (To start
   anew at the last hit is what goes wrong: its position is rounded.)
   SPDX-License-Identifier: MIT */
#include "renderer.h"

static int lookup(const sss_medium *wax, uint32_t seed, sss_exit *exit) {
    sss_resampler s;
    sss_probe probe;

    sss_begin(&s, wax, NULL, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit;
        float least = 0.0f;

        while (closest_hit(SLAB, probe.origin, probe.direction, least, probe.length, &hit)) {
            sss_add_hit(&s, hit.position, hit.normal, 1.0f);
            least = nextafterf(hit.t, HUGE_VALF);
        }
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

        for (int c = 0; c < 3; ++c) tally_add(&channel[c], found ? (double)exit.weight[c] : 0.0);
    }
    print_channels(channel, &wax);
    return 0;
}
