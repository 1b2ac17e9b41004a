/* What the tests share: comparisons that say what went wrong, running statistics, reference
   profiles and analytic surfaces. All of it is in double precision and none of it uses the header's
   arithmetic, so that it can contradict it.

   A test program: include this, call cmocka_run_group_tests from main. Call check_... and st_report
   outside parallel regions: they keep state. All else is thread-safe. */
#ifndef SSS_TEST_H
#define SSS_TEST_H

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#if defined(__x86_64__) || defined(__i386__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

#include "sss_resample.h"

#define TEST_SEED   20160505u
#define ST_PI       3.14159265358979323846
#define ST_MAX_HITS 12
#define ST_SHEETS   12

/* ---- Comparisons. Each is written so that NaN fails; `inputs` says which case it was. ---- */
typedef struct st_log {
    int z_count;
    double worst_z;
    double power; /* the largest, over the checks, of the relative bias that lifts z to the limit */
    double alarms; /* the chance that a correct header fails in one of them, as if they were
                      independent */
} st_log;
static inline st_log *st_logbook(void) {
    static st_log book;
    return &book;
}

static inline void check_near(const char *inputs, double actual, double expected,
                              double tolerance) {
    if (!(fabs(actual - expected) <= tolerance))
        fail_msg("%s: expected %.9g, got %.9g, error %.3g, tolerance %.3g", inputs, expected,
                 actual, actual - expected, tolerance);
}
static inline void check_relative(const char *inputs, double actual, double expected,
                                  double tolerance) {
    if (!(fabs(actual - expected) <= tolerance * fabs(expected)))
        fail_msg("%s: expected %.9g, got %.9g, relative error %.3g, tolerance %.3g", inputs,
                 expected, actual, actual / expected - 1.0, tolerance);
}
static inline void check_at_most(const char *inputs, double actual, double limit) {
    if (!(actual <= limit)) fail_msg("%s: got %.9g, above the limit %.9g", inputs, actual, limit);
}
static inline void check_at_least(const char *inputs, double actual, double limit) {
    if (!(actual >= limit)) fail_msg("%s: got %.9g, below the limit %.9g", inputs, actual, limit);
}
static inline void check_equal(const char *inputs, long actual, long expected) {
    if (actual != expected) fail_msg("%s: expected %ld, got %ld", inputs, expected, actual);
}
/* An estimate with its standard error against the truth. `rounding` is what float32 and the
   quadrature may add: keep it far below the error. */
static inline void check_z(const char *inputs, double actual, double error, double expected,
                           double rounding, double limit) {
    st_log *book = st_logbook();
    double z = error > 0.0 ? (actual - expected) / error : 0.0;
    double unexplained = error > 0.0 ? fmax(fabs(actual - expected) - rounding, 0.0) / error : 0.0;
    ++book->z_count;
    book->alarms += erfc(limit / sqrt(2.0));
    if (unexplained > book->worst_z) book->worst_z = unexplained;
    if (expected != 0.0 && limit * error / fabs(expected) > book->power)
        book->power = limit * error / fabs(expected);
    if (!(fabs(actual - expected) <= limit * error + rounding))
        fail_msg("%s: expected %.9g, got %.9g +- %.3g, z %.2f, limit %.2f", inputs, expected,
                 actual, error, z, limit);
}
/* A teardown for a group: what was compared, and how sharply. */
static inline int st_report(void **state) {
    const st_log *book = st_logbook();
    (void)state;
    if (book->z_count)
        print_message("%d z-scores, worst %.2f; the least sharp reaches its limit at a bias of "
                      "%.2f %%; false alarms "
                      "%.1g\n",
                      book->z_count, book->worst_z, 100.0 * book->power, book->alarms);
    return 0;
}

/* The costly statistics take an eighth of the samples in make test, and all in make test-long, make
   test-mutants and with SSS_TEST_LONG=1: standard errors are sqrt(8) times as large in the former,
   and false alarms as rare. */
static inline int st_is_long(void) {
    const char *wish = getenv("SSS_TEST_LONG");
    return wish && strcmp(wish, "1") == 0;
}
static inline int st_samples(int all) { return st_is_long() ? all : all / 8; }
static inline double st_bluntness(void) { return st_is_long() ? 1.0 : sqrt(8.0); }

/* ---- Running mean and variance (Welford; merging by Chan). Thread-safe: give each block of
   samples its own and merge the blocks in order, then the result does not depend on the number of
   threads. ---- */
typedef struct st_stat {
    double n, mean, m2;
} st_stat;
static inline void st_add(st_stat *s, double x) {
    double delta = x - s->mean;
    s->n += 1.0;
    s->mean += delta / s->n;
    s->m2 += delta * (x - s->mean);
}
static inline void st_merge(st_stat *s, const st_stat *other) {
    double n = s->n + other->n, delta = other->mean - s->mean;
    if (other->n == 0.0) return;
    s->m2 += other->m2 + delta * delta * s->n * other->n / n;
    s->mean += delta * other->n / n;
    s->n = n;
}
static inline double st_variance(const st_stat *s) {
    return s->n > 1.0 ? s->m2 / (s->n - 1.0) : 0.0;
}
static inline double st_error(const st_stat *s) {
    return s->n > 1.0 ? sqrt(st_variance(s) / s->n) : 0.0;
}
static inline double st_relative_variance(const st_stat *s) {
    return st_variance(s) / (s->mean * s->mean);
}

/* A uniform number in (0, 1), and one in -1..1, from a counter; not the header's hash. */
static inline double st_random(uint64_t counter) {
    uint64_t z = (counter + 1u) * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    z ^= z >> 31;
    return ((double)(z >> 12) + 0.5) / 4503599627370496.0;
}
static inline double st_signed(uint64_t counter) { return 2.0 * st_random(counter) - 1.0; }
/* In (0, 1), of hit `index` of a lookup. */
static inline double st_noise(uint32_t seed, int index) {
    return st_random(((uint64_t)seed << 16) + (uint64_t)index);
}

/* Denormal results and arguments become 0 in this thread, as renderers often set it and OpenCL
 * devices may. */
#if defined(__x86_64__) || defined(__i386__) || defined(_M_X64)
#define ST_CAN_FLUSH 1
static inline void st_flush_denormals(int on) {
    _mm_setcsr((_mm_getcsr() & ~0x8040u) | (on ? 0x8040u : 0u));
}
#else
#define ST_CAN_FLUSH 0
static inline void st_flush_denormals(int on) { (void)on; }
#endif

/* ---- Quadrature: three-point Gauss on equal panels ---- */
static inline double st_node(double a, double b, int panels, int i, double *weight) {
    double h = (b - a) / panels, middle = a + (i / 3 + 0.5) * h;
    *weight = h * (i % 3 == 1 ? 8.0 : 5.0) / 18.0;
    return middle + h * 0.38729833462074168852 * (i % 3 - 1);
}

/* ---- Vectors ---- */
typedef struct st_vec {
    double x, y, z;
} st_vec;
static inline st_vec st_vec3(double x, double y, double z) {
    st_vec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
static inline double st_dot(st_vec a, st_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double st_length(st_vec a) { return sqrt(st_dot(a, a)); }
static inline st_vec st_sum(st_vec a, st_vec b, double k) {
    return st_vec3(a.x + k * b.x, a.y + k * b.y, a.z + k * b.z);
}
static inline st_vec st_unit(st_vec a) {
    return st_sum(st_vec3(0.0, 0.0, 0.0), a, 1.0 / st_length(a));
}
static inline sss_vec3 st_float(st_vec a) {
    sss_vec3 v;
    v.x = (float)a.x;
    v.y = (float)a.y;
    v.z = (float)a.z;
    return v;
}
static inline st_vec st_double(sss_vec3 a) {
    return st_vec3((double)a.x, (double)a.y, (double)a.z);
}

static inline int st_same_bits(sss_vec3 a, sss_vec3 b) { return memcmp(&a, &b, sizeof a) == 0; }
/* Times 2^k. */
static inline sss_vec3 st_scaled(sss_vec3 v, int k) {
    v.x = ldexpf(v.x, k);
    v.y = ldexpf(v.y, k);
    v.z = ldexpf(v.z, k);
    return v;
}

/* A rigid motion: world = rows * local + move. */
typedef struct st_frame {
    st_vec row[3], move;
} st_frame;
static inline st_frame st_motion(st_vec axis, double angle, st_vec move) { /* Rodrigues */
    st_vec k = st_unit(axis);
    double c = cos(angle), s = sin(angle), d = 1.0 - c;
    st_frame f;
    f.row[0] = st_vec3(c + k.x * k.x * d, k.x * k.y * d - k.z * s, k.x * k.z * d + k.y * s);
    f.row[1] = st_vec3(k.y * k.x * d + k.z * s, c + k.y * k.y * d, k.y * k.z * d - k.x * s);
    f.row[2] = st_vec3(k.z * k.x * d - k.y * s, k.z * k.y * d + k.x * s, c + k.z * k.z * d);
    f.move = move;
    return f;
}
static inline st_frame st_stay(void) {
    return st_motion(st_vec3(0.0, 0.0, 1.0), 0.0, st_vec3(0.0, 0.0, 0.0));
}
/* Nothing lines up with an axis; float32 still resolves 2e-6. */
static inline st_frame st_moved(void) {
    return st_motion(st_vec3(0.61, -0.37, 0.83), 2.345, st_vec3(23.0, -17.0, 11.0));
}
static inline st_vec st_turn(const st_frame *f, st_vec v) {
    return st_vec3(st_dot(f->row[0], v), st_dot(f->row[1], v), st_dot(f->row[2], v));
}
static inline st_vec st_turn_back(const st_frame *f, st_vec v) {
    st_vec a = st_sum(st_vec3(0.0, 0.0, 0.0), f->row[0], v.x);
    return st_sum(st_sum(a, f->row[1], v.y), f->row[2], v.z);
}
static inline st_vec st_world(const st_frame *f, st_vec v) {
    return st_sum(st_turn(f, v), f->move, 1.0);
}
static inline st_vec st_local(const st_frame *f, sss_vec3 v) {
    return st_turn_back(f, st_sum(st_double(v), f->move, -1.0));
}

/* ---- Reference profiles ---- */
typedef struct st_profile {
    int dipole;
    double albedo;        /* the integral over the plane */
    double d;             /* Burley */
    double zr, zv, s;     /* dipoles */
    double flux, fluence; /* in front of the two sums, albedo'^n / 4 pi included */
    double cut; /* the profile is 0 beyond: infinity, or what a plan without chords can see */
} st_profile;

static inline double st_rd(const st_profile *p, double r) {
    if (r > p->cut || p->albedo == 0.0) return 0.0;
    if (!p->dipole)
        return p->albedo * (exp(-r / p->d) + exp(-r / (3.0 * p->d))) / (8.0 * ST_PI * p->d * r);
    double dr = sqrt(r * r + p->zr * p->zr);
    double dv = sqrt(r * r + p->zv * p->zv);
    return p->flux * (p->zr * (1.0 + p->s * dr) * exp(-p->s * dr) / (dr * dr * dr) +
                      p->zv * (1.0 + p->s * dv) * exp(-p->s * dv) / (dv * dv * dv)) +
           p->fluence * (exp(-p->s * dr) / dr - exp(-p->s * dv) / dv);
}
/* The integral over the plane beyond r; needs s > 0. */
static inline double st_tail(const st_profile *p, double r) {
    if (!p->dipole) return p->albedo * (exp(-r / p->d) + 3.0 * exp(-r / (3.0 * p->d))) / 4.0;
    double dr = sqrt(r * r + p->zr * p->zr);
    double dv = sqrt(r * r + p->zv * p->zv);
    return 2.0 * ST_PI *
           (p->flux * (p->zr / dr * exp(-p->s * dr) + p->zv / dv * exp(-p->s * dv)) +
            p->fluence * (exp(-p->s * dr) - exp(-p->s * dv)) / p->s);
}
/* The radius beyond which lies `part` of the albedo. */
static inline double st_radius_of_tail(const st_profile *p, double part) {
    double low = 0.0, high = p->dipole ? 100.0 / p->s : 100.0 * p->d;
    for (int i = 0; i < 100; ++i) {
        double middle = 0.5 * (low + high);
        if (st_tail(p, middle) > part * p->albedo) low = middle;
        else high = middle;
    }
    return high;
}

/* Christensen and Burley 2015, eq. 8. */
static inline double st_burley_s(double albedo) { return 3.5 + 100.0 * pow(albedo - 0.33, 4.0); }
static inline st_profile st_burley(double albedo, double dmfp) {
    st_profile p;
    memset(&p, 0, sizeof p);
    p.albedo = albedo;
    p.d = dmfp / st_burley_s(albedo);
    p.cut = HUGE_VAL;
    return p;
}
/* 2 C1 and 3 C2: moments of the Fresnel reflectance met from inside, by quadrature; eta >= 1. */
static inline void st_fresnel_moments(double eta, double *two_c1, double *three_c2) {
    double critical = sqrt(1.0 - 1.0 / (eta * eta)), c1 = critical * critical / 2.0,
           c2 = pow(critical, 3.0) / 3.0;
    /* mu = critical + (1 - critical) x^2 takes the root at the critical angle away. */
    for (int i = 0; i < 600; ++i) {
        double w, x = st_node(0.0, 1.0, 200, i, &w), mu = critical + (1.0 - critical) * x * x;
        double out = sqrt(fmax(1.0 - eta * eta * (1.0 - mu * mu), 0.0));
        double rs = (eta * mu - out) / (eta * mu + out), rp = (mu - eta * out) / (mu + eta * out);
        double f = 0.5 * (rs * rs + rp * rp) * w * 2.0 * (1.0 - critical) * x;
        c1 += f * mu;
        c2 += f * mu * mu;
    }
    *two_c1 = 2.0 * c1;
    *three_c2 = 3.0 * c2;
}
/* Jensen et al. 2001, or d'Eon 2012. */
static inline st_profile st_dipole(double sigma_a, double sigma_s, double eta, int better) {
    double t = sigma_a + sigma_s, alpha = sigma_s / t;
    st_profile p;
    memset(&p, 0, sizeof p);
    double c1, c2;
    st_fresnel_moments(eta, &c1, &c2);
    double diffusion = better ? (2.0 * sigma_a + sigma_s) / (3.0 * t * t) : 1.0 / (3.0 * t);
    double a = (1.0 + (better ? c2 : c1)) / (1.0 - c1);
    p.dipole = 1;
    p.zr = 1.0 / t;
    p.zv = p.zr + 4.0 * a * diffusion;
    p.s = sqrt(sigma_a / diffusion);
    p.flux = better ? alpha * alpha * (1.0 - c2) / (8.0 * ST_PI) : alpha / (4.0 * ST_PI);
    p.fluence = better ? alpha * alpha * (1.0 - c1) / (16.0 * ST_PI * diffusion) : 0.0;
    p.albedo = 1.0;
    p.albedo = st_tail(&p, 0.0);
    p.cut = HUGE_VAL;
    return p;
}
/* The same with a given reflectance in 0..1 and 1 / sigma_tr. */
static inline st_profile st_dipole_from_albedo(double albedo, double dmfp, double eta, int better) {
    double low = -30.0, high = 30.0; /* log of sigma_a / sigma_s' */
    st_profile p;
    for (int i = 0; i < 80; ++i) {
        double middle = 0.5 * (low + high);
        p = st_dipole(exp(middle), 1.0, eta, better);
        if (p.albedo > albedo) low = middle;
        else high = middle;
    }
    return st_dipole(exp(low) / (p.s * dmfp), 1.0 / (p.s * dmfp), eta, better);
}
/* A black channel's. */
static inline st_profile st_nothing(void) {
    st_profile p;
    memset(&p, 0, sizeof p);
    p.cut = HUGE_VAL;
    return p;
}

/* ---- Surfaces. In local coordinates the entry is the origin and its normal +z. ---- */
typedef enum st_kind {
    ST_PLANE,    /* z = 0 */
    ST_SPHERE,   /* radius `size` */
    ST_SLAB,     /* z = 0 and z = -size */
    ST_STACK,    /* ST_SHEETS planes, `size` apart, the entry on the topmost */
    ST_EDGE,     /* z = 0 where x <= size, and x = size where z <= 0 */
    ST_CYLINDER, /* radius `size`, along y */
    ST_KINDS
} st_kind;
typedef struct st_fixture {
    st_kind kind;
    double size;
    st_frame frame;
} st_fixture;
typedef struct st_hit {
    double t;
    st_vec local, local_normal;
    sss_vec3 position, normal; /* what a renderer would hand over */
} st_hit;

static inline const char *st_kind_name(st_kind kind) {
    static const char *const names[ST_KINDS] = {"plane", "sphere", "slab",
                                                "stack", "edge",   "cylinder"};
    return names[kind];
}
/* Parallel sheets. */
static inline int st_sheets(st_kind kind) {
    if (kind == ST_STACK) return ST_SHEETS;
    return kind == ST_SLAB ? 2 : 1;
}
/* The surface of each kind that the closed forms in test_contract.c belong to, at d = 1. */
static inline st_fixture st_standard(st_kind kind, st_frame frame) {
    static const double sizes[ST_KINDS] = {0.0, 1.0, 1.0, 0.3, 0.2, 0.3};
    st_fixture f;
    f.kind = kind;
    f.size = sizes[kind];
    f.frame = frame;
    return f;
}
static inline void st_entry(const st_fixture *f, sss_vec3 *position, sss_vec3 *normal) {
    *position = st_float(st_world(&f->frame, st_vec3(0.0, 0.0, 0.0)));
    *normal = st_float(st_turn(&f->frame, st_vec3(0.0, 0.0, 1.0)));
}

/* Adds a hit in the order of distance. */
static inline int st_insert(const st_fixture *f, st_hit *hits, int count, double t, st_vec local,
                            st_vec normal) {
    int i = count;
    for (; i > 0 && hits[i - 1].t > t; --i) hits[i] = hits[i - 1];
    hits[i].t = t;
    hits[i].local = local;
    hits[i].local_normal = normal;
    hits[i].position = st_float(st_world(&f->frame, local));
    hits[i].normal = st_float(st_turn(&f->frame, normal));
    return count + 1;
}
/* The sphere (round = 1) or cylinder (round = 0: y does not count) of radius R that touches the
 * entry from below. */
static inline int st_hit_round(const st_fixture *f, st_vec o, st_vec d, double length, double round,
                               st_hit *hits) {
    double R = f->size, oz = o.z + R, a = d.x * d.x + d.z * d.z + round * d.y * d.y;
    double b = o.x * d.x + oz * d.z + round * o.y * d.y,
           c = o.x * o.x + oz * oz + round * o.y * o.y - R * R;
    double q = b * b - a * c;
    int count = 0;
    if (!(a > 0.0 && q > 0.0)) return 0;
    for (int i = -1; i <= 1; i += 2) {
        double t = (-b + i * sqrt(q)) / a;
        if (!(t >= 0.0 && t <= length)) continue;
        st_vec y = st_sum(o, d, t);
        count = st_insert(f, hits, count, t, y, st_unit(st_vec3(y.x, round * y.y, y.z + R)));
    }
    return count;
}
/* All hits of a probe, nearest first; hits has ST_MAX_HITS places. */
static inline int st_trace(const st_fixture *f, const sss_probe *probe, st_hit *hits) {
    st_vec o = st_local(&f->frame, probe->origin),
           d = st_turn_back(&f->frame, st_double(probe->direction));
    double length = (double)probe->length;
    int sheets = st_sheets(f->kind), count = 0;
    if (f->kind == ST_SPHERE || f->kind == ST_CYLINDER)
        return st_hit_round(f, o, d, length, f->kind == ST_SPHERE ? 1.0 : 0.0, hits);
    for (int i = 0; i < sheets && d.z != 0.0; ++i) {
        double t = (-i * f->size - o.z) / d.z;
        st_vec y = st_sum(o, d, t);
        if (t >= 0.0 && t <= length && (f->kind != ST_EDGE || y.x <= f->size))
            count = st_insert(f, hits, count, t, y, st_vec3(0.0, 0.0, 1.0));
    }
    if (f->kind == ST_EDGE && d.x != 0.0) {
        double t = (f->size - o.x) / d.x;
        st_vec y = st_sum(o, d, t);
        if (t >= 0.0 && t <= length && y.z <= 0.0)
            count = st_insert(f, hits, count, t, y, st_vec3(1.0, 0.0, 0.0));
    }
    return count;
}

/* ---- Integrals over the surfaces. A face is a plane, strip or sphere in polar coordinates (s,
   psi) about the point nearest to the entry, with area s ds dpsi; a strip holds only u = s cos(psi)
   <= high and >= -low. ---- */
typedef double st_function(st_vec local, st_vec normal, const void *context);

static inline void st_face_point(const st_fixture *f, int face, double s, double psi, st_vec *y,
                                 st_vec *n) {
    double R = f->size, u = s * cos(psi), v = s * sin(psi);
    if (f->kind == ST_SPHERE) { /* s is the chord: the cap within it has the area pi s^2 */
        double rim = sqrt(fmax(1.0 - s * s / (4.0 * R * R), 0.0));
        *y = st_vec3(u * rim, v * rim, -s * s / (2.0 * R));
        *n = st_vec3(y->x / R, y->y / R, y->z / R + 1.0);
    } else if (f->kind == ST_CYLINDER) { /* unrolled */
        double half = sin(0.5 * u / R);
        *n = st_vec3(sin(u / R), 0.0, cos(u / R));
        *y = st_vec3(R * n->x, v, -2.0 * R * half * half);
    } else if (f->kind == ST_EDGE && face == 1) {
        *y = st_vec3(f->size, v, u);
        *n = st_vec3(1.0, 0.0, 0.0);
    } else {
        *y = st_vec3(u, v, -face * f->size);
        *n = st_vec3(0.0, 0.0, 1.0);
    }
}
/* The sum over angles at s; half the angles, the other half mirrored. */
static inline double st_ring(const st_fixture *f, int face, double s, double low, double high,
                             st_function *function, const void *context) {
    double from = high < s ? acos(high / s) : 0.0, to = low < s ? acos(-low / s) : ST_PI, sum = 0.0;
    for (int i = 0; i < 48; ++i) {
        double w, psi = st_node(from, to, 16, i, &w);
        st_vec y, n;
        st_face_point(f, face, s, psi, &y, &n);
        sum += w * function(y, n, context);
        st_face_point(f, face, s, -psi, &y, &n);
        sum += w * function(y, n, context);
    }
    return sum * s;
}
/* The integral of a function of the profile's kind, of the given length scale, over the whole
 * surface; about 1e-6. */
static inline double st_surface(const st_fixture *f, double scale, st_function *function,
                                const void *context) {
    int faces = f->kind == ST_EDGE ? 2 : st_sheets(f->kind);
    double sum = 0.0;
    for (int face = 0; face < faces; ++face) {
        double low = HUGE_VAL, high = HUGE_VAL,
               end = f->kind == ST_SPHERE ? 2.0 * f->size : HUGE_VAL;
        if (f->kind == ST_CYLINDER) low = high = ST_PI * f->size;
        if (f->kind == ST_EDGE) high = face ? 0.0 : f->size;
        /* s = scale (t / (1 - t))^2; the strip's limit, where a root begins, ends a panel */
        double bounds[3];
        bounds[0] = 0.0;
        bounds[1] = high < HUGE_VAL && high > 0.0 ? 1.0 / (1.0 + sqrt(scale / high)) : 0.5;
        bounds[2] = end < HUGE_VAL ? 1.0 / (1.0 + sqrt(scale / end)) : 1.0;
        if (!(bounds[1] < bounds[2])) bounds[1] = 0.5 * bounds[2];
        for (int part = 0; part < 2; ++part)
            for (int i = 0; i < 450; ++i) {
                double w, t = st_node(bounds[part], bounds[part + 1], 150, i, &w),
                          q = t / (1.0 - t);
                double ds = 2.0 * scale * q / ((1.0 - t) * (1.0 - t));
                sum += w * ds * st_ring(f, face, scale * q * q, low, high, function, context);
            }
    }
    return sum;
}

/* ---- Irradiance and the truth ---- */
typedef double st_light(st_vec local);
static inline double st_light_one(st_vec y) {
    (void)y;
    return 1.0;
}
/* A spot beside the entry, and a gradient along y. Positive. */
static inline double st_light_spot(st_vec y) {
    double dx = y.x - 0.4, dz = y.z + 0.2;
    return 0.2 + 2.0 * exp(-4.0 * (dx * dx + y.y * y.y + dz * dz)) +
           0.3 * tanh(2.0 * y.y) * tanh(2.0 * y.y);
}
/* A shadow edge: nothing at x < -0.3. */
static inline double st_light_shadow(st_vec y) {
    double x = y.x + 0.3;
    return x > 0.0 ? x * x / (0.1 + x * x) : 0.0;
}
typedef struct st_lit_profile {
    const st_profile *profile;
    st_light *light;
} st_lit_profile;
static inline double st_lit(st_vec local, st_vec normal, const void *context) {
    const st_lit_profile *p = (const st_lit_profile *)context;
    (void)normal;
    return st_rd(p->profile, st_length(local)) * p->light(local);
}
/* The integral of Rd E over the surface. */
static inline double st_truth(const st_fixture *f, const st_profile *p, st_light *light) {
    st_lit_profile context;
    context.profile = p;
    context.light = light;
    if (p->albedo == 0.0) return 0.0;
    return st_surface(f, p->dipole ? 1.0 / (3.0 * p->s) : p->d, st_lit, &context);
}

/* The same at E = 1 for Burley's profile with A = d = 1, by integrals in one dimension. */
static inline double st_bessel_k0(double x) { /* the integral of e^(-x cosh t) */
    double sum = 0.5 * exp(-x);
    for (double t = 0.03125; t < 30.0; t += 0.03125) sum += exp(-x * cosh(t));
    return 0.03125 * sum;
}
static inline double st_closed_form(const st_fixture *f) {
    st_profile p = st_burley(1.0, st_burley_s(1.0));
    double sum = 0.0, w;
    switch (f->kind) {
    case ST_PLANE: return 1.0;
    case ST_SPHERE: return 1.0 - st_tail(&p, 2.0 * f->size);
    case ST_SLAB: return 1.0 + st_tail(&p, f->size);
    case ST_STACK:
        for (int i = 0; i < ST_SHEETS; ++i) sum += st_tail(&p, i * f->size);
        return sum;
    case ST_EDGE:
        for (int i = 0; i < 3000; ++i) { /* r = a + x^2 */
            double x = st_node(0.0, 11.0, 1000, i, &w), r = f->size + x * x;
            sum += w * 2.0 * x * 2.0 * r * st_rd(&p, r) * acos(f->size / r);
        }
        return 1.0 - sum + 0.5 * st_tail(&p, f->size);
    case ST_CYLINDER:
        for (int i = 0; i < 600; ++i) { /* theta = x^2 takes the logarithm away */
            double x = st_node(0.0, sqrt(ST_PI), 200, i, &w), c = 2.0 * f->size * sin(0.5 * x * x);
            sum += w * 2.0 * x * (st_bessel_k0(c) + st_bessel_k0(c / 3.0));
        }
        return f->size / (2.0 * ST_PI) * sum;
    case ST_KINDS: break;
    }
    return -1.0;
}

/* ---- One lookup on a fixture. hint: NULL, or a guess of the light at `local` (the position as the
   header sees it) for hit number `index` of lookup `seed`. Returns the number of exits. Thread-safe
   if hint is. ---- */
typedef float st_hint(st_vec local, uint32_t seed, int index);
static inline int st_lookup(const st_fixture *f, const sss_medium *m, const sss_plan *plan,
                            uint32_t seed, st_hint *hint, sss_exit *exits) {
    sss_vec3 x, n;
    int index = 0;
    st_entry(f, &x, &n);
    sss_resampler s;
    if (sss_begin(&s, m, plan, x, n, seed) != SSS_OK) return -1;
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(f, &probe, hits);
        for (int i = 0; i < count; ++i, ++index) {
            float light = hint ? hint(st_local(&f->frame, hits[i].position), seed, index) : 1.0f;
            sss_add_hit(&s, hits[i].position, hits[i].normal, light);
        }
    }
    return sss_finish(&s, exits);
}

#endif /* SSS_TEST_H */
