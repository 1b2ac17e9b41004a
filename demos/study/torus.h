// torus.h - a torus of 50,000 triangles as the studies on a mesh render it.
// SPDX-License-Identifier: MIT
#ifndef TORUS_H
#define TORUS_H

#include "demos/common/mesh_tracer.h"

enum { TORUS_AROUND = 250, TORUS_ACROSS = 100, TORUS_VERTICES = TORUS_AROUND * TORUS_ACROSS };

// A torus with a wave about it.
static void torus_make(mesh_world *world) {
    static float xyz[3 * TORUS_VERTICES];
    static uint32_t corner[6 * TORUS_VERTICES];

    for (uint32_t i = 0; i < TORUS_VERTICES; i++) {
        uint32_t u = i / TORUS_ACROSS, v = i % TORUS_ACROSS;
        uint32_t next = (u + 1) % TORUS_AROUND, up = (v + 1) % TORUS_ACROSS;
        double a = 2.0 * 3.14159265358979 * u / TORUS_AROUND;
        double b = 2.0 * 3.14159265358979 * v / TORUS_ACROSS;
        double r = 0.4 + 0.03 * sin(9.0 * a + 5.0 * b);
        const uint32_t two[6] = {i, next * TORUS_ACROSS + v,  next * TORUS_ACROSS + up,
                                 i, next * TORUS_ACROSS + up, u * TORUS_ACROSS + up};

        xyz[3 * i] = (float)((1.0 + r * cos(b)) * cos(a));
        xyz[3 * i + 1] = (float)(r * sin(b));
        xyz[3 * i + 2] = (float)((1.0 + r * cos(b)) * sin(a));
        memcpy(corner + 6 * i, two, sizeof two);
    }
    const char *wrong = mesh_make(&world->m, xyz, TORUS_VERTICES, corner, 2 * TORUS_VERTICES);
    if (!wrong) wrong = mesh_open(world);
    if (wrong) fail(1, "%s", wrong);
}

// As in mesh.c: the lamp behind the object, the sky in front.
static void torus_scene(mesh_world *world) {
    scene *s = &world->s;
    float r = (float)MESH_RADIUS, turn = -98.0f * (SCENE_PI / 180.0f);
    sss_vec3 middle = scene_vec(0.0f, (float)(0.5 * world->m.size[1] * world->m.unit), 0.0f);
    sss_vec3 lamp = scene_vec(2.6f * r * sinf(turn), middle.y + 2.2f * r, 2.6f * r * cosf(turn));
    sss_vec3 toward_eye = scene_normalize(scene_vec(0.475f, 0.3f, 0.817f));

    s->floor_lit = 0.6f;
    s->sky_horizon = scene_vec(0.36f, 0.40f, 0.46f);
    s->sky_zenith = scene_vec(0.30f, 0.36f, 0.46f);
    s->floor_albedo = scene_vec(0.27f, 0.24f, 0.215f);
    scenes_light(s, lamp, middle, 0.5f * r, scene_vec(64.0f, 58.0f, 49.0f));
    scenes_camera(s, scene_along(middle, toward_eye, 5.2f * r), middle, 22.0f);
}

// Whether a pixel shows nothing but the object.
static int torus_fills(const mesh_world *world, int side, int x, int y) {
    for (int i = 0; i < 25; i++) {
        float px = (float)x + 0.25f * (float)(i % 5), py = (float)y + 0.25f * (float)(i / 5);
        sss_vec3 d = tracer_camera(&world->s, side, side, px, py);

        if (mesh_nearest(world, world->s.eye, d, NULL).geometry != MESH_OBJECT) return 0;
    }
    return 1;
}

// A square picture of the torus, and which of its pixels show nothing but the object. Returns the
// width of a pixel there.
static float torus_begin(mesh_world *world, int side, tracer_settings *settings,
                         unsigned char *mask) {
    torus_make(world);
    torus_scene(world);
    memset(settings, 0, sizeof *settings);
    settings->method = TRACER_RESAMPLED;
    settings->width = settings->height = side;
    for (int i = 0; i < side * side; i++)
        mask[i] = (unsigned char)torus_fills(world, side, i % side, i / side);
    return tracer_footprint(&world->s, *settings, scene_vec(0.0f, 0.0f, 0.0f));
}

// Adds one sample to each pixel of a square picture.
static void torus_add_sample(const mesh_world *world, tracer_settings settings, uint32_t sample,
                             mesh_hits *hits, float *rgb) {
    int tiles = tracer_tile_side(settings) > 1, side = settings.width;
    int columns = tiles ? tracer_tile_count(settings, sample, 0) : side;
    int rows = tiles ? tracer_tile_count(settings, sample, 1) : side;

    for (int unit = 0; unit < columns * rows; unit++) {
        sss_vec3 radiance[TRACER_TILE_PIXELS];
        int x = unit % columns, y = unit / columns, count = tiles ? TRACER_TILE_PIXELS : 1;

        if (tiles) mesh_tile_sample(world, settings, x, y, sample, hits, radiance);
        else radiance[0] = mesh_sample(world, settings, x, y, sample, hits).radiance;

        for (int i = 0; i < count; i++) {
            int px = x, py = y;

            if (tiles && !tracer_tile_pixel(settings, sample, x, y, i, &px, &py)) continue;
            float *to = rgb + 3 * (py * side + px);
            to[0] += radiance[i].x;
            to[1] += radiance[i].y;
            to[2] += radiance[i].z;
        }
    }
}

#endif
