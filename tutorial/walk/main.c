// walk - a walk through the volume. Chapter 14 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/head.h"

// Change these and see what happens.
static const vec sun_behind = {-0.6, 0.35, -0.7};
static const int few = 4, many[] = {32, 128}; // lookups for each pixel, of profile and walk
static const int light_hint = 1;      // 0: no hints
static const double exposure = 2.5;   // the camera sees the dark side

enum { PROFILE, WALK, WAYS, BLOCK = 4 };
static sss_medium wax;
static uint32_t lookups = 0;
static long traced = 0; // segments

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }

// [plans]
static const sss_plan plan[WAYS] = {
    {.candidates = 8},                          // the profile, by the default mix
    {.candidates = 2, .techniques = SSS_WALK}}; // two walks, of which one is picked
// [/plans]

// [lookup]
static vec exitance(hit entry, int way) {
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[MOST_HITS];

    uint32_t seed = sss_hash(lookups / 32, 0), sample = lookups % 32; // strata of one another

    sss_begin_sample(&s, &wax, &plan[way], to_sss(entry.y), to_sss(entry.n), seed, sample);
    lookups++;
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(o, dir, 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) {
            double hint = sun * greater(0, dot(hits[i].n, unit(to_sun))) + sky;
            sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), light_hint ? (float)hint : 1);
        }
        traced++;
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0};

    hit exit_point = {0, from_sss(e.position), from_sss(e.normal)};
    vec weight = {(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]};
    return scale(weight, irradiance(exit_point));
}
// [/lookup]

// Draws into seen; returns the mean radiance of the head.
static vec picture_mean(int way, int samples, vec *seen) {
    vec sum = {0, 0, 0};
    int inside = 0; // pixels of the head

    for (int i = 0; i < SIDE * SIDE; i++) {
        seen[i] = pixel(i % SIDE, i / SIDE, samples, exitance, way);
        if (camera((i % SIDE + 0.5) / SIDE, (i / SIDE + 0.5) / SIDE).t < 0) continue;
        sum = add(sum, seen[i]);
        inside++;
    }
    return scale(sum, 1.0 / inside);
}
static void show(sheet *s, int panel, const char *title, const vec *seen) {
    sheet_title(s, panel, title);
    for (int i = 0; i < SIDE * SIDE; i++) {
        sheet_pixel(s, panel, i % SIDE, i / SIDE, scale(seen[i], exposure));
    }
}
// The profile's error, in blocks of pixels: full colour where it is off by 50 %.
static void show_error(sheet *s, int panel, const vec *seen, const vec *right) {
    for (int i = 0; i < SIDE * SIDE; i++) {
        int x = i % SIDE / BLOCK * BLOCK, y = i / SIDE / BLOCK * BLOCK;
        double a = 0, b = 0;
        for (int k = 0; k < BLOCK * BLOCK; k++) {
            int at = (y + k / BLOCK) * SIDE + x + k % BLOCK;
            a += mean(seen[at]);
            b += mean(right[at]);
        }
        sheet_error(s, panel, i % SIDE, i / SIDE, 2 * (a / b - 1));
    }
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);
    static vec by[WAYS][SIDE * SIDE], noisy[SIDE * SIDE];
    static const char *const name[WAYS] = {"flat profile", "walk"};
    float a[3] = {(float)albedo[0], (float)albedo[1], (float)albedo[2]};
    float free_path[3] = {(float)dmfp[0], (float)dmfp[1], (float)dmfp[2]};
    sss_result result = sss_burley(&wax, a, free_path);

    if (result != SSS_OK) return fprintf(stderr, "wax: %s\n", sss_result_string(result)), 1;
    to_sun = sun_behind;
    for (int way = 0; way < WAYS; way++) {
        traced = lookups = 0;
        vec m = picture_mean(way, many[way], by[way]);
        printf("%s: mean red %.3f, green %.3f, blue %.3f, segments a lookup %.1f\n", name[way], m.x,
               m.y, m.z, (double)traced / lookups);
        show(&s, way, name[way], by[way]);
    }
    picture_mean(WALK, few, noisy);
    char title[64];
    snprintf(title, sizeof title, "walk, %d lookups a pixel", few);
    show(&s, 2, title, noisy);
    sheet_title(&s, 3, "error of the profile");
    show_error(&s, 3, by[PROFILE], by[WALK]);
    for (int way = 0; way < WAYS; way++) {
        spread m = measure(20000, exitance, way);
        printf("%s, one lookup: relative variance %.2f\n", name[way], m.variance);
    }
    return sheet_end(&s);
}
