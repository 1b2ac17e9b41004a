// plan - as little as the scene needs. Chapter 15 of the tutorial; SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "tutorial/tutorial.h"

// Change these and see what happens.
enum { BALLS = 4, SIDE = 240, VIEW = 2 };
static const double free_path[BALLS] = {0.001, 0.1, 0.4, 2}; // dmfp of red
static const float albedo[3] = {0.8f, 0.55f, 0.4f};
static const double tolerance = 0.1;  // relative error of the model that is good enough
static const double shading_cost = 10;// of shading an exit, over that of tracing a probe
static const vec to_sun = {-0.8, 0.5, 0.2};
static const double sun = 5, sky = 0.4;
static const int few = 16; // lookups for each pixel

static const double radius = 0.9;
static sss_medium wax[BALLS];
static sss_plan plan[BALLS], standard = {0};
static uint32_t lookups = 0;
static long probes = 0;

static sss_vec3 to_sss(vec v) { return (sss_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static vec from_sss(sss_vec3 v) { return (vec){(double)v.x, (double)v.y, (double)v.z}; }

static int all_hits(vec o, vec dir, double t0, double t1, hit *hits) {
    double b = dot(o, dir), rest = b * b - dot(o, o) + radius * radius;
    int count = 0;

    for (int side = -1; side <= 1 && rest > 0; side += 2) {
        double t = -b + side * sqrt(rest);
        vec y = along(o, dir, t);
        if (t < t0 || t > t1) continue;
        hits[count++] = (hit){t, y, unit(y)};
    }
    return count;
}
static double irradiance(vec n) { return sun * greater(0, dot(n, unit(to_sun))) + sky; }

// [plan]
static sss_plan choose(const sss_medium *m, double good_enough) {
    sss_need need = {0};

    need.footprint = (float)VIEW / SIDE;     // width of a pixel on the surface
    need.curvature_radius = (float)radius;   // half the thickness, for thin objects
    need.shading_cost = (float)shading_cost; // over that of a probe
    need.tolerance = (float)good_enough;     // of the model, not of the noise
    need.hinted = 1;                         // we shall give light hints
    return sss_plan_for(m, &need);
}
// [/plan]

static const char *model(const sss_plan *p) {
    if (p->techniques == SSS_LAMBERT) return "Lambert";
    if (p->techniques == SSS_DISK) return "one disk";
    return p->techniques == SSS_WALK ? "walk" : "resampling";
}

// [lookup]
static vec exitance(int i, hit entry, const sss_plan *by) {
    sss_resampler s;
    sss_probe p;
    sss_exit e[SSS_MAX_EXITS];
    hit hits[2];
    vec sum = {0, 0, 0};

    sss_begin(&s, &wax[i], by, to_sss(entry.y), to_sss(entry.n), sss_hash(lookups++, 0));
    while (sss_next_probe(&s, &p)) {
        vec o = from_sss(p.origin), dir = from_sss(p.direction);
        int count = all_hits(o, dir, 0, (double)p.length, hits);
        for (int k = 0; k < count; k++) {
            float hint = (float)irradiance(hits[k].n);
            sss_add_hit(&s, to_sss(hits[k].y), to_sss(hits[k].n), hint);
        }
        probes++;
    }
    int found = sss_finish(&s, e);
    for (int k = 0; k < found; k++) {
        vec weight = {(double)e[k].weight[0], (double)e[k].weight[1], (double)e[k].weight[2]};
        sum = add(sum, scale(weight, irradiance(from_sss(e[k].normal))));
    }
    return sum;
}
// [/lookup]

static void draw(sheet *s, int i) {
    sheet_title(s, i, model(&plan[i]));
    for (int k = 0; k < SIDE * SIDE; k++) {
        vec sum = {0, 0, 0};
        for (int n = 0; n < few; n++) {
            hit hits[2];
            double u = (k % SIDE + rnd()) / SIDE - 0.5, v = 0.5 - (k / SIDE + rnd()) / SIDE;
            int count = all_hits((vec){VIEW * u, VIEW * v, 9}, (vec){0, 0, -1}, 0, 99, hits);
            vec seen = background;
            if (count) seen = scale(exitance(i, hits[0], &plan[i]), 1 / pi);
            sum = add(sum, scale(seen, 1.0 / few));
        }
        sheet_pixel(s, i, k % SIDE, k / SIDE, sum);
    }
}
// The mean, and the relative variance of one lookup, all over ball i.
static void print_plan(const char *name, int i, const sss_plan *by) {
    double squares = 0, products = 0, sum = 0, n = 10000;

    probes = lookups = 0;
    for (int k = 0; k < n; k++) {
        vec up = rnd_on_unit_sphere();
        hit entry = {0, scale(up, radius), up};
        double a = mean(exitance(i, entry, by)), b = mean(exitance(i, entry, by));
        squares += (a - b) * (a - b) / 2;
        products += a * b;
        sum += (a + b) / 2;
    }
    printf("  %s: %s, probes %.1f, mean %.2f, relative variance %.3f\n", name, model(by),
           (double)probes / lookups, sum / n, squares / products);
}

int main(int argc, char **argv) {
    sheet s = sheet_begin(argc, argv, BALLS, SIDE, SIDE);

    for (int i = 0; i < BALLS; i++) {
        float r = (float)free_path[i], dmfp[3] = {r, 0.6f * r, 0.4f * r};
        sss_result result = sss_burley(&wax[i], albedo, dmfp);
        if (result != SSS_OK) return fprintf(stderr, "wax: %s\n", sss_result_string(result)), 1;

        sss_plan strict = choose(&wax[i], 0.01), lax = choose(&wax[i], 0.4);
        plan[i] = choose(&wax[i], tolerance);
        draw(&s, i);
        printf("ball %d, dmfp %g: tolerance 0.01 %s, 0.1 %s, 0.4 %s; tile %d, per_channel %d\n",
               i + 1, free_path[i], model(&strict), model(&plan[i]), model(&lax), plan[i].tile,
               plan[i].per_channel);
        print_plan("planned", i, &plan[i]);
        print_plan("default", i, &standard);
    }
    return sheet_end(&s);
}
