// resample - importance resampling. Chapter 7 of the tutorial; SPDX-License-Identifier: MIT
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const double albedo[3] = {0.8, 0.5, 0.35};
static const double dmfp[3] = {2, 0.35, 0.15};
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int samples = 4;                // for each pixel: points that are shaded
static const int candidates[3] = {1, 4, 16}; // for each of them

// A head, two ears and a muzzle: the surface is that of all the balls together.
static const struct {
    vec centre;
    double radius;
} ball[] = {{{0, -0.15, 0}, 0.85}, {{-0.64, 0.55, 0}, 0.36}, {{0.64, 0.55, 0}, 0.36}, {{0, -0.35, 0.68}, 0.34}};
enum { BALLS = sizeof ball / sizeof *ball, SIDE = 240 };
static const vec eye = {0, 0, 7};
enum { ONE, RIGHT, BY_HITS, ANY_HIT, WAYS }; // the last two are wrong
static const char *const way_name[WAYS] = {"M = 1", "M = 16", "divided by the hits", "any hit picked"};
static double d[3]; // Burley's lengths

static double burley_length(double a, double free_path) { return free_path / (3.5 + 100 * pow(a - 0.33, 4)); }
static double burley(double a, double l, double r) {
    double e = exp(-r / (3 * l));
    return a * (e * e * e + e) / (8 * pi * l * r);
}

// All places where the line o + t w, t within t0..t1, meets the surface: those of each ball that no other one holds.
static int all_hits(vec o, vec w, double t0, double t1, hit *hits) {
    int count = 0;
    for (int i = 0; i < 2 * BALLS; i++) {
        vec from = sub(o, ball[i / 2].centre);
        double r = ball[i / 2].radius, b = dot(from, w), rest = b * b - dot(from, from) + r * r;
        double t = -b + (i % 2 ? sqrt(rest) : -sqrt(rest));
        vec y = along(o, w, t);
        int seen = rest > 0 && t >= t0 && t <= t1;
        for (int k = 0; k < BALLS; k++) seen = seen && (k == i / 2 || length(sub(y, ball[k].centre)) > ball[k].radius);
        if (seen) hits[count++] = (hit){t, y, scale(sub(y, ball[i / 2].centre), 1 / r)};
    }
    return count;
}
// The first hit in front of o; t < 0 if there is none.
static hit first_hit(vec o, vec w) {
    hit hits[2 * BALLS], best = {-1, {0, 0, 0}, {0, 0, 0}};
    int count = all_hits(o, w, 1e-4, far_away, hits);
    for (int i = 0; i < count; i++)
        if (best.t < 0 || hits[i].t < best.t) best = hits[i];
    return best;
}
static hit camera(double u, double v) { return first_hit(eye, unit((vec){0.36 * (u - 0.5), 0.36 * (0.5 - v), -1})); }
static double irradiance(hit h) {
    double facing = dot(h.n, unit(to_sun));
    return facing > 0 && first_hit(h.y, unit(to_sun)).t < 0 ? sun * facing + sky : sky;
}

// [techniques]
enum { DISK, SPHERE, CHORD };
static const double share[3] = {0.375, 0.375, 0.25}; // of the probes

static double exponentials(double l, int count) { // their sum, of the mean l with the chance 1/4, else 3 l
    double sum = rnd() < 0.25 ? l : 3 * l, u = rnd();
    return -sum * log(count == 1 ? u : u * rnd());
}
// A probe by one of three techniques and for one of three colours, each drawn anew. Returns its hits.
static int probe(hit entry, hit *hits) {
    double u = rnd(), l = d[(int)(3 * rnd())], r = exponentials(l, 1), turn = 2 * pi * rnd();
    vec tangent, bitangent, way = rnd_on_unit_sphere(), other = rnd_on_unit_sphere();
    frame(entry.n, &tangent, &bitangent);
    vec o = along(along(entry.y, tangent, r * cos(turn)), bitangent, r * sin(turn));
    if (u < share[DISK]) return all_hits(o, entry.n, -far_away, far_away, hits);
    if (u < share[DISK] + share[SPHERE]) return all_hits(along(entry.y, entry.n, -l), way, -far_away, far_away, hits);
    double rho = exponentials(l, rnd() < 0.5 ? 1 : 2);
    vec chord = scale(sub(other, way), rho);
    return all_hits(along(entry.y, way, rho), unit(chord), 0, length(chord), hits);
}
// Expected hits per unit area of one such probe: all techniques and colours together.
static double intensity(vec to, vec n, hit entry) {
    double sum = 0, height = dot(to, entry.n), r_a = length(along(to, entry.n, -height));
    for (int c = 0; c < 3; c++) {
        vec v = along(to, entry.n, d[c]);
        sum += share[DISK] / 3 * burley(1, d[c], r_a) * fabs(dot(n, entry.n));
        sum += share[SPHERE] / 3 * fabs(dot(n, unit(v))) / (2 * pi * dot(v, v));
        sum += share[CHORD] / 3 * burley(1, d[c], length(to)) / 2;
    }
    return sum;
}
// [/techniques]

// [resample]
// The target: the mean of the three unit profiles.
static double target(double r) { return (burley(1, d[0], r) + burley(1, d[1], r) + burley(1, d[2], r)) / 3; }

static vec exitance(hit entry, int m, int way, int lit) {
    hit hits[2 * BALLS], held = entry;
    double sum = 0, seen = 0; // of the weights; hits
    for (int j = 0; j < m; j++) {
        int count = probe(entry, hits);
        for (int i = 0; i < count; i++) {
            vec to = sub(hits[i].y, entry.y);
            double w = target(length(to)) / intensity(to, hits[i].n, entry);
            sum += w;
            seen += 1;
            if (way == ANY_HIT ? rnd() * seen < 1 : rnd() * sum < w) held = hits[i];
        }
    }
    if (seen == 0) return (vec){0, 0, 0}; // a fair sample too: never try again
    double r = length(sub(held.y, entry.y)), k = sum / (way == BY_HITS ? seen : m) / target(r);
    vec f = {burley(albedo[0], d[0], r), burley(albedo[1], d[1], r), burley(albedo[2], d[2], r)};
    return scale(f, k * (lit ? irradiance(held) : 1)); // shaded once
}
// [/resample]

// The relative variance of one shaded point, from two lookups at each of many places that the camera sees.
static void print_variance(int m) {
    double variance = 0, power = 0;
    for (int i = 0; i < 250000 / m; i++) {
        double u = rnd(), v = rnd();
        hit entry = camera(u, v);
        if (entry.t < 0) continue;
        double a = mean(exitance(entry, m, RIGHT, 1)), b = mean(exitance(entry, m, RIGHT, 1));
        variance += (a - b) * (a - b) / 2;
        power += a * b;
    }
    printf("relative variance with M = %d: %.2f\n", m, variance / power);
}
int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 3, SIDE, SIDE);
    for (int c = 0; c < 3; c++) d[c] = burley_length(albedo[c], dmfp[c]);
    for (int panel = 0; panel < 3; panel++) {
        sheet_text(&s, panel, 0, -9, "M = %d", candidates[panel]);
        for (int i = 0; i < SIDE * SIDE; i++) {
            vec sum = {0, 0, 0};
            for (int k = 0; k < samples; k++) {
                double u = (i % SIDE + rnd()) / SIDE, v = (i / SIDE + rnd()) / SIDE;
                hit entry = camera(u, v);
                vec l = entry.t > 0 ? scale(exitance(entry, candidates[panel], RIGHT, 1), 1 / pi) : background;
                sum = add(sum, scale(l, 1.0 / samples));
            }
            sheet_pixel(&s, panel, i % SIDE, i / SIDE, sum);
        }
    }
    for (int m = 1; m <= 64; m *= 4) print_variance(m);
    for (int way = 0; way < WAYS; way++) { // one entry, a light of 1 from everywhere
        double sum = 0, n = 10000;
        for (int i = 0; i < n; i++) sum += mean(exitance(camera(0.5, 0.4), way == ONE ? 1 : 16, way, 0));
        printf("energy, %s: %.2f\n", way_name[way], sum / n);
    }
    return sheet_end(&s);
}
