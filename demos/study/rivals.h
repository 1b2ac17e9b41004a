// rivals.h - ten ways to find the light that leaves a translucent object at a point, and the truth for nine of them by
// brute force; all in the tracer's scenes. Host only. SPDX-License-Identifier: MIT
//
// Each looks for M(x) = integral of Rd(|y - x|) E(y) a(y) dA(y) at an entry x: E is one next-event sample of the lamp
// and the surroundings in closed form, a is a procedural texture whose octaves of noise set what shading costs. The
// walk looks for the same with the volume itself in place of Rd.
#ifndef RIVALS_H
#define RIVALS_H

#include <string.h>

#include "point_cloud.h"
#include "random_walk.h"
#include "demos/common/entries.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer.h"

#define RIVALS_SOLID 0.05f // solid angle of the point cloud's nodes
#define RIVALS_LIGHT 4     // each point of the cloud gets a grid of that many by that many lamp samples

enum { RIVALS_PROBES, RIVALS_PLANNED, RIVALS_CLOUD, RIVALS_WALK };
typedef struct rivals_method {
    const char *name;
    int kind, independent, told;
    unsigned techniques;
    int least, most; // candidates by powers of two, or points of the cloud by powers of eight
    int exact;       // unbiased: its mean is the surface integral
} rivals_method;
static const rivals_method rivals_methods[] = {
    {"disk", RIVALS_PROBES, 1, 0, SSS_DISK, 1, 1, 0},
    {"three-axes", RIVALS_PROBES, 1, 0, SSS_DISK | SSS_DISK_TANGENTS, 1, 1, 1}, // but for 1e-4 of the tail
    {"sphere", RIVALS_PROBES, 1, 0, SSS_SPHERE, 1, 1, 0},                       // infinite variance: no z-score holds
    {"disk-sphere", RIVALS_PROBES, 1, 0, SSS_DISK | SSS_SPHERE, 1, 1, 1},
    {"chord", RIVALS_PROBES, 1, 0, SSS_CHORD, 1, 1, 1},
    {"memo", RIVALS_PROBES, 1, 0, SSS_DISK | SSS_SPHERE, 2, 64, 1},
    {"ours", RIVALS_PROBES, 0, 0, 0, 1, 64, 1},
    {"told", RIVALS_PROBES, 0, 1, 0, 1, 64, 1},
    {"planned", RIVALS_PLANNED, 0, 0, 0, 0, 0, 1},
    {"planned-told", RIVALS_PLANNED, 0, 1, 0, 0, 0, 1},
    {"cloud", RIVALS_CLOUD, 0, 0, 0, 1024, 65536, 0},
    {"walk", RIVALS_WALK, 0, 0, 0, 0, 0, 0},
};
#define RIVALS_METHODS ((int)(sizeof rivals_methods / sizeof rivals_methods[0]))

typedef struct rivals_world {
    scene s;
    walk_medium volume;
    point_cloud cloud;
    int octaves;
    float shading_cost; // over that of a probe
} rivals_world;

typedef struct rivals_work {
    long long probes, shaded; // the walk's probes are its straight segments
} rivals_work;

// ---- The shader

#define RIVALS_BAND 8 // octaves, each half as high and twice as fine as the one before; then the next stack begins

static inline float rivals_corner(uint32_t x, uint32_t y, uint32_t z, uint32_t seed) {
    return 2.0f * tracer_unit(sss_hash(x * 73856093u ^ y * 19349663u ^ z * 83492791u, seed)) - 1.0f;
}
// Value noise, -1..1.
static inline float rivals_noise(sss_vec3 p, uint32_t seed) {
    float fx = floorf(p.x), fy = floorf(p.y), fz = floorf(p.z), x = p.x - fx, y = p.y - fy, z = p.z - fz, row[4];
    uint32_t i = (uint32_t)(int)fx, j = (uint32_t)(int)fy, k = (uint32_t)(int)fz;
    x *= x * (3.0f - 2.0f * x), y *= y * (3.0f - 2.0f * y), z *= z * (3.0f - 2.0f * z);
    for (uint32_t r = 0; r < 4; r++) {
        float a = rivals_corner(i, j + (r & 1u), k + (r >> 1), seed);
        row[r] = a + x * (rivals_corner(i + 1u, j + (r & 1u), k + (r >> 1), seed) - a);
    }
    float low = row[0] + y * (row[1] - row[0]), high = row[2] + y * (row[3] - row[2]);
    return low + z * (high - low);
}
static inline float rivals_octave(sss_vec3 p, int k) {
    return rivals_noise(scene_scale(p, 3.0f * (float)(1 << k % RIVALS_BAND)), (uint32_t)k);
}
// 0.1..0.9, 0.5 in the mean.
static inline float rivals_texture(sss_vec3 p, int octaves) {
    float sum = 0.0f, total = 1e-20f;
    for (int k = 0; k < octaves; k++) {
        float height = 1.0f / (float)(1 << k % RIVALS_BAND);
        sum += height * rivals_octave(p, k);
        total += height;
    }
    return 0.5f + 0.4f * sum / total;
}
// The same in the mean over u and v by one octave, drawn by its height; for whole stacks of octaves.
static inline float rivals_texture_guess(sss_vec3 p, int octaves, float u, float v) {
    int band = 0, stack = (int)(v * (float)(octaves / RIVALS_BAND));
    float half = 0.5f / (1.0f - 1.0f / (float)(1 << RIVALS_BAND)), below = half; // band b has half / 2^b
    for (; band < RIVALS_BAND - 1 && u >= below; band++) below += half / (float)(2 << band);
    return octaves ? 0.5f + 0.4f * rivals_octave(p, stack * RIVALS_BAND + band) : 0.5f;
}

static inline sss_vec3 rivals_irradiance(const scene *s, tracer_point point, float u, float v) {
    return scene_add(tracer_light(s, point, u, v),
                     scene_ambient_irradiance(scene_make_ambient(s, point.position), point.normal));
}
static inline sss_vec3 rivals_shade(const rivals_world *w, tracer_point point, uint32_t seed) {
    float u = tracer_unit(sss_hash(seed, 0x75u)), v = tracer_unit(sss_hash(seed, 0x76u));
    return scene_scale(rivals_irradiance(&w->s, point, u, v), rivals_texture(point.position, w->octaves));
}

// ---- Entries

// Scene units in a pixel of a picture of that many rows.
static inline float rivals_footprint(const scene *s, const camera_entry *at, int rows) {
    return 2.0f * at->distance * scene_sqrt(scene_dot(s->up, s->up)) / (float)rows;
}

// ---- The rivals: one lookup each

static inline void rivals_probe_lookup(const rivals_world *w, const sss_plan *plan, int told, camera_entry at,
                                       uint32_t seed, rivals_work *work, double value[3]) {
    sss_resampler r;
    sss_probe probe;
    sss_exit exit;
    scene_hits hits;
    unsigned char found[SCENE_MAX_FOUND];
    int calls = 0;
    sss_begin(&r, &w->s.medium, plan, at.position, at.normal, seed);
    while (sss_next_probe(&r, &probe)) {
        work->probes++;
        scene_segment_hits(&w->s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++) {
            sss_vec3 y = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 n = scene_normal(&w->s.shape[hits.hit[i].shape], y);
            found[calls++] = (unsigned char)hits.hit[i].shape;
            sss_add_hit(&r, y, n, told ? tracer_light_guess(&w->s, y, n) : 1.0f);
        }
    }
    value[0] = value[1] = value[2] = 0.0;
    if (!sss_finish(&r, &exit)) return;
    int shape = exit.hit < 0 ? scene_shape_at(&w->s, at.position) : (int)found[exit.hit];
    tracer_point point = {exit.position, exit.normal, exit.position, shape};
    sss_vec3 light = rivals_shade(w, point, seed);
    work->shaded++;
    value[0] = (double)(exit.weight[0] * light.x);
    value[1] = (double)(exit.weight[1] * light.y);
    value[2] = (double)(exit.weight[2] * light.z);
}

static inline void rivals_walk_lookup(const rivals_world *w, camera_entry at, uint32_t seed, rivals_work *work,
                                      double value[3]) {
    tracer_random random = tracer_random_begin(seed, 0u, 0u);
    walk_exit exit;
    value[0] = value[1] = value[2] = 0.0;
    int leaves = walk_lookup(&w->s, &w->volume, at.position, at.normal, at.shape, &random, &exit);
    work->probes += exit.scatterings + 1;
    if (!leaves) return;
    tracer_point point = {exit.position, exit.normal, exit.position, exit.shape};
    sss_vec3 light = rivals_shade(w, point, seed);
    work->shaded++;
    value[0] = (double)(exit.weight[0] * light.x);
    value[1] = (double)(exit.weight[1] * light.y);
    value[2] = (double)(exit.weight[2] * light.z);
}

static inline void rivals_cloud_lookup(const rivals_world *w, camera_entry at, double value[3]) {
    sss_vec3 sum = cloud_lookup(&w->cloud, &w->s.medium, at.position, RIVALS_SOLID);
    value[0] = (double)sum.x, value[1] = (double)sum.y, value[2] = (double)sum.z;
}

// Points, their irradiance and the octree; 0 when memory runs out.
static inline int rivals_build_cloud(rivals_world *w, int points, uint32_t seed) {
    if (!cloud_scatter(&w->cloud, &w->s, points, seed)) return 0;
    for (int i = 0; i < w->cloud.points; i++) {
        cloud_point *p = &w->cloud.point[i];
        sss_vec3 normal = scene_normal(&w->s.shape[p->shape], p->position), sum = scene_vec(0.0f, 0.0f, 0.0f);
        tracer_point point = {p->position, normal, normal, p->shape};
        for (int k = 0; k < RIVALS_LIGHT * RIVALS_LIGHT; k++) {
            float u = ((float)(k % RIVALS_LIGHT) + tracer_unit(sss_hash(seed + 1u, (uint32_t)(32 * i + k))));
            float v = ((float)(k / RIVALS_LIGHT) + tracer_unit(sss_hash(seed + 2u, (uint32_t)(32 * i + k))));
            sum = scene_add(sum, rivals_irradiance(&w->s, point, u / RIVALS_LIGHT, v / RIVALS_LIGHT));
        }
        p->light = scene_scale(sum, rivals_texture(p->position, w->octaves) / (RIVALS_LIGHT * RIVALS_LIGHT));
    }
    return cloud_gather(&w->cloud, &w->s.medium);
}

// The plan of a probe method with that many candidates, or the header's own for that cost of shading. All errors here
// are against the profile's integral, so the header is told to tolerate that model, and no pixel is wide.
static inline sss_plan rivals_plan(const rivals_world *w, const rivals_method *m, int candidates) {
    sss_plan plan = {candidates, 1, m->techniques, m->independent, 0, 0};
    sss_need need = {0.0f, 0.0f, w->shading_cost, 1.0f, 0};
    return m->kind == RIVALS_PLANNED ? sss_plan_for(&w->s.medium, &need) : plan;
}

static inline void rivals_lookup(const rivals_world *w, const rivals_method *m, const sss_plan *plan, camera_entry at,
                                 uint32_t seed, rivals_work *work, double value[3]) {
    if (m->kind == RIVALS_WALK)
        rivals_walk_lookup(w, at, seed, work, value);
    else if (m->kind == RIVALS_CLOUD)
        rivals_cloud_lookup(w, at, value);
    else
        rivals_probe_lookup(w, plan, m->told, at, seed, work, value);
}

// ---- Brute force: area points over the whole object

#define RIVALS_COSTS 4
static const int rivals_octaves[RIVALS_COSTS] = {0, 64, 512, 4096};

typedef struct rivals_truth {
    double mean[RIVALS_COSTS][3], variance[RIVALS_COSTS][3]; // of the mean
} rivals_truth;

// The mean over `sets` of TRACER_AREA_POINTS points, for each cost of shading.
static inline void rivals_brute_force(const scene *s, camera_entry at, uint32_t seed, int sets, rivals_truth *truth) {
    double sum[RIVALS_COSTS][3] = {{0.0}}, squares[RIVALS_COSTS][3] = {{0.0}};
    for (int n = 0; n < sets; n++) {
        tracer_random random = tracer_random_begin(seed, 1u, (uint32_t)n);
        tracer_points points;
        double set[RIVALS_COSTS][3] = {{0.0}};
        tracer_area_points(s, at.position, &random, &points);
        for (int i = 0; i < points.count; i++) {
            tracer_point p = points.point[i];
            float u = tracer_next(&random), v = tracer_next(&random), a = tracer_next(&random),
                  b = tracer_next(&random);
            sss_vec3 light = scene_mul(p.weight, rivals_irradiance(s, p, u, v));
            for (int k = 0; k < RIVALS_COSTS; k++) {
                double texture = (double)rivals_texture_guess(p.position, rivals_octaves[k], a, b);
                set[k][0] += texture * (double)light.x;
                set[k][1] += texture * (double)light.y;
                set[k][2] += texture * (double)light.z;
            }
        }
        for (int k = 0; k < 3 * RIVALS_COSTS; k++) {
            sum[k / 3][k % 3] += set[k / 3][k % 3];
            squares[k / 3][k % 3] += set[k / 3][k % 3] * set[k / 3][k % 3];
        }
    }
    for (int k = 0; k < RIVALS_COSTS; k++) {
        for (int c = 0; c < 3; c++) {
            truth->mean[k][c] = sum[k][c] / sets;
            truth->variance[k][c] = (squares[k][c] / sets - truth->mean[k][c] * truth->mean[k][c]) / (sets - 1);
        }
    }
}

#endif
