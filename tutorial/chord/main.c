// chord - chords of spheres about the entry. Chapter 8 of the tutorial.
// SPDX-License-Identifier: MIT
#include "tutorial/head.h"

// Change these and see what happens.
static const int colour = 0;      // that the probes are for: 0 is red
static const int probes = 400000; // of each kind, for the numbers
static const int points = 4000;   // probes of each kind whose hits are drawn

enum { DISK, CHORD, HALF, WHOLE_LINE, WAYS, WIDTH = 520, HEIGHT = 380 };

// [radius]
// The radius of a chord's sphere. Its density is -pi rho^2 P'(rho): with probability 1/2 each, one
// exponential random number or the sum of two.
static double chord_radius(int c) {
    double d = burley_length(c);
    double mean_radius = rnd() < 0.25 ? d : 3 * d;

    return -mean_radius * log(rnd() < 0.5 ? rnd() : rnd() * rnd());
}
// [/radius]

// [cast]
// The segment between two independent uniform points of that sphere about the entry.
static int cast_chord(hit entry, int whole_line, hit *hits) {
    double rho = chord_radius(colour);
    vec start = along(entry.y, rnd_on_unit_sphere(), rho);
    vec end = along(entry.y, rnd_on_unit_sphere(), rho), way = sub(end, start);

    if (whole_line) return all_hits(start, unit(way), -far_away, far_away, hits); // a bug
    return all_hits(start, unit(way), 0, length(way), hits);
}
static double chord_intensity(vec to) { return unit_profile(colour, length(to)) / 2; }
// [/cast]

// The disk probes of chapter 4, along the normal.
static int cast_disk(hit entry, hit *hits) {
    double r = disk_radius(colour), turn = 2 * pi * rnd();
    vec tangent, bitangent;

    frame(entry.n, &tangent, &bitangent);
    vec o = along(along(entry.y, tangent, r * cos(turn)), bitangent, r * sin(turn));
    return all_hits(o, entry.n, -far_away, far_away, hits);
}
static double disk_intensity(vec to, vec n, hit entry) {
    double height = dot(to, entry.n), r_a = length(along(to, entry.n, -height));

    return unit_profile(colour, r_a) * fabs(dot(n, entry.n));
}

// [half]
// Expected hits per unit of area where one probe in two is a disk probe, the others are chords.
static double half_intensity(vec to, vec n, hit entry) {
    return 0.5 * disk_intensity(to, n, entry) + 0.5 * chord_intensity(to);
}
// [/half]

// One probe. Every hit gets a weight: the unit profile over the intensity there.
static int probe(hit entry, int way, hit *hits, double *weight) {
    int is_disk = way == DISK || (way == HALF && rnd() < 0.5);
    int count = is_disk ? cast_disk(entry, hits) : cast_chord(entry, way == WHOLE_LINE, hits);

    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double mu = chord_intensity(to);
        if (way == DISK) mu = disk_intensity(to, hits[i].n, entry);
        if (way == HALF) mu = half_intensity(to, hits[i].n, entry);
        weight[i] = unit_profile(colour, length(to)) / mu;
    }
    return count;
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const char *const name[WAYS] = {"disks along n", "chords", "half of each",
                                           "chords as whole lines"};
    const vec paint[WAYS] = {blue, black, orange, black};
    plot p = {&s, 0, 0, 1, 0, 1.5, 0.1, 100};
    vec n = unit((vec){-0.2, 0.4, 1});
    hit entry = {0, along(ball[0].centre, n, ball[0].radius), n}, hits[MOST_HITS];
    double weight[MOST_HITS];

    sheet_title(&s, 0, "weight of a hit over its distance");
    plot_grid(p, 0.25, 10);
    for (int way = 0; way < WAYS; way++) {
        double sum = 0, squares = 0, heaviest = 0, distances = 0;
        for (int k = 0; k < probes; k++) {
            double one = 0;
            int count = probe(entry, way, hits, weight);
            for (int i = 0; i < count; i++) {
                double r = length(sub(hits[i].y, entry.y));
                double size = way == CHORD ? 1.5 : 1;
                if (k < points && way != WHOLE_LINE && r < p.x1) {
                    plot_point(p, r, weight[i], size, paint[way]);
                }
                one += weight[i];
                distances += weight[i] * r;
                heaviest = greater(heaviest, weight[i]);
            }
            sum += one;
            squares += one * one;
        }
        sum /= probes;
        if (way != WHOLE_LINE) plot_name(p, way, paint[way], name[way]);
        printf("%s: sum %.2f, sum of weight times distance %.3f, relative variance %.2f, "
               "largest weight %.3g\n",
               name[way], sum, distances / probes, squares / probes / (sum * sum) - 1, heaviest);
    }
    return sheet_end(&s);
}
