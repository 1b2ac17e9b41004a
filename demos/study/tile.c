// tile.c - the experiment behind sss_share's spacing rule and the tile that sss_plan_for advises: the variance of a
// lookup that shares the exits of its tile, over that of one exit of its own.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "scenes.h"
#include "tracer.h"

#define TILE_MOST 16 // side of the largest tile

typedef struct tile_case {
    const char *scene;
    float dmfp_in_pixels; // of the widest channel
    int colours;          // 0: grey, 1: coloured
} tile_case;

typedef struct tile_group {
    int count;
    sss_vec3 position[TILE_MOST * TILE_MOST], normal[TILE_MOST * TILE_MOST];
    sss_entry entry[TILE_MOST * TILE_MOST];
} tile_group;

// How a lookup is made.
typedef struct tile_way {
    int side, candidates, per_channel, samples;
    float spacing; // in pixels; below 0: no sharing
} tile_way;

static float noise; // relative variance of shading

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// The light at an exit, over pi, as a path tracer estimates it: one point of the lamp, with its shadow.
static float tile_light(const scene *s, sss_vec3 position, sss_vec3 normal, int shape, uint32_t seed) {
    tracer_point point = {position, normal, position, shape};
    float u = tracer_unit(sss_hash(seed, 1u)), v = tracer_unit(sss_hash(seed, 2u));
    sss_vec3 around = scene_ambient_irradiance(scene_make_ambient(s, position), normal);

    float e = scene_mean(scene_add(tracer_light(s, point, u, v), around)) / SCENE_PI;

    return noise > 0.0f ? (tracer_unit(sss_hash(seed, 3u)) < 1.0f / (1.0f + noise) ? e * (1.0f + noise) : 0.0f) : e;
}

// One lookup of entry k: its exits, with the light at each.
static int tile_lookup(const scene *s, const tile_group *g, int k, const tile_way *way, uint32_t seed, sss_exit *exits, float *light) {
    sss_resampler r;
    sss_probe probe;
    scene_hits hits;
    int shapes[64 * 40], calls = 0, count;
    sss_plan plan = {way->candidates, 1, 0u, 0, way->per_channel, 0};
    sss_begin(&r, &s->medium, &plan, g->position[k], g->normal[k], seed);
    while (sss_next_probe(&r, &probe)) {
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++) {
            sss_vec3 x = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 n = scene_normal(&s->shape[hits.hit[i].shape], x);
            shapes[calls++] = hits.hit[i].shape;
            sss_add_hit(&r, x, n, tracer_light_guess(s, x, n));
        }
    }
    count = sss_finish(&r, exits);
    for (int i = 0; i < count; i++) light[i] = tile_light(s, exits[i].position, exits[i].normal, shapes[exits[i].hit], sss_hash(seed, 50u + (uint32_t)i));
    return count;
}

// The estimates of all entries of the group.
static void tile_estimate(const scene *s, const tile_group *g, const tile_way *way, float pixel, uint32_t seed, double (*value)[3]) {
    static _Thread_local float weight[TILE_MOST * TILE_MOST][3];
    for (int k = 0; k < g->count; k++) value[k][0] = value[k][1] = value[k][2] = 0.0;
    for (int k = 0; k < g->count; k++) {
        sss_exit exits[SSS_MAX_EXITS];
        float light[SSS_MAX_EXITS];
        int count = tile_lookup(s, g, k, way, sss_hash(seed, (uint32_t)k), exits, light);
        for (int i = 0; i < count; i++) {
            if (way->spacing < 0.0f) {
                for (int c = 0; c < 3; c++) value[k][c] += (double)(exits[i].weight[c] * light[i]);
                continue;
            }
            sss_share(&exits[i], g->entry, g->count, k, way->spacing * pixel, weight);
            for (int j = 0; j < g->count; j++)
                for (int c = 0; c < 3; c++) value[j][c] += (double)(weight[j][c] * light[i]);
        }
    }
}

static float tile_pixel(const scene *s, int resolution, float distance) {
    return 2.0f * scene_sqrt(scene_dot(s->up, s->up)) * distance / (float)resolution;
}

static int tile_make(const scene *s, int resolution, int side, uint32_t seed, tile_group *g, float *pixel) {
    int x0 = (int)(tracer_unit(sss_hash(seed, 1u)) * (float)(resolution - side)), y0 = (int)(tracer_unit(sss_hash(seed, 2u)) * (float)(resolution - side));
    double distance = 0.0;
    g->count = 0;
    for (int i = 0; i < side * side; i++) {
        float x = (float)(x0 + i % side) + tracer_unit(sss_hash(seed, 10u + (uint32_t)i)), y = (float)(y0 + i / side) + tracer_unit(sss_hash(seed, 5000u + (uint32_t)i));
        sss_vec3 d = tracer_camera(s, resolution, resolution, x, y);
        scene_hit hit = scene_nearest(s, s->eye, d, SCENE_NOTHING);
        if (hit.shape < 0) continue;
        g->position[g->count] = scene_along(s->eye, d, hit.t);
        g->normal[g->count] = scene_normal(&s->shape[hit.shape], g->position[g->count]);
        g->entry[g->count].position = g->position[g->count];
        g->entry[g->count].medium = &s->medium;
        g->count++;
        distance += (double)hit.t;
    }
    if (g->count > 0) *pixel = tile_pixel(s, resolution, (float)(distance / g->count));
    return g->count > 0;
}

// Variance by channel, summed over entries and tiles, and the squared means; seconds of CPU for each lookup.
typedef struct tile_sums {
    double variance[3], mean[3], square, seconds;
    long lookups;
} tile_sums;

static void tile_measure(const scene *s, const tile_way *way, int resolution, int tiles, int runs, uint32_t key, tile_sums *sums) {
    memset(sums, 0, sizeof *sums);
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) {
        tile_group *g = malloc(sizeof *g);
        double(*sum)[3] = calloc(TILE_MOST * TILE_MOST, sizeof *sum), (*squares)[3] = calloc(TILE_MOST * TILE_MOST, sizeof *squares), (*value)[3] = calloc(TILE_MOST * TILE_MOST, sizeof *value);
        float pixel = 0.0f;
        uint32_t seed = sss_hash(key, (uint32_t)t);
        while (!tile_make(s, resolution, way->side, seed, g, &pixel)) seed = sss_hash(seed, 99u);
        double start = now();
        for (int r = 0; r < runs; r++) {
            tile_estimate(s, g, way, pixel, sss_hash(seed, 777u + (uint32_t)r), value);
            for (int k = 0; k < g->count; k++)
                for (int c = 0; c < 3; c++) sum[k][c] += value[k][c], squares[k][c] += value[k][c] * value[k][c];
        }
        double seconds = now() - start;
#pragma omp critical
        {
            for (int k = 0; k < g->count; k++)
                for (int c = 0; c < 3; c++) {
                    double mean = sum[k][c] / runs;
                    sums->variance[c] += (squares[k][c] - sum[k][c] * mean) / (runs - 1) / g->count;
                    sums->mean[c] += mean / g->count;
                }
            sums->seconds += seconds;
            sums->lookups += (long)g->count * runs;
        }
        free(g), free(sum), free(squares), free(value);
    }
}

static void tile_medium(scene *s, int colours, float dmfp) {
    static const float spread[2][3] = {{1.0f, 1.0f, 1.0f}, {1.0f, 0.2f, 0.04f}}, albedo[2][3] = {{0.8f, 0.8f, 0.8f}, {0.9f, 0.6f, 0.4f}};
    float d[3];
    for (int c = 0; c < 3; c++) d[c] = spread[colours][c] * dmfp;
    sss_burley(&s->medium, albedo[colours], d);
}

int main(int argc, char **argv) {
    static const char *const scenes[] = {"sphere", "slab", "corner", "needles", "bear"};
    static const float sizes[] = {100.0f, 30.0f, 10.0f, 5.0f, 2.0f, 1.0f, 0.5f, 0.25f};
    float factor = argc > 1 ? (float)atof(argv[1]) : 1.0f;
    int tiles = argc > 2 ? atoi(argv[2]) : 6, runs = argc > 3 ? atoi(argv[3]) : 40, scene_count = argc > 4 ? atoi(argv[4]) : 3;
    int resolution = 256;
    noise = argc > 5 ? (float)atof(argv[5]) : 0.0f;
    double logs = 0.0, time_logs = 0.0, worst = 0.0;
    int n = 0;
    for (int k = 0; k < scene_count; k++) {
        static scene s;
        scenes_optics optics;
        if (!scenes_find(&s, &optics, scenes[k])) return 2;
        for (int colours = 0; colours < 2; colours++) {
            for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
                tile_sums own, shared, apart;
                float distance = scene_sqrt(scene_dot(s.eye, s.eye));
                tile_medium(&s, colours, sizes[i] * tile_pixel(&s, resolution, distance));
                tile_way a = {8, 8, 0, 1, -1.0f}, b = {8, 8, 1, 1, factor}, c = {8, 8, 1, 1, -1.0f};
                tile_measure(&s, &a, resolution, tiles, runs, 5u, &own);
                tile_measure(&s, &b, resolution, tiles, runs, 5u, &shared);
                tile_measure(&s, &c, resolution, tiles, runs, 5u, &apart);
                double sum_own = 0.0, sum_shared = 0.0;
                printf("%-8s %s dmfp %6.2f px:", scenes[k], colours ? "coloured" : "grey    ", (double)sizes[i]);
                for (int ch = 0; ch < 3; ch++) {
                    sum_own += own.variance[ch] / (own.mean[ch] * own.mean[ch]), sum_shared += shared.variance[ch] / (own.mean[ch] * own.mean[ch]);
                    printf(" %.3f(%.2f)", shared.variance[ch] / own.variance[ch], apart.variance[ch] / own.variance[ch]);
                    if (!colours) break;
                }
                double ratio = sum_shared / sum_own, t = shared.seconds / shared.lookups / (own.seconds / own.lookups);
                printf("  own %.3f all %.4f, time %.2f, product %.4f, means %+.2f %%\n", sum_own / 3 * tiles, ratio, t, ratio * t, 100.0 * (shared.mean[0] / own.mean[0] - 1.0));
                logs += log(ratio), time_logs += log(ratio * t), n++;
                if (ratio > worst) worst = ratio;
            }
        }
    }
    printf("geometric mean %.4f, with time %.4f, worst %.3f\n", exp(logs / n), exp(time_logs / n), worst);
    return 0;
}
