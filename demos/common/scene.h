// scene.h - exact scenes of convex shapes, one text for C99, C++11 and OpenCL C 1.2.
// SPDX-License-Identifier: MIT
//
// The translucent object is a union of convex shapes (ellipsoids and rounded boxes) above a floor,
// y = 0. A line meets a convex shape in one interval, and the boundary of the union is made of
// those interval ends that lie inside no other interval: every hit is exact and found without
// marching, and no epsilon says what is a hit and what is not. A ray that leaves a shape outwards
// cannot meet that convex shape again, so self hits are left out by shape number.
//
// Lengths are in scene units, y is up. Radiance is linear RGB. The object's optics are one
// sss_medium.
#ifndef SCENE_H
#define SCENE_H

#include "sss_resample.h"

// The one place that knows languages: a scene lives in host memory or in the device's global
// memory, what a tile of paths shares (tracer.h) in that of a work-group.
#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define SCENE_SPACE       __global
#define TRACER_TILE_SPACE __local
static inline float scene_sqrt(float x) { return sqrt(x); }
static inline float scene_abs(float x) { return fabs(x); }
#else
#define SCENE_SPACE
#define TRACER_TILE_SPACE
static inline float scene_sqrt(float x) { return sqrtf(x); }
static inline float scene_abs(float x) { return fabsf(x); }
#endif

#define SCENE_MAX_SHAPES 20
#define SCENE_MAX_FOUND  (SSS_MAX_CANDIDATES * 2 * SCENE_MAX_SHAPES) // hits in a lookup
#define SCENE_PI         3.14159265358979f

enum { SCENE_ELLIPSOID = 0, SCENE_ROUNDED_BOX = 1 };
enum { SCENE_FLOOR = -1, SCENE_NOTHING = -2 }; // in place of a shape number

typedef struct scene_shape {
    int kind;
    float rounding; // rounded box: radius of its edges, > 0 and at most the smallest extent
    float area; // of the whole shape; only for choosing among shapes, so near enough is good enough
    sss_vec3 center;
    sss_vec3 axis[3];        // orthonormal
    sss_vec3 extent;         // half sizes along the axes, rounding included
    sss_vec3 inverse_extent; // 1 / extent
} scene_shape;

// A rectangle that shines to the side of its normal. It is felt through next-event estimation only:
// rays pass through.
typedef struct scene_light {
    sss_vec3 center, u, v; // u and v: half edges
    sss_vec3 normal;       // unit length
    sss_vec3 radiance;
    float area, radius; // radius: of the disk of that area
} scene_light;

typedef struct scene {
    int shape_count;
    scene_shape shape[SCENE_MAX_SHAPES];
    sss_medium medium;
    scene_light light;
    sss_vec3 sky_horizon, sky_zenith; // radiance, linear in the height of the direction
    sss_vec3 floor_albedo;
    float floor_lit;       // rough share of the floor around the object that the light reaches
    sss_vec3 eye, forward; // forward is of unit length
    sss_vec3 right, up;    // they reach the edge of the central square
} scene;

typedef struct scene_interval {
    float t0, t1;
} scene_interval; // empty: t0 > t1

typedef struct scene_hit {
    float t;
    int shape;
} scene_hit;

// Every crossing of one segment with the boundary of the object, nearest first.
typedef struct scene_hits {
    int count;
    scene_hit hit[2 * SCENE_MAX_SHAPES];
} scene_hits;

static inline sss_vec3 scene_vec(float x, float y, float z) {
    sss_vec3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
static inline sss_vec3 scene_add(sss_vec3 a, sss_vec3 b) {
    return scene_vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline sss_vec3 scene_sub(sss_vec3 a, sss_vec3 b) {
    return scene_vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline sss_vec3 scene_mul(sss_vec3 a, sss_vec3 b) {
    return scene_vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline sss_vec3 scene_scale(sss_vec3 a, float s) {
    return scene_vec(a.x * s, a.y * s, a.z * s);
}
static inline float scene_dot(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline sss_vec3 scene_cross(sss_vec3 a, sss_vec3 b) {
    return scene_vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline sss_vec3 scene_normalize(sss_vec3 a) {
    return scene_scale(a, 1.0f / scene_sqrt(scene_dot(a, a)));
}
static inline float scene_mean(sss_vec3 a) { return (a.x + a.y + a.z) * (1.0f / 3.0f); }
static inline float scene_min(float a, float b) { return a < b ? a : b; }
static inline float scene_max(float a, float b) { return a > b ? a : b; }
static inline sss_vec3 scene_along(sss_vec3 origin, sss_vec3 direction, float t) {
    return scene_add(origin, scene_scale(direction, t));
}

// A world vector in the axes of a shape, and back.
static inline sss_vec3 scene_to_local(const SCENE_SPACE scene_shape *s, sss_vec3 v) {
    return scene_vec(scene_dot(s->axis[0], v), scene_dot(s->axis[1], v), scene_dot(s->axis[2], v));
}
static inline sss_vec3 scene_to_world(const SCENE_SPACE scene_shape *s, sss_vec3 v) {
    return scene_add(scene_add(scene_scale(s->axis[0], v.x), scene_scale(s->axis[1], v.y)),
                     scene_scale(s->axis[2], v.z));
}

static inline scene_interval scene_make_interval(float t0, float t1) {
    scene_interval i;
    i.t0 = t0;
    i.t1 = t1;
    return i;
}

// Ellipsoid: a unit sphere after a linear map. The distance of the line from the centre is formed
// as a vector before it is squared, so that a thin ellipsoid far from the origin of the ray loses
// no digits to cancellation.
static inline scene_interval scene_ellipsoid_interval(const SCENE_SPACE scene_shape *s, sss_vec3 o,
                                                      sss_vec3 d) {
    sss_vec3 p = scene_mul(o, s->inverse_extent), v = scene_mul(d, s->inverse_extent);
    float inverse = 1.0f / scene_dot(v, v), middle = -scene_dot(p, v) * inverse;
    sss_vec3 nearest = scene_along(p, v, middle);
    float rest = 1.0f - scene_dot(nearest, nearest);
    if (!(rest > 0.0f)) return scene_make_interval(1.0f, -1.0f);
    float reach = scene_sqrt(rest * inverse);
    return scene_make_interval(middle - reach, middle + reach);
}

// The part of a line inside |x| <= extent, one axis. A line along the faces has no crossing: all or
// nothing.
static inline scene_interval scene_slab_interval(float o, float d, float extent) {
    const float far_away = 1e30f;
    if (scene_abs(d) < 1e-20f) {
        return scene_abs(o) <= extent ? scene_make_interval(-far_away, far_away)
                                      : scene_make_interval(1.0f, -1.0f);
    }
    float inverse = 1.0f / d, a = (-extent - o) * inverse, b = (extent - o) * inverse;
    return scene_make_interval(scene_min(a, b), scene_max(a, b));
}

// One axis of the squared distance to the core of a rounded box near t = middle, as a quadratic
// about t = start: adds v^2, e v and e^2, or nothing where the line is between the two core faces.
static inline sss_vec3 scene_axis_quadratic(sss_vec3 abc, float o, float d, float core, float start,
                                            float middle) {
    float side = o + middle * d < 0.0f ? -1.0f : 1.0f;
    if (side * (o + middle * d) <= core) return abc;
    float e = side * (o + start * d) - core, v = side * d;
    return scene_add(abc, scene_vec(v * v, e * v, e * e));
}

// The smallest t in [start, end] at which the line comes within `rounding` of the core box, or
// `none`. The squared distance is convex and quadratic between the (at most six) crossings of the
// core's face planes: walk those pieces.
static inline float scene_first_root(sss_vec3 o, sss_vec3 d, sss_vec3 core, float rounding,
                                     float start, float end, float none) {
    scene_interval x = scene_slab_interval(o.x, d.x, core.x),
                   y = scene_slab_interval(o.y, d.y, core.y),
                   z = scene_slab_interval(o.z, d.z, core.z);
    float crossing[6];
    crossing[0] = x.t0;
    crossing[1] = x.t1;
    crossing[2] = y.t0;
    crossing[3] = y.t1;
    crossing[4] = z.t0;
    crossing[5] = z.t1;

    for (int piece = 0; piece < 7 && start < end; piece++) {
        float stop = end;
        for (int i = 0; i < 6; i++) {
            if (crossing[i] > start && crossing[i] < stop) stop = crossing[i];
        }
        float middle = 0.5f * (start + stop);
        sss_vec3 q =
            scene_axis_quadratic(scene_vec(0.0f, 0.0f, 0.0f), o.x, d.x, core.x, start, middle);
        q = scene_axis_quadratic(q, o.y, d.y, core.y, start, middle);
        q = scene_axis_quadratic(q, o.z, d.z, core.z, start, middle);
        float c = q.z - rounding * rounding;
        if (c <= 0.0f) return start;
        if (q.y >= 0.0f) return none; // convex and rising: it never comes nearer
        float discriminant = q.y * q.y - q.x * c;
        if (discriminant >= 0.0f) {
            float t = start + c / (scene_sqrt(discriminant) - q.y);
            if (t <= stop) return t;
        }
        start = stop;
    }
    return none;
}

static inline scene_interval scene_box_interval(const SCENE_SPACE scene_shape *s, sss_vec3 o,
                                                sss_vec3 d) {
    scene_interval x = scene_slab_interval(o.x, d.x, s->extent.x),
                   y = scene_slab_interval(o.y, d.y, s->extent.y),
                   z = scene_slab_interval(o.z, d.z, s->extent.z);
    float a = scene_max(scene_max(x.t0, y.t0), z.t0), b = scene_min(scene_min(x.t1, y.t1), z.t1);
    if (!(a < b)) return scene_make_interval(1.0f, -1.0f);
    // Move the origin to the middle of the box's stretch: the roots then keep their digits however
    // far the ray started.
    float middle = 0.5f * (a + b), reach = 0.5f * (b - a), none = 2.0f * reach;
    sss_vec3 p = scene_along(o, d, middle), r = scene_vec(s->rounding, s->rounding, s->rounding);
    sss_vec3 core = scene_sub(s->extent, r);
    float entry = scene_first_root(p, d, core, s->rounding, -reach, reach, none);
    if (entry == none) return scene_make_interval(1.0f, -1.0f);
    float leave =
        -scene_first_root(p, scene_scale(d, -1.0f), core, s->rounding, -reach, reach, none);
    return scene_make_interval(middle + entry, middle + leave);
}

static inline scene_interval scene_shape_interval(const SCENE_SPACE scene_shape *s, sss_vec3 origin,
                                                  sss_vec3 direction) {
    sss_vec3 o = scene_to_local(s, scene_sub(origin, s->center)), d = scene_to_local(s, direction);
    return s->kind == SCENE_ELLIPSOID ? scene_ellipsoid_interval(s, o, d)
                                      : scene_box_interval(s, o, d);
}

// The vector from the core of a rounded box (local frame) to p: zero inside the core.
static inline sss_vec3 scene_from_core(const SCENE_SPACE scene_shape *s, sss_vec3 p) {
    sss_vec3 e = scene_vec(scene_max(scene_abs(p.x) - s->extent.x + s->rounding, 0.0f),
                           scene_max(scene_abs(p.y) - s->extent.y + s->rounding, 0.0f),
                           scene_max(scene_abs(p.z) - s->extent.z + s->rounding, 0.0f));
    return scene_vec(p.x < 0.0f ? -e.x : e.x, p.y < 0.0f ? -e.y : e.y, p.z < 0.0f ? -e.z : e.z);
}

// How far a point is from the shape's boundary, as a share of the shape's size: below 0 inside, 0
// on it, above 0 outside.
static inline float scene_level(const SCENE_SPACE scene_shape *s, sss_vec3 position) {
    sss_vec3 p = scene_to_local(s, scene_sub(position, s->center));
    if (s->kind == SCENE_ELLIPSOID) {
        p = scene_mul(p, s->inverse_extent);
        return scene_sqrt(scene_dot(p, p)) - 1.0f;
    }
    p = scene_from_core(s, p);
    return scene_sqrt(scene_dot(p, p)) / s->rounding - 1.0f;
}

// Unit outward normal at a point of the shape's boundary.
static inline sss_vec3 scene_normal(const SCENE_SPACE scene_shape *s, sss_vec3 position) {
    sss_vec3 p = scene_to_local(s, scene_sub(position, s->center));
    if (s->kind == SCENE_ELLIPSOID) {
        p = scene_mul(scene_mul(p, s->inverse_extent), s->inverse_extent);
    } else {
        p = scene_from_core(s, p);
    }
    return scene_normalize(scene_to_world(s, p));
}

static inline int scene_inside_another(const SCENE_SPACE scene *s, sss_vec3 position, int shape) {
    for (int i = 0; i < s->shape_count; i++) {
        if (i != shape && scene_level(&s->shape[i], position) < 0.0f) return 1;
    }
    return 0;
}

// Which shape a boundary point of the object lies on.
static inline int scene_shape_at(const SCENE_SPACE scene *s, sss_vec3 position) {
    int best = 0;
    float least = 1e30f;

    for (int i = 0; i < s->shape_count; i++) {
        float level = scene_abs(scene_level(&s->shape[i], position));
        if (level >= least) continue;
        least = level;
        best = i;
    }
    return best;
}

// All hits of the segment with the boundary of the object, nearest first.
static inline void scene_segment_hits(const SCENE_SPACE scene *s, sss_vec3 origin,
                                      sss_vec3 direction, float length, scene_hits *hits) {
    scene_interval interval[SCENE_MAX_SHAPES];
    hits->count = 0;
    for (int i = 0; i < s->shape_count; i++) {
        interval[i] = scene_shape_interval(&s->shape[i], origin, direction);
    }

    for (int k = 0; k < 2 * s->shape_count; k++) {
        scene_interval own = interval[k >> 1];
        float t = (k & 1) != 0 ? own.t1 : own.t0;
        int counts = own.t0 <= own.t1 && t >= 0.0f && t <= length;
        for (int i = 0; counts && i < s->shape_count; i++) {
            counts = i == k >> 1 || t <= interval[i].t0 || t >= interval[i].t1;
        }
        if (!counts) continue;
        int place = hits->count++;
        for (; place > 0 && hits->hit[place - 1].t > t; place--)
            hits->hit[place] = hits->hit[place - 1];
        hits->hit[place].t = t;
        hits->hit[place].shape = k >> 1;
    }
}

// The nearest hit of a random walk's segment, or none. The segment begins inside, so the stretch
// that lies inside is followed from shape to shape to its end. One that begins outside, by a
// rounding, enters first.
static inline void scene_way_out(const SCENE_SPACE scene *s, sss_vec3 origin, sss_vec3 direction,
                                 float length, scene_hits *hits) {
    scene_interval interval[SCENE_MAX_SHAPES];
    float reached = 0.0f, enters = 1e30f;
    int shape = SCENE_NOTHING, entered = 0, before;

    for (int i = 0; i < s->shape_count; i++) {
        interval[i] = scene_shape_interval(&s->shape[i], origin, direction);
        if (!(interval[i].t0 <= interval[i].t1 && interval[i].t0 >= 0.0f)) continue;
        if (interval[i].t0 >= enters) continue;
        enters = interval[i].t0;
        entered = i;
    }

    do {
        before = shape;

        for (int i = 0; i < s->shape_count; i++) {
            if (!(interval[i].t0 <= reached && interval[i].t1 > reached)) continue;
            reached = interval[i].t1;
            shape = i;
        }
    } while (shape != before && reached <= length);

    hits->hit[0].t = shape >= 0 ? reached : enters;
    hits->hit[0].shape = shape >= 0 ? shape : entered;
    hits->count = hits->hit[0].t <= length;
}

// What a ray through empty space meets first: a shape, the floor or nothing. `leaving` is the shape
// that the origin lies on (or SCENE_FLOOR, SCENE_NOTHING), which the ray leaves outwards. Below the
// floor it is dark: see tracer.h.
static inline scene_hit scene_nearest(const SCENE_SPACE scene *s, sss_vec3 origin,
                                      sss_vec3 direction, int leaving) {
    scene_hit nearest;
    nearest.t = 1e30f;
    nearest.shape = SCENE_NOTHING;
    if (direction.y < 0.0f && leaving != SCENE_FLOOR) {
        nearest.t = scene_max(-origin.y / direction.y, 0.0f);
        nearest.shape = SCENE_FLOOR;
    }

    for (int i = 0; i < s->shape_count; i++) {
        if (i == leaving) continue;
        scene_interval interval = scene_shape_interval(&s->shape[i], origin, direction);
        if (interval.t0 <= interval.t1 && interval.t0 >= 0.0f && interval.t0 < nearest.t) {
            nearest.t = interval.t0;
            nearest.shape = i;
        }
    }
    return nearest;
}

static inline int scene_occluded(const SCENE_SPACE scene *s, sss_vec3 origin, sss_vec3 direction,
                                 float length, int leaving) {
    for (int i = 0; i < s->shape_count; i++) {
        if (i == leaving) continue;
        scene_interval interval = scene_shape_interval(&s->shape[i], origin, direction);
        if (interval.t0 <= interval.t1 && interval.t0 >= 0.0f && interval.t0 < length) return 1;
    }
    return 0;
}

static inline sss_vec3 scene_sky(const SCENE_SPACE scene *s, sss_vec3 direction) {
    sss_vec3 climb = scene_sub(s->sky_zenith, s->sky_horizon);
    return scene_along(s->sky_horizon, climb, direction.y);
}

// The surroundings of a point without the object in them: the sky above, and below the floor as
// bright as it is near the point, roughly. Radiance towards the point from direction w: (w.y > 0 ?
// above : below) + climb w.y. The sky is exact.
typedef struct scene_ambient {
    sss_vec3 above, below, climb;
} scene_ambient;

static inline scene_ambient scene_make_ambient(const SCENE_SPACE scene *s, sss_vec3 position) {
    scene_ambient a;
    sss_vec3 path = scene_sub(s->light.center, scene_vec(position.x, 0.0f, position.z));
    float squared = scene_dot(path, path);
    float lamp = path.y * scene_max(-scene_dot(path, s->light.normal), 0.0f) * s->light.area /
                 (squared * squared);
    a.above = s->sky_horizon;
    a.climb = scene_sub(s->sky_zenith, s->sky_horizon);
    // The sky's irradiance on the floor, over pi.
    sss_vec3 sky = scene_along(a.above, a.climb, 2.0f / 3.0f);
    sss_vec3 floor_radiance = scene_mul(
        s->floor_albedo, scene_along(sky, s->light.radiance, lamp * s->floor_lit / SCENE_PI));
    // So that its mean, seen from above, is that of the floor.
    a.below = scene_along(floor_radiance, a.climb, 2.0f / 3.0f);
    return a;
}

static inline sss_vec3 scene_ambient_radiance(scene_ambient a, sss_vec3 direction) {
    return scene_along(direction.y > 0.0f ? a.above : a.below, a.climb, direction.y);
}

// The irradiance of that on a surface: closed, since each half space of constant radiance gives pi
// (1 +- n.y) / 2 and the part that is linear in w.y gives 2 pi / 3 n.y.
static inline sss_vec3 scene_ambient_irradiance(scene_ambient a, sss_vec3 normal) {
    sss_vec3 e = scene_scale(a.above, 0.5f + 0.5f * normal.y);
    e = scene_along(e, a.below, 0.5f - 0.5f * normal.y);
    return scene_scale(scene_along(e, a.climb, 2.0f / 3.0f * normal.y), SCENE_PI);
}

#endif
