/* Albedo and length from textures. The lookup takes the medium at the entry. That alone is what
   most renderers do, and it is not reciprocal where the texture changes: to look from x to y is
   then not the same as from y to x. Here the exit's weight is set right for a profile that is:
   the geometric mean of the entry's and the exit's. The texture is a round spot about the entry,
   inside one medium and outside the other. SPDX-License-Identifier: MIT */
#include "renderer.h"

#define SPOT 0.15f /* its radius */

static sss_medium inside, outside;

/* The maps: both have the same lengths here, so that there is a closed form to compare with. */
static const sss_medium *medium_at(sss_vec3 p) {
    float x = p.x - entry_position().x, y = p.y - entry_position().y;

    return x * x + y * y < SPOT * SPOT && p.z > -0.5f * THICKNESS ? &inside : &outside;
}

static float mean_profile(const sss_medium *a, const sss_medium *b, int channel, float r) {
    return sqrtf(sss_profile(a, channel, r) * sss_profile(b, channel, r));
}

/* A_in within the spot, beyond it and on the lower face the root of A_in A_out. */
static double truth(int channel) {
    double spot = (double)sss_within(&inside, channel, SPOT);
    double rest = slab_integral(&inside, channel) - spot;

    return spot + rest * sqrt((double)(outside.albedo[channel] / inside.albedo[channel]));
}

int main(void) {
    static const char *const name[3] = {"red", "green", "blue"};
    static const float bright[3] = {0.9f, 0.8f, 0.7f}, dark[3] = {0.7f, 0.3f, 0.1f};
    static const float length[3] = {0.3f, 0.2f, 0.1f};
    static tally channel[3];
    float dmfp_bright[3], dmfp_dark[3];

    /* The scattering length of Burley's profile is dmfp / (3.5 + 100 (A - 0.33)^4). */
    for (int c = 0; c < 3; ++c) {
        dmfp_bright[c] = length[c] * (3.5f + 100.0f * powf(bright[c] - 0.33f, 4.0f));
        dmfp_dark[c] = length[c] * (3.5f + 100.0f * powf(dark[c] - 0.33f, 4.0f));
    }
    if (sss_burley(&inside, bright, dmfp_bright) != SSS_OK) return 1;
    if (sss_burley(&outside, dark, dmfp_dark) != SSS_OK) return 1;

    for (uint32_t i = 0; i < LOOKUPS; ++i) {
        const sss_medium *here = medium_at(entry_position());
        sss_resampler s;
        sss_probe probe;
        sss_exit exit;
        ray_hit hit[MOST_HITS];

        sss_begin(&s, here, NULL, entry_position(), entry_normal(), sss_hash(3, i));
        while (sss_next_probe(&s, &probe)) {
            int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

            for (int k = 0; k < count; ++k) sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
        }
        int found = sss_finish(&s, &exit);
        for (int c = 0; c < 3; ++c) {
            float r = found ? distance(entry_position(), exit.position) : 0.0f;
            float theirs = sss_profile(here, c, r);
            float right = found && theirs > 0.0f
                              ? mean_profile(here, medium_at(exit.position), c, r) / theirs
                              : 0.0f;

            tally_add(&channel[c], found ? (double)(exit.weight[c] * right) : 0.0);
        }
    }
    for (int c = 0; c < 3; ++c) tally_print(&channel[c], name[c], truth(c));
    return 0;
}
