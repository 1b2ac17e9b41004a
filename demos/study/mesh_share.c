// mesh_share.c - what sharing exits brings on a mesh, where rays take nearly all of the time: noise
// and time of one core against the default plan, over media from narrower than a pixel to much
// wider. SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "mesh_share"
#include "demos/common/command.h"
#include "demos/study/torus.h"

enum { SIDE = 128, SPP = 8, METHODS = 5, MEDIA = 10 };
static const char *const method_name[METHODS] = {"default", "hinted", "plan", "plan, hinted",
                                                 "4 candidates"};

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

// The default, and what the plan says, both without and with a light hint; last half of the
// default's candidates.
static void set_method(tracer_settings *settings, int method, float footprint) {
    memset(&settings->plan, 0, sizeof settings->plan);
    settings->light_aware = method % 2;
    if (method == 4) settings->plan.candidates = 4;
    if (method < 2 || method == 4) return;

    sss_plan advice = tracer_sharing(&world.s.medium, footprint, settings->light_aware);
    settings->plan.tile = advice.tile;
    settings->plan.candidates = advice.candidates;
    settings->plan.per_channel = advice.per_channel;
}

int main(void) {
    static const float pixels[MEDIA / 2] = {60.0f, 20.0f, 10.0f, 5.0f, 1.5f},
                                      part[3] = {1.0f, 0.4f, 0.17f};
    static const float colours[3] = {0.93f, 0.42f, 0.14f}, grey[3] = {0.5f, 0.5f, 0.5f};
    tracer_settings settings;
    float pixel = torus_begin(&world, SIDE, &settings, mask);

    printf("%u triangles, %d samples a pixel; error over the default's in equal time\n",
           world.m.triangles, 2 * SPP);
    for (int k = 0; k < MEDIA; k++) {
        int is_grey = k < MEDIA / 2;
        float dmfp[3];
        double error[METHODS], seconds[METHODS];
        for (int c = 0; c < 3; c++)
            dmfp[c] = pixels[k % (MEDIA / 2)] * pixel * (is_grey ? 1.0f : part[c]);
        sss_burley(&world.s.medium, is_grey ? grey : colours, dmfp);
        const float *d = world.s.medium.length;
        printf("%s, dmfp up to %4.1f pixels, length %5.2f %5.2f %5.2f:",
               is_grey ? "grey  " : "colour", (double)pixels[k % (MEDIA / 2)],
               (double)(d[0] / pixel), (double)(d[1] / pixel), (double)(d[2] / pixel));
        for (int i = 0; i < METHODS; i++) {
            set_method(&settings, i, pixel);
            error[i] = measure(settings, &seconds[i]);
            printf("\n    %-12s %d of %d x %d: %.5f in %.2f s (%.3f)", method_name[i],
                   settings.plan.candidates ? settings.plan.candidates : 8, settings.plan.tile,
                   settings.plan.tile, error[i], seconds[i],
                   error[i] * seconds[i] / (error[0] * seconds[0]));
        }
        printf("\n");
        fflush(stdout);
    }
    mesh_close(&world);
    return 0;
}
