/* sss_resample.h - v0.1.0 - exit points of subsurface scattering by importance resampling - C99, C++11, OpenCL C
   SPDX-License-Identifier: MIT. No warranty; the full text is in LICENSE.

   Light enters a translucent surface at one point and leaves at another. This header finds that other point:

       sss_medium wax;      sss_resampler s;      sss_probe probe;      sss_exit exit;
       sss_burley(&wax, albedo, dmfp);                               // once for each material
       sss_begin(&s, &wax, NULL, x, n, sss_hash(pixel, sample));     // once for each camera path that meets it
       while (sss_next_probe(&s, &probe))
           for (each hit of this object on the segment, nearest first)
               sss_add_hit(&s, hit.position, hit.normal, 1.0f);
       if (sss_finish(&s, &exit))
           radiance += exit.weight * shade_as_white_lambert(exit.position, exit.normal);

   WHAT IT DOES. It implements "Importance Resampling for BSSRDF" (Villemin, Hery, Christensen, Pixar Technical Memo
   16-05, 2016): probe rays find candidate exits, each is weighed by the diffusion profile over the density that found
   it, and one (or a few) is picked in proportion to that weight. Only what is picked is shaded. Beyond the memo:
   weights that are bounded on any geometry, stratified candidates, and a hint of the light at a candidate.
   WHAT IT DOES NOT. No ray tracing, no Fresnel factors at entry and exit (they are the caller's), no single
   scattering, no random walk, no allocation, no globals, no input or output, no libm beyond sqrtf and fabsf.

   OPTIONS, to be defined before the include, the same in every file of a program:
       SSS_MAX_EXITS       4      bounds sss_plan.exits; each costs 52 bytes of sss_resampler
       SSS_MAX_CANDIDATES  256    bounds sss_plan.candidates; costs nothing
       SSS_LANES           8      probes and hits worked on side by side, which changes no bit; each costs 60 bytes of
                                  sss_resampler. 1 suits a GPU. Compilers vectorise with -fno-math-errno

   CONVENTIONS
   Lengths are in scene units, coefficients in their inverse. Normals are geometric, of either sign and any length.
   The contract: for any irradiance E, the mean over seeds of
       sum over exits of weight[c] * E(exit)    equals    the integral over the surface of Rd_c(|y - x|) E(y) dA(y).
   It is exact for every plan that holds SSS_CHORD, for all numbers of candidates and exits. SSS_DISK with
   SSS_DISK_TANGENTS lacks the tail beyond the radius that holds all but 1e-4 of the widest channel's albedo. SSS_DISK
   alone misses faces at right angles to the entry's, SSS_SPHERE alone has infinite variance for Burley's profile:
   both are for smooth surfaces and for teaching. With SSS_SPHERE a medium's lengths may be 1e5 apart, not more: float32
   puts the hits of the widest channel's lines too coarsely for a narrower one, which loses light (1e8 apart: 14 %).
   Densities are *intensities*: expected hits per unit of surface area. They integrate to the expected number of hits,
   not to 1, and so all hits count (front, back, several on one probe), and sums are divided by probes, never by hits.
   Hits: each crossing of this object's surface once, at shared edges too: one reported twice counts twice, one missed
   loses its light. Trace every probe to its end, and do not start again where there is no hit. Step from hit to hit by
   primitive, not by an absolute epsilon, which far from the origin is less than an ulp. Shading normals lose light here
   (a tenth under a gentle bump map: make failures); they belong in E. One medium a lookup: the entry's.
   Bound: without hints one hit adds to exit.weight[c] at most albedo[c] * live channels * 2 / (chord's share of the
   probes) * b / candidates. b = 1 for Burley; for the dipoles the profile over its proposal, measured: 3.3 for eta up
   to 2, 8.3 up to 5. Lambert channels beside live ones add their albedo times their number to the first exit.
   Randomness: one 32-bit seed names a lookup; the same seed and hits give the same exits. Use one seed once.
   Bits: with -ffp-contract=off on the host the CPU and an OpenCL device compute the same bits, up to the bits that a
   NaN has. -ffast-math is refused. Scaling the scene by a power of two changes no pick and no bit of a weight.
   Nothing that a caller passes makes a NaN come out: bad media, plans and points are refused by name, bad hits
   ignored. Everything is reentrant.

   THEORY (numbers in brackets are cited below)
   [1] A probe is a random segment. If the expected number of times that probe j crosses a surface element dA is
       mu_j dA, and Lambda = sum over the M probes of mu_j, then  sum over all hits of f / Lambda  has the mean
       integral f dA: Campbell's theorem, and the balance heuristic over all techniques at once.
   [2] Resampling (Talbot et al. 2005): with w = g / Lambda for each hit and W their sum, pick one hit with the
       probability w / W; then f / g * W has the same mean. Its variance is that of M probes divided by M, and, as a
       floor, that of one exit drawn exactly from g. Here g is the mean of the live channels' unit profiles Rd / A,
       times the hint of the light: the nearer g is to Rd E, the lower the floor.
   [3] Disk (King et al. 2013): a line along axis a through a point of the disk about the entry, with planar density
       P(r_a): mu = P(r_a) |n.a|, r_a the distance from the axis; cut by the ball r <= r_max, 0 outside.
   [4] Sphere: a whole line in a uniform direction through o, a depth h below the entry (Burley d, dipoles z_r):
       mu = |n.w| / (2 pi |y - o|^2), w the direction from o to y; cut by the same ball.
   [5] Chord: the segment between two uniform points of the sphere of random radius rho about the entry. With
       the density -pi rho^2 P'(rho) of rho, mu = P(r) / 2 whatever the hit's normal: the bound above.
   [6] Burley's profile (Christensen and Burley 2015): Rd = A (e^(-r/d) + e^(-r/3d)) / (8 pi d r).
   [7] Dipoles (Jensen et al. 2001; d'Eon 2012), k = 4 pi Rd / A, z in {z_r, z_v}, d_z = sqrt(r^2 + z^2), s = sigma_tr:
       k = flux * sum of z (1 + s d_z) e^(-s d_z) / d_z^3 + fluence * (e^(-s d_r) / d_r - e^(-s d_v) / d_v). */
#ifndef SSS_RESAMPLE_H
#define SSS_RESAMPLE_H

/* ---- Language: all that differs between C, C++ and OpenCL C, and what a user may set ---- */
#if defined(__FAST_MATH__) || defined(__FAST_RELAXED_MATH__) || defined(__ASSOCIATIVE_MATH__) ||                       \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "sss_resample.h needs IEEE arithmetic: compile without -ffast-math, -ffinite-math-only, -cl-fast-relaxed-math"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__
#error "sss_resample.h needs IEEE arithmetic in float: -msse2 -mfpmath=sse on x86, -fexcess-precision=fast on s390x"
#endif
#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#pragma OPENCL FP_CONTRACT OFF
typedef uint uint32_t;
#define SSSI_TEXT    __constant char *
#define SSSI_SQRT(x) sqrt(x)
#define SSSI_FABS(x) fabs(x)
static inline uint32_t sssi_bits(float x) { return as_uint(x); }
static inline float sssi_float(uint32_t u) { return as_float(u); }
#else
#include <stdint.h>
#define SSSI_TEXT const char *
#if defined(__GNUC__) && defined(__STDC_HOSTED__) && !__STDC_HOSTED__ /* freestanding: there may be no libc */
#define SSSI_SQRT(x)       __builtin_sqrtf(x)
#define SSSI_FABS(x)       __builtin_fabsf(x)
#define SSSI_COPY(a, b, n) __builtin_memcpy(a, b, n)
#else
#include <math.h>
#include <string.h>
#define SSSI_SQRT(x)       sqrtf(x)
#define SSSI_FABS(x)       fabsf(x)
#define SSSI_COPY(a, b, n) memcpy(a, b, n)
#endif
static inline uint32_t sssi_bits(float x) {
    uint32_t u;
    SSSI_COPY(&u, &x, sizeof u);
    return u;
}
static inline float sssi_float(uint32_t u) {
    float x;
    SSSI_COPY(&x, &u, sizeof x);
    return x;
}
#endif
#if defined(__GNUC__) || defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define SSSI_FN static inline __attribute__((always_inline)) /* loops over these vectorise only when inlined */
#else
#define SSSI_FN static inline
#endif
#if defined(__OPTIMIZE__) || defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define SSSI_APART static __attribute__((noinline, unused)) /* loops in these vectorise whatever the caller is like */
#else
#define SSSI_APART static inline
#endif
#ifndef SSS_MAX_EXITS
#define SSS_MAX_EXITS 4
#endif
#ifndef SSS_MAX_CANDIDATES
#define SSS_MAX_CANDIDATES 256
#endif
#ifndef SSS_LANES
#define SSS_LANES 8
#endif
/* f(s, dipole, lanes) for n probes or hits, up to the number of lanes. Loops over lanes vectorise if their number is a
   constant and sqrt an instruction: then all are worked on, else as many as are needed. */
#if defined(__NO_MATH_ERRNO__) || defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define SSSI_WIDE             1
#define SSSI_CALL(f, s, d, n) ((n) > 1 ? f(s, d, SSS_LANES) : f(s, d, 1))
#else
#define SSSI_WIDE             0
#define SSSI_CALL(f, s, d, n) f(s, d, (n) < SSS_LANES ? (n) : SSS_LANES)
#endif
#if SSS_MAX_EXITS < 1 || SSS_LANES < 1 || SSS_MAX_CANDIDATES < 8 || SSS_MAX_CANDIDATES > 65534
#error "sss_resample.h needs SSS_MAX_EXITS >= 1, SSS_LANES >= 1 and SSS_MAX_CANDIDATES within 8..65534"
#endif

/* ---- Types ---- */
typedef struct sss_vec3 {
    float x, y, z;
} sss_vec3;

typedef enum sss_result {
    SSS_OK = 0,
    SSS_BAD_ALBEDO,
    SSS_BAD_LENGTH,
    SSS_BAD_ETA,
    SSS_BAD_NORMAL,
    SSS_BAD_POSITION,
    SSS_BAD_PLAN
} sss_result;

/* A material: three colour channels, all in plain floats. Made by the constructors below; its fields are private. */
typedef struct sss_medium {
    int dipole;       /* 0: Burley's profile [6]; 1: a dipole [7] */
    float albedo[3];  /* A: the integral of Rd over the plane, 0..1 */
    float length[3];  /* Burley's d or the dipole's z_r; 0: the channel scatters like Lambert, or is black */
    float zv[3];      /* depth of the dipole's virtual source */
    float sigma[3];   /* sigma_tr, 1/length */
    float flux[3];    /* [7], without unit */
    float fluence[3]; /* [7], 1/length; 0 for the standard dipole */
    float r_max;      /* holds all but 1e-4 of the widest live channel's albedo */
} sss_medium;

/* How many probes by which techniques. All zero means: 8 candidates, 1 exit, the default mix, stratified. */
enum { SSS_DISK = 1, SSS_DISK_TANGENTS = 2, SSS_SPHERE = 4, SSS_CHORD = 8 };
typedef struct sss_plan {
    int candidates;      /* M: probes for each lookup, 1..SSS_MAX_CANDIDATES; 0: 8 */
    int exits;           /* N: exits for each lookup, 1..SSS_MAX_EXITS; 0: 1. Probe j feeds exit j mod N */
    unsigned techniques; /* bits above, which share the probes equally; 0: the default mix */
    int independent;     /* not 0: the memo's plain algorithm, every choice drawn anew for each candidate */
} sss_plan;

/* What a scene asks for; lengths in scene units, 0 where not known. */
typedef struct sss_need {
    float footprint;        /* width of a pixel on the surface */
    float curvature_radius; /* of the surface about the entry; half the thickness where the object is thin */
    float shading_cost;     /* of shading one exit, over that of tracing one probe */
} sss_need;
enum { SSS_ADVICE_LAMBERT = 1, SSS_ADVICE_VOLUME = 2 };

typedef struct sss_probe {
    sss_vec3 origin, direction; /* direction is of unit length */
    float length;               /* in scene units: the segment ends at origin + length * direction */
} sss_probe;

typedef struct sss_exit {
    sss_vec3 position, normal; /* as given to sss_add_hit, the normal at unit length */
    float weight[3];           /* times white Lambert's radiance there: the contract above; >= 0, without unit */
} sss_exit;

typedef struct sssi_reservoir {
    float weight;        /* sum of w over the hits so far [2] */
    float plain;         /* the same without hints */
    float light, target; /* of the hit that is held: the hint and g */
    float profile[3];    /* and its unit profiles */
    sss_vec3 position, normal;
} sssi_reservoir;

typedef struct sssi_lanes { /* vectors side by side */
    float x[SSS_LANES], y[SSS_LANES], z[SSS_LANES];
} sssi_lanes;

enum { SSSI_NORMAL, SSSI_TANGENT, SSSI_BITANGENT, SSSI_SPHERE, SSSI_CHORD, SSSI_TECHNIQUES };

/* One lookup: plain values, lives on the stack, its fields are private. */
typedef struct sss_resampler {
    sss_medium medium; /* in units of `unit`; channels that are not live hold the lengths of one that is */
    sss_vec3 position; /* in scene units */
    sss_vec3 axis[3];  /* normal, tangent, bitangent: orthonormal */
    float unit;        /* scene units in an inner unit: 2^e <= the longest live length */
    float mix[3];      /* 1/n for the n live channels, 0 for the others */
    float lambert;     /* number of Lambert channels over number of live ones, 0 when there are none of the latter */
    int lambert_only;  /* there are Lambert channels and no live one */
    float share[SSSI_TECHNIQUES];   /* q of each technique: its expected part of the probes, sums to 1 */
    int first[SSSI_TECHNIQUES + 1]; /* stratified: technique t has the probes first[t] .. first[t + 1] - 1 */
    int candidates, exits, independent;
    uint32_t seed;
    int next, exit;               /* probes given; which exit the last of them feeds */
    sssi_lanes origin, direction; /* of the probes made together with the next one */
    float length[SSS_LANES];      /* not above 0: that probe has no segment */
    int hits, waiting;            /* hits weighed; hits that wait to be weighed together: */
    sssi_lanes hit_position, hit_normal;
    float hit_light[SSS_LANES];
    int hit_exit[SSS_LANES];
    sssi_reservoir reservoir[SSS_MAX_EXITS];
} sss_resampler;

/* ---- Functions ---- */

/* The name of a result, one line without a full stop. */
static inline SSSI_TEXT sss_result_string(sss_result result);

/* Media. Albedos in [0, 1]; lengths and coefficients 0 or in [1e-12, 1e12]; eta = n_inside / n_outside in [0.2, 5].
   Otherwise SSS_BAD_ALBEDO, SSS_BAD_LENGTH or SSS_BAD_ETA, and *m is black: safe to use, no light.
   A channel of length 0 scatters like Lambert with its albedo. */

/* Christensen and Burley 2015, dmfp = diffuse mean free path, searchlight, eq. 8. Fitted at matched indices. */
static inline sss_result sss_burley(sss_medium *m, const float albedo[3], const float dmfp[3]);
/* The same from the volume's mean free path, diffuse transmission, eq. 6. */
static inline sss_result sss_burley_mfp(sss_medium *m, const float albedo[3], const float mfp[3]);
/* Jensen et al. 2001, with exact Fresnel moments. sigma_a = sigma_s' = 0 is black. */
static inline sss_result sss_dipole(sss_medium *m, const float sigma_a[3], const float sigma_s_prime[3], float eta);
/* d'Eon 2012, "A better dipole": Grosjean's diffusion, multiple scattering only. */
static inline sss_result sss_better_dipole(sss_medium *m, const float sigma_a[3], const float sigma_s_prime[3],
                                           float eta);
/* The dipoles with the total reflectance `albedo` (to 1e-5) and sigma_tr = 1 / dmfp. At albedo 1 that is Lambert. */
static inline sss_result sss_dipole_from_albedo(sss_medium *m, const float albedo[3], const float dmfp[3], float eta);
static inline sss_result sss_better_dipole_from_albedo(sss_medium *m, const float albedo[3], const float dmfp[3],
                                                       float eta);

/* Rd(r) of a channel in 0..2, 1/length^2, r >= 0 in scene units; below 1e-6 of the channel's length as at that radius,
   and beyond 70 e-foldings without further decay. 0 for black and Lambert channels, and for a channel or radius that
   does not exist. Worst relative error: 4.0e-7 for Burley, 1.2e-6 for the standard dipole, 1.4e-6 for the better one,
   and 2.1e-7 more for each e-folding (tests/test_profiles.c). */
static inline float sss_profile(const sss_medium *m, int channel, float r);
/* The integral of Rd over the disk of radius r: 0..albedo; 0 for a channel or radius that does not exist. */
static inline float sss_within(const sss_medium *m, int channel, float r);

/* The cheapest plan for a need, and advice (NULL where not wanted) in SSS_ADVICE_ bits: Lambert where a pixel is wider
   than r_max, a volume where the flat profile would lose a fifth of a ball's light. The plan is SSS_DISK with one
   candidate where the surface is flat as far as r_max, else the default mix with the number of candidates that pays at
   that cost of shading; for hints of the light the default is the better plan. */
static inline sss_plan sss_plan_for(const sss_medium *m, const sss_need *need, unsigned *advice);

/* Starts a lookup. plan NULL: the default. SSS_BAD_PLAN (an unknown technique, a count below 0 or above its maximum),
   SSS_BAD_POSITION (not finite), SSS_BAD_NORMAL (zero, not finite): no probes, no exits. A black medium is SSS_OK. */
static inline sss_result sss_begin(sss_resampler *s, const sss_medium *m, const sss_plan *plan, sss_vec3 position,
                                   sss_vec3 geometric_normal, uint32_t seed);
/* 1 and a segment to trace while there is another probe, else 0. */
static inline int sss_next_probe(sss_resampler *s, sss_probe *probe);
/* A hit of the last probe, in order of distance (the mean does not mind the order, the bits do). light: a guess, in any
   unit, of the light that arrives there, 1 when not known. 0 drops the hit, which is exact only where no light comes;
   positive values act as clamped to [2^-40, 2^40] and change the variance, not the mean. */
static inline void sss_add_hit(sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal, float light);
/* Writes the exits, an array of plan.exits, and returns their number, 0..plan.exits. None is a fair sample of zero:
   do not try again. */
static inline int sss_finish(sss_resampler *s, sss_exit *exits);
/* Expected hits per unit area and probe at a point of the surface, 1/length^2. */
static inline float sss_intensity(const sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal);
/* A well mixed 32-bit hash of two, to name lookups: sss_hash(pixel, sample). */
static inline uint32_t sss_hash(uint32_t a, uint32_t b);

/* ---- Mathematics: the same bits on every device, hence not libm's. Worst errors over all arguments used here, against
   double precision (tests/test_math.c): exp 1.1 ulp, expm1 1.8 ulp, log 1 ulp, sin and cos 1e-7. ---- */
#define SSSI_PI       3.14159265f
#define SSSI_FLT_MAX  3.402823466e38f
#define SSSI_NUDGE    5.9604644e-8f /* 2^-24 */
#define SSSI_LOWEST   (-70.0f)      /* e^x below is as at -70: far away no ratio of profiles is 0/0 */
#define SSSI_R_MIN    1e-6f         /* of the length: profiles do not grow below */
#define SSSI_R_FAR    1e18f         /* squares do not overflow */
#define SSSI_TAIL     1e-4f         /* what r_max leaves out */
#define SSSI_LEN_MIN  1e-9f         /* shortest length in a lookup, over the longest: keeps 1/d^2 finite */
#define SSSI_TINY     1e-36f        /* hits of a lower target or weight, or a higher weight, are left out: they are */
#define SSSI_HUGE     1e20f         /* rarer or fainter than 1e-20, and nothing of the others over- or underflows */
#define SSSI_POLE_MIN 1e-25f        /* square of a distance from the sphere's origin: its power 3/2 is a normal float */
#define SSSI_HINT_MIN 9.0949470e-13f /* 2^-40 */
#define SSSI_HINT_MAX 1.0995116e12f

SSSI_FN float sssi_min(float a, float b) { return a < b ? a : b; }
SSSI_FN float sssi_max(float a, float b) { return a > b ? a : b; }

/* x = n ln 2 + f: returns 2^n and puts e^f - 1 in *p. x in [-87, 88]; adding 1.5 * 2^23 rounds to nearest. */
SSSI_FN float sssi_exp_parts(float x, float *p) {
    float n = (x * 1.44269504f + 12582912.0f) - 12582912.0f;
    float f = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float q = f * f, high = (1.0f / 24 + f * (1.0f / 120)) + q * (1.0f / 720 + f * (1.0f / 5040));
    *p = f + q * (0.5f + (f * (1.0f / 6) + q * high));
    return sssi_float((uint32_t)(127 + (int)n) << 23);
}
SSSI_FN float sssi_exp(float x) { /* x <= 80 */
    float p, scale = sssi_exp_parts(sssi_max(x, SSSI_LOWEST), &p);
    return scale + scale * p;
}
SSSI_FN float sssi_expm1(float x) { /* e^x - 1, accurate about 0 too */
    float p, scale = sssi_exp_parts(sssi_max(x, SSSI_LOWEST), &p);
    return scale * p + (scale - 1.0f);
}
/* (1 - e^-t) / t, t >= 0: the mean of e^-x over 0..t. */
SSSI_FN float sssi_mean_exp(float t) { return t > 0.0f ? -sssi_expm1(-t) / t : 1.0f; }

/* ln x for normal x > 0: x = 2^n m with m within [sqrt(1/2), sqrt(2)), and ln m = 2 artanh((m - 1) / (m + 1)). */
SSSI_FN float sssi_log(float x) {
    uint32_t u = sssi_bits(x) - 0x3f3504f3u + 0x3f800000u;
    float n = (float)((int)(u >> 23) - 127);
    float m = sssi_float((u & 0x007fffffu) + 0x3f3504f3u), f = m - 1.0f, s = f / (2.0f + f), z = s * s;
    float tail = s * (z * ((2.0f / 3 + z * (2.0f / 5)) + z * z * (2.0f / 7 + z * (2.0f / 9))) - f);
    return n * 0.693359375f + (f + (tail - n * 2.12194440e-4f));
}
/* sin and cos of 2 pi u, u in [0, 1]. */
SSSI_FN void sssi_sincos_turn(float u, float *s, float *c) {
    int quarter = (int)(4.0f * u + 0.5f);
    float x = (u - 0.25f * (float)quarter) * (2.0f * SSSI_PI), z = x * x;
    float sn = x + x * z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880))));
    float cs = 1.0f + z * (-0.5f + z * (1.0f / 24 + z * (-1.0f / 720 + z * (1.0f / 40320))));
    float a = (quarter & 1) ? cs : sn, b = (quarter & 1) ? sn : cs;
    *s = (quarter & 2) ? -a : a;
    *c = ((quarter + 1) & 2) ? -b : b;
}

SSSI_FN sss_vec3 sssi_vec3(float x, float y, float z) {
    sss_vec3 v = {x, y, z};
    return v;
}
SSSI_FN sss_vec3 sssi_add(sss_vec3 a, sss_vec3 b) { return sssi_vec3(a.x + b.x, a.y + b.y, a.z + b.z); }
SSSI_FN sss_vec3 sssi_sub(sss_vec3 a, sss_vec3 b) { return sssi_vec3(a.x - b.x, a.y - b.y, a.z - b.z); }
SSSI_FN sss_vec3 sssi_mul(sss_vec3 a, float k) { return sssi_vec3(a.x * k, a.y * k, a.z * k); }
SSSI_FN float sssi_dot(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SSSI_FN sss_vec3 sssi_lane(const sssi_lanes *v, int l) { return sssi_vec3(v->x[l], v->y[l], v->z[l]); }
SSSI_FN void sssi_set_lane(sssi_lanes *v, int l, sss_vec3 a) {
    v->x[l] = a.x;
    v->y[l] = a.y;
    v->z[l] = a.z;
}
SSSI_FN int sssi_finite(sss_vec3 v) { return (0.0f * v.x + 0.0f * v.y) + 0.0f * v.z == 0.0f; } /* else NaN */
SSSI_FN float sssi_longest(sss_vec3 v) { return sssi_max(SSSI_FABS(v.x), sssi_max(SSSI_FABS(v.y), SSSI_FABS(v.z))); }
/* Unit length from any length; 0, and NaNs, from a zero or infinite vector or one with a NaN. */
SSSI_FN int sssi_normalize(sss_vec3 *v) {
    float m = sssi_longest(*v), length;
    *v = sssi_vec3(v->x / m, v->y / m, v->z / m);
    length = SSSI_SQRT(sssi_dot(*v, *v));
    *v = sssi_vec3(v->x / length, v->y / length, v->z / length);
    return length > 0.0f;
}
/* Two tangents of a unit normal: Duff et al., "Building an orthonormal basis, revisited", JCGT 2017. */
SSSI_FN void sssi_frame(sss_vec3 n, sss_vec3 *t, sss_vec3 *b) {
    float sign = n.z >= 0.0f ? 1.0f : -1.0f, a = -1.0f / (sign + n.z), c = n.x * n.y * a;
    *t = sssi_vec3(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    *b = sssi_vec3(c, sign + n.y * n.y * a, -n.y);
}

/* ---- Random numbers ---- */
SSSI_FN uint32_t sssi_mix(uint32_t x) { /* a bijection in which each bit of the input flips each of the output */
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}
static inline uint32_t sss_hash(uint32_t a, uint32_t b) { return sssi_mix(sssi_mix(a + 0x9e3779b9u) ^ b); }
SSSI_FN float sssi_unit(uint32_t bits) { return ((float)(bits >> 9) + 0.5f) * 1.1920929e-7f; } /* (0, 1) */
SSSI_FN float sssi_open(float u) { return sssi_min(sssi_max(u, SSSI_NUDGE), 1.0f - SSSI_NUDGE); }
/* One of n classes by *u, which becomes a uniform number again. */
SSSI_FN int sssi_class(float *u, int n) {
    float x = *u * (float)n;
    int i = (int)x < n ? (int)x : n - 1;
    *u = sssi_open(x - (float)i);
    return i;
}

/* ---- Media ---- */
static inline SSSI_TEXT sss_result_string(sss_result result) {
    switch (result) {
    case SSS_OK: return "ok";
    case SSS_BAD_ALBEDO: return "an albedo is not within 0..1";
    case SSS_BAD_LENGTH: return "a length or coefficient is neither 0 nor within 1e-12..1e12";
    case SSS_BAD_ETA: return "the relative index of refraction is not within 0.2..5";
    case SSS_BAD_NORMAL: return "a normal is zero or not finite";
    case SSS_BAD_POSITION: return "a position is not finite";
    case SSS_BAD_PLAN: return "a plan has an unknown technique or a count out of range";
    }
    return "not a result of sss_resample.h";
}

SSSI_FN sss_medium sssi_black(void) {
    sss_medium m;
    int c;
    m.dipole = 0;
    for (c = 0; c < 3; ++c) m.albedo[c] = m.length[c] = m.zv[c] = m.sigma[c] = m.flux[c] = m.fluence[c] = 0.0f;
    m.r_max = 0.0f;
    return m;
}
SSSI_FN int sssi_is_live(const sss_medium *m, int c) { return m->albedo[c] > 0.0f && m->length[c] > 0.0f; }
SSSI_FN int sssi_in_range(float x) { return x == 0.0f || (x >= 1e-12f && x <= 1e12f); }
SSSI_FN sss_result sssi_check(const float *albedo, const float *a, const float *b, float eta) {
    int c;
    for (c = 0; c < 3; ++c)
        if (albedo && !(albedo[c] >= 0.0f && albedo[c] <= 1.0f)) return SSS_BAD_ALBEDO;
    for (c = 0; c < 3; ++c)
        if (!sssi_in_range(a[c]) || (b && !sssi_in_range(b[c]))) return SSS_BAD_LENGTH;
    return eta >= 0.2f && eta <= 5.0f ? SSS_OK : SSS_BAD_ETA;
}

/* Unit profile Rd / A of channel c at distance sqrt(r2): [6] and [7]. */
SSSI_FN float sssi_burley_unit(float d, float r2) {
    float decay = 1.0f / (3.0f * d), r = sssi_max(SSSI_SQRT(r2), SSSI_R_MIN * d), e = sssi_exp(-decay * r);
    return (e + e * e * e) * (0.375f / SSSI_PI * decay) / r;
}
SSSI_FN float sssi_dipole_unit(const sss_medium *m, int c, float r2) {
    float zr = m->length[c], zv = m->zv[c], s = m->sigma[c];
    float dr = SSSI_SQRT(r2 + zr * zr), dv = SSSI_SQRT(r2 + zv * zv), far = (zv - zr) * (zv + zr) / (dr + dv);
    float er = sssi_exp(-s * dr), fall = sssi_expm1(-s * far), ev = er * (1.0f + fall);
    float poles = zr / dr * (1.0f + s * dr) * er / (dr * dr) + zv / dv * (1.0f + s * dv) * ev / (dv * dv);
    return m->flux[c] * poles + m->fluence[c] * er * (far - dr * fall) / (dr * dv);
}
SSSI_FN float sssi_profile_unit(const sss_medium *m, int dipole, int c, float r2) {
    return dipole ? sssi_dipole_unit(m, c, r2) : sssi_burley_unit(m->length[c], r2);
}

/* The integral of the unit profile beyond r, and within r: each accurate where it is the smaller of the two. */
SSSI_FN float sssi_tail(const sss_medium *m, int c, float r) {
    float zr = m->length[c], zv = m->zv[c], s = m->sigma[c];
    if (m->dipole) {
        float dr = SSSI_SQRT(r * r + zr * zr), dv = SSSI_SQRT(r * r + zv * zv), far = (zv - zr) * (zv + zr) / (dr + dv);
        float er = sssi_exp(-s * dr), poles = zr / dr * er + zv / dv * sssi_exp(-s * dv);
        return 2.0f * SSSI_PI * (m->flux[c] * poles + m->fluence[c] * er * far * sssi_mean_exp(s * far));
    } else {
        float e = sssi_exp(-r / (3.0f * zr));
        return 0.25f * e * (3.0f + e * e);
    }
}
SSSI_FN float sssi_head(const sss_medium *m, int c, float r) {
    float s = m->sigma[c], poles[2], waves[2];
    int i;
    if (!m->dipole) {
        float e = sssi_expm1(-r / (3.0f * m->length[c]));
        return -0.25f * e * (6.0f + e * (3.0f + e));
    }
    for (i = 0; i < 2; ++i) { /* l = d_z - z; what is within comes from e^(-s z) (1 - e^(-s l) z / d_z) */
        float z = i ? m->zv[c] : m->length[c], dz = SSSI_SQRT(r * r + z * z), l = r * (r / (dz + z));
        poles[i] = sssi_exp(-s * z) * (sssi_exp(-s * l) * (l / dz) - sssi_expm1(-s * l));
        waves[i] = sssi_exp(-s * z) * l * sssi_mean_exp(s * l);
    }
    return 2.0f * SSSI_PI * (m->flux[c] * (poles[0] + poles[1]) + m->fluence[c] * (waves[0] - waves[1]));
}

/* Sets r_max, the last step of every constructor. Positive floats are in the order of their bits. */
SSSI_FN void sssi_set_r_max(sss_medium *m) {
    int c;
    m->r_max = 0.0f;
    for (c = 0; c < 3; ++c) {
        if (sssi_is_live(m, c)) {
            uint32_t low = sssi_bits(m->length[c]), high = sssi_bits((m->length[c] + m->zv[c]) * 1e5f);
            while (high - low > 1u) {
                uint32_t middle = low + (high - low) / 2u;
                if (sssi_tail(m, c, sssi_float(middle)) > SSSI_TAIL) low = middle;
                else high = middle;
            }
            m->r_max = sssi_max(m->r_max, sssi_float(high));
        }
    }
}

/* dmfp / d: equation 8 of [6]. */
SSSI_FN float sssi_burley_scale(float a) {
    float b = a - 0.33f;
    return 3.5f + 100.0f * (b * b) * (b * b);
}
SSSI_FN sss_result sssi_make_burley(sss_medium *m, const float *albedo, const float *path, int diffuse) {
    sss_result result = sssi_check(albedo, path, 0, 1.0f);
    int c;
    *m = sssi_black();
    if (result != SSS_OK) return result;
    for (c = 0; c < 3; ++c) {
        float a = albedo[c], s = sssi_burley_scale(a);
        if (diffuse) s = 1.9f - a + 3.5f * (a - 0.8f) * (a - 0.8f);
        m->albedo[c] = a;
        m->length[c] = path[c] / s;
    }
    sssi_set_r_max(m);
    return SSS_OK;
}
static inline sss_result sss_burley(sss_medium *m, const float albedo[3], const float dmfp[3]) {
    return sssi_make_burley(m, albedo, dmfp, 0);
}
static inline sss_result sss_burley_mfp(sss_medium *m, const float albedo[3], const float mfp[3]) {
    return sssi_make_burley(m, albedo, mfp, 1);
}

/* The boundary of a dipole: z_v = z_r + 4 A D, and the part of the reflectance that comes from the flux. */
typedef struct sssi_boundary {
    int better;
    float a, flux;
} sssi_boundary;

/* Moments 2 C1 and 3 C2 of the internal Fresnel reflectance F, C_i = integral of F mu^i dmu over 0..1, mu the cosine
   inside. y is the cosine on the thin side, z that on the dense; a quintic in place of y makes the midpoint rule
   converge as a Gauss rule does: 2e-8 for all eta. */
SSSI_FN sssi_boundary sssi_make_boundary(float eta, int better) {
    float n = eta > 1.0f ? eta : 1.0f / eta, n2 = (n - 1.0f) * (n + 1.0f), c1 = 0.0f, c2 = 0.0f;
    sssi_boundary b;
    int i;
    for (i = 0; i < 32; ++i) {
        float x = ((float)i + 0.5f) / 32, y = x * x * x * (10.0f + x * (6.0f * x - 15.0f));
        float dy = 30.0f / 32 * (x * (1.0f - x)) * (x * (1.0f - x)), z = SSSI_SQRT(y * y + n2) / n;
        float rs = (y - n * z) / (y + n * z), rp = (n * y - z) / (n * y + z);
        float f = 0.5f * (rs * rs + rp * rp) * y * dy;
        c1 += f;
        c2 += f * (eta > 1.0f ? z : y);
    }
    if (eta > 1.0f) { /* mu dmu = y dy / n^2, and all is reflected beyond the critical angle */
        float critical = n2 / (n * n);
        c1 = c1 / (n * n) + critical / 2;
        c2 = c2 / (n * n) + critical * SSSI_SQRT(critical) / 3;
    }
    b.better = better;
    b.a = (1.0f + (better ? 3.0f * c2 : 2.0f * c1)) / (1.0f - 2.0f * c1);
    b.flux = better ? 0.5f * (1.0f - 3.0f * c2) : 1.0f;
    return b;
}

/* A dipole in units of 1 / sigma_t', named by x = sqrt(sigma_a / sigma_s'), so that both albedo' = 1 / (1 + x^2) and
   its complement keep all their digits. */
typedef struct sssi_shape {
    float sigma, depth; /* sigma_tr, z_v - z_r */
    float core;         /* R without the power of albedo' in front */
    float total, lack;  /* reflectance and 1 - reflectance, each to relative precision */
} sssi_shape;

SSSI_FN sssi_shape sssi_make_shape(const sssi_boundary *b, float x) {
    float p = x * x / (1.0f + x * x), alpha = 1.0f / (1.0f + x * x), front, dark, t, slope, er, ev;
    sssi_shape h;
    h.sigma = SSSI_SQRT(b->better ? 3.0f * p / (1.0f + p) : 3.0f * p);
    h.depth = 4.0f / 3 * b->a * (b->better ? 1.0f + p : 1.0f);
    t = h.sigma * h.depth;
    er = sssi_expm1(-h.sigma);
    ev = sssi_expm1(-h.sigma - t);
    slope = t < 0.5f ? t / 2 * (1.0f - t / 3 * (1.0f - t / 4 * (1.0f - t / 5 * (1.0f - t / 6 * (1.0f - t / 7)))))
                     : (t + sssi_expm1(-t)) / t; /* 1 - (1 - e^-t) / t */
    h.core = b->flux * (1.0f + 0.5f * (er + ev)) + (1.0f - b->flux) * (1.0f + er) * sssi_mean_exp(t);
    dark = -0.5f * b->flux * (er + ev) + (1.0f - b->flux) * ((1.0f + er) * slope - er); /* 1 - core */
    front = b->better ? alpha * alpha : alpha;
    h.total = front * h.core;
    h.lack = (b->better ? p * (2.0f - p) : p) + front * dark;
    return h;
}
/* Channel c with the shape x and the reduced mean free path z_r. */
SSSI_FN void sssi_set_dipole(sss_medium *m, int c, const sssi_boundary *b, const sssi_shape *h, float zr) {
    m->length[c] = zr;
    m->zv[c] = zr + zr * h->depth;
    m->sigma[c] = h->sigma / zr;
    m->flux[c] = b->flux / (4.0f * SSSI_PI * h->core);
    m->fluence[c] = (1.0f - b->flux) / (2.0f * SSSI_PI * h->core * h->depth * zr);
}
SSSI_FN sss_result sssi_make_dipole(sss_medium *m, const float *sigma_a, const float *sigma_s, float eta, int better) {
    sss_result result = sssi_check(0, sigma_a, sigma_s, eta);
    sssi_boundary b;
    int c;
    *m = sssi_black();
    if (result != SSS_OK) return result;
    b = sssi_make_boundary(eta, better);
    m->dipole = 1;
    for (c = 0; c < 3; ++c) {
        if (sigma_s[c] > 0.0f) {
            sssi_shape h = sssi_make_shape(&b, SSSI_SQRT(sigma_a[c] / sigma_s[c]));
            m->albedo[c] = sssi_min(h.total, 1.0f);
            sssi_set_dipole(m, c, &b, &h, 1.0f / (sigma_a[c] + sigma_s[c]));
        }
    }
    sssi_set_r_max(m);
    return SSS_OK;
}
/* The total falls as x grows: bisection on the bits of x, with the smaller of total and lack compared. */
SSSI_FN sss_result sssi_invert_dipole(sss_medium *m, const float *albedo, const float *dmfp, float eta, int better) {
    sss_result result = sssi_check(albedo, dmfp, 0, eta);
    sssi_boundary b;
    int c;
    *m = sssi_black();
    if (result != SSS_OK) return result;
    b = sssi_make_boundary(eta, better);
    m->dipole = 1;
    for (c = 0; c < 3; ++c) {
        m->albedo[c] = albedo[c];
        if (albedo[c] > 0.0f && albedo[c] < 1.0f && dmfp[c] > 0.0f) {
            uint32_t low = sssi_bits(1e-15f), high = sssi_bits(1e15f);
            sssi_shape h;
            while (high - low > 1u) {
                uint32_t middle = low + (high - low) / 2u;
                h = sssi_make_shape(&b, sssi_float(middle));
                if (albedo[c] < 0.5f ? h.total > albedo[c] : h.lack < 1.0f - albedo[c]) low = middle;
                else high = middle;
            }
            h = sssi_make_shape(&b, sssi_float(high));
            /* Lambert where 1 / z_r^2 would leave float's range. */
            if (h.sigma * dmfp[c] >= 1e-17f) sssi_set_dipole(m, c, &b, &h, h.sigma * dmfp[c]);
        }
    }
    sssi_set_r_max(m);
    return SSS_OK;
}
static inline sss_result sss_dipole(sss_medium *m, const float sigma_a[3], const float sigma_s_prime[3], float eta) {
    return sssi_make_dipole(m, sigma_a, sigma_s_prime, eta, 0);
}
static inline sss_result sss_better_dipole(sss_medium *m, const float sigma_a[3], const float sigma_s_prime[3],
                                           float eta) {
    return sssi_make_dipole(m, sigma_a, sigma_s_prime, eta, 1);
}
static inline sss_result sss_dipole_from_albedo(sss_medium *m, const float albedo[3], const float dmfp[3], float eta) {
    return sssi_invert_dipole(m, albedo, dmfp, eta, 0);
}
static inline sss_result sss_better_dipole_from_albedo(sss_medium *m, const float albedo[3], const float dmfp[3],
                                                       float eta) {
    return sssi_invert_dipole(m, albedo, dmfp, eta, 1);
}

static inline float sss_profile(const sss_medium *m, int channel, float r) {
    float k;
    if (channel < 0 || channel > 2 || !(r >= 0.0f) || !sssi_is_live(m, channel)) return 0.0f;
    k = sssi_min(r, SSSI_R_FAR);
    return m->albedo[channel] * sssi_profile_unit(m, m->dipole, channel, k * k);
}
static inline float sss_within(const sss_medium *m, int channel, float r) {
    float tail;
    if (channel < 0 || channel > 2 || !(r >= 0.0f)) return 0.0f;
    if (!sssi_is_live(m, channel)) return m->albedo[channel];
    tail = sssi_tail(m, channel, sssi_min(r, SSSI_R_FAR));
    return m->albedo[channel] * sssi_max(tail > 0.5f ? sssi_head(m, channel, r) : 1.0f - tail, 0.0f);
}

/* ---- Plan ---- */
/* What a walk lets out of a ball lit from everywhere: A, and of the rest 1 / (1 + 0.7 (r / dmfp)^1.5); to 6 %. */
SSSI_FN float sssi_ball_albedo(const sss_medium *m, int c, float r) {
    float a = m->albedo[c], x = m->dipole ? r * m->sigma[c] : r / (m->length[c] * sssi_burley_scale(a));
    return a + (1.0f - a) / (1.0f + 0.7f * x * SSSI_SQRT(x));
}
static inline sss_plan sss_plan_for(const sss_medium *m, const sss_need *need, unsigned *advice) {
    sss_plan plan = {0, 0, 0u, 0};
    unsigned bits = 0;
    float r = need->curvature_radius, cost = need->shading_cost;
    int c, live = 0;
    for (c = 0; c < 3; ++c) {
        if (!sssi_is_live(m, c)) continue;
        live = 1;
        if (r > 0.0f && sss_within(m, c, 2.0f * r) < 0.8f * sssi_ball_albedo(m, c, r)) bits |= SSS_ADVICE_VOLUME;
    }
    if (!live || need->footprint > m->r_max) bits = SSS_ADVICE_LAMBERT;
    /* M* = sqrt((V_1 / V_g - 1) c_s / c_p), V_1 = 3 V_g (make mix), in eights: eight cost little more than five. */
    if (cost > 0.0f) {
        int eights = (int)(SSSI_SQRT(2.0f * sssi_min(cost, 2048.0f)) / 8.0f + 0.5f);
        plan.candidates = cost < 1.5f ? 4 : eights < 1 ? 8 : 8 * eights;
        if (plan.candidates > SSS_MAX_CANDIDATES) plan.candidates = SSS_MAX_CANDIDATES;
    }
    if (r >= m->r_max && live) { /* all in the ball faces up: one candidate is as good as many */
        plan.candidates = 1;
        plan.techniques = SSS_DISK;
    }
    if (advice) *advice = bits;
    return plan;
}

/* Shares of a plan's techniques: equal over the set bits, and of the two tangents. The default mix was measured by
   demos/mix.c: the sphere finds curved and thin bodies, the disk flat ones, and the chord bounds the weights. */
SSSI_FN void sssi_set_shares(sss_resampler *s, unsigned bits) {
    float each;
    int t, n = 0;
    for (t = 0; t < 4; ++t) n += (int)(bits >> t & 1u);
    each = 1.0f / (float)(n > 0 ? n : 1);
    s->share[SSSI_NORMAL] = !bits ? 0.375f : bits & SSS_DISK ? each : 0.0f;
    s->share[SSSI_TANGENT] = s->share[SSSI_BITANGENT] = bits & SSS_DISK_TANGENTS ? 0.5f * each : 0.0f;
    s->share[SSSI_SPHERE] = !bits ? 0.375f : bits & SSS_SPHERE ? each : 0.0f;
    s->share[SSSI_CHORD] = !bits ? 0.25f : bits & SSS_CHORD ? each : 0.0f;
}
/* Whole probes for each technique: floor or ceiling of M q, and M q in the mean, by systematic sampling. */
SSSI_FN void sssi_set_counts(sss_resampler *s) {
    float u = sssi_unit(sss_hash(s->seed, 0x40000000u)), sum = 0.0f;
    int t;
    s->first[0] = 0;
    for (t = 0; t < SSSI_TECHNIQUES; ++t) {
        float whole, expected;
        sum += s->share[t];
        expected = sum * (float)s->candidates;
        whole = (float)(int)expected;
        s->first[t + 1] = (int)whole + (expected - whole > u);
    }
    s->first[SSSI_TECHNIQUES] = s->candidates;
}

SSSI_FN sss_result sssi_check_lookup(const sss_plan *plan, sss_vec3 position, sss_vec3 *normal) {
    if (plan->candidates < 0 || plan->candidates > SSS_MAX_CANDIDATES || plan->exits < 0 ||
        plan->exits > SSS_MAX_EXITS || plan->techniques > 15u)
        return SSS_BAD_PLAN;
    if (!sssi_finite(position)) return SSS_BAD_POSITION;
    return sssi_normalize(normal) ? SSS_OK : SSS_BAD_NORMAL;
}
/* The medium in units of 2^e <= its longest live length, and the channels' parts in the mixtures. */
SSSI_FN void sssi_set_medium(sss_resampler *s, const sss_medium *m) {
    float longest = 0.0f, inverse;
    int c, wide = 0, live = 0, lambert = 0;
    s->medium = *m;
    for (c = 0; c < 3; ++c) {
        live += sssi_is_live(m, c);
        lambert += m->albedo[c] > 0.0f && !sssi_is_live(m, c);
        if (sssi_is_live(m, c) && m->length[c] > longest) longest = m->length[c], wide = c;
    }
    s->lambert = live ? (float)lambert / (float)live : 0.0f;
    s->lambert_only = lambert && !live;
    s->unit = live ? sssi_float(sssi_bits(longest) & 0x7f800000u) : 1.0f;
    inverse = 1.0f / s->unit;
    for (c = 0; c < 3; ++c) {
        int from = sssi_is_live(m, c) ? c : wide;
        float scale = inverse, back = s->unit;
        if (m->length[from] * inverse < SSSI_LEN_MIN && live)
            scale = SSSI_LEN_MIN / m->length[from], back = m->length[from] / SSSI_LEN_MIN;
        s->mix[c] = sssi_is_live(m, c) ? 1.0f / (float)live : 0.0f;
        s->medium.length[c] = m->length[from] * scale;
        s->medium.zv[c] = m->zv[from] * scale;
        s->medium.sigma[c] = m->sigma[from] * back;
        s->medium.flux[c] = m->flux[from];
        s->medium.fluence[c] = m->fluence[from] * back;
    }
    s->medium.r_max = m->r_max * inverse;
}
static inline sss_result sss_begin(sss_resampler *s, const sss_medium *m, const sss_plan *plan, sss_vec3 position,
                                   sss_vec3 geometric_normal, uint32_t seed) {
    sss_plan given = {0, 0, 0u, 0};
    sss_result result;
    int i, live;
    if (plan) given = *plan;
    result = sssi_check_lookup(&given, position, &geometric_normal);
    sssi_set_medium(s, m);
    live = s->mix[0] + s->mix[1] + s->mix[2] > 0.0f;
    if (result != SSS_OK) {
        position = sssi_vec3(0.0f, 0.0f, 0.0f);
        geometric_normal = sssi_vec3(0.0f, 0.0f, 1.0f);
        live = s->lambert_only = 0;
        s->lambert = 0.0f;
        given.exits = 0;
    }
    s->position = position;
    s->axis[SSSI_NORMAL] = geometric_normal;
    sssi_frame(geometric_normal, &s->axis[SSSI_TANGENT], &s->axis[SSSI_BITANGENT]);
    s->candidates = !live ? 0 : given.candidates ? given.candidates : 8;
    s->exits = result != SSS_OK ? 0 : given.exits ? given.exits : 1;
    s->independent = given.independent;
    s->next = s->hits = s->waiting = 0;
    s->exit = s->exits - 1;
    s->seed = seed;
    sssi_set_shares(s, given.techniques);
    sssi_set_counts(s);
    for (i = 0; i < s->exits; ++i) s->reservoir[i].weight = s->reservoir[i].plain = 0.0f; /* else set with a hit */
    for (i = 0; i < SSS_LANES; ++i) { /* lanes without a hit are worked on too */
        sssi_set_lane(&s->hit_position, i, geometric_normal);
        sssi_set_lane(&s->hit_normal, i, geometric_normal);
        s->hit_light[i] = 1.0f;
        s->hit_exit[i] = 0;
    }
    return result;
}

/* ---- Probes ---- */

/* Random numbers. The n probes of a technique are a lattice in all their dimensions: from where the lookup's seed puts
   probe 0, probe k stands k p / n of a turn on, p the prime that names the dimension. So each dimension has one number
   in each of n equal strata (a Latin hypercube), and angles are evenly spaced. The primes were chosen for even pairs
   of dimensions at n up to 96. An independent probe is number 0 of a lattice of its own. */
enum { SSSI_CHANNEL = 449, SSSI_PART = 607, SSSI_RADIUS = 457, SSSI_TURN = 379 };
enum { SSSI_SIDE = 569, SSSI_COSINE = 563, SSSI_TURN_B = 641 };
typedef struct sssi_places { /* where the next probes stand */
    int technique[SSS_LANES];
    uint32_t name[SSS_LANES];                          /* of the lattice */
    float k[SSS_LANES], n[SSS_LANES], step[SSS_LANES]; /* step = 1 / n */
} sssi_places;

SSSI_FN void sssi_find_places(const sss_resampler *s, int count, sssi_places *at) {
    const int *f = s->first;
    int n[SSSI_TECHNIQUES], f1 = f[1], f2 = f[2], f3 = f[3], f4 = f[4], j[SSS_LANES], l;
    for (l = 0; l < SSSI_TECHNIQUES; ++l) n[l] = f[l + 1] - f[l];
    for (l = 0; l < count; ++l) j[l] = s->next + l < s->candidates ? s->next + l : s->candidates - 1;
    for (l = 0; l < count; ++l) { /* no branches, or this would not vectorise */
        int past1 = j[l] >= f1, past2 = j[l] >= f2, past3 = j[l] >= f3, past4 = j[l] >= f4;
        int before = past1 * n[0] + past2 * n[1] + past3 * n[2] + past4 * n[3];
        int all = n[0] + past1 * (n[1] - n[0]) + past2 * (n[2] - n[1]) + past3 * (n[3] - n[2]) + past4 * (n[4] - n[3]);
        at->technique[l] = past1 + past2 + past3 + past4;
        at->name[l] = (uint32_t)at->technique[l] << 10;
        at->k[l] = (float)(j[l] - before);
        at->n[l] = (float)all;
        at->step[l] = 1.0f / (float)all;
    }
    for (l = 0; l < count && s->independent; ++l) {
        float u = sssi_unit(sss_hash(s->seed, 0x50000000u + (uint32_t)j[l])), sum = s->share[0];
        at->technique[l] = 0;
        while (u > sum && at->technique[l] < SSSI_CHORD) sum += s->share[++at->technique[l]];
        at->name[l] = (uint32_t)(SSSI_TECHNIQUES + j[l]) << 10;
        at->k[l] = 0.0f;
    }
}
SSSI_FN void sssi_draw(const sss_resampler *s, int count, const sssi_places *at, int prime, float *u) {
    int l;
    for (l = 0; l < count; ++l) {
        float kp = at->k[l] * (float)prime;
        float place = kp - at->n[l] * (float)(int)(kp * at->step[l] - 0.5f); /* k p less whole turns: 0..1.5 n */
        float x = place * at->step[l] + sssi_unit(sss_hash(s->seed, at->name[l] + (uint32_t)prime));
        u[l] = sssi_open(x - (float)(int)x);
    }
}

/* The proposal P of channel c, a unit density over the plane: Burley's profile itself, and for the dipoles the two
   poles p(z; r) = z / (2 pi (r^2 + z^2)^1.5) with 1/4 each and Burley's profile at d = 1 / (3 sigma_tr) with 1/2,
   which is left out at sigma_tr = 0. */
SSSI_FN float sssi_pole(float z, float r2) {
    float dz2 = r2 + z * z;
    return z / (2.0f * SSSI_PI * dz2 * SSSI_SQRT(dz2));
}
SSSI_FN float sssi_proposal(const sss_medium *m, int dipole, int c, float r2) {
    float poles;
    if (!dipole) return sssi_burley_unit(m->length[c], r2);
    poles = 0.5f * (sssi_pole(m->length[c], r2) + sssi_pole(m->zv[c], r2));
    return m->sigma[c] > 0.0f ? 0.5f * (poles + sssi_burley_unit(1.0f / (3.0f * m->sigma[c]), r2)) : poles;
}

/* A distance with density 2 pi r P(r) from a uniform u; Burley: u is the tail x (x^2 + 3) / 4, x = e^(-r/3d). */
SSSI_FN float sssi_burley_step(float x, float u) {
    return x - (x * (x * x + 3.0f) - 4.0f * u) / (3.0f * (x * x + 1.0f));
}
SSSI_FN float sssi_burley_radius(float d, float u) {
    float x = u * (4.0f / 3 - u * (1.0f / 3));
    x = sssi_burley_step(sssi_burley_step(x, u), u);
    return -3.0f * d * sssi_log(sssi_min(x, 1.0f));
}
/* The radius of a chord's sphere, with density -pi rho^2 P'(rho). Burley: the tail 3/4 T(rho/3d) + 1/4 T(rho/d), where
   T(t) = e^-t (1 + t/2) is half an exponential and half the sum of two; `part` picks. */
SSSI_FN float sssi_burley_chord(float d, float part, float u) {
    int i = sssi_class(&part, 8);
    return -(i < 6 ? 3.0f * d : d) * sssi_log(i & 1 ? u * part : u);
}
/* The same for a pole: the distance to it is z / c, with c = u on disks; u = (3c - c^3) / 2 for chords, that is
   1 - u = v = e^2 (3 - e) / 2, e = 1 - c, by Newton. */
SSSI_FN float sssi_pole_radius(float z, float c) { return z * SSSI_SQRT((1.0f - c) * (1.0f + c)) / c; }
SSSI_FN float sssi_pole_chord_step(float e, float v) {
    return e - (e * e * (3.0f - e) - 2.0f * v) / (3.0f * e * (2.0f - e));
}
SSSI_FN float sssi_pole_chord(float z, float u) {
    float v = 1.0f - u, e = SSSI_SQRT(v * (2.0f / 3 + v * (1.0f / 3)));
    e = sssi_pole_chord_step(sssi_pole_chord_step(sssi_pole_chord_step(e, v), v), v);
    return sssi_pole_radius(z, sssi_max(1.0f - e, SSSI_NUDGE));
}
/* A radius from u, for a disk or a chord; `part` picks among the parts of the proposal. */
SSSI_FN float sssi_radius(int dipole, int all, float length, float zv, float sigma, int chord, float part, float u) {
    int i = dipole ? sssi_class(&part, sigma > 0.0f ? 4 : 2) : 2, pole = i < 2;
    float z = i > 0 ? zv : length, d = dipole ? 1.0f / (3.0f * sigma) : length;
    float disk_pole = all || (!chord && pole) ? sssi_pole_radius(z, u) : 0.0f;
    float disk_wave = all || (!chord && !pole) ? sssi_burley_radius(d, u) : 0.0f;
    float chord_pole = all || (chord && pole) ? sssi_pole_chord(z, u) : 0.0f;
    float chord_wave = all || (chord && !pole) ? sssi_burley_chord(d, part, u) : 0.0f;
    float of_pole = chord ? chord_pole : disk_pole, of_wave = chord ? chord_wave : disk_wave;
    return !dipole ? of_wave : pole ? of_pole : of_wave;
}

/* The ends of a probe's segment: `rim` from its axis and `height` along it, about the entry. */
typedef struct sssi_ends {
    float rim_a, height_a, rim_b, height_b;
} sssi_ends;

/* [3]. Beyond r_max the ends meet, and there is no probe. */
SSSI_FN sssi_ends sssi_disk_ends(float r, float r_max) {
    float height = SSSI_SQRT(sssi_max(r_max * r_max - r * r, 0.0f));
    sssi_ends e = {r, height, r, -height};
    return e;
}
/* [4]. The line is o + t w, w the upper of its two directions; the ball cuts it at t = h (n.w) -+ reach. */
SSSI_FN sssi_ends sssi_sphere_ends(float h, float r_max, float z) {
    float rim = SSSI_SQRT((1.0f - z) * (1.0f + z)), reach = SSSI_SQRT((r_max - h) * (r_max + h) + h * h * z * z);
    float a = h * z + reach, b = h * z - reach;
    sssi_ends e = {a * rim, a * z - h, b * rim, b * z - h};
    return e;
}
/* [5]. Half of the chords join the two sides of the tangent plane, a quarter lies above it and a quarter below. */
SSSI_FN sssi_ends sssi_chord_ends(float rho, float za, float zb) {
    int side = sssi_class(&za, 4);
    sssi_ends e;
    e.rim_a = rho * SSSI_SQRT((1.0f - za) * (1.0f + za));
    e.rim_b = rho * SSSI_SQRT((1.0f - zb) * (1.0f + zb));
    e.height_a = side == 3 ? -rho * za : rho * za;
    e.height_b = side == 2 ? rho * zb : -rho * zb;
    return e;
}
/* a, b or c for i up to 0, of 1, or from 2 on. */
SSSI_FN float sssi_choose(int i, float a, float b, float c) { return i > 1 ? c : i > 0 ? b : a; }
/* Tangent disks: from parts across and along the disk's own axis, z, to parts along tangent, bitangent and normal. */
SSSI_FN void sssi_turn_disks(int count, const sssi_places *at, sssi_lanes *v) {
    int l;
    for (l = 0; l < count; ++l) {
        int i = at->technique[l] * (at->technique[l] <= SSSI_BITANGENT);
        float x = v->x[l], y = v->y[l], z = v->z[l];
        v->x[l] = sssi_choose(i, x, z, y);
        v->y[l] = sssi_choose(i, y, x, z);
        v->z[l] = sssi_choose(i, z, y, x);
    }
}
/* A vector from its parts along tangent, bitangent and normal. */
SSSI_FN sss_vec3 sssi_in_frame(const sss_resampler *s, sss_vec3 v) {
    return sssi_add(sssi_add(sssi_mul(s->axis[SSSI_TANGENT], v.x), sssi_mul(s->axis[SSSI_BITANGENT], v.y)),
                    sssi_mul(s->axis[SSSI_NORMAL], v.z));
}

/* The lengths of the live channel that each of the next probes is for. */
typedef struct sssi_channels {
    float length[SSS_LANES], zv[SSS_LANES], sigma[SSS_LANES];
} sssi_channels;

SSSI_FN void sssi_draw_channels(const sss_resampler *s, int count, const float *u, sssi_channels *of) {
    float length[3], zv[3], sigma[3];
    int c, l, live = 0;
    for (c = 0; c < 3; ++c) { /* the live ones first */
        length[live] = length[c] = s->medium.length[c];
        zv[live] = zv[c] = s->medium.zv[c];
        sigma[live] = sigma[c] = s->medium.sigma[c];
        live += s->mix[c] > 0.0f;
    }
    for (l = 0; l < count; ++l) {
        float rest = u[l];
        int i = sssi_class(&rest, live);
        of->length[l] = sssi_choose(i, length[0], length[1], length[2]);
        of->zv[l] = sssi_choose(i, zv[0], zv[1], zv[2]);
        of->sigma[l] = sssi_choose(i, sigma[0], sigma[1], sigma[2]);
    }
}
/* The ends of the next probes about the entry: parts along tangent, bitangent and normal, in inner units. */
SSSI_FN void sssi_draw_segments(const sss_resampler *s, int dipole, int count, sssi_lanes *a, sssi_lanes *b) {
    sssi_places at;
    sssi_channels of;
    float u[SSS_LANES], part[SSS_LANES], r[SSS_LANES], turn[SSS_LANES], turn_b[SSS_LANES], side[SSS_LANES];
    float cosine[SSS_LANES], r_max = s->medium.r_max;
    int l, all = SSSI_WIDE && count > 1;
    sssi_find_places(s, count, &at);
    sssi_draw(s, count, &at, SSSI_CHANNEL, u);
    sssi_draw_channels(s, count, u, &of);
    sssi_draw(s, count, &at, SSSI_PART, part);
    sssi_draw(s, count, &at, SSSI_RADIUS, u);
    sssi_draw(s, count, &at, SSSI_TURN, turn);
    sssi_draw(s, count, &at, SSSI_SIDE, side);
    sssi_draw(s, count, &at, SSSI_COSINE, cosine);
    sssi_draw(s, count, &at, SSSI_TURN_B, turn_b);
    for (l = 0; l < count; ++l) {
        int t = at.technique[l];
        float drawn = 0.0f;
        if (all || t != SSSI_SPHERE)
            drawn = sssi_radius(dipole, all, of.length[l], of.zv[l], of.sigma[l], t == SSSI_CHORD, part[l], u[l]);
        r[l] = t == SSSI_SPHERE ? 0.0f : drawn;
    }
    for (l = 0; l < count; ++l) {
        int t = at.technique[l];
        sssi_ends disk = sssi_disk_ends(r[l], r_max), sphere = sssi_sphere_ends(of.length[l], r_max, cosine[l]);
        sssi_ends chord = sssi_chord_ends(r[l], side[l], cosine[l]);
        float rim_a = sssi_choose(t - 2, disk.rim_a, sphere.rim_a, chord.rim_a), sa, ca;
        float rim_b = sssi_choose(t - 2, disk.rim_b, sphere.rim_b, chord.rim_b), sb, cb;
        float height_a = sssi_choose(t - 2, disk.height_a, sphere.height_a, chord.height_a);
        float height_b = sssi_choose(t - 2, disk.height_b, sphere.height_b, chord.height_b);
        sssi_sincos_turn(turn[l], &sa, &ca);
        sssi_sincos_turn(turn_b[l], &sb, &cb);
        sb = t == SSSI_CHORD ? sb : sa;
        cb = t == SSSI_CHORD ? cb : ca;
        sssi_set_lane(a, l, sssi_vec3(rim_a * ca, rim_a * sa, height_a));
        sssi_set_lane(b, l, sssi_vec3(rim_b * cb, rim_b * sb, height_b));
    }
    if (!(s->share[SSSI_TANGENT] > 0.0f)) return;
    sssi_turn_disks(count, &at, a);
    sssi_turn_disks(count, &at, b);
}
SSSI_FN void sssi_make_probes_of(sss_resampler *s, int dipole, int count) {
    sssi_lanes *a = &s->origin, *b = &s->direction;
    int l;
    sssi_draw_segments(s, dipole, count, a, b);
    for (l = 0; l < count; ++l) {
        sss_vec3 from = sssi_in_frame(s, sssi_lane(a, l)), way = sssi_sub(sssi_in_frame(s, sssi_lane(b, l)), from);
        float reach = SSSI_SQRT(sssi_dot(way, way));
        sssi_set_lane(a, l, sssi_add(s->position, sssi_mul(from, s->unit)));
        sssi_set_lane(b, l, sssi_mul(way, 1.0f / reach));
        s->length[l] = reach * s->unit;
    }
}
/* Makes the next probes, as many as there are lanes or are left. */
SSSI_APART void sssi_make_probes(sss_resampler *s) {
    int left = s->candidates - s->next;
    if (s->medium.dipole) SSSI_CALL(sssi_make_probes_of, s, 1, left);
    else SSSI_CALL(sssi_make_probes_of, s, 0, left);
}
static inline int sss_next_probe(sss_resampler *s, sss_probe *probe) {
    while (s->next < s->candidates) {
        int l = (int)((uint32_t)s->next % SSS_LANES);
        if (l == 0) sssi_make_probes(s);
        ++s->next;
        if (++s->exit >= s->exits) s->exit = 0;
        if (!(s->length[l] > 0.0f)) continue;
        probe->origin = sssi_lane(&s->origin, l);
        probe->direction = sssi_lane(&s->direction, l);
        probe->length = s->length[l];
        return 1;
    }
    return 0;
}

/* ---- Weights ---- */
SSSI_FN float sssi_mean_proposal(const sss_resampler *s, int dipole, float r2) {
    const sss_medium *m = &s->medium;
    return s->mix[0] * sssi_proposal(m, dipole, 0, r2) + s->mix[1] * sssi_proposal(m, dipole, 1, r2) +
           s->mix[2] * sssi_proposal(m, dipole, 2, r2);
}
/* The intensities below are of one technique, at x about the entry where the surface has the unit normal n. */
SSSI_FN float sssi_depth_intensity(sss_vec3 x, sss_vec3 n, sss_vec3 axis, float h) {
    sss_vec3 v = sssi_add(x, sssi_mul(axis, h));
    float v2 = sssi_max(sssi_dot(v, v), SSSI_POLE_MIN), far = SSSI_SQRT(v2);
    float along = v2 > 1e-8f * h * h ? SSSI_FABS(sssi_dot(n, v)) : far;
    return along / (2.0f * SSSI_PI * v2 * far); /* at o itself infinite, however the surface runs through it */
}
SSSI_FN float sssi_sphere_intensity(const sss_resampler *s, sss_vec3 x, sss_vec3 n) {
    const float *h = s->medium.length;
    sss_vec3 axis = s->axis[SSSI_NORMAL];
    return s->mix[0] * sssi_depth_intensity(x, n, axis, h[0]) + s->mix[1] * sssi_depth_intensity(x, n, axis, h[1]) +
           s->mix[2] * sssi_depth_intensity(x, n, axis, h[2]);
}
/* r_a comes from the parts along the two other axes: r^2 less that along this one would lose it near the pole. */
SSSI_FN void sssi_add_disk(const sss_resampler *s, int dipole, int count, const sssi_lanes *x, const sssi_lanes *n,
                           int axis, int second, int third, float *mu) {
    int l;
    if (!(s->share[axis] > 0.0f)) return;
    for (l = 0; l < count; ++l) {
        float u = sssi_dot(sssi_lane(x, l), s->axis[second]), v = sssi_dot(sssi_lane(x, l), s->axis[third]);
        float along = SSSI_FABS(sssi_dot(sssi_lane(n, l), s->axis[axis]));
        mu[l] += s->share[axis] * along * sssi_mean_proposal(s, dipole, u * u + v * v);
    }
}
/* The unit profiles, their mean g, and the intensity that every weight uses: expected hits per area and probe; all in
   inner units. Burley's proposal is the profile itself. */
typedef struct sssi_densities {
    float profile[3][SSS_LANES], target[SSS_LANES], mu[SSS_LANES];
} sssi_densities;

SSSI_FN void sssi_find_densities(const sss_resampler *s, int dipole, int count, const sssi_lanes *x,
                                 const sssi_lanes *n, sssi_densities *d) {
    float ball = s->medium.r_max * s->medium.r_max, *mu = d->mu;
    int l;
    for (l = 0; l < count; ++l) mu[l] = 0.0f;
    sssi_add_disk(s, dipole, count, x, n, SSSI_NORMAL, SSSI_TANGENT, SSSI_BITANGENT, mu);
    sssi_add_disk(s, dipole, count, x, n, SSSI_TANGENT, SSSI_BITANGENT, SSSI_NORMAL, mu);
    sssi_add_disk(s, dipole, count, x, n, SSSI_BITANGENT, SSSI_NORMAL, SSSI_TANGENT, mu);
    if (s->share[SSSI_SPHERE] > 0.0f)
        for (l = 0; l < count; ++l)
            mu[l] += s->share[SSSI_SPHERE] * sssi_sphere_intensity(s, sssi_lane(x, l), sssi_lane(n, l));
    for (l = 0; l < count; ++l) {
        float r2 = sssi_dot(sssi_lane(x, l), sssi_lane(x, l)), g, p;
        float red = sssi_profile_unit(&s->medium, dipole, 0, r2), green = sssi_profile_unit(&s->medium, dipole, 1, r2);
        float blue = sssi_profile_unit(&s->medium, dipole, 2, r2);
        g = s->mix[0] * red + s->mix[1] * green + s->mix[2] * blue;
        p = dipole ? sssi_mean_proposal(s, 1, r2) : g;
        mu[l] = (r2 <= ball ? mu[l] : 0.0f) + 0.5f * s->share[SSSI_CHORD] * p;
        d->profile[0][l] = red;
        d->profile[1][l] = green;
        d->profile[2][l] = blue;
        d->target[l] = g;
    }
}
SSSI_FN sss_vec3 sssi_offset(const sss_resampler *s, sss_vec3 position) {
    return sssi_mul(sssi_sub(position, s->position), 1.0f / s->unit);
}
static inline float sss_intensity(const sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal) {
    sssi_lanes x, n;
    sssi_densities d;
    if (!s->candidates || !sssi_finite(position) || !sssi_normalize(&geometric_normal)) return 0.0f;
    sssi_set_lane(&x, 0, sssi_offset(s, position));
    sssi_set_lane(&n, 0, geometric_normal);
    if (s->medium.dipole) sssi_find_densities(s, 1, 1, &x, &n, &d);
    else sssi_find_densities(s, 0, 1, &x, &n, &d);
    return d.mu[0] / (s->unit * s->unit);
}

/* ---- Pick ---- */
SSSI_FN void sssi_weigh_of(sss_resampler *s, int dipole, int count) {
    sssi_lanes x, n;
    sssi_densities d;
    float plain[SSS_LANES], weight[SSS_LANES], light[SSS_LANES], pick[SSS_LANES];
    int c, e, l;
    for (l = 0; l < count; ++l) {
        sss_vec3 normal = sssi_lane(&s->hit_normal, l);
        sssi_normalize(&normal);
        sssi_set_lane(&n, l, normal);
        sssi_set_lane(&x, l, sssi_offset(s, sssi_lane(&s->hit_position, l)));
    }
    sssi_find_densities(s, dipole, count, &x, &n, &d);
    for (l = 0; l < count; ++l) {
        float w, p = d.target[l] / (d.mu[l] * (float)s->candidates);
        light[l] = sssi_min(sssi_max(s->hit_light[l], SSSI_HINT_MIN), SSSI_HINT_MAX);
        w = p * light[l];
        plain[l] = ((d.target[l] >= SSSI_TINY) & (w >= SSSI_TINY) & (p <= SSSI_HUGE)) ? p : 0.0f; /* 0 for NaN too */
        weight[l] = plain[l] > 0.0f ? w : 0.0f;
        pick[l] = sssi_unit(sss_hash(s->seed, 0x70000000u + (uint32_t)(s->hits + l)));
    }
    for (e = 0; e < s->exits; ++e) {
        sssi_reservoir *held = &s->reservoir[e];
        float sum = held->weight, sum_plain = held->plain;
        int chosen = -1;
        for (l = 0; l < s->waiting; ++l) {
            float w = s->hit_exit[l] == e ? weight[l] : 0.0f;
            sum += w;
            sum_plain += s->hit_exit[l] == e ? plain[l] : 0.0f;
            chosen = pick[l] * sum < w ? l : chosen;
        }
        held->weight = sum;
        held->plain = sum_plain;
        if (chosen < 0) continue;
        held->light = light[chosen];
        held->target = d.target[chosen];
        for (c = 0; c < 3; ++c) held->profile[c] = d.profile[c][chosen];
        held->position = sssi_lane(&s->hit_position, chosen);
        held->normal = sssi_lane(&n, chosen);
    }
    s->hits += s->waiting;
    s->waiting = 0;
}
/* Weighs the hits that wait, side by side; then each in its turn is held with the chance weight / sum so far. */
SSSI_APART void sssi_weigh(sss_resampler *s) {
    if (s->medium.dipole) SSSI_CALL(sssi_weigh_of, s, 1, s->waiting);
    else SSSI_CALL(sssi_weigh_of, s, 0, s->waiting);
}
static inline void sss_add_hit(sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal, float light) {
    int l = s->waiting;
    if (s->next == 0 || !(light > 0.0f && light <= SSSI_FLT_MAX)) return;
    if (!sssi_finite(position) || !sssi_finite(geometric_normal) || !(sssi_longest(geometric_normal) > 0.0f)) return;
    sssi_set_lane(&s->hit_position, l, position);
    sssi_set_lane(&s->hit_normal, l, geometric_normal);
    s->hit_light[l] = light;
    s->hit_exit[l] = s->exit;
    if (++s->waiting == SSS_LANES) sssi_weigh(s);
}

/* The entry itself, for the Lambert channels of a medium that has live ones too: it stands in the first reservoir with
   the weight lambert * W / H (H the weights without hints), which gives it the probability below. */
SSSI_FN int sssi_finish_lambert(const sss_resampler *s, float h, sss_exit *exit) {
    float chance = s->lambert_only ? 1.0f : s->lambert / (s->lambert + h);
    int c;
    if (!(sssi_unit(sss_hash(s->seed, 0x60000000u)) < chance)) return 0;
    exit->position = s->position;
    exit->normal = s->axis[SSSI_NORMAL];
    for (c = 0; c < 3; ++c) exit->weight[c] = s->mix[c] > 0.0f ? 0.0f : s->medium.albedo[c] / chance;
    return 1;
}
static inline int sss_finish(sss_resampler *s, sss_exit *exits) {
    int i, c, count = 0;
    if (s->waiting) sssi_weigh(s);
    for (i = 0; i < s->exits; ++i) {
        sssi_reservoir *held = &s->reservoir[i];
        float weight = held->weight;
        if (i == 0 && (s->lambert > 0.0f || s->lambert_only)) {
            if (sssi_finish_lambert(s, held->plain, &exits[count])) {
                ++count;
                continue;
            }
            weight += s->lambert * held->weight / held->plain;
        }
        if (!(weight > 0.0f)) continue;
        exits[count].position = held->position;
        exits[count].normal = held->normal;
        for (c = 0; c < 3; ++c)
            exits[count].weight[c] =
                s->mix[c] > 0.0f ? s->medium.albedo[c] * (held->profile[c] / held->target) * (weight / held->light)
                                 : 0.0f;
        ++count;
    }
    return count;
}

#endif /* SSS_RESAMPLE_H */
