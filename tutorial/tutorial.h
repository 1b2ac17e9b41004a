// tutorial.h - what every chapter needs and none is about: vectors, random numbers, a sheet of panels as a PNG.
// SPDX-License-Identifier: MIT
#ifndef TUTORIAL_H
#define TUTORIAL_H

#include <stdarg.h>
#include "demos/common/image.h"

static const double pi = 3.14159265358979323846, far_away = 1e9;

// ---- Vectors: points, directions and colours (x, y, z = red, green, blue)

typedef struct vec {
    double x, y, z;
} vec;

static inline vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec mul(vec a, vec b) { return (vec){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline vec scale(vec a, double k) { return (vec){a.x * k, a.y * k, a.z * k}; }
static inline vec along(vec o, vec d, double t) { return add(o, scale(d, t)); }
static inline double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double length(vec a) { return sqrt(dot(a, a)); }
static inline vec unit(vec a) { return scale(a, 1 / length(a)); }
static inline double mean(vec a) { return (a.x + a.y + a.z) / 3; }
static inline double greater(double a, double b) { return a > b ? a : b; }

// Two directions at right angles to n and to each other.
static inline void frame(vec n, vec *t, vec *b) {
    *t = unit(cross(fabs(n.x) < 0.6 ? (vec){1, 0, 0} : (vec){0, 1, 0}, n));
    *b = cross(n, *t);
}

// Where a line meets a surface: the distance along it, the place and the normal.
typedef struct hit {
    double t;
    vec y, n;
} hit;

// ---- Random numbers: uniform in (0, 1), the same on every machine (PCG, O'Neill 2014)

static uint64_t rnd_state = 1;
static inline double rnd(void) {
    uint64_t old = rnd_state;
    uint32_t mixed = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    rnd_state = old * 6364136223846793005u + 1442695040888963407u;
    return ((mixed >> turn | mixed << ((32 - turn) & 31)) + 0.5) / 4294967296.0;
}
static inline vec rnd_on_unit_sphere(void) {
    double z = 2 * rnd() - 1, turn = 2 * pi * rnd(), rim = sqrt(1 - z * z);
    return (vec){rim * cos(turn), rim * sin(turn), z};
}

// ---- A sheet: panels side by side, each with a line of text above it

enum { SHEET_GAP = 12, SHEET_TITLE = 34 };
static const vec background = {0.16, 0.17, 0.19}; // what rays see that meet nothing

typedef struct sheet {
    const char *name;
    FILE *file;
    int width, height; // of a panel
    image_bytes pixels;
    image_font font;
} sheet;

// The program's one argument is the file to write. Wrong arguments end it here, before any work is done.
static inline sheet sheet_begin(int argc, char **argv, int panels, int width, int height) {
    sheet s = {argv[1], NULL, width, height, {0, 0, NULL}, {NULL, {0}}};
    if (argc != 2) {
        fprintf(stderr, "%s: usage: one argument, the PNG file to write\n", argv[0]);
        exit(2);
    }
    s.file = fopen(s.name, "wb");
    if (!s.file) {
        fprintf(stderr, "%s: %s: %s\n", argv[0], s.name, strerror(errno));
        exit(2);
    }
    const char *wrong = image_font_open(&s.font);
    if (wrong ||
        !image_bytes_new(&s.pixels, panels * (width + SHEET_GAP) + SHEET_GAP, height + SHEET_TITLE + SHEET_GAP, 250)) {
        fprintf(stderr, "%s: %s: %s\n", argv[0], FONT_FILE, wrong ? wrong : "no memory for the picture");
        exit(1);
    }
    return s;
}
static inline int sheet_left(const sheet *s, int panel) { return SHEET_GAP + panel * (s->width + SHEET_GAP); }

static inline unsigned char *sheet_at(const sheet *s, int panel, int x, int y) {
    return s->pixels.rgb + image_count(s->pixels.width, y + SHEET_TITLE) + 3 * (sheet_left(s, panel) + x);
}
// A pixel of a panel from linear radiance.
static inline void sheet_pixel(sheet *s, int panel, int x, int y, vec radiance) {
    unsigned char *rgb = sheet_at(s, panel, x, y);
    rgb[0] = image_tone((float)radiance.x, 1.0f);
    rgb[1] = image_tone((float)radiance.y, 1.0f);
    rgb[2] = image_tone((float)radiance.z, 1.0f);
}
static inline void sheet_text(sheet *s, int panel, int x, int y, const char *format, ...) {
    char text[96];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    image_text(&s->pixels, &s->font, text, 21.0f, sheet_left(s, panel) + x, SHEET_TITLE + y, 30);
}
static inline int sheet_end(sheet *s) {
    int good = image_write_png(&s->pixels, s->file);
    good &= fclose(s->file) == 0;
    if (!good) fprintf(stderr, "%s: could not be written to the end\n", s->name);
    free(s->pixels.rgb);
    free(s->font.file);
    return !good;
}

// ---- A plot in a panel: x from 0, y from y0 on a linear or a logarithmic axis; colours are bytes here

enum { PLOT_LEFT = 44, PLOT_FOOT = 30 }; // room for the numbers

typedef struct plot {
    sheet *sheet;
    int panel, log_y;
    double x1, y0, y1;
} plot;

// Where a point of the plot is, in pixels of the panel.
static inline vec plot_place(plot p, double x, double y) {
    double h = p.log_y ? log(greater(y, p.y0 * 1e-9) / p.y0) / log(p.y1 / p.y0) : (y - p.y0) / (p.y1 - p.y0);
    return (vec){PLOT_LEFT + x / p.x1 * (p.sheet->width - PLOT_LEFT), (1 - h) * (p.sheet->height - PLOT_FOOT), 0};
}
// A disc of a radius in pixels, its edge smoothed; what lies outside the plot is cut off.
static inline void plot_disc(plot p, vec at, double radius, vec colour) {
    for (int y = (int)(at.y - radius - 1); y <= (int)(at.y + radius + 1); y++) {
        for (int x = (int)(at.x - radius - 1); x <= (int)(at.x + radius + 1); x++) {
            double cover = radius + 0.5 - length((vec){x + 0.5 - at.x, y + 0.5 - at.y, 0});
            if (cover <= 0 || x < PLOT_LEFT || y < 0) continue;
            if (x >= p.sheet->width || y > p.sheet->height - PLOT_FOOT) continue;
            unsigned char *rgb = sheet_at(p.sheet, p.panel, x, y);
            double keep = cover < 1 ? 1 - cover : 0, c[3] = {colour.x, colour.y, colour.z};
            for (int i = 0; i < 3; i++) rgb[i] = (unsigned char)(rgb[i] * keep + c[i] * (1 - keep) + 0.5);
        }
    }
}
static inline void plot_point(plot p, double x, double y, double radius, vec colour) {
    plot_disc(p, plot_place(p, x, y), radius, colour);
}
static inline void plot_line(plot p, double xa, double ya, double xb, double yb, vec colour) {
    vec a = plot_place(p, xa, ya), way = sub(plot_place(p, xb, yb), a);
    int steps = 1 + (int)(3 * length(way));
    for (int i = 0; i <= steps; i++) plot_disc(p, along(a, way, (double)i / steps), 1, colour);
}
// White paper, and a faint line with its number at each step of both axes; a logarithmic axis is multiplied by its
// step.
static inline void plot_grid(plot p, double step_x, double step_y) {
    vec faint = {215, 215, 215};
    for (int y = 0; y <= p.sheet->height - PLOT_FOOT; y++)
        memset(sheet_at(p.sheet, p.panel, PLOT_LEFT, y), 255, 3 * (size_t)(p.sheet->width - PLOT_LEFT));
    for (double x = 0; x < 1.001 * p.x1; x += step_x) {
        vec at = plot_place(p, x, p.y0);
        plot_line(p, x, p.y0, x, p.y1, faint);
        sheet_text(p.sheet, p.panel, (int)at.x - (x > 0.95 * p.x1 ? 34 : 6), p.sheet->height - 6, "%g", x);
    }
    for (double y = p.y0; y < 1.001 * p.y1; y = p.log_y ? y * step_y : y + step_y) {
        vec at = plot_place(p, 0, y);
        plot_line(p, 0, y, p.x1, y, faint);
        sheet_text(p.sheet, p.panel, 0, (int)at.y + (y > 0.95 * p.y1 ? 16 : 6), "%g", y);
    }
}
// The name of a colour, in line `row` at the top right.
static inline void plot_name(plot p, int row, vec colour, const char *name) {
    int wide = (int)image_text(&p.sheet->pixels, &p.sheet->font, name, 21.0f, 0, 0, -1), y = 14 + 26 * row;
    plot_disc(p, (vec){p.sheet->width - wide - 20, y, 0}, 6, colour);
    sheet_text(p.sheet, p.panel, p.sheet->width - wide - 8, y + 7, "%s", name);
}

#endif
