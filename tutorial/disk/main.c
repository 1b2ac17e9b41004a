// disk - a disk probe and its Jacobian. Chapter 4 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const vec albedo = {0.8, 0.5, 0.35};
static const vec dmfp = {2, 0.35, 0.15};
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int samples = 16; // for each pixel

static const double radius = 1;
static const vec eye = {0, 0, 7};
enum { SIDE = 240 };
enum { AREA, DISK, NO_JACOBIAN, FIRST_HIT, PER_HIT, WAYS }; // ways to estimate, of which the first two are right
static const char *const way_name[WAYS] = {"points on the area", "disk probes", "without the Jacobian",
                                           "first hit only", "divided by hits"};

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
static double irradiance(vec n) { return sun * greater(0, dot(n, unit(to_sun))) + sky; }

// [hits]
// Where a line of unit direction meets the ball: 0 or 2 distances, which may be negative.
static int ball(vec o, vec d, double t[2]) {
    double b = dot(o, d), c = dot(o, o) - radius * radius;
    if (b * b <= c) return 0;
    t[0] = -b - sqrt(b * b - c);
    t[1] = -b + sqrt(b * b - c);
    return 2;
}
// [/hits]

// [radius]
// A distance with the density 2 pi r P(r): an exponential of mean d with the chance 1/4, of mean 3 d with 3/4.
static double disk_radius(double d) {
    double scale_of = rnd() < 0.25 ? d : 3 * d;
    return -scale_of * log(rnd());
}
// [/radius]

// [probe]
// An estimate of the integral of Rd E over the ball; lit = 0 stands for a light of 1 from everywhere.
static vec disk_probe(vec x, vec n, int way, int lit) {
    double d = colour_lengths().x, r = disk_radius(d), turn = 2 * pi * rnd(), t[2];
    vec tangent, bitangent, sum = {0, 0, 0};
    frame(n, &tangent, &bitangent);
    vec o = along(along(x, tangent, r * cos(turn)), bitangent, r * sin(turn));
    int hits = ball(o, n, t);
    for (int i = 0; i < hits; i++) {
        vec y = along(o, n, t[i]), normal = unit(y);
        double density = burley(1, d, r) * fabs(dot(normal, n));
        if (way == NO_JACOBIAN) density = burley(1, d, r);
        if (way == FIRST_HIT && i != hits - 1) continue; // the probe comes from above: the last one along n
        vec f = scale(profile(length(sub(y, x))), lit ? irradiance(normal) : 1);
        sum = add(sum, scale(f, 1 / density));
    }
    return way == PER_HIT && hits ? scale(sum, 1.0 / hits) : sum;
}
// [/probe]

static vec area_point(vec x, int lit) {
    vec n = rnd_on_unit_sphere(), y = scale(n, radius);
    return scale(profile(length(sub(y, x))), (lit ? irradiance(n) : 1) * 4 * pi * radius * radius);
}
static vec exitance(vec x, int way, int lit) {
    return way == AREA ? area_point(x, lit) : disk_probe(x, unit(x), way, lit);
}

static vec pixel(int px, int py, int way) {
    vec sum = {0, 0, 0};
    for (int i = 0; i < samples; i++) {
        double u = (px + rnd()) / SIDE - 0.5, v = 0.5 - (py + rnd()) / SIDE, t[2];
        vec d = unit((vec){0.36 * u, 0.36 * v, -1});
        int hits = ball(eye, d, t);
        sum = add(sum, hits ? scale(exitance(along(eye, d, t[0]), way, 1), 1 / pi) : background);
    }
    return scale(sum, 1.0 / samples);
}

// The estimate under light of 1 from everywhere over the exact sum: 1 if all is well.
static void print_energy(int way) {
    double sum = 0, n = 500000, exact = burley_within(albedo.x, colour_lengths().x, 2 * radius);
    for (int i = 0; i < n; i++) sum += exitance((vec){0, radius, 0}, way, 0).x;
    printf("energy, %s: %.2f\n", way_name[way], sum / n / exact);
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 3, SIDE, SIDE);
    for (int way = AREA; way <= NO_JACOBIAN; way++) {
        sheet_text(&s, way, 0, -9, "%s", way_name[way]);
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) sheet_pixel(&s, way, x, y, pixel(x, y, way));
    }
    for (int way = 0; way < WAYS; way++) print_energy(way);
    return sheet_end(&s);
}
