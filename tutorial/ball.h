// ball.h - a ball of wax in the sun, for chapters 3 and 4. SPDX-License-Identifier: MIT
#ifndef BALL_H
#define BALL_H

#include "tutorial/wax.h"

// Change these and see what happens.
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;

static const double radius = 1; // of the ball about the origin
static const vec eye = {0, 0, 7};

// [hits]
// Where a line of unit direction meets the ball: 0 or 2 distances, which may be negative.
static inline int ball(vec o, vec dir, double t[2]) {
    double b = dot(o, dir), c = dot(o, o) - radius * radius;

    if (b * b <= c) return 0;
    t[0] = -b - sqrt(b * b - c);
    t[1] = -b + sqrt(b * b - c);
    return 2;
}
// [/hits]

static inline double irradiance(vec n) { return sun * greater(0, dot(n, unit(to_sun))) + sky; }

// [exact]
// The integral over the ball, in rings about x. A ring at the straight distance r from x has the
// area 2 pi r dr, as on a plane. `cosine` is that of the angle between the normal at x and the sun.
static inline vec ring_sum(double cosine) {
    enum { RINGS = 200, PARTS = 48 };
    double sine = sqrt(greater(0, 1 - cosine * cosine));
    vec sum = {0, 0, 0};

    for (int i = 0; i < RINGS; i++) { // r = 2 R u^2: finer where the profile is large
        double u = (i + 0.5) / RINGS, r = 2 * radius * u * u, dr = 4 * radius * u / RINGS;
        double up = 1 - r * r / (2 * radius * radius), out = sqrt(greater(0, 1 - up * up));
        double light = 0;
        for (int k = 0; k < PARTS; k++) {
            double facing = up * cosine + out * sine * cos(2 * pi * (k + 0.5) / PARTS);
            light += (sun * greater(0, facing) + sky) / PARTS;
        }
        sum = add(sum, scale(profile(r), light * 2 * pi * r * dr));
    }
    return sum;
}
// [/exact]

// The same from a table.
static inline vec exact(vec x) {
    enum { STEPS = 200 };
    static vec table[STEPS + 2];
    static int ready = 0;

    for (int i = 0; i <= STEPS && !ready; i++) table[i] = ring_sum(-cos(pi * i / STEPS));
    ready = 1;
    double cosine = dot(x, unit(to_sun)) / radius;
    double at = (pi - acos(cosine < -1 ? -1 : cosine > 1 ? 1 : cosine)) / pi * STEPS;
    int i = (int)at;
    return add(scale(table[i], 1 - (at - i)), scale(table[i + 1], at - i));
}

// A pixel of a square picture of the ball: the mean over a few rays, and over the estimates of
// exitance(x, way), over pi.
typedef vec exitance_of(vec x, int way);
static inline vec pixel(int px, int py, int side, int samples, exitance_of *exitance, int way) {
    vec sum = {0, 0, 0};

    for (int i = 0; i < samples; i++) {
        double u = (px + rnd()) / side - 0.5, v = 0.5 - (py + rnd()) / side, t[2];
        vec dir = unit((vec){0.36 * u, 0.36 * v, -1});
        int hits = ball(eye, dir, t);
        vec seen = background;
        if (hits) seen = scale(exitance(along(eye, dir, t[0]), way), 1 / pi);
        sum = add(sum, seen);
    }
    return scale(sum, 1.0 / samples);
}

#endif
