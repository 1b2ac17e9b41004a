// least - as little as the scene needs: a path tracer with the header. Chapter 10 of the tutorial.
// SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/tutorial.h"

// Change these and see what happens.
enum { BALLS = 4, WIDTH = 600, HEIGHT = 220 };
static const double free_path[BALLS] = {0.002, 0.2, 0.5, 6}; // dmfp of red; green has 0.6 of it, blue 0.4
static const float albedo[3] = {0.8f, 0.55f, 0.4f};
static const double shading_cost = 1; // of shading a point, over that of tracing a probe
static const vec to_sun = {-0.8, 0.7, 0.3};
static const double sun = 4, sky = 0.35; // irradiance on what faces the sun; radiance of the sky
static const double floor_albedo = 0.5;
static const int samples = 8; // for each pixel

enum { NOTHING = -2, FLOOR = -1 }; // in place of the number of a ball
static const double radius = 0.9;
static const vec eye = {0, 2.6, 9};
static sss_medium wax[BALLS];
static sss_plan plan[BALLS];
static long probes, lookups;

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }
static vec centre(int i) { return (vec){2.1 * i - 3.15, radius, 0}; }

// Where the line meets ball i, t within t0..t1: up to two hits.
static int all_hits(int i, vec o, vec w, double t0, double t1, hit *hits) {
    vec from = sub(o, centre(i));
    double b = dot(from, w), rest = b * b - dot(from, from) + radius * radius, root = rest > 0 ? sqrt(rest) : 0;
    int count = 0;
    for (int side = -1; side <= 1 && rest > 0; side += 2) {
        double t = -b + side * root;
        vec y = along(o, w, t);
        if (t >= t0 && t <= t1) hits[count++] = (hit){t, y, scale(sub(y, centre(i)), 1 / radius)};
    }
    return count;
}
// What a ray meets first.
static int first_hit(vec o, vec w, hit *first) {
    hit hits[2];
    int what = NOTHING;
    first->t = far_away;
    for (int i = 0; i < BALLS; i++)
        if (all_hits(i, o, w, 1e-4, first->t, hits)) *first = hits[0], what = i;
    double t = -o.y / w.y;
    if (t > 1e-4 && t < first->t) *first = (hit){t, along(o, w, t), {0, 1, 0}}, what = FLOOR;
    return what;
}
static double sunlight(hit h) {
    hit blocker;
    double facing = dot(h.n, unit(to_sun));
    return facing > 0 && first_hit(h.y, unit(to_sun), &blocker) == NOTHING ? sun * facing : 0;
}

// [drop]
// What the surface does to a path: the point moves, and the weight is what white Lambert is multiplied by there.
static vec scatter(int what, hit *at, const sss_plan *use) {
    sss_resampler s;
    sss_probe p;
    sss_exit e;
    hit hits[2];
    if (what == FLOOR) return (vec){floor_albedo, floor_albedo, floor_albedo};
    sss_begin(&s, &wax[what], use ? use : &plan[what], to_sss(at->y), to_sss(at->n), (uint32_t)lookups++);
    while (sss_next_probe(&s, &p)) {
        int count = all_hits(what, from_sss(p.origin), from_sss(p.direction), 0, (double)p.length, hits);
        for (int i = 0; i < count; i++) sss_add_hit(&s, to_sss(hits[i].y), to_sss(hits[i].n), 1);
        probes++;
    }
    if (!sss_finish(&s, &e)) return (vec){0, 0, 0};
    at->y = from_sss(e.position);
    at->n = from_sss(e.normal);
    return (vec){(double)e.weight[0], (double)e.weight[1], (double)e.weight[2]};
}
// [/drop]

// [path]
static vec radiance(vec o, vec w) {
    vec sum = {0, 0, 0}, weight = {1, 1, 1}, sky_here = {sky * 0.8, sky * 0.95, sky * 1.25};
    for (int bounce = 0; bounce < 4; bounce++) {
        hit at;
        int what = first_hit(o, w, &at);
        if (what == NOTHING) return add(sum, mul(weight, sky_here));
        weight = mul(weight, scatter(what, &at, NULL));
        sum = add(sum, scale(weight, sunlight(at) / pi));
        w = unit(add(at.n, rnd_on_unit_sphere())); // cosine-distributed, so a white Lambert surface cancels
        o = at.y;
    }
    return sum;
}
// [/path]

// [plan]
static void choose_plans(void) {
    sss_need need = {9.0f / WIDTH, (float)radius, (float)shading_cost, 0, 0}; // a pixel is 9 / WIDTH wide where the balls are
    for (int i = 0; i < BALLS; i++) {
        float r = (float)free_path[i], dmfp[3] = {r, 0.6f * r, 0.4f * r};
        sss_result result = sss_burley(&wax[i], albedo, dmfp);
        if (result != SSS_OK) fprintf(stderr, "ball %d: %s\n", i, sss_result_string(result)), exit(1);
        plan[i] = sss_plan_for(&wax[i], &need);
    }
}
// [/plan]

// Relative variance of one shaded point where the sun shines on ball i, from two lookups at each of many places.
static double variance(int i, const sss_plan *use) {
    double sum = 0, power = 0;
    for (int k = 0; k < 20000; k++) {
        vec n = unit(add(unit(to_sun), rnd_on_unit_sphere()));
        hit a = {0, along(centre(i), n, radius), n}, b = a;
        double x = mean(scatter(i, &a, use)) * (sunlight(a) + sky), y = mean(scatter(i, &b, use)) * (sunlight(b) + sky);
        sum += (x - y) * (x - y) / 2;
        power += x * y;
    }
    return sum / power;
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, 1, WIDTH, HEIGHT);
    static const sss_plan standard = {0};
    choose_plans();
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        vec sum = {0, 0, 0};
        for (int k = 0; k < samples; k++) {
            double u = (i % WIDTH + rnd()) / WIDTH - 0.5, v = (HEIGHT / 2 - i / WIDTH - rnd()) / WIDTH;
            sum = add(sum, scale(radiance(eye, unit((vec){u, v - 0.19, -1})), 1.0 / samples));
        }
        sheet_pixel(&s, 0, i % WIDTH, i / WIDTH, sum);
    }
    printf("probes for each lookup: %.1f\n", (double)probes / (double)lookups);
    for (int i = 0; i < BALLS; i++) {
        const char *name = plan[i].techniques == SSS_DISK ? "one disk" : "default mix";
        double kept = (double)sss_within(&wax[i], 0, 2 * (float)radius) / (double)albedo[0];
        double least = variance(i, NULL), by_default = variance(i, &standard);
        if (plan[i].techniques == SSS_LAMBERT) name = "Lambert";
        if (plan[i].techniques == SSS_WALK) name = "volume";
        sheet_text(&s, 0, 34 + 142 * i, -9, "%s", name);
        printf("ball %d: %s, M = %d, red light kept %.2f, relative variance %.3f, by default %.3f\n", i + 1, name,
               plan[i].candidates, kept, least, by_default);
    }
    return sheet_end(&s);
}
