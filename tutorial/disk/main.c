// disk - a disk probe and its Jacobian. Chapter 4 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/ball.h"

// Change these and see what happens.
static const int samples = 16;            // for each pixel
static const int for_error = 2048;        // for each block of pixels in the last panel
enum { SIDE = 240, BLOCK = 4 }; // pixels; the last panel has blocks of them
enum { EXACT, DISK, NO_JACOBIAN, FIRST_HIT, PER_HIT, WAYS };

// [cast]
// A line along the normal n through a point of the disk about x. Returns its hits with the ball,
// and the distance r_a of the line from x.
static int cast(vec x, vec n, hit hits[2], double *r_a) {
    double turn = 2 * pi * rnd(), t[2];
    vec tangent, bitangent;

    frame(n, &tangent, &bitangent);
    *r_a = disk_radius(0); // for red
    vec o = along(x, tangent, *r_a * cos(turn));
    o = along(o, bitangent, *r_a * sin(turn));

    int count = ball(o, n, t);
    for (int i = 0; i < count; i++) {
        vec y = along(o, n, t[i]);
        hits[i] = (hit){t[i], y, unit(y)};
    }
    return count;
}
// [/cast]

// [probe]
// An estimate of the integral of Rd E over the ball, by one probe.
static vec disk_probe(vec x, double (*light)(vec n)) {
    vec n = unit(x), sum = {0, 0, 0};
    hit hits[2];
    double r_a;
    int count = cast(x, n, hits, &r_a);

    for (int i = 0; i < count; i++) {
        double density = unit_profile(0, r_a) * fabs(dot(hits[i].n, n));
        vec f = scale(profile(length(sub(hits[i].y, x))), light(hits[i].n));
        sum = add(sum, scale(f, 1 / density));
    }
    return sum;
}
// [/probe]

// The same with a bug.
static vec wrong_probe(vec x, double (*light)(vec n), int bug) {
    vec n = unit(x), sum = {0, 0, 0};
    hit hits[2];
    double r_a;
    int count = cast(x, n, hits, &r_a);

    for (int i = 0; i < count; i++) {
        double density = unit_profile(0, r_a);
        if (bug != NO_JACOBIAN) density *= fabs(dot(hits[i].n, n));
        if (bug == PER_HIT) density *= count;
        if (bug == FIRST_HIT && i < count - 1) continue; // from outside the last one comes first
        vec f = scale(profile(length(sub(hits[i].y, x))), light(hits[i].n));
        sum = add(sum, scale(f, 1 / density));
    }
    return sum;
}

static double of_one(vec n) { return n.x < 2 ? 1 : 0; } // an irradiance of 1 everywhere
static vec exitance(vec x, int way) {
    if (way == EXACT) return exact(x);
    return way == DISK ? disk_probe(x, irradiance) : wrong_probe(x, irradiance, way);
}

// The error without the Jacobian, in red, over the exact radiance: the mean over many probes.
static void draw_error(sheet *s, int panel) {
    for (int i = 0; i < SIDE * SIDE / (BLOCK * BLOCK); i++) {
        int x = i % (SIDE / BLOCK), y = i / (SIDE / BLOCK);
        uint64_t state = rnd_state;
        vec right = pixel(x, y, SIDE / BLOCK, for_error, exitance, EXACT);
        rnd_state = state;
        vec wrong = pixel(x, y, SIDE / BLOCK, for_error, exitance, NO_JACOBIAN);
        for (int k = 0; k < BLOCK * BLOCK; k++) {
            sheet_error(s, panel, x * BLOCK + k % BLOCK, y * BLOCK + k / BLOCK,
                        2 * (wrong.x / right.x - 1)); // full colour at 50 %
        }
    }
}

// The estimate under an irradiance of 1 over the exact value: 1 if all is well.
static void print_energy(const char *name, int way) {
    double sum = 0, n = 500000, right = albedo[0] * unit_within(0, 2 * radius);
    vec x = {0, radius, 0};

    for (int i = 0; i < n; i++) {
        sum += (way == DISK ? disk_probe(x, of_one) : wrong_probe(x, of_one, way)).x;
    }
    printf("energy, %s: %.2f\n", name, sum / n / right);
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);
    static const char *const title[WAYS] = {"exact", "disk probes", "without the Jacobian",
                                            "first hit only", "divided by hits"};

    for (int way = EXACT; way <= NO_JACOBIAN; way++) {
        sheet_title(&s, way, title[way]);
        for (int i = 0; i < SIDE * SIDE; i++) {
            vec seen = pixel(i % SIDE, i / SIDE, SIDE, samples, exitance, way);
            sheet_pixel(&s, way, i % SIDE, i / SIDE, seen);
        }
    }
    sheet_title(&s, 3, "its error: too dark");
    draw_error(&s, 3);
    for (int way = DISK; way < WAYS; way++) print_energy(title[way], way);
    return sheet_end(&s);
}
