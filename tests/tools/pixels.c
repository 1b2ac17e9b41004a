// pixels.c - questions about pictures. Reads PNG, and the screen as Xvfb keeps it in a file (XWD: a
// header of big endian words, then rows of blue, green, red, unused). SPDX-License-Identifier: MIT
//
// clang-format off
//     pixels size A                 its size as WxH
//     pixels bright A [X Y W H]     how many pixels of the rectangle are nearly white
//     pixels differ A B [X Y W H]   how many of 10000 pixels differ by more than 24 of 255
//                                   in some channel
//     pixels extent A [X Y W H]     where pixels differ from the rectangle's first one,
//                                   as X0 Y0 X1 Y1
//     pixels bytes A B              how many of a million bytes differ, and by how much the
//                                   worst of them does
// clang-format on
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stb/stb_image.h>

#define NOTICED 24  // of 255: less is the edge of a glyph, as another OpenGL rounds it
#define WHITE   180 // of 255

typedef struct picture {
    int width, height;
    unsigned char *rgb;
} picture;

typedef struct rectangle {
    int x, y, width, height;
} rectangle;

static unsigned word(const unsigned char *bytes, int i) {
    const unsigned char *b = bytes + 4 * i;
    return (unsigned)b[0] << 24 | (unsigned)b[1] << 16 | (unsigned)b[2] << 8 | b[3];
}

static picture load_screen(const char *path) {
    static unsigned char b[1 << 24];
    picture p = {0, 0, NULL};
    FILE *f = fopen(path, "rb");
    if (!f || fread(b, 1, sizeof b, f) <= 100) return p;
    fclose(f);

    const unsigned char *rows = b + word(b, 0) + 12 * word(b, 19);
    p.width = (int)word(b, 4);
    p.height = (int)word(b, 5);
    p.rgb = malloc((size_t)p.width * (size_t)p.height * 3);
    for (int i = 0; p.rgb && i < p.width * p.height; i++) {
        const unsigned char *from = rows + (size_t)(i / p.width) * word(b, 12) + 4 * (i % p.width);
        p.rgb[3 * i] = from[2];
        p.rgb[3 * i + 1] = from[1];
        p.rgb[3 * i + 2] = from[0];
    }
    return p;
}

static picture load(const char *path) {
    picture p = {0, 0, NULL};
    int channels;
    if (strstr(path, ".png")) p.rgb = stbi_load(path, &p.width, &p.height, &channels, 3);
    else p = load_screen(path);

    if (!p.rgb) {
        fprintf(stderr, "pixels: cannot read %s\n", path);
        exit(2);
    }
    return p;
}

// The rectangle that four words name; the whole picture without them.
static rectangle read_rectangle(const picture *p, int count, char **words) {
    rectangle r = {0, 0, p->width, p->height};
    if (count < 4) return r;
    r.x = atoi(words[0]);
    r.y = atoi(words[1]);
    r.width = atoi(words[2]);
    r.height = atoi(words[3]);
    return r;
}

static int lies_in(const rectangle *r, const picture *p) {
    return r->x + r->width <= p->width && r->y + r->height <= p->height;
}

static const unsigned char *pixel(const picture *p, int x, int y) {
    return p->rgb + 3 * (y * p->width + x);
}

static int differs(const unsigned char *a, const unsigned char *b) {
    return abs(a[0] - b[0]) > NOTICED || abs(a[1] - b[1]) > NOTICED || abs(a[2] - b[2]) > NOTICED;
}

static int bright(const picture *p, const rectangle *r) {
    int count = 0;
    for (int y = r->y; y < r->y + r->height; y++) {
        for (int x = r->x; x < r->x + r->width; x++) {
            const unsigned char *a = pixel(p, x, y);
            count += a[0] > WHITE && a[1] > WHITE && a[2] > WHITE;
        }
    }
    return count;
}

static int differ(const picture *a, const picture *b, const rectangle *r) {
    int count = 0;
    if (!lies_in(r, a) || !lies_in(r, b)) return 10000;
    for (int y = r->y; y < r->y + r->height; y++) {
        for (int x = r->x; x < r->x + r->width; x++)
            count += differs(pixel(a, x, y), pixel(b, x, y));
    }
    return (int)(1e4 * count / ((double)r->width * r->height) + 0.5);
}

static void print_extent(const picture *p, const rectangle *r) {
    const unsigned char *first = pixel(p, r->x, r->y);
    int left = p->width, top = p->height, right = -1, bottom = -1;
    for (int y = r->y; y < r->y + r->height; y++) {
        for (int x = r->x; x < r->x + r->width; x++) {
            if (!differs(pixel(p, x, y), first)) continue;
            if (x < left) left = x;
            if (x > right) right = x;
            if (y < top) top = y;
            if (y > bottom) bottom = y;
        }
    }
    printf("%d %d %d %d\n", left, top, right, bottom);
}

static int print_bytes(const picture *a, const picture *b) {
    int bytes = 3 * a->width * a->height;
    int count = 0;
    int worst = 0;
    if (a->width != b->width || a->height != b->height) return 1;
    for (int i = 0; i < bytes; i++) {
        int difference = abs(a->rgb[i] - b->rgb[i]);
        count += difference > 0;
        if (difference > worst) worst = difference;
    }
    printf("%.0f %d\n", 1e6 * count / bytes, worst);
    return 0;
}

int main(int count, char **words) {
    const char *question = count > 2 ? words[1] : "";
    int two = strcmp(question, "differ") == 0 || strcmp(question, "bytes") == 0;
    int used = two ? 4 : 3;
    if (count < used) {
        fputs("usage: pixels size|bright|extent A [X Y W H], pixels differ|bytes A B [X Y W H]\n",
              stderr);
        return 2;
    }

    picture a = load(words[2]);
    picture b = two ? load(words[3]) : a;
    rectangle r = read_rectangle(&a, count - used, words + used);
    if (strcmp(question, "differ") == 0) return printf("%d\n", differ(&a, &b, &r)) < 0;
    if (strcmp(question, "bytes") == 0) return print_bytes(&a, &b);
    if (strcmp(question, "size") == 0) return printf("%dx%d\n", a.width, a.height) < 0;
    if (!lies_in(&r, &a)) return 1;
    if (strcmp(question, "extent") == 0) print_extent(&a, &r);
    else printf("%d\n", bright(&a, &r));
    return 0;
}
