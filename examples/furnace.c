/* The furnace: a white object in white light must vanish. Run it in your own renderer before any
   picture: albedo 1, a white sky of radiance 1, no Fresnel factors. Each pixel of the object must
   become 1. With a profile that holds where the object is flat and thick against the mean free path;
   with SSS_WALK it holds on every shape, and for each sample by itself.

   Below the walk, the profile, and the profile with seven faults of a renderer, so that you know them
   when you see them. Here "the object" is a slab that lies on a plate. SPDX-License-Identifier: MIT */
#include "renderer.h"

typedef enum fault {
    NONE,
    CLOSEST_ONLY,  /* one hit a probe */
    FRONT_ONLY,    /* back faces culled */
    TMIN,          /* rays start a little later */
    RESTART,       /* after a hit a new ray from its position, moved by an epsilon */
    OTHERS,        /* hits of another object too */
    TWICE,         /* a hit at an edge, or all, reported twice */
    TRY_AGAIN,     /* a lookup without an exit is made anew */
    FAULTS
} fault;

static const char *const name[FAULTS] = {"no fault",
                                         "the closest hit alone",
                                         "no back faces",
                                         "tmin of 0.01",
                                         "restarts 0.01 after a hit",
                                         "hits of another object",
                                         "every hit twice",
                                         "tried again until an exit is found"};

static int probe_hits(const sss_probe *p, fault f, ray_hit *hits) {
    int i, kept = 0;
    int count = all_hits(SLAB, p->origin, p->direction, p->length, hits);

    if (f == OTHERS)
        count += all_hits(PLATE, p->origin, p->direction, p->length, hits + count);
    for (i = 0; i < count; ++i) {
        if (f == CLOSEST_ONLY && i > 0) continue;
        if (f == FRONT_ONLY && dot(hits[i].normal, p->direction) > 0.0f) continue;
        if (f == TMIN && hits[i].t < 0.01f) continue;
        if (f == RESTART && i > 0 && hits[i].t - hits[i - 1].t < 0.01f) continue;
        hits[kept++] = hits[i];
    }
    return kept;
}

static float lookup(const sss_medium *m, fault f, uint32_t seed) {
    sss_resampler s;
    sss_probe probe;
    sss_exit exit;
    ray_hit hits[2 * MOST_HITS];
    int i, count;

    sss_begin(&s, m, NULL, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &probe)) {
        count = probe_hits(&probe, f, hits);
        for (i = 0; i < count; ++i) {
            sss_add_hit(&s, hits[i].position, hits[i].normal, 1.0f);
            if (f == TWICE) sss_add_hit(&s, hits[i].position, hits[i].normal, 1.0f);
        }
    }
    if (sss_finish(&s, &exit)) return exit.weight[0];
    return f == TRY_AGAIN ? lookup(m, f, sss_hash(seed, 1)) : 0.0f;
}

static float walk(const sss_medium *m, uint32_t seed) {
    sss_plan plan = {1, 1, SSS_WALK, 0, 0, 0};
    sss_resampler s;
    sss_probe segment;
    sss_exit exit;
    ray_hit hit;

    sss_begin(&s, m, &plan, entry_position(), entry_normal(), seed);
    while (sss_next_probe(&s, &segment))
        if (closest_hit(SLAB, segment.origin, segment.direction, 0.0f, segment.length, &hit))
            sss_add_hit(&s, hit.position, hit.normal, 1.0f);
    return sss_finish(&s, &exit) ? exit.weight[0] : 0.0f;
}

int main(void) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, length[3] = {0.6f, 0.6f, 0.6f};
    tally of_walk = {0.0, 0.0, 0};
    sss_medium m;
    uint32_t i;
    int f;

    if (sss_burley(&m, white, length) != SSS_OK) return 1;
    for (i = 0; i < LOOKUPS; ++i) tally_add(&of_walk, (double)walk(&m, sss_hash(5, i)));
    tally_print(&of_walk, "the walk", 1.0);

    for (f = NONE; f < FAULTS; ++f) {
        tally of_fault = {0.0, 0.0, 0};

        for (i = 0; i < 4u * LOOKUPS; ++i)
            tally_add(&of_fault, (double)lookup(&m, (fault)f, sss_hash(6, i)));
        tally_print(&of_fault, name[f], slab_integral(&m, 0));
    }
    return 0;
}
