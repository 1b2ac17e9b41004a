// mesh_tracer.h - a path tracer for one translucent mesh on a floor, with sss_resample.h on Embree:
// mesh_lookup() is all that the library asks of a renderer. Host only; link with -lembree3.
// SPDX-License-Identifier: MIT
//
// Light, sky, camera and medium are those of a scene (scene.h) without shapes; the mesh and the
// floor are two geometries of Embree's. Probes ask for all hits on the object that they start from
// (see mesh_orient()) and on nothing else, paths for the nearest hit on anything, light for none.
//
// One crossing, one hit. A line through an edge or a corner meets every triangle there, and with a
// rounding error Embree reports one of them or several. Seen along the line, two triangles with a
// common corner that do not overlap can be met together only at what they share: that is one
// crossing of the surface, and counts once. Where they overlap the surface is folded, and both
// count. That needs the signs of a few determinants and no epsilon, and no distance decides:
// however thin a part, its two sides stay two. (RTC_SCENE_FLAG_ROBUST sees to it that no crossing
// is lost.)
#ifndef MESH_TRACER_H
#define MESH_TRACER_H

#include <embree3/rtcore.h>
#include <stdio.h>

#include "triangle_mesh.h"
#include "tracer.h"

enum { MESH_OBJECT = 0, MESH_FLOOR = 1, MESH_NOTHING = 2 }; // geometry ids

typedef struct mesh_world {
    triangle_mesh m;
    scene s; // without shapes
    RTCDevice device;
    RTCScene rays;
} mesh_world;

// Where a ray met a surface. All of it lies on the triangle to rounding, which `rounding` bounds.
typedef struct mesh_hit {
    unsigned geometry;
    uint32_t triangle;
    float t, u, v; // the place is (1 - u - v, u, v) of the triangle's corners
    float rounding;
    sss_vec3 position, normal,
        shading; // normal: geometric; shading: see mesh_shade(); both of unit length and outward
} mesh_hit;

// Of one lookup: the entry, then what its probes have found. Grows as it must.
typedef struct mesh_hits {
    int count, room;
    mesh_hit *hit;
} mesh_hits;

// What Embree's callbacks are given; `embree` comes first, so that a pointer to it points to all.
typedef struct mesh_query {
    struct RTCIntersectContext embree;
    mesh_hits *hits; // probes: where hits go, and which object's they are
    const uint32_t *object_of;
    uint32_t object;
    unsigned geometry; // paths: the triangle that they leave
    uint32_t triangle;
} mesh_query;

static inline mesh_hit *mesh_hits_next(mesh_hits *hits) {
    if (hits->count == hits->room) {
        hits->room = 2 * hits->room + 32;
        hits->hit = (mesh_hit *)realloc(hits->hit, (size_t)hits->room * sizeof *hits->hit);
        if (!hits->hit) fputs("out of memory\n", stderr), exit(1);
    }
    return &hits->hit[hits->count++];
}

// ---- Embree's side

static inline void mesh_keep(const struct RTCFilterFunctionNArguments *found) {
    mesh_query *query = (mesh_query *)(void *)found->context;
    const struct RTCHit *at = (const struct RTCHit *)(const void *)found->hit; // of one ray: N is 1
    found->valid[0] = 0;                                                       // go on
    if (at->geomID != MESH_OBJECT || query->object_of[at->primID] != query->object) return;
    mesh_hit *hit = mesh_hits_next(query->hits);
    hit->geometry = at->geomID;
    hit->triangle = at->primID;
    hit->t = ((const struct RTCRay *)(const void *)found->ray)->tfar;
    hit->u = at->u;
    hit->v = at->v;
}

static inline void mesh_skip(const struct RTCFilterFunctionNArguments *found) {
    const mesh_query *query = (const mesh_query *)(const void *)found->context;
    const struct RTCHit *at = (const struct RTCHit *)(const void *)found->hit;
    if (at->geomID == query->geometry && at->primID == query->triangle) found->valid[0] = 0;
}

// Of one object alone.
static inline void mesh_only(const struct RTCFilterFunctionNArguments *found) {
    const mesh_query *query = (const mesh_query *)(const void *)found->context;
    const struct RTCHit *at = (const struct RTCHit *)(const void *)found->hit;
    if (at->geomID != MESH_OBJECT || query->object_of[at->primID] != query->object)
        found->valid[0] = 0;
}

static inline struct RTCRay mesh_ray(sss_vec3 origin, sss_vec3 direction, float length) {
    struct RTCRay ray;
    memset(&ray, 0, sizeof ray);
    ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
    ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
    ray.tfar = length;
    ray.mask = 0xffffffffu;
    return ray;
}

static inline void mesh_trace(const mesh_world *w, mesh_query *query, RTCFilterFunctionN filter,
                              struct RTCRayHit *ray) {
    rtcInitIntersectContext(&query->embree);
    query->embree.filter = filter;
    ray->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(w->rays, &query->embree, ray);
}

// ---- Hits

static inline const uint32_t *mesh_corners(const mesh_world *w, uint32_t triangle) {
    return w->m.corner + 3 * (size_t)triangle;
}

// The rest of a hit on the object, from its place on the triangle: nearer to it than any t is. Each
// component has a few roundings of numbers that are at most |position| + |edge| + |edge|, each of
// them half of 2^-23.
static inline void mesh_fill(const mesh_world *w, mesh_hit *hit) {
    const uint32_t *c = mesh_corners(w, hit->triangle);
    const sss_vec3 *at = w->m.position;
    sss_vec3 a = scene_sub(at[c[1]], at[c[0]]), b = scene_sub(at[c[2]], at[c[0]]), n;
    hit->position = scene_along(scene_along(at[c[0]], a, hit->u), b, hit->v);
    hit->normal = n = mesh_normal(&w->m, hit->triangle);
    hit->rounding =
        0x1p-22f *
        (scene_abs(n.x) * (scene_abs(hit->position.x) + scene_abs(a.x) + scene_abs(b.x)) +
         scene_abs(n.y) * (scene_abs(hit->position.y) + scene_abs(a.y) + scene_abs(b.y)) +
         scene_abs(n.z) * (scene_abs(hit->position.z) + scene_abs(a.z) + scene_abs(b.z)));
}

// Its shading normal, which only what is shaded needs.
static inline void mesh_shade(const mesh_world *w, mesh_hit *hit) {
    const sss_vec3 *normal = w->m.shading + 3 * (size_t)hit->triangle;
    sss_vec3 sum = scene_along(scene_scale(normal[0], 1.0f - hit->u - hit->v), normal[1], hit->u);
    hit->shading = scene_normalize(scene_along(sum, normal[2], hit->v));
}

static inline void mesh_fill_floor(mesh_hit *hit, sss_vec3 position) {
    hit->position = scene_vec(position.x, 0.0f, position.z);
    hit->normal = hit->shading = scene_vec(0.0f, 1.0f, 0.0f);
    hit->rounding = 0.0f;
}

// Does the wedge from a to b, less than half a turn about d, hold v? Its first side is in it, its
// second is not.
static inline double mesh_turn(mesh_vector d, mesh_vector a, mesh_vector b) {
    return mesh_dot(d, mesh_cross(a, b));
}
static inline int mesh_in_wedge(mesh_vector d, mesh_vector a, mesh_vector b, mesh_vector v) {
    return mesh_turn(d, a, v) >= 0.0 && mesh_turn(d, v, b) > 0.0;
}

// The two sides of a triangle from its corner k, in positive order about d.
static inline void mesh_wedge(const mesh_world *w, const uint32_t *c, int k, mesh_vector d,
                              mesh_vector side[2]) {
    const sss_vec3 *at = w->m.position;
    side[0] = mesh_between(at[c[k]], at[c[(k + 1) % 3]]);
    side[1] = mesh_between(at[c[k]], at[c[(k + 2) % 3]]);
    if (mesh_turn(d, side[0], side[1]) >= 0.0) return;
    mesh_vector kept = side[0];
    side[0] = side[1];
    side[1] = kept;
}

// Have these two triangles, both met by a line along `direction`, been met at one crossing? See the
// head of the file.
static inline int mesh_same_crossing(const mesh_world *w, sss_vec3 direction, uint32_t triangle,
                                     uint32_t other) {
    const uint32_t *a = mesh_corners(w, triangle), *b = mesh_corners(w, other);
    if (triangle == other) return 1;
    for (int k = 0; k < 9; k++) {
        if (a[k / 3] != b[k % 3]) continue;
        const mesh_vector d = {(double)direction.x, (double)direction.y, (double)direction.z};
        mesh_vector p[2], q[2];
        mesh_wedge(w, a, k / 3, d, p);
        mesh_wedge(w, b, k % 3, d, q);
        return !mesh_in_wedge(d, p[0], p[1], q[0]) && !mesh_in_wedge(d, q[0], q[1], p[0]);
    }
    return 0;
}

// All crossings of the segment with one of the mesh's objects, nearest first, behind the hits that
// are there.
static inline void mesh_all_hits(const mesh_world *w, uint32_t object, sss_vec3 origin,
                                 sss_vec3 direction, float length, mesh_hits *hits) {
    int first = hits->count, kept = first;
    mesh_query query;
    struct RTCRayHit ray;
    query.hits = hits;
    query.object_of = w->m.object;
    query.object = object;
    ray.ray = mesh_ray(origin, direction, length);
    mesh_trace(w, &query, mesh_keep, &ray);
    for (int i = first; i < hits->count; i++) {
        mesh_hit hit = hits->hit[i];
        int place = kept, known = 0;
        for (int k = first; k < kept && !known; k++)
            known = mesh_same_crossing(w, direction, hits->hit[k].triangle, hit.triangle);
        if (known) continue;
        for (; place > first && hits->hit[place - 1].t > hit.t; place--)
            hits->hit[place] = hits->hit[place - 1];
        mesh_fill(w, &hit);
        hits->hit[place] = hit;
        kept++;
    }
    hits->count = kept;
}

// Where a path that goes on from a hit begins: off the triangle by what its position may have been
// rounded.
static inline sss_vec3 mesh_off(const mesh_hit *from) {
    return scene_along(from->position, from->normal, from->rounding);
}

// What a ray meets first; `from` is where it begins, NULL for the camera.
static inline mesh_hit mesh_nearest(const mesh_world *w, sss_vec3 origin, sss_vec3 direction,
                                    const mesh_hit *from) {
    mesh_hit hit;
    mesh_query query;
    struct RTCRayHit ray;
    query.geometry = from ? from->geometry : MESH_NOTHING;
    query.triangle = from ? from->triangle : 0;
    ray.ray = mesh_ray(from ? mesh_off(from) : origin, direction, HUGE_VALF);
    mesh_trace(w, &query, mesh_skip, &ray);
    memset(&hit, 0, sizeof hit);
    hit.geometry = ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? MESH_NOTHING : ray.hit.geomID;
    hit.triangle = ray.hit.primID;
    hit.t = ray.ray.tfar;
    hit.u = ray.hit.u;
    hit.v = ray.hit.v;
    if (hit.geometry == MESH_OBJECT) mesh_fill(w, &hit);
    if (hit.geometry == MESH_FLOOR) mesh_fill_floor(&hit, scene_along(origin, direction, hit.t));
    return hit;
}

static inline int mesh_occluded(const mesh_world *w, const mesh_hit *from, sss_vec3 direction,
                                float length) {
    mesh_query query;
    query.geometry = from->geometry;
    query.triangle = from->triangle;
    struct RTCRay ray = mesh_ray(mesh_off(from), direction, length);
    rtcInitIntersectContext(&query.embree);
    query.embree.filter = mesh_skip;
    rtcOccluded1(w->rays, &query.embree, &ray);
    return ray.tfar < 0.0f;
}

// The first hit of the segment with one of the mesh's objects, behind the hits that are there; or
// none.
static inline void mesh_first_hit(const mesh_world *w, uint32_t object, sss_vec3 origin,
                                  sss_vec3 direction, float length, mesh_hits *hits) {
    mesh_query query;
    struct RTCRayHit ray;
    query.object_of = w->m.object;
    query.object = object;
    ray.ray = mesh_ray(origin, direction, length);
    mesh_trace(w, &query, mesh_only, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;

    mesh_hit *hit = mesh_hits_next(hits);
    hit->geometry = MESH_OBJECT;
    hit->triangle = ray.hit.primID;
    hit->t = ray.ray.tfar;
    hit->u = ray.hit.u;
    hit->v = ray.hit.v;
    mesh_fill(w, hit);
}

// ---- The library at work: one lookup from the entry, hits->hit[0]

// As tracer_radius(): what hits->hit[0] can touch from inside or outside.
static inline float mesh_radius(const mesh_world *w, mesh_hits *hits) {
    const mesh_hit entry = hits->hit[0];
    uint32_t object = w->m.object[entry.triangle];
    float radius = 1e30f, cosine;
    for (int i = 0; i < TRACER_FEELERS; i++) {
        sss_vec3 direction = tracer_feeler(entry.normal, i, &cosine);
        sss_vec3 origin = scene_along(entry.position, direction, TRACER_NEAR);
        hits->count = 1;
        mesh_first_hit(w, object, origin, direction, 1e3f, hits);
        if (hits->count == 1) continue;
        float distance = hits->hit[1].t + TRACER_NEAR;
        radius = scene_min(radius, distance / (2.0f * scene_abs(cosine)));
    }
    hits->count = 1;
    return radius;
}

static inline sss_plan mesh_plan(const mesh_world *w, tracer_settings settings, mesh_hits *hits) {
    if (settings.method == TRACER_PLAIN) return tracer_plain_plan();
    if (!(settings.tolerance > 0.0f)) return settings.plan;
    float footprint = tracer_footprint(&w->s, settings, hits->hit[0].position);
    return tracer_choose(&w->s.medium, settings, footprint, mesh_radius(w, hits));
}

// The number of exits; on[i] is the hit that exits[i] was, or the entry. What follows the entry in
// `hits` are the hits in the order of the calls.
static inline int mesh_lookup(const mesh_world *w, tracer_settings settings, sss_plan plan,
                              uint32_t seed, uint32_t sample, mesh_hits *hits, sss_exit *exits,
                              mesh_hit *on, uint32_t *probes) {
    sss_resampler s;
    sss_probe probe;
    uint32_t object = w->m.object[hits->hit[0].triangle];
    hits->count = 1;
    sss_begin_sample(&s, &w->s.medium, &plan, hits->hit[0].position, hits->hit[0].normal, seed,
                     sample);
    while (sss_next_probe(&s, &probe)) {
        int i = hits->count;
        if (plan.techniques == SSS_WALK) {
            mesh_first_hit(w, object, probe.origin, probe.direction, probe.length, hits);
        } else {
            mesh_all_hits(w, object, probe.origin, probe.direction, probe.length, hits);
        }
        for (; i < hits->count; i++) {
            mesh_hit *h = &hits->hit[i];
            if (settings.light_aware) mesh_shade(w, h);
            sss_add_hit(&s, h->position, h->normal,
                        settings.light_aware ? tracer_light_guess(&w->s, h->position, h->shading)
                                             : 1.0f);
        }
        ++*probes;
    }
    int count = sss_finish(&s, exits);
    for (int i = 0; i < count; i++) {
        on[i] = hits->hit[1 + exits[i].hit];
        mesh_shade(w, &on[i]);
    }
    return count;
}

// ---- The path, as in tracer.h: the lamp by one shadow ray, all else by one ray that goes on, with
// the closed surroundings as its control variate.

// Irradiance from the lamp. Light from behind the triangle does not count, wherever the shading
// normal points.
static inline sss_vec3 mesh_light(const mesh_world *w, const mesh_hit *at, float u, float v) {
    const scene_light *light = &w->s.light;
    tracer_point point = {at->position, at->shading, {1.0f, 1.0f, 1.0f}, SCENE_NOTHING};
    sss_vec3 to = scene_along(scene_along(light->center, light->u, 2.0f * u - 1.0f), light->v,
                              2.0f * v - 1.0f);
    sss_vec3 path = scene_sub(to, at->position), irradiance = tracer_light(&w->s, point, u, v);
    float length = scene_sqrt(scene_dot(path, path));
    int dark = !(scene_mean(irradiance) > 0.0f) || scene_dot(path, at->normal) <= 0.0f;
    if (!dark) dark = mesh_occluded(w, at, scene_scale(path, 1.0f / length), length);
    return dark ? scene_vec(0.0f, 0.0f, 0.0f) : irradiance;
}

typedef struct mesh_path {
    tracer_random random;
    sss_vec3 origin, direction, throughput;
    mesh_hit at; // what the ray leaves, if surface > 0
    uint32_t surface;
    int dark; // the ray goes behind the triangle that it leaves
} mesh_path;

static inline mesh_path mesh_begin(const mesh_world *w, tracer_settings settings, int x, int y,
                                   uint32_t sample) {
    mesh_path path;
    uint32_t pixel = (uint32_t)y * (uint32_t)settings.width + (uint32_t)x;
    memset(&path, 0, sizeof path);
    path.random = tracer_random_begin(settings.seed, pixel, sample);
    float px = (float)x + tracer_stratified(&path.random, TRACER_STRATIFY_PIXEL);
    float py = (float)y + tracer_stratified(&path.random, TRACER_STRATIFY_PIXEL + 1u);
    path.origin = w->s.eye;
    path.direction = tracer_camera(&w->s, settings.width, settings.height, px, py);
    path.throughput = scene_vec(1.0f, 1.0f, 1.0f);
    return path;
}

// The irradiance but for the one ray that goes on. `first`: of the path.
static inline sss_vec3 mesh_irradiance(const mesh_world *w, const mesh_hit *at, int first,
                                       tracer_random *random) {
    float u = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT) : tracer_next(random);
    float v = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT + 1u) : tracer_next(random);
    scene_ambient around = scene_make_ambient(&w->s, at->position);
    return scene_add(mesh_light(w, at, u, v), scene_ambient_irradiance(around, at->shading));
}

// The path goes on from path->at by one ray. Returns the radiance along it that has been counted
// already.
static inline sss_vec3 mesh_go_on(const mesh_world *w, mesh_path *path) {
    tracer_random *random = &path->random;
    int first = path->surface == 0u;
    float u = first ? tracer_stratified(random, TRACER_STRATIFY_DIRECTION) : tracer_next(random);
    float v =
        first ? tracer_stratified(random, TRACER_STRATIFY_DIRECTION + 1u) : tracer_next(random);
    path->direction = tracer_about(path->at.shading, scene_sqrt(1.0f - u), scene_sqrt(u), v);
    path->origin = path->at.position;
    path->surface++;
    path->dark = scene_dot(path->direction, path->at.normal) <= 0.0f;
    return scene_ambient_radiance(scene_make_ambient(&w->s, path->origin), path->direction);
}

// One of several exits goes on, in proportion to its weight; *over_chance is 1 over the chance.
static inline int mesh_choose(const sss_exit *exits, int count, sss_vec3 throughput,
                              tracer_random *random, float *over_chance) {
    float total = 0.0f, chosen_weight = 1.0f;
    int chosen = 0;
    for (int k = 0; k < count; k++) {
        const float *e = exits[k].weight;
        float weight = scene_dot(throughput, scene_vec(e[0], e[1], e[2]));
        total += weight;
        if (count > 1 && tracer_next(random) * total < weight) chosen = k;
        if (chosen == k) chosen_weight = weight;
    }
    *over_chance = count > 1 && chosen_weight > 0.0f ? total / chosen_weight : 1.0f;
    return chosen;
}

// The surface that the path has met: its exits, or the floor itself. Returns their number.
static inline int mesh_surface(const mesh_world *w, tracer_settings settings, mesh_path *path,
                               mesh_hit hit, mesh_hits *hits, sss_exit *exits, mesh_hit *on,
                               tracer_result *result) {
    if (hit.geometry != MESH_OBJECT) {
        exits[0].weight[0] = w->s.floor_albedo.x;
        exits[0].weight[1] = w->s.floor_albedo.y;
        exits[0].weight[2] = w->s.floor_albedo.z;
        on[0] = hit;
        return 1;
    }
    hits->count = 0;
    *mesh_hits_next(hits) = hit;
    sss_plan plan = mesh_plan(w, settings, hits);
    uint32_t seed = sss_hash(path->random.pixel_key, 0x40000000u + path->surface);
    int count =
        mesh_lookup(w, settings, plan, seed, path->random.sample, hits, exits, on, &result->probes);
    result->shaded += (uint32_t)count;
    return count;
}

// Adds what a path gathers along its ray and behind it.
static inline void mesh_follow(const mesh_world *w, tracer_settings settings, mesh_path *path,
                               mesh_hits *hits, tracer_result *result) {
    while (path->origin.y >= 0.0f && !path->dark) {
        sss_exit exits[SSS_MAX_EXITS];
        mesh_hit on[SSS_MAX_EXITS];
        mesh_hit hit =
            mesh_nearest(w, path->origin, path->direction, path->surface ? &path->at : NULL);
        if (hit.geometry == MESH_NOTHING) {
            sss_vec3 sky = scene_sky(&w->s, path->direction);
            result->radiance = scene_add(result->radiance, scene_mul(path->throughput, sky));
            return;
        }
        if (path->surface == TRACER_MAX_SURFACES) return;
        int count = mesh_surface(w, settings, path, hit, hits, exits, on, result);
        if (count == 0) return;

        for (int k = 0; k < count; k++) {
            sss_vec3 weight = scene_vec(exits[k].weight[0], exits[k].weight[1], exits[k].weight[2]);
            int first = path->surface == 0u && k == 0;
            sss_vec3 irradiance = mesh_irradiance(w, &on[k], first, &path->random);
            weight = scene_scale(scene_mul(path->throughput, weight), 1.0f / SCENE_PI);
            result->radiance = scene_add(result->radiance, scene_mul(weight, irradiance));
        }
        float over_chance;
        int chosen = mesh_choose(exits, count, path->throughput, &path->random, &over_chance);
        const float *e = exits[chosen].weight;
        sss_vec3 weight = scene_scale(scene_vec(e[0], e[1], e[2]), over_chance);
        path->throughput = scene_mul(path->throughput, weight);
        if (!(scene_mean(path->throughput) > 0.0f)) return;
        path->at = on[chosen];
        sss_vec3 expected = mesh_go_on(w, path);
        result->radiance = scene_sub(result->radiance, scene_mul(path->throughput, expected));
    }
}

static inline tracer_result mesh_sample(const mesh_world *w, tracer_settings settings, int x, int y,
                                        uint32_t sample, mesh_hits *hits) {
    tracer_result result = tracer_no_result();
    mesh_path path = mesh_begin(w, settings, x, y, sample);
    mesh_follow(w, settings, &path, hits, &result);
    return result;
}

// ---- Tiles, as in tracer.h. A group is one of the mesh's objects.

static inline tracer_result mesh_tile_begin(const mesh_world *w, tracer_settings settings, int x,
                                            int y, uint32_t sample, int i, mesh_hits *hits,
                                            tracer_tile *tile) {
    tracer_result result = tracer_no_result();
    mesh_path path = mesh_begin(w, settings, x, y, sample);
    mesh_hit hit = mesh_nearest(w, path.origin, path.direction, NULL), on[SSS_MAX_EXITS];
    sss_plan plan = settings.plan;
    int shares = hit.geometry == MESH_OBJECT;
    if (shares) {
        hits->count = 0;
        *mesh_hits_next(hits) = hit;
        plan = mesh_plan(w, settings, hits);
        shares = tracer_may_share(settings, plan);
    }
    if (!shares) {
        mesh_follow(w, settings, &path, hits, &result);
        return result;
    }

    uint32_t seed = sss_hash(path.random.pixel_key, 0x40000000u);
    int count = mesh_lookup(w, settings, plan, seed, path.random.sample, hits, tile->exit[i], on,
                            &result.probes);
    result.shaded = (uint32_t)count;
    tile->group[i] = (int)w->m.object[hit.triangle];
    tile->count[i] = count;
    tile->entry[i] = hit.position;
    tile->footprint[i] = tracer_footprint(&w->s, settings, hit.position);
    if (count == 0) return result;

    for (int k = 0; k < count; k++)
        tile->light[i][k] = mesh_irradiance(w, &on[k], k == 0, &path.random);
    float over_chance;
    int chosen = mesh_choose(tile->exit[i], count, path.throughput, &path.random, &over_chance);
    path.at = on[chosen];
    sss_vec3 expected = mesh_go_on(w, &path);
    mesh_follow(w, settings, &path, hits, &result);
    sss_vec3 more = scene_scale(scene_sub(result.radiance, expected), SCENE_PI * over_chance);
    tile->light[i][chosen] = scene_add(tile->light[i][chosen], more);
    result.radiance = scene_vec(0.0f, 0.0f, 0.0f);
    return result;
}

static inline tracer_result mesh_tile_sample(const mesh_world *w, tracer_settings settings,
                                             int column, int row, uint32_t sample, mesh_hits *hits,
                                             sss_vec3 *radiance) {
    tracer_result all = tracer_no_result();
    tracer_tile tile;
    int x, y;
    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        tracer_tile_clear(&tile, i);
        radiance[i] = scene_vec(0.0f, 0.0f, 0.0f);
        if (!tracer_tile_pixel(settings, sample, column, row, i, &x, &y)) continue;
        tracer_result one = mesh_tile_begin(w, settings, x, y, sample, i, hits, &tile);
        radiance[i] = one.radiance;
        all.probes += one.probes;
        all.shaded += one.shaded;
    }
    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        int group = tile.group[i], is_first = group >= 0;
        for (int k = 0; k < i; k++) is_first &= tile.group[k] != group;
        if (is_first) tracer_tile_share(&w->s.medium, &tile, group, radiance);
    }
    return all;
}

// ---- The world about the mesh

static inline void mesh_add_geometry(mesh_world *w, unsigned id, const sss_vec3 *position,
                                     size_t vertices, const uint32_t *corner, size_t triangles) {
    RTCGeometry g = rtcNewGeometry(w->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, position, 0,
                               sizeof *position, vertices);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corner, 0,
                               3 * sizeof *corner, triangles);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(w->rays, g, id);
    rtcReleaseGeometry(g);
}

// Makes w->m ready for rays: NULL, or what is wrong. The floor reaches 1000 units to all sides, the
// camera sees none of its ends.
static inline const char *mesh_open(mesh_world *w) {
    static const sss_vec3 floor_at[5] = {{-1e3f, 0.0f, -1e3f},
                                         {-1e3f, 0.0f, 1e3f},
                                         {1e3f, 0.0f, 1e3f},
                                         {1e3f, 0.0f, -1e3f},
                                         {0.0f, 0.0f, 0.0f}};
    static const uint32_t floor_corner[6] = {0, 1, 2, 0, 2, 3};
    w->device = rtcNewDevice(NULL);
    if (!w->device) return "Embree does not start";
    w->rays = rtcNewScene(w->device);
    rtcSetSceneFlags(w->rays, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    mesh_add_geometry(w, MESH_OBJECT, w->m.position, w->m.vertices, w->m.corner, w->m.triangles);
    mesh_add_geometry(w, MESH_FLOOR, floor_at, 4, floor_corner, 2);
    rtcCommitScene(w->rays);
    return rtcGetDeviceError(w->device) == RTC_ERROR_NONE ? NULL : "Embree cannot build its tree";
}

static inline void mesh_close(mesh_world *w) {
    if (w->rays) rtcReleaseScene(w->rays);
    if (w->device) rtcReleaseDevice(w->device);
    mesh_free(&w->m);
    w->rays = NULL;
    w->device = NULL;
}

#endif
