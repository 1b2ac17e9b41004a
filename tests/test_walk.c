/* The promise of SSS_WALK: each candidate is a random walk through the volume, and the mean of
   weight * E(exit) is the light that leaves that volume at the entry, on every shape. Truth: the
   half space's albedo, the searchlight of tests/data/mc_searchlight.csv, the energy in a white
   ball, and the independent walk in double precision, demos/study/random_walk.h. Also what
   renderers do, and SSS_LAMBERT.

   Comparisons: 245 z-scores at |z| < 5.2: the chance that a correct header fails in one of them is
   245 * 2.0e-7 = 5e-5. The half space's albedo is checked to 4.2e-3: its standard error is at most
   9e-4, the start inside may cost 2e-4, and the rest is 4.4 standard errors, 20 * 1.1e-5 in all.
   make test-long: ten times as many walks, and the half space's albedo to 1e-3.
   SPDX-License-Identifier: MIT */
#include "sss_test.h"

#include "demos/common/scenes.h"
#include "demos/study/random_walk.h"

#define Z_LIMIT 5.2
#define BLOCKS  64

static long factor = 1;

/* ---- Estimates in blocks: the mean of three channels over many lookups ---- */
typedef void lookup_function(const void *context, uint32_t i, double sum[3]);

static void estimate(lookup_function *lookup, const void *context, long first, long count,
                     st_stat stat[3]) {
    static st_stat part[BLOCKS][3];

    memset(part, 0, sizeof part);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        for (long i = b; i < count; i += BLOCKS) {
            double sum[3] = {0.0, 0.0, 0.0};

            lookup(context, (uint32_t)(first + i), sum);
            for (int k = 0; k < 3; ++k) st_add(&part[b][k], sum[k]);
        }
    }
    for (int b = 0; b < BLOCKS; ++b)
        for (int c = 0; c < 3; ++c) st_merge(&stat[c], &part[b][c]);
}

static sss_plan walks(int candidates, int exits, int per_channel) {
    sss_plan p = {0, 0, SSS_WALK, 0, 0, 0};

    p.candidates = candidates;
    p.exits = exits;
    p.per_channel = per_channel;
    return p;
}

/* ---- Renderers as one writes them in an hour: floats, and no epsilon ---- */
typedef struct body {
    sss_vec3 centre, normal; /* a point of the plane and its normal; or the ball's centre */
    float radius;            /* 0: the half space below the plane */
    sss_vec3 entry, entry_normal;
} body;

static int trace_plane(const body *b, const sss_probe *p, sss_vec3 *y, sss_vec3 *n) {
    float t =
        scene_dot(b->normal, scene_sub(b->centre, p->origin)) / scene_dot(b->normal, p->direction);

    if (!(t >= 0.0f && t <= p->length)) return 0;
    *y = scene_along(p->origin, p->direction, t);
    *n = b->normal;
    return 1;
}

static int trace_ball(const body *b, const sss_probe *p, sss_vec3 *y, sss_vec3 *n) {
    sss_vec3 o = scene_sub(p->origin, b->centre);
    float half = scene_dot(o, p->direction), c = scene_dot(o, o) - b->radius * b->radius;
    float q = half * half - c;

    if (!(q > 0.0f)) return 0;
    float t = -half - sqrtf(q);
    if (!(t >= 0.0f)) t = -half + sqrtf(q);
    if (!(t >= 0.0f && t <= p->length)) return 0;
    *y = scene_along(p->origin, p->direction, t);
    *n = scene_sub(*y, b->centre);
    return 1;
}

static int lookup_body(const body *b, const sss_medium *m, const sss_plan *plan, uint32_t seed,
                       sss_exit *exits) {
    sss_resampler s;

    if (sss_begin(&s, m, plan, b->entry, b->entry_normal, seed) != SSS_OK) return -1;
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) {
        sss_vec3 y, n;
        int hit = b->radius > 0.0f ? trace_ball(b, &probe, &y, &n) : trace_plane(b, &probe, &y, &n);

        if (hit) sss_add_hit(&s, y, n, 1.0f);
    }
    return sss_finish(&s, exits);
}

static body half_space(void) {
    body b;

    memset(&b, 0, sizeof b);
    b.normal = scene_normalize(scene_vec(0.36f, -0.48f, 0.8f));
    b.entry_normal = b.normal;
    return b;
}
static body ball_of(float radius) {
    body b;

    memset(&b, 0, sizeof b);
    b.radius = radius;
    b.centre.z = -radius;
    b.entry_normal.z = 1.0f;
    return b;
}

typedef struct body_case {
    body b;
    sss_medium m;
    sss_plan plan;
} body_case;

static void walk_body(const void *context, uint32_t i, double sum[3]) {
    const body_case *k = (const body_case *)context;
    sss_exit exits[SSS_MAX_EXITS];
    int found = lookup_body(&k->b, &k->m, &k->plan, sss_hash(TEST_SEED, i), exits);

    for (int e = 0; e < found; ++e)
        for (int c = 0; c < 3; ++c) sum[c] += (double)exits[e].weight[c];
}

/* ---- The half space ---- */
static void check_albedo(float albedo, double aim, double limit) {
    float all[3] = {0.0f, 0.0f, 0.0f}, mfp[3] = {0.7f, 0.7f, 0.7f};
    long pilot = 2048;

    all[1] = albedo;
    body_case k;
    k.b = half_space();
    k.plan = walks(1, 1, 0);
    assert_int_equal(sss_burley_mfp(&k.m, all, mfp), SSS_OK);
    st_stat stat[3];
    memset(stat, 0, sizeof stat);
    estimate(walk_body, &k, 0, pilot, stat);
    estimate(walk_body, &k, pilot, (long)(1.2 * st_variance(&stat[1]) / (aim * aim)), stat);
    char name[80];
    snprintf(name, sizeof name, "half space, albedo %.4g", (double)albedo);
    check_at_most(name, st_error(&stat[1]), aim);
    check_near(name, stat[1].mean, (double)albedo, limit);
    if (factor > 1)
        print_message("    albedo %.4g: %+.5f +- %.5f\n", (double)albedo,
                      stat[1].mean - (double)albedo, st_error(&stat[1]));
}

static void half_space_has_its_albedo(void **state) {
    static const float albedos[20] = {0.01f, 0.05f, 0.1f, 0.15f, 0.2f,  0.25f, 0.3f,
                                      0.4f,  0.45f, 0.5f, 0.55f, 0.6f,  0.65f, 0.7f,
                                      0.75f, 0.8f,  0.9f, 0.95f, 0.99f, 0.999f};
    double aim = factor > 1 ? 1.8e-4 : 9e-4;
    int step = factor > 1 ? 1 : 2;

    (void)state;
    for (int i = step - 1; i < 20; i += step) check_albedo(albedos[i], aim, 2e-4 + 4.4 * aim);
}

/* All constructors give a volume: its half space has the medium's albedo, also if the channels
   differ in everything. */
static void every_medium_has_a_volume(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.2f}, length[3] = {1.0f, 0.6f, 0.3f};
    static const float absorbed[3] = {0.1f, 0.5f, 1.0f}, scattered[3] = {2.0f, 3.0f, 2.0f};
    static const char *const names[6] = {"sss_burley",       "sss_burley_mfp",
                                         "sss_dipole",       "sss_better_dipole",
                                         "dipole of albedo", "better dipole of albedo"};

    (void)state;
    for (int i = 0; i < 6; ++i) {
        body_case k;
        sss_result result = SSS_OK;

        k.b = half_space();
        k.plan = walks(1, 1, 0);
        if (i == 0) result = sss_burley(&k.m, albedo, length);
        if (i == 1) result = sss_burley_mfp(&k.m, albedo, length);
        if (i == 2) result = sss_dipole(&k.m, absorbed, scattered, 1.3f);
        if (i == 3) result = sss_better_dipole(&k.m, absorbed, scattered, 1.3f);
        if (i == 4) result = sss_dipole_from_albedo(&k.m, albedo, length, 1.3f);
        if (i == 5) result = sss_better_dipole_from_albedo(&k.m, albedo, length, 1.3f);
        assert_int_equal(result, SSS_OK);

        st_stat stat[3];
        memset(stat, 0, sizeof stat);
        estimate(walk_body, &k, 0, 40000 * factor, stat);
        for (int c = 0; c < 3; ++c)
            check_z(names[i], stat[c].mean, st_error(&stat[c]), (double)k.m.albedo[c], 2e-4,
                    Z_LIMIT);
        if (i == 0 || i >= 4) {
            walk_medium truth = walk_from_albedo(albedo, length);

            for (int c = 0; c < 3; ++c)
                check_relative(names[i], (double)k.m.extinction[c], truth.extinction[c], 1e-5);
        }
    }
}

/* ---- Nothing is lost in a white ball ---- */
static void white_ball_keeps_all_energy(void **state) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, grey[3] = {0.5f, 0.5f, 0.5f};
    static const float colours[3] = {0.5f, 0.3f, 1.0f};
    body_case k;

    (void)state;
    k.b = ball_of(1.5f);
    assert_int_equal(sss_burley_mfp(&k.m, white, grey), SSS_OK);
    for (uint32_t seed = 0; seed < 4000u; ++seed) {
        sss_plan plans[4];

        plans[0] = walks(1, 1, 0);
        sss_exit exits[SSS_MAX_EXITS];
        assert_int_equal(lookup_body(&k.b, &k.m, &plans[0], seed, exits), 1);
        for (int c = 0; c < 3; ++c) check_near("energy", (double)exits[0].weight[c], 1.0, 0.0);
        if (seed >= 400u) continue;
        plans[1] = walks(8, 1, 0);
        plans[2] = walks(13, 4, 0);
        plans[3] = walks(7, 0, 1);
        for (int e = 1; e < 4; ++e) {
            double sum = 0.0;
            int found = lookup_body(&k.b, &k.m, &plans[e], seed, exits);

            for (int c = 0; c < found; ++c) sum += (double)exits[c].weight[1];
            check_near("energy of several walks", sum, 1.0, 13 * 1.2e-7);
        }
    }

    /* Channels of their own: the sum over them of a walk's weights is 3, each has the mean 1. */
    assert_int_equal(sss_burley_mfp(&k.m, white, colours), SSS_OK);
    k.plan = walks(1, 1, 0);
    st_stat stat[3];
    memset(stat, 0, sizeof stat);
    estimate(walk_body, &k, 0, 40000 * factor, stat);
    for (int c = 0; c < 3; ++c)
        check_z("energy of a channel", stat[c].mean, st_error(&stat[c]), 1.0, 1e-6, Z_LIMIT);
    for (uint32_t seed = 0; seed < 4000u; ++seed) {
        sss_exit exit;
        double sum = 0.0;

        assert_int_equal(lookup_body(&k.b, &k.m, &k.plan, seed, &exit), 1);
        for (int c = 0; c < 3; ++c) sum += (double)exit.weight[c];
        check_near("energy over the channels", sum, 3.0, 1e-5);
    }
}

/* ---- The searchlight: what leaves between r0 and r1 ---- */
enum { RINGS = 6 };
static const double radius[RINGS + 1] = {0.01, 0.0316227766, 0.1, 0.316227766,
                                         1.0,  3.16227766,   10.0};

typedef struct ring_sums {
    st_stat ring[RINGS][3];
} ring_sums;

static void find_rings(const body_case *k, long count, ring_sums *all) {
    static ring_sums part[BLOCKS];

    memset(part, 0, sizeof part);
    memset(all, 0, sizeof *all);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        for (long i = b; i < count; i += BLOCKS) {
            sss_exit exit;
            uint32_t seed = sss_hash(TEST_SEED + 1u, (uint32_t)i);
            int found = lookup_body(&k->b, &k->m, &k->plan, seed, &exit);
            double distance = -1.0;

            if (found)
                distance = st_length(st_sum(st_double(exit.position), st_double(k->b.entry), -1.0));
            for (int ring = 0; ring < RINGS; ++ring) {
                int here = distance >= radius[ring] && distance < radius[ring + 1];

                for (int ch = 0; ch < 3; ++ch)
                    st_add(&part[b].ring[ring][ch], here ? (double)exit.weight[ch] : 0.0);
            }
        }
    }
    for (int b = 0; b < BLOCKS; ++b) {
        for (int r = 0; r < RINGS; ++r)
            for (int c = 0; c < 3; ++c) st_merge(&all->ring[r][c], &part[b].ring[r][c]);
    }
}

/* The sum of the table's bins within a ring, and its variance. `key` begins the rows. */
static double ring_of_table(const char *key, int ring, double *variance) {
    double energy = 0.0;
    FILE *f = fopen(DATA_DIR "/mc_searchlight.csv", "r");

    assert_non_null(f);
    *variance = 0.0;
    char line[512];
    while (fgets(line, sizeof line, f)) {
        if (strncmp(line, key, strlen(key)) != 0) continue;
        double v[4];
        if (sscanf(line + strlen(key), "%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2], &v[3]) != 4)
            continue;
        if (v[0] < radius[ring] * 0.999 || v[1] > radius[ring + 1] * 1.001) continue;
        energy += v[2];
        *variance += v[3] * v[3];
    }
    fclose(f);
    assert_true(energy > 0.0);
    return energy;
}

/* The albedo of the half space whose scatterings have this albedo, from the table. */
static float total_of_table(const char *alpha) {
    double total = 0.0;
    FILE *f = fopen(DATA_DIR "/exact_totals.csv", "r");

    assert_non_null(f);
    char key[32];
    snprintf(key, sizeof key, "%s,1.0,D,", alpha);
    char line[512];
    while (fgets(line, sizeof line, f))
        if (strncmp(line, key, strlen(key)) == 0) total = strtod(line + strlen(key), NULL);
    fclose(f);
    assert_true(total > 0.0);
    return (float)total;
}

static void searchlight_is_that_of_the_table(void **state) {
    static const char *const names[2][3] = {{"0.5", "0.8", "0.95"}, {"0.2", "0.9", "0.99"}};
    static const float mfp[3] = {1.0f, 1.0f, 1.0f};

    (void)state;
    for (int i = 0; i < 2; ++i) {
        static ring_sums sums;
        float albedo[3];

        for (int c = 0; c < 3; ++c) albedo[c] = total_of_table(names[i][c]);
        body_case k;
        k.b = half_space();
        k.plan = walks(1, 1, 0);
        assert_int_equal(sss_burley_mfp(&k.m, albedo, mfp), SSS_OK);
        find_rings(&k, 80000 * factor, &sums);
        for (int c = 0; c < 3; ++c) {
            for (int r = 0; r < RINGS; ++r) {
                const st_stat *s = &sums.ring[r][c];
                char key[64];

                snprintf(key, sizeof key, "%s,1,D,", names[i][c]);
                double variance;
                double energy = ring_of_table(key, r, &variance);
                snprintf(key, sizeof key, "albedo %s, r %g..%g", names[i][c], radius[r],
                         radius[r + 1]);

                /* The start inside moves what leaves within a hundredth of a mean free path. */
                check_z(key, s->mean, sqrt(st_variance(s) / s->n + variance), energy,
                        r == 0 ? 0.01 * energy : 1e-5, Z_LIMIT);
            }
        }
    }
}

/* ---- Scenes: the header's walk against the one in double precision, from the same entries ---- */
enum { ENTRIES = 64 };
typedef struct scene_case {
    scene s;
    walk_medium truth;
    sss_plan plan;
    int hinted;
    sss_vec3 position[ENTRIES], normal[ENTRIES];
    int shape[ENTRIES];
} scene_case;

static double light_at(sss_vec3 y) {
    return st_light_spot(st_vec3((double)y.x, (double)y.z, (double)y.y - 1.0));
}

static void find_entries(scene_case *k) {
    uint32_t counter = 0;

    for (int i = 0; i < ENTRIES; ++i) {
        scene_hit hit;
        sss_vec3 d;

        do {
            float x = 256.0f * (float)st_random(counter++);
            float y = 256.0f * (float)st_random(counter++);

            d = tracer_camera(&k->s, 256, 256, x, y);
            hit = scene_nearest(&k->s, k->s.eye, d, SCENE_NOTHING);
        } while (hit.shape < 0);
        k->position[i] = scene_along(k->s.eye, d, hit.t);
        k->shape[i] = hit.shape;
        k->normal[i] = scene_normal(&k->s.shape[hit.shape], k->position[i]);
    }
}

static void make_scene(int which, const float albedo[3], const float dmfp[3], float size,
                       scene_case *k) {
    scenes_optics optics = scenes_make(&k->s, which);

    k->hinted = 0;
    float length[3];
    for (int c = 0; c < 3; ++c) {
        if (albedo) optics.albedo[c] = albedo[c];
        length[c] = size * (dmfp ? dmfp[c] : optics.dmfp[c]);
    }
    k->plan = walks(1, 1, 0);
    k->truth = walk_from_albedo(optics.albedo, length);
    assert_int_equal(sss_burley(&k->s.medium, optics.albedo, length), SSS_OK);
    find_entries(k);
}

static void walk_truth(const void *context, uint32_t i, double sum[3]) {
    const scene_case *k = (const scene_case *)context;
    tracer_random random = tracer_random_begin(TEST_SEED, 11u, i);
    int e = (int)(i % ENTRIES);
    walk_exit exit;

    if (!walk_lookup(&k->s, &k->truth, k->position[e], k->normal[e], k->shape[e], &random, &exit))
        return;
    for (int c = 0; c < 3; ++c) sum[c] = (double)exit.weight[c] * light_at(exit.position);
}

/* What a renderer may do with the hits of a segment. */
enum { ALL, CLOSEST, FIRST_TWICE, BACKWARDS, LONG_NORMALS, RENDERERS };

static void give_hit(sss_resampler *s, const scene_case *k, const sss_probe *probe, scene_hit hit,
                     uint32_t seed, int renderer) {
    sss_vec3 y = scene_along(probe->origin, probe->direction, hit.t);
    sss_vec3 n = scene_normal(&k->s.shape[hit.shape], y);
    float light = 1.0f;

    if (renderer == LONG_NORMALS) n = scene_scale(n, ldexpf(1.0f, (int)(seed % 80u) - 40));

    /* In a unit of its own for each lookup, and not quite the light. */
    if (k->hinted)
        light = (float)((light_at(y) + 0.05) * (0.5 + st_random(sss_hash(seed, sssi_bits(y.x)))) *
                        exp2((double)(seed % 9u)));
    sss_add_hit(s, y, n, light);
}

static int lookup_scene(const scene_case *k, const sss_plan *plan, int entry, uint32_t seed,
                        int renderer, sss_exit *exits) {
    sss_vec3 n = k->normal[entry];

    if (renderer == LONG_NORMALS) n = scene_scale(n, 0.0078125f);
    sss_resampler s;
    if (sss_begin(&s, &k->s.medium, plan, k->position[entry], n, seed) != SSS_OK) return -1;
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) {
        scene_hits hits;

        scene_segment_hits(&k->s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; ++i) {
            int j = renderer == BACKWARDS ? hits.count - 1 - i : i;

            if (renderer == CLOSEST && i > 0) break;
            give_hit(&s, k, &probe, hits.hit[j], seed, renderer);
            if (renderer == FIRST_TWICE && i == 0)
                give_hit(&s, k, &probe, hits.hit[j], seed, renderer);
        }
    }
    return sss_finish(&s, exits);
}

static void walk_scene(const void *context, uint32_t i, double sum[3]) {
    const scene_case *k = (const scene_case *)context;
    sss_exit exits[SSS_MAX_EXITS];
    uint32_t seed = sss_hash(TEST_SEED + 2u, i);
    int found = lookup_scene(k, &k->plan, (int)(i % ENTRIES), seed, CLOSEST, exits);

    for (int e = 0; e < found; ++e) {
        for (int c = 0; c < 3; ++c)
            sum[c] += (double)exits[e].weight[c] * light_at(exits[e].position);
    }
}

static void scenes_agree_with_double_precision(void **state) {
    static const float grey_albedo[3] = {0.8f, 0.5f, 0.2f}, grey[3] = {0.5f, 0.5f, 0.5f};
    static const float sizes[] = {0.1f, 1.0f, 10.0f};
    static scene_case k;

    (void)state;
    for (int i = 0; i < 5 * 3 * 2; ++i) {
        int coloured = i % 2;

        make_scene(i / 6, coloured ? NULL : grey_albedo, coloured ? NULL : grey, sizes[i / 2 % 3],
                   &k);
        st_stat truth[3];
        memset(truth, 0, sizeof truth);
        st_stat mine[3];
        memset(mine, 0, sizeof mine);
        estimate(walk_truth, &k, 0, 12800 * factor, truth);
        estimate(walk_scene, &k, 0, 12800 * factor, mine);
        for (int c = 0; c < 3; ++c) {
            char name[80];

            snprintf(name, sizeof name, "%s, size %g, %s, channel %d", scenes_known[i / 6].name,
                     (double)sizes[i / 2 % 3], coloured ? "coloured" : "grey", c);

            /* The start inside: up to 2e-4 of the light. */
            check_z(name, mine[c].mean, hypot(st_error(&mine[c]), st_error(&truth[c])),
                    truth[c].mean, 2e-4 * truth[c].mean, Z_LIMIT);
        }
    }
}

/* ---- Plans: several walks, exits, hints, channels of all kinds ---- */
static void every_plan_has_the_same_mean(void **state) {
    static const float albedo[3] = {0.85f, 0.6f, 0.3f}, dmfp[3] = {0.6f, 0.3f, 0.1f};
    static const float lambert[3] = {0.6f, 0.3f, 0.0f}, black[3] = {0.85f, 0.0f, 0.3f};
    static const int plans[7][4] = {/* candidates, exits, per_channel, independent */
                                    {1, 1, 0, 0}, {2, 1, 0, 0}, {8, 1, 0, 1}, {7, 4, 0, 0},
                                    {2, 1, 1, 0}, {5, 0, 1, 1}, {3, 4, 0, 0}};
    static scene_case k;

    (void)state;
    make_scene(2, albedo, dmfp, 1.0f, &k);
    st_stat truth[3];
    memset(truth, 0, sizeof truth);
    estimate(walk_truth, &k, 0, 64000 * factor, truth);
    for (int i = 0; i < 21; ++i) {
        const int *p = plans[i % 7];
        int special = i / 7; /* 1: a Lambert channel, 2: a black one */
        const float *a = special == 2 ? black : albedo;
        double here = 0.0;

        assert_int_equal(sss_burley(&k.s.medium, a, special == 1 ? lambert : dmfp), SSS_OK);
        k.plan = walks(p[0], p[1], p[2]);
        k.plan.independent = p[3];
        k.hinted = i % 2;
        st_stat mine[3];
        memset(mine, 0, sizeof mine);
        estimate(walk_scene, &k, 0, 5120 * factor, mine);
        for (int c = 0; c < ENTRIES; ++c) here += light_at(k.position[c]) / ENTRIES;
        for (int c = 0; c < 3; ++c) {
            double expected = truth[c].mean, error = st_error(&truth[c]);

            if (special == 1 && c == 2) expected = (double)albedo[2] * here, error = 0.0;
            if (special == 2 && c == 1) expected = error = 0.0;
            char name[80];
            snprintf(name, sizeof name, "plan %d, media %d, channel %d", i % 7, special, c);
            if (expected == 0.0) check_near(name, mine[c].mean, 0.0, 0.0);
            else
                check_z(name, mine[c].mean, hypot(error, st_error(&mine[c])), expected,
                        2e-4 * expected, Z_LIMIT);
        }
    }
}

/* ---- Bounds ---- */
static void no_weight_exceeds_the_number_of_live_channels(void **state) {
    static const float albedo[4][3] = {
        {0.9f, 0.6f, 0.3f}, {0.05f, 0.99f, 0.99f}, {0.95f, 0.1f, 0.1f}, {0.9f, 0.0f, 0.3f}};
    static const float mfp[4][3] = {
        {1.0f, 0.5f, 0.2f}, {0.1f, 1.0f, 1.0f}, {1.0f, 0.3f, 0.1f}, {1.0f, 1.0f, 0.1f}};

    (void)state;
    for (int i = 0; i < 4; ++i) {
        sss_plan plan = walks(1, 1, 0);
        body b = ball_of(3.0f);
        float most = 0.0f, live = 0.0f;
        sss_medium m;

        assert_int_equal(sss_burley_mfp(&m, albedo[i], mfp[i]), SSS_OK);
        for (int c = 0; c < 3; ++c) live += albedo[i][c] > 0.0f;
#pragma omp parallel for reduction(max : most)
        for (int seed = 0; seed < 40000; ++seed) {
            sss_exit exit;
            int found = lookup_body(&b, &m, &plan, (uint32_t)seed, &exit);

            for (int k = 0; k < 3 && found; ++k)
                most = exit.weight[k] > most ? exit.weight[k] : most;
        }
        print_message("    albedo %g %g %g: weights up to %.3f of %g\n", (double)albedo[i][0],
                      (double)albedo[i][1], (double)albedo[i][2], (double)most, (double)live);
        check_at_most("weight of a walk", (double)most, (double)live * 1.00001);
    }
}

/* A renderer that never finds anything: every walk ends, and there is no exit. */
static void walks_without_a_surface_end(void **state) {
    static const float albedos[4][3] = {
        {1.0f, 1.0f, 1.0f}, {0.999f, 0.5f, 0.1f}, {0.9f, 0.9f, 0.9f}, {1e-30f, 0.0f, 1e-30f}};
    static const float mfp[3] = {1.0f, 0.5f, 0.25f};

    (void)state;
    for (int i = 0; i < 4; ++i) {
        sss_plan plan = walks(i < 2 ? 1 : 8, 1, 0);
        sss_vec3 x = {0.0f, 0.0f, 0.0f}, n = {0.0f, 0.0f, 1.0f};
        sss_medium m;
        long segments = 0;

        assert_int_equal(sss_burley_mfp(&m, albedos[i], mfp), SSS_OK);
        sss_resampler s;
        assert_int_equal(sss_begin(&s, &m, &plan, x, n, 1u), SSS_OK);
        sss_probe probe;
        while (sss_next_probe(&s, &probe)) {
            ++segments;
            if (!(probe.length > 0.0f && probe.length <= FLT_MAX))
                fail_msg("segment %ld", segments);
            check_at_most("segments", (double)segments, 8.0 * SSSI_MAX_SCATTERINGS);
        }
        assert_int_equal(sss_next_probe(&s, &probe), 0);
        sss_exit exit;
        assert_int_equal(sss_finish(&s, &exit), 0);
        print_message("    albedo %g: %ld segments\n", (double)albedos[i][0], segments);
    }
}

/* Mean free paths down to far below an ulp of the coordinates: no light is right there, but every
   walk ends: at albedo .9 a scattering takes .2 %, so none has 1e5 of them. */
static void walks_end_where_floats_do(void **state) {
    static const float albedo[3] = {0.9f, 0.5f, 0.2f};
    static const float lengths[] = {1e-4f, 1e-6f, 1e-8f, 1e-12f};
    sss_vec3 x = {0.3f, 0.5f, 0.7f}, n = {0.36f, 0.48f, 0.8f};

    (void)state;
    for (int i = 0; i < 4; ++i) {
        float mfp[3];
        body b = i % 2 ? half_space() : ball_of(0.5f);
        long most = 0;

        for (int c = 0; c < 3; ++c) mfp[c] = lengths[i] * (float)(1 + c);
        sss_medium m;
        assert_int_equal(sss_burley_mfp(&m, albedo, mfp), SSS_OK);
        b.centre = b.radius > 0.0f ? scene_along(x, n, -b.radius) : x;
        b.normal = n;
        for (uint32_t seed = 0; seed < 2000u; ++seed) {
            sss_plan plan = walks(1, 1, 0);
            sss_resampler s;
            long segments = 0;

            assert_int_equal(sss_begin(&s, &m, &plan, x, n, seed), SSS_OK);
            sss_probe probe;
            while (sss_next_probe(&s, &probe)) {
                sss_vec3 y, normal;
                int hit = b.radius > 0.0f ? trace_ball(&b, &probe, &y, &normal)
                                          : trace_plane(&b, &probe, &y, &normal);

                if (hit) sss_add_hit(&s, y, normal, 1.0f);
                check_at_most("segments of a walk", (double)++segments, 1e5);
            }
            most = segments > most ? segments : most;
        }
        print_message("    mean free path %g: at most %ld segments\n", (double)lengths[i], most);
    }
}

/* ---- Renderers: all of them give the bits of the one that finds the closest hit alone ---- */
static void renderers_give_the_same_bits(void **state) {
    static scene_case k;
    long compared = 0;

    (void)state;
    for (int i = 0; i < 4; ++i) {
        make_scene(i + 1, NULL, NULL, 1.0f, &k);
        for (uint32_t seed = 0; seed < 600u; ++seed) {
            sss_plan plan = walks(1 + (int)seed % 4, 1 + (int)seed % 2, 0);
            sss_exit closest[SSS_MAX_EXITS], exits[SSS_MAX_EXITS];
            int entry = (int)(seed % ENTRIES);
            int found = lookup_scene(&k, &plan, entry, seed, CLOSEST, closest);

            for (int r = 0; r < RENDERERS; ++r) {
                check_equal("exits", lookup_scene(&k, &plan, entry, seed, r, exits), found);
                for (int e = 0; e < found; ++e) {
                    assert_memory_equal(&exits[e].position, &closest[e].position, 12);
                    for (int c = 0; c < 3; ++c)
                        assert_true(sssi_bits(exits[e].weight[c]) ==
                                    sssi_bits(closest[e].weight[c]));

                    /* The frame may turn by a rounding where the normal has another length. */
                    if (r != LONG_NORMALS)
                        assert_memory_equal(&exits[e].normal, &closest[e].normal, 12);
                    ++compared;
                }
            }
        }
    }
    print_message("    %ld exits of %d renderers\n", compared, RENDERERS);
    check_at_least("exits", (double)compared, 5000.0);
}

/* A hit without light ends its walk, a bad hit is none; no NaN comes out. */
static void odd_hits_are_harmless(void **state) {
    static const float lights[] = {0.0f, -1.0f, NAN, INFINITY, -INFINITY};
    static const float albedo[3] = {0.95f, 0.6f, 0.3f}, mfp[3] = {1.0f, 0.5f, 0.2f};
    body b = ball_of(2.0f);
    sss_medium m;

    (void)state;
    assert_int_equal(sss_burley_mfp(&m, albedo, mfp), SSS_OK);
    for (uint32_t seed = 0; seed < 3000u; ++seed) {
        sss_plan plan = walks(2, 1, (int)seed % 2);
        sss_vec3 bad = {NAN, 0.0f, 0.0f}, far_away = {INFINITY, 0.0f, 0.0f},
                 none = {0.0f, 0.0f, 0.0f};
        sss_resampler s;
        int dark = (int)(seed % 3u), starts = 0, hits = 0;

        assert_int_equal(sss_begin(&s, &m, &plan, b.entry, b.entry_normal, seed), SSS_OK);
        sss_add_hit(&s, b.entry, b.entry_normal, 1.0f); /* before any segment */
        sss_probe probe;
        while (sss_next_probe(&s, &probe)) {
            ++starts;
            sss_add_hit(&s, bad, b.entry_normal, 1.0f);
            sss_add_hit(&s, far_away, b.entry_normal, 1.0f);
            sss_add_hit(&s, b.entry, none, 1.0f);
            sss_add_hit(&s, b.entry, bad, 1.0f);
            sss_vec3 y, n;
            if (!trace_ball(&b, &probe, &y, &n)) continue;
            ++hits;
            sss_add_hit(&s, y, n, dark ? lights[seed / 3u % 5u] : 1.0f);
        }
        check_at_most("surfaces met by two walks", hits, 2.0);
        sss_exit exits[SSS_MAX_EXITS];
        int found = sss_finish(&s, exits);
        if (dark) {
            check_equal("exits without light", found, 0);
            continue;
        }
        sss_exit plain[SSS_MAX_EXITS];
        check_equal("exits", found, lookup_body(&b, &m, &plan, seed, plain));
        for (int c = 0; c < 3 && found; ++c) {
            assert_true(sssi_bits(exits[0].weight[c]) == sssi_bits(plain[0].weight[c]));
            assert_true(exits[0].weight[c] >= 0.0f);
        }
    }
}

/* ---- Far from the origin: the same walks there and here, the renderer without any epsilon. The
   header promises for coordinates of 1e4 lengths a mean right to .1 %, and at 1e5 to 1 %. ---- */
typedef struct pair_case {
    body_case near_by, far_off;
} pair_case;

static void walk_pair(const void *context, uint32_t i, double sum[3]) {
    const pair_case *k = (const pair_case *)context;
    double other[3] = {0.0, 0.0, 0.0};

    walk_body(&k->near_by, i, other);
    walk_body(&k->far_off, i, sum);
    for (int c = 0; c < 3; ++c) sum[c] -= other[c];
}

static body moved(body b, float distance) {
    sss_vec3 move = scene_vec(0.7f * distance, 0.5f * distance, -distance);

    b.entry = scene_add(b.entry, move);
    b.centre = scene_add(b.centre, move);
    return b;
}

static void far_from_the_origin(void **state) {
    static const float albedo[3] = {0.9f, 0.7f, 0.5f}, mfp[3] = {1.0f, 1.0f, 1.0f};
    static const float distances[] = {100.0f, 1e3f, 1e4f,
                                      1e5f}; /* of the entry, in mean free paths */
    static const double limits[] = {1e-3, 1e-3, 1e-3, 1e-2};

    (void)state;
    for (int i = 0; i < 3; ++i) {
        for (int d = 0; d < 4; ++d) {
            pair_case k;

            k.near_by.b = i == 0 ? half_space() : ball_of(i == 1 ? 3.0f : 300.0f);
            k.near_by.plan = walks(1, 1, 0);
            assert_int_equal(sss_burley_mfp(&k.near_by.m, albedo, mfp), SSS_OK);
            k.far_off = k.near_by;
            k.far_off.b = moved(k.near_by.b, distances[d]);
            st_stat near_by[3];
            memset(near_by, 0, sizeof near_by);
            st_stat change[3];
            memset(change, 0, sizeof change);
            estimate(walk_body, &k.near_by, 0, 4096, near_by);
            estimate(walk_pair, &k, 0, 8192 * factor, change);
            for (int c = 0; c < 3; ++c) {
                double mean = near_by[c].mean;
                char name[80];

                snprintf(name, sizeof name, "%s, %g mean free paths from the origin, channel %d",
                         i == 0   ? "half space"
                         : i == 1 ? "ball of 3"
                                  : "ball of 300",
                         (double)distances[d], c);
                if (d >= 2)
                    print_message("    %s: %+.3f %% +- %.3f\n", name, 100.0 * change[c].mean / mean,
                                  100.0 * st_error(&change[c]) / mean);
                check_z(name, change[c].mean, st_error(&change[c]), 0.0, limits[d] * mean, Z_LIMIT);
            }
        }
    }
}

/* A ball that touches the world's origin: entries near it have small coordinates, but the
   renderer's own errors are those of the ball's size. So large a ball is a half space. (At 9e4 mean
   free paths this renderer is 1.4 % off.) */
static void ball_that_touches_the_origin(void **state) {
    static const float radii[] = {1e3f, 1e4f}; /* mean free paths */
    static const float albedo[3] = {0.9f, 0.7f, 0.5f}, mfp[3] = {1.0f, 1.0f, 1.0f};

    (void)state;
    for (int i = 0; i < 2; ++i) {
        st_stat stat[3];

        memset(stat, 0, sizeof stat);
        for (int j = 0; j < 8; ++j) {
            double R = (double)radii[i], x = 1e-3 * R * st_signed(2u * (uint64_t)j);
            double y = 1e-3 * R * st_signed(2u * (uint64_t)j + 1u), q = x * x + y * y;
            body_case k;

            k.b = ball_of(radii[i]);
            k.plan = walks(1, 1, 0);
            k.b.entry = st_float(st_vec3(x, y, -q / (R + sqrt(R * R - q))));
            k.b.entry_normal = scene_sub(k.b.entry, k.b.centre);
            assert_int_equal(sss_burley_mfp(&k.m, albedo, mfp), SSS_OK);
            estimate(walk_body, &k, 4000 * factor * j, 4000 * factor, stat);
        }
        for (int c = 0; c < 3; ++c) {
            char name[80];

            /* Curvature of 1e-3, and a few walks that end where they start. */
            snprintf(name, sizeof name, "ball of %g at the origin, channel %d", (double)radii[i],
                     c);
            check_z(name, stat[c].mean, st_error(&stat[c]), (double)albedo[c], 2e-3, Z_LIMIT);
        }
    }
}

/* ---- SSS_LAMBERT: no probes, one exit at the entry ---- */
static void lambert_needs_no_probes(void **state) {
    static const float albedo[3] = {0.9f, 0.0f, 0.3f}, length[3] = {1.0f, 0.5f, 0.0f};
    static const float black[3] = {0.0f, 0.0f, 0.0f}, some[3] = {1.0f, 2.0f, 3.0f};
    sss_vec3 x = {1.0f, 2.0f, 3.0f}, n = {0.0f, 3.0f, 4.0f};

    (void)state;
    for (int i = 0; i < 7; ++i) {
        sss_medium m;
        sss_result result = SSS_OK;

        if (i == 0) result = sss_burley(&m, albedo, length);
        if (i == 1) result = sss_burley_mfp(&m, albedo, some);
        if (i == 2) result = sss_dipole(&m, some, some, 1.4f);
        if (i == 3) result = sss_better_dipole(&m, black, some, 1.0f);
        if (i == 4) result = sss_dipole_from_albedo(&m, albedo, length, 1.4f);
        if (i == 5) result = sss_better_dipole_from_albedo(&m, albedo, some, 1.4f);
        if (i == 6) result = sss_burley(&m, black, some);
        assert_int_equal(result, SSS_OK);
        for (int k = 0; k < 40; ++k) {
            sss_plan plan = {k % 10, k % 2, SSS_LAMBERT, k % 3, k % 2, k};
            sss_resampler s;

            assert_int_equal(sss_begin(&s, &m, &plan, x, n, (uint32_t)k), SSS_OK);
            sss_probe probe;
            assert_int_equal(sss_next_probe(&s, &probe), 0);
            sss_add_hit(&s, n, x, 1.0f); /* of no probe */
            sss_exit exits[SSS_MAX_EXITS];
            check_equal("exits", sss_finish(&s, exits), i < 6);
            if (i == 6) continue;
            assert_int_equal(exits[0].hit, -1);
            check_near("mass", (double)exits[0].mass, 0.0, 0.0);
            assert_memory_equal(&exits[0].position, &x, 12);
            check_near("normal", (double)exits[0].normal.z, 0.8, 1e-7);
            for (int c = 0; c < 3; ++c)
                check_near("weight", (double)exits[0].weight[c], (double)m.albedo[c], 0.0);
        }
    }
}

/* Walks and Lambert stand alone. */
static void mixtures_are_refused(void **state) {
    static const float albedo[3] = {0.9f, 0.5f, 0.3f}, length[3] = {1.0f, 0.5f, 0.2f};
    sss_vec3 x = {1.0f, 2.0f, 3.0f}, n = {0.0f, 3.0f, 4.0f};
    sss_medium m;

    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    for (unsigned bits = 0; bits < 130u; ++bits) {
        sss_plan plan = {0, 0, bits, 0, 0, 0};
        sss_resampler s;
        int fine = bits <= SSS_WALK || bits == SSS_LAMBERT;

        check_equal("result", sss_begin(&s, &m, &plan, x, n, 1u), fine ? SSS_OK : SSS_BAD_PLAN);
        if (fine) continue;
        sss_probe probe;
        assert_int_equal(sss_next_probe(&s, &probe), 0);
        sss_exit exit;
        assert_int_equal(sss_finish(&s, &exit), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_space_has_its_albedo),
        cmocka_unit_test(every_medium_has_a_volume),
        cmocka_unit_test(white_ball_keeps_all_energy),
        cmocka_unit_test(searchlight_is_that_of_the_table),
        cmocka_unit_test(scenes_agree_with_double_precision),
        cmocka_unit_test(every_plan_has_the_same_mean),
        cmocka_unit_test(no_weight_exceeds_the_number_of_live_channels),
        cmocka_unit_test(walks_without_a_surface_end),
        cmocka_unit_test(walks_end_where_floats_do),
        cmocka_unit_test(renderers_give_the_same_bits),
        cmocka_unit_test(odd_hits_are_harmless),
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(ball_that_touches_the_origin),
        cmocka_unit_test(lambert_needs_no_probes),
        cmocka_unit_test(mixtures_are_refused),
    };

    if (st_is_long()) factor = 10;
    return cmocka_run_group_tests_name("walk", tests, NULL, st_report);
}
