// resample - importance resampling. Chapter 9 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/head.h"

// Change these and see what happens.
static const int work = 600000; // probes for each point of the plot, at least
static const double of_axis[3] = {0.5, 0.25, 0.25};

enum { WIDTH = 520, HEIGHT = 340, MOST = 64 };
enum { RIGHT, BY_HITS, ANY_HIT, WAYS }; // the last two are wrong
static int candidates = 1;              // M

// The probes and their intensity are those of chapter 6.
static int pick(const double q[3]) {
    double u = rnd();

    return u < q[0] ? 0 : u < q[0] + q[1] ? 1 : 2;
}
static int probe(hit entry, const vec axis[3], hit *hits) {
    int a = pick(of_axis), c = (int)(3 * rnd());
    double r = disk_radius(c), turn = 2 * pi * rnd();
    vec o = along(entry.y, axis[(a + 1) % 3], r * cos(turn));

    o = along(o, axis[(a + 2) % 3], r * sin(turn));
    return all_hits(o, axis[a], -far_away, far_away, hits);
}
static double mean_profile(double r) {
    return (unit_profile(0, r) + unit_profile(1, r) + unit_profile(2, r)) / 3;
}
static double intensity(vec to, vec n, const vec axis[3]) {
    double sum = 0;

    for (int a = 0; a < 3; a++) {
        double u = dot(to, axis[(a + 1) % 3]), v = dot(to, axis[(a + 2) % 3]);
        sum += of_axis[a] * mean_profile(sqrt(u * u + v * v)) * fabs(dot(n, axis[a]));
    }
    return sum;
}

// [reservoir]
// One candidate out of many, picked in proportion to its weight, without a list of them.
typedef struct reservoir {
    double sum; // W: of the weights so far
    hit held;
} reservoir;

static void offer(reservoir *r, hit candidate, double weight) {
    r->sum += weight;
    if (rnd() * r->sum < weight) r->held = candidate;
}
// [/reservoir]

// [resample]
static double target(double r) { return mean_profile(r); } // of the three colours

static vec resampled(hit entry) {
    reservoir r = {0, entry};
    hit hits[MOST_HITS];
    vec axis[3] = {entry.n};

    frame(entry.n, &axis[1], &axis[2]);
    for (int j = 0; j < candidates; j++) {
        int count = probe(entry, axis, hits);
        for (int i = 0; i < count; i++) {
            vec to = sub(hits[i].y, entry.y);
            double lambda = candidates * intensity(to, hits[i].n, axis);
            offer(&r, hits[i], target(length(to)) / lambda);
        }
    }
    if (r.sum <= 0) return (vec){0, 0, 0}; // no hit: a fair sample too, never try again

    double distance = length(sub(r.held.y, entry.y));
    double k = r.sum / target(distance) * irradiance(r.held); // shaded once
    return scale(profile(distance), k);
}
// [/resample]

// An estimate for an irradiance of 1: the right one, or with a bug.
static double energy(hit entry, int way) {
    reservoir r = {0, entry};
    hit hits[MOST_HITS];
    vec axis[3] = {entry.n};
    int seen = 0;

    frame(entry.n, &axis[1], &axis[2]);
    for (int j = 0; j < candidates; j++) {
        int count = probe(entry, axis, hits);
        for (int i = 0; i < count; i++) {
            vec to = sub(hits[i].y, entry.y);
            double weight = target(length(to)) / intensity(to, hits[i].n, axis);
            hit before = r.held;
            offer(&r, hits[i], weight);
            if (way == ANY_HIT) r.held = rnd() * ++seen < 1 ? hits[i] : before;
            else seen++;
        }
    }
    if (seen == 0) return 0;
    double distance = length(sub(r.held.y, entry.y));
    double w = r.sum / (way == BY_HITS ? seen : candidates);
    return mean(profile(distance)) / target(distance) * w;
}

static vec exitance(hit entry, int way) { return way == RIGHT ? resampled(entry) : entry.n; }

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const char *const name[WAYS] = {"right", "divided by the hits", "any hit picked"};
    plot p = {&s, 0, 1, 0, 1, MOST, 0, 1.5};
    double v_1 = 0, v_g = 0, measured[MOST + 1];

    sheet_title(&s, 0, "relative variance over M");
    plot_grid(p, 2, 0.25);
    for (candidates = 1; candidates <= MOST; candidates *= 2) {
        int points = work / candidates > 30000 ? 30000 : work / candidates;
        spread m = measure(points < 10000 ? 10000 : points, exitance, RIGHT);
        measured[candidates] = m.variance;
        printf("M = %d: relative variance %.2f, mean %.2f\n", candidates, m.variance, m.mean);
    }
    v_1 = measured[1]; // the curve goes through the first point and the last
    v_g = (MOST * measured[MOST] - v_1) / (MOST - 1);
    for (double m = 1; m < MOST; m *= 1.02) {
        plot_line(p, m, v_g + (v_1 - v_g) / m, 1.02 * m, v_g + (v_1 - v_g) / (1.02 * m), orange);
    }
    for (int m = 1; m <= MOST; m *= 2) plot_point(p, m, measured[m], 5, blue);
    plot_name(p, 0, blue, "measured");
    plot_name(p, 1, orange, "by the formula");
    printf("V_g by the formula: %.2f\n", v_g);

    candidates = 16;
    for (int way = 0; way < WAYS; way++) { // at one entry
        double sum = 0, n = 20000;
        for (int i = 0; i < n; i++) sum += energy(camera(0.5, 0.4), way);
        printf("energy, %s: %.2f\n", name[way], sum / n);
    }
    return sheet_end(&s);
}
