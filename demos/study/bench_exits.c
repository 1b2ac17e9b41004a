// bench_exits.c - lookups a second on one core, on all, and on an OpenCL device, the same work in
// the same run: bench_exits [DEVICE] [LOCAL SIZE]. SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "demos/common/entries.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer_cl.h"

enum { ENTRIES = 1 << 16, ROUNDS = 7 };

typedef struct batch {
    sss_vec3 position[ENTRIES], normal[ENTRIES];
    uint32_t seed[ENTRIES];
    int count[ENTRIES];
    sss_exit exit[ENTRIES];
} batch;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void make_entries(const scene *s, batch *b) {
    static camera_entry entry[ENTRIES];
    camera_entries(s, 11u, entry, ENTRIES);
    for (int i = 0; i < ENTRIES; i++) {
        b->position[i] = entry[i].position;
        b->normal[i] = entry[i].normal;
        b->seed[i] = sss_hash(2u, (uint32_t)i);
    }
}

static void exits_on_cpu(const scene *s, tracer_settings settings, int threads, int entries,
                         batch *b) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (int i = 0; i < entries; i++) {
        sss_exit own[SSS_MAX_EXITS];
        uint32_t probes = 0;
        b->count[i] =
            tracer_exits(s, settings, b->position[i], b->normal[i], b->seed[i], own, &probes);
        if (b->count[i] > 0) b->exit[i] = own[0];
    }
}

static void exits_on_device(tracer_cl *t, const scene *s, tracer_settings settings, batch *b) {
    const sss_cl_batch all = {ENTRIES, 1, b->position, b->normal, b->seed, b->count, b->exit};
    if (tracer_cl_lookups(t, s, settings, &all) == SSS_CL_OK) return;
    fprintf(stderr, "bench_exits: %s\n", t->cl.error);
    exit(1);
}

static void keep_least(double *least, double seconds) {
    if (seconds < *least) *least = seconds;
}

// The least and the most speed of the device over that of all cores, over the scenes.
typedef struct range {
    double least, most;
} range;

// The best of several rounds of each, in turns, so that other work on the machine troubles both
// alike. Returns how many seconds the first launch took.
static double measure(tracer_cl *t, int which, int candidates, range *r) {
    static batch cpu, device;
    double best[3] = {1e30, 1e30, 1e30}, first = 0.0;
    scene s;
    tracer_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.method = TRACER_RESAMPLED;
    settings.plan.candidates = candidates;
    scenes_optics optics = scenes_make(&s, which);
    if (sss_burley(&s.medium, optics.albedo, optics.dmfp) != SSS_OK) exit(1);
    make_entries(&s, &cpu);
    device = cpu;
    for (int round = 0; round < ROUNDS; round++) {
        double start = now();
        exits_on_cpu(&s, settings, 1, ENTRIES / 4, &cpu);
        keep_least(&best[0], 4.0 * (now() - start));
        start = now();
        exits_on_cpu(&s, settings, omp_get_num_procs(), ENTRIES, &cpu);
        keep_least(&best[1], now() - start);
        start = now();
        exits_on_device(t, &s, settings, &device);
        if (round == 0) first = now() - start;
        keep_least(&best[2], now() - start);
    }
    r->least = fmin(r->least, best[1] / best[2]);
    r->most = fmax(r->most, best[1] / best[2]);
    printf("%-8s M = %2d: one core %5.0f, all %5.0f, device %5.0f thousand lookups a second; "
           "device over all %.2f, bits %s\n",
           scenes_known[which].name, candidates, 1e-3 * ENTRIES / best[0], 1e-3 * ENTRIES / best[1],
           1e-3 * ENTRIES / best[2], best[1] / best[2],
           memcmp(&cpu, &device, sizeof cpu) == 0 ? "equal" : "DIFFER");
    return first;
}

int main(int count, char **words) {
    tracer_cl t;
    double start = now();
    sss_cl_result result = tracer_cl_open(&t, count > 1 ? words[1] : "opencl", NULL);
    if (result != SSS_CL_OK) {
        fprintf(stderr, "%sbench_exits: %s\n", t.cl.log ? t.cl.log : "", t.cl.error);
        tracer_cl_close(&t);
        return (int)result;
    }
    if (count > 2 && atoi(words[2]) > 0) t.cl.local = (size_t)atoi(words[2]);
    printf("%s: kernels built in %.2f s\n", t.cl.device.name, now() - start);
    range one = {1e30, 0.0}, eight = {1e30, 0.0};
    for (int i = 0; i < SCENES; i++) {
        double first = measure(&t, i, 1, &one);
        if (i == 0) printf("(the very first launch took %.2f s)\n", first);
        measure(&t, i, 8, &eight);
    }
    printf("Device over all cores: M = 1 from %.2f to %.2f; M = 8 from %.2f to %.2f.\n", one.least,
           one.most, eight.least, eight.most);
    tracer_cl_close(&t);
    return 0;
}
