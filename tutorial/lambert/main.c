// lambert - a ball that scatters light where the light hits. Chapter 1 of the tutorial.
// SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const vec albedo = {0.8, 0.5, 0.35}; // the share that comes back: red, green, blue
static const vec to_sun = {-0.8, 0.5, 0.2}; // where the sun is; the camera looks along -z
static const double sun = 5, sky = 0.4;     // irradiance: of the sun head-on; of the sky
static const int samples = 16;              // for each pixel

static const double radius = 1; // of the ball about the origin
static const vec eye = {0, 0, 7};
enum { SIDE = 360 }; // pixels

// [hit]
// The distance to the ball along a ray of unit direction, or -1. |o + t dir|^2 = radius^2 is a
// quadratic equation in t.
static double ball(vec o, vec dir) {
    double b = dot(o, dir), c = dot(o, o) - radius * radius;

    return b * b > c ? -b - sqrt(b * b - c) : -1;
}
// [/hit]

// [light]
// Irradiance: the power per area that arrives at a point with normal n. The ball is convex, so it
// shades itself only where n turns away from the sun.
static double irradiance(vec n) { return sun * greater(0, dot(n, unit(to_sun))) + sky; }
// [/light]

// [shade]
// The radiance that leaves the surface at x.
static vec radiance(vec x) {
    vec n = scale(x, 1 / radius);

    return scale(albedo, irradiance(n) / pi);
}
// [/shade]

// [camera]
static vec pixel(int px, int py) {
    vec sum = {0, 0, 0};

    for (int i = 0; i < samples; i++) {
        double u = (px + rnd()) / SIDE - 0.5, v = 0.5 - (py + rnd()) / SIDE;
        vec dir = unit((vec){0.36 * u, 0.36 * v, -1});
        double t = ball(eye, dir);
        sum = add(sum, t > 0 ? radiance(along(eye, dir, t)) : background);
    }
    return scale(sum, 1.0 / samples);
}
// [/camera]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, SIDE, SIDE);
    vec bright = radiance(unit(to_sun)), dark = radiance(unit(scale(to_sun, -1)));

    sheet_title(&s, 0, "Lambert");
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x < SIDE; x++) sheet_pixel(&s, 0, x, y, pixel(x, y));
    }
    printf("red radiance where the ball faces the sun: %.3f\n", bright.x);
    printf("red radiance where it faces away: %.3f\n", dark.x);
    return sheet_end(&s);
}
