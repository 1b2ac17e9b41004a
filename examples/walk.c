/* The random walk through the volume, for a renderer whose rays find the closest hit alone: a
   segment of a walk needs no more than that. Two things differ from the profiles: the plan, and a
   normal that must point outwards. Here the slab is many mean free paths thick, so that it reflects
   what a half space would: the albedo. SPDX-License-Identifier: MIT */
#include "renderer.h"

int main(void) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, dmfp[3] = {0.008f, 0.006f, 0.004f};
    static const char *const name[3] = {"red", "green", "blue"};
    static tally channel[3];
    sss_plan plan = {4, 1, SSS_WALK, 0, 0, 0};
    sss_medium wax;

    if (sss_burley(&wax, albedo, dmfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < LOOKUPS; ++i) {
        sss_resampler s;
        sss_probe segment;
        sss_exit exit;
        ray_hit hit;

        sss_begin(&s, &wax, &plan, entry_position(), entry_normal(), sss_hash(1, i));
        while (sss_next_probe(&s, &segment))
            if (closest_hit(SLAB, segment.origin, segment.direction, 0.0f, segment.length, &hit))
                sss_add_hit(&s, hit.position, hit.normal, 1.0f);
        int found = sss_finish(&s, &exit);
        for (int c = 0; c < 3; ++c) tally_add(&channel[c], found ? (double)exit.weight[c] : 0.0);
    }
    for (int c = 0; c < 3; ++c) tally_print(&channel[c], name[c], (double)albedo[c]);
    return 0;
}
