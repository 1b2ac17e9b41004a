/* The promise: the ends of what is allowed are like the middle. Lengths over 24 orders of
   magnitude, albedo 1, indices of refraction from 0.2 to 5, saturated colours, an entry far from
   the origin, 1 and 256 candidates, all exits: the mean over seeds is the integral, and no channel
   is noisier than the target of all channels makes it. (Identical picks at scales 2^-40 to 2^40:
   test_invariance.c. No NaN, no infinity, the bound: test_fuzz.c.)

   On a plane at E = 1 the integral is the albedo. Comparisons of means: 192. At |z| < 5.0 the
   chance that a correct header fails here is 192 * 5.7e-7 = 1e-4. The least sharp sees a bias
   of 1.3 % every other time and one of 2 % always; in make test, which takes an eighth of the
   lookups, 2.8 times that. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT 5.0
#define BLOCKS  64

static const sss_plan standard = {0, 0, 0u, 0, 0, 0};
static int measured = 0;

/* What is lit, and what hint the lookups get; NULL: none. */
typedef struct lighting {
    st_light *light;
    st_hint *hint;
} lighting;
static const lighting everywhere = {st_light_one, NULL};

typedef struct means {
    st_stat channel[3];
    st_stat variance[3]; // relative, of blocks
    int bad;             // weights that are not finite or negative
} means;

static void run_block(const st_fixture *f, const sss_medium *m, const sss_plan *plan,
                      const lighting *l, uint32_t first, int lookups, means *to) {
    memset(to, 0, sizeof *to);
    sss_exit exits[SSS_MAX_EXITS];
    for (int i = 0; i < lookups; ++i) {
        int n = st_lookup(f, m, plan, sss_hash(TEST_SEED + (uint32_t)measured, first + (uint32_t)i),
                          l->hint, exits);
        for (int c = 0; c < 3; ++c) {
            double sum = 0.0;
            for (int e = 0; e < n; ++e) {
                to->bad += !(exits[e].weight[c] >= 0.0f && exits[e].weight[c] <= FLT_MAX);
                sum +=
                    (double)exits[e].weight[c] * l->light(st_local(&f->frame, exits[e].position));
            }
            st_add(&to->channel[c], sum);
        }
    }
}
static means run(const st_fixture *f, const sss_medium *m, const sss_plan *plan, const lighting *l,
                 int lookups) {
    static means blocks[BLOCKS];
    int each = st_samples(lookups) / BLOCKS;
    ++measured;
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b)
        run_block(f, m, plan, l, (uint32_t)(b * each), each, &blocks[b]);
    means all;
    memset(&all, 0, sizeof all);
    for (int b = 0; b < BLOCKS; ++b) {
        all.bad += blocks[b].bad;
        for (int c = 0; c < 3; ++c) {
            st_merge(&all.channel[c], &blocks[b].channel[c]);
            st_add(&all.variance[c], st_relative_variance(&blocks[b].channel[c]));
        }
    }
    return all;
}
/* The means of a plane's lookups are the medium's albedos; `rounding` is relative. */
static void check_plane(const char *name, const sss_medium *m, const sss_plan *plan, st_frame frame,
                        double rounding, int lookups) {
    st_fixture plane = st_standard(ST_PLANE, frame);
    means all = run(&plane, m, plan, &everywhere, lookups);
    check_equal(name, all.bad, 0);
    for (int c = 0; c < 3; ++c) {
        double albedo = (double)m->albedo[c];
        check_z(name, all.channel[c].mean, st_error(&all.channel[c]), albedo, rounding * albedo,
                Z_LIMIT);
    }
}
typedef sss_result constructor(sss_medium *m, const float a[3], const float b[3], float eta);
static sss_result burley(sss_medium *m, const float a[3], const float b[3], float eta) {
    (void)eta;
    return sss_burley(m, a, b);
}
static constructor *const by_albedo[3] = {burley, sss_dipole_from_albedo,
                                          sss_better_dipole_from_albedo};
static const char *const names[3] = {"Burley", "dipole", "better dipole"};

static sss_medium grey(int type, float albedo, float length, float eta) {
    float a[3];
    a[0] = a[1] = a[2] = albedo;
    float b[3];
    b[0] = b[1] = b[2] = length;
    sss_medium m;
    assert_int_equal(by_albedo[type](&m, a, b, eta), SSS_OK);
    return m;
}

static void lengths_over_24_orders_of_magnitude(void **state) {
    (void)state;
    for (int type = 0; type < 3; ++type)
        for (int k = -12; k <= 12; k += 4) {
            sss_medium m = grey(type, 0.8f, (float)pow(10.0, k), 1.3f);
            check_plane(names[type], &m, &standard, st_stay(), 1e-5, 64000);
        }
}
/* In one medium. Chords take all of the 24 orders of magnitude; the lines of spheres are as wide as
   the widest channel, and float32 puts their hits at 1e-7 of that. So the default plan is good for
   lengths 1e5 apart. */
static void lengths_far_apart(void **state) {
    static const float albedo[3] = {0.9f, 0.5f, 0.7f}, all[3] = {1e12f, 1.0f, 1e-12f},
                       some[3] = {1e12f, 3e9f, 1e7f};
    const sss_plan chords = {8, 1, SSS_CHORD, 0, 0, 0};
    (void)state;
    for (int type = 0; type < 3; ++type) {
        sss_medium m;
        assert_int_equal(by_albedo[type](&m, albedo, all, 1.3f), SSS_OK);
        check_plane(names[type], &m, &chords, st_stay(), 1e-5, 320000);
        assert_int_equal(by_albedo[type](&m, albedo, some, 1.3f), SSS_OK);
        check_plane(names[type], &m, &standard, st_stay(), 1e-5, 320000);
    }
}
/* One exit drawn exactly from the mean of three channels has in each of them a relative variance of
   at most 1/q - 1 = 2, q = 1/3 the channel's part. M candidates add 1 / M of what one candidate has
   above that (Talbot et al. 2005), which is measured too. */
static void saturated_colours(void **state) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, length[3] = {10.0f, 0.1f, 0.001f};
    const st_fixture plane = st_standard(ST_PLANE, st_stay());
    const sss_plan one = {1, 1, 0u, 0, 0, 0};
    (void)state;
    for (int type = 0; type < 3; ++type) {
        sss_medium m;
        assert_int_equal(by_albedo[type](&m, albedo, length, 1.3f), SSS_OK);
        check_plane(names[type], &m, &standard, st_stay(), 1e-5, 320000);
        means single = run(&plane, &m, &one, &everywhere, 320000);
        means all = run(&plane, &m, &standard, &everywhere, 320000);
        for (int c = 0; c < 3; ++c) {
            double v1 = single.variance[c].mean, v8 = all.variance[c].mean,
                   error = st_error(&all.variance[c]);
            print_message(
                "    %s, length %g: relative variance %.3f +- %.3f, of one candidate %.2f\n",
                names[type], (double)length[c], v8, error, v1);
            check_at_most("relative variance of a saturated channel", v8,
                          2.0 + fmax(v1 - 2.0, 0.0) / 8.0 +
                              Z_LIMIT * hypot(error, st_error(&single.variance[c]) / 8.0));
        }
    }
}
static void albedo_of_one(void **state) {
    static const float none[3] = {0.0f, 0.0f, 0.0f}, some[3] = {2.0f, 1.0f, 0.5f};
    static const float one[3] = {1.0f, 0.0f, 1.0f};
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, one, some), SSS_OK);
    check_plane("Burley at 1 and 0", &m, &standard, st_stay(), 1e-5, 64000);
    assert_int_equal(sss_dipole(&m, none, some, 1.4f), SSS_OK);
    check_near("albedo of a dipole without absorption", (double)m.albedo[0], 1.0, 1e-6);
    check_plane("a dipole without absorption", &m, &standard, st_stay(), 1e-5, 160000);
    assert_int_equal(sss_better_dipole(&m, none, some, 1.4f), SSS_OK);
    check_near("albedo of a better dipole without absorption", (double)m.albedo[0], 1.0, 1e-6);
    check_plane("a better dipole without absorption", &m, &standard, st_stay(), 1e-5, 160000);
}
static void indices_of_refraction(void **state) {
    static const float eta[] = {0.2f, 0.8f, 0.99999994f, 1.0f, 1.00000012f, 1.33f, 5.0f};
    (void)state;
    for (int type = 1; type < 3; ++type)
        for (int i = 0; i < 7; ++i) {
            sss_medium m = grey(type, 0.8f, 1.0f, eta[i]);
            check_plane(names[type], &m, &standard, st_stay(), 1e-5, 64000);
        }
}
/* float32 resolves 2^-7 there, hits are off by half of it. Those nearer than 16 such errors, which
   is `within` of the light, weigh anything up to the bound, here 8 albedos; of the others the
   errors average out. */
static void far_from_the_origin(void **state) {
    const st_frame far = st_motion(st_vec3(0.61, -0.37, 0.83), 2.345, st_vec3(1e5, -1e5, 1e5));
    (void)state;
    for (int type = 0; type < 3; ++type) {
        sss_medium m = grey(type, 0.8f, 300.0f, 1.3f);
        double near_by = (double)sss_within(&m, 0, 16.0f / 256.0f) / 0.8;
        check_plane(names[type], &m, &standard, far, 8.0 * near_by, 320000);
    }
}
static void many_and_few(void **state) {
    st_fixture ball = st_standard(ST_SPHERE, st_moved());
    static const int candidates[] = {1, 2, SSS_MAX_CANDIDATES};
    (void)state;
    for (int i = 0; i < 3; ++i)
        for (int exits = 1; exits <= SSS_MAX_EXITS; ++exits) {
            sss_medium m = grey(0, 0.8f, 3.0f, 1.0f);
            st_profile p = st_burley((double)0.8f, 3.0);
            sss_plan plan = {0, 0, 0u, 0, 0, 0};
            plan.candidates = candidates[i];
            plan.exits = exits;
            means all = run(&ball, &m, &plan, &everywhere, 2560000 / (4 + candidates[i]));
            check_equal("weights", all.bad, 0);
            check_z("1, 2 and 256 candidates", all.channel[0].mean, st_error(&all.channel[0]),
                    st_truth(&ball, &p, st_light_one), 1e-5, Z_LIMIT);
        }
}

/* ---- Light that vanishes: the half plane x > 0 is bright. A hint of 0 drops a hit, which is exact
   where no light comes; where light comes it is lost, and a comparison with the truth sees
   it. ---- */
static double half_lit(st_vec y) { return y.x > 0.0 ? 1.0 : 0.0; }
static double mostly_lit(st_vec y) { return y.x > 0.0 ? 1000.0 : 1.0; }
static float hint_right(st_vec y, uint32_t seed, int i) {
    return (void)seed, (void)i, y.x > 0.0 ? 1.0f : 0.0f;
}
static float hint_wrong(st_vec y, uint32_t seed, int i) {
    return (void)seed, (void)i, y.x > 0.0 ? 0.0f : 1.0f;
}
static float hint_nothing(st_vec y, uint32_t seed, int i) {
    return (void)y, (void)seed, (void)i, 0.0f;
}

static void light_that_vanishes(void **state) {
    static const struct {
        const char *name;
        lighting lighting;
        double expected, truth; // of an albedo of 1
    } cases[] = {{"0 on the dark half", {half_lit, hint_right}, 0.5, 0.5},
                 {"0 on a lit half", {st_light_one, hint_wrong}, 0.5, 1.0},
                 {"0 on the bright half", {mostly_lit, hint_wrong}, 0.5, 500.5},
                 {"0 on all that is lit", {half_lit, hint_wrong}, 0.0, 0.5},
                 {"0 on all", {st_light_one, hint_nothing}, 0.0, 1.0}};
    const st_fixture plane = st_standard(ST_PLANE, st_stay());
    (void)state;
    for (int type = 0; type < 3; ++type)
        for (int i = 0; i < 5; ++i)
            for (int exits = 1; exits <= SSS_MAX_EXITS; exits += 3) {
                sss_medium m = grey(type, 0.8f, 1.0f, 1.3f);
                sss_plan plan = standard;
                double albedo = (double)0.8f;
                plan.exits = exits;
                means all = run(&plane, &m, &plan, &cases[i].lighting, 64000);
                check_equal(cases[i].name, all.bad, 0);
                check_z(cases[i].name, all.channel[0].mean, st_error(&all.channel[0]),
                        cases[i].expected * albedo, 1e-5, Z_LIMIT);
                double z =
                    fabs(all.channel[0].mean - cases[i].truth * albedo) / st_error(&all.channel[0]);
                if (i > 0 && !(z > Z_LIMIT))
                    fail_msg("%s: light was lost, and z is %.2f", cases[i].name, z);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lengths_over_24_orders_of_magnitude),
        cmocka_unit_test(lengths_far_apart),
        cmocka_unit_test(saturated_colours),
        cmocka_unit_test(albedo_of_one),
        cmocka_unit_test(indices_of_refraction),
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(many_and_few),
        cmocka_unit_test(light_that_vanishes),
    };
    return cmocka_run_group_tests_name("extremes", tests, NULL, st_report);
}
