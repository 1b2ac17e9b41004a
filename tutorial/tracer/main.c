// tracer - a path tracer with the header. Chapter 12 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/tutorial.h"

// Change these and see what happens.
enum { BALLS = 4, WIDTH = 520, HEIGHT = 190 };
static const double free_path[BALLS] = {0.002, 0.1, 0.4, 1.2}; // dmfp of red
static const float albedo[3] = {0.8f, 0.55f, 0.4f};
static const vec to_sun = {-0.8, 0.7, 0.3};
static const double sun = 3, sky = 0.25; // irradiance of the sun head-on; radiance of the sky
static const double floor_albedo = 0.5;
static const int few = 4, many = 24; // paths for each pixel

enum { NOTHING = -2, FLOOR = -1 }; // in place of the number of a ball
static const double radius = 0.9;
static const vec eye = {0, 2.6, 9};
static sss_medium wax[BALLS];
static uint32_t lookups = 0;

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }
static vec centre(int i) { return (vec){2.1 * i - 3.15, radius, 0}; }

// Where the line crosses ball i, t within t0..t1: up to two hits.
static int all_hits(int i, vec o, vec dir, double t0, double t1, hit *hits) {
    vec from = sub(o, centre(i));
    double b = dot(from, dir), rest = b * b - dot(from, from) + radius * radius;
    int count = 0;

    for (int side = -1; side <= 1 && rest > 0; side += 2) {
        double t = -b + side * sqrt(rest);
        vec y = along(o, dir, t);
        if (t < t0 || t > t1) continue;
        hits[count++] = (hit){t, y, scale(sub(y, centre(i)), 1 / radius)};
    }
    return count;
}
// What a ray meets first.
static int first_hit(vec o, vec dir, hit *first) {
    hit hits[2];
    int what = NOTHING;
    double t = -o.y / dir.y;

    first->t = far_away;
    for (int i = 0; i < BALLS; i++) {
        if (!all_hits(i, o, dir, 1e-4, first->t, hits)) continue;
        *first = hits[0];
        what = i;
    }
    if (t < 1e-4 || t > first->t) return what;
    *first = (hit){t, along(o, dir, t), {0, 1, 0}};
    return FLOOR;
}
static double sunlight(hit h) {
    hit blocker;
    double facing = dot(h.n, unit(to_sun));

    return facing > 0 && first_hit(h.y, unit(to_sun), &blocker) == NOTHING ? sun * facing : 0;
}

// [drop]
// What the surface does to a path: the point moves from the entry to the exit. The result is what
// white Lambert is multiplied by there.
static vec scatter(int what, hit *at) {
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[2];

    if (what == FLOOR) return (vec){floor_albedo, floor_albedo, floor_albedo};
    sss_begin(&s, &wax[what], NULL, to_sss(at->y), to_sss(at->n), sss_hash(lookups++, 0));
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(what, o, dir, 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) {
            double hint = sun * greater(0, dot(hits[i].n, unit(to_sun))) + pi * sky;
            sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), (float)hint);
        }
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0};

    at->y = from_sss(e.position);
    at->n = from_sss(e.normal);
    return (vec){(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]};
}
// [/drop]

// [path]
static vec radiance(vec o, vec dir) {
    vec sum = {0, 0, 0}, weight = {1, 1, 1};

    for (int bounce = 0; bounce < 4; bounce++) {
        hit at;
        int what = first_hit(o, dir, &at);
        if (what == NOTHING) return add(sum, scale(mul(weight, (vec){0.8, 0.95, 1.25}), sky));

        weight = mul(weight, scatter(what, &at));
        sum = add(sum, scale(weight, sunlight(at) / pi));
        dir = unit(add(at.n, rnd_on_unit_sphere())); // as Lambert: cosine over pi cancels
        o = at.y;
    }
    return sum;
}
// [/path]

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 2, WIDTH, HEIGHT);

    for (int i = 0; i < BALLS; i++) {
        float r = (float)free_path[i], dmfp[3] = {r, 0.6f * r, 0.4f * r};
        sss_result result = sss_burley(&wax[i], albedo, dmfp);
        if (result != SSS_OK) return fprintf(stderr, "wax: %s\n", sss_result_string(result)), 1;
    }
    for (int panel = 0; panel < 2; panel++) {
        int paths = panel == 0 ? many : few;
        vec sum = {0, 0, 0};
        sheet_label(&s, panel, WIDTH / 2, -9, "%d paths a pixel", paths);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            vec seen = {0, 0, 0};
            for (int k = 0; k < paths; k++) {
                double u = (i % WIDTH + rnd()) / WIDTH - 0.5;
                double v = (HEIGHT / 2 - i / WIDTH - rnd()) / WIDTH;
                vec dir = unit((vec){u, v - 0.19, -1});
                seen = add(seen, scale(radiance(eye, dir), 1.0 / paths));
            }
            sheet_pixel(&s, panel, i % WIDTH, i / WIDTH, seen);
            sum = add(sum, scale(seen, 1.0 / (WIDTH * HEIGHT)));
        }
        printf("%d paths: mean of the picture %.3f\n", paths, mean(sum));
    }
    return sheet_end(&s);
}
