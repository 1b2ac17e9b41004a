// chart.c - the race: measures error against the volume's truth and CPU time of the rivals of
// rivals.h, one row of CSV for each way to sample. chart.py draws them. See --help.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#include <signal.h>

#define COMMAND "chart"
#include "demos/common/command.h"
#include "demos/common/progress.h"
#include "rivals.h"

#define CHART_SCENES SCENES_RABBIT // those before it: it is for the picture of the README
#define CHART_TILES  6
#define CHART_LEVELS 4 // errors after 1, 4, 16 and 64 samples
#define CHART_MOST   64
#define CHART_WIDTH  480
#define CHART_HEIGHT 270 // of the picture whose pixels share a point cloud
#define CHART_KEY    96

static const char usage[] =
    "usage: chart [--quick | --reduced] [--scene NAME] [--csv FILE]\n"
    "Measures total error (noise and model together) against a walk through the volume, and\n"
    "CPU time, of the ways to sample subsurface scattering: build/chart.csv.\n"
    "\n"
    "  --csv FILE   where the rows go; rows that it holds are not measured again\n"
    "  --scene NAME only this one: sphere, slab, corner, needles or bear\n"
    "  --reduced    an eighth of the work: fewer tiles, runs, walks and points\n"
    "  --quick      few samples: checks that all works, its figures say nothing\n"
    "  --help\n"
    "\n"
    "Ctrl-C keeps the finished rows, and the next run of the same program goes on from there.\n";

// `runs`: pictures of CHART_MOST samples a pixel. `walks`: for the truth of each pixel.
typedef struct chart_settings {
    const char *name;
    int tiles, runs, walks, sizes, points;
} chart_settings;
static const chart_settings chart_full = {"full", 6, 4, 4096, 3, 262144};
static const chart_settings chart_reduced = {"reduced", 3, 2, 1024, 3, 65536};
static const chart_settings chart_quick = {"quick", 1, 2, 64, 2, 1024};

// Factors of each scene's dmfp. At the first all ways race, at the others those of the map.
static const float chart_sizes[] = {1.0f, 0.125f, 4.0f};

// What shading an exit costs beyond one sample of the lamp, in probes. It is charged, not spent: no
// way's error depends on it, so that one measurement serves all costs.
#define CHART_COSTS 4
static const float chart_costs[CHART_COSTS] = {0.0f, 2.0f, 10.0f, 80.0f};
#define CHART_TOLERANCES 6
static const float chart_tolerances[CHART_TOLERANCES] = {0.5f, 0.2f, 0.1f, 0.05f, 0.02f, 0.01f};

enum { CHART_HEADER, CHART_PLAN, CHART_LEAN, CHART_CLOUD };

// A way to sample: a fixed plan of the header, sss_plan_for, the lean probe or the cloud.
typedef struct chart_method {
    const char *name;
    int kind, hint, strata;
    sss_plan plan;
    int least, most; // candidates by powers of two, or points of the cloud by powers of four
    int in_map;      // the candidates that race at every size, added up; -1: all
} chart_method;
static const chart_method chart_methods[] = {
    {"lambert", CHART_HEADER, HINT_NONE, 1, {0, 0, SSS_LAMBERT, 0, 0, 0}, 0, 0, -1},
    {"disk", CHART_HEADER, HINT_NONE, 1, {1, 1, SSS_DISK, 0, 0, 0}, 1, 1, -1},
    {"lean", CHART_LEAN, HINT_NONE, 1, {0, 0, 0u, 0, 0, 0}, 0, 0, -1},
    {"memo", CHART_HEADER, HINT_NONE, 1, {0, 1, SSS_DISK | SSS_SPHERE, 1, 0, 0}, 2, 64, 0},
    {"resampled", CHART_HEADER, HINT_NONE, 1, {0, 1, 0u, 0, 0, 0}, 1, 64, 2 + 8 + 32},
    {"resampled", CHART_HEADER, HINT_COSINE, 1, {0, 1, 0u, 0, 0, 0}, 1, 64, 2 + 8 + 32},
    {"two-exits", CHART_HEADER, HINT_COSINE, 1, {0, 2, 0u, 0, 0, 0}, 4, 16, 0},
    {"four-exits", CHART_HEADER, HINT_NONE, 1, {0, 4, 0u, 0, 0, 0}, 8, 32, 8},
    {"four-exits", CHART_HEADER, HINT_COSINE, 1, {0, 4, 0u, 0, 0, 0}, 8, 32, 8},
    {"colours", CHART_HEADER, HINT_NONE, 1, {0, 1, 0u, 0, 1, 0}, 2, 32, 8},
    {"colours", CHART_HEADER, HINT_COSINE, 1, {0, 1, 0u, 0, 1, 0}, 2, 32, 8},
    {"shared", CHART_HEADER, HINT_NONE, 1, {0, 1, 0u, 0, 1, 8}, 1, 32, 1 + 4 + 16},
    {"shared", CHART_HEADER, HINT_COSINE, 1, {0, 1, 0u, 0, 1, 8}, 1, 32, 1 + 4 + 16},
    {"shared-one", CHART_HEADER, HINT_NONE, 1, {0, 1, 0u, 0, 0, 8}, 1, 32, 4},
    {"shared-one", CHART_HEADER, HINT_COSINE, 1, {0, 1, 0u, 0, 0, 8}, 1, 32, 4},
    {"walk", CHART_HEADER, HINT_NONE, 1, {0, 1, SSS_WALK, 0, 0, 0}, 1, 1, -1},
    {"walk", CHART_HEADER, HINT_COSINE, 1, {0, 1, SSS_WALK, 0, 0, 0}, 2, 8, 2},
    {"no-strata", CHART_HEADER, HINT_COSINE, 0, {0, 1, 0u, 0, 0, 0}, 8, 8, 0},
    {"resampled", CHART_HEADER, HINT_LAMP, 1, {0, 1, 0u, 0, 0, 0}, 8, 8, 0},
    {"resampled", CHART_HEADER, HINT_EXACT, 1, {0, 1, 0u, 0, 0, 0}, 8, 8, 0},
    {"resampled", CHART_HEADER, HINT_WRONG, 1, {0, 1, 0u, 0, 0, 0}, 8, 8, 0},
    {"shared", CHART_HEADER, HINT_LAMP, 1, {0, 1, 0u, 0, 1, 8}, 8, 8, 0},
    {"shared", CHART_HEADER, HINT_EXACT, 1, {0, 1, 0u, 0, 1, 8}, 8, 8, 0},
    {"shared", CHART_HEADER, HINT_WRONG, 1, {0, 1, 0u, 0, 1, 8}, 8, 8, 0},
    {"cloud", CHART_CLOUD, HINT_NONE, 0, {0, 0, 0u, 0, 0, 0}, 1024, 262144, -1},
    {"plan", CHART_PLAN, HINT_NONE, 1, {0, 0, 0u, 0, 0, 0}, 0, CHART_TOLERANCES - 1, -1},
    {"plan", CHART_PLAN, HINT_COSINE, 1, {0, 0, 0u, 0, 0, 0}, 0, CHART_TOLERANCES - 1, -1},
};
#define CHART_METHODS ((int)(sizeof chart_methods / sizeof *chart_methods))

// The cloud is tuned: the solid angle of its nodes, and lamp samples of each point, squared.
#define CHART_CLOUDS 6
static const float chart_solid[CHART_CLOUDS] = {0.05f, 0.2f, 0.5f, 0.05f, 0.2f, 0.5f};
static const int chart_lamps[CHART_CLOUDS] = {1, 1, 1, 3, 3, 3};

// What a row holds: seconds, probes and shaded exits of a sample; and what a pixel costs once.
typedef struct chart_row {
    double seconds, probes, shaded, once_seconds, once_shaded;
    double error[CHART_LEVELS], block[CHART_LEVELS], model, model_block;
    double walks, lamberts; // parts of the pixels that the plan gives to these models
} chart_row;

// A scene at a size: what all its rows share.
typedef struct chart_world {
    rivals_world world;
    rivals_tile tile[CHART_TILES];
    rivals_truth truth[CHART_TILES];
    double probe_seconds, shade_seconds;
    double floor;       // square of a tenth of the mean light: keeps errors of dark pixels finite
    double truth_error; // relative, of a pixel
    double thickness;   // median, in longest dmfp
    int pixels;         // of the tiles
    int sees;           // pixels of the picture that see the object
    int cloud_points, cloud_lamps;
    double cloud_seconds;        // to build it
    rivals_way way[CHART_TILES]; // of the last row of lookups
    chart_row row;
} chart_world;

// Sums over the pixels of one tile.
typedef struct chart_sums {
    double seconds, error[CHART_LEVELS], block[CHART_LEVELS], model, model_block;
    double walks, lamberts;
    rivals_work work;
} chart_sums;

static volatile sig_atomic_t interrupted = 0;
static void interrupt(int signal) {
    (void)signal;
    interrupted = 1;
}

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// ---- Worlds

// CPU seconds of a probe with all that belongs to it, and of one sample of the lamp; least of five.
static void measure_costs(chart_world *w) {
    const rivals_tile *tile = &w->tile[0];
    static rivals_way way;
    static rivals_values value;
    rivals_work work = {0, 0};
    double least[2] = {1e30, 1e30};
    float sink = 0.0f;

    way.strata = 1;
    w->shade_seconds = 1e30;
    for (int round = 0; round < 10; round++) {
        double start = cpu_seconds();

        for (int i = 0; i < tile->count; i++) way.plan[i].candidates = round % 2 ? 64 : 8;
        rivals_header_tile(&w->world, tile, &way, 1u, (uint32_t)round, value, &work);
        double each = (cpu_seconds() - start) / tile->count;
        least[round % 2] = fmin(least[round % 2], each);

        start = cpu_seconds();
        for (int i = 0; i < 4096; i++) {
            const camera_entry *at = &tile->at[i % tile->count];
            tracer_random random = tracer_random_begin(2u, (uint32_t)i, 0u);
            sss_vec3 light = rivals_shade_exit(&w->world.s, at->position, at->normal, at->shape, 0,
                                               &random, &work);
            sink += light.x;
        }
        each = (cpu_seconds() - start) / 4096.0 + 1e-30 * (double)sink;
        w->shade_seconds = fmin(w->shade_seconds, each);
    }
    w->probe_seconds = (least[1] - least[0]) / 56.0;
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// What all truths of the world say together.
static void sum_up_truth(chart_world *w, const chart_settings *settings, double dmfp) {
    static double thickness[CHART_TILES * RIVALS_PIXELS];
    double light = 0.0, noise = 0.0, power = 0.0;

    w->pixels = 0;
    for (int t = 0; t < settings->tiles; t++) {
        for (int i = 0; i < w->tile[t].count; i++) {
            const double *mean = w->truth[t].mean[i], *variance = w->truth[t].variance[i];
            double radius = (double)rivals_radius(&w->world.s, &w->tile[t].at[i]);

            light += mean[0] + mean[1] + mean[2];
            power += mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2];
            noise += variance[0] + variance[1] + variance[2];
            thickness[w->pixels++] = 2.0 * radius / dmfp;
        }
    }
    qsort(thickness, (size_t)w->pixels, sizeof *thickness, compare_doubles);
    w->thickness = thickness[w->pixels / 2];
    w->truth_error = sqrt(noise / power);
    w->floor = 3.0 * pow(0.1 * light / (3.0 * w->pixels), 2.0);
}

static void make_world(chart_world *w, const chart_settings *settings, int scene_index,
                       float size) {
    double dmfp = 0.0;

    memset(w, 0, sizeof *w);
    scenes_optics optics = scenes_make(&w->world.s, scene_index);
    for (int c = 0; c < 3; c++) {
        optics.dmfp[c] *= size;
        dmfp = fmax(dmfp, (double)optics.dmfp[c]);
    }
    if (sss_burley(&w->world.s.medium, optics.albedo, optics.dmfp) != SSS_OK) fail(1, "bad medium");
    w->world.volume = walk_from_albedo(optics.albedo, optics.dmfp);
    for (int y = 0; y < CHART_HEIGHT; y++)
        for (int x = 0; x < CHART_WIDTH; x++)
            w->sees += tracer_sees_object(&w->world.s, CHART_WIDTH, CHART_HEIGHT, x, y);
    for (int t = 0; t < settings->tiles; t++) rivals_place(&w->world.s, (uint32_t)t, &w->tile[t]);

#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < settings->tiles; t++)
        rivals_walk_truth(&w->world, &w->tile[t], settings->walks, &w->truth[t]);
    sum_up_truth(w, settings, dmfp);
    measure_costs(w);
}

// ---- Errors of one tile

// Square of the relative error of a pixel's light.
static double pixel_error(const chart_world *w, const double *value, double scale,
                          const double *truth) {
    double error = 0.0, power = w->floor;

    for (int c = 0; c < 3; c++) {
        double d = value[c] * scale - truth[c];
        error += d * d;
        power += truth[c] * truth[c];
    }
    return error / power;
}

// The same of the mean over the tile's pixels.
static double block_error(const chart_world *w, const rivals_tile *tile, const rivals_truth *truth,
                          rivals_values sum, double scale) {
    double light[3] = {0.0}, mean[3] = {0.0};

    for (int k = 0; k < 3 * tile->count; k++) {
        light[k % 3] += sum[k / 3][k % 3] / tile->count;
        mean[k % 3] += truth->mean[k / 3][k % 3] / tile->count;
    }
    return pixel_error(w, light, scale, mean);
}

// What the truth's own noise adds to the squares above: to those of pixels, and of the block.
static void truth_noise(const chart_world *w, const rivals_tile *tile, const rivals_truth *truth,
                        double *pixels, double *block) {
    double mean[3] = {0.0}, deviation[3] = {0.0};

    *pixels = 0.0;
    for (int i = 0; i < tile->count; i++) {
        double noisy[3];
        for (int c = 0; c < 3; c++) {
            noisy[c] = truth->mean[i][c] + sqrt(truth->variance[i][c]);
            mean[c] += truth->mean[i][c] / tile->count;
            deviation[c] += truth->variance[i][c] / (tile->count * tile->count);
        }
        *pixels += pixel_error(w, noisy, 1.0, truth->mean[i]);
    }
    for (int c = 0; c < 3; c++) deviation[c] = mean[c] + sqrt(deviation[c]);
    *block = pixel_error(w, deviation, 1.0, mean);
}

typedef double chart_light[RIVALS_PIXELS][3];

// One picture of CHART_MOST samples: errors at all levels go to the sums, its light to `picture`.
static void measure_run(chart_sums *sums, const chart_world *w, const chart_method *m,
                        const rivals_way *way, int t, uint32_t seed, double part,
                        chart_light picture) {
    const rivals_tile *tile = &w->tile[t];
    const rivals_truth *truth = &w->truth[t];
    chart_light level[CHART_LEVELS] = {{{0.0}}};
    rivals_values value;

    for (int n = 0; n < CHART_MOST; n++) {
        double start = cpu_seconds();
        if (m->kind == CHART_LEAN)
            rivals_lean_tile(&w->world, tile, seed, (uint32_t)n, value, &sums->work);
        else rivals_header_tile(&w->world, tile, way, seed, (uint32_t)n, value, &sums->work);
        sums->seconds += cpu_seconds() - start;

        for (int l = 0, size = 1; l < CHART_LEVELS; l++, size *= 4) {
            double share = part * size / CHART_MOST;

            for (int k = 0; k < 3 * tile->count; k++) level[l][k / 3][k % 3] += value[k / 3][k % 3];
            if ((n + 1) % size != 0) continue;
            for (int i = 0; i < tile->count; i++)
                sums->error[l] += share * pixel_error(w, level[l][i], 1.0 / size, truth->mean[i]);
            sums->block[l] += share * block_error(w, tile, truth, level[l], 1.0 / size);
            if (size == CHART_MOST) memcpy(picture, level[l], sizeof(chart_light));
            memset(level[l], 0, sizeof level[l]);
        }
    }
}

// Square of the model's error: that of the mean over all runs, less the noise that is left in it.
static void measure_model(chart_sums *sums, const chart_world *w, int t, int runs,
                          chart_light *picture) {
    const rivals_tile *tile = &w->tile[t];
    chart_light mean = {{0.0}}, rest;
    double block = 0.0;

    for (int r = 0; r < runs; r++)
        for (int k = 0; k < 3 * tile->count; k++)
            mean[k / 3][k % 3] += picture[r][k / 3][k % 3] / (runs * CHART_MOST);
    for (int i = 0; i < tile->count; i++)
        sums->model += pixel_error(w, mean[i], 1.0, w->truth[t].mean[i]);
    sums->model_block += block_error(w, tile, &w->truth[t], mean, 1.0);

    // A run's deviation from the mean, put on top of the truth, has the truth's denominator.
    for (int r = 0; r < runs; r++) {
        double part = 1.0 / (runs * (runs - 1));

        for (int k = 0; k < 3 * tile->count; k++)
            rest[k / 3][k % 3] = picture[r][k / 3][k % 3] / CHART_MOST - mean[k / 3][k % 3] +
                                 w->truth[t].mean[k / 3][k % 3];
        for (int i = 0; i < tile->count; i++)
            sums->model -= part * pixel_error(w, rest[i], 1.0, w->truth[t].mean[i]);
        block += part * block_error(w, tile, &w->truth[t], rest, 1.0);
    }
    sums->model_block -= block;
}

// ---- Plans

// The plan that a user gets for each pixel of a tile.
static void ask_for_plans(const chart_world *w, const chart_method *m, int t, int tolerance,
                          int cost, sss_plan *plan) {
    const rivals_tile *tile = &w->tile[t];
    double own = w->shade_seconds / w->probe_seconds;

    for (int i = 0; i < tile->count; i++) {
        sss_need need;

        memset(&need, 0, sizeof need);
        need.footprint = rivals_footprint(&w->world.s, tile->at[i].distance);
        need.curvature_radius = rivals_radius(&w->world.s, &tile->at[i]);
        need.shading_cost = (float)own + chart_costs[cost];
        need.tolerance = chart_tolerances[tolerance];
        need.hinted = m->hint != HINT_NONE;
        plan[i] = sss_plan_for(&w->world.s.medium, &need);
    }
}

// How the pixels of a tile are sampled; returns the CPU seconds that asking took.
static double make_way(const chart_world *w, const chart_method *m, int t, int setting, int cost,
                       rivals_way *way) {
    double start = cpu_seconds();

    memset(way, 0, sizeof *way);
    way->hint = m->hint;
    way->strata = m->strata;
    if (m->kind == CHART_PLAN) {
        ask_for_plans(w, m, t, setting, cost, way->plan);
        return cpu_seconds() - start;
    }
    for (int i = 0; i < w->tile[t].count; i++) {
        way->plan[i] = m->plan;
        way->plan[i].candidates = setting;
    }
    return 0.0;
}

static void measure_tile(chart_sums *sums, const chart_world *w, const chart_settings *settings,
                         const chart_method *m, const rivals_way *way, int t) {
    static const uint32_t key = 41u;
    chart_light *picture = (chart_light *)calloc((size_t)settings->runs, sizeof *picture);
    double pixels, block;

    if (!picture) fail(1, "out of memory");
    memset(sums, 0, sizeof *sums);
    for (int i = 0; i < w->tile[t].count; i++) {
        sums->walks += way->plan[i].techniques == SSS_WALK;
        sums->lamberts += way->plan[i].techniques == SSS_LAMBERT;
    }
    for (int r = 0; r < settings->runs; r++)
        measure_run(sums, w, m, way, t, sss_hash(key, (uint32_t)r), 1.0 / settings->runs,
                    picture[r]);
    measure_model(sums, w, t, settings->runs, picture);

    truth_noise(w, &w->tile[t], &w->truth[t], &pixels, &block);
    for (int l = 0; l < CHART_LEVELS; l++) {
        sums->error[l] -= pixels;
        sums->block[l] -= block;
    }
    sums->model -= pixels;
    sums->model_block -= block;
    free(picture);
}

// The cloud is one picture: no noise to take off, and its error is at all levels the same.
static void measure_cloud_tile(chart_sums *sums, const chart_world *w, int t, int kind) {
    const rivals_tile *tile = &w->tile[t];
    rivals_values value;
    double pixels, block;

    memset(sums, 0, sizeof *sums);
    double start = cpu_seconds();
    rivals_cloud_tile(&w->world, tile, chart_solid[kind], value);
    sums->seconds = cpu_seconds() - start;

    truth_noise(w, tile, &w->truth[t], &pixels, &block);
    for (int i = 0; i < tile->count; i++)
        sums->model += pixel_error(w, value[i], 1.0, w->truth[t].mean[i]);
    sums->model -= pixels;
    sums->model_block = block_error(w, tile, &w->truth[t], value, 1.0) - block;
    for (int l = 0; l < CHART_LEVELS; l++) {
        sums->error[l] = sums->model;
        sums->block[l] = sums->model_block;
    }
}

// ---- One row

static double root(double squares, double count) { return sqrt(fmax(squares, 0.0) / count); }

static chart_row sum_up(const chart_sums *sums, const chart_world *w, int tiles, double samples) {
    double n = w->pixels, error[CHART_LEVELS] = {0.0}, block[CHART_LEVELS] = {0.0};
    double model = 0.0, model_block = 0.0;
    chart_row row;

    memset(&row, 0, sizeof row);
    for (int t = 0; t < tiles; t++) {
        row.seconds += sums[t].seconds / (n * samples);
        row.probes += (double)sums[t].work.probes / (n * samples);
        row.shaded += (double)sums[t].work.shaded / (n * samples);
        row.walks += sums[t].walks / n;
        row.lamberts += sums[t].lamberts / n;
        model += sums[t].model;
        model_block += sums[t].model_block;
        for (int l = 0; l < CHART_LEVELS; l++) {
            error[l] += sums[t].error[l];
            block[l] += sums[t].block[l];
        }
    }
    for (int l = 0; l < CHART_LEVELS; l++) {
        row.error[l] = root(error[l], n);
        row.block[l] = root(block[l], tiles);
    }
    row.model = root(model, n);
    row.model_block = root(model_block, tiles);
    return row;
}

static chart_row measure_lookups(chart_world *w, const chart_settings *settings,
                                 const chart_method *m, int setting, int cost) {
    static rivals_way way[CHART_TILES];
    static chart_sums sums[CHART_TILES];
    double asking = 0.0;

    for (int t = 0; t < settings->tiles; t++) asking += make_way(w, m, t, setting, cost, &way[t]);

    // Plans for another need are often the same: then the row is the one before.
    if (m->kind != CHART_PLAN || memcmp(way, w->way, sizeof way) != 0) {
#pragma omp parallel for schedule(dynamic)
        for (int t = 0; t < settings->tiles; t++)
            measure_tile(&sums[t], w, settings, m, &way[t], t);
        w->row = sum_up(sums, w, settings->tiles, (double)(settings->runs * CHART_MOST));
    }
    memcpy(w->way, way, sizeof way);
    w->row.once_seconds = asking / w->pixels;
    return w->row;
}

// A cloud is built once for all solid angles.
static chart_row measure_cloud(chart_world *w, const chart_settings *settings, int points,
                               int kind) {
    static chart_sums sums[CHART_TILES];

    if (w->cloud_points != points || w->cloud_lamps != chart_lamps[kind]) {
        double start = cpu_seconds();

        cloud_free(&w->world.cloud);
        if (!rivals_build_cloud(&w->world, points, chart_lamps[kind], 19u))
            fail(1, "out of memory");
        w->cloud_seconds = cpu_seconds() - start;
        w->cloud_points = points;
        w->cloud_lamps = chart_lamps[kind];
    }

#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < settings->tiles; t++) measure_cloud_tile(&sums[t], w, t, kind);

    chart_row row = sum_up(sums, w, settings->tiles, 1.0);
    row.once_seconds = w->cloud_seconds / w->sees;
    row.once_shaded = (double)w->world.cloud.points / w->sees;
    return row;
}

// ---- The file

static const char chart_columns[] =
    "scene,size,method,hint,setting,kind,seconds,probes,shaded,once_seconds,once_shaded,"
    "error_1,error_4,error_16,error_64,block_1,block_4,block_16,block_64,model,model_block,"
    "walks,lamberts,probe_seconds,shade_seconds,truth_error,thickness";

typedef struct chart_file {
    FILE *file;
    char (*key)[CHART_KEY];
    int keys, room;
} chart_file;

static const char *machine(void) {
    static char name[160] = "unknown processor";
    char line[256];
    FILE *f = fopen("/proc/cpuinfo", "r");

    while (f && fgets(line, sizeof line, f)) {
        if (strncmp(line, "model name", 10) != 0 || !strchr(line, ':')) continue;
        snprintf(name, sizeof name, "%.150s", strchr(line, ':') + 2);
        name[strcspn(name, "\n")] = '\0';
        break;
    }
    if (f) fclose(f);
    return name;
}

// Names this very program (FNV-1a of its file), so that rows of another header or compiler are not
// mixed in.
static unsigned program_hash(void) {
    uint32_t hash = 2166136261u;
    FILE *f = fopen("/proc/self/exe", "rb");

    for (int c; f && (c = fgetc(f)) != EOF;) hash = (hash ^ (uint32_t)c) * 16777619u;
    if (f) fclose(f);
    return hash;
}

static void remember(chart_file *f, const char *line) {
    size_t length = 0;

    for (int commas = 0; line[length] && commas < 6; length++) commas += line[length] == ',';
    if (f->keys == f->room) {
        f->room = 2 * f->room + 1024;
        f->key = realloc(f->key, (size_t)f->room * sizeof *f->key);
        if (!f->key) fail(1, "out of memory");
    }
    snprintf(f->key[f->keys++], CHART_KEY, "%.*s", (int)length, line);
}

static int is_known(const chart_file *f, const char *key) {
    for (int i = 0; i < f->keys; i++)
        if (strcmp(f->key[i], key) == 0) return 1;
    return 0;
}

// Reads the finished rows, cuts off one that was torn, and stays open for more. Rows of other
// settings, another program or another machine are refused.
static void open_file(chart_file *f, const char *path, const chart_settings *settings) {
    char line[1024], head[256];
    long whole = 0;
    int n = 0;

    memset(f, 0, sizeof *f);
    snprintf(head, sizeof head, "# chart %s, program %08x, CPU time on %s\n", settings->name,
             program_hash(), machine());
    f->file = fopen(path, "a+");
    if (!f->file) fail(2, "cannot write %s: %s", path, strerror(errno));
    rewind(f->file);
    for (; fgets(line, sizeof line, f->file) && strchr(line, '\n'); n++) {
        whole = ftell(f->file);
        if (n == 0 && strcmp(line, head) != 0)
            fail(2,
                 "%s was measured by another program, with other settings or elsewhere: "
                 "name another file, or remove it",
                 path);
        if (n > 1) remember(f, line);
    }
    if (ftruncate(fileno(f->file), whole) != 0) fail(1, "cannot cut %s: %s", path, strerror(errno));
    fseek(f->file, 0, SEEK_END);
    if (n == 0) fputs(head, f->file);
    if (n <= 1) fprintf(f->file, "%s\n", chart_columns);
}

static void write_row(chart_file *f, const char *key, const chart_row *r, const chart_world *w) {
    char line[1024];
    int n = snprintf(line, sizeof line, "%s%.5g,%.5g,%.5g,%.5g,%.5g,", key, r->seconds, r->probes,
                     r->shaded, r->once_seconds, r->once_shaded);

    for (int l = 0; l < CHART_LEVELS; l++)
        n += snprintf(line + n, sizeof line - (size_t)n, "%.6g,", r->error[l]);
    for (int l = 0; l < CHART_LEVELS; l++)
        n += snprintf(line + n, sizeof line - (size_t)n, "%.6g,", r->block[l]);
    snprintf(line + n, sizeof line - (size_t)n, "%.6g,%.6g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g\n",
             r->model, r->model_block, r->walks, r->lamberts, w->probe_seconds, w->shade_seconds,
             w->truth_error, w->thickness);
    if (fputs(line, f->file) < 0 || fflush(f->file) != 0)
        fail(1, "cannot write a row: %s", strerror(errno));
    remember(f, line);
}

// ---- The race

typedef struct chart_rows {
    int done, total, skipped;
} chart_rows;

// How many kinds of a row there are: costs of a plan, tunings of a cloud.
static int kinds(const chart_method *m) {
    if (m->kind == CHART_PLAN) return CHART_COSTS;
    return m->kind == CHART_CLOUD ? CHART_CLOUDS : 1;
}

static int is_wanted(const chart_settings *settings, const chart_method *m, int size, int setting) {
    if (m->kind == CHART_CLOUD && setting > settings->points) return 0;
    if (m->kind == CHART_CLOUD && size > 0 && setting > 65536) return 0;
    return size == 0 || m->in_map < 0 || (m->in_map & setting);
}

static int next_setting(const chart_method *m, int setting) {
    if (m->kind == CHART_PLAN) return setting + 1;
    if (setting == 0) return m->most + 1;
    return setting * (m->kind == CHART_CLOUD ? 4 : 2);
}

// All rows of one world. Without one they are counted, and 1 says that some are missing.
static int race(chart_file *f, chart_world *w, const chart_settings *settings, int scene_index,
                int size, chart_rows *rows, progress *p) {
    int missing = 0;

    for (int k = 0; k < CHART_METHODS; k++) {
        const chart_method *m = &chart_methods[k];

        for (int setting = m->least; setting <= m->most; setting = next_setting(m, setting)) {
            for (int kind = 0; kind < kinds(m) && !interrupted; kind++) {
                char key[CHART_KEY];

                if (!is_wanted(settings, m, size, setting)) continue;
                snprintf(key, sizeof key, "%s,%g,%s,%s,%d,%d,", scenes_known[scene_index].name,
                         (double)chart_sizes[size], m->name, rivals_hints[m->hint], setting, kind);
                int known = is_known(f, key);
                missing += !known;
                if (!w) {
                    rows->total++;
                    rows->skipped += known;
                } else if (!known) {
                    chart_row row = m->kind == CHART_CLOUD
                                        ? measure_cloud(w, settings, setting, kind)
                                        : measure_lookups(w, settings, m, setting, kind);
                    write_row(f, key, &row, w);
                    rows->done++;
                    progress_show(p, rows->done - rows->skipped);
                }
            }
        }
    }
    return missing > 0;
}

static int scene_of(const char *name) {
    for (int i = 0; i < CHART_SCENES; i++)
        if (strcmp(scenes_known[i].name, name) == 0) return i;
    fail(2, "there is no scene '%s' in the race; --help lists them", name);
    return -1;
}

// Sets the place of the file and the only scene, -1 for all.
static const chart_settings *parse(int count, char **words, const char **path, int *scene_index) {
    const chart_settings *settings = &chart_full;

    *path = "build/chart.csv";
    *scene_index = -1;
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--help") == 0) {
            fputs(usage, stdout);
            exit(fflush(stdout) == 0 ? 0 : 1);
        } else if (strcmp(words[i], "--quick") == 0) {
            settings = &chart_quick;
        } else if (strcmp(words[i], "--reduced") == 0) {
            settings = &chart_reduced;
        } else if (strcmp(words[i], "--csv") == 0) {
            if (++i == count) fail(2, "--csv wants a file name");
            *path = words[i];
        } else if (strcmp(words[i], "--scene") == 0) {
            if (++i == count) fail(2, "--scene wants a name");
            *scene_index = scene_of(words[i]);
        } else {
            fail(2, "unknown option '%s'; --help lists what there is", words[i]);
        }
    }
    return settings;
}

int main(int argc, char **argv) {
    static chart_world w;
    const char *path;
    int only;
    const chart_settings *settings = parse(argc, argv, &path, &only);
    chart_file f;
    chart_rows rows = {0, 0, 0};
    progress p;
    int missing[CHART_SCENES * 3] = {0};

    open_file(&f, path, settings);
    signal(SIGINT, interrupt);
    for (int i = 0; i < CHART_SCENES * settings->sizes; i++) {
        if (only >= 0 && i % CHART_SCENES != only) continue;
        missing[i] = race(&f, NULL, settings, i % CHART_SCENES, i / CHART_SCENES, &rows, NULL);
    }
    rows.done = rows.skipped;
    progress_begin(&p, "rows", rows.total - rows.skipped);
    for (int i = 0; i < CHART_SCENES * settings->sizes && !interrupted; i++) {
        if (!missing[i]) continue;
        make_world(&w, settings, i % CHART_SCENES, chart_sizes[i / CHART_SCENES]);
        race(&f, &w, settings, i % CHART_SCENES, i / CHART_SCENES, &rows, &p);
        cloud_free(&w.world.cloud);
    }

    progress_end(&p);
    free(f.key);
    if (fclose(f.file) != 0) fail(1, "cannot write %s: %s", path, strerror(errno));
    if (interrupted)
        fprintf(stderr, "chart: interrupted; %d of %d rows are in %s\n", rows.done, rows.total,
                path);
    return interrupted ? 130 : 0;
}
