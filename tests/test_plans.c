/* The promises about plans: how the probes are shared out changes the variance and never the mean;
   stratified is no noisier than independent; the variance falls as theory D4 says.

   Comparisons: 444 z-scores (shares of probes, cells of strata, means) and 12 ratios of variances.
   At |z| < 5.2 (one-sided for the ratios) the chance that a correct header fails somewhere in this
   file is 456 * 2.0e-7 = 9e-5. The means are known to 0.13 % or better: a bias of 1 % gives z
   of 7.5 or more. A share of the probes that is wrong by 3 %, a cell that is wrong by 4 % and a
   stratified variance 8 % above the independent one are seen, in make test one that is 16 %
   above. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT 5.2
#define BLOCKS  128
#define ALL     (SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD)

/* ---- Moments of one channel's estimate, and the noise of the variance from that of the blocks
 * ---- */
typedef struct sample {
    st_stat value;
    st_stat variance; /* of the blocks */
} sample;
static void grey_burley(sss_medium *m, float albedo, float scale) {
    float a[3], dmfp[3];
    for (int c = 0; c < 3; ++c) {
        a[c] = albedo;
        dmfp[c] = scale * (float)st_burley_s((double)albedo);
    }
    assert_int_equal(sss_burley(m, a, dmfp), SSS_OK);
}
static sample run(const st_fixture *f, const sss_medium *m, const sss_plan *plan, st_light *light,
                  uint32_t name, int lookups) {
    static st_stat stats[BLOCKS];
    int each = lookups / BLOCKS;
    sample result;
    memset(&result, 0, sizeof result);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        memset(&stats[b], 0, sizeof stats[b]);
        sss_exit exits[SSS_MAX_EXITS];
        for (int i = 0; i < each; ++i) {
            int n = st_lookup(f, m, plan, sss_hash(name, (uint32_t)(b * each + i)), NULL, exits);
            double sum = 0.0;
            for (int e = 0; e < n; ++e)
                sum += (double)exits[e].weight[1] * light(st_local(&f->frame, exits[e].position));
            st_add(&stats[b], sum);
        }
    }
    for (int b = 0; b < BLOCKS; ++b) {
        st_merge(&result.value, &stats[b]);
        st_add(&result.variance, st_variance(&stats[b]));
    }
    return result;
}
static void name_case(char *name, size_t size, const sss_plan *plan, const st_fixture *f,
                      const char *what) {
    snprintf(name, size, "%s: techniques %u, M %d, N %d, %s, %s", what, plan->techniques,
             plan->candidates, plan->exits, plan->independent ? "independent" : "stratified",
             st_kind_name(f->kind));
}

/* ---- Stratified against independent ---- */
static void stratified_and_independent_agree(void **state) {
    static const unsigned sets[] = {0u, ALL};
    sss_medium m;
    (void)state;
    grey_burley(&m, 0.8f, 1.0f);
    for (int kind = 0; kind < 2 * ST_KINDS; ++kind) {
        st_fixture f = st_standard((st_kind)(kind % ST_KINDS), st_moved());
        st_light *light = kind & 1 ? st_light_spot : st_light_one;
        sss_plan plan = {8, 1, 0u, 0, 0, 0};
        int lookups = st_samples(f.kind == ST_STACK ? 200000 : 400000);
        plan.techniques = sets[kind / ST_KINDS];
        sample strata = run(&f, &m, &plan, light, TEST_SEED + (uint32_t)kind, lookups);
        plan.independent = 1;
        sample drawn = run(&f, &m, &plan, light, TEST_SEED + 100u + (uint32_t)kind, lookups);
        double error = sqrt(pow(st_error(&strata.value), 2.0) + pow(st_error(&drawn.value), 2.0));
        char name[160];
        name_case(name, sizeof name, &plan, &f, "mean of stratified against");
        check_z(name, strata.value.mean, error, drawn.value.mean, 0.0, Z_LIMIT);
        double ratio = strata.variance.mean / drawn.variance.mean;
        error = ratio * sqrt(pow(st_error(&strata.variance) / strata.variance.mean, 2.0) +
                             pow(st_error(&drawn.variance) / drawn.variance.mean, 2.0));
        name_case(name, sizeof name, &plan, &f, "variance of stratified over");
        check_at_most(name, ratio, 1.0 + Z_LIMIT * error);
        check_at_most("noise of that ratio", Z_LIMIT * error, 0.08 * st_bluntness());
    }
}

/* ---- No bias: counts that fall to zero, strata that are no power of two, exits that share the
   probes ---- */
static void no_bias(const st_fixture *f, const sss_medium *m, const sss_plan *plan, double truth,
                    uint32_t name) {
    sample got = run(f, m, plan, st_light_one, name, st_samples(4000000) / (plan->candidates + 1));
    char text[160];
    name_case(text, sizeof text, plan, f, "mean");
    check_z(text, got.value.mean, st_error(&got.value), truth, 2e-5 * truth, Z_LIMIT);
}
static void drawn_counts_bring_no_bias(void **state) {
    static const float albedo = 0.8f;
    sss_medium m;
    st_fixture f = st_standard(ST_EDGE, st_moved());
    (void)state;
    grey_burley(&m, albedo, 1.0f);
    for (int independent = 0; independent < 2; ++independent)
        for (int i = 1; i <= 7; ++i) {
            sss_plan plan = {0, 1, ALL, 0, 0, 0};
            plan.candidates = i;
            plan.exits = i == 5 ? 4 : i == 6 ? 2 : 1;
            plan.independent = independent;
            no_bias(&f, &m, &plan, (double)albedo * st_closed_form(&f),
                    TEST_SEED + 200u + (uint32_t)(10 * independent + i));
        }
}
static void strata_of_any_number_bring_no_bias(void **state) {
    static const float albedo = 0.8f;
    static const int counts[] = {2, 3, 5, 6, 7, 9, 11, 13};
    sss_medium m;
    (void)state;
    grey_burley(&m, albedo, 0.3f);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        st_fixture f = st_standard(ST_CYLINDER, st_moved()), unit = f;
        sss_plan plan = {0, 1, SSS_CHORD, 0, 0, 0};
        unit.size /= (double)0.3f;
        plan.candidates = counts[i];
        no_bias(&f, &m, &plan, (double)albedo * st_closed_form(&unit),
                TEST_SEED + 300u + (uint32_t)i);
        plan.techniques = SSS_DISK | SSS_DISK_TANGENTS | SSS_CHORD;
        if (i < 4)
            no_bias(&f, &m, &plan, (double)albedo * st_closed_form(&unit),
                    TEST_SEED + 320u + (uint32_t)i);
    }
}

/* ---- Counts, as a caller sees them. Entry at the origin, normal +z. ---- */
enum { NORMAL, TANGENT, SPHERE, CHORD, CLASSES };
/* Disk probes lie along an axis (the two tangents count as one here), the lines of the sphere pass
   through the point at depth 1, and none of the others does. */
static int class_of(const sss_probe *p) {
    st_vec o = st_double(p->origin), d = st_double(p->direction),
           below = st_sum(o, st_vec3(0.0, 0.0, -1.0), -1.0);
    double along =
        fabs(d.x * d.x * d.y * d.y) + fabs(d.y * d.y * d.z * d.z) + fabs(d.z * d.z * d.x * d.x);
    if (along < 1e-20) return fabs(d.z) > 0.5 ? NORMAL : TANGENT;
    double t = -st_dot(below, d);
    return st_length(st_sum(below, d, t)) < 2e-5 && p->length > 4.0f ? SPHERE : CHORD;
}
static double share_of(unsigned techniques, int c) {
    int n = 0;
    for (int i = 0; i < 4; ++i) n += (int)(techniques >> i & 1u);
    return techniques >> c & 1u ? 1.0 / n : 0.0;
}
/* The probes of one lookup by class and by j mod N; returns their number, which lacks the few
 * beyond the ball. */
static int count_probes(const sss_medium *m, const sss_plan *plan, uint32_t seed,
                        double count[CLASSES][SSS_MAX_EXITS]) {
    int probes = 0;
    for (int c = 0; c < CLASSES; ++c)
        for (int i = 0; i < SSS_MAX_EXITS; ++i) count[c][i] = 0.0;
    sss_resampler s;
    sss_begin(&s, m, plan, st_float(st_vec3(0.0, 0.0, 0.0)), st_float(st_vec3(0.0, 0.0, 1.0)),
              seed);
    sss_probe probe;
    for (; sss_next_probe(&s, &probe); ++probes)
        count[class_of(&probe)][probes % plan->exits] += 1.0;
    return probes;
}
static void check_counts(const sss_medium *m, const sss_plan *plan, uint32_t name) {
    st_stat totals[CLASSES] = {{0.0, 0.0, 0.0}};
    char text[160];
    snprintf(text, sizeof text, "probes of a technique: techniques %u, M %d, N %d, %s",
             plan->techniques, plan->candidates, plan->exits,
             plan->independent ? "independent" : "stratified");
    double count[CLASSES][SSS_MAX_EXITS];
    for (uint32_t seed = 0; seed < 40000; ++seed) {
        int probes = count_probes(m, plan, sss_hash(name, seed), count);
        for (int c = 0; c < CLASSES; ++c) {
            double expected = plan->candidates * share_of(plan->techniques, c), sum = 0.0;
            for (int i = 0; i < plan->exits; ++i) {
                sum += count[c][i];
                if (probes == plan->candidates &&
                    !plan->independent) /* the two tangents are two techniques */
                    check_near(text, count[c][i], expected / plan->exits,
                               c == TANGENT ? 1.99999 : 0.99999);
            }
            st_add(&totals[c], sum);
            if (probes == plan->candidates && !plan->independent)
                check_near(text, sum, expected, c == TANGENT ? 1.99999 : 0.99999);
        }
    }
    for (int c = 0; c < CLASSES; ++c) { /* of a disk's probes 1e-4 lie beyond the ball */
        double expected =
            plan->candidates * share_of(plan->techniques, c) * (c <= TANGENT ? 1.0 - 1e-4 : 1.0);
        check_z(text, totals[c].mean, st_error(&totals[c]), expected, 2e-5 * expected, Z_LIMIT);
    }
}
static void probes_are_shared_as_stated(void **state) {
    static const unsigned sets[] = {ALL, SSS_DISK | SSS_CHORD,
                                    SSS_DISK | SSS_DISK_TANGENTS | SSS_CHORD};
    static const int candidates[] = {1, 2, 3, 4, 5, 6, 7, 8, 13, 16};
    const sss_plan none = {0, 0, 0u, 0, 0, 0};
    sss_medium m;
    (void)state;
    grey_burley(&m, 0.8f, 1.0f);
    for (size_t t = 0; t < 3; ++t)
        for (size_t i = 0; i < 10; ++i)
            for (int independent = 0; independent < 2; ++independent) {
                sss_plan plan = none;
                plan.candidates = candidates[i];
                plan.techniques = sets[t];
                plan.exits = i == 7 || i == 9 ? 4 : i == 3 ? 2 : 1;
                plan.independent = independent;
                check_counts(&m, &plan,
                             TEST_SEED + 400u + (uint32_t)(20 * t + 2 * i) + (uint32_t)independent);
            }
}

/* ---- Strata leave no pattern: radius and angle of a probe are independent, whatever the number of
 * strata ---- */
/* Where a probe's radius lies in its distribution, and its angle about the normal, both in 0..1.
   Burley, d = 1: the disk's radius has the tail (e^-r + 3 e^(-r/3)) / 4, the chord's sphere 3/4 e
   (1 + t/2) + 1/4 e^3 (1 + 3t/2), e = e^-t and t = rho / 3. */
static void ranks_of(const sss_probe *p, int chord, double *radius, double *angle) {
    st_vec o = st_double(p->origin);
    double t = (chord ? st_length(o) : sqrt(o.x * o.x + o.y * o.y)) / 3.0, e = exp(-t);
    *radius = chord ? 0.75 * e * (1.0 + 0.5 * t) + 0.25 * e * e * e * (1.0 + 1.5 * t)
                    : 0.25 * e * (e * e + 3.0);
    *angle = atan2(o.y, o.x) / (2.0 * ST_PI) + 0.5;
}
static void check_table(const sss_medium *m, unsigned technique, int strata, uint32_t name) {
    static st_stat cells[49];
    sss_plan plan = {0, 1, 0u, 0, 0, 0};
    plan.candidates = strata;
    plan.techniques = technique;
    memset(cells, 0, sizeof cells);
    int i;
    for (uint32_t seed = 0; seed < 300000; ++seed) {
        double count[49] = {0.0};
        sss_resampler s;
        sss_begin(&s, m, &plan, st_float(st_vec3(0.0, 0.0, 0.0)), st_float(st_vec3(0.0, 0.0, 1.0)),
                  sss_hash(name, seed));
        double radius, angle;
        sss_probe probe;
        while (sss_next_probe(&s, &probe)) {
            ranks_of(&probe, technique == SSS_CHORD, &radius, &angle);
            i = (int)fmin(radius * strata, strata - 1.0) * strata +
                (int)fmin(angle * strata, strata - 1.0);
            count[i] += 1.0;
        }
        for (i = 0; i < strata * strata; ++i) st_add(&cells[i], count[i]);
    }
    char text[80];
    for (i = 0; i < strata * strata; ++i) {
        snprintf(text, sizeof text, "technique %u, M %d, radius %d and angle %d", technique, strata,
                 i / strata, i % strata);
        check_z(text, cells[i].mean, st_error(&cells[i]), 1.0 / strata, 1e-3 / strata, Z_LIMIT);
    }
}
static void strata_leave_no_pattern(void **state) {
    sss_medium m;
    (void)state;
    grey_burley(&m, 0.8f, 1.0f);
    for (int n = 3; n <= 7; n += 2) {
        check_table(&m, SSS_DISK, n, TEST_SEED + 700u + (uint32_t)n);
        check_table(&m, SSS_CHORD, n, TEST_SEED + 710u + (uint32_t)n);
    }
}

/* ---- D4: independent probes with at most one hit, one exit: variance = V_S / M + (1 - 1 / M) V_g
 * ---- */
typedef struct law {
    sss_resampler s;
    st_profile profile;
    st_light *light;
    int over_intensity;
} law;
static double second_moment(st_vec y, st_vec n, const void *context) {
    const law *l = (const law *)context;
    double g = st_rd(&l->profile, st_length(y)), f = g * l->light(y);
    double mu = (double)sss_intensity(&l->s, st_float(y), st_float(n));
    return l->over_intensity ? f * f / mu : f * l->light(y);
}
static void variance_follows_the_law(void **state) {
    static const unsigned sets[] = {SSS_CHORD, SSS_DISK | SSS_CHORD};
    static const int candidates[] = {1, 2, 5, 16, 64};
    const float albedo = 0.8f;
    st_fixture f = st_standard(ST_PLANE, st_stay());
    sss_medium m;
    (void)state;
    grey_burley(&m, albedo, 1.0f);
    for (size_t t = 0; t < 2; ++t)
        for (size_t i = 0; i < (st_is_long() ? 5u : 4u);
             ++i) { /* 64 candidates cost as much as all others */
            sss_plan plan = {0, 1, 0u, 1, 0, 0};
            plan.candidates = candidates[i];
            plan.techniques = sets[t];
            law l;
            l.profile = st_burley((double)albedo, (double)((float)st_burley_s((double)albedo)));
            l.light = st_light_shadow;
            sss_vec3 x, n;
            st_entry(&f, &x, &n);
            sss_begin(&l.s, &m, &plan, x, n, 1u);
            double mean = st_truth(&f, &l.profile, l.light);
            l.over_intensity = 1;
            double v_s = st_surface(&f, 1.0, second_moment, &l) - mean * mean;
            l.over_intensity = 0;
            double v_g = (double)albedo * st_surface(&f, 1.0, second_moment, &l) - mean * mean;
            double expected = v_s / plan.candidates + (1.0 - 1.0 / plan.candidates) * v_g;
            sample got =
                run(&f, &m, &plan, l.light, TEST_SEED + 600u + (uint32_t)(10 * t + i), 300000);
            char name[160];
            name_case(name, sizeof name, &plan, &f, "variance");
            check_relative(name, got.variance.mean, expected, 0.05);
            check_at_most("noise of that variance", Z_LIMIT * st_error(&got.variance) / expected,
                          0.05);
        }
}

/* ---- One disk probe, which sss_plan_for may ask for: on a sphere of radius r_max it has the whole
   integral but the tail, and no more variance than eight candidates of the default mix. ---- */
static void one_probe_is_enough_where_it_is_flat(void **state) {
    sss_medium m;
    st_fixture f = st_standard(ST_SPHERE, st_moved());
    const sss_plan plan = {1, 1, SSS_DISK, 0, 0, 0};
    (void)state;
    grey_burley(&m, 0.8f, 0.037f);
    assert_true((double)m.r_max > 0.95 * f.size && (double)m.r_max <= f.size);
    double truth = (double)sss_within(&m, 1, 2.0f * (float)f.size);
    sample one = run(&f, &m, &plan, st_light_one, TEST_SEED + 700u, 2000000);
    check_near("mean of one probe", one.value.mean, truth,
               1e-4 * truth + Z_LIMIT * st_error(&one.value));
    sample eight = run(&f, &m, NULL, st_light_one, TEST_SEED + 701u, 200000);
    check_at_most("variance of one probe", one.variance.mean,
                  eight.variance.mean +
                      Z_LIMIT * (st_error(&one.variance) + st_error(&eight.variance)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probes_are_shared_as_stated),
        cmocka_unit_test(strata_leave_no_pattern),
        cmocka_unit_test(drawn_counts_bring_no_bias),
        cmocka_unit_test(strata_of_any_number_bring_no_bias),
        cmocka_unit_test(stratified_and_independent_agree),
        cmocka_unit_test(variance_follows_the_law),
        cmocka_unit_test(one_probe_is_enough_where_it_is_flat),
    };
    return cmocka_run_group_tests_name("plans", tests, NULL, st_report);
}
