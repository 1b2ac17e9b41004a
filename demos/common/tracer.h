// tracer.h - a path tracer whose translucent object is shaded with sss_resample.h; C99, C++11 and OpenCL
// C 1.2. SPDX-License-Identifier: MIT
//
// One call, tracer_sample(), traces one path and returns its radiance. A sample is named by (pixel, sample,
// seed) alone, so the picture does not depend on threads, tiles or devices.
//
// At each surface the path has a set of *points*: the floor point itself, the exits of a lookup or, in the
// brute force reference, points all over the object. Every point gets next-event estimation to the area light
// as a white Lambert surface, times its weight. One point is drawn in proportion to its weight and continues
// the path with one cosine-distributed ray; that ray also collects the sky when nothing stops it, so no light
// is counted twice (rays pass through the area light). A control variate takes most of the noise out of that
// one ray: the surroundings without the object, known in closed form, are added at every point, and their
// radiance along the ray is taken off again. Paths end after TRACER_MAX_SURFACES surfaces; there is no
// Russian roulette. Fresnel reflection is left out: it is the caller's matter in the library, and one effect
// less between picture and claim.
#ifndef TRACER_H
#define TRACER_H

#include "scene.h"

#define TRACER_MAX_SURFACES 4
// Area points in each lookup of the reference: its relative variance per sample is then 0.3 (bear) to 2.8
// (needles).
#define TRACER_AREA_POINTS 16
#define TRACER_MAX_POINTS  (TRACER_AREA_POINTS > SSS_MAX_EXITS ? TRACER_AREA_POINTS : SSS_MAX_EXITS)

enum { TRACER_PLAIN = 0, TRACER_RESAMPLED = 1, TRACER_REFERENCE = 2 };

typedef struct tracer_settings {
    int method;
    int light_aware; // resampled: tell the library a guess of the light at each candidate
    sss_plan plan;   // resampled: as given; plain: see tracer_plain_plan
    int width, height;
    uint32_t seed;
} tracer_settings;

typedef struct tracer_result {
    sss_vec3 radiance;
    uint32_t probes, shaded; // probe segments traced; exits or area points that got next-event estimation
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

// Random numbers of one sample: a few stratified over the samples of a pixel, the others plain hashes.
typedef struct tracer_random {
    uint32_t pixel_key, sample, sample_key, dimension;
} tracer_random;

enum { TRACER_STRATIFY_PIXEL = 0, TRACER_STRATIFY_LIGHT = 2, TRACER_STRATIFY_DIRECTION = 4 };

// King et al. 2013: one probe a lookup, along the normal or one of two tangents, and nothing to choose from.
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

static inline float tracer_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); } // [0, 1)

static inline float tracer_next(tracer_random *r) {
    return tracer_unit(sss_hash(r->sample_key, r->dimension++));
}

// Coordinate `d` (0..5) of a rank-1 sequence: sample k sits at offset + k g^-(d+1) mod 1, g^7 = g + 1 (the
// golden ratio's cousin in six dimensions), with the offset hashed from the pixel. Even for every number of
// samples, in any order.
static inline float tracer_stratified(const tracer_random *r, uint32_t d) {
    uint32_t step = d == 0u   ? 3859688307u
                    : d == 1u ? 3468523227u
                    : d == 2u ? 3117001275u
                    : d == 3u ? 2801104767u
                    : d == 4u ? 2517223199u
                              : 2262111973u;
    return tracer_unit(sss_hash(r->pixel_key, 0x80000000u + d) + r->sample * step);
}

// A unit vector that is nowhere near parallel to n, crossed with n.
static inline sss_vec3 tracer_tangent(sss_vec3 n) {
    sss_vec3 other = scene_abs(n.x) < 0.6f ? scene_vec(1.0f, 0.0f, 0.0f) : scene_vec(0.0f, 1.0f, 0.0f);
    return scene_normalize(scene_cross(other, n));
}

// The direction at cosine z and sine r from n, turned about it by u of a full turn.
static inline sss_vec3 tracer_about(sss_vec3 n, float z, float r, float u) {
    sss_vec3 t = tracer_tangent(n), b = scene_cross(n, t);
    float sine, cosine;
    sssi_sincos_turn(u, &sine, &cosine);
    return scene_add(scene_scale(n, z), scene_add(scene_scale(t, r * cosine), scene_scale(b, r * sine)));
}

// The camera ray's direction through a point of the image, in pixels; (0, 0) is the top left corner. The
// central square of the picture sees the same whatever the shape of the image.
static inline sss_vec3 tracer_camera(const SCENE_SPACE scene *s, int width, int height, float x, float y) {
    float side = 1.0f / (float)(width < height ? width : height);
    sss_vec3 d = scene_along(s->forward, s->right, (2.0f * x - (float)width) * side);
    return scene_normalize(scene_along(d, s->up, ((float)height - 2.0f * y) * side));
}

// Irradiance from the area light, estimated by one point of it.
static inline sss_vec3 tracer_light(const SCENE_SPACE scene *s, tracer_point point, float u, float v) {
    sss_vec3 none = scene_vec(0.0f, 0.0f, 0.0f);
    sss_vec3 at =
        scene_along(scene_along(s->light.center, s->light.u, 2.0f * u - 1.0f), s->light.v, 2.0f * v - 1.0f);
    sss_vec3 path = scene_sub(at, point.position);
    float squared = scene_dot(path, path), distance = scene_sqrt(squared);
    if (!(distance > 0.0f)) return none;
    sss_vec3 direction = scene_scale(path, 1.0f / distance);
    float here = scene_dot(direction, point.normal), there = -scene_dot(direction, s->light.normal);
    if (here <= 0.0f || there <= 0.0f || point.position.y < 0.0f) return none; // below the floor it is dark
    if (scene_occluded(s, point.position, direction, distance, point.shape)) return none;
    return scene_scale(s->light.radiance, here * there * s->light.area / squared);
}

// A guess of the irradiance at a candidate, without a single ray: the light as a disk seen from here, faded
// where it sinks below the horizon of the surface, and the surroundings without the object.
static inline float tracer_light_guess(const SCENE_SPACE scene *s, sss_vec3 position, sss_vec3 normal) {
    sss_vec3 path = scene_sub(s->light.center, position);
    float squared = scene_dot(path, path), inverse = 1.0f / scene_sqrt(squared);
    float here = scene_dot(path, normal) * inverse, there = -scene_dot(path, s->light.normal) * inverse;
    float wide = s->light.radius * inverse; // sine of the light's radius
    if (here < wide) here = here <= -wide ? 0.0f : (here + wide) * (here + wide) / (4.0f * wide);
    float direct = scene_mean(s->light.radiance) * here * scene_max(there, 0.0f) * s->light.area / squared;
    return direct + scene_mean(scene_ambient_irradiance(scene_make_ambient(s, position), normal));
}

// The library at work: one lookup gives its exits and returns their number; the probes are added to *probes.
static inline int tracer_exits(const SCENE_SPACE scene *s, tracer_settings settings, sss_vec3 position,
                               sss_vec3 normal, uint32_t seed, sss_exit *exits, uint32_t *probes) {
    sss_medium medium = s->medium;
    sss_plan plan = settings.method == TRACER_PLAIN ? tracer_plain_plan() : settings.plan;
    int aware = settings.method == TRACER_RESAMPLED && settings.light_aware;
    sss_resampler resampler;
    sss_probe probe;
    scene_hits hits;
    sss_begin(&resampler, &medium, &plan, position, normal, seed);
    while (sss_next_probe(&resampler, &probe)) {
        (*probes)++;
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++) {
            sss_vec3 at = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 facing = scene_normal(&s->shape[hits.hit[i].shape], at);
            sss_add_hit(&resampler, at, facing, aware ? tracer_light_guess(s, at, facing) : 1.0f);
        }
    }
    return sss_finish(&resampler, exits);
}

// The same as points to shade. Returns how many probes were traced.
static inline uint32_t tracer_lookup(const SCENE_SPACE scene *s, tracer_settings settings, sss_vec3 position,
                                     sss_vec3 normal, uint32_t seed, tracer_points *points) {
    sss_exit exits[SSS_MAX_EXITS];
    uint32_t probes = 0u;
    points->count = tracer_exits(s, settings, position, normal, seed, exits, &probes);
    for (int i = 0; i < points->count; i++) {
        points->point[i].position = exits[i].position;
        points->point[i].normal = exits[i].normal;
        points->point[i].weight = scene_vec(exits[i].weight[0], exits[i].weight[1], exits[i].weight[2]);
        points->point[i].shape = scene_shape_at(s, exits[i].position);
    }
    return probes;
}

// ---- The reference: the surface integral of Rd(|y - x|) E(y) by area sampling. It shares no code with the
// library but the profile itself. A convex shape is the image of the unit sphere: direction w goes to the
// boundary point y = center + tau(w) S w, S the extents along the axes. The cone over dw has the volume
// det(S) tau^3 dw / 3 = (y . n) dA / 3, hence dA/dw = det(S) tau^3 / (y . n), for every convex shape, edges
// and all.

static inline sss_vec3 tracer_profile(const sss_medium *m, float r) {
    return scene_vec(sss_profile(m, 0, r), sss_profile(m, 1, r), sss_profile(m, 2, r));
}

// The direction w of the unit sphere on whose ray from the shape's centre a point lies.
static inline sss_vec3 tracer_parameter(const SCENE_SPACE scene_shape *s, sss_vec3 position) {
    sss_vec3 w = scene_mul(scene_to_local(s, scene_sub(position, s->center)), s->inverse_extent);
    float squared = scene_dot(w, w);
    return squared > 0.0f ? scene_scale(w, 1.0f / scene_sqrt(squared)) : scene_vec(0.0f, 0.0f, 1.0f);
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

// One point of a shape: half uniform on the parameter sphere, half with density 1/(4 pi rho) at chord rho
// from `about`, which cancels the 1/r of the profile; the balance heuristic joins the two.
static inline tracer_point tracer_area_point(const SCENE_SPACE scene *s, int shape, sss_vec3 position,
                                             const sss_medium *m, float share, tracer_random *random) {
    const SCENE_SPACE scene_shape *body = &s->shape[shape];
    sss_vec3 about = tracer_parameter(body, position);
    float pick = tracer_next(random), first = tracer_next(random), turn = tracer_next(random);
    float rho =
        pick < 0.5f ? 2.0f * scene_sqrt(first) : 2.0f * first; // rho^2 is uniform (on the sphere), or rho is
    float sine = rho * scene_sqrt(scene_max(1.0f - 0.25f * rho * rho, 0.0f));
    sss_vec3 w = tracer_about(about, 1.0f - 0.5f * rho * rho, sine, turn);
    float density = (1.0f + 1.0f / scene_max(rho, 1e-6f)) * (0.125f / SCENE_PI);

    sss_vec3 ray = scene_mul(w, body->extent);
    float tau = 1.0f;
    if (body->kind == SCENE_ROUNDED_BOX) tau = scene_box_interval(body, scene_vec(0.0f, 0.0f, 0.0f), ray).t1;
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

// TRACER_AREA_POINTS points over the whole object, shapes drawn by systematic sampling of their shares.
static inline void tracer_area_points(const SCENE_SPACE scene *s, sss_vec3 position, tracer_random *random,
                                      tracer_points *points) {
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

// Shade all points; leave in points->point[0] the one that continues, its weight divided by the chance of its
// draw.
static inline sss_vec3 tracer_shade(const SCENE_SPACE scene *s, tracer_points *points, sss_vec3 throughput,
                                    int first, tracer_random *random) {
    sss_vec3 radiance = scene_vec(0.0f, 0.0f, 0.0f);
    float total = 0.0f, chosen_weight = 1.0f;
    int chosen = 0;
    for (int k = 0; k < points->count; k++) {
        tracer_point point = points->point[k];
        int stratify = first && k == 0;
        float u = stratify ? tracer_stratified(random, TRACER_STRATIFY_LIGHT) : tracer_next(random);
        float v = stratify ? tracer_stratified(random, TRACER_STRATIFY_LIGHT + 1u) : tracer_next(random);
        sss_vec3 around = scene_ambient_irradiance(scene_make_ambient(s, point.position), point.normal);
        sss_vec3 irradiance = scene_add(tracer_light(s, point, u, v), around);
        radiance = scene_add(radiance, scene_mul(scene_scale(throughput, 1.0f / SCENE_PI),
                                                 scene_mul(point.weight, irradiance)));
        float weight = scene_dot(throughput, point.weight);
        total += weight;
        if (points->count > 1 && tracer_next(random) * total < weight) chosen = k;
        if (chosen == k) chosen_weight = weight;
    }
    tracer_point next = points->point[chosen];
    next.weight = scene_scale(next.weight, chosen_weight > 0.0f ? total / chosen_weight : 0.0f);
    points->point[0] = next;
    return radiance;
}

// The points that stand for a hit: the floor itself, or the exits of the light that leaves the object here.
static inline void tracer_surface(const SCENE_SPACE scene *s, tracer_settings settings, sss_vec3 position,
                                  int shape, uint32_t surface, tracer_random *random, tracer_points *points,
                                  tracer_result *result) {
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
        tracer_area_points(s, position, random, points);
        result->shaded += (uint32_t)points->count;
    } else {
        uint32_t seed = sss_hash(random->sample_key, 0x40000000u + surface);
        result->probes += tracer_lookup(s, settings, position, normal, seed, points);
        result->shaded += (uint32_t)points->count;
    }
}

static inline tracer_result tracer_sample(const SCENE_SPACE scene *s, tracer_settings settings, int x, int y,
                                          uint32_t sample) {
    tracer_result result;
    tracer_points points;
    uint32_t pixel = (uint32_t)y * (uint32_t)settings.width + (uint32_t)x;
    // A reference never shares its noise with the picture that is measured against it.
    uint32_t stream = settings.method == TRACER_REFERENCE ? 0x52656675u : 0u;
    tracer_random random = tracer_random_begin(settings.seed ^ stream, pixel, sample);
    float px = (float)x + tracer_stratified(&random, TRACER_STRATIFY_PIXEL);
    float py = (float)y + tracer_stratified(&random, TRACER_STRATIFY_PIXEL + 1u);
    sss_vec3 origin = s->eye, direction = tracer_camera(s, settings.width, settings.height, px, py);
    sss_vec3 throughput = scene_vec(1.0f, 1.0f, 1.0f);
    int leaving = SCENE_NOTHING;
    result.radiance = scene_vec(0.0f, 0.0f, 0.0f);
    result.probes = result.shaded = 0u;
    for (uint32_t surface = 0u; surface <= TRACER_MAX_SURFACES; surface++) {
        if (origin.y < 0.0f) break; // below the floor it is dark
        scene_hit hit = scene_nearest(s, origin, direction, leaving);
        if (hit.shape == SCENE_NOTHING) {
            result.radiance = scene_add(result.radiance, scene_mul(throughput, scene_sky(s, direction)));
            break;
        }
        if (surface == TRACER_MAX_SURFACES) break;
        tracer_surface(s, settings, scene_along(origin, direction, hit.t), hit.shape, surface, &random,
                       &points, &result);
        if (points.count == 0) break;
        int first = surface == 0u;
        result.radiance = scene_add(result.radiance, tracer_shade(s, &points, throughput, first, &random));
        tracer_point next = points.point[0];
        throughput = scene_mul(throughput, next.weight);
        if (!(scene_mean(throughput) > 0.0f)) break;
        float u = first ? tracer_stratified(&random, TRACER_STRATIFY_DIRECTION) : tracer_next(&random);
        float v = first ? tracer_stratified(&random, TRACER_STRATIFY_DIRECTION + 1u) : tracer_next(&random);
        direction = tracer_about(next.normal, scene_sqrt(1.0f - u), scene_sqrt(u), v);
        origin = next.position;
        leaving = next.shape;
        sss_vec3 expected = scene_ambient_radiance(scene_make_ambient(s, origin), direction);
        result.radiance = scene_sub(result.radiance, scene_mul(throughput, expected));
    }
    return result;
}

// Does the pixel's centre ray meet the translucent object? Errors are measured over these pixels.
static inline int tracer_sees_object(const SCENE_SPACE scene *s, int width, int height, int x, int y) {
    sss_vec3 direction = tracer_camera(s, width, height, (float)x + 0.5f, (float)y + 0.5f);
    return scene_nearest(s, s->eye, direction, SCENE_NOTHING).shape >= 0;
}

#endif
