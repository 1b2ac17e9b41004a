// test_profiles.c - the diffusion profiles, their integrals, the Fresnel moments, the inversion and
// the proposals are what their formulas say. SPDX-License-Identifier: MIT
#include "sss_test.h"

#define HALF_ULP 5.9604644775390625e-8 // 2^-24, the relative error of one rounding

typedef sss_result constructor(sss_medium *m, const float a[3], const float b[3], float eta);

static void three(float *to, double x) { to[0] = to[1] = to[2] = (float)x; }

typedef sss_result burley_constructor(sss_medium *m, const float a[3], const float b[3]);
static sss_medium grey_burley(burley_constructor *make, double albedo, double path) {
    float a[3];
    three(a, albedo);
    float l[3];
    three(l, path);
    sss_medium m;
    assert_int_equal(make(&m, a, l), SSS_OK);
    return m;
}

static sss_medium grey(constructor *make, double a, double b, double eta) {
    float x[3];
    three(x, a);
    float y[3];
    three(y, b);
    sss_medium m;
    assert_int_equal(make(&m, x, y, (float)eta), SSS_OK);
    return m;
}

// ---- Against the reference table

// What float32 may add: 2e-6, and the rounding of the exponent. About nine roundings lead from the
// arguments to sigma_tr d_z or r / 3d; each is at most 2^-24 of the exponent and they partly
// cancel, as sqrt(9) / 2 of them.
static double allowed(double exponent) { return 2e-6 + 1.5 * HALF_ULP * exponent; }

typedef struct row {
    char profile[32], params[96];
    double r, value, tail, total;
} row;

static int read_row(FILE *file, row *to) {
    char line[400];
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "%31[a-zA-Z_],\"%95[^\"]\",%lf,%lf,%lf,%lf", to->profile, to->params,
                   &to->r, &to->value, &to->tail, &to->total) == 6)
            return 1;
    return 0;
}

static FILE *open_table(const char *name) {
    char path[400];
    snprintf(path, sizeof path, "%s/%s", DATA_DIR, name);
    FILE *file = fopen(path, "r");
    if (!file) fail_msg("cannot read %s", path);
    return file;
}

// The medium of a row and the exponent at its radius; 0 where the library does not offer the
// profile.
static int medium_of(const row *from, sss_medium *m, double *exponent) {
    double alpha, sigma, eta;
    if (sscanf(from->params, "alpha'=%lf;sigma_t'=%lf;eta=%lf", &alpha, &sigma, &eta) == 3) {
        int better = strcmp(from->profile, "better_dipole") == 0;
        *m = grey(better ? sss_better_dipole : sss_dipole, (1.0 - alpha) * sigma, alpha * sigma,
                  eta);
        *exponent = (double)m->sigma[0] * sqrt(from->r * from->r + 1.0 / (sigma * sigma));
        return 1;
    }
    double albedo, length, s, d;
    if (sscanf(from->params, "A=%lf;l=%lf;s=%lf;d=%lf", &albedo, &length, &s, &d) != 4)
        fail_msg("%s", from->params);
    float a[3];
    three(a, albedo);
    float b[3];
    three(b, length);
    *exponent = from->r / (3.0 * d);
    if (strcmp(from->profile, "burley_sD") == 0) return sss_burley_mfp(m, a, b) == SSS_OK;
    if (strcmp(from->profile, "burley_sM") == 0) return sss_burley(m, a, b) == SSS_OK;
    return 0; // burley_sN, eq. 5
}

typedef struct errors {
    double profile, within, tail, total;
} errors;

static void take(double *worst, double computed, double exact) {
    double error = exact == 0.0 ? fabs(computed) : fabs(computed / exact - 1.0);
    if (!(error <= *worst)) *worst = error;
}

// The radius as a float: a tail that falls as e^-x moves by x roundings of r with it.
static void compare_row(const row *from, const sss_medium *m, double exponent, errors *worst) {
    char name[200];
    float r = (float)from->r;
    double limit = allowed(exponent), profile = (double)sss_profile(m, 1, r),
           within = (double)sss_within(m, 1, r);
    double tail = (double)m->albedo[1] * (double)sssi_tail(m, 1, r);
    snprintf(name, sizeof name, "%s %s r=%g", from->profile, from->params, from->r);
    check_relative(name, profile, from->value, limit);
    check_relative(name, tail, from->tail, limit);
    check_relative(name, within, from->total - from->tail, 2e-6);
    check_relative(name, (double)m->albedo[1], from->total, 2e-6);
    take(&worst->profile, profile, from->value);
    take(&worst->tail, tail, from->tail);
    take(&worst->within, within, from->total - from->tail);
    take(&worst->total, (double)m->albedo[1], from->total);
}

static void test_reference(void **state) {
    FILE *file = open_table("profile_reference.csv");
    errors worst = {0.0, 0.0, 0.0, 0.0};
    row from;
    int compared = 0, skipped = 0;
    (void)state;
    while (read_row(file, &from)) {
        sss_medium m;
        double exponent;
        if (!medium_of(&from, &m, &exponent)) {
            ++skipped;
            continue;
        }
        compare_row(&from, &m, exponent, &worst);
        ++compared;
    }
    fclose(file);
    print_message(
        "    %d rows, %d of a profile that is not offered skipped; worst relative errors:\n"
        "    Rd %.2g, tail %.2g, within %.2g, total %.2g\n",
        compared, skipped, worst.profile, worst.tail, worst.within, worst.total);
    check_equal("rows compared", compared, 280);
    check_equal("rows skipped", skipped, 50);
}

// ---- The whole domain

// Rd in long double from what the constructor was given, where the difference of the two waves does
// not cancel: at most 1e-8 of its 64 bits are lost at 1e4 z_r.
typedef struct precise {
    int dipole;
    long double scale, d, zr, zv, s, flux, fluence;
} precise;

static precise precise_burley(double albedo, double path, int diffuse) {
    precise p;
    double s = diffuse ? 1.9 - albedo + 3.5 * (albedo - 0.8) * (albedo - 0.8) : st_burley_s(albedo);
    memset(&p, 0, sizeof p);
    p.scale = (long double)albedo;
    p.d = (long double)path / (long double)s;
    return p;
}
static precise precise_dipole(double sigma_a, double sigma_s, double eta, int better) {
    st_profile q = st_dipole(sigma_a, sigma_s, eta, better);
    precise p;
    memset(&p, 0, sizeof p);
    p.dipole = 1;
    p.zr = (long double)q.zr;
    p.zv = (long double)q.zv;
    p.s = (long double)q.s;
    p.flux = (long double)q.flux;
    p.fluence = (long double)q.fluence;
    return p;
}
static long double precise_rd(const precise *p, long double r) {
    if (!p->dipole)
        return p->scale * (expl(-r / p->d) + expl(-r / (3.0L * p->d))) /
               (8.0L * (long double)ST_PI * p->d * r);
    long double dr = sqrtl(r * r + p->zr * p->zr);
    long double dv = sqrtl(r * r + p->zv * p->zv);
    return p->flux * (p->zr * (1.0L + p->s * dr) * expl(-p->s * dr) / (dr * dr * dr) +
                      p->zv * (1.0L + p->s * dv) * expl(-p->s * dv) / (dv * dv * dv)) +
           p->fluence * (expl(-p->s * dr) / dr - expl(-p->s * dv) / dv);
}

// The worst relative error at up to an e-folding, in it over what is allowed, and over the number
// of e-foldings beyond.
typedef struct domain {
    double near_by, ratio, each;
    long compared;
} domain;

// Nine roundings lead to the exponent, and each is at most 2^-24 of it. Beside it a profile is a
// product of a few factors and a sum of positive terms, about 16 roundings, and exp with 1.1 ulp.
// The dipoles' moments are good to 2e-8 (2 C1 to twice that), and divided by 1 - 2 C1.
#define EACH (9.0 * HALF_ULP)
static double near_error(double eta) {
    double c1, c2;
    st_fresnel_moments(eta, &c1, &c2);
    return 18.0 * HALF_ULP + 4e-8 / (1.0 - c1);
}

static void sweep_radii(const sss_medium *m, const precise *p, double near_by, domain *worst) {
    long double unit = p->dipole ? p->zr : p->d;
    for (int k = 0; k <= 500;
         ++k) { // 1e-6 to 1e4 of the length, where the profile is above float's smallest
        float r = (float)(unit * powl(10.0L, -5.999L + 0.02L * k));
        long double exact = precise_rd(p, (long double)r);
        double exponent = (double)(p->dipole ? p->s * hypotl((long double)r, p->zr)
                                             : (long double)r / (3.0L * p->d));
        double error = fabs((double)((long double)sss_profile(m, 0, r) / exact - 1.0L));
        if (exponent > 69.0 || exact < 1e-36L) break;
        ++worst->compared;
        if (exponent <= 1.0) {
            if (!(error <= worst->near_by)) worst->near_by = error;
            if (!(error <= worst->ratio * (near_by + EACH)))
                worst->ratio = error / (near_by + EACH);
        } else if (!(error <= near_by + worst->each * exponent))
            worst->each = (error - near_by) / exponent;
    }
}

static void test_domain(void **state) {
    static const char *const names[4] = {"Burley", "Burley by mfp", "dipole", "better dipole"};
    static const double eta[] = {1.0, 1.1, 1.33, 1.5, 2.0, 5.0};
    (void)state;
    for (int which = 0; which < 4; ++which) {
        domain worst = {0.0, 0.0, 0.0, 0};
        for (int i = 0; i <= 90; ++i) // the albedo, or 1 - albedo', from 1 to 1e-9
            for (int e = 0; e < (which < 2 ? 1 : 6); ++e) {
                double x = (double)(float)pow(10.0, -i / 10.0),
                       y = (double)(float)(1.0 - 0.9999 * x), n = (double)(float)eta[e];
                precise p = which < 2 ? precise_burley(x, (double)0.37f, which)
                                      : precise_dipole(x, y, n, which == 3);
                sss_medium m = which == 0 ? grey_burley(sss_burley, x, 0.37)
                               : which == 1
                                   ? grey_burley(sss_burley_mfp, x, 0.37)
                                   : grey(which == 2 ? sss_dipole : sss_better_dipole, x, y, n);
                sweep_radii(&m, &p, near_error(which < 2 ? 1.0 : n), &worst);
            }
        print_message("    %s: %ld radii, worst relative error of Rd %.2g within an e-folding, "
                      "then %.2g each\n",
                      names[which], worst.compared, worst.near_by, worst.each);
        check_at_most(names[which], worst.ratio, 1.0);
        check_at_most(names[which], worst.each, EACH);
    }
}

// ---- Ends of the range

static int all_media(sss_medium *to) {
    static const double albedo[] = {1e-4, 0.2, 0.8, 0.99, 0.999999};
    int n = 0;
    for (int i = 0; i < 5; ++i) {
        to[n++] = grey_burley(sss_burley, albedo[i], 0.37);
        to[n++] = grey_burley(sss_burley_mfp, albedo[i], 0.37);
        to[n++] = grey(sss_dipole, 2.7 * (1.0 - albedo[i]), 2.7 * albedo[i], 1.4);
        to[n++] = grey(sss_better_dipole, 2.7 * (1.0 - albedo[i]), 2.7 * albedo[i], 1.0);
        to[n++] = grey(sss_dipole_from_albedo, albedo[i], 0.37, 1.33);
        to[n++] = grey(sss_better_dipole_from_albedo, albedo[i], 0.37, 0.8);
    }
    return n;
}

static void test_ends(void **state) {
    sss_medium media[30];
    int n = all_media(media);
    (void)state;
    for (int i = 0; i < n; ++i) {
        const sss_medium *m = &media[i];
        float albedo = m->albedo[0], floor = 1e-6f * m->length[0],
              at_floor = sss_profile(m, 0, floor);
        assert_true(at_floor > 0.0f);
        check_relative("Rd(0)", (double)sss_profile(m, 0, 0.0f), (double)at_floor, 2e-6);
        check_relative("Rd(1e-9 length)", (double)sss_profile(m, 0, 1e-3f * floor),
                       (double)at_floor, 2e-6);
        check_relative("Rd(least float)", (double)sss_profile(m, 0, 1e-45f), (double)at_floor,
                       2e-6);
        assert_true(sss_profile(m, 0, -0.0f) == sss_profile(m, 0, 0.0f));
        assert_true(sss_within(m, 0, 0.0f) == 0.0f);
        assert_true(sss_within(m, 0, INFINITY) == albedo && sss_within(m, 0, 3.4e38f) == albedo);
        check_at_most("Rd(huge)", (double)sss_profile(m, 0, 3.4e38f), 1e-8 * (double)at_floor);
        check_at_most("Rd(Inf)", (double)sss_profile(m, 0, INFINITY), 1e-8 * (double)at_floor);
        check_at_least("Rd(Inf)", (double)sss_profile(m, 0, INFINITY), 0.0);
        assert_true(sss_profile(m, 0, NAN) == 0.0f && sss_within(m, 0, NAN) == 0.0f);
        assert_true(sss_profile(m, 0, -1.0f) == 0.0f && sss_within(m, 0, -1.0f) == 0.0f);
    }
}

static void test_channels(void **state) {
    static const int wrong[] = {-1, 3, 4, INT32_MAX, INT32_MIN};
    static const float albedo[3] = {0.0f, 0.7f, 0.5f}, length[3] = {1.0f, 0.0f, 2.0f};
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    for (int i = 0; i < 5; ++i)
        assert_true(sss_profile(&m, wrong[i], 1.0f) == 0.0f &&
                    sss_within(&m, wrong[i], 1.0f) == 0.0f);
    assert_true(sss_profile(&m, 0, 1.0f) == 0.0f && sss_within(&m, 0, 1.0f) == 0.0f); // black
    assert_true(sss_profile(&m, 1, 1.0f) == 0.0f && sss_within(&m, 1, 0.0f) == 0.7f); // Lambert
    assert_true(sss_profile(&m, 2, 1.0f) > 0.0f && sss_within(&m, 2, 1.0f) > 0.0f);
}

static void test_falls(void **state) {
    sss_medium media[30];
    int n = all_media(media);
    (void)state;
    for (int i = 0; i < n; ++i) {
        double before = (double)INFINITY, less = -1.0;
        for (int k = 0; k < 400; ++k) {
            float r = media[i].length[0] * (float)pow(10.0, -5.0 + 0.02 * k);
            double value = (double)sss_profile(&media[i], 0, r),
                   within = (double)sss_within(&media[i], 0, r);
            check_at_most("a profile falls", value, before * (1.0 + 1e-6));
            check_at_least("what is within grows", within, less * (1.0 - 1e-6));
            before = value;
            less = within;
        }
    }
}

// 2 pi r Rd, integrated with r = R x^2, which takes Burley's pole away. Below 1e-6 of the length
// the profile is level where the true one grows as 1/r: of what is within that radius a half is
// left to add.
static double integral(const sss_medium *m, double radius) {
    double sum = m->dipole ? 0.0 : 0.5 * (double)sss_within(m, 0, 1e-6f * m->length[0]);
    for (int i = 0; i < 6000; ++i) {
        double w, x = st_node(0.0, 1.0, 2000, i, &w), r = radius * x * x;
        sum += w * 2.0 * ST_PI * r * (double)sss_profile(m, 0, (float)r) * 2.0 * radius * x;
    }
    return sum;
}

static void test_integral(void **state) {
    static const double part[] = {0.02, 0.3, 1.0, 4.0, 15.0};
    sss_medium media[30];
    double worst = 0.0;
    int n = all_media(media);
    (void)state;
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < 5; ++k) {
            double r = (double)(float)(part[k] * (double)media[i].length[0]);
            double within = (double)sss_within(&media[i], 0, (float)r),
                   sum = integral(&media[i], r);
            take(&worst, within, sum);
            check_relative("the integral of Rd", within, sum, 4e-6); // both have their own 2e-6
        }
    }
    print_message("worst difference between quadrature and sss_within %.2g\n", worst);
}

// ---- Fresnel moments

// 2 C1 and 3 C2 as the boundary holds them.
static double two_c1(double eta) {
    double a = (double)sssi_make_boundary((float)eta, 0).a;
    return (a - 1.0) / (a + 1.0);
}
static double three_c2(double eta) {
    return 1.0 - 2.0 * (double)sssi_make_boundary((float)eta, 1).flux;
}

static void test_moments_table(void **state) {
    FILE *file = open_table("fresnel_moments.csv");
    char line[200];
    double worst = 0.0, eta, c1, c2;
    int rows = 0;
    (void)state;
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "%lf,%lf,%lf", &eta, &c1, &c2) != 3) continue;
        check_near("2 C1", two_c1(eta), 2.0 * c1, 1e-6);
        check_near("3 C2", three_c2(eta), 3.0 * c2, 1e-6);
        worst = fmax(worst, fmax(fabs(two_c1(eta) - 2.0 * c1), fabs(three_c2(eta) - 3.0 * c2)));
        ++rows;
    }
    fclose(file);
    check_equal("rows", rows, 20);
    print_message("    worst error of 2 C1 and 3 C2: %.2g\n", worst);
}

// Light inside meets a denser outside, eta < 1: nothing is totally reflected. x^3 evens out the
// grazing end.
static void moments_below(double eta, double *c1, double *c2) {
    *c1 = *c2 = 0.0;
    for (int i = 0; i < 12000; ++i) {
        double w, x = st_node(0.0, 1.0, 4000, i, &w), mu = x * x * x,
                  out = sqrt(1.0 - eta * eta * (1.0 - mu * mu));
        double rs = (eta * mu - out) / (eta * mu + out), rp = (mu - eta * out) / (mu + eta * out);
        double f = 0.5 * (rs * rs + rp * rp) * w * 3.0 * x * x;
        *c1 += 2.0 * f * mu;
        *c2 += 3.0 * f * mu * mu;
    }
}

static void test_moments_everywhere(void **state) {
    double worst = 0.0;
    (void)state;
    for (int i = 0; i <= 480; ++i) {
        double eta = (double)(float)(0.2 + 0.01 * i);
        if (fabs(eta - 1.0) < 0.001) continue;
        double c1, c2;
        if (eta > 1.0) st_fresnel_moments(eta, &c1, &c2);
        else moments_below(eta, &c1, &c2);
        check_near("2 C1", two_c1(eta), c1, 1e-6);
        check_near("3 C2", three_c2(eta), c2, 1e-6);
        worst = fmax(worst, fmax(fabs(two_c1(eta) - c1), fabs(three_c2(eta) - c2)));
    }
    print_message("worst error of 2 C1 and 3 C2 over eta 0.2 .. 5: %.2g\n", worst);
}

static void test_moments_matched(void **state) {
    float above = 1.00000012f, below = 0.99999994f;
    (void)state;
    assert_true(sssi_make_boundary(1.0f, 0).a == 1.0f && sssi_make_boundary(1.0f, 0).flux == 1.0f);
    assert_true(sssi_make_boundary(1.0f, 1).a == 1.0f && sssi_make_boundary(1.0f, 1).flux == 0.5f);
    check_near("2 C1 next to 1", two_c1((double)above), 0.0, 1e-6);
    check_near("3 C2 next to 1", three_c2((double)above), 0.0, 1e-6);
    check_near("2 C1 next to 1", two_c1((double)below), 0.0, 1e-6);
    check_near("3 C2 next to 1", three_c2((double)below), 0.0, 1e-6);
    check_near("2 C1 at 1 + 1e-6", two_c1(1.0 + 1e-6), 0.0, 1e-5);
    check_near("3 C2 at 1 + 1e-6", three_c2(1.0 + 1e-6), 0.0, 1e-5);
}

// ---- Inversion

static const double inverted_albedo[] = {
    1e-4, 1e-3, 0.01, 0.05, 0.1,  0.2,   0.4,    0.499999, 0.5,        0.501,
    0.6,  0.8,  0.9,  0.95, 0.99, 0.999, 0.9999, 0.99999,  1.0 - 1e-6, 1.0 - 1e-7};
#define INVERTED (int)(sizeof inverted_albedo / sizeof *inverted_albedo)

// What a medium that was made by inversion says of its coefficients: q = sigma_tr / sigma_t', p = 1
// - albedo'.
typedef struct implied {
    double q, p, total, lack;
} implied;

static implied look_inside(const sss_medium *m, double eta, int better) {
    double c1, c2;
    if (eta == 1.0) c1 = c2 = 0.0;
    else if (eta > 1.0) st_fresnel_moments(eta, &c1, &c2);
    else moments_below(eta, &c1, &c2);
    double a = (1.0 + (better ? c2 : c1)) / (1.0 - c1);
    double flux = better ? 0.5 * (1.0 - c2) : 1.0;
    implied i;
    i.q = (double)m->sigma[0] * (double)m->length[0];
    i.p = better ? i.q * i.q / (3.0 - i.q * i.q) : i.q * i.q / 3.0;
    double depth = 4.0 / 3.0 * a * (better ? 1.0 + i.p : 1.0);
    double er = expm1(-i.q);
    double ev = expm1(-i.q * (1.0 + depth));
    i.lack = -flux * 0.5 * (er + ev); // 1 - total / albedo'^n, by parts that do not cancel
    if (better) i.lack += (1.0 - flux) - (1.0 - flux) * (er - ev) / (i.q * depth);
    i.total = (1.0 - i.lack) * pow(1.0 - i.p, better ? 2.0 : 1.0);
    i.lack =
        (better ? i.p * (2.0 - i.p) : i.p) + (1.0 - (better ? i.p * (2.0 - i.p) : i.p)) * i.lack;
    return i;
}

// The unit profile of the fields has the integral 1, in double: nothing is lost between inversion
// and profile.
static double unit_integral(const sss_medium *m) {
    double s = (double)m->sigma[0], zr = (double)m->length[0], zv = (double)m->zv[0];
    double er = exp(-s * zr), fall = -expm1(-s * (zv - zr));
    return 2.0 * ST_PI *
           ((double)m->flux[0] * er * (2.0 - fall) + (double)m->fluence[0] * er * fall / s);
}

static void compare_forward(const char *name, const sss_medium *m, const implied *in, double eta,
                            int better) {
    static const double part[] = {0.0, 0.1, 1.0, 5.0, 20.0};
    double sigma_t = 1.0 / (double)m->length[0];
    sss_medium f = grey(better ? sss_better_dipole : sss_dipole, in->p * sigma_t,
                        (1.0 - in->p) * sigma_t, eta);
    check_near(name, (double)f.albedo[0], (double)m->albedo[0], 1e-5);
    check_relative(name, (double)f.zv[0], (double)m->zv[0], 1e-6);
    check_relative(name, (double)f.sigma[0], (double)m->sigma[0], 1e-6);
    for (int i = 0; i < 5;
         ++i) { // profiles per unit of albedo: at small albedos p cannot tell the albedo
        float r = (float)(part[i] * (double)m->length[0]);
        double exponent = (double)m->sigma[0] * hypot((double)r, (double)m->length[0]);
        double x = (double)sss_profile(&f, 0, r) / (double)f.albedo[0];
        check_relative(name, (double)sss_profile(m, 0, r) / (double)m->albedo[0], x,
                       2.0 * allowed(exponent));
    }
}

typedef struct inversion_errors {
    double total, lack, unit, sigma;
} inversion_errors;

static void invert_one(double albedo, double dmfp, double eta, int better,
                       inversion_errors *worst) {
    sss_medium m =
        grey(better ? sss_better_dipole_from_albedo : sss_dipole_from_albedo, albedo, dmfp, eta);
    implied in = look_inside(&m, (double)(float)eta, better);
    double given = (double)(float)albedo;
    char name[120];
    snprintf(name, sizeof name, "%s dipole, albedo %.9g, dmfp %g, eta %g",
             better ? "better" : "standard", albedo, dmfp, eta);
    assert_true(m.albedo[0] == (float)albedo);
    check_relative(name, (double)m.sigma[0], 1.0 / (double)(float)dmfp, 1e-6);
    check_near(name, in.total, given, 1e-5);
    check_relative(name, unit_integral(&m), 1.0, 2e-6);
    if (given >= 0.5) check_relative(name, in.lack, 1.0 - given, 1e-5);
    compare_forward(name, &m, &in, eta, better);
    worst->total = fmax(worst->total, fabs(in.total - given));
    if (given >= 0.5) take(&worst->lack, in.lack, 1.0 - given);
    take(&worst->unit, unit_integral(&m), 1.0);
    take(&worst->sigma, (double)m.sigma[0], 1.0 / (double)(float)dmfp);
}

static void test_inversion(void **state) {
    static const double eta[] = {0.2, 0.75, 1.0, 1.1, 1.33, 1.5, 2.0, 5.0},
                        dmfp[] = {1e-3, 1.0, 37.0};
    inversion_errors worst = {0.0, 0.0, 0.0, 0.0};
    (void)state;
    for (int better = 0; better < 2; ++better)
        for (int a = 0; a < INVERTED; ++a)
            for (int e = 0; e < 8; ++e)
                for (int d = 0; d < 3; ++d)
                    invert_one(inverted_albedo[a], dmfp[d], eta[e], better, &worst);
    print_message("    worst errors: total %.2g, 1 - total (relative) %.2g, unit integral %.2g, "
                  "sigma_tr %.2g\n",
                  worst.total, worst.lack, worst.unit, worst.sigma);
}

// The brighter, the shorter the mean free path, down to Lambert at exactly 1.
static void test_inversion_is_monotone(void **state) {
    (void)state;
    for (int better = 0; better < 2; ++better) {
        constructor *make = better ? sss_better_dipole_from_albedo : sss_dipole_from_albedo;
        float before = INFINITY;
        for (int i = 1; i <= 4000; ++i) {
            double x = i / 4000.0, albedo = 1.0 - pow(1.0 - x, 3.0);
            sss_medium m = grey(make, albedo, 1.0, 1.3);
            assert_true(m.length[0] <= before);
            assert_true(m.length[0] > 0.0f || (float)albedo == 1.0f);
            before = m.length[0];
        }
        assert_true(before == 0.0f);
    }
}

static void test_inversion_ends(void **state) {
    (void)state;
    for (int better = 0; better < 2; ++better) {
        constructor *make = better ? sss_better_dipole_from_albedo : sss_dipole_from_albedo;
        sss_medium white = grey(make, 1.0, 1.0, 1.3), black = grey(make, 0.0, 1.0, 1.3),
                   flat = grey(make, 0.6, 0.0, 1.3);
        assert_true(white.length[0] == 0.0f && white.albedo[0] == 1.0f && white.r_max == 0.0f);
        assert_true(sss_profile(&white, 0, 1.0f) == 0.0f && sss_within(&white, 0, 0.0f) == 1.0f);
        assert_true(black.albedo[0] == 0.0f && sss_profile(&black, 0, 0.1f) == 0.0f &&
                    black.r_max == 0.0f);
        assert_true(flat.length[0] == 0.0f && sss_within(&flat, 0, 0.0f) == 0.6f);
    }
}

// alpha' = 1 exactly, sigma_a = 0: all comes out again, and sigma_tr = 0.
static void test_no_absorption(void **state) {
    (void)state;
    for (int better = 0; better < 2; ++better) {
        sss_medium m = grey(better ? sss_better_dipole : sss_dipole, 0.0, 2.0, 1.4);
        check_near("albedo", (double)m.albedo[0], 1.0, 1e-6);
        assert_true(m.sigma[0] == 0.0f);
        check_near("within", (double)sss_within(&m, 0, 1e6f), 1.0, 2e-6);
    }
}

// ---- The radius that the disk and the sphere reach

static double tail_of(const sss_medium *m, int c, double r) {
    st_profile p;
    memset(&p, 0, sizeof p);
    p.albedo = 1.0;
    p.dipole = m->dipole;
    p.d = p.zr = (double)m->length[c];
    p.zv = (double)m->zv[c];
    p.s = (double)m->sigma[c];
    p.flux = (double)m->flux[c];
    p.fluence = (double)m->fluence[c];
    return st_tail(&p, r);
}

// What the ball of r_max leaves out: never more than 1e-4 of the light, and not so little that
// probes search in vain.
static void check_r_max(const sss_medium *m) {
    double tail = tail_of(m, 0, (double)m->r_max);

    check_at_most("tail beyond r_max", tail, 1.001e-4);
    check_at_least("tail beyond r_max", tail, 8e-5);
}

static void test_r_max(void **state) {
    enum { ETAS = 9, DARKS = 100 };
    static constructor *const makers[] = {sss_dipole, sss_better_dipole, sss_dipole_from_albedo,
                                          sss_better_dipole_from_albedo};
    static const double eta[ETAS] = {0.2, 0.5, 0.8, 1.0, 1.1, 1.33, 1.5, 2.0, 5.0};
    static const float albedo[3] = {0.3f, 0.9f, 0.99f}, length[3] = {1.0f, 0.3f, 0.05f};
    sss_medium media[30];
    int n = all_media(media);
    (void)state;
    for (int i = 0; i < n; ++i) check_r_max(&media[i]);
    sss_medium m;
    for (int i = 0; i < 4 * ETAS * DARKS; ++i) {
        constructor *make = makers[i % 4];
        double dark = pow(10.0, -6.0 * (i / (4 * ETAS)) / (DARKS - 1.0));

        m = i % 4 < 2 ? grey(make, dark, 1.0 - 0.9999999 * dark, eta[i / 4 % ETAS])
                      : grey(make, 1.0 - 0.9999 * dark, 1.0, eta[i / 4 % ETAS]);
        if (m.length[0] > 0.0f) check_r_max(&m);
    }
    assert_int_equal(sss_better_dipole_from_albedo(&m, albedo, length, 1.3f), SSS_OK);
    check_r_max(&m);
    check_at_most("tail of the second", tail_of(&m, 1, (double)m.r_max), 1e-5);
    check_at_most("tail of the third", tail_of(&m, 2, (double)m.r_max), 1e-5);
}

// ---- Proposals

// What the header states in its bound: for eta up to 2, and for all that is allowed.
#define PROPOSAL_SUP      3.3
#define PROPOSAL_SUP_WIDE 8.3

// The greatest Rd / (A P) over radii from 1e-6 to 1e6 of the length, and up to where the
// exponential is cut off.
static double proposal_ratio(const sss_medium *m) {
    double worst = 0.0;
    for (int i = 0; i <= 2400; ++i) {
        float r = m->length[0] * (float)pow(10.0, -6.0 + i / 200.0),
              exponent = r / (3.0f * m->length[0]);
        if (m->dipole) exponent = m->sigma[0] * sqrtf(r * r + m->zv[0] * m->zv[0]);
        if (exponent > 69.0f) break;
        double ratio = (double)sssi_unit_profile(m, m->dipole, 0, r * r) /
                       (double)sssi_proposal(m, m->dipole, 0, r * r);
        if (!(ratio <= worst)) worst = ratio;
    }
    return worst;
}

// Over the plane, with r = length e^y.
static double proposal_integral(const sss_medium *m) {
    double sum = 0.0, z = (double)m->length[0];
    for (int i = 0; i < 3000; ++i) {
        double w, y = st_node(-16.0, 24.0, 1000, i, &w), r = z * exp(y);
        sum +=
            w * 2.0 * ST_PI * r * r * (double)sssi_proposal(m, m->dipole, 0, (float)r * (float)r);
    }
    return sum;
}

static double worst_ratio(constructor *make, int inverted, int wide) {
    static const double eta[] = {0.2, 0.5, 0.8, 1.0, 1.1, 1.33, 1.5, 2.0, 3.0, 5.0};
    double worst = 0.0;
    for (int e = wide ? 8 : 0; e < (wide ? 10 : 8); ++e) {
        for (int i = 0; i <= 60; ++i) {
            double p =
                pow(10.0, -i / (inverted ? 8.5 : 10.0)); // 1 - albedo' to 1e-6, 1 - albedo to 1e-7
            sss_medium m = inverted ? grey(make, fmax(1.0 - p, 1e-4), 1.0, eta[e])
                                    : grey(make, p, 1.0 - 0.9999999 * p, eta[e]);
            double ratio = proposal_ratio(&m);
            if (!(ratio <= worst)) worst = ratio;
            check_relative("the integral of a proposal", proposal_integral(&m), 1.0, 1e-5);
        }
    }
    return worst;
}

static void test_proposals(void **state) {
    (void)state;
    for (int wide = 0; wide < 2; ++wide) {
        double worst[4];
        worst[0] = worst_ratio(sss_dipole, 0, wide);
        worst[1] = worst_ratio(sss_better_dipole, 0, wide);
        worst[2] = worst_ratio(sss_dipole_from_albedo, 1, wide);
        worst[3] = worst_ratio(sss_better_dipole_from_albedo, 1, wide);
        print_message(
            "    sup of Rd / (A P), eta %s: %.4f standard, %.4f better, %.4f and %.4f inverted\n",
            wide ? "3 and 5" : "up to 2", worst[0], worst[1], worst[2], worst[3]);
        for (int i = 0; i < 4; ++i)
            check_at_most("sup of Rd / (A P)", worst[i], wide ? PROPOSAL_SUP_WIDE : PROPOSAL_SUP);
    }
    sss_medium media[30];
    int n = all_media(media);
    for (int i = 0; i < n; ++i) {
        if (media[i].dipole) continue;
        check_relative("Burley's proposal is its profile", proposal_ratio(&media[i]), 1.0, 1e-6);
        check_relative("its integral", proposal_integral(&media[i]), 1.0, 1e-5);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_domain),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_channels),
        cmocka_unit_test(test_falls),
        cmocka_unit_test(test_integral),
        cmocka_unit_test(test_moments_table),
        cmocka_unit_test(test_moments_everywhere),
        cmocka_unit_test(test_moments_matched),
        cmocka_unit_test(test_inversion),
        cmocka_unit_test(test_inversion_is_monotone),
        cmocka_unit_test(test_inversion_ends),
        cmocka_unit_test(test_no_absorption),
        cmocka_unit_test(test_r_max),
        cmocka_unit_test(test_proposals),
    };
    return cmocka_run_group_tests_name("profiles", tests, NULL, NULL);
}
