// random_walk.h - light walks through the volume of the object of scene.h: the truth that profiles
// stand for. Host only. SPDX-License-Identifier: MIT
//
// The object is a homogeneous medium with isotropic scattering and no boundary of its own (matched
// indices). A walk enters in a cosine-distributed direction, ideal diffuse transmission as the
// profiles assume it, and ends where it leaves the object.
//
// All three channels share one path. Channel `hero` draws its distances; over all channels that
// might have drawn them the balance heuristic gives channel c the weight albedo^n p_c / mean p, p_c
// the density of the path's distances if c draws them. That is at most 3, and grey media lose
// nothing.
#ifndef RANDOM_WALK_H
#define RANDOM_WALK_H

#include <math.h>

#include "demos/common/tracer.h"

// A guard against media without absorption; no walk of ours comes near.
#define WALK_MAX_SCATTERINGS 100000

typedef struct walk_medium {
    double extinction[3], albedo[3]; // 1/length, and of a single scattering
} walk_medium;

typedef struct walk_exit {
    sss_vec3 position, normal;
    int shape, scatterings;
    float weight[3]; // times white Lambert's radiance there, as sss_exit
} walk_exit;

// Diffuse albedo of the half space, s = sqrt(1 - albedo of a scattering): a rational fit to
// Chandrasekhar's exact value, good to 1e-6.
static inline double walk_diffuse_albedo(double s) {
    return (1.0 - s) * (1.0 + s * (0.38313089 - 0.00319767 * s)) /
           (1.0 + s * (1.69256344 + 0.6802289 * s));
}

// The volume of a half space with this diffuse albedo, whose light falls off as e^(-r / dmfp):
// Grosjean's diffusion.
static inline walk_medium walk_from_albedo(const float albedo[3], const float dmfp[3]) {
    walk_medium m;
    for (int c = 0; c < 3; c++) {
        double low = 0.0, high = 1.0;
        for (int i = 0; i < 50; i++) {
            double middle = 0.5 * (low + high);
            if (walk_diffuse_albedo(middle) > (double)albedo[c]) low = middle;
            else high = middle;
        }
        m.albedo[c] = 1.0 - low * low;
        m.extinction[c] = 1.0 / (sqrt(3.0 * low * low / (1.0 + low * low)) * (double)dmfp[c]);
    }
    return m;
}

// Goes up to `want` along a ray that starts in `shape`, from shape to shape while they overlap.
// Returns the distance; it is less than `want` where the ray leaves the object, and then *shape is
// the one that it leaves.
static inline float walk_along(const scene *s, sss_vec3 x, sss_vec3 d, float want, int *shape) {
    float reach = scene_max(scene_shape_interval(&s->shape[*shape], x, d).t1, 0.0f);
    for (int i = 0; i < s->shape_count && reach < want; i++) {
        scene_interval other = scene_shape_interval(&s->shape[i], x, d);
        if (!(other.t0 <= reach && other.t1 > reach)) continue;
        reach = other.t1;
        *shape = i;
        i = -1; // the next may start from here
    }
    return scene_min(reach, want);
}

static inline sss_vec3 walk_isotropic(tracer_random *random) {
    float z = 1.0f - 2.0f * tracer_next(random), r = scene_sqrt(scene_max(1.0f - z * z, 0.0f));
    float angle = 6.28318531f * tracer_next(random);

    return scene_vec(r * cosf(angle), r * sinf(angle), z);
}

// 1 and where the walk leaves, or 0 when it is absorbed; exit->scatterings either way.
static inline int walk_lookup(const scene *s, const walk_medium *m, sss_vec3 x, sss_vec3 normal,
                              int shape, tracer_random *random, walk_exit *exit) {
    double path[3] = {1.0, 1.0, 1.0},
           light[3] = {1.0, 1.0, 1.0}; // p_c / p_hero, and albedo^n over chances to live on
    int hero = (int)(3.0f * tracer_next(random));
    float u = tracer_next(random);
    sss_vec3 d = tracer_about(scene_scale(normal, -1.0f), scene_sqrt(1.0f - u), scene_sqrt(u),
                              tracer_next(random));
    for (int n = 0; n < WALK_MAX_SCATTERINGS; n++) {
        float want = (float)(-log(1.0 - (double)tracer_next(random)) / m->extinction[hero]);
        float length = walk_along(s, x, d, want, &shape);
        double weight[3], most = 0.0;
        exit->scatterings = n;
        x = scene_along(x, d, length);
        for (int c = 0; c < 3; c++) {
            path[c] *= exp((m->extinction[hero] - m->extinction[c]) * (double)length);
            if (length < want) continue;
            path[c] *= m->extinction[c] / m->extinction[hero];
            light[c] *= m->albedo[c];
        }
        for (int c = 0; c < 3; c++) {
            weight[c] = 3.0 * light[c] * path[c] / (path[0] + path[1] + path[2]);
            most = weight[c] > most ? weight[c] : most;
        }
        if (length < want) {
            exit->position = x;
            exit->normal = scene_normal(&s->shape[shape], x);
            exit->shape = shape;
            for (int c = 0; c < 3; c++) exit->weight[c] = (float)weight[c];
            return 1;
        }
        if (most < 0.5) { // Russian roulette back to one half
            if ((double)tracer_next(random) >= 2.0 * most) return 0;
            for (int c = 0; c < 3; c++) light[c] *= 0.5 / most;
        }
        d = walk_isotropic(random);
    }
    return 0;
}

#endif
