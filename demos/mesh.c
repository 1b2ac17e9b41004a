// mesh.c - any mesh made translucent: read by assimp, traced by Embree, shaded with
// sss_resample.h; plain on the left and resampled on the right, with the noise of both. In a
// window, or as a PNG. See --help.
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#include <sys/resource.h>
#include <unistd.h>

#define COMMAND "mesh"
#include "common/mesh_file.h"
#include "common/mesh_tracer.h"
#include "common/pair.h"
#include "common/progress.h"

#define SLICE      0.012  // seconds that one step of rendering takes
#define REFRESH    0.080  // between two frames, unless there is an event
#define COARSE     4      // how many pixels the preview's are wide
#define PATIENT    0.3    // seconds until a preview that takes longer is shown in part, or given up
#define QUICK      8      // candidates of a preview at most
#define BATCH      8      // pixels
#define ROWS       16     // of the mask in one step
#define FIELD      22.0f  // angle of the view in degrees
#define FILLED     0.86f  // share of the view that the object fills
#define LAMP       128.0f // degrees from the eye, about the object
#define LEAST_SIZE 1e-3   // of --scale
#define MOST_SIZE  1e5
#define LEAST_DMFP 1e-12 // of --dmfp, beside 0
#define MOST_DMFP  1e12
#define PRESETS    "apple chicken cream jade ketchup marble milk potato skimmilk skin skin2 wax"

static const char usage[] =
    "usage: mesh FILE [options]\n"
    "Makes a mesh (OBJ, PLY, STL, glTF and what else assimp reads) translucent, and renders it "
    "twice at the same price:\n"
    "plain on the left, resampled on the right, and the noise of both.\n"
    "\n"
    "  --preset NAME      a medium measured by Jensen et al. 2001: apple, chicken, cream, ketchup, "
    "marble, milk,\n"
    "                     potato, skimmilk, skin, skin2; and by eye, not measured: jade, wax\n"
    "  --scale MM         with --preset: the object's largest dimension in millimetres (50)\n"
    "  --dmfp R,G,B       without --preset: diffuse mean free paths in the file's units (relative "
    "to the object's size)\n"
    "  --albedo R,G,B     without --preset: diffuse albedos (0.93,0.42,0.14)\n"
    "  --up AXIS          the file's axis that points up: y, or z (default of STL files)\n"
    "  --turn DEGREES     see the object from this much further to the right (0)\n"
    "  --light-aware      give the library a light hint at each candidate\n"
    "  --share            the resampled picture shares its exits over tiles of pixels\n"
    "  --tolerance E      choose the model of each resampled lookup: by volume, profile or "
    "Lambert,\n"
    "                     whichever is cheapest for this relative error\n"
    "  --models           with --tolerance: colour the object by the model chosen\n"
    "  --candidates M     probes of each resampled lookup (8)\n"
    "  --spp N            headless: samples a pixel of the resampled picture (32)\n"
    "  --seed S           0..4294967295 (1)\n" WINDOW_HELP_FILES WINDOW_HELP_INTERRUPT;

// Reduced scattering and absorption, 1/mm, and index of refraction: Jensen, Marschner, Levoy and
// Hanrahan 2001, "A practical model for subsurface light transport", the table of measured
// parameters. skin and milk are its skin1 and whole milk, chicken its chicken1. No published
// measurement of jade and wax was found: these two were chosen by eye.
static const struct {
    const char *name;
    float sigma_s[3], sigma_a[3], eta;
    int by_eye;
} preset[] = {{"apple", {2.29f, 2.39f, 1.97f}, {0.0030f, 0.0034f, 0.046f}, 1.3f, 0},
              {"chicken", {0.15f, 0.21f, 0.38f}, {0.015f, 0.077f, 0.19f}, 1.3f, 0},
              {"cream", {7.38f, 5.47f, 3.15f}, {0.0002f, 0.0028f, 0.0163f}, 1.3f, 0},
              {"jade", {1.10f, 1.40f, 1.20f}, {0.045f, 0.008f, 0.025f}, 1.6f, 1},
              {"ketchup", {0.18f, 0.07f, 0.03f}, {0.061f, 0.97f, 1.45f}, 1.3f, 0},
              {"marble", {2.19f, 2.62f, 3.00f}, {0.0021f, 0.0041f, 0.0071f}, 1.5f, 0},
              {"milk", {2.55f, 3.21f, 3.77f}, {0.0011f, 0.0024f, 0.014f}, 1.3f, 0},
              {"potato", {0.68f, 0.70f, 0.55f}, {0.0024f, 0.0090f, 0.12f}, 1.3f, 0},
              {"skimmilk", {0.70f, 1.22f, 1.90f}, {0.0014f, 0.0025f, 0.0142f}, 1.3f, 0},
              {"skin", {0.74f, 0.88f, 1.01f}, {0.032f, 0.17f, 0.48f}, 1.3f, 0},
              {"skin2", {1.09f, 1.59f, 1.79f}, {0.013f, 0.070f, 0.145f}, 1.3f, 0},
              {"wax", {1.50f, 1.40f, 1.10f}, {0.004f, 0.009f, 0.035f}, 1.4f, 1}};
#define PRESET_COUNT ((int)(sizeof preset / sizeof *preset))

enum { PLAIN, RESAMPLED, RUNS };

// What the user sees of a run, or will see next.
typedef struct card {
    image_bytes picture;           // has room for the full size, a preview takes less of it
    int fresh;                     // OpenGL does not have the picture yet
    double passes, seconds, noise; // noise below 0: not known yet
    unsigned long long probes, shaded;
} card;

// A picture that grows, pass by pass of one sample a pixel, in two halves with independent noise.
// The difference of the halves is what the noise is measured by.
typedef struct run {
    tracer_settings settings;
    image half[2], preview;
    int unit, previewed; // unit: how many of the pass or the preview under way are done
    uint32_t spp[2];     // complete passes of each half
    card card;
} run;

// What the user wants to see.
typedef struct view {
    float turn, tilt, zoom;
    int candidates, light_aware, shares, models;
    float tolerance; // 0: the profile everywhere
    sss_medium medium;
} view;

// The window never waits for a picture: it draws what there is, and a thread of its own renders,
// the painter. Between them are, under the lock, the view that is wanted and the cards shown.
typedef struct viewer {
    window w;
    const char *file, *up;
    int preset; // -1: by albedo and dmfp
    double millimetres;
    int has_dmfp, has_albedo, has_scale;
    float dmfp[3], albedo[3];
    uint32_t spp;
    view view;
    int dragging;
    float mouse_x, mouse_y;
    GLuint texture[RUNS];

    pthread_t painter;
    pthread_mutex_t lock;
    view wanted;
    int is_wanted, stops;
    card shown[RUNS];

    mesh_world world; // the painter's, with all below; the window reads world.m, which is constant
    run run[RUNS];
    unsigned char *mask; // which pixels' middles show the object, and by which of the models below
    int colours;         // the object is coloured by them
    int masked;          // rows of it that are done
    double begun;        // when the view was taken
} viewer;

// What the mask holds. 0: not the object.
enum { BY_PROFILE = 1, BY_DISK, BY_WALK, BY_LAMBERT, MODELS };
static const char *const model_name[MODELS] = {"", "profile", "one disk", "volume", "Lambert"};
static const unsigned model_colour[MODELS] = {0u, 0x4c9be8ffu, 0x7fd1aeffu, 0xf2a33affu,
                                              0xd8d8d8ffu};

// ---- The file

static int ends_with(const char *text, const char *end) {
    size_t length = strlen(text), n = strlen(end);
    if (length < n) return 0;
    for (size_t i = 0; i < n; i++) {
        char c = text[length - n + i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != end[i]) return 0;
    }
    return 1;
}

static void load_object(viewer *v) {
    mesh_file file;
    triangle_mesh *m = &v->world.m;
    mesh_file_read(&file, v->file, v->up ? strcmp(v->up, "z") == 0 : ends_with(v->file, ".stl"));
    if (file.reason[0]) fail(2, "cannot read %s: %s", v->file, file.reason);
    const char *wrong =
        mesh_make(m, file.xyz, (size_t)file.vertices, file.corner, (size_t)file.triangles);
    mesh_file_free(&file);
    if (wrong) fail(2, "cannot use %s: it %s", v->file, wrong);
    if (m->left_out > 0)
        fprintf(stderr,
                "mesh: note: left out %u of %u triangles: without area or place, or there twice\n",
                m->left_out, m->left_out + m->triangles);
    wrong = mesh_open(&v->world);
    if (wrong) fail(1, "%s", wrong);
}

// ---- Medium, light and camera, all relative to the object

static double largest(const triangle_mesh *m) {
    return fmax(m->size[0], fmax(m->size[1], m->size[2]));
}

// A mean free path in scene units as the library takes it. The object is about 2 large, and its
// coordinates are rounded by 1e-7: probes do not resolve lengths below 1e-5, which pictures of less
// than 100,000 pixels a side show as Lambert. Beyond 1e12 all is black.
static float scene_length(double length) {
    return length < 1e-5 ? 0.0f : (float)fmin(length, 1e12);
}

static sss_result set_medium(viewer *v) {
    const triangle_mesh *m = &v->world.m;
    sss_medium *medium = &v->view.medium;
    float a[3], b[3];
    if (v->preset >= 0) { // from 1/mm to 1/scene unit
        float unit = (float)(v->millimetres / (largest(m) * m->unit));
        for (int c = 0; c < 3; c++) {
            a[c] = preset[v->preset].sigma_a[c] * unit;
            b[c] = preset[v->preset].sigma_s[c] * unit;
        }
        return sss_dipole(medium, a, b, preset[v->preset].eta);
    }
    for (int c = 0; c < 3; c++) b[c] = scene_length((double)v->dmfp[c] * m->unit);
    return sss_burley(medium, v->albedo, b);
}

// The lamp stands behind the object and to the left, wherever that is seen from, so that thin parts
// glow; the sky lights the front.
static void set_light(mesh_world *world, const view *seen) {
    scene *s = &world->s;
    float r = (float)MESH_RADIUS, middle = (float)(0.5 * world->m.size[1] * world->m.unit);
    float turn = (seen->turn - LAMP) * (SCENE_PI / 180.0f);
    s->floor_lit = 0.6f;
    s->sky_horizon = scene_vec(0.36f, 0.40f, 0.46f);
    s->sky_zenith = scene_vec(0.30f, 0.36f, 0.46f);
    s->floor_albedo = scene_vec(0.27f, 0.24f, 0.215f);
    scenes_light(s, scene_vec(2.6f * r * sinf(turn), middle + 2.2f * r, 2.6f * r * cosf(turn)),
                 scene_vec(0.0f, middle, 0.0f), 0.5f * r, scene_vec(64.0f, 58.0f, 49.0f));
}

// Which way the eye is from the object.
static sss_vec3 view_direction(const view *seen) {
    float turn = seen->turn * (SCENE_PI / 180.0f), tilt = seen->tilt * (SCENE_PI / 180.0f);
    return scene_vec(sinf(turn) * cosf(tilt), sinf(tilt), cosf(turn) * cosf(tilt));
}

// As near as the vertices allow, in a picture of this shape. A vertex v from the target is on the
// edge of the view if |v.right| is tan(half the view) times the distance less v.back.
static void set_camera(mesh_world *world, const view *seen, int width, int height) {
    const triangle_mesh *m = &world->m;
    scene *s = &world->s;
    sss_vec3 back = view_direction(seen);
    sss_vec3 target = scene_vec(0.0f, (float)(0.5 * m->size[1] * m->unit), 0.0f);
    float side = (float)(width < height ? width : height), distance = 0.0f;
    scenes_camera(s, scene_add(target, back), target, FIELD);
    float reach = scene_sqrt(scene_dot(s->up, s->up)),
          across = FILLED * reach * (float)width / side;
    sss_vec3 right = scene_scale(s->right, 1.0f / reach), up = scene_scale(s->up, 1.0f / reach);
    float down = FILLED * reach * (float)height / side;
    for (uint32_t i = 0; i < m->vertices; i++) {
        sss_vec3 p = scene_sub(m->position[i], target);
        float far =
            scene_max(scene_abs(scene_dot(p, right)) / across, scene_abs(scene_dot(p, up)) / down);
        distance = scene_max(distance, far + scene_dot(p, back));
    }
    scenes_camera(s, scene_along(target, back, distance * seen->zoom), target, FIELD);
}

// ---- The window's side of what it has in common with the painter

static void want(viewer *v) {
    pthread_mutex_lock(&v->lock);
    v->wanted = v->view;
    v->is_wanted = 1;
    pthread_mutex_unlock(&v->lock);
}

static void want_medium(viewer *v) {
    sss_result wrong = set_medium(v);
    if (wrong != SSS_OK) fail(2, "this medium cannot be: %s", sss_result_string(wrong));
    want(v);
}

static void upload_cards(viewer *v, canvas *c) {
    pthread_mutex_lock(&v->lock);
    for (int i = 0; i < RUNS; i++) {
        card *k = &v->shown[i];
        int preview = k->picture.width < v->run[i].half[0].width;
        if (!k->fresh) continue;
        canvas_upload(c, &v->texture[i], k->picture.width, k->picture.height, 3, k->picture.rgb,
                      !preview);
        k->fresh = 0;
    }
    pthread_mutex_unlock(&v->lock);
}

// ---- Rendering in slices

// Shows what there is of a run; its picture only if it is fresh.
static void publish(viewer *v, int which) {
    card *mine = &v->run[which].card, *shown = &v->shown[which];
    pthread_mutex_lock(&v->lock);
    image_bytes before = shown->picture;
    int fresh = shown->fresh;
    *shown = *mine;
    if (mine->fresh) mine->picture = before;
    else shown->picture = before, shown->fresh = fresh;
    mine->fresh = 0;
    pthread_mutex_unlock(&v->lock);
}

static void restart_run(run *r) {
    for (int h = 0; h < 2; h++) {
        memset(r->half[h].rgb, 0, image_count(r->half[h].width, r->half[h].height) * sizeof(float));
        r->spp[h] = 0;
    }
    memset(r->preview.rgb, 0, image_count(r->preview.width, r->preview.height) * sizeof(float));
    r->unit = r->previewed = 0;
    r->card.probes = r->card.shaded = 0;
    r->card.passes = r->card.seconds = 0.0;
    r->card.noise = -1.0;
}

// Tiles as the plan advises them.
static void set_sharing(const viewer *v, tracer_settings *settings, int shares) {
    const scene *s = &v->world.s;
    sss_vec3 middle = scene_vec(0.0f, (float)(0.5 * v->world.m.size[1] * v->world.m.unit), 0.0f);
    float footprint = tracer_footprint(s, *settings, middle);
    sss_plan advice = tracer_sharing(&s->medium, footprint, settings->light_aware);
    settings->plan.tile = shares ? advice.tile : 0;
    settings->plan.per_channel = shares && advice.per_channel;
}

// Takes the view that is wanted; returns whether there is a new one. A preview is not given up for
// it at once, or one who turns the object would see nothing.
static int take_view(viewer *v) {
    int waits = !v->run[RUNS - 1].previewed && now() - v->begun < PATIENT;
    pthread_mutex_lock(&v->lock);
    int is_new = v->is_wanted && !waits;
    view seen = v->wanted;
    if (is_new) v->is_wanted = 0;
    pthread_mutex_unlock(&v->lock);
    if (!is_new) return 0;

    v->begun = now();
    v->masked = 0;
    v->world.s.medium = seen.medium;
    set_camera(&v->world, &seen, v->run[0].settings.width, v->run[0].settings.height);
    set_light(&v->world, &seen);
    for (int i = 0; i < RUNS; i++) {
        run *r = &v->run[i];
        r->settings.method = i == PLAIN ? TRACER_PLAIN : TRACER_RESAMPLED;
        r->settings.light_aware = i == RESAMPLED && seen.light_aware;
        r->settings.plan.candidates = seen.candidates;
        r->settings.tolerance = i == RESAMPLED ? seen.tolerance : 0.0f;
        set_sharing(v, &r->settings, i == RESAMPLED && seen.shares);
        restart_run(r);
    }
    v->colours = seen.models && seen.tolerance > 0.0f;
    return 1;
}

// The model of the lookup at hits->hit[0].
static unsigned char model_at(const viewer *v, mesh_hits *hits) {
    if (!v->colours) return BY_PROFILE;
    sss_plan plan = mesh_plan(&v->world, v->run[RESAMPLED].settings, hits);
    switch (plan.techniques) {
    case SSS_DISK: return BY_DISK;
    case SSS_WALK: return BY_WALK;
    case SSS_LAMBERT: return BY_LAMBERT;
    default: return BY_PROFILE;
    }
}

// The next rows of the mask.
static void find_object(viewer *v) {
    int width = v->run[0].settings.width, height = v->run[0].settings.height;
    int end = v->masked + ROWS < height ? v->masked + ROWS : height;
#pragma omp parallel
    {
        mesh_hits hits = {0, 0, NULL};
#pragma omp for schedule(dynamic, 64)
        for (int i = v->masked * width; i < end * width; i++) {
            float x = (float)(i % width) + 0.5f;
            float y = (float)(i / width) + 0.5f;
            sss_vec3 d = tracer_camera(&v->world.s, width, height, x, y);
            mesh_hit hit = mesh_nearest(&v->world, v->world.s.eye, d, NULL);
            v->mask[i] = 0;
            if (hit.geometry != MESH_OBJECT) continue;
            hits.count = 0;
            *mesh_hits_next(&hits) = hit;
            v->mask[i] = model_at(v, &hits);
        }
        free(hits.hit);
    }
    v->masked = end;
}

// The object in the colours of its models, as light as it is.
static void colour_models(const viewer *v, image_bytes *picture) {
    for (int i = 0; i < picture->width * picture->height; i++) {
        unsigned char *rgb = picture->rgb + 3 * (size_t)i;
        unsigned light = (rgb[0] + 2u * rgb[1] + rgb[2] + 3u * 128u) / 7u;
        for (int c = 0; c < 3 && v->mask[i]; c++) {
            unsigned colour = model_colour[v->mask[i]] >> (24 - 8 * c) & 255u;
            rgb[c] = (unsigned char)(colour * light / 255u);
        }
    }
}

// The picture so far, of both halves, as the screen shows it; and its noise: the relative variance
// that one half's difference from the other tells of. Of n1 and n2 samples a pixel, the mean square
// of the difference is V/n1 + V/n2, V a sample's variance, and that of the picture V/(n1 + n2).
static void show(viewer *v, run *r) {
    float n1 = (float)r->spp[0], n2 = (float)r->spp[1];
    double squares = 0.0, power = 0.0;
    if (!r->spp[0]) return;
    r->card.picture.width = r->half[0].width;
    r->card.picture.height = r->half[0].height;
    r->card.fresh = 1;
    for (size_t i = 0; i < image_count(r->half[0].width, r->half[0].height); i++) {
        float a = r->half[0].rgb[i], b = r->half[1].rgb[i];
        r->card.picture.rgb[i] = image_tone((a + b) / (n1 + n2), 1.0f);
        if (!v->mask[i / 3] || !r->spp[1]) continue;
        double difference = (double)(a / n1) - (double)(b / n2);
        squares += difference * difference;
        power += (double)(a / n1) * (double)(b / n2);
    }
    if (v->colours && r == &v->run[RESAMPLED]) colour_models(v, &r->card.picture);
    if (!r->spp[1]) return;
    r->card.noise =
        power > 0.0 ? squares / power * (double)(n1 * n2 / ((n1 + n2) * (n1 + n2))) : 0.0;
}

// What a pass is done in: pixels or, where exits are shared, tiles.
static int units_of(const tracer_settings *settings, uint32_t sample) {
    if (tracer_tile_side(*settings) == 1) return settings->width * settings->height;
    return tracer_tile_count(*settings, sample, 0) * tracer_tile_count(*settings, sample, 1);
}

static void add_radiance(image *into, int x, int y, sss_vec3 radiance) {
    float *rgb = into->rgb + image_count(into->width, y) + 3 * x;
    rgb[0] += radiance.x;
    rgb[1] += radiance.y;
    rgb[2] += radiance.z;
}

static tracer_result render_unit(const viewer *v, image *into, const tracer_settings *settings,
                                 uint32_t sample, int unit, mesh_hits *hits) {
    sss_vec3 radiance[TRACER_TILE_PIXELS];
    tracer_result all;
    if (tracer_tile_side(*settings) == 1) {
        int x = unit % into->width, y = unit / into->width;
        all = mesh_sample(&v->world, *settings, x, y, sample, hits);
        add_radiance(into, x, y, all.radiance);
        return all;
    }
    int columns = tracer_tile_count(*settings, sample, 0);
    int column = unit % columns, row = unit / columns;
    all = mesh_tile_sample(&v->world, *settings, column, row, sample, hits, radiance);
    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        int x, y;
        if (!tracer_tile_pixel(*settings, sample, column, row, i, &x, &y)) continue;
        add_radiance(into, x, y, radiance[i]);
    }
    return all;
}

// The next units of an image, one sample a pixel more, until `end`: whoever is free takes a batch.
// A single pixel can take 50 ms where the mesh is tangled and the candidates are many.
static void render_units(viewer *v, run *r, image *into, const tracer_settings *settings,
                         uint32_t sample, double end) {
    unsigned long long probes = 0, shaded = 0;
    int count = units_of(settings, sample), next = r->unit;
    int batch = tracer_tile_side(*settings) == 1 ? BATCH : 1;
#pragma omp parallel reduction(+ : probes, shaded)
    {
        mesh_hits hits = {0, 0, NULL};
        while (now() < end) {
            int first;
#pragma omp atomic capture
            {
                first = next;
                next += batch;
            }
            for (int i = first; i < first + batch && i < count; i++) {
                tracer_result one = render_unit(v, into, settings, sample, i, &hits);
                probes += one.probes;
                shaded += one.shaded;
            }
            if (first >= count) break;
        }
        free(hits.hit);
    }
    r->unit = next < count ? next : count;
    r->card.probes += probes;
    r->card.shaded += shaded;
}

// A part of one quick pass in large pixels, so that a turned object is there at once.
static void render_preview(viewer *v, int which) {
    run *r = &v->run[which];
    tracer_settings settings = r->settings;
    settings.width = r->preview.width;
    settings.height = r->preview.height;
    int count = units_of(&settings, 0);
    if (settings.plan.candidates > QUICK) settings.plan.candidates = QUICK;
    render_units(v, r, &r->preview, &settings, 0, now() + SLICE);
    r->card.probes = r->card.shaded = 0; // not part of the picture

    r->previewed = r->unit == count;
    if (!r->previewed && now() - v->begun < PATIENT) return;
    if (r->previewed) r->unit = 0;
    r->card.picture.width = r->preview.width;
    r->card.picture.height = r->preview.height;
    r->card.fresh = 1;
    image_blit(&r->card.picture, &r->preview, 1.0f, 0, 0);
    publish(v, which);
    if (r->previewed) glfwPostEmptyEvent(); // the window need not wait any longer
}

// A part of a pass. The halves take turns.
static void render_slice(viewer *v, int which, double slice) {
    run *r = &v->run[which];
    double start = now();
    int h = r->spp[0] > r->spp[1];
    tracer_settings settings = r->settings;
    settings.seed = sss_hash(v->w.seed, (uint32_t)(2 * settings.method + h));
    int count = units_of(&settings, r->spp[h]);
    render_units(v, r, &r->half[h], &settings, r->spp[h], start + slice);
    if (r->unit == count) {
        r->unit = 0;
        r->spp[h]++;
    }
    r->card.seconds += now() - start;
    r->card.passes = (double)(r->spp[0] + r->spp[1]) + (double)r->unit / count;
    if (!v->w.headless && r->unit == 0) show(v, r);
    publish(v, which);
}

// Whose turn it is; RUNS when all is done. Plain goes on until it has shaded as many points as
// resampled.
static int next_run(const viewer *v) {
    const run *plain = &v->run[PLAIN], *resampled = &v->run[RESAMPLED];
    uint32_t done = resampled->spp[0] + resampled->spp[1], passes = plain->spp[0] + plain->spp[1];
    double shaded = (double)plain->card.shaded * (1.0 + 0.5 / (passes ? passes : 1));
    int behind = shaded < (double)resampled->card.shaded;
    if (plain->unit > 0) return PLAIN;
    if (resampled->unit > 0) return RESAMPLED;
    if (behind || (done > 0 && passes < 2)) return PLAIN;
    return v->w.headless && done >= v->spp ? RUNS : RESAMPLED;
}

// The painter. What it does comes after the window: the priority is this thread's on Linux, and
// that of the threads which it starts.
static void *paint(void *argument) {
    viewer *v = (viewer *)argument;
    int stops = 0;
    setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + 5);
    while (!stops) {
        take_view(v);
        if (!v->run[PLAIN].previewed) render_preview(v, PLAIN);
        else if (!v->run[RESAMPLED].previewed) render_preview(v, RESAMPLED);
        else if (v->masked < v->run[0].settings.height) find_object(v);
        else render_slice(v, next_run(v), SLICE);
        pthread_mutex_lock(&v->lock);
        stops = v->stops;
        pthread_mutex_unlock(&v->lock);
    }
    return NULL;
}

// ---- Drawing

// Where the picture of a run is.
static box view_box(const canvas *c, int which) {
    float width = 0.5f * (c->width - 2.0f * MARGIN - 16.0f), height = c->height - TOP - FOOTER;
    box b = {which == PLAIN ? MARGIN : MARGIN + width + 16.0f, TOP, width, height};
    return b;
}

static box picture_box(const canvas *c, const run *r, int which) {
    return pair_box(c, which, r->settings.width, r->settings.height);
}

static void medium_text(const viewer *v, char *text, size_t room) {
    const triangle_mesh *m = &v->world.m;
    const sss_medium *medium = &v->view.medium;
    if (v->preset < 0) {
        snprintf(text, room, "albedo %.2f %.2f %.2f, diffuse mean free path %.3g %.3g %.3g units",
                 (double)v->albedo[0], (double)v->albedo[1], (double)v->albedo[2],
                 (double)v->dmfp[0], (double)v->dmfp[1], (double)v->dmfp[2]);
        return;
    }
    double unit = v->millimetres / (largest(m) * m->unit), dmfp[3];
    for (int c = 0; c < 3; c++) dmfp[c] = unit / (double)medium->sigma[c];
    snprintf(text, room, "%s (%s), %.4g mm large, diffuse mean free path %.3g %.3g %.3g mm",
             preset[v->preset].name, preset[v->preset].by_eye ? "by eye" : "Jensen et al. 2001",
             v->millimetres, dmfp[0], dmfp[1], dmfp[2]);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static const char *right_name(const viewer *v) {
    if (!v->view.shares) return pair_resampled_name(v->view.light_aware);
    return v->view.light_aware ? "shared, light hint" : "shared";
}

static void run_text(viewer *v, int which, char *first, char *second, size_t room) {
    const char *name = which == PLAIN ? "plain" : right_name(v);
    pthread_mutex_lock(&v->lock);
    const card *k = &v->shown[which];
    double plain = v->shown[PLAIN].noise;
    snprintf(first, room, "%s", name);
    if (k->noise >= 0.0) snprintf(first, room, "%s: noise %.4f", name, k->noise);
    if (which == RESAMPLED && plain > 0.0 && k->noise > 0.0)
        snprintf(first, room, "%s: noise %.4f, %.2f of plain's", name, k->noise, k->noise / plain);
    snprintf(second, room,
             "%.1f samples a pixel in %.1f s, %.2f million probes, %.2f million points shaded",
             k->passes, k->seconds, 1e-6 * (double)k->probes, 1e-6 * (double)k->shaded);
    pthread_mutex_unlock(&v->lock);
}

static void draw_run(viewer *v, canvas *c, int which) {
    char first[200], second[200];
    const box b = picture_box(c, &v->run[which], which);
    const float at[4] = {b.x, b.y, b.width, b.height}, all[4] = {0.0f, 0.0f, 1.0f, 1.0f};
    unsigned colour = which == PLAIN ? TEXT : CHOSEN;
    if (v->texture[which]) canvas_image(c, v->texture[which], at, all, 0xffffffffu);
    run_text(v, which, first, second, sizeof first);
    pair_label(c, b.x, b.y, CANVAS_LEFT, colour, which == PLAIN ? "plain" : right_name(v));
    canvas_text(c, b.x, b.y + b.height + 26.0f, 19.0f, CANVAS_LEFT, colour, first);
    canvas_text(c, b.x, b.y + b.height + 47.0f, 14.0f, CANVAS_LEFT, QUIET, second);
    canvas_look(c);
}

// Which colour is which model, to the right of the title.
static void draw_models(const viewer *v, canvas *c, float right) {
    char text[64];
    if (!v->view.models || !(v->view.tolerance > 0.0f)) return;
    for (int i = MODELS - 1; i > 0; i--) {
        canvas_text(c, right, 66.0f, 16.0f, CANVAS_RIGHT, TEXT, model_name[i]);
        right -= canvas_text_width(c, 16.0f, model_name[i]) + 22.0f;
        canvas_rectangle(c, right, 53.0f, 14.0f, 14.0f, model_colour[i]);
        right -= 14.0f;
    }
    snprintf(text, sizeof text, "for an error of %g %%:", 100.0 * (double)v->view.tolerance);
    canvas_text(c, right, 66.0f, 16.0f, CANVAS_RIGHT, QUIET, text);
}

static void draw_keys(viewer *v, canvas *c, float y) {
    char text[64];
    snprintf(text, sizeof text, "medium: %s", v->preset < 0 ? "own" : preset[v->preset].name);
    float x = canvas_key(c, MARGIN, y, 'M', text);
    x = canvas_key(c, canvas_key(c, x, y, '[', ""), y, ']', v->preset < 0 ? "dmfp" : "size");
    x = canvas_key(c, x, y, '-', "");
    snprintf(text, sizeof text, "candidates: %d", v->w.candidates);
    x = canvas_key(c, x, y, '+', text);
    x = canvas_key(c, x, y, 'L', v->view.light_aware ? "no light hint" : "light hint");
    x = canvas_key(c, x, y, 'H', v->view.shares ? "share nothing" : "share exits");
    snprintf(text, sizeof text, "error: %g %%", 100.0 * (double)v->view.tolerance);
    x = canvas_key(c, x, y, 'T', v->view.tolerance > 0.0f ? text : "profile");
    if (v->view.tolerance > 0.0f) x = canvas_key(c, x, y, 'C', "models");
    x = window_last_keys(&v->w, x, y);
    canvas_text(c, x, y, 13.0f, CANVAS_LEFT, TEXT,
                v->w.note[0] ? v->w.note : "drag to turn, wheel to zoom");
}

static void draw(viewer *v, canvas *c) {
    char text[300], medium[200];
    const triangle_mesh *m = &v->world.m;
    canvas_begin(c, PAGE);
    canvas_look(c);
    const box b = picture_box(c, &v->run[PLAIN], PLAIN);
    snprintf(text, sizeof text, "%.60s: %u triangles, %.4g \xc3\x97 %.4g \xc3\x97 %.4g units",
             base_name(v->file), m->triangles, m->size[0], m->size[1], m->size[2]);
    canvas_text(c, b.x, 38.0f, 28.0f, CANVAS_LEFT, TEXT, text);
    medium_text(v, medium, sizeof medium);
    canvas_text(c, b.x, 66.0f, 16.0f, CANVAS_LEFT, QUIET, medium);
    canvas_look(c);
    draw_run(v, c, PLAIN);
    draw_run(v, c, RESAMPLED);
    const box e = picture_box(c, &v->run[RESAMPLED], RESAMPLED);
    draw_models(v, c, e.x + e.width);
    snprintf(text, sizeof text,
             "Plain shades what one probe finds, resampled the one it picks from %d. Noise: the "
             "variance over the "
             "object's pixels, relative to their mean square,",
             v->w.candidates);
    float y = b.y + b.height + 70.0f;
    if (v->w.headless) {
        canvas_text(c, b.x, y, 13.0f, CANVAS_LEFT, QUIET, text);
        canvas_text(c, b.x, y + 18.0f, 13.0f, CANVAS_LEFT, QUIET,
                    "measured by two halves of each picture with independent noise, without a "
                    "reference; both pictures "
                    "have shaded the same number of points.");
    } else {
        draw_keys(v, c, c->height - 14.0f);
        canvas_look(c);
    }
}

// ---- The window

// Within the ranges of the options.
static void change_scale(viewer *v, double factor) {
    double millimetres = v->millimetres * factor;
    int own = v->preset < 0;
    int good = own || (millimetres >= LEAST_SIZE && millimetres <= MOST_SIZE);
    for (int c = 0; c < 3 && own; c++) {
        double dmfp = (double)v->dmfp[c] * factor;
        good &= dmfp == 0.0 || (dmfp >= LEAST_DMFP && dmfp <= MOST_DMFP);
    }
    if (!good) return;
    if (!own) v->millimetres = millimetres;
    for (int c = 0; c < 3 && own; c++) v->dmfp[c] = (float)((double)v->dmfp[c] * factor);
    want_medium(v);
}

// From the profile everywhere to ever stricter choices of the model.
static float next_tolerance(float tolerance) {
    static const float steps[] = {0.5f, 0.2f, 0.1f, 0.05f, 0.02f};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
        if (!(tolerance > 0.0f) || steps[i] < tolerance) return steps[i];
    return 0.0f;
}

// Returns 0 for the key that ends the program.
static int press_key(viewer *v, int code) {
    if (code == 'S' || code == 'F') return 1; // the other windows' scene and profile
    window_change change = window_key(&v->w, code);
    v->view.candidates = v->w.candidates;
    if (code == 'L') v->view.light_aware = !v->view.light_aware;
    if (code == 'H') v->view.shares = !v->view.shares;
    if (code == 'T') v->view.tolerance = next_tolerance(v->view.tolerance);
    if (code == 'C') v->view.models = !v->view.models;
    if (strchr("LHTC", code) || change == WINDOW_CANDIDATES) want(v);
    if (code == 'M') v->preset = v->preset + 1 < PRESET_COUNT ? v->preset + 1 : -1, want_medium(v);
    if (code == '[') change_scale(v, 0.8);
    if (code == ']') change_scale(v, 1.25);
    return change != WINDOW_QUIT;
}

static void turn_view(viewer *v, const canvas_event *event) {
    v->view.turn -= 0.5f * (event->x - v->mouse_x);
    v->view.tilt = scene_max(2.0f, scene_min(88.0f, v->view.tilt + 0.4f * (event->y - v->mouse_y)));
    v->mouse_x = event->x;
    v->mouse_y = event->y;
    want(v);
}

static int handle(viewer *v, canvas *c) {
    canvas_event event;
    // What follows W belongs into the next frame.
    while (!v->w.save && canvas_next_event(c, &event)) {
        if (event.kind == CANVAS_KEY && !press_key(v, event.code)) return 0;
        if (event.kind == CANVAS_RELEASE) v->dragging = 0;
        if (event.kind == CANVAS_PRESS) {
            v->dragging = event.y > TOP && event.y < c->height - FOOTER;
            v->mouse_x = event.x;
            v->mouse_y = event.y;
        }
        if (event.kind == CANVAS_MOVE && v->dragging) turn_view(v, &event);
        if (event.kind == CANVAS_WHEEL) {
            v->view.zoom = scene_max(0.2f, scene_min(4.0f, v->view.zoom * powf(0.9f, event.wheel)));
            want(v);
        }
    }
    return !canvas_closing(c);
}

static void run_window(viewer *v, canvas *c) {
    int code = pthread_create(&v->painter, NULL, paint, v);
    if (code) fail(1, "cannot start a thread: %s", strerror(code));
    while (handle(v, c)) {
        upload_cards(v, c);
        draw(v, c);
        window_show(&v->w);
        canvas_poll(c, REFRESH);
    }
    glfwHideWindow(c->window); // the painter may still have a pixel to end
    pthread_mutex_lock(&v->lock);
    v->stops = 1;
    pthread_mutex_unlock(&v->lock);
    pthread_join(v->painter, NULL);
}

// ---- Without a window

// Returns the exit code, unless the picture cannot be written.
static int render_headless(viewer *v, canvas *c) {
    char first[200], second[200];
    progress p;
    int next;
    progress_begin(&p, base_name(v->file), v->spp);
    interrupt_await();
    take_view(v);
    while (v->masked < v->run[0].settings.height) find_object(v);
    while ((next = next_run(v)) < RUNS && !interrupted()) {
        render_slice(v, next, HUGE_VAL);
        progress_show(&p, v->run[RESAMPLED].spp[0] + v->run[RESAMPLED].spp[1]);
    }
    progress_end(&p);
    if (next < RUNS) {
        fprintf(stderr, "mesh: stopped after %.0f of %u samples a pixel\n",
                v->run[RESAMPLED].card.passes, v->spp);
    }
    for (int i = 0; i < RUNS; i++) {
        show(v, &v->run[i]);
        publish(v, i);
    }
    for (int i = 0; i < RUNS; i++) {
        run_text(v, i, first, second, sizeof first);
        printf("%s; %s\n", first, second);
    }
    upload_cards(v, c);
    draw(v, c);
    window_save(&v->w);
    return next < RUNS ? 130 : 0;
}

// ---- Command line

static void parse_colours(const char *option, const char *text, double least, double most,
                          float out[3]) {
    char *end;
    const char *at = text;
    for (int c = 0; c < 3; c++, at = end + 1) {
        double value = strtod(at, &end);
        if (end == at || *end != (c < 2 ? ',' : '\0') || !(value >= least && value <= most))
            fail(2, "%s wants R,G,B, each from %g to %g, not '%s'", option, least, most, text);
        out[c] = (float)value;
    }
}

// How many words the option takes.
static int parse_option(viewer *v, const char *name, const char *value) {
    if (strncmp(name, "--", 2) != 0) {
        if (v->file) fail(2, "one file at a time: after %s comes %s", v->file, name);
        v->file = name;
        return 1;
    }
    if (strcmp(name, "--light-aware") == 0) return v->view.light_aware = 1;
    if (strcmp(name, "--share") == 0) return v->view.shares = 1;
    if (strcmp(name, "--models") == 0) return v->view.models = 1;
    if (strcmp(name, "--scene") != 0 && strcmp(name, "--profile") != 0) {
        int taken = window_option(&v->w, usage, name, value);
        if (taken) return taken;
    }
    if (is_option("--preset", name, value)) {
        parse_word(name, value, PRESETS);
        for (v->preset = 0; strcmp(preset[v->preset].name, value) != 0;) v->preset++;
    } else if (is_option("--scale", name, value)) {
        v->millimetres = parse_real(name, value, LEAST_SIZE, MOST_SIZE);
        v->has_scale = 1;
    } else if (is_option("--dmfp", name, value)) {
        parse_colours(name, value, 0.0, MOST_DMFP, v->dmfp);
        v->has_dmfp = 1;
    } else if (is_option("--albedo", name, value)) {
        parse_colours(name, value, 0.0, 1.0, v->albedo);
        v->has_albedo = 1;
    } else if (is_option("--tolerance", name, value)) {
        v->view.tolerance = (float)parse_real(name, value, 1e-3, 10.0);
    } else if (is_option("--up", name, value)) {
        v->up = parse_word(name, value, "y z");
    } else if (is_option("--turn", name, value)) {
        v->view.turn += (float)parse_real(name, value, -360.0, 360.0);
    } else if (is_option("--spp", name, value)) {
        v->spp = (uint32_t)parse_number(name, value, 2, 1000000);
    } else {
        fail(2, "unknown option '%s'; --help lists what there is", name);
    }
    return 2;
}

static void parse(viewer *v, int count, char **words) {
    static const float albedo[3] = {0.93f, 0.42f, 0.14f};
    window_defaults(&v->w);
    memcpy(v->albedo, albedo, sizeof albedo);
    v->preset = -1;
    v->millimetres = 50.0;
    v->view.turn = 30.0f;
    v->view.tilt = 17.0f;
    v->view.zoom = 1.0f;
    v->spp = 32;
    for (int i = 1; i < count;) i += parse_option(v, words[i], i + 1 < count ? words[i + 1] : NULL);
    if (!v->file) fail(2, "which file? --help lists what there is");
    if (v->preset >= 0 && (v->has_dmfp || v->has_albedo))
        fail(2, "--preset is in place of --dmfp and --albedo");
    if (v->preset < 0 && v->has_scale)
        fail(2, "--scale goes with --preset; --dmfp is in the file's units");
    if (v->view.models && !(v->view.tolerance > 0.0f)) fail(2, "--models goes with --tolerance");
    v->view.candidates = v->w.candidates;
}

// ---- All of it

// As large as they are in the window or picture that is asked for.
static void make_pictures(viewer *v) {
    float unit = scene_min((float)v->w.width / 1280.0f, (float)v->w.height / 720.0f);
    canvas c;
    c.width = (float)v->w.width / unit;
    c.height = (float)v->w.height / unit;
    const box b = view_box(&c, PLAIN);
    int width = (int)(b.width * unit), height = (int)(b.height * unit), good = 1;
    if (width < 1) width = 1;
    if (height < 1) height = 1;
    for (int i = 0; i < RUNS; i++) {
        run *r = &v->run[i];
        r->settings.width = width;
        r->settings.height = height;
        good &= !image_new(&r->half[0], width, height) && !image_new(&r->half[1], width, height);
        good &=
            !image_new(&r->preview, (width + COARSE - 1) / COARSE, (height + COARSE - 1) / COARSE);
        good &= !image_bytes_new(&r->card.picture, width, height, 0);
        good &= !image_bytes_new(&v->shown[i].picture, width, height, 0);
        v->shown[i].noise = -1.0;
    }
    v->mask = (unsigned char *)malloc((size_t)width * (size_t)height);
    if (!good || !v->mask) fail(1, "out of memory");
}

static void free_pictures(viewer *v) {
    for (int i = 0; i < RUNS; i++) {
        free(v->run[i].half[0].rgb);
        free(v->run[i].half[1].rgb);
        free(v->run[i].preview.rgb);
        free(v->run[i].card.picture.rgb);
        free(v->shown[i].picture.rgb);
    }
    free(v->mask);
}

int main(int count, char **words) {
    static viewer v;
    static const float relative[3] = {0.30f, 0.12f,
                                      0.05f}; // diffuse mean free paths over half the diagonal
    canvas *c = &v.w.c;
    parse(&v, count, words);
    const char *wrong = output_try(v.w.png);
    if (wrong) fail(2, "cannot write %s: %s", v.w.png, wrong);
    load_object(&v);
    const triangle_mesh *m = &v.world.m;
    for (int k = 0; k < 3 && !v.has_dmfp; k++)
        v.dmfp[k] = relative[k] * (float)(MESH_RADIUS / m->unit);
    make_pictures(&v);
    pthread_mutex_init(&v.lock, NULL);
    want_medium(&v);
    char medium[200];
    medium_text(&v, medium, sizeof medium);
    printf("%s: %u triangles, %.6g x %.6g x %.6g units; %s\n", v.file, m->triangles, m->size[0],
           m->size[1], m->size[2], medium);
    wrong = canvas_open(c, "mesh", v.w.headless, v.w.width, v.w.height, 1280.0f, 720.0f);
    int code = 0;
    if (!wrong && v.w.headless) code = render_headless(&v, c);
    if (!wrong && !v.w.headless) run_window(&v, c);
    window_close(&v.w);
    free_pictures(&v);
    mesh_close(&v.world);
    if (wrong) fail(3, "%s", wrong);
    return v.w.failed ? 1 : code;
}
