// test_random.c - the random numbers are uniform, and do not know of each other.
// SPDX-License-Identifier: MIT
//
// All seeds are fixed, so a result never changes by itself. Every statistic is turned into a
// z-score, limit LIMIT: of the 3000 or so of them a perfect generator fails with a probability of
// 3000 * 6.8e-6 = 2 % in all, once and for all.
#include "sss_test.h"

#define LIMIT 4.5

static double worst_z = 0.0;
static int z_count = 0;

static void check_score(const char *what, double z) {
    ++z_count;
    if (fabs(z) > worst_z) worst_z = fabs(z);
    if (!(fabs(z) <= LIMIT)) fail_msg("%s: z = %.2f, limit %.1f", what, z, LIMIT);
}

// Chi-square of counts that are all expected to be n / bins, as a z-score (Wilson and Hilferty).
static double chi_score(const long *counts, int bins, double n) {
    double sum = 0.0, k = bins - 1.0, expected = n / bins;
    for (int i = 0; i < bins; ++i)
        sum += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
    return (cbrt(sum / k) - (1.0 - 2.0 / (9.0 * k))) / sqrt(2.0 / (9.0 * k));
}

// Sums for the correlation of pairs; as a z-score it is the coefficient times sqrt(n).
typedef struct pairs {
    double n, x, y, xx, yy, xy;
} pairs;

static void add_pair(pairs *p, float x, float y) {
    double a = (double)x - 0.5, b = (double)y - 0.5;
    p->n += 1.0;
    p->x += a;
    p->y += b;
    p->xx += a * a;
    p->yy += b * b;
    p->xy += a * b;
}

static double correlation(const pairs *p) {
    double cov = p->xy - p->x * p->y / p->n, vx = p->xx - p->x * p->x / p->n,
           vy = p->yy - p->y * p->y / p->n;
    return cov / sqrt(vx * vy);
}

// ---- The unit interval

static void test_ends(void **state) {
    (void)state;
    assert_true(sssi_unit(0u) > 0.0f && sssi_unit(0xffffffffu) < 1.0f);
    assert_true(sssi_unit(0x1ffu) == sssi_unit(0u) && sssi_unit(0x200u) > sssi_unit(0u));
    assert_true((double)sssi_unit(0u) + (double)sssi_unit(0xffffffffu) == 1.0);
    assert_true(sssi_open(0.0f) > 0.0f && sssi_open(1.0f) < 1.0f && sssi_open(-1.0f) > 0.0f &&
                sssi_open(2.0f) < 1.0f);
    assert_true(sssi_open(NAN) > 0.0f && sssi_open(NAN) < 1.0f);
}

#define PIXELS  1024u
#define SAMPLES 1024u

// Mean, variance and histogram of a million numbers, in the order in which a renderer asks for
// them.
static void test_uniform(void **state) {
    double n = PIXELS * SAMPLES, sum = 0.0, squares = 0.0;
    long counts[256] = {0}, low[256] = {0};
    (void)state;
    for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
        for (uint32_t sample = 0; sample < SAMPLES; ++sample) {
            uint32_t bits = sss_hash(pixel, sample);
            double u = (double)sssi_unit(bits), x = u - 0.5;
            sum += x;
            squares += x * x;
            ++counts[(int)(256.0 * u)];
            ++low[bits & 255u];
        }
    }
    check_score("mean", sum / n / sqrt(1.0 / 12.0 / n));
    check_score("variance",
                (squares / n - 1.0 / 12.0) / sqrt(1.0 / 180.0 / n)); // the variance of x^2 is 1/180
    check_score("high bits", chi_score(counts, 256, n));
    check_score("low bits", chi_score(low, 256, n));
}

static void test_neighbours(void **state) {
    pairs pixels = {0, 0, 0, 0, 0, 0}, samples = pixels, swapped = pixels, lines = pixels;
    double limit = 4.0 / sqrt((double)(PIXELS * SAMPLES));
    (void)state;
    for (uint32_t p = 0; p < PIXELS; ++p) {
        for (uint32_t s = 0; s < SAMPLES; ++s) {
            float u = sssi_unit(sss_hash(p, s));
            add_pair(&pixels, u, sssi_unit(sss_hash(p + 1u, s)));
            add_pair(&samples, u, sssi_unit(sss_hash(p, s + 1u)));
            add_pair(&lines, u, sssi_unit(sss_hash(p + 1920u, s)));
            if (p != s) add_pair(&swapped, u, sssi_unit(sss_hash(s, p)));
        }
    }
    check_at_most("pixel and the next", fabs(correlation(&pixels)), limit);
    check_at_most("sample and the next", fabs(correlation(&samples)), limit);
    check_at_most("pixel and the one below", fabs(correlation(&lines)), limit);
    // Each pair comes up twice here, once in either order: half of the pairs are news
    check_at_most("arguments swapped", fabs(correlation(&swapped)), limit * sqrt(2.0));
}

// Each bit of either argument flips each bit of the result in half of the cases.
static void test_avalanche(void **state) {
    enum { TRIES = 20000 };
    static long flips[64][32];
    (void)state;
    for (uint64_t t = 0; t < TRIES; ++t) {
        uint32_t a = (uint32_t)(4294967296.0 * st_random(2u * t)),
                 b = (uint32_t)(4294967296.0 * st_random(2u * t + 1u));
        uint32_t h = sss_hash(a, b);
        for (int in = 0; in < 64; ++in) {
            uint32_t d =
                h ^ (in < 32 ? sss_hash(a ^ (1u << in), b) : sss_hash(a, b ^ (1u << (in - 32))));
            for (int out = 0; out < 32; ++out) flips[in][out] += d >> out & 1u;
        }
    }
    for (int in = 0; in < 64; ++in)
        for (int out = 0; out < 32; ++out)
            check_score("avalanche",
                        ((double)flips[in][out] - TRIES / 2.0) / (0.5 * sqrt((double)TRIES)));
}

// Numbers with neighbouring names fill the square evenly over seeds: names that differ in a few of
// their bits, as those of dimensions, of a walk's scatterings and of picks do.
static void square_of(uint32_t name, uint32_t other) {
    enum { SIDE = 32, SEEDS = 1 << 19 };
    static long counts[SIDE * SIDE];

    memset(counts, 0, sizeof counts);
    for (uint32_t i = 0; i < SEEDS; ++i) {
        uint32_t seed = sss_hash(i, 11u);

        ++counts[(sss_hash(seed, name) >> 27) * SIDE + (sss_hash(seed, other) >> 27)];
    }
    char what[80];
    snprintf(what, sizeof what, "names %#x and %#x", (unsigned)name, (unsigned)other);
    check_score(what, chi_score(counts, SIDE * SIDE, SEEDS));
}
static void test_names_are_independent(void **state) {
    static const uint32_t bases[] = {0u, (uint32_t)SSSI_CHORD << 10, 0x70000000u};

    (void)state;
    for (int i = 0; i < 3; ++i)
        for (uint32_t a = 0; a < 8u; ++a)
            for (uint32_t b = a + 1u; b < 8u; ++b) square_of(bases[i] + a, bases[i] + b);
    for (uint32_t a = 0; a < 16u; ++a) square_of(0x70000000u + a, 0x78000000u + a);
}

// One of n classes, each as likely, and what is left is uniform again, and knows nothing of the
// class.
static void test_classes(void **state) {
    (void)state;
    for (int n = 1; n <= 8; ++n) {
        long counts[8] = {0}, left[64] = {0};
        pairs p = {0, 0, 0, 0, 0, 0};
        for (uint32_t i = 0; i < 1u << 17; ++i) {
            float u = sssi_unit(sss_hash(i, 77u));
            int c = sssi_class(&u, n);
            assert_true(c >= 0 && c < n && u > 0.0f && u < 1.0f);
            ++counts[c];
            ++left[(int)(64.0f * u)];
            if (n > 1) add_pair(&p, (float)c / (float)n, u);
        }
        if (n > 1) check_score("classes", chi_score(counts, n, 131072.0));
        if (n > 1) check_score("class and rest", correlation(&p) * sqrt(p.n));
        check_score("what is left", chi_score(left, 64, 131072.0));
    }
}

// ---- Stratified dimensions

static float number(uint32_t seed, sssi_place at, int of) {
    sss_resampler s;

    memset(&s, 0, sizeof s);
    s.seed = seed;
    return sssi_number(&s, at, of);
}

// Number k of the n probes of a technique, where there are no others.
static sssi_place place_in_lattice(int technique, int k, int n) {
    int first[SSSI_TECHNIQUES + 1];

    for (int i = 0; i <= SSSI_TECHNIQUES; ++i) first[i] = i <= technique ? 0 : n;
    return sssi_find_place(first, k);
}
static sssi_place independent_place(int j) {
    sss_resampler s;

    memset(&s, 0, sizeof s);
    s.share[SSSI_CHORD] = 1.0f;
    return sssi_find_independent_place(&s, j);
}

// Dimensions 1..9: the seven of a technique and two of another one.
static const int dimensions[] = {0,         SSSI_CHANNEL, SSSI_PART,   SSSI_RADIUS, SSSI_TURN,
                                 SSSI_SIDE, SSSI_COSINE,  SSSI_TURN_B, SSSI_RADIUS, SSSI_TURN};
static float dimension(uint32_t seed, int k, int n, uint32_t dim) {
    return number(seed, place_in_lattice(dim > 7u ? SSSI_CHORD : SSSI_NORMAL, k, n),
                  dimensions[dim]);
}

static int compare_floats(const void *a, const void *b) {
    float x;
    memcpy(&x, a, sizeof x);
    float y;
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

// Sorted, number i lies within stratum i. Rounding may push it on the edge: i + u has ulps of n /
// 2^24.
static void test_strata(void **state) {
    (void)state;
    for (int n = 1; n <= 64; ++n) {
        for (uint32_t seed = 0; seed < 60u; ++seed) {
            for (uint32_t dim = 1; dim <= 9u; ++dim) {
                float u[64];
                double edge = n * 1.2e-7;
                for (int k = 0; k < n; ++k) u[k] = dimension(sss_hash(seed, 3u), k, n, dim);
                qsort(u, (size_t)n, sizeof *u, compare_floats);
                for (int k = 0; k < n; ++k) {
                    double x = (double)u[k] * n;
                    if (!(u[k] > 0.0f && u[k] < 1.0f && x >= k - edge && x <= k + 1 + edge))
                        fail_msg("n %d, seed %u, dimension %u: stratum %d holds %.8g", n, seed, dim,
                                 k, x);
                }
            }
        }
    }
}

static int stratum(float u, int n) {
    int i = (int)(u * (float)n);
    return i < n ? i : n - 1;
}

// Over seeds every probe visits all strata alike, and is uniform inside them.
static void test_strata_are_uniform(void **state) {
    static const int sizes[] = {2, 3, 4, 5, 7, 8, 13, 16, 24, 32, 64};
    enum { SEEDS = 40000 };
    int n;
    uint32_t dim;
    (void)state;
    for (int i = 0; i < 11; ++i) {
        n = sizes[i];
        for (int k = 0; k<n; k += n> 16 ? 5 : 1) {
            long counts[64] = {0}, inside[32] = {0};
            dim = 1u + (uint32_t)k % 9u;
            for (uint32_t seed = 0; seed < SEEDS; ++seed) {
                float u = dimension(sss_hash(seed, 9u), k, n, dim);
                int at = stratum(u, n);
                ++counts[at];
                ++inside[stratum(u * (float)n - (float)at, 32)];
            }
            check_score("strata", chi_score(counts, n, SEEDS));
            check_score("inside a stratum", chi_score(inside, 32, SEEDS));
        }
    }
}

// The strata of two dimensions of one probe fill the square evenly: correlation zero would not say
// as much.
static void test_dimensions_are_independent(void **state) {
    enum { SEEDS = 20000 };
    static const int sizes[] = {1, 4, 7, 8};
    (void)state;
    for (int i = 0; i < 4; ++i) {
        for (uint32_t a = 1; a <= 9u; ++a) {
            for (uint32_t b = a + 1u; b <= 9u; ++b) {
                long counts[64] = {0};
                pairs p = {0, 0, 0, 0, 0, 0};
                int n = sizes[i], k = (int)(a + b) % n, bins = n == 1 ? 8 : n;
                for (uint32_t seed = 0; seed < SEEDS; ++seed) {
                    float x = dimension(sss_hash(seed, 5u), k, n, a),
                          y = dimension(sss_hash(seed, 5u), k, n, b);
                    add_pair(&p, x, y);
                    ++counts[stratum(x, bins) * bins + stratum(y, bins)];
                }
                check_score("correlation of dimensions", correlation(&p) * sqrt(p.n));
                check_score("square of strata", chi_score(counts, bins * bins, SEEDS));
            }
        }
    }
}

// Within one lookup, too, the order of one dimension says nothing about that of another.
static void test_orders_are_independent(void **state) {
    (void)state;
    for (uint32_t a = 1; a <= 9u; ++a) {
        for (uint32_t b = a + 1u; b <= 9u; ++b) {
            st_stat slope = {0.0, 0.0, 0.0};
            for (uint32_t seed = 0; seed < 4000u; ++seed) {
                double sum = 0.0;
                for (int k = 0; k < 8; ++k) {
                    uint32_t s = sss_hash(seed, 6u);
                    sum += ((double)dimension(s, k, 8, a) - 0.5) *
                           ((double)dimension(s, k, 8, b) - 0.5);
                }
                st_add(&slope, sum);
            }
            check_score("orders", slope.mean / st_error(&slope));
        }
    }
}

// Independent probes: one stratum, so every probe of a lookup must be a number of its own.
static void test_independent_probes(void **state) {
    (void)state;
    for (uint32_t dim = 1; dim <= 9u; ++dim) {
        long counts[64] = {0};
        pairs next = {0, 0, 0, 0, 0, 0};
        for (uint32_t seed = 0; seed < 40000u; ++seed) {
            float x = number(sss_hash(seed, 8u), independent_place(0), dimensions[dim]),
                  y = number(sss_hash(seed, 8u), independent_place(1), dimensions[dim]);
            add_pair(&next, x, y);
            ++counts[stratum(x, 64)];
        }
        check_score("one stratum", chi_score(counts, 64, 40000.0));
        check_score("probe and the next", correlation(&next) * sqrt(next.n));
    }
}

// The number that picks a hit, seen through the pick itself: of two hits of equal weight the second
// is taken in half of the lookups, whatever radius its probe had. A number that served both would
// show at once.
static void pick_against_radius(unsigned technique, int t, int of) {
    static const float albedo[3] = {0.8f, 0.8f, 0.8f}, length[3] = {1.0f, 1.0f, 1.0f};
    const sss_vec3 up = {0.0f, 0.0f, 1.0f}, at = {0.3f, 0.0f, 0.0f}, also = {0.0f, 0.3f, 0.0f};
    pairs first = {0, 0, 0, 0, 0, 0}, last = first;
    sss_medium m;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    int independent;
    for (uint32_t seed = 0; seed < 40000u; ++seed) {
        sss_plan plan = {2, 1, 0u, 0, 0, 0};
        independent = (int)(seed % 2u);
        plan.techniques = technique;
        plan.independent = independent;
        sss_resampler s;
        assert_int_equal(sss_begin(&s, &m, &plan, up, up, sss_hash(seed, 4u)), SSS_OK);
        float u[2];
        for (int k = 0; k < 2; ++k)
            u[k] = independent ? number(s.seed, independent_place(k), of)
                               : number(s.seed, place_in_lattice(t, k, 2), of);
        sss_probe probe;
        while (sss_next_probe(&s, &probe)) {
            sss_vec3 p = s.next == 1 ? at : also;
            p.z = 1.0f;
            sss_add_hit(&s, p, up, 1.0f);
        }
        sss_exit exits[SSS_MAX_EXITS];
        if (sss_finish(&s, exits) != 1 || s.weighed != 2) continue;
        add_pair(&first, u[0], exits[0].position.y > 0.1f ? 1.0f : 0.0f);
        add_pair(&last, u[1], exits[0].position.y > 0.1f ? 1.0f : 0.0f);
    }
    check_at_least("lookups with two hits", first.n, 30000.0);
    check_score("the second of two is picked", 2.0 * first.y / sqrt(first.n));
    check_score("pick and radius", correlation(&first) * sqrt(first.n));
    check_score("pick and radius", correlation(&last) * sqrt(last.n));
}

static void test_pick(void **state) {
    (void)state;
    pick_against_radius(SSS_DISK, SSSI_NORMAL, SSSI_RADIUS);
    pick_against_radius(SSS_SPHERE, SSSI_SPHERE, SSSI_COSINE);
    pick_against_radius(SSS_CHORD, SSSI_CHORD, SSSI_RADIUS);
}

static int report(void **state) {
    (void)state;
    print_message("%d z-scores, worst %.2f; false alarms %.1g\n", z_count, worst_z,
                  z_count * erfc(LIMIT / sqrt(2.0)));
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_uniform),
        cmocka_unit_test(test_neighbours),
        cmocka_unit_test(test_avalanche),
        cmocka_unit_test(test_names_are_independent),
        cmocka_unit_test(test_classes),
        cmocka_unit_test(test_strata),
        cmocka_unit_test(test_strata_are_uniform),
        cmocka_unit_test(test_dimensions_are_independent),
        cmocka_unit_test(test_orders_are_independent),
        cmocka_unit_test(test_independent_probes),
        cmocka_unit_test(test_pick),
    };
    return cmocka_run_group_tests_name("random numbers", tests, NULL, report);
}
