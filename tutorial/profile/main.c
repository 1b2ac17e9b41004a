// profile - light that leaves elsewhere: the spot of a laser. Chapter 2 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const vec albedo = {0.8, 0.5, 0.35}; // the share of light that comes back at all
static const vec dmfp = {2, 0.35, 0.15};    // how far it comes: diffuse mean free path, in scene units
static const double laser = 1.2;            // its power
static const double view = 2;               // width of the left panel, in scene units

enum { SIDE = 360 }; // pixels

// [burley]
// The length d in Burley's profile, from albedo and diffuse mean free path.
static double burley_length(double a, double free_path) { return free_path / (3.5 + 100 * pow(a - 0.33, 4)); }
static double burley(double a, double d, double r) { return a * (exp(-r / d) + exp(-r / (3 * d))) / (8 * pi * d * r); }
// [/burley]

// [within]
// The integral of the profile over the disk of radius r.
static double burley_within(double a, double d, double r) {
    return a * (1 - exp(-r / d) / 4 - exp(-r / (3 * d)) * 3 / 4);
}
// [/within]

// Rd for the three colours.
static vec colour_lengths(void) {
    return (vec){burley_length(albedo.x, dmfp.x), burley_length(albedo.y, dmfp.y), burley_length(albedo.z, dmfp.z)};
}
static vec profile(double r) {
    vec d = colour_lengths();
    return (vec){burley(albedo.x, d.x, r), burley(albedo.y, d.y, r), burley(albedo.z, d.z, r)};
}

// [spot]
// What one sees of a laser that meets a flat block at the origin: white Lambert, as bright as the profile says.
static vec spot(double x, double y) { return scale(profile(length((vec){x, y, 0})), laser / pi); }
// [/spot]

static void print_channel(const char *name, double a, double d) {
    double sum = 0, step = d / 1000; // the midpoint rule over rings of the plane
    for (double r = step / 2; r < 60 * d; r += step) sum += 2 * pi * r * burley(a, d, r) * step;
    printf("%s: d = %.4f, all that comes back: %.4f, within a distance of 0.2: %.4f\n", name, d, sum,
           burley_within(a, d, 0.2));
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 2, SIDE, SIDE);
    vec d = colour_lengths(), red = {200, 60, 50}, green = {60, 140, 60}, blue = {60, 90, 190};
    sheet_text(&s, 0, 0, -9, "a laser meets a flat block");
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            sheet_pixel(&s, 0, x, y, spot(((x + 0.5) / SIDE - 0.5) * view, ((y + 0.5) / SIDE - 0.5) * view));

    sheet_text(&s, 1, 0, -9, "2 pi r Rd(r) over the distance r");
    plot p = {&s, 1, 0, 1.2, 0, 4};
    plot_grid(p, 0.4, 1);
    for (double r = 0.001, step = 0.003; r < p.x1; r += step) {
        vec a = scale(profile(r), 2 * pi * r), b = scale(profile(r + step), 2 * pi * (r + step));
        plot_line(p, r, a.x, r + step, b.x, red);
        plot_line(p, r, a.y, r + step, b.y, green);
        plot_line(p, r, a.z, r + step, b.z, blue);
    }
    plot_name(p, 0, red, "red");
    plot_name(p, 1, green, "green");
    plot_name(p, 2, blue, "blue");
    print_channel("red", albedo.x, d.x);
    print_channel("green", albedo.y, d.y);
    print_channel("blue", albedo.z, d.z);
    return sheet_end(&s);
}
