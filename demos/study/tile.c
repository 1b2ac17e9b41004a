// tile.c - the experiment behind sss_share: its spacing rule, and the tile, the candidates and the
// colours that sss_plan_for advises. See --help.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#define COMMAND "tile"
#include "demos/common/command.h"
#include "demos/common/entries.h"
#include "demos/common/tracer.h"

#define TILE_SIDE  16 // of the largest tile
#define TILE_MOST  (TILE_SIDE * TILE_SIDE)
#define TILE_HITS  (64 * SCENE_MAX_SHAPES) // of one lookup, at most
#define TILE_ROWS  256                     // of the picture whose pixels are looked at
#define TILE_SIZES 8
#define NOT_SHARED (-1.0f)

static const char usage[] =
    "usage: tile [--quick]\n"
    "Measures what sharing does to the variance of lookups, over that of a hinted lookup with 8\n"
    "candidates and one exit of its own. Below 1 is better. CPU time is of the calling thread.\n"
    "\n"
    "First tables: 8 x 8 pixels share, one exit a colour. One column for each spacing rule: a "
    "channel\n"
    "takes part if its length (Burley's d) is at least that many pixels; the header has 0.5. `own` "
    "is\n"
    "the relative variance itself, `alone` one exit a colour without sharing. Where hints leave "
    "next\n"
    "to no variance, sharing adds some. Last tables: candidates, side of the tile, and one exit "
    "or\n"
    "one of each colour.\n"
    "\n"
    "  --quick   one pass: checks that all works, its figures say little\n"
    "  --help\n";

typedef struct tile_settings {
    int tiles, runs, scenes; // tiles of each case; lookups of each of its pixels
} tile_settings;
static const tile_settings tile_full = {6, 40, 3};
static const tile_settings tile_quick = {1, 4, 1};

// The entries of one tile that see the object.
typedef struct tile_group {
    int count;
    float pixel; // width of a pixel on the surface
    camera_entry at[TILE_MOST];
    sss_entry entry[TILE_MOST];
} tile_group;

// How lookups are made. `rule`: the least length that is shared, in pixels.
typedef struct tile_way {
    int side, candidates, per_channel;
    float rule;
} tile_way;
static const tile_way tile_own = {8, 8, 0, NOT_SHARED};
static const tile_way tile_alone = {8, 8, 1, NOT_SHARED};

// Mean over all tiles; the variance of one lookup.
typedef struct tile_result {
    double mean[3], variance[3], seconds;
} tile_result;

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// ---- Light and lookups

// The light hint of a lookup at a hit, and what shading an exit adds to the noise.
typedef struct tile_shading {
    const char *name;
    int knows_lamp; // its size, distance and the sky; else n.l + 0.05
    float noise;    // relative variance
} tile_shading;
static const tile_shading tile_shadings[] = {
    {"hints know all but shadows, shading without noise of its own", 1, 0.0f},
    {"hints know all but shadows, shading with a relative variance of 0.5", 1, 0.5f},
    {"hints are n.l + 0.05, shading without noise of its own", 0, 0.0f},
};

static float tile_hint(const scene *s, const tile_shading *how, sss_vec3 position,
                       sss_vec3 normal) {
    sss_vec3 to_light = scene_normalize(scene_sub(s->light.center, position));

    if (how->knows_lamp) return tracer_light_guess(s, position, normal);
    return scene_max(scene_dot(to_light, normal), 0.0f) + 0.05f;
}

// The light at an exit, as a path tracer estimates it: one point of the lamp, with its shadow. More
// noise of that relative variance is put on top.
static float tile_light(const scene *s, tracer_point point, float noise, uint32_t seed) {
    float u = tracer_unit(sss_hash(seed, 1u));
    float v = tracer_unit(sss_hash(seed, 2u));
    scene_ambient around = scene_make_ambient(s, point.position);
    sss_vec3 ambient = scene_ambient_irradiance(around, point.normal);
    float light = scene_mean(scene_add(tracer_light(s, point, u, v), ambient)) / SCENE_PI;
    int survives = tracer_unit(sss_hash(seed, 3u)) * (1.0f + noise) < 1.0f;

    return survives ? light * (1.0f + noise) : 0.0f;
}

// One lookup: its exits, and the light at each.
static int tile_lookup(const scene *s, camera_entry at, const tile_way *way,
                       const tile_shading *how, uint32_t seed, sss_exit *exits, float *light) {
    sss_plan plan = {way->candidates, 1, 0u, 0, way->per_channel, 0};
    sss_resampler r;
    sss_probe probe;
    scene_hits hits;
    int shape[TILE_HITS], calls = 0;

    sss_begin(&r, &s->medium, &plan, at.position, at.normal, seed);
    while (sss_next_probe(&r, &probe)) {
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++) {
            sss_vec3 y = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 n = scene_normal(&s->shape[hits.hit[i].shape], y);

            shape[calls++] = hits.hit[i].shape;
            sss_add_hit(&r, y, n, tile_hint(s, how, y, n));
        }
    }

    int count = sss_finish(&r, exits);
    for (int i = 0; i < count; i++) {
        tracer_point point = {exits[i].position, exits[i].normal, exits[i].position,
                              shape[exits[i].hit]};
        light[i] = tile_light(s, point, how->noise, sss_hash(seed, 50u + (uint32_t)i));
    }
    return count;
}

// One estimate for each entry of the tile.
static void tile_estimate(const scene *s, const tile_group *g, const tile_way *way,
                          const tile_shading *how, uint32_t seed, double (*value)[3]) {
    float weight[TILE_MOST][3];

    memset(value, 0, (size_t)g->count * sizeof *value);
    for (int k = 0; k < g->count; k++) {
        sss_exit exits[SSS_MAX_EXITS];
        float light[SSS_MAX_EXITS];
        uint32_t key = sss_hash(seed, (uint32_t)k);
        int count = tile_lookup(s, g->at[k], way, how, key, exits, light);

        for (int i = 0; i < count; i++) {
            if (way->rule < 0.0f) {
                for (int c = 0; c < 3; c++) value[k][c] += (double)(exits[i].weight[c] * light[i]);
                continue;
            }
            // The header shares lengths of at least half the spacing.
            sss_share(&exits[i], g->entry, g->count, k, 2.0f * way->rule * g->pixel, weight);
            for (int j = 0; j < g->count; j++)
                for (int c = 0; c < 3; c++) value[j][c] += (double)(weight[j][c] * light[i]);
        }
    }
}

// ---- Tiles and cases

static float tile_pixel(const scene *s, double distance) {
    return 2.0f * scene_sqrt(scene_dot(s->up, s->up)) * (float)distance / (float)TILE_ROWS;
}

// A tile somewhere in the picture, one entry a pixel; 0 if it does not see the object.
static int tile_place(const scene *s, int side, uint32_t seed, tile_group *g) {
    tracer_random random = tracer_random_begin(seed, 0u, 0u);
    float left = tracer_next(&random) * (float)(TILE_ROWS - side);
    float top = tracer_next(&random) * (float)(TILE_ROWS - side);
    double distance = 0.0;

    g->count = 0;
    for (int i = 0; i < side * side; i++) {
        camera_entry *at = &g->at[g->count];
        float x = floorf(left) + (float)(i % side) + tracer_next(&random);
        float y = floorf(top) + (float)(i / side) + tracer_next(&random);

        if (!camera_sees(s, x / (float)TILE_ROWS, y / (float)TILE_ROWS, at)) continue;
        g->entry[g->count].position = at->position;
        g->entry[g->count].medium = &s->medium;
        distance += (double)at->distance;
        g->count++;
    }
    if (g->count == 0) return 0;
    g->pixel = tile_pixel(s, distance / g->count);
    return 1;
}

// Adds one tile to the result, all its entries with the same part.
static void tile_add(const scene *s, const tile_way *way, const tile_shading *how, int runs,
                     uint32_t seed, double part, tile_result *result) {
    tile_group g;
    double value[TILE_MOST][3], sum[TILE_MOST][3], squares[TILE_MOST][3];

    while (!tile_place(s, way->side, seed, &g)) seed = sss_hash(seed, 99u);
    memset(sum, 0, sizeof sum);
    memset(squares, 0, sizeof squares);

    double start = cpu_seconds();
    for (int r = 0; r < runs; r++) {
        tile_estimate(s, &g, way, how, sss_hash(seed, 777u + (uint32_t)r), value);
        for (int k = 0; k < 3 * g.count; k++) {
            double v = value[k / 3][k % 3];
            sum[k / 3][k % 3] += v;
            squares[k / 3][k % 3] += v * v;
        }
    }
    double seconds = cpu_seconds() - start;

#pragma omp critical
    {
        for (int k = 0; k < 3 * g.count; k++) {
            double mean = sum[k / 3][k % 3] / runs;
            double variance = (squares[k / 3][k % 3] - sum[k / 3][k % 3] * mean) / (runs - 1);
            result->mean[k % 3] += part * mean / g.count;
            result->variance[k % 3] += part * variance / g.count;
        }
        result->seconds += part * seconds / (g.count * runs);
    }
}

static tile_result tile_measure(const scene *s, const tile_way *way, const tile_shading *how,
                                const tile_settings *settings) {
    tile_result result = {{0.0}, {0.0}, 0.0};

#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < settings->tiles; t++)
        tile_add(s, way, how, settings->runs, sss_hash(5u, (uint32_t)t), 1.0 / settings->tiles,
                 &result);
    return result;
}

// Relative variance, summed over the colours.
static double tile_variance(const tile_result *r, const tile_result *relative_to) {
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += r->variance[c] / (relative_to->mean[c] * relative_to->mean[c]);
    return sum;
}

// A scene with a grey medium or a coloured one; the longest dmfp in pixels.
static void tile_scene(scene *s, int which, int coloured, float dmfp) {
    static const float spread[2][3] = {{1.0f, 1.0f, 1.0f}, {1.0f, 0.2f, 0.04f}};
    static const float albedo[2][3] = {{0.8f, 0.8f, 0.8f}, {0.9f, 0.6f, 0.4f}};
    float length[3];

    scenes_make(s, which);
    float pixel = tile_pixel(s, (double)scene_sqrt(scene_dot(s->eye, s->eye)));
    for (int c = 0; c < 3; c++) length[c] = spread[coloured][c] * dmfp * pixel;
    if (sss_burley(&s->medium, albedo[coloured], length) != SSS_OK) fail(1, "bad medium");
}

static const char *const tile_colours[2] = {"grey", "coloured"};
static const int tile_scenes[] = {SCENES_SPHERE, SCENES_SLAB, SCENES_CORNER};

// ---- The first table: the rule

#define TILE_RULES 6
static const float tile_rules[TILE_RULES] = {0.0f, 0.125f, 0.25f, 0.5f, 1.0f, 2.0f};

typedef struct tile_column {
    double logs, worst, time;
} tile_column;

// One case: its ratios go to the columns, `alone` last.
static void tile_rule_row(const scene *s, const tile_shading *how, const tile_settings *settings,
                          tile_column *column) {
    tile_result own = tile_measure(s, &tile_own, how, settings);
    double plain = tile_variance(&own, &own);

    printf(" %7.4f", plain / 3.0);
    for (int i = 0; i <= TILE_RULES; i++) {
        tile_way way = tile_alone;
        if (i < TILE_RULES) way.rule = tile_rules[i];
        tile_result r = tile_measure(s, &way, how, settings);
        double ratio = tile_variance(&r, &own) / plain;
        double time = r.seconds / own.seconds;

        printf(" %7.4f", ratio);
        column[i].logs += log(ratio);
        column[i].time += log(time);
        if (ratio > column[i].worst) column[i].worst = ratio;
    }
    printf("\n");
    fflush(stdout);
}

static void tile_rule_table(const tile_shading *how, const tile_settings *settings) {
    static const float sizes[TILE_SIZES] = {100.0f, 30.0f, 10.0f, 5.0f, 2.0f, 1.0f, 0.5f, 0.25f};
    static scene s;
    tile_column column[TILE_RULES + 1] = {{0.0, 0.0, 0.0}};
    int cases = 0;

    printf("\nVariance over that of one exit of its own; %s\n%-31s     own", how->name,
           "shared from a length of");
    for (int i = 0; i < TILE_RULES; i++) printf(" %7.3f", (double)tile_rules[i]);
    printf("   alone\n");

    for (int k = 0; k < 2 * TILE_SIZES * settings->scenes; k++) {
        int which = tile_scenes[k / (2 * TILE_SIZES)];
        int coloured = k / TILE_SIZES % 2;
        float dmfp = sizes[k % TILE_SIZES];

        tile_scene(&s, which, coloured, dmfp);
        printf("%-7s %-8s %7.2f pixels", scenes_known[which].name, tile_colours[coloured],
               (double)dmfp);
        tile_rule_row(&s, how, settings, column);
        cases++;
    }

    printf("%-39s", "geometric mean");
    for (int i = 0; i <= TILE_RULES; i++) printf(" %7.4f", exp(column[i].logs / cases));
    printf("\n");
    printf("%-39s", "worst case");
    for (int i = 0; i <= TILE_RULES; i++) printf(" %7.4f", column[i].worst);
    printf("\n");
    printf("%-39s", "CPU time over own exit's");
    for (int i = 0; i <= TILE_RULES; i++) printf(" %7.2f", exp(column[i].time / cases));
    printf("\n");
    printf("%-39s", "variance times time");
    for (int i = 0; i <= TILE_RULES; i++)
        printf(" %7.4f", exp((column[i].logs + column[i].time) / cases));
    printf("\n");
}

// ---- The second table: candidates, tile and colours

#define TILE_SIDES      5
#define TILE_CANDIDATES 4

// A medium in all scenes, and what lookups of their own give there.
typedef struct tile_block {
    scene s[3];
    tile_result own[3];
} tile_block;

// Variance and CPU time over those of lookups of their own: geometric means over the scenes.
static void tile_plan_cell(const tile_block *b, const tile_way *way,
                           const tile_settings *settings) {
    double variance = 0.0, time = 0.0;

    for (int k = 0; k < settings->scenes; k++) {
        const tile_result *own = &b->own[k];
        tile_result r = tile_measure(&b->s[k], way, &tile_shadings[0], settings);

        variance += log(tile_variance(&r, own) / tile_variance(own, own));
        time += log(r.seconds / own->seconds);
    }
    printf(" %7.4f (%4.2f)", exp(variance / settings->scenes), exp(time / settings->scenes));
    fflush(stdout);
}

static void tile_plan_block(int coloured, float dmfp, const tile_settings *settings) {
    static const int sides[TILE_SIDES] = {1, 2, 4, 8, 16};
    static const int candidates[TILE_CANDIDATES] = {1, 2, 4, 8};
    static tile_block b;

    for (int k = 0; k < settings->scenes; k++) {
        tile_scene(&b.s[k], tile_scenes[k], coloured, dmfp);
        b.own[k] = tile_measure(&b.s[k], &tile_own, &tile_shadings[0], settings);
    }

    printf("\n%s, dmfp %.0f pixels: variance (CPU time)\n%26s", tile_colours[coloured],
           (double)dmfp, "");
    for (int t = 0; t < TILE_SIDES; t++) printf(" %5d x %-6d", sides[t], sides[t]);
    printf("\n");

    for (int k = 0; k < 2 * TILE_CANDIDATES; k++) {
        int colours = k / TILE_CANDIDATES, m = candidates[k % TILE_CANDIDATES];

        printf("%s, %d candidate%s", colours ? "each its own" : "one exit    ", m,
               m > 1 ? "s" : " ");
        for (int t = 0; t < TILE_SIDES; t++) {
            tile_way way = {sides[t], m, colours, sides[t] > 1 ? 0.5f : NOT_SHARED};

            if (sides[t] == 1) way.side = 8; // the same entries
            tile_plan_cell(&b, &way, settings);
        }
        printf("\n");
    }
}

static void tile_plan_table(const tile_settings *settings) {
    static const float sizes[] = {100.0f, 30.0f, 10.0f, 3.0f};
    int count = settings->scenes > 1 ? (int)(sizeof sizes / sizeof *sizes) : 1;

    for (int k = 0; k < 2 * count; k++) tile_plan_block(k / count, sizes[k % count], settings);
}

int main(int argc, char **argv) {
    const tile_settings *settings = &tile_full;

    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(usage, stdout);
            return fflush(stdout) == 0 ? 0 : 1;
        }
        if (strcmp(argv[i], "--quick") != 0)
            fail(2, "unknown option '%s'; --help lists what there is", argv[i]);
        settings = &tile_quick;
    }

    for (size_t i = 0; i < sizeof tile_shadings / sizeof *tile_shadings; i++)
        tile_rule_table(&tile_shadings[i], settings);
    tile_plan_table(settings);
    return 0;
}
