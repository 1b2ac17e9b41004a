// failures.c - ten ways to sample subsurface scattering that fail, each beside what the header
// does, by measurement: pictures, data for failures.gp, a page of HTML, and the figures as a table.
// See --help. SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700
#define COMMAND       "failures"
#include <stdarg.h>

#include "demos/common/command.h"
#include "demos/common/files.h"
#include "demos/common/tracer.h"

#define BLOCKS 64

static const char usage[] = "usage: failures [--quick] OUT\n"
                            "Measures ten classical failures and the header beside them. Writes "
                            "OUT.html, the pictures OUT-*.png and what\n"
                            "failures.gp draws the rest from; prints what was measured as a table. "
                            "--quick: fewer samples, smaller pictures.\n";

static const char *out;
static int quick;

// ---- Ten panels: what is wrong, and a line below each half

typedef struct panel {
    const char *name, *title, *how; // how: what is done wrongly, and what the header does
    char left[100], right[100];
} panel;

enum { EDGE, HITS, RETRY, REACH, COLOURS, WALL, HAIR, SLAB, BUMPS, FLOATS, PANELS };
static panel panels[PANELS] = {
    {"edge", "A disk probe along the normal is blind to faces along that normal",
     "Probes about the normal alone never meet the other face of an edge: the light that would "
     "leave there is lost, "
     "and since nothing is noisy the picture looks converged. Chords meet every face alike. The "
     "figures are for even "
     "light, 0.2 d from the edge.",
     "", ""},
    {"hits", "Dividing by hits instead of probes",
     "The sum of the candidates' weights has to be divided by the probes that were sent. Divided "
     "by the hits that were "
     "found it is biased, by an amount that depends on the shape and that more candidates do not "
     "take away. Figures "
     "for plane, sphere and plates at M = 8.",
     "", ""},
    {"retry", "Trying again until a probe hits",
     "No hit is a fair sample of zero. On a small body most probes miss; a renderer that draws "
     "again until one hits "
     "makes small things glow.",
     "", ""},
    {"reach", "A reach that suits one colour",
     "White wax whose red light travels ten times as far as the green. Probes that end at 16 "
     "lengths of the green "
     "channel lose the red light beyond: the wax turns cyan. The header's reach is that of the "
     "widest channel, and "
     "chords have no end.",
     "", ""},
    {"colours", "Radii drawn for one colour",
     "The same wax, both resampled, left with radii drawn from the blue channel's profile alone. "
     "The mean is right, "
     "but the variance of red is infinite, as its profile is more than twice as wide as the "
     "density that should find "
     "it. So most of the picture lacks red and a few dots have it all. The header draws from all "
     "channels and weighs "
     "by their mixture. The figures are the largest weight of a lookup over the albedo.",
     "", ""},
    {"wall", "A pick without a light hint",
     "A pane with the lamp behind it. Resampling by the profile alone picks points next to the "
     "entry, which are dark. "
     "A guess of the light at each candidate, without a ray, moves the pick to the lit side; the "
     "mean stays. The "
     "figures are for the pixel in the middle.",
     "", ""},
    {"hair", "Weights without a bound",
     "A hair of radius d / 10. Where its side turns along the only axis of the probes, the density "
     "goes to zero and "
     "the weight to infinity: the largest weight grows with the number of lookups for ever. With "
     "chords in the mix no "
     "weight exceeds the bound.",
     "", ""},
    {"slab", "A depth that meets the far side",
     "Sphere probes pass through a point at depth h. Where a slab is as thick as that, all of them "
     "meet its far side "
     "in that very point, and the rest of the far side, a good part of the light, is missed. Other "
     "techniques in the "
     "mix see it.",
     "", ""},
    {"bumps", "Shading normals in the density",
     "A sphere with a bump map; the light is even along the true surface, so the picture should be "
     "smooth. The density "
     "counts crossings of the true surface: given shading normals, probes along the tangents seem "
     "likely where there "
     "are none. Pass the geometric normal, and keep the shading normal for shading.",
     "", ""},
    {"floats", "Single precision where two waves cancel",
     "The better dipole subtracts two waves that are nearly equal far from the entry. As the "
     "formula is written, "
     "32-bit floats lose one digit after the other and then all of them; the header rearranges it.",
     "", ""},
};

// What stands above the halves: a format each for a figure and its standard error, which it may
// leave out.
#define PLUS_MINUS " \302\261 "
static void name_halves(int which, const char *left, double a, double a_error, const char *right,
                        double b, double b_error) {
    snprintf(panels[which].left, sizeof panels[which].left, left, a, a_error);
    snprintf(panels[which].right, sizeof panels[which].right, right, b, b_error);
}

// One line of the table. kind is "mean" or "noise", which are compared with `truth` by their
// errors, or "exact".
static void claim(int which, const char *side, const char *kind, double value, double error,
                  double truth, double truth_error) {
    double spread = hypot(error, truth_error);
    printf("%s,%s,%s,%.6g,%.2g,%.6g,%.2g,%.2f\n", panels[which].name, side, kind, value, error,
           truth, truth_error,
           (value - truth) /
               fmax(spread, 1e-6 * fabs(truth))); // float sums are no nearer than that
}

static FILE *open_file(const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s%s", out, name);
    FILE *f = fopen(path, "w");
    if (!f) fail(2, "cannot write %s: %s", path, strerror(errno));
    return f;
}
static void close_file(FILE *f, const char *name) {
    if (ferror(f) | fclose(f)) fail(1, "cannot write %s%s to the end", out, name);
}

// ---- Estimators: the header, used rightly or with one flaw

enum { SOUND, BY_HITS, RETRIES, SHORT_REACH, BY_BLUE, BUMPED };
typedef struct method {
    unsigned techniques;
    int flaw, candidates;
    float reach; // with SHORT_REACH
} method;

static const method ours = {0u, SOUND, 8, 0.0f}, one_probe = {0u, SOUND, 1, 0.0f};

// Even light of 1, or with `lit` light from one side, by the true normal.
static double light_at(const scene *s, sss_vec3 x, int lit) {
    sss_vec3 n = scene_normal(&s->shape[scene_shape_at(s, x)], x);
    return lit ? 0.35 + 0.65 * (double)scene_max(scene_dot(n, scene_vec(-0.48f, 0.8f, 0.36f)), 0.0f)
               : 1.0;
}
static sss_vec3 normal_at(const scene *s, const method *k, int shape, sss_vec3 x) {
    sss_vec3 n = scene_normal(&s->shape[shape], x);
    if (k->flaw != BUMPED) return n;
    return scene_normalize(
        scene_along(n, scene_vec(sinf(13.0f * x.x), sinf(13.0f * x.y), sinf(13.0f * x.z)), 0.15f));
}
// One lookup: the estimate of the integral of Rd E for each channel.
static void look_up(const scene *s, const method *k, tracer_point at, int lit, uint32_t seed,
                    double value[3]) {
    sss_plan plan = {k->candidates, 1, k->techniques, 0, 0, 0};
    sss_medium medium = s->medium;
    sss_resampler r;
    sss_probe probe;
    sss_exit exit;
    scene_hits hits;
    int found = 0, exits = 0;
    if (k->flaw == SHORT_REACH) medium.r_max = k->reach;
    value[0] = value[1] = value[2] = 0.0;
    for (uint32_t attempt = 0;
         attempt == 0u || (k->flaw == RETRIES && exits == 0 && attempt < 100000u); attempt++) {
        sss_begin(&r, &medium, &plan, at.position, at.normal,
                  attempt ? sss_hash(seed, attempt) : seed);
        while (sss_next_probe(&r, &probe)) {
            scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
            found += hits.count;
            for (int i = 0; i < hits.count; i++) {
                sss_vec3 x = scene_along(probe.origin, probe.direction, hits.hit[i].t);
                sss_add_hit(&r, x, normal_at(s, k, hits.hit[i].shape, x), 1.0f);
            }
        }
        exits = sss_finish(&r, &exit);
    }
    if (exits == 0) return;
    double light = light_at(s, exit.position, lit) *
                   (k->flaw == BY_HITS ? (double)k->candidates / found : 1.0);
    for (int c = 0; c < 3; c++) value[c] = (double)exit.weight[c] * light;
}
// The same with the memo's resampling, of candidates whose radii are all drawn for the last
// channel.
static void look_up_by_blue(const scene *s, const method *k, tracer_point at, int lit,
                            uint32_t seed, double value[3]) {
    sss_plan plan = {k->candidates, 1, k->techniques, 0, 0, 0};
    sss_medium medium = s->medium;
    sss_resampler r;
    sss_probe probe;
    scene_hits hits;
    double sum = 0.0, rd[3], held[3] = {0.0, 0.0, 0.0}; // Rd E over g of the hit that is held
    medium.albedo[0] = medium.albedo[1] = 0.0f;
    sss_begin(&r, &medium, &plan, at.position, at.normal, seed);
    for (uint32_t number = 1; sss_next_probe(&r, &probe);) {
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++, number++) {
            sss_vec3 x = scene_along(probe.origin, probe.direction, hits.hit[i].t),
                     way = scene_sub(x, at.position);
            double mu =
                (double)sss_intensity(&r, x, normal_at(s, k, hits.hit[i].shape, x)) * k->candidates;
            for (int c = 0; c < 3; c++)
                rd[c] = (double)sss_profile(&s->medium, c, sqrtf(scene_dot(way, way)));
            double g = rd[0] + rd[1] + rd[2]; // the albedos are alike
            if (!(mu > 0.0)) continue;
            sum += g / mu;
            if ((double)tracer_unit(sss_hash(seed, 0x90000000u + number)) * sum >= g / mu) continue;
            for (int c = 0; c < 3; c++) held[c] = rd[c] / g * light_at(s, x, lit);
        }
    }
    for (int c = 0; c < 3; c++) value[c] = held[c] * sum;
}
static void estimate(const scene *s, const method *k, tracer_point at, int lit, uint32_t seed,
                     double value[3]) {
    (k->flaw == BY_BLUE ? look_up_by_blue : look_up)(s, k, at, lit, seed, value);
}

// Many of them: mean and relative variance of one channel, with their standard errors from blocks.
typedef struct tally {
    double mean, error, noise, noise_error, greatest;
} tally;

static tally tally_values(const double *values, int lookups) {
    tally t = {0.0, 0.0, 0.0, 0.0, 0.0};
    double squares = 0.0, variance[BLOCKS], spread = 0.0;
    int each = lookups / BLOCKS;
    for (int b = 0; b < BLOCKS; b++) {
        double sum = 0.0, sum2 = 0.0;
        for (int i = b * each; i < (b + 1) * each; i++) {
            sum += values[i];
            sum2 += values[i] * values[i];
            t.greatest = fmax(t.greatest, values[i]);
        }
        variance[b] = (sum2 - sum * sum / each) / (each - 1);
        t.mean += sum / (each * BLOCKS);
        squares += sum * sum / ((double)each * each);
        t.noise += variance[b] / BLOCKS;
    }
    for (int b = 0; b < BLOCKS; b++) spread += (variance[b] - t.noise) * (variance[b] - t.noise);
    t.error = sqrt(fmax(squares / BLOCKS - t.mean * t.mean, 0.0) / (BLOCKS - 1));
    t.noise /= t.mean * t.mean;
    t.noise_error = sqrt(spread / BLOCKS / (BLOCKS - 1)) / (t.mean * t.mean);
    return t;
}
// The values themselves; the caller frees them.
static double *draw_values(const scene *s, const method *k, tracer_point at, int channel,
                           uint32_t key, int lookups) {
    double *values = (double *)malloc((size_t)lookups * sizeof *values);
    if (!values) fail(1, "out of memory");
#pragma omp parallel for schedule(dynamic, 256)
    for (int i = 0; i < lookups; i++) {
        double value[3];
        estimate(s, k, at, 0, sss_hash(key, (uint32_t)i), value);
        values[i] = value[channel];
    }
    return values;
}
static tally measure(const scene *s, const method *k, tracer_point at, int channel, uint32_t key,
                     int lookups) {
    double *values = draw_values(s, k, at, channel, key, lookups);
    tally t = tally_values(values, lookups);
    free(values);
    return t;
}
static int lookups_of(int many) { return quick ? many / 16 : many; }

// ---- Bodies; lengths in units of d where nothing else is said

// Burley's profile with these d.
static void set_medium(scene *s, float red, float green, float blue) {
    const float albedo[3] = {0.8f, 0.8f, 0.8f}, one[3] = {1.0f, 1.0f, 1.0f};
    float dmfp[3] = {red, green, blue};
    sss_burley(&s->medium, albedo, one);
    float unit = s->medium.length[0]; // d of a dmfp of 1
    for (int c = 0; c < 3; c++) dmfp[c] /= unit;
    if (sss_burley(&s->medium, albedo, dmfp) != SSS_OK) fail(1, "a medium is refused");
}
// Entries are on top of shape 0, to one side by `aside`.
static tracer_point entry_on(const scene *s, float aside) {
    tracer_point p;
    p.position = scene_add(s->shape[0].center, scene_vec(aside, s->shape[0].extent.y, 0.0f));
    p.normal = scene_vec(0.0f, 1.0f, 0.0f);
    p.weight = p.normal;
    p.shape = 0;
    return p;
}
static tracer_point make_round(scene *s, float x, float y, float z) {
    memset(s, 0, sizeof *s);
    scenes_ellipsoid(s, scene_vec(0.0f, 0.0f, 0.0f), scene_vec(x, y, z),
                     scene_vec(0.0f, 0.0f, 0.0f));
    set_medium(s, 1.0f, 1.0f, 1.0f);
    return entry_on(s, 0.0f);
}
#define WIDE 40.0f // no light comes back from there
// Plates of thickness t, and as far apart, under the plane of the entry.
static tracer_point make_plates(scene *s, int plates, float t) {
    memset(s, 0, sizeof *s);
    for (int i = 0; i < plates; i++)
        scenes_shape(s, scene_vec(0.0f, -(2.0f * (float)i + 0.5f) * t, 0.0f),
                     scene_vec(WIDE, 0.5f * t, WIDE), 1e-3f * t, scene_vec(0.0f, 0.0f, 0.0f));
    set_medium(s, 1.0f, 1.0f, 1.0f);
    return entry_on(s, 0.0f);
}

// ---- The truth for an even light, from closed forms in at most two dimensions

static double albedo_of(const scene *s) { return (double)sss_within(&s->medium, 0, FLT_MAX); }

static double beyond(const scene *s,
                     double r) { // the integral of Rd over a whole plane at distance r
    return albedo_of(s) - (double)sss_within(&s->medium, 0, (float)r);
}
static double truth_plates(const scene *s, int plates, double t) {
    double sum = 0.0;
    for (int i = 0; i < 2 * plates; i++) sum += beyond(s, i * t);
    return sum;
}
static double truth_sphere(const scene *s, double radius) {
    return (double)sss_within(&s->medium, 0, (float)(2.0 * radius));
}
// A right-angled edge at distance a: the plane but for what lies beyond the edge, and half of the
// plane at distance a.
static double truth_edge(const scene *s, double a) {
    double lost = 0.0, step = 1e-3;
    for (double x = 0.5 * step; x < 6.5; x += step) { // r = a + x^2
        double r = a + x * x;
        lost +=
            step * 2.0 * x * 2.0 * r * (double)sss_profile(&s->medium, 0, (float)r) * acos(a / r);
    }
    return albedo_of(s) - lost + 0.5 * beyond(s, a);
}
// A cylinder: around it by theta = x^2, along it by y = c sinh u, c the chord across; Rd has a pole
// of 1 / r.
static double truth_hair(const scene *s, double radius) {
    double sum = 0.0, step = 1.0 / 256, end = sqrt((double)SCENE_PI);
    for (int i = 0; i < 256; i++) {
        double x = (i + 0.5) * step * end, c = 2.0 * radius * sin(0.5 * x * x), along = 0.0;
        for (double u = 0.5 * step; c * sinh(u) < 60.0; u += step) {
            double r = c * cosh(u);
            along += step * r * (double)sss_profile(&s->medium, 0, (float)r);
        }
        sum += 2.0 * x * step * end * 2.0 * along * 2.0 * radius;
    }
    return sum;
}

// ---- Pictures

static void write_picture(const image *in, int which, const char *side, float exposure) {
    char path[1024];
    image_bytes bytes;
    if (image_bytes_new(&bytes, in->width, in->height, 0)) fail(1, "out of memory");
    image_blit(&bytes, in, exposure, 0, 0);
    snprintf(path, sizeof path, "%s-%s-%s.png", out, panels[which].name, side);
    const char *wrong = file_write_png(path, &bytes);
    if (wrong) fail(1, "%s: %s", path, wrong);
    free(bytes.rgb);
}
// The light of one point of the picture: one lookup where the camera ray meets the body.
static void shoot(const scene *s, const method *k, int size, int x, int y, uint32_t seed,
                  float *rgb) {
    float u = tracer_unit(sss_hash(seed, 1u)), v = tracer_unit(sss_hash(seed, 2u));
    sss_vec3 d = tracer_camera(s, size, size, (float)x + u, (float)y + v);
    scene_hit hit = scene_nearest(s, s->eye, d, SCENE_FLOOR);
    double value[3] = {1.6, 1.6, 1.6}; // the background
    if (hit.shape >= 0) {
        tracer_point at;
        at.position = scene_along(s->eye, d, hit.t);
        at.normal = scene_normal(&s->shape[hit.shape], at.position);
        at.weight = at.normal;
        at.shape = hit.shape;
        estimate(s, k, at, 1, seed, value);
    }
    for (int c = 0; c < 3; c++) rgb[c] += (float)value[c];
}
static void take_picture(const scene *s, const method *k, int which, const char *side, int spp) {
    image picture;
    int size = quick ? 60 : 400;
    if (image_new(&picture, size, size)) fail(1, "out of memory");
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < size; y++)
        for (int i = 0; i < spp * size; i++)
            shoot(s, k, size, i / spp, y,
                  sss_hash(sss_hash(77u, (uint32_t)(y * size + i / spp)), (uint32_t)(i % spp)),
                  picture.rgb + image_count(size, y) + 3 * (i / spp));
    write_picture(&picture, which, side, 1.0f / (float)spp);
    free(picture.rgb);
}
static void take_both(const scene *s, const method *wrong, int which, int spp) {
    take_picture(s, wrong, which, "left", spp);
    take_picture(s, &ours, which, "right", spp);
}

// ---- The panels

static void show_edge(void) {
    static scene s;
    const method disk = {SSS_DISK, SOUND, 8, 0.0f};
    memset(&s, 0, sizeof s);
    scenes_shape(&s, scene_vec(0.0f, 0.0f, 0.0f), scene_vec(WIDE, WIDE, WIDE), 5e-4f,
                 scene_vec(0.0f, 0.0f, 0.0f));
    set_medium(&s, 1.0f, 1.0f, 1.0f);
    double truth = truth_edge(&s, 0.2);
    tally a = measure(&s, &disk, entry_on(&s, WIDE - 0.2f), 0, 11u, lookups_of(800000));
    tally b = measure(&s, &ours, entry_on(&s, WIDE - 0.2f), 0, 12u, lookups_of(800000));
    claim(EDGE, "classical", "mean", a.mean, a.error, truth, 0.0);
    claim(EDGE, "ours", "mean", b.mean, b.error, truth, 0.0);
    name_halves(EDGE, "disk: %.4f" PLUS_MINUS "%.4f of the light", a.mean / truth, a.error / truth,
                "ours: %.4f" PLUS_MINUS "%.4f", b.mean / truth, b.error / truth);
    memset(&s, 0, sizeof s);
    scenes_shape(&s, scene_vec(0.0f, 2.0f, 0.0f), scene_vec(1.0f, 0.8f, 0.8f), 2e-3f,
                 scene_vec(0.0f, 35.0f, 0.0f));
    scenes_camera(&s, scene_vec(0.0f, 5.2f, 6.0f), scene_vec(0.0f, 1.95f, 0.0f), 24.0f);
    set_medium(&s, 0.1f, 0.1f, 0.1f);
    take_both(&s, &disk, EDGE, quick ? 4 : 64);
}

static void show_hits(void) {
    static scene s;
    const char *const names[3] = {"plane", "sphere of radius d", "stack of plates"};
    double last[2][3], error = 0.0; // the largest of ours
    FILE *f = open_file("-hits.dat");
    for (int side = 0; side < 2; side++)
        for (int body = 0; body < 3; body++) {
            tracer_point at = body == 0   ? make_plates(&s, 1, 2.0f * WIDE)
                              : body == 1 ? make_round(&s, 1.0f, 1.0f, 1.0f)
                                          : make_plates(&s, 4, 0.3f);
            double truth = body == 0   ? truth_plates(&s, 1, 2.0 * (double)WIDE)
                           : body == 1 ? truth_sphere(&s, 1.0)
                                       : truth_plates(&s, 4, (double)0.3f);
            fprintf(f, "\"%s\"\n", names[body]);
            for (int m = 1; m <= 64; m *= 2) {
                method k = {side ? 0u : SSS_DISK | SSS_DISK_TANGENTS, side ? SOUND : BY_HITS, m,
                            0.0f};
                tally t = measure(&s, &k, at, 0, 20u + (uint32_t)(10 * body + m),
                                  lookups_of(1600000) / (m + 4));
                fprintf(f, "%d %g %g\n", m, t.mean / truth, t.error / truth);
                if (m == 8)
                    claim(HITS, side ? "ours" : "classical", "mean", t.mean, t.error, truth, 0.0);
                if (m == 8) last[side][body] = t.mean / truth - 1.0;
                if (m == 8 && side) error = fmax(error, t.error / truth);
            }
            fprintf(f, "\n\n");
        }
    close_file(f, "-hits.dat");
    snprintf(panels[HITS].left, sizeof panels[HITS].left, "by hits: %+.0f, %+.0f, %+.0f %%",
             100.0 * last[0][0], 100.0 * last[0][1], 100.0 * last[0][2]);
    snprintf(panels[HITS].right, sizeof panels[HITS].right,
             "ours: %+.2f, %+.2f, %+.2f" PLUS_MINUS "%.2f %%", 100.0 * last[1][0],
             100.0 * last[1][1], 100.0 * last[1][2], 100.0 * error);
}

static void show_retry(void) {
    static scene s;
    const method king = {SSS_DISK | SSS_DISK_TANGENTS, RETRIES, 1, 0.0f};
    double small[2] = {0.0, 0.0}, small_error[2] = {0.0, 0.0};
    FILE *f = open_file("-retry.dat");
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i <= 10; i++) {
            float radius = 0.1f * powf(100.0f, 0.1f * (float)i);
            tracer_point at = make_round(&s, radius, radius, radius);
            tally t = measure(&s, side ? &one_probe : &king, at, 0, 100u + (uint32_t)i,
                              lookups_of(800000));
            double truth = truth_sphere(&s, (double)radius);
            fprintf(f, "%g %g %g\n", (double)radius, t.mean / truth, t.error / truth);
            if (i == 0) small[side] = t.mean / truth, small_error[side] = t.error / truth;
            if (i % 5 == 0)
                claim(RETRY, side ? "ours" : "classical", "mean", t.mean, t.error, truth, 0.0);
        }
        fprintf(f, "\n\n");
    }
    close_file(f, "-retry.dat");
    name_halves(RETRY, "until one hits: up to %.2f" PLUS_MINUS "%.2f times", small[0],
                small_error[0], "ours: %.3f" PLUS_MINUS "%.3f", small[1], small_error[1]);
}

// White wax: red light goes ten times as far as green, and 25 times as far as blue.
static tracer_point make_wax(scene *s) {
    tracer_point at = make_round(s, 1.0f, 1.0f, 1.0f);
    s->shape[0].center.y = 2.0f;
    scenes_camera(s, scene_vec(0.0f, 4.0f, 6.0f), scene_vec(0.0f, 2.0f, 0.0f), 20.0f);
    set_medium(s, 0.15f, 0.015f, 0.006f);
    at.position.y += 2.0f;
    return at;
}
static void show_reach(void) {
    static scene s;
    tracer_point at = make_wax(&s);
    method cut = {SSS_DISK | SSS_DISK_TANGENTS, SHORT_REACH, 8, 0.0f};
    cut.reach = 16.0f * s.medium.length[1];
    double truth = truth_sphere(&s, 1.0);
    tally a = measure(&s, &cut, at, 0, 31u, lookups_of(800000)),
          b = measure(&s, &ours, at, 0, 32u, lookups_of(800000));
    claim(REACH, "classical", "mean", a.mean, a.error, truth, 0.0);
    claim(REACH, "ours", "mean", b.mean, b.error, truth, 0.0);
    name_halves(REACH, "16 d of green: red %+.1f" PLUS_MINUS "%.1f %%",
                100.0 * a.mean / truth - 100.0, 100.0 * a.error / truth,
                "ours: red %+.2f" PLUS_MINUS "%.2f %%", 100.0 * b.mean / truth - 100.0,
                100.0 * b.error / truth);
    take_both(&s, &cut, REACH, quick ? 4 : 64);
}
static void show_colours(void) {
    static scene s;
    tracer_point at = make_wax(&s);
    const method blue = {SSS_DISK | SSS_DISK_TANGENTS, BY_BLUE, 8, 0.0f};
    double truth = truth_sphere(&s, 1.0);
    tally a = measure(&s, &blue, at, 0, 41u, lookups_of(800000)),
          b = measure(&s, &ours, at, 0, 42u, lookups_of(800000));
    double bound = 2.0 * 3.0 * 2.0 / 0.25,
           albedo = albedo_of(&s); // over A: two hits, three channels
    claim(COLOURS, "classical", "exact", a.greatest / albedo, 0.0, bound, 0.0);
    claim(COLOURS, "ours", "exact", b.greatest / albedo, 0.0, bound, 0.0);
    claim(COLOURS, "ours", "mean", b.mean, b.error, truth, 0.0);
    name_halves(COLOURS, "radii of blue: red weights up to %.0f", a.greatest / albedo, 0.0,
                "ours: up to %.1f", b.greatest / albedo, 0.0);
    take_both(&s, &blue, COLOURS, quick ? 2 : 32);
}

static tracer_settings wall_settings(int how, int light_aware, int size) {
    tracer_settings t;
    memset(&t, 0, sizeof t);
    t.method = how;
    t.light_aware = light_aware;
    t.width = t.height = size;
    return t;
}
// The pixel in the middle, by the tracer.
static tally measure_wall(const scene *s, tracer_settings t, int samples) {
    double *values = (double *)malloc((size_t)samples * sizeof *values);
    if (!values) fail(1, "out of memory");
#pragma omp parallel for schedule(dynamic, 256)
    for (int i = 0; i < samples; i++)
        values[i] = (double)scene_mean(
            tracer_sample(s, t, t.width / 2, t.height / 2, (uint32_t)i).radiance);
    tally got = tally_values(values, samples);
    free(values);
    return got;
}
static void show_wall(void) {
    static scene s;
    int size = quick ? 60 : 400, spp = quick ? 2 : 8;
    tally t[2];
    load_scene(&s, SCENES_SLAB, "burley", 1.0f);
    tally truth = measure_wall(&s, wall_settings(TRACER_REFERENCE, 0, size), lookups_of(400000));
    for (int hinted = 0; hinted < 2; hinted++) {
        tracer_settings settings = wall_settings(TRACER_RESAMPLED, hinted, size);
        image picture;
        t[hinted] = measure_wall(&s, settings, lookups_of(400000));
        if (image_new(&picture, size, size)) fail(1, "out of memory");
#pragma omp parallel for schedule(dynamic)
        for (int y = 0; y < size; y++)
            for (int i = 0; i < spp * size; i++) {
                sss_vec3 l = tracer_sample(&s, settings, i / spp, y, (uint32_t)(i % spp)).radiance;
                float *rgb = picture.rgb + image_count(size, y) + 3 * (i / spp);
                rgb[0] += l.x, rgb[1] += l.y, rgb[2] += l.z;
            }
        write_picture(&picture, WALL, hinted ? "right" : "left", 0.8f / (float)spp);
        free(picture.rgb);
    }
    claim(WALL, "classical", "noise", t[0].noise, t[0].noise_error, t[1].noise, t[1].noise_error);
    claim(WALL, "ours", "mean", t[1].mean, t[1].error, truth.mean, truth.error);
    name_halves(WALL, "no hint: variance %.4f" PLUS_MINUS "%.4f", t[0].noise, t[0].noise_error,
                "ours, hinted: %.5f" PLUS_MINUS "%.5f", t[1].noise, t[1].noise_error);
}

static void show_hair(void) {
    static scene s;
    const method disk = {SSS_DISK, SOUND, 8, 0.0f};
    int lookups = lookups_of(1 << 21);
    double bound = 2.0 * 2.0 / 0.25,
           greatest[2] = {0.0, 0.0}; // over A: two hits of each probe, 2 A / (chord's share)
    tracer_point at = make_round(&s, 0.1f, 0.1f, 1000.0f);
    double albedo = albedo_of(&s);
    FILE *f = open_file("-hair.dat");
    for (int side = 0; side < 2; side++) {
        double *values =
            draw_values(&s, side ? &ours : &disk, at, 0, 50u + (uint32_t)side, lookups);
        tally t = tally_values(values, lookups);
        for (int i = 0; i < lookups; i++) {
            greatest[side] = fmax(greatest[side], values[i] / albedo);
            if (i + 1 >= 64 && ((i + 1) & i) == 0) fprintf(f, "%d %g\n", i + 1, greatest[side]);
        }
        fprintf(f, "\n\n");
        claim(HAIR, side ? "ours" : "classical", "exact", greatest[side], 0.0, bound, 0.0);
        if (side) claim(HAIR, "ours", "mean", t.mean, t.error, truth_hair(&s, (double)0.1f), 0.0);
        free(values);
    }
    close_file(f, "-hair.dat");
    name_halves(HAIR, "disk about the normal: up to %.0f", greatest[0], 0.0, "ours: up to %.1f",
                greatest[1], 0.0);
}

static void show_slab(void) {
    static scene s;
    const method sphere = {SSS_SPHERE, SOUND, 8, 0.0f};
    double at_h[2] = {0.0, 0.0}, at_h_error[2] = {0.0, 0.0};
    FILE *f = open_file("-slab.dat");
    for (int side = 0; side < 2; side++) {
        for (int i = -10; i <= 10; i++) {
            float t = expf(0.12f * (float)i * (1.0f + 0.1f * (float)abs(i)));
            tracer_point at = make_plates(&s, 1, t);
            tally got = measure(&s, side ? &ours : &sphere, at, 0, 60u + (uint32_t)(i + 10),
                                lookups_of(200000));
            double truth = truth_plates(&s, 1, (double)t);
            fprintf(f, "%g %g %g\n", (double)t, got.mean / truth, got.error / truth);
            if (i == 0) at_h[side] = got.mean / truth, at_h_error[side] = got.error / truth;
            if (side || i == 0)
                claim(SLAB, side ? "ours" : "classical", "mean", got.mean, got.error, truth, 0.0);
        }
        fprintf(f, "\n\n");
    }
    close_file(f, "-slab.dat");
    name_halves(SLAB, "sphere alone, t = h: %.4f" PLUS_MINUS "%.4f", at_h[0], at_h_error[0],
                "ours: %.4f" PLUS_MINUS "%.4f", at_h[1], at_h_error[1]);
}

static void show_bumps(void) {
    static scene s;
    tracer_point at = make_round(&s, 1.0f, 1.0f, 1.0f);
    const method bumped = {SSS_DISK | SSS_DISK_TANGENTS, BUMPED, 8, 0.0f};
    s.shape[0].center.y = 2.0f;
    at.position.y += 2.0f;
    scenes_camera(&s, scene_vec(0.0f, 4.0f, 6.0f), scene_vec(0.0f, 2.0f, 0.0f), 20.0f);
    set_medium(&s, 0.03f, 0.03f, 0.03f);
    double truth = truth_sphere(&s, 1.0);
    tally a = measure(&s, &bumped, at, 0, 71u, lookups_of(400000)),
          b = measure(&s, &ours, at, 0, 72u, lookups_of(400000));
    claim(BUMPS, "classical", "mean", a.mean, a.error, truth, 0.0);
    claim(BUMPS, "ours", "mean", b.mean, b.error, truth, 0.0);
    name_halves(BUMPS, "shading normals: %+.2f" PLUS_MINUS "%.2f %% on top",
                100.0 * a.mean / truth - 100.0, 100.0 * a.error / truth,
                "ours, geometric: %+.2f" PLUS_MINUS "%.2f %%", 100.0 * b.mean / truth - 100.0,
                100.0 * b.error / truth);
    take_both(&s, &bumped, BUMPS, quick ? 4 : 48);
}

// The better dipole's unit profile as the formula stands, in float, and rearranged in double.
static float written_dipole(const sss_medium *m, float r) {
    float zr = m->length[0], zv = m->zv[0], s = m->sigma[0], dr = sqrtf(r * r + zr * zr),
          dv = sqrtf(r * r + zv * zv);
    return m->flux[0] * (zr * (1.0f + s * dr) * expf(-s * dr) / (dr * dr * dr) +
                         zv * (1.0f + s * dv) * expf(-s * dv) / (dv * dv * dv)) +
           m->fluence[0] * (expf(-s * dr) / dr - expf(-s * dv) / dv);
}
static double exact_dipole(const sss_medium *m, double r) {
    double zr = (double)m->length[0], zv = (double)m->zv[0], s = (double)m->sigma[0],
           dr = hypot(r, zr);
    double dv = hypot(r, zv), gap = (zv - zr) * (zv + zr) / (dr + dv);
    return (double)m->flux[0] * (zr * (1.0 + s * dr) * exp(-s * dr) / (dr * dr * dr) +
                                 zv * (1.0 + s * dv) * exp(-s * dv) / (dv * dv * dv)) +
           (double)m->fluence[0] * exp(-s * dr) * (gap - dr * expm1(-s * gap)) / (dr * dv);
}
static void show_floats(void) {
    const float sigma_a[3] = {1e-9f, 1e-9f, 1e-9f}, sigma_s[3] = {1.0f, 1.0f, 1.0f};
    double worst[2] = {0.0, 0.0};
    sss_medium m;
    if (sss_better_dipole(&m, sigma_a, sigma_s, 1.4f) != SSS_OK) fail(1, "a medium is refused");
    FILE *f = open_file("-floats.dat");
    for (int i = 0; i <= 700; i++) {
        float r = powf(10.0f, -2.0f + (float)i * 0.01f);
        double exact = exact_dipole(&m, (double)r), error[2];
        error[0] = fabs((double)written_dipole(&m, r) / exact - 1.0);
        error[1] = fabs(
            (double)sss_profile(&m, 0, r) / ((double)sss_within(&m, 0, FLT_MAX) * exact) - 1.0);
        fprintf(f, "%g %g %g\n", (double)r, fmax(error[0], 1e-9), fmax(error[1], 1e-9));
        for (int k = 0; k < 2; k++) worst[k] = fmax(worst[k], error[k]);
    }
    close_file(f, "-floats.dat");
    claim(FLOATS, "classical", "exact", worst[0], 0.0, 1e-5, 0.0);
    claim(FLOATS, "ours", "exact", worst[1], 0.0, 1e-5, 0.0);
    name_halves(FLOATS, "as written: error up to %.2g", worst[0], 0.0, "ours: up to %.1e", worst[1],
                0.0);
}

// ---- The page

static void write_titles(void) {
    FILE *f = open_file("-titles.gp");
    fprintf(f, "names = \"");
    for (int i = 0; i < PANELS; i++) fprintf(f, "%s ", panels[i].name);
    fprintf(f, "\"\n");
    for (int i = 0; i < PANELS; i++)
        fprintf(f, "title_%s = \"%s\"\nleft_%s = \"%s\"\nright_%s = \"%s\"\n", panels[i].name,
                panels[i].title, panels[i].name, panels[i].left, panels[i].name, panels[i].right);
    close_file(f, "-titles.gp");
}
static void write_page(void) {
    const char *base = strrchr(out, '/') ? strrchr(out, '/') + 1 : out;
    FILE *f = open_file(".html");
    fprintf(f, "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Where "
               "methods fail</title>\n"
               "<style>body{font:16px/1.5 sans-serif;max-width:900px;margin:2em auto;padding:0 "
               "1em;color:#202020}"
               "img{width:100%%}figure{margin:3em 0}</style>\n<h1>Where methods fail</h1>\n"
               "<p>Left a classical way, right sss_resample.h, both measured in one run. Standard "
               "errors follow "
               "the figures; variances are over the squared mean. Lengths are in units of d, the "
               "length of Burley's "
               "profile.</p>\n");
    for (int i = 0; i < PANELS; i++)
        fprintf(f,
                "<figure><img src=\"%s-%s.png\" alt=\"%s\"><figcaption>%s <b>Left</b>, %s. "
                "<b>Right</b>, %s."
                "</figcaption></figure>\n",
                base, panels[i].name, panels[i].title, panels[i].how, panels[i].left,
                panels[i].right);
    fprintf(f, "</html>\n");
    close_file(f, ".html");
}

int main(int argc, char **argv) {
    static void (*const show[PANELS])(void) = {show_edge,    show_hits,  show_retry, show_reach,
                                               show_colours, show_wall,  show_hair,  show_slab,
                                               show_bumps,   show_floats};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) return fputs(usage, stdout) < 0;
        if (strcmp(argv[i], "--quick") == 0) quick = 1;
        else if (argv[i][0] == '-' || out)
            fail(2, "does not know '%s'; --help tells more", argv[i]);
        else out = argv[i];
    }
    if (!out) fail(2, "wants the name of what it writes; --help tells more");
    write_titles(); // before the long job: can it be written at all?
    printf("panel,side,kind,value,error,truth,truth_error,z\n");
    for (int i = 0; i < PANELS; i++) {
        show[i]();
        fprintf(stderr, "\rfailures: %d of %d panels", i + 1, PANELS);
    }
    fprintf(stderr, "\n");
    write_titles();
    write_page();
    return 0;
}
