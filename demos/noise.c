// noise.c - one picture rendered twice at the same price, plain on the left and resampled on the
// right, and the error of both, while it grows. In a window, or as a PNG. See --help.
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "noise"
#include "common/device.h"
#include "common/pair.h"

#define WIDTH   300 // of the picture in pixels; shown twice as large
#define HEIGHT  260
#define SLICE   0.012 // seconds that one step of rendering may take
#define REFRESH 0.080 // between two frames, unless there is an event
#define ENOUGH  4096  // samples a pixel in each half of the reference

static const char usage[] =
    "usage: noise [options]\n"
    "Renders a scene twice at the same price: plain on the left, resampled on the right, and the "
    "error of both.\n"
    "\n" WINDOW_HELP_SCENE "  --light-aware      give the library a light hint at each candidate\n"
    "  --share            the resampled half shares its exits over tiles of pixels\n"
    "  --same-time        the same time for both, not the same number of shaded points\n"
    "  --device NAME      cpu (default), opencl, opencl:NUMBER or opencl:all\n"
    "  --against FILE     measure the error against this PFM, whose size the pictures take\n"
    "  --spp N            headless: samples a pixel of the resampled half (4)\n"
    "  --reference N      headless: samples a pixel of the reference (48)\n" WINDOW_HELP_FILES
        WINDOW_HELP_INTERRUPT;

enum {
    PLAIN,
    RESAMPLED,
    HALF,
    OTHER_HALF,
    RUNS
}; // the last two: a reference in two halves with independent noise

// A picture that grows, pass by pass of one sample a pixel, each from the top row to the bottom.
typedef struct run {
    tracer_settings settings;
    image sum, mean;
    image_bytes shown, error; // tone-mapped; the difference from the reference
    GLuint shown_texture, error_texture;
    int row;      // of the pass under way: a row of pixels, or of tiles
    uint32_t spp; // complete passes
    device_work work;
    double seconds, rate; // rows a second
} run;

typedef struct noise {
    window w;
    int light_aware, same_time, shares;
    uint32_t spp, reference;
    const char *against, *device;
    scene s;
    run run[RUNS];
    unsigned char *mask;
    double power, relative_mse[2],
        measured; // power: root mean square of the reference; measured: when
    float worst;  // error at the end of the colour bar: twice the mean of plain
    device_set devices, opening;
    job opener;
    scene first_scene; // for the first launch on it
    tracer_settings first_settings;
    sss_cl_result open_result;
    float divider; // 0..1
    int dragging, changed;
} noise;

// ---- Rendering in slices

static void clear(run *r) {
    size_t count = image_count(r->sum.width, r->sum.height);
    memset(r->sum.rgb, 0, count * sizeof *r->sum.rgb);
    memset(r->mean.rgb, 0, count * sizeof *r->mean.rgb);
    if (r->shown.rgb) memset(r->shown.rgb, 0, count);
    if (r->error.rgb) memset(r->error.rgb, 0, count);
    memset(&r->work, 0, sizeof r->work);
    r->row = 0;
    r->spp = 0;
    r->seconds = 0.0;
}

// Tiles as the plan advises them, on the right alone.
static void set_sharing(noise *n, int which) {
    tracer_settings *settings = &n->run[which].settings;
    float footprint = tracer_footprint(&n->s, *settings, n->s.shape[0].center);
    sss_plan advice = tracer_sharing(&n->s.medium, footprint, settings->light_aware);
    int shares = which == RESAMPLED && n->shares;
    settings->plan.tile = shares ? advice.tile : 0;
    settings->plan.per_channel = shares && advice.per_channel;
}

static void restart(noise *n, int reference_too) {
    for (int i = 0; i < (reference_too && !n->against ? RUNS : HALF); i++) {
        tracer_settings *settings = &n->run[i].settings;
        settings->method = i == PLAIN       ? TRACER_PLAIN
                           : i == RESAMPLED ? TRACER_RESAMPLED
                                            : TRACER_REFERENCE;
        settings->light_aware = i == RESAMPLED && n->light_aware;
        settings->plan.candidates = n->w.candidates;
        settings->seed = i == HALF         ? n->w.seed ^ 0x68616c66u
                         : i == OTHER_HALF ? n->w.seed ^ 0x48414c46u
                                           : n->w.seed;
        set_sharing(n, i);
        clear(&n->run[i]);
    }
    n->relative_mse[0] = n->relative_mse[1] = -1.0;
    n->measured = 0.0;
}

static void set_scene(noise *n) {
    int width = n->run[0].settings.width, height = n->run[0].settings.height;
    load_scene(&n->s, n->w.scene, window_profile[n->w.profile], 1.0f);
    for (int i = 0; i < width * height; i++) {
        n->mask[i] = (unsigned char)tracer_sees_object(&n->s, width, height, i % width, i / width);
    }
    restart(n, 1);
}

// Rows top .. bottom - 1, which the pass under way has just done, as means, and as the screen shows
// them.
static void show_rows(noise *n, int which, int top, int bottom) {
    run *r = &n->run[which];
    for (int y = top; y < bottom; y++) {
        float scale = 1.0f / (float)(r->spp + 1u);
        for (size_t i = image_count(r->sum.width, y); i < image_count(r->sum.width, y + 1); i++) {
            r->mean.rgb[i] = r->sum.rgb[i] * scale;
            if (which < HALF) r->shown.rgb[i] = image_tone(r->mean.rgb[i], 1.0f);
        }
    }
}

static void show_error(noise *n, int which) {
    run *r = &n->run[which];
    const float *one = n->run[HALF].mean.rgb, *other = n->run[OTHER_HALF].mean.rgb;
    for (size_t i = 0; i < image_count(r->mean.width, r->mean.height); i += 3) {
        float squares = 0.0f;
        for (size_t k = i; k < i + 3; k++) {
            float e = r->mean.rgb[k] - 0.5f * (one[k] + other[k]);
            squares += e * e;
        }
        unsigned colour = canvas_scale(sqrtf(squares / 3.0f) / (n->worst * (float)n->power));
        for (size_t k = 0; k < 3; k++)
            r->error.rgb[i + k] = (unsigned char)(colour >> (24 - 8 * k));
    }
}

// Once all pictures have a whole pass: the errors so far.
static void measure(noise *n) {
    const image *one = &n->run[HALF].mean, *other = &n->run[OTHER_HALF].mean;
    double power = 0.0, pixels = 1e-9;
    if (!n->changed || !n->run[HALF].spp || !n->run[OTHER_HALF].spp) return;
    for (size_t i = 0; i < image_count(one->width, one->height); i++) {
        if (!n->mask[i / 3]) continue;
        power += (double)one->rgb[i] * (double)other->rgb[i];
        pixels += 1.0;
    }
    n->power = sqrt(power > 0.0 ? power / pixels : 1.0);
    for (int i = PLAIN; i <= RESAMPLED; i++) {
        if (n->run[i].spp)
            n->relative_mse[i] = image_relative_mse(&n->run[i].mean, one, other, n->mask);
    }
    n->worst = n->relative_mse[PLAIN] > 0.0 ? 2.0f * sqrtf((float)n->relative_mse[PLAIN]) : 1.0f;
    for (int i = PLAIN; i <= RESAMPLED; i++) {
        if (n->run[i].spp) show_error(n, i);
    }
    n->changed = 0;
    n->measured = now();
}

// The next rows of a pass: whoever is free takes one, or a device as many as it should do in a
// quarter of the slice, until the slice's time is over.
static void render_slice(noise *n, int which) {
    run *r = &n->run[which];
    double start = now(), end = n->w.headless ? 1e30 : start + SLICE;
    int bands = device_bands(r->settings, r->spp), next = r->row, count = n->devices.count,
        rows = 1, failed = 0;
    if (count > 0)
        rows =
            n->w.headless ? (bands + count - 1) / count : 1 + (int)(0.25 * SLICE * r->rate / count);
    unsigned long long probes = 0, shaded = 0;
#pragma omp parallel num_threads(device_threads(&n->devices)) reduction(+ : probes, shaded)
    {
        device_work mine = {0, 0};
        while (now() < end) {
            int top, bottom;
#pragma omp atomic capture
            bottom = next += rows;
            top = bottom - rows;
            if (top >= bands) break;
            if (bottom > bands) bottom = bands;
            if (device_band(&n->devices, device_thread(), &n->s, r->settings, top, bottom, r->spp,
                            1, r->sum.rgb, &mine) == SSS_CL_OK)
                continue;
#pragma omp atomic write
            failed = device_thread() + 1;
            break;
        }
        probes += mine.probes;
        shaded += mine.shaded;
    }
    if (failed) fail(1, "%s", n->devices.cl[failed - 1].cl.error);
    if (next > bands) next = bands;
    int top = r->row;
    r->work.probes += probes;
    r->work.shaded += shaded;
    r->seconds += now() - start;
    r->rate = (next - top) / (now() - start + 1e-9);
    r->row = next;
    show_rows(n, which, device_band_top(r->settings, r->spp, top),
              device_band_top(r->settings, r->spp, next));
    if (next == bands) r->row = 0, r->spp++;
    n->changed = 1;
}

// Whose turn it is; -1 when all is done. Plain and resampled take turns by whole passes, so that
// they cost the same; the reference has half of the time.
static int next_run(const noise *n) {
    const run *plain = &n->run[PLAIN], *resampled = &n->run[RESAMPLED], *half = &n->run[HALF];
    const run *other = &n->run[OTHER_HALF];
    uint32_t limit = n->w.headless ? n->spp : 1u << 30,
             enough = n->w.headless ? n->reference / 2 : ENOUGH;
    double passes =
        plain->spp > 0 ? plain->spp : 1; // the pass that brings plain nearest to even is its last
    int behind = n->same_time ? plain->seconds * (1.0 + 0.5 / passes) < resampled->seconds
                              : (double)plain->work.shaded * (1.0 + 0.5 / passes) <
                                    (double)resampled->work.shaded;
    int pair = plain->row > 0 ? PLAIN : resampled->row > 0 ? RESAMPLED : behind ? PLAIN : RESAMPLED;
    if (pair == RESAMPLED && resampled->spp >= limit) pair = -1;
    if (n->against || other->spp >= enough) return pair;
    if (pair >= 0 && half->seconds + other->seconds > plain->seconds + resampled->seconds)
        return pair;
    return half->spp > other->spp ? OTHER_HALF : HALF;
}

// ---- Devices: opening one may take seconds, and must not stop the window

static void open_device(void *argument) {
    noise *n = (noise *)argument;
    n->open_result = device_open(&n->opening, "opencl");
    if (n->open_result != SSS_CL_OK) return;
    unsigned long long probes = 0, shaded = 0; // the first launch compiles once more
    static float rgb[3 * 16 * 16];
    n->open_result = tracer_cl_render(&n->opening.cl[0], &n->first_scene, n->first_settings, 0, 16,
                                      0, 1, rgb, &probes, &shaded);
    if (n->open_result != SSS_CL_OK)
        memcpy(n->opening.error, n->opening.cl[0].cl.error, sizeof n->opening.error);
}

static void begin_opening(noise *n) {
    n->first_scene = n->s;
    n->first_settings = n->run[RESAMPLED].settings;
    n->first_settings.width = n->first_settings.height = 16;
    snprintf(n->w.note, sizeof n->w.note, "opening an OpenCL device ...");
    job_begin(&n->opener, open_device, n);
}

// Takes the device when it is there. The pictures go on where they are: the samples are the same on
// every device.
static void end_opening(noise *n) {
    if (!job_ends(&n->opener, 0)) return;
    if (n->open_result == SSS_CL_OK) {
        n->devices = n->opening;
        snprintf(n->w.note, sizeof n->w.note, "device: %s", n->devices.cl[0].cl.device.name);
    } else {
        device_close(&n->opening);
        snprintf(n->w.note, sizeof n->w.note, "%.200s", n->opening.error);
    }
    puts(n->w.note);
    fflush(stdout);
    for (int i = 0; i < RUNS; i++) n->run[i].rate = 0.0;
}

static void switch_device(noise *n) {
    if (n->opener.runs) return;
    if (n->devices.count == 0) {
        begin_opening(n);
        return;
    }
    device_close(&n->devices);
    for (int i = 0; i < RUNS; i++) n->run[i].rate = 0.0;
    snprintf(n->w.note, sizeof n->w.note, "back on the CPU");
}

// ---- Drawing

// Where the pictures (0) or their errors (1) are.
static box view_box(const noise *n, const canvas *c, int which) {
    return pair_box(c, which, n->run[0].settings.width, n->run[0].settings.height);
}

// The left part of one texture and the right part of another, with the divider between.
static void draw_split(const noise *n, canvas *c, box b, GLuint left, GLuint right) {
    float cut = n->divider, x = b.x + cut * b.width;
    const float at[2][4] = {{b.x, b.y, cut * b.width, b.height},
                            {x, b.y, (1.0f - cut) * b.width, b.height}};
    const float uv[2][4] = {{0.0f, 0.0f, cut, 1.0f}, {cut, 0.0f, 1.0f, 1.0f}};
    canvas_image(c, left, at[0], uv[0], 0xffffffffu);
    canvas_image(c, right, at[1], uv[1], 0xffffffffu);
    canvas_rectangle(c, x - 1.5f, b.y, 3.0f, b.height, 0xffffffffu);
    canvas_point(c, x, b.y + 0.5f * b.height, 9.0f, 0xffffffffu);
    canvas_line(c, x - 2.0f, b.y + 0.5f * b.height - 4.0f, x - 2.0f, b.y + 0.5f * b.height + 4.0f,
                1.6f, PAGE);
    canvas_line(c, x + 2.0f, b.y + 0.5f * b.height - 4.0f, x + 2.0f, b.y + 0.5f * b.height + 4.0f,
                1.6f, PAGE);
}

static const char *right_name(const noise *n) {
    if (!n->run[RESAMPLED].settings.plan.tile) return pair_resampled_name(n->light_aware);
    return n->light_aware ? "shared, light hint" : "shared";
}

static void draw_run(const noise *n, canvas *c, int which, float x, float y, int side) {
    const run *r = &n->run[which];
    char text[160];
    snprintf(text, sizeof text, "%s: error %.4f", which == PLAIN ? "plain" : right_name(n),
             n->relative_mse[which]);
    if (n->relative_mse[which] < 0.0)
        snprintf(text, sizeof text, "%s", which == PLAIN ? "plain" : right_name(n));
    canvas_text(c, x, y, 19.0f, side, which == PLAIN ? TEXT : CHOSEN, text);
    snprintf(text, sizeof text, "%.1f samples a pixel in %.1f s",
             (double)r->spp + (double)r->row / device_bands(r->settings, r->spp), r->seconds);
    canvas_text(c, x, y + 22.0f, 14.0f, side, QUIET, text);
    snprintf(text, sizeof text, "%.2f million points shaded", 1e-6 * (double)r->work.shaded);
    canvas_text(c, x, y + 41.0f, 14.0f, side, QUIET, text);
}

static void draw_colours(const noise *n, canvas *c, float right, float y) {
    char text[32];
    window_colour_bar(c, right - 200.0f, y, 200.0f, 12.0f);
    canvas_text(c, right - 210.0f, y + 11.0f, 13.5f, CANVAS_RIGHT, QUIET,
                "error of a pixel, over the mean of the object:  0");
    snprintf(text, sizeof text, "%.0f %%", 100.0 * (double)n->worst);
    canvas_text(c, right + 8.0f, y + 11.0f, 13.5f, CANVAS_LEFT, QUIET, text);
}

static void draw_reference(const noise *n, canvas *c, float x, float y) {
    char text[200];
    double plain = n->relative_mse[PLAIN], resampled = n->relative_mse[RESAMPLED];
    const char *price = n->same_time ? "in the same time" : "for the same number of shaded points";
    text[0] = '\0';
    if (resampled > 0.0 && plain > resampled) {
        snprintf(text, sizeof text, "%.1f times less error %s", plain / resampled, price);
    } else if (plain > 0.0 && resampled > 0.0) {
        snprintf(text, sizeof text, "%.1f times more error %s", resampled / plain, price);
    }
    canvas_text(c, x, y, 19.0f, CANVAS_RIGHT, CHOSEN, text);
    canvas_text(c, x, y + 22.0f, 14.0f, CANVAS_RIGHT, QUIET,
                "Error: relative mean square over the object, against");
    snprintf(text, sizeof text,
             "brute force, so far %u samples a pixel; its own noise cancels out of the number",
             n->run[HALF].spp + n->run[OTHER_HALF].spp);
    canvas_text(c, x, y + 41.0f, 14.0f, CANVAS_RIGHT, QUIET, n->against ? n->against : text);
}

static void draw_keys(noise *n, canvas *c, float y) {
    float x = window_first_keys(&n->w, MARGIN, y);
    x = canvas_key(c, x, y, 'L', n->light_aware ? "no light hint" : "light hint");
    x = canvas_key(c, x, y, 'H', n->shares ? "share nothing" : "share exits");
    x = canvas_key(c, x, y, 'T', n->same_time ? "same points" : "same time");
    x = canvas_key(c, x, y, 'D',
                   n->opener.runs         ? "opening ..."
                   : n->devices.count > 0 ? "use the CPU"
                                          : "use OpenCL");
    x = canvas_key(c, x, y, 'R', "restart");
    x = window_last_keys(&n->w, x, y);
    canvas_text(c, x, y, 13.0f, CANVAS_LEFT, TEXT, n->w.note);
}

static void draw(noise *n, canvas *c) {
    char text[200];
    canvas_begin(c, PAGE);
    const box b = view_box(n, c, 0), e = view_box(n, c, 1);
    for (int i = PLAIN; i <= RESAMPLED; i++) {
        run *r = &n->run[i];
        canvas_upload(c, &r->shown_texture, r->shown.width, r->shown.height, 3, r->shown.rgb, 1);
        canvas_upload(c, &r->error_texture, r->error.width, r->error.height, 3, r->error.rgb, 1);
    }
    canvas_text(c, b.x, 38.0f, 28.0f, CANVAS_LEFT, TEXT,
                n->same_time ? "Rendered in the same time: which is noisier?"
                             : "The same number of shaded points: which is noisier?");
    char shared[64] = "";
    int tile = n->run[RESAMPLED].settings.plan.tile;
    if (tile) snprintf(shared, sizeof shared, ", which serves %d x %d pixels", tile, tile);
    snprintf(text, sizeof text,
             "Plain probes find one exit at a time and shade it. Resampling finds %d candidates "
             "and shades "
             "the one it picks%s.%s",
             n->w.candidates, shared, n->w.headless ? "" : " Drag the line.");
    canvas_text(c, b.x, 64.0f, 16.0f, CANVAS_LEFT, QUIET, text);
    draw_split(n, c, b, n->run[PLAIN].shown_texture, n->run[RESAMPLED].shown_texture);
    canvas_look(c);
    draw_split(n, c, e, n->run[PLAIN].error_texture, n->run[RESAMPLED].error_texture);
    canvas_look(c);
    pair_label(c, b.x, b.y, CANVAS_LEFT, TEXT, "plain");
    pair_label(c, b.x + b.width, b.y, CANVAS_RIGHT, CHOSEN, right_name(n));
    pair_label(c, e.x, e.y, CANVAS_LEFT, TEXT, "error of plain");
    pair_label(c, e.x + e.width, e.y, CANVAS_RIGHT, CHOSEN,
               n->run[RESAMPLED].settings.plan.tile ? "error of shared" : "error of resampled");
    if (n->measured > 0.0) draw_colours(n, c, e.x + e.width - 50.0f, e.y - 20.0f);
    else
        canvas_text(c, e.x + 0.75f * e.width, e.y + 0.5f * e.height, 16.0f, CANVAS_CENTRE, QUIET,
                    "the first pass is under way");
    draw_run(n, c, PLAIN, b.x, b.y + b.height + 26.0f, CANVAS_LEFT);
    draw_run(n, c, RESAMPLED, b.x + b.width, b.y + b.height + 26.0f, CANVAS_RIGHT);
    draw_reference(n, c, e.x + e.width, e.y + e.height + 26.0f);
    if (!n->w.headless) draw_keys(n, c, c->height - 14.0f);
}

// ---- The window

// Returns 0 for the key that ends the program.
static int press_key(noise *n, int code) {
    window_change change = window_key(&n->w, code);
    if (change == WINDOW_SCENE || change == WINDOW_PROFILE) n->against = NULL, set_scene(n);
    if (change == WINDOW_CANDIDATES) restart(n, 0);
    if (code == 'L') n->light_aware = !n->light_aware, restart(n, 0);
    if (code == 'H') n->shares = !n->shares, restart(n, 0);
    if (code == 'T') n->same_time = !n->same_time;
    if (code == 'D') switch_device(n);
    if (code == 'R') restart(n, 1);
    return change != WINDOW_QUIT;
}

static void drag(noise *n, const canvas *c, const canvas_event *event) {
    for (int i = 0; i < 2; i++) {
        const box b = view_box(n, c, i);
        if (event->x < b.x - 20.0f || event->x > b.x + b.width + 20.0f) continue;
        n->divider = scene_max(0.0f, scene_min(1.0f, (event->x - b.x) / b.width));
        if (event->x <= b.x + b.width) return;
    }
}

static int handle(noise *n, canvas *c) {
    canvas_event event;
    while (!n->w.save &&
           canvas_next_event(c, &event)) { // what follows W belongs into the next frame
        if (event.kind == CANVAS_KEY && !press_key(n, event.code)) return 0;
        if (event.kind == CANVAS_PRESS) n->dragging = event.y > TOP && event.y < c->height - FOOTER;
        if (event.kind == CANVAS_RELEASE) n->dragging = 0;
        if (n->dragging && (event.kind == CANVAS_PRESS || event.kind == CANVAS_MOVE))
            drag(n, c, &event);
    }
    return !canvas_closing(c);
}

static void run_window(noise *n, canvas *c) {
    while (handle(n, c)) {
        int which = 0, asked = 0;
        end_opening(n);
        for (double end = now() + REFRESH; which >= 0 && !asked && now() < end;
             asked = canvas_poll(c, 0.0)) {
            which = next_run(n);
            if (which >= 0) render_slice(n, which);
        }
        if (now() - n->measured > 0.2) measure(n);
        draw(n, c);
        window_show(&n->w);
        canvas_poll(c, which < 0 ? REFRESH : 0.0);
    }
}

// ---- Command line

// How many words the option takes.
static int parse_option(noise *n, const char *name, const char *value) {
    int taken = window_option(&n->w, usage, name, value);
    if (taken) return taken;
    if (strcmp(name, "--light-aware") == 0) return n->light_aware = 1;
    if (strcmp(name, "--share") == 0) return n->shares = 1;
    if (strcmp(name, "--same-time") == 0) return n->same_time = 1;
    if (is_option("--device", name, value)) {
        n->device = parse_device(name, value);
    } else if (is_option("--against", name, value)) {
        n->against = value;
    } else if (is_option("--spp", name, value)) {
        n->spp = (uint32_t)parse_number(name, value, 1, 1000000);
    } else if (is_option("--reference", name, value)) {
        n->reference = (uint32_t)parse_number(name, value, 2, 1000000);
    } else {
        fail(2, "unknown option '%s'; --help lists what there is", name);
    }
    return 2;
}

static void make_pictures(noise *n) {
    int width = WIDTH, height = HEIGHT;
    image against = {0, 0, NULL};
    const char *wrong = n->against ? file_read_pfm(&against, n->against, NULL) : NULL;
    if (wrong) fail(2, "cannot read %s: %s", n->against, wrong);
    if (n->against) width = against.width, height = against.height;
    n->mask = (unsigned char *)malloc((size_t)width * (size_t)height);
    int good = n->mask != NULL;
    for (int i = 0; i < RUNS; i++) {
        run *r = &n->run[i];
        good &= !image_new(&r->sum, width, height) && !image_new(&r->mean, width, height);
        if (i < HALF)
            good &= !image_bytes_new(&r->shown, width, height, 0) &&
                    !image_bytes_new(&r->error, width, height, 0);
        r->settings.width = width;
        r->settings.height = height;
        if (i < HALF || !n->against) continue;
        memcpy(r->mean.rgb, against.rgb, image_count(width, height) * sizeof *against.rgb);
        r->spp = 1;
    }
    if (!good) fail(1, "out of memory");
    free(against.rgb);
}

static void free_pictures(noise *n) {
    for (int i = 0; i < RUNS; i++) {
        free(n->run[i].sum.rgb);
        free(n->run[i].mean.rgb);
        free(n->run[i].shown.rgb);
        free(n->run[i].error.rgb);
    }
    free(n->mask);
}

// Returns the exit code, unless the picture cannot be written.
static int render_headless(noise *n, canvas *c) {
    int which;
    interrupt_await();
    while ((which = next_run(n)) >= 0 && !interrupted()) render_slice(n, which);
    if (which >= 0) {
        fprintf(stderr, "noise: stopped after %u of %u samples a pixel\n", n->run[RESAMPLED].spp,
                n->spp);
    }
    measure(n);
    draw(n, c);
    window_save(&n->w);
    return which >= 0 ? 130 : 0;
}

int main(int count, char **words) {
    static noise n;
    canvas *c = &n.w.c;
    window_defaults(&n.w);
    n.spp = 4;
    n.reference = 48;
    n.divider = 0.5f;
    n.device = "cpu";
    for (int i = 1; i < count;)
        i += parse_option(&n, words[i], i + 1 < count ? words[i + 1] : NULL);
    const char *wrong = output_try(n.w.png);
    if (wrong) fail(2, "cannot write %s: %s", n.w.png, wrong);
    make_pictures(&n);
    set_scene(&n);
    pthread_mutex_init(&n.opener.lock, NULL);
    sss_cl_result opened = device_open(&n.devices, n.device);
    if (opened != SSS_CL_OK) fail((int)opened, "%s", n.devices.error);
    wrong = canvas_open(c, "noise", n.w.headless, n.w.width, n.w.height, 1280.0f, 720.0f);
    int code = 0;
    if (!wrong && n.w.headless) code = render_headless(&n, c);
    if (!wrong && !n.w.headless) run_window(&n, c);
    window_close(&n.w);
    if (job_ends(&n.opener, 1)) device_close(&n.opening); // it could not be stopped
    device_close(&n.devices);
    free_pictures(&n);
    if (wrong) fail(3, "%s", wrong);
    return n.w.failed ? 1 : code;
}
