// model_bodies.h - analytic bodies in double precision, a random walk through their volume, and
// what a flat profile says of them: the truth and the model of model_error.c and of
// tests/test_plan_model.c. Host only. SPDX-License-Identifier: MIT
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
typedef struct body {
    int count;
    body_shape shape[BODY_SHAPES];
    body_vec entry, normal;
    double radius; // of curvature, or half the thickness, or how far the surface is flat
} body;

static inline void body_interval(const body_shape *s, body_vec o, body_vec d, double *t0, double *t1) {
    double p[3] = {o.x, o.y, o.z}, v[3] = {d.x, d.y, d.z};

    if (s->is_box) {
        *t0 = -INFINITY;
        *t1 = INFINITY;
        for (int i = 0; i < 3; i++) {
            if (v[i] == 0.0) {
                if (p[i] < s->low[i] || p[i] > s->high[i]) *t1 = -INFINITY;
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
        *t0 = pp < 1.0 && vv < 1e-300 ? -INFINITY : INFINITY;
        *t1 = -*t0;
        return;
    }
    *t0 = (-pv - sqrt(inside)) / vv;
    *t1 = (-pv + sqrt(inside)) / vv;
}

static inline body_vec body_normal(const body_shape *s, body_vec at) {
    double p[3] = {at.x, at.y, at.z}, n[3] = {0.0, 0.0, 0.0}, nearest = INFINITY;

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

static inline double body_irradiance(const body *b, const body_light *light, int shape, body_vec at) {
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
static inline double body_reach(const body *b, body_vec x, body_vec d, double want, int *shape) {
    double t0, t1, reach;
    body_interval(&b->shape[*shape], x, d, &t0, &t1);
    reach = fmax(t1, 0.0);
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

// A mean and its standard error.
typedef struct body_mean {
    double mean, error;
} body_mean;

static inline body_mean body_mean_of(double sum, double squares, int count) {
    body_mean m = {sum / count, 0.0};
    m.error = sqrt(fmax(squares / count - m.mean * m.mean, 0.0) / count);
    return m;
}

// One walk from the entry, in a cosine-distributed direction. 1, its weight, and where it leaves;
// 0 when it is absorbed.
static inline int body_walk(const body *b, const body_volume *v, uint64_t *random, body_vec *at, int *shape,
                            double *weight) {
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
static inline void body_by_walk(const body *b, const body_volume *v, const body_light *light, int lights,
                                int walks, uint64_t seed, body_mean *result) {
    double sum[16] = {0.0}, squares[16] = {0.0};
    for (int i = 0; i < walks; i++) {
        body_vec at;
        int shape;
        double weight;
        if (!body_walk(b, v, &seed, &at, &shape, &weight)) continue;
        for (int l = 0; l < lights; l++) {
            double value = weight * body_irradiance(b, &light[l], shape, at);
            sum[l] += value;
            squares[l] += value * value;
        }
    }
    for (int l = 0; l < lights; l++) result[l] = body_mean_of(sum[l], squares[l], walks);
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
static inline void body_by_burley(const body *b, double albedo, double dmfp, const body_light *light,
                                  int lights, int chords, uint64_t seed, body_mean *result) {
    double sum[16] = {0.0}, squares[16] = {0.0}, d = dmfp * body_burley_length(albedo);
    for (int i = 0; i < chords; i++) {
        double scale = body_random(&seed) < 0.25 ? d : 3.0 * d, value[16] = {0.0};
        double rho = -scale * log(body_random(&seed));
        if (body_random(&seed) < 0.5) rho -= scale * log(body_random(&seed));

        body_vec p = body_along(b->entry, body_isotropic(&seed), rho);
        body_vec q = body_along(b->entry, body_isotropic(&seed), rho), pq = body_along(q, p, -1.0);
        double ends[BODY_SHAPES][2];
        for (int s = 0; s < b->count; s++) body_interval(&b->shape[s], p, pq, &ends[s][0], &ends[s][1]);
        for (int k = 0; k < 2 * b->count; k++) {
            int s = k >> 1, other = 1 - s;
            double t = ends[s][k & 1];
            if (!(ends[s][0] < ends[s][1] && t > 0.0 && t < 1.0)) continue;
            if (b->count == 2 && t > ends[other][0] && t < ends[other][1]) continue;
            body_vec at = body_along(p, pq, t);
            for (int l = 0; l < lights; l++)
                value[l] += 2.0 * albedo * body_irradiance(b, &light[l], s, at);
        }
        for (int l = 0; l < lights; l++) {
            sum[l] += value[l];
            squares[l] += value[l] * value[l];
        }
    }
    for (int l = 0; l < lights; l++) result[l] = body_mean_of(sum[l], squares[l], chords);
}

#endif
