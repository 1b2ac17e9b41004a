// mesh_race.c - speed against accuracy on a mesh, where rays cost what they cost. See --help.
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "mesh_race"
#include "demos/common/command.h"
#include "demos/study/torus.h"

enum { SIDE = 64, LEVELS = 5, METHODS = 12, MEDIA = 3, TRUTH = 4096, FLOATS = 3 * SIDE * SIDE };

static const char usage[] =
    "usage: mesh_race [--reduced]\n"
    "A torus of 50,000 triangles, with Embree: the total error of a picture (noise and model) "
    "against\n"
    "a walk through the volume, after 1 to 256 samples a pixel, and the CPU time of one. Rows\n"
    "for demos/study/chart.py. Errors below `unsure` may be noise of the truth. Takes 4 minutes.\n"
    "\n"
    "  --reduced   a thirty-second of the truth: checks that all works, its figures say little\n"
    "  --help\n";

// A fixed plan; or, where the tolerance is above 0, the model that sss_plan_for chooses for each
// lookup, with the candidates, colours and tile for a body on which the profile is right.
typedef struct race_method {
    const char *name;
    unsigned techniques;
    int candidates, is_shared, is_hinted;
    float tolerance;
} race_method;
static const race_method methods[METHODS] = {
    {"Lambert", SSS_LAMBERT, 1, 0, 0, 0.0f},
    {"one disk", SSS_DISK, 1, 0, 0, 0.0f},
    {"resampled", 0u, 8, 0, 0, 0.0f},
    {"resampled", 0u, 8, 0, 1, 0.0f},
    {"shared", 0u, 2, 1, 1, 0.0f},
    {"walk", SSS_WALK, 1, 0, 0, 0.0f},
    {"plan", 0u, 0, 0, 1, 0.5f},
    {"plan", 0u, 0, 0, 1, 0.2f},
    {"plan", 0u, 0, 0, 1, 0.1f},
    {"plan", 0u, 0, 0, 1, 0.05f},
    {"plan", 0u, 0, 0, 1, 0.02f},
    {"plan", 0u, 0, 0, 1, 0.01f},
};

static mesh_world world;
static unsigned char mask[SIDE * SIDE]; // pixels that show nothing but the object
static float truth[2][FLOATS];

static void set_method(tracer_settings *settings, const race_method *m, float footprint) {
    memset(&settings->plan, 0, sizeof settings->plan);
    settings->light_aware = m->is_hinted;
    settings->tolerance = m->tolerance;
    if (m->tolerance > 0.0f) {
        settings->plan = tracer_sharing(&world.s.medium, footprint, m->is_hinted);
        return;
    }
    settings->plan.techniques = m->techniques;
    settings->plan.candidates = m->candidates;
    settings->plan.per_channel = m->is_shared;
    settings->plan.tile = m->is_shared ? 8 : 0;
}

// Two halves, so that the noise of the truth cancels in a product of differences.
static void make_truth(tracer_settings settings, int samples) {
    memset(&settings.plan, 0, sizeof settings.plan);
    settings.plan.techniques = SSS_WALK;
    settings.tolerance = 0.0f;
    settings.light_aware = 0;
    settings.plan.candidates = 1;
    memset(truth, 0, sizeof truth);

#pragma omp parallel for
    for (int h = 0; h < 2; h++) {
        mesh_hits hits = {0, 0, NULL};
        tracer_settings mine = settings;

        mine.seed = 1000u + (uint32_t)h;
        for (int k = 0; k < samples; k++)
            torus_add_sample(&world, mine, (uint32_t)k, &hits, truth[h]);
        for (int i = 0; i < FLOATS; i++) truth[h][i] /= (float)samples;
        free(hits.hit);
    }
}

// The mean square over the object's pixels and the colours, relative, and its standard error.
static double squared_error(const float *sum, int samples, double *unsure) {
    double squares = 0.0, spread = 0.0, power = 0.0;
    int pixels = 0;

    for (int p = 0; p < SIDE * SIDE; p++) {
        double pixel = 0.0;

        if (!mask[p]) continue;
        for (int i = 3 * p; i < 3 * p + 3; i++) {
            double a = (double)sum[i] / samples;
            pixel += (a - (double)truth[0][i]) * (a - (double)truth[1][i]);
            power += (double)truth[0][i] * (double)truth[1][i];
        }
        squares += pixel;
        spread += pixel * pixel;
        pixels++;
    }
    *unsure = sqrt(spread - squares * squares / pixels) / power;
    return squares / power;
}

static void run_method(tracer_settings settings, const char *body, const race_method *m) {
    static float sum[FLOATS];
    mesh_hits hits = {0, 0, NULL};
    double error[LEVELS], unsure = 0.0, seconds = 0.0;
    int samples = 0;

    memset(sum, 0, sizeof sum);
    for (int level = 0; level < LEVELS; level++) {
        struct timespec start, end;

        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
        for (; samples < 1 << (2 * level); samples++)
            torus_add_sample(&world, settings, (uint32_t)samples, &hits, sum);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
        seconds +=
            (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
        error[level] = sqrt(fmax(squared_error(sum, samples, &unsure), 0.0));
    }
    free(hits.hit);

    printf("%s,%s,%d,%g,%.4g", body, m->name, m->is_hinted, (double)m->tolerance,
           seconds / (samples * SIDE * SIDE));
    for (int level = 0; level < LEVELS; level++) printf(",%.5f", error[level]);
    printf(",%.5f\n", sqrt(unsure));
    fflush(stdout);
}

int main(int argc, char **argv) {
    static const char *const bodies[MEDIA] = {"thick", "curved", "thin"};
    static const float thickness[MEDIA] = {16.0f, 4.0f, 0.7f}; // of the tube, in the longest dmfp
    static const float albedo[3] = {0.93f, 0.42f, 0.14f}, part[3] = {1.0f, 0.4f, 0.17f};
    int samples = TRUTH;

    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(usage, stdout);
            return fflush(stdout) == 0 ? 0 : 1;
        }
        if (strcmp(argv[i], "--reduced") != 0)
            fail(2, "unknown option '%s'; --help lists what there is", argv[i]);
        samples = TRUTH / 32;
    }

    tracer_settings settings;
    float footprint = torus_begin(&world, SIDE, &settings, mask);

    printf("body,method,hinted,tolerance,seconds,error_1,error_4,error_16,error_64,error_256,"
           "unsure\n");
    for (int k = 0; k < MEDIA; k++) {
        float dmfp[3];

        for (int c = 0; c < 3; c++) dmfp[c] = part[c] * 0.8f * (float)world.m.unit / thickness[k];
        if (sss_burley(&world.s.medium, albedo, dmfp) != SSS_OK) fail(1, "bad medium");
        make_truth(settings, samples);
        for (int i = 0; i < METHODS; i++) {
            set_method(&settings, &methods[i], footprint);
            settings.seed = 1u;
            run_method(settings, bodies[k], &methods[i]);
        }
    }
    mesh_close(&world);
    return 0;
}
