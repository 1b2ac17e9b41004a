// area - the truth, slowly: points all over the ball. Chapter 3 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const vec albedo = {0.8, 0.5, 0.35};
static const vec dmfp = {2, 0.35, 0.15};
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int few = 16, many = 512; // points for each pixel

static const double radius = 1;
static const vec eye = {0, 0, 7};
enum { SIDE = 240 };

static double burley_length(double a, double free_path) { return free_path / (3.5 + 100 * pow(a - 0.33, 4)); }
static double burley(double a, double d, double r) { return a * (exp(-r / d) + exp(-r / (3 * d))) / (8 * pi * d * r); }
static double burley_within(double a, double d, double r) {
    return a * (1 - exp(-r / d) / 4 - exp(-r / (3 * d)) * 3 / 4);
}
static vec colour_lengths(void) {
    return (vec){burley_length(albedo.x, dmfp.x), burley_length(albedo.y, dmfp.y), burley_length(albedo.z, dmfp.z)};
}
static vec profile(double r) {
    vec d = colour_lengths();
    return (vec){burley(albedo.x, d.x, r), burley(albedo.y, d.y, r), burley(albedo.z, d.z, r)};
}

static double ball(vec o, vec d) {
    double b = dot(o, d), c = dot(o, o) - radius * radius;
    return b * b > c ? -b - sqrt(b * b - c) : -1;
}
static double irradiance(vec n) { return sun * greater(0, dot(n, unit(to_sun))) + sky; }

// [estimate]
// One point y, uniform on the ball: its density over area is 1 / (4 pi R^2). Returns an estimate of the radiant
// exitance at x, the integral of Rd(|y - x|) E(y) over the surface.
static vec exitance(vec x) {
    vec n = rnd_on_unit_sphere(), y = scale(n, radius);
    double density = 1 / (4 * pi * radius * radius);
    return scale(profile(length(sub(y, x))), irradiance(n) / density);
}
// [/estimate]

static vec pixel(int px, int py, int points, int scatter) {
    vec sum = {0, 0, 0};
    for (int i = 0; i < points; i++) {
        double u = (px + rnd()) / SIDE - 0.5, v = 0.5 - (py + rnd()) / SIDE;
        vec d = unit((vec){0.36 * u, 0.36 * v, -1}), x;
        double t = ball(eye, d);
        if (t > 0) x = along(eye, d, t);
        if (t <= 0) sum = add(sum, background);
        else if (scatter) sum = add(sum, scale(exitance(x), 1 / pi));
        else sum = add(sum, scale(albedo, irradiance(unit(x)) / pi));
    }
    return scale(sum, 1.0 / points);
}

// [energy]
// Light of irradiance 1 from everywhere: the exitance is then the integral of Rd alone, and on a ball it is known. The
// points of a ball within a distance r of x have the area pi r^2, as on the plane, only that r ends at 2 R.
static void check_energy(void) {
    double sum = 0, n = 1000000, d = colour_lengths().x;
    for (int i = 0; i < n; i++) {
        vec y = scale(rnd_on_unit_sphere(), radius), x = {0, 0, radius};
        sum += burley(albedo.x, d, length(sub(y, x))) * 4 * pi * radius * radius;
    }
    printf("red exitance under light of 1 from everywhere: %.3f\n", sum / n);
    printf("the exact sum: %.3f\n", burley_within(albedo.x, d, 2 * radius));
}
// [/energy]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 3, SIDE, SIDE);
    for (int panel = 0; panel < 3; panel++) {
        int points = panel == 2 ? many : few;
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) sheet_pixel(&s, panel, x, y, pixel(x, y, points, panel > 0));
    }
    sheet_text(&s, 0, 0, -9, "Lambert");
    sheet_text(&s, 1, 0, -9, "%d points a pixel", few);
    sheet_text(&s, 2, 0, -9, "%d points", many);
    check_energy();
    return sheet_end(&s);
}
