// header - the header takes over. Chapter 10 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/head.h"

// Change these and see what happens.
static const int work = 800000; // probes for each point of the plot
static const int lit = 0;       // 1: the light of the head; 0: an irradiance of 1 everywhere

enum { WIDTH = 520, HEIGHT = 340, MOST = 64 };
enum { INDEPENDENT, STRATIFIED, WAYS };
static sss_medium wax;
static sss_plan plan = {0};
static uint32_t lookups = 0; // so far: no two lookups have the same seed

// [vectors]
static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }
// [/vectors]

// [medium]
static void make_wax(void) {
    float a[3] = {(float)albedo[0], (float)albedo[1], (float)albedo[2]};
    float free_path[3] = {(float)dmfp[0], (float)dmfp[1], (float)dmfp[2]};
    sss_result result = sss_burley(&wax, a, free_path);

    if (result != SSS_OK) fprintf(stderr, "wax: %s\n", sss_result_string(result)), exit(1);
}
// [/medium]

// [lookup]
static vec exitance(hit entry, int way) {
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[MOST_HITS];

    plan.independent = way == INDEPENDENT;
    sss_begin(&s, &wax, &plan, to_sss(entry.y), to_sss(entry.n), sss_hash(lookups++, 0));
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(o, dir, 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), 1);
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0}; // a fair sample too: never try again

    hit exit_point = {0, from_sss(e.position), from_sss(e.normal)};
    vec weight = {(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]};
    return scale(weight, lit ? irradiance(exit_point) : 1);
}
// [/lookup]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const char *const name[WAYS] = {"independent", "stratified"};
    const vec paint[WAYS] = {blue, orange};
    plot p = {&s, 0, 1, 1, 1, MOST, 0.01, 1};

    make_wax();
    sheet_title(&s, 0, "relative variance over M");
    plot_grid(p, 2, 10);
    for (int way = 0; way < WAYS; way++) {
        double before = 0;
        plot_name(p, way, paint[way], name[way]);
        for (int m = 1; m <= MOST; m *= 2) {
            int points = work / m < 40000 ? work / m : 40000;
            plan.candidates = m;
            spread v = measure(points, exitance, way);
            plot_point(p, m, v.variance, 5, paint[way]);
            if (m > 1) plot_line(p, m / 2, before, m, v.variance, paint[way]);
            before = v.variance;
            printf("%s, M = %d: relative variance %.3f, mean %.2f\n", name[way], m, v.variance,
                   v.mean);
        }
    }
    return sheet_end(&s);
}
