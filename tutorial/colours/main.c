// colours - probes for three colours. Chapter 6 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/head.h"

// Change these and see what happens.
static const int few = 16, many = 96; // probes for each pixel

enum { BLUE, RED, ALL, WAYS };
static const double of_axis[3] = {0.5, 0.25, 0.25}; // probabilities of the axes
static const double of_colour[WAYS][3] = {{0, 0, 1}, {1, 0, 0}, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
static double heaviest = 0; // weight so far

// [density]
// Expected hits per unit of area: the sum over axes a and colours c.
static double intensity(vec to, vec n, const vec axis[3], const double q[3]) {
    double sum = 0;

    for (int a = 0; a < 3; a++) {
        double u = dot(to, axis[(a + 1) % 3]), v = dot(to, axis[(a + 2) % 3]);
        double r_a = sqrt(u * u + v * v);
        for (int c = 0; c < 3; c++) {
            double both = of_axis[a] * q[c];
            if (both > 0) sum += both * unit_profile(c, r_a) * fabs(dot(n, axis[a]));
        }
    }
    return sum;
}
// [/density]

static int pick(const double q[3]) { // 0, 1 or 2 with these probabilities
    double u = rnd();

    return u < q[0] ? 0 : u < q[0] + q[1] ? 1 : 2;
}
// A probe along one of the axes and for one of the colours. Returns its hits.
static int probe(hit entry, const vec axis[3], const double q[3], hit *hits) {
    int a = pick(of_axis);
    double r = disk_radius(pick(q)), turn = 2 * pi * rnd();
    vec o = along(entry.y, axis[(a + 1) % 3], r * cos(turn));

    o = along(o, axis[(a + 2) % 3], r * sin(turn));
    return all_hits(o, axis[a], -far_away, far_away, hits);
}

// [weights]
static vec exitance(hit entry, int way) {
    const double *q = of_colour[way];
    vec axis[3] = {entry.n}, sum = {0, 0, 0};
    hit hits[MOST_HITS];

    frame(entry.n, &axis[1], &axis[2]);
    int count = probe(entry, axis, q, hits);
    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double mu = intensity(to, hits[i].n, axis, q), weight[3];
        for (int c = 0; c < 3; c++) {
            weight[c] = unit_profile(c, length(to)) / mu;
            heaviest = greater(heaviest, weight[c]);
        }
        vec f = {albedo[0] * weight[0], albedo[1] * weight[1], albedo[2] * weight[2]};
        sum = add(sum, scale(f, irradiance(hits[i])));
    }
    return sum;
}
// [/weights]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);
    static const char *const name[WAYS] = {"for blue", "for red", "for all colours"};

    picture(&s, 0, "what it should be", many, exitance, ALL);
    for (int way = BLUE; way < WAYS; way++) {
        picture(&s, 1 + way, name[way], few, exitance, way);
        heaviest = 0;
        spread m = measure(50000, exitance, way);
        printf("%s: mean %.2f, relative variance %.2f, largest weight %.3g\n", name[way], m.mean,
               m.variance, heaviest);
    }
    return sheet_end(&s);
}
