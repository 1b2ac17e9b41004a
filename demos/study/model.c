// model.c - what the model itself costs, apart from the sampling: the profiles against a searchlight on a half space,
// and whether a seam shows where the plan changes to Lambert along a surface. Writes data for chart.gp. See --help.
// What profiles cost on curved and thin bodies is in model_error.c.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#define COMMAND "model"
#include "demos/common/command.h"
#include "rivals.h"

#define SEAM_SIDE  200   // pixels
#define SEAM_LEAST 1e-2f // below it float32 no longer resolves the probes on this sphere
#define SEAM_MOST  1e1f  // dmfp in pixels; above it the plan walks, from the left edge of the sphere to the right

static const char usage[] =
    "usage: model [--quick] SEARCHLIGHT OUT\n"
    "Measures the profiles against SEARCHLIGHT (tests/data/mc_searchlight.csv): OUT-model.dat; and a sphere whose\n"
    "diffuse mean free path grows from left to right, with the plan and without: OUT-seam.dat.\n";

static FILE *open_data(const char *out, const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s-%s.dat", out, name);
    FILE *f = fopen(path, "w");
    if (!f) fail(2, "cannot write %s: %s", path, strerror(errno));
    return f;
}
static void close_data(FILE *f, const char *name) {
    if (ferror(f) | fclose(f)) fail(1, "cannot write the data of %s to the end", name);
}

// ---- Profiles

// One searchlight: energy by rings, per unit that entered. Lengths in mean free paths.
typedef struct light_rings {
    double albedo, eta, low[128], high[128], energy[128];
    char source;
    int count;
} light_rings;

enum { BURLEY_DMFP, BURLEY_MFP, DIPOLE, BETTER_DIPOLE, PROFILES };

// The sum over the rings of |profile - searchlight|, over the light that leaves.
static double ring_error(const light_rings *l, int profile) {
    double total = 0.0, error = 0.0, p = 1.0 - l->albedo;
    float sigma_a[3], sigma_s[3], one[3] = {1.0f, 1.0f, 1.0f}, eta = (float)l->eta, albedo[3], dmfp[3];
    sss_medium m;
    for (int i = 0; i < l->count; i++) total += l->energy[i];
    for (int c = 0; c < 3; c++) {
        sigma_a[c] = (float)p;
        sigma_s[c] = (float)l->albedo;
        albedo[c] = (float)total;
        dmfp[c] = (float)sqrt((1.0 + p) / (3.0 * p)); // Grosjean's
    }
    if (profile == BURLEY_DMFP) sss_burley(&m, albedo, dmfp);
    else if (profile == BURLEY_MFP) sss_burley_mfp(&m, albedo, one);
    else if (profile == DIPOLE) sss_dipole(&m, sigma_a, sigma_s, eta);
    else sss_better_dipole(&m, sigma_a, sigma_s, eta);
    for (int i = 0; i < l->count; i++) {
        double far = i + 1 == l->count ? (double)m.albedo[0] : (double)sss_within(&m, 0, (float)l->high[i]);
        error += fabs(far - (double)sss_within(&m, 0, (float)l->low[i]) - l->energy[i]);
    }
    return error / total;
}

static void write_rings(FILE *f, const light_rings *l) {
    double total = 0.0;
    // Matched indices with the light inside, and light from outside refracted where there is a boundary.
    if (l->count == 0 || l->source != (l->eta > 1.0 ? 'X' : 'D')) return;
    for (int i = 0; i < l->count; i++) total += l->energy[i];
    fprintf(f, "%g %g %.5f", l->eta, l->albedo, total);
    for (int k = 0; k < PROFILES; k++) fprintf(f, " %.4f", ring_error(l, k));
    fputc('\n', f);
}

static void measure_profiles(const char *path, const char *out) {
    static light_rings l;
    char line[256];
    FILE *in = fopen(path, "r"), *f;
    int known = 0;
    if (!in) fail(2, "cannot read %s: %s", path, strerror(errno));
    f = open_data(out, "model");
    fprintf(
        f, "# eta, albedo of a scattering, of the half space; errors: Burley by dmfp, by mfp, dipole, better dipole\n");
    while (fgets(line, sizeof line, in)) {
        double a, eta, low, high, energy;
        char source;
        if (sscanf(line, "%lf,%lf,%c,%lf,%lf,%lf", &a, &eta, &source, &low, &high, &energy) != 6) continue;
        if (a != l.albedo || eta != l.eta || source != l.source) {
            write_rings(f, &l);
            memset(&l, 0, sizeof l);
            l.albedo = a, l.eta = eta, l.source = source;
        }
        if (l.count == 128) fail(1, "%s has more rings than 128", path);
        l.low[l.count] = low, l.high[l.count] = high, l.energy[l.count++] = energy;
        known++;
    }
    write_rings(f, &l);
    fclose(in);
    if (!known) fail(2, "%s holds no searchlight", path);
    close_data(f, "the profiles");
}

// ---- The seam

// Sums over a column of the picture: of all lookups, and of those that the plan gives.
typedef struct seam_column {
    double x, sum[2], squares[2], seconds[2], pixels, advised;
} seam_column;

static double cpu_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// The mean over the channels of `samples` lookups, by the default plan or as `planned`.
static double seam_pixel(rivals_world *w, camera_entry at, int planned, uint32_t seed, int samples, int *lambert) {
    sss_need need = {rivals_footprint(&w->s, &at, SEAM_SIDE), w->s.shape[0].extent.x, 0.0f, 0.0f, 0};
    sss_plan plan = sss_plan_for(&w->s.medium, &need);
    double sum = 0.0;
    *lambert = plan.techniques == SSS_LAMBERT;
    for (int i = 0; i < samples; i++) {
        double value[3];
        rivals_work work;
        tracer_point point = {at.position, at.normal, at.position, at.shape};
        if (planned && *lambert) {
            sss_vec3 light = rivals_shade(w, point, sss_hash(seed, (uint32_t)i));
            value[0] = (double)(w->s.medium.albedo[0] * light.x);
            value[1] = (double)(w->s.medium.albedo[1] * light.y);
            value[2] = (double)(w->s.medium.albedo[2] * light.z);
        } else {
            rivals_probe_lookup(w, planned ? &plan : NULL, 0, at, sss_hash(seed, (uint32_t)i), &work, value);
        }
        sum += (value[0] + value[1] + value[2]) / 3.0;
    }
    return sum / samples;
}

static void measure_column(const scene *s, seam_column *column, int x, int samples, float *pixel) {
    static const float albedo[3] = {0.8f, 0.6f, 0.5f};
    rivals_world w;
    memset(&w, 0, sizeof w);
    w.s = *s;
    for (int y = 0; y < SEAM_SIDE; y++) {
        camera_entry at;
        if (!camera_sees(s, ((float)x + 0.5f) / SEAM_SIDE, ((float)y + 0.5f) / SEAM_SIDE, &at)) continue;
        float span = logf(SEAM_MOST / SEAM_LEAST) * (float)column->x;
        float dmfp = SEAM_LEAST * expf(span) * rivals_footprint(s, &at, SEAM_SIDE);
        float lengths[3] = {dmfp, 0.7f * dmfp, 0.5f * dmfp};
        int lambert;
        sss_burley(&w.s.medium, albedo, lengths);
        for (int planned = 0; planned < 2; planned++) {
            double start = cpu_now();
            uint32_t seed = sss_hash((uint32_t)(2 * x + planned), (uint32_t)y);
            double value = seam_pixel(&w, at, planned, seed, samples, &lambert);
            column->seconds[planned] += (cpu_now() - start) / samples;
            column->sum[planned] += value;
            column->squares[planned] += value * value;
            if (planned) pixel[y] = (float)value;
        }
        column->pixels += 1.0;
        column->advised += lambert;
    }
}

// Column, dmfp in pixels, mean with the plan over that of all lookups, seconds of a sample of both, share of Lambert;
// then the picture with the plan: column, row, value.
static void measure_seam(const char *out, int samples) {
    static seam_column column[SEAM_SIDE];
    static float picture[SEAM_SIDE][SEAM_SIDE];
    static scene s;
    FILE *f = open_data(out, "seam");
    scenes_make(&s, SCENES_SPHERE);
    scenes_camera(&s, scene_vec(0.0f, 1.6f, 6.4f), s.shape[0].center, 19.0f);
    scenes_light(&s, scene_vec(-2.4f, 3.2f, 3.2f), s.shape[0].center, 0.6f, scene_vec(34.0f, 31.0f, 27.0f));
#pragma omp parallel for schedule(dynamic)
    for (int x = 0; x < SEAM_SIDE; x++) {
        column[x].x = (x + 0.5) / SEAM_SIDE;
        measure_column(&s, &column[x], x, samples, picture[x]);
    }
    fprintf(f, "# columns\n");
    for (int x = 0; x < SEAM_SIDE; x++) {
        const seam_column *c = &column[x];
        if (c->pixels < 20.0) continue;
        double dmfp = (double)SEAM_LEAST * pow((double)(SEAM_MOST / SEAM_LEAST), c->x);
        fprintf(f, "%d %.5g %.6g %.4g %.4g %.4g\n", x, dmfp, c->sum[1] / c->sum[0], c->seconds[0] / c->pixels,
                c->seconds[1] / c->pixels, c->advised / c->pixels);
    }
    fprintf(f, "\n\n# picture\n");
    for (int y = 0; y < SEAM_SIDE; y++)
        for (int x = 0; x < SEAM_SIDE; x++) fprintf(f, "%d %d %.4g\n", x, SEAM_SIDE - 1 - y, (double)picture[x][y]);
    close_data(f, "the seam");
}

int main(int argc, char **argv) {
    const char *names[2] = {NULL, NULL};
    int samples = 256, n = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) return fputs(usage, stdout) < 0;
        if (strcmp(argv[i], "--quick") == 0) samples = 4;
        else if (argv[i][0] == '-' || n == 2) fail(2, "unknown word '%s'; --help lists what there is", argv[i]);
        else names[n++] = argv[i];
    }
    if (n < 2) fail(2, "wants SEARCHLIGHT and OUT; --help says what they are");
    measure_profiles(names[0], names[1]);
    measure_seam(names[1], samples);
    return 0;
}
