// bench.c - what a candidate costs: the library alone, on a plane, against six exponentials of libm
// in the same run. SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "sss_resample.h"

#define BENCH_REPEATS 15
#define BENCH_FLOOR   0 // the first case is what the others are measured against

typedef struct bench_case {
    const char *name;
    unsigned techniques;
    int candidates;
} bench_case;
static const bench_case bench_cases[] = {
    {"six expf", 0, 0},
    {"default mix, M = 1", 0, 1},
    {"default mix, M = 8", 0, 8},
    {"default mix, M = 64", 0, 64},
    {"disk, M = 8", SSS_DISK, 8},
    {"disk on three axes, M = 8", SSS_DISK | SSS_DISK_TANGENTS, 8},
    {"sphere, M = 8", SSS_SPHERE, 8},
    {"chord, M = 8", SSS_CHORD, 8},
};
#define BENCH_CASES ((int)(sizeof bench_cases / sizeof bench_cases[0]))

static volatile float bench_sink;

static double bench_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// What a candidate cannot do without: three channels of a profile at two radii. ns for each.
static double bench_exponentials(int count) {
    static float radius[1024];
    float sum = 0.0f;
    for (int i = 0; i < 1024; i++) radius[i] = 0.003f * (float)i;
    double start = bench_seconds();
    for (int i = 0; i < count; i++) {
        float r = radius[i & 1023], q = radius[(7 * i) & 1023];
        sum += r * (expf(-r) + expf(-0.5f * r) + expf(-0.25f * r));
        sum += q * (expf(-q) + expf(-0.5f * q) + expf(-0.25f * q));
    }
    bench_sink = sum;
    return 1e9 * (bench_seconds() - start) / count;
}

// Whole lookups, a hit for each probe whose line meets the plane z = 0. ns for each candidate.
static double bench_candidates(const sss_medium *m, bench_case what, int count) {
    const sss_vec3 origin = {0.0f, 0.0f, 0.0f}, up = {0.0f, 0.0f, 1.0f};
    sss_plan plan = {what.candidates, 1, what.techniques, 0, 0, 0};
    int lookups = count / what.candidates;
    float sum = 0.0f;
    double start = bench_seconds();
    for (int i = 0; i < lookups; i++) {
        sss_resampler s;
        sss_probe probe;
        sss_exit exit;
        sss_begin(&s, m, &plan, origin, up, sss_hash(1u, (uint32_t)i));
        while (sss_next_probe(&s, &probe)) {
            float t = -probe.origin.z / probe.direction.z;
            sss_vec3 at = {probe.origin.x + t * probe.direction.x,
                           probe.origin.y + t * probe.direction.y, 0.0f};
            if (t == t) sss_add_hit(&s, at, up, 1.0f);
        }
        if (sss_finish(&s, &exit)) sum += exit.weight[0];
    }
    bench_sink = sum;
    return 1e9 * (bench_seconds() - start) / (lookups * what.candidates);
}

// A medium for each hit, as a texture gives it. ns for each.
static double bench_media(int which, int count) {
    const float dmfp[3] = {1.0f, 0.5f, 0.2f};
    float sum = 0.0f;
    double start = bench_seconds();

    for (int i = 0; i < count; i++) {
        float a = 1e-6f * (float)(i & 1023);
        const float albedo[3] = {0.5f + a, 0.7f + a, 0.3f + a};
        sss_medium m;

        if (which == 0) sss_burley(&m, albedo, dmfp);
        else if (which == 1) sss_dipole_from_albedo(&m, albedo, dmfp, 1.4f);
        else sss_better_dipole_from_albedo(&m, albedo, dmfp, 1.4f);
        for (int c = 0; c < 3; c++)
            sum += m.length[c] + m.zv[c] + m.extinction[c] + m.similarity[c];
        sum += m.r_max;
    }
    bench_sink = sum;
    return 1e9 * (bench_seconds() - start) / count;
}

// An exit for a tile of 8 x 8 entries, with one medium or with a medium each. ns for the tile.
static double bench_share(const sss_medium *m, int own_media, int count) {
    static sss_medium media[64];
    static float weight[64][3];
    sss_entry group[64];
    sss_exit exit = {{0.3f, 0.4f, 0.0f}, {0.0f, 0.0f, 1.0f}, {0.1f, 0.1f, 0.1f}, 0, 1.0f};
    float sum = 0.0f;

    for (int i = 0; i < 64; i++) {
        const sss_vec3 place = {0.05f * (float)(i % 8), 0.05f * (float)(i / 8), 0.0f};

        media[i] = *m;
        group[i].position = place;
        group[i].medium = own_media ? &media[i] : m;
    }
    double start = bench_seconds();
    for (int i = 0; i < count; i++) {
        exit.position.x = 0.3f + 1e-4f * (float)(i & 1023);
        sss_share(&exit, group, 64, 3, 0.01f, weight);
        sum += weight[5][1];
    }
    bench_sink = sum;
    return 1e9 * (bench_seconds() - start) / count;
}

static int bench_order(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The median of BENCH_REPEATS runs.
static double bench_median(double *time) {
    qsort(time, BENCH_REPEATS, sizeof(double), bench_order);
    return time[BENCH_REPEATS / 2];
}

static void bench_print_others(const sss_medium *medium) {
    static const char *const name[3] = {"a medium from albedo", "share: 64 entries, one medium",
                                        "share: 64 entries, 64 media"};

    for (int what = 0; what < 3; what++) {
        printf("%-30s", name[what]);
        for (int p = 0; p < 3; p++) {
            double time[BENCH_REPEATS];

            for (int k = 0; k < BENCH_REPEATS; k++)
                time[k] =
                    what == 0 ? bench_media(p, 20000) : bench_share(&medium[p], what - 1, 500);
            printf("%16.0f", bench_median(time));
        }
        printf("\n");
    }
}

int main(void) {
    static double time[BENCH_CASES][3][BENCH_REPEATS];
    static const char *const profile[3] = {"Burley", "dipole", "better dipole"};
    const float albedo[3] = {0.9f, 0.7f, 0.5f}, dmfp[3] = {1.0f, 0.5f, 0.2f};
    sss_medium medium[3];
    sss_burley(&medium[0], albedo, dmfp);
    sss_dipole_from_albedo(&medium[1], albedo, dmfp, 1.4f);
    sss_better_dipole_from_albedo(&medium[2], albedo, dmfp, 1.4f);
    for (int k = 0; k < BENCH_REPEATS; k++)
        for (int i = 0; i < BENCH_CASES; i++)
            for (int p = 0; p < 3; p++)
                time[i][p][k] = i == BENCH_FLOOR
                                    ? bench_exponentials(100000)
                                    : bench_candidates(&medium[p], bench_cases[i], 40000);
    printf("ns for each candidate, one core, median of %d (over six expf):\n%-28s", BENCH_REPEATS,
           "");
    for (int p = 0; p < 3; p++) printf("%18s", profile[p]);
    for (int i = 0; i < BENCH_CASES; i++) {
        printf("\n%-28s", bench_cases[i].name);
        for (int p = 0; p < 3; p++) {
            double ns = bench_median(time[i][p]);
            printf("%9.1f (%5.2f)", ns, ns / time[BENCH_FLOOR][p][BENCH_REPEATS / 2]);
        }
    }
    printf("\n\nbytes: sss_resampler %u, sss_medium %u, sss_exit %u, with SSS_LANES %d\n",
           (unsigned)sizeof(sss_resampler), (unsigned)sizeof(sss_medium),
           (unsigned)sizeof(sss_exit), SSS_LANES);
    printf("\nns:\n");
    bench_print_others(medium);
    return 0;
}
