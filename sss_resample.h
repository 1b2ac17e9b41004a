/* sss_resample.h - v0.2.0 - exit points of subsurface scattering by importance resampling
   C99, C++11 and OpenCL C 1.2. SPDX-License-Identifier: MIT. No warranty; LICENSE has the full
   text.

   Give it a point where a camera path meets a translucent surface. It tells you where on the
   surface to gather the light that leaves there, and with which weight.

       sss_medium wax;  sss_resampler s;  sss_probe probe;  sss_exit exit;

       sss_burley(&wax, albedo, dmfp);                            // once for each material
       sss_begin(&s, &wax, NULL, x, n, sss_hash(pixel, sample));  // once for each path that hits it
       while (sss_next_probe(&s, &probe))
           for (each hit of this object on the segment, nearest first)
               sss_add_hit(&s, hit.position, hit.normal, 1.0f);
       if (sss_finish(&s, &exit))
           radiance += exit.weight * shade_as_white_lambert(exit.position, exit.normal);

   WHAT IT DOES
   It implements "Importance Resampling for BSSRDF" (Villemin, Hery, Christensen, Pixar Technical
   Memo 16-05, 2016). Probe rays find candidates for the exit. Each candidate is weighed by the
   diffusion profile over the density that found it. One candidate (or a few) is picked in
   proportion to that weight, and only what is picked is shaded. Beyond the memo: weights that are
   bounded on any geometry, stratified candidates, light hints, exits that serve a whole tile of
   pixels (sss_share), and a random walk through the volume behind the same loop (SSS_WALK).

   WHAT IT DOES NOT
   It traces no rays and knows no Fresnel factors (they are the caller's). Its profiles hold no
   single scattering (a walk does), and it has no anisotropic phase function. It allocates nothing,
   has no globals, does no input or output, and needs nothing of libm but sqrtf and fabsf.

   WORDS
   The camera path enters the object at the *entry* and leaves it at the *exit*. Light goes the
   other way: in at the exit, out at the entry. A profile depends on the distance alone, so it does
   not matter which is which. A *probe* is a ray segment that looks for the surface, a *hit* is
   where it meets the surface, a *candidate* is a hit with its weight, a *technique* is a way to
   place probes.

   OPTIONS, to be defined before the include, the same in every file of a program:
       SSS_MAX_EXITS       4     the largest sss_plan.exits; at least 3 for sss_plan.per_channel
       SSS_MAX_CANDIDATES  256   the largest sss_plan.candidates; costs nothing
       SSS_LANES           8     how many probes, hits or entries are worked on side by side. It
                                 changes no bit. 1 suits a GPU. Compilers vectorise with
                                 -fno-math-errno

   CONVENTIONS
   Units. Lengths are in scene units, coefficients in their inverse. A normal is geometric, of any
   length; its sign does not matter, but for SSS_WALK it points outwards.

   The contract. For any irradiance E, the expected value over seeds of
       sum over exits of weight[c] * E(exit)
   equals
       the surface integral of Rd_c(|y - x|) E(y) dA(y).
   It holds for every plan with SSS_CHORD and for all numbers of candidates and exits. A plan
   without SSS_CHORD lacks the tail beyond the radius that holds all but 1e-4 of the widest
   channel's albedo. SSS_DISK alone also misses faces at right angles to the entry's. SSS_SPHERE
   alone also has infinite variance for Burley's profile. Use either alone on smooth surfaces or for
   teaching only.
   With SSS_WALK the integral is over the paths through the volume instead.

   Densities are *intensities*: expected hits per unit of surface area. They integrate to the
   expected number of hits, not to 1. So all hits count (front, back, several on one probe), and a
   sum is divided by the number of probes, never by the number of hits.

   Hits. Report each crossing of this object's surface once, also at shared edges: one that is
   reported twice counts twice, one that is missed loses its light. Trace a probe from its very
   origin (tmin = 0) to its very end, and do not start again where there is no hit. Step from hit to
   hit by primitive, not by an absolute epsilon. An intersector with an epsilon of its own gets a
   ray that starts that much earlier; one that culls back faces traces each probe from both ends.
   Light arrives on the outer side of an exit, wherever the probe came from. Report geometric
   normals. Shading normals make the mean wrong (7 % too bright in examples/furnace.c, 13 % too dark
   in demos/study/failures.c): use them in E. A lookup has one medium, that of its entry.

   Bound. Without hints one hit adds to exit.weight[c] at most
       albedo[c] * live channels * 2 / (share of the chord) * b / candidates.
   b = 1 for Burley; for the dipoles it is the largest ratio of profile and proposal: measured 3.3
   for eta up to 2, 8.3 up to 5. Beside Lambert channels the first exit also stands for the entry,
   and carries up to albedo[c] more for each of them. A weight may exceed 1: clamp the chance of
   Russian roulette.

   Precision. A hit is as good as its float coordinates. The mean is right to .1 % while coordinates
   are below 1e4 times the shortest dmfp, to 1 % below 1e5; at 1e6 it is off by 4 to 20 %. A
   renderer with larger coordinates begins the lookup at the origin and adds the entry to each probe
   in its own precision. Channels far narrower than the widest one scatter like Lambert (see
   sss_medium).

   Randomness. One 32-bit seed names a lookup. The same seed and the same hits give the same exits.
   Use a seed once: where paths enter several times, hash in the bounce. sss_begin_sample makes the
   samples of a pixel strata of one another. In tests/test_samples.c 64 of them have 0.3 to 0.75 of
   the variance of 64 seeds. Where the light itself is noisy it gains less.

   Bits. The CPU and an OpenCL device compute the same bits (a NaN is only a NaN) under three
   conditions: -ffp-contract=off on the host, no -ffast-math where the program is linked, and a
   device that keeps denormals, with -cl-fp32-correctly-rounded-divide-sqrt. Scaling the scene by a
   power of two changes no pick and no bit of a weight. Nothing that a caller passes makes a NaN
   come out: bad media, plans and points are refused by name, bad hits are ignored. Everything is
   reentrant.

   THEORY (numbers in brackets are cited below)
   [1] A probe is a random segment. If the expected number of times that probe j crosses a surface
       element dA is mu_j dA, and Lambda = sum over the M probes of mu_j, then the sum over all hits
       of f / Lambda has the expected value integral f dA: Campbell's theorem, and the balance
       heuristic over all techniques at once (Veach and Guibas 1995).
   [2] Resampling (Talbot et al. 2005): with w = g / Lambda for each hit and W their sum, pick one
       hit with probability w / W; then f / g * W has the same expected value. Its variance is that
       of M probes divided by M plus, as a floor, that of one exit drawn exactly from g. Here g is
       the mean of the live channels' unit profiles Rd / A, times the light hint: the nearer g is to
       Rd E, the lower the floor.
   [3] Disk (King et al. 2013): a line along axis a through a point of the disk about the entry,
       with planar density P(r_a). mu = P(r_a) |n.a|, r_a the distance from the axis; cut by the
       ball r <= r_max, 0 outside.
   [4] Sphere: a whole line in a uniform direction through o, a depth h below the entry.
       mu = |n.w| / (2 pi |y - o|^2), w the direction from o to y; cut by the same ball.
   [5] Chord: the segment between two uniform points of the sphere of random radius rho about the
       entry. With the density -pi rho^2 P'(rho) of rho, mu = P(r) / 2 whatever the hit's normal:
       the bound above.
   [6] Burley's profile (Christensen and Burley 2015): Rd = A (e^(-r/d) + e^(-r/3d)) / (8 pi d r).
   [7] Dipoles (Jensen et al. 2001; d'Eon 2012). With s = sigma_tr, k = 4 pi Rd / A,
       z in {z_r, z_v}, d_z = sqrt(r^2 + z^2):
       k = flux * sum of z (1 + s d_z) e^(-s d_z) / d_z^3
         + fluence * (e^(-s d_r) / d_r - e^(-s d_v) / d_v).
   [8] Sharing (balance heuristic over targets: Bekaert et al. 2002; Lin et al. 2022): an exit y of
       any of the lookups j = 1..n, weighed with Rd_i(y) / (sum over j of g_j(y)) * mass, has the
       surface integral of Rd_i E as its expected value, summed over the exits of all n lookups.
   [9] Walk: a path of n scatterings and length L through a homogeneous volume with extinction s_c
       has in channel c the density s_c^n e^(-s_c L) times what does not depend on c. The balance
       heuristic over the channel that draws the distances weighs it with albedo_c^n times its
       density over their mean. */
#ifndef SSS_RESAMPLE_H
#define SSS_RESAMPLE_H

#define SSS_VERSION 200 /* 0.2.0: 10000 * major + 100 * minor + patch */

/* ---- Language: all that differs between C, C++ and OpenCL C, and what a user may set ---- */

#if defined(__FAST_MATH__) || defined(__FAST_RELAXED_MATH__) || defined(__ASSOCIATIVE_MATH__) ||   \
    defined(__RECIPROCAL_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "sss_resample.h needs IEEE arithmetic: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__
#error "sss_resample.h needs float arithmetic: -msse2 -mfpmath=sse or -fexcess-precision=fast"
#endif

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define SSSI_OPENCL 1
#else
#define SSSI_OPENCL 0
#endif

/* clang defines no macro for most parts of -ffast-math: it is told here, until the end of the
   file. */
#if defined(__clang__) && !defined(__wasm__) && !SSSI_OPENCL
#pragma float_control(push)
#pragma float_control(precise, on)
#pragma clang fp contract(off) reassociate(off)
#define SSSI_END_OF_MATHS _Pragma("float_control(pop)")
#else
#define SSSI_END_OF_MATHS
#endif

#if SSSI_OPENCL
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
#if defined(__GNUC__) && defined(__STDC_HOSTED__) && !__STDC_HOSTED__ /* there may be no libc */
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

/* Loops over the lanes vectorise only if all that they call is inlined. */
#if defined(__GNUC__) || SSSI_OPENCL
#define SSSI_FN static inline __attribute__((always_inline))
#else
#define SSSI_FN static inline
#endif

/* A function that holds such loops stays apart, so that they vectorise whatever its caller is
   like. */
#if defined(__OPTIMIZE__) || SSSI_OPENCL
#define SSSI_APART static __attribute__((noinline, unused))
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
#if SSS_MAX_EXITS < 1 || SSS_LANES < 1 || SSS_MAX_CANDIDATES < 8 || SSS_MAX_CANDIDATES > 65534
#error "sss_resample.h: SSS_MAX_EXITS >= 1, SSS_LANES >= 1 and SSS_MAX_CANDIDATES within 8..65534"
#endif

/* How many lanes to work on for n waiting probes or hits. A loop over the lanes vectorises if their
   number is a constant and sqrt is an instruction. Then all lanes are worked on, also those that
   nobody reads. */
#if defined(__NO_MATH_ERRNO__) || SSSI_OPENCL
#define SSSI_WIDE     1
#define SSSI_COUNT(n) ((n) > 1 ? SSS_LANES : 1)
#else
#define SSSI_WIDE     0
#define SSSI_COUNT(n) ((n) < SSS_LANES ? (n) : SSS_LANES)
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

/* A material: three colour channels, all in plain floats. Made by the constructors below; read
   its fields, but write none. A channel is *live* (albedo > 0, length > 0), *Lambert* (albedo >
   0, length 0: the light leaves where it came in) or *black* (albedo 0). A channel whose length
   is below 2^-20 of the widest channel's r_max becomes Lambert: float coordinates cannot resolve
   it beside the other. All but 1e-3 of its light would leave within 1e-3 of r_max. */
typedef struct sss_medium {
    int dipole;          /* 0: Burley's profile [6]; 1: a dipole [7] */
    float albedo[3];     /* A: the integral of Rd over the plane, 0..1 */
    float length[3];     /* Burley's d or the dipole's z_r; 0: the channel is not live */
    float zv[3];         /* depth of the dipole's virtual source */
    float sigma[3];      /* sigma_tr, 1/length */
    float flux[3];       /* that of [7] over 4 pi, without unit */
    float fluence[3];    /* that of [7] over 4 pi, 1/length; 0 for the standard dipole */
    float r_max;         /* holds all but 1e-4 of the widest live channel's albedo */
    float extinction[3]; /* of the volume [9], 1/length; 0: it is Lambert for the walk too */
    float similarity[3]; /* of the volume: s = sqrt(1 - albedo of one scattering), 0..1 */
} sss_medium;

/* Techniques, as bits of sss_plan.techniques. The last two stand alone. */
enum {
    SSS_DISK = 1,          /* [3] along the normal */
    SSS_DISK_TANGENTS = 2, /* [3] along two tangents */
    SSS_SPHERE = 4,        /* [4] */
    SSS_CHORD = 8,         /* [5] */
    SSS_WALK = 16,         /* [9]: candidates are random walks through the volume */
    SSS_LAMBERT = 32       /* no probes: one exit at the entry, with weight A */
};

/* How many probes by which techniques. All zero means: 8 candidates, 1 exit, the default mix. */
typedef struct sss_plan {
    int candidates;      /* M: probes or walks, 1..SSS_MAX_CANDIDATES; 0: 8 */
    int exits;           /* N: 1..SSS_MAX_EXITS; 0: 1. Probe j feeds exit j mod N */
    unsigned techniques; /* bits above, which share the probes equally; 0: the default mix */
    int independent;     /* not 0: the memo's plain algorithm, without strata */
    int per_channel;     /* not 0: each live channel picks its own exit, see sss_finish */
    int tile;            /* advice: side of the square of pixels to share exits; 0, 1: none */
} sss_plan;

/* What a scene asks for; lengths in scene units, 0 where not known. */
typedef struct sss_need {
    float footprint;        /* width of a pixel on the surface */
    float curvature_radius; /* or half the thickness if that is less, see sss_plan_for */
    float shading_cost;     /* of one exit and all behind it, over all hits of one probe */
    float tolerance;        /* relative error of the model that is good enough; 0: 0.1 */
    int hinted;             /* not 0: light hints will be given */
} sss_need;

typedef struct sss_probe {
    sss_vec3 origin, direction; /* direction is of unit length */
    float length;               /* the segment ends at origin + length * direction */
} sss_probe;

typedef struct sss_exit {
    sss_vec3 position, normal; /* as given to sss_add_hit, the normal at unit length */
    float weight[3];           /* times white Lambert's radiance there: the contract above; >= 0 */
    int hit;                   /* which call of sss_add_hit it was, from 0; -1: the entry itself */
    float mass;                /* for sss_share; 0: the exit serves its own lookup alone */
} sss_exit;

/* An entry as sss_share sees it. */
typedef struct sss_entry {
    sss_vec3 position;
    const sss_medium *medium;
} sss_entry;

/* A medium as a lookup uses it, in inner units. Channels that are not live hold the values of one
   that is, so that no loop over channels needs a branch. */
typedef struct sssi_optics {
    sss_medium medium;
    float unit;        /* scene units in an inner unit: 2^e <= the longest live length */
    float mix[3];      /* 1 / n for the n live channels, 0 for the others */
    int live, lambert; /* how many channels are live, and how many are Lambert */
} sssi_optics;

/* A hit with all that its weight needs; lengths in inner units. */
typedef struct sssi_candidate {
    sss_vec3 position, normal; /* in scene units; at unit length */
    float profile[3];          /* unit profiles, or what a walk carries */
    float target;              /* g: their mean over the live channels */
    float light;               /* the hint */
    int hit;                   /* which call of sss_add_hit it was */
} sssi_candidate;

typedef struct sssi_reservoir {
    float weight; /* sum of w over the hits so far [2] */
    float plain;  /* the same without hints; kept for the first reservoir alone */
    sssi_candidate held;
} sssi_reservoir;

/* Vectors side by side. */
typedef struct sssi_lanes {
    float x[SSS_LANES], y[SSS_LANES], z[SSS_LANES];
} sssi_lanes;

enum { SSSI_NORMAL, SSSI_TANGENT, SSSI_BITANGENT, SSSI_SPHERE, SSSI_CHORD, SSSI_TECHNIQUES };

/* Probes that were made together. */
typedef struct sssi_probes {
    sssi_lanes origin, direction; /* in scene units */
    float length[SSS_LANES];      /* not above 0: that probe has no segment */
    float depth[SSS_LANES];       /* of the point that a sphere's line runs through; else 0 */
} sssi_probes;

/* Hits that wait to be weighed together. */
typedef struct sssi_hits {
    int count;
    sssi_lanes position, normal;
    float light[SSS_LANES];
    float depth[SSS_LANES];   /* of the probe that found it */
    int reservoir[SSS_LANES]; /* that it feeds */
    int number[SSS_LANES];    /* of the call of sss_add_hit */
} sssi_hits;

/* The random walk under way; lengths in inner units. */
typedef struct sssi_walk {
    int on, found;           /* a segment has been given; a hit of it is held */
    int goes_on;             /* that hit is the start of the walk, seen from outside */
    uint32_t key;            /* of its random numbers */
    sss_vec3 position;       /* where the segment starts, about the entry */
    sss_vec3 direction;      /* at unit length */
    float length;            /* of the segment */
    float skip;              /* where on the segment its trace begins */
    float skin;              /* that length for the first segment */
    float extinction;        /* of the channel that draws the distances */
    int scatterings;         /* n of [9] */
    float path;              /* L of [9], up to where the segment starts */
    float roulette;          /* ln of the product of 1 / chances to live on */
    float distance;          /* of the hit that is held, in scene units */
    sssi_candidate hit;      /* that hit */
    float log_extinction[3]; /* over that of channel 0 */
    float log_albedo[3];     /* of one scattering */
    float brightest;         /* the highest of these, of the live channels */
} sssi_walk;

/* One lookup: plain values, lives on the stack, its fields are private. */
typedef struct sss_resampler {
    sssi_optics optics;
    sss_vec3 position;              /* in scene units */
    sss_vec3 axis[3];               /* normal, tangent, bitangent: orthonormal */
    float share[SSSI_TECHNIQUES];   /* q of each technique: its expected part of the probes */
    int first[SSSI_TECHNIQUES + 1]; /* technique t has the probes first[t] .. first[t + 1] - 1 */
    int candidates, exits, independent, per_channel, walks;
    float reach;     /* of disk and sphere probes: a little less than `ball`, in inner units */
    float ball;      /* beyond it their intensity is 0; a little less than r_max */
    float blur;      /* how far a line may pass from where it should */
    uint32_t seed;   /* of the lattices of numbers, with `sample` */
    uint32_t sample; /* by which they are shifted */
    uint32_t key;    /* of all other random numbers */
    int next, calls; /* probes given; calls of sss_add_hit */
    int weighed;     /* hits weighed so far */
    sssi_probes probes;
    sssi_hits hits;
    sssi_walk walk;
    sssi_reservoir reservoir[SSS_MAX_EXITS];
} sss_resampler;

/* ---- Functions ---- */

/* The name of a result, one line without a full stop. */
static inline SSSI_TEXT sss_result_string(sss_result result);

/* Media. Albedos in [0, 1]; lengths and coefficients 0 or in [1e-12, 1e12]; eta = n_inside /
   n_outside in [0.2, 5]. Otherwise SSS_BAD_ALBEDO, SSS_BAD_LENGTH or SSS_BAD_ETA, and *m is black:
   safe to use, no light. A channel of length 0 is Lambert with its albedo. Each also gives the
   volume that SSS_WALK goes through: isotropic scattering, matched indices, the albedo of its half
   space is A. A channel with albedo 1 and a dmfp has no such volume, and the walk takes it for
   Lambert: use sss_burley_mfp there. */

/* Christensen and Burley 2015, dmfp = diffuse mean free path, searchlight, eq. 8. Volume: 1 / dmfp
   is the decay of light deep inside, by Grosjean's diffusion. */
static inline sss_result sss_burley(sss_medium *m, const float albedo[3], const float dmfp[3]);

/* The same from the volume's mean free path 1 / extinction, diffuse transmission, eq. 6. */
static inline sss_result sss_burley_mfp(sss_medium *m, const float albedo[3], const float mfp[3]);

/* Jensen et al. 2001, with exact Fresnel moments. A channel with sigma_s' = 0 is black. */
static inline sss_result sss_dipole(sss_medium *m, const float sigma_a[3],
                                    const float sigma_s_prime[3], float eta);

/* d'Eon 2012, "A better dipole": Grosjean's diffusion, multiple scattering only. */
static inline sss_result sss_better_dipole(sss_medium *m, const float sigma_a[3],
                                           const float sigma_s_prime[3], float eta);

/* The dipoles with the total reflectance `albedo` (to 1e-5) and sigma_tr = 1 / dmfp. At albedo 1
   that is Lambert. */
static inline sss_result sss_dipole_from_albedo(sss_medium *m, const float albedo[3],
                                                const float dmfp[3], float eta);
static inline sss_result sss_better_dipole_from_albedo(sss_medium *m, const float albedo[3],
                                                       const float dmfp[3], float eta);

/* Rd(r) of a channel in 0..2, 1/length^2, r >= 0 in scene units; below 1e-6 of the channel's length
   as at that radius, and beyond 70 e-foldings without further decay. 0 for black and Lambert
   channels, and for a channel or radius that does not exist. Worst relative error: 4.0e-7 for
   Burley, 1.2e-6 for the standard dipole, 1.4e-6 for the better one, and 2.1e-7 more for each
   e-folding. */
static inline float sss_profile(const sss_medium *m, int channel, float r);

/* The integral of Rd over the disk of radius r: 0..albedo; 0 for a channel or radius that does not
   exist. */
static inline float sss_within(const sss_medium *m, int channel, float r);

/* The cheapest plan whose model is good enough for a need. In this order:
     SSS_WALK      where the flat profile would be off by more than the tolerance, all channels
                   weighed by their albedo;
     SSS_LAMBERT   where the light leaves within a pixel (footprint * tolerance > 0.05 r_max);
     SSS_DISK      with one candidate, where r_max is at most the curvature_radius;
     the default mix elsewhere, with the candidates, colours and tile that pay.
   A disk may get a tile, too. Without a shading_cost there are 8 candidates, hinted or not; without
   a footprint there is no tile.
   curvature_radius is that of the largest ball that touches the surface at the entry, from inside
   or from outside, and holds no other surface: half the thickness of a leaf, the distance from an
   edge.
   Every point y of the surface bounds it from above, by |v|^2 / (2 |n.v|) with v = y - entry: take
   the least of that over the hits of earlier lookups nearby. On a mesh take it at each vertex, with
   the smooth normal there, over the other vertices; the normal of a facet makes it too small. 0,
   not known, gives the walk, which is right on every shape. One radius for a whole object gives all
   of it one model. */
static inline sss_plan sss_plan_for(const sss_medium *m, const sss_need *need);

/* Starts a lookup. plan NULL: the default. SSS_BAD_PLAN (an unknown technique; SSS_WALK or
   SSS_LAMBERT beside another; a count below 0 or above its maximum; per_channel with exits above 1
   or SSS_MAX_EXITS below 3), SSS_BAD_POSITION (not finite, or beyond 1e30), SSS_BAD_NORMAL (zero,
   not finite): no probes, no exits. A black medium is SSS_OK and has no exits. */
static inline sss_result sss_begin(sss_resampler *s, const sss_medium *m, const sss_plan *plan,
                                   sss_vec3 position, sss_vec3 geometric_normal, uint32_t seed);

/* The same for sample 0, 1, 2, ... of one seed, say of a pixel: the lookups are strata of one
   another, which lowers the error of their sum. sss_begin is sample 0. */
static inline sss_result sss_begin_sample(sss_resampler *s, const sss_medium *m,
                                          const sss_plan *plan, sss_vec3 position,
                                          sss_vec3 geometric_normal, uint32_t seed,
                                          uint32_t sample);

/* 1 and a segment to trace while there is another probe, else 0. */
static inline int sss_next_probe(sss_resampler *s, sss_probe *probe);

/* A hit of the last probe, in order of distance (another order changes bits, not the expected
   value); of a walk's segment only the nearest counts. light: a guess, in any unit, of the
   light that arrives there, 1 when not known. 0 drops the hit, which is exact only where no
   light comes. Positive values act as clamped to [2^-30, 2^30] and change the variance, not the
   expected value. */
static inline void sss_add_hit(sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal,
                               float light);

/* Writes the exits and returns their number. An array of SSS_MAX_EXITS always suffices. The default
   plan needs one; a plan of sss_plan_for may need more. No exit is a fair sample of zero: do not
   try again. With per_channel, channels that picked the same hit share
   one exit. */
static inline int sss_finish(sss_resampler *s, sss_exit *exits);

/* Expected hits per unit area and probe at a point of the surface, 1/length^2; 0 for walks. */
static inline float sss_intensity(const sss_resampler *s, sss_vec3 position,
                                  sss_vec3 geometric_normal);

/* A well mixed 32-bit hash of two, to name lookups: sss_hash(pixel, sample). */
static inline uint32_t sss_hash(uint32_t a, uint32_t b);

/* One exit, many lookups [8]: the weight of an exit for every entry of a group of lookups, of which
   number `own` found it. Add weight[i][c] * E(exit) to the estimate of entry i, for every exit of
   every member. The expected value stays the contract's under two conditions. The group is chosen
   without a look at the random numbers (a tile of pixels, one object). Every member made its own
   lookup, also if that found no exit, with a plan that holds SSS_CHORD (SSS_DISK alone will do
   where all is flat). No ray is needed. weight[i][c] is at most albedo * live channels * mass.
   Neighbours then have correlated noise: shift the tiles from pass to pass. A channel of an entry
   whose length is below half of `spacing`, the distance of neighbours, gains nothing
   (demos/study/tile.c): there each entry keeps to its own exits. Exits with mass 0 serve their own
   entry alone. Fastest if all entries point to one medium. */
static inline void sss_share(const sss_exit *exit, const sss_entry *group, int count, int own,
                             float spacing, float (*weight)[3]);

/* The same one entry at a time, for kernels. First add up the density of all entries of the group,
   in order, then ask for each entry's weight. 1/length^2. This is the weight of a channel that is
   shared. Where exit->mass is 0, or sss_is_shared says 0 for an entry and a channel, that entry
   takes exit->weight[c] from its own exits and nothing from others. */
static inline float sss_share_density(const sss_medium *m, sss_vec3 entry, const sss_exit *exit);
static inline void sss_share_weight(const sss_medium *m, sss_vec3 entry, const sss_exit *exit,
                                    float density_sum, float weight[3]);

/* 1 if a channel takes part at this spacing, 0 if each entry keeps to its own exits: the rule
   above. */
static inline int sss_is_shared(const sss_medium *m, int channel, float spacing);

/* ---- Mathematics: the same bits on every device, hence not libm's. Worst errors over all
   arguments that are used here, against double precision: exp 1.1 ulp, expm1 1.8 ulp, log 1 ulp,
   sin and cos 1e-7. ---- */

#define SSSI_PI       3.14159265f
#define SSSI_FLT_MAX  3.402823466e38f
#define SSSI_NUDGE    5.9604644e-8f /* 2^-24 */
#define SSSI_LOWEST   (-70.0f) /* e^x below is as at -70: far away no ratio of profiles is 0/0 */
#define SSSI_R_MIN    1e-6f    /* of the length: profiles do not grow below */
#define SSSI_R_FAR    1e18f    /* squares do not overflow */
#define SSSI_FARTHEST 1e30f    /* the largest coordinate of an entry */
#define SSSI_TAIL     1e-4f    /* what r_max leaves out */
#define SSSI_NARROW   9.5367432e-7f /* 2^-20: shortest live length, over r_max */
#define SSSI_SHELL    7.6293945e-6f /* 2^-17: see sss_begin_sample */
#define SSSI_BLUR     2.3841858e-7f /* 2^-22: see sssi_depth_intensity */

/* A hit is left out if its target or weight is below these limits, or its weight above. Such hits
   are rarer or fainter than 1e-20. The sums over all others neither overflow nor underflow. */
#define SSSI_FAINT 1e-32f /* least target: what underflows in it is below 1e-5 of it */
#define SSSI_TINY  1e-36f /* least weight */
#define SSSI_HUGE  1e20f  /* largest weight */

#define SSSI_POLE_MIN 1e-25f         /* square of a distance: its power 3/2 is a normal float */
#define SSSI_HINT_MIN 9.3132257e-10f /* 2^-30 */
#define SSSI_HINT_MAX 1.0737418e9f

SSSI_FN float sssi_min(float a, float b) { return a < b ? a : b; }
SSSI_FN float sssi_max(float a, float b) { return a > b ? a : b; }

/* x = n ln 2 + f: returns 2^n and puts e^f - 1 in *p. x in [-87, 88]; adding 1.5 * 2^23 rounds. */
SSSI_FN float sssi_exp_parts(float x, float *p) {
    float n = (x * 1.44269504f + 12582912.0f) - 12582912.0f;
    float f = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float q = f * f;
    float high = (1.0f / 24 + f * (1.0f / 120)) + q * (1.0f / 720 + f * (1.0f / 5040));

    *p = f + q * (0.5f + (f * (1.0f / 6) + q * high));
    return sssi_float((uint32_t)(127 + (int)n) << 23);
}

/* e^x for x <= 80; below SSSI_LOWEST as at SSSI_LOWEST. */
SSSI_FN float sssi_exp(float x) {
    float p;
    float scale = sssi_exp_parts(sssi_max(x, SSSI_LOWEST), &p);

    return scale + scale * p;
}

/* e^x - 1 in the same range, accurate about 0 too. */
SSSI_FN float sssi_expm1(float x) {
    float p;
    float scale = sssi_exp_parts(sssi_max(x, SSSI_LOWEST), &p);

    return scale * p + (scale - 1.0f);
}

/* (1 - e^-t) / t, t >= 0: the mean of e^-x over 0..t. */
SSSI_FN float sssi_mean_exp(float t) { return t > 0.0f ? -sssi_expm1(-t) / t : 1.0f; }

/* ln(2^n (1 + f)) with 1 + f within [sqrt(1/2), sqrt(2)): ln(1 + f) = 2 artanh(f / (2 + f)). */
SSSI_FN float sssi_log_parts(float n, float f) {
    float s = f / (2.0f + f);
    float z = s * s;
    float series = z * ((2.0f / 3 + z * (2.0f / 5)) + z * z * (2.0f / 7 + z * (2.0f / 9)));

    return n * 0.693359375f + (f + (s * (series - f) - n * 2.12194440e-4f));
}

/* ln x for normal x > 0. */
SSSI_FN float sssi_log(float x) {
    uint32_t u = sssi_bits(x) - 0x3f3504f3u + 0x3f800000u;
    float n = (float)((int)(u >> 23) - 127);
    float m = sssi_float((u & 0x007fffffu) + 0x3f3504f3u);

    return sssi_log_parts(n, m - 1.0f);
}

/* sin and cos of 2 pi u, u in [0, 1]. */
SSSI_FN void sssi_sincos_turn(float u, float *s, float *c) {
    int quarter = (int)(4.0f * u + 0.5f);
    float x = (u - 0.25f * (float)quarter) * (2.0f * SSSI_PI);
    float z = x * x;
    float sn =
        x + x * z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880))));
    float cs = 1.0f + z * (-0.5f + z * (1.0f / 24 + z * (-1.0f / 720 + z * (1.0f / 40320))));
    float a = (quarter & 1) ? cs : sn;
    float b = (quarter & 1) ? sn : cs;

    *s = (quarter & 2) ? -a : a;
    *c = ((quarter + 1) & 2) ? -b : b;
}

SSSI_FN sss_vec3 sssi_vec3(float x, float y, float z) {
    sss_vec3 v = {x, y, z};
    return v;
}
SSSI_FN sss_vec3 sssi_add(sss_vec3 a, sss_vec3 b) {
    return sssi_vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}
SSSI_FN sss_vec3 sssi_sub(sss_vec3 a, sss_vec3 b) {
    return sssi_vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}
SSSI_FN sss_vec3 sssi_mul(sss_vec3 a, float k) { return sssi_vec3(a.x * k, a.y * k, a.z * k); }
SSSI_FN float sssi_dot(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SSSI_FN sss_vec3 sssi_lane(const sssi_lanes *v, int l) {
    return sssi_vec3(v->x[l], v->y[l], v->z[l]);
}
SSSI_FN void sssi_set_lane(sssi_lanes *v, int l, sss_vec3 a) {
    v->x[l] = a.x;
    v->y[l] = a.y;
    v->z[l] = a.z;
}

/* 0 if a component is infinite or NaN: then the sum is NaN. */
SSSI_FN int sssi_finite(sss_vec3 v) { return (0.0f * v.x + 0.0f * v.y) + 0.0f * v.z == 0.0f; }
SSSI_FN float sssi_longest(sss_vec3 v) {
    return sssi_max(SSSI_FABS(v.x), sssi_max(SSSI_FABS(v.y), SSSI_FABS(v.z)));
}

/* Scales a vector to unit length and returns 1. Returns 0, and leaves NaNs, if the vector is zero,
   infinite or has a NaN. */
SSSI_FN int sssi_normalize(sss_vec3 *v) {
    float m = sssi_longest(*v);

    *v = sssi_vec3(v->x / m, v->y / m, v->z / m);
    float length = SSSI_SQRT(sssi_dot(*v, *v));
    *v = sssi_vec3(v->x / length, v->y / length, v->z / length);
    return length > 0.0f;
}

/* Two tangents of a unit normal: Duff et al., "Building an orthonormal basis, revisited", JCGT
   2017. */
SSSI_FN void sssi_frame(sss_vec3 n, sss_vec3 *t, sss_vec3 *b) {
    float sign = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (sign + n.z);
    float c = n.x * n.y * a;

    *t = sssi_vec3(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    *b = sssi_vec3(c, sign + n.y * n.y * a, -n.y);
}

/* ---- Random numbers ---- */

/* A bijection in which each bit of the input flips each bit of the output half of the time. */
SSSI_FN uint32_t sssi_mix(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}
static inline uint32_t sss_hash(uint32_t a, uint32_t b) {
    return sssi_mix(sssi_mix(a + 0x9e3779b9u) ^ (b * 0x85ebca6bu));
}

/* A number in (0, 1). */
SSSI_FN float sssi_unit(uint32_t bits) { return ((float)(bits >> 9) + 0.5f) * 1.1920929e-7f; }

/* The same with 64 bits, of which most matter near 0. */
SSSI_FN float sssi_unit_fine(uint32_t high, uint32_t low) {
    return ((float)high + ((float)low + 0.5f) * 2.3283064e-10f) * 2.3283064e-10f;
}

SSSI_FN float sssi_open(float u) { return sssi_min(sssi_max(u, SSSI_NUDGE), 1.0f - SSSI_NUDGE); }

/* One of n classes by *u, which becomes a uniform number again. */
SSSI_FN int sssi_class(float *u, int n) {
    float x = *u * (float)n;
    int i = (int)x < n ? (int)x : n - 1;

    *u = sssi_open(x - (float)i);
    return i;
}

/* ---- Burley's profile [6]: all that is particular to it. Its proposal, the unit density over the
   plane from which radii are drawn, is the profile itself. ---- */

/* dmfp / d: equation 8 of [6]. */
SSSI_FN float sssi_burley_scale(float albedo) {
    float b = albedo - 0.33f;

    return 3.5f + 100.0f * (b * b) * (b * b);
}

/* mfp / d: equation 6 of [6]. */
SSSI_FN float sssi_burley_mfp_scale(float albedo) {
    float b = albedo - 0.8f;

    return 1.9f - albedo + 3.5f * b * b;
}

#define SSSI_BURLEY_R_MAX 26.767973f /* over d: the tail there is 1e-4 */

/* Unit profile Rd / A at distance sqrt(r2). */
SSSI_FN float sssi_burley_unit(float d, float r2) {
    float decay = 1.0f / (3.0f * d);
    float r = sssi_max(SSSI_SQRT(r2), SSSI_R_MIN * d);
    float e = sssi_exp(-decay * r);

    return (e + e * e * e) * (0.375f / SSSI_PI * decay) / r;
}

/* The integral of the unit profile beyond r, and within r: each accurate where it is the smaller
   one. */
SSSI_FN float sssi_burley_tail(float d, float r) {
    float e = sssi_exp(-r / (3.0f * d));

    return 0.25f * e * (3.0f + e * e);
}
SSSI_FN float sssi_burley_head(float d, float r) {
    float e = sssi_expm1(-r / (3.0f * d));

    return -0.25f * e * (6.0f + e * (3.0f + e));
}

/* A distance with density 2 pi r P(r) from a uniform u: u is the tail x (x^2 + 3) / 4, x =
   e^(-r/3d). Two Newton steps from x = u (4 - u) / 3 solve for x. */
SSSI_FN float sssi_burley_step(float x, float u) {
    return x - (x * (x * x + 3.0f) - 4.0f * u) / (3.0f * (x * x + 1.0f));
}
SSSI_FN float sssi_burley_radius(float d, float u) {
    float x = u * (4.0f / 3 - u * (1.0f / 3));

    x = sssi_burley_step(sssi_burley_step(x, u), u);
    return -3.0f * d * sssi_log(sssi_min(x, 1.0f));
}

/* The radius of a chord's sphere, with density -pi rho^2 P'(rho). Its tail is 3/4 T(rho/3d) + 1/4
   T(rho/d), and T(t) = e^-t (1 + t/2) is that of an exponential number with probability 1/2, else
   that of the sum of two. `part` picks one of eight equal classes: six have the scale 3d, and odd
   ones are sums of two. */
SSSI_FN float sssi_burley_chord(float d, float part, float u) {
    int i = sssi_class(&part, 8);
    float scale = i < 6 ? 3.0f * d : d;
    float product = (i & 1) ? u * part : u;

    return -scale * sssi_log(product);
}

/* ---- The dipoles [7]: all that is particular to them ---- */

/* d_v - d_r, without the cancellation of a difference. */
SSSI_FN float sssi_dipole_gap(float zr, float zv, float dr, float dv) {
    return (zv - zr) * (zv + zr) / (dr + dv);
}

/* Unit profile of channel c at distance sqrt(r2). */
SSSI_FN float sssi_dipole_unit(const sss_medium *m, int c, float r2) {
    float zr = m->length[c], zv = m->zv[c], s = m->sigma[c];
    float dr = SSSI_SQRT(r2 + zr * zr);
    float dv = SSSI_SQRT(r2 + zv * zv);
    float gap = sssi_dipole_gap(zr, zv, dr, dv);

    /* e^(-s d_v) = e^(-s d_r) (1 + fall). */
    float er = sssi_exp(-s * dr);
    float fall = sssi_expm1(-s * gap);
    float ev = er * (1.0f + fall);

    float real = zr / dr * (1.0f + s * dr) * er / (dr * dr);
    float virtual_source = zv / dv * (1.0f + s * dv) * ev / (dv * dv);
    float wave = er * (gap - dr * fall) / (dr * dv);

    return m->flux[c] * (real + virtual_source) + m->fluence[c] * wave;
}

/* The integral of the unit profile beyond r, and within r: each accurate where it is the smaller
   one. */
SSSI_FN float sssi_dipole_tail(const sss_medium *m, int c, float r) {
    float zr = m->length[c], zv = m->zv[c], s = m->sigma[c];
    float dr = SSSI_SQRT(r * r + zr * zr);
    float dv = SSSI_SQRT(r * r + zv * zv);
    float gap = sssi_dipole_gap(zr, zv, dr, dv);
    float er = sssi_exp(-s * dr);
    float poles = zr / dr * er + zv / dv * sssi_exp(-s * dv);
    float wave = er * gap * sssi_mean_exp(s * gap);

    return 2.0f * SSSI_PI * (m->flux[c] * poles + m->fluence[c] * wave);
}
SSSI_FN float sssi_dipole_head(const sss_medium *m, int c, float r) {
    float s = m->sigma[c];
    float poles[2], waves[2];

    /* With l = d_z - z, what is within comes from e^(-s z) (1 - e^(-s l) z / d_z). */
    for (int i = 0; i < 2; ++i) {
        float z = i ? m->zv[c] : m->length[c];
        float dz = SSSI_SQRT(r * r + z * z);
        float l = r * (r / (dz + z));

        poles[i] = sssi_exp(-s * z) * (sssi_exp(-s * l) * (l / dz) - sssi_expm1(-s * l));
        waves[i] = sssi_exp(-s * z) * l * sssi_mean_exp(s * l);
    }
    return 2.0f * SSSI_PI *
           (m->flux[c] * (poles[0] + poles[1]) + m->fluence[c] * (waves[0] - waves[1]));
}

/* The proposal: the two poles p(z; r) = z / (2 pi (r^2 + z^2)^1.5) with 1/4 each, and Burley's
   profile at d = 1 / (3 sigma_tr) with 1/2, which is left out at sigma_tr = 0. */
SSSI_FN float sssi_pole(float z, float r2) {
    float dz2 = r2 + z * z;

    return z / (2.0f * SSSI_PI * dz2 * SSSI_SQRT(dz2));
}
SSSI_FN float sssi_dipole_proposal(const sss_medium *m, int c, float r2) {
    float poles = 0.5f * (sssi_pole(m->length[c], r2) + sssi_pole(m->zv[c], r2));

    return m->sigma[c] > 0.0f ? 0.5f * (poles + sssi_burley_unit(1.0f / (3.0f * m->sigma[c]), r2))
                              : poles;
}

/* Radii for a pole. The distance to it is z / c; c = u on disks. On chords u = (3c - c^3) / 2: with
   e = 1 - c that is 1 - u = e^2 (3 - e) / 2, solved by Newton. */
SSSI_FN float sssi_pole_radius(float z, float c) {
    return z * SSSI_SQRT((1.0f - c) * (1.0f + c)) / c;
}
SSSI_FN float sssi_pole_chord_step(float e, float v) {
    return e - (e * e * (3.0f - e) - 2.0f * v) / (3.0f * e * (2.0f - e));
}
SSSI_FN float sssi_pole_chord(float z, float u) {
    float v = 1.0f - u;
    float e = SSSI_SQRT(v * (2.0f / 3 + v * (1.0f / 3)));

    e = sssi_pole_chord_step(sssi_pole_chord_step(e, v), v);
    return sssi_pole_radius(z, sssi_max(1.0f - e, SSSI_NUDGE));
}

/* ---- Either profile. `dipole` equals m->dipole; it travels as an argument because a caller passes
   the constant 0 or 1, so that the compiler makes two copies of a loop without a branch. ---- */

SSSI_FN float sssi_unit_profile(const sss_medium *m, int dipole, int c, float r2) {
    return dipole ? sssi_dipole_unit(m, c, r2) : sssi_burley_unit(m->length[c], r2);
}
SSSI_FN float sssi_tail(const sss_medium *m, int c, float r) {
    return m->dipole ? sssi_dipole_tail(m, c, r) : sssi_burley_tail(m->length[c], r);
}
SSSI_FN float sssi_head(const sss_medium *m, int c, float r) {
    return m->dipole ? sssi_dipole_head(m, c, r) : sssi_burley_head(m->length[c], r);
}
SSSI_FN float sssi_proposal(const sss_medium *m, int dipole, int c, float r2) {
    return dipole ? sssi_dipole_proposal(m, c, r2) : sssi_burley_unit(m->length[c], r2);
}

/* The lengths of the channel that a probe is for. */
typedef struct sssi_lengths {
    float length, zv, sigma;
} sssi_lengths;

/* A radius with the proposal's density, for a disk or a chord's sphere, from the uniform numbers
   part and u. `all`: the lanes side by side take all branches anyway. */
SSSI_FN float sssi_burley_draw(float d, int all, int chord, float part, float u) {
    float on_disk = all || !chord ? sssi_burley_radius(d, u) : 0.0f;
    float on_chord = all || chord ? sssi_burley_chord(d, part, u) : 0.0f;

    return chord ? on_chord : on_disk;
}
SSSI_FN float sssi_pole_draw(float z, int all, int chord, float u) {
    float on_disk = all || !chord ? sssi_pole_radius(z, u) : 0.0f;
    float on_chord = all || chord ? sssi_pole_chord(z, u) : 0.0f;

    return chord ? on_chord : on_disk;
}
SSSI_FN float sssi_draw_radius(const sssi_lengths *of, int dipole, int all, int chord, float part,
                               float u) {
    if (!dipole) return sssi_burley_draw(of->length, all, chord, part, u);

    /* The first two of four parts are the poles; without sigma_tr there are no others. */
    int i = sssi_class(&part, of->sigma > 0.0f ? 4 : 2);
    int is_pole = i < 2;
    float z = i > 0 ? of->zv : of->length;
    float pole = all || is_pole ? sssi_pole_draw(z, all, chord, u) : 0.0f;
    float wave =
        all || !is_pole ? sssi_burley_draw(1.0f / (3.0f * of->sigma), all, chord, part, u) : 0.0f;
    return is_pole ? pole : wave;
}

/* ---- Media ---- */

static inline SSSI_TEXT sss_result_string(sss_result result) {
    switch (result) {
    case SSS_OK: return "ok";
    case SSS_BAD_ALBEDO: return "an albedo is not within 0..1";
    case SSS_BAD_LENGTH: return "a length or coefficient is neither 0 nor within 1e-12..1e12";
    case SSS_BAD_ETA: return "the relative index of refraction is not within 0.2..5";
    case SSS_BAD_NORMAL: return "a normal is zero or not finite";
    case SSS_BAD_POSITION: return "a position is not finite, or beyond 1e30";
    case SSS_BAD_PLAN:
        return "a plan has techniques that do not go together, or a count out of range";
    }
    return "not a result of sss_resample.h";
}

SSSI_FN sss_medium sssi_black(int dipole) {
    sss_medium m;

    m.dipole = dipole;
    m.r_max = 0.0f;
    for (int c = 0; c < 3; ++c) {
        m.albedo[c] = m.length[c] = m.zv[c] = m.sigma[c] = m.flux[c] = m.fluence[c] = 0.0f;
        m.extinction[c] = m.similarity[c] = 0.0f;
    }
    return m;
}
SSSI_FN int sssi_is_live(const sss_medium *m, int c) {
    return m->albedo[c] > 0.0f && m->length[c] > 0.0f;
}

SSSI_FN int sssi_in_range(float x) { return x == 0.0f || (x >= 1e-12f && x <= 1e12f); }
SSSI_FN sss_result sssi_check_albedo(const float *albedo) {
    for (int c = 0; c < 3; ++c)
        if (!(albedo[c] >= 0.0f && albedo[c] <= 1.0f)) return SSS_BAD_ALBEDO;
    return SSS_OK;
}
SSSI_FN sss_result sssi_check_lengths(const float *a) {
    for (int c = 0; c < 3; ++c)
        if (!sssi_in_range(a[c])) return SSS_BAD_LENGTH;
    return SSS_OK;
}
SSSI_FN sss_result sssi_check_eta(float eta) {
    return eta >= 0.2f && eta <= 5.0f ? SSS_OK : SSS_BAD_ETA;
}

/* The similarity parameter s of the volume whose half space has the diffuse albedo 1 - lack, for
   isotropic scattering and matched indices. Chandrasekhar's exact value is fitted to 1e-6 by lack =
   s (2.30943255 + 1.06655746 s - 0.00319767 s^2) / (1 + 1.69256344 s + 0.6802289 s^2). Without the
   small cubic term that is a quadratic equation; its root is put in, and solved again. */
SSSI_FN float sssi_similarity(float lack) {
    float s = lack;

    for (int i = 0; i < 2; ++i) {
        float a = 1.06655746f - 0.00319767f * s - 0.6802289f * lack;
        float b = 2.30943255f - 1.69256344f * lack;

        s = 2.0f * lack / (b + SSSI_SQRT(b * b + 4.0f * a * lack));
    }
    return sssi_min(s, 1.0f);
}

/* The diffuse mean free path over the mean free path, by Grosjean's diffusion (d'Eon 2012). */
SSSI_FN float sssi_dmfp_over_mfp(float s) { return SSSI_SQRT((1.0f + s * s) / 3.0f) / s; }

/* The volume of channel c from its lack of albedo and its dmfp. Nearly white, its mean free path is
   below 2e-5 of the dmfp, and the walk takes it for Lambert. */
SSSI_FN void sssi_set_volume(sss_medium *m, int c, float lack, float dmfp) {
    float s = sssi_similarity(lack);

    m->similarity[c] = s;
    if (s > 1e-5f && dmfp > 0.0f) m->extinction[c] = sssi_dmfp_over_mfp(s) / dmfp;
}

/* The last step of every constructor: channels too narrow for float coordinates beside the widest
   one become Lambert. */
SSSI_FN void sssi_drop_narrow(sss_medium *m) {
    for (int c = 0; c < 3; ++c)
        if (m->length[c] < SSSI_NARROW * m->r_max) m->length[c] = 0.0f;
}

/* Burley's constructors differ in what `path` stands for: the dmfp, or the mean free path. */
SSSI_FN sss_result sssi_make_burley(sss_medium *m, const float *albedo, const float *path,
                                    int is_mfp) {
    sss_result result = sssi_check_albedo(albedo);

    *m = sssi_black(0);
    if (result == SSS_OK) result = sssi_check_lengths(path);
    if (result != SSS_OK) return result;

    for (int c = 0; c < 3; ++c) {
        float scale = is_mfp ? sssi_burley_mfp_scale(albedo[c]) : sssi_burley_scale(albedo[c]);

        m->albedo[c] = albedo[c];
        m->length[c] = path[c] / scale;
        sssi_set_volume(m, c, 1.0f - albedo[c], path[c]);
        if (is_mfp) m->extinction[c] = path[c] > 0.0f ? 1.0f / path[c] : 0.0f;
        if (sssi_is_live(m, c)) m->r_max = sssi_max(m->r_max, SSSI_BURLEY_R_MAX * m->length[c]);
    }
    sssi_drop_narrow(m);
    return SSS_OK;
}
static inline sss_result sss_burley(sss_medium *m, const float albedo[3], const float dmfp[3]) {
    return sssi_make_burley(m, albedo, dmfp, 0);
}
static inline sss_result sss_burley_mfp(sss_medium *m, const float albedo[3], const float mfp[3]) {
    return sssi_make_burley(m, albedo, mfp, 1);
}

/* Loops over three channels vectorise when they go over four: the last is one of the others
   again. */
#define SSSI_FOUR 4
SSSI_FN int sssi_channel_of(int lane) { return lane < 3 ? lane : 0; }

/* The boundary of a dipole: z_v = z_r + 4 A D, and the part of the reflectance that comes from the
   flux. */
typedef struct sssi_boundary {
    int better;
    float a, flux;
} sssi_boundary;

/* Moments C1 and C2 of the internal Fresnel reflectance F: C_i = integral of F mu^i dmu over 0..1,
   mu the cosine inside. y is the cosine on the thin side, z that on the dense one. A quintic in
   place of y makes the midpoint rule converge as a Gauss rule does: 2e-8 for all eta. */
#define SSSI_NODES 32
SSSI_FN sssi_boundary sssi_make_boundary(float eta, int better) {
    float n = eta > 1.0f ? eta : 1.0f / eta;
    float n2_less_1 = (n - 1.0f) * (n + 1.0f);
    int inside_is_dense = eta > 1.0f;
    float part1[SSSI_NODES], part2[SSSI_NODES];

    for (int i = 0; i < SSSI_NODES; ++i) {
        float x = ((float)i + 0.5f) / SSSI_NODES;
        float y = x * x * x * (10.0f + x * (6.0f * x - 15.0f));
        float dy = 30.0f / SSSI_NODES * (x * (1.0f - x)) * (x * (1.0f - x));
        float z = SSSI_SQRT(y * y + n2_less_1) / n;
        float rs = (y - n * z) / (y + n * z);
        float rp = (n * y - z) / (n * y + z);
        float mu = inside_is_dense ? z : y;

        part1[i] = 0.5f * (rs * rs + rp * rp) * y * dy;
        part2[i] = part1[i] * mu;
    }

    /* Sums of every fourth, then of those: they keep more digits, and run side by side. */
    float four1[SSSI_FOUR], four2[SSSI_FOUR];
    for (int l = 0; l < SSSI_FOUR; ++l) {
        four1[l] = part1[l];
        four2[l] = part2[l];
        for (int i = l + SSSI_FOUR; i < SSSI_NODES; i += SSSI_FOUR) {
            four1[l] += part1[i];
            four2[l] += part2[i];
        }
    }
    float c1 = (four1[0] + four1[1]) + (four1[2] + four1[3]);
    float c2 = (four2[0] + four2[1]) + (four2[2] + four2[3]);

    /* Inside a denser medium mu dmu = y dy / n^2, and all is reflected beyond the critical angle,
       whose squared cosine this is. */
    if (inside_is_dense) {
        float critical2 = n2_less_1 / (n * n);

        c1 = c1 / (n * n) + critical2 / 2;
        c2 = c2 / (n * n) + critical2 * SSSI_SQRT(critical2) / 3;
    }

    sssi_boundary b;
    b.better = better;
    b.a = (1.0f + (better ? 3.0f * c2 : 2.0f * c1)) / (1.0f - 2.0f * c1);
    b.flux = better ? 0.5f * (1.0f - 3.0f * c2) : 1.0f;
    return b;
}

/* A dipole in units of 1 / sigma_t', named by x = sqrt(sigma_a / sigma_s'), so that both the albedo
   of a scattering 1 / (1 + x^2) and its complement keep all their digits. */
typedef struct sssi_shape {
    float sigma, depth; /* sigma_tr, z_v - z_r */
    float core;         /* reflectance without the power of that albedo in front */
    float total, lack;  /* reflectance and 1 - reflectance, each to relative precision */
} sssi_shape;

/* 1 - (1 - e^-t) / t, t > 0, accurate about 0 too. */
SSSI_FN float sssi_lack_of_mean_exp(float t) {
    float series = t / 6 * (1.0f - t / 7);

    series = t / 4 * (1.0f - t / 5 * (1.0f - series));
    series = t / 2 * (1.0f - t / 3 * (1.0f - series));
    return t < 0.5f ? series : (t + sssi_expm1(-t)) / t;
}
SSSI_FN sssi_shape sssi_make_shape(sssi_boundary b, float x) {
    float alpha = 1.0f / (1.0f + x * x);
    float lost = x * x / (1.0f + x * x);
    float wave_part = 1.0f - b.flux;
    sssi_shape h;

    h.sigma = SSSI_SQRT(b.better ? 3.0f * lost / (1.0f + lost) : 3.0f * lost);
    h.depth = 4.0f / 3 * b.a * (b.better ? 1.0f + lost : 1.0f);

    /* e^(-s z) - 1 of the real and the virtual source. */
    float t = h.sigma * h.depth;
    float er = sssi_expm1(-h.sigma);
    float ev = sssi_expm1(-h.sigma - t);

    /* The core, and 1 - core without its cancellation. */
    h.core = b.flux * (1.0f + 0.5f * (er + ev)) + wave_part * (1.0f + er) * sssi_mean_exp(t);
    float dark =
        -0.5f * b.flux * (er + ev) + wave_part * ((1.0f + er) * sssi_lack_of_mean_exp(t) - er);

    float front = b.better ? alpha * alpha : alpha;
    h.total = front * h.core;
    h.lack = (b.better ? lost * (2.0f - lost) : lost) + front * dark;
    return h;
}

/* Channel c with the numbers of a shape and the reduced mean free path z_r. */
SSSI_FN void sssi_set_dipole(sss_medium *m, int c, float flux, float sigma, float depth, float core,
                             float zr) {
    m->length[c] = zr;
    m->zv[c] = zr + zr * depth;
    m->sigma[c] = sigma / zr;
    m->flux[c] = flux / (4.0f * SSSI_PI * core);
    m->fluence[c] = (1.0f - flux) / (2.0f * SSSI_PI * core * depth * zr);
}

/* The radius of a dipole with the tail SSSI_TAIL. Far away the tail is k e^(-s r) / r, which
   Lambert's W function solves: the guess uses W(v) = l (1 - ln(1 + l) / (2 + l)), l = ln(1 + v),
   good to 2 %. Three Newton steps in the logarithm of the true tail follow. A channel that is not
   live has no radius; it gets one that divides nothing by 0. */
SSSI_FN float sssi_guess_r_max(const sss_medium *m, int c) {
    float zr = m->length[c], zv = m->zv[c], s = m->sigma[c];
    float k = m->flux[c] * (zr + zv) + m->fluence[c] * 0.5f * (zv - zr) * (zv + zr);
    float q = k * (2.0f * SSSI_PI / SSSI_TAIL);
    float v = sssi_min(s * q, 1e30f);
    float l = sssi_log(1.0f + v);
    float w = l * (1.0f - sssi_log(1.0f + l) / (2.0f + l));

    return sssi_max(v > 1e-3f ? w / s : q, 1e-15f);
}
SSSI_FN float sssi_better_r_max(const sss_medium *m, int c, float r) {
    float over = sssi_log(sssi_max(sssi_dipole_tail(m, c, r), SSSI_TINY) / SSSI_TAIL);

    return sssi_max(r + over * r / (m->sigma[c] * r + 1.0f), 0.25f * r);
}
SSSI_FN void sssi_finish_dipole(sss_medium *m) {
    float r[SSSI_FOUR];

    for (int l = 0; l < SSSI_FOUR; ++l) r[l] = sssi_guess_r_max(m, sssi_channel_of(l));
    for (int i = 0; i < 3; ++i)
        for (int l = 0; l < SSSI_FOUR; ++l) r[l] = sssi_better_r_max(m, sssi_channel_of(l), r[l]);
    for (int l = 0; l < 3; ++l)
        if (sssi_is_live(m, l)) m->r_max = sssi_max(m->r_max, r[l]);
    sssi_drop_narrow(m);
}

SSSI_APART sss_result sssi_make_dipole(sss_medium *m, const float *sigma_a, const float *sigma_s,
                                       float eta, int better) {
    sss_result result = sssi_check_lengths(sigma_a);

    *m = sssi_black(1);
    if (result == SSS_OK) result = sssi_check_lengths(sigma_s);
    if (result == SSS_OK) result = sssi_check_eta(eta);
    if (result != SSS_OK) return result;

    sssi_boundary b = sssi_make_boundary(eta, better);
    for (int c = 0; c < 3; ++c) {
        if (sigma_s[c] > 0.0f) {
            float x = SSSI_SQRT(sigma_a[c] / sigma_s[c]);
            sssi_shape h = sssi_make_shape(b, x);
            float zr = 1.0f / (sigma_a[c] + sigma_s[c]);

            m->albedo[c] = sssi_min(h.total, 1.0f);
            sssi_set_dipole(m, c, b.flux, h.sigma, h.depth, h.core, zr);

            /* The volume's mean free path over z_r has a limit as absorption goes to 0. x = 1e-3
               is close to it. */
            sssi_shape volume = sssi_make_shape(b, sssi_max(x, 1e-3f));
            sssi_set_volume(m, c, volume.lack, zr / volume.sigma);
            m->similarity[c] = sssi_similarity(h.lack);
        }
    }
    sssi_finish_dipole(m);
    return SSS_OK;
}

/* ln x of the dipole with a given reflectance, first as a guess: with R = (1 + x^2)^-p core, p 1 or
   2, the quantity R^(-1/p) - 1 is nearly linear in x for small x, and quadratic for large x. */
SSSI_FN float sssi_guess_shape(sssi_boundary b, float albedo, float lack) {
    float linear = 1.7320508f * (1.0f + 2.0f / 3 * b.a);
    float square = 11.0f;
    float gap = lack / albedo;

    if (b.better) {
        float root = SSSI_SQRT(albedo);

        linear *= 0.5f;
        square = 3.6f;
        gap = lack / ((1.0f + root) * root);
    }
    return sssi_log(2.0f * gap / (linear + SSSI_SQRT(linear * linear + 4.0f * square * gap)));
}
/* ln(total / lack): falls with ln x, nearly in a straight line. */
SSSI_FN float sssi_shape_odds(sssi_boundary b, float log_x) {
    sssi_shape h = sssi_make_shape(b, sssi_exp(log_x));

    return sssi_log(sssi_max(h.total, SSSI_TINY) / h.lack);
}

/* How far the odds at y are from those wanted. The boundary's kind is a constant in each loop. */
SSSI_FN void sssi_miss_of(sssi_boundary b, int better, const float *y, const float *wanted,
                          float *miss) {
    float from[SSSI_FOUR], odds[SSSI_FOUR];

    b.better = better;
    for (int l = 0; l < SSSI_FOUR; ++l) from[l] = y[l];
    for (int l = 0; l < SSSI_FOUR; ++l) odds[l] = sssi_shape_odds(b, from[l]);
    for (int l = 0; l < SSSI_FOUR; ++l) miss[l] = odds[l] - wanted[l];
}
SSSI_APART void sssi_miss(const sssi_boundary *b, const float *y, const float *wanted,
                          float *miss) {
    if (b->better) sssi_miss_of(*b, 1, y, wanted, miss);
    else sssi_miss_of(*b, 0, y, wanted, miss);
}

/* The state of four searches for ln x, side by side. */
typedef struct sssi_secant {
    float y[SSSI_FOUR], miss[SSSI_FOUR];   /* the step before, and how far its odds are off */
    float low[SSSI_FOUR], high[SSSI_FOUR]; /* bounds */
} sssi_secant;

/* One secant step between the bounds. If it leads out of them, they are halved instead. */
SSSI_FN float sssi_secant_step(sssi_secant *k, int l, float y, float miss) {
    float run = y - k->y[l];
    float fall = k->miss[l] - miss;
    float next = y + miss * (run / (fall != 0.0f ? fall : 1.0f));
    float low = k->low[l], high = k->high[l];

    low = miss > 0.0f ? y : low;
    high = miss > 0.0f ? high : y;
    next = next < low ? 0.5f * (low + high) : next;
    next = next > high ? 0.5f * (low + high) : next;
    k->low[l] = low;
    k->high[l] = high;
    k->y[l] = y;
    k->miss[l] = miss;
    return next;
}
SSSI_FN void sssi_invert_shapes(sssi_boundary b, const float *albedo, float *y) {
    float wanted[SSSI_FOUR], step = 1.0f;
    sssi_secant k;

    for (int l = 0; l < SSSI_FOUR; ++l) {
        float lack = 1.0f - albedo[l];

        wanted[l] = sssi_log(albedo[l] / lack);
        y[l] = sssi_guess_shape(b, albedo[l], lack);
        k.y[l] = y[l] + 0.01f;
        k.low[l] = -40.0f;
        k.high[l] = 40.0f;
    }
    sssi_miss(&b, k.y, wanted, k.miss);

    /* Four steps do for an eta up to 1.5. A step of 2e-4 leaves an error of less than 1e-6. */
    for (int i = 0; i < 24 && step > 2e-4f; ++i) {
        float miss[SSSI_FOUR];

        sssi_miss(&b, y, wanted, miss);
        step = 0.0f;
        for (int l = 0; l < SSSI_FOUR; ++l) {
            float next = sssi_secant_step(&k, l, y[l], miss[l]);

            step = sssi_max(step, SSSI_FABS(next - y[l]));
            y[l] = next;
        }
    }
}
SSSI_APART sss_result sssi_invert_dipole(sss_medium *m, const float *albedo, const float *dmfp,
                                         float eta, int better) {
    sss_result result = sssi_check_albedo(albedo);

    *m = sssi_black(1);
    if (result == SSS_OK) result = sssi_check_lengths(dmfp);
    if (result == SSS_OK) result = sssi_check_eta(eta);
    if (result != SSS_OK) return result;

    /* A stand-in for albedos that need no dipole. */
    float wanted[SSSI_FOUR], log_x[SSSI_FOUR];
    for (int c = 0; c < SSSI_FOUR; ++c) {
        float a = albedo[sssi_channel_of(c)];

        wanted[c] = a > 0.0f && a < 1.0f ? sssi_max(a, SSSI_TINY) : 0.5f;
    }
    sssi_boundary b = sssi_make_boundary(eta, better);
    sssi_invert_shapes(b, wanted, log_x);

    float sigma[SSSI_FOUR], depth[SSSI_FOUR], core[SSSI_FOUR];
    for (int c = 0; c < SSSI_FOUR; ++c) {
        sssi_shape h = sssi_make_shape(b, sssi_exp(log_x[c]));

        sigma[c] = h.sigma;
        depth[c] = h.depth;
        core[c] = h.core;
    }
    for (int c = 0; c < 3; ++c) {
        float zr = sigma[c] * dmfp[c];

        m->albedo[c] = albedo[c];
        sssi_set_volume(m, c, 1.0f - albedo[c], dmfp[c]);

        /* Lambert where 1 / z_r^2 would leave float's range. */
        if (albedo[c] > 0.0f && albedo[c] < 1.0f && zr >= 1e-17f)
            sssi_set_dipole(m, c, b.flux, sigma[c], depth[c], core[c], zr);
    }
    sssi_finish_dipole(m);
    return SSS_OK;
}
static inline sss_result sss_dipole(sss_medium *m, const float sigma_a[3],
                                    const float sigma_s_prime[3], float eta) {
    return sssi_make_dipole(m, sigma_a, sigma_s_prime, eta, 0);
}
static inline sss_result sss_better_dipole(sss_medium *m, const float sigma_a[3],
                                           const float sigma_s_prime[3], float eta) {
    return sssi_make_dipole(m, sigma_a, sigma_s_prime, eta, 1);
}
static inline sss_result sss_dipole_from_albedo(sss_medium *m, const float albedo[3],
                                                const float dmfp[3], float eta) {
    return sssi_invert_dipole(m, albedo, dmfp, eta, 0);
}
static inline sss_result sss_better_dipole_from_albedo(sss_medium *m, const float albedo[3],
                                                       const float dmfp[3], float eta) {
    return sssi_invert_dipole(m, albedo, dmfp, eta, 1);
}

static inline float sss_profile(const sss_medium *m, int channel, float r) {
    if (channel < 0 || channel > 2 || !(r >= 0.0f) || !sssi_is_live(m, channel)) return 0.0f;
    float k = sssi_min(r, SSSI_R_FAR);
    return m->albedo[channel] * sssi_unit_profile(m, m->dipole, channel, k * k);
}
static inline float sss_within(const sss_medium *m, int channel, float r) {
    if (channel < 0 || channel > 2 || !(r >= 0.0f)) return 0.0f;
    if (!sssi_is_live(m, channel)) return m->albedo[channel];
    float tail = sssi_tail(m, channel, sssi_min(r, SSSI_R_FAR));
    float within = tail > 0.5f ? sssi_head(m, channel, r) : 1.0f - tail;
    return m->albedo[channel] * sssi_max(within, 0.0f);
}

/* ---- Lookup ---- */

/* Shares of a plan's techniques: equal over the set bits, and of the two tangents. The default mix
   was measured by demos/study/mix.c: the sphere finds curved and thin bodies, the disk flat ones,
   and the chord bounds the weights. */
SSSI_FN void sssi_set_shares(sss_resampler *s, unsigned bits) {
    int n = 0;

    for (int t = 0; t < SSSI_TECHNIQUES; ++t) s->share[t] = 0.0f;
    if (bits == 0) {
        s->share[SSSI_NORMAL] = 0.375f;
        s->share[SSSI_SPHERE] = 0.375f;
        s->share[SSSI_CHORD] = 0.25f;
        return;
    }
    for (int t = 0; t < 4; ++t) n += (int)(bits >> t & 1u);
    float each = 1.0f / (float)(n > 0 ? n : 1);
    if (bits & SSS_DISK) s->share[SSSI_NORMAL] = each;
    if (bits & SSS_DISK_TANGENTS) s->share[SSSI_TANGENT] = s->share[SSSI_BITANGENT] = 0.5f * each;
    if (bits & SSS_SPHERE) s->share[SSSI_SPHERE] = each;
    if (bits & SSS_CHORD) s->share[SSSI_CHORD] = each;
}

/* Whole probes for each technique: floor or ceiling of M q, and M q in the mean, by systematic
   sampling with one number u of the lookup. */
SSSI_FN void sssi_set_counts(sss_resampler *s) {
    uint32_t golden = 0x9e3779b9u;
    float u = sssi_unit(sss_hash(s->seed, 0x40000000u) + s->sample * golden);
    float sum = 0.0f;

    s->first[0] = 0;
    for (int t = 0; t < SSSI_TECHNIQUES; ++t) {
        sum += s->share[t];
        float expected = sum * (float)s->candidates;
        float whole = (float)(int)expected;

        s->first[t + 1] = (int)whole + (expected - whole > u ? 1 : 0);
    }
    s->first[SSSI_TECHNIQUES] = s->candidates;
}

/* The medium in units of 2^e <= its longest live length, and the channels' parts in the mixtures.
   For a walk a channel is live if it has a volume, and its length is the mean free path. */
SSSI_FN sssi_optics sssi_make_optics(const sss_medium *m, unsigned techniques) {
    float longest = 0.0f;
    int wide = 0;
    sssi_optics o;

    o.medium = *m;
    o.live = o.lambert = 0;

    float size[3];
    for (int c = 0; c < 3; ++c) {
        size[c] = m->length[c];
        if (techniques == SSS_WALK && m->length[c] > 0.0f)
            size[c] = m->extinction[c] > 0.0f ? 1.0f / m->extinction[c] : 0.0f;
        if (techniques == SSS_LAMBERT || !(m->albedo[c] > 0.0f)) size[c] = 0.0f;

        if (size[c] > 0.0f) o.live += 1;
        else if (m->albedo[c] > 0.0f) o.lambert += 1;

        if (size[c] > longest) {
            longest = size[c];
            wide = c;
        }
    }
    o.unit = o.live ? sssi_float(sssi_bits(longest) & 0x7f800000u) : 1.0f;
    float inverse = 1.0f / o.unit;

    for (int c = 0; c < 3; ++c) {
        int from = size[c] > 0.0f ? c : wide;

        o.mix[c] = size[c] > 0.0f ? 1.0f / (float)o.live : 0.0f;
        o.medium.length[c] = m->length[from] * inverse;
        o.medium.zv[c] = m->zv[from] * inverse;
        o.medium.sigma[c] = m->sigma[from] * o.unit;
        o.medium.flux[c] = m->flux[from];
        o.medium.fluence[c] = m->fluence[from] * o.unit;
        o.medium.extinction[c] = m->extinction[from] * o.unit;
        o.medium.similarity[c] = m->similarity[from];
    }
    o.medium.r_max = m->r_max * inverse;
    return o;
}

SSSI_FN sss_result sssi_check_plan(const sss_plan *plan) {
    unsigned probes = SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD;
    unsigned models = SSS_WALK | SSS_LAMBERT;
    int alone = plan->techniques == SSS_WALK || plan->techniques == SSS_LAMBERT;
    int room = SSS_MAX_EXITS;

    if (plan->candidates < 0 || plan->candidates > SSS_MAX_CANDIDATES) return SSS_BAD_PLAN;
    if (plan->exits < 0 || plan->exits > SSS_MAX_EXITS) return SSS_BAD_PLAN;
    if (plan->techniques & ~(probes | models)) return SSS_BAD_PLAN;
    if ((plan->techniques & models) && !alone) return SSS_BAD_PLAN;
    if (plan->per_channel && (plan->exits > 1 || room < 3)) return SSS_BAD_PLAN;
    return SSS_OK;
}

/* The logarithms that weigh a walk, the extinctions' over that of channel 0. ln albedo = ln(1 -
   s^2). */
SSSI_FN void sssi_begin_walks(sss_resampler *s) {
    const sss_medium *m = &s->optics.medium;
    sssi_walk *w = &s->walk;

    w->on = w->found = w->goes_on = w->scatterings = 0;
    w->key = 0u;
    w->position = w->direction = s->axis[SSSI_NORMAL];
    w->length = w->skip = w->skin = w->extinction = w->path = w->roulette = w->distance = 0.0f;
    w->hit.light = 0.0f;
    w->brightest = -SSSI_FLT_MAX;
    for (int c = 0; c < 3; ++c) {
        float lost = m->similarity[c] * m->similarity[c];

        w->log_albedo[c] = w->log_extinction[c] = 0.0f;
        if (!s->walks || !(s->optics.mix[c] > 0.0f)) continue;
        w->log_albedo[c] = sssi_log(sssi_max(1.0f - lost, SSSI_TINY));
        if (lost < 0.25f) w->log_albedo[c] = sssi_log_parts(0.0f, -lost);
        w->log_extinction[c] = sssi_log(m->extinction[c] / m->extinction[0]);
        w->brightest = sssi_max(w->brightest, w->log_albedo[c]);
    }
}

/* Lanes without a hit are worked on too, so they hold numbers. */
SSSI_FN void sssi_clear_hits(sssi_hits *h, sss_vec3 normal) {
    h->count = 0;
    for (int l = 0; l < SSS_LANES; ++l) {
        sssi_set_lane(&h->position, l, normal);
        sssi_set_lane(&h->normal, l, normal);
        h->light[l] = 1.0f;
        h->depth[l] = 0.0f;
        h->reservoir[l] = h->number[l] = 0;
    }
}

static inline sss_result sss_begin_sample(sss_resampler *s, const sss_medium *m,
                                          const sss_plan *plan, sss_vec3 position,
                                          sss_vec3 geometric_normal, uint32_t seed,
                                          uint32_t sample) {
    sss_plan p = {0, 0, 0u, 0, 0, 0};

    if (plan) p = *plan;
    sss_result result = sssi_check_plan(&p);
    if (result == SSS_OK && (!sssi_finite(position) || sssi_longest(position) > SSSI_FARTHEST))
        result = SSS_BAD_POSITION;
    if (!sssi_normalize(&geometric_normal) && result == SSS_OK) result = SSS_BAD_NORMAL;

    /* A refused lookup is one of a black medium: no probes, no exits. */
    if (result != SSS_OK) {
        sss_medium black = sssi_black(0);
        sss_plan none = {0, 0, 0u, 0, 0, 0};

        p = none;
        position = sssi_vec3(0.0f, 0.0f, 0.0f);
        geometric_normal = sssi_vec3(0.0f, 0.0f, 1.0f);
        s->optics = sssi_make_optics(&black, 0u);
    } else {
        s->optics = sssi_make_optics(m, p.techniques);
    }

    s->position = position;
    s->axis[SSSI_NORMAL] = geometric_normal;
    sssi_frame(geometric_normal, &s->axis[SSSI_TANGENT], &s->axis[SSSI_BITANGENT]);

    /* The segments end a little within the ball outside of which their intensity is 0: no rounding
       of a hit can carry it out of the ball, where it would be weighed as if only chords went
       there. What lies in the thin shell between the two is lost: at most 2e-3 of the albedo, and
       that only if the surface is a sphere of this very radius about the entry. */
    s->ball = s->optics.medium.r_max * (1.0f - SSSI_SHELL);
    s->reach = s->ball * (1.0f - SSSI_SHELL);
    s->blur = SSSI_BLUR * (s->optics.medium.r_max + sssi_longest(position) / s->optics.unit);

    s->candidates = p.candidates ? p.candidates : 8;
    if (s->optics.live == 0) s->candidates = 0;
    s->exits = p.exits ? p.exits : 1;
    s->independent = p.independent;
    s->per_channel = p.per_channel;
    s->walks = p.techniques == SSS_WALK;

    /* Samples of one seed share its lattices, each shifted a step on. All else they draw anew. */
    s->key = sss_hash(seed, sample);
    s->seed = p.independent ? s->key : seed;
    s->sample = p.independent ? 0u : sample;

    s->next = s->calls = s->weighed = 0;
    sssi_set_shares(s, p.techniques);
    sssi_set_counts(s);
    sssi_clear_hits(&s->hits, geometric_normal);
    sssi_begin_walks(s);
    for (int i = 0; i < SSS_LANES; ++i) s->probes.depth[i] = s->probes.length[i] = 0.0f;
    for (int i = 0; i < SSS_MAX_EXITS; ++i) s->reservoir[i].weight = s->reservoir[i].plain = 0.0f;
    return result;
}
static inline sss_result sss_begin(sss_resampler *s, const sss_medium *m, const sss_plan *plan,
                                   sss_vec3 position, sss_vec3 geometric_normal, uint32_t seed) {
    return sss_begin_sample(s, m, plan, position, geometric_normal, seed, 0u);
}

/* ---- Numbers for probes ---- */

/* The n probes of a technique are a lattice in all their dimensions: from where the lookup's seed
   puts probe 0, probe k stands k p / n of a turn on, p the prime of the dimension. So each
   dimension has one number in each of n equal strata (a Latin hypercube), and angles are evenly
   spaced. The primes were chosen for even pairs of dimensions at n up to 96. Each sample of a seed
   shifts the lattice by a step, in units of 2^-32 of a turn: powers of 1 / g, g^8 = g + 1, a
   Kronecker sequence in seven dimensions. */
enum { SSSI_CHANNEL, SSSI_PART, SSSI_RADIUS, SSSI_TURN, SSSI_SIDE, SSSI_COSINE, SSSI_TURN_B };
SSSI_FN int sssi_prime(int dimension) {
    switch (dimension) {
    case SSSI_CHANNEL: return 449;
    case SSSI_PART: return 607;
    case SSSI_RADIUS: return 457;
    case SSSI_TURN: return 379;
    case SSSI_SIDE: return 569;
    case SSSI_COSINE: return 563;
    }
    return 641;
}
SSSI_FN uint32_t sssi_step(int dimension) {
    switch (dimension) {
    case SSSI_CHANNEL: return 0xa127a31du;
    case SSSI_PART: return 0x92e852c9u;
    case SSSI_RADIUS: return 0xe95e1dd1u;
    case SSSI_TURN: return 0xd4bc74e1u;
    case SSSI_SIDE: return 0xb0c8ac51u;
    case SSSI_COSINE: return 0xc1edbc5bu;
    }
    return 0x85eb75c3u;
}

/* Where a probe stands in its lattice. An independent probe is number 0 of a lattice of its own. */
typedef struct sssi_place {
    int technique;
    uint32_t name;    /* of the lattice */
    float k, n, step; /* step = 1 / n */
} sssi_place;

SSSI_FN sssi_place sssi_find_place(const int *first, int probe) {
    int begin = first[0], end = first[1];
    sssi_place at;

    at.technique = 0;
    for (int t = 1; t < SSSI_TECHNIQUES; ++t) {
        int past = probe >= first[t];

        at.technique = past ? t : at.technique;
        begin = past ? first[t] : begin;
        end = past ? first[t + 1] : end;
    }
    at.name = (uint32_t)at.technique << 10;
    at.k = (float)(probe - begin);
    at.n = (float)(end - begin);
    at.step = 1.0f / at.n;
    return at;
}
SSSI_FN sssi_place sssi_find_independent_place(const sss_resampler *s, int probe) {
    float u = sssi_unit(sss_hash(s->key, 0x50000000u + (uint32_t)probe));
    float sum = s->share[0];
    sssi_place at;

    at.technique = 0;
    while (u > sum && at.technique < SSSI_CHORD) sum += s->share[++at.technique];
    at.name = (uint32_t)(SSSI_TECHNIQUES + probe) << 10;
    at.k = 0.0f;
    at.n = at.step = 1.0f;
    return at;
}

SSSI_FN float sssi_number(const sss_resampler *s, sssi_place at, int dimension) {
    int prime = sssi_prime(dimension);
    uint32_t offset =
        sss_hash(s->seed, at.name + (uint32_t)dimension) + s->sample * sssi_step(dimension);

    /* k p less whole turns: 0 .. 1.5 n. */
    float kp = at.k * (float)prime;
    float place = kp - at.n * (float)(int)(kp * at.step - 0.5f);

    float x = place * at.step + sssi_unit(offset);
    return sssi_open(x - (float)(int)x);
}

/* ---- Techniques: for each, how its segment is drawn and the intensity of its hits ---- */

/* The ends of a probe's segment: `rim` from its axis and `height` along it, about the entry. */
typedef struct sssi_ends {
    float rim_a, height_a, rim_b, height_b;
} sssi_ends;

/* The mean over the channels of the proposal, at distance sqrt(r2). */
SSSI_FN float sssi_mean_proposal(const sss_resampler *s, int dipole, float r2) {
    const sss_medium *m = &s->optics.medium;
    const float *mix = s->optics.mix;

    return mix[0] * sssi_proposal(m, dipole, 0, r2) + mix[1] * sssi_proposal(m, dipole, 1, r2) +
           mix[2] * sssi_proposal(m, dipole, 2, r2);
}

/* Disk [3]. A line at the distance r from its axis; beyond the reach its ends meet, and there is no
   probe. */
SSSI_FN sssi_ends sssi_disk_ends(float r, float reach) {
    float height = SSSI_SQRT(sssi_max(reach * reach - r * r, 0.0f));
    sssi_ends e = {r, height, r, -height};

    return e;
}

/* x is the hit about the entry. The distance from the axis comes from the parts along the two other
   axes: r^2 less the part along this one would cancel near the axis. */
SSSI_FN float sssi_disk_intensity(const sss_resampler *s, int dipole, int axis, sss_vec3 x,
                                  sss_vec3 n) {
    float u = sssi_dot(x, s->axis[(axis + 1) % 3]);
    float v = sssi_dot(x, s->axis[(axis + 2) % 3]);
    float along = SSSI_FABS(sssi_dot(n, s->axis[axis]));

    return along * sssi_mean_proposal(s, dipole, u * u + v * v);
}

/* Sphere [4]. The line is o + t w, w the upper of its two directions with cosine z; the ball cuts
   it at t = h z -+ the root. */
SSSI_FN sssi_ends sssi_sphere_ends(float h, float reach, float z) {
    float rim = SSSI_SQRT((1.0f - z) * (1.0f + z));
    float root = SSSI_SQRT((reach - h) * (reach + h) + h * h * z * z);
    float a = h * z + root;
    float b = h * z - root;
    sssi_ends e = {a * rim, a * z - h, b * rim, b * z - h};

    return e;
}

/* How far the surface's tangent plane at x passes from the point o at depth h; *v2 is |x - o|^2. */
SSSI_FN float sssi_plane_distance(const sss_resampler *s, float h, sss_vec3 x, sss_vec3 n,
                                  float *v2) {
    sss_vec3 v = sssi_add(x, sssi_mul(s->axis[SSSI_NORMAL], h));

    *v2 = sssi_dot(v, v);
    return SSSI_FABS(sssi_dot(n, v));
}

/* A face whose plane runs through o is met by these lines at o alone, but for rounding. So within
   `blur` the intensity is 0, and sssi_weigh drops what a line through o finds there. */
SSSI_FN float sssi_depth_intensity(const sss_resampler *s, float h, sss_vec3 x, sss_vec3 n) {
    float v2;
    float distance = sssi_plane_distance(s, h, x, n, &v2);
    float safe = sssi_max(v2, SSSI_POLE_MIN);
    float mu = distance / (2.0f * SSSI_PI * safe * SSSI_SQRT(safe));

    return distance > s->blur ? mu : 0.0f;
}
SSSI_FN float sssi_sphere_intensity(const sss_resampler *s, sss_vec3 x, sss_vec3 n) {
    const float *mix = s->optics.mix, *h = s->optics.medium.length;

    return mix[0] * sssi_depth_intensity(s, h[0], x, n) +
           mix[1] * sssi_depth_intensity(s, h[1], x, n) +
           mix[2] * sssi_depth_intensity(s, h[2], x, n);
}

/* Chord [5]. Half of the chords join the two sides of the tangent plane, a quarter lies above it
   and a quarter below; za and zb are the heights of the ends over rho. */
SSSI_FN sssi_ends sssi_chord_ends(float rho, float za, float zb) {
    int side = sssi_class(&za, 4);
    sssi_ends e;

    e.rim_a = rho * SSSI_SQRT((1.0f - za) * (1.0f + za));
    e.rim_b = rho * SSSI_SQRT((1.0f - zb) * (1.0f + zb));
    e.height_a = side == 3 ? -rho * za : rho * za;
    e.height_b = side == 2 ? rho * zb : -rho * zb;
    return e;
}

/* `proposal` is the mean proposal at the hit. */
SSSI_FN float sssi_chord_intensity(float proposal) { return 0.5f * proposal; }

/* ---- Probes: made together for as many lanes as there are, in loops that vectorise. Each loop
   calls a function of one probe. ---- */

/* All random numbers of the next probes. */
typedef struct sssi_numbers {
    int technique[SSS_LANES];
    float channel[SSS_LANES], part[SSS_LANES], radius[SSS_LANES], turn[SSS_LANES];
    float side[SSS_LANES], cosine[SSS_LANES], turn_b[SSS_LANES];
} sssi_numbers;

SSSI_FN void sssi_set_numbers(const sss_resampler *s, int l, sssi_place at, sssi_numbers *u) {
    u->technique[l] = at.technique;
    u->channel[l] = sssi_number(s, at, SSSI_CHANNEL);
    u->part[l] = sssi_number(s, at, SSSI_PART);
    u->radius[l] = sssi_number(s, at, SSSI_RADIUS);
    u->turn[l] = sssi_number(s, at, SSSI_TURN);
    u->side[l] = sssi_number(s, at, SSSI_SIDE);
    u->cosine[l] = sssi_number(s, at, SSSI_COSINE);
    u->turn_b[l] = sssi_number(s, at, SSSI_TURN_B);
}

/* The lengths of the live channels, these first. */
SSSI_FN void sssi_live_lengths(const sssi_optics *o, sssi_lengths of[3]) {
    int live = 0;

    for (int c = 0; c < 3; ++c) {
        sssi_lengths mine = {o->medium.length[c], o->medium.zv[c], o->medium.sigma[c]};

        of[c] = mine;
        of[live] = mine;
        if (o->mix[c] > 0.0f) ++live;
    }
}

/* Number 0, 1 or 2 of three. */
SSSI_FN float sssi_choose(int i, float a, float b, float c) {
    float first = i == 0 ? a : b;

    return i == 2 ? c : first;
}

/* The lengths of the live channel that a probe is for, by a uniform number. */
SSSI_FN sssi_lengths sssi_draw_channel(const sssi_lengths of[3], int live, float u) {
    int i = sssi_class(&u, live);
    sssi_lengths mine;

    mine.length = sssi_choose(i, of[0].length, of[1].length, of[2].length);
    mine.zv = sssi_choose(i, of[0].zv, of[1].zv, of[2].zv);
    mine.sigma = sssi_choose(i, of[0].sigma, of[1].sigma, of[2].sigma);
    return mine;
}

SSSI_FN float sssi_by_technique(int t, float disk, float sphere, float chord) {
    float line = t == SSSI_SPHERE ? sphere : disk;

    return t == SSSI_CHORD ? chord : line;
}

/* The ends of a probe's segment, each about its own technique's axis. */
SSSI_FN sssi_ends sssi_find_ends(const sss_resampler *s, int t, float depth, float r, float za,
                                 float zb) {
    sssi_ends disk = sssi_disk_ends(r, s->reach);
    sssi_ends sphere = sssi_sphere_ends(depth, s->reach, zb);
    sssi_ends chord = sssi_chord_ends(r, za, zb);
    sssi_ends e;

    e.rim_a = sssi_by_technique(t, disk.rim_a, sphere.rim_a, chord.rim_a);
    e.rim_b = sssi_by_technique(t, disk.rim_b, sphere.rim_b, chord.rim_b);
    e.height_a = sssi_by_technique(t, disk.height_a, sphere.height_a, chord.height_a);
    e.height_b = sssi_by_technique(t, disk.height_b, sphere.height_b, chord.height_b);
    return e;
}

/* A disk's axis is the last of three. This turns it, with the others, to where it belongs among
   tangent, bitangent and normal. */
SSSI_FN sss_vec3 sssi_turn_disk(int technique, sss_vec3 v) {
    sss_vec3 t = technique == SSSI_TANGENT ? sssi_vec3(v.z, v.x, v.y) : v;

    return technique == SSSI_BITANGENT ? sssi_vec3(v.y, v.z, v.x) : t;
}

/* A vector from its parts along tangent, bitangent and normal. */
SSSI_FN sss_vec3 sssi_in_frame(const sss_resampler *s, sss_vec3 v) {
    sss_vec3 flat =
        sssi_add(sssi_mul(s->axis[SSSI_TANGENT], v.x), sssi_mul(s->axis[SSSI_BITANGENT], v.y));

    return sssi_add(flat, sssi_mul(s->axis[SSSI_NORMAL], v.z));
}

SSSI_FN void sssi_make_probes_of(sss_resampler *s, int dipole, int count) {
    sssi_probes *p = &s->probes;
    int all = SSSI_WIDE && count > 1;
    int last = s->candidates - 1;
    int first[SSSI_TECHNIQUES + 1];

    for (int l = 0; l <= SSSI_TECHNIQUES; ++l) first[l] = s->first[l];

    /* Draw the numbers. Lanes beyond the last probe repeat it. */
    sssi_numbers u;
    for (int l = 0; l < count; ++l) {
        int probe = s->next + l;

        sssi_set_numbers(s, l, sssi_find_place(first, probe < last ? probe : last), &u);
    }
    if (s->independent) {
        for (int l = 0; l < count; ++l)
            sssi_set_numbers(s, l, sssi_find_independent_place(s, s->next + l), &u);
    }

    /* Draw the channel and the radius. */
    sssi_lengths of[3];
    sssi_live_lengths(&s->optics, of);
    float r[SSS_LANES], depth[SSS_LANES];
    for (int l = 0; l < count; ++l) {
        sssi_lengths mine = sssi_draw_channel(of, s->optics.live, u.channel[l]);
        int t = u.technique[l];
        int needed = all || t != SSSI_SPHERE;

        depth[l] = mine.length;
        r[l] = needed
                   ? sssi_draw_radius(&mine, dipole, all, t == SSSI_CHORD, u.part[l], u.radius[l])
                   : 0.0f;
    }

    /* Find the two ends of the segment in the frame of the entry. */
    sssi_lanes a, b;
    for (int l = 0; l < count; ++l) {
        int t = u.technique[l];
        sssi_ends e = sssi_find_ends(s, t, depth[l], r[l], u.side[l], u.cosine[l]);
        float sa, ca, sb, cb;

        sssi_sincos_turn(u.turn[l], &sa, &ca);
        sssi_sincos_turn(u.turn_b[l], &sb, &cb);
        sb = t == SSSI_CHORD ? sb : sa;
        cb = t == SSSI_CHORD ? cb : ca;
        sssi_set_lane(&a, l, sssi_vec3(e.rim_a * ca, e.rim_a * sa, e.height_a));
        sssi_set_lane(&b, l, sssi_vec3(e.rim_b * cb, e.rim_b * sb, e.height_b));
        p->depth[l] = t == SSSI_SPHERE ? depth[l] : 0.0f;
    }

    /* Turn the disks about the tangents. */
    if (s->share[SSSI_TANGENT] > 0.0f) {
        for (int l = 0; l < count; ++l) {
            sssi_set_lane(&a, l, sssi_turn_disk(u.technique[l], sssi_lane(&a, l)));
            sssi_set_lane(&b, l, sssi_turn_disk(u.technique[l], sssi_lane(&b, l)));
        }
    }

    /* Turn the two ends into a probe of the scene. */
    for (int l = 0; l < count; ++l) {
        sss_vec3 from = sssi_in_frame(s, sssi_lane(&a, l));
        sss_vec3 way = sssi_sub(sssi_in_frame(s, sssi_lane(&b, l)), from);
        float length = SSSI_SQRT(sssi_dot(way, way));

        sssi_set_lane(&p->origin, l, sssi_add(s->position, sssi_mul(from, s->optics.unit)));
        sssi_set_lane(&p->direction, l, sssi_mul(way, 1.0f / length));
        p->length[l] = length * s->optics.unit;
    }
}

/* Makes the next probes, as many as there are lanes or are left. */
SSSI_APART void sssi_make_probes(sss_resampler *s) {
    int left = s->candidates - s->next;

    if (s->optics.medium.dipole) {
        if (left > 1) sssi_make_probes_of(s, 1, SSSI_COUNT(left));
        else sssi_make_probes_of(s, 1, 1);
    } else {
        if (left > 1) sssi_make_probes_of(s, 0, SSSI_COUNT(left));
        else sssi_make_probes_of(s, 0, 1);
    }
}

/* ---- Weights ---- */

/* The unit profiles at a hit, their mean g, and the intensity that every weight uses: expected hits
   per area and probe. All in inner units. */
typedef struct sssi_densities {
    float profile[3][SSS_LANES], target[SSS_LANES], mu[SSS_LANES];
} sssi_densities;

SSSI_FN sss_vec3 sssi_offset(const sss_resampler *s, sss_vec3 position) {
    return sssi_mul(sssi_sub(position, s->position), 1.0f / s->optics.unit);
}

/* mu += the part of the disks along one axis. */
SSSI_FN void sssi_add_disks(const sss_resampler *s, int dipole, int axis, int count,
                            const sssi_lanes *x, const sssi_lanes *n, float *mu) {
    for (int l = 0; l < count; ++l)
        mu[l] +=
            s->share[axis] * sssi_disk_intensity(s, dipole, axis, sssi_lane(x, l), sssi_lane(n, l));
}
SSSI_FN void sssi_find_densities(const sss_resampler *s, int dipole, int count, const sssi_lanes *x,
                                 const sssi_lanes *n, sssi_densities *d) {
    const sss_medium *m = &s->optics.medium;
    const float *mix = s->optics.mix;
    float ball = s->ball * s->ball;
    float *mu = d->mu;

    /* Techniques that a plan may lack. */
    for (int l = 0; l < count; ++l) mu[l] = 0.0f;
    if (s->share[SSSI_NORMAL] > 0.0f) sssi_add_disks(s, dipole, SSSI_NORMAL, count, x, n, mu);
    if (s->share[SSSI_TANGENT] > 0.0f) {
        sssi_add_disks(s, dipole, SSSI_TANGENT, count, x, n, mu);
        sssi_add_disks(s, dipole, SSSI_BITANGENT, count, x, n, mu);
    }
    if (s->share[SSSI_SPHERE] > 0.0f) {
        for (int l = 0; l < count; ++l)
            mu[l] +=
                s->share[SSSI_SPHERE] * sssi_sphere_intensity(s, sssi_lane(x, l), sssi_lane(n, l));
    }

    /* The profiles, and with them the chord, which goes beyond the ball. */
    for (int l = 0; l < count; ++l) {
        float r2 = sssi_dot(sssi_lane(x, l), sssi_lane(x, l));
        float red = sssi_unit_profile(m, dipole, 0, r2);
        float green = sssi_unit_profile(m, dipole, 1, r2);
        float blue = sssi_unit_profile(m, dipole, 2, r2);
        float g = mix[0] * red + mix[1] * green + mix[2] * blue;
        float proposal = dipole ? sssi_mean_proposal(s, 1, r2) : g;
        float within = r2 <= ball ? mu[l] : 0.0f;

        mu[l] = within + s->share[SSSI_CHORD] * sssi_chord_intensity(proposal);
        d->profile[0][l] = red;
        d->profile[1][l] = green;
        d->profile[2][l] = blue;
        d->target[l] = g;
    }
}
static inline float sss_intensity(const sss_resampler *s, sss_vec3 position,
                                  sss_vec3 geometric_normal) {
    if (!s->candidates || s->walks) return 0.0f;
    if (!sssi_finite(position) || !sssi_normalize(&geometric_normal)) return 0.0f;

    sssi_lanes x, n;
    sssi_densities d;
    sssi_set_lane(&x, 0, sssi_offset(s, position));
    sssi_set_lane(&n, 0, geometric_normal);
    if (s->optics.medium.dipole) sssi_find_densities(s, 1, 1, &x, &n, &d);
    else sssi_find_densities(s, 0, 1, &x, &n, &d);
    return d.mu[0] / (s->optics.unit * s->optics.unit);
}

/* ---- Pick ---- */

/* A uniform number u and v = 1 - u, both exact near 0. */
typedef struct sssi_chance {
    float u, v;
} sssi_chance;

SSSI_FN sssi_chance sssi_draw_chance(uint32_t key, int hit) {
    uint32_t high = sss_hash(key, 0x70000000u + (uint32_t)hit);
    uint32_t low = sss_hash(key, 0x78000000u + (uint32_t)hit);
    sssi_chance chance = {sssi_unit_fine(high, low), sssi_unit_fine(~high, ~low)};

    return chance;
}

/* One more hit comes to a reservoir: 1 if it is held from now on, with probability w / sum so far.
   Of u and v the one counts that is small for the rarer of the two outcomes, which so keeps its
   probability. */
SSSI_FN int sssi_offer(sssi_reservoir *r, float w, sssi_chance chance) {
    float before = r->weight;
    float sum = before + w;

    r->weight = sum;
    if (!(w > 0.0f)) return 0;
    return w < before ? chance.u * sum < w : !(chance.v * sum < before);
}

/* A candidate with the weight p, without its hint, comes to the reservoir that its probe feeds, or
   with per_channel to that of every live channel. Channels share the chance, so that grey media
   hold one hit. */
SSSI_FN void sssi_collect(sss_resampler *s, int reservoir, float p, sssi_chance chance,
                          const sssi_candidate *c) {
    float w = p * c->light;

    /* This is false for NaN too. */
    if (!(c->target >= SSSI_FAINT && w >= SSSI_TINY && p <= SSSI_HUGE)) return;

    if (reservoir == 0) s->reservoir[0].plain += p;
    if (!s->per_channel) {
        if (sssi_offer(&s->reservoir[reservoir], w, chance)) s->reservoir[reservoir].held = *c;
        return;
    }
    for (int i = 0; i < 3 && i < SSS_MAX_EXITS; ++i) {
        if (!(s->optics.mix[i] > 0.0f)) continue;
        if (sssi_offer(&s->reservoir[i], w * (c->profile[i] / c->target), chance))
            s->reservoir[i].held = *c;
    }
}

SSSI_FN void sssi_weigh_of(sss_resampler *s, int dipole, int count) {
    sssi_hits *h = &s->hits;
    sssi_lanes x, n;
    uint32_t key = s->key;
    float blur = s->blur;
    int weighed = s->weighed;

    for (int l = 0; l < count; ++l) {
        sss_vec3 normal = sssi_lane(&h->normal, l);

        sssi_normalize(&normal);
        sssi_set_lane(&n, l, normal);
        sssi_set_lane(&x, l, sssi_offset(s, sssi_lane(&h->position, l)));
    }
    sssi_densities d;
    sssi_find_densities(s, dipole, count, &x, &n, &d);

    float p[SSS_LANES], light[SSS_LANES];
    for (int l = 0; l < count; ++l) {
        float weight = d.target[l] / (d.mu[l] * (float)s->candidates);
        float v2;
        float distance =
            sssi_plane_distance(s, h->depth[l], sssi_lane(&x, l), sssi_lane(&n, l), &v2);

        /* What a line through o finds where its intensity is 0: see sssi_depth_intensity. */
        float least = h->depth[l] > 0.0f ? blur : -1.0f;

        p[l] = distance <= least ? 0.0f : weight;
        light[l] = sssi_min(sssi_max(h->light[l], SSSI_HINT_MIN), SSSI_HINT_MAX);
    }
    float u[SSS_LANES], v[SSS_LANES];
    for (int l = 0; l < count; ++l) {
        sssi_chance chance = sssi_draw_chance(key, weighed + l);

        u[l] = chance.u;
        v[l] = chance.v;
    }

    /* Each in its turn comes to its reservoir. */
    for (int l = 0; l < h->count; ++l) {
        sssi_chance chance = {u[l], v[l]};
        sssi_candidate hit;

        hit.position = sssi_lane(&h->position, l);
        hit.normal = sssi_lane(&n, l);
        for (int c = 0; c < 3; ++c) hit.profile[c] = d.profile[c][l];
        hit.target = d.target[l];
        hit.light = light[l];
        hit.hit = h->number[l];
        sssi_collect(s, h->reservoir[l], p[l], chance, &hit);
    }
    s->weighed += h->count;
    h->count = 0;
}

/* Weighs the hits that wait. */
SSSI_APART void sssi_weigh(sss_resampler *s) {
    int n = s->hits.count;

    if (s->optics.medium.dipole) {
        if (n > 1) sssi_weigh_of(s, 1, SSSI_COUNT(n));
        else sssi_weigh_of(s, 1, 1);
    } else {
        if (n > 1) sssi_weigh_of(s, 0, SSSI_COUNT(n));
        else sssi_weigh_of(s, 0, 1);
    }
}

/* ---- Walk [9]: each candidate is one random walk ---- */

/* A guard for renderers whose segments find no surface. It cuts less than 1e-4 of the light for
   albedos up to .999 and for bodies of up to 2000 mean free paths; a white half space loses
   5e-4. */
#define SSSI_MAX_SCATTERINGS 4194304

#define SSSI_LN_HALF (-0.69314718f)

/* A walk starts at the entry itself, but its first segment is traced only from a little inside on,
   so that it does not meet the surface where it starts: 8 ulp of the entry's coordinates, and at
   least 2^-13 and at most 1/4 mean free paths below the tangent plane. What scatters before needs
   no trace. */
#define SSSI_ULPS      9.5367432e-7f
#define SSSI_SKIN      1.2207031e-4f
#define SSSI_SKIN_MOST 0.25f
#define SSSI_START     64.0f /* skins within which a walk may see its own start */

/* A number in (0, 1) of this walk: 4 for each scattering. */
SSSI_FN float sssi_walk_number(const sss_resampler *s, uint32_t which) {
    return sssi_unit(sss_hash(s->walk.key, 4u * (uint32_t)s->walk.scatterings + which));
}

/* Where this walk stands in the lattice of all walks of the lookup, for its first numbers. */
SSSI_FN sssi_place sssi_walk_place(const sss_resampler *s) {
    sssi_place at = {0, 0u, 0.0f, 1.0f, 1.0f};

    if (s->independent) {
        at.name = (uint32_t)s->next << 10;
    } else {
        at.k = (float)(s->next - 1);
        at.n = (float)s->candidates;
        at.step = 1.0f / at.n;
    }
    return at;
}

/* What the walk carries in each channel after n scatterings and a path of the given length, in
   inner units: albedo^n times the density of the path over the mean of the channels' densities. At
   most the number of live channels. */
SSSI_FN void sssi_walk_weights(const sss_resampler *s, float path, float *weight) {
    const float *mix = s->optics.mix;
    const float *extinction = s->optics.medium.extinction;
    float n = (float)s->walk.scatterings;
    float density[3], most = -SSSI_FLT_MAX, mean = 0.0f;

    for (int c = 0; c < 3; ++c) {
        density[c] = n * s->walk.log_extinction[c] - (extinction[c] - extinction[0]) * path;
        if (mix[c] > 0.0f) most = sssi_max(most, density[c]);
    }
    for (int c = 0; c < 3; ++c) mean += mix[c] > 0.0f ? mix[c] * sssi_exp(density[c] - most) : 0.0f;
    for (int c = 0; c < 3; ++c) {
        float carried = n * s->walk.log_albedo[c] + s->walk.roulette + density[c] - most;

        weight[c] = mix[c] > 0.0f ? sssi_exp(carried) / mean : 0.0f;
    }
}

/* The next stretch: from the walk's position along a direction, up to the next scattering. */
SSSI_FN void sssi_walk_on(sss_resampler *s, sss_vec3 direction, float u) {
    s->walk.on = 1;
    s->walk.found = 0;
    s->walk.skip = 0.0f;
    s->walk.direction = direction;
    s->walk.length = -sssi_log(u) / s->walk.extinction;
}

/* Starts the next walk: its channel, its direction and its first stretch. */
SSSI_FN void sssi_walk_in(sss_resampler *s) {
    int live = 0;

    ++s->next;
    sssi_place at = sssi_walk_place(s);

    /* One channel draws all distances of this walk. */
    float u = sssi_number(s, at, SSSI_CHANNEL);
    int hero = sssi_class(&u, s->optics.live);
    for (int c = 0; c < 3; ++c) {
        if (!(s->optics.mix[c] > 0.0f)) continue;
        if (live == hero) s->walk.extinction = s->optics.medium.extinction[c];
        ++live;
    }

    /* A direction into the object with density cosine / pi. */
    float cosine2 = sssi_number(s, at, SSSI_COSINE);
    float sine = SSSI_SQRT(1.0f - cosine2);
    float sn, cs;
    sssi_sincos_turn(sssi_number(s, at, SSSI_TURN), &sn, &cs);
    sss_vec3 flat = sssi_add(sssi_mul(s->axis[SSSI_TANGENT], sine * cs),
                             sssi_mul(s->axis[SSSI_BITANGENT], sine * sn));
    sss_vec3 direction = sssi_sub(flat, sssi_mul(s->axis[SSSI_NORMAL], SSSI_SQRT(cosine2)));

    /* The trace begins a skin below the surface, or less where the cosine is below 1/16. */
    float ulps = SSSI_ULPS * (sssi_longest(s->position) / s->optics.unit);
    float skin = sssi_max(ulps, SSSI_SKIN / s->walk.extinction);
    skin = sssi_min(skin, SSSI_SKIN_MOST / s->walk.extinction);
    s->walk.skin = skin / sssi_max(SSSI_SQRT(cosine2), 0.0625f);

    s->walk.position = sssi_vec3(0.0f, 0.0f, 0.0f);
    s->walk.key = sss_hash(s->key, 0x20000000u + (uint32_t)s->next);
    s->walk.scatterings = 0;
    s->walk.path = s->walk.roulette = 0.0f;
    sssi_walk_on(s, direction, sssi_number(s, at, SSSI_RADIUS));
    s->walk.skip = s->walk.skin;
}

/* No surface on the segment: the walk scatters at its end. Russian roulette brings what its
   brightest channel may still carry, albedo^n over the chances so far, back to one half. What it
   carries now may be far less, and rise again: so the weights stay below the number of live
   channels. */
SSSI_FN void sssi_walk_scatter(sss_resampler *s) {
    sssi_walk *w = &s->walk;

    w->position = sssi_add(w->position, sssi_mul(w->direction, w->length));
    w->path += w->length;
    w->scatterings += 1;

    float carried = (float)w->scatterings * w->brightest + w->roulette;
    if (carried < SSSI_LN_HALF) {
        float chance = 2.0f * sssi_exp(carried);

        if (!(sssi_walk_number(s, 3u) < chance)) {
            w->on = 0;
            return;
        }
        w->roulette += SSSI_LN_HALF - carried;
    }
    w->on = w->scatterings < SSSI_MAX_SCATTERINGS;
    if (!w->on) return;

    /* A uniform direction. */
    float z = 2.0f * sssi_walk_number(s, 0u) - 1.0f;
    float rim = SSSI_SQRT((1.0f - z) * (1.0f + z));
    float sn, cs;
    sssi_sincos_turn(sssi_walk_number(s, 1u), &sn, &cs);
    sssi_walk_on(s, sssi_vec3(rim * cs, rim * sn, z), sssi_walk_number(s, 2u));
}

/* The walk leaves where its segment met the surface, and becomes a candidate. */
SSSI_FN void sssi_walk_out(sss_resampler *s) {
    sssi_candidate *hit = &s->walk.hit;

    s->walk.on = s->walk.found = 0;
    if (!(hit->light > 0.0f)) return;
    sssi_walk_weights(s, s->walk.path + s->walk.distance / s->optics.unit, hit->profile);
    hit->target = 0.0f;
    for (int c = 0; c < 3; ++c) hit->target += s->optics.mix[c] * hit->profile[c];
    sssi_collect(s, (s->next - 1) % s->exits, hit->target / (float)s->candidates,
                 sssi_draw_chance(s->key, s->next), hit);
}

/* The segment goes on behind its own start, each time by twice as much, so that it comes to an
   end. */
SSSI_FN void sssi_walk_past(sss_resampler *s) {
    sssi_walk *w = &s->walk;

    w->found = w->goes_on = 0;
    w->skip = sssi_max(w->skip, w->distance / s->optics.unit) + w->skin;
    w->skin *= 2.0f;
}

/* Ends or goes on with the walk under way, and starts the next one where it has ended. */
static inline int sssi_next_segment(sss_resampler *s, sss_probe *probe) {
    sssi_walk *w = &s->walk;

    if (w->found && w->goes_on) sssi_walk_past(s);
    else if (w->found) sssi_walk_out(s);
    else if (w->on) sssi_walk_scatter(s);

    /* Until there is a segment that needs a trace. */
    while (!w->on || w->length <= w->skip) {
        if (w->on) {
            sssi_walk_scatter(s);
        } else {
            if (s->next >= s->candidates) return 0;
            sssi_walk_in(s);
        }
    }
    sss_vec3 start = sssi_add(w->position, sssi_mul(w->direction, w->skip));
    probe->origin = sssi_add(s->position, sssi_mul(start, s->optics.unit));
    probe->direction = w->direction;
    probe->length = (w->length - w->skip) * s->optics.unit;
    return 1;
}

/* Keeps the nearest hit of the segment. A hit without light ends the walk too. An entry that lies a
   few roundings outside sees its own surface once more, from outside: there the segment goes on. */
static inline void sssi_hit_segment(sss_resampler *s, sss_vec3 position, sss_vec3 normal,
                                    float light, int hit) {
    sssi_walk *w = &s->walk;
    sss_vec3 start = sssi_add(s->position, sssi_mul(w->position, s->optics.unit));
    float along = sssi_dot(sssi_sub(position, start), w->direction);
    float distance = sssi_max(along, 0.0f);
    int is_start = w->scatterings == 0 && distance < SSSI_START * w->skin * s->optics.unit;

    if (!w->on || (w->found && !(distance < w->distance))) return;
    w->found = 1;
    w->goes_on = is_start && sssi_dot(normal, w->direction) < 0.0f;
    w->distance = distance;
    w->hit.position = position;
    w->hit.normal = normal;
    w->hit.hit = hit;
    sssi_normalize(&w->hit.normal);
    w->hit.light = 0.0f;
    if (light > 0.0f && light <= SSSI_FLT_MAX)
        w->hit.light = sssi_min(sssi_max(light, SSSI_HINT_MIN), SSSI_HINT_MAX);
}

/* ---- The loop ---- */

static inline int sss_next_probe(sss_resampler *s, sss_probe *probe) {
    if (s->walks) return sssi_next_segment(s, probe);

    while (s->next < s->candidates) {
        int l = (int)((uint32_t)s->next % SSS_LANES);

        if (l == 0) sssi_make_probes(s);
        ++s->next;
        if (!(s->probes.length[l] > 0.0f)) continue;
        probe->origin = sssi_lane(&s->probes.origin, l);
        probe->direction = sssi_lane(&s->probes.direction, l);
        probe->length = s->probes.length[l];
        return 1;
    }
    return 0;
}

static inline void sss_add_hit(sss_resampler *s, sss_vec3 position, sss_vec3 geometric_normal,
                               float light) {
    sssi_hits *h = &s->hits;
    int l = h->count;
    int number = s->calls++;

    if (!sssi_finite(position) || !sssi_finite(geometric_normal)) return;
    if (!(sssi_longest(geometric_normal) > 0.0f)) return;
    if (s->walks) {
        sssi_hit_segment(s, position, geometric_normal, light, number);
        return;
    }
    if (s->next == 0 || !(light > 0.0f && light <= SSSI_FLT_MAX)) return;

    sssi_set_lane(&h->position, l, position);
    sssi_set_lane(&h->normal, l, geometric_normal);
    h->light[l] = light;
    h->depth[l] = s->probes.depth[(uint32_t)(s->next - 1) % SSS_LANES];
    h->reservoir[l] = s->exits > 1 ? (s->next - 1) % s->exits : 0;
    h->number[l] = number;
    if (++h->count == SSS_LANES) sssi_weigh(s);
}

/* The entry itself, for Lambert channels. Beside live ones it stands in the first reservoir with
   the weight ratio * W / plain. Here ratio is the number of Lambert channels over that of live
   ones, W the sum of weights, and plain that without hints. The chance below follows. With
   per_channel it is an exit of its own. */
SSSI_FN int sssi_finish_lambert(const sss_resampler *s, float ratio, sss_exit *exit) {
    int alone = s->optics.live == 0 || s->per_channel;
    float chance = alone ? 1.0f : ratio / (ratio + s->reservoir[0].plain);

    if (!(sssi_unit(sss_hash(s->key, 0x60000000u)) < chance)) return 0;
    exit->position = s->position;
    exit->normal = s->axis[SSSI_NORMAL];
    exit->hit = -1;
    exit->mass = 0.0f;
    for (int c = 0; c < 3; ++c)
        exit->weight[c] = s->optics.mix[c] > 0.0f ? 0.0f : s->optics.medium.albedo[c] / chance;
    return 1;
}

/* An exit from what a reservoir holds. Its weights still lack the mass. */
SSSI_FN void sssi_set_exit(const sss_resampler *s, const sssi_candidate *held, float mass,
                           sss_exit *exit) {
    exit->position = held->position;
    exit->normal = held->normal;
    exit->hit = held->hit;
    exit->mass = mass;
    for (int c = 0; c < 3; ++c) {
        float albedo = s->walks ? 1.0f : s->optics.medium.albedo[c];
        float unit = albedo * (held->profile[c] / held->target);

        exit->weight[c] = s->optics.mix[c] > 0.0f ? unit : 0.0f;
    }
}

/* The exit before `count` with the same hit, or `count`. */
SSSI_FN int sssi_find_exit(const sss_exit *exits, int count, int hit) {
    for (int i = 0; i < count; ++i)
        if (exits[i].hit == hit) return i;
    return count;
}

static inline int sss_finish(sss_resampler *s, sss_exit *exits) {
    float ratio = s->optics.live ? (float)s->optics.lambert / (float)s->optics.live : 0.0f;
    int reservoirs = s->per_channel ? 3 : s->exits;
    int surface = 1, count = 0;

    if (s->walk.found) sssi_walk_out(s);
    if (s->hits.count) sssi_weigh(s);

    /* In the first reservoir the entry may be picked instead of a surface point. */
    if (s->optics.lambert && sssi_finish_lambert(s, ratio, &exits[0])) {
        count = 1;
        surface = s->per_channel;
    }

    for (int i = 0; i < reservoirs && i < SSS_MAX_EXITS; ++i) {
        const sssi_reservoir *r = &s->reservoir[i];
        if (!(r->weight > 0.0f) || (i == 0 && !surface)) continue;

        float mass = r->weight / r->held.light;
        if (s->per_channel) mass *= s->optics.mix[i];
        else if (i == 0 && s->optics.lambert) mass += mass * (ratio / r->plain);

        int e = sssi_find_exit(exits, count, r->held.hit);
        if (e < count) {
            exits[e].mass += mass;
            continue;
        }
        sssi_set_exit(s, &r->held, mass, &exits[count]);
        ++count;
    }

    /* The weights take their mass. A walk's exit then keeps none: it serves no other entry. */
    for (int i = 0; i < count; ++i) {
        if (exits[i].hit < 0) continue;
        for (int c = 0; c < 3; ++c) exits[i].weight[c] *= exits[i].mass;
        if (s->walks) exits[i].mass = 0.0f;
    }
    return count;
}

/* ---- Share [8] ---- */

static inline int sss_is_shared(const sss_medium *m, int channel, float spacing) {
    return sssi_is_live(m, channel) && 2.0f * m->length[channel] >= spacing;
}

/* The square of the distance of an exit from an entry. */
SSSI_FN float sssi_share_distance2(sss_vec3 exit, sss_vec3 entry, float scale) {
    sss_vec3 way = sssi_mul(sssi_sub(exit, entry), scale);

    return sssi_dot(way, way);
}

/* x, or 0 where it is NaN, infinite or not above 0: bad positions and black media make such
   numbers. */
SSSI_FN float sssi_sound(float x) { return x > 0.0f && x <= SSSI_FLT_MAX ? x : 0.0f; }

/* Unit profiles of one entry at an exit, 0 for channels that are not live, and their mean; in scene
   units. */
SSSI_FN float sssi_share_profile(const sss_medium *m, sss_vec3 entry, const sss_exit *exit,
                                 float *profile) {
    sssi_optics o = sssi_make_optics(m, 0u);
    float inverse = 1.0f / o.unit;
    float r2 = sssi_share_distance2(exit->position, entry, inverse);
    float target = 0.0f;

    for (int c = 0; c < 3; ++c) {
        float unit = o.live ? sssi_unit_profile(&o.medium, o.medium.dipole, c, r2) : 0.0f;

        target += o.mix[c] * unit;
        profile[c] = o.mix[c] > 0.0f ? unit * (inverse * inverse) : 0.0f;
    }
    return sssi_sound(target * (inverse * inverse));
}
static inline float sss_share_density(const sss_medium *m, sss_vec3 entry, const sss_exit *exit) {
    float profile[3];

    return sssi_share_profile(m, entry, exit, profile);
}
static inline void sss_share_weight(const sss_medium *m, sss_vec3 entry, const sss_exit *exit,
                                    float density_sum, float weight[3]) {
    sssi_share_profile(m, entry, exit, weight);
    for (int c = 0; c < 3; ++c)
        weight[c] = sssi_sound(m->albedo[c] * (weight[c] / density_sum) * exit->mass);
}

/* The first half of sss_share for entries with one medium, side by side: their unit profiles in
   scene units, and the sum of their targets in the order of the entries. */
SSSI_FN float sssi_share_profiles(const sss_exit *exit, const sss_entry *group, int count,
                                  int dipole, float (*profile)[3]) {
    sssi_optics o = sssi_make_optics(group[0].medium, 0u);
    float inverse = 1.0f / o.unit;
    float area = inverse * inverse;
    float r2[SSS_LANES], p[SSS_LANES], sum = 0.0f;
    sss_vec3 y = exit->position;
    sssi_lanes x;

    for (int i = 0; i < count; i += SSS_LANES) {
        int left = count - i;
        int here = left < SSS_LANES ? left : SSS_LANES;
        int lanes = SSSI_WIDE ? SSS_LANES : here;

        /* Lanes beyond the last entry repeat one. */
        for (int l = 0; l < lanes; ++l) sssi_set_lane(&x, l, group[l < here ? i + l : i].position);
        for (int l = 0; l < lanes; ++l) r2[l] = sssi_share_distance2(y, sssi_lane(&x, l), inverse);
        for (int c = 0; c < 3; ++c) {
            for (int l = 0; l < lanes; ++l) p[l] = sssi_unit_profile(&o.medium, dipole, c, r2[l]);
            for (int l = 0; l < here; ++l) profile[i + l][c] = p[l] * area;
        }
    }
    for (int i = 0; i < count; ++i) {
        float target = 0.0f;

        for (int c = 0; c < 3; ++c) target += o.mix[c] * profile[i][c];
        sum += sssi_sound(target);
    }
    return sum;
}

/* The second half: from profiles to weights. A channel that is not shared gets 0. */
SSSI_FN void sssi_share_weights(const sss_medium *m, int count, float spacing, float sum,
                                float mass, float (*weight)[3]) {
    float scale[3 * SSS_LANES];
    float *flat = weight[0];

    for (int l = 0; l < SSS_LANES; ++l)
        for (int c = 0; c < 3; ++c)
            scale[3 * l + c] = sss_is_shared(m, c, spacing) ? m->albedo[c] : 0.0f;

    for (int i = 0; i < 3 * count; i += 3 * SSS_LANES) {
        int left = 3 * count - i;
        int here = left < 3 * SSS_LANES ? left : 3 * SSS_LANES;

        for (int l = 0; l < here; ++l)
            flat[i + l] = sssi_sound(scale[l] * (flat[i + l] / sum) * mass);
    }
}

SSSI_APART void sssi_share_one(const sss_exit *exit, const sss_entry *group, int count,
                               float spacing, float (*weight)[3]) {
    const sss_medium *m = group[0].medium;
    float sum;

    if (m->dipole) sum = sssi_share_profiles(exit, group, count, 1, weight);
    else sum = sssi_share_profiles(exit, group, count, 0, weight);
    sssi_share_weights(m, count, spacing, sum, exit->mass, weight);
}

/* Each entry with its own medium. */
SSSI_FN void sssi_share_each(const sss_exit *exit, const sss_entry *group, int count, float spacing,
                             float (*weight)[3]) {
    float sum = 0.0f;

    for (int i = 0; i < count; ++i)
        sum += sssi_share_profile(group[i].medium, group[i].position, exit, weight[i]);
    for (int i = 0; i < count; ++i)
        sssi_share_weights(group[i].medium, 1, spacing, sum, exit->mass, &weight[i]);
}

static inline void sss_share(const sss_exit *exit, const sss_entry *group, int count, int own,
                             float spacing, float (*weight)[3]) {
    int one_medium = 1;
    int has_mass = exit->mass > 0.0f;

    for (int i = 0; i < count; ++i) {
        one_medium &= group[i].medium == group[0].medium;
        weight[i][0] = weight[i][1] = weight[i][2] = 0.0f;
    }
    if (has_mass && count > 0) {
        if (one_medium) sssi_share_one(exit, group, count, spacing, weight);
        else sssi_share_each(exit, group, count, spacing, weight);
    }

    /* What is not shared stays with its own entry. */
    if (own < 0 || own >= count) return;
    for (int c = 0; c < 3; ++c)
        if (!has_mass || !sss_is_shared(group[own].medium, c, spacing))
            weight[own][c] = exit->weight[c];
}

/* ---- Plan ---- */

/* The relative error of the flat profile against a walk through the volume, where the largest ball
   that touches the surface has this radius over the dmfp. 1 where nothing is known of the radius
   (0), 0 on a plane. Fitted to balls, slabs, cylinders, spheroids, edges and corners that are lit
   from everywhere, from the front and from behind (demos/study/model_error.c). In 3 % of other
   cases the error exceeds a tolerance unnoticed; in 13 % the walk is asked for without need. */
SSSI_FN float sssi_profile_error(float albedo, float radius_over_dmfp) {
    float u = 0.75f * radius_over_dmfp / sssi_max(1.0f - albedo, 0.05f);

    return 1.0f / (1.0f + u * SSSI_SQRT(SSSI_SQRT(u)));
}

/* 1 / dmfp of a live channel. */
SSSI_FN float sssi_decay(const sss_medium *m, int c) {
    return m->dipole ? m->sigma[c] : 1.0f / (m->length[c] * sssi_burley_scale(m->albedo[c]));
}

/* Sharing over 8 x 8 pixels pays where the widest channel is at least one and a half pixels long.
   A disk on a flat surface has the noise of the light alone, so there is less to share away: there
   from four pixels on (demos/study/mesh_share.c, tile.c, chart.c). */
SSSI_FN int sssi_plan_tile(const sss_medium *m, float footprint, int is_flat) {
    float least = (is_flat ? 4.0f : 1.5f) * footprint;
    int pays = 0;

    for (int c = 0; c < 3; ++c)
        if (footprint > 0.0f && sssi_is_live(m, c) && m->length[c] >= least) pays = 1;
    return pays ? 8 : 0;
}

/* The variance of M candidates is about V (1 + k / M). k is 2 where the light about the entry
   varies, and some 12 where it does not: with hints, or where the medium is too narrow for a tile.
   Where all channels are shared few candidates do, as with k = 2. The best M is sqrt(k C). C is the
   cost of shading plus two probes for the rest of the lookup. The least power of two whose square
   reaches k C / 2 is the nearest to it. */
SSSI_FN int sssi_plan_candidates(const sss_medium *m, const sss_need *need, int tile) {
    float worth = need->shading_cost + 2.0f;
    int is_calm = need->hinted || (need->footprint > 0.0f && tile == 0);
    int all_shared = tile != 0;
    int candidates = 2;

    for (int c = 0; c < 3; ++c)
        if (sssi_is_live(m, c) && !sss_is_shared(m, c, need->footprint)) all_shared = 0;
    if (is_calm && !all_shared) worth *= 6.0f;

    while (2 * candidates <= SSS_MAX_CANDIDATES && (float)(candidates * candidates) < worth)
        candidates *= 2;
    return candidates;
}

/* An exit for each colour takes a third of the variance away where colours differ, and pays while
   shading an exit costs no more than the lookup's probes. */
SSSI_FN int sssi_plan_colours(const sss_medium *m, float cost, int candidates) {
    float shortest = SSSI_FLT_MAX, longest = 0.0f;
    int room = SSS_MAX_EXITS;

    for (int c = 0; c < 3; ++c) {
        if (!sssi_is_live(m, c)) continue;
        shortest = sssi_min(shortest, m->length[c]);
        longest = sssi_max(longest, m->length[c]);
    }
    return room >= 3 && longest > 1.5f * shortest && cost <= (float)candidates;
}

static inline sss_plan sss_plan_for(const sss_medium *m, const sss_need *need) {
    sss_plan plan = {0, 0, 0u, 0, 0, 0};
    float r = sssi_max(need->curvature_radius, 0.0f);
    float tolerance = need->tolerance > 0.0f ? need->tolerance : 0.1f;
    float cost = sssi_max(need->shading_cost, 0.0f);
    float error = 0.0f, light = 0.0f;
    int live = 0;

    /* The error of the profile, all channels weighed by the light that they carry. */
    for (int c = 0; c < 3; ++c) {
        light += m->albedo[c];
        if (!sssi_is_live(m, c)) continue;
        live += 1;
        error += m->albedo[c] * sssi_profile_error(m->albedo[c], r * sssi_decay(m, c));
    }

    if (live == 0) plan.techniques = SSS_LAMBERT;
    else if (error > tolerance * light) plan.techniques = SSS_WALK;
    else if (need->footprint * tolerance > 0.05f * m->r_max) plan.techniques = SSS_LAMBERT;
    else if (r >= m->r_max) plan.techniques = SSS_DISK;

    /* One walk, with hints or without: a second costs as much as the first, and takes less of
       the noise away than the next sample does (demos/study/chart.c). */
    if (plan.techniques == SSS_WALK) plan.candidates = 1;
    if (plan.techniques == SSS_WALK || plan.techniques == SSS_LAMBERT) return plan;

    plan.tile = sssi_plan_tile(m, need->footprint, plan.techniques == SSS_DISK);
    if (plan.techniques == SSS_DISK) {
        plan.candidates = 1;
        return plan;
    }
    if (cost > 0.0f) plan.candidates = sssi_plan_candidates(m, need, plan.tile);
    plan.per_channel = sssi_plan_colours(m, cost, plan.candidates ? plan.candidates : 8);
    return plan;
}

SSSI_END_OF_MATHS

#endif /* SSS_RESAMPLE_H */
