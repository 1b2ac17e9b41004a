// rivals.h - the ways to find the light that leaves a translucent object which chart.c races.
// Host only. SPDX-License-Identifier: MIT
//
// All look for the light at the pixels of a tile, in a scene of the tracer. The light at an exit is
// one sample of the lamp and the surroundings in closed form, times a procedural texture that no
// hint knows. The truth is a random walk through the volume.
#ifndef RIVALS_H
#define RIVALS_H

#include <math.h>
#include <string.h>

#include "point_cloud.h"
#include "random_walk.h"
#include "demos/common/entries.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer.h"

#define RIVALS_SIDE    8 // of a tile
#define RIVALS_PIXELS  (RIVALS_SIDE * RIVALS_SIDE)
#define RIVALS_ROWS    256 // of the picture that the tiles belong to
#define RIVALS_OCTAVES 8   // of the texture
#define RIVALS_HITS    (SSS_MAX_CANDIDATES * 8)

typedef struct rivals_world {
    scene s;
    walk_medium volume;
    point_cloud cloud;
    float shading_cost; // over that of a probe
} rivals_world;

// The pixels of a tile that see the object.
typedef struct rivals_tile {
    int count;
    float pixel; // width of a pixel on the surface
    uint32_t name;
    camera_entry at[RIVALS_PIXELS];
    sss_entry entry[RIVALS_PIXELS];
} rivals_tile;

typedef struct rivals_work {
    long long probes, shaded; // a walk's probes are its straight segments
} rivals_work;

// One estimate for each pixel of a tile.
typedef double rivals_values[RIVALS_PIXELS][3];

// ---- The shader

static inline float rivals_corner(uint32_t x, uint32_t y, uint32_t z, uint32_t seed) {
    return 2.0f * tracer_unit(sss_hash(x * 73856093u ^ y * 19349663u ^ z * 83492791u, seed)) - 1.0f;
}
// Value noise, -1..1.
static inline float rivals_noise(sss_vec3 p, uint32_t seed) {
    float fx = floorf(p.x), fy = floorf(p.y), fz = floorf(p.z);
    float x = p.x - fx, y = p.y - fy, z = p.z - fz, row[4];
    uint32_t i = (uint32_t)(int)fx, j = (uint32_t)(int)fy, k = (uint32_t)(int)fz;
    x *= x * (3.0f - 2.0f * x), y *= y * (3.0f - 2.0f * y), z *= z * (3.0f - 2.0f * z);
    for (uint32_t r = 0; r < 4; r++) {
        float a = rivals_corner(i, j + (r & 1u), k + (r >> 1), seed);
        row[r] = a + x * (rivals_corner(i + 1u, j + (r & 1u), k + (r >> 1), seed) - a);
    }
    float low = row[0] + y * (row[1] - row[0]), high = row[2] + y * (row[3] - row[2]);
    return low + z * (high - low);
}
// 0.1..0.9, 0.5 in the mean: octaves of value noise, each half as high and twice as fine.
static inline float rivals_texture(sss_vec3 p) {
    float sum = 0.0f, total = 0.0f;

    for (int k = 0; k < RIVALS_OCTAVES; k++) {
        float height = 1.0f / (float)(1 << k);

        sum += height * rivals_noise(scene_scale(p, 3.0f * (float)(1 << k)), (uint32_t)k);
        total += height;
    }
    return 0.5f + 0.4f * sum / total;
}

static inline sss_vec3 rivals_irradiance(const scene *s, tracer_point point, float u, float v) {
    scene_ambient around = scene_make_ambient(s, point.position);

    return scene_add(tracer_light(s, point, u, v), scene_ambient_irradiance(around, point.normal));
}

static inline sss_vec3 rivals_shade(const scene *s, tracer_point point, float u, float v) {
    return scene_scale(rivals_irradiance(s, point, u, v), rivals_texture(point.position));
}

// The first exit of a sample has the lamp's strata of its pixel.
static inline sss_vec3 rivals_shade_exit(const scene *s, sss_vec3 position, sss_vec3 normal,
                                         int shape, int first, tracer_random *random,
                                         rivals_work *work) {
    tracer_point point = {position, normal, position, shape};
    float u = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT) : tracer_next(random);
    float v = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT + 1u) : tracer_next(random);

    work->shaded++;
    return rivals_shade(s, point, u, v);
}

// ---- Hints: what a caller may know of the light at a hit

enum { HINT_NONE, HINT_COSINE, HINT_LAMP, HINT_EXACT, HINT_WRONG, HINTS };
static const char *const rivals_hints[HINTS] = {"none", "cosine", "lamp", "exact", "wrong"};

static inline float rivals_hint(const scene *s, int kind, sss_vec3 position, sss_vec3 normal,
                                int shape) {
    tracer_point point = {position, normal, position, shape};
    sss_vec3 sum = scene_vec(0.0f, 0.0f, 0.0f);

    if (kind == HINT_NONE) return 1.0f;
    if (kind == HINT_LAMP) return tracer_light_guess(s, position, normal);
    if (kind == HINT_EXACT) {
        for (int k = 0; k < 16; k++) {
            float u = ((float)(k % 4) + 0.5f) * 0.25f, v = ((float)(k / 4) + 0.5f) * 0.25f;
            sum = scene_add(sum, rivals_shade(s, point, u, v));
        }
        return scene_mean(sum);
    }
    float cosine = scene_dot(scene_normalize(scene_sub(s->light.center, position)), normal);
    return scene_max(kind == HINT_WRONG ? -cosine : cosine, 0.0f) + 0.05f;
}

// ---- Tiles

static inline float rivals_footprint(const scene *s, float distance) {
    return 2.0f * distance * scene_sqrt(scene_dot(s->up, s->up)) / (float)RIVALS_ROWS;
}

// The tile number `name` of a scene: somewhere in the picture, and most of it sees the object.
static inline void rivals_place(const scene *s, uint32_t name, rivals_tile *tile) {
    tracer_random random = tracer_random_begin(31u, name, 0u);
    float distance = 0.0f;

    do {
        float left = floorf(tracer_next(&random) * (float)(RIVALS_ROWS - RIVALS_SIDE));
        float top = floorf(tracer_next(&random) * (float)(RIVALS_ROWS - RIVALS_SIDE));

        tile->count = 0;
        for (int i = 0; i < RIVALS_PIXELS; i++) {
            float x = (left + (float)(i % RIVALS_SIDE) + 0.5f) / (float)RIVALS_ROWS;
            float y = (top + (float)(i / RIVALS_SIDE) + 0.5f) / (float)RIVALS_ROWS;
            tile->count += camera_sees(s, x, y, &tile->at[tile->count]);
        }
    } while (tile->count < RIVALS_PIXELS / 2);

    tile->name = name;
    for (int i = 0; i < tile->count; i++) {
        tile->entry[i].position = tile->at[i].position;
        tile->entry[i].medium = &s->medium;
        distance += tile->at[i].distance / (float)tile->count;
    }
    tile->pixel = rivals_footprint(s, distance);
}

// The radius of the largest ball that touches the surface here, from four rays inwards: one
// straight, three at 60 degrees. Each hit y bounds it by |y - x|^2 / (2 |n . (y - x)|).
static inline float rivals_radius(const scene *s, const camera_entry *at) {
    float radius = 1e30f;
    scene_hits hits;

    for (int k = 0; k < 4; k++) {
        float z = k == 0 ? 1.0f : 0.5f, across = k == 0 ? 0.0f : 0.8660254f;
        sss_vec3 d = tracer_about(scene_scale(at->normal, -1.0f), z, across, (float)k / 3.0f);

        scene_segment_hits(s, at->position, d, 1e3f, &hits);
        for (int i = 0; i < hits.count; i++)
            if (hits.hit[i].t > 1e-3f) radius = scene_min(radius, 0.5f * hits.hit[i].t / z);
    }
    return radius;
}

// ---- Lookups with the header

// How a pixel asks: a plan, and a kind of hint. Without strata each sample is on its own.
typedef struct rivals_way {
    sss_plan plan[RIVALS_PIXELS];
    int hint, strata;
} rivals_way;

static inline int rivals_lookup(const rivals_world *w, const camera_entry *at,
                                const rivals_way *way, int i, const tracer_random *random,
                                rivals_work *work, sss_exit *exits, int *shapes) {
    sss_resampler r;
    sss_probe probe;
    scene_hits hits;
    int shape[RIVALS_HITS], calls = 0;
    uint32_t seed = way->strata ? random->pixel_key : random->sample_key;

    sss_begin_sample(&r, &w->s.medium, &way->plan[i], at->position, at->normal, seed,
                     way->strata ? random->sample : 0u);
    while (sss_next_probe(&r, &probe)) {
        work->probes++;
        scene_segment_hits(&w->s, probe.origin, probe.direction, probe.length, &hits);
        for (int k = 0; k < hits.count; k++) {
            int body = hits.hit[k].shape;
            sss_vec3 y = scene_along(probe.origin, probe.direction, hits.hit[k].t);
            sss_vec3 n = scene_normal(&w->s.shape[body], y);

            if (calls < RIVALS_HITS) shape[calls] = body;
            calls++;
            sss_add_hit(&r, y, n, rivals_hint(&w->s, way->hint, y, n, body));
        }
    }

    int count = sss_finish(&r, exits);
    for (int k = 0; k < count; k++) {
        int hit = exits[k].hit;
        shapes[k] = hit < 0             ? at->shape
                    : hit < RIVALS_HITS ? shape[hit]
                                        : scene_shape_at(&w->s, exits[k].position);
    }
    return count;
}

static inline void rivals_add(double value[3], const float weight[3], sss_vec3 light) {
    value[0] += (double)(weight[0] * light.x);
    value[1] += (double)(weight[1] * light.y);
    value[2] += (double)(weight[2] * light.z);
}

// Pixels whose plan shares form the group.
static inline void rivals_header_tile(const rivals_world *w, const rivals_tile *tile,
                                      const rivals_way *way, uint32_t seed, uint32_t sample,
                                      rivals_values value, rivals_work *work) {
    sss_entry group[RIVALS_PIXELS];
    float weight[RIVALS_PIXELS][3];
    int member[RIVALS_PIXELS], members = 0;

    for (int i = 0; i < tile->count; i++) {
        memset(value[i], 0, sizeof value[i]);
        if (way->plan[i].tile > 1) {
            group[members] = tile->entry[i];
            member[members++] = i;
        }
    }

    for (int i = 0, own = 0; i < tile->count; i++) {
        tracer_random random = tracer_random_begin(seed, 64u * tile->name + (uint32_t)i, sample);
        int shared = way->plan[i].tile > 1, shapes[SSS_MAX_EXITS];
        sss_exit exits[SSS_MAX_EXITS];
        int count = rivals_lookup(w, &tile->at[i], way, i, &random, work, exits, shapes);

        for (int k = 0; k < count; k++) {
            sss_vec3 light = rivals_shade_exit(&w->s, exits[k].position, exits[k].normal, shapes[k],
                                               k == 0, &random, work);
            if (!shared) {
                rivals_add(value[i], exits[k].weight, light);
                continue;
            }
            sss_share(&exits[k], group, members, own, tile->pixel, weight);
            for (int j = 0; j < members; j++) rivals_add(value[member[j]], weight[j], light);
        }
        own += shared;
    }
}

// ---- A lean probe, as renderers write it: King et al. 2013 without the header. One line along
// the normal or a tangent, radius by a channel's profile; all its hits are shaded, weighed by the
// balance heuristic over axes and channels. For Burley's profile with three live channels.

static inline void rivals_burley(const sss_medium *m, float r, float unit[3]) {
    r = scene_max(r, 1e-6f);
    for (int c = 0; c < 3; c++) {
        float d = m->length[c], slow = expf(-r / (3.0f * d));
        unit[c] = (slow + slow * slow * slow) / (8.0f * SCENE_PI * d * r);
    }
}

// Expected hits of a probe per area, for a point at `way` from the entry.
static inline float rivals_lean_density(const sss_medium *m, const sss_vec3 axis[3], sss_vec3 way,
                                        sss_vec3 normal) {
    float squared = scene_dot(way, way), density = 0.0f, unit[3];

    if (squared > m->r_max * m->r_max) return 0.0f;
    for (int a = 0; a < 3; a++) {
        float along = scene_dot(way, axis[a]);
        rivals_burley(m, scene_sqrt(scene_max(squared - along * along, 0.0f)), unit);
        density += (a == 0 ? 0.5f : 0.25f) * scene_abs(scene_dot(normal, axis[a])) *
                   (unit[0] + unit[1] + unit[2]) / 3.0f;
    }
    return density;
}

static inline void rivals_lean_lookup(const rivals_world *w, const camera_entry *at,
                                      tracer_random *random, rivals_work *work, double value[3]) {
    const sss_medium *m = &w->s.medium;
    float pick = tracer_stratified(random, 0u), turn = tracer_stratified(random, 1u);
    float u = tracer_stratified(random, 4u), colour = tracer_stratified(random, 5u);
    sss_vec3 tangent = tracer_tangent(at->normal);
    sss_vec3 axis[3] = {at->normal, tangent, scene_cross(at->normal, tangent)};
    int a = pick < 0.5f ? 0 : pick < 0.75f ? 1 : 2;
    float d = m->length[(int)(3.0f * colour)];
    float r = u < 0.25f ? -d * logf(1.0f - 4.0f * u) : -3.0f * d * logf(1.0f - (u - 0.25f) / 0.75f);

    if (!(r < m->r_max)) return;
    float half = scene_sqrt(m->r_max * m->r_max - r * r), angle = 6.28318531f * turn;
    sss_vec3 start = scene_along(at->position, axis[(a + 1) % 3], r * cosf(angle));
    scene_hits hits;
    start = scene_along(scene_along(start, axis[(a + 2) % 3], r * sinf(angle)), axis[a], half);
    work->probes++;
    scene_segment_hits(&w->s, start, scene_scale(axis[a], -1.0f), 2.0f * half, &hits);

    for (int k = 0; k < hits.count; k++) {
        int body = hits.hit[k].shape;
        sss_vec3 y = scene_along(start, axis[a], -hits.hit[k].t), way = scene_sub(y, at->position);
        sss_vec3 n = scene_normal(&w->s.shape[body], y);
        float density = rivals_lean_density(m, axis, way, n), unit[3];

        if (!(density > 0.0f)) continue;
        rivals_burley(m, scene_sqrt(scene_dot(way, way)), unit);
        for (int c = 0; c < 3; c++) unit[c] *= m->albedo[c] / density;
        rivals_add(value, unit, rivals_shade_exit(&w->s, y, n, body, k == 0, random, work));
    }
}

static inline void rivals_lean_tile(const rivals_world *w, const rivals_tile *tile, uint32_t seed,
                                    uint32_t sample, rivals_values value, rivals_work *work) {
    for (int i = 0; i < tile->count; i++) {
        tracer_random random = tracer_random_begin(seed, 64u * tile->name + (uint32_t)i, sample);

        memset(value[i], 0, sizeof value[i]);
        rivals_lean_lookup(w, &tile->at[i], &random, work, value[i]);
    }
}

// ---- The point cloud

// Points with lamps x lamps samples of the lamp each, and the octree; 0 when memory runs out.
static inline int rivals_build_cloud(rivals_world *w, int points, int lamps, uint32_t seed) {
    if (!cloud_scatter(&w->cloud, &w->s, points, seed)) return 0;
    for (int i = 0; i < w->cloud.points; i++) {
        cloud_point *p = &w->cloud.point[i];
        tracer_random random = tracer_random_begin(seed, (uint32_t)i, 0u);
        sss_vec3 normal = scene_normal(&w->s.shape[p->shape], p->position);
        sss_vec3 sum = scene_vec(0.0f, 0.0f, 0.0f);
        tracer_point point = {p->position, normal, normal, p->shape};

        for (int k = 0; k < lamps * lamps; k++) {
            float u = ((float)(k % lamps) + tracer_next(&random)) / (float)lamps;
            float v = ((float)(k / lamps) + tracer_next(&random)) / (float)lamps;
            sum = scene_add(sum, rivals_irradiance(&w->s, point, u, v));
        }
        p->light = scene_scale(sum, rivals_texture(p->position) / (float)(lamps * lamps));
    }
    return cloud_gather(&w->cloud, &w->s.medium);
}

static inline void rivals_cloud_tile(const rivals_world *w, const rivals_tile *tile, float solid,
                                     rivals_values value) {
    for (int i = 0; i < tile->count; i++) {
        sss_vec3 sum = cloud_lookup(&w->cloud, &w->s.medium, tile->at[i].position, solid);
        value[i][0] = (double)sum.x;
        value[i][1] = (double)sum.y;
        value[i][2] = (double)sum.z;
    }
}

// ---- The truth

typedef struct rivals_truth {
    double mean[RIVALS_PIXELS][3], variance[RIVALS_PIXELS][3]; // of the mean
} rivals_truth;

// Walks through the volume from each pixel of a tile.
static inline void rivals_walk_truth(const rivals_world *w, const rivals_tile *tile, int walks,
                                     rivals_truth *truth) {
    for (int i = 0; i < tile->count; i++) {
        const camera_entry *at = &tile->at[i];
        double sum[3] = {0.0}, squares[3] = {0.0};

        for (int n = 0; n < walks; n++) {
            uint32_t pixel = 64u * tile->name + (uint32_t)i;
            tracer_random random = tracer_random_begin(77u, pixel, (uint32_t)n);
            walk_exit exit;
            rivals_work work = {0, 0};
            double value[3] = {0.0};

            if (walk_lookup(&w->s, &w->volume, at->position, at->normal, at->shape, &random, &exit))
                rivals_add(value, exit.weight,
                           rivals_shade_exit(&w->s, exit.position, exit.normal, exit.shape, 0,
                                             &random, &work));
            for (int c = 0; c < 3; c++) {
                sum[c] += value[c];
                squares[c] += value[c] * value[c];
            }
        }
        for (int c = 0; c < 3; c++) {
            double mean = sum[c] / walks;
            truth->mean[i][c] = mean;
            truth->variance[i][c] = (squares[c] / walks - mean * mean) / (walks - 1);
        }
    }
}

#endif
