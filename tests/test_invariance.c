/* The promise: what does not matter, does not matter. Scaling the scene by a power of two, flipping
   normals or giving them another length changes no pick and no weight; motions and the order of the
   colours change no mean.

   Comparisons of means: 24. At |z| < 4.9 the chance that a correct header fails here is 24 * 9.6e-7
   = 2e-5. Each mean is known to 0.15 % or better: a bias of 1 % of one against the other gives z
   > 5. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT 4.9
#define BLOCKS  64
#define LOOKUPS 300
#define MEDIA   3

static const unsigned sets[] = {0u, SSS_CHORD,
                                SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD};

static sss_vec3 times(sss_vec3 v, float k) {
    v.x *= k;
    v.y *= k;
    v.z *= k;
    return v;
}

/* ---- Scale ---- */
/* All that is allowed is 1e-12 to 1e12, a little less than 2^-40 to 2^40, so there are two sets of
   each: one to be made shorter and one to be made longer. */
static sss_result make_medium(sss_medium *m, int type, int up, int k) {
    static const float albedo[3] = {0.9f, 0.5f, 0.7f};
    static const float length[2][3] = {{1.2f, 3.1f, 77.0f}, {0.85f, 0.31f, 0.012f}};
    static const float absorbs[2][3] = {{0.01f, 0.03f, 0.0005f}, {2.1f, 1.2f, 30.0f}};
    static const float scatters[2][3] = {{0.8f, 0.3f, 0.02f}, {40.0f, 9.0f, 900.0f}};
    float a[3], b[3];
    for (int c = 0; c < 3; ++c) {
        a[c] = type == 1 ? ldexpf(absorbs[up][c], -k) : albedo[c];
        b[c] = type == 1 ? ldexpf(scatters[up][c], -k) : ldexpf(length[up][c], k);
    }
    if (type == 0) return sss_burley(m, a, b);
    return type == 1 ? sss_dipole(m, a, b, 1.4f) : sss_better_dipole_from_albedo(m, a, b, 1.4f);
}
/* The hits of a lookup at scale 1, and what came of them. */
typedef struct record {
    sss_probe probe[64];
    st_hit hit[64][ST_MAX_HITS];
    int probes, hits[64], exits;
    sss_exit exit[SSS_MAX_EXITS];
} record;
static void record_lookup(const st_fixture *f, const sss_medium *m, const sss_plan *plan,
                          uint32_t seed, record *r) {
    sss_vec3 x, n;
    st_entry(f, &x, &n);
    sss_resampler s;
    assert_int_equal(sss_begin(&s, m, plan, x, n, seed), SSS_OK);
    for (r->probes = 0; sss_next_probe(&s, &r->probe[r->probes]); ++r->probes) {
        st_hit *hit = r->hit[r->probes];
        r->hits[r->probes] = st_trace(f, &r->probe[r->probes], hit);
        for (int i = 0; i < r->hits[r->probes]; ++i)
            sss_add_hit(&s, hit[i].position, hit[i].normal, 1.0f);
    }
    r->exits = sss_finish(&s, r->exit);
}
static void compare_scaled(const st_fixture *f, const sss_medium *m, const sss_plan *plan,
                           uint32_t seed, int k, const record *r) {
    char name[80];
    int bad = 0;
    snprintf(name, sizeof name, "scale 2^%d, techniques %u, %s", k, plan->techniques,
             st_kind_name(f->kind));
    sss_vec3 x, n;
    st_entry(f, &x, &n);
    sss_resampler s;
    assert_int_equal(sss_begin(&s, m, plan, st_scaled(x, k), n, seed), SSS_OK);
    sss_probe probe;
    int i;
    for (i = 0; sss_next_probe(&s, &probe); ++i) {
        if (i >= r->probes) fail_msg("%s: too many probes", name);
        bad += !st_same_bits(probe.origin, st_scaled(r->probe[i].origin, k));
        bad += !st_same_bits(probe.direction, r->probe[i].direction);
        bad += probe.length != ldexpf(r->probe[i].length, k);
        for (int j = 0; j < r->hits[i]; ++j)
            sss_add_hit(&s, st_scaled(r->hit[i][j].position, k), r->hit[i][j].normal, 1.0f);
    }
    check_equal(name, i, r->probes);
    sss_exit exit[SSS_MAX_EXITS];
    int exits = sss_finish(&s, exit);
    check_equal(name, exits, r->exits);
    for (i = 0; i < exits; ++i) {
        bad += !st_same_bits(exit[i].position, st_scaled(r->exit[i].position, k));
        bad += !st_same_bits(exit[i].normal, r->exit[i].normal);
        bad += memcmp(exit[i].weight, r->exit[i].weight, sizeof exit[i].weight) != 0;
    }
    check_equal(name, bad, 0);
}
static void scaling_by_powers_of_two_changes_no_bit(void **state) {
    static record r;
    (void)state;
    for (int type = 0; type < MEDIA; ++type)
        for (int up = 0; up < 2; ++up)
            for (int t = 0; t < 3; ++t) {
                st_fixture f = st_standard(t == 0   ? ST_SPHERE
                                           : t == 1 ? ST_STACK
                                                    : ST_EDGE,
                                           st_moved());
                sss_plan plan = {7, 2, 0u, 0, 0, 0};
                plan.techniques = sets[t];
                sss_medium m;
                assert_int_equal(make_medium(&m, type, up, 0), SSS_OK);
                sss_medium small;
                for (uint32_t seed = 0; seed < LOOKUPS; ++seed) {
                    record_lookup(&f, &m, &plan, sss_hash(TEST_SEED, seed), &r);
                    for (int k = up ? 1 : -40; k <= (up ? 40 : -1); k += seed % 8 == 0 ? 1 : 13) {
                        assert_int_equal(make_medium(&small, type, up, k), SSS_OK);
                        compare_scaled(&f, &small, &plan, sss_hash(TEST_SEED, seed), k, &r);
                    }
                }
            }
}

/* ---- Normals ---- */
static int lookup_with_normals(const st_fixture *f, const sss_medium *m, uint32_t seed,
                               float factor, float entry, sss_exit *exits) {
    const sss_plan plan = {8, 2, SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD, 0, 0, 0};
    sss_vec3 x, n;
    st_entry(f, &x, &n);
    sss_resampler s;
    assert_int_equal(sss_begin(&s, m, &plan, x, times(n, entry), seed), SSS_OK);
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(f, &probe, hits);
        for (int i = 0; i < count; ++i)
            sss_add_hit(&s, hits[i].position, times(hits[i].normal, factor), 1.0f);
    }
    return sss_finish(&s, exits);
}
static void normals_may_have_any_sign_and_length(void **state) {
    /* Powers of two (2^66 = 7e19) leave every bit. The others round the normal they are given, by
       6e-8, and where it grazes an axis beside which the disk's density is 50 times the chord's,
       that is 3e-6 of a weight. */
    static const float factors[] = {-1.0f,         0.5f,  2.0f,   1.3552527e-20f,
                                    7.3786976e19f, -3.0f, 1e-20f, 1e20f};
    enum { EXACT = 5, FACTORS = 8 };
    sss_medium m;
    (void)state;
    assert_int_equal(make_medium(&m, 0, 1, 0), SSS_OK);
    sss_exit want[SSS_MAX_EXITS], got[SSS_MAX_EXITS];
    for (int kind = 0; kind < ST_KINDS; ++kind)
        for (uint32_t seed = 0; seed < 500; ++seed) {
            st_fixture f = st_standard((st_kind)kind, st_moved());
            int count = lookup_with_normals(&f, &m, sss_hash(TEST_SEED, seed), 1.0f, 1.0f, want);
            for (int i = 0; i < FACTORS; ++i) {
                double sign = factors[i] < 0.0f ? -1.0 : 1.0;
                char name[80];
                snprintf(name, sizeof name, "normals times %g on %s", (double)factors[i],
                         st_kind_name(f.kind));
                check_equal(
                    name,
                    lookup_with_normals(&f, &m, sss_hash(TEST_SEED, seed), factors[i], 1.0f, got),
                    count);
                for (int e = 0; e < count; ++e) {
                    check_equal(name, st_same_bits(got[e].position, want[e].position), 1);
                    check_near(name, st_dot(st_double(got[e].normal), st_double(want[e].normal)),
                               sign, 1e-6);
                    for (int c = 0; c < 3; ++c)
                        check_relative(name, (double)got[e].weight[c], (double)want[e].weight[c],
                                       i < EXACT ? 0.0 : 1e-5);
                }
                if (i >= EXACT || factors[i] < 0.0f)
                    continue; /* the entry's normal, by powers of two */
                check_equal(
                    name,
                    lookup_with_normals(&f, &m, sss_hash(TEST_SEED, seed), 1.0f, factors[i], got),
                    count);
                check_equal(name, memcmp(got, want, sizeof got[0] * (size_t)count), 0);
            }
        }
}

/* ---- Means ---- */
static void run(const st_fixture *f, const sss_medium *m, const sss_plan *plan, uint32_t name,
                int lookups, st_stat *total) {
    static st_stat stats[BLOCKS][3];
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        memset(stats[b], 0, sizeof stats[b]);
        sss_exit exits[SSS_MAX_EXITS];
        for (int i = 0; i < lookups / BLOCKS; ++i) {
            int n = st_lookup(f, m, plan, sss_hash(name, (uint32_t)(b * (lookups / BLOCKS) + i)),
                              NULL, exits);
            double sum[3] = {0.0, 0.0, 0.0};
            for (int e = 0; e < n; ++e)
                for (int k = 0; k < 3; ++k)
                    sum[k] += (double)exits[e].weight[k] *
                              st_light_spot(st_local(&f->frame, exits[e].position));
            for (int k = 0; k < 3; ++k) st_add(&stats[b][k], sum[k]);
        }
    }
    memset(total, 0, 3 * sizeof *total);
    for (int b = 0; b < BLOCKS; ++b)
        for (int c = 0; c < 3; ++c) st_merge(&total[c], &stats[b][c]);
}
static void compare(const char *name, const st_stat *a, const st_stat *b) {
    double error = sqrt(pow(st_error(a), 2.0) + pow(st_error(b), 2.0));
    check_z(name, a->mean, error, b->mean, 0.0, Z_LIMIT);
    check_at_most("the power of that test: error over mean", error / b->mean,
                  0.0021 * st_bluntness());
}
static void motions_change_no_mean(void **state) {
    st_stat rest[3], moved[3];
    sss_medium m;
    (void)state;
    for (int kind = 0; kind < 2; ++kind) {
        st_fixture f = st_standard(kind ? ST_EDGE : ST_SPHERE, st_stay());
        sss_plan plan = {5, 1, 0u, 0, 0, 0};
        plan.techniques = sets[2 * kind];
        assert_int_equal(make_medium(&m, kind, 1, 0), SSS_OK);
        run(&f, &m, &plan, TEST_SEED + 10u * (uint32_t)kind, st_samples(1600000), rest);
        for (int i = 2; i <= 3; ++i) { /* one of them upside down, where frames have their seam */
            st_vec move = st_vec3(3.0 * i, -2.0 * i, 40.0),
                   axis = st_vec3(i == 2 ? 1.0 : 0.3 * i, i == 2 ? 0.0 : -0.7, 0.0);
            f.frame = st_motion(axis, i == 2 ? ST_PI : 1.1 * i, move);
            run(&f, &m, &plan, TEST_SEED + 10u * (uint32_t)kind + (uint32_t)i, st_samples(1600000),
                moved);
            for (int c = 0; c < 3; ++c) compare("a motion", &moved[c], &rest[c]);
        }
    }
}
static void colours_in_another_order_have_the_same_means(void **state) {
    static const int order[2][3] = {{2, 0, 1}, {1, 0, 2}};
    st_stat straight[3], mixed[3];
    (void)state;
    for (int type = 0; type < 2; ++type) {
        const float albedo[3] = {0.9f, 0.5f, 0.3f}, length[3] = {1.0f, 0.3f, 2.0f};
        st_fixture f = st_standard(ST_SPHERE, st_moved());
        const sss_plan plan = {8, 1, 0u, 0, 0, 0};
        sss_medium m;
        assert_int_equal((type ? sss_dipole_from_albedo(&m, albedo, length, 1.3f)
                               : sss_burley(&m, albedo, length)),
                         SSS_OK);
        run(&f, &m, &plan, TEST_SEED + 50u + (uint32_t)type, st_samples(1600000), straight);
        for (int i = 0; i < 2; ++i) {
            float a[3], d[3];
            for (int c = 0; c < 3; ++c) a[c] = albedo[order[i][c]], d[c] = length[order[i][c]];
            assert_int_equal((type ? sss_dipole_from_albedo(&m, a, d, 1.3f) : sss_burley(&m, a, d)),
                             SSS_OK);
            run(&f, &m, &plan, TEST_SEED + 60u + (uint32_t)(2 * type + i), st_samples(1600000),
                mixed);
            for (int c = 0; c < 3; ++c)
                compare("the order of the colours", &mixed[c], &straight[order[i][c]]);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scaling_by_powers_of_two_changes_no_bit),
        cmocka_unit_test(normals_may_have_any_sign_and_length),
        cmocka_unit_test(motions_change_no_mean),
        cmocka_unit_test(colours_in_another_order_have_the_same_means),
    };
    return cmocka_run_group_tests_name("invariance", tests, NULL, st_report);
}
