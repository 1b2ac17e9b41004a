// head.h - the head of wax that chapter 5 builds, its camera and its light, for the chapters from
// there on. SPDX-License-Identifier: MIT
#ifndef HEAD_H
#define HEAD_H

#include "tutorial/wax.h"

// Change these and see what happens.
static vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
enum { SIDE = 240 }; // pixels of a picture

// [head]
// A head, two ears and a muzzle: the surface is that of all the balls together.
static const struct {
    vec centre;
    double radius;
} ball[] = {{{0, -0.15, 0}, 0.85},
            {{-0.64, 0.55, 0}, 0.36},
            {{0.64, 0.55, 0}, 0.36},
            {{0, -0.35, 0.68}, 0.34}};
enum { BALLS = sizeof ball / sizeof *ball, MOST_HITS = 2 * BALLS };
// [/head]
static const vec eye = {0, 0, 7};

static inline int inside_another(vec y, int own) {
    for (int i = 0; i < BALLS; i++) {
        if (i != own && length(sub(y, ball[i].centre)) < ball[i].radius) return 1;
    }
    return 0;
}
// [crossings]
// All points where the line o + t dir, t within t0..t1, crosses the surface: those of each ball
// that no other ball contains.
static inline int all_hits(vec o, vec dir, double t0, double t1, hit *hits) {
    int count = 0;

    for (int i = 0; i < 2 * BALLS; i++) {
        vec from = sub(o, ball[i / 2].centre);
        double r = ball[i / 2].radius, b = dot(from, dir);
        double rest = b * b - dot(from, from) + r * r;
        if (rest <= 0) continue;

        double t = -b + (i % 2 ? sqrt(rest) : -sqrt(rest));
        vec y = along(o, dir, t);
        if (t < t0 || t > t1 || inside_another(y, i / 2)) continue;
        hits[count++] = (hit){t, y, scale(sub(y, ball[i / 2].centre), 1 / r)};
    }
    return count;
}
// [/crossings]

// The first hit in front of o; t < 0 if there is none.
static inline hit first_hit(vec o, vec dir) {
    hit hits[MOST_HITS], best = {-1, {0, 0, 0}, {0, 0, 0}};
    int count = all_hits(o, dir, 1e-4, far_away, hits);

    for (int i = 0; i < count; i++) {
        if (best.t < 0 || hits[i].t < best.t) best = hits[i];
    }
    return best;
}
// What the camera sees at (u, v), both in 0..1 from the top left.
static inline hit camera(double u, double v) {
    return first_hit(eye, unit((vec){0.36 * (u - 0.5), 0.36 * (0.5 - v), -1}));
}
static inline double irradiance(hit h) {
    double facing = dot(h.n, unit(to_sun));

    if (facing <= 0 || first_hit(h.y, unit(to_sun)).t > 0) return sky;
    return sun * facing + sky;
}

// A chapter's estimate of the exitance at an entry, by one of the ways that it compares.
typedef vec exitance_of(hit entry, int way);

// The radiance of a pixel: the mean over some samples.
static inline vec pixel(int px, int py, int samples, exitance_of *exitance, int way) {
    vec sum = {0, 0, 0};

    for (int k = 0; k < samples; k++) {
        double u = (px + rnd()) / SIDE, v = (py + rnd()) / SIDE;
        hit entry = camera(u, v);
        vec seen = entry.t > 0 ? scale(exitance(entry, way), 1 / pi) : background;
        sum = add(sum, scale(seen, 1.0 / samples));
    }
    return sum;
}
static inline void picture(sheet *s, int panel, const char *title, int samples,
                           exitance_of *exitance, int way) {
    sheet_title(s, panel, title);
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x < SIDE; x++) {
            sheet_pixel(s, panel, x, y, pixel(x, y, samples, exitance, way));
        }
    }
}

// The relative variance of one estimate, from two of them at each of many points that the camera
// sees; and their mean. The points are the same for every way.
typedef struct spread {
    double variance, mean;
} spread;

static inline spread measure(int points, exitance_of *exitance, int way) {
    double squares = 0, products = 0, sum = 0, count = 0;

    rnd_state = 1;
    for (int i = 0; i < points; i++) {
        double u = rnd(), v = rnd();
        hit entry = camera(u, v);
        if (entry.t < 0) continue;

        double a = mean(exitance(entry, way)), b = mean(exitance(entry, way));
        squares += (a - b) * (a - b) / 2;
        products += a * b;
        sum += a + b;
        count += 2;
    }
    return (spread){squares / products, sum / count};
}

#endif
