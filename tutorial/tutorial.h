// tutorial.h - what every chapter needs and none is about: vectors, random numbers, a sheet of
// panels as a PNG. SPDX-License-Identifier: MIT
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
static inline vec along(vec o, vec dir, double t) { return add(o, scale(dir, t)); }
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

// Where a line meets a surface: the distance along it, the point and the normal.
typedef struct hit {
    double t;
    vec y, n;
} hit;

// ---- Random numbers: uniform in (0, 1), the same on every machine (PCG, O'Neill 2014)

static uint64_t rnd_state = 1;
static inline double rnd(void) {
    uint64_t old = rnd_state;
    uint32_t mixed = (uint32_t)(((old >> 18) ^ old) >> 27);
    uint32_t turn = (uint32_t)(old >> 59);

    rnd_state = old * 6364136223846793005u + 1442695040888963407u;
    return ((mixed >> turn | mixed << ((32 - turn) & 31)) + 0.5) / 4294967296.0;
}
static inline vec rnd_on_unit_sphere(void) {
    double z = 2 * rnd() - 1, turn = 2 * pi * rnd(), rim = sqrt(1 - z * z);

    return (vec){rim * cos(turn), rim * sin(turn), z};
}

// ---- A sheet: panels, two in a row if they are small, each with a title above it

enum { SHEET_GAP = 12, SHEET_TITLE = 34, SHEET_SMALL = 300 };
static const vec background = {0.05, 0.055, 0.07}; // radiance where a ray meets nothing
static const double white = 1.4;                   // radiance that is shown as white

typedef struct sheet {
    const char *name;
    FILE *file;
    int columns, width, height; // the latter two are of a panel
    image_bytes pixels;
    image_font font;
} sheet;

// The program's one argument is the file to write. Wrong arguments end it here, before any work.
static inline sheet sheet_begin(int argc, char **argv, int panels, int width, int height) {
    int columns = panels > 1 && width <= SHEET_SMALL ? 2 : 1, rows = (panels - 1) / columns + 1;
    sheet s = {argv[1], NULL, columns, width, height, {0, 0, NULL}, {NULL, {0}}};

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
    int full_width = columns * (width + SHEET_GAP) + SHEET_GAP;
    int full_height = rows * (height + SHEET_TITLE) + SHEET_GAP;
    if (!wrong) wrong = image_bytes_new(&s.pixels, full_width, full_height, 250);
    if (wrong) {
        fprintf(stderr, "%s: %s: %s\n", argv[0], FONT_FILE, wrong);
        exit(1);
    }
    return s;
}
static inline int sheet_left(const sheet *s, int panel) {
    return SHEET_GAP + panel % s->columns * (s->width + SHEET_GAP);
}
static inline int sheet_top(const sheet *s, int panel) {
    return SHEET_TITLE + panel / s->columns * (s->height + SHEET_TITLE);
}
static inline unsigned char *sheet_at(const sheet *s, int panel, int x, int y) {
    return s->pixels.rgb + image_count(s->pixels.width, y + sheet_top(s, panel)) +
           3 * (sheet_left(s, panel) + x);
}

// The byte of a screen (sRGB) for a brightness of 0..1. What is brighter than white is cut off.
static inline unsigned char sheet_byte(double x) {
    double y = x <= 0.0031308 ? 12.92 * greater(x, 0) : 1.055 * pow(x, 1 / 2.4) - 0.055;

    return (unsigned char)(y < 1 ? 255 * y + 0.5 : 255);
}
// A pixel of a panel from radiance. Twice the radiance is twice the light of the screen.
static inline void sheet_pixel(sheet *s, int panel, int x, int y, vec radiance) {
    unsigned char *rgb = sheet_at(s, panel, x, y);

    rgb[0] = sheet_byte(radiance.x / white);
    rgb[1] = sheet_byte(radiance.y / white);
    rgb[2] = sheet_byte(radiance.z / white);
}
// A pixel from an error: white for 0, blue down to -1 (too dark), orange up to 1 (too bright).
static inline void sheet_error(sheet *s, int panel, int x, int y, double error) {
    unsigned char *rgb = sheet_at(s, panel, x, y);
    double size = fabs(error) < 1 ? fabs(error) : 1;
    double end[2][3] = {{0, 90, 181}, {213, 94, 0}};

    for (int c = 0; c < 3; c++) {
        rgb[c] = (unsigned char)(255 + (end[error > 0][c] - 255) * size + 0.5);
    }
}

static inline void sheet_text(sheet *s, int panel, int x, int y, const char *text) {
    image_text(&s->pixels, &s->font, text, 21.0f, sheet_left(s, panel) + x,
               sheet_top(s, panel) + y, 30);
}
// Text with its middle at x.
static inline void sheet_label(sheet *s, int panel, int x, int y, const char *format, ...) {
    char text[96];
    va_list list;

    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    float wide = image_text(&s->pixels, &s->font, text, 21.0f, 0, 0, -1);
    sheet_text(s, panel, x - (int)(wide / 2), y, text);
}
static inline void sheet_title(sheet *s, int panel, const char *text) {
    sheet_label(s, panel, s->width / 2, -9, "%s", text);
}
static inline int sheet_end(sheet *s) {
    int good = !image_write_png(&s->pixels, s->file);

    good &= fclose(s->file) == 0;
    if (!good) fprintf(stderr, "%s: could not be written to the end\n", s->name);
    free(s->pixels.rgb);
    free(s->font.file);
    return !good;
}

// ---- A plot in a panel. Colours are bytes here; these differ to every eye (Okabe and Ito)

static const vec orange = {213, 94, 0}, blue = {0, 114, 178}, green = {0, 158, 115};
static const vec black = {40, 40, 40}, faint = {215, 215, 215};
enum { PLOT_LEFT = 48, PLOT_FOOT = 30 }; // room for the numbers

typedef struct plot {
    sheet *sheet;
    int panel, log_x, log_y;
    double x0, x1, y0, y1;
} plot;

// Where a point of the plot is, in pixels of the panel.
static inline double plot_share(double x, double x0, double x1, int is_log) {
    if (is_log) return log(greater(x, x0 * 1e-9) / x0) / log(x1 / x0);
    return (x - x0) / (x1 - x0);
}
static inline vec plot_place(plot p, double x, double y) {
    double u = plot_share(x, p.x0, p.x1, p.log_x), v = plot_share(y, p.y0, p.y1, p.log_y);
    int width = p.sheet->width - PLOT_LEFT, height = p.sheet->height - PLOT_FOOT;

    return (vec){PLOT_LEFT + u * width, (1 - v) * height, 0};
}
// A disc of a radius in pixels, its edge smoothed. What lies outside the plot is cut off.
static inline void plot_disc(plot p, vec at, double radius, vec colour) {
    for (int y = (int)(at.y - radius - 1); y <= (int)(at.y + radius + 1); y++) {
        for (int x = (int)(at.x - radius - 1); x <= (int)(at.x + radius + 1); x++) {
            double cover = radius + 0.5 - length((vec){x + 0.5 - at.x, y + 0.5 - at.y, 0});
            if (cover <= 0 || x < PLOT_LEFT || y < 0) continue;
            if (x >= p.sheet->width || y > p.sheet->height - PLOT_FOOT) continue;

            unsigned char *rgb = sheet_at(p.sheet, p.panel, x, y);
            double keep = cover < 1 ? 1 - cover : 0, c[3] = {colour.x, colour.y, colour.z};
            for (int i = 0; i < 3; i++) {
                rgb[i] = (unsigned char)(rgb[i] * keep + c[i] * (1 - keep) + 0.5);
            }
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
// White paper, and a faint line with its number at each step of both axes. A logarithmic axis is
// multiplied by its step.
static inline void plot_grid(plot p, double step_x, double step_y) {
    sheet *s = p.sheet;
    double x_end = p.x1 + 0.001 * fabs(p.x1), y_end = p.y1 + 0.001 * fabs(p.y1);

    for (int y = 0; y <= s->height - PLOT_FOOT; y++) {
        memset(sheet_at(s, p.panel, PLOT_LEFT, y), 255, 3 * (size_t)(s->width - PLOT_LEFT));
    }
    for (double x = p.x0; x < x_end; x = p.log_x ? x * step_x : x + step_x) {
        int at = (int)plot_place(p, x, p.y0).x;
        plot_line(p, x, p.y0, x, p.y1, faint);
        sheet_label(s, p.panel, at > s->width - 16 ? s->width - 16 : at, s->height - 6, "%g", x);
    }
    for (double y = p.y0; y < y_end; y = p.log_y ? y * step_y : y + step_y) {
        int at = (int)plot_place(p, p.x0, y).y;
        plot_line(p, p.x0, y, p.x1, y, faint);
        sheet_label(s, p.panel, PLOT_LEFT / 2, at + (at < 10 ? 16 : 6), "%g", y);
    }
}
// The name of a colour, in line `row` at the top right.
static inline void plot_name(plot p, int row, vec colour, const char *name) {
    int wide = (int)image_text(&p.sheet->pixels, &p.sheet->font, name, 21.0f, 0, 0, -1);
    int y = 16 + 26 * row;

    plot_disc(p, (vec){p.sheet->width - wide - 20, y, 0}, 6, colour);
    sheet_text(p.sheet, p.panel, p.sheet->width - wide - 8, y + 7, name);
}

#endif
