// model_bodies.h - analytic bodies in double precision, a random walk through their volume, what a
// flat profile says of them, and how far it is off: for model_error.c and tests/test_plan_model.c.
// Host only. SPDX-License-Identifier: MIT
//
// Nothing here comes from sss_resample.h or from the demos' tracer. The medium is homogeneous,
// scatters isotropically and has no boundary of its own (matched indices).
#ifndef MODEL_BODIES_H
#define MODEL_BODIES_H

#include <math.h>
#include <stdint.h>

#define BODY_PI     3.14159265358979323846
#define BODY_SHAPES 2

// ---- Vectors and random numbers

typedef struct body_vec {
    double x, y, z;
} body_vec;

static inline body_vec body_make(double x, double y, double z) {
    body_vec v = {x, y, z};
    return v;
}

static inline double body_dot(body_vec a, body_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline body_vec body_along(body_vec o, body_vec d, double t) {
    return body_make(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
}

static inline body_vec body_unit(body_vec v) {
    double k = 1.0 / sqrt(body_dot(v, v));
    return body_make(k * v.x, k * v.y, k * v.z);
}

// splitmix64; a number in (0, 1).
static inline double body_random(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return ((double)(z >> 11) + 0.5) * 0x1p-53;
}

// A point of the unit disk, by rejection.
static inline void body_disk(uint64_t *state, double *x, double *y, double *square) {
    do {
        *x = 2.0 * body_random(state) - 1.0;
        *y = 2.0 * body_random(state) - 1.0;
        *square = *x * *x + *y * *y;
    } while (*square > 1.0);
}

static inline body_vec body_isotropic(uint64_t *state) {
    double x, y, s;
    body_disk(state, &x, &y, &s);
    double k = 2.0 * sqrt(1.0 - s);
    return body_make(k * x, k * y, 1.0 - 2.0 * s);
}

// ---- Bodies

// Convex: the points with sum (inverse_i p_i)^2 < 1 (an ellipsoid, an endless cylinder where one
// inverse is 0, a slab where two are), or the box between two corners, either of them endless.
typedef struct body_shape {
    int is_box;
    double inverse[3], low[3], high[3];
} body_shape;

// The union of its shapes, and the point of its surface that the camera sees.
typedef struct body_solid {
    int count;
    body_shape shape[BODY_SHAPES];
    body_vec entry, normal;
} body_solid;

static inline void body_interval(const body_shape *s, body_vec o, body_vec d, double *t0,
                                 double *t1) {
    double p[3] = {o.x, o.y, o.z}, v[3] = {d.x, d.y, d.z};

    if (s->is_box) {
        *t0 = (double)-INFINITY;
        *t1 = (double)INFINITY;
        for (int i = 0; i < 3; i++) {
            if (v[i] == 0.0) {
                if (p[i] < s->low[i] || p[i] > s->high[i]) *t1 = (double)-INFINITY;
                continue;
            }
            double a = (s->low[i] - p[i]) / v[i], b = (s->high[i] - p[i]) / v[i];
            *t0 = fmax(*t0, fmin(a, b));
            *t1 = fmin(*t1, fmax(a, b));
        }
        return;
    }

    double vv = 0.0, pv = 0.0, pp = 0.0;
    for (int i = 0; i < 3; i++) {
        double q = p[i] * s->inverse[i], w = v[i] * s->inverse[i];
        vv += w * w;
        pv += q * w;
        pp += q * q;
    }
    double inside = pv * pv - vv * (pp - 1.0);
    if (vv < 1e-300 || inside <= 0.0) {
        *t0 = pp < 1.0 && vv < 1e-300 ? (double)-INFINITY : (double)INFINITY;
        *t1 = -*t0;
        return;
    }
    *t0 = (-pv - sqrt(inside)) / vv;
    *t1 = (-pv + sqrt(inside)) / vv;
}

static inline body_vec body_normal(const body_shape *s, body_vec at) {
    double p[3] = {at.x, at.y, at.z}, n[3] = {0.0, 0.0, 0.0}, nearest = (double)INFINITY;

    for (int i = 0; i < 3; i++) {
        if (!s->is_box) {
            n[i] = p[i] * s->inverse[i] * s->inverse[i];
            continue;
        }
        for (int side = -1; side <= 1; side += 2) {
            double gap = fabs(p[i] - (side < 0 ? s->low[i] : s->high[i]));
            if (!(gap < nearest)) continue;
            nearest = gap;
            n[0] = n[1] = n[2] = 0.0;
            n[i] = side;
        }
    }
    return body_unit(body_make(n[0], n[1], n[2]));
}

// ---- Light

// From everywhere alike, or a lamp far away. A plane that faces it gets irradiance 1.
typedef struct body_light {
    int everywhere;
    body_vec towards;
} body_light;

static inline double body_irradiance(const body_solid *b, const body_light *light, int shape,
                                     body_vec at) {
    if (light->everywhere) return 1.0;

    double cosine = body_dot(body_normal(&b->shape[shape], at), light->towards);
    if (cosine <= 0.0) return 0.0;
    for (int i = 0; i < b->count; i++) {
        double t0, t1;
        if (i == shape) continue;
        body_interval(&b->shape[i], at, light->towards, &t0, &t1);
        if (t0 < t1 && t1 > 1e-9) return 0.0;
    }
    return cosine;
}

// ---- The volume

typedef struct body_volume {
    double albedo, extinction; // of a single scattering; 1/length
} body_volume;

// The half space with diffuse albedo A whose light falls off as e^(-r / dmfp): Chandrasekhar's H
// function (a rational fit, good to 1e-6) and Grosjean's diffusion.
static inline body_volume body_volume_of(double albedo, double dmfp) {
    double low = 0.0, high = 1.0;
    body_volume v;
    for (int i = 0; i < 60; i++) {
        double s = 0.5 * (low + high);
        double a = (1.0 - s) * (1.0 + s * (0.38313089 - 0.00319767 * s)) /
                   (1.0 + s * (1.69256344 + 0.6802289 * s));
        if (a > albedo) low = s;
        else high = s;
    }
    v.albedo = 1.0 - low * low;
    v.extinction = 1.0 / (dmfp * sqrt(3.0 * low * low / (1.0 + low * low)));
    return v;
}

// How far a ray goes inside the body, at most `want`. *shape: the one that it is in, or leaves.
static inline double body_reach(const body_solid *b, body_vec x, body_vec d, double want,
                                int *shape) {
    double t0, t1;
    body_interval(&b->shape[*shape], x, d, &t0, &t1);
    double reach = fmax(t1, 0.0);
    for (int i = 0; i < b->count && reach < want; i++) {
        if (i == *shape) continue;
        body_interval(&b->shape[i], x, d, &t0, &t1);
        if (!(t0 <= reach && t1 > reach)) continue;
        reach = t1;
        *shape = i;
        i = -1;
    }
    return reach < want ? reach : want;
}

// Values that are summed up, their mean and its standard error.
typedef struct body_sum {
    double count, sum, squares;
} body_sum;

static inline void body_add(body_sum *s, double value) {
    s->count += 1.0;
    s->sum += value;
    s->squares += value * value;
}

static inline double body_mean(const body_sum *s) { return s->sum / s->count; }

static inline double body_error(const body_sum *s) {
    double mean = body_mean(s);
    return sqrt(fmax(s->squares / s->count - mean * mean, 0.0) / s->count);
}

// One walk from the entry, in a cosine-distributed direction. 1, its weight, and where it leaves;
// 0 when it is absorbed.
static inline int body_walk(const body_solid *b, const body_volume *v, uint64_t *random,
                            body_vec *at, int *shape, double *weight) {
    body_vec x = b->entry, d = body_isotropic(random);
    *shape = 0;
    *weight = 1.0;
    // A point of the unit sphere around the normal's end is cosine-distributed about it.
    d = body_unit(body_along(d, b->normal, -1.0));
    for (;;) {
        double want = -log(body_random(random)) / v->extinction;
        double reach = body_reach(b, x, d, want, shape);
        x = body_along(x, d, reach);
        if (reach < want) {
            *at = x;
            return 1;
        }
        *weight *= v->albedo;
        if (*weight < 0.25) {
            if (body_random(random) >= 2.0 * *weight) return 0;
            *weight = 0.5;
        }
        d = body_isotropic(random);
    }
}

// The light that leaves at the entry, over that of a white plane that faces the lamp.
static inline void body_by_walk(const body_solid *b, const body_volume *v, const body_light *light,
                                int walks, uint64_t *random, body_sum *sum) {
    for (int i = 0; i < walks; i++) {
        body_vec at;
        int shape;
        double weight, value = 0.0;
        if (body_walk(b, v, random, &at, &shape, &weight))
            value = weight * body_irradiance(b, light, shape, at);
        body_add(sum, value);
    }
}

// ---- The flat profile

// Christensen and Burley 2015, eq. 8: the shape's length for a diffuse mean free path of 1.
static inline double body_burley_length(double albedo) {
    double x = (albedo - 0.33) * (albedo - 0.33);
    return 1.0 / (3.5 + 100.0 * x * x);
}

// The same by Burley's profile: the integral over the surface of Rd times irradiance. A segment
// between two random points of a sphere about the entry, whose radius has the right distribution,
// meets each part of the surface with intensity Rd / 2A, whichever way it faces.
static inline void body_by_burley(const body_solid *b, double albedo, double dmfp,
                                  const body_light *light, int chords, uint64_t *random,
                                  body_sum *sum) {
    double d = dmfp * body_burley_length(albedo);

    for (int i = 0; i < chords; i++) {
        double scale = body_random(random) < 0.25 ? d : 3.0 * d;
        double radius = -scale * log(body_random(random));
        if (body_random(random) < 0.5) radius -= scale * log(body_random(random));

        body_vec from = body_along(b->entry, body_isotropic(random), radius);
        body_vec to = body_along(b->entry, body_isotropic(random), radius);
        body_vec chord = body_along(to, from, -1.0);
        double end[BODY_SHAPES][2], value = 0.0;
        for (int k = 0; k < b->count; k++)
            body_interval(&b->shape[k], from, chord, &end[k][0], &end[k][1]);

        for (int k = 0; k < 2 * b->count; k++) {
            int own = k >> 1, other = 1 - own;
            double t = end[own][k & 1];
            if (!(end[own][0] < end[own][1] && t > 0.0 && t < 1.0)) continue;
            if (b->count == 2 && t > end[other][0] && t < end[other][1]) continue;
            value += 2.0 * albedo * body_irradiance(b, light, own, body_along(from, chord, t));
        }
        body_add(sum, value);
    }
}

// ---- Random cases

enum { BODY_BALL, BODY_SLAB, BODY_CYLINDER, BODY_SPHEROID, BODY_EDGE, BODY_CORNER, BODY_KINDS };
enum { BODY_EVERYWHERE, BODY_FRONT, BODY_BEHIND, BODY_LIGHTS }; // as seen by the camera

// An entry, a light and a medium: what a plan is asked about.
typedef struct body_case {
    int kind, light_kind, grey;
    body_solid b;
    body_light light;
    double albedo[3], dmfp[3];
} body_case;

// Its entry is its highest point, and the radius of curvature there, or half the thickness, is 1.
static inline body_solid body_quadric(double inverse_x, double inverse_y, double inverse_z) {
    body_shape shape = {0, {inverse_x, inverse_y, inverse_z}, {0.0}, {0.0}};
    body_solid b = {1, {shape, shape}, {0.0, 0.0, 1.0 / inverse_z}, {0.0, 0.0, 1.0}};
    return b;
}

// Solid below z = 0, and cut off at x = 1, or with a wall on it that begins at x = -1.
static inline body_solid body_right_angle(int inside) {
    const double far = (double)INFINITY;
    body_shape ground = {1, {0.0}, {-far, -far, -far}, {inside ? far : 1.0, far, 0.0}};
    body_shape wall = {1, {0.0}, {-far, -far, -far}, {-1.0, far, far}};
    body_solid b = {inside ? 2 : 1, {ground, wall}, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
    return b;
}

// A spheroid of a smallest radius 1, from three times as long to three times as wide.
static inline body_solid body_spheroid(double u) {
    double wide = 1.0, high = pow(3.0, 2.0 * u - 1.0), least = fmin(high, wide * wide / high);
    return body_quadric(least / wide, least / wide, least / high);
}

// A lamp: its height is uniform, so each direction is as likely. It shines on one side of an edge
// where it is behind, and never from inside the wall of a corner.
static inline void body_random_lamp(body_case *c, uint64_t *random) {
    double height = body_random(random), turn = 2.0 * BODY_PI * body_random(random);
    if (c->kind == BODY_EDGE || c->kind == BODY_CORNER) turn = 0.45 * (turn - BODY_PI);
    if (c->kind == BODY_EDGE && c->light_kind == BODY_BEHIND) height *= 0.8;
    if (c->light_kind == BODY_BEHIND) height = -height;

    double side = sqrt(1.0 - height * height);
    c->light.everywhere = 0;
    c->light.towards = body_make(side * cos(turn), side * sin(turn), height);
}

// dmfps so that the radius 1 is .01 to 30 of the longest; one medium in three is grey.
static inline void body_random_medium(body_case *c, uint64_t *random) {
    c->grey = body_random(random) < 1.0 / 3.0;
    for (int i = 0; i < 3; i++) {
        int copy = c->grey && i > 0;
        c->albedo[i] = copy ? c->albedo[0] : 0.05 + 0.94 * body_random(random);
        c->dmfp[i] = i == 0 ? 100.0 / pow(3000.0, body_random(random))
                            : c->dmfp[0] * (copy ? 1.0 : pow(0.2, body_random(random)));
    }
}

static inline body_case body_random_case(uint64_t seed) {
    uint64_t random = seed << 32;
    body_case c;
    c.kind = (int)(BODY_KINDS * body_random(&random));
    c.light_kind = (int)(BODY_LIGHTS * body_random(&random));
    if (c.kind == BODY_CORNER && c.light_kind == BODY_BEHIND) c.light_kind = BODY_FRONT;

    if (c.kind == BODY_BALL) c.b = body_quadric(1.0, 1.0, 1.0);
    else if (c.kind == BODY_SLAB) c.b = body_quadric(0.0, 0.0, 1.0);
    else if (c.kind == BODY_CYLINDER) c.b = body_quadric(1.0, 0.0, 1.0);
    else if (c.kind == BODY_SPHEROID) c.b = body_spheroid(body_random(&random));
    else c.b = body_right_angle(c.kind == BODY_CORNER);

    c.light.everywhere = 1;
    c.light.towards = c.b.normal;
    if (c.light_kind != BODY_EVERYWHERE) body_random_lamp(&c, &random);
    body_random_medium(&c, &random);
    return c;
}

// ---- The error of the profile

// Below this part of what a plane gives that faces the lamp, an error counts as if the walk gave
// that part. CIE lightness is linear near black: an absolute error of t / 25 there is the same step
// as the relative error t in full light (.045 / t to .041 / t for t from .5 to .02).
#define BODY_DARK (1.0 / 25.0)

// |profile - walk| / max(walk, BODY_DARK A) of a channel, and its standard error.
static inline double body_channel_error(const body_case *c, int channel, int walks,
                                        uint64_t *random, body_sum sum[2], double *error) {
    double albedo = c->albedo[channel], dmfp = c->dmfp[channel];
    body_volume v = body_volume_of(albedo, dmfp);
    body_by_walk(&c->b, &v, &c->light, walks, random, &sum[0]);
    body_by_burley(&c->b, albedo, dmfp, &c->light, 2 * walks, random, &sum[1]);

    double walk = body_mean(&sum[0]), dark = fmax(walk, BODY_DARK * albedo);
    *error = hypot(body_error(&sum[0]), body_error(&sum[1])) / dark;
    return fabs(body_mean(&sum[1]) - walk) / dark;
}

// The mean over the channels, weighed by the light that they carry, and its standard error.
// Twice as many walks until the standard error is at most `fine`, or a third of the distance to
// the next of the given limits; 2^17 walks in a channel are the most.
static inline double body_case_error(const body_case *c, uint64_t seed, double fine,
                                     const double *limit, int limits, double *error) {
    uint64_t random = seed << 32 ^ 0x5bd1e995u;
    body_sum none = {0.0, 0.0, 0.0}, sum[3][2] = {{none, none}, {none, none}, {none, none}};
    double mean, nearest;
    int walks = 2000;
    do {
        double light = 0.0, variance = 0.0;
        mean = 0.0;
        for (int i = 0; i < (c->grey ? 1 : 3); i++) {
            double own, value = body_channel_error(c, i, walks, &random, sum[i], &own);
            light += c->albedo[i];
            mean += c->albedo[i] * value;
            variance += c->albedo[i] * c->albedo[i] * own * own;
        }
        mean /= light;
        *error = sqrt(variance) / light;
        nearest = (double)INFINITY;
        for (int i = 0; i < limits; i++) nearest = fmin(nearest, fabs(mean - limit[i]));
        walks *= 2;
    } while (walks <= 1 << 16 && *error > fine && *error > nearest / 3.0);
    return mean;
}

#endif
