/* The promise: the known ways in which sampling of subsurface scattering fails do not fail here.
   These are the ones that no other file holds; tests/README.md says which test answers which.

   Comparisons: 21 z-scores at |z| < 5.0, 10 distributions at sqrt(n) D < 2.6: the chance that a
   correct header fails somewhere in this file is 21 * 5.7e-7 + 10 * 2.7e-6 = 4e-5. The rest is
   exact, or a bound that follows from the bound of the weights; where a limit is not from theory it
   says where from. SPDX-License-Identifier: MIT */
#define SSS_MAX_CANDIDATES 65534 /* the most that may be set; it costs nothing */
#include "sss_test.h"

#define Z_LIMIT 5.0
#define BLOCKS  64
#define SUP     3.3  /* of a dipole's profile over its proposal, eta up to 2: the header's bound */
#define EPSILON 6e-8 /* 2^-24, one rounding */

/* Burley with d = length in each channel. */
static sss_medium burley(float albedo, float red, float green, float blue) {
    float a[3], s = (float)st_burley_s((double)albedo);
    a[0] = a[1] = a[2] = albedo;
    float dmfp[3];
    dmfp[0] = red * s;
    dmfp[1] = green * s;
    dmfp[2] = blue * s;
    sss_medium m;
    assert_int_equal(sss_burley(&m, a, dmfp), SSS_OK);
    return m;
}
static sss_medium dipole(int better, double sigma_a, double sigma_s, float eta) {
    float a[3];
    a[0] = a[1] = a[2] = (float)sigma_a;
    float b[3];
    b[0] = b[1] = b[2] = (float)sigma_s;
    sss_medium m;
    assert_int_equal((better ? sss_better_dipole : sss_dipole)(&m, a, b, eta), SSS_OK);
    return m;
}

/* Many lookups; the sum over exits of weight times light, each channel for itself. */
static void run(const st_fixture *f, const sss_medium *m, const sss_plan *plan, st_light *light,
                st_hint *hint, uint32_t name, int lookups, st_stat *total) {
    static st_stat stats[BLOCKS][3];
    int each = lookups / BLOCKS;
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        memset(stats[b], 0, sizeof stats[b]);
        sss_exit exits[SSS_MAX_EXITS];
        for (int i = 0; i < each; ++i) {
            int n = st_lookup(f, m, plan, sss_hash(name, (uint32_t)(b * each + i)), hint, exits);
            double sum[3] = {0.0, 0.0, 0.0};
            for (int e = 0; e < n; ++e)
                for (int k = 0; k < 3; ++k)
                    sum[k] +=
                        (double)exits[e].weight[k] * light(st_local(&f->frame, exits[e].position));
            for (int k = 0; k < 3; ++k) st_add(&stats[b][k], sum[k]);
        }
    }
    memset(total, 0, 3 * sizeof *total);
    for (int b = 0; b < BLOCKS; ++b)
        for (int c = 0; c < 3; ++c) st_merge(&total[c], &stats[b][c]);
}

/* ---- Profiles ---- */

/* The difference of the better dipole's two waves, and the expm1 that stands in for it: over seven
   decades of r the relative error stays below 1e-5, of which 2e-6 is arithmetic and the rest the
   rounding of the exponent. */
static void dipoles_do_not_cancel(void **state) {
    static const double dark[] = {0.25, 0.01, 1e-6}; /* 1 - albedo' */
    double worst = 0.0;
    int compared = 0;
    (void)state;
    for (int better = 0; better < 2; ++better)
        for (int i = 0; i < 3; ++i) {
            sss_medium m = dipole(better, dark[i], 1.0 - dark[i], 1.4f);
            st_profile p = st_dipole((double)(float)dark[i], (double)(float)(1.0 - dark[i]),
                                     (double)1.4f, better);
            for (int k = 0; k <= 1400; ++k) {
                float r = (float)(p.zr * pow(10.0, -3.0 + k / 200.0));
                double exact = st_rd(&p, (double)r);
                if (p.s * hypot((double)r, p.zv) > 69.0)
                    break; /* beyond 70 the profile is said to stay as it is */
                double error = fabs((double)sss_profile(&m, 0, r) / exact - 1.0);
                worst = error <= worst ? worst : error;
                ++compared;
            }
        }
    print_message("%d radii, worst relative error %.2g\n", compared, worst);
    check_at_most("relative error of the dipoles", worst, 1e-5);
    check_at_least("radii compared", compared, 6000.0);
}

/* Without absorption a dipole falls as 1/r^3: an exponential proposal has a relative variance of 45
   at albedo' = 1 - 1e-6. Here Rd / (A P) <= SUP, so that E[w^2] <= SUP A E[w]. */
static void albedo_near_one_stays_calm(void **state) {
    static const double dark[] = {1e-2, 1e-4, 1e-6, 0.0};
    const sss_plan plan = {1, 1, SSS_DISK, 1, 0, 0};
    st_fixture f = st_standard(ST_PLANE, st_stay());
    double worst = 0.0;
    (void)state;
    for (int better = 0; better < 2; ++better)
        for (int i = 0; i < 4; ++i) {
            sss_medium m = dipole(better, dark[i], 1.0 - dark[i], 1.4f);
            double albedo = (double)m.albedo[0];
            st_stat got[3];
            run(&f, &m, &plan, st_light_one, NULL, TEST_SEED + (uint32_t)(10 * better + i), 400000,
                got);
            check_z("mean of disk probes", got[0].mean, st_error(&got[0]), (1.0 - 1e-4) * albedo,
                    1e-5, Z_LIMIT);
            check_at_most("relative variance of disk probes", st_relative_variance(&got[0]),
                          SUP - 1.0);
            worst = fmax(worst, st_relative_variance(&got[0]));
        }
    print_message("worst relative variance %.2f, limit %.2f\n", worst, SUP - 1.0);
}

/* ---- Radii have the distribution that the density says, from end to end ---- */
static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
/* What lies beyond r: of disks about the normal, or of the spheres of chords. */
static double beyond_burley(double d, int chord, double r) {
    double t = r / (3.0 * d), e = exp(-t);
    return chord ? 0.75 * e * (1.0 + 0.5 * t) + 0.25 * e * e * e * (1.0 + 1.5 * t)
                 : 0.25 * e * (e * e + 3.0);
}
static double beyond_pole(double z, int chord, double r) {
    double c = z / hypot(r, z);
    return chord ? 0.5 * (3.0 * c - c * c * c) : c;
}
static double beyond(const sss_medium *m, int chord, double r) {
    double sigma = (double)m->sigma[0];
    if (!m->dipole) return beyond_burley((double)m->length[0], chord, r);
    double poles = 0.5 * (beyond_pole((double)m->length[0], chord, r) +
                          beyond_pole((double)m->zv[0], chord, r));
    return sigma > 0.0 ? 0.5 * (poles + beyond_burley(1.0 / (3.0 * sigma), chord, r)) : poles;
}
/* Kolmogorov and Smirnov's distance, times sqrt(n); disk probes beyond r_max are missing and lie
 * beyond all others. */
static double distance_of_radii(const sss_medium *m, int chord, uint32_t name) {
    enum { MOST = 400000 };
    static double r[MOST];
    const int lookups = st_samples(MOST);
    const sss_plan plan = {1, 1, chord ? SSS_CHORD : SSS_DISK, 0, 0, 0};
    const sss_vec3 origin = {0.0f, 0.0f, 0.0f}, up = {0.0f, 0.0f, 1.0f};
    double worst = 0.0;
    int n = 0;
    for (int i = 0; i < lookups; ++i) {
        sss_resampler s;
        sss_begin(&s, m, &plan, origin, up, sss_hash(name, (uint32_t)i));
        sss_probe p;
        if (!sss_next_probe(&s, &p)) continue;
        r[n++] =
            chord ? st_length(st_double(p.origin)) : hypot((double)p.origin.x, (double)p.origin.y);
    }
    qsort(r, (size_t)n, sizeof *r, compare_doubles);
    for (int i = 0; i < n; ++i) {
        double within = 1.0 - beyond(m, chord, r[i]);
        worst = fmax(worst,
                     fmax(fabs(within - (double)i / lookups), fabs(within - (i + 1.0) / lookups)));
    }
    return worst * sqrt((double)lookups);
}
static void radii_follow_their_density_to_the_ends(void **state) {
    double worst = 0.0;
    (void)state;
    for (int i = 0; i < 5; ++i)
        for (int chord = 0; chord < 2; ++chord) {
            sss_medium m = i == 0 ? burley(0.8f, 1.0f, 1.0f, 1.0f)
                                  : dipole(i > 2, i & 1 ? 0.1 : 0.0, i & 1 ? 0.9 : 1.0, 1.4f);
            double distance =
                distance_of_radii(&m, chord, TEST_SEED + 100u + (uint32_t)(2 * i + chord));
            check_at_most(chord ? "sqrt(n) D of the chords' radii"
                                : "sqrt(n) D of the disks' radii",
                          distance, 2.6);
            worst = fmax(worst, distance);
        }
    print_message("10 distributions of %d radii, worst sqrt(n) D %.2f, limit 2.60\n",
                  st_samples(400000), worst);
}

/* ---- Disk and sphere probes cover the ball r <= r_max, as their intensity does, and not a
   cylinder or more. They end a shell of at most 2^-16 of r_max before it, so that at their rounded
   ends there is an intensity yet. ---- */
static double distance_from(sss_vec3 x, const sss_probe *p, double t) {
    return st_length(
        st_sum(st_sum(st_double(p->origin), st_double(p->direction), t), st_double(x), -1.0));
}
static float intensity_on(const sss_resampler *s, const sss_probe *p, double t) {
    return sss_intensity(s, st_float(st_sum(st_double(p->origin), st_double(p->direction), t)),
                         p->direction);
}
static void check_end(const char *name, const sss_resampler *s, const sss_probe *p, double t,
                      double inwards, double r_max, sss_vec3 x) {
    double distance = distance_from(x, p, t) / r_max;

    check_at_most(name, distance, 1.0);
    check_at_least(name, distance, 1.0 - ldexp(1.0, -16) - 1e-6);
    assert_true(intensity_on(s, p, t) > 0.0f);
    assert_true(intensity_on(s, p, t + inwards) > 0.0f);
    assert_true(intensity_on(s, p, t - inwards) == 0.0f);
}
static void probes_and_density_end_at_the_same_ball(void **state) {
    static const unsigned techniques[] = {SSS_DISK, SSS_DISK_TANGENTS, SSS_SPHERE};
    const sss_vec3 x = {0.25f, -0.5f, 0.125f}, n = {0.3f, -0.5f, 0.8f};
    int probes = 0;
    (void)state;
    for (int k = 0; k < 3; ++k)
        for (int t = 0; t < 3; ++t) {
            sss_medium m = k == 0   ? burley(0.8f, 1.0f, 1.0f, 1.0f)
                           : k == 1 ? burley(0.8f, 0.01f, 1.0f, 0.1f)
                                    : dipole(1, 0.1, 0.9, 1.4f);
            const sss_plan plan = {8, 1, techniques[t], 0, 0, 0};
            double r_max = (double)m.r_max, near_by = 1e-3 * r_max;
            for (uint32_t seed = 0; seed < 2000u; ++seed) {
                sss_resampler s;
                sss_begin(&s, &m, &plan, x, n, sss_hash(TEST_SEED, seed));
                sss_probe p;
                for (; sss_next_probe(&s, &p); ++probes) {
                    double end = (double)p.length;
                    if (end < 100.0 * near_by) continue; /* at the rim the ends are ill defined */
                    check_end("where a probe begins, over r_max", &s, &p, 0.0, near_by, r_max, x);
                    check_end("where it ends", &s, &p, end, -near_by, r_max, x);
                }
            }
        }
    print_message("    %d probes\n", probes);
}

/* ---- Bodies smaller than the mean free path, or than the depth h = d that the sphere probes go
 * through ---- */
static void bodies_smaller_than_the_depth(void **state) {
    static const struct {
        st_kind kind;
        double size;
    } bodies[] = {
        {ST_SPHERE, 0.2}, {ST_SPHERE, 0.05}, {ST_SLAB, 0.05}, {ST_SLAB, 1.0}, {ST_CYLINDER, 0.1}};
    static const unsigned sets[] = {0u, SSS_SPHERE | SSS_CHORD};
    sss_medium m = burley(0.8f, 1.0f, 1.0f, 1.0f);
    (void)state;
    for (int i = 0; i < 5; ++i)
        for (int t = 0; t < 2; ++t) {
            const sss_plan plan = {8, 1, sets[t], 0, 0, 0};
            st_fixture f = st_standard(bodies[i].kind, st_stay());
            f.size = i == 3
                         ? (double)m.length[0]
                         : bodies[i].size; /* h to the last bit: all lines meet the far side at o */
            double truth = (double)0.8f * st_closed_form(&f);
            st_stat got[3];
            run(&f, &m, &plan, st_light_one, NULL, TEST_SEED + 200u + (uint32_t)(2 * i + t),
                st_samples(400000), got);
            char name[80];
            snprintf(name, sizeof name, "%s %g, techniques %u", st_kind_name(f.kind), f.size,
                     plan.techniques);
            print_message("    %s %g, %s: relative variance %.2f\n", st_kind_name(f.kind), f.size,
                          t ? "sphere and chord" : "default", st_relative_variance(&got[1]));
            check_z(name, got[1].mean, st_error(&got[1]), truth, 2e-5 * truth, Z_LIMIT);
            if (t == 0 && i == 0)
                check_at_most("relative variance of the default", st_relative_variance(&got[1]),
                              5.0);
        }
}

/* ---- Light that vanishes: on the half plane x > 0 there is nine times the light ---- */
static double light_half(st_vec y) { return y.x > 0.0 ? 9.0 : 0.0; }
static double light_both(st_vec y) { return y.x > 0.0 ? 9.0 : 1.0; }
static float hint_none(st_vec y, uint32_t seed, int index) {
    (void)y, (void)seed, (void)index;
    return 0.0f;
}
static float hint_bright(st_vec y, uint32_t seed, int index) {
    (void)seed, (void)index;
    return y.x > 0.0 ? 1.0f : 0.0f;
}
static float hint_dark(st_vec y, uint32_t seed, int index) {
    (void)seed, (void)index;
    return y.x > 0.0 ? 0.0f : 1.0f;
}
static void hints_of_zero_drop_their_light_and_no_other(void **state) {
    const sss_plan plan = {8, 2, 0u, 0, 0, 0};
    sss_medium m = burley(0.8f, 1.0f, 1.0f, 1.0f);
    st_fixture f = st_standard(ST_PLANE, st_stay());
    double albedo = (double)0.8f;
    st_stat got[3];
    (void)state;
    run(&f, &m, &plan, light_both, hint_none, TEST_SEED + 300u, 20000, got);
    check_equal("light from exits where all hints are zero", got[0].mean != 0.0 || got[0].m2 != 0.0,
                0);
    run(&f, &m, &plan, light_half, hint_bright, TEST_SEED + 301u, 400000,
        got); /* zero only where no light comes */
    check_z("zero on the dark half of the hits", got[0].mean, st_error(&got[0]), 4.5 * albedo, 0.0,
            Z_LIMIT);
    run(&f, &m, &plan, light_both, hint_bright, TEST_SEED + 302u, 400000,
        got); /* loses the other half's 1 */
    check_z("zero on faint hits", got[0].mean, st_error(&got[0]), 4.5 * albedo, 0.0, Z_LIMIT);
    check_at_least("z of that bias", (5.0 * albedo - got[0].mean) / st_error(&got[0]), 20.0);
    run(&f, &m, &plan, light_both, hint_dark, TEST_SEED + 303u, 400000, got);
    check_z("zero on the only bright hits", got[0].mean, st_error(&got[0]), 0.5 * albedo, 0.0,
            Z_LIMIT);
    check_at_least("z of that bias", (5.0 * albedo - got[0].mean) / st_error(&got[0]), 20.0);
}

/* ---- One exit for three colours: their noise has a floor of C - 1 = 2, which exits divide. To
   that comes, of M probes, at most the bound of a hit over the albedo, 3 * 2 / (1/4), by M. ---- */
static void colour_noise_falls_with_exits(void **state) {
    static const int exits[] = {1, 2, 4};
    sss_medium m = burley(0.8f, 10.0f, 0.1f, 0.001f);
    st_fixture f = st_standard(ST_PLANE, st_stay());
    (void)state;
    for (int i = 0; i < 3; ++i) {
        const sss_plan plan = {256, exits[i], 0u, 0, 0, 0};
        st_stat got[3];
        run(&f, &m, &plan, st_light_one, NULL, TEST_SEED + 400u + (uint32_t)i, 12800, got);
        print_message("    %d exits: relative variance %.3f %.3f %.3f\n", exits[i],
                      st_relative_variance(&got[0]), st_relative_variance(&got[1]),
                      st_relative_variance(&got[2]));
        for (int c = 0; c < 3; ++c)
            check_at_most("relative variance of a colour", st_relative_variance(&got[c]),
                          2.0 / exits[i] + 24.0 / 256.0);
    }
}

/* ---- Sums and picks ---- */

/* All hits of a chord weigh 2 A / M: K of them sum to 2 A K / M but for K + 4 roundings. */
static void sums_of_many_weights_are_kept(void **state) {
    static const int candidates[] = {256, 65534};
    sss_medium m = burley(0.8f, 1.0f, 1.0f, 1.0f);
    st_fixture f = st_standard(ST_PLANE, st_stay());
    (void)state;
    for (int i = 0; i < 2; ++i) {
        const sss_plan plan = {candidates[i], 1, SSS_CHORD, 0, 0, 0};
        double worst = 0.0;
        for (uint32_t seed = 0; seed < (i ? 20u : 5000u); ++seed) {
            sss_vec3 x, n;
            int k = 0;
            st_entry(&f, &x, &n);
            sss_resampler s;
            assert_int_equal(sss_begin(&s, &m, &plan, x, n, sss_hash(TEST_SEED, seed)), SSS_OK);
            sss_probe probe;
            st_hit hits[ST_MAX_HITS];
            while (sss_next_probe(&s, &probe))
                if (st_trace(&f, &probe, hits))
                    sss_add_hit(&s, hits[0].position, hits[0].normal, 1.0f), ++k;
            sss_exit exit;
            assert_int_equal(sss_finish(&s, &exit), 1);
            double expected = 2.0 * (double)0.8f * k / candidates[i];
            check_relative("sum of equal weights", (double)exit.weight[0], expected,
                           (k + 4) * EPSILON);
            worst = fmax(worst, fabs((double)exit.weight[0] / expected - 1.0));
        }
        print_message("    %d candidates: worst relative error of the sum %.2g\n", candidates[i],
                      worst);
    }
}

/* The pick's numbers next to 0 and 1, by seeds that were searched for them: the only hit is held
 * whatever it weighs. */
static void the_first_hit_is_always_held(void **state) {
    sss_medium m = burley(0.8f, 1.0f, 1.0f, 1.0f);
    const sss_plan plan = {1, 1, SSS_CHORD | SSS_DISK, 0, 0, 0};
    const sss_vec3 origin = {0.0f, 0.0f, 0.0f}, up = {0.0f, 0.0f, 1.0f};
    int found = 0, held = 0;
    (void)state;
    for (uint32_t seed = 0; found < 20; ++seed) {
        uint32_t bits = sss_hash(sss_hash(seed, 0u), 0x70000000u);

        if (bits + 0x4000u > 0x8000u) continue;
        ++found;
        for (int i = 0; i < 20000; ++i) {
            sss_resampler s;
            sss_vec3 at = st_float(
                st_vec3(pow(10.0, 1.6 * st_signed((uint64_t)i)), 0.0, st_signed((uint64_t)i + 1u)));
            sss_begin(&s, &m, &plan, origin, up, seed);
            sss_probe probe;
            if (!sss_next_probe(&s, &probe)) break;
            sss_add_hit(&s, at, up, (float)exp2(20.0 * st_signed((uint64_t)i + 2u)));
            sss_exit exit;
            if (sss_finish(&s, &exit) != 1 || !(exit.weight[0] > 0.0f))
                fail_msg("seed %u: the hit at %g %g is lost", seed, (double)at.x, (double)at.z);
            ++held;
        }
    }
    print_message("%d hits held\n", held);
    check_at_least("hits held", held, 2e5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dipoles_do_not_cancel),
        cmocka_unit_test(albedo_near_one_stays_calm),
        cmocka_unit_test(radii_follow_their_density_to_the_ends),
        cmocka_unit_test(probes_and_density_end_at_the_same_ball),
        cmocka_unit_test(bodies_smaller_than_the_depth),
        cmocka_unit_test(hints_of_zero_drop_their_light_and_no_other),
        cmocka_unit_test(colour_noise_falls_with_exits),
        cmocka_unit_test(sums_of_many_weights_are_kept),
        cmocka_unit_test(the_first_hit_is_always_held),
    };
    return cmocka_run_group_tests_name("failures", tests, NULL, st_report);
}
