// pfm.c - questions about the float pictures (PFM) that render writes. SPDX-License-Identifier: MIT
//
// clang-format off
//     pfm check FILE W H   exit code 0 if it is a colour PFM of this size, all finite
//                          and not all black
//     pfm mean FILE        the same for any size, and the mean of each channel
//     pfm same A B         exit code 0 if the pictures differ as little as 64 additions
//                          of floats allow
// clang-format on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Samples are about as large as the brightest pixel of the tests' pictures (5), and each of 64
// additions may lose half an ulp of the sum.
#define ROUNDING (5.0 * 64.0 * 5.96e-8)

typedef struct picture {
    int width, height;
    float *rgb;
} picture;

// The pixels are little endian, as the tests' machines are; behind them stands what render says of
// its samples.
static picture load(const char *path) {
    picture p = {0, 0, NULL};
    double scale = 0.0;
    char note[8];
    FILE *f = fopen(path, "rb");

    if (!f || fscanf(f, "PF %d %d %lf", &p.width, &p.height, &scale) != 3 || fgetc(f) != '\n' ||
        scale != -1.0) {
        fprintf(stderr, "pfm: %s is no little endian colour PFM\n", path);
        exit(1);
    }

    size_t count = 3 * (size_t)p.width * (size_t)p.height;
    p.rgb = malloc(count * sizeof *p.rgb);
    if (!p.rgb || fread(p.rgb, sizeof *p.rgb, count, f) != count || fread(note, 1, 8, f) != 8 ||
        memcmp(note, "samples ", 8) != 0) {
        fprintf(stderr, "pfm: %s lacks pixels or the note on its samples\n", path);
        exit(1);
    }
    fclose(f);
    return p;
}

// Negative numbers are fair, as the tracer subtracts what it expects.
static int mean(const char *path, int width, int height, int show) {
    picture p = load(path);
    double sum[3] = {0.0, 0.0, 0.0};
    if (width > 0 && (p.width != width || p.height != height)) return 1;

    for (int i = 0; i < 3 * p.width * p.height; i++) {
        if (!isfinite(p.rgb[i])) return 1;
        sum[i % 3] += (double)p.rgb[i];
    }

    double pixels = (double)p.width * p.height;
    if (show) printf("%.9g %.9g %.9g\n", sum[0] / pixels, sum[1] / pixels, sum[2] / pixels);
    return !(sum[0] + sum[1] + sum[2] > 0.0);
}

static int same(const char *one, const char *other) {
    picture a = load(one);
    picture b = load(other);
    double worst = 0.0;
    if (a.width != b.width || a.height != b.height) return 1;

    for (int i = 0; i < 3 * a.width * a.height; i++) {
        double difference = fabs((double)a.rgb[i] - (double)b.rgb[i]);
        if (!(difference <= worst)) worst = difference;
    }

    printf("greatest difference %g of %d numbers\n", worst, 3 * a.width * a.height);
    return !(worst <= ROUNDING);
}

int main(int count, char **words) {
    if (count == 5 && strcmp(words[1], "check") == 0)
        return mean(words[2], atoi(words[3]), atoi(words[4]), 0);
    if (count == 3 && strcmp(words[1], "mean") == 0) return mean(words[2], 0, 0, 1);
    if (count == 4 && strcmp(words[1], "same") == 0) return same(words[2], words[3]);
    fputs("usage: pfm check FILE W H, pfm mean FILE, pfm same A B\n", stderr);
    return 2;
}
