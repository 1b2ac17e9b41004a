/* A light hint with several lights. It is a guess of the irradiance at a hit without any ray: the
   sum over the lights of what each would give unshadowed, plus a floor in the same unit for all
   that the sum leaves out (sky, bounced light). A wrong guess costs noise, never bias.

   Here two lamps hang over the slab, one of them has a shadow that the hint knows nothing of, and a
   dim sky is everywhere. The floor is the sky's irradiance. SPDX-License-Identifier: MIT */
#include "renderer.h"

#define SKY 0.3f

typedef struct lamp {
    sss_vec3 position;
    float intensity, shadow_from, shadow_to; /* the shadow: a stripe of the upper face in x */
} lamp;

static const lamp lamps[2] = {{{1.2f, 0.0f, 0.6f}, 2.0f, 0.40f, 0.55f},
                              {{-0.5f, 0.5f, 1.0f}, 0.5f, 9.0f, 9.0f}};

/* The irradiance by one lamp if nothing is in its way. */
static float unshadowed(const lamp *l, sss_vec3 p, sss_vec3 n) {
    sss_vec3 to = minus(l->position, p);
    float squared = dot(to, to), cosine = dot(to, n) / sqrtf(squared * dot(n, n));

    return cosine > 0.0f ? l->intensity * cosine / squared : 0.0f;
}
static float irradiance(sss_vec3 p, sss_vec3 n) {
    float e = SKY;

    for (int i = 0; i < 2; ++i)
        if (!(p.x > lamps[i].shadow_from && p.x < lamps[i].shadow_to))
            e += unshadowed(&lamps[i], p, n);
    return e;
}
static float hint(sss_vec3 p, sss_vec3 n, float floor_of_hint) {
    return unshadowed(&lamps[0], p, n) + unshadowed(&lamps[1], p, n) + floor_of_hint;
}

static float lookup(const sss_medium *m, float floor_of_hint, uint32_t seed) {
    sss_resampler s;
    sss_probe probe;
    sss_exit exit;

    sss_begin(&s, m, NULL, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit[MOST_HITS];
        int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

        for (int k = 0; k < count; ++k) {
            float light =
                floor_of_hint > 0.0f ? hint(hit[k].position, hit[k].normal, floor_of_hint) : 1.0f;

            sss_add_hit(&s, hit[k].position, hit[k].normal, light);
        }
    }
    if (!sss_finish(&s, &exit)) return 0.0f;
    return exit.weight[0] * irradiance(exit.position, exit.normal);
}

/* Rings about the entry, each with its share of the profile and the mean irradiance around it. */
static double truth(const sss_medium *m) {
    const int rings = 4000, turns = 512;
    double sum = 0.0, before = 0.0;

    for (int face = 0; face < 2; ++face) {
        float depth = face ? THICKNESS : 0.0f;

        before = (double)sss_within(m, 0, depth);
        for (int i = 0; i < rings; ++i) {
            float middle = 6.0f * ((float)i + 0.5f) / (float)rings;
            float outer = 6.0f * (float)(i + 1) / (float)rings;
            double after = (double)sss_within(m, 0, sqrtf(outer * outer + depth * depth));
            double around = 0.0;

            for (int k = 0; k < turns; ++k) {
                float angle = 2.0f * PI * ((float)k + 0.5f) / (float)turns;
                sss_vec3 p = vec(0.3f + middle * cosf(angle), 0.1f + middle * sinf(angle), -depth);

                around += (double)irradiance(p, vec(0.0f, 0.0f, face ? -1.0f : 1.0f)) / turns;
            }
            sum += (after - before) * around;
            before = after;
        }
    }
    return sum;
}

int main(void) {
    static const float albedo[3] = {0.9f, 0.9f, 0.9f}, dmfp[3] = {1.0f, 1.0f, 1.0f};
    static const float of_sky[6] = {0.0f, 0.1f, 0.3f, 1.0f, 2.0f, 10.0f};
    sss_medium m;

    if (sss_burley(&m, albedo, dmfp) != SSS_OK) return 1;
    double right = truth(&m);
    for (int k = 0; k < 6; ++k) {
        tally t = {0.0, 0.0, 0};
        char line[64];

        for (uint32_t i = 0; i < 2u * LOOKUPS; ++i)
            tally_add(&t, (double)lookup(&m, of_sky[k] * SKY, sss_hash(7u + (uint32_t)k, i)));
        snprintf(line, sizeof line, k ? "floor %g times the sky" : "no hint", (double)of_sky[k]);
        tally_print(&t, line, right);
    }
    return 0;
}
