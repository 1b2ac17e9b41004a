// light - stratified candidates and the light: the header. Chapter 8 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/tutorial.h"

// Change these and see what happens.
static const float albedo[3] = {0.8f, 0.5f, 0.35f};
static const float dmfp[3] = {2.0f, 0.35f, 0.15f};
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int samples = 4; // for each pixel: points that are shaded
// [plans]
enum { MEMO, STRATIFIED, TOLD, TOLD_WRONG, WAYS };
static const char *const way_name[WAYS] = {"the memo, M = 16", "stratified, M = 8", "told of the light", "told wrong"};
static const sss_plan plan[WAYS] = {
    {.candidates = 16, .independent = 1}, {.candidates = 8}, {.candidates = 8}, {.candidates = 8}};
// [/plans]

// A head, two ears and a muzzle: the surface is that of all the balls together.
static const struct {
    vec centre;
    double radius;
} ball[] = {{{0, -0.15, 0}, 0.85}, {{-0.64, 0.55, 0}, 0.36}, {{0.64, 0.55, 0}, 0.36}, {{0, -0.35, 0.68}, 0.34}};
enum { BALLS = sizeof ball / sizeof *ball, SIDE = 240 };
static const vec eye = {0, 0, 7};
static sss_medium wax;

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

// [vectors]
static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }
// [/vectors]

// [hint]
// A guess of the irradiance without a ray. It must not be 0 where light comes.
static double hint(vec n, int way) {
    if (way < TOLD) return 1;
    return sun * greater(0, dot(n, unit(to_sun))) + (way == TOLD_WRONG ? 0 : sky);
}
// [/hint]

// [lookup]
static vec exitance(hit entry, int way, int lit) {
    static uint32_t lookups = 0;
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[2 * BALLS];
    sss_begin(&s, &wax, &plan[way], to_sss(entry.y), to_sss(entry.n), sss_hash(lookups++, (uint32_t)way));
    while (sss_next_probe(&s, &p)) {
        int count = all_hits(from_sss(p.origin), from_sss(p.direction), 0, (double)p.length, hits);
        for (int i = 0; i < count; i++)
            sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), (float)hint(hits[i].n, way));
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0}; // a fair sample too: never try again
    hit at = {0, from_sss(e.position), from_sss(e.normal)};
    return scale((vec){(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]}, lit ? irradiance(at) : 1);
}
// [/lookup]

// The relative variance of one shaded point, from two lookups at each of many places that the camera sees.
static void print_variance(int way) {
    double variance = 0, power = 0, sum = 0;
    rnd_state = 1; // the same places for every plan
    for (int i = 0; i < 40000; i++) {
        double u = rnd(), v = rnd();
        hit entry = camera(u, v);
        if (entry.t < 0) continue;
        double a = mean(exitance(entry, way, 1)), b = mean(exitance(entry, way, 1));
        variance += (a - b) * (a - b) / 2;
        power += a * b;
        sum += a + b;
    }
    printf("%s: relative variance %.3f, mean %.2f\n", way_name[way], variance / power, sum / 80000);
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 3, SIDE, SIDE);
    sss_result result = sss_burley(&wax, albedo, dmfp);
    if (result != SSS_OK) return fprintf(stderr, "%s\n", sss_result_string(result)), 1;
    for (int way = 0; way < WAYS; way++) {
        if (way <= TOLD) sheet_text(&s, way, 0, -9, "%s", way_name[way]);
        for (int i = 0; i < SIDE * SIDE && way <= TOLD; i++) {
            vec sum = {0, 0, 0};
            for (int k = 0; k < samples; k++) {
                double u = (i % SIDE + rnd()) / SIDE, v = (i / SIDE + rnd()) / SIDE;
                hit entry = camera(u, v);
                vec l = entry.t > 0 ? scale(exitance(entry, way, 1), 1 / pi) : background;
                sum = add(sum, scale(l, 1.0 / samples));
            }
            sheet_pixel(&s, way, i % SIDE, i / SIDE, sum);
        }
        print_variance(way);
    }
    return sheet_end(&s);
}
