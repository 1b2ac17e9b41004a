/* The furnace that is quickest to set up: a white ball in white light. Its mean is sss_within(2 R)
   in each channel, at every entry: no point of a ball is farther than 2 R, and of its surface as
   much lies within a distance as of a plane.

   The profile reaches far beyond this ball, so probes start far away. The usual quadratic equation
   loses digits there, and the channel a thousand times narrower than the widest one loses light.
   With the ray's origin moved to the ball's centre nothing is lost. The seeds are the same both
   times, so their difference shows it.

   Then a fault of renderers: Russian roulette that divides by a chance above 1.
   SPDX-License-Identifier: MIT */
#include "renderer.h"

#define RADIUS 1.0f

static float farthest; /* from the centre, of all origins, in radii */

/* The hits of a unit direction with the ball about 0. */
static int ball_hits(sss_vec3 origin, sss_vec3 direction, float most, int moved, float *t) {
    float shift = moved ? -dot(origin, direction) : 0.0f;
    sss_vec3 o = vec(origin.x + shift * direction.x, origin.y + shift * direction.y,
                     origin.z + shift * direction.z);
    float b = dot(o, direction), root = b * b - dot(o, o) + RADIUS * RADIUS;
    int count = 0;

    if (root < 0.0f) return 0;
    root = sqrtf(root);
    for (int i = 0; i < 2; ++i) {
        float at = shift - b + (i ? root : -root);

        if (at >= 0.0f && at <= most) t[count++] = at;
    }
    return count;
}

static void lookup(const sss_medium *m, uint32_t seed, int moved, float weight[3]) {
    sss_vec3 entry = vec(0.36f * RADIUS, 0.48f * RADIUS, 0.8f * RADIUS);
    sss_resampler s;
    sss_probe p;
    sss_exit exit;
    float t[2];
    int i;

    sss_begin(&s, m, NULL, entry, entry, seed);
    while (sss_next_probe(&s, &p)) {
        int count = ball_hits(p.origin, p.direction, p.length, moved, t);

        farthest = fmaxf(farthest, distance(p.origin, vec(0.0f, 0.0f, 0.0f)) / RADIUS);
        for (i = 0; i < count; ++i) {
            sss_vec3 y = vec(p.origin.x + t[i] * p.direction.x, p.origin.y + t[i] * p.direction.y,
                             p.origin.z + t[i] * p.direction.z);

            sss_add_hit(&s, y, y, 1.0f);
        }
    }
    i = sss_finish(&s, &exit);
    memset(weight, 0, 3 * sizeof *weight);
    if (i) memcpy(weight, exit.weight, sizeof exit.weight);
}

int main(void) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, dmfp[3] = {12.0f, 0.4f, 0.012f};
    static const char *const name[3] = {"wide", "middle", "narrow"};
    static tally mean[3], loss, roulette;
    sss_medium m;

    if (sss_burley(&m, white, dmfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < 8u * LOOKUPS; ++i) {
        float moved[3], not_moved[3];

        lookup(&m, sss_hash(8, i), 1, moved);
        lookup(&m, sss_hash(8, i), 0, not_moved);
        for (int c = 0; c < 3; ++c) tally_add(&mean[c], (double)moved[c]);
        tally_add(&loss, (double)not_moved[2] - (double)moved[2]);

        /* Below 1 the chance to live on and the division by it cancel in the mean. */
        float chance = fmaxf(moved[0], fmaxf(moved[1], moved[2]));
        tally_add(&roulette, (double)(chance > 1.0f ? moved[1] / chance : moved[1]));
    }
    for (int c = 0; c < 3; ++c)
        tally_print(&mean[c], name[c], (double)sss_within(&m, c, 2.0f * RADIUS));
    printf("with a fault each: probes started up to %.1f radii away\n", (double)farthest);
    tally_print(&loss, "narrow, origin not moved", 0.0);
    tally_print(&roulette, "middle, roulette by a chance above 1", 1.0);
    return 0;
}
