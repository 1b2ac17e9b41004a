// test_math.c - the header's own mathematics is as accurate as the header says: elementary
// functions, inverse samplers, frames. With --long every float of each domain is tried.
// SPDX-License-Identifier: MIT
#include "sss_test.h"

// What the header states in its comment on mathematics. All else in this file follows from these
// and from rounding.
#define EXP_ULP    1.1
#define EXPM1_ULP  1.8
#define LOG_ULP    1.0
#define TURN_ERROR 1e-7
#define HALF_ULP   5.9604644775390625e-8 // 2^-24, the relative error of one rounding

static int exhaustive = 0;

// ---- Worst cases

typedef struct worst {
    double error;
    float at;
} worst;

// A NaN counts as infinitely wrong.
static double safe(double error) { return error >= 0.0 ? error : (double)INFINITY; }

static void take(worst *w, double error, float at) {
    error = safe(error);
    if (error > w->error) {
        w->error = error;
        w->at = at;
    }
}

static int limits = 0;
static double nearest = 0.0; // to its limit
static void expect_below(const char *what, worst w, double limit) {
    ++limits;
    nearest = fmax(nearest, w.error / limit);
    print_message("    %-34s worst %.4g at %.9g, limit %.4g\n", what, w.error, (double)w.at, limit);
    check_at_most(what, w.error, limit);
}

// The error in units of the spacing of floats about the exact value.
static double ulps(float computed, double exact) {
    int exponent;
    (void)frexp(exact, &exponent);
    if (exponent < -125) exponent = -125;
    return fabs((double)computed - exact) / ldexp(1.0, exponent - 24);
}

// Error of one function at one argument, in the unit of its limit.
typedef double (*error_of)(float x);

// About `count` floats from first to last, even in their bits, or with count 0 all; first and last
// have one sign.
static worst sweep_bits(error_of f, float first, float last, uint32_t count) {
    uint32_t low = sssi_bits(first), high = sssi_bits(last);
    uint32_t stride = count == 0u ? 1u : (high - low) / count | 1u;
    int64_t n = (high - low) / stride;
    worst all = {0.0, 0.0f};
#pragma omp parallel
    {
        worst mine = {0.0, 0.0f};
#pragma omp for nowait
        for (int64_t i = 0; i <= n; ++i) {
            float x = sssi_float(low + (uint32_t)i * stride);
            take(&mine, f(x), x);
        }
#pragma omp critical
        if (mine.error > all.error) all = mine;
    }
    take(&all, f(last), last);
    return all;
}

// Even steps in value, each moved within its step, so that the low bits of the arguments vary as
// well.
static worst sweep_values(error_of f, float first, float last, int count) {
    worst all = {0.0, 0.0f};
    for (int i = 0; i < count; ++i) {
        float u = ((float)i + sssi_unit(sss_hash((uint32_t)i, 1u))) / (float)count,
              x = first + (last - first) * u;
        take(&all, f(x), x);
    }
    return all;
}

static worst greater(worst a, worst b) { return b.error > a.error ? b : a; }

static worst sweep(error_of f, float first, float last) {
    if (exhaustive) return sweep_bits(f, first, last, 0u);
    return greater(sweep_bits(f, first, last, 1u << 22), sweep_values(f, first, last, 1 << 22));
}

// ---- Elementary functions

static double exp_error(float x) { return ulps(sssi_exp(x), exp((double)x)); }
static double expm1_error(float x) { return ulps(sssi_expm1(x), expm1((double)x)); }
static double log_error(float x) { return ulps(sssi_log(x), log((double)x)); }
static double mean_exp_error(float x) {
    double t = (double)x;
    return ulps(sssi_mean_exp(x), t > 0.0 ? -expm1(-t) / t : 1.0);
}
static double sin_error(float u) {
    float s, c;
    sssi_sincos_turn(u, &s, &c);
    return fabs((double)s - sin(6.283185307179586477 * (double)u));
}
static double cos_error(float u) {
    float s, c;
    sssi_sincos_turn(u, &s, &c);
    return fabs((double)c - cos(6.283185307179586477 * (double)u));
}

// From the smallest float: -0, 0 and denormals are arguments too.
static void test_exp(void **state) {
    worst negative = sweep(exp_error, -1e-45f, -70.0f), positive = sweep(exp_error, 1e-45f, 80.0f);
    (void)state;
    expect_below("exp on [-70, 0], ulp", negative, EXP_ULP);
    expect_below("exp on [0, 80], ulp", positive, EXP_ULP);
    assert_true(sssi_exp(0.0f) == 1.0f && sssi_exp(-0.0f) == 1.0f);
}

// Below its least argument the exponential stays where it is: far away no ratio of profiles is 0/0.
static void test_exp_floor(void **state) {
    float least = sssi_exp(-70.0f);
    (void)state;
    assert_true(least > 0.0f && least < 1e-30f);
    assert_true(sssi_exp(-70.00001f) == least && sssi_exp(-1e30f) == least &&
                sssi_exp(-INFINITY) == least);
    assert_true(sssi_expm1(-1e30f) == -1.0f && sssi_expm1(-INFINITY) == -1.0f);
}

static void test_expm1(void **state) {
    worst negative = sweep(expm1_error, -1.17549435e-38f, -70.0f),
          positive = sweep(expm1_error, 1.17549435e-38f, 80.0f);
    (void)state;
    expect_below("expm1 on [-70, 0], ulp", negative, EXPM1_ULP);
    expect_below("expm1 on [0, 80], ulp", positive, EXPM1_ULP);
    assert_true(sssi_expm1(0.0f) == 0.0f);
}

// expm1 and one division; a quotient may lie in a lower binade than its numerator, where one ulp
// weighs twice.
static void test_mean_exp(void **state) {
    (void)state;
    expect_below("(1 - e^-t) / t on [0, 70], ulp", sweep(mean_exp_error, 1.17549435e-38f, 70.0f),
                 2.0 * EXPM1_ULP + 0.5);
    assert_true(sssi_mean_exp(0.0f) == 1.0f);
    assert_true(sssi_mean_exp(1e30f) > 0.0f && sssi_mean_exp(INFINITY) >= 0.0f);
}

static void test_log(void **state) {
    worst used = sweep(log_error, 5.9604645e-8f, 1.0f),
          all = sweep(log_error, 1.17549435e-38f, 3.402823466e38f);
    (void)state;
    expect_below("log on [2^-24, 1], ulp", used, LOG_ULP);
    expect_below("log of all normal floats, ulp", all, LOG_ULP);
    assert_true(sssi_log(1.0f) == 0.0f);
}

static void test_sincos(void **state) {
    static const float quarter[5][3] = {
        {0, 0, 1}, {0.25f, 1, 0}, {0.5f, 0, -1}, {0.75f, -1, 0}, {1, 0, 1}};
    (void)state;
    expect_below("sin of a turn, absolute", sweep(sin_error, 0.0f, 1.0f), TURN_ERROR);
    expect_below("cos of a turn, absolute", sweep(cos_error, 0.0f, 1.0f), TURN_ERROR);
    float s, c;
    for (int i = 0; i < 5; ++i) {
        sssi_sincos_turn(quarter[i][0], &s, &c);
        assert_true(s == quarter[i][1] && c == quarter[i][2]);
    }
}

// ---- Inverse samplers. Each must hit its own survival function: S(radius(u)) = u, S in double
// precision.

static float sampler_length = 1.0f; // d or z of the samplers below

static double burley_tail(double t) { return 0.25 * exp(-t) * (3.0 + exp(-2.0 * t)); } // t = r / 3d
static double burley_chord_tail(double t) {
    return 0.75 * exp(-t) * (1.0 + 0.5 * t) + 0.25 * exp(-3.0 * t) * (1.0 + 1.5 * t);
}
static double pole_cosine(double r) {
    return 1.0 / sqrt(1.0 + r * r / ((double)sampler_length * (double)sampler_length));
}

static double burley_radius_error(float u) {
    double t = (double)sssi_burley_radius(sampler_length, u) / (3.0 * (double)sampler_length);
    return fabs(burley_tail(t) / (double)u - 1.0);
}
// The tail of the law that number `i` of the eight parts of a chord's radius draws, and how far the
// radius is from having it: in units of the rounding that must be allowed for. The logarithm has
// one ulp, the product of the two numbers half of one, and the radius two, of 3 d and of the
// product; the latter move the tail's logarithm by t each.
static double burley_chord_part_tail(int i, double t) {
    double s = i < 6 ? t : 3.0 * t;
    return i % 2 ? exp(-s) * (1.0 + s) : exp(-s);
}
static int chord_part; // of the eight
static double burley_chord_error(float u) {
    float part = ((float)chord_part + (float)(sss_hash(sssi_bits(u), 1u) >> 13 | 1u) / 524288.0f) /
                 8.0f; // exact
    double t = (double)sssi_burley_chord(sampler_length, part, u) / (3.0 * (double)sampler_length);
    double s = chord_part < 6 ? t : 3.0 * t, rest = (double)part * 8.0 - chord_part;
    return fabs(exp(-s) / ((double)u * (chord_part % 2 ? rest : 1.0)) - 1.0) /
           ((1.0 + 4.0 * s) * HALF_ULP);
}
static double pole_radius_error(float u) {
    return fabs(pole_cosine((double)sssi_pole_radius(sampler_length, u)) / (double)u - 1.0);
}
static double pole_chord_error(float u) {
    double c = pole_cosine((double)sssi_pole_chord(sampler_length, u));
    return fabs((3.0 * c - c * c * c) / 2.0 - (double)u);
}

// Every number of sssi_unit, in make test every fifth; and, as stratified numbers may be any floats
// from 2^-24, many of those too, or all.
static worst sweep_unit(error_of f, int all_floats) {
    worst all = sweep_bits(f, SSSI_NUDGE, all_floats ? 1.0f - SSSI_NUDGE : 0.01f,
                           all_floats ? 0u : 1u << 21);
    int32_t step = exhaustive ? 1 : 5;
#pragma omp parallel
    {
        worst mine = {0.0, 0.0f};
#pragma omp for nowait
        for (int32_t i = 0; i < 1 << 23; i += step) {
            float u = sssi_unit((uint32_t)i << 9);
            take(&mine, f(u), u);
        }
#pragma omp critical
        if (mine.error > all.error) all = mine;
    }
    take(&all, f(1.0f - SSSI_NUDGE), 1.0f - SSSI_NUDGE);
    return all;
}

static void expect_sampler(const char *what, error_of f, double limit) {
    static const float length[] = {1.0f, 1.7f, 0.037f};
    worst all = {0.0, 0.0f};
    for (size_t i = 0; i < sizeof length / sizeof *length; ++i) {
        sampler_length = length[i];
        all = greater(all, sweep_unit(f, exhaustive && i == 0));
    }
    expect_below(what, all, limit);
}

static void test_burley_radius(void **state) {
    (void)state;
    expect_sampler("tail of Burley's radius, relative", burley_radius_error, 5e-6);
}

// Each part by its own inverse (an exponential, or the sum of two); together they must be the
// chord's law.
static void test_burley_chord(void **state) {
    (void)state;
    sampler_length = 1.7f;
    for (chord_part = 0; chord_part < 8; ++chord_part)
        expect_below("a part of Burley's chord, of rounding",
                     sweep_unit(burley_chord_error, exhaustive), 1.0);
    for (double t = 0.0; t < 40.0; t += 0.01) {
        double sum = 0.0;
        for (int i = 0; i < 8; ++i) sum += burley_chord_part_tail(i, t) / 8.0;
        if (!(fabs(sum - burley_chord_tail(t)) <= 1e-14))
            fail_msg("the eight parts at t = %g: %.17g", t, sum);
    }
}

// Six roundings lie between u and the radius (two of them under a root), and the cosine follows the
// radius at most one to one.
static void test_pole_radius(void **state) {
    (void)state;
    expect_sampler("tail of a pole's radius, relative", pole_radius_error, 6.0 * HALF_ULP);
}

// The cosine is 1 - e, so it is known to about one rounding of 1, not of itself, and S' = 3/2 (1 -
// c^2) <= 3/2; the residual of the last step of Newton has about two roundings of 1 more.
static void test_pole_chord(void **state) {
    (void)state;
    expect_sampler("tail of a pole's chord, absolute", pole_chord_error, 3.5 * HALF_ULP);
}

// ---- Vectors

static double dot(sss_vec3 a, sss_vec3 b) { return st_dot(st_double(a), st_double(b)); }

static sss_vec3 vector(float x, float y, float z) { return sssi_vec3(x, y, z); }

static double frame_error(sss_vec3 n) {
    sss_vec3 t, b;
    double most = 0.0;
    sssi_frame(n, &t, &b);
    double e[5];
    e[0] = dot(t, t) - 1.0;
    e[1] = dot(b, b) - 1.0;
    e[2] = dot(t, b);
    e[3] = dot(t, n);
    e[4] = dot(b, n);
    for (int i = 0; i < 5; ++i)
        if (!(fabs(e[i]) <= most)) most = safe(fabs(e[i]));
    return most;
}

// Most normals anywhere, one in four within a small distance of a pole or of the equator.
static sss_vec3 some_normal(uint32_t i) {
    sss_vec3 n;
    float small = sssi_exp(-30.0f * sssi_unit(sss_hash(i, 4u)));
    n.x = 2.0f * sssi_unit(sss_hash(i, 1u)) - 1.0f;
    n.y = 2.0f * sssi_unit(sss_hash(i, 2u)) - 1.0f;
    n.z = 2.0f * sssi_unit(sss_hash(i, 3u)) - 1.0f;
    if (i % 8u == 0u) n = vector(n.x * small, n.y * small, n.z > 0.0f ? 1.0f : -1.0f);
    if (i % 8u == 1u) n.z *= small;
    return n;
}

static void test_frame(void **state) {
    static const float ends[] = {-1.0f,   -0.0f,  0.0f,    1.0f,  1e-45f,
                                 -1e-45f, 1e-20f, -1e-20f, 6e-8f, -6e-8f};
    int32_t n = exhaustive ? 20000000 : 2000000;
    worst all = {0.0, 0.0f};
    (void)state;
#pragma omp parallel
    {
        worst mine = {0.0, 0.0f};
#pragma omp for nowait
        for (int32_t i = 0; i < n; ++i) {
            sss_vec3 v = some_normal((uint32_t)i);
            if (sssi_normalize(&v)) take(&mine, frame_error(v), v.z);
        }
#pragma omp critical
        if (mine.error > all.error) all = mine;
    }
    for (int32_t i = 0; i < 1000; ++i) {
        sss_vec3 v = vector(ends[i % 10], ends[i / 10 % 10], ends[i / 100]);
        if (sssi_normalize(&v)) take(&all, frame_error(v), v.z);
    }
    expect_below("frames, from orthonormal", all, 1e-6);
}

// How far from the unit vector in the same direction, scaled by a power of two so that nothing
// under- or overflows.
static double normalize_error(sss_vec3 v) {
    sss_vec3 unit = v;
    double length = sqrt(dot(v, v));
    if (!sssi_normalize(&unit)) return (double)INFINITY;
    double x = (double)v.x / length - (double)unit.x;
    double y = (double)v.y / length - (double)unit.y;
    double z = (double)v.z / length - (double)unit.z;
    return sqrt(x * x + y * y + z * z);
}

static void test_normalize(void **state) {
    static const float scale[] = {1.0f,   1e-45f, 3e-42f, 1e-38f, 1e-20f,
                                  1e-12f, 1e12f,  1e19f,  1e30f,  3.4e38f};
    worst all = {0.0, 0.0f};
    (void)state;
    for (uint32_t i = 0; i < 1000000u; ++i) {
        sss_vec3 v = some_normal(i);
        float k = scale[i / 8u % 10u];
        v = vector(v.x * k, v.y * k, v.z * k);
        if (dot(v, v) > 0.0) take(&all, normalize_error(v), k);
    }
    expect_below("unit vectors, distance", all, 4.0 * HALF_ULP);
}

// A vector without a direction is refused.
static void test_normalize_refuses(void **state) {
    static const float bad[] = {0.0f, -0.0f, NAN, INFINITY, -INFINITY};
    (void)state;
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 3; ++k) {
            float other = i < 2 ? 0.0f : 1.0f;
            sss_vec3 v =
                vector(k == 0 ? bad[i] : other, k == 1 ? bad[i] : other, k == 2 ? bad[i] : other);
            assert_false(sssi_normalize(&v));
        }
    }
}

static int report(void **state) {
    (void)state;
    print_message("%d worst errors, the nearest to its limit at %.2f of it\n", limits, nearest);
    return 0;
}

int main(int count, char **words) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exp),
        cmocka_unit_test(test_exp_floor),
        cmocka_unit_test(test_expm1),
        cmocka_unit_test(test_mean_exp),
        cmocka_unit_test(test_log),
        cmocka_unit_test(test_sincos),
        cmocka_unit_test(test_burley_radius),
        cmocka_unit_test(test_burley_chord),
        cmocka_unit_test(test_pole_radius),
        cmocka_unit_test(test_pole_chord),
        cmocka_unit_test(test_frame),
        cmocka_unit_test(test_normalize),
        cmocka_unit_test(test_normalize_refuses),
    };
    exhaustive = (count > 1 && strcmp(words[1], "--long") == 0);
    return cmocka_run_group_tests_name("mathematics", tests, NULL, report);
}
