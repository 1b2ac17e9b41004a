// model_error.c - how far a flat profile and Lambert are off from the volume, and whether
// sss_plan_for knows it; and how a renderer may find the radius that it asks for. See --help.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#define COMMAND "model_error"
#include "demos/common/command.h"
#include "demos/common/tracer.h"
#include "model_bodies.h"

#define TOLERANCES 5

static const char usage[] =
    "usage: model_error [--quick] [--fit] OUT\n"
    "Draws random bodies, lights and media, and compares what a flat profile says with a random\n"
    "walk through the volume: a line for each case in OUT, for model_error.gp, and what\n"
    "sss_plan_for makes of them. Then Lambert, and ways to find the radius of curvature.\n"
    "  --quick  a tenth of the cases\n"
    "  --fit    also other constants of the plan's formula, on other cases\n";

static const double tolerance[TOLERANCES] = {0.5, 0.2, 0.1, 0.05, 0.02};
static const char *const kind_name[BODY_KINDS] = {"ball",     "slab", "cylinder",
                                                  "spheroid", "edge", "inside corner"};
static const char *const light_name[BODY_LIGHTS] = {"everywhere", "in front", "behind"};

// ---- The plan

typedef struct case_row {
    body_case c;
    double measured, error;
} case_row;

static sss_medium medium_of(const double albedo[3], const double dmfp[3]) {
    float a[3], d[3];
    sss_medium m;
    for (int i = 0; i < 3; i++) {
        a[i] = (float)albedo[i];
        d[i] = (float)dmfp[i];
    }
    sss_burley(&m, a, d);
    return m;
}

static sss_plan plan_of(const body_case *c, double tolerated) {
    sss_medium m = medium_of(c->albedo, c->dmfp);
    sss_need need;
    memset(&need, 0, sizeof need);
    need.curvature_radius = 1.0f;
    need.tolerance = (float)tolerated;
    return sss_plan_for(&m, &need);
}

// What the plan expects the profile to be off: the smallest tolerance that it uses it for.
static double predicted_error(const body_case *c) {
    double low = 1e-6, high = 1.0;
    while (high / low > 1.001) {
        double middle = sqrt(low * high);
        if (plan_of(c, middle).techniques == SSS_WALK) low = middle;
        else high = middle;
    }
    return high;
}

// Shares of cases with an error above the tolerance though the profile was chosen, and of cases
// with the volume though the profile would do. A case on the border counts by its likelihood.
typedef struct plan_rates {
    double missed, needless, cases;
} plan_rates;

static void count_choice(plan_rates *r, const case_row *row, double tolerated, int volume) {
    double z = (row->measured - tolerated) / fmax(row->error, 1e-9);
    double above = 0.5 * erfc(-z / sqrt(2.0));
    r->cases += 1.0;
    if (volume) r->needless += 1.0 - above;
    else r->missed += above;
}

static void print_rates(const char *name, plan_rates r) {
    printf("  %-22s %6.0f choices: %5.1f %% above the tolerance, %5.1f %% walked needlessly\n",
           name, r.cases, 100.0 * r.missed / r.cases, 100.0 * r.needless / r.cases);
}

static case_row *measure_cases(uint64_t first, int count) {
    case_row *row = malloc((size_t)count * sizeof *row);
    int done = 0;
    double start = now();
    if (!row) fail(1, "out of memory");
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < count; i++) {
        uint64_t seed = first + (uint64_t)i;
        row[i].c = body_random_case(seed);
        row[i].measured =
            body_case_error(&row[i].c, seed, 0.002, tolerance, TOLERANCES, &row[i].error);
#pragma omp critical
        if (++done % 10 == 0)
            fprintf(stderr, "\r%d of %d cases, %.0f s left ", done, count,
                    (now() - start) * (count - done) / done);
    }
    fputc('\n', stderr);
    return row;
}

static void write_cases(FILE *f, const case_row *row, int count) {
    fprintf(f, "# kind, light, predicted error, measured, its standard error\n");
    for (int kind = 0; kind < BODY_KINDS; kind++) {
        for (int i = 0; i < count; i++) {
            if (row[i].c.kind != kind) continue;
            fprintf(f, "%d %d %.4g %.4g %.2g\n", kind, row[i].c.light_kind,
                    predicted_error(&row[i].c), row[i].measured, row[i].error);
        }
        fprintf(f, "\n\n");
    }
}

static void report_plan(const case_row *row, int count) {
    plan_rates by_tolerance[TOLERANCES], by_kind[BODY_KINDS], by_light[BODY_LIGHTS];
    plan_rates all = {0.0, 0.0, 0.0};
    memset(by_tolerance, 0, sizeof by_tolerance);
    memset(by_kind, 0, sizeof by_kind);
    memset(by_light, 0, sizeof by_light);
    const case_row *worst = NULL;
    int tenth = 0, half = 0;
    for (int i = 0; i < count; i++) {
        const case_row *r = &row[i];
        tenth += r->measured > 0.1;
        half += r->measured > 0.5;
        for (int t = 0; t < TOLERANCES; t++) {
            int volume = plan_of(&r->c, tolerance[t]).techniques == SSS_WALK;
            count_choice(&by_tolerance[t], r, tolerance[t], volume);
            count_choice(&by_kind[r->c.kind], r, tolerance[t], volume);
            count_choice(&by_light[r->c.light_kind], r, tolerance[t], volume);
            count_choice(&all, r, tolerance[t], volume);
            if (tolerance[t] == 0.1 && !volume && (!worst || r->measured > worst->measured))
                worst = r;
        }
    }
    printf("The profile is off by more than 10 %% in %.0f %%, by more than 50 %% in %.0f %% of %d "
           "cases.\n",
           100.0 * tenth / count, 100.0 * half / count, count);
    printf("The plan, on %d cases:\n", count);
    for (int t = 0; t < TOLERANCES; t++) {
        char name[32];
        snprintf(name, sizeof name, "tolerance %g", tolerance[t]);
        print_rates(name, by_tolerance[t]);
    }
    for (int k = 0; k < BODY_KINDS; k++) print_rates(kind_name[k], by_kind[k]);
    for (int l = 0; l < BODY_LIGHTS; l++) print_rates(light_name[l], by_light[l]);
    print_rates("all", all);
    if (worst)
        printf("  worst at tolerance 0.1: %s, light %s, albedo %.2f %.2f %.2f, "
               "radius %.2f %.2f %.2f dmfp: %.2f\n",
               kind_name[worst->c.kind], light_name[worst->c.light_kind], worst->c.albedo[0],
               worst->c.albedo[1], worst->c.albedo[2], 1.0 / worst->c.dmfp[0],
               1.0 / worst->c.dmfp[1], 1.0 / worst->c.dmfp[2], worst->measured);
}

// The formula 1 / (1 + u^power), u = factor radius / dmfp / max(1 - A, least), with other
// constants.
static void report_fit(const case_row *row, int count) {
    static const double power[] = {1.0, 1.25, 1.5}, least[] = {0.02, 0.05, 0.1};
    printf("On %d other cases: power, least and factor of the formula 1 / (1 + u^power),\n"
           "u = factor radius / dmfp / max(1 - A, least):\n",
           count);
    for (int p = 0; p < 3; p++) {
        for (int l = 0; l < 3; l++) {
            for (double factor = 0.6; factor < 1.3; factor += 0.2) {
                plan_rates rates = {0.0, 0.0, 0.0};
                char name[64];
                for (int i = 0; i < count; i++) {
                    double error = 0.0, light = 0.0;
                    for (int c = 0; c < 3; c++) {
                        double a = row[i].c.albedo[c];
                        double u = factor / row[i].c.dmfp[c] / fmax(1.0 - a, least[l]);
                        error += a / (1.0 + pow(u, power[p]));
                        light += a;
                    }
                    for (int t = 0; t < TOLERANCES; t++)
                        count_choice(&rates, &row[i], tolerance[t], error > tolerance[t] * light);
                }
                snprintf(name, sizeof name, "%.2f, %.2f, %.2f", power[p], least[l], factor);
                print_rates(name, rates);
            }
        }
    }
}

// ---- Lambert

// A pixel as wide as `footprint` about a point of a ball that a lamp lights, or of a plane half of
// which is in shadow. Points of the pixel at random; sum[0]: the walk; sum[1]: Lambert.
static void lambert_pixel(double radius, double footprint, double shadow, const body_light *light,
                          double albedo, double dmfp, int points, uint64_t *random,
                          body_sum sum[2]) {
    int ball = isfinite(radius);
    double k = 1.0 / radius;
    body_solid b = ball ? body_quadric(k, k, k) : body_right_angle(0);
    body_volume v = body_volume_of(albedo, dmfp);
    b.shape[0].high[0] = (double)INFINITY;
    for (int i = 0; i < points; i++) {
        double x, y, square, weight, there = 0.0;
        body_vec at;
        int shape;
        body_disk(random, &x, &y, &square);
        x *= 0.5 * footprint;
        y *= 0.5 * footprint;
        b.entry = body_make(x, y, ball ? sqrt(radius * radius - x * x - y * y) : 0.0);
        if (ball) b.normal = body_unit(b.entry);
        double here = ball ? body_irradiance(&b, light, 0, b.entry) : x > shadow;
        if (body_walk(&b, &v, random, &at, &shape, &weight))
            there = ball ? body_irradiance(&b, light, 0, at) : at.x > shadow;
        body_add(&sum[0], there > 0.0 ? weight * there : 0.0);
        body_add(&sum[1], albedo * here);
    }
}

// One random pixel: footprint over r_max is .05 to 10, and a ball .5 to 50 pixels in radius.
// Measured like body_case_error.
static double lambert_error(uint64_t seed, double *footprint, double *radius, body_case *c,
                            double *deviation) {
    uint64_t random = seed << 32;
    body_light lamp;
    body_random_medium(c, &random);

    sss_medium m = medium_of(c->albedo, c->dmfp);
    int ball = body_random(&random) < 0.5, points = 2000;
    *footprint = 0.05 * pow(200.0, body_random(&random)) * (double)m.r_max;
    *radius = ball ? 0.5 * pow(100.0, body_random(&random)) * *footprint : (double)INFINITY;
    lamp.everywhere = body_random(&random) < 1.0 / 3.0;
    lamp.towards = body_isotropic(&random);
    double shadow = *footprint * (6.0 * body_random(&random) - 3.0);

    body_sum sum[3][2];
    double error, nearest;
    memset(sum, 0, sizeof sum);
    do {
        double light = 0.0, variance = 0.0;
        error = 0.0;
        for (int i = 0; i < 3; i++) {
            double a = c->albedo[i];
            lambert_pixel(*radius, *footprint, shadow, &lamp, a, c->dmfp[i], points, &random,
                          sum[i]);
            double walk = body_mean(&sum[i][0]), dark = fmax(walk, BODY_DARK * a);
            double own = a * hypot(body_error(&sum[i][0]), body_error(&sum[i][1])) / dark;
            error += a * fabs(body_mean(&sum[i][1]) - walk) / dark;
            variance += own * own;
            light += a;
        }
        error /= light;
        *deviation = sqrt(variance) / light;
        nearest = (double)INFINITY;
        for (int t = 0; t < TOLERANCES; t++) nearest = fmin(nearest, fabs(error - tolerance[t]));
        points *= 2;
    } while (points <= 1 << 16 && *deviation > nearest / 3.0);
    return error;
}

static void report_lambert(int count) {
    plan_rates rates[TOLERANCES];
    memset(rates, 0, sizeof rates);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < count; i++) {
        double footprint, radius;
        case_row row;
        row.measured =
            lambert_error((uint64_t)(3000000 + i), &footprint, &radius, &row.c, &row.error);
        sss_medium m = medium_of(row.c.albedo, row.c.dmfp);
        sss_need need;
        memset(&need, 0, sizeof need);
        need.footprint = (float)footprint;
        need.curvature_radius = isfinite(radius) ? (float)radius : 1e6f;
        for (int t = 0; t < TOLERANCES; t++) {
            need.tolerance = (float)tolerance[t];
            if (sss_plan_for(&m, &need).techniques != SSS_LAMBERT) continue;
#pragma omp critical
            count_choice(&rates[t], &row, tolerance[t], 0);
        }
    }
    printf("Lambert, on %d pixels of balls and of planes half in shadow:\n", count);
    for (int t = 0; t < TOLERANCES; t++)
        printf("  tolerance %-12g chosen for %5.1f %%, %4.1f %% of these above the tolerance\n",
               tolerance[t], 100.0 * rates[t].cases / count,
               100.0 * rates[t].missed / fmax(rates[t].cases, 1.0));
}

// ---- The radius

typedef struct radius_entry {
    sss_vec3 position, normal;
} radius_entry;

// Points that the camera sees, at random in the picture.
static void radius_entries(const scene *s, radius_entry *entry, int count) {
    tracer_random random = tracer_random_begin(11u, 0u, 0u);
    for (int n = 0; n < count;) {
        float x = tracer_next(&random), y = tracer_next(&random);
        sss_vec3 direction = tracer_camera(s, 1, 1, x, y);
        scene_hit hit = scene_nearest(s, s->eye, direction, SCENE_NOTHING);
        if (hit.shape < 0) continue;
        entry[n].position = scene_along(s->eye, direction, hit.t);
        entry[n].normal = scene_normal(&s->shape[hit.shape], entry[n].position);
        n++;
    }
}

// The largest ball that touches the surface at an entry holds no other point of the surface. So a
// point at `offset` from the entry bounds its radius: what curvature_radius asks for.
static float radius_bound(sss_vec3 normal, sss_vec3 offset) {
    float square = scene_dot(offset, offset), depth = scene_abs(scene_dot(normal, offset));
    return depth > 1e-6f * square ? 0.5f * square / depth : 1e6f;
}

// Over all crossings of a segment. Those nearer than 2e-3 are the entry itself.
static float radius_of_segment(const scene *s, const radius_entry *e, sss_vec3 origin,
                               sss_vec3 direction, float length) {
    float least = 1e6f;
    scene_hits hits;
    scene_segment_hits(s, origin, direction, length, &hits);
    for (int i = 0; i < hits.count; i++) {
        sss_vec3 y = scene_along(origin, direction, hits.hit[i].t);
        sss_vec3 offset = scene_sub(y, e->position);
        if (scene_dot(offset, offset) < 4e-6f) continue;
        least = scene_min(least, radius_bound(e->normal, offset));
    }
    return least;
}

enum { RADIUS_INWARD, RADIUS_FOUR, RADIUS_LOOKUP, RADIUS_LOOKUPS, RADIUS_WAYS };
static const char *const radius_name[RADIUS_WAYS] = {"one ray inwards", "four rays inwards",
                                                     "hits of 1 lookup", "hits of 8 lookups"};

// `rays` into the object: along the normal, and around it at 60 degrees.
static float radius_by_rays(const scene *s, const radius_entry *e, int rays) {
    float least = 1e6f;
    sss_vec3 in = scene_scale(e->normal, -1.0f);
    for (int i = 0; i < rays; i++) {
        float turn = (float)i / 3.0f;
        sss_vec3 d = i == 0 ? in : tracer_about(in, 0.5f, scene_sqrt(0.75f), turn);
        least = scene_min(least, radius_of_segment(s, e, e->position, d, 100.0f));
    }
    return least;
}

static float radius_by_lookups(const scene *s, const radius_entry *e, uint32_t seed, int lookups) {
    float least = 1e6f;
    for (int i = 0; i < lookups; i++) {
        sss_resampler r;
        sss_probe p;
        sss_begin(&r, &s->medium, NULL, e->position, e->normal, sss_hash(seed, (uint32_t)i));
        while (sss_next_probe(&r, &p))
            least = scene_min(least, radius_of_segment(s, e, p.origin, p.direction, p.length));
    }
    return least;
}

static float radius_true(const scene *s, const radius_entry *e, uint32_t seed) {
    float least = 1e6f;
    tracer_random random = tracer_random_begin(seed, 0u, 0u);
    for (int i = 0; i < 6000; i++) {
        float height = 2.0f * tracer_next(&random) - 1.0f;
        float side = scene_sqrt(scene_max(1.0f - height * height, 0.0f));
        sss_vec3 d = tracer_about(e->normal, height, side, tracer_next(&random));
        least = scene_min(least, radius_of_segment(s, e, e->position, d, 100.0f));
    }
    return least;
}

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// The estimates over the true radius. What one estimates is never too small, so all that can go
// wrong is a profile where the true radius leads to a volume: *wrong counts these choices.
static void radius_ratios(const scene *s, const radius_entry *e, uint32_t seed,
                          float ratio[RADIUS_WAYS], int wrong[RADIUS_WAYS]) {
    float truth = radius_true(s, e, seed);
    ratio[RADIUS_INWARD] = radius_by_rays(s, e, 1) / truth;
    ratio[RADIUS_FOUR] = radius_by_rays(s, e, 4) / truth;
    ratio[RADIUS_LOOKUP] = radius_by_lookups(s, e, seed, 1) / truth;
    ratio[RADIUS_LOOKUPS] = radius_by_lookups(s, e, seed, 8) / truth;

    for (int t = 0; t < TOLERANCES; t++) {
        sss_need need;
        memset(&need, 0, sizeof need);
        need.tolerance = (float)tolerance[t];
        need.curvature_radius = truth;
        if (sss_plan_for(&s->medium, &need).techniques != SSS_WALK) continue;
        for (int w = 0; w < RADIUS_WAYS; w++) {
            need.curvature_radius = truth * ratio[w];
            wrong[w] += sss_plan_for(&s->medium, &need).techniques != SSS_WALK;
        }
    }
}

static void report_radius(int which, int entries) {
    static scene s;
    scenes_optics optics = scenes_make(&s, which);
    const char *name = scenes_known[which].name;
    int wrong[RADIUS_WAYS] = {0};
    float(*ratio)[RADIUS_WAYS] = malloc((size_t)entries * sizeof *ratio);
    float *sorted = malloc((size_t)entries * sizeof *sorted);
    radius_entry *entry = malloc((size_t)entries * sizeof *entry);
    if (!ratio || !sorted || !entry) fail(1, "out of memory");
    sss_burley(&s.medium, optics.albedo, optics.dmfp);
    radius_entries(&s, entry, entries);
    for (int i = 0; i < entries; i++) radius_ratios(&s, &entry[i], (uint32_t)i, ratio[i], wrong);

    for (int w = 0; w < RADIUS_WAYS; w++) {
        for (int i = 0; i < entries; i++) sorted[i] = ratio[i][w];
        qsort(sorted, (size_t)entries, sizeof *sorted, compare_floats);
        printf("  %-8s %-18s median %5.2f, 90 %% below %6.2f; %4.1f %% wrong\n", name,
               radius_name[w], (double)sorted[entries / 2], (double)sorted[entries * 9 / 10],
               100.0 * wrong[w] / (TOLERANCES * entries));
    }
    free(ratio);
    free(sorted);
    free(entry);
}

static void report_radii(int entries) {
    printf("The radius on %d entries of each scene: the estimate over the true radius, and how\n"
           "often it leads to a profile where the true one leads to a volume:\n",
           entries);
    for (int k = 0; k < SCENES; k++) report_radius(k, entries);
}

int main(int argc, char **argv) {
    const char *out = NULL;
    int quick = 0, fit = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) return fputs(usage, stdout) < 0;
        if (strcmp(argv[i], "--quick") == 0) quick = 1;
        else if (strcmp(argv[i], "--fit") == 0) fit = 1;
        else if (argv[i][0] == '-' || out)
            fail(2, "unknown word '%s'; --help lists what there is", argv[i]);
        else out = argv[i];
    }
    if (!out) fail(2, "wants OUT; --help says what it is");

    FILE *f = fopen(out, "w");
    if (!f) fail(2, "cannot write %s: %s", out, strerror(errno));
    int count = quick ? 60 : 600;
    case_row *held_out = measure_cases(1000000, count);
    write_cases(f, held_out, count);
    if (fclose(f)) fail(1, "cannot write %s: %s", out, strerror(errno));
    report_plan(held_out, count);
    free(held_out);

    if (fit) {
        case_row *fitted = measure_cases(1, 2 * count);
        report_fit(fitted, 2 * count);
        free(fitted);
    }
    report_lambert(quick ? 60 : 600);
    report_radii(quick ? 100 : 400);
    return 0;
}
