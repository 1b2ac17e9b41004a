// mesh_share.c - what sharing exits brings on a mesh, where rays take nearly all of the time: noise
// and time of one core against the default plan, over media from narrower than a pixel to much
// wider. Prints what demos/study/README.md shows. SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "mesh_share"
#include "demos/common/command.h"
#include "demos/study/torus.h"

enum { SIDE = 128, SPP = 8, MEDIA = 10, RUNS = 3 };
enum { DEFAULT, FOUR, HINTED, PLAN, PLAN_HINTED, METHODS };
static const char *const method_name[METHODS] = {"default", "4 candidates", "with a hint",
                                                 "the plan", "the plan, with a hint"};

static mesh_world world;
static unsigned char mask[SIDE * SIDE]; // pixels that show nothing but the object

// The squared error of 16 samples a pixel over the mean square, by the difference of two halves,
// and the seconds of the processor that they take.
static double measure(tracer_settings settings, double *seconds) {
    static float half[2][3 * SIDE * SIDE];
    mesh_hits hits = {0, 0, NULL};
    struct timespec start, end;
    double squares = 0.0, power = 0.0;
    memset(half, 0, sizeof half);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    for (uint32_t k = 0; k < 2 * SPP; k++) {
        settings.seed = 1u + k % 2;
        torus_add_sample(&world, settings, k / 2, &hits, half[k % 2]);
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    *seconds = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
        if (!mask[i / 3]) continue;
        double difference = (double)half[0][i] - (double)half[1][i];
        squares += difference * difference;
        power += (double)half[0][i] * (double)half[1][i];
    }
    free(hits.hit);
    return squares / power / 4.0;
}

static void set_method(tracer_settings *settings, int method, float footprint) {
    memset(&settings->plan, 0, sizeof settings->plan);
    settings->light_aware = method == HINTED || method == PLAN_HINTED;
    if (method == FOUR) settings->plan.candidates = 4;
    if (method != PLAN && method != PLAN_HINTED) return;

    sss_plan advice = tracer_sharing(&world.s.medium, footprint, settings->light_aware);
    settings->plan.tile = advice.tile;
    settings->plan.candidates = advice.candidates;
    settings->plan.per_channel = advice.per_channel;
}

// A medium's lengths in pixels, shortest and longest, and for each method the error over that of
// the default in the same time.
typedef struct row {
    float least, most, dmfp_least, dmfp_most;
    int is_grey, shared[METHODS];
    double ratio[METHODS];
} row;

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Errors do not depend on the run, times do: the median of RUNS.
static void measure_row(row *r, tracer_settings settings, float pixel) {
    const float *d = world.s.medium.length;
    double price[METHODS];
    r->least = fminf(d[0], fminf(d[1], d[2])) / pixel;
    r->most = fmaxf(d[0], fmaxf(d[1], d[2])) / pixel;

    for (int i = 0; i < METHODS; i++) {
        double seconds[RUNS], error = 0.0;
        set_method(&settings, i, pixel);
        for (int k = 0; k < RUNS; k++) error = measure(settings, &seconds[k]);
        qsort(seconds, RUNS, sizeof *seconds, compare);
        price[i] = error * seconds[RUNS / 2];
        r->shared[i] = settings.plan.tile > 1;
        r->ratio[i] = price[i] / price[DEFAULT];
        fprintf(stderr, "%s: error %.5f, %.2f to %.2f s\n", method_name[i], error, seconds[0],
                seconds[RUNS - 1]);
    }
}

// As demos/study/README.md shows it.
static void print_row(const row *r) {
    if (r->is_grey) printf("| %.2g | grey, dmfp %g |", (double)r->most, (double)r->dmfp_most);
    else
        printf("| %.2g to %.2g | coloured, dmfp %.2g to %g |", (double)r->least, (double)r->most,
               (double)r->dmfp_least, (double)r->dmfp_most);
    for (int i = DEFAULT + 1; i < METHODS; i++)
        printf(" %.2f%s |", r->ratio[i], r->shared[i] ? ", shared" : "");
    printf("\n");
}

int main(void) {
    static const float pixels[MEDIA / 2] = {60.0f, 20.0f, 10.0f, 5.0f, 1.5f};
    static const float part[3] = {1.0f, 0.4f, 0.17f};
    static const float colours[3] = {0.93f, 0.42f, 0.14f}, grey[3] = {0.5f, 0.5f, 0.5f};
    static row rows[MEDIA];
    tracer_settings settings;
    float pixel = torus_begin(&world, SIDE, &settings, mask);

    for (int k = 0; k < MEDIA; k++) {
        row *r = &rows[k];
        float dmfp[3];
        r->is_grey = k < MEDIA / 2;
        r->dmfp_most = pixels[k % (MEDIA / 2)];
        r->dmfp_least = r->dmfp_most * (r->is_grey ? 1.0f : part[2]);
        for (int c = 0; c < 3; c++) dmfp[c] = r->dmfp_most * pixel * (r->is_grey ? 1.0f : part[c]);
        sss_burley(&world.s.medium, r->is_grey ? grey : colours, dmfp);
        fprintf(stderr, "medium %d of %d\n", k + 1, MEDIA);
        measure_row(r, settings, pixel);
    }

    printf("A mesh of %u triangles, %d samples a pixel, squared error over the default's in equal "
           "time, medians of %d runs:\n\n",
           world.m.triangles, 2 * SPP, RUNS);
    printf("| length in pixels | medium, dmfp in pixels |");
    for (int i = DEFAULT + 1; i < METHODS; i++) printf(" %s |", method_name[i]);
    printf("\n|---|---|---|---|---|---|\n");
    for (int k = 0; k < MEDIA; k++) print_row(&rows[k]);

    double least = 1.0, four_least = HUGE_VAL, four_most = 0.0;
    for (int k = 0; k < MEDIA; k++) {
        if (rows[k].most >= 1.0f) {
            four_least = fmin(four_least, rows[k].ratio[FOUR]);
            four_most = fmax(four_most, rows[k].ratio[FOUR]);
            continue;
        }
        for (int i = HINTED; i < METHODS; i++) least = fmin(least, rows[k].ratio[i]);
    }
    printf("\nWith a length of %.2g pixels a hint divides the squared error by %.2g, and the plan "
           "with a hint by %.2g.\n",
           (double)rows[0].most, 1.0 / rows[0].ratio[HINTED], 1.0 / rows[0].ratio[PLAN_HINTED]);
    printf("With a length of a pixel or more 4 candidates have from %.2f to %.2f of it.\n",
           four_least, four_most);
    printf("With lengths below one pixel hint and plan divide it by %.2g at most.\n", 1.0 / least);
    mesh_close(&world);
    return 0;
}
