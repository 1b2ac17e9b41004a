// axes - probes along three axes. Chapter 5 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/head.h" // the head, its light and its camera: change them there

// Change these and see what happens.
static const double three_axes[3] = {0.5, 0.25, 0.25}; // probabilities: n and two tangents
static const int few = 16, more = 128, many = 96;    // probes for each pixel

static const double one_axis[3] = {1, 0, 0};
enum { ONE, THREE, WAYS };
static double heaviest = 0; // weight so far

// [density]
// Expected hits per unit of area of a probe that takes axis a with probability q[a]. `to` goes from
// the entry to the hit, n is the normal there.
static double intensity(vec to, vec n, const vec axis[3], const double q[3]) {
    double sum = 0;

    for (int a = 0; a < 3; a++) {
        double u = dot(to, axis[(a + 1) % 3]), v = dot(to, axis[(a + 2) % 3]);
        double r_a = sqrt(u * u + v * v); // the distance of the hit from the axis
        if (q[a] > 0) sum += q[a] * unit_profile(0, r_a) * fabs(dot(n, axis[a]));
    }
    return sum;
}
// [/density]

// [probe]
static int pick(const double q[3]) { // 0, 1 or 2 with these probabilities
    double u = rnd();

    return u < q[0] ? 0 : u < q[0] + q[1] ? 1 : 2;
}
// An estimate of the exitance at the entry, by one probe. All light scatters as red light does.
static vec exitance(hit entry, int way) {
    const double *q = way == ONE ? one_axis : three_axes;
    vec axis[3] = {entry.n};
    hit hits[MOST_HITS];
    double sum = 0;

    frame(entry.n, &axis[1], &axis[2]);
    int a = pick(q);
    double r = disk_radius(0), turn = 2 * pi * rnd();
    vec o = along(entry.y, axis[(a + 1) % 3], r * cos(turn));
    o = along(o, axis[(a + 2) % 3], r * sin(turn));

    int count = all_hits(o, axis[a], -far_away, far_away, hits);
    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double weight = unit_profile(0, length(to)) / intensity(to, hits[i].n, axis, q);
        heaviest = greater(heaviest, weight);
        sum += weight * irradiance(hits[i]);
    }
    return scale((vec){albedo[0], albedo[1], albedo[2]}, sum);
}
// [/probe]

static void print_way(const char *name, int way) {
    heaviest = 0;
    spread m = measure(50000, exitance, way);
    printf("%s: mean %.2f, relative variance %.2f, largest weight %.3g\n", name, m.mean, m.variance,
           heaviest);
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 4, SIDE, SIDE);

    picture(&s, 0, "what it should be", many, exitance, THREE);
    picture(&s, 1, "three axes, 16 probes", few, exitance, THREE);
    picture(&s, 2, "one axis, 16 probes", few, exitance, ONE);
    picture(&s, 3, "one axis, 128 probes", more, exitance, ONE);
    print_way("one axis", ONE);
    print_way("three axes", THREE);
    return sheet_end(&s);
}
