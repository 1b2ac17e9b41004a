// scenes.h - the scenes of the demos, as data for scene.h. Host only.
// SPDX-License-Identifier: MIT
#ifndef SCENES_H
#define SCENES_H

#include <math.h>
#include <string.h>

#include "scene.h"

// What a medium is made from: diffuse albedo and diffuse mean free path (scene units), per colour
// channel. At a high albedo most light leaves much nearer than one dmfp: Burley's length is dmfp
// / 3.5 at albedo 0.33, dmfp / 14 at 0.9.
typedef struct scenes_optics {
    float albedo[3], dmfp[3];
} scenes_optics;

static inline sss_vec3 scenes_turn(sss_vec3 v, float degrees, int axis) {
    float a = degrees * (SCENE_PI / 180.0f), c = cosf(a), s = sinf(a);
    if (axis == 0) return scene_vec(v.x, c * v.y - s * v.z, s * v.y + c * v.z);
    if (axis == 1) return scene_vec(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
    return scene_vec(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

// Append a shape. `turn` is in degrees about x, then y, then z. Rounding 0 makes an ellipsoid.
static inline void scenes_shape(scene *s, sss_vec3 center, sss_vec3 extent, float rounding,
                                sss_vec3 turn) {
    if (s->shape_count >= SCENE_MAX_SHAPES) return;
    scene_shape *shape = &s->shape[s->shape_count++];
    shape->kind = rounding > 0.0f ? SCENE_ROUNDED_BOX : SCENE_ELLIPSOID;
    shape->rounding = rounding;
    shape->center = center;
    shape->extent = extent;
    shape->inverse_extent = scene_vec(1.0f / extent.x, 1.0f / extent.y, 1.0f / extent.z);
    for (int i = 0; i < 3; i++) {
        sss_vec3 axis = scene_vec(i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f);
        axis = scenes_turn(scenes_turn(axis, turn.x, 0), turn.y, 1);
        shape->axis[i] = scene_normalize(scenes_turn(axis, turn.z, 2));
    }
    float pairs = extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
    shape->area = (rounding > 0.0f ? 8.0f : SCENE_PI * 4.0f / 3.0f) * pairs;
}

static inline void scenes_ellipsoid(scene *s, sss_vec3 center, sss_vec3 extent, sss_vec3 turn) {
    scenes_shape(s, center, extent, 0.0f, turn);
}

// A limb and its mirror image in x = 0.
static inline void scenes_pair(scene *s, sss_vec3 center, sss_vec3 extent, sss_vec3 turn) {
    scenes_ellipsoid(s, center, extent, turn);
    center.x = -center.x;
    scenes_ellipsoid(s, center, extent, scene_vec(turn.x, -turn.y, -turn.z));
}

// A light at `center` that faces `target`.
static inline void scenes_light(scene *s, sss_vec3 center, sss_vec3 target, float half_size,
                                sss_vec3 radiance) {
    scene_light *light = &s->light;
    light->center = center;
    light->normal = scene_normalize(scene_sub(target, center));
    sss_vec3 side = scene_normalize(scene_cross(light->normal, scene_vec(0.0f, 1.0f, 0.0f)));
    light->u = scene_scale(side, half_size);
    light->v = scene_scale(scene_cross(side, light->normal), half_size);
    light->radiance = radiance;
    light->area = 4.0f * half_size * half_size;
    light->radius = half_size * 2.0f / sqrtf(SCENE_PI);
}

// `view` is the whole angle of the central square, in degrees.
static inline void scenes_camera(scene *s, sss_vec3 eye, sss_vec3 target, float view) {
    float reach = tanf(view * (SCENE_PI / 360.0f));
    s->eye = eye;
    s->forward = scene_normalize(scene_sub(target, eye));
    sss_vec3 right = scene_normalize(scene_cross(s->forward, scene_vec(0.0f, 1.0f, 0.0f)));
    s->right = scene_scale(right, reach);
    s->up = scene_scale(scene_cross(right, s->forward), reach);
}

static inline scenes_optics scenes_make_optics(sss_vec3 albedo, sss_vec3 dmfp) {
    scenes_optics o = {{albedo.x, albedo.y, albedo.z}, {dmfp.x, dmfp.y, dmfp.z}};
    return o;
}

static inline scenes_optics scenes_sphere(scene *s) {
    scenes_ellipsoid(s, scene_vec(0.0f, 1.0f, 0.0f), scene_vec(1.0f, 1.0f, 1.0f),
                     scene_vec(0.0f, 0.0f, 0.0f));
    scenes_camera(s, scene_vec(0.0f, 3.0f, 6.4f), scene_vec(0.0f, 0.95f, 0.0f), 25.0f);
    scenes_light(s, scene_vec(-2.4f, 3.2f, -2.2f), scene_vec(0.0f, 1.0f, 0.0f), 0.6f,
                 scene_vec(34.0f, 31.0f, 27.0f));
    return scenes_make_optics(scene_vec(0.50f, 0.84f, 0.62f), scene_vec(0.36f, 1.33f, 0.46f));
}

// An upright pane with the light behind it: all that one sees of it has come through.
static inline scenes_optics scenes_slab(scene *s) {
    scenes_shape(s, scene_vec(0.0f, 1.0f, 0.0f), scene_vec(1.0f, 0.99f, 0.075f), 0.06f,
                 scene_vec(-8.0f, 24.0f, 0.0f));
    scenes_camera(s, scene_vec(0.0f, 3.0f, 6.4f), scene_vec(0.0f, 0.90f, 0.0f), 25.0f);
    scenes_light(s, scene_vec(-1.2f, 2.6f, -2.6f), scene_vec(0.0f, 0.9f, 0.0f), 0.4f,
                 scene_vec(40.0f, 37.0f, 33.0f));
    return scenes_make_optics(scene_vec(0.46f, 0.80f, 0.84f), scene_vec(0.21f, 0.63f, 0.82f));
}

// Two blocks that meet in an inside edge.
static inline scenes_optics scenes_corner(scene *s) {
    sss_vec3 turn = scene_vec(0.0f, 32.0f, 0.0f);
    scenes_shape(s, scene_vec(0.0f, 0.3f, 0.0f), scene_vec(1.1f, 0.3f, 1.0f), 0.06f, turn);
    scenes_shape(s, scene_vec(-0.4f, 0.9f, -0.62f), scene_vec(1.07f, 0.88f, 0.26f), 0.06f, turn);
    scenes_camera(s, scene_vec(0.0f, 3.2f, 6.2f), scene_vec(0.0f, 0.72f, 0.0f), 27.0f);
    scenes_light(s, scene_vec(3.4f, 3.4f, -0.8f), scene_vec(0.0f, 0.6f, 0.0f), 0.6f,
                 scene_vec(30.0f, 27.0f, 23.0f));
    return scenes_make_optics(scene_vec(0.88f, 0.62f, 0.44f), scene_vec(1.27f, 0.34f, 0.25f));
}

// A tuft of spines, each thinner than the mean free path.
static inline scenes_optics scenes_needles(scene *s) {
    for (int i = 0; i < 14; i++) {
        float k = (float)i, tilt = 8.0f + 3.2f * k, around = 137.508f * k,
              length = 0.86f - 0.012f * k;
        sss_vec3 turn = scene_vec(tilt, around, 0.0f), along = scene_vec(0.0f, 1.0f, 0.0f);
        along = scenes_turn(scenes_turn(along, tilt, 0), around, 1);
        sss_vec3 center = scene_add(scene_vec(0.0f, 0.06f, 0.0f), scene_scale(along, length));
        scenes_ellipsoid(s, center, scene_vec(0.055f, length, 0.055f), turn);
    }
    scenes_camera(s, scene_vec(0.0f, 3.0f, 6.4f), scene_vec(0.0f, 0.80f, 0.0f), 23.0f);
    scenes_light(s, scene_vec(-2.2f, 3.4f, -2.4f), scene_vec(0.0f, 0.8f, 0.0f), 0.6f,
                 scene_vec(34.0f, 31.0f, 27.0f));
    return scenes_make_optics(scene_vec(0.36f, 0.76f, 0.18f), scene_vec(0.28f, 0.69f, 0.25f));
}

// A gummy bear as the mould makes it, flat at the back and lit from there: the light comes through,
// most of it where the bear is thin.
static inline scenes_optics scenes_bear(scene *s) {
    sss_vec3 upright = scene_vec(0.0f, 0.0f, 0.0f);
    scenes_ellipsoid(s, scene_vec(0.0f, 0.74f, 0.0f), scene_vec(0.50f, 0.62f, 0.27f),
                     upright); // belly
    scenes_ellipsoid(s, scene_vec(0.0f, 1.54f, 0.0f), scene_vec(0.45f, 0.40f, 0.26f),
                     upright); // head
    scenes_ellipsoid(s, scene_vec(0.0f, 1.44f, 0.21f), scene_vec(0.20f, 0.15f, 0.18f),
                     upright); // muzzle
    scenes_ellipsoid(s, scene_vec(0.0f, 1.51f, 0.37f), scene_vec(0.075f, 0.055f, 0.05f),
                     upright); // nose
    scenes_pair(s, scene_vec(0.175f, 1.65f, 0.235f), scene_vec(0.055f, 0.065f, 0.055f),
                upright); // eyes
    scenes_pair(s, scene_vec(0.35f, 1.87f, -0.02f), scene_vec(0.19f, 0.19f, 0.09f),
                scene_vec(0.0f, 0.0f, -14.0f));
    scenes_pair(s, scene_vec(0.47f, 1.00f, 0.07f), scene_vec(0.29f, 0.14f, 0.15f),
                scene_vec(0.0f, 0.0f, 28.0f));
    scenes_pair(s, scene_vec(0.31f, 0.23f, 0.10f), scene_vec(0.23f, 0.23f, 0.24f),
                scene_vec(0.0f, 0.0f, 0.0f));
    scenes_camera(s, scene_vec(1.2f, 2.9f, 6.3f), scene_vec(0.0f, 0.98f, 0.1f), 21.0f);
    scenes_light(s, scene_vec(-1.3f, 2.8f, -3.6f), scene_vec(0.0f, 1.0f, 0.0f), 0.6f,
                 scene_vec(48.0f, 43.0f, 36.0f));
    return scenes_make_optics(scene_vec(0.93f, 0.19f, 0.05f), scene_vec(1.22f, 0.25f, 0.28f));
}

// A rabbit with the sun low behind it: light comes through the ears, and the edges glow.
static inline scenes_optics scenes_rabbit(scene *s) {
    sss_vec3 upright = scene_vec(0.0f, 0.0f, 0.0f);
    scenes_ellipsoid(s, scene_vec(0.0f, 0.58f, -0.22f), scene_vec(0.50f, 0.60f, 0.52f),
                     upright); // body
    scenes_ellipsoid(s, scene_vec(0.0f, 0.78f, 0.12f), scene_vec(0.30f, 0.42f, 0.28f),
                     upright); // chest
    scenes_ellipsoid(s, scene_vec(0.0f, 1.28f, 0.20f), scene_vec(0.33f, 0.29f, 0.36f),
                     upright); // head
    scenes_pair(s, scene_vec(0.105f, 1.17f, 0.47f), scene_vec(0.14f, 0.11f, 0.13f),
                upright); // cheeks
    scenes_ellipsoid(s, scene_vec(0.0f, 1.25f, 0.57f), scene_vec(0.055f, 0.04f, 0.05f),
                     upright); // nose
    scenes_pair(s, scene_vec(0.22f, 1.37f, 0.40f), scene_vec(0.06f, 0.075f, 0.06f),
                upright); // eyes
    scenes_pair(s, scene_vec(0.36f, 0.33f, 0.02f), scene_vec(0.23f, 0.33f, 0.40f),
                upright); // thighs
    scenes_pair(s, scene_vec(0.30f, 0.09f, 0.42f), scene_vec(0.13f, 0.09f, 0.28f), upright); // feet
    scenes_pair(s, scene_vec(0.14f, 0.36f, 0.38f), scene_vec(0.10f, 0.36f, 0.11f), upright); // paws
    scenes_ellipsoid(s, scene_vec(0.21f, 1.86f, 0.08f), scene_vec(0.18f, 0.46f, 0.06f),
                     scene_vec(-6.0f, -10.0f, -14.0f)); // ears, one of them cocked
    scenes_ellipsoid(s, scene_vec(-0.30f, 1.80f, 0.08f), scene_vec(0.18f, 0.46f, 0.06f),
                     scene_vec(-8.0f, 16.0f, 30.0f));
    scenes_camera(s, scene_vec(-0.5f, 1.7f, 6.5f), scene_vec(-0.04f, 1.40f, 0.1f), 15.0f);
    scenes_light(s, scene_vec(-2.9f, 2.7f, -2.5f), scene_vec(0.0f, 1.4f, 0.0f), 0.5f,
                 scene_vec(125.0f, 108.0f, 86.0f));
    s->sky_horizon = scene_vec(0.06f, 0.08f, 0.11f);
    s->sky_zenith = scene_vec(0.36f, 0.42f, 0.50f);
    s->floor_albedo = scene_vec(0.23f, 0.25f, 0.28f);
    return scenes_make_optics(scene_vec(0.87f, 0.60f, 0.42f), scene_vec(1.20f, 0.115f, 0.05f));
}

// ---- All of them

#define SCENES_NAMES "sphere slab corner needles bear rabbit"

enum {
    SCENES_SPHERE,
    SCENES_SLAB,
    SCENES_CORNER,
    SCENES_NEEDLES,
    SCENES_BEAR,
    SCENES_RABBIT,
    SCENES
};

static const struct {
    const char *name;
    scenes_optics (*make)(scene *s);
} scenes_known[SCENES] = {{"sphere", scenes_sphere}, {"slab", scenes_slab},
                          {"corner", scenes_corner}, {"needles", scenes_needles},
                          {"bear", scenes_bear},     {"rabbit", scenes_rabbit}};

// Fill a scene, all but its medium; returns what that may be made of.
static inline scenes_optics scenes_make(scene *s, int which) {
    memset(s, 0, sizeof *s);
    s->floor_lit = 0.6f;
    s->sky_horizon = scene_vec(0.88f, 0.95f, 1.04f);
    s->sky_zenith = scene_vec(0.55f, 0.66f, 0.84f);
    s->floor_albedo = scene_vec(0.27f, 0.24f, 0.215f);
    return scenes_known[which].make(s);
}

#endif
