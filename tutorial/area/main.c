// area - the truth, slowly: points all over the ball. Chapter 3 of the tutorial.
// SPDX-License-Identifier: MIT
#include "tutorial/ball.h" // the ball and its light, from chapter 1: change them there

// Change these and see what happens.
static const int few = 16, many = 512; // points for each pixel

enum { SIDE = 240 };
enum { LAMBERT, EXACT, FEW, MANY, WAYS };

// [estimate]
// One point y, uniform on the ball: its density over area is 1 / (4 pi R^2). Returns an estimate of
// the exitance at x, the integral of Rd(|y - x|) E(y) over the surface.
static vec area_point(vec x) {
    vec n = rnd_on_unit_sphere(), y = scale(n, radius);
    double density = 1 / (4 * pi * radius * radius);

    return scale(profile(length(sub(y, x))), irradiance(n) / density);
}
// [/estimate]

static vec exitance(vec x, int way) {
    if (way == LAMBERT) return scale((vec){albedo[0], albedo[1], albedo[2]}, irradiance(unit(x)));
    return way == EXACT ? exact(x) : area_point(x);
}

// [energy]
// An irradiance of 1 everywhere: the exitance is then the integral of Rd alone.
static void check_energy(void) {
    double sum = 0, n = 1000000;

    for (int i = 0; i < n; i++) {
        vec y = scale(rnd_on_unit_sphere(), radius), x = {0, 0, radius};
        sum += profile(length(sub(y, x))).x * 4 * pi * radius * radius;
    }
    printf("red exitance under an irradiance of 1: %.3f\n", sum / n);
    printf("the exact integral: %.3f\n", albedo[0] * unit_within(0, 2 * radius));
}
// [/energy]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, WAYS, SIDE, SIDE);

    for (int way = 0; way < WAYS; way++) {
        double full = 0, shown = 0; // sums of red, and of what of it is not cut off at white
        char title[64] = "Lambert";
        if (way == EXACT) strcpy(title, "wax, exact");
        if (way >= FEW) snprintf(title, sizeof title, "%d points a pixel", way == FEW ? few : many);
        sheet_title(&s, way, title);
        for (int i = 0; i < SIDE * SIDE; i++) {
            int points = way == MANY ? many : few;
            vec seen = pixel(i % SIDE, i / SIDE, SIDE, points, exitance, way);
            sheet_pixel(&s, way, i % SIDE, i / SIDE, seen);
            full += seen.x;
            shown += seen.x < white ? seen.x : white;
        }
        printf("%s: mean red radiance %.3f, as shown %.3f\n", title, full / (SIDE * SIDE),
               shown / (SIDE * SIDE));
    }
    check_energy();
    return sheet_end(&s);
}
