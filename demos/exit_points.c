// exit_points.c - light leaves an object at one point, the entry of a camera path: which exits do
// the techniques find, how much does each count, and what does resampling make of them? In a
// window, or as a PNG. See --help. SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "exit_points"
#include "common/tracer.h"
#include "common/window.h"

#define POINTS      500        // shown in each pane
#define LOOKUPS     25000      // behind each histogram
#define TRUTH       20000      // calls of tracer_area_points() behind the true curve
#define BINS        32         // of a histogram
#define PROBES      10         // shown on demand
#define PASSES      16         // rays through each pixel of the object
#define RAYS        70000      // pixels of the object in a window at most; more are interpolated
#define STEP        1.2599210f // of the dmfp: three make a factor of two
#define FRAME       0.016      // seconds
#define BUSY        0.010      // of them for lookups, or as long as drawing takes
#define SLICE       0.002      // of lookups without a look at the events
#define TURN        12.0f      // degrees a second
#define VIEW_CENTRE 0.95f      // height that the camera turns about
#define MARGIN      52.0f      // of the sheet, at the left
#define HISTOGRAM   120.0f     // its height
#define FOOTER      96.0f      // below the histograms

static const char usage[] =
    "usage: exit_points [options]\n"
    "Light leaves an object at one point. Shows where probes of each technique look for the places "
    "at which\n"
    "it went in (the exits of the camera path), coloured by how much each counts, and what "
    "resampling picks.\n"
    "\n" WINDOW_HELP_SCENE "  --dmfp-scale X     multiplies the scene's mean free paths (2)\n"
    "  --techniques LIST  of disk,tangents,sphere,chord, mixed and resampled; default: the "
    "library's mix\n"
    "  --turn DEGREES     where the camera stands to begin with (-24)\n"
    "  --still            do not turn the object\n"
    "  --probes           show the probes of a few candidates\n" WINDOW_HELP_FILES;

enum { DISK, SPHERE, CHORD, MIX, PICKED, PANES };

// What the pictures need to know of each scene: what to call its object, where its own camera looks
// at the object's most telling part, roughly, and how large the object is shown.
static const struct {
    const char *object;
    float x, y, zoom;
} subject[SCENES] = {[SCENES_SPHERE] = {"sphere", 0.5f, 0.45f, 19.0f},
                     [SCENES_SLAB] = {"pane", 0.55f, 0.45f, 20.0f},
                     [SCENES_CORNER] = {"corner", 0.5f, 0.56f, 20.5f},
                     [SCENES_NEEDLES] = {"needle", 0.5f, 0.5f, 19.0f},
                     [SCENES_BEAR] = {"bear", 0.57f, 0.53f, 15.2f},
                     [SCENES_RABBIT] = {"rabbit", 0.57f, 0.53f, 15.2f}};

#define PANE 0x1b2029ffu
#define EDGE 0x39424fffu
#define BAR  0x6f86a6ffu

typedef struct point {
    sss_vec3 position;
    float weight;
} point;

// One technique: the points it found, and the sums over many more of them.
typedef struct pane {
    sss_plan plan;
    uint32_t lookups, misses; // done so far, and without a point
    int count;                // of points below
    point shown[POINTS];
    double histogram[BINS], points, sum, squares; // of what all lookups found; of a lookup's weight
} pane;

typedef struct exit_points {
    window w;
    int probes, paused;
    unsigned techniques;
    float dmfp, turn, tilt, zoom, distance;
    scene s;
    sss_vec3 entry, normal;
    float reach; // of the histograms
    pane pane[PANES];
    tracer_random truth_random;
    uint32_t truths;
    double truth[BINS], truth_sum;
    float *rays; // brightness and coverage of the object's pixels, summed over passes
    unsigned char *rgb;
    int passes, ray_width, ray_height;
    GLuint texture;
    int turning, moving; // by the mouse: the view, the entry
    float mouse_x, mouse_y;
} exit_points;

// ---- Lookups

// The mean of the channels' unit profiles: what resampling aims at.
static float target(const sss_medium *m, float r) {
    float sum = 0.0f;
    for (int c = 0; c < 3; c++) sum += sss_profile(m, c, r) / sss_within(m, c, 1e30f);
    return sum * (1.0f / 3.0f);
}

static float distance_to(sss_vec3 a, sss_vec3 b) {
    sss_vec3 d = scene_sub(a, b);
    return scene_sqrt(scene_dot(d, d));
}

static void add_point(exit_points *e, pane *p, sss_vec3 position, float weight) {
    int bin = (int)(distance_to(position, e->entry) / e->reach * BINS);
    if (bin < BINS) p->histogram[bin] += 1.0;
    p->points += 1.0;
    if (p->count == POINTS) return;
    p->shown[p->count].position = position;
    p->shown[p->count++].weight = weight;
}

// A hit's weight: the profile over the density that finds it.
static float weigh(const exit_points *e, const sss_resampler *r, sss_vec3 position,
                   sss_vec3 normal) {
    return target(&e->s.medium, distance_to(position, e->entry)) /
           sss_intensity(r, position, normal);
}

// Traces a probe for the library. With `p` each hit is a point, and the sum of their weights is
// returned.
static float trace(exit_points *e, pane *p, sss_resampler *r, const sss_probe *probe) {
    scene_hits hits;
    float sum = 0.0f;
    scene_segment_hits(&e->s, probe->origin, probe->direction, probe->length, &hits);
    for (int i = 0; i < hits.count; i++) {
        sss_vec3 at = scene_along(probe->origin, probe->direction, hits.hit[i].t);
        sss_vec3 normal = scene_normal(&e->s.shape[hits.hit[i].shape], at);
        sss_add_hit(r, at, normal, 1.0f);
        if (!p) continue;
        float weight = weigh(e, r, at, normal);
        add_point(e, p, at, weight);
        sum += weight;
    }
    return sum;
}

static void begin(const exit_points *e, int which, sss_resampler *r, uint32_t lookup) {
    uint32_t key = sss_hash(e->w.seed, (uint32_t)which);
    sss_begin(r, &e->s.medium, &e->pane[which].plan, e->entry, e->normal, sss_hash(key, lookup));
}

// The candidates of one probe, or the exit that resampling picks from several.
static void look_up(exit_points *e, int which) {
    pane *p = &e->pane[which];
    sss_resampler r;
    sss_probe probe;
    sss_exit exit;
    float weight = 0.0f;
    begin(e, which, &r, p->lookups++);
    while (sss_next_probe(&r, &probe)) weight += trace(e, which == PICKED ? NULL : p, &r, &probe);
    if (which == PICKED && sss_finish(&r, &exit)) {
        for (int c = 0; c < 3; c++)
            weight += exit.weight[c] / sss_within(&e->s.medium, c, 1e30f) * (1.0f / 3.0f);
        add_point(e, p, exit.position, weight);
    }
    if (!(weight > 0.0f)) p->misses++;
    p->sum += (double)weight;
    p->squares += (double)weight * (double)weight;
}

// The surface integral of the target over the object, by distance: area points, without the
// library's sampling.
static void add_truth(exit_points *e) {
    tracer_points points;
    tracer_area_points(&e->s, e->entry, &e->truth_random, &points);
    for (int i = 0; i < points.count; i++) {
        const float weight[3] = {points.point[i].weight.x, points.point[i].weight.y,
                                 points.point[i].weight.z};
        int bin = (int)(distance_to(points.point[i].position, e->entry) / e->reach * BINS);
        for (int c = 0; c < 3; c++) {
            double share = (double)(weight[c] / sss_within(&e->s.medium, c, 1e30f));
            if (bin < BINS) e->truth[bin] += share;
            e->truth_sum += share;
        }
    }
    e->truths++;
}

// Works until it is done, or until `deadline`. Returns whether there is more to do.
static int work(exit_points *e, double deadline) {
    int left = 1;
    while (left && now() < deadline) {
        left = 0;
        for (int i = 0; i < PANES; i++) {
            if (e->pane[i].lookups < LOOKUPS) look_up(e, i), left = 1;
        }
        if (e->truths < TRUTH) add_truth(e), left = 1;
    }
    return left;
}

static void restart(exit_points *e) {
    static const unsigned technique[PANES] = {SSS_DISK, SSS_SPHERE, SSS_CHORD, 0, 0};
    float within = 0.0f;
    memset(e->pane, 0, sizeof e->pane);
    memset(e->truth, 0, sizeof e->truth);
    e->truth_sum = 0.0;
    e->truths = 0;
    e->truth_random = tracer_random_begin(e->w.seed, 0x74727574u, 0);
    for (int i = 0; i < PANES; i++) {
        sss_plan *plan = &e->pane[i].plan;
        plan->techniques = i < MIX ? technique[i] : e->techniques;
        plan->candidates = i == PICKED ? e->w.candidates : 1;
        plan->independent = i != PICKED;
    }
    for (e->reach = 0.01f; within < 0.96f && e->reach < 100.0f; e->reach *= 1.05f) {
        within = 0.0f;
        for (int c = 0; c < 3; c++) {
            within += sss_within(&e->s.medium, c, e->reach) / sss_within(&e->s.medium, c, 1e30f) *
                      (1.0f / 3.0f);
        }
    }
}

// ---- The camera and the object

static void aim(exit_points *e) {
    sss_vec3 centre = scene_vec(0.0f, VIEW_CENTRE, 0.0f), arm = scene_vec(0.0f, 0.0f, e->distance);
    arm = scenes_turn(scenes_turn(arm, -e->tilt, 0), e->turn, 1);
    scenes_camera(&e->s, scene_add(centre, arm), centre, e->zoom);
    e->passes = 0;
}

// The square of a picture that the camera fills with the scene, whatever the picture's shape.
static float fit(float width, float height) { return scene_min(width, 0.75f * height); }

// The hit of the camera's ray through a point of a pane's picture.
static scene_hit see(const exit_points *e, float width, float height, float x, float y,
                     sss_vec3 *direction) {
    float side = 1.0f / fit(width, height);
    sss_vec3 d = scene_along(e->s.forward, e->s.right, (2.0f * x - width) * side);
    *direction = scene_normalize(scene_along(d, e->s.up, (height - 2.0f * y) * side));
    return scene_nearest(&e->s, e->s.eye, *direction, SCENE_NOTHING);
}

// Where in a box the camera sees a point; returns whether the object hides it.
static int project(const exit_points *e, box b, sss_vec3 position, float *x, float *y) {
    sss_vec3 d = scene_sub(position, e->s.eye);
    float depth = scene_dot(d, e->s.forward), side = fit(b.width, b.height),
          length = scene_sqrt(scene_dot(d, d));
    float inverse = side / (depth * scene_dot(e->s.right, e->s.right));
    *x = b.x + 0.5f * (b.width + scene_dot(d, e->s.right) * inverse);
    *y = b.y + 0.5f * (b.height - scene_dot(d, e->s.up) * inverse);
    return scene_nearest(&e->s, e->s.eye, scene_scale(d, 1.0f / length), SCENE_NOTHING).t <
           length - 2e-3f;
}

static void find_entry(exit_points *e) {
    float x = subject[e->w.scene].x;
    float y = subject[e->w.scene].y;
    sss_vec3 direction;
    for (float shift = 0.0f; shift < 0.3f;
         shift += 0.01f) { // needles: to the side until one is met
        scene_hit hit = see(e, 1.0f, 1.0f, x + shift, y, &direction);
        if (hit.shape < 0) continue;
        e->entry = scene_along(e->s.eye, direction, hit.t);
        e->normal = scene_normal(&e->s.shape[hit.shape], e->entry);
        return;
    }
}

static void open_scene(exit_points *e) {
    load_scene(&e->s, e->w.scene, window_profile[e->w.profile], e->dmfp);
    sss_vec3 arm = scene_sub(e->s.eye, scene_vec(0.0f, VIEW_CENTRE, 0.0f));
    e->distance = scene_sqrt(scene_dot(arm, arm));
    find_entry(e);
    e->tilt = 14.0f;
    e->zoom = subject[e->w.scene].zoom;
    aim(e);
    restart(e);
}

// One more ray through each pixel of the object's picture; after PASSES of them its edges are
// smooth.
static void cast(exit_points *e, float pane_width, float pane_height, float unit) {
    float width = pane_width * unit, height = pane_height * unit, detail = 1.0f;
    while (!e->w.headless && width * height / (detail * detail) > RAYS) detail += 0.25f;
    int w = (int)(width / detail), h = (int)(height / detail);
    if (w < 1 || h < 1) return;
    if (w != e->ray_width || h != e->ray_height) {
        e->ray_width = w, e->ray_height = h, e->passes = 0;
        e->rays = (float *)realloc(e->rays, (size_t)w * (size_t)h * 2 * sizeof *e->rays);
        e->rgb = (unsigned char *)realloc(e->rgb, image_count(w, h));
        if (!e->rays || !e->rgb) fail(1, "out of memory");
    }
    if (e->passes == PASSES) return;
    float dx = tracer_unit(sss_hash(1u, (uint32_t)e->passes)),
          dy = tracer_unit(sss_hash(2u, (uint32_t)e->passes));
    sss_vec3 light =
        scene_normalize(scene_sub(scene_along(e->s.up, e->s.forward, -0.25f), e->s.right));
#pragma omp parallel for schedule(dynamic, 8)
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            sss_vec3 direction;
            scene_hit hit = see(e, (float)w, (float)h, (float)x + dx, (float)y + dy, &direction);
            float *sum = e->rays + 2 * (y * w + x), shade = 0.0f;
            if (hit.shape >= 0) {
                sss_vec3 n =
                    scene_normal(&e->s.shape[hit.shape], scene_along(e->s.eye, direction, hit.t));
                float lit = 0.5f + 0.5f * scene_dot(n, light), facing = -scene_dot(n, direction);
                shade = (0.06f + 0.24f * lit * lit) * (0.45f + 0.55f * facing);
            }
            sum[0] = shade + (e->passes > 0 ? sum[0] : 0.0f);
            sum[1] = (hit.shape >= 0 ? 1.0f : 0.0f) + (e->passes > 0 ? sum[1] : 0.0f);
        }
    }
    e->passes++;
}

static void upload(exit_points *e, canvas *c) {
    static const float tint[3] = {0.94f, 0.97f, 1.0f};
    if (e->passes == 0) return; // an iconified window has no pixels
    for (int i = 0; i < e->ray_width * e->ray_height; i++) {
        const float *sum = e->rays + 2 * i;
        float shade = 255.0f * sqrtf(sum[0] / (sum[1] > 0.0f ? sum[1] : 1.0f)),
              covered = sum[1] / (float)e->passes;
        for (int k = 0; k < 3; k++) {
            float behind = (float)(PANE >> (24 - 8 * k) & 255u);
            e->rgb[3 * i + k] = (unsigned char)(behind + (tint[k] * shade - behind) * covered);
        }
    }
    canvas_upload(c, &e->texture, e->ray_width, e->ray_height, 3, e->rgb, 0);
}

// ---- Drawing

// Where a pane's picture is; the last stands apart.
static box pane_box(const canvas *c, int which) {
    const float gap = 12.0f, apart = 24.0f;
    box b;
    b.width = (c->width - MARGIN - 18.0f - (PANES - 1) * gap - apart) / PANES;
    b.x = MARGIN + (float)which * (b.width + gap) + (which == PICKED ? apart : 0.0f);
    b.y = 146.0f;
    b.height = c->height - b.y - 56.0f - HISTOGRAM - FOOTER;
    return b;
}

static void draw_arrow(canvas *c, float x0, float y0, float x1, float y1, unsigned colour) {
    float dx = x1 - x0, dy = y1 - y0, length = sqrtf(dx * dx + dy * dy);
    if (length < 6.0f) return; // it points at the eye
    dx *= 8.0f / length;
    dy *= 8.0f / length;
    canvas_line(c, x0, y0, x1, y1, 2.4f, colour);
    canvas_line(c, x1, y1, x1 - dx + 0.7f * dy, y1 - dy - 0.7f * dx, 2.4f, colour);
    canvas_line(c, x1, y1, x1 - dx - 0.7f * dy, y1 - dy + 0.7f * dx, 2.4f, colour);
}

// From a quarter of the mean to four times it.
static unsigned weight_colour(double relative) {
    return canvas_scale(0.5f + 0.25f * (float)log2(relative + 1e-9));
}

static double mean_weight(const pane *p) { return p->points > 0.0 ? p->sum / p->points : 1.0; }

// First what the object hides, faded, then the rest.
static void draw_points(const exit_points *e, canvas *c, const pane *p, box b) {
    double mean = mean_weight(p);
    float x[POINTS], y[POINTS];
    unsigned colour[POINTS];
    int count = 0;
    for (int i = 0; i < p->count; i++) {
        int hidden = project(e, b, p->shown[i].position, &x[count], &y[count]);
        colour[count] = weight_colour((double)p->shown[i].weight / mean);
        if (hidden) canvas_point(c, x[count], y[count], 2.0f, (colour[count] & ~255u) | 70u);
        else count++;
    }
    for (int i = 0; i < count; i++) canvas_spot(c, x[i], y[i], 3.4f, colour[i]);
}

static void draw_ring(canvas *c, float x, float y, float radius, float wide, unsigned colour) {
    for (int i = 0; i < 24; i++) {
        float a = (float)i * (SCENE_PI / 12.0f), n = (float)(i + 1) * (SCENE_PI / 12.0f);
        canvas_line(c, x + radius * cosf(a), y + radius * sinf(a), x + radius * cosf(n),
                    y + radius * sinf(n), wide, colour);
    }
}

// The part of a probe that is before the camera.
static void draw_probe(const exit_points *e, canvas *c, box b, const sss_probe *probe) {
    const float nearest = 1.0f;
    float depth = scene_dot(scene_sub(probe->origin, e->s.eye), e->s.forward);
    float slope = scene_dot(probe->direction, e->s.forward), from = 0.0f, to = probe->length, x0,
          y0, x1, y1;
    if (slope > 0.0f) from = scene_max(from, (nearest - depth) / slope);
    if (slope < 0.0f) to = scene_min(to, (nearest - depth) / slope);
    if (!(from < to)) return;
    project(e, b, scene_along(probe->origin, probe->direction, from), &x0, &y0);
    project(e, b, scene_along(probe->origin, probe->direction, to), &x1, &y1);
    canvas_line(c, x0, y0, x1, y1, 1.5f, 0xffffffa0u);
}

// The probes of a few lookups, or those of one that is resampled, with their hits and the one that
// is picked.
static void draw_probes(exit_points *e, canvas *c, int which, box b) {
    double mean = mean_weight(&e->pane[which == PICKED ? MIX : which]);
    for (uint32_t k = 0; k < (which == PICKED ? 1u : PROBES); k++) {
        sss_resampler r;
        sss_probe probe;
        sss_exit exit;
        float x, y;
        begin(e, which, &r, k);
        while (sss_next_probe(&r, &probe)) {
            scene_hits hits;
            trace(e, NULL, &r, &probe);
            draw_probe(e, c, b, &probe);
            scene_segment_hits(&e->s, probe.origin, probe.direction, probe.length, &hits);
            for (int i = 0; i < hits.count; i++) {
                sss_vec3 at = scene_along(probe.origin, probe.direction, hits.hit[i].t);
                float weight = weigh(e, &r, at, scene_normal(&e->s.shape[hits.hit[i].shape], at));
                project(e, b, at, &x, &y);
                canvas_point(c, x, y, 5.2f, 0xffffffffu);
                canvas_point(c, x, y, 4.2f, weight_colour((double)weight / mean));
            }
        }
        if (which != PICKED || !sss_finish(&r, &exit)) continue;
        project(e, b, exit.position, &x, &y);
        draw_ring(c, x, y, 10.0f, 3.0f, CHOSEN);
    }
}

// An arrow along the normal into a ring.
static void draw_entry(const exit_points *e, canvas *c, box b) {
    float x, y, from_x, from_y, to_x, to_y;
    unsigned colour = project(e, b, e->entry, &x, &y) ? 0xffffff50u : 0xffffffffu;
    project(e, b, scene_along(e->entry, e->normal, 0.45f), &from_x, &from_y);
    project(e, b, scene_along(e->entry, e->normal, 0.08f), &to_x, &to_y);
    draw_ring(c, x, y, 7.0f, 2.2f, colour);
    draw_arrow(c, to_x, to_y, from_x, from_y, colour);
}

// A step for an axis of this length: 1, 2 or 5 times a power of ten, some four to the axis.
static double tick_step(double length) {
    double power = pow(10.0, floor(log10(length / 3.0))), rest = length / 3.0 / power;
    return power * (rest >= 5.0 ? 5.0 : rest >= 2.0 ? 2.0 : 1.0);
}

// Through the middles of the bins, as one band: lines of their own would show where they overlap.
static void draw_curve(canvas *c, float left, float top, float step, const float *y) {
    float x[BINS], half[BINS];
    for (int i = 0; i < BINS; i++) {
        float slope = (y[i < BINS - 1 ? i + 1 : i] - y[i > 0 ? i - 1 : i]) /
                      (i % (BINS - 1) ? 2.0f * step : step);
        half[i] = 1.7f * sqrtf(1.0f + slope * slope);
        x[i] = left + step * (float)i;
    }
    canvas_use(c, c->disc);
    canvas_colour(c, CHOSEN);
    for (int i = 0; i + 1 < BINS; i++) {
        canvas_corner(c, x[i], top + y[i] - half[i], 0.5f, 0.0f);
        canvas_corner(c, x[i], top + y[i] + half[i], 0.5f, 1.0f);
        canvas_corner(c, x[i + 1], top + y[i + 1] + half[i + 1], 0.5f, 1.0f);
        canvas_corner(c, x[i + 1], top + y[i + 1] - half[i + 1], 0.5f, 0.0f);
    }
}

static void draw_histogram(const exit_points *e, canvas *c, int which, box b, double top) {
    const pane *p = &e->pane[which];
    char text[32];
    double step = tick_step(100.0 * top);
    for (double tick = 0.0; tick <= 100.0 * top; tick += step) {
        float level = b.y + b.height * (1.0f - (float)(tick / 100.0 / top));
        canvas_rectangle(c, b.x, level, b.width, 1.0f, EDGE);
        snprintf(text, sizeof text, "%g %%", tick);
        if (which == 0) canvas_text(c, b.x - 5.0f, level + 4.0f, 12.5f, CANVAS_RIGHT, QUIET, text);
    }
    step = tick_step((double)e->reach);
    for (double tick = 0.0; tick < (double)e->reach * 0.97; tick += step) {
        float x = b.x + b.width * (float)(tick / (double)e->reach);
        snprintf(text, sizeof text, "%g", tick);
        canvas_text(c, x, b.y + b.height + 14.0f, 12.5f, tick > 0.0 ? CANVAS_CENTRE : CANVAS_LEFT,
                    QUIET, text);
    }
    canvas_clip(c, b.x, b.y, b.width, b.height + 1.0f);
    float wide = b.width / BINS, y[BINS];
    for (int i = 0; i < BINS; i++) {
        float high = (float)(p->histogram[i] / (p->points + 1e-9) / top) * b.height;
        canvas_rectangle(c, b.x + wide * (float)i + 0.5f, b.y + b.height - high, wide - 1.0f, high,
                         BAR);
    }
    for (int i = 0; i < BINS; i++)
        y[i] = b.height * (1.0f - (float)(e->truth[i] / (e->truth_sum + 1e-9) / top));
    draw_curve(c, b.x + 0.5f * wide, b.y, wide, y);
    canvas_unclip(c);
}

// How many of 100 lookups would do if all weighed the same: (sum w)^2 / sum w^2.
static double worth(const pane *p) {
    return p->squares > 0.0 ? 100.0 * p->sum * p->sum / (p->squares * p->lookups) : 0.0;
}

static const char *technique_names(const exit_points *e, char *text) {
    static const char *const name[4] = {"disk", "tangents", "sphere", "chord"};
    if (!e->techniques) return strcpy(text, "disk, sphere and chord, 3 : 3 : 2");
    *text = '\0';
    for (int i = 0; i < 4; i++) {
        if (!(e->techniques >> i & 1)) continue;
        if (*text) strcat(text, ", ");
        strcat(text, name[i]);
    }
    return text;
}

static void draw_pane(exit_points *e, canvas *c, int which, double top) {
    static const char *const title[PANES] = {"disk probes", "sphere probes", "chord probes",
                                             "mixed probes", ""};
    static const char *const how[PANES] = {"lines along the normal", "lines through a point below",
                                           "segments across a ball", "", "the exits to be shaded"};
    const box b = pane_box(c, which);
    const float uv[4] = {0.0f, 0.0f, 1.0f, 1.0f}, at[4] = {b.x, b.y, b.width, b.height};
    const pane *p = &e->pane[which];
    char text[96];
    int chosen = which == PICKED;
    snprintf(text, sizeof text, "resampled: 1 of %d", e->w.candidates);
    canvas_text(c, b.x, b.y - 27.0f, 21.0f, CANVAS_LEFT, chosen ? CHOSEN : TEXT,
                chosen ? text : title[which]);
    canvas_text(c, b.x, b.y - 8.0f, 14.5f, CANVAS_LEFT, QUIET,
                which == MIX ? technique_names(e, text) : how[which]);
    canvas_frame(c, b.x, b.y, b.width, b.height, chosen ? 2.0f : 1.0f, chosen ? CHOSEN : EDGE);
    canvas_clip(c, b.x, b.y, b.width, b.height);
    canvas_image(c, e->texture, at, uv, 0xffffffff);
    if (e->probes) draw_probes(e, c, which, b);
    else draw_points(e, c, p, b);
    draw_entry(e, c, b);
    canvas_unclip(c);
    snprintf(text, sizeof text,
             chosen ? "%d points, %.0f %% of lookups miss" : "%d points, %.0f %% of probes miss",
             p->count, 100.0 * p->misses / (p->lookups + 1e-9));
    canvas_text(c, b.x, b.y + b.height + 20.0f, 14.5f, CANVAS_LEFT, QUIET, text);
    snprintf(text, sizeof text, "100 %s worth %.0f ideal ones", chosen ? "exits" : "probes",
             worth(p));
    canvas_text(c, b.x, b.y + b.height + 41.0f, 15.5f, CANVAS_LEFT, chosen ? CHOSEN : TEXT, text);
    const box h = {b.x, b.y + b.height + 54.0f, b.width, HISTOGRAM};
    draw_histogram(e, c, which, h, top);
}

static void draw_colours(canvas *c, float x, float y) {
    static const char *const label[5] = {"1/4", "1/2", "1", "2", "4"};
    canvas_text(c, x, y - 8.0f, 15.0f, CANVAS_LEFT, TEXT, "how much a point counts");
    window_colour_bar(c, x, y, 240.0f, 14.0f);
    for (int i = 0; i < 5; i++) {
        canvas_text(c, x + 60.0f * (float)i, y + 29.0f, 13.5f, CANVAS_CENTRE, QUIET, label[i]);
    }
    canvas_text(c, x, y + 48.0f, 13.5f, CANVAS_LEFT, QUIET,
                "1: the mean. Faded: behind the object.");
}

static void draw_keys(exit_points *e, canvas *c, float y) {
    char text[64], names[64];
    float x = window_first_keys(&e->w, MARGIN, y);
    x = canvas_key(c, x, y, '[', "");
    snprintf(text, sizeof text, "dmfp \xc3\x97%.3g", (double)e->dmfp);
    x = canvas_key(c, x, y, ']', text);
    for (int i = 0; i < 3; i++) x = canvas_key(c, x, y, '1' + i, "");
    x = canvas_key(c, x, y, '4',
                   e->techniques ? technique_names(e, names) : "disk tangents sphere chord");
    x = canvas_key(c, x, y, 'P', e->probes ? "points" : "probes");
    x = canvas_key(c, x, y, ' ', e->paused ? "turn" : "pause");
    window_last_keys(&e->w, x, y);
    canvas_text(c, MARGIN, y - 24.0f, 13.0f, CANVAS_LEFT, e->w.note[0] ? TEXT : QUIET,
                e->w.note[0] ? e->w.note
                             : "Press on the object to move the entry; drag beside it or with the "
                               "right button to turn; "
                               "wheel to zoom. Press a key, or click on it here:");
}

// What the numbers are, where there is no window and so no keys.
static void draw_small_print(const exit_points *e, canvas *c, float y) {
    char text[256];
    snprintf(text, sizeof text,
             "%d lookups behind each histogram, points counted without their weight. The curve: "
             "brute force over the "
             "surface, mean of the three colours.",
             LOOKUPS);
    canvas_text(c, MARGIN, y, 13.0f, CANVAS_LEFT, QUIET, text);
    snprintf(text, sizeof text,
             "Worth: 100 (sum w)\xc2\xb2 / (n sum w\xc2\xb2), w the weight that one of n lookups "
             "finds. Profile %s, "
             "the scene's "
             "mean free paths \xc3\x97%.3g, seed %u.",
             window_profile[e->w.profile], (double)e->dmfp, e->w.seed);
    canvas_text(c, MARGIN, y + 18.0f, 13.0f, CANVAS_LEFT, QUIET, text);
}

static void draw_text(exit_points *e, canvas *c) {
    char text[256];
    float low = c->height - FOOTER + 32.0f;
    snprintf(text, sizeof text, "Light leaves the %s at the ring. Where did it go in?",
             subject[e->w.scene].object);
    canvas_text(c, MARGIN, 37.0f, 28.0f, CANVAS_LEFT, TEXT, text);
    canvas_text(c, MARGIN, 62.0f, 16.0f, CANVAS_LEFT, QUIET,
                "Probe rays find candidates: too many in some places, too few in others. The "
                "colour is how much each "
                "must count to make up for it.");
    snprintf(text, sizeof text,
             "Resampling picks 1 of %d candidates by this weight: what it picks lies where the "
             "light went in, "
             "and counts nearly alike.",
             e->w.candidates);
    canvas_text(c, MARGIN, 83.0f, 16.0f, CANVAS_LEFT, QUIET, text);
    draw_colours(c, c->width - 258.0f, 40.0f);
    canvas_text(c, MARGIN, low, 14.0f, CANVAS_LEFT, QUIET,
                "distance from the entry (the object is about 2 high)");
    canvas_rectangle(c, 560.0f, low - 11.0f, 14.0f, 11.0f, BAR);
    canvas_text(c, 581.0f, low, 14.0f, CANVAS_LEFT, QUIET, "share of the points");
    canvas_rectangle(c, 760.0f, low - 6.0f, 22.0f, 2.5f, CHOSEN);
    canvas_text(c, 790.0f, low, 14.0f, CANVAS_LEFT, QUIET,
                "share of the light: 2\xcf\x80r Rd(r), integrated over this object");
    if (e->w.headless) draw_small_print(e, c, low + 26.0f);
    else draw_keys(e, c, c->height - 14.0f);
}

static void draw(exit_points *e, canvas *c) {
    double top = 0.0;
    canvas_begin(c, PAGE);
    const box b = pane_box(c, 0);
    for (int k = 0; k < (e->w.headless ? PASSES : 1); k++) cast(e, b.width, b.height, c->unit);
    canvas_look(c);
    upload(e, c);
    for (int i = 0; i < BINS; i++) top = e->truth[i] > top ? e->truth[i] : top;
    top = 1.5 * top / (e->truth_sum + 1e-9) + 1e-6;
    for (int i = 0; i < PANES; i++) draw_pane(e, c, i, top), canvas_look(c);
    const box from = pane_box(c, MIX), to = pane_box(c, PICKED);
    float y = from.y + 0.5f * from.height;
    draw_arrow(c, from.x + from.width + 6.0f, y, to.x - 9.0f, y, CHOSEN);
    draw_text(e, c);
}

// ---- The window

// Moves the entry to where the mouse is; 0 when that is beside the object.
static int move_entry(exit_points *e, const canvas *c, float x, float y) {
    for (int i = 0; i < PANES; i++) {
        const box b = pane_box(c, i);
        sss_vec3 direction;
        if (x < b.x || x > b.x + b.width || y < b.y || y > b.y + b.height) continue;
        scene_hit hit = see(e, b.width, b.height, x - b.x, y - b.y, &direction);
        if (hit.shape < 0) continue;
        e->entry = scene_along(e->s.eye, direction, hit.t);
        e->normal = scene_normal(&e->s.shape[hit.shape], e->entry);
        restart(e);
        return 1;
    }
    return 0;
}

static void toggle(exit_points *e, unsigned technique) {
    unsigned before = e->techniques ? e->techniques : SSS_DISK | SSS_SPHERE | SSS_CHORD;
    e->techniques = before ^ technique;
    if (e->techniques == (SSS_DISK | SSS_SPHERE | SSS_CHORD)) e->techniques = 0;
    restart(e);
}

static void set_medium(exit_points *e) {
    load_scene(&e->s, e->w.scene, window_profile[e->w.profile], e->dmfp);
    aim(e);
    restart(e);
}

// Returns 0 for the key that ends the program.
static int press_key(exit_points *e, int code) {
    window_change change = window_key(&e->w, code);
    if (change == WINDOW_SCENE) open_scene(e);
    if (change == WINDOW_PROFILE) set_medium(e);
    if (change == WINDOW_CANDIDATES) restart(e);
    if (code == '[' && e->dmfp > 0.05f) e->dmfp /= STEP, set_medium(e);
    if (code == ']' && e->dmfp < 20.0f) e->dmfp *= STEP, set_medium(e);
    if (code >= '1' && code <= '4') toggle(e, 1u << (code - '1'));
    if (code == 'P') e->probes = !e->probes;
    if (code == ' ') e->paused = !e->paused;
    return change != WINDOW_QUIT;
}

static int handle(exit_points *e, canvas *c) {
    canvas_event event;
    while (!e->w.save &&
           canvas_next_event(c, &event)) { // what follows W belongs into the next frame
        switch (event.kind) {
        case CANVAS_KEY:
            if (!press_key(e, event.code)) return 0;
            break;
        case CANVAS_PRESS:
            e->moving = event.code == 0 && move_entry(e, c, event.x, event.y);
            e->turning = !e->moving;
            break;
        case CANVAS_RELEASE: e->moving = e->turning = 0; break;
        case CANVAS_WHEEL:
            e->zoom = scene_max(1.0f, scene_min(60.0f, e->zoom * powf(0.9f, event.wheel)));
            aim(e);
            break;
        case CANVAS_MOVE:
            if (e->moving) move_entry(e, c, event.x, event.y);
            if (e->turning) {
                e->turn -= 0.4f * (event.x - e->mouse_x);
                e->tilt =
                    scene_max(-60.0f, scene_min(80.0f, e->tilt + 0.4f * (event.y - e->mouse_y)));
                aim(e);
            }
            e->mouse_x = event.x;
            e->mouse_y = event.y;
            break;
        }
    }
    return !canvas_closing(c);
}

static void run(exit_points *e, canvas *c) {
    double before = now(), drawing = 0.0;
    while (handle(e, c)) {
        double time = now(), end = time + fmax(BUSY, drawing);
        if (!e->paused && !e->turning && !e->moving)
            e->turn += TURN * (float)(time - before), aim(e);
        before = time;
        int left = 1, asked = 0;
        while (left && !asked && now() < end)
            left = work(e, now() + SLICE), asked = canvas_poll(c, 0.0);
        drawing = now();
        draw(e, c);
        window_show(&e->w);
        drawing = now() - drawing;
        int rests = !left && e->paused && e->passes == PASSES;
        canvas_poll(c, rests ? 0.5 : FRAME - (now() - time));
    }
}

// ---- Command line

// How many words the option takes.
static int parse_option(exit_points *e, const char *name, const char *value) {
    int taken = window_option(&e->w, usage, name, value);
    if (taken) return taken;
    if (strcmp(name, "--probes") == 0) return e->probes = 1;
    if (strcmp(name, "--still") == 0) return e->paused = 1;
    if (is_option("--dmfp-scale", name, value)) {
        e->dmfp = (float)parse_real(name, value, 0.01, 100.0);
    } else if (is_option("--techniques", name, value)) {
        e->techniques = parse_techniques(value);
    } else if (is_option("--turn", name, value)) {
        e->turn = (float)parse_real(name, value, -360.0, 360.0);
    } else {
        fail(2, "unknown option '%s'; --help lists what there is", name);
    }
    return 2;
}

int main(int count, char **words) {
    static exit_points e;
    canvas *c = &e.w.c;
    window_defaults(&e.w);
    e.dmfp = 2.0f;
    e.turn = -24.0f;
    for (int i = 1; i < count;)
        i += parse_option(&e, words[i], i + 1 < count ? words[i + 1] : NULL);
    const char *wrong = output_try(e.w.png);
    if (wrong) fail(2, "cannot write %s: %s", e.w.png, wrong);
    open_scene(&e);
    wrong = canvas_open(c, "exit points", e.w.headless, e.w.width, e.w.height, 1280.0f, 720.0f);
    if (!wrong && e.w.headless) {
        work(&e, 1e30);
        draw(&e, c);
        window_save(&e.w);
    } else if (!wrong) {
        run(&e, c);
    }
    window_close(&e.w);
    free(e.rays);
    free(e.rgb);
    if (wrong) fail(3, "%s", wrong);
    return e.w.failed;
}
