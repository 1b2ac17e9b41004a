/* The plan for a need. sss_plan_for picks the cheapest model that is good enough, from what the
   renderer knows: the width of a pixel, how thick the object is, what shading an exit costs, and
   the error that may be left. The loop is the same for every plan that comes out. Here the slab
   stands for three bodies: one that is flat for its medium, one that is thin for it, and one of
   which nothing is known. SPDX-License-Identifier: MIT */
#include "renderer.h"

static float lookup(const sss_medium *m, const sss_plan *plan, uint32_t sample) {
    sss_resampler s;
    sss_probe probe;
    sss_exit exits[SSS_MAX_EXITS]; /* a plan may ask for an exit of each colour */
    float sum = 0.0f;

    /* The seed names the pixel. A renderer has a new one for each pixel and bounce. */
    sss_begin_sample(&s, m, plan, entry_position(), entry_normal(), sss_hash(7, 0), sample);
    while (sss_next_probe(&s, &probe)) {
        ray_hit hit[MOST_HITS];
        int count = all_hits(SLAB, probe.origin, probe.direction, probe.length, hit);

        for (int k = 0; k < count; ++k) sss_add_hit(&s, hit[k].position, hit[k].normal, 1.0f);
    }

    /* Here a renderer shades each exit. Its light is 1. */
    int count = sss_finish(&s, exits);
    for (int e = 0; e < count; ++e)
        for (int c = 0; c < 3; ++c) sum += exits[e].weight[c] / 3.0f;
    return sum;
}

static const char *words(const sss_plan *plan) {
    switch (plan->techniques) {
    case SSS_LAMBERT: return "Lambert";
    case SSS_DISK: return "disk";
    case SSS_WALK: return "walk";
    }
    return "mix";
}

int main(void) {
    static const float albedo[3] = {0.6f, 0.5f, 0.4f}, colour[3] = {1.0f, 0.7f, 0.4f};
    static const struct {
        const char *name;
        float dmfp, radius; /* 0: not known */
    } body[3] = {{"flat", 0.01f, 0.5f * THICKNESS},
                 {"thin", 0.03f, 0.5f * THICKNESS},
                 {"not known", 0.006f, 0.0f}};

    for (int i = 0; i < 3; ++i) {
        sss_need need = {0.0005f, body[i].radius, 10.0f, 0.1f, 0};
        float dmfp[3];
        tally t = {0.0, 0.0, 0};
        double truth = 0.0;
        sss_medium m;

        for (int c = 0; c < 3; ++c) dmfp[c] = body[i].dmfp * colour[c];
        if (sss_burley(&m, albedo, dmfp) != SSS_OK) return 1;
        sss_plan plan = sss_plan_for(&m, &need);
        for (uint32_t k = 0; k < LOOKUPS; ++k) tally_add(&t, (double)lookup(&m, &plan, k));

        /* A slab of so many mean free paths reflects what a half space would: its albedo. */
        for (int c = 0; c < 3; ++c)
            truth += (plan.techniques == SSS_WALK ? (double)albedo[c] : slab_integral(&m, c)) / 3.0;
        printf("%s, by %s, %d candidates, tile %d, ", body[i].name, words(&plan), plan.candidates,
               plan.tile);
        tally_print(&t, plan.per_channel ? "an exit for each colour" : "one exit", truth);
    }
    return 0;
}
