// light - a light hint. Chapter 11 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/head.h"

// Change these and see what happens.
static const int few = 4, many = 24; // lookups for each pixel

enum { NONE, HINT, NO_SKY, WAYS, BLOCK = 4, FOR_ERROR = 128 };
static const char *const name[WAYS] = {"no hint", "light hint", "a hint of zero"};
static sss_medium wax;
static uint32_t lookups = 0;

// [hint]
// A guess of the irradiance without a shadow ray.
static double hint(vec n, int way) {
    double facing = greater(0, dot(n, unit(to_sun)));

    if (way == NONE) return 1;
    return sun * facing + (way == NO_SKY ? 0 : sky); // without the sky it is wrong: see below
}
// [/hint]

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }

// [lookup]
static vec exitance(hit entry, int way) {
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[MOST_HITS];

    sss_begin(&s, &wax, NULL, to_sss(entry.y), to_sss(entry.n), sss_hash(lookups++, 0));
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(o, dir, 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) {
            float light = (float)hint(hits[i].n, way);
            sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), light);
        }
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0};

    hit exit_point = {0, from_sss(e.position), from_sss(e.normal)};
    vec weight = {(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]};
    return scale(weight, irradiance(exit_point));
}
// [/lookup]

// The mean of a block of pixels.
static double block(int left, int top, int way) {
    double sum = 0;

    for (int i = 0; i < BLOCK * BLOCK; i++) {
        int x = left + i % BLOCK, y = top + i / BLOCK;
        vec seen = pixel(x, y, FOR_ERROR / BLOCK / BLOCK, exitance, way);
        sum += mean(seen) / (BLOCK * BLOCK);
    }
    return sum;
}
// What the wrong hint loses, over what is right.
static void draw_error(sheet *s, int panel) {
    for (int i = 0; i < SIDE * SIDE / (BLOCK * BLOCK); i++) {
        int x = i % (SIDE / BLOCK) * BLOCK, y = i / (SIDE / BLOCK) * BLOCK;
        uint64_t state = rnd_state;
        double right = block(x, y, HINT);
        rnd_state = state;
        double error = 2 * (block(x, y, NO_SKY) / right - 1);
        for (int k = 0; k < BLOCK * BLOCK; k++) {
            sheet_error(s, panel, x + k % BLOCK, y + k / BLOCK, error);
        }
    }
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);
    float a[3] = {(float)albedo[0], (float)albedo[1], (float)albedo[2]};
    float free_path[3] = {(float)dmfp[0], (float)dmfp[1], (float)dmfp[2]};
    sss_result result = sss_burley(&wax, a, free_path);

    if (result != SSS_OK) return fprintf(stderr, "wax: %s\n", sss_result_string(result)), 1;
    picture(&s, 0, "what it should be", many, exitance, HINT);
    picture(&s, 1, name[NONE], few, exitance, NONE);
    picture(&s, 2, name[HINT], few, exitance, HINT);
    sheet_title(&s, 3, "error of a hint of zero");
    draw_error(&s, 3);
    for (int way = 0; way < WAYS; way++) {
        spread m = measure(40000, exitance, way);
        printf("%s: relative variance %.3f, mean %.2f\n", name[way], m.variance, m.mean);
    }
    return sheet_end(&s);
}
