// point_cloud.h - the point cloud of Jensen and Buhler, "A rapid hierarchical rendering technique
// for translucent materials", SIGGRAPH 2002, on the objects of scene.h. Host only.
// SPDX-License-Identifier: MIT
//
// Points are spread over the surface with a least distance between them, each stands for the same
// area and keeps its irradiance; an octree joins far points into one where their area fills less
// than a given solid angle. One addition: a point nearer than the radius of its own area counts
// with the mean of the profile over that disk, as Burley's profile has a pole there and the dipoles
// of the paper have none.
#ifndef POINT_CLOUD_H
#define POINT_CLOUD_H

#include <stdlib.h>
#include <string.h>

#include "demos/common/tracer.h"

#define CLOUD_LEAF  8  // points
#define CLOUD_DARTS 12 // thrown for each point that is wanted
#define CLOUD_DEPTH 24 // of the octree: points may coincide in float

typedef struct cloud_point {
    sss_vec3 position, light; // light: irradiance, later that times the point's area
    int shape;
} cloud_point;

typedef struct cloud_node {
    sss_vec3 center, position, light; // of the cell; mean position by light; sum over its points
    float half;                       // half the cell's side
    int first, count;                 // points
    int child, children;              // none: a leaf
} cloud_node;

typedef struct point_cloud {
    cloud_point *point;
    cloud_node *node;
    int points, nodes, node_room;
    float area, disk; // of a point; radius of the disk of that area
    float profile[3]; // mean profile over that disk
} point_cloud;

static inline size_t cloud_bytes(const point_cloud *c) {
    return (size_t)c->points * sizeof *c->point + (size_t)c->nodes * sizeof *c->node;
}
static inline void cloud_free(point_cloud *c) {
    free(c->point);
    free(c->node);
    memset(c, 0, sizeof *c);
}

// ---- Points, evenly by area

// A bound of dA/dw over the parameter sphere (tracer.h): det(S) tau^3 / (y . n), with tau = 1 for
// ellipsoids and up to sqrt(3) for boxes, and y . n at least the smallest extent.
static inline float cloud_stretch(const scene_shape *s) {
    float least = scene_min(s->extent.x, scene_min(s->extent.y, s->extent.z));
    float bound = s->extent.x * s->extent.y * s->extent.z / least;
    return s->kind == SCENE_ROUNDED_BOX ? 5.1961524f * bound : bound;
}

// One dart: 1 and a point, or 0. `total` is the sum of all bounds; a dart hits each part of the
// surface with the same density 1 / (4 pi total).
static inline int cloud_dart(const scene *s, float total, tracer_random *random,
                             cloud_point *point) {
    float place = tracer_next(random) * total, z = 1.0f - 2.0f * tracer_next(random);
    float turn = tracer_next(random), chance = tracer_next(random), tau = 1.0f;
    int i = 0;
    for (; i < s->shape_count - 1 && place >= cloud_stretch(&s->shape[i]); i++)
        place -= cloud_stretch(&s->shape[i]);
    const scene_shape *body = &s->shape[i];
    sss_vec3 w = tracer_about(scene_vec(0.0f, 0.0f, 1.0f), z,
                              scene_sqrt(scene_max(1.0f - z * z, 0.0f)), turn);
    sss_vec3 ray = scene_mul(w, body->extent);
    if (body->kind == SCENE_ROUNDED_BOX)
        tau = scene_box_interval(body, scene_vec(0.0f, 0.0f, 0.0f), ray).t1;
    sss_vec3 arm = scene_scale(scene_to_world(body, ray), tau);
    point->shape = i;
    point->position = scene_add(body->center, arm);
    float across = scene_dot(arm, scene_normal(body, point->position));
    float stretch = body->extent.x * body->extent.y * body->extent.z * tau * tau * tau / across;
    return chance * cloud_stretch(body) < stretch && !scene_inside_another(s, point->position, i);
}

// A hash table of cells as wide as the least distance: the first point of each chain and the next
// of each point.
typedef struct cloud_grid {
    int *head, *next;
    uint32_t mask;
    float inverse; // 1 / width
} cloud_grid;

static inline uint32_t cloud_cell(const cloud_grid *g, sss_vec3 p, int dx, int dy, int dz) {
    uint32_t x = (uint32_t)((int)floorf(p.x * g->inverse) + dx),
             y = (uint32_t)((int)floorf(p.y * g->inverse) + dy);
    return sss_hash(sss_hash(x, y), (uint32_t)((int)floorf(p.z * g->inverse) + dz)) & g->mask;
}
// Is there a point too near? The other side of a thin body is not near.
static inline int cloud_crowded(const scene *s, const point_cloud *c, const cloud_grid *g,
                                const cloud_point *dart) {
    sss_vec3 normal = scene_normal(&s->shape[dart->shape], dart->position);
    for (int k = 0; k < 27; k++) {
        int i = g->head[cloud_cell(g, dart->position, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)];
        for (; i >= 0; i = g->next[i]) {
            sss_vec3 gap = scene_scale(scene_sub(c->point[i].position, dart->position), g->inverse);
            sss_vec3 other = scene_normal(&s->shape[c->point[i].shape], c->point[i].position);
            if (scene_dot(gap, gap) < 1.0f && scene_dot(normal, other) > 0.0f) return 1;
        }
    }
    return 0;
}

// Throws darts and keeps those that are not crowded. Their least distance is 0.8 of the root of the
// wanted area of a point, which about fills the surface. 0 when memory runs out.
static inline int cloud_scatter(point_cloud *c, const scene *s, int wanted, uint32_t seed) {
    tracer_random random = tracer_random_begin(seed, 0u, 0u);
    cloud_grid g = {NULL, NULL, 0u, 0.0f};
    cloud_point dart;
    float total = 0.0f;
    int hits = 0, room = 2 * wanted + 64, thrown = 4096;
    for (int i = 0; i < s->shape_count; i++) total += cloud_stretch(&s->shape[i]);
    for (int i = 0; i < thrown; i++) hits += cloud_dart(s, total, &random, &dart);
    float area =
        4.0f * SCENE_PI * total * (float)hits / (float)thrown; // to 2 %: enough for the distance
    while (g.mask < (uint32_t)room) g.mask = 2u * g.mask + 1u;
    g.inverse = 1.0f / (0.8f * scene_sqrt(area / (float)wanted));
    g.head = (int *)malloc((g.mask + 1u) * sizeof *g.head);
    g.next = (int *)malloc((size_t)room * sizeof *g.next);
    c->point = (cloud_point *)malloc((size_t)room * sizeof *c->point);
    int good = g.head && g.next && c->point;
    if (good) memset(g.head, -1, (g.mask + 1u) * sizeof *g.head);
    for (hits = thrown = 0; good && hits < CLOUD_DARTS * wanted && c->points < room; thrown++) {
        if (!cloud_dart(s, total, &random, &dart)) continue;
        hits++;
        if (cloud_crowded(s, c, &g, &dart)) continue;
        uint32_t cell = cloud_cell(&g, dart.position, 0, 0, 0);
        g.next[c->points] = g.head[cell];
        g.head[cell] = c->points;
        c->point[c->points++] = dart;
    }
    free(g.head);
    free(g.next);
    if (!good) return 0;
    c->area = (float)(4.0 * 3.14159265358979 * (double)total * hits / ((double)thrown * c->points));
    c->disk = scene_sqrt(c->area / SCENE_PI);
    return 1;
}

// ---- The octree

// Children are made of the octants that hold points; a cell's points are put in the order of their
// octants.
static inline int cloud_octant(sss_vec3 center, sss_vec3 p) {
    return (p.x >= center.x) | (p.y >= center.y) << 1 | (p.z >= center.z) << 2;
}
static inline void cloud_split(point_cloud *c, int parent, int depth) {
    cloud_node n = c->node[parent];
    sss_vec3 sum = scene_vec(0.0f, 0.0f, 0.0f), place = sum;
    float power = 0.0f;
    for (int i = n.first; i < n.first + n.count; i++) {
        float weight = scene_mean(c->point[i].light) + 1e-20f;
        sum = scene_add(sum, c->point[i].light);
        place = scene_along(place, c->point[i].position, weight);
        power += weight;
    }
    c->node[parent].light = sum;
    c->node[parent].position = scene_scale(place, 1.0f / power);
    if (n.count <= CLOUD_LEAF || depth == CLOUD_DEPTH || c->nodes + 8 > c->node_room) return;
    c->node[parent].child = c->nodes;
    for (int octant = 0, first = n.first; octant < 8; octant++) {
        int end = first;
        for (int i = first; i < n.first + n.count; i++) {
            if (cloud_octant(n.center, c->point[i].position) != octant) continue;
            cloud_point p = c->point[i];
            c->point[i] = c->point[end];
            c->point[end++] = p;
        }
        if (end == first) continue;
        float half = 0.5f * n.half;
        cloud_node child = {n.center, n.center, n.center, half, first, end - first, 0, 0};
        child.center =
            scene_add(n.center, scene_vec(octant & 1 ? half : -half, octant & 2 ? half : -half,
                                          octant & 4 ? half : -half));
        c->node[c->nodes++] = child;
        c->node[parent].children++;
        first = end;
    }
    for (int k = 0; k < c->node[parent].children; k++)
        cloud_split(c, c->node[parent].child + k, depth + 1);
}

// Takes the irradiance that stands at the points; 0 when memory runs out.
static inline int cloud_gather(point_cloud *c, const sss_medium *m) {
    sss_vec3 low = c->point[0].position, high = low;
    for (int i = 0; i < c->points; i++) {
        sss_vec3 p = c->point[i].position;
        low = scene_vec(scene_min(low.x, p.x), scene_min(low.y, p.y), scene_min(low.z, p.z));
        high = scene_vec(scene_max(high.x, p.x), scene_max(high.y, p.y), scene_max(high.z, p.z));
        c->point[i].light = scene_scale(c->point[i].light, c->area);
    }
    for (int k = 0; k < 3; k++) c->profile[k] = sss_within(m, k, c->disk) / c->area;
    c->node_room = 2 * c->points + 64;
    c->node = (cloud_node *)malloc((size_t)c->node_room * sizeof *c->node);
    if (!c->node) return 0;
    sss_vec3 size = scene_sub(high, low), center = scene_scale(scene_add(low, high), 0.5f);
    float half = 0.5f * scene_max(size.x, scene_max(size.y, size.z));
    cloud_node root = {center, center, center, half, 0, c->points, 0, 0};
    c->node[c->nodes++] = root;
    cloud_split(c, 0, 0);
    return 1;
}

// The sum over the points below one node; `solid` is the solid angle below which a node counts as
// one point.
static inline sss_vec3 cloud_sum(const point_cloud *c, const sss_medium *m, const cloud_node *n,
                                 sss_vec3 x, float solid) {
    sss_vec3 way = scene_sub(n->position, x), out = scene_sub(x, n->center),
             sum = scene_vec(0.0f, 0.0f, 0.0f);
    float squared = scene_dot(way, way),
          side = scene_max(scene_abs(out.x), scene_max(scene_abs(out.y), scene_abs(out.z)));
    if (side > n->half && c->area * (float)n->count < solid * squared)
        return scene_mul(n->light, tracer_profile(m, scene_sqrt(squared)));
    for (int k = 0; k < n->children; k++)
        sum = scene_add(sum, cloud_sum(c, m, &c->node[n->child + k], x, solid));
    for (int i = n->first; !n->children && i < n->first + n->count; i++) {
        way = scene_sub(c->point[i].position, x);
        float r = scene_sqrt(scene_dot(way, way));
        sss_vec3 mean = scene_vec(c->profile[0], c->profile[1], c->profile[2]);
        sum =
            scene_add(sum, scene_mul(c->point[i].light, r < c->disk ? mean : tracer_profile(m, r)));
    }
    return sum;
}
static inline sss_vec3 cloud_lookup(const point_cloud *c, const sss_medium *m, sss_vec3 x,
                                    float solid) {
    return cloud_sum(c, m, &c->node[0], x, solid);
}

#endif
