/* Any profile: the exits come from one of the header's profiles, and your own one weighs them.
   Here it is a Gaussian. First on the picked exit: its weight times own Rd over sss_profile. Then
   on every hit, without a pick: own Rd over the density of the hits, which is sss_intensity times
   the number of probes. Both have the integral of the own profile as their expected value
   wherever the medium's profile is above zero; the nearer the two profiles are, the less noise.
   SPDX-License-Identifier: MIT */
#include "renderer.h"

#define CANDIDATES 8

static const float own_albedo[3] = {0.8f, 0.5f, 0.2f}, width[3] = {0.2f, 0.12f, 0.06f};

static float own_profile(int channel, float r) {
    float x = r / width[channel];

    return own_albedo[channel] * expf(-0.5f * x * x) /
           (2.0f * PI * width[channel] * width[channel]);
}

/* Over both faces of the slab: the lower one is a plane at the distance THICKNESS. */
static double own_integral(int channel) {
    double x = (double)(THICKNESS / width[channel]);

    return (double)own_albedo[channel] * (1.0 + exp(-0.5 * x * x));
}

static void lookup(const sss_medium *m, uint32_t seed, float picked[3], float every[3]) {
    sss_vec3 x = entry_position();
    sss_resampler s;
    sss_probe probe;
    sss_exit exit;

    for (int c = 0; c < 3; ++c) picked[c] = every[c] = 0.0f;
    sss_begin(&s, m, NULL, x, entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit[MOST_HITS];
        int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

        for (int k = 0; k < count; ++k) {
            float density = CANDIDATES * sss_intensity(&s, hit[k].position, hit[k].normal);

            for (int c = 0; c < 3 && density > 0.0f; ++c)
                every[c] += own_profile(c, distance(x, hit[k].position)) / density;
            sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
        }
    }
    if (!sss_finish(&s, &exit)) return;
    for (int c = 0; c < 3; ++c) {
        float r = distance(x, exit.position), theirs = sss_profile(m, c, r);

        if (theirs > 0.0f) picked[c] = exit.weight[c] * own_profile(c, r) / theirs;
    }
}

int main(void) {
    static const char *const name[3] = {"red", "green", "blue"};
    static const float albedo[3] = {1.0f, 1.0f, 1.0f}; /* only its lengths matter here */
    static tally picked[3], every[3];
    float dmfp[3], weight[2][3];
    sss_medium near_enough;
    char line[32];

    /* Burley's d = dmfp / 23.7 at albedo 1: two thirds of the Gaussian's width. */
    for (int c = 0; c < 3; ++c) dmfp[c] = 23.7f * 0.67f * width[c];
    if (sss_burley(&near_enough, albedo, dmfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < LOOKUPS; ++i) {
        lookup(&near_enough, sss_hash(2, i), weight[0], weight[1]);
        for (int c = 0; c < 3; ++c) {
            tally_add(&picked[c], (double)weight[0][c]);
            tally_add(&every[c], (double)weight[1][c]);
        }
    }
    for (int c = 0; c < 3; ++c) {
        snprintf(line, sizeof line, "picked exit, %s", name[c]);
        tally_print(&picked[c], line, own_integral(c));
        snprintf(line, sizeof line, "every hit, %s", name[c]);
        tally_print(&every[c], line, own_integral(c));
    }
    return 0;
}
