// image.h - float images, PFM in and out, tone curve, PNG, captions. Host only; link with -lstb.
// See files.h for files. SPDX-License-Identifier: MIT
//
// FONT_FILE is the TrueType font of the captions, named when the program is built.
//
// What can fail returns a text, here and in all of demos/common: NULL for success, or a short
// reason to print after the file's name. An int answers a question: 1 for yes, 0 for no.
#ifndef IMAGE_H
#define IMAGE_H

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <stb/stb_image_write.h>
#include <stb/stb_truetype.h>

#ifndef FONT_FILE
#define FONT_FILE "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
#endif

#define IMAGE_MAX_SIDE 16384
#define IMAGE_MAX_NOTE (1 << 27) // bytes of text behind a PFM's pixels

#define IMAGE_NO_ROOM "it does not fit into memory"
#define IMAGE_CUT     "it could not be written to the end"
#define IMAGE_UNREAD  "it could not be read to the end"

// Linear RGB, rows from the top, three floats a pixel.
typedef struct image {
    int width, height;
    float *rgb;
} image;

// The same with bytes, ready for the screen.
typedef struct image_bytes {
    int width, height;
    unsigned char *rgb;
} image_bytes;

typedef struct image_font {
    unsigned char *file;
    stbtt_fontinfo info;
} image_font;

static inline size_t image_count(int width, int height) {
    return (size_t)width * (size_t)height * 3u;
}

static inline const char *image_new(image *out, int width, int height) {
    out->width = width;
    out->height = height;
    out->rgb = (float *)calloc(image_count(width, height), sizeof *out->rgb);
    return out->rgb ? NULL : IMAGE_NO_ROOM;
}

static inline const char *image_bytes_new(image_bytes *out, int width, int height,
                                          unsigned char grey) {
    out->width = width;
    out->height = height;
    out->rgb = (unsigned char *)malloc(image_count(width, height));
    if (out->rgb) memset(out->rgb, grey, image_count(width, height));
    return out->rgb ? NULL : IMAGE_NO_ROOM;
}

// ---- Files

// PFM is little endian when its scale is negative; floats are put together from bytes, so the
// machine does not matter.
static inline float image_float(const unsigned char *b, int little) {
    uint32_t bits = 0;
    float value;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)b[little ? i : 3 - i] << (8 * i);
    memcpy(&value, &bits, sizeof value);
    return value;
}

// `note` is text to stand behind the pixels, where readers of the format do not look; NULL for
// none.
static inline const char *image_write_pfm(const image *in, FILE *file, const char *note) {
    int good = fprintf(file, "PF\n%d %d\n-1.0\n", in->width, in->height) > 0;
    for (int y = in->height - 1; y >= 0; y--) { // the format stores rows from the bottom
        const float *row = in->rgb + image_count(in->width, y);
        for (int i = 0; i < 3 * in->width; i++) {
            uint32_t bits;
            memcpy(&bits, row + i, sizeof bits);
            unsigned char b[4] = {(unsigned char)bits, (unsigned char)(bits >> 8),
                                  (unsigned char)(bits >> 16), (unsigned char)(bits >> 24)};
            good &= fwrite(b, 1, 4, file) == 4;
        }
    }
    if (note) good &= fputs(note, file) >= 0;
    return good ? NULL : IMAGE_CUT;
}

static inline const char *image_read_header(image *out, FILE *file, int *little) {
    int width = 0, height = 0;
    double scale = 0.0;
    // Six digits: a longer number is a size out of range, and does not wrap around.
    if (fscanf(file, "PF %6d %6d %lf", &width, &height, &scale) != 3 || fgetc(file) != '\n') {
        return "it is not a colour PFM file";
    }
    if (!(fabs(scale) > 0.0 && fabs(scale) <= DBL_MAX))
        return "it has a scale that is 0 or no number";
    if (width < 1 || height < 1 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return "it has a size out of range";
    *little = scale < 0.0;
    return image_new(out, width, height);
}

static inline const char *image_read_pixels(image *out, FILE *file, int little) {
    for (int y = out->height - 1; y >= 0; y--) {
        float *row = out->rgb + image_count(out->width, y);
        for (int i = 0; i < 3 * out->width; i++) {
            unsigned char b[4];
            if (fread(b, 1, 4, file) != 4) return ferror(file) ? IMAGE_UNREAD : "it ends too early";
            row[i] = image_float(b, little);
            if (!(fabsf(row[i]) <= FLT_MAX)) return "it has pixels that are no finite numbers";
        }
    }
    return NULL;
}

// All that is left of the file, as text; it must be freed.
static inline const char *image_read_note(FILE *file, char **note) {
    size_t length = 0, room = 0, got = 1;
    *note = NULL;
    while (got > 0) {
        room = 2 * room + 4096;
        char *larger = room > IMAGE_MAX_NOTE ? NULL : (char *)realloc(*note, room);
        if (!larger) {
            free(*note);
            *note = NULL;
            return "it has more text behind its pixels than fits into memory";
        }
        *note = larger;
        got = fread(*note + length, 1, room - 1 - length, file);
        length += got;
    }
    if (ferror(file)) {
        free(*note);
        *note = NULL;
        return IMAGE_UNREAD;
    }
    (*note)[length] = '\0';
    return strlen(*note) == length ? NULL : "it has bytes behind its pixels that are no text";
}

// `note` takes the text behind the pixels, to be freed; NULL leaves it unread.
static inline const char *image_read_pfm(image *out, FILE *file, char **note) {
    int little = 0;
    memset(out, 0, sizeof *out);
    const char *wrong = image_read_header(out, file, &little);
    if (!wrong) wrong = image_read_pixels(out, file, little);
    if (!wrong && note) wrong = image_read_note(file, note);
    if (wrong) {
        free(out->rgb);
        out->rgb = NULL;
    }
    return wrong;
}

typedef struct image_sink {
    FILE *file;
    int good;
} image_sink;

static inline void image_drain(void *sink, void *bytes, int count) {
    image_sink *s = (image_sink *)sink;
    s->good &= fwrite(bytes, 1, (size_t)count, s->file) == (size_t)count;
}

static inline const char *image_write_png(const image_bytes *in, FILE *file) {
    image_sink sink = {file, 1};
    int made = stbi_write_png_to_func(image_drain, &sink, in->width, in->height, 3, in->rgb,
                                      3 * in->width);
    return made && sink.good ? NULL : IMAGE_CUT;
}

// ---- Tone

// Exposure and a soft shoulder, so that light behind wax may exceed 1 without a hard edge, then the
// sRGB curve.
static inline unsigned char image_tone(float linear, float exposure) {
    float x = linear * exposure;
    if (!(x > 0.0f)) x = 0.0f;
    const float knee = 0.45f; // below it linear, above it towards 1 with the same slope
    if (x > knee) x = knee + (1.0f - knee) * (1.0f - expf((knee - x) / (1.0f - knee)));
    x = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f;
    return (unsigned char)(255.0f * x + 0.5f);
}

static inline void image_blit(image_bytes *to, const image *from, float exposure, int left,
                              int top) {
    for (int y = 0; y < from->height; y++) {
        for (int i = 0; i < 3 * from->width; i++) {
            to->rgb[image_count(to->width, y + top) + (size_t)(3 * left + i)] =
                image_tone(from->rgb[image_count(from->width, y) + (size_t)i], exposure);
        }
    }
}

// ---- Captions

static inline const char *image_font_open(image_font *font) {
    FILE *file = fopen(FONT_FILE, "rb");
    if (!file) return strerror(errno);
    const char *wrong = NULL;
    long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    rewind(file);
    font->file = size > 0 ? (unsigned char *)malloc((size_t)size) : NULL;
    if (size > 0 && !font->file) wrong = IMAGE_NO_ROOM;
    else if (size <= 0 || fread(font->file, 1, (size_t)size, file) != (size_t)size)
        wrong = IMAGE_UNREAD;
    else if (!stbtt_InitFont(&font->info, font->file, stbtt_GetFontOffsetForIndex(font->file, 0)))
        wrong = "it is not a TrueType font";
    fclose(file);
    if (wrong) free(font->file);
    return wrong;
}

// One glyph's coverage, laid over the picture in a grey.
static inline void image_glyph(image_bytes *to, const unsigned char *coverage, int width,
                               int height, int left, int top, int grey) {
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            int px = left + x, py = top + y, a = coverage[y * width + x];
            if (px < 0 || py < 0 || px >= to->width || py >= to->height) continue;
            unsigned char *rgb = to->rgb + image_count(to->width, py) + 3 * (size_t)px;
            for (int c = 0; c < 3; c++)
                rgb[c] = (unsigned char)((rgb[c] * (255 - a) + grey * a) / 255);
        }
    }
}

// ASCII text with its baseline at `baseline`; returns its width. A negative grey measures only.
static inline float image_text(image_bytes *to, const image_font *font, const char *text,
                               float size, int left, int baseline, int grey) {
    float scale = stbtt_ScaleForPixelHeight(&font->info, size), x = 0.0f;
    for (const char *c = text; *c; c++) {
        int advance, bearing, width, height, dx, dy;
        stbtt_GetCodepointHMetrics(&font->info, *c, &advance, &bearing);
        float place = floorf(x);
        unsigned char *coverage = stbtt_GetCodepointBitmapSubpixel(
            &font->info, scale, scale, x - place, 0.0f, *c, &width, &height, &dx, &dy);
        if (coverage && grey >= 0) {
            image_glyph(to, coverage, width, height, left + (int)place + dx, baseline + dy, grey);
        }
        stbtt_FreeBitmap(coverage, NULL);
        x += scale * (float)advance;
        if (c[1]) x += scale * (float)stbtt_GetCodepointKernAdvance(&font->info, c[0], c[1]);
    }
    return x;
}

// ---- Numbers

static inline void image_mean(const image *in, double mean[3]) {
    size_t pixels = (size_t)in->width * (size_t)in->height;
    for (size_t c = 0; c < 3; c++) {
        mean[c] = 0.0;
        for (size_t i = 0; i < pixels; i++) mean[c] += (double)in->rgb[3 * i + c];
        mean[c] /= (double)pixels;
    }
}

// Relative mean squared error of `a` over the pixels of `mask`, from two references with
// independent noise: sum (a - r1)(a - r2) / sum r1 r2. The noise of r1 and that of r2 do not
// correlate, so the expectation has the true error alone in it, however noisy the references are.
// With r1 = r2 it is the plain sum (a - r)^2 / sum r^2. Below 0: not defined, since the references
// are black there.
static inline double image_relative_mse(const image *a, const image *r1, const image *r2,
                                        const unsigned char *mask) {
    size_t pixels = (size_t)a->width * (size_t)a->height;
    double error = 0.0, power = 0.0;
    for (size_t i = 0; i < 3 * pixels; i++) {
        if (!mask[i / 3]) continue;
        double x = (double)a->rgb[i], y = (double)r1->rgb[i], z = (double)r2->rgb[i];
        error += (x - y) * (x - z);
        power += y * z;
    }
    return power > 0.0 ? error / power : -1.0;
}

#endif
