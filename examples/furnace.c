/* The furnace: a white object in white light must vanish. Run it in your own renderer before any
   picture: albedo 1, a white sky of radiance 1, no Fresnel factors. With SSS_WALK and one mean free
   path for all colours every sample of every shape is 1, to the bit. That tests your shading, but
   not your hits, since a walk that is lost outside mostly finds its way back. Its medium comes from
   sss_burley_mfp: at albedo 1 sss_burley has no volume, and nothing is traced. With a profile the
   mean is 1 where the object is flat and thick against the mean free path. A thin slab has the
   closed form 2 A - sss_within(thickness), and that does test the hits.

   What follows are the walk, the profile, and the profile with faults of a renderer, so that you
   know them when you see them. The slab lies on a plate. SPDX-License-Identifier: MIT */
#include "renderer.h"

typedef enum fault { NONE, CLOSEST, FRONT, LATE, SHORT, OTHERS, TWICE, BUMPS, FAULTS } fault;

static const char *const name[FAULTS] = {
    "the profile",        "the closest hit alone",  "no back faces",   "tmin of 0.01",
    "ends 0.01 too soon", "hits of another object", "every hit twice", "shading normals"};

static int probe_hits(const sss_probe *p, fault f, ray_hit *hits) {
    int kept = 0;
    int count = all_hits(SLAB, p->origin, p->direction, p->length, hits);

    if (f == OTHERS) count += all_hits(PLATE, p->origin, p->direction, p->length, hits + count);
    for (int i = 0; i < count; ++i) {
        ray_hit h = hits[i];

        if (f == CLOSEST && i > 0) continue;
        if (f == FRONT && dot(h.normal, p->direction) > 0.0f) continue;
        if (f == LATE && h.t < 0.01f) continue;
        if (f == SHORT && h.t > p->length - 0.01f) continue;

        /* Bumps of up to 27 degrees. */
        if (f == BUMPS) {
            float z = fabsf(h.normal.z);

            h.normal = vec(h.normal.x + 0.5f * z * sinf(40.0f * h.position.x),
                           h.normal.y + 0.5f * z * sinf(40.0f * h.position.y), h.normal.z);
        }
        hits[kept++] = h;
    }
    return kept;
}

static float lookup(const sss_medium *m, fault f, uint32_t seed) {
    sss_resampler s;
    sss_probe probe;
    sss_exit exit;

    sss_begin(&s, m, NULL, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hits[2 * MOST_HITS];
        int count = probe_hits(&probe, f, hits);

        for (int i = 0; i < count; ++i) {
            sss_add_hit(&s, hits[i].position, hits[i].normal, 1.0f);
            if (f == TWICE) sss_add_hit(&s, hits[i].position, hits[i].normal, 1.0f);
        }
    }
    return sss_finish(&s, &exit) ? exit.weight[0] : 0.0f;
}

static float walk(const sss_medium *m, uint32_t seed, long *segments) {
    sss_plan plan = {1, 1, SSS_WALK, 0, 0, 0};
    sss_resampler s;
    sss_probe segment;
    sss_exit exit;
    ray_hit hit;

    sss_begin(&s, m, &plan, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &segment)) {
        if (closest_hit(SLAB, segment.origin, segment.direction, 0.0f, segment.length, &hit))
            sss_add_hit(&s, hit.position, hit.normal, 1.0f);
        ++*segments;
    }
    return sss_finish(&s, &exit) ? exit.weight[0] : 0.0f;
}

int main(void) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, dmfp[3] = {3.0f, 3.0f, 3.0f};
    static const float mfp[3] = {0.05f, 0.05f, 0.05f};
    static tally walked, profile[FAULTS];
    long segments = 0;
    sss_medium m, volume;

    if (sss_burley(&m, white, dmfp) != SSS_OK) return 1;
    if (sss_burley_mfp(&volume, white, mfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < LOOKUPS; ++i) {
        tally_add(&walked, (double)walk(&volume, sss_hash(5, i), &segments));
        for (int f = NONE; f < FAULTS; ++f)
            tally_add(&profile[f], (double)lookup(&m, (fault)f, sss_hash(6, i)));
    }
    printf("%.1f segments, ", (double)segments / LOOKUPS);
    tally_print(&walked, "the walk", 1.0);
    for (int f = NONE; f < FAULTS; ++f) {
        if (f == CLOSEST) puts("with a fault each:");
        tally_print(&profile[f], name[f], slab_integral(&m, 0));
    }
    return 0;
}
