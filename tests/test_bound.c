/* The promise: without hints one hit adds to exit.weight[c] at most
       albedo[c] * live channels * 2 / (chord's share of the probes) * sup / candidates,
   sup = 1 for Burley's profile, 3.3 for the dipoles up to eta = 2, 8.3 up to 5, on any geometry.
   Channels without a profile (Lambert) are not live; beside them an exit also stands for the entry,
   which adds at most albedo[c] for each of them. Searched over 1e7 random media, points and
   normals; that the bound is nearly reached shows that it is not vacuous. No statistics: nothing
   here may be exceeded at all, but for the rounding of float32. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define MEDIA    500
#define POINTS   20000 /* each */
#define LOOKUPS  400   /* of the points, each */
#define ROUNDING 2e-6  /* of weights */
#define FAR      3e-5  /* of a profile over an intensity: e^-x in two units, at x up to 70 */
#define SUP_2    3.3   /* eta up to 2 */
#define SUP_5    8.3

static const unsigned sets[] = {
    0u,
    SSS_CHORD,
    SSS_DISK | SSS_CHORD,
    SSS_DISK | SSS_DISK_TANGENTS | SSS_CHORD,
    SSS_SPHERE | SSS_CHORD,
    SSS_DISK | SSS_SPHERE | SSS_CHORD,
    SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD,
};
#define SETS (sizeof sets / sizeof *sets)

typedef struct subject {
    sss_medium medium;
    sss_vec3 normal;
    double albedo[3]; /* of the live channels, 0 for others */
    double widest, narrowest;
    double sup;
    int live, lambert, dipole;
    char name[160];
} subject;
/* What a search has seen: the largest Rd / (mu * bound) and where, and the largest weight over its
 * bound. */
typedef struct worst {
    double ratio, weight;
    sss_vec3 x, n;
    int bad;
} worst;

static sss_vec3 random_direction(uint64_t seed) {
    double z = st_signed(seed), turn = 2.0 * ST_PI * st_random(seed + 1u), rim = sqrt(1.0 - z * z);
    return st_float(st_vec3(rim * cos(turn), rim * sin(turn), z));
}
/* Any albedos, lengths apart by up to 1e4, 1 - albedo' from 1e-6 to 1 - 1e-6 and, by way
   of the albedo, from far less, eta from 0.2 to 5, mostly from 1 to 2, some channels
 * black. */
static void make_subject(subject *k, uint64_t seed) {
    float a[3], b[3],
        eta = (float)(st_random(seed + 9u) < 0.7 ? 1.0 + st_random(seed + 1u)
                                                 : 0.2 + 4.8 * st_random(seed + 1u));
    double spread = 9.0 * (st_random(seed + 2u) < 0.5 ? 0.0 : st_random(seed + 3u));
    int type = (int)(5.0 * st_random(seed + 4u));
    for (int c = 0; c < 3; ++c) {
        uint64_t t = seed + 10u * (uint64_t)c;
        double scale = exp(spread * st_random(t + 5u)), dark = exp(-13.8 * st_random(t + 6u));
        if (st_random(t + 8u) < 0.3) dark = 1.0 - dark;
        dark = fmin(fmax(dark, 1e-6), 1.0 - 1e-6);
        a[c] = (float)(type == 1 || type == 2 ? dark * scale : 1.0 - dark);
        b[c] = (float)(type == 1 || type == 2 ? (1.0 - dark) * scale : scale);
        if (c > 0 && st_random(t + 7u) < 0.2) {
            if (type == 1 || type == 2) b[c] = 0.0f;
            else a[c] = 0.0f;
        }
    }
    sss_result result;
    if (type == 0) result = sss_burley(&k->medium, a, b);
    else if (type == 1) result = sss_dipole(&k->medium, a, b, eta);
    else if (type == 2) result = sss_better_dipole(&k->medium, a, b, eta);
    else if (type == 3) result = sss_dipole_from_albedo(&k->medium, a, b, eta);
    else result = sss_better_dipole_from_albedo(&k->medium, a, b, eta);
    assert_int_equal(result, SSS_OK);
    k->dipole = type > 0;
    k->sup = type == 0 ? 1.0 : eta <= 2.0f ? SUP_2 : SUP_5;
    k->live = k->lambert = 0;
    k->widest = 0.0;
    k->narrowest = HUGE_VAL;
    for (int c = 0; c < 3; ++c) {
        double length = type == 1 || type == 2 ? 1.0 / ((double)a[c] + (double)b[c]) : (double)b[c];
        k->albedo[c] = (double)sss_within(&k->medium, c, FLT_MAX);
        if (k->albedo[c] > 0.0 && !(sss_profile(&k->medium, c, 0.0f) > 0.0f)) {
            ++k->lambert;
            k->albedo[c] = 0.0;
        }
        if (!(k->albedo[c] > 0.0)) continue;
        ++k->live;
        k->widest = fmax(k->widest, length);
        k->narrowest = fmin(k->narrowest, length);
    }
    k->normal = random_direction(seed + 50u);
    snprintf(k->name, sizeof k->name, "medium %d (%g %g, %g %g, %g %g) eta %g", type, (double)a[0],
             (double)b[0], (double)a[1], (double)b[1], (double)a[2], (double)b[2], (double)eta);
}
/* Distances over all scales, and those at which divisions go wrong; directions and normals along
 * and across axes. */
static sss_vec3 random_point(const subject *k, uint64_t seed) {
    static const double odd[] = {0.0, (double)FLT_MIN, 1e-30, 1e-20, 1e-10};
    double r =
        exp(log(1e-8 * k->narrowest) + st_random(seed) * log(1e10 * k->widest / k->narrowest));
    double pick = st_random(seed + 1u), off = exp(-18.0 * st_random(seed + 2u));
    sss_vec3 d = random_direction(seed + 3u), n = k->normal;
    if (pick < 0.05) r = odd[(int)(100.0 * pick)];
    else if (pick < 0.1) r = (pick < 0.07 ? 1e-7 : 1e-6) * k->narrowest;
    if (st_random(seed + 5u) < 0.5) /* close to the axis */
        d = st_float(st_unit(st_sum(st_double(n), st_double(d), off)));
    else if (st_random(seed + 6u) < 0.5) /* close to the tangent plane */
        d = st_float(st_unit(
            st_sum(st_double(d), st_double(n), (off - 1.0) * st_dot(st_double(d), st_double(n)))));
    return st_float(st_sum(st_vec3(0.0, 0.0, 0.0), st_double(d), r));
}
static sss_vec3 random_normal(const subject *k, uint64_t seed) {
    double off = exp(-18.0 * st_random(seed));
    sss_vec3 d = random_direction(seed + 1u);
    if (st_random(seed + 3u) < 0.4) return d;
    double along = st_dot(st_double(d), st_double(k->normal)); /* grazing: |n.a| down to 1e-8 */
    return st_float(st_sum(st_double(d), st_double(k->normal), (off - 1.0) * along));
}
static double bound(const subject *k, int c, double share, int candidates) {
    return k->albedo[c] * k->live * 2.0 / share * k->sup / candidates;
}
/* A radius beyond the ball that cuts disks and spheres. */
static double far_out(const subject *k) {
    double r = k->narrowest;
    for (int c = 0; c < 3; ++c)
        while (k->albedo[c] > 0.0 &&
               (double)sss_within(&k->medium, c, (float)r) < (1.0 - 5e-5) * k->albedo[c])
            r *= 1.5;
    return 1.5 * r;
}
/* Chord's part of the probes, as a caller sees it: far out there is nothing else. */
static double chord_share(const subject *k, sss_plan plan) {
    sss_vec3 far = st_float(st_vec3(0.0, 0.0, far_out(k))),
             origin = st_float(st_vec3(0.0, 0.0, 0.0));
    sss_resampler s;
    sss_begin(&s, &k->medium, &plan, origin, k->normal, 1u);
    double mixed = (double)sss_intensity(&s, far, k->normal);
    plan.techniques = SSS_CHORD;
    sss_begin(&s, &k->medium, &plan, origin, k->normal, 1u);
    return mixed / (double)sss_intensity(&s, far, k->normal);
}
static void look_up(const subject *k, const sss_plan *plan, sss_vec3 x, sss_vec3 n, double share,
                    worst *w) {
    sss_resampler s;
    sss_begin(&s, &k->medium, plan, st_float(st_vec3(0.0, 0.0, 0.0)), k->normal, 1u);
    sss_probe probe;
    if (!sss_next_probe(&s, &probe)) return;
    sss_add_hit(&s, x, n, 1.0f);
    sss_exit exit;
    if (sss_finish(&s, &exit) != 1) return;
    for (int c = 0; c < 3; ++c) {
        double weight = (double)exit.weight[c];
        double most = bound(k, c, share, plan->candidates) + k->lambert * k->albedo[c];

        if (k->albedo[c] > 0.0) w->weight = fmax(w->weight, weight / most);
        if (!(weight >= 0.0 && weight <= (double)FLT_MAX)) w->bad = 1;
    }
}
static void search(const subject *k, uint64_t seed, sss_plan plan, worst *w) {
    double share = chord_share(k, plan);
    sss_resampler s;
    sss_begin(&s, &k->medium, &plan, st_float(st_vec3(0.0, 0.0, 0.0)), k->normal, 1u);
    for (int i = 0; i < POINTS; ++i) {
        uint64_t t = seed + 100u * (uint64_t)i;
        sss_vec3 x = random_point(k, t), n = random_normal(k, t + 20u);
        double mu = (double)sss_intensity(&s, x, n), r = st_length(st_double(x));

        if (!(mu > 0.0)) w->bad = 1;
        for (int c = 0; c < 3; ++c) {
            double ratio = (double)sss_profile(&k->medium, c, (float)r) / mu;
            if (!(k->albedo[c] > 0.0)) continue;
            ratio /= bound(k, c, share, 1);
            if (ratio <= w->ratio) continue;
            w->ratio = ratio;
            w->x = x;
            w->n = n;
        }
        if (i < LOOKUPS) look_up(k, &plan, x, n, share, w);
    }

    /* A lookup reaches there what the ratio says. */
    look_up(k, &plan, w->x, w->n, share, w);
}

static void no_weight_exceeds_the_bound(void **state) {
    static subject subjects[MEDIA];
    static worst found[MEDIA];
    double reached[2] = {0.0, 0.0};
    (void)state;
    for (int i = 0; i < MEDIA; ++i) make_subject(&subjects[i], TEST_SEED + 1000000u * (uint64_t)i);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < MEDIA; ++i) {
        sss_plan plan = {8, 1, 0u, 0, 0, 0};
        plan.techniques = sets[(size_t)i % SETS];
        plan.candidates = 1 + i % 13;
        search(&subjects[i], TEST_SEED + 100000000u * (uint64_t)(i + 1), plan, &found[i]);
    }
    for (int i = 0; i < MEDIA; ++i) {
        char name[300];
        const subject *k = &subjects[i];
        snprintf(name, sizeof name, "techniques %u, M %d, %s, r %g, over its bound",
                 sets[(size_t)i % SETS], 1 + i % 13, k->name, st_length(st_double(found[i].x)));
        check_equal(name, found[i].bad, 0);
        check_at_most(name, found[i].ratio, 1.0 + FAR);
        check_at_most(name, found[i].weight, 1.0 + ROUNDING);
        reached[k->dipole] = fmax(reached[k->dipole], fmin(found[i].ratio, found[i].weight));
    }
    print_message("reached: %.4f of the bound by Burley, %.4f by the dipoles\n", reached[0],
                  reached[1]);
    check_at_least("the part of the bound that Burley reaches", reached[0], 0.99);
    check_at_least("the part of the bound that the dipoles reach", reached[1], 0.9);
}

/* sup of Rd / (A P): a chord-only plan of one channel has the intensity P / 2. */
static double sup_of(const sss_medium *m, double length) {
    const sss_plan plan = {1, 1, SSS_CHORD, 0, 0, 0};
    double albedo = (double)sss_within(m, 0, FLT_MAX), sup = 0.0;
    sss_vec3 up = st_float(st_vec3(0.0, 0.0, 1.0));
    sss_resampler s;
    sss_begin(&s, m, &plan, st_float(st_vec3(0.0, 0.0, 0.0)), up, 1u);
    for (int i = 0; i < 400; ++i) {
        float r = (float)(length * exp(log(1e-6) + i * log(1e12) / 400.0));
        double p = 2.0 * (double)sss_intensity(&s, st_float(st_vec3((double)r, 0.0, 0.0)), up);
        double rd = (double)sss_profile(m, 0, r);
        if (rd > 1e-30)
            sup = fmax(sup, rd / (albedo * p)); /* below, both are about to be subnormal */
    }
    return sup;
}
/* By the coefficients 1 - albedo' goes from 1 to 1e-6, by the albedo down to about 1e-15. */
static double sup_at(int better, int way, double dark, float eta) {
    float a[3] = {0.0f, 0.0f, 0.0f}, b[3] = {0.0f, 0.0f, 0.0f};
    a[0] = (float)(way ? 1.0 - dark : dark);
    b[0] = (float)(way ? 1.0 : 1.0 - dark);
    sss_medium m;
    if (way)
        assert_int_equal(
            (better ? sss_better_dipole_from_albedo : sss_dipole_from_albedo)(&m, a, b, eta),
            SSS_OK);
    else assert_int_equal((better ? sss_better_dipole : sss_dipole)(&m, a, b, eta), SSS_OK);
    return sup_of(&m, 1.0);
}
static void dipoles_stay_below_the_stated_sup(void **state) {
    double sup[2] = {0.0, 0.0};
    (void)state;
    for (int way = 0; way < 4; ++way)
        for (int i = 0; i <= 100; ++i)
            for (int j = 0; j <= 24; ++j) {
                double dark = fmin(exp(-13.816 * i / 100.0), 1.0 - 2e-7), eta = 0.2 + 0.2 * j;
                double *worst_of = &sup[(float)eta > 2.0f];
                *worst_of = fmax(*worst_of, sup_at(way & 1, way >> 1, dark, (float)eta));
            }
    print_message("sup of Rd / (A P): %.4f up to eta = 2, %.4f up to 5\n", sup[0], sup[1]);
    check_at_most("sup of Rd / (A P), eta up to 2", sup[0], SUP_2 * (1.0 + ROUNDING));
    check_at_most("sup of Rd / (A P), eta up to 5", sup[1], SUP_5 * (1.0 + ROUNDING));
    check_at_least("sup of Rd / (A P), eta up to 2", sup[0], 0.95 * SUP_2);
    check_at_least("sup of Rd / (A P), eta up to 5", sup[1], 0.95 * SUP_5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_weight_exceeds_the_bound),
        cmocka_unit_test(dipoles_stay_below_the_stated_sup),
    };
    return cmocka_run_group_tests_name("bound", tests, NULL, NULL);
}
