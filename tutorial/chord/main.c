// chord - sphere and chord. Chapter 6 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const double albedo[3] = {0.8, 0.5, 0.35};
static const double dmfp[3] = {2, 0.35, 0.15};
static const int colour = 0;      // the channel that the probes are for: 0 is red
static const int probes = 400000; // of each technique, for the sums
static const int points = 2500;   // of each technique, in the plot

// A head, two ears and a muzzle: the surface is that of all the balls together.
static const struct {
    vec centre;
    double radius;
} ball[] = {{{0, -0.15, 0}, 0.85}, {{-0.64, 0.55, 0}, 0.36}, {{0.64, 0.55, 0}, 0.36}, {{0, -0.35, 0.68}, 0.34}};
enum { BALLS = sizeof ball / sizeof *ball, WIDTH = 744, HEIGHT = 420 };

enum { DISK, SPHERE, CHORD, WHOLE_LINE, WAYS };
static const char *const way_name[WAYS] = {"disks on three axes", "sphere", "chord", "chord, whole line"};
static double d; // Burley's length

static double burley_length(double a, double free_path) { return free_path / (3.5 + 100 * pow(a - 0.33, 4)); }
static double burley(double a, double l, double r) {
    double e = exp(-r / (3 * l));
    return a * (e * e * e + e) / (8 * pi * l * r);
}

static int inside_another(vec y, int own) {
    for (int i = 0; i < BALLS; i++)
        if (i != own && length(sub(y, ball[i].centre)) < ball[i].radius) return 1;
    return 0;
}
// All places where the line o + t w, t within t0..t1, meets the surface: those of each ball that no other one holds.
static int all_hits(vec o, vec w, double t0, double t1, hit *hits) {
    int count = 0;
    for (int i = 0; i < 2 * BALLS; i++) {
        vec from = sub(o, ball[i / 2].centre);
        double r = ball[i / 2].radius, b = dot(from, w), rest = b * b - dot(from, from) + r * r;
        if (rest <= 0) continue;
        double t = -b + (i % 2 ? sqrt(rest) : -sqrt(rest));
        vec y = along(o, w, t);
        if (t >= t0 && t <= t1 && !inside_another(y, i / 2))
            hits[count++] = (hit){t, y, scale(sub(y, ball[i / 2].centre), 1 / r)};
    }
    return count;
}
static double disk_radius(double l) {
    double scale_of = rnd() < 0.25 ? l : 3 * l;
    return -scale_of * log(rnd());
}

// A disk probe on one of three axes, which have the chances q, and the intensity of such probes.
static const double q[3] = {0.5, 0.25, 0.25};
static int disk_hits(hit entry, const vec axis[3], hit *hits) {
    double u = rnd(), r = disk_radius(d), turn = 2 * pi * rnd();
    int a = u < q[0] ? 0 : u < q[0] + q[1] ? 1 : 2;
    vec o = along(along(entry.y, axis[(a + 1) % 3], r * cos(turn)), axis[(a + 2) % 3], r * sin(turn));
    return all_hits(o, axis[a], -far_away, far_away, hits);
}
static double disk_intensity(vec to, vec n, const vec axis[3]) {
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double r_a = length((vec){dot(to, axis[(a + 1) % 3]), dot(to, axis[(a + 2) % 3]), 0}); // from the axis
        sum += q[a] * burley(1, d, r_a) * fabs(dot(n, axis[a]));
    }
    return sum;
}

// [sphere]
// A whole line in a uniform direction through the point at the depth d below the entry.
static int sphere_hits(hit entry, hit *hits) {
    return all_hits(along(entry.y, entry.n, -d), rnd_on_unit_sphere(), -far_away, far_away, hits);
}
static double sphere_intensity(vec to, vec n, hit entry) {
    vec v = along(to, entry.n, d); // from that point
    return fabs(dot(n, unit(v))) / (2 * pi * dot(v, v));
}
// [/sphere]

// [chord]
// The radius of a chord's sphere, with the density -pi rho^2 P'(rho): exponentials, and sums of two of them.
static double chord_radius(double l) {
    double scale_of = rnd() < 0.25 ? l : 3 * l;
    return -scale_of * log(rnd() < 0.5 ? rnd() : rnd() * rnd());
}
// The segment between two uniform points of that sphere about the entry.
static int chord_hits(hit entry, int cut, hit *hits) {
    double rho = chord_radius(d);
    vec from = along(entry.y, rnd_on_unit_sphere(), rho), way = sub(along(entry.y, rnd_on_unit_sphere(), rho), from);
    double end = length(way);
    return all_hits(from, unit(way), cut ? 0 : -far_away, cut ? end : far_away, hits);
}
static double chord_intensity(vec to) { return burley(1, d, length(to)) / 2; }
// [/chord]

// One probe; every hit of it gets the weight w[i], Rd / A over the intensity there.
static int probe(hit entry, int way, hit *hits, double *w) {
    vec axis[3] = {entry.n};
    frame(entry.n, &axis[1], &axis[2]);
    int count = way == DISK     ? disk_hits(entry, axis, hits)
                : way == SPHERE ? sphere_hits(entry, hits)
                                : chord_hits(entry, way == CHORD, hits);
    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double mu = way == DISK     ? disk_intensity(to, hits[i].n, axis)
                    : way == SPHERE ? sphere_intensity(to, hits[i].n, entry)
                                    : chord_intensity(to);
        w[i] = burley(1, d, length(to)) / mu;
    }
    return count;
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const vec paint[] = {{70, 110, 190}, {80, 150, 70}, {200, 60, 50}};
    plot p = {&s, 0, 1, 1.5, 0.1, 100};
    vec n = unit((vec){-0.2, 0.4, 1});
    hit entry = {0, along(ball[0].centre, n, ball[0].radius), n}, hits[2 * BALLS];
    double w[2 * BALLS];
    d = burley_length(albedo[colour], dmfp[colour]);
    sheet_text(&s, 0, 0, -9, "weight of a hit over its distance from the entry");
    plot_grid(p, 0.25, 10);
    for (int way = 0; way < WAYS; way++) {
        double sum = 0, squares = 0, heaviest = 0;
        for (int k = 0; k < probes; k++) {
            double one = 0;
            int count = probe(entry, way, hits, w);
            for (int i = 0; i < count; i++) {
                double r = length(sub(hits[i].y, entry.y));
                if (k < points && way <= CHORD && r < p.x1) plot_point(p, r, w[i], 1, paint[way]);
                one += w[i];
                heaviest = greater(heaviest, w[i]);
            }
            sum += one;
            squares += one * one;
        }
        sum /= probes;
        printf("%s: sum %.2f, relative variance %.2f, largest weight %.4g\n", way_name[way], sum,
               squares / probes / (sum * sum) - 1, heaviest);
        if (way <= CHORD) plot_name(p, way, paint[way], way_name[way]);
    }
    return sheet_end(&s);
}
