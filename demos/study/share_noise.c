// share_noise.c - what the noise of shared exits looks like: a part of the bear, each exit for its
// own lookup on the left and shared on the right, after 1 and after 16 samples a pixel, with the
// error below. Usage: share_noise FILE.png
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "share_noise"
#include "demos/common/command.h"
#include "demos/common/files.h"
#include "demos/common/tracer.h"

#define WIDTH     360 // of the whole picture
#define HEIGHT    400
#define LEFT      78 // of the part
#define TOP       140
#define SIDE      84
#define ZOOM      4
#define REFERENCE 256 // samples a pixel of brute force, in each of two halves
#define MARGIN    16
#define CAPTION   264

enum { OWN_1, SHARED_1, OWN_16, SHARED_16, PANELS };
static const char *const title[PANELS] = {"own exits", "shared", "own exits", "shared"};
enum { CAPTION_LINES = 3 };
static const char *const caption[CAPTION_LINES] = {
    "All lookups have a light hint. A shared exit serves 8 x 8 pixels. Lower row: the error. It is "
    "grey",
    "where there is none, and four times as strong in the two panels on the right. Correlation: of "
    "the",
    "errors of neighbouring pixels."};
static const int samples[PANELS] = {1, 1, 16, 16};

static void add(image *part, int x, int y, sss_vec3 radiance) {
    x -= LEFT;
    y -= TOP;
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return;
    float *rgb = part->rgb + 3 * (size_t)(y * SIDE + x);
    rgb[0] += radiance.x;
    rgb[1] += radiance.y;
    rgb[2] += radiance.z;
}

static void add_tiles(const scene *s, tracer_settings settings, uint32_t sample, image *part) {
    int columns = tracer_tile_count(settings, sample, 0),
        rows = tracer_tile_count(settings, sample, 1);
#pragma omp parallel for schedule(dynamic)
    for (int number = 0; number < columns * rows; number++) {
        tracer_tile tile;
        sss_vec3 radiance[TRACER_TILE_PIXELS];
        int column = number % columns, row = number / columns, x, y;
        tracer_tile_pixel(settings, sample, column, row, 0, &x, &y);
        if (x + TRACER_MAX_TILE <= LEFT || x >= LEFT + SIDE) continue;
        if (y + TRACER_MAX_TILE <= TOP || y >= TOP + SIDE) continue;

        tracer_tile_sample(s, settings, column, row, sample, &tile, radiance);
        for (int i = 0; i < TRACER_TILE_PIXELS; i++)
            if (tracer_tile_pixel(settings, sample, column, row, i, &x, &y))
                add(part, x, y, radiance[i]);
    }
}

static void add_pixels(const scene *s, tracer_settings settings, uint32_t sample, image *part) {
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < SIDE * SIDE; i++) {
        int x = LEFT + i % SIDE, y = TOP + i / SIDE;
        add(part, x, y, tracer_sample(s, settings, x, y, sample).radiance);
    }
}

static image render(const scene *s, tracer_settings settings, int count) {
    image part;
    if (image_new(&part, SIDE, SIDE)) fail(1, "out of memory");
    for (uint32_t k = 0; k < (uint32_t)count; k++) {
        if (tracer_tile_side(settings) > 1) add_tiles(s, settings, k, &part);
        else add_pixels(s, settings, k, &part);
    }
    for (int i = 0; i < 3 * SIDE * SIDE; i++) part.rgb[i] /= (float)count;
    return part;
}

// Pixel (x, y)'s error, the mean of its colours.
static double error_at(const image *part, const image truth[2], int x, int y) {
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        size_t i = 3 * (size_t)(y * SIDE + x) + (size_t)c;
        sum += (double)part->rgb[i] - 0.5 * (double)(truth[0].rgb[i] + truth[1].rgb[i]);
    }
    return sum / 3.0;
}

// The correlation of a pixel's error with its right neighbour's, both on the object.
static double correlation(const image *part, const image truth[2], const unsigned char *mask) {
    double product = 0.0, square = 0.0;
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x + 1 < SIDE; x++) {
            if (!mask[y * SIDE + x] || !mask[y * SIDE + x + 1]) continue;
            double a = error_at(part, truth, x, y), b = error_at(part, truth, x + 1, y);
            product += a * b;
            square += 0.5 * (a * a + b * b);
        }
    }
    return product / square;
}

// The part, or its error about grey, `scale` times; each pixel ZOOM large.
static void draw(image_bytes *sheet, const image *part, const image truth[2], float scale, int left,
                 int top) {
    for (int i = 0; i < SIDE * ZOOM * SIDE * ZOOM; i++) {
        int x = i % (SIDE * ZOOM), y = i / (SIDE * ZOOM), from = y / ZOOM * SIDE + x / ZOOM;
        unsigned char *to = sheet->rgb + 3 * (size_t)((top + y) * sheet->width + left + x);
        float error = 0.5f + scale * (float)error_at(part, truth, x / ZOOM, y / ZOOM);
        for (int c = 0; c < 3; c++) {
            float linear = part->rgb[3 * from + c];
            to[c] = scale > 0.0f
                        ? (unsigned char)(255.0f * scene_min(scene_max(error, 0.0f), 1.0f) + 0.5f)
                        : image_tone(linear, 1.0f);
        }
    }
}

static void draw_sheet(const char *path, const image *part, const image truth[2],
                       const unsigned char *mask) {
    const int panel = SIDE * ZOOM;
    image_font font;
    image_bytes sheet;
    const char *wrong = image_font_open(&font);
    if (wrong) fail(1, "cannot read the font %s: %s", FONT_FILE, wrong);
    int height = 2 * panel + 3 * MARGIN + CAPTION;
    if (image_bytes_new(&sheet, PANELS * (panel + MARGIN) + MARGIN, height, 250))
        fail(1, "out of memory");
    double before = 0.0;
    for (int i = 0; i < PANELS; i++) {
        char line[120];
        int left = MARGIN + i * (panel + MARGIN), below = 2 * panel + 2 * MARGIN;
        float scale = samples[i] == 1 ? 1.0f : 4.0f;
        draw(&sheet, &part[i], truth, 0.0f, left, MARGIN);
        draw(&sheet, &part[i], truth, scale, left, 2 * MARGIN + panel);
        image_text(&sheet, &font, title[i], 38.0f, left, below + 38, 20);
        double error = image_relative_mse(&part[i], &truth[0], &truth[1], mask);
        double neighbours = correlation(&part[i], truth, mask);
        snprintf(line, sizeof line, "%d sample%s", samples[i], samples[i] == 1 ? "" : "s");
        image_text(&sheet, &font, line, 32.0f, left, below + 74, 20);
        snprintf(line, sizeof line, "relative MSE %.4f", error);
        image_text(&sheet, &font, line, 32.0f, left, below + 110, 20);
        snprintf(line, sizeof line, "correlation %.2f", neighbours);
        image_text(&sheet, &font, line, 32.0f, left, below + 146, 20);
        printf("%s, %d: relative MSE %.5f, correlation of neighbours %.2f\n", title[i], samples[i],
               error, neighbours);
        if (i % 2)
            printf("shared over own exits, %d: %.2g times lower\n", samples[i], before / error);
        before = error;
    }
    for (int i = 0; i < CAPTION_LINES; i++) {
        int baseline = height - MARGIN - 34 * (CAPTION_LINES - 1 - i);
        image_text(&sheet, &font, caption[i], 29.0f, MARGIN, baseline, 60);
    }
    wrong = file_write_png(path, &sheet);
    if (wrong) fail(1, "cannot write %s: %s", path, wrong);
    free(sheet.rgb);
    free(font.file);
}

int main(int count, char **words) {
    if (count != 2 || words[1][0] == '-') fail(2, "usage: share_noise FILE.png");
    const char *wrong = output_try(words[1]);
    if (wrong) fail(2, "cannot write %s: %s", words[1], wrong);
    scene s;
    image part[PANELS], truth[2];
    static unsigned char mask[SIDE * SIDE];
    tracer_settings settings;
    load_scene(&s, SCENES_BEAR, "burley", 1.0f);
    memset(&settings, 0, sizeof settings);
    settings.width = WIDTH;
    settings.height = HEIGHT;
    settings.method = TRACER_REFERENCE;
    for (int h = 0; h < 2; h++) {
        settings.seed = h ? 0x48414c46u : 0x68616c66u;
        truth[h] = render(&s, settings, REFERENCE);
    }
    settings.method = TRACER_RESAMPLED;
    settings.light_aware = 1;
    settings.seed = 1;
    for (int i = 0; i < PANELS; i++) {
        settings.plan.tile = i == SHARED_1 || i == SHARED_16 ? 8 : 0;
        part[i] = render(&s, settings, samples[i]);
    }
    for (int i = 0; i < SIDE * SIDE; i++)
        mask[i] =
            (unsigned char)tracer_sees_object(&s, WIDTH, HEIGHT, LEFT + i % SIDE, TOP + i / SIDE);
    draw_sheet(words[1], part, truth, mask);
    for (int i = 0; i < PANELS; i++) free(part[i].rgb);
    free(truth[0].rgb);
    free(truth[1].rgb);
    return 0;
}
