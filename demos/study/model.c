// model.c - what the model itself costs, apart from the sampling: the profiles against a
// searchlight on a half space. Writes data for chart.py. See --help. What profiles cost on curved
// and thin bodies is in model_error.c. SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#define COMMAND "model"
#include "demos/common/command.h"

static const char usage[] =
    "usage: model SEARCHLIGHT OUT\n"
    "Measures the profiles against SEARCHLIGHT (tests/data/mc_searchlight.csv): OUT-model.dat.\n";

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
    float sigma_a[3], sigma_s[3], one[3] = {1.0f, 1.0f, 1.0f}, eta = (float)l->eta, albedo[3],
                                  dmfp[3];
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
        double far = i + 1 == l->count ? (double)sss_within(&m, 0, FLT_MAX)
                                       : (double)sss_within(&m, 0, (float)l->high[i]);
        error += fabs(far - (double)sss_within(&m, 0, (float)l->low[i]) - l->energy[i]);
    }
    return error / total;
}

static void write_rings(FILE *f, const light_rings *l) {
    double total = 0.0;
    // Matched indices with the light inside, and light from outside refracted where there is a
    // boundary.
    if (l->count == 0 || l->source != (l->eta > 1.0 ? 'X' : 'D')) return;
    for (int i = 0; i < l->count; i++) total += l->energy[i];
    fprintf(f, "%g %g %.5f", l->eta, l->albedo, total);
    for (int k = 0; k < PROFILES; k++) fprintf(f, " %.4f", ring_error(l, k));
    fputc('\n', f);
}

static void measure_profiles(const char *path, const char *out) {
    static light_rings l;
    char line[256];
    FILE *in = fopen(path, "r");
    int known = 0;
    if (!in) fail(2, "cannot read %s: %s", path, strerror(errno));
    FILE *f = open_data(out, "model");
    fprintf(f, "# eta, albedo of a scattering, of the half space; errors: Burley by dmfp, by mfp, "
               "dipole, better dipole\n");
    while (fgets(line, sizeof line, in)) {
        double a, eta, low, high, energy;
        char source;
        if (sscanf(line, "%lf,%lf,%c,%lf,%lf,%lf", &a, &eta, &source, &low, &high, &energy) != 6)
            continue;
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

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "--help") == 0) return fputs(usage, stdout) < 0;
    for (int i = 1; i < argc; i++)
        if (argv[i][0] == '-') fail(2, "unknown word '%s'; --help lists what there is", argv[i]);
    if (argc != 3) fail(2, "wants SEARCHLIGHT and OUT; --help says what they are");
    measure_profiles(argv[1], argv[2]);
    return 0;
}
