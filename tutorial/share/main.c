// share - exits that serve their neighbours. Chapter 13 of the tutorial.
// SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/head.h"

// Change these and see what happens.
static const int few = 4, many = 16; // lookups for each pixel

enum { TILE = 8, MOST = TILE * TILE };
static const double spacing = 0.36 * 7 / SIDE; // of the entries of neighbouring pixels
static sss_medium wax;
static uint32_t lookups = 0;

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }
static vec times(const float weight[3], double light) {
    return scale((vec){(double)weight[0], (double)weight[1], (double)weight[2]}, light);
}

static int lookup(hit entry, int per_channel, sss_exit exits[SSS_MAX_EXITS]) {
    sss_plan plan = {.per_channel = per_channel};
    sss_resampler s;
    sss_probe p;
    hit hits[MOST_HITS];

    sss_begin(&s, &wax, &plan, to_sss(entry.y), to_sss(entry.n), sss_hash(lookups++, 0));
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(o, dir, 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) {
            double hint = sun * greater(0, dot(hits[i].n, unit(to_sun))) + sky;
            sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), (float)hint);
        }
    }
    return sss_finish(&s, exits);
}

// [share]
// One lookup for each entry of a tile. Every exit is shaded once, and serves all entries.
static long share(const sss_entry *group, const hit *entry, int count, int per_channel, vec *sum) {
    sss_exit exits[SSS_MAX_EXITS];
    float weight[MOST][3];
    long shaded = 0;

    for (int own = 0; own < count; own++) {
        int found = lookup(entry[own], per_channel, exits);
        for (int k = 0; k < found; k++) {
            hit exit_point = {0, from_sss(exits[k].position), from_sss(exits[k].normal)};
            double light = irradiance(exit_point); // a shadow ray, once for each exit
            sss_share(&exits[k], group, count, own, (float)spacing, weight);
            for (int i = 0; i < count; i++) sum[i] = add(sum[i], times(weight[i], light));
        }
        shaded += found;
    }
    return shaded;
}
// [/share]

// [tile]
// One sample of all pixels of the tile at (left, top). Not shared, each entry is a group of one.
static long add_tile(vec *seen, int left, int top, int shared, int per_channel) {
    sss_entry group[MOST];
    hit entry[MOST];
    vec sum[MOST];
    int place[MOST], count = 0;
    long shaded = 0;

    for (int i = 0; i < MOST; i++) {
        int x = left + i % TILE, y = top + i / TILE;
        if (x < 0 || x >= SIDE || y < 0 || y >= SIDE) continue;
        double u = (x + rnd()) / SIDE, v = (y + rnd()) / SIDE;
        entry[count] = camera(u, v);
        if (entry[count].t < 0) seen[y * SIDE + x] = add(seen[y * SIDE + x], background);
        if (entry[count].t < 0) continue;
        group[count] = (sss_entry){to_sss(entry[count].y), &wax};
        sum[count] = (vec){0, 0, 0};
        place[count++] = y * SIDE + x;
    }
    if (shared) shaded = share(group, entry, count, per_channel, sum);
    for (int i = 0; i < count; i++) {
        if (!shared) shaded += share(&group[i], &entry[i], 1, per_channel, &sum[i]);
        seen[place[i]] = add(seen[place[i]], scale(sum[i], 1 / pi));
    }
    return shaded;
}
// [/tile]

// The whole picture, once more; tiles lie elsewhere in every pass. Returns how often it shaded.
static long add_pass(vec *seen, int shared, int per_channel) {
    int dx = (int)(TILE * rnd()), dy = (int)(TILE * rnd());
    long shaded = 0;

    for (int top = -dy; top < SIDE; top += TILE) {
        for (int left = -dx; left < SIDE; left += TILE) {
            shaded += add_tile(seen, left, top, shared, per_channel);
        }
    }
    return shaded;
}

static void draw(sheet *s, int panel, const char *title, int passes, int shared, int per_channel) {
    static vec half[2][SIDE * SIDE]; // two pictures with half of the passes each
    double error = 0, power = 0, total = 0, shaded = 0;

    memset(half, 0, sizeof half);
    for (int k = 0; k < passes; k++) shaded += (double)add_pass(half[k % 2], shared, per_channel);
    if (panel >= 0) sheet_title(s, panel, title);
    for (int i = 0; i < SIDE * SIDE; i++) {
        vec a = scale(half[0][i], 2.0 / passes), b = scale(half[1][i], 2.0 / passes);
        vec seen = scale(add(a, b), 0.5), off = sub(a, b);
        if (panel >= 0) sheet_pixel(s, panel, i % SIDE, i / SIDE, seen);
        if (length(off) <= 0) continue; // the background
        error += dot(off, off) / 2 * passes / 2;
        power += dot(a, b);
        total += mean(seen);
    }
    printf("%s: relative variance %.3f, mean %.3f, exits a lookup %.2f\n", title, error / power,
           total / (SIDE * SIDE), shaded / lookups);
    lookups = 0;
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);
    float a[3] = {(float)albedo[0], (float)albedo[1], (float)albedo[2]};
    float free_path[3] = {(float)dmfp[0], (float)dmfp[1], (float)dmfp[2]};
    sss_result result = sss_burley(&wax, a, free_path);

    if (result != SSS_OK) return fprintf(stderr, "wax: %s\n", sss_result_string(result)), 1;
    draw(&s, 0, "what it should be", many, 1, 1);
    draw(&s, 1, "own exit", few, 0, 0);
    draw(&s, 2, "own, for each colour", few, 0, 1);
    draw(&s, 3, "shared, for each colour", few, 1, 1);
    draw(&s, -1, "shared", few, 1, 0);
    return sheet_end(&s);
}
