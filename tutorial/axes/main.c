// axes - three axes, three colours. Chapter 5 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const double albedo[3] = {0.8, 0.5, 0.35};
static const double dmfp[3] = {2, 0.35, 0.15};
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int samples = 32; // for each pixel

// [head]
// A head, two ears and a muzzle: the surface is that of all the balls together.
static const struct {
    vec centre;
    double radius;
} ball[] = {{{0, -0.15, 0}, 0.85}, {{-0.64, 0.55, 0}, 0.36}, {{0.64, 0.55, 0}, 0.36}, {{0, -0.35, 0.68}, 0.34}};
enum { BALLS = sizeof ball / sizeof *ball, SIDE = 240 };
static const vec eye = {0, 0, 7};
// [/head]

enum { ONE_AXIS, BLUE, ALL, WAYS };
static const char *const way_name[WAYS] = {"one axis", "three axes, for blue", "for all colours"};
static double d[3];         // Burley's lengths
static double heaviest = 0; // weight so far

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
// [hits]
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
// [/hits]
// The first hit in front of o; t < 0 if there is none.
static hit first_hit(vec o, vec w) {
    hit hits[2 * BALLS], best = {-1, {0, 0, 0}, {0, 0, 0}};
    int count = all_hits(o, w, 1e-4, far_away, hits);
    for (int i = 0; i < count; i++)
        if (best.t < 0 || hits[i].t < best.t) best = hits[i];
    return best;
}
static double irradiance(hit h) {
    double facing = dot(h.n, unit(to_sun));
    return facing > 0 && first_hit(h.y, unit(to_sun)).t < 0 ? sun * facing + sky : sky;
}

static double disk_radius(double l) {
    double scale_of = rnd() < 0.25 ? l : 3 * l;
    return -scale_of * log(rnd());
}

// [density]
// Expected hits per unit area of a probe which is along axis a with the chance q[a] and for colour c with q_colour[c].
static double intensity(vec to, vec n, const vec axis[3], const double q[3], const double q_colour[3]) {
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double r_a = length((vec){dot(to, axis[(a + 1) % 3]), dot(to, axis[(a + 2) % 3]), 0}); // from the axis
        for (int c = 0; c < 3; c++)
            if (q[a] * q_colour[c] > 0) sum += q[a] * q_colour[c] * burley(1, d[c], r_a) * fabs(dot(n, axis[a]));
    }
    return sum;
}
// [/density]

// [probe]
static int pick(const double q[3]) { // 0, 1 or 2 with these chances
    double u = rnd();
    return u < q[0] ? 0 : u < q[0] + q[1] ? 1 : 2;
}
static vec exitance(hit entry, int way) {
    static const double axes[2][3] = {{1, 0, 0}, {0.5, 0.25, 0.25}};
    static const double colours[WAYS][3] = {{1.0 / 3, 1.0 / 3, 1.0 / 3}, {0, 0, 1}, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
    const double *q = axes[way != ONE_AXIS];
    vec axis[3] = {entry.n}, f = {0, 0, 0};
    hit hits[2 * BALLS];
    frame(entry.n, &axis[1], &axis[2]);
    int a = pick(q);
    double r = disk_radius(d[pick(colours[way])]), turn = 2 * pi * rnd();
    vec o = along(along(entry.y, axis[(a + 1) % 3], r * cos(turn)), axis[(a + 2) % 3], r * sin(turn));
    int count = all_hits(o, axis[a], -far_away, far_away, hits);
    for (int i = 0; i < count; i++) {
        vec to = sub(hits[i].y, entry.y);
        double mu = intensity(to, hits[i].n, axis, q, colours[way]), e = irradiance(hits[i]), w[3];
        for (int c = 0; c < 3; c++) {
            w[c] = burley(1, d[c], length(to)) / mu;
            heaviest = greater(heaviest, w[c]);
        }
        f = add(f, scale((vec){albedo[0] * w[0], albedo[1] * w[1], albedo[2] * w[2]}, e));
    }
    return f;
}
// [/probe]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, WAYS, SIDE, SIDE);
    for (int c = 0; c < 3; c++) d[c] = burley_length(albedo[c], dmfp[c]);
    for (int way = 0; way < WAYS; way++, heaviest = 0) {
        sheet_text(&s, way, 0, -9, "%s", way_name[way]);
        for (int i = 0; i < SIDE * SIDE; i++) {
            vec sum = {0, 0, 0};
            for (int k = 0; k < samples; k++) {
                double u = (i % SIDE + rnd()) / SIDE - 0.5, v = 0.5 - (i / SIDE + rnd()) / SIDE;
                hit entry = first_hit(eye, unit((vec){0.36 * u, 0.36 * v, -1}));
                sum = add(sum, entry.t > 0 ? scale(exitance(entry, way), 1 / pi) : background);
            }
            sheet_pixel(&s, way, i % SIDE, i / SIDE, scale(sum, 1.0 / samples));
        }
        printf("largest weight, %s: %.3g\n", way_name[way], heaviest);
    }
    return sheet_end(&s);
}
