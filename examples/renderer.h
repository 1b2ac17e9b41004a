/* renderer.h - stands for your renderer: a translucent slab on a plate, twelve triangles each, and
   rays that try every one. Of it the examples use closest_hit() or all_hits(), and a tally that
   prints what came out beside what is known to be right. SPDX-License-Identifier: MIT */
#ifndef RENDERER_H
#define RENDERER_H

#include <stdio.h>

#include "sss_resample.h"

#define PI        3.14159265f
#define THICKNESS 0.25f
#define LOOKUPS   16384u
#define MOST_HITS 8 /* of one segment on one object; here no line has more than a few */

enum { SLAB, PLATE };

typedef struct ray_hit {
    float t;
    sss_vec3 position, normal; /* the normal is geometric and points outwards */
} ray_hit;

static inline sss_vec3 vec(float x, float y, float z) {
    sss_vec3 v;

    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
static inline sss_vec3 minus(sss_vec3 a, sss_vec3 b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline float dot(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline sss_vec3 cross(sss_vec3 a, sss_vec3 b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float distance(sss_vec3 a, sss_vec3 b) {
    return sqrtf(dot(minus(a, b), minus(a, b)));
}

/* Where the camera path meets the slab: on its upper face, z = 0. */
static inline sss_vec3 entry_position(void) { return vec(0.3f, 0.1f, 0.0f); }
static inline sss_vec3 entry_normal(void) { return vec(0.0f, 0.0f, 1.0f); }

/* Corner k (0..2) of triangle i (0..11): the slab has its top at z = 0, the plate is right
   below. */
static inline sss_vec3 corner(int object, int i, int k) {
    /* The faces' corners, counter-clockwise seen from outside; the bits of a digit are x, y, z. */
    static const char *const box[6] = {"0231", "4576", "0154", "2673", "0462", "1375"};
    int bits = box[i / 2][(k + (i % 2 && k > 0)) % 4] - '0';
    float top = object == SLAB ? 0.0f : -THICKNESS;
    float z = bits & 4 ? top : top - THICKNESS;

    return vec(bits & 1 ? 20.0f : -20.0f, bits & 2 ? 20.0f : -20.0f, z);
}

/* Moeller and Trumbore 1997. The same ray has the same t, to the bit, however it is asked for. */
static inline int meets(int object, int i, sss_vec3 origin, sss_vec3 direction, ray_hit *hit) {
    sss_vec3 p = corner(object, i, 0);
    sss_vec3 a = minus(corner(object, i, 1), p), b = minus(corner(object, i, 2), p);
    sss_vec3 s = minus(origin, p), q = cross(direction, b), r = cross(s, a);
    float inverse = 1.0f / dot(a, q);
    float u = dot(s, q) * inverse, v = dot(direction, r) * inverse;

    if (!(u >= 0.0f && v >= 0.0f && u + v <= 1.0f)) return 0;
    hit->t = dot(b, r) * inverse;
    hit->position = vec(p.x + u * a.x + v * b.x, p.y + u * a.y + v * b.y, p.z + u * a.z + v * b.z);
    hit->normal = cross(a, b);
    return 1;
}

/* The nearest hit on one object with least <= t <= most; 0 for none. */
static inline int closest_hit(int object, sss_vec3 origin, sss_vec3 direction, float least,
                              float most, ray_hit *hit) {
    ray_hit other;
    int found = 0;

    memset(hit, 0, sizeof *hit);
    for (int i = 0; i < 12; ++i) {
        if (!meets(object, i, origin, direction, &other)) continue;
        if (!(other.t >= least && other.t <= most)) continue;
        if (found && other.t >= hit->t) continue;
        *hit = other;
        found = 1;
    }
    return found;
}

/* All of them, nearest first; how many. */
static inline int all_hits(int object, sss_vec3 origin, sss_vec3 direction, float most,
                           ray_hit *hits) {
    ray_hit other;
    int place, count = 0;

    for (int i = 0; i < 12 && count < MOST_HITS; ++i) {
        if (!meets(object, i, origin, direction, &other)) continue;
        if (!(other.t >= 0.0f && other.t <= most)) continue;
        for (place = count++; place > 0 && hits[place - 1].t > other.t; --place)
            hits[place] = hits[place - 1];
        hits[place] = other;
    }
    return count;
}

/* The mean of many samples, and its standard error. */
typedef struct tally {
    double sum, squares;
    long count;
} tally;

static inline void tally_add(tally *t, double x) {
    t->sum += x;
    t->squares += x * x;
    t->count += 1;
}
static inline void tally_print(const tally *t, const char *name, double truth) {
    double mean = t->sum / (double)t->count;
    double variance = t->squares / (double)t->count - mean * mean;
    double error = variance > 0.0 ? sqrt(variance / (double)t->count) : 0.0;

    printf("%s: %.9f +- %.9f, truth %.6f\n", name, mean, error, truth);
}

/* The integral of the profile over both faces of the slab: white light from everywhere. */
static inline double slab_integral(const sss_medium *m, int channel) {
    return 2.0 * (double)sss_within(m, channel, 1e9f) - (double)sss_within(m, channel, THICKNESS);
}
static inline void print_channels(const tally channel[3], const sss_medium *m) {
    static const char *const name[3] = {"red", "green", "blue"};

    for (int c = 0; c < 3; ++c) tally_print(&channel[c], name[c], slab_integral(m, c));
}

#endif
