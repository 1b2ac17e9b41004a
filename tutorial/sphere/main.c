// sphere - lines through a point below the entry. Chapter 7 of the tutorial.
// SPDX-License-Identifier: MIT
#include "tutorial/head.h"

// Change these and see what happens.
static const int colour = 0;               // that the probes are for: 0 is red
static const double depth_over_length = 1; // the depth h over Burley's d
static const int probes = 400000;          // for the numbers
static const int points = 4000;            // probes whose hits are drawn

enum { DISK, SPHERE, WAYS, WIDTH = 520, HEIGHT = 380 };
static const double of_axis[3] = {0.5, 0.25, 0.25};

// [cast]
// A whole line in a uniform direction through the point at the depth h below the entry.
static int cast_sphere(hit entry, double h, hit *hits) {
    vec o = along(entry.y, entry.n, -h);

    return all_hits(o, rnd_on_unit_sphere(), -far_away, far_away, hits);
}
// [/cast]

// [density]
// Its expected hits per unit of area at a point with the normal n. `to` goes there from the entry.
static double sphere_intensity(vec to, vec n, hit entry, double h) {
    vec from_o = along(to, entry.n, h);

    return fabs(dot(n, unit(from_o))) / (2 * pi * dot(from_o, from_o));
}
// [/density]

// The disk probes of chapter 5.
static int cast_disk(hit entry, const vec axis[3], hit *hits) {
    double u = rnd(), r = disk_radius(colour), turn = 2 * pi * rnd();
    int a = u < of_axis[0] ? 0 : u < of_axis[0] + of_axis[1] ? 1 : 2;
    vec o = along(entry.y, axis[(a + 1) % 3], r * cos(turn));

    o = along(o, axis[(a + 2) % 3], r * sin(turn));
    return all_hits(o, axis[a], -far_away, far_away, hits);
}
static double disk_intensity(vec to, vec n, const vec axis[3]) {
    double sum = 0;

    for (int a = 0; a < 3; a++) {
        double u = dot(to, axis[(a + 1) % 3]), v = dot(to, axis[(a + 2) % 3]);
        sum += of_axis[a] * unit_profile(colour, sqrt(u * u + v * v)) * fabs(dot(n, axis[a]));
    }
    return sum;
}

// One probe. Every hit gets a weight: the unit profile over the intensity there.
static int probe(hit entry, int way, hit *hits, double *weight) {
    vec axis[3] = {entry.n};
    double h = depth_over_length * burley_length(colour);

    frame(entry.n, &axis[1], &axis[2]);
    int count = way == DISK ? cast_disk(entry, axis, hits) : cast_sphere(entry, h, hits);
    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double mu = way == DISK ? disk_intensity(to, hits[i].n, axis)
                                : sphere_intensity(to, hits[i].n, entry, h);
        weight[i] = unit_profile(colour, length(to)) / mu;
    }
    return count;
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const char *const name[WAYS] = {"disks on three axes", "sphere"};
    const vec paint[WAYS] = {blue, orange};
    plot p = {&s, 0, 0, 1, 0, 1.5, 0.1, 100};
    vec n = unit((vec){-0.2, 0.4, 1});
    hit entry = {0, along(ball[0].centre, n, ball[0].radius), n}, hits[MOST_HITS];
    double weight[MOST_HITS];

    sheet_title(&s, 0, "weight of a hit over its distance");
    plot_grid(p, 0.25, 10);
    for (int way = 0; way < WAYS; way++) {
        double sum = 0, squares = 0, heaviest = 0, missed = 0;
        for (int k = 0; k < probes; k++) {
            double one = 0;
            int count = probe(entry, way, hits, weight);
            for (int i = 0; i < count; i++) {
                double r = length(sub(hits[i].y, entry.y));
                if (k < points && r < p.x1) plot_point(p, r, weight[i], 1, paint[way]);
                one += weight[i];
                heaviest = greater(heaviest, weight[i]);
            }
            missed += count == 0;
            sum += one;
            squares += one * one;
        }
        sum /= probes;
        plot_name(p, way, paint[way], name[way]);
        printf("%s: sum %.2f, probes without a hit %.2f, relative variance %.2f, "
               "largest weight %.3g\n",
               name[way], sum, missed / probes, squares / probes / (sum * sum) - 1, heaviest);
    }
    return sheet_end(&s);
}
