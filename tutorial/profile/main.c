// profile - light that leaves elsewhere: the glow of a laser. Chapter 2 of the tutorial.
// SPDX-License-Identifier: MIT
#include "tutorial/wax.h" // the wax: change it there

// Change these and see what happens.
static const double laser = 25;// its power
static const double view = 4;  // width of the left panel, in scene units
enum { PIXELS = 280 };

// [glow]
// What one sees of a laser that meets a flat block at the origin: the profile, as white Lambert.
static vec glow(double x, double y) {
    return scale(profile(length((vec){x, y, 0})), laser / pi);
}
// [/glow]

static void print_colour(const char *name, int c) {
    double d = burley_length(c), sum = 0, step = d / 1000; // the midpoint rule over rings

    for (double r = step / 2; r < 60 * d; r += step) {
        sum += 2 * pi * r * albedo[c] * unit_profile(c, r) * step;
    }
    printf("%s: d = %.4f, all that comes back: %.4f, within a distance of 0.2: %.4f\n", name, d,
           sum, albedo[c] * unit_within(c, 0.2));
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 2, PIXELS, PIXELS);
    static const char *const name[3] = {"red", "green", "blue"};
    const vec paint[3] = {orange, green, blue};

    sheet_title(&s, 0, "a laser on a flat block");
    for (int y = 0; y < PIXELS; y++) {
        for (int x = 0; x < PIXELS; x++) {
            double u = (x + 0.5) / PIXELS - 0.5, v = (y + 0.5) / PIXELS - 0.5;
            sheet_pixel(&s, 0, x, y, glow(u * view, v * view));
        }
    }

    plot p = {&s, 1, 0, 0, 0, 1.2, 0, 4};
    sheet_title(&s, 1, "2 pi r Rd(r) over r");
    plot_grid(p, 0.4, 1);
    for (int c = 0; c < 3; c++) {
        for (double r = 0.001, step = 0.003; r < p.x1; r += step) {
            double q = r + step;
            double y0 = 2 * pi * r * albedo[c] * unit_profile(c, r);
            double y1 = 2 * pi * q * albedo[c] * unit_profile(c, q);
            plot_line(p, r, y0, q, y1, paint[c]);
        }
        plot_name(p, c, paint[c], name[c]);
        print_colour(name[c], c);
    }
    return sheet_end(&s);
}
