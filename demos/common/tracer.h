// tracer.h - a path tracer whose translucent object is shaded with sss_resample.h; C99, C++11 and
// OpenCL C 1.2. SPDX-License-Identifier: MIT
//
// One call, tracer_sample(), traces one path and returns its radiance. A sample is named by (pixel,
// sample, seed) alone, so the picture does not depend on threads, tiles or devices.
//
// At each surface the path has a set of *points*: the floor point itself, the exits of a lookup or,
// in the brute force reference, points all over the object. Every point gets next-event estimation
// to the area light as a white Lambert surface, times its weight. One point is drawn in proportion
// to its weight and continues the path with one cosine-distributed ray; that ray also collects the
// sky when nothing stops it, so no light is counted twice (rays pass through the area light). A
// control variate takes most of the noise out of that one ray: the surroundings without the object,
// known in closed form, are added at every point, and their radiance along the ray is taken off
// again. Paths end after TRACER_MAX_SURFACES surfaces; there is no Russian roulette. Fresnel
// reflection is left out: it is the caller's matter in the library, and one effect less between
// picture and claim.
//
// With a tile (settings.plan.tile) paths whose first surface is the object share their exits: each
// looks up and shades its own, the whole path behind it included, and then every exit of the tile
// serves every path of the tile. See tracer_tile.
#ifndef TRACER_H
#define TRACER_H

#include "scene.h"

#define TRACER_MAX_SURFACES 4
// Area points in each lookup of the reference: its relative variance per sample is then 0.3 (bear)
// to 2.8 (needles).
#define TRACER_AREA_POINTS 16
#define TRACER_MAX_POINTS  (TRACER_AREA_POINTS > SSS_MAX_EXITS ? TRACER_AREA_POINTS : SSS_MAX_EXITS)

enum { TRACER_PLAIN = 0, TRACER_RESAMPLED = 1, TRACER_REFERENCE = 2 };

typedef struct tracer_settings {
    int method;
    int light_aware; // resampled: with a light hint at each candidate
    sss_plan plan;   // resampled: as given; plain: see tracer_plain_plan
    float tolerance; // above 0: sss_plan_for chooses the model of each lookup, for this error
    int width, height;
    uint32_t seed;
} tracer_settings;

typedef struct tracer_result {
    sss_vec3 radiance;
    uint32_t probes; // segments traced
    uint32_t shaded; // exits or area points that got next-event estimation
} tracer_result;

// A point that is shaded as a white Lambert surface, times its weight.
typedef struct tracer_point {
    sss_vec3 position, normal, weight;
    int shape;
} tracer_point;

typedef struct tracer_points {
    int count;
    tracer_point point[TRACER_MAX_POINTS];
} tracer_points;

// What the paths of a tile know of each other, pixel by pixel.
#define TRACER_MAX_TILE    8
#define TRACER_TILE_PIXELS (TRACER_MAX_TILE * TRACER_MAX_TILE)
typedef struct tracer_tile {
    int group[TRACER_TILE_PIXELS]; // members of one object have one number; -1: no member
    int count[TRACER_TILE_PIXELS]; // of exits
    sss_vec3 entry[TRACER_TILE_PIXELS];
    float footprint[TRACER_TILE_PIXELS];
    sss_exit exit[TRACER_TILE_PIXELS][SSS_MAX_EXITS];
    sss_vec3 light[TRACER_TILE_PIXELS][SSS_MAX_EXITS]; // irradiance there
    float density[TRACER_TILE_PIXELS][SSS_MAX_EXITS];  // kernels: summed over the group
} tracer_tile;

// Random numbers of one sample: a few stratified over the samples of a pixel, the others plain
// hashes.
typedef struct tracer_random {
    uint32_t pixel_key, sample, sample_key, dimension;
} tracer_random;

enum { TRACER_STRATIFY_PIXEL = 0, TRACER_STRATIFY_LIGHT = 2, TRACER_STRATIFY_DIRECTION = 4 };

// King et al. 2013: one probe a lookup, along the normal or one of two tangents, and nothing to
// choose from.
static inline sss_plan tracer_plain_plan(void) {
    sss_plan plan;
    plan.candidates = 1;
    plan.exits = 1;
    plan.techniques = SSS_DISK | SSS_DISK_TANGENTS;
    plan.independent = 1;
    plan.per_channel = 0;
    plan.tile = 0;
    return plan;
}

static inline tracer_random tracer_random_begin(uint32_t seed, uint32_t pixel, uint32_t sample) {
    tracer_random r;
    r.pixel_key = sss_hash(sss_hash(seed, 0x7261u), pixel);
    r.sample = sample;
    r.sample_key = sss_hash(r.pixel_key, sample);
    r.dimension = 16u;
    return r;
}

// A number in [0, 1).
static inline float tracer_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

static inline float tracer_next(tracer_random *r) {
    return tracer_unit(sss_hash(r->sample_key, r->dimension++));
}

// Coordinate `d` (0..5) of a rank-1 sequence: sample k sits at offset + k g^-(d+1) mod 1, g^7 = g +
// 1 (the golden ratio's cousin in six dimensions), with the offset hashed from the pixel. Even for
// every number of samples, in any order.
static inline uint32_t tracer_step(uint32_t d) {
    switch (d) {
    case 0u: return 3859688307u;
    case 1u: return 3468523227u;
    case 2u: return 3117001275u;
    case 3u: return 2801104767u;
    case 4u: return 2517223199u;
    }
    return 2262111973u;
}
static inline float tracer_stratified(const tracer_random *r, uint32_t d) {
    uint32_t offset = sss_hash(r->pixel_key, 0x80000000u + d);
    return tracer_unit(offset + r->sample * tracer_step(d));
}

// A unit vector that is nowhere near parallel to n, crossed with n.
static inline sss_vec3 tracer_tangent(sss_vec3 n) {
    sss_vec3 other =
        scene_abs(n.x) < 0.6f ? scene_vec(1.0f, 0.0f, 0.0f) : scene_vec(0.0f, 1.0f, 0.0f);
    return scene_normalize(scene_cross(other, n));
}

// The direction at cosine z and sine r from n, turned about it by u of a full turn.
static inline sss_vec3 tracer_about(sss_vec3 n, float z, float r, float u) {
    sss_vec3 t = tracer_tangent(n), b = scene_cross(n, t);
    float sine, cosine;

    // Private to the header, and borrowed because it has the same bits on every device.
    sssi_sincos_turn(u, &sine, &cosine);
    return scene_add(scene_scale(n, z),
                     scene_add(scene_scale(t, r * cosine), scene_scale(b, r * sine)));
}

// The camera ray's direction through a point of the image, in pixels; (0, 0) is the top left
// corner. The central square of the picture sees the same whatever the shape of the image.
static inline sss_vec3 tracer_camera(const SCENE_SPACE scene *s, int width, int height, float x,
                                     float y) {
    float side = 1.0f / (float)(width < height ? width : height);
    sss_vec3 d = scene_along(s->forward, s->right, (2.0f * x - (float)width) * side);
    return scene_normalize(scene_along(d, s->up, ((float)height - 2.0f * y) * side));
}

// Irradiance from the area light, estimated by one point of it.
static inline sss_vec3 tracer_light(const SCENE_SPACE scene *s, tracer_point point, float u,
                                    float v) {
    sss_vec3 none = scene_vec(0.0f, 0.0f, 0.0f);
    sss_vec3 at = scene_along(scene_along(s->light.center, s->light.u, 2.0f * u - 1.0f), s->light.v,
                              2.0f * v - 1.0f);
    sss_vec3 path = scene_sub(at, point.position);
    float squared = scene_dot(path, path), distance = scene_sqrt(squared);
    if (!(distance > 0.0f)) return none;
    sss_vec3 direction = scene_scale(path, 1.0f / distance);
    float here = scene_dot(direction, point.normal), there = -scene_dot(direction, s->light.normal);
    if (here <= 0.0f || there <= 0.0f) return none;
    if (point.position.y < 0.0f) return none; // below the floor it is dark
    if (scene_occluded(s, point.position, direction, distance, point.shape)) return none;
    return scene_scale(s->light.radiance, here * there * s->light.area / squared);
}

// A guess of the irradiance at a candidate, without a single ray: the light as a disk seen from
// here, faded where it sinks below the horizon of the surface, and the surroundings without the
// object.
static inline float tracer_light_guess(const SCENE_SPACE scene *s, sss_vec3 position,
                                       sss_vec3 normal) {
    sss_vec3 path = scene_sub(s->light.center, position);
    float squared = scene_dot(path, path), inverse = 1.0f / scene_sqrt(squared);
    float here = scene_dot(path, normal) * inverse,
          there = -scene_dot(path, s->light.normal) * inverse;
    float wide = s->light.radius * inverse; // sine of the light's radius
    if (here < wide) here = here <= -wide ? 0.0f : (here + wide) * (here + wide) / (4.0f * wide);
    float direct =
        scene_mean(s->light.radiance) * here * scene_max(there, 0.0f) * s->light.area / squared;
    return direct + scene_mean(scene_ambient_irradiance(scene_make_ambient(s, position), normal));
}

// How wide a pixel is at a point.
static inline float tracer_footprint(const SCENE_SPACE scene *s, tracer_settings settings,
                                     sss_vec3 position) {
    int side = settings.width < settings.height ? settings.width : settings.height;
    float depth = scene_abs(scene_dot(scene_sub(position, s->eye), s->forward));
    return depth * 2.0f * scene_sqrt(scene_dot(s->right, s->right)) / (float)side;
}

// The direction of ray i of TRACER_FEELERS, which look for other surfaces about an entry: one goes
// straight in, three in and three out at 60 degrees from the normal. *cosine: with the normal.
#define TRACER_FEELERS 7
static inline sss_vec3 tracer_feeler(sss_vec3 normal, int i, float *cosine) {
    float aside = i < 4 ? -0.5f : 0.5f;
    *cosine = i == 0 ? -1.0f : aside;
    return tracer_about(normal, *cosine, i == 0 ? 0.0f : 0.8660254f, (float)(i % 3) / 3.0f);
}

// The radius of the largest ball that touches the surface at the entry and holds no other surface,
// as far as the feelers tell: a hit y allows |y - x|^2 / (2 |n.(y - x)|). What is nearer than
// TRACER_NEAR is the entry itself.
#define TRACER_NEAR 2e-3f
static inline float tracer_radius(const SCENE_SPACE scene *s, sss_vec3 position, sss_vec3 normal) {
    scene_hits hits;
    float radius = 1e30f, cosine;

    for (int i = 0; i < TRACER_FEELERS; i++) {
        sss_vec3 direction = tracer_feeler(normal, i, &cosine);
        scene_segment_hits(s, position, direction, 1e3f, &hits);
        for (int k = 0; k < hits.count; k++) {
            if (hits.hit[k].t < TRACER_NEAR) continue;
            radius = scene_min(radius, hits.hit[k].t / (2.0f * scene_abs(cosine)));
        }
    }
    return radius;
}

// An exit costs a ray to the light and one that goes on.
#define TRACER_SHADING_COST 2.0f

// The plan of a lookup whose model the user leaves open. sss_plan_for gives the techniques, and the
// candidates of a disk, of a walk, and where the user names none. All else is settings.plan.
static inline sss_plan tracer_choose(const sss_medium *m, tracer_settings settings, float footprint,
                                     float radius) {
    sss_need need;
    need.footprint = footprint;
    need.curvature_radius = radius;
    need.shading_cost = settings.plan.tile > 1 ? TRACER_SHADING_COST : 0.0f;
    need.tolerance = settings.tolerance;
    need.hinted = settings.light_aware;

    sss_plan chosen = sss_plan_for(m, &need), plan = settings.plan;
    plan.techniques = chosen.techniques;
    int probes = chosen.techniques != SSS_DISK && chosen.techniques != SSS_WALK;
    if (!probes || plan.candidates == 0) plan.candidates = chosen.candidates;
    return plan;
}

// What sss_plan_for advises on sharing, and what goes with it, on a body on which the profile is
// right.
static inline sss_plan tracer_sharing(const sss_medium *m, float footprint, int hinted) {
    sss_need need;
    need.footprint = footprint;
    need.curvature_radius = 0.99f * m->r_max;
    need.shading_cost = TRACER_SHADING_COST;
    need.tolerance = 0.2f;
    need.hinted = hinted;
    return sss_plan_for(m, &need);
}

static inline sss_plan tracer_plan(const SCENE_SPACE scene *s, tracer_settings settings,
                                   sss_vec3 position, sss_vec3 normal) {
    sss_medium medium = s->medium;
    if (settings.method == TRACER_PLAIN) return tracer_plain_plan();
    if (!(settings.tolerance > 0.0f)) return settings.plan;
    return tracer_choose(&medium, settings, tracer_footprint(s, settings, position),
                         tracer_radius(s, position, normal));
}

// The library at work: one lookup from an entry on a shape. Returns the number of its exits, which
// lie on the given shapes; the probes are added to *probes.
static inline int tracer_lookup(const SCENE_SPACE scene *s, tracer_settings settings, sss_plan plan,
                                sss_vec3 position, sss_vec3 normal, int shape, uint32_t seed,
                                uint32_t sample, sss_exit *exits, int *shapes, uint32_t *probes) {
    sss_medium medium = s->medium;
    sss_resampler resampler;
    sss_probe probe;
    scene_hits hits;
    unsigned char found[SCENE_MAX_FOUND]; // the shape of each hit, in the order of the calls
    int calls = 0, aware = settings.method == TRACER_RESAMPLED && settings.light_aware;
    sss_begin_sample(&resampler, &medium, &plan, position, normal, seed, sample);

    while (sss_next_probe(&resampler, &probe)) {
        (*probes)++;
        if (plan.techniques == SSS_WALK) {
            scene_way_out(s, probe.origin, probe.direction, probe.length, &hits);
        } else {
            scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        }

        for (int i = 0; i < hits.count; i++) {
            sss_vec3 at = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 facing = scene_normal(&s->shape[hits.hit[i].shape], at);
            found[calls] = (unsigned char)hits.hit[i].shape;
            if (calls < SCENE_MAX_FOUND - 1) calls++;
            sss_add_hit(&resampler, at, facing, aware ? tracer_light_guess(s, at, facing) : 1.0f);
        }
    }

    int count = sss_finish(&resampler, exits);
    for (int i = 0; i < count; i++) {
        int hit = exits[i].hit < calls ? exits[i].hit : calls;
        shapes[i] = hit < 0 ? shape : (int)found[hit];
    }
    return count;
}

// The same for those who only want the exits.
static inline int tracer_exits(const SCENE_SPACE scene *s, tracer_settings settings,
                               sss_vec3 position, sss_vec3 normal, uint32_t seed, sss_exit *exits,
                               uint32_t *probes) {
    int shapes[SSS_MAX_EXITS];
    sss_plan plan = tracer_plan(s, settings, position, normal);
    return tracer_lookup(s, settings, plan, position, normal, SCENE_NOTHING, seed, 0u, exits,
                         shapes, probes);
}

static inline void tracer_exit_points(const sss_exit *exits, const int *shapes, int count,
                                      tracer_points *points) {
    points->count = count;

    for (int i = 0; i < count; i++) {
        points->point[i].position = exits[i].position;
        points->point[i].normal = exits[i].normal;
        points->point[i].weight =
            scene_vec(exits[i].weight[0], exits[i].weight[1], exits[i].weight[2]);
        points->point[i].shape = shapes[i];
    }
}

// ---- The reference: the surface integral of Rd(|y - x|) E(y) by area sampling. It shares no code
// with the library but the profile itself. A convex shape is the image of the unit sphere:
// direction w goes to the boundary point y = center + tau(w) S w, S the extents along the axes. The
// cone over dw has the volume det(S) tau^3 dw / 3 = (y . n) dA / 3, hence dA/dw = det(S) tau^3 / (y
// . n), for every convex shape, edges and all.

static inline sss_vec3 tracer_profile(const sss_medium *m, float r) {
    return scene_vec(sss_profile(m, 0, r), sss_profile(m, 1, r), sss_profile(m, 2, r));
}

// The direction w of the unit sphere on whose ray from the shape's centre a point lies.
static inline sss_vec3 tracer_parameter(const SCENE_SPACE scene_shape *s, sss_vec3 position) {
    sss_vec3 w = scene_mul(scene_to_local(s, scene_sub(position, s->center)), s->inverse_extent);
    float squared = scene_dot(w, w);
    return squared > 0.0f ? scene_scale(w, 1.0f / scene_sqrt(squared))
                          : scene_vec(0.0f, 0.0f, 1.0f);
}

// How much a shape is likely to give: its area times the mean profile at about its distance.
static inline float tracer_shape_share(const SCENE_SPACE scene_shape *s, const sss_medium *m,
                                       sss_vec3 position) {
    sss_vec3 w = tracer_parameter(s, position);
    sss_vec3 nearest = scene_add(s->center, scene_to_world(s, scene_mul(w, s->extent)));
    sss_vec3 gap = scene_sub(position, nearest);
    float distance = scene_level(s, position) > 0.0f ? scene_sqrt(scene_dot(gap, gap)) : 0.0f;
    float size = scene_sqrt(s->area) * 0.2f;
    return s->area * scene_mean(tracer_profile(m, distance + size)) + 1e-3f * s->area;
}

// One point of a shape: half uniform on the parameter sphere, half with density 1/(4 pi rho) at
// chord rho from `about`, which cancels the 1/r of the profile; the balance heuristic joins the
// two.
static inline tracer_point tracer_area_point(const SCENE_SPACE scene *s, int shape,
                                             sss_vec3 position, const sss_medium *m, float share,
                                             tracer_random *random) {
    const SCENE_SPACE scene_shape *body = &s->shape[shape];
    sss_vec3 about = tracer_parameter(body, position);
    float pick = tracer_next(random), first = tracer_next(random), turn = tracer_next(random);
    // Either rho^2 is uniform, which is uniform on the sphere, or rho is.
    float rho = 2.0f * (pick < 0.5f ? scene_sqrt(first) : first);
    float sine = rho * scene_sqrt(scene_max(1.0f - 0.25f * rho * rho, 0.0f));
    sss_vec3 w = tracer_about(about, 1.0f - 0.5f * rho * rho, sine, turn);
    float density = (1.0f + 1.0f / scene_max(rho, 1e-6f)) * (0.125f / SCENE_PI);

    sss_vec3 ray = scene_mul(w, body->extent);
    float tau = 1.0f;
    if (body->kind == SCENE_ROUNDED_BOX)
        tau = scene_box_interval(body, scene_vec(0.0f, 0.0f, 0.0f), ray).t1;
    sss_vec3 arm = scene_scale(scene_to_world(body, ray), tau);
    tracer_point point;
    point.shape = shape;
    point.position = scene_add(body->center, arm);
    point.normal = scene_normal(body, point.position);
    point.weight = scene_vec(0.0f, 0.0f, 0.0f);
    float volume = body->extent.x * body->extent.y * body->extent.z;
    float per_direction = volume * tau * tau * tau / scene_dot(arm, point.normal);
    sss_vec3 way = scene_sub(point.position, position);
    if (!scene_inside_another(s, point.position, shape)) {
        point.weight = scene_scale(tracer_profile(m, scene_sqrt(scene_dot(way, way))),
                                   per_direction / (density * share));
    }
    return point;
}

// TRACER_AREA_POINTS points over the whole object, shapes drawn by systematic sampling of their
// shares.
static inline void tracer_area_points(const SCENE_SPACE scene *s, sss_vec3 position,
                                      tracer_random *random, tracer_points *points) {
    sss_medium medium = s->medium;
    float share[SCENE_MAX_SHAPES], total = 0.0f, below = 0.0f;
    for (int i = 0; i < s->shape_count; i++) {
        share[i] = tracer_shape_share(&s->shape[i], &medium, position);
        total += share[i];
    }
    int shape = 0;
    points->count = 0;

    for (int k = 0; k < TRACER_AREA_POINTS; k++) {
        float place = ((float)k + tracer_next(random)) * (total / (float)TRACER_AREA_POINTS);
        while (shape < s->shape_count - 1 && place >= below + share[shape]) below += share[shape++];
        float expected = (float)TRACER_AREA_POINTS * share[shape] / total;
        tracer_point point = tracer_area_point(s, shape, position, &medium, expected, random);
        if (scene_mean(point.weight) > 0.0f) points->point[points->count++] = point;
    }
}

// ---- The path

typedef struct tracer_path {
    tracer_random random;
    sss_vec3 origin, direction, throughput;
    int leaving;      // the shape that the origin lies on
    uint32_t surface; // how many surfaces the path has met
} tracer_path;

// The irradiance at a point but for the one ray that goes on. `first`: this is the path's first
// point, whose numbers are stratified.
static inline sss_vec3 tracer_irradiance(const SCENE_SPACE scene *s, tracer_point point, int first,
                                         tracer_random *random) {
    float u = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT) : tracer_next(random);
    float v = first ? tracer_stratified(random, TRACER_STRATIFY_LIGHT + 1u) : tracer_next(random);
    scene_ambient around = scene_make_ambient(s, point.position);
    return scene_add(tracer_light(s, point, u, v), scene_ambient_irradiance(around, point.normal));
}

// Shade all points; leave in points->point[0] the one that continues, its weight divided by the
// chance of its draw.
static inline sss_vec3 tracer_shade(const SCENE_SPACE scene *s, tracer_points *points,
                                    tracer_path *path) {
    sss_vec3 radiance = scene_vec(0.0f, 0.0f, 0.0f);
    float total = 0.0f, chosen_weight = 1.0f;
    int chosen = 0;

    for (int k = 0; k < points->count; k++) {
        tracer_point point = points->point[k];
        int first = path->surface == 0u && k == 0;
        sss_vec3 irradiance = tracer_irradiance(s, point, first, &path->random);
        radiance = scene_add(radiance, scene_mul(scene_scale(path->throughput, 1.0f / SCENE_PI),
                                                 scene_mul(point.weight, irradiance)));
        float weight = scene_dot(path->throughput, point.weight);
        total += weight;
        if (points->count > 1 && tracer_next(&path->random) * total < weight) chosen = k;
        if (chosen == k) chosen_weight = weight;
    }

    tracer_point next = points->point[chosen];
    next.weight = scene_scale(next.weight, chosen_weight > 0.0f ? total / chosen_weight : 0.0f);
    points->point[0] = next;
    return radiance;
}

// The points that stand for a hit: the floor itself, or the exits of the path that enters the
// object here.
static inline void tracer_surface(const SCENE_SPACE scene *s, tracer_settings settings,
                                  sss_vec3 position, int shape, tracer_path *path,
                                  tracer_points *points, tracer_result *result) {
    if (shape == SCENE_FLOOR) {
        points->count = 1;
        points->point[0].position = scene_vec(position.x, 0.0f, position.z);
        points->point[0].normal = scene_vec(0.0f, 1.0f, 0.0f);
        points->point[0].weight = s->floor_albedo;
        points->point[0].shape = SCENE_FLOOR;
        return;
    }

    sss_vec3 normal = scene_normal(&s->shape[shape], position);
    if (settings.method == TRACER_REFERENCE) {
        tracer_area_points(s, position, &path->random, points);
    } else {
        sss_exit exits[SSS_MAX_EXITS];
        int shapes[SSS_MAX_EXITS];
        sss_plan plan = tracer_plan(s, settings, position, normal);
        uint32_t seed = sss_hash(path->random.pixel_key, 0x40000000u + path->surface);
        int count = tracer_lookup(s, settings, plan, position, normal, shape, seed,
                                  path->random.sample, exits, shapes, &result->probes);
        tracer_exit_points(exits, shapes, count, points);
    }
    result->shaded += (uint32_t)points->count;
}

// The path goes on from a point by one ray. Returns the radiance along it that has been counted
// already.
static inline sss_vec3 tracer_go_on(const SCENE_SPACE scene *s, tracer_point from,
                                    tracer_path *path) {
    tracer_random *random = &path->random;
    int first = path->surface == 0u;
    float u = first ? tracer_stratified(random, TRACER_STRATIFY_DIRECTION) : tracer_next(random);
    float v =
        first ? tracer_stratified(random, TRACER_STRATIFY_DIRECTION + 1u) : tracer_next(random);
    path->direction = tracer_about(from.normal, scene_sqrt(1.0f - u), scene_sqrt(u), v);
    path->origin = from.position;
    path->leaving = from.shape;
    path->surface++;
    return scene_ambient_radiance(scene_make_ambient(s, path->origin), path->direction);
}

// Adds what a path gathers along its ray and behind it.
static inline void tracer_follow(const SCENE_SPACE scene *s, tracer_settings settings,
                                 tracer_path *path, tracer_result *result) {
    tracer_points points;
    while (path->origin.y >= 0.0f) { // below the floor it is dark
        scene_hit hit = scene_nearest(s, path->origin, path->direction, path->leaving);

        if (hit.shape == SCENE_NOTHING) {
            sss_vec3 sky = scene_sky(s, path->direction);
            result->radiance = scene_add(result->radiance, scene_mul(path->throughput, sky));
            return;
        }

        if (path->surface == TRACER_MAX_SURFACES) return;
        sss_vec3 position = scene_along(path->origin, path->direction, hit.t);
        tracer_surface(s, settings, position, hit.shape, path, &points, result);
        if (points.count == 0) return;
        result->radiance = scene_add(result->radiance, tracer_shade(s, &points, path));
        path->throughput = scene_mul(path->throughput, points.point[0].weight);
        if (!(scene_mean(path->throughput) > 0.0f)) return;
        sss_vec3 expected = tracer_go_on(s, points.point[0], path);
        result->radiance = scene_sub(result->radiance, scene_mul(path->throughput, expected));
    }
}

static inline tracer_path tracer_begin(const SCENE_SPACE scene *s, tracer_settings settings, int x,
                                       int y, uint32_t sample) {
    tracer_path path;
    uint32_t pixel = (uint32_t)y * (uint32_t)settings.width + (uint32_t)x;
    // A reference never shares its noise with the picture that is measured against it.
    uint32_t stream = settings.method == TRACER_REFERENCE ? 0x52656675u : 0u;
    path.random = tracer_random_begin(settings.seed ^ stream, pixel, sample);
    float px = (float)x + tracer_stratified(&path.random, TRACER_STRATIFY_PIXEL);
    float py = (float)y + tracer_stratified(&path.random, TRACER_STRATIFY_PIXEL + 1u);
    path.origin = s->eye;
    path.direction = tracer_camera(s, settings.width, settings.height, px, py);
    path.throughput = scene_vec(1.0f, 1.0f, 1.0f);
    path.leaving = SCENE_NOTHING;
    path.surface = 0u;
    return path;
}

static inline tracer_result tracer_no_result(void) {
    tracer_result result;
    result.radiance = scene_vec(0.0f, 0.0f, 0.0f);
    result.probes = result.shaded = 0u;
    return result;
}

static inline tracer_result tracer_sample(const SCENE_SPACE scene *s, tracer_settings settings,
                                          int x, int y, uint32_t sample) {
    tracer_result result = tracer_no_result();
    tracer_path path = tracer_begin(s, settings, x, y, sample);
    tracer_follow(s, settings, &path, &result);
    return result;
}

// ---- Tiles: paths that share their exits
//
// A member of a tile is a path that meets the object first, with a plan that may share. It begins
// alone: it looks up its exits and estimates the irradiance of each, with the one ray that goes on
// and all behind it. Then all exits of the tile serve all members. A path that is no member is
// traced as ever. Who is a member depends on where paths enter and on nothing that a lookup draws,
// which is what sss_share asks for.

// The side of the tiles in use, in pixels; 1: none.
static inline int tracer_tile_side(tracer_settings settings) {
    int side = settings.plan.tile;
    if (settings.method != TRACER_RESAMPLED || side < 1) return 1;
    return side > TRACER_MAX_TILE ? TRACER_MAX_TILE : side;
}

// How far the grid of tiles is shifted to the left (axis 0) or up (1), so that each sample has its
// borders elsewhere.
static inline int tracer_tile_shift(tracer_settings settings, uint32_t sample, uint32_t axis) {
    uint32_t number = sss_hash(sss_hash(settings.seed, 0x74696c65u + axis), sample);
    return (int)(number % (uint32_t)tracer_tile_side(settings));
}

// How many rows (axis 1) or columns (0) of tiles cover the picture.
static inline int tracer_tile_count(tracer_settings settings, uint32_t sample, uint32_t axis) {
    int side = tracer_tile_side(settings), size = axis == 0u ? settings.width : settings.height;
    return (size + tracer_tile_shift(settings, sample, axis) + side - 1) / side;
}

// Where pixel i of a tile is; 0 if that is outside of the picture.
static inline int tracer_tile_pixel(tracer_settings settings, uint32_t sample, int column, int row,
                                    int i, int *x, int *y) {
    int side = tracer_tile_side(settings);
    *x = column * side - tracer_tile_shift(settings, sample, 0u) + i % side;
    *y = row * side - tracer_tile_shift(settings, sample, 1u) + i / side;
    return i < side * side && *x >= 0 && *x < settings.width && *y >= 0 && *y < settings.height;
}

// A condition of sss_share: techniques that reach everything, or a disk that sss_plan_for chose
// because all is flat. The exits of walks serve nobody else.
static inline int tracer_may_share(tracer_settings settings, sss_plan plan) {
    if (plan.techniques == SSS_DISK) return settings.tolerance > 0.0f;
    return plan.techniques == 0u || (plan.techniques & SSS_CHORD) != 0u;
}

static inline void tracer_tile_clear(TRACER_TILE_SPACE tracer_tile *tile, int i) {
    tile->group[i] = -1;
    tile->count[i] = 0;
}

// Pixel i of a tile, up to where it needs the others. Returns what it cost; its radiance, if it is
// no member.
static inline tracer_result tracer_tile_begin(const SCENE_SPACE scene *s, tracer_settings settings,
                                              int x, int y, uint32_t sample, int i,
                                              TRACER_TILE_SPACE tracer_tile *tile) {
    tracer_result result = tracer_no_result();
    tracer_path path = tracer_begin(s, settings, x, y, sample);
    tracer_points points;
    sss_exit exits[SSS_MAX_EXITS];
    int shapes[SSS_MAX_EXITS];
    sss_plan plan = settings.plan;
    scene_hit hit = scene_nearest(s, path.origin, path.direction, SCENE_NOTHING);
    sss_vec3 position = scene_along(path.origin, path.direction, hit.t);
    sss_vec3 normal = path.direction;
    int shares = hit.shape >= 0;

    tracer_tile_clear(tile, i);

    if (shares) {
        normal = scene_normal(&s->shape[hit.shape], position);
        plan = tracer_plan(s, settings, position, normal);
        shares = tracer_may_share(settings, plan);
    }

    if (!shares) {
        tracer_follow(s, settings, &path, &result);
        return result;
    }

    uint32_t seed = sss_hash(path.random.pixel_key, 0x40000000u);
    int count = tracer_lookup(s, settings, plan, position, normal, hit.shape, seed,
                              path.random.sample, exits, shapes, &result.probes);
    result.shaded = (uint32_t)count;
    tile->group[i] = 0;
    tile->count[i] = count;
    tile->entry[i] = position;
    tile->footprint[i] = tracer_footprint(s, settings, position);
    if (count == 0) return result;

    // One of the exits goes on. What its ray brings, over the chance of its choice, belongs to it.
    float total = 0.0f, chosen_weight = 1.0f;
    int chosen = 0;
    tracer_exit_points(exits, shapes, count, &points);

    for (int k = 0; k < count; k++) {
        tile->exit[i][k] = exits[k];
        tile->light[i][k] = tracer_irradiance(s, points.point[k], k == 0, &path.random);
        float weight = scene_mean(points.point[k].weight);
        total += weight;
        if (count > 1 && tracer_next(&path.random) * total < weight) chosen = k;
        if (chosen == k) chosen_weight = weight;
    }

    if (!(chosen_weight > 0.0f)) return result;
    sss_vec3 expected = tracer_go_on(s, points.point[chosen], &path);
    tracer_follow(s, settings, &path, &result);
    sss_vec3 more =
        scene_scale(scene_sub(result.radiance, expected), SCENE_PI * total / chosen_weight);
    tile->light[i][chosen] = scene_add(tile->light[i][chosen], more);
    result.radiance = scene_vec(0.0f, 0.0f, 0.0f);
    return result;
}

// The distance of a group's neighbours: a pixel's width at its first member.
static inline float tracer_tile_spacing(const TRACER_TILE_SPACE tracer_tile *tile, int group) {
    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        if (tile->group[i] == group) return tile->footprint[i];
    }
    return 0.0f;
}

// The host's second half: adds what all exits of a group bring to each of its members.
static inline void tracer_tile_share(const sss_medium *m, const TRACER_TILE_SPACE tracer_tile *tile,
                                     int group, sss_vec3 *radiance) {
    sss_entry entry[TRACER_TILE_PIXELS];
    float weight[TRACER_TILE_PIXELS][3], spacing = tracer_tile_spacing(tile, group);
    int pixel[TRACER_TILE_PIXELS], members = 0;

    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        if (tile->group[i] != group) continue;
        entry[members].position = tile->entry[i];
        entry[members].medium = m;
        pixel[members++] = i;
    }

    for (int own = 0; own < members; own++) {
        for (int k = 0; k < tile->count[pixel[own]]; k++) {
            sss_vec3 light = tile->light[pixel[own]][k];
            sss_exit exit = tile->exit[pixel[own]][k];
            sss_share(&exit, entry, members, own, spacing, weight);

            for (int i = 0; i < members; i++) {
                sss_vec3 w = scene_vec(weight[i][0], weight[i][1], weight[i][2]);
                sss_vec3 brought = scene_scale(scene_mul(w, light), 1.0f / SCENE_PI);
                radiance[pixel[i]] = scene_add(radiance[pixel[i]], brought);
            }
        }
    }
}

// One sample of each pixel of a tile: their radiances, and what they cost together.
static inline tracer_result tracer_tile_sample(const SCENE_SPACE scene *s, tracer_settings settings,
                                               int column, int row, uint32_t sample,
                                               TRACER_TILE_SPACE tracer_tile *tile,
                                               sss_vec3 *radiance) {
    sss_medium medium = s->medium;
    tracer_result all = tracer_no_result();
    int x, y;

    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        tracer_tile_clear(tile, i);
        radiance[i] = scene_vec(0.0f, 0.0f, 0.0f);
        if (!tracer_tile_pixel(settings, sample, column, row, i, &x, &y)) continue;
        tracer_result one = tracer_tile_begin(s, settings, x, y, sample, i, tile);
        radiance[i] = one.radiance;
        all.probes += one.probes;
        all.shaded += one.shaded;
    }

    tracer_tile_share(&medium, tile, 0, radiance);
    return all;
}

// The same for a kernel, where each work-item has its own pixels. First the density of pixel own's
// exits, summed over the entries of the group ...
static inline void tracer_tile_densities(const SCENE_SPACE scene *s, int own,
                                         TRACER_TILE_SPACE tracer_tile *tile) {
    sss_medium medium = s->medium;

    for (int k = 0; k < tile->count[own]; k++) {
        sss_exit exit = tile->exit[own][k];
        float sum = 0.0f;
        for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
            if (tile->group[i] != tile->group[own]) continue;
            sum += sss_share_density(&medium, tile->entry[i], &exit);
        }
        tile->density[own][k] = sum;
    }
}

// ... then what all exits of the group bring to pixel i.
static inline sss_vec3 tracer_tile_gather(const SCENE_SPACE scene *s, int i,
                                          const TRACER_TILE_SPACE tracer_tile *tile) {
    sss_medium medium = s->medium;
    sss_vec3 radiance = scene_vec(0.0f, 0.0f, 0.0f);
    float spacing = tracer_tile_spacing(tile, tile->group[i]), weight[3];

    for (int own = 0; own < TRACER_TILE_PIXELS; own++) {
        if (tile->group[own] != tile->group[i]) continue;
        for (int k = 0; k < tile->count[own]; k++) {
            sss_exit exit = tile->exit[own][k];
            int has_mass = exit.mass > 0.0f;
            if (has_mass)
                sss_share_weight(&medium, tile->entry[i], &exit, tile->density[own][k], weight);
            for (int c = 0; c < 3; c++) {
                if (has_mass && sss_is_shared(&medium, c, spacing)) continue;
                weight[c] = own == i ? exit.weight[c] : 0.0f;
            }
            sss_vec3 w = scene_vec(weight[0], weight[1], weight[2]);
            sss_vec3 brought = scene_scale(scene_mul(w, tile->light[own][k]), 1.0f / SCENE_PI);
            radiance = scene_add(radiance, brought);
        }
    }
    return radiance;
}

// Does the pixel's centre ray meet the translucent object? Errors are measured over these pixels.
static inline int tracer_sees_object(const SCENE_SPACE scene *s, int width, int height, int x,
                                     int y) {
    sss_vec3 direction = tracer_camera(s, width, height, (float)x + 0.5f, (float)y + 0.5f);
    return scene_nearest(s, s->eye, direction, SCENE_NOTHING).shape >= 0;
}

#endif
