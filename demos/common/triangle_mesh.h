// triangle_mesh.h - a triangle mesh as files have them, made fit for probes: one vertex a place, no
// triangle twice, outward normals, a size and a place where float32 is at its best. Host only.
// SPDX-License-Identifier: MIT
//
// Positions are brought to the origin and to one size in double precision, before anything else is
// computed: wherever and however large the file's object is, rays meet the same numbers. Corners at
// the same place (to the bit) become one vertex, and so triangles know their neighbours even where
// the file does not say so, as STL never does.
#ifndef TRIANGLE_MESH_H
#define TRIANGLE_MESH_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

// Half the diagonal of the bounding box, in scene units: the size of the demo scenes' objects.
#define MESH_RADIUS 1.2
// Cosine of the angle between faces up to which shading is smooth across their edge.
#define MESH_CREASE 0.6f
// Faces: a vertex of more, such as a globe's pole, is not smoothed. That is work by their square.
#define MESH_CROWD 256
#define MESH_MOST  100000000u // triangles
#define MESH_NONE  0xffffffffu

#define MESH_NO_ROOM "does not fit into memory"

typedef struct triangle_mesh {
    uint32_t vertices, triangles;
    sss_vec3 *position; // and one more than there are: Embree reads 16 bytes of each
    uint32_t *corner;   // three vertices a triangle, counterclockwise seen from outside
    sss_vec3 *shading;  // three normals a triangle
    uint32_t *object;   // of each triangle: see mesh_orient()
    double size[3];     // of the bounding box, in the file's units
    double unit;        // scene units in one of the file's
    uint32_t left_out; // triangles without area, with corners that are no numbers, or there already
} triangle_mesh;

// ---- A set of keys of three words each, which are numbered as they come

typedef struct mesh_set {
    uint32_t *slot, mask, count, (*key)[3];
} mesh_set;

static inline const char *mesh_set_new(mesh_set *set, size_t most) {
    size_t slots = 16;
    while (slots < 2 * most) slots *= 2;
    memset(set, 0, sizeof *set);
    set->slot = (uint32_t *)malloc(slots * sizeof *set->slot);
    set->key = (uint32_t(*)[3])malloc((most + 1) * sizeof *set->key);
    set->mask = (uint32_t)(slots - 1);
    if (set->slot) memset(set->slot, 0xff, slots * sizeof *set->slot);
    return set->slot && set->key ? NULL : MESH_NO_ROOM;
}
static inline void mesh_set_free(mesh_set *set) {
    free(set->slot);
    free(set->key);
}
// The number of a key, a new one at its first time.
static inline uint32_t mesh_set_add(mesh_set *set, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t key[3] = {a, b, c};
    uint32_t place = sss_hash(sss_hash(a, b), c) & set->mask;
    while (set->slot[place] != MESH_NONE &&
           memcmp(set->key[set->slot[place]], key, sizeof key) != 0)
        place = (place + 1) & set->mask;
    if (set->slot[place] == MESH_NONE) {
        set->slot[place] = set->count;
        memcpy(set->key[set->count++], key, sizeof key);
    }
    return set->slot[place];
}

// ---- Vectors in double, and what a triangle spans

typedef struct mesh_vector {
    double x, y, z;
} mesh_vector;

static inline mesh_vector mesh_between(sss_vec3 from, sss_vec3 to) {
    mesh_vector v = {(double)to.x - (double)from.x, (double)to.y - (double)from.y,
                     (double)to.z - (double)from.z};
    return v;
}
static inline mesh_vector mesh_cross(mesh_vector a, mesh_vector b) {
    mesh_vector v = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return v;
}
static inline double mesh_dot(mesh_vector a, mesh_vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The cross product of two edges: along the outward normal, twice the area long.
static inline mesh_vector mesh_span(const triangle_mesh *m, uint32_t triangle) {
    const uint32_t *c = m->corner + 3 * (size_t)triangle;
    return mesh_cross(mesh_between(m->position[c[0]], m->position[c[1]]),
                      mesh_between(m->position[c[0]], m->position[c[2]]));
}
static inline sss_vec3 mesh_direction(mesh_vector v) {
    double inverse = 1.0 / sqrt(mesh_dot(v, v));
    return scene_vec((float)(v.x * inverse), (float)(v.y * inverse), (float)(v.z * inverse));
}
static inline sss_vec3 mesh_normal(const triangle_mesh *m, uint32_t triangle) {
    return mesh_direction(mesh_span(m, triangle));
}

// ---- Which way is out

typedef struct mesh_edge {
    uint32_t side[2], faces; // 3 * triangle + which edge of it; how many triangles it has
} mesh_edge;

// One piece, its triangles in `list`: its faces are turned if its volume about its middle is below
// 0 or, where it is as flat as a sheet, if it faces down.
static inline void mesh_turn_out(const triangle_mesh *m, const uint32_t *list, uint32_t count,
                                 unsigned char *flip) {
    const sss_vec3 zero = {0.0f, 0.0f, 0.0f};
    mesh_vector sum = {0.0, 0.0, 0.0}, middle = {0.0, 0.0, 0.0};
    double moment = 0.0, total = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        mesh_vector n = mesh_span(m, list[i]),
                    p = mesh_between(zero, m->position[m->corner[3 * (size_t)list[i]]]);
        double weight = sqrt(mesh_dot(n, n)), side = flip[list[i]] ? -1.0 : 1.0;
        sum.x += side * n.x, sum.y += side * n.y, sum.z += side * n.z;
        middle.x += weight * p.x, middle.y += weight * p.y, middle.z += weight * p.z;
        moment += side * mesh_dot(n, p);
        total += weight;
    }
    double volume = (moment - mesh_dot(middle, sum) / total) / 6.0, area = 0.5 * total;
    int flat = fabs(volume) < 0.001 * area * sqrt(area); // of a sphere this is 0.094
    for (uint32_t i = 0; i < count && (flat ? sum.y : volume) < 0.0; i++) flip[list[i]] ^= 1;
}

// Turns neighbours the same way, piece by piece, then each piece outwards. Edges of more than two
// triangles join none. A closed piece is an object of its own: light scatters in it alone, whatever
// is beside or inside of it. All open ones together are object 0: they are patches of one body, or
// leaves, or torn along a seam.
enum { MESH_UNSEEN = 2 };
static inline void mesh_orient(const triangle_mesh *m, const mesh_edge *edge,
                               const uint32_t *edge_of, uint32_t *list, unsigned char *flip) {
    uint32_t objects = 0;
    for (uint32_t seed = 0; seed < m->triangles; seed++) {
        uint32_t count = 0, open = 0;
        if (flip[seed] != MESH_UNSEEN) continue;
        flip[seed] = 0;
        list[count++] = seed;
        for (uint32_t done = 0; done < count; done++) {
            for (uint32_t k = 3 * list[done]; k < 3 * list[done] + 3; k++) {
                const mesh_edge *e = &edge[edge_of[k]];
                uint32_t other = e->side[0] == k ? e->side[1] : e->side[0];
                open += e->faces != 2;
                if (e->faces != 2 || flip[other / 3] != MESH_UNSEEN) continue;
                int along = m->corner[k] ==
                            m->corner[other]; // both run along the edge the same way: one is turned
                flip[other / 3] = flip[list[done]] ^ (unsigned char)along;
                list[count++] = other / 3;
            }
        }
        mesh_turn_out(m, list, count, flip);
        objects += !open;
        for (uint32_t i = 0; i < count; i++) m->object[list[i]] = open ? 0 : objects;
    }
}

static inline const char *mesh_find_outside(triangle_mesh *m) {
    size_t corners = 3 * (size_t)m->triangles;
    mesh_set set;
    int good = !mesh_set_new(&set, corners);
    mesh_edge *edge = (mesh_edge *)calloc(corners, sizeof *edge);
    uint32_t *edge_of = (uint32_t *)malloc(corners * sizeof *edge_of);
    uint32_t *list = (uint32_t *)malloc(m->triangles * sizeof *list);
    unsigned char *flip = (unsigned char *)malloc(m->triangles);
    m->object = (uint32_t *)malloc(m->triangles * sizeof *m->object);
    good = good && edge && edge_of && list && flip && m->object;
    for (uint32_t k = 0; good && k < corners; k++) {
        uint32_t a = m->corner[k], b = m->corner[k % 3 == 2 ? k - 2 : k + 1];
        mesh_edge *e = &edge[edge_of[k] = mesh_set_add(&set, a < b ? a : b, a < b ? b : a, 0)];
        if (e->faces < 2) e->side[e->faces] = k;
        e->faces++;
    }
    if (good) memset(flip, MESH_UNSEEN, m->triangles);
    if (good) mesh_orient(m, edge, edge_of, list, flip);
    for (uint32_t i = 0; good && i < m->triangles; i++) {
        uint32_t *c = m->corner + 3 * (size_t)i, kept = c[1];
        if (flip[i]) c[1] = c[2], c[2] = kept;
    }
    mesh_set_free(&set);
    free(edge);
    free(edge_of);
    free(list);
    free(flip);
    return good ? NULL : MESH_NO_ROOM;
}

// ---- Shading normals: at each corner the mean of the faces about the vertex, weighted by their
// angles there, as far as they are not beyond a crease

static inline double mesh_angle(const triangle_mesh *m, uint32_t corner) {
    const uint32_t *c = m->corner + 3 * (size_t)(corner / 3);
    uint32_t i = corner % 3;
    mesh_vector a = mesh_between(m->position[c[i]], m->position[c[(i + 1) % 3]]);
    mesh_vector b = mesh_between(m->position[c[i]], m->position[c[(i + 2) % 3]]),
                n = mesh_cross(a, b);
    return atan2(sqrt(mesh_dot(n, n)), mesh_dot(a, b));
}

static inline void mesh_smooth_vertex(triangle_mesh *m, const uint32_t *list, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        sss_vec3 own = mesh_normal(m, list[i] / 3),
                 sum = count > MESH_CROWD ? own : scene_vec(0.0f, 0.0f, 0.0f);
        for (uint32_t j = 0; j < count && count <= MESH_CROWD; j++) {
            sss_vec3 other = mesh_normal(m, list[j] / 3);
            if (scene_dot(own, other) >= MESH_CREASE)
                sum = scene_along(sum, other, (float)mesh_angle(m, list[j]));
        }
        m->shading[list[i]] = scene_normalize(sum);
    }
}

static inline const char *mesh_smooth(triangle_mesh *m) {
    size_t corners = 3 * (size_t)m->triangles;
    uint32_t *first = (uint32_t *)calloc((size_t)m->vertices + 1, sizeof *first);
    uint32_t *list = (uint32_t *)malloc(corners * sizeof *list);
    m->shading = (sss_vec3 *)malloc(corners * sizeof *m->shading);
    int good = first && list && m->shading;
    for (size_t k = 0; good && k < corners; k++) first[m->corner[k]]++;
    for (uint32_t v = 1; good && v <= m->vertices; v++) first[v] += first[v - 1];
    for (size_t k = corners; good && k-- > 0;) list[--first[m->corner[k]]] = (uint32_t)k;
    for (uint32_t v = 0; good && v < m->vertices; v++)
        mesh_smooth_vertex(m, list + first[v], first[v + 1] - first[v]);
    free(first);
    free(list);
    return good ? NULL : MESH_NO_ROOM;
}

// ---- Making one

static inline int mesh_usable(const float *xyz, size_t vertices, const uint32_t *corner) {
    for (int i = 0; i < 3; i++) {
        if (corner[i] >= vertices) return 0;
        for (int c = 0; c < 3; c++) {
            if (!(fabsf(xyz[3 * (size_t)corner[i] + (size_t)c]) <= FLT_MAX)) return 0;
        }
    }
    return 1;
}

// The bounding box of the triangles that can be used, in the file's units; whether there are any.
static inline int mesh_bounds(const float *xyz, size_t vertices, const uint32_t *corner,
                              size_t triangles, double low[3], double high[3]) {
    int any = 0;
    for (int c = 0; c < 3; c++) low[c] = HUGE_VAL, high[c] = -HUGE_VAL;
    for (size_t k = 0; k < 3 * triangles; k++) {
        if (!mesh_usable(xyz, vertices, corner + k - k % 3)) continue;
        any = 1;
        for (int c = 0; c < 3; c++) {
            double x = (double)xyz[3 * (size_t)corner[k] + (size_t)c];
            low[c] = fmin(low[c], x);
            high[c] = fmax(high[c], x);
        }
    }
    return any;
}

// The vertices at their new place, those at the same place as one; which of them each triangle has.
// A triangle with less than three of them, or with the same three as another, is left out.
static inline void mesh_weld(triangle_mesh *m, mesh_set *places, mesh_set *faces, const float *xyz,
                             size_t vertices, const uint32_t *corner, size_t triangles,
                             const double from[3]) {
    for (size_t i = 0; i < triangles; i++) {
        uint32_t v[3], *kept = m->corner + 3 * (size_t)m->triangles;
        if (!mesh_usable(xyz, vertices, corner + 3 * i)) continue;
        for (int k = 0; k < 3; k++) {
            const float *p = xyz + 3 * (size_t)corner[3 * i + (size_t)k];
            float at[3];
            uint32_t bits[3];
            for (int c = 0; c < 3; c++)
                at[c] = (float)(((double)p[c] - from[c]) * m->unit) + 0.0f; // -0 is 0
            memcpy(bits, at, sizeof bits);
            kept[k] = v[k] = mesh_set_add(places, bits[0], bits[1], bits[2]);
            m->position[v[k]] = scene_vec(at[0], at[1], at[2]);
        }
        uint32_t least = v[0] < v[1] ? v[0] : v[1], most = v[0] < v[1] ? v[1] : v[0],
                 known = faces->count;
        uint32_t low = v[2] < least ? v[2] : least, high = v[2] > most ? v[2] : most;
        mesh_vector span = mesh_span(m, m->triangles);
        if (!(mesh_dot(span, span) > 0.0)) continue;
        mesh_set_add(faces, low, v[0] ^ v[1] ^ v[2] ^ low ^ high, high);
        if (faces->count > known) m->triangles++;
    }
    m->vertices = places->count;
    m->left_out = (uint32_t)(triangles - m->triangles);
}

static inline void mesh_free(triangle_mesh *m) {
    free(m->position);
    free(m->corner);
    free(m->shading);
    free(m->object);
    memset(m, 0, sizeof *m);
}

// From vertices, three numbers each, and triangles, three vertices each: NULL, or what is wrong. It
// stands on y = 0 with its middle on the y axis.
static inline const char *mesh_make(triangle_mesh *m, const float *xyz, size_t vertices,
                                    const uint32_t *corner, size_t triangles) {
    double low[3], high[3], from[3], diagonal = 0.0;
    mesh_set places = {NULL, 0, 0, NULL}, faces = {NULL, 0, 0, NULL};
    memset(m, 0, sizeof *m);
    if (triangles > MESH_MOST) return "has too many triangles";
    if (!mesh_bounds(xyz, vertices, corner, triangles, low, high)) return "has no triangles";
    for (int c = 0; c < 3; c++) {
        m->size[c] = high[c] - low[c];
        from[c] = c == 1 ? low[c] : 0.5 * (low[c] + high[c]);
        diagonal = hypot(diagonal, m->size[c]);
    }
    if (!(diagonal > 0.0)) return "has no size";
    m->unit = 2.0 * MESH_RADIUS / diagonal;
    m->corner = (uint32_t *)malloc(3 * triangles * sizeof *m->corner);
    m->position = (sss_vec3 *)malloc((3 * triangles + 1) * sizeof *m->position);
    const char *wrong = mesh_set_new(&places, 3 * triangles);
    if (!wrong) wrong = mesh_set_new(&faces, triangles);
    if (!m->corner || !m->position) wrong = MESH_NO_ROOM;
    if (!wrong) {
        mesh_weld(m, &places, &faces, xyz, vertices, corner, triangles, from);
        wrong = m->triangles ? mesh_find_outside(m) : "has no triangles with an area";
        if (!wrong) wrong = mesh_smooth(m);
    }
    mesh_set_free(&places);
    mesh_set_free(&faces);
    if (wrong) mesh_free(m);
    return wrong;
}

#endif
